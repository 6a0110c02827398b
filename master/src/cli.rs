//! Command line: commands and options.

pub mod pages;
mod service;

pub use service::{
    FetchArgs, JobsArgs, OneJobArgs, ResumeArgs, Role, ServeArgs, ServerArgs, StopArgs, SubmitArgs,
};

use clap::{Args, Parser, Subcommand};
use std::path::{Path, PathBuf};
use tracing::level_filters::LevelFilter;
use tracing_subscriber::EnvFilter;

/// Parallel explicit finite element solver for crash and impact.
#[derive(Debug, Parser)]
#[command(name = "crumple", version, after_help = EXIT_CODES)]
pub struct Cli {
    /// Command to run.
    #[command(subcommand)]
    pub command: Command,
}

const EXIT_CODES: &str = "Exit codes: 0 completed; 1 completed, but a requirement of the job is \
not met; 2 bad input; 3 numerical failure (last good state kept); 4 a worker was lost; 130 stopped \
by the user (state kept).";

/// Default size of the largest d3plot file [MB].
pub const D3PLOT_FILE_SIZE: u64 = 256;

const SET_HELP: &str = "Change a key of the job: section.key=value, such as time.safety=0.8, \
scene.refine=2, end_time=5, part.rail.thickness=3. Give a part by name or id, a material or wall \
by name, an entry of another list by its position from 0. Values are written as in the job; words \
need no quotes. Units are those of the job. May be given several times";

/// Commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a job.
    ///
    /// Workers are threads of this process. Under mpirun, rank 0 is the master and all other ranks
    /// are workers.
    Run(RunArgs),
    /// Watch a run in progress, or give it an order.
    ///
    /// Without an option, prints the state of the run and then its progress, redecompositions,
    /// warnings and orders until it ends; the exit code is then that of the run. An order takes
    /// effect in a cycle on which all workers agree; the command waits for it and prints the cycle.
    Attach(AttachArgs),
    /// Serve jobs to a browser and to the commands submit, jobs, watch, stop, resume and fetch.
    ///
    /// Keeps a queue of jobs in a folder and starts them on this machine, by mpirun or by Slurm.
    /// Prints its address with a token. When it ends, in whatever way, jobs that run go on; the
    /// next start finds them.
    Serve(ServeArgs),
    /// Submit a job to a service, and print its number.
    Submit(SubmitArgs),
    /// List the jobs of a service, the newest first.
    Jobs(JobsArgs),
    /// Show the progress of a job of a service until it ends; the exit code is then that of the
    /// run.
    Watch(OneJobArgs),
    /// Stop a job of a service. One that runs writes a checkpoint.
    Stop(StopArgs),
    /// Continue a job of a service from its newest checkpoint, or start one that was only checked.
    Resume(ResumeArgs),
    /// Copy files of a job from a service.
    Fetch(FetchArgs),
    /// Check a job without running it: mass, parts, time step, mesh quality, memory, warnings.
    Check(CheckArgs),
    /// Run the catalogue of verification cases against exact, published and computed references.
    ///
    /// Writes one line for each case as VERIFICATION.md, the table of all rows as
    /// VERIFICATION_ROWS.md, verification.json, and every job that was run. Exit
    /// code 3 if a case is outside its tolerance.
    Verify(VerifyArgs),
    /// Run a job over a grid of settings: a table and charts of errors and costs.
    ///
    /// Continues where an earlier call with the same folder stopped.
    Study(StudyArgs),
    /// Time the scenes of the benchmark: nanoseconds per element and cycle, by phase.
    ///
    /// The table also shows what the core could have computed in each time, measured in the same
    /// rounds.
    Bench(BenchArgs),
    /// Predict the parallel efficiency of a job on any number of workers.
    ///
    /// Decomposes the mesh for each number of workers, and counts the elements, ghosts and messages
    /// of each worker. Costs are measured on this machine; the network is not. Results for more
    /// than two workers are therefore modelled.
    Scale(ScaleArgs),
    /// Make report.html in a folder of results: animation, plots, tables and warnings on one page.
    ///
    /// `crumple run` does this at its end. This command makes the page again, from the files in the
    /// folder only. The page opens from disk, without a network. Runs that failed or were stopped
    /// are accepted. With a second folder it makes compare.html in the first one: both runs in
    /// step, with their plots laid over each other.
    Report {
        /// Folder of results.
        dir: PathBuf,
        /// Folder of a second run, to compare.
        second: Option<PathBuf>,
    },
    /// Write a job for a mesh file of another program, and print what became of its content.
    ///
    /// Reads Gmsh MSH 4.1 and 2.2, Abaqus input, Nastran bulk data, VTK (XML and legacy), STL and
    /// EXODUS II; the format is recognised by the content. The folder gets a copy of the file and a
    /// job.toml with its parts, materials and sections. Values that the file does not have are
    /// placeholders: the job lists them, and `crumple check` warns of each. A Radioss starter file
    /// with parts becomes a job that names it as its deck.
    Import(ImportArgs),
    /// Write a job as an LS-DYNA keyword deck that gives the same results when it is read back.
    ExportDeck(ExportArgs),
    /// Write a deck or a job as a deck of LS-DYNA or Radioss, with a list of what is lost.
    ///
    /// The ending of the second file chooses the format: .k, .key and .dyn for LS-DYNA, _0000.rad
    /// for Radioss, whose engine file (_0001.rad) is written next to it. The list of losses is
    /// printed, and written next to the deck: requests that have another form here, and keys that
    /// the format has no card for. Such keys stay in comments that only Crumple reads.
    Convert(ConvertArgs),
    /// Write the fields of a run as a d3plot database, for post-processors that read it.
    ExportD3plot {
        /// Folder of results of a run with fields.
        dir: PathBuf,
        /// Largest file of the family, unless one state needs more [MB].
        #[arg(long, value_name = "MB", default_value_t = D3PLOT_FILE_SIZE)]
        file_size: u64,
        /// Also write strains: of solids, and of shells at both surfaces, from the positions of
        /// their nodes.
        #[arg(long)]
        strains: bool,
    },
    /// Write the histories of a run as LS-DYNA's binary time histories (binout), for scripts and
    /// post-processors that read them.
    ExportBinout {
        /// Folder of results of a run.
        dir: PathBuf,
    },
    /// Write the fields of a run as one temporal VTKHDF file; needs a build with `--features
    /// vtkhdf`.
    ExportVtkhdf {
        /// Folder of results of a run with fields.
        dir: PathBuf,
    },
    /// Write the fields of a run as an EXODUS II file, for ParaView and other post-processors.
    ExportExodus {
        /// Folder of results of a run with fields.
        dir: PathBuf,
    },
    /// Run the job of a folder of results again, and compare the final states.
    ///
    /// Prints PASS if they are equal to the bit, on any number of workers; otherwise FAIL, with the
    /// exit code 1. If a file that the run has read was changed since, names it and runs nothing.
    Reproduce(ReproduceArgs),
    /// Find where the results of two runs part, and the largest difference of each quantity.
    ///
    /// Compares what both folders have: histories, checkpoints and fields. Names the first cycle,
    /// node and element that differ. Exit code 1 if there is a difference.
    Diff(DiffArgs),
    /// Write an example job into a folder; without a name, list the examples.
    Init(InitArgs),
    /// Print completions of the command line for a shell.
    ///
    /// For bash: crumple completions bash > ~/.local/share/bash-completion/completions/crumple
    Completions {
        /// Shell.
        shell: clap_complete::Shell,
    },
    /// Write the manual pages of all commands into a folder, for `man`.
    Manual {
        /// Folder for the pages.
        dir: PathBuf,
    },
    /// Print the JSON Schema of job files, for editors.
    Schema(SchemaArgs),
    /// List the materials of the library, for `use` in a material of a job, with the source of each
    /// value.
    Materials(MaterialsArgs),
    /// Report the warnings of a run, and what it did not need, part by part, with the settings.
    Advise {
        /// Folder of results of a run that completed.
        dir: PathBuf,
    },
}

/// Job, and changes to it.
#[derive(Args, Clone, Debug)]
pub struct JobArgs {
    /// A .toml job file, a folder with job.toml, or a deck of LS-DYNA (.k, .key, .dyn) or Radioss
    /// (_0000.rad).
    pub job: PathBuf,
    /// Workers, and changes of the job.
    #[command(flatten)]
    pub options: JobOptions,
}

/// Workers, and changes of the job.
#[derive(Args, Clone, Debug, Default)]
pub struct JobOptions {
    /// Number of workers, at least 1 [default: parallel.workers of the job, else one per core, or
    /// per --threads cores; under mpirun, ranks - 1].
    #[arg(long, value_name = "N", value_parser = workers)]
    pub workers: Option<usize>,
    /// Number of threads of each worker, which share its loops [default: parallel.threads of the
    /// job, else 1].
    #[arg(long, value_name = "N", value_parser = threads)]
    pub threads: Option<usize>,
    #[arg(long = "set", value_name = "KEY=VALUE", help = SET_HELP)]
    set: Vec<String>,
    /// Ignore unsupported content of a deck or a mesh file instead of failing; summary.json lists
    /// it.
    #[arg(long)]
    pub allow_unsupported: bool,
    /// Case of a deck that has several (*CASE).
    #[arg(long, value_name = "N")]
    pub case: Option<u64>,
    /// Refuse to read files of the job outside this folder: meshes, decks and what they include.
    #[arg(long, value_name = "DIR")]
    pub within: Option<PathBuf>,
}

/// `crumple check`.
#[derive(Args, Clone, Debug)]
pub struct CheckArgs {
    /// The job.
    #[command(flatten)]
    pub job: JobArgs,
    /// Also find the largest stable step of the assembled system (elements, springs, ties, active
    /// penalty contact), at the start. With --step=T, run the job to time T first, on one worker.
    /// Exit code 3 if the step in use is larger.
    #[arg(long, value_name = "T", num_args = 0..=1, require_equals = true)]
    #[arg(default_missing_value = "0", value_parser = moment)]
    pub step: Option<f64>,
    /// Simulated time at which the run would end, as for `crumple run`.
    #[arg(long, value_name = "T", value_parser = time, allow_negative_numbers = true)]
    pub end_time: Option<f64>,
    /// Print one object of JSON: the findings with file, line, column and the text of the line,
    /// the estimated memory, and the text that is printed without this option.
    #[arg(long, conflicts_with = "step")]
    pub json: bool,
    /// Also make a page that shows the model in a browser: boundary conditions, walls, sets,
    /// thickness, time steps, mesh quality, initial penetrations, parts, cost and findings. Give
    /// the job before this option [default file: the name of the job and -check.html].
    #[arg(long, value_name = "FILE", num_args = 0..=1)]
    pub html: Option<Option<PathBuf>>,
}

/// `crumple reproduce`.
#[derive(Args, Clone, Debug)]
pub struct ReproduceArgs {
    /// Folder of results of a run that has ended.
    pub dir: PathBuf,
    /// Number of workers [default: that of the run, at most one per core].
    #[arg(long, value_name = "N", value_parser = workers)]
    pub workers: Option<usize>,
    /// Folder for the new results [default: that of the run with -reproduced].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Remove the results that are in the folder for the new results.
    #[arg(long, visible_alias = "force")]
    pub overwrite: bool,
    /// Run the job also if a file that the run has read was changed since.
    #[arg(long)]
    pub allow_changed: bool,
    /// Print only the verdict and errors.
    #[arg(long)]
    pub quiet: bool,
}

impl ReproduceArgs {
    /// Returns the folder for the new results.
    pub fn out_dir(&self) -> PathBuf {
        let dir = std::fs::canonicalize(&self.dir).unwrap_or_else(|_| self.dir.clone());
        let mut name = dir.file_name().unwrap_or_default().to_owned();
        name.push("-reproduced");
        self.out.clone().unwrap_or_else(|| self.dir.join("..").join(name))
    }
}

/// `crumple init`.
#[derive(Args, Clone, Debug)]
pub struct InitArgs {
    /// Name of the example.
    pub example: Option<String>,
    /// Folder for the job [default: the name of the example].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

/// `crumple diff`.
#[derive(Args, Clone, Debug)]
pub struct DiffArgs {
    /// Folder of results.
    pub first: PathBuf,
    /// Folder of results to compare with.
    pub second: PathBuf,
    /// Run both jobs again, side by side, until they part: names the exact cycle, and the nodes and
    /// elements that differ after it, with all digits. Writes no files.
    #[arg(long)]
    pub rerun: bool,
}

/// `crumple run`.
#[derive(Args, Clone, Debug, Default)]
pub struct RunArgs {
    /// A .toml job file, a folder with job.toml, or a deck (.k, .key, .dyn, _0000.rad). With
    /// --resume, the job of the checkpoint if it was moved.
    #[arg(required_unless_present = "resume")]
    pub job: Option<PathBuf>,
    /// Workers, and changes of the job.
    #[command(flatten)]
    pub options: JobOptions,
    /// Continue the run in this folder, or the one of this checkpoint, from its newest whole
    /// checkpoint. Results are as if it had never ended, on any number of workers.
    #[arg(long, value_name = "DIR", conflicts_with = "out")]
    pub resume: Option<PathBuf>,
    /// Start again from the newest checkpoint if the run is lost: a worker or a host fails, or the
    /// process is killed. Gives up after N failures, or if there was no new checkpoint between two.
    #[arg(long, value_name = "N")]
    pub retries: Option<u32>,
    /// With --retries, start the run by this command, such as "mpirun -n 5". In it, {ranks} stands
    /// for the number of workers plus 1. After two losses without a new checkpoint between them, a
    /// run that is started with {ranks} continues with half as many workers.
    #[arg(long, value_name = "COMMAND", requires = "retries")]
    pub launcher: Option<String>,
    /// Folder for results [default: out/ and the name of the job].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Remove the results that are in the folder for results, with the checkpoints of an unfinished
    /// run. Without this option, a folder with results is refused.
    #[arg(long, visible_alias = "force", conflicts_with = "resume")]
    pub overwrite: bool,
    /// Simulated time at which the run ends, in the units of the job [default: end_time of the
    /// job].
    #[arg(long, value_name = "T", value_parser = time, allow_negative_numbers = true)]
    pub end_time: Option<f64>,
    /// Print only errors.
    #[arg(long)]
    pub quiet: bool,
    /// Also print each redecomposition, with its cause.
    #[arg(long, short, conflicts_with = "quiet")]
    pub verbose: bool,
    /// Repeat the orders of this file in their cycles: a summary.json of a run that was steered by
    /// `crumple attach`, or a list of orders. With the job of that run, the results have the same
    /// bits.
    #[arg(long, value_name = "FILE")]
    pub steering: Option<PathBuf>,
    /// Write a time line of all workers, by phase, for chrome://tracing or ui.perfetto.dev.
    #[arg(long, value_name = "FILE")]
    pub trace: Option<PathBuf>,
    /// Write spans and events of each rank to logs/rank_0000.log (the master), logs/rank_0001.log
    /// and so on. LEVEL is error, warn, info, debug (orders and renewals) or trace (phases of each
    /// step), or a list as in RUST_LOG, such as info,crumple_worker=debug [default: RUST_LOG; none
    /// without it].
    #[arg(long, value_name = "LEVEL", value_parser = directives)]
    pub log: Option<String>,
    /// Do not make report.html at the end.
    #[arg(long)]
    pub no_report: bool,
    /// Create this file with the number of the process, hold its lock, and add the exit code at the
    /// end. If the file exists, nothing is run: `crumple serve` starts no job twice.
    #[arg(long, value_name = "FILE")]
    pub attempt: Option<PathBuf>,
    /// File of the attempt of the supervisor that starts this process. If the supervisor has ended,
    /// nothing is run.
    #[arg(long, value_name = "FILE", hide = true)]
    pub under: Option<PathBuf>,
}

/// `crumple attach`.
#[derive(Args, Clone, Debug)]
pub struct AttachArgs {
    /// Folder of results of the run.
    pub dir: PathBuf,
    /// The order.
    #[command(flatten)]
    pub order: AttachOrder,
    /// Print the answers of the run as they are, one line of JSON each.
    #[arg(long)]
    pub json: bool,
}

/// Order of `crumple attach`.
#[derive(Args, Clone, Debug, Default)]
#[group(multiple = false)]
pub struct AttachOrder {
    /// Print the state of the run and of its workers.
    #[arg(long)]
    pub status: bool,
    /// Write a checkpoint. The run continues.
    #[arg(long)]
    pub checkpoint: bool,
    /// Hold the run between two cycles.
    #[arg(long)]
    pub pause: bool,
    /// Go on with a run that is paused.
    #[arg(long = "continue")]
    pub go_on: bool,
    /// Stop the run with complete output and a checkpoint, as SIGTERM does.
    #[arg(long)]
    pub stop: bool,
    /// Change a setting of the run: end_time, output.field_interval, output.history_interval,
    /// parallel.imbalance or parallel.low_every_at_least. May be given several times.
    #[arg(long, value_name = "KEY=VALUE")]
    pub set: Vec<String>,
}

/// `crumple schema`.
#[derive(Args, Clone, Debug)]
pub struct SchemaArgs {
    /// Print the reference of jobs as Markdown instead: cases/REFERENCE.md.
    #[arg(long)]
    pub reference: bool,
}

/// `crumple materials`.
#[derive(Args, Clone, Debug)]
pub struct MaterialsArgs {
    /// Name of a material, such as "steel DP600" [default: all].
    pub material: Option<String>,
    /// Units of the values, as in a job.
    #[arg(long, value_name = "UNITS", default_value = "m, s, kg")]
    pub units: String,
}

/// `crumple verify`.
#[derive(Args, Clone, Debug)]
pub struct VerifyArgs {
    /// Run only these entries of the catalogue, such as A01,C02.
    #[arg(long, value_name = "ID", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Run only the quick cases, a second or two each.
    #[arg(long)]
    pub quick: bool,
    /// Folder for the table and the jobs.
    #[arg(long, value_name = "DIR", default_value = "out/verify")]
    pub out: PathBuf,
}

/// `crumple study`.
#[derive(Args, Clone, Debug)]
pub struct StudyArgs {
    /// Study, a .toml file.
    pub study: PathBuf,
    /// Folder for results [default: out/studies/ and the name of the study].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Number of points that run at the same time; with more than one, their CPU times disturb each
    /// other.
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = jobs)]
    pub jobs: usize,
    /// Run all points again. Otherwise, points that this version of the program has completed are
    /// kept, and the charts are drawn again.
    #[arg(long)]
    pub fresh: bool,
}

/// `crumple bench`.
#[derive(Args, Clone, Debug)]
pub struct BenchArgs {
    /// Run only these scenes, such as "tube,hex-bar".
    #[arg(long, value_name = "NAME", value_delimiter = ',')]
    pub only: Vec<String>,
    /// Number of times that every scene is timed.
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = jobs)]
    pub rounds: usize,
    /// Run a few cycles of every scene, once, only to show that all of them run.
    #[arg(long)]
    pub tiny: bool,
    /// Do not time the scenes: list the data that a step of each reads and writes, in bytes per
    /// element.
    #[arg(long, conflicts_with_all = ["tiny", "rounds"])]
    pub traffic: bool,
    /// File for all values.
    #[arg(long, value_name = "FILE")]
    pub json: Option<PathBuf>,
}

/// `crumple scale`.
#[derive(Args, Clone, Debug)]
pub struct ScaleArgs {
    /// A .toml job file, or a folder with job.toml.
    pub job: PathBuf,
    /// Numbers of workers, each at least 2 [default: 2,4,8,... to 1024, at most the number of
    /// elements].
    #[arg(long, value_name = "N,...", value_delimiter = ',', value_parser = several)]
    pub workers: Vec<usize>,
    /// Simulated times of the predictions, in the units of the job. One worker runs the job to
    /// these times.
    #[arg(long, value_name = "T,...", value_delimiter = ',')]
    #[arg(value_parser = moment, default_value = "0")]
    pub at: Vec<f64>,
    /// Latency of a message, such as 1.5us.
    #[arg(long, value_name = "TIME", value_parser = latency, default_value = "2us")]
    pub latency: f64,
    /// Bandwidth of the connection of a worker, such as 10GB/s.
    #[arg(long, value_name = "RATE", value_parser = bandwidth, default_value = "10GB/s")]
    pub bandwidth: f64,
    /// Folder for the table and the chart [default: out/, the name of the job, and scale].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Changes to the job.
    #[arg(long = "set", value_name = "KEY=VALUE", help = SET_HELP)]
    pub set: Vec<String>,
}

/// `crumple import`.
#[derive(Args, Clone, Debug)]
pub struct ImportArgs {
    /// Mesh file.
    pub file: PathBuf,
    /// Folder for the job [default: the name of the file without its extension].
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Leave out content that is not supported, such as elements of second order, instead of
    /// failing.
    #[arg(long)]
    pub allow_unsupported: bool,
}

/// `crumple convert`.
#[derive(Args, Clone, Debug)]
pub struct ConvertArgs {
    /// A deck, a .toml job file, or a folder with job.toml.
    pub from: PathBuf,
    /// File for the deck: NAME_0000.rad, or NAME.k.
    pub to: PathBuf,
    /// Replace files that exist.
    #[arg(long, visible_alias = "force")]
    pub overwrite: bool,
    /// Changes to the job.
    #[arg(long = "set", value_name = "KEY=VALUE", help = SET_HELP)]
    pub set: Vec<String>,
}

/// `crumple export-deck`.
#[derive(Args, Clone, Debug)]
pub struct ExportArgs {
    /// A .toml job file, a folder with job.toml, or a deck.
    pub job: PathBuf,
    /// File for the deck [default: standard output].
    #[arg(long, value_name = "FILE")]
    pub out: Option<PathBuf>,
    /// Replace the file. Without this option, a file that exists is refused.
    #[arg(long, visible_alias = "force")]
    pub overwrite: bool,
    /// Changes to the job.
    #[arg(long = "set", value_name = "KEY=VALUE", help = SET_HELP)]
    pub set: Vec<String>,
}

impl ScaleArgs {
    /// Returns the folder for results.
    pub fn out_dir(&self) -> PathBuf {
        self.out
            .clone()
            .unwrap_or_else(|| PathBuf::from("out").join(name_of(&self.job)).join("scale"))
    }
}

impl JobOptions {
    /// Returns options with this number of workers and these `key=value`.
    pub fn new(workers: Option<usize>, set: Vec<String>) -> Self {
        Self { workers, set, ..Self::default() }
    }

    /// Returns all `key=value`, in order.
    pub fn sets(&self) -> Vec<String> {
        let allowed = self.allow_unsupported.then(|| "mesh.allow_unsupported=true".to_string());
        let case = self.case.map(|case| format!("mesh.case={case}"));
        let threads = self.threads.map(|threads| format!("parallel.threads={threads}"));
        self.set.iter().cloned().chain(allowed).chain(case).chain(threads).collect()
    }

    /// Returns all `key=value`, in order, with the time at which the run ends as the last.
    fn sets_until(&self, end_time: Option<f64>) -> Vec<String> {
        let end_time = end_time.map(|t| format!("end_time={t:?}"));
        self.sets().into_iter().chain(end_time).collect()
    }
}

impl CheckArgs {
    /// Returns all `key=value`, in order, `--end-time` as the last.
    pub fn sets(&self) -> Vec<String> {
        self.job.options.sets_until(self.end_time)
    }

    /// Returns the file for the page, if one is asked for.
    pub fn page(&self) -> Option<PathBuf> {
        let default = || {
            let mut name = name_of(&self.job.job).into_os_string();
            name.push("-check.html");
            PathBuf::from(name)
        };
        self.html.as_ref().map(|file| file.clone().unwrap_or_else(default))
    }
}

impl RunArgs {
    /// Returns all `key=value`, in order, `--end-time` as the last.
    pub fn sets(&self) -> Vec<String> {
        self.options.sets_until(self.end_time)
    }

    /// Returns the options that a supervised run gets, except for folders and workers. One that
    /// continues from its own checkpoint gets no changes of the job: the checkpoint has them.
    pub fn passed_on(&self, without_changes: bool) -> Vec<String> {
        let mut words = Vec::new();
        if !without_changes {
            words.extend(self.sets().into_iter().flat_map(|set| ["--set".to_string(), set]));
        }
        if let Some(folder) = &self.options.within {
            words.extend(["--within".to_string(), folder.to_string_lossy().into_owned()]);
        }
        if let Some(trace) = &self.trace {
            words.extend(["--trace".to_string(), trace.to_string_lossy().into_owned()]);
        }
        if let Some(plan) = &self.steering {
            words.extend(["--steering".to_string(), plan.to_string_lossy().into_owned()]);
        }
        if let Some(attempt) = &self.attempt {
            words.extend(["--under".to_string(), attempt.to_string_lossy().into_owned()]);
        }
        if let Some(level) = &self.log {
            words.extend(["--log".to_string(), level.clone()]);
        }
        let flags =
            [("--quiet", self.quiet), ("--verbose", self.verbose), ("--no-report", self.no_report)];
        words.extend(flags.iter().filter(|f| f.1).map(|f| f.0.to_string()));
        words
    }

    /// Returns the folder for results: the given one, otherwise `out/` and the name of the job file
    /// or, for `job.toml`, of its folder.
    pub fn out_dir(&self) -> PathBuf {
        if let Some(out) = &self.out {
            return out.clone();
        }
        PathBuf::from("out").join(name_of(self.job.as_deref().unwrap_or(Path::new("job"))))
    }
}

/// Returns the name of a job: that of its file or, for `job.toml`, of its folder.
fn name_of(job: &Path) -> PathBuf {
    let job = std::fs::canonicalize(job).unwrap_or_else(|_| job.to_owned());
    let named_by_folder = job.file_name().is_some_and(|name| name == "job.toml");
    let name = match named_by_folder {
        true => job.parent().and_then(|folder| folder.file_name()),
        false if job.is_dir() => job.file_name(),
        false => job.file_stem(),
    };
    PathBuf::from(name.unwrap_or("job".as_ref()))
}

/// Checks the directives of `--log`: a level, or targets with levels as in `RUST_LOG`.
///
/// # Errors
/// A directive is wrong; the message names the levels.
fn directives(text: &str) -> Result<String, String> {
    let hint = "give off, error, warn, info, debug or trace, or targets with levels, such as \
                info,crumple_worker=debug";
    // `EnvFilter` takes an unknown level for the name of a target.
    let known = text.split(',').all(|directive| {
        directive.contains(['=', '[', ':', '_']) || directive.parse::<LevelFilter>().is_ok()
    });
    match EnvFilter::try_new(text) {
        Ok(_) if known && !text.is_empty() => Ok(text.into()),
        Ok(_) => Err(hint.into()),
        Err(error) => Err(format!("{error}; {hint}")),
    }
}

fn workers(text: &str) -> Result<usize, String> {
    match text.parse() {
        Ok(0) => Err("0 workers cannot run a job; omit --workers for one per core".into()),
        Ok(n) => Ok(n),
        Err(_) => Err("give a whole number from 1".into()),
    }
}

fn threads(text: &str) -> Result<usize, String> {
    let count = text.parse().ok().filter(|n| (1..=1024).contains(n));
    count.ok_or_else(|| "give the threads of each worker: a whole number from 1 to 1024".into())
}

fn several(text: &str) -> Result<usize, String> {
    text.parse()
        .ok()
        .filter(|n| *n > 1)
        .ok_or_else(|| "give whole numbers from 2, such as 2,4,8".into())
}

fn moment(text: &str) -> Result<f64, String> {
    let time = text.parse::<f64>().ok().filter(|t| t.is_finite() && *t >= 0.0);
    time.ok_or_else(|| "give times from 0 in the job's units, such as 0,20".into())
}

/// Parses a time in seconds.
fn latency(text: &str) -> Result<f64, String> {
    let units = [("ns", 1e-9), ("us", 1e-6), ("ms", 1e-3), ("s", 1.0)];
    with_unit(text, &units)
        .filter(|t| *t >= 0.0)
        .ok_or_else(|| "give a time with ns, us, ms or s, such as 2us".into())
}

/// Parses a rate in bytes per second.
fn bandwidth(text: &str) -> Result<f64, String> {
    let units = [("GB/s", 1e9), ("MB/s", 1e6)];
    with_unit(text, &units)
        .filter(|r| *r > 0.0)
        .ok_or_else(|| "give a rate with GB/s or MB/s, such as 10GB/s".into())
}

/// Parses a finite number followed by one of the units.
fn with_unit(text: &str, units: &[(&str, f64)]) -> Option<f64> {
    let (number, factor) =
        units.iter().find_map(|(unit, factor)| Some((text.strip_suffix(unit)?, factor)))?;
    number.trim().parse::<f64>().ok().filter(|n| n.is_finite()).map(|n| n * factor)
}

fn jobs(text: &str) -> Result<usize, String> {
    text.parse().ok().filter(|n| *n > 0).ok_or_else(|| "give a whole number from 1".into())
}

fn time(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(t) if t.is_finite() && t > 0.0 => Ok(t),
        _ => Err("give a time above 0 in the job's units".into()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn levels_and_targets_are_accepted_and_misspelt_ones_are_not() {
        for good in
            ["off", "error", "trace", "DEBUG", "info,crumple_worker=debug", "warn,[run]=info"]
        {
            assert_eq!(directives(good), Ok(good.into()));
        }
        for bad in ["", "debgu", "info,tracee", "crumple_worker=loud"] {
            let why = directives(bad).unwrap_err();
            assert!(why.contains("trace"), "{bad}: {why}");
        }
    }
    use clap::CommandFactory;

    #[test]
    fn the_command_line_is_consistent() {
        Cli::command().debug_assert();
    }

    #[test]
    fn sets_come_in_order_with_the_end_time_last() {
        let line = "crumple run x.toml --set a=1 --end-time 1e-3 --set b=2 --workers 3";
        let Command::Run(args) = Cli::parse_from(line.split(' ')).command else { panic!() };
        assert_eq!(args.sets(), ["a=1", "b=2", "end_time=0.001"]);
        assert_eq!((args.options.workers, args.out_dir()), (Some(3), PathBuf::from("out/x")));
    }

    #[test]
    fn bad_numbers_are_refused_with_exit_code_2() {
        for line in [
            "check x --workers 0",
            "check x --workers -1",
            "run x --end-time nan",
            "run x --end-time -1",
            "run x --end-time 0",
            "scale x --workers 1,2",
            "scale x --at -1",
            "scale x --latency 2",
            "scale x --latency infus",
            "scale x --bandwidth 0GB/s",
        ] {
            let error = Cli::try_parse_from(format!("crumple {line}").split(' ')).unwrap_err();
            assert_eq!(error.exit_code(), 2, "{line}");
        }
    }
}
