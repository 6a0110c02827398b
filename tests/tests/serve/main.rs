//! The service.

mod archives;
mod attacks;
mod commands;
mod hostile;
mod interface;
mod jobs;
mod kills;
mod limits;
mod page;
mod python;
mod real_slurm;
mod slurm;
mod tls;
mod torture;
mod view;
