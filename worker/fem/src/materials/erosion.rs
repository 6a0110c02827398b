//! Criteria of failure that any law can have in addition to its own, as in `*MAT_ADD_EROSION`:
//! ```text
//! p >= max_pressure,   p <= min_pressure,   sigma_1 >= principal_stress,
//! sigma_vm >= von_mises,   eps_p >= plastic_strain,   ln V >= volume_strain,
//! -eps_z >= thinning,   eps_1 >= major_strain,   -ln V >= compression,
//! sqrt(2/3 e:e) >= effective_strain,
//! (max(sigma_n, 0)/weld_normal_stress)^2 + (tau/weld_shear_stress)^2 >= 1
//! ```
//! with the pressure p (the mean stress with the other sign), the largest principal stress and the
//! logarithm of the ratio of volumes; a negative limit of `volume_strain` is one of compression.
//! Thinning, of shells, is the strain through the thickness; the major strain is the largest
//! principal strain, in shells in the plane, and e the deviator of the strain, in shells without
//! the transverse shear. All three are of sums of the increments, in axes that turn with the
//! material. A point fails as soon as one of them holds; its stress is zero from then on. Each
//! criterion has the key of its name with `erosion_` before it. The last one, of spot welds as
//! solids, is of the normal stress and the shear stress on the plane of the sides of the node 1 in
//! the face of the nodes 1 to 4, which turns with the material; a limit that is not given is
//! infinite.
//!
//! With `major_strain_start` e_s the stress fades before it: a point carries the share
//! ```text
//! 1 - max over time of (eps_1 - e_s)/(major_strain - e_s)
//! ```
//! of the stress of the law, between 0 and 1. It does not rise again when the strain falls.
//!
//! A law without criteria is not wrapped, so that it runs the same code as before.

use super::failed_points::FailedPoints;
use super::tensor::{Principal, deviator, full, inner, trace};
use super::wrapped::{self, LawModifier, PointColumns, full_stress};
use super::{
    AXES_COLUMNS, DefaultValue, Form, LawResult, MaterialAxes, ParameterRow, PlaneStress,
    STRAIN_COLUMN, Solid, SolidLawResult, axes_of,
};
use crumple_math::lanes::{Real, dot};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;
use std::convert::Infallible;

/// Creates a row of a criterion.
const fn row(key: &'static str, meaning: &'static str) -> ParameterRow {
    ParameterRow { key, form: Form::Number, otherwise: DefaultValue::Absent, range: None, meaning }
}

/// Keys of all laws.
pub const EROSION: &[ParameterRow] = &[
    row(
        "erosion_max_pressure",
        "Pressure, positive in compression, from which on a point fails [force/length^2].",
    ),
    row(
        "erosion_min_pressure",
        "Pressure, negative in tension, down to which a point carries stress [force/length^2].",
    ),
    row(
        "erosion_principal_stress",
        "Largest principal stress from which on a point fails [force/length^2].",
    ),
    row("erosion_von_mises", "Von Mises stress from which on a point fails [force/length^2]."),
    row(
        "erosion_plastic_strain",
        "Effective plastic strain from which on a point fails, of laws that have one.",
    ),
    row(
        "erosion_volume_strain",
        "Logarithm of the ratio of volumes from which on a point fails; a negative one is a limit \
         of compression. For solids.",
    ),
    row(
        "erosion_thinning",
        "Logarithm of the thickness at the start over the present one from which on a point \
         fails. For shells.",
    ),
    row(
        "erosion_major_strain",
        "Largest principal strain, logarithmic, from which on a point fails; in shells that in the \
         plane, in fibres of beams and trusses that along or across.",
    ),
    row(
        "erosion_compression",
        "Logarithm of the volume at the start over the present one from which on a point fails. \
         For solids.",
    ),
    row(
        "erosion_major_strain_start",
        "Largest principal strain from which on the stress falls, in proportion to the strain, \
         until it is zero at `erosion_major_strain`; it has to be below it.",
    ),
    row(
        "erosion_effective_strain",
        "Effective strain from which on a point fails, elastic and plastic together.",
    ),
    row(
        "erosion_weld_normal_stress",
        "Spot weld: tensile stress across the weld at which a point fails, with the square of the \
         shear stress over its limit [force/length^2]. For solids; the faces of the nodes 1 to 4 \
         and 5 to 8 are those on the sheets.",
    ),
    row("erosion_weld_shear_stress", "Spot weld: the same for the shear stress [force/length^2]."),
    row(
        "erosion_failed_points",
        "Number of points through the thickness of a shell that have to fail until it is removed, \
         below 0 a percentage of them. Without it all of them, or as many as a damage of the \
         material says. Solids and beams are removed when all their points have failed.",
    ),
];

/// Places in [`EROSION`].
const MAJOR_STRAIN: usize = 7;
const START: usize = 9;
const EFFECTIVE_STRAIN: usize = 10;
const WELD: [usize; 2] = [11, 12];
const FAILED_POINTS: usize = 13;

/// Column that marks failure.
const FAILED: &str = "failed";

/// Columns of the strain in the plane: xx, yy, and twice xy.
const PLANE_STRAIN: [&str; 3] = [STRAIN_COLUMN, "erosion strain yy", "erosion strain xy"];

/// Columns of the strain of solids, which the element rotates: its components as a tensor.
const STRAIN: [&str; 6] = [
    STRAIN_COLUMN,
    "erosion strain yy",
    "erosion strain zz",
    "erosion strain xy",
    "erosion strain yz",
    "erosion strain zx",
];

/// ErosionLimits in the order of [`EROSION`].
type ErosionLimits = [Option<f64>; EROSION.len()];

/// Returns the material without its criteria, and their limits; or all problems of the criteria.
pub fn split(material: &Material) -> Result<(Material, ErosionLimits), Vec<Problem>> {
    let mut rest = material.clone();
    let mut problems = Vec::new();
    let mut limits = [None; EROSION.len()];
    for (limit, row) in limits.iter_mut().zip(EROSION) {
        let Some(param) = rest.parameters.remove(row.key) else { continue };
        let wanted = match row.key {
            "erosion_min_pressure" => "below 0",
            "erosion_volume_strain" => "above or below 0, but not 0",
            "erosion_failed_points" => FailedPoints::WANTED,
            _ => "above 0",
        };
        let fits = |x: f64| match wanted {
            "below 0" => x < 0.0,
            "above 0" => x > 0.0,
            FailedPoints::WANTED => FailedPoints::is_possible(x),
            _ => x != 0.0,
        };
        match param {
            Param::Number(x) if x.is_finite() && fits(x) => *limit = Some(x),
            _ => {
                let message = format!("material '{}': {} is not valid", material.name, row.key);
                problems.push(Problem::error(row.key, message, format!("it has to be {wanted}")));
            }
        }
    }
    if let Some(start) = limits[START]
        && limits[MAJOR_STRAIN].is_none_or(|end| start >= end)
    {
        let key = EROSION[START].key;
        let message = format!("material '{}': {key} is {start:?}", material.name);
        let help = "it has to be below erosion_major_strain, which has to be given";
        problems.push(Problem::error(key, message, help));
    }
    if limits[FAILED_POINTS].is_some() && limits[..FAILED_POINTS].iter().all(Option::is_none) {
        let key = EROSION[FAILED_POINTS].key;
        let message = format!("material '{}': {key} without a criterion", material.name);
        let help = "give one of the other erosion_... keys, or remove it";
        problems.push(Problem::error(key, message, help));
    }
    if problems.is_empty() { Ok((rest, limits)) } else { Err(problems) }
}

/// Returns the problems of criteria of welds of a material of solids other than hexahedra, whose
/// faces do not say which ones are on the sheets.
pub fn problems_of_welds(material: &Material) -> Vec<Problem> {
    let keys = WELD.map(|at| EROSION[at].key);
    let given = keys.into_iter().filter(|key| material.parameters.contains_key(*key));
    given
        .map(|key| {
            let message = format!("material '{}': {key} is for hexahedra only", material.name);
            Problem::error(key, message, "mesh welds with hexahedra, or use beams")
        })
        .collect()
}

/// Criteria of a law.
struct Erosion {
    limits: ErosionLimits,
    /// Columns: failure, plastic strain, volume, strain through the thickness, first of the strains
    /// in the plane.
    failed: usize,
    plastic_strain: Option<usize>,
    volume: Option<usize>,
    thickness: Option<usize>,
    plane: Option<usize>,
    /// First column of the strain of solids.
    strain: Option<usize>,
    /// Column of the share of the stress that has faded.
    faded: Option<usize>,
    /// First column of the axes of a weld.
    weld: Option<usize>,
}

impl Erosion {
    fn new(
        material: &Material,
        limits: ErosionLimits,
        columns: &mut PointColumns,
    ) -> Result<Self, Vec<Problem>> {
        let volume = limits[5].or(limits[8]).map(|_| columns.add("erosion volume"));
        let of_solid = columns.of_solid();
        let thins = limits[6].is_some() || limits[EFFECTIVE_STRAIN].is_some() && !of_solid;
        let thickness = thins.then(|| columns.add("erosion thickness strain"));
        let strains = limits[MAJOR_STRAIN].or(limits[EFFECTIVE_STRAIN]).is_some();
        let plane = (strains && !of_solid).then(|| PLANE_STRAIN.map(|name| columns.add(name))[0]);
        let strain = (strains && of_solid).then(|| STRAIN.map(|name| columns.add(name))[0]);
        let faded = limits[START].map(|_| columns.add("erosion faded"));
        let of_weld = WELD.into_iter().find(|&at| limits[at].is_some());
        let has_axes = columns.find(AXES_COLUMNS[0]).is_some();
        let weld = (of_weld.is_some() && of_solid && !has_axes)
            .then(|| AXES_COLUMNS.map(|name| columns.add(name))[0]);
        let failed = columns.add(FAILED);
        let plastic_strain = columns.find("plastic_strain");
        let missing = if let Some(at) = of_weld.filter(|_| weld.is_none()) {
            let why = match of_solid {
                true => "the law has axes of its own",
                false => "it is for spot welds as solids",
            };
            Some((EROSION[at].key, why))
        } else if limits[4].is_some() && plastic_strain.is_none() {
            Some((EROSION[4].key, "the law has no plastic strain"))
        } else if let Some(at) = [5, 8].into_iter().find(|&at| limits[at].is_some() && !of_solid) {
            Some((EROSION[at].key, "shells have no change of volume of their own"))
        } else {
            let why = "it is for shells, and a part of solids has this material";
            (limits[6].is_some() && of_solid).then_some((EROSION[6].key, why))
        };
        if let Some((key, why)) = missing {
            let message = format!("material '{}': {key} is given, but {why}", material.name);
            return Err(vec![Problem::error(key, message, "remove it")]);
        }
        Ok(Self { limits, failed, plastic_strain, volume, thickness, plane, strain, faded, weld })
    }

    /// Returns the largest principal strain; none if no column has the strain.
    #[inline(always)]
    fn major_strain<R: Real>(&self, state: &[R]) -> Option<R> {
        if let Some(column) = self.plane {
            let [x, y, xy] = std::array::from_fn(|c| state[column + c]);
            let (half, apart) = (R::splat(0.5), x - y);
            let radius = apart.mul_add(apart, xy * xy).sqrt();
            return Some(half * (x + y + radius));
        }
        let column = self.strain?;
        let [a, b, c] = Principal::new(&std::array::from_fn(|c| state[column + c])).values;
        Some(Real::max(Real::max(a, b), c))
    }

    /// Returns the effective strain; none if no column has the strain.
    #[inline(always)]
    fn effective_strain<R: Real>(&self, state: &[R]) -> Option<R> {
        let strain = match (self.plane, self.thickness) {
            (Some(plane), Some(through)) => {
                let [x, y, xy] = std::array::from_fn(|c| state[plane + c]);
                [x, y, state[through], R::splat(0.5) * xy, R::zero(), R::zero()]
            }
            _ => {
                let column = self.strain?;
                std::array::from_fn(|c| state[column + c])
            }
        };
        let e = deviator(&strain);
        Some((R::splat(2.0 / 3.0) * inner(&e, &e)).sqrt())
    }

    /// Returns the share of the stress of the law that acts.
    #[inline(always)]
    fn intact<R: Real>(&self, state: &[R]) -> Option<R> {
        let left = R::splat(1.0) - state[self.faded?];
        // A point without stress has failed.
        Some(R::select(left.gt(R::zero()), left, R::splat(1.0)))
    }

    /// Lets the stress fade with the strain; `before` is the share that acted. Returns the factor
    /// on the stiffness.
    #[inline(always)]
    fn fade<R: Real>(&self, state: &mut [R], stress: usize, before: R) -> R {
        let (Some(faded), Some(start), Some(end)) =
            (self.faded, self.limits[START], self.limits[MAJOR_STRAIN])
        else {
            return R::splat(1.0);
        };
        let strain = self.major_strain(state).unwrap_or_else(R::zero);
        let share = (strain - R::splat(start)) * R::splat(1.0 / (end - start));
        let share = Real::min(Real::max(share, state[faded]), R::splat(1.0));
        state[faded] = share;
        let after = R::splat(1.0) - share;
        state[..stress].iter_mut().for_each(|s| *s = after * *s);
        after / before
    }

    /// Returns the left side of the criterion of a weld with these axes.
    #[inline(always)]
    fn weld_usage<R: Real>(&self, sig: &[R; 6], axes: &[R]) -> R {
        let [_, _, normal] = axes_of(axes);
        let rows = full(*sig);
        let traction: [R; 3] = std::array::from_fn(|i| dot(rows[i], normal));
        let direct = dot(traction, normal);
        let shear = Real::max(direct.neg_mul_add(direct, dot(traction, traction)), R::zero());
        let direct = Real::max(direct, R::zero());
        let [of_normal, of_shear] =
            WELD.map(|at| R::splat(self.limits[at].map_or(0.0, |limit| limit.powi(-2))));
        of_normal.mul_add(direct * direct, of_shear * shear)
    }

    /// Marks failure by the stress (xx, yy, zz, xy, yz, zx) and the columns; removes the stress of
    /// failed lanes, the first `stress` columns.
    #[inline(always)]
    fn fail<R: Real>(&self, sig: &[R; 6], state: &mut [R], stress: usize) {
        let (zero, one) = (R::zero(), R::splat(1.0));
        let mut fails = zero.gt(zero);
        let mut at_least = |value: R, limit: Option<f64>| {
            if let Some(limit) = limit {
                fails = R::either(fails, value.ge(R::splat(limit)));
            }
        };
        let pressure = R::splat(-1.0 / 3.0) * trace(sig);
        at_least(pressure, self.limits[0]);
        at_least(-pressure, self.limits[1].map(|limit| -limit));
        if self.limits[2].is_some() {
            let [a, b, c] = Principal::new(sig).values;
            at_least(Real::max(Real::max(a, b), c), self.limits[2]);
        }
        if self.limits[3].is_some() {
            let s = deviator(sig);
            at_least((R::splat(1.5) * inner(&s, &s)).sqrt(), self.limits[3]);
        }
        if let Some(column) = self.plastic_strain {
            at_least(state[column], self.limits[4]);
        }
        if let Some(column) = self.weld {
            at_least(self.weld_usage(sig, &state[column..]), Some(1.0));
        }
        if let Some(column) = self.volume {
            if let Some(limit) = self.limits[5] {
                at_least(R::splat(limit.signum()) * state[column], Some(limit.abs()));
            }
            at_least(-state[column], self.limits[8]);
        }
        if let Some(column) = self.thickness {
            at_least(-state[column], self.limits[6]);
        }
        if self.limits[MAJOR_STRAIN].is_some()
            && let Some(strain) = self.major_strain(state)
        {
            at_least(strain, self.limits[MAJOR_STRAIN]);
        }
        if self.limits[EFFECTIVE_STRAIN].is_some()
            && let Some(strain) = self.effective_strain(state)
        {
            at_least(strain, self.limits[EFFECTIVE_STRAIN]);
        }
        let failed = R::select(fails, one, state[self.failed]);
        state[self.failed] = failed;
        let alive = failed.lt(R::splat(0.5));
        state[..stress].iter_mut().for_each(|s| *s = R::select(alive, *s, zero));
    }
}

impl LawModifier for Erosion {
    #[inline(always)]
    fn update<R: Real>(&self, state: &mut [R], strain: &[R], law: impl FnOnce(&mut [R]) -> R) -> R {
        let before = self.intact(state);
        if let Some(before) = before {
            state[..strain.len()].iter_mut().for_each(|s| *s = *s / before);
        }
        let of_law = law(state);
        if let Some(column) = self.thickness {
            state[column] += of_law;
        }
        if let Some(column) = self.plane {
            (0..3).for_each(|c| state[column + c] += strain[c]);
        }
        if let Some(column) = self.strain {
            let half = R::splat(0.5);
            for (c, &increment) in strain.iter().enumerate() {
                state[column + c] += if c < 3 { increment } else { half * increment };
            }
        }
        if let Some(column) = self.volume {
            state[column] += strain[0] + strain[1] + strain[2];
        }
        let left = before.map(|before| self.fade(state, strain.len(), before));
        self.fail(&full_stress(state, strain.len()), state, strain.len());
        left.map_or(of_law, |left| of_law * left)
    }

    fn failed_points(&self, points: usize, of_law: usize) -> usize {
        FailedPoints::new(self.limits[FAILED_POINTS]).of(points, of_law)
    }

    fn axes(&self) -> Option<MaterialAxes> {
        self.weld.map(|_| MaterialAxes::Nodes)
    }
}

/// Adds criteria to a law of shells.
pub fn shell(material: &Material, law: Box<dyn PlaneStress>, limits: ErosionLimits) -> LawResult {
    if limits.iter().all(Option::is_none) {
        return Ok(law);
    }
    let through = [6, EFFECTIVE_STRAIN].into_iter().find(|&at| limits[at].is_some());
    if let Some(at) = through.filter(|_| !law.thins()) {
        let (name, key) = (&material.name, EROSION[at].key);
        let message =
            format!("material '{name}': {key} is given, but the law has no change of thickness");
        return Err(vec![Problem::error(key, message, "remove it")]);
    }
    wrapped::shell(law, |columns| Erosion::new(material, limits, columns))
}

/// Adds criteria to a law of solids.
pub fn solid(material: &Material, law: Box<dyn Solid>, limits: ErosionLimits) -> SolidLawResult {
    if limits.iter().all(Option::is_none) {
        return Ok(law);
    }
    wrapped::solid(law, |columns| Erosion::new(material, limits, columns))
}

/// Gives a law of solids a column of failure, if it has none.
pub fn that_can_fail(law: Box<dyn Solid>) -> Box<dyn Solid> {
    if law.history().contains(&FAILED) {
        return law;
    }
    let none = |columns: &mut PointColumns| -> Result<_, Infallible> {
        Ok(Erosion {
            limits: [None; EROSION.len()],
            failed: columns.add(FAILED),
            plastic_strain: None,
            volume: None,
            thickness: None,
            plane: None,
            strain: None,
            faded: None,
            weld: None,
        })
    };
    match wrapped::solid(law, none) {
        Ok(law) => law,
    }
}

#[cfg(test)]
mod tests {
    use crate::materials::testing::{Cube, Sheet, material, problems};
    use crumple_proto::partition::Material;

    const E: f64 = 200.0;

    fn glass(more: &[(&str, f64)]) -> Material {
        let numbers = [&[("youngs_modulus", E), ("poisson", 0.25)], more].concat();
        material("elastic", &numbers, &[])
    }

    /// Strain at which a cube on this path fails, in steps of 1e-6 of the strain along x; it has no
    /// stress then, and none afterwards.
    fn fails_at(law: &Material, path: [f64; 6]) -> f64 {
        let mut cube = Cube::new(law);
        let mut steps = 0.0;
        while cube.at("failed") == 0.0 {
            cube.step(path.map(|e| 1e-6 * e), 1.0);
            steps += 1.0;
            assert!(steps < 2e4, "it must fail: {path:?}");
        }
        cube.step(path.map(|e| 1e-3 * e), 1.0);
        assert!(cube.state[..6].iter().all(|s| *s == 0.0), "{:?}", cube.state);
        1e-6 * steps
    }

    /// A spot weld across z under tension with shear fails on the ellipse of both limits, under
    /// pressure by shear alone; each limit may stand alone. Its axes are those of the start.
    #[test]
    fn welds_fail_on_an_ellipse() {
        let (normal, shear) = (0.4, 0.3);
        let limits = [("erosion_weld_normal_stress", normal), ("erosion_weld_shear_stress", shear)];
        let numbers = [("youngs_modulus", E), ("poisson", 0.0)];
        let of =
            |limits: &[(&str, f64)]| material("elastic", &[&numbers[..], limits].concat(), &[]);
        // Stress zz of E and shear stress of E/2 per strain of the path.
        let (e, g) = (E, 0.5 * E);
        for (law, path, wanted) in [
            (of(&limits), [1.0, 0.0, 1.0, 0.0, 0.0, 0.0], normal / e),
            (of(&limits), [0.0, 0.0, 0.0, 1.0, 3.0, 4.0], shear / (5.0 * g)),
            (
                of(&limits),
                [0.0, 0.0, 1.0, 0.0, 1.0, 0.0],
                ((e / normal).powi(2) + (g / shear).powi(2)).powf(-0.5),
            ),
            (of(&limits), [0.0, 0.0, -5.0, 0.0, 0.0, 1.0], shear / g),
            (of(&limits[..1]), [0.0, 0.0, 1.0, 0.0, 9.0, 0.0], normal / e),
            (of(&limits[1..]), [0.0, 0.0, 9.0, 0.0, 1.0, 0.0], shear / g),
        ] {
            let got = fails_at(&law, path);
            assert!(got >= wanted - 1e-12 && got < wanted + 1.1e-6, "{path:?}: {got} for {wanted}");
        }
        let text = problems(&of(&limits));
        assert!(text.contains("it is for spot welds as solids"), "{text}");
    }

    /// Stretched along x with nu = 0, the stress is `(1 - D) E eps` with the share D that grows
    /// from the start to the end of fading; it does not rise again, and ends at the limit.
    #[test]
    fn stress_fades_before_the_limit_of_the_major_strain() {
        let (start, end) = (0.004, 0.0121);
        let fading = [
            ("youngs_modulus", E),
            ("poisson", 0.0),
            ("erosion_major_strain", end),
            ("erosion_major_strain_start", start),
        ];
        let law = material("elastic", &fading, &[]);
        let (mut cube, mut sheet) = (Cube::new(&law), Sheet::new(&law));
        let (mut strain, mut most) = (0.0, 0.0f64);
        let path = (0..80).map(|k| if (40..50).contains(&k) { -1.0 } else { 1.0 });
        for sign in path {
            let step = sign * 2e-4;
            cube.step([step, 0.0, 0.0, 0.0, 0.0, 0.0], 1.0);
            sheet.step([step, 0.0, 0.0], 1.0);
            strain += step;
            most = most.max(strain);
            let lost = ((most - start) / (end - start)).clamp(0.0, 1.0);
            let expected = (1.0 - lost) * E * strain;
            for stress in [cube.state[0], sheet.state[0]] {
                assert!((stress - expected).abs() < 1e-10, "{strain}: {stress}, {expected}");
            }
            assert_eq!(cube.at("failed") == 1.0, most > end, "{strain}");
        }
        for (numbers, words) in [
            (&[("erosion_major_strain_start", 0.1)][..], "it has to be below"),
            (&[("erosion_major_strain_start", 0.1), ("erosion_major_strain", 0.1)], "below"),
        ] {
            let found = problems(&glass(numbers));
            assert!(found.contains(words), "{found}");
        }
    }

    /// Each criterion at the strain of its closed form, within a step.
    #[test]
    fn each_criterion_fails_at_its_limit() {
        let (bulk, g) = (E / 1.5, E / 2.5);
        let all = [1.0, 1.0, 1.0, 0.0, 0.0, 0.0];
        let shear = [0.0, 0.0, 0.0, 2.0, 0.0, 0.0];
        for (key, limit, path, exact) in [
            ("erosion_max_pressure", 0.5, all.map(|e: f64| -e), 0.5 / (3.0 * bulk)),
            ("erosion_min_pressure", -0.5, all, 0.5 / (3.0 * bulk)),
            // Shear stress 2 G e is the principal stress; the von Mises stress is sqrt(3) of it.
            ("erosion_principal_stress", 0.4, shear, 0.4 / (2.0 * g)),
            ("erosion_von_mises", 0.4, shear, 0.4 / (2.0 * g * 3.0f64.sqrt())),
            ("erosion_volume_strain", 0.01, all, 0.01 / 3.0),
            ("erosion_volume_strain", -0.01, all.map(|e: f64| -e), 0.01 / 3.0),
            ("erosion_compression", 0.01, all.map(|e: f64| -e), 0.01 / 3.0),
            ("erosion_major_strain", 0.004, shear, 0.004),
            ("erosion_major_strain", 0.004, [0.5, -1.0, 1.0, 0.0, 0.0, 0.0], 0.004),
            // Without change of volume, 2/3 e:e is the square of the strain along the axis; in
            // shear e it is 4/3 e^2.
            ("erosion_effective_strain", 0.004, [1.0, -0.5, -0.5, 0.0, 0.0, 0.0], 0.004),
            ("erosion_effective_strain", 0.004, shear, 0.004 * 0.75f64.sqrt()),
        ] {
            let got = fails_at(&glass(&[(key, limit)]), path);
            assert!((got - exact).abs() < 1.5e-6, "{key} {limit}: {got} for {exact}");
        }
        let metal = [
            ("youngs_modulus", E),
            ("poisson", 0.25),
            ("yield_stress", 0.2),
            ("erosion_plastic_strain", 0.005),
        ];
        let got = fails_at(&material("j2", &metal, &[]), shear);
        // Effective strain 2/sqrt(3) e, of which 0.2/(3 G) is elastic.
        let exact = (0.005 + 0.2 / (3.0 * g)) * 3.0f64.sqrt() / 2.0;
        assert!((got - exact).abs() < 1.5e-6, "{got} for {exact}");
    }

    /// A sheet fails at the principal stress of uniaxial tension, but not in compression.
    #[test]
    fn a_sheet_fails_in_tension() {
        let law = glass(&[("erosion_principal_stress", 0.1)]);
        let mut sheet = Sheet::new(&law);
        (0..499).for_each(|_| sheet.pull(1e-6, 1.0));
        assert!((sheet.state[0] - 0.0998).abs() < 1e-9 && sheet.state[3] == 0.0);
        (0..3).for_each(|_| sheet.pull(1e-6, 1.0));
        assert!(sheet.state[0] == 0.0 && sheet.state[3] == 1.0, "{:?}", sheet.state);
        let mut pressed = Sheet::new(&law);
        (0..1000).for_each(|_| pressed.step([-1e-6, 0.25e-6, 0.0], 1.0));
        assert!((pressed.state[0] + 1e-3 * E).abs() < 1e-9, "uniaxial: {:?}", pressed.state);
        assert_eq!(pressed.state[3], 0.0);
    }

    /// Strain through the thickness of uniaxial tension, `nu eps`, and the larger principal strain,
    /// of tension `eps` and of pure shear half of the engineering strain.
    #[test]
    fn a_sheet_fails_at_a_strain() {
        for (key, limit, strain, exact) in [
            ("erosion_thinning", 1e-3, [1e-5, -0.25e-5, 0.0], 4e-3),
            ("erosion_major_strain", 1e-3, [1e-5, -0.25e-5, 0.0], 1e-3),
            ("erosion_major_strain", 1e-3, [-1e-5, 1e-5, 0.0], 1e-3),
            ("erosion_major_strain", 1e-3, [0.0, 0.0, 1e-5], 2e-3),
            // Tension with nu = 1/4: the deviator is 5/6 of that without change of volume.
            ("erosion_effective_strain", 1e-3, [1e-5, -0.25e-5, 0.0], 1.2e-3),
            ("erosion_effective_strain", 1e-3, [0.0, 0.0, 1e-5], 1e-3 * 3.0f64.sqrt()),
        ] {
            let mut sheet = Sheet::new(&glass(&[(key, limit)]));
            let last = sheet.state.len() - 1;
            let mut reached = 0.0_f64;
            while sheet.state[last] == 0.0 {
                sheet.step(strain, 1.0);
                reached += 1e-5;
                assert!(reached < 1.0, "{key} must fail");
            }
            assert!((reached - exact).abs() < 1.5e-5, "{key} {strain:?}: {reached} for {exact}");
            assert!(sheet.state[..3].iter().all(|s| *s == 0.0));
        }
    }

    #[test]
    fn wrong_criteria_are_refused() {
        for (key, value, words) in [
            ("erosion_min_pressure", 1.0, "below 0"),
            ("erosion_von_mises", 0.0, "above 0"),
            ("erosion_plastic_strain", 0.1, "no plastic strain"),
        ] {
            let text = problems(&glass(&[(key, value)]));
            assert!(text.contains(words) && text.contains(key), "{text}");
        }
        let text = problems(&glass(&[("erosion_volume_strain", 0.1)]));
        assert!(text.contains("shells have no change of volume"), "{text}");
        let moduli = [("youngs_modulus", E), ("poisson", 0.25), ("erosion_thinning", 0.1)];
        let text = problems(&material("fabric", &moduli, &[]));
        assert!(text.contains("no change of thickness"), "{text}");
        let moduli = [("youngs_modulus", E), ("poisson", 0.2), ("erosion_effective_strain", 0.1)];
        let text = problems(&material("fabric", &moduli, &[]));
        assert!(text.contains("no change of thickness"), "{text}");
        let text = problems(&glass(&[("erosion_thinning", 0.1)]));
        assert!(text.contains("it is for shells") && text.contains("erosion_thinning"), "{text}");
        let text = problems(&glass(&[("erosion_compression", 0.1)]));
        assert!(text.contains("erosion_compression") && text.contains("shells have no"), "{text}");
    }
}
