//! Results of a run, read back by other readers; the report, the trace and studies; runs that are
//! reproduced and compared.

mod binout;
mod contact_forces;
mod d3plot;
mod damage;
mod exodus;
mod histories;
mod logs;
mod mentioned;
mod model_page;
mod paraview;
mod provenance;
mod python;
mod report;
mod report_page;
mod report_play;
mod report_signal;
mod study;
mod trace;
mod vtkhdf;
mod warnings;
