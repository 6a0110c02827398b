//! Two-node truss: a force along the line between its nodes, without bending and rotations.
//!
//! With the length L0 at the start and the area A at the start, the strain increment of a step is
//! `dL / L0`, the same measure as that along a beam. The stress follows from the law of fibres
//! (`fibre.rs`), elastic or plastic, and the force is
//! ```text
//! f_2 = A sig(eps) e = -f_1,    eps = (L - L0) / L0
//! ```
//! with the unit vector e along the present line. The length is measured, not summed up, so no
//! rotation strains a truss. The forces are opposite and on one line: they conserve momentum and
//! angular momentum.
//!
//! Stable step: with half of the mass rho A L0 at each end, the frequency of stretching is
//! `w^2 = 4 E/(rho L0^2)`. Across the line the stiffness is N/L, which is below E A/L0 for strains
//! below 1; in a compressed truss L is below L0. The step is `2/w` with the shorter length.
//!
//! Left out: change of the area with the strain, buckling within an element.

use super::beam::STRAIN_LIMIT;
use super::fibre::FibreMaterial;
use super::{
    Constructor, Element, ElementEntry, ElementFields, ElementPass, ElementResult, PassTotals,
    SingleElement,
};
use crate::columns::ElementState;
use crate::materials::PlaneStress;
use crate::parameter::Values;
use crumple_math::row::{V3, xyz};
use crumple_proto::job::Part;
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::problem::Problem;

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "truss",
    shape: Shape::Truss2,
    meaning: "Two-node truss with a force along its line.",
    parameters: [&[], &[]],
    idle: |_| &[],
    build: Constructor::Shell(build),
};

/// Columns: 1 if it has started, else 0; length at the start and now [length]; force on the second
/// corner [force]; then those of its fibre.
const STARTED: usize = 0;
const LENGTH: usize = 1;
const NOW: usize = 2;
const FORCE: usize = 3;
const FIBRE: usize = 6;
/// Number of ends.
const ENDS: usize = 2;

/// Parameters of trusses.
pub struct Truss {
    material: FibreMaterial,
    /// Area [length^2].
    area: f64,
}

fn build(part: &Part, _: &Values<'_>, law: Box<dyn PlaneStress>) -> ElementResult {
    let mut problems = Vec::new();
    let mut say = |key: &str, what: String, help: &str| {
        problems.push(Problem::error(key, format!("part {}: {what}", part.label()), help));
    };
    let Some(truss) = &part.truss else {
        say("truss", "it has trusses but no cross section".into(), "add [part.truss] with an area");
        return Err(problems);
    };
    if part.element.is_some() {
        say("element", "trusses have one formulation".into(), "remove `element`");
    }
    let above_zero = |value: f64| value > 0.0 && value.is_finite();
    for (key, value) in [("area", Some(truss.area)), ("contact_radius", truss.contact_radius)] {
        if let Some(value) = value.filter(|value| !above_zero(*value)) {
            say(&format!("truss.{key}"), format!("{key} is {value}"), "it has to be above 0");
        }
    }
    let material = FibreMaterial::new(law);
    if material.is_none() {
        say("material", "trusses cannot store the history of its law".into(), "use another law");
    }
    let area = truss.area;
    match material.filter(|_| problems.is_empty()) {
        Some(material) => Ok(Box::new(Truss { material, area })),
        None => Err(problems),
    }
}

impl Truss {
    /// Updates a truss with `line` from its first to its second node. Returns the force on the
    /// second one, and true if the step is valid.
    fn respond(&self, state: &mut [f64], line: &V3, dt: f64) -> (V3, bool) {
        let length = line.norm();
        if state[STARTED] == 0.0 {
            (state[STARTED], state[LENGTH], state[NOW]) = (1.0, length, length);
        }
        let along = (length - std::mem::replace(&mut state[NOW], length)) / state[LENGTH];
        self.material.strain(&mut state[FIBRE..], &mut [[along, 0.0, 0.0]], dt);
        let force = line * (self.area * state[FIBRE] / length);
        (force, force.abs().sum().is_finite() && along.abs() <= STRAIN_LIMIT)
    }

    /// Returns the stable step of a truss of this length [time].
    fn step(&self, length: f64) -> f64 {
        let dt =
            length * (self.material.elastic.density / self.material.elastic.youngs_modulus).sqrt();
        if dt > 0.0 && dt.is_finite() { dt } else { f64::NAN }
    }

    /// Returns true if its fibre has failed.
    fn is_gone(&self, state: &[f64]) -> bool {
        self.material.failed.is_some_and(|column| state[FIBRE + column] > 0.5)
    }
}

impl Element for Truss {
    fn columns(&self) -> usize {
        FIBRE + self.material.stride
    }

    fn names(&self) -> Vec<String> {
        let own = ["started", "length", "length now", "force x", "force y", "force z"];
        own.into_iter().chain(self.material.names()).map(String::from).collect()
    }

    fn corner_mass(&self, x: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        let length = (V3::from(x[1]) - V3::from(x[0])).norm();
        (0.5 * self.material.elastic.density * self.area * length, 0.0)
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        let (nodes, dt) = (pass.nodes, pass.dt);
        pass.one_by_one::<ENDS>(self.columns(), |element, out| {
            let SingleElement { index, nodes: ends, state, internal } = element;
            let [line, v] = [nodes.x, nodes.v]
                .map(|rows| V3::from(xyz(&rows[ends[1]])) - V3::from(xyz(&rows[ends[0]])));
            let (mut force, is_valid) = self.respond(state, &line, dt);
            let gone = self.is_gone(state);
            if gone {
                force = V3::zeros();
            } else {
                let before = V3::from_column_slice(&state[FORCE..FIBRE]);
                *internal += 0.5 * dt * (before + force).dot(&v);
            }
            state[FORCE..FIBRE].copy_from_slice(force.as_slice());
            let slot = index * ENDS;
            for c in 0..3 {
                (out.force[slot][c], out.force[slot + 1][c]) = (-force[c], force[c]);
            }
            let step = || self.step(state[NOW].min(state[LENGTH]));
            if gone { (f64::INFINITY, true) } else { (step(), is_valid) }
        })
    }

    fn stable_dt(&self, x: &[[f64; 3]], _: OwnSection) -> f64 {
        self.step((V3::from(x[1]) - V3::from(x[0])).norm())
    }

    fn stable_dt_now(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> f64 {
        let length = (V3::from(x[1]) - V3::from(x[0])).norm();
        self.step(if history.at(STARTED) > 0.0 { length.min(history.at(LENGTH)) } else { length })
    }

    fn failed(&self, history: ElementState<'_>) -> bool {
        self.is_gone(&history.to_vec())
    }

    fn can_fail(&self) -> bool {
        self.material.failed.is_some()
    }

    fn fields(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> ElementFields {
        let state = history.to_vec();
        let along = (V3::from(x[1]) - V3::from(x[0])).try_normalize(0.0).unwrap_or_default();
        let (stress, fibre) = (state[FIBRE], &state[FIBRE..]);
        let dyad = |i: usize, j: usize| stress * along[i] * along[j];
        ElementFields {
            stress: [dyad(0, 0), dyad(1, 1), dyad(2, 2), dyad(0, 1), dyad(1, 2), dyad(2, 0)],
            von_mises: stress.abs(),
            plastic_strain: self.material.plastic_strain.map_or(0.0, |column| fibre[column]),
            failed: self.is_gone(&state),
            ..ElementFields::default()
        }
    }
}
