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
use super::solid::{
    SOLID_KEYS, STRAIN_LIMIT, SolidMaterial, StressStep, increment, viscous, work_and_size,
};
use super::{
    Constructor, Element, ElementEntry, ElementFields, ElementPass, ElementResult, GroupCorners,
    GroupNodes, HourglassForm, PassTotals, SolidGroups, TakenAtStart, Totals, zero_failed,
};
use crate::columns::ElementState;
use crate::materials::{Elastic, PointLanes, PointReal, Solid};
use crate::nodes::NodeView;
use crate::parameter::{DefaultValue, Form, ParameterRow, Range, Values};
use crumple_math::lanes::Real;
use crumple_proto::initial::InitialPoint;
use crumple_proto::job::Part;
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::problem::Problem;

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "hexahedron",
    meaning: "One point, exact mean gradient, three forms of hourglass control.",
    shape: Shape::Hex8,
    parameters: [
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
        ],
        SOLID_KEYS,
    ],
    idle: |values| match HourglassForm::from_word(&values.word("hourglass")) {
        HourglassForm::AssumedStrain => {
            &[("hourglass_coefficient", "hourglass = \"assumed_strain\" has no coefficient")]
        }
        HourglassForm::Stiffness | HourglassForm::Viscous => &[],
    },
    build: Constructor::Solid(build),
};

/// Number of columns between the law's state and hourglass: volume at the start [length^3], bulk
/// viscosity [force/length^2].
const OWN: usize = 2;

/// Parameters of the hexahedron.
pub struct Hexahedron {
    material: SolidMaterial,
    hourglass: Hourglass,
}

fn build(part: &Part, values: &Values<'_>, law: Box<dyn Solid>) -> ElementResult {
    let fluid = law.viscosity().is_some();
    let asked = HourglassForm::from_word(&values.word("hourglass"));
    if fluid && values.is_given("hourglass") && asked != HourglassForm::Viscous {
        let message = format!("part {}: hourglass = \"{}\" of a fluid", part.label(), asked.word());
        let help = "a fluid has no stiffness against a change of shape: use \"viscous\", which is \
                    its default";
        return Err(vec![Problem::error("hourglass", message, help)]);
    }
    let material = SolidMaterial::new(values, law);
    let elastic = material.elastic;
    // Waves of a fluid damp its modes as those of a solid do.
    let modes = match fluid {
        true => Elastic { youngs_modulus: elastic.bulk_modulus(), poisson: 0.0, ..elastic },
        false => elastic,
    };
    Ok(Box::new(Hexahedron {
        material,
        hourglass: Hourglass {
            form: if fluid { HourglassForm::Viscous } else { asked },
            coefficient: values.number("hourglass_coefficient"),
            elastic: modes,
        },
    }))
}

/// Shape of an element at the end of a step.
struct HexahedronEndShape<R> {
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
        let (state, own) = history.split_at_mut(self.material.state);
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
        let (eps, turn) = increment(&k);

        // 2. Shape at the end of the step, before stress, so that the root and the quotient of the
        //    rotation are ready when they are used.
        let HexahedronEndShape { gradient, inverse64, density, gram, slowness, length } =
            self.end(x, first_volume);

        // 3. Stress.
        let StressStep { before, after, stress, left } =
            self.material.update(state, &eps, &turn, dt);
        let slowness = self.material.stiffened(state, slowness);

        // 4. Bulk viscosity, in compression only.
        let trace = eps[0] + eps[1] + eps[2];
        let (q, stable_dt) =
            self.material.viscosity(R::splat(-per_time) * trace, length, density, slowness);

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
        let (resistance, resisted) = self.hourglass.update(&step, hourglass);

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
        let mean_q = half * (*viscosity + q);
        let (work, largest, mut total) = work_and_size(&before, &after, &eps, mean_q);
        let volume = mid_gradient.volume();
        self.material.heat(state, mean_q, trace, volume / *first_volume);
        *viscosity = q;
        for mode in &force {
            total += mode[0] + mode[1] + mode[2];
        }
        let whole = gradient.whole();
        let calm =
            R::both(largest.le(R::splat(STRAIN_LIMIT)), total.abs().le(R::splat(R::LARGEST)));
        let sound = R::both(whole, calm);
        let internal = work * volume;
        let mut response = HexahedronResponse {
            force,
            totals: Totals { stable_dt, internal, hourglass: resisted, sound },
        };
        if let Some(column) = self.material.failed {
            let failed = state[column].gt(half);
            response.zero_failed(failed);
            zero_failed(failed, hourglass);
        }
        response
    }

    /// Computes the shape at these coordinates. Sets the volume at the start if there is none yet.
    #[inline(always)]
    fn end<R: Real>(&self, x: &HexahedronModes<R>, first_volume: &mut R) -> HexahedronEndShape<R> {
        let gradient = Gradient::new(x);
        let inverse64 = R::splat(1.0) / gradient.volume64;
        let volume = gradient.volume();
        *first_volume = R::select(first_volume.gt(R::zero()), *first_volume, volume);
        let density = R::splat(64.0 * self.material.elastic.density) * *first_volume * inverse64;
        let gram = gradient.gram(inverse64);
        let slowness = (density * R::splat(1.0 / self.material.modulus())).sqrt();
        let length = self.material.length::<8, R>(&gram);
        HexahedronEndShape { gradient, inverse64, density, gram, slowness, length }
    }

    /// Returns the column of the volume at the start.
    fn first_volume(&self) -> usize {
        self.material.state
    }
}

/// Returns the eight slots of a solid.
///
/// # Panics
/// If there are fewer than eight slots. Callers pass all slots of a solid.
fn per_corner(x: &[[f64; 3]]) -> &[[f64; 3]; 8] {
    x.first_chunk().expect("a hexahedron has eight slots")
}

impl SolidGroups<8> for Hexahedron {
    fn material(&self) -> Option<(&SolidMaterial, usize)> {
        Some((&self.material, 1))
    }

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
        let HexahedronEndShape { gradient, slowness, length, .. } =
            self.end(&x, &mut history[self.first_volume()]);
        let [b1, _] = self.material.bulk_viscosity;
        Totals::inactive(viscous(length * slowness, L::splat(b1)), gradient.whole())
    }
}

impl Element for Hexahedron {
    fn columns(&self) -> usize {
        self.material.state + OWN + hourglass::COLUMNS
    }

    fn names(&self) -> Vec<String> {
        let own = ["volume at start", "bulk viscosity"].map(String::from);
        let hourglass = (0..hourglass::COLUMNS).map(|k| format!("hourglass {k}"));
        self.material.names().chain(own).chain(hourglass).collect()
    }

    fn any_precision(&self) -> bool {
        self.material.any_precision()
    }

    fn measure(&self, history: &mut [f64], x: &[[f64; 3]], _: OwnSection) {
        let volume = Gradient::new(&modes_of_corners(per_corner(x))).volume();
        self.material.measure(history, x, 1, volume);
    }

    fn taken_at_start(&self) -> TakenAtStart {
        self.material.taken_at_start()
    }

    fn set_initial(&self, history: &mut [f64], _: &[[f64; 3]], points: &[InitialPoint]) {
        self.material.set_initial(history, 1, points);
    }

    fn corner_mass(&self, x: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        (
            0.125
                * self.material.elastic.density
                * Gradient::new(&modes_of_corners(per_corner(x))).volume(),
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
        let [b1, _] = self.material.bulk_viscosity;
        let speed = self.material.elastic.dilatational_wave_speed();
        self.material.length::<8, f64>(&gradient.gram(1.0 / gradient.volume64)) / speed
            * ((1.0 + b1 * b1).sqrt() - b1)
    }

    fn stable_dt_now(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        let (first, volume) = (
            history.at(self.first_volume()),
            Gradient::new(&modes_of_corners(per_corner(x))).volume(),
        );
        self.stable_dt(x, OwnSection::default())
            * if first > 0.0 { (first / volume).sqrt() } else { 1.0 }
            * self.material.step_factor(history, 0)
    }

    fn is_unstrained(&self, history: ElementState<'_>) -> bool {
        self.material.is_unstrained(history, 1)
    }

    fn failed(&self, history: ElementState<'_>) -> bool {
        self.material.has_failed(history, 0)
    }

    fn is_deleted(&self, history: ElementState<'_>) -> bool {
        self.material.is_deleted(history)
    }

    fn can_fail(&self) -> bool {
        self.material.failed.is_some()
    }

    fn failure_column(&self) -> Option<usize> {
        self.material.failed
    }

    fn fields(&self, history: ElementState<'_>, _x: &[[f64; 3]]) -> ElementFields {
        self.material.fields(history, 0)
    }
}

#[cfg(test)]
#[path = "hexahedron_scenes.rs"]
mod scenes;
#[cfg(test)]
#[path = "hexahedron_tests.rs"]
mod tests;
