//! Writes contact, its interfaces and ties.

use super::{Gap, Real, StarterWriter, Whole, differing, list, named};
use crate::input::deck::export::contact::{names, rest};
use crate::input::deck::export::value_of;
use crumple_proto::job::{ContactInput, TieInput};
use toml::{Table, Value};

/// Keys of `[contact]` and of interfaces that cards have.
const CARRIED: [&str; 12] = [
    "name",
    "parts",
    "against",
    "exclude",
    "friction",
    "friction_dynamic",
    "friction_decay",
    "birth",
    "death",
    "thickness_scale",
    "edges",
    "interface",
];

impl StarterWriter<'_> {
    /// Writes contact and its interfaces as `/INTER/TYPE25`, if those of one surface come before
    /// those of two, as the reader of cards assumes, and if all of them have a law and parts on
    /// each side.
    pub(super) fn contact(&mut self) {
        let job = &self.model.job;
        let Some(contact) = &job.contact else { return };
        let ids: Vec<u32> = job
            .part
            .iter()
            .filter(|p| {
                p.spring.is_none()
                    && p.discrete_beam.is_none()
                    && p.beam.is_none()
                    && p.truss.is_none()
            })
            .map(|p| p.id)
            .collect();
        let all: Vec<ContactInput> = contact.each().collect();
        let touches = |c: &ContactInput| {
            c.law != ContactInput::NO_LAW && c.sides(&ids).iter().all(|side| !side.is_empty())
        };
        let in_order = all.iter().map(|c| !c.against.is_empty()).is_sorted();
        if !(in_order && all.iter().all(touches)) {
            self.deck.rest.insert("contact".into(), value_of(contact));
            return;
        }
        let names = names(&all);
        for (id, (one, name)) in (1..).zip(all.iter().zip(&names)) {
            self.interface(one, (id, name), (&ids, contact.edges));
        }
        differing(&mut self.deck, "contact", contact, &ContactInput::default(), &CARRIED);
        let entries: Vec<Value> = contact
            .interface
            .iter()
            .zip(&names[1..])
            .filter_map(|(i, name)| rest(i, name, &CARRIED))
            .collect();
        if !entries.is_empty()
            && let Value::Table(of) =
                self.deck.rest.entry("contact").or_insert_with(|| Value::Table(Table::new()))
        {
            of.insert("interface".into(), Value::Array(entries));
        }
    }

    fn interface(
        &mut self,
        c: &ContactInput,
        (id, name): (u64, &str),
        (ids, edges): (&[u32], bool),
    ) {
        let sides = c.sides(ids).map(|side| side.into_iter().map(|i| ids[i]).collect::<Vec<u32>>());
        let [ahead, behind] = sides;
        let first = self.new_surface(&format!("first side of {name}"), &ahead);
        let second = match c.against.is_empty() {
            true => 0,
            false => self.new_surface(&format!("second side of {name}"), &behind),
        };
        self.titled("INTER/TYPE25", id, name);
        let edge = Whole(if edges { 22 } else { 0 });
        self.card(&[Whole(first), Whole(second), Gap, Gap, Gap, Gap, Gap, Gap, edge]);
        let scale = if c.thickness_scale == 1.0 { 0.0 } else { c.thickness_scale };
        self.card(&[Whole(0), Gap, Real(scale)]);
        self.card(&[]);
        let stop = c.death.unwrap_or(0.0);
        self.card(&[Real(0.0), Real(c.friction), Gap, Gap, Real(c.birth), Real(stop)]);
        self.card(&[]);
        let decays = c.friction_dynamic.is_some() || c.friction_decay != 0.0;
        self.card(&[Whole(if decays { 4 } else { 0 })]);
        if decays {
            let sliding = c.friction_dynamic.unwrap_or(c.friction);
            self.card(&[Real(sliding), Real(c.friction_decay)]);
            self.card(&[]);
        }
    }

    /// Writes ties to parts. Those to single faces or to a node have no card.
    pub(super) fn ties(&mut self) {
        let ties = &self.model.job.tie;
        let has_no_card = |t: &TieInput| {
            t.faces.is_some()
                || t.node.is_some()
                || t.mean_of.is_some()
                || t.failure.is_some()
                || t.inside
                || t.name.is_empty()
        };
        if ties.iter().any(has_no_card) {
            return list(&mut self.deck, "tie", ties);
        }
        let first = self.model.job.contact.as_ref().map_or(0, |c| 1 + c.interface.len() as u64);
        for (tie, id) in ties.iter().zip(first + 1..) {
            let group = self.group(&tie.nodes);
            let surface = self.new_surface(&format!("surface of {}", tie.name), &tie.parts);
            self.titled("INTER/TYPE2", id, &tie.name);
            let head = [Whole(group), Whole(surface), Gap, Gap, Gap, Gap, Gap, Gap];
            self.card(&[&head[..], &[Real(tie.tolerance)]].concat());
            let mut own = Table::from_iter([named(&tie.name)]);
            for (key, value) in [("rotations", tie.rotations), ("offset", tie.offset)] {
                if !value {
                    own.insert(key.into(), value.into());
                }
            }
            if tie.thicknesses != [0.0; 2] {
                own.insert("thicknesses".into(), Value::from(tie.thicknesses.to_vec()));
            }
            if own.len() > 1 {
                self.rest("tie", own);
            }
        }
    }
}
