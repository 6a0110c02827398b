//! The binary as a user starts it, with a deadline so that nothing can hang, and what it leaves
//! behind.

use rustix::process::{Pid, Signal, kill_process, kill_process_group};
use serde_json::Value;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Longest that a run of a test may take: several times what the longest takes on two busy cores.
const LIMIT: Duration = Duration::from_secs(240);
/// Between two looks at a process.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// The binary to test: `CRUMPLE_BIN`, or the one that cargo built beside this test.
///
/// # Panics
/// When there is none.
pub fn crumple() -> PathBuf {
    if let Some(path) = std::env::var_os("CRUMPLE_BIN") {
        return path.into();
    }
    let test = std::env::current_exe().expect("a test knows where it is");
    let beside = test.ancestors().nth(2).map(|folder| folder.join("crumple")).unwrap_or_default();
    assert!(
        beside.exists(),
        "no {}: run `cargo build` first, or name the binary in CRUMPLE_BIN",
        beside.display()
    );
    beside
}

/// The repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ lies in the repository")
}

/// `crumple` with arguments, in the repository's root.
pub fn crumple_with(args: &[&str]) -> Command {
    let mut command = Command::new(crumple());
    command.args(args);
    command
}

/// `mpirun` with so many ranks of `crumple`.
pub fn mpirun(ranks: usize, args: &[&str]) -> Command {
    let mut command = Command::new("mpirun");
    command.args(["-n", &ranks.to_string()]).arg(crumple()).args(args);
    // One machine, more ranks than cores, perhaps root in a container; as in deploy/setup.sh.
    for name in [
        "OMPI_ALLOW_RUN_AS_ROOT",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM",
        "OMPI_MCA_rmaps_base_oversubscribe",
    ] {
        command.env(name, "1");
    }
    command
        .env("OMPI_MCA_hwloc_base_binding_policy", "none")
        .env("OMPI_MCA_btl_vader_single_copy_mechanism", "none");
    command.env("PRTE_MCA_rmaps_default_mapping_policy", ":oversubscribe");
    command
}

/// Why there can be no test under MPI here; `None` if there can. `deploy/test.sh` promises that
/// there can.
///
/// # Panics
/// When `CRUMPLE_BIN` is set, as `deploy/test.sh` does, and there is no MPI all the same.
pub fn no_mpi() -> Option<String> {
    let there = Command::new("mpirun")
        .arg("--version")
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .status();
    let why = match there {
        Err(error) => Some(format!("mpirun: {error}")),
        Ok(_) => {
            let asked = run(mpirun(1, &["run", "no-such-job.toml"]));
            asked
                .said()
                .contains("built without MPI")
                .then(|| format!("{} was built without MPI", crumple().display()))
        }
    };
    if let Some(why) = &why {
        assert!(
            std::env::var_os("CRUMPLE_BIN").is_none(),
            "{why}, but CRUMPLE_BIN is set: deploy/test.sh promises MPI"
        );
        eprintln!("skipped: {why}; deploy/test.sh runs this test");
    }
    why
}

/// A process that runs. Its results go to a folder of its own, its words to a file.
pub struct Running {
    child: Child,
    folder: TempDir,
    began: Instant,
}

/// A process that has ended.
pub struct Ended {
    /// Exit code; none if a signal ended it.
    pub code: Option<i32>,
    /// How long it took.
    pub took: Duration,
    folder: TempDir,
}

/// A `history.csv`.
pub struct History {
    /// Names of the columns.
    pub header: Vec<String>,
    /// Rows; an empty field is not a number.
    pub rows: Vec<Vec<f64>>,
}

/// Starts a command in the repository's root with `--out` for a folder of its own, in its own
/// process group.
///
/// # Panics
/// When it cannot be started.
pub fn start(mut command: Command) -> Running {
    let folder = tempfile::tempdir().expect("a temporary folder");
    if command.get_args().any(|a| a == "run") && !command.get_args().any(|a| a == "--out") {
        command.arg("--out").arg(folder.path().join("out"));
    }
    let words = File::create(folder.path().join("words")).expect("a file in it");
    let errors = words.try_clone().expect("a second handle");
    command.current_dir(root()).stdin(Stdio::null()).stdout(words).stderr(errors).process_group(0);
    let child =
        command.spawn().unwrap_or_else(|error| panic!("{:?}: {error}", command.get_program()));
    Running { child, folder, began: Instant::now() }
}

/// Starts a command as [`start`] does and waits for its end.
pub fn run(command: Command) -> Ended {
    start(command).end()
}

impl Running {
    /// Waits for the end.
    ///
    /// # Panics
    /// When the deadline is over; the process and its group are killed.
    pub fn end(mut self) -> Ended {
        let status =
            self.wait_for("it ends", |r| r.child.try_wait().expect("a child can be waited for"));
        let folder =
            std::mem::replace(&mut self.folder, tempfile::tempdir().expect("a temporary folder"));
        Ended { code: status.code(), took: self.began.elapsed(), folder }
    }

    /// Waits until `look` finds something.
    ///
    /// # Panics
    /// When the deadline is over; the process and its group are killed.
    pub fn wait_for<T>(&mut self, what: &str, mut look: impl FnMut(&mut Self) -> Option<T>) -> T {
        loop {
            if let Some(found) = look(self) {
                return found;
            }
            let words = || fs::read_to_string(self.folder.path().join("words")).unwrap_or_default();
            assert!(
                self.began.elapsed() < LIMIT,
                "no end in sight after {LIMIT:?} of waiting until {what}: {}",
                words()
            );
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Waits until the history has so many rows: the run is under way.
    pub fn wait_for_rows(&mut self, rows: usize) {
        let path = self.folder.path().join("out/history.csv");
        let there =
            |_: &mut Self| (fs::read_to_string(&path).ok()?.lines().count() > rows).then_some(());
        self.wait_for("there is history", there);
    }

    /// Sends a signal to the process.
    pub fn signal(&self, signal: Signal) {
        send(self.child.id(), signal);
    }

    /// Process ids of the ranks that an mpirun has started, by rank.
    ///
    /// # Panics
    /// When there is no /proc.
    pub fn ranks(&self) -> Vec<u32> {
        let children = format!("/proc/{0}/task/{0}/children", self.child.id());
        let children = fs::read_to_string(children).expect("Linux");
        let rank_of = |pid: u32| {
            let environment = fs::read_to_string(format!("/proc/{pid}/environ")).ok()?;
            let rank =
                environment.split('\0').find_map(|v| v.strip_prefix("OMPI_COMM_WORLD_RANK="))?;
            Some((rank.parse::<usize>().ok()?, pid))
        };
        let mut ranks: Vec<(usize, u32)> =
            children.split_whitespace().filter_map(|pid| rank_of(pid.parse().ok()?)).collect();
        ranks.sort_unstable();
        ranks.into_iter().map(|r| r.1).collect()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Ok(None) = self.child.try_wait() {
            for rank in self.ranks() {
                send(rank, Signal::KILL); // mpirun gives each a group of its own
            }
            if let Some(group) = Pid::from_raw(self.child.id() as i32) {
                let _ = kill_process_group(group, Signal::KILL);
            }
            let _ = self.child.wait();
        }
    }
}

/// Sends a signal to a process; one that has just ended needs none.
pub fn send(pid: u32, signal: Signal) {
    if let Some(pid) = Pid::from_raw(pid as i32) {
        let _ = kill_process(pid, signal);
    }
}

impl Ended {
    /// Everything that it wrote to standard output and error.
    pub fn said(&self) -> String {
        String::from_utf8_lossy(&fs::read(self.folder.path().join("words")).unwrap_or_default())
            .into_owned()
    }

    /// This, if the exit code is the one wanted.
    ///
    /// # Panics
    /// When it is not.
    pub fn with_code(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{}", self.said());
        self
    }

    /// The folder with results.
    pub fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    /// `summary.json`.
    ///
    /// # Panics
    /// When there is none.
    pub fn summary(&self) -> Value {
        let text = fs::read_to_string(self.out().join("summary.json"));
        serde_json::from_str(&text.unwrap_or_else(|e| panic!("summary.json: {e}: {}", self.said())))
            .expect("JSON")
    }

    /// The digest of the state.
    pub fn digest(&self) -> String {
        self.summary()["state_digest"].as_str().expect("a digest").to_owned()
    }

    /// `history.csv`.
    ///
    /// # Panics
    /// When there is none.
    pub fn history(&self) -> History {
        let text = fs::read_to_string(self.out().join("history.csv")).expect("a history");
        let mut lines = text.lines();
        let header = lines.next().expect("a header").split(',').map(String::from).collect();
        let number = |field: &str| field.parse().unwrap_or(f64::NAN);
        History { header, rows: lines.map(|line| line.split(',').map(number).collect()).collect() }
    }

    /// Events of `log.jsonl`.
    ///
    /// # Panics
    /// When a line is no JSON.
    pub fn log(&self) -> Vec<Value> {
        let text = fs::read_to_string(self.out().join("log.jsonl")).expect("a log");
        text.lines().map(|line| serde_json::from_str(line).expect("a line is JSON")).collect()
    }

    /// Reads the field files through VTK with deploy/read_fields.py, or, without a Python that can,
    /// looks that every file that the collection names is there. Returns the number of steps.
    ///
    /// # Panics
    /// When something does not add up.
    pub fn read_fields(&self) -> usize {
        let collection =
            fs::read_to_string(self.out().join("fields/fields.pvd")).expect("fields.pvd");
        let files: Vec<&str> =
            collection.split("file=\"").skip(1).filter_map(|s| s.split('"').next()).collect();
        for file in &files {
            assert!(self.out().join("fields").join(file).is_file(), "{file} is named but missing");
        }
        if let Some(python) = std::env::var_os("CRUMPLE_PYTHON") {
            let mut command = Command::new(python);
            command.args([OsStr::new("deploy/read_fields.py"), self.out().as_os_str()]);
            run(command).with_code(0);
        }
        files.len()
    }
}

impl History {
    /// A column by the start of its name.
    ///
    /// # Panics
    /// When there is none.
    pub fn column(&self, name: &str) -> Vec<f64> {
        let at = self
            .header
            .iter()
            .position(|h| h.starts_with(name))
            .unwrap_or_else(|| panic!("no column {name}"));
        self.rows.iter().map(|row| row[at]).collect()
    }
}

/// Numbers of a JSON array.
///
/// # Panics
/// When it is none.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|v| v.as_f64().expect("a number")).collect()
}

/// Panics when a number anywhere in `value` is not finite: JSON has no word for those, serde writes
/// null.
///
/// # Panics
/// See above.
pub fn assert_finite(value: &Value, path: &str) {
    match value {
        Value::Null => panic!("{path} is no number"),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, v)| assert_finite(v, &format!("{path}[{i}]")))
        }
        Value::Object(map) => {
            map.iter().for_each(|(k, v)| assert_finite(v, &format!("{path}.{k}")))
        }
        _ => {}
    }
}
