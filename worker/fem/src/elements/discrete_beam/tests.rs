//! Tests of one discrete beam: with prescribed motion of its nodes, and free.

use super::*;
use crate::elements::testing::part;
use crumple_proto::job::{AxisSpring, BeamAxis, DiscreteBeamInput, YieldingSpring};

const ALL: [BeamAxis; AXES] =
    [BeamAxis::R, BeamAxis::S, BeamAxis::T, BeamAxis::Rr, BeamAxis::Rs, BeamAxis::Rt];

fn spring(axis: BeamAxis, stiffness: f64, damping: f64) -> AxisSpring {
    AxisSpring {
        axis,
        stiffness,
        force_elongation: Vec::new(),
        damping,
        force_rate: Vec::new(),
        yielding: None,
        hysteresis: None,
        between_curves: None,
        permanent_set: None,
        preload: 0.0,
        initial_displacement: 0.0,
        failure_tension: None,
        failure_compression: None,
        failure_force: None,
    }
}

/// Returns a part with a spring of stiffness 1, 2, ... 6 and a damper of a tenth of it, times
/// `damping`, on each axis.
fn part_of(turns_with: TurningNode, damping: f64) -> Part {
    let spring = ALL.into_iter().zip(1..).map(|(axis, k)| {
        let k = f64::from(k);
        spring(axis, k, 0.1 * damping * k)
    });
    let input = DiscreteBeamInput {
        mass: 2.0,
        inertia: 3.0,
        axes: [[1.0, 1.0, 0.0], [0.0, 2.0, 1.0]],
        turns_with,
        along_line: false,
        spring: spring.collect(),
        failure: BeamFailure::Together,
    };
    Part { material: String::new(), discrete_beam: Some(input), ..part(0.0) }
}

fn beam(turns_with: TurningNode, damping: f64) -> DiscreteBeam {
    read(&part_of(turns_with, damping)).unwrap_or_else(|e| panic!("{e:?}"))
}

/// Returns force and moments of a beam whose nodes move through `places` with rotational velocities
/// `w` in steps of 1.
fn led(beam: &DiscreteBeam, places: &[[V3; 2]], w: &[[V3; 2]]) -> [V3; 3] {
    let mut state = vec![0.0; beam.columns()];
    let mut loads = [V3::zeros(); 3];
    for (k, &x) in places.iter().enumerate() {
        let before = places[k.saturating_sub(1)];
        let v = [0, 1].map(|c| x[c] - before[c]);
        let (w, dt) = if k == 0 { ([V3::zeros(); 2], 0.0) } else { (w[k - 1], 1.0) };
        loads = beam.respond(&mut state, &NodeMotion { x, v, w }, dt);
    }
    loads
}

const WAYS: [TurningNode; 3] = [TurningNode::Both, TurningNode::First, TurningNode::Second];

/// A beam that is rotated by several full turns about a slanted axis in large steps, and moved, has
/// no force beyond round-off: 100 products of quaternions.
#[test]
fn no_rigid_motion_strains_it() {
    let axis = V3::new(1.0, -2.0, 0.5).normalize() * 0.4;
    let turned = |k: usize, p: V3| {
        AxesRotation::from_scaled_axis(axis * k as f64) * p + V3::new(0.1, 0.2, -0.3) * k as f64
    };
    for ends in [[V3::new(1.0, 0.2, 0.0), V3::new(3.0, 0.5, 0.4)], [V3::new(1.0, 0.2, 0.0); 2]] {
        let places: Vec<[V3; 2]> = (0..=100).map(|k| ends.map(|p| turned(k, p))).collect();
        for turns_with in WAYS {
            let loads = led(&beam(turns_with, 1.0), &places, &[[axis; 2]; 100]);
            let largest: f64 = loads.iter().map(|load| load.norm()).sum();
            assert!(largest < 1e-11, "{turns_with:?}: {largest}");
        }
    }
}

fn along_line(turns_with: TurningNode, damping: f64) -> DiscreteBeam {
    let mut part = part_of(turns_with, damping);
    part.discrete_beam.as_mut().expect("a discrete beam").along_line = true;
    read(&part).unwrap_or_else(|e| panic!("{e:?}"))
}

/// With r along the line: no force in rigid motions in large steps, whose rotation is exact.
#[test]
fn no_rigid_motion_strains_a_beam_along_its_line() {
    let axis = V3::new(1.0, -2.0, 0.5).normalize() * 0.4;
    let ends = [V3::new(1.0, 0.2, 0.0), V3::new(3.0, 0.5, 0.4)];
    let turned = |k: usize, p: V3| AxesRotation::from_scaled_axis(axis * k as f64) * p;
    let places: Vec<[V3; 2]> = (0..=100).map(|k| ends.map(|p| turned(k, p))).collect();
    for turns_with in WAYS {
        let loads = led(&along_line(turns_with, 1.0), &places, &[[axis; 2]; 100]);
        let largest: f64 = loads.iter().map(|load| load.norm()).sum();
        assert!(largest < 1e-11, "{turns_with:?}: {largest}");
    }
}

/// With r along the line of length 2: a stretch has the force k_r times its change, as it turns the
/// line by a right angle about nodes that do not rotate the displacements across it are the arc, 2
/// times the angle (within the sines of 1000 steps, 4.1e-7); a node that turns about t shears it by
/// the arc too. The moments balance the couple of the forces.
#[test]
fn a_beam_along_its_line_is_stretched_and_sheared() {
    let x = V3::new;
    let mut part = part_of(TurningNode::Second, 0.0);
    let input = part.discrete_beam.as_mut().expect("a discrete beam");
    (input.axes, input.along_line) = ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], true);
    let beam = read(&part).unwrap_or_else(|e| panic!("{e:?}"));
    let steps = 1000;
    let angle = |k: usize| std::f64::consts::FRAC_PI_2 * k as f64 / steps as f64;
    let balanced = |loads: [V3; 3], line: V3| {
        let net = line.cross(&loads[0]) + loads[1] + loads[2];
        assert!(net.norm() < 1e-13, "{net}");
    };
    let still = vec![[V3::zeros(); 2]; steps];
    let stretched: Vec<_> =
        (0..=steps).map(|k| [V3::zeros(), x(2.0 + angle(k), 0.0, 0.0)]).collect();
    let loads = led(&beam, &stretched, &still);
    assert!((loads[0] - x(angle(steps), 0.0, 0.0)).norm() < 1e-12, "{}", loads[0]);
    balanced(loads, stretched[steps][1]);
    // The line turns from x to y: at its end s points to -x.
    let turned: Vec<_> =
        (0..=steps).map(|k| [V3::zeros(), x(angle(k).cos(), angle(k).sin(), 0.0) * 2.0]).collect();
    let loads = led(&beam, &turned, &still);
    let arc = 2.0 * angle(steps);
    assert!((loads[0] - x(-2.0 * arc, 0.0, 0.0)).norm() < 4.2e-7 * 2.0 * arc, "{}", loads[0]);
    balanced(loads, turned[steps][1]);
    let held = vec![[V3::zeros(), x(2.0, 0.0, 0.0)]; steps + 1];
    let spun = vec![[V3::zeros(), x(0.0, 0.0, angle(1))]; steps];
    let loads = led(&beam, &held, &spun);
    assert!((loads[0] - x(0.0, -2.0 * arc, 0.0)).norm() < 4.2e-7 * 2.0 * arc, "{}", loads[0]);
    balanced(loads, held[0][1]);
}

/// Returns a beam with these springs and criterion, along x, y and z.
fn beam_of(spring: Vec<AxisSpring>, failure: BeamFailure) -> DiscreteBeam {
    let mut part = part_of(TurningNode::Both, 0.0);
    let input = part.discrete_beam.as_mut().expect("a discrete beam");
    (input.axes, input.spring, input.failure) =
        ([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]], spring, failure);
    read(&part).unwrap_or_else(|e| panic!("{e:?}"))
}

/// Limits of 2 and 1 along r, of 0.5 in both directions along s, and of a force of 3 along t: each
/// criterion lets a beam hold just below its limit, and no longer at it.
#[test]
fn limits_make_a_beam_fail() {
    let limited = |failure| {
        let mut all = [BeamAxis::R, BeamAxis::S, BeamAxis::T].map(|axis| spring(axis, 4.0, 0.0));
        (all[0].failure_tension, all[0].failure_compression) = (Some(2.0), Some(1.0));
        (all[1].failure_tension, all[1].failure_compression) = (Some(0.5), Some(0.5));
        all[2].failure_force = Some(3.0);
        beam_of(all.to_vec(), failure)
    };
    let x = V3::new;
    for (failure, at) in [
        (BeamFailure::Together, x(1.2, 0.4, 0.0)),
        (BeamFailure::Together, x(-0.6, 0.4, 0.7)),
        (BeamFailure::Together, x(0.0, 0.0, 0.75)),
        (BeamFailure::BySign, x(1.2, 0.4, 0.0)),
        (BeamFailure::BySign, x(-1.0, 0.4, 0.0)),
        (BeamFailure::BySign, x(-0.6, -0.4, 0.0)),
        (BeamFailure::Any, x(2.0, 0.45, 0.0)),
        (BeamFailure::Any, x(0.0, -0.5, 0.7)),
        (BeamFailure::Any, x(1.9, 0.4, 0.75)),
    ] {
        let beam = limited(failure);
        assert!(beam.can_fail());
        let led_to = |factor: f64| {
            led(&beam, &[[V3::zeros(); 2], [V3::zeros(), at * factor]], &[[V3::zeros(); 2]])
        };
        let held = led_to(0.999)[0];
        assert!((held - at * (0.999 * 4.0)).norm() < 1e-14, "{failure:?} at {at}: {held}");
        assert_eq!(led_to(1.001), [V3::zeros(); 3], "{failure:?} at {at}");
    }
    assert!(!beam_of(vec![spring(BeamAxis::R, 1.0, 0.0)], BeamFailure::Together).can_fail());
}

/// A preload is there before any displacement, as is the force of an initial displacement, which
/// counts for the limits. A spring that yields has its preload as elastic force: k = 10, `F_y = 3 +
/// 2 p`, F_0 = 1 yields after 0.2.
#[test]
fn forces_of_the_start() {
    let mut all = [BeamAxis::R, BeamAxis::S, BeamAxis::T].map(|axis| spring(axis, 4.0, 0.0));
    all[0].preload = -3.0;
    (all[1].initial_displacement, all[1].failure_tension) = (0.5, Some(0.8));
    let law = YieldingSpring { stiffness: 10.0, yield_force: vec![[0.0, 3.0], [1.0, 5.0]] };
    (all[2].stiffness, all[2].yielding, all[2].preload) = (0.0, Some(law), 1.0);
    let beam = beam_of(all.to_vec(), BeamFailure::Together);
    let x = V3::new;
    let led_to =
        |at: V3| led(&beam, &[[V3::zeros(); 2], [V3::zeros(), at]], &[[V3::zeros(); 2]])[0];
    for (at, exact) in [
        (V3::zeros(), x(-3.0, 2.0, 1.0)),
        (x(0.25, 0.25, 0.2), x(-2.0, 3.0, 3.0)),
        (x(0.0, 0.25, 0.8), x(-3.0, 3.0, 4.0)),
        (x(0.0, 0.31, 0.8), V3::zeros()),
    ] {
        assert!((led_to(at) - exact).norm() < 1e-14, "{at}: {}", led_to(at));
    }
}

/// Displacements and rotations against the axes, after a large rotation of all: each axis has its
/// stiffness and its damping, with rates equal to the displacements in a step of 1. The moments
/// balance the couple of the forces.
#[test]
fn each_axis_has_its_spring_and_damper() {
    let axes = beam(TurningNode::Both, 1.0).axes;
    let [r, s] = [V3::new(1.0, 1.0, 0.0).normalize(), V3::new(-1.0, 1.0, 1.0).normalize()];
    assert!((axes * V3::x() - r).norm() < 1e-15 && (axes * V3::y() - s).norm() < 1e-15);
    let (moved, bent) = (V3::new(0.01, -0.02, 0.03), V3::new(0.004, 0.005, -0.006));
    for turn in [AxesRotation::identity(), AxesRotation::from_euler_angles(0.4, 1.2, -0.7)] {
        for line in [V3::zeros(), V3::new(2.0, 0.3, -0.5)] {
            let all = turn * axes;
            let start = [V3::new(0.1, 0.2, 0.3), V3::new(0.1, 0.2, 0.3) + line];
            let whole = start.map(|p| turn * p);
            for (turns_with, own, weights) in [
                (TurningNode::Both, [-0.5 * bent, 0.5 * bent], [0.5, 0.5]),
                (TurningNode::First, [V3::zeros(), bent], [1.0, 0.0]),
                (TurningNode::Second, [-bent, V3::zeros()], [0.0, 1.0]),
            ] {
                let last = [whole[0], whole[1] + all * moved];
                let rates = [[turn.scaled_axis(); 2], own.map(|w| all * w)];
                let loads = led(&beam(turns_with, 1.0), &[start, whole, last], &rates);
                let force = all * V3::new(1.1, 2.2, 3.3).component_mul(&moved);
                let moment = all * V3::new(4.4, 5.5, 6.6).component_mul(&bent);
                let couple = (last[1] - last[0]).cross(&force);
                let exact = [force, -moment - couple * weights[0], moment - couple * weights[1]];
                for (found, exact) in loads.iter().zip(exact) {
                    assert!((found - exact).norm() < 1e-14, "{turns_with:?}: {found} {exact}");
                }
                let net = couple + loads[1] + loads[2];
                assert!(net.norm() < 1e-14, "{net}");
            }
        }
    }
}

/// The largest step, by bisection, at which small oscillations of a free beam stay bounded is at
/// least its step. Without length and damping, it is its step.
#[test]
fn a_free_beam_is_stable_at_its_step() {
    let is_stable = |beam: &DiscreteBeam, length: f64, dt: f64| {
        let mut state = vec![0.0; beam.columns()];
        let small = |a: f64, b: f64, c: f64| V3::new(a, b, c) * 1e-7;
        let mut ends = NodeMotion {
            x: [V3::zeros(), V3::new(0.6, 0.0, 0.8) * length],
            v: [small(1.0, -2.0, 3.0), small(2.0, 1.0, -1.0)],
            w: [small(-1.0, 2.0, 1.0), small(1.0, 3.0, -2.0)],
        };
        let start = ends.x[1];
        for k in 0..3000 {
            let step = if k == 0 { 0.0 } else { dt };
            let [force, first, second] = beam.respond(&mut state, &ends, step);
            ends.v[0] += force * (dt / (0.5 * beam.mass));
            ends.v[1] -= force * (dt / (0.5 * beam.mass));
            ends.w[0] -= first * (dt / (0.5 * beam.inertia));
            ends.w[1] -= second * (dt / (0.5 * beam.inertia));
            (0..2).for_each(|k| ends.x[k] += ends.v[k] * dt);
            let largest = ends.w[0].norm() + ends.w[1].norm() + (ends.x[1] - start).norm();
            if largest > 0.1 {
                return false;
            }
        }
        true
    };
    let free = [
        (TurningNode::Both, 0.0, 0.0),
        (TurningNode::Both, 3.0, 0.0),
        (TurningNode::Both, 0.0, 3.0),
        (TurningNode::First, 0.0, 3.0),
        (TurningNode::First, 3.0, 1.0),
        (TurningNode::Second, 0.0, 0.5),
    ];
    let both = free.into_iter().flat_map(|case| {
        let lines = (case.2 > 0.0).then(|| along_line(case.0, case.1));
        [Some(beam(case.0, case.1)), lines].into_iter().flatten().map(move |beam| (case, beam))
    });
    for ((turns_with, damping, length), beam) in both {
        let reported = beam.step(length);
        let (mut low, mut high) = (0.5 * reported, 4.0 * reported);
        for _ in 0..30 {
            let middle = 0.5 * (low + high);
            if is_stable(&beam, length, middle) { low = middle } else { high = middle }
        }
        let case = format!("{turns_with:?}, damping {damping}, length {length}");
        assert!(low > 0.999 * reported, "{case}: {low} {reported}");
        if turns_with == TurningNode::Both && damping == 0.0 && length == 0.0 {
            assert!(low < 1.001 * reported, "{case}: {low} {reported}");
        }
    }
    // k = 3 along t with 4/m = 2, k = 6 about t with 4/J = 4/3: 8 about t is larger.
    let exact = 2.0 / 8f64.sqrt();
    assert!((beam(TurningNode::Both, 0.0).step(0.0) / exact - 1.0).abs() < 1e-14);
}

/// Everything that is wrong with a part is named.
#[test]
fn wrong_numbers_are_named() {
    let mut part = part_of(TurningNode::Both, 1.0);
    let input = part.discrete_beam.as_mut().expect("a discrete beam");
    input.mass = 0.0;
    input.inertia = -1.0;
    input.axes = [[1.0, 0.0, 0.0], [2.0, 0.0, 0.0]];
    input.spring[1].axis = BeamAxis::R;
    input.spring[2].stiffness = -2.0;
    input.spring[3].force_elongation = vec![[0.0, 0.0], [1.0, 1.0]];
    input.spring[4].damping = 0.0;
    input.spring[4].force_rate = vec![[0.0, 0.0]];
    input.spring[5].preload = f64::NAN;
    input.spring[5].failure_force = Some(0.0);
    let law = YieldingSpring { stiffness: 1.0, yield_force: vec![[0.0, 3.0], [1.0, 3.0]] };
    input.spring[5].yielding = Some(law);
    part.material = "steel".into();
    let said = read(&part).err().expect("errors");
    let said: Vec<String> = said.iter().map(|p| format!("{}: {}", p.path, p.message)).collect();
    let said = said.join("\n");
    for what in [
        "material: part 1: a part of discrete beams has no material",
        "discrete_beam.mass: part 1: mass is 0",
        "discrete_beam.inertia: part 1: inertia is -1",
        "its axes span no plane",
        "discrete_beam.spring.1.axis: part 1: an axis has two springs",
        "discrete_beam.spring.2.stiffness: part 1: stiffness is -2",
        "a spring has both force_elongation and stiffness",
        "force_rate has one point only",
        "discrete_beam.spring.5.preload: part 1: preload is NaN",
        "preload is NaN, beyond the yield force",
        "discrete_beam.spring.5.failure_force: part 1: failure_force is 0",
        "an axis has both stiffness or force_elongation and yielding",
    ] {
        assert!(said.contains(what), "no {what} in\n{said}");
    }
    let input = part.discrete_beam.as_mut().expect("a discrete beam");
    (input.failure, input.spring) = (BeamFailure::Any, Vec::new());
    let said = read(&part).err().expect("errors");
    assert!(said.iter().any(|p| p.message.contains("no axis has a limit")));
    assert!(said.iter().any(|p| p.message.contains("its discrete beams carry no force")));
}

/// Beams that would fail at once, a force at the start that turns with the line, and yield forces
/// of one direction only are errors.
#[test]
fn starts_that_cannot_be_are_named() {
    let said = |change: &dyn Fn(&mut DiscreteBeamInput)| {
        let mut part = part_of(TurningNode::First, 0.0);
        change(part.discrete_beam.as_mut().expect("a discrete beam"));
        read(&part).err().map_or(String::new(), |problems| problems[0].message.clone())
    };
    let start = |way: f64| {
        said(&move |input| {
            input.spring[0].initial_displacement = way;
            input.spring[0].failure_tension = Some(1.0);
        })
    };
    assert_eq!(start(0.9), "");
    assert!(start(1.0).contains("its beams fail at the start"));
    let led = said(&|input| (input.along_line, input.spring[0].preload) = (true, 0.5));
    assert!(led.contains("the spring on r has a force at the start"), "{led}");
    let one_way = said(&|input| {
        let yield_force = vec![[-1.0, -6.0], [0.0, -4.0]];
        let spring = &mut input.spring[0];
        (spring.stiffness, spring.force_elongation) = (0.0, Vec::new());
        spring.yielding = Some(YieldingSpring { stiffness: 10.0, yield_force });
    });
    assert!(one_way.contains("points of compression only"), "{one_way}");
}
