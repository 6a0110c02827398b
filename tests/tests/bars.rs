//! Elastic waves in bars, against one-dimensional theory: Graff, Wave Motion in Elastic Solids (1975), ch. 2.
//!
//! A bar is a strip of N square shells with Poisson's ratio 0, so that it carries plane waves of speed
//! `c = sqrt(E/rho)` and nothing else. Units mm, ms, kg.

use crumple_tests::{read, run_alone};
use crumple_worker::engine::Engine;

const LENGTH: f64 = 100.0;
const E: f64 = 207.0;
const RHO: f64 = 7.85e-6;
const THICKNESS: f64 = 1.0;
/// Speed of the bars [mm/ms]; strains are v / c = 1e-4.
const V: f64 = 0.5;

fn c() -> f64 {
    (E / RHO).sqrt()
}

/// Strips in the plane, one part each.
#[derive(Default)]
struct Bars {
    nodes: Vec<[f64; 2]>,
    shells: Vec<[usize; 5]>,
    parts: usize,
}

impl Bars {
    /// Adds a strip of `n` squares from x = `from` on.
    fn add(&mut self, from: f64, n: usize) {
        let (first, side) = (self.nodes.len(), LENGTH / n as f64);
        self.parts += 1;
        self.nodes.extend((0..=n).flat_map(|i| [0.0, side].map(|y| [from + side * i as f64, y])));
        let shell = |i: usize| [self.parts, first + 2 * i + 1, first + 2 * i + 3, first + 2 * i + 4, first + 2 * i + 2];
        self.shells.extend((0..n).map(shell));
    }

    /// Runs a job on these bars; `rest` are walls, velocities and contact. The set `first` holds the first `first` nodes.
    fn run(&self, first: usize, rest: &str, look: impl FnMut(&Engine)) -> Engine {
        let nodes = self.nodes.iter().zip(1..).map(|([x, y], id): (_, u32)| format!("[{id}, {x:?}, {y:?}, 0.0],\n"));
        let shells = self.shells.iter().zip(1..).map(|([p, a, b, c, d], id): (_, u32)| format!("[{id}, {p}, {a}, {b}, {c}, {d}],\n"));
        let (nodes, shells): (String, String) = (nodes.collect(), shells.collect());
        let set: Vec<usize> = (1..=first).collect();
        let part = |id| format!("[[part]]\nid = {id}\nmaterial = \"steel\"\nthickness = {THICKNESS:?}\npoints = 2\n");
        let parts: String = (1..=self.parts).map(part).collect();
        let text = format!(
            "end_time = {:?}\n[mesh]\nnodes = [{nodes}]\nshells = [{shells}]\nnode_sets = {{ first = {set:?} }}\n\
             [output]\nfield_interval = -1.0\n[[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = {RHO:?}\n\
             youngs_modulus = {E:?}\npoisson = 0.0\n{parts}{rest}",
            3.2 * LENGTH / c()
        );
        let there = tempfile::tempdir().unwrap();
        let path = there.path().join("bars.toml");
        std::fs::write(&path, text).unwrap();
        run_alone(&read(&path, &[]), look)
    }
}

/// Mean velocity along x and kinetic energy of a range of nodes at the last mid-step.
fn flight(e: &Engine, nodes: std::ops::Range<usize>) -> (f64, f64) {
    let sum = |f: fn(f64, f64) -> f64| nodes.clone().map(|i| f(e.nodes.mass[i], e.nodes.v[i][0])).sum::<f64>();
    (sum(|m, v| m * v) / sum(|m, _| m), sum(|m, v| 0.5 * m * v * v))
}

struct Struck {
    contact_time: f64,
    mean_force: f64,
    rebound: f64,
    lost: f64,
}

/// A bar flies end-on against a rigid wall.
fn struck(n: usize) -> Struck {
    let mut bars = Bars::default();
    bars.add(0.0, n);
    let rest = format!(
        "[[wall]]\npoint = [0.0, 0.0, 0.0]\nnormal = [1.0, 0.0, 0.0]\n[[initial_velocity]]\nvelocity = [{:?}, 0.0, 0.0]\n",
        -V
    );
    let (mut last_push, mut impulse, mut work) = (0.0, 0.0, f64::NAN);
    let end = bars.run(1, &rest, |e| {
        let now = e.walls.impulse[0][0];
        if now > impulse {
            (impulse, last_push) = (now, e.clock.time);
        }
        work = e.ledger.energies(&e.nodes).wall;
    });
    let mass = RHO * LENGTH * LENGTH / n as f64 * THICKNESS;
    let area = LENGTH / n as f64 * THICKNESS;
    let (rebound, _) = flight(&end, 0..end.nodes.held);
    Struck {
        contact_time: last_push * c() / (2.0 * LENGTH),
        mean_force: impulse / (2.0 * LENGTH / c()) / (RHO * c() * V * area),
        rebound: rebound / V,
        lost: -work / (0.5 * mass * V * V),
    }
}

/// A01 and A03: the wall holds the end for the wave's way there and back, 2L/c, with `rho c v A`, and the bar leaves as
/// fast as it came. The wall stops the end nodes for good at the touch, a plastic impact that takes their share 1/2N
/// of the energy: the loss vanishes with the mesh size, to first order.
#[test]
fn a_bar_on_a_rigid_wall_rebounds_after_two_wave_times() {
    let bars = [20, 40, 80].map(|n| (n, struck(n)));
    for (n, b) in &bars {
        eprintln!(
            "N = {n}: contact time {:.4} (2L/c), mean force {:.4} (rho c v A), rebound {:.4} v, loss {:.5} = {:.4} / 2N",
            b.contact_time,
            b.mean_force,
            b.rebound,
            b.lost,
            b.lost * 2.0 * *n as f64
        );
        assert!((b.lost * 2.0 * *n as f64 - 1.0).abs() < 0.02, "the end nodes' share, to the steps in contact: {}", b.lost);
    }
    let (_, finest) = &bars[2];
    // The front of N = 80 cells is some 3 cells wide after 160 cells (dispersion of central differences and lumped
    // masses): 1 to 2 % of the time there and back.
    assert!((finest.contact_time - 1.0).abs() < 0.02, "{}", finest.contact_time);
    assert!((finest.mean_force - 1.0).abs() < 0.02, "{}", finest.mean_force);
    // What the front's ringing keeps and what the impact took.
    assert!((finest.rebound - 1.0).abs() < 0.02, "{}", finest.rebound);
    for pair in bars.windows(2) {
        let order = (pair[0].1.lost / pair[1].1.lost).log2();
        assert!((order - 1.0).abs() < 0.03, "order {order}");
        assert!((1.0 - pair[1].1.rebound).abs() < (1.0 - pair[0].1.rebound).abs() + 1e-3, "towards 1");
    }
}

/// Two equal bars meet end to end: they exchange their velocities, so the struck one leaves with all of it, and while
/// they touch the interface carries `rho c v / 2`. Here nodes meet the rims of segments.
#[test]
fn two_equal_bars_exchange_their_velocities() {
    let mut before = f64::INFINITY;
    for n in [20, 40, 80] {
        let mut bars = Bars::default();
        bars.add(0.0, n);
        // Surfaces meet at a distance of the mean thickness; a hair's breadth of air.
        bars.add(LENGTH + THICKNESS + 1e-6, n);
        let half = 2 * (n + 1);
        let rest = format!("[[initial_velocity]]\nnodes = \"first\"\nvelocity = [{V:?}, 0.0, 0.0]\n[contact]\n");
        let (mut last_push, mut when, mut gained, mut last) = (0.0, 0.0, 0.0, 0.0f64);
        let end = bars.run(half, &rest, |e| {
            let velocity = flight(e, half..e.nodes.held).0;
            if velocity - last > 1e-9 * V {
                last_push = e.clock.time;
            }
            last = velocity;
            if e.clock.time < LENGTH / c() {
                // All that the second bar has by now came through the interface.
                (when, gained) = (e.clock.time * c() / LENGTH, velocity);
            }
        });
        let ((one, e_one), (two, e_two)) = (flight(&end, 0..half), flight(&end, half..end.nodes.held));
        let mass: f64 = end.nodes.mass[..half].iter().sum();
        let restitution = (two - one) / V;
        // Over a time t the stress s gives the bar of mass rho L A a mean velocity s t / (rho L).
        let stress = gained / V / (when / 2.0);
        let (work, brought) = (end.ledger.energies(&end.nodes).contact, 0.5 * mass * V * V);
        eprintln!(
            "N = {n}: restitution {restitution:.4}, stress {stress:.4} (rho c v / 2), touch for {:.4} (2L/c), \
             contact work {:.5} of the energy = {:.3} / 2N, in motion {:.4}",
            last_push * c() / (2.0 * LENGTH),
            work / brought,
            work / brought * 2.0 * n as f64,
            (e_one + e_two) / brought,
        );
        assert!(((one + two) / V - 1.0).abs() < 1e-12, "momentum to round-off");
        assert!(work < 0.0, "contact adds no energy: {work} of {brought}");
        let gap = (1.0 - restitution).abs();
        assert!(gap < before, "towards 1 as the mesh gets finer: {gap} after {before}");
        before = gap;
        if n == 80 {
            assert!(gap < 0.02 && (stress - 1.0).abs() < 0.02, "restitution {restitution}, stress {stress}");
        }
    }
}
