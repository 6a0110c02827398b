//! Beams compared with closed forms, and the same bits on any number of workers. Units mm, ms,
//! kg.

use crumple::input::job::{Model, read_text};
use crumple_tests::restart::{Plan, run_interrupted};
use crumple_tests::{model_of, run_alone, run_side_by_side};
use crumple_verification::scene::Scene;
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;
use nalgebra::{Rotation3, Vector3};

const E: f64 = 207.0;
const RHO: f64 = 7.85e-6;
const LENGTH: f64 = 100.0;
const RECTANGLE: &str = "section = \"rectangle\"\nheight = 4.0\nwidth = 2.0";

/// Returns a cantilever of `n` beams from the origin along the first axis of `turn`; the second
/// axis of `turn` is that of the section. Sets are `root` and `tip`. `law` are further keys of
/// its material, `rest` those of the job.
fn cantilever(
    n: usize,
    turn: &Rotation3<f64>,
    section: &str,
    law: &str,
    end_time: f64,
    rest: &str,
) -> Model {
    let mut scene = Scene::default();
    let along = |i: usize| turn * Vector3::new(LENGTH * i as f64 / n as f64, 0.0, 0.0);
    let nodes: Vec<u32> = (0..=n).map(|i| scene.node(along(i).into())).collect();
    let third = scene.node((turn * Vector3::new(30.0, 50.0, 0.0)).into());
    nodes.windows(2).for_each(|ends| scene.beam(1, [ends[0], ends[1], third]));
    scene.set_named("root", &nodes[..1]);
    scene.set_named("tip", &nodes[n..]);
    let text = format!(
        "end_time = {end_time:?}\n{}[output]\nfield_interval = -1.0\n\
         [[material]]\nname = \"steel\"\ndensity = {RHO:?}\nyoungs_modulus = {E:?}\npoisson = 0.3\n\
         {law}\n\
         [[part]]\nid = 1\nmaterial = \"steel\"\n[part.beam]\n{section}\n\
         [[fix]]\nnodes = \"root\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n{rest}",
        scene.mesh_text()
    );
    model_of(&text, &[])
}

const ELASTIC: &str = "law = \"elastic\"";

/// Returns the first frequency of the cantilever for bending with the second moment `i` and the
/// area 8 [1/ms].
fn first_frequency(i: f64) -> f64 {
    1.875_104_07f64.powi(2) * (E * i / (RHO * 8.0 * LENGTH.powi(4))).sqrt()
}

/// The tip deflects by P L^3 / 3 E I under a force, turns by M L / E I under a moment, and by T
/// L / G J under a torque, for any mesh and any direction of the beam: the cubic shape is exact.
/// With 1e-3 of the length the error of small displacements is 1e-6. The torsion constant of 4 x
/// 2 is 0.229 a b^3 (Timoshenko & Goodier 1970, sec. 109).
#[test]
fn a_cantilever_bends_and_twists_as_beams_do() {
    let turn = Rotation3::from_euler_angles(0.3, -0.8, 1.1);
    let (iy, iz) = (4.0 * 8.0 / 12.0, 2.0 * 64.0 / 12.0);
    for n in [1, 3] {
        for (axis, i) in [(1, iz), (2, iy)] {
            let down = 1e-3 * LENGTH;
            let force = turn * Vector3::ith(axis, down * 3.0 * E * i / LENGTH.powi(3));
            let w = first_frequency(i);
            let rest = format!(
                "[time]\ndamping = {:?}\n[[load]]\nnodes = \"tip\"\nforce = [{:?}, {:?}, {:?}]\n",
                2.0 * w,
                force.x,
                force.y,
                force.z
            );
            let end = run_alone(&cantilever(n, &turn, RECTANGLE, ELASTIC, 60.0 / w, &rest), |_| {});
            let moved = Vector3::from_fn(|c, _| end.nodes.x[n][c] - end.nodes.x0[n][c]);
            let moved = turn.inverse() * moved;
            assert!((moved[axis] / down - 1.0).abs() < 1e-5, "{n} beams, axis {axis}: {moved}");
            assert!(moved[3 - axis].abs() < 1e-6 * down, "{n} beams, axis {axis}: {moved}");
        }
    }
    let shear = E / 2.6;
    let torque = 1e-3 * shear * 0.229 * 4.0 * 8.0 / LENGTH;
    let moment = turn * Vector3::new(torque, 0.0, 0.0);
    let rest = format!(
        "[time]\ndamping = 20.0\n[[load]]\nnodes = \"tip\"\nmoment = [{:?}, {:?}, {:?}]\n",
        moment.x, moment.y, moment.z
    );
    let end = run_alone(&cantilever(2, &turn, RECTANGLE, ELASTIC, 60.0, &rest), |_| {});
    let energy = end.ledger.energies(&end.nodes, &end.blocks).values().internal;
    assert!(
        (energy / (0.5 * torque * 1e-3) - 1.0).abs() < 0.01,
        "constant to three digits: {energy}"
    );
}

/// The first frequency converges with the square of the element length to that of Euler and
/// Bernoulli, 1.875^2 sqrt(E I/(rho A L^4)); rotatory inertia reduces it by (r/L)^2 terms of
/// 1e-4.
#[test]
fn a_cantilever_swings_as_beams_do() {
    let i = 2.0 * 64.0 / 12.0;
    let w = first_frequency(i);
    let quarter = 0.5 * std::f64::consts::PI / w;
    let late = |n: usize| {
        // An impact on the tip would excite higher modes too: the beam is released from its
        // static shape instead.
        let force = 1e-3 * LENGTH * 3.0 * E * i / LENGTH.powi(3);
        let rest = format!(
            "[[curve]]\nname = \"off\"\npoints = [[0.0, 0.0], [{:?}, 1.0], [{:?}, 1.0], [{:?}, \
             0.0]]\n\
             [[load]]\nnodes = \"tip\"\nforce = [0.0, {force:?}, 0.0]\ncurve = \"off\"\n",
            10.0 * quarter,
            10.5 * quarter,
            10.5 * quarter + 1e-6
        );
        let model =
            cantilever(n, &Rotation3::identity(), RECTANGLE, ELASTIC, 31.0 * quarter, &rest);
        let (mut crossings, mut before) = (Vec::new(), (0.0, 0.0));
        run_alone(&model, |e| {
            let now = (e.clock.time, e.nodes.x[n][1]);
            if now.0 > 10.6 * quarter && before.1 * now.1 < 0.0 {
                crossings.push(before.0 + (now.0 - before.0) * before.1 / (before.1 - now.1));
            }
            before = now;
        });
        let half = (crossings[8] - crossings[0]) / 8.0;
        std::f64::consts::PI / half / w - 1.0
    };
    let [coarse, fine] = [6, 12].map(late);
    assert!(fine.abs() < 0.01 && coarse.abs() > 2.5 * fine.abs(), "{coarse} {fine}");
}

/// A tip with prescribed motion far beyond yield needs the force M_p / (L - h/3), M_p = sigma b
/// h^2 / 4. With the cubic shape the middle of the first element yields together with its end,
/// so the plastic moment acts at a third of its length h from the root. The force is the work
/// over the displacement; the arm shortens by 1 % at 14 of 100.
#[test]
fn a_plastic_hinge_bears_its_moment() {
    let law = "law = \"j2\"\nhardening = [[0.0, 0.3], [1.0, 0.3]]";
    let rest = "[time]\ndamping = 2.0\n[[motion]]\nnodes = \"tip\"\ndofs = [\"y\"]\n\
                velocity = [0.0, -0.5, 0.0]\n";
    for n in [4, 8] {
        let (mut at, mut unexplained) = (None, 0.0f64);
        let end =
            run_alone(&cantilever(n, &Rotation3::identity(), RECTANGLE, law, 32.0, rest), |e| {
                let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
                if e.clock.time > 24.0 {
                    at.get_or_insert((e.nodes.x[n][1], energies.external));
                }
                unexplained = unexplained
                    .max(energies.balance(0.0).abs() / energies.external.abs().max(1e-3));
            });
        let (way, work) = at.unwrap();
        let force = (end.ledger.energies(&end.nodes, &end.blocks).values().external - work)
            / (way - end.nodes.x[n][1]);
        let expected = 1.01 * 0.3 * 2.0 * 16.0 / 4.0 / (LENGTH * (1.0 - 1.0 / (3.0 * n as f64)));
        assert!((force / expected - 1.0).abs() < 0.01, "{n} beams: {force}, expected {expected}");
        assert!(unexplained < 1e-3, "{n} beams: {unexplained}");
    }
}

/// A free angle of elastic-plastic tubes flies, turns and bends. Momentum and angular momentum
/// are conserved to round-off, energy to the squares of rotations within an element.
#[test]
fn a_loose_frame_keeps_momentum() {
    let law = "law = \"j2\"\nhardening = [[0.0, 0.1], [1.0, 0.3]]";
    let tube = "section = \"tube\"\nradius = 3.0\nwall = 0.5";
    let rest = "[[initial_velocity]]\nvelocity = [1.0, 2.0, 3.0]\nspin = [0.3, 0.5, -0.8]\n\
                centre = [40.0, 0.0, 0.0]\n\
                [[initial_velocity]]\nnodes = \"tip\"\nvelocity = [0.0, 60.0, 35.0]\n";
    let mut model = cantilever(6, &Rotation3::identity(), tube, law, 3.0, rest);
    model.nodes.fixed.fill(0);
    let (mut first, mut worst, mut unexplained, mut initial) = (None, [0.0f64; 2], 0.0f64, 0.0);
    let end = run_alone(&model, |e: &Engine| {
        let (p, l) = momentum(&e.nodes);
        let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
        let now = [p, l];
        let start = *first.get_or_insert(now);
        if e.clock.cycle == 1 {
            initial = energies.balance(0.0);
        }
        for k in 0..2 {
            worst[k] = (0..3).map(|c| (now[k][c] - start[k][c]).abs()).fold(worst[k], f64::max);
        }
        unexplained = unexplained.max(energies.balance(initial).abs() / initial);
    });
    let (p, l) = (0.01, 1.0);
    assert!(worst[0] < 1e-12 * p * 1e2 && worst[1] < 1e-10 * l, "{worst:?}");
    let internal = end.ledger.energies(&end.nodes, &end.blocks).values().internal;
    assert!(internal > 0.01 * initial, "the beams yield: {internal} of {initial}");
    assert!(unexplained < 1e-3, "{unexplained}");
}

/// A weld connects a held node and one with a prescribed velocity, along it or across it. It
/// breaks at its strength and has no force afterwards; under compression it holds. The work
/// until failure is `F^2 L / 2 E A` along and `F^2 L^3 / 6 E I` across if its end turns freely;
/// the displacement of 0.5 mm also stretches it, by 1 % of the work.
#[test]
fn a_weld_breaks_at_its_strength() {
    let section = "section = \"tube\"\nradius = 3.0\n[part.beam.weld]\nnormal = 2.0\nshear = 0.02\n\
                   exponents = [2.0, 1.0]";
    let (area, i) = (std::f64::consts::PI * 9.0, std::f64::consts::PI * 81.0 / 4.0);
    let (along, across) = (LENGTH / (2.0 * E * area), LENGTH.powi(3) / (6.0 * E * i));
    for (velocity, work) in [
        ([0.005, 0.0, 0.0], Some(4.0 * along)),
        ([0.0, 0.02, 0.0], Some(0.02 * 0.02 * across)),
        ([0.0, 0.0, -0.02], Some(0.02 * 0.02 * across)),
        ([-0.005, 0.0, 0.0], None),
    ] {
        let rest = format!(
            "[time]\ndamping = 1.0\ndt_max = 0.05\n[[motion]]\nnodes = \"tip\"\n\
             velocity = {velocity:?}\n"
        );
        let end = run_alone(
            &cantilever(1, &Rotation3::identity(), section, ELASTIC, 80.0, &rest),
            |_| {},
        );
        let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
        let failed = end.blocks.elements[0].record.failed;
        assert_eq!(failed, work.is_some(), "{velocity:?}: {energies:?}");
        if let Some(work) = work {
            assert!(
                (energies.internal / work - 1.0).abs() < 0.02,
                "{velocity:?}: {} {work}",
                energies.internal
            );
            assert!(
                end.nodes.force.iter().all(|f| f[..3] == [0.0; 3]),
                "{velocity:?}: {:?}",
                end.nodes.force
            );
        } else {
            let pressed = 0.5 * E * area * 0.4 * 0.4 / LENGTH;
            assert!(
                (energies.internal / pressed - 1.0).abs() < 0.02,
                "{} {pressed}",
                energies.internal
            );
        }
    }
}

/// A sheet of shells with ribs of beams of all sections hits a wall: the same bits on 1, 2 and 4
/// workers, with forced renewals of the boxes.
#[test]
fn bits_do_not_depend_on_workers() {
    let mut scene = Scene::default();
    let plate = scene.lattice(1, [6, 4], |i, j| [10.0 * i as f64, 10.0 * j as f64, 0.0]);
    let third = scene.node([20.0, 20.0, 300.0]);
    for (i, (rib, j)) in (0..6).flat_map(|i| [(2, 0), (3, 2), (4, 4)].map(|rib| (i, rib))) {
        scene.beam(rib, [plate.at(i, j), plate.at(i + 1, j), third]);
    }
    let part = |id: u32, section: &str| {
        format!("[[part]]\nid = {id}\nmaterial = \"steel\"\n[part.beam]\n{section}\n")
    };
    let text = format!(
        "end_time = 1.0\n{}[output]\nfield_interval = -1.0\n\
         [[material]]\nname = \"steel\"\nlaw = \"j2\"\n\
         density = {RHO:?}\n\
         youngs_modulus = {E:?}\npoisson = 0.3\nhardening = [[0.0, 0.2], [1.0, 0.4]]\n\
         [[part]]\nid = 1\nmaterial = \"steel\"\nthickness = 1.0\n{}{}{}\
         [[wall]]\npoint = [0.0, 0.0, -0.1]\nnormal = [0.4, 0.1, 1.0]\n\
         [[initial_velocity]]\nvelocity = [0.0, 0.0, -20.0]\n",
        scene.mesh_text(),
        part(2, RECTANGLE),
        part(3, "section = \"tube\"\nradius = 2.0\n[part.beam.weld]\nnormal = 0.3\nshear = 0.1"),
        part(4, "section = \"i\"\nheight = 5.0\nwidth = 4.0\nflange = 0.6\nweb = 0.5"),
    );
    let model = model_of(&text, &[]);
    let alone = run_alone(&model, |_| {});
    let broken = alone.blocks.elements.iter().filter(|e| e.record.failed).count();
    assert!((1..18).contains(&broken), "{broken} welds break");
    let serial = run_side_by_side(&model, 1, 700, 0);
    assert!(serial.trouble.is_none(), "{:?} in cycle {}", serial.trouble, serial.pairs.len());
    for (workers, force) in [(2, 0), (4, 0), (2, 7), (4, 11)] {
        let parallel = run_side_by_side(&model, workers, 700, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}

/// A pulled beam fails at the largest principal strain, which is that along it, or at the effective
/// strain, `2/3 (1 + nu)` of it while it is elastic. Its strain is summed up over the present
/// length or that of the start: 1 % here.
#[test]
fn beams_erode_at_a_strain() {
    let limit = 0.01;
    for (key, share) in
        [("erosion_major_strain", 1.0), ("erosion_effective_strain", 2.0 / 3.0 * 1.3)]
    {
        let law = format!("{ELASTIC}\n{key} = {:?}", share * limit);
        let rest = "[[motion]]\nnodes = \"tip\"\nvelocity = [0.2, 0.0, 0.0]\n";
        let model = cantilever(1, &Rotation3::identity(), RECTANGLE, &law, 6.0, rest);
        let mut last = 0.0;
        let end = run_alone(&model, |e| {
            if !e.blocks.elements[0].record.failed {
                last = e.nodes.x[1][0] / LENGTH - 1.0;
            }
        });
        assert!(end.blocks.elements[0].record.failed, "{key}");
        assert!((last / limit - 1.0).abs() < 0.015, "{key}: {last}");
    }
}

/// Anisotropy and strains of failure of sheets have no meaning in beams: each key is refused.
#[test]
fn parameters_of_sheets_are_refused_in_beams() {
    for key in ["lankford", "erosion_thinning"] {
        let text = format!(
            "title = \"beam\"\nunits = \"mm, ms, kg\"\nend_time = 1.0\n[mesh]\n\
             nodes = [[1, 0, 0, 0], [2, 10, 0, 0], [3, 0, 10, 0]]\nbeams = [[1, 1, 1, 2, 3]]\n\
             [[material]]\nname = \"steel\"\nlaw = \"j2\"\ndensity = {RHO:?}\n\
             youngs_modulus = {E:?}\npoisson = 0.3\nyield_stress = 0.2\n{key} = 1.5\n\
             [[part]]\nid = 1\nmaterial = \"steel\"\n[part.beam]\n{RECTANGLE}\n"
        );
        let report = read_text("job.toml".into(), text, &[]).err().expect(key).to_string();
        assert!(
            report.contains(&format!("{key} is not for beams and trusses, which part 1 has")),
            "{report}"
        );
    }
}

/// A bolt of one beam between two free blocks of beams is tightened to a stress of 0.2 and then
/// released to the elastic law. Its axial force is the stress of the curve times its area to the
/// last digits, whatever the strain, and the forces of the bolt change no momentum. After the end
/// of the curve the stress follows the strain from there: E times its change.
#[test]
fn a_bolt_reaches_its_preload_and_keeps_momentum() {
    let (end, stress) = (0.02, 0.2);
    let mut scene = Scene::default();
    let nodes: Vec<u32> = (0..6).map(|i| scene.node([10.0 * f64::from(i), 0.0, 0.0])).collect();
    let third = scene.node([0.0, 50.0, 0.0]);
    for (k, ends) in nodes.windows(2).enumerate() {
        scene.beam(if k == 2 { 2 } else { 1 }, [ends[0], ends[1], third]);
    }
    let beam = |id: u32, more: &str| {
        format!("[[part]]\nid = {id}\nmaterial = \"steel\"\n[part.beam]\n{RECTANGLE}\n{more}")
    };
    let job = |bending: &str| {
        let preload =
            format!("preload = [[0.0, 0.0], [0.01, {stress}], [{end}, {stress}]]\n{bending}");
        let text = format!(
            "end_time = 0.04\n{}[output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\n\
             density = {RHO:?}\nyoungs_modulus = {E:?}\npoisson = 0.3\n{ELASTIC}\n{}{}",
            scene.mesh_text(),
            beam(1, ""),
            beam(2, &preload)
        );
        model_of(&text, &[])
    };
    for bending in ["", "preload_bending = true\n"] {
        let model = job(bending);
        let (mut worst, mut drift, mut free, mut freed) = (0.0f64, 0.0f64, 0.0f64, 0);
        let (mut length, mut base) = (10.0, None);
        run_alone(&model, |e| {
            // The stress is that of the start of the step, with the length there.
            let (time, (next, now)) = (e.clock.time - e.clock.last_dt, bolt(e));
            if base.is_none() {
                let asked = stress * (time / 0.01).min(1.0);
                worst = worst.max((now - asked).abs());
                base = (time >= end).then_some(length);
            } else if let Some(base) = base {
                free = free.max((now - stress - E * (length - base) / 10.0).abs());
                freed += 1;
            }
            length = next;
            drift = drift.max(momentum(&e.nodes).0[0].abs());
        });
        assert!(worst < 1e-9 * stress, "{bending}: {worst}");
        assert!(free < 1e-9 * stress && freed > 5, "{bending}: {free} in {freed} steps");
        // The mass of the blocks times the speed of their ends is some 1e-3.
        assert!(drift < 1e-15, "{bending}: {drift}");
    }
    let model = job("");
    let one = run_side_by_side(&model, 1, 1_000_000, 0);
    for workers in [2, 3] {
        assert_eq!(run_side_by_side(&model, workers, 1_000_000, 0).digest(), one.digest());
    }
    let count = one.pairs.len() as u64;
    for part in [5, 15] {
        let plan = Plan { at: count * part / 20, cycles: 1_000_000, workers: [2, 3] };
        assert_eq!(run_interrupted(&model, plan), one.digest(), "{plan:?}");
    }
}

/// Returns the length of the element of part 2 and its axial stress.
fn bolt(e: &Engine) -> (f64, f64) {
    let [a, b] = [2, 3].map(|n| e.nodes.x[n]);
    let length = (0..3).map(|c| (b[c] - a[c]).powi(2)).sum::<f64>().sqrt();
    (length, axial_stress(e, 2))
}

/// Returns the axial stress of the element of a part of beams along x.
fn axial_stress(e: &Engine, part: u32) -> f64 {
    let part_of = |first: usize| e.blocks.elements[first].record.part as usize;
    let mut blocks = e.blocks.blocks.iter();
    let block = blocks.find(|b| e.settings.parts[part_of(b.first)].id == part).expect("its block");
    block.element.fields(block.state(0), &[[0.0; 3], [1.0, 0.0, 0.0]]).stress[0]
}
