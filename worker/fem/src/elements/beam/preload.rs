//! Preload of beams: a prescribed axial stress until the end of its curve.

use crate::piecewise_linear::PiecewiseLinear;
use crumple_proto::job::BeamInput;

/// Axial stress over time.
pub struct Preload {
    /// Stress [force/length^2] over time [time].
    curve: PiecewiseLinear,
    /// First time with a point, and that at which the preload ends [time].
    times: [f64; 2],
    /// True if fibres keep their differences of stress.
    pub bending: bool,
}

impl Preload {
    /// Returns the preload of a section, if it has one. Its points have no [`Preload::fault`].
    pub fn new(beam: &BeamInput) -> Option<Self> {
        let (first, last) = (beam.preload.first()?, beam.preload.last()?);
        let loaded = beam.preload.iter().position(|p| p[1] != 0.0)?;
        let released = beam.preload[loaded..].iter().find(|p| p[1] == 0.0);
        Some(Self {
            curve: PiecewiseLinear::new(&beam.preload, 0.0),
            times: [first[0], released.unwrap_or(last)[0]],
            bending: beam.preload_bending,
        })
    }

    /// Returns the largest size of a stress, 0 without a preload [force/length^2].
    pub fn largest(beam: &BeamInput) -> f64 {
        beam.preload.iter().fold(0.0, |most: f64, point| most.max(point[1].abs()))
    }

    /// Returns the fault of the points of a section, if any.
    pub fn fault(beam: &BeamInput) -> Option<String> {
        let points = &beam.preload;
        if points.is_empty() {
            return beam.preload_bending.then(|| "preload_bending without a preload".into());
        }
        let [least, most] = [f64::min, f64::max].map(|f| points.iter().map(|p| p[1]).fold(0.0, f));
        if points.len() < 2 {
            return Some("its preload has fewer than two points".into());
        }
        if least < 0.0 && most > 0.0 {
            return Some(format!("its preload goes from {least} to {most}"));
        }
        if least == 0.0 && most == 0.0 {
            return Some("its preload is 0 at all times".into());
        }
        if points[0][0] < 0.0 {
            return Some(format!("its preload begins at {}", points[0][0]));
        }
        PiecewiseLinear::fault(points).map(|fault| format!("its preload: {fault}"))
    }

    /// Adds a step to the time of an element. Returns the stress at its end, or that at the end of
    /// the preload if this is within the step; `None` if the preload has ended before.
    pub fn stress(&self, time: &mut f64, dt: f64) -> Option<f64> {
        let [first, end] = self.times;
        let before = *time;
        *time += dt;
        (before < end).then(|| self.curve.value(time.clamp(first, end)))
    }
}
