//! Start of the ties: tables, masses that move to the masters, velocities of the slaves.

use super::exchange::{PackedNode, of_owners};
use super::mean::MeanRotation;
use super::{ARM_INERTIA, Ties, blend};
use crate::math::row::{V3, row, xyz};
use crate::nodes::Nodes;
use crumple_proto::ids::NodeId;
use crumple_proto::partition::Settings;
use crumple_proto::tie::Tie;
use crumple_proto::transport::{RankLost, Transport};

impl Ties {
    /// Builds all ties: adds masses to masters and sets the velocities of slaves. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn new(
        comm: &mut dyn Transport,
        settings: &Settings,
        nodes: &mut Nodes,
    ) -> Result<Self, RankLost> {
        let jobs = settings.ties.clone();
        if jobs.is_empty() {
            return Ok(Self::default());
        }
        let mut all = Self::of_jobs(jobs, nodes.rotations);
        let tied: Vec<NodeId> = all.definitions.iter().map(|t| t.node).collect();
        let slaves = of_owners(comm, nodes, &tied)?;
        all.slave_masses = slaves.iter().map(|s| [s.mass, s.inertia]).collect();
        let mut masters = of_owners(comm, nodes, &all.masters)?;
        let own: Vec<f64> = masters.iter().map(|m| m.mass).collect();
        all.breakable = all.breakable_of(&own);
        let arms = all.arms_of(&slaves, &masters);
        all.added_inertia = all.inertia_of_slaves(&arms);
        all.share_momentum(&slaves, &arms, &mut masters);
        all.move_masses(nodes);
        all.set_velocities(&masters, &arms, nodes);
        Ok(all)
    }

    /// Builds the tables of the ties; `rotations` states if nodes rotate.
    pub(super) fn of_jobs(jobs: Vec<Tie>, rotations: bool) -> Self {
        let mut masters: Vec<NodeId> =
            jobs.iter().flat_map(|t| t.masters.iter().map(|c| c.0)).collect();
        masters.extend(jobs.iter().flat_map(|t| &t.failure).flat_map(|f| f.corners));
        masters.sort_unstable();
        masters.dedup();
        let number = |id: NodeId| masters.partition_point(|&c| c < id) as u32;
        Self {
            turn: rotations && jobs.iter().any(|t| t.rotations || t.offset),
            arms: jobs.iter().any(|t| t.mean || rotations && t.offset),
            means: jobs.iter().any(|t| t.mean),
            shares: jobs
                .iter()
                .map(|t| t.masters.iter().map(|&(id, share)| (number(id), share)).collect())
                .collect(),
            slave_loads: vec![[V3::zeros(); 2]; jobs.len()],
            master_velocities: vec![[[0.0; 3]; 2]; masters.len()],
            master_positions: vec![[0.0; 3]; masters.len()],
            contact_forces: vec![V3::zeros(); masters.len()],
            definitions: jobs,
            masters,
            ..Self::default()
        }
    }

    /// Returns the vector to each slave from the point of its masters, zero for ties without
    /// offset [length].
    fn arms_of(&self, slaves: &[PackedNode], masters: &[PackedNode]) -> Vec<V3> {
        let joined = self.definitions.iter().zip(&self.shares).zip(slaves);
        joined
            .map(|((job, shares), slave)| {
                if self.has_arm(job) {
                    V3::from(slave.x) - V3::from(xyz(&blend(shares, |c| masters[c].x)))
                } else {
                    V3::zeros()
                }
            })
            .collect()
    }

    /// Returns the inertia that each slave adds to its masters [mass length^2].
    fn inertia_of_slaves(&self, arms: &[V3]) -> Vec<f64> {
        let inertia = |(job, (own, arm)): (&Tie, (&[f64; 2], &V3))| {
            if job.mean {
                return 0.0; // its masters do not rotate with it
            }
            let turns = if self.turn && job.rotations { own[1] } else { 0.0 };
            turns + ARM_INERTIA * own[0] * arm.norm_squared()
        };
        self.definitions.iter().zip(self.slave_masses.iter().zip(arms)).map(inertia).collect()
    }

    /// Moves the masses of all slaves to their masters.
    fn move_masses(&mut self, nodes: &mut Nodes) {
        for t in 0..self.definitions.len() {
            self.add_masses(t, 1.0, nodes);
            if let Some(n) = nodes.index_of(self.definitions[t].node).map(|n| n as usize) {
                nodes.mass[n] = 0.0;
                if self.turn && self.definitions[t].rotations {
                    nodes.inertia[n] = 0.0;
                }
                nodes.invert_mass(n);
            }
        }
    }

    /// Sets the velocities of the masters that are present here, and those of the slaves that
    /// follow from them.
    fn set_velocities(&self, masters: &[PackedNode], arms: &[V3], nodes: &mut Nodes) {
        for (&id, state) in self.masters.iter().zip(masters) {
            if let Some(n) = nodes.index_of(id).map(|n| n as usize) {
                nodes.v[n][..3].copy_from_slice(&state.v);
                nodes.v_next[n] = nodes.v[n];
                if nodes.rotations {
                    nodes.w[n][..3].copy_from_slice(&state.w);
                }
            }
        }
        for ((job, shares), arm) in self.definitions.iter().zip(&self.shares).zip(arms) {
            let Some(n) = nodes.index_of(job.node).map(|n| n as usize) else { continue };
            let spin = match job.mean {
                true => {
                    let rotation = MeanRotation::new(shares, |c| masters[c].x);
                    row(rotation.spin(shares, |c| masters[c].x, |c| masters[c].v).into())
                }
                false => blend(shares, |c| masters[c].w),
            };
            nodes.v[n] = blend(shares, |c| masters[c].v);
            let turned = V3::from(xyz(&spin)).cross(arm);
            (0..3).for_each(|k| nodes.v[n][k] += turned[k]);
            nodes.v_next[n] = nodes.v[n];
            if self.turn && job.rotations {
                nodes.w[n] = spin;
            }
        }
    }
}
