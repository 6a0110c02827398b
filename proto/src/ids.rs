//! Global ids. A node id where an element id is meant does not compile.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, Pod, Zeroable)]
        #[repr(transparent)]
        #[serde(transparent)]
        pub struct $name(pub u64);

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.0.fmt(f)
            }
        }
    };
}

id!(
    /// Global id of a node, as the user's mesh numbers it.
    NodeId
);
id!(
    /// Global id of an element, as the user's mesh numbers it.
    ElemId
);

id!(
    /// A face of an element: its id times 8 and the number of the face ([`crate::mesh::Shape::faces`]).
    SegmentId
);

impl SegmentId {
    /// Face number `face` of an element.
    pub fn new(elem: ElemId, face: usize) -> Self {
        Self(elem.0 * 8 + face as u64)
    }

    /// The element.
    pub fn elem(self) -> ElemId {
        ElemId(self.0 / 8)
    }
}

impl ElemId {
    /// Largest id of an element: workers agree on ids as exact f64, which end at 2^53.
    pub const LARGEST: Self = Self(9_000_000_000_000_000 - 1);
}
