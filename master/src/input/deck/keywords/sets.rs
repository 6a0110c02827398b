//! Sets, curves, boxes, coordinate systems, and keywords that do not change a model by
//! themselves.

use super::title;
use crate::input::deck::table::{Effect::*, Keyword, Times::*, UnusedFields, ignored, no_effect};

const LIST: &[(&str, crate::input::deck::table::Times)] = &[
    ("heading:l", Count(title)),
    ("sid:i! da1:r da2:r da3:r da4:r solver:a its:a", Once),
    ("id:i*8", Rest),
];

const ATTRIBUTES: &[UnusedFields] =
    &[no_effect("da1 da2 da3 da4 solver its a", "no keyword here refers to attributes of a set")];
/// Options of sets: with COLLECT, cards with the same id are one set.
const COLLECTED: &[&str] = &["TITLE", "COLLECT"];
/// Attributes of sets of parts.
const OF_PARTS: &[UnusedFields] = &[
    no_effect("da1 da2 da3 da4", "only CONTACT_INTERIOR refers to attributes of a set"),
    no_effect("solver its a", "no keyword here refers to them"),
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
    Keyword::new(
        "PARAMETER_DUPLICATION",
        &[("dflag:i=1", Once)],
        "for a second value of a parameter: 1 and 5 keep the first one, 2 and 4 take the last one, \
         3 is an error; 1 and 2 warn of it",
    ),
    Keyword::new(
        "CASE",
        &[("caseid:i! jobid:a70", Once), ("commands:l", Maybe), ("scid:i*8", Rest)],
        "a case of the deck: keywords of its subcases scid (of subcase caseid without any), and \
         those of no subcase. `--case` or `mesh.case` chooses it; a single one needs no choice. \
         commands is not used",
    ),
    Keyword::new(
        "CASE_BEGIN",
        &[],
        "CASE_BEGIN_n: the keywords up to CASE_END_n belong to subcase n, as does a keyword with \
         CID=n on its line. Without CASE each subcase is a case",
    ),
    Keyword::new("CASE_END", &[], "the end of CASE_BEGIN_n"),
    Keyword::new(
        "SET_NODE_LIST",
        LIST,
        "node set `set-SID`, and the same set under its title; with COLLECT, cards with the same \
         id are one set",
    )
    .aliases(&["SET_NODE"])
    .unused(ATTRIBUTES)
    .options(COLLECTED),
    Keyword::new("SET_NODE_LIST_GENERATE", LIST, "the same by ranges: first and last id of each")
        .unused(ATTRIBUTES)
        .options(COLLECTED),
    Keyword::new(
        "SET_NODE_COLUMN",
        &[
            ("heading:l", Count(title)),
            ("sid:i! da1:r da2:r da3:r da4:r solver:a its:a", Once),
            ("nid:i a:r*4", Rest),
        ],
        "the same, one node per line",
    )
    .unused(ATTRIBUTES)
    .options(&["TITLE"]),
    Keyword::new("SET_NODE_ADD", LIST, "the same from other node sets")
        .unused(ATTRIBUTES)
        .options(&["TITLE"]),
    Keyword::new("SET_NODE_INTERSECT", LIST, "the nodes that all of these sets have")
        .unused(ATTRIBUTES)
        .options(&["TITLE"]),
    Keyword::new(
        "SET_NODE_ADD_ADVANCED",
        &[
            ("heading:l", Count(title)),
            ("sid:i! da1:r da2:r da3:r da4:r", Once),
            ("id:i type:i=1 id:i type:i=1 id:i type:i=1 id:i type:i=1", Rest),
        ],
        "the same from sets of nodes (type 1), shells (2), solids (4), segments (5) or springs (6)",
    )
    .unused(ATTRIBUTES)
    .options(&["TITLE"]),
    Keyword::new(
        "SET_NODE_GENERAL",
        &[
            ("heading:l", Count(title)),
            ("sid:i! da1:r da2:r da3:r da4:r solver:a its:a", Once),
            ("option:a! e:i*7", Rest),
        ],
        "the same by ALL, NODE, PART, BOX, SET_NODE, SET_PART; the prefix D removes nodes",
    )
    .unused(ATTRIBUTES)
    .options(&["TITLE"]),
    Keyword::new("SET_PART_LIST", LIST, "a set of parts")
        .aliases(&["SET_PART"])
        .unused(OF_PARTS)
        .options(COLLECTED),
    Keyword::new("SET_PART_LIST_GENERATE", LIST, "the same by ranges")
        .unused(OF_PARTS)
        .options(COLLECTED),
    Keyword::new("SET_PART_ADD", LIST, "the same from other sets of parts")
        .unused(OF_PARTS)
        .options(&["TITLE"]),
    Keyword::new(
        "SET_PART_TREE",
        &[("card:l", Rest)],
        "not read: a tree of parts for pre-processors; name parts by SET_PART_LIST",
    )
    .options(&["TITLE"])
    .effect(Harmless),
    Keyword::new(
        "SET_SEGMENT",
        &[
            ("heading:l", Count(title)),
            ("sid:i! da1:r da2:r da3:r da4:r solver:a its:a", Once),
            ("n:i*4 a:r*4", Rest),
        ],
        "faces for LOAD_SEGMENT_SET, and parts for contact",
    )
    .unused(ATTRIBUTES)
    .options(&["TITLE"]),
    Keyword::new(
        "SET_SEGMENT_GENERAL",
        &[
            ("heading:l", Count(title)),
            ("sid:i! da1:r da2:r da3:r da4:r solver:a its:a", Once),
            // Real attributes follow the ids, whose number depends on the option.
            ("option:a! e:r*7", Rest),
        ],
        "the same by ALL, SEG, PART, SHELL, SET, SET_SHELL, SET_SOLID, BOX, BOX_SHELL and \
         BOX_SOLID: all shells, and the faces of solids that no other solid of the part has. DSEG, \
         DPART and DBOX remove segments",
    )
    .unused(ATTRIBUTES)
    .options(&["TITLE"]),
    Keyword::new("SET_SEGMENT_ADD", LIST, "the same from other sets of segments")
        .unused(ATTRIBUTES)
        .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_CURVE",
        &[
            ("heading:l", Count(title)),
            ("lcid:i! sidr:i sfa:r=1 sfo:r=1 offa:r offo:r dattyp:i lcint:i", Once),
            ("a:r20 o:r20", Rest),
        ],
        "`[[curve]]`, or a table of a material; constant outside its points. A load or motion by a \
         curve with sidr 1 (dynamic relaxation) is left out",
    )
    .unused(&[no_effect("dattyp lcint", "curves are used as they are, at all their points")])
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_TABLE",
        &[("heading:l", Count(title)), ("tbid:i! sfa:r=1 offa:r", Once), ("value:r20", Rest)],
        "friction by pressure and speed (fs 2), or curves of a material by strain rate; a \
         `*DEFINE_CURVE` for each value must follow",
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
        &[("heading:l", Count(title)), ("vid:i! iop:i xt:r yt:r zt:r nid1:i nid2:i", Rest)],
        "`spring.direction`, or with iop 2 and 3 `direction_nodes`; with iop 1 and 3 `projected`. \
         The nodes have to belong to elements or to rigid bodies",
    )
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_VECTOR",
        &[("heading:l", Count(title)), ("vid:i! xt:r yt:r zt:r xh:r yh:r zh:r cid:i", Rest)],
        "direction from the tail to the head, in the axes of cid, for \
         CONSTRAINED_RIGID_BODY_STOPPERS and prescribed motions",
    )
    .options(&["TITLE"]),
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
        "DEFINE_TRANSFORMATION",
        &[
            ("heading:l", Count(title)),
            ("tranid:i!", Once),
            ("option:a! a1:r a2:r a3:r a4:r a5:r a6:r a7:r", Rest),
        ],
        "a chain of maps for INCLUDE_TRANSFORM and NODE_TRANSFORM, the first line first: TRANSL, \
         SCALE, ROTATE (about a direction through a point, or about the line between two POINT), \
         MIRROR, POS6P, POS6N, TRANSL2ND. A POINT has to be on a line right before its use",
    )
    .options(&["TITLE"]),
    Keyword::new(
        "INCLUDE_TRANSFORM",
        &[
            ("idnoff:i ideoff:i idpoff:i idmoff:i idsoff:i idfoff:i iddoff:i", Maybe),
            ("idroff:i ilctmf:i prefix:a suffix:a", Maybe),
            ("fctmas:r=1 fcttim:r=1 fctlen:r=1 fcttem:a incout1:i fctchg:r", Maybe),
            ("tranid:i", Maybe),
        ],
        "the file on the line after the keyword, with offsets of its ids, in other units (factors \
         on mass, time and length), and moved by a DEFINE_TRANSFORMATION above. Points, vectors \
         and velocities of its cards move with it, degrees of freedom stay along the axes of the \
         deck. After a reflection, elements and faces have their nodes in the reverse order. \
         prefix and suffix are added to headings",
    )
    .unused(&[
        ignored("fcttem", "temperatures of materials stay in their units"),
        ignored("ilctmf", "coordinate systems of the file move with it"),
        no_effect("incout1", "no file with the changed cards is written: see `crumple convert`"),
        no_effect("fctchg", "there are no electric charges"),
    ]),
    Keyword::new(
        "NODE_TRANSFORM",
        &[("trsid:i! nsid:i! immed:i", Rest)],
        "moves the nodes of a set by a DEFINE_TRANSFORMATION, once all of the deck is read",
    )
    .unused(&[no_effect("immed", "sets are those of the whole deck in any case")]),
    Keyword::new(
        "DEFINE_COORDINATE_VECTOR",
        &[("heading:l", Count(title)), ("cid:i! xx:r yx:r zx:r xv:r yv:r zv:r nid:i", Once)],
        "the same by the x axis and a vector in the x-y plane",
    )
    .options(&["TITLE"]),
    Keyword::new(
        "DEFINE_COORDINATE_NODES",
        &[("heading:l", Count(title)), ("cid:i! n1:i! n2:i! n3:i! flag:i dir:a", Once)],
        "the same by three nodes at their initial positions",
    )
    .aliases(&["DEFINE_COORDINATE_NODE"])
    .options(&["TITLE"]),
];
