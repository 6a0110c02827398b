//! Free space on the file system of the service.

use super::intake::{IntakeFault, Taken};
use std::path::PathBuf;

/// Share of the file system, and bytes, that stay free without another limit.
const LEAST_SHARE: f64 = 0.05;
const LEAST: f64 = 2e9;

/// The file system of a folder, and how much of it stays free.
#[derive(Clone, Debug)]
pub struct Disk {
    /// A folder on it.
    pub folder: PathBuf,
    /// Bytes that stay free; none for the larger of 2 GB and 5 % of all.
    pub least: Option<u64>,
}

impl Disk {
    /// Returns how many bytes may be written.
    ///
    /// # Errors
    /// Fewer than `need`, or the file system does not say.
    pub fn room(&self, need: u64) -> Taken<u64> {
        let about = rustix::fs::statvfs(&self.folder).map_err(|e| IntakeFault::Failed(e.into()))?;
        let free = about.f_bavail.saturating_mul(about.f_frsize);
        room(need, free, about.f_blocks.saturating_mul(about.f_frsize), self.least)
    }
}

fn room(need: u64, free: u64, total: u64, least: Option<u64>) -> Taken<u64> {
    let least = least.unwrap_or((LEAST_SHARE * total as f64).max(LEAST) as u64);
    let room = free.saturating_sub(least);
    if room >= need.max(1) {
        return Ok(room);
    }
    let gb = |bytes: u64| bytes as f64 / 1e9;
    Err(IntakeFault::Full(format!(
        "the service takes no jobs of {:.3} GB: its disk has {:.3} of {:.3} GB free, and {:.3} GB \
         stay free (--disk-limit); ask an administrator to remove old results",
        gb(need),
        gb(free),
        gb(total),
        gb(least)
    )))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn some_of_the_disk_stays_free() {
        let gb = |n: u64| n * 1_000_000_000;
        assert_eq!(room(0, gb(5), gb(20), None).unwrap(), gb(3), "2 GB of a small disk");
        assert_eq!(room(0, gb(15), gb(200), None).unwrap(), gb(5), "5 % of a large one");
        assert_eq!(room(gb(5), gb(15), gb(200), None).unwrap(), gb(5));
        assert_eq!(room(0, gb(1), gb(200), Some(0)).unwrap(), gb(1));
        for (need, free, total, least) in [
            (0, gb(2), gb(20), None),
            (0, gb(9), gb(200), None),
            (gb(6), gb(15), gb(200), None),
            (0, 0, gb(200), Some(0)),
            (0, gb(7), gb(200), Some(gb(8))),
        ] {
            match room(need, free, total, least) {
                Err(IntakeFault::Full(why)) => assert!(why.contains("--disk-limit"), "{why}"),
                other => panic!("{need} {free} {total} {least:?}: {other:?}"),
            }
        }
    }
}
