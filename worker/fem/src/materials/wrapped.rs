//! Laws around a law: damage and criteria of failure that are added to it, for shells and solids.

use super::{
    Elastic, MaterialAxes, Orientation, PlaneStress, PointReal, Points, Solid, SolidPoint,
};
use crate::materials::plasticity::Plasticity;
use crumple_math::lanes::{Lane, Lane32, Real};

/// A damage, or criteria of failure, around a law.
pub trait LawModifier: Send + Sync {
    /// Updates a point by `law` and modifies its stress. Returns the factor on the stiffness of a
    /// solid: that which `law` returns, with the modifier. Of a shell `law` returns the strain
    /// through the thickness, which a modifier does not change, and the result is not used.
    ///
    /// `state` has the stress, as many components as `strain`, the columns of the law and those of
    /// the modifier. `strain` is the increment, as in [`Points`] and [`SolidPoint`].
    fn update<R: Real>(&self, state: &mut [R], strain: &[R], law: impl FnOnce(&mut [R]) -> R) -> R;

    /// Returns the number of failed points of [`PlaneStress::failed_points`]; `of_law` is that of
    /// the law alone.
    fn failed_points(&self, _points: usize, of_law: usize) -> usize {
        of_law
    }

    /// Returns the axes of the material that the modifier needs; the law has none of its own then.
    fn axes(&self) -> Option<MaterialAxes> {
        None
    }

    /// Returns the result of [`Solid::averages_volume`]; `of_law` is that of the law alone.
    fn averages_volume(&self, of_law: bool) -> bool {
        of_law
    }
}

/// Columns of a point: the stress, then those with a name.
pub struct PointColumns {
    stress: usize,
    names: Vec<&'static str>,
}

impl PointColumns {
    /// Returns the columns of a law with so many components of stress.
    pub fn new(stress: usize, history: &[&'static str]) -> Self {
        Self { stress, names: history.to_vec() }
    }

    /// Returns the place of a column, if there is one.
    pub fn find(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|known| *known == name).map(|at| self.stress + at)
    }

    /// Returns the place of a column, which is added if it is not there.
    pub fn add(&mut self, name: &'static str) -> usize {
        self.find(name).unwrap_or_else(|| {
            self.names.push(name);
            self.stress + self.names.len() - 1
        })
    }

    /// Returns true for the columns of solids.
    pub fn of_solid(&self) -> bool {
        self.stress == SOLID
    }
}

/// Components of stress.
const SHELL: usize = 3;
const SOLID: usize = 6;

/// Returns the stress of a point (xx, yy, zz, xy, yz, zx) with so many components.
#[inline(always)]
pub fn full_stress<R: Real>(state: &[R], components: usize) -> [R; 6] {
    let zero = R::zero();
    match components {
        SHELL => [state[0], state[1], zero, state[2], zero, zero],
        _ => std::array::from_fn(|c| state[c]),
    }
}

/// A law with a modifier.
struct Wrapped<L: ?Sized, A> {
    law: Box<L>,
    modifier: A,
    names: Vec<&'static str>,
    /// Number of columns of stress and of the law.
    own: usize,
}

/// Adds to a law of shells what `modifier` makes of its columns, or returns its problems.
pub fn shell<A: LawModifier + 'static, E>(
    law: Box<dyn PlaneStress>,
    modifier: impl FnOnce(&mut PointColumns) -> Result<A, E>,
) -> Result<Box<dyn PlaneStress>, E> {
    let mut columns = PointColumns::new(SHELL, law.history());
    let own = SHELL + law.history().len();
    let modifier = modifier(&mut columns)?;
    Ok(Box::new(Wrapped { law, modifier, names: columns.names, own }))
}

/// Adds to a law of solids what `modifier` makes of its columns, or returns its problems.
pub fn solid<A: LawModifier + 'static, E>(
    law: Box<dyn Solid>,
    modifier: impl FnOnce(&mut PointColumns) -> Result<A, E>,
) -> Result<Box<dyn Solid>, E> {
    let mut columns = PointColumns::new(SOLID, law.history());
    let own = SOLID + law.history().len();
    let modifier = modifier(&mut columns)?;
    Ok(Box::new(Wrapped { law, modifier, names: columns.names, own }))
}

impl<A: LawModifier> Wrapped<dyn PlaneStress, A> {
    #[inline(always)]
    fn points<R: PointReal>(&self, points: Points<'_, R>, dt: f64) {
        let states = points.state.chunks_exact_mut(SHELL + self.names.len());
        for ((state, eps), through) in states.zip(points.strain).zip(points.thickness_strain) {
            let strain = std::slice::from_ref(eps);
            self.modifier.update(state, eps, |state| {
                let (state, thickness_strain) =
                    (&mut state[..self.own], std::slice::from_mut(&mut *through));
                R::update(&*self.law, Points { state, strain, thickness_strain }, dt);
                *through
            });
        }
    }
}

impl<A: LawModifier> Wrapped<dyn Solid, A> {
    #[inline(always)]
    fn point<R: PointReal>(&self, point: SolidPoint<'_, R>, dt: f64) -> R {
        let strain = point.strain;
        self.modifier.update(point.state, strain, |state| {
            R::update_solid(&*self.law, SolidPoint { state: &mut state[..self.own], strain }, dt)
        })
    }
}

impl<A: LawModifier> PlaneStress for Wrapped<dyn PlaneStress, A> {
    fn history(&self) -> &[&'static str] {
        &self.names
    }
    fn elastic(&self) -> Elastic {
        self.law.elastic()
    }
    fn adds_stress(&self) -> bool {
        self.law.adds_stress()
    }
    fn initial_yield_stress(&self) -> f64 {
        self.law.initial_yield_stress()
    }
    fn thins(&self) -> bool {
        self.law.thins()
    }
    fn failed_points(&self, points: usize) -> usize {
        self.modifier.failed_points(points, self.law.failed_points(points))
    }
    fn orientation(&self, point: usize) -> Option<Orientation> {
        self.law.orientation(point)
    }
    fn transverse_shear(&self, point: usize) -> Option<[f64; 2]> {
        self.law.transverse_shear(point)
    }
    fn stabilising(&self) -> Elastic {
        self.law.stabilising()
    }
    fn rate_dependent(&self) -> Option<&Plasticity> {
        self.law.rate_dependent()
    }
    fn update(&self, points: Points<'_, Lane>, dt: f64) {
        self.points(points, dt);
    }
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64) {
        self.points(points, dt);
    }
    fn update_one(&self, points: Points<'_, f64>, dt: f64) {
        self.points(points, dt);
    }
}

impl<A: LawModifier> Solid for Wrapped<dyn Solid, A> {
    fn history(&self) -> &[&'static str] {
        &self.names
    }
    fn tensors(&self) -> usize {
        self.law.tensors()
    }
    fn axes(&self) -> Option<MaterialAxes> {
        self.law.axes().or_else(|| self.modifier.axes())
    }
    fn elastic(&self) -> Elastic {
        self.law.elastic()
    }
    fn adds_stress(&self) -> bool {
        self.law.adds_stress()
    }
    fn averages_volume(&self) -> bool {
        self.modifier.averages_volume(self.law.averages_volume())
    }
    fn viscosity(&self) -> Option<f64> {
        self.law.viscosity()
    }
    fn update(&self, point: SolidPoint<'_, Lane>, dt: f64) -> Lane {
        self.point(point, dt)
    }
    fn update_short(&self, point: SolidPoint<'_, Lane32>, dt: f64) -> Lane32 {
        self.point(point, dt)
    }
    fn update_one(&self, point: SolidPoint<'_, f64>, dt: f64) -> f64 {
        self.point(point, dt)
    }
}
