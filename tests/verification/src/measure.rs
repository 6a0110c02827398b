//! Quantities measured in a run: nodes, stresses, frequencies, forces from impulses.

use crumple_worker::engine::Engine;
use crumple_worker::fem::elements::ElementFields;
use crumple_worker::math::row::{row, xyz};

/// Returns the index of a node in the columns: on one engine nodes are in ascending id, from 1.
fn place(node: u32) -> usize {
    node as usize - 1
}

/// Returns the coordinates of a node [m].
pub fn position(e: &Engine, node: u32) -> [f64; 3] {
    xyz(&e.nodes.x[place(node)])
}

/// Returns the displacement of a node [m].
pub fn displacement(e: &Engine, node: u32) -> [f64; 3] {
    let (x, x0) = (e.nodes.x[place(node)], e.nodes.x0[place(node)]);
    [x[0] - x0[0], x[1] - x0[1], x[2] - x0[2]]
}

/// Counts the folds along a line of nodes, given their outward displacements [m]: the reversals by
/// more than `least` from the last extreme.
pub fn folds(line: impl IntoIterator<Item = f64>, least: f64) -> usize {
    let (mut folds, mut extreme, mut outward) = (0, 0.0f64, None);
    for u in line {
        let past = match outward {
            Some(true) => extreme - u,
            Some(false) => u - extreme,
            None => u.abs(),
        };
        if past > least {
            outward = Some(outward.map_or(u > 0.0, |outward| !outward));
            (folds, extreme) = (folds + 1, u);
        } else if outward.is_some_and(|outward| (u > extreme) == outward) {
            extreme = u;
        }
    }
    folds
}

/// Position [m] and rotation vector [1].
pub type Pose = ([f64; 3], [f64; 3]);

/// Makes the step just done one that moved a fixed node from one pose to another.
pub fn lead(e: &mut Engine, node: u32, from: Pose, to: Pose) {
    let dt = e.clock.last_dt;
    let rate = |a: [f64; 3], b: [f64; 3]| row(std::array::from_fn(|c| (b[c] - a[c]) / dt));
    let n = place(node);
    e.nodes.x[n] = row(to.0);
    e.nodes.v[n] = rate(from.0, to.0);
    if e.nodes.rotations {
        e.nodes.w[n] = rate(from.1, to.1);
    }
}

/// Sets the velocities of a node [m/s], [1/s]; a fixed node keeps them.
pub fn drive(e: &mut Engine, node: u32, velocity: [f64; 3], spin: [f64; 3]) {
    let n = place(node);
    e.nodes.v[n] = row(velocity);
    if e.nodes.rotations {
        e.nodes.w[n] = row(spin);
    }
}

/// Returns the mass of nodes [kg].
pub fn mass(e: &Engine, nodes: &[u32]) -> f64 {
    nodes.iter().map(|&n| e.nodes.mass[place(n)]).sum()
}

/// Returns the velocity of the centre of mass of nodes along axis `c` at the last mid-step
/// [m/s].
pub fn mean_velocity(e: &Engine, nodes: &[u32], c: usize) -> f64 {
    nodes.iter().map(|&n| e.nodes.mass[place(n)] * e.nodes.v[place(n)][c]).sum::<f64>()
        / mass(e, nodes)
}

/// Returns the contact force on nodes in the last step, along axis `c` [N].
pub fn contact_force(e: &Engine, nodes: &[u32], c: usize) -> f64 {
    e.contact.iter().flat_map(|contact| nodes.iter().map(|&n| contact.force_on(n - 1)[c])).sum()
}

/// Returns the displacement projected on a shape, `sum m u_c phi / sum m phi^2`.
pub fn amplitude(e: &Engine, shape: &[(u32, f64)], c: usize) -> f64 {
    let (mut over, mut under) = (0.0, 0.0);
    for &(n, phi) in shape {
        let m = e.nodes.mass[place(n)];
        over += m * phi * displacement(e, n)[c];
        under += m * phi * phi;
    }
    over / under
}

/// Returns the fields of all elements, in ascending id. The stress is that of the previous time;
/// its axes are those of the present time.
pub fn fields(e: &Engine) -> Vec<ElementFields> {
    fields_at(e, 0.0)
}

/// Returns the fields of all elements with the axes of the previous time, to which the stress
/// belongs.
pub fn fields_before(e: &Engine) -> Vec<ElementFields> {
    fields_at(e, e.clock.last_dt)
}

/// Returns the fields of all elements with the axes of the time `ago` before the present one
/// [s]. The positions of that time follow from the present velocities.
fn fields_at(e: &Engine, ago: f64) -> Vec<ElementFields> {
    let mut all = Vec::new();
    for b in &e.blocks.blocks {
        for (i, element) in e.blocks.elements[b.first..b.first + b.count].iter().enumerate() {
            let x = element.nodes.map(|n| {
                let (x, v) = (xyz(&e.nodes.x[n as usize]), xyz(&e.nodes.v[n as usize]));
                std::array::from_fn(|c| x[c] - ago * v[c])
            });
            all.push((element.record.id, b.element.fields(b.state(i), &x)));
        }
    }
    all.sort_by_key(|f| f.0);
    all.into_iter().map(|f| f.1).collect()
}

/// Zero crossings of a signal.
#[derive(Debug, Default)]
pub struct Crossings {
    last: Option<(f64, f64)>,
    times: Vec<f64>,
}

impl Crossings {
    /// Adds the value of the signal at a time.
    pub fn add_sample(&mut self, time: f64, value: f64) {
        if let Some((t, v)) = self.last
            && v * value < 0.0
        {
            self.times.push(t + (time - t) * v / (v - value));
        }
        self.last = Some((time, value));
    }

    /// Returns the frequency from the first crossing to the last; NaN for fewer than three
    /// crossings.
    pub fn frequency(&self) -> f64 {
        match self.times.as_slice() {
            [first, .., last] if self.times.len() > 2 => {
                0.5 * (self.times.len() - 1) as f64 / (last - first)
            }
            _ => f64::NAN,
        }
    }
}

/// A force given by its accumulated impulse.
#[derive(Debug, Default)]
pub struct Push {
    samples: Vec<(f64, f64)>,
}

impl Push {
    /// Adds the accumulated impulse at a time.
    pub fn add_sample(&mut self, time: f64, impulse: f64) {
        self.samples.push((time, impulse));
    }

    /// Returns the impulse at a time, interpolated linearly between samples.
    pub fn impulse(&self, time: f64) -> f64 {
        let i = self.samples.partition_point(|s| s.0 < time).clamp(1, self.samples.len() - 1);
        let ((t0, p0), (t1, p1)) = (self.samples[i - 1], self.samples[i]);
        p0 + (p1 - p0) * ((time - t0) / (t1 - t0)).clamp(0.0, 1.0)
    }

    /// Returns the mean force between two times.
    pub fn mean_force(&self, from: f64, to: f64) -> f64 {
        (self.impulse(to) - self.impulse(from)) / (to - from)
    }

    /// Returns the total impulse.
    pub fn total(&self) -> f64 {
        self.samples.last().map_or(0.0, |s| s.1)
    }

    /// Returns the times at which the force, as a mean over `window`, first rises above and last
    /// falls below `half`. A front that is spread by dispersion passes half its height at the
    /// time of the sharp one.
    pub fn span(&self, half: f64, window: f64) -> (f64, f64) {
        let force = |t: f64| self.mean_force(t - 0.5 * window, t + 0.5 * window) - half;
        // Linear interpolation between the samples on either side.
        let crossing = |pair: &[(f64, f64)]| {
            let (a, b) = (force(pair[0].0), force(pair[1].0));
            ((a <= 0.0) != (b <= 0.0)).then(|| pair[0].0 + (pair[1].0 - pair[0].0) * a / (a - b))
        };
        let mut crossings = self.samples.windows(2).filter_map(crossing);
        let first = crossings.next().unwrap_or(f64::NAN);
        let last = crossings.next_back().unwrap_or(f64::NAN);
        (first, last)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sine_has_its_frequency_and_a_square_push_its_ends() {
        let mut c = Crossings::default();
        (0..1000)
            .map(|i| f64::from(i) * 1e-3)
            .for_each(|t| c.add_sample(t, (std::f64::consts::TAU * 7.3 * t).sin()));
        assert!((c.frequency() - 7.3).abs() < 1e-3, "linear between samples: {}", c.frequency());
        let mut p = Push::default();
        (0..=1000)
            .map(|i| f64::from(i) * 1e-3)
            .for_each(|t| p.add_sample(t, 5.0 * (t.clamp(0.2, 0.7) - 0.2)));
        assert!((p.total() - 2.5).abs() < 1e-12 && (p.mean_force(0.3, 0.6) - 5.0).abs() < 1e-9);
        let (on, off) = p.span(2.5, 0.02);
        assert!((on - 0.2).abs() < 2e-3 && (off - 0.7).abs() < 2e-3, "to a sample: {on} {off}");
    }
}
