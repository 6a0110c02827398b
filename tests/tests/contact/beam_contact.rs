//! Contact of beams as lines: with each other, with edges of shells and solids, and with faces.
//! Closed forms, and the same bits on any number of workers. Units mm, ms, kg.

use crumple::input::job::{self, Model};
use crumple_tests::{run_alone, run_side_by_side};
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;
use std::fmt::Write;
use std::path::PathBuf;

/// Length of a beam and its radius [mm].
const LENGTH: f64 = 100.0;
pub(super) const RADIUS: f64 = 2.0;
pub(super) const RHO: f64 = 7.85e-6;
const LAWS: [&str; 3] = ["lagrange", "kinematic", "penalty"];

/// Builder of a mesh.
#[derive(Default)]
pub(super) struct Rows {
    nodes: String,
    beams: String,
    shells: String,
    solids: String,
    node: usize,
    element: usize,
}

impl Rows {
    fn node(&mut self, x: [f64; 3]) -> usize {
        self.node += 1;
        writeln!(self.nodes, "[{}, {:?}, {:?}, {:?}],", self.node, x[0], x[1], x[2]).unwrap();
        self.node
    }

    /// Adds a row of `n` beams of a part between two points; returns its nodes.
    pub(super) fn bar(&mut self, part: u32, n: usize, from: [f64; 3], to: [f64; 3]) -> Vec<usize> {
        let at = |i: usize| [0, 1, 2].map(|c| from[c] + (to[c] - from[c]) * i as f64 / n as f64);
        let nodes: Vec<usize> = (0..=n).map(|i| self.node(at(i))).collect();
        self.beams(part, &nodes);
        nodes
    }

    /// Adds beams from node to node.
    fn beams(&mut self, part: u32, nodes: &[usize]) {
        // The direction of the second axis has no effect on tubes.
        let third = self.node([310.0, 470.0, 590.0]);
        for pair in nodes.windows(2) {
            self.element += 1;
            writeln!(self.beams, "[{}, {part}, {}, {}, {third}],", self.element, pair[0], pair[1])
                .unwrap();
        }
    }

    /// Adds a grid of quads over a rectangle; `at` maps fractions of its sides to positions.
    /// Returns its nodes.
    fn sheet(
        &mut self,
        part: u32,
        [n, m]: [usize; 2],
        at: impl Fn(f64, f64) -> [f64; 3],
    ) -> Vec<usize> {
        let mut nodes = Vec::new();
        for i in 0..=n {
            for j in 0..=m {
                nodes.push(self.node(at(i as f64 / n as f64, j as f64 / m as f64)));
            }
        }
        for i in 0..n {
            for j in 0..m {
                let [a, b] = [nodes[(m + 1) * i + j], nodes[(m + 1) * (i + 1) + j]];
                self.element += 1;
                writeln!(
                    self.shells,
                    "[{}, {part}, {a}, {b}, {}, {}],",
                    self.element,
                    b + 1,
                    a + 1
                )
                .unwrap();
            }
        }
        nodes
    }

    /// Returns the job with node sets and the further keys `rest`. Parts 1 and 2 have beams,
    /// part 3 shells, part 4 solids.
    pub(super) fn model(&self, end_time: f64, sets: &[(&str, &[usize])], rest: &str) -> Model {
        let list = |ids: &[usize]| ids.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
        let sets: Vec<String> =
            sets.iter().map(|(name, ids)| format!("{name} = [{}]", list(ids))).collect();
        let tube = |id: u32| {
            format!(
                "[[part]]\nid = {id}\nmaterial = \"steel\"\n[part.beam]\nsection = \"tube\"\n\
                 radius = {RADIUS:?}\n"
            )
        };
        let text = format!(
            "end_time = {end_time:?}\n[mesh]\nnodes = [{}]\nbeams = [{}]\nshells = [{}]\n\
             solids = [{}]\n\
             node_sets = {{ {} }}\n[output]\nfield_interval = -1.0\n[[material]]\n\
             name = \"steel\"\nlaw = \"elastic\"\n\
             density = {RHO:?}\nyoungs_modulus = 207.0\npoisson = 0.3\n{}{}\
             [[part]]\nid = 3\nmaterial = \"steel\"\nthickness = {THICKNESS:?}\n[[part]]\nid = 4\n\
             material = \"steel\"\n{rest}",
            self.nodes,
            self.beams,
            self.shells,
            self.solids,
            sets.join(", "),
            tube(1),
            tube(2),
        );
        job::read_text(PathBuf::from("lines.toml"), text, &[])
            .unwrap_or_else(|report| panic!("{report}"))
    }
}

/// Thickness of shells [mm].
const THICKNESS: f64 = 1.0;

/// Returns the position and velocity of the node with this id.
pub(super) fn at(e: &Engine, id: usize) -> ([f64; 3], [f64; 3]) {
    let n = (0..e.nodes.local_count)
        .find(|&n| e.nodes.id[n].label() == id as u64)
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
    let mut rows = Rows::default();
    let z = RADIUS + 0.5;
    let along = |s: f64| LENGTH * (s - 0.5) - off;
    let above = rows.bar(1, CELLS, [along(0.0), 0.0, z], [along(1.0), 0.0, z]);
    let below = rows.bar(2, CELLS, [0.0, along(0.0), -z], [0.0, along(1.0), -z]);
    let rest = format!(
        "[[rigid]]\nname = \"above\"\nparts = [1]\n[[rigid]]\nname = \"below\"\nparts = [2]\n\
         [time]\ndt_max = 2e-3\n\
         [[initial_velocity]]\nnodes = \"above\"\nvelocity = [0.0, 0.0, -1.0]\n[contact]\n{law}\n"
    );
    let model = rows.model(1.5, &[("above", &above)], &rest);
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
    let mean = |ids: &[usize]| {
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
        let mut rows = Rows::default();
        let z = RADIUS + 0.1;
        let above = rows.bar(1, 10, [-50.0, 1.0, z], [50.0, 1.0, z]);
        rows.bar(2, 11, [2.0, -50.0, -z], [2.0, 50.0, -z]);
        let rest = format!(
            "[[initial_velocity]]\nnodes = \"above\"\nvelocity = [0.0, 0.0, -5.0]\n[contact]\n\
             law = \"{law}\"\n"
        );
        let (mut nearest, mut initial, mut worst) = (f64::INFINITY, 0.0f64, 0.0f64);
        let end = run_alone(&rows.model(1.0, &[("above", &above)], &rest), |e| {
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
        let mut rows = Rows::default();
        let z = RADIUS + 0.5 * THICKNESS + 0.2;
        let bar = rows.bar(1, 11, [0.0, d - 50.0, z], [0.0, d + 50.0, z]);
        let sheet = rows.sheet(3, [3, 2], |x, y| [30.0 * (x - 0.5), 0.0, -20.0 * y]);
        let rest = format!(
            "[[rigid]]\nname = \"bar\"\nparts = [1]\n[time]\ndt_max = 1e-3\n[[fix]]\n\
             nodes = \"sheet\"\ndofs = [\"x\", \"y\", \"z\"]\n\
             [[initial_velocity]]\nnodes = \"bar\"\nvelocity = [0.0, 0.0, {:?}]\n[contact]\n\
             law = \"{law}\"\npenalty_damping = 0.0\n",
            -v
        );
        let model = rows.model(3.0, &[("bar", &bar), ("sheet", &sheet)], &rest);
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
        let mut rows = Rows::default();
        let z = RADIUS + 0.5 * THICKNESS;
        let bar = rows.bar(1, 5, [-35.0, 3.0, z + 0.1], [35.0, 5.0, z + 0.1]);
        let sheet = rows.sheet(3, [7, 6], |x, y| [90.0 * (x - 0.5), 70.0 * (y - 0.5), 0.0]);
        let rest = format!(
            "[time]\ndamping = 2.0\n[[fix]]\nnodes = \"sheet\"\n\
             dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
             [[gravity]]\nacceleration = [0.0, 0.0, -0.5]\n[contact]\nlaw = \"{law}\"\n"
        );
        let end = run_alone(&rows.model(8.0, &[("sheet", &sheet)], &rest), |_| {});
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
        let mut rows = Rows::default();
        let mut held = Vec::new();
        for k in 0..3 {
            let (s, c) = (f64::from(k) * 120f64.to_radians()).sin_cos();
            let end = |along: f64| [rho * c - along * s, rho * s + along * c, 0.0];
            held.extend(rows.bar(1, 3, end(-24.0), end(24.0)));
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
        let cube: Vec<usize> = [0.0, 1.0]
            .iter()
            .flat_map(|&up| around.map(|[a, b]| [a, b, up]))
            .map(|k| rows.node(corner(k)))
            .collect();
        rows.element += 1;
        let ids: Vec<String> = cube.iter().map(usize::to_string).collect();
        writeln!(rows.solids, "[{}, 4, {}],", rows.element, ids.join(", ")).unwrap();
        let rest = format!(
            "[time]\ndamping = 1.0\n[[fix]]\nnodes = \"held\"\n\
             dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
             [[gravity]]\nacceleration = [0.0, 0.0, -0.05]\n[contact]\nlaw = \"{law}\"\n\
             friction = 0.3\n"
        );
        let mut lowest = f64::INFINITY;
        let end = run_alone(&rows.model(12.0, &[("held", &held)], &rest), |e| {
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
        let mut rows = Rows::default();
        // Bent down by 6 degrees at each joint.
        let (mut x, mut z) = (-60.0, 0.0);
        let track: Vec<usize> = (0..=12)
            .map(|i| {
                let id = rows.node([x, 0.0, z]);
                let slope = (6.0 * (f64::from(i) - 6.0)).to_radians();
                (x, z) = (x + 10.0 * slope.cos(), z - 10.0 * slope.sin());
                id
            })
            .collect();
        rows.beams(1, &track);
        let middle = 2.0 * RADIUS
            + 10.0 * (0..6).map(|i| (6.0 * (6.0 - f64::from(i))).to_radians().sin()).sum::<f64>();
        let rider = rows.bar(2, 3, [-5.0, -15.0, middle + 0.05], [-5.0, 15.0, middle + 0.05]);
        let rest = format!(
            "[[rigid]]\nname = \"rider\"\nparts = [2]\nfixed = [\"rx\", \"ry\", \"rz\"]\n[time]\n\
             dt_max = 1e-3\n\
             [[fix]]\nnodes = \"track\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
             [[initial_velocity]]\nnodes = \"rider\"\nvelocity = [3.0, 0.0, 0.0]\n\
             [[gravity]]\nacceleration = [0.0, 0.0, -0.2]\n[contact]\nlaw = \"{law}\"\n"
        );
        let model = rows.model(10.0, &[("track", &track), ("rider", &rider)], &rest);
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
    let mut rows = Rows::default();
    let mut upper = Vec::new();
    for k in 0..4 {
        let y = 14.0 * f64::from(k) - 20.0;
        upper.extend(rows.bar(1, 9, [-45.0, y, 2.2], [40.0, y + 6.0, 2.4]));
    }
    for k in 0..4 {
        let x = 17.0 * f64::from(k) - 26.0;
        rows.bar(2, 8, [x, -40.0, -2.2], [x - 7.0, 42.0, -2.1]);
    }
    let sheet = rows.sheet(3, [9, 7], |x, y| [100.0 * (x - 0.5), 90.0 * (y - 0.5), -5.2]);
    let lid = rows.sheet(3, [5, 4], |x, y| [61.0 * (x - 0.4), 43.0 * (y - 0.5), 5.4]);
    upper.extend(&lid);
    // Ribs along edges of both sheets, and a post under the lid's corner.
    let ribs = [(&sheet, 8, 3), (&sheet, 8, 5), (&lid, 5, 2)];
    let ribs = ribs
        .map(|(of, step, from)| of.iter().copied().skip(from).step_by(step).collect::<Vec<_>>());
    ribs.iter().for_each(|rib| rows.beams(2, rib));
    let below = rows.node([61.0 * -0.4, 43.0 * -0.5, 3.0]);
    rows.beams(1, &[lid[0], below]);
    upper.push(below);
    let mut nodes = Vec::new();
    for i in 0..=5 {
        for [y, z] in [[0.0, 6.2], [4.0, 10.2], [0.0, 14.2], [-4.0, 10.2]] {
            nodes.push(rows.node([10.0 * f64::from(i) - 22.0, y, z]));
        }
    }
    for i in 0..5 {
        rows.element += 1;
        let at = |k: usize| nodes[4 * i + k].to_string();
        let corners: Vec<String> = (0..8).map(at).collect();
        writeln!(rows.solids, "[{}, 4, {}],", rows.element, corners.join(", ")).unwrap();
    }
    upper.extend(&nodes);
    let rest = format!(
        "[[initial_velocity]]\nnodes = \"upper\"\nvelocity = [9.0, 5.0, -6.0]\n[[gravity]]\n\
         acceleration = [0.0, 0.0, -20.0]\n\
         [[fix]]\nnodes = \"rim\"\ndofs = [\"x\", \"y\", \"z\"]\n[contact]\nfriction = 0.2\n\
         {contact}\n"
    );
    let rim: Vec<usize> = sheet.iter().copied().filter(|n| (n - sheet[0]) % 8 == 0).collect();
    rows.model(1.0, &[("upper", &upper), ("rim", &rim)], &rest)
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
        let mut rows = Rows::default();
        let above = rows.bar(1, 6, [-50.0, 1.0, 3.0], [50.0, 1.0, 3.0]);
        let below = rows.bar(2, 7, [2.0, -50.0, -3.0], [2.0, 50.0, -3.0]);
        let rest = format!(
            "[[initial_velocity]]\nnodes = \"above\"\nvelocity = [0.0, 0.0, -10.0]\n[contact]\n\
             {contact}\n"
        );
        let end = run_alone(&rows.model(1.0, &[("above", &above)], &rest), |_| {});
        let through = at(&end, above[3]).0[2] < at(&end, below[3]).0[2];
        assert_eq!(through, passes, "{contact}");
    }
}

/// A beam that fails releases the bodies that lie on it.
#[test]
fn broken_beams_leave_the_contact() {
    let mut rows = Rows::default();
    let above = rows.bar(1, 6, [-50.0, 1.0, 2.1], [50.0, 1.0, 2.1]);
    let below = rows.bar(2, 1, [2.0, -50.0, -2.1], [2.0, 50.0, -2.1]);
    let rest = "[[initial_velocity]]\nnodes = \"above\"\nvelocity = [0.0, 0.0, -4.0]\n\
                [[motion]]\nnodes = \"far\"\ndofs = [\"y\"]\nvelocity = [0.0, 4.0, 0.0]\n\
                [[fix]]\nnodes = \"near\"\ndofs = [\"x\", \"y\", \"z\"]\n[[fix]]\nnodes = \"far\"\n\
                dofs = [\"x\", \"z\"]\n[contact]\n";
    let sets: [(&str, &[usize]); 3] =
        [("above", &above), ("near", &below[..1]), ("far", &below[1..])];
    let ends = ["", "\n[part.beam.weld]\nnormal = 1.0"].map(|weld| {
        let mut model = rows.model(2.0, &sets, rest);
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
