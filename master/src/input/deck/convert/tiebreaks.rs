//! Converts `*CONTACT_TIEBREAK_...` and `*CONTACT_AUTOMATIC_..._TIEBREAK`: ties that fail, and the
//! contact that is left of them.

use super::DeckConverter;
use super::names::names;
use super::ties::TieCard;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// How a keyword gives its limits.
#[derive(Clone, Copy, PartialEq)]
enum LimitsOfTie {
    /// As forces on nodes, with exponents.
    Forces,
    /// As stresses.
    Stresses,
    /// As stresses, with an option.
    Automatic,
}

/// Keywords with their limits; true if contact follows the failure.
const KEYWORDS: [(&str, LimitsOfTie, bool); 6] = [
    ("CONTACT_TIEBREAK_NODES_TO_SURFACE", LimitsOfTie::Forces, true),
    ("CONTACT_TIEBREAK_NODES_ONLY", LimitsOfTie::Forces, false),
    ("CONTACT_TIEBREAK_SURFACE_TO_SURFACE", LimitsOfTie::Stresses, true),
    ("CONTACT_TIEBREAK_SURFACE_TO_SURFACE_ONLY", LimitsOfTie::Stresses, false),
    ("CONTACT_AUTOMATIC_SURFACE_TO_SURFACE_TIEBREAK", LimitsOfTie::Automatic, true),
    ("CONTACT_AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE_TIEBREAK", LimitsOfTie::Automatic, true),
];

/// A tie of these contacts: its limits, and what else the option asks for.
#[derive(Default)]
struct TiebreakRequest {
    /// The table of the key `failure`, if it can fail.
    failure: Option<JobTable>,
    rotations: bool,
    offset: bool,
}

impl DeckConverter {
    /// Adds ties, and notes the contacts that follow them.
    pub(super) fn tiebreaks(&mut self) {
        let mut found: Vec<(CardRecord, LimitsOfTie, bool)> = Vec::new();
        for (keyword, limits, touches) in KEYWORDS {
            let records = self.take_records(keyword);
            found.extend(records.into_iter().map(|record| (record, limits, touches)));
        }
        let names = names(found.iter().map(|f| &f.0), "tiebreak-", ["heading", "cid"]);
        for ((number, name), (record, limits, touches)) in (1..).zip(names).zip(found) {
            let label = format!("tiebreak-{number}");
            let asked = match limits {
                LimitsOfTie::Forces => Some(forces(&record)),
                LimitsOfTie::Stresses => Some(TiebreakRequest {
                    failure: Some(self.stresses(&record)),
                    offset: record.integer("thkoff") != 0,
                    ..TiebreakRequest::default()
                }),
                LimitsOfTie::Automatic => self.automatic(&record, &label),
            };
            if let Some(TiebreakRequest { failure, rotations, offset }) = asked {
                let card = TieCard { record: &record, label: &label, name, rotations, offset };
                if let Some(mut table) = self.tie_table(card) {
                    if limits == LimitsOfTie::Automatic {
                        // Nodes that are not tied are in contact by this card.
                        table.put("may_be_empty", record.head, true);
                    }
                    let used = match failure {
                        Some(failure) => {
                            table.put("failure", record.head, failure);
                            "a tie of the nodes that are on the surface at the start; it fails"
                        }
                        None => "a tie of the nodes that are on the surface at the start",
                    };
                    self.map(label.as_str(), record.name(), used);
                    self.add_tie(record.block, table);
                }
            }
            if touches {
                self.broken_contacts.push(record);
            }
        }
    }

    /// Returns what an option asks for; none if it is not supported.
    fn automatic(&mut self, record: &CardRecord, label: &str) -> Option<TiebreakRequest> {
        let option = record.integer("option");
        let mut asked =
            TiebreakRequest { rotations: option < 0, offset: true, ..TiebreakRequest::default() };
        match option {
            1 | -1 => {}
            2 | 3 | -2 | -3 => asked.failure = Some(self.stresses(record)),
            4 => {
                let why = "sliding of nodes that are tied to the surface: the tie holds them along \
                           it too, and fails by tension";
                self.unsupported_value(record, "option", why);
                let mut limits = JobTable::new(record.head);
                limits.put("limits", record.head, "stress");
                self.limit(record, "nfls", ("normal", &mut limits));
                asked.failure = Some(limits);
            }
            6 | 8 => {
                let (opening, place) = (record.real("param"), record.place("param"));
                if opening <= 0.0 {
                    let message =
                        format!("{}: param is {opening} with option {option}", record.name());
                    let help = "give the distance over which the stress falls to zero; option 2 \
                                has no damage";
                    self.trouble.error(place, message, help);
                    return None;
                }
                let mut limits = self.stresses(record);
                limits.put("opening", place, opening);
                asked.failure = Some(limits);
            }
            _ => {
                let why = "give 1 to 3 (-1 to -3), 6 or 8; for laws with energies use 6 with param \
                           = 2 energy/nfls";
                self.unsupported_card(record, "option", why);
                return None;
            }
        }
        if matches!(option.saturating_abs(), 1 | 3) {
            let used = "only nodes on the surface at the start are tied";
            self.map(label, format!("option {option}: nodes also stick later"), used);
            let message = format!(
                "{}: option {option} also ties nodes that touch the surface later; here they stay \
                 in contact and can part",
                record.name()
            );
            let help = "if all nodes that stick are on the surface at the start, nothing is \
                        different; option 2 then says so";
            self.trouble.warning(record.place("option"), message, help);
        }
        Some(asked)
    }

    /// Returns limits as stresses.
    fn stresses(&mut self, record: &CardRecord) -> JobTable {
        let mut limits = JobTable::new(record.head);
        limits.put("limits", record.head, "stress");
        self.limit(record, "nfls", ("normal", &mut limits));
        self.limit(record, "sfls", ("shear", &mut limits));
        limits
    }

    /// Sets a limit of stress. A negative one is a curve.
    fn limit(&mut self, record: &CardRecord, field: &str, (key, limits): (&str, &mut JobTable)) {
        match record.real(field) {
            limit if limit < 0.0 => self.unsupported_value(record, field, "a curve; give a stress"),
            limit => limits.put(key, record.place(field), limit),
        }
    }
}

/// Returns limits as forces.
fn forces(record: &CardRecord) -> TiebreakRequest {
    let [nen, mes] = ["nen", "mes"].map(|field| record.real(field));
    let mut limits = JobTable::new(record.head);
    limits.put("normal", record.place("nflf"), record.real("nflf"));
    limits.put("shear", record.place("sflf"), record.real("sflf"));
    if [nen, mes] != [2.0; 2] {
        limits.put("exponents", record.place("nen"), [nen, mes]);
    }
    TiebreakRequest { failure: Some(limits), ..TiebreakRequest::default() }
}
