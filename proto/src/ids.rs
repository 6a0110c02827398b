//! Global ids. A node id where an element id is meant does not compile.
//!
//! Everything of which the order matters (columns, sums, pairs) goes by ascending id. A user's mesh
//! may be numbered so that neighbours lie far apart in memory; its ids then get a *place* in front
//! of the number that the user gave, their *label*, and go by place. Only labels are shown.
//!
//! An id of a mesh is at most `LARGEST`, which its check sees to; with a place it is larger.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize, Pod, Zeroable)]
        #[repr(transparent)]
        #[serde(transparent)]
        pub struct $name(pub u64);
    };
}

/// Ids that a user's mesh has.
macro_rules! labelled {
    ($name:ident) => {
        impl $name {
            /// Largest id that is taken from a mesh.
            pub const LARGEST: Self = Self(9_000_000_000_000_000 - 1);

            /// The id of what comes at `place` and is called `label`; `None` if either is too
            /// large.
            pub fn placed(place: u64, label: u64) -> Option<Self> {
                let fits = place < 1 << PLACE_BITS && label < 1 << LABEL_BITS;
                fits.then_some(Self(PLACED | place << LABEL_BITS | label))
            }

            /// What the user's mesh calls it.
            pub fn label(self) -> u64 {
                if self.0 & PLACED == 0 { self.0 } else { self.0 & ((1 << LABEL_BITS) - 1) }
            }
        }

        impl std::fmt::Display for $name {
            fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                self.label().fmt(f)
            }
        }
    };
}

const LABEL_BITS: u32 = 32;
const PLACE_BITS: u32 = 28;
/// Set in ids with a place; those without are far below it.
const PLACED: u64 = 1 << (LABEL_BITS + PLACE_BITS);

id!(
    /// Global id of a node, as the user's mesh numbers it or with a place in front.
    NodeId
);
labelled!(NodeId);
id!(
    /// Global id of an element, as the user's mesh numbers it or with a place in front.
    ElemId
);
labelled!(ElemId);

id!(
    /// A face of an element: its id times 8 and the number of the face
    /// ([`crate::mesh::Shape::faces`]).
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_placed_id_goes_by_its_place_and_shows_its_label() {
        let last = (1 << PLACE_BITS) - 1;
        let (a, b) =
            (ElemId::placed(0, 900).unwrap(), ElemId::placed(last, u64::from(u32::MAX)).unwrap());
        assert!(a < b && ElemId::LARGEST < a);
        assert_eq!(
            (a.label(), b.label(), ElemId::LARGEST.label()),
            (900, 0xffff_ffff, ElemId::LARGEST.0)
        );
        assert_eq!(b.to_string(), "4294967295");
        assert_eq!(SegmentId::new(b, 5).elem(), b);
        assert_eq!(NodeId::placed(0, 1 << LABEL_BITS), None);
        assert_eq!(NodeId::placed(1 << PLACE_BITS, 1), None);
    }
}
