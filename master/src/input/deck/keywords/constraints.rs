//! Rigid bodies and constraints between nodes.

use super::id;
use super::parts::{inertia, local_inertia};
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    UnusedFields, ignored, no_effect, refused,
};

const WELD_ID: (&str, Times) = ("wid:i", Count(id));

const SPOT_UNUSED: &[UnusedFields] = &[
    no_effect("wid", "welds are numbered in the order of the deck"),
    no_effect("cid npr nprt", "forces of welds are not recorded"),
    ignored("filter window", "the forces of welds are not filtered"),
];

const LINEAR_UNUSED: &[UnusedFields] = &[no_effect("lcid", "equations have no numbers")];

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "CONSTRAINED_NODAL_RIGID_BODY",
        &[
            ("heading:l", Count(super::title)),
            ("pid:i! cid:i nsid:i pnode:i iprt:i drflag:i rrflag:i", Once),
            ("cmo:r con1:r con2:r", Count(spc)),
            ("xc:r yc:r zc:r tm:r! ircs:i nodeid:i", Count(inertia)),
            ("ixx:r! ixy:r ixz:r iyy:r! iyz:r izz:r!", Count(inertia)),
            ("vtx:r vty:r vtz:r vrx:r vry:r vrz:r", Count(inertia)),
            ("xl:r yl:r zl:r xlip:r ylip:r zlip:r cid2:i", Count(local_inertia)),
        ],
        "`[[rigid]]` body `body-PID` of the node set. Card of _SPC: `fixed`, as of MAT_RIGID; only \
         in global axes (cmo 1). Cards of _INERTIA: `inertia` of the body, tm as `[[mass]]` of its \
         nodes with the centre xc, yc, zc, if that is between them (their own masses are added), \
         and its `[[initial_velocity]]`. Constraints of all nodes, of pnode, or of a node of a \
         body that does not turn, fix the body",
    )
    .unused(&[
        no_effect("cid iprt", "they are for output"),
        no_effect("xl yl zl xlip ylip zlip cid2", "axes of the inertia are not supported"),
    ])
    .options(&["TITLE", "SPC", "INERTIA"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_EXTRA_NODES_NODE",
        &[("pid:i! nid:i!", Rest)],
        "adds a node to a rigid part",
    ),
    Keyword::new(
        "CONSTRAINED_EXTRA_NODES_SET",
        &[("pid:i! nsid:i!", Rest)],
        "adds a node set to a rigid part",
    ),
    Keyword::new(
        "CONSTRAINED_RIGID_BODIES",
        &[("pidl:i! pidc:i! iflag:i", Rest)],
        "joins two rigid parts to one body. With a PART_INERTIA of pidl and iflag 0, this is the \
         inertia of the whole body; iflag 1 is not supported for it",
    ),
    Keyword::new(
        "CONSTRAINED_GLOBAL",
        &[("tc:i! rc:i! dir:i! x:r y:r z:r tol:r", Rest)],
        "`[[symmetry]]` in a plane through x, y, z, with its normal along the axis dir (1 to 3); \
         tol is its tolerance. Only with the constraints of a plane of symmetry: tc fixes the \
         displacement along the normal, rc the rotations about the other two axes",
    ),
    Keyword::new(
        "CONSTRAINED_RIGID_BODY_STOPPERS",
        &[
            ("pid:i! lcmax:i lcmin:i psidmx:i psidmn:i lcvmnx:i dir:i=1 vid:i", Once),
            ("tb:r td:r=1e21 unused:r stiff:r", Maybe),
        ],
        "`stop` of the body along x, y, z (dir 1 to 3) or a DEFINE_VECTOR (dir 4): lcmax is its \
         curve `upper`, lcmin `lower`; a positive id is for the coordinate of the centre \
         (`position`), a negative one for its displacement. tb and td are `birth` and `death`. \
         A body that is beyond a bound when it begins to act is not moved back. Stops of \
         rotations (dir 5 to 8) are not supported",
    )
    .unused(&[
        refused(
            "psidmx psidmn",
            "bodies that stop when this one stops: give each a card of its own, or join them by \
             CONSTRAINED_RIGID_BODIES",
        ),
        refused("lcvmnx", "a limit of the velocity; a DAMPING or a spring can slow the body"),
        no_effect("unused", "no field of the format"),
        no_effect("stiff", "it is for implicit analysis"),
    ])
    .repeats(),
    Keyword::new(
        "DEFORMABLE_TO_RIGID",
        &[("pid:i! lrb:i ptype:a", Rest)],
        "the part (with ptype PSET, each part of the set) is rigid for the whole run; lrb joins it \
         to the body of that part",
    ),
    Keyword::new(
        "DEFORMABLE_TO_RIGID_AUTOMATIC",
        &[
            ("swset:i! code:i time1:r time2:r=1e20 time3:r entno:i relsw:i paired:i", Once),
            ("nrbf:i ncsf:i rwf:i dtmax:r d2r:i r2d:i offset:i", Maybe),
            ("rpid:i! lrb:i ptype:a", AtMost(to_rigid)),
            ("dpid:i! dptype:a", AtMost(to_deformable)),
        ],
        "at time1 the parts of the d2r lines become one rigid body each (`from`; parts with common \
         nodes or lrb one body), those of the r2d lines deform again (`until`). Only code 0: \
         conditions of forces are not supported",
    )
    .unused(&[
        no_effect("swset", "a switch is that of its card"),
        no_effect("time2 time3", "a switch by time acts at time1"),
        no_effect("entno", "it is for other codes"),
        ignored("dtmax", "the step is the stable one of the parts that deform"),
        ignored("offset", "contacts find their thickness themselves"),
        refused("relsw paired", "switches that activate each other: give their times"),
        refused("nrbf ncsf rwf", "bodies, contacts or walls that go with a switch"),
    ])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_SPOTWELD",
        &[WELD_ID, ("n1:i! n2:i! sn:r ss:r n:r m:r tf:r=1e20 ep:r=1e20", Once)],
        "`[[rigid]]` body of the two nodes; bodies with common nodes become one. With sn or ss: a \
         round beam that breaks, its diameter equal to its length, of the material of the first \
         node's part. sn is its `normal`, ss its `shear`, n and m are their exponents (2 if blank)",
    )
    .unused(SPOT_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_GENERALIZED_WELD_SPOT",
        &[
            WELD_ID,
            ("nsid:i! cid:i filter:i window:r npr:i nprt:i", Once),
            ("tfail:r=1e20 epsf:r=1e20 sn:r ss:r n:r m:r", Once),
        ],
        "the same for a node set; a weld that breaks has two nodes",
    )
    .unused(SPOT_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_NODE_SET",
        &[WELD_ID, ("nsid:i! dof:i! tf:r=1e20", Once)],
        "`[[tie]]` of the other nodes to the first node of the set; dof has to be 7 (all \
         displacements)",
    )
    .unused(SPOT_UNUSED)
    .options(&["ID"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_LINEAR_GLOBAL",
        &[("lcid:i", Once), ("nid:i! dof:i! coef:r", Rest)],
        "an equation of one term is `[[fix]]`. Equations of two nodes with coefficients 1 and -1 \
         in x, y and z are a `[[tie]]` of one to the other, with `rotations` if those are equal \
         too. All others are refused",
    )
    .unused(LINEAR_UNUSED),
    Keyword::new(
        "CONSTRAINED_LINEAR_LOCAL",
        &[("lcid:i", Once), ("nid:i! dof:i! cid:i coef:r", Rest)],
        "the same in the axes of a system",
    )
    .unused(LINEAR_UNUSED),
    Keyword::new(
        "CONSTRAINED_TIED_NODES_FAILURE",
        &[("nsid:i! eppf:r etype:i", Once)],
        "`[[tie]]` of the coincident nodes of the set to one of them; with etype 0, for shells, \
         with `rotations`. eppf has to be 0 or above 1e19 (no failure)",
    )
    .repeats(),
    Keyword::new(
        "CONSTRAINED_SHELL_TO_SOLID",
        &[("nid:i! nsid:i!", Once)],
        "`[[rigid]]` body of the node of the shell and of the nodes of the solids along its fibre, \
         which keeps its length; bodies with common nodes become one",
    )
    .repeats(),
    Keyword::new(
        "CONSTRAINED_BEAM_IN_SOLID",
        &[
            ("coupid:i heading:a70", Count(id)),
            ("bsid:i! ssid:i! bstyp:i sstyp:i unused:i unused:i ncoup:i cdir:i", Once),
            ("start:r end:r unused:i axfor:i unused:i pssf:r unused:i xint:r=1e16", Once),
        ],
        "`[[tie]]` with `inside`: the nodes of the beams follow the solids in which they are, also \
         with PENALTY",
    )
    .unused(&[
        no_effect("coupid", "couplings are numbered in the order of the deck"),
        ignored("ncoup xint", "the nodes of beams are tied, not points between them"),
        no_effect("pssf", "ties are exact: there is no penalty"),
        no_effect("unused", "no field of the format"),
    ])
    .options(&["PENALTY", "ID", "TITLE"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_LAGRANGE_IN_SOLID",
        &[
            ("coupid:i heading:a70", Count(id)),
            ("lstrsid:i! alesid:i! lstrsty:i alesty:i nquad:i ctype:i=2 direc:i=1 mcoup:i", Once),
            ("start:r end:r pfac:r fric:r frcmin:r norm:i normtyp:i dampfrac:r", Once),
            ("k:r hmin:r hmax:r ileak:i pleak:r lcidpor:i nvent:i iblock:i", Maybe),
            ("iboxid:i ipenchk:i intforc:i ialesof:i lagmul:r pfacmm:i thkf:r", Maybe),
            ("a1:r b1:r a2:r b2:r a3:r b3:r unused:i pore:i", Maybe),
        ],
        "the same with ctype 2 for nodes of beams, trusses or shells; other values of ctype are \
         coupling to fluids, which is not supported",
    )
    .unused(&[
        no_effect("coupid", "couplings are numbered in the order of the deck"),
        ignored("nquad", "nodes are tied, not points between them"),
        no_effect("direc mcoup", "all displacements are tied"),
        no_effect(
            "pfac fric frcmin norm normtyp dampfrac k hmin hmax ileak pleak lcidpor nvent iblock",
            "they are for penalty coupling",
        ),
        no_effect(
            "iboxid ipenchk intforc ialesof lagmul pfacmm thkf a1 b1 a2 b2 a3 b3 pore",
            "they are for penalty coupling and output",
        ),
        no_effect("unused", "no field of the format"),
    ])
    .options(&["ID", "TITLE"])
    .repeats(),
    Keyword::new(
        "CONSTRAINED_INTERPOLATION",
        &[
            ("icid:i! dnid:i! ddof:i=123456 cidd:i ityp:i idnsw:i fgm:i", Once),
            ("inid:i! idof:i=123456 twghtx:r=1 twghty:r twghtz:r rwghtx:r rwghty:r rwghtz:r", Rest),
        ],
        "`[[tie]]` of the node dnid to the mean motion (`mean_of`) of the nodes inid, or with ityp \
         1 of sets; twghtx are the `weights`. ddof is 123 or 123456, idof contains 123, and the \
         weights along x, y and z are equal",
    )
    .unused(&[
        no_effect("cidd", "all displacements follow, in any axes"),
        refused("idnsw", "a switch between two dependent nodes"),
        refused("fgm", "forces by mass"),
        ignored("rwghtx rwghty rwghtz", "the rotation follows from the displacements alone"),
    ]),
];

fn spc(record: &CardRecord) -> usize {
    usize::from(record.has("SPC"))
}

/// Returns the number of parts that become rigid.
fn to_rigid(record: &CardRecord) -> usize {
    usize::try_from(record.integer("d2r")).unwrap_or(0)
}

/// Returns the number of parts that deform again.
fn to_deformable(record: &CardRecord) -> usize {
    usize::try_from(record.integer("r2d")).unwrap_or(0)
}
