//! Materials of cohesive elements.

use super::title;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    no_effect,
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
];
