//! Keys of the decomposition, in `[parallel]` of a job.

use crate::parameter::{DefaultValue, Form, ParameterRow, Range, Values};
use crumple_proto::job::Parallel;
use crumple_proto::partition::ContactDecomposition;

/// Width b of the buffer.
const BUFFER: ParameterRow = ParameterRow {
    key: "buffer",
    form: Form::Number,
    otherwise: DefaultValue::Number(0.0),
    range: Some(Range { wanted: "0 (for the default) or above", fits: |x| x >= 0.0 }),
    meaning: "Width b of the buffer around each box face [length]; 0 for the median side of the \
              elements, at most four times the smallest side.",
};

/// Limit of the imbalance.
const IMBALANCE: ParameterRow = ParameterRow {
    key: "imbalance",
    form: Form::Number,
    otherwise: DefaultValue::Number(1.1),
    range: Some(Range { wanted: "at least 1; 1.1 is usual", fits: |x| x >= 1.0 }),
    meaning: "Limit of the imbalance: the largest CPU time without contact plus the largest one of \
              contact, over the mean time of the workers. The boxes are recomputed if it stays \
              above this limit.",
};

/// Smallest number of cycles between two repartitions.
const LOW_EVERY_AT_LEAST: ParameterRow = ParameterRow {
    key: "low_every_at_least",
    form: Form::Whole,
    otherwise: DefaultValue::Whole(200),
    range: None,
    meaning: "Smallest number of cycles between two repartitions. The first may come earlier.",
};

/// Number of cycles between forced redecompositions.
const FORCE_EVERY: ParameterRow = ParameterRow {
    key: "force_every",
    form: Form::Whole,
    otherwise: DefaultValue::Whole(0),
    range: None,
    meaning: "Number of cycles between forced redecompositions of alternating kind, for tests; 0 \
              for none.",
};

/// Threads of each worker.
const THREADS: ParameterRow = ParameterRow {
    key: "threads",
    form: Form::Whole,
    otherwise: DefaultValue::Whole(1),
    range: Some(Range {
        wanted: "from 1 to 1024; about the cores of a socket or node",
        fits: |x| (1.0..=1024.0).contains(&x),
    }),
    meaning: "Number of threads of each worker, which share its loops: elements, nodes and the \
              searches of contact. The results have the same bits. `--threads` overrides it.",
};

/// The workers that search for contact.
const CONTACT: ParameterRow = ParameterRow {
    key: "contact",
    form: Form::Word(&["boxes", "rcb"]),
    otherwise: DefaultValue::Word("boxes"),
    range: None,
    meaning: "`boxes`: each worker searches for the contact of its own elements; these migrate. \
              `rcb`: elements stay, and a second decomposition by recursive coordinate bisection \
              gives each worker the same number of contact nodes; there are no repartitions. The \
              results have the same bits.",
};

/// Decomposition: its settings, with defaults.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BoxDecomposition {
    /// Width of the buffer around each box face [length]; 0 if it follows from the mesh.
    pub buffer: f64,
    /// Limit of the imbalance.
    pub imbalance: f64,
    /// Smallest number of cycles between two repartitions.
    pub low_every_at_least: u64,
    /// Number of cycles between forced redecompositions, 0 for none.
    pub force_every: u64,
    /// The workers that search for contact.
    pub contact: ContactDecomposition,
    /// Number of threads of each worker.
    pub threads: usize,
}

impl BoxDecomposition {
    /// Its keys in `[parallel]`.
    pub const KEYS: &[ParameterRow] =
        &[BUFFER, IMBALANCE, LOW_EVERY_AT_LEAST, FORCE_EVERY, CONTACT, THREADS];

    /// Returns the settings of a job, whose values have been checked.
    pub fn new(job: &Parallel) -> Self {
        let values = Values::new([Self::KEYS, &[]], &job.parameters);
        Self {
            buffer: values.number(BUFFER.key),
            imbalance: values.number(IMBALANCE.key),
            low_every_at_least: values.whole(LOW_EVERY_AT_LEAST.key) as u64,
            force_every: values.whole(FORCE_EVERY.key) as u64,
            contact: match values.word(CONTACT.key).as_str() {
                "rcb" => ContactDecomposition::Rcb,
                _ => ContactDecomposition::Boxes,
            },
            threads: values.whole(THREADS.key).max(1),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_that_are_not_given_have_the_defaults_of_the_table() {
        let mut job = Parallel::default();
        job.parameters.insert("imbalance".into(), 1.5.into());
        let all = BoxDecomposition::new(&job);
        let wanted = BoxDecomposition {
            buffer: 0.0,
            imbalance: 1.5,
            low_every_at_least: 200,
            force_every: 0,
            contact: ContactDecomposition::Boxes,
            threads: 1,
        };
        assert_eq!(all, wanted);
    }
}
