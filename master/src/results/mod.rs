//! Results: fields, histories, the summary, the report page and exports for other programs.

pub mod binout;
pub mod channels;
pub mod d3plot;
pub mod exodus;
pub mod field_file;
pub mod fields;
pub mod figures;
pub mod histories;
pub mod history;
pub mod probe;
pub mod provenance;
pub mod quantity;
pub mod report;
pub mod requirements;
pub mod snapshot;
pub mod steering;
pub mod summary;
pub mod table;
pub mod trace;
pub mod vtkhdf;
pub mod warnings;
pub mod workers;
