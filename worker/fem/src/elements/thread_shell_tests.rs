//! Elements one at a time against elements in groups.

use super::ThreadShell;
use crate::elements::testing::{Noise, Patch, YIELD, part, part_of, steel};
use crate::materials::build;
use crate::nodes::NodeView;
use crumple_proto::partition::Param;

/// Distorted shells under random motions, far into plastic flow: forces and all columns have the
/// bits of the groups.
#[test]
fn one_element_has_the_bits_of_a_group() {
    let mut noise = Noise(7);
    let mut near = |at: f64| at + 0.1 * noise.next();
    let nodes: Vec<[f64; 3]> =
        (0..12).map(|n| [near(f64::from(n / 2)), near(f64::from(n % 2)), near(0.0)]).collect();
    let cells: Vec<[u32; 4]> = (0..5).map(|e| [2 * e, 2 * e + 2, 2 * e + 3, 2 * e + 1]).collect();
    let law = || {
        let number = Param::Number;
        steel("j2", &[("yield_stress", number(YIELD)), ("hardening_modulus", number(1.0))])
    };
    let mut patch = Patch::new(part_of("belytschko_tsay", 0.1), law(), &nodes, &cells);
    let single = ThreadShell::new(&part(0.1), build(&law()).unwrap()).unwrap();
    let mut histories: Vec<Vec<f64>> =
        cells.iter().map(|cell| single.history(&cell.map(|n| nodes[n as usize]))).collect();
    let mut plastic = 0.0f64;
    for step in 0..40 {
        for row in patch.v.iter_mut().chain(&mut patch.w) {
            (0..3).for_each(|c| row[c] = 2.0 * noise.next());
        }
        let dt = 1e-3;
        let passed = patch.step(dt);
        assert_eq!(passed.trouble, None);
        let view = NodeView { x: &patch.x, v: &patch.v, w: &patch.w };
        let (mut least, mut energies) = (f64::INFINITY, [0.0; 2]);
        for (e, history) in histories.iter_mut().enumerate() {
            let result = single.compute::<f64, 5, 4>(cells[e], &view, history, dt).unwrap();
            assert_eq!(result.force[..], patch.force[4 * e..4 * e + 4], "step {step}");
            assert_eq!(result.moment[..], patch.moment[4 * e..4 * e + 4], "step {step}");
            assert_eq!(*history, patch.history.element(e).to_vec(), "step {step}");
            assert!(result.sound);
            (0..2).for_each(|c| energies[c] += result.energies[c]);
            least = least.min(result.stable_dt);
            plastic = plastic.max(history[8]);
        }
        assert_eq!((least, energies), (passed.stable_dt, [passed.internal, passed.hourglass]));
    }
    assert!(plastic > 0.01, "{plastic}");
}

/// A part with other points, or with an option that needs more columns, is refused.
#[test]
fn other_parts_are_refused() {
    let law = steel("j2", &[("yield_stress", Param::Number(YIELD))]);
    let mut with_offset = part(0.1);
    with_offset.offset = 1.0;
    let nodes = [[0.0; 4], [1.0, 0.0, 0.0, 0.0], [1.0, 1.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0]];
    let view = NodeView { x: &nodes, v: &[[0.0; 4]; 4], w: &[[0.0; 4]; 4] };
    for (part, fits) in [(part(0.1), true), (with_offset, false)] {
        let single = ThreadShell::new(&part, build(&law).unwrap()).unwrap();
        let mut history = vec![0.0; single.columns()];
        let all = [0, 1, 2, 3];
        assert_eq!(single.compute::<f64, 5, 4>(all, &view, &mut history, 0.0).is_some(), fits);
        assert!(single.compute::<f64, 3, 4>(all, &view, &mut history, 0.0).is_none());
    }
}
