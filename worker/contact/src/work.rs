//! Work of contact forces.

use crumple_fem::work::WorkSum;
use serde::{Deserialize, Serialize};

/// Work of contact forces.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct ContactWork {
    /// Work of all contact forces.
    pub total: WorkSum,
    /// Work of friction.
    pub friction: WorkSum,
    /// Work of the pairs that penetrate since the start of the run.
    pub starting: WorkSum,
}
