//! Particles of fluids: elements, sections, settings, equation of state.

use super::title;
use crate::input::deck::table::{Keyword, Times::*, ignored, no_effect, refused};

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "ELEMENT_SPH",
        &[("nid:i8! pid:i8! mass:r16! nend:i8", Rest)],
        "particles of `[part.particles]`; the cube of the spacing is the volume of a particle: the \
         mass over the ro of its MAT_NULL, or the number itself if the mass is below 0 or with \
         VOLUME. All particles of a part have the same. nend makes the nodes from nid to nend \
         particles. Their element ids follow the largest one of other elements, in the order of \
         the deck",
    )
    .options(&["VOLUME"]),
    Keyword::new(
        "SECTION_SPH",
        &[
            ("heading:l", Count(title)),
            (
                "secid:i! cslh:r=1.2 hmin:r=0.2 hmax:r=2 sphini:r death:r=1e20 start:r sphkern:i",
                Once,
            ),
        ],
        "`[part.particles]` of the parts that refer to it, with a MAT_NULL (pc is minus the \
         `tension`; 0 for none) and an EOS_MURNAGHAN, an EOS_GRUNEISEN (`hugoniot`), or an \
         EOS_LINEAR_POLYNOMIAL with c1 alone (`exponent` 1). A mu of MAT_NULL far below the \
         artificial viscosity is not used; a larger one is not supported. cslh is `smoothing`, in \
         spacings; with sphini the smoothing length is that. It is constant, as with hmin 1 and \
         hmax 1. q2 and q1 of the HOURGLASS of the part, or of CONTROL_BULK_VISCOSITY, are \
         `viscosity`. Other materials are not supported",
    )
    .unused(&[
        refused("death start", "particles that act for some time only"),
        refused("sphkern", "another kernel; use 0, the cubic spline"),
    ])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "EOS_MURNAGHAN",
        &[("heading:l", Count(title)), ("eosid:i! gamma:r! k0:r! v0:r", Once)],
        "pressure of particles: `exponent` is gamma, `sound_speed` the root of k0 gamma / ro with \
         the ro of MAT_NULL; the volume at the start is 1",
    )
    .aliases(&["EOS_019", "EOS_19"])
    .options(&["TITLE"]),
    Keyword::new(
        "CONTROL_SPH",
        &[
            ("ncbs:i=1 boxid:i dt:r=1e20 idim:i nmneigh:i=150 form:i start:r maxv:r=1e15", Maybe),
            ("cont:i deriv:i ini:i ishow:i ierod:i icont:i iavis:i isymp:i=100", Maybe),
            ("ithk:i istab:i ql:r=0.01 unused:i sphsort:i ishift:i", Maybe),
        ],
        "idim has to be 3 or blank. Particles have one form of the sums, that of \
         docs/theory/particles.md, which form 0 and 2 are converted to. A maxv from 1e12 on is no \
         limit; a smaller one is not supported. Other forms of fluids get a warning; tensor, \
         Lagrangian, adaptive and implicit forms are not supported",
    )
    .unused(&[
        no_effect("ncbs", "neighbours are those of each step"),
        ignored("boxid", "particles outside of the box go on"),
        refused("dt start", "particles that act for some time only"),
        no_effect("nmneigh isymp", "memory is found as needed"),
        refused("cont", "particles of different parts that do not push each other"),
        no_effect("deriv ini", "the smoothing length is that of the section, and constant"),
        no_effect("ishow ierod icont", "no particle is deleted"),
        ignored("iavis", "the artificial viscosity is that of Monaghan"),
        no_effect("ithk", "in contact particles have a radius, `contact_radius`"),
        ignored("istab", "there is no stabilisation of the particles"),
        no_effect("ql", "it belongs to istab"),
        no_effect("sphsort", "the order of the particles does not matter"),
        ignored("ishift", "particles are not shifted"),
        no_effect("unused", "no field of the format"),
    ]),
];
