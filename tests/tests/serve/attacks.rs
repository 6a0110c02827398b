//! Attacks that take more than one request: each is refused with a plain error, and the service
//! goes on. Those of one request are the table in `hostile.rs`.

use crumple_tests::service::{Reply, Service, bars};
use serde_json::{Value, json};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::Duration;

/// Asserts that a request was refused with one of these codes, in JSON with a reason, and that the
/// answer names no path of the machine.
pub(super) fn refused(service: &Service, what: &str, reply: &Reply, codes: &[u16]) {
    let text = reply.text();
    assert!(codes.contains(&reply.status), "{what}: {} {text}", reply.head);
    let dir = service.dir();
    assert!(!text.contains(dir.to_str().unwrap()), "{what}: {text}");
    let why = reply.json()["error"].as_str().map(String::from).unwrap_or_default();
    assert!(!why.is_empty(), "{what}: {text}");
}

/// Returns a form with the boundary `xyz`.
pub(super) fn form(parts: &[(&str, Option<&str>, &[u8])]) -> Vec<u8> {
    let mut body = Vec::new();
    for (name, file, content) in parts {
        let file = file.map(|file| format!("; filename=\"{file}\"")).unwrap_or_default();
        let head =
            format!("--xyz\r\nContent-Disposition: form-data; name=\"{name}\"{file}\r\n\r\n");
        body.extend([head.as_bytes(), content, b"\r\n"].concat());
    }
    body.extend(b"--xyz--\r\n");
    body
}

pub(super) fn multipart(service: &Service, parts: &[(&str, Option<&str>, &[u8])]) -> Reply {
    let bearer = format!("Bearer {}", service.token);
    let kind = ("Content-Type", "multipart/form-data; boundary=xyz");
    service.ask("POST", "/api/jobs", &[("Authorization", &bearer), kind], &form(parts))
}

#[test]
fn jobs_cannot_name_files_outside_their_folder() {
    let service = Service::start(&[]);
    let secret = service.dir().join("access.json");
    let secret = secret.to_str().unwrap();
    let other = service.submit(&bars(&[]));
    service.wait_for(other, "completed");
    let deck = |include: &str| format!("*KEYWORD\n*INCLUDE\n{include}\n*END\n");
    let deck_in_path = |path: &str, name: &str| {
        format!("*KEYWORD\n*INCLUDE_PATH\n{path}\n*INCLUDE\n{name}\n*END\n")
    };
    let job = |key: &str, value: &str| format!("end_time = 1.0\n[mesh]\n{key} = {value:?}\n");
    let jobs = [
        ("a mesh file", "job.toml", job("file", secret)),
        ("a mesh file above", "job.toml", job("file", "../../../access.json")),
        (
            "a mesh of another job",
            "job.toml",
            job("file", &format!("../../{other}/input/job.toml")),
        ),
        ("a deck", "job.toml", job("deck", "/etc/passwd")),
        ("a deck above", "job.toml", job("deck", "../check.json")),
        ("an EXODUS file", "job.toml", job("exodus", "/etc/hostname")),
        ("an EXODUS file above", "job.toml", job("exodus", "../check.json")),
        ("an include", "main.k", deck(secret)),
        ("an include above", "main.k", deck("../../../access.json")),
        ("an include with backslashes", "main.k", deck("..\\..\\..\\access.json")),
        ("an include in quotes", "main.k", deck("\"/etc/passwd\"")),
        ("an include path", "main.k", deck_in_path("/etc", "passwd")),
        ("an include path above", "main.k", deck_in_path("../../..", "access.json")),
        ("an include of another case", "main.k", deck("../../../ACCESS.JSON")),
        ("an included job", "job.toml", "include = [\"/etc/secret.toml\"]\n".into()),
        ("an included job above", "job.toml", "include = [\"../../../access.toml\"]\n".into()),
        ("a device", "main.k", deck("/dev/zero")),
        ("a process", "main.k", deck("/proc/self/environ")),
    ];
    for (what, name, text) in jobs {
        let id = service.submit(&json!({"files": {name: text}}));
        let job = service.wait_for(id, "refused");
        let said = service.get(&format!("/api/jobs/{id}/check")).json()["text"].to_string();
        let reasons = ["must be in its own folder", "is not a file", "cannot be read"];
        assert!(reasons.iter().any(|reason| said.contains(reason)), "{what}: {said}");
        for hidden in [&service.token, "root:", "#token"] {
            assert!(!said.contains(hidden) && !job.to_string().contains(hidden), "{what}: {said}");
        }
    }
    for set in [format!("mesh.file={secret}"), "mesh.deck=/etc/passwd".into()] {
        let mut job = bars(&[&set]);
        job["files"]["job.toml"] = json!("end_time = 1.0\n");
        let id = service.submit(&job);
        service.wait_for(id, "refused");
        let said = service.get(&format!("/api/jobs/{id}/check")).json()["text"].to_string();
        assert!(said.contains("must be in its own folder"), "{set}: {said}");
    }
}

#[test]
fn without_a_valid_token_nothing_is_shown_and_nothing_is_done() {
    let service = Service::start(&[]);
    let id = service.submit(&bars(&[]));
    service.wait_for(id, "completed");
    let own = service.token.clone();
    let upper = own.to_uppercase();
    let wrong = "0".repeat(64);
    let tokens = [
        String::new(),
        "Bearer".into(),
        "Bearer ".into(),
        format!("Bearer {wrong}"),
        format!("Bearer {}", &own[..63]),
        format!("Bearer {own}0"),
        format!("Bearer  {own}"),
        format!("Bearer {upper}"),
        format!("bearer {own}"),
        format!("Basic {own}"),
        format!("Token {own}"),
        "Bearer ' OR 1=1 --".into(),
        "Bearer %".into(),
    ];
    for (number, token) in tokens.iter().enumerate() {
        let path = format!("/api/jobs/{id}/files/results/summary.json");
        let reply = service.ask("GET", &path, &[("Authorization", token)], b"");
        refused(&service, &format!("token {number}: {token}"), &reply, &[401]);
    }
    let twice = [("Authorization", &*format!("Bearer {own}")), ("Authorization", "Bearer x")];
    refused(&service, "two tokens", &service.ask("GET", "/api/jobs", &twice, b""), &[401]);
    for path in [
        "/api/jobs",
        "/api/about",
        "/metrics",
        "/api/audit",
        "/api/openapi.json",
        "/api/jobs/1/events",
    ] {
        refused(&service, path, &service.ask("GET", path, &[], b""), &[401]);
        let query = format!("{path}?token={own}");
        refused(&service, &query, &service.ask("GET", &query, &[], b""), &[401]);
    }
    let cookie = format!("crumple_session={own}");
    refused(
        &service,
        "a token as cookie",
        &service.ask("GET", "/api/jobs", &[("Cookie", &cookie)], b""),
        &[401],
    );
    for path in
        ["/api/jobs", "/api/jobs/1/stop", "/api/jobs/1/resume", "/api/jobs/1/orders", "/logout"]
    {
        refused(&service, path, &service.ask("POST", path, &[], b"{}"), &[401]);
    }
    assert_eq!(service.get("/api/jobs").json()["total"], 1);
    assert_eq!(fs::metadata(service.dir().join("access.json")).unwrap().permissions(), private());
    assert_eq!(fs::metadata(service.dir().join("service.db")).unwrap().permissions(), private());
    for name in ["service.db", "service.db-wal"] {
        let bytes = fs::read(service.dir().join(name)).unwrap_or_default();
        assert!(!bytes.windows(64).any(|w| w == own.as_bytes()), "{name} has the token");
    }
}

fn private() -> fs::Permissions {
    std::os::unix::fs::PermissionsExt::from_mode(0o100600)
}

#[test]
fn many_wrong_tokens_are_refused_and_valid_ones_are_not_delayed() {
    let service = Service::start(&[]);
    let wrong = format!("Bearer {}", "0".repeat(64));
    let mut codes = Vec::new();
    for _ in 0..40 {
        codes.push(service.ask("GET", "/api/jobs", &[("Authorization", &wrong)], b"").status);
    }
    assert!(codes[0] == 401 && codes.contains(&429), "{codes:?}");
    assert_eq!(service.get("/api/jobs").status, 200, "a valid token");
}

#[test]
fn roles_bound_what_a_token_may_do() {
    let service = Service::start(&[]);
    let [reader, anna, ben] =
        ["reader:read", "anna:submit", "ben:submit"].map(|token| service.new_token(token));
    let submission = |token: &str| service.post_as(token, "/api/jobs", &bars(&[]));
    refused(&service, "a reader submits", &submission(&reader), &[403]);
    let id = submission(&anna).json()["id"].as_i64().unwrap();
    for token in [&reader, &ben] {
        for order in ["stop", "resume", "orders"] {
            let path = format!("/api/jobs/{id}/{order}");
            let body = if order == "orders" { json!({"request": "stop"}) } else { json!({}) };
            let reply = service.post_as(token, &path, &body);
            refused(&service, &path, &reply, &[403]);
        }
        let bearer = format!("Bearer {token}");
        let audit = service.ask("GET", "/api/audit", &[("Authorization", &bearer)], b"");
        refused(&service, "the audit log", &audit, &[403]);
    }
    service.wait_for(id, "completed");
    let audit = service.get("/api/audit").json().to_string();
    assert!(audit.contains("\"who\":\"ben\"") && audit.contains("\"status\":403"), "{audit}");
    let removed = service.command(&["serve", "--remove-token", "anna"]);
    assert!(removed.status.success(), "{removed:?}");
    refused(&service, "a removed token", &submission(&anna), &[401]);
}

#[test]
fn a_foreign_page_cannot_use_the_session_of_a_browser() {
    let service = Service::start(&[]);
    let origin = format!("http://{}", service.host);
    let body = json!({"token": service.token}).to_string();
    let login = |origin: &str, body: &str| {
        let headers = [("Content-Type", "application/json"), ("Origin", origin)];
        service.ask("POST", "/login", &headers, body.as_bytes())
    };
    for foreign in [
        "http://evil.example",
        "null",
        "",
        &origin.replace("http:", "https:"),
        &format!("{origin}0"),
    ] {
        refused(&service, foreign, &login(foreign, &body), &[403]);
    }
    refused(&service, "a wrong token", &login(&origin, &json!({"token": "x"}).to_string()), &[401]);
    let begun = login(&origin, &body);
    assert_eq!(begun.status, 204, "{}", begun.head);
    let set = begun.header("Set-Cookie").unwrap();
    assert!(set.contains("HttpOnly") && set.contains("SameSite=Strict"), "{set}");
    let cookie = set.split(';').next().unwrap();
    assert!(!cookie.contains(&service.token));
    let order = |headers: &[(&str, &str)]| {
        let all = [&[("Cookie", cookie), ("Content-Type", "application/json")], headers].concat();
        service.ask("POST", "/api/jobs", &all, bars(&[]).to_string().as_bytes())
    };
    assert_eq!(service.ask("GET", "/api/jobs", &[("Cookie", cookie)], b"").status, 200);
    refused(&service, "no origin", &order(&[]), &[403]);
    for foreign in ["http://evil.example", "null", "http://127.0.0.1:1", "http://localhost"] {
        refused(&service, foreign, &order(&[("Origin", foreign)]), &[403]);
    }
    assert_eq!(order(&[("Origin", &origin)]).status, 201);
    let double = format!("{cookie}; {cookie}");
    refused(
        &service,
        "two cookies",
        &service.ask("GET", "/api/jobs", &[("Cookie", &double)], b""),
        &[401],
    );
    let left = service.ask("POST", "/logout", &[("Cookie", cookie), ("Origin", &origin)], b"");
    assert_eq!(left.status, 204);
    refused(
        &service,
        "after the end",
        &service.ask("GET", "/api/jobs", &[("Cookie", cookie)], b""),
        &[401],
    );
    // No answer lets another page read it.
    let asked = [
        ("Origin", "http://evil.example"),
        ("Authorization", &format!("Bearer {}", service.token)),
    ];
    let reply = service.ask("GET", "/api/jobs", &asked, b"");
    assert!(reply.header("Access-Control-Allow-Origin").is_none(), "{}", reply.head);
    let options = service.ask("OPTIONS", "/api/jobs", &asked[..1], b"");
    assert!(options.header("Access-Control-Allow-Methods").is_none(), "{}", options.head);
}

#[test]
fn submissions_that_are_too_large_or_cut_off_leave_nothing() {
    let service = Service::start(&["--max-upload", "1"]);
    let large = "x".repeat(1_100_000);
    let parts = [("file", Some("job.toml"), large.as_bytes())];
    refused(&service, "a large file", &multipart(&service, &parts), &[413]);
    let reply = service.post("/api/jobs", &json!({"files": {"job.toml": large}}));
    assert_eq!(reply.status, 413, "{}", reply.head);
    let many: serde_json::Map<String, Value> =
        (0..2001).map(|i| (format!("{i}.k"), json!(""))).collect();
    refused(&service, "many files", &service.post("/api/jobs", &json!({"files": many})), &[413]);
    let head = format!(
        "POST /api/jobs HTTP/1.1\r\nHost: {}\r\nAuthorization: Bearer {}\r\nContent-Type: \
         multipart/form-data; boundary=xyz\r\nContent-Length: 100000\r\n\r\n\
         --xyz\r\nContent-Disposition: \
         form-data; name=\"file\"; filename=\"job.toml\"\r\n\r\nend_time",
        service.host, service.token
    );
    let mut cut = TcpStream::connect(&service.host).unwrap();
    cut.write_all(head.as_bytes()).unwrap();
    service.wait("the job arrives", |service| {
        fs::read_dir(service.dir().join("jobs")).unwrap().next().map(drop)
    });
    assert_eq!(service.get("/api/jobs").json()["total"], 0, "a job that arrives is not shown");
    drop(cut);
    service.wait("nothing stays", |service| {
        fs::read_dir(service.dir().join("jobs")).unwrap().next().is_none().then_some(())
    });
}

#[test]
fn one_token_cannot_take_all_requests_and_slow_clients_delay_no_others() {
    let service = Service::start(&["--rate", "5"]);
    let reader = service.new_token("reader:read");
    let bearer = format!("Bearer {reader}");
    let codes: Vec<u16> = (0..40)
        .map(|_| service.ask("GET", "/api/about", &[("Authorization", &bearer)], b"").status)
        .collect();
    assert!(codes.contains(&429), "{codes:?}");
    let slow: Vec<TcpStream> = (0..200)
        .map(|_| {
            let mut stream = TcpStream::connect(&service.host).unwrap();
            stream.write_all(b"GET / HTTP/1.1\r\nX: ").unwrap();
            stream
        })
        .collect();
    assert_eq!(service.get("/api/jobs").status, 200);
    // A connection whose headers do not arrive is closed.
    let mut first = &slow[0];
    first.set_read_timeout(Some(Duration::from_secs(200))).unwrap();
    let mut rest = Vec::new();
    let closed = first.read_to_end(&mut rest);
    assert!(
        closed.is_ok() || closed.is_err_and(|e| e.kind() == std::io::ErrorKind::ConnectionReset)
    );
}

#[test]
fn titles_and_names_are_data() {
    let service = Service::start(&[]);
    let hostile = "<script>alert(1)</script><img src=x onerror=alert(2)>\"'&{{facts}}";
    let mut job = bars(&[]);
    let text = job["files"]["job.toml"].as_str().unwrap();
    let text = text.replace("Two bars collide end to end\"", "<script>alert(1)</script>\"");
    job["files"]["job.toml"] =
        json!(text.replace("name = \"one\"", "name = \"<b onload=alert(3)>\""));
    job["name"] = json!(hostile);
    let id = service.submit(&job);
    service.wait_for(id, "completed");
    let reply = service.get(&format!("/api/jobs/{id}"));
    assert_eq!(reply.header("Content-Type"), Some("application/json"));
    assert_eq!(reply.header("X-Content-Type-Options"), Some("nosniff"));
    assert_eq!(reply.json()["name"], hostile);
    let none = service.get("/api/jobs?name=%27%3B%20DROP%20TABLE%20job").json();
    assert_eq!(none["total"], 0, "SQL in a filter is text");
    let report = service.get(&format!("/api/jobs/{id}/files/results/report.html"));
    assert!(!report.text().contains("<script>alert(1)"), "the title is escaped");
    // A job file that is a page is no page for the browser.
    let mut page = bars(&[]);
    page["files"]["evil.html"] = json!("<script>alert(1)</script>");
    page["files"]["evil.svg"] = json!("<svg onload='alert(1)'/>");
    page["files"]["results/report.html"] = json!("<script>alert(1)</script>");
    let id = service.submit(&page);
    service.wait_for(id, "completed");
    for name in ["evil.html", "evil.svg", "results/report.html"] {
        let reply = service.get(&format!("/api/jobs/{id}/files/input/{name}"));
        assert_eq!(reply.header("Content-Type"), Some("application/octet-stream"), "{name}");
        assert_eq!(reply.header("Content-Disposition"), Some("attachment"), "{name}");
    }
}

#[test]
fn an_address_that_others_reach_needs_tls() {
    let folder = tempfile::tempdir().unwrap();
    let dir = folder.path().join("s");
    for address in ["0.0.0.0:0", "[::]:0"] {
        let mut command = std::process::Command::new(crumple_tests::program::crumple());
        let ended =
            command.args(["serve", "--listen", address, "--dir"]).arg(&dir).output().unwrap();
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        assert_eq!(ended.status.code(), Some(2), "{said}");
        assert!(said.contains("TLS is needed") && said.contains("ssh -L"), "{said}");
    }
}
