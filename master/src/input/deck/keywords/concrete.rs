//! Concrete.

use super::title;
use crate::input::deck::record::CardRecord;
use crate::input::deck::table::{
    Keyword,
    Times::{self, *},
    UnusedFields, no_effect, refused,
};

const TITLE: (&str, Times) = ("heading:l", Count(title));
const FIRST: (&str, Times) =
    ("mid:i! ro:r! nplot:i incre:r irate:i erode:r recov:r itretrc:i", Once);
const OUTPUT: UnusedFields = no_effect("nplot", "it is for output; the damage is in the fields");
const PARTS: UnusedFields = no_effect("incre", "large increments are divided by their size");
const STARTS: UnusedFields = refused("pred", "damage at the start: use 0");

/// Returns 1 with effects of the rate, whose card follows.
fn rates(record: &CardRecord) -> usize {
    usize::from(record.integer("irate") != 0)
}

pub const KEYWORDS: &[Keyword] = &[
    Keyword::new(
        "MAT_CSCM",
        &[
            TITLE,
            FIRST,
            ("pred:r", Once),
            ("g:r! k:r! alpha:r! theta:r! lamda:r! beta:r! nh:r ch:r", Once),
            ("alpha1:r! theta1:r lamda1:r beta1:r alpha2:r! theta2:r lamda2:r beta2:r", Once),
            ("r:r! xd:r! w:r! d1:r! d2:r", Once),
            ("b:r! gfc:r! d:r! gft:r! gfs:r! pwrc:r=5 pwrt:r=1 pmod:r", Once),
            ("eta0c:r nc:r eta0t:r nt:r overc:r overt:r srate:r=1 repow:r=1", AtMost(rates)),
        ],
        "law `cscm`; erode of 1 or above is the strain of erosion plus 1, recov is from 0 to 1; \
         nh other than 1 and itretrc are not supported",
    )
    .unused(&[OUTPUT, PARTS, STARTS, no_effect("ch", "it is for nh")])
    .aliases(&["MAT_159"])
    .options(&["TITLE"]),
    Keyword::new(
        "MAT_CSCM_CONCRETE",
        &[TITLE, FIRST, ("pred:r", Once), ("fpc:r=0 dagg:r=0 units:i", Once)],
        "law `cscm` with the constants of FHWA-HRT-05-062 by the strength fpc (blank: 30 MPa) and \
         the size dagg of the aggregate (blank: 19 mm), both in the units that `units` names",
    )
    .unused(&[OUTPUT, PARTS, STARTS])
    .aliases(&["MAT_159_CONCRETE"])
    .options(&["TITLE"]),
];
