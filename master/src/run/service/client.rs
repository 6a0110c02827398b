//! One client of a run: a line of JSON for each request and each answer.

use super::Call;
use crate::run::request::{Answer, Request};
use std::sync::Arc;
use std::time::Duration;
use tokio::io::AsyncWriteExt;
use tokio::net::UnixStream;
use tokio::net::unix::OwnedWriteHalf;
use tokio::sync::broadcast::{self, error::RecvError};
use tokio::sync::{mpsc, oneshot};
use tokio_stream::StreamExt;
use tokio_util::codec::{FramedRead, LinesCodec, LinesCodecError};

/// Longest line of a request [byte].
const LONGEST: usize = 16 * 1024;
/// Time after which a client that does not read its answers is dropped.
const SLOW: Duration = Duration::from_secs(5);

/// The client is gone, or too slow.
struct Gone;

/// Answers a client until it leaves, breaks a rule, or the run ends.
pub(super) async fn serve(
    stream: UnixStream,
    calls: mpsc::Sender<Call>,
    lines: broadcast::Receiver<Arc<str>>,
    is_full: bool,
) {
    let is_owner = stream.peer_cred().is_ok_and(|peer| {
        let me = rustix::process::geteuid().as_raw();
        peer.uid() == me || peer.uid() == 0
    });
    let (reader, mut writer) = stream.into_split();
    if !is_owner || is_full {
        let why =
            if is_full { "the run has too many clients" } else { "you did not start the run" };
        let _ = write(&mut writer, &Answer::refused(why).to_line()).await;
        return;
    }
    let requests = FramedRead::new(reader, LinesCodec::new_with_max_length(LONGEST));
    let client = Client { requests, writer, calls, lines, watches: false, pending: None };
    let _ = client.serve().await;
}

struct Client {
    requests: FramedRead<tokio::net::unix::OwnedReadHalf, LinesCodec>,
    writer: OwnedWriteHalf,
    calls: mpsc::Sender<Call>,
    lines: broadcast::Receiver<Arc<str>>,
    /// True if it gets the stream.
    watches: bool,
    /// The answer for which it waits. Until then its next request is not read.
    pending: Option<oneshot::Receiver<Answer>>,
}

impl Client {
    async fn serve(mut self) -> Result<(), Gone> {
        loop {
            tokio::select! {
                request = self.requests.next(), if self.pending.is_none() => match request {
                    None => return Ok(()),
                    Some(Ok(text)) => self.forward(&text).await?,
                    Some(Err(error)) => {
                        let why = match error {
                            LinesCodecError::MaxLineLengthExceeded => {
                                format!("a request has at most {LONGEST} bytes")
                            }
                            LinesCodecError::Io(_) => "a request is a line of text in UTF-8".into(),
                        };
                        return self.refuse(&why).await;
                    }
                },
                answer = wait_for(&mut self.pending) => {
                    self.pending = None;
                    match answer {
                        Some(answer) => write(&mut self.writer, &answer.to_line()).await?,
                        None => self.refuse("the run has ended").await?,
                    }
                }
                line = self.lines.recv() => match line {
                    Ok(line) if self.watches => write(&mut self.writer, &line).await?,
                    Ok(_) => {}
                    Err(RecvError::Lagged(_)) if self.watches => {
                        return self.refuse("this client reads too slowly").await;
                    }
                    Err(RecvError::Lagged(_)) => {}
                    Err(RecvError::Closed) => {
                        if self.pending.is_some() {
                            match wait_for(&mut self.pending).await {
                                Some(answer) => write(&mut self.writer, &answer.to_line()).await?,
                                None => self.refuse("the run has ended").await?,
                            }
                        }
                        return Ok(());
                    }
                },
            }
        }
    }

    /// Passes a request on to the master.
    async fn forward(&mut self, text: &str) -> Result<(), Gone> {
        let request = match Request::from_line(text) {
            Ok(request) => request,
            Err(why) => return self.refuse(&why).await,
        };
        if request == Request::Watch {
            self.watches = true;
            self.lines = self.lines.resubscribe();
        }
        let (answer, pending) = oneshot::channel();
        match self.calls.try_send(Call { request, answer }) {
            Ok(()) => {
                self.pending = Some(pending);
                Ok(())
            }
            Err(mpsc::error::TrySendError::Full(_)) => {
                self.refuse("too many requests wait for the run; try again").await
            }
            Err(mpsc::error::TrySendError::Closed(_)) => self.refuse("the run has ended").await,
        }
    }

    async fn refuse(&mut self, why: &str) -> Result<(), Gone> {
        write(&mut self.writer, &Answer::refused(why).to_line()).await
    }
}

/// Waits for the answer, for ever without a request. Returns `None` if the run ends without one.
async fn wait_for(pending: &mut Option<oneshot::Receiver<Answer>>) -> Option<Answer> {
    match pending {
        Some(answer) => answer.await.ok(),
        None => std::future::pending().await,
    }
}

/// Writes a line.
async fn write(writer: &mut OwnedWriteHalf, line: &str) -> Result<(), Gone> {
    match tokio::time::timeout(SLOW, writer.write_all(line.as_bytes())).await {
        Ok(Ok(())) => Ok(()),
        _ => Err(Gone),
    }
}
