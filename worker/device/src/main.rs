//! Steps of a sheet of shells on a GPU, checked against the same functions on a CPU, and timed.
//!
//! Usage: `crumple-device KERNELS.ptx`. Prints a table in Markdown.

mod gpu;
mod scene;

use crumple_device_kernels::{Direct, SAFETY, element, node};
use crumple_fem::materials::PointLanes;
use gpu::{DIRECT, Gpu, TABLE, Times};
use scene::Scene;
use std::error::Error;

/// Shells along and across the sheet of the check, and steps.
const CHECKED: [usize; 2] = [120, 60];
const CHECKED_STEPS: u32 = 400;
/// Shells along and across the sheets that are timed.
const TIMED: [[usize; 2]; 5] = [[120, 60], [360, 180], [720, 360], [1440, 720], [2880, 1440]];
/// Steps of a timing, after as many that are not timed.
const TIMED_STEPS: u32 = 200;
/// Timings of each sheet; the median counts.
const ROUNDS: usize = 5;
/// Threads per block.
const THREADS: u32 = 64;

fn main() -> Result<(), Box<dyn Error>> {
    let path = std::env::args().nth(1).ok_or("give the file of the kernels: KERNELS.ptx")?;
    let gpu = Gpu::new(&path).map_err(|e| format!("{path}: {e}"))?;
    println!("Device: {}", gpu.name()?);
    for kernel in [DIRECT, TABLE] {
        check(&gpu, kernel)?;
    }
    println!();
    println!("| kernel | shells | elements | nodes | step | ns per shell |");
    println!("|---|---|---|---|---|---|");
    for kernel in [DIRECT, TABLE] {
        for size in TIMED {
            time(&gpu, kernel, size)?;
        }
    }
    Ok(())
}

/// Does steps on the CPU and returns the last step size [ms].
fn run_here<L: PointLanes<1>>(scene: &mut Scene, steps: u32) -> f64 {
    let mut last = 0.0;
    for _ in 0..steps {
        let (mesh, mut least) = (scene.mesh(), f64::INFINITY);
        for i in 0..mesh.count {
            // SAFETY: the columns of a scene have the lengths of its mesh.
            least = least.min(unsafe { element::<L>(&scene.shell, &mesh, i, last) });
        }
        let dt = SAFETY * least;
        for i in 0..mesh.nodes {
            // SAFETY: as above.
            unsafe { node(&mesh, i, 0.5 * (last + dt), dt) };
        }
        last = dt;
    }
    last
}

/// Runs the same steps on both sides and compares all bits.
fn check(gpu: &Gpu, kernel: &str) -> Result<(), Box<dyn Error>> {
    let mut host = Scene::new(CHECKED);
    let mut device = gpu.upload(&host)?;
    device.run(kernel, THREADS, CHECKED_STEPS)?;
    let last = run_here::<Direct>(&mut host, CHECKED_STEPS);
    let copy = device.download()?;
    let [most, flowed] = host.plastic_strain();
    println!(
        "{kernel}: {} shells, {CHECKED_STEPS} steps, last step {last:.6e} ms, plastic strain up to \
         {most:.4}, at {:.0} % of the points",
        host.mesh().count,
        100.0 * flowed
    );
    let mut differing = 0;
    for ((name, ours), (_, theirs)) in host.columns().into_iter().zip(copy.columns()) {
        let differ = ours.iter().zip(&theirs).filter(|(a, b)| a.to_bits() != b.to_bits()).count();
        println!("- {name}: {differ} of {} numbers differ", ours.len());
        differing += differ;
    }
    if differing > 0 || copy.trouble[0] != 0 || most == 0.0 {
        return Err("the results of the GPU are not those of the CPU, or nothing flows".into());
    }
    Ok(())
}

/// Times the steps of one sheet and prints a row.
fn time(gpu: &Gpu, kernel: &str, size: [usize; 2]) -> Result<(), Box<dyn Error>> {
    let mut scene = Scene::new(size);
    let count = scene.mesh().count;
    let mut device = gpu.upload(&scene)?;
    device.run(kernel, THREADS, TIMED_STEPS)?;
    let mut all = Vec::new();
    for _ in 0..ROUNDS {
        all.push(device.time(kernel, THREADS, TIMED_STEPS)?);
    }
    let median = |of: fn(&Times) -> f64| {
        let mut values: Vec<f64> = all.iter().map(of).collect();
        values.sort_by(f64::total_cmp);
        values[ROUNDS / 2]
    };
    let [elements, nodes, step] = [median(|t| t.elements), median(|t| t.nodes), median(|t| t.step)];
    println!(
        "| {kernel} | {count} | {elements:.4} ms | {nodes:.4} ms | {step:.4} ms | {:.3} |",
        step * 1e6 / count as f64
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The steps of the sheet keep its momentum to round-off, and make it flow.
    #[test]
    fn steps_keep_momentum() {
        let mut scene = Scene::new([24, 12]);
        let momentum = |scene: &Scene| {
            let of = |c: usize| {
                let nodes = scene.data.v.iter().zip(&scene.data.inverse);
                nodes.map(|(v, [mass, _])| v[c] / mass).sum::<f64>()
            };
            [0, 1, 2].map(of)
        };
        let before = momentum(&scene);
        let last = run_here::<Direct>(&mut scene, 200);
        let after = momentum(&scene);
        for c in 0..3 {
            assert!((after[c] - before[c]).abs() < 1e-12 * before[0].abs(), "{before:?} {after:?}");
        }
        assert_eq!(scene.data.trouble, [0]);
        let [most, flowed] = scene.plastic_strain();
        assert!(last > 0.0 && most > 1e-3 && flowed > 0.1, "{last} {most} {flowed}");
    }

    /// A direct call of the law has the bits of a call through its table.
    #[test]
    fn both_scalars_have_the_same_bits() {
        let mut scenes = [Scene::new([12, 6]), Scene::new([12, 6])];
        run_here::<Direct>(&mut scenes[0], 200);
        run_here::<f64>(&mut scenes[1], 200);
        assert_eq!(scenes[0].columns(), scenes[1].columns());
        assert!(scenes[0].plastic_strain()[0] > 1e-3);
    }
}
