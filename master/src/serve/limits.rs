//! Choice of the waiting jobs that start now.
//!
//! Jobs start by priority, then in the order of submission. A job that does not fit holds back
//! those after it, so that none waits for ever.

/// Places and memory.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Amount {
    /// Number of workers.
    pub workers: u32,
    /// Memory [MB].
    pub memory_mb: f64,
}

impl Amount {
    /// Returns the sum.
    pub fn plus(self, other: Self) -> Self {
        Self {
            workers: self.workers.saturating_add(other.workers),
            memory_mb: self.memory_mb + other.memory_mb,
        }
    }

    /// Returns true if it is not more than `limit`.
    pub fn fits(self, limit: Self) -> bool {
        self.workers <= limit.workers && self.memory_mb <= limit.memory_mb
    }
}

/// Returns how many of the jobs that wait start, from the first. `used` is in use already.
pub fn starts(waiting: &[Amount], used: Amount, limit: Amount) -> usize {
    let mut used = used;
    waiting
        .iter()
        .take_while(|need| {
            used = used.plus(**need);
            used.fits(limit)
        })
        .count()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn jobs_start_in_order_while_they_fit() {
        let need = |workers, memory_mb| Amount { workers, memory_mb };
        let limit = need(4, 100.0);
        let waiting = [need(2, 10.0), need(2, 10.0), need(1, 1.0)];
        assert_eq!(starts(&waiting, need(0, 0.0), limit), 2);
        assert_eq!(starts(&waiting, need(1, 0.0), limit), 1, "the second holds back the third");
        assert_eq!(starts(&waiting, need(0, 85.0), limit), 1, "by memory");
        assert_eq!(starts(&waiting, need(4, 0.0), limit), 0);
        assert_eq!(starts(&[], need(0, 0.0), limit), 0);
    }
}
