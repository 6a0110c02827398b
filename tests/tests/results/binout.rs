//! The binout of a run, read back by independent readers (lasso-python with the reader of LSTC,
//! dynars) and compared number by number with the histories: deploy/read_binout.py.

use crumple_tests::program::{Ended, crumple_with, root, run};
use crumple_tests::tools;
use std::process::Command;

/// Has the binout of a run compared; returns the output.
fn compared(ended: &Ended) -> Option<String> {
    let mut reader = Command::new(tools::python("dynars, lasso.dyna, pandas")?);
    reader.arg(root().join("deploy/read_binout.py")).arg(ended.out());
    Some(run(reader).with_code(0).said())
}

/// Runs the tube with a node, a section and more settings, for a few hundred cycles.
fn tube(sets: &[&str]) -> Ended {
    let node = "output.node=[{ nodes = \"head\", name = \"head\" }, { ids = [1, 2, 3] }]";
    let common = ["scene.elements=6", "end_time=0.1", node];
    let args = ["run", "cases/tube", "--quiet", "--workers", "2"];
    let sets = common.iter().chain(sets).flat_map(|set| ["--set", set]);
    run(crumple_with(&args.into_iter().chain(sets).collect::<Vec<_>>())).with_code(0)
}

/// Energies, parts, nodes, sections, a plane and a cylinder, written at the end of the run because
/// the job asks for it.
#[test]
fn histories_read_back() {
    let walls = "wall=[{ name = \"floor\", point = [0, 0, 0], normal = [0, 0, 2] }, \
                 { name = \"roll\", point = [0, 200, 90], axis = [1, 0, 0], radius = 20 }]";
    let section = "output.section=[{ nodes = \"head\", name = \"below the head\", \
                   side = [0, 0, -1] }]";
    let ended = tube(&["output.d3plot=true", "output.field_interval=0.05", walls, section]);
    let Some(said) = compared(&ended) else { return };
    let branches = "glstat, matsum, nodout, rwforc, secforc: ";
    assert!(said.starts_with(branches) && said.contains("all agrees"), "{said}");
}

/// Forces of transducers, and those of pairs of parts: zero at the times without contact.
#[test]
fn contact_forces_read_back() {
    let transducers = "output.transducer=[{ name = \"on one\", parts = [1] }, { name = \"on two\", \
                       parts = [2] }]";
    for more in [&[][..], &["--set", transducers]] {
        let args = ["run", "cases/bars", "--quiet", "--set", "output.field_interval=-1"];
        let ended = run(crumple_with(&[&args[..], more].concat())).with_code(0);
        let dir = ended.out();
        let said = run(crumple_with(&["export-binout", dir.to_str().unwrap()])).with_code(0).said();
        assert!(said.contains("glstat, matsum, rcforc in "), "{said}");
        let Some(said) = compared(&ended) else { return };
        assert!(said.contains("glstat, matsum, rcforc: "), "{said}");
    }
}

/// A folder without a run, and a damaged history, are errors that name the file.
#[test]
fn damage_is_named() {
    let dir = tempfile::tempdir().unwrap();
    let export =
        || run(crumple_with(&["export-binout", dir.path().to_str().unwrap()])).with_code(2).said();
    let history = dir.path().join("history.csv");
    assert!(export().contains("history.csv: there is no history"));
    std::fs::write(&history, "time [ms],cycle\n0,0\n").unwrap();
    assert!(export().contains("history.csv: there is no column `dt`"));
    std::fs::write(&history, "time [ms],cycle\nsoon,0\n").unwrap();
    assert!(export().contains("history.csv: `soon` is not a time"));
    assert!(!dir.path().join("binout0000").exists());
}
