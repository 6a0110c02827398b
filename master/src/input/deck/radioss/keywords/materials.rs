//! Materials.

use super::{TITLE, not_yet};
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Keyword,
    Times::{self, AtMost, Maybe, Once, Rest},
    UnusedFields, ignored, no_effect, refused,
};

const DENSITY: (&str, Times) = ("rho:r20! rhoref:r20", Once);
const REFERENCE: UnusedFields =
    no_effect("rhoref", "the density at the start is that without strain");
const FILTER: UnusedFields = ignored("fsmooth fcut", "the strain rate is not filtered");

/// Returns the number of lines of five values, for the functions of a yield table.
fn fives(record: &CardRecord) -> usize {
    let count = record.integer("nfunc").clamp(1, 1000);
    usize::try_from(count).unwrap_or(1).div_ceil(5)
}

/// Returns the number of lines of factors on limits of the strain.
fn sizes(record: &CardRecord) -> usize {
    usize::from(matches!(record.integer("sflag"), 2 | 3))
}

/// Returns 1 if strains to failure are given by ratios.
fn ratios(record: &CardRecord) -> usize {
    usize::from(record.integer("mflag") == 99)
}

/// Returns 1 if a card with the id of a failure may follow that of softening: a number in the first
/// columns of the latter is this id.
fn identity(record: &CardRecord) -> usize {
    record.line("icoup").map_or(0, |line| usize::from(line.is_blank("failid")))
}

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new("/MAT/LAW1", &[TITLE, DENSITY, ("e:r20! nu:r20", Once)], "law `elastic`")
        .aliases(&["/MAT/ELAST"])
        .unused(&[REFERENCE]),
    Keyword::new(
        "/MAT/LAW0",
        &[TITLE, ("rho:r20 rhoref:r20", Maybe), ("e:r20 nu:r20", Maybe)],
        "a `skin`: shells with mass and contact that carry no load",
    )
    .aliases(&["/MAT/VOID"])
    .unused(&[REFERENCE]),
    Keyword::new(
        "/MAT/LAW2",
        &[
            TITLE,
            DENSITY,
            ("e:r20! nu:r20 iflag:i", Once),
            ("a:r20! b:r20 n:r20=1 epsmax:r20=1e30 sigmax:r20=1e30", Once),
            ("c:r20 eps0:r20 icc:i fsmooth:i fcut:r20 chard:r20", Maybe),
            ("m:r20=1 tmelt:r20=1e30 rhocp:r20 tr:r20=300", Maybe),
        ],
        "law `johnson_cook`, or `j2` if n is 1 and there is neither rate nor temperature. With \
         iflag 1, a, b and n are the yield stress, the ultimate engineering stress and its \
         engineering strain, from which a + b eps^n with a maximum of the engineering stress there \
         follows. With sigmax, without rate and heat, it is `j2` with straight lines up to this \
         stress, else `largest_stress`, which the rate scales (icc 1). epsmax is the strain of \
         failure. Heat comes from rhocp, with all plastic work",
    )
    .aliases(&["/MAT/PLAS_JOHNS"])
    .unused(&[
        REFERENCE,
        ignored("chard", "hardening is isotropic, which differs when the load reverses"),
        FILTER,
    ]),
    Keyword::new(
        "/MAT/LAW19",
        &[
            TITLE,
            DENSITY,
            ("e11:r20! e22:r20! nu12:r20", Once),
            ("g12:r20! g23:r20 g31:r20", Once),
            ("re:r20 blank:a20 zerostress:r20 fscalepor:r20 sens:i", Maybe),
        ],
        "law `fabric` with the axes of `/PROP/TYPE9`; R_E 1 is with `compression`, up to 0.01 \
         without any",
    )
    .aliases(&["/MAT/FABRI"])
    .unused(&[
        REFERENCE,
        ignored("g23 g31", "the shear across the thickness is that of the formulation"),
        ignored("zerostress", "the stress is zero in the mesh as given"),
        no_effect("fscalepor", "it is for airbags with finite volumes"),
        refused("sens", "a reference state that a sensor ends"),
    ]),
    Keyword::new(
        "/MAT/LAW36",
        &[
            TITLE,
            DENSITY,
            ("e:r20! nu:r20 epsmax:r20=1e30 epst:r20=1e30 epsm:r20=1e30", Once),
            ("nfunc:i fsmooth:i chard:r20 fcut:r20 epsf:r20=1e30 blank:a10 vp:i", Once),
            ("fctp:i fscalep:r20=1 fcte:i einf:r20 ce:r20", Once),
            ("fcts:i*5", AtMost(fives)),
            ("fscales:r20=1*5", AtMost(fives)),
            ("rates:r20*5", AtMost(fives)),
        ],
        "law `j2` with a function as `hardening`, several as `hardening_by_rate`. epsmax is \
         `failure_strain`",
    )
    .aliases(&["/MAT/PLAS_TAB"])
    .unused(&[
        REFERENCE,
        ignored("chard", "hardening is isotropic, which differs when the load reverses"),
        FILTER,
        ignored("epst epsm epsf", "stress does not fall with the largest tensile strain"),
        ignored("vp", "functions have the rate of the total strain"),
        refused("fctp", "a yield stress that depends on pressure"),
        no_effect("fscalep", "it scales that function"),
        refused("fcte einf ce", "a modulus that depends on plastic strain"),
    ]),
    Keyword::new(
        "/MAT/LAW43",
        &[
            TITLE,
            DENSITY,
            ("e:r20! nu:r20", Once),
            ("fcte:i blank:a10 einf:r20 ce:r20", Once),
            ("r00:r20=1 r45:r20=1 r90:r20=1 chard:r20 iyield:i", Once),
            ("epsmax:r20=1e30 epst1:r20=1e30 epsm:r20=1e30", Once),
            ("func:i blank:a10 fscale:r20=1 rate:r20", Rest),
        ],
        "law `barlat` of shells with the exponent 2 (Hill), the ratios r00, r45 and r90, one \
         function as `hardening`, and the axes of `/PROP/TYPE9`. With iyield 0 the function is of \
         a mean over the directions, and is converted to tension along the first axis",
    )
    .aliases(&["/MAT/HILL_TAB"])
    .unused(&[
        REFERENCE,
        ignored("chard", "hardening is isotropic, which differs when the load reverses"),
        ignored("epsmax epst1 epsm", "elements of this law do not fail"),
        refused("fcte einf ce", "a modulus that depends on plastic strain"),
    ]),
    Keyword::new(
        "/MAT/LAW44",
        &[
            TITLE,
            DENSITY,
            ("e:r20! nu:r20 iflag:i", Once),
            ("a:r20 b:r20 n:r20=1 chard:r20 sigmax:r20=1e30", Once),
            ("c:r20 p:r20=1 icc:i fsmooth:i fcut:r20 blank:a10 vp:i", Maybe),
            ("epsmax:r20=1e30 epst1:r20=1e30 epst2:r20=1e30", Maybe),
            ("fcty:i blank:a10 fscaley:r20=1", Maybe),
        ],
        "law `j2` with c and p as `cowper_symonds`. With n other than 1 or with sigmax, \
         a + b eps^n becomes straight lines; with fcty the function, times fscaley, is the yield \
         stress instead, as `hardening`. epsmax is `failure_strain`",
    )
    .aliases(&["/MAT/COWPER"])
    .unused(&[
        REFERENCE,
        refused("iflag", "yield stress and ultimate strength; give a, b and n (iflag 0)"),
        ignored("chard", "hardening is isotropic, which differs when the load reverses"),
        FILTER,
        ignored("vp", "the factor has the rate of the total strain"),
        ignored("epst1 epst2", "stress does not fall with the largest tensile strain"),
    ]),
    Keyword::new(
        "/MAT/LAW42",
        &[
            TITLE,
            DENSITY,
            ("nu:r20=0.495 sigcut:r20=1e30 blank:a10 fctbulk:i fscalebulk:r20=1 m:i iform:i", Once),
            ("mu:r20*5", Once),
            ("moremu:r20*5", Once),
            ("alpha:r20*5", Once),
            ("morealpha:r20*5", Maybe),
        ],
        "law `ogden` of solids with the terms mu and alpha of the same sign. The energy of the \
         volume is `K (J - 1 - ln J)`, that of iform 2; that of iform 1 is the same for small \
         changes of the volume",
    )
    .aliases(&["/MAT/OGDEN"])
    .unused(&[
        REFERENCE,
        refused("sigcut", "a largest tensile stress"),
        refused("fctbulk", "a bulk modulus that depends on the volume"),
        no_effect("fscalebulk", "it scales that function"),
        refused("m", "relaxation of the stress"),
    ]),
    Keyword::new(
        "/MAT/LAW69",
        &[
            TITLE,
            DENSITY,
            ("law:i=1 fctbulk:i nu:r20=0.495 fscalebulk:r20=1 npair:i=2 icheck:i", Once),
            ("fct:i!", Once),
        ],
        "law `tabulated_rubber` of solids with the function of the nominal stress over the nominal \
         strain as `curve`, and the bulk modulus of nu and the slope of the curve at 0. The terms \
         of Ogden (law 1) or of Mooney and Rivlin (law 2) that Radioss fits to the function are \
         not needed: tension and compression follow the function itself, other states of stress \
         differ by the error of the fit",
    )
    .unused(&[
        REFERENCE,
        no_effect("law npair icheck", "nothing is fitted"),
        refused("fctbulk", "a bulk modulus that depends on the volume"),
        no_effect("fscalebulk", "it scales that function"),
    ]),
    Keyword::new(
        "/MAT/PLAS_PREDEF",
        &[TITLE, ("predef:a20!", Once)],
        "law `johnson_cook` with the values of OpenRadioss for STEEL, HSS, UHSS, AA5182, \
         AA6082-T6, PA6GF30 or PPT40, without rate and heat, in the units of `/BEGIN`",
    ),
    Keyword::new(
        "/FAIL/JOHNSON",
        &[
            ("d1:r20 d2:r20 d3:r20 d4:r20 d5:r20", Once),
            ("eps0:r20=1 ifailsh:i ifailso:i blank:a20 dadv:r20 ixfem:i", Maybe),
        ],
        "`damage` of the material with this id, whose law has to be `/MAT/LAW2`",
    )
    .unused(&[
        no_effect("ifailso", "a point fails, and an element with its last point"),
        ignored("dadv", "cracks do not advance on their own"),
        refused("ixfem", "cracks within elements"),
    ]),
    Keyword::new(
        "/FAIL/TENSSTRAIN",
        &[
            ("epst1:r20=1e30 epst2:r20=2e30 fct:i epsf1:r20 epsf2:r20 sflag:i=1", Once),
            ("fctel:i fscaleel:r20=1 elref:r20=1", AtMost(sizes)),
            ("fctt:i fscalet:r20=1", AtMost(sizes)),
            ("failid:i", Maybe),
        ],
        "`erosion_major_strain_start` and `erosion_major_strain` of the material with this id: the \
         stress falls from the largest principal strain epst1 to epst2. Without them epsf1 alone \
         is `erosion_major_strain`. A shell goes with its first failed point",
    )
    .unused(&[
        refused("fct", "limits of the strain that depend on its rate"),
        refused("fctel", "limits of the strain that depend on the size of elements"),
        no_effect("fscaleel elref", "they scale that function"),
        refused("fctt", "limits of the strain that depend on the temperature"),
        no_effect("fscalet", "it scales that function"),
        refused("epsf2", "a limit of the second principal strain"),
        no_effect("failid", "it is for output"),
    ]),
    Keyword::new(
        "/FAIL/BIQUAD",
        &[
            ("c1:r20 c2:r20 c3:r20 c4:r20 c5:r20", Once),
            ("pthick:r20 mflag:i sflag:i=2 inst:r20 blank:a10 fctel:i elref:r20", Maybe),
            ("r1:r20 r2:r20 r4:r20 r5:r20", AtMost(ratios)),
            // Up to the format 2022 this card is that of failid.
            ("failid:i icoup:i dcrit:r20 exp:r20=1", Maybe),
            ("failid:i", AtMost(identity)),
        ],
        "`gissmo_failure_strain` of the material with this id: points of the parabolas over the \
         triaxiality from -1 to 1. pthick is `gissmo_failed_points`, with 0 a shell goes with its \
         first failed point; fctel over the size elref is `gissmo_size_factors`; with dcrit the \
         stress fades from this damage on",
    )
    .unused(&[no_effect("inst", "it is for S-Flag 3"), no_effect("failid", "it is for output")]),
    not_yet("/MAT/PLAS_ZERIL", "the law of Zerilli and Armstrong; use /MAT/LAW2 or /MAT/LAW44"),
    not_yet("/MAT/LAW3", "hydrodynamic plasticity").aliases(&["/MAT/HYDPLA"]),
    not_yet("/MAT/LAW27", "brittle plasticity").aliases(&["/MAT/PLAS_BRIT"]),
    not_yet("/MAT/LAW70", "foam").aliases(&["/MAT/FOAM_TAB"]),
    not_yet("/MAT/LAW13", "rigid materials; use /RBODY").aliases(&["/MAT/RIGID"]),
];
