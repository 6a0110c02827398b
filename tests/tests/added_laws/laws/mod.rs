//! Laws that only tests have, one per file.

pub mod breaking;
pub mod damper;
pub mod ludwik;
pub mod maxwell;
pub mod sticky;
pub mod strict;
