//! The service.

mod archives;
mod attacks;
mod camera;
mod commands;
mod findings;
mod hostile;
mod interface;
mod jobs;
mod kills;
mod limits;
mod mpirun;
mod page;
mod python;
mod real_slurm;
mod slurm;
mod tls;
mod torture;
mod view;
