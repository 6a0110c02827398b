//! Settings of a run, and intervals of output.

use crate::input::deck::table::{Effect::*, Keyword, Times::*};

const ANY: &[(&str, crate::input::deck::table::Times)] = &[("card:l", Rest)];

const fn harmless(name: &'static str, note: &'static str) -> Keyword {
    Keyword::new(name, ANY, note).effect(Harmless)
}

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "CONTROL_TERMINATION",
        &[("endtim:r! endcyc:i dtmin:r endeng:r endmas:r nosol:i", Once)],
        "`end_time`; endcyc is `time.max_cycles`, dtmin is `time.dt_min_ratio`",
    ),
    Keyword::new(
        "CONTROL_TIMESTEP",
        &[
            ("dtinit:r tssfac:r isdo:i tslimt:r dt2ms:r lctm:i erode:i ms1st:i", Once),
            ("dt2msf:r dt2mslc:i imscl:i unused:r*2 rmscl:r", Maybe),
        ],
        "tssfac is `time.safety` (0.9 if blank). The absolute value of dt2ms is \
         `time.mass_scaling_dt`; added mass has no limit, and the run warns of its fraction. lctm \
         is not supported",
    ),
    Keyword::new(
        "CONTROL_SHELL",
        &[
            ("wrpang:r esort:i irnxx:i istupd:i theory:i bwc:i miter:i proj:i", Once),
            ("rotascl:r intgrd:i lamsht:i cstyp6:i thshel:i", Maybe),
            ("psstupd:i sidt4tu:i cntco:i itsflg:i irquad:i wmode:r stretch:r icrq:i", Maybe),
            ("nfail1:i nfail4:i psnfail:i keepcs:i delfr:i drcpsid:i drcprm:r intperr:i", Maybe),
        ],
        "theory is the elform of sections with elform 0; bwc 1 sets `warping`, istupd 1 and 4 set \
         `thinning`. cntco 1 and 2 set `contact.shell_offset` if shells have an nloc or OFFSET; 1 \
         is not supported together with a contact thickness that is not that of the shells. Other \
         fields are not used",
    ),
    Keyword::new(
        "CONTROL_HOURGLASS",
        &[("ihq:i qh:r", Maybe)],
        "as HOURGLASS, for parts without hgid",
    ),
    Keyword::new(
        "CONTROL_BULK_VISCOSITY",
        &[("q1:r q2:r type:i btype:i", Maybe)],
        "`bulk_viscosity` of solids: q2 linear, q1 quadratic",
    ),
    Keyword::new(
        "CONTROL_CONTACT",
        &[
            ("slsfac:r rwpnal:r islchk:i shlthk:i penopt:i thkchg:i orien:i enmass:i", Once),
            ("usrstr:i usrfrc:i nsbcs:i interm:i xpene:r ssthk:i ecdt:i tiedprj:i", Maybe),
            ("sfric:r dfric:r edc:r vfc:r th:r th_sf:r pen_sf:r ptscl:r", Maybe),
        ],
        "not used: the contact law needs no stiffness from the deck",
    ),
    Keyword::new("CONTROL_ENERGY", ANY, "not used: all energies are computed"),
    Keyword::new(
        "DAMPING_GLOBAL",
        &[("lcid:i valdmp:r stx:r sty:r stz:r srx:r sry:r srz:r", Once)],
        "`time.damping`",
    ),
    Keyword::new(
        "DATABASE_GLSTAT",
        &[("dt:r binary:i lcur:i ioopt:i", Maybe)],
        "`output.history_interval`",
    ),
    Keyword::new(
        "DATABASE_BINARY_D3PLOT",
        &[("dt:r lcdt:i beam:i npltc:i psetid:i", Maybe), ("ioopt:i rate:r", Maybe)],
        "`output.field_interval`; npltc is the number of intervals",
    ),
    harmless("CONTROL_ACCURACY", "not used: results do not depend on any order"),
    harmless("CONTROL_CPU", "not used"),
    harmless("CONTROL_SOLID", "not used"),
    harmless("CONTROL_SOLUTION", "not used"),
    harmless("CONTROL_PARALLEL", "not used: set `parallel.workers`, or give --workers"),
    harmless("CONTROL_MPP_DECOMPOSITION_METHOD", "not used"),
    harmless("CONTROL_MPP_IO_NODUMP", "not used"),
    harmless("CONTROL_UNITS", "not used"),
    harmless("CONTROL_STRUCTURED", "not used"),
    harmless("CONTROL_RIGID", "not used"),
    harmless("CONTROL_CHECK", "not used"),
];
