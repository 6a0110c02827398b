//! A shell of layers: each point through its thickness has the law of its layer.
//!
//! The history of a point has all columns that the laws of any layer have. Columns of the same name
//! are one column, so that the element finds plastic strain, failure and directions as in a shell
//! of one material.

use super::{Elastic, MAX_POINTS, Orientation, PlaneStress, PointReal, Points};
use crate::materials::plasticity::Plasticity;
use crumple_math::lanes::{Lane, Lane32};

/// Largest number of points through the thickness of a shell with layers.
pub const MAX_LAYER_POINTS: usize = 40;

/// Largest number of columns of a point: stress and history.
const MAX_COLUMNS: usize = 64;

/// A point of a layer.
#[derive(Clone, Copy, Debug)]
pub struct LayerPoint {
    /// Index into the laws.
    pub law: usize,
    /// Weight of the point; any unit.
    pub weight: f64,
    /// Angle of its axis a from that of its material [rad].
    pub angle: f64,
}

struct Layered {
    laws: Vec<Box<dyn PlaneStress>>,
    points: Vec<LayerPoint>,
    history: Vec<&'static str>,
    /// For each law, the column of a point for each of its own; `None` if they are the same.
    columns: Vec<Option<Vec<usize>>>,
    elastic: Elastic,
    stabilising: Elastic,
}

/// Returns the law of a shell with these points from its inner surface to its outer one. A single
/// law without angles remains as it is.
///
/// # Panics
/// Without points, or with more than [`MAX_LAYER_POINTS`].
pub fn layered(
    mut laws: Vec<Box<dyn PlaneStress>>,
    points: Vec<LayerPoint>,
) -> Box<dyn PlaneStress> {
    assert!((1..=MAX_LAYER_POINTS).contains(&points.len()), "{} points", points.len());
    if laws.len() == 1 && points.iter().all(|point| point.angle == 0.0) {
        return laws.remove(0);
    }
    // The section saves the first columns of laws with plastic flow before a step.
    let flows = |law: &&dyn PlaneStress| law.history().contains(&"plastic_strain");
    let (first, rest): (Vec<_>, Vec<_>) = laws.iter().map(|law| &**law).partition(flows);
    let mut history: Vec<&'static str> = Vec::new();
    for &name in first.iter().chain(&rest).flat_map(|law| law.history()) {
        if !history.contains(&name) {
            history.push(name);
        }
    }
    assert!(3 + history.len() <= MAX_COLUMNS, "{} columns", history.len());
    let place = |name: &&str| history.iter().position(|other| other == name).expect("a column");
    let columns = laws.iter().map(|law| {
        let own: Vec<usize> =
            (0..3).chain(law.history().iter().map(|name| 3 + place(name))).collect();
        (law.history() != history).then_some(own)
    });
    let columns = columns.collect();
    let (elastic, stabilising) = constants(&laws, &points);
    Box::new(Layered { columns, laws, points, history, elastic, stabilising })
}

/// Returns isotropic constants that are nowhere softer than a layer, for the stable step, and means
/// over the thickness, for stabilising forces. Both have the mean density.
fn constants(laws: &[Box<dyn PlaneStress>], points: &[LayerPoint]) -> (Elastic, Elastic) {
    let whole: f64 = points.iter().map(|point| point.weight).sum();
    let mean = |of: &dyn Fn(&dyn PlaneStress) -> f64| {
        points.iter().map(|point| point.weight * of(&*laws[point.law])).sum::<f64>() / whole
    };
    let density = mean(&|law| law.elastic().density);
    // C (1 + nu) and C (1 - nu), the stiffness for equal and for opposite strains along the axes.
    let largest = |sign: f64| {
        let of = |law: &dyn PlaneStress| {
            law.elastic().plane_stress()[0] * (1.0 + sign * law.elastic().poisson)
        };
        points.iter().map(|point| of(&*laws[point.law])).fold(0.0, f64::max)
    };
    let (equal, opposite) = (largest(1.0), largest(-1.0));
    let poisson = (equal - opposite) / (equal + opposite);
    let stiffest = 0.5 * (equal + opposite);
    let bound = Elastic { youngs_modulus: stiffest * (1.0 - poisson * poisson), poisson, density };
    let stabilising = Elastic {
        youngs_modulus: mean(&|law| law.stabilising().youngs_modulus),
        poisson: mean(&|law| law.stabilising().poisson),
        density,
    };
    (bound, stabilising)
}

impl Layered {
    fn law_of(&self, point: usize) -> &dyn PlaneStress {
        &*self.laws[self.points[point].law]
    }

    fn stress<R: PointReal>(&self, points: Points<'_, R>, dt: f64) {
        let Points { state, strain, thickness_strain } = points;
        let stride = 3 + self.history.len();
        let mut from = 0;
        for run in self.points.chunk_by(|one, next| one.law == next.law) {
            let (law, columns) = (&*self.laws[run[0].law], &self.columns[run[0].law]);
            // A law takes at most so many points, and one if its columns have to be collected.
            let most = if columns.is_some() { 1 } else { MAX_POINTS };
            for part in run.chunks(most) {
                let to = from + part.len();
                let state = &mut state[from * stride..to * stride];
                let strain = &strain[from..to];
                let thickness_strain = &mut thickness_strain[from..to];
                match columns {
                    None => R::update(law, Points { state, strain, thickness_strain }, dt),
                    Some(columns) => {
                        let mut own = [R::zero(); MAX_COLUMNS];
                        let own = &mut own[..columns.len()];
                        own.iter_mut().zip(columns).for_each(|(own, &c)| *own = state[c]);
                        R::update(law, Points { state: own, strain, thickness_strain }, dt);
                        own.iter().zip(columns).for_each(|(own, &c)| state[c] = *own);
                    }
                }
                from = to;
            }
        }
    }
}

impl PlaneStress for Layered {
    fn history(&self) -> &[&'static str] {
        &self.history
    }
    fn elastic(&self) -> Elastic {
        self.elastic
    }
    fn adds_stress(&self) -> bool {
        self.laws.iter().all(|law| law.adds_stress())
    }
    fn initial_yield_stress(&self) -> f64 {
        self.laws.iter().map(|law| law.initial_yield_stress()).fold(f64::INFINITY, f64::min)
    }
    fn thins(&self) -> bool {
        self.laws.iter().all(|law| law.thins())
    }
    fn failed_points(&self, points: usize) -> usize {
        // The law that asks for the fewest decides.
        self.laws.iter().map(|law| law.failed_points(points)).min().unwrap_or(points)
    }
    fn orientation(&self, point: usize) -> Option<Orientation> {
        let of = self.law_of(point).orientation(point)?;
        Some(Orientation { angle: of.angle + self.points[point].angle, ..of })
    }
    fn transverse_shear(&self, point: usize) -> Option<[f64; 2]> {
        let law = self.law_of(point);
        // Layers of several laws have their own moduli: the constants are those of the stiffest.
        let own = || [law.elastic().shear_modulus(); 2];
        law.transverse_shear(point).or((self.laws.len() > 1).then(own))
    }
    fn stabilising(&self) -> Elastic {
        self.stabilising
    }
    fn rate_dependent(&self) -> Option<&Plasticity> {
        match &self.laws[..] {
            [law] => law.rate_dependent(),
            _ => None,
        }
    }
    fn update(&self, points: Points<'_, Lane>, dt: f64) {
        self.stress(points, dt);
    }
    fn update_short(&self, points: Points<'_, Lane32>, dt: f64) {
        self.stress(points, dt);
    }
    fn update_one(&self, points: Points<'_, f64>, dt: f64) {
        self.stress(points, dt);
    }
}

#[cfg(test)]
#[path = "layered_tests.rs"]
mod tests;
