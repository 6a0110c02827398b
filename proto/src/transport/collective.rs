//! What workers do together over any transport. The master takes no part.

use super::{Lost, Tag, Transport};

/// Sends `parcels[w]` to every other worker w and returns what each of them sent here.
/// Worker w is rank w + 1; the entry of this worker is handed back as it is.
///
/// # Errors
/// A worker is gone.
pub fn exchange_all(wire: &mut dyn Transport, mut parcels: Vec<Vec<u64>>) -> Result<Vec<Vec<u64>>, Lost> {
    let me = wire.rank() - 1;
    let others = || (0..parcels.len()).filter(|&w| w != me);
    for w in others() {
        wire.send(w + 1, Tag::Renewal, &parcels[w])?;
    }
    for w in others().collect::<Vec<_>>() {
        wire.recv(w + 1, Tag::Renewal, &mut parcels[w])?;
    }
    Ok(parcels)
}

/// A maximum over all workers that is begun early and finished late, so that it overlaps work.
/// By dissemination (Hensgen, Finkel & Manber 1988): ceil(log2 P) rounds; a maximum may count a value twice.
#[derive(Debug)]
pub struct MaxReduction {
    values: Vec<f64>,
    buffer: Vec<u64>,
}

impl MaxReduction {
    /// A reduction of `width` numbers.
    pub fn new(width: usize) -> Self {
        Self { values: vec![f64::NEG_INFINITY; width], buffer: Vec::new() }
    }

    /// Rounds among so many workers; each sends one message in each.
    pub fn hops(workers: usize) -> u32 {
        workers.next_power_of_two().ilog2()
    }

    /// Puts in this worker's values and sends the first round.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn begin(&mut self, wire: &mut dyn Transport, values: &[f64]) -> Result<(), Lost> {
        self.values.copy_from_slice(values);
        if wire.size() > 2 { self.send(wire, 1) } else { Ok(()) }
    }

    /// Completes the rounds and gives the maxima, the same on every worker.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn finish(&mut self, wire: &mut dyn Transport) -> Result<&[f64], Lost> {
        let (workers, me) = (wire.size() - 1, wire.rank() - 1);
        let mut hop = 1;
        while hop < workers {
            if hop > 1 {
                self.send(wire, hop)?;
            }
            wire.recv((me + workers - hop) % workers + 1, Tag::Maximum, &mut self.buffer)?;
            for (v, &o) in self.values.iter_mut().zip(&self.buffer) {
                *v = v.max(f64::from_bits(o));
            }
            hop *= 2;
        }
        Ok(&self.values)
    }

    fn send(&self, wire: &mut dyn Transport, hop: usize) -> Result<(), Lost> {
        let (workers, me) = (wire.size() - 1, wire.rank() - 1);
        wire.send((me + hop) % workers + 1, Tag::Maximum, bytemuck::cast_slice(&self.values))
    }
}

#[cfg(test)]
mod tests {
    use super::super::threads::connect;
    use super::*;

    #[test]
    fn every_worker_gets_the_maximum_for_any_number_of_workers() {
        for workers in 1..=7 {
            let mut ends = connect(workers + 1);
            let _master = ends.remove(0);
            let threads: Vec<_> = ends
                .into_iter()
                .map(|mut end| {
                    std::thread::spawn(move || {
                        let me = end.rank() as f64;
                        let mut max = MaxReduction::new(2);
                        max.begin(&mut end, &[me, -me]).unwrap();
                        max.finish(&mut end).unwrap().to_vec()
                    })
                })
                .collect();
            for t in threads {
                assert_eq!(t.join().unwrap(), [workers as f64, -1.0]);
            }
        }
    }
}
