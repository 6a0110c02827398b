//! Rate at which near slaves and segments pass each other. A pair is examined if its distance is
//! below [`REACH`] of its scales. If it moves by at most these scales in a step, it is found
//! before the slave has passed through. Slaves that are farther away do not count, for any
//! velocity and for any thin foil elsewhere in the model.
//!
//! A rate that is computed in a step is reduced over all workers in the next step and limits the
//! step after that. So everything that can be near by then counts. The rate depends on positions
//! and velocities only, not on the search or on the number of workers. The candidates of a
//! search must include everything within this distance ([`STEPS`]).
use crate::reach::REACH;
use crate::surface::Segment;
use crumple_fem::nodes::Nodes;
use crumple_math::row::{Row, V3, xyz};

/// Number of steps for which approaching slaves must be known: until the end of the step that a
/// rate limits, and one more for velocities that grow in that time.
pub const STEPS: f64 = 4.0;

fn v3(row: &Row) -> V3 {
    V3::from(xyz(row))
}

/// Returns the largest relative velocity of a node of one side and a node of the other, without
/// contact [length/time].
pub fn speed(nodes: &Nodes, ahead: &[u32], behind: &[u32]) -> f64 {
    let square = |a: &u32, b: &u32| {
        (v3(&nodes.v_next[*a as usize]) - v3(&nodes.v_next[*b as usize])).norm_squared()
    };
    ahead.iter().flat_map(|a| behind.iter().map(move |b| square(a, b))).fold(0.0, f64::max).sqrt()
}

/// Returns the relative velocity of a slave and a segment over their scales, 0 if the slave is
/// too far away to count [1/time]. `scale` is the sum of both scales, `added` what shifts add to
/// the reach ([`Surface::shift_reach`](super::surface::Surface::shift_reach)) [length], `dt` the
/// longest step to which the present one can grow [time].
pub fn rate(
    nodes: &Nodes,
    slave: u32,
    segment: &Segment,
    (scale, added): (f64, f64),
    dt: f64,
) -> f64 {
    let speed = speed(nodes, &[slave], &segment.nodes);
    let at = v3(&nodes.x[slave as usize]);
    let Some(near) = segment.nearest(&at, &nodes.x) else { return 0.0 };
    let reach = REACH * scale + added + STEPS * dt * speed;
    if (at - near.point).norm() <= reach { speed / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surface::NOT_LOCAL;
    use crumple_fem::testing::nodes_at;
    use crumple_proto::ids::SegmentId;

    /// A slave that moves towards a thin square counts if it can reach it in four steps; the
    /// rate uses the scale and the speed of this pair.
    #[test]
    fn what_can_be_near_in_four_steps_counts() {
        let rate_from = |height: f64| {
            let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
            let mut nodes = nodes_at(&[&square[..], &[[0.5, 0.5, height]]].concat());
            nodes.v_next[4] = [0.0, 0.0, -2.0, 0.0];
            let id = SegmentId(8);
            let behind = [NOT_LOCAL; 4];
            let foil = Segment {
                id,
                nodes: [0, 1, 2, 3],
                behind,
                half_thickness: 0.01,
                offset: 0.0,
                scale: 0.01,
                part: 0,
                own: true,
                searched: true,
            };
            rate(&nodes, 4, &foil, (0.02, 0.0), 0.1)
        };
        let reach = 1.5 * 0.02 + 4.0 * 0.1 * 2.0;
        assert_eq!([rate_from(0.999 * reach), rate_from(1.001 * reach)], [2.0 / 0.02, 0.0]);
    }
}
