//! A service in a folder of its own, and a plain client for it that sends any bytes.

use crate::program::{crumple, root, send};
use crate::variable;
use rustix::process::Signal;
use serde_json::Value;
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Interval between two looks.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Longest wait: several times that on two busy cores.
fn limit() -> Duration {
    Duration::from_secs(variable("CRUMPLE_TEST_LIMIT", 240))
}

/// A service. Its jobs end with it.
pub struct Service {
    child: Option<Child>,
    folder: TempDir,
    options: Vec<String>,
    path: Option<String>,
    /// Host and port.
    pub host: String,
    /// Token of an admin.
    pub token: String,
}

/// An answer.
#[derive(Clone, Debug)]
pub struct Reply {
    /// Status code; 0 if the service closed the connection without one.
    pub status: u16,
    /// Head: status line and headers.
    pub head: String,
    /// Body.
    pub body: Vec<u8>,
}

impl Reply {
    /// Returns the body as text.
    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    /// Returns the body as JSON.
    ///
    /// # Panics
    /// When it is none.
    pub fn json(&self) -> Value {
        serde_json::from_slice(&self.body)
            .unwrap_or_else(|error| panic!("{error}: {} {}", self.head, self.text()))
    }

    /// Returns the value of a header.
    pub fn header(&self, name: &str) -> Option<&str> {
        let all = self.head.lines().filter_map(|line| line.split_once(':'));
        let mut own = all.filter(|(key, _)| key.eq_ignore_ascii_case(name));
        own.next().map(|(_, value)| value.trim())
    }
}

impl Service {
    /// Starts a service on a free port.
    ///
    /// # Panics
    /// When it does not start.
    pub fn start(options: &[&str]) -> Self {
        Self::start_with_path(options, None)
    }

    /// Starts a service whose `PATH` begins with a folder.
    ///
    /// # Panics
    /// When it does not start.
    pub fn start_with_path(options: &[&str], path: Option<&Path>) -> Self {
        let path = path.map(|path| {
            format!("{}:{}", path.display(), std::env::var("PATH").unwrap_or_default())
        });
        let mut service = Self {
            child: None,
            folder: tempfile::tempdir().expect("a temporary folder"),
            options: options.iter().map(ToString::to_string).collect(),
            path,
            host: String::new(),
            token: String::new(),
        };
        service.again();
        service
    }

    /// Returns the folder of the service.
    pub fn dir(&self) -> PathBuf {
        self.folder.path().join("service")
    }

    /// Starts the service again in its folder.
    ///
    /// # Panics
    /// When it does not start.
    pub fn again(&mut self) {
        let access = self.dir().join("access.json");
        let _ = fs::remove_file(self.folder.path().join("said"));
        let said = fs::File::create(self.folder.path().join("said")).expect("a file");
        let errors = said.try_clone().expect("a second handle");
        let mut command = Command::new(crumple());
        command.arg("serve").arg("--dir").arg(self.dir()).args(["--listen", "127.0.0.1:0"]);
        if !self.options.iter().any(|option| option.starts_with("--disk-limit")) {
            command.arg("--disk-limit=0"); // the machine of the tests may be nearly full
        }
        command.args(&self.options).current_dir(root()).process_group(0);
        command.stdin(Stdio::null()).stdout(said).stderr(errors);
        if let Some(path) = &self.path {
            command.env("PATH", path);
        }
        self.child = Some(command.spawn().expect("crumple starts"));
        self.wait("the service prints its address", |service| {
            service.said().contains("#token=").then_some(())
        });
        let access: Value = serde_json::from_slice(&fs::read(&access).unwrap()).unwrap();
        self.host = access["address"].as_str().unwrap().rsplit('/').next().unwrap().into();
        self.token = access["token"].as_str().unwrap().into();
    }

    /// Sets the options of the next start.
    pub fn set_options(&mut self, options: &[&str]) {
        self.options = options.iter().map(ToString::to_string).collect();
    }

    /// Returns what the service has printed.
    pub fn said(&self) -> String {
        fs::read_to_string(self.folder.path().join("said")).unwrap_or_default()
    }

    /// Kills the service. Its jobs go on.
    pub fn kill(&mut self) {
        if let Some(mut child) = self.child.take() {
            let _ = child.kill();
            let _ = child.wait();
        }
    }

    /// Returns the process of the service.
    ///
    /// # Panics
    /// When it is killed.
    pub fn id(&self) -> u32 {
        self.child.as_ref().expect("the service runs").id()
    }

    /// Waits until `look` returns a value.
    ///
    /// # Panics
    /// When the deadline has passed.
    pub fn wait<T>(&self, what: &str, mut look: impl FnMut(&Self) -> Option<T>) -> T {
        let began = Instant::now();
        loop {
            if let Some(found) = look(self) {
                return found;
            }
            assert!(began.elapsed() < limit(), "still waiting until {what}: {}", self.said());
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Sends bytes on a connection of their own, and reads until the service closes it.
    pub fn raw(&self, bytes: &[u8]) -> Reply {
        let mut stream = TcpStream::connect(&self.host).expect("the service listens");
        stream.set_read_timeout(Some(limit())).unwrap();
        let _ = stream.write_all(bytes); // the service may close early
        let mut all = Vec::new();
        let _ = stream.read_to_end(&mut all);
        let split =
            all.windows(4).position(|four| four == b"\r\n\r\n").map_or(all.len(), |i| i + 4);
        let head = String::from_utf8_lossy(&all[..split]).into_owned();
        let status = head.split(' ').nth(1).and_then(|code| code.parse().ok()).unwrap_or(0);
        Reply { status, head, body: all[split..].to_vec() }
    }

    /// Sends a request with headers.
    pub fn ask(&self, method: &str, path: &str, headers: &[(&str, &str)], body: &[u8]) -> Reply {
        self.raw(&self.request(method, path, headers, body))
    }

    /// Returns the bytes of a request with headers.
    pub fn request(
        &self,
        method: &str,
        path: &str,
        headers: &[(&str, &str)],
        body: &[u8],
    ) -> Vec<u8> {
        let mut text = format!("{method} {path} HTTP/1.1\r\nConnection: close\r\n");
        if !headers.iter().any(|(name, _)| *name == "Host") {
            text += &format!("Host: {}\r\n", self.host);
        }
        for (name, value) in headers {
            text += &format!("{name}: {value}\r\n");
        }
        if !body.is_empty() || method == "POST" {
            text += &format!("Content-Length: {}\r\n", body.len());
        }
        [text.as_bytes(), b"\r\n", body].concat()
    }

    /// Sends a request as admin.
    pub fn get(&self, path: &str) -> Reply {
        self.ask("GET", path, &[("Authorization", &format!("Bearer {}", self.token))], b"")
    }

    /// Sends JSON as admin.
    pub fn post(&self, path: &str, body: &Value) -> Reply {
        self.post_as(&self.token, path, body)
    }

    /// Sends JSON with a token.
    pub fn post_as(&self, token: &str, path: &str, body: &Value) -> Reply {
        let bearer = format!("Bearer {token}");
        let headers = [("Authorization", &*bearer), ("Content-Type", "application/json")];
        self.ask("POST", path, &headers, body.to_string().as_bytes())
    }

    /// Submits a job and returns its number.
    ///
    /// # Panics
    /// When it is refused.
    pub fn submit(&self, submission: &Value) -> i64 {
        let reply = self.post("/api/jobs", submission);
        assert_eq!(reply.status, 201, "{}", reply.text());
        reply.json()["id"].as_i64().unwrap()
    }

    /// Returns a job.
    pub fn job(&self, id: i64) -> Value {
        self.get(&format!("/api/jobs/{id}")).json()
    }

    /// Waits until a job is in a state.
    ///
    /// # Panics
    /// When it ends in another one, or the deadline has passed.
    pub fn wait_for(&self, id: i64, state: &str) -> Value {
        const FINAL: [&str; 6] = ["checked", "completed", "refused", "failed", "lost", "stopped"];
        self.wait(&format!("job {id} is {state}"), |service| {
            let job = service.job(id);
            let now = job["state"].as_str().unwrap();
            assert!(now == state || !FINAL.contains(&now), "{job}");
            (now == state).then_some(job)
        })
    }

    /// Returns the folder of a job.
    pub fn folder(&self, id: i64) -> PathBuf {
        self.dir().join("jobs").join(id.to_string())
    }

    /// Makes a token.
    ///
    /// # Panics
    /// When it is refused.
    pub fn new_token(&self, name_and_role: &str) -> String {
        let mut command = Command::new(crumple());
        command.arg("serve").arg("--dir").arg(self.dir()).args(["--new-token", name_and_role]);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{output:?}");
        String::from_utf8(output.stdout).unwrap().trim().to_string()
    }

    /// Runs a client command for this service.
    pub fn command(&self, words: &[&str]) -> std::process::Output {
        let mut command = Command::new(crumple());
        command.args(words).arg("--dir").arg(self.dir()).current_dir(root());
        command.output().unwrap()
    }

    /// Returns the processes of all attempts that were claimed.
    fn processes(&self) -> Vec<u32> {
        let jobs = fs::read_dir(self.dir().join("jobs")).into_iter().flatten().flatten();
        let files = jobs.flat_map(|job| fs::read_dir(job.path()).into_iter().flatten().flatten());
        let attempts = files.filter(|f| f.file_name().to_string_lossy().starts_with("attempt-"));
        attempts
            .filter_map(|file| {
                let text = fs::read_to_string(file.path()).ok()?;
                let is_over = text.contains("code ");
                let pid = text.lines().find_map(|line| line.strip_prefix("pid "))?.parse().ok()?;
                (!is_over && is_crumple(pid)).then_some(pid)
            })
            .collect()
    }
}

/// Returns true if a process runs `crumple`.
fn is_crumple(pid: u32) -> bool {
    fs::read(format!("/proc/{pid}/cmdline"))
        .is_ok_and(|line| line.windows(9).any(|w| w == b"--attempt"))
}

/// Returns the child processes of a process.
pub fn children(pid: u32) -> Vec<u32> {
    let text = fs::read_to_string(format!("/proc/{pid}/task/{pid}/children")).unwrap_or_default();
    text.split_whitespace().filter_map(|pid| pid.parse().ok()).collect()
}

impl Drop for Service {
    fn drop(&mut self) {
        self.kill();
        for pid in self.processes() {
            let below = children(pid);
            send(pid, Signal::KILL);
            below.into_iter().for_each(|child| send(child, Signal::KILL));
        }
    }
}

/// Returns a job of two bars that collide, 0.2 s on one core, with changes.
pub fn bars(set: &[&str]) -> Value {
    let text = fs::read_to_string(root().join("cases/bars/job.toml")).unwrap();
    serde_json::json!({"files": {"job.toml": text}, "set": set})
}

/// Returns a job that runs for hours unless it is stopped.
pub fn endless() -> Value {
    bars(&["end_time=1e9", "output.field_interval=-1", "output.history_interval=1e3"])
}
