//! The description of the interface, and the page.

use crumple_tests::program::{crumple, root};
use crumple_tests::service::Service;
use crumple_tests::tools;
use std::fs;
use std::process::Command;

#[test]
fn the_description_of_the_interface_is_current() {
    let output = Command::new(crumple()).args(["serve", "--openapi"]).output().unwrap();
    let text = String::from_utf8(output.stdout).unwrap();
    let path = root().join("docs/reference/service-api.json");
    if std::env::var_os("UPDATE_EXPECT").is_some() {
        fs::write(&path, &text).unwrap();
    }
    let committed = fs::read_to_string(&path).unwrap_or_default();
    assert!(
        committed == text,
        "docs/reference/service-api.json is old; write it again with UPDATE_EXPECT=1"
    );
    let value: serde_json::Value = serde_json::from_str(&text).unwrap();
    let paths = value["paths"].as_object().unwrap();
    assert!(paths.len() > 12, "{:?}", paths.keys());
}

#[test]
fn the_page_has_no_script_or_style_in_itself_and_all_its_files() {
    let service = Service::start(&[]);
    let page = service.ask("GET", "/", &[], b"");
    assert_eq!(page.status, 200);
    let policy = page.header("Content-Security-Policy").unwrap();
    assert!(policy.contains("default-src 'none'") && !policy.contains("unsafe"), "{policy}");
    let text = page.text();
    for forbidden in ["<style", " style=", "javascript:", "<script>", " onclick", " onload"] {
        assert!(!text.contains(forbidden), "{forbidden}");
    }
    let mut files = 0;
    for key in ["src=\"", "href=\"/"] {
        for part in text.split(key).skip(1) {
            let path = part.split('"').next().unwrap();
            let path = if path.starts_with('/') { path.to_string() } else { format!("/{path}") };
            assert_eq!(service.ask("GET", &path, &[], b"").status, 200, "{path}");
            files += 1;
        }
    }
    assert!(files >= 10, "{files} files");
    for path in ["/health", "/ready"] {
        assert_eq!(service.ask("GET", path, &[], b"").status, 200);
    }
}

#[test]
fn a_list_of_ten_thousand_jobs_is_answered_a_page_at_a_time() {
    let service = Service::start(&[]);
    let path = service.dir().join("service.db");
    // Written by another program, as a backup would read it.
    let script = "import sqlite3,sys\ndb=sqlite3.connect(sys.argv[1])\n\
                  db.executemany(\"INSERT INTO job \
                  (name,owner,state,priority,workers,launcher,main,sets,retries,submitted) VALUES \
                  (?,'a','completed',0,1,'threads','job.toml','[]',0,1.0)\",[('job %d'%i,) for i \
                  in range(10000)])\ndb.commit()";
    let Some(python) = tools::python("sqlite3") else { return };
    let filled = Command::new(python).args(["-c", script]).arg(path).status().unwrap();
    assert!(filled.success());
    let page = service.get("/api/jobs?limit=50&name=job%2099").json();
    assert_eq!((page["total"].as_i64(), page["jobs"].as_array().unwrap().len()), (Some(111), 50));
    let whole = service.get("/api/jobs?limit=100000").json();
    assert_eq!(
        (whole["total"].as_i64(), whole["jobs"].as_array().unwrap().len()),
        (Some(10_000), 500)
    );
}
