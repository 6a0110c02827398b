//! Cohesive laws against closed forms. Units mm, ms, kg, so GPa and J/mm^2 = kN/mm.

use super::*;
use crate::materials::build_cohesive;
use crate::materials::testing::material;
use crumple_proto::partition::Material;

/// Stiffnesses [GPa/mm], strengths [GPa], toughnesses [kN/mm] of an adhesive.
const K: [f64; 2] = [20.0, 8.0];
const T: [f64; 2] = [0.04, 0.025];
const G: [f64; 2] = [8e-4, 2.4e-3];

fn adhesive(more: &[(&str, f64)]) -> Material {
    let numbers = [
        ("stiffness_normal", K[0]),
        ("stiffness_shear", K[1]),
        ("strength_normal", T[0]),
        ("strength_shear", T[1]),
        ("toughness_normal", G[0]),
        ("toughness_shear", G[1]),
    ];
    material("cohesive_mixed_mode", &[&numbers, more].concat(), &[])
}

/// Strength [GPa], openings at separation [mm], and shares of them, of a law with a plateau.
const SIGMA: f64 = 0.03;
const SEPARATION: [f64; 2] = [0.04, 0.1];
const SHARES: [f64; 2] = [0.1, 0.6];

fn trilinear(more: &[(&str, f64)]) -> Material {
    let numbers = [
        ("strength", SIGMA),
        ("separation_normal", SEPARATION[0]),
        ("separation_shear", SEPARATION[1]),
        ("peak_share", SHARES[0]),
        ("softening_share", SHARES[1]),
    ];
    material("cohesive_tvergaard_hutchinson", &[&numbers, more].concat(), &[])
}

/// Shares of the toughnesses that flow takes.
const PLATEAU: [f64; 2] = [0.4, 0.5];

fn plastic(more: &[(&str, f64)]) -> Material {
    let shares = [("plateau_normal", PLATEAU[0]), ("plateau_shear", PLATEAU[1])];
    Material { law: "cohesive_elastoplastic".into(), ..adhesive(&[&shares[..], more].concat()) }
}

/// A point of a law on a path.
struct Path {
    law: Box<dyn Cohesive>,
    history: Vec<f64>,
    opening: [f64; 3],
    traction: [f64; 3],
    /// Work by opening and by sliding per area [force/length].
    work: [f64; 2],
}

impl Path {
    fn new(material: &Material) -> Self {
        let law = build_cohesive(material).map_err(|problems| format!("{problems:?}")).unwrap();
        let history = vec![0.0; law.history().len()];
        Self { law, history, opening: [0.0; 3], traction: [0.0; 3], work: [0.0; 2] }
    }

    fn to(&mut self, opening: [f64; 3]) -> [f64; 3] {
        let now = self.law.update(CohesivePoint { opening, history: &mut self.history });
        for c in 0..3 {
            let work = 0.5 * (self.traction[c] + now[c]) * (opening[c] - self.opening[c]);
            self.work[usize::from(c > 0)] += work;
        }
        (self.opening, self.traction) = (opening, now);
        now
    }

    fn damage(&self) -> f64 {
        self.history[0]
    }
}

/// Direction of an opening with this angle from the normal, sliding along a slanted direction.
fn direction(angle: f64) -> [f64; 3] {
    [angle.cos(), 0.6 * angle.sin(), 0.8 * angle.sin()]
}

/// Returns the openings along a direction at which damage begins and ends, found by bisection.
fn limits(material: &Material, along: [f64; 3]) -> [f64; 2] {
    [0.0, 1.0 - 1e-15].map(|damage| {
        let (mut low, mut high) = (0.0, 10.0);
        for _ in 0..200 {
            let middle = 0.5 * (low + high);
            let mut point = Path::new(material);
            point.to(along.map(|c| middle * c));
            if point.damage() > damage { high = middle } else { low = middle }
        }
        high
    })
}

/// Peak, straight softening and work to separation of one mode.
#[test]
fn pure_modes_have_strength_and_toughness() {
    for (mode, along) in [(0, [1.0, 0.0, 0.0]), (1, [0.0, 0.6, -0.8]), (1, [-1e-3, 0.0, 1.0])] {
        let law = adhesive(&[]);
        let [peak, end] = [T[mode] / K[mode], 2.0 * G[mode] / T[mode]];
        let mut path = Path::new(&law);
        let size = |traction: [f64; 3]| {
            if mode == 0 { traction[0] } else { traction[1].hypot(traction[2]) }
        };
        for k in 0..=10 {
            let u = peak * f64::from(k) / 10.0;
            let got = size(path.to(along.map(|c| u * c)));
            assert!((got - K[mode] * u).abs() < 1e-15, "{mode} {u}: {got}");
        }
        for k in 1..=10 {
            let part = f64::from(k) / 10.0;
            let u = peak + (end - peak) * part;
            let got = size(path.to(along.map(|c| u * c)));
            assert!((got - T[mode] * (1.0 - part)).abs() < 1e-12, "{mode} {u}: {got}");
        }
        // Under pressure the work of opening is that of the elastic contact.
        assert!((path.work[mode] / G[mode] - 1.0).abs() < 1e-9, "{mode}: {:?}", path.work);
        path.to(along.map(|c| 1.001 * end * c));
        assert_eq!(path.history, [1.0, 1.0]);
        assert_eq!(path.traction[0], K[0] * path.opening[0].min(0.0));
    }
}

/// In all mixtures damage begins on the ellipse of strengths, softening is straight, and the works
/// of both modes meet the criterion.
#[test]
fn mixtures_meet_their_criterion() {
    for (m, more) in
        [(1.0, &[][..]), (2.0, &[("power_exponent", 2.0)]), (1.4, &[("power_exponent", 1.4)])]
    {
        for angle in [0.0, 0.1, 0.5, 0.8, 1.2, 1.5] {
            let (law, along) = (adhesive(more), direction(angle));
            let [begin, end] = limits(&law, along);
            let mut path = Path::new(&law);
            let t = path.to(along.map(|c| begin * c));
            let ellipse = (t[0] / T[0]).powi(2) + (t[1].hypot(t[2]) / T[1]).powi(2);
            assert!((ellipse - 1.0).abs() < 1e-9, "{m} {angle}: {ellipse}");
            let half = path.to(along.map(|c| 0.5 * (begin + end) * c));
            for c in 0..3 {
                assert!((half[c] - 0.5 * t[c]).abs() < 1e-12, "{m} {angle}: {half:?} {t:?}");
            }
            path.to(along.map(|c| end * c));
            let [of_first, of_second] = [0, 1].map(|k| (path.work[k] / G[k]).powf(m));
            assert!((of_first + of_second - 1.0).abs() < 1e-9, "{m} {angle}: {:?}", path.work);
        }
    }
}

/// The work of a mixture by Benzeggagh and Kenane, `G_I + (G_II - G_I) (W_II/W)^m`.
#[test]
fn benzeggagh_kenane_gives_the_work_of_a_mixture() {
    for m in [1.0, 2.2] {
        for angle in [0.0, 0.1, 0.5, 0.8, 1.2, 1.5] {
            let law = adhesive(&[("benzeggagh_kenane", m)]);
            let along = direction(angle);
            let [begin, end] = limits(&law, along);
            let mut path = Path::new(&law);
            path.to(along.map(|c| begin * c));
            path.to(along.map(|c| end * c));
            let [first, second] = path.work;
            let wanted = G[0] + (G[1] - G[0]) * (second / (first + second)).powf(m);
            assert!(
                ((first + second) / wanted - 1.0).abs() < 1e-9,
                "{m} {angle}: {path:?}",
                path = path.work
            );
        }
    }
    // With the exponent g of the stiffness the end is 2 G/(u_0 K), K = (c^2 Kn^g + s^2 Ks^g)^(1/g).
    let law = adhesive(&[("benzeggagh_kenane", 1.0), ("stiffness_exponent", 2.0)]);
    let [begin, end] = limits(&law, direction(std::f64::consts::FRAC_PI_4));
    let ratio = K[1] / (K[0] + K[1]);
    let mean = (0.5 * (K[0] * K[0] + K[1] * K[1])).sqrt();
    let wanted = 2.0 * (G[0] + (G[1] - G[0]) * ratio) / (begin * mean);
    assert!((end / wanted - 1.0).abs() < 1e-9, "{end} for {wanted}");
}

/// Unloading is straight to the origin, and reloading goes back on the same line.
#[test]
fn a_point_unloads_to_the_origin() {
    for angle in [0.0, 0.7, 1.5] {
        let (law, along) = (adhesive(&[]), direction(angle));
        let [begin, end] = limits(&law, along);
        let u = 0.4 * begin + 0.6 * end;
        let mut path = Path::new(&law);
        let there = path.to(along.map(|c| u * c));
        let damage = path.damage();
        assert!(damage > 0.5 && damage < 1.0);
        for part in [0.7, 0.2, 0.0, 0.3, 1.0] {
            let back = path.to(along.map(|c| part * u * c));
            for c in 0..3 {
                assert!((back[c] - part * there[c]).abs() < 1e-15, "{angle} {part}");
            }
        }
        assert_eq!(path.damage(), damage);
        // The faces push with their whole stiffness.
        assert!((path.to([-1e-3, 0.0, 0.0])[0] + 1e-3 * K[0]).abs() < 1e-15);
    }
}

/// No closed path of openings and slidings gives energy. Legs are cut where the faces touch, so
/// that the sums of work have no error there.
#[test]
fn no_closed_path_gives_energy() {
    let mut noise = crate::elements::testing::Noise(5);
    let elastic = [("stiffness_normal", K[0]), ("stiffness_shear", K[1])];
    let limits = [("strength_normal", T[0]), ("strength_shear", T[1])];
    let brittle = material("cohesive_elastic", &[&elastic[..], &limits].concat(), &[]);
    let laws = [
        adhesive(&[]),
        adhesive(&[("benzeggagh_kenane", 2.0)]),
        brittle,
        trilinear(&[]),
        plastic(&[]),
    ];
    let mut damaged = 0;
    for k in 0..300 {
        let mut path = Path::new(&laws[k % laws.len()]);
        let size = 0.01 * (1.0 + k as f64 / 30.0);
        let mut points: Vec<[f64; 3]> =
            (0..6).map(|_| [noise.next(), noise.next(), noise.next()].map(|c| size * c)).collect();
        points.push([0.0; 3]);
        for to in points {
            let from = path.opening;
            let mut parts: Vec<f64> = (1..=500).map(|s| f64::from(s) / 500.0).collect();
            if from[0] * to[0] < 0.0 {
                parts.push(from[0] / (from[0] - to[0]));
                parts.sort_by(f64::total_cmp);
            }
            for part in parts {
                path.to([0, 1, 2].map(|c| from[c] + part * (to[c] - from[c])));
            }
        }
        assert!(path.work[0] + path.work[1] > -1e-12, "{k}: {:?}", path.work);
        damaged += usize::from(path.damage() > 0.0);
    }
    assert!(damaged > 100, "the paths reach damage: {damaged}");
}

/// Tractions over increasing openings of pure modes and of mixtures are those of Tvergaard &
/// Hutchinson 1992, and all take the same work.
#[test]
fn a_plateau_softens_with_one_toughness() {
    let ([normal, shear], [first, second]) = (SEPARATION, SHARES);
    for angle in [0.0, 0.2, 0.7, 1.1, 1.5, std::f64::consts::FRAC_PI_2] {
        let along = direction(angle);
        let law = trilinear(&[]);
        let mut path = Path::new(&law);
        // Opening at separation in this direction.
        let end = 1.0 / (along[0] / normal).hypot(along[1].hypot(along[2]) / shear);
        // Tractions of straight parts, whose trapezia have no error.
        let at_l = |path: &mut Path, l: f64| {
            let u = along.map(|c| l * end * c);
            let t = if l <= first {
                SIGMA * l / first
            } else if l <= second {
                SIGMA
            } else {
                SIGMA * (1.0 - l) / (1.0 - second)
            };
            let slip = t / l * normal / (shear * shear);
            let wanted = [t / l * u[0] / normal, slip * u[1], slip * u[2]];
            let got = path.to(u);
            for c in 0..3 {
                assert!((got[c] - wanted[c]).abs() < 1e-9 * SIGMA, "{angle} {l}: {got:?}");
            }
        };
        for k in 1..=10 {
            at_l(&mut path, first * f64::from(k) / 10.0);
        }
        assert!(path.damage() < 1e-15, "round-off at the peak: {}", path.damage());
        for k in 1..=10 {
            at_l(&mut path, first + (second - first) * f64::from(k) / 10.0);
        }
        for k in 1..10 {
            at_l(&mut path, second + (1.0 - second) * f64::from(k) / 10.0);
        }
        assert_eq!(path.history[1], 0.0);
        path.to(along.map(|c| (1.0 + 1e-15) * end * c));
        assert_eq!((path.history[1], path.traction), (1.0, [0.0; 3]), "{angle}");
        let toughness = 0.5 * SIGMA * normal * (1.0 - first + second);
        let work = path.work[0] + path.work[1];
        assert!((work / toughness - 1.0).abs() < 1e-9, "{angle}: {work} for {toughness}");
    }
}

/// Unloading goes straight to the origin, and pressure meets its own stiffness, also after
/// failure.
#[test]
fn a_plateau_unloads_to_the_origin() {
    let law = trilinear(&[("pressure_factor", 5.0)]);
    let stiffness = SIGMA / (SHARES[0] * SEPARATION[0]);
    let mut path = Path::new(&law);
    let far = [0.8 * SEPARATION[0], 0.0, 0.0];
    let there = path.to(far);
    assert!((there[0] - 0.5 * SIGMA).abs() < 1e-12 * SIGMA, "{there:?}");
    for part in [0.5, 0.0, 1.0] {
        let back = path.to(far.map(|u| part * u));
        assert!((back[0] - part * there[0]).abs() < 1e-15, "{part}: {back:?}");
    }
    for _ in 0..2 {
        let pressed = path.to([-1e-3, 0.0, 0.0])[0];
        assert!((pressed / (-5e-3 * stiffness) - 1.0).abs() < 1e-12, "{pressed}");
        path.to([0.0, 2.0 * SEPARATION[1], 0.0]);
        assert_eq!(path.history, [1.0, 1.0]);
    }
    assert_eq!(path.law.face().stiffest(), 5.0 * path.law.face().stiffness[0]);
    let mut free = Path::new(&trilinear(&[("pressure_factor", 0.0)]));
    assert_eq!(free.to([-1.0, 0.0, 0.0])[0], 0.0);
}

/// Shares out of order, and numbers out of range.
#[test]
fn a_plateau_has_a_beginning_and_an_end() {
    for (key, value, words) in [
        ("peak_share", 0.0, "above 0, at most 1"),
        ("softening_share", 0.05, "at least peak_share, at most 1"),
        ("softening_share", 1.1, "at least peak_share, at most 1"),
        ("pressure_factor", -1.0, "at least 0"),
        ("separation_shear", 0.0, "above 0"),
    ] {
        let mut material = trilinear(&[]);
        let number = crumple_proto::partition::Param::Number(value);
        material.parameters.insert(key.into(), number);
        let found = format!("{:?}", build_cohesive(&material).err());
        assert!(found.contains(key) && found.contains(words), "{key}: {found}");
    }
}

/// Elastic rise, plateau at the strength, straight softening, and the work of each part, of pure
/// modes; unloading is elastic with what damage leaves, and leaves the flow.
#[test]
fn a_flowing_surface_has_strength_plateau_and_toughness() {
    for (mode, along) in [(0, [1.0, 0.0, 0.0]), (1, [0.0, 0.6, -0.8])] {
        let first = T[mode] / K[mode];
        let second = first + PLATEAU[mode] * G[mode] / T[mode];
        let end = first - second + 2.0 * G[mode] / T[mode];
        let law = plastic(&[]);
        let mut path = Path::new(&law);
        let along_it = |t: [f64; 3]| (0..3).map(|c| t[c] * along[c]).sum::<f64>();
        let straight = |path: &mut Path, from: f64, to: f64, traction: [f64; 2]| {
            for k in 1..=10 {
                let part = f64::from(k) / 10.0;
                let u = from + (to - from) * part;
                let got = along_it(path.to(along.map(|c| u * c)));
                let wanted = traction[0] + (traction[1] - traction[0]) * part;
                assert!((got - wanted).abs() < 1e-9 * T[mode], "{mode} {u}: {got} {wanted}");
            }
        };
        straight(&mut path, 0.0, first, [0.0, T[mode]]);
        straight(&mut path, first, second, [T[mode]; 2]);
        let plateau = path.work[mode] - 0.5 * T[mode] * first;
        assert!((plateau / (PLATEAU[mode] * G[mode]) - 1.0).abs() < 1e-9, "{mode}: {plateau}");
        let half = 0.5 * (second + end);
        straight(&mut path, second, half, [T[mode], 0.5 * T[mode]]);
        assert!((path.damage() - 0.5).abs() < 1e-12);
        // Down to no traction, where the flow is left, and back.
        straight(&mut path, half, half - first, [0.5 * T[mode], 0.0]);
        straight(&mut path, half - first, half, [0.0, 0.5 * T[mode]]);
        straight(&mut path, half, end, [0.5 * T[mode], 0.0]);
        assert!((path.work[mode] / G[mode] - 1.0).abs() < 1e-9, "{mode}: {:?}", path.work);
        path.to(along.map(|c| 1.001 * end * c));
        assert_eq!(path.history[..2], [1.0, 1.0]);
        assert_eq!(path.to([-1e-3, 1.0, 0.0]), [-1e-3 * K[0], 0.0, 0.0]);
    }
}

/// In mixtures yield is on the ellipse of strengths, the traction stays there until damage, and
/// the works of both modes over their toughnesses add up to one.
#[test]
fn mixtures_of_a_flowing_surface_meet_their_criterion() {
    for angle in [0.0, 0.1, 0.5, 0.8, 1.2, 1.5] {
        let (law, along) = (plastic(&[]), direction(angle));
        let mixed = |pure: [f64; 2]| {
            let [c, s] = [along[0] / pure[0], along[1].hypot(along[2]) / pure[1]];
            1.0 / c.hypot(s)
        };
        let yields = [0, 1].map(|k| T[k] / K[k]);
        let first = mixed(yields);
        let second = mixed([0, 1].map(|k| yields[k] + PLATEAU[k] * G[k] / T[k]));
        let mut path = Path::new(&law);
        let t = path.to(along.map(|c| first * c));
        let ellipse = (t[0] / T[0]).powi(2) + (t[1].hypot(t[2]) / T[1]).powi(2);
        assert!((ellipse - 1.0).abs() < 1e-9, "{angle}: {ellipse}");
        let flows = path.to(along.map(|c| second * c));
        assert!(path.damage() < 1e-14, "{angle}: {}", path.damage());
        for c in 0..3 {
            assert!((flows[c] - t[c]).abs() < 1e-9 * T[0], "{angle}: {flows:?} {t:?}");
        }
        let [_, end] = limits(&law, along);
        let half = path.to(along.map(|c| 0.5 * (second + end) * c));
        for c in 0..3 {
            assert!((half[c] - 0.5 * t[c]).abs() < 1e-9 * T[0], "{angle}: {half:?} {t:?}");
        }
        path.to(along.map(|c| end * c));
        let sum = path.work[0] / G[0] + path.work[1] / G[1];
        assert!((sum - 1.0).abs() < 1e-9, "{angle}: {:?}", path.work);
    }
}

/// A point that has flowed open is pushed before its faces touch, with the whole stiffness; a point
/// under pressure flows in the surface at its own strength.
#[test]
fn pressure_does_not_flow() {
    let law = plastic(&[]);
    let mut path = Path::new(&law);
    let first = T[0] / K[0];
    path.to([3.0 * first, 0.0, 0.0]);
    let touching = path.to([0.0; 3])[0];
    assert!((touching / (-2.0 * T[0]) - 1.0).abs() < 1e-12, "{touching}");
    let mut path = Path::new(&law);
    let slid = path.to([-1.0, 2.0 * T[1] / K[1], 0.0]);
    assert_eq!(slid[0], -K[0]);
    assert!((slid[1] / T[1] - 1.0).abs() < 1e-12 && path.damage() == 0.0, "{slid:?}");
    assert_eq!(path.history[2], 0.0);
}

/// A share of the toughness that leaves nothing for softening is refused, with the limit.
#[test]
fn a_plateau_leaves_work_for_softening() {
    let limit = 1.0 - 0.5 * T[0] * T[0] / (K[0] * G[0]);
    for (key, value, words) in [
        ("plateau_normal", limit, format!("it has to be below {limit}")),
        ("plateau_shear", 1.0, "from 0 to 1".into()),
        ("toughness_shear", 3e-5, "the work 0.0000390625".into()),
    ] {
        let mut material = plastic(&[]);
        let number = crumple_proto::partition::Param::Number(value);
        material.parameters.insert(key.into(), number);
        let found = format!("{:?}", build_cohesive(&material).err());
        assert!(found.contains(key) && found.contains(&words), "{key}: {found}");
    }
    assert!(build_cohesive(&plastic(&[("plateau_normal", limit - 1e-9)])).is_ok());
}

/// The elastic law fails at the limit of either traction, and pushes afterwards.
#[test]
fn the_elastic_law_breaks_at_its_strength() {
    let numbers = [
        ("stiffness_normal", K[0]),
        ("stiffness_shear", K[1]),
        ("strength_normal", T[0]),
        ("strength_shear", T[1]),
    ];
    for (mode, along) in [(0, [1.0, 0.0, 0.0]), (1, [0.0, 0.6, 0.8])] {
        let mut path = Path::new(&material("cohesive_elastic", &numbers, &[]));
        let peak = T[mode] / K[mode];
        path.to(along.map(|c| 0.999_999 * peak * c));
        assert_eq!(path.history[1], 0.0);
        assert!((path.work[mode] - 0.5 * T[mode] * peak).abs() < 1e-5 * T[mode] * peak);
        assert_eq!(path.to(along.map(|c| 1.000_001 * peak * c)), [0.0; 3]);
        assert_eq!(path.history[1], 1.0);
        assert_eq!(path.to([-1e-3, 1.0, 1.0]), [-1e-3 * K[0], 0.0, 0.0]);
    }
    let mut whole = Path::new(&material("cohesive_elastic", &numbers[..2], &[]));
    assert_eq!(whole.to([1.0, 2.0, 3.0]), [K[0], 2.0 * K[1], 3.0 * K[1]]);
}

#[test]
fn wrong_parameters_are_refused_at_once() {
    let text = |material: &Material| {
        let found = build_cohesive(material).err();
        found.map_or(String::new(), |found| format!("{found:?}"))
    };
    let mut brittle = adhesive(&[("power_exponent", 0.0), ("stiffness_exponent", 2.0)]);
    brittle
        .parameters
        .insert("toughness_normal".into(), crumple_proto::partition::Param::Number(3e-5));
    brittle.parameters.remove("strength_shear");
    let found = text(&brittle);
    for words in [
        "power_exponent is 0",
        "without benzeggagh_kenane",
        "toughness_normal is 0.00003",
        "the work 0.00004",
        "strength_shear is missing",
    ] {
        assert!(found.contains(words), "{words}: {found}");
    }
    assert!(!found.contains("toughness_shear"), "{found}");
    let both = adhesive(&[("power_exponent", 1.0), ("benzeggagh_kenane", 1.0)]);
    assert!(text(&both).contains("remove one of them"));
    let criteria = adhesive(&[("erosion_von_mises", 1.0)]);
    assert!(text(&criteria).contains("no parameter 'erosion_von_mises'"));
    let steel = material("elastic", &[("youngs_modulus", 1.0), ("poisson", 0.3)], &[]);
    assert!(text(&steel).contains("is not for cohesive elements"), "{}", text(&steel));
    let solid = crate::materials::build_solid(&adhesive(&[])).err();
    assert!(format!("{solid:?}").contains("for cohesive elements only"), "{solid:?}");
}
