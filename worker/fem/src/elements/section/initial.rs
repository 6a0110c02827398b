//! Stress and plastic strain of a shell at the start, at the points of its section.

use super::{POINT_AT_CORNER, POINTS, SHEAR, Section};
use crate::elements::initial::{StateAtStart, TakenAtStart, by_number};
use crumple_proto::initial::InitialPoint;

impl Section {
    /// Returns what the law takes of a state at the start.
    pub fn taken_at_start(&self) -> TakenAtStart {
        let stress = self.law.adds_stress();
        TakenAtStart { stress, plastic_strain: stress && self.plastic_strain.is_some() }
    }

    /// Sets stress and plastic strain in the history of a new element with the axes e1, e2 and
    /// normal `axes`. With four points in the plane, four given ones are those next to the corners,
    /// in their order; otherwise each gets the mean of the given ones. The transverse shear stress
    /// is the mean over the thickness; a stress normal to the shell does not count.
    pub fn set_initial(&self, history: &mut [f64], points: &[InitialPoint], axes: &[[f64; 3]; 3]) {
        let TakenAtStart { stress, plastic_strain } = self.taken_at_start();
        if !stress {
            return;
        }
        let given = by_number(points);
        for plane in 0..self.planar {
            let corner = POINT_AT_CORNER.iter().position(|&point| point == plane);
            let own = match corner {
                Some(corner) if self.planar == 4 && given.len() == 4 => &given[corner..][..1],
                _ => &given[..],
            };
            let columns = &mut history[plane * self.each()..][..self.each()];
            let mut shear = [0.0; 2];
            for k in 0..self.points {
                let at = |points: &&[InitialPoint]| StateAtStart::at(points, self.zeta[k]);
                let state = StateAtStart::mean(own.iter().map(at));
                let [xx, yy, xy, xz, yz] = state.in_axes(axes);
                // The weights sum to two.
                let share = 0.5 * self.weight[k];
                shear = [share.mul_add(xz, shear[0]), share.mul_add(yz, shear[1])];
                let point = &mut columns[POINTS + k * self.stride..][..self.stride];
                point[..3].copy_from_slice(&[xx, yy, xy]);
                if let Some(column) = self.plastic_strain.filter(|_| plastic_strain) {
                    point[column] = state.plastic_strain;
                }
            }
            if self.shear != 0.0 {
                columns[SHEAR..POINTS].copy_from_slice(&shear);
            }
        }
    }
}
