//! The serial engine of Crumple: it runs without MPI, and its search and elements do not know that
//! there are others.
//!
//! - [`step`]: THE TIME STEP, start there; [`serve`]: one worker from first order to last report
//! - [`engine`]: owns everything; [`nodes`], [`blocks`]: columns of nodes and elements
//! - [`elements`], [`materials`]: formulations and laws, one file each; [`lanes`]: numbers they are
//!   written in
//! - [`contact`]: search, then enforce; [`wall`]: rigid walls
//! - [`loads`], [`prescribed`]: what acts from outside, and motion that is given; [`curve`]: their
//!   factors over time; [`rigid`]: bodies that do not deform; [`ties`]: nodes carried by others
//! - [`membership`], [`migrate`], [`erosion`]: who has what, and how that changes; [`census`]: who
//!   would have what; [`halo`]: what goes over the wires in a step; [`agreement`]: what all must
//!   know alike; [`motion`]: how far things have moved
//! - [`time`], [`energy`], [`histories`], [`output`], [`vtu`]: step sizes, ledger, records, files;
//!   [`trace`]: what happens when

pub mod constraints;
pub mod contact;
pub mod curve;
pub mod energy;
pub mod engine;
pub mod erosion;
pub mod fem;
pub mod histories;
pub mod loads;
pub mod math;
pub mod nodes;
pub mod output;
pub mod parallel;
pub mod serve;
pub mod step;
#[cfg(test)]
mod testing;
pub mod time;
pub mod trace;
pub mod vtu;
