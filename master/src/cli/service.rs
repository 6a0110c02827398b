//! Command line of the service and of the commands that ask one.

use super::SET_HELP;
use clap::Args;
use std::net::SocketAddr;
use std::path::PathBuf;

/// Default folder of a service.
const SERVICE_DIR: &str = "out/service";

/// `crumple serve`.
#[derive(Args, Clone, Debug)]
pub struct ServeArgs {
    /// Folder of the service: queue, and a folder for each job.
    #[arg(long, value_name = "DIR", default_value = SERVICE_DIR)]
    pub dir: PathBuf,
    /// Address and port; port 0 takes a free one.
    #[arg(long, value_name = "ADDRESS:PORT", default_value = "127.0.0.1:8787")]
    pub listen: SocketAddr,
    /// Name under which the service is reached, such as that of the machine. May be given several
    /// times.
    #[arg(long, value_name = "NAME")]
    pub host: Vec<String>,
    /// Certificate chain for TLS, in PEM. Needed if other machines can reach the address.
    #[arg(long, value_name = "FILE", requires = "tls_key")]
    pub tls_cert: Option<PathBuf>,
    /// Key of the certificate, in PEM.
    #[arg(long, value_name = "FILE", requires = "tls_cert")]
    pub tls_key: Option<PathBuf>,
    /// Number of workers of all jobs that run on this machine at a time [default: the cores].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub slots: Option<u32>,
    /// Memory of all jobs that run on this machine at a time, by the estimate of `crumple check`
    /// [MB] [default: 80 % of the memory].
    #[arg(long, value_name = "MB")]
    pub memory: Option<f64>,
    /// Offer the launcher `mpirun`: the command that starts ranks, such as "mpirun -n {ranks}
    /// --hostfile hosts".
    #[arg(long, value_name = "COMMAND")]
    pub mpirun: Option<String>,
    /// Number of workers of all jobs that run by mpirun at a time [default: that of --slots].
    #[arg(long, value_name = "N", requires = "mpirun")]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    pub mpirun_slots: Option<u32>,
    /// Offer the launcher `slurm`. The folder must be on a file system that all nodes share.
    #[arg(long)]
    pub slurm: bool,
    /// Number of workers of all jobs that are submitted to Slurm at a time.
    #[arg(long, value_name = "N", default_value_t = 1024)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    pub slurm_slots: u32,
    /// Option of sbatch, such as --slurm-option=--partition=crash. May be given several times.
    #[arg(long, value_name = "OPTION", allow_hyphen_values = true)]
    pub slurm_option: Vec<String>,
    /// Command that starts ranks within an allocation of Slurm, such as "srun -n {ranks}" [default:
    /// workers are threads on one node].
    #[arg(long, value_name = "COMMAND")]
    pub slurm_launcher: Option<String>,
    /// Largest submission, and most bytes of an unpacked archive [MB].
    #[arg(long, value_name = "MB", default_value_t = 2000)]
    pub max_upload: u64,
    /// Space that submissions leave free on the disk of the folder [GB] [default: 5 % of it, and at
    /// least 2].
    #[arg(long, value_name = "GB")]
    pub disk_limit: Option<f64>,
    /// Time in which a client has to take each 64 kB of an answer before it is disconnected [s].
    #[arg(long, value_name = "S", default_value_t = 60)]
    #[arg(value_parser = clap::value_parser!(u64).range(1..))]
    pub stall_limit: u64,
    /// Requests per second of one token.
    #[arg(long, value_name = "N", default_value_t = 200)]
    pub rate: u32,
    /// Make a token with a role (read, submit or admin), print it and end.
    #[arg(long, value_name = "NAME:ROLE", value_parser = token)]
    pub new_token: Option<(String, Role)>,
    /// Remove a token and end.
    #[arg(long, value_name = "NAME")]
    pub remove_token: Option<String>,
    /// Print the OpenAPI document of the service and end.
    #[arg(long)]
    pub openapi: bool,
}

/// Role of a token of a service.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Role {
    /// Sees all jobs and their files.
    Read,
    /// Also submits jobs, and gives orders to its own.
    Submit,
    /// Also gives orders to all jobs, and reads the audit log.
    Admin,
}

impl Role {
    /// Returns the name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Read => "read",
            Self::Submit => "submit",
            Self::Admin => "admin",
        }
    }

    /// Returns the role of this name.
    pub fn of_name(name: &str) -> Option<Self> {
        [Self::Read, Self::Submit, Self::Admin].into_iter().find(|role| role.name() == name)
    }
}

/// The service that a command asks.
#[derive(Args, Clone, Debug)]
pub struct ServerArgs {
    /// Address of the service, such as http://127.0.0.1:8787. Its token is read from
    /// CRUMPLE_TOKEN [default: the service whose folder is --dir].
    #[arg(long, value_name = "URL")]
    pub server: Option<String>,
    /// Folder of a service on this machine; its address and token are read from there.
    #[arg(long, value_name = "DIR", default_value = SERVICE_DIR)]
    pub dir: PathBuf,
    /// Certificates in PEM that the command trusts if the address begins with https, such as that of
    /// a private authority [default: those of public authorities].
    #[arg(long, value_name = "FILE")]
    pub ca: Option<PathBuf>,
}

/// `crumple submit`.
#[derive(Args, Clone, Debug)]
pub struct SubmitArgs {
    /// A .toml job file, a deck, a folder, all files of which are sent, or an archive (.zip, .tar,
    /// .tar.gz, .tgz), which the service unpacks.
    pub job: PathBuf,
    /// Further files: meshes, and what decks include. They keep their paths below the folder of the
    /// job.
    pub files: Vec<PathBuf>,
    /// Job file or deck in the folder or the archive [default: its job.toml, its only .toml file or
    /// its only deck].
    #[arg(long, value_name = "FILE")]
    pub main: Option<String>,
    /// Name of the job [default: that of its file].
    #[arg(long, value_name = "NAME")]
    pub name: Option<String>,
    /// Number of workers.
    #[arg(long, value_name = "N", default_value_t = 1)]
    #[arg(value_parser = clap::value_parser!(u32).range(1..))]
    pub workers: u32,
    /// How it is started: threads, mpirun or slurm [default: threads].
    #[arg(long, value_name = "NAME")]
    pub launcher: Option<String>,
    /// Jobs of higher priority start first, from -100 to 100.
    #[arg(long, value_name = "N", default_value_t = 0, allow_negative_numbers = true)]
    pub priority: i32,
    /// Number of times that a run which is lost is continued.
    #[arg(long, value_name = "N", default_value_t = 2)]
    pub retries: u32,
    /// Changes to the job.
    #[arg(long = "set", value_name = "KEY=VALUE", help = SET_HELP)]
    pub set: Vec<String>,
    /// Only check the job. `crumple resume` starts it.
    #[arg(long)]
    pub check: bool,
    /// Show its progress until it ends; the exit code is then that of the run.
    #[arg(long)]
    pub watch: bool,
    /// The service.
    #[command(flatten)]
    pub server: ServerArgs,
}

/// `crumple jobs`.
#[derive(Args, Clone, Debug)]
pub struct JobsArgs {
    /// Only jobs in this state, such as running.
    #[arg(long, value_name = "STATE")]
    pub state: Option<String>,
    /// Number of jobs.
    #[arg(long, value_name = "N", default_value_t = 20)]
    pub limit: u32,
    /// Print the answer of the service as it is.
    #[arg(long)]
    pub json: bool,
    /// The service.
    #[command(flatten)]
    pub server: ServerArgs,
}

/// `crumple watch` and `crumple stop`.
#[derive(Args, Clone, Debug)]
pub struct OneJobArgs {
    /// Number of the job.
    pub job: i64,
    /// The service.
    #[command(flatten)]
    pub server: ServerArgs,
}

/// `crumple stop`.
#[derive(Args, Clone, Debug)]
pub struct StopArgs {
    /// Number of the job.
    pub job: i64,
    /// Kill the processes of a job that was asked to stop and does not. What it has computed since
    /// its last checkpoint is lost.
    #[arg(long)]
    pub force: bool,
    /// The service.
    #[command(flatten)]
    pub server: ServerArgs,
}

/// `crumple resume`.
#[derive(Args, Clone, Debug)]
pub struct ResumeArgs {
    /// Number of the job.
    pub job: i64,
    /// Number of workers [default: as before].
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub workers: Option<u32>,
    /// Changes to the job.
    #[arg(long = "set", value_name = "KEY=VALUE", help = SET_HELP)]
    pub set: Vec<String>,
    /// The service.
    #[command(flatten)]
    pub server: ServerArgs,
}

/// `crumple fetch`.
#[derive(Args, Clone, Debug)]
pub struct FetchArgs {
    /// Number of the job.
    pub job: i64,
    /// Only files whose paths begin with this text, such as results/history.csv.
    #[arg(default_value = "results/")]
    pub only: String,
    /// Folder for the files [default: out/job- and the number].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// The service.
    #[command(flatten)]
    pub server: ServerArgs,
}

/// Parses name and role of a token.
fn token(text: &str) -> Result<(String, Role), String> {
    let wrong = || "give a name of letters, digits, - and _, and a role, such as anna:submit";
    let (name, role) = text.split_once(':').ok_or_else(wrong)?;
    let is_plain = |c: char| c.is_ascii_alphanumeric() || c == '-' || c == '_';
    let is_name = !name.is_empty() && name.len() <= 50 && name.chars().all(is_plain);
    let role = Role::of_name(role).filter(|_| is_name).ok_or_else(wrong)?;
    Ok((name.into(), role))
}
