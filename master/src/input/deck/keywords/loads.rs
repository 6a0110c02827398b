//! Constraints, motions and loads of the model.

use super::id;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Effect::Harmless,
    Keyword,
    Times::{self, *},
    UnusedFields, ignored, no_effect, refused,
};

const SPC_UNUSED: &[UnusedFields] = &[no_effect("id", "constraints have no numbers")];
const MOTION_UNUSED: &[UnusedFields] = &[
    no_effect("id", "motions have no numbers"),
    no_effect("vid lrb node1 node2", "they are for other values of dof and vad"),
];
const OF_RIGID: UnusedFields =
    ignored("irigid", "rigid bodies start with the mean motion of their nodes");
const NODAL_UNUSED: &[UnusedFields] =
    &[no_effect("m1 m2 m3", "they are for loads that follow nodes (dof 4 and 8)")];

/// Returns 1 for a charge that moves, whose card follows.
fn moves(record: &CardRecord) -> usize {
    usize::from(record.integer("blast") == 3)
}

/// Returns 1 for an air burst with reflection by the ground, whose card follows.
fn has_ground(record: &CardRecord) -> usize {
    usize::from(record.integer("blast") == 4)
}

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "BOUNDARY_SPC_SET",
        &[
            ("id:i heading:a70", Count(id)),
            ("nsid:i! cid:i dofx:i dofy:i dofz:i dofrx:i dofry:i dofrz:i", Once),
        ],
        "`[[fix]]`",
    )
    .unused(SPC_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "BOUNDARY_SPC_NODE",
        &[
            ("id:i heading:a70", Count(id)),
            ("nid:i! cid:i dofx:i dofy:i dofz:i dofrx:i dofry:i dofrz:i", Once),
        ],
        "`[[fix]]`, one for all nodes with the same degrees of freedom",
    )
    .unused(SPC_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "BOUNDARY_SPC_SET_BIRTH_DEATH",
        &[
            ("id:i heading:a70", Count(id)),
            ("nsid:i! cid:i dofx:i dofy:i dofz:i dofrx:i dofry:i dofrz:i", Once),
            ("birth:r death:r=1e20", Once),
        ],
        "`[[motion]]` at rest from birth to death; `[[fix]]` if that is the whole run",
    )
    .unused(SPC_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "BOUNDARY_SPC_NODE_BIRTH_DEATH",
        &[
            ("id:i heading:a70", Count(id)),
            ("nid:i! cid:i dofx:i dofy:i dofz:i dofrx:i dofry:i dofrz:i", Once),
            ("birth:r death:r=1e20", Once),
        ],
        "the same for a node",
    )
    .unused(SPC_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "BOUNDARY_PRESCRIBED_MOTION_SET",
        &[
            ("id:i heading:a70", Count(id)),
            ("nsid:i! dof:i! vad:i lcid:i! sf:r=1 vid:i death:r=1e28 birth:r", Once),
            ("offset1:r offset2:r lrb:i node1:i node2:i", Count(offsets)),
        ],
        "`[[motion]]` along x, y or z (dof 1 to 3) by velocity, acceleration or displacement, or \
         rotation by velocity, of the nodes (dof 5 to 7) or about a parallel axis through the \
         offsets (dof 9 to 11). dof 4 and 8 are along a vector that is parallel to an axis, -4 and \
         -8 along any, with all other motion fixed. birth and death are its times of begin and \
         end, and the curve starts at the birth; outside of them the degrees of freedom are free",
    )
    .unused(MOTION_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "BOUNDARY_PRESCRIBED_MOTION_NODE",
        &[
            ("id:i heading:a70", Count(id)),
            ("nid:i! dof:i! vad:i lcid:i! sf:r=1 vid:i death:r=1e28 birth:r", Once),
            ("offset1:r offset2:r lrb:i node1:i node2:i", Count(offsets)),
        ],
        "the same for one node",
    )
    .unused(MOTION_UNUSED)
    .options(&["ID"])
    .aliases(&["BOUNDARY_PRESCRIBED_MOTION_NODES"])
    .repeats(),
    Keyword::new(
        "BOUNDARY_PRESCRIBED_MOTION_RIGID",
        &[
            ("id:i heading:a70", Count(id)),
            ("pid:i! dof:i! vad:i lcid:i! sf:r=1 vid:i death:r=1e28 birth:r", Once),
            ("offset1:r offset2:r lrb:i node1:i node2:i", Count(offsets)),
        ],
        "the same for a rigid body",
    )
    .unused(MOTION_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "INITIAL_VELOCITY",
        &[
            ("nsid:i nsidex:i boxid:i irigid:i icid:i", Once),
            ("vx:r vy:r vz:r vxr:r vyr:r vzr:r", Once),
            ("vxe:r vye:r vze:r vxre:r vyre:r vzre:r", Count(exempted)),
        ],
        "`[[initial_velocity]]` of a set, of a box or of all nodes, and a second one for the \
         exempted set",
    )
    .unused(&[OF_RIGID]),
    Keyword::new(
        "INITIAL_VELOCITY_NODE",
        &[("nid:i! vx:r vy:r vz:r vxr:r vyr:r vzr:r icid:i", Rest)],
        "`[[initial_velocity]]`, one for all nodes with the same velocity",
    ),
    Keyword::new(
        "INITIAL_VELOCITY_GENERATION",
        &[
            ("id:i styp:i omega:r vx:r vy:r vz:r ivatn:i icid:i", Once),
            ("xc:r yc:r zc:r nx:r ny:r nz:r phase:i irigid:i", Maybe),
        ],
        "`[[initial_velocity]]` with spin omega about an axis through a point; without spin the \
         second card can be missing",
    )
    .unused(&[
        OF_RIGID,
        ignored("ivatn", "nodes that are constrained to others start with their own velocity"),
    ])
    .repeats(),
    Keyword::new(
        "INITIAL_VELOCITY_RIGID_BODY",
        &[("pid:i! vx:r vy:r vz:r vxr:r vyr:r vzr:r icid:i", Rest)],
        "`[[initial_velocity]]` of the body's nodes; spin about its centre",
    ),
    Keyword::new(
        "LOAD_BODY_X",
        GRAVITY,
        "`[[gravity]]` along -x, in the axes of cid at the start: the load accelerates the frame \
         of reference",
    )
    .unused(GRAVITY_UNUSED),
    Keyword::new("LOAD_BODY_Y", GRAVITY, "the same along -y").unused(GRAVITY_UNUSED),
    Keyword::new("LOAD_BODY_Z", GRAVITY, "the same along -z").unused(GRAVITY_UNUSED),
    Keyword::new("LOAD_BODY_VECTOR", GRAVITY_VECTOR, "the same along a vector, times its length")
        .unused(GRAVITY_UNUSED),
    Keyword::new(
        "LOAD_BODY_PARTS",
        &[("psid:i!", Once)],
        "`parts` of the gravity of all LOAD_BODY_X, _Y, _Z and _VECTOR",
    ),
    Keyword::new("LOAD_GRAVITY_PART", GRAVITY_PART, "`[[gravity]]` of one of `parts` along -dof")
        .unused(GRAVITY_PART_UNUSED),
    Keyword::new("LOAD_GRAVITY_PART_SET", GRAVITY_PART_SET, "the same for a set of parts")
        .unused(GRAVITY_PART_UNUSED),
    Keyword::new(
        "LOAD_BODY_GENERALIZED",
        &[("n1:i! n2:i lcid:i! drlcid:i xc:r yc:r zc:r", Once), ACCELERATION],
        "`[[gravity]]` along -ax, -ay and -az, in the axes of cid at the start, of all masses of \
         the nodes n1 to n2, or of the parts whose nodes they are",
    )
    .unused(ACCELERATION_UNUSED)
    .repeats(),
    Keyword::new(
        "LOAD_BODY_GENERALIZED_SET_NODE",
        &[("nsid:i! n2:i lcid:i! drlcid:i xc:r yc:r zc:r", Once), ACCELERATION],
        "the same for a set of nodes",
    )
    .unused(ACCELERATION_UNUSED)
    .repeats(),
    Keyword::new(
        "LOAD_BODY_GENERALIZED_SET_PART",
        &[("psid:i! n2:i lcid:i! drlcid:i xc:r yc:r zc:r", Once), ACCELERATION],
        "the same for a set of parts",
    )
    .unused(ACCELERATION_UNUSED)
    .repeats(),
    Keyword::new(
        "INITIAL_AXIAL_FORCE_BEAM",
        &[("bsid:i! lcid:i! scale:r=1 kbend:i", Rest)],
        "`beam.preload` of the parts of these beams: the axial stress over time, the curve times \
         scale. It ends with the curve, or when the stress is 0 again. kbend 1 and 2 are \
         `preload_bending`. A set has all beams of its parts; trusses and discrete beams (elform 3 \
         and 6) have no preload",
    ),
    Keyword::new(
        "INITIAL_STRESS_SHELL",
        &[
            ("eid:i! nplane:i=1 nthick:i=1 nhisv:i ntensr:i large:i nthint:i nthhsv:i", Rest),
            ("t:r sigxx:r sigyy:r sigzz:r sigxy:r sigyz:r sigzx:r eps:r", Rest),
            ("t:r16 sigxx:r16 sigyy:r16 sigzz:r16 sigxy:r16", Rest),
            ("sigyz:r16 sigzx:r16 eps:r16", Rest),
            ("hisv:r*8", Rest),
            ("hisv:r16*5", Rest),
        ],
        "`mesh.stresses` of shells, as in `dynain` files: stress in global axes and plastic \
         strain. Lines 2 and 5 repeat for each point, with large 1 lines 3, 4 and 6. Points \
         through the thickness may be others than those of the section: values are linear between \
         them. With SET eid is a set of shells",
    )
    .unused(SHELL_STRESS_UNUSED)
    .options(&["SET"]),
    Keyword::new(
        "INITIAL_STRESS_SOLID",
        &[
            ("eid:i! nint:i=1 nhisv:i large:i iveflg:i ialegp:i nthint:i nthhsv:i", Rest),
            ("sigxx:r sigyy:r sigzz:r sigxy:r sigyz:r sigzx:r eps:r", Rest),
            ("sigxx:r16 sigyy:r16 sigzz:r16 sigxy:r16 sigyz:r16", Rest),
            ("sigzx:r16 eps:r16 hisv:r16*3", Rest),
            ("hisv:r*8", Rest),
            ("hisv:r16*5", Rest),
        ],
        "the same of solids: the mean of the points",
    )
    .unused(SOLID_STRESS_UNUSED)
    .options(&["SET"]),
    Keyword::new(
        "INITIAL_STRAIN_SHELL",
        &[("text:l", Rest)],
        "strains at the start are for the output of other programs: stresses and plastic strains \
         are those of *INITIAL_STRESS_SHELL",
    )
    .options(&["SET"])
    .effect(Harmless),
    Keyword::new(
        "INITIAL_STRAIN_SOLID",
        &[("text:l", Rest)],
        "strains at the start are for the output of other programs: stresses and plastic strains \
         are those of *INITIAL_STRESS_SOLID",
    )
    .options(&["SET"])
    .effect(Harmless),
    Keyword::new(
        "LOAD_NODE_SET",
        &[("nsid:i! dof:i! lcid:i! sf:r=1 cid:i m1:i m2:i m3:i", Rest)],
        "`[[load]]` on each node of the set: dof 1 to 3 force, 5 to 7 moment",
    )
    .unused(NODAL_UNUSED),
    Keyword::new(
        "LOAD_NODE_POINT",
        &[("nid:i! dof:i! lcid:i! sf:r=1 cid:i m1:i m2:i m3:i", Rest)],
        "the same on one node",
    )
    .unused(NODAL_UNUSED),
    Keyword::new(
        "LOAD_RIGID_BODY",
        &[("pid:i! dof:i! lcid:i! sf:r=1 cid:i m1:i m2:i m3:i", Rest)],
        "`load` of the body of the part: dof 1 to 3 a force at its centre of mass, 5 to 7 a \
         moment about it, along the axes of cid at the start; 4 and 8 a force and a moment along \
         the normal m1m2 x m1m3 of three of its nodes, which turn with it (`follows`)",
    ),
    Keyword::new(
        "LOAD_SEGMENT",
        &[("lcid:i! sf:r=1 at:r n:i*4", Rest)],
        "`[[pressure]]`, positive against the segment's normal and into solids",
    ),
    Keyword::new(
        "LOAD_SEGMENT_SET",
        &[("ssid:i! lcid:i! sf:r=1 at:r", Rest)],
        "the same on a set of segments",
    ),
    Keyword::new(
        "LOAD_BLAST",
        &[
            ("wgt:r! xbo:r ybo:r zbo:r tbo:r iunit:i=2 isurf:i=2", Once),
            ("cfm:r cfl:r cft:r cfp:r death:r=1e20", Maybe),
        ],
        "`blast` of the pressures whose curve (lcid) is -2. isurf is `burst`; iunit and the \
         factors are `si`",
    ),
    Keyword::new(
        "LOAD_BLAST_ENHANCED",
        &[
            ("bid:i! m:r! xbo:r ybo:r zbo:r tbo:r unit:i=2 blast:i=2", Once),
            ("cfm:r cfl:r cft:r cfp:r nidbo:i death:r=1e20 negphs:i", Maybe),
            ("vel:r temp:r=70 ratio:r=1 vid:i", AtMost(moves)),
            ("gnid:i gvid:i", AtMost(has_ground)),
        ],
        "`blast` of the pressures of LOAD_BLAST_SEGMENT; blast 1 and 2 are `burst`, unit and the \
         factors are `si`, negphs is `suction`. Distance and angle of a face are those at the \
         start",
    )
    .unused(&[
        refused("nidbo", "a charge that moves with a node"),
        no_effect("vel temp ratio vid", "they are for blast 3, which is refused as a whole"),
        no_effect("gnid gvid", "they are for blast 4, which is refused as a whole"),
    ])
    .repeats(),
    Keyword::new(
        "LOAD_BLAST_SEGMENT",
        &[("bid:i! n:i*4 alepid:i sfnrb:r scalep:r=1", Rest)],
        "`[[pressure]]` of an explosion on a segment",
    )
    .unused(OF_FLUIDS),
    Keyword::new(
        "LOAD_BLAST_SEGMENT_SET",
        &[("bid:i! ssid:i! alepid:i sfnrb:r scalep:r=1", Rest)],
        "the same on a set of segments",
    )
    .unused(OF_FLUIDS),
    Keyword::new(
        "BOUNDARY_NON_REFLECTING",
        &[("ssid:i! ad:r as:r", Rest)],
        "`[[non_reflecting]]`: dampers at the nodes of these faces of solids; ad and as other than \
         0 switch off those of dilatational and shear waves",
    ),
    Keyword::new(
        "LOAD_SHELL_ELEMENT",
        &[("eid:i! lcid:i! sf:r=1 at:r", Rest)],
        "`[[pressure]]` on a shell, positive against its normal",
    ),
    Keyword::new(
        "LOAD_SHELL_SET",
        &[("esid:i! lcid:i! sf:r=1 at:r", Rest)],
        "the same on a set of shells",
    ),
];

const OF_HISTORY: UnusedFields =
    ignored("nhisv hisv", "history of the materials is 0 at the start, except for plastic strain");
const SHELL_STRESS_UNUSED: &[UnusedFields] = &[
    OF_HISTORY,
    refused("ntensr", "tensors of the history"),
    refused("nthint nthhsv", "thermal data"),
];
const SOLID_STRESS_UNUSED: &[UnusedFields] = &[
    OF_HISTORY,
    refused("iveflg", "volume and energy at the start"),
    refused("nthint nthhsv", "thermal data"),
    ignored("ialegp", "it is for fluids"),
];
const OF_FLUIDS: &[UnusedFields] = &[refused("alepid sfnrb", "segments of fluids")];

const GRAVITY: &[(&str, Times)] = &[("lcid:i! sf:r=1 lciddr:i xc:r yc:r zc:r cid:i", Once)];

const GRAVITY_VECTOR: &[(&str, Times)] = &[GRAVITY[0], ("v1:r v2:r v3:r", Once)];
const GRAVITY_PART: &[(&str, Times)] = &[("pid:i! dof:i! lc:i accel:r lcdr:i stga:i stgr:i", Rest)];
const GRAVITY_PART_SET: &[(&str, Times)] =
    &[("psid:i! dof:i! lc:i accel:r lcdr:i stga:i stgr:i", Rest)];
const GRAVITY_PART_UNUSED: &[UnusedFields] = &[
    no_effect("lcdr", "there is no dynamic relaxation"),
    refused("stga stgr", "stages of construction"),
];

const ACCELERATION: (&str, Times) = ("ax:r ay:r az:r omx:r omy:r omz:r cid:i angtyp:a", Maybe);
const ACCELERATION_UNUSED: &[UnusedFields] = &[
    no_effect("drlcid", "there is no dynamic relaxation"),
    no_effect("xc yc zc angtyp", "they are for rotations"),
    refused("omx omy omz", "a rotating frame of reference"),
];

const GRAVITY_UNUSED: &[UnusedFields] = &[
    no_effect("lciddr", "there is no dynamic relaxation"),
    refused("xc yc zc", "a centre of rotation"),
];

/// Returns 1 if prescribed motion has a second line: for a degree of freedom with an offset, or
/// for relative motion.
fn offsets(record: &CardRecord) -> usize {
    usize::from(
        matches!(record.integer("dof").unsigned_abs(), 9..=11) || record.integer("vad") == 4,
    )
}

fn exempted(record: &CardRecord) -> usize {
    usize::from(record.integer("nsidex") > 0)
}
