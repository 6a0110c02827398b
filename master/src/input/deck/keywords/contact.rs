//! Contact and rigid walls.

use super::id;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    UnusedFields, ignored, no_effect, refused,
};

/// The cards of a contact; those of ties that fail have one more in their middle.
macro_rules! cards {
    ($($failure:expr)?) => {
        &[
            ("cid:i heading:a70", Count(id)),
            (MPP_CARD, Count(mpp)),
            ("surfa:i surfb:i surfatyp:i surfbtyp:i saboxid:i sbboxid:i sapr:i sbpr:i", Once),
            ("fs:r fd:r dc:r vc:r vdc:r penchk:i bt:r dt:r=1e20", Maybe),
            ("sfsa:r=1 sfsb:r=1 sast:r sbst:r sfsat:r=1 sfsbt:r=1 fsf:r=1 vsf:r=1", Maybe),
            ("isym:i erosop:i iadj:i", Count(eroding)),
            $(($failure, Once),)?
            (SOFT_CARD, Maybe),
            ("penmax:r thkopt:i shlthk:i snlog:i isym_b:i i2d3d:i sldthk:r sldstf:r", Maybe),
            ("igap:i=1 ignore:i dprfac:r dtstif:r edgek:r unused:r flangl:r cid_rcf:i", Maybe),
            ("q2tri:i dtpchk:r sfnbr:r fnlscl:r dnlscl:r tcso:i tiedid:i shledg:i", Maybe),
            ("sharec:i cparm8:r ipback:i srnde:i fricsf:r=1 icor:i ftorq:i region:i", Maybe),
            ("pstiff:i ignroff:i unused:r fstol:r 2dbinr:r ssftyp:i swtpr:i tetfac:r", Maybe),
        ]
    };
}

const MPP_CARD: &str = "ignore_mpp:i bckt:r lcbckt:r ns2trk:r inititr:r parmax:r unused:r cparm8:r";
const SOFT_CARD: &str =
    "soft:i sofscl:r=0.1 lcidab:i maxpar:r=1.025 sbopt:r=2 depth:i=2 bsort:i frcfrq:i=1";

type ContactCards = &'static [(&'static str, Times)];

const CARDS: ContactCards = cards!();
const BY_FORCE: ContactCards = cards!("nflf:r! sflf:r! nen:r=2 mes:r=2");
const BY_STRESS: ContactCards = cards!("nfls:r! sfls:r! tblcid:i thkoff:i");
const BY_OPTION: ContactCards =
    cards!("option:i! nfls:r sfls:r param:r eraten:r erates:r ct2cn:r cn:r");

/// The fates of the fields of a contact, after those of its own card.
macro_rules! unused {
    ($($own:expr),*) => {
        &[
            $($own,)*
            no_effect(
                "ignore_mpp bckt lcbckt ns2trk inititr parmax unused cparm8",
                "they direct the search of another program",
            ),
            no_effect("sapr sbpr cid_rcf", "force transducers select what is recorded"),
            no_effect(
                "vdc sfsa sfsb soft sofscl maxpar sbopt depth bsort frcfrq penmax snlog \
                 sldstf dtstif dprfac sfnbr fnlscl dnlscl pstiff fstol tetfac tcso",
                "contact needs no stiffness, damping or search from the deck",
            ),
            no_effect("penchk igap ignore erosop iadj q2tri dtpchk", "it has no counterpart here"),
            no_effect("shlthk thkopt", "contact always includes the thickness of shells"),
            ignored("isym isym_b", "faces on a plane of symmetry are in contact as all others"),
            ignored("lcidab", "no thickness depends on time"),
            ignored(
                "edgek flangl shledg srnde",
                "edges of shells are round and have one thickness",
            ),
            no_effect("i2d3d 2dbinr ssftyp ipback icor", "it has no counterpart here"),
            ignored("sharec ftorq ignroff swtpr", "friction acts at the surfaces of all segments"),
            refused("fricsf", "a factor on the friction: give fs and fd with this factor"),
            refused("region", "contact in a part of space"),
            refused("tiedid", "ties that do not start at the surface: use an OFFSET option"),
        ]
    };
}

const UNUSED: &[UnusedFields] = unused!();
const UNUSED_BY_STRESS: &[UnusedFields] = unused!(refused(
    "tblcid",
    "a stress over the gap by a curve: give option 6 of an AUTOMATIC tiebreak"
));
const UNUSED_BY_OPTION: &[UnusedFields] = unused!(no_effect(
    "eraten erates ct2cn cn",
    "the options of ties that use it are not supported"
));

const SINGLE: &str = "`[contact]`, from the second card on `[[contact.interface]]`: \
    contact of its parts with each other and with themselves. fs, fd and dc are the friction \
    (times fsf), vc its limit (times vsf), sast or sfsat the thickness, bt and dt birth and \
    death. If several cards contain the same two parts, the last one counts. The option MORTAR \
    of AUTOMATIC_SINGLE_SURFACE and AUTOMATIC_SURFACE_TO_SURFACE sets the `law` to `mortar`, in \
    other contacts it has no effect. Only AUTOMATIC_SINGLE_SURFACE and AUTOMATIC_GENERAL include \
    beams";
const PAIR: &str = "the same for the parts of surfa `against` those of surfb, after all contacts \
    of single surfaces; the thickness is the mean of both sides. Contacts NODES_TO_SURFACE, and \
    ONE_WAY without soft 2, are `one_way`: surfb holds the nodes of surfa";

const FORMING: &str = "as CONTACT_SURFACE_TO_SURFACE. The tools, surfb, have no thickness: the \
    `contact_thickness` of their shells is sbst, or 0.001 of their thickness. On which side of a \
    tool the sheet is follows from the start";

const WITH_MORTAR: &[&str] = &["ID", "TITLE", "MPP", "MORTAR"];

const TRANSDUCER: &str = "`[[output.transducer]]`: contact force on surfa from surfb, or from \
    everything if surfb is blank. A set of segments selects its nodes and the faces between them";

const fn contact(name: &'static str, note: &'static str) -> Keyword {
    Keyword::new(name, CARDS, note).options(WITH_MORTAR).unused(UNUSED)
}

const TIED: &str = "`[[tie]]` of the nodes of surfa to the faces of surfb. The nodes are moved \
    onto the faces; with an OFFSET option they keep their positions, at the end of arms (a \
    constraint for all three options). A negative sast or sbst is the tolerance; positive values \
    are the thicknesses for it (the larger of 0.6 of both and a twentieth of the shorter diagonal \
    of the face). A node is released when the element of its face fails";
const TURNED: &str = "the same with `rotations`";

const fn tied(name: &'static str, note: &'static str) -> Keyword {
    Keyword::new(name, CARDS, note).unused(UNUSED).options(&[
        "ID",
        "TITLE",
        "MPP",
        "MORTAR",
        "OFFSET",
        "BEAM_OFFSET",
        "CONSTRAINED_OFFSET",
    ])
}

const BREAKING: &str = "`[[tie]]` of the nodes of surfa that are on the faces of surfb at the \
    start, with a `failure` by the forces nflf, sflf and the exponents nen, mes. When it fails, \
    the nodes are in contact with the parts of surfb";
const BREAKING_ONLY: &str = "`[[tie]]` as by CONTACT_TIEBREAK_NODES_TO_SURFACE; when it fails, no \
    contact follows";
const BREAKING_STRESS: &str = "`[[tie]]` of the nodes of surfa that are on the faces of surfb at \
    the start, with a `failure` by the stresses nfls, sfls on the tied faces. When it fails, the \
    nodes are in contact with the parts of surfb. thkoff 1 keeps nodes at their positions";
const BREAKING_STRESS_ONLY: &str = "`[[tie]]` as by CONTACT_TIEBREAK_SURFACE_TO_SURFACE; when it \
    fails, no contact follows";
const BREAKING_OPTION: &str = "`[[tie]]` with `offset` of the nodes of surfa that are on the faces \
    of surfb at the start. option 1 ties without failure, 2 and 3 fail by the stresses nfls, sfls, \
    6 and 8 with damage over the opening param; negative ones tie rotations too. When it fails, \
    the nodes are in contact with the parts of surfb. Nodes that come into contact later do not \
    stick";

const fn breaking(name: &'static str, cards: ContactCards, note: &'static str) -> Keyword {
    Keyword::new(name, cards, note).options(&["ID", "TITLE", "MPP"]).unused(UNUSED)
}

const WALL_UNUSED: &[UnusedFields] = &[
    no_effect("rwksf", "walls need no stiffness"),
    refused("wvel", "nodes that stick to a wall above a speed"),
    no_effect("ssid n1 n2 n3 n4", "walls.csv has the force on the whole wall"),
    no_effect("pid ro e pr", "they are for pictures of the wall"),
];

const WALL: &[(&str, Times)] = &[
    WALL_ID,
    ("nsid:i nsidex:i boxid:i offset:r birth:r death:r=1e20 rwksf:r=1", Once),
    ("xt:r yt:r zt:r xh:r yh:r zh:r fric:r wvel:r", Once),
    ("xhev:r yhev:r zhev:r lenl:r lenm:r", Count(finite)),
    ("mass:r v0:r", Count(moving)),
    ("soft:i ssid:i n1:i n2:i n3:i n4:i", Count(forces)),
    DISPLAY,
];

const CYLINDER: &[(&str, Times)] =
    &[WALL_ID, SHAPE_NODES, SHAPE_PLACE, ("radcyl:r lencyl:r", Once), MOTION, DISPLAY];
const SPHERE: &[(&str, Times)] =
    &[WALL_ID, SHAPE_NODES, SHAPE_PLACE, ("radsph:r", Once), MOTION, DISPLAY];
const FLAT: &[(&str, Times)] = &[
    WALL_ID,
    SHAPE_NODES,
    SHAPE_PLACE,
    ("xhev:r yhev:r zhev:r lenl:r lenm:r", Once),
    MOTION,
    DISPLAY,
];
const PRISM: &[(&str, Times)] = &[
    WALL_ID,
    SHAPE_NODES,
    SHAPE_PLACE,
    ("xhev:r yhev:r zhev:r lenl:r lenm:r lenp:r", Once),
    MOTION,
    DISPLAY,
];
const WALL_ID: (&str, Times) = ("wid:i heading:a70", Count(id));
const SHAPE_NODES: (&str, Times) = ("nsid:i nsidex:i boxid:i birth:r death:r=1e20", Once);
const SHAPE_PLACE: (&str, Times) = ("xt:r yt:r zt:r xh:r yh:r zh:r fric:r", Once);
const MOTION: (&str, Times) = ("lcid:i! opt:i vx:r vy:r vz:r", Count(motion));
const DISPLAY: (&str, Times) = ("pid:i ro:r e:r pr:r", AtMost(display));

/// Creates a rigid wall of a given shape, with or without a prescribed motion.
const fn geometric(
    name: &'static str,
    cards: &'static [(&'static str, Times)],
    note: &'static str,
) -> Keyword {
    Keyword::new(name, cards, note)
        .options(&["ID", "MOTION", "DISPLAY"])
        .unused(WALL_UNUSED)
        .repeats()
}

pub const KEYWORDS: &[Keyword] = &[
    contact("CONTACT_AUTOMATIC_SINGLE_SURFACE", SINGLE),
    contact("CONTACT_AUTOMATIC_GENERAL", SINGLE),
    contact("CONTACT_SINGLE_SURFACE", SINGLE),
    contact("CONTACT_AUTOMATIC_SURFACE_TO_SURFACE", PAIR),
    contact("CONTACT_AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE", PAIR),
    contact("CONTACT_AUTOMATIC_NODES_TO_SURFACE", PAIR),
    contact("CONTACT_SURFACE_TO_SURFACE", PAIR),
    contact("CONTACT_ONE_WAY_SURFACE_TO_SURFACE", PAIR),
    contact("CONTACT_NODES_TO_SURFACE", PAIR),
    contact("CONTACT_ERODING_SINGLE_SURFACE", SINGLE),
    contact("CONTACT_ERODING_SURFACE_TO_SURFACE", PAIR),
    contact("CONTACT_ERODING_NODES_TO_SURFACE", PAIR),
    contact("CONTACT_FORMING_SURFACE_TO_SURFACE", FORMING),
    contact("CONTACT_FORMING_ONE_WAY_SURFACE_TO_SURFACE", FORMING),
    contact("CONTACT_FORMING_NODES_TO_SURFACE", FORMING),
    contact("CONTACT_FORCE_TRANSDUCER_PENALTY", TRANSDUCER).aliases(&["CONTACT_FORCE_TRANSDUCER"]),
    breaking("CONTACT_TIEBREAK_NODES_TO_SURFACE", BY_FORCE, BREAKING),
    breaking("CONTACT_TIEBREAK_NODES_ONLY", BY_FORCE, BREAKING_ONLY),
    breaking("CONTACT_TIEBREAK_SURFACE_TO_SURFACE", BY_STRESS, BREAKING_STRESS)
        .unused(UNUSED_BY_STRESS),
    breaking("CONTACT_TIEBREAK_SURFACE_TO_SURFACE_ONLY", BY_STRESS, BREAKING_STRESS_ONLY)
        .unused(UNUSED_BY_STRESS),
    breaking("CONTACT_AUTOMATIC_SURFACE_TO_SURFACE_TIEBREAK", BY_OPTION, BREAKING_OPTION)
        .unused(UNUSED_BY_OPTION),
    breaking("CONTACT_AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE_TIEBREAK", BY_OPTION, BREAKING_OPTION)
        .unused(UNUSED_BY_OPTION),
    tied("CONTACT_TIED_NODES_TO_SURFACE", TIED),
    tied("CONTACT_TIED_SURFACE_TO_SURFACE", TIED),
    tied("CONTACT_TIED_SHELL_EDGE_TO_SURFACE", TURNED),
    tied("CONTACT_SPOTWELD", TURNED),
    Keyword::new(
        "CONTACT_INTERIOR",
        &[("psid:i!", Rest)],
        "`interior_contact` of the parts of solids of psid: fraction da2 (0.1) and factor da1 (1) \
         of the set. It acts on the volume, not on the distance of faces; the modulus da3 is not \
         used, type 2 (da4) is type 1",
    ),
    Keyword::new(
        "RIGIDWALL_PLANAR",
        WALL,
        "`[[wall]]` through the tail, with its normal towards the head; fric is the friction. \
         nsid, boxid and offset select `nodes`, nsidex selects `except`. FINITE: a rectangle with \
         `edge` and `lengths`; MOVING: `mass` and `speed`. birth and death are those of the wall: \
         a plane with a birth ignores nodes that are behind it then. soft is not used",
    )
    .options(&["ID", "FINITE", "MOVING", "FORCES", "DISPLAY"])
    .unused(WALL_UNUSED)
    .repeats(),
    geometric(
        "RIGIDWALL_GEOMETRIC_CYLINDER",
        CYLINDER,
        "`[[wall]]` with `axis` from the tail to the head, `radius`, `length` and open ends. \
         MOTION prescribes its velocity (opt 0) or displacement (opt 1) along vx, vy, vz by a \
         curve. birth and death are those of the wall, which moves at all times",
    ),
    geometric(
        "RIGIDWALL_GEOMETRIC_SPHERE",
        SPHERE,
        "the same for a sphere with the tail as its centre and `radius`",
    ),
    geometric(
        "RIGIDWALL_GEOMETRIC_FLAT",
        FLAT,
        "the same for a rectangle, as RIGIDWALL_PLANAR_FINITE",
    ),
    geometric(
        "RIGIDWALL_GEOMETRIC_PRISM",
        PRISM,
        "six rectangles, the faces of a box: the first one as of RIGIDWALL_GEOMETRIC_FLAT, the \
         others lenp behind it. The forces are those of each face",
    ),
];

fn mpp(record: &CardRecord) -> usize {
    usize::from(record.has("MPP"))
}

fn eroding(record: &CardRecord) -> usize {
    usize::from(record.row.keyword.name.contains("ERODING"))
}

fn finite(record: &CardRecord) -> usize {
    usize::from(record.has("FINITE"))
}

fn moving(record: &CardRecord) -> usize {
    usize::from(record.has("MOVING"))
}

fn forces(record: &CardRecord) -> usize {
    usize::from(record.has("FORCES"))
}

fn motion(record: &CardRecord) -> usize {
    usize::from(record.has("MOTION"))
}

fn display(record: &CardRecord) -> usize {
    usize::from(record.has("DISPLAY"))
}
