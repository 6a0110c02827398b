//! Element deletion: failed elements leave the contact surface, and the faces behind them are in
//! contact from then on, whichever workers own either.

use crumple::input::job::Model;
use crumple_tests::brittle::{SIDE, rod_on_plate, rod_on_plate_with};
use crumple_tests::{model_of, run_alone, run_side_by_side};
use crumple_verification::scene::{Cut, Scene};

/// The rod goes through the brittle layer and rebounds from the lower one, whose faces are
/// exposed only after the upper layer has failed. Without these faces it would fall through the
/// whole plate.
#[test]
fn what_was_behind_a_failed_element_is_touched() {
    let model = rod_on_plate(2);
    let top = |e: &crumple_worker::engine::Engine| {
        e.contact.as_ref().map_or(0, |c| c.surface.segments.len())
    };
    let (mut at_start, mut lowest, mut failed) = (None, f64::INFINITY, 0);
    let end = run_alone(&model, |e| {
        at_start.get_or_insert(top(e));
        let rod = e.nodes.id.iter().zip(&e.nodes.x).filter(|(id, _)| id.0 > 108);
        lowest = rod.fold(lowest, |low: f64, (_, x)| low.min(x[2]));
        failed = e.blocks.elements.iter().filter(|b| b.record.failed).count();
    });
    assert!(
        failed > 0 && top(&end) > at_start.unwrap(),
        "{failed} failed: each exposes up to five faces"
    );
    // The upper face of the lower layer starts at 5 mm and deflects elastically, by well below a
    // tenth of its height.
    assert!(lowest < 2.0 * SIDE - 2.0, "the rod must pass through the upper layer: {lowest}");
    assert!(lowest > SIDE - 0.5, "the lower layer must stop the rod: {lowest}");
    let speed = end
        .nodes
        .id
        .iter()
        .zip(&end.nodes.v)
        .filter(|(id, _)| id.0 > 108)
        .map(|(_, v)| v[2])
        .sum::<f64>()
        / 20.0;
    assert!(speed > 0.0, "the rod rebounds: {speed}");
}

/// Surfaces, and with them the bits, do not depend on the owners of failed elements and of those
/// behind them.
#[test]
fn deletion_gives_the_same_bits_on_any_number_of_workers() {
    let interface = "[[contact.interface]]\nname = \"rod\"\nparts = [3]\nfriction = 0.3";
    let cases = [
        (2, ""),
        (4, ""),
        (4, "edges = true\nfriction = 0.2"),
        (4, "law = \"mortar\""),
        (4, "surface = \"smooth\""),
        (4, "law = \"penalty\"\nfriction = 0.2"),
        (4, interface),
    ];
    for (layers, contact) in cases {
        let model = rod_on_plate_with(layers, Cut::Whole, contact);
        let alone = run_side_by_side(&model, 1, 400, 0);
        assert_eq!(alone.trouble, None);
        for (workers, every) in [(2, 0), (3, 7), (5, 0), (8, 0)] {
            let many = run_side_by_side(&model, workers, 400, every);
            let differs = many.pairs.iter().zip(&alone.pairs).position(|(a, b)| a != b);
            let what = format!("{layers} layers, {workers} workers, {contact}");
            assert_eq!(differs, None, "{what}: cycle in which pairs differ");
            assert_eq!(many.digest(), alone.digest(), "{what}");
        }
    }
}

/// Returns a job with a sheet of 8 by 8 shells above another one; a node of the upper sheet
/// moves fast within it, through its neighbours.
fn shot_sheet(inverted: &str, element: &str) -> Model {
    const N: usize = 8;
    let mut scene = Scene::default();
    for sheet in 0..2 {
        let (first, z) = (scene.count() + 1, 3.0 * sheet as f64);
        let id = |i: usize, j: usize| first + (j * (N + 1) + i) as u32;
        for (i, j) in (0..=N).flat_map(|j| (0..=N).map(move |i| (i, j))) {
            scene.node([SIDE * i as f64, SIDE * j as f64, z]);
        }
        for (i, j) in (0..N).flat_map(|j| (0..N).map(move |i| (i, j))) {
            scene.shell(sheet + 1, &[id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)]);
        }
    }
    let shot = (N + 1) * (N + 1) + 1 + 4 * (N + 1) + 4;
    scene.set_named("shot", &[shot as u32]);
    let text = format!(
        r#"
        title = "A node that is shot through its neighbours"
        units = "mm, ms, kg"
        end_time = 0.03
        {}
        [[material]]
        name = "steel"
        law = "j2"
        density = 7.85e-6
        youngs_modulus = 210.0
        poisson = 0.3
        yield_stress = 0.25
        [[part]]
        id = 1
        name = "lower"
        material = "steel"
        thickness = 1.0
        inverted = "{inverted}"
        element = "{element}"
        [[part]]
        id = 2
        name = "upper"
        material = "steel"
        thickness = 1.0
        inverted = "{inverted}"
        element = "{element}"
        [[initial_velocity]]
        nodes = "shot"
        velocity = [6000.0, 300.0, -100.0]
        [contact]
        "#,
        scene.mesh_text(),
    );
    model_of(&text, &[])
}

/// Returns a job with a block of solids whose upper middle node is shot into it, above a plate.
fn shot_block(cut: Cut, inverted: &str) -> Model {
    const N: usize = 4;
    let mut scene = Scene::default();
    scene.cut(cut);
    let id = |i: usize, j: usize, k: usize| 1 + ((k * (N + 1) + j) * (N + 1) + i) as u32;
    for k in 0..=N {
        for j in 0..=N {
            (0..=N).for_each(|i| _ = scene.node([i, j, k].map(|c| SIDE * c as f64)));
        }
    }
    for k in 0..N {
        for j in 0..N {
            for i in 0..N {
                let face = |k| [id(i, j, k), id(i + 1, j, k), id(i + 1, j + 1, k), id(i, j + 1, k)];
                let (low, high) = (face(k), face(k + 1));
                let corner = |c: usize| if c < 4 { low[c] } else { high[c - 4] };
                scene.solid(1, std::array::from_fn(corner));
            }
        }
    }
    let plate = |i: usize, j: usize| [SIDE * i as f64, SIDE * j as f64, -30.0];
    scene.lattice(2, [N, N], plate);
    scene.set_named("shot", &[id(N / 2, N / 2, N)]);
    let text = format!(
        r#"
        title = "A node that is shot into a block"
        units = "mm, ms, kg"
        end_time = 0.01
        {}
        [time]
        dt_min_ratio = 0.3
        [[material]]
        name = "steel"
        law = "j2"
        density = 7.85e-6
        youngs_modulus = 210.0
        poisson = 0.3
        yield_stress = 0.25
        [[part]]
        id = 1
        material = "steel"
        inverted = "{inverted}"
        [[part]]
        id = 2
        material = "steel"
        thickness = 1.0
        [[initial_velocity]]
        nodes = "shot"
        velocity = [300.0, 200.0, -40000.0]
        [contact]
        "#,
        scene.mesh_text(),
    );
    model_of(&text, &[])
}

/// Solids that are inverted, or whose step falls too far, end the run. If their part permits
/// deletion, the run goes on without them, with the same bits on any number of workers.
#[test]
fn collapsed_solids_end_the_run_or_leave_it() {
    for cut in [Cut::Whole, Cut::Tetrahedra] {
        let stopped = run_side_by_side(&shot_block(cut, "stop"), 1, 400, 0);
        assert!(stopped.trouble.is_some(), "{}: the scene must lose a solid", cut.name());
        let model = shot_block(cut, "delete");
        let mut named = 0;
        let end = run_alone(&model, |e| named = e.inverted.len());
        let all = &end.blocks.elements;
        let failed: Vec<_> = all.iter().filter(|e| e.record.failed).map(|e| e.record.id).collect();
        assert!(!failed.is_empty() && 4 * failed.len() < all.len(), "{}", failed.len());
        assert_eq!(named, failed.len(), "{}: each is named", cut.name());
        let alone = run_side_by_side(&model, 1, 400, 0);
        assert_eq!(alone.trouble, None, "{}", cut.name());
        for (workers, every) in [(2, 0), (3, 7)] {
            let many = run_side_by_side(&model, workers, 400, every);
            assert_eq!(many.digest(), alone.digest(), "{}, {workers} workers", cut.name());
        }
    }
}

/// An inverted shell ends the run. If its part permits deletion, it leaves the contact surface
/// and the sums instead, whichever worker owns it.
#[test]
fn inverted_shells_end_the_run_or_leave_it() {
    for element in ["belytschko_tsay", "stabilised_quad", "fully_integrated_quad"] {
        let stopped = run_side_by_side(&shot_sheet("stop", element), 1, 400, 0);
        assert!(stopped.trouble.is_some(), "{element}: the scene must invert a shell");

        let model = shot_sheet("delete", element);
        let segments = |e: &crumple_worker::engine::Engine| {
            e.contact.as_ref().map_or(0, |c| c.surface.segments.len())
        };
        let (mut at_start, mut named) = (None, 0);
        let end = run_alone(&model, |e| {
            at_start.get_or_insert(segments(e));
            named = e.inverted.len();
        });
        let failed: Vec<_> =
            end.blocks.elements.iter().filter(|e| e.record.failed).map(|e| e.record.id).collect();
        assert!(
            !failed.is_empty() && failed.len() < 16,
            "{element}: only some shells around the node, {}",
            failed.len()
        );
        assert_eq!(
            segments(&end),
            at_start.unwrap() - failed.len(),
            "{element}: each failed shell was one segment"
        );
        assert_eq!(named, failed.len(), "{element}: each failed shell is named");
        assert!(failed.iter().all(|&id| end.blocks.is_deleted(id)));

        let alone = run_side_by_side(&model, 1, 400, 0);
        assert_eq!(alone.trouble, None, "{element}");
        for (workers, every) in [(2, 0), (4, 7)] {
            let many = run_side_by_side(&model, workers, 400, every);
            assert_eq!(many.digest(), alone.digest(), "{element}, {workers} workers");
        }
    }
}
