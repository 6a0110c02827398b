//! Known solutions on a bare explicit solver, and the step at which elements and meshes lose stability.

use super::testing::*;
use crumple_proto::job::Part;
use crumple_proto::partition::Material;

/// Quarter of a square plate of side `a`, simply supported outside, symmetric inside; loads and supports of it.
struct Quarter {
    patch: Patch,
    masses: Vec<(f64, f64)>,
    n: usize,
    side: f64,
    /// Whether a supported edge may not turn about its normal either, as in Kirchhoff's plate.
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

    /// One step under a pressure along z; supports on x = a/2 and y = a/2.
    fn step(&mut self, dt: f64, pressure: f64) -> super::PassTotals {
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
        let all = (0..self.patch.quads.len()).map(|e| self.patch.element.stable_dt(&self.patch.corners(e)));
        all.fold(f64::INFINITY, f64::min)
    }
}

/// Verification A16: the (1,1) mode of a simply supported square plate, 491.0 Hz by Mindlin. A step pressure swings
/// it about its static deflection, and its period is read from the zeros of the centre's velocity.
#[test]
fn simply_supported_plate_swings_at_its_frequency() {
    for triangular in [false, true] {
        // m, s, kg: 0.2 m square, 4 mm steel, 16 x 16 over the whole plate.
        let mut plate = Quarter::new(part(0.004), elastic(210e9, 0.3, 7850.0), 8, 0.2, triangular, true);
        let dt = 0.9 * plate.stable_dt();
        let (mut time, mut minima, mut last) = (0.0, Vec::new(), 0.0);
        // A start in the shape of the mode leaves the others quiet.
        for node in 0..plate.patch.x.len() {
            let x = plate.patch.x[node];
            let (cx, cy) = ((std::f64::consts::PI * x[0] / 0.2).cos(), (std::f64::consts::PI * x[1] / 0.2).cos());
            plate.patch.v[node][2] = 1e-3 * cx * cy;
        }
        while minima.len() < 5 {
            plate.step(dt, 0.0);
            let z = plate.patch.x[0][2];
            if last < 0.0 && z >= 0.0 || last > 0.0 && z <= 0.0 {
                // Straight line between the two steps.
                minima.push(time + dt * last / (last - z));
            }
            last = z;
            time += dt;
        }
        let frequency = 2.0 / (minima[4] - minima[0]);
        let why = "16 x 16 over the plate: 1.3 % at 8 x 8, and the support leaves tangential rotation free";
        println!("{triangular} {frequency}");
        assert_close(frequency, 491.0, 0.015 * 491.0, why);
    }
}

/// Verification B08: centre of an elastic-plastic plate under a step pressure (Belytschko, Lin & Tsay 1984).
#[test]
fn elastic_plastic_plate_peaks_where_others_do() {
    let numbers = [("youngs_modulus", 68.95e9), ("poisson", 0.3), ("yield_stress", 206.84e6)];
    let plate = material("j2", 2765.8, &numbers);
    for (n, triangular, r) in [(8,false,0.03),(4,true,0.03),(8,true,0.03),(16,true,0.03),(8,true,0.0),(16,true,0.0),(8,true,1.0)] {
        let mut plate = Quarter::new(Part{hourglass_coefficient: r, ..part(0.0127)}, plate.clone(), n, 0.254, triangular, false);
        let dt = 0.9 * plate.stable_dt();
        let (mut peak, mut when, mut time) = (0.0, 0.0, 0.0);
        let (mut internal, mut hourglass) = (0.0, 0.0);
        while time < 1.0e-3 {
            let totals = plate.step(dt, 2.0684e6);
            assert!(!totals.trouble);
            (internal, hourglass) = (internal + totals.internal, hourglass + totals.hourglass);
            time += dt;
            let z = plate.patch.x[0][2];
            if z > peak {
                (peak, when) = (z, time);
            }
        }
        println!("{triangular} {n} {r} {peak} {when} {}", hourglass / internal);
        if triangular {continue}
        assert_close(peak, 7.62e-3, 0.02 * 7.62e-3, "7.55 to 7.64 mm in the reference for 4 to 16 elements a side");
        assert_close(when, 0.75e-3, 0.03 * 0.75e-3, "0.745 to 0.770 ms in the reference");
        assert!(hourglass.abs() < 0.02 * internal, "hourglass energy {hourglass} of {internal}");
    }
}

/// Largest step that a free mesh bears, over the smallest stable step of its elements: grows or not from noise.
fn critical(nodes: &[[f64; 3]], cells: &[[u32; 4]], part: &Part, nu: f64) -> f64 {
    let grows = |factor: f64| {
        let mut patch = Patch::new(part.clone(), elastic(1.0, nu, 1.0), nodes, cells);
        let masses = patch.masses();
        let all = (0..cells.len()).map(|e| patch.element.stable_dt(&patch.corners(e)));
        let dt = factor * all.fold(f64::INFINITY, f64::min);
        let mut noise = Noise(1);
        for (v, w) in patch.v.iter_mut().zip(&mut patch.w) {
            (0..3).for_each(|i| (v[i], w[i]) = (1e-12 * noise.next(), 1e-12 * noise.next()));
        }
        for _ in 0..600 {
            patch.explicit(dt, &masses, |_| [0.0; 3], |_, _, _| ());
        }
        patch.v.iter().flatten().any(|v| !(v.abs() <= 1e-9))
    };
    let (mut low, mut high) = (0.5, 2.0);
    while high - low > 0.004 {
        let middle = 0.5 * (low + high);
        if grows(middle) { high = middle } else { low = middle }
    }
    0.5 * (low + high)
}

#[test]
fn explore() {
    for nu in [0.0, 0.3, 0.49] {
        for t in [0.01, 0.5] {
            let part = part(t);
            for (nx, ny, w, h) in [(1, 1, 1.0, 1.0), (8, 1, 8.0, 1.0), (2,2,2.,2.), (4, 4, 4.0, 4.0), (8, 8, 8.0, 8.0), (1, 1, 3.0, 1.0), (8, 1, 4.0, 1.0),(8,1,16.,1.)] {
                let (nodes, quads) = grid(nx, ny, w, h);
                let q = critical(&nodes, &quads, &part, nu);
                let tr = critical(&nodes, &triangles(&quads), &part, nu);
                println!("nu {nu} t {t} {nx}x{ny} of {w}x{h}: quads {q:.3} triangles {tr:.3}");
            }
            let tri = vec![[0.,0.,0.],[1.,0.,0.],[0.5,0.75f64.sqrt(),0.]];
            println!("nu {nu} t {t} one equilateral {:.3}", critical(&tri,&[[0,1,2,2]],&part,nu));
            let tri = vec![[0.,0.,0.],[1.,0.,0.],[0.5,0.2,0.]];
            println!("nu {nu} t {t} one flat {:.3}", critical(&tri,&[[0,1,2,2]],&part,nu));
            let tri = vec![[0.,0.,0.],[1.,0.,0.],[0.5,2.0,0.]];
            println!("nu {nu} t {t} one needle {:.3}", critical(&tri,&[[0,1,2,2]],&part,nu));
            for q in [[[0.,0.,0.],[4.,0.,0.],[3.,2.,0.],[1.,2.,0.]],[[0.,0.,0.],[1.,0.,0.],[1.6,1.,0.],[0.6,1.,0.]],[[0.,0.,0.],[1.,0.,0.],[1.0,0.2,0.],[0.,1.,0.]],[[0.,0.,0.],[1.,0.,0.],[0.6,0.6,0.],[0.,1.,0.]]] {
            println!("nu {nu} t {t} odd quad {:.3}", critical(&q,&[[0,1,2,3]],&part,nu)); }
        }
    }
}
