//! How fast what is near passes what it could meet. A pair is looked at from [`REACH`] of its
//! scales on: while it does not move by more than these in a step, it is seen before it is through.
//! What is farther away does not count, however fast it flies and however thin a foil there is
//! elsewhere.
//!
//! A rate that is found in a step is agreed on in the next one and holds for the step after that:
//! what can be near by then counts. It is decided by places and velocities alone, so that neither
//! search nor workers show; a search has to know all that is so near ([`STEPS`]).

use crate::contact::geometry::V3;
use crate::contact::local_search::REACH;
use crate::contact::surface::Segment;
use crate::nodes::{Nodes, Row, xyz};

/// Steps within which what comes near has to be known: until the one that a rate holds for is over,
/// and one more for what becomes faster meanwhile.
pub const STEPS: f64 = 4.0;

fn v3(row: &Row) -> V3 {
    V3::from(xyz(row))
}

/// Largest relative velocity of a node of one side and one of the other, contact not yet felt
/// [length/time].
pub fn speed(nodes: &Nodes, ahead: &[u32], behind: &[u32]) -> f64 {
    let square = |a: &u32, b: &u32| {
        (v3(&nodes.v_next[*a as usize]) - v3(&nodes.v_next[*b as usize])).norm_squared()
    };
    ahead.iter().flat_map(|a| behind.iter().map(move |b| square(a, b))).fold(0.0, f64::max).sqrt()
}

/// How often a slave passes the scales of a segment in a unit of time, 0 if it is too far away to
/// count [1/time]. `scale` is theirs together [length].
pub fn rate(nodes: &Nodes, slave: u32, segment: &Segment, scale: f64, dt: f64) -> f64 {
    let speed = speed(nodes, &[slave], &segment.nodes);
    let at = v3(&nodes.x[slave as usize]);
    let Some(near) = segment.nearest(&at, &nodes.x) else { return 0.0 };
    if (at - near.point).norm() <= REACH * scale + STEPS * dt * speed { speed / scale } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::surface::NOT_LOCAL;
    use crate::testing::nodes_at;
    use crumple_proto::ids::SegmentId;

    /// A slave that comes down on a thin square counts when it can be there in four steps, and with
    /// its own scale and speed.
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
                scale: 0.01,
                part: 0,
                own: true,
            };
            rate(&nodes, 4, &foil, 0.02, 0.1)
        };
        let reach = 1.5 * 0.02 + 4.0 * 0.1 * 2.0;
        assert_eq!([rate_from(0.999 * reach), rate_from(1.001 * reach)], [2.0 / 0.02, 0.0]);
    }
}
