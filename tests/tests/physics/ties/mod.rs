//! Nodes tied to surfaces. Units mm, ms, kg.

mod contact;
mod failure;
mod jobs;
mod mean;
mod motion;
mod release;

use crumple::input::job::{self, Model};
use crumple_proto::ids::NodeId;
use crumple_tests::run_alone;
use crumple_verification::scene::{Elastic, Grid, Scene};
use crumple_verification::solids::Block;
use crumple_worker::energy::momentum;
use crumple_worker::engine::Engine;

const E: f64 = 207.0;
const RHO: f64 = 7.85e-6;
/// Length of each bar, its side, and the length of its cells [mm].
const LENGTH: f64 = 60.0;
const SIDE: f64 = 4.0;
const CELL: f64 = 1.0;

/// Ties the end of the second of two bars to the first one.
const TIE: &str = "[[tie]]\nname = \"joint\"\nnodes = \"end\"\nparts = [1]\n";

/// Returns a scene with steel and without bodies.
fn steel(end_time: f64) -> Scene {
    let mut scene = Scene::new(end_time).in_units("mm, ms, kg");
    scene.elastic("steel", Elastic { e: E, nu: 0.0, rho: RHO });
    scene
}

/// Adds a plate of shells of thickness 1 perpendicular to the third axis.
fn plate(scene: &mut Scene, part: u32, [a, b]: [[f64; 2]; 2], z: f64, n: [usize; 2]) -> Grid {
    scene.part(part, "steel", 1.0, "");
    scene.grid(part, n, |u, v| [a[0] + (b[0] - a[0]) * u, a[1] + (b[1] - a[1]) * v, z])
}

/// Adds a block of solids from one corner to the opposite one.
fn block(scene: &mut Scene, part: u32, [a, b]: [[f64; 3]; 2], n: [usize; 3]) -> Block {
    scene.solid_part(part, "steel", "");
    scene.block(part, n, |at| [0, 1, 2].map(|c| a[c] + (b[c] - a[c]) * at[c]))
}

/// Reads the job of a scene.
fn model(scene: &Scene) -> Result<Model, String> {
    let model = job::read_text("ties.toml".into(), scene.text("Ties"), &[]);
    model.map_err(|report| report.to_string())
}

/// Returns two bars end to end, with 2 x 2 and 3 x 3 cells in the cross section, and the second
/// one. The nodes at its end towards the first bar, at the distance `gap`, are the set `end`; all
/// its nodes are the set `second`.
fn bars(end_time: f64, gap: f64) -> (Scene, Block) {
    let mut scene = steel(end_time);
    let along = (LENGTH / CELL) as usize;
    block(&mut scene, 1, [[0.0; 3], [LENGTH, SIDE, SIDE]], [along, 2, 2]);
    let corners = [[LENGTH + gap, 0.0, 0.0], [2.0 * LENGTH, SIDE, SIDE]];
    let second = block(&mut scene, 2, corners, [along, 3, 3]);
    scene.set_named("end", &second.layer(0, 0));
    scene.set_named("second", second.all());
    (scene, second)
}

/// Returns the local index of a node.
fn local(e: &Engine, node: u32) -> usize {
    e.nodes.local_index(NodeId(node.into())).expect("one worker has all nodes") as usize
}

/// Returns the position of a node [mm].
fn position(e: &Engine, node: u32) -> [f64; 3] {
    let x = e.nodes.x[local(e, node)];
    [0, 1, 2].map(|c| x[c])
}

/// Returns the position of a node by its id [mm].
fn position_of(e: &Engine, id: NodeId) -> [f64; 3] {
    position(e, id.0 as u32)
}

/// Conserved quantities of a free run: the largest changes of momentum and angular momentum
/// since the first step seen, and the largest error of the energy as a fraction of the initial
/// energy.
#[derive(Default)]
struct Watch {
    first: Option<[[f64; 3]; 2]>,
    changed: [f64; 2],
    initial: f64,
    unexplained: f64,
}

impl Watch {
    fn record(&mut self, e: &Engine) {
        let (p, l) = momentum(&e.nodes);
        let first = *self.first.get_or_insert([p, l]);
        for ((changed, now), then) in self.changed.iter_mut().zip([p, l]).zip(first) {
            *changed = (0..3).map(|c| (now[c] - then[c]).abs()).fold(*changed, f64::max);
        }
        let energies = e.ledger.energies(&e.nodes, &e.blocks).values();
        if e.clock.cycle == 1 {
            self.initial = energies.balance(0.0);
        }
        self.unexplained =
            self.unexplained.max(energies.balance(self.initial).abs() / self.initial);
    }
}
