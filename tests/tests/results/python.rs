//! The Python package.

use crumple_tests::program::root;
use crumple_tests::python_package::PythonPackage;
use crumple_tests::tools::python;
use std::process::Command;

/// Jobs, runs, results and examples of the package, by its own tests.
#[test]
fn the_python_package_passes_its_tests() {
    let Some(python) = python("mypy, numpy, pandas, pytest, pyvista") else { return };
    let package = PythonPackage::link();
    let mut command = Command::new(python);
    command.args(["-m", "pytest", "-q", "-p", "no:cacheprovider"]);
    command.arg(root().join("master/python/tests"));
    package.add_to(&mut command);
    let ended = command.output().unwrap();
    let said = String::from_utf8_lossy(&ended.stdout).into_owned();
    assert!(ended.status.success(), "{said}{}", String::from_utf8_lossy(&ended.stderr));
}
