//! Converts `/PART` and `/SUBSET`.

use super::properties::{StarterProperties, StarterProperty};
use super::{StarterConverter, StarterPart};
use crate::input::deck::convert::materials::DeckMaterial;
use crate::input::deck::convert::parts::Shapes;
use crate::input::deck::convert::sections::SectionKind;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::{BTreeMap, BTreeSet, HashMap};

impl StarterConverter {
    pub(super) fn parts(
        &mut self,
        materials: &BTreeMap<i64, DeckMaterial>,
        properties: &StarterProperties,
    ) {
        let shapes = self.deck.shapes_of_parts();
        let own_thickness = self.deck.thickness_of_elements();
        let mut used: BTreeSet<i64> = BTreeSet::new();
        for record in self.take(&["/PART"]) {
            let (id, place) = (record.integer("id"), record.place("id"));
            let [property, material, subset] =
                ["prop", "mat", "subset"].map(|field| record.integer(field));
            if self.parts.insert(id, StarterPart { property, material, subset }).is_some() {
                self.twice("/PART", id, place);
                continue;
            }
            let name = part_name(&record, id, &mut self.names);
            let found = (materials.get(&material), properties.by_id.get(&property));
            self.check_references(&record, found, (materials, properties));
            if self.deck.is_left_out(id) {
                continue;
            }
            self.add_part(id, place, found.0.map(|m| m.name.clone()));
            let Some(of) = found.1 else { continue };
            let mut table = JobTable::new(record.head).with("id", place, id).with(
                "name",
                record.place("title"),
                name.as_str(),
            );
            if of.kind == SectionKind::Discrete {
                self.spring_mass(id, of);
                if let Some(spring) = self.spring_property(of) {
                    table.put("spring", record.place("prop"), spring);
                    self.deck.add("part", table);
                }
                continue;
            }
            let Some(law) = found.0 else { continue };
            table.put("material", record.place("mat"), law.name.as_str());
            let own = own_thickness.get(&id).map_or(&[][..], Vec::as_slice);
            let elements = (shapes.get(&id).copied().unwrap_or_default(), own);
            self.section(&record, (of, properties), elements, &mut table);
            self.note_axes(&record, of);
            self.skin(&record, law, of.kind, &mut table);
            used.insert(material);
            self.deck.add("part", table);
        }
        self.deck.remove_left_out();
        for id in used {
            if let Some(table) = materials.get(&id).and_then(|m| m.table.as_ref()) {
                let mut table = table.copy();
                self.put_axes(id, &mut table);
                self.deck.add("material", table);
            }
        }
    }

    /// Converts the property of a part.
    fn section(
        &mut self,
        record: &CardRecord,
        (of, properties): (&StarterProperty, &StarterProperties),
        (shapes, own): (Shapes, &[(usize, [f64; 4])]),
        table: &mut JobTable,
    ) {
        let id = record.integer("id");
        let has_shells = shapes.quads || shapes.triangles;
        let kind = of.kind;
        if (kind == SectionKind::Shell && shapes.have_solids())
            || (matches!(kind, SectionKind::Solid | SectionKind::ThickShell) && has_shells)
        {
            let message = format!(
                "part {id} has {} and {} {}",
                if has_shells { "shells" } else { "solids" },
                of.record.name(),
                record.integer("prop"),
            );
            let help = "give the property that fits its elements: /PROP/SHELL for shells, \
                        /PROP/SOLID or /PROP/TSHELL for solids";
            self.deck.trouble.error(record.place("prop"), message, help);
        }
        let contact = record.real("thick");
        match kind {
            SectionKind::Shell => {
                let given = of.record.real("thick");
                let thickness = match own.is_empty() {
                    true => given,
                    false => self.deck.own_thickness(id, own, [given; 4], given),
                };
                self.shell_property(id, (of, properties), thickness, table);
                if contact > 0.0 {
                    table.put("contact_thickness", record.place("thick"), contact);
                }
            }
            SectionKind::Solid => {
                self.solid_property(id, (of, properties), shapes, table);
            }
            SectionKind::Beam => self.beam_property(id, of, table),
            SectionKind::ThickShell => self.thick_shell_property(id, (of, properties), table),
            SectionKind::Discrete | SectionKind::Particle | SectionKind::Belt => {}
        }
        if contact > 0.0 && kind != SectionKind::Shell {
            let asked = format!("thickness {contact} in contact");
            self.deck.map(format!("part {id}"), asked, "not used: it is for shells only");
        }
    }

    /// Makes a part of a void material a skin.
    fn skin(
        &mut self,
        record: &CardRecord,
        law: &DeckMaterial,
        kind: SectionKind,
        table: &mut JobTable,
    ) {
        let id = record.integer("id");
        match (law.skin, kind) {
            (false, _) => {}
            (true, SectionKind::Shell) => {
                table.put("skin", record.place("mat"), true);
                self.deck.map(
                    format!("part {id}"),
                    "/MAT/VOID",
                    "a skin: it has contact and mass, and carries no load",
                );
            }
            (true, _) => {
                let message = format!("part {id}: /MAT/VOID is supported for shells only");
                self.deck.unsupported(record.place("mat"), message, "/MAT/VOID".into());
            }
        }
    }

    /// Reports a part without its material or its property.
    fn check_references(
        &mut self,
        record: &CardRecord,
        (material, property): (Option<&DeckMaterial>, Option<&StarterProperty>),
        (materials, properties): (&BTreeMap<i64, DeckMaterial>, &StarterProperties),
    ) {
        let part = record.integer("id");
        let is_spring = property.is_some_and(|p| p.kind == SectionKind::Discrete);
        if material.is_none() && !is_spring && property.is_some() {
            let known: Vec<String> = materials.keys().map(i64::to_string).collect();
            let (id, place) = (record.integer("mat"), record.place("mat"));
            if !self.deck.part_lacks(part, ("/MAT/...", "mat"), (id, place)) {
                self.deck.missing(place, "/MAT/...", id, &known);
            }
        }
        if property.is_none() {
            let known: Vec<String> = properties.by_id.keys().map(i64::to_string).collect();
            let (id, place) = (record.integer("prop"), record.place("prop"));
            if !self.deck.part_lacks(part, ("/PROP/...", "prop"), (id, place)) {
                self.deck.missing(place, "/PROP/...", id, &known);
            }
        }
    }

    /// Adds half of the mass of a spring to each of its nodes.
    fn spring_mass(&mut self, part: i64, of: &StarterProperty) {
        let mass = of.record.real("mass");
        if mass <= 0.0 {
            return;
        }
        let mut ends: HashMap<NodeId, usize> = HashMap::new();
        for spring in self.deck.rows.springs.iter().filter(|s| i64::from(s.part) == part) {
            for &node in spring.corners() {
                *ends.entry(node).or_default() += 1;
            }
        }
        let mut groups: BTreeMap<usize, BTreeSet<NodeId>> = BTreeMap::new();
        for (node, count) in ends {
            groups.entry(count).or_default().insert(node);
        }
        for (count, nodes) in groups {
            let place = of.record.place("mass");
            let total = 0.5 * mass * (count * nodes.len()) as f64;
            let set = format!("springs-{part}-{count}");
            self.deck.rows.add_set(set.clone(), nodes.into_iter().collect(), place);
            let table = JobTable::new(place).with("nodes", place, set);
            self.deck.add("mass", table.with("mass", place, total));
        }
    }

    /// Reads subsets: their parts are those that name them, and those of the subsets below them.
    pub(super) fn subsets(&mut self) {
        for (&part, of) in &self.parts {
            self.subsets.entry(of.subset).or_default().insert(part);
        }
        let mut below: BTreeMap<i64, Vec<(i64, Place)>> = BTreeMap::new();
        for record in self.take(&["/SUBSET"]) {
            let id = record.integer("id");
            self.subsets.entry(id).or_default();
            below.insert(id, super::groups::ids(&record));
        }
        for _ in 0..below.len() {
            for (id, others) in &below {
                let more: BTreeSet<i64> = others
                    .iter()
                    .filter_map(|(other, _)| self.subsets.get(other))
                    .flatten()
                    .copied()
                    .collect();
                self.subsets.entry(*id).or_default().extend(more);
            }
        }
        for (other, place) in below.into_values().flatten() {
            if !self.subsets.contains_key(&other) {
                let known: Vec<String> = self.subsets.keys().map(i64::to_string).collect();
                self.deck.missing(place, "/SUBSET", other, &known);
            }
        }
    }
}

/// Returns the name of a part, other than those of earlier parts.
fn part_name(record: &CardRecord, id: i64, names: &mut BTreeSet<String>) -> String {
    let title = record.word("title").trim().to_string();
    let name = match title.is_empty() {
        true => format!("part-{id}"),
        false if names.contains(&title) => format!("{title} ({id})"),
        false => title,
    };
    names.insert(name.clone());
    name
}
