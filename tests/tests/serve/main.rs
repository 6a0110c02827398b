//! The service.

mod attacks;
mod commands;
mod interface;
mod jobs;
mod kills;
mod page;
mod slurm;
mod view;
