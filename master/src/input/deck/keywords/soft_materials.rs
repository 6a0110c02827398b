//! Materials of rubber, foam and honeycomb, and failure that is added to any material.

use super::title;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    UnusedFields, ignored, no_effect, refused,
};

const TITLE: (&str, Times) = ("heading:l", Count(title));
const REFERENCE: UnusedFields =
    ignored("ref", "the stress is zero in the mesh as given; there is no reference geometry");
const DAMPING: UnusedFields = ignored("damp", "the bulk viscosity of the elements damps");
const OF_CONTACT: UnusedFields = no_effect("kcon", "contact finds its stiffness itself");

const OF_HONEYCOMB: UnusedFields = ignored("mu bulk", "the bulk viscosity of the elements acts");
const OTHER_AXES: UnusedFields =
    no_effect("xp yp zp v1 v2 v3", "they are for axes by aopt 1, 3 and 4");

/// First cards of honeycombs.
const HONEYCOMB: [(&str, Times); 4] = [
    ("mid:i! ro:r! e:r! pr:r sigy:r! vf:r! mu:r=0.05 bulk:r", Once),
    ("lca:i! lcb:i lcc:i lcs:i lcab:i lcbc:i lcca:i lcsr:i", Once),
    ("eaau:r ebbu:r eccu:r gabu:r gbcu:r gcau:r aopt:r macf:i", Once),
    ("xp:r yp:r zp:r a1:r a2:r a3:r", Maybe),
];

/// Cards of rubbers with constants, or with a fit to a test.
const FIT: &str = "sgl:r sw:r st:r lcid:i";

/// Cards of soft tissue: those of 092 have relaxation.
const TISSUE: &[(&str, Times)] = &[
    TITLE,
    ("mid:i! ro:r! c1:r c2:r c3:r c4:r c5:r", Once),
    ("xk:r xlam:r fang:r xlam0:r failsf:r failsm:r failshr:r", Once),
    ("aopt:r ax:r ay:r az:r bx:r by:r bz:r", Maybe),
    ("la1:r la2:r la3:r macf:i=1", Maybe),
    ("s:r*6", Maybe),
    ("t:r*6", Maybe),
];
const TISSUE_UNUSED: &[UnusedFields] = &[
    no_effect("xlam fang xlam0", "there are no fibres"),
    refused("failsf failsm failshr", "failure; use MAT_ADD_EROSION"),
    no_effect("aopt ax ay az bx by bz la1 la2 la3 macf", "without fibres it is isotropic"),
    no_effect("t", "there is no relaxation"),
];

/// Cards of a criterion of MAT_ADD_DAMAGE_DIEM.
const ONSET: (&str, Times) = ("dityp:i p1:i p2:r p3:r p4:r p5:i", Maybe);
const EVOLUTION: (&str, Times) = ("detyp:i dctyp:i q1:r q2:r q3:r q4:i", Maybe);

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "MAT_ADD_EROSION",
        &[
            TITLE,
            ("mid:i! excl:r mxpres:r mneps:r effeps:r voleps:r numfip:r ncs:r", Once),
            ("mnpres:r sigp1:r sigvm:r mxeps:r epssh:r sigth:r impulse:r failtm:r", Maybe),
            ("idam:i dmgtyp:r lcsdg:i ecrit:r dmgexp:r dcrit:r fadexp:r lcregd:i", Maybe),
            ("sizflg:i refsz:r nahsv:i lcsrs:r shrf:r biaxf:r lcdlim:r midfail:r", AtMost(damage)),
            ("hisvn:r soft:r lp2bi:r", AtMost(damage)),
            ("lcfld:i nsff:i epsthin:r engcrt:r radcrt:r", Maybe),
        ],
        "keys `erosion_...` of the material: mxpres, mnpres, sigp1, sigvm, mxeps, voleps, \
         effeps (below 0 the plastic strain), numfip for shells (1 if it is blank: the first \
         failed point removes the shell); idam 1 with dmgtyp 1 is damage as in \
         MAT_ADD_DAMAGE_GISSMO; the other criteria are not supported",
    )
    .unused(&[
        refused("sizflg", "sizes that change with the element: use 0, its size at the start"),
        ignored("refsz nahsv", "it is for output"),
        no_effect("hisvn", "it is for tables"),
        no_effect("nsff", "it is for lcfld"),
    ])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_ADD_DAMAGE_GISSMO",
        &[
            TITLE,
            ("mid:i! unused:r dtyp:r refsz:r numfip:r", Once),
            ("lcsdg:i! ecrit:r dmgexp:r dcrit:r fadexp:r lcregd:i instf:r", Once),
            ("lcsrs:r shrf:r biaxf:r lcdlim:r midfail:r hisvn:r soft:r lp2bi:r", Maybe),
            ("rgtr1:r rgtr2:r", Maybe),
        ],
        "keys `gissmo_...` of the material, for dtyp 1: lcsdg and ecrit below 0 are curves over \
         the triaxiality, lcregd is one over the size; numfip is for shells",
    )
    .unused(&[
        no_effect("unused", "no field of the format"),
        ignored("refsz", "it is for output"),
        no_effect("hisvn rgtr1 rgtr2", "they are for tables and reduction factors"),
    ])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_ADD_DAMAGE_DIEM",
        &[
            TITLE,
            ("mid:i! ndiemc:r! dinit:i deps:r numfip:r volfrac:r", Once),
            ONSET,
            EVOLUTION,
            ONSET,
            EVOLUTION,
            ONSET,
            EVOLUTION,
            ONSET,
            EVOLUTION,
            ONSET,
            EVOLUTION,
        ],
        "keys `diem_...` of the material: dityp 0, 1 and 4 are `diem_ductile`, `diem_shear` and \
         `diem_principal`, p1 their curve, p2 the factor of the pressure; q1 is the displacement \
         (detyp 0) or the energy (detyp 1), dctyp 1 is multiplied; each dityp once",
    )
    .unused(&[
        refused("dinit", "damage by the strain at the start: use 0"),
        ignored("deps", "damage grows in every step"),
        no_effect("volfrac", "it is for elements of higher order"),
        no_effect("p3", "it is for dityp 2 and 3"),
        no_effect("p4", "plastic laws of shells have no transverse shear"),
        no_effect("q2", "failed elements are in the output"),
    ])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_FABRIC",
        &[
            TITLE,
            ("mid:i! ro:r! ea:r! eb:r ec:r prba:r prab:r prcb:r", Once),
            ("gab:r gbc:r gca:r cse:r el:r prl:r lratio:r damp:r", Once),
            ("aopt:r flc:r fac:r ela:r lnrc:r form:i fvopt:i tsrfac:r", Maybe),
            ("blank:r rgbrth:r a0ref:i a1:r a2:r a3:r x0:r x1:r", Maybe),
            ("v1:r v2:r v3:r d1:r d2:r d3:r beta:r isrefg:i", Maybe),
            ("lca:i lcb:i lcab:i lcua:i lcub:i lcuab:i rl:r", AtMost(curves)),
        ],
        "law `fabric`: isotropic with ea and prba, or with yarns (eb, gab) along aopt 0, 2 or 3 \
         and beta; cse 1 is without compression, damp the damping, and lratio, el, prl the liner",
    )
    .unused(&[
        no_effect("ec prcb gbc gca blank", "the format has no such constants any more"),
        refused("flc fac ela fvopt x0 x1", "porosity of the fabric: give cp23 and ap23 of the bag"),
        refused("lnrc tsrfac", "changes of liner and tension over time"),
        ignored("rgbrth a0ref isrefg", "the stress is zero in the mesh as given"),
        no_effect("d1 d2 d3", "the yarns a follow from the vectors a or v"),
        refused("lca lcb lcab lcua lcub lcuab rl", "curves of stress: give ea, eb, gab"),
    ])
    .aliases(&["MAT_034", "MAT_34"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_VISCOELASTIC",
        &[TITLE, ("mid:i! ro:r! bulk:r! g0:r! gi:r beta:r", Once)],
        "law `viscoelastic`",
    )
    .aliases(&["MAT_006", "MAT_6"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_KELVIN-MAXWELL_VISCOELASTIC",
        &[TITLE, ("mid:i! ro:r! bulk:r! g0:r! gi:r dc:r fo:r so:r", Once)],
        "law `viscoelastic`: dc is `decay_rate` with fo 0 (Maxwell), and the time 1/`decay_rate` \
         with fo 1 (Kelvin), whose equation `s' + s/dc = 2 g0 e' + 2 gi e/dc` of the deviators has \
         the same solution; from memory of the LS-DYNA Keyword User's Manual, vol. II, material 61",
    )
    .unused(&[no_effect("so", "it is for output; strains are in the fields")])
    .aliases(&["MAT_061", "MAT_61"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_GENERAL_VISCOELASTIC",
        &[
            TITLE,
            ("mid:i! ro:r! bulk:r pcf:r ef:r tref:r a:r b:r", Once),
            ("lcid:i nt:i bstart:r tramp:r lcidk:i ntk:i bstartk:r trampk:r", Maybe),
            ("gi:r betai:r ki:r betaki:r", Rest),
        ],
        "law `general_viscoelastic`: gi and betai are `shear_terms`, ki and betaki `bulk_terms`, \
         bulk without ki is `bulk_modulus`; fits to tests (lcid, lcidk) are not supported",
    )
    .unused(&[
        refused("pcf", "solids without tension; use 0"),
        ignored("tref a b", "there are no temperatures: times are those at tref"),
        no_effect("nt bstart tramp ntk bstartk trampk", "they are for lcid and lcidk"),
    ])
    .aliases(&["MAT_076", "MAT_76"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_BLATZ-KO_RUBBER",
        &[TITLE, ("mid:i! ro:r! g:r! ref:r", Once)],
        "law `blatz_ko`",
    )
    .unused(&[REFERENCE])
    .aliases(&["MAT_007", "MAT_7"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_MOONEY-RIVLIN_RUBBER",
        &[TITLE, ("mid:i! ro:r! pr:r! a:r b:r ref:r", Once), (FIT, Maybe)],
        "law `mooney_rivlin` with a and b; a fit to the curve lcid is not supported",
    )
    .unused(&[REFERENCE])
    .aliases(&["MAT_027", "MAT_27"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_SOFT_TISSUE",
        TISSUE,
        "law `polynomial_rubber` of solids with c1, c2 and the Poisson's ratio of the bulk modulus \
         xk, without fibres and relaxation. The energy of the volume is `xk/2 (J - 1)^2`, which \
         that of the format is for small changes of the volume",
    )
    .unused(TISSUE_UNUSED)
    .aliases(&["MAT_SOFT_TISSUE_VISCO", "MAT_091", "MAT_91", "MAT_092", "MAT_92"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_HYPERELASTIC_RUBBER",
        &[
            TITLE,
            ("mid:i! ro:r! pr:r! n:i nv:i g:r sigf:r ref:r", Once),
            ("c10:r c01:r c11:r c20:r c02:r c30:r", Maybe),
            ("gi:r betai:r", Rest),
        ],
        "law `polynomial_rubber` with the constants of n 0; a fit to a test (n above 0) and \
         relaxation (gi, betai) are not supported",
    )
    .unused(&[
        REFERENCE,
        ignored("sigf", "there is no friction damping"),
        no_effect("nv betai", "there is no relaxation"),
    ])
    .aliases(&["MAT_077_H", "MAT_77_H"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_OGDEN_RUBBER",
        &[
            TITLE,
            ("mid:i! ro:r! pr:r! n:i nv:i g:r sigf:r ref:r", Once),
            ("mu:r*8", Maybe),
            ("alpha:r*8", Maybe),
            ("gi:r betai:r", Rest),
        ],
        "law `ogden` with the terms of n 0; a fit to a test (n above 0) and relaxation (gi, betai) \
         are not supported",
    )
    .unused(&[
        REFERENCE,
        ignored("sigf", "there is no friction damping"),
        no_effect("nv betai", "there is no relaxation"),
    ])
    .aliases(&["MAT_077_O", "MAT_77_O"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_SIMPLIFIED_RUBBER/FOAM",
        &[
            TITLE,
            ("mid:i! ro:r! km:r mu:r g:r sigf:r ref:r prten:r", Once),
            ("sgl:r! sw:r! st:r! lctbid:i! tension:r=-1 rtype:r avgopt:r prbeta:r", Once),
            ("lcunld:i hu:r shape:r stol:r visco:r hisout:r", Maybe),
            ("gi:r betai:r", Rest),
        ],
        "law `tabulated_rubber`: `curve` is lctbid over sgl and over sw times st, km is \
         `bulk_modulus`; prbeta between 0 and 0.5 is `poisson` of a foam. A table of curves by the \
         strain rate is `curve_by_rate`: tension 0 leaves the rates to compression, -1 and 1 are \
         rates in loading; rtype 1 is `nominal_rate`; avgopt below 0 `rate_averaging_time`. \
         Unloading (lcunld, hu below 1), friction (g) and relaxation (visco) are not supported",
    )
    .unused(&[
        REFERENCE,
        ignored("mu", "the bulk viscosity of the elements damps"),
        no_effect("sigf", "it is for g"),
        no_effect("prten", "it is for shells"),
        no_effect("shape", "it is for hu below 1"),
        no_effect("stol", "the law checks its curve at the start"),
        no_effect("hisout", "it is for output"),
        no_effect("gi betai", "they are for visco"),
    ])
    .aliases(&["MAT_181", "MAT_SIMPLIFIED_RUBBER"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_LOW_DENSITY_FOAM",
        &[
            TITLE,
            ("mid:i! ro:r! e:r! lcid:i! tc:r hu:r beta:r damp:r", Once),
            ("shape:r fail:r bvflag:r ed:r beta1:r kcon:r ref:r", Maybe),
        ],
        "law `low_density_foam`: lcid is `compression`, tc `tension_cutoff`, hu `hysteresis`",
    )
    .unused(&[
        REFERENCE,
        DAMPING,
        OF_CONTACT,
        no_effect("bvflag", "the bulk viscosity of the elements acts"),
        ignored("ed beta1", "there is no relaxation of the foam"),
    ])
    .aliases(&["MAT_057", "MAT_57"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_CRUSHABLE_FOAM",
        &[TITLE, ("mid:i! ro:r! e:r! pr:r lcid:i! tsc:r damp:r model:r", Once)],
        "law `crushable_foam`: lcid is `compression`, tsc `tension_cutoff`",
    )
    .unused(&[DAMPING])
    .aliases(&["MAT_063", "MAT_63"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_VISCOUS_FOAM",
        &[TITLE, ("mid:i! ro:r! e1:r! n1:r v2:r e2:r n2:r pr:r", Once)],
        "law `viscous_foam`: e1, n1 are `youngs_modulus`, `stiffness_exponent`; v2, n2 \
         `viscous_coefficient`, `viscous_exponent`; e2 `viscous_modulus`",
    )
    .aliases(&["MAT_062", "MAT_62"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_FU_CHANG_FOAM",
        &[
            TITLE,
            ("mid:i! ro:r! e:r! kcon:r tc:r fail:r damp:r tbid:i!", Once),
            ("bvflag:r sflag:r rflag:r tflag:r pvid:i sraf:r ref:r hu:r", Maybe),
            ("d0:r n0:r n1:r n2:r n3:r c0:r c1:r c2:r", Maybe),
            ("c3:r c4:r c5:r aij:r sij:r minr:r maxr:r shape:r", Maybe),
            ("expon:r riuld:r", Maybe),
        ],
        "law `low_density_foam`: the curves of tbid are `compression_by_rate`, over the nominal \
         strain rate; tc is `tension_cutoff`, hu `hysteresis`",
    )
    .unused(&[
        REFERENCE,
        DAMPING,
        OF_CONTACT,
        no_effect("bvflag", "the bulk viscosity of the elements acts"),
        ignored("sflag rflag", "strains, stresses and rates of the curves are nominal"),
        no_effect("sraf", "the rate is a running mean"),
        no_effect("d0 n0 n1 n2 n3 c0 c1 c2 c3 c4 c5 aij sij", "tbid replaces them"),
        ignored("minr maxr", "the rates of the curves are the limits"),
        ignored("expon riuld", "unloading has the form of `hysteresis` and `shape`"),
    ])
    .aliases(&["MAT_083", "MAT_83"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_HONEYCOMB",
        &[
            TITLE,
            HONEYCOMB[0],
            HONEYCOMB[1],
            HONEYCOMB[2],
            HONEYCOMB[3],
            ("d1:r d2:r d3:r tsef:r ssef:r v1:r v2:r v3:r", Maybe),
        ],
        "law `honeycomb`: lca to lcca are `crush_a` to `crush_ca` (lcs `crush_shear`) over the \
         volume strain, or over the relative volume if a curve begins above 0; eaau to gcau are \
         `moduli`, blanks those of the solid; vf `compacted_volume`, sigy `yield_stress`, lcsr \
         `rate_factors`, tsef and ssef the strains of failure; axes by aopt 0, or 2 with the \
         vectors a and d",
    )
    .unused(&[OF_HONEYCOMB, OTHER_AXES])
    .aliases(&["MAT_026", "MAT_26"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_MODIFIED_HONEYCOMB",
        &[
            TITLE,
            HONEYCOMB[0],
            HONEYCOMB[1],
            HONEYCOMB[2],
            HONEYCOMB[3],
            ("d1:r d2:r d3:r tsef:r ssef:r vref:r tref:r shdflg:r", Maybe),
            ("v1:r v2:r v3:r", AtMost(more_axes)),
            ("lcsra:i lcsrb:i lcsrc:i lcsrab:i lcsrbc:i lcsca:i", AtMost(rates_by_component)),
        ],
        "law `honeycomb` as by MAT_HONEYCOMB, with `directional`: each curve is over the nominal \
         strain of its own direction, positive in compression, or over the size of its shear \
         strain",
    )
    .unused(&[
        OF_HONEYCOMB,
        OTHER_AXES,
        ignored("vref tref", "elements do not become springs"),
        ignored("shdflg", "shear has no damage: its stress follows its curve"),
        refused("lcsra lcsrb lcsrc lcsrab lcsrbc lcsca", "one curve (lcsr) is for all components"),
    ])
    .aliases(&["MAT_126"])
    .options(&["TITLE"]),
];

/// Returns 1 if failure that is added comes with damage.
fn damage(record: &CardRecord) -> usize {
    usize::from(record.integer("idam") != 0)
}

/// Returns 1 if a honeycomb has axes by a vector v.
fn more_axes(record: &CardRecord) -> usize {
    usize::from([3.0, 4.0].contains(&record.real("aopt")))
}

/// Returns 1 if a honeycomb has a curve of rates for each component.
fn rates_by_component(record: &CardRecord) -> usize {
    usize::from(record.integer("lcsr") == -1)
}

/// Returns 1 if a form of fabric has curves.
fn curves(record: &CardRecord) -> usize {
    usize::from(matches!(record.integer("form"), 4 | 14 | -14 | 24))
}
