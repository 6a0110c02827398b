//! Material laws. Each law is one file and one row in [`LAWS`].
//!
//! A law sees only integration points: stress, history and strain increments in; stress and
//! history out; all in axes that rotate with the material. Rotation, thickness and integration
//! belong to the element.

mod axes;
mod barlat;
mod cohesive;
mod crushable_foam;
mod cscm;
mod damaged;
mod diem;
mod elastic;
mod equation_of_state;
mod erosion;
mod fabric;
mod failed_points;
mod fluid;
mod gissmo;
mod gurson;
mod hardening;
mod honeycomb;
mod interior;
mod isentrope;
mod j2;
mod johnson_cook;
mod layered;
mod low_density_foam;
mod orthotropic;
mod parameters;
pub mod plasticity;
mod polyline;
mod polymer;
mod pressure_dependent;
mod prony;
mod rubber;
pub(crate) mod tensor;
mod viscoelastic;
mod viscous_foam;
mod wrapped;

pub use crate::parameter::{DefaultValue, Form, ParameterRow};
pub use axes::{DIRECTION, DIRECTION_COLUMNS, Orientation};
pub use cohesive::{Cohesive, CohesiveLawResult, CohesivePoint};
pub use diem::DIEM;
pub use equation_of_state::{EQUATION_OF_STATE, Equation};
pub use erosion::{EROSION, problems_of_welds, that_can_fail};
pub use gissmo::{GISSMO, SIZE_COLUMN};
pub use interior::with_interior_contact;
pub use isentrope::Isentrope;
pub use layered::{LayerPoint, MAX_LAYER_POINTS, layered};
pub use parameters::Parameters;
pub(crate) use parameters::unknown_name;

use crate::registry::{Named, Registry};
use crumple_math::lanes::{Lane, Lane32, Lanes, Real, cross, dot};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;
use plasticity::Plasticity;

/// Largest number of integration points through the thickness.
pub const MAX_POINTS: usize = 10;

/// Elastic constants of a law, for the stable step, shear, hourglass and drilling forces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Elastic {
    /// Young's modulus E [force/length^2].
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Mass density [mass/length^3].
    pub density: f64,
}

impl Elastic {
    /// Returns the shear modulus G [force/length^2].
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.youngs_modulus / (1.0 + self.poisson)
    }

    /// Returns the first Lame constant lambda [force/length^2].
    pub fn lame(&self) -> f64 {
        self.youngs_modulus * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
    }

    /// Returns the bulk modulus K [force/length^2].
    pub fn bulk_modulus(&self) -> f64 {
        self.youngs_modulus / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// Returns the speed of the dilatational wave, `sqrt((lambda + 2 G)/rho)` [length/time].
    pub fn dilatational_wave_speed(&self) -> f64 {
        ((self.lame() + 2.0 * self.shear_modulus()) / self.density).sqrt()
    }

    /// Returns the speed of the longitudinal wave in a plate, `sqrt(E/(rho (1-nu^2)))`
    /// [length/time].
    pub fn plate_wave_speed(&self) -> f64 {
        (self.youngs_modulus / (self.density * (1.0 - self.poisson * self.poisson))).sqrt()
    }

    /// Returns the plane-stress stiffness [force/length^2]: of a direct strain for its own
    /// stress, of a direct strain for the other direct stress, and of engineering shear.
    pub fn plane_stress(&self) -> [f64; 3] {
        let c11 = self.youngs_modulus / (1.0 - self.poisson * self.poisson);
        [c11, self.poisson * c11, self.shear_modulus()]
    }

    /// Returns the factor k in `eps_z = k d(sig_x + sig_y) - (eps_x + eps_y)` [length^2/force].
    /// It holds if plastic flow is isochoric: the elastic volumetric strain is `(1-2nu)/E` times
    /// the sum of stresses.
    pub fn thinning(&self) -> f64 {
        (1.0 - 2.0 * self.poisson) / self.youngs_modulus
    }
}

/// The integration points of a group of shell elements, as a law sees them.
pub struct Points<'a, R> {
    /// For each point, stress xx, yy, xy [force/length^2], then the history columns of the law.
    /// Updated in place.
    pub state: &'a mut [R],
    /// For each point, the strain increment xx, yy, and twice xy.
    pub strain: &'a [[R; 3]],
    /// For each point, the increment of the strain through the thickness. Output.
    pub thickness_strain: &'a mut [R],
}

/// A law in plane stress.
///
/// The result of each lane must not depend on other lanes, bit for bit. With zero state and zero
/// strain increment the state must stay zero, whatever the time: unstrained elements skip the
/// law.
pub trait PlaneStress: Send + Sync {
    /// Returns the names of the history columns per point. All start at zero; the element stores
    /// its size in [`SIZE_COLUMN`], if there is one.
    fn history(&self) -> &[&'static str];

    /// Returns the elastic constants and the density.
    fn elastic(&self) -> Elastic;

    /// Returns the yield stress at zero plastic strain [force/length^2]; infinite if the law has
    /// no plastic flow.
    fn initial_yield_stress(&self) -> f64 {
        f64::INFINITY
    }

    /// Returns false if the law has no strain through the thickness.
    fn thins(&self) -> bool {
        true
    }

    /// Returns the number of failed points through the thickness from which on an element with so
    /// many points is removed.
    fn failed_points(&self, points: usize) -> usize {
        points
    }

    /// Returns the axes of the material of a point at the start, if it has any. Its columns
    /// [`DIRECTION_COLUMNS`] then hold the axis a in the axes of each element.
    fn orientation(&self, _point: usize) -> Option<Orientation> {
        None
    }

    /// Returns the transverse shear moduli G_ca and G_bc of a point [force/length^2], if they are
    /// not the shear modulus of [`Self::elastic`].
    fn transverse_shear(&self, _point: usize) -> Option<[f64; 2]> {
        None
    }

    /// Returns the constants for forces that only stabilise an element (hourglass and drilling).
    /// In laws with axes those of [`Self::elastic`] would be too stiff: they bound the step.
    fn stabilising(&self) -> Elastic {
        self.elastic()
    }

    /// Returns true if the stress follows from that before and the strain increment, so that an
    /// element can have a stress at the start.
    fn adds_stress(&self) -> bool {
        false
    }

    /// Returns the law itself if its yield stress depends on the strain rate.
    fn rate_dependent(&self) -> Option<&Plasticity> {
        None
    }

    /// Updates stress and history over a step `dt` [time] at all points of a group, at most
    /// [`MAX_POINTS`].
    fn update(&self, points: Points<'_, Lane>, dt: f64);

    /// Updates in single precision, by the same code.
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64);

    /// Updates one element, by the same code.
    fn update_one(&self, points: Points<'_, f64>, dt: f64);
}

/// The integration point of a group of solid elements, as a law sees it.
pub struct SolidPoint<'a, R> {
    /// Stress xx, yy, zz, xy, yz, zx [force/length^2], then the history columns of the law.
    /// Updated in place.
    pub state: &'a mut [R],
    /// Strain increment xx, yy, zz, and twice xy, yz, zx.
    pub strain: &'a [R; 6],
}

/// First column of a tensor `b = B - 1` of the left Cauchy-Green tensor B. Elements whose law has
/// it compute in double precision.
pub const STRETCH_COLUMN: &str = "B-1 xx";

/// Column of the logarithm of the volume in laws whose pressure depends on the volume alone.
/// Elements whose law has it compute in double precision.
pub const VOLUME_COLUMN: &str = "logarithm of volume";

/// Column of the internal energy per volume at the start of laws with an equation of state. The
/// element adds the work of its bulk viscosity.
pub const HEAT_COLUMN: &str = "eos energy";

/// First column of the strain of solids, as a symmetric tensor in the order of the stress, of laws
/// that keep it. The element rotates it with the stress.
pub const STRAIN_COLUMN: &str = "erosion strain xx";

/// First column of the axes of the material in laws with [`Solid::axes`]: the unit vectors a and b,
/// each less the one that it is in a material without a rotation, x and y. So zeros are the global
/// axes.
pub const AXES_COLUMN: &str = "axis a x - 1";

/// Columns of the axes of the material of a solid, the first of which is [`AXES_COLUMN`].
const AXES_COLUMNS: [&str; 6] =
    [AXES_COLUMN, "axis a y", "axis a z", "axis b x", "axis b y - 1", "axis b z"];

/// Returns the axes a, b, c of a solid with these columns of the axes, orthonormal whatever
/// rounding did to the columns.
#[inline(always)]
fn axes_of<R: Real>(columns: &[R]) -> [[R; 3]; 3] {
    let one = R::splat(1.0);
    let unit = |v: [R; 3]| {
        let size = dot(v, v).sqrt();
        v.map(|x| x / size)
    };
    let a = unit([columns[0] + one, columns[1], columns[2]]);
    let b = [columns[3], columns[4] + one, columns[5]];
    let along = dot(a, b);
    let b = unit(std::array::from_fn(|i| along.neg_mul_add(a[i], b[i])));
    [a, b, cross(a, b)]
}

/// Axes of the material of a solid at the start.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MaterialAxes {
    /// a from node 1 to node 2 of the element, b in the plane of the nodes 1, 2 and 4.
    Nodes,
    /// a along the first vector, b in the plane of both.
    Vectors([[f64; 3]; 2]),
}

/// A law in three dimensions.
///
/// The result of each lane must not depend on other lanes, bit for bit. With zero state and zero
/// strain increment the state must stay zero, whatever the time: unstrained elements skip the
/// law.
pub trait Solid: Send + Sync {
    /// Returns the names of the history columns. All start at zero; the element stores its size in
    /// [`SIZE_COLUMN`], if there is one. A column `stiffening` holds by
    /// how much the modulus of longitudinal waves exceeds that of the elastic constants, as a
    /// fraction of it: the element then takes a shorter step.
    fn history(&self) -> &[&'static str];

    /// Returns how many symmetric tensors, of six columns each in the order of the stress, begin
    /// the history. The element rotates them with the stress.
    fn tensors(&self) -> usize {
        0
    }

    /// Returns the axes of the material at the start, if it has any. The columns from
    /// [`AXES_COLUMN`] on hold them; the element stores them and rotates them with the stress.
    fn axes(&self) -> Option<MaterialAxes> {
        None
    }

    /// Returns the elastic constants and the density.
    fn elastic(&self) -> Elastic;

    /// Returns false if elements must not average the volume strain: averaging keeps the energy
    /// only with a pressure that is linear in the volume strain.
    fn averages_volume(&self) -> bool {
        true
    }

    /// Returns true if the stress follows from that before and the strain increment, so that an
    /// element can have a stress at the start.
    fn adds_stress(&self) -> bool {
        false
    }

    /// Returns the viscosity of a fluid [force*time/length^2]; `None` if the law is not one. A
    /// fluid has no pressure of its own: it needs an equation of state.
    fn viscosity(&self) -> Option<f64> {
        None
    }

    /// Updates stress and history over a step `dt` [time] of a group. Returns the norm of the
    /// deviator after plastic flow over that of the elastic trial (of the stress, in laws that
    /// limit all of it); one without plastic flow.
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane;

    /// Updates in single precision, by the same code.
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32;

    /// Updates one element, by the same code.
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64;
}

/// A scalar for which laws have an entry point, so that element kernels can be generic over it.
pub trait PointReal: Real {
    /// Calls the entry point of a plane-stress law for this scalar.
    fn update(law: &dyn PlaneStress, points: Points<'_, Self>, dt: f64);
    /// Calls the entry point of a solid law for this scalar.
    fn update_solid(law: &dyn Solid, point: SolidPoint<'_, Self>, dt: f64) -> Self;
}

/// Lanes for which laws have an entry point.
pub trait PointLanes<const W: usize>: Lanes<W> + PointReal {}

impl<L: Lanes<W> + PointReal, const W: usize> PointLanes<W> for L {}

impl PointReal for Lane {
    #[inline(always)]
    fn update(law: &dyn PlaneStress, points: Points<'_, Self>, dt: f64) {
        law.update(points, dt);
    }
    #[inline(always)]
    fn update_solid(law: &dyn Solid, point: SolidPoint<'_, Self>, dt: f64) -> Self {
        law.update(point, dt)
    }
}

impl PointReal for Lane32 {
    #[inline(always)]
    fn update(law: &dyn PlaneStress, points: Points<'_, Self>, dt: f64) {
        law.update_short(points, dt);
    }
    #[inline(always)]
    fn update_solid(law: &dyn Solid, point: SolidPoint<'_, Self>, dt: f64) -> Self {
        law.update_short(point, dt)
    }
}

impl PointReal for f64 {
    #[inline(always)]
    fn update(law: &dyn PlaneStress, points: Points<'_, Self>, dt: f64) {
        law.update_one(points, dt);
    }
    #[inline(always)]
    fn update_solid(law: &dyn Solid, point: SolidPoint<'_, Self>, dt: f64) -> Self {
        law.update_one(point, dt)
    }
}

/// A law in plane stress, or all problems of its material.
pub type LawResult = Result<Box<dyn PlaneStress>, Vec<Problem>>;
/// A law in three dimensions, or all problems of its material.
pub type SolidLawResult = Result<Box<dyn Solid>, Vec<Problem>>;

/// Elastic constants as parameters of a law.
pub const ELASTIC: &[ParameterRow] = &[YOUNGS_MODULUS, POISSON];

/// Young's modulus as a parameter.
pub const YOUNGS_MODULUS: ParameterRow = ParameterRow {
    key: "youngs_modulus",
    form: Form::Number,
    otherwise: DefaultValue::Needed,
    range: None,
    meaning: "Young's modulus [force/length^2].",
};

/// Poisson's ratio as a parameter.
pub const POISSON: ParameterRow = ParameterRow {
    key: "poisson",
    form: Form::Number,
    otherwise: DefaultValue::Needed,
    range: None,
    meaning: "Poisson's ratio; below 0.5 for solids.",
};

/// A row of [`LAWS`]. All functions read the same parameters. They return all problems, with
/// paths relative to the material.
pub struct Law {
    /// Name in jobs.
    pub name: &'static str,
    /// Meaning, in one line.
    pub meaning: &'static str,
    /// Its elastic constants: [`ELASTIC`] in most laws.
    pub constants: &'static [ParameterRow],
    /// Its other parameters.
    pub parameters: &'static [ParameterRow],
    /// Builds the law for shells; `None` if it is not for them.
    pub build: Option<fn(&Material) -> LawResult>,
    /// Builds the law for solids; `None` if it is not for them.
    pub solid: Option<fn(&Material) -> SolidLawResult>,
    /// Builds the law for cohesive elements; `None` if it is not for them.
    pub cohesive: Option<fn(&Material) -> CohesiveLawResult>,
}

impl Law {
    /// Returns the kind of elements that the law is for, if there is only one.
    pub fn only_for(&self) -> Option<&'static str> {
        match (self.build, self.solid, self.cohesive) {
            (Some(_), None, None) => Some("shells"),
            (None, Some(_), None) => Some("solids"),
            (None, None, Some(_)) => Some("cohesive elements"),
            _ => None,
        }
    }
}

impl Named for Law {
    fn name(&self) -> &'static str {
        self.name
    }
}

/// All laws.
pub static LAWS: Registry<Law> = Registry::new(&[
    elastic::LAW,
    j2::LAW,
    johnson_cook::LAW,
    viscoelastic::LAW,
    prony::LAW,
    rubber::mooney_rivlin::LAW,
    rubber::polynomial::LAW,
    rubber::ogden::LAW,
    rubber::blatz_ko::LAW,
    rubber::tabulated::LAW,
    fluid::LAW,
    low_density_foam::LAW,
    crushable_foam::LAW,
    viscous_foam::LAW,
    cscm::LAW,
    pressure_dependent::ceramic::LAW,
    pressure_dependent::concrete::LAW,
    pressure_dependent::karagozian_case::LAW,
    pressure_dependent::soil::LAW,
    fabric::LAW,
    orthotropic::LAW,
    barlat::LAW,
    gurson::LAW,
    polymer::LAW,
    honeycomb::LAW,
    cohesive::mixed_mode::LAW,
    cohesive::elastic::LAW,
    cohesive::tvergaard_hutchinson::LAW,
    cohesive::elastoplastic::LAW,
]);

/// Builds the law of a shell's material. Returns all problems of the material if there are any,
/// with paths relative to it.
pub fn build(material: &Material) -> LawResult {
    let row = row_of(material)?;
    let Some(build) = row.build else {
        return Err(vec![not_for(material, row, "shells", |law| law.build.is_some())]);
    };
    let (rest, limits) = erosion::split(material)?;
    let (rest, equation) = equation_of_state::split(&rest)?;
    if equation.is_some() {
        let message = format!("material '{}': an equation of state is for solids", material.name);
        let help = "use a material without eos_... in parts of shells and beams";
        return Err(vec![Problem::error("law", message, help)]);
    }
    let (rest, onset) = diem::split(&rest)?;
    let (rest, damage) = gissmo::split(&rest)?;
    let law = gissmo::shell(material, build(&rest)?, damage)?;
    let law = diem::shell(material, law, onset)?;
    erosion::shell(material, law, limits)
}

/// Columns of the damage of a law: 0 in intact material, 1 where it fails.
pub const DAMAGE_COLUMNS: [&str; 2] = ["damage", diem::DAMAGE_COLUMN];

/// Returns true if a material has a damage that output shows.
pub fn has_damage(material: &Material) -> bool {
    let shown = |history: &[&str]| history.iter().any(|name| DAMAGE_COLUMNS.contains(name));
    build_solid(material).is_ok_and(|law| shown(law.history()))
        || build(material).is_ok_and(|law| shown(law.history()))
}

/// Parameters that describe a sheet or its size: beams and trusses cannot have them.
pub const OF_SHEETS: [&str; 6] = [
    j2::LANKFORD,
    "erosion_thinning",
    gissmo::SIZES,
    "diem_ductile",
    "diem_shear",
    "diem_principal",
];

/// Returns the elastic constants of a material for any element, `None` if it is one of cohesive
/// elements; or all its problems, with paths relative to it.
pub fn elastic_of(material: &Material) -> Result<Option<Elastic>, Vec<Problem>> {
    let row = row_of(material)?;
    if let Some(build) = row.cohesive {
        return build(material).map(|_| None);
    }
    let (rest, _) = erosion::split(material)?;
    let (rest, equation) = equation_of_state::split(&rest)?;
    let (rest, _) = diem::split(&rest)?;
    let (rest, _) = gissmo::split(&rest)?;
    match (row.build.filter(|_| equation.is_none()), row.solid) {
        (Some(build), _) => build(&rest).map(|law| Some(law.elastic())),
        (None, Some(solid)) => {
            let law = equation_of_state::solid(material, solid(&rest)?, equation)?;
            Ok(Some(law.elastic()))
        }
        (None, None) => Err(vec![not_for(material, row, "solids", |law| law.solid.is_some())]),
    }
}

/// Returns the modulus [force/length^2] and the wave speed [length/time] that contact uses: Young's
/// modulus and the speed in plates, and of fluids the bulk modulus and its speed. `None` if the
/// material cannot be built, or is one of cohesive elements.
pub fn contact_constants(material: &Material) -> Option<(f64, f64)> {
    let elastic = elastic_of(material).ok().flatten()?;
    let fluid = || build_solid(material).is_ok_and(|law| law.viscosity().is_some());
    let sheets = row_of(material).is_ok_and(|row| row.build.is_some());
    Some(match !sheets && fluid() {
        true => (elastic.bulk_modulus(), elastic.dilatational_wave_speed()),
        false => (elastic.youngs_modulus, elastic.plate_wave_speed()),
    })
}

/// Builds the law of a solid's material. Returns all problems of the material if there are any,
/// with paths relative to it.
pub fn build_solid(material: &Material) -> SolidLawResult {
    let row = row_of(material)?;
    let Some(solid) = row.solid else {
        return Err(vec![not_for(material, row, "solids", |law| law.solid.is_some())]);
    };
    let (rest, limits) = erosion::split(material)?;
    let (rest, equation) = equation_of_state::split(&rest)?;
    let (rest, onset) = diem::split(&rest)?;
    let (rest, damage) = gissmo::split(&rest)?;
    let law = equation_of_state::solid(material, solid(&rest)?, equation)?;
    let law = gissmo::solid(material, law, damage)?;
    let law = diem::solid(material, law, onset)?;
    erosion::solid(material, law, limits)
}

/// Builds the law of a cohesive element's material. Returns all problems of the material if there
/// are any, with paths relative to it.
pub fn build_cohesive(material: &Material) -> CohesiveLawResult {
    let row = row_of(material)?;
    match row.cohesive {
        Some(build) => build(material),
        None => {
            let fits = |law: &Law| law.cohesive.is_some();
            Err(vec![not_for(material, row, "cohesive elements", fits)])
        }
    }
}

/// Returns the problem of a law that is not for these elements. `fits` selects the laws that
/// could replace it.
fn not_for(material: &Material, row: &Law, elements: &str, fits: fn(&Law) -> bool) -> Problem {
    let Material { name, law, .. } = material;
    let message = match row.only_for() {
        Some(only) => format!("material '{name}': the law '{law}' is for {only} only"),
        None => format!("material '{name}': the law '{law}' is not for {elements}"),
    };
    let others = LAWS.iter().filter(|law| fits(law)).map(|law| law.name);
    let help = format!("use one of {}", others.collect::<Vec<_>>().join(", "));
    Problem::error("law", message, help)
}

fn row_of(material: &Material) -> Result<&'static Law, Vec<Problem>> {
    LAWS.iter().find(|law| law.name == material.law).ok_or_else(|| {
        let names: Vec<_> = LAWS.iter().map(|law| law.name).collect();
        let what = format!("material '{}': there is no law '{}'", material.name, material.law);
        vec![unknown_name("law", what, &material.law, &names)]
    })
}

#[cfg(test)]
#[path = "table_tests.rs"]
mod table_tests;
#[cfg(test)]
mod testing;

/// Constants of the law that checks a part when its own law cannot be built.
const PLACEHOLDER: Elastic = Elastic { youngs_modulus: 1.0, poisson: 0.0, density: 1.0 };

/// Returns a law that checks a part of shells when its own law cannot be built.
pub(crate) fn placeholder_law() -> Box<dyn PlaneStress> {
    elastic::law(PLACEHOLDER)
}

/// Returns a law that checks a part of cohesive elements when its own law cannot be built.
pub(crate) fn cohesive_placeholder_law() -> Box<dyn Cohesive> {
    cohesive::elastic::law(1.0)
}

/// Returns a law that checks a part of solids when its own law cannot be built.
pub(crate) fn solid_placeholder_law() -> Box<dyn Solid> {
    elastic::solid_law(PLACEHOLDER)
}
