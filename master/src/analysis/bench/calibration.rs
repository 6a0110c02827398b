//! Present speed of one core of this machine, to which all times of a benchmark are compared.

use crumple_proto::transport::thread_cpu;
use crumple_worker::math::lanes::{LANES, Lane};
use std::hint::black_box;

/// Number of independent chains of fused multiply-adds: latency 4, two units.
const CHAINS: usize = 12;
/// Rounds of all chains in one measurement: some hundredths of a second.
const ROUNDS: usize = 4_000_000;
/// Length of each of the three arrays of the triad. Together they are much larger than any cache.
const TRIAD: usize = 1 << 24;
/// Number of measurements, of which the best counts.
const TRIES: usize = 3;

/// Limits of one core.
#[derive(Clone, Copy, Debug, serde::Serialize)]
pub struct Calibration {
    /// Rate of fused multiply-adds of [`LANES`] f64, two operations each [GFLOP/s].
    pub fma_gflops: f64,
    /// Rate of `a = b + s c` over arrays larger than any cache, three numbers moved per element
    /// [GB/s].
    pub triad_gb_s: f64,
}

/// Measures both limits in about a second.
pub fn calibrate() -> Calibration {
    let best = |measure: &mut dyn FnMut() -> f64| (0..TRIES).map(|_| measure()).fold(0.0, f64::max);
    let mut arrays = [vec![0.0; TRIAD], vec![1.0; TRIAD], vec![2.0; TRIAD]];
    Calibration { fma_gflops: best(&mut fma), triad_gb_s: best(&mut || triad(&mut arrays)) }
}

fn fma() -> f64 {
    let (factor, term) = (black_box(Lane::splat(0.999_999)), black_box(Lane::splat(1e-6)));
    let mut sums = [Lane::splat(1.0); CHAINS];
    let start = thread_cpu();
    for _ in 0..ROUNDS {
        for sum in &mut sums {
            *sum = sum.mul_add(factor, term);
        }
    }
    let seconds = (thread_cpu() - start).as_secs_f64();
    black_box(sums);
    1e-9 * (2 * LANES * CHAINS * ROUNDS) as f64 / seconds
}

fn triad([a, b, c]: &mut [Vec<f64>; 3]) -> f64 {
    let scale = black_box(3.0);
    let start = thread_cpu();
    for ((a, b), c) in a.iter_mut().zip(b.iter()).zip(c.iter()) {
        *a = scale * c + b;
    }
    let seconds = (thread_cpu() - start).as_secs_f64();
    black_box(&a[..]);
    1e-9 * (3 * size_of::<f64>() * TRIAD) as f64 / seconds
}
