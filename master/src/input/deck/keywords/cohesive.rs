//! Materials of cohesive elements.

use super::title;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    no_effect, refused,
};

const TITLE: (&str, Times) = ("heading:l", Count(title));

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "MAT_COHESIVE_MIXED_MODE",
        &[
            TITLE,
            ("mid:i! ro:r! roflg:i intfail:r en:r! et:r! gic:r! giic:r!", Once),
            ("xmu:r! t:r s:r und:r utd:r gamma:r=1", Once),
        ],
        "law `cohesive_mixed_mode`, for solids of elform 19: xmu above 0 is `power_exponent`, \
         below 0 `benzeggagh_kenane`; a strength t or s that is blank follows from und or utd; \
         intfail is `integration` and `failed_points` of the part",
    )
    .aliases(&["MAT_138"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_COHESIVE_ELASTIC",
        &[TITLE, ("mid:i! ro:r! roflg:i intfail:r et:r! en:r! fn_fail:r ft_fail:r", Once)],
        "law `cohesive_elastic`, for solids of elform 19; intfail as in MAT_COHESIVE_MIXED_MODE",
    )
    .aliases(&["MAT_184"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_COHESIVE_TH",
        &[
            TITLE,
            ("mid:i! ro:r! roflg:i intfail:r sigmax:r! nls:r! tls:r! tls2:r", Once),
            ("lamda1:r! lamda2:r! lamdaf:r! stfsf:r isw:i alpha1:r alpha2:r", Once),
            ("dr:r alpha3:r", Maybe),
        ],
        "law `cohesive_tvergaard_hutchinson`, for solids of elform 19: lamda1 and lamda2 over \
         lamdaf are its shares; points unload along the line to the origin; intfail as in \
         MAT_COHESIVE_MIXED_MODE",
    )
    .unused(&[no_effect("tls2 isw alpha1 alpha2 dr alpha3", "they are for shells")])
    .aliases(&["MAT_185"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_COHESIVE_MIXED_MODE_ELASTOPLASTIC_RATE",
        &[
            TITLE,
            ("mid:i! ro:r! roflg:i intfail:r emod:r! gmod:r! thick:r inicrt:r", Once),
            ("g1c_0:r! g1c_inf:r edot_g1:r t0:r! t1:r edot_t:r fg1:r lcg1c:i", Once),
            ("g2c_0:r! g2c_inf:r edot_g2:r s0:r! s1:r edot_s:r fg2:r lcg2c:i", Once),
            ("rfiltf:r", Maybe),
        ],
        "law `cohesive_elastoplastic`, for solids of elform 19: stiffnesses are emod and gmod over \
         thick, which may not be blank; inicrt 0 only; g1c_0, g2c_0, t0 and s0 above 0 only, \
         without rates; fg1 and fg2 above 0 are shares of toughnesses, below 0 of openings; \
         intfail as in MAT_COHESIVE_MIXED_MODE",
    )
    .unused(&[
        no_effect(
            "g1c_inf edot_g1 t1 edot_t g2c_inf edot_g2 s1 edot_s rfiltf",
            "they are for rates, which g1c_0, t0, g2c_0 and s0 below 0 ask for",
        ),
        refused("lcg1c lcg2c", "toughnesses do not depend on the thickness"),
    ])
    .aliases(&["MAT_240"])
    .options(&["TITLE"]),
];
