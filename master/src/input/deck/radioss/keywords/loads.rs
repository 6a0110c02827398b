//! Boundary conditions, initial velocities, loads, masses.

use super::TITLE;
use crate::input::deck::table::{
    Keyword,
    Times::{self, Maybe, Once, Rest},
    UnusedFields, no_effect, refused,
};

const MOTION: &[(&str, Times)] = &[
    TITLE,
    ("fct:i dir:a skew:i sens:i grnod:i! frame:i icoor:i", Once),
    ("ascale:r20=1 fscale:r20=1 tstart:r20 tstop:r20=1e30", Maybe),
];
const MOTION_UNUSED: &[UnusedFields] = &[
    refused("sens", "motion that a sensor starts"),
    refused("frame", "motion in a moving frame"),
    refused("icoor", "cylindrical coordinates"),
];
const FORCE: &[(&str, Times)] =
    &[TITLE, ("fct:i dir:a skew:i sens:i grnod:i itypfun:i=1 ascale:r20=1 fscale:r20=1", Once)];
const SENSOR: UnusedFields = refused("sens", "loads that a sensor starts");
const KIND: UnusedFields = refused("itypfun", "functions of other variables than time");

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "/BCS",
        &[TITLE, ("blank:a3 tra:a3 blank:a1 rot:a3 skew:i grnod:i!", Once)],
        "`[[fix]]`, and `fixed` of a body if the group has its main node",
    ),
    Keyword::new(
        "/INIVEL/TRA",
        &[TITLE, ("vx:r20 vy:r20 vz:r20 grnod:i! skew:i", Once)],
        "`[[initial_velocity]]`; that of a main node holds for its body",
    ),
    Keyword::new(
        "/INIVEL/ROT",
        &[TITLE, ("vx:r20 vy:r20 vz:r20 grnod:i skew:i", Once)],
        "spin of a body whose main node is in the group; of single nodes it is not supported",
    ),
    Keyword::new(
        "/INIVEL/AXIS",
        &[TITLE, ("dir:a frame:i grnod:i", Once), ("vxt:r20 vyt:r20 vzt:r20 vr:r20", Once)],
        "`[[initial_velocity]]` with spin about a global axis",
    )
    .unused(&[refused("frame", "an axis of another system")]),
    Keyword::new(
        "/IMPVEL",
        MOTION,
        "`[[motion]]` by velocity, of a group or of the body of a main node; of the node of a \
         wall, the velocity of the wall",
    )
    .unused(MOTION_UNUSED),
    Keyword::new("/IMPDISP", MOTION, "`[[motion]]` by displacement").unused(MOTION_UNUSED),
    Keyword::new("/IMPACC", MOTION, "`[[motion]]` by acceleration").unused(MOTION_UNUSED),
    Keyword::new("/CLOAD", FORCE, "`[[load]]`: the force acts on each node of the group")
        .unused(&[SENSOR, KIND]),
    Keyword::new(
        "/PLOAD",
        &[
            TITLE,
            ("surf:i! fct:i sens:i ipinch:i idel:i=1 blank:a10 ascale:r20=1 fscale:r20=1", Once),
        ],
        "`[[pressure]]` on the faces of a surface; a positive value acts along their normals (by \
         the right-hand rule), so the `pressure` of the job has the other sign",
    )
    .unused(&[SENSOR, refused("ipinch idel", "other forms of pressure")]),
    Keyword::new(
        "/GRAV",
        FORCE,
        "`[[gravity]]` on the whole model, of `parts` if the group has their nodes, or of `nodes`",
    )
    .unused(&[SENSOR, KIND]),
    Keyword::new(
        "/DAMP",
        &[
            TITLE,
            ("alpha:r20 beta:r20 grnod:i skew:i tstart:r20 tstop:r20=1e30", Once),
            ("others:r20*2", Rest),
        ],
        "`time.damping` of the whole model, or `[[damping]]` of `parts` if the group has their \
         nodes, with alpha. The engine file may give other values",
    )
    .unused(&[
        refused("others", "damping that depends on the direction"),
        no_effect("skew", "damping is the same in all directions"),
    ]),
    Keyword::new(
        "/ADMAS",
        &[("kind:i0 id:i0 unit:i0", Once), TITLE, ("mass:r20 of:i iflag:i", Rest)],
        "`[[mass]]`. Kind 0: on each node of a group; 1: on the whole group; 5: on single nodes. \
         On a main node it is on the nodes of the body",
    )
    .unused(&[refused("iflag", "shares by area")]),
];
