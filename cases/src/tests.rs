//! Checks of all scenes: valid files, meshes without errors, and the numbers of the papers.

use crate::{GENERATORS, generate, jobs};
use crumple_proto::ids::NodeId;
use crumple_proto::job::Job;
use crumple_proto::mesh::{Mesh, MeshElement, Shape};
use crumple_proto::quality::quality;
use std::collections::{BTreeMap, BTreeSet};

const FLIGHT: &str = include_str!("../flight/job.toml");
const BEAM: &str = include_str!("../beam/job.toml");
const BRICK_WALL: &str = include_str!("../brick-wall/job.toml");
const CAN_CRUSH: &str = include_str!("../can-crush/job.toml");

fn job(text: &str) -> Job {
    toml::from_str(text).unwrap_or_else(|e| panic!("{e}"))
}

fn mesh_of(job: &Job) -> Mesh {
    let name = job.mesh.generator.as_deref().expect("a scene of this folder names a generator");
    generate(name, &job.scene).unwrap_or_else(|p| panic!("{p:?}"))
}

fn scene(text: &str) -> toml::Table {
    text.parse().expect("a table")
}

fn made(name: &str, options: &str) -> Mesh {
    generate(name, &scene(options)).unwrap_or_else(|p| panic!("{p:?}"))
}

/// Returns the undirected edges and the number of elements that share each.
fn edges(mesh: &Mesh) -> BTreeMap<(NodeId, NodeId), usize> {
    let mut edges = BTreeMap::new();
    for e in &mesh.elements {
        let c = e.corners();
        for i in 0..c.len() {
            let (a, b) = (c[i], c[(i + 1) % c.len()]);
            *edges.entry((a.min(b), a.max(b))).or_insert(0) += 1;
        }
    }
    edges
}

/// Returns the number of connected pieces that the elements form through shared nodes.
fn pieces(mesh: &Mesh) -> usize {
    let mut root: Vec<usize> = (0..=mesh.nodes.len()).collect();
    fn find(root: &mut [usize], mut i: usize) -> usize {
        while root[i] != i {
            root[i] = root[root[i]];
            i = root[i];
        }
        i
    }
    for e in &mesh.elements {
        for pair in e.corners().windows(2) {
            let (a, b) = (find(&mut root, pair[0].0 as usize), find(&mut root, pair[1].0 as usize));
            root[a] = b;
        }
    }
    (1..=mesh.nodes.len()).filter(|&i| find(&mut root, i) == i).count()
}

/// Checks that ids run from 1, and that there are no free nodes, no two nodes in one place and no
/// two elements on the same nodes.
fn assert_whole(mesh: &Mesh) {
    assert!(mesh.nodes.iter().zip(1..).all(|(n, id)| n.id == NodeId(id)));
    assert!(mesh.elements.iter().zip(1..).all(|(e, id)| e.id.0 == id));
    let used: BTreeSet<NodeId> = mesh.elements.iter().flat_map(|e| e.corners()).copied().collect();
    assert_eq!(used.len(), mesh.nodes.len(), "free nodes");
    for (name, set) in &mesh.node_sets {
        assert!(!set.is_empty() && set.iter().all(|id| used.contains(id)), "node set {name}");
    }
    let q = quality(mesh).unwrap();
    assert!(q.zero_area.is_empty() && q.dangling.is_empty());
    // Nodes in one place would differ by round-off only. A thousandth of a side separates them
    // from neighbours.
    let cell = 1e-3 * q.min_side.value;
    let places: BTreeSet<[i64; 3]> =
        mesh.nodes.iter().map(|n| n.x.map(|c| (c / cell).round() as i64)).collect();
    assert_eq!(places.len(), mesh.nodes.len(), "two nodes in one place");
    let corners: BTreeSet<BTreeSet<NodeId>> =
        mesh.elements.iter().map(|e| e.corners().iter().copied().collect()).collect();
    assert_eq!(corners.len(), mesh.elements.len(), "two elements on the same nodes");
}

/// Checks also that all elements are nearly square.
fn assert_sound(mesh: &Mesh) {
    assert_whole(mesh);
    let q = quality(mesh).unwrap();
    assert!(
        q.min_side.value > 0.5 * q.median_side,
        "short side {:?}, median {}",
        q.min_side,
        q.median_side
    );
    assert!(q.max_aspect.value < 2.0, "{:?}", q.max_aspect);
    assert!(q.max_warpage_deg.value < 0.01, "{:?}", q.max_warpage_deg);
    assert!(q.min_jacobian.value > 0.6, "{:?}", q.min_jacobian);
}

/// Returns the mass of the shells of a job [mass].
fn shell_mass(job: &Job, mesh: &Mesh) -> f64 {
    let at: BTreeMap<NodeId, [f64; 3]> = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let mut mass = 0.0;
    for e in &mesh.elements {
        let part =
            job.part.iter().find(|p| p.id == e.part).expect("every element has a part in the job");
        let material = job
            .material
            .iter()
            .find(|m| m.name == part.material)
            .expect("every part has a material");
        let x: Vec<_> = e.nodes.iter().map(|id| at[id]).collect();
        let (d1, d2) = ([0, 1, 2].map(|i| x[2][i] - x[0][i]), [0, 1, 2].map(|i| x[3][i] - x[1][i]));
        let cross = [0, 1, 2].map(|i| {
            let (j, k) = ((i + 1) % 3, (i + 2) % 3);
            d1[j] * d2[k] - d1[k] * d2[j]
        });
        mass += 0.5
            * cross.iter().map(|c| c * c).sum::<f64>().sqrt()
            * part.thickness
            * material.density;
    }
    mass
}

#[test]
fn jobs_fit_their_meshes() {
    for text in [jobs::JEEP_FRAME, FLIGHT, jobs::TUMBLE] {
        assert!(text.starts_with("# Units"), "line one states units and what to see");
        let job = job(text);
        let mesh = mesh_of(&job);
        assert_sound(&mesh);
        assert!(shell_mass(&job, &mesh) > 0.0);
        let sets = job
            .mass
            .iter()
            .map(|m| &m.nodes)
            .chain(job.initial_velocity.iter().filter_map(|v| v.nodes.as_ref()));
        for set in sets {
            assert!(mesh.node_sets.contains_key(set), "no node set {set}");
        }
        for part in &job.part {
            assert!(
                mesh.elements.iter().any(|e| e.part == part.id),
                "part {} has no elements",
                part.name
            );
        }
    }
}

/// Wang 2007, section 3: 7208 four-node shells and 35,950 degrees of freedom with five per node.
#[test]
fn jeep_frame_has_the_published_size() {
    let mesh = made("jeep_frame", "");
    assert_eq!((mesh.elements.len(), mesh.nodes.len()), (7208, 7190));
    assert_eq!(5 * mesh.nodes.len(), 35_950);
    let finer = made("jeep_frame", "refine = 3");
    assert_eq!((finer.elements.len(), finer.nodes.len()), (64_872, 64_818));
    assert_sound(&finer);
}

/// The edges of a weld ring belong to two quads of the wall and one quad of the tube. The ends of
/// the rails are open.
#[test]
fn jeep_frame_is_welded_through_shared_nodes() {
    for refine in 1..=2 {
        let mesh = made("jeep_frame", &format!("refine = {refine}"));
        assert_eq!(pieces(&mesh), 1);
        let mut count = BTreeMap::new();
        for n in edges(&mesh).into_values() {
            *count.entry(n).or_insert(0) += 1;
        }
        assert_eq!(count[&1], 4 * 16 * refine, "open ends");
        assert_eq!(count[&3], 2 * 50 * refine, "weld edges");
        assert_eq!(count.keys().copied().collect::<Vec<_>>(), [1, 2, 3]);
    }
}

/// The same for horns with a finer mesh: there are no open edges where the fine mesh ends, and the
/// surface is complete.
#[test]
fn finer_horns_hang_together_with_the_rest() {
    let (job, coarse) = (job(jobs::JEEP_FRAME), made("jeep_frame", ""));
    for (horns, triangles) in [(2, 2 * 16 * 3), (3, 2 * 16 * 2), (4, 2 * 16 * 5)] {
        let mesh = made("jeep_frame", &format!("horn_refine = {horns}"));
        assert_eq!(pieces(&mesh), 1);
        let mut count = BTreeMap::new();
        for n in edges(&mesh).into_values() {
            *count.entry(n).or_insert(0) += 1;
        }
        assert_eq!(count[&1], 2 * 16 * (horns + 1), "open ends");
        assert_eq!(count[&3], 2 * (8 * horns + 42), "weld edges");
        assert_eq!(count.keys().copied().collect::<Vec<_>>(), [1, 2, 3]);
        assert_eq!(mesh.elements.iter().filter(|e| e.shape == Shape::Tri3).count(), triangles);
        let [ours, theirs] = [&mesh, &coarse].map(|mesh| shell_mass(&job, mesh));
        assert!((ours / theirs - 1.0).abs() < 1e-3, "chords of curved horns: {ours} for {theirs}");
    }
}

#[test]
fn jeep_frame_carries_masses_where_refinement_leaves_them() {
    let centre = |mesh: &Mesh, set: &str| {
        let nodes = &mesh.node_sets[set];
        let sum = nodes
            .iter()
            .map(|id| mesh.nodes[id.0 as usize - 1].x)
            .fold([0.0; 3], |s, x| [0, 1, 2].map(|i| s[i] + x[i]));
        sum.map(|s| s / nodes.len() as f64)
    };
    let (coarse, fine) = (made("jeep_frame", ""), made("jeep_frame", "refine = 4"));
    for set in ["engine", "rear", "front"] {
        let (a, b) = (centre(&coarse, set), centre(&fine, set));
        assert!(a[1].abs() < 1e-9, "{set} is on the centre plane");
        // The finer patch has more nodes inside the same outline: its rear end is an open edge,
        // hence the 3 mm.
        assert!((0..3).all(|i| (a[i] - b[i]).abs() < 3.0), "{set} {a:?} {b:?}");
    }
    let tip = coarse.nodes.iter().map(|n| n.x[0]).fold(f64::INFINITY, f64::min);
    assert!(tip.abs() < 1e-9, "the front tips are at x = 0, behind the wall of job.toml");
}

/// The engine, the load and about 100 kg of steel.
#[test]
fn jeep_frame_weighs_what_its_notes_say() {
    let job = job(jobs::JEEP_FRAME);
    let steel = shell_mass(&job, &mesh_of(&job));
    let added: f64 = job.mass.iter().map(|m| m.mass).sum();
    assert_eq!(added, 1300.0);
    assert!((98.0..104.0).contains(&steel), "{steel} kg of steel");
}

#[test]
fn neighbours_in_space_are_neighbours_in_number() {
    let mesh = made("jeep_frame", "");
    let widest = mesh
        .elements
        .iter()
        .map(|e| e.nodes.iter().max().unwrap().0 - e.nodes.iter().min().unwrap().0);
    // A slice holds up to 32 nodes of the rails and 35 * 8 of a member's end walls.
    assert!(widest.max().unwrap() < 800);
}

#[test]
fn all_that_is_wrong_with_a_scene_comes_back_at_once() {
    let table = scene("refin = 2\nhorn_drop = \"deep\"\nrail_depth = 1.0\nrefine = 2.5");
    let problems = generate("jeep_frame", &table).err().unwrap();
    let paths: Vec<&str> = problems.iter().map(|p| p.path.as_str()).collect();
    for path in ["scene.refin", "scene.horn_drop", "scene.rail_depth", "scene.refine"] {
        assert!(paths.contains(&path), "{paths:?}");
    }
    assert!(
        problems
            .iter()
            .find(|p| p.path == "scene.refin")
            .unwrap()
            .help
            .contains("did you mean `refine`?")
    );
    let unknown = generate("jeep-fram", &toml::Table::new()).err().unwrap();
    assert_eq!(unknown[0].path, "mesh.generator");
    assert!(unknown[0].help.contains("`jeep_frame`"));
}

#[test]
fn members_and_curves_that_do_not_fit_are_refused() {
    let refused = |options: &str, path: &str| {
        let problems = generate("jeep_frame", &scene(options)).err().unwrap_or_default();
        assert!(problems.iter().any(|p| p.path == path), "{options}: {problems:?}");
    };
    refused("front_kick_to = 800", "scene.front_kick_to");
    refused("front_height = 0\nfront_kick_to = 720", "scene.front_kick_to");
    refused("gearbox_member_at = 2560", "scene.middle_member_at");
    refused("rear_part_from = 100", "scene.rear_part_from");
}

#[test]
fn defaults_are_the_values_of_the_job_file() {
    for text in [jobs::JEEP_FRAME, jobs::TUMBLE, BEAM, BRICK_WALL, CAN_CRUSH] {
        let job = job(text);
        let generator = GENERATORS
            .iter()
            .find(|g| Some(g.name) == job.mesh.generator.as_deref())
            .expect("it is there");
        for (key, value) in &job.scene {
            let row = generator.options.iter().find(|row| row.0 == key).expect(key);
            assert_eq!(
                value.as_float().or(value.as_integer().map(|i| i as f64)),
                Some(row.1),
                "{key}"
            );
        }
    }
}

/// Returns the smallest distance between nodes of different bodies that move without contact [mm].
fn least_gap(job: &Job, mesh: &Mesh, time: f64) -> f64 {
    let bodies: Vec<Vec<[f64; 3]>> = job
        .initial_velocity
        .iter()
        .map(|v| {
            let spin = v.spin.iter().map(|c| c * c).sum::<f64>().sqrt();
            let (axis, (sin, cos)) = (v.spin.map(|c| c / spin), (spin * time).sin_cos());
            let turned = |x: [f64; 3]| {
                let r = [0, 1, 2].map(|i| x[i] - v.centre[i]);
                let along: f64 = (0..3).map(|i| axis[i] * r[i]).sum();
                [0, 1, 2].map(|i| {
                    let (j, k) = ((i + 1) % 3, (i + 2) % 3);
                    let across = axis[j] * r[k] - axis[k] * r[j];
                    let turned = cos * r[i] + sin * across + (1.0 - cos) * along * axis[i];
                    v.centre[i] + turned + time * v.velocity[i]
                })
            };
            let set = &mesh.node_sets[v.nodes.as_ref().expect("a body's node set")];
            set.iter().map(|id| turned(mesh.nodes[id.0 as usize - 1].x)).collect()
        })
        .collect();
    let mut least = f64::INFINITY;
    for (i, one) in bodies.iter().enumerate() {
        for other in &bodies[i + 1..] {
            for a in one {
                for b in other {
                    least = least.min((0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>());
                }
            }
        }
    }
    least.sqrt()
}

/// Bodies start apart and would soon pass through each other. The nearest points of two surfaces
/// are at most half a diagonal from a node, 2.1 mm for sides of 3 mm. The half thicknesses, at most
/// 1.5 mm, keep surfaces apart.
#[test]
fn tumble_starts_apart_and_collides_soon() {
    let job = job(jobs::TUMBLE);
    let mesh = made("tumble", "refine = 3");
    let start = least_gap(&job, &mesh, 0.0);
    assert!(start > 1.5 + 2.0 * 2.2, "{start} mm at the start");
    let later = least_gap(&job, &mesh, 1.0);
    assert!(later < 1.0, "{later} mm after 1 ms: the bodies do not meet");
}

#[test]
fn tumble_is_small_and_of_seven_pieces() {
    let mesh = made("tumble", "");
    assert_eq!((mesh.elements.len(), mesh.nodes.len()), (1200, 1339));
    assert_eq!(pieces(&mesh), 7);
}

/// Attaway et al. 1994: 19,500 elements and 22,506 nodes for the fixed-size beam, 6480 elements per
/// worker for the scaled one; 8400 elements and 17 bricks, with 54 elements in a full brick; 7152
/// elements for the can crush.
#[test]
fn the_scenes_of_pronto_have_their_published_sizes() {
    let size = |mesh: &Mesh| (mesh.elements.len(), mesh.nodes.len());
    assert_eq!(size(&mesh_of(&job(BEAM))), (19_500, 22_506));
    for workers in [1, 2, 7] {
        assert_eq!(made("beam", &format!("scale = {workers}")).elements.len(), 6480 * workers);
    }
    let wall = mesh_of(&job(BRICK_WALL));
    assert_eq!((wall.elements.len(), pieces(&wall)), (8400, 19), "17 bricks, rod and wall");
    let bricks = wall.elements.iter().filter(|e| e.part == 2).count();
    assert_eq!(bricks, 13 * 54 + 4 * 27);
    let can = mesh_of(&job(CAN_CRUSH));
    assert_eq!((can.elements.len(), pieces(&can)), (7152, 2));
    for (name, scale) in [("brick_wall", 8.0), ("can_crush", 8.0)] {
        let (small, large) = (made(name, ""), made(name, &format!("scale = {scale}")));
        let ratio = large.elements.len() as f64 / small.elements.len() as f64;
        assert!((ratio / scale - 1.0).abs() < 0.01, "{name}: {ratio}");
    }
}

/// No solid is inverted or needle-like, in the published meshes and in refined ones.
#[test]
fn solids_have_a_good_shape() {
    for (name, options) in [
        ("beam", ""),
        ("brick_wall", ""),
        ("can_crush", ""),
        ("brick_wall", "scale = 3"),
        ("can_crush", "scale = 3"),
    ] {
        let q = quality(&made(name, options)).expect("the mesh has elements");
        assert!(q.min_jacobian.value > 0.9 && q.max_aspect.value < 6.0, "{name}: {q:?}");
        assert!(q.zero_area.is_empty() && q.dangling.is_empty());
    }
}

#[test]
fn bars_meet_end_to_end() {
    let mesh = made("bars", "elements = 8");
    assert_sound(&mesh);
    assert_eq!((mesh.elements.len(), mesh.nodes.len(), pieces(&mesh)), (16, 36, 2));
    let last = |set: &str, pick: fn(f64, f64) -> f64, start: f64| {
        let of_set = mesh.nodes.iter().filter(|n| mesh.node_sets[set].contains(&n.id));
        of_set.map(|n| n.x[0]).fold(start, pick)
    };
    let gap = last("two", f64::min, f64::INFINITY) - last("one", f64::max, f64::NEG_INFINITY);
    // 0.200001 to round-off of coordinates around 100.
    assert!((gap - 0.200_001).abs() < 1e-12, "{gap}");
}

/// Narrow columns are in the middle; the others share the rest of the side.
#[test]
fn a_plate_can_have_a_strip_of_narrow_quads() {
    let mesh = made("plate", "elements = 3\nside = 90.0\nstrip = 2\nnarrow = 4.0");
    let mut x: Vec<f64> = mesh.nodes.iter().filter(|n| n.x[1] == -45.0).map(|n| n.x[0]).collect();
    x.sort_by(f64::total_cmp);
    assert_eq!(x, [-45.0, -25.0, -5.0, 0.0, 5.0, 25.0, 45.0]);
}

#[test]
fn the_plate_is_held_at_its_rim() {
    let mesh = made("plate", "elements = 3");
    assert_sound(&mesh);
    assert_eq!((mesh.elements.len(), pieces(&mesh)), (36, 1));
    let count = |set: &str| mesh.node_sets[set].len();
    assert_eq!((count("rim"), count("inside")), (24, 25));
}

/// Bars of 40 elements: a row of shells, or three by three rows of cubes; the second one shifted by
/// half a side.
#[test]
fn bars_are_shells_or_solids() {
    let shells = made("bars", "elements = 40");
    assert_eq!((shells.elements.len(), shells.nodes.len()), (2 * 40, 2 * 2 * 41));
    let solids = made("bars", "elements = 40\nacross = 3\nshift = 0.5");
    assert_eq!((solids.elements.len(), solids.nodes.len()), (2 * 40 * 9, 2 * 41 * 16));
    let sideways = |part: &str| {
        let at: BTreeMap<_, _> = solids.nodes.iter().map(|n| (n.id, n.x)).collect();
        solids.node_sets[part].iter().map(|n| at[n][1]).fold(f64::INFINITY, f64::min)
    };
    assert_eq!((sideways("one"), sideways("two")), (0.0, 0.5 * 100.0 / 40.0));
    for mesh in [shells, solids] {
        assert_sound(&mesh);
    }
}

/// The drop of `splash` is a ball of particles above the plate, each with a node of its own.
#[test]
fn splash_has_a_ball_of_particles() {
    let mesh = made("splash", "");
    let (particles, shells): (Vec<&MeshElement>, Vec<&MeshElement>) =
        mesh.elements.iter().partition(|e| e.shape == Shape::Point1);
    assert_eq!((particles.len(), shells.len()), (925, 400));
    let nodes: BTreeSet<_> = particles.iter().map(|e| e.nodes[0]).collect();
    assert_eq!(nodes, mesh.node_sets["drop"].iter().copied().collect());
    assert_eq!(nodes.len(), 925);
    let lowest = mesh.nodes.iter().filter(|n| nodes.contains(&n.id)).map(|n| n.x[2]);
    assert_eq!(lowest.fold(f64::INFINITY, f64::min), 1.0, "the gap");
    assert_eq!(mesh.node_sets["edge"].len(), 80);
    let wrong = generate("splash", &scene("spacing = 7.0\ngap = -1.0")).err().unwrap();
    assert_eq!(wrong[0].path, "scene.gap");
}

/// Every plate of `drop` is separate, above the shell, and does not touch its neighbours.
#[test]
fn plates_drop_inside_the_shell() {
    let mesh = made("drop", "plates = 64");
    assert_sound(&mesh);
    assert_eq!(
        (pieces(&mesh), mesh.node_sets["plates"].len(), mesh.node_sets["base"].len()),
        (65, 256, 4)
    );
    assert!(
        mesh.nodes
            .iter()
            .filter(|n| n.x[2] > 0.0)
            .all(|n| n.x[0].abs() < 10.0 && n.x[1].abs() < 10.0)
    );
}

/// MacNeal and Harder (1985): 12 by 2 quads, turned by a right angle from root to tip.
#[test]
fn the_twisted_beam_turns_by_a_right_angle() {
    let mesh = made("twist", "");
    assert_eq!((mesh.elements.len(), mesh.nodes.len(), pieces(&mesh)), (24, 39, 1));
    let at: BTreeMap<_, _> = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let spread = |set: &str, c: usize| {
        mesh.node_sets[set].iter().map(|n| at[n][c].abs()).fold(0.0, f64::max)
    };
    assert!((spread("root", 1) - 0.55).abs() < 1e-12 && spread("root", 2) < 1e-12);
    assert!((spread("tip", 2) - 0.55).abs() < 1e-12 && spread("tip", 1) < 1e-12);
}

/// The scenes of studies are complete with default and finer meshes and have the node sets that
/// their jobs name.
#[test]
fn scenes_of_studies_are_whole() {
    let jobs = [
        include_str!("../hertz/job.toml"),
        jobs::SLIDE,
        include_str!("../slide/reversal.toml"),
        include_str!("../drum/job.toml"),
        include_str!("../corner/job.toml"),
        jobs::TUBE,
        include_str!("../strip/job.toml"),
        jobs::BLOCK,
        include_str!("../block/cantilever.toml"),
    ];
    for text in jobs {
        assert!(text.starts_with("# Units"), "line one states units and what to see");
        let job = job(text);
        let mesh = mesh_of(&job);
        assert_whole(&mesh);
        let sets = job.fix.iter().map(|f| &f.nodes).chain(job.load.iter().map(|l| &l.nodes));
        for set in sets.chain(job.mass.iter().map(|m| &m.nodes)) {
            assert!(mesh.node_sets.contains_key(set), "{}: no node set {set}", job.title);
        }
    }
    let finer = [
        ("hertz", "cells = 8\nsize = 6.0"),
        ("slide", "facets = 16\ncells = 4\ngap = -0.1"),
        ("drum", "facets = 24\nturn = 45.0"),
        ("corner", "angle = 60.0\nturn = 45.0\nfacets = 9\ncells = 3"),
        ("tube", "elements = 5\nlength = 44.0"),
        ("strip", "along = 10\nacross = 2\nslant = -0.3"),
        ("block", "along = 3\nacross = 1\nhigh = 2\nrefine = 2"),
    ];
    finer.into_iter().for_each(|(name, options)| assert_whole(&made(name, options)));
}

/// The cube has the distance `gap` for any rotation and any angle between the walls: moved by the
/// gap, it touches a wall of 1 mm and penetrates none.
#[test]
fn the_cube_stands_before_the_corner() {
    for (angle, turn) in [(90.0, 0.0), (90.0, 45.0), (60.0, 10.0), (120.0, -30.0)] {
        let mesh = made("corner", &format!("angle = {angle:?}\nturn = {turn:?}\ngap = 0.25"));
        let half = 0.5 * f64::to_radians(angle);
        let at: BTreeMap<_, _> = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
        // Distance from the nearer wall, which are the lines y = +-x tan half.
        let gap = |x: f64, y: f64| x * half.sin() - y.abs() * half.cos() - 0.5;
        let least = |moved: f64| {
            let gaps = mesh.node_sets["cube"].iter().map(|n| gap(at[n][0] - moved, at[n][1]));
            gaps.fold(f64::INFINITY, f64::min)
        };
        assert!(least(0.25).abs() < 1e-12, "{angle} {turn}: {}", least(0.25));
        assert!((least(0.0) - 0.25 * half.sin()).abs() < 1e-12);
    }
}
