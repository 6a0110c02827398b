//! Runs the binary as a user does, with a deadline so that no test can hang, and reads the files
//! that it leaves.

use crate::tools::{self, Missing};
use crate::variable;
use rustix::process::{Pid, Signal, kill_process, kill_process_group};
use serde_json::Value;
use std::ffi::OsStr;
use std::fs::{self, File};
use std::os::unix::process::CommandExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::LazyLock;
use std::time::{Duration, Instant};
use tempfile::TempDir;

/// Longest duration of a run: several times that of the slowest test on two busy cores. The
/// variable `CRUMPLE_TEST_LIMIT` sets another number of seconds, for machines with other work.
static LIMIT: LazyLock<Duration> =
    LazyLock::new(|| Duration::from_secs(variable("CRUMPLE_TEST_LIMIT", 240)));
/// Interval between two polls of a process.
const LOOK_EVERY: Duration = Duration::from_millis(20);

/// Returns the binary to test: `CRUMPLE_BIN`, or the one that cargo built next to this test.
///
/// # Panics
/// When there is none.
pub fn crumple() -> PathBuf {
    if let Some(path) = std::env::var_os("CRUMPLE_BIN") {
        return path.into();
    }
    let test = std::env::current_exe().expect("the path of the test binary is known");
    let program = test.ancestors().nth(2).map(|folder| folder.join("crumple")).unwrap_or_default();
    assert!(
        program.exists(),
        "no {}: run `cargo build` first, or name the binary in CRUMPLE_BIN",
        program.display()
    );
    program
}

/// Returns the root of the repository.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().expect("tests/ is in the repository")
}

/// Returns a command that runs `crumple` with arguments in the repository's root.
pub fn crumple_with(args: &[&str]) -> Command {
    let mut command = Command::new(crumple());
    command.args(args);
    command
}

/// Returns a command that runs `mpirun` with `ranks` ranks of `crumple`.
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

/// Returns `Some` if `mpirun` is present and the binary is built with MPI; else see
/// [`tools::or_skip`].
pub fn mpi_or_skip() -> Option<()> {
    static FOUND: LazyLock<Result<(), Missing>> = LazyLock::new(|| {
        let missing = |what: String| Missing {
            what,
            install: "install openmpi-bin, libopenmpi-dev and libclang-dev, and build with \
                      --features crumple/mpi; deploy/test.sh does both"
                .into(),
        };
        let version = Command::new("mpirun").arg("--version").output();
        version.map_err(|error| missing(format!("mpirun: {error}")))?;
        match run(mpirun(1, &["run", "no-such-job.toml"])).said().contains("built without MPI") {
            true => Err(missing(format!("{} was built without MPI", crumple().display()))),
            false => Ok(()),
        }
    });
    tools::or_skip(FOUND.clone())
}

/// Returns `Some` if the binary is built with VTKHDF; else see [`tools::or_skip`].
pub fn vtkhdf_or_skip() -> Option<()> {
    let said = run(crumple_with(&["export-vtkhdf", "."])).said();
    tools::or_skip(match said.contains("built without VTKHDF") {
        true => Err(Missing {
            what: format!("{} was built without VTKHDF", crumple().display()),
            install: "build with --features crumple/vtkhdf; deploy/test.sh does so".into(),
        }),
        false => Ok(()),
    })
}

/// A running process. Its results go to a folder of its own, its output to a file.
pub struct Running {
    child: Child,
    folder: TempDir,
    began: Instant,
}

/// A process that has ended.
pub struct Ended {
    /// Exit code; none if a signal ended the process.
    pub code: Option<i32>,
    /// Duration of the process.
    pub took: Duration,
    folder: TempDir,
}

/// Contents of a `history.csv`.
pub struct History {
    /// Names of the columns.
    pub header: Vec<String>,
    /// Rows; an empty field is NaN.
    pub rows: Vec<Vec<f64>>,
}

/// Starts a command in the repository's root, in its own process group, with `--out` for a
/// folder of its own.
///
/// # Panics
/// When it cannot be started.
pub fn start(mut command: Command) -> Running {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let names_folder = command.get_args().any(|a| a == "--out" || a == "--resume");
    if command.get_args().any(|a| a == "run") && !names_folder {
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
    /// When the deadline has passed; the process and its group are killed.
    pub fn end(mut self) -> Ended {
        let status =
            self.wait_for("it ends", |r| r.child.try_wait().expect("a child can be waited for"));
        let folder =
            std::mem::replace(&mut self.folder, tempfile::tempdir().expect("a temporary folder"));
        Ended { code: status.code(), took: self.began.elapsed(), folder }
    }

    /// Waits until `look` returns a value.
    ///
    /// # Panics
    /// When the deadline has passed; the process and its group are killed.
    pub fn wait_for<T>(&mut self, what: &str, mut look: impl FnMut(&mut Self) -> Option<T>) -> T {
        loop {
            if let Some(found) = look(self) {
                return found;
            }
            let words = || fs::read_to_string(self.folder.path().join("words")).unwrap_or_default();
            assert!(
                self.began.elapsed() < *LIMIT,
                "after {:?} still waiting until {what}: {}",
                *LIMIT,
                words()
            );
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Waits until the history has `rows` rows, so that the run is in progress.
    pub fn wait_for_rows(&mut self, rows: usize) {
        let path = self.folder.path().join("out/history.csv");
        let there =
            |_: &mut Self| (fs::read_to_string(&path).ok()?.lines().count() > rows).then_some(());
        self.wait_for("history.csv has rows", there);
    }

    /// Sends a signal to the process.
    pub fn signal(&self, signal: Signal) {
        send(self.child.id(), signal);
    }

    /// Returns the folder of results.
    pub fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    /// Returns the process id.
    pub fn id(&self) -> u32 {
        self.child.id()
    }

    /// Returns the process ids of all child processes.
    ///
    /// # Panics
    /// When there is no /proc.
    pub fn children(&self) -> Vec<u32> {
        let children = format!("/proc/{0}/task/{0}/children", self.child.id());
        let children = fs::read_to_string(children).expect("Linux");
        children.split_whitespace().filter_map(|pid| pid.parse().ok()).collect()
    }

    /// Returns the process ids of the ranks that mpirun has started, by rank.
    ///
    /// # Panics
    /// When there is no /proc.
    pub fn ranks(&self) -> Vec<u32> {
        let rank_of = |pid: u32| {
            let environment = fs::read_to_string(format!("/proc/{pid}/environ")).ok()?;
            let rank =
                environment.split('\0').find_map(|v| v.strip_prefix("OMPI_COMM_WORLD_RANK="))?;
            Some((rank.parse::<usize>().ok()?, pid))
        };
        let mut ranks: Vec<(usize, u32)> =
            self.children().into_iter().filter_map(rank_of).collect();
        ranks.sort_unstable();
        ranks.into_iter().map(|r| r.1).collect()
    }
}

impl Drop for Running {
    fn drop(&mut self) {
        if let Ok(None) = self.child.try_wait() {
            for rank in self.children() {
                send(rank, Signal::KILL); // mpirun puts each rank in its own group
            }
            if let Some(group) = Pid::from_raw(self.child.id() as i32) {
                let _ = kill_process_group(group, Signal::KILL);
            }
            let _ = self.child.wait();
        }
    }
}

/// Sends a signal to a process; does nothing if it has just ended.
pub fn send(pid: u32, signal: Signal) {
    if let Some(pid) = Pid::from_raw(pid as i32) {
        let _ = kill_process(pid, signal);
    }
}

impl Ended {
    /// Returns all output of the process, standard output and error.
    pub fn said(&self) -> String {
        String::from_utf8_lossy(&fs::read(self.folder.path().join("words")).unwrap_or_default())
            .into_owned()
    }

    /// Returns `self` after a check of the exit code.
    ///
    /// # Panics
    /// When the exit code is not `code`.
    pub fn with_code(self, code: i32) -> Self {
        assert_eq!(self.code, Some(code), "{}", self.said());
        self
    }

    /// Returns the folder with results.
    pub fn out(&self) -> PathBuf {
        self.folder.path().join("out")
    }

    /// Reads `summary.json`.
    ///
    /// # Panics
    /// When there is none.
    pub fn summary(&self) -> Value {
        let text = fs::read_to_string(self.out().join("summary.json"));
        serde_json::from_str(&text.unwrap_or_else(|e| panic!("summary.json: {e}: {}", self.said())))
            .expect("JSON")
    }

    /// Returns the digest of the state.
    pub fn digest(&self) -> String {
        self.summary()["state_digest"].as_str().expect("a digest").to_owned()
    }

    /// Reads `history.csv`.
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

    /// Reads the events of `log.jsonl`.
    ///
    /// # Panics
    /// When a line is not JSON.
    pub fn log(&self) -> Vec<Value> {
        let text = fs::read_to_string(self.out().join("log.jsonl")).expect("a log");
        text.lines().map(|line| serde_json::from_str(line).expect("a line is JSON")).collect()
    }

    /// Reads the field files through VTK with deploy/read_fields.py. Without a Python that has
    /// VTK, it checks only that every file in the collection exists, and says so. Returns the
    /// number of steps.
    ///
    /// # Panics
    /// When a check fails.
    pub fn read_fields(&self) -> usize {
        let collection =
            fs::read_to_string(self.out().join("fields/fields.pvd")).expect("fields.pvd");
        let files: Vec<&str> =
            collection.split("file=\"").skip(1).filter_map(|s| s.split('"').next()).collect();
        for file in &files {
            assert!(self.out().join("fields").join(file).is_file(), "{file} is named but missing");
        }
        if let Some(python) = tools::python("pyvista") {
            let mut command = Command::new(python);
            command.args([OsStr::new("deploy/read_fields.py"), self.out().as_os_str()]);
            run(command).with_code(0);
        }
        files.len()
    }
}

impl History {
    /// Returns the column whose name starts with `name`.
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

/// Returns the numbers of a JSON array.
///
/// # Panics
/// When the value is not an array of numbers.
pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("an array").iter().map(|v| v.as_f64().expect("a number")).collect()
}

/// Asserts that all numbers in `value` are finite. JSON cannot represent others; serde writes
/// null for them.
///
/// # Panics
/// When a number is not finite.
pub fn assert_finite(value: &Value, path: &str) {
    match value {
        Value::Null => panic!("{path} is not a finite number"),
        Value::Array(items) => {
            items.iter().enumerate().for_each(|(i, v)| assert_finite(v, &format!("{path}[{i}]")))
        }
        Value::Object(map) => {
            map.iter().for_each(|(k, v)| assert_finite(v, &format!("{path}.{k}")))
        }
        _ => {}
    }
}
