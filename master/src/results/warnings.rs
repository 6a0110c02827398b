//! Engineering warnings: what an engineer looks at before the results are used. Each has its time,
//! its place and the setting that cures it, and is given once for each part.

use crate::input::job::Model;
use crate::results::history::{Course, HistoryRow};
use crumple_proto::histories::PartShare;
use crumple_proto::job::{Part, Setting};
use crumple_proto::mesh::{Mesh, MeshElement};
use crumple_proto::message::EdgeCrossings;
use crumple_proto::place::{ModelPlace, Peak};
use serde::{Deserialize, Serialize};

/// Hourglass energy over internal energy of a part, and of the whole model.
const MUCH_HOURGLASS: [f64; 2] = [0.1, 0.05];
/// Fraction of the largest energy of the run below which an energy does not count.
const NO_ENERGY: f64 = 0.001;
/// Energy created by contact, as a fraction of the largest energy so far.
const LITTLE_CREATED: f64 = 0.01;
/// Cure of contact that creates energy.
pub const CREATED_CURE: &str = "Look for parts that penetrate each other at the start (`crumple \
                                check` names them) or are pressed through each other; try a \
                                smaller time.dt_max, more contact.sweeps or a smaller \
                                contact.penalty_scale";
/// Energy taken by friction of contact, by friction on walls, or by contact without its friction,
/// as a fraction of the largest energy so far.
const MUCH_TAKEN: f64 = 0.1;
/// Cure of contact that takes energy without friction.
const TAKEN_CURE: &str = "The first touch takes the velocity at which two nodes meet, with the \
                          energy of their masses: less in a finer mesh. Springs of penalty \
                          contact store energy while they are pressed. Compare a run with a finer \
                          mesh where parts meet, or with another contact.law";
/// Mass added by mass scaling over the mass of a part, and of the whole model.
const MUCH_MASS: [f64; 2] = [0.1, 0.05];
/// Stable step over that of the start.
const SHORT_STEP: f64 = 0.2;
/// Step of contact over step of the elements.
const SHORT_CONTACT_STEP: f64 = 0.5;
/// Penetration over contact thickness.
const SUNK: f64 = 0.5;
/// Jacobian at a corner of an element over its value at the start.
const FLAT: f64 = 0.1;

/// Subject of a warning.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum WarningKind {
    /// Hourglass energy.
    Hourglass,
    /// Energy that contact has created: its energy is negative.
    ContactEnergy,
    /// Energy that contact takes without friction, in impacts of nodes.
    ContactLoss,
    /// Energy of friction of contact.
    Friction,
    /// Energy of friction on rigid walls.
    WallFriction,
    /// Mass added by mass scaling.
    AddedMass,
    /// Collapse of the stable step.
    TimeStep,
    /// Contact that shortens the step.
    ContactStep,
    /// Deep penetration.
    Penetration,
    /// Elements that are about to invert, or have inverted at a corner.
    Inversion,
    /// Edges that have passed through segments.
    Crossing,
    /// Contact that had nothing to do in the whole run.
    UnusedContact,
    /// Walls that nothing has touched in the whole run.
    UnusedWall,
}

impl WarningKind {
    /// Returns its name in the files of a run.
    pub fn name(self) -> String {
        let name = serde_json::to_value(self).unwrap_or_default();
        name.as_str().unwrap_or_default().into()
    }
}

/// A warning.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct EngineeringWarning {
    /// Its subject.
    pub kind: WarningKind,
    /// Name of the part; empty for the whole model.
    pub part: String,
    /// Cycle in which it was found.
    pub cycle: u64,
    /// Simulated time at which it was found [time].
    pub time: f64,
    /// The quantity that is compared with its limit, at its worst so far. All are ratios,
    /// except that of crossings of edges, the largest number that one worker has found.
    pub value: f64,
    /// Simulated time of this value [time].
    pub worst_time: f64,
    /// The observation.
    pub what: String,
    /// Element or node, with its coordinates; empty if there is none.
    pub place: String,
    /// The setting that cures it.
    pub cure: String,
}

impl EngineeringWarning {
    /// Returns the warning as one line, without its end.
    pub fn line(&self) -> String {
        let part =
            if self.part.is_empty() { String::new() } else { format!("part {}: ", self.part) };
        let place = if self.place.is_empty() { String::new() } else { format!("; {}", self.place) };
        let since = if self.time < self.worst_time {
            format!(" (since time {:.6e}, cycle {})", self.time, self.cycle)
        } else {
            String::new()
        };
        format!("at time {:.6e} {part}{}{since}{place}. {}", self.worst_time, self.what, self.cure)
    }

    /// Returns true if this one is worse than an earlier one of its kind.
    fn is_worse(&self, than: &Self) -> bool {
        match self.kind {
            WarningKind::TimeStep | WarningKind::ContactStep | WarningKind::Inversion => {
                self.value < than.value
            }
            _ => self.value > than.value,
        }
    }
}

/// Adds the warnings of a row to those of the run: new ones, and worse values of those that were
/// given. Returns the number of warnings that were there before; the new ones follow.
#[must_use]
pub fn merge(all: &mut Vec<EngineeringWarning>, found: Vec<EngineeringWarning>) -> usize {
    let before = all.len();
    for one in found {
        match all.iter_mut().find(|known| known.kind == one.kind && known.part == one.part) {
            Some(known) if one.is_worse(known) => {
                *known = EngineeringWarning { cycle: known.cycle, time: known.time, ..one }
            }
            Some(_) => {}
            None => all.push(one),
        }
    }
    before
}

/// A row of the history, with what its warnings need.
#[derive(Clone, Copy)]
pub struct WatchedRow<'a> {
    /// Parts of the settings.
    pub parts: &'a [Part],
    /// The rows so far; the last one is judged.
    pub course: &'a Course,
    /// Number of times that shells may be divided; each halves their step.
    pub levels: u32,
}

impl WatchedRow<'_> {
    /// Returns the warnings of the last row.
    pub fn warnings(&self) -> Vec<EngineeringWarning> {
        let Some(row) = &self.course.last else { return Vec::new() };
        let mut found = self.hourglass(row);
        found.extend(self.contact_energy(row));
        found.extend(self.contact_loss(row));
        let e = &row.sum.energies;
        let of_contact = (WarningKind::Friction, "of contact", e.friction);
        let cure = "Compare a run with another contact.friction";
        found.extend(self.friction(row, of_contact, &row.sum.sliding.at, cure));
        let of_walls = (WarningKind::WallFriction, "on rigid walls", e.wall_friction);
        let cure = "Compare a run with another wall.friction";
        found.extend(self.friction(row, of_walls, &ModelPlace::default(), cure));
        found.extend(self.step(row));
        found.extend(self.contact_step(row));
        found.extend(self.penetration(row));
        found.extend(self.inversion(row));
        found
    }

    /// Returns the warnings of a run that is complete: what it had, and never used. `has_contact`
    /// is true if the job asks for contact, `walls` are the names of its walls.
    pub fn unused(&self, has_contact: bool, walls: &[String]) -> Vec<EngineeringWarning> {
        let Some(row) = &self.course.last else { return Vec::new() };
        let whole = ModelPlace::default();
        let mut found = Vec::new();
        let cure = "Look at positions, velocities, normals of walls and the end time in the model \
                    (`crumple check --html`); remove what is not needed";
        if has_contact && self.course.pairs == 0 && row.sum.energies.contact == 0.0 {
            let what = "contact has never acted: no node has touched a segment".into();
            found.push(self.warn(row, (WarningKind::UnusedContact, 0.0), what, &whole, cure));
        }
        let walls: Vec<&str> = walls
            .iter()
            .zip(&row.sum.wall_impulse)
            .filter(|(_, impulse)| **impulse == [0.0; 3])
            .map(|(name, _)| name.as_str())
            .collect();
        if !walls.is_empty() {
            let what = format!("no node has touched these walls: {}", walls.join(", "));
            found.push(self.warn(row, (WarningKind::UnusedWall, 0.0), what, &whole, cure));
        }
        found
    }

    /// Returns a warning of this row.
    fn warn(
        &self,
        row: &HistoryRow,
        (kind, value): (WarningKind, f64),
        what: String,
        at: &ModelPlace,
        cure: &str,
    ) -> EngineeringWarning {
        let time = row.sum.time;
        EngineeringWarning {
            kind,
            part: at.part.map_or(String::new(), |part| name(self.parts, part as usize)),
            cycle: row.sum.cycle,
            time,
            value,
            worst_time: time,
            what,
            place: described(at),
            cure: cure.into(),
        }
    }

    /// Returns a warning of the whole model, which is worst at a place.
    fn warn_of_all(
        &self,
        row: &HistoryRow,
        worst: (WarningKind, f64),
        what: String,
        at: &ModelPlace,
        cure: &str,
    ) -> EngineeringWarning {
        let whole = ModelPlace { part: None, ..*at };
        let mut warning = self.warn(row, worst, what, &whole, cure);
        if let Some(part) = at.part.filter(|_| !warning.place.is_empty()) {
            warning.place += &format!(" of part {}", name(self.parts, part as usize));
        }
        warning
    }

    fn hourglass(&self, row: &HistoryRow) -> Vec<EngineeringWarning> {
        let e = &row.sum.energies;
        let counts = |energy: f64| energy > NO_ENERGY * self.course.most;
        let mut worst = Peak::default();
        let of_part = |(part, share): (u32, &PartShare)| {
            worst.raise(share.most_hourglass.value, || share.most_hourglass.at);
            let at = ModelPlace { part: Some(part), ..share.most_hourglass.at };
            (at, share.hourglass, share.internal)
        };
        let parts: Vec<_> = (0..).zip(&row.sum.shares.parts).map(of_part).collect();
        let is_much = |hourglass: f64, internal: f64, limit: f64| {
            counts(hourglass) && hourglass > limit * internal
        };
        let judged = |hourglass: f64, internal: f64, limit: f64| {
            let ratio = if internal > 0.0 { hourglass / internal } else { 1.0 };
            let what = format!(
                "the hourglass energy is {hourglass:.3e}, {:.0} % of the internal energy; {:.0} % \
                 is usually acceptable",
                100.0 * ratio,
                100.0 * limit
            );
            ((WarningKind::Hourglass, ratio), what)
        };
        let [of_part, of_all] = MUCH_HOURGLASS;
        let much = parts
            .into_iter()
            .filter(|&(_, hourglass, internal)| is_much(hourglass, internal, of_part));
        let mut warned: Vec<_> = much
            .map(|(at, hourglass, internal)| {
                let (value, what) = judged(hourglass, internal, of_part);
                let part = at.part.and_then(|part| self.parts.get(part as usize));
                self.warn(row, value, what, &at, hourglass_cure(part))
            })
            .collect();
        if is_much(e.hourglass, e.internal, of_all) {
            let (value, what) = judged(e.hourglass, e.internal, of_all);
            let part = worst.at.part.and_then(|part| self.parts.get(part as usize));
            warned.push(self.warn_of_all(row, value, what, &worst.at, hourglass_cure(part)));
        }
        warned
    }

    fn contact_energy(&self, row: &HistoryRow) -> Option<EngineeringWarning> {
        let what = format!(
            "contact has created an energy of {:.3e}, {:.1} % of the largest energy so far: the \
             energy of contact is negative; the run stops at 10 %",
            row.sum.energies.contact,
            100.0 * row.created
        );
        let kind = (WarningKind::ContactEnergy, row.created);
        let at = &row.sum.deepest;
        (row.created > LITTLE_CREATED).then(|| self.warn_of_all(row, kind, what, at, CREATED_CURE))
    }

    fn contact_loss(&self, row: &HistoryRow) -> Option<EngineeringWarning> {
        let e = &row.sum.energies;
        let taken = e.friction - e.contact;
        let share = taken / self.course.most;
        let what = format!(
            "contact has taken an energy of {taken:.3e} without friction, {:.0} % of the largest \
             energy so far",
            100.0 * share
        );
        let (kind, at) = ((WarningKind::ContactLoss, share), &ModelPlace::default());
        (self.course.most > 0.0 && share > MUCH_TAKEN)
            .then(|| self.warn_of_all(row, kind, what, at, TAKEN_CURE))
    }

    /// Returns a warning of the work of one kind of friction, which is largest at a place.
    fn friction(
        &self,
        row: &HistoryRow,
        (kind, of, work): (WarningKind, &str, f64),
        at: &ModelPlace,
        cure: &str,
    ) -> Option<EngineeringWarning> {
        let share = work.abs() / self.course.most;
        let (limit, has) = match work > 0.0 {
            true => (LITTLE_CREATED, "created"),
            false => (MUCH_TAKEN, "dissipated"),
        };
        let what = format!(
            "friction {of} has {has} an energy of {:.3e}, {:.0} % of the largest energy so \
             far: results depend on the coefficient of friction",
            work.abs(),
            100.0 * share
        );
        (self.course.most > 0.0 && share > limit)
            .then(|| self.warn_of_all(row, (kind, share), what, at, cure))
    }

    fn step(&self, row: &HistoryRow) -> Option<EngineeringWarning> {
        let first = self.course.first.as_ref()?.sum.controlling_dt;
        let (now, at) = (row.sum.controlling_dt, &row.sum.controlling);
        let what = format!(
            "the stable step has fallen to {now:.3e}, {:.0} % of that of the start",
            100.0 * now / first
        );
        let cure = "Remesh the element or let its part fail at a large strain; \
                    time.mass_scaling_dt or time.subcycles allow a longer step";
        let kind = (WarningKind::TimeStep, now / first);
        let divided = 0.5_f64.powi(self.levels as i32);
        (first.is_finite() && now < SHORT_STEP * divided * first)
            .then(|| self.warn(row, kind, what, at, cure))
    }

    fn contact_step(&self, row: &HistoryRow) -> Option<EngineeringWarning> {
        let [contact, elements] = [row.sum.contact_dt, row.sum.controlling_dt];
        let what = format!(
            "the stable step of contact is {contact:.3e}, that of elements {elements:.3e}: in a \
             longer step, fast bodies could pass through others"
        );
        let cure = "Increase the contact thickness, or exclude fast fragments and thin foils from \
                    contact";
        let kind = (WarningKind::ContactStep, contact / elements);
        (contact < SHORT_CONTACT_STEP * elements)
            .then(|| self.warn(row, kind, what, &ModelPlace::default(), cure))
    }

    fn penetration(&self, row: &HistoryRow) -> Option<EngineeringWarning> {
        let depth = row.sum.penetration;
        let what = format!(
            "the largest penetration is {depth:.2} of the contact thickness; from 1 on a node may \
             pass through"
        );
        let cure = "Unless the mesh starts with this penetration, increase contact.sweeps or \
                    contact.penalty_scale, change contact.iteration, or reduce time.dt_max";
        let kind = (WarningKind::Penetration, depth);
        (depth > SUNK).then(|| self.warn(row, kind, what, &row.sum.deepest, cure))
    }

    fn inversion(&self, row: &HistoryRow) -> Option<EngineeringWarning> {
        let left = row.sum.corner_left;
        let state = if left < 0.0 { "has inverted" } else { "is about to invert" };
        let what = format!(
            "an element {state}: a corner has {:.0} % of its Jacobian at the start",
            100.0 * left
        );
        let cure = "Use a finer or more regular mesh there, a stiffer material curve at large \
                    strains, or part.inverted = \"delete\"";
        let kind = (WarningKind::Inversion, left);
        (left < FLAT).then(|| self.warn(row, kind, what, &row.sum.flattest, cure))
    }
}

/// Returns the cure of hourglass energy in a part, by its element.
fn hourglass_cure(part: Option<&Part>) -> &'static str {
    // Elements of a part that names none: solids have no thickness.
    let default = |part: &Part| match part.thickness {
        0.0 => "hexahedron",
        _ => "stabilised_quad",
    };
    let word = part.and_then(|part| part.parameters.get("hourglass"));
    let has_coefficient = matches!(word, Some(Setting::Word(word)) if word != "assumed_strain");
    match part.map(|part| part.element.as_deref().unwrap_or_else(|| default(part))) {
        Some("belytschko_tsay") => {
            "Set part.element = \"stabilised_quad\" or \"fully_integrated_quad\", or use a finer \
             mesh, or loads and supports on more nodes"
        }
        Some("stabilised_quad") => {
            "Use a finer mesh where the part bends or folds, loads and supports on more nodes, or \
             part.element = \"fully_integrated_quad\""
        }
        Some("hexahedron") if has_coefficient => {
            "Set part.hourglass = \"assumed_strain\", or use more elements over the depth that \
             bends, or loads and supports on more nodes"
        }
        Some("hexahedron") => {
            "Use more elements over the depth that bends, tetrahedra of ten nodes, or loads and \
             supports on more nodes"
        }
        _ => {
            "Use an element without hourglass modes or with physical stabilisation \
             (part.element), a finer mesh, or loads and supports on more nodes"
        }
    }
}

/// Mass that mass scaling adds to a part.
#[derive(Clone, Copy, Debug, Default)]
struct AddedMass {
    /// Mass without it [mass].
    mass: f64,
    /// Added mass [mass].
    added: f64,
    /// Largest factor on the density of an element, and the element.
    largest: (f64, ModelPlace),
}

/// Returns the warnings of mass scaling, before the mesh of the model is distributed.
pub fn of_added_mass(model: &Model) -> Vec<EngineeringWarning> {
    let (elements, mesh) = (&model.elements, &model.mesh);
    let mut of_parts = vec![AddedMass::default(); model.settings.parts.len()];
    for (i, element) in mesh.elements.iter().enumerate() {
        let part = &mut of_parts[elements.part[i] as usize];
        let added = elements.mass_with_scaling(i) - elements.mass[i];
        part.mass += elements.mass[i];
        part.added += added;
        if added > 0.0 && elements.mass_factor[i] > part.largest.0 {
            part.largest = (elements.mass_factor[i], centre(mesh, element, elements.part[i]));
        }
    }
    judged_mass(&model.settings.parts, &of_parts)
}

/// Returns the warning of edges that have passed through segments.
pub fn of_crossings(found: &EdgeCrossings) -> EngineeringWarning {
    let EdgeCrossings { cycle, time, count, edge, surface } = *found;
    EngineeringWarning {
        kind: WarningKind::Crossing,
        part: String::new(),
        cycle,
        time,
        value: count as f64,
        worst_time: time,
        what: format!(
            "an edge of element {edge} has passed through element {surface} between their nodes \
             ({count} such crossings on one worker); contact detects nodes against surfaces, and \
             free edges, folds and sharp edges against each other"
        ),
        place: format!("element {edge}"),
        cure: "Refine the mesh where an edge cuts into a face, and set contact.edges = true if it \
               is off"
            .into(),
    }
}

/// Returns the place of an element of a mesh.
fn centre(mesh: &Mesh, element: &MeshElement, part: u32) -> ModelPlace {
    let corners = element.corners();
    let mut x = [0.0; 3];
    for id in corners {
        if let Ok(at) = mesh.nodes.binary_search_by_key(id, |node| node.id) {
            (0..3).for_each(|c| x[c] += mesh.nodes[at].x[c] / corners.len() as f64);
        }
    }
    ModelPlace { element: Some(element.id), node: None, part: Some(part), x }
}

/// Returns the warnings of the parts and of the whole model. `of_parts` is in the order of `parts`.
fn judged_mass(parts: &[Part], of_parts: &[AddedMass]) -> Vec<EngineeringWarning> {
    let sum = |of: fn(&AddedMass) -> f64| of_parts.iter().map(of).sum::<f64>();
    let worst = of_parts.iter().map(|p| p.largest).max_by(|a, b| a.0.total_cmp(&b.0));
    let whole = AddedMass {
        mass: sum(|p| p.mass),
        added: sum(|p| p.added),
        largest: worst.unwrap_or_default(),
    };
    let parts_of = of_parts.iter().enumerate().map(|(i, p)| (name(parts, i), p, MUCH_MASS[0]));
    let all = parts_of.chain([(String::new(), &whole, MUCH_MASS[1])]);
    let is_much = |(_, p, limit): &(String, &AddedMass, f64)| {
        p.added > limit * p.mass && p.added > NO_ENERGY * whole.mass
    };
    let warned = all.filter(is_much).map(|(part, p, _)| EngineeringWarning {
        kind: WarningKind::AddedMass,
        part,
        cycle: 0,
        time: 0.0,
        value: p.added / p.mass,
        worst_time: 0.0,
        what: format!(
            "mass scaling adds a mass of {:.3e}, {:.1} % of the mass",
            p.added,
            100.0 * p.added / p.mass
        ),
        place: described(&p.largest.1),
        cure: "Use a smaller time.mass_scaling_dt, or a mesh without tiny elements".into(),
    });
    warned.collect()
}

/// Returns the name of a part, or its id without a name.
fn name(parts: &[Part], index: usize) -> String {
    parts.get(index).map_or(String::new(), |part| match part.name.is_empty() {
        true => part.id.to_string(),
        false => format!("`{}`", part.name),
    })
}

/// Returns the element or node of a place, with its coordinates.
fn described(at: &ModelPlace) -> String {
    let what = match (at.element, at.node) {
        (Some(element), _) => format!("element {element}"),
        (None, Some(node)) => format!("node {node}"),
        (None, None) => return String::new(),
    };
    let [x, y, z] = at.x;
    format!("{what} at ({x:.6}, {y:.6}, {z:.6})")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::ids::{ElemId, NodeId};
    use crumple_proto::report::HistoryPart;

    fn part(name: &str) -> Part {
        toml::from_str(&format!("id = 4\nname = \"{name}\"\nmaterial = \"m\"")).unwrap()
    }

    /// Returns the warnings of one row after a healthy first one.
    fn of(change: impl Fn(&mut HistoryRow)) -> Vec<EngineeringWarning> {
        let sum = HistoryPart {
            controlling_dt: 1.0,
            contact_dt: 1.0,
            corner_left: 1.0,
            ..HistoryPart::default()
        };
        let mut row = HistoryRow { sum, ..HistoryRow::default() };
        (row.sum.energies.internal, row.sum.energies.kinetic) = (10.0, 90.0);
        row.sum.shares.parts = vec![PartShare { internal: 5.0, ..PartShare::default() }; 2];
        let mut course = Course::default();
        (course.first, course.most) = (Some(row.clone()), 100.0);
        (row.sum.cycle, row.sum.time) = (30, 2.5);
        change(&mut row);
        course.last = Some(row);
        WatchedRow { parts: &[part("a"), part("b")], course: &course, levels: 0 }.warnings()
    }

    /// No part gets the advice to use the element that it has.
    #[test]
    fn the_cure_of_hourglass_energy_is_for_the_element() {
        let with = |element: Option<&str>, thickness: f64| {
            let part = Part { element: element.map(String::from), thickness, ..part("a") };
            hourglass_cure(Some(&part))
        };
        assert!(with(Some("belytschko_tsay"), 1.0).contains("stabilised_quad"));
        assert_eq!(with(None, 1.0), with(Some("stabilised_quad"), 1.0));
        assert!(!with(None, 1.0).contains("\"stabilised_quad\""));
        assert_eq!(with(None, 0.0), with(Some("hexahedron"), 0.0));
        assert!(!with(None, 0.0).contains("assumed_strain"), "it is the default");
        let mut solid = part("a");
        solid.parameters.insert("hourglass".into(), Setting::Word("viscous".into()));
        assert!(hourglass_cure(Some(&solid)).contains("assumed_strain"));
    }

    #[test]
    fn a_healthy_row_has_no_warning() {
        assert_eq!(of(|_| ()), []);
        let close = |row: &mut HistoryRow| {
            row.sum.shares.parts[1].hourglass = 0.49;
            row.sum.energies.hourglass = 0.49;
            (row.sum.energies.friction, row.sum.energies.wall_friction) = (-9.0, -9.0);
            row.sum.energies.contact = -18.0;
            (row.created, row.sum.penetration) = (0.009, 0.49);
            (row.sum.corner_left, row.sum.controlling_dt, row.sum.contact_dt) = (0.11, 0.21, 0.2);
        };
        assert_eq!(of(close), []);
    }

    /// One row beyond each limit, and what the warning names.
    #[test]
    fn each_limit_has_its_warning_with_part_place_and_cure() {
        type Change = fn(&mut HistoryRow);
        let at = |element| ModelPlace {
            element: Some(ElemId(element)),
            part: Some(1),
            x: [1.0, 2.0, 3.0],
            ..ModelPlace::default()
        };
        let table: [(WarningKind, Change, &str, &str); 10] = [
            (
                WarningKind::Hourglass,
                |r| r.sum.shares.parts[1].hourglass = 0.51,
                "`b`",
                "ten nodes",
            ),
            (WarningKind::Hourglass, |r| r.sum.energies.hourglass = 0.51, "", "more nodes"),
            (WarningKind::ContactEnergy, |r| r.created = 0.011, "", "contact.sweeps"),
            (WarningKind::ContactLoss, |r| r.sum.energies.contact = -11.0, "", "finer mesh"),
            (WarningKind::Friction, |r| r.sum.energies.friction = -11.0, "", "contact.friction"),
            (WarningKind::Friction, |r| r.sum.energies.friction = 1.1, "", "contact.friction"),
            (
                WarningKind::WallFriction,
                |r| r.sum.energies.wall_friction = -11.0,
                "",
                "wall.friction",
            ),
            (
                WarningKind::WallFriction,
                |r| r.sum.energies.wall_friction = 1.1,
                "",
                "wall.friction",
            ),
            (WarningKind::ContactStep, |r| r.sum.contact_dt = 0.49, "", "contact thickness"),
            (WarningKind::Penetration, |r| r.sum.penetration = 0.51, "", "contact.sweeps"),
        ];
        for (kind, change, part, cure) in table {
            let found = of(change);
            assert_eq!(found.len(), 1, "{kind:?}: {found:?}");
            assert_eq!((found[0].kind, &found[0].part[..]), (kind, part));
            assert_eq!((found[0].cycle, found[0].time), (30, 2.5));
            assert!(found[0].line().contains(cure), "{}", found[0].line());
        }
        let short = of(|r| (r.sum.controlling_dt, r.sum.controlling) = (0.19, at(7)));
        let short: Vec<_> = short.iter().filter(|w| w.kind == WarningKind::TimeStep).collect();
        assert_eq!((short.len(), &short[0].part[..]), (1, "`b`"));
        assert!(short[0].line().contains("element 7 at (1.000000, 2.0"), "{}", short[0].line());
        let flat = of(|r| (r.sum.corner_left, r.sum.flattest) = (0.09, at(8)));
        assert_eq!((flat.len(), flat[0].kind), (1, WarningKind::Inversion));
        let deep = of(|r| {
            r.sum.penetration = 0.7;
            r.sum.deepest = ModelPlace { element: None, node: Some(NodeId(5)), ..at(0) };
        });
        assert!(deep[0].place.starts_with("node 5 at "), "{}", deep[0].place);
        let peak = Peak { value: 0.2, at: at(9) };
        let distorted = of(|r| {
            (r.sum.shares.parts[1].hourglass, r.sum.energies.hourglass) = (0.51, 0.51);
            r.sum.shares.parts[1].most_hourglass = peak;
        });
        let here = "element 9 at (1.000000, 2.000000, 3.000000)";
        let places: Vec<&str> = distorted.iter().map(|w| &w.place[..]).collect();
        assert_eq!(places, [here, &format!("{here} of part `b`")]);
        let rubbed = of(|r| (r.sum.energies.friction, r.sum.sliding) = (-11.0, peak));
        assert_eq!(rubbed[0].place, format!("{here} of part `b`"));
        let created = of(|r| (r.created, r.sum.deepest) = (0.011, at(9)));
        assert_eq!((&created[0].part[..], &created[0].place), ("", &rubbed[0].place));
    }

    /// Contact without a pair and without work, and walls without an impulse, are named once the
    /// run is complete; one touch is enough for none.
    #[test]
    fn what_a_run_never_used_is_named() {
        let of = |change: fn(&mut HistoryRow), pairs: u64, has_contact: bool| {
            let mut row = HistoryRow::default();
            row.sum.wall_impulse = vec![[0.0, 0.0, 1.0], [0.0; 3], [0.0; 3]];
            change(&mut row);
            let names = ["floor", "side", "roof"].map(String::from);
            let mut course = Course::default();
            (course.last, course.pairs) = (Some(row), pairs);
            let found =
                WatchedRow { parts: &[], course: &course, levels: 0 }.unused(has_contact, &names);
            found.iter().map(EngineeringWarning::line).collect::<Vec<_>>()
        };
        let found = of(|_| (), 0, true);
        assert_eq!(found.len(), 2, "{found:?}");
        assert!(
            found[0].contains("never acted") && found[1].contains("walls: side, roof."),
            "{found:?}"
        );
        let all_walls = |row: &mut HistoryRow| row.sum.wall_impulse = vec![[0.0, -1.0, 0.0]];
        assert_eq!(of(all_walls, 1, true), Vec::<String>::new());
        assert_eq!(of(all_walls, 0, false), Vec::<String>::new());
        let worked = |row: &mut HistoryRow| {
            row.sum.wall_impulse = Vec::new();
            row.sum.energies.contact = -1e-9;
        };
        assert_eq!(of(worked, 0, true), Vec::<String>::new());
    }

    #[test]
    fn hourglass_of_a_part_without_energy_does_not_count() {
        assert_eq!(
            of(|row| row.sum.shares.parts[0] =
                PartShare { hourglass: 0.09, internal: 0.01, ..PartShare::default() }),
            []
        );
    }

    #[test]
    fn a_corner_below_zero_has_inverted() {
        let line = |left: f64| of(|row| row.sum.corner_left = left)[0].line();
        let close = line(0.09);
        assert!(close.contains("is about to invert: a corner has 9 %"), "{close}");
        let beyond = line(-0.15);
        assert!(beyond.contains("has inverted: a corner has -15 %"), "{beyond}");
        assert_eq!(WarningKind::ContactEnergy.name(), "contact_energy");
    }

    #[test]
    fn crossings_name_both_elements_and_keep_the_largest_count() {
        let of = |count| EdgeCrossings {
            cycle: 8,
            time: 0.5,
            count,
            edge: ElemId(3),
            surface: ElemId(7),
        };
        let mut all = Vec::new();
        assert_eq!(merge(&mut all, vec![of_crossings(&of(2))]), 0);
        assert_eq!(merge(&mut all, vec![of_crossings(&of(5))]), 1, "of another worker");
        let line = all[0].line();
        let words = "an edge of element 3 has passed through element 7";
        assert!(all.len() == 1 && line.contains(words) && line.contains("(5 such"), "{line}");
        assert_eq!(all[0].kind.name(), "crossing");
    }

    #[test]
    fn a_warning_is_given_once_and_keeps_its_worst_value() {
        let mut all = Vec::new();
        let deep = |depth: f64| of(|row| row.sum.penetration = depth);
        assert_eq!((merge(&mut all, deep(0.6)), all.len()), (0, 1));
        let mut later = deep(0.9);
        (later[0].time, later[0].worst_time) = (3.0, 3.0);
        assert_eq!((merge(&mut all, later), all.len()), (1, 1));
        assert_eq!((all[0].time, all[0].value, all[0].worst_time), (2.5, 0.9, 3.0));
        assert_eq!(merge(&mut all, deep(0.7)), 1);
        assert_eq!(all[0].value, 0.9);
        assert!(all[0].line().contains("since time 2.5"), "{}", all[0].line());
    }

    #[test]
    fn added_mass_is_judged_by_part_and_in_total() {
        let of = |added: [f64; 2]| {
            let parts = added.map(|added| AddedMass { mass: 10.0, added, ..Default::default() });
            judged_mass(&[part("a"), part("b")], &parts)
        };
        assert_eq!(of([0.9, 0.05]), []);
        let found = of([1.1, 0.0]);
        let parts: Vec<&str> = found.iter().map(|w| &w.part[..]).collect();
        assert_eq!(parts, ["`a`", ""]);
        assert!(found[0].line().contains("11.0 %"), "{}", found[0].line());
    }
}
