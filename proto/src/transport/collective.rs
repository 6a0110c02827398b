//! Collective operations of the workers over any transport. The master takes no part.

use super::{Mailbox, RankLost, Tag, Transport, words_of};
use bytemuck::Pod;

/// Sends `parcels[w]` to every other worker w for which it is not empty, and returns the items
/// that each of them sent here. Worker w is rank w + 1; the entry of this worker is returned
/// unchanged.
/// Each worker first learns who sends to it (Attaway et al. 1998, figure 5), unless all to all
/// takes no more messages.
///
/// # Errors
/// A worker is gone.
pub fn exchange_all<T: Pod>(
    comm: &mut dyn Transport,
    parcels: Vec<Vec<T>>,
) -> Result<Vec<Vec<T>>, RankLost> {
    let workers = comm.size() - 1;
    let sends: Vec<bool> = match is_dense(workers) {
        true => vec![true; workers],
        false => parcels.iter().map(|parcel| !parcel.is_empty()).collect(),
    };
    let receives = if is_dense(workers) { sends.clone() } else { transpose(comm, &sends)? };
    exchange(comm, parcels, &sends, &receives)
}

/// Sends `parcels[w]` to every other worker w with `partners[w]`, and returns the items that each
/// of them sent here. Two workers are partners of each other or both are not; then neither sends.
/// The entry of this worker is returned unchanged.
///
/// # Errors
/// A worker is gone.
pub fn exchange_with<T: Pod>(
    comm: &mut dyn Transport,
    parcels: Vec<Vec<T>>,
    partners: &[bool],
) -> Result<Vec<Vec<T>>, RankLost> {
    exchange(comm, parcels, partners, partners)
}

fn exchange<T: Pod>(
    comm: &mut dyn Transport,
    mut parcels: Vec<Vec<T>>,
    sends: &[bool],
    receives: &[bool],
) -> Result<Vec<Vec<T>>, RankLost> {
    const { assert!(words_of::<T>() > 0) };
    let me = comm.rank() - 1;
    let others = || (0..sends.len()).filter(move |&w| w != me);
    for w in others().filter(|&w| sends[w]) {
        comm.send(w + 1, Tag::Renewal, bytemuck::cast_slice(&parcels[w]))?;
    }
    let mut words = Vec::new();
    for w in others() {
        parcels[w].clear();
        if receives[w] {
            comm.recv(w + 1, Tag::Renewal, &mut words)?;
            parcels[w].extend_from_slice(bytemuck::cast_slice(&words));
        }
    }
    Ok(parcels)
}

/// Returns true if a message from each worker to each other one takes no more messages than the
/// rounds that find out who sends.
fn is_dense(workers: usize) -> bool {
    workers <= MaxReduction::hops(workers) as usize + 1
}

/// Returns for each worker w whether its flag of this worker is set; `flags[w]` is the flag of this
/// worker for w. In ceil(log2 P) rounds each worker sends half of the flags that it has (index
/// algorithm of Bruck et al. 1997, IEEE Trans. Parallel Distrib. Syst. 8, section 3).
fn transpose(comm: &mut dyn Transport, flags: &[bool]) -> Result<Vec<bool>, RankLost> {
    let (workers, me) = (flags.len(), comm.rank() - 1);
    // Flag i is for the worker i places after its present holder.
    let mut held: Vec<bool> = (0..workers).map(|i| flags[(me + i) % workers]).collect();
    let mut words = Vec::new();
    let mut hop = 1;
    while hop < workers {
        let moved = || (0..workers).filter(|i| i & hop != 0);
        let mut out = vec![0_u64; moved().count().div_ceil(64)];
        let set = moved().enumerate().filter(|&(_, i)| held[i]);
        set.for_each(|(bit, _)| out[bit / 64] |= 1 << (bit % 64));
        comm.send((me + hop) % workers + 1, Tag::Renewal, &out)?;
        comm.recv((me + workers - hop) % workers + 1, Tag::Renewal, &mut words)?;
        for (bit, i) in moved().enumerate() {
            held[i] = words[bit / 64] >> (bit % 64) & 1 == 1;
        }
        hop *= 2;
    }
    Ok((0..workers).map(|w| held[(me + workers - w) % workers]).collect())
}

/// Returns the items of all workers, this one included. In ceil(log2 P) rounds each worker passes
/// on the items that it has (concatenation algorithm of Bruck et al. 1997).
///
/// # Errors
/// A worker is gone.
pub fn gather_all<T: Pod>(comm: &mut dyn Transport, mine: Vec<T>) -> Result<Vec<Vec<T>>, RankLost> {
    const { assert!(words_of::<T>() > 0) };
    let (workers, me) = (comm.size() - 1, comm.rank() - 1);
    // List i is that of the worker i places after this one.
    let mut held: Vec<Vec<T>> = vec![mine];
    while held.len() < workers {
        let hop = held.len();
        let mut mail = Mailbox::default();
        for list in &held[..hop.min(workers - hop)] {
            mail.push(list.len() as u64);
            mail.extend(list);
        }
        mail.send(comm, (me + workers - hop) % workers, Tag::Renewal)?;
        mail.receive(comm, (me + hop) % workers, Tag::Renewal)?;
        while !mail.is_read() {
            let count = mail.take::<u64>() as usize;
            held.push(mail.take_many(count).to_vec());
        }
    }
    held.rotate_right(me);
    Ok(held)
}

/// Returns the numbers of messages and words that worker `me` (0-based) sends in [`gather_all`],
/// if the items of each worker have these numbers of words.
pub fn traffic_of_gather(me: usize, words: &[usize]) -> [usize; 2] {
    let (workers, mut held, mut sent) = (words.len(), 1, [0; 2]);
    while held < workers {
        let lists = held.min(workers - held);
        let of_lists = (0..lists).map(|i| 1 + words[(me + i) % workers]);
        sent = [sent[0] + 1, sent[1] + of_lists.sum::<usize>()];
        held += lists;
    }
    sent
}

/// Maximum over all workers that begins early and finishes late, so that it overlaps
/// computation. It uses dissemination (Hensgen, Finkel & Manber 1988): ceil(log2 P) rounds, in
/// which a value may count twice.
#[derive(Debug)]
pub struct MaxReduction {
    tag: Tag,
    values: Vec<f64>,
    buffer: Vec<u64>,
    /// True if all rounds are over.
    is_complete: bool,
}

impl MaxReduction {
    /// Builds a reduction of `width` numbers. No other exchange with this tag may be in
    /// progress at the same time.
    pub fn new(width: usize, tag: Tag) -> Self {
        Self { tag, values: vec![f64::NEG_INFINITY; width], buffer: Vec::new(), is_complete: true }
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
        self.is_complete = false;
        if comm.size() > 2 { self.send(comm, 1) } else { Ok(()) }
    }

    /// Completes the rounds and returns the maxima, equal on every worker.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn finish(&mut self, comm: &mut dyn Transport) -> Result<&[f64], RankLost> {
        self.complete(comm)?;
        Ok(&self.values)
    }

    /// Completes the rounds. [`Self::finish`] then does not wait for other workers, and they do not
    /// wait for this one.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn complete(&mut self, comm: &mut dyn Transport) -> Result<(), RankLost> {
        if std::mem::replace(&mut self.is_complete, true) {
            return Ok(());
        }
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
        Ok(())
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
/// worker afterwards. Sums wrap around. No other exchange with this tag may be in progress.
///
/// # Errors
/// A worker is gone.
pub fn sum_all(comm: &mut dyn Transport, tag: Tag, values: &mut [i64]) -> Result<(), RankLost> {
    let members: Vec<usize> = (0..comm.size() - 1).collect();
    sum_among(comm, tag, &members, values)
}

/// Adds integers as [`sum_all`], among the workers `members` (0-based, ascending). Only they call
/// it.
///
/// # Errors
/// A worker is gone.
pub fn sum_among(
    comm: &mut dyn Transport,
    tag: Tag,
    members: &[usize],
    values: &mut [i64],
) -> Result<(), RankLost> {
    combine(comm, tag, members, bytemuck::cast_slice_mut(values), u64::wrapping_add)
}

/// Returns the maximum of a number, which is not NaN, among the workers `members` (0-based,
/// ascending). Only they call it. No other exchange with this tag may be in progress.
///
/// # Errors
/// A worker is gone.
pub fn max_among(
    comm: &mut dyn Transport,
    tag: Tag,
    members: &[usize],
    value: f64,
) -> Result<f64, RankLost> {
    let mut words = [value.to_bits()];
    let larger = |a, b| f64::from_bits(a).max(f64::from_bits(b)).to_bits();
    combine(comm, tag, members, &mut words, larger)?;
    Ok(f64::from_bits(words[0]))
}

/// Combines the words of the workers `members` one by one. They go up a binomial tree and down
/// again: twice ceil(log2 P) rounds. The order depends on the number of members, so `with` must be
/// commutative and associative to the last bit.
fn combine(
    comm: &mut dyn Transport,
    tag: Tag,
    members: &[usize],
    values: &mut [u64],
    with: impl Fn(u64, u64) -> u64,
) -> Result<(), RankLost> {
    let (count, worker) = (members.len(), comm.rank() - 1);
    let me = members.binary_search(&worker).expect("only members take part");
    let rank = |place: usize| members[place] + 1;
    let mut buffer = Vec::new();
    let up = rounds_of_sum(me, count);
    for bit in &up {
        if me & bit != 0 {
            comm.send(rank(me - bit), tag, values)?;
        } else if me + bit < count {
            comm.recv(rank(me + bit), tag, &mut buffer)?;
            values.iter_mut().zip(&buffer).for_each(|(v, &o)| *v = with(*v, o));
        }
    }
    for bit in up.iter().rev() {
        if me & bit != 0 {
            comm.recv(rank(me - bit), tag, &mut buffer)?;
            values.copy_from_slice(&buffer);
        } else if me + bit < count {
            comm.send(rank(me + bit), tag, values)?;
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

    /// Workers send parcels of any length, some of them empty, to workers that they choose.
    #[test]
    fn parcels_arrive_and_empty_ones_are_not_sent() {
        for workers in 1..=9 {
            let all = on_all(workers, |end| {
                let (workers, me) = (end.size() - 1, end.rank() - 1);
                let parcel = |to| vec![(10 * me + to) as u64; sent(me, to)];
                let arrived = exchange_all(end, (0..workers).map(parcel).collect()).unwrap();
                (arrived, end.traffic().messages as usize)
            });
            for (me, (arrived, messages)) in all.into_iter().enumerate() {
                for (from, parcel) in arrived.iter().enumerate() {
                    assert_eq!(*parcel, vec![(10 * from + me) as u64; sent(from, me)]);
                }
                let others = (0..workers).filter(|&to| to != me);
                let wanted = match workers {
                    1..=3 => workers - 1,
                    _ => {
                        let rounds = MaxReduction::hops(workers) as usize;
                        rounds + others.filter(|&to| sent(me, to) > 0).count()
                    }
                };
                assert_eq!(messages, wanted, "{me} of {workers}");
            }
        }

        fn sent(from: usize, to: usize) -> usize {
            (3 * from + 5 * to) % 4
        }
    }

    #[test]
    fn partners_exchange_parcels_and_others_nothing() {
        let all = on_all(5, |end| {
            let me = end.rank() - 1;
            let partners = std::array::from_fn::<_, 5, _>(|w| (w + me) % 2 == 1);
            let arrived = exchange_with(end, vec![vec![me as u64]; 5], &partners).unwrap();
            (arrived, end.traffic().messages)
        });
        for (me, (arrived, messages)) in all.into_iter().enumerate() {
            let partner = |w: usize| (w + me) % 2 == 1;
            for (w, parcel) in arrived.iter().enumerate() {
                let is_known = w == me || partner(w);
                assert_eq!(*parcel, if is_known { vec![w as u64] } else { vec![] });
            }
            assert_eq!(messages as usize, (0..5).filter(|&w| partner(w)).count());
        }
    }

    #[test]
    fn every_worker_gets_the_lists_of_all_in_few_messages() {
        for workers in 1..=9 {
            let all = on_all(workers, |end| {
                let me = end.rank() - 1;
                let lists = gather_all(end, vec![[me as u64, 7]; me % 3]).unwrap();
                (lists, end.traffic().messages as u32)
            });
            let wanted: Vec<_> = (0..workers).map(|w| vec![[w as u64, 7]; w % 3]).collect();
            for (lists, messages) in all {
                assert_eq!(lists, wanted, "{workers} workers");
                assert_eq!(messages, MaxReduction::hops(workers), "{workers} workers");
            }
        }
    }

    #[test]
    fn the_traffic_of_a_gather_is_known() {
        for workers in 1..=9 {
            let words = |w: usize| 2 * (w % 3);
            let all = on_all(workers, |end| {
                let me = end.rank() - 1;
                gather_all(end, vec![[me as u64, 7]; me % 3]).unwrap();
                [end.traffic().messages, end.traffic().bytes / 8].map(|n| n as usize)
            });
            let lengths: Vec<usize> = (0..workers).map(words).collect();
            for (me, sent) in all.into_iter().enumerate() {
                assert_eq!(sent, traffic_of_gather(me, &lengths), "{me} of {workers}");
            }
        }
    }

    /// Every other worker takes part; the others send and receive nothing.
    #[test]
    fn members_get_their_sum_and_maximum() {
        for workers in 1..=9 {
            let all = on_all(workers, |end| {
                let members: Vec<usize> = (0..end.size() - 1).step_by(2).collect();
                let mut values = [end.rank() as i64, 1];
                let mut largest = 0.0;
                if members.contains(&(end.rank() - 1)) {
                    sum_among(end, Tag::Settled, &members, &mut values).unwrap();
                    let mine = -(end.rank() as f64);
                    largest = max_among(end, Tag::Settled, &members, mine).unwrap();
                }
                (values, largest, end.traffic().messages as usize)
            });
            let members: Vec<usize> = (0..workers).step_by(2).collect();
            let sum = members.iter().map(|m| *m as i64 + 1).sum();
            for (w, (values, largest, messages)) in all.into_iter().enumerate() {
                match members.binary_search(&w) {
                    Ok(place) => {
                        assert_eq!((values, largest), ([sum, members.len() as i64], -1.0));
                        assert_eq!(messages, 2 * messages_of_sum(place, members.len()));
                    }
                    Err(_) => assert_eq!((values, messages), ([w as i64 + 1, 1], 0)),
                }
            }
        }
    }

    #[test]
    fn every_worker_gets_the_maximum_for_any_number_of_workers() {
        for workers in 1..=7 {
            let all = on_all(workers, |end| {
                let me = end.rank() as f64;
                let mut max = MaxReduction::new(2, Tag::Maximum);
                max.begin(end, &[me, -me]).unwrap();
                max.complete(end).unwrap();
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
                (values, end.traffic().messages)
            });
            let n = workers as i64;
            let sums = [n * (n + 1) / 2, -n, i64::MAX.wrapping_mul(n)];
            for (me, (values, messages)) in all.into_iter().enumerate() {
                assert_eq!(values, sums, "{workers} workers");
                assert_eq!(messages as usize, messages_of_sum(me, workers), "{me} of {workers}");
            }
        }
    }
}
