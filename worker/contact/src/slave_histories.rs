//! Pair histories of the slaves.

use crate::pairs::{Pair, PairHistory};

/// Pair histories in the order of the surface's slaves.
#[derive(Default)]
pub struct SlaveHistories {
    /// Start of each slave's run in `all`, and their end.
    start: Vec<u32>,
    /// For each slave the pairs of the last step first, then lost pairs, both ascending.
    all: Vec<PairHistory>,
    /// Indices of the slaves that have histories, ascending.
    having: Vec<u32>,
    /// Indices of the slaves that have got their first history since the near list was made or
    /// made up to date, ascending.
    having_first: Vec<u32>,
}

/// Order of the histories of a slave.
fn by_age_and_key(history: &PairHistory) -> impl Ord + use<> {
    (history.age > 0, history.name)
}

impl SlaveHistories {
    /// Sets the histories of the `slaves`, given as local nodes; `of` returns all histories of a
    /// node.
    pub fn renew(&mut self, slaves: &[u32], of: impl Fn(usize) -> Vec<PairHistory>) {
        self.all.clear();
        self.start.clear();
        self.having.clear();
        for (i, &slave) in (0..).zip(slaves) {
            let start = self.all.len();
            self.start.push(start as u32);
            self.all.extend(of(slave as usize).into_iter().filter(|m| m.name.is_node()));
            self.all[start..].sort_unstable_by_key(by_age_and_key);
            if self.all.len() > start {
                self.having.push(i);
            }
        }
        self.start.push(self.all.len() as u32);
    }

    /// Returns the histories of the slave with index `i`.
    #[inline]
    pub fn of_slave(&self, i: usize) -> &[PairHistory] {
        &self.all[self.start[i] as usize..self.start[i + 1] as usize]
    }

    /// Returns the indices of the slaves that have got their first history, ascending.
    pub fn with_first(&self) -> &[u32] {
        &self.having_first
    }

    /// Empties the list of the slaves that have got their first history.
    pub fn forget_first(&mut self) {
        self.having_first.clear();
    }

    /// Returns the bytes in use without the histories and without spare capacity.
    pub fn bytes(&self) -> usize {
        [&self.start, &self.having, &self.having_first].iter().map(|l| size_of_val(&l[..])).sum()
    }

    /// Stores the histories of the own pairs of a step, and those of lost pairs.
    pub fn store(&mut self, slaves: &[u32], pairs: &[Pair]) {
        let before = std::mem::take(&mut self.all);
        let having = std::mem::take(&mut self.having);
        let mut had = having.iter().map(|&i| i as usize).peekable();
        let mut own: Vec<&Pair> = pairs.iter().filter(|p| p.is_owned && p.key.is_node()).collect();
        // Pairs are in ascending order of ids, slaves in that of local indices.
        if !own.is_sorted_by_key(|p| p.nodes[0]) {
            own.sort_by_key(|p| p.nodes[0]);
        }
        let mut own = own.into_iter().peekable();
        // Most slaves have neither a pair nor a history. Their runs start where the next one does.
        let mut next = 0;
        loop {
            let paired =
                own.peek().map(|p| next + slaves[next..].partition_point(|&s| s < p.nodes[0]));
            let Some(i) = paired.into_iter().chain(had.peek().copied()).min() else { break };
            let old = self.start[i] as usize..self.start[i + 1] as usize;
            let start = self.all.len();
            self.start[next..=i].fill(start as u32);
            next = i + 1;
            while let Some(p) = own.next_if(|p| p.nodes[0] == slaves[i]) {
                self.all.push(p.to_history());
            }
            if had.next_if_eq(&i).is_none() {
                self.having_first.push(i as u32);
            }
            for m in &before[old] {
                if !self.all[start..].iter().any(|n| n.name == m.name) {
                    self.all.extend(m.after_loss());
                }
            }
            self.all[start..].sort_unstable_by_key(by_age_and_key);
            if self.all.len() > start {
                self.having.push(i as u32);
            }
        }
        self.start[next..].fill(self.all.len() as u32);
    }
}
