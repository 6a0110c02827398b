//! Converts `*CONTACT_TIED_...` and `*CONTACT_SPOTWELD`: nodes tied to surfaces.

use super::DeckConverter;
use super::names::names;
use super::sets::id;
use super::tree::JobTable;
use crate::input::deck::record::{CardLine, CardRecord};
use crumple_proto::ids::NodeId;
use std::collections::{BTreeMap, HashSet};

/// Keywords; true if they tie rotations too.
const KEYWORDS: [(&str, bool); 4] = [
    ("CONTACT_TIED_NODES_TO_SURFACE", false),
    ("CONTACT_TIED_SURFACE_TO_SURFACE", false),
    ("CONTACT_TIED_SHELL_EDGE_TO_SURFACE", true),
    ("CONTACT_SPOTWELD", true),
];
const OFFSETS: [&str; 3] = ["OFFSET", "BEAM_OFFSET", "CONSTRAINED_OFFSET"];
/// Share of the time of the run within which a tie that begins is tied from the start.
const SOON: f64 = 1e-3;

/// A card that ties nodes to a surface.
pub(super) struct TieCard<'a> {
    pub record: &'a CardRecord,
    /// Start of the names of its node sets.
    pub label: &'a str,
    /// Name of the tie.
    pub name: String,
    pub rotations: bool,
    pub offset: bool,
}

impl DeckConverter {
    pub(super) fn ties(&mut self) {
        let mut found: Vec<(CardRecord, bool)> = Vec::new();
        for (keyword, rotations) in KEYWORDS {
            found.extend(self.take_records(keyword).into_iter().map(|record| (record, rotations)));
        }
        let names = names(found.iter().map(|f| &f.0), "tie-", ["heading", "cid"]);
        for ((number, name), (record, rotations)) in (1..).zip(names).zip(&found) {
            self.tie(record, (number, name), *rotations);
        }
    }

    /// Notes a tie of the block with this number.
    pub(super) fn add_tie(&mut self, block: usize, table: JobTable) {
        self.ties.push((block, table));
    }

    /// Adds all ties to the job, in the order of the deck.
    pub(super) fn put_ties(&mut self) {
        let mut ties = std::mem::take(&mut self.ties);
        ties.sort_by_key(|(block, _)| *block);
        ties.into_iter().for_each(|(_, table)| self.add("tie", table));
    }

    /// Converts `*CONSTRAINED_BEAM_IN_SOLID` and `*CONSTRAINED_LAGRANGE_IN_SOLID`: nodes tied to
    /// the solids in which they are.
    pub(super) fn embedded(&mut self) {
        let keywords = ["CONSTRAINED_BEAM_IN_SOLID", "CONSTRAINED_LAGRANGE_IN_SOLID"];
        let records = self.take_in_order(&keywords);
        for (record, number) in records.iter().zip(1..) {
            if let Some(mut table) = self.embed(record, number) {
                // The nodes may be in the solids of another card.
                table.put("may_be_empty", record.head, records.len() > 1);
                self.add_tie(record.block, table);
            }
        }
    }

    fn embed(&mut self, record: &CardRecord, number: usize) -> Option<JobTable> {
        let of_beams = record.row.keyword.name == "CONSTRAINED_BEAM_IN_SOLID";
        let [inner, outer] = match of_beams {
            true => [("bsid", "bstyp"), ("ssid", "sstyp")],
            false => [("lstrsid", "lstrsty"), ("alesid", "alesty")],
        };
        if !of_beams && record.integer("ctype") != 2 {
            let why = "a coupling to fluids; 2 ties nodes to solids";
            self.unsupported_card(record, "ctype", why);
            return None;
        }
        let wrong = match of_beams {
            true if record.integer("cdir") != 0 => {
                Some(("cdir", "beams that slide along their axis"))
            }
            true if record.integer("axfor") != 0 => Some(("axfor", "a bond that fails")),
            _ => None,
        };
        if let Some((field, why)) = wrong {
            self.unsupported_card(record, field, why);
            return None;
        }
        let (start, end) = (record.real("start"), record.real("end"));
        if start > 0.0 || (end > 0.0 && end < self.end_time) {
            let field = if start > 0.0 { "start" } else { "end" };
            self.unsupported_value(record, field, "ties that begin or end within the run");
        }
        let mut parts_of = |(field, kind): (&str, &str)| {
            let (number, place) = (record.integer(field), record.place(field));
            match record.integer(kind) {
                0 => Some(self.part_set(number, place)),
                1 => Some(if self.has_part(number, place) { vec![number] } else { Vec::new() }),
                _ => {
                    self.unsupported_card(record, kind, "use 0 (a set of parts) or 1 (a part)");
                    None
                }
            }
        };
        let (beams, solids) = (parts_of(inner)?, parts_of(outer)?);
        if beams.is_empty() || solids.is_empty() {
            return None;
        }
        let nodes = self.rows.nodes_of(|p| beams.contains(&i64::from(p)));
        let set =
            self.rows.add_new_set(&format!("embedded-{number}"), nodes, record.place(inner.0));
        let name = match record.word("heading") {
            "" => format!("embedded {number}"),
            heading => heading.to_string(),
        };
        let used = "nodes tied to the solids in which they are";
        self.map(&name, record.name(), used);
        Some(
            JobTable::new(record.head)
                .with("name", record.head, name)
                .with("nodes", record.place(inner.0), set)
                .with("parts", record.place(outer.0), solids)
                .with("inside", record.head, true),
        )
    }

    /// Converts `*CONSTRAINED_INTERPOLATION`.
    pub(super) fn interpolations(&mut self) {
        for (record, number) in self.take_records("CONSTRAINED_INTERPOLATION").iter().zip(1..) {
            self.interpolation(record, number);
        }
    }

    fn interpolation(&mut self, record: &CardRecord, number: usize) {
        let ddof = record.integer("ddof");
        if ![0, 123, 123_456].contains(&ddof) {
            let why = "give 123 (displacements) or 123456 (and rotations)";
            return self.unsupported_card(record, "ddof", why);
        }
        let mut weights: BTreeMap<NodeId, f64> = BTreeMap::new();
        let lines: Vec<CardLine> = record.lines("inid").cloned().collect();
        for line in &lines {
            let idof = line.integer("idof").to_string();
            let [x, y, z] = ["twghtx", "twghty", "twghtz"].map(|name| line.real(name));
            if idof != "0" && !["1", "2", "3"].iter().all(|dof| idof.contains(dof)) {
                return self.unsupported_card(record, "idof", "give 123 or 123456");
            }
            if [y, z].iter().any(|&w| w != 0.0 && w != x) {
                return self.unsupported_card(record, "twghty", "weights that differ by direction");
            }
            let (of, place) = (line.integer("inid"), line.place("inid"));
            let nodes: Vec<NodeId> = match record.integer("ityp") {
                0 => id(of).into_iter().collect(),
                1 if self.node_set(of, place).is_some() => self.node_sets[&of].0.clone(),
                1 => return,
                _ => return self.unsupported_card(record, "ityp", "give 0 (nodes) or 1 (sets)"),
            };
            let weight = if x == 0.0 { 1.0 } else { x };
            nodes.into_iter().for_each(|node| *weights.entry(node).or_default() += weight);
        }
        let place = record.place("dnid");
        let (slave, masters) = (format!("mean-{number}-node"), format!("mean-{number}-of"));
        let node: Vec<NodeId> = id(record.integer("dnid")).into_iter().collect();
        let slave = self.rows.add_new_set(&slave, node, place);
        // Only nodes of elements have a motion.
        let used: HashSet<NodeId> = self.rows.nodes_of(|_| true).into_iter().collect();
        let before = weights.len();
        let lost = self.rows.lost_nodes();
        if before > 0 && weights.keys().all(|node| lost.contains(node)) {
            let message = "all its independent nodes are those of parts that are left out";
            return self.trouble.warning(record.place("inid"), message, "it has no effect");
        }
        weights.retain(|node, _| used.contains(node));
        if weights.is_empty() || weights.len() < before {
            let message = format!(
                "{}: {} of its {before} independent nodes belong to no element",
                record.name(),
                before - weights.len()
            );
            if weights.is_empty() {
                let help = "name nodes of elements: only they move";
                return self.trouble.error(record.place("inid"), message, help);
            }
            let help = "they are left out of the mean; name nodes of elements";
            self.trouble.warning(record.place("inid"), message, help);
        }
        let masters = self.rows.add_new_set(&masters, weights.keys().copied().collect(), place);
        let mut table = JobTable::new(record.head)
            .with("name", record.head, format!("interpolation {}", record.integer("icid")))
            .with("nodes", place, slave)
            .with("mean_of", record.place("inid"), masters)
            .with("rotations", record.place("ddof"), ddof != 123);
        let first = weights.values().next().copied().unwrap_or(1.0);
        if weights.values().any(|w| *w != first) {
            let weights: Vec<f64> = weights.into_values().collect();
            table.put("weights", record.place("twghtx"), weights);
        }
        self.add_tie(record.block, table);
    }

    fn tie(&mut self, record: &CardRecord, (number, name): (usize, String), rotations: bool) {
        let (of, label) = (format!("tie {number}"), format!("tie-{number}"));
        let offset = OFFSETS.iter().find(|o| record.has(o));
        let card = TieCard { record, label: &label, name, rotations, offset: offset.is_some() };
        let Some(table) = self.tie_table(card) else { return };
        if record.has("MORTAR") {
            self.map(&of, "MORTAR", "the tie without MORTAR");
        }
        let asked =
            record.row.keyword.name.replace("CONTACT_", "").to_lowercase().replace('_', " ");
        let asked = offset
            .map_or(asked.clone(), |o| format!("{asked}, {}", o.to_lowercase().replace('_', " ")));
        let used = match (offset, rotations) {
            (None, false) => "displacements tied, nodes moved onto the surface",
            (None, true) => "displacements and rotations tied, nodes moved onto the surface",
            (Some(_), false) => {
                "displacements tied at the end of arms that rotate with the surface, by a \
                 constraint"
            }
            (Some(_), true) => {
                "displacements, at the end of arms, and rotations tied, by a constraint"
            }
        };
        self.map(of, asked, used);
        self.add_tie(record.block, table);
    }

    /// Returns the table of a tie; none if it has no nodes or no surface.
    pub(super) fn tie_table(&mut self, card: TieCard<'_>) -> Option<JobTable> {
        let TieCard { record, label, name, rotations, offset } = card;
        let nodes = self.tied_nodes(record, label);
        let (nodes, surface) = (nodes?, self.surface(record, label)?);
        let mut table = JobTable::new(record.head)
            .with("name", record.head, name)
            .with("nodes", record.place("surfa"), nodes)
            .with("rotations", record.head, rotations)
            .with("offset", record.head, offset);
        match surface {
            TiedSurface::Parts(parts) => table.put("parts", record.place("surfb"), parts),
            TiedSurface::Faces(set) => table.put("faces", record.place("surfb"), set),
        }
        // A negative value is the distance itself; positive values replace the thicknesses of the
        // parts.
        let off = ["sast", "sbst"].map(|side| record.real(side));
        let place = record.place("sast");
        match off[0].min(off[1]) {
            least if least < 0.0 => table.put("tolerance", place, least.abs()),
            _ if off != [0.0; 2] => table.put("thicknesses", place, off),
            _ => {}
        }
        for field in ["saboxid", "sbboxid"] {
            if record.integer(field) != 0 {
                self.unsupported_value(record, field, "give the nodes by a set");
            }
        }
        let (birth, death) = (self.birth_of_tie(record), record.real("dt"));
        if birth > 0.0 || (death > 0.0 && death < self.end_time) {
            let field = if birth > 0.0 { "bt" } else { "dt" };
            self.unsupported_value(record, field, "ties with a birth or death time within the run");
        }
        Some(table)
    }

    /// Returns the time from which a tie acts. One shortly after the start is the start.
    fn birth_of_tie(&mut self, record: &CardRecord) -> f64 {
        let birth = record.real("bt");
        if birth <= 0.0 || birth > SOON * self.end_time {
            return birth;
        }
        let asked = format!("birth time {birth}, early in the run of {}", self.end_time);
        self.map(record.name(), asked, "tied from the start");
        0.0
    }

    /// Returns the name of a set with the nodes of the first side.
    fn tied_nodes(&mut self, record: &CardRecord, label: &str) -> Option<String> {
        let (id, place) = (record.integer("surfa"), record.place("surfa"));
        match record.integer("surfatyp") {
            4 => self.node_set(id, place),
            2 => {
                let parts = self.part_set(id, place);
                (!parts.is_empty()).then(|| self.nodes_of_parts(&parts))
            }
            3 => self.has_part(id, place).then(|| self.nodes_of_parts(&[id])),
            0 => self.nodes_of_segments(record, "surfa", format!("{label}-nodes")),
            _ => {
                self.unsupported_card(
                    record,
                    "surfatyp",
                    "give the nodes by 0 (segments), 2 (set of parts), 3 (part) or 4 (nodes)",
                );
                None
            }
        }
    }

    /// Returns the surface of the second side.
    fn surface(&mut self, record: &CardRecord, label: &str) -> Option<TiedSurface> {
        let (id, place) = (record.integer("surfb"), record.place("surfb"));
        match record.integer("surfbtyp") {
            2 => Some(TiedSurface::Parts(self.part_set(id, place)))
                .filter(|s| !matches!(s, TiedSurface::Parts(p) if p.is_empty())),
            3 => self.has_part(id, place).then(|| TiedSurface::Parts(vec![id])),
            0 => self
                .nodes_of_segments(record, "surfb", format!("{label}-faces"))
                .map(TiedSurface::Faces),
            _ => {
                self.unsupported_card(
                    record,
                    "surfbtyp",
                    "give the surface by 0 (segments), 2 (set of parts) or 3 (part)",
                );
                None
            }
        }
    }

    /// Adds a set with the nodes of a set of segments.
    fn nodes_of_segments(
        &mut self,
        record: &CardRecord,
        side: &str,
        name: String,
    ) -> Option<String> {
        let (id, place) = (record.integer(side), record.place(side));
        let Some(set) = self.segment_sets.get(&id) else {
            let known: Vec<String> = self.segment_sets.keys().map(i64::to_string).collect();
            self.missing(place, "*SET_SEGMENT", id, &known);
            return None;
        };
        let mut nodes: Vec<NodeId> = set.iter().flat_map(|s| s.nodes.iter().copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        self.rows.add_set(name.clone(), nodes, place);
        Some(name)
    }
}

/// A surface to which nodes are tied.
enum TiedSurface {
    /// All faces of parts.
    Parts(Vec<i64>),
    /// The faces within a node set.
    Faces(String),
}
