//! The run: the same bits on any number of workers, steps, and how runs end.

mod adaptivity;
mod checkpoint_contents;
mod checkpoints;
mod element_classes;
mod exit_codes;
mod free_flight;
mod hostile_disks;
mod jeep_frame;
mod numbering;
mod precision;
mod requirements;
mod restart_changes;
mod steps;
mod subcycles;
mod unused_features;
mod worker_invariance;
