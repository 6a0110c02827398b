//! Bodies that start inside each other's contact thickness: contact leaves them unchanged and
//! does not create energy. Units mm, ms, kg.

use crumple::input::job::Model;
use crumple_tests::program::{Ended, crumple_with, run};
use crumple_tests::{model_of, run_alone};
use crumple_verification::scene::Scene;
use crumple_worker::engine::Engine;
use std::ops::ControlFlow;

/// Adds a sheet of `n[0]` by `n[1]` shells, row by row; `place` maps the unit square to positions.
fn sheet(scene: &mut Scene, part: u32, n: [usize; 2], place: impl Fn(f64, f64) -> [f64; 3]) {
    let first = scene.count() + 1;
    for (j, i) in (0..=n[1]).flat_map(|j| (0..=n[0]).map(move |i| (j, i))) {
        scene.node(place(i as f64 / n[0] as f64, j as f64 / n[1] as f64));
    }
    let id = |i: usize, j: usize| first + (j * (n[0] + 1) + i) as u32;
    for (j, i) in (0..n[1]).flat_map(|j| (0..n[0]).map(move |i| (j, i))) {
        scene.shell(part, &[id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]);
    }
}

/// Returns the job with the parts 1 to `parts`, 1 mm thick.
fn model(scene: &Scene, parts: u32, end: f64, contact: &str, rest: &str) -> Model {
    let part = |id| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\nthickness = 1.0\n");
    let parts: String = (1..=parts).map(part).collect();
    let text = format!(
        "end_time = {end:?}\n{}[output]\nfield_interval = -1.0\n\
         [[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
         youngs_modulus = 207.0\npoisson = 0.3\n\
         {parts}[contact]\n{contact}\n{rest}",
        scene.mesh_text()
    );
    model_of(&text, &[])
}

const LAWS: [&str; 4] = [
    "law = \"lagrange\"",
    "law = \"kinematic\"",
    "law = \"penalty\"",
    "law = \"penalty\"\npenalty_form = \"stiffness\"\npenalty_scale = 1.0",
];

/// Two plates start half a thickness apart instead of a whole one, and at an angle so that no
/// nodes match: they stay at rest.
#[test]
fn plates_at_rest_inside_each_other_stay_at_rest() {
    for law in LAWS {
        for tilt in [0.0, 0.03] {
            let mut scene = Scene::default();
            sheet(&mut scene, 1, [6, 6], |x, y| [30.0 * x, 30.0 * y, 0.0]);
            sheet(&mut scene, 2, [5, 4], |x, y| {
                [3.0 + 22.0 * x + 4.0 * y, 2.0 + 24.0 * y, 0.5 + tilt * 22.0 * x]
            });
            let model = model(&scene, 2, 3.0, law, "");
            let (mut pairs, mut kinetic) = (0, 0.0f64);
            let end = run_alone(&model, |e: &Engine| {
                pairs = pairs.max(e.contact.as_ref().unwrap().owned_pairs().count());
                kinetic =
                    kinetic.max(e.ledger.energies(&e.nodes, &e.blocks).values().kinetic.abs());
            });
            let energies = end.ledger.energies(&end.nodes, &end.blocks).values();
            let work = energies.contact.abs() + energies.starting.abs();
            assert!(
                end.clock.cycle > 2000 && pairs > 20,
                "{law}: {} cycles, {pairs} pairs",
                end.clock.cycle
            );
            assert_eq!((kinetic, work), (0.0, 0.0), "{law}, tilt {tilt}: no forces and no motion");
        }
    }
}

/// A panel whose rim is folded back to 0.6 of a thickness, like a hem, flies, spins and
/// vibrates: contact may not drive it.
///
/// A defect that gives penetrations of the start back slowly makes contact work that grows with the
/// square of time: 0.03 of the kinetic energy in this flight, which should be 6e-9. The bound is
/// that of 1e-3 in a flight of 6 ms, 7e-6, rounded down.
#[test]
fn a_folded_panel_in_flight_gains_nothing() {
    for law in LAWS {
        let mut scene = Scene::default();
        // 40 up, the fold of 0.6, 15 down on the other side.
        let fold = |s: f64| match s * 56.0 {
            s if s <= 40.0 => [s, 0.0],
            s if s <= 41.0 => [40.0, 0.6 * (s - 40.0)],
            s => [40.0 - (s - 41.0), 0.6],
        };
        sheet(&mut scene, 1, [56, 8], |x, y| [fold(x)[0], 40.0 * y, fold(x)[1]]);
        let rest = "[[initial_velocity]]\nvelocity = [3.0, 0.0, 2.0]\nspin = [0.1, 0.3, 0.05]\n\
                    centre = [20.0, 20.0, 0.0]\n";
        let model = model(&scene, 1, 0.5, &format!("{law}\nthickness_limit = 0.0"), rest);
        let (mut first, mut most, mut work) = (None, 0.0f64, 0.0f64);
        run_alone(&model, |e: &Engine| {
            let now = e.ledger.energies(&e.nodes, &e.blocks).values();
            first.get_or_insert(now.kinetic);
            most = most.max(now.kinetic);
            work = work.max(now.contact);
        });
        let first = first.unwrap();
        assert!(
            work < 5e-6 * first && most < (1.0 + 5e-6) * first,
            "{law}: work {work}, {most} of {first}"
        );
    }
}

/// Plates start half a thickness apart, and one moves towards the other. The work at pairs with
/// an initial penetration is a separate ledger entry, and they return no more energy than they
/// took. Plates with an initial distance have no such work.
#[test]
fn work_at_starting_penetrations_is_booked_apart() {
    for law in LAWS {
        for (gap, inside) in [(-0.5, true), (0.05, false)] {
            let mut scene = Scene::default();
            sheet(&mut scene, 1, [6, 6], |x, y| [30.0 * x, 30.0 * y, 0.0]);
            sheet(&mut scene, 2, [5, 4], |x, y| {
                [3.0 + 22.0 * x + 4.0 * y, 2.0 + 24.0 * y, 1.0 + gap]
            });
            let model = model(&scene, 2, 0.4, law, "");
            let (mut taken, mut given, mut contact, mut kinetic) = (0.0f64, 0.0f64, 0.0f64, 0.0);
            let ended = crumple::run::embedded::run_alone(&model, |e: &mut Engine| {
                if e.clock.cycle == 0 {
                    let upper = (0..e.nodes.local_count).filter(|&n| e.nodes.x0[n][2] > 0.25);
                    upper.collect::<Vec<_>>().into_iter().for_each(|n| e.nodes.v[n][2] = -1.0);
                    return ControlFlow::Continue(());
                }
                let now = e.ledger.energies(&e.nodes, &e.blocks).values();
                kinetic = if e.clock.cycle == 1 { now.kinetic } else { kinetic };
                (taken, given) = (taken.min(now.starting), given.max(now.starting));
                contact = contact.min(now.contact);
                ControlFlow::Continue(())
            });
            assert!(ended.is_ok_and(|ended| ended.trouble.is_none()), "{law}");
            assert!(
                contact < -0.01 * kinetic,
                "{law}, gap {gap}: there is contact, {contact} of {kinetic}"
            );
            if inside {
                assert!(
                    taken < 0.5 * contact,
                    "{law}: {taken} of {contact}: all pairs are initial penetrations"
                );
                assert!(given < 1e-3 * kinetic, "{law}: {given} of {kinetic}");
            } else {
                assert_eq!((taken, given), (0.0, 0.0), "{law}");
            }
        }
    }
}

/// Undamped springs that are too stiff for the step give energy to bars, from a scale of 1.72 on:
/// from 1 % on the run warns, at 10 % it ends.
#[test]
fn a_contact_that_creates_energy_is_warned_of_and_ends_the_run() {
    let bars = |scale: f64, more: &[&str]| {
        let sets = [
            "law=penalty",
            "penalty_cap=false",
            "penalty_damping=0",
            &format!("penalty_scale={scale}"),
        ];
        let sets = sets.map(|set| format!("contact.{set}"));
        let set = sets.iter().flat_map(|set| ["--set", set]);
        let all = ["run", "cases/bars"].into_iter().chain(set).chain(more.iter().copied());
        run(crumple_with(&all.collect::<Vec<_>>()))
    };
    let created = |ended: &Ended| ended.summary()["energy"]["contact_created"].as_f64().unwrap();
    let warned_of_energy = |ended: &Ended| ended.said().contains("contact has created");
    let stable = bars(1.5, &[]).with_code(0);
    assert!(created(&stable) < 0.01 && !warned_of_energy(&stable), "{}", created(&stable));
    let warned = bars(1.8, &["--end-time", "0.025"]).with_code(0);
    assert!(
        (0.01..0.1).contains(&created(&warned)) && warned_of_energy(&warned),
        "{}",
        created(&warned)
    );
    let stopped = bars(1.8, &[]).with_code(3);
    assert!(created(&stopped) > 0.1 && warned_of_energy(&stopped), "{}", created(&stopped));
    let reason = stopped.summary()["reason"].as_str().unwrap().to_string();
    assert!(reason.contains("contact has created"), "{reason}");
}
