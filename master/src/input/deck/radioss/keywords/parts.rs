//! Parts, properties and their defaults.

use super::{TITLE, not_yet};
use crate::input::deck::table::{
    Keyword,
    Times::{Maybe, Once, Rest},
    ignored, no_effect, refused,
};

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "/PART",
        &[TITLE, ("prop:i! mat:i subset:i thick:r20", Once)],
        "`[[part]]` with the title as its name; thick is `contact_thickness` of shells",
    ),
    Keyword::new(
        "/SUBSET",
        &[TITLE, ("ids:i*10", Rest)],
        "its parts, for groups and surfaces by subset",
    ),
    Keyword::new(
        "/PROP/TYPE1",
        &[
            TITLE,
            ("ishell:i ismstr:i ish3n:i idril:i ipinch:i blank:a10 pthick:r20", Once),
            ("hm:r20 hf:r20 hr:r20 dm:r20 dn:r20", Once),
            ("n:i istrain:i thick:r20 ashear:r20 blank:a10 ithick:i iplas:i", Once),
        ],
        "shells. Ishell 24: `stabilised_quad`; 12: `fully_integrated_quad`; 1, 2 and 4: \
         `belytschko_tsay` with viscous, 3 with stiffness hourglass control. N: `points`, with 0 \
         (resultants) 3. Ithick 1: `thinning`. Triangles are `c0_triangle`",
    )
    .aliases(&["/PROP/SHELL"])
    .unused(&[
        no_effect("ismstr", "strains are finite"),
        no_effect("ish3n", "triangles have one formulation"),
        no_effect("istrain", "strains are no output here"),
        no_effect("iplas", "the return to the yield surface is iterated"),
        no_effect("hm hf hr", "hourglass control has a scale of its own"),
        ignored("dm dn", "shells have no numerical damping"),
        ignored("ipinch", "shells do not deform through their thickness"),
        ignored("pthick", "a shell is deleted when all its points have failed"),
        no_effect("ashear", "the shear factor is 5/6"),
    ]),
    Keyword::new(
        "/PROP/TYPE9",
        &[
            TITLE,
            ("ishell:i ismstr:i ish3n:i idril:i blank:a20 pthick:r20", Once),
            ("hm:r20 hf:r20 hr:r20 dm:r20 dn:r20", Once),
            ("n:i istrain:i thick:r20 ashear:r20 blank:a10 ithick:i iplas:i", Once),
            ("vx:r20 vy:r20 vz:r20 phi:r20", Maybe),
        ],
        "the same with the reference vector and the angle of the axes of a fabric (`direction` and \
         `angle` of the material), which have to be the same for all parts with this material",
    )
    .aliases(&["/PROP/SH_ORTH"])
    .unused(&[
        no_effect("ismstr", "strains are finite"),
        no_effect("ish3n", "triangles have one formulation"),
        no_effect("istrain", "strains are no output here"),
        no_effect("iplas", "the return to the yield surface is iterated"),
        no_effect("hm hf hr", "hourglass control has a scale of its own"),
        ignored("dm dn", "shells have no numerical damping"),
        ignored("pthick", "a shell is deleted when all its points have failed"),
        no_effect("ashear", "the shear factor is 5/6"),
    ]),
    Keyword::new(
        "/PROP/TYPE14",
        &[
            TITLE,
            (
                "isolid:i ismstr:i blank:a10 icpre:i itetra10:i inpts:i itetra4:i iframe:i dn:r20",
                Once,
            ),
            ("qa:r20=1.1 qb:r20=0.05 h:r20=0.1 lambda:r20 mu:r20", Maybe),
            ("dtmin:r20 more:a80", Maybe),
        ],
        "solids. Isolid 1 and 2: one point and viscous hourglass control with h; others: \
         `assumed_strain`. qa and qb are `bulk_viscosity`. Itetra4 3: volume strain of nodes",
    )
    .aliases(&["/PROP/SOLID"])
    .unused(&[
        no_effect("ismstr", "strains are finite"),
        no_effect("icpre", "the formulations do not lock at constant volume"),
        no_effect("itetra10", "tetrahedra of ten nodes have one formulation"),
        no_effect("inpts", "solids have one point, wedges two"),
        no_effect("iframe", "rates are corotational"),
        ignored("dn", "it is the damping of other formulations"),
        ignored("lambda mu", "solids have bulk viscosity only"),
        ignored("dtmin", "no solid is deleted by its step"),
        ignored("more", "no solid is deleted by its shape, and strains are no output here"),
    ]),
    Keyword::new(
        "/PROP/TYPE20",
        &[
            TITLE,
            ("isolid:i ismstr:i blank:a20 icstr:i inpts:i iint:i blank:a10 dn:r20", Once),
            ("qa:r20 qb:r20 h:r20", Maybe),
            ("dtmin:r20 more:a80", Maybe),
        ],
        "thick shells: `thick_shell` with one point in the plane and inpts of them through the \
         thickness, for Isolid 14 and 15. The thickness is from the first four nodes to the others",
    )
    .aliases(&["/PROP/TSHELL"])
    .unused(&[
        no_effect("ismstr", "strains are finite"),
        no_effect("iint", "it is for elements with 16 nodes"),
        ignored("dn", "it is the damping of other formulations"),
        ignored("qa qb", "thick shells have no bulk viscosity"),
        no_effect("h", "the hourglass control of thick shells has no coefficient"),
        ignored("dtmin", "no solid is deleted by its step"),
        ignored("more", "no solid is deleted by its shape, and strains are no output here"),
    ]),
    Keyword::new("/PROP/TYPE2", &[TITLE, ("area:r20! gap:r20", Once)], "trusses, `part.truss`")
        .aliases(&["/PROP/TRUSS"])
        .unused(&[refused("gap", "a truss has no gap")]),
    Keyword::new(
        "/PROP/TYPE3",
        &[
            TITLE,
            ("blank:a10 ismstr:i", Once),
            ("dm:r20 df:r20", Once),
            ("area:r20! iyy:r20! izz:r20! ixx:r20!", Once),
            ("wdof:a10 ishear:i", Maybe),
        ],
        "beams with a `general` section and shear areas of 5/6; Ishear 1: without shear",
    )
    .aliases(&["/PROP/BEAM"])
    .unused(&[
        no_effect("ismstr", "strains are finite"),
        ignored("dm df", "beams have no damping of their own"),
        refused("wdof", "releases at the ends of a beam"),
    ]),
    Keyword::new(
        "/PROP/TYPE4",
        &[
            TITLE,
            ("mass:r20 blank:a30 sens:i isflag:i ileng:i", Once),
            ("k1:r20 c1:r20 a1:r20 b1:r20 d1:r20", Once),
            ("fct1:i h1:i fct2:i fct3:i fct4:i blank:a10 dmin:r20 dmax:r20", Maybe),
            ("f1:r20 e1:r20 ascale1:r20 hscale1:r20", Maybe),
        ],
        "springs and dampers: K1 and C1, or the function fct1 scaled by A1 with H1 0; half of the \
         mass on each node",
    )
    .aliases(&["/PROP/SPRING"])
    .unused(&[
        refused("sens isflag", "springs that a sensor switches"),
        refused("ileng", "values per length"),
        refused("b1 d1 e1 fct2", "functions of the rate"),
        refused("fct3 fct4", "unloading and other functions"),
        refused("dmin dmax", "springs that break"),
        no_effect("f1 hscale1", "they scale functions that are not used"),
    ]),
    Keyword::new(
        "/DEF_SHELL",
        &[("ishell:i ismstr:i ithick:i iplas:i istrain:i blank:a20 ish3n:i idril:i", Once)],
        "defaults of the properties of shells",
    )
    .unused(&[
        no_effect("ismstr", "strains are finite"),
        no_effect("ish3n", "triangles have one formulation"),
        no_effect("istrain", "strains are no output here"),
        no_effect("iplas", "the return to the yield surface is iterated"),
    ]),
    Keyword::new(
        "/DEF_SOLID",
        &[("isolid:i ismstr:i blank:a10 istrain:i itetra4:i itetra10:i blank:a10 iframe:i", Once)],
        "defaults of the properties of solids",
    )
    .unused(&[
        no_effect("ismstr", "strains are finite"),
        no_effect("istrain", "strains are no output here"),
        no_effect("itetra10", "tetrahedra of ten nodes have one formulation"),
        no_effect("iframe", "rates are corotational"),
    ]),
    not_yet("/PROP/TYPE0", "void properties; use a property of shells with a void material")
        .aliases(&["/PROP/VOID"]),
    not_yet("/PROP/TYPE6", "orthotropic solids").aliases(&["/PROP/SOL_ORTH"]),
    not_yet("/PROP/TYPE8", "springs with six stiffnesses").aliases(&["/PROP/SPR_GENE"]),
    not_yet("/PROP/TYPE10", "composite shells").aliases(&["/PROP/SH_COMP"]),
    not_yet("/PROP/TYPE11", "sandwich shells").aliases(&["/PROP/SH_SANDW"]),
    not_yet("/PROP/TYPE13", "springs like beams; use /PROP/TYPE4").aliases(&["/PROP/SPR_BEAM"]),
    not_yet("/PROP/TYPE18", "integrated beams; use /PROP/TYPE3").aliases(&["/PROP/INT_BEAM"]),
];
