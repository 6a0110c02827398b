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

            /// Returns an id after all others, in number and in place; `None` if there is none
            /// left, or there are no others.
            pub fn following(all: impl Iterator<Item = Self>) -> Option<Self> {
                let both = |(label, last): (u64, Option<Self>), id: Self| {
                    (label.max(id.label()), last.max(Some(id)))
                };
                let (label, last) = all.fold((0, None), both);
                let last = last?;
                if last.0 & PLACED == 0 {
                    return Some(Self(last.0 + 1));
                }
                Self::placed(((last.0 & !PLACED) >> LABEL_BITS) + 1, label + 1)
            }

            /// Returns the `count`-th id after this one, in number and in place.
            pub fn after(self, count: u64) -> Self {
                let places = if self.0 & PLACED == 0 { 0 } else { count << LABEL_BITS };
                Self(self.0 + places + count)
            }

            /// Returns true if that many ids follow this one.
            pub fn has_room(self, count: u64) -> bool {
                if self.0 & PLACED == 0 {
                    return count <= Self::LARGEST.0.saturating_sub(self.0);
                }
                let place = (self.0 & !PLACED) >> LABEL_BITS;
                let room = |used: u64, bits: u32| (1 << bits) - 1 - used;
                count <= room(place, PLACE_BITS).min(room(self.label(), LABEL_BITS))
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
const PLACE_BITS: u32 = 27;
/// Bit that is set in ids with a place; ids without one are far below it.
const PLACED: u64 = 1 << 60;
/// Number of faces of an element whose numbers are the last bits of the id of a segment.
const LOW_FACES: usize = 8;
/// Bit of a segment's id for the faces after them. No id of an element reaches it.
const HIGH_FACE: u64 = (LOW_FACES as u64) << (LABEL_BITS + PLACE_BITS);

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
    /// ([`crate::mesh::Shape::faces`]); a bit of its own marks numbers from 8 to 15.
    SegmentId
);

impl SegmentId {
    /// Returns the id of face number `face` of an element.
    pub fn new(elem: ElemId, face: usize) -> Self {
        let high = if face < LOW_FACES { 0 } else { HIGH_FACE };
        Self(high | (elem.0 * LOW_FACES as u64 + (face % LOW_FACES) as u64))
    }

    /// Returns the element's id.
    pub fn elem(self) -> ElemId {
        ElemId((self.0 & !HIGH_FACE) / LOW_FACES as u64)
    }

    /// Returns the number of the face.
    pub fn face(self) -> usize {
        let low = (self.0 % LOW_FACES as u64) as usize;
        if self.0 & HIGH_FACE == 0 { low } else { LOW_FACES + low }
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
        for face in [0, 5, 8, 15] {
            for elem in [a, b, ElemId::LARGEST] {
                let segment = SegmentId::new(elem, face);
                assert_eq!((segment.elem(), segment.face()), (elem, face));
            }
        }
        assert_eq!(SegmentId::new(ElemId(3), 5), SegmentId(29));
        assert_eq!(NodeId::placed(0, 1 << LABEL_BITS), None);
        assert_eq!(NodeId::placed(1 << PLACE_BITS, 1), None);
    }

    #[test]
    fn new_ids_follow_all_others_in_number_and_in_place() {
        assert_eq!(NodeId::following([3, 7, 5].map(NodeId).into_iter()), Some(NodeId(8)));
        assert_eq!(NodeId::following(std::iter::empty()), None);
        let placed = |place, label| ElemId::placed(place, label).unwrap();
        let first = ElemId::following([placed(0, 90), placed(4, 12)].into_iter()).unwrap();
        assert_eq!(first, placed(5, 91));
        assert_eq!([first.after(0), first.after(3)], [first, placed(8, 94)]);
        assert_eq!(NodeId(8).after(3), NodeId(11));
        let last = (1 << PLACE_BITS) - 1;
        assert!(placed(last - 2, 5).has_room(2) && !placed(last - 2, 5).has_room(3));
        assert!(NodeId(8).has_room(1 << 40) && !NodeId::LARGEST.has_room(1));
        assert_eq!(ElemId::following([placed(last, 5)].into_iter()), None);
    }
}
