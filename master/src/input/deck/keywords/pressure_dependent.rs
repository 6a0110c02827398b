//! Ceramics, concrete in high pressures, and soil: materials with strength by pressure.

use super::title;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    ignored,
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
