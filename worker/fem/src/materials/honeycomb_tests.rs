//! Honeycomb on paths of strain: limits of each component, compaction, axes, energy, failure.

use crate::elements::HourglassForm;
use crate::elements::solid_testing::{Solids, block, solid_part};
use crate::elements::testing::{Noise, rotate};
use crate::materials::testing::{Cube, material, problems, table};
use crumple_proto::partition::{Material, Param};

/// Constants of the compacted solid, and V_f.
const E: f64 = 70.0;
const NU: f64 = 0.3;
const YIELD: f64 = 0.2;
const COMPACTED: f64 = 0.3;
/// Moduli before compaction, in the order of the stress.
const MODULI: [f64; 6] = [1.0, 0.6, 0.4, 0.5, 0.3, 0.2];
/// Stress of each curve at a volume strain of 0 and 0.6.
const LIMITS: [[f64; 2]; 6] = [
    [0.004, 0.01],
    [0.003, 0.006],
    [0.002, 0.005],
    [0.0015, 0.003],
    [0.001, 0.0025],
    [0.0012, 0.002],
];
const KEYS: [&str; 6] = ["crush_a", "crush_b", "crush_c", "crush_ab", "crush_bc", "crush_ca"];

/// Returns a honeycomb with a curve for each component and these parameters.
fn honeycomb(numbers: &[(&str, f64)], others: &[(&str, Param)]) -> Material {
    let solid = [
        ("youngs_modulus", E),
        ("poisson", NU),
        ("yield_stress", YIELD),
        ("compacted_volume", COMPACTED),
    ];
    let curves = KEYS.into_iter().zip(LIMITS);
    let curves = curves.map(|(key, [first, last])| (key, table(&[[0.0, first], [0.6, last]])));
    let all: Vec<_> = curves
        .chain([("moduli", Param::List(MODULI.to_vec()))])
        .chain(others.iter().cloned())
        .collect();
    material("honeycomb", &[&solid, numbers].concat(), &all)
}

/// Limit of a component at an abscissa.
fn limit(component: usize, x: f64) -> f64 {
    let [first, last] = LIMITS[component];
    first + (last - first) * x.max(0.0) / 0.6
}

/// Modulus of a component at a volume.
fn modulus(component: usize, volume: f64) -> f64 {
    let beta = ((1.0 - volume) / (1.0 - COMPACTED)).clamp(0.0, 1.0);
    let solid = if component < 3 { E } else { 0.5 * E / (1.0 + NU) };
    MODULI[component] + beta * (solid - MODULI[component])
}

/// Returns a strain with one component.
fn along(component: usize, strain: f64) -> [f64; 6] {
    std::array::from_fn(|c| if c == component { strain } else { 0.0 })
}

/// Compression along each axis follows the curve of the axis, without stress in the others, also
/// where the honeycomb is turned over by a quarter; unloading has the modulus of the compaction.
#[test]
fn crushing_follows_the_curve_of_each_axis() {
    for c in 0..3 {
        let mut cube = Cube::new(&honeycomb(&[], &[]));
        assert_eq!(cube.step(along(c, -1e-4), 1.0), 1.0, "elastic");
        let volume = (-1e-4f64).exp();
        assert!((cube.state[c] + 1e-4 * modulus(c, volume)).abs() < 1e-15, "{}", cube.state[c]);
        let mut length = volume;
        for percent in 2..69 {
            let next = 1.0 - 0.01 * f64::from(percent);
            let left = cube.step(along(c, (next / length).ln()), 1.0);
            length = next;
            assert!((cube.state[c] + limit(c, 1.0 - length)).abs() < 1e-9 * YIELD, "{length}");
            assert!((0..6).all(|k| k == c || cube.state[k] == 0.0), "{:?}", cube.state);
            assert!(left < 1.0);
        }
        let before = cube.state[c];
        cube.step(along(c, 1e-5), 1.0);
        let slope = (cube.state[c] - before) / 1e-5;
        assert!((slope / modulus(c, length) - 1.0).abs() < 1e-9, "{slope}");
        // Tension is limited by the same curve.
        (0..30).for_each(|_| _ = cube.step(along(c, 1e-3), 1.0));
        let exact = limit(c, 1.0 - length * (1e-5f64 + 0.03).exp());
        assert!((cube.state[c] - exact).abs() < 1e-12, "{} {exact}", cube.state[c]);
    }
}

/// Shear of both signs, in the uncrushed material and after compression.
#[test]
fn shear_follows_its_curve_over_the_volume() {
    for c in 3..6 {
        for crush in [0.0, 0.35] {
            let mut cube = Cube::new(&honeycomb(&[], &[]));
            cube.step(along(2, (1.0f64 - crush).ln()), 1.0);
            cube.step(along(c, 1e-5), 1.0);
            let exact = 1e-5 * modulus(c, 1.0 - crush);
            assert!((cube.state[c] / exact - 1.0).abs() < 1e-9, "{} {exact}", cube.state[c]);
            for sign in [1.0, -1.0] {
                (0..60).for_each(|_| _ = cube.step(along(c, sign * 1e-3), 1.0));
                let exact = sign * limit(c, crush);
                assert!((cube.state[c] - exact).abs() < 1e-12, "{} {exact}", cube.state[c]);
            }
            let other = (0..6).filter(|k| ![2, c].contains(k));
            assert!(other.map(|k| cube.state[k]).all(|s| s == 0.0), "{:?}", cube.state);
        }
    }
}

/// From V_f on the pressure grows with the bulk modulus of the solid, and the deviator is limited
/// by its yield stress. The step follows both.
#[test]
fn compacted_honeycomb_is_the_solid() {
    let mut cube = Cube::new(&honeycomb(&[], &[]));
    let bulk = E / (3.0 * (1.0 - 2.0 * NU));
    cube.step(along(2, (COMPACTED + 1e-3f64).ln()), 1.0);
    assert!((cube.state[2] + limit(2, 0.7 - 1e-3)).abs() < 1e-12, "{:?}", cube.state);
    let mean = |cube: &Cube| cube.state[..3].iter().sum::<f64>() / 3.0;
    let (mut before, mut volume) = (mean(&cube), COMPACTED + 1e-3);
    for step in 0..50 {
        let left = cube.step(along(2, -1e-3), 1.0);
        let grows = mean(&cube) - before;
        (before, volume) = (mean(&cube), volume * (-1e-3f64).exp());
        if volume <= COMPACTED {
            assert!((grows + bulk * 1e-3).abs() < 1e-12, "{step}: {grows}");
            assert!(cube.von_mises() < YIELD * (1.0 + 1e-12));
        }
        assert!(step < 20 || (left < 1.0 && (cube.von_mises() / YIELD - 1.0).abs() < 1e-12));
    }
    let bound = 1.0 + cube.at("stiffening");
    assert!(bound >= 3.0 * bulk / MODULI[0] * (1.0 - 1e-12), "{bound}");
    assert_eq!(cube.at("compaction"), 1.0);
}

/// The moduli of the step at the start are those before compaction, and grow with it.
#[test]
fn the_step_follows_the_compaction() {
    let mut cube = Cube::new(&honeycomb(&[], &[]));
    cube.step([0.0; 6], 1.0);
    assert!(cube.state.iter().all(|s| *s == 0.0));
    cube.step(along(0, 0.5f64.ln()), 1.0);
    cube.step(along(0, 1e-6), 1.0);
    let beta = 0.5 / 0.7;
    let exact = beta * (E / (1.0 - 2.0 * NU) - 1.0);
    assert!((cube.at("stiffening") / exact - 1.0).abs() < 1e-6, "{}", cube.at("stiffening"));
}

/// With `directional` a curve is over the strain of its own direction, whatever the volume.
#[test]
fn directional_curves_are_over_their_own_strain() {
    let law = honeycomb(&[], &[("directional", Param::Flag(true))]);
    for c in 0..3 {
        let mut cube = Cube::new(&law);
        let other = (c + 1) % 3;
        cube.step(along(other, 0.8f64.ln()), 1.0);
        (0..40).for_each(|_| _ = cube.step(along(c, 0.025 * 0.7f64.ln()), 1.0));
        assert!((cube.state[c] + limit(c, 0.3)).abs() < 1e-12, "{:?}", cube.state);
        let sheared = 3 + c;
        (0..40).for_each(|_| _ = cube.step(along(sheared, -0.01), 1.0));
        assert!((cube.state[sheared] + limit(sheared, 0.4)).abs() < 1e-12, "{:?}", cube.state);
    }
}

/// At a constant rate of uniaxial strain the effective rate is 2/3 of it.
#[test]
fn the_rate_scales_all_curves() {
    let factors = table(&[[0.0, 1.0], [1.0, 1.5], [10.0, 2.0]]);
    let law = honeycomb(&[], &[("rate_factors", factors)]);
    for (rate, factor) in [(0.3, 1.1), (1.5, 1.5), (300.0, 2.0)] {
        let mut cube = Cube::new(&law);
        (0..4000).for_each(|_| _ = cube.step(along(0, -1e-4), 1e-4 / rate));
        let exact = factor * limit(0, 1.0 - (-0.4f64).exp());
        assert!((cube.state[0] / exact + 1.0).abs() < 1e-9, "{rate}: {} {exact}", cube.state[0]);
    }
}

/// Closed random paths never give energy: small ones far from compaction, and ones across it.
#[test]
fn closed_paths_cost_work() {
    for (seed, first) in (0..40).flat_map(|seed| [(seed, 1.0), (seed, 0.6), (seed, 0.31)]) {
        for directional in [false, true] {
            let law = honeycomb(&[], &[("directional", Param::Flag(directional))]);
            let mut cube = Cube::new(&law);
            let each = f64::ln(first) / 300.0;
            (0..100).for_each(|_| _ = cube.step([each, each, each, 0.0, 0.0, 0.0], 1.0));
            let start = (cube.work, stored(&cube));
            let mut noise = Noise(seed);
            let path: Vec<[f64; 6]> =
                (0..3).map(|_| std::array::from_fn(|_| 2e-4 * noise.next())).collect();
            for sign in [1.0, -1.0] {
                for e in &path {
                    (0..50).for_each(|_| _ = cube.step(e.map(|e| sign * e), 1.0));
                }
            }
            let gain = start.1 + cube.work - start.0 - stored(&cube);
            assert!(gain > -1e-9, "{seed} {first} {directional}: {gain}");
        }
    }
}

/// Stored energy per volume at the start, with the moduli of the largest compaction.
fn stored(cube: &Cube) -> f64 {
    let volume = cube.at("volume strain").exp();
    let s = &cube.state;
    let normal = s[..3].iter().map(|s| s * s).sum::<f64>();
    let shear = s[3..6].iter().map(|s| s * s).sum::<f64>();
    if volume <= COMPACTED {
        let sum = s[..3].iter().sum::<f64>();
        return volume * ((1.0 + NU) * (normal + 2.0 * shear) - NU * sum * sum) / (2.0 * E);
    }
    let of = 1.0 - cube.at("compaction") * (1.0 - COMPACTED);
    volume * (0..6).map(|c| 0.5 * s[c] * s[c] / modulus(c, of)).sum::<f64>()
}

/// A point fails at its tensile strain, not in compression, or at its shear strain.
#[test]
fn a_point_fails_at_its_strain() {
    let law = honeycomb(&[("tension_failure_strain", 0.2), ("shear_failure_strain", 0.3)], &[]);
    for (c, sign, last) in [(1, 1.0, 182), (4, -1.0, 298), (5, 1.0, 298)] {
        let mut cube = Cube::new(&law);
        // The logarithm of 1.2 is 0.1823.
        (0..last).for_each(|_| _ = cube.step(along(c, sign * 1e-3), 1.0));
        assert_eq!(cube.at("failed"), 0.0, "{c}");
        (0..4).for_each(|_| _ = cube.step(along(c, sign * 1e-3), 1.0));
        assert!(cube.at("failed") == 1.0 && cube.state[..6].iter().all(|s| *s == 0.0), "{c}");
    }
    let mut pressed = Cube::new(&law);
    (0..600).for_each(|_| _ = pressed.step(along(1, -1e-3), 1.0));
    assert_eq!(pressed.at("failed"), 0.0);
}

/// Returns the component of a stress (xx, yy, zz, xy, yz, zx) in two directions.
fn component([xx, yy, zz, xy, yz, zx]: [f64; 6], m: [f64; 3], n: [f64; 3]) -> f64 {
    let rows = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
    (0..3).map(|i| (0..3).map(|j| m[i] * rows[i][j] * n[j]).sum::<f64>()).sum()
}

/// Returns an element of honeycomb at these nodes.
fn element(law: Material, turned: impl Fn([f64; 3]) -> [f64; 3]) -> Solids {
    let (nodes, cells) = block([1, 1, 1], [1.0; 3]);
    let nodes: Vec<[f64; 3]> = nodes.into_iter().map(turned).collect();
    let mut part = solid_part(HourglassForm::Stiffness, None);
    part.material.clone_from(&law.name);
    Solids::new(part, law, &nodes, &cells)
}

/// Compresses an element by 40 % along a direction, in steps by the logarithm.
fn press(solids: &mut Solids, n: [f64; 3], steps: usize) {
    let each = (0.6f64.ln() / steps as f64).exp() - 1.0;
    for _ in 0..steps {
        solids.go(|x| {
            let along: f64 = (0..3).map(|i| n[i] * x[i]).sum();
            std::array::from_fn(|i| x[i] + each * along * n[i])
        });
    }
}

/// Axes at 30 degrees, by vectors in an element along the global axes, and by the nodes of a turned
/// element: compression along a, b and c gives the stress of the axis, and none in the others.
#[test]
fn axes_may_be_turned() {
    let angle = [0.0, 0.0, std::f64::consts::PI / 6.0];
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]].map(|e| rotate(angle, e));
    let [a, b, _] = axes;
    // The second vector is in the plane of a and b, not along b.
    let second = std::array::from_fn::<f64, 3, _>(|i| 0.3 * a[i] + 2.0 * b[i]);
    let vectors = [
        ("direction", Param::List(a.map(|x| 5.0 * x).to_vec())),
        ("direction_2", Param::List(second.to_vec())),
    ];
    for c in 0..3 {
        for by_nodes in [false, true] {
            let mut solids = if by_nodes {
                element(honeycomb(&[], &[]), |x| rotate(angle, x))
            } else {
                element(honeycomb(&[], &vectors), |x| x)
            };
            press(&mut solids, axes[c], 2000);
            let stress = solids.fields(0).stress;
            for i in 0..3 {
                for j in 0..3 {
                    let exact = if i == c && j == c { -limit(c, 0.4) } else { 0.0 };
                    let got = component(stress, axes[i], axes[j]);
                    // A step of 2.6e-4 has a third-order error in the volume.
                    assert!((got - exact).abs() < 1e-9, "{c} {by_nodes} {i} {j}: {got} {exact}");
                }
            }
        }
    }
}

/// Returns the stress of an element that is crushed by 40 % along a, after it has turned by `about`
/// meanwhile.
fn turned_stress(about: [f64; 3], steps: usize) -> [f64; 6] {
    let mut solids = element(honeycomb(&[], &[]), |x| x);
    let start: Vec<[f64; 3]> = solids.x.iter().map(|x| [x[0], x[1], x[2]]).collect();
    for step in 1..=steps {
        let share = step as f64 / steps as f64;
        let length = 1.0 - 0.4 * share;
        for ((x, v), first) in solids.x.iter().zip(&mut solids.v).zip(&start) {
            let pressed = [length * first[0], first[1], first[2]];
            let to = rotate(about.map(|c| share * c), pressed);
            (0..3).for_each(|i| v[i] = to[i] - x[i]);
        }
        assert_eq!(solids.step(1.0).trouble, None);
    }
    solids.fields(0).stress
}

/// A block that turns three times about an oblique axis while it is crushed along its axis a has
/// the stress of that axis; what is off falls with the square of the step.
#[test]
fn the_axes_turn_with_the_block() {
    let total = 6.0 * std::f64::consts::PI;
    let about = [1.0, -2.0, 0.5].map(|x: f64| x * total / 5.25f64.sqrt());
    let axes = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let [coarse, fine] = [2000, 4000].map(|steps| {
        let stress = turned_stress(about, steps);
        let off = |i: usize, j: usize| {
            let exact = if (i, j) == (0, 0) { -limit(0, 0.4) } else { 0.0 };
            component(stress, rotate(about, axes[i]), rotate(about, axes[j])) - exact
        };
        (0..9).map(|k| off(k / 3, k % 3).abs() / limit(0, 0.4)).fold(0.0, f64::max)
    });
    assert!(fine < 2e-3 && fine < 0.3 * coarse, "{coarse:e} {fine:e}");
}

/// The internal energy that elements report is the area under the curve, and what is left after
/// release is dissipated.
#[test]
fn the_energy_of_an_element_is_the_area_of_the_curve() {
    let mut solids = element(honeycomb(&[], &[]), |x| x);
    let (mut internal, mut hourglass) = (0.0, 0.0);
    let steps = 4000;
    for step in 0..steps {
        let ratio = 1.0 - 0.4 / f64::from(steps) / (1.0 - 0.4 * f64::from(step) / f64::from(steps));
        let passed = solids.go(|x| [ratio * x[0], x[1], x[2]]);
        (internal, hourglass) = (internal + passed.internal, hourglass + passed.hourglass);
    }
    let area = 0.4 * (LIMITS[0][0] + 0.5 * (LIMITS[0][1] - LIMITS[0][0]) * 0.4 / 0.6);
    // The elastic start lacks about limit^2/(2 E).
    let elastic = LIMITS[0][0].powi(2) / (2.0 * MODULI[0]);
    assert!((internal - area).abs() < 1.5 * elastic, "{internal} {area}");
    assert!(hourglass.abs() < 1e-20, "{hourglass}");
    let forces = solids.nodal().0;
    let right: f64 =
        solids.x.iter().zip(&forces).filter(|(x, _)| x[0] > 0.1).map(|(_, f)| f[0]).sum();
    assert!((right.abs() / limit(0, 0.4) - 1.0).abs() < 1e-6, "{right}");
}

#[test]
fn wrong_honeycombs_are_refused() {
    let text = problems(&honeycomb(
        &[],
        &[("direction", Param::List(vec![0.0; 3])), ("moduli", Param::List(vec![1.0; 5]))],
    ));
    let words = ["direction is no direction", "are not six moduli", "direction_2 is missing"];
    assert!(words.iter().all(|word| text.contains(word)), "{text}");
    let mut bad = honeycomb(&[("tension_failure_strain", 0.0)], &[]);
    bad.parameters.insert("compacted_volume".into(), Param::Number(1.2));
    bad.parameters.insert("crush_bc".into(), table(&[[0.0, 1.0], [0.0, 2.0]]));
    bad.parameters.insert("rate_factors".into(), table(&[[0.0, 1.0], [1.0, 0.9]]));
    let text = problems(&bad);
    let words = [
        "compacted_volume is 1.2",
        "crush_bc is not such a curve",
        "rate_factors are not such factors",
        "tension_failure_strain is 0",
    ];
    assert!(words.iter().all(|word| text.contains(word)), "{text}");
    let along = [
        ("direction", Param::List(vec![1.0, 2.0, 0.0])),
        ("direction_2", Param::List(vec![-2.0, -4.0, 0.0])),
    ];
    let text = problems(&honeycomb(&[], &along));
    assert!(text.contains("direction_2 is along direction"), "{text}");
    let mut less = honeycomb(&[], &[]);
    less.parameters.remove("crush_a");
    less.parameters.remove("moduli");
    let text = problems(&less);
    assert!(text.contains("crush_a is missing") && text.contains("moduli is missing"), "{text}");
}
