//! Groups of nodes and elements, surfaces, functions, boxes and systems.

use super::TITLE;
use crate::input::deck::table::{
    Keyword,
    Times::{self, Maybe, Once, Rest},
    refused,
};

const IDS: &[(&str, Times)] = &[TITLE, ("ids:i*10", Rest)];

/// Creates a group or a surface by ids.
const fn of_ids(name: &'static str, note: &'static str) -> Keyword {
    Keyword::new(name, IDS, note)
}

pub const KEYWORDS: &[Keyword] = &[
    of_ids("/GRNOD/NODE", "node set `set-ID`, also under its title"),
    of_ids("/GRNOD/PART", "nodes of parts"),
    of_ids("/GRNOD/SUBSET", "nodes of the parts of subsets"),
    of_ids("/GRNOD/MAT", "nodes of the parts of materials"),
    of_ids("/GRNOD/PROP", "nodes of the parts of properties"),
    of_ids("/GRNOD/GRNOD", "nodes of groups; a negative id removes those of a group"),
    of_ids("/GRNOD/BOX", "nodes in boxes"),
    of_ids("/GRNOD/SURF", "nodes of surfaces"),
    of_ids("/GRNOD/GENE", "nodes of ranges of ids").aliases(&["/GRNOD/GENERATE"]),
    of_ids("/GRNOD/GRSHEL", "nodes of groups of elements").aliases(&[
        "/GRNOD/GRSH3N",
        "/GRNOD/GRBRIC",
        "/GRNOD/GRBEAM",
        "/GRNOD/GRTRUS",
        "/GRNOD/GRSPRI",
    ]),
    of_ids("/GRSHEL/SHEL", "a group of elements by their ids, for groups of nodes").aliases(&[
        "/GRSH3N/SH3N",
        "/GRBRIC/BRIC",
        "/GRBEAM/BEAM",
        "/GRTRUS/TRUS",
        "/GRSPRI/SPRI",
    ]),
    of_ids("/GRSHEL/PART", "a group of elements by their parts").aliases(&[
        "/GRSH3N/PART",
        "/GRBRIC/PART",
        "/GRBEAM/PART",
        "/GRTRUS/PART",
        "/GRSPRI/PART",
    ]),
    of_ids("/SURF/PART", "all faces of parts; those within solids are never in contact")
        .aliases(&["/SURF/PART/EXT", "/SURF/PART/ALL"]),
    of_ids("/SURF/SUBSET", "all faces of the parts of subsets")
        .aliases(&["/SURF/SUBSET/EXT", "/SURF/SUBSET/ALL"]),
    of_ids("/SURF/MAT", "all faces of the parts of materials")
        .aliases(&["/SURF/MAT/EXT", "/SURF/MAT/ALL"]),
    of_ids("/SURF/PROP", "all faces of the parts of properties")
        .aliases(&["/SURF/PROP/EXT", "/SURF/PROP/ALL"]),
    of_ids("/SURF/SURF", "faces of surfaces"),
    of_ids("/SURF/GRSHEL", "the parts of groups of elements").aliases(&[
        "/SURF/GRSH3N",
        "/SURF/GRBRIC",
        "/SURF/GRBRIC/EXT",
        "/SURF/GRBRIC/FREE",
    ]),
    Keyword::new(
        "/SURF/SEG",
        &[TITLE, ("seg:i n:i*4", Rest)],
        "faces by their nodes, for pressure and ties; contact takes their whole parts",
    ),
    of_ids("/LINE/PART", "edges of parts, for `/INTER/TYPE11`").aliases(&["/LINE/SUBSET"]),
    of_ids("/LINE/SURF", "edges of surfaces").aliases(&["/LINE/EDGE"]),
    Keyword::new(
        "/SET/GENERAL",
        &[TITLE, ("key:a ids:i*9", Rest)],
        "a group of nodes and a surface of the same id. Keys: ALL, NODE, PART, SUBS, MAT, PROP, \
         SET, BOX, SEG, NODE_G (first id, last id, increment); one that ends in _D is taken away",
    )
    .aliases(&["/SET/COLLECT", "/SET"]),
    Keyword::new(
        "/FUNCT",
        &[TITLE, ("x:r20 y:r20", Rest)],
        "`[[curve]]` of loads, hardening of materials, force of springs",
    ),
    Keyword::new(
        "/FUNCT_SMOOTH",
        &[
            TITLE,
            ("ascalex:r20=1 fscaley:r20=1 ashiftx:r20 fshifty:r20", Once),
            ("x:r20 y:r20", Rest),
        ],
        "`[[curve]]` with points on the smooth steps between those of the card; constant beyond",
    ),
    Keyword::new(
        "/BOX/RECTA",
        &[
            TITLE,
            ("n1:i n2:i skew:i", Once),
            ("xp1:r20 yp1:r20 zp1:r20", Maybe),
            ("xp2:r20 yp2:r20 zp2:r20", Maybe),
        ],
        "a box for groups of nodes",
    )
    .unused(&[refused("skew", "boxes along other axes than the global ones")]),
    Keyword::new(
        "/SKEW/FIX",
        &[
            TITLE,
            ("ox:r20 oy:r20 oz:r20", Once),
            ("x1:r20 y1:r20 z1:r20", Once),
            ("x2:r20 y2:r20 z2:r20", Once),
        ],
        "a system for velocities; conditions along its axes are not supported unless they are the \
         global ones",
    ),
];
