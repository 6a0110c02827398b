//! Tests of segment to segment contact.

use super::*;
use crate::surface::Surface;

/// A plate of `n` by `n` segments, a square of side 2, with nodal masses in proportion to their
/// areas; its height and velocity.
struct Plate {
    points: Vec<NodeRecord>,
    segments: Vec<[u32; 4]>,
    /// Area of each node.
    areas: Vec<f64>,
}

fn plate(n: usize, first: usize, at: impl Fn(f64, f64) -> f64, v: [f64; 3]) -> Plate {
    let side = 2.0 / n as f64;
    let (mut points, mut areas, mut segments) = (Vec::new(), Vec::new(), Vec::new());
    for (j, i) in (0..=n).flat_map(|j| (0..=n).map(move |i| (j, i))) {
        let half = |k: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
        let area = half(i) * half(j) * side * side;
        let (x, y) = (side * i as f64 - 1.0, side * j as f64 - 1.0);
        points.push(mass([x, y, at(x, y)], v, area));
        areas.push(area);
        if i < n && j < n {
            let a = (first + j * (n + 1) + i) as u32;
            let up = (n + 1) as u32;
            segments.push([a, a + 1, a + up + 1, a + up]);
        }
    }
    Plate { points, segments, areas }
}

fn forms() -> [ContactInput; 2] {
    // E A / d of a segment is 1 / (n sqrt 2) here.
    let stiff = job("mortar").with("penalty_form", "stiffness").with("penalty_scale", 2e5);
    [job("mortar"), stiff]
}

/// Returns a scene of two plates, one above the other, and the area of each node.
fn two(
    of: &ContactInput,
    [below, above]: [usize; 2],
    at: impl Fn(f64, f64) -> f64,
    v: [f64; 3],
) -> (Scene, Vec<f64>) {
    let one = plate(below, 0, |_, _| 0.0, [0.0; 3]);
    let two = plate(above, one.points.len(), at, v);
    let points = [one.points, two.points].concat();
    let slaves: Vec<u32> = (0..points.len() as u32).collect();
    let scene = Scene::new(of, &points, &[one.segments, two.segments].concat(), &slaves, 1e-3);
    (scene, [one.areas, two.areas].concat())
}

/// A22: flat contact of two plates gives a uniform pressure on both sides, for any meshes.
#[test]
fn flat_plates_press_uniformly_whatever_their_meshes() {
    for of in forms() {
        for meshes in [[2, 2], [2, 3], [4, 3], [1, 3]] {
            let (mut scene, areas) = two(&of, meshes, |_, _| THICK + 1.3e-3, [0.0, 0.0, -1.0]);
            let (mut pressed, before) = (0, scene.energy());
            let momentum = scene.momentum();
            for _ in 0..20 {
                scene.step();
                let forces: Vec<V3> =
                    (0..areas.len()).map(|i| scene.contact.force_on(i as u32)).collect();
                let pressure = forces.iter().map(|f| f.z.abs()).sum::<f64>() / 8.0;
                if pressure == 0.0 {
                    continue;
                }
                pressed += 1;
                for (f, a) in forces.iter().zip(&areas) {
                    let off = (f.z.abs() / (pressure * a) - 1.0).abs();
                    assert!(
                        off < 1e-9 && f.xy().norm() < 1e-9 * f.norm(),
                        "{meshes:?}: {off:e} at a node of {a}"
                    );
                }
            }
            assert!(pressed > 2, "{:?} {meshes:?}: contact in {pressed} steps", of.parameters);
            let upper = scene.v(areas.len() - 1).z;
            assert!(
                scene.pairs().iter().all(|p| p.force.norm() == 0.0) && upper > -0.2,
                "separated again: {upper}"
            );
            assert!((scene.momentum() - momentum).norm() < 1e-12 * momentum.norm(), "round-off");
            // Error of central differences: the parts of a step in which contact begins and ends.
            let kept = scene.energy() / before;
            assert!((kept - 1.0).abs() < 0.2, "{:?} {meshes:?}: energy kept {kept}", of.parameters);
            assert!(
                (scene.energy() - before - scene.work).abs() < 1e-12 * before,
                "energy balance"
            );
        }
    }
}

/// A warped and tilted plate that slides while it falls: both momenta are conserved, and contact
/// returns little more energy than it took.
#[test]
fn tilted_plates_keep_both_momenta() {
    for of in forms() {
        let at = |x: f64, y: f64| THICK + 0.35 + 0.25 * x - 0.05 * y + 0.03 * x * y;
        let (mut scene, _) = two(&of, [3, 4], at, [0.4, 0.2, -2.0]);
        let (momentum, spin, before) = (scene.momentum(), scene.spin(), scene.energy());
        let mut touched = 0;
        for _ in 0..250 {
            scene.step();
            touched += usize::from(scene.pairs().iter().any(|p| p.force.norm() > 0.0));
        }
        assert!(touched > 20, "contact in {touched} steps");
        assert!((scene.momentum() - momentum).norm() < 1e-12 * momentum.norm(), "round-off");
        assert!(
            (scene.spin() - spin).norm() < 1e-11 * momentum.norm(),
            "round-off: {}",
            scene.spin() - spin
        );
        let work = scene.work / before;
        eprintln!("{:?}: work of contact / energy {work:.4}", of.parameters);
        assert!((scene.energy() - before - scene.work).abs() < 1e-12 * before, "energy balance");
        assert!(work < 5e-3, "{:?}: contact work is {work} of the energy", of.parameters);
    }
}

/// A07: a plate slides over another one with a different mesh. Friction decelerates it with mu
/// times the normal force.
#[test]
fn friction_slows_a_plate_over_many_segments() {
    let (mu, load, v) = (0.3, 2.0, 1.0);
    for of in forms() {
        let (mut scene, areas) =
            two(&ContactInput { friction: mu, ..of.clone() }, [4, 1], |_, _| THICK, [0.0; 3]);
        let first = areas.len() - 4;
        (0..first).for_each(|i| scene.nodes.inv_mass[i] = [0.0; 4]);
        for (i, area) in areas.iter().enumerate().skip(first) {
            // Small enough to stay on the plate below all the time.
            (scene.nodes.x[i][0], scene.nodes.x[i][1]) =
                (0.31 * scene.nodes.x[i][0] - 0.55, 0.31 * scene.nodes.x[i][1]);
            scene.load[i].z = -load * area;
        }
        scene.run_damped(100, 0.1);
        (first..areas.len()).for_each(|i| scene.nodes.v[i] = [v, 0.0, 0.0, 0.0]);
        let steps = 200;
        (0..steps).for_each(|_| _ = scene.step());
        let expected = v - mu * load * f64::from(steps) * 1e-3;
        let now = (first..areas.len()).map(|i| scene.v(i).x).sum::<f64>() / 4.0;
        assert!(
            ((now - expected) / (v - expected)).abs() < 0.02,
            "{:?}: {now}, expected {expected}",
            of.parameters
        );
    }
}

/// The segment with the lower number is the slave, and each area is counted once.
#[test]
fn of_two_segments_one_is_the_slave() {
    let (mut scene, _) = two(&job("mortar"), [2, 3], |_, _| THICK - 1e-3, [0.0; 3]);
    scene.step();
    let surface: &Surface = &scene.contact.surface;
    assert!(!scene.pairs().is_empty());
    for p in scene.pairs() {
        assert!(
            p.key.is_segment() && p.key.slave_quarter().0 < p.segment && p.slave_node_count() == 4
        );
        let of = |s: SegmentId| surface.segments.iter().find(|g| g.id == s).unwrap().nodes;
        assert_eq!(
            [&p.nodes[..4], &p.nodes[4..]].concat(),
            [of(p.key.slave_quarter().0), of(p.segment)].concat()
        );
        // Initial penetrations are tolerated.
        assert!(
            (p.penetration - 1e-3).abs() < 1e-15 && p.gap.abs() < 1e-15 && p.force == V3::zeros()
        );
    }
    let area: f64 = scene.pairs().iter().map(|p| p.area).sum();
    assert!((area - 4.0).abs() < 1e-12, "the whole area of the plates: {area}");
}

/// A plate between two others has a separate history for each of them: the first contact does not
/// decide the side of the second one.
#[test]
fn a_plate_between_two_others_holds_both_apart() {
    for of in forms() {
        let middle = plate(2, 0, |_, _| 0.0, [0.0; 3]);
        let above = plate(3, 9, |_, _| THICK + 1e-3, [0.0; 3]);
        let below = plate(3, 25, |_, _| -THICK - 0.1, [0.0, 0.0, 1.0]);
        let points = [middle.points, above.points, below.points].concat();
        let slaves: Vec<u32> = (0..points.len() as u32).collect();
        let segments = [middle.segments, above.segments, below.segments].concat();
        let mut scene = Scene::new(&of, &points, &segments, &slaves, 1e-3);
        // Always pressed onto the middle plate, so that its history is of this contact.
        (9..25).for_each(|i| scene.load[i] = V3::new(0.0, 0.0, -20.0 * scene.nodes.mass[i]));
        let (mut met, mut nearest) = ([0, 0], f64::INFINITY);
        for _ in 0..200 {
            scene.step();
            let touches = |side: f64| {
                scene.pairs().iter().any(|p| p.normal.z * side > 0.0 && p.force.norm() > 0.0)
            };
            (0..2).for_each(|i| met[i] += usize::from(touches([1.0, -1.0][i])));
            let mean = |nodes: std::ops::Range<usize>| {
                nodes.clone().map(|i| scene.x(i).z).sum::<f64>() / nodes.len() as f64
            };
            let [m, a, b] = [mean(0..9), mean(9..25), mean(25..41)];
            nearest = nearest.min((a - m).min(m - b));
        }
        assert!(met[0] > 0 && met[1] > 0, "{:?}: pairs {met:?}", of.parameters);
        assert!(nearest > 0.5 * THICK, "{:?}: smallest distance {nearest}", of.parameters);
    }
}
