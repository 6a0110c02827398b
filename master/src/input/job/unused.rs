//! Warns of settings in a job that no feature of the job uses, because the user expects an
//! effect.

use super::laws::{ElementKey, Used, contact_keys, element_keys};
use super::tree::{Node, NodeContent, Place};
use super::validate::JobProblems;
use crumple_proto::job::{ContactInput, Job, Part};
use crumple_proto::mesh::Shape;
use crumple_proto::problem::Problem;
use crumple_worker::fem::elements::formulation;
use crumple_worker::fem::materials::{DIRECTION, LAWS};

/// Keys of a part that only its shells use.
const OF_SHELLS: [&str; 4] =
    ["thickness", "offset", "contact_thickness", "contact_thickness_scale"];

/// Returns the remedy if no element of a part uses a key.
fn reason_without_effect(key: &ElementKey, part: &Part, used: &Used) -> Option<String> {
    let shapes = Shape::ALL.into_iter().filter(|&shape| used[shape as usize]);
    let elements = shapes.filter_map(|shape| formulation(part, shape));
    let mut reason = None;
    for element in elements.filter(|e| e.keys().any(|row| row.key == key.key)) {
        let idle = (element.idle)(&element.values(part));
        let (_, why) = idle.iter().find(|(idle, _)| *idle == key.key)?;
        reason = Some(format!("remove it: {why}"));
    }
    Some(reason.unwrap_or_else(|| format!("remove it: it is for {}", key.users().join(", "))))
}

/// Reports unused settings. `used` are the shapes of each part of the job. Settings of a deck are
/// not checked here, because the deck reader reports them.
pub fn check(tree: &Node, job: &Job, used: &[Used], findings: &mut JobProblems) {
    let written = |table: &Node, path: &str, key: &str| {
        table.get(key).is_some()
            && !matches!(tree.locate(&format!("{path}.{key}")), Place::Deck { .. })
    };
    if let (Some(table), Some(contact)) = (tree.get("contact"), &job.contact) {
        let used_by = |one: &ContactInput, laws: &[&str]| laws.contains(&one.law.as_str());
        let mut warn = |path: String, key: &str, law: &str, laws: &[&str]| {
            let message = format!("law = \"{law}\" does not use `{key}`");
            findings.add(Problem::warning(
                path,
                message,
                format!("remove it: it belongs to law {}", laws.join(" and ")),
            ));
        };
        let all: Vec<ContactInput> = contact.each().collect();
        for (row, laws) in &contact_keys() {
            let key = row.key;
            // Interfaces inherit this value.
            if written(table, "contact", key) && !all.iter().any(|one| used_by(one, laws)) {
                warn(format!("contact.{key}"), key, &contact.law, laws);
            }
            let Some(NodeContent::Array(interfaces)) =
                table.get("interface").map(|node| &node.kind)
            else {
                continue;
            };
            for (i, (table, one)) in interfaces.iter().zip(&all[1..]).enumerate() {
                let path = format!("contact.interface.{i}");
                if written(table, &path, key) && !used_by(one, laws) {
                    warn(format!("{path}.{key}"), key, &one.law, laws);
                }
            }
        }
    }
    let Some(NodeContent::Array(parts)) = tree.get("part").map(|node| &node.kind) else { return };
    for (index, ((table, part), used)) in parts.iter().zip(&job.part).zip(used).enumerate() {
        // Parts without elements are reported elsewhere.
        if !used.contains(&true) {
            continue;
        }
        let path = format!("part.{index}");
        if !Shape::ALL.into_iter().any(|shape| used[shape as usize] && shape.is_shell()) {
            for key in OF_SHELLS.into_iter().filter(|key| written(table, &path, key)) {
                let message = format!("nothing in part {} uses `{key}`", part.id);
                let help = "remove it: it is for shells";
                findings.add(Problem::warning(format!("{path}.{key}"), message, help));
            }
        }
        let has_axes = |name: &&str| {
            let material = job.material.iter().find(|m| m.name == **name);
            let law = material.and_then(|m| LAWS.iter().find(|law| law.name == m.law));
            // Unknown materials are reported elsewhere.
            law.is_none_or(|law| law.parameters.iter().any(|row| row.key == DIRECTION.key))
        };
        let turned = [
            ("angles", part.angles.iter().any(|angle| *angle != 0.0)),
            ("layer", part.layer.iter().any(|layer| layer.angle != 0.0)),
        ];
        for (key, _) in turned.into_iter().filter(|(key, any)| *any && written(table, &path, key)) {
            if !part.materials().iter().any(has_axes) {
                let message =
                    format!("no material of part {} has axes that angles could turn", part.id);
                let help = "remove the angles, or use a law with `direction`, such as orthotropic";
                findings.add(Problem::warning(format!("{path}.{key}"), message, help));
            }
        }
        if !part.layer.is_empty() && written(table, &path, "points") {
            let message = format!("part {} has layers and does not use `points`", part.id);
            let help = "remove it: each layer has its `points`";
            findings.add(Problem::warning(format!("{path}.points"), message, help));
        }
        for element_key in element_keys().iter().filter(|k| written(table, &path, k.key)) {
            let key = element_key.key;
            if let Some(help) = reason_without_effect(element_key, part, used) {
                let message = format!("nothing in part {} uses `{key}`", part.id);
                findings.add(Problem::warning(format!("{path}.{key}"), message, help));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use crate::input::job::read_text;
    use crumple_cases::jobs;

    /// Returns the warnings for the colliding bars (shells with 2 points) with some settings.
    fn warned(sets: &[&str]) -> Vec<String> {
        warned_in(jobs::BARS, sets)
    }

    fn warned_in(text: &str, sets: &[&str]) -> Vec<String> {
        let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
        let model = read_text("job.toml".into(), text.to_string(), &sets)
            .unwrap_or_else(|report| panic!("{report}"));
        model
            .warnings
            .iter()
            .filter(|w| w.message.contains("use"))
            .map(|w| w.path.clone())
            .collect()
    }

    /// Angles turn nothing if no material has axes, and layers have their own points.
    #[test]
    fn angles_without_axes_are_reported() {
        let tube = jobs::COMPOSITE_TUBE;
        let found = |text: &str| {
            let model = read_text("job.toml".into(), text.to_string(), &[]);
            let model = model.unwrap_or_else(|report| panic!("{report}"));
            let paths = model.warnings.iter().map(|w| w.path.clone());
            paths.filter(|path| path.starts_with("part.")).collect::<Vec<_>>()
        };
        assert_eq!(found(tube), [""; 0]);
        let (from, to) = (tube.find("[[material]]").unwrap(), tube.find("[[part]]").unwrap());
        let steel = "[[material]]\nname = \"ply\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
                     youngs_modulus = 210.0\npoisson = 0.3\n";
        let of_steel = format!("{}{steel}{}", &tube[..from], &tube[to..]);
        let of_steel = of_steel.replace("layer = [", "points = 3\nlayer = [");
        assert_eq!(found(&of_steel), ["part.0.layer", "part.0.points"]);
    }

    /// Solids have no thickness, so a thickness of theirs is reported.
    #[test]
    fn keys_of_shells_are_reported_for_solids() {
        let block = jobs::BLOCK;
        assert_eq!(warned_in(block, &[]), [""; 0]);
        assert_eq!(
            warned_in(block, &["part.block.thickness=1.0", "part.block.offset=0.5"]),
            ["part.0.thickness", "part.0.offset"]
        );
    }

    #[test]
    fn only_unused_keys_are_reported() {
        let plain = ["part.one.element=belytschko_tsay", "part.one.warping=true"];
        assert_eq!(
            warned(&[&["contact.law=penalty", "contact.penalty_scale=0.2"][..], &plain].concat()),
            [""; 0]
        );
        assert_eq!(
            warned(&["part.one.warping=true"]),
            ["part.0.warping"],
            "the default has no such terms"
        );
        assert_eq!(warned(&["contact.partition=0.3", "contact.sweeps=5"]), ["contact.partition"]);
        assert_eq!(
            warned(&["contact.law=kinematic", "contact.iteration=split"]),
            ["contact.iteration"]
        );
        let stabilised = ["part.one.element=stabilised_quad", "part.one.hourglass=viscous"];
        assert_eq!(warned(&stabilised), ["part.0.hourglass"]);
        let stabilised = ["part.one.element=stabilised_quad", "part.one.warping=true"];
        assert_eq!(warned(&stabilised), ["part.0.warping"]);
        assert_eq!(warned(&["part.one.bulk_viscosity=[0.1, 1.5]"]), ["part.0.bulk_viscosity"]);
        let full = ["part.one.element=fully_integrated_quad", "part.one.hourglass_coefficient=0.1"];
        assert_eq!(warned(&full), ["part.0.hourglass_coefficient"]);
    }
}
