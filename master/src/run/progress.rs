//! What a user sees while a job runs: a bar on a terminal, plain lines elsewhere.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::time::{Duration, Instant};

/// Between plain lines, and between redraws of the bar.
const LINE_EVERY: Duration = Duration::from_secs(5);
const DRAW_EVERY: Duration = Duration::from_millis(200);
/// Ticks of the bar.
const TICKS: u64 = 10_000;

/// State of a run for people.
#[derive(Clone, Copy, Debug, Default)]
pub struct State {
    /// Cycles done.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Step [time].
    pub dt: f64,
    /// Energy error, a fraction.
    pub error: f64,
    /// Active pairs.
    pub pairs: u64,
    /// max/mean step cost.
    pub imbalance: f64,
}

/// Shows progress on standard error.
pub struct Progress {
    end_time: f64,
    began: Instant,
    last: Instant,
    bar: Option<ProgressBar>,
    quiet: bool,
}

impl Progress {
    /// Progress towards `end_time`; nothing is shown if `quiet`.
    pub fn new(end_time: f64, quiet: bool) -> Self {
        let bar = (!quiet && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(TICKS);
            let style = ProgressStyle::with_template("{bar:20} {percent:>3}% {wide_msg}");
            style.into_iter().for_each(|s| bar.set_style(s));
            bar
        });
        Self { end_time, began: Instant::now(), last: Instant::now(), bar, quiet }
    }

    /// Shows the state, if it is time to.
    pub fn show(&mut self, s: &State) {
        let every = if self.bar.is_some() { DRAW_EVERY } else { LINE_EVERY };
        if self.quiet || self.last.elapsed() < every {
            return;
        }
        self.last = Instant::now();
        let done = (s.time / self.end_time).clamp(0.0, 1.0);
        let elapsed = self.began.elapsed().as_secs_f64();
        let left = if done > 0.0 { clock(elapsed * (1.0 - done) / done) } else { "?".into() };
        let line = format!(
            "NC={:7} T={:10.4e} DT={:9.3e} ERR={:6.2}% pairs={} imbalance={:.2} elapsed {} remaining {left}",
            s.cycle,
            s.time,
            s.dt,
            100.0 * s.error,
            s.pairs,
            s.imbalance,
            clock(elapsed)
        );
        match &self.bar {
            Some(bar) => {
                bar.set_position((done * TICKS as f64) as u64);
                bar.set_message(line);
            }
            None => eprintln!("{line}"),
        }
    }

    /// Says something in between.
    pub fn println(&self, line: &str) {
        match &self.bar {
            Some(bar) => bar.println(line),
            None if !self.quiet => eprintln!("{line}"),
            None => {}
        }
    }

    /// Takes the bar away.
    pub fn finish(&self) {
        self.bar.iter().for_each(|b| b.finish_and_clear());
    }
}

/// Seconds as hours, minutes and seconds.
fn clock(seconds: f64) -> String {
    let s = seconds.max(0.0).round() as u64;
    if s >= 3600 {
        format!("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
    } else {
        format!("{}:{:02}", s / 60, s % 60)
    }
}
