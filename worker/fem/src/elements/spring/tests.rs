//! Laws of springs against closed forms, and the step at which a mode begins to grow.

use super::unloading::{BetweenCurves, PermanentSet};
use super::*;
use crumple_proto::job::{
    BetweenCurvesSpring, ElastoplasticSpring, HysteresisSpring, MaxwellSpring, OneSidedSpring,
    PermanentSetSpring, SpringHardening, SpringSide, YieldingSpring,
};

/// Checks the amplification polynomial: at the stable step a mode grows at most linearly, just
/// above it without bound.
#[test]
fn the_stable_step_is_where_a_mode_begins_to_grow() {
    for (stiffness, damping) in [(3.0, 0.0), (0.0, 0.7), (3.0, 0.7), (3.0, 20.0)] {
        let mu = 1.0 / 2.0 + 1.0 / 5.0;
        let limit =
            Discrete { stiffness, damping, along_line: true, rotational: false }.stable_dt(mu);
        let largest = |dt: f64| {
            let (mut x, mut v, mut most) = (1.0f64, 1.0f64, 0.0f64);
            for _ in 0..4000 {
                v -= dt * mu * (stiffness * x + damping * v);
                x += dt * v;
                most = most.max(x.abs());
            }
            most
        };
        assert!(largest(0.999 * limit) < 1e3, "{stiffness} {damping}: {}", largest(0.999 * limit));
        assert!(largest(1.01 * limit) > 1e6, "{stiffness} {damping}: {}", largest(1.01 * limit));
    }
    let nothing = Discrete { stiffness: 0.0, damping: 0.0, along_line: true, rotational: false };
    assert_eq!(nothing.stable_dt(1.0), f64::INFINITY);
}

/// Returns the law of a spring, or the problems of its part.
fn law_of(input: &SpringInput) -> Result<Box<dyn SpringLaw>, Vec<String>> {
    let mut said = Vec::new();
    let mut say = |key: &str, what: String, _: &str| said.push(format!("{key}: {what}"));
    let law = LAWS.iter().find_map(|(_, law)| law(input, &mut say)).expect("a law with a memory");
    law.ok_or(said)
}

fn elastoplastic(tangent_stiffness: f64) -> SpringInput {
    let law = ElastoplasticSpring { stiffness: 10.0, tangent_stiffness, yield_force: 3.0 };
    SpringInput { elastoplastic: Some(law), ..SpringInput::default() }
}

fn hysteresis(
    loading: &[[f64; 2]],
    unloading: &[[f64; 2]],
    yield_forces: Option<[f64; 2]>,
) -> SpringInput {
    let hardening = match yield_forces {
        Some(_) => SpringHardening::Isotropic,
        None => SpringHardening::Independent,
    };
    let [loading, unloading] = [loading, unloading].map(<[_]>::to_vec);
    let law = HysteresisSpring { loading, unloading, hardening, yield_forces };
    SpringInput { hysteresis: Some(law), ..SpringInput::default() }
}

fn isotropic() -> SpringInput {
    let loading = [[-2.0, -3.0], [0.0, 0.0], [1.0, 4.0], [3.0, 6.0]];
    hysteresis(&loading, &[[0.0, 1.0], [1.0, 9.0]], Some([-1.5, 4.0]))
}

fn independent() -> SpringInput {
    let loading = [[-2.0, -1.0], [-1.0, -4.0], [0.0, 0.0], [1.0, 4.0], [2.0, 1.0]];
    hysteresis(&loading, &[[-1.0, -4.0], [0.0, 0.0], [0.5, 5.0]], None)
}

fn one_sided(carries: SpringSide, unloading_stiffness: f64) -> SpringInput {
    let loading = vec![[0.0, 0.0], [1.0, 2.0], [2.0, 6.0]];
    let law = OneSidedSpring { loading, unloading_stiffness, carries };
    SpringInput { one_sided: Some(law), ..SpringInput::default() }
}

const K0: f64 = 10.0;
const KI: f64 = 4.0;
const DECAY: f64 = 0.5;

fn maxwell(ageing: bool, cutoff_time: Option<f64>) -> SpringInput {
    let law = MaxwellSpring {
        short_time_stiffness: K0,
        long_time_stiffness: KI,
        decay: DECAY,
        ageing,
        cutoff_time,
        cutoff_force: cutoff_time.map_or(0.0, |_| 7.0),
    };
    SpringInput { maxwell: Some(law), ..SpringInput::default() }
}

/// Returns what a constructor builds, or what it says.
fn built(
    build: impl FnOnce(&mut AddSpringProblem<'_>) -> SpringLawResult,
) -> Result<Box<dyn SpringLaw>, String> {
    let mut said = Vec::new();
    let law = build(&mut |key: &str, what: String, _: &str| said.push(format!("{key}: {what}")));
    law.ok_or(said.join("\n"))
}

fn yielding(yield_force: &[[f64; 2]]) -> Result<Box<dyn SpringLaw>, String> {
    let input = YieldingSpring { stiffness: 10.0, yield_force: yield_force.to_vec() };
    built(|say| boxed(Plastic::yielding(&input, say)))
}

fn between_curves(
    loading: &[[f64; 2]],
    unloading: &[[f64; 2]],
    stiffness: f64,
) -> Result<Box<dyn SpringLaw>, String> {
    let [loading, unloading] = [loading, unloading].map(<[_]>::to_vec);
    let input = BetweenCurvesSpring { loading, unloading, stiffness };
    built(|say| boxed(BetweenCurves::new(&input, say)))
}

fn permanent_set(loading: &[[f64; 2]], fraction: f64) -> Result<Box<dyn SpringLaw>, String> {
    let input = PermanentSetSpring { loading: loading.to_vec(), fraction };
    built(|say| boxed(PermanentSet::new(&input, say)))
}

/// Slopes 4 and 1 in tension, 2 in compression; half of the forces for unloading.
const LOADING: [[f64; 2]; 4] = [[-2.0, -4.0], [0.0, 0.0], [1.0, 4.0], [3.0, 6.0]];
const HALF: [[f64; 2]; 4] = [[-2.0, -2.0], [0.0, 0.0], [1.0, 2.0], [3.0, 3.0]];

/// Checks the force at each elongation of a path, which is reached from the one before it in one
/// step and in a hundred. The closed forms are exact, so the error is that of rounding.
fn follows(input: &SpringInput, path: &[[f64; 2]]) {
    law_follows(&*law_of(input).expect("a sound spring"), path);
}

fn law_follows(law: &dyn SpringLaw, path: &[[f64; 2]]) {
    for steps in [1, 100] {
        let mut state = vec![0.0; law.names().len()];
        let mut from = 0.0;
        for &[to, exact] in path {
            let mut force = 0.0;
            for k in 1..=steps {
                let way = from + (to - from) * f64::from(k) / f64::from(steps);
                force = law.force(&mut state, way, 0.1);
            }
            from = to;
            assert!((force - exact).abs() < 1e-12 * exact.abs().max(1.0), "{to}: {force} {exact}");
        }
    }
}

/// k = 10, k_t = 2, F_y = 3: it yields at 0.3 with 3 + 2 0.7 = 4.4 at 1, at -4.4 in compression,
/// and then at 6.4 in tension.
#[test]
fn bilinear_springs_harden_alike_on_both_sides() {
    let path = [
        [0.2, 2.0],
        [1.0, 4.4],
        [0.5, -0.6],
        [0.9, 3.4],
        [0.12, -4.4],
        [-0.88, -6.4],
        [0.3, 5.4],
        [0.4, 6.4],
        [0.6, 6.8],
    ];
    follows(&elastoplastic(2.0), &path);
    follows(&elastoplastic(0.0), &[[1.0, 3.0], [0.5, -2.0], [0.2, -3.0], [0.5, 0.0], [2.0, 3.0]]);
}

/// Loading slopes 4 and 1 in tension, 1.5 in compression, unloading slope 8. It is elastic between
/// -1.5 and 4. After 5 in tension it yields at -5 (at 0.75), after -5.75 (at 0.25) at 5.75 (at
/// 1.6875).
#[test]
fn two_curves_with_isotropic_hardening() {
    let path = [
        [0.5, 2.0],
        [-0.5, -0.75],
        [2.0, 5.0],
        [1.5, 1.0],
        [0.75, -5.0],
        [0.25, -5.75],
        [1.6875, 5.75],
        [1.8375, 5.9],
    ];
    follows(&isotropic(), &path);
}

/// Both sides soften: the force falls from 4 at 1 to 1 at 2. Unloading has the slope 10 in tension
/// and 4 in compression. From 1.25 without force, compression begins at the origin of its curve;
/// tension goes on at 2.5, where it stopped. A curve that has fallen to zero stays there.
#[test]
fn two_curves_of_independent_sides_that_soften() {
    let path = [
        [1.5, 2.5],
        [1.35, 1.0],
        [1.25, 0.0],
        [0.25, -4.0],
        [-0.25, -2.5],
        [0.375, 0.0],
        [0.625, 2.5],
        [0.875, 1.75],
        [1.875, 0.0],
        [1.775, -0.4],
    ];
    follows(&independent(), &path);
}

/// The unloading stiffness is the larger of the given one and the steepest slope of loading, 4.
#[test]
fn one_sided_springs_keep_a_part_of_their_elongation() {
    let path =
        [[1.5, 4.0], [1.0, 2.0], [0.5, 0.0], [-1.0, 0.0], [0.75, 1.0], [2.0, 6.0], [1.75, 5.0]];
    follows(&one_sided(SpringSide::Tension, 3.0), &path);
    follows(&one_sided(SpringSide::Compression, 0.0), &path.map(|p| p.map(|x| -x)));
    let stiff = [[-1.5, -4.0], [-1.4, -3.0], [-1.1, 0.0], [3.0, 0.0], [-1.2, -1.0], [-2.0, -6.0]];
    follows(&one_sided(SpringSide::Compression, 10.0), &stiff);
}

/// At a constant rate v, `F = K_i v t + (K_0 - K_i) v (1 - e^(-beta t))/beta`; then at constant
/// elongation the second part falls as `e^(-beta t)`. Ageing and cutoff follow the time.
#[test]
fn maxwell_springs_relax_exponentially() {
    for steps in [1, 50] {
        let each = 2.0 / f64::from(steps);
        let run = |input: &SpringInput, rate: f64| {
            let law = law_of(input).expect("a sound spring");
            let mut state = vec![0.0; law.names().len()];
            let mut force = law.force(&mut state, 0.0, 0.0);
            assert_eq!(force, 0.0);
            for k in 1..=steps {
                force = law.force(&mut state, rate * each * f64::from(k), each);
            }
            let loaded = force;
            for _ in 0..steps {
                force = law.force(&mut state, 2.0 * rate, each);
            }
            [loaded, force]
        };
        let (rate, fallen) = (0.3, f64::exp(-DECAY * 2.0));
        let part = (K0 - KI) * rate * (1.0 - fallen) / DECAY;
        let steady = KI * rate * 2.0;
        let ageing = |time: f64| (KI + (K0 - KI) * (-DECAY * time).exp()) * 2.0 * rate;
        for (input, exact) in [
            (maxwell(false, None), [steady + part, steady + part * fallen]),
            (maxwell(true, None), [ageing(2.0), ageing(4.0)]),
            (maxwell(false, Some(3.0)), [steady + part, 7.0]),
        ] {
            for (found, exact) in run(&input, rate).into_iter().zip(exact) {
                assert!((found / exact - 1.0).abs() < 1e-13, "{found} {exact}");
            }
        }
    }
}

/// k = 10, `F_y = 3 + 2 p`: at 1 it has yielded by p = 7/12 and has 25/6. Turned around, it yields
/// at -25/6 (at 1/6), and has `-(3 + 2 p)` with 10 (s - 7/12 + q) and p = 7/12 + q after: at -1, 10
/// (-19/12 + q) = -25/6 - 2 q, so that q = 35/36.
#[test]
fn yield_forces_follow_the_plastic_elongation_of_both_directions() {
    let linear = yielding(&[[0.0, 3.0], [1.0, 5.0]]).expect("a law");
    let (p, q) = (7.0 / 12.0, 35.0 / 36.0);
    let turned = -(3.0 + 2.0 * (p + q));
    let path = [
        [0.2, 2.0],
        [1.0, 25.0 / 6.0],
        [0.6, 1.0 / 6.0],
        [1.0 / 6.0, -25.0 / 6.0],
        [-1.0, turned],
        [-1.0 - 2.0 * turned / 10.0, -turned],
    ];
    law_follows(&*linear, &path);
    // The same as bilinear plasticity with k_t = 10 2/(10 + 2).
    law_follows(&*law_of(&elastoplastic(10.0 / 6.0)).expect("a law"), &path);
}

/// k = 10. Tension falls from 4 to 1 while p grows to 1, and to zero at 4/3; compression stays at
/// 6. At s = 0.8 p = 4/7 with 10 (s - p) = 4 - 3 p. Compression by p = 1/2 more, 15/14 in all,
/// leaves 4 - 45/14 to tension. A force of zero remains.
#[test]
fn yield_forces_may_fall_on_one_side() {
    let law = yielding(&[[-1.0, -6.0], [-1e-9, -6.0], [1e-9, 4.0], [1.0, 1.0]]).expect("a law");
    let p = 4.0 / 7.0;
    let path = [
        [0.1, 1.0],
        [0.8, 4.0 - 3.0 * p],
        [p - 0.6, -6.0],
        [p - 0.6 - 0.5, -6.0],
        [p - 0.5 + 0.1 * (4.0 - 45.0 / 14.0), 4.0 - 45.0 / 14.0],
        [p + 5.0, 0.0],
        [p + 4.5, -5.0],
    ];
    // The curve has its jump at 0 within 1e-9: forces are off by its slope of 3 there.
    let mut state = vec![0.0; law.names().len()];
    for [way, exact] in path {
        let force = law.force(&mut state, way, 0.1);
        assert!((force - exact).abs() < 1e-7, "{way}: {force} {exact}");
    }
}

/// K = 8 between slopes of 4 and 2 (after 1: 1 and 0.5) in tension, 2 and 1 in compression: from 5
/// at 2 it falls to the lower curve, 2.3 at 1.6 (5 - 8 0.4 is less), follows it, and rises to the
/// upper one, 4.5 at 1.5.
#[test]
fn a_force_between_curves_goes_from_one_to_the_other() {
    let law = between_curves(&LOADING, &HALF, 8.0).expect("a law");
    let path = [
        [2.0, 5.0],
        [1.75, 3.0],
        [1.9, 4.2],
        [1.75, 3.0],
        [1.6, 2.3],
        [1.0, 2.0],
        [1.125, 3.0],
        [1.5, 4.5],
        [0.5, 1.0],
        [-1.0, -2.0],
        [-0.9375, -1.5],
        [-0.8, -0.8],
        [0.5, 2.0],
    ];
    law_follows(&*law, &path);
    // A loop to 1 and back takes the area between the curves, less that of the steep line.
    let mut state = vec![0.0; 2];
    let (mut work, mut before) = (0.0, 0.0);
    let steps = 100_000;
    for k in 1..=2 * steps {
        let way = 1.0 - (1.0 - f64::from(k) / f64::from(steps)).abs();
        let force = law.force(&mut state, way, 0.1);
        work += 0.5 * (before + force) * if k <= steps { 1.0 } else { -1.0 } / f64::from(steps);
        before = force;
    }
    // From 4 at 1 with the slope 8 to 2 s at 2/3: a triangle of the height 1/3 and the side 2.
    let exact = 0.5 * 4.0 - 0.5 * 2.0 - 0.5 * 2.0 / 3.0;
    assert!((work - exact).abs() < 1e-4, "corners within steps of 1e-5: {work} {exact}");
}

/// Unloaded from 2 with the fraction 0.25 it has its set at 0.5 and `5 ((s - 0.5)/1.5)^2`; loaded
/// again it is the same to 2, and then the curve. Compression has its own set.
#[test]
fn a_permanent_set_is_a_fraction_of_the_largest_elongation() {
    let law = permanent_set(&LOADING, 0.25).expect("a law");
    let at = |s: f64| 5.0 * (s - 0.5) * (s - 0.5) / 2.25;
    let path = [
        [0.5, 2.0],
        [2.0, 5.0],
        [1.5, at(1.5)],
        [0.6, at(0.6)],
        [0.5, 0.0],
        [0.25, 0.0],
        [-1.0, -2.0],
        [-0.625, -0.5],
        [-0.25, 0.0],
        [1.0, at(1.0)],
        [3.0, 6.0],
    ];
    law_follows(&*law, &path);
}

/// The laws of discrete beams.
fn laws_of_beams() -> Vec<Box<dyn SpringLaw>> {
    let all = [
        yielding(&[[0.0, 3.0], [1.0, 5.0]]),
        yielding(&[[0.0, 3.0], [0.5, 3.0], [1.0, 5.0]]),
        yielding(&[[-1.0, -6.0], [-1e-3, -6.0], [1e-3, 4.0], [1.0, 1.0]]),
        between_curves(&LOADING, &HALF, 8.0),
        between_curves(&LOADING, &LOADING, 4.0),
        permanent_set(&LOADING, 0.25),
        permanent_set(&LOADING, 0.0),
    ];
    all.into_iter().map(|law| law.expect("a sound spring")).collect()
}

fn all_laws() -> Vec<SpringInput> {
    vec![
        elastoplastic(2.0),
        elastoplastic(0.0),
        isotropic(),
        independent(),
        one_sided(SpringSide::Tension, 3.0),
        one_sided(SpringSide::Compression, 10.0),
        maxwell(false, None),
        maxwell(true, None),
    ]
}

/// All laws with a memory.
fn every_law() -> Vec<Box<dyn SpringLaw>> {
    let of_springs = all_laws().into_iter().map(|input| law_of(&input).expect("a sound spring"));
    of_springs.chain(laws_of_beams()).collect()
}

/// On a random path from rest the work done on a spring never becomes negative: what it stores
/// and what it dissipates are not. The steps are short against the pieces of the curves; the
/// trapezoidal rule misses less than 1e-3 at their corners.
#[test]
fn no_spring_gives_back_more_work_than_it_took() {
    for (number, law) in every_law().iter().enumerate() {
        let mut random = 12345u64 + number as u64;
        for _ in 0..200 {
            let mut state = vec![0.0; law.names().len()];
            let (mut way, mut before, mut work) = (0.0, 0.0, 0.0);
            for _ in 0..8 {
                random = random.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
                let target = 4.0 * ((random >> 33) as f64 / f64::from(1u32 << 31) - 0.5);
                let step = (target - way) / 1000.0;
                for _ in 0..1000 {
                    way += step;
                    let force = law.force(&mut state, way, 0.01);
                    work += 0.5 * (before + force) * step;
                    before = force;
                    assert!(work > -1e-3, "law {number}: {work} at {way}");
                }
            }
        }
    }
}

/// No force changes by more than the steepest slope times the change of the elongation.
#[test]
fn the_steepest_slope_bounds_the_force() {
    for (number, law) in every_law().iter().enumerate() {
        let mut state = vec![0.0; law.names().len()];
        let (mut way, mut before) = (0.0f64, 0.0f64);
        for k in 1..20000 {
            let now = 1e-4 * f64::from(k) * (0.01 * f64::from(k)).sin();
            let force = law.force(&mut state, now, 1e-4);
            let most = law.steepest() * (now - way).abs() + 1e-3 * K0 * DECAY;
            assert!((force - before).abs() <= most, "law {number} at {now}: {force} {before}");
            (way, before) = (now, force);
        }
    }
}

/// The largest step, by bisection, at which a small oscillation stays bounded is at least the step
/// of the steepest slope: about the origin, and about the force of a spring that has yielded and is
/// being unloaded.
#[test]
fn springs_with_a_memory_are_stable_at_their_step() {
    let of = |input: &SpringInput| law_of(input).expect("a sound spring");
    let mut laws: Vec<_> = all_laws().iter().map(|i| (of(i), i.maxwell.is_some())).collect();
    laws.extend(laws_of_beams().into_iter().map(|law| (law, false)));
    for decay in [0.0, 0.05, 3.0, 30.0] {
        let mut input = maxwell(false, None);
        input.maxwell.as_mut().expect("a law").decay = decay;
        laws.push((of(&input), true));
    }
    let mu = 0.7;
    for (number, (law, relaxes)) in laws.iter().enumerate() {
        let stiffness = law.steepest();
        let discrete = Discrete { stiffness, damping: 0.0, along_line: true, rotational: false };
        let reported = discrete.stable_dt(mu);
        let is_stable = |dt: f64, path: &[f64]| {
            let mut state = vec![0.0; law.names().len()];
            let (mut about, mut held) = (0.0, 0.0);
            for &way in path {
                (about, held) = (way, law.force(&mut state, way, 0.0));
            }
            let (mut x, mut v) = (1e-6f64, 0.0f64);
            for _ in 0..4000 {
                v -= dt * mu * (law.force(&mut state, about + x, dt) - held);
                x += dt * v;
                if x.abs() > 1e-2 {
                    return false;
                }
            }
            true
        };
        for path in [&[][..], &[1.5, 1.45], &[-1.5, -1.45]] {
            // Relaxation moves the force that is subtracted.
            if *relaxes && !path.is_empty() {
                continue;
            }
            let (mut low, mut high) = (0.5 * reported, 4.0 * reported);
            for _ in 0..40 {
                let middle = 0.5 * (low + high);
                if is_stable(middle, path) { low = middle } else { high = middle }
            }
            assert!(low > 0.9999 * reported, "law {number} after {path:?}: {low} {reported}");
        }
    }
}

/// Each error of a law is named, and two at once.
#[test]
fn wrong_numbers_are_named() {
    let of = |input: &SpringInput| law_of(input).err().unwrap_or_default().join("\n");
    let mut bad = elastoplastic(12.0);
    bad.elastoplastic.as_mut().expect("a law").yield_force = 0.0;
    let said = of(&bad);
    assert!(
        said.contains("yield_force is 0") && said.contains("tangent_stiffness is 12"),
        "{said}"
    );
    let line = [[0.0, 0.0], [1.0, 4.0]];
    for (loading, unloading, forces, what) in [
        (&line[..], &[[0.0, 0.0], [1.0, 3.0]][..], None, "less steep than loading at the force"),
        (&[[0.0, 1.0], [1.0, 4.0]], &line, None, "has the force 1 at 0, not 0"),
        (&[[0.0, 0.0], [1.0, -4.0]], &line, None, "has the force -4.0 at 1.0"),
        (&line, &[[0.0, 0.0], [1.0, 0.0]], None, "unloading does not ascend"),
        (&line, &[], None, "unloading has no points"),
        (&[[0.0, 0.0], [1.0, 4.0], [2.0, 3.0]], &line, Some([-1.0, 1.0]), "loading descends"),
        (&line, &line, Some([1.0, 1.0]), "yield_forces are 1, 1"),
        (
            &[[-1.0, -4.0], [0.0, 0.0], [1.0, 4.0], [2.0, 4.0]],
            &line,
            Some([-1.0, 5.0]),
            "loading does not reach the yield_forces -1, 5",
        ),
    ] {
        let said = of(&hysteresis(loading, unloading, forces));
        assert!(said.contains(what), "{what}: {said}");
    }
    let mut bad = one_sided(SpringSide::Tension, -1.0);
    bad.one_sided.as_mut().expect("a law").loading[0] = [0.5, 0.0];
    let said = of(&bad);
    assert!(said.contains("unloading_stiffness is -1"), "{said}");
    bad.one_sided.as_mut().expect("a law").unloading_stiffness = 0.0;
    assert!(of(&bad).contains("loading begins at [0.5, 0.0]"), "{}", of(&bad));
    let mut bad = maxwell(false, Some(-1.0));
    bad.maxwell.as_mut().expect("a law").long_time_stiffness = 11.0;
    let said = of(&bad);
    assert!(
        said.contains("long_time_stiffness is 11") && said.contains("cutoff_time is -1"),
        "{said}"
    );
}

/// Curves with which a law of discrete beams would not be what it is, or give work.
#[test]
fn wrong_curves_of_beams_are_named() {
    let line = [[0.0, 0.0], [1.0, 4.0]];
    let stiffening = [[0.0, 0.0], [1.0, 0.1], [2.0, 10.0]];
    for (law, what) in [
        (yielding(&[[0.0, 3.0]]), "yield_force has one point only"),
        (yielding(&[[0.0, 3.0], [1.0, -5.0]]), "yield_force has the wrong sign at 1.0"),
        (yielding(&[[0.0, 0.0], [1.0, 0.0]]), "yield_force is zero"),
        (yielding(&[[0.0, 20.0], [1.0, 10.0]]), "yield_force falls as steeply as `stiffness`"),
        (between_curves(&line, &line, 3.0), "stiffness is 3.0, a curve has the slope 4.0"),
        (between_curves(&HALF, &LOADING, 8.0), "unloading has a larger force than loading at -2.0"),
        (between_curves(&line, &[[0.0, 0.0], [1.0, 2.0], [2.0, 1.0]], 8.0), "unloading descends"),
        (between_curves(&[[0.0, 1.0], [1.0, 4.0]], &line, 8.0), "has the force 1 at 0, not 0"),
        (permanent_set(&line, 1.0), "fraction is 1"),
        (permanent_set(&stiffening, 0.0), "loading takes less work up to"),
    ] {
        let said = law.err().unwrap_or_default();
        assert!(said.contains(what), "no {what} in {said}");
    }
    assert!(permanent_set(&stiffening, 0.8).is_ok());
}
