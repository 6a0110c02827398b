//! Element formulations. Each formulation has one file and one row in [`ELEMENTS`].
//!
//! Elements are computed in groups: lane l of every vector belongs to element l of the group.

mod beam;
mod belt;
mod belytschko_tsay;
mod bounds;
mod c0_triangle;
mod cohesive;
mod discrete_beam;
mod fibre;
mod fully_integrated_quad;
#[cfg(test)]
mod gissmo_tests;
mod hexahedron;
mod initial;
#[cfg(test)]
mod inverted_tests;
mod kinematics;
#[cfg(test)]
mod law_motion_tests;
#[cfg(test)]
mod motion_tests;
#[cfg(test)]
mod offset_tests;
mod parameters;
pub mod particle;
mod pass;
#[cfg(test)]
mod plate_tests;
#[cfg(test)]
mod precision_tests;
mod quad;
mod quadratic_tetrahedron;
mod section;
mod shell;
#[cfg(test)]
mod shell_benchmarks;
mod sides;
mod solid;
#[cfg(test)]
pub(crate) mod solid_testing;
#[cfg(test)]
mod solid_tests;
mod spring;
mod stabilised_quad;
#[cfg(test)]
mod statics;
#[cfg(test)]
mod stretched_tests;
#[cfg(test)]
pub(crate) mod testing;
mod tetrahedron;
mod thick_shell;
pub mod thread_shell;
mod truss;
#[cfg(test)]
mod unstrained_tests;
mod wedge;

pub use belt::is_steeper;
pub use cohesive::COHESIVE;
pub use initial::TakenAtStart;
pub use parameters::HourglassForm;
pub use pass::{ElementNodalForces, ElementPass, GroupNodes, PassTotals, energy_places};
pub use section::LARGEST_OFFSET;
pub use thick_shell::THICK_SHELL;

use crate::columns::ElementState;
use crate::materials::{self, Cohesive, LayerPoint, PlaneStress, Solid, unknown_name};
use crate::parameter::{ParameterRow, Values};
use crumple_math::lanes::Real;
use crumple_proto::initial::InitialPoint;
use crumple_proto::job::{LayerInput, Part};
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::partition::{Material, Settings};
use crumple_proto::problem::Problem;
use particle::Fluid;
use pass::{GroupCorners, ShellGroups, SingleElement, SolidGroups, Totals};

/// Output fields of an element.
#[derive(Clone, Copy, Debug, Default)]
pub struct ElementFields {
    /// Largest effective plastic strain over the thickness.
    pub plastic_strain: f64,
    /// Largest damage of the law over the thickness, 0 if the law has none.
    pub damage: f64,
    /// Global stress at mid-surface: xx, yy, zz, xy, yz, zx [force/length^2].
    pub stress: [f64; 6],
    /// Largest von Mises stress over the thickness [force/length^2].
    pub von_mises: f64,
    /// Current thickness [length], zero for solids.
    pub thickness: f64,
    /// True if the law has failed at every point: the element carries no force any more.
    pub failed: bool,
}

/// Output fields of a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PointFields {
    /// Global stress: xx, yy, zz, xy, yz, zx [force/length^2].
    pub stress: [f64; 6],
    /// Effective plastic strain.
    pub plastic_strain: f64,
}

impl ElementFields {
    /// Returns the fields of a solid with several points: the mean of the stress, the largest of
    /// the other values. It has failed if all points have.
    fn of_points<const N: usize>(points: &[Self; N]) -> Self {
        let largest =
            |of: fn(&Self) -> f64| points.iter().map(of).fold(0.0, |m: f64, value| m.max(value));
        Self {
            plastic_strain: largest(|p| p.plastic_strain),
            damage: largest(|p| p.damage),
            stress: std::array::from_fn(|c| {
                points.iter().map(|p| p.stress[c]).sum::<f64>() / N as f64
            }),
            von_mises: largest(|p| p.von_mises),
            thickness: 0.0,
            failed: points.iter().all(|p| p.failed),
        }
    }
}

/// Elements of one part and one shape. An implementation holds parameters only; the state is in the
/// history columns.
pub trait Element: Send + Sync {
    /// History columns per element.
    fn columns(&self) -> usize;

    /// Returns the names of the history columns, in their order. A checkpoint has them: a program
    /// with others refuses it.
    fn names(&self) -> Vec<String>;

    /// Returns true if the kernels exist in single and double precision; otherwise they are in
    /// double.
    fn any_precision(&self) -> bool {
        false
    }

    /// Stores an offset for each element, instead of one for the whole part. Shells only.
    fn store_offsets(&mut self) {}

    /// Sets the nonzero entries in the history of a new element. `own` are the values of a shell
    /// that replace those of its part, here and below.
    fn start(&self, _history: &mut [f64], _own: OwnSection) {}

    /// Stores in the history of a new element the shape that determines its mass. `x` are the
    /// coordinates of its slots at the start.
    fn measure(&self, _history: &mut [f64], _x: &[[f64; 3]], _own: OwnSection) {}

    /// Returns the history of the quarter of an element at one of its corners, when the element is
    /// divided into four; `None` if elements of this kind cannot be divided. `history` is that of
    /// the element, `x` are the coordinates of the slots of the quarter at the start. Forces that
    /// only stabilise the element begin at zero, and its energies are not part of it.
    fn quarter(
        &self,
        _history: &[f64],
        _corner: usize,
        _x: &[[f64; 3]],
        _own: OwnSection,
    ) -> Option<Vec<f64>> {
        None
    }

    /// Returns the effective plastic strain of bending at the outer fibres of a shell; 0 for all
    /// other elements.
    fn plastic_bending_strain(&self, _history: ElementState<'_>) -> f64 {
        0.0
    }

    /// Orients a new beam with this history: its second axis points towards the vector `towards`.
    fn orient(&self, _history: &mut [f64], _towards: [f64; 3]) {}

    /// Returns what its law takes of a stress and a plastic strain at the start.
    fn taken_at_start(&self) -> TakenAtStart {
        TakenAtStart::default()
    }

    /// Sets stress and plastic strain in the history of a new element, if it takes them, after
    /// [`Self::measure`]. `points` are those of the element, at least one, sorted.
    fn set_initial(&self, _history: &mut [f64], _x: &[[f64; 3]], _points: &[InitialPoint]) {}

    /// Returns the mass [mass] and the rotational inertia [mass length^2] that one element
    /// contributes to each of its corners, on average ([`Shape::mass_share`]). `x` are the
    /// coordinates of its slots.
    fn corner_mass(&self, x: &[[f64; 3]], own: OwnSection) -> (f64, f64);

    /// Computes internal forces at the coordinates x(t), after it updates the stress from t - dt to
    /// t with the mid-step velocities.
    fn forces(&self, pass: ElementPass<'_>) -> PassTotals;

    /// Returns true if an element with this history has no force and remains without stress as long
    /// as its nodes have one velocity and do not rotate (at rest, or in uniform motion). Elements
    /// for which this is never true are always computed.
    fn is_unstrained(&self, _history: ElementState<'_>) -> bool {
        false
    }

    /// Returns the stable step of one element at the density of its material, before the safety
    /// factor [time]. It is NaN if the element is inverted or not finite. `x` are the coordinates
    /// of its slots.
    fn stable_dt(&self, x: &[[f64; 3]], own: OwnSection) -> f64;

    /// Returns the stable step of an element with this history, which keeps the mass of the start
    /// [time].
    fn stable_dt_now(&self, _history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        self.stable_dt(x, OwnSection::default())
    }

    /// Returns the fraction of its stable step for which an element is stable alone, without
    /// neighbours of its kind.
    fn single_element_step(&self) -> f64 {
        1.0
    }

    /// Returns true if dampers may determine its stable step, which is then proportional to its
    /// mass instead of the root of it.
    fn has_dampers(&self) -> bool {
        false
    }

    /// Returns the stiffness and damping of a spring or damper. It has no mass; the masses of its
    /// nodes determine its stable step.
    fn discrete(&self) -> Option<Discrete> {
        None
    }

    /// Returns the numbers of the fluid of a particle. Its density and force are sums over
    /// neighbours, which are in its columns before each pass.
    fn fluid(&self) -> Option<&Fluid> {
        None
    }

    /// Returns the history column that has to contain the volume strain increment of the nodes
    /// before each pass, if the element averages it (see [`tetrahedron`]).
    fn averaged_volume(&self) -> Option<usize> {
        None
    }

    /// Returns the first of three history columns that have to contain the direction of the element
    /// before each pass, if it is that from one node to another (see [`spring`]).
    fn followed_direction(&self) -> Option<usize> {
        None
    }

    /// Returns the volume in the middle of a step [length^3] and its change, at these coordinates
    /// of the corners and with these velocities, at the end of the step; both times the share of
    /// its volume strain that the element averages.
    ///
    /// # Panics
    /// The element does not average its volume strain.
    fn volume_change(&self, _corners: [&[[f64; 3]]; 2], _dt: f64) -> [f64; 2] {
        unreachable!("only elements with `averaged_volume` are asked")
    }

    /// Returns true if the law of the element with this history has failed at every point, or if
    /// the element was inverted and its part deletes such elements. A failed element has no force,
    /// does not limit the step and is never reported as trouble.
    fn failed(&self, history: ElementState<'_>) -> bool;

    /// Returns true if the element has failed because it was inverted, or its step too short.
    fn is_deleted(&self, _history: ElementState<'_>) -> bool {
        false
    }

    /// Returns true if the element can fail.
    fn can_fail(&self) -> bool;

    /// Returns the column of the mark of failure, in elements that can fail with others.
    fn failure_column(&self) -> Option<usize> {
        None
    }

    /// Returns the fields of the element with this history at the slot coordinates `x`.
    fn fields(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> ElementFields;

    /// Returns the points through the thickness, from the inner surface to the outer one; of an
    /// element without a thickness its fields.
    fn points(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> Vec<PointFields> {
        let ElementFields { plastic_strain, stress, .. } = self.fields(history, x);
        vec![PointFields { stress, plastic_strain }]
    }
}

/// A spring or damper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Discrete {
    /// Largest change of its force with its elongation [force/length].
    pub stiffness: f64,
    /// Largest change of its force with the rate of its elongation [force time/length].
    pub damping: f64,
    /// True if the force acts along the line between the nodes.
    pub along_line: bool,
    /// True for a moment and a rotation instead of the force and the elongation: softness is then
    /// the change of the rotational velocity per unit impulse [1/(mass length^2)].
    pub rotational: bool,
}

impl Discrete {
    /// Returns the stable step between nodes whose inverse masses have the sum `softness` [1/mass],
    /// before the safety factor [time].
    pub fn stable_dt(&self, softness: f64) -> f64 {
        let (k, c) = (self.stiffness * softness, self.damping * softness);
        4.0 / (c + (c * c + 4.0 * k).sqrt())
    }

    /// Returns the fraction of the masses at its ends for which the stable step is `dt`; `softness`
    /// is as in [`Self::stable_dt`].
    pub fn require(&self, softness: f64, dt: f64) -> f64 {
        softness * dt * (0.25 * self.stiffness * dt + 0.5 * self.damping)
    }
}

/// Returns the four slots of a shell.
///
/// # Panics
/// If there are fewer than four slots. Callers pass all slots of a shell.
fn four(x: &[[f64; 3]]) -> &[[f64; 3]; 4] {
    x.first_chunk().expect("a shell has four slots")
}

/// An element, or all problems of its part.
pub type ElementResult = Result<Box<dyn Element>, Vec<Problem>>;

/// A row of [`ELEMENTS`].
pub struct ElementEntry {
    /// Name in jobs.
    pub name: &'static str,
    /// Description in one line.
    pub meaning: &'static str,
    /// Shape that the formulation is for.
    pub shape: Shape,
    /// Its keys in `[[part]]`, besides those of all parts. Each table may be that of another
    /// formulation too.
    pub parameters: [&'static [ParameterRow]; 2],
    /// Returns its keys that have no effect with these values, each with the reason.
    pub idle: fn(&Values<'_>) -> &'static [(&'static str, &'static str)],
    /// Checks the other keys of the part that the formulation uses; paths of problems are relative
    /// to the part.
    pub build: Constructor,
}

impl ElementEntry {
    /// Returns all its keys.
    pub fn keys(&self) -> impl Iterator<Item = &'static ParameterRow> + use<> {
        self.parameters.into_iter().flatten()
    }

    /// Returns its values in a part.
    pub fn values<'a>(&self, part: &'a Part) -> Values<'a> {
        Values::new(self.parameters, &part.parameters)
    }
}

/// Constructor of a formulation, with a law for its state of stress.
#[derive(Clone, Copy)]
pub enum Constructor {
    /// With a law in plane stress.
    Shell(fn(&Part, &Values<'_>, Box<dyn PlaneStress>) -> ElementResult),
    /// With a law in three dimensions.
    Solid(fn(&Part, &Values<'_>, Box<dyn Solid>) -> ElementResult),
    /// With a law of tractions over the opening.
    Cohesive(fn(&Part, &Values<'_>, Box<dyn Cohesive>) -> ElementResult),
    /// Without a law.
    Discrete(fn(&Part) -> ElementResult),
}

/// All formulations. The first one of each shape is the default of parts that name none. For quads
/// the default is `stabilised_quad`: in folds it is nearer to converged crush forces than
/// `belytschko_tsay` on every mesh, at the same cost of the run (`cases/studies/README.md`, crush).
pub const ELEMENTS: &[ElementEntry] = &[
    stabilised_quad::ROW,
    belytschko_tsay::ROW,
    fully_integrated_quad::ROW,
    c0_triangle::ROW,
    hexahedron::ROW,
    thick_shell::ROW,
    tetrahedron::ROW,
    wedge::ROW,
    quadratic_tetrahedron::ROW,
    cohesive::ROW,
    beam::ROW,
    truss::ROW,
    particle::ROW,
    spring::ROW,
    discrete_beam::ROW,
    belt::ROW,
];

/// Builds the element for a part's elements of one shape, or returns all problems of the part and
/// its material. Paths are `part.INDEX.key` and `material.INDEX.key`, with indices into `settings`.
///
/// Quads and hexahedra use the formulation of the part; each other shape has only one.
pub fn build_block(settings: &Settings, part_index: usize, shape: Shape) -> ElementResult {
    let part = &settings.parts[part_index];
    let mut problems = Vec::new();
    let mut note = |prefix: String, found: Vec<Problem>| {
        problems.extend(
            found
                .into_iter()
                .map(|problem| Problem { path: format!("{prefix}.{}", problem.path), ..problem }),
        );
    };

    let materials = &settings.materials;
    let index = materials.iter().position(|material| material.name == part.material);
    let row = row_for(part, shape);
    let lawless = matches!(row.as_ref().map(|row| row.build), Ok(Constructor::Discrete(_)));
    if index.is_none() && !lawless {
        let names: Vec<_> = materials.iter().map(|material| material.name.as_str()).collect();
        let what = format!("part {}: there is no material '{}'", part.label(), part.material);
        note(
            format!("part.{part_index}"),
            vec![unknown_name("material", what, &part.material, &names)],
        );
    }
    let of_shells = [("layer", part.layer.is_empty()), ("angles", part.angles.is_empty())];
    let is_shell =
        matches!(shape, Shape::Quad4 | Shape::Tri3) || part.element.as_deref() == Some(THICK_SHELL);
    for (key, _) in of_shells.into_iter().filter(|(_, empty)| !empty && !is_shell) {
        let message =
            format!("part {}: `{key}` is for shells, and it has other elements", part.label());
        let help = format!("remove `{key}`, or move the other elements to another part");
        note(format!("part.{part_index}"), vec![Problem::error(key, message, help)]);
    }
    for (k, layer) in part.layer.iter().enumerate().filter(|(_, layer)| {
        !layer.material.is_empty() && materials.iter().all(|m| m.name != layer.material)
    }) {
        let names: Vec<_> = materials.iter().map(|material| material.name.as_str()).collect();
        let label = part.label();
        let what =
            format!("part {label}, layer {}: there is no material '{}'", k + 1, layer.material);
        let path = format!("layer.{k}.material");
        note(
            format!("part.{part_index}"),
            vec![unknown_name(&path, what, &layer.material, &names)],
        );
    }
    // The part is checked even if its material is wrong, so that one check reports all problems.
    let mut stand_in = index.is_none() && !lawless;
    let mut law_problems = |index: usize, found: Vec<Problem>| {
        stand_in = true;
        note(format!("material.{index}"), found);
    };
    let material = index.map(|index| (index, &materials[index]));
    if let Some((index, material)) =
        material.filter(|_| matches!(shape, Shape::Beam2 | Shape::Truss2))
    {
        let given = |key: &&str| material.parameters.contains_key(*key);
        for key in materials::OF_SHEETS.into_iter().filter(given) {
            let message = format!(
                "material '{}': {key} is not for beams and trusses, which part {} has",
                material.name,
                part.label()
            );
            let found = vec![Problem::error(key, message, "give them a material without it")];
            law_problems(index, found);
        }
    }
    let built = match row {
        Ok(row) => with_values(row, part, |values| match row.build {
            Constructor::Discrete(build) => build(part),
            Constructor::Shell(build) => {
                let law_of = |(index, material): (usize, &Material)| {
                    materials::build(material).map_err(|found| law_problems(index, found)).ok()
                };
                let law = match &part.layer[..] {
                    [] => material.and_then(law_of).map(|law| with_angles(part, values, law)),
                    layers => layered_law(part, layers, materials, law_of),
                };
                let built = build(part, values, law.unwrap_or_else(materials::placeholder_law));
                match (built, section::fault_of_angles(part, values)) {
                    (built, None) => built,
                    (Ok(_), Some(fault)) => Err(vec![fault]),
                    (Err(found), Some(fault)) => Err([found, vec![fault]].concat()),
                }
            }
            Constructor::Solid(build) => {
                let law = material.and_then(|(index, m)| {
                    materials::build_solid(m).map_err(|found| law_problems(index, found)).ok()
                });
                let law = law.unwrap_or_else(materials::solid_placeholder_law);
                if let Some((index, material)) = material.filter(|_| shape != Shape::Hex8) {
                    let found = materials::problems_of_welds(material);
                    if !found.is_empty() {
                        law_problems(index, found);
                    }
                }
                solid::with_interior(part, values, law).and_then(|law| build(part, values, law))
            }
            Constructor::Cohesive(build) => {
                let law = material.and_then(|(index, m)| {
                    materials::build_cohesive(m).map_err(|found| law_problems(index, found)).ok()
                });
                build(part, values, law.unwrap_or_else(materials::cohesive_placeholder_law))
            }
        }),
        Err(problem) => {
            if let Some((index, material)) = material
                && let Err(found) = materials::elastic_of(material)
            {
                law_problems(index, found);
            }
            Err(vec![problem])
        }
    };
    match built.map_err(|found| note(format!("part.{part_index}"), found)) {
        Ok(mut element) if !stand_in && problems.is_empty() => {
            if settings.with_own_offsets.contains(&(part_index as u32)) {
                element.store_offsets();
            }
            Ok(element)
        }
        _ => Err(problems),
    }
}

/// Returns the law of a part whose points have these angles.
fn with_angles(
    part: &Part,
    values: &Values<'_>,
    law: Box<dyn PlaneStress>,
) -> Box<dyn PlaneStress> {
    // Others are reported by the section.
    if part.angles.is_empty() || section::fault_of_angles(part, values).is_some() {
        return law;
    }
    let (_, weights) = section::gauss_legendre(part.angles.len());
    let points = part.angles.iter().zip(weights).map(|(angle, weight)| LayerPoint {
        law: 0,
        weight,
        angle: angle.to_radians(),
    });
    materials::layered(vec![law], points.collect())
}

/// Returns the law of a part with layers; `None` if that of a layer cannot be built. `law_of`
/// builds the law of a material.
fn layered_law<'a>(
    part: &Part,
    layers: &[LayerInput],
    materials: &'a [Material],
    mut law_of: impl FnMut((usize, &'a Material)) -> Option<Box<dyn PlaneStress>>,
) -> Option<Box<dyn PlaneStress>> {
    let name_of = |layer: &LayerInput| match layer.material.as_str() {
        "" => part.material.clone(),
        own => own.to_string(),
    };
    let mut names: Vec<String> = layers.iter().map(name_of).collect();
    names.sort_unstable();
    names.dedup();
    let laws: Vec<Option<_>> = names
        .iter()
        .map(|name| law_of(materials.iter().enumerate().find(|(_, m)| m.name == *name)?))
        .collect();
    let laws = laws.into_iter().collect::<Option<Vec<_>>>()?;
    let mut points = Vec::new();
    for layer in layers {
        let law = names.binary_search(&name_of(layer)).expect("a law of each layer");
        let (_, weights) = section::gauss_legendre(layer.points);
        points.extend(weights[..layer.points].iter().map(|weight| LayerPoint {
            law,
            weight: layer.thickness * weight,
            angle: layer.angle.to_radians(),
        }));
    }
    Some(materials::layered(laws, points))
}

/// Checks the values of a part by the table of its formulation, and builds the element. Defaults
/// take the place of faulty values, so that one check reports all problems.
fn with_values(
    row: &ElementEntry,
    part: &Part,
    build: impl FnOnce(&Values<'_>) -> ElementResult,
) -> ElementResult {
    let owner = format!("part {}", part.label());
    let values = row.values(part);
    let missing = |row: &ParameterRow| {
        let message = format!("{owner} has no `{}`", row.key);
        Problem::error(row.key, message, format!("add it: {}", row.meaning))
    };
    let missing: Vec<Problem> = values.missing().map(missing).collect();
    let faults = values.faults(&owner);
    let mut given = part.parameters.clone();
    faults.iter().for_each(|fault| drop(given.remove(&fault.path)));
    let usable = Values::new(row.parameters, &given);
    if usable.missing().next().is_some() {
        return Err([missing, faults].concat());
    }
    match build(&usable) {
        Ok(element) if faults.is_empty() => Ok(element),
        Ok(_) => Err(faults),
        Err(found) => Err([found, faults].concat()),
    }
}

/// Returns the row of the formulation that a part's elements of a shape get, if there is one.
pub fn formulation(part: &Part, shape: Shape) -> Option<&'static ElementEntry> {
    row_for(part, shape).ok()
}

/// Returns the number of integration points through the thickness of a part: 1 if it has no
/// shells.
pub fn points_of(part: &Part) -> usize {
    let shells = formulation(part, Shape::Quad4).filter(|_| part.thickness > 0.0);
    let of_layers = part.layer.iter().map(|layer| layer.points).sum();
    shells.map_or(1, |row| if of_layers > 0 { of_layers } else { row.values(part).whole("points") })
}

/// The formulation that a part wants for a shape: the first of the shape if it does not say.
fn row_for(part: &Part, shape: Shape) -> Result<&'static ElementEntry, Problem> {
    let sections = [
        ("spring", part.spring.is_some(), Shape::Line2),
        ("belt", part.belt.is_some(), Shape::Line2),
        ("beam", part.beam.is_some(), Shape::Beam2),
        ("truss", part.truss.is_some(), Shape::Truss2),
        ("discrete_beam", part.discrete_beam.is_some(), Shape::Line2),
        ("particles", part.particles.is_some(), Shape::Point1),
    ];
    if let Some((key, ..)) = sections.into_iter().find(|(_, given, own)| *given && shape != *own) {
        let what = format!("part {}: it has [part.{key}] and other elements", part.label());
        let help = format!("remove [part.{key}], or move the other elements to another part");
        return Err(Problem::error(key, what, help));
    }
    let of_shape = |row: &&ElementEntry| row.shape == shape;
    let named = part.element.as_deref();
    let wanted = match (&part.discrete_beam, &part.belt) {
        (Some(_), _) => Some("discrete_beam"),
        (_, Some(_)) => Some("belt"),
        _ => named.filter(|_| matches!(shape, Shape::Quad4 | Shape::Hex8)),
    };
    // Other solids than hexahedra have one formulation each, which the name of another solid does
    // not exclude: a part may have all of them.
    let is_solid = |row: &&ElementEntry| row.shape.is_solid();
    if let Some(name) = named
        && matches!(shape, Shape::Tet4 | Shape::Wedge6 | Shape::Tet10)
        && !ELEMENTS.iter().filter(is_solid).any(|row| row.name == name)
    {
        let names: Vec<_> = ELEMENTS.iter().filter(of_shape).map(|row| row.name).collect();
        let what = format!("part {}: there is no element '{name}'", part.label());
        return Err(unknown_name("element", what, name, &names));
    }
    let row =
        ELEMENTS.iter().filter(of_shape).find(|row| wanted.is_none_or(|name| row.name == name));
    row.ok_or_else(|| {
        let names: Vec<_> = ELEMENTS.iter().filter(of_shape).map(|row| row.name).collect();
        let (corners, name) = (shape.corners(), wanted.unwrap_or_default());
        let what = format!("part {}: there is no {corners}-node element '{name}'", part.label());
        unknown_name("element", what, name, &names)
    })
}

/// Returns the column of a point that has this history column of its law, if the law has it. The
/// columns of the law begin at `first`.
fn law_column(history: &[&str], name: &str, first: usize) -> Option<usize> {
    history.iter().position(|&column| column == name).map(|column| first + column)
}

/// Returns the column of the damage of a law, counted from `first`, if it has one.
fn damage_column(history: &[&str], first: usize) -> Option<usize> {
    materials::DAMAGE_COLUMNS.iter().find_map(|name| law_column(history, name, first))
}

/// Sets the lanes that have failed to zero.
#[inline(always)]
fn zero_failed<R: Real>(failed: R::Mask, values: &mut [R]) {
    values.iter_mut().for_each(|value| *value = R::select(failed, R::zero(), *value));
}

/// Runs `$call` with the constant `$n` set to the number of points, so that the compiler unrolls
/// loops over the thickness. Shells with layers may have more points: then the constant is the
/// largest number.
macro_rules! with_points {
    ($points:expr, $n:ident => $call:expr) => {
        with_points!($points, $n => $call; 1 2 3 4 5 6 7 8 9 10)
    };
    ($points:expr, $n:ident => $call:expr; $($value:literal)*) => {
        match $points {
            $($value => { const $n: usize = $value; $call })*
            _ => { const $n: usize = crate::materials::MAX_LAYER_POINTS; $call }
        }
    };
}
use with_points;
