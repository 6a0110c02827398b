//! A client of a run in progress.

use crate::program::Running;
use crumple::run::request::{Answer, Done, Request, Status};
use crumple::run::service::socket;
use std::io::{BufRead, BufReader, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

/// Longest wait for an answer.
const LIMIT: Duration = Duration::from_secs(120);

/// A connection to a run.
pub struct Client {
    stream: UnixStream,
    lines: BufReader<UnixStream>,
}

impl Client {
    /// Connects to a run, as soon as it has its socket.
    ///
    /// # Panics
    /// When the run ends before.
    pub fn attach(running: &mut Running) -> Self {
        let stream = running.wait_for("it has a socket", |r| socket::connect(&r.out()).ok());
        stream.set_read_timeout(Some(LIMIT)).unwrap();
        let lines = BufReader::new(stream.try_clone().unwrap());
        Self { stream, lines }
    }

    /// Sends any text.
    pub fn send(&mut self, text: &str) {
        self.stream.write_all(text.as_bytes()).unwrap();
    }

    /// Sends text as long as the run takes it, and reads nothing.
    pub fn flood(&mut self, text: &str) {
        self.stream.set_write_timeout(Some(Duration::from_millis(200))).unwrap();
        while self.stream.write_all(text.as_bytes()).is_ok() {}
    }

    /// Returns the next line of the run; none if it has closed the connection.
    ///
    /// # Panics
    /// When the line is no answer, or none comes in time.
    pub fn next_line(&mut self) -> Option<Answer> {
        let mut line = String::new();
        match self.lines.read_line(&mut line) {
            Ok(0) => None,
            Ok(_) => Some(serde_json::from_str(&line).unwrap_or_else(|e| panic!("{e}: {line}"))),
            Err(error) if error.kind() == std::io::ErrorKind::ConnectionReset => None,
            Err(error) => panic!("no answer: {error}"),
        }
    }

    /// Sends a request and returns the answer.
    pub fn ask(&mut self, request: &Request) -> Answer {
        self.send(&request.to_line());
        self.next_line().expect("the run answers")
    }

    /// Sends a request and returns the answer; none if the run has ended.
    pub fn try_ask(&mut self, request: &Request) -> Option<Answer> {
        self.stream.write_all(request.to_line().as_bytes()).ok()?;
        self.next_line()
    }

    /// Gives an order and returns where it has taken effect.
    ///
    /// # Panics
    /// When it is refused.
    pub fn order(&mut self, request: &Request) -> Done {
        match self.ask(request) {
            Answer::Done(done) => done,
            other => panic!("{request:?}: {other:?}"),
        }
    }

    /// Changes a setting.
    pub fn set(&mut self, key: &str, value: f64) -> Done {
        self.order(&Request::Set { key: key.into(), value })
    }

    /// Returns the state of the run.
    ///
    /// # Panics
    /// When it is refused.
    pub fn status(&mut self) -> Status {
        match self.ask(&Request::Status) {
            Answer::Status(status) => *status,
            other => panic!("{other:?}"),
        }
    }

    /// Returns the reason why a line is refused.
    ///
    /// # Panics
    /// When it is not.
    pub fn refusal(&mut self, line: &str) -> String {
        self.send(line);
        match self.next_line() {
            Some(Answer::Refused { why }) => why,
            other => panic!("{line}: {other:?}"),
        }
    }
}
