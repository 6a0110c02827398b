//! Jobs with wrong ties, and the projection of tied nodes onto their surface.

use super::*;

/// Reads the job of two bars with a gap [mm] and these keys.
fn job(gap: f64, keys: &str) -> Result<Model, String> {
    let (mut scene, _) = bars(1.0, gap);
    scene.add("[[initial_velocity]]\nvelocity = [1.0, 0.0, 0.0]");
    scene.add(keys);
    model(&scene)
}

#[test]
fn wrong_jobs_are_reported() {
    let said = |rest: &str, words: &[&str]| {
        let report = match job(0.0, rest) {
            Ok(model) => model.warnings.iter().map(|w| format!("{}\n", w.message)).collect(),
            Err(report) => report,
        };
        words
            .iter()
            .for_each(|word| assert!(report.contains(word), "missing text: {word}\n{report}"));
    };
    said("[[tie]]\nnodes = \"end\"\n", &["a tie has no surface"]);
    said(
        "[[tie]]\nnodes = \"ends\"\nparts = [3]\n",
        &["there is no node set `ends`", "tie: there is no part 3"],
    );
    said(
        "[[tie]]\nnodes = \"end\"\nnode = 550\nparts = [1]\n",
        &["also has `parts`, `faces`, `offset` or `inside`", "node 550 is tied to itself"],
    );
    said("[[tie]]\nnodes = \"end\"\nnode = 9999\n", &["no element has node 9999"]);
    said("[[tie]]\nnodes = \"end\"\nparts = [1]\ntolerance = -1.0\n", &["tolerance is -1"]);
    said(
        "[[tie]]\nnodes = \"end\"\nparts = [1]\nthicknesses = [0.0, -1.0]\n",
        &["a thickness is -1"],
    );
    said(
        &format!("{TIE}[[wall]]\npoint = [-1.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n"),
        &["16 tied nodes do not touch rigid walls"],
    );
    said(&format!("{TIE}{TIE}"), &["is tied twice: by tie `joint` and tie `joint`"]);
    let inside = "[[tie]]\nnodes = \"end\"\ninside = true\n";
    said(inside, &["its parts have no solids"]);
    said(&format!("{inside}parts = [1]\nrotations = true\n"), &["`inside` and also `rotations`"]);
    said(&format!("{inside}parts = [2]\n"), &["all its nodes belong to its solids"]);
    said(&inside.replace("end", "ends"), &["there is no node set `ends`"]);
    said(
        "[[tie]]\nnodes = \"second\"\nparts = [1]\n",
        &["tie 1: 960 of 976 nodes are not near enough to its surface"],
    );
    said("[[tie]]\nnodes = \"end\"\nparts = [2]\n", &["none of its 16 nodes is near enough"]);
    said(
        "[[tie]]\nnodes = \"end\"\nparts = [1]\nfaces = \"second\"\n",
        &["its surface has no face"],
    );
    said(
        &format!("{TIE}[[fix]]\nnodes = \"end\"\ndofs = [\"y\"]\n"),
        &["16 tied nodes have another constraint or motion: 550, 551,"],
    );
    said(
        &format!("{TIE}[[rigid]]\nname = \"b\"\nparts = [2]\n"),
        &["16 tied nodes belong to rigid bodies"],
    );
}

/// Nodes near a surface are moved onto it, with a warning; nodes farther away than the tolerance
/// are not tied.
#[test]
fn nodes_are_moved_onto_the_surface() {
    let near = job(0.1, TIE).unwrap();
    let warning = near.warnings.iter().find(|w| w.message.contains("moved onto")).unwrap();
    assert!(
        warning.message.contains("tie `joint`: 16 nodes are moved onto its surface"),
        "{}",
        warning.message
    );
    let at = |id| near.mesh.nodes.iter().find(|n| n.id == id).unwrap().x[0];
    assert!(
        near.settings.ties.iter().all(|t| (at(t.node) - LENGTH).abs() < 1e-12),
        "round-off of the projection"
    );
    // A twentieth of a diagonal of 2 sqrt 2 is 0.14.
    let far = job(0.2, TIE).err().unwrap();
    assert!(far.contains("none of its 16 nodes"), "{far}");
    job(0.2, &format!("{TIE}tolerance = 0.25")).unwrap();
    // The tolerance follows from the thicknesses of a deck, but is at least a twentieth of the
    // diagonal.
    job(0.2, &format!("{TIE}thicknesses = [0.2, 0.2]")).unwrap();
    job(0.1, &format!("{TIE}thicknesses = [0.01, 0.0]")).unwrap();
}
