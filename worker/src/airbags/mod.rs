//! Airbags: volumes with uniform pressure inside closed surfaces.
//!
//! The volume is a sum over faces, `V = 1/3 sum of (x_a - x_0) . g_a` over their corners a, where
//! `g_a` is the integral of `N_a n` over the face. This is exact for bilinear faces, and `g_a` is
//! dV/dx_a: the pressure forces `p g_a` ([`crate::loads`]) do the work p dV. The sum is exact, so
//! it has the same bits for any number of workers; all workers compute the same gas.
//!
//! The pressure of a bag acts as a spring on all nodes of its surface at once. Its squared
//! frequency is `-dp/dV sum of |G_a|^2/M_a` over nodes, where `G_a` is the sum of `g_a` over the
//! faces that meet at the node. If these are k, `|sum of g|^2 <= k sum of |g|^2`, so that the sum
//! over all faces of `k |g_a|^2/M_a` is an upper bound. Constraints only lower the frequency
//! ([`crate::constraints::Constraints::largest_inv_mass`]). By Irons & Treharne (1971) the squared
//! frequency of the model is at most the sum of that of its elements and this one.

mod gas;

use crate::constraints::Constraints;
use crate::curve::Curve;
use crate::loads::{BagSums, Loads};
use crate::nodes::Nodes;
use crate::time::{Clock, stiffened};
use crumple_proto::airbag::{BagLaw, ResolvedAirbag};
use crumple_proto::exact_sum::{ExactSum, WORDS};
use crumple_proto::histories::BagState;
use crumple_proto::loads::ResolvedLoads;
use crumple_proto::transport::{RankLost, Tag, Transport, sum_all};
use gas::{Gas, GasModel};
use serde::{Deserialize, Serialize};

/// State of an airbag between steps, equal on all workers.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct BagMemory {
    /// Volume at the start; 0 before [length^3].
    start_volume: f64,
    /// Volume when the last forces were computed [length^3].
    volume: f64,
    /// Absolute pressure then [force/length^2].
    pressure: f64,
    /// Work on the surface so far [energy].
    work: f64,
    /// The gas; without mass if the bag has none.
    gas: Gas,
}

impl BagMemory {
    /// Returns true if it is a state of a job's airbag.
    pub fn fits(&self, job: &ResolvedAirbag) -> bool {
        let vents = if let BagLaw::Gas(law) = &job.law { law.vents.len() } else { 0 };
        let Self { start_volume, volume, pressure, work, gas } = self;
        let Gas { mass, energy, exchanged, enthalpy, open } = gas;
        let numbers = [start_volume, volume, pressure, work, mass, energy];
        let numbers = numbers.into_iter().chain(exchanged).chain(enthalpy);
        let positive = [start_volume, volume, mass, energy].into_iter().all(|n| *n >= 0.0);
        let begun = *start_volume > 0.0;
        positive
            && numbers.into_iter().all(|n| n.is_finite())
            && (!begun || *volume > 0.0 && open.len() == vents)
    }
}

/// All airbags of the model.
#[derive(Debug, Default)]
pub struct Airbags {
    bags: Vec<Bag>,
    /// Words of the sums, for the message.
    words: Vec<i64>,
    /// Upper bound of the squared frequency due to all bags [1/time^2].
    frequency2: f64,
    /// The fault of the first bag that has no valid next state; equal on all workers.
    fault: Option<String>,
}

#[derive(Debug)]
struct Bag {
    job: ResolvedAirbag,
    model: BagModel,
    memory: BagMemory,
}

#[derive(Debug)]
enum BagModel {
    Gas(GasModel),
    Inverse(f64, Curve),
    Table(Curve),
}

impl Airbags {
    /// Builds the airbags of a job before the start.
    pub fn new(loads: &ResolvedLoads) -> Self {
        let curves = &loads.curves;
        let model = |job: &ResolvedAirbag| match &job.law {
            BagLaw::Gas(law) => BagModel::Gas(GasModel::new(law, job.ambient_pressure, curves)),
            BagLaw::Inverse { pressure, curve } => {
                let factor = curve.map_or_else(Curve::one, |c| Curve::new(&curves[c]));
                BagModel::Inverse(*pressure, factor)
            }
            BagLaw::Table { points } => BagModel::Table(Curve::new(points)),
        };
        let bag = |job: &ResolvedAirbag| Bag {
            job: ResolvedAirbag { faces: Vec::new(), ..job.clone() },
            model: model(job),
            memory: BagMemory::default(),
        };
        Self {
            bags: loads.airbags.iter().map(bag).collect(),
            words: vec![0; 2 * WORDS * loads.airbags.len()],
            frequency2: 0.0,
            fault: None,
        }
    }

    /// Returns true if the model has no airbags.
    pub fn is_empty(&self) -> bool {
        self.bags.is_empty()
    }

    /// Returns the states of all airbags.
    pub fn state(&self) -> Vec<BagMemory> {
        // A new field is an error here: state has to be added. The words belong to one step, the
        // frequency follows from the state when the next step begins, and a fault ends the run.
        let Self { bags, words: _, frequency2: _, fault: _ } = self;
        let of = |bag: &Bag| {
            let Bag { job: _, model: _, memory } = bag;
            memory.clone()
        };
        bags.iter().map(of).collect()
    }

    /// Sets the states of all airbags.
    pub fn restore(&mut self, states: Vec<BagMemory>) {
        self.bags.iter_mut().zip(states).for_each(|(bag, memory)| bag.memory = memory);
    }

    /// Computes volumes and pressures at the present time, and hands the pressures to the loads. If
    /// a bag has no valid state there, it keeps the last one, and there is a fault. Collective.
    ///
    /// # Errors
    /// A worker is gone.
    pub fn fill(
        &mut self,
        comm: &mut dyn Transport,
        loads: &mut Loads,
        (nodes, constraints): (&Nodes, &Constraints),
        clock: Option<&Clock>,
    ) -> Result<(), RankLost> {
        let mut sums = vec![BagSums::default(); self.bags.len()];
        loads.measure_airbags(nodes, |n| constraints.largest_inv_mass(n, nodes), &mut sums);
        for (words, sum) in self.words.chunks_exact_mut(2 * WORDS).zip(&sums) {
            words[..WORDS].copy_from_slice(sum.volume.words());
            words[WORDS..].copy_from_slice(sum.softness.words());
        }
        sum_all(comm, Tag::Airbags, &mut self.words)?;
        let [from, dt] = clock.map_or([0.0; 2], |c| [c.time - c.last_dt, c.last_dt]);
        self.frequency2 = 0.0;
        for (bag, words) in self.bags.iter_mut().zip(self.words.chunks_exact(2 * WORDS)) {
            let [volume, softness] = [&words[..WORDS], &words[WORDS..]].map(ExactSum::value_of);
            match bag.filled(volume + bag.job.added_volume, from, dt) {
                Ok(memory) => bag.memory = memory,
                Err(why) => {
                    let fault = format!("airbag `{}`: {why}", bag.job.name);
                    self.fault.get_or_insert(fault);
                }
            }
            self.frequency2 += bag.stiffness(from + dt) * softness;
        }
        loads.airbag_pressures.clear();
        loads
            .airbag_pressures
            .extend(self.bags.iter().map(|bag| bag.memory.pressure - bag.job.ambient_pressure));
        Ok(())
    }

    /// Returns the stable step of the model, from that of its elements [time].
    pub fn limit(&self, stable_dt: f64) -> f64 {
        stiffened(stable_dt, self.frequency2)
    }

    /// Returns what is wrong if a bag has no valid next state; equal on all workers.
    pub fn fault(&self) -> Option<&str> {
        self.fault.as_deref()
    }

    /// Returns the states of all airbags for output.
    pub fn records(&self) -> Vec<BagState> {
        self.bags.iter().map(Bag::record).collect()
    }
}

impl Bag {
    /// Returns the state after a step `dt` to a new volume; `from` is the time before. Before the
    /// start, the bag starts with this volume.
    ///
    /// # Errors
    /// There is no valid state: the volume is not above 0 or changes too much, or the gas is used
    /// up.
    fn filled(&self, volume: f64, from: f64, dt: f64) -> Result<BagMemory, String> {
        if !(volume > 0.0 && volume.is_finite()) {
            return Err(format!(
                "its volume is {volume:.4e} after {:.4e}: its surface has collapsed or turned \
                 inside out. Give it an `added_volume`, or let contact keep its layers apart",
                self.memory.volume
            ));
        }
        let mut memory = self.memory.clone();
        let started = memory.start_volume > 0.0;
        if started && dt == 0.0 {
            return Ok(memory); // the first step begins with the state of the start
        }
        if !started {
            (memory.start_volume, memory.volume) = (volume, volume);
            if let BagModel::Gas(model) = &self.model {
                memory.gas = model.start(volume);
            }
        }
        let before = memory.pressure;
        let volumes = [memory.volume, volume];
        memory.volume = volume;
        let mean_work = |after: f64| 0.5 * (before + after) * (volumes[1] - volumes[0]);
        let ambient = self.job.ambient_pressure;
        let work;
        (memory.pressure, work) = match &self.model {
            // Without round-off, so that a bag with the ambient pressure is at rest.
            BagModel::Gas(model) if !started => (model.start_pressure(), 0.0),
            BagModel::Gas(model) => {
                model.exchange(&mut memory.gas, volumes[0], from, dt)?;
                let work = model.expand(&mut memory.gas, before, volumes)?;
                (model.pressure(&memory.gas, volume), work)
            }
            BagModel::Inverse(pressure, factor) => {
                let ratio = memory.start_volume / volume;
                let after = ambient + pressure * factor.value(from + dt) * ratio;
                (after, mean_work(after))
            }
            BagModel::Table(points) => {
                let after = ambient + points.value(volume / memory.start_volume);
                (after, mean_work(after))
            }
        };
        memory.work += work;
        if !(memory.pressure.is_finite() && memory.work.is_finite()) {
            return Err(format!("its pressure is {:?} and not finite", memory.pressure));
        }
        Ok(memory)
    }

    /// Returns the change of pressure per decrease of the volume, at least 0
    /// [force/length^5].
    fn stiffness(&self, time: f64) -> f64 {
        let BagMemory { start_volume, volume, pressure, .. } = self.memory;
        let of = match &self.model {
            BagModel::Gas(model) => model.exponent() * pressure / volume,
            BagModel::Inverse(gauge, factor) => {
                gauge * factor.value(time) * start_volume / (volume * volume)
            }
            BagModel::Table(points) => -points.slope(volume / start_volume) / start_volume,
        };
        of.max(0.0)
    }

    fn record(&self) -> BagState {
        let BagMemory { volume, pressure, work, gas, .. } = &self.memory;
        BagState {
            volume: *volume,
            pressure: *pressure,
            mass: gas.mass,
            temperature: match &self.model {
                BagModel::Gas(model) => model.temperature(gas),
                _ => 0.0,
            },
            energy: gas.energy,
            mass_in: gas.exchanged[0],
            mass_out: gas.exchanged[1],
            enthalpy_in: gas.enthalpy[0],
            enthalpy_out: gas.enthalpy[1],
            work: *work,
        }
    }
}
