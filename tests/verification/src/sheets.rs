//! Sheets: thickness in plastic flow (A36), elements that fail (A37), triangles in motion (A38).

use super::beams::{frequency, pluck};
use super::measure::fields;
use super::row::CheckRow;
use super::scene::{STEEL, Scene};
use super::{Bench, Check};
use std::f64::consts::PI;

/// Check of A36.
pub const THINNING: Check = Check { name: "stretched sheet", quick: true, run: thinning };
/// Check of A37.
pub const EROSION: Check = Check { name: "sheet pulled until it fails", quick: true, run: erosion };
/// Check of A38.
pub const TRIANGLES: Check = Check { name: "plate of triangles", quick: true, run: triangles };

const YIELD: f64 = 250e6;
const THICKNESS: f64 = 1e-3;
const SIDE: f64 = 0.01;
const QUADS: [&str; 3] = ["belytschko_tsay", "stabilised_quad", "fully_integrated_quad"];

/// Returns a scene with one square shell, so that no neck can form. It is stretched uniformly by
/// prescribed motion, along x by `stretch` and along y by `across` (free if `None`); `more` are
/// further keys of the material. The motion starts and ends at rest, so that no waves remain.
fn led(stretch: f64, across: Option<f64>, more: &str, part: &str) -> Scene {
    let time = 2e-3;
    let mut scene = Scene::new(time);
    let grid = scene.grid(1, [1, 1], |x, y| [SIDE * x, SIDE * y, 0.0]);
    scene.plastic("sheet", STEEL, YIELD, 0.0);
    scene.add(more);
    scene.part(1, "sheet", THICKNESS, part);
    scene.fix(&grid.row(0), "x z rx ry rz");
    scene.fix(&[grid.at(0, 0), grid.at(1, 0)], "y");
    // A velocity that rises and falls linearly; its integral is the displacement.
    scene.add(&format!(
        "[[curve]]\nname = \"way\"\n\
         points = [[0.0, 0.0], [{:?}, 1.0], [{:?}, 1.0], [{time:?}, 0.0]]",
        0.2 * time,
        0.8 * time
    ));
    let mut lead = |nodes: &[u32], axis: usize, way: f64| {
        let set = scene.set(nodes);
        let velocity: [f64; 3] =
            std::array::from_fn(|c| if c == axis { way / (0.8 * time) } else { 0.0 });
        let dof = ["x", "y", "z"][axis];
        scene.add(&format!(
            "[[motion]]\nnodes = \"{set}\"\ndofs = [\"{dof}\"]\n\
             velocity = {velocity:?}\ncurve = \"way\""
        ));
    };
    lead(&grid.row(1), 0, (stretch - 1.0) * SIDE);
    if let Some(across) = across {
        lead(&[grid.at(0, 1), grid.at(1, 1)], 1, (across - 1.0) * SIDE);
    }
    scene
}

fn thinning(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const D: &str =
        "[D] plastic flow keeps the volume; the elastic part (1 - 2 nu) p/E is a thousandth";
    let mut all = Vec::new();
    for element in QUADS {
        for (how, stretch, across, thinner) in [
            ("uniaxial stress, 1.2", 1.2, None, 1.2f64.sqrt()),
            ("width held, 1.2", 1.2, Some(1.0), 1.2),
            ("both ways, 1.2", 1.2, Some(1.2), 1.44),
        ] {
            let scene =
                led(stretch, across, "", &format!("thinning = true\nelement = \"{element}\""));
            let run = bench.watch(&format!("A36 {element} {how}"), &scene, |_| {})?;
            let now = fields(&run.engine)[0].thickness;
            let variant = format!("{element}, {how}");
            all.push(
                CheckRow::new("thickness / that at the start", &variant, "", now / THICKNESS).near(
                    1.0 / thinner,
                    3e-3,
                    D,
                ),
            );
            all.push(run.closing_row(&variant, 1e-2));
        }
    }
    Ok(all)
}

fn erosion(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const D: &str = "[D] work of a perfectly plastic sheet until it fails, in logarithmic strain; \
                     it stays in the ledger after failure";
    let fails = 0.1;
    let mut all = Vec::new();
    for element in QUADS {
        let scene = led(
            1.25,
            None,
            &format!("failure_strain = {fails:?}"),
            &format!("thinning = true\nelement = \"{element}\""),
        );
        let mut whole = 0.0f64;
        let run = bench.watch(&format!("A37 {element}"), &scene, |e| {
            whole = whole.max(e.ledger.energies(&e.nodes, &e.blocks).values().external);
        })?;
        let variant = format!("{element}, failure strain {fails}");
        let volume = THICKNESS * SIDE * SIDE;
        let taken = (YIELD * fails + 0.5 * YIELD * YIELD / STEEL.e) * volume;
        let failed = fields(&run.engine).iter().filter(|f| f.failed).count();
        all.push(CheckRow::new("elements that failed", &variant, "", failed as f64).within(
            1.0,
            0.0,
            "[D] all elements",
        ));
        all.push(
            CheckRow::new("internal energy at the end", &variant, "J", run.energies.internal)
                .near(taken, 0.02, D),
        );
        all.push(
            CheckRow::new("work of the motion, largest", &variant, "J", whole).near(taken, 0.03, D),
        );
        all.push(run.closing_row(&variant, 1e-2));
    }
    Ok(all)
}

fn triangles(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let side = 0.2;
    let mut all = Vec::new();
    for (p, q, f) in [(1.0, 1.0, 491.0), (1.0, 2.0, 1224.8)] {
        for n in [6usize, 12, 24] {
            let mut scene = Scene::new(3.2 / f);
            let nodes: Vec<Vec<u32>> = (0..=n)
                .map(|i| {
                    (0..=n)
                        .map(|j| {
                            scene.node([
                                side * i as f64 / n as f64,
                                side * j as f64 / n as f64,
                                0.0,
                            ])
                        })
                        .collect()
                })
                .collect();
            for (i, j) in (0..n).flat_map(|i| (0..n).map(move |j| (i, j))) {
                let [a, b, c, d] =
                    [nodes[i][j], nodes[i + 1][j], nodes[i + 1][j + 1], nodes[i][j + 1]];
                // The directions of diagonals alternate, so that the mesh has no preferred
                // direction.
                let two =
                    if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                two.iter().for_each(|t| _ = scene.shell(1, t));
            }
            scene.elastic("steel", STEEL);
            scene.part(1, "steel", 0.004, "");
            // Hard support: the edge does not rotate about its normal either.
            for i in [0, n] {
                scene.fix(&nodes[i], "z rx");
                let column: Vec<u32> = nodes.iter().map(|row| row[i]).collect();
                scene.fix(&column, "z ry");
            }
            let (p, q) = (p * PI / side, q * PI / side);
            let all_nodes: Vec<u32> = nodes.concat();
            let shape = pluck(&mut scene, &all_nodes, |x| {
                let (a, b) = (p * x[0], q * x[1]);
                (a.sin() * b.sin(), [p * a.cos() * b.sin(), q * a.sin() * b.cos()])
            });
            let ours = frequency(bench, &format!("A38 {f} {n}"), &scene, &shape, 2)?;
            let row = CheckRow::new(
                format!("frequency ({p:.0},{q:.0})", p = p * side / PI, q = q * side / PI),
                format!("c0_triangle, {n} by {n} by 2"),
                "Hz",
                ours,
            );
            all.push(if n == 24 {
                row.near(f, 0.01, "[D] Mindlin, catalogue A16")
            } else {
                row.reference(f, "[D] Mindlin")
            });
        }
    }
    Ok(all)
}
