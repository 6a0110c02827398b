//! Collective operations of the workers over any transport. The master takes no part.

use super::{RankLost, Tag, Transport, words_of};
use bytemuck::Pod;

/// Sends `parcels[w]` to every other worker w and returns the items that each of them sent here.
/// Worker w is rank w + 1; the entry of this worker is returned unchanged.
///
/// # Errors
/// A worker is gone.
pub fn exchange_all<T: Pod>(
    comm: &mut dyn Transport,
    mut parcels: Vec<Vec<T>>,
) -> Result<Vec<Vec<T>>, RankLost> {
    const { assert!(words_of::<T>() > 0) };
    let me = comm.rank() - 1;
    let others = |parcels: &[Vec<T>]| (0..parcels.len()).filter(move |&w| w != me);
    for w in others(&parcels) {
        comm.send(w + 1, Tag::Renewal, bytemuck::cast_slice(&parcels[w]))?;
    }
    let mut words = Vec::new();
    for w in others(&parcels) {
        comm.recv(w + 1, Tag::Renewal, &mut words)?;
        parcels[w].clear();
        parcels[w].extend_from_slice(bytemuck::cast_slice(&words));
    }
    Ok(parcels)
}

/// Sends the same items to every other worker, and returns the items of all workers, this one
/// included.
///
/// # Errors
/// A worker is gone.
pub fn gather_all<T: Pod>(comm: &mut dyn Transport, mine: Vec<T>) -> Result<Vec<Vec<T>>, RankLost> {
    let workers = comm.size() - 1;
    exchange_all(comm, vec![mine; workers])
}

/// Maximum over all workers that begins early and finishes late, so that it overlaps
/// computation. It uses dissemination (Hensgen, Finkel & Manber 1988): ceil(log2 P) rounds, in
/// which a value may count twice.
#[derive(Debug)]
pub struct MaxReduction {
    tag: Tag,
    values: Vec<f64>,
    buffer: Vec<u64>,
}

impl MaxReduction {
    /// Builds a reduction of `width` numbers. No other exchange with this tag may be in
    /// progress at the same time.
    pub fn new(width: usize, tag: Tag) -> Self {
        Self { tag, values: vec![f64::NEG_INFINITY; width], buffer: Vec::new() }
    }

    /// Returns the number of rounds for `workers` workers; each worker sends one message per
    /// round.
    pub fn hops(workers: usize) -> u32 {
        workers.next_power_of_two().ilog2()
    }

    /// Sets this worker's values and sends the first round.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn begin(&mut self, comm: &mut dyn Transport, values: &[f64]) -> Result<(), RankLost> {
        self.values.copy_from_slice(values);
        if comm.size() > 2 { self.send(comm, 1) } else { Ok(()) }
    }

    /// Completes the rounds and returns the maxima, equal on every worker.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn finish(&mut self, comm: &mut dyn Transport) -> Result<&[f64], RankLost> {
        let (workers, me) = (comm.size() - 1, comm.rank() - 1);
        let mut hop = 1;
        while hop < workers {
            if hop > 1 {
                self.send(comm, hop)?;
            }
            comm.recv((me + workers - hop) % workers + 1, self.tag, &mut self.buffer)?;
            for (v, &o) in self.values.iter_mut().zip(&self.buffer) {
                *v = v.max(f64::from_bits(o));
            }
            hop *= 2;
        }
        Ok(&self.values)
    }

    fn send(&self, comm: &mut dyn Transport, hop: usize) -> Result<(), RankLost> {
        let (workers, me) = (comm.size() - 1, comm.rank() - 1);
        comm.send((me + hop) % workers + 1, self.tag, bytemuck::cast_slice(&self.values))
    }
}

/// Returns the rounds of a sum in which worker `me` (0-based) takes part, as one bit each. The
/// lowest bit of `me` is the round in which it sends its sum to the worker without this bit.
fn rounds_of_sum(me: usize, workers: usize) -> Vec<usize> {
    let levels = (0..MaxReduction::hops(workers)).map(|level| 1 << level);
    levels.take_while(|bit| me & (bit - 1) == 0).collect()
}

/// Returns the number of messages that worker `me` (0-based) sends in a sum over all workers.
pub fn messages_of_sum(me: usize, workers: usize) -> usize {
    let sends = |bit: &usize| me & bit != 0 || me + bit < workers;
    rounds_of_sum(me, workers).into_iter().filter(sends).count()
}

/// Adds the integers of all workers, element by element; `values` contains the sums on every
/// worker afterwards. The sums go up a binomial tree and down again: twice ceil(log2 P) rounds.
/// Sums wrap around. No other exchange with this tag may be in progress.
///
/// # Errors
/// A worker is gone.
pub fn sum_all(comm: &mut dyn Transport, tag: Tag, values: &mut [i64]) -> Result<(), RankLost> {
    let (workers, me) = (comm.size() - 1, comm.rank() - 1);
    let mut buffer = Vec::new();
    let up = rounds_of_sum(me, workers);
    for bit in &up {
        if me & bit != 0 {
            comm.send(me - bit + 1, tag, bytemuck::cast_slice(values))?;
        } else if me + bit < workers {
            comm.recv(me + bit + 1, tag, &mut buffer)?;
            values.iter_mut().zip(&buffer).for_each(|(v, &o)| *v = v.wrapping_add(o as i64));
        }
    }
    for bit in up.iter().rev() {
        if me & bit != 0 {
            comm.recv(me - bit + 1, tag, &mut buffer)?;
            values.copy_from_slice(bytemuck::cast_slice(&buffer));
        } else if me + bit < workers {
            comm.send(me + bit + 1, tag, bytemuck::cast_slice(values))?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::threads::{Threads, connect};
    use super::*;

    /// Returns the result of `run` on each of `workers` workers.
    fn on_all<T: Send + 'static>(workers: usize, run: fn(&mut Threads) -> T) -> Vec<T> {
        let mut ends = connect(workers + 1);
        let _master = ends.remove(0);
        let start = |mut end: Threads| std::thread::spawn(move || run(&mut end));
        let threads: Vec<_> = ends.into_iter().map(start).collect();
        threads.into_iter().map(|t| t.join().unwrap()).collect()
    }

    #[test]
    fn every_worker_gets_the_maximum_for_any_number_of_workers() {
        for workers in 1..=7 {
            let all = on_all(workers, |end| {
                let me = end.rank() as f64;
                let mut max = MaxReduction::new(2, Tag::Maximum);
                max.begin(end, &[me, -me]).unwrap();
                max.finish(end).unwrap().to_vec()
            });
            assert_eq!(all, vec![[workers as f64, -1.0]; workers]);
        }
    }

    #[test]
    fn every_worker_gets_the_sum_for_any_number_of_workers() {
        for workers in 1..=9 {
            let all = on_all(workers, |end| {
                let mut values = [end.rank() as i64, -1, i64::MAX];
                sum_all(end, Tag::Settled, &mut values).unwrap();
                values
            });
            let n = workers as i64;
            assert_eq!(all, vec![[n * (n + 1) / 2, -n, i64::MAX.wrapping_mul(n)]; workers]);
        }
    }
}
