//! Validation: Taylor tests (B03) and impulsively loaded clamped plates (B17) against
//! measurements. Each law names the source of its constants; none was fitted to these tests.

use super::measure::{displacement, position};
use super::row::CheckRow;
use super::scene::{Elastic, Scene};
use super::{Bench, Check};

/// Check of B03, copper.
pub const COPPER: Check = Check { name: "Taylor tests of copper", quick: false, run: copper };
/// Check of B03, steel.
pub const STEEL_4340: Check = Check { name: "Taylor test of 4340 steel", quick: false, run: steel };
/// Check of B17, plates.
pub const PLATES: Check =
    Check { name: "clamped square plates under an impulse", quick: false, run: plates };

/// Test in which a bar hits a rigid wall.
struct Shot {
    length: f64,
    radius: f64,
    velocity: f64,
    friction: f64,
    until: f64,
    material: &'static str,
}

/// Runs a test; returns the final length and the largest radius, each over its initial value.
fn fired(bench: &Bench, name: &str, shot: &Shot) -> Result<[f64; 2], String> {
    const CELLS: usize = 6;
    let mut scene = Scene::new(shot.until);
    let along = (shot.length / shot.radius * CELLS as f64).round() as usize;
    let nodes = scene.quarter_bar(1, shot.radius, shot.length, CELLS / 2, along);
    scene
        .add(&format!("[[material]]\nname = \"metal\"\nlaw = \"johnson_cook\"\n{}", shot.material));
    scene.solid_part(1, "metal", "");
    scene.symmetry([0.0; 3], [1.0, 0.0, 0.0]);
    scene.symmetry([0.0; 3], [0.0, 1.0, 0.0]);
    scene.start(&nodes, [0.0, 0.0, -shot.velocity], [0.0; 3]);
    scene.wall([0.0; 3], [0.0, 0.0, 1.0], shot.friction);
    let run = bench.watch(name, &scene, |_| {})?;
    let at = |n: &u32| position(&run.engine, *n);
    let low = nodes.iter().map(|n| at(n)[2]).fold(f64::INFINITY, f64::min);
    let high = nodes.iter().map(|n| at(n)[2]).fold(f64::NEG_INFINITY, f64::max);
    let wide = nodes.iter().map(|n| at(n)[0].hypot(at(n)[1])).fold(0.0, f64::max);
    Ok([(high - low) / shot.length, wide / shot.radius])
}

/// OFHC copper of Johnson & Cook 1983.
const OFHC: &str = "density = 8960.0\nyoungs_modulus = 124e9\npoisson = 0.34\n\
                    a = 90e6\nb = 292e6\nn = 0.31\nc = 0.025\nreference_rate = 1.0\nm = 1.09\n\
                    reference_temperature = 25.0\nmelting_temperature = 1083.0\n\
                    specific_heat = 383.0\ntaylor_quinney = 0.9";
/// 4340 steel, Rockwell C 30, of Johnson & Cook 1983.
const RC30: &str = "density = 7830.0\nyoungs_modulus = 200e9\npoisson = 0.29\n\
                    a = 792e6\nb = 510e6\nn = 0.26\nc = 0.014\nreference_rate = 1.0\nm = 1.03\n\
                    reference_temperature = 25.0\nmelting_temperature = 1520.0\n\
                    specific_heat = 477.0\ntaylor_quinney = 0.9";

fn copper(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const WILKINS: &str = "experiment: Wilkins & Guinan 1973, as drawn in Zelepugin et al. 2023 \
                           [V:S4]; law of Johnson & Cook 1983";
    const M1: &str = "experiment: Zelepugin et al. 2022, copper M1, as drawn in Zelepugin et al. \
                      2023 [V:S4]; law of Johnson & Cook 1983 for another copper";
    let mut all = Vec::new();
    for (what, length, diameter, velocity, [long, wide], gated) in [
        ("OFHC", 23.47e-3, 7.62e-3, 210.0, [0.630, 2.204], true),
        ("M1", 34.5e-3, 7.8e-3, 162.0, [0.763, 1.701], false),
        ("M1", 34.5e-3, 7.8e-3, 167.0, [0.743, 1.772], false),
        ("M1", 34.5e-3, 7.8e-3, 225.0, [0.645, 2.056], false),
    ] {
        // The bar has stopped after about L/v.
        let until = 1.1 * length / velocity;
        let shot =
            Shot { length, radius: 0.5 * diameter, velocity, friction: 0.0, until, material: OFHC };
        let [l, r] = fired(bench, &format!("B03 {what} {velocity}"), &shot)?;
        let variant = format!("{what} copper, {velocity} m/s, 6 cells on the radius, no friction");
        let (length, radius) = (
            CheckRow::new("length / that at the start", &variant, "", l),
            CheckRow::new("largest radius / that at the start", &variant, "", r),
        );
        // The catalogue has 3 to 5 % and 8 % for a law of the tested copper.
        all.extend(match gated {
            true => [length.near(long, 0.05, WILKINS), radius.near(wide, 0.08, WILKINS)],
            false => [length.reference(long, M1), radius.reference(wide, M1)],
        });
    }
    Ok(all)
}

fn steel(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const TEST: &str =
        "experiment: catalogue B03, 37.97 by 7.595 mm [V:S14]; law of Johnson & Cook 1983";
    const CODE: &str = "[V:S14] converged, without friction";
    let mut all = Vec::new();
    for friction in [0.0, 0.09] {
        let (length, radius, velocity) = (37.97e-3, 3.7975e-3, 181.0);
        let shot = Shot { length, radius, velocity, friction, until: 80e-6, material: RC30 };
        let [l, r] = fired(bench, &format!("B03 4340 {friction}"), &shot)?;
        let variant = format!("4340 steel, 181 m/s, 6 cells on the radius, friction {friction}");
        all.push(
            CheckRow::new("length / that at the start", &variant, "", l).near(0.908, 0.03, TEST),
        );
        let foot = CheckRow::new("largest diameter", &variant, "mm", 2e3 * r * radius);
        // The radius depends on friction, the length on strength.
        all.push(if friction > 0.0 {
            foot.near(9.5, 0.08, TEST)
        } else {
            foot.near(10.13, 0.05, CODE)
        });
    }
    Ok(all)
}

/// Compares the mean deflection of the centre of a clamped square plate after the first peak,
/// over its thickness. A quarter of the plate starts with a uniform velocity.
fn plates(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const LINE: &str = "experiment: Nurick & Martin 1989, Int. J. Impact Engng 8, 171-186, line \
                        through tests of quadrangular plates as cited by others, 0.471 phi + \
                        0.001; most tests are within one thickness of the line";
    const N: usize = 24;
    let (side, thickness, yield_stress) = (89e-3, 1.6e-3, 296e6);
    let steel = Elastic { e: 207e9, nu: 0.3, rho: 7850.0 };
    let mut all = Vec::new();
    for phi in [8.0f64, 14.0, 20.0] {
        let expected = 0.471 * phi + 0.001;
        let speed = phi * 2.0 * thickness / side * (yield_stress / steel.rho).sqrt();
        for (how, rate) in
            [("no rate effect", ""), ("Cowper-Symonds 40.4/s, 5", "cowper_symonds = [40.4, 5.0]")]
        {
            let mut scene = Scene::new(0.6e-3);
            let grid = scene.grid(1, [N, N], |x, y| [0.5 * side * x, 0.5 * side * y, 0.0]);
            scene.plastic("steel", steel, yield_stress, 0.0);
            scene.add(rate);
            scene.part(1, "steel", thickness, "thinning = true");
            scene.symmetry([0.0; 3], [1.0, 0.0, 0.0]);
            scene.symmetry([0.0; 3], [0.0, 1.0, 0.0]);
            let edges: Vec<u32> =
                grid.row(N).into_iter().chain((0..N).map(|i| grid.at(i, N))).collect();
            scene.fix(&edges, "x y z rx ry rz");
            let inside: Vec<u32> =
                grid.all().iter().copied().filter(|n| !edges.contains(n)).collect();
            scene.start(&inside, [0.0, 0.0, speed], [0.0; 3]);
            let (mut sum, mut samples) = (0.0, 0.0);
            let run = bench.watch(&format!("B17 {phi} {how}"), &scene, |e| {
                let now = displacement(e, grid.at(0, 0))[2];
                if e.clock.time > 0.3e-3 {
                    (sum, samples) = (sum + now, samples + 1.0);
                }
            })?;
            let ours = sum / samples / thickness;
            let variant =
                format!("89 by 1.6 mm, {} by {} shells, impulse {phi}, {how}", 2 * N, 2 * N);
            let row = CheckRow::new("deflection after the peak / thickness", &variant, "", ours);
            // The line is for the static yield stress, but the steel of the tests hardens with
            // the rate.
            all.push(if rate.is_empty() {
                row.reference(expected, LINE)
            } else {
                row.within(expected, 1.0, LINE)
            });
            all.push(run.hourglass_row(&variant));
        }
    }
    Ok(all)
}
