//! Marks of the shells that are divided: the criterion, rings of neighbours, and the rule that a
//! side has one node in its middle, where both shells may be divided.

use super::division::quarter_of_quad;
use super::{Adaptivity, ShellSide, side};
use crate::fem::blocks::{Block, Blocks};
use crate::math::row::{V3, xyz};
use crate::nodes::Nodes;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{CornerNodes, Shape};
use crumple_proto::transport::{RankLost, Transport, gather_all};
use std::collections::{BTreeSet, HashSet};

/// Smallest area of a quarter in the direction of the normal of its shell, over that of the shell.
/// A quarter of a square has 1/4; at a re-entrant corner of a concave quad it is negative.
const LEAST_QUARTER: f64 = 0.05;

/// Returns the sides of a four-node shell.
pub(crate) fn sides(nodes: &CornerNodes) -> [ShellSide; 4] {
    std::array::from_fn(|k| side(nodes[k], nodes[(k + 1) % 4]))
}

/// Returns half the product of the diagonals: a vector along the normal [length^2].
fn area(x: &[[f64; 3]; 4]) -> V3 {
    let across = |a: usize, b: usize| V3::from(x[b]) - V3::from(x[a]);
    across(0, 2).cross(&across(1, 3)) * 0.5
}

/// Returns true if the quarters of a quad have its normal and are not too small.
fn has_sound_quarters(x: &[[f64; 3]; 4]) -> bool {
    let whole = area(x);
    let share = |corner| area(&quarter_of_quad(x, corner)).dot(&whole) / whole.norm_squared();
    (0..4).all(|corner| share(corner) > LEAST_QUARTER)
}

/// Returns the plastic bending angle of own element `i` of a block with the area A [rad]. With the
/// strain `kappa z` of bending the outer fibres have the plastic strain `kappa t/2`; so the angle
/// between two sides at the distance L, `kappa L`, is `2 eps L/t`, with `L = sqrt(A)`.
fn bending_angle(block: &Block, i: usize, x: &[[f64; 3]; 4]) -> f64 {
    let state = block.state(i);
    let strain = block.element.plastic_bending_strain(state);
    let thickness = block.element.fields(state, x).thickness;
    if thickness > 0.0 { 2.0 * strain * area(x).norm().sqrt() / thickness } else { 0.0 }
}

/// Returns the own elements that are divided now, as indices into [`Blocks::elements`]. All workers
/// call this together.
///
/// # Errors
/// A worker is gone.
pub(crate) fn marks(
    comm: &mut dyn Transport,
    known: &Adaptivity,
    blocks: &Blocks,
    nodes: &Nodes,
) -> Result<BTreeSet<usize>, RankLost> {
    let (open, mut marked) = open_and_bent(known, blocks, nodes);
    for _ in 0..known.settings.rings {
        let corners = |&i: &usize| blocks.elements[i].record.nodes;
        let around: BTreeSet<NodeId> = marked.iter().flat_map(corners).collect();
        let around = gather_all(comm, around.into_iter().collect())?.concat();
        let around: HashSet<NodeId> = around.into_iter().collect();
        let touches = |i: &usize| corners(i).iter().any(|n| around.contains(n));
        marked.extend(open.iter().copied().filter(touches));
    }
    // Larger neighbours of marked elements, and theirs.
    let mut last: Vec<usize> = marked.iter().copied().collect();
    loop {
        let own = last.iter().flat_map(|&i| sides(&blocks.elements[i].record.nodes));
        let wholes: BTreeSet<ShellSide> = own.filter_map(|s| known.whole_side(s)).collect();
        let wholes = gather_all(comm, wholes.into_iter().collect())?.concat();
        if wholes.is_empty() {
            return Ok(marked);
        }
        let wholes: HashSet<ShellSide> = wholes.into_iter().collect();
        let has =
            |i: &usize| sides(&blocks.elements[*i].record.nodes).iter().any(|s| wholes.contains(s));
        last = open.iter().copied().filter(|i| !marked.contains(i) && has(i)).collect();
        marked.extend(&last);
    }
}

/// Returns the elements that may be divided, ascending, and those of them whose plastic bending
/// angle has reached its limit.
fn open_and_bent(
    known: &Adaptivity,
    blocks: &Blocks,
    nodes: &Nodes,
) -> (Vec<usize>, BTreeSet<usize>) {
    let (mut open, mut bent) = (Vec::new(), BTreeSet::new());
    for b in &blocks.blocks {
        for i in 0..b.count {
            let e = &blocks.elements[b.first + i];
            let (r, state) = (&e.record, b.state(i));
            let may = r.shape == Shape::Quad4 && known.may_divide(r.part, r.id);
            if !may || r.failed || b.element.can_fail() && b.element.failed(state) {
                continue;
            }
            let x = std::array::from_fn(|c| xyz(&nodes.x[e.nodes[c] as usize]));
            if !has_sound_quarters(&x) {
                continue;
            }
            open.push(b.first + i);
            if bending_angle(b, i, &x) >= known.settings.angle {
                bent.insert(b.first + i);
            }
        }
    }
    (open, bent)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn concave_quads_are_not_divided() {
        let quad = |x: f64| [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [x, x, 0.0], [0.0, 1.0, 0.0]];
        assert!(has_sound_quarters(&quad(1.0)) && has_sound_quarters(&quad(0.7)));
        assert!(
            !has_sound_quarters(&quad(0.2)),
            "the quarter at the re-entrant corner is inverted"
        );
        assert!(!has_sound_quarters(&quad(0.0)), "without area");
    }
}
