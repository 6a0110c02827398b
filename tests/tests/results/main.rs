//! Results of a run, read back by other readers; the report, the trace and studies.

mod d3plot;
mod exodus;
mod histories;
mod logs;
mod paraview;
mod report;
mod study;
mod trace;
mod vtkhdf;
