//! Nodes of a group of quads as rows of modes, and back: gathering of corner coordinates and
//! velocities, the middle surface of shells with an offset, forces at the corners.

use super::super::kinematics::along_normal;
use super::super::{GroupCorners, GroupNodes};
use super::{QuadModes, QuadResponse};
use crate::materials::PointLanes;
use crate::nodes::NodeView;
use crumple_math::lanes::{Each, Lane, cross};

/// Returns the modes 1 - 3, 2 - 4 and h of the corner coordinates of a group [length]. Differences
/// are taken row by row, before the rows become lanes.
#[inline(always)]
pub(super) fn gather_coordinates<L: PointLanes<W>, const W: usize>(
    group: &GroupNodes<4, W>,
    x: &[[f64; 4]],
) -> [[L; 3]; 3] {
    let mut modes = [[L::row(Lane::splat(0.0)); W]; 3];
    for lane in 0..W {
        let corner = group.map(|corner| corner[lane] as usize);
        let rows = rows_of_coordinates(x, corner).map(L::row);
        [modes[0][lane], modes[1][lane], modes[2][lane]] = rows;
    }
    modes.each(L::from_rows)
}

/// Returns the modes of the corner velocities of a group, in the same way.
#[inline(always)]
pub(super) fn gather_velocities<L: PointLanes<W>, const W: usize>(
    group: &GroupNodes<4, W>,
    nodes: &NodeView<'_>,
) -> QuadModes<L> {
    // One length for both columns, so that one bounds check per node is enough.
    let n = nodes.x.len();
    let (v, w) = (&nodes.v[..n], &nodes.w[..n]);
    let zero = L::row(Lane::splat(0.0));
    let (mut of_v, mut of_w) = ([[zero; W]; 3], [[zero; W]; 4]);
    for lane in 0..W {
        let corner = group.map(|corner| corner[lane] as usize);
        let modes = |column: &[[f64; 4]]| {
            let [a, b, c, d] = corner.map(|node| Lane::new(column[node]));
            [a - c, b - d, (a + c) - (b + d), (a + c) + (b + d)].map(L::row)
        };
        let rows = modes(v);
        [of_v[0][lane], of_v[1][lane], of_v[2][lane]] = [rows[0], rows[1], rows[2]];
        let rows = modes(w);
        [of_w[0][lane], of_w[1][lane], of_w[2][lane], of_w[3][lane]] = rows;
    }
    QuadModes { v: of_v.each(L::from_rows), w: of_w.each(L::from_rows) }
}

/// Returns the sum of the magnitudes of all coordinates and velocities of a group, which is not
/// finite if one of them is not.
#[cold]
#[inline(never)]
pub fn magnitude<L: PointLanes<W>, const W: usize>(
    group: &GroupNodes<4, W>,
    nodes: &NodeView<'_>,
) -> L {
    let x: [[L; 3]; 3] = gather_coordinates(group, nodes.x);
    let QuadModes { v, w } = gather_velocities::<L, W>(group, nodes);
    let all = [x.as_flattened(), v.as_flattened(), w.as_flattened()];
    all.into_iter().flatten().fold(L::zero(), |sum, c| sum + c.abs())
}

/// Velocities of the middle surface of a group, `v + w x e n`, as modes, and the arm `e n`
/// [length].
pub(super) struct OfMiddle<L> {
    pub modes: QuadModes<L>,
    pub arm: [L; 3],
}

/// Returns the velocities of the middle surface, which is at the distance `e` from the nodes along
/// the normal [length]. The modes of the coordinates are the same for both.
#[cold]
#[inline(never)]
pub(super) fn of_middle<L: PointLanes<W>, const W: usize>(
    group: &GroupNodes<4, W>,
    nodes: &NodeView<'_>,
    e: L,
) -> OfMiddle<L> {
    let x: [[L; 3]; 3] = gather_coordinates(group, nodes.x);
    let mut modes = gather_velocities::<L, W>(group, nodes);
    let arm = along_normal(e, x[0], x[1]);
    for c in 0..3 {
        let more = cross(modes.w[c], arm);
        modes.v[c] = std::array::from_fn(|i| modes.v[c][i] + more[i]);
    }
    OfMiddle { modes, arm }
}

/// Adds to the moments on the nodes those of the forces on the middle surface, which act at `arm`
/// from the nodes, so that the work on both is the same.
#[cold]
#[inline(never)]
pub(super) fn shift_to_nodes<L: PointLanes<W>, const W: usize>(
    arm: [L; 3],
    force: &GroupCorners<4, W>,
    moment: &mut GroupCorners<4, W>,
) {
    let arm = L::to_rows(arm).map(|arm| arm.to_array());
    for lane in 0..W {
        for (f, m) in force[lane].iter().zip(&mut moment[lane]) {
            let more = cross([arm[lane][0], arm[lane][1], arm[lane][2]], [f[0], f[1], f[2]]);
            (0..3).for_each(|i| m[i] += more[i]);
        }
    }
}

/// Sets forces and moments of the lanes `gone` to zero.
#[cold]
#[inline(never)]
pub fn zero_corners<L: PointLanes<W>, const W: usize>(
    gone: L::Mask,
    force: &mut GroupCorners<4, W>,
    moment: &mut GroupCorners<4, W>,
) {
    let gone = L::select(gone, L::splat(1.0), L::zero()).to_array();
    for lane in (0..W).filter(|&lane| gone[lane] > 0.0) {
        (force[lane], moment[lane]) = ([[0.0; 4]; 4], [[0.0; 4]; 4]);
    }
}

/// Returns the modes of the coordinates of an element. h is taken from differences of neighbours,
/// which are small: `(1 - 2) + (3 - 4)`.
#[inline(always)]
fn rows_of_coordinates(x: &[[f64; 4]], corner: [usize; 4]) -> [Lane; 3] {
    let [a, b, c, d] = corner.map(|node| Lane::new(x[node]));
    [a - c, b - d, (a - b) + (c - d)]
}

/// Converts modes to corner values and lanes to rows.
#[inline(always)]
pub(super) fn scatter<L: PointLanes<W>, const W: usize>(
    response: &QuadResponse<L>,
    force: &mut GroupCorners<4, W>,
    moment: &mut GroupCorners<4, W>,
) {
    let [f13, f24, fh] = response.force.each(L::to_rows);
    let [m13, m24, mh, ms] = response.moment.each(L::to_rows);
    for lane in 0..W {
        let force = &mut force[lane];
        force[0] = (fh[lane] + f13[lane]).to_array();
        force[1] = (f24[lane] - fh[lane]).to_array();
        force[2] = (fh[lane] - f13[lane]).to_array();
        force[3] = (-(f24[lane] + fh[lane])).to_array();
        let moment = &mut moment[lane];
        let (even, odd) = (ms[lane] + mh[lane], ms[lane] - mh[lane]);
        moment[0] = (even + m13[lane]).to_array();
        moment[1] = (odd + m24[lane]).to_array();
        moment[2] = (even - m13[lane]).to_array();
        moment[3] = (odd - m24[lane]).to_array();
    }
}
