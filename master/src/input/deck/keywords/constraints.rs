//! Rigid bodies and constraints between nodes.

use super::{id, not_yet};
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    UnusedFields, ignored, no_effect,
};

const WELD_ID: (&str, Times) = ("wid:i", Count(id));

const SPOT_UNUSED: &[UnusedFields] = &[
    no_effect("wid", "welds are numbered in the order of the deck"),
    no_effect("cid npr nprt", "forces of welds are not recorded"),
    ignored("filter window", "the forces of welds are not filtered"),
];

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "CONSTRAINED_NODAL_RIGID_BODY",
        &[
            ("heading:l", Count(super::title)),
            ("pid:i! cid:i nsid:i pnode:i iprt:i drflag:i rrflag:i", Once),
        ],
        "`[[rigid]]` body `body-PID` of the node set",
    )
    .unused(&[no_effect("cid pnode iprt", "they are for output")])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_EXTRA_NODES_NODE",
        &[("pid:i! nid:i!", Rest)],
        "adds a node to a rigid part",
    ),
    Keyword::new(
        "CONSTRAINED_EXTRA_NODES_SET",
        &[("pid:i! nsid:i!", Rest)],
        "adds a node set to a rigid part",
    ),
    Keyword::new(
        "CONSTRAINED_RIGID_BODIES",
        &[("pidl:i! pidc:i! iflag:i", Rest)],
        "joins two rigid parts to one body",
    )
    .unused(&[ignored("iflag", "the mass of the body is that of both parts")]),
    Keyword::new(
        "DEFORMABLE_TO_RIGID",
        &[("pid:i! lrb:i ptype:a", Rest)],
        "the part (with ptype PSET, each part of the set) is rigid for the whole run; lrb joins it \
         to the body of that part",
    ),
    Keyword::new(
        "CONSTRAINED_SPOTWELD",
        &[WELD_ID, ("n1:i! n2:i! sn:r ss:r n:r m:r tf:r=1e20 ep:r=1e20", Once)],
        "`[[rigid]]` body of the two nodes; bodies with common nodes become one. With sn or ss: a \
         round beam that breaks, its diameter equal to its length, of the material of the first \
         node's part. sn is its `normal`, ss its `shear`, n and m are their exponents (2 if blank)",
    )
    .unused(SPOT_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_GENERALIZED_WELD_SPOT",
        &[
            WELD_ID,
            ("nsid:i! cid:i filter:i window:r npr:i nprt:i", Once),
            ("tfail:r=1e20 epsf:r=1e20 sn:r ss:r n:r m:r", Once),
        ],
        "the same for a node set; a weld that breaks has two nodes",
    )
    .unused(SPOT_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_NODE_SET",
        &[WELD_ID, ("nsid:i! dof:i! tf:r=1e20", Once)],
        "`[[tie]]` of the other nodes to the first node of the set; dof has to be 7 (all \
         displacements)",
    )
    .unused(SPOT_UNUSED)
    .options(&["ID"])
    .repeats(),
    not_yet(
        "CONSTRAINED_INTERPOLATION",
        &[
            ("icid:i! dnid:i! ddof:i cidd:i ityp:i", Once),
            ("inid:i! idof:i twghtx:r twghty:r twghtz:r rwghtx:r rwghty:r rwghtz:r", Rest),
        ],
        "a node whose motion is a mean of other nodes",
    ),
];
