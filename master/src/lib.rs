//! The master of Crumple as a library. The `crumple` binary is the package in `program/`.
//!
//! - [`cli`]: the command line
//! - [`input`]: jobs ([`input::job`]), LS-DYNA keyword decks ([`input::deck`]), checks
//!   (`crumple check`), reference (`crumple schema`)
//! - [`run`]: start reading at [`run::control`], the run on the master; [`run::launch`]:
//!   `crumple run` on threads or under MPI; [`run::embedded`]: engines in this process without a
//!   master
//! - [`results`]: fields, histories, summary, report page, exports
//! - [`analysis`]: `crumple study`, `advise`, `scale`, `bench`, `cost`
//!
//! `crumple verify` is the crate `crumple-verification` in `tests/verification/`.

pub mod analysis;
pub mod cli;
pub mod input;
pub mod results;
pub mod run;
