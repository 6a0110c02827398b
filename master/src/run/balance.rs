//! Decides when to redecompose, from measured costs. Has no side effects, so it is tested without
//! workers.

use crumple_proto::checkpoint::MOST;
use crumple_proto::report::{Displacement, Phase, StepLoads, StepReport, step_loads};
use serde::{Deserialize, Serialize};
use std::collections::VecDeque;

/// A redecomposition that is due.
#[derive(Clone, Debug, PartialEq)]
pub enum Due {
    /// Membership update: boxes move with their content and get new members.
    High {
        /// Reason, shown to the user.
        why: String,
    },
    /// Repartition: new boxes.
    Low {
        /// Reason, shown to the user.
        why: String,
    },
}

/// Thresholds from the job.
#[derive(Clone, Debug)]
pub struct BalanceLimits {
    /// [`Balance::imbalance`] above which a low redecomposition is due.
    pub imbalance: f64,
    /// Minimum number of cycles between two low redecompositions; the first may come earlier.
    pub low_every_at_least: u64,
    /// True to alternate both kinds whenever workers ask, for tests.
    pub forced: bool,
    /// False if elements do not migrate. Then there are no low redecompositions by imbalance.
    pub migrates: bool,
}

/// Share of the margin used by a worker's displacement at which a high redecomposition is ordered.
/// The rest covers the motion until the order arrives.
pub const URGENT: f64 = 0.7;
/// Minimum number of cycles over which the balance is judged.
const WINDOW: usize = 100;
/// Fraction of an imbalance that a low redecomposition must remove. If it removes less, the wait
/// until the next one is doubled.
const WORTHWHILE: f64 = 0.3;
/// Cost of a low redecomposition that takes the place of a high one, as a fraction of the cost of
/// any other: elements migrate in either.
const SAVED: f64 = 0.3;
/// Weight of the latest report in smoothed times and numbers of pairs.
const NEWEST: f64 = 0.1;
/// Number of pairs from which a worker shows what a pair costs.
const ENOUGH_PAIRS: f64 = 8.0;
/// Assumed cost of a low redecomposition before one is measured [s].
const LOW_COST: f64 = 0.02;

/// The master's data on the load of the workers.
#[derive(Debug)]
pub struct Balance {
    limits: BalanceLimits,
    /// Last report of each worker.
    pub last: Vec<StepReport>,
    /// CPU time of cycles that not all workers have reported yet [s].
    waiting: Vec<VecDeque<StepLoads>>,
    /// CPU time of each worker since the last redecomposition or judgement [s], and the number of
    /// cycles in it.
    window: Vec<StepLoads>,
    cycles: usize,
    /// Imbalance of the last complete window since the last low redecomposition, 1 before.
    last_imbalance: f64,
    /// Smoothed CPU time of contact forces in a cycle [s], and number of pairs, of each worker.
    contact: Vec<[f64; 2]>,
    /// Share of contact in the CPU time of each worker, and the number of samples in it since the
    /// last low redecomposition.
    contact_share: Vec<(f64, u32)>,
    /// Number of the order of the last low redecomposition, 0 before the first.
    low_order: u64,
    /// Time lost by waiting for other workers since the last low redecomposition [s].
    lost: f64,
    /// Cycle of the last low redecomposition, none before the first.
    last_low: Option<u64>,
    low_cost: f64,
    /// Imbalance that caused the last low redecomposition, until its effect is known.
    unproven: Option<f64>,
    judged_imbalance: Option<f64>,
    /// Factor on the minimum number of cycles between low redecompositions. Each one of little
    /// effect doubles it.
    patience: u64,
    orders_due: u64,
    /// Sum over cycles of the largest CPU time without contact and the largest one of contact [s].
    pub critical_s: f64,
    /// Sum over cycles and workers of the CPU time [s].
    pub total_s: f64,
    /// CPU time of redecompositions, per worker [s].
    pub renewal_s: Vec<f64>,
    /// Largest imbalance of a window.
    pub worst: f64,
    /// Number of low redecompositions.
    pub low: u64,
    /// Number of high redecompositions.
    pub high: u64,
    flip: bool,
}

/// Sums over a run that continues after a checkpoint.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize)]
pub struct Accounts {
    critical_s: f64,
    total_s: f64,
    renewal_s: f64,
    worst: f64,
    low: u64,
    high: u64,
}

impl Accounts {
    /// Returns true if no sum is too large or no number.
    pub fn are_possible(&self) -> bool {
        let seconds = [self.critical_s, self.total_s, self.renewal_s, self.worst];
        let counts = [self.low, self.high];
        seconds.iter().all(|s| s.is_finite()) && counts.iter().all(|&count| count <= MOST)
    }
}

impl Balance {
    /// Returns the sums so far.
    pub fn accounts(&self) -> Accounts {
        // A new field is an error here: sums have to be added, all else to the last lists.
        let Self {
            critical_s,
            total_s,
            renewal_s,
            worst,
            low,
            high,
            // From the job.
            limits: _,
            // Belongs to one partition. The first low redecomposition of the run that continues
            // starts from the same values as that of a new run.
            last: _,
            waiting: _,
            window: _,
            cycles: _,
            last_imbalance: _,
            contact: _,
            contact_share: _,
            low_order: _,
            lost: _,
            last_low: _,
            low_cost: _,
            unproven: _,
            judged_imbalance: _,
            patience: _,
            orders_due: _,
            flip: _,
        } = self;
        Accounts {
            critical_s: *critical_s,
            total_s: *total_s,
            renewal_s: renewal_s.iter().copied().fold(0.0, f64::max),
            worst: *worst,
            low: *low,
            high: *high,
        }
    }

    /// Continues with the sums of the run before the checkpoint. The worker with the largest time
    /// of redecompositions is not known any more; all get it.
    pub fn restore(&mut self, a: &Accounts) {
        (self.critical_s, self.total_s) = (a.critical_s, a.total_s);
        self.renewal_s.fill(a.renewal_s);
        (self.worst, self.low, self.high) = (a.worst, a.low, a.high);
    }

    /// Creates the balance of a run without reports.
    pub fn new(workers: usize, limits: BalanceLimits) -> Self {
        Self {
            limits,
            last: vec![StepReport::default(); workers],
            waiting: vec![VecDeque::new(); workers],
            window: vec![[0.0; 2]; workers],
            cycles: 0,
            last_imbalance: 1.0,
            contact: vec![[0.0; 2]; workers],
            contact_share: vec![(0.0, 0); workers],
            low_order: 0,
            lost: 0.0,
            last_low: None,
            low_cost: LOW_COST,
            unproven: None,
            judged_imbalance: None,
            patience: 1,
            orders_due: 0,
            critical_s: 0.0,
            total_s: 0.0,
            renewal_s: vec![0.0; workers],
            worst: 1.0,
            low: 0,
            high: 0,
            flip: false,
        }
    }

    /// Adds a worker's report. Its phases are measured in some cycles only, so the smoothed share
    /// of contact divides the time of each cycle; it counts as 0 before the first sample.
    pub fn add_report(&mut self, worker: usize, report: StepReport) {
        let [rest, contact] = step_loads(&report.phase_cpu);
        let (share, samples) = &mut self.contact_share[worker];
        if self.last[worker].order < self.low_order && report.order >= self.low_order {
            *samples = 0; // the first report with the new boxes
        }
        if rest + contact > 0.0 {
            *samples += 1;
            let newest = (1.0 / f64::from(*samples)).max(NEWEST);
            *share += newest * (contact / (rest + contact) - *share);
        }
        let share = *share;
        let cycles =
            report.cpu.iter().map(|&c| [(1.0 - share) * f64::from(c), share * f64::from(c)]);
        self.waiting[worker].extend(cycles);
        self.renewal_s[worker] += report.renewal_s;
        let of_contact = report.phase_cpu[Phase::Contact as usize];
        if of_contact > 0.0 {
            let now = [of_contact / report.cpu.len().max(1) as f64, report.pairs as f64];
            let smooth = self.contact[worker].iter_mut().zip(now);
            smooth.for_each(|(mean, value)| *mean += NEWEST * (value - *mean));
        }
        self.last[worker] = report;
        while self.waiting.iter().all(|w| !w.is_empty()) {
            let costs: Vec<StepLoads> =
                self.waiting.iter_mut().filter_map(|w| w.pop_front()).collect();
            let (sum, max) = (costs.iter().flatten().sum::<f64>(), slowest(&costs));
            self.critical_s += max;
            self.total_s += sum;
            self.lost += max - sum / costs.len() as f64;
            let window = self.window.iter_mut().flatten();
            window.zip(costs.iter().flatten()).for_each(|(w, c)| *w += c);
            self.cycles += 1;
        }
    }

    /// Returns the imbalance since the window began: the time of a step, with the waits for the
    /// slowest worker without contact and in contact, over the mean time of the workers.
    pub fn imbalance(&self) -> f64 {
        let mean = self.window.iter().flatten().sum::<f64>() / self.window.len() as f64;
        if mean > 0.0 { slowest(&self.window) / mean } else { 1.0 }
    }

    /// Returns the mean over the run of the imbalance of each cycle.
    pub fn mean_imbalance(&self) -> f64 {
        if self.total_s > 0.0 {
            self.critical_s * self.last.len() as f64 / self.total_s
        } else {
            1.0
        }
    }

    /// Returns the number of active pairs of all workers in their last reports.
    pub fn pairs(&self) -> u64 {
        self.last.iter().map(|r| r.pairs).sum()
    }

    /// Returns the numbers of interior, interface and exterior elements of all workers in their
    /// last reports.
    pub fn classes(&self) -> [u64; 3] {
        let of = |r: &StepReport| [r.elements - r.interface, r.interface, r.exterior];
        self.last.iter().map(of).fold([0; 3], |s, c| [0, 1, 2].map(|i| s[i] + c[i]))
    }

    /// Returns the CPU time of a contact pair in a cycle [s], infinite if no worker has enough of
    /// them. Contact forces also cost messages, whose number depends on the cuts and not on the
    /// pairs of a worker: the worker with the least time per pair shows what pairs cost.
    pub fn pair_seconds(&self) -> f64 {
        let enough = self.contact.iter().filter(|c| c[1] >= ENOUGH_PAIRS);
        enough.map(|[seconds, pairs]| seconds / pairs).fold(f64::INFINITY, f64::min)
    }

    /// Returns the number of updates of the contact surface because elements have failed.
    pub fn erosions(&self) -> u64 {
        self.last.iter().map(|r| r.erosions).max().unwrap_or(0)
    }

    /// Returns the redecomposition that is due, if any. Returns none until all workers have
    /// carried out the last order.
    pub fn due(&mut self) -> Option<Due> {
        if self.last.iter().any(|r| r.order < self.orders_due) {
            return None;
        }
        let (worker, displacement) = (0..)
            .zip(&self.last)
            .map(|(w, r)| (w, r.displacement))
            .fold((0, Displacement::default()), |a, b| if b.1.share > a.1.share { b } else { a });
        let urgency = displacement.share;
        let cycle = self.last.iter().map(|r| r.cycle).max().unwrap_or(0);
        if self.limits.forced {
            self.flip ^= urgency >= 1.0;
            let why = "forced".to_string();
            return (urgency >= 1.0).then_some(if self.flip || !self.limits.migrates {
                Due::High { why }
            } else {
                Due::Low { why }
            });
        }
        let judged = self.cycles >= WINDOW;
        let imbalance = self.imbalance();
        if judged {
            self.worst = self.worst.max(imbalance);
        }
        if let Some(before) = self.unproven.filter(|_| judged) {
            let brought = (before - imbalance) / (before - 1.0);
            self.patience = if brought > WORTHWHILE { 1 } else { (2 * self.patience).min(64) };
            self.unproven = None;
        }
        let wait = self.patience * self.limits.low_every_at_least;
        let patient = self.last_low.is_none_or(|last| cycle >= last + wait);
        let migrates = self.limits.migrates;
        if migrates
            && judged
            && patient
            && imbalance > self.limits.imbalance
            && self.lost > self.low_cost
        {
            let why = format!(
                "imbalance {imbalance:.2}, {:.0} ms lost by waiting since the last repartition",
                1e3 * self.lost
            );
            self.judged_imbalance = Some(imbalance);
            return Some(Due::Low { why });
        }
        let recent = if self.cycles >= WINDOW / 2 { imbalance } else { self.last_imbalance };
        let too_uneven =
            migrates && recent > self.limits.imbalance && self.lost > SAVED * self.low_cost;
        let proven = self.unproven.is_none() && self.patience == 1;
        if urgency >= URGENT && proven && too_uneven {
            self.judged_imbalance = Some(recent);
            let why = format!("imbalance {recent:.2}, in place of a high one, which is due");
            return Some(Due::Low { why });
        }
        if judged {
            self.last_imbalance = imbalance;
            self.begin_window();
        }
        let why = || {
            let Displacement { moved, margin, share } = displacement;
            format!(
                "worker {worker} has a displacement of {moved:.3e}, {:.0} % of its margin of \
                 {margin:.3e}",
                100.0 * share
            )
        };
        (urgency >= URGENT).then(|| Due::High { why: why() })
    }

    /// Changes the limits of low redecompositions.
    pub fn set_limits(&mut self, imbalance: f64, low_every_at_least: u64) {
        (self.limits.imbalance, self.limits.low_every_at_least) = (imbalance, low_every_at_least);
    }

    /// Records an order that was sent. A low redecomposition begins a new window.
    pub fn ordered(&mut self, number: u64, due: &Due) {
        self.orders_due = number;
        match due {
            // The boxes stay, and so does most of the load: the window goes on.
            Due::High { .. } => self.high += 1,
            Due::Low { .. } => {
                self.low_order = number;
                self.begin_window();
                self.last_imbalance = 1.0;
                self.low += 1;
                self.lost = 0.0;
                self.unproven = self.judged_imbalance.take();
                self.last_low = self.last.iter().map(|r| r.cycle).max();
            }
        }
    }

    /// Records the cost of a low redecomposition [s].
    pub fn low_took(&mut self, seconds: f64) {
        self.low_cost = seconds;
    }

    fn begin_window(&mut self) {
        self.window.iter_mut().for_each(|w| *w = [0.0; 2]);
        self.cycles = 0;
    }
}

/// Returns the largest time without contact plus the largest one of contact of any worker [s].
fn slowest(workers: &[StepLoads]) -> f64 {
    (0..2).map(|kind| workers.iter().map(|w| w[kind]).fold(0.0, f64::max)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn balance() -> Balance {
        Balance::new(
            2,
            BalanceLimits { imbalance: 1.1, low_every_at_least: 50, forced: false, migrates: true },
        )
    }

    /// Elements that do not migrate: neither an imbalance nor the test option cuts new boxes.
    #[test]
    fn there_is_no_repartition_if_elements_stay() {
        for forced in [false, true] {
            let limits =
                BalanceLimits { imbalance: 1.1, low_every_at_least: 50, forced, migrates: false };
            let mut b = Balance::new(2, limits);
            for round in 1..=4 {
                b.add_report(0, report(100 * round, 2e-3, 1.0, 0));
                b.add_report(1, report(100 * round, 1e-3, 0.0, 0));
                assert!(matches!(b.due(), Some(Due::High { .. })), "round {round}, {forced}");
            }
        }
    }

    fn report(cycle: u64, cpu: f32, urgency: f64, order: u64) -> StepReport {
        StepReport {
            cycle,
            cpu: vec![cpu; 100],
            displacement: Displacement::new(urgency, 1.0),
            order,
            elements: 10,
            ..Default::default()
        }
    }

    #[test]
    fn a_lasting_imbalance_calls_for_new_boxes_and_a_slight_one_does_not() {
        let mut b = balance();
        b.add_report(0, report(100, 1e-3, 0.0, 0));
        b.add_report(1, report(100, 1.1e-3, 0.0, 0));
        assert_eq!(b.due(), None);
        b.add_report(0, report(200, 1e-3, 0.0, 0));
        b.add_report(1, report(200, 3e-3, 0.0, 0));
        assert!(matches!(b.due(), Some(Due::Low { .. })));
    }

    #[test]
    fn used_up_motion_calls_for_new_membership_once() {
        let mut b = balance();
        b.add_report(0, report(100, 1e-3, 0.0, 0));
        b.add_report(1, report(100, 1e-3, 0.8, 0));
        let due = b.due().unwrap();
        assert!(matches!(due, Due::High { .. }));
        b.ordered(1, &due);
        assert_eq!(b.due(), None, "the order is pending");
        b.add_report(0, report(200, 1e-3, 0.1, 1));
        b.add_report(1, report(200, 1e-3, 0.1, 1));
        assert_eq!(b.due(), None);
        assert_eq!((b.low, b.high), (0, 1));
    }

    /// Elements migrate in a high redecomposition anyway.
    #[test]
    fn a_high_one_that_is_due_becomes_a_low_one_if_the_load_is_uneven() {
        for (slow, low) in [(1.05e-3, false), (1.5e-3, true)] {
            let mut b = balance();
            let first = |b: &mut Balance, share| {
                b.add_report(0, StepReport { cpu: vec![1e-3; 60], ..report(60, 1e-3, 0.0, 0) });
                let cpu = vec![slow; 60];
                b.add_report(1, StepReport { cpu, ..report(60, 1e-3, share, 0) });
                b.due()
            };
            assert_eq!(first(&mut b, 0.1), None, "too few cycles for a low one alone");
            let mut b = balance();
            let due = first(&mut b, 0.75);
            assert_eq!(matches!(due, Some(Due::Low { .. })), low, "{due:?}");
            assert_eq!(matches!(due, Some(Due::High { .. })), !low, "{due:?}");
        }
    }

    /// One worker has nearly all pairs, the other most messages.
    #[test]
    fn a_pair_costs_what_it_costs_where_there_are_many() {
        let mut b = balance();
        assert_eq!(b.pair_seconds(), f64::INFINITY);
        for (worker, pairs, seconds) in [(0, 500, 1e-3), (1, 20, 0.8e-3)] {
            let mut phase_cpu = [0.0; crumple_proto::report::PHASES.len()];
            phase_cpu[Phase::Contact as usize] = seconds;
            let cpu = vec![1e-3; 1];
            b.add_report(worker, StepReport { pairs, cpu, phase_cpu, ..Default::default() });
            for _ in 0..200 {
                let more = b.last[worker].clone();
                b.add_report(worker, more);
            }
        }
        assert!((b.pair_seconds() - 2e-6).abs() < 1e-9, "{}", b.pair_seconds());
    }

    /// Highs in short succession do not hide that the load is uneven.
    #[test]
    fn the_load_is_judged_across_high_redecompositions() {
        let mut b = Balance::new(2, BalanceLimits { imbalance: 1.1, ..balance().limits });
        let uneven = |b: &mut Balance, cycle, order| {
            b.add_report(0, StepReport { cpu: vec![1e-3; 60], ..report(cycle, 1e-3, 0.0, order) });
            b.add_report(1, StepReport { cpu: vec![3e-3; 60], ..report(cycle, 1e-3, 0.0, order) });
        };
        uneven(&mut b, 60, 0);
        b.ordered(1, &Due::High { why: String::new() });
        uneven(&mut b, 120, 1);
        assert!(matches!(b.due(), Some(Due::Low { .. })));
    }

    #[test]
    fn critical_path_is_the_sum_of_the_slowest() {
        let mut b = balance();
        b.add_report(0, StepReport { cpu: vec![1.0, 2.0], ..Default::default() });
        b.add_report(1, StepReport { cpu: vec![3.0, 1.0], ..Default::default() });
        assert_eq!((b.critical_s, b.total_s), (5.0, 7.0));
    }

    /// After a low redecomposition the share of contact is that of the new boxes.
    #[test]
    fn new_boxes_have_a_share_of_contact_of_their_own() {
        let mut b = balance();
        let with = |of_contact, order| {
            let mut phase_cpu = [0.0; crumple_proto::report::PHASES.len()];
            phase_cpu[Phase::Elements as usize] = 1.0 - of_contact;
            phase_cpu[Phase::Contact as usize] = of_contact;
            StepReport { phase_cpu, ..report(100, 1.0, 0.0, order) }
        };
        for _ in 0..20 {
            b.add_report(0, with(0.5, 0));
            b.add_report(1, with(0.0, 0));
        }
        assert!((b.imbalance() - 1.5).abs() < 1e-9, "{}", b.imbalance());
        b.ordered(1, &Due::Low { why: String::new() });
        b.add_report(0, with(0.25, 1));
        b.add_report(1, with(0.25, 1));
        assert!((b.imbalance() - 1.0).abs() < 1e-9, "{}", b.imbalance());
    }

    /// The sums of both workers are equal, but each waits for the other once per step.
    #[test]
    fn contact_on_one_side_is_an_imbalance_although_the_sums_are_equal() {
        let mut b = balance();
        for (worker, of_contact) in [(0, 0.5), (1, 0.0)] {
            let mut phase_cpu = [0.0; crumple_proto::report::PHASES.len()];
            phase_cpu[Phase::Elements as usize] = 1.0 - of_contact;
            phase_cpu[Phase::Local as usize] = 0.4 * of_contact;
            phase_cpu[Phase::Contact as usize] = 0.6 * of_contact;
            b.add_report(worker, StepReport { phase_cpu, ..report(100, 1.0, 0.0, 0) });
        }
        assert!((b.critical_s - 150.0).abs() < 1e-9, "{}", b.critical_s);
        assert!((b.imbalance() - 1.5).abs() < 1e-9, "{}", b.imbalance());
        assert!(matches!(b.due(), Some(Due::Low { .. })));
    }
}
