//! Eight-node hexahedron with one integration point, after Flanagan & Belytschko 1981.
//!
//! Strain and forces use the exact mean gradient `B_I = (dV/dx_I)/V` (see `modes`), so that
//! distorted elements pass the patch test and the volume strain is that of the element. Stress is
//! stored in global axes. A step, with u the displacement increment and x the coordinates in its
//! middle (Hughes & Winget 1980):
//! ```text
//! K = du/dx,   eps = sym K,   w = half the axis of skew K,   s = sqrt(1 + w.w)
//! R = 1/s + [w]/s + w w'/(s (1 + s))              half the rotation of Cayley's transform
//! sig <- R law(R sig R', eps) R'
//! ```
//! For a rigid rotation by any angle below 180 degrees K is exactly skew and R R is that rotation:
//! it leaves no strain. eps is the logarithmic strain except for terms of third order, changes sign
//! with u, and preserves the volume if the element does. The rate is Jaumann's; it is of second
//! order, as law and rotation are applied symmetrically.
//!
//! Corner forces follow from virtual power with B at x(t); hourglass resistance is in `hourglass`.
//!
//! Bulk viscosity in compression, `q = rho L (b1 c_d d + b2 L d^2)`, with d the rate of -ln V and L
//! equal to c_d times the stable step without viscosity (the side of a cube, or slightly less). It
//! is not part of the stress; its work is internal energy.
//!
//! Stable step: with `G = sum B_I B_I'` and m/8 at each corner, the squared frequencies of the
//! mean-gradient stiffness are the eigenvalues of `eps -> (8 V/m) (sig G + G sig)/2`. The largest
//! one is at most
//! ```text
//! omega^2 <= (8 V/m) (2 mu g + max(lambda, 0) tr G)
//! g = t/3 + sqrt(2/3 (G:G - t^2/3)),   t = tr G
//! ```
//! (Weyl; g bounds the largest eigenvalue of G, Wolkowicz & Styan 1980). The step is exact for
//! cubes and flat bricks, and a few percent too small for needles, where `2/sqrt(8 c_d^2 tr G)` of
//! Flanagan & Belytschko loses up to 27 % at nu = 0.3. Hourglass frequencies are below that for any
//! coefficient allowed here. With viscosity the step is `dt (sqrt(1 + z^2) - z)`, z = b1 + 2 b2 L
//! d/c_d.

mod hourglass;
mod modes;

use self::hourglass::{Hourglass, HourglassStep, apply};
use self::modes::{Gradient, HOURGLASS_MODES, HexahedronModes, gather, modes_of_corners, scatter};
use super::{
    Constructor, Element, ElementEntry, ElementFields, ElementPass, ElementResult, GroupCorners,
    GroupNodes, HourglassForm, PassTotals, SolidGroups, Totals, law_column, zero_failed,
};
use crate::columns::ElementState;
use crate::materials::{Elastic, PointLanes, PointReal, Solid, SolidPoint};
use crate::nodes::NodeView;
use crate::parameter::{DefaultValue, Form, ParameterRow, Range, Values};
use crumple_math::lanes::{Real, dot};
use crumple_proto::job::Part;
use crumple_proto::mesh::{OwnSection, Shape};

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "hexahedron",
    meaning: "One point, exact mean gradient, three forms of hourglass control.",
    shape: Shape::Hex8,
    parameters: [
        &[],
        &[
            ParameterRow {
                key: "hourglass",
                form: Form::Word(HourglassForm::OF_SOLIDS),
                otherwise: DefaultValue::Word(HourglassForm::AssumedStrain.word()),
                range: None,
                meaning: "Hourglass control. `assumed_strain` gives correct bending without a \
                          coefficient and does not lock as nu approaches 1/2 \
                          (`cases/studies/README.md`, hourglass-solids and incompressible).",
            },
            ParameterRow {
                key: "hourglass_coefficient",
                form: Form::Number,
                otherwise: DefaultValue::Number(0.05),
                range: Some(Range {
                    wanted: "from 0 to 0.5 for solids (0.05 is usual)",
                    fits: |r| (0.0..=0.5).contains(&r),
                }),
                meaning: "Hourglass coefficient: fraction of the stiffness of the element, or of \
                          critical damping; `assumed_strain` has none. See \
                          `cases/studies/README.md`, hourglass-solids.",
            },
            ParameterRow {
                key: "bulk_viscosity",
                form: Form::Numbers(2),
                otherwise: DefaultValue::Numbers(&[0.06, 1.5]),
                range: Some(Range {
                    wanted: "[linear, quadratic], each from 0 to 10",
                    fits: |b| (0.0..=10.0).contains(&b),
                }),
                meaning: "Bulk viscosity in compression: linear coefficient, as a fraction of \
                          critical damping, and quadratic coefficient (`cases/studies/README.md`, \
                          viscosity).",
            },
        ],
    ],
    idle: |values| match HourglassForm::from_word(&values.word("hourglass")) {
        HourglassForm::AssumedStrain => {
            &[("hourglass_coefficient", "hourglass = \"assumed_strain\" has no coefficient")]
        }
        HourglassForm::Stiffness | HourglassForm::Viscous => &[],
    },
    build: Constructor::Solid(build),
};

/// Largest strain increment of a valid step.
const STRAIN_LIMIT: f64 = 0.5;
/// Number of stress components, at the start of the law's state.
const STRESS: usize = 6;
/// Number of columns between the law's state and hourglass: volume at the start [length^3], bulk
/// viscosity [force/length^2].
const OWN: usize = 2;

/// Parameters of the hexahedron.
pub struct Hexahedron {
    law: Box<dyn Solid>,
    elastic: Elastic,
    hourglass: Hourglass,
    /// b1 and b2.
    bulk_viscosity: [f64; 2],
    /// Number of columns of stress and of the law.
    state: usize,
    /// Column of the law with its effective plastic strain, if it has any.
    plastic_strain: Option<usize>,
    /// Column of the law that marks failure, if it can fail.
    failed: Option<usize>,
}

fn build(_: &Part, values: &Values<'_>, law: Box<dyn Solid>) -> ElementResult {
    let elastic = law.elastic();
    let (history, poisson) = (law.history(), elastic.poisson);
    debug_assert!(poisson < 0.5, "laws of solids require a finite bulk modulus");
    Ok(Box::new(Hexahedron {
        elastic,
        hourglass: Hourglass {
            form: HourglassForm::from_word(&values.word("hourglass")),
            coefficient: values.number("hourglass_coefficient"),
        },
        bulk_viscosity: values.numbers("bulk_viscosity"),
        state: STRESS + history.len(),
        plastic_strain: law_column(history, "plastic_strain", STRESS),
        failed: law_column(history, "failed", STRESS),
        law,
    }))
}

/// Shape of an element at the end of a step.
struct EndShape<R> {
    gradient: Gradient<R>,
    /// One over 64 V [1/length^3].
    inverse64: R,
    /// Density [mass/length^3].
    density: R,
    /// See [`Gradient::gram`] [1/length^2].
    gram: [R; 6],
    /// 1/c_d [time/length], and the stable step without viscosity times c_d [length].
    slowness: R,
    length: R,
}

/// Result of a kernel for a group, in global axes.
struct HexahedronResponse<R: Real> {
    /// Forces of the modes [force]. Corner forces are their sums with the signs of the modes.
    force: HexahedronModes<R>,
    totals: Totals<R>,
}

impl<R: Real> HexahedronResponse<R> {
    /// Removes failed elements: they have no forces, do not limit the step and are never reported
    /// as trouble.
    #[inline(always)]
    fn zero_failed(&mut self, failed: R::Mask) {
        zero_failed(failed, self.force.as_flattened_mut());
        self.totals.zero_failed(failed);
    }
}

impl Hexahedron {
    /// Computes one element in each lane. The reference kernel and the fast kernel are this one
    /// function.
    #[inline(always)]
    fn respond<R: PointReal>(
        &self,
        x: &HexahedronModes<R>,
        v: &HexahedronModes<R>,
        history: &mut [R],
        dt: f64,
    ) -> HexahedronResponse<R> {
        let (state, own) = history.split_at_mut(self.state);
        let ([first_volume, viscosity], hourglass) =
            own.split_first_chunk_mut().expect("the history has columns() values");
        // Before the first step nothing has moved, so all rates are zero.
        let per_time = if dt > 0.0 { 1.0 / dt } else { 0.0 };
        let half = R::splat(0.5);

        // 1. Kinematics in the middle of the step.
        let back = R::splat(0.5 * dt);
        let mid: HexahedronModes<R> =
            std::array::from_fn(|k| std::array::from_fn(|i| back.neg_mul_add(v[k][i], x[k][i])));
        let mid_gradient = Gradient::new(&mid);
        let k = mid_gradient.gradient_of(v, dt);
        let eps =
            [k[0][0], k[1][1], k[2][2], k[0][1] + k[1][0], k[1][2] + k[2][1], k[2][0] + k[0][2]];
        let turn = half_turn([k[2][1] - k[1][2], k[0][2] - k[2][0], k[1][0] - k[0][1]]);

        // 2. Shape at the end of the step, before stress, so that the root and the quotient of the
        //    rotation are ready when they are used.
        let EndShape { gradient, inverse64, density, gram, slowness, length } =
            self.end(x, first_volume);

        // 3. Stress.
        let before = rotated(&turn, state);
        state[..STRESS].copy_from_slice(&before);
        let left = R::update_solid(&*self.law, SolidPoint { state, strain: &eps }, dt);
        let after: [R; STRESS] = std::array::from_fn(|c| state[c]);
        let stress = rotated(&turn, state);
        state[..STRESS].copy_from_slice(&stress);

        // 4. Bulk viscosity, in compression only.
        let rate = Real::max(R::splat(-per_time) * (eps[0] + eps[1] + eps[2]), R::zero());
        let [b1, b2] = self.bulk_viscosity.map(R::splat);
        let rate = length * rate;
        let quadratic = b2 * rate;
        let q = rate * density.mul_add(quadratic, b1 * R::splat(self.modulus()) * slowness);
        let stable_dt = viscous(length * slowness, (quadratic + quadratic).mul_add(slowness, b1));

        // 5. Hourglass.
        let of_mode = |a: usize| {
            let (v, x) = (&v[3 + a], mid[3 + a]);
            std::array::from_fn(|i| {
                let field =
                    k[i][1].neg_mul_add(x[1], k[i][2].neg_mul_add(x[2], R::splat(dt) * v[i]));
                k[i][0].neg_mul_add(x[0], field)
            })
        };
        let step = HourglassStep {
            mid: &mid,
            mid_gradient: &mid_gradient,
            end: x,
            end_gradient: &gradient,
            q: std::array::from_fn(of_mode),
            half_turn: &turn,
            gram_trace: gram[0] + gram[1] + gram[2],
            density,
            left,
            per_time,
        };
        let (resistance, resisted) = self.hourglass.update(&self.elastic, &step, hourglass);

        // 6. Forces of the modes: all factors of B are one tensor.
        let mut force = [[R::zero(); 3]; 7];
        let [xx, yy, zz, xy, yz, zx] = stress;
        // The gradient has 64 times the derivatives of the volume.
        let scale = R::splat(1.0 / 64.0);
        let [xx, yy, zz, xy, yz, zx] = [xx - q, yy - q, zz - q, xy, yz, zx].map(|s| scale * s);
        let rows = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
        let tensor: [[R; 3]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|j| {
                let mut sum = resistance[0][i] * x[3][j];
                for a in 1..HOURGLASS_MODES {
                    sum = resistance[a][i].mul_add(x[3 + a][j], sum);
                }
                sum.neg_mul_add(inverse64, rows[i][j])
            })
        });
        for (force, b) in force.iter_mut().zip(&gradient.b) {
            *force = apply(&tensor, *b);
        }
        for a in 0..HOURGLASS_MODES {
            (0..3).for_each(|i| force[3 + a][i] += resistance[a][i]);
        }

        // 7. Energy and validity. The sum is not finite if any of its terms is not.
        let mean: [R; STRESS] = std::array::from_fn(|c| half * (before[c] + after[c]));
        let mut work = -(half * (*viscosity + q) * (eps[0] + eps[1] + eps[2]));
        *viscosity = q;
        let mut total = R::zero();
        let mut largest = R::zero();
        for c in 0..STRESS {
            work = mean[c].mul_add(eps[c], work);
            let size = if c < 3 { eps[c].abs() } else { half * eps[c].abs() };
            largest = Real::max(largest, size);
            total += size;
        }
        for mode in &force {
            total += mode[0] + mode[1] + mode[2];
        }
        let whole = gradient.whole();
        let calm =
            R::both(largest.le(R::splat(STRAIN_LIMIT)), total.abs().le(R::splat(R::LARGEST)));
        let sound = R::both(whole, calm);
        let internal = work * mid_gradient.volume();
        let mut response = HexahedronResponse {
            force,
            totals: Totals { stable_dt, internal, hourglass: resisted, sound },
        };
        if let Some(column) = self.failed {
            let failed = state[column].gt(half);
            response.zero_failed(failed);
            zero_failed(failed, hourglass);
        }
        response
    }

    /// Computes the shape at these coordinates. Sets the volume at the start if there is none yet.
    #[inline(always)]
    fn end<R: Real>(&self, x: &HexahedronModes<R>, first_volume: &mut R) -> EndShape<R> {
        let gradient = Gradient::new(x);
        let inverse64 = R::splat(1.0) / gradient.volume64;
        let volume = gradient.volume();
        *first_volume = R::select(first_volume.gt(R::zero()), *first_volume, volume);
        let density = R::splat(64.0 * self.elastic.density) * *first_volume * inverse64;
        let gram = gradient.gram(inverse64);
        let slowness = (density * R::splat(1.0 / self.modulus())).sqrt();
        let length = self.length(&gram);
        EndShape { gradient, inverse64, density, gram, slowness, length }
    }

    /// Returns the column of the volume at the start.
    fn first_volume(&self) -> usize {
        self.state
    }

    /// Returns lambda + 2 mu [force/length^2].
    fn modulus(&self) -> f64 {
        self.elastic.lame() + 2.0 * self.elastic.shear_modulus()
    }

    /// Returns the stable step without viscosity times c_d, from `sum B_I B_I'` [length].
    #[inline(always)]
    fn length<R: Real>(&self, gram: &[R; 6]) -> R {
        let [a, b, c, d, e, f] = *gram;
        let trace = a + b + c;
        let third = R::splat(1.0 / 3.0) * trace;
        let [a, b, c] = [a - third, b - third, c - third];
        let square = dot([a, b, c], [a, b, c]) + R::splat(2.0) * dot([d, e, f], [d, e, f]);
        let largest = third + (R::splat(2.0 / 3.0) * square).sqrt();
        let elastic = &self.elastic;
        let stiffness = R::splat(elastic.lame().max(0.0)) * trace
            + R::splat(2.0 * elastic.shear_modulus()) * largest;
        // 2 c_d/omega with omega^2 = 8 stiffness/density.
        (R::splat(0.5 * self.modulus()) / stiffness).sqrt()
    }
}

/// Returns the stable step with damping; z is the fraction of critical damping.
#[inline(always)]
fn viscous<R: Real>(step: R, z: R) -> R {
    step * (z.mul_add(z, R::splat(1.0)).sqrt() - z)
}

/// Returns the rotation of half the step from twice the axis of skew K, with one division.
#[inline(always)]
fn half_turn<R: Real>(twice: [R; 3]) -> [[R; 3]; 3] {
    let [one, quarter] = [1.0, 0.25].map(R::splat);
    let w = twice.map(|c| quarter * c);
    let s = (one + dot(w, w)).sqrt();
    let along = one / s.mul_add(s, s);
    let cos = along.mul_add(s, along);
    let spin = w.map(|c| cos * c);
    let r = w.map(|c| along * c);
    let dyad = |i: usize, j: usize| r[i] * w[j];
    let (xy, yz, zx) = (dyad(0, 1), dyad(1, 2), dyad(2, 0));
    [
        [r[0].mul_add(w[0], cos), xy - spin[2], zx + spin[1]],
        [xy + spin[2], r[1].mul_add(w[1], cos), yz - spin[0]],
        [zx - spin[1], yz + spin[0], r[2].mul_add(w[2], cos)],
    ]
}

/// Returns `R sig R'` of the stress at the start of `state`.
#[inline(always)]
fn rotated<R: Real>(turn: &[[R; 3]; 3], state: &[R]) -> [R; STRESS] {
    let [xx, yy, zz, xy, yz, zx]: [R; STRESS] = std::array::from_fn(|c| state[c]);
    let columns = [[xx, xy, zx], [xy, yy, yz], [zx, yz, zz]];
    let half: [[R; 3]; 3] =
        std::array::from_fn(|i| std::array::from_fn(|j| dot(turn[i], columns[j])));
    // Written out, because a loop over pairs of indices becomes a call, which moves all registers
    // to memory.
    let at = |i: usize, j: usize| dot(half[i], turn[j]);
    [at(0, 0), at(1, 1), at(2, 2), at(0, 1), at(1, 2), at(2, 0)]
}

/// Returns the eight slots of a solid.
///
/// # Panics
/// If there are fewer than eight slots. Callers pass all slots of a solid.
fn per_corner(x: &[[f64; 3]]) -> &[[f64; 3]; 8] {
    x.first_chunk().expect("a hexahedron has eight slots")
}

impl SolidGroups for Hexahedron {
    #[inline(always)]
    fn group<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<8, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
        dt: f64,
        force: &mut GroupCorners<8, W>,
    ) -> Totals<L> {
        let [x, v] = gather(group, [nodes.x, nodes.v]);
        let response = self.respond(&x, &v, history, dt);
        scatter(&response.force, force);
        response.totals
    }

    #[inline(never)]
    fn forceless<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<8, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
    ) -> Totals<L> {
        let [x, _] = gather(group, [nodes.x, nodes.v]);
        let EndShape { gradient, slowness, length, .. } =
            self.end(&x, &mut history[self.first_volume()]);
        let [b1, _] = self.bulk_viscosity;
        Totals::inactive(viscous(length * slowness, L::splat(b1)), gradient.whole())
    }
}

impl Element for Hexahedron {
    fn columns(&self) -> usize {
        self.state + OWN + hourglass::COLUMNS
    }

    fn names(&self) -> Vec<String> {
        let stress = ["xx", "yy", "zz", "xy", "yz", "zx"].map(|c| format!("stress {c}"));
        let law = self.law.history().iter().map(|name| name.to_string());
        let own = ["volume at start", "bulk viscosity"].map(String::from);
        let hourglass = (0..hourglass::COLUMNS).map(|k| format!("hourglass {k}"));
        stress.into_iter().chain(law).chain(own).chain(hourglass).collect()
    }

    fn any_precision(&self) -> bool {
        true
    }

    fn corner_mass(&self, x: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        (
            0.125 * self.elastic.density * Gradient::new(&modes_of_corners(per_corner(x))).volume(),
            0.0,
        )
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        pass.solids(self.columns(), self)
    }

    /// Without the viscosity that is quadratic in the rate.
    fn stable_dt(&self, x: &[[f64; 3]], _: OwnSection) -> f64 {
        let gradient = Gradient::new(&modes_of_corners(per_corner(x)));
        if !gradient.whole() {
            return f64::NAN;
        }
        let [b1, _] = self.bulk_viscosity;
        let speed = self.elastic.dilatational_wave_speed();
        self.length(&gradient.gram(1.0 / gradient.volume64)) / speed * ((1.0 + b1 * b1).sqrt() - b1)
    }

    fn stable_dt_now(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        let (first, volume) = (
            history.at(self.first_volume()),
            Gradient::new(&modes_of_corners(per_corner(x))).volume(),
        );
        self.stable_dt(x, OwnSection::default())
            * if first > 0.0 { (first / volume).sqrt() } else { 1.0 }
    }

    fn is_unstrained(&self, history: ElementState<'_>) -> bool {
        history.is_zero_where(|column| column != self.first_volume())
    }

    fn failed(&self, history: ElementState<'_>) -> bool {
        self.failed.is_some_and(|column| history.at(column) > 0.5)
    }

    fn can_fail(&self) -> bool {
        self.failed.is_some()
    }

    fn fields(&self, history: ElementState<'_>, _x: &[[f64; 3]]) -> ElementFields {
        let at = |column: usize| history.at(column);
        let stress: [f64; STRESS] = std::array::from_fn(at);
        let [x, y, z, xy, yz, zx] = stress;
        let direct = (x - y) * (x - y) + (y - z) * (y - z) + (z - x) * (z - x);
        ElementFields {
            plastic_strain: self.plastic_strain.map_or(0.0, at),
            stress,
            von_mises: (0.5 * direct + 3.0 * (xy * xy + yz * yz + zx * zx)).sqrt(),
            thickness: 0.0,
            failed: self.failed(history),
        }
    }
}

#[cfg(test)]
#[path = "hexahedron_scenes.rs"]
mod scenes;
#[cfg(test)]
#[path = "hexahedron_tests.rs"]
mod tests;
