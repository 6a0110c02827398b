//! Stress and plastic strain of an element at the start, at the points that it has. The points that
//! are given may be others, such as those of a simulation of forming with another rule.
//!
//! Through the thickness, stress is linear between the given points and beyond the outermost ones:
//! then linear stress keeps its moment. Plastic strain is constant beyond them, since it is not
//! below 0.

use crumple_proto::initial::InitialPoint;

/// Values of the state at the start that the law of an element takes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct TakenAtStart {
    /// True if it takes a stress: the stress of the law follows from that before and the strain
    /// increment. Others compute it from all of the deformation since the start.
    pub stress: bool,
    /// True if it takes a plastic strain.
    pub plastic_strain: bool,
}

/// Stress [force/length^2] and plastic strain of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct StateAtStart {
    /// Global stress xx, yy, zz, xy, yz, zx.
    pub stress: [f64; 6],
    /// Effective plastic strain.
    pub plastic_strain: f64,
}

impl StateAtStart {
    fn of(point: &InitialPoint) -> Self {
        Self { stress: point.stress, plastic_strain: point.plastic_strain }
    }

    /// Returns the mean of some states.
    pub fn mean(states: impl ExactSizeIterator<Item = Self>) -> Self {
        let share = 1.0 / states.len() as f64;
        states.fold(Self::default(), |sum, state| Self {
            stress: std::array::from_fn(|c| sum.stress[c] + share * state.stress[c]),
            plastic_strain: sum.plastic_strain + share * state.plastic_strain,
        })
    }

    /// Returns the mean of the points of a solid.
    pub fn of_solid(points: &[InitialPoint]) -> Self {
        Self::mean(points.iter().map(Self::of))
    }

    /// Returns the state at a place through the thickness from points there, ascending by their
    /// different positions.
    pub fn at(points: &[InitialPoint], position: f64) -> Self {
        if points.len() < 2 {
            return Self::of_solid(points);
        }
        let inner = &points[1..points.len() - 1];
        let above = 1 + inner.iter().take_while(|p| p.position < position).count();
        let (low, high) = (&points[above - 1], &points[above]);
        let along = (position - low.position) / (high.position - low.position);
        let between = |a: f64, b: f64, along: f64| along.mul_add(b - a, a);
        Self {
            stress: std::array::from_fn(|c| between(low.stress[c], high.stress[c], along)),
            plastic_strain: between(low.plastic_strain, high.plastic_strain, along.clamp(0.0, 1.0)),
        }
    }

    /// Returns the stress in the axes e1, e2 and normal of a shell: xx, yy, xy, and the transverse
    /// xz and yz.
    pub fn in_axes(&self, axes: &[[f64; 3]; 3]) -> [f64; 5] {
        let [xx, yy, zz, xy, yz, zx] = self.stress;
        let global = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
        let local = |a: usize, b: usize| -> f64 {
            let each = |i: usize| (0..3).map(move |j| axes[a][i] * global[i][j] * axes[b][j]);
            (0..3).flat_map(each).sum()
        };
        [local(0, 0), local(1, 1), local(0, 1), local(0, 2), local(1, 2)]
    }
}

/// Returns the points of each number.
pub fn by_number(points: &[InitialPoint]) -> Vec<&[InitialPoint]> {
    points.chunk_by(|a, b| a.number == b.number).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::ids::ElemId;

    fn point(position: f64, along: f64, plastic_strain: f64) -> InitialPoint {
        let stress = [along, 0.0, 0.0, 0.0, 0.0, 0.0];
        InitialPoint { element: ElemId(1), number: 1, position, stress, plastic_strain }
    }

    /// Stress lies on the lines through the points, also beyond them; plastic strain stays.
    #[test]
    fn values_lie_on_lines_between_points() {
        let given = [point(-0.8, 1.0, 0.0), point(0.0, 0.0, 0.1), point(0.8, 3.0, 0.3)];
        for (position, stress, strain) in [
            (-1.0, 1.25, 0.0),
            (-0.4, 0.5, 0.05),
            (0.0, 0.0, 0.1),
            (0.4, 1.5, 0.2),
            (1.0, 3.75, 0.3),
        ] {
            let state = StateAtStart::at(&given, position);
            assert!((state.stress[0] - stress).abs() < 1e-14, "{position}");
            assert!((state.plastic_strain - strain).abs() < 1e-14, "{position}");
        }
        assert_eq!(StateAtStart::at(&given[..1], 0.9).stress[0], 1.0);
    }

    /// Axes that are turned by a quarter about the normal.
    #[test]
    fn stresses_turn_into_the_axes_of_a_shell() {
        let state = StateAtStart { stress: [1.0, 2.0, 0.0, 0.5, 0.3, 0.4], plastic_strain: 0.0 };
        let axes = [[0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        assert_eq!(state.in_axes(&axes), [2.0, 1.0, -0.5, 0.3, -0.4]);
    }
}
