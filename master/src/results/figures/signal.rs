//! Numbers from curves: filters of crash tests, integrals, crush figures, head injury criteria. The
//! report computes the same in `signal.js`. A curve is two slices of equal length, `x` and `y`,
//! without gaps; `x` of curves over time ascends.

/// Mirrored points at each end of a filtered signal, in periods of the class. Over four, a
/// transient falls to 1e-15.
const RUN_IN: f64 = 4.0;
/// Rows per period of a filter class that SAE J211-1 asks for.
const ROWS_PER_PERIOD: f64 = 10.0;
/// Ratio of the corner of a pass to its class.
const CORNER: f64 = 2.0775;

/// Figures of a crush.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crush {
    /// Largest magnitude of the force up to the stroke [force].
    pub peak: f64,
    /// Displacement at the peak [length].
    pub at: f64,
    /// Largest displacement from the start [length].
    pub stroke: f64,
    /// Integral of the force over the displacement up to the stroke [force length].
    pub energy: f64,
    /// Energy over stroke [force].
    pub mean: f64,
}

/// Head injury criterion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Injury {
    /// Value [g^2.5 s].
    pub value: f64,
    /// Begin and end of its interval [s].
    pub interval: [f64; 2],
}

/// Returns the values of a curve at ascending places, linear between its points.
fn values_at(x: &[f64], y: &[f64], places: &[f64]) -> Vec<f64> {
    let mut i = 0;
    let value = |&place: &f64| {
        while i + 2 < x.len() && x[i + 1] < place {
            i += 1;
        }
        if x.len() < 2 {
            return y[0];
        }
        let span = x[i + 1] - x[i];
        let share = if span > 0.0 { (place - x[i]) / span } else { 0.0 };
        y[i] + share * (y[i + 1] - y[i])
    };
    places.iter().map(value).collect()
}

/// A curve at equal intervals.
struct EvenCurve {
    places: Vec<f64>,
    step: f64,
    values: Vec<f64>,
}

/// Returns the curve at as many equal intervals as it has. Rows of a history are a step apart from
/// where they were due.
fn evenly(x: &[f64], y: &[f64]) -> EvenCurve {
    let step = (x[x.len() - 1] - x[0]) / (x.len() - 1) as f64;
    let places: Vec<f64> = (0..x.len()).map(|i| x[0] + i as f64 * step).collect();
    let values = values_at(x, y, &places);
    EvenCurve { places, step, values }
}

/// Returns one pass of a filter class over values at intervals of `step` [s]: Butterworth with two
/// poles (SAE J211-1, annex C), from a state of rest at the first one.
fn passed(class: f64, step: f64, values: &[f64]) -> Vec<f64> {
    let w = (std::f64::consts::PI * class * CORNER * step).tan();
    let whole = 1.0 + std::f64::consts::SQRT_2 * w + w * w;
    let a = w * w / whole;
    let b = [-2.0 * (w * w - 1.0) / whole, (-1.0 + std::f64::consts::SQRT_2 * w - w * w) / whole];
    let (mut x, mut y) = ([values[0]; 2], [values[0]; 2]);
    let pass = |&value: &f64| {
        let out = a * (value + 2.0 * x[0] + x[1]) + b[0] * y[0] + b[1] * y[1];
        (x, y) = ([value, x[0]], [out, y[0]]);
        out
    };
    values.iter().map(pass).collect()
}

/// Returns the reason why rows at intervals of `step` [s] do not suffice for a filter class [Hz],
/// if they do not.
pub fn too_coarse(step: f64, class: f64) -> Option<String> {
    let rate = 1.0 / step;
    (rate.is_nan() || rate <= 2.0 * CORNER * class).then(|| {
        format!(
            "CFC {class} needs rows at most {:.3e} s apart, but they are {step:.3e} s apart: \
             reduce output.history_interval",
            1.0 / (ROWS_PER_PERIOD * class)
        )
    })
}

/// Returns the curve after the filter of a class [Hz]: forward and backward, so that the phase is
/// zero. `x` is in seconds. The ends are continued by their point reflection.
///
/// # Errors
/// The rows are too far apart for the class.
pub fn filtered(x: &[f64], y: &[f64], class: f64) -> Result<Vec<f64>, String> {
    if x.len() < 3 {
        return Ok(y.to_vec());
    }
    let EvenCurve { places, step, values } = evenly(x, y);
    if let Some(why) = too_coarse(step, class) {
        return Err(why);
    }
    let rate = 1.0 / step;
    let last = values.len() - 1;
    let more = last.min((RUN_IN * rate / class).ceil() as usize);
    let before = (1..=more).rev().map(|i| 2.0 * values[0] - values[i]);
    let after = (1..=more).map(|i| 2.0 * values[last] - values[last - i]);
    let long: Vec<f64> = before.chain(values.iter().copied()).chain(after).collect();
    let mut there = passed(class, step, &long);
    there.reverse();
    let mut back = passed(class, step, &there);
    back.reverse();
    Ok(values_at(&places, &back[more..=more + last], x))
}

/// Returns the integral from the start to each point, by trapezoids.
pub fn integral(x: &[f64], y: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let steps = (1..y.len()).map(|i| {
        sum += 0.5 * (y[i] + y[i - 1]) * (x[i] - x[i - 1]);
        sum
    });
    std::iter::once(0.0).take(y.len()).chain(steps).collect()
}

/// Returns the place of the largest magnitude, the first of equal ones.
fn peak_of(y: impl Iterator<Item = f64>) -> usize {
    let larger = |best: (usize, f64), (i, v): (usize, f64)| {
        if v.abs() > best.1 { (i, v.abs()) } else { best }
    };
    y.enumerate().fold((0, 0.0), larger).0
}

/// Returns the figures of a force over a displacement, from the start to the largest displacement;
/// none for an empty curve.
pub fn crush(displacement: &[f64], force: &[f64]) -> Option<Crush> {
    let start = *displacement.first()?;
    let moved = |i: usize| (displacement[i] - start).abs();
    let end = peak_of(displacement.iter().map(|u| u - start));
    let peak = peak_of(force[..=end].iter().copied());
    let (stroke, energy) = (moved(end), integral(displacement, force)[end].abs());
    let mean = if stroke > 0.0 { energy / stroke } else { f64::NAN };
    Some(Crush { peak: force[peak].abs(), at: moved(peak), stroke, energy, mean })
}

/// Returns the head injury criterion of an acceleration [g] over time [s]: the largest value of
/// duration times mean^2.5, over all intervals of at most `longest` [s] (FMVSS 208); none for a
/// curve without duration.
pub fn head_injury(time: &[f64], acceleration: &[f64], longest: f64) -> Option<Injury> {
    if time.len() < 2 {
        return None;
    }
    let EvenCurve { places, step, values } = evenly(time, acceleration);
    let sums = integral(&places, &values);
    let most = ((longest / step + 1e-9).floor() as usize).min(values.len() - 1);
    // (integral / duration^0.6)^2.5 is the criterion: one power per duration, not per interval.
    let mut best = (0.0, 0, 0);
    for long in 1..=most {
        let share = 1.0 / (long as f64 * step).powf(0.6);
        for i in 0..sums.len() - long {
            let value = (sums[i + long] - sums[i]) * share;
            if value > best.0 {
                best = (value, i, i + long);
            }
        }
    }
    Some(Injury { value: best.0.powf(2.5), interval: [places[best.1], places[best.2]] })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn times(count: usize, step: f64) -> Vec<f64> {
        (0..count).map(|i| i as f64 * step).collect()
    }

    /// A constant acceleration has HIC = T a^2.5 for the longest window T; a half sine of amplitude
    /// A and duration T has 0.4146 T A^2.5.
    #[test]
    fn injury_has_its_closed_forms() {
        let t = times(20001, 1e-5);
        let constant = head_injury(&t, &vec![60.0; t.len()], 0.015).unwrap().value;
        assert!((constant / (0.015 * 60f64.powf(2.5)) - 1.0).abs() < 1e-9, "{constant}");
        let sine = |&t: &f64| match t < 0.03 {
            true => 80.0 * (std::f64::consts::PI * t / 0.03).sin(),
            false => 0.0,
        };
        let found = head_injury(&t, &t.iter().map(sine).collect::<Vec<_>>(), 0.036).unwrap();
        let mut x = 1.0f64;
        (0..100).for_each(|_| x = (5.0 / 3.0 * x).atan());
        let share = 2.0 / std::f64::consts::PI * x.sin().powf(2.5) / x.powf(1.5);
        let exact = share * 0.03 * 80f64.powf(2.5);
        assert!((found.value / exact - 1.0).abs() < 1e-4, "{}: 3000 rows per pulse", found.value);
        let middle = 0.5 * (found.interval[0] + found.interval[1]);
        assert!((middle - 0.015).abs() < 2e-5, "{found:?}");
        assert_eq!(head_injury(&[0.0], &[1.0], 0.015), None);
    }

    /// Down to -30 with the force 2 u, then back to -20 with a larger one, which does not count:
    /// the work is F u / 2.
    #[test]
    fn a_crush_ends_at_its_stroke() {
        let u: Vec<f64> = (0..401)
            .map(|i| if i <= 300 { -0.1 * f64::from(i) } else { -30.0 + 0.1 * f64::from(i - 300) })
            .collect();
        let f: Vec<f64> =
            u.iter().enumerate().map(|(i, u)| if i <= 300 { 2.0 * u } else { 100.0 }).collect();
        let c = crush(&u, &f).unwrap();
        for (value, exact) in
            [(c.peak, 60.0), (c.at, 30.0), (c.stroke, 30.0), (c.energy, 900.0), (c.mean, 30.0)]
        {
            assert!((value / exact - 1.0).abs() < 1e-9, "{value} for {exact}");
        }
        assert_eq!(crush(&[], &[]), None);
    }

    /// A filter class has the gain -3 dB and no phase at 5/3 of the class, and leaves straight
    /// lines unchanged.
    #[test]
    fn filters_have_their_corner() {
        let class = 180.0;
        let step = 1.0 / (1000.0 * class);
        let t = times(8000, step);
        let wave: Vec<f64> =
            t.iter().map(|t| (std::f64::consts::TAU * class * 5.0 / 3.0 * t).sin()).collect();
        let out = filtered(&t, &wave, class).unwrap();
        let gain = out[2000..6000].iter().fold(0.0f64, |most, v| most.max(v.abs()));
        assert!((20.0 * gain.log10() - 20.0 * 0.5f64.sqrt().log10()).abs() < 0.02, "{gain}");
        // The largest of 600 rows per period is 1e-5 below the amplitude.
        let shifted = |i: usize| (out[i] - gain * wave[i]).abs() > 1e-3;
        assert!(!(2000..6000).any(shifted), "the phase is not zero");
        let line: Vec<f64> = t.iter().map(|t| 3.0 + 40.0 * t).collect();
        let out = filtered(&t, &line, class).unwrap();
        assert!(out.iter().zip(&line).all(|(a, b)| (a - b).abs() < 1e-9));
        let why = filtered(&times(100, 1e-2), &[0.0; 100], class).unwrap_err();
        assert!(why.contains("output.history_interval"), "{why}");
    }
}
