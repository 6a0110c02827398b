//! Limits of the disk and of open files, clients that do not read, and many at the same time.

use super::attacks::{multipart, refused};
use crumple_tests::program::crumple;
use crumple_tests::service::{Service, bars, endless};
use rustix::process::{Resource, getrlimit, setrlimit};
use serde_json::json;
use std::fs::{self, File};
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// Size of a file that fits into no buffer of a connection [byte].
const LARGE: u64 = 48 << 20;

#[test]
fn jobs_that_leave_too_little_of_the_disk_are_refused() {
    let mut service = Service::start(&["--disk-limit=1000000000"]);
    let full = service.post("/api/jobs", &bars(&[]));
    refused(&service, "a full disk", &full, &[507]);
    let why = full.json()["error"].as_str().unwrap().to_string();
    assert!(why.contains("1000000000.000 GB") && why.contains("--disk-limit"), "{why}");
    let parts = [("file", Some("job.toml"), &b"x"[..])];
    refused(&service, "a form", &multipart(&service, &parts), &[507]);
    assert_eq!(service.get("/api/jobs").json()["total"], 0);
    assert!(fs::read_dir(service.dir().join("jobs")).unwrap().next().is_none());
    // A request that states more than the disk has is refused before it arrives.
    service.set_options(&["--disk-limit=0", "--max-upload=100000000000"]);
    service.kill();
    service.again();
    let head = format!(
        "POST /api/jobs HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {}\r\nConnection: close\r\n\
         Content-Type: multipart/form-data; boundary=xyz\r\nContent-Length: {}\r\n\r\n",
        service.host, service.token, 90_000_000_000_000_000_u64
    );
    refused(&service, "a job beyond the disk", &service.raw(head.as_bytes()), &[507]);
    let id = service.submit(&bars(&[]));
    service.wait_for(id, "completed");
}

/// Asks for a large file of a job.
fn ask(service: &Service, id: i64) -> TcpStream {
    let mut stream = TcpStream::connect(&service.host).unwrap();
    let request = format!(
        "GET /api/jobs/{id}/files/results/large HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer \
         {}\r\nConnection: close\r\n\r\n",
        service.host, service.token
    );
    stream.write_all(request.as_bytes()).unwrap();
    stream
}

#[test]
fn a_client_that_does_not_read_is_disconnected_and_a_slow_one_is_not() {
    let service = Service::start(&["--stall-limit=5"]);
    let id = service.submit(&bars(&[]));
    service.wait_for(id, "completed");
    let large = File::create(service.folder(id).join("results/large")).unwrap();
    large.set_len(LARGE).unwrap();
    let mut slow = ask(&service, id);
    let mut stalled = ask(&service, id);
    // For longer than the limit, but with pauses that are shorter.
    let mut piece = vec![0; 1 << 20];
    let mut read = slow.read(&mut piece).unwrap() as u64; // the head, and some of the file
    for _ in 0..10 {
        std::thread::sleep(Duration::from_millis(600));
        slow.read_exact(&mut piece).unwrap();
        read += piece.len() as u64;
    }
    read += std::io::copy(&mut slow, &mut std::io::sink()).unwrap();
    assert!(read > LARGE, "the slow client has the whole file: {read}");
    service.wait("the connection is closed", |service| {
        let text = fs::read_to_string(format!("/proc/{}/net/tcp", service.id())).ok()?;
        let port: u16 = service.host.rsplit(':').next()?.parse().ok()?;
        let own = format!("0100007F:{port:04X}");
        // State 01 is an open connection.
        let is_open = |line: &str| {
            let words: Vec<&str> = line.split_whitespace().collect();
            words.len() > 3 && words[1] == own && words[3] == "01"
        };
        (!text.lines().any(is_open)).then_some(())
    });
    let mut rest = 0;
    while let Ok(n @ 1..) = stalled.read(&mut piece) {
        rest += n as u64;
    }
    assert!(rest < LARGE, "the stalled client had {rest} bytes");
    assert_eq!(service.get("/api/jobs").status, 200);
}

#[test]
fn the_service_raises_a_limit_of_open_files_that_is_below_its_connections() {
    let folder = tempfile::tempdir().unwrap();
    let said = File::create(folder.path().join("said")).unwrap();
    let mut command = std::process::Command::new("sh");
    let script = "ulimit -Sn 256; exec \"$0\" serve --listen 127.0.0.1:0 --dir \"$1\"";
    command.args(["-c", script]).arg(crumple()).arg(folder.path().join("service"));
    let mut child = command.stdout(said).spawn().unwrap();
    let limits = (0..1000).find_map(|_| {
        std::thread::sleep(Duration::from_millis(20));
        let said = fs::read_to_string(folder.path().join("said")).unwrap();
        let begun = said.contains("#token=");
        begun.then(|| fs::read_to_string(format!("/proc/{}/limits", child.id())).unwrap())
    });
    child.kill().unwrap();
    child.wait().unwrap();
    let limits = limits.expect("the service starts");
    let line = limits.lines().find(|line| line.starts_with("Max open files")).unwrap();
    let words: Vec<&str> = line.split_whitespace().collect();
    let [soft, hard] = [3, 4].map(|i| words[i].parse().unwrap_or(u64::MAX));
    assert_eq!(soft, hard.min(8192), "{line}");
}

#[test]
fn watchers_beyond_the_limit_are_refused_and_other_requests_are_not() {
    const MOST: usize = 2000;
    let mut files = getrlimit(Resource::Nofile);
    files.current = files.maximum;
    setrlimit(Resource::Nofile, files).unwrap();
    let service = Service::start(&["--rate", "100000"]);
    let id = service.submit(&endless());
    service.wait_for(id, "running");
    let bearer = format!("Bearer {}", service.token);
    let path = format!("/api/jobs/{id}/events");
    let request = service.request("GET", &path, &[("Authorization", &bearer)], b"");
    let watch = || {
        let mut stream = TcpStream::connect(&service.host).unwrap();
        stream.write_all(&request).unwrap();
        let mut code = [0; 12];
        stream.read_exact(&mut code).unwrap();
        (code == *b"HTTP/1.1 200").then_some(stream)
    };
    let mut watchers: Vec<TcpStream> = (0..MOST).map(|_| watch().unwrap()).collect();
    let refusal = service.raw(&request);
    refused(&service, "one watcher more", &refusal, &[503]);
    assert_eq!(refusal.json()["error"], "the service has too many watchers");
    assert_eq!(service.get("/api/jobs").status, 200);
    assert_eq!(service.post(&format!("/api/jobs/{id}/stop"), &json!({})).status, 202);
    service.wait_for(id, "stopped");
    let last = watchers.last_mut().unwrap();
    let mut text = String::new();
    last.set_read_timeout(Some(Duration::from_secs(60))).unwrap();
    let _ = last.read_to_string(&mut text);
    assert!(text.contains("event: end"), "the last watcher sees the end: {text}");
}

#[test]
fn orders_at_the_same_time_take_effect_once() {
    const CLIENTS: usize = 16;
    let service = Service::start(&[]);
    let mut job = bars(&["checkpoint.every=off"]);
    job["check_only"] = json!(true);
    let id = service.submit(&job);
    service.wait_for(id, "checked");
    let order = |name: &str| {
        let path = format!("/api/jobs/{id}/{name}");
        std::thread::scope(|scope| {
            let all: Vec<_> = (0..CLIENTS)
                .map(|_| scope.spawn(|| service.post(&path, &json!({})).status))
                .collect();
            all.into_iter().map(|one| one.join().unwrap()).collect::<Vec<u16>>()
        })
    };
    let codes = order("resume");
    let done = codes.iter().filter(|code| **code == 202).count();
    assert!(done == 1 && codes.iter().all(|code| [202, 409].contains(code)), "{codes:?}");
    assert_eq!(service.wait_for(id, "completed")["attempt"], 1);
    let codes = order("stop");
    assert!(codes.iter().all(|code| *code == 409), "{codes:?}");
    assert_eq!(service.job(id)["state"], "completed");
}
