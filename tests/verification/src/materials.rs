//! A27, A26 (c): plasticity of a single shell or cube along strain paths with a known result.

use super::measure::{fields, lead};
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::solid_bars::INVISCID;
use super::{Bench, Check};
use crumple_worker::fem::elements::ElementFields;
use std::cell::Cell;
use std::ops::ControlFlow;

/// Check of A27, uniaxial.
pub const UNIAXIAL: Check = Check { name: "uniaxial stress", quick: true, run: uniaxial };
/// Check of A27: paths prescribed in both directions.
pub const PATHS: Check = Check { name: "led strain paths", quick: true, run: paths };
/// Check of A27, cyclic.
pub const CYCLIC: Check = Check { name: "cyclic loading", quick: true, run: cyclic };
/// Check of A27: the law of Johnson and Cook.
pub const JOHNSON_COOK: Check = Check { name: "johnson_cook", quick: true, run: johnson_cook };
/// Check of A27, laws with a rate.
pub const RATES: Check = Check { name: "strain rates", quick: true, run: rates };
/// Check of A26 (c).
pub const SQUASHED: Check =
    Check { name: "isochoric squash of a cube", quick: true, run: squashed };

const YIELD: f64 = 250e6;
const MODULUS: f64 = 1e9;
const SIDE: f64 = 0.01;

/// Body that is deformed.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Body {
    Shell,
    Cube,
}

impl Body {
    const ALL: [Self; 2] = [Self::Shell, Self::Cube];

    fn name(self) -> &'static str {
        match self {
            Self::Shell => "belytschko_tsay",
            Self::Cube => "hexahedron",
        }
    }

    fn scene(self, end: f64, material: AddMetal<'_>) -> Scene {
        let mut scene = Scene::new(end);
        material(&mut scene);
        let nodes = match self {
            Self::Shell => {
                scene.part(1, "metal", 1e-3, "element = \"belytschko_tsay\"");
                scene.grid(1, [1, 1], |x, y| [SIDE * x, SIDE * y, 0.0]).all().to_vec()
            }
            Self::Cube => {
                scene.solid_part(1, "metal", INVISCID);
                scene.block(1, [1; 3], |p| p.map(|x| SIDE * x)).all().to_vec()
            }
        };
        scene.fix(&nodes, if self == Self::Shell { "x y z rx ry rz" } else { "x y z" });
        scene
    }
}

/// Function that adds the material "metal" to a scene.
type AddMetal<'a> = &'a dyn Fn(&mut Scene);

/// Deforms one shell or cube with prescribed logarithmic strains along x, y and z. `rates` gives
/// their rates per run from the time in runs, the step in runs and the stress of the previous
/// step; a shell uses the first two. Calls `at` with the strains and the fields of the same
/// time. Returns the time of the run [s].
fn led(
    bench: &Bench,
    (name, body, material): (&str, Body, AddMetal<'_>),
    steps: f64,
    mut rates: impl FnMut(f64, f64, &ElementFields) -> [f64; 3],
    mut at: impl FnMut([f64; 3], &ElementFields),
) -> Result<f64, String> {
    let dt = bench.model(name, &body.scene(1.0, material))?.first_dt().0;
    let end = steps * dt;
    let mut scene = body.scene(end, material);
    // The step stays that of the start, however the body deforms.
    scene.time(&format!("dt_max = {dt:?}"));
    let mut strain = [0.0; 3];
    let places: Vec<[f64; 3]> = (1..=scene.count()).map(|n| scene.at(n)).collect();
    let run = bench.run(name, &scene, |e| {
        let (t, dt) = (e.clock.time, e.clock.last_dt);
        if dt > 0.0 {
            // The stress is still that of the previous time, and so is the strain.
            let before = fields(e)[0];
            at(strain, &before);
            let rate = rates((t - dt) / end, dt / end, &before);
            let next: [f64; 3] = std::array::from_fn(|c| strain[c] + rate[c] * dt / end);
            for (n, x) in (1..).zip(&places) {
                let pose = |s: [f64; 3]| (std::array::from_fn(|c| x[c] * s[c].exp()), [0.0; 3]);
                lead(e, n, pose(strain), pose(next));
            }
            strain = next;
        }
        ControlFlow::Continue(())
    })?;
    if run.trouble {
        Err(format!("{name}: the run stopped because an element failed"))
    } else {
        Ok(end)
    }
}

/// Returns the J2 plasticity of the catalogue.
fn j2(modulus: f64) -> impl Fn(&mut Scene) {
    move |scene| scene.plastic("metal", STEEL, YIELD, modulus)
}

/// Rates of uniaxial stress: `along` the x axis per run, and lateral rates that keep the lateral
/// stress at zero.
struct Uniaxial {
    yielded: bool,
    ratio: f64,
}

impl Uniaxial {
    fn new() -> Self {
        Self { yielded: false, ratio: -STEEL.nu }
    }

    /// Returns the rates; `flows` is true if the metal yields now.
    fn rates(&mut self, along: f64, flows: bool, dt: f64, f: &ElementFields) -> [f64; 3] {
        if flows != self.yielded {
            // Initial ratio: elastic, or without change of volume. The feedback below corrects
            // the rest.
            (self.yielded, self.ratio) = (flows, if flows { -0.5 } else { -STEEL.nu });
        }
        // Each step removes a part of the lateral stress and changes the ratio slightly.
        let back = -f.stress[1] / (STEEL.e * dt);
        self.ratio += 0.02 * back / along;
        let across = self.ratio * along + 0.3 * back;
        [along, across, across]
    }
}

fn uniaxial(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for body in Body::ALL {
        let mut path = Uniaxial::new();
        let (mut last, mut worst, mut normal) =
            (([0.0; 3], ElementFields::default()), 0.0f64, 0.0f64);
        led(
            bench,
            (&format!("A27 uniaxial stress {}", body.name()), body, &j2(MODULUS)),
            20_000.0,
            |_, dt, f| path.rates(0.05, f.plastic_strain > 0.0, dt, f),
            |strain, f| {
                if f.plastic_strain > 0.0 {
                    worst =
                        worst.max((f.von_mises - YIELD - MODULUS * f.plastic_strain).abs() / YIELD);
                }
                normal = normal.max(f.stress[2].abs() / YIELD);
                last = (strain, *f);
            },
        )?;
        let (strain, f) = last;
        let plastic = (STEEL.e * strain[0] - YIELD) / (STEEL.e + MODULUS);
        let variant = format!("j2, {}, 20000 steps", body.name());
        all.push(
            CheckRow::new(
                "uniaxial stress at a strain of 5 %",
                &variant,
                "MPa",
                1e-6 * f.stress[0],
            )
            .near(1e-6 * (YIELD + MODULUS * plastic), 1e-6, "[D] 298.58 MPa at 0.05"),
        );
        all.push(CheckRow::new("plastic strain there", &variant, "", f.plastic_strain).near(
            plastic,
            1e-6,
            "[D] 0.04858 at 0.05",
        ));
        all.push(
            CheckRow::new("largest distance from the yield surface / sigma_y", &variant, "", worst)
                .at_most(1e-8, "limit of the catalogue"),
        );
        if body == Body::Shell {
            let row = CheckRow::new("largest normal stress / sigma_y", &variant, "", normal);
            all.push(row.at_most(1e-8, "limit of the catalogue"));
        }
    }
    Ok(all)
}

fn paths(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let mut all = Vec::new();
    for body in Body::ALL {
        let variant = format!("perfect j2, {}, 2000 steps", body.name());
        let mpa = 1e-6;
        let end = |name: &str, along: [f64; 3]| -> Result<ElementFields, String> {
            let mut last = ElementFields::default();
            let name = format!("A27 {name} {}", body.name());
            led(bench, (&name, body, &j2(0.0)), 2000.0, |_, _, _| along, |_, f| last = *f)?;
            Ok(last)
        };
        let shear = end("pure shear", [0.02, -0.02, 0.0])?;
        let sheared = 0.5 * (shear.stress[0] - shear.stress[1]);
        all.push(CheckRow::new("yield in pure shear", &variant, "MPa", mpa * sheared).near(
            mpa * YIELD / 3f64.sqrt(),
            1e-6,
            "[D] sigma_y / sqrt 3",
        ));
        // A cube needs lateral contraction for plane stress; these two laws are of plane stress.
        if body == Body::Cube {
            continue;
        }
        let both = end("equibiaxial", [0.02, 0.02, 0.0])?;
        let held = end("plane strain", [0.05, 0.0, 0.0])?;
        let mut seen: Vec<(f64, f64)> = Vec::new();
        let there_and_back = |t: f64, _: f64, _: &ElementFields| {
            if t < 0.5 { [0.02, 0.02, 0.0] } else { [-0.001, -0.001, 0.0] }
        };
        let look = |s: [f64; 3], f: &ElementFields| seen.push((s[0], f.stress[0]));
        led(bench, ("A27 unloading", body, &j2(0.0)), 2000.0, there_and_back, look)?;
        let (from, to) = (seen[seen.len() * 6 / 10], seen[seen.len() - 1]);
        let slope = (to.1 - from.1) / (to.0 - from.0);
        all.push(
            CheckRow::new("yield in equibiaxial tension", &variant, "MPa", mpa * both.stress[0])
                .near(mpa * YIELD, 1e-6, "[D] sigma_y"),
        );
        all.push(
            CheckRow::new(
                "tension with the width held, at 5 %",
                &variant,
                "MPa",
                mpa * held.stress[0],
            )
            .near(mpa * 2.0 * YIELD / 3f64.sqrt(), 1e-6, "[D] 2 sigma_y / sqrt 3"),
        );
        all.push(
            CheckRow::new("slope of equibiaxial unloading", &variant, "GPa", 1e-9 * slope).near(
                1e-9 * STEEL.e / (1.0 - STEEL.nu),
                1e-6,
                "[D] E/(1-nu)",
            ),
        );
    }
    Ok(all)
}

fn cyclic(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const SWING: f64 = 0.02;
    let mut all = Vec::new();
    for body in Body::ALL {
        // To 2 %, to -2 %, to 2 % again: five quarters of a cycle each way.
        let turns = [0.2, 0.6];
        let (mut path, mut plastic, mut ends) = (Uniaxial::new(), 0.0, Vec::new());
        let here = Cell::new((0.0, ElementFields::default()));
        led(
            bench,
            (&format!("A27 cyclic {}", body.name()), body, &j2(MODULUS)),
            20_000.0,
            |t, dt, f| {
                let turning = turns.get(ends.len()).is_some_and(|&turn| t >= turn - 0.5 * dt);
                if turning {
                    ends.push(here.get());
                }
                let flows = f.plastic_strain > plastic && !turning;
                plastic = f.plastic_strain;
                let along = 5.0 * SWING * if ends.len() == 1 { -1.0 } else { 1.0 };
                path.rates(along, flows, dt, f)
            },
            |strain, f| here.set((strain[0], *f)),
        )?;
        ends.push(here.get());
        let variant = format!("isotropic j2, {}, 20000 steps", body.name());
        let (mut stress, mut plastic, mut from) = (0.0, 0.0, 0.0);
        for (number, (strain, f)) in (1..).zip(&ends) {
            // From the present stress to that on the other side: elastic except for the plastic
            // part.
            let way: f64 = strain - from;
            let flow =
                (STEEL.e * way.abs() - stress - (YIELD + MODULUS * plastic)) / (STEEL.e + MODULUS);
            (plastic, from) = (plastic + flow, *strain);
            stress = YIELD + MODULUS * plastic;
            let row = CheckRow::new(
                format!("stress at turn {number}"),
                &variant,
                "MPa",
                1e-6 * f.stress[0],
            );
            all.push(row.near(
                1e-6 * way.signum() * stress,
                1e-6,
                "[D] sigma_y + E_p times the plastic strain so far",
            ));
            let row = CheckRow::new(
                format!("plastic strain at turn {number}"),
                &variant,
                "",
                f.plastic_strain,
            );
            all.push(row.near(plastic, 1e-6, "[D]"));
        }
    }
    Ok(all)
}

/// Johnson and Cook's law for 42CrMo4 (B02), SI units.
const A: f64 = 806e6;
const B: f64 = 614e6;
const N: f64 = 0.168;
const C: f64 = 0.0089;
const M: f64 = 1.1;

fn johnson_cook(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let (cold, melting, heat, share) = (20.0, 1540.0, 460.0, 0.9);
    let mut all = Vec::new();
    for (hot, body) in
        [(false, Body::Shell), (false, Body::Cube), (true, Body::Shell), (true, Body::Cube)]
    {
        let law = |scene: &mut Scene| {
            let thermal = format!(
                "m = {M}\nreference_temperature = {cold:?}\nmelting_temperature = {melting:?}\n\
                 specific_heat = {heat:?}\ntaylor_quinney = {share}"
            );
            scene.add(&format!(
                "[[material]]\nname = \"metal\"\nlaw = \"johnson_cook\"\ndensity = {:?}\n\
                 youngs_modulus = {:?}\npoisson = {:?}\na = {A:?}\nb = {B:?}\nn = {N}\nc = {C}\n\
                 reference_rate = 1e-3\n{}",
                STEEL.rho,
                STEEL.e,
                STEEL.nu,
                if hot { &thermal } else { "" }
            ));
        };
        // The path is isochoric: the deviatoric strain is the strain, and its rate is known.
        let (along, how) = (0.2, if hot { "with heat" } else { "without heat" });
        let mut last = ElementFields::default();
        let name = format!("A27 johnson_cook {how} {}", body.name());
        let end = led(
            bench,
            (&name, body, &law),
            20_000.0,
            |_, _, _| [along, -along, 0.0],
            |_, f| last = *f,
        )?;
        let rate = 2.0 / 3f64.sqrt() * along / end;
        let rated = 1.0 + C * (rate / 1e-3).ln();
        let yields = |p: f64, t: f64| {
            let soft =
                if hot { 1.0 - ((t - cold) / (melting - cold)).max(0.0).powf(M) } else { 1.0 };
            (A + B * p.max(0.0).powf(N)) * rated * soft
        };
        // Temperature over plastic strain by the midpoint rule.
        const STEPS: usize = 100_000;
        let (step, mut t) = (last.plastic_strain / STEPS as f64, cold);
        let warms = |p: f64, t: f64| share * yields(p, t) / (STEEL.rho * heat);
        for k in 0..STEPS {
            let p = k as f64 * step;
            let half = t + 0.5 * step * warms(p, t);
            t += step * warms(p + 0.5 * step, half);
        }
        let variant = format!("{}, {how}, 20000 steps", body.name());
        let row = CheckRow::new(
            "flow stress at a shear strain of 0.4",
            &variant,
            "MPa",
            1e-6 * last.von_mises,
        );
        let expected = yields(last.plastic_strain, t);
        all.push(row.near(
            1e-6 * expected,
            if hot { 1e-4 } else { 1e-6 },
            "[D] (a + b p^n)(1 + c ln rate*)(1 - T*^m), heat integrated separately; steps are of \
             first order in T",
        ));
        let elastic =
            2.0 / 3f64.sqrt() * along - expected / (3.0 * STEEL.e / (2.0 * (1.0 + STEEL.nu)));
        let row = CheckRow::new("plastic strain there", &variant, "", last.plastic_strain);
        all.push(row.near(elastic, 1e-4, "[D] strain less sigma/3G, one step before the end"));
    }
    Ok(all)
}

/// Compares the yield stress over the static one at two rates, a decade apart, in plane stress
/// and in three dimensions.
fn rates(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const SYMONDS: [f64; 2] = [40.0, 5.0];
    const ALONG: f64 = 0.1;
    let j2 = |scene: &mut Scene| {
        scene.plastic("metal", STEEL, YIELD, MODULUS);
        scene.add(&format!("cowper_symonds = {SYMONDS:?}"));
    };
    let johnson_cook = |scene: &mut Scene| {
        scene.add(&format!(
            "[[material]]\nname = \"metal\"\nlaw = \"johnson_cook\"\ndensity = {:?}\n\
             youngs_modulus = {:?}\npoisson = {:?}\na = {A:?}\nb = {B:?}\nn = {N}\nc = {C}\n\
             reference_rate = 1.0",
            STEEL.rho, STEEL.e, STEEL.nu
        ));
    };
    let by_j2 = |p: f64, rate: f64| {
        (YIELD + MODULUS * p) * (1.0 + (rate / SYMONDS[0]).powf(1.0 / SYMONDS[1]))
    };
    let by_johnson_cook = |p: f64, rate: f64| (A + B * p.powf(N)) * (1.0 + C * rate.ln());
    type Law<'a> = (&'static str, AddMetal<'a>, &'a dyn Fn(f64, f64) -> f64, &'static str);
    let laws: [Law<'_>; 2] = [
        ("j2, cowper_symonds", &j2, &by_j2, "[D] (sigma_y + E_p p) (1 + (rate/C)^(1/p))"),
        ("johnson_cook", &johnson_cook, &by_johnson_cook, "[D] (a + b p^n)(1 + c ln rate*)"),
    ];
    let mut all = Vec::new();
    for (body, (law, metal, stress, source)) in
        Body::ALL.into_iter().flat_map(|body| laws.map(|law| (body, law)))
    {
        for steps in [2000.0, 20_000.0] {
            let mut last = ElementFields::default();
            let name = format!("A27 {law} shear {} {steps}", body.name());
            // Without change of volume the strain is its own deviator.
            let end = led(
                bench,
                (&name, body, metal),
                steps,
                |_, _, _| [ALONG, -ALONG, 0.0],
                |_, f| last = *f,
            )?;
            let rate = 2.0 / 3f64.sqrt() * ALONG / end;
            let variant = format!("{law}, {}, {rate:.0}/s", body.name());
            let row =
                CheckRow::new("flow stress in pure shear", &variant, "MPa", 1e-6 * last.von_mises);
            all.push(row.near(1e-6 * stress(last.plastic_strain, rate), 1e-6, source));
            if body == Body::Cube {
                continue;
            }
            let mut path = Uniaxial::new();
            let name = format!("A27 {law} uniaxial {steps}");
            let pull = |_: f64, dt: f64, f: &ElementFields| {
                path.rates(ALONG, f.plastic_strain > 0.0, dt, f)
            };
            let end = led(bench, (&name, body, metal), steps, pull, |_, f| last = *f)?;
            // Flow without change of volume has the rate of the axial strain; the elastic part
            // of the rate decreases with E_p/E.
            let variant = format!("{law}, {}, {:.0}/s", body.name(), ALONG / end);
            let row = CheckRow::new("uniaxial stress", &variant, "MPa", 1e-6 * last.stress[0]);
            all.push(row.near(1e-6 * stress(last.plastic_strain, ALONG / end), 1e-4, source));
        }
    }
    Ok(all)
}

fn squashed(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let yield_stress = 800e6;
    let law = |scene: &mut Scene| scene.plastic("metal", STEEL, yield_stress, 0.0);
    let half = 2f64.ln();
    let (mut last, mut pressure) = (ElementFields::default(), 0.0f64);
    led(
        bench,
        ("A26 squash", Body::Cube, &law),
        20_000.0,
        |_, _, _| [half, 0.0, -half],
        |_, f| {
            pressure =
                pressure.max((f.stress[0] + f.stress[1] + f.stress[2]).abs() / 3.0 / yield_stress);
            last = *f;
        },
    )?;
    let variant = "perfect j2, hexahedron, to half the height in 20000 steps";
    Ok(vec![
        CheckRow::new("largest pressure / sigma_y", variant, "", pressure)
            .at_most(1e-9, "limit of the catalogue [V:S14]"),
        CheckRow::new("sigma_zz", variant, "MPa", 1e-6 * last.stress[2]).near(
            -1e-6 * yield_stress / 3f64.sqrt(),
            1e-6,
            "[V:S14] -461.88 MPa; tolerance of A27",
        ),
    ])
}
