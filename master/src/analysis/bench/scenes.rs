//! Scenes of `crumple bench`. A new scene is a row of [`SCENES`].

/// A scene that is timed over a number of cycles from its start.
pub struct BenchScene {
    /// Name in the table.
    pub name: &'static str,
    /// Name of its job, see [`crumple_cases::job`].
    pub job: &'static str,
    /// Changes to the job, as with `--set`.
    pub sets: &'static [&'static str],
    /// True if its contact stays switched on.
    pub contact: bool,
    /// Number of workers, each a thread.
    pub workers: usize,
    /// Number of cycles before the timing, and number of timed cycles.
    pub cycles: [u64; 2],
    /// Goal per element and cycle [ns on a core of 58.7 GFLOP/s]; zero without a goal.
    pub goal_ns: f64,
}

/// Goals and comparisons of tubes use the cheapest shell.
const PLAIN: &str = "part.tube.element=belytschko_tsay";
const STABILISED: &str = "part.tube.element=stabilised_quad";
const INTEGRATED: &str = "part.tube.element=fully_integrated_quad";
const FINE: &str = "scene.elements=57";
const SINGLE: &str = "elements.precision=single";
const TWO_THREADS: &str = "parallel.threads=2";

/// All scenes, in the order in which they are timed. The goal is a fifth of the time of the
/// established open solver in its stock build (OpenRadioss of August 2026 on an EPYC of Zen 4),
/// if that solver runs the scene.
pub const SCENES: &[BenchScene] = &[
    BenchScene { goal_ns: 105.0, sets: &[PLAIN], ..scene("tube", "tube-crush") },
    BenchScene {
        goal_ns: 95.0,
        contact: false,
        sets: &[PLAIN],
        ..scene("tube-free", "tube-crush")
    },
    BenchScene { goal_ns: 142.0, sets: &[STABILISED], ..scene("tube-stabilised", "tube-crush") },
    BenchScene { sets: &[INTEGRATED], ..scene("tube-integrated", "tube-crush") },
    BenchScene { workers: 2, sets: &[PLAIN], ..scene("tube-2-workers", "tube-crush") },
    BenchScene { cycles: [12_000, 1000], sets: &[PLAIN], ..scene("tube-folded", "tube-crush") },
    BenchScene { goal_ns: 130.0, ..fine("tube-65k", "tube-crush", &[FINE, PLAIN]) },
    BenchScene { contact: false, ..fine("tube-65k-free", "tube-crush", &[FINE, PLAIN]) },
    fine("tube-65k-shuffled", "tube-crush", &[FINE, PLAIN, "scene.shuffle=1"]),
    fine("tube-65k-stabilised", "tube-crush", &[FINE, STABILISED]),
    BenchScene { workers: 2, ..fine("tube-65k-2-workers", "tube-crush", &[FINE, PLAIN]) },
    fine("tube-65k-2-threads", "tube-crush", &[FINE, PLAIN, TWO_THREADS]),
    scene("jeep-frame", "jeep-frame"),
    BenchScene { workers: 2, ..scene("jeep-frame-2-workers", "jeep-frame") },
    BenchScene { sets: &[TWO_THREADS], ..scene("jeep-frame-2-threads", "jeep-frame") },
    fine("jeep-frame-65k", "jeep-frame", &["scene.refine=3"]),
    BenchScene { goal_ns: 60.0, ..scene("hex-bar", "bench/hex-bar") },
    BenchScene { sets: &["scene.nodes=4"], ..scene("tetrahedron-bar", "bench/hex-bar") },
    BenchScene { sets: &["scene.nodes=10"], ..scene("ten-node-bar", "bench/hex-bar") },
    BenchScene { sets: &["scene.nodes=6"], ..scene("wedge-bar", "bench/hex-bar") },
    BenchScene { sets: &[SINGLE, PLAIN], ..scene("tube-single", "tube-crush") },
    BenchScene {
        sets: &[SINGLE, PLAIN],
        contact: false,
        ..scene("tube-free-single", "tube-crush")
    },
    BenchScene { sets: &[SINGLE, STABILISED], ..scene("tube-stabilised-single", "tube-crush") },
    BenchScene {
        contact: false,
        ..fine("tube-65k-free-single", "tube-crush", &[FINE, SINGLE, PLAIN])
    },
    BenchScene { sets: &[SINGLE], ..scene("hex-bar-single", "bench/hex-bar") },
];

const fn scene(name: &'static str, job: &'static str) -> BenchScene {
    BenchScene { name, job, sets: &[], contact: true, workers: 1, cycles: [50, 1000], goal_ns: 0.0 }
}

const fn fine(name: &'static str, job: &'static str, sets: &'static [&'static str]) -> BenchScene {
    BenchScene { sets, cycles: [20, 150], ..scene(name, job) }
}
