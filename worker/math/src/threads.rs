//! Threads of a worker. They share the loops of a time step.
//!
//! A loop is cut into pieces, and each piece writes values of its own. Results of pieces are joined
//! in the order of the pieces. So no bit depends on the number of threads.
//!
//! The threads wait awake for the next loop of a step: to wake one takes as long as a loop over
//! some hundred elements. A pool that lets its threads sleep between loops (rayon) takes 50 us more
//! per loop.

mod team;

use crumple_proto::transport::thread_cpu;
use std::cell::RefCell;
use std::ops::Range;
use std::rc::Rc;
use std::sync::Mutex;
use std::time::Duration;
use team::Team;

/// Number of pieces into which [`ranges`] cuts the share of a thread: a thread that is slow, or has
/// dear pieces, leaves some to the others.
const PIECES: usize = 4;

thread_local! {
    /// Helpers of this thread. They end with it.
    static TEAM: RefCell<Option<Rc<Team>>> = const { RefCell::new(None) };
}

fn team() -> Option<Rc<Team>> {
    TEAM.with(|own| own.borrow().clone())
}

/// Lets `count` threads, with the calling one, share its loops from now on. Other helpers that it
/// had end.
///
/// # Errors
/// The system starts no more threads; the calling thread has no helpers then.
pub fn start(count: usize) -> Result<(), String> {
    if team().map_or(1, |team| 1 + team.size()) == count.max(1) {
        return Ok(());
    }
    TEAM.with(|own| own.take());
    if count > 1 {
        let team = Team::start(count - 1).map_err(|why| why.to_string())?;
        TEAM.with(|own| own.replace(Some(Rc::new(team))));
    }
    Ok(())
}

/// Runs `work`, in which `count` threads share the loops of the calling thread. If the system
/// starts no more threads, or there are helpers already, their number stays as it is.
pub fn with<T>(count: usize, work: impl FnOnce() -> T) -> T {
    let alone = self::count() == 1 && start(count).is_ok();
    let result = work();
    if alone {
        TEAM.with(|own| own.take());
    }
    result
}

/// Returns the number of threads that share the loops of the calling thread.
pub fn count() -> usize {
    team().map_or(1, |team| 1 + team.size())
}

/// Returns the CPU time so far of the calling thread and its helpers in loops, without that of
/// waiting for each other.
pub fn cpu() -> Duration {
    let [helped, waited] = team().map_or([Duration::ZERO; 2], |team| team.cpu());
    (thread_cpu() + helped).saturating_sub(waited)
}

/// Cuts `0..count` into ranges, none with fewer than `least` steps; into one for a single thread.
/// The shares of threads differ by at most one step. Each share is cut into pieces that become
/// shorter: the last ones, which threads take from each other, decide how long they wait at the end
/// of the loop.
pub fn ranges(count: usize, least: usize) -> Vec<Range<usize>> {
    let threads = self::count().min(count / least.max(1)).max(1);
    if threads == 1 {
        return std::iter::once(0..count).collect();
    }
    let share = |thread: usize| {
        let (mut start, end) = (thread * count / threads, (thread + 1) * count / threads);
        let mut pieces: Vec<Range<usize>> = Vec::with_capacity(PIECES);
        while pieces.len() + 1 < PIECES && (end - start) / 2 >= least.max(1) {
            let half = start + (end - start).div_ceil(2);
            pieces.push(start..half);
            start = half;
        }
        pieces.push(start..end);
        pieces
    };
    (0..threads).flat_map(share).collect()
}

/// Cuts `0..count` into ranges of `size` steps; the last may be shorter. They do not depend on the
/// number of threads. So sums over ranges, added in their order, have the same bits.
///
/// # Panics
/// If `size` is 0.
pub fn ranges_of_size(count: usize, size: usize) -> Vec<Range<usize>> {
    (0..count).step_by(size).map(|start| start..(start + size).min(count)).collect()
}

/// Calls `work` for each piece, and returns its results in the order of the pieces.
///
/// # Panics
/// If `work` panics.
pub fn map<T: Send, U: Send>(pieces: Vec<T>, work: impl Fn(T) -> U + Sync) -> Vec<U> {
    if pieces.len() <= 1 || count() == 1 {
        return pieces.into_iter().map(work).collect();
    }
    let due: Vec<Mutex<Option<T>>> = pieces.into_iter().map(|p| Mutex::new(Some(p))).collect();
    let done: Vec<Mutex<Option<U>>> = due.iter().map(|_| Mutex::new(None)).collect();
    let one = |i: usize| {
        let piece = due[i].lock().expect("no other thread has this piece").take();
        let result = piece.map(&work);
        *done[i].lock().expect("no other thread has this result") = result;
    };
    team().expect("there are helpers").run(due.len(), &one);
    let result = |of: Mutex<Option<U>>| of.into_inner().ok().flatten().expect("it is done");
    done.into_iter().map(result).collect()
}

/// Returns the results of `a` and `b`. If the calling thread has helpers, one of them may compute
/// one of the results at the same time.
///
/// # Panics
/// If one of them panics.
pub fn both<A: Send, B: Send>(
    a: impl FnOnce() -> A + Send,
    b: impl FnOnce() -> B + Send,
) -> (A, B) {
    let (mut of_a, mut of_b) = (None, None);
    let tasks: Vec<Box<dyn FnOnce() + Send + '_>> =
        vec![Box::new(|| of_a = Some(a())), Box::new(|| of_b = Some(b()))];
    map(tasks, |task| task());
    (of_a.expect("it is done"), of_b.expect("it is done"))
}

/// Joins the results of pieces in their order.
pub fn joined<T>(pieces: Vec<Vec<T>>) -> Vec<T> {
    let mut pieces = pieces.into_iter();
    let mut all = pieces.next().unwrap_or_default();
    pieces.for_each(|piece| all.extend(piece));
    all
}

/// Returns the values of `of` for `0..count`, of which a thread computes at least `least` at a
/// time.
pub fn collect<T: Send>(count: usize, least: usize, of: impl Fn(usize) -> T + Sync) -> Vec<T> {
    let of_range = |range: Range<usize>| range.map(&of).collect();
    joined(map(ranges(count, least), of_range))
}

/// Cuts a column at the ends of `ranges`, which follow each other from 0 on.
pub fn cut<'a, T>(mut column: &'a mut [T], ranges: &[Range<usize>]) -> Vec<&'a mut [T]> {
    let piece = |range: &Range<usize>| {
        let (piece, rest) = std::mem::take(&mut column).split_at_mut(range.len());
        column = rest;
        piece
    };
    ranges.iter().map(piece).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    /// Runs a test on a thread of its own, which gets helpers.
    fn with_threads<T: Send>(count: usize, run: impl FnOnce() -> T + Send) -> T {
        let run = || {
            start(count).unwrap();
            run()
        };
        std::thread::scope(|s| s.spawn(run).join().unwrap())
    }

    #[test]
    fn ranges_cover_a_loop_once() {
        for threads in [1, 2, 5] {
            for length in [0, 1, 7, 64, 1000] {
                let ranges = with_threads(threads, || ranges(length, 10));
                let covered: Vec<usize> = ranges.iter().cloned().flatten().collect();
                assert_eq!(covered, (0..length).collect::<Vec<_>>(), "{threads}: {ranges:?}");
                assert!(length < 10 || ranges.iter().all(|r| r.len() >= 10), "{ranges:?}");
                assert!(ranges.len() <= PIECES * threads && (threads > 1 || ranges.len() == 1));
            }
        }
    }

    #[test]
    fn pieces_of_a_share_become_shorter() {
        let lengths: Vec<usize> =
            with_threads(2, || ranges(160, 10).iter().map(Range::len).collect());
        assert_eq!(lengths, [40, 20, 10, 10, 40, 20, 10, 10]);
    }

    #[test]
    fn ranges_of_a_size_do_not_depend_on_threads() {
        let of = |threads| with_threads(threads, || ranges_of_size(25, 10));
        assert_eq!(of(1), [0..10, 10..20, 20..25]);
        assert_eq!(of(3), of(1));
        assert_eq!(ranges_of_size(0, 10), []);
    }

    #[test]
    fn two_tasks_give_both_results() {
        let count = || std::thread::current().id();
        for threads in [1, 2, 3] {
            let ids =
                with_threads(threads, || (0..100).map(|_| both(count, count)).collect::<Vec<_>>());
            assert_eq!(ids.len(), 100);
            let apart = ids.iter().filter(|(a, b)| a != b).count();
            assert!(threads > 1 || apart == 0, "{apart}");
        }
        assert_eq!(both(|| 3, || "b"), (3, "b"));
    }

    #[test]
    fn pieces_are_computed_once_and_joined_in_order() {
        for threads in [1, 2, 3] {
            let (results, numbers) = with_threads(threads, || {
                assert_eq!(super::count(), threads);
                let mut numbers = vec![0; 1000];
                let ranges = ranges(numbers.len(), 1);
                let mut results = Vec::new();
                // Often: helpers come late, or not at all, to some of the loops.
                for _ in 0..300 {
                    let pieces = ranges.iter().cloned().zip(cut(&mut numbers, &ranges)).collect();
                    results = map(pieces, |(range, piece)| {
                        piece.iter_mut().zip(range.clone()).for_each(|(n, i)| *n += i);
                        range.start
                    });
                }
                (results, numbers)
            });
            assert!(results.is_sorted() && results[0] == 0);
            assert!(numbers.iter().zip(0..).all(|(n, i)| *n == 300 * i));
            let squares = with_threads(threads, || collect(100, 3, |i| i * i));
            assert_eq!(squares, (0..100).map(|i| i * i).collect::<Vec<_>>());
        }
    }

    #[test]
    fn helpers_of_one_task_end_with_it() {
        let counts = with_threads(1, || (with(3, count), count()));
        assert_eq!(counts, (3, 1));
        let counts = with_threads(2, || (with(3, count), count()));
        assert_eq!(counts, (2, 2), "it has helpers already");
    }

    #[test]
    fn a_thread_gets_the_helpers_of_its_last_start() {
        let counts = with_threads(3, || {
            let count_after = |count| {
                start(count).unwrap();
                let sum: usize = map((0..50).collect(), |i: usize| i).iter().sum();
                assert_eq!(sum, 1225);
                super::count()
            };
            [4, 4, 1, 2].map(count_after)
        });
        assert_eq!(counts, [4, 4, 1, 2]);
    }

    #[test]
    fn a_panic_in_a_piece_ends_the_loop_and_not_the_helpers() {
        let work = |i: usize| assert!(i % 7 != 3, "piece {i}");
        let (failed, after) = with_threads(3, || {
            let loop_ = std::panic::AssertUnwindSafe(|| map((0..20).collect(), work));
            (std::panic::catch_unwind(loop_).is_err(), map((0..20).collect(), |i: usize| i))
        });
        assert!(failed);
        assert_eq!(after, (0..20).collect::<Vec<_>>());
    }

    #[test]
    fn the_time_of_helpers_is_counted() {
        let spin = |_| {
            let start = thread_cpu();
            while thread_cpu() - start < Duration::from_millis(5) {}
        };
        let all = with_threads(3, || {
            let before = cpu();
            map(vec![(); 30], spin);
            cpu() - before
        });
        assert!(all >= Duration::from_millis(150), "{all:?}");
    }
}
