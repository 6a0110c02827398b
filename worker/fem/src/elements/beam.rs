//! Two-node beam in a corotational frame (Belytschko, Schwer & Klein 1977), with its cross section
//! integrated over fibres as in Hughes & Liu 1981.
//!
//! Each node has a triad that rotates with it. The first axis of the frame is along the line
//! between the nodes. The second one is perpendicular to it, between the second axes of the triads.
//! The length and the triads relative to the frame give the deformation of the beam: `u = L - L0`,
//! the rotations of its ends about the second and third axis, and the twist. They are measured, not
//! summed up, so that no rotation leaves a strain. With the cubic shape of a thin beam (Euler,
//! Bernoulli), at `x = s L0`,
//! ```text
//! kappa(s) = ((6 s - 4) theta_1 + (6 s - 2) theta_2)/L0,   eps = u/L0 + z kappa_y - y kappa_z
//! ```
//! integrated by Lobatto's rule at both ends and the middle: bending is exact for forces on the
//! nodes, and a plastic hinge forms exactly at the end. Fibres have a law in plane stress, with
//! zero stress across. Those of tubes carry the torque as shear, with the law; in other sections
//! the torque stays elastic. A weld breaks when the forces at its end reach
//! `(N/S_n)^n + (V/S_s)^m + (M/S_b)^2 + (T/S_t)^2 = 1`, tension only.
//!
//! If shear areas are given, shear also deforms the beam, elastically (Timoshenko 1921):
//! `gamma = (m_1 + m_2)/(L G A_s)` is subtracted from the rotations of both ends before they bend
//! the beam. With `phi = 12 E I/(G A_s L^2)` the increment `d theta` of their mean gives `d gamma =
//! (phi d theta + (m_1 + m_2)/(L G A_s) - gamma)/(1 + phi)`. This is exact while the fibres are
//! elastic, and follows their remaining moments when they yield.
//!
//! A beam with a preload, such as a bolt, has a prescribed axial stress until the end of its curve:
//! the stresses of all fibres, or their mean in each section, are set to it after the law, so that
//! the axial force is the stress times the area. Its work is internal energy.
//!
//! Forces follow from virtual work, and shear forces from the moments, so that they conserve
//! momentum and angular momentum: `f_2 = N e_1 + e_1 x (m_1 + m_2)/L`.
//!
//! Stable step with masses m/2 and inertias J at the ends: axial `w^2 = 4 E/(rho L^2)`, bending
//! with equal rotations of both ends `w^2 = 6 E I/L (1/J + 8/(m L^2))`, which is above that with
//! opposite rotations, and twist `w^2 = 2 G J_t/(L J)`; with the length at the start, or the
//! present one if that is shorter.

mod preload;
mod section;
#[cfg(test)]
mod tests;

use self::preload::Preload;
use self::section::FibreSection;
use super::fibre::FibreMaterial;
use super::{
    Constructor, Element, ElementEntry, ElementFields, ElementPass, ElementResult, PassTotals,
    SingleElement,
};
use crate::columns::ElementState;
use crate::materials::{MAX_POINTS, PlaneStress};
use crate::parameter::Values;
use crumple_math::row::{V3, xyz};
use crumple_proto::job::{BeamInput, BeamSection, Part, Weld};
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::problem::Problem;
use nalgebra::{Rotation3, UnitQuaternion};

/// The row of this element.
pub const ROW: ElementEntry = ElementEntry {
    name: "beam",
    shape: Shape::Beam2,
    meaning: "Two-node beam in a corotating frame, with a cross section of fibres.",
    parameters: [&[], &[]],
    idle: |_| &[],
    build: Constructor::Shell(build),
};

type Rotation = UnitQuaternion<f64>;

/// Columns of an element: 1 if it has started, else 0; length then [length]; triads as quaternions
/// (before the start a vector towards the second axis); deformation; forces at its corners; 1 if it
/// is broken, else 0; shear; time since its start; then those of its fibres.
const STARTED: usize = 0;
const LENGTH: usize = 1;
const TRIADS: usize = 2;
const DEFORMED: usize = 10;
const FORCES: usize = 16;
const BROKEN: usize = 25;
/// Rotations of the ends about the second and the third axis due to shear, and the sums of their
/// moments.
const SHEARED: usize = 26;
const SUMS: usize = 28;
/// Time since the start [time], for a preload.
const TIME: usize = 30;
const FIBRES: usize = 31;
/// Number of ends.
const ENDS: usize = 2;
/// Weights of Lobatto's rule at s = 0, 1/2, 1, and the factors of the rotations of the ends in the
/// curvature there.
const SECTIONS: [(f64, f64, f64); 3] =
    [(1.0 / 6.0, -4.0, -2.0), (2.0 / 3.0, -1.0, 1.0), (1.0 / 6.0, 2.0, 4.0)];
/// Largest strain increment of a valid step.
pub(super) const STRAIN_LIMIT: f64 = 0.5;

/// Parameters of beams.
pub struct Beam {
    material: FibreMaterial,
    section: FibreSection,
    /// Area [length^2]; second moments about the second and third axis, torsion constant
    /// [length^4].
    moments: [f64; 4],
    /// Shear areas for bending about the second and the third axis [length^2]; 0 for no shear
    /// deformation.
    shear_areas: [f64; 2],
    weld: Option<Weld>,
    preload: Option<Preload>,
}

fn build(part: &Part, _: &Values<'_>, law: Box<dyn PlaneStress>) -> ElementResult {
    let mut problems = Vec::new();
    let mut say = |key: &str, what: String, help: &str| {
        problems.push(Problem::error(key, format!("part {}: {what}", part.label()), help));
    };
    let Some(beam) = &part.beam else {
        say("beam", "it has beams but no cross section".into(), "add [part.beam] with a section");
        return Err(problems);
    };
    if part.element.is_some() {
        say("element", "beams have one formulation".into(), "remove `element`");
    }
    check_section(beam, &mut say);
    if let Some(weld) = &beam.weld {
        check_weld(weld, &mut say);
    }
    if let Some(fault) = Preload::fault(beam) {
        say("beam.preload", fault, "give points in ascending time with stresses of one sign");
    }
    let (most, yields) = (Preload::largest(beam), law.initial_yield_stress());
    if most >= yields {
        // The return of the law to its yield surface would be undone in every step.
        let what = format!("its preload reaches {most}, and its material yields at {yields}");
        say("beam.preload", what, "keep all stresses below the yield stress");
    }
    let material = FibreMaterial::new(law);
    if material.is_none() {
        say("material", "beams cannot store the history of its law".into(), "use another law");
    }
    let Some(material) = material.filter(|_| problems.is_empty()) else { return Err(problems) };
    let section = FibreSection::new(beam);
    Ok(Box::new(Beam {
        weld: beam.weld.clone(),
        preload: Preload::new(beam),
        material,
        moments: section.moments(),
        // A force along the third axis bends about the second one.
        shear_areas: [beam.shear_areas[1], beam.shear_areas[0]],
        section,
    }))
}

/// Reports a problem: the key, what is wrong, and what to do.
type AddProblem<'a> = dyn FnMut(&str, String, &str) + 'a;

/// Checks the numbers of a cross section.
fn check_section(beam: &BeamInput, say: &mut AddProblem<'_>) {
    let [about_y, about_z] = beam.second_moments;
    let all = [
        ("height", beam.height),
        ("width", beam.width),
        ("flange", beam.flange),
        ("web", beam.web),
        ("radius", beam.radius),
        ("wall", beam.wall),
        ("area", beam.area),
        (
            "second_moments",
            if about_y.min(about_z) < 0.0 { about_y.min(about_z) } else { about_y.max(about_z) },
        ),
        ("torsion", beam.torsion),
    ];
    all.into_iter().for_each(|(key, value)| check_number(beam, key, value, say));
    if beam.section == BeamSection::I
        && !(2.0 * beam.flange < beam.height && beam.web <= beam.width)
    {
        say(
            "beam",
            "flanges or web are thicker than the section".into(),
            "correct height, width, flange and web",
        );
    }
    for (k, area) in beam.shear_areas.into_iter().enumerate().filter(|(_, area)| *area < 0.0) {
        say(
            &format!("beam.shear_areas.{k}"),
            format!("a shear area is {area}"),
            "give an area above 0, or 0 for no shear deformation",
        );
    }
    if let Some(radius) =
        beam.contact_radius.filter(|radius| !(*radius > 0.0 && radius.is_finite()))
    {
        say("beam.contact_radius", format!("contact_radius is {radius}"), "it has to be above 0");
    }
}

/// Checks one number of a cross section: its range, and that the section has it.
fn check_number(beam: &BeamInput, key: &str, value: f64, say: &mut AddProblem<'_>) {
    let needed: &[&str] = match beam.section {
        BeamSection::Rectangle => &["height", "width"],
        BeamSection::Tube => &["radius"],
        BeamSection::I => &["height", "width", "flange", "web"],
        BeamSection::General => &["area"],
    };
    let of_general =
        beam.section == BeamSection::General && matches!(key, "second_moments" | "torsion");
    let may = of_general || beam.section == BeamSection::Tube && key == "wall";
    let (name, found) = (format!("beam.{key}"), format!("{key} is {value}"));
    if needed.contains(&key) && value <= 0.0 {
        say(&name, found, "it has to be above 0");
    } else if of_general && value < 0.0 {
        say(&name, found, "it has to be 0 or above");
    } else if key == "wall" && may && !(0.0..=beam.radius).contains(&value) {
        say(&name, found, "it has to be from 0 (a solid bar) to the radius");
    } else if !needed.contains(&key) && !may && value != 0.0 {
        say(&name, format!("its section has no {key}"), "remove it");
    }
}

/// Checks the limits of the welds.
fn check_weld(weld: &Weld, say: &mut AddProblem<'_>) {
    let Weld { normal, shear, bending, torsion, exponents: [n, m] } = *weld;
    let limits = [("normal", normal), ("shear", shear), ("bending", bending), ("torsion", torsion)];
    for (key, value) in limits.into_iter().filter(|limit| limit.1 < 0.0) {
        say(
            &format!("beam.weld.{key}"),
            format!("{key} of its welds is {value}"),
            "give 0 (no limit) or above",
        );
    }
    if limits.iter().all(|limit| limit.1 == 0.0) {
        say(
            "beam.weld",
            "its welds have no limit".into(),
            "give normal, shear, bending or torsion",
        );
    }
    if n <= 0.0 || m <= 0.0 {
        say(
            "beam.weld.exponents",
            format!("exponents of its welds are {n}, {m}"),
            "they have to be above 0",
        );
    }
}

/// Coordinates and velocities of the ends of a beam.
struct Ends {
    x: [V3; ENDS],
    v: [V3; ENDS],
    w: [V3; ENDS],
}

/// Results of a beam for its nodes: force on the second one, moments on both, and true if it is
/// finite and its strain increments are within the limit.
struct BeamResponse {
    force: V3,
    moments: [V3; 2],
    sound: bool,
}

impl Beam {
    fn respond(&self, state: &mut [f64], ends: &Ends, dt: f64) -> BeamResponse {
        let line = ends.x[1] - ends.x[0];
        let length = line.norm();
        if state[STARTED] == 0.0 {
            (state[STARTED], state[LENGTH]) = (1.0, length);
            let along = line / length;
            let third = along.cross(&V3::from_column_slice(&state[TRIADS..TRIADS + 3])).normalize();
            let first = frame(&along, &third.cross(&along));
            (0..ENDS).for_each(|k| put_turn(&mut state[TRIADS + 4 * k..], &first));
        }
        // 1. Triads, frame, deformation.
        let triads = [0, 1].map(|k| {
            let turn =
                Rotation::from_scaled_axis(ends.w[k] * dt) * turn_at(&state[TRIADS + 4 * k..]);
            let turn = Rotation::new_normalize(turn.into_inner());
            put_turn(&mut state[TRIADS + 4 * k..], &turn);
            turn
        });
        let along = line / length;
        let second = triads[0] * V3::y() + triads[1] * V3::y();
        let axes = frame(&along, &(second - along * along.dot(&second)).normalize());
        let [first, last] = triads.map(|t| (axes.inverse() * t).scaled_axis());
        let start = state[LENGTH];
        let deformed = [length - start, first.y, last.y, first.z, last.z, last.x - first.x];
        let mut step = [0.0; 6];
        for ((step, now), column) in step.iter_mut().zip(deformed).zip(&mut state[DEFORMED..FORCES])
        {
            *step = now - std::mem::replace(column, now);
        }

        let sheared = [[1, 2], [3, 4]].map(|ends| ends.map(|k| step[k]));
        for (axis, own) in sheared.into_iter().enumerate() {
            let strain = self.shear(state, axis, 0.5 * (own[0] + own[1]), start);
            (0..ENDS).for_each(|k| step[1 + 2 * axis + k] -= strain);
        }

        // 2. Fibres at the sections, and what they give to the ends.
        let preload = self.preload.as_ref().and_then(|p| p.stress(&mut state[TIME], dt));
        let [du, y1, y2, z1, z2, twist] = step.map(|d| d / start);
        let (mut axial, mut torque, mut bending, mut largest) = (0.0, 0.0, [0.0; 4], 0.0f64);
        for (number, (weight, of_first, of_last)) in SECTIONS.into_iter().enumerate() {
            let [about_y, about_z] = [of_first * y1 + of_last * y2, of_first * z1 + of_last * z2];
            let from = FIBRES + number * self.section.fibres.len() * self.material.stride;
            for (batch, fibres) in self.section.fibres.chunks(MAX_POINTS).enumerate() {
                let from = from + batch * MAX_POINTS * self.material.stride;
                let mut strain = [[0.0; 3]; MAX_POINTS];
                for (strain, f) in strain.iter_mut().zip(fibres) {
                    *strain = [du + f.z * about_y - f.y * about_z, 0.0, f.arm * twist];
                    largest = largest.max(strain[0].abs());
                }
                let fibre_states = &mut state[from..from + fibres.len() * self.material.stride];
                self.material.strain(fibre_states, &mut strain[..fibres.len()], dt);
            }
            if let Some(stress) = preload {
                let to = from + self.section.fibres.len() * self.material.stride;
                self.tighten(&mut state[from..to], stress);
            }
            for (batch, fibres) in self.section.fibres.chunks(MAX_POINTS).enumerate() {
                let from = from + batch * MAX_POINTS * self.material.stride;
                let fibre_states = &state[from..from + fibres.len() * self.material.stride];
                for (state, f) in fibre_states.chunks_exact(self.material.stride).zip(fibres) {
                    let along = weight * f.area * state[0];
                    axial += along;
                    torque += weight * f.area * f.arm * state[2];
                    bending[0] += of_first * f.z * along;
                    bending[1] += of_last * f.z * along;
                    bending[2] -= of_first * f.y * along;
                    bending[3] -= of_last * f.y * along;
                }
            }
        }
        state[SUMS] = bending[0] + bending[1];
        state[SUMS + 1] = bending[2] + bending[3];
        torque +=
            self.material.elastic.shear_modulus() * self.section.torsion * deformed[5] / start;

        // 3. Forces in space.
        let moments =
            [V3::new(-torque, bending[0], bending[2]), V3::new(torque, bending[1], bending[3])]
                .map(|m| axes * m);
        let across = along.cross(&(moments[0] + moments[1])) / length;
        let force = along * axial + across;
        if let Some(weld) = &self.weld {
            let bent = moments.map(|m| (m - along * along.dot(&m)).norm());
            if weld_is_broken(weld, axial, across.norm(), bent[0].max(bent[1]), torque) {
                state[BROKEN] = 1.0;
            }
        }
        let sum = force.abs().sum() + moments[0].abs().sum() + moments[1].abs().sum();
        BeamResponse { force, moments, sound: sum.is_finite() && largest <= STRAIN_LIMIT }
    }

    /// Gives the fibres of a section the stress of a preload, or this mean stress if they keep
    /// their differences.
    fn tighten(&self, fibres: &mut [f64], stress: f64) {
        let stride = self.material.stride;
        if !self.preload.as_ref().is_some_and(|p| p.bending) {
            return fibres.chunks_exact_mut(stride).for_each(|state| state[0] = stress);
        }
        let own = fibres.chunks_exact(stride).zip(&self.section.fibres);
        let mean = own.map(|(state, f)| f.area * state[0]).sum::<f64>() / self.moments[0];
        fibres.chunks_exact_mut(stride).for_each(|state| state[0] += stress - mean);
    }

    /// Returns the part of an increment of the mean rotation of the ends about the second (0) or
    /// third (1) axis that is shear.
    fn shear(&self, state: &mut [f64], axis: usize, turned: f64, length: f64) -> f64 {
        let stiffness = self.material.elastic.shear_modulus() * self.shear_areas[axis] * length;
        if stiffness == 0.0 {
            return 0.0;
        }
        let phi = 12.0 * self.material.elastic.youngs_modulus * self.moments[1 + axis]
            / (stiffness * length);
        let left = state[SUMS + axis] / stiffness - state[SHEARED + axis];
        let strain = (phi * turned + left) / (1.0 + phi);
        state[SHEARED + axis] += strain;
        strain
    }
}

/// Returns true if the forces and moments at the end of a weld break it.
fn weld_is_broken(weld: &Weld, axial: f64, across: f64, bent: f64, torque: f64) -> bool {
    let part = |load: f64, limit: f64, exponent: f64| {
        if limit > 0.0 { (load / limit).powf(exponent) } else { 0.0 }
    };
    let [n, m] = weld.exponents;
    let forces = part(axial.max(0.0), weld.normal, n) + part(across, weld.shear, m);
    forces + part(bent, weld.bending, 2.0) + part(torque.abs(), weld.torsion, 2.0) >= 1.0
}

/// Returns the rotation of the axes of space to a first and a second axis, and the third one.
fn frame(first: &V3, second: &V3) -> Rotation {
    let axes = [*first, *second, first.cross(second)];
    Rotation::from_rotation_matrix(&Rotation3::from_basis_unchecked(&axes))
}

fn turn_at(columns: &[f64]) -> Rotation {
    Rotation::new_unchecked(nalgebra::Quaternion::new(
        columns[0], columns[1], columns[2], columns[3],
    ))
}

fn put_turn(columns: &mut [f64], turn: &Rotation) {
    columns[..4].copy_from_slice(&[turn.w, turn.i, turn.j, turn.k]);
}

impl Element for Beam {
    fn columns(&self) -> usize {
        FIBRES + SECTIONS.len() * self.section.fibres.len() * self.material.stride
    }

    fn names(&self) -> Vec<String> {
        let several = |name: &'static str, count| (0..count).map(move |k| format!("{name} {k}"));
        let one = |name: &str| std::iter::once(name.to_string());
        let own = one("started")
            .chain(one("length"))
            .chain(several("triad", DEFORMED - TRIADS))
            .chain(several("deformation", FORCES - DEFORMED))
            .chain(several("force", BROKEN - FORCES))
            .chain(one("broken"))
            .chain(several("shear rotation", SUMS - SHEARED))
            .chain(several("moment sum", TIME - SUMS))
            .chain(one("time"));
        let fibres = (0..SECTIONS.len() * self.section.fibres.len()).flat_map(|fibre| {
            self.material.names().map(move |name| format!("fibre {fibre} {name}"))
        });
        own.chain(fibres).collect()
    }

    fn orient(&self, history: &mut [f64], towards: [f64; 3]) {
        history[TRIADS..].iter_mut().zip(towards).for_each(|(column, c)| *column = c);
    }

    fn corner_mass(&self, x: &[[f64; 3]], _: OwnSection) -> (f64, f64) {
        self.masses((V3::from(x[1]) - V3::from(x[0])).norm())
    }

    fn forces(&self, pass: ElementPass<'_>) -> PassTotals {
        let (nodes, dt) = (pass.nodes, pass.dt);
        pass.one_by_one::<ENDS>(self.columns(), |element, out| {
            let SingleElement { index, nodes: of_element, state, internal } = element;
            let at = |rows: &[[f64; 4]], c: usize| V3::from(xyz(&rows[of_element[c]]));
            let ends = Ends {
                x: [0, 1].map(|c| at(nodes.x, c)),
                v: [0, 1].map(|c| at(nodes.v, c)),
                w: [0, 1].map(|c| at(nodes.w, c)),
            };
            let mut r = self.respond(state, &ends, dt);
            let gone = self.is_gone(state);
            if gone {
                (r.force, r.moments, r.sound) = (V3::zeros(), [V3::zeros(); 2], true);
            }
            let moves = [ends.v[1] - ends.v[0], ends.w[0], ends.w[1]];
            for ((now, moved), column) in
                [r.force, r.moments[0], r.moments[1]].iter().zip(moves).zip((FORCES..).step_by(3))
            {
                let before = V3::from_column_slice(&state[column..column + 3]);
                *internal += if gone { 0.0 } else { 0.5 * dt * (before + now).dot(&moved) };
                state[column..column + 3].copy_from_slice(now.as_slice());
            }
            let slot = index * ENDS;
            for c in 0..3 {
                (out.force[slot][c], out.force[slot + 1][c]) = (-r.force[c], r.force[c]);
                (out.moment[slot][c], out.moment[slot + 1][c]) = (r.moments[0][c], r.moments[1][c]);
            }
            let step = || self.step((ends.x[1] - ends.x[0]).norm().min(state[LENGTH]));
            (if gone { f64::INFINITY } else { step() }, r.sound)
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
        self.material.failed.is_some() || self.weld.is_some()
    }

    fn fields(&self, history: ElementState<'_>, x: &[[f64; 3]]) -> ElementFields {
        let state = history.to_vec();
        let along = (V3::from(x[1]) - V3::from(x[0])).try_normalize(0.0).unwrap_or_default();
        let (mut fields, mut mean) = (ElementFields::default(), 0.0);
        for fibre in state[FIBRES..].chunks_exact(self.material.stride) {
            let (direct, shear) = (fibre[0], fibre[2]);
            fields.von_mises = fields.von_mises.max((direct * direct + 3.0 * shear * shear).sqrt());
            fields.plastic_strain = fields
                .plastic_strain
                .max(self.material.plastic_strain.map_or(0.0, |column| fibre[column]));
        }
        for (section, (weight, ..)) in state[FIBRES..]
            .chunks_exact(self.section.fibres.len() * self.material.stride)
            .zip(SECTIONS)
        {
            let of = |(fibre, f): (&[f64], &section::Fibre)| fibre[0] * f.area;
            let force: f64 =
                section.chunks_exact(self.material.stride).zip(&self.section.fibres).map(of).sum();
            mean += weight * force / self.moments[0];
        }
        let dyad = |i: usize, j: usize| mean * along[i] * along[j];
        fields.stress = [dyad(0, 0), dyad(1, 1), dyad(2, 2), dyad(0, 1), dyad(1, 2), dyad(2, 0)];
        fields.failed = self.is_gone(&state);
        fields
    }
}

impl Beam {
    /// Returns the mass of an end and its rotational inertia, for a beam of this length at the
    /// start.
    fn masses(&self, length: f64) -> (f64, f64) {
        let [area, iy, iz, _] = self.moments;
        let line = self.material.elastic.density * length;
        // Half of the beam about its end; the section's own inertia is used for any axis.
        (0.5 * line * area, line * (area * length * length / 24.0 + 0.5 * iy.max(iz)))
    }

    /// Returns the stable step of a beam of this length. Mass and axial stiffness depend on the
    /// length at the start, and shear forces on the present one; the shorter of them is safe.
    fn step(&self, length: f64) -> f64 {
        let [area, iy, iz, torsion] = self.moments;
        let (mass, inertia) =
            (self.material.elastic.density * area * length, self.masses(length).1);
        let (e, g) = (self.material.elastic.youngs_modulus, self.material.elastic.shear_modulus());
        let axial = 4.0 * e * area / (mass * length);
        let bending =
            6.0 * e * iy.max(iz) / length * (1.0 / inertia + 8.0 / (mass * length * length));
        let twist = 2.0 * g * torsion / (length * inertia);
        let largest = axial.max(bending).max(twist);
        if largest.is_finite() { 2.0 / largest.sqrt() } else { f64::NAN }
    }

    /// Returns true if it is broken or all of its fibres have failed.
    fn is_gone(&self, state: &[f64]) -> bool {
        let of_all = |column: usize| {
            state[FIBRES..].chunks_exact(self.material.stride).all(|fibre| fibre[column] > 0.5)
        };
        state[BROKEN] > 0.5 || self.material.failed.is_some_and(of_all)
    }
}
