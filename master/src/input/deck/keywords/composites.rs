//! Composites: parts with layers, and materials of plies.

use super::title;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    UnusedFields, ignored, no_effect, refused,
};

const TITLE: (&str, Times) = ("heading:l", Count(title));
const AXES: UnusedFields =
    no_effect("xp yp zp d1 d2 d3", "in a shell the axis a follows from aopt 0, 2 or 3");
const OF_SOLIDS: UnusedFields =
    no_effect("ec prca prcb", "the stress through the thickness of a shell is zero");

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "PART_COMPOSITE",
        &[
            ("heading:l", Once),
            ("pid:i! elform:i shrf:r=1 nloc:r marea:r hgid:i adpopt:i thshel:i", Once),
            ("fs:r fd:r dc:r vc:r optt:r sft:r ssf:r cparm8:r", Count(contact)),
            ("mid1:i! thick1:r! b1:r tmid1:i plyid1:i shrfac1:r", AtMost(long)),
            ("mid1:i! thick1:r! b1:r tmid1:i mid2:i thick2:r b2:r tmid2:i", Rest),
        ],
        "`[[part]]` of shells with a `layer` for each mid, thick and b (angle), one point each, \
         from the bottom to the top; the other fields as in PART and SECTION_SHELL",
    )
    .unused(&[
        ignored("adpopt", "the mesh is not refined"),
        ignored("thshel tmid1 tmid2", "there is no heat conduction"),
        no_effect("ssf", "contact needs no stiffness"),
        ignored("cparm8", "beams of the part are in contact as others"),
        no_effect("plyid1", "it is a name"),
        ignored("shrfac1", "all layers have the shear factor 5/6"),
    ])
    .options(&["CONTACT", "LONG"]),
    Keyword::new(
        "MAT_ORTHOTROPIC_ELASTIC",
        &[
            TITLE,
            ("mid:i! ro:r! ea:r! eb:r! ec:r prba:r prca:r prcb:r", Once),
            ("gab:r! gbc:r gca:r aopt:r g:r sigf:r", Once),
            ("xp:r yp:r zp:r a1:r a2:r a3:r macf:i ihis:i", Once),
            ("v1:r v2:r v3:r d1:r d2:r d3:r beta:r ref:r", Once),
        ],
        "law `orthotropic`, for shells",
    )
    .unused(&[
        OF_SOLIDS,
        AXES,
        no_effect("g sigf", "they are for frequency independent damping"),
        no_effect("macf ihis", "they are for solids"),
        ignored("ref", "the stress is zero in the mesh as given; there is no reference geometry"),
    ])
    .aliases(&["MAT_002", "MAT_2"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_COMPOSITE_DAMAGE",
        &[
            TITLE,
            ("mid:i! ro:r! ea:r! eb:r! ec:r prba:r prca:r prcb:r", Once),
            ("gab:r! gbc:r gca:r kfail:r aopt:r macf:i=1 atrack:i", Once),
            ("xp:r yp:r zp:r a1:r a2:r a3:r", Once),
            ("v1:r v2:r v3:r d1:r d2:r d3:r beta:r", Once),
            ("sc:r xt:r yt:r yc:r alph:r sn:r syz:r szx:r", Once),
        ],
        "law `orthotropic` with `shear_energy` and residual strengths of 0, for shells: a cracked \
         or crushed matrix loses its stress across and its shear, a ply with broken fibres all its \
         stress. Strengths that are 0 are no limits",
    )
    .unused(&[
        OF_SOLIDS,
        AXES,
        no_effect("kfail macf sn syz szx", "they are for solids"),
        ignored("atrack", "the axis a turns with the element"),
    ])
    .aliases(&["MAT_022", "MAT_22"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_ENHANCED_COMPOSITE_DAMAGE",
        &[
            TITLE,
            ("mid:i! ro:r! ea:r! eb:r! ec:r prba:r prca:r prcb:r", Once),
            ("gab:r! gbc:r gca:r kf:r aopt:r 2way:r ti:r", Once),
            ("xp:r yp:r zp:r a1:r a2:r a3:r mangle:r", Once),
            ("v1:r v2:r v3:r d1:r d2:r d3:r dfailm:r dfails:r", Once),
            ("tfail:r alph:r soft:r=1 fbrt:r ycfac:r=2 dfailt:r dfailc:r efs:r", Once),
            ("xc:r xt:r yc:r yt:r sc:r crit:r=54 beta:r", Once),
            ("pfl:r=100 epsf:r epsr:r tsmd:r=0.9 soft2:r=1", Maybe),
            ("slimt1:r slimc1:r slimt2:r slimc2:r slims:r ncyred:r softg:r=1", Maybe),
            ("lcxc:i lcxt:i lcyc:i lcyt:i lcsc:i dt:r", Maybe),
        ],
        "law `orthotropic` with its strengths, for shells: crit 54 is Chang-Chang, 55 Tsai-Wu; \
         ycfac yc and fbrt xt are the strengths along the fibres after compressive failure of the \
         matrix; slimt1 to slims are `residual_strengths`, 1 if all are 0; dfail and efs are the \
         `failure_strain_...`, for crit 54. Strengths that are 0 are no limits. A failed ply keeps \
         its transverse shear stress until the element leaves",
    )
    .unused(&[
        OF_SOLIDS,
        AXES,
        no_effect("kf", "it is not used"),
        ignored("tfail", "elements are not removed because of their time step"),
        no_effect("pfl tsmd", "they are for soft and epsf"),
        ignored("ncyred", "the stress falls to its residual value at once"),
        no_effect("dt", "it is for curves over the strain rate"),
        refused("2way ti", "a second direction of fibres, and transversely isotropic solids"),
        refused("epsf epsr", "failure by transverse shear"),
        refused("lcxc lcxt lcyc lcyt lcsc", "strengths over the strain rate"),
    ])
    .aliases(&["MAT_054", "MAT_54", "MAT_055", "MAT_55", "MAT_054-055"])
    .options(&["TITLE"]),
];

/// Returns the number of lines with one layer each: all of them with the option `LONG`.
fn long(record: &CardRecord) -> usize {
    if record.has("LONG") { usize::MAX } else { 0 }
}

fn contact(record: &CardRecord) -> usize {
    usize::from(record.has("CONTACT"))
}
