//! Sets, curves, boxes, coordinate systems, and keywords that do not change a model by
//! themselves.

use super::title;
use crate::input::deck::table::{Keyword, Times::*};

const LIST: &[(&str, crate::input::deck::table::Times)] = &[
    ("heading:l", Count(title)),
    ("sid:i! da1:r da2:r da3:r da4:r solver:a its:a", Once),
    ("id:i*8", Rest),
];

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new("TITLE", &[("text:l", Maybe)], "`title`"),
    Keyword::new("COMMENT", &[("text:l", Rest)], "ignored"),
    Keyword::new(
        "PARAMETER",
        &[("prmr:a*8", Rest)],
        "names of values, which fields use as &name; types R, I and C",
    )
    .aliases(&["PARAMETER_LOCAL"]),
    Keyword::new(
        "PARAMETER_EXPRESSION",
        &[("prmr:a expression:a70", Rest)],
        "the same by formulas; integers stay integers, so 2/5 is 0",
    )
    .aliases(&["PARAMETER_EXPRESSION_LOCAL"]),
    Keyword::new("SET_NODE_LIST", LIST, "node set `set-SID`, and the same set under its title")
        .aliases(&["SET_NODE"])
        .options(&["TITLE"]),
    Keyword::new("SET_NODE_LIST_GENERATE", LIST, "the same by ranges: first and last id of each")
        .options(&["TITLE"]),
    Keyword::new(
        "SET_NODE_COLUMN",
        &[
            ("heading:l", Count(title)),
            ("sid:i! da1:r da2:r da3:r da4:r solver:a its:a", Once),
            ("nid:i a:r*4", Rest),
        ],
        "the same, one node per line",
    )
    .options(&["TITLE"]),
    Keyword::new("SET_NODE_ADD", LIST, "the same from other node sets").options(&["TITLE"]),
    Keyword::new(
        "SET_NODE_GENERAL",
        &[
            ("heading:l", Count(title)),
            ("sid:i! da1:r da2:r da3:r da4:r solver:a its:a", Once),
            ("option:a! e:i*7", Rest),
        ],
        "the same by ALL, NODE, PART, BOX, SET_NODE, SET_PART; the prefix D removes nodes",
    )
    .options(&["TITLE"]),
    Keyword::new("SET_PART_LIST", LIST, "a set of parts")
        .aliases(&["SET_PART"])
        .options(&["TITLE"]),
    Keyword::new("SET_PART_LIST_GENERATE", LIST, "the same by ranges").options(&["TITLE"]),
    Keyword::new("SET_PART_ADD", LIST, "the same from other sets of parts").options(&["TITLE"]),
    Keyword::new(
        "SET_SEGMENT",
        &[
            ("heading:l", Count(title)),
            ("sid:i! da1:r da2:r da3:r da4:r solver:a its:a", Once),
            ("n:i*4 a:r*4", Rest),
        ],
        "faces for LOAD_SEGMENT_SET, and parts for contact",
    )
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_CURVE",
        &[
            ("heading:l", Count(title)),
            ("lcid:i! sidr:i sfa:r=1 sfo:r=1 offa:r offo:r dattyp:i lcint:i", Once),
            ("a:r20 o:r20", Rest),
        ],
        "`[[curve]]`, or a table of a material; constant outside its points",
    )
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_TABLE",
        &[("heading:l", Count(title)), ("tbid:i! sfa:r=1 offa:r", Once), ("value:r20", Rest)],
        "friction by pressure and speed (fs 2); a `*DEFINE_CURVE` for each value must follow",
    )
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_TABLE_2D",
        &[
            ("heading:l", Count(title)),
            ("tbid:i! sfa:r=1 offa:r", Once),
            ("value:r20 curveid:i20", Rest),
        ],
        "the same, with the id of the curve for each value",
    )
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_BOX",
        &[("heading:l", Count(title)), ("boxid:i! xmn:r xmx:r ymn:r ymx:r zmn:r zmx:r", Once)],
        "a box for sets and initial velocities",
    )
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_SD_ORIENTATION",
        &[("vid:i! iop:i xt:r yt:r zt:r nid1:i nid2:i", Rest)],
        "`spring.direction`; iop has to be 0",
    ),
    Keyword::new(
        "DEFINE_COORDINATE_SYSTEM",
        &[
            ("heading:l", Count(title)),
            ("cid:i! xo:r yo:r zo:r xl:r yl:r zl:r cidl:i", Once),
            ("xp:r yp:r zp:r", Once),
        ],
        "axes for initial velocities and constraints",
    )
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_COORDINATE_NODES",
        &[("heading:l", Count(title)), ("cid:i! n1:i! n2:i! n3:i! flag:i dir:a", Once)],
        "the same by three nodes at their initial positions",
    )
    .options(&["TITLE"]),
];
