//! Springs with a memory compared with closed forms: masses that yield, bounce and relax; the
//! stable step; the same bits on any number of workers. Units of the closed forms.

use super::springs::{Balance, HELD, job, model};
use crumple::input::job::Model;
use crumple_tests::{run_alone, run_side_by_side};
use crumple_verification::scene::{Elastic, Scene};
use crumple_worker::engine::Engine;

/// Mass of the moving node, and its velocity at the start.
const M: f64 = 2.0;
const V: f64 = 3.0;

/// Returns a mass at x = 20 on a spring from the origin, with the velocity `v` along x.
fn oscillator(numbers: &str, v: f64, end_time: f64, time: &str) -> Model {
    let rest = format!(
        "{HELD}[[mass]]\nnodes = \"n2\"\nmass = {M:?}\n\
         [[initial_velocity]]\nnodes = \"n2\"\nvelocity = [{v:?}, 0.0, 0.0]\n"
    );
    job(&[[0.0; 3], [20.0, 0.0, 0.0]], &[([1, 2], numbers)], end_time, [time, &rest])
}

/// Energy that the springs have taken [energy].
fn internal(e: &Engine) -> f64 {
    e.ledger.energies(&e.nodes, &e.blocks).values().internal
}

/// A mass stretches a spring that yields (k = 10, k_t = 2, F_y = 3) to the elongation at which its
/// work is m v^2/2, and then swings about the plastic elongation with the amplitude F/k: the range
/// between both yield forces. What remains is dissipated.
#[test]
fn a_mass_yields_its_spring_once() {
    let (k, kt, fy) = (10.0, 2.0, 3.0);
    let numbers = "[part.spring.elastoplastic]\nstiffness = 10.0\ntangent_stiffness = 2.0\n\
                   yield_force = 3.0";
    let two = "[part.spring.hysteresis]\nloading = [[-0.6, -3.6], [-0.3, -3.0], [0.3, 3.0], \
               [0.6, 3.6]]\nunloading = [[0.0, 0.0], [1.0, 10.0]]\nhardening = \"isotropic\"\n\
               yield_forces = [-3.0, 3.0]";
    let free = "[part.spring.hysteresis]\nloading = [[-0.6, -3.6], [-0.3, -3.0], [0.0, 0.0], \
                [0.3, 3.0], [0.6, 3.6]]\nunloading = [[0.0, 5.0], [1.0, 15.0]]";
    // With x beyond yield: k_t x^2/2 + F_y x = m v^2/2 - F_y^2/(2 k).
    let left = 0.5 * M * V * V - 0.5 * fy * fy / k;
    let beyond = ((fy * fy + 2.0 * kt * left).sqrt() - fy) / kt;
    let (largest, force) = (fy / k + beyond, fy + kt * beyond);
    let [w, dissipated] = [f64::sqrt(k / M), 0.5 * M * V * V - 0.5 * force * force / k];
    let time = format!("dt_max = {:?}", 0.002 / w);
    for (numbers, to) in [(numbers, -1.0), (two, -1.0), (free, 0.0)] {
        let (mut most, mut least, mut balance) = (0.0f64, f64::INFINITY, Balance::default());
        let (mut lowest, mut taken) = (f64::INFINITY, 0.0f64);
        run_alone(&oscillator(numbers, V, 3.0, &time), |e| {
            let way = e.nodes.x[1][0] - 20.0;
            most = most.max(way);
            if e.clock.time > 1.0 {
                least = least.min(way);
                lowest = lowest.min(internal(e));
            }
            taken = taken.max(internal(e));
            balance.record(e);
        });
        // Half a period after the largest elongation; a spring without force in compression before
        // the origin of its second curve yields there.
        assert!((most / largest - 1.0).abs() < 1e-4, "{numbers}: {most} {largest}");
        if to < 0.0 {
            let back = largest - 2.0 * force / k;
            assert!((least / back - 1.0).abs() < 1e-3, "{numbers}: {least} {back}");
            assert!((lowest / dissipated - 1.0).abs() < 1e-3, "{numbers}: {lowest} {dissipated}");
        }
        assert!((taken / (0.5 * M * V * V) - 1.0).abs() < 1e-4, "{numbers}: {taken}");
        assert!(balance.worst < 1e-11, "{numbers}: round-off: {}", balance.worst);
    }
}

/// A mass runs into a buffer with the loading stiffness k and the unloading stiffness 4 k: half of
/// its velocity returns, and three quarters of its energy are dissipated. Then nothing holds it.
#[test]
fn a_buffer_gives_half_of_the_velocity_back() {
    let numbers = "[part.spring.one_sided]\nloading = [[0.0, 0.0], [1.0, 10.0]]\n\
                   unloading_stiffness = 40.0\ncarries = \"compression\"";
    let mut balance = Balance::default();
    let model = oscillator(numbers, -V, 3.0, "dt_max = 1e-4");
    let end = run_alone(&model, |e| balance.record(e));
    let back = end.nodes.v[1][0] / V;
    // The force vanishes within a step: w dt = 4e-4.
    assert!((back - 0.5).abs() < 1e-3, "{back}");
    assert!((internal(&end) / (0.375 * M * V * V) - 1.0).abs() < 1e-3, "{}", internal(&end));
    assert!(balance.worst < 1e-10, "round-off: {}", balance.worst);
}

/// A mass on a spring that relaxes: x is a sum of exponentials with the roots of `l^3 + beta l^2 +
/// K_0/m l + beta K_i/m`, with x = 0, x' = v, x'' = 0 at the start.
#[test]
fn a_mass_on_a_relaxing_spring_follows_its_three_roots() {
    let (k0, ki, beta) = (10.0, 4.0, 0.8);
    let numbers = "[part.spring.maxwell]\nshort_time_stiffness = 10.0\nlong_time_stiffness = 4.0\n\
                   decay = 0.8";
    let value = |l: f64| ((l + beta) * l + k0 / M) * l + beta * ki / M;
    let (mut low, mut high) = (-beta, 0.0);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if value(middle) < 0.0 { low = middle } else { high = middle }
    }
    // (l - a)(l^2 - 2 p l + p^2 + q^2)
    let a = low;
    let p = -0.5 * (beta + a);
    let q = (beta * ki / M / -a - p * p).sqrt();
    // x = A e^(a t) + e^(p t) (B cos q t + C sin q t): B = -A, A a + p B + q C = v,
    // A a^2 + (p^2 - q^2) B + 2 p q C = 0.
    let over = (a * a - p * p + q * q) - 2.0 * p * (a - p);
    let first = -2.0 * p * V / over;
    let sine = (V - first * (a - p)) / q;
    let exact = |t: f64| {
        first * (a * t).exp() + (p * t).exp() * (sine * (q * t).sin() - first * (q * t).cos())
    };
    let (mut worst, mut balance) = (0.0f64, Balance::default());
    run_alone(&oscillator(numbers, V, 8.0, "dt_max = 1e-3"), |e| {
        let x = e.nodes.x[1][0] - 20.0;
        worst = worst.max((x - exact(e.clock.time)).abs());
        balance.record(e);
    });
    // Central differences: 8 w (w dt)^2/24 of the amplitude, 8e-6.
    assert!(worst < 2e-5, "{worst}");
    assert!(balance.worst < 1e-11, "round-off: {}", balance.worst);
}

/// The step is that of the largest slope of both curves, 2 (m/k)^(1/2), also where loading is soft;
/// at 0.99 of it nothing grows, before and after the spring has yielded: linear oscillations reach
/// 7 times their velocity.
#[test]
fn the_step_is_that_of_the_steepest_slope() {
    let bilinear = "[part.spring.elastoplastic]\nstiffness = 40.0\nyield_force = 3.0";
    let curves = "[part.spring.hysteresis]\nloading = [[-1.0, -10.0], [0.0, 0.0], [1.0, 10.0]]\n\
                  unloading = [[0.0, 0.0], [1.0, 40.0]]";
    let sided = "[part.spring.one_sided]\nloading = [[0.0, 0.0], [0.5, 20.0], [1.0, 25.0]]\n\
                 unloading_stiffness = 1.0\ncarries = \"tension\"";
    let maxwell = "[part.spring.maxwell]\nshort_time_stiffness = 40.0\ndecay = 3.0";
    for numbers in [bilinear, curves, sided, maxwell] {
        let mut most = 0.0f64;
        let model = oscillator(numbers, 0.1 * V, 200.0, "safety = 0.99\ndt_min_ratio = 0.0");
        let end = run_alone(&model, |e| most = most.max(e.nodes.v[1][0].abs()));
        // Whole steps reach the end, so that they are up to one part in their number shorter.
        let ratio = end.clock.first_dt / (0.99 * 2.0 * f64::sqrt(M / 40.0));
        assert!((0.99..=1.0 + 1e-12).contains(&ratio), "{numbers}: {ratio}");
        assert!(most < 0.8 * V, "{numbers}: {most}");
    }
}

/// A sheet of shells on springs of all laws to the ground: the same bits on 1, 2 and 3 workers,
/// with forced renewals of the boxes.
#[test]
fn bits_of_springs_with_a_memory_do_not_depend_on_workers() {
    let mut scene = Scene::new(3.0).in_units("mm, ms, kg");
    scene.elastic("steel", Elastic { e: 207.0, nu: 0.3, rho: 7.85e-6 });
    scene.part(1, "steel", 1.0, "");
    let sheet = scene.grid(1, [4, 4], |u, v| [40.0 * u, 40.0 * v, 0.0]);
    let ground: Vec<u32> = (0..25)
        .map(|n| scene.node([10.0 * f64::from(n / 5), 10.0 * f64::from(n % 5), -8.0]))
        .collect();
    for (n, &node) in sheet.all().iter().enumerate() {
        scene.spring(2 + n as u32 % 4, [node, ground[n]]);
    }
    scene.set_named("ground", &ground);
    scene.set_named("sheet", sheet.all());
    scene.add(
        "[[part]]\nid = 2\n[part.spring.elastoplastic]\nstiffness = 0.02\n\
         tangent_stiffness = 0.002\nyield_force = 0.01\n\
         [[part]]\nid = 3\n[part.spring]\ndamping = 1e-5\n[part.spring.hysteresis]\n\
         loading = [[-1.0, -0.01], [0.0, 0.0], [0.5, 0.01], [2.0, 0.005]]\n\
         unloading = [[-1.0, -0.02], [0.0, 0.0], [0.5, 0.02]]\n\
         [[part]]\nid = 4\n[part.spring.one_sided]\nloading = [[0.0, 0.0], [1.0, 0.02]]\n\
         unloading_stiffness = 0.05\ncarries = \"compression\"\n\
         [[part]]\nid = 5\n[part.spring.maxwell]\nshort_time_stiffness = 0.03\n\
         long_time_stiffness = 0.01\ndecay = 2.0\n\
         [[fix]]\nnodes = \"ground\"\ndofs = [\"x\", \"y\", \"z\"]\n\
         [[initial_velocity]]\nnodes = \"sheet\"\nvelocity = [0.5, 0.2, -4.0]\n",
    );
    let model = model(&scene);
    let serial = run_side_by_side(&model, 1, 600, 0);
    assert!(serial.trouble.is_none(), "{:?}", serial.trouble);
    for (workers, force) in [(2, 0), (3, 0), (2, 7), (3, 11)] {
        let parallel = run_side_by_side(&model, workers, 600, force);
        assert_eq!(serial.digest(), parallel.digest(), "{workers} workers, renewed every {force}");
    }
}
