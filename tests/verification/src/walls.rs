//! Impact of bars on rigid walls, elastic (A03) and elastic-plastic (A06). See `bars.rs` for the
//! bars.

use super::bars::{BAR, SOFT, stopped};
use super::bench::Finished;
use super::laws::{UNDAMPED, is_spring};
use super::measure::{Push, displacement, mass, mean_velocity};
use super::row::CheckRow;
use super::scene::{Elastic, Grid, Scene};
use super::{Bench, Check};

/// Check of A03 (a).
pub const TRUSS: Check = Check { name: "truss impact", quick: true, run: truss };
/// Check of A03 (c).
pub const ROD: Check = Check { name: "rod at a wall", quick: true, run: rod };
/// Check of A03: wall and contact laws.
pub const TARGETS: Check = Check { name: "wall and contact laws agree", quick: true, run: targets };
/// Check of A06.
pub const PLASTIC: Check = Check { name: "elastic-plastic wave", quick: true, run: plastic };

/// A bar that flies along -x.
#[derive(Clone, Copy)]
struct Flight {
    material: Elastic,
    length: f64,
    /// Area to which forces refer [m^2].
    area: f64,
    velocity: f64,
    gap: f64,
}

/// Obstacle in its path.
#[derive(Clone, Copy)]
enum Target<'a> {
    Wall,
    /// A fixed shell with this contact law.
    Shell(&'a str),
}

struct Struck {
    /// Times of the first and the last push [s].
    span: (f64, f64),
    /// Mean force over the plateau, for the whole area [N].
    force: f64,
    /// Impulse from the target, for the whole area [N s].
    impulse: f64,
    /// Velocity of the bar at the end [m/s].
    rebound: f64,
    /// Energy taken by the target, as a fraction.
    lost: f64,
    run: Finished,
}

/// Thickness of the shells [m], smaller than any side, see `bars.rs`.
const THICKNESS: f64 = 1e-3;

impl Flight {
    fn duration(&self) -> f64 {
        2.0 * self.length / self.material.c()
    }

    fn force(&self) -> f64 {
        self.material.rho * self.material.c() * self.velocity * self.area
    }

    fn strip(&self, scene: &mut Scene, n: usize, from: f64) -> Grid {
        let width = self.length / n as f64;
        scene.grid(1, [n, 1], |x, y| [from + self.length * x, width * y, 0.0])
    }

    fn run(
        &self,
        bench: &Bench,
        name: &str,
        n: usize,
        target: Target<'_>,
    ) -> Result<Struck, String> {
        let touch = self.gap / self.velocity;
        let mut scene = Scene::new(touch + 1.6 * self.duration());
        let width = self.length / n as f64;
        // Shells touch shells at the mean thickness, walls at their nodes.
        let air = if let Target::Shell(_) = target { THICKNESS } else { 0.0 };
        let bar = self.strip(&mut scene, n, air + self.gap);
        scene.elastic("bar", self.material);
        scene.part(1, "bar", THICKNESS, "points = 2");
        scene.start(bar.all(), [-self.velocity, 0.0, 0.0], [0.0; 3]);
        match target {
            Target::Wall => scene.wall([0.0; 3], [1.0, 0.0, 0.0], 0.0),
            Target::Shell(law) => {
                let shell = scene.grid(2, [1, 1], |x, y| [width * (x - 1.0), width * y, 0.0]);
                scene.part(2, "bar", THICKNESS, "points = 2");
                scene.fix(shell.all(), "x y z rx ry rz");
                scene.add(&format!("[contact]\nlaw = \"{law}\"\n{UNDAMPED}"));
            }
        }
        let (mut push, v) = (Push::default(), self.velocity);
        let run = bench.watch(name, &scene, |e| {
            let gained = mass(e, bar.all()) * (mean_velocity(e, bar.all(), 0) + v);
            push.add_sample(e.clock.time - 0.5 * e.clock.last_dt, gained);
        })?;
        let whole = self.area / (width * THICKNESS);
        let time = self.duration();
        Ok(Struck {
            span: push.span(0.5 * self.force() / whole, 0.05 * time),
            force: whole * push.mean_force(touch + 0.1 * time, touch + 0.9 * time),
            impulse: whole * push.total(),
            rebound: mean_velocity(&run.engine, bar.all(), 0),
            lost: -(run.energies.wall + run.energies.contact) / run.initial,
            run,
        })
    }
}

fn truss(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let material = Elastic { e: 200e9, nu: 0.0, rho: 7800.0 };
    let flight = Flight { material, length: 2.0, area: 0.2, velocity: 1.5, gap: 1e-3 };
    const D: &str = "[V:S5] set-up, [D] 2L/(c+v), rho v (c+v) A";
    let mut all = Vec::new();
    for n in [5, 10, 100] {
        let s = flight.run(bench, &format!("A03a wall {n}"), n, Target::Wall)?;
        let variant = format!("wall, {n} shells");
        // Five or ten elements do not resolve a front: duration and force have bounds on the
        // fine mesh only.
        let fine = |row: CheckRow, reference| {
            if n == 100 { row.near(reference, 0.01, D) } else { row.reference(reference, D) }
        };
        all.push(fine(CheckRow::new("time of impact", &variant, "us", 1e6 * s.span.0), 666.7));
        all.push(fine(
            CheckRow::new("contact duration", &variant, "us", 1e6 * (s.span.1 - s.span.0)),
            1e6 * 4.0 / (material.c() + 1.5),
        ));
        all.push(fine(CheckRow::new("mean force", &variant, "MN", 1e-6 * s.force), 11.85));
        all.push(fine(CheckRow::new("rebound velocity", &variant, "m/s", s.rebound), 1.5));
        all.push(fine(CheckRow::new("impulse 2 rho L A v", &variant, "N s", s.impulse), 9360.0));
        // The manual of [V:S5] gives the loss 1/2N: 10 % with 5 elements, 5 % with 10.
        all.push(stopped(
            CheckRow::new("energy lost at the wall / E0", &variant, "", s.lost),
            0.5 / n as f64,
        ));
        all.extend(s.run.energy_rows(&variant, 1e-3));
    }
    Ok(all)
}

const ROD_FLIGHT: Flight = Flight {
    material: Elastic { e: 206.84e9, nu: 0.0, rho: 7801.0 },
    length: 0.254,
    area: 6.4516e-4,
    velocity: 5.1359,
    gap: 0.254e-3,
};

fn rod(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let s = ROD_FLIGHT.run(bench, "A03c wall 100", 100, Target::Wall)?;
    let variant = "rod at a wall, 100 shells";
    Ok(s.run.with_energy(
        variant,
        1e-3,
        vec![
            CheckRow::new("time of impact", variant, "us", 1e6 * s.span.0).near(
                49.46,
                0.01,
                "[V:S7] 0.00005 s, [D]",
            ),
            CheckRow::new("contact duration 2L/c", variant, "us", 1e6 * (s.span.1 - s.span.0))
                .near(98.66, 0.01, "[D]"),
            CheckRow::new("mean force rho c v A", variant, "kN", 1e-3 * s.force)
                .near(133.1, 0.01, "[D]"),
            CheckRow::new("rebound velocity", variant, "m/s", s.rebound).near(5.1359, 0.01, "[D]"),
            s.run.closing_row(variant, 1e-3),
        ],
    ))
}

fn targets(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    let f = ROD_FLIGHT;
    let expected = 2.0 * f.material.rho * f.length * f.area * f.velocity;
    let row = |variant: &str, s: &Struck| {
        CheckRow::new("impulse 2 rho L A v", variant, "N s", s.impulse).near(expected, 0.01, "[D]")
    };
    let mut all = vec![row("wall", &f.run(bench, "A03c wall", 100, Target::Wall)?)];
    for law in bench.laws() {
        let s = f.run(bench, &format!("A03c {law}"), 100, Target::Shell(law))?;
        let variant = format!("{law}, on a fixed shell");
        all.push(row(&variant, &s).known(if is_spring(law) { SOFT } else { "" }));
        all.extend(s.run.energy_rows(&variant, 1e-3));
    }
    Ok(all)
}

fn plastic(bench: &Bench) -> Result<Vec<CheckRow>, String> {
    const N: usize = 200;
    let (length, v, yield_stress) = (1.0, 20.0, 200e6);
    let tangent = BAR.e / 100.0;
    // True stress over logarithmic plastic strain.
    let modulus = BAR.e * tangent / (BAR.e - tangent);
    let time = length / BAR.c();
    let mut scene = Scene::new(1.8 * time);
    let width = length / N as f64;
    let bar = scene.grid(1, [N, 1], |x, y| [length * x, width * y, 0.0]);
    scene.plastic("steel", BAR, yield_stress, modulus);
    scene.part(1, "steel", THICKNESS, "points = 2\nthinning = true");
    scene.start(bar.all(), [-v, 0.0, 0.0], [0.0; 3]);
    scene.wall([0.0; 3], [1.0, 0.0, 0.0], 0.0);
    let mut push = Push::default();
    let run = bench.watch("A06 wall", &scene, |e| {
        push.add_sample(e.clock.time, e.constraints.walls.impulse(0)[0])
    })?;
    // Behind the plastic front, 0.16 m from the wall at the end.
    let [from, to] = [0.02, 0.1].map(|x| bar.at((x * N as f64) as usize, 0));
    let strain = (displacement(&run.engine, from)[0] - displacement(&run.engine, to)[0]) / 0.08;
    let stress = push.mean_force(0.4 * time, 1.7 * time) / (width * THICKNESS);
    let variant = "wall, 200 shells, j2";
    let (finite_stress, finite_strain) =
        plastic_shock(yield_stress, tangent, v - yield_stress / (BAR.rho * BAR.c()));
    // At 3 % compression stiffens the nominal tangent E_t by 2 sigma_y/E_t: the catalogue
    // assumes small strains.
    Ok(run.with_energy(
        variant,
        1e-3,
        vec![
            CheckRow::new("stress behind the plastic front", variant, "MPa", 1e-6 * stress)
                .reference(261.2, "[D] sigma_y + rho c_t (V - v_y), small strains"),
            CheckRow::new("strain behind the plastic front", variant, "", strain)
                .reference(0.0301, "[D] sigma_y/E + (V - v_y)/c_t, small strains"),
            CheckRow::new(
                "stress behind the plastic front, finite strain",
                variant,
                "MPa",
                1e-6 * stress,
            )
            .near(1e-6 * finite_stress, 0.02, "[D] shock in nominal stress"),
            CheckRow::new("strain behind the plastic front, finite strain", variant, "", strain)
                .near(finite_strain, 0.02, "[D] shock in nominal stress"),
        ],
    ))
}

/// Returns the nominal stress [Pa] and strain behind a plastic shock that changes the velocity
/// by `jump` [m/s]. The true stress is `sigma_y + E_t (e - sigma_y/E)` over the logarithmic
/// strain e, and plastic flow conserves volume: the area grows by `exp(e - sigma/E)`. Across a
/// shock `rho jump^2 = (P - P_y) (eps - eps_y)`.
pub fn plastic_shock(yield_stress: f64, tangent: f64, jump: f64) -> (f64, f64) {
    let at_yield = yield_stress / BAR.e;
    let nominal = |strain: f64| {
        let e = -(1.0 - strain).ln();
        let stress = yield_stress + tangent * (e - at_yield);
        stress * (e - stress / BAR.e).exp()
    };
    let (mut low, mut high) = (at_yield, 0.5);
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        let jumped = (nominal(middle) - nominal(at_yield)) * (middle - at_yield);
        if jumped < BAR.rho * jump * jump { low = middle } else { high = middle }
    }
    (nominal(low), low)
}
