//! Converts the cards of `*PART_INERTIA`: mass properties and initial motion of rigid parts.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::centre;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;

/// Largest distance between the given centre of mass and that of the elements that is round-off,
/// as a fraction of the radius of gyration.
const SAME_CENTRE: f64 = 0.01;

/// Mass properties of a rigid part.
#[derive(Clone, Copy, Debug)]
pub struct DeckInertia {
    /// Mass [mass].
    mass: f64,
    /// Components xx, yy, zz, xy, yz, zx about the centre [mass length^2].
    tensor: [f64; 6],
    /// Centre of mass [length].
    centre: [f64; 3],
    /// Velocity [length/time] and rotational velocity [1/time] at the start.
    motion: [[f64; 3]; 2],
    place: Place,
}

impl DeckConverter {
    /// Reads the cards of inertia of a part; `None` for a part without them.
    pub(super) fn inertia_card(&mut self, record: &CardRecord) -> Option<DeckInertia> {
        record.line("tm")?;
        if record.integer("ircs") != 0 {
            self.unsupported_card(record, "ircs", "inertia about local axes");
            return None;
        }
        let number = |field: &str| record.real(field);
        let mut centre = ["xc", "yc", "zc"].map(number);
        if let Ok(node @ 1..) = u64::try_from(record.integer("nodeid")) {
            match self.rows.at(NodeId(node)) {
                Some(x) => centre = x,
                None => self.missing(record.place("nodeid"), "node", node as i64, &[]),
            }
        }
        Some(DeckInertia {
            mass: number("tm"),
            tensor: ["ixx", "iyy", "izz", "ixy", "iyz", "ixz"].map(number),
            centre,
            motion: [["vtx", "vty", "vtz"].map(number), ["vrx", "vry", "vrz"].map(number)],
            place: record.place("tm"),
        })
    }

    /// Adds the inertia of a part to its body, if it is the only part of that body. `extra` is the
    /// number of nodes of other parts in the body.
    pub(super) fn put_inertia(
        &mut self,
        part: i64,
        alone: bool,
        extra: usize,
        table: &mut JobTable,
    ) {
        let Some(given) = self.parts.get(&part).and_then(|p| p.inertia) else { return };
        if !alone {
            let message = format!("part {part}: *PART_INERTIA of a part that is joined to others");
            return self.unsupported(given.place, message, "*PART_INERTIA".into());
        }
        if extra > 0 {
            let message = format!(
                "part {part}: masses of nodes of other parts in the body ({extra}) are added to tm"
            );
            let help = "the original counts tm for all of them; a body whose motion is prescribed \
                        does not depend on it";
            self.trouble.warning(given.place, message, help);
        }
        table.put("mass", given.place, given.mass);
        table.put("inertia", given.place, given.tensor);
        let centre = self.centre_of(part);
        let away = (0..3).map(|c| (centre[c] - given.centre[c]).powi(2)).sum::<f64>().sqrt();
        let [xx, yy, zz, ..] = given.tensor;
        let radius = (0.5 * (xx + yy + zz) / given.mass).sqrt();
        let moves = given.mass > 0.0 && away > SAME_CENTRE * radius;
        let can_move = moves && self.holds_centre(part, given.centre);
        if can_move {
            table.put("centre", given.place, given.centre);
        } else if moves {
            let message = format!(
                "part {part}: its centre of mass is {:?} in the deck, which is not inside of its \
                 elements; that of the elements is {centre:?}",
                given.centre
            );
            let help = "the body has the centre of its elements: add masses that move it";
            self.trouble.warning(given.place, message, help);
        }
        self.map(
            format!("part {part}"),
            format!("inertia: mass {}", given.mass),
            if can_move {
                "mass, centre and inertia of the rigid body"
            } else {
                "mass and inertia of the rigid body"
            },
        );
        let [v, w] = given.motion;
        if given.motion != [[0.0; 3]; 2] {
            let set = self.nodes_of_parts(&[part]);
            let spin = (w != [0.0; 3]).then_some((w, if can_move { given.centre } else { centre }));
            self.initial(given.place, Some(set), v, spin);
        }
    }

    /// Gives the nodes of other parts, in a set, the motion of a part without elements, whose mass
    /// and inertia have no carrier.
    pub(super) fn bare_inertia(&mut self, part: i64, set: &str) {
        let Some(given) = self.parts.get(&part).and_then(|p| p.inertia) else { return };
        let message = format!(
            "part {part} has no elements: its body has the mass, centre and inertia of its nodes, \
             not those of *PART_INERTIA"
        );
        let help = "a body whose motion is prescribed does not depend on them; else give the part \
                    elements, or its nodes masses by *ELEMENT_MASS";
        self.trouble.warning(given.place, message, help);
        let [v, w] = given.motion;
        if given.motion != [[0.0; 3]; 2] {
            let spin = (w != [0.0; 3]).then_some((w, given.centre));
            self.initial(given.place, Some(set.to_string()), v, spin);
        }
    }

    /// Returns true if masses of the elements of a part can have this centre.
    fn holds_centre(&mut self, part: i64, centre: [f64; 3]) -> bool {
        let (masses, points) = self.middles_of(part);
        centre::factors(&masses, &points, centre).is_some()
    }
}
