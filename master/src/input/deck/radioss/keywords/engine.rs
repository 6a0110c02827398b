//! Keywords of the engine file. Their lines are words, in any columns.

use super::{ANY, harmless};
use crate::input::deck::table::{
    Keyword,
    Times::{self, Maybe, Once},
    ignored, no_effect, refused,
};

const INTERVAL: &[(&str, Times)] = &[("tstart:r dt:r!", Once)];
/// Name of `/DAMP` in the engine file, where it has other fields than in the starter file.
pub const ENGINE_DAMP: &str = "/DAMP/ENGINE";
const STEP: &[(&str, Times)] = &[("scale:r dtmin:r", Maybe)];

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new("/RUN", &[("tend:r!", Once)], "`end_time`").options(ANY),
    Keyword::new("/TFILE", &[("dt:r!", Once)], "`output.history_interval`").options(ANY),
    Keyword::new("/ANIM/DT", INTERVAL, "`output.field_interval`")
        .unused(&[no_effect("tstart", "fields begin at the start")]),
    Keyword::new("/H3D/DT", INTERVAL, "`output.field_interval`")
        .unused(&[no_effect("tstart", "fields begin at the start")]),
    Keyword::new("/DT", STEP, "`time.safety`; a smallest step is not supported")
        .unused(&[refused("dtmin", "a smallest step; use /DT/NODA/CST")]),
    Keyword::new("/DT/NODA", STEP, "`time.safety`; steps are those of elements")
        .unused(&[refused("dtmin", "a smallest step; use /DT/NODA/CST")]),
    Keyword::new(
        "/DT/NODA/CST",
        &[("scale:r dtmin:r massratio:r", Maybe)],
        "`time.safety`, and `time.mass_scaling_dt`: the smallest step over the scale, as mass is \
         added before the safety factor",
    )
    .aliases(&["/DT/NODA/CST1", "/DT/NODA/CST2"])
    .unused(&[ignored(
        "massratio",
        "the smallest step is dtmin: no larger one is computed from a \
                                    ratio of added mass, so less mass is added and a run takes \
                                    more cycles",
    )]),
    Keyword::new(
        "/DT/BRICK",
        STEP,
        "`time.safety`; elements are not deleted and their strains not made small for a step",
    )
    .aliases(&["/DT/SHELL", "/DT/SH_3N", "/DT/BEAM", "/DT/TRUSS", "/DT/SPRING", "/DT/INTER"])
    .options(ANY)
    .unused(&[refused("dtmin", "deletion or small strains for a step; use /DT/NODA/CST")]),
    Keyword::new("/DTIX", &[("dtini:r dtmax:r", Once)], "`time.dt_max`")
        .unused(&[no_effect("dtini", "the first step is that of the elements")]),
    Keyword::new(
        ENGINE_DAMP,
        &[("alpha:r beta:r", Once)],
        "alpha of the `/DAMP` of the starter with this number; written as `/DAMP`",
    ),
    harmless("/ANIM", "docs/guide/output.md lists the fields of a run").options(ANY),
    harmless("/H3D", "docs/guide/output.md lists the fields of a run").options(ANY),
    harmless("/PRINT", "progress is printed in its own interval").options(ANY),
    harmless("/VERS", "it is the version of the format").options(ANY),
    harmless("/STOP", "the run stops by its own energy and mass limits").options(ANY),
    harmless("/MON", "times of phases are always measured").options(ANY),
    harmless("/RFILE", "see [checkpoint] of a job").options(ANY),
    harmless("/PARITH", "results do not depend on the number of workers").options(ANY),
    harmless("/PROC", "--workers sets the number of workers").options(ANY),
    harmless("/OUTP", "docs/guide/output.md lists the fields of a run").options(ANY),
    harmless("/STATE", "the last fields and checkpoints have the state").options(ANY),
    harmless("/ABF", "docs/guide/output.md lists the histories of a run").options(ANY),
    harmless("/RBODY/ON", "rigid bodies are on from the start").options(ANY),
    harmless("/DT1TET10", "each element has its own bound of the stable step"),
    harmless("/TH/TITLE", "histories have the names of their parts and nodes"),
    harmless("/TH/VERS", "histories have one format").options(ANY),
];
