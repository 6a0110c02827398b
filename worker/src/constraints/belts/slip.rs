//! How much belt moves through a ring or out of a retractor in a step, at fixed positions of the
//! nodes.
//!
//! A ring holds tensions with a ratio of up to `exp(mu theta)`, with the friction mu and the angle
//! theta by which the belt turns (Euler 1762; for belts over a pulley, Eytelwein 1808). Beyond that
//! belt moves towards the larger tension until the ratio is this one. A retractor lets belt out or
//! takes it in until its tension and that of the belt are equal. As belt moves into a segment its
//! tension falls, so each equation has one solution, which bisection finds.

use super::curve::TensionCurve;

/// Number of bisections: the solution is exact to about the precision of numbers.
const BISECTIONS: usize = 60;

/// A segment next to a ring or a retractor.
#[derive(Clone, Copy, Debug)]
pub struct BeltSpan<'a> {
    /// Tension over the strain.
    pub curve: &'a TensionCurve,
    /// Distance of its nodes [length].
    pub distance: f64,
    /// Unstretched length [length].
    pub length: f64,
    /// Largest strain so far.
    pub largest: f64,
}

impl BeltSpan<'_> {
    /// Returns the tension with more unstretched length [force].
    pub fn pull(&self, more: f64) -> f64 {
        let strain = self.distance / (self.length + more) - 1.0;
        if strain > 0.0 { self.curve.at(strain, self.largest) } else { 0.0 }
    }
}

/// Returns the length that moves through a ring into the `tight` segment from the other one, so
/// that its tension is at most `ratio` times that of the other; at most so much that the other one
/// keeps the length `least` [length].
pub fn through_ring(tight: &BeltSpan<'_>, loose: &BeltSpan<'_>, ratio: f64, least: f64) -> f64 {
    let beyond = |moved: f64| tight.pull(moved) - ratio * loose.pull(-moved);
    if beyond(0.0) <= 0.0 {
        return 0.0;
    }
    let most = (loose.length - least).max(0.0);
    if beyond(most) >= 0.0 { most } else { zero(beyond, 0.0, most) }
}

/// Returns the length that comes out of a retractor, negative if it goes in, so that the tension of
/// the belt is that of the retractor; at most so much goes in that the segment keeps the length
/// `least` [length]. `tension` is that of the retractor, with more pulled out.
pub fn out_of_retractor(span: &BeltSpan<'_>, tension: impl Fn(f64) -> f64, least: f64) -> f64 {
    let beyond = |moved: f64| span.pull(moved) - tension(moved);
    let now = beyond(0.0);
    if now > 0.0 {
        // Without strain there is no tension.
        return zero(beyond, 0.0, (span.distance - span.length).max(0.0));
    }
    let most = -(span.length - least).max(0.0);
    match now < 0.0 {
        true if beyond(most) <= 0.0 => most,
        true => zero(beyond, most, 0.0),
        false => 0.0,
    }
}

/// Returns the length that a pretensioner pulls in, of a length that it wants to, so that the
/// tension is at most `limit` [length].
pub fn pulled_in(span: &BeltSpan<'_>, wanted: f64, limit: f64, least: f64) -> f64 {
    let most = wanted.min((span.length - least).max(0.0));
    if span.pull(0.0) >= limit {
        0.0
    } else if span.pull(-most) <= limit {
        most
    } else {
        zero(|moved| limit - span.pull(-moved), 0.0, most)
    }
}

/// Returns where a function that falls from above 0 to 0 or below has its zero, on its side below.
fn zero(falls: impl Fn(f64) -> f64, mut above: f64, mut below: f64) -> f64 {
    for _ in 0..BISECTIONS {
        let middle = 0.5 * (above + below);
        if falls(middle) > 0.0 {
            above = middle;
        } else {
            below = middle;
        }
    }
    below
}

#[cfg(test)]
mod tests {
    use super::*;

    fn linear() -> TensionCurve {
        TensionCurve::new(&[[0.0, 0.0], [1.0, 100.0]], &[], 0.0)
    }

    fn span(curve: &TensionCurve, distance: f64, length: f64) -> BeltSpan<'_> {
        BeltSpan { curve, distance, length, largest: 0.0 }
    }

    #[test]
    fn a_ring_leaves_the_ratio_of_its_friction() {
        let curve = linear();
        let (tight, loose) = (span(&curve, 1.2, 1.0), span(&curve, 1.05, 1.0));
        for ratio in [1.0, 1.5, 3.0] {
            let moved = through_ring(&tight, &loose, ratio, 0.1);
            let (a, b) = (tight.pull(moved), loose.pull(-moved));
            assert!((a / b - ratio).abs() < 1e-9 && moved > 0.0, "{ratio}: {a} {b}");
        }
        assert_eq!(through_ring(&tight, &loose, 4.1, 0.1), 0.0);
        assert_eq!(through_ring(&tight, &span(&curve, 0.5, 1.0), 1.0, 0.95), 1.0 - 0.95);
    }

    #[test]
    fn a_retractor_takes_belt_until_both_tensions_are_equal() {
        let curve = linear();
        let stretched = span(&curve, 1.2, 1.0);
        let out = out_of_retractor(&stretched, |_| 5.0, 0.1);
        assert!((stretched.pull(out) - 5.0).abs() < 1e-9 && out > 0.0);
        let slack = span(&curve, 1.0, 1.3);
        let taken = out_of_retractor(&slack, |out| 5.0 + 50.0 * (out + 0.3), 0.1);
        assert!((slack.pull(taken) - (5.0 + 50.0 * (taken + 0.3))).abs() < 1e-9);
        assert_eq!(out_of_retractor(&slack, |_| 0.0, 0.1), 0.0);
        assert_eq!(out_of_retractor(&slack, |_| 5.0, 1.2), 1.2 - 1.3);
    }

    #[test]
    fn a_pretensioner_stops_at_its_limit() {
        let curve = linear();
        let slack = span(&curve, 1.0, 1.0);
        assert_eq!(pulled_in(&slack, 0.1, f64::INFINITY, 0.1), 0.1);
        let moved = pulled_in(&slack, 0.1, 2.0, 0.1);
        assert!((slack.pull(-moved) - 2.0).abs() < 1e-9);
        assert_eq!(pulled_in(&span(&curve, 1.1, 1.0), 0.1, 2.0, 0.1), 0.0);
    }
}
