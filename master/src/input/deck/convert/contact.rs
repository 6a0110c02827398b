//! Converts `*CONTACT_...`: contact and its interfaces, one for each card.

use super::DeckConverter;
use super::names::names;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::{Entry, Node, NodeContent, Place};
use crumple_proto::ids::NodeId;
use crumple_proto::job::ContactInput;
use crumple_proto::mesh::Shape;
use std::collections::{BTreeMap, BTreeSet};

/// Contacts that include the thickness of beams (LS-DYNA support, contact types 13 and 26).
const WITH_BEAMS: [&str; 2] = ["CONTACT_AUTOMATIC_SINGLE_SURFACE", "CONTACT_AUTOMATIC_GENERAL"];

pub(super) const KEYWORDS: [(&str, bool); 15] = [
    ("CONTACT_AUTOMATIC_SINGLE_SURFACE", true),
    ("CONTACT_AUTOMATIC_GENERAL", true),
    ("CONTACT_SINGLE_SURFACE", true),
    ("CONTACT_ERODING_SINGLE_SURFACE", true),
    ("CONTACT_AUTOMATIC_SURFACE_TO_SURFACE", false),
    ("CONTACT_AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE", false),
    ("CONTACT_AUTOMATIC_NODES_TO_SURFACE", false),
    ("CONTACT_SURFACE_TO_SURFACE", false),
    ("CONTACT_ONE_WAY_SURFACE_TO_SURFACE", false),
    ("CONTACT_NODES_TO_SURFACE", false),
    ("CONTACT_ERODING_SURFACE_TO_SURFACE", false),
    ("CONTACT_ERODING_NODES_TO_SURFACE", false),
    ("CONTACT_FORMING_SURFACE_TO_SURFACE", false),
    ("CONTACT_FORMING_ONE_WAY_SURFACE_TO_SURFACE", false),
    ("CONTACT_FORMING_NODES_TO_SURFACE", false),
];

/// Contact thickness of tools of forming contacts, as a fraction of that of their section: they
/// have none, and the engine takes no zero.
const OF_TOOLS: f64 = 1e-3;

/// Value of `soft` for contact between segments.
const BY_SEGMENTS: i64 = 2;

/// Contacts whose option MORTAR selects the law of segments.
const WITH_MORTAR: [&str; 2] =
    ["CONTACT_AUTOMATIC_SINGLE_SURFACE", "CONTACT_AUTOMATIC_SURFACE_TO_SURFACE"];

/// Friction of a part, or of two parts in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Friction {
    /// Static coefficient.
    fixed: f64,
    /// Dynamic coefficient.
    sliding: f64,
    /// Decay from the static to the dynamic coefficient with the speed [time/length].
    decay: f64,
    /// Largest shear stress, 0 without a limit [force/length^2].
    limit: f64,
}

impl Friction {
    /// Reads the friction of a card.
    pub(super) fn from_record(record: &CardRecord) -> Self {
        let [fixed, sliding, decay, limit] =
            ["fs", "fd", "dc", "vc"].map(|field| record.real(field));
        Self { fixed, sliding, decay, limit }
    }

    /// Returns the friction of two parts: the mean of their coefficients, and the lower limit.
    fn between(self, other: Self) -> Self {
        let mean = |a: f64, b: f64| if a == b { a } else { 0.5 * (a + b) };
        let limits = [self.limit, other.limit].into_iter().filter(|&limit| limit > 0.0);
        Self {
            fixed: mean(self.fixed, other.fixed),
            sliding: mean(self.sliding, other.sliding),
            decay: mean(self.decay, other.decay),
            limit: limits.fold(f64::INFINITY, f64::min),
        }
    }

    fn bits(self) -> [u64; 4] {
        [self.fixed, self.sliding, self.decay, self.limit].map(f64::to_bits)
    }
}

/// Returns true if a contact of two sides holds only the nodes of the first. The formulation of
/// segments (`soft` 2) has no nodes, and checks both sides.
fn holds_one_side(record: &CardRecord) -> bool {
    let keyword = record.row.keyword.name;
    keyword.contains("NODES_TO_SURFACE")
        || keyword.contains("ONE_WAY") && record.integer("soft") != BY_SEGMENTS
}

impl DeckConverter {
    /// Converts the first contact to `[contact]` and the others to interfaces. Of several that
    /// name two parts the last one holds, so contacts of one surface come before those of two.
    /// `shifted` is the setting that contact uses the offset of shells.
    pub(super) fn contacts(&mut self, shifted: Option<(i64, Place)>) {
        let mut found: Vec<(bool, CardRecord)> = Vec::new();
        for (keyword, single) in KEYWORDS {
            found.extend(self.take_records(keyword).into_iter().map(|record| (single, record)));
        }
        let broken = std::mem::take(&mut self.broken_contacts);
        found.extend(broken.into_iter().map(|record| (false, record)));
        found.sort_by_key(|(single, record)| (!single, record.block));
        let mut tables = Vec::new();
        let names = names(found.iter().map(|f| &f.1), "contact ", ["heading", "cid"]);
        for (name, (single, record)) in names.iter().zip(&found) {
            tables.extend(self.contact(name, *single, record));
        }
        if let (Some((cntco, place)), Some(first)) = (shifted, tables.first()) {
            let thick = tables.iter().any(|t| t.has("thickness") || t.has("thickness_scale"));
            if self.is_shifted(cntco, place, thick) {
                let place = first.place();
                tables[0].put("shell_offset", place, true);
            }
        }
        self.put_contacts(tables);
    }

    /// Adds contacts to the job: the first as `[contact]`, the others as its interfaces.
    pub(super) fn put_contacts(&mut self, tables: Vec<JobTable>) {
        let mut tables = tables.into_iter();
        if let Some(mut first) = tables.next() {
            let mut interfaces: Vec<JobTable> = tables.collect();
            // An interface inherits the keys that it does not set.
            let default = ContactInput::default().law;
            for table in interfaces.iter_mut().filter(|table| first.has("law") && !table.has("law"))
            {
                table.put("law", table.place(), default.as_str());
            }
            let neutral = [
                ("friction", 0.0),
                ("friction_limit", 0.0),
                ("birth", 0.0),
                ("death", f64::MAX),
                ("thickness_scale", 1.0),
            ];
            for (key, value) in neutral {
                let said = first.has(key) || key == "thickness_scale" && first.has("thickness");
                for table in interfaces.iter_mut().filter(|table| said && !table.has(key)) {
                    table.put(key, table.place(), value);
                }
            }
            let place = first.place();
            if !interfaces.is_empty() {
                first.put("interface", place, interfaces);
            }
            self.tree.set("contact", place, first);
        }
    }

    /// Converts a contact to a table of `[contact]` or of an interface, and to further tables if
    /// its parts have individual friction. Returns no table if the contact has no surface.
    fn contact(&mut self, name: &str, single: bool, record: &CardRecord) -> Vec<JobTable> {
        let mut table = JobTable::new(record.head).with("name", record.head, name);
        if single && record.integer("surfb") == 0 {
            // The type of a side that is not there has no meaning.
            record.integer("surfbtyp");
        }
        let sides: &[(&str, &str, &str, &str)] = match single {
            true => &[("surfa", "surfatyp", "parts", "saboxid")],
            false => &[
                ("surfa", "surfatyp", "parts", "saboxid"),
                ("surfb", "surfbtyp", "against", "sbboxid"),
            ],
        };
        for (side, kind, key, within) in sides {
            let has_box = record.integer(within) != 0;
            let parts = match self.side(record, side, kind) {
                // All parts; in `against` they must be named.
                None if *key == "parts" && !has_box => continue,
                None => self.parts.keys().copied().collect(),
                Some(parts) => parts,
            };
            let parts =
                if has_box { self.parts_in_box(record, name, within, parts) } else { parts };
            if parts.is_empty() {
                let message = format!("{name} is left out: there are no parts in {side}");
                self.trouble.warning(
                    record.place(side),
                    message,
                    "name parts of shells or solids, or remove the contact",
                );
                return Vec::new();
            }
            table.put(key, record.place(side), parts);
        }
        if record.has("MORTAR") {
            self.mortar(record, name, &mut table);
        }
        let keyword = record.row.keyword.name;
        // In ties a negative value is the distance of tied nodes.
        let is_distance = ["sast", "sbst"].iter().any(|side| record.real(side) < 0.0);
        let is_forming = keyword.contains("FORMING");
        if is_forming {
            let tools = table.integers("against").unwrap_or_default();
            self.tool_thickness(record, name, &tools);
        } else if !(is_distance && keyword.contains("TIEBREAK")) {
            self.thickness(record, name, single, &mut table);
        }
        let of_shells = !keyword.contains("AUTOMATIC") && !single && !is_forming;
        if of_shells && record.integer("shlthk") == 0 {
            self.map(name, "shlthk 0: shells without thickness", "shells with their thickness");
        }
        let (birth, death) = (record.real("bt"), record.real("dt"));
        if birth > 0.0 {
            table.put("birth", record.place("bt"), birth);
        }
        if death > 0.0 && death < self.end_time {
            table.put("death", record.place("dt"), death);
        }
        let kind = record.row.keyword.name.replace("CONTACT_", "");
        let said =
            ["AUTOMATIC_", "ERODING_", "FORMING_"].iter().fold(kind, |n, w| n.replace(w, ""));
        let one_way = !single && holds_one_side(record);
        let used = match single {
            true if table.has("parts") => "every part of its set with every other and itself",
            true => "every part with every other and itself",
            false if one_way => "one_way: the faces of surfb hold the nodes of the parts of surfa",
            false => "the parts of one side with those of the other, in both directions",
        };
        if one_way {
            table.put("one_way", record.head, true);
        }
        if keyword.contains("ONE_WAY") && !matches!(record.integer("soft"), 0 | BY_SEGMENTS) {
            let asked = format!("soft {}", record.integer("soft"));
            self.map(name, asked, "not used: contact needs no stiffness from the deck");
        }
        self.map(name, said.to_lowercase().replace('_', " "), used);
        self.with_beams(record, name, &mut table);
        self.options(record);
        self.friction(record, name, &mut table);
        let mut tables = vec![table];
        if record.real("fs") == -1.0 {
            self.friction_of_parts(record, name, &mut tables);
        }
        tables
    }

    /// Selects the law of segments, for contacts that have it.
    fn mortar(&mut self, record: &CardRecord, name: &str, table: &mut JobTable) {
        if WITH_MORTAR.contains(&record.row.keyword.name) {
            table.put("law", record.head, "mortar");
            self.map(name, "MORTAR", "law mortar, with a stiffness from masses and the step size");
        } else {
            self.map(name, "MORTAR", "the contact without MORTAR");
        }
    }

    /// Includes or excludes beams, and adds this to the mapping, if the deck has beams.
    fn with_beams(&mut self, record: &CardRecord, name: &str, table: &mut JobTable) {
        if self.rows.beams.is_empty() {
            return;
        }
        let keyword = record.row.keyword.name;
        let take_part = WITH_BEAMS.contains(&keyword);
        table.put("beams", record.head, take_part);
        let used = match take_part {
            true if keyword.ends_with("GENERAL") => {
                "contact of lines, also with edges of shells and solids"
            }
            true => {
                "contact of lines, also with edges of shells and solids, as in AUTOMATIC_GENERAL"
            }
            false => {
                "not in this contact: only AUTOMATIC_SINGLE_SURFACE and AUTOMATIC_GENERAL have \
                 beams"
            }
        };
        self.map(name, "beams", used);
    }

    /// Returns the parts of one side; `None` for all.
    fn side(&mut self, record: &CardRecord, side: &str, kind: &str) -> Option<Vec<i64>> {
        let (id, place) = (record.integer(side), record.place(side));
        match record.integer(kind) {
            5 => None,
            _ if id == 0 => None,
            2 => Some(self.part_set(id, place)),
            3 => Some(if self.has_part(id, place) { vec![id] } else { Vec::new() }),
            6 => {
                let out = self.part_set(id, place);
                Some(self.parts.keys().copied().filter(|p| !out.contains(p)).collect())
            }
            0 => match self.segment_set(id, place) {
                Some(set) => {
                    let nodes: BTreeSet<_> =
                        set.iter().flat_map(|s| s.nodes.iter().copied()).collect();
                    Some(self.parts_with(record, side, "segments", &nodes))
                }
                None => Some(Vec::new()),
            },
            4 => {
                self.node_set(id, place)?;
                let nodes: BTreeSet<_> = self.node_sets[&id].0.iter().copied().collect();
                Some(self.parts_with(record, side, "nodes", &nodes))
            }
            _ => {
                self.unsupported_value(
                    record,
                    kind,
                    "use 0 (segments), 2 or 6 (set of parts), 3 (part), 4 (nodes) or 5 (all)",
                );
                Some(Vec::new())
            }
        }
    }

    /// Returns the parts that have any of these nodes, because contact works with whole parts.
    fn parts_with(
        &mut self,
        record: &CardRecord,
        side: &str,
        what: &str,
        nodes: &BTreeSet<NodeId>,
    ) -> Vec<i64> {
        let found: BTreeSet<i64> = self
            .rows
            .elements()
            .filter(|e| {
                // Particles touch others as nodes.
                let touches = !e.shape.faces().is_empty() || e.shape == Shape::Point1;
                touches && e.corners().iter().any(|n| nodes.contains(n))
            })
            .map(|e| i64::from(e.part))
            .collect();
        let list: Vec<String> = found.iter().map(i64::to_string).collect();
        self.map(
            "contact",
            format!("{side}: {what} of set {}", record.integer(side)),
            format!("the parts {}", list.join(", ")),
        );
        found.into_iter().collect()
    }

    /// Returns those of some parts that have nodes in a box at the start. A part that is partly in
    /// it takes part as a whole, with a warning.
    fn parts_in_box(
        &mut self,
        record: &CardRecord,
        name: &str,
        field: &str,
        parts: Vec<i64>,
    ) -> Vec<i64> {
        let (id, place) = (record.integer(field), record.place(field));
        let inside: BTreeSet<NodeId> = self.in_box(id, place).into_iter().collect();
        // Two marks of a part: it has nodes in the box, and nodes out of it.
        let mut found: BTreeMap<i64, [bool; 2]> = BTreeMap::new();
        for element in self.rows.elements() {
            let [within, without] = found.entry(i64::from(element.part)).or_default();
            for node in element.corners() {
                let is_in = inside.contains(node);
                *within |= is_in;
                *without |= !is_in;
            }
        }
        let state = |part: &i64| found.get(part).copied().unwrap_or_default();
        let kept: Vec<i64> = parts.into_iter().filter(|part| state(part)[0]).collect();
        let list = |of: &[i64]| of.iter().map(i64::to_string).collect::<Vec<_>>().join(", ");
        self.map(name, format!("{field} {id}"), format!("the parts in it: {}", list(&kept)));
        let cut: Vec<i64> = kept.iter().copied().filter(|part| state(part)[1]).collect();
        if !cut.is_empty() {
            let message = format!(
                "{name}: box {id} has only some nodes of the parts {}, which take part as a whole",
                list(&cut)
            );
            let help = "contact works with whole parts: divide them at the box, if it matters";
            self.trouble.warning(place, message, help);
        }
        kept
    }

    /// Converts the friction of the card, except for fs -1.
    fn friction(&mut self, record: &CardRecord, name: &str, table: &mut JobTable) {
        let fs = record.real("fs");
        let [factor, of_limit] = ["fsf", "vsf"].map(|field| record.real_or(field, 1.0));
        if factor != 1.0 && (fs == 2.0 || fs == -1.0) {
            let help = "friction by a table or by parts has no factor: give them its product";
            self.unsupported_value(record, "fsf", help);
        }
        if fs == 2.0 && record.name().ends_with("SURFACE_TO_SURFACE") {
            let (id, place) = (record.real("fd") as i64, record.place("fd"));
            if let Some(rows) = self.table_rows(id, place) {
                table.put("friction_table", place, rows);
                let to = "friction_table: coefficients by pressure and speed";
                self.map(name, format!("fs 2, fd {id}: a table"), to.to_string());
            }
            put_friction_limit(record, of_limit * record.real("vc"), table);
        } else if fs >= 0.0 {
            let given = Friction::from_record(record);
            let friction = Friction {
                fixed: factor * given.fixed,
                sliding: factor * given.sliding,
                limit: of_limit * given.limit,
                ..given
            };
            self.put_friction(record, name, friction, table);
        } else if fs != -1.0 {
            self.unsupported_value(
                record,
                "fs",
                "-1 selects the friction of the parts; other codes refer to tables",
            );
        }
    }

    fn put_friction(
        &mut self,
        record: &CardRecord,
        name: &str,
        friction: Friction,
        table: &mut JobTable,
    ) {
        let Friction { fixed, sliding, decay, limit } = friction;
        table.put("friction", record.place("fs"), fixed);
        if decay > 0.0 && fixed != sliding {
            table.put("friction_dynamic", record.place("fd"), sliding);
            table.put("friction_decay", record.place("dc"), decay);
        } else if fixed != sliding {
            self.map(
                name,
                format!("fs {fixed}, fd {sliding}, no decay"),
                format!("friction {fixed}"),
            );
        }
        put_friction_limit(record, limit, table);
    }

    /// Converts the friction of `*PART_CONTACT`. Parts with equal friction form a group, and each
    /// two groups in contact get an interface. The first two groups are those of the contact
    /// itself.
    fn friction_of_parts(&mut self, record: &CardRecord, name: &str, tables: &mut Vec<JobTable>) {
        let named = |table: &JobTable, key: &str| table.integers(key);
        let everyone: Vec<i64> = self.parts.keys().copied().collect();
        let ahead = named(&tables[0], "parts").unwrap_or_else(|| everyone.clone());
        let behind = named(&tables[0], "against");
        let groups = |parts: &[i64]| {
            let mut groups: BTreeMap<[u64; 4], (Friction, Vec<i64>)> = BTreeMap::new();
            for &part in parts {
                let none = Friction { fixed: 0.0, sliding: 0.0, decay: 0.0, limit: 0.0 };
                let of = self.part_friction.get(&part).copied().unwrap_or(none);
                groups.entry(of.bits()).or_insert((of, Vec::new())).1.push(part);
            }
            groups.into_values().collect::<Vec<_>>()
        };
        let ones = groups(&ahead);
        let others = behind.as_ref().map(|parts| groups(parts));
        let mut frictions = Vec::new();
        for (i, one) in ones.iter().enumerate() {
            for other in others.as_deref().unwrap_or(&ones[i..]) {
                let alone = others.is_none() && one.1 == other.1;
                frictions.push((
                    one.0.between(other.0),
                    one.1.clone(),
                    (!alone).then(|| other.1.clone()),
                ));
            }
        }
        let count = frictions.len();
        let plain = tables[0].copy();
        for (i, (friction, parts, against)) in frictions.into_iter().enumerate() {
            let (of, mut table) = if i == 0 {
                (name.to_string(), plain.copy())
            } else {
                let of = format!("{name}, {}", i + 1);
                let table = plain.copy().with("name", record.head, of.as_str()).with(
                    "parts",
                    record.head,
                    parts,
                );
                (
                    of,
                    match against {
                        Some(against) => table.with("against", record.head, against),
                        None => table,
                    },
                )
            };
            self.put_friction(record, &of, friction, &mut table);
            match i {
                0 => tables[0] = table,
                _ => tables.push(table),
            }
        }
        let used = match count {
            1 => "the same for all parts".to_string(),
            _ => format!("{count} interfaces; for two parts the mean of their values"),
        };
        self.map(name, "fs -1: friction of the parts", used);
    }

    /// Returns true if contact uses the offset of shells by `cntco`. With 1 LS-DYNA takes half the
    /// contact thickness times nloc as the offset, with 2 half the thickness of the shell, as the
    /// engine does. `thick` is true if a contact has a contact thickness of its own.
    fn is_shifted(&mut self, cntco: i64, place: Place, thick: bool) -> bool {
        let Some(&(part, _)) = self.with_offset.first() else { return false };
        let thick = thick || self.with_offset.iter().any(|&(_, own)| own);
        let wrong = match cntco {
            1 if thick => {
                "with 1 the offset is a fraction of the contact thickness, and this deck \
                           gives contact thicknesses: set cntco to 2, for the offset of the \
                           elements, or remove them (sast, sbst, sfsat, sfsbt, optt, sft)"
            }
            1 | 2 => {
                self.map(
                    "*CONTROL_SHELL",
                    format!("cntco {cntco}: contact at the middle surface of shells"),
                    "contact.shell_offset",
                );
                return true;
            }
            _ => "set it to 0 (contact is at the nodes), 1 or 2 (at the middle surface)",
        };
        let message = format!("cntco is {cntco}, and part {part} has an offset: {wrong}");
        self.unsupported(place, message, "*CONTROL_SHELL cntco".into());
        false
    }

    /// Converts the contact thickness, given directly or by a factor. For two surfaces the mean
    /// is used. A side without a given thickness has that of its shells.
    fn thickness(&mut self, record: &CardRecord, name: &str, single: bool, table: &mut JobTable) {
        let given = ["sast", "sbst"].map(|field| record.real(field));
        let [a, b] = if single { [given[0]; 2] } else { given };
        if a < 0.0 || b < 0.0 {
            let field = if a < 0.0 { "sast" } else { "sbst" };
            self.unsupported_value(record, field, "give a thickness above 0");
        } else if a > 0.0 && b > 0.0 {
            table.put("thickness", record.place("sast"), 0.5 * (a + b));
            if a != b {
                let used = format!("thickness {}", 0.5 * (a + b));
                self.map(name, format!("thicknesses {a} and {b}"), used);
            }
        } else if a > 0.0 || b > 0.0 {
            let (field, value, other) =
                if a > 0.0 { ("sast", a, "against") } else { ("sbst", b, "parts") };
            let parts = table.integers(other).unwrap_or_default();
            match self.only_thickness(&parts) {
                // Solids have no thickness in contact.
                Some(0.0) => table.put("thickness", record.place(field), value),
                Some(own) => {
                    let used = 0.5 * (value + own);
                    table.put("thickness", record.place(field), used);
                    let asked = format!("{field} {value}, shells of {own} on the other side");
                    self.map(name, asked, format!("thickness {used}"));
                }
                None => {
                    let why = "give both sides a thickness: the elements of the other side have no \
                               common one";
                    self.unsupported_value(record, field, why);
                }
            }
        }
        let factor = |field| {
            if record.is_blank(field) || record.real(field) == 0.0 {
                1.0
            } else {
                record.real(field)
            }
        };
        let [fa, fb] = ["sfsat", "sfsbt"].map(factor);
        if !single && fa != fb {
            self.unsupported_value(record, "sfsat", "give the same factor for both sides");
        } else if fa != 1.0 {
            table.put("thickness_scale", record.place("sfsat"), fa);
        }
    }

    /// Returns the only contact thickness of the elements of some parts, 0 for solids [length].
    /// Returns `None` if they differ, or if it is not that of a section.
    fn only_thickness(&mut self, parts: &[i64]) -> Option<f64> {
        let elements = self.rows.elements().filter(|e| parts.contains(&i64::from(e.part)));
        let kinds: BTreeSet<(u32, bool)> = elements.map(|e| (e.part, e.shape.is_solid())).collect();
        let own: BTreeSet<i64> = self.thickness_of_elements().into_keys().collect();
        let mut only = None;
        for (part, is_solid) in kinds {
            let part = i64::from(part);
            let thickness = match self.tree.part(part)?.get("thickness").map(|key| &key.node.kind) {
                _ if is_solid => 0.0,
                Some(&NodeContent::Float(value)) if !own.contains(&part) => value,
                _ => return None,
            };
            if only.is_some_and(|other| other != thickness) {
                return None;
            }
            only = Some(thickness);
        }
        only
    }

    /// Gives the tools of a forming contact, the shells of surfb, the thickness of sbst: their mesh
    /// is their surface, so that those of their sections do not count (LS-DYNA support, metal
    /// forming: thickness of the rigid bodies).
    fn tool_thickness(&mut self, record: &CardRecord, name: &str, tools: &[i64]) {
        for field in ["sfsat", "sfsbt"] {
            if ![0.0, 1.0].contains(&record.real_or(field, 1.0)) {
                self.unsupported_value(record, field, "use 1");
            }
        }
        if record.real("sast") != 0.0 {
            self.unsupported_value(record, "sast", "the sheet has the thickness of its section");
        }
        let given = record.real("sbst");
        if given < 0.0 {
            let why = "tools that are moved by this distance: move their mesh";
            self.unsupported_value(record, "sbst", why);
        }
        for tool in tools {
            let place = record.place("sbst");
            let Some(keys) = self.tree.part(*tool) else { continue };
            let float = |key: &str| match keys.get(key)?.node.kind {
                NodeContent::Float(value) => Some(value),
                _ => None,
            };
            let of = format!("{name}, part {tool}");
            let Some(own) = float("thickness") else {
                if given > 0.0 {
                    self.map(of, format!("sbst {given}"), "not used: it is for shells only");
                }
                continue;
            };
            let thickness = if given > 0.0 { given } else { OF_TOOLS * own };
            let differs = float("contact_thickness").is_some_and(|other| other != thickness);
            if differs || keys.contains_key("contact_thickness_scale") {
                let why = "one contact thickness for each tool: remove optt and sft of \
                           *PART_CONTACT, or give the same sbst in all contacts";
                self.unsupported_value(record, "sbst", why);
                continue;
            }
            let node = Node { kind: NodeContent::Float(thickness), place };
            keys.insert("contact_thickness".into(), Entry { key: place, node });
            let (from, to) = match given > 0.0 {
                true => (format!("sbst {given}"), format!("contact_thickness {given}")),
                false => ("tools without thickness".into(), format!("{OF_TOOLS} of its own")),
            };
            self.map(of, from, to);
        }
    }

    /// Notes options that are not supported.
    fn options(&mut self, record: &CardRecord) {
        if record.real("sldthk") != 0.0 {
            self.unsupported_value(record, "sldthk", "solids have no thickness in contact");
        }
    }
}

/// Sets the largest shear stress of friction, if there is one [force/length^2].
fn put_friction_limit(record: &CardRecord, limit: f64, table: &mut JobTable) {
    if limit > 0.0 && limit.is_finite() {
        table.put("friction_limit", record.place("vc"), limit);
    }
}
