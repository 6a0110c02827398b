//! Meshes of eight-node solids for scenes: boxes, round bars, balls, and patches that share
//! their nodes.

use super::scene::{Grid, Scene};
use std::collections::HashMap;

/// Box of nodes, n + 1 each way.
#[derive(Clone, Debug)]
pub struct Block {
    /// Nodes of the grid, then those in the middle of edges.
    nodes: Vec<u32>,
    n: [usize; 3],
    /// Twice the steps of the nodes in the middle of edges.
    middles: Vec<[usize; 3]>,
}

impl Block {
    /// Returns the node at step (i, j, k).
    pub fn at(&self, [i, j, k]: [usize; 3]) -> u32 {
        self.nodes[(i * (self.n[1] + 1) + j) * (self.n[2] + 1) + k]
    }

    /// Returns all nodes.
    pub fn all(&self) -> &[u32] {
        &self.nodes
    }

    /// Returns the nodes at step `at` along axis `c`.
    pub fn layer(&self, c: usize, at: usize) -> Vec<u32> {
        let on_grid = steps(self.n).filter(|s| s[c] == at).map(|s| self.at(s));
        let middles = &self.nodes[self.nodes.len() - self.middles.len()..];
        let on_edges = self.middles.iter().zip(middles).filter(|(s, _)| s[c] == 2 * at);
        on_grid.chain(on_edges.map(|(_, &node)| node)).collect()
    }

    /// Returns the nodes of the last layer along axis `c`.
    pub fn last(&self, c: usize) -> Vec<u32> {
        self.layer(c, self.n[c])
    }
}

/// Returns the steps from (0, 0, 0) to n, the last axis fastest.
fn steps(n: [usize; 3]) -> impl Iterator<Item = [usize; 3]> {
    (0..=n[0]).flat_map(move |i| (0..=n[1]).flat_map(move |j| (0..=n[2]).map(move |k| [i, j, k])))
}

/// Nodes by position, so that adjacent blocks share them.
#[derive(Debug)]
pub struct Weld {
    /// Distance below which two positions are the same node [m].
    grain: f64,
    nodes: HashMap<[i64; 3], u32>,
}

impl Weld {
    /// Creates an empty map; `grain` is far below any side [m].
    pub fn new(grain: f64) -> Self {
        Self { grain, nodes: HashMap::new() }
    }

    /// Returns the node at a position [m]; adds it if there is none.
    fn node(&mut self, scene: &mut Scene, x: [f64; 3]) -> u32 {
        let key = x.map(|c| (c / self.grain).round() as i64);
        *self.nodes.entry(key).or_insert_with(|| scene.node(x))
    }
}

impl Scene {
    /// Adds a grid of n by m quads; it reuses existing nodes.
    pub fn welded_grid(
        &mut self,
        part: u32,
        n: [usize; 2],
        weld: &mut Weld,
        place: impl Fn(f64, f64) -> [f64; 3],
    ) -> Grid {
        let node = |scene: &mut Self, x: [f64; 3]| weld.node(scene, x);
        self.grid_of(part, n, place, node)
    }

    /// Adds a block of n cells each way; `place` maps (0..1)^3 to coordinates [m] and preserves
    /// the orientation.
    pub fn block(
        &mut self,
        part: u32,
        n: [usize; 3],
        place: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Block {
        self.welded(part, n, None, place)
    }

    /// Adds a block like [`Scene::block`]; it reuses existing nodes.
    pub fn welded(
        &mut self,
        part: u32,
        n: [usize; 3],
        mut weld: Option<&mut Weld>,
        place: impl Fn([f64; 3]) -> [f64; 3],
    ) -> Block {
        let nodes = steps(n)
            .map(|s| {
                let x = place(std::array::from_fn(|c| s[c] as f64 / n[c] as f64));
                match weld.as_deref_mut() {
                    Some(weld) => weld.node(self, x),
                    None => self.node(x),
                }
            })
            .collect();
        let mut block = Block { nodes, n, middles: Vec::new() };
        for [i, j, k] in steps(n.map(|n| n - 1)) {
            let face = |k: usize| {
                [[i, j, k], [i + 1, j, k], [i + 1, j + 1, k], [i, j + 1, k]].map(|s| block.at(s))
            };
            let (below, above) = (face(k), face(k + 1));
            self.solid(part, std::array::from_fn(|c| if c < 4 { below[c] } else { above[c - 4] }));
        }
        let step_of: HashMap<u32, [usize; 3]> =
            steps(n).map(|step| (block.at(step), step)).collect();
        for (ends, node) in self.middles() {
            if let [Some(a), Some(b)] = ends.map(|end| step_of.get(&end)) {
                block.nodes.push(node);
                block.middles.push([0, 1, 2].map(|c| a[c] + b[c]));
            }
        }
        block
    }

    /// Adds a quarter of a round bar along z, with the planes of symmetry x = 0 and y = 0. It
    /// has `core` cells each way in the square at the axis and as many around it up to the
    /// radius, and `n` along. Returns its nodes.
    pub fn quarter_bar(
        &mut self,
        part: u32,
        radius: f64,
        length: f64,
        core: usize,
        n: usize,
    ) -> Vec<u32> {
        let side = 0.55 * radius;
        let mut weld = Weld::new(1e-6 * radius);
        // The sides of the core are curved, so that the adjacent cells are not wedges.
        let inside = |x: f64, y: f64| {
            let bulge = |t: f64| 1.0 - 0.15 * t * t;
            [side * x * bulge(y), side * y * bulge(x)]
        };
        let mut nodes = Vec::new();
        let square = self.welded(part, [core, core, n], Some(&mut weld), |[x, y, z]| {
            let [x, y] = inside(x, y);
            [x, y, length * z]
        });
        nodes.extend(square.all());
        for flip in [false, true] {
            let ring = self.welded(part, [core, core, n], Some(&mut weld), |[r, t, z]| {
                // `t` runs along the side of the core, towards its corner or back from it.
                let t = if flip { 1.0 - t } else { t };
                let [x, y] = inside(1.0, t);
                let angle = t * std::f64::consts::FRAC_PI_4;
                let (at, out) = ([x, y], [radius * angle.cos(), radius * angle.sin()]);
                let p = [at[0] + r * (out[0] - at[0]), at[1] + r * (out[1] - at[1])];
                if flip { [p[1], p[0], length * z] } else { [p[0], p[1], length * z] }
            });
            nodes.extend(ring.all());
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Adds a quarter of a ball around `centre`, with the planes of symmetry x and y, whole
    /// along z. It has `core` cells each way in each eighth of the cube in the middle and
    /// `rings` around it. Returns its nodes. `shift`, below 1, makes cells at the lower pole
    /// smaller by `(1+shift)/(1-shift)` and those at the upper pole larger: a conformal map of
    /// the ball onto itself.
    pub fn quarter_ball(
        &mut self,
        part: u32,
        (centre, radius): ([f64; 3], f64),
        [core, rings]: [usize; 2],
        shift: f64,
    ) -> Vec<u32> {
        let side = 0.5 * radius;
        let mut weld = Weld::new(1e-6 * radius);
        let mut nodes = Vec::new();
        let place = |p: [f64; 3], up: bool| {
            let z = if up { p[2] } else { -p[2] };
            let p = shifted([p[0] / radius, p[1] / radius, z / radius], -shift);
            std::array::from_fn(|c| centre[c] + radius * p[c])
        };
        // The core is half way between a cube and a ball.
        let inside = |p: [f64; 3]| {
            let most = p.iter().copied().fold(0.0f64, f64::max);
            let norm = p.iter().map(|x| x * x).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
            let onto = 1.0 - 0.4 * most * (1.0 - most / norm);
            p.map(|x| side * x * onto)
        };
        for up in [true, false] {
            // An eighth below the middle is the mirror image of the one above: two axes are
            // exchanged to keep the orientation.
            let turn = |p: [f64; 3]| if up { p } else { [p[1], p[0], p[2]] };
            let cube =
                self.welded(part, [core; 3], Some(&mut weld), |p| place(inside(turn(p)), up));
            nodes.extend(cube.all());
            for axis in 0..3 {
                let shell = self.welded(part, [rings, core, core], Some(&mut weld), |[r, a, b]| {
                    let (a, b) = if up { (a, b) } else { (b, a) };
                    let mut p = [0.0; 3];
                    (p[axis], p[(axis + 1) % 3], p[(axis + 2) % 3]) = (1.0, a, b);
                    let from = inside(p);
                    // Equal angles between nodes on the surface.
                    let out = p.map(|x| (x * std::f64::consts::FRAC_PI_4).tan());
                    let norm = out.iter().map(|x| x * x).sum::<f64>().sqrt();
                    place(
                        std::array::from_fn(|c| from[c] + r * (radius * out[c] / norm - from[c])),
                        up,
                    )
                });
                nodes.extend(shell.all());
            }
        }
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }
}

/// Adds (0, 0, a) to a point of the unit ball by Moebius addition: a map of the ball onto itself
/// that preserves angles.
fn shifted(x: [f64; 3], a: f64) -> [f64; 3] {
    let (dot, square) = (a * x[2], x.iter().map(|c| c * c).sum::<f64>());
    let (of_a, of_x) = (1.0 + 2.0 * dot + square, 1.0 - a * a);
    let under = 1.0 + 2.0 * dot + a * a * square;
    [of_x * x[0] / under, of_x * x[1] / under, (of_a * a + of_x * x[2]) / under]
}
