//! Run, units, nodes, elements.

use super::{ANY, TITLE, harmless, not_yet};
use crate::input::deck::table::{
    Keyword,
    Times::{Maybe, Once, Rest},
    ignored, no_effect, refused,
};

pub const MODEL: &[Keyword] = &[
    Keyword::new(
        "/BEGIN",
        &[
            ("text:l", Once),
            ("invers:i irun:i", Once),
            ("inmass:a20 inlength:a20 intime:a20", Maybe),
            ("wmass:a20 wlength:a20 wtime:a20", Maybe),
        ],
        "`units`: the input units. Numbers are not converted to the work units, so results have \
         the input units. Versions before 110 have other columns and are an error",
    )
    .unused(&[no_effect("irun", "a deck is the begin of a run")]),
    Keyword::new("/TITLE", &[("text:l", Once)], "`title`"),
    Keyword::new(
        "/UNIT",
        &[TITLE, ("inmass:a20 inlength:a20 intime:a20", Once)],
        "units of single entities: they have to be those of `/BEGIN`, others are an error",
    ),
    Keyword::new(
        "/PARAMETER/GLOBAL/REAL",
        &[TITLE, ("name:a10 value:r20", Once)],
        "name of a value, which fields use as &name, above the card as well as below",
    ),
    Keyword::new("/PARAMETER/GLOBAL/INTEGER", &[TITLE, ("name:a10 value:i20", Once)], "as above"),
    Keyword::new(
        "/PARAMETER/GLOBAL/REAL_EXPR",
        &[TITLE, ("name:a10 expression:a90", Once)],
        "the same by a formula of numbers and of the names above it",
    ),
    Keyword::new(
        "/PARAMETER/GLOBAL/INT_EXPR",
        &[TITLE, ("name:a10 expression:a90", Once)],
        "as above",
    ),
    harmless("/ANALY", "the analysis is in three dimensions and parallel"),
    harmless("/IOFLAG", "it controls the listing"),
    harmless("/AMS", "it acts only with /DT/AMS in the engine file"),
    harmless("/SPMD", "`[parallel]` of a job divides the model"),
    harmless("/MEMORY", "memory grows with the model"),
    harmless("/SHFRA", "the axes of a shell are those of its formulation").options(ANY),
    harmless(
        "/ALE/BCS",
        "it holds nodes of a mesh that moves on its own; here it moves with the \
        material, which `/BCS` holds",
    ),
    Keyword::new("/RANDOM", &[("noise:r20 seed:r20", Once)], "a noise of 0 is no noise")
        .aliases(&["/RANDOM/GRNOD"])
        .unused(&[
            ignored("noise", "nodes stay where they are, without noise"),
            no_effect("seed", "it is that of the noise"),
        ]),
    harmless("/DEFAULT/INTER/TYPE7", "it has defaults of contact, of which none has a counterpart"),
    harmless("/DEFAULT/INTER/TYPE24", "as above"),
    harmless("/DEFAULT/INTER/TYPE25", "as above"),
    harmless("/DEFAULT/INTER/TYPE11", "as above"),
];

const ANGLE: &str = "shells are isotropic";

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new("/NODE", &[("nid:i! x:r20 y:r20 z:r20", Rest)], "nodes"),
    Keyword::new(
        "/SHELL",
        &[("eid:i! n1:i! n2:i! n3:i! n4:i blank:a10 phi:r20 thick:r20", Rest)],
        "shells of the part in the keyword's line; thick is the thickness of a single shell",
    )
    .unused(&[refused("phi", ANGLE)]),
    Keyword::new(
        "/SH3N",
        &[("eid:i! n1:i! n2:i! n3:i! blank:a20 phi:r20 thick:r20", Rest)],
        "triangles",
    )
    .unused(&[refused("phi", ANGLE)]),
    Keyword::new(
        "/BRICK",
        &[("eid:i! n1:i! n2:i! n3:i! n4:i! n5:i! n6:i! n7:i! n8:i!", Rest)],
        "solids; repeated nodes give wedges and tetrahedra",
    ),
    Keyword::new("/TETRA4", &[("eid:i! n1:i! n2:i! n3:i! n4:i!", Rest)], "tetrahedra"),
    Keyword::new(
        "/TETRA10",
        &[("eid:i!", Rest), ("n1:i! n2:i! n3:i! n4:i! n5:i! n6:i! n7:i! n8:i! n9:i! n10:i!", Rest)],
        "tetrahedra of ten nodes, each on two lines; those that lack some nodes between their \
         corners are not supported",
    ),
    Keyword::new("/PENTA6", &[("eid:i! n1:i! n2:i! n3:i! n4:i! n5:i! n6:i!", Rest)], "wedges"),
    Keyword::new(
        "/BEAM",
        &[("eid:i! n1:i! n2:i! n3:i vx:r20 vy:r20 vz:r20", Rest)],
        "beams; n3, or n1 and the vector, shows the second axis",
    ),
    Keyword::new("/TRUSS", &[("eid:i! n1:i! n2:i!", Rest)], "trusses"),
    Keyword::new(
        "/SPRING",
        &[("eid:i! n1:i! n2:i! n3:i skew:i", Rest)],
        "springs, along the line between their nodes",
    )
    .unused(&[no_effect("n3", "the spring has one direction"), refused("skew", "a system")]),
    not_yet("/BRIC20", "solids of twenty nodes; mesh with eight"),
    not_yet("/SHEL16", "thick shells"),
    not_yet("/SPHCEL", "particles; a job has `part.particles`"),
    not_yet("/QUAD", "elements of plane analyses"),
    not_yet("/TRIA", "elements of plane analyses"),
];
