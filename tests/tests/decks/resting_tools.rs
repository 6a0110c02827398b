//! Tools that stop: the error of the energy is not that of the round-off of what they gave back.

use crate::base::BASE;
use crumple_tests::program::{crumple_with, run};
use std::fs;

/// A rigid block moves, rests and moves again, by displacements and by velocities, next to a plate
/// at rest: the run ends, with a small error.
#[test]
fn a_tool_may_rest() {
    let base = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\n").replace("10.0\n*PART", "2.0\n*PART");
    let materials = "*MAT_ELASTIC\n1,7.85e-6,210.0,0.3\n*MAT_RIGID\n2,7.85e-6,210.0,0.3\n\n\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    for (kind, curve) in [(2, "0,0\n0.6,-5\n1.2,-5\n4,-20\n"), (0, "0,-9\n0.6,0\n1.2,0\n4,-9\n")] {
        let motion = format!("*BOUNDARY_PRESCRIBED_MOTION_RIGID\n2,3,{kind},7\n*DEFINE_CURVE\n7\n");
        fs::write(&path, format!("{base}{materials}{motion}{curve}*END\n")).unwrap();
        let args = ["run", path.to_str().unwrap(), "--set", "output.history_interval=0.002"];
        let ended = run(crumple_with(&args)).with_code(0);
        let error = ended.history().column("energy error [-]");
        let most = error.iter().fold(0.0, |m: f64, e| m.max(e.abs()));
        // A thousandth of the largest energy is left of it at least.
        assert!(most < 1e-6, "{kind}: {most}");
    }
}
