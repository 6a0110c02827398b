//! Ties of nodes to the mean motion of a node set.

use super::{Projected, TieContext, name, whole};
use crate::input::job::validate::JobProblems;
use crumple_proto::ids::NodeId;
use crumple_proto::job::TieInput;
use crumple_proto::problem::Problem;
use crumple_proto::tie::Tie;
use nalgebra::{Matrix3, Vector3};

/// Smallest spread of masters across their longest line, over that along it: points below it are
/// on one line.
const ON_A_LINE: f64 = 1e-9;

/// Returns the ties of nodes that follow the mean motion of a set.
pub(super) fn to_mean(
    spec: &TieInput,
    set: &str,
    entry: usize,
    nodes: Vec<usize>,
    context: &TieContext<'_>,
    findings: &mut JobProblems,
) -> Vec<Projected> {
    let TieContext { job, mesh, sets, .. } = context;
    let path = |key: &str| format!("tie.{entry}.{key}");
    let masters = sets.ids(set, path("mean_of"), findings).unwrap_or_default();
    let mut wrong = |key: &str, message: String, help: &str| {
        let message = format!("{}: {message}", name(job, entry));
        findings.add(Problem::error(path(key), message, help));
    };
    if !spec.parts.is_empty() || spec.faces.is_some() || spec.offset || spec.inside {
        wrong(
            "mean_of",
            "it has `mean_of` and also `parts`, `faces`, `offset` or `inside`".into(),
            "remove them: a tie to a mean motion has no surface, and keeps its distance",
        );
    }
    if masters.is_empty() {
        return Vec::new();
    }
    let count = masters.len();
    if !spec.weights.is_empty() && spec.weights.len() != count {
        let message = format!("it has {} weights for {count} masters", spec.weights.len());
        wrong("weights", message, "give one weight for each node of `mean_of` that has elements");
        return Vec::new();
    }
    if let Some(weight) = spec.weights.iter().find(|w| !(**w > 0.0 && w.is_finite())) {
        let message = format!("a weight is {weight}");
        wrong("weights", message, "give numbers above 0, or leave masters without weight out");
        return Vec::new();
    }
    if let Some(&n) = nodes.iter().find(|&&n| masters.contains(&mesh.nodes[n].id)) {
        let message = format!("node {} is its own master", mesh.nodes[n].id);
        wrong("nodes", message, "remove it from `mean_of`");
    }
    // Weights are in the order of the ids of the user.
    let mut in_order = masters.clone();
    in_order.sort_unstable_by_key(|id| id.label());
    let weight = |k: usize| spec.weights.get(k).copied().unwrap_or(1.0);
    let mut shares: Vec<(NodeId, f64)> =
        in_order.iter().enumerate().map(|(k, id)| (*id, weight(k))).collect();
    whole(&mut shares);
    let spread = Spread::new(&shares, |id| context.place(*id));
    if spread.least <= ON_A_LINE * spread.most {
        wrong(
            "mean_of",
            "its masters are on one line, about which they cannot turn".into(),
            "give at least three nodes off one line",
        );
        return Vec::new();
    }
    let tied = |node: usize| Projected {
        tie: Tie {
            node: mesh.nodes[node].id,
            masters: shares.clone(),
            near: Vec::new(),
            faces: Vec::new(),
            rotations: spec.rotations,
            offset: true,
            mean: true,
            failure: None,
        },
        entry,
        node,
        point: mesh.nodes[node].x,
        moved: 0.0,
    };
    nodes.into_iter().map(tied).collect()
}

/// Spread of weighted points about their mean.
struct Spread {
    /// Their mean [length].
    foot: Vector3<f64>,
    /// Smallest and largest principal value of `sum N (r^2 I - r r')` [length^2].
    least: f64,
    most: f64,
}

impl Spread {
    fn new(shares: &[(NodeId, f64)], at: impl Fn(&NodeId) -> [f64; 3]) -> Self {
        let points = || shares.iter().map(|(id, share)| (Vector3::from(at(id)), *share));
        let foot: Vector3<f64> = points().map(|(x, share)| x * share).sum();
        let spread = points().fold(Matrix3::zeros(), |sum, (x, share)| {
            let r = x - foot;
            sum + (Matrix3::identity() * r.norm_squared() - r * r.transpose()) * share
        });
        let values = spread.symmetric_eigenvalues();
        Self { foot, least: values.min(), most: values.max() }
    }
}

/// Returns the reciprocal of the fraction of the mass of a tied node on which the step of its
/// elements has to be based, 1 or above.
///
/// With the mean velocity v and rotation w of its masters, which get its mass by their weights N,
/// their kinetic energy is at least that of `v^2 + t w^2`, t the smallest principal value of their
/// spread. The squared velocity of the node at the distance d is at most `(1 + a) v^2 + (1 + 1/a)
/// d^2 w^2`, for any a above 0. The smallest bound has `a = d^2/t`.
pub fn excess(tie: &Tie, at: impl Fn(&NodeId) -> [f64; 3]) -> f64 {
    let spread = Spread::new(&tie.masters, &at);
    1.0 + (Vector3::from(at(&tie.node)) - spread.foot).norm_squared() / spread.least
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The bound holds for a node on an arm: with the velocities of masters that move it most, its
    /// squared velocity is at most that of the masters times the excess. At the mean it is 1.
    #[test]
    fn the_excess_bounds_the_velocity_of_the_node() {
        let corners = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
        let masters = (0..4).map(|k| (NodeId(k + 1), 0.25)).collect();
        let tie = Tie {
            node: NodeId(9),
            masters,
            near: Vec::new(),
            faces: Vec::new(),
            rotations: false,
            offset: true,
            mean: true,
            failure: None,
        };
        for arm in [[0.0, 0.0, 0.0], [0.0, 0.0, 0.7], [2.0, 0.0, 0.0]] {
            let at = |id: &NodeId| if id.0 == 9 { arm } else { corners[id.0 as usize - 1] };
            let found = excess(&tie, at);
            let mut most = 0.0f64;
            // Translations along z or x with a rotation about x, y or z, at all ratios.
            for step in 0..=400 {
                let angle = f64::from(step) * std::f64::consts::TAU / 400.0;
                for (drift, axis) in [
                    ([0.0, 0.0, 1.0], 0),
                    ([0.0, 1.0, 0.0], 0),
                    ([0.0, 0.0, 1.0], 1),
                    ([1.0, 0.0, 0.0], 1),
                    ([0.0, 1.0, 0.0], 2),
                ] {
                    let mut spin = Vector3::zeros();
                    spin[axis] = angle.sin();
                    let v = |x: [f64; 3]| {
                        Vector3::from(drift) * angle.cos() + spin.cross(&Vector3::from(x))
                    };
                    let of_masters: f64 = corners.iter().map(|&x| 0.25 * v(x).norm_squared()).sum();
                    most = most.max(v(arm).norm_squared() / of_masters);
                }
            }
            assert!(most <= found * (1.0 + 1e-12), "{arm:?}: {most} above {found}");
            assert!(found <= 1.6 * most, "{arm:?}: {found} is far from {most}");
        }
        let at = |id: &NodeId| if id.0 == 9 { [0.0; 3] } else { corners[id.0 as usize - 1] };
        assert_eq!(excess(&tie, at), 1.0);
    }
}
