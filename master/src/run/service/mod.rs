//! The asynchronous task of the master, the only one in the program: it takes signals and the
//! requests of clients (`crumple attach`).
//!
//! It has its own thread. The thread of the master, which alone calls MPI, and this one communicate
//! by channels: requests go to the master with a place for the answer, lines of the live stream go
//! to all clients. Neither waits for the other. Worker ranks have no such task.

mod client;
pub mod signals;
pub mod socket;

use crate::run::request::{Answer, Request};
use signals::{Manner, Signals, StopFlag};
use socket::Socket;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use tokio::net::UnixListener;
use tokio::sync::{broadcast, mpsc, oneshot};
use tokio::task::JoinSet;

/// Number of requests that wait for the master; further ones are refused.
const MOST_CALLS: usize = 64;
/// Number of lines of the stream that a client may lag behind.
const MOST_LINES: usize = 256;
/// Number of clients at a time.
const MOST_CLIENTS: usize = 64;
/// Time that clients get to read their last lines when the run has ended.
const LAST_LINES: Duration = Duration::from_secs(1);

/// The task, as other threads see it.
pub struct Service {
    flag: StopFlag,
    openings: mpsc::UnboundedSender<Opening>,
}

/// A socket that the task is to serve.
struct Opening {
    listener: std::os::unix::net::UnixListener,
    calls: mpsc::Sender<Call>,
    lines: broadcast::Receiver<Arc<str>>,
    ended: std::sync::mpsc::Sender<()>,
}

/// A request of a client, which waits for the answer.
pub struct Call {
    /// The request.
    pub request: Request,
    answer: oneshot::Sender<Answer>,
}

/// The master's end of the channels. The socket is removed when it is dropped.
pub struct Desk {
    calls: mpsc::Receiver<Call>,
    lines: Option<broadcast::Sender<Arc<str>>>,
    ended: std::sync::mpsc::Receiver<()>,
    _socket: Socket,
}

impl Service {
    /// Starts the task on its own thread. It takes signals from here on.
    pub fn start(manner: Manner) -> Self {
        let flag = StopFlag::default();
        flag.set_manner(manner);
        let (openings, mut opened) = mpsc::unbounded_channel::<Opening>();
        let (raised, (ready, is_ready)) = (flag.clone(), std::sync::mpsc::channel());
        let body = move || {
            let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build();
            let Ok(runtime) = runtime else { return };
            runtime.block_on(async {
                let Some(signals) = Signals::catch() else { return };
                let _ = ready.send(());
                tokio::spawn(async move {
                    while let Some(opening) = opened.recv().await {
                        tokio::spawn(serve(opening));
                    }
                });
                signals.watch(raised).await;
            });
        };
        // An error means that there is no task: signals keep their usual effect.
        let _ = std::thread::Builder::new().name("service".into()).spawn(body);
        let _ = is_ready.recv();
        Self { flag, openings }
    }

    /// Returns the flags that signals raise.
    pub fn stop(&self) -> &StopFlag {
        &self.flag
    }

    /// Opens a socket in the folder of a run, which is locked.
    ///
    /// # Errors
    /// No socket can be made; the message names the path.
    pub fn open(&self, out: &Path) -> Result<Desk, String> {
        let (socket, listener) = Socket::bind(out)?;
        let (to_master, calls) = mpsc::channel(MOST_CALLS);
        let (lines, of_clients) = broadcast::channel(MOST_LINES);
        let (ended, end) = std::sync::mpsc::channel();
        let opening = Opening { listener, calls: to_master, lines: of_clients, ended };
        self.openings.send(opening).map_err(|_| "the thread of the service has ended")?;
        Ok(Desk { calls, lines: Some(lines), ended: end, _socket: socket })
    }
}

impl Desk {
    /// Returns the next request, if there is one.
    pub fn next_call(&mut self) -> Option<Call> {
        self.calls.try_recv().ok()
    }

    /// Returns true if there are clients. Without them no line of the stream is made.
    pub fn has_clients(&self) -> bool {
        self.lines.as_ref().is_some_and(|lines| lines.receiver_count() > 1)
    }

    /// Sends a line of the stream to all clients. Never waits: a client that reads too slowly is
    /// dropped.
    pub fn publish(&self, line: &Answer) {
        if let Some(lines) = &self.lines {
            let _ = lines.send(line.to_line().into()); // an error means that there are no clients
        }
    }
}

impl Drop for Desk {
    fn drop(&mut self) {
        self.lines = None;
        self.calls.close();
        while self.calls.try_recv().is_ok() {} // their clients learn that the run has ended
        let _ = self.ended.recv_timeout(2 * LAST_LINES);
    }
}

impl Call {
    /// Separates the request from the place for its answer.
    pub fn split(self) -> (Request, Reply) {
        (self.request, Reply(self.answer))
    }
}

/// Place for the answer to a request. A client whose request is dropped learns that the run has
/// ended.
pub struct Reply(oneshot::Sender<Answer>);

impl Reply {
    /// Answers. The client may have left.
    pub fn send(self, answer: Answer) {
        let _ = self.0.send(answer);
    }
}

/// Serves a socket until the master closes the stream.
async fn serve(opening: Opening) {
    let Opening { listener, calls, mut lines, ended } = opening;
    let Ok(listener) = UnixListener::from_std(listener) else { return };
    let mut clients = JoinSet::new();
    loop {
        tokio::select! {
            accepted = listener.accept() => match accepted {
                Ok((stream, _)) => {
                    while clients.try_join_next().is_some() {}
                    let is_full = clients.len() >= MOST_CLIENTS;
                    let (calls, lines) = (calls.clone(), lines.resubscribe());
                    clients.spawn(client::serve(stream, calls, lines, is_full));
                }
                // Too many open files, for example.
                Err(_) => tokio::time::sleep(Duration::from_millis(100)).await,
            },
            line = lines.recv() => {
                if matches!(line, Err(broadcast::error::RecvError::Closed)) {
                    break;
                }
            }
        }
    }
    drop(listener);
    let all = async { while clients.join_next().await.is_some() {} };
    let _ = tokio::time::timeout(LAST_LINES, all).await;
    let _ = ended.send(());
}
