//! Plain data shared by master and workers, and its transport. No physics here.
//!
//! - [`ids`], [`mesh`], [`job`], [`problem`]: input of the user, and problems in it
//! - [`quality`]: shape quality of the elements of a mesh
//! - [`partition`]: data that one worker receives
//! - [`loads`], [`airbag`], [`belt`], [`rigid`], [`tie`], [`wall`]: loads and prescribed motions,
//!   airbags, seat belts, rigid bodies, ties, walls
//! - [`adaptivity`]: division of shells
//! - [`boxes`]: boxes that tile space
//! - [`exact_sum`]: sums that do not depend on the order of their terms
//! - [`histories`]: requested histories, and the contributions of workers
//! - [`message`], [`report`], [`trace`], [`wire`]: messages between master and workers
//! - [`disk`]: watch over operations on files
//! - [`exit_code`]: exit codes of the program
//! - [`transport`]: transport of messages, by threads or MPI
//!
//! Kernels for a GPU (`nvptx64`) use the data alone: without files and messages.

pub mod adaptivity;
pub mod airbag;
pub mod belt;
pub mod boxes;
pub mod checkpoint;
#[cfg(not(target_arch = "nvptx64"))]
pub mod disk;
pub mod exact_sum;
pub mod exit_code;
pub mod histories;
pub mod ids;
pub mod initial;
pub mod job;
pub mod joint;
pub mod loads;
pub mod mesh;
pub mod message;
pub mod partition;
pub mod place;
pub mod problem;
pub mod quality;
pub mod report;
pub mod rigid;
pub mod steering;
pub mod tie;
pub mod trace;
#[cfg(not(target_arch = "nvptx64"))]
pub mod transport;
pub mod wall;
#[cfg(not(target_arch = "nvptx64"))]
pub mod wire;
