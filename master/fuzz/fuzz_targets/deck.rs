//! Any bytes as a keyword deck: a model or a report, never a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::cell::RefCell;

thread_local! {
    static FOLDER: RefCell<tempfile::TempDir> =
        RefCell::new(tempfile::tempdir().expect("a temporary folder"));
}

fuzz_target!(|bytes: &[u8]| {
    FOLDER.with_borrow(|folder| {
        let path = folder.path().join("deck.k");
        std::fs::write(&path, bytes).expect("a file in it");
        let allowed = ["mesh.allow_unsupported=true".to_string()];
        if let Ok(model) = crumple::input::job::read(&path, &allowed) {
            let _ = (crumple::input::check::describe(&model), model.records());
        }
    });
});
