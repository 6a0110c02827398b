//! Ceramics, concrete in high pressures, and soil: materials with strength by pressure.

use super::title;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    ignored, no_effect,
};

const TITLE: (&str, Times) = ("heading:l", Count(title));

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "MAT_JOHNSON_HOLMQUIST_CERAMICS",
        &[
            TITLE,
            ("mid:i! ro:r! g:r! a:r! b:r c:r m:r n:r", Once),
            ("epsi:r t:r sfmax:r hel:r! phel:r! beta:r", Once),
            ("d1:r d2:r k1:r! k2:r k3:r fs:r", Once),
        ],
        "law `johnson_holmquist_ceramic`, for solids: a, n `intact_strength`; b, m \
         `fractured_strength`; c, epsi `rate`; fs below 0 `fails_in_tension`, above 0 \
         `failure_strain`",
    )
    .aliases(&["MAT_110"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_JOHNSON_HOLMQUIST_CONCRETE",
        &[
            TITLE,
            ("mid:i! ro:r! g:r! a:r! b:r c:r n:r fc:r!", Once),
            ("t:r eps0:r efmin:r sfmax:r pc:r! uc:r! pl:r! ul:r!", Once),
            ("d1:r d2:r k1:r! k2:r k3:r fs:r", Once),
        ],
        "law `johnson_holmquist_concrete`, for solids: a, b, n `strength_constants`; c, eps0 \
         `rate`; uc, pc `crushing_point`; ul, pl `locking_point`; fs 0 `fails_in_tension`, below 0 \
         `fails_in_damaged_tension`, above 0 `failure_strain`",
    )
    .aliases(&["MAT_111"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_CONCRETE_DAMAGE_REL3",
        &[
            TITLE,
            ("mid:i! ro:r! pr:r!", Once),
            ("ft:r a0:r! a1:r a2:r b1:r omega:r a1f:r", Once),
            ("slambda:r nout:r edrop:r rsize:r ucf:r lcrate:i locwidth:r npts:r", Maybe),
            ("lambda:r*8", Maybe),
            ("lambda9:r*5 b3:r a0y:r a1y:r", Maybe),
            ("eta:r*8", Maybe),
            ("eta9:r*5 b2:r a2f:r a2y:r", Maybe),
        ],
        "law `karagozian_case_concrete`, for solids: ft `tensile_strength`; a0 to a2 \
         `largest_surface`, a0y to a2y `yield_surface`, a1f and a2f `residual_surface`; lambda and \
         eta `damage_curve`; b1, b2, b3 `damage_scaling`; omega, edrop `dilatancy`; lcrate \
         `rate_factors`; the EOS_TABULATED_COMPACTION of the part is `compaction`. A0 below 0 is \
         minus the strength of a bar, 1000 to 20000 psi by ucf: all that is 0 follows from it, and \
         so does the compaction if the part has no eosid; its bulk modulus, 14.53 GPa at 45.4 MPa \
         and by the root of the strength, is a number from memory",
    )
    .unused(&[
        no_effect("nout", "it is for output; the damage is in the fields"),
        no_effect("rsize", "it is for locwidth"),
        ignored("slambda", "the damage curve is not stretched"),
        ignored("locwidth", "damage does not depend on the size of elements"),
    ])
    .aliases(&["MAT_072R3", "MAT_72R3"])
    .options(&["TITLE"]),
    Keyword::new(
        "EOS_TABULATED_COMPACTION",
        &[
            TITLE,
            ("eosid:i! gama:r e0:r v0:r lcc:i lct:i lck:i lcid:i", Once),
            ("ev:r16*5", Count(without_curves)),
            ("c:r16*5", Count(without_curves)),
            ("t:r16*5", Count(without_curves)),
            ("k:r16*5", AtMost(without_curves)),
        ],
        "`compaction` of the MAT_CONCRETE_DAMAGE_REL3 of parts of solids with this eosid: pressure \
         and modulus of unloading over ln V by ev, c and k, or by the curves lcc and lck; the \
         volume at the start is 1, the energy 0",
    )
    .unused(&[no_effect("lcid", "it is for energy that is deposited")])
    .aliases(&["EOS_008", "EOS_8"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_SOIL_AND_FOAM",
        &[
            TITLE,
            ("mid:i! ro:r! g:r! bulk:r! a0:r a1:r a2:r pc:r", Once),
            ("vcr:r ref:r lcid:i", Once),
            ("eps:r*8", AtMost(|_| 2)),
            ("p:r*8", AtMost(|_| 2)),
        ],
        "law `soil`, for solids: lcid, or eps and p, are `pressure` with the volume strain ln V \
         (below 0 in compression); pc, below 0, is `tension_cutoff`; vcr 1 is `reversible`",
    )
    .unused(&[ignored("ref", "the stress is zero in the mesh as given")])
    .aliases(&["MAT_005", "MAT_5"])
    .options(&["TITLE"]),
];

/// Returns the lines of ten points, which a card without curves has.
fn without_curves(record: &CardRecord) -> usize {
    if record.integer("lcc") == 0 { 2 } else { 0 }
}
