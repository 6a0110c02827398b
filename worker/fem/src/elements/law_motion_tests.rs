//! Solids of all laws, above all of rubber and foam: free motion at 0.9 of the stable step gains no
//! energy, since these laws are passive; loops of the deformation; large rotations.

use super::HourglassForm;
use super::solid_testing::{Solids, block, solid_part};
use super::testing::{Noise, laws_of_solids, material, part_of, rotate};
use crate::elements::testing::Patch;
use crumple_proto::partition::{Material, Param};

/// Part of the stable step that is taken.
const FACTOR: f64 = 0.9;

/// Returns the kinetic energy.
fn kinetic(solids: &Solids, masses: &[(f64, f64)]) -> f64 {
    let square = |v: &[f64; 4]| v[..3].iter().map(|v| v * v).sum::<f64>();
    masses.iter().zip(&solids.v).map(|((mass, _), v)| 0.5 * mass * square(v)).sum()
}

/// Returns the largest kinetic energy of a motion over that at its start. `free` says which axes
/// move; `speed` is the largest velocity in units of the dilatational wave.
///
/// The leapfrog scheme conserves `v^2 + w^2 u_n u_(n+1)` of a linear vibration `w`, so its kinetic
/// energy at mid-steps can be up to `1 / (1 - (w dt / 2)^2)` times that at the start. The fastest
/// vibrations are a small part of a random motion: stable motions stay within some percent.
fn gains(law: &Material, free: [bool; 3], speed: f64, steps: usize) -> f64 {
    let (nodes, cells) = block([6, 1, 1], [6.0, 1.0, 1.0]);
    let part = solid_part(HourglassForm::Stiffness, None);
    let mut solids = Solids::new(part, law.clone(), &nodes, &cells);
    let masses = solids.masses();
    let wave = super::testing::wave_speed(law);
    let mut noise = Noise(23);
    for v in &mut solids.v {
        (0..3).filter(|&i| free[i]).for_each(|i| v[i] = speed * wave * noise.next());
    }
    let first = kinetic(&solids, &masses);
    let start = solids.stable_dt();
    let (mut stable, mut dt) = (std::collections::VecDeque::from([start]), FACTOR * start);
    let mut most = 0.0f64;
    for step in 0..steps {
        // The steps of a run: the mean of two for velocities, the smallest limit of the last 256.
        let next = FACTOR * stable.iter().copied().fold(f64::INFINITY, f64::min);
        let (force, _) = solids.nodal();
        for ((v, force), (mass, _)) in solids.v.iter_mut().zip(force).zip(&masses) {
            let axes = (0..3).filter(|&i| free[i]);
            axes.for_each(|i| v[i] -= 0.5 * (dt + next) * force[i] / mass);
        }
        dt = next;
        let passed = solids.step(dt);
        assert_eq!(passed.trouble, None, "{} step {step}", law.law);
        stable.push_back(passed.stable_dt);
        if stable.len() > 256 {
            stable.pop_front();
        }
        most = most.max(kinetic(&solids, &masses) / first);
    }
    most
}

fn foam(more: &[(&str, f64)], key: &str, rows: &[&[f64]]) -> Material {
    let mut law = material("low_density_foam", 1e-6, &[&[("youngs_modulus", 0.3)], more].concat());
    let rows = Param::Table(rows.iter().map(|row| row.to_vec()).collect());
    law.parameters.insert(key.into(), rows);
    law
}

/// Foam with hysteresis: unloading adds `c P^2` to the modulus, here 2 shape E where the curve is
/// straight.
#[test]
fn foam_with_hysteresis_gains_no_energy() {
    for (hysteresis, shape) in [(0.0, 5.0), (0.1, 1.0), (0.3, 12.0)] {
        let law = foam(
            &[("hysteresis", hysteresis), ("shape", shape)],
            "compression",
            &[&[0.0, 0.0], &[0.3, 0.09], &[0.6, 0.3]],
        );
        for (free, speed) in [([true, false, false], 0.02), ([true; 3], 0.02)] {
            let gain = gains(&law, free, speed, 1500);
            assert!(gain < 1.01, "{hysteresis} {shape} {free:?}: {gain}");
        }
    }
}

/// Foam with curves by rate, in which the stress rises with the rate much more than the modulus
/// allows in a step.
#[test]
fn foam_with_rates_gains_no_energy() {
    for rate in [1e-4, 0.01, 1.0] {
        let law = foam(
            &[],
            "compression_by_rate",
            &[&[0.0, 0.0, 0.0], &[0.0, 0.5, 0.15], &[rate, 0.0, 0.0], &[rate, 0.5, 0.9]],
        );
        for (free, speed) in [([true, false, false], 0.02), ([true; 3], 0.02)] {
            let gain = gains(&law, free, speed, 1500);
            assert!(gain < 1.01, "{rate} {free:?}: {gain}");
        }
    }
}

/// All laws of solids at large velocities.
#[test]
fn no_law_gains_energy() {
    for law in laws_of_solids() {
        let gain = gains(&law, [true; 3], 0.03, 1000);
        assert!(gain < 1.01, "{}: {gain}", law.law);
    }
}

/// Columns of a matrix are the images of the axes.
type Matrix = [[f64; 3]; 3];

const UNIT: Matrix = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];

fn image(m: &Matrix, x: [f64; 3]) -> [f64; 3] {
    std::array::from_fn(|i| (0..3).map(|j| m[j][i] * x[j]).sum())
}

/// Moves all nodes of a mesh with this start along straight lines between deformations; returns the
/// work at the end and its largest value.
fn travel<const C: usize>(
    patch: &mut Patch<C>,
    start: &[[f64; 3]],
    stations: &[Matrix],
    steps: usize,
) -> [f64; 2] {
    let (mut work, mut most) = (0.0, 0.0f64);
    for two in stations.windows(2) {
        for step in 1..=steps {
            let share = step as f64 / steps as f64;
            let now: Matrix = std::array::from_fn(|j| {
                std::array::from_fn(|i| (1.0 - share) * two[0][j][i] + share * two[1][j][i])
            });
            for ((x, v), first) in patch.x.iter().zip(&mut patch.v).zip(start) {
                let to = image(&now, *first);
                (0..3).for_each(|i| v[i] = to[i] - x[i]);
            }
            let passed = patch.step(1.0);
            assert_eq!(passed.trouble, None);
            work += passed.internal;
            most = most.max(work);
        }
    }
    [work, most]
}

/// A loop over two deformations with shear, in which the principal directions turn: the work of
/// rubber and of foam without losses is zero within the second order of the step.
#[test]
fn a_loop_with_shear_gives_no_energy() {
    let stations = [
        UNIT,
        [[1.3, 0.0, 0.1], [0.4, 1.0, 0.0], [0.0, 0.0, 0.9]],
        [[1.0, 0.2, 0.0], [-0.3, 1.1, 0.1], [0.3, 0.0, 0.8]],
        UNIT,
    ];
    let curve: &[&[f64]] = &[&[0.0, 0.0], &[0.1, 2.0], &[0.5, 30.0]];
    let soft = foam(&[], "compression", curve);
    let rubbers = ["mooney_rivlin", "polynomial_rubber", "ogden", "blatz_ko", "tabulated_rubber"];
    let keeps_energy = |law: &Material| {
        rubbers.contains(&law.law.as_str()) && !law.parameters.contains_key("curve_by_rate")
    };
    let laws = laws_of_solids().into_iter().filter(keeps_energy);
    for law in laws.chain([soft]) {
        let [coarse, fine] = [50, 100].map(|steps| {
            let (nodes, cells) = block([1, 1, 1], [1.0; 3]);
            let part = solid_part(HourglassForm::Stiffness, None);
            let mut solids = Solids::new(part, law.clone(), &nodes, &cells);
            let [work, most] = travel(&mut solids, &nodes, &stations, steps);
            work.abs() / most
        });
        assert!(coarse < 3e-3 && fine < 0.3 * coarse, "{}: {coarse:e} {fine:e}", law.law);
    }
}

/// Foams in tetrahedra take the volume of the element: a loop in which the elements have different
/// volumes gives no energy. Averaging is refused.
#[test]
fn foam_in_tetrahedra_keeps_the_energy_of_a_loop() {
    let curve: &[&[f64]] = &[&[0.0, 0.0], &[0.1, 0.01], &[0.5, 0.3]];
    let law = foam(&[], "compression", curve);
    let nodes = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0], [1.0, 1.0, 1.0]];
    let part = part_of("tetrahedron", 0.0).with("bulk_viscosity", [0.0; 2]);
    let [coarse, fine] = [50, 100].map(|steps| {
        let mut patch =
            Patch::<4>::new(part.clone(), law.clone(), &nodes, &[[0, 1, 2, 3], [1, 2, 3, 4]]);
        assert_eq!(patch.element.averaged_volume(), None);
        // Node 4 alone moves on a triangle: the second element is strained, the first one is not.
        let (mut work, mut most) = (0.0, 0.0f64);
        let stations = [[1.0; 3], [0.6, 0.9, 0.8], [0.9, 0.5, 0.7], [1.0; 3]];
        for two in stations.windows(2) {
            for _ in 0..steps {
                (0..3).for_each(|i| patch.v[4][i] = (two[1][i] - two[0][i]) / steps as f64);
                work += patch.step(1.0).internal;
                most = most.max(work);
            }
        }
        work.abs() / most
    });
    assert!(coarse < 3e-3 && fine < 0.3 * coarse, "{coarse:e} {fine:e}");
    let settings = super::testing::settings(part.with("pressure", "nodal"), law);
    let problems = super::build_block(&settings, 0, crumple_proto::mesh::Shape::Tet4);
    let text = format!("{:?}", problems.err());
    assert!(text.contains("default with foams"), "{text}");
}

/// All laws: an element that is strained, turned by a right angle and strained more has the rotated
/// stress of one that is not turned; so the tensors of the history turn with it.
#[test]
fn a_turned_element_has_the_turned_stress() {
    let angle = [1.0, 2.0, 3.0].map(|c: f64| c * 0.5 * std::f64::consts::PI / 14.0f64.sqrt());
    let turn: Matrix = UNIT.map(|axis| rotate(angle, axis));
    let back = |x: [f64; 3]| rotate(angle.map(|c| -c), x);
    let first: Matrix = [[0.99, 0.004, 0.0], [0.002, 1.002, -0.006], [0.003, 0.0, 0.994]];
    let second: Matrix = [[1.001, 0.0, 0.003], [-0.004, 0.997, 0.0], [0.0, 0.005, 0.998]];
    for law in laws_of_solids() {
        let stress = [false, true].map(|turns| {
            let (nodes, cells) = block([1, 1, 1], [1.0; 3]);
            let part = solid_part(HourglassForm::Stiffness, None);
            let mut solids = Solids::new(part, law.clone(), &nodes, &cells);
            (0..15).for_each(|_| _ = solids.go(|x| image(&first, x)));
            let by = angle.map(|c| c / 20.0);
            (0..20).for_each(|_| _ = solids.go(|x| if turns { rotate(by, x) } else { x }));
            let more = |x: [f64; 3]| image(&second, x);
            (0..5).for_each(|_| {
                _ = solids.go(|x| if turns { rotate(angle, more(back(x))) } else { more(x) });
            });
            solids.fields(0).stress
        });
        let [still, turned] =
            stress.map(|[xx, yy, zz, xy, yz, zx]| [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]]);
        let size = still.iter().flatten().fold(0.0, |most: f64, s| most.max(s.abs()));
        for i in 0..3 {
            for j in 0..3 {
                // Component of the turned stress in the turned axes i and j.
                let along = image(&turned, turn[j]);
                let got: f64 = (0..3).map(|k| turn[i][k] * along[k]).sum();
                let off = (got - still[i][j]).abs() / size;
                // Cowper and Symonds take the rounding of the turn for a rate: its fifth root is
                // a thousandth of the yield stress.
                assert!(off < 1e-6, "{} {i} {j}: {got} for {}", law.law, still[i][j]);
            }
        }
        assert!(size > 0.0 || law.law == "johnson_cook", "{}", law.law);
    }
}

/// A fluid is stable at its step also where its viscosity takes most of it: random velocities
/// decay.
#[test]
fn a_viscous_fluid_is_stable_at_its_step() {
    let mut law = material("fluid", 1.0, &[("viscosity", 0.5)]);
    let constants = Param::List(vec![1.0, 0.0, 0.0, 0.0, 0.0, 0.0]);
    law.parameters.insert("eos_polynomial".into(), constants);
    // 2 c/dt is above one: without the viscosity a cube of side 1 has a step of about one.
    let most = gains(&law, [true; 3], 1e-4, 2000);
    assert!(most <= 1.001, "{most}");
}

/// The strain of a criterion of failure turns with the element: an element that is stretched,
/// turned by a right angle and stretched along the same line of material fails at the sum, and
/// along another line at the larger of both.
#[test]
fn the_strain_of_failure_turns_with_the_element() {
    let limit = ("erosion_major_strain", 0.01);
    let law = material("elastic", 1.0, &[("youngs_modulus", 1.0), ("poisson", 0.3), limit]);
    let quarter = 0.5 * std::f64::consts::PI / 50.0;
    for (turns, along, left) in [(50, 1, 4), (50, 0, 10), (0, 0, 4), (0, 1, 10)] {
        let (nodes, cells) = block([1, 1, 1], [1.0; 3]);
        let part = solid_part(HourglassForm::Stiffness, None);
        let mut solids = Solids::new(part, law.clone(), &nodes, &cells);
        let stretch = |x: [f64; 3], axis: usize| {
            std::array::from_fn(
                |c| if c == axis { 1.0f64.mul_add(x[c], 1e-3 * x[c]) } else { x[c] },
            )
        };
        (0..6).for_each(|_| _ = solids.go(|x| stretch(x, 0)));
        (0..turns).for_each(|_| _ = solids.go(|x| rotate([0.0, 0.0, quarter], x)));
        assert!(!solids.fields(0).failed);
        let steps = (1..20).find(|_| {
            solids.go(|x| stretch(x, along));
            solids.fields(0).failed
        });
        // A logarithmic strain of 0.01 takes 10.005 steps.
        assert_eq!(steps, Some(left + 1), "{turns} turns, along {along}");
    }
}

/// The bulk viscosity of a stiffened element is the fraction of critical damping with the stiffened
/// modulus.
#[test]
fn bulk_viscosity_follows_the_stiffening() {
    let law = material("blatz_ko", 1.0, &[("shear_modulus", 1.0)]);
    let (nodes, cells) = block([1, 1, 1], [1.0; 3]);
    let b1 = 0.06;
    let part = solid_part(HourglassForm::Stiffness, None).with("bulk_viscosity", [b1, 0.0]);
    let mut solids = Solids::new(part, law.clone(), &nodes, &cells);
    (0..60).for_each(|_| _ = solids.go(|x| [0.99 * x[0], 0.99 * x[1], 0.99 * x[2]]));
    let passed = solids.go(|x| [0.999 * x[0], x[1], x[2]]);
    let column = |name: &str| {
        let names = solids.element.names();
        let place = names.iter().position(|known| known == name).expect("a column");
        solids.history.element(0).at(place)
    };
    let stiffening = column("stiffening");
    let volume: f64 = solids.x[7][..3].iter().product();
    let modulus = super::testing::wave_speed(&law).powi(2) * (1.0 + stiffening);
    let speed = (modulus * volume).sqrt();
    let length = passed.stable_dt * speed / ((b1 * b1 + 1.0).sqrt() - b1);
    let rate = 0.001 / 0.9995;
    let exact = b1 * length * rate * (modulus / volume).sqrt();
    assert!(stiffening > 2.0, "{stiffening}");
    assert!((column("bulk viscosity") / exact - 1.0).abs() < 1e-9, "{exact}");
}

/// Laws that add up the deformation compute in double precision, whatever the job says.
#[test]
fn laws_that_sum_up_need_double_precision() {
    for law in laws_of_solids() {
        let sums = [
            "mooney_rivlin",
            "polynomial_rubber",
            "ogden",
            "blatz_ko",
            "tabulated_rubber",
            "low_density_foam",
            "johnson_holmquist_ceramic",
            "johnson_holmquist_concrete",
            "karagozian_case_concrete",
            "soil",
            "viscous_foam",
        ];
        let (nodes, cells) = block([1, 1, 1], [1.0; 3]);
        let part = solid_part(HourglassForm::Stiffness, None);
        let solids = Solids::new(part, law.clone(), &nodes, &cells);
        assert_eq!(
            solids.element.any_precision(),
            !sums.contains(&law.law.as_str()),
            "{}",
            law.law
        );
    }
}
