//! Ghosts of particles in a step, and the sums over neighbours with them.
//!
//! Particles belong to workers by their boxes, as all elements do. In each step workers exchange
//! the boxes around their particles. A worker sends the particles within reach of the box of
//! another one, and later their new densities. So no ghost is ever missing, and no order of the
//! master is needed.

use crate::fem::blocks::Blocks;
use crate::fem::particles::{ParticleState, Particles};
use crate::nodes::Nodes;
use bytemuck::{Pod, Zeroable};
use crumple_proto::boxes::Aabb;
use crumple_proto::transport::{RankLost, Transport, exchange_with, gather_all};

/// Where the particles of a worker are, in a message.
#[derive(Clone, Copy, Pod, Zeroable)]
#[repr(C)]
struct WireExtent {
    min: [f64; 3],
    max: [f64; 3],
    /// Largest speed [length/time].
    speed: f64,
}

/// Computes densities and forces of the own particles, after a step of size `dt` [time]. All
/// workers call this together.
///
/// # Errors
/// A worker is gone.
pub fn sum_over_neighbours(
    comm: &mut dyn Transport,
    nodes: &Nodes,
    blocks: &mut Blocks,
    particles: &mut Particles,
    dt: f64,
) -> Result<(), RankLost> {
    let own = blocks.particles(nodes);
    particles.start(own.iter().map(|(state, _)| *state));
    let me = comm.rank() - 1;
    let (Aabb { min, max }, speed) = particles.bounds();
    let all = gather_all(comm, vec![WireExtent { min, max, speed }])?;
    let speed = all.iter().map(|w| w[0].speed).fold(0.0, f64::max);
    let reach = particles.reach(speed, dt);
    let boxes: Vec<Aabb> = all.iter().map(|w| Aabb { min: w[0].min, max: w[0].max }).collect();
    // The lower worker is first, so that both come to the same result.
    let are_near = |a: usize, b: usize| {
        let (low, high) = (&boxes[a.min(b)], &boxes[a.max(b)]);
        a != b && !low.is_empty() && !high.is_empty() && low.grown(reach).intersects(high)
    };
    let partners: Vec<bool> = (0..boxes.len()).map(|w| are_near(me, w)).collect();
    let offer = |w: usize| match partners[w] {
        true => particles.own_in(&boxes[w].grown(reach)),
        false => Vec::new(),
    };
    let offers: Vec<Vec<ParticleState>> = (0..boxes.len()).map(offer).collect();
    let ghosts = exchange_with(comm, offers.clone(), &partners)?;
    let others = || ghosts.iter().enumerate().filter(|(w, _)| *w != me);
    let arrived: Vec<ParticleState> = others().flat_map(|(_, list)| list).copied().collect();
    particles.find_candidates(&arrived, reach);
    particles.update_densities(dt);
    let news = offers.iter().map(|list| particles.densities(list).collect()).collect();
    let news: Vec<Vec<f64>> = exchange_with(comm, news, &partners)?;
    for (w, list) in others() {
        particles.set_densities(list, &news[w]);
    }
    for (sums, (_, place)) in particles.sums().zip(&own) {
        blocks.set_particle(*place, &sums);
    }
    Ok(())
}
