//! Particles among the own elements: their states for the sums over neighbours, and the sums.

use super::Blocks;
use crate::elements::particle::{COLUMNS, DENSITY, FORCE, STEP};
use crate::nodes::Nodes;
use crate::particles::{ParticleState, ParticleSums};
use crumple_math::row::xyz;

impl Blocks {
    /// Returns the own particles in ascending id, each with its block and its index in the block.
    pub fn particles(&self, nodes: &Nodes) -> Vec<(ParticleState, [usize; 2])> {
        let fluids = self.blocks.iter().enumerate().filter(|(_, b)| b.element.fluid().is_some());
        let mut all: Vec<(ParticleState, [usize; 2])> = fluids
            .flat_map(|(block, b)| (0..b.count).map(move |i| [block, i]))
            .map(|[block, i]| {
                let b = &self.blocks[block];
                let e = &self.elements[b.first + i];
                let [x, v] = [&nodes.x, &nodes.v].map(|rows| xyz(&rows[e.nodes[0] as usize]));
                let (id, part) = (e.record.id, u64::from(e.record.part));
                let density = b.state(i).at(DENSITY);
                (ParticleState { id, part, x, v, density }, [block, i])
            })
            .collect();
        all.sort_unstable_by_key(|(state, _)| state.id);
        all
    }

    /// Stores the sums of an own particle, where its element finds them.
    pub fn set_particle(&mut self, [block, i]: [usize; 2], sums: &ParticleSums) {
        let history = &mut self.blocks[block].history;
        let state = history.element(i);
        let mut columns: [f64; COLUMNS] = std::array::from_fn(|column| state.at(column));
        (columns[DENSITY], columns[STEP]) = (sums.density, sums.stable_dt);
        columns[FORCE..FORCE + 3].copy_from_slice(&sums.force);
        history.set(i, &columns);
    }
}
