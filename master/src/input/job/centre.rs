//! Masses of a body whose centre of mass is given.

use nalgebra::{Matrix3, Vector3};

/// Largest distance of the centre that is reached, over the size of the body.
const REACHED: f64 = 1e-12;
/// Largest logarithm of the ratio of two factors: a centre that needs more is as good as on the
/// surface of the body.
const LARGEST: f64 = 25.0;
/// Largest number of steps of Newton's method.
const STEPS: usize = 200;

/// Spread below which a body is flat or straight, over its size.
const FLAT: f64 = 1e-9;
/// Largest distance of the centre from a flat body that is the rounding of a file, over its size.
const ACROSS: f64 = 1e-6;

/// Masses with factors, and the function that is minimised.
struct TiltedMasses {
    value: f64,
    /// Their centre.
    mean: Vector3<f64>,
    /// Factors up to a scale, masses with them, and the sum of these.
    shares: Vec<f64>,
    weights: Vec<f64>,
    sum: f64,
}

/// Returns factors of masses, all above zero and with the sum of the masses kept, that move the
/// centre of the masses at `points` to `centre`; `None` if it is not inside of them.
///
/// These factors have the largest entropy of all: `f = exp(l . (x - centre))` up to a scale,
/// where l minimises the convex function `log sum m exp(l . (x - centre))`. Its gradient is the
/// distance of the centre.
pub fn factors(masses: &[f64], points: &[[f64; 3]], centre: [f64; 3]) -> Option<Vec<f64>> {
    let away: Vec<Vector3<f64>> =
        points.iter().map(|x| Vector3::from(*x) - Vector3::from(centre)).collect();
    let size = away.iter().map(Vector3::norm).fold(0.0, f64::max);
    if size == 0.0 {
        return Some(vec![1.0; masses.len()]);
    }
    let mut away: Vec<Vector3<f64>> = away.iter().map(|d| d / size).collect();
    // Across a flat or straight body nothing can move; only rounding is off it.
    let middle = away.iter().sum::<Vector3<f64>>() / away.len() as f64;
    let spread = away.iter().fold(Matrix3::zeros(), |sums, d| {
        let off = d - middle;
        sums + off * off.transpose() / away.len() as f64
    });
    let axes = spread.symmetric_eigen();
    for (axis, value) in axes.eigenvectors.column_iter().zip(axes.eigenvalues.iter()) {
        if *value < FLAT * FLAT {
            if away.iter().any(|d| d.dot(&axis).abs() > ACROSS) {
                return None;
            }
            away.iter_mut().for_each(|d| *d -= axis * axis.dot(d));
        }
    }
    let state = |l: &Vector3<f64>| {
        let logs: Vec<f64> = away.iter().map(|d| l.dot(d)).collect();
        let most = logs.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        let shares: Vec<f64> = logs.iter().map(|log| (log - most).exp()).collect();
        let weights: Vec<f64> = masses.iter().zip(&shares).map(|(m, share)| m * share).collect();
        let sum: f64 = weights.iter().sum();
        let mean = away.iter().zip(&weights).map(|(d, w)| d * (w / sum)).sum::<Vector3<f64>>();
        TiltedMasses { value: most + sum.ln(), mean, shares, weights, sum }
    };
    let mut l = Vector3::zeros();
    for _ in 0..STEPS {
        let TiltedMasses { value, mean, shares, weights, sum } = state(&l);
        if mean.norm() <= REACHED {
            let whole: f64 = masses.iter().sum();
            return Some(shares.iter().map(|share| whole / sum * share).collect());
        }
        let spread = |l: &Vector3<f64>| {
            let logs = away.iter().map(|d| l.dot(d));
            logs.clone().fold(f64::NEG_INFINITY, f64::max) - logs.fold(f64::INFINITY, f64::min)
        };
        if spread(&l) > LARGEST {
            return None;
        }
        let covariance = away.iter().zip(&weights).fold(Matrix3::zeros(), |sums, (d, w)| {
            let off = d - mean;
            sums + off * off.transpose() * (w / sum)
        });
        // A flat body has no spread across it.
        let regular = covariance + Matrix3::identity() * (1e-14 * covariance.trace());
        let step = regular.cholesky()?.solve(&mean);
        let slope = mean.dot(&step);
        let mut share = 1.0;
        while share > 1e-9 && state(&(l - step * share)).value > value - 0.25 * share * slope {
            share *= 0.5;
        }
        l -= step * share;
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    fn centre_of(masses: &[f64], points: &[[f64; 3]]) -> ([f64; 3], f64) {
        let whole: f64 = masses.iter().sum();
        let along = |c: usize| masses.iter().zip(points).map(|(m, x)| m * x[c]).sum::<f64>();
        ([0, 1, 2].map(|c| along(c) / whole), whole)
    }

    fn cloud(flat: bool) -> (Vec<f64>, Vec<[f64; 3]>) {
        let points = (0..60).map(|k| {
            let t = f64::from(k);
            [3.0 * (1.7 * t).sin(), (0.9 * t).cos(), if flat { 0.5 } else { (2.3 * t).sin() }]
        });
        ((0..60).map(|k| 1.0 + f64::from(k % 7)).collect(), points.collect())
    }

    /// The masses have the given centre, and their sum is kept, up to the round-off of sums; also
    /// in a plane, from which the centre may be off by the rounding of a file.
    #[test]
    fn the_centre_moves_to_its_place() {
        for (flat, centre) in
            [(false, [1.2, -0.3, 0.2]), (false, [-2.0, 0.2, 0.1]), (true, [1.5, 0.4, 0.5 + 1e-7])]
        {
            let (masses, points) = cloud(flat);
            let factors = factors(&masses, &points, centre).expect("inside");
            assert!(factors.iter().all(|f| *f > 0.0));
            let moved: Vec<f64> = masses.iter().zip(&factors).map(|(m, f)| m * f).collect();
            let ((got, whole), before) =
                (centre_of(&moved, &points), centre_of(&masses, &points).1);
            assert!((whole / before - 1.0).abs() < 1e-12);
            for c in 0..3 {
                let bound = if flat && c == 2 { 2e-7 } else { 1e-10 };
                assert!((got[c] - centre[c]).abs() < bound, "{got:?} for {centre:?}");
            }
        }
        // Where it is already, nothing changes.
        let (masses, points) = cloud(false);
        let same = factors(&masses, &points, centre_of(&masses, &points).0).expect("inside");
        assert!(same.iter().all(|f| (f - 1.0).abs() < 1e-12));
    }

    #[test]
    fn a_centre_outside_is_refused() {
        let (masses, points) = cloud(false);
        assert!(factors(&masses, &points, [5.0, 0.0, 0.0]).is_none());
        let (masses, points) = cloud(true);
        assert!(factors(&masses, &points, [0.0, 0.0, 0.7]).is_none(), "off the plane");
    }
}
