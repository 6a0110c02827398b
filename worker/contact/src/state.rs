//! State of contact for a checkpoint, besides pair histories, which belong to nodes.

use super::Contact;
use crumple_proto::checkpoint::MOST;
use crumple_proto::place::{ModelPlace, Peak};
use serde::{Deserialize, Serialize};

/// State and sums of one worker. Those of several workers are merged into one.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ContactState {
    searches: u64,
    sweeps: u64,
    unsettled: [u64; 2],
    capped_pairs: u64,
    penetration: f64,
    deepest: ModelPlace,
    sliding: Peak,
    approach: f64,
    /// Marks of parts, see [`super::diagnostics::search_record`].
    parts: Vec<u8>,
}

impl ContactState {
    /// Checks that the sums are possible ones of a job with this number of parts.
    ///
    /// # Errors
    /// They are not: the reason.
    pub fn validate(&self, parts: usize) -> Result<(), String> {
        let counts = [self.searches, self.sweeps, self.capped_pairs];
        if counts.into_iter().chain(self.unsettled).any(|count| count > MOST) {
            return Err("it has a number of contact searches or sweeps that is not possible".into());
        }
        if self.parts.len() > parts {
            let count = self.parts.len();
            return Err(format!("it has marks of {count} parts, and the job has {parts}"));
        }
        if self.penetration.is_nan()
            || self.approach.is_nan()
            || self.sliding.value.is_nan()
            || self.deepest.x.iter().chain(&self.sliding.at.x).any(|x| x.is_nan())
        {
            return Err("it has a penetration or work that is not a number".into());
        }
        Ok(())
    }

    /// Adds the state of another worker: sums, or the value that the next step uses of all workers.
    pub fn add(&mut self, o: &Self) {
        self.searches += o.searches;
        self.sweeps += o.sweeps;
        (0..2).for_each(|i| self.unsettled[i] = self.unsettled[i].max(o.unsettled[i]));
        self.capped_pairs += o.capped_pairs;
        let is_deeper = o.penetration > self.penetration;
        if is_deeper || o.penetration == self.penetration && o.deepest.is_before(&self.deepest) {
            (self.penetration, self.deepest) = (o.penetration, o.deepest);
        }
        self.sliding.raise(o.sliding.value, || o.sliding.at);
        self.approach = self.approach.max(o.approach);
        self.parts.resize(self.parts.len().max(o.parts.len()), 0);
        self.parts.iter_mut().zip(&o.parts).for_each(|(a, b)| *a |= b);
    }
}

impl Contact {
    /// Returns the state of this worker.
    pub fn state(&self) -> ContactState {
        // A new field is an error here: state has to be added, all else to the second list.
        let Self {
            searches,
            sweeps,
            unsettled,
            capped_pairs,
            penetration,
            deepest,
            sliding,
            approach,
            record,
            // Equal on all workers, see `common`.
            interface_started: _,
            pairs: _,
            // Pair histories are saved with their nodes.
            histories: _,
            edges: _,
            facets: _,
            // From the job.
            laws: _,
            search_method: _,
            skin: _,
            by_mass: _,
            speeds: _,
            with_edges: _,
            detail: _,
            beams_only: _,
            accelerated: _,
            // Computed from the mesh, and again after each change of the partition.
            surface,
            candidates: _,
            near_list: _,
            projected_pairs: _,
            motion_since_near_list: _,
            motion_before_near_list: _,
            stiffness: _,
            // For one step only.
            table: _,
            free_velocities: _,
            free_spins: _,
            momentum: _,
        } = self;
        ContactState {
            searches: *searches,
            sweeps: *sweeps,
            unsettled: *unsettled,
            capped_pairs: *capped_pairs,
            penetration: *penetration,
            deepest: *deepest,
            sliding: *sliding,
            approach: *approach,
            parts: record.of_parts(&surface.segments),
        }
    }

    /// Returns the state of the last step that is equal on all workers: for each interface true if
    /// its pairs were searched for, and the number of pairs, which selects the laws of the next
    /// step.
    pub fn common(&self) -> (&[bool], u64) {
        (&self.interface_started, self.pairs)
    }

    /// Sets the state, with that of [`Contact::common`]. Call it after [`Contact::renew`].
    pub fn restore(&mut self, state: ContactState, (started, pairs): (Vec<bool>, u64)) {
        self.searches = state.searches;
        self.sweeps = state.sweeps;
        self.unsettled = state.unsettled;
        self.capped_pairs = state.capped_pairs;
        (self.penetration, self.deepest) = (state.penetration, state.deepest);
        (self.sliding, self.approach) = (state.sliding, state.approach);
        self.pairs = pairs;
        self.interface_started = started;
        self.record.restore(state.parts);
    }
}
