//! Distributed convergence detection for workers that are connected by shared pairs, directly or
//! through other workers.
//!
//! Information travels by one worker per round. So all workers have converged after d + 1 rounds
//! without a change on any of them, where d is the largest distance between two workers. The
//! workers find this distance in the same rounds: each worker sends to its neighbours the list
//! of its own neighbours, and all lists that it has newly received.

use crumple_proto::transport::Mailbox;
use std::collections::{BTreeMap, VecDeque};

/// Number of rounds since the last change, and the graph of workers that share pairs.
#[derive(Debug, Default)]
pub struct ConvergenceDetector {
    rounds: u64,
    /// Neighbours of each known worker, without the worker itself; all by worker number.
    neighbours: BTreeMap<u64, Vec<u64>>,
    /// Workers whose neighbours have not been sent to other workers yet.
    fresh: Vec<u64>,
    /// Workers whose neighbours have been received in the current round.
    heard: Vec<u64>,
    /// Number of rounds without a change that is needed; `None` while the neighbours of a worker
    /// are unknown.
    enough: Option<u64>,
    /// Graph of the last step and the number of rounds that it needs. The graph rarely changes.
    last: (BTreeMap<u64, Vec<u64>>, u64),
}

impl ConvergenceDetector {
    /// Starts with worker `me` and its `neighbours`, with which it shares pairs; no other worker
    /// is known.
    pub fn start(&mut self, me: usize, neighbours: impl Iterator<Item = usize>) {
        let mine: Vec<u64> = neighbours.map(|w| w as u64).collect();
        // A worker without neighbours receives nothing.
        self.enough = mine.is_empty().then_some(1);
        self.neighbours = BTreeMap::from([(me as u64, mine)]);
        self.fresh = vec![me as u64];
        self.rounds = 0;
    }

    /// Resets the number of rounds, for example before changes of another kind.
    pub fn restart(&mut self) {
        self.rounds = 0;
    }

    /// Ends the own part of a round.
    pub fn record_change(&mut self, changed: bool) {
        self.rounds = if changed { 0 } else { self.rounds + 1 };
    }

    /// Writes the header of a message to a neighbour.
    pub fn write(&self, mail: &mut Mailbox) {
        mail.extend(&[self.rounds, self.fresh.len() as u64]);
        for w in &self.fresh {
            let theirs = &self.neighbours[w];
            mail.extend(&[*w, theirs.len() as u64]);
            mail.extend(theirs);
        }
    }

    /// Reads the header of a neighbour's message.
    pub fn read(&mut self, mail: &mut Mailbox) {
        let [rounds, count] = mail.take::<[u64; 2]>();
        self.rounds = self.rounds.min(rounds);
        for _ in 0..count {
            let [worker, neighbours] = mail.take::<[u64; 2]>();
            let theirs = mail.take_many::<u64>(neighbours as usize);
            self.neighbours.entry(worker).or_insert_with(|| {
                self.heard.push(worker);
                theirs.to_vec()
            });
        }
    }

    /// Ends a round after the messages of all neighbours have been read.
    pub fn end_round(&mut self) {
        std::mem::swap(&mut self.fresh, &mut self.heard);
        self.heard.clear();
        if self.enough.is_none()
            && self.neighbours.values().flatten().all(|w| self.neighbours.contains_key(w))
        {
            if self.neighbours != self.last.0 {
                let farthest =
                    |&w| distances(&self.neighbours, w).values().copied().max().unwrap_or(0);
                let enough = self.neighbours.keys().map(farthest).max().unwrap_or(0) + 1;
                self.last = (self.neighbours.clone(), enough);
            }
            self.enough = Some(self.last.1);
        }
    }

    /// Returns true if all workers have converged; it does so in the same round on all of them.
    pub fn has_converged(&self) -> bool {
        self.enough.is_some_and(|enough| self.rounds >= enough)
    }
}

/// Returns the number of rounds that information from a worker needs to reach each other worker.
pub fn distances(neighbours: &BTreeMap<u64, Vec<u64>>, from: u64) -> BTreeMap<u64, u64> {
    let mut distance = BTreeMap::from([(from, 0u64)]);
    let mut queue = VecDeque::from([from]);
    while let Some(w) = queue.pop_front() {
        let next = distance[&w] + 1;
        for &o in neighbours.get(&w).into_iter().flatten() {
            distance.entry(o).or_insert_with(|| {
                queue.push_back(o);
                next
            });
        }
    }
    distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    /// Simulates workers with these connections: `first` makes a change, its neighbours do so in
    /// the next round, and so on for `reach` rounds. Returns the round in which each worker
    /// detects convergence.
    fn rounds(edges: &[(usize, usize)], workers: usize, first: usize, reach: usize) -> Vec<usize> {
        let of = |w: usize| {
            let mut all: Vec<usize> = edges
                .iter()
                .filter_map(|&(a, b)| if a == w { Some(b) } else { (b == w).then_some(a) })
                .collect();
            all.sort_unstable();
            all.dedup();
            all.retain(|&o| o != w);
            all
        };
        let mut quiet: Vec<ConvergenceDetector> =
            (0..workers).map(|_| ConvergenceDetector::default()).collect();
        quiet.iter_mut().enumerate().for_each(|(w, q)| q.start(w, of(w).into_iter()));
        let mut over = vec![usize::MAX; workers];
        // Workers that make a change in this round.
        let mut wave = vec![first];
        for round in 0..4 * workers + reach {
            quiet.iter_mut().enumerate().for_each(|(w, q)| q.record_change(wave.contains(&w)));
            let message = |q: &ConvergenceDetector| {
                let mut mail = Mailbox::default();
                q.write(&mut mail);
                mail.push(77u64);
                mail
            };
            let sent: Vec<Mailbox> = quiet.iter().map(message).collect();
            for w in 0..workers {
                for o in of(w) {
                    let mut mail = sent[o].clone();
                    quiet[w].read(&mut mail);
                    assert_eq!(mail.rest::<u64>(), [77], "the rest of the message remains");
                }
                quiet[w].end_round();
                if quiet[w].has_converged() {
                    over[w] = over[w].min(round);
                }
            }
            wave = if round + 1 < reach {
                wave.iter().flat_map(|&w| of(w)).collect()
            } else {
                Vec::new()
            };
            wave.sort_unstable();
            wave.dedup();
        }
        over
    }

    proptest! {
        /// No worker detects convergence before the last change. Connected workers detect it in
        /// the same round, soon after the last change.
        #[test]
        fn all_end_together_after_the_last_change(
            edges in prop::collection::vec((0usize..9, 0usize..9), 0..20),
            first in 0usize..9,
            reach in 0usize..12,
        ) {
            let over = rounds(&edges, 9, first, reach);
            let mut group = vec![first];
            for _ in 0..9 {
                let more: Vec<usize> = edges
                    .iter()
                    .flat_map(|&(a, b)| [(a, b), (b, a)])
                    .filter(|(a, _)| group.contains(a))
                    .map(|(_, b)| b)
                    .collect();
                group.extend(more);
                group.sort_unstable();
                group.dedup();
            }
            let last = if group.len() > 1 { reach.max(1) } else { 1 };
            for &w in &group {
                prop_assert_eq!(over[w], over[first]);
                prop_assert!(over[w] + 1 >= last, "{} before {}", over[w], last);
                prop_assert!(over[w] <= last + 2 * group.len());
            }
            prop_assert!(over.iter().all(|&o| o < usize::MAX));
        }
    }
}
