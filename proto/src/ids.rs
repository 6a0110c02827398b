//! Global ids. The compiler rejects a node id in place of an element id.
//!
//! Everything whose order matters (columns, sums, pairs) is ordered by ascending id. A user's
//! mesh may be numbered such that neighbours lie far apart in memory. Its ids then get a
//! *place* in front of the user's number, the *label*, and are ordered by place. Output shows
//! labels only.
//!
//! Ids of a mesh are at most `LARGEST`, which the check of the mesh ensures. Ids with a place
//! are larger.

use bytemuck::{Pod, Zeroable};
use serde::{Deserialize, Serialize};

macro_rules! id {
    ($(#[$doc:meta])* $name:ident) => {
        $(#[$doc])*
        #[derive(
            Clone,
            Copy,
            Debug,
            Default,
            PartialEq,
            Eq,
            PartialOrd,
            Ord,
            Hash,
            Serialize,
            Deserialize,
            Pod,
            Zeroable,
        )]
        #[repr(transparent)]
        #[serde(transparent)]
        pub struct $name(pub u64);
    };
}

/// Implements ids that come from a user's mesh.
macro_rules! labelled {
    ($name:ident) => {
        impl $name {
            /// Largest id that a mesh may contain.
            pub const LARGEST: Self = Self(9_000_000_000_000_000 - 1);

            /// Returns the id with `place` and `label`; `None` if either is too large.
            pub fn placed(place: u64, label: u64) -> Option<Self> {
                let fits = place < 1 << PLACE_BITS && label < 1 << LABEL_BITS;
                fits.then_some(Self(PLACED | place << LABEL_BITS | label))
            }

            /// Returns the number in the user's mesh.
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
/// Bit that is set in ids with a place; ids without one are far below it.
const PLACED: u64 = 1 << (LABEL_BITS + PLACE_BITS);

id!(
    /// Global id of a node: the number in the user's mesh, possibly with a place in front.
    NodeId
);
labelled!(NodeId);
id!(
    /// Global id of an element: the number in the user's mesh, possibly with a place in front.
    ElemId
);
labelled!(ElemId);

id!(
    /// Id of a face of an element: 8 times the element's id plus the number of the face
    /// ([`crate::mesh::Shape::faces`]).
    SegmentId
);

impl SegmentId {
    /// Returns the id of face number `face` of an element.
    pub fn new(elem: ElemId, face: usize) -> Self {
        Self(elem.0 * 8 + face as u64)
    }

    /// Returns the element's id.
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
