//! Marks of the shells that are divided: the criterion, rings of neighbours, and the rule that no
//! side has more than one node in its middle.

use super::{Adaptivity, Side, side};
use crate::fem::blocks::{Block, Blocks};
use crate::math::row::xyz;
use crate::nodes::Nodes;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{CornerNodes, Shape};
use crumple_proto::transport::{RankLost, Transport, gather_all};
use std::collections::{BTreeSet, HashSet};

/// Returns the sides of a four-node shell.
pub(super) fn sides(nodes: &CornerNodes) -> [Side; 4] {
    std::array::from_fn(|k| side(nodes[k], nodes[(k + 1) % 4]))
}

/// Returns the plastic bending angle of own element `i` of a block [rad]. With the strain `kappa z`
/// of bending the outer fibres have the plastic strain `kappa t/2`; so the angle between two sides
/// at the distance L, `kappa L`, is `2 eps L/t`. Plastic strain that is the same at all points
/// through the thickness is no bending.
fn bending_angle(block: &Block, i: usize, x: &[[f64; 3]; 4]) -> f64 {
    let state = block.state(i);
    let points = block.element.points(state, x);
    let strains = || points.iter().map(|p| p.plastic_strain);
    let (most, least) = (strains().fold(0.0, f64::max), strains().fold(f64::INFINITY, f64::min));
    let thickness = block.element.fields(state, x).thickness;
    if most <= least || thickness <= 0.0 {
        return 0.0;
    }
    2.0 * (most - least) * area(x).sqrt() / thickness
}

/// Returns half the size of the product of the diagonals [length^2].
fn area(x: &[[f64; 3]; 4]) -> f64 {
    let across = |a: usize, b: usize| [0, 1, 2].map(|c| x[b][c] - x[a][c]);
    let [p, q] = [across(0, 2), across(1, 3)].map(nalgebra::Vector3::from);
    0.5 * p.cross(&q).norm()
}

/// Returns the own elements that are divided now, as indices into [`Blocks::elements`]. All workers
/// call this together.
///
/// # Errors
/// A worker is gone.
pub(super) fn marks(
    comm: &mut dyn Transport,
    known: &Adaptivity,
    blocks: &Blocks,
    nodes: &Nodes,
) -> Result<BTreeSet<usize>, RankLost> {
    let open: Vec<usize> = (0..blocks.elements.len())
        .filter(|&i| {
            let r = &blocks.elements[i].record;
            r.shape == Shape::Quad4 && !r.failed && known.may_divide(r.part, r.id)
        })
        .collect();
    let mut marked = bent(known, blocks, nodes, &open);
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
        let wholes: BTreeSet<Side> = own.filter_map(|s| known.whole_side(s)).collect();
        let wholes = gather_all(comm, wholes.into_iter().collect())?.concat();
        if wholes.is_empty() {
            return Ok(marked);
        }
        let wholes: HashSet<Side> = wholes.into_iter().collect();
        let has =
            |i: &usize| sides(&blocks.elements[*i].record.nodes).iter().any(|s| wholes.contains(s));
        last = open.iter().copied().filter(|i| !marked.contains(i) && has(i)).collect();
        marked.extend(&last);
    }
}

/// Returns the open elements whose plastic bending angle has reached its limit.
fn bent(known: &Adaptivity, blocks: &Blocks, nodes: &Nodes, open: &[usize]) -> BTreeSet<usize> {
    let open: HashSet<usize> = open.iter().copied().collect();
    let of_block = |b: &'_ Block| -> Vec<usize> {
        let is_bent = |&i: &usize| {
            let corners = blocks.elements[b.first + i].nodes;
            let x = std::array::from_fn(|c| xyz(&nodes.x[corners[c] as usize]));
            bending_angle(b, i, &x) >= known.settings.angle
        };
        let own = (0..b.count).filter(|i| open.contains(&(b.first + i)));
        own.filter(is_bent).map(|i| b.first + i).collect()
    };
    blocks.blocks.iter().flat_map(of_block).collect()
}
