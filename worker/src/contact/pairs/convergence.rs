//! When workers that have pairs in common, one with the next, know that nothing changes any more.
//!
//! News travels one worker per round. So all of them are quiet when nobody has changed anything for
//! as many rounds as the two that are farthest apart are from each other, and one more. How far
//! that is they learn in the same rounds: each tells its neighbours whom it has pairs in common
//! with, and what it has newly heard of others.

use std::collections::{BTreeMap, VecDeque};

/// Rounds since anything changed, and who has pairs in common with whom.
#[derive(Debug, Default)]
pub struct ConvergenceDetector {
    rounds: u64,
    /// Neighbours of each worker that is known, itself left out; both by number.
    neighbours: BTreeMap<u64, Vec<u64>>,
    /// Workers that others have not been told of yet.
    fresh: Vec<u64>,
    /// What has been heard in the round at hand.
    heard: Vec<u64>,
    /// Rounds that it takes; none while somebody's neighbours are not known.
    enough: Option<u64>,
    /// What was known in the end the last time, and how many rounds it takes: mostly the same
    /// again.
    last: (BTreeMap<u64, Vec<u64>>, u64),
}

impl ConvergenceDetector {
    /// Worker `me` has pairs in common with `neighbours` and knows of nobody else.
    pub fn start(&mut self, me: usize, neighbours: impl Iterator<Item = usize>) {
        let mine: Vec<u64> = neighbours.map(|w| w as u64).collect();
        // Alone there is nobody to hear from.
        self.enough = mine.is_empty().then_some(1);
        self.neighbours = BTreeMap::from([(me as u64, mine)]);
        self.fresh = vec![me as u64];
        self.rounds = 0;
    }

    /// A new round of changes, such as another kind of them.
    pub fn restart(&mut self) {
        self.rounds = 0;
    }

    /// Ends the own part of a round.
    pub fn record_change(&mut self, changed: bool) {
        self.rounds = if changed { 0 } else { self.rounds + 1 };
    }

    /// Leads a message to a neighbour.
    pub fn write(&self, words: &mut Vec<u64>) {
        words.extend([self.rounds, self.fresh.len() as u64]);
        for w in &self.fresh {
            let theirs = &self.neighbours[w];
            words.extend([*w, theirs.len() as u64]);
            words.extend(theirs);
        }
    }

    /// Takes what leads a neighbour's message off it.
    pub fn read<'a>(&mut self, words: &'a [u64]) -> &'a [u64] {
        self.rounds = self.rounds.min(words[0]);
        let mut rest = &words[2..];
        for _ in 0..words[1] {
            let (worker, theirs) = (rest[0], &rest[2..2 + rest[1] as usize]);
            self.neighbours.entry(worker).or_insert_with(|| {
                self.heard.push(worker);
                theirs.to_vec()
            });
            rest = &rest[2 + theirs.len()..];
        }
        rest
    }

    /// Ends a round in which all neighbours have been read.
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

    /// Whether all are quiet; they all say so in the same round.
    pub fn has_converged(&self) -> bool {
        self.enough.is_some_and(|enough| self.rounds >= enough)
    }
}

/// Rounds that news from a worker takes to each that it reaches.
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

    /// Among workers with these connections `first` changes something, in the next round its
    /// neighbours do, and so on for `reach` rounds; the round in which each says that all are
    /// quiet.
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
        // A wave of changes that starts at `first` and goes on from neighbour to neighbour for
        // `reach` rounds.
        let mut wave = vec![first];
        for round in 0..4 * workers + reach {
            quiet.iter_mut().enumerate().for_each(|(w, q)| q.record_change(wave.contains(&w)));
            let sent: Vec<Vec<u64>> = quiet
                .iter()
                .map(|q| {
                    let mut words = Vec::new();
                    q.write(&mut words);
                    words.push(77);
                    words
                })
                .collect();
            for w in 0..workers {
                of(w).into_iter().for_each(|o| {
                    assert_eq!(quiet[w].read(&sent[o]), [77], "what follows is left")
                });
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
        /// Nobody ends before the last change, and those that are connected end in the same round,
        /// soon after it.
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
