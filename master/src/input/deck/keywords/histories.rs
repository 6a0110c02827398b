//! Quantities recorded over time.

use super::id;
use crate::input::deck::table::{Keyword, Times, Times::*, UnusedFields, ignored, no_effect};

const CROSS_SECTION: (&str, Times) = ("csid:i title:a70", Count(id));
const LIST: &[(&str, Times)] = &[("id:i*8", Rest)];
const NAMED: &[(&str, Times)] = &[("id:i! heading:a70", Rest)];
const ELEMENTS: &[(&str, Times)] = &[
    ("heading:l", Count(super::title)),
    ("sid:i! da1:r da2:r da3:r da4:r", Once),
    ("id:i*8", Rest),
];

const ATTRIBUTES: &[UnusedFields] =
    &[no_effect("da1 da2 da3 da4", "no keyword here refers to attributes of a set")];

const fn elements(name: &'static str, aliases: &'static [&'static str]) -> Keyword {
    Keyword::new(name, ELEMENTS, "elements for DATABASE_CROSS_SECTION_SET")
        .aliases(aliases)
        .unused(ATTRIBUTES)
        .options(&["TITLE", "COLLECT"])
}

const fn ranges(name: &'static str, aliases: &'static [&'static str]) -> Keyword {
    Keyword::new(name, ELEMENTS, "the same by ranges")
        .aliases(aliases)
        .unused(ATTRIBUTES)
        .options(&["TITLE"])
}

const fn general(name: &'static str) -> Keyword {
    Keyword::new(
        name,
        &[
            ("heading:l", Count(super::title)),
            ("sid:i! da1:r da2:r da3:r da4:r", Once),
            ("option:a! e:i*7", Rest),
        ],
        "the same by ALL, ELEM, PART and BOX (elements with all nodes inside); the prefix D \
         removes elements",
    )
    .unused(ATTRIBUTES)
    .options(&["TITLE"])
}

const fn adding(name: &'static str) -> Keyword {
    Keyword::new(name, ELEMENTS, "the same from other sets of these elements")
        .unused(ATTRIBUTES)
        .options(&["TITLE"])
}

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "DATABASE_CROSS_SECTION_SET",
        &[CROSS_SECTION, ("nsid:i! hsid:i bsid:i ssid:i tsid:i dsid:i id:i itype:i", Once)],
        "`[[output.section]]` at the nodes of nsid: force and moment of the elements of hsid, \
         bsid, ssid and dsid on these nodes, in global axes",
    )
    .unused(&[no_effect("itype", "forces are in global axes")])
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "DATABASE_CROSS_SECTION_PLANE",
        &[
            CROSS_SECTION,
            ("psid:i xct:r yct:r zct:r xch:r ych:r zch:r radius:r", Once),
            ("xhev:r yhev:r zhev:r lenl:r lenm:r id:i itype:i", Once),
        ],
        "the same for the elements that the plane cuts: force and moment on their nodes on the \
         side of the tail, so tension points to the head",
    )
    .unused(&[no_effect("itype", "forces are in global axes")])
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "DATABASE_SWFORC",
        &[("dt:r binary:i lcur:i ioopt:i=1", Maybe)],
        "`[[output.section]]` for the force of each spot weld that is a beam or a solid, 200 at \
         most, on its last node or its face of n5 to n8, in global axes",
    )
    .unused(&[
        no_effect("binary ioopt", "histories are text files"),
        ignored("lcur", "the interval of histories is constant"),
    ]),
    Keyword::new("DATABASE_HISTORY_NODE", LIST, "`[[output.node]]`"),
    Keyword::new(
        "DATABASE_HISTORY_NODE_ID",
        NAMED,
        "the same, one node per line, with its heading as name",
    ),
    Keyword::new(
        "DATABASE_HISTORY_NODE_SET",
        LIST,
        "the same by node sets, with their titles as names",
    ),
    Keyword::new(
        "ELEMENT_SEATBELT_ACCELEROMETER",
        &[("sbacid:i! nid1:i! nid2:i! nid3:i! igrav:i intopt:i mass:r", Rest)],
        "`[[output.node]]` of nid1 with the `axes` of the three nodes, named `accelerometer` and \
         sbacid; and `[[mass]]` of mass, a third on each node",
    )
    .unused(&[
        ignored("igrav", "accelerations contain that of gravity, as with igrav 0"),
        ignored("intopt", "velocities are those of the node in its present axes"),
    ]),
    elements("SET_SHELL_LIST", &["SET_SHELL"]),
    ranges("SET_SHELL_LIST_GENERATE", &["SET_SHELL_GENERATE"]),
    adding("SET_SHELL_ADD"),
    elements("SET_SOLID", &["SET_SOLID_LIST"]),
    ranges("SET_SOLID_GENERATE", &["SET_SOLID_LIST_GENERATE"]),
    adding("SET_SOLID_ADD"),
    elements("SET_DISCRETE", &["SET_DISCRETE_LIST"]),
    ranges("SET_DISCRETE_GENERATE", &["SET_DISCRETE_LIST_GENERATE"]),
    adding("SET_DISCRETE_ADD"),
    elements("SET_BEAM", &["SET_BEAM_LIST"]),
    ranges("SET_BEAM_GENERATE", &["SET_BEAM_LIST_GENERATE"]),
    adding("SET_BEAM_ADD"),
    general("SET_SHELL_GENERAL"),
    general("SET_SOLID_GENERAL"),
    general("SET_DISCRETE_GENERAL"),
    general("SET_BEAM_GENERAL"),
];
