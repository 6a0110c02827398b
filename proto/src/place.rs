//! Places of extreme values in a model.

use crate::ids::{ElemId, NodeId};
use serde::{Deserialize, Serialize};

/// Place of an extreme value: an element or a node, its part, and where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ModelPlace {
    /// The element, if it is one.
    pub element: Option<ElemId>,
    /// The node, if it is one.
    pub node: Option<NodeId>,
    /// Index of the part into those of the settings.
    pub part: Option<u32>,
    /// Coordinates of the node or of the centre of the element [length].
    pub x: [f64; 3],
}

impl ModelPlace {
    /// Returns true if the ids come before those of another place. Of places with the same value,
    /// the first one counts, on any number of workers.
    pub fn is_before(&self, o: &Self) -> bool {
        (self.element, self.node) < (o.element, o.node)
    }
}

/// Largest value of a quantity, and where it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Peak {
    /// The value, in the unit of the quantity; zero without a place.
    pub value: f64,
    /// Its element or node.
    pub at: ModelPlace,
}

impl Peak {
    /// Takes a value if it is larger. Of equal ones the lower ids count, on any number of workers.
    pub fn raise(&mut self, value: f64, at: impl FnOnce() -> ModelPlace) {
        if value < self.value || value <= 0.0 {
            return;
        }
        let at = at();
        if comes_first(-value, &at, -self.value, &self.at) {
            *self = Self { value, at };
        }
    }
}

/// Returns true if the first value is smaller than the second, or the same with lower ids.
pub(crate) fn comes_first(a: f64, at: &ModelPlace, b: f64, other: &ModelPlace) -> bool {
    a < b || a == b && at.is_before(other)
}
