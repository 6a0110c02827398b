//! Input: jobs, keyword decks, their checks and their reference pages.

pub mod check;
pub mod confine;
pub mod connectivity;
pub mod deck;
pub mod exodus;
pub mod findings;
pub mod init;
pub mod job;
pub mod mesh_file;
pub mod reference;
