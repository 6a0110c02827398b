//! Settings of a run, and intervals of output.

use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Effect::*,
    Keyword,
    Times::{self, *},
    UnusedFields, ignored, no_effect, refused,
};

type CardTable = &'static [(&'static str, Times)];

const ANY: CardTable = &[("card:l", Rest)];

const fn harmless(name: &'static str, note: &'static str) -> Keyword {
    Keyword::new(name, ANY, note).effect(Harmless)
}

/// Cards of the damping of a part, or of a set of parts, by their field.
macro_rules! part_damping {
    ($of:literal) => {
        &[
            (concat!($of, ":i! lcid:i! sf:r=1 flag:i"), Once),
            ("stx:r sty:r stz:r srx:r sry:r srz:r", Count(directions)),
        ]
    };
}

const PART_DAMPING: CardTable = part_damping!("pid");
const PART_DAMPING_SET: CardTable = part_damping!("psid");
const PART_DAMPING_NOTE: &str = "`[[damping]]` of one of `parts` with sf as its coefficient and \
    the curve of lcid; with flag 1 stx, sty and stz have to be equal";

const STIFFNESS_DAMPING_NOTE: &str = "no damping of the highest frequencies: a positive coef, a \
    fraction of critical, is ignored with a warning; a negative one is not supported";
const STIFFNESS_DAMPING: &[UnusedFields] = &[ignored(
    "coef",
    "oscillations of the highest frequencies, those of single elements, are not damped by it: the \
     bulk viscosity of solids and viscous hourglass control act",
)];

fn directions(record: &CardRecord) -> usize {
    usize::from(record.integer("flag") == 1)
}

const SHELLS_UNUSED: &[UnusedFields] = &[
    no_effect("wrpang", "check reports elements of bad shape in any case"),
    no_effect("esort", "triangles always are c0_triangle"),
    no_effect("irnxx", "normals of shells are those of each step"),
    no_effect("miter", "plane stress is iterated until it converges"),
    ignored("proj", "each formulation has its own projection; bwc 1 adds warping terms"),
    ignored("rotascl", "the mass of rotations is that of the formulation"),
    ignored("intgrd", "the points through the thickness are those of Gauss"),
    no_effect("lamsht cstyp6", "there are no layered shells"),
    ignored("thshel", "there are no temperatures of nodes"),
    refused("psstupd", "thinning of some parts only: set istupd alone, or `thinning` of parts"),
    ignored("sidt4tu", "thinning has one form"),
    no_effect("itsflg irquad intperr keepcs", "it has no counterpart here"),
    refused("wmode stretch", "shells that are deleted by a distortion"),
    ignored("icrq", "thickness and plastic strain are those of elements"),
    ignored("nfail1 nfail4 psnfail", "distorted shells are not deleted: set `inverted` of parts"),
    ignored("delfr", "loose elements stay until they fail"),
    no_effect("drcprm", "the drilling stiffness is that of `drilling`"),
];

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "CONTROL_TERMINATION",
        &[("endtim:r! endcyc:i dtmin:r endeng:r endmas:r=1e8 nosol:i", Once)],
        "`end_time`; endcyc is `time.max_cycles`, dtmin is `time.dt_min_ratio`",
    )
    .unused(&[
        ignored("endeng", "no change of the energy ends the run: watch it in history.csv"),
        ignored("endmas", "no added mass ends the run: set `time.mass_scaling_limit`"),
        ignored("nosol", "the run is computed: use `crumple check` to only read the deck"),
    ]),
    Keyword::new(
        "CONTROL_IMPLICIT_GENERAL",
        &[("imflag:i dt0:r imform:i=2 nsbs:i=1 igs:i=2 cnstn:i form:i zero_v:i", Maybe)],
        "imflag has to be 0: the code is explicit. Other CONTROL_IMPLICIT keywords have no effect",
    )
    .unused(&[no_effect("dt0 imform nsbs igs cnstn form zero_v", "it is for implicit analysis")]),
    Keyword::new(
        "CONTROL_TIMESTEP",
        &[
            ("dtinit:r tssfac:r isdo:i tslimt:r dt2ms:r lctm:i erode:i ms1st:i", Maybe),
            ("dt2msf:r dt2mslc:i imscl:i unused:r*2 rmscl:r", Maybe),
        ],
        "tssfac is `time.safety` (0.9 if blank). erode 1 is `inverted = \"delete\"` of all parts \
         of solids: those whose step falls below dtmin are deleted, too. The absolute value of \
         dt2ms is `time.mass_scaling_dt`; added mass has no limit, and the run warns of its \
         fraction. The smallest value of the curve of lctm in the run is `time.dt_max`",
    )
    .unused(&[
        no_effect("dtinit", "the first step is the stable one times tssfac"),
        no_effect("isdo", "each element has its own bound of the stable step"),
        ignored("tslimt", "the stiffness of shells is not reduced to keep the step"),
        no_effect("ms1st", "mass is added at the start only in any case"),
        refused("dt2msf dt2mslc", "another measure of mass scaling: give dt2ms"),
        refused("imscl", "selective mass scaling"),
        ignored("rmscl", "the mass of rotations is scaled as that of displacements"),
        no_effect("unused", "no field of the format"),
    ]),
    Keyword::new(
        "CONTROL_SHELL",
        &[
            ("wrpang:r=20 esort:i irnxx:i=-1 istupd:i theory:i bwc:i miter:i=1 proj:i", Maybe),
            ("rotascl:r=1 intgrd:i lamsht:i cstyp6:i=1 thshel:i", Maybe),
            ("psstupd:i sidt4tu:i cntco:i itsflg:i irquad:i=3 wmode:r stretch:r icrq:i", Maybe),
            ("nfail1:i nfail4:i psnfail:i keepcs:i delfr:i drcpsid:i drcprm:r=1 intperr:i", Maybe),
        ],
        "theory is the elform of sections with elform 0; bwc 1 sets `warping`, istupd 1 and 4 set \
         `thinning`. cntco 1 and 2 set `contact.shell_offset` if shells have an nloc or OFFSET; 1 \
         is not supported together with a contact thickness that is not that of the shells. Quads \
         of elform 2 and its kin have no drilling stiffness, unless drcpsid gives it to all shells",
    )
    .unused(SHELLS_UNUSED),
    Keyword::new(
        "CONTROL_HOURGLASS",
        &[("ihq:i qh:r=0.1", Maybe)],
        "as HOURGLASS, for parts without hgid",
    ),
    Keyword::new(
        "CONTROL_BULK_VISCOSITY",
        &[("q1:r q2:r type:i=1 btype:i", Maybe)],
        "`bulk_viscosity` of solids: q2 linear, q1 quadratic",
    )
    .unused(&[ignored("type btype", "shells and beams have no bulk viscosity")]),
    Keyword::new(
        "CONTROL_CONTACT",
        &[
            (
                "slsfac:r=0.1 rwpnal:r islchk:i=1 shlthk:i penopt:i=1 thkchg:i orien:i=1 enmass:i",
                Maybe,
            ),
            ("usrstr:i usrfrc:i nsbcs:i interm:i xpene:r ssthk:i ecdt:i tiedprj:i", Maybe),
            ("sfric:r dfric:r edc:r vfc:r th:r th_sf:r pen_sf:r ptscl:r", Maybe),
            ("ignore:i frceng:i skiprwg:i outseg:i spotstp:i spotdel:i spothin:r dir_tie:i", Maybe),
            ("isym:i nserod:i rwgaps:i rwgdth:r rwksf:r=1 icov:i swradf:r ithoff:i", Maybe),
            ("shledg:i pstiff:i ithcnt:i tdcnof:i ftall:i unused:i shltrw:r igactc:i", Maybe),
        ],
        "not used: the contact law needs no stiffness from the deck",
    )
    .unused(&[
        no_effect(
            "slsfac rwpnal usrstr usrfrc nsbcs interm pen_sf ptscl",
            "contact and walls need no stiffness, and each step searches",
        ),
        no_effect("islchk penopt orien xpene ecdt tiedprj", "the search does not need it"),
        no_effect("ignore", "gaps that are there at the start are tolerated in any case"),
        no_effect("frceng skiprwg outseg ithcnt ftall unused igactc", "they are for output"),
        no_effect("pstiff rwksf icov", "contact and walls need no stiffness"),
        ignored("spotstp spotdel spothin swradf", "spot welds are tied as the deck gives them"),
        ignored("isym nserod shledg tdcnof dir_tie", "each contact has one treatment of it"),
        ignored("rwgaps rwgdth ithoff shltrw", "walls act on nodes, without a gap"),
        no_effect("shlthk", "contact always includes the thickness of shells"),
        ignored("thkchg", "contact keeps the first thickness of shells"),
        ignored("enmass", "nodes of failed elements leave contact"),
        ignored("ssthk", "contact limits the thickness by `contact.thickness_limit`"),
        ignored("sfric dfric edc vfc", "give the friction on each contact card"),
        ignored("th th_sf", "give the thickness on each contact card"),
    ]),
    Keyword::new("CONTROL_ENERGY", ANY, "not used: all energies are computed"),
    Keyword::new(
        "DAMPING_GLOBAL",
        &[("lcid:i valdmp:r stx:r sty:r stz:r srx:r sry:r srz:r", Maybe)],
        "`time.damping`, for all directions: stx, sty and stz have to be equal, or all blank. The \
         curve of lcid replaces valdmp; it is `time.damping_curve`, or part of `time.damping` if \
         it is constant in the whole run",
    ),
    Keyword::new("DAMPING_PART_MASS", PART_DAMPING, PART_DAMPING_NOTE).repeats(),
    Keyword::new("DAMPING_PART_MASS_SET", PART_DAMPING_SET, "the same for a set of parts")
        .repeats(),
    Keyword::new("DAMPING_PART_STIFFNESS", &[("pid:i! coef:r!", Once)], STIFFNESS_DAMPING_NOTE)
        .unused(STIFFNESS_DAMPING)
        .repeats(),
    Keyword::new(
        "DAMPING_PART_STIFFNESS_SET",
        &[("psid:i! coef:r!", Once)],
        "the same for a set of parts",
    )
    .unused(STIFFNESS_DAMPING)
    .repeats(),
    Keyword::new(
        "DATABASE_GLSTAT",
        &[("dt:r binary:i lcur:i ioopt:i=1", Maybe)],
        "`output.history_interval`",
    )
    .unused(&[
        no_effect("binary ioopt", "histories are text files"),
        ignored("lcur", "the interval of histories is constant"),
    ]),
    Keyword::new(
        "DATABASE_BINARY_D3PLOT",
        &[("dt:r lcdt:i beam:i npltc:i psetid:i", Maybe), ("ioopt:i rate:r", Maybe)],
        "`output.field_interval`; npltc is the number of intervals. With ioopt 3 the abscissas of \
         lcdt are `output.field_times`",
    )
    .unused(&[
        ignored("psetid", "fields have all parts"),
        no_effect("beam rate", "fields have all elements"),
    ]),
    Keyword::new(
        "DATABASE_EXTENT_BINARY",
        &[
            (
                "neiph:i neips:i maxint:i=3 strflg:i sigflg:i=1 epsflg:i=1 rltflg:i=1 engflg:i=1",
                Maybe,
            ),
            ("card:l", Rest),
        ],
        "strflg 1 is `output.strains`; other cards are not read",
    )
    .unused(&[
        no_effect("neiph neips", "d3plot files have no history variables of materials"),
        no_effect("maxint", "`output.points` writes all points through the thickness"),
        no_effect("sigflg epsflg rltflg engflg", "d3plot files have them in any case"),
        no_effect("card", "d3plot files have one form"),
    ]),
    Keyword::new(
        "CONTROL_UNITS",
        &[("length:a time:a mass:a temp:a", Maybe), ("card:l", Rest)],
        "`units`, also those of blanks: m, s, kg. Numbers are not converted",
    )
    .unused(&[no_effect("temp card", "values have the units of the deck")]),
    Keyword::new(
        "CONTROL_ADAPTIVE",
        &[
            ("adpfreq:r adptol:r=1e20 adptyp:i=1 maxlvl:i=3 tbirth:r tdeath:r=1e20 lcadp:i", Once),
            ("adpsize:r adpass:i ireflg:i adpene:r adpth:r memory:i orient:i maxel:i", Maybe),
            ("card:l", Rest),
        ],
        "`[adaptivity]` of the parts with adpopt 1: adptyp 1 and 2 are divided by their plastic \
         bending angle, adptol [degree]; maxlvl - 1 is `levels`. Other kinds, and decks where \
         adaptivity does not work, are warned of, and the mesh stays as it is",
    )
    .unused(&[
        ignored("lcadp", "the time between two checks is constant, adpfreq"),
        ignored("adpsize", "the number of levels bounds the size of shells"),
        ignored("adpass", "a step is not repeated with smaller shells: neighbours are divided too"),
        ignored("ireflg adpene", "shells are divided when they bend, not before"),
        ignored("adpth", "thinning does not divide shells"),
        no_effect("memory orient", "the program needs no such limit"),
        ignored("maxel", "there is no limit of the number of elements"),
        ignored("card", "shells are not joined again, and the whole mesh is not made again"),
    ]),
    harmless("CONTROL_ADAPSTEP", "not used: it is for CONTROL_ADAPTIVE"),
    Keyword::new(
        "CONTROL_DYNAMIC_RELAXATION",
        &[("nrcyck:i=250 drtol:r drfctr:r drterm:r tssfdr:r irelal:i edttl:r idrflg:i", Maybe)],
        "idrflg has to be 0 or negative: there is no phase of relaxation before the run",
    )
    .aliases(&["CONTROL_DAMPING"])
    .unused(&[no_effect(
        "nrcyck drtol drfctr drterm tssfdr irelal edttl",
        "they are for a relaxation before the run",
    )]),
    Keyword::new(
        "TERMINATION_NODE",
        ANY,
        "no motion and no contact ends a run: it goes on to its end time. Give an earlier one",
    )
    .aliases(&["TERMINATION_BODY", "TERMINATION_CONTACT", "TERMINATION_CURVE"])
    .effect(Harmless),
    Keyword::new(
        "DAMPING_FREQUENCY_RANGE",
        ANY,
        "the model has no damping of a range of frequencies: `time.damping` and `[[damping]]` damp \
         low ones, viscous hourglass control and bulk viscosity the highest",
    )
    .options(&["DEFORM"])
    .effect(Harmless),
    harmless(
        "DAMPING_RELATIVE",
        "the model has no damping relative to a rigid body: `[[damping]]` of parts is relative to \
         the space",
    ),
    harmless("CONTROL_REQUIRE_REVISION", "not used: it names a revision of another program"),
    harmless("CONTROL_ACCURACY", "not used: results do not depend on any order"),
    harmless("CONTROL_CPU", "not used"),
    harmless("CONTROL_SOLID", "not used"),
    harmless("CONTROL_SOLUTION", "not used"),
    harmless("CONTROL_PARALLEL", "not used: set `parallel.workers`, or give --workers"),
    harmless("CONTROL_STRUCTURED", "not used"),
    harmless("CONTROL_RIGID", "not used"),
    harmless("CONTROL_CHECK", "not used"),
];
