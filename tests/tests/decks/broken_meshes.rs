//! Broken mesh files: each error has a place and a cure, and no bytes cause a panic.

use crumple::input::mesh_file::read;
use crumple_proto::problem::Severity;
use crumple_tests::program::root;
use proptest::prelude::*;
use std::fs;
use std::path::PathBuf;
use std::sync::LazyLock;

/// Files with one small mesh in all formats.
const FILES: [&str; 7] =
    ["plate.msh", "plate22.msh", "plate.inp", "plate.bdf", "plate.vtk", "plate.vtu", "plate.stl"];

fn folder() -> PathBuf {
    root().join("tests/meshes/broken")
}

/// Each file, files in binary form, assemblies of instances, and one of several pieces.
static TEXTS: LazyLock<Vec<(&str, Vec<u8>)>> = LazyLock::new(|| {
    let made = root().join("tests/meshes/made");
    let of = |folder: PathBuf, name: &'static str| (name, fs::read(folder.join(name)).unwrap());
    let mut texts: Vec<_> = FILES.iter().map(|name| of(folder(), name)).collect();
    for name in [
        "block41-binary.msh",
        "block22-binary.msh",
        "block-binary.vtk",
        "block-binary.stl",
        "assembly.inp",
        "joined.inp",
        "pieces.vtu",
    ] {
        texts.push(of(made.clone(), name));
    }
    let zlib = root().join("tests/meshes/third-party/vtkio");
    texts.push(of(zlib, "hexahedron_zlib.vtu"));
    texts
});

/// Each line of `tests/meshes/broken/FILE.toml` is one change of a good file. The first error
/// begins as the table says: with the line, where the format has lines. All errors have a cure.
#[test]
fn every_broken_file_is_reported_with_place_and_cure() {
    let scratch = tempfile::tempdir().unwrap();
    let mut wrong = String::new();
    for name in FILES {
        let text = fs::read_to_string(folder().join(name)).unwrap();
        let table = fs::read_to_string(folder().join(format!("{name}.toml"))).unwrap();
        let table: toml::Table = table.parse().unwrap();
        let cases = table["case"].as_array().unwrap();
        assert!(cases.len() >= 30, "{name}: {} cases", cases.len());
        for case in cases {
            let of = |key: &str| case[key].as_str().unwrap();
            assert!(text.contains(of("replace")), "{name}: {case}");
            let path = scratch.path().join(name);
            fs::write(&path, text.replacen(of("replace"), of("by"), 1)).unwrap();
            let Err(problems) = read(&path, false, None) else {
                wrong += &format!("{name}: no error: {case}\n");
                continue;
            };
            let errors = problems.iter().filter(|p| p.severity == Severity::Error);
            let first = errors.clone().next().map_or("", |p| p.message.as_str());
            let said = first.strip_prefix(path.to_str().unwrap()).unwrap_or(first);
            if !said.starts_with(of("says")) {
                wrong += &format!("{name}: {case}\n  says {said}\n");
            }
            if errors.clone().any(|p| p.help.is_empty()) {
                wrong += &format!("{name}: no cure: {said}\n");
            }
        }
    }
    assert!(wrong.is_empty(), "{wrong}");
}

/// A file that is cut anywhere is read or refused.
#[test]
fn cut_files_do_not_panic() {
    let scratch = tempfile::tempdir().unwrap();
    for (name, bytes) in TEXTS.iter() {
        let path = scratch.path().join(name);
        for length in (0..bytes.len()).step_by(1 + bytes.len() / 400) {
            fs::write(&path, &bytes[..length]).unwrap();
            let _ = read(&path, length % 2 == 0, None);
        }
    }
}

/// Generates a change of a file: bytes that are replaced, removed or repeated.
fn change() -> impl Strategy<Value = (usize, usize, Vec<u8>)> {
    let words = prop::sample::select(vec![
        "-1",
        "0",
        "99999999999",
        "18446744073709551615",
        "1e308",
        "nan",
        "é",
        "\n",
        ",",
        "$",
        "*",
        "=",
        "\"",
        "<",
        ">",
        " ",
        "\0",
        "THRU",
        "generate",
        "8",
        "-9223372036854775808",
    ]);
    let new = prop_oneof![
        3 => words.prop_map(|word| word.as_bytes().to_vec()),
        1 => prop::collection::vec(any::<u8>(), 0..9),
    ];
    (any::<usize>(), 0usize..12, new)
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 3000, ..ProptestConfig::default() })]

    /// Any few changes of a good file give a mesh or errors with cures.
    #[test]
    fn changed_files_do_not_panic(
        index in 0usize..15,
        changes in prop::collection::vec(change(), 1..6),
        allowed in any::<bool>(),
    ) {
        let (name, bytes) = &TEXTS[index];
        let mut bytes = bytes.clone();
        for (at, length, new) in changes {
            let at = at % (bytes.len() + 1);
            let end = (at + length).min(bytes.len());
            bytes.splice(at..end, new);
        }
        let scratch = tempfile::tempdir().unwrap();
        let path = scratch.path().join(name);
        fs::write(&path, &bytes).unwrap();
        match read(&path, allowed, None) {
            Ok(found) => {
                let mesh = found.mesh.to_mesh();
                prop_assert_eq!(mesh.elements.len(), found.mesh.elements.len());
            }
            Err(problems) => prop_assert!(problems.iter().all(|p| !p.help.is_empty())),
        }
    }
}
