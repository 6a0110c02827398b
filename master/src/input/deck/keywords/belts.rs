//! Seat belts: elements of one dimension, slip rings, retractors, pretensioners and sensors.

use super::title;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{Keyword, Times::*, UnusedFields, ignored, no_effect, refused};

const DSID: UnusedFields = refused("dsid", "a sensor that deactivates it");

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "ELEMENT_SEATBELT",
        &[("eid:i8! pid:i8! n1:i8! n2:i8! sbrid:i8 slen:r16 n3:i8 n4:i8", Rest)],
        "a row of `mesh.springs` of a part with `[part.belt]`; with slen (slack) an entry of \
         `belts.unstretched`: the distance of its nodes and slen. Elements without length are \
         wound up at a retractor. Shell elements (n3, n4) are **not supported**",
    )
    .unused(&[no_effect(
        "sbrid",
        "elements of zero length beyond a retractor are wound up, whatever they name",
    )]),
    Keyword::new(
        "SECTION_SEATBELT",
        &[("heading:l", Count(title)), ("secid:i! area:r thick:r", Once)],
        "makes the parts that refer to it `[part.belt]`",
    )
    .unused(&[ignored("area thick", "they are for contact, in which belts take no part")])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "MAT_SEATBELT",
        &[
            ("heading:l", Count(title)),
            ("mid:i! mpul:r llcid:i! ulcid:i lmin:r cse:r damp:r e:r", Once),
            ("a:r i:r j:r as:r f:r m:r r:r", Count(bending)),
        ],
        "`[part.belt]`: `force_strain` llcid and `unloading` ulcid (points of negative strain and \
         no force are left out), `mass_per_length` mpul, `min_length` lmin (without it a tenth of \
         the shortest element of the part). Belts have no damping",
    )
    .aliases(&["MAT_B01"])
    .unused(&[
        no_effect("cse damp", "they are for belts of shells"),
        refused("e", "stiffness in bending and compression"),
        no_effect("a i j as f m r", "`e` is refused"),
    ])
    .options(&["TITLE"])
    .repeats(),
    Keyword::new(
        "ELEMENT_SEATBELT_SLIPRING",
        &[
            ("sbsrid:i! sbid1:i! sbid2:i! fc:r sbrnid:i! ltime:r=1e20 fcs:r onid:i", Once),
            ("k:r funcid:i direct:i dc:r unused:i lcnffd:i lcnffs:i", Maybe),
        ],
        "`[[belts.ring]]` at sbrnid, which takes the place of the common node of sbid1 and sbid2: \
         `friction` fc, `static_friction` fcs, `decay` dc, `lock_time` ltime",
    )
    .unused(&[
        refused("onid k", "friction that depends on the skew of the belt"),
        refused("funcid lcnffd lcnffs", "friction by a function"),
        refused("direct", "a ring that lets belt through in one direction"),
        no_effect("unused", "it has no meaning"),
    ])
    .repeats(),
    Keyword::new(
        "ELEMENT_SEATBELT_RETRACTOR",
        &[
            ("sbrid:i! sbrnid:i! sbid:i! sid1:i sid2:i sid3:i sid4:i dsid:i", Once),
            ("tdel:r pull:r llcid:i! ulcid:i lfed:r lcfl:i flopt:i", Once),
        ],
        "`[[belts.retractor]]` at sbrnid, which takes the place of the node of sbid at the same \
         place: `sensors` sid1 to sid4, `delay` tdel, `pull_out` pull, `force_pull_out` llcid, \
         `unloading` ulcid, `fed_length` lfed. Belt moves as far as the tension asks for, not by a \
         hundredth of lfed per step at most",
    )
    .unused(&[DSID, refused("lcfl flopt", "a force limit by a curve")])
    .repeats(),
    Keyword::new(
        "ELEMENT_SEATBELT_PRETENSIONER",
        &[
            ("sbprid:i! sbprty:i=1 sbsid1:i! sbsid2:i sbsid3:i sbsid4:i", Once),
            ("sbrid:i! time:r ptlcid:i! lmtfrc:r", Once),
        ],
        "`[[belts.pretensioner]]` for sbprty 1 and 5: `retractor` sbrid, `sensors` sbsid1 to \
         sbsid4, `delay` time, `pull_in` ptlcid, with sbprty 5 `force_limit` lmtfrc. Other types \
         are **not supported**. At the end of the curve the retractor locks",
    )
    .repeats(),
    Keyword::new(
        "ELEMENT_SEATBELT_SENSOR",
        &[
            ("sbsid:i! sbstyp:i=1 sbsfl:i", Once),
            ("nid:i! dof:i=1 acc:r atime:r", Count(of_acceleration)),
            ("sbrid:i! pulrat:r pultim:r", Count(of_rate)),
            ("time:r", Count(of_time)),
            ("nid1:i! nid2:i! dmx:r dmn:r", Count(of_distance)),
            ("field:r*8", Count(of_another_kind)),
        ],
        "`[[belts.sensor]]`: sbstyp 1 `acceleration` of nid in the direction dof over atime, 2 \
         `pull_out_rate` of sbrid over pultim, 3 `time`, 4 the distance of nid1 and nid2. Other \
         types are **not supported**",
    )
    .unused(&[
        no_effect("sbsfl", "there is no dynamic relaxation"),
        no_effect("field", "the type is not supported"),
    ])
    .repeats(),
];

fn bending(record: &CardRecord) -> usize {
    usize::from(record.real("e") > 0.0)
}

fn of_type(record: &CardRecord, kind: i64) -> usize {
    usize::from(record.integer("sbstyp") == kind)
}

fn of_acceleration(record: &CardRecord) -> usize {
    of_type(record, 1)
}

fn of_rate(record: &CardRecord) -> usize {
    of_type(record, 2)
}

fn of_time(record: &CardRecord) -> usize {
    of_type(record, 3)
}

fn of_distance(record: &CardRecord) -> usize {
    of_type(record, 4)
}

fn of_another_kind(record: &CardRecord) -> usize {
    usize::from(!(1..=4).contains(&record.integer("sbstyp")))
}
