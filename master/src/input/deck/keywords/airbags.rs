//! Airbags: control volumes with uniform pressure.

use super::id;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{Keyword, Times::*, UnusedFields, ignored, no_effect, refused};

/// The first card of all airbags.
const HEAD: &str = "sid:i! sidtyp:i rbid:i vsca:r=1 psca:r=1 vini:r mwd:r spsf:r";
const TITLE: &str = "id:i heading:a70";

const RBID: UnusedFields = refused("rbid", "sensors: shift the curves of the gas to its start");
const SCALES: UnusedFields =
    refused("vsca psca vini", "scaled volumes and pressures: change the gas instead");
const MWD: UnusedFields = ignored("mwd", "bags have no damping of their own; see `time.damping`");
const SPSF: UnusedFields = refused("spsf", "pressure of the air in front of the bag");

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "AIRBAG_SIMPLE_PRESSURE_VOLUME",
        &[(TITLE, Count(id)), (HEAD, Once), ("cn:r beta:r lcid:i lciddr:i", Once)],
        "`[[airbag]]` with the gauge pressure `inverse_pressure` (beta cn; a negative cn is a \
         curve) or `pressure_over_volume` (lcid). A number at the end of the name of an airbag is \
         not used",
    )
    .unused(&[RBID, SCALES, MWD, SPSF, no_effect("lciddr", "there is no dynamic relaxation")])
    .options(&["ID"]),
    Keyword::new(
        "AIRBAG_LOAD_CURVE",
        &[(TITLE, Count(id)), (HEAD, Once), ("stime:r lcid:i ro:r pe:r p0:r t:r t0:r", Once)],
        "`[[pressure]]` on the surface of the bag, the curve lcid over time, outwards",
    )
    .unused(&[
        RBID,
        SCALES,
        MWD,
        SPSF,
        no_effect("ro pe p0 t t0", "they are for a bag without a curve"),
    ])
    .options(&["ID"]),
    Keyword::new(
        "AIRBAG_SIMPLE_AIRBAG_MODEL",
        &[
            (TITLE, Count(id)),
            (HEAD, Once),
            ("cv:r cp:r t:r lcid:i mu:r area:r pe:r ro:r", Once),
            ("lou:i text:r a:r b:r mw:r gasc:r", Maybe),
        ],
        "`[[airbag]]` with a gas. It starts with the ambient pressure pe, and the temperature text \
         (with cv 0), that of the ambient density ro, or t. Inflow \
         lcid with the temperature t. Vents: an orifice with the coefficient mu and the area (if \
         negative, a curve over absolute pressure), and the rate lou over gauge pressure. With cv \
         0 the heat capacity is a/mw and the gas constant gasc/mw",
    )
    .unused(&[RBID, SCALES, MWD, SPSF])
    .options(&["ID"]),
    Keyword::new(
        "AIRBAG_ADIABATIC_GAS_MODEL",
        &[(TITLE, Count(id)), (HEAD, Once), ("psf:r=1 lcid:i gamma:r! p0:r! pe:r ro:r", Once)],
        "`[[airbag]]` with a gas of constant mass: the absolute pressure p0 at the start changes \
         as V^-gamma; pe acts outside",
    )
    .unused(&[
        RBID,
        SCALES,
        MWD,
        SPSF,
        refused("psf", "a scale of the pressure: scale p0 and pe"),
        refused("lcid", "a pressure that is applied before the gas"),
    ])
    .options(&["ID"]),
    Keyword::new(
        "AIRBAG_WANG_NEFSKE",
        &[
            (TITLE, Count(id)),
            (HEAD, Once),
            ("cv:r cp:r t:r lct:i lcmt:i! tvol:r lcdt:i iabt:r", Once),
            ("c23:r lcc23:i a23:r lca23:i cp23:r lccp23:i ap23:r lcap23:i", Once),
            ("pe:r ro:r gc:r=1 lcefr:i pover:r ppop:r opt:i knkdn:i", Once),
            ("ioc:r ioa:r ivol:r iro:r it:r lcbf:i", Maybe),
            ("text:r a:r b:r mw:r gasc:r hconv:r", AtMost(molar)),
            ("tdp:r axp:r ayp:r azp:r amagp:r tdurp:r tda:r rbidp:i", Maybe),
        ],
        "`[[airbag]]` with a gas. It starts with the pressure pe + pover and the temperature iabt, \
         text (with cv 0), that of the ambient density ro, or t. Inflow lcmt with the temperature \
         t or lct. Vents: an orifice (coefficient c23 or lcc23 over time, area a23 or lca23 over \
         absolute pressure) that opens at ppop, the leakage of the fabric (cp23, lccp23, ap23, \
         lcap23), and the rate lcefr over gauge pressure. With cv 0 the heat capacity is a/mw and \
         the gas constant gasc/mw",
    )
    .unused(&[
        RBID,
        SCALES,
        MWD,
        SPSF,
        refused("tvol lcdt", "tests of inflators in a tank: give the mass rate as lcmt"),
        refused("ioc ioa ivol iro it lcbf", "models of inflators: give the mass rate as lcmt"),
        refused("opt", "porosity by the material of the fabric: give cp23 and ap23"),
        no_effect("knkdn", "it is for jets"),
        refused("hconv", "loss of heat through the fabric"),
        refused("tdp axp ayp azp amagp tdurp tda rbidp", "vents that open by time or acceleration"),
    ])
    .options(&["ID"]),
];

/// Returns 1 if the gas is given by mole.
fn molar(record: &CardRecord) -> usize {
    usize::from(record.real("cv") == 0.0)
}
