//! Rigid bodies, walls, contact and ties.

use super::{TITLE, not_yet};
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Keyword,
    Times::{self, AtMost, Count, Maybe, Once},
    UnusedFields, ignored, no_effect, refused,
};

/// Returns 1 if the curvature of an interface needs nodes.
fn curved(record: &CardRecord) -> usize {
    usize::from(matches!(record.integer("icurv"), 1 | 2))
}

/// Returns 1 if a body can fail.
fn fails(record: &CardRecord) -> usize {
    usize::from(record.integer("ifail") != 0)
}

/// Returns 1 if friction has coefficients.
fn has_coefficients(record: &CardRecord) -> usize {
    usize::from(record.integer("ifric") > 0)
}

/// Returns 1 if friction has a sixth coefficient.
fn has_sixth(record: &CardRecord) -> usize {
    usize::from(record.integer("ifric") > 1)
}

const COEFFICIENTS: (&str, Times) =
    ("cf1:r20 cf2:r20 cf3:r20 cf4:r20 cf5:r20", Count(has_coefficients));
const SIXTH: (&str, Times) = ("cf6:r20", Count(has_sixth));

/// Fields of all interfaces that depend on how the penalty of Radioss works.
const PENALTY: &str = "the law of contact finds its own stiffness and damping";
const SEARCH: &str = "the search works without it";
const FRICTION: UnusedFields = ignored("ifiltr xfreq", "friction is not filtered");
const OTHER_FRICTION: UnusedFields = refused("cf3 cf4 cf5 cf6", "only Ifric 0 and 4 are supported");

pub const WALL: (&str, Times) = ("node:i slide:i grnod1:i grnod2:i iform:i", Once);
const REACH: (&str, Times) = ("d:r20 fric:r20 phi:r20 ffac:r20 ifq:i", Once);
const POINT: (&str, Times) = ("p1:r20 p2:r20 p3:r20 p4:r20", Once);
const END: (&str, Times) = ("xm1:r20 ym1:r20 zm1:r20", Once);
const WALL_UNUSED: &[UnusedFields] = &[
    no_effect("iform", "nodes are stopped by a constraint"),
    ignored("ffac ifq", "friction is not filtered"),
];

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "/RBODY",
        &[
            TITLE,
            ("node:i! sens:i skew:i ispher:i mass:r20 grnod:i! ikrem:i icog:i surf:i", Once),
            ("jxx:r20 jyy:r20 jzz:r20", Maybe),
            ("jxy:r20 jyz:r20 jxz:r20", Maybe),
            ("ioptoff:i iexpams:i=2 ifail:i", Maybe),
            ("fn:r20 ft:r20 expn:r20=2 expt:r20=2", AtMost(fails)),
        ],
        "`[[rigid]]` of the nodes of the group. Parts whose nodes are all in it are its `parts`. \
         The main node is no part of the model: conditions on it act on the body. mass is \
         `[[mass]]` in equal shares on its nodes, the inertia is `added_inertia`. Walls do not \
         stop its nodes unless Ikrem is 1. A body whose main node is in the group of another one \
         is a part of that one",
    )
    .unused(&[
        refused("sens", "bodies that a sensor switches"),
        ignored(
            "ispher icog",
            "mass and inertia of the body are those of its nodes and the added ones",
        ),
        no_effect("surf", "contact has the surfaces of the elements"),
        no_effect("ioptoff", "rigid elements compute no forces"),
        no_effect("iexpams", "mass scaling is that of elements"),
        refused("ifail", "bodies that fail"),
        no_effect("fn ft expn expt", "they belong to ifail"),
    ]),
    Keyword::new(
        "/RBE2",
        &[TITLE, ("node:i! blank:a3 tra:a3 blank:a1 rot:a3 skew:i grnod:i! iflag:i", Once)],
        "`[[rigid]]` of the main node and the nodes of the group, if all degrees of freedom are \
         tied",
    )
    .unused(&[no_effect("skew iflag", "all degrees of freedom are tied")]),
    Keyword::new(
        "/RWALL/PLANE",
        &[TITLE, WALL, REACH, POINT, END],
        "`[[wall]]` through M with the normal from M to M1. It stops the nodes of grnd_ID1 and \
         those in front of it up to the distance d, without those of grnd_ID2. With a node, \
         the third line is its mass and initial velocity",
    )
    .unused(WALL_UNUSED),
    Keyword::new("/RWALL/CYL", &[TITLE, WALL, REACH, POINT, END], "a cylinder of diameter Phi")
        .unused(WALL_UNUSED),
    Keyword::new("/RWALL/SPHER", &[TITLE, WALL, REACH, POINT], "a sphere of diameter Phi")
        .unused(WALL_UNUSED),
    Keyword::new(
        "/RWALL/PARAL",
        &[TITLE, WALL, REACH, POINT, END, ("xm2:r20 ym2:r20 zm2:r20", Once)],
        "a rectangle with the sides from M to M1 and from M to M2",
    )
    .unused(WALL_UNUSED),
    Keyword::new(
        "/INTER/TYPE7",
        &[
            TITLE,
            ("grnod:i surf:i istf:i ithe:i igap:i blank:a10 ibag:i idel:i icurv:i iadm:i", Once),
            ("fscalegap:r20 gapmax:r20 fpenmax:r20 blank:a20 itied:i", Once),
            ("stmin:r20 stmax:r20 meshsize:r20 dtmin:r20 iremgap:i iremi2:i", Once),
            ("nc1:i nc2:i", Count(curved)),
            ("stfac:r20 fric:r20 gapmin:r20 tstart:r20 tstop:r20", Once),
            ("blank:a7 ibc:a3 blank:a20 inacti:i viss:r20 visf:r20 bumult:r20", Once),
            ("ifric:i ifiltr:i xfreq:r20 iform:i sens:i fctf:i ascalef:r20 fricid:i", Maybe),
            COEFFICIENTS,
            SIXTH,
        ],
        "contact of the parts of the group of nodes with those of the surface, in both directions. \
         Gapmin with Igap 1000 is `thickness`",
    )
    .unused(&[
        no_effect("istf stmin stmax stfac fpenmax dtmin", PENALTY),
        no_effect("viss visf", PENALTY),
        refused("ithe", "heat in contact"),
        no_effect("ibag", "it is for airbags"),
        no_effect("idel", "faces of failed elements leave the contact"),
        ignored("icurv nc1 nc2", "segments are flat; see `contact.surface`"),
        no_effect("iadm", "the mesh is not refined"),
        ignored("fscalegap gapmax", "the gap is the mean thickness"),
        no_effect("meshsize", SEARCH),
        no_effect("itied", "nodes are not tied by contact"),
        no_effect("iremgap iremi2 bumult", SEARCH),
        no_effect("inacti", "initial penetrations are kept without force"),
        ignored("ibc", "fixed degrees of freedom stay fixed in contact"),
        FRICTION,
        no_effect("iform", "friction has a stick point"),
        refused("sens", "contact that a sensor starts"),
        refused("fctf", "friction as a function"),
        no_effect("ascalef", "it scales that function"),
        refused("fricid", "friction by parts"),
        OTHER_FRICTION,
    ]),
    Keyword::new(
        "/INTER/TYPE19",
        &[
            TITLE,
            ("surf1:i surf2:i istf:i ithe:i igap:i iedge:i ibag:i idel:i icurv:i", Once),
            ("fscalegap:r20 gapmax:r20", Once),
            ("stmin:r20 stmax:r20 meshsize:r20 dtmin:r20 iremgap:i iremi2:i", Once),
            ("nc1:i nc2:i", Count(curved)),
            ("stfac:r20 fric:r20 gapmin:r20 tstart:r20 tstop:r20", Once),
            ("blank:a7 ibc:a3 blank:a20 inacti:i viss:r20 visf:r20 bumult:r20", Once),
            ("ifric:i ifiltr:i xfreq:r20 iform:i sens:i blank:a30 fricid:i", Maybe),
            COEFFICIENTS,
            SIXTH,
        ],
        "contact of two surfaces, in both directions, with `contact.edges`: `/INTER/TYPE7` and \
         `TYPE11` in one",
    )
    .unused(&[
        no_effect("istf stmin stmax stfac dtmin viss visf", PENALTY),
        refused("ithe", "heat in contact"),
        no_effect("iedge", "edges are those of the engine"),
        no_effect("ibag", "it is for airbags"),
        no_effect("idel", "faces of failed elements leave the contact"),
        ignored("icurv nc1 nc2", "segments are flat; see `contact.surface`"),
        ignored("fscalegap gapmax", "the gap is the mean thickness"),
        no_effect("meshsize iremgap iremi2 bumult", SEARCH),
        no_effect("inacti", "initial penetrations are kept without force"),
        ignored("ibc", "fixed degrees of freedom stay fixed in contact"),
        FRICTION,
        no_effect("iform", "friction has a stick point"),
        refused("sens", "contact that a sensor starts"),
        refused("fricid", "friction by parts"),
        OTHER_FRICTION,
    ]),
    Keyword::new(
        "/INTER/TYPE24",
        &[
            TITLE,
            ("surf1:i surf2:i istf:i blank:a20 iremi2:i blank:a10 idel:i", Once),
            ("grnod:i blank:a20 iedge:i edgeangle:r20 gapmaxs:r20 gapmaxm:r20", Once),
            ("stmin:r20 stmax:r20 igap0:i ipen0:i ipenmax:r20", Once),
            ("stfac:r20 fric:r20 blank:a20 tstart:r20 tstop:r20", Once),
            ("blank:a7 ibc:a3 blank:a20 inacti:i viss:r20 blank:a20 tpressfit:r20", Once),
            ("ifric:i ifiltr:i xfreq:r20 blank:a10 sens:i blank:a30 fricid:i", Maybe),
            COEFFICIENTS,
            SIXTH,
        ],
        "contact of a surface with itself, or of two surfaces. Iedge: `contact.edges`",
    )
    .unused(&[
        no_effect("istf stmin stmax stfac viss", PENALTY),
        no_effect("iremi2 idel", "faces of failed elements leave the contact"),
        refused("grnod", "nodes in addition to surfaces; use /INTER/TYPE7"),
        no_effect("edgeangle", "edges are those of the engine"),
        ignored("gapmaxs gapmaxm", "the gap is the mean thickness"),
        no_effect("igap0 ipen0 ipenmax inacti", "initial penetrations are kept without force"),
        ignored("ibc", "fixed degrees of freedom stay fixed in contact"),
        refused("tpressfit", "press fits"),
        FRICTION,
        refused("sens", "contact that a sensor starts"),
        refused("fricid", "friction by parts"),
        OTHER_FRICTION,
    ]),
    Keyword::new(
        "/INTER/TYPE25",
        &[
            TITLE,
            ("surf1:i surf2:i istf:i ithe:i igap:i iremi2:i blank:a10 idel:i iedge:i", Once),
            ("grnod:i blank:a10 gapscale:r20 meshsize:r20 gapmaxs:r20 gapmaxm:r20", Once),
            ("stmin:r20 stmax:r20 igap0:i ishape:i edgeangle:r20", Once),
            ("stfac:r20 fric:r20 blank:a20 tstart:r20 tstop:r20", Once),
            (
                "blank:a7 ibc:a3 blank:a10 ivis2:i inacti:i viss:r20 ithick:i blank:a10 pmax:r20",
                Once,
            ),
            ("ifric:i ifiltr:i xfreq:r20 blank:a10 sens:i blank:a30 fricid:i", Maybe),
            COEFFICIENTS,
            SIXTH,
        ],
        "as `/INTER/TYPE24`; Gap_scale is `thickness_scale`",
    )
    .unused(&[
        no_effect("istf stmin stmax stfac viss", PENALTY),
        refused("ithe", "heat in contact"),
        no_effect("igap meshsize", SEARCH),
        no_effect("iremi2 idel", "faces of failed elements leave the contact"),
        refused("grnod", "nodes in addition to surfaces; use /INTER/TYPE7"),
        ignored("gapmaxs gapmaxm", "the gap is the mean thickness"),
        no_effect("igap0 inacti", "initial penetrations are kept without force"),
        no_effect("ishape edgeangle", "edges are those of the engine"),
        ignored("ibc", "fixed degrees of freedom stay fixed in contact"),
        refused("ivis2", "adhesion"),
        no_effect("ithick", "the contact thickness does not change"),
        ignored("pmax", "the pressure has no limit"),
        FRICTION,
        refused("sens", "contact that a sensor starts"),
        refused("fricid", "friction by parts"),
        OTHER_FRICTION,
    ]),
    Keyword::new(
        "/INTER/TYPE11",
        &[
            TITLE,
            ("lines:i linem:i istf:i ithe:i igap:i blank:a10 iremgap:i idel:i", Once),
            ("stmin:r20 stmax:r20 meshsize:r20 dtmin:r20 iform:i sens:i", Once),
            ("stfac:r20 fric:r20 gapmin:r20 tstart:r20 tstop:r20", Once),
            ("blank:a7 ibc:a3 blank:a20 inacti:i viss:r20 visf:r20 bumult:r20", Maybe),
            ("blank:a70 fricid:i", Maybe),
        ],
        "contact of the parts of lines, with `contact.edges`: their faces are in contact as well",
    )
    .unused(&[
        no_effect("istf stmin stmax stfac dtmin viss visf", PENALTY),
        refused("ithe", "heat in contact"),
        no_effect("igap meshsize iremgap bumult", SEARCH),
        no_effect("idel", "edges of failed elements leave the contact"),
        no_effect("iform", "friction has a stick point"),
        refused("sens", "contact that a sensor starts"),
        ignored("gapmin", "the gap is the mean thickness"),
        ignored("ibc", "fixed degrees of freedom stay fixed in contact"),
        no_effect("inacti", "initial penetrations are kept without force"),
        refused("fricid", "friction by parts"),
    ]),
    Keyword::new(
        "/INTER/TYPE2",
        &[
            TITLE,
            (
                "grnod:i! surf:i! ignore:i spotflag:i level:i isearch:i idel:i blank:a10 \
                 dsearch:r20",
                Once,
            ),
        ],
        "`[[tie]]` with rotations and offset; dsearch is `tolerance`",
    )
    .unused(&[
        no_effect("ignore", "nodes that are too far are not tied, and a warning names them"),
        no_effect("level isearch", SEARCH),
        no_effect("idel", "the node is released when the element of its face fails"),
    ]),
    not_yet("/RBE3", "motion as the mean of other nodes"),
    not_yet("/MPC", "linear conditions"),
    not_yet("/CYL_JOINT", "joints"),
];
