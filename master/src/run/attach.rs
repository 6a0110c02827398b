//! `crumple attach`: shows a run in progress on a terminal, and gives it orders.

use crate::cli::{AttachArgs, AttachOrder};
use crate::run::request::{Answer, Done, Progress, Request, Status};
use crate::run::service::socket;
use crate::stdout::{say, write};
use crumple_proto::exit_code::{BAD_INPUT, COMPLETED, WORKER_LOST};
use std::io::{BufRead, BufReader, ErrorKind, Write};
use std::os::unix::net::UnixStream;
use std::path::Path;
use std::time::{Duration, Instant};

/// Interval between two lines of progress.
const LINE_EVERY: Duration = Duration::from_secs(1);

/// Carries out the command and returns the exit code.
pub fn run(args: &AttachArgs) -> u8 {
    let ended = requests(&args.order).and_then(|requests| {
        let mut run = Connection::open(&args.dir)?;
        match &requests[..] {
            [Request::Watch] => run.watch(args.json),
            _ => requests.iter().try_fold(COMPLETED, |_, request| run.ask(request, args.json)),
        }
    });
    ended.unwrap_or_else(|why| {
        eprintln!("error: {why}");
        BAD_INPUT
    })
}

/// Returns the requests that an order stands for.
fn requests(order: &AttachOrder) -> Result<Vec<Request>, String> {
    let change = |set: &String| {
        let (key, value) = set
            .split_once('=')
            .ok_or_else(|| format!("{set}: give key=value, such as end_time=5"))?;
        let value = value.trim().parse().map_err(|_| format!("{set}: give a number"))?;
        Ok(Request::Set { key: key.trim().into(), value })
    };
    Ok(match order {
        AttachOrder { status: true, .. } => vec![Request::Status],
        AttachOrder { checkpoint: true, .. } => vec![Request::Checkpoint],
        AttachOrder { pause: true, .. } => vec![Request::Pause],
        AttachOrder { go_on: true, .. } => vec![Request::Continue],
        AttachOrder { stop: true, .. } => vec![Request::Stop],
        AttachOrder { set, .. } if !set.is_empty() => {
            set.iter().map(change).collect::<Result<_, String>>()?
        }
        _ => vec![Request::Watch],
    })
}

/// A connection to a run.
struct Connection<'a> {
    dir: &'a Path,
    stream: UnixStream,
    lines: BufReader<UnixStream>,
}

impl<'a> Connection<'a> {
    fn open(dir: &'a Path) -> Result<Self, String> {
        let shown = dir.display();
        if !dir.is_dir() {
            return Err(format!(
                "{shown}: no such folder; give the folder of results of a run, which is out/ and \
                 the name of its job, or that of --out"
            ));
        }
        let failed = |error: std::io::Error| match error.kind() {
            ErrorKind::NotFound if dir.join("summary.json").exists() => {
                format!("{shown}: no run is in progress; how the last one ended is in summary.json")
            }
            ErrorKind::NotFound => format!("{shown}: no run is in progress in this folder"),
            ErrorKind::ConnectionRefused => format!(
                "{shown}: the run does not answer: it was killed, or it runs on another machine; \
                 attach there, or continue it with: crumple run --resume {shown}"
            ),
            ErrorKind::PermissionDenied => {
                format!("{shown}: only the user who started the run may attach to it")
            }
            _ => format!("{shown}: {error}"),
        };
        let stream = socket::connect(dir).map_err(failed)?;
        let lines = stream.try_clone().map(BufReader::new).map_err(failed)?;
        Ok(Self { dir, stream, lines })
    }

    fn send(&mut self, request: &Request) -> Result<(), String> {
        // A run that has just ended shows in the answer.
        let _ = self.stream.write_all(request.to_line().as_bytes());
        Ok(())
    }

    /// Returns the next line of the run; `None` if it has gone.
    fn answer(&mut self) -> Option<(Answer, String)> {
        let mut line = String::new();
        let bytes = self.lines.read_line(&mut line).ok()?;
        let answer = serde_json::from_str(&line).ok()?;
        (bytes > 0).then_some((answer, line))
    }

    /// Sends a request and prints the answer.
    fn ask(&mut self, request: &Request, json: bool) -> Result<u8, String> {
        self.send(request)?;
        let shown = self.dir.display();
        let Some((answer, line)) = self.answer() else {
            return Err(format!("{shown}: the run has ended"));
        };
        match answer {
            Answer::Refused { why } => return Err(why),
            _ if json => write(format_args!("{line}")),
            Answer::Done(done) => show_done(&done),
            Answer::Status(status) => show_status(&status),
            Answer::View(_) | Answer::Progress(_) | Answer::Event { .. } | Answer::Ended { .. } => {
            }
        }
        Ok(COMPLETED)
    }

    /// Prints the stream until the run ends. Returns its exit code.
    fn watch(&mut self, json: bool) -> Result<u8, String> {
        self.send(&Request::Watch)?;
        let mut shown = None::<Instant>;
        while let Some((answer, line)) = self.answer() {
            if json {
                write(format_args!("{line}"));
            }
            match answer {
                Answer::Refused { why } => return Err(why),
                Answer::Ended { code, reason } => {
                    if !json {
                        say!("the run has ended: {reason}");
                    }
                    return Ok(code);
                }
                _ if json => {}
                Answer::View(_) => {}
                Answer::Status(status) => show_status(&status),
                Answer::Done(done) => show_done(&done),
                Answer::Event { text } => say!("{text}"),
                Answer::Progress(progress) => {
                    if shown.is_none_or(|shown| shown.elapsed() >= LINE_EVERY) {
                        shown = Some(Instant::now());
                        show_progress(&progress);
                    }
                }
            }
        }
        eprintln!("error: {}: the run was lost", self.dir.display());
        Ok(WORKER_LOST)
    }
}

fn show_done(done: &Done) {
    let note = if done.note.is_empty() { String::new() } else { format!("; {}", done.note) };
    say!("{}: cycle {}, time {:.6e}{note}", done.order, done.cycle, done.time);
}

fn show_status(status: &Status) {
    let Status { title, state, pid, workers, transport, settings, checkpoint, progress } = status;
    say!("{title}: {state}, process {pid}, {workers} workers ({transport})");
    for (key, value) in settings {
        say!("  {key} = {value:?}");
    }
    if let Some((cycle, time)) = checkpoint {
        say!("  newest checkpoint: cycle {cycle}, time {time:.6e}");
    }
    let e = progress.energy;
    say!(
        "  energy: kinetic {:.4e} internal {:.4e} hourglass {:.4e} contact work {:.4e} external \
         work {:.4e}",
        e.kinetic,
        e.internal,
        e.hourglass,
        e.contact,
        e.external
    );
    for (number, w) in progress.workers.iter().enumerate() {
        say!(
            "  worker {number}: {} elements, {} pairs, {:.3e} s per cycle, displacement {:.3e}, \
             {:.0} % of its margin",
            w.elements,
            w.pairs,
            w.load,
            w.displacement,
            100.0 * w.share
        );
    }
    show_progress(progress);
}

/// Prints a line of progress.
pub fn show_progress(p: &Progress) {
    let share = p.workers.iter().map(|w| w.share).fold(0.0, f64::max);
    let [low, high] = p.redecompositions;
    say!(
        "NC={:7} T={:10.4e} DT={:9.3e} ERR={:6.2}% pairs={} imbalance={:.2} margin={:.0}% \
         redecompositions={low} low, {high} high, elapsed {:.0} s",
        p.cycle,
        p.time,
        p.dt,
        100.0 * p.energy.error,
        p.pairs,
        p.imbalance,
        100.0 * share,
        p.wall_s
    );
}
