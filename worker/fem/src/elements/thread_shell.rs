//! Four-node shells one element at a time: the entry point for devices on which each thread
//! computes one element. It calls the function of the groups, so both give the same bits.

use super::GroupCorners;
use super::belytschko_tsay::{BelytschkoTsay, PARAMETERS, kernel};
use super::quad::Quad;
use super::shell::Formulation;
use crate::materials::{PlaneStress, PointLanes};
use crate::nodes::NodeView;
use crate::parameter::Values;
use crumple_proto::job::Part;
use crumple_proto::mesh::OwnSection;
use crumple_proto::problem::Problem;

/// Belytschko-Tsay shells of one part.
pub struct ThreadShell(Quad<BelytschkoTsay>);

/// Result of one element.
pub struct ThreadResult {
    /// Forces on the nodes of the corners: x, y, z, padding [force].
    pub force: [[f64; 4]; 4],
    /// Moments on them [force length].
    pub moment: [[f64; 4]; 4],
    /// Stable step [time].
    pub stable_dt: f64,
    /// Increases of internal energy, and of hourglass and drilling energy [energy].
    pub energies: [f64; 2],
    /// True if the element is finite, is not inverted, and its strain increments are within the
    /// limit.
    pub sound: bool,
}

impl ThreadShell {
    /// Creates the shells of a part with a law.
    ///
    /// # Errors
    /// All problems of the part.
    pub fn new(part: &Part, law: Box<dyn PlaneStress>) -> Result<Self, Vec<Problem>> {
        let values = Values::new(PARAMETERS, &part.parameters);
        kernel(part, &values, law).map(|kernel| Self(Quad(kernel)))
    }

    /// Returns the number of history columns of an element.
    pub fn columns(&self) -> usize {
        self.0.section().columns() + <Quad<BelytschkoTsay> as Formulation>::OWN.len()
    }

    /// Returns the history of an element at the coordinates `x` at the start [length].
    pub fn history(&self, x: &[[f64; 3]; 4]) -> Vec<f64> {
        let mut history = vec![0.0; self.columns()];
        let own = OwnSection::default();
        let [area, floor] = self.0.size(x);
        self.0.section().start(&mut history, own);
        self.0.section().measure(&mut history, own, area, floor);
        history
    }

    /// Returns the mass [mass] and the rotational inertia [mass length^2] of a corner at the
    /// coordinates `x` at the start [length].
    pub fn corner_mass(&self, x: &[[f64; 3]; 4]) -> (f64, f64) {
        self.0.corner_mass(x, OwnSection::default())
    }

    /// Updates `history` over the step `dt` [time] and returns the forces. N is the number of
    /// points, COLUMNS that of the history columns of a point. Returns `None` if the part has
    /// others, or an option that needs more columns: the compiler then knows the place of each
    /// column, and can keep all of them in registers.
    #[inline(always)]
    pub fn compute<L: PointLanes<1>, const N: usize, const COLUMNS: usize>(
        &self,
        corners: [u32; 4],
        nodes: &NodeView<'_>,
        history: &mut [L],
        dt: f64,
    ) -> Option<ThreadResult> {
        if !self.0.section().is_plain::<N, COLUMNS>() {
            return None;
        }
        let mut corner_rows: [GroupCorners<4, 1>; 2] = [[[[0.0; 4]; 4]; 1]; 2];
        let [force, moment] = &mut corner_rows;
        let group = corners.map(|corner| [corner]);
        let totals = self.0.group::<L, 1, N>(&group, nodes, history, dt, [force, moment]);
        let [[force], [moment]] = corner_rows;
        Some(ThreadResult {
            force,
            moment,
            stable_dt: totals.stable_dt.lane(0),
            energies: [totals.internal.lane(0), totals.hourglass.lane(0)],
            sound: L::select(totals.sound, L::splat(1.0), L::zero()).lane(0) > 0.5,
        })
    }
}

#[cfg(test)]
#[path = "thread_shell_tests.rs"]
mod tests;
