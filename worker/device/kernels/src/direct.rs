//! The scalar of a thread: an `f64` that calls its law directly. A call through a table needs the
//! columns of the points in memory.

use super::{POINT_COLUMNS, POINTS};
use crumple_fem::materials::plasticity::Plasticity;
use crumple_fem::materials::{PlaneStress, PointReal, Points, Solid, SolidPoint};
use crumple_math::lanes::{Lane, Lanes, Real};
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// A number of one element, whose law is [`Plasticity`] with four columns at five points.
#[derive(Clone, Copy, Debug)]
#[repr(transparent)]
pub struct Direct(f64);

macro_rules! operators {
    ($($of:ident $call:ident, $with:ident $assign:ident;)*) => {$(
        impl $of for Direct {
            type Output = Self;
            #[inline(always)]
            fn $call(self, o: Self) -> Self {
                Self($of::$call(self.0, o.0))
            }
        }
        operators!(@ $with $assign);
    )*};
    (@ none none) => {};
    (@ $with:ident $assign:ident) => {
        impl $with for Direct {
            #[inline(always)]
            fn $assign(&mut self, o: Self) {
                $with::$assign(&mut self.0, o.0);
            }
        }
    };
}
operators! {
    Add add, AddAssign add_assign;
    Sub sub, SubAssign sub_assign;
    Mul mul, none none;
    Div div, none none;
}

impl Neg for Direct {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self(-self.0)
    }
}

macro_rules! as_f64 {
    ($($name:ident($($arg:ident),*) -> $out:tt;)*) => {$(
        #[inline(always)]
        fn $name(self, $($arg: Self),*) -> as_f64!(@type $out) {
            as_f64!(@wrap $out Real::$name(self.0, $($arg.0),*))
        }
    )*};
    (@type number) => { Self };
    (@type mask) => { bool };
    (@wrap number $e:expr) => { Self($e) };
    (@wrap mask $e:expr) => { $e };
}

impl Real for Direct {
    type Mask = bool;
    const EPSILON: f64 = f64::EPSILON;
    const SMALLEST: f64 = f64::MIN_POSITIVE;
    const LARGEST: f64 = f64::MAX;

    as_f64! {
        sqrt() -> number;
        abs() -> number;
        min(other) -> number;
        max(other) -> number;
        mul_add(factor, term) -> number;
        neg_mul_add(factor, term) -> number;
        ln() -> number;
        exp() -> number;
        lt(other) -> mask;
        le(other) -> mask;
        gt(other) -> mask;
        ge(other) -> mask;
    }
    #[inline(always)]
    fn splat(value: f64) -> Self {
        Self(value)
    }
    #[inline(always)]
    fn lane(self, _: usize) -> f64 {
        self.0
    }
    #[inline(always)]
    fn powf_where(self, exponent: f64, mask: bool) -> Self {
        Self(self.0.powf_where(exponent, mask))
    }
    #[inline(always)]
    fn select(mask: bool, yes: Self, no: Self) -> Self {
        if mask { yes } else { no }
    }
    #[inline(always)]
    fn both(a: bool, b: bool) -> bool {
        a && b
    }
    #[inline(always)]
    fn either(a: bool, b: bool) -> bool {
        a || b
    }
    #[inline(always)]
    fn any(mask: bool) -> bool {
        mask
    }
}

impl Lanes<1> for Direct {
    type Row = Lane;
    #[inline(always)]
    fn row(row: Lane) -> Lane {
        row
    }
    #[inline(always)]
    fn from_rows(rows: [Lane; 1]) -> [Self; 3] {
        <f64 as Lanes<1>>::from_rows(rows).map(Self)
    }
    #[inline(always)]
    fn to_rows([x, y, z]: [Self; 3]) -> [Lane; 1] {
        <f64 as Lanes<1>>::to_rows([x.0, y.0, z.0])
    }
    #[inline(always)]
    fn to_array(self) -> [f64; 1] {
        [self.0]
    }
    #[inline(always)]
    fn from_array([number]: [f64; 1]) -> Self {
        Self(number)
    }
}

impl PointReal for Direct {
    #[inline(always)]
    fn update(law: &dyn PlaneStress, points: Points<'_, Self>, dt: f64) {
        // SAFETY: shells of this scalar have this law: see `element`.
        let law = unsafe { &*std::ptr::from_ref(law).cast::<Plasticity>() };
        // One point after the other needs the fewest registers. They are independent, so the bits
        // are the same.
        let Points { state, strain, thickness_strain } = points;
        macro_rules! point {
            ($($k:literal)*) => {$(
                let point = Points {
                    state: &mut state[$k * POINT_COLUMNS..][..POINT_COLUMNS],
                    strain: &strain[$k..=$k],
                    thickness_strain: &mut thickness_strain[$k..=$k],
                };
                law.update_points::<Self, 1, POINT_COLUMNS>(point, dt);
            )*};
        }
        const { assert!(POINTS == 5) };
        point! { 0 1 2 3 4 }
    }
    #[inline(always)]
    fn update_solid(_: &dyn Solid, _: SolidPoint<'_, Self>, _: f64) -> Self {
        unreachable!("shells only")
    }
}
