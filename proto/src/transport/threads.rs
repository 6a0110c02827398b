//! Ranks as threads of one process, with a channel for every ordered pair of ranks.

use super::rest::Rest;
use super::wait::{Patience, WaitClock};
use super::{RankLost, Tag, Traffic, Transport};
use std::collections::VecDeque;
use std::sync::mpsc::{Receiver, Sender, TryRecvError, channel};
use std::time::Duration;

type TaggedWords = (Tag, Vec<u64>);

/// Communication of one rank. Buffers of received messages are reused for sending.
pub struct Threads {
    rank: usize,
    to: Vec<Sender<TaggedWords>>,
    from: Vec<Receiver<TaggedWords>>,
    early: Vec<VecDeque<TaggedWords>>,
    pool: Vec<Vec<u64>>,
    wait_cpu: Duration,
    traffic: Traffic,
    /// Time for which a waiting rank polls an empty channel before it leaves its core to others.
    patience: Patience,
    /// How it does so; none if ranks share cores: it sleeps at once.
    rest: Option<Rest>,
}

/// Number of polls between two readings of the clock.
const LOOKS: u32 = 64;
/// Largest number of buffers kept for reuse.
const POOL: usize = 64;

/// Returns connected communications for `size` ranks, each of which computes with one thread.
pub fn connect(size: usize) -> Vec<Threads> {
    connect_teams(size, 1)
}

/// Returns connected communications for `size` ranks: the master, and workers that each compute
/// with `threads` threads.
pub fn connect_teams(size: usize, threads: usize) -> Vec<Threads> {
    let mut senders: Vec<Vec<Sender<TaggedWords>>> = (0..size).map(|_| Vec::new()).collect();
    let mut receivers: Vec<Vec<Receiver<TaggedWords>>> = (0..size).map(|_| Vec::new()).collect();
    for sender in &mut senders {
        for receiver in &mut receivers {
            let (tx, rx) = channel();
            sender.push(tx);
            receiver.push(rx);
        }
    }
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    // The master rarely works.
    let has_core = size.saturating_sub(1) * threads <= cores;
    let ends = senders.into_iter().zip(receivers).enumerate();
    ends.map(|(rank, (to, from))| Threads {
        rank,
        to,
        from,
        early: vec![VecDeque::new(); size],
        pool: Vec::new(),
        wait_cpu: Duration::ZERO,
        traffic: Traffic::default(),
        patience: Patience::new(has_core),
        rest: has_core.then(Rest::new),
    })
    .collect()
}

impl Threads {
    fn deliver(&mut self, parcel: Vec<u64>, words: &mut Vec<u64>) {
        let old = std::mem::replace(words, parcel);
        if old.capacity() > 0 && self.pool.len() < POOL {
            self.pool.push(old);
        }
    }
}

impl Transport for Threads {
    fn rank(&self) -> usize {
        self.rank
    }

    fn size(&self) -> usize {
        self.to.len()
    }

    fn send(&mut self, to: usize, tag: Tag, words: &[u64]) -> Result<(), RankLost> {
        let mut parcel = self.pool.pop().unwrap_or_default();
        parcel.clear();
        parcel.extend_from_slice(words);
        self.traffic.messages += 1;
        self.traffic.bytes += 8 * words.len() as u64;
        self.to[to].send((tag, parcel)).map_err(|_| RankLost { rank: to })
    }

    fn try_recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<bool, RankLost> {
        if let Some(i) = self.early[from].iter().position(|p| p.0 == tag) {
            let parcel = self.early[from].remove(i).map_or_else(Vec::new, |p| p.1);
            self.deliver(parcel, words);
            return Ok(true);
        }
        loop {
            match self.from[from].try_recv() {
                Ok((t, parcel)) if t == tag => {
                    self.deliver(parcel, words);
                    return Ok(true);
                }
                Ok(other) => self.early[from].push_back(other),
                Err(TryRecvError::Empty) => return Ok(false),
                Err(TryRecvError::Disconnected) => return Err(RankLost { rank: from }),
            }
        }
    }

    fn recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<(), RankLost> {
        if self.try_recv(from, tag, words)? {
            return Ok(());
        }
        let (mut clock, patience) = (WaitClock::start(), self.patience.start());
        while clock.elapsed() < patience {
            for _ in 0..LOOKS {
                std::hint::spin_loop();
                if self.try_recv(from, tag, words)? {
                    self.patience.record_success(clock.elapsed());
                    self.wait_cpu += clock.cpu();
                    return Ok(());
                }
            }
        }
        self.patience.record_failure();
        clock.before_sleep();
        // To yield is faster than to sleep and be woken.
        while self.rest.as_ref().is_some_and(|rest| rest.yields(clock.elapsed())) {
            self.rest.iter_mut().for_each(Rest::yield_core);
            if self.try_recv(from, tag, words)? {
                self.wait_cpu += clock.cpu();
                return Ok(());
            }
        }
        self.rest.iter_mut().for_each(Rest::record_sleep);
        let parcel = loop {
            match self.from[from].recv() {
                Ok((t, parcel)) if t == tag => break Ok(parcel),
                Ok(other) => self.early[from].push_back(other),
                Err(_) => break Err(RankLost { rank: from }),
            }
        };
        self.wait_cpu += clock.cpu();
        self.deliver(parcel?, words);
        Ok(())
    }

    fn wait_cpu(&self) -> Duration {
        self.wait_cpu
    }

    fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn one_clock(&self) -> bool {
        true
    }

    fn name(&self) -> &'static str {
        "threads"
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tags_keep_their_own_order_and_a_lost_rank_is_an_error() {
        let mut ends = connect(2);
        let (mut b, mut a) = (ends.pop().unwrap(), ends.pop().unwrap());
        a.send(1, Tag::Order, &[1]).unwrap();
        a.send(1, Tag::Sweep, &[2, 2]).unwrap();
        a.send(1, Tag::Order, &[3]).unwrap();
        drop(a);
        let mut w = Vec::new();
        b.recv(0, Tag::Sweep, &mut w).unwrap();
        assert_eq!(w, [2, 2]);
        b.recv(0, Tag::Order, &mut w).unwrap();
        assert_eq!(w, [1]);
        b.recv(0, Tag::Order, &mut w).unwrap();
        assert_eq!(w, [3]);
        assert_eq!(b.recv(0, Tag::Order, &mut w), Err(RankLost { rank: 0 }));
    }
}
