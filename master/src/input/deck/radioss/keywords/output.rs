//! Histories.

use super::{ANY, TITLE, harmless};
use crate::input::deck::table::{Keyword, Times::Rest};

const ALWAYS: &str = "the histories of a run have it without a request: docs/guide/output.md";

const IN_FIELDS: &str = "the fields of a run have the values of elements";
const OTHER: &str = "docs/guide/output.md lists the histories of a run";
const FRAME: &str = "it is for output; a condition that refers to it is an error";

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
    harmless("/TH/SHEL", IN_FIELDS),
    harmless("/TH/SH3N", IN_FIELDS),
    harmless("/TH/BRIC", IN_FIELDS).aliases(&["/TH/BRICK", "/TH/QUAD", "/TH/SPHCEL"]),
    harmless("/TH/BEAM", IN_FIELDS),
    harmless("/TH/TRUS", IN_FIELDS).aliases(&["/TH/TRUSS"]),
    harmless("/TH/SPRI", "energies of springs are in `parts.csv`").aliases(&["/TH/SPRING"]),
    harmless("/TH/ACCEL", "give the node to `/TH/NODE`; accelerations are not filtered"),
    harmless("/TH/SECTIO", "give the section in a job: `[[output.section]]`")
        .aliases(&["/TH/SECTION"]),
    harmless("/TH", OTHER).options(ANY),
    harmless("/FRAME/MOV", FRAME).aliases(&["/FRAME/MOV2", "/FRAME/FIX", "/FRAME/NOD"]),
    harmless("/SKEW/MOV", FRAME).aliases(&["/SKEW/MOV2"]),
    harmless("/SECT", "give the section in a job: `[[output.section]]`"),
    harmless("/ACCEL", "accelerations are not filtered"),
];
