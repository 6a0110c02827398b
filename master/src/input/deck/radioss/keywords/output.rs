//! Histories.

use super::{TITLE, harmless};
use crate::input::deck::table::{Keyword, Times::Rest};

const ALWAYS: &str = "the histories of a run have it without a request: docs/guide/output.md";

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "/TH/NODE",
        &[TITLE, ("row:l", Rest)],
        "`[[output.node]]`: motion of nodes in `nodes.csv`, with all variables",
    ),
    Keyword::new(
        "/TH/PART",
        &[TITLE, ("row:l", Rest)],
        "energies of parts are always in `parts.csv`",
    ),
    harmless("/TH/RWALL", ALWAYS),
    harmless("/TH/INTER", ALWAYS),
    harmless("/TH/RBODY", ALWAYS),
    harmless("/TH/SHEL", "the fields of a run have the values of elements"),
    harmless("/TH/SH3N", "the fields of a run have the values of elements"),
    harmless("/TH/BRIC", "the fields of a run have the values of elements"),
    harmless("/TH/BEAM", "the fields of a run have the values of elements"),
    harmless("/TH/TRUS", "the fields of a run have the values of elements"),
    harmless("/TH/SPRI", "energies of springs are in `parts.csv`"),
    harmless("/TH/ACCEL", "give the node to `/TH/NODE`; accelerations are not filtered"),
    harmless("/TH/SECTIO", "give the section in a job: `[[output.section]]`"),
    harmless("/SECT", "give the section in a job: `[[output.section]]`"),
    harmless("/ACCEL", "accelerations are not filtered"),
];
