//! The jeep frame in free flight with a spin: conserved quantities, and the number of
//! redecompositions.
//!
//! Wang 2007 redecomposes when the largest displacement exceeds the buffer. Here displacement is
//! measured relative to a rigid motion of each worker's content. Flight alone therefore needs no
//! redecomposition; only the frame's own vibration does.

use crumple_tests::program::{Ended, crumple_with, numbers, run};

/// Half the smallest side [mm].
const BUFFER: &str = "parallel.buffer=7.042";

fn flight(workers: &str) -> Ended {
    // Boxes are computed again only for the load, which depends on the clock; here only motion
    // may require it.
    let args = [
        "run",
        "cases/flight",
        "--workers",
        workers,
        "--set",
        "output.field_interval=-1",
        "--set",
        "parallel.imbalance=100",
        "--set",
        BUFFER,
    ];
    run(crumple_with(&args)).with_code(0)
}

/// Returns the largest change of a column triple since the start, as a fraction of its size at
/// the start.
fn drift(r: &Ended, name: &str) -> f64 {
    let h = r.history();
    let [x, y, z] = ["x", "y", "z"].map(|c| h.column(&format!("{name} {c}")));
    let size = (x[0] * x[0] + y[0] * y[0] + z[0] * z[0]).sqrt();
    let off =
        |i: usize| ((x[i] - x[0]).powi(2) + (y[i] - y[0]).powi(2) + (z[i] - z[0]).powi(2)).sqrt();
    (0..x.len()).map(off).fold(0.0, f64::max) / size
}

#[test]
fn a_thrown_frame_keeps_what_it_has_and_seldom_renews_its_boxes() {
    let (one, four) = (flight("1"), flight("4"));
    assert_eq!(one.digest(), four.digest());

    let s = four.summary();
    let [low, high] = ["low", "high"].map(|k| s["redecompositions"][k].as_u64().unwrap());
    let buffer: f64 = BUFFER.split_once('=').unwrap().1.parse().unwrap();
    // With fixed boxes the frame would use up the buffer every 0.7 b / |v| = 0.5 ms.
    let fixed = 20.0 * numbers(&s["momentum"]["start"])[0].abs() / 103.9 / (0.7 * buffer);
    // With boxes that only translate, the motion due to the spin relative to the centre of a
    // worker's quarter counts (half its length is 500 mm at 0.0229 / ms, and of two bodies twice
    // that is relative).
    let spin = 0.005f64.hypot(0.01).hypot(0.02);
    let translated = 20.0 * spin * 500.0 / (0.7 * buffer);
    eprintln!(
        "{low} low, {high} high; fixed boxes would need {fixed:.0}, boxes that only translate \
         {translated:.0}"
    );
    assert!(fixed > 30.0 && translated > 30.0);
    // The frame starts to spin without the matching stretch and vibrates, which occasionally
    // uses up the margin.
    assert!(low == 0 && high <= 2, "{low} low and {high} high in 20 ms");

    for r in [&one, &four] {
        // Central differences conserve linear momentum, and angular momentum of lumped masses,
        // to round-off of the sums; history has ten digits.
        let (p, l) = (drift(r, "momentum"), drift(r, "angular momentum"));
        let error = r.summary()["energy"]["error_max"].as_f64().unwrap();
        eprintln!("momentum {p:.1e}, angular momentum {l:.1e}, energy {error:.1e}");
        assert!(p < 1e-9, "linear momentum drifts by {p:e}");
        assert!(l < 1e-7, "angular momentum drifts by {l:e}");
        assert!(error < 1e-6, "energy drifts by {error:e}");
        let m = &r.summary()["momentum"];
        let (start, end) = (numbers(&m["start"]), numbers(&m["end"]));
        // In full digits: a sum of 7190 terms of 13.4 * m, round-off sqrt(7190) * 1e-16 and more
        // over 6000 steps.
        (0..3).for_each(|c| {
            assert!((end[c] - start[c]).abs() < 1e-10 * start[0].abs(), "{start:?} {end:?}")
        });
    }
}
