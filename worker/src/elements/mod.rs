//! Element formulations. One file per formulation, one row in [`ELEMENTS`].
//!
//! Elements are worked on in groups of [`LANES`]: lane l of every vector belongs to element l of the group.

mod belytschko_tsay;
mod c0_triangle;
#[cfg(test)]
mod motion_tests;
#[cfg(test)]
mod plate_tests;
mod quad;
mod section;
#[cfg(test)]
mod shell_benchmarks;
mod stabilised_quad;
#[cfg(test)]
mod statics;
#[cfg(test)]
pub(crate) mod testing;

use crate::lanes::{LANES, Lane};
use crate::materials::{self, PlaneStress, unknown_name};
use crumple_proto::job::Part;
use crumple_proto::mesh::Shape;
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use std::ops::Range;

/// Nodal columns as elements see them, indexed by local node; the fourth component is padding.
#[derive(Clone, Copy)]
pub struct NodeView<'a> {
    /// Coordinates [length].
    pub x: &'a [[f64; 4]],
    /// Velocities at mid-step [length/time].
    pub v: &'a [[f64; 4]],
    /// Rotational velocities at mid-step [1/time].
    pub w: &'a [[f64; 4]],
}

/// Forces of element corners. Slot `(group * LANES + lane) * 4 + corner`; components x, y, z, padding.
pub struct CornerForces<'a> {
    /// Internal force on the corner, to be subtracted from what drives the node [force].
    pub force: &'a mut [[f64; 4]],
    /// Internal moment on the corner [force length].
    pub moment: &'a mut [[f64; 4]],
}

/// What a pass over elements adds up.
#[derive(Clone, Copy, Debug)]
pub struct PassTotals {
    /// Smallest stable step of the elements passed, before the safety factor [time].
    pub stable_dt: f64,
    /// Increase of internal energy [energy].
    pub internal: f64,
    /// Increase of hourglass and drilling energy [energy].
    pub hourglass: f64,
    /// First element of the pass that is inverted, not finite, or strained by more than half in one step.
    pub trouble: Option<usize>,
}

impl PassTotals {
    /// Of no elements.
    pub const NONE: Self = Self { stable_dt: f64::INFINITY, internal: 0.0, hourglass: 0.0, trouble: None };

    /// Adds another pass.
    pub fn add(&mut self, o: &Self) {
        self.stable_dt = self.stable_dt.min(o.stable_dt);
        self.internal += o.internal;
        self.hourglass += o.hourglass;
        self.trouble = self.trouble.or(o.trouble);
    }
}

/// A group of elements: local nodes per corner and lane. Padding lanes repeat the last real element.
pub type GroupNodes = [[u32; LANES]; 4];

/// What an element tells of itself for output.
#[derive(Clone, Copy, Debug, Default)]
pub struct ElementFields {
    /// Largest effective plastic strain over the thickness.
    pub plastic_strain: f64,
    /// Global stress at mid-surface: xx, yy, zz, xy, yz, zx [force/length^2].
    pub stress: [f64; 6],
    /// Largest von Mises stress over the thickness [force/length^2].
    pub von_mises: f64,
    /// Current thickness [length].
    pub thickness: f64,
}

/// Elements of one part, all of one shape. Holds parameters only; the state is in the history columns.
pub trait Element: Send + Sync {
    /// History columns per element, each [`Lane`] wide in a group.
    fn columns(&self) -> usize;

    /// Sets the history of one fresh group (thickness and the like).
    fn start(&self, history: &mut [Lane]);

    /// Mass [mass] and rotational inertia [mass length^2] that one element gives to each of its corners.
    /// `x` are its corner coordinates.
    fn corner_mass(&self, x: &[[f64; 3]; 4]) -> (f64, f64);

    /// Internal forces of the groups in `range` at coordinates x(t), after stress is brought from t - dt to t
    /// with the mid-step velocities. `groups`, `history` and `out` are those of the whole block,
    /// `count` the number of real elements (the rest of the last group is padding and adds nothing to totals).
    #[allow(clippy::too_many_arguments)]
    fn forces(
        &self,
        range: Range<usize>,
        count: usize,
        groups: &[GroupNodes],
        history: &mut [Lane],
        nodes: NodeView<'_>,
        dt: f64,
        out: CornerForces<'_>,
    ) -> PassTotals;

    /// Stable step of one element, before the safety factor [time]; NaN if it is inverted or not finite.
    fn stable_dt(&self, x: &[[f64; 3]; 4]) -> f64;

    /// Fields of the element in `lane` of a group with this history at corner coordinates `x`.
    fn fields(&self, history: &[Lane], lane: usize, x: &[[f64; 3]; 4]) -> ElementFields;
}

/// An element, or everything that is wrong with its part.
pub type Built = Result<Box<dyn Element>, Vec<Problem>>;

/// A row of [`ELEMENTS`].
pub struct ElementRow {
    /// Name in jobs.
    pub name: &'static str,
    /// Shape that the formulation is for.
    pub shape: Shape,
    /// Checks what the formulation needs of a part; paths of problems are relative to the part.
    pub build: fn(&Part, Box<dyn PlaneStress>) -> Built,
}

/// Every formulation.
pub const ELEMENTS: &[ElementRow] = &[belytschko_tsay::ROW, stabilised_quad::ROW, c0_triangle::ROW];

/// The element of a part's shells of one shape, or everything that is wrong with the part and its material.
/// Paths are `part.INDEX.key` and `material.INDEX.key`, with indices into `settings`.
///
/// Quads take the part's formulation, triangles the only one there is for them.
pub fn build_block(settings: &Settings, part_index: usize, shape: Shape) -> Built {
    let part = &settings.parts[part_index];
    let mut problems = Vec::new();
    let mut note = |prefix: String, found: Vec<Problem>| {
        problems
            .extend(found.into_iter().map(|problem| Problem { path: format!("{prefix}.{}", problem.path), ..problem }));
    };

    let materials = &settings.materials;
    let law = match materials.iter().position(|material| material.name == part.material) {
        Some(index) => materials::build(&materials[index]).map_err(|found| note(format!("material.{index}"), found)),
        None => {
            let names: Vec<_> = materials.iter().map(|material| material.name.as_str()).collect();
            let what = format!("part {}: there is no material '{}'", section::label(part), part.material);
            note(format!("part.{part_index}"), vec![unknown_name("material", what, &part.material, &names)]);
            Err(())
        }
    };
    let row = row_for(part, shape).map_err(|problem| note(format!("part.{part_index}"), vec![problem]));
    // A part is checked even where its material is wrong, so that one run of the checks tells all.
    let stand_in = law.is_err();
    let law = law.unwrap_or_else(|()| materials::stand_in());
    let element = row.and_then(|row| (row.build)(part, law).map_err(|found| note(format!("part.{part_index}"), found)));
    match element {
        Ok(element) if !stand_in => Ok(element),
        _ => Err(problems),
    }
}

/// The formulation that a part wants for a shape.
fn row_for(part: &Part, shape: Shape) -> Result<&'static ElementRow, Problem> {
    let of_shape = |row: &&ElementRow| row.shape == shape;
    let row = match shape {
        Shape::Quad4 => ELEMENTS.iter().filter(of_shape).find(|row| row.name == part.element),
        Shape::Tri3 => ELEMENTS.iter().find(of_shape),
    };
    row.ok_or_else(|| {
        let names: Vec<_> = ELEMENTS.iter().filter(of_shape).map(|row| row.name).collect();
        let corners = shape.corners();
        let what = format!("part {}: no {corners}-node element '{}'", section::label(part), part.element);
        unknown_name("element", what, &part.element, &names)
    })
}

/// Arguments of [`Element::forces`], together.
struct Pass<'a> {
    range: Range<usize>,
    count: usize,
    groups: &'a [GroupNodes],
    history: &'a mut [Lane],
    nodes: NodeView<'a>,
    dt: f64,
    out: CornerForces<'a>,
}

/// What a kernel tells of a group, lane by lane.
struct GroupTotals {
    stable_dt: Lane,
    internal: Lane,
    hourglass: Lane,
    /// All bits set in the lanes whose element is sound.
    sound: Lane,
}

impl Pass<'_> {
    /// Calls `kernel` for each group with its connectivity, its history and its corner forces and moments,
    /// and adds up. Padding lanes add nothing.
    #[inline(always)]
    fn run<F>(self, columns: usize, mut kernel: F) -> PassTotals
    where
        F: FnMut(&GroupNodes, &NodeView<'_>, &mut [Lane], &mut [[f64; 4]; 16], &mut [[f64; 4]; 16]) -> GroupTotals,
    {
        const CORNERS: usize = 4 * LANES;
        let Pass { range, count, groups, history, nodes, dt: _, out } = self;
        let corners = range.start * CORNERS..range.end * CORNERS;
        let states = history[range.start * columns..range.end * columns].chunks_exact_mut(columns);
        let force = out.force[corners.clone()].as_chunks_mut::<CORNERS>().0;
        let moment = out.moment[corners].as_chunks_mut::<CORNERS>().0;
        let slots = force.iter_mut().zip(moment);

        let zero = Lane::splat(0.0);
        let (mut internal, mut hourglass) = (zero, zero);
        let mut stable_dt = Lane::splat(f64::INFINITY);
        let mut trouble = None;
        for (((index, group), state), (force, moment)) in range.clone().zip(&groups[range]).zip(states).zip(slots) {
            let totals = kernel(group, &nodes, state, force, moment);
            // Padding repeats a real element, so its step and its health are true; only sums must leave it out.
            let real = count.saturating_sub(index * LANES);
            let counted = |values: Lane| if real >= LANES { values } else { first_lanes(values, real) };
            internal += counted(totals.internal);
            hourglass += counted(totals.hourglass);
            stable_dt = crate::lanes::Real::min(totals.stable_dt, stable_dt);
            if !totals.sound.all() && trouble.is_none() {
                let lane = totals.sound.to_array().iter().position(|l| l.to_bits() == 0).unwrap_or(0);
                trouble = Some((index * LANES + lane).min(count - 1));
            }
        }
        PassTotals {
            stable_dt: stable_dt.to_array().into_iter().fold(f64::INFINITY, f64::min),
            internal: internal.to_array().iter().sum(),
            hourglass: hourglass.to_array().iter().sum(),
            trouble,
        }
    }
}

/// The first `count` lanes, and nought in the others.
fn first_lanes(values: Lane, count: usize) -> Lane {
    let mut values = values.to_array();
    values[count..].fill(0.0);
    Lane::new(values)
}

/// Runs `$call` with the constant `$n` set to the number of points: loops over the thickness unroll.
macro_rules! with_points {
    ($points:expr, $n:ident => $call:expr) => {
        with_points!($points, $n => $call; 1 2 3 4 5 6 7 8 9 10)
    };
    ($points:expr, $n:ident => $call:expr; $($value:literal)*) => {
        match $points {
            $($value => { const $n: usize = $value; $call })*
            points => unreachable!("a section of {points} points was built"),
        }
    };
}
use with_points;
