//! Parts, sections, hourglass control.

use super::title;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{Keyword, Times::*, ignored, no_effect, refused};

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "PART",
        &[
            ("heading:l", Once),
            ("pid:i! secid:i! mid:i! eosid:i hgid:i grav:i adpopt:i tmid:i", Once),
            ("xc:r yc:r zc:r tm:r! ircs:i nodeid:i", Count(inertia)),
            ("ixx:r! ixy:r ixz:r iyy:r! iyz:r izz:r!", Count(inertia)),
            ("vtx:r vty:r vtz:r vrx:r vry:r vrz:r", Count(inertia)),
            ("xl:r yl:r zl:r xlip:r ylip:r zlip:r cid:i", Count(local_inertia)),
            ("fs:r fd:r dc:r vc:r optt:r sft:r ssf:r cparm8:r", Count(contact)),
        ],
        "`[[part]]`; its name is the heading, or `part-PID` without one. Card of _CONTACT: fs, fd, \
         dc and vc are the friction in contacts with fs -1 (for two parts the mean); optt and sft \
         are `contact_thickness` and its scale. Cards of _INERTIA: `mass` and `inertia` of the \
         `[[rigid]]` body that the part leads, its `centre` if that is not the one of its elements \
         and its `[[initial_velocity]]`. adpopt 1 is for *CONTROL_ADAPTIVE",
    )
    .unused(&[
        no_effect("grav", "it is for loads by density and depth"),
        ignored("tmid", "there is no heat conduction"),
        no_effect("ssf", "contact needs no stiffness"),
        ignored("cparm8", "beams of the part are in contact as others"),
        no_effect("xl yl zl xlip ylip zlip cid", "they are for inertia about local axes"),
    ])
    .options(&["CONTACT", "INERTIA"])
    .repeats(),
    Keyword::new(
        "SECTION_SHELL",
        &[
            ("heading:l", Count(title)),
            ("secid:i! elform:i shrf:r=1 nip:i propt:r=1 qr:r icomp:i setyp:i=1", Once),
            ("t1:r t2:r t3:r t4:r nloc:r marea:r idof:r edgset:i", Once),
            ("angle:r*8", Count(angles)),
        ],
        "formulation, thickness (the mean of t1 to t4), points and `offset` (-nloc) of the parts \
         that refer to it; nip 0 is 2. With icomp 1 the angles of the points are `angles`, for \
         materials with axes. marea, mass per area, is added to the density of the material of \
         these parts. Rigid parts without a thickness have a hundredth of the side of their shells",
    )
    .unused(&[
        no_effect("propt", "results have all points"),
        refused("setyp", "two-dimensional solids"),
        ignored("idof", "the strain through the thickness is that of the formulation"),
        refused("edgset", "edges of membranes"),
    ])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "SECTION_TSHELL",
        &[
            ("heading:l", Count(title)),
            ("secid:i! elform:i=1 shrf:r=1 nip:i propt:r=1 qr:r icomp:i tshear:i", Once),
            ("angle:r*8", Count(angles)),
        ],
        "thick shells: `element = \"thick_shell\"` with so many points; nip 0 is 2. It has one \
         point in its plane; elform 2, 3 and 7 have four, and elform 3, 5 and 7 use laws in three \
         dimensions: it takes their place, with the law in plane stress, and the report says so",
    )
    .unused(&[
        no_effect("propt", "results have all points"),
        ignored("tshear", "transverse shear is constant over the thickness"),
    ])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "SECTION_SOLID",
        &[
            ("heading:l", Count(title)),
            ("secid:i! elform:i=1 aet:i unused:r*3 cohoff:r gaskeit:r", Once),
        ],
        "formulation of the parts that refer to it",
    )
    .unused(&[
        refused("aet", "ambient elements of fluids"),
        refused("cohoff gaskeit", "cohesive elements and gaskets"),
        no_effect("unused", "no field of the format"),
    ])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "SECTION_BEAM",
        &[
            ("heading:l", Count(title)),
            ("secid:i! elform:i=1 shrf:r=1 qr:r=2 cst:r scoor:r nsm:r", Once),
            ("ts1:r ts2:r tt1:r tt2:r nsloc:r ntloc:r", Count(integrated)),
            ("a:r! iss:r itt:r j:r sa:r ist:r", Count(resultant)),
            ("vol:r! iner:r! cid:i ca:r offset:r rrcon:r srcon:r trcon:r", Count(discrete)),
            ("field:r*8", Count(of_another_kind)),
        ],
        "`[part.beam]`. elform 1, 4, 5 and 9: with cst 0 a `rectangle` (ts1 by tt1; a tube for 5 \
         and 9), with cst 1 a `tube` (diameters ts1 and tt1), with qr below 0 the section of the \
         INTEGRATION_BEAM of this number; 1 and 9 have the shear area shrf \
         times the area. elform 2 and 13: `general`, elastic, with a, iss, itt, j and the shear \
         area sa. elform 3: `[part.truss]` with the area a. elform 6: `[part.discrete_beam]` with \
         the mass ro vol, the inertia iner and the axes of cid (without it the global ones); scoor \
         -1, -2 and -3 turn the axes with the first node, 1, 2 and 3 with the second, 0 with both; \
         with -2 and 2 r lies along the line between the nodes (`along_line`), for springs that \
         are alike on s and t; other elforms do not use scoor",
    )
    .unused(&[
        no_effect("ca offset", "they are for cables"),
        refused("rrcon srcon trcon", "axes whose rotation is constrained"),
        no_effect("field", "the elform is not supported"),
    ])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "INTEGRATION_BEAM",
        &[
            ("irid:i! nip:i ra:r icst:i k:i", Once),
            ("d1:r d2:r d3:r d4:r sref:r tref:r d5:r d6:r", Count(standard)),
            ("s:r t:r wf:r pid:i", Count(points)),
        ],
        "icst 1: section `i` of the parts of beams whose section refers to it, with the width d1 \
         and the thickness d2 of its flanges along the second axis, and the depth d3 and the \
         thickness d4 of its web along the third; other standard sections and points of an own \
         rule are not supported",
    )
    .unused(&[
        no_effect("ra", "it is for points of an own rule"),
        no_effect("k", "sections have fibres of their own number"),
        refused("sref tref", "a reference line that is not the centre"),
        no_effect("d5 d6", "the section has four dimensions"),
        no_effect("s t wf pid", "nip is not supported"),
    ])
    .repeats(),
    Keyword::new(
        "SECTION_DISCRETE",
        &[
            ("heading:l", Count(title)),
            ("secid:i! dro:i kd:r v0:r cl:r fd:r", Once),
            ("cdl:r tdl:r", Maybe),
        ],
        "makes the parts that refer to it `[part.spring]`, with dro 1 rotational ones; kd, cl, fd, \
         cdl and tdl have to be 0",
    )
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "HOURGLASS",
        &[
            ("heading:l", Count(title)),
            ("hgid:i! ihq:i qm:r=0.1 ibq:i=1 q1:r q2:r qb:r qw:r", Once),
        ],
        "`hourglass` of the parts that refer to it: ihq 0 to 3 viscous, 4 and 5 stiffness, 6, 7, 9 \
         and 10 assumed_strain (of solids; it has no coefficient); qm is the coefficient (0.1 if \
         0); q2 and q1 are `bulk_viscosity`. Other values of ihq are not supported. Parts without \
         hourglass control have ihq 1 and qm 0.1",
    )
    .unused(&[no_effect("ibq", "bulk viscosity has one form")])
    .options(&["TITLE"])
    .repeats(),
];

fn standard(record: &CardRecord) -> usize {
    usize::from(record.integer("icst") > 0)
}

fn points(record: &CardRecord) -> usize {
    usize::try_from(record.integer("nip")).unwrap_or(0)
}

fn integrated(record: &CardRecord) -> usize {
    usize::from(matches!(record.integer("elform"), 0 | 1 | 4 | 5 | 9 | 11))
}

fn resultant(record: &CardRecord) -> usize {
    usize::from(matches!(record.integer("elform"), 2 | 3 | 12 | 13))
}

fn discrete(record: &CardRecord) -> usize {
    usize::from(record.integer("elform") == 6)
}

fn of_another_kind(record: &CardRecord) -> usize {
    usize::from(integrated(record) + resultant(record) + discrete(record) == 0)
}

/// Returns 1 with the option `INERTIA`.
pub(super) fn inertia(record: &CardRecord) -> usize {
    usize::from(record.has("INERTIA"))
}

/// Returns 1 with the option `INERTIA` and axes of its own.
pub(super) fn local_inertia(record: &CardRecord) -> usize {
    usize::from(record.has("INERTIA") && record.integer("ircs") == 1)
}

fn contact(record: &CardRecord) -> usize {
    usize::from(record.has("CONTACT"))
}

/// Returns the number of lines with material angles: eight per line, one angle for each point.
fn angles(record: &CardRecord) -> usize {
    match record.integer("icomp") {
        1 => usize::try_from(record.integer("nip")).unwrap_or(0).min(100).div_ceil(8),
        _ => 0,
    }
}
