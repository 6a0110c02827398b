//! Converts `/INTER/TYPE7`, `TYPE11`, `TYPE19`, `TYPE24` and `TYPE25`: contact and its interfaces.

use super::StarterConverter;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crumple_proto::ids::NodeId;
use std::collections::BTreeSet;

/// Keywords of contact.
const KEYWORDS: [&str; 5] =
    ["/INTER/TYPE7", "/INTER/TYPE11", "/INTER/TYPE19", "/INTER/TYPE24", "/INTER/TYPE25"];
/// Time from which on a limit is none.
const NEVER: f64 = 1e20;
/// Gap flag for a constant gap.
const CONSTANT: i64 = 1000;

/// The parts of both sides of an interface; the second is `None` for contact with itself.
struct StarterSides {
    ahead: BTreeSet<i64>,
    behind: Option<BTreeSet<i64>>,
}

impl StarterConverter {
    /// Converts all interfaces. Of several that name two parts the last one holds, so contacts of
    /// one surface come before those of two.
    pub(super) fn contacts(&mut self) {
        let records = self.take(&KEYWORDS);
        let mut tables: Vec<(bool, JobTable)> = Vec::new();
        let mut names: BTreeSet<String> = BTreeSet::new();
        let mut edges = None;
        for record in &records {
            let id = record.integer("id");
            let title = record.word("title").trim().to_string();
            let is_taken = title.is_empty() || names.contains(&title);
            let name = if is_taken { format!("interface {id}") } else { title };
            names.insert(name.clone());
            let wants_edges = match record.row.keyword.name {
                "/INTER/TYPE11" | "/INTER/TYPE19" => true,
                "/INTER/TYPE7" => false,
                _ => !matches!(record.integer("iedge"), 0 | 1000),
            };
            if wants_edges {
                edges = edges.or(Some(record.head));
            }
            tables.extend(self.interface(record, &name));
        }
        tables.sort_by_key(|(two, _)| *two);
        let mut tables: Vec<JobTable> = tables.into_iter().map(|t| t.1).collect();
        if let (Some(place), Some(first)) = (edges, tables.first_mut()) {
            first.put("edges", place, true);
            if records.len() > 1 {
                self.deck.map("edges", "edges of one interface", "edges of all parts in contact");
            }
        }
        self.deck.put_contacts(tables);
    }

    /// Converts an interface to a table, with true if it has two sides.
    fn interface(&mut self, record: &CardRecord, name: &str) -> Option<(bool, JobTable)> {
        let sides = self.sides(record)?;
        let keyword = record.row.keyword.name;
        let empty = |side: &BTreeSet<i64>| side.is_empty();
        if empty(&sides.ahead) || sides.behind.as_ref().is_some_and(empty) {
            let message = format!("{name} is left out: a side has no shells and no solids");
            let help = "name nodes and faces of shells or solids, or remove the interface";
            self.deck.trouble.warning(record.head, message, help);
            return None;
        }
        let mut table = JobTable::new(record.head).with("name", record.head, name);
        let two = sides.behind.is_some();
        let one_way = two && keyword == "/INTER/TYPE7";
        let used = match two {
            false => "every part of the surface with every other and itself",
            true if one_way => "one_way: the surface holds the nodes of the parts of the group",
            true => "the parts of one side with those of the other, in both directions",
        };
        self.deck.map(name, keyword, used);
        let place = record.head;
        table.put("parts", place, sides.ahead.into_iter().collect::<Vec<i64>>());
        if let Some(behind) = sides.behind {
            table.put("against", place, behind.into_iter().collect::<Vec<i64>>());
            if one_way {
                table.put("one_way", place, true);
            }
        }
        self.friction(record, &mut table);
        let (start, stop) = (record.real("tstart"), record.real("tstop"));
        if start > 0.0 {
            table.put("birth", record.place("tstart"), start);
        }
        if stop > 0.0 && stop < NEVER {
            table.put("death", record.place("tstop"), stop);
        }
        self.gap(record, name, &mut table);
        if !self.deck.rows.beams.is_empty() {
            table.put("beams", record.head, keyword == "/INTER/TYPE11");
        }
        Some((two, table))
    }

    /// Returns the parts of an interface. Contact works with whole parts.
    fn sides(&mut self, record: &CardRecord) -> Option<StarterSides> {
        match record.row.keyword.name {
            "/INTER/TYPE7" => {
                let (grnod, surf) = (record.integer("grnod"), record.integer("surf"));
                let behind = self.surface_parts(record, surf, "surf")?;
                let ahead = match grnod {
                    0 => behind.clone(),
                    _ => {
                        self.deck.node_set(grnod, record.place("grnod"))?;
                        let nodes: BTreeSet<NodeId> =
                            self.deck.node_sets[&grnod].0.iter().copied().collect();
                        self.parts_with(&nodes, false)
                    }
                };
                let is_own = ahead == behind;
                Some(StarterSides { ahead, behind: (!is_own).then_some(behind) })
            }
            "/INTER/TYPE11" => {
                let ahead = self.line_parts(record, "lines")?;
                let behind = match record.integer("linem") {
                    0 => None,
                    _ => Some(self.line_parts(record, "linem")?),
                };
                let behind = behind.filter(|behind| *behind != ahead);
                Some(StarterSides { ahead, behind })
            }
            _ => {
                let [one, other] = ["surf1", "surf2"].map(|field| record.integer(field));
                let (first, field) = if one != 0 { (one, "surf1") } else { (other, "surf2") };
                let ahead = self.surface_parts(record, first, field)?;
                let behind = match one != 0 && other != 0 {
                    true => Some(self.surface_parts(record, other, "surf2")?),
                    false => None,
                };
                let behind = behind.filter(|behind| *behind != ahead);
                Some(StarterSides { ahead, behind })
            }
        }
    }

    fn surface_parts(
        &mut self,
        record: &CardRecord,
        id: i64,
        field: &str,
    ) -> Option<BTreeSet<i64>> {
        let surface = self.surface(id, record.place(field))?;
        Some(self.parts_of_surface(&surface))
    }

    fn line_parts(&mut self, record: &CardRecord, field: &str) -> Option<BTreeSet<i64>> {
        let (id, place) = (record.integer(field), record.place(field));
        let found = self.lines.get(&id).cloned();
        if found.is_none() {
            let known: Vec<String> = self.lines.keys().map(i64::to_string).collect();
            self.deck.missing(place, "/LINE/...", id, &known);
        }
        found
    }

    /// Converts friction: Coulomb's law, or its exponential decay with the speed.
    fn friction(&mut self, record: &CardRecord, table: &mut JobTable) {
        let fixed = record.real("fric");
        table.put("friction", record.place("fric"), fixed);
        match record.integer("ifric") {
            0 => {}
            4 => {
                table.put("friction_dynamic", record.place("cf1"), record.real("cf1"));
                table.put("friction_decay", record.place("cf2"), record.real("cf2"));
            }
            _ => {
                // The message names the law; its coefficients need none of their own.
                let _ = ["cf1", "cf2"].map(|field| record.real(field));
                let why = "laws of friction other than Coulomb's (0) and exponential decay (4)";
                self.deck.unsupported_value(record, "ifric", why);
            }
        }
    }

    /// Converts gaps: a constant gap is the contact thickness of shells.
    fn gap(&mut self, record: &CardRecord, name: &str, table: &mut JobTable) {
        match record.row.keyword.name {
            "/INTER/TYPE7" | "/INTER/TYPE19" => {
                let (gap, igap) = (record.real("gapmin"), record.integer("igap"));
                if gap > 0.0 && matches!(igap, 0 | CONSTANT) {
                    table.put("thickness", record.place("gapmin"), gap);
                    let used = format!("contact thickness {gap} of shells; solids keep their own");
                    self.deck.map(name, format!("constant gap {gap}"), used);
                } else if gap > 0.0 {
                    let asked = format!("a smallest gap {gap}");
                    self.deck.map(name, asked, "not used: the gap is the mean thickness");
                }
            }
            "/INTER/TYPE25" => {
                let scale = record.real("gapscale");
                if scale > 0.0 && scale != 1.0 {
                    table.put("thickness_scale", record.place("gapscale"), scale);
                }
            }
            _ => {}
        }
    }
}
