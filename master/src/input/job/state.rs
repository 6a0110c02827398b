//! Initial state of nodes and elements: added mass, fixed degrees of freedom, velocities, steps
//! and masses.

use super::centre;
use super::laws::{BuiltElements, Used};
use super::loads::dof_bits;
use super::node_sets::known_names;
use super::springs;
use super::units;
use super::validate::{JobProblems, nearest};
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Job, MaterialSpec};
use crumple_proto::mesh::{Mesh, MeshElement, Shape};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_proto::rigid::RigidBody;
use rustc_hash::FxHashMap;
use std::collections::HashMap;

/// Per node, in the order of the mesh.
#[derive(Clone, Debug, Default)]
pub struct NodeStart {
    /// Lumped mass in addition to that of the elements [mass].
    pub added_mass: Vec<f64>,
    /// Bits 0..6: x, y, z, rx, ry, rz fixed or prescribed.
    pub fixed: Vec<u64>,
    /// Velocity [length/time].
    pub velocity: Vec<[f64; 3]>,
    /// Rotational velocity [1/time].
    pub spin: Vec<[f64; 3]>,
    /// Degrees of freedom by node that motions prescribe in windows of time only.
    pub timed: HashMap<usize, Vec<(u64, [f64; 2])>>,
}

impl NodeStart {
    /// Returns the degrees of freedom of a node that are not free for a motion in a window.
    pub fn taken(&self, n: usize, dofs: u64, window: Option<[f64; 2]>) -> u64 {
        let timed = self.timed.get(&n).map_or(&[][..], Vec::as_slice);
        let in_windows = timed.iter().fold(0, |all, (bits, _)| all | bits);
        let meets = |other: &[f64; 2]| window.is_none_or(|own| !are_apart(own, *other));
        let met = timed.iter().filter(|(_, other)| meets(other));
        let met = met.fold(0, |all, (bits, _)| all | bits);
        dofs & (self.fixed[n] & !in_windows | met)
    }

    /// Marks degrees of freedom of a node as prescribed.
    pub fn prescribe(&mut self, n: usize, dofs: u64, window: Option<[f64; 2]>) {
        self.fixed[n] |= dofs;
        if let Some(window) = window {
            self.timed.entry(n).or_default().push((dofs, window));
        }
    }

    /// Frees what motions prescribe in windows only: the workers constrain it in time.
    pub fn free_timed(&mut self) {
        for (n, motions) in std::mem::take(&mut self.timed) {
            motions.iter().for_each(|(dofs, _)| self.fixed[n] &= !dofs);
        }
    }

    /// Fixes degrees of freedom of a node and sets their initial velocity to zero.
    pub fn hold(&mut self, n: usize, bits: u64) {
        self.fixed[n] |= bits;
        for c in 0..3 {
            if bits >> c & 1 == 1 {
                self.velocity[n][c] = 0.0;
            }
            if bits >> (c + 3) & 1 == 1 {
                self.spin[n][c] = 0.0;
            }
        }
    }
}

/// Returns true if two windows of time have no time in common.
pub fn are_apart(one: [f64; 2], other: [f64; 2]) -> bool {
    one[1] <= other[0] || other[1] <= one[0]
}

/// Per element, in the order of the mesh.
#[derive(Clone, Debug, Default)]
pub struct ElementStart {
    /// Index of its part in the settings.
    pub part: Vec<u32>,
    /// Mass without mass scaling; for rigid elements as given in the job [mass].
    pub mass: Vec<f64>,
    /// Factor on its density from mass scaling, or from the given mass of a rigid body.
    pub mass_factor: Vec<f64>,
    /// Fraction of its mass for its stable step, below 1 if springs and ties use the rest.
    pub share: Vec<f64>,
    /// Stable step with mass scaling, before the safety factor; infinite for rigid elements and
    /// skins [time].
    pub stable_dt: Vec<f64>,
    /// True if it averages its volume strain with its neighbours.
    pub averages: Vec<bool>,
    /// True if it is computed in the first cycle of an outer step only; empty without subcycles.
    pub slow: Vec<bool>,
}

/// The mesh's node sets, for access by name.
pub struct NodeSets<'m> {
    job: &'m Job,
    mesh: &'m Mesh,
    /// Indices by label.
    index: HashMap<u64, usize>,
}

impl<'m> NodeSets<'m> {
    /// Collects the sets of a mesh; names of parts and bodies of the job are for advice.
    pub fn new(job: &'m Job, mesh: &'m Mesh) -> Self {
        Self {
            job,
            mesh,
            index: mesh.nodes.iter().enumerate().map(|(i, n)| (n.id.label(), i)).collect(),
        }
    }

    /// Returns the indices of a set's nodes that elements use, ascending. Reports an error at
    /// `path` and returns `None` if there is no such set; an error of a set by rule is reported
    /// with the rule.
    pub fn indices(
        &self,
        name: &str,
        path: String,
        findings: &mut JobProblems,
    ) -> Option<Vec<usize>> {
        let Some(ids) = self.mesh.node_sets.get(name) else {
            let known: Vec<&str> = known_names(self.job, self.mesh).collect();
            // The nodes of these are not known if the set or the mesh has an error.
            if known.contains(&name) || self.job.set.iter().any(|set| set.name == name) {
                return None;
            }
            findings.add(Problem::error(
                path,
                format!("there is no node set `{name}`"),
                nearest(name, &known),
            ));
            return None;
        };
        let nodes: Vec<usize> = ids.iter().filter_map(|&id| self.place(id)).collect();
        if nodes.is_empty() {
            let message = match ids.len() {
                0 => format!("node set `{name}` is empty"),
                _ => format!("no node of node set `{name}` belongs to an element"),
            };
            findings.add(Problem::error(path, message, "add nodes to it, or remove this entry"));
            return None;
        }
        Some(nodes)
    }

    /// Returns the index of a node that an element uses.
    pub fn place(&self, id: NodeId) -> Option<usize> {
        self.index.get(&id.label()).copied()
    }

    /// Returns the id of the node with this label in the user's mesh, if an element uses it.
    pub fn labelled(&self, label: u64) -> Option<NodeId> {
        self.index.get(&label).map(|&n| self.mesh.nodes[n].id)
    }

    /// Returns the coordinates at the start of the node with this label [length].
    pub fn coordinates(&self, label: u64) -> Option<[f64; 3]> {
        self.index.get(&label).map(|&n| self.mesh.nodes[n].x)
    }

    /// Returns the ids of a set's nodes that elements use, ascending. Reports an error at `path`
    /// and returns `None` if there is no such set.
    pub fn ids(&self, name: &str, path: String, findings: &mut JobProblems) -> Option<Vec<NodeId>> {
        let nodes = self.indices(name, path, findings)?;
        Some(nodes.into_iter().map(|n| self.mesh.nodes[n].id).collect())
    }
}

impl ElementStart {
    /// Returns the stable step of an element without mass, infinite for all others [time].
    pub fn massless_dt(&self, i: usize) -> f64 {
        if self.mass[i] == 0.0 { self.stable_dt[i] } else { f64::INFINITY }
    }

    /// Returns the mass of an element with mass scaling [mass].
    pub fn mass_with_scaling(&self, i: usize) -> f64 {
        if self.stable_dt[i].is_finite() {
            self.mass[i] * self.mass_factor[i]
        } else {
            self.mass[i]
        }
    }
}

/// Returns the initial state of the nodes from the job's `[[mass]]`, `[[fix]]` and
/// `[[initial_velocity]]`.
pub fn nodes(job: &Job, mesh: &Mesh, sets: &NodeSets<'_>, findings: &mut JobProblems) -> NodeStart {
    let count = mesh.nodes.len();
    let mut start = NodeStart {
        added_mass: vec![0.0; count],
        fixed: vec![0; count],
        velocity: vec![[0.0; 3]; count],
        spin: vec![[0.0; 3]; count],
        timed: HashMap::new(),
    };
    for (i, mass) in job.mass.iter().enumerate() {
        let path = format!("mass.{i}.nodes");
        let Some(nodes) = sets.indices(&mass.nodes, path.clone(), findings) else { continue };
        if nodes.len() < mesh.node_sets[&mass.nodes].len() {
            let message = format!(
                "node set `{}` has nodes that belong to no element and cannot carry mass",
                mass.nodes
            );
            findings.add(Problem::error(
                path,
                message,
                "connect them, or remove them from the set",
            ));
        }
        let each = mass.mass / nodes.len() as f64;
        nodes.iter().for_each(|&n| start.added_mass[n] += each);
    }
    for (i, fix) in job.fix.iter().enumerate() {
        let Some(nodes) = sets.indices(&fix.nodes, format!("fix.{i}.nodes"), findings) else {
            continue;
        };
        let bits = dof_bits(&fix.dofs, &format!("fix.{i}.dofs"), findings);
        nodes.iter().for_each(|&n| start.fixed[n] |= bits);
    }
    for (i, initial) in job.initial_velocity.iter().enumerate() {
        let nodes = match &initial.nodes {
            None => (0..count).collect(),
            Some(name) => match sets.indices(name, format!("initial_velocity.{i}.nodes"), findings)
            {
                Some(nodes) => nodes,
                None => continue,
            },
        };
        let w = initial.spin;
        for n in nodes {
            let r = [0, 1, 2].map(|c| mesh.nodes[n].x[c] - initial.centre[c]);
            let turn =
                [w[1] * r[2] - w[2] * r[1], w[2] * r[0] - w[0] * r[2], w[0] * r[1] - w[1] * r[0]];
            start.velocity[n] = [0, 1, 2].map(|c| initial.velocity[c] + turn[c]);
            start.spin[n] = w;
        }
    }
    for n in 0..count {
        start.hold(n, start.fixed[n]);
    }
    if let Some(n) = start.velocity.iter().position(|v| v.iter().any(|c| !c.is_finite())) {
        let message = format!(
            "the initial velocity of node {} is too large to compute with",
            mesh.nodes[n].id
        );
        findings.add(Problem::error(
            "initial_velocity",
            message,
            "check velocity, spin and centre",
        ));
    }
    start
}

/// Returns masses and stable steps of all elements, with mass scaling to a given step.
pub fn elements(
    job: &Job,
    mesh: &Mesh,
    settings: &Settings,
    blocks: &BuiltElements,
    nodes: &NodeStart,
    findings: &mut JobProblems,
) -> ElementStart {
    let at: FxHashMap<NodeId, [f64; 3]> = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let part_of: FxHashMap<u32, usize> =
        settings.parts.iter().enumerate().map(|(i, p)| (p.id, i)).collect();
    let mut start = ElementStart::default();
    // Numbers of elements, with the first one.
    let (mut unsound, mut massless) = ((0, None), (0, None));
    let mut bodies: Vec<Option<usize>> = Vec::new();
    for element in &mesh.elements {
        let part = part_of[&element.part];
        let Some(formulation) = blocks.element(part, element.shape) else { continue };
        let x = element.nodes.map(|id| at[&id]);
        let mass = formulation.corner_mass(&x, element.own).0 * element.shape.corners() as f64;
        let dt = formulation.stable_dt(&x, element.own);
        let sound = dt.is_finite() && dt > 0.0 && mass.is_finite() && mass > 0.0;
        if element.shape == Shape::Cohesive8 && mass == 0.0 {
            massless = (massless.0 + 1, massless.1.or(Some(element.id)));
        } else if !sound && formulation.discrete().is_none() {
            unsound = (unsound.0 + 1, unsound.1.or(Some(element.id)));
        }
        let wanted = job.time.mass_scaling_dt;
        // The stable step is proportional to the square root of the density.
        let factor = if wanted > dt { (wanted / dt).powi(2) } else { 1.0 };
        let is_rigid =
            |body: &RigidBody| body.window.is_none() && body.parts.contains(&(part as u32));
        let rigid = settings.rigid.iter().position(is_rigid);
        start.part.push(part as u32);
        start.averages.push(formulation.averaged_volume().is_some());
        start.mass.push(mass);
        start.share.push(1.0);
        let idle = rigid.is_some() || settings.parts[part].skin;
        start.mass_factor.push(if idle { 1.0 } else { factor });
        start.stable_dt.push(if idle { f64::INFINITY } else { dt * factor.sqrt() });
        bodies.push(rigid);
    }
    for (b, given) in job.rigid.iter().enumerate().filter_map(|(b, r)| Some((b, r.mass?))) {
        let own: Vec<usize> = (0..bodies.len()).filter(|&e| bodies[e] == Some(b)).collect();
        let factor = given / own.iter().map(|&e| start.mass[e]).sum::<f64>();
        for e in own {
            start.mass[e] *= factor;
            start.mass_factor[e] = factor;
        }
    }
    let middle = |e: &MeshElement| {
        let corners: Vec<[f64; 3]> = e.corners().iter().map(|id| at[id]).collect();
        [0, 1, 2].map(|c| corners.iter().map(|x| x[c]).sum::<f64>() / corners.len() as f64)
    };
    for (b, given) in job.rigid.iter().enumerate().filter_map(|(b, r)| Some((b, r.centre?))) {
        let own: Vec<usize> = (0..bodies.len()).filter(|&e| bodies[e] == Some(b)).collect();
        let masses: Vec<f64> = own.iter().map(|&e| start.mass[e]).collect();
        let points: Vec<[f64; 3]> = own.iter().map(|&e| middle(&mesh.elements[e])).collect();
        let Some(factors) = centre::factors(&masses, &points, given) else {
            let name = &job.rigid[b].name;
            let message =
                format!("the centre of rigid body `{name}` is not inside of its elements");
            let help = "correct `centre`, or remove it and add a [[mass]] that moves the centre";
            findings.add(Problem::error(format!("rigid.{b}.centre"), message, help));
            continue;
        };
        for (e, factor) in own.into_iter().zip(factors) {
            start.mass[e] *= factor;
            start.mass_factor[e] *= factor;
        }
    }
    springs::steps(mesh, settings, blocks, nodes, &mut start, findings);
    let (added, limit) =
        (scaled_mass(&start) / deformable_mass(&start), job.time.mass_scaling_limit);
    if unsound.0 + massless.0 == 0 && added > limit {
        let message =
            format!("mass scaling would add {:.1} % of the structure's mass", 100.0 * added);
        let help = format!(
            "use a shorter step, remesh the small elements, or increase \
             time.mass_scaling_limit (now {limit}) if so much mass is acceptable"
        );
        findings.add(Problem::error("time.mass_scaling_dt", message, help));
    }
    if start.stable_dt.iter().all(|dt| dt.is_infinite()) && settings.dt_max == 0.0 {
        let help = "add dt_max to [time]: rigid bodies and parts with skin = true set no time \
                    step; or add a mesh that deforms, by [[mesh.add]]";
        findings.add(Problem::error("time", "all elements are rigid or have skin = true", help));
    }
    if let (count, Some(first)) = massless {
        let message = match count {
            1 => format!("cohesive element {first} has no thickness, and so no mass"),
            n => format!(
                "{n} cohesive elements have no thickness, and so no mass; the first is element \
                 {first}"
            ),
        };
        let help = "its material has a density per volume: set density_per_area = true (roflg 1 in \
                    a deck) and give a mass per area, or move its two faces apart";
        findings.add(Problem::error("mesh", message, help));
    }
    if let (count, Some(first)) = unsound {
        let message = match count {
            1 => format!("element {first} has no stable time step"),
            n => format!("{n} elements have no stable time step; the first is element {first}"),
        };
        findings.add(Problem::error(
            "mesh",
            message,
            "correct it: it is inverted, or its size, density or stiffness is out of range",
        ));
    }
    start
}

/// Returns the largest `sqrt(E/rho)` of a job's materials, or speed of sound of its fluids
/// [length/time].
pub fn fastest_wave(job: &Job) -> f64 {
    let wave = |m: &MaterialSpec| Some((units::youngs_modulus(m)? / m.density).sqrt());
    let fluids = job.part.iter().filter_map(|p| Some(p.particles.as_ref()?.sound_speed));
    job.material.iter().filter_map(wave).chain(fluids).fold(0.0, f64::max)
}

/// Returns the mass added by mass scaling to all elements [mass].
pub fn scaled_mass(elements: &ElementStart) -> f64 {
    (0..elements.mass.len()).map(|i| elements.mass_with_scaling(i) - elements.mass[i]).sum()
}

/// Returns the mass of the elements with a stable step, without those of rigid bodies, before
/// scaling [mass].
pub fn deformable_mass(elements: &ElementStart) -> f64 {
    elements
        .mass
        .iter()
        .zip(&elements.stable_dt)
        .filter(|(_, dt)| dt.is_finite())
        .map(|(mass, _)| mass)
        .sum()
}

/// Returns the index and value of the first of the smallest values.
pub fn smallest(values: &[f64]) -> Option<(usize, f64)> {
    values.iter().copied().enumerate().min_by(|a, b| a.1.total_cmp(&b.1))
}

/// Returns the shapes in use of each part of the settings, by [`Shape`].
pub fn shapes_in_use(mesh: &Mesh, settings: &Settings) -> Vec<Used> {
    let part_of: HashMap<u32, usize> =
        settings.parts.iter().enumerate().map(|(i, p)| (p.id, i)).collect();
    let mut used = vec![Used::default(); settings.parts.len()];
    for element in &mesh.elements {
        if let Some(&part) = part_of.get(&element.part) {
            used[part][element.shape as usize] = true;
        }
    }
    used
}
