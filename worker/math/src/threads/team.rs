//! Helpers of a thread: they take pieces of its loops.

use crumple_proto::transport::thread_cpu;
use std::cell::Cell;
use std::ops::Range;
use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::sync::atomic::Ordering::{Relaxed, SeqCst};
use std::sync::atomic::{AtomicBool, AtomicU64, AtomicUsize};
use std::sync::{Arc, Mutex};
use std::thread::{self, JoinHandle};
use std::time::{Duration, Instant};

/// Time for which a helper waits awake for the next loop. Steps are shorter, so that helpers sleep
/// only when no loops come.
const AWAKE: Duration = Duration::from_millis(2);
/// Number of looks for a loop between two looks at the clock.
const LOOKS: usize = 64;

/// A loop: it computes the piece with this number.
type Loop<'a> = dyn Fn(usize) + Sync + 'a;

/// A loop that helpers may call while it is open.
#[derive(Clone, Copy)]
struct OpenLoop {
    work: &'static Loop<'static>,
    pieces: usize,
}

/// Data of a thread and its helpers.
#[derive(Default)]
struct LoopState {
    /// Number of the loop that is open; 0 if none is.
    open: AtomicU64,
    /// The open loop.
    current: Mutex<Option<OpenLoop>>,
    /// For each thread the number of the next piece of its share, see [`LoopState::take_pieces`].
    next: Vec<AtomicUsize>,
    /// Number of helpers that may be in a loop.
    active: AtomicUsize,
    /// Number of helpers that sleep.
    asleep: AtomicUsize,
    /// True when the helpers end.
    ends: AtomicBool,
    /// The first panic of a helper in a loop.
    panic: Mutex<Option<Box<dyn std::any::Any + Send>>>,
    /// CPU time of the helpers in loops so far [ns].
    cpu: AtomicU64,
}

/// Helpers of a thread.
pub struct Team {
    shared: Arc<LoopState>,
    helpers: Vec<JoinHandle<()>>,
    /// Number of loops so far.
    loops: Cell<u64>,
    /// True during a loop.
    in_loop: Cell<bool>,
    /// CPU time of waiting for helpers so far.
    waited: Cell<Duration>,
}

impl Team {
    /// Starts so many helpers.
    ///
    /// # Errors
    /// The system starts no more threads.
    pub fn start(helpers: usize) -> std::io::Result<Self> {
        let next = (0..=helpers).map(|_| AtomicUsize::new(0)).collect();
        let shared = Arc::new(LoopState { next, ..LoopState::default() });
        let (loops, in_loop, waited) = (Cell::new(0), Cell::new(false), Cell::default());
        let mut team = Self { shared, helpers: Vec::new(), loops, in_loop, waited };
        let own = thread::current().name().unwrap_or("worker").to_owned();
        for i in 1..=helpers {
            let shared = team.shared.clone();
            let builder = thread::Builder::new().name(format!("{own}, helper {i}"));
            team.helpers.push(builder.spawn(move || shared.help(i))?);
        }
        Ok(team)
    }

    /// Returns the number of helpers that can take part in a loop: none for a loop within a loop.
    pub fn size(&self) -> usize {
        if self.in_loop.get() { 0 } else { self.helpers.len() }
    }

    /// Returns the CPU time of the helpers in loops so far, and that of waiting for them.
    pub fn cpu(&self) -> [Duration; 2] {
        [Duration::from_nanos(self.shared.cpu.load(Relaxed)), self.waited.get()]
    }

    /// Calls `work` for each of `pieces` numbers. Only the thread that started the team calls this.
    ///
    /// # Panics
    /// If `work` panics.
    pub fn run(&self, pieces: usize, work: &Loop<'_>) {
        /// Closes the loop, also after a panic, and waits for the helpers in it.
        struct Closing<'a>(&'a Team);
        impl Drop for Closing<'_> {
            fn drop(&mut self) {
                self.0.shared.open.store(0, SeqCst);
                if self.0.shared.active.load(SeqCst) > 0 {
                    let before = thread_cpu();
                    while self.0.shared.active.load(SeqCst) > 0 {
                        thread::yield_now();
                    }
                    self.0.waited.update(|waited| waited + (thread_cpu() - before));
                }
                self.0.in_loop.set(false);
            }
        }
        assert!(!self.in_loop.replace(true), "a loop within a loop has one thread");
        // SAFETY: helpers call `work` only while they count as active in an open loop. `Closing`
        // closes the loop and waits until no helper is active before this function ends, also by a
        // panic; a helper that comes later finds no open loop.
        let work = unsafe { std::mem::transmute::<&Loop<'_>, &'static Loop<'static>>(work) };
        let shared = &*self.shared;
        *shared.current.lock().expect("no helper panics with the lock") =
            Some(OpenLoop { work, pieces });
        shared.next.iter().enumerate().for_each(|(i, next)| {
            next.store(shared.share_of(i, pieces).start, SeqCst);
        });
        // It belongs to a loop that ended by a panic of this thread.
        shared.panic.lock().expect("no helper panics with the lock").take();
        self.loops.update(|number| number + 1);
        let closing = Closing(self);
        shared.open.store(self.loops.get(), SeqCst);
        if shared.asleep.load(SeqCst) > 0 {
            self.helpers.iter().for_each(|helper| helper.thread().unpark());
        }
        shared.take_pieces(0, OpenLoop { work, pieces });
        drop(closing);
        let panic = shared.panic.lock().expect("no helper panics with the lock").take();
        if let Some(panic) = panic {
            resume_unwind(panic);
        }
    }
}

impl Drop for Team {
    fn drop(&mut self) {
        self.shared.ends.store(true, SeqCst);
        for helper in self.helpers.drain(..) {
            helper.thread().unpark();
            helper.join().ok();
        }
    }
}

impl LoopState {
    /// Returns the share of a thread of the pieces of a loop. Neighbouring pieces have neighbouring
    /// data: what a thread wrote in the last loop is in the cache of its core.
    fn share_of(&self, thread: usize, pieces: usize) -> Range<usize> {
        let threads = self.next.len();
        thread * pieces / threads..(thread + 1) * pieces / threads
    }

    /// Computes pieces until none is left: those in the share of this thread, then those that other
    /// threads have left in theirs.
    fn take_pieces(&self, thread: usize, of: OpenLoop) {
        let threads = self.next.len();
        for owner in (thread..threads).chain(0..thread) {
            let end = self.share_of(owner, of.pieces).end;
            loop {
                let piece = self.next[owner].fetch_add(1, SeqCst);
                if piece >= end {
                    break;
                }
                (of.work)(piece);
            }
        }
    }

    /// Takes part in the loops until the team ends. The thread that started it has the number 0.
    fn help(&self, thread: usize) {
        let mut seen = 0;
        while self.wait_for_loop(seen) {
            self.active.fetch_add(1, SeqCst);
            // From here on an open loop stays until this helper is no longer active.
            let number = self.open.load(SeqCst);
            if number != 0 && number != seen {
                seen = number;
                let of = *self.current.lock().expect("no helper panics with the lock");
                let before = thread_cpu();
                let taken = catch_unwind(AssertUnwindSafe(|| {
                    of.into_iter().for_each(|of| self.take_pieces(thread, of));
                }));
                if let Err(panic) = taken {
                    self.panic.lock().expect("no helper panics with the lock").get_or_insert(panic);
                }
                let took = thread_cpu().saturating_sub(before);
                self.cpu.fetch_add(took.as_nanos() as u64, Relaxed);
            }
            self.active.fetch_sub(1, SeqCst);
        }
    }

    /// Waits until a loop other than `seen` is open. Returns false if the team ends.
    fn wait_for_loop(&self, seen: u64) -> bool {
        let is_open = || {
            let number = self.open.load(SeqCst);
            number != 0 && number != seen
        };
        let mut awake = Instant::now();
        loop {
            for _ in 0..LOOKS {
                if self.ends.load(SeqCst) {
                    return false;
                }
                if is_open() {
                    return true;
                }
                // Other threads of the machine may need the core.
                thread::yield_now();
            }
            if awake.elapsed() > AWAKE {
                self.asleep.fetch_add(1, SeqCst);
                if !is_open() && !self.ends.load(SeqCst) {
                    thread::park();
                }
                self.asleep.fetch_sub(1, SeqCst);
                awake = Instant::now();
            }
        }
    }
}
