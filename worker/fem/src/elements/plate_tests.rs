//! Known solutions with a minimal explicit solver, and the step at which elements and meshes lose
//! stability.

use super::testing::*;
use crumple_proto::job::{LayerInput, Part};
use crumple_proto::mesh::OwnSection;
use crumple_proto::partition::{Material, Param};

/// Quarter of a square plate of side `a`, simply supported outside, symmetric inside, with its
/// loads and supports.
struct Quarter {
    patch: Patch,
    masses: Vec<(f64, f64)>,
    n: usize,
    side: f64,
    /// True if a supported edge may not rotate about its normal either, as in Kirchhoff's plate.
    hard: bool,
}

impl Quarter {
    fn new(part: Part, material: Material, n: usize, a: f64, triangular: bool, hard: bool) -> Self {
        let (nodes, quads) = grid(n, n, 0.5 * a, 0.5 * a);
        let cells = if triangular { triangles(&quads) } else { quads };
        let patch = Patch::new(part, material, &nodes, &cells);
        let masses = patch.masses();
        Self { patch, masses, n, side: 0.5 * a / n as f64, hard }
    }

    /// Advances one step under a pressure along z, with supports on x = a/2 and y = a/2.
    fn step(&mut self, dt: f64, pressure: f64) -> super::testing::Passed {
        let (n, side, hard) = (self.n, self.side, self.hard);
        let at = |node: usize| (node % (n + 1), node / (n + 1));
        let share = |k: usize| if k == 0 || k == n { 0.5 } else { 1.0 };
        let load = |node: usize| {
            let (i, j) = at(node);
            [0.0, 0.0, pressure * side * side * share(i) * share(j)]
        };
        self.patch.explicit(dt, &self.masses, load, |node, v, w| {
            let (i, j) = at(node);
            if i == 0 {
                (v[0], w[1], w[2]) = (0.0, 0.0, 0.0);
            }
            if j == 0 {
                (v[1], w[0], w[2]) = (0.0, 0.0, 0.0);
            }
            if i == n {
                (v[2], w[0]) = (0.0, if hard { 0.0 } else { w[0] });
            }
            if j == n {
                (v[2], w[1]) = (0.0, if hard { 0.0 } else { w[1] });
            }
        })
    }

    fn stable_dt(&self) -> f64 {
        let all = (0..self.patch.cells.len())
            .map(|e| self.patch.element.stable_dt(&self.patch.corners(e), OwnSection::default()));
        all.fold(f64::INFINITY, f64::min)
    }
}

/// Returns the frequency of a vibration, from the zeros of the values of `sample` after each step
/// of `dt`.
fn frequency(dt: f64, mut sample: impl FnMut() -> f64) -> f64 {
    let (mut zeros, mut last, mut time) = (Vec::new(), 0.0, 0.0);
    while zeros.len() < 5 {
        let value = sample();
        if last * value < 0.0 {
            // Linear interpolation between the two steps.
            zeros.push(time + dt * last / (last - value));
        }
        (last, time) = (value, time + dt);
    }
    2.0 / (zeros[4] - zeros[0])
}

/// Returns a part of layers of equal thickness with these angles [degrees].
fn layers(element: &str, thickness: f64, angles: &[f64]) -> Part {
    let layer = |&angle: &f64| LayerInput {
        thickness: thickness / angles.len() as f64,
        material: String::new(),
        angle,
        points: 2,
    };
    Part { layer: angles.iter().map(layer).collect(), ..part_of(element, thickness) }
}

/// First mode of a cantilever of plies [0/90/90/0] along x (Euler-Bernoulli): 1.8751^2/(2 pi L^2)
/// sqrt(D/(rho t)), with D from the moduli of the plies since there is no contraction. The loss to
/// transverse shear is 0.2 %.
#[test]
fn cantilever_of_layers_swings_at_its_frequency() {
    let (ea, eb, g, t) = (210e9, 30e9, 60e9, 0.004);
    let numbers =
        [("youngs_modulus", ea), ("youngs_modulus_b", eb), ("poisson", 0.0), ("shear_modulus", g)];
    let mut ply = material("orthotropic", 7850.0, &numbers);
    ply.parameters.insert("direction".into(), Param::List(vec![1.0, 0.0, 0.0]));
    // The outer halves of the thickness have 7/8 of the second moment.
    let bending = (7.0 * ea + eb) / 8.0 * f64::powi(t, 3) / 12.0;
    let root = 1.875104_f64;
    let wanted = root * root / (std::f64::consts::TAU * 0.04) * (bending / (7850.0 * t)).sqrt();
    for (element, triangular) in FORMULATIONS {
        let (nodes, quads) = grid(20, 2, 0.2, 0.02);
        let cells = if triangular { triangles(&quads) } else { quads };
        let part = layers(element, t, &[0.0, 90.0, 90.0, 0.0]);
        let mut patch = Patch::new(part, ply.clone(), &nodes, &cells);
        let found = cantilever_frequency(&mut patch);
        assert_close(found, wanted, 0.01 * wanted, element);
    }
}

/// Verification A16: the (1,1) mode of a simply supported square plate, 491.0 Hz by Mindlin.
#[test]
fn simply_supported_plate_swings_at_its_frequency() {
    for (element, triangular) in FORMULATIONS {
        // m, s, kg: 0.2 m square, 4 mm steel, 16 x 16 over the whole plate.
        let mut plate = Quarter::new(
            part_of(element, 0.004),
            elastic(210e9, 0.3, 7850.0),
            8,
            0.2,
            triangular,
            true,
        );
        // A start in the shape of the mode does not excite the others.
        for (v, x) in plate.patch.v.iter_mut().zip(&plate.patch.x) {
            let shape = |x: f64| (std::f64::consts::PI * x / 0.2).cos();
            v[2] = 1e-3 * shape(x[0]) * shape(x[1]);
        }
        let dt = 0.9 * plate.stable_dt();
        let found = frequency(dt, || {
            plate.step(dt, 0.0);
            plate.patch.x[0][2]
        });
        assert_close(found, 491.0, 0.01 * 491.0, "16 x 16 over the plate: quads 0.6 % low");
    }
}

/// Returns the frequency of the first mode of a strip of 20 by 2 cells, 0.2 m long, held at x = 0.
pub fn cantilever_frequency<const C: usize>(patch: &mut Patch<C>) -> f64 {
    let masses = patch.masses();
    // Near enough to the first mode: others are a few per cent and average out over the vibration.
    for (v, x) in patch.v.iter_mut().zip(&patch.x) {
        let s = x[0] / 0.2;
        v[2] = 1e-3 * s * s * (6.0 - 4.0 * s + s * s) / 3.0;
    }
    let dt = 0.9
        * (0..patch.cells.len())
            .map(|e| patch.element.stable_dt(&patch.corners(e), OwnSection::default()))
            .fold(1.0, f64::min);
    frequency(dt, || {
        patch.explicit(
            dt,
            &masses,
            |_| [0.0; 3],
            |node, v, w| {
                if node % 21 == 0 {
                    (*v, *w) = ([0.0; 4], [0.0; 4]);
                }
            },
        );
        patch.x[20][2]
    })
}

/// Verification A15: first mode of a cantilever strip, 83.55 Hz; nu = 0 makes it a beam.
#[test]
fn cantilever_swings_at_its_frequency() {
    for (element, triangular) in FORMULATIONS {
        let (nodes, quads) = grid(20, 2, 0.2, 0.02);
        let cells = if triangular { triangles(&quads) } else { quads };
        let mut patch =
            Patch::new(part_of(element, 0.004), elastic(210e9, 0.0, 7850.0), &nodes, &cells);
        let found = cantilever_frequency(&mut patch);
        assert_close(found, 83.55, 0.01 * 83.55, "20 elements long");
    }
}

/// Verification B08: centre of an elastic-plastic plate under a step pressure (Belytschko, Lin &
/// Tsay 1984).
#[test]
fn elastic_plastic_plate_peaks_where_others_do() {
    let numbers = [("youngs_modulus", 68.95e9), ("poisson", 0.3), ("yield_stress", 206.84e6)];
    let aluminium = material("j2", 2765.8, &numbers);
    let peak = |element: &str, n: usize, triangular: bool| {
        let mut plate =
            Quarter::new(part_of(element, 0.0127), aluminium.clone(), n, 0.254, triangular, false);
        let dt = 0.9 * plate.stable_dt();
        let (mut peak, mut when, mut time) = (0.0, 0.0, 0.0);
        let (mut internal, mut hourglass) = (0.0, 0.0);
        while time < 1.0e-3 {
            let totals = plate.step(dt, 2.0684e6);
            assert_eq!(totals.trouble, None);
            (internal, hourglass) = (internal + totals.internal, hourglass + totals.hourglass);
            time += dt;
            let z = plate.patch.x[0][2];
            if z > peak {
                (peak, when) = (z, time);
            }
        }
        assert!(hourglass.abs() < 0.02 * internal, "hourglass energy {hourglass} of {internal}");
        (peak, when)
    };
    let (height, when) = peak("belytschko_tsay", 8, false);
    assert_close(
        height,
        7.62e-3,
        0.02 * 7.62e-3,
        "7.55 to 7.64 mm in the reference for 4 to 16 elements per side",
    );
    assert_close(when, 0.75e-3, 0.03 * 0.75e-3, "0.745 to 0.770 ms in the reference");

    // Shear that is elastic over the whole element is too stiff where plastic hinges cross it; the
    // error decreases with the mesh size.
    let off = [4, 8].map(|n| 1.0 - peak("stabilised_quad", n, false).0 / 7.62e-3);
    assert!(
        off[0] < 0.07 && off[1] < 0.04,
        "6.3 % and 3.6 % with 4 and 8 per side, 1.8 % with 16: {off:?}"
    );

    // Constant-strain triangles are too stiff where membrane and bending mix, and converge with the
    // first order of h.
    let off = [4, 8].map(|n| 1.0 - peak("c0_triangle", n, true).0 / 7.62e-3);
    assert!(
        off[0] < 0.18 && off[1] < 0.08,
        "16 % and 7 % with 4 and 8 per side, 3.5 % with 16: {off:?}"
    );
}

/// Returns the largest step for which a free mesh is stable, over the smallest stable step of its
/// elements; the criterion is growth from noise.
fn critical(nodes: &[[f64; 3]], cells: &[[u32; 4]], part: &Part, nu: f64) -> f64 {
    critical_of(nodes, cells, part, &elastic(1.0, nu, 1.0))
}

/// Returns [`critical`] for a material.
fn critical_of(nodes: &[[f64; 3]], cells: &[[u32; 4]], part: &Part, material: &Material) -> f64 {
    let grows = |factor: f64| {
        let mut patch = Patch::new(part.clone(), material.clone(), nodes, cells);
        let masses = patch.masses();
        let all = (0..cells.len())
            .map(|e| patch.element.stable_dt(&patch.corners(e), OwnSection::default()));
        let dt = factor * all.fold(f64::INFINITY, f64::min);
        let mut noise = Noise(1);
        for (v, w) in patch.v.iter_mut().zip(&mut patch.w) {
            (0..3).for_each(|i| (v[i], w[i]) = (1e-12 * noise.next(), 1e-12 * noise.next()));
        }
        for _ in 0..600 {
            patch.explicit(dt, &masses, |_| [0.0; 3], |_, _, _| ());
        }
        !patch.v.iter().flatten().all(|v| v.abs() <= 1e-9)
    };
    let (mut low, mut high) = (0.5, 2.0);
    while high - low > 0.004 {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

/// Meshes are stable at the step of their elements, times the usual 0.9.
#[test]
fn the_step_is_stable_with_the_usual_safety() {
    for (nu, t) in [(0.0, 0.01), (0.3, 0.01), (0.3, 0.5), (0.45, 0.01)] {
        for (nx, ny, width, height) in
            [(8, 1, 8.0, 1.0), (2, 2, 2.0, 2.0), (8, 1, 4.0, 1.0), (1, 1, 3.0, 1.0)]
        {
            let (nodes, quads) = grid(nx, ny, width, height);
            for (element, triangular) in FORMULATIONS {
                let cells = if triangular { triangles(&quads) } else { quads.clone() };
                let limit = critical(&nodes, &cells, &part_of(element, t), nu);
                assert!(
                    limit > 0.91,
                    "{element}: nu {nu}, t {t}, {nx} x {ny} of {width} x {height}: {limit}"
                );
            }
        }
        // A single triangle has its exact bound, or nearly so at nu = 0, where shear determines the
        // step.
        for (x, y) in [(0.5, 0.75_f64.sqrt()), (0.5, 0.2), (0.5, 2.0), (0.0, 1.0)] {
            let nodes = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [x, y, 0.0]];
            let limit = critical(&nodes, &[[0, 1, 2, 2]], &part(t), nu);
            assert!(limit > 0.92, "one triangle to {x}, {y}: nu {nu}, t {t}: {limit}");
        }
    }
}

/// The same for plies that are twenty times stiffer along their fibres.
#[test]
fn the_step_of_layers_is_stable_with_the_usual_safety() {
    let numbers = [
        ("youngs_modulus", 20.0),
        ("youngs_modulus_b", 1.0),
        ("poisson", 0.015),
        ("shear_modulus", 0.5),
    ];
    let ply = material("orthotropic", 1.0, &numbers);
    for (t, (nx, ny, width)) in [(0.01, (4, 1, 4.0)), (0.5, (2, 2, 2.0)), (0.01, (1, 1, 3.0))] {
        let (nodes, quads) = grid(nx, ny, width, ny as f64);
        for (element, triangular) in FORMULATIONS {
            let cells = if triangular { triangles(&quads) } else { quads.clone() };
            for angles in [&[0.0][..], &[0.0, 90.0], &[45.0, -45.0], &[30.0]] {
                let limit = critical_of(&nodes, &cells, &layers(element, t, angles), &ply);
                assert!(limit > 0.91, "{element}: t {t}, {nx} x {ny}, {angles:?}: {limit}");
            }
        }
    }
}

/// Verification A23(c): a free square is stable for 1/sqrt(1 + nu) of L/c and no more, for any
/// thickness; its step is 1.05 of that.
#[test]
fn a_lone_square_is_stable_at_its_step_with_the_usual_safety() {
    let (nodes, quads) = grid(1, 1, 1.0, 1.0);
    for t in [0.01, 0.5] {
        for element in QUADS {
            let part = part_of(element, t);
            let limit = critical(&nodes, &quads, &part, 0.3);
            // The fully integrated quad uses 0.95 of the step, because of stretched elements.
            let own = if element == "fully_integrated_quad" { 0.95 } else { 1.0 };
            assert_close(own * limit, 1.0 / 1.05, 0.004, "bisection to 0.004");
            let step = Patch::new(part, elastic(1.0, 0.3, 1.0), &nodes, &quads)
                .element
                .stable_dt(&nodes_of(&nodes), OwnSection::default());
            let c = (1.0 / (1.0 - 0.3 * 0.3_f64)).sqrt();
            assert_close(limit * step * c, 1.0 / 1.3_f64.sqrt(), 0.004, "bisection to 0.004");
        }
    }
}

fn nodes_of(nodes: &[[f64; 3]]) -> [[f64; 3]; 4] {
    [0, 1, 3, 2].map(|n: usize| nodes[n])
}

/// Single quads and triangles of any shape, thickness and Poisson's ratio.
#[test]
fn any_lone_element_is_stable_at_its_step_with_the_usual_safety() {
    let quads = [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]];
    let shears: [fn([f64; 2]) -> [f64; 2]; 5] = [
        |x| x,
        |x| [x[0] + 0.7 * x[1], x[1]],
        |x| [x[0] + 2.0 * x[1], x[1]],
        |x| [(x[0] - 0.5) * (1.0 - 0.7 * x[1]), x[1]],
        |x| if x == [1.0, 1.0] { [0.7, 0.6] } else { x },
    ];
    let mut worst = [("", f64::INFINITY); FORMULATIONS.len()];
    for ratio in [1.0, 2.0, 5.0, 20.0] {
        for shear in &shears {
            for nu in [0.0, 0.3, 0.49] {
                for t in [0.01, 0.1, 0.5] {
                    let nodes = quads.map(|x| {
                        let [x, y] = shear(x);
                        [ratio * x, y, 0.0]
                    });
                    for (k, (element, triangular)) in FORMULATIONS.into_iter().enumerate() {
                        let cell = if triangular { [0, 1, 2, 2] } else { [0, 1, 2, 3] };
                        let nodes = if triangular { &nodes[..3] } else { &nodes[..] };
                        let limit = critical(nodes, &[cell], &part_of(element, t), nu);
                        if limit < worst[k].1 {
                            worst[k] = (element, limit);
                        }
                    }
                }
            }
        }
    }
    assert!(worst.iter().all(|w| w.1 > 0.92), "0.933 for squares with nu = 0: {worst:?}");
}

/// Squares whose corners are alternately above and below their plane, up to upright sides.
#[test]
fn any_warped_element_is_stable_at_its_step_with_the_usual_safety() {
    let mut worst = [("", f64::INFINITY, 0.0); QUADS.len()];
    for warp in [0.1, 0.25, 0.5, 1.0, 2.0] {
        let nodes = [[0.0, 0.0, warp], [1.0, 0.0, -warp], [1.0, 1.0, warp], [0.0, 1.0, -warp]];
        for (k, element) in QUADS.into_iter().enumerate() {
            for t in [0.02, 0.1, 0.5] {
                let limit = critical(&nodes, &[[0, 1, 2, 3]], &part_of(element, t), 0.3);
                if limit < worst[k].1 {
                    worst[k] = (element, limit, warp);
                }
            }
        }
    }
    assert!(
        worst.iter().all(|w| w.1 > 0.91),
        "0.920 for a stabilised quad that rises by a fifth of its side: {worst:?}"
    );
}
