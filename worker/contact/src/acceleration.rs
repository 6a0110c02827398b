//! Anderson acceleration of sweeps that converge slowly (Anderson 1965; Walker & Ni 2011, eq.
//! 2.1).
//!
//! A sweep maps the forces x to G(x). If masses differ much it converges slowly: for a light
//! layer of mass m between heavy layers of mass M, a Gauss-Seidel sweep leaves `1 / (1 + m/M)^2`
//! of an error. The residuals f = G(x) - x of the last sweeps predict the next sweeps. With the
//! coefficients that minimise `|f_k - sum_j c_j (f_{j+1} - f_j)|` the next forces are `G(x_k) -
//! sum_j c_j (G(x_{j+1}) - G(x_j))`. These are then projected onto their friction cones. For
//! pairs that stay in contact, where G is linear, the method is GMRES (Walker & Ni, theorem
//! 2.2): the number of its steps is the number of different rates of convergence, for any values
//! of these rates.
//!
//! The norm is that of the energy of a force in the pair's own compliance, `c |f|^2`. Its sums
//! are exact, so they are equal for any number of workers (`proto/src/exact_sum.rs`). If pairs
//! close or open, or if a residual grows, the function G has changed: the history is dropped, and
//! the next forces are those of the sweep itself.

use crate::enforce::within_cone;
use crate::pairs::Pair;
use crate::pairs::Peers;
use crumple_math::row::V3;
use crumple_proto::exact_sum::{ExactSum, WORDS};
use crumple_proto::transport::RankLost;
use nalgebra::{DMatrix, DVector};
use std::collections::VecDeque;

/// Largest number of earlier sweeps that are combined with one sweep. For five light layers,
/// mass ratio 1 to 10,000, with split masses and no momentum: 69 sweeps with 2, 27 with 5 and 8
/// (`accelerated_sweeps_settle_whatever_the_masses`).
const DEPTH: usize = 5;
/// Smallest squared sine of a direction to the other directions. Below it the direction is
/// dropped, because the round-off of the sums, 1e-16, would affect the result.
const PARALLEL: f64 = 1e-12;

/// Largest squared norm of the force changes of pairs that have closed or opened, as a fraction
/// of the squared norm of the residual. Above it the earlier sweeps belong to another system.
const SWITCHED: f64 = 0.01;

/// Forces of own pairs, one after the other [force].
pub type Forces = Vec<V3>;

/// History of the sweeps of a step.
#[derive(Debug, Default)]
pub struct Acceleration {
    /// Residual and final forces of the last sweep, with the squared norm of the residual.
    last: Option<(Forces, Forces, f64)>,
    /// Differences of residuals and of final forces between consecutive sweeps, the newest last.
    differences: VecDeque<(Forces, Forces)>,
    /// Products of the differences of residuals with each other, in the order of `differences`.
    products: DMatrix<f64>,
}

/// Result of a sweep that all workers know.
#[derive(Debug)]
pub struct AccelerationStep {
    /// True if a force has changed, on any worker.
    pub changed: bool,
    /// Squared norm of the residual of all pairs before the sweep [force length/time].
    pub residual: f64,
    /// Extrapolated forces for the next sweep; `None` if the forces of the sweep itself are
    /// used.
    pub forces: Option<Forces>,
}

/// Returns the largest number of words of the sum over all workers in an accelerated sweep.
pub fn words_of_sum() -> usize {
    (2 * DEPTH + 2) * WORDS + 1
}

impl Acceleration {
    /// Adds a sweep to the history. `pairs` includes the own pairs with their final forces,
    /// `before` holds their forces before the sweep, and `changed` is true if the sweep has
    /// changed one of them. All workers must call it after each sweep.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn update(
        &mut self,
        pairs: &[Pair],
        before: &[V3],
        changed: bool,
        peers: &mut impl Peers,
    ) -> Result<AccelerationStep, RankLost> {
        let own: Vec<&Pair> = pairs.iter().filter(|p| p.is_owned).collect();
        let ends: Forces = own.iter().map(|p| p.force).collect();
        let residual = minus(&ends, before);
        let mut switched = ExactSum::ZERO;
        if let Some((residuals_before, ends_before, _)) = &self.last {
            let both = own.iter().zip(&ends).zip(ends_before);
            let switch = both.filter(|((p, end), before)| {
                !p.is_replica && is_pressed(p, end) != is_pressed(p, before)
            });
            switch.for_each(|((p, end), before)| {
                switched.add(weighted(p, &(end - before), &(end - before)))
            });
            self.differences
                .push_back((minus(&residual, residuals_before), minus(&ends, ends_before)));
            if self.differences.len() > DEPTH {
                self.differences.pop_front();
                self.products = self.products.clone().remove_row(0).remove_column(0);
            }
        }
        let n = self.differences.len();
        // Products of the newest difference with all differences, and of the residual with all
        // differences and with itself.
        let newest = self.differences.back();
        let of_newest = self.differences.iter().map(|d| newest.map(|(r, _)| (r, &d.0)));
        let of_residual = self.differences.iter().map(|d| Some((&residual, &d.0)));
        let all = of_newest.chain(of_residual).flatten().chain([(&residual, &residual)]);
        let mut words: Vec<i64> = all.flat_map(|(a, b)| *product(&own, a, b).words()).collect();
        words.extend(switched.words());
        words.push(changed.into());
        peers.sum(&mut words)?;
        let changed = words[words.len() - 1] > 0;
        let sums: Vec<f64> = words.chunks_exact(WORDS).map(ExactSum::value_of).collect();
        let size = sums[2 * n];
        if n > 0 {
            if self.products.nrows() < n {
                self.products = std::mem::take(&mut self.products).resize(n, n, 0.0);
            }
            for (i, &sum) in sums[..n].iter().enumerate() {
                self.products[(i, n - 1)] = sum;
                self.products[(n - 1, i)] = sum;
            }
        }
        let is_other = self.last.as_ref().is_some_and(|(_, _, before)| size > *before)
            || sums[2 * n + 1] > SWITCHED * size;
        self.last = Some((residual, ends.clone(), size));
        if is_other || !size.is_finite() {
            self.differences.clear();
            self.products = DMatrix::zeros(0, 0);
            return Ok(AccelerationStep { changed, residual: size, forces: None });
        }
        if !changed || n == 0 {
            return Ok(AccelerationStep { changed, residual: size, forces: None });
        }
        let mut way = vec![V3::zeros(); ends.len()];
        for ((_, difference), c) in
            self.differences.iter().zip(least_squares(&self.products, &sums[n..2 * n]))
        {
            way.iter_mut().zip(difference).for_each(|(w, d)| *w -= d * c);
        }
        let part = usable_fraction(&own, &ends, &way, peers)?;
        let forces_of =
            |((p, end), way): ((&&Pair, &V3), &V3)| within_friction_cone(p, end + way * part);
        let forces = own.iter().zip(&ends).zip(&way).map(forces_of).collect();
        Ok(AccelerationStep { changed, residual: size, forces: Some(forces) })
    }
}

/// Returns the fraction of the way `way` from the forces `ends` that is used: up to the point
/// where the first closed pair would get a tensile force, but at least one half. Forces that are
/// tensile beyond this point are set to 0, so the forces on the other side of these pairs are
/// not balanced.
///
/// # Errors
/// A worker is gone.
fn usable_fraction(
    own: &[&Pair],
    ends: &[V3],
    way: &[V3],
    peers: &mut impl Peers,
) -> Result<f64, RankLost> {
    let part = |((p, end), way): ((&&Pair, &V3), &V3)| {
        let (pressed, more) = (end.dot(&p.normal), way.dot(&p.normal));
        if pressed > 0.0 && pressed + more < 0.0 { pressed / -more } else { 1.0 }
    };
    let least = own.iter().zip(ends).zip(way).map(part).fold(1.0, f64::min);
    Ok((-peers.max(-least)?).max(0.5))
}

/// Returns the force of a pair projected onto its friction cone, zero if it is tensile.
pub fn within_friction_cone(pair: &Pair, force: V3) -> V3 {
    let pressed = force.dot(&pair.normal).max(0.0);
    let sheared = force - pair.normal * force.dot(&pair.normal);
    pair.normal * pressed + within_cone(sheared, pressed, pair)
}

/// Returns true if the own pair has a compressive force.
fn is_pressed(pair: &Pair, force: &V3) -> bool {
    force.dot(&pair.normal) > 0.0
}

fn minus(a: &[V3], b: &[V3]) -> Forces {
    a.iter().zip(b).map(|(a, b)| a - b).collect()
}

/// Returns the product of two sets of forces, weighted by the compliance of each pair.
fn product(own: &[&Pair], a: &[V3], b: &[V3]) -> ExactSum {
    let mut sum = ExactSum::ZERO;
    // The owner of a replicated pair counts it.
    for ((p, a), b) in own.iter().zip(a).zip(b).filter(|((p, _), _)| !p.is_replica) {
        sum.add(weighted(p, a, b));
    }
    sum
}

/// Returns the product of two forces of a pair, weighted by its normal and tangential
/// compliance.
fn weighted(pair: &Pair, a: &V3, b: &V3) -> f64 {
    let along = a.dot(&pair.normal) * b.dot(&pair.normal);
    pair.compliance[0] * along + pair.compliance[1] * (a.dot(b) - along)
}

/// Returns coefficients c that minimise `c' P c - 2 c' b`, for directions with the products `P`.
/// Newer directions are included before older ones. A direction that is nearly a combination of
/// those included gets 0.
fn least_squares(products: &DMatrix<f64>, b: &[f64]) -> Vec<f64> {
    let n = b.len();
    let scale: Vec<f64> = (0..n).map(|i| products[(i, i)].sqrt()).collect();
    let mut kept: Vec<usize> = Vec::new();
    let mut solution = DVector::zeros(0);
    for i in (0..n).rev().filter(|&i| scale[i] > 0.0) {
        kept.push(i);
        let size = kept.len();
        let scaled = DMatrix::from_fn(size, size, |r, c| {
            products[(kept[r], kept[c])] / (scale[kept[r]] * scale[kept[c]])
        });
        let right = DVector::from_fn(size, |r, _| b[kept[r]] / scale[kept[r]]);
        match scaled.cholesky().filter(|c| c.l_dirty()[(size - 1, size - 1)].powi(2) > PARALLEL) {
            Some(factors) => solution = factors.solve(&right),
            None => {
                kept.pop();
            }
        }
    }
    let mut coefficients = vec![0.0; n];
    kept.iter().zip(solution.iter()).for_each(|(&i, c)| coefficients[i] = c / scale[i]);
    coefficients
}
