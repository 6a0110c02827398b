//! Sensors, their switches, and what they control.

use super::title;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    UnusedFields, no_effect,
};

const HEADING: (&str, Times) = ("heading:l", Count(title));

const MEASURED: &str = "what sensors measure switches nothing; the report of each \
    SENSOR_CONTROL says what it would have switched";

/// Creates a sensor, whose number alone is used.
const fn sensor(
    name: &'static str,
    cards: &'static [(&'static str, Times)],
    unused: &'static [UnusedFields],
) -> Keyword {
    Keyword::new(name, cards, "named in the reports of the SENSOR_CONTROL that depend on it")
        .unused(unused)
        .options(&["TITLE"])
        .repeats()
}

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "SENSOR_CONTROL",
        &[
            HEADING,
            ("cntlid:i! type:a! typeid:i timeoff:i nrep:i estyp:a", Once),
            ("initstt:a swit1:i swit2:i swit3:i swit4:i swit5:i swit6:i swit7:i", Once),
        ],
        "a rigid wall (RWALL) or a contact (CONTACT) with switches of time: `birth` and `death`, \
         one interval in which it is on. All else is **not supported**: the report names what it \
         would have switched, by which sensors, and what the run does without it",
    )
    .unused(&[
        no_effect("timeoff", "it is for curves of motions and pressures"),
        no_effect("estyp", "it is for sets of elements"),
    ])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "SENSOR_SWITCH",
        &[HEADING, ("switid:i! type:a sensid:i logic:a value:r filtrid:i timwin:r tdelay:r", Once)],
        "type TIME with logic GT: the time value + timwin + tdelay for SENSOR_CONTROL. Others are \
         named in its report",
    )
    .unused(&[no_effect("filtrid", MEASURED)])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "SENSOR_SWITCH_CALC-LOGIC",
        &[HEADING, ("switid:i! swit1:i swit2:i swit3:i swit4:i swit5:i swit6:i swit7:i", Once)],
        "named in the reports of the SENSOR_CONTROL that depend on it",
    )
    .options(&["TITLE"])
    .repeats(),
    sensor(
        "SENSOR_DEFINE_NODE",
        &[HEADING, ("sensid:i! node1:i node2:i vid:a unused:i ctype:a setopt:a", Once)],
        &[no_effect("node1 node2 vid unused ctype setopt", MEASURED)],
    ),
    sensor(
        "SENSOR_DEFINE_NODE_SET",
        &[HEADING, ("sensid:i! node1:i node2:i vid:a unused:i ctype:a setopt:a", Once)],
        &[no_effect("node1 node2 vid unused ctype setopt", MEASURED)],
    ),
    sensor(
        "SENSOR_DEFINE_ELEMENT",
        &[HEADING, ("sensid:i! etype:a elemid:i comp:a ctype:a layer:a sf:r pwr:r", Once)],
        &[no_effect("etype elemid comp ctype layer sf pwr", MEASURED)],
    ),
    sensor(
        "SENSOR_DEFINE_FORCE",
        &[HEADING, ("sensid:i! ftype:a typeid:i vid:a crd:i", Once)],
        &[no_effect("ftype typeid vid crd", MEASURED)],
    ),
    sensor(
        "SENSOR_DEFINE_MISC",
        &[HEADING, ("sensid:i! mtype:a i0:a i1:a i2:a i3:a i4:a i5:a", Once)],
        &[no_effect("mtype i0 i1 i2 i3 i4 i5", MEASURED)],
    ),
    sensor(
        "SENSOR_DEFINE_CALC-MATH",
        &[HEADING, ("sensid:i! calc:a sens1:i sens2:i sens3:i sens4:i sens5:i sens6:i", Once)],
        &[no_effect("calc sens1 sens2 sens3 sens4 sens5 sens6", MEASURED)],
    ),
];
