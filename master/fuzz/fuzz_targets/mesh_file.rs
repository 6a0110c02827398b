//! Any bytes as a mesh file: a mesh or problems, never a panic.
#![no_main]

use libfuzzer_sys::fuzz_target;
use std::cell::RefCell;

thread_local! {
    static FOLDER: RefCell<tempfile::TempDir> =
        RefCell::new(tempfile::tempdir().expect("a temporary folder"));
}

fuzz_target!(|bytes: &[u8]| {
    FOLDER.with_borrow(|folder| {
        let path = folder.path().join("mesh");
        std::fs::write(&path, bytes).expect("a file in it");
        if let Ok(read) = crumple::input::mesh_file::read(&path, true, None) {
            let _ = read.mesh.to_mesh();
        }
    });
});
