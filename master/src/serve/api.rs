//! Messages between clients and the service, as JSON.

use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use strum::{EnumIter, EnumString, IntoStaticStr};
use utoipa::ToSchema;

/// Where a job stands.
#[derive(
    Clone,
    Copy,
    Debug,
    PartialEq,
    Eq,
    Serialize,
    Deserialize,
    ToSchema,
    EnumIter,
    EnumString,
    IntoStaticStr,
)]
#[serde(rename_all = "snake_case")]
#[strum(serialize_all = "snake_case")]
pub enum JobState {
    /// Its files are being checked.
    Checking,
    /// Its files are checked; it starts when it is resumed.
    Checked,
    /// It waits for a free place.
    Queued,
    /// A process has been ordered for it.
    Starting,
    /// It runs.
    Running,
    /// It is complete.
    Completed,
    /// Its input cannot be used.
    Refused,
    /// Numerical failure.
    Failed,
    /// A worker or the process was lost, and no retry is left.
    Lost,
    /// A user stopped it.
    Stopped,
}

impl JobState {
    /// Returns the name, as in JSON.
    pub fn name(self) -> &'static str {
        self.into()
    }

    /// Returns true if nothing more happens without an order.
    pub fn is_final(self) -> bool {
        !matches!(self, Self::Checking | Self::Queued | Self::Starting | Self::Running)
    }

    /// Returns true if there is or may be a process of the run.
    pub fn is_active(self) -> bool {
        matches!(self, Self::Starting | Self::Running)
    }

    /// Returns the state of a run that ended with an exit code.
    pub fn of_code(code: u8) -> Self {
        use crumple_proto::exit_code::{BAD_INPUT, COMPLETED, FAILED, STOPPED, UNMET};
        match code {
            COMPLETED | UNMET => Self::Completed,
            BAD_INPUT => Self::Refused,
            FAILED => Self::Failed,
            STOPPED => Self::Stopped,
            _ => Self::Lost,
        }
    }
}

/// A job of the service.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct ServiceJob {
    /// Number, in the order of submission.
    pub id: i64,
    /// Name that its owner gave it.
    pub name: String,
    /// Name of the token that submitted it.
    pub owner: String,
    /// Where it stands.
    pub state: JobState,
    /// Jobs of higher priority start first.
    pub priority: i32,
    /// Number of workers.
    pub workers: u32,
    /// How it is started: `threads`, `mpirun` or `slurm`.
    pub launcher: String,
    /// Its job file or deck, relative to its folder of input.
    pub job: String,
    /// Changes of the job, as `key=value`.
    pub set: Vec<String>,
    /// Number of times that a run which is lost is continued.
    pub retries: u32,
    /// Estimate of its memory by `crumple check` [MB]; 0 before the check.
    pub memory_mb: f64,
    /// Seconds since 1970 of its submission.
    pub submitted: f64,
    /// Seconds since 1970 of its last start.
    pub started: Option<f64>,
    /// Seconds since 1970 of its end.
    pub ended: Option<f64>,
    /// Exit code of `crumple run`.
    pub code: Option<u8>,
    /// Why it is in this state, for people.
    pub reason: String,
    /// Number of processes that were ordered for it.
    pub attempt: u32,
    /// True if a user wants it to stop.
    pub stopping: bool,
    /// True if its processes are to be killed.
    pub forced: bool,
}

/// A job as it is submitted. As multipart, it is the part `options`, and each file is a part
/// `file` whose file name is its path; a part `archive`, whose file name ends in `.zip`, `.tar`,
/// `.tar.gz` or `.tgz`, is unpacked. As JSON alone, `files` has all files as text.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Submission {
    /// Name, of at most 200 characters. Without it, the name of the job file.
    pub name: String,
    /// Job file or deck among the files. Without it, `job.toml`, or the only `.toml` file, or the
    /// only deck.
    pub job: String,
    /// Number of workers. Without it, 1.
    pub workers: Option<u32>,
    /// `threads`, `mpirun` or `slurm`. Without it, the first that the service offers.
    pub launcher: String,
    /// Jobs of higher priority start first, from -100 to 100.
    pub priority: i32,
    /// Number of times that a run which is lost is continued. Without it, 2.
    pub retries: Option<u32>,
    /// Changes of the job, as `key=value`.
    pub set: Vec<String>,
    /// True if the files are only checked. The job starts when it is resumed.
    pub check_only: bool,
    /// Files as text, by their paths.
    pub files: BTreeMap<String, String>,
}

/// Changes when a job is resumed.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, ToSchema)]
#[serde(deny_unknown_fields, default)]
pub struct ResumeRequest {
    /// Number of workers. Without it, as before.
    pub workers: Option<u32>,
    /// Changes of the job, as `key=value`, such as `end_time=40`.
    pub set: Vec<String>,
}

/// Part of the list of jobs, the newest first.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct JobPage {
    /// Jobs.
    pub jobs: Vec<ServiceJob>,
    /// Number of jobs that match.
    pub total: i64,
    /// `before` of the next page; none after the last.
    pub next: Option<i64>,
}

/// A file of a job.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct FileEntry {
    /// Path in the folder of the job.
    pub path: String,
    /// Size [byte].
    pub size: u64,
}

/// An entry of the audit log.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct AuditEntry {
    /// Seconds since 1970.
    pub at: f64,
    /// Name of the token.
    pub who: String,
    /// Order.
    pub what: String,
    /// Job, if the order is for one.
    pub job: Option<i64>,
    /// Details.
    pub detail: String,
    /// Status code of the answer.
    pub status: u16,
}

/// Why a request is refused.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct Refusal {
    /// Reason, and what is allowed.
    pub error: String,
}

/// Rights of this token, and the offer of the service.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, ToSchema)]
pub struct About {
    /// Name of the token.
    pub name: String,
    /// Role of the token: `read`, `submit` or `admin`.
    pub role: String,
    /// Launchers, with the workers that each runs at a time.
    pub launchers: BTreeMap<String, u32>,
    /// Version of the program.
    pub version: String,
}
