//! The table of hostile requests: each has a name, a request and the refusal that is expected. All
//! are sent to one service, which goes on and keeps nothing of them.

use super::archives::{Entry, Member, deflated, entry, file, gzip, tar, with_mode, zip};
use super::attacks::form;
use crumple_tests::service::{Reply, Service, bars};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::fs;

/// Least number of attacks.
const LEAST: usize = 190;
/// The connection is closed without an answer.
const CLOSED: u16 = 0;
/// Refusal by the parser of HTTP, which has no body.
const NO_HTTP: &str = "";

/// A request, the code and the words of its refusal.
struct Attack {
    name: String,
    request: Vec<u8>,
    code: u16,
    says: &'static str,
}

fn attack(name: &str, request: Vec<u8>, code: u16, says: &'static str) -> Attack {
    Attack { name: name.into(), request, code, says }
}

/// Makes requests with the token of the admin.
struct Client<'a> {
    service: &'a Service,
    bearer: String,
    /// A job that has ended.
    job: i64,
}

impl Client<'_> {
    fn send(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Vec<u8> {
        let token = [("Authorization", &*self.bearer)];
        self.service.request(method, path, &[&token, headers].concat(), body)
    }

    fn get(&self, path: &str) -> Vec<u8> {
        self.send("GET", path, &[], b"")
    }

    fn post(&self, path: &str, body: &[u8]) -> Vec<u8> {
        self.send("POST", path, &[("Content-Type", "application/json")], body)
    }

    /// Submits one file.
    fn named(&self, name: &str) -> Vec<u8> {
        self.post("/api/jobs", json!({"files": {name: "x"}}).to_string().as_bytes())
    }

    /// Submits a job with another value of an option.
    fn with(&self, key: &str, value: Value) -> Vec<u8> {
        let mut job = bars(&[]);
        job[key] = value;
        self.post("/api/jobs", job.to_string().as_bytes())
    }

    fn parts(&self, parts: &[(&str, Option<&str>, &[u8])]) -> Vec<u8> {
        let kind = ("Content-Type", "multipart/form-data; boundary=xyz");
        self.send("POST", "/api/jobs", &[kind], &form(parts))
    }

    fn archive(&self, name: &str, archive: &[u8]) -> Vec<u8> {
        self.parts(&[("archive", Some(name), archive)])
    }

    /// Asks for a file of the job.
    fn file(&self, path: &str) -> Vec<u8> {
        self.get(&format!("/api/jobs/{}/files/{path}", self.job))
    }

    fn range(&self, range: &str) -> Vec<u8> {
        let path = format!("/api/jobs/{}/files/results/history.csv", self.job);
        self.send("GET", &path, &[("Range", range)], b"")
    }
}

/// Names that could leave the folder of a job, or that mislead.
fn names(client: &Client) -> Vec<Attack> {
    let plain = "empty names and names that begin with a point";
    let control = "control characters or backslashes";
    let (deep, long) = ("a/".repeat(9) + "x", "a".repeat(300));
    [
        ("an absolute path", "/etc/cron.d/x", plain),
        ("a path above", "../x", plain),
        ("a path to the database", "../../service.db", plain),
        ("a path that goes down and up", "a/../../x", plain),
        ("a path that ends above", "a/..", plain),
        ("a path that begins here", "./x", plain),
        ("the folder itself", ".", plain),
        ("a folder", "a/", plain),
        ("the folder above", "..", plain),
        ("an empty name in a path", "a//b", plain),
        ("no name", "", "give 1 to 200 bytes"),
        ("a long name", &long, "give 1 to 200 bytes"),
        ("a deep path", &deep, "more than 8 folders"),
        ("a hidden file", ".bashrc", plain),
        ("a hidden folder", "a/.ssh/authorized_keys", plain),
        ("backslashes", "..\\x", control),
        ("a drive", "C:\\x", control),
        ("a share", "\\\\host\\x", control),
        ("a null byte in a name", "a\0b", control),
        ("a new line in a name", "a\nb", control),
        ("a tab in a name", "a\tb", control),
        ("a name that is written backwards", "\u{202e}x\u{7f}", control),
        ("an escape sequence of terminals", "a\u{1b}[2J", control),
    ]
    .map(|(what, name, says)| attack(&format!("name: {what}"), client.named(name), 422, says))
    .into()
}

/// Parts of a form and archives.
fn uploads(client: &Client) -> Vec<Attack> {
    let good = || file("job.toml", b"x");
    let link = |kind, target: &'static [u8]| Member(b"s", kind, target, 0, b"");
    let zeros = vec![0; 5 << 20];
    let mode = |mode| with_mode("s", mode);
    let zipped = |all: &[Entry]| client.archive("a.zip", &zip(all));
    let tarred = |all: &[Member]| client.archive("a.tar", &tar(all));
    let a = |content| ("file", Some("a.toml"), content);
    let twice = client.parts(&[a(&b"x"[..]), a(b"y")]);
    let case = client.parts(&[a(&b"x"[..]), ("file", Some("A.toml"), b"y")]);
    let below = client.parts(&[a(&b"x"[..]), ("file", Some("a.toml/b"), b"y")]);
    let bomb = gzip(&tar(&[good(), file("bomb", &zeros)]));
    let kind = ("Content-Type", "multipart/form-data");
    let named = |name| client.parts(&[("file", Some(name), b"x")]);
    let form =
        |name: &str, request, code, says| attack(&format!("form: {name}"), request, code, says);
    let archive =
        |name: &str, request, code, says| attack(&format!("archive: {name}"), request, code, says);
    vec![
        form("a name twice", twice, 422, "given twice"),
        form("two names that differ by case", case, 422, "only by case"),
        form("a file below a file", below, 422, "is a file"),
        form("a path above", named("../x"), 422, "a point"),
        form("a path to the database", named("../../service.db"), 422, "a point"),
        form("an absolute path", named("/etc/cron.d/x"), 422, "empty names"),
        form("a hidden file", named(".hidden"), 422, "a point"),
        form("a backslash", named("a\\b"), 422, "backslashes"),
        form("an unknown part", client.parts(&[("other", None, b"x")]), 422, "give one part"),
        form("broken options", client.parts(&[("options", None, b"{")]), 422, "options"),
        form("no boundary", client.send("POST", "/api/jobs", &[kind], b"x"), 400, "boundary"),
        form("a large file", client.parts(&[a(&zeros)]), 413, "too large"),
        archive("an entry above", tarred(&[good(), file("../../evil", b"x")]), 422, "`../../evil`"),
        archive("an absolute entry", tarred(&[good(), file("/evil", b"x")]), 422, "`/evil`"),
        archive("a symbolic link", tarred(&[good(), link(b'2', b"/etc")]), 422, "symbolic link"),
        archive("a hard link", tarred(&[good(), link(b'1', b"/etc/passwd")]), 422, "hard link"),
        archive("a device", tarred(&[good(), link(b'3', b"")]), 422, "device"),
        archive("a pipe", tarred(&[good(), link(b'6', b"")]), 422, "pipe"),
        archive(
            "a name that is not UTF-8",
            tarred(&[good(), Member(b"\xff.k", b'0', b"", 1, b"x")]),
            422,
            "not UTF-8",
        ),
        archive("a bomb", client.archive("a.tgz", &bomb), 413, "more than 4 MB"),
        archive("zip: an entry above", zipped(&[entry("../../evil", b"x")]), 422, "`../../evil`"),
        archive("zip: a symbolic link", zipped(&[mode(0o120_777)]), 422, "symbolic link"),
        archive(
            "zip: a bomb",
            zipped(&[deflated("bomb", &zeros, 10)]),
            422,
            "larger than its declared",
        ),
        archive("another kind", client.archive("a.rar", b"Rar!"), 422, "ends in .zip"),
        archive("text as zip", client.archive("a.zip", b"no archive"), 422, "cannot be read"),
    ]
}

/// Values of a submission that are out of range, or no JSON.
fn submissions(client: &Client) -> Vec<Attack> {
    let post = |body: &[u8]| client.post("/api/jobs", body);
    let plain = client.send("POST", "/api/jobs", &[("Content-Type", "text/plain")], b"{}");
    let deep = "[".repeat(100_000);
    let number = b"{\"files\": {\"a.toml\": 1}}";
    let mut all = vec![
        attack("submission: no body", post(b""), 400, "JSON"),
        attack("submission: half an object", post(b"{"), 400, "JSON"),
        attack("submission: a list", post(b"[]"), 422, "name the job file"),
        attack("submission: null", post(b"null"), 422, "invalid type: null"),
        attack("submission: a number", post(b"1"), 422, "invalid type: integer"),
        attack("submission: a list of files", post(b"{\"files\": []}"), 422, "expected a map"),
        attack("submission: a file that is a number", post(number), 422, "expected a string"),
        attack("submission: deep JSON", post(deep.as_bytes()), 422, "JSON"),
        attack("submission: text that is not UTF-8", post(b"{\"name\": \"\xff\"}"), 400, "JSON"),
        attack("submission: half a surrogate", post(b"{\"name\": \"\\ud800\"}"), 400, "JSON"),
        attack("submission: another type of content", plain, 415, "Content-Type"),
        attack("submission: an unknown key", post(b"{\"root\": true}"), 422, "unknown field"),
        attack("submission: a key twice", post(b"{\"job\":\"a\",\"job\":\"b\"}"), 422, "duplicate"),
    ];
    for (what, key, value, says) in [
        ("the largest number of workers", "workers", json!(u32::MAX), "workers: give 1 to"),
        ("a number of workers that overflows", "workers", json!(4_294_967_297_u64), "u32"),
        ("a negative number of workers", "workers", json!(-1), "u32"),
        ("a number of workers with an exponent", "workers", json!(1e99), "expected u32"),
        ("more workers than slots", "workers", json!(100_000), "workers: give 1 to"),
        ("a priority that overflows", "priority", json!(99_999_999_999_u64), "expected i32"),
        ("one retry too many", "retries", json!(21), "at most 20"),
        (
            "a launcher that is not offered",
            "launcher",
            json!("slurm"),
            "launcher: this service has",
        ),
        ("a title of two lines", "name", json!("a\nb"), "printable"),
        ("a change that is a word", "set", json!(["end_time"]), "give key=value"),
        ("a file that is no job", "files", json!({"a.txt": "x"}), "name the job file"),
        ("a job file that is missing", "job", json!("absent.toml"), "no such file"),
        ("no workers", "workers", json!(0), "workers: give 1 to"),
        ("a priority above all others", "priority", json!(101), "give -100 to 100"),
        ("retries without end", "retries", json!(1_000_000), "at most 20"),
        ("a command as launcher", "launcher", json!("sh -c id"), "launcher: this service has"),
        ("an escape sequence as title", "name", json!("a\u{1b}]0;b"), "printable"),
        ("a long title", "name", json!("x".repeat(201)), "at most 200"),
        ("a change without a value", "set", json!(["--out"]), "give key=value"),
        ("a change with a second line", "set", json!(["a=b\n--out=/tmp"]), "give key=value"),
        ("a change with a null byte", "set", json!(["a=b\0"]), "give key=value"),
        ("a long change", "set", json!(["a=".repeat(2000)]), "give key=value"),
        ("many changes", "set", json!(vec!["a=b"; 101]), "at most 100"),
        ("a job file above", "job", json!("../../etc/passwd"), "a point"),
        ("a job file that is not there", "job", json!("/etc/passwd"), "empty names"),
        ("no files", "files", json!({}), "name the job file"),
    ] {
        all.push(attack(&format!("submission: {what}"), client.with(key, value), 422, says));
    }
    all
}

/// Paths, ranges, numbers and queries.
fn addresses(client: &Client) -> Vec<Attack> {
    let point = "names that begin with a point";
    let queries = "/api/jobs?state=queued%27%20OR%201=1--";
    let events = format!("/api/jobs/{}/events", client.job);
    let after = |value: &str| client.send("GET", &events, &[("Last-Event-ID", value)], b"");
    let number = |text: &str| client.get(&format!("/api/jobs/{text}"));
    let range = "give one range";
    let all: Vec<(&str, Vec<u8>, u16, &'static str)> = vec![
        ("a file above", client.file("../../../access.json"), 422, point),
        ("a file above, encoded", client.file("..%2f..%2faccess.json"), 422, point),
        ("points that are encoded", client.file("%2e%2e/%2e%2e/access.json"), 422, point),
        ("a path that is encoded twice", client.file("%252e%252e%252fx"), 404, "no such file"),
        ("backslashes that are encoded", client.file("..%5c..%5cx"), 422, "backslashes"),
        ("a null byte", client.file("results/%00"), 422, "control characters"),
        ("bytes that are not UTF-8", client.file("%ff%fe"), 400, "UTF-8"),
        ("an overlong point", client.file("%c0%ae%c0%ae/x"), 400, "UTF-8"),
        ("an absolute path", client.file("/etc/passwd"), 422, "empty names"),
        ("an absolute path, encoded", client.file("%2fetc%2fpasswd"), 422, "empty names"),
        ("a file above a folder", client.file("results/../../../access.json"), 422, point),
        ("an empty name", client.file("results//history.csv"), 422, "empty names"),
        ("the folder itself", client.file("."), 422, point),
        ("a point in a path", client.file("results/./history.csv"), 422, point),
        ("a folder with a slash", client.file("results/"), 422, "empty names"),
        ("a file that is not there", client.file("absent"), 404, "no such file"),
        ("a folder as file", client.file("results"), 404, "no such file"),
        ("a link out of the folder", client.file("link"), 404, "no such file"),
        ("a file through a link", client.file("results/etc/passwd"), 404, "no such file"),
        ("a pipe", client.file("results/pipe"), 404, "no such file"),
        ("range: backwards", client.range("bytes=5-1"), 416, range),
        ("range: beyond the end", client.range("bytes=99999999999-"), 416, range),
        ("range: several", client.range("bytes=0-1,3-4"), 416, range),
        (
            "range: a number that overflows",
            client.range("bytes=0-99999999999999999999"),
            416,
            range,
        ),
        ("range: another unit", client.range("lines=1-2"), 416, range),
        ("range: none of the last bytes", client.range("bytes=-0"), 416, range),
        ("range: a word", client.range("x"), 416, range),
        ("range: letters", client.range("bytes=a-b"), 416, range),
        ("number: zero", number("0"), 404, "no job 0"),
        ("number: of no job", number("999999"), 404, "no job 999999"),
        ("number: a letter", number("x"), 400, "i64"),
        ("number: a negative one", number("-1"), 404, "no job -1"),
        ("number: one that overflows", number("99999999999999999999"), 400, "i64"),
        ("number: SQL", number("1;drop%20table%20job"), 400, "i64"),
        ("number: SQL that is always true", number("1%20or%201=1"), 400, "i64"),
        ("query: SQL as state", client.get(queries), 422, "no such state"),
        ("query: an unknown state", client.get("/api/jobs?state=x"), 422, "no such state"),
        ("query: two states", client.get("/api/jobs?state=queued&state=running"), 400, "duplicate"),
        ("query: a negative number", client.get("/api/jobs?limit=-1"), 400, "limit"),
        ("query: a letter as number", client.get("/api/jobs?limit=x"), 400, "limit"),
        ("query: a letter as job", client.get("/api/jobs?before=x"), 400, "before"),
        ("query: a key twice", client.get("/api/jobs?limit=1&limit=2"), 400, "duplicate"),
        ("query: an unknown key", client.get("/api/jobs?debug=1"), 400, "unknown field"),
        ("query: a number that overflows", client.get("/api/jobs?limit=4294967296"), 400, "limit"),
        ("event: SQL as number", after("1 OR 1=1"), 422, "Last-Event-ID"),
        ("event: a number that overflows", after("9223372036854775808"), 422, "Last-Event-ID"),
        ("a path of the source", client.get("/.git/config"), 404, "no such path"),
        ("a path above the page", client.get("/../../etc/passwd"), 404, "no such path"),
    ];
    let named = |(name, request, code, says)| attack(&format!("path: {name}"), request, code, says);
    all.into_iter().map(named).collect()
}

/// Tokens, cookies and roles.
fn identities(client: &Client) -> Vec<Attack> {
    let service = client.service;
    let own = &service.token;
    let bearer = &client.bearer;
    let ask = |headers: &[(&str, &str)]| service.request("GET", "/api/jobs", headers, b"");
    let token = |value: &str| ask(&[("Authorization", value)]);
    let reader = format!("Bearer {}", service.new_token("reader:read"));
    let other = format!("Bearer {}", service.new_token("ben:submit"));
    let order = |bearer: &str, path: &str, body: &[u8]| {
        let headers = [("Authorization", bearer), ("Content-Type", "application/json")];
        service.request("POST", &format!("/api/jobs{path}"), &headers, body)
    };
    let (stop, resume) = (format!("/{}/stop", client.job), format!("/{}/resume", client.job));
    let valid = "give a valid token";
    let cookie = format!("crumple_session={own}");
    let audit = service.request("GET", "/api/audit", &[("Authorization", &reader)], b"");
    let all: Vec<(&str, Vec<u8>, u16, &'static str)> = vec![
        ("none", ask(&[]), 401, "give a token"),
        (
            "in the query",
            service.request("GET", &format!("/api/jobs?token={own}"), &[], b""),
            401,
            "give a token",
        ),
        ("as cookie", ask(&[("Cookie", &cookie)]), 401, "give a token"),
        ("a wrong one", token(&format!("Bearer {}", "0".repeat(64))), 401, valid),
        ("one digit less", token(&format!("Bearer {}", &own[..63])), 401, valid),
        ("one digit more", token(&format!("Bearer {own}0")), 401, valid),
        ("in capitals", token(&format!("Bearer {}", own.to_uppercase())), 401, valid),
        ("by Basic", token(&format!("Basic {own}")), 401, valid),
        ("SQL", token("Bearer ' OR 1=1 --"), 401, valid),
        (
            "two headers",
            ask(&[("Authorization", bearer), ("Authorization", "Bearer x")]),
            401,
            valid,
        ),
        (
            "role: a reader submits",
            order(&reader, "", bars(&[]).to_string().as_bytes()),
            403,
            "needs submit",
        ),
        ("role: a reader stops a job", order(&reader, &stop, b""), 403, "needs submit"),
        ("role: another user stops a job", order(&other, &stop, b""), 403, "belongs to admin"),
        (
            "role: another user resumes a job",
            order(&other, &resume, b"{}"),
            403,
            "belongs to admin",
        ),
        ("role: a reader reads the audit log", audit, 403, "needs admin"),
    ];
    let named =
        |(name, request, code, says)| attack(&format!("token: {name}"), request, code, says);
    all.into_iter().map(named).collect()
}

/// Names of the host, and pages that begin a session.
fn origins(client: &Client) -> Vec<Attack> {
    let service = client.service;
    let host = |name: &str| {
        let headers = [("Host", name), ("Authorization", &*client.bearer)];
        service.request("GET", "/api/jobs", &headers, b"")
    };
    let login = |origin: &str| {
        let headers = [("Content-Type", "application/json"), ("Origin", origin)];
        let body = json!({"token": service.token}).to_string();
        service.request("POST", "/login", &headers, body.as_bytes())
    };
    let without = format!(
        "GET /api/jobs HTTP/1.1\r\nAuthorization: {}\r\nConnection: close\r\n\r\n",
        client.bearer
    );
    let without = without.into_bytes();
    let page = "page of the service only";
    let name = "has another name";
    let all: Vec<(&str, Vec<u8>, u16, &'static str)> = vec![
        ("a foreign name (DNS rebinding)", host("evil.example"), 421, name),
        ("the own name with another port", host("127.0.0.1:1"), 421, name),
        (
            "a name that begins with the own",
            host(&format!("{}.evil.example", service.host)),
            421,
            name,
        ),
        ("no name", host(""), 421, name),
        ("no header", without, 421, name),
        ("the own name without its port", host("127.0.0.1"), 421, name),
        ("a name that begins as another own one", host("localhost.evil.example"), 421, name),
        ("a foreign page begins a session", login("http://evil.example"), 403, page),
        ("a page without an origin", login("null"), 403, page),
        ("the own with another scheme", login(&format!("https://{}", service.host)), 403, page),
        (
            "a page whose origin begins with the own",
            login(&format!("http://{}.evil.example", service.host)),
            403,
            page,
        ),
    ];
    let named =
        |(name, request, code, says)| attack(&format!("origin: {name}"), request, code, says);
    all.into_iter().map(named).collect()
}

/// Orders to a run, and what is no HTTP.
fn protocols(client: &Client) -> Vec<Attack> {
    let orders = format!("/api/jobs/{}/orders", client.job);
    let order = |body: &[u8]| client.post(&orders, body);
    let head = format!(
        "POST /api/jobs HTTP/1.1\r\nHost: {}\r\nAuthorization: {}\r\n\
                        Content-Type: application/json\r\nConnection: close\r\n",
        client.service.host, client.bearer
    );
    let raw = |rest: &str| format!("{head}{rest}").into_bytes();
    let method = |name: &str| client.send(name, "/api/jobs", &[], b"");
    let all: Vec<(&str, Vec<u8>, u16, &'static str)> = vec![
        ("an order that is no JSON", order(b"stop"), 422, "no request"),
        ("an order to watch", order(b"{\"request\": \"watch\"}"), 422, "the stream is at"),
        ("an order without words", order(b""), 422, "no request"),
        ("an order without a name", order(b"{}"), 422, "missing field `request`"),
        ("an order that no run knows", order(b"{\"request\": \"halt\"}"), 422, "halt"),
        (
            "an order without its values",
            order(b"{\"request\": \"set\"}"),
            422,
            "missing field `key`",
        ),
        ("an unknown order", order(b"{\"request\": \"exec\"}"), 422, "exec"),
        ("a large order", order(&[b' '; 100_000]), 413, "limit"),
        ("an order to a job that has ended", order(b"{\"request\": \"stop\"}"), 409, "the job is"),
        ("DELETE", method("DELETE"), 405, "no method"),
        ("TRACE", method("TRACE"), 405, "no method"),
        ("PUT", method("PUT"), 405, "no method"),
        ("PATCH", method("PATCH"), 405, "no method"),
        ("CONNECT", method("CONNECT"), 405, "no method"),
        ("an unknown version", b"GET / HTTP/9.9\r\n\r\n".to_vec(), 400, NO_HTTP),
        ("a method alone", b"GET\r\n\r\n".to_vec(), 400, NO_HTTP),
        ("a null byte in a path", b"GET /\x00 HTTP/1.1\r\nHost: x\r\n\r\n".to_vec(), 400, NO_HTTP),
        ("two lengths", raw("Content-Length: 5\r\nContent-Length: 6\r\n\r\nzzzzz"), 400, NO_HTTP),
        ("a negative length", raw("Content-Length: -1\r\n\r\n"), 400, NO_HTTP),
        (
            "a length that overflows",
            raw("Content-Length: 99999999999999999999\r\n\r\n"),
            400,
            NO_HTTP,
        ),
        ("a broken chunk", raw("Transfer-Encoding: chunked\r\n\r\nzz\r\n"), 400, "request body"),
        (
            "chunks and a length",
            raw("Transfer-Encoding: chunked\r\nContent-Length: 4\r\n\r\nzz\r\n"),
            400,
            "request body",
        ),
        (
            "an unknown coding",
            raw("Transfer-Encoding: chunked, xyz\r\n\r\n0\r\n\r\n"),
            400,
            NO_HTTP,
        ),
        ("a space before the colon", raw("X : y\r\n\r\n"), 400, NO_HTTP),
        ("a header that goes on in a second line", raw("X: y\r\n z\r\n\r\n"), 400, NO_HTTP),
        ("a null byte in a header", raw("X: a\0b\r\n\r\n"), 400, NO_HTTP),
        ("large headers", raw(&format!("X: {}\r\n\r\n", "x".repeat(200_000))), 431, NO_HTTP),
        ("many headers", raw(&("X: y\r\n".repeat(200) + "\r\n")), 431, NO_HTTP),
        (
            "TLS to a port without it",
            b"\x16\x03\x01\x02\x00\x01\x00\r\n\r\n".to_vec(),
            400,
            NO_HTTP,
        ),
        ("HTTP/2", b"PRI * HTTP/2.0\r\n\r\nSM\r\n\r\n".to_vec(), CLOSED, NO_HTTP),
    ];
    let named = |(name, request, code, says)| attack(&format!("HTTP: {name}"), request, code, says);
    all.into_iter().map(named).collect()
}

/// Returns why the answer is not the refusal that is expected.
fn fault(service: &Service, attack: &Attack, reply: &Reply) -> Option<String> {
    let text = reply.text();
    let shown = format!("{}: {} {text:.200}", attack.name, reply.status);
    let shown = |why: &str| Some(format!("{shown}: {why}"));
    let is_by_parser = reply.body.is_empty();
    let why = serde_json::from_slice::<Value>(&reply.body)
        .ok()
        .and_then(|body| Some(body["error"].as_str()?.to_string()));
    match why {
        _ if reply.status != attack.code => shown(&format!("expected {}", attack.code)),
        None if attack.says == NO_HTTP && is_by_parser => None,
        None => shown("it has no reason"),
        Some(_) if attack.says == NO_HTTP => shown("expected no reason"),
        Some(why) if !why.contains(attack.says) => shown(&format!("expected {}", attack.says)),
        Some(why) if why.contains(&service.token) => shown("it has the token"),
        Some(why) if why.contains(service.dir().to_str()?) => shown("it names a path"),
        Some(_) => None,
    }
}

#[test]
fn each_hostile_request_of_the_table_is_refused_and_the_service_goes_on() {
    let service = Service::start(&["--max-upload", "4", "--rate", "1000"]);
    let job = service.submit(&bars(&[]));
    service.wait_for(job, "completed");
    let results = service.folder(job).join("results");
    let link = |target: &str, name: &str| {
        std::os::unix::fs::symlink(target, service.folder(job).join(name)).unwrap();
    };
    link("../../access.json", "link");
    link("/etc", "results/etc");
    drop(std::os::unix::net::UnixListener::bind(results.join("pipe")).unwrap());
    let client = Client { service: &service, bearer: format!("Bearer {}", service.token), job };
    let tables = [names, uploads, submissions, addresses, identities, origins, protocols];
    let all: Vec<Attack> = tables.iter().flat_map(|table| table(&client)).collect();
    let (process, before) = (service.id(), service.job(job));
    let mut faults = Vec::new();
    for attack in &all {
        faults.extend(fault(&service, attack, &service.raw(&attack.request)));
        let alive = service.ask("GET", "/health", &[], b"");
        assert_eq!(alive.status, 200, "after {}: {}", attack.name, alive.head);
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
    let different: BTreeSet<&[u8]> = all.iter().map(|attack| &attack.request[..]).collect();
    let named: BTreeSet<&str> = all.iter().map(|attack| &*attack.name).collect();
    println!("{} attacks, all refused", different.len());
    assert!(different.len() >= LEAST && different.len() == all.len() && named.len() == all.len());
    assert_eq!(service.get("/api/jobs").json()["total"], 1);
    assert_eq!((service.id(), service.job(job)), (process, before));
    service.wait("nothing stays of them", |service| {
        (fs::read_dir(service.dir().join("jobs")).unwrap().count() == 1).then_some(())
    });
    for folder in [service.dir().parent().unwrap(), &service.dir()] {
        assert!(["evil", "x"].iter().all(|name| !folder.join(name).exists()));
    }
}
