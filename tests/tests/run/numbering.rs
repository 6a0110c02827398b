//! Meshes with shuffled ids are renumbered internally: the same result as with ids in rows, the
//! same on any number of workers, and the user's ids in requests and output. Units mm, ms, kg.

use crumple::results::field_file::{PieceArrays, pieces_of_folder};
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{Mesh, MeshElement};
use crumple_proto::partition::NodeRecord;
use crumple_tests::program::{Ended, crumple_with, run};
use crumple_tests::{case, model_of, read, run_side_by_side};
use crumple_verification::scene::{Elastic, Scene};
use std::collections::HashMap;
use std::fs;

/// So large that not all nodes fit into a cache.
const FINE: &str = "scene.elements=24";
const SHUFFLED: &str = "scene.shuffle=7";

#[test]
fn a_shuffled_tube_is_crushed_as_one_in_rows_on_any_number_of_workers() {
    const CYCLES: u64 = 200;
    let (rows, shuffled) =
        (read(&case("tube-crush"), &[FINE]), read(&case("tube-crush"), &[FINE, SHUFFLED]));
    assert_eq!(rows.renumbered, None);
    let renumbered = shuffled.renumbered.expect("ids are random");
    assert!(renumbered.before > 1.0 && renumbered.after < 0.2, "{renumbered:?}");

    let one = run_side_by_side(&shuffled, 1, CYCLES, 0);
    for (workers, force_every) in [(2, 0), (3, 40)] {
        let other = run_side_by_side(&shuffled, workers, CYCLES, force_every);
        assert_eq!(one.digest(), other.digest(), "{workers} workers");
    }

    // The order of sums differs, so nodes differ by round-off, for a displacement of 1.4 mm and
    // sides of 2.5 mm.
    let of_rows = run_side_by_side(&rows, 1, CYCLES, 0);
    let there: HashMap<[u64; 3], [f64; 3]> =
        of_rows.nodes.iter().map(|n| (n.x0.map(f64::to_bits), n.x)).collect();
    let apart = |n: &NodeRecord| {
        let x = there[&n.x0.map(f64::to_bits)];
        (0..3).fold(0.0f64, |most, c| most.max((n.x[c] - x[c]).abs()))
    };
    let most = one.nodes.iter().map(apart).fold(0.0, f64::max);
    assert_eq!(one.nodes.len(), there.len());
    assert!(most < 1e-9, "{most} mm");
    let moved = one.nodes.iter().map(|n| (n.x[2] - n.x0[2]).abs()).fold(0.0, f64::max);
    assert!(moved > 1.0, "{moved} mm");
}

/// Returns a job with colliding plates, a fin tied to one of them by its foot and to one node by
/// its top, and a rigid plate on a spring. `node` maps the numbers of nodes, from 1, to ids,
/// `shell` those of shells.
fn joined(node: impl Fn(u32) -> u32, shell: impl Fn(u32) -> u32) -> String {
    let mut scene = Scene::new(1.0).in_units("mm, ms, kg");
    // Part, quads along both sides, and the position of node (i, j); rows go along i.
    type At = fn(f64, f64) -> [f64; 3];
    let plates: [(u32, [usize; 2], At); 4] = [
        (1, [80, 80], |i, j| [1.25 * i, 1.25 * j, 0.0]),
        (2, [20, 20], |i, j| [2.0 * i + 45.37, 2.0 * j + 45.61, 1.3 + 0.02 * i + 0.013 * j]),
        (3, [10, 5], |i, j| [2.0 * i + 11.0, 20.5, 2.0 * j]),
        (4, [5, 5], |i, j| [2.0 * i + 110.0, 2.0 * j, 0.0]),
    ];
    scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: 7.85e-6 });
    let [large, falling, fin, end] = plates.map(|(part, [a, b], at)| {
        scene.part(part, "steel", 1.0, "element = \"belytschko_tsay\"");
        scene.lattice(part, [b, a], |j, i| at(i as f64, j as f64))
    });
    scene.spring(5, [large.at(0, 80), end.at(0, 0)]);
    scene.set_named("foot", &fin.row(0));
    scene.set_named("top", &fin.row(5)[1..]);
    scene.add(&format!(
        "[[part]]\nid = 5\n[part.spring]\nstiffness = 0.5\n\
         [[rigid]]\nname = \"end\"\nparts = [4]\n\
         [[tie]]\nnodes = \"foot\"\nparts = [1]\n\
         [[tie]]\nnodes = \"top\"\nnode = {}",
        node(fin.at(5, 0))
    ));
    scene.fix(&large.row(0), "x y z");
    scene.start(falling.all(), [0.0, 0.0, -20.0], [0.0; 3]);
    scene.start(end.all(), [30.0, 5.0, 0.0], [0.0; 3]);
    scene.renumber(node, |n| if n <= SHELLS { shell(n) } else { 9999 });
    scene.text("Joined plates")
}

const COUNT: u32 = 81 * 81 + 21 * 21 + 11 * 6 + 6 * 6;
const SHELLS: u32 = 80 * 80 + 20 * 20 + 10 * 5 + 5 * 5;

/// Shuffled ids compared with ids in rows: nodes differ by round-off, for a displacement of 1
/// mm. In contact, ids determine the order of pairs and the choice between two faces at their
/// common edge; the effect is 3e-6 mm here.
#[test]
fn contact_ties_springs_and_rigid_bodies_go_along() {
    const CYCLES: u64 = 150;
    let number = |n: u32| n;
    let node = |n: u32| 1 + (n - 1) * 1009 % COUNT;
    let shell = |n: u32| 1 + (n - 1) * 1847 % SHELLS;
    for (rest, tolerance) in [("", 1e-9), ("[contact]\nfriction = 0.1\n", 1e-5)] {
        let models =
            [joined(number, number), joined(node, shell)].map(|text| model_of(&(text + rest), &[]));
        assert_eq!(models.each_ref().map(|model| model.renumbered.is_some()), [false, true]);
        let [of_rows, one] = models.each_ref().map(|model| run_side_by_side(model, 1, CYCLES, 0));
        let three = run_side_by_side(&models[1], 3, CYCLES, 40);
        assert_eq!(one.digest(), three.digest(), "{rest}");
        assert_eq!(one.pairs.iter().any(|pairs| !pairs.is_empty()), !rest.is_empty());
        let by_id = |nodes: &[NodeRecord]| -> HashMap<u64, NodeRecord> {
            nodes.iter().map(|n| (n.id.label(), *n)).collect()
        };
        let [of_rows, one] = [of_rows, one].map(|trace| by_id(&trace.nodes));
        assert_eq!([of_rows.len(), one.len()], [COUNT as usize; 2]);
        let apart =
            |(n, c): (u32, usize)| (of_rows[&n.into()].x[c] - one[&node(n).into()].x[c]).abs();
        let most =
            (1..=COUNT).flat_map(|n| [0, 1, 2].map(|c| (n, c))).map(apart).fold(0.0, f64::max);
        assert!(most < tolerance, "{most} mm, {rest}");
        let moved = one.values().map(|n| (n.x[2] - n.x0[2]).abs()).fold(0.0, f64::max);
        assert!(moved > 0.3, "{moved} mm");
    }
}

/// Asserts that values are equal within a millionth of the largest.
fn assert_near(a: &[f64], b: &[f64], what: &str) {
    let largest = a.iter().fold(0.0f64, |m, x| m.max(x.abs()));
    assert_eq!(a.len(), b.len(), "{what}");
    for (a, b) in a.iter().zip(b) {
        assert!((a - b).abs() <= 1e-6 * largest, "{what}: {a} and {b} of {largest}");
    }
}

/// Returns the mesh of the user, with the original ids.
fn given(shuffle: u32) -> Mesh {
    let scene = format!(
        "side = 60\nlength = 300\nelements = 24\ntrigger = 0.5\ntrigger_from = 10\n\
         trigger_to = 40\nshuffle = {shuffle}"
    );
    crumple_cases::generate("tube", &scene.parse().unwrap()).unwrap()
}

/// Runs some cycles of a job that requests histories of nodes and of elements by their ids.
fn asked_for(shuffle: u32, nodes: &[u64], elements: &[u64]) -> Ended {
    let text = fs::read_to_string(case("tube-crush").join("job.toml")).unwrap();
    let more = format!(
        "\n[[output.node]]\nids = {nodes:?}\n[[output.section]]\nnodes = \"head\"\n\
         elements = {elements:?}\n"
    );
    let there = tempfile::tempdir().unwrap();
    let path = there.path().join("job.toml");
    fs::write(&path, text + &more).unwrap();
    let (path, shuffle) = (path.to_str().unwrap(), format!("scene.shuffle={shuffle}"));
    let sets = ["--set", FINE, "--set", &shuffle, "--set", "time.max_cycles=300", "--workers", "2"];
    run(crumple_with(&[&["run", path, "--quiet"], &sets[..]].concat())).with_code(0)
}

/// Returns the rows of a history: words, then numbers.
fn rows(ended: &Ended, name: &str, words: usize) -> Vec<(Vec<String>, Vec<f64>)> {
    let text = fs::read_to_string(ended.out().join(name)).unwrap();
    let row = |line: &str| {
        let fields: Vec<&str> = line.split(',').collect();
        let numbers = fields[words..].iter().map(|f| f.parse().unwrap()).collect();
        (fields[1..words].iter().map(|f| f.to_string()).collect(), numbers)
    };
    text.lines().skip(1).map(row).collect()
}

#[test]
fn what_is_asked_for_and_what_is_written_has_the_ids_of_the_mesh() {
    // The same nodes and elements by their ids in either mesh.
    let (in_rows, mesh) = (given(0), given(7));
    let place = |mesh: &Mesh, id: NodeId| mesh.nodes[id.0 as usize - 1].x.map(f64::to_bits);
    let shuffled: HashMap<[u64; 3], u64> =
        mesh.nodes.iter().map(|n| (n.x.map(f64::to_bits), n.id.0)).collect();
    let of_nodes: HashMap<Vec<u64>, u64> =
        mesh.elements.iter().map(|e| (e.corners().iter().map(|n| n.0).collect(), e.id.0)).collect();
    let nodes = [4321, 17, 9000, 500];
    let there = nodes.map(|n| shuffled[&place(&in_rows, NodeId(n))]);
    let head = &in_rows.node_sets["head"];
    let at_head = in_rows.elements.iter().filter(|e| e.corners().iter().any(|n| head.contains(n)));
    let elements: Vec<&MeshElement> = at_head.step_by(3).collect();
    let ids: Vec<u64> = elements.iter().map(|e| e.id.0).collect();
    let corners = |e: &&MeshElement| {
        e.corners().iter().map(|&n| shuffled[&place(&in_rows, n)]).collect::<Vec<_>>()
    };
    let shuffled_ids: Vec<u64> = elements.iter().map(|e| of_nodes[&corners(e)]).collect();
    let (one, ended) = (asked_for(0, &nodes, &ids), asked_for(7, &there, &shuffled_ids));

    let mut sorted = there;
    sorted.sort_unstable();
    let mut written = rows(&ended, "nodes.csv", 3);
    written.retain(|row| row.0[0] != "head"); // the job itself asks for its head
    let written_ids: Vec<u64> = written[..4].iter().map(|r| r.0[1].parse().unwrap()).collect();
    assert_eq!(written_ids, sorted, "by ascending id");
    let histories = |ended: &Ended, ids: [u64; 4]| {
        let all = rows(ended, "nodes.csv", 3);
        ids.map(|id| {
            all.iter()
                .filter(|r| r.0[1] == id.to_string())
                .map(|r| r.1[..6].to_vec())
                .collect::<Vec<_>>()
        })
    };
    let numbers = |of: [Vec<Vec<f64>>; 4]| of.into_iter().flatten().flatten().collect::<Vec<f64>>();
    assert_near(&numbers(histories(&one, nodes)), &numbers(histories(&ended, there)), "nodes");
    let section = |ended: &Ended| {
        rows(ended, "sections.csv", 2).into_iter().flat_map(|r| r.1[..3].to_vec()).collect()
    };
    let (ours, theirs): (Vec<f64>, Vec<f64>) = (section(&one), section(&ended));
    assert!(ours.iter().any(|f| f.abs() > 1.0), "the section carries several kN");
    assert_near(&ours, &theirs, "section");

    let at: HashMap<i64, [f64; 3]> = mesh.nodes.iter().map(|n| (n.id.0 as i64, n.x)).collect();
    let mut corners: HashMap<i64, Vec<i64>> = HashMap::new();
    let step = ended.out().join("fields/step_000000");
    for file in pieces_of_folder(&step) {
        let piece = PieceArrays::read(&file).unwrap();
        let nodes = piece.i64("node_id").unwrap();
        let (points, moved) =
            (piece.array("Points").unwrap(), piece.array("displacement").unwrap());
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
    assert!(said.contains("numbering    changed internally"), "{said}");
    let there = tempfile::tempdir().unwrap();
    let deck = there.path().join("tube.k");
    let out = ["--out", deck.to_str().unwrap()];
    run(crumple_with(&[&["export-deck"], &sets[..], &out].concat())).with_code(0);
    let (of_deck, of_job) = (read(&deck, &[]), read(&case("tube-crush"), &[FINE, SHUFFLED]));
    assert_eq!(of_deck.mesh.elements, of_job.mesh.elements);
    assert_eq!(of_deck.mesh.nodes, of_job.mesh.nodes);
}

#[test]
fn messages_name_failed_elements_and_unknown_ids_by_mesh_ids() {
    let sets = ["--set", FINE, "--set", SHUFFLED, "--workers", "2", "--quiet"];
    let said = run(crumple_with(
        &[&["run", "cases/tube-crush", "--set", "time.safety=3"], &sets[..]].concat(),
    ))
    .said();
    let id = said
        .split("element ")
        .nth(1)
        .and_then(|rest| rest.split(' ').next())
        .expect("an element is named");
    assert!((1..=11520).contains(&id.parse::<u64>().unwrap()), "{said}");
    let there = tempfile::tempdir().unwrap();
    let path = there.path().join("job.toml");
    let text = fs::read_to_string(case("tube-crush").join("job.toml")).unwrap();
    fs::write(&path, text + "\n[[output.node]]\nids = [20000]\n").unwrap();
    let said = run(crumple_with(&[&["run", path.to_str().unwrap()], &sets[..]].concat()))
        .with_code(2)
        .said();
    assert!(said.contains("a history names node 20000, which no element has"), "{said}");
}

#[test]
fn ids_of_nodes_have_an_end() {
    let there = tempfile::tempdir().unwrap();
    let deck = there.path().join("large.k");
    let text = "*KEYWORD\n*NODE\n1,0,0,0\n2,1,0,0\n3,1,1,0\n1152921508901814276,0,1,0\n\
                *ELEMENT_SHELL\n1,1,1,2,3,1152921508901814276\n\
                *PART\np\n1,1,1\n*SECTION_SHELL\n1,2\n1,1,1,1\n*MAT_ELASTIC\n1,7.85e-6,210,0.3\n\
                *CONTROL_TERMINATION\n1\n*END\n";
    fs::write(&deck, text).unwrap();
    let said = run(crumple_with(&["check", deck.to_str().unwrap()])).with_code(2).said();
    assert!(said.contains("node id 1152921508901814276 is too large"), "{said}");
}
