//! Joints between rigid bodies.

use super::id;
use crate::input::deck::table::{Keyword, Times, Times::*, UnusedFields, ignored, no_effect};

const JOINT_ID: (&str, Times) = ("jid:i heading:a70", Count(id));
const NODES: (&str, Times) = ("n1:i! n2:i! n3:i n4:i n5:i n6:i rps:r=1 damp:r=1", Once);

const EXACT: UnusedFields = no_effect("rps damp", "joints are exact and need no penalty stiffness");
const WITH_AXIS: &[UnusedFields] =
    &[EXACT, no_effect("n5 n6", "the other nodes give the joint; only their bodies are checked")];
const WITH_POINT: &[UnusedFields] = &[EXACT, no_effect("n3 n4 n5 n6", "n1 and n2 give the joint")];
const WITH_SCREW: &[UnusedFields] = &[
    EXACT,
    no_effect("n5 n6", "the other nodes give the joint; only their bodies are checked"),
    no_effect("lcid type r1 h_angle", "they are for motors, gears and pulleys"),
];
const ROTATION_UNUSED: &[UnusedFields] = &[
    no_effect("jsid", "stiffnesses have no numbers"),
    ignored(
        "esph est esps",
        "friction and stops are rigid where they act, which is if it is not 0",
    ),
];
const SLIDING_UNUSED: &[UnusedFields] = &[
    no_effect("jsid", "stiffnesses have no numbers"),
    ignored("esx esy esz", "friction and stops are rigid where they act, which is if it is not 0"),
];

/// Creates a joint whose nodes n1, n3, n5 belong to the first body, n2, n4, n6 to the second.
const fn joint(name: &'static str, note: &'static str) -> Keyword {
    Keyword::new(name, &[JOINT_ID, NODES], note).unused(WITH_AXIS).options(&["ID"]).repeats()
}

pub const KEYWORDS: &[Keyword] = &[
    joint(
        "CONSTRAINED_JOINT_SPHERICAL",
        "`[[joint]]` `spherical` at n1, between the bodies of n1 and n2; its name is the heading, \
         or `joint-JID`",
    )
    .unused(WITH_POINT),
    joint("CONSTRAINED_JOINT_REVOLUTE", "the same, `revolute`, with the axis from n1 to n3"),
    joint("CONSTRAINED_JOINT_CYLINDRICAL", "the same, `cylindrical`, with the axis from n1 to n3"),
    joint("CONSTRAINED_JOINT_PLANAR", "the same, `planar`, with the normal from n1 to n3"),
    joint(
        "CONSTRAINED_JOINT_TRANSLATIONAL",
        "the same, `translational`, with the axis from n1 to n3",
    ),
    joint(
        "CONSTRAINED_JOINT_UNIVERSAL",
        "the same, `universal`, with the axes from n1 to n3 and from n2 to n4",
    ),
    joint("CONSTRAINED_JOINT_LOCKING", "the same, `fixed`").unused(WITH_POINT),
    Keyword::new(
        "CONSTRAINED_JOINT_SCREW",
        &[JOINT_ID, NODES, ("parm:r! lcid:i type:i r1:r h_angle:r", Once)],
        "the same, `screw`, with the axis from n1 to n3; parm is the distance per radian",
    )
    .unused(WITH_SCREW)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_JOINT_STIFFNESS_GENERALIZED",
        &[
            ("jsid:i pida:i! pidb:i! cida:i! cidb:i jid:i", Once),
            ("lcidph:i lcidt:i lcidps:i dlcidph:i dlcidt:i dlcidps:i", Maybe),
            ("esph:r fmph:r est:r fmt:r esps:r fmps:r", Maybe),
            ("nsaph:r psaph:r nsat:r psat:r nsaps:r psaps:r", Maybe),
        ],
        "`rotation` of the joint jid, or of the joint between the bodies of pida and pidb, whose \
         axis is an axis of cida: curve of the moment (angles in radians), a linear curve of the \
         rate as damping, friction fm and stops (degrees, 0 for none), both only if es is not 0",
    )
    .unused(ROTATION_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_JOINT_STIFFNESS_TRANSLATIONAL",
        &[
            ("jsid:i pida:i! pidb:i! cida:i! cidb:i jid:i", Once),
            ("lcidx:i lcidy:i lcidz:i dlcidx:i dlcidy:i dlcidz:i", Maybe),
            ("esx:r ffx:r esy:r ffy:r esz:r ffz:r", Maybe),
            ("nsdx:r psdx:r nsdy:r psdy:r nsdz:r psdz:r", Maybe),
        ],
        "`sliding` in the same way: force by distance, friction ff, stops as distances",
    )
    .unused(SLIDING_UNUSED)
    .options(&["ID"])
    .repeats(),
];
