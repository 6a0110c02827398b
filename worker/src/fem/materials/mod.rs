//! Material laws. One file per law, one row in [`LAWS`].
//!
//! A law sees integration points only: stress and history in, strain increments in, stress and
//! history out, all in axes that turn with the material. Rotation, thickness and integration are
//! the element's business.

mod elastic;
mod j2;
mod johnson_cook;
mod parameters;
mod plasticity;

pub(crate) use parameters::unknown_name;

use crate::math::lanes::{Lane, Lane32, Real};
use crumple_proto::partition::Material;
use crumple_proto::problem::Problem;
use plasticity::Plasticity;

/// Integration points through the thickness, at most.
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
    /// Shear modulus G [force/length^2].
    pub fn shear_modulus(&self) -> f64 {
        0.5 * self.youngs_modulus / (1.0 + self.poisson)
    }

    /// First Lame constant lambda [force/length^2].
    pub fn lame(&self) -> f64 {
        self.youngs_modulus * self.poisson / ((1.0 + self.poisson) * (1.0 - 2.0 * self.poisson))
    }

    /// Bulk modulus K [force/length^2].
    pub fn bulk_modulus(&self) -> f64 {
        self.youngs_modulus / (3.0 * (1.0 - 2.0 * self.poisson))
    }

    /// Speed of the dilatational wave, `sqrt((lambda + 2 G)/rho)` [length/time].
    pub fn dilatational_wave_speed(&self) -> f64 {
        ((self.lame() + 2.0 * self.shear_modulus()) / self.density).sqrt()
    }

    /// Speed of the longitudinal wave in a plate, `sqrt(E/(rho (1-nu^2)))` [length/time].
    pub fn plate_wave_speed(&self) -> f64 {
        (self.youngs_modulus / (self.density * (1.0 - self.poisson * self.poisson))).sqrt()
    }

    /// Plane-stress stiffness: of a direct strain on its own stress, on the other, of engineering
    /// shear [force/length^2].
    pub fn plane_stress(&self) -> [f64; 3] {
        let c11 = self.youngs_modulus / (1.0 - self.poisson * self.poisson);
        [c11, self.poisson * c11, self.shear_modulus()]
    }

    /// Factor k in `eps_z = k d(sig_x + sig_y) - (eps_x + eps_y)`, which holds wherever plastic
    /// flow keeps volume: elastic bulk strain is `(1-2nu)/E` times the sum of stresses
    /// [length^2/force].
    pub fn thinning(&self) -> f64 {
        (1.0 - 2.0 * self.poisson) / self.youngs_modulus
    }
}

/// The integration points of a group of elements, as a law sees them.
pub struct Points<'a, R> {
    /// For each point stress xx, yy, xy [force/length^2], then the law's history columns. Updated
    /// in place.
    pub state: &'a mut [R],
    /// For each point the strain increment xx, yy, and twice xy.
    pub strain: &'a [[R; 3]],
    /// For each point the increment of strain through the thickness. Written.
    pub thickness_strain: &'a mut [R],
}

/// A law in plane stress. Must give each lane what it would give it alone, bit for bit. Where state
/// and strain are nought it must leave the state so, whatever the time: elements that nothing has
/// strained are not asked.
pub trait PlaneStress: Send + Sync {
    /// History columns per point, by name. All start at nought.
    fn history(&self) -> &'static [&'static str];

    /// Elastic constants and density.
    fn elastic(&self) -> Elastic;

    /// Yield stress at no plastic strain [force/length^2]; infinite where the law never flows.
    fn initial_yield_stress(&self) -> f64 {
        f64::INFINITY
    }

    /// The law itself if rates raise its yield stress.
    fn rate_dependent(&self) -> Option<&Plasticity> {
        None
    }

    /// Stress and history over a step `dt` [time] at all points of a group, at most [`MAX_POINTS`]
    /// of them.
    fn update(&self, points: Points<'_, Lane>, dt: f64);

    /// The same in single precision, by the same code.
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64);

    /// The same for one element, by the same code.
    fn update_one(&self, points: Points<'_, f64>, dt: f64);
}

/// The integration point of a group of solid elements, as a law sees it.
pub struct SolidPoint<'a, R> {
    /// Stress xx, yy, zz, xy, yz, zx [force/length^2], then the law's history columns. Updated in
    /// place.
    pub state: &'a mut [R],
    /// The strain increment xx, yy, zz, and twice xy, yz, zx.
    pub strain: &'a [R; 6],
}

/// A law in three dimensions. Must give each lane what it would give it alone, bit for bit. Where
/// state and strain are nought it must leave the state so, whatever the time: elements that nothing
/// has strained are not asked.
pub trait Solid: Send + Sync {
    /// History columns, by name. All start at nought.
    fn history(&self) -> &'static [&'static str];

    /// Elastic constants and density.
    fn elastic(&self) -> Elastic;

    /// Stress and history over a step `dt` [time] of a group. Returns what plastic flow left of the
    /// deviator of the elastic trial, by its norm: one where nothing flowed.
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane;

    /// The same in single precision, by the same code.
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32;

    /// The same for one element, by the same code.
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64;
}

/// A scalar that laws have an entry for, so that element kernels can be generic over it.
pub trait PointReal: Real {
    /// Calls the entry for this scalar.
    fn update(law: &dyn PlaneStress, points: Points<'_, Self>, dt: f64);
    /// Calls the entry of a solid's law for this scalar.
    fn update_solid(law: &dyn Solid, point: SolidPoint<'_, Self>, dt: f64) -> Self;
}

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

/// A law in plane stress, or everything that is wrong with its material.
pub type BuildResult = Result<Box<dyn PlaneStress>, Vec<Problem>>;
/// A law in three dimensions, or everything that is wrong with its material.
pub type BuildSolidResult = Result<Box<dyn Solid>, Vec<Problem>>;

/// A parameter of a law, as the reference of jobs shows it.
pub struct ParameterRow {
    /// Key in the material.
    pub key: &'static str,
    /// What is written: a number, or a list such as `[C, p]`.
    pub form: &'static str,
    /// What counts if it is left out.
    pub otherwise: DefaultValue,
    /// What it is, with its dimension in brackets.
    pub meaning: &'static str,
}

/// What counts when a parameter is left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DefaultValue {
    /// It cannot be.
    Needed,
    /// What it describes is not there.
    Absent,
    /// This number.
    Number(f64),
    /// It depends on others: in words.
    Depends(&'static str),
}

/// What every law has.
pub const ELASTIC: &[ParameterRow] = &[
    ParameterRow {
        key: "youngs_modulus",
        form: "number",
        otherwise: DefaultValue::Needed,
        meaning: "Young's modulus [force/length^2].",
    },
    ParameterRow {
        key: "poisson",
        form: "number",
        otherwise: DefaultValue::Needed,
        meaning: "Poisson's ratio; of solids below 0.5.",
    },
];

/// A row of [`LAWS`]. Both functions read the same parameters; they return everything that is wrong
/// with them, with paths relative to the material.
pub struct Law {
    /// Name in jobs.
    pub name: &'static str,
    /// What it is, in a line.
    pub meaning: &'static str,
    /// Its parameters beside [`ELASTIC`].
    pub parameters: &'static [ParameterRow],
    /// For shells.
    pub build: fn(&Material) -> BuildResult,
    /// For solids.
    pub solid: fn(&Material) -> BuildSolidResult,
}

/// Every law.
pub const LAWS: &[Law] = &[elastic::LAW, j2::LAW, johnson_cook::LAW];

/// The law of a shell's material, or everything that is wrong with the material, with paths
/// relative to it.
pub fn build(material: &Material) -> BuildResult {
    (row_of(material)?.build)(material)
}

/// The law of a solid's material, or everything that is wrong with the material, with paths
/// relative to it.
pub fn build_solid(material: &Material) -> BuildSolidResult {
    (row_of(material)?.solid)(material)
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

/// Constants to check a part with when its law cannot be built.
const PLACEHOLDER: Elastic = Elastic { youngs_modulus: 1.0, poisson: 0.0, density: 1.0 };

/// A law to check a part of shells with when its own cannot be built.
pub(crate) fn placeholder_law() -> Box<dyn PlaneStress> {
    elastic::law(PLACEHOLDER)
}

/// The same for a part of solids.
pub(crate) fn solid_placeholder_law() -> Box<dyn Solid> {
    elastic::solid_law(PLACEHOLDER)
}
