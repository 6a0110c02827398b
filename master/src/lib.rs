//! The master of Crumple as a library; `main.rs` is the `crumple` binary.
//!
//! - [`cli`]: what can be said on the command line
//! - [`job`]: from a job file to a sound model, or to everything that is wrong with it
//! - [`deck`]: LS-DYNA keyword decks, in and out
//! - [`check`]: `crumple check`; [`spectrum`]: `crumple check --step`
//! - [`launch`]: `crumple run`, on threads or under MPI
//! - [`verify`]: `crumple verify`; [`embedded`]: engines in this process without a master
//! - [`control`]: THE RUN, start there; [`decompose`]: where boxes are; [`balance`]: when they are
//!   renewed
//! - [`advise`]: `crumple advise`, what a run did not need
//! - [`bench`]: `crumple bench`, what elements cost per cycle
//! - [`scale`]: `crumple scale`, parallel efficiency on any number of workers, predicted
//! - [`mod@reference`]: `crumple schema`, what a job may say, for editors and for people
//! - [`study`]: `crumple study`, many runs of one job, and charts of them
//! - [`trace`]: `crumple run --trace`, a time line of all workers
//! - [`report`]: `crumple report`, a page that shows a run; [`field_file`]: field files read back
//! - [`vtkhdf`]: `crumple export-vtkhdf`, fields as one file for ParaView
//! - [`d3plot`]: `crumple export-d3plot`, fields for post-processors of LS-DYNA
//! - [`history`], [`histories`], [`summary`], [`fields`], [`progress`], [`say`], [`stop`]: what
//!   comes out, and how it is stopped

pub mod analysis;
pub mod cli;
pub mod input;
pub mod results;
pub mod run;
pub mod verify;
