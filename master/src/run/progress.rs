//! Progress of a run on the terminal: a bar, or plain lines if the output is no terminal. A program
//! that runs a job in its own process asks a [`ProgressFeed`] instead.

use indicatif::{ProgressBar, ProgressStyle};
use std::io::IsTerminal;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

/// Interval between plain lines, and interval between updates of the bar.
const LINE_EVERY: Duration = Duration::from_secs(5);
const DRAW_EVERY: Duration = Duration::from_millis(200);
/// Number of ticks of the bar.
const TICKS: u64 = 10_000;

/// State of a run as it is displayed.
#[derive(Clone, Copy, Debug, Default)]
pub struct RunState {
    /// Number of cycles done.
    pub cycle: u64,
    /// Simulated time [time].
    pub time: f64,
    /// Step size [time].
    pub dt: f64,
    /// Energy error as a fraction.
    pub error: f64,
    /// Number of active pairs.
    pub pairs: u64,
    /// Critical path over the mean CPU time of the workers.
    pub imbalance: f64,
}

/// Reader of the progress of a run.
#[derive(Clone, Debug)]
pub enum Audience {
    /// Standard error.
    Terminal,
    /// Standard error, with each redecomposition.
    VerboseTerminal,
    /// No reader.
    Silent,
    /// Another thread of this process.
    Thread(ProgressFeed),
}

/// Progress of a run for another thread of this process.
#[derive(Clone, Debug, Default)]
pub struct ProgressFeed(Arc<Mutex<FeedContent>>);

/// State and messages for a thread.
#[derive(Clone, Debug, Default)]
pub struct FeedContent {
    /// The last state.
    pub state: RunState,
    /// End of the run [time]; 0 before it has begun.
    pub end_time: f64,
    /// Messages since the last question.
    pub messages: Vec<String>,
}

impl ProgressFeed {
    /// Returns the last state, and the messages since the last call.
    pub fn take(&self) -> FeedContent {
        self.change(|content| {
            let messages = std::mem::take(&mut content.messages);
            FeedContent { messages, ..*content }
        })
    }

    /// Adds a message.
    pub fn say(&self, message: &str) {
        self.change(|content| content.messages.push(message.into()));
    }

    fn change<T>(&self, change: impl FnOnce(&mut FeedContent) -> T) -> T {
        change(&mut self.0.lock().unwrap_or_else(PoisonError::into_inner))
    }
}

/// Progress display on standard error, or for another thread.
pub struct ProgressDisplay {
    end_time: f64,
    began: Instant,
    last: Instant,
    bar: Option<ProgressBar>,
    audience: Audience,
}

impl ProgressDisplay {
    /// Creates the display for a run to `end_time`.
    pub fn new(end_time: f64, audience: Audience) -> Self {
        let on_terminal = matches!(audience, Audience::Terminal | Audience::VerboseTerminal);
        let bar = (on_terminal && std::io::stderr().is_terminal()).then(|| {
            let bar = ProgressBar::new(TICKS);
            let style = ProgressStyle::with_template("{bar:20} {percent:>3}% {wide_msg}");
            style.into_iter().for_each(|s| bar.set_style(s));
            bar
        });
        Self { end_time, began: Instant::now(), last: Instant::now(), bar, audience }
    }

    /// Changes the end of the run.
    pub fn set_end_time(&mut self, end_time: f64) {
        self.end_time = end_time;
    }

    /// Shows the state, if the interval has passed.
    pub fn show(&mut self, s: &RunState) {
        match &self.audience {
            Audience::Terminal | Audience::VerboseTerminal => {}
            Audience::Silent => return,
            Audience::Thread(feed) => {
                feed.change(|content| (content.state, content.end_time) = (*s, self.end_time));
                return;
            }
        }
        let every = if self.bar.is_some() { DRAW_EVERY } else { LINE_EVERY };
        if self.last.elapsed() < every {
            return;
        }
        self.last = Instant::now();
        let done = (s.time / self.end_time).clamp(0.0, 1.0);
        let elapsed = self.began.elapsed().as_secs_f64();
        let left = if done > 0.0 { clock(elapsed * (1.0 - done) / done) } else { "?".into() };
        let line = format!(
            "NC={:7} T={:10.4e} DT={:9.3e} ERR={:6.2}% pairs={} imbalance={:.2} \
             elapsed {} remaining {left}",
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

    /// Prints a line without disturbing the bar.
    pub fn println(&self, line: &str) {
        match (&self.bar, &self.audience) {
            (Some(bar), _) => bar.println(line),
            (None, Audience::Terminal | Audience::VerboseTerminal) => eprintln!("{line}"),
            (None, Audience::Thread(feed)) => feed.say(line),
            (None, Audience::Silent) => {}
        }
    }

    /// Prints a line for readers of details.
    pub fn print_detail(&self, line: &str) {
        if matches!(self.audience, Audience::VerboseTerminal) {
            self.println(line);
        }
    }

    /// Removes the bar.
    pub fn finish(&self) {
        self.bar.iter().for_each(|b| b.finish_and_clear());
    }
}

/// Formats seconds as hours, minutes and seconds.
fn clock(seconds: f64) -> String {
    let s = seconds.max(0.0).round() as u64;
    if s >= 3600 {
        format!("{}:{:02}:{:02}", s / 3600, s / 60 % 60, s % 60)
    } else {
        format!("{}:{:02}", s / 60, s % 60)
    }
}
