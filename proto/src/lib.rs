//! Plain data shared by master and workers, and how it travels. No physics here.
//!
//! - [`ids`], [`mesh`], [`job`], [`problem`]: what the user brings and what is wrong with it
//! - [`quality`]: how good the elements' shapes are
//! - [`partition`]: what one worker receives; [`loads`], [`rigid`], [`tie`], [`wall`]: what acts on
//!   the model, what of it is rigid or tied, what it cannot pass
//! - [`boxes`]: the boxes that tile space
//! - [`histories`]: what is recorded by kind, as it is asked for and as workers report it
//! - [`message`], [`report`], [`trace`], [`wire`]: the conversation between master and workers
//! - [`transport`]: the wires, threads or MPI

pub mod boxes;
pub mod histories;
pub mod ids;
pub mod job;
pub mod loads;
pub mod mesh;
pub mod message;
pub mod partition;
pub mod problem;
pub mod quality;
pub mod report;
pub mod rigid;
pub mod tie;
pub mod trace;
pub mod transport;
pub mod wall;
pub mod wire;
