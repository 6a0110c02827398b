//! `crumple serve`: a queue of jobs on this machine or a cluster, with a page and an interface for
//! programs. Start reading at `keeper`, the loop; `http` is what clients reach.
//!
//! Tokio runs everything here: connections, the loop, the streams of the runs. Calls that may wait,
//! of the database and of launchers, have threads of their own. Runs are processes that do not need
//! the service; nothing of it is in a run.

pub mod api;
mod archive;
mod check;
mod disk;
mod folder;
mod http;
mod intake;
mod keeper;
mod launcher;
mod limits;
mod live;
mod start;
mod store;
mod tokens;
mod views;

pub use archive::ArchiveFormat;
pub use http::openapi::text as openapi;
pub use start::{ACCESS_FILE, read_access, run};
pub use tokens::secret;
