//! Converts the cards of `*PART_INERTIA`: mass properties and initial motion of rigid parts.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
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

    /// Adds the inertia of a part to its body, if it is the only part of that body.
    pub(super) fn put_inertia(&mut self, part: i64, alone: bool, table: &mut JobTable) {
        let Some(given) = self.parts.get(&part).and_then(|p| p.inertia) else { return };
        if !alone {
            let message = format!("part {part}: *PART_INERTIA of a part that is joined to others");
            return self.unsupported(given.place, message, "*PART_INERTIA".into());
        }
        table.put("mass", given.place, given.mass);
        table.put("inertia", given.place, given.tensor);
        let centre = self.centre_of(part);
        let away = (0..3).map(|c| (centre[c] - given.centre[c]).powi(2)).sum::<f64>().sqrt();
        let [xx, yy, zz, ..] = given.tensor;
        let radius = (0.5 * (xx + yy + zz) / given.mass).sqrt();
        if given.mass > 0.0 && away > SAME_CENTRE * radius {
            let message = format!(
                "part {part}: its centre of mass is {:?} in the deck, but that of its elements is \
                 {centre:?}",
                given.centre
            );
            let help = "the body has the centre of its elements: add masses that move it";
            self.trouble.warning(given.place, message, help);
        }
        self.map(
            format!("part {part}"),
            format!("inertia: mass {}", given.mass),
            "mass and inertia of the rigid body",
        );
        let [v, w] = given.motion;
        if given.motion != [[0.0; 3]; 2] {
            let set = self.nodes_of_parts(&[part]);
            let spin = (w != [0.0; 3]).then_some((w, centre));
            self.initial(given.place, Some(set), v, spin);
        }
    }
}
