//! Commands that ask a service: `crumple submit`, `jobs`, `watch`, `stop`, `resume` and `fetch`.

mod server;
mod stream;
mod upload;

use crate::cli::{FetchArgs, JobsArgs, OneJobArgs, ResumeArgs, StopArgs, SubmitArgs};
use crate::serve::api::{FileEntry, JobPage, ResumeRequest, ServiceJob, Submission};
use crate::stdout::{say, write};
use crumple_proto::exit_code::{BAD_INPUT, COMPLETED};
use server::Server;
use std::path::{Component, Path, PathBuf};

/// Outcome of a command: the exit code, or why it could not be carried out.
type CommandResult = Result<u8, String>;

fn code_of(ended: CommandResult) -> u8 {
    ended.unwrap_or_else(|why| {
        eprintln!("error: {why}");
        BAD_INPUT
    })
}

/// `crumple submit`. Returns the exit code.
pub fn submit(args: &SubmitArgs) -> u8 {
    let submitted = || -> CommandResult {
        let server = Server::find(&args.server)?;
        let files = upload::files(&args.job, &args.files)?;
        let options = Submission {
            name: args.name.clone().unwrap_or_default(),
            job: args.main.clone().unwrap_or_else(|| files.main.clone()),
            workers: Some(args.workers),
            launcher: args.launcher.clone().unwrap_or_default(),
            priority: args.priority,
            retries: Some(args.retries),
            set: args.set.clone(),
            check_only: args.check,
            ..Submission::default()
        };
        let job: ServiceJob = upload::send(&server, &options, &files)?;
        if !args.watch {
            say!("{}", job.id);
            return Ok(COMPLETED);
        }
        say!("job {}", job.id);
        stream::watch(&server, job.id)
    };
    code_of(submitted())
}

/// `crumple jobs`. Returns the exit code.
pub fn jobs(args: &JobsArgs) -> u8 {
    let listed = || -> CommandResult {
        let server = Server::find(&args.server)?;
        let state = args.state.iter().map(|state| format!("&state={}", server::escaped(state)));
        let path = format!("/api/jobs?limit={}{}", args.limit, state.collect::<String>());
        if args.json {
            write(format_args!("{}\n", server.get::<serde_json::Value>(&path)?));
            return Ok(COMPLETED);
        }
        let page: JobPage = server.get(&path)?;
        say!(
            "{:>6}  {:<10} {:>7}  {:<10} {:<12} name",
            "job",
            "state",
            "workers",
            "launcher",
            "owner"
        );
        for job in &page.jobs {
            let ServiceJob { id, name, owner, state, workers, launcher, reason, .. } = job;
            let why = if reason.is_empty() { String::new() } else { format!(" ({reason})") };
            say!(
                "{id:>6}  {:<10} {workers:>7}  {launcher:<10} {owner:<12} {name}{why}",
                state.name()
            );
        }
        if page.total > page.jobs.len() as i64 {
            say!("{} of {} jobs", page.jobs.len(), page.total);
        }
        Ok(COMPLETED)
    };
    code_of(listed())
}

/// `crumple watch`. Returns the exit code of the run.
pub fn watch(args: &OneJobArgs) -> u8 {
    let server = Server::find(&args.server);
    code_of(server.and_then(|server| stream::watch(&server, args.job)))
}

/// `crumple stop`. Returns the exit code.
pub fn stop(args: &StopArgs) -> u8 {
    let stopped = || -> CommandResult {
        let server = Server::find(&args.server)?;
        let path = format!("/api/jobs/{}/stop?force={}", args.job, args.force);
        let job: ServiceJob = server.post(&path, &serde_json::json!({}))?;
        let state = if job.stopping { "stopping" } else { job.state.name() };
        say!("job {}: {state}", job.id);
        Ok(COMPLETED)
    };
    code_of(stopped())
}

/// `crumple resume`. Returns the exit code.
pub fn resume(args: &ResumeArgs) -> u8 {
    let resumed = || -> CommandResult {
        let server = Server::find(&args.server)?;
        let change = ResumeRequest { workers: args.workers, set: args.set.clone() };
        let job: ServiceJob = server.post(&format!("/api/jobs/{}/resume", args.job), &change)?;
        say!("job {}: {}", job.id, job.state.name());
        Ok(COMPLETED)
    };
    code_of(resumed())
}

/// `crumple fetch`. Returns the exit code.
pub fn fetch(args: &FetchArgs) -> u8 {
    let fetched = || -> CommandResult {
        let server = Server::find(&args.server)?;
        let out =
            args.out.clone().unwrap_or_else(|| PathBuf::from(format!("out/job-{}", args.job)));
        let files: Vec<FileEntry> = server.get(&format!("/api/jobs/{}/files", args.job))?;
        let mut count = 0;
        for file in files.iter().filter(|file| file.path.starts_with(&args.only)) {
            let path = Path::new(&file.path);
            if !path.components().all(|part| matches!(part, Component::Normal(_))) {
                return Err(format!("{}: the service names a file outside its folder", file.path));
            }
            let url = format!("/api/jobs/{}/files/{}", args.job, server::escaped(&file.path));
            server.download(&url, &out.join(path))?;
            count += 1;
        }
        if count == 0 {
            return Err(format!("the job has no file whose path begins with {}", args.only));
        }
        say!("{count} files in {}", out.display());
        Ok(COMPLETED)
    };
    code_of(fetched())
}
