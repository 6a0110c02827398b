//! Thermoplastics.

use super::title;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    ignored, no_effect, refused,
};

const TITLE: (&str, Times) = ("heading:l", Count(title));

pub const KEYWORDS: &[Keyword] = &[Keyword::new(
    "MAT_SAMP-1",
    &[
        TITLE,
        ("mid:i! ro:r! bulk:r gmod:r emod:r! nue:r rbcfac:r numint:r", Once),
        ("lcid_t:i! lcid_c:i lcid_s:i lcid_b:i nuep:r lcid_p:i blank1:r incdam:r", Once),
        ("lcid_d:i epfail:r=1e5 deprpt:r lcid_tri:i lcid_lc:i", Maybe),
        ("miter:i=400 mipds:i=10 blank2:r incfail:r iconv:r asaf:r=1 blank3:r nhsv:i=22", Maybe),
        ("lcemod:i beta:r filt:r", Maybe),
    ],
    "law `polymer`: lcid_t is `tension`, or `tension_by_rate` if it is a table; lcid_c, lcid_s \
         are `compression`, `shear`, with the same effect of the rate; nuep, lcid_p \
         `plastic_poisson`, `plastic_poisson_curve`; lcid_d above 0 `damage`; epfail, deprpt \
         `failure_strain`, `fading_strain`, unless incfail is -1; iconv 1 with asaf `convexity`, \
         iconv 2 lowers `poisson` to nuep; numint for shells (1 if it is blank). A failure strain \
         by triaxiality or size is that of MAT_ADD_DAMAGE_GISSMO",
)
.unused(&[
    no_effect("bulk gmod", "the moduli follow from emod and nue"),
    no_effect("blank1 blank2 blank3", "the format has no such fields"),
    no_effect("miter mipds", "the return to the surface is exact"),
    no_effect("nhsv", "it is for output"),
    no_effect("beta", "it is for lcemod"),
    ignored("filt", "the rate is a running mean over 12 steps"),
    refused("rbcfac lcid_b", "a surface through biaxial tests; use 0"),
    refused("incdam lcid_tri lcid_lc", "damage and failure by triaxiality or size; use 0"),
    refused("lcemod", "a modulus by the strain rate; use 0"),
])
.aliases(&["MAT_187"])
.options(&["TITLE"])];
