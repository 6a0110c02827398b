//! Contact between edges, of shells and of solids: the same bits whichever workers own the
//! edges.

use crumple::input::job::{self, Model};
use crumple_tests::{run_alone, run_side_by_side};
use std::fmt::Write;
use std::path::PathBuf;

/// Distance below the edges of the lower layer from which its nodes are held [mm].
const FLOOR: f64 = 4.0;

/// Nodes and elements of a mesh.
#[derive(Default)]
struct Bodies {
    nodes: String,
    shells: String,
    solids: String,
    upper: Vec<usize>,
    floor: Vec<usize>,
    node: usize,
    element: usize,
}

/// Position of a body: a point, its length along a direction in the plane, and true if it is in
/// the upper layer [mm].
struct Place {
    at: [f64; 3],
    length: f64,
    angle: f64,
    above: bool,
}

impl Bodies {
    fn node(&mut self, p: &Place, along: f64, across: f64, up: f64) {
        let (sin, cos) = p.angle.to_radians().sin_cos();
        self.node += 1;
        let z = if p.above { up } else { -up };
        let (x, y) = (p.at[0] + cos * along - sin * across, p.at[1] + sin * along + cos * across);
        writeln!(self.nodes, "[{}, {x:?}, {y:?}, {:?}],", self.node, p.at[2] + z).unwrap();
        if p.above {
            self.upper.push(self.node);
        } else if up > FLOOR {
            self.floor.push(self.node);
        }
    }

    /// Adds an upright strip of shells, 4 mm high, its free edge towards the other layer.
    fn strip(&mut self, p: &Place, cells: usize) {
        let first = self.node + 1;
        for i in 0..=cells {
            let along = p.length * (i as f64 / cells as f64 - 0.5);
            self.node(p, along, 0.0, 0.6);
            self.node(p, along, 0.0, 4.6);
        }
        for i in 0..cells {
            self.element += 1;
            let n = first + 2 * i;
            let part = if p.above { 1 } else { 2 };
            writeln!(
                self.shells,
                "[{}, {part}, {n}, {}, {}, {}],",
                self.element,
                n + 2,
                n + 3,
                n + 1
            )
            .unwrap();
        }
    }

    /// Adds a sheet of shells that is bent along its middle, 5 mm high, its ridge towards the
    /// other layer.
    fn roof(&mut self, p: &Place, cells: usize) {
        let first = self.node + 1;
        for i in 0..=cells {
            let along = p.length * (i as f64 / cells as f64 - 0.5);
            for across in [-5.0f64, -2.5, 0.0, 2.5, 5.0] {
                self.node(p, along, across, 0.6 + across.abs());
            }
        }
        for i in 0..cells {
            for j in 0..4 {
                self.element += 1;
                let n = first + 5 * i + j;
                let part = if p.above { 1 } else { 2 };
                writeln!(
                    self.shells,
                    "[{}, {part}, {n}, {}, {}, {}],",
                    self.element,
                    n + 5,
                    n + 6,
                    n + 1
                )
                .unwrap();
            }
        }
    }

    /// Adds a bar of cubes, 4 mm wide, that stands on an edge, its lowest or highest.
    fn bar(&mut self, p: &Place, cells: usize) {
        let (first, d) = (self.node + 1, 8f64.sqrt());
        for i in 0..=cells {
            let along = p.length * (i as f64 / cells as f64 - 0.5);
            for (across, up) in [(0.0, 0.1), (d, 0.1 + d), (0.0, 0.1 + 2.0 * d), (-d, 0.1 + d)] {
                self.node(p, along, across, up);
            }
        }
        for i in 0..cells {
            self.element += 1;
            let n = first + 4 * i;
            // A reflection of the axes across and up reverses the order of the corners.
            let around = if p.above { [0, 1, 2, 3] } else { [0, 3, 2, 1] };
            let corners = around.map(|k| n + k).into_iter().chain(around.map(|k| n + 4 + k));
            let corners: Vec<String> = corners.map(|c| c.to_string()).collect();
            let part = if p.above { 3 } else { 4 };
            writeln!(self.solids, "[{}, {part}, {}],", self.element, corners.join(", ")).unwrap();
        }
    }
}

/// Returns a job with strips, bars and bent sheets in two layers. The upper layer falls and
/// slides over the lower one, from edge to edge, also across workers.
fn grid(contact: &str, cells: usize, velocity: [f64; 3], weight: f64) -> Model {
    let mut bodies = Bodies::default();
    for (above, angle) in [(true, 0.0), (false, 70.0)] {
        for k in [-1.9, -0.9, 0.1, 1.2, 2.1] {
            let at = if above { [0.0, 12.0 * k, 0.0] } else { [12.0 * k, 0.0, 0.0] };
            bodies.strip(&Place { at, length: 70.0, angle, above }, cells);
        }
    }
    for (above, angle) in [(true, 5.0), (false, 80.0)] {
        bodies.bar(&Place { at: [1.0, 60.0, 0.0], length: 50.0, angle, above }, 11);
    }
    for (above, angle, sides) in [(true, 0.0, [-6.0, 7.0]), (false, 75.0, [-7.0, 6.0])] {
        for side in sides {
            let at = if above { [0.0, side - 60.0, 0.0] } else { [side, -60.0, 0.0] };
            bodies.roof(&Place { at, length: 40.0, angle, above }, 9);
        }
    }
    let set = |ids: &[usize]| ids.iter().map(usize::to_string).collect::<Vec<_>>().join(", ");
    let parts = |ids: [u32; 2], more: &str| {
        ids.map(|i| format!("[[part]]\nid = {i}\nmaterial = \"steel\"\n{more}\n")).concat()
    };
    let text = format!(
        r#"
        title = "Strips, bars and roofs across each other"
        units = "mm, ms, kg"
        end_time = 1.0
        [mesh]
        nodes = [{}]
        shells = [{}]
        solids = [{}]
        node_sets = {{ upper = [{}], floor = [{}] }}
        [[material]]
        name = "steel"
        law = "elastic"
        density = 7.85e-6
        youngs_modulus = 200.0
        poisson = 0.3
        {}
        {}
        [[initial_velocity]]
        nodes = "upper"
        velocity = {velocity:?}
        [[gravity]]
        acceleration = [0.0, 0.0, {:?}]
        [[fix]]
        nodes = "floor"
        dofs = ["x", "y", "z"]
        [contact]
        friction = 0.2
        {contact}
        "#,
        bodies.nodes,
        bodies.shells,
        bodies.solids,
        set(&bodies.upper),
        set(&bodies.floor),
        parts([1, 2], "thickness = 1.0\npoints = 2"),
        parts([3, 4], ""),
        -weight,
    );
    job::read_text(PathBuf::from("grid.toml"), text, &[])
        .unwrap_or_else(|report| panic!("{report}"))
}

const LAWS: [&str; 5] = [
    "",
    "iteration = \"split\"",
    "law = \"kinematic\"",
    "law = \"penalty\"",
    "law = \"penalty\"\npenalty_form = \"stiffness\"\npenalty_scale = 0.5",
];

#[test]
fn edges_across_workers_give_the_same_bits() {
    for law in LAWS {
        let model = grid(law, 29, [40.0, 25.0, -2.0], 150.0);
        let alone = run_side_by_side(&model, 1, 900, 0);
        assert_eq!(alone.trouble, None);
        for (workers, every) in [(2, 0), (3, 7), (6, 3), (9, 3)] {
            let many = run_side_by_side(&model, workers, 900, every);
            let differs = many.pairs.iter().zip(&alone.pairs).position(|(a, b)| a != b);
            assert_eq!(
                differs, None,
                "{law}: cycle in which the pairs of {workers} workers differ, renewed every {every}"
            );
            assert_eq!(
                many.digest(),
                alone.digest(),
                "{law}: {workers} workers, renewed every {every}"
            );
        }
    }
}

/// With contact of edges the layers rebound; without it the upper layer goes through.
#[test]
fn edges_hold_what_would_pass_between_nodes() {
    let ends = [true, false].map(|edges| {
        let model = grid(&format!("edges = {edges}"), 13, [4.0, 2.0, -8.0], 0.0);
        let end = run_alone(&model, |_| {});
        end.contact.as_ref().unwrap().crossings(&end.nodes, end.clock.time).len()
    });
    assert_eq!(ends[0], 0);
    assert!(ends[1] > 0, "without edges the strips pass through: {ends:?}");
}
