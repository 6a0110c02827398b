//! Meshes whose ids lie all over them are numbered anew inside: the same answer as in rows, the same on any number of workers,
//! and the user's ids in all that is asked for and written. Units mm, ms, kg.

use crumple::field_file::{Piece, pieces_of_folder};
use crumple_proto::mesh::Mesh;
use crumple_tests::program::{crumple_with, run};
use crumple_tests::{case, read, run_side_by_side};
use std::collections::HashMap;
use std::fs;

/// Large enough that not all nodes fit into a cache.
const FINE: &str = "scene.elements=24";
const SHUFFLED: &str = "scene.shuffle=7";

#[test]
fn a_shuffled_tube_is_crushed_as_one_in_rows_on_any_number_of_workers() {
    const CYCLES: u64 = 200;
    let (rows, shuffled) = (read(&case("tube-crush"), &[FINE]), read(&case("tube-crush"), &[FINE, SHUFFLED]));
    assert_eq!(rows.renumbered, None);
    let renumbered = shuffled.renumbered.expect("ids are random");
    assert!(renumbered.before > 1.0 && renumbered.after < 0.2, "{renumbered:?}");

    let one = run_side_by_side(&shuffled, 1, CYCLES, 0);
    for (workers, force_every) in [(2, 0), (3, 40)] {
        let other = run_side_by_side(&shuffled, workers, CYCLES, force_every);
        assert_eq!(one.digest(), other.digest(), "{workers} workers");
    }

    // Sums go in another order: nodes differ by round-off, of a way of 1.4 mm and sides of 2.5 mm.
    let of_rows = run_side_by_side(&rows, 1, CYCLES, 0);
    let there: HashMap<[u64; 3], [f64; 3]> = of_rows.nodes.iter().map(|n| (n.x0.map(f64::to_bits), n.x)).collect();
    let apart = |n: &crumple_proto::partition::NodeRecord| {
        let x = there[&n.x0.map(f64::to_bits)];
        (0..3).fold(0.0f64, |most, c| most.max((n.x[c] - x[c]).abs()))
    };
    let most = one.nodes.iter().map(apart).fold(0.0, f64::max);
    assert_eq!(one.nodes.len(), there.len());
    assert!(most < 1e-9, "{most} mm");
    let moved = one.nodes.iter().map(|n| (n.x[2] - n.x0[2]).abs()).fold(0.0, f64::max);
    assert!(moved > 1.0, "{moved} mm");
}

/// The mesh as a user has it, with its own ids.
fn given() -> Mesh {
    let scene =
        "side = 60\nlength = 300\nelements = 24\ntrigger = 0.5\ntrigger_from = 10\ntrigger_to = 40\nshuffle = 7";
    crumple_cases::generate("tube", &scene.parse().unwrap()).unwrap()
}

#[test]
fn what_is_asked_for_and_what_is_written_has_the_ids_of_the_mesh() {
    let mesh = given();
    let at: HashMap<i64, [f64; 3]> = mesh.nodes.iter().map(|n| (n.id.0 as i64, n.x)).collect();
    let head = &mesh.node_sets["head"];
    let last = mesh.elements.iter().rfind(|e| e.corners().iter().any(|n| head.contains(n))).unwrap();
    let asked = mesh.nodes[4321].id.0;
    let text = fs::read_to_string(case("tube-crush").join("job.toml")).unwrap();
    let more = format!(
        "\n[[output.node]]\nids = [{asked}]\n[[output.section]]\nnodes = \"head\"\nelements = [{}]\n",
        last.id.0
    );
    let there = tempfile::tempdir().unwrap();
    let path = there.path().join("job.toml");
    fs::write(&path, text + &more).unwrap();
    let path = path.to_str().unwrap();
    let sets = ["--set", FINE, "--set", SHUFFLED, "--set", "time.max_cycles=5", "--workers", "2"];
    let ended = run(crumple_with(&[&["run", path, "--quiet"], &sets[..]].concat())).with_code(0);

    let rows = fs::read_to_string(ended.out().join("nodes.csv")).unwrap();
    let first: Vec<&str> = rows.lines().nth(1).expect("a row").split(',').collect();
    let column = |name: &str| rows.lines().next().unwrap().split(',').position(|h| h.starts_with(name)).unwrap();
    assert_eq!(first[column("id")], asked.to_string());
    let x: f64 = first[column("x")].parse().unwrap();
    assert!((x - at[&(asked as i64)][0]).abs() < 1e-8, "{x}");

    let mut corners: HashMap<i64, Vec<i64>> = HashMap::new();
    let step = ended.out().join("fields/step_000000");
    for file in pieces_of_folder(&step) {
        let piece = Piece::read(&file).unwrap();
        let nodes = piece.i64("node_id").unwrap();
        let (points, moved) = (piece.array("Points").unwrap(), piece.array("displacement").unwrap());
        for (n, (x, u)) in nodes.iter().zip(points.chunks(3).zip(moved.chunks(3))) {
            assert!((0..3).all(|c| (x[c] - u[c] - at[n][c]).abs() < 1e-4), "node {n} is at {x:?}");
        }
        let list = piece.array("connectivity").unwrap();
        for (e, four) in piece.i64("element_id").unwrap().into_iter().zip(list.chunks(4)) {
            corners.insert(e, four.iter().map(|&c| nodes[c as usize]).collect());
        }
    }
    assert_eq!(corners.len(), mesh.elements.len());
    for e in &mesh.elements {
        let own: Vec<i64> = e.corners().iter().map(|n| n.0 as i64).collect();
        assert_eq!(corners[&(e.id.0 as i64)], own, "element {}", e.id);
    }
}

#[test]
fn check_says_so_and_an_exported_deck_has_the_ids_of_the_mesh() {
    let sets = ["cases/tube-crush", "--set", FINE, "--set", SHUFFLED];
    let said = run(crumple_with(&[&["check"], &sets[..]].concat())).with_code(0).said();
    assert!(said.contains("numbering    anew inside"), "{said}");
    let there = tempfile::tempdir().unwrap();
    let deck = there.path().join("tube.k");
    let out = ["--out", deck.to_str().unwrap()];
    run(crumple_with(&[&["export-deck"], &sets[..], &out].concat())).with_code(0);
    let (of_deck, of_job) = (read(&deck, &[]), read(&case("tube-crush"), &[FINE, SHUFFLED]));
    assert_eq!(of_deck.mesh.elements, of_job.mesh.elements);
    assert_eq!(of_deck.mesh.nodes, of_job.mesh.nodes);
}
