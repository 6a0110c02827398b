//! Data that a step reads and writes, for `crumple bench --traffic`.

/// One kind of data that a step touches.
#[derive(Clone, Copy, Debug)]
pub struct StepData {
    /// Its name.
    pub data: &'static str,
    /// Size [bytes].
    pub bytes: usize,
    /// Number of times that a step reads it from end to end.
    pub reads: usize,
    /// Number of times that a step writes it from end to end.
    pub writes: usize,
}
