//! Access to the worker's tables of laws and elements, and construction of the elements of a job.
//!
//! This module does not know the content of a law. The worker checks the parameters of its laws.

use super::validate::JobProblems;
use crumple_proto::job::Part;
use crumple_proto::mesh::Shape;
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_worker::contact::diagnostics::initial_penetration::{InitialPenetrations, Penetration};
use crumple_worker::contact::enforce::{CONTACT_LAWS, LawRow};
use crumple_worker::contact::search::SEARCHES;
use crumple_worker::fem::elements::{
    COHESIVE, ELEMENTS, Element, ElementEntry, THICK_SHELL, build_block, formulation,
};
use crumple_worker::fem::materials;
use crumple_worker::parameter::{Form, ParameterRow};

/// Returns the names of the contact laws.
pub fn contact_laws() -> Vec<&'static str> {
    CONTACT_LAWS.iter().map(|law| law.name).collect()
}

/// Returns the contact law with this name, if there is one.
pub fn contact_law(name: &str) -> Option<&'static LawRow> {
    CONTACT_LAWS.iter().find(|law| law.name == name)
}

/// Returns the keys of contact laws, each once, with the names of the laws that use it.
pub fn contact_keys() -> Vec<(&'static ParameterRow, Vec<&'static str>)> {
    let mut keys: Vec<(&ParameterRow, Vec<&str>)> = Vec::new();
    for law in CONTACT_LAWS.iter() {
        for row in law.keys() {
            match keys.iter_mut().find(|(known, _)| known.key == row.key) {
                Some((_, laws)) => laws.push(law.name),
                None => keys.push((row, vec![law.name])),
            }
        }
    }
    keys
}

/// A key of elements, with the formulations that use it and their rows of it.
pub struct ElementKey {
    /// Key in `[[part]]`.
    pub key: &'static str,
    /// Formulations, and their rows.
    pub rows: Vec<(&'static ElementEntry, &'static ParameterRow)>,
}

impl ElementKey {
    /// Returns the names of the formulations.
    pub fn users(&self) -> Vec<&'static str> {
        self.rows.iter().map(|(element, _)| element.name).collect()
    }

    /// Returns the words that any formulation permits, if the values are words.
    pub fn words(&self) -> Vec<&'static str> {
        let mut words = Vec::new();
        for (_, row) in &self.rows {
            if let Form::Word(own) = row.form {
                words.extend(own.iter().filter(|word| !words.contains(*word)).collect::<Vec<_>>());
            }
        }
        words
    }
}

/// Returns the keys of elements, each once.
pub fn element_keys() -> Vec<ElementKey> {
    let mut keys: Vec<ElementKey> = Vec::new();
    for element in ELEMENTS {
        for row in element.keys() {
            match keys.iter_mut().find(|known| known.key == row.key) {
                Some(known) => known.rows.push((element, row)),
                None => keys.push(ElementKey { key: row.key, rows: vec![(element, row)] }),
            }
        }
    }
    keys
}

/// Returns the names of the global searches.
pub fn searches() -> Vec<&'static str> {
    SEARCHES.iter().map(|search| search.name).collect()
}

/// True for each [`Shape`] of which a part has elements.
pub type Used = [bool; Shape::ALL.len()];

/// The elements of every part, as the worker builds them.
pub struct BuiltElements {
    parts: Vec<[Option<Box<dyn Element>>; Shape::ALL.len()]>,
}

impl BuiltElements {
    /// Builds the elements of all parts for the shapes in use (`used` per part, by [`Shape`]).
    /// For parts without elements it builds those that they could have, so that their parameters
    /// are checked too. `order[i]` is the index in the job of part `i` of `settings`.
    pub fn build(
        settings: &Settings,
        order: &[usize],
        used: &[Used],
        findings: &mut JobProblems,
    ) -> Self {
        let mut problems: Vec<Problem> = Vec::new();
        let mut parts = Vec::with_capacity(order.len());
        for (index, &place) in order.iter().enumerate() {
            let mut build = |shape: Shape| match build_block(settings, index, shape) {
                Ok(element) => Some(element),
                Err(found) => {
                    for mut problem in found {
                        if let Some(rest) = problem.path.strip_prefix(&format!("part.{index}.")) {
                            problem.path = format!("part.{place}.{rest}");
                        }
                        problems.push(problem);
                    }
                    None
                }
            };
            let idle = match &settings.parts[index] {
                Part { spring: Some(_), .. }
                | Part { belt: Some(_), .. }
                | Part { discrete_beam: Some(_), .. } => Shape::Line2,
                Part { beam: Some(_), .. } => Shape::Beam2,
                Part { truss: Some(_), .. } => Shape::Truss2,
                Part { particles: Some(_), .. } => Shape::Point1,
                Part { element: Some(name), .. } if name == "hexahedron" => Shape::Hex8,
                Part { element: Some(name), .. } if name == THICK_SHELL => Shape::Hex8,
                Part { element: Some(name), .. } if name == COHESIVE => Shape::Cohesive8,
                Part { element: Some(name), .. } if name == "tetrahedron" => Shape::Tet4,
                Part { element: Some(name), .. } if name == "quadratic_tetrahedron" => Shape::Tet10,
                Part { thickness: 0.0, element: None, .. } => Shape::Hex8,
                _ => Shape::Quad4,
            };
            let none = !used[index].contains(&true);
            parts.push(Shape::ALL.map(|shape| {
                let wanted = used[index][shape as usize] || none && shape == idle;
                if wanted { build(shape) } else { None }
            }));
        }
        for (index, material) in settings.materials.iter().enumerate() {
            for mut problem in materials::elastic_of(material).err().unwrap_or_default() {
                problem.path = format!("material.{index}.{}", problem.path);
                problems.push(problem);
            }
        }
        // Each part that uses a material repeats the checks of the material.
        let mut reported: Vec<(String, String)> = Vec::new();
        for problem in problems {
            let key = (problem.path.clone(), problem.message.clone());
            if !reported.contains(&key) {
                reported.push(key);
                findings.add(problem);
            }
        }
        BuiltElements { parts }
    }

    /// Returns the names of the formulations of a part with the given index in the settings.
    pub fn names(&self, part: &Part, index: usize) -> Vec<&'static str> {
        let shapes = Shape::ALL.into_iter();
        shapes
            .filter(|&s| self.element(index, s).is_some())
            .filter_map(|s| formulation(part, s).map(|row| row.name))
            .collect()
    }

    /// Returns the element of a part and shape, if the job has one.
    pub fn element(&self, part: usize, shape: Shape) -> Option<&dyn Element> {
        self.parts[part][shape as usize].as_deref()
    }
}

/// Warns if contact uses a reduced thickness for shells or beams.
pub fn thinned(settings: &Settings, initial: &InitialPenetrations) -> Option<Problem> {
    let (count, least) = initial.thinned?;
    let limit = settings.contact.as_ref()?.thickness_limit;
    let message = format!(
        "{count} shells or beams are thicker than {limit} times their shortest side: contact \
         reduces their thickness, at worst to {:.0} % of it",
        100.0 * least
    );
    let help = "use elements at least as long as the sheet or beam is thick, or set \
                contact.thickness_limit (0 for no limit)";
    Some(Problem::warning("contact.thickness_limit", message, help))
}

/// Warns if nodes start inside the thickness of shells, or inside solids, that are in contact
/// with them.
pub fn penetrations(initial: &InitialPenetrations) -> Vec<Problem> {
    let (unseen, seen): (Vec<_>, Vec<_>) =
        initial.penetrations.iter().copied().partition(|p| p.unseen);
    let warn = |found: &[Penetration], what: &str, otherwise: &str| {
        let deepest = found.iter().max_by(|a, b| a.depth.total_cmp(&b.depth))?;
        let Penetration { node, depth, elem, normal: [x, y, z], at_least, .. } = deepest;
        let count = found.len();
        let (least, side) = if *at_least {
            (
                "at least ",
                "; it is near the middle of this element: if its part belongs on the other side, \
                 move it the other way, and farther",
            )
        } else {
            ("", "")
        };
        let message = format!(
            "{count} nodes start inside {what}; the deepest is node {node}, {least}{depth:.3e} \
             into element {elem}, along the normal ({x:.3}, {y:.3}, {z:.3})"
        );
        let help = format!(
            "move the part of this node by {least}{depth:.3e} along this normal{side}; {otherwise}"
        );
        Some(Problem::warning("contact", message, help))
    };
    let kept = "otherwise these penetrations are tolerated without force, and contact acts from \
                that depth on; a node in the middle of a shell has no contact with it until it has \
                left the middle";
    let never = "otherwise the parts pass through each other there";
    let seen = warn(&seen, "the thickness of shells, beams, or other solids", kept);
    let unseen = warn(&unseen, "other solids, too deep for contact to detect", never);
    seen.into_iter().chain(unseen).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::ids::{ElemId, NodeId};

    /// The message says where the deepest node is, how deep at least, and how to move it out.
    #[test]
    fn initial_penetrations_have_a_direction_and_a_distance() {
        let at = |node, depth, at_least| Penetration {
            node: NodeId(node),
            elem: ElemId(7),
            depth,
            normal: [0.0, 0.0, -1.0],
            at_least,
            unseen: false,
        };
        let text = |penetrations: Vec<Penetration>| {
            let found = InitialPenetrations { penetrations, thinned: None };
            penetrations_text(&found)
        };
        let plain = text(vec![at(3, 0.25, false), at(4, 0.125, false)]);
        assert!(plain.contains("node 3, 2.500e-1 into element 7, along the normal"), "{plain}");
        assert!(plain.contains("by 2.500e-1 along this normal; otherwise"), "{plain}");
        let middle = text(vec![at(3, 0.75, true), at(4, 0.125, false)]);
        assert!(middle.contains("node 3, at least 7.500e-1 into"), "{middle}");
        assert!(middle.contains("move it the other way"), "{middle}");
    }

    fn penetrations_text(found: &InitialPenetrations) -> String {
        penetrations(found).iter().map(ToString::to_string).collect()
    }
}
