//! Rigid bodies and what ties nodes together.

use super::not_yet;
use crate::deck::table::{Keyword, Times::*};

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "CONSTRAINED_NODAL_RIGID_BODY",
        &[("heading:l", Count(super::title)), ("pid:i! cid:i nsid:i pnode:i iprt:i drflag:i rrflag:i", Once)],
        "`[[rigid]]` body `body-PID` of the node set",
    )
    .options(&["TITLE"])
    .repeats(),
    Keyword::new("CONSTRAINED_EXTRA_NODES_NODE", &[("pid:i! nid:i!", Rest)], "a node more of a rigid part"),
    Keyword::new("CONSTRAINED_EXTRA_NODES_SET", &[("pid:i! nsid:i!", Rest)], "a node set more of a rigid part"),
    Keyword::new("CONSTRAINED_RIGID_BODIES", &[("pidl:i! pidc:i! iflag:i", Rest)], "two rigid parts are one body"),
    Keyword::new(
        "DEFORMABLE_TO_RIGID",
        &[("pid:i! lrb:i ptype:a", Rest)],
        "the part, or with PSET each part of the set, is rigid from the start on and stays so; with lrb it joins that part's body",
    ),
    not_yet("CONSTRAINED_SPOTWELD", &[("n1:i! n2:i! sn:r ss:r n:r m:r tf:r ep:r", Rest)], "spot welds")
        .options(&["ID"]),
    not_yet(
        "CONSTRAINED_GENERALIZED_WELD_SPOT",
        &[("nsid:i! cid:i filter:i window:r npr:i nprt:i", Once), ("tfail:r epsf:r sn:r ss:r n:r m:r", Maybe)],
        "spot welds of a node set",
    )
    .options(&["ID"])
    .repeats(),
];
