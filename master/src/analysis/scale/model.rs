//! Time of a step from counts, costs and a network. Pure arithmetic.
//!
//! Workers wait for each other before contact and after it. A step takes the largest time of
//! elements and nodes, and then as long as the worker that is slowest in the rest: search, contact,
//! a latency for each of its messages (including the rounds of the global reduction), and its bytes
//! over the bandwidth. These add up; no communication overlaps with work, as in
//! `deploy/efficiency.py`. Redecomposition, ties, field files and cache effects are not included.

use super::census::Count;
use super::kernels::Kernels;
use crumple_worker::parallel::pair_exchange::TrafficEstimate;

/// Network between any two workers.
#[derive(Clone, Copy, Debug)]
pub struct Network {
    /// Time of an empty message [s].
    pub latency: f64,
    /// Bandwidth [bytes/s].
    pub bandwidth: f64,
}

/// Cost of work and communication.
#[derive(Clone, Copy, Debug)]
pub struct CostModel<'a> {
    /// Costs on the machine.
    pub kernels: &'a Kernels,
    /// Network between machines.
    pub network: Network,
}

/// Step of a worker: times [s], and the messages and bytes that it sends.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct WorkerStep {
    /// Time of elements and nodes [s].
    pub elements: f64,
    /// Time of candidates and pairs [s].
    pub contact: f64,
    /// Time of the motion fit and of global searches [s].
    pub search: f64,
    /// Latency of the messages [s].
    pub latency: f64,
    /// Transfer time of the bytes [s].
    pub transfer: f64,
    /// Number of messages.
    pub messages: f64,
    /// Number of bytes.
    pub bytes: f64,
}

/// Step of all workers [s]. Useful time and losses add up to the total.
#[derive(Clone, Copy, Debug, Default)]
pub struct PredictedStep {
    /// Total time [s].
    pub total: f64,
    /// Time of one worker with the whole mesh over the number of workers [s].
    pub useful: f64,
    /// Lost time, in the order of [`LOSSES`] [s].
    pub lost: [f64; LOSSES.len()],
    /// Largest own work without contact, and that of the slowest worker in contact, without
    /// messages [s].
    pub own: f64,
    /// Largest number of messages and of bytes of a worker.
    pub messages: f64,
    /// See `messages`.
    pub bytes: f64,
}

/// Causes of lost time, compared with one worker that has the whole mesh.
pub const LOSSES: [&str; 5] = ["imbalance", "shared work", "search", "latency", "bytes"];

impl WorkerStep {
    /// Computes the step of a worker. `traffic` holds its messages and bytes without the exchange
    /// between partners in contact. `exchange` estimates that exchange; it is none for a single
    /// worker.
    pub fn new(
        count: &Count,
        traffic: [f64; 2],
        exchange: Option<TrafficEstimate>,
        costs: CostModel<'_>,
    ) -> Self {
        let (k, network) = (costs.kernels, costs.network);
        let units = |n: u64| n as f64;
        let elements: f64 = k.element.iter().zip(&count.lanes).map(|(s, &n)| s * units(n)).sum();
        let local = k.local[0] * units(count.slaves) + k.local[1] * units(count.near);
        let contact =
            k.contact[0] * units(count.slaves) + k.contact[1] * units(count.pairs + count.replicas);
        let partners = exchange.filter(|_| count.partners > 0);
        let longer = partners.filter(|_| k.sweeps > 0.0).map_or(1.0, |e| e.sweeps / k.sweeps);
        let [mut messages, mut bytes] = traffic;
        if let Some(e) = partners {
            messages += units(count.partners) * e.messages;
            messages += units(count.phase_messages) * e.phased_sweeps;
            bytes += 8.0 * (units(count.partners) * e.words[0] + units(count.copies) * e.words[1]);
        }
        let surface = units(count.segments + count.exterior_segments + count.slaves);
        let motion = if exchange.is_some() { k.motion * units(count.held) } else { 0.0 };
        Self {
            elements: elements + k.node * units(count.held),
            contact: local + contact * longer,
            search: motion
                + k.watch * units(count.held + count.exterior_nodes)
                + k.search * surface,
            latency: messages * network.latency,
            transfer: bytes / network.bandwidth,
            messages,
            bytes,
        }
    }

    /// Returns the time of elements, nodes, candidates and pairs [s].
    pub fn kernels(&self) -> f64 {
        self.elements + self.contact
    }

    /// Returns the total time [s].
    pub fn total(&self) -> f64 {
        self.elements + self.rest()
    }

    /// Returns the time of contact with its search, and of all messages [s].
    fn rest(&self) -> f64 {
        self.contact + self.search + self.latency + self.transfer
    }
}

impl PredictedStep {
    /// Computes the step of all workers. `alone` is the time of one worker with the whole mesh
    /// [s], for kernels and search.
    pub fn new(works: &[WorkerStep], alone: [f64; 2]) -> Self {
        let n = works.len() as f64;
        let by_rest = |a: &&WorkerStep, b: &&WorkerStep| a.rest().total_cmp(&b.rest());
        let Some(slowest) = works.iter().max_by(by_rest) else { return Self::default() };
        let mean = |f: fn(&WorkerStep) -> f64| works.iter().map(f).sum::<f64>() / n;
        let most = |f: fn(&WorkerStep) -> f64| works.iter().map(f).fold(0.0, f64::max);
        let (kernels, search) = (mean(WorkerStep::kernels), mean(|w| w.search));
        let elements = most(|w| w.elements);
        let own = elements + slowest.contact + slowest.search;
        Self {
            total: elements + slowest.rest(),
            useful: (alone[0] + alone[1]) / n,
            lost: [
                own - kernels - search,
                kernels - alone[0] / n,
                search - alone[1] / n,
                slowest.latency,
                slowest.transfer,
            ],
            own,
            messages: most(|w| w.messages),
            bytes: most(|w| w.bytes),
        }
    }

    /// Returns T_1 / (N T_N) for a mesh of fixed size.
    pub fn efficiency(&self) -> f64 {
        self.useful / self.total
    }

    /// Returns the index of the largest loss.
    pub fn first_limit(&self) -> usize {
        (0..LOSSES.len()).max_by(|&a, &b| self.lost[a].total_cmp(&self.lost[b])).unwrap_or(0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn kernels() -> Kernels {
        Kernels {
            element: vec![1e-7],
            node: 2e-8,
            watch: 1e-9,
            local: [0.0, 5e-8],
            contact: [0.0, 1e-6],
            ..Kernels::default()
        }
    }

    fn count(elements: u64, near: u64) -> Count {
        Count { elements, lanes: vec![elements], held: elements, near, ..Count::default() }
    }

    /// Useful time and losses add up, and each cause appears under its own name.
    #[test]
    fn losses_add_up_and_are_named() {
        let kernels = kernels();
        let costs =
            |latency| CostModel { kernels: &kernels, network: Network { latency, bandwidth: 1e9 } };
        let alone = WorkerStep::new(&count(800, 40), [0.0; 2], None, costs(0.0));
        assert!(
            (alone.kernels() - (800.0 * 1.2e-7 + 40.0 * 5e-8)).abs() < 1e-18
                && alone.messages == 0.0
        );
        let together = |counts: &[Count], traffic, latency| {
            let exchange = Some(TrafficEstimate::default());
            let works: Vec<WorkerStep> = counts
                .iter()
                .map(|c| WorkerStep::new(c, traffic, exchange, costs(latency)))
                .collect();
            let step = PredictedStep::new(&works, [alone.kernels(), alone.search]);
            assert!(
                (step.useful + step.lost.iter().sum::<f64>() - step.total).abs()
                    < 1e-12 * step.total
            );
            step
        };
        let even = together(&[count(400, 20), count(400, 20)], [0.0; 2], 0.0);
        assert!((even.efficiency() - 1.0).abs() < 1e-12);
        let uneven = together(&[count(500, 20), count(300, 20)], [0.0; 2], 0.0);
        assert_eq!((LOSSES[uneven.first_limit()], uneven.efficiency() < 0.81), ("imbalance", true));
        // Two workers of the same time: each waits for the other once.
        let apart = together(&[count(440, 0), count(400, 96)], [0.0; 2], 0.0);
        let own = 440.0 * 1.2e-7 + 96.0 * 5e-8 + 400.0 * 1e-9; // the last is the watch over nodes
        assert!((apart.own - own).abs() < 1e-18, "{}", apart.own);
        assert_eq!(LOSSES[apart.first_limit()], "imbalance");
        let shared = Count { held: 450, ..count(400, 20) };
        let sharing = together(&[shared.clone(), shared], [0.0; 2], 0.0);
        assert_eq!(LOSSES[sharing.first_limit()], "shared work");
        let talking = together(&[count(400, 20), count(400, 20)], [5.0, 100.0], 2e-6);
        let round_off = 1e-20;
        assert!(
            (talking.lost[3] - 1e-5).abs() < round_off
                && (talking.lost[4] - 1e-7).abs() < round_off
        );
        assert_eq!(LOSSES[talking.first_limit()], "latency");
    }
}
