//! Contact of beams as lines: with each other, with edges of shells and solids, and with faces.
//! Closed forms, and the same bits on any number of workers. Units mm, ms, kg.

use crumple::input::job::Model;
use crumple_tests::{model_of, run_alone, run_side_by_side};
use crumple_verification::scene::{Elastic, Scene};
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;

/// Length of a beam and its radius [mm].
const LENGTH: f64 = 100.0;
pub(super) const RADIUS: f64 = 2.0;
pub(super) const RHO: f64 = 7.85e-6;
const LAWS: [&str; 3] = ["lagrange", "kinematic", "penalty"];

/// Returns a scene without bodies. Parts 1 and 2 have beams, part 3 shells, part 4 solids.
pub(super) fn lines(end_time: f64) -> Scene {
    let mut scene = Scene::new(end_time).in_units("mm, ms, kg");
    scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: RHO });
    for part in [1, 2] {
        scene.add(&format!(
            "[[part]]\nid = {part}\nmaterial = \"steel\"\n[part.beam]\nsection = \"tube\"\n\
             radius = {RADIUS:?}"
        ));
    }
    scene.part(3, "steel", THICKNESS, "");
    scene.solid_part(4, "steel", "");
    scene
}

/// Adds a row of `n` beams of a part between two points; returns its nodes.
pub(super) fn bar(
    scene: &mut Scene,
    part: u32,
    n: usize,
    from: [f64; 3],
    to: [f64; 3],
) -> Vec<u32> {
    let at = |i: usize| [0, 1, 2].map(|c| from[c] + (to[c] - from[c]) * i as f64 / n as f64);
    let nodes: Vec<u32> = (0..=n).map(|i| scene.node(at(i))).collect();
    beams(scene, part, &nodes);
    nodes
}

/// Adds gravity downwards [mm/ms^2].
pub(super) fn gravity(scene: &mut Scene, g: f64) {
    scene.add(&format!("[[gravity]]\nacceleration = [0.0, 0.0, {:?}]", -g));
}

/// Holds a track and starts the rigid body `rider` of part 2, which does not turn, along x.
pub(super) fn ride(scene: &mut Scene, track: &[u32], rider: &[u32], velocity: f64) {
    scene.add("[[rigid]]\nname = \"rider\"\nparts = [2]\nfixed = [\"rx\", \"ry\", \"rz\"]");
    scene.time("dt_max = 1e-3");
    scene.fix(track, "x y z rx ry rz");
    scene.start(rider, [velocity, 0.0, 0.0], [0.0; 3]);
}

/// Returns the model of a scene with these keys of contact.
pub(super) fn in_contact(scene: &Scene, keys: &str) -> Model {
    let mut scene = scene.clone();
    scene.add(&format!("[contact]\n{keys}"));
    model_of(&scene.text("Lines in contact"), &[])
}

/// Adds beams from node to node.
fn beams(scene: &mut Scene, part: u32, nodes: &[u32]) {
    // The direction of the second axis has no effect on tubes.
    let third = scene.node([310.0, 470.0, 590.0]);
    nodes.windows(2).for_each(|pair| scene.beam(part, [pair[0], pair[1], third]));
}

/// Thickness of shells [mm].
const THICKNESS: f64 = 1.0;

/// Returns the position and velocity of the node with this id.
pub(super) fn at(e: &Engine, id: u32) -> ([f64; 3], [f64; 3]) {
    let n = (0..e.nodes.local_count)
        .find(|&n| e.nodes.id[n].label() == u64::from(id))
        .expect("a node of the mesh");
    ([0, 1, 2].map(|c| e.nodes.x[n][c]), [0, 1, 2].map(|c| e.nodes.v[n][c]))
}

/// Returns the momentum and the angular momentum.
fn momenta(e: &Engine) -> [f64; 6] {
    let (p, l) = momentum(&e.nodes);
    [p[0], p[1], p[2], l[0], l[1], l[2]]
}

/// Collides two rigid beams at right angles, at the distance `off` from the middle of both; the
/// upper one falls with 1 mm/ms. Returns the velocities along z of their centres after they have
/// separated or joined, and the change of the momenta.
fn crossed(law: &str, off: f64) -> ([f64; 2], f64) {
    const CELLS: usize = 11; // no node at the crossing
    let mut scene = lines(1.5);
    let z = RADIUS + 0.5;
    let along = |s: f64| LENGTH * (s - 0.5) - off;
    let above = bar(&mut scene, 1, CELLS, [along(0.0), 0.0, z], [along(1.0), 0.0, z]);
    let below = bar(&mut scene, 2, CELLS, [0.0, along(0.0), -z], [0.0, along(1.0), -z]);
    scene.add("[[rigid]]\nname = \"above\"\nparts = [1]\n[[rigid]]\nname = \"below\"\nparts = [2]");
    scene.time("dt_max = 2e-3");
    scene.start(&above, [0.0, 0.0, -1.0], [0.0; 3]);
    let model = in_contact(&scene, law);
    let (mut start, mut change, mut touched) = (None, 0.0f64, false);
    let end = run_alone(&model, |e| {
        let now = momenta(e);
        let first = *start.get_or_insert(now);
        let size = first[2].abs();
        change = now
            .iter()
            .zip(first)
            .map(|(a, b)| (a - b).abs())
            .fold(change, |m, d| m.max(d / (size * LENGTH)));
        touched |= e.contact.as_ref().is_some_and(|c| c.owned_table().any(|p| p.key.is_edge()));
    });
    assert!(touched, "{law}: there are edge pairs");
    let mean = |ids: &[u32]| {
        let weight = |k: usize| if k == 0 || k == CELLS { 0.5 } else { 1.0 };
        ids.iter().enumerate().map(|(k, &id)| weight(k) * at(&end, id).1[2]).sum::<f64>()
            / CELLS as f64
    };
    ([mean(&above), mean(&below)], change)
}

/// Rigid beams collide at the distance `d` from their middles. The impulse is
/// `m v (1 + e)/2/(1 + m d^2/I)`, with the restitution e = 0 of the laws without compliance and
/// e = 1 of a spring without damping.
#[test]
fn crossed_rigid_beams_take_over_the_closed_form() {
    for d in [0.0, 20.0] {
        // Inertia of lumped masses: m L^2/12 (1 + 2/n^2); the inertia of the nodes themselves is
        // below 1 %.
        let arm = d * d / (LENGTH * LENGTH / 12.0 * (1.0 + 2.0 / 121.0));
        for (law, rebound) in [
            ("law = \"lagrange\"", 0.0),
            ("law = \"kinematic\"", 0.0),
            ("law = \"penalty\"\npenalty_damping = 0.0", 1.0),
        ] {
            let ([above, below], change) = crossed(law, d);
            let struck = 0.5 * (1.0 + rebound) / (1.0 + arm);
            assert!((-below - struck).abs() < 0.01, "{law}, {d} off: {below}, expected {struck}");
            assert!(
                (above + below + 1.0).abs() < 1e-9,
                "{law}, {d} off: momentum, {above} {below}"
            );
            assert!(change < 1e-9, "{law}, {d} off: momenta change by {change}");
        }
    }
}

/// Deformable beams, elastic and hollow: none goes through the other, and contact creates no
/// energy.
#[test]
fn crossed_elastic_beams_do_not_pass_and_keep_energy() {
    for law in LAWS {
        let mut scene = lines(1.0);
        let z = RADIUS + 0.1;
        let above = bar(&mut scene, 1, 10, [-50.0, 1.0, z], [50.0, 1.0, z]);
        bar(&mut scene, 2, 11, [2.0, -50.0, -z], [2.0, 50.0, -z]);
        scene.start(&above, [0.0, 0.0, -5.0], [0.0; 3]);
        let model = in_contact(&scene, &format!("law = \"{law}\""));
        let (mut nearest, mut initial, mut worst) = (f64::INFINITY, 0.0f64, 0.0f64);
        let end = run_alone(&model, |e| {
            // Node 6 of one beam and the nodes near y = 1 of the other.
            let low = at(e, above[5]).0[2];
            let high = 0.5 * (at(e, above[10] + 2 + 5).0[2] + at(e, above[10] + 2 + 6).0[2]);
            nearest = nearest.min(low - high);
            let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
            initial = initial.max(if e.clock.cycle == 1 { energies.kinetic } else { 0.0 });
            worst = worst.max((energies.kinetic + energies.internal) / initial);
        });
        // The beams bend by less than 0.1 between nodes.
        assert!(nearest > 2.0 * RADIUS - 0.2, "{law}: smallest distance of the axes {nearest}");
        assert!(worst < 1.005, "{law}: energy rises to {worst} of the initial energy");
        let crossings = end.contact.as_ref().unwrap().crossings(&end.nodes, end.clock.time);
        assert!(crossings.is_empty(), "{law}: {crossings:?}");
    }
}

/// A rigid beam falls on the free edge of an upright sheet that is held, off the beam's middle.
/// It gives off `m v (1 + e)/(1 + m d^2/I)` with the restitution e, and turns about the edge, at
/// the distance of its radius and half the thickness.
#[test]
fn a_beam_that_falls_over_a_free_edge_turns_about_it() {
    let (v, d) = (1.0, 20.0);
    for law in LAWS {
        let mut scene = lines(3.0);
        let z = RADIUS + 0.5 * THICKNESS + 0.2;
        let bar = bar(&mut scene, 1, 11, [0.0, d - 50.0, z], [0.0, d + 50.0, z]);
        let sheet = scene.grid(3, [3, 2], |x, y| [30.0 * (x - 0.5), 0.0, -20.0 * y]);
        scene.add("[[rigid]]\nname = \"bar\"\nparts = [1]");
        scene.time("dt_max = 1e-3");
        scene.fix(sheet.all(), "x y z");
        scene.start(&bar, [0.0, 0.0, -v], [0.0; 3]);
        let law_keys = format!("law = \"{law}\"\npenalty_damping = 0.0");
        let model = in_contact(&scene, &law_keys);
        let mut least = f64::INFINITY;
        let end = run_alone(&model, |e| {
            let [[_, y0, z0], [_, y1, z1]] = [bar[0], bar[11]].map(|n| at(e, n).0);
            // Distance of the edge, which is the origin, from the line of the bar.
            least = least.min((y0 * z1 - y1 * z0).abs() / (y1 - y0).hypot(z1 - z0));
        });
        let arm = d * d / (LENGTH * LENGTH / 12.0 * (1.0 + 2.0 / 121.0));
        let weight = |k: usize| if k == 0 || k == 11 { 0.5 } else { 1.0 };
        let mean =
            bar.iter().enumerate().map(|(k, &n)| weight(k) * at(&end, n).1[2]).sum::<f64>() / 11.0;
        // Under laws without compliance it stays on the edge. On a spring without damping it
        // rebounds with its initial velocity.
        let rebound = if law == "penalty" { 1.0 } else { 0.0 };
        let kept = v * ((1.0 + rebound) / (1.0 + arm) - 1.0);
        assert!(
            (mean - kept).abs() < 0.01 * v,
            "{law}: velocity of the middle {mean}, expected \
            {kept}"
        );
        assert!(least > (RADIUS + 0.5 * THICKNESS) * 0.99, "{law}: smallest distance {least}");
    }
}

/// A beam comes to rest on a sheet under gravity, its line at `r + t/2` from the middle surface;
/// only nodes of either body carry contact forces.
#[test]
fn a_beam_lies_on_a_sheet_at_its_radius_and_half_the_thickness() {
    for law in LAWS {
        let mut scene = lines(8.0);
        let z = RADIUS + 0.5 * THICKNESS;
        let bar = bar(&mut scene, 1, 5, [-35.0, 3.0, z + 0.1], [35.0, 5.0, z + 0.1]);
        let sheet = scene.grid(3, [7, 6], |x, y| [90.0 * (x - 0.5), 70.0 * (y - 0.5), 0.0]);
        scene.time("damping = 2.0");
        scene.fix(sheet.all(), "x y z rx ry rz");
        gravity(&mut scene, 0.5);
        let end = run_alone(&in_contact(&scene, &format!("law = \"{law}\"")), |_| {});
        for &n in &bar {
            let (x, v) = at(&end, n);
            // The penalty spring is compressed by about g dt^2/0.35.
            assert!(
                (x[2] / z - 1.0).abs() < 2e-3 && v[2].abs() < 1e-3,
                "{law}: node {n} at {}, expected {z}, {}",
                x[2],
                v[2]
            );
        }
    }
}

/// Three beams in a triangle hold a cube that stands on its corner between them. Each beam
/// touches one edge of the cube, in the plane of this edge and the axis. The corner is therefore
/// `(r - rho cos a)/sin a` from the plane of the beams, with the distance `rho` from the axis to
/// a beam and `cos a = 1/sqrt(3)`.
#[test]
fn a_cage_of_beams_holds_a_cube_by_its_edges() {
    let (rho, side) = (15.0, 40.0);
    let (cos, sin) = ((1.0f64 / 3.0).sqrt(), (2.0f64 / 3.0).sqrt());
    let depth = (RADIUS - rho * cos) / sin;
    for law in LAWS {
        let mut scene = lines(12.0);
        let mut held = Vec::new();
        for k in 0..3 {
            let (s, c) = (f64::from(k) * 120f64.to_radians()).sin_cos();
            let end = |along: f64| [rho * c - along * s, rho * s + along * c, 0.0];
            held.extend(bar(&mut scene, 1, 3, end(-24.0), end(24.0)));
        }
        // Edges of the cube rise from its corner in the planes through the axis and the middles
        // of the beams.
        let edges: [[f64; 3]; 3] = std::array::from_fn(|k| {
            let (s, c) = (k as f64 * 120f64.to_radians()).sin_cos();
            [side * sin * c, side * sin * s, side * cos]
        });
        let corner = |k: [f64; 3]| {
            [0, 1, 2].map(|c| {
                let start = if c == 2 { depth + 0.05 } else { 0.0 };
                start + (0..3).map(|e| k[e] * edges[e][c]).sum::<f64>()
            })
        };
        let around = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
        let cube: [u32; 8] = std::array::from_fn(|k| {
            let [a, b] = around[k % 4];
            scene.node(corner([a, b, (k / 4) as f64]))
        });
        scene.solid(4, cube);
        scene.time("damping = 1.0");
        scene.fix(&held, "x y z rx ry rz");
        gravity(&mut scene, 0.05);
        let model = in_contact(&scene, &format!("law = \"{law}\"\nfriction = 0.3"));
        let mut lowest = f64::INFINITY;
        let end = run_alone(&model, |e| {
            lowest = lowest.min(at(e, cube[0]).0[2]);
        });
        let (x, v) = at(&end, cube[0]);
        assert!(
            (x[2] - depth).abs() < 0.02 * RADIUS,
            "{law}: the corner is at {}, expected {depth}",
            x[2]
        );
        assert!(lowest > depth - 0.02 * RADIUS && v[2].abs() < 1e-3, "{law}: {lowest}, {v:?}");
        let table = end.contact.as_ref().unwrap().owned_table();
        assert_eq!(table.filter(|p| p.key.is_edge()).count(), 3, "{law}: one edge pair per beam");
    }
}

/// A row of beams is a slide: its joints do not stop a beam that slides across them without
/// friction.
#[test]
fn nothing_catches_where_one_beam_ends_and_the_next_begins() {
    for law in LAWS {
        let mut scene = lines(10.0);
        // Bent down by 6 degrees at each joint.
        let (mut x, mut z) = (-60.0, 0.0);
        let track: Vec<u32> = (0..=12)
            .map(|i| {
                let id = scene.node([x, 0.0, z]);
                let slope = (6.0 * (f64::from(i) - 6.0)).to_radians();
                (x, z) = (x + 10.0 * slope.cos(), z - 10.0 * slope.sin());
                id
            })
            .collect();
        beams(&mut scene, 1, &track);
        let middle = 2.0 * RADIUS
            + 10.0 * (0..6).map(|i| (6.0 * (6.0 - f64::from(i))).to_radians().sin()).sum::<f64>();
        let ends = [-15.0, 15.0].map(|y| [-5.0, y, middle + 0.05]);
        let rider = bar(&mut scene, 2, 3, ends[0], ends[1]);
        ride(&mut scene, &track, &rider, 3.0);
        gravity(&mut scene, 0.2);
        let model = in_contact(&scene, &format!("law = \"{law}\""));
        let (mut least, mut start, mut most) = (f64::INFINITY, None, 0.0f64);
        let end = run_alone(&model, |e| {
            let (p, v) = at(e, rider[1]);
            least = least.min(v[0]);
            let energy = 0.5 * (v[0] * v[0] + v[2] * v[2]) + 0.2 * p[2];
            most = most.max(energy - *start.get_or_insert(energy));
        });
        let (p, _) = at(&end, rider[1]);
        assert!(p[0] > 15.0, "{law}: final position {}", p[0]);
        assert!(least > 2.8, "{law}: lowest velocity {least}");
        assert!(most < 0.02, "{law}: energy gain {most} of 4.5");
    }
}

/// Returns a job with a pile of loose beams, sheets and a bar of solids in two layers, which
/// falls, slides and turns; one beam breaks.
fn pile(contact: &str) -> Model {
    let mut scene = lines(1.0);
    let mut upper = Vec::new();
    for k in 0..4 {
        let y = 14.0 * f64::from(k) - 20.0;
        upper.extend(bar(&mut scene, 1, 9, [-45.0, y, 2.2], [40.0, y + 6.0, 2.4]));
    }
    for k in 0..4 {
        let x = 17.0 * f64::from(k) - 26.0;
        bar(&mut scene, 2, 8, [x, -40.0, -2.2], [x - 7.0, 42.0, -2.1]);
    }
    let sheet = scene.grid(3, [9, 7], |x, y| [100.0 * (x - 0.5), 90.0 * (y - 0.5), -5.2]);
    let lid = scene.grid(3, [5, 4], |x, y| [61.0 * (x - 0.4), 43.0 * (y - 0.5), 5.4]);
    upper.extend(lid.all());
    // Ribs along edges of both sheets, and a post under the lid's corner.
    let ribs = [(&sheet, 8, 3), (&sheet, 8, 5), (&lid, 5, 2)];
    for (of, step, from) in ribs {
        let rib: Vec<u32> = of.all().iter().copied().skip(from).step_by(step).collect();
        beams(&mut scene, 2, &rib);
    }
    let below = scene.node([61.0 * -0.4, 43.0 * -0.5, 3.0]);
    beams(&mut scene, 1, &[lid.at(0, 0), below]);
    upper.push(below);
    let nodes: Vec<u32> = (0..=5)
        .flat_map(|i| {
            [[0.0, 6.2], [4.0, 10.2], [0.0, 14.2], [-4.0, 10.2]]
                .map(|[y, z]| [10.0 * f64::from(i) - 22.0, y, z])
        })
        .map(|at| scene.node(at))
        .collect();
    (0..5).for_each(|i| scene.solid(4, std::array::from_fn(|k| nodes[4 * i + k])));
    upper.extend(&nodes);
    let rim: Vec<u32> = (0..=9).map(|i| sheet.at(i, 0)).collect();
    scene.start(&upper, [9.0, 5.0, -6.0], [0.0; 3]);
    scene.fix(&rim, "x y z");
    gravity(&mut scene, 20.0);
    in_contact(&scene, &format!("friction = 0.2\n{contact}"))
}

#[test]
fn lines_across_workers_give_the_same_bits() {
    for law in [
        "law = \"lagrange\"",
        "law = \"lagrange\"\nedges = false\nbeams = true",
        "law = \"kinematic\"",
        "law = \"penalty\"",
        "law = \"penalty\"\npenalty_form = \"stiffness\"\npenalty_scale = 0.2",
    ] {
        let model = pile(law);
        let alone = run_side_by_side(&model, 1, 500, 0);
        assert_eq!(alone.trouble, None);
        let pairs: usize = alone.pairs.iter().map(Vec::len).sum();
        assert!(pairs > 1000, "{law}: {pairs} pairs in all steps");
        for (workers, every) in [(2, 0), (3, 7), (4, 3)] {
            let many = run_side_by_side(&model, workers, 500, every);
            let differs = many.pairs.iter().zip(&alone.pairs).position(|(a, b)| a != b);
            assert_eq!(
                differs, None,
                "{law}: first cycle in which pairs of {workers} workers differ, renewed every \
                 {every}"
            );
            assert_eq!(
                many.digest(),
                alone.digest(),
                "{law}: {workers} workers, renewed every {every}"
            );
        }
    }
}

/// Without beams in contact the upper beams fall through the lower ones.
#[test]
fn beams_are_out_of_contact_where_the_job_says_so() {
    for (contact, passes) in [
        ("", false),
        ("beams = false", true),
        ("edges = false", true),
        ("edges = false\nbeams = true", false),
        ("beams = false\n[[contact.interface]]\nparts = [1, 2]\nbeams = true", false),
        ("[[contact.interface]]\nparts = [1]\nagainst = [2]\nlaw = \"none\"", true),
    ] {
        let mut scene = lines(1.0);
        let above = bar(&mut scene, 1, 6, [-50.0, 1.0, 3.0], [50.0, 1.0, 3.0]);
        let below = bar(&mut scene, 2, 7, [2.0, -50.0, -3.0], [2.0, 50.0, -3.0]);
        scene.start(&above, [0.0, 0.0, -10.0], [0.0; 3]);
        let end = run_alone(&in_contact(&scene, contact), |_| {});
        let through = at(&end, above[3]).0[2] < at(&end, below[3]).0[2];
        assert_eq!(through, passes, "{contact}");
    }
}

/// A beam that fails releases the bodies that lie on it.
#[test]
fn broken_beams_leave_the_contact() {
    let mut scene = lines(2.0);
    let above = bar(&mut scene, 1, 6, [-50.0, 1.0, 2.1], [50.0, 1.0, 2.1]);
    let below = bar(&mut scene, 2, 1, [2.0, -50.0, -2.1], [2.0, 50.0, -2.1]);
    scene.start(&above, [0.0, 0.0, -4.0], [0.0; 3]);
    let far = scene.set(&below[1..]);
    scene
        .add(&format!("[[motion]]\nnodes = \"{far}\"\ndofs = [\"y\"]\nvelocity = [0.0, 4.0, 0.0]"));
    scene.fix(&below[..1], "x y z");
    scene.fix(&below[1..], "x z");
    let ends = ["", "\n[part.beam.weld]\nnormal = 1.0"].map(|weld| {
        let mut model = in_contact(&scene, "");
        let weak = model
            .settings
            .parts
            .iter_mut()
            .find(|p| p.id == 2)
            .and_then(|p| p.beam.as_mut())
            .unwrap();
        weak.contact_radius = Some(RADIUS);
        if !weld.is_empty() {
            let limits = crumple_proto::job::Weld {
                normal: 1.0,
                shear: 0.0,
                bending: 0.0,
                torsion: 0.0,
                exponents: [2.0; 2],
            };
            weak.weld = Some(limits);
        }
        let end = run_alone(&model, |_| {});
        at(&end, above[3]).0[2]
    });
    assert!(ends[0] > 0.0 && ends[1] < -4.0, "{ends:?}");
}
