//! Points with damage, around a law that computes the effective stress: the state holds the stress
//! that acts, so that elements see no other. A failed point has no stress from then on.

use super::wrapped::{LawModifier, PointColumns, full_stress};
use crumple_math::lanes::Real;

/// Columns of a point with damage.
pub struct DamageColumns {
    /// Effective plastic strain of the law.
    pub plastic_strain: usize,
    /// 1 from failure on.
    pub failed: usize,
}

impl DamageColumns {
    /// Finds the columns, and adds that of failure; none if the law has no plastic strain.
    pub fn new(columns: &mut PointColumns) -> Option<Self> {
        let plastic_strain = columns.find("plastic_strain")?;
        Some(Self { plastic_strain, failed: columns.add("failed") })
    }
}

/// Growth of damage and what it leaves of the stress.
pub trait DamageLaw: Send + Sync {
    /// Returns the columns of a point.
    fn columns(&self) -> &DamageColumns;

    /// Returns the share of the effective stress that acts.
    fn intact<R: Real>(&self, state: &[R]) -> R;

    /// Adds the damage of an increment of plastic strain at this effective stress (xx, yy, zz, xy,
    /// yz, zx) [force/length^2].
    fn grow<R: Real>(&self, _state: &mut [R], _sig: &[R; 6], _plastic_strain: R) {}

    /// Returns the lanes that do not fail by damage; `intact` is the share that acts.
    fn holds<R: Real>(&self, state: &[R], intact: R) -> R::Mask;

    /// Returns the number of failed points from which on an element with so many points is removed;
    /// `of_law` is that of the law alone.
    fn failed_points(&self, _points: usize, of_law: usize) -> usize {
        of_law
    }
}

impl<D: DamageLaw> LawModifier for D {
    #[inline(always)]
    fn update<R: Real>(&self, state: &mut [R], strain: &[R], law: impl FnOnce(&mut [R]) -> R) -> R {
        let (zero, one, half) = (R::zero(), R::splat(1.0), R::splat(0.5));
        let &DamageColumns { plastic_strain, failed } = self.columns();
        let stress = strain.len();
        let alive = state[failed].lt(half);
        let before = R::select(alive, self.intact(state), one);
        state[..stress].iter_mut().for_each(|s| *s = R::select(alive, *s / before, zero));
        let old = state[plastic_strain];
        let of_law = law(state);
        // A failed point keeps its plastic strain, whatever the law inside does.
        let new = R::select(alive, state[plastic_strain], old);
        state[plastic_strain] = new;
        self.grow(state, &full_stress(state, stress), new - old);
        let after = self.intact(state);
        let holds = R::both(state[failed].lt(half), self.holds(state, after));
        let alive = R::both(alive, holds);
        state[..stress].iter_mut().for_each(|s| *s = R::select(alive, after * *s, zero));
        state[failed] = R::select(alive, zero, one);
        of_law * (after / before)
    }

    fn failed_points(&self, points: usize, of_law: usize) -> usize {
        DamageLaw::failed_points(self, points, of_law)
    }
}
