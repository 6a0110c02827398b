//! Joints: a wave through a tied joint, tied plates in free flight (A32), welds that break
//! (A33).

use super::bars::BAR;
use super::measure::{mass, mean_velocity};
use super::row::CheckRow;
use super::scene::{Elastic, STEEL, Scene};
use super::solid_bars::INVISCID;
use super::{Bench, Check};
use crumple_worker::energy::momentum;

/// Check of A32.
pub const WAVE: Check = Check { name: "wave through a tied joint", quick: true, run: wave };
/// Check of A32, offset.
pub const FLIGHT: Check = Check { name: "tied plates in free flight", quick: true, run: flight };
/// Check of A33.
pub const WELD: Check =
    Check { name: "weld under tension, shear and both", quick: true, run: weld };

/// Sends a pulse of half a sine, a fifth of a bar long, through the joint of two bars. The bars
/// are of cubes, end to end, 2 N cells along; the second bar has `across` cells each way, and
/// its end is tied to the first one.
fn wave(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 50;
    const D: &str = "[D] the bar continues unchanged behind the joint: no reflection";
    let (length, stress) = (1.0, 1e6);
    let side = length / N as f64;
    let (time, pulse) = (length / BAR.c(), 0.2 * length / BAR.c());
    let mut all = Vec::new();
    for (across, mesh) in [(1, "matching"), (3, "three cells each way on one")] {
        // At the end the pulse has passed half of the second bar; a reflected pulse would be in
        // the first bar.
        let mut scene = Scene::new(1.6 * time);
        let bar = |scene: &mut Scene, part: u32, across: usize, from: f64| {
            scene.block(part, [N, across, across], |p| {
                [from + length * p[0], side * p[1], side * p[2]]
            })
        };
        let one = bar(&mut scene, 1, 1, 0.0);
        let two = bar(&mut scene, 2, across, length);
        scene.elastic("steel", BAR);
        (1..=2).for_each(|part| scene.solid_part(part, "steel", INVISCID));
        let end = scene.set(&two.layer(0, 0));
        scene.add(&format!("[[tie]]\nname = \"joint\"\nnodes = \"{end}\"\nparts = [1]"));
        let half_sine =
            |k: usize| (pulse * k as f64 / 20.0, (std::f64::consts::PI * k as f64 / 20.0).sin());
        let points: Vec<String> =
            (0..=20).map(half_sine).map(|(t, f)| format!("[{t:?}, {f:?}]")).collect();
        scene.add(&format!("[[curve]]\nname = \"pulse\"\npoints = [{}]", points.join(", ")));
        let face = scene.set(&one.layer(0, 0));
        scene.add(&format!(
            "[[pressure]]\nnodes = \"{face}\"\npressure = {stress:?}\ncurve = \"pulse\""
        ));
        let run = bench.watch(&format!("A32 wave {across}"), &scene, |_| {})?;
        let given = 2.0 / std::f64::consts::PI * stress * pulse * side * side;
        let momentum_of =
            |nodes: &[u32]| mass(&run.engine, nodes) * mean_velocity(&run.engine, nodes, 0);
        let variant = format!("tied bars, {mesh}");
        // The masters carry the mass of the nodes tied to them; the pulse is far from there.
        let back = CheckRow::new(
            "momentum that came back / impulse",
            &variant,
            "",
            momentum_of(one.all()) / given,
        );
        all.push(back.within(0.0, 0.01, D));
        let through = CheckRow::new(
            "momentum that went through / impulse",
            &variant,
            "",
            momentum_of(two.all()) / given,
        );
        all.push(through.within(1.0, 0.01, D));
        all.push(run.closing_row(&variant, 1e-3));
    }
    Ok(all)
}

/// Throws and turns a small plate that is tied at a distance to a larger one.
fn flight(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const EXACT: &str = "exact; round-off of some thousand steps";
    let mut all = Vec::new();
    for (offset, keys) in [
        ("offset", "offset = true"),
        ("moved onto the face", ""),
        ("with rotations", "rotations = true"),
    ] {
        let (thickness, gap) = (2e-3, if offset == "offset" { 2e-3 } else { 0.5e-3 });
        let mut scene = Scene::new(2e-3);
        scene.grid(1, [8, 8], |x, y| [0.1 * (x - 0.5), 0.1 * (y - 0.5), 0.0]);
        let small = scene.grid(2, [5, 5], |x, y| [0.04 * (x - 0.4), 0.04 * (y - 0.6), gap]);
        scene.elastic("steel", STEEL);
        (1..=2).for_each(|part| scene.part(part, "steel", thickness, "points = 2"));
        let set = scene.set(small.all());
        scene.add(&format!("[[tie]]\nname = \"patch\"\nnodes = \"{set}\"\nparts = [1]\n{keys}"));
        scene.add(
            "[[initial_velocity]]\nvelocity = [3.0, -2.0, 5.0]\nspin = [200.0, 100.0, -300.0]",
        );
        let run = bench.watch(&format!("A32 flight {offset}"), &scene, |_| {})?;
        let variant = format!("two plates, {offset}");
        let now: [[f64; 3]; 2] = momentum(&run.engine.nodes).into();
        let far =
            |k: usize| (0..3).map(|c| (now[k][c] - run.momentum[k][c]).powi(2)).sum::<f64>().sqrt();
        let size = |k: usize| run.momentum[k].iter().map(|c| c * c).sum::<f64>().sqrt();
        all.push(
            CheckRow::new("change of momentum / its size", &variant, "", far(0) / size(0))
                .at_most(1e-10, EXACT),
        );
        all.push(
            CheckRow::new("change of angular momentum / its size", &variant, "", far(1) / size(1))
                .at_most(1e-10, EXACT),
        );
        all.push(run.closing_row(&variant, 1e-3));
    }
    Ok(all)
}

/// Pulls a weld between a held node and one with a constant prescribed velocity.
fn weld(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const D: &str = "[D] elastic energy at the force that breaks the weld";
    // A stud of 10 mm; it is slow compared with its waves, so that the force is uniform.
    let (length, side, speed) = (0.01f64, 5e-3f64, 0.05);
    let (normal, shear) = (20e3, 12e3);
    let stiff = Elastic { e: 210e9, nu: 0.0, rho: 7850.0 };
    let area = side * side;
    let second = side.powi(4) / 12.0;
    let along = stiff.e * area / length;
    // Both ends are held against rotation: 12 E I/L^3.
    let across = 12.0 * stiff.e * second / length.powi(3);
    let mut all = Vec::new();
    for (how, degrees) in [("tension", 0.0f64), ("shear", 90.0), ("tension and shear", 30.0)] {
        let (s, c) = degrees.to_radians().sin_cos();
        // (u k_n c/N)^2 + (u k_s s/V)^2 = 1
        let breaks = ((along * c / normal).powi(2) + (across * s / shear).powi(2)).sqrt().recip();
        let mut scene = Scene::new(3.0 * breaks / speed);
        let nodes =
            [scene.node([0.0; 3]), scene.node([length, 0.0, 0.0]), scene.node([0.0, length, 0.0])];
        scene.beam(1, nodes);
        scene.elastic("steel", stiff);
        scene.add(&format!(
            "[[part]]\nid = 1\nmaterial = \"steel\"\n[part.beam]\nsection = \"rectangle\"\n\
             height = {side:?}\nwidth = {side:?}\n\
             [part.beam.weld]\nnormal = {normal:?}\nshear = {shear:?}"
        ));
        scene.fix(&nodes[..1], "x y z rx ry rz");
        let led = scene.set(&nodes[1..2]);
        scene.add(&format!(
            "[[motion]]\nnodes = \"{led}\"\ndofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
             velocity = [{:?}, {:?}, 0.0]",
            speed * c,
            speed * s
        ));
        let (mut before, mut broke) = (0.0, f64::NAN);
        let run = bench.watch(&format!("A33 {how}"), &scene, |e| {
            let now = e.ledger.energies(&e.nodes, &e.blocks).values().internal;
            if broke.is_nan() && before > 0.0 && now <= before {
                broke = speed * (e.clock.time - e.clock.last_dt);
            }
            before = now;
        })?;
        let variant = format!("weld 5 by 5 by 10 mm, {how}");
        let stored = 0.5 * breaks * breaks * (along * c * c + across * s * s);
        all.push(CheckRow::new("way at which it breaks", &variant, "um", 1e6 * broke).near(
            1e6 * breaks,
            0.01,
            "[D] (N/N0)^2 + (V/V0)^2 = 1",
        ));
        all.push(
            CheckRow::new("energy taken by it", &variant, "J", run.energies.internal)
                .near(stored, 0.02, D),
        );
        let led = run.energies.external / stored;
        all.push(CheckRow::new("work of the motion / the same", &variant, "", led).near(
            1.0,
            0.02,
            "[D] a broken weld carries no force",
        ));
    }
    Ok(all)
}
