//! Tension of belts and retractors: a curve for loading, and one for unloading that is shifted so
//! that both meet at the largest strain or pull-out so far.

use crate::piecewise_linear::PiecewiseLinear;

/// Tension over a strain or a pull-out, the `way`.
#[derive(Debug)]
pub struct TensionCurve {
    loading: PiecewiseLinear,
    unloading: Option<PiecewiseLinear>,
    /// Largest way up to which unloading is as loading.
    elastic: f64,
}

impl TensionCurve {
    /// Builds the curve from its points; without points for unloading it is elastic, with them up
    /// to the way `elastic`.
    pub fn new(loading: &[[f64; 2]], unloading: &[[f64; 2]], elastic: f64) -> Self {
        let line = |points: &[[f64; 2]]| PiecewiseLinear::new(points, 0.0);
        Self {
            loading: line(loading),
            unloading: Some(unloading).filter(|points| !points.is_empty()).map(line),
            elastic,
        }
    }

    /// Returns the tension at a way, with the largest way so far [force].
    pub fn at(&self, way: f64, largest: f64) -> f64 {
        let force = match &self.unloading {
            Some(unloading) if way < largest && largest > self.elastic => {
                let met = unloading.first_at(self.loading.value(largest));
                unloading.value(way - largest + met)
            }
            _ => self.loading.value(way.max(self.loading.points()[0][0])),
        };
        force.max(0.0)
    }

    /// Returns the way at which loading first has a tension: the first point for any tension up to
    /// its own, the last one for a tension that loading never has.
    pub fn way_at(&self, tension: f64) -> f64 {
        let [start, first] = self.loading.points()[0];
        if tension <= first { start } else { self.loading.first_at(tension).max(start) }
    }

    /// Returns the tension at the first point [force].
    pub fn first(&self) -> f64 {
        self.loading.points()[0][1]
    }

    /// Returns the largest slope of both curves.
    pub fn steepest(&self) -> f64 {
        let of_unloading = self.unloading.as_ref().map_or(0.0, PiecewiseLinear::steepest);
        self.loading.steepest().max(of_unloading)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn unloading_begins_where_loading_has_ended() {
        let (loading, unloading) =
            ([[0.0, 0.0], [0.1, 1.0], [0.2, 1.5]], [[0.0, 0.0], [0.05, 2.0]]);
        let curve = TensionCurve::new(&loading, &unloading, 0.1);
        let close = |a: f64, b: f64| assert!((a - b).abs() < 1e-12, "{a} {b}");
        close(curve.at(0.05, 0.05), 0.5);
        close(curve.at(0.05, 0.1), 0.5);
        close(curve.at(0.2, 0.2), 1.5);
        close(curve.at(0.2 - 0.0125, 0.2), 1.0);
        close(curve.at(0.1, 0.2), 0.0);
        close(curve.at(-0.1, 0.0), 0.0);
        close(curve.way_at(1.25), 0.15);
        close(curve.steepest(), 40.0);
        let elastic = TensionCurve::new(&[[0.0, 0.3], [1.0, 0.3]], &[], 0.0);
        assert_eq!([-1.0, 0.0, 2.0].map(|way| elastic.at(way, 2.0)), [0.3; 3]);
        // A tension that loading never has is beyond its last point.
        assert_eq!([0.2, 0.3, 0.7].map(|tension| elastic.way_at(tension)), [0.0, 0.0, 1.0]);
    }
}
