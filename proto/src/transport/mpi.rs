//! Ranks as MPI processes. All calls come from the thread that initialised MPI.

use super::rest::Rest;
use super::wait::{Patience, WaitClock};
use super::{RankLost, Tag, Traffic, Transport};
use ::mpi::environment::Universe;
use ::mpi::request::{Request, StaticScope, scope};
use ::mpi::topology::SimpleCommunicator;
use ::mpi::traits::*;
use std::time::{Duration, Instant};

/// Environment variable by which Open MPI decides whether ranks yield their core.
const YIELD: &str = "OMPI_MCA_mpi_yield_when_idle";

/// Message in transit: MPI reads the buffer until the request is complete.
struct Flying {
    request: Request<'static, [u64], StaticScope>,
    buffer: *mut [u64],
}

/// Communication of this process over MPI_COMM_WORLD.
pub struct Mpi {
    world: SimpleCommunicator,
    _universe: Universe,
    flying: Vec<Flying>,
    wait_cpu: Duration,
    traffic: Traffic,
    /// Time for which a waiting rank polls before it leaves its core to others.
    patience: Patience,
    rest: Rest,
}

impl Mpi {
    /// Sets MPI not to yield the core in its own calls, unless the environment sets it. A rank
    /// that yields to a process outside the run gets the core back some milliseconds later; this
    /// transport knows better when to yield (`Rest`). Open MPI yields where ranks share cores.
    ///
    /// # Safety
    /// No other thread of this process may exist: it changes the environment.
    pub unsafe fn configure() {
        if std::env::var_os(YIELD).is_none() {
            // SAFETY: there is no other thread that could read the environment.
            unsafe { std::env::set_var(YIELD, "0") };
        }
    }

    /// Initialises MPI; returns `None` if it is initialised already. From here on a panic ends
    /// all ranks: MPI would otherwise leave the others waiting for ever. Call
    /// [`Self::configure`] first.
    pub fn start() -> Option<Self> {
        let (universe, _) = ::mpi::initialize_with_threading(::mpi::Threading::Funneled)?;
        let world = universe.world();
        let rank = world.rank();
        // A rank that is bound to a single core does not share it.
        let cores = std::thread::available_parallelism().map_or(1, usize::from);
        let here = world.split_shared(rank).size() as usize;
        let has_core = cores == 1 || here <= cores + 1;
        let default = std::panic::take_hook();
        std::panic::set_hook(Box::new(move |info| {
            eprintln!("crumple: rank {rank} panicked; ending all ranks");
            default(info);
            SimpleCommunicator::world().abort(4);
        }));
        Rest::shorten_sleeps();
        Some(Self {
            world,
            _universe: universe,
            flying: Vec::new(),
            wait_cpu: Duration::ZERO,
            traffic: Traffic::default(),
            patience: Patience::new(has_core),
            rest: Rest::new(),
        })
    }

    /// Ends all ranks of the job at once.
    pub fn abort(&self, code: i32) -> ! {
        self.world.abort(code)
    }

    fn land(&mut self) {
        let mut still = Vec::with_capacity(self.flying.len());
        for f in self.flying.drain(..) {
            match f.request.test() {
                // SAFETY: the buffer came from Box::into_raw in `send` and MPI is done with it.
                Ok(_) => drop(unsafe { Box::from_raw(f.buffer) }),
                Err(request) => still.push(Flying { request, buffer: f.buffer }),
            }
        }
        self.flying = still;
    }
}

impl Drop for Mpi {
    fn drop(&mut self) {
        for f in self.flying.drain(..) {
            f.request.wait();
            // SAFETY: as in `land`.
            drop(unsafe { Box::from_raw(f.buffer) });
        }
    }
}

impl Transport for Mpi {
    fn rank(&self) -> usize {
        self.world.rank() as usize
    }

    fn size(&self) -> usize {
        self.world.size() as usize
    }

    fn send(&mut self, to: usize, tag: Tag, words: &[u64]) -> Result<(), RankLost> {
        if self.flying.len() >= 32 {
            self.land();
        }
        let buffer: *mut [u64] = Box::into_raw(words.to_vec().into_boxed_slice());
        // SAFETY: the buffer lives until `land` or `drop` sees the request complete.
        let view: &'static [u64] = unsafe { &*buffer };
        let to = self.world.process_at_rank(to as i32);
        let request = to.immediate_send_with_tag(StaticScope, view, tag as i32);
        self.flying.push(Flying { request, buffer });
        self.traffic.messages += 1;
        self.traffic.bytes += 8 * words.len() as u64;
        Ok(())
    }

    fn try_recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<bool, RankLost> {
        let from = self.world.process_at_rank(from as i32);
        let Some(status) = from.immediate_probe_with_tag(tag as i32) else {
            return Ok(false);
        };
        words.resize(status.count(u64::equivalent_datatype()) as usize, 0);
        // The rest of a long message is sent only now. A receive that blocks would occupy the core
        // that the sender may need.
        let (start, rest) = (Instant::now(), &mut self.rest);
        scope(|scope| {
            let mut request =
                from.immediate_receive_into_with_tag(scope, &mut words[..], tag as i32);
            while let Err(pending) = request.test() {
                request = pending;
                rest.pause(start.elapsed());
            }
        });
        Ok(true)
    }

    fn recv(&mut self, from: usize, tag: Tag, words: &mut Vec<u64>) -> Result<(), RankLost> {
        if self.try_recv(from, tag, words)? {
            return Ok(());
        }
        let (mut clock, patience) = (WaitClock::start(), self.patience.start());
        let mut polls = true;
        while !self.try_recv(from, tag, words)? {
            let waited = clock.elapsed();
            polls = waited < patience;
            if polls {
                std::hint::spin_loop();
            } else {
                clock.before_sleep();
                self.rest.pause(waited);
            }
        }
        if polls {
            self.patience.record_success(clock.elapsed());
        } else {
            self.patience.record_failure();
        }
        self.wait_cpu += clock.cpu();
        Ok(())
    }

    fn wait_cpu(&self) -> Duration {
        self.wait_cpu
    }

    fn traffic(&self) -> Traffic {
        self.traffic
    }

    fn one_clock(&self) -> bool {
        false
    }

    fn name(&self) -> &'static str {
        "mpi"
    }
}
