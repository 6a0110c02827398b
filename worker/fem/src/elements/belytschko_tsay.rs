//! Four-node shell of Belytschko, Lin & Tsay 1984 with one point in its plane, stabilised.
//!
//! Frame, strains and corner forces are those of `quad.rs`. Options and additions:
//! - Hourglass control after Flanagan & Belytschko 1981, with stiffness `r E t^3 A BB/192` of tx
//!   and ty, `r 5/6 G t^3 BB/12` of vz, `r E t A BB/8` of vx and vy (BB = B1 B1 + B2 B2), which for
//!   r = 1 is about that of full integration. In the viscous form the coefficient is
//!   `(r/2) sqrt(K m)`, with K the stiffness at r = 1 and m the mass (or inertia): r is the
//!   fraction of critical damping of the mode. In plastic parts these forces are bounded by
//!   [`BOUNDS`] times the capacity of the section in their modes (`bounds.rs`): elastic ones
//!   would grow without bound in folds.
//! - Warping of Belytschko, Wong & Chiang 1992: `Bc1 vx, Bc2 vy, Bc2 vx + Bc1 vy` is added to the
//!   curvature, with `Bc1 = (2 z0/A^2) [x13, x42, x31, x24]`, Bc2 likewise with y, z0 = h z/4; here
//!   the contribution of in-plane spin is subtracted.
//!
//! A membrane has one point, no transverse shear, no drilling and no hourglass stiffness of tx and
//! ty, so that it has no moments. The stiffness of vz stays: the twist of a quad out of its plane
//! would have none.
//!
//! Not included: a shear projection, so bending patches of distorted quads fail;
//! `stabilised_quad.rs` has one. Thin twisted strips do not lock, as the hourglass rates exclude
//! rigid rotation; coarse ones are stiff (`shell_benchmarks.rs`).

use super::bounds::{self, Bounds, Mode};
use super::quad::{
    DRILLING, Generalised, HOURGLASS, Kernel, Quad, QuadGeometry, QuadModes, QuadMotion,
    QuadResponse,
};
use super::section::{Resultants, SHEAR_CORRECTION, Section};
use super::shell::Shell;
use super::{Constructor, ElementEntry, ElementResult, HourglassForm, parameters, zero_failed};
use crate::materials::{PlaneStress, PointReal};
use crate::parameter::{DefaultValue, Form, ParameterRow, Values};
use crumple_math::lanes::{Each, Real};
use crumple_proto::job::Part;
use crumple_proto::mesh::Shape;
use crumple_proto::problem::Problem;

/// The keys of this element in `[[part]]`.
pub const PARAMETERS: [&[ParameterRow]; 2] = [
    parameters::OF_SHELLS,
    &[
        ParameterRow {
            key: "hourglass",
            form: Form::Word(HourglassForm::OF_SHELLS),
            otherwise: DefaultValue::Word(HourglassForm::Stiffness.word()),
            range: None,
            meaning: "Hourglass control (`cases/studies/README.md`, hourglass).",
        },
        parameters::coefficient_of_shell(
            0.03,
            "Hourglass coefficient: fraction of the stiffness of the element, or of critical \
             damping. Hourglass forces of shells with a plastic law are bounded with every \
             form of control. See `cases/studies/README.md`, hourglass.",
        ),
        parameters::MEMBRANE,
        ParameterRow {
            key: "warping",
            form: Form::Flag,
            otherwise: DefaultValue::Flag(false),
            range: None,
            meaning: "Add the Belytschko-Wong-Chiang coupling terms for warped quads. Their \
                      effect is small (`cases/studies/README.md`, twist, twist-thin and \
                      panel).",
        },
    ],
];

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "belytschko_tsay",
    meaning: "Belytschko-Lin-Tsay: one in-plane point, hourglass control with a coefficient.",
    shape: Shape::Quad4,
    parameters: PARAMETERS,
    idle: parameters::idle_in_membranes,
    build: Constructor::Shell(build),
};

/// Largest hourglass forces of a plastic part, as a fraction of the capacity under full
/// integration. With it crushed tubes (B11, B12) have 3 to 4 % of hourglass energy, 6 % with 0.1,
/// and none of their shells collapses.
pub(super) const BOUNDS: Bounds<HOURGLASS> = Bounds {
    modes: [Mode::Bending, Mode::Bending, Mode::Twist, Mode::Membrane, Mode::Membrane],
    strength: 0.03,
};

/// Parameters of the four-node shell. Its own columns, after those of the section, are the
/// hourglass resultants of tx, ty [force length], vz, vx, vy [force], then the drilling moments.
pub struct BelytschkoTsay {
    section: Section,
    hourglass: HourglassForm,
    /// r.
    hourglass_coefficient: f64,
    warping: bool,
    membrane: bool,
    /// alpha.
    drilling: f64,
}

fn build(part: &Part, values: &Values<'_>, law: Box<dyn PlaneStress>) -> ElementResult {
    Ok(Box::new(Shell(Quad(kernel(part, values, law)?))))
}

/// Returns the kernel of the shells of a part.
///
/// # Errors
/// All problems of the part.
pub fn kernel(
    part: &Part,
    values: &Values<'_>,
    law: Box<dyn PlaneStress>,
) -> Result<BelytschkoTsay, Vec<Problem>> {
    let section = Section::new(part, values, law)?;
    let membrane = parameters::is_membrane(part, values)?;
    Ok(BelytschkoTsay {
        section: if membrane { section.of_membrane() } else { section },
        membrane,
        hourglass: HourglassForm::from_word(&values.word("hourglass")),
        hourglass_coefficient: values.number("hourglass_coefficient"),
        warping: values.flag("warping"),
        drilling: if membrane { 0.0 } else { values.number("drilling") },
    })
}

/// Coupling of in-plane velocity to curvature in a warped element: corner values 1 and 2 of Bc1 and
/// Bc2 [1/length^2], and their products with the coordinates.
struct Warping<R> {
    bc1: [R; 2],
    bc2: [R; 2],
    /// Bc1 x, Bc1 y (which is Bc2 x), Bc2 y.
    on_x: [R; 3],
}

impl<R: Real> Warping<R> {
    #[inline(always)]
    fn new(g: &QuadGeometry<R>) -> Self {
        // 2 z0/A^2 with z0 = hz/4.
        let c = R::splat(2.0) * g.hz * g.inv_2a * g.inv_2a;
        let (bc1, bc2) = ([c * g.x[0], -(c * g.x[1])], [c * g.y[0], -(c * g.y[1])]);
        let on = |bc: [R; 2], u: [R; 3]| bc[0].mul_add(u[0], bc[1] * u[1]);
        Self { bc1, bc2, on_x: [on(bc1, g.x), on(bc1, g.y), on(bc2, g.y)] }
    }

    /// Returns curvature increments from displacement increments in the plane, minus those of the
    /// rigid part of K, which is K without the strain.
    #[inline(always)]
    fn curvature(&self, motion: &QuadMotion<R>) -> [R; 3] {
        let QuadMotion { u, k, almansi: e, .. } = motion;
        let u = [[u[0][0], u[1][0]], [u[0][1], u[1][1]]];
        let on = |bc: [R; 2], u: [R; 2]| bc[0].mul_add(u[0], bc[1] * u[1]);
        let [xx, xy, yy] = self.on_x;
        let rigid = [[k[0][0] - e[0], k[0][1] - e[2]], [k[1][0] - e[2], k[1][1] - e[1]]];
        [
            on(self.bc1, u[0]) - on([xx, xy], rigid[0]),
            on(self.bc2, u[1]) - on([xy, yy], rigid[1]),
            on(self.bc2, u[0]) + on(self.bc1, u[1])
                - on([xy, yy], rigid[0])
                - on([xx, xy], rigid[1]),
        ]
    }

    /// Returns the couple of the moments `m` on the spin.
    #[inline(always)]
    fn couple(&self, [mx, my, mxy]: [R; 3]) -> R {
        let [xx, xy, yy] = self.on_x;
        xy.mul_add(mx, (yy - xx).mul_add(mxy, -(xy * my)))
    }
}

impl Kernel for BelytschkoTsay {
    const OWN: &'static [&'static str] = &[
        "hourglass tx",
        "hourglass ty",
        "hourglass vz",
        "hourglass vx",
        "hourglass vy",
        "drilling 1 - 3",
        "drilling 2 - 4",
        "drilling h",
        "drilling sum",
    ];
    const TAPER: f64 = 0.0;

    fn section(&self) -> &Section {
        &self.section
    }

    fn section_mut(&mut self) -> &mut Section {
        &mut self.section
    }

    #[inline(always)]
    fn respond<R: PointReal, const N: usize>(
        &self,
        g: &QuadGeometry<R>,
        modes: &QuadModes<R>,
        history: &mut [R],
        dt: f64,
    ) -> QuadResponse<R> {
        let (section, own) = history.split_at_mut(self.section.columns());
        let (hourglass, drill) = own[..HOURGLASS + DRILLING].split_at_mut(HOURGLASS);
        // Before the first step nothing has moved, so all rates are zero.
        let per_time = if dt > 0.0 { 1.0 / dt } else { 0.0 };

        // 1. Frame, and all motions in its axes.
        let (motion, mut strains) = QuadMotion::new(g, modes, dt);
        let warping = if self.warping { Some(Warping::new(g)) } else { None };
        if let Some(warping) = &warping {
            let more = warping.curvature(&motion);
            strains.kappa = std::array::from_fn(|c| strains.kappa[c] + more[c]);
        }

        // 2. Stress.
        let sound = self.section.sound_points(&strains, self.section.current_thickness(section));
        let Resultants { n, m, q, work, thickness } =
            self.section.update::<R, N>(section, &strains, dt);
        let stable_dt = g.stable_dt_now::<Self>(&self.section, section);
        let (n, m, q) = (n.each(|n| n * g.area), m.each(|m| m * g.area), q.each(|q| q * g.area));

        // 3. Hourglass and drilling. Twice the energy is the work of old and new forces.
        let rates = motion.hourglass(g);
        let stiffness = self.hourglass_stiffness(g, thickness);
        let ahead = motion.extrapolated();
        let mut energy = R::zero();
        for c in 0..HOURGLASS {
            let old = hourglass[c];
            let new = match self.hourglass {
                HourglassForm::Viscous => stiffness[c] * rates[c] * R::splat(per_time),
                _ => stiffness[c].mul_add(rates[c], old),
            };
            hourglass[c] = new;
            energy = (old + new).mul_add(rates[c], energy);
        }
        let stiff = bounds::drilling_stiffness(&self.section, self.drilling, thickness, g.area);
        let energy = bounds::drill(drill, stiff, &ahead, energy);
        let lost = BOUNDS.apply::<R, N>(
            (&self.section, section),
            (hourglass, drill),
            (&rates, &ahead),
            thickness,
            ([g.area; HOURGLASS], g.area),
        );
        let energy = energy + lost;

        // 4. Corner forces, mode by mode.
        let couple = warping.as_ref().map_or(R::zero(), |warping| warping.couple(m));
        let resisting = std::array::from_fn(|c| hourglass[c]);
        let (mut force, moment) =
            Generalised { n, m, q, hourglass: resisting, drilling: drill, couple }.corners(g);
        if let Some(Warping { bc1, bc2, .. }) = &warping {
            let [mx, my, mxy] = m;
            for c in 0..2 {
                force[c][0] += bc1[c].mul_add(mx, bc2[c] * mxy);
                force[c][1] += bc2[c].mul_add(my, bc1[c] * mxy);
            }
        }
        let energies = [work * g.area, R::splat(0.5) * energy];
        let mut response = QuadResponse::new(g, (force, moment), energies, stable_dt, sound);
        if let Some(failed) = self.section.failed_lanes(section) {
            response.zero_failed(failed);
            zero_failed(failed, hourglass);
            zero_failed(failed, drill);
        }
        response
    }
}

impl BelytschkoTsay {
    /// Returns the coefficients of tx, ty, vz, vx, vy.
    #[inline(always)]
    fn hourglass_stiffness<R: Real>(&self, g: &QuadGeometry<R>, t: R) -> [R; HOURGLASS] {
        let e = self.section.stabilising.youngs_modulus;
        let sq = |v: R| v * v;
        let bb = R::splat(2.0) * (sq(g.b1[0]) + sq(g.b1[1]) + sq(g.b2[0]) + sq(g.b2[1]));
        let (t2, tbb) = (t * t, t * bb);
        let bends = if self.membrane { 0.0 } else { e / 192.0 };
        let theta = R::splat(bends) * t2 * tbb * g.area;
        let w = R::splat(SHEAR_CORRECTION * self.section.transverse_modulus / 12.0) * t2 * tbb;
        let membrane = R::splat(e / 8.0) * tbb * g.area;
        let r = self.hourglass_coefficient;
        let [theta, w, membrane] = if self.hourglass == HourglassForm::Viscous {
            self.viscosities([theta, w, membrane], g.area, t)
        } else {
            [R::splat(r) * theta, R::splat(r) * w, R::splat(r) * membrane]
        };
        [theta, theta, w, membrane, membrane]
    }

    /// Returns the damping coefficients that belong to these stiffnesses of tx, vz and vx.
    #[cold]
    #[inline(never)]
    fn viscosities<R: Real>(&self, [theta, w, membrane]: [R; 3], area: R, t: R) -> [R; 3] {
        let mass = R::splat(self.section.elastic.density) * t * area;
        let floor = R::splat(self.section.inertia_floor()) * area;
        let radius2 = Real::max(t * t * R::splat(1.0 / 12.0), floor);
        let half = R::splat(0.5 * self.hourglass_coefficient);
        let damping = |k: R, m: R| half * (k * m).sqrt();
        [damping(theta, mass * radius2), damping(w, mass), damping(membrane, mass)]
    }
}

#[cfg(test)]
#[path = "belytschko_tsay_tests.rs"]
mod tests;
