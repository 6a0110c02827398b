//! The Python client against a service.

use crumple_tests::program::root;
use crumple_tests::python_package::PythonPackage;
use crumple_tests::service::Service;
use crumple_tests::tools::python;
use std::process::Command;

#[test]
fn the_python_client_submits_waits_reads_stops_and_resumes() {
    let Some(python) = python("numpy, pandas, pyvista, requests") else { return };
    let service = Service::start(&["--slots=2"]);
    let folder = tempfile::tempdir().unwrap();
    let (archive, job) = (folder.path().join("bars.tar.gz"), root().join("cases/bars/job.toml"));
    let bars = root().join("cases");
    let mut tar = Command::new("tar");
    tar.arg("-czf").arg(&archive).arg("-C").arg(bars).arg("bars");
    assert!(tar.status().unwrap().success());
    let mut command = Command::new(python);
    command.arg(root().join("tests/tests/serve/python_client.py")).arg(service.dir());
    command.args([&job, &archive]).arg(folder.path().join("out"));
    let package = PythonPackage::link();
    package.add_to(&mut command);
    let ended = command.output().unwrap();
    let said = String::from_utf8_lossy(&ended.stderr).into_owned();
    assert!(ended.status.success(), "{said}");
}
