//! The service.

mod archives;
mod attacks;
mod commands;
mod interface;
mod jobs;
mod kills;
mod limits;
mod python;
mod real_slurm;
mod slurm;
mod tls;
