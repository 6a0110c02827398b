//! Parts in lists of a job.

use schemars::JsonSchema;

/// Part in a list of parts: its id or its name. Names are replaced by ids when a job is read, so
/// the lists of a [`Job`](super::Job) have ids only; this is their form in a file.
#[derive(Clone, Debug, JsonSchema)]
#[schemars(untagged)]
pub enum PartRef {
    /// `id` of the part.
    Id(u32),
    /// `name` of the part.
    Name(String),
}
