//! Archives as submissions: good ones by other programs, and hostile ones made by hand. Each of
//! those is refused by a message that names the entry and the rule, and nothing stays on the disk.

use super::attacks::{multipart, refused};
use crumple_tests::program::root;
use crumple_tests::service::Service;
use flate2::write::{DeflateEncoder, GzEncoder};
use flate2::{Compression, Crc};
use std::fs;
use std::io::Write;
use std::process::Command;

/// Type of an entry of tar.
const FILE: u8 = b'0';
/// Mode of a symbolic link and of a pipe in a zip file.
const LINK_MODE: u32 = 0o120_777;
const PIPE_MODE: u32 = 0o010_644;

/// An entry of tar: name, type, target of a link, stated size, content.
pub(super) struct Member<'a>(pub &'a [u8], pub u8, pub &'a [u8], pub u64, pub &'a [u8]);

pub(super) fn file<'a>(name: &'a str, content: &'a [u8]) -> Member<'a> {
    Member(name.as_bytes(), FILE, b"", content.len() as u64, content)
}

/// Returns an archive without its end mark.
fn open_tar(members: &[Member]) -> Vec<u8> {
    let mut all = Vec::new();
    for Member(name, kind, target, size, content) in members {
        let mut head = [0u8; 512];
        head[..name.len()].copy_from_slice(name);
        for (at, text) in [(100, "0000644"), (108, "0000000"), (116, "0000000")] {
            head[at..at + 7].copy_from_slice(text.as_bytes());
        }
        head[124..135].copy_from_slice(format!("{size:011o}").as_bytes());
        head[136..147].copy_from_slice(b"00000000000");
        head[148..156].fill(b' ');
        head[156] = *kind;
        head[157..157 + target.len()].copy_from_slice(target);
        head[257..265].copy_from_slice(b"ustar\x0000");
        let sum: u32 = head.iter().map(|b| u32::from(*b)).sum();
        head[148..155].copy_from_slice(format!("{sum:06o}\0").as_bytes());
        all.extend(head);
        all.extend_from_slice(content);
        all.resize(all.len().next_multiple_of(512), 0);
    }
    all
}

pub(super) fn tar(members: &[Member]) -> Vec<u8> {
    [open_tar(members), vec![0; 1024]].concat()
}

pub(super) fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = GzEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

fn deflate(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = DeflateEncoder::new(Vec::new(), Compression::fast());
    encoder.write_all(bytes).unwrap();
    encoder.finish().unwrap()
}

/// An entry of a zip file.
#[derive(Clone)]
pub(super) struct Entry {
    name: Vec<u8>,
    /// 0 is stored, 8 is deflated.
    method: u16,
    flags: u16,
    mode: u32,
    content: Vec<u8>,
    packed: Vec<u8>,
    /// Stated size.
    size: usize,
}

pub(super) fn entry(name: &str, content: &[u8]) -> Entry {
    let (content, size) = (content.to_vec(), content.len());
    let packed = content.clone();
    Entry { name: name.into(), method: 0, flags: 0, mode: 0o100_644, content, packed, size }
}

pub(super) fn with_mode(name: &str, mode: u32) -> Entry {
    Entry { mode, ..entry(name, b"/etc/passwd") }
}

pub(super) fn deflated(name: &str, content: &[u8], size: usize) -> Entry {
    Entry { method: 8, packed: deflate(content), size, ..entry(name, content) }
}

pub(super) fn zip(entries: &[Entry]) -> Vec<u8> {
    let (mut all, mut directory) = (Vec::new(), Vec::new());
    for entry in entries {
        let mut crc = Crc::new();
        crc.update(&entry.content);
        let offset = all.len() as u32;
        let mut common = Vec::new();
        for value in [20, entry.flags, entry.method, 0, 33] {
            common.extend(value.to_le_bytes());
        }
        for value in [crc.sum(), entry.packed.len() as u32, entry.size as u32] {
            common.extend(value.to_le_bytes());
        }
        common.extend((entry.name.len() as u16).to_le_bytes());
        common.extend([0, 0]);
        all.extend([&b"PK\x03\x04"[..], &common, &entry.name, &entry.packed].concat());
        directory.extend([&b"PK\x01\x02"[..], &[20, 3], &common, &[0; 6]].concat());
        directory.extend((entry.mode << 16).to_le_bytes());
        directory.extend(offset.to_le_bytes());
        directory.extend_from_slice(&entry.name);
    }
    let (start, count) = (all.len() as u32, entries.len() as u16);
    let mut end = b"PK\x05\x06\0\0\0\0".to_vec();
    end.extend([count.to_le_bytes(), count.to_le_bytes()].concat());
    end.extend([(directory.len() as u32).to_le_bytes(), start.to_le_bytes()].concat());
    end.extend([0, 0]);
    [all, directory, end].concat()
}

/// Submits an archive and asserts that it is refused for a reason, that nothing is next to the
/// folder of the service, and that no folder of a job stays.
fn is_refused(service: &Service, name: &str, archive: &[u8], code: u16, reasons: &[&str]) {
    let reply = multipart(service, &[("archive", Some(name), archive)]);
    refused(service, &format!("{name}, {reasons:?}"), &reply, &[code]);
    let why = reply.json()["error"].as_str().unwrap().to_string();
    for reason in reasons {
        assert!(why.contains(reason), "{name}: {why}; not {reason}");
    }
    service.wait("nothing stays", |service| {
        let mut left = fs::read_dir(service.dir().join("jobs")).unwrap();
        left.next().is_none().then_some(())
    });
    assert!(!service.dir().parent().unwrap().join("evil").exists());
}

#[test]
fn hostile_entries_of_tar_are_refused() {
    let service = Service::start(&["--max-upload", "4"]);
    let good = || file("job.toml", b"x");
    let link = |name: &'static str, kind: u8, target: &'static str| {
        Member(name.as_bytes(), kind, target.as_bytes(), 0, b"")
    };
    let deep = "a/".repeat(9) + "x";
    let many: Vec<String> = (0..2001).map(|i| format!("{i}.k")).collect();
    let folders: Vec<String> = (0..4001).map(|i| format!("d{i}/")).collect();
    let sparse = b"22 GNU.sparse.major=1\n32 GNU.sparse.name=evil.keyword\n";
    let named_by_pax = b"19 path=../../evil\n";
    let (mebi, zeros) = (1 << 20, vec![0; 5 << 20]);
    let cases: Vec<(Vec<Member>, u16, &[&str])> = vec![
        (vec![good(), file("../../evil", b"x")], 422, &["`../../evil`", "begin with a point"]),
        (vec![good(), file("a/../../evil", b"x")], 422, &["`a/../../evil`"]),
        (vec![good(), file("/evil", b"x")], 422, &["`/evil`", "empty names"]),
        (vec![good(), file("..\\evil", b"x")], 422, &["`..\\evil`", "backslashes"]),
        (vec![good(), file("C:\\evil", b"x")], 422, &["backslashes"]),
        (vec![good(), file(".ssh/x", b"x")], 422, &["`.ssh/x`"]),
        (vec![good(), file("a\nb", b"x")], 422, &["control characters"]),
        (vec![good(), file(&deep, b"x")], 422, &["more than 8 folders"]),
        (vec![good(), Member(b"\xff.k", FILE, b"", 1, b"x")], 422, &["not UTF-8"]),
        (
            vec![good(), link("s", b'2', "/tmp"), file("s/evil", b"x")],
            422,
            &["`s`", "symbolic link"],
        ),
        (vec![good(), link("h", b'1', "/etc/passwd")], 422, &["`h`", "hard link"]),
        (vec![good(), link("h", b'1', "job.toml")], 422, &["`h`", "hard link"]),
        (vec![good(), link("d", b'3', "")], 422, &["`d`", "device"]),
        (vec![good(), link("d", b'4', "")], 422, &["`d`", "device"]),
        (vec![good(), link("p", b'6', "")], 422, &["`p`", "pipe"]),
        (vec![good(), link("v", b'V', "")], 422, &["`v`", "neither a file nor a folder"]),
        (vec![good(), good()], 422, &["`job.toml`", "given twice"]),
        (vec![good(), file("JOB.toml", b"x")], 422, &["`JOB.toml`", "only by case"]),
        (vec![good(), file("job.toml/x", b"x")], 422, &["`job.toml/x`", "is a file"]),
        (
            vec![good(), Member(b"x", b'x', b"", sparse.len() as u64, sparse), file("e", b"x")],
            422,
            &["`e`", "sparse"],
        ),
        (
            vec![
                good(),
                Member(b"x", b'x', b"", named_by_pax.len() as u64, named_by_pax),
                file("e", b"x"),
            ],
            422,
            &["`../../evil`"],
        ),
        (
            vec![Member(b"x", b'L', b"", mebi, &zeros[..1 << 20]), good()],
            422,
            &["headers", "too long"],
        ),
        (many.iter().map(|name| file(name, b"")).collect(), 413, &["at most 2000 files"]),
        (
            folders.iter().map(|name| Member(name.as_bytes(), b'5', b"", 0, b"")).collect(),
            413,
            &["at most 4000 entries"],
        ),
        // The stated size is beyond the limit, and beyond the archive.
        (vec![Member(b"big", FILE, b"", 8_000_000_000, b"x")], 413, &["`big`", "more than 4 MB"]),
        (vec![Member(b"cut", FILE, b"", 5000, b"x")], 422, &["`cut`", "5000"]),
        (vec![], 422, &["no files"]),
    ];
    for (members, code, reasons) in &cases {
        is_refused(&service, "a.tar", &tar(members), *code, reasons);
        is_refused(&service, "a.tar.gz", &gzip(&tar(members)), *code, reasons);
    }
    // 5 MB of zeros in 25 kB.
    let bomb = gzip(&tar(&[file("job.toml", b"x"), file("bomb", &zeros)]));
    assert!(bomb.len() < 100_000);
    is_refused(&service, "a.tgz", &bomb, 413, &["`bomb`", "more than 4 MB"]);
    let halves = [file("a", &zeros[..3 << 20]), file("b", &zeros[..3 << 20])];
    is_refused(&service, "a.tgz", &gzip(&tar(&halves)), 413, &["`b`", "more than 4 MB"]);
    let padded = [tar(&[good()]), zeros].concat();
    is_refused(&service, "a.tgz", &gzip(&padded), 422, &["padding"]);
    assert_eq!(service.get("/api/jobs").json()["total"], 0);
}

#[test]
fn hostile_entries_of_zip_are_refused() {
    let service = Service::start(&["--max-upload", "4"]);
    let good = || entry("job.toml", b"x");
    let many: Vec<Entry> = (0..2001).map(|i| entry(&format!("{i}.k"), b"")).collect();
    let folders: Vec<Entry> = (0..4001).map(|i| entry(&format!("d{i}/"), b"")).collect();
    let zeros = vec![0; 5 << 20];
    let cases: Vec<(Vec<Entry>, u16, &[&str])> = vec![
        (vec![good(), entry("../../evil", b"x")], 422, &["`../../evil`", "begin with a point"]),
        (vec![good(), entry("/evil", b"x")], 422, &["`/evil`", "empty names"]),
        (vec![good(), entry("..\\evil", b"x")], 422, &["`..\\evil`", "backslashes"]),
        (vec![good(), Entry { name: b"\xe9.k".into(), ..good() }], 422, &["not UTF-8"]),
        (
            vec![good(), with_mode("s", LINK_MODE), entry("s/evil", b"x")],
            422,
            &["`s`", "symbolic link"],
        ),
        (vec![good(), with_mode("p", PIPE_MODE)], 422, &["`p`", "neither a file nor a folder"]),
        (vec![good(), good()], 422, &["same name"]),
        (vec![good(), entry("JOB.TOML", b"x")], 422, &["`JOB.TOML`", "only by case"]),
        (vec![good(), entry("job.toml/x", b"x")], 422, &["`job.toml/x`", "is a file"]),
        (vec![good(), Entry { flags: 1, ..entry("e", &[0; 20]) }], 422, &["`e`", "encrypted"]),
        (vec![good(), Entry { method: 14, ..entry("l", b"x") }], 422, &["`l`"]),
        (vec![good(), deflated("bomb", &zeros, 5 << 20)], 413, &["`bomb`", "more than 4 MB"]),
        // A bomb that states a small size, and one that states a large size.
        (vec![good(), deflated("lie", &zeros, 10)], 422, &["`lie`"]),
        (vec![good(), deflated("lie", b"x", 3000)], 422, &["`lie`"]),
        (vec![good(), deflated("lie", b"x", 0xfff_ffff)], 413, &["`lie`", "more than 4 MB"]),
        (vec![Entry { content: b"y".into(), ..good() }], 422, &["`job.toml`", "checksum"]),
        (many, 413, &["at most 2000 files"]),
        (folders, 413, &["at most 4000 entries"]),
        (vec![], 422, &["no files"]),
    ];
    for (entries, code, reasons) in &cases {
        is_refused(&service, "a.zip", &zip(entries), *code, reasons);
    }
    // The name before the entry is another one than in the directory: readers would disagree.
    let two = zip(&[good(), entry("abcd", b"x")]);
    let at = two.windows(4).position(|four| four == b"abcd").unwrap();
    let mut two_names = two;
    two_names[at..at + 4].copy_from_slice(b"evil");
    is_refused(&service, "a.zip", &two_names, 422, &["cannot be read"]);
    // A directory that is larger than any that is needed.
    let long = "n".repeat(60_000);
    let wide: Vec<Entry> = (0..200).map(|i| entry(&format!("{i}{long}"), b"")).collect();
    let service = Service::start(&["--max-upload", "100"]);
    is_refused(&service, "a.zip", &zip(&wide), 422, &["too long"]);
}

#[test]
fn archives_that_are_cut_off_or_of_another_kind_are_refused() {
    let service = Service::start(&[]);
    let members = [file("job.toml", b"x"), file("a.k", &[7; 2000])];
    let (plain, packed) = (tar(&members), gzip(&tar(&members)));
    let zipped = zip(&[entry("job.toml", b"x"), deflated("a.k", &[7; 2000], 2000)]);
    let cut = |bytes: &[u8], n: usize| bytes[..n].to_vec();
    for (name, bytes) in [
        ("a.tar", cut(&plain, 700)),
        ("a.tar", cut(&plain, 1024)),
        ("a.tar", open_tar(&members)),
        ("a.tar", Vec::new()),
        ("a.tgz", cut(&packed, packed.len() / 2)),
        ("a.tgz", cut(&packed, packed.len() - 4)),
        ("a.tgz", Vec::new()),
        ("a.tgz", plain.clone()),
        ("a.tar", packed.clone()),
        ("a.zip", plain.clone()),
        ("a.zip", Vec::new()),
        ("a.zip", cut(&zipped, zipped.len() - 30)),
        ("a.zip", cut(&zipped, zipped.len() / 2)),
        ("a.tar", vec![b'x'; 5000]),
    ] {
        is_refused(&service, name, &bytes, 422, &["archive"]);
    }
    is_refused(&service, "a.rar", &plain, 422, &[".tar.gz"]);
    is_refused(&service, "", &plain, 422, &[".tar.gz"]);
    let both = [("archive", Some("a.tar"), &plain[..]), ("archive", Some("b.tar"), &plain)];
    refused(&service, "two archives", &multipart(&service, &both), &[422]);
}

#[test]
fn an_archive_and_files_make_one_job_and_an_archive_in_an_archive_is_data() {
    let service = Service::start(&[]);
    let bars = fs::read(root().join("cases/bars/job.toml")).unwrap();
    let inner = zip(&[entry("../../evil", b"x")]);
    let archive = tar(&[
        Member(b"./", b'5', b"", 0, b""),
        file("./job.toml", &bars),
        Member(b"./parts/", b'5', b"", 0, b""),
        file("./parts/inner.zip", &inner),
        Member(b"", b'g', b"", 19, b"19 comment=by hand\n"),
    ]);
    let options = br#"{"check_only": true}"#;
    let parts = [
        ("options", None, &options[..]),
        ("archive", Some("a.tar"), &archive),
        ("file", Some("more.k"), b"*KEYWORD\n*END\n"),
    ];
    let reply = multipart(&service, &parts);
    assert_eq!(reply.status, 201, "{}", reply.text());
    let id = reply.json()["id"].as_i64().unwrap();
    service.wait_for(id, "checked");
    let input = service.folder(id).join("input");
    assert_eq!(fs::read(input.join("parts/inner.zip")).unwrap(), inner);
    assert_eq!(fs::read(input.join("job.toml")).unwrap(), bars);
    assert!(input.join("more.k").exists() && !service.folder(id).join("archive").exists());
    let clash = [("archive", Some("a.tar"), &archive[..]), ("file", Some("job.toml"), b"x")];
    refused(&service, "a file of the archive", &multipart(&service, &clash), &[422]);
}

#[test]
fn archives_of_other_programs_are_submitted_by_the_command() {
    let service = Service::start(&[]);
    let folder = tempfile::tempdir().unwrap();
    let run = |words: &[&str]| {
        let ended = Command::new(words[0]).args(&words[1..]).current_dir(folder.path()).output();
        let ended = ended.unwrap();
        assert!(ended.status.success(), "{ended:?}");
    };
    fs::create_dir_all(folder.path().join("bars/parts")).unwrap();
    fs::copy(root().join("cases/bars/job.toml"), folder.path().join("bars/job.toml")).unwrap();
    fs::write(folder.path().join("bars/parts/other.toml"), "x".repeat(100_000)).unwrap();
    run(&["python3", "-m", "zipfile", "-c", "a.zip", "bars/"]);
    run(&["tar", "-cf", "a.tar", "bars"]);
    run(&["tar", "-czf", "a.tar.gz", "-C", "bars", "."]);
    run(&["tar", "--format=posix", "-czf", "a.tgz", "bars"]);
    for (number, name) in ["a.zip", "a.tar", "a.tar.gz", "a.tgz"].iter().enumerate() {
        let id = number as i64 + 1;
        let path = folder.path().join(name);
        let sent = service.command(&["submit", path.to_str().unwrap(), "--check"]);
        assert_eq!(sent.status.code(), Some(0), "{name}: {sent:?}");
        let job = service.wait_for(id, "checked");
        assert!(job["job"].as_str().unwrap().ends_with("job.toml"), "{job}");
        let files = service.get(&format!("/api/jobs/{id}/files")).json().to_string();
        assert!(files.contains("parts/other.toml"), "{files}");
    }
    let path = folder.path().join("a.zip");
    let words = ["submit", path.to_str().unwrap(), "--main", "bars/parts/other.toml", "--check"];
    assert_eq!(service.command(&words).status.code(), Some(0));
    service.wait_for(5, "refused");
}
