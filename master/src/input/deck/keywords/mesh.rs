//! Nodes and elements.

use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{Keyword, Times::*, ignored, no_effect, refused};

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "NODE",
        &[("nid:i8! x:r16 y:r16 z:r16 tc:i8 rc:i8", Rest)],
        "nodes; tc and rc become `[[fix]]`",
    ),
    Keyword::new(
        "ELEMENT_SHELL",
        &[
            ("eid:i8! pid:i8! n:i8*8", Rest),
            ("thic:r16*4 beta:r16", Count(thickness)),
            ("offset:r16", Count(offset)),
        ],
        "shells of three or four nodes. THICKNESS and BETA add a second line; with THICKNESS a \
         shell gets the mean of its corner thicknesses, and a zero means that of the section. beta \
         is its angle in `mesh.angles`, for materials with axes: it replaces that of the material. \
         OFFSET adds another line and overrides nloc: it becomes `offset` of the part if it is the \
         same for all its shells, over their thickness, else the offset of each shell",
    )
    .options(&["THICKNESS", "BETA", "OFFSET"]),
    Keyword::new(
        "ELEMENT_SOLID",
        &[("eid:i8! pid:i8! n:i8*8", Rest), ("n:i8*10", Maybe)],
        "solids of eight nodes, on one line or on two (ids, then nodes); with repeated nodes \
         tetrahedra and wedges, but no pyramids; with ten nodes quadratic tetrahedra",
    ),
    Keyword::new(
        "ELEMENT_TSHELL",
        &[("eid:i8! pid:i8! n:i8*8", Rest)],
        "thick shells of eight nodes: the first four are one face, the others the opposite face",
    ),
    Keyword::new(
        "ELEMENT_MASS",
        &[("eid:i8 nid:i8! mass:r16! pid:i8", Rest)],
        "`[[mass]]`, one for all nodes with the same mass",
    )
    .unused(&[no_effect("eid pid", "masses have no numbers")]),
    Keyword::new(
        "ELEMENT_INERTIA",
        &[("eid:i8 nid:i8! cid:i8", Once), ("ixx:r ixy:r ixz:r iyy:r iyz:r izz:r mass:r", Once)],
        "`added_inertia` of the rigid body of the node, and `[[mass]]` of the node. A node without \
         elements gets a spring without force to another node of the body",
    )
    .unused(&[no_effect("eid", "inertias have no numbers")])
    .repeats(),
    Keyword::new(
        "ELEMENT_MASS_NODE_SET",
        &[("eid:i8 nsid:i8! mass:r16!", Rest)],
        "`[[mass]]` of the set",
    )
    .unused(&[no_effect("eid", "masses have no numbers")]),
    Keyword::new(
        "ELEMENT_MASS_PART",
        &[("pid:i8! addmass:r16 finmass:r16 lcid:i8 mwd:i8", Rest)],
        "`[[mass]]` of the nodes of the part, the same on each of them",
    )
    .unused(&[
        refused("finmass", "the mass that the part has in the end: give addmass"),
        refused("lcid", "a mass that grows with the time"),
        ignored("mwd", "the mass is the same on all nodes of the part"),
    ]),
    Keyword::new(
        "ELEMENT_BEAM",
        &[
            ("eid:i8! pid:i8! n1:i8! n2:i8! n3:i8 rt1:i8 rr1:i8 rt2:i8 rr2:i8 local:i8", Once),
            ("pid1:i8 pid2:i8", Count(joined_parts)),
            ("vx:r vy:r vz:r", Count(orientation)),
        ],
        "beams. n3, or with ORIENTATION a vector, gives the direction of the second axis (s); it \
         is optional for round sections and trusses. Releases (rt, rr) are not supported",
    )
    .unused(&[
        no_effect("local", "it is for releases"),
        no_effect("pid1 pid2", "a tied contact finds the nearest face"),
    ])
    .options(&["ORIENTATION", "PID"])
    .repeats(),
    Keyword::new(
        "ELEMENT_DISCRETE",
        &[("eid:i8! pid:i8! n1:i8! n2:i8 vid:i8 s:r16=1 pf:i8 offset:r16", Rest)],
        "springs along the line between their nodes, or along vid. All springs of a part have the \
         same s and direction. With n2 0 the second node is a new fixed node at the position of \
         the first one, and vid is required. offset is not supported yet",
    )
    .unused(&[no_effect("pf", "the print flag of other programs")]),
];

/// Returns 1, for the line with the parts that a beam joins, with the option `PID`.
fn joined_parts(record: &CardRecord) -> usize {
    usize::from(record.has("PID"))
}

fn orientation(record: &CardRecord) -> usize {
    usize::from(record.has("ORIENTATION"))
}

fn offset(record: &CardRecord) -> usize {
    usize::from(record.has("OFFSET"))
}

fn thickness(record: &CardRecord) -> usize {
    usize::from(record.has("THICKNESS") || record.has("BETA"))
}
