//! Results: fields, histories, the summary, the report page and exports for other programs.

pub mod d3plot;
pub mod exodus;
pub mod field_file;
pub mod fields;
pub mod histories;
pub mod history;
pub mod report;
pub mod snapshot;
pub mod steering;
pub mod summary;
pub mod table;
pub mod trace;
pub mod vtkhdf;
pub mod workers;
