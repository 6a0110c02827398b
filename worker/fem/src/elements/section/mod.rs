//! Through-thickness integration, common to all shells: Gauss points, resultants, transverse shear,
//! thinning, stable step.
//!
//! Over the thickness t, with 1 to 10 Gauss-Legendre points `zeta_k` of weights `W_k`,
//! ```text
//! eps(z) = eps_m + z kappa,   z = zeta t/2
//! N = sum sig w,   M = sum sig z w,   w = W t/2,   Q = t tau
//! tau <- tau + 5/6 G gamma
//! ```
//! The shear stress tau is elastic, constant over the thickness, and not part of the yield
//! condition. If the middle surface is not in the nodal plane (`offset` of a part), all of this
//! refers to the middle surface. An element transforms the velocities of its nodes to the middle
//! surface and its forces back to the nodes, so that hourglass and drilling forces also act at the
//! middle surface.
//!
//! Few Gauss points reach the accuracy that is needed: 5 give linear bending exactly and the
//! plastic hinge within 2 %. There is no point at the outer fibres themselves.

mod flow;
mod initial;
mod rule;
mod step;
#[cfg(test)]
mod tests;
mod transverse;

pub use flow::{Flow, SAVED};
pub use rule::{fault_of_angles, gauss_legendre};
pub use step::StepQuantities;

use crate::columns::ElementState;
use crate::materials::{
    DIRECTION_COLUMNS, Elastic, MAX_LAYER_POINTS, MAX_POINTS, PlaneStress, PointReal, Points,
    SIZE_COLUMN,
};
use crate::parameter::Values;
use crumple_math::lanes::{Each, Real};
use crumple_proto::job::Part;
use crumple_proto::mesh::OwnSection;
use crumple_proto::problem::Problem;

use rule::IntegrationRule;

use super::{ElementFields, PointFields, damage_column, law_column, parameters, zero_failed};

/// Shear correction of a homogeneous section.
pub const SHEAR_CORRECTION: f64 = 5.0 / 6.0;
/// Limit on the squared frequency of shear of square elements, over that of the membrane,
/// `(2 c/L)^2`. Such elements are then stable for 0.934 L/c, more than the usual safety factor of
/// 0.9.
const SHEAR_OVER_MEMBRANE: f64 = 2.75 * 0.5 * SHEAR_CORRECTION;
/// Largest offset of the middle surface from the nodal plane, over half the thickness.
pub const LARGEST_OFFSET: f64 = 10.0;
/// Largest strain increment of a valid step.
const STRAIN_LIMIT: f64 = 0.5;

/// First columns of every shell: thickness [length], volume at the start [length^3], rotational
/// inertia of its corners per mass [length^2], transverse shear stress xz and yz [force/length^2].
const THICKNESS: usize = 0;
const VOLUME: usize = 1;
const INERTIA: usize = 2;
const SHEAR: usize = 3;
const POINTS: usize = 5;
/// The number of the point next to each corner, of four points in the plane in the order of
/// `fully_integrated_quad.rs`.
const POINT_AT_CORNER: [usize; 4] = [1, 3, 0, 2];
/// Section of a part: material and points through the thickness.
pub struct Section {
    law: Box<dyn PlaneStress>,
    /// Elastic constants of the law, which bound its stiffness.
    pub elastic: Elastic,
    /// Constants for forces that only stabilise an element.
    pub stabilising: Elastic,
    /// Initial thickness of elements that do not have their own [length].
    pub thickness: f64,
    /// Distance from the nodal plane to the middle surface along the normal, over half the
    /// thickness, of elements that do not have their own.
    offset: f64,
    /// True if each element stores its offset, in the last column of the section.
    stores_offsets: bool,
    /// Number of points through the thickness.
    pub points: usize,
    /// Number of points in the plane of an element; each has its own columns.
    planar: usize,
    zeta: [f64; MAX_LAYER_POINTS],
    weight: [f64; MAX_LAYER_POINTS],
    /// Transverse shear moduli of the points along and across their direction [force/length^2], if
    /// they are not that of the constants.
    transverse: Option<Box<[[f64; 2]]>>,
    /// Transverse shear modulus, a mean over thickness and directions [force/length^2].
    pub transverse_modulus: f64,
    /// `2 G (1 - nu^2)/E` of transverse shear and bending: `1 - nu` in isotropic shells.
    pub shear_ratio: f64,
    /// Columns of a point: stress xx, yy, xy and those of the law.
    stride: usize,
    thinning: bool,
    /// Column of a point with the size of the element, if the law has one.
    size: Option<usize>,
    /// Number of failed points through the thickness from which on an element has failed.
    failed_points: usize,
    /// Columns of a point with the direction of the law: cosine less 1, sine.
    direction: Option<[usize; 2]>,
    /// Factor on the transverse shear: 0 in membranes, which have none.
    shear: f64,
    /// True if inverted elements are deleted instead of ending the run. Such a part has one more
    /// column, the last one: 1 if the element was deleted.
    pub deletes: bool,
    /// Stable step below which elements are deleted, 0 for none [time].
    pub deletion_step: f64,
    /// Column of a point with its effective plastic strain, if the law has any.
    plastic_strain: Option<usize>,
    /// Column of a point with its damage, if the law has any.
    damage: Option<usize>,
    /// Yield stress at zero plastic strain [force/length^2]; infinite without plastic flow.
    initial_yield_stress: f64,
    /// Column of a point that marks its failure, if the law can fail.
    failed: Option<usize>,
}

/// Strain increments of a step, in the element's axes.
#[derive(Clone, Copy)]
pub struct Strains<R> {
    /// Membrane xx, yy, and twice xy.
    pub eps: [R; 3],
    /// Curvature xx, yy, and twice xy [1/length].
    pub kappa: [R; 3],
    /// Twice the transverse shear xz and yz.
    pub gamma: [R; 2],
}

/// Stress resultants, in the element's axes.
#[derive(Clone, Copy)]
pub struct Resultants<R> {
    /// Membrane forces xx, yy, xy [force/length].
    pub n: [R; 3],
    /// Moments xx, yy, xy [force].
    pub m: [R; 3],
    /// Shear forces xz and yz [force/length].
    pub q: [R; 2],
    /// Increase of internal energy per area [force/length].
    pub work: R,
    /// Thickness for which the resultants were computed [length].
    pub thickness: R,
}

impl Section {
    /// Builds the section of a part.
    ///
    /// # Errors
    /// All problems of the part, with paths relative to it.
    pub fn new(
        part: &Part,
        values: &Values<'_>,
        law: Box<dyn PlaneStress>,
    ) -> Result<Self, Vec<Problem>> {
        let mut problems = Vec::new();
        if part.thickness == 0.0 {
            let message = format!("part {}: its shells have no `thickness`", part.label());
            problems.push(Problem::error("thickness", message, "add it: a length above 0"));
        }
        let mut check = |right: bool, key: &str, value: &dyn std::fmt::Display, wanted: &str| {
            if !right {
                let message = format!("part {}: {key} is {value}", part.label());
                problems.push(Problem::error(key, message, format!("it has to be {wanted}")));
            }
        };
        check(
            part.thickness.is_finite() && part.thickness >= 0.0,
            "thickness",
            &part.thickness,
            "above 0",
        );
        check(
            part.offset.abs() <= LARGEST_OFFSET,
            "offset",
            &part.offset,
            "from -10 to 10 (-1 to 1 is usual)",
        );
        let given = part.contact_thickness.unwrap_or(1.0);
        check(given > 0.0 && given.is_finite(), "contact_thickness", &given, "above 0");
        let scale = part.contact_thickness_scale;
        check(
            scale > 0.0 && scale.is_finite(),
            "contact_thickness_scale",
            &scale,
            "above 0; 1 is usual",
        );
        if !problems.is_empty() {
            return Err(problems);
        }
        let rule = if part.layer.is_empty() {
            let points = values.whole("points");
            let (zeta, weight) = gauss_legendre(points);
            IntegrationRule { points, zeta, weight }
        } else {
            IntegrationRule::of_layers(&part.layer)
        };
        let IntegrationRule { points, zeta, weight } = rule;
        let history = law.history();
        let (elastic, stabilising) = (law.elastic(), law.stabilising());
        let transverse: Option<Box<[[f64; 2]]>> =
            (0..points).map(|point| law.transverse_shear(point)).collect();
        let mean = |moduli: &[[f64; 2]]| {
            moduli.iter().zip(weight).map(|([ca, bc], w)| 0.25 * w * (ca + bc)).sum()
        };
        let transverse_modulus = transverse.as_deref().map_or(elastic.shear_modulus(), mean);
        let nu = stabilising.poisson;
        let shear_ratio = match transverse {
            None => 1.0 - nu,
            Some(_) => 2.0 * transverse_modulus * (1.0 - nu * nu) / stabilising.youngs_modulus,
        };
        Ok(Self {
            elastic,
            stabilising,
            thickness: part.thickness,
            offset: part.offset,
            stores_offsets: false,
            points,
            planar: 1,
            zeta,
            weight,
            stride: 3 + history.len(),
            thinning: values.flag("thinning"),
            size: law_column(history, SIZE_COLUMN, 3),
            failed_points: law.failed_points(points),
            direction: law_column(history, DIRECTION_COLUMNS[0], 3)
                .zip(law_column(history, DIRECTION_COLUMNS[1], 3))
                .map(|(cosine, sine)| [cosine, sine]),
            transverse,
            transverse_modulus,
            shear_ratio,
            shear: 1.0,
            deletes: parameters::deletes_inverted(values),
            deletion_step: values.number(parameters::DELETION_STEP.key),
            plastic_strain: law_column(history, "plastic_strain", 3),
            damage: damage_column(history, 3),
            initial_yield_stress: law.initial_yield_stress(),
            failed: law_column(history, "failed", 3),
            law,
        })
    }

    /// Returns true if the law has no direction.
    pub fn is_isotropic(&self) -> bool {
        self.transverse.is_none() && self.direction.is_none()
    }

    /// Returns true if the thickness follows the strain.
    pub fn is_thinning(&self) -> bool {
        self.thinning
    }

    /// Returns the same section with a constant thickness.
    pub fn without_thinning(self) -> Self {
        Self { thinning: false, ..self }
    }

    /// Returns the same section with `planar` points in the plane of an element.
    pub fn at_points(self, planar: usize) -> Self {
        Self { planar, ..self }
    }

    /// Returns the section of a membrane, which has one point, and neither moments nor transverse
    /// shear.
    pub fn of_membrane(self) -> Self {
        let (zeta, weight) = gauss_legendre(1);
        Self { points: 1, failed_points: 1, zeta, weight, shear: 0.0, ..self }
    }

    /// Returns true if an element has N points, all through the thickness at one place in the
    /// plane, with COLUMNS columns each, and no column of an option.
    #[inline(always)]
    pub fn is_plain<const N: usize, const COLUMNS: usize>(&self) -> bool {
        self.points == N
            && self.stride == COLUMNS
            && self.planar == 1
            && !self.has_offset()
            && !self.deletes
            && self.failed.is_none()
            && self.transverse.is_none()
    }

    /// Makes each element store its offset in a column of the section.
    pub fn store_offsets(&mut self) {
        self.stores_offsets = true;
    }

    /// Returns the number of history columns of the section; those of the element follow them.
    pub fn columns(&self) -> usize {
        self.point_columns() + usize::from(self.stores_offsets)
    }

    /// Returns the names of the columns: for each point in the plane its own, then those of its
    /// points through the thickness.
    pub fn names(&self) -> Vec<String> {
        let own = ["thickness", "volume at start", "inertia", "shear xz", "shear yz"];
        let mut names = Vec::new();
        for p in 0..self.planar {
            names.extend(own.map(|name| format!("point {p} {name}")));
            for k in 0..self.points {
                let of_law = self.law.history().iter().copied();
                let all = ["stress xx", "stress yy", "stress xy"].into_iter().chain(of_law);
                names.extend(all.map(|name| format!("point {p}.{k} {name}")));
            }
        }
        names.extend(self.stores_offsets.then(|| "offset".to_string()));
        names
    }

    /// Returns the number of columns of the points in the plane; the offset follows them.
    fn point_columns(&self) -> usize {
        self.planar * self.each()
    }

    /// Returns the number of columns of one point in the plane.
    pub fn each(&self) -> usize {
        POINTS + self.points * self.stride
    }

    /// Returns the initial thickness of an element: its own, or that of the part [length].
    pub fn thickness_at_start(&self, own: OwnSection) -> f64 {
        if own.thickness > 0.0 { own.thickness } else { self.thickness }
    }

    /// Returns the distance from the nodal plane to the middle surface of an element at the start
    /// [length].
    fn arm_at_start(&self, own: OwnSection) -> f64 {
        0.5 * own.offset.unwrap_or(self.offset) * self.thickness_at_start(own)
    }

    /// Sets the thickness and the stored offset. All other columns are zero at the start, until
    /// [`Self::measure`].
    pub fn start(&self, history: &mut [f64], own: OwnSection) {
        let thickness = self.thickness_at_start(own);
        (0..self.planar).for_each(|p| history[p * self.each() + THICKNESS] = thickness);
        if self.stores_offsets {
            history[self.point_columns()] = own.offset.unwrap_or(self.offset);
        }
    }

    /// Stores what determines the mass of an element: its volume at the start, from `area`
    /// [length^2], and its [`Self::inertia_per_mass`]; and its size, if the law needs it.
    pub fn measure(&self, history: &mut [f64], own: OwnSection, area: f64, floor: f64) {
        (history[VOLUME], history[INERTIA]) =
            (area * self.thickness_at_start(own), self.inertia_per_mass(own, floor));
        let Some(size) = self.size else { return };
        for k in 0..self.planar * self.points {
            let (plane, layer) = (k / self.points, k % self.points);
            history[plane * self.each() + POINTS + layer * self.stride + size] = area.sqrt();
        }
    }

    /// Returns the effective plastic strain of bending at the outer fibres, the largest of the
    /// points in the plane: the difference over the thickness, extrapolated from the points. With
    /// two points, which have the same distance from the middle, all plastic strain counts.
    pub fn plastic_bending_strain(&self, history: ElementState<'_>) -> f64 {
        let Some(strain) = self.plastic_strain else { return 0.0 };
        let of_plane = |plane: usize| {
            let base = plane * self.each() + POINTS + strain;
            let points =
                (0..self.points).map(|k| (self.zeta[k].abs(), history.at(base + k * self.stride)));
            let all = [f64::INFINITY, 0.0_f64];
            let widen = |[low, high]: [f64; 2], v: f64| [low.min(v), high.max(v)];
            let [inner, outer] = points.clone().fold(all, |range, (z, _)| widen(range, z));
            let [least, most] = points.fold(all, |range, (_, eps)| widen(range, eps));
            match outer - inner > 0.1 {
                true => (most - least) / (outer - inner),
                false if outer > 0.0 => most / outer,
                false => 0.0,
            }
        };
        (0..self.planar).map(of_plane).fold(0.0, f64::max)
    }

    /// Copies to the new history of a quarter of an element, at one of its corners, what its points
    /// have in the history of the element: thickness, stress and the columns of the law. What
    /// [`Self::measure`] stores is kept: volume, inertia and size.
    pub fn inherit(&self, whole: &[f64], corner: usize, quarter: &mut [f64]) {
        let each = self.each();
        // With several points in the plane it is the one next to the corner.
        let point = if self.planar == 1 { 0 } else { POINT_AT_CORNER[corner] };
        let from = &whole[point * each..(point + 1) * each];
        for plane in 0..self.planar {
            let to = &mut quarter[plane * each..(plane + 1) * each];
            to[THICKNESS] = from[THICKNESS];
            to[SHEAR..POINTS].copy_from_slice(&from[SHEAR..POINTS]);
            let layers = to[POINTS..].chunks_exact_mut(self.stride);
            for (to, from) in layers.zip(from[POINTS..].chunks_exact(self.stride)) {
                let size = self.size.map(|size| to[size]);
                to.copy_from_slice(from);
                if let (Some(column), Some(size)) = (self.size, size) {
                    to[column] = size;
                }
            }
        }
    }

    /// Stores the direction of the law at each point in the axes e1, e2 and normal of an element
    /// with the first side `side`.
    pub fn orient(
        &self,
        history: &mut [f64],
        own: OwnSection,
        axes: &[[f64; 3]; 3],
        side: [f64; 3],
    ) {
        let Some([cosine, sine]) = self.direction else { return };
        for k in 0..self.planar * self.points {
            let (plane, layer) = (k / self.points, k % self.points);
            let Some(of) = self.law.orientation(layer) else { continue };
            let along = of.direction.unwrap_or(side);
            let on = |axis: &[f64; 3], v: [f64; 3]| (0..3).map(|c| axis[c] * v[c]).sum::<f64>();
            let projection = |v: [f64; 3]| (on(&axes[0], v), on(&axes[1], v));
            let (x, y) = projection(along);
            // A direction along the normal has no projection: then that of the first side.
            let seen = x.hypot(y) > 1e-6 * along.iter().fold(0.0, |m: f64, c| m.max(c.abs()));
            let (x, y) = if seen { (x, y) } else { projection(side) };
            let angle = of.angle + own.angle.to_radians();
            let (size, (s, c)) = (x.hypot(y), angle.sin_cos());
            let (x, y) = ((c * x - s * y) / size, (s * x + c * y) / size);
            let point = &mut history[plane * self.each() + POINTS + layer * self.stride..];
            (point[cosine], point[sine]) = (x - 1.0, y);
        }
    }

    /// Returns true if the middle surface of some elements is not in the nodal plane.
    #[inline(always)]
    pub fn has_offset(&self) -> bool {
        self.offset != 0.0 || self.stores_offsets
    }

    /// Returns the distance `e` from the nodal plane to the middle surface along the normal
    /// [length]. The points keep their places about the middle surface: an element transforms its
    /// velocities to the middle surface and its forces back.
    #[inline(always)]
    pub fn arm<R: Real>(&self, history: &[R]) -> R {
        let half = 0.5 / self.planar as f64;
        if self.stores_offsets {
            return history[self.point_columns()] * R::splat(half) * self.thicknesses(history);
        }
        R::splat(0.5 * self.offset / self.planar as f64) * self.thicknesses(history)
    }

    /// Returns the sum of the thicknesses of the points in the plane [length].
    #[inline(always)]
    fn thicknesses<R: Real>(&self, history: &[R]) -> R {
        (1..self.planar)
            .fold(history[THICKNESS], |sum, p| sum + history[p * self.each() + THICKNESS])
    }

    /// Returns the columns of a history that [`Self::stable_dt`] reads, if these are the first
    /// ones: the thicknesses at several points in the plane and stored offsets are not.
    pub fn shape_columns(&self, history: ElementState<'_>) -> Option<[f64; POINTS]> {
        (self.planar == 1 && !self.stores_offsets)
            .then(|| std::array::from_fn(|column| history.at(column)))
    }

    /// Returns the current thickness [length].
    #[inline(always)]
    pub fn current_thickness<R: Real>(&self, history: &[R]) -> R {
        history[THICKNESS]
    }

    /// Returns the volume of the element at the start, which [`Self::measure`] stores [length^3].
    #[inline(always)]
    pub fn volume_at_start<R: Real>(&self, history: &[R]) -> R {
        history[VOLUME]
    }

    /// Returns a bound of the transverse shear modulus in any direction, as a mean over the
    /// thickness [force/length^2].
    pub fn largest_shear_modulus(&self) -> f64 {
        match self.transverse {
            None => self.elastic.shear_modulus(),
            // Half the sum of the moduli in two directions, neither of which is negative.
            Some(_) => 2.0 * self.transverse_modulus,
        }
    }

    /// Returns true if all columns are zero except those that are set at the start.
    pub fn is_unstrained(&self, history: ElementState<'_>) -> bool {
        let (each, all, own) = (self.each(), self.point_columns(), self.columns());
        // Directions of the law and the size are set at the start and say nothing of strain.
        let of_start = || self.direction.iter().flatten().chain(&self.size);
        let is_of_start = |column: usize| {
            let within = column % each;
            within >= POINTS && of_start().any(|&set| set == (within - POINTS) % self.stride)
        };
        history.is_zero_where(|column| {
            column >= own || column < all && column % each >= SHEAR && !is_of_start(column)
        })
    }

    /// Returns the smallest rotational inertia of a corner of a quad per mass and area for which
    /// membrane waves, and not rotations, determine the stable step (Hughes, Cohen & Haroun 1978).
    /// Shear of squares of side L has the squared frequency `4 (5/6 G/rho) (1/L^2 + 1/(4 I))`, and
    /// `5/6 G/rho = c^2 5/12 (1 - nu)`. With I = f L^2 it stays below [`SHEAR_OVER_MEMBRANE`] times
    /// `(2 c/L)^2` if `5/12 (1 - nu) (1 + 1/(4 f))` does: f = 1/7 for nu = 0, 1/11.7 for nu = 0.3.
    pub fn inertia_floor(&self) -> f64 {
        let softer = 0.5 * SHEAR_CORRECTION * (1.0 - self.elastic.poisson);
        0.25 / (SHEAR_OVER_MEMBRANE / softer - 1.0)
    }

    /// Returns the rotational inertia of a corner about its node per mass [length^2]: that of the
    /// section, but at least `floor` about the middle surface.
    pub fn inertia_per_mass(&self, own: OwnSection, floor: f64) -> f64 {
        let thickness = self.thickness_at_start(own);
        let arm = self.arm_at_start(own);
        (thickness * thickness / 12.0).max(floor) + arm * arm
    }

    /// Updates the stress at all points over a step and returns the resultants. N is the number of
    /// points.
    #[inline(always)]
    pub fn update<R: PointReal, const N: usize>(
        &self,
        history: &mut [R],
        strains: &Strains<R>,
        dt: f64,
    ) -> Resultants<R> {
        let half = R::splat(0.5);
        let failed = self.failed_lanes(history);
        let (front, points) = history.split_at_mut(POINTS);
        let count = self.count::<N>();
        let points = &mut points[..count * self.stride];
        let thickness = front[THICKNESS];
        let half_t = half * thickness;

        let mut eps = [[R::zero(); 3]; N];
        let mut work = R::zero();
        for k in 0..count {
            let z = R::splat(self.zeta[k]) * half_t;
            for (c, e) in eps[k].iter_mut().enumerate() {
                *e = z.mul_add(strains.kappa[c], strains.eps[c]);
            }
            work =
                R::splat(self.weight[k]).mul_add(power(&points[k * self.stride..], &eps[k]), work);
        }

        let mut eps_z = [R::zero(); N];
        R::update(
            &*self.law,
            Points { state: points, strain: &eps[..count], thickness_strain: &mut eps_z[..count] },
            dt,
        );

        let mut n = [R::zero(); 3];
        let mut m = [R::zero(); 3];
        for k in 0..count {
            let sig = &points[k * self.stride..];
            let weight = R::splat(self.weight[k]);
            let moment = R::splat(self.weight[k] * self.zeta[k]);
            work = weight.mul_add(power(sig, &eps[k]), work);
            for c in 0..3 {
                n[c] = weight.mul_add(sig[c], n[c]);
                m[c] = moment.mul_add(sig[c], m[c]);
            }
        }
        // The two loops over stress sum up old and new stress: one factor 1/2 is the trapezoidal
        // rule, the other belongs to the weight.
        work = half * half_t * work;
        let to_moment = half_t * half_t;

        let more = match &self.transverse {
            None => {
                let modulus = self.shear * SHEAR_CORRECTION * self.elastic.shear_modulus();
                strains.gamma.map(|gamma| [R::splat(modulus), gamma])
            }
            Some(moduli) => self.transverse_shear(moduli, points, strains.gamma),
        };
        let mut q = [R::zero(); 2];
        for c in 0..2 {
            let old = front[SHEAR + c];
            let [modulus, gamma] = more[c];
            let new = modulus.mul_add(gamma, old);
            let new = failed.map_or(new, |failed| R::select(failed, R::zero(), new));
            front[SHEAR + c] = new;
            work = (half_t * (old + new)).mul_add(strains.gamma[c], work);
            q[c] = thickness * new;
        }

        if self.thinning {
            // Mean over the thickness (weights sum to two), and exp() to second order.
            let mut mean = R::zero();
            for (eps_z, weight) in eps_z[..count].iter().zip(&self.weight) {
                mean = R::splat(0.5 * weight).mul_add(*eps_z, mean);
            }
            front[THICKNESS] = thickness.mul_add(mean.mul_add(half * mean, mean), thickness);
        }
        let (n, m) = (n.each(|n| n * half_t), m.each(|m| m * to_moment));
        Resultants { n, m, q, work, thickness }
    }

    /// Returns the number of points: N, except in shells with layers, which have at most N.
    #[inline(always)]
    pub(super) fn count<const N: usize>(&self) -> usize {
        if N > MAX_POINTS { self.points.min(N) } else { N }
    }

    /// Returns the yield stress at zero plastic strain [force/length^2]; `None` if the law has no
    /// plastic flow.
    #[inline(always)]
    pub fn least_flow_stress(&self) -> Option<f64> {
        self.plastic_strain.map(|_| self.initial_yield_stress)
    }

    /// Returns the lanes in which as many points have failed as remove an element; `None` if the
    /// law never fails.
    #[inline(always)]
    pub fn failed_lanes<R: Real>(&self, history: &[R]) -> Option<R::Mask> {
        let column = self.failed?;
        let marks = (0..self.points).map(|k| history[POINTS + k * self.stride + column]);
        if self.failed_points < self.points {
            let count = marks.fold(R::zero(), |count, mark| count + mark);
            return Some(count.gt(R::splat(self.failed_points as f64 - 0.5)));
        }
        Some(marks.fold(R::splat(1.0), Real::min).gt(R::splat(0.5)))
    }

    /// Makes the last point in the plane fail where the points through the thickness have failed at
    /// all others, since one point alone cannot hold the shape. Returns the lanes in which all have
    /// failed; `None` if the law never fails.
    #[inline(always)]
    pub fn fail_with_last_point<R: Real>(&self, history: &mut [R]) -> Option<R::Mask> {
        let column = self.failed?;
        let (each, one) = (self.each(), R::splat(1.0));
        let mut gone = R::zero();
        for point in history[..self.point_columns()].chunks_exact(each) {
            gone += R::select(self.failed_lanes(point)?, one, R::zero());
        }
        let failed = gone.gt(R::splat(self.planar as f64 - 1.5));
        for point in history[..self.point_columns()].chunks_exact_mut(each) {
            zero_failed(failed, &mut point[SHEAR..POINTS]);
            for k in 0..self.points {
                let point = &mut point[POINTS + k * self.stride..][..self.stride];
                zero_failed(failed, &mut point[..3]);
                point[column] = R::select(failed, one, point[column]);
            }
        }
        Some(failed)
    }

    /// Deletes inverted elements of a part with [`Self::deletes`]. Returns the lanes with deleted
    /// elements, now or before. `calm` are the lanes that have an area and the strain increments of
    /// a valid step, `sound` those that are valid in all respects. `moves` returns a sum over
    /// coordinates and velocities, and is called if a lane is neither: if the sum is not finite, no
    /// element is deleted and the run must stop. A deleted element keeps no state, since its shape
    /// gives no valid one.
    #[cold]
    #[inline(never)]
    pub fn delete_inverted<R: Real>(
        &self,
        history: &mut [R],
        calm: R::Mask,
        sound: R::Mask,
        moves: impl FnOnce() -> R,
    ) -> R::Mask {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let (columns, each) = (self.point_columns(), self.each());
        let last = history.len() - 1;
        let (state, mark) = history.split_at_mut(last);
        let inverted = R::select(R::either(calm, sound), zero, one);
        if R::any(inverted.gt(zero)) {
            let is_finite = moves().le(R::splat(R::LARGEST));
            mark[0] = Real::max(mark[0], R::select(is_finite, inverted, zero));
        }
        let gone = mark[0].gt(R::splat(0.5));
        if !R::any(gone) {
            return gone;
        }
        for (column, value) in state.iter_mut().enumerate() {
            let kept = match column {
                VOLUME | INERTIA => *value,
                _ if self.stores_offsets && column == columns => *value,
                _ if column < columns && column % each == THICKNESS => {
                    let known = value.abs().le(R::splat(R::LARGEST));
                    R::select(known, *value, R::splat(self.thickness))
                }
                _ => zero,
            };
            *value = R::select(gone, kept, *value);
        }
        gone
    }

    /// Returns true if elements can fail, by their law or because they are inverted.
    pub fn can_fail(&self) -> bool {
        self.failed.is_some() || self.deletes
    }

    /// Returns true if as many points of one element have failed as remove it.
    pub fn has_failed(&self, history: ElementState<'_>) -> bool {
        let each = self.each();
        let mark = |p: usize, k: usize, column: usize| {
            history.at(p * each + POINTS + k * self.stride + column)
        };
        self.failed.is_some_and(|column| {
            let failed = |p: usize| (0..self.points).filter(|&k| mark(p, k, column) > 0.5).count();
            (0..self.planar).all(|p| failed(p) >= self.failed_points)
        })
    }

    /// Returns the lanes in which the strain increments at both faces are those of a valid step
    /// (false if NaN).
    #[inline(always)]
    pub fn sound_points<R: Real>(&self, strains: &Strains<R>, thickness: R) -> R::Mask {
        let half_t = R::splat(0.5) * thickness;
        let face = |c: usize| half_t.mul_add(strains.kappa[c].abs(), strains.eps[c].abs());
        // Twice the shear is compared with twice the limit. A maximum ignores NaN; a sum does not.
        let direct = Real::max(face(0), face(1)) + R::zero() * (face(0) + face(1));
        let shear = half_of(face(2)) + R::zero() * (strains.gamma[0] + strains.gamma[1]);
        R::both(direct.le(R::splat(STRAIN_LIMIT)), shear.le(R::splat(STRAIN_LIMIT)))
    }

    /// Returns the points through the thickness of one element, as means over its points in the
    /// plane; `axes` as in [`Self::fields`].
    pub fn point_fields(
        &self,
        history: ElementState<'_>,
        axes: &[[f64; 3]; 3],
    ) -> Vec<PointFields> {
        let mean = |column: usize| {
            let values = (0..self.planar).map(|p| history.at(p * self.each() + column));
            values.sum::<f64>() / self.planar as f64
        };
        let of = |k: usize| {
            let at = |c: usize| mean(POINTS + k * self.stride + c);
            PointFields {
                stress: in_global_axes([0, 1, 2].map(at), [SHEAR, SHEAR + 1].map(mean), axes),
                plastic_strain: self.plastic_strain.map_or(0.0, at),
            }
        };
        (0..self.points).map(of).collect()
    }

    /// Returns the fields of one element. Stress and thickness are means over its points in the
    /// plane; `axes` are its e1, e2 and normal.
    pub fn fields(&self, history: ElementState<'_>, axes: &[[f64; 3]; 3]) -> ElementFields {
        let mean = |column: usize| {
            let values = (0..self.planar).map(|p| history.at(p * self.each() + column));
            values.sum::<f64>() / self.planar as f64
        };
        let (mut von_mises, mut plastic_strain, mut damage) = (0.0_f64, 0.0_f64, 0.0_f64);
        for (p, k) in (0..self.planar).flat_map(|p| (0..self.points).map(move |k| (p, k))) {
            let point = |c: usize| history.at(p * self.each() + POINTS + k * self.stride + c);
            let [x, y, t] = [0, 1, 2].map(point);
            von_mises = von_mises.max((x * x + y * y - x * y + 3.0 * t * t).sqrt());
            plastic_strain = plastic_strain.max(self.plastic_strain.map_or(0.0, point));
            damage = damage.max(self.damage.map_or(0.0, point));
        }
        // The middle point, or the mean of the two points nearest to the middle.
        let layer = |k: usize, c: usize| mean(POINTS + k * self.stride + c);
        let (below, above) = ((self.points - 1) / 2, self.points / 2);
        let plane = [0, 1, 2].map(|c| 0.5 * (layer(below, c) + layer(above, c)));
        ElementFields {
            plastic_strain,
            damage,
            stress: in_global_axes(plane, [SHEAR, SHEAR + 1].map(mean), axes),
            von_mises,
            thickness: mean(THICKNESS),
            failed: self.has_failed(history),
        }
    }
}

/// Returns a stress in global axes [force/length^2]: xx, yy, zz, xy, yz, zx. `plane` is its part in
/// the plane of the shell (xx, yy, xy), `shear` the transverse one (xz, yz).
fn in_global_axes(plane: [f64; 3], shear: [f64; 2], axes: &[[f64; 3]; 3]) -> [f64; 6] {
    let ([xx, yy, xy], [xz, yz]) = (plane, shear);
    let local = [[xx, xy, xz], [xy, yy, yz], [xz, yz, 0.0]];
    let global = |i: usize, j: usize| -> f64 {
        (0..3).map(|a| (0..3).map(|b| axes[a][i] * local[a][b] * axes[b][j]).sum::<f64>()).sum()
    };
    [global(0, 0), global(1, 1), global(2, 2), global(0, 1), global(1, 2), global(2, 0)]
}

/// Returns stress times strain increment at one point.
#[inline(always)]
fn power<R: Real>(sig: &[R], eps: &[R; 3]) -> R {
    sig[0].mul_add(eps[0], sig[1].mul_add(eps[1], sig[2] * eps[2]))
}

#[inline(always)]
fn half_of<R: Real>(value: R) -> R {
    R::splat(0.5) * value
}
