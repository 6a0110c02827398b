//! Parts of shells with layers: their thickness, and the limits on the layers.

use super::validate::JobProblems;
use crumple_proto::job::{Job, LayerInput, Part};
use crumple_proto::problem::Problem;
use crumple_worker::fem::materials::{MAX_LAYER_POINTS, MAX_POINTS};

/// Checks the layers of all parts. Gives each such part the thickness of its layers and, if it has
/// no material, that of its thickest layer, which stands for the part where one is needed.
pub fn resolve(job: &mut Job, findings: &mut JobProblems) {
    for (index, part) in job.part.iter_mut().enumerate().filter(|(_, part)| !part.layer.is_empty())
    {
        if !check(index, part, findings) {
            // Valid values take the place of faulty ones, so that the rest of the job is checked.
            part.layer.truncate(MAX_LAYER_POINTS);
            for layer in &mut part.layer {
                let thickness = Some(layer.thickness).filter(|t| *t > 0.0 && t.is_finite());
                (layer.points, layer.thickness) = (1, thickness.unwrap_or(1.0));
            }
        }
        part.thickness = part.layer.iter().map(|layer| layer.thickness).sum();
        if part.material.is_empty() {
            let named = part.layer.iter().filter(|layer| !layer.material.is_empty());
            let thickest = named.reduce(|a, b| if b.thickness > a.thickness { b } else { a });
            part.material = thickest.map_or(String::new(), |layer| layer.material.clone());
        }
    }
}

/// Returns true if the layers have valid points and thicknesses.
fn check(index: usize, part: &Part, findings: &mut JobProblems) -> bool {
    let of = if part.name.is_empty() { part.id.to_string() } else { part.name.clone() };
    let mut wrong = |key: &str, what: String, help: &str| {
        let path = format!("part.{index}.{key}");
        findings.add(Problem::error(path, format!("part {of}: {what}"), help));
    };
    if part.thickness != 0.0 {
        let help = "remove it: the thickness is that of the layers";
        wrong("thickness", "it has both layers and a thickness".into(), help);
    }
    for (k, LayerInput { thickness, material, angle, points }) in part.layer.iter().enumerate() {
        let layer = k + 1;
        let key = |key: &str| format!("layer.{k}.{key}");
        if !(*thickness > 0.0 && thickness.is_finite()) {
            let help = "it has to be above 0";
            wrong(&key("thickness"), format!("layer {layer} has the thickness {thickness}"), help);
        }
        if !angle.is_finite() {
            let help = "give a number of degrees";
            wrong(&key("angle"), format!("layer {layer} has the angle {angle}"), help);
        }
        if !(1..=MAX_POINTS).contains(points) {
            let help = "it has to be from 1 to 10";
            wrong(&key("points"), format!("layer {layer} has {points} points"), help);
        }
        if material.is_empty() && part.material.is_empty() {
            let help = "give the layer or the part a `material`";
            wrong(&key("material"), format!("layer {layer} has no material"), help);
        }
    }
    let points: usize = part.layer.iter().map(|layer| layer.points).sum();
    if points > MAX_LAYER_POINTS {
        let help = "use one point in each layer, or unite layers";
        let what = format!("its layers have {points} points, and at most 40 are possible");
        wrong("layer", what, help);
    }
    let valid = |layer: &LayerInput| {
        layer.thickness > 0.0
            && layer.thickness.is_finite()
            && (1..=MAX_POINTS).contains(&layer.points)
    };
    points <= MAX_LAYER_POINTS && part.layer.iter().all(valid)
}

#[cfg(test)]
mod tests {
    use crate::input::job::read_text;

    const JOB: &str = "title = \"t\"\nunits = \"mm, ms, kg\"\nend_time = 1.0\n[mesh]\nnodes = \
        [[1, 0.0, 0.0, 0.0], [2, 1.0, 0.0, 0.0], [3, 1.0, 1.0, 0.0], [4, 0.0, 1.0, 0.0]]\n\
        shells = [[1, 1, 1, 2, 3, 4]]\n[[material]]\nname = \"steel\"\nlaw = \"elastic\"\n\
        density = 7.85e-6\nyoungs_modulus = 200.0\npoisson = 0.3\n[[part]]\nid = 1\n";

    fn problems(part: &str) -> String {
        let read = read_text("layers.toml".into(), format!("{JOB}{part}"), &[]);
        read.err().map_or(String::new(), |report| report.to_string())
    }

    #[test]
    fn a_part_has_the_thickness_and_the_material_of_its_layers() {
        let layers = "layer = [{ thickness = 0.5, material = \"steel\", points = 1 }, \
                      { thickness = 1.0, material = \"steel\", angle = 45.0 }]\n";
        let text = format!("{JOB}{layers}");
        let Ok(model) = read_text("layers.toml".into(), text, &[]) else { panic!("no model") };
        let part = &model.job.part[0];
        assert_eq!((part.thickness, part.material.as_str()), (1.5, "steel"));
        assert_eq!(part.layer.iter().map(|layer| layer.points).sum::<usize>(), 3);
    }

    #[test]
    fn wrong_layers_are_all_reported_with_their_lines() {
        let text = problems(
            "thickness = 1.0\nlayer = [\n{ thickness = 0.0, material = \"steel\" },\n\
             { thickness = 1.0, points = 11 },\n{ thickness = 1.0, material = \"stel\" }]\n",
        );
        for wanted in [
            "it has both layers and a thickness",
            "layer 1 has the thickness 0",
            "layer 2 has 11 points",
            "layer 2 has no material",
            "layers.toml:",
        ] {
            assert!(text.contains(wanted), "{wanted}: {text}");
        }
        for (points, wanted) in [("0", "has 0 points"), ("50", "has 50 points"), ("9", "45 points")]
        {
            let layer = format!("{{ thickness = 1.0, material = \"steel\", points = {points} }},");
            let text = problems(&format!("layer = [{}]\n", layer.repeat(5)));
            assert!(text.contains(wanted), "{wanted}: {text}");
        }
        let text = problems(
            "layer = [{ thickness = 1.0, material = \"stel\" }, \
             { thickness = 1.0, material = \"steel\" }]\n",
        );
        assert!(text.contains("layer 1: there is no material 'stel'"), "{text}");
        assert!(text.contains("did you mean 'steel'"), "{text}");
    }
}
