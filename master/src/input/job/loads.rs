//! Loads, prescribed motion and planes of symmetry: checks, and conversion to numbers and ids.

use super::airbags;
use super::state::{ElementStart, NodeSets, NodeStart};
use super::units::read;
use super::validate::{JobProblems, nearest};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::job::{
    BlastInput, Burst, GravityInput, Job, MotionInput, PressureInput, Symmetry,
};
use crumple_proto::loads::{
    Blast, Gravity, MotionForm, NodalForce, PartDamping, PrescribedMotion, Pressure, ResolvedLoads,
};
use crumple_proto::mesh::{Mesh, free_faces};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_worker::blast::range;
use std::collections::{HashMap, HashSet};

/// Names of the degrees of freedom, in the order of their bits.
pub const DOFS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Largest cross component of a direction, as a fraction, for which it counts as parallel to an
/// axis.
const ALONG: f64 = 1e-9;
/// Largest distance of a node from a plane of symmetry on which it lies, as a fraction of the
/// smallest side.
const ON_PLANE: f64 = 1e-3;

/// Returns the bits of named degrees of freedom. Reports every unknown name.
pub fn dof_bits(dofs: &[String], path: &str, findings: &mut JobProblems) -> u64 {
    let mut bits = 0;
    for (place, dof) in dofs.iter().enumerate() {
        match DOFS.iter().position(|known| known == dof) {
            Some(bit) => bits |= 1 << bit,
            None => {
                let message = format!("`{dof}` is not a degree of freedom");
                findings.add(Problem::error(
                    format!("{path}.{place}"),
                    message,
                    nearest(dof, &DOFS),
                ));
            }
        }
    }
    bits
}

/// Resolves all loads and motions of a job. Marks prescribed degrees of freedom and those in
/// planes of symmetry as fixed in `start`. `smallest` is the shortest side of an element
/// [length].
pub fn resolve(
    job: &Job,
    mesh: &Mesh,
    sets: &NodeSets<'_>,
    smallest: f64,
    start: &mut NodeStart,
    findings: &mut JobProblems,
) -> ResolvedLoads {
    symmetry(job, mesh, smallest, start, findings);
    let curves = Curves::new(job, findings);
    let mut loads = ResolvedLoads {
        curves: job.curve.iter().map(|c| c.points.clone()).collect(),
        damping: job.time.damping,
        damping_curve: curves.find_positive(
            &job.time.damping_curve,
            "time.damping_curve",
            findings,
        ),
        ..ResolvedLoads::default()
    };
    if job.time.damping_curve.is_some() && job.time.damping == 0.0 {
        let message = "`damping_curve` has no effect: `damping` is 0";
        let help = "give `time.damping`, on which it is a factor, or remove the curve";
        findings.add(Problem::error("time.damping_curve", message, help));
    }
    if loads.damping < 0.0 {
        let message = format!("`damping` is {:?}", loads.damping);
        findings.add(Problem::error("time.damping", message, "it has to be 0 (none) or above"));
    }
    for (i, g) in job.gravity.iter().enumerate() {
        let curve = curves.find(&g.curve, &format!("gravity.{i}.curve"), findings);
        known_parts(&g.parts, &format!("gravity.{i}"), "gravity", job, findings);
        if let Some(name) = &g.nodes {
            let path = format!("gravity.{i}.nodes");
            if !g.parts.is_empty() {
                let message = "a gravity has both `nodes` and `parts`";
                let help = "remove one of them; two gravities add up";
                findings.add(Problem::error(path.clone(), message, help));
            }
            sets.indices(name, path, findings);
        }
        // Shares follow from the masses of the elements, see `share_masses`.
        loads.gravity.push(Gravity { acceleration: g.acceleration, curve, shares: None });
    }
    for (i, d) in job.damping.iter().enumerate() {
        let path = |key: &str| format!("damping.{i}.{key}");
        let curve = curves.find_positive(&d.curve, &path("curve"), findings);
        if d.parts.is_empty() {
            let help = "name its `parts`; `time.damping` acts on the whole model";
            findings.add(Problem::error(path("parts"), "a damping has no parts", help));
        }
        known_parts(&d.parts, &format!("damping.{i}"), "damping", job, findings);
        let switched = |part: &&u32| {
            job.rigid
                .iter()
                .any(|body| (body.from > 0.0 || body.until.is_some()) && body.parts.contains(part))
        };
        if let Some(part) = d.parts.iter().find(switched) {
            let message = format!("part {part} is rigid for a time, and has a damping of its own");
            let help = "remove the part from the damping; `time.damping` acts on the whole model";
            findings.add(Problem::error(path("parts"), message, help));
        }
        let coefficient = d.coefficient;
        if !(coefficient.is_finite() && coefficient >= 0.0) {
            let message = format!("`coefficient` is {coefficient:?}");
            findings.add(Problem::error(path("coefficient"), message, "give it at 0 or above"));
        }
        loads.part_damping.push(PartDamping { coefficient, curve, ..PartDamping::default() });
    }
    for (i, load) in job.load.iter().enumerate() {
        let curve = curves.find(&load.curve, &format!("load.{i}.curve"), findings);
        if load.force == [0.0; 3] && load.moment == [0.0; 3] {
            let help = "give it a force, a moment or both";
            findings.add(Problem::error(
                format!("load.{i}"),
                "a load has neither force nor moment",
                help,
            ));
        }
        let Some(nodes) = sets.ids(&load.nodes, format!("load.{i}.nodes"), findings) else {
            continue;
        };
        let each = |all: [f64; 3]| all.map(|c| c / nodes.len() as f64);
        loads.forces.push(NodalForce {
            force: each(load.force),
            moment: each(load.moment),
            nodes,
            curve,
        });
    }
    for (i, p) in job.pressure.iter().enumerate() {
        let curve = curves.find(&p.curve, &format!("pressure.{i}.curve"), findings);
        let blast = p.blast.as_ref().and_then(|b| blast(b, i, &job.units, findings));
        if let Some(faces) = loaded_faces(p, i, job, mesh, sets, findings) {
            if let Some(blast) = &blast {
                check_range(blast, &faces, i, (mesh, sets), findings);
            }
            loads.pressures.push(Pressure { faces, pressure: p.pressure, curve, blast });
        }
    }
    loads.airbags = airbags::resolve(job, mesh, sets, &curves, smallest, findings);
    for (i, m) in job.motion.iter().enumerate().filter(|(_, m)| m.rigid.is_none()) {
        loads.motions.extend(motion(m, i, &curves, mesh, sets, start, findings));
    }
    loads
}

/// Indices of curves by name, and start of their factors.
pub struct Curves<'j> {
    names: Vec<&'j str>,
    starts: Vec<Option<f64>>,
    /// First negative factor of each curve.
    negative: Vec<Option<[f64; 2]>>,
}

impl<'j> Curves<'j> {
    fn new(job: &'j Job, findings: &mut JobProblems) -> Self {
        let mut seen = HashSet::new();
        for (i, curve) in job.curve.iter().enumerate() {
            if curve.name.is_empty() {
                let path = format!("curve.{i}.name");
                findings.add(Problem::error(
                    path,
                    "a curve has no name",
                    "give it a name: loads refer to it by name",
                ));
            } else if !seen.insert(&curve.name) {
                let message = format!("two entries of [[curve]] have the name `{}`", curve.name);
                findings.add(Problem::error(
                    format!("curve.{i}.name"),
                    message,
                    "give each its own name",
                ));
            }
            let path = format!("curve.{i}.points");
            if curve.points.is_empty() {
                let message = format!("curve `{}` has no points", curve.name);
                findings.add(Problem::error(path, message, "give points = [[time, factor], ...]"));
            } else if let Some(k) = curve.points.windows(2).position(|p| p[1][0] <= p[0][0]) {
                let (from, to) = (curve.points[k][0], curve.points[k + 1][0]);
                let message =
                    format!("curve `{}`: time {to:?} is listed after {from:?}", curve.name);
                let help =
                    "give times in ascending order; for a jump, give two points a short time apart";
                findings.add(Problem::error(format!("{path}.{}", k + 1), message, help));
            }
        }
        Self::quietly(job)
    }

    /// Returns the value at time 0 of a curve, if there is one with this name.
    pub fn start(&self, name: &str) -> Option<f64> {
        let at = self.names.iter().position(|known| *known == name)?;
        self.starts[at]
    }

    /// Collects the curves without checks.
    pub fn quietly(job: &'j Job) -> Self {
        let start = |points: &[[f64; 2]]| {
            let after = points.partition_point(|p| p[0] <= 0.0);
            match (after.checked_sub(1).map(|i| points[i]), points.get(after)) {
                (Some([t0, y0]), Some([t1, y1])) => Some(y0 - t0 * (y1 - y0) / (t1 - t0)),
                (Some([_, y]), None) => Some(y),
                (None, first) => first.map(|p| p[1]),
            }
        };
        Self {
            names: job.curve.iter().map(|c| c.name.as_str()).collect(),
            starts: job.curve.iter().map(|c| start(&c.points)).collect(),
            negative: job
                .curve
                .iter()
                .map(|c| c.points.iter().copied().find(|p| p[1] < 0.0))
                .collect(),
        }
    }

    /// Returns the index of an optional curve, and reports negative factors of it.
    pub fn find_positive(
        &self,
        name: &Option<String>,
        path: &str,
        findings: &mut JobProblems,
    ) -> Option<usize> {
        let found = self.find(name, path, findings)?;
        if let Some([time, factor]) = self.negative[found] {
            let message =
                format!("curve `{}` has the factor {factor:?} at {time:?}", self.names[found]);
            findings.add(Problem::error(path, message, "its factors have to be 0 or above"));
        }
        Some(found)
    }

    /// Returns the index of an optional curve.
    pub fn find(
        &self,
        name: &Option<String>,
        path: &str,
        findings: &mut JobProblems,
    ) -> Option<usize> {
        let name = name.as_ref()?;
        let found = self.names.iter().position(|n| n == name);
        if found.is_none() {
            findings.add(Problem::error(
                path,
                format!("there is no curve `{name}`"),
                nearest(name, &self.names),
            ));
        }
        found
    }
}

/// Returns an explosion with its mass in kilograms; `None` after an error.
fn blast(b: &BlastInput, i: usize, units: &str, findings: &mut JobProblems) -> Option<Blast> {
    let path = |key: &str| format!("pressure.{i}.blast.{key}");
    let known = b.si.or_else(|| {
        let units = read(units)?;
        Some([[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|powers| units.factor(powers)))
    });
    let Some(si) = known else {
        let message = format!("an explosion needs units, and `units` is \"{units}\"");
        let help = "write units = \"mm, ms, kg\" or others, or blast.si = [metres, seconds, \
                    kilograms] per unit of length, time and mass";
        findings.add(Problem::error(path("si"), message, help));
        return None;
    };
    let positive = |value: f64| value.is_finite() && value > 0.0;
    let mut wrong = Vec::new();
    if !positive(b.mass) {
        wrong.push(("mass", format!("the mass of a charge is {}", b.mass), "give it above 0"));
    }
    if !si.into_iter().all(positive) {
        let help = "give metres, seconds and kilograms per unit, each above 0";
        wrong.push(("si", format!("units are {si:?}"), help));
    }
    if !b.time.is_finite() {
        wrong.push(("time", format!("an explosion is at {}", b.time), "give a time"));
    }
    if !b.position.into_iter().all(f64::is_finite) {
        wrong.push(("position", format!("a charge is at {:?}", b.position), "give three lengths"));
    }
    if !wrong.is_empty() {
        for (key, message, help) in wrong {
            findings.add(Problem::error(path(key), message, help));
        }
        return None;
    }
    let [metre, second, kilogram] = si;
    Some(Blast {
        mass: b.mass * kilogram,
        position: b.position,
        time: b.time,
        on_ground: b.burst == Burst::Ground,
        suction: b.suction,
        si: [metre, second, kilogram / (metre * second * second)],
    })
}

/// Reports faces that are outside of the distances for which the tables of an explosion hold.
fn check_range(
    blast: &Blast,
    faces: &[(ElemId, u8)],
    i: usize,
    (mesh, sets): (&Mesh, &NodeSets<'_>),
    findings: &mut JobProblems,
) {
    let distance = |&(id, face): &(ElemId, u8)| {
        let place = mesh.elements.binary_search_by_key(&id, |element| element.id).ok()?;
        let element = &mesh.elements[place];
        let corners = element.shape.faces()[usize::from(face)].map(|c| element.nodes[c]);
        let x: Vec<[f64; 3]> =
            corners.iter().filter_map(|&n| Some(mesh.nodes[sets.place(n)?].x)).collect();
        let middle = |c: usize| x.iter().map(|x| x[c]).sum::<f64>() / x.len() as f64;
        Some((0..3).map(|c| (middle(c) - blast.position[c]).powi(2)).sum::<f64>().sqrt())
    };
    let [least, most] = range(blast);
    let distances: Vec<f64> = faces.iter().filter_map(distance).collect();
    let near = distances.iter().filter(|&&d| d < least).count();
    let far = distances.iter().filter(|&&d| d > most).count();
    let path = format!("pressure.{i}.blast.position");
    let count = distances.len();
    let help = "check position, mass and units of the charge";
    if far > 0 {
        let message = format!(
            "{far} of {count} faces are farther than {most:.4e} from the charge: an explosion of \
             this mass gives them no pressure"
        );
        findings.add(match far == count {
            true => Problem::error(path.clone(), message, help),
            false => Problem::warning(path.clone(), message, help),
        });
    }
    if near > 0 {
        let message = format!(
            "{near} of {count} faces are nearer than {least:.4e} to the charge: they get the \
             pressure at this distance"
        );
        findings.add(Problem::warning(path, message, help));
    }
}

/// Returns the faces on which a pressure acts, ascending. Reports an error and returns `None` if
/// there are none.
fn loaded_faces(
    p: &PressureInput,
    i: usize,
    job: &Job,
    mesh: &Mesh,
    sets: &NodeSets<'_>,
    findings: &mut JobProblems,
) -> Option<Vec<(ElemId, u8)>> {
    let path = format!("pressure.{i}");
    let faces = part_faces((&p.parts, &p.nodes), &path, "pressure", (job, mesh, sets), findings)?;
    Some(faces.into_iter().map(|(e, f)| (mesh.elements[e].id, f as u8)).collect())
}

/// Returns the faces of some parts, of a node set, or of both, as index of the element and number
/// of the face. `what` names the entry of the job. Reports an error and returns `None` if there
/// are none.
pub fn part_faces(
    (parts, nodes): (&[u32], &Option<String>),
    path: &str,
    what: &str,
    (job, mesh, sets): (&Job, &Mesh, &NodeSets<'_>),
    findings: &mut JobProblems,
) -> Option<Vec<(usize, usize)>> {
    let article = if what.starts_with('a') { "an" } else { "a" };
    if parts.is_empty() && nodes.is_none() {
        let help = "name `parts`, a node set as `nodes`, or both";
        let message = format!("{article} {what} has neither parts nor nodes");
        findings.add(Problem::error(path, message, help));
        return None;
    }
    let known = known_parts(parts, path, what, job, findings);
    let within = match nodes {
        None => None,
        Some(name) => Some(sets.ids(name, format!("{path}.nodes"), findings)?),
    };
    if !known {
        return None;
    }
    let of_part = |part: u32| parts.is_empty() || parts.contains(&part);
    let faces = faces(mesh, of_part, within.as_deref());
    if faces.is_empty() {
        let message =
            format!("{article} {what} acts on no face: no element face has all its nodes there");
        let help = "name a part that has elements, or a set that holds all nodes of each face";
        findings.add(Problem::error(path, message, help));
        return None;
    }
    Some(faces)
}

/// Returns true if the job has all these parts. Reports those that it does not have.
fn known_parts(
    parts: &[u32],
    path: &str,
    what: &str,
    job: &Job,
    findings: &mut JobProblems,
) -> bool {
    let mut known = true;
    for (place, id) in
        parts.iter().enumerate().filter(|(_, id)| !job.part.iter().any(|part| part.id == **id))
    {
        let ids: Vec<String> = job.part.iter().map(|part| part.id.to_string()).collect();
        let ids: Vec<&str> = ids.iter().map(String::as_str).collect();
        let message = format!("{what}: there is no part {id}");
        let help = nearest(&id.to_string(), &ids);
        findings.add(Problem::error(format!("{path}.parts.{place}"), message, help));
        known = false;
    }
    known
}

/// Finds the nodes of gravity and damping of parts, with the fraction of their mass that elements
/// of these parts have, and those of gravity of nodes. The mass of tied nodes counts at the nodes
/// that they follow.
pub fn share_masses(
    job: &Job,
    mesh: &Mesh,
    settings: &mut Settings,
    (elements, nodes): (&ElementStart, &NodeStart),
    findings: &mut JobProblems,
) {
    if !job.gravity.iter().any(GravityInput::is_partial) && job.damping.is_empty() {
        return;
    }
    let place: HashMap<NodeId, usize> =
        mesh.nodes.iter().enumerate().map(|(n, node)| (node.id, n)).collect();
    let masses_of = |of: &dyn Fn(u32) -> bool, added: Option<&[f64]>, at: Option<&[NodeId]>| {
        let mut masses = added.map_or(vec![0.0; mesh.nodes.len()], <[f64]>::to_vec);
        for (i, e) in mesh.elements.iter().enumerate().filter(|(_, e)| of(e.part)) {
            let each = elements.mass_with_scaling(i) / e.shape.corners() as f64;
            for (c, id) in e.corners().iter().enumerate() {
                masses[place[id]] += each * e.shape.mass_share(c);
            }
        }
        if let Some(at) = at {
            let is_in = |n: usize| at.binary_search(&mesh.nodes[n].id).is_ok();
            masses.iter_mut().enumerate().filter(|(n, _)| !is_in(*n)).for_each(|(_, m)| *m = 0.0);
        }
        for tie in &settings.ties {
            let mass = std::mem::take(&mut masses[place[&tie.node]]);
            tie.masters.iter().for_each(|(id, share)| masses[place[id]] += share * mass);
        }
        masses
    };
    let all_masses = Some(&nodes.added_mass[..]);
    let whole = masses_of(&|_| true, all_masses, None);
    let shares_of = |own: Vec<f64>| {
        let share =
            |(n, mass): (usize, &f64)| (*mass > 0.0).then(|| (mesh.nodes[n].id, mass / whole[n]));
        let mut list: Vec<_> = own.iter().enumerate().filter_map(share).collect();
        list.sort_unstable_by_key(|s| s.0);
        list
    };
    let shares = |parts: &[u32]| shares_of(masses_of(&|p| parts.contains(&p), None, None));
    let of_nodes = |name: &String| {
        let at = mesh.node_sets.get(name).map_or(&[][..], |ids| &ids[..]);
        shares_of(masses_of(&|_| true, all_masses, Some(at)))
    };
    let of_one = |g: &GravityInput| match &g.nodes {
        Some(name) => Some(of_nodes(name)),
        None => (!g.parts.is_empty()).then(|| shares(&g.parts)),
    };
    let of_gravity: Vec<_> = job.gravity.iter().map(of_one).collect();
    let of_damping: Vec<_> = job.damping.iter().map(|d| shares(&d.parts)).collect();
    for (gravity, shares) in settings.loads.gravity.iter_mut().zip(of_gravity) {
        gravity.shares = shares;
    }
    let bodies: HashSet<NodeId> =
        settings.rigid.iter().flat_map(|body| body.nodes.iter().copied()).collect();
    for (i, shares) in of_damping.into_iter().enumerate() {
        if shares.is_empty() {
            let message = "a damping acts on nothing: its parts have no mass".to_string();
            let help = "name parts with elements, or remove it";
            findings.add(Problem::warning(format!("damping.{i}.parts"), message, help));
        }
        let damping = &mut settings.loads.part_damping[i];
        (damping.members, damping.shares) = shares.into_iter().partition(|s| bodies.contains(&s.0));
    }
}

/// Returns the faces of shells and outer faces of solids of some parts, as index of the element
/// and number of the face. With a node set, returns only faces whose nodes are all in the set.
pub fn faces(
    mesh: &Mesh,
    of_part: impl Fn(u32) -> bool,
    within: Option<&[NodeId]>,
) -> Vec<(usize, usize)> {
    outer_faces(mesh, &free_faces(&mesh.elements), of_part, within)
}

/// Returns these faces if the free faces of the mesh are already known.
pub fn outer_faces(
    mesh: &Mesh,
    free: &[u16],
    of_part: impl Fn(u32) -> bool,
    within: Option<&[NodeId]>,
) -> Vec<(usize, usize)> {
    let inside = |id: NodeId| within.is_none_or(|set| set.binary_search(&id).is_ok());
    let mut faces = Vec::new();
    for (at, (e, free)) in
        mesh.elements.iter().zip(free).enumerate().filter(|(_, (e, _))| of_part(e.part))
    {
        for (f, corners) in e.shape.faces().iter().enumerate() {
            let outer = e.shape.is_shell() || free >> f & 1 == 1;
            if outer && corners.iter().all(|&c| inside(e.nodes[c])) {
                faces.push((at, f));
            }
        }
    }
    faces
}

/// Resolves a motion without nodes, and returns its degrees of freedom as far as they are given.
pub fn motion_form(
    m: &MotionInput,
    i: usize,
    curves: &Curves<'_>,
    findings: &mut JobProblems,
) -> Option<(PrescribedMotion, Option<u64>)> {
    let path = format!("motion.{i}");
    let curve = curves.find(&m.curve, &format!("{path}.curve"), findings);
    let forms = [
        m.velocity.map(|a| (MotionForm::Velocity, a)),
        m.displacement.map(|a| (MotionForm::Displacement, a)),
        m.acceleration.map(|a| (MotionForm::Acceleration, a)),
        m.spin.map(|a| (MotionForm::Spin { centre: m.centre }, a)),
        m.rotation.map(|a| (MotionForm::Rotation { centre: m.centre }, a)),
    ];
    let mut given = forms.into_iter().flatten();
    let (Some((form, amount)), None) = (given.next(), given.next()) else {
        let message = "a motion has none or several of velocity, displacement, acceleration, spin \
                       and rotation";
        findings.add(Problem::error(path, message, "give exactly one of them"));
        return None;
    };
    let window = window(m, &path, findings);
    if m.birth <= 0.0 && starts_with_jump(form, curves, &m.curve, curve) {
        let message = "a prescribed displacement or rotation starts with a jump";
        findings.add(Problem::error(&path, message, "give it a curve that is 0 at time 0"));
    }
    let dofs = (!m.dofs.is_empty()).then(|| dof_bits(&m.dofs, &format!("{path}.dofs"), findings));
    Some((PrescribedMotion { nodes: Vec::new(), dofs: 0, form, amount, curve, window }, dofs))
}

/// Returns the times of begin and end of a motion that does not act in the whole run.
fn window(m: &MotionInput, path: &str, findings: &mut JobProblems) -> Option<[f64; 2]> {
    if m.birth < 0.0 || m.death.is_some_and(|death| death <= m.birth) {
        let message = format!(
            "a motion begins at {:?} and ends at {:?}",
            m.birth,
            m.death.unwrap_or(f64::INFINITY)
        );
        let help = "give a `birth` of 0 or above, and a `death` above it";
        findings.add(Problem::error(format!("{path}.birth"), message, help));
    }
    let is_whole = m.birth == 0.0 && m.death.is_none();
    (!is_whole).then_some([m.birth, m.death.unwrap_or(f64::MAX)])
}

/// Returns true if a motion is a displacement or rotation that is not 0 at time 0. `index` is that
/// of its curve.
pub fn starts_with_jump(
    form: MotionForm,
    curves: &Curves<'_>,
    name: &Option<String>,
    index: Option<usize>,
) -> bool {
    let first = if name.is_none() { Some(1.0) } else { index.and_then(|c| curves.starts[c]) };
    form.is_place() && first.is_some_and(|y| y != 0.0)
}

/// Resolves a motion of nodes and marks its degrees of freedom as fixed. None of them may be
/// fixed already.
fn motion(
    m: &MotionInput,
    i: usize,
    curves: &Curves<'_>,
    mesh: &Mesh,
    sets: &NodeSets<'_>,
    start: &mut NodeStart,
    findings: &mut JobProblems,
) -> Option<PrescribedMotion> {
    let path = format!("motion.{i}");
    let form = motion_form(m, i, curves, findings);
    let Some(name) = &m.nodes else {
        let help = "name a node set as `nodes`, or a `rigid` body";
        findings.add(Problem::error(&path, "a motion names neither nodes nor a rigid body", help));
        return None;
    };
    let nodes = sets.indices(name, format!("{path}.nodes"), findings)?;
    let (motion, dofs) = form?;
    let all = if motion.form.centre().is_some() { 0b11_1111 } else { 0b111 };
    let dofs = dofs.unwrap_or(all);
    let taken = |n: usize| start.taken(n, dofs, motion.window);
    let clashes: Vec<usize> = nodes.iter().copied().filter(|&n| taken(n) != 0).collect();
    if let Some(&first) = clashes.first() {
        let bits = taken(first);
        let twice = DOFS.iter().enumerate().filter(|(bit, _)| bits & (1 << bit) != 0);
        let twice: Vec<&str> = twice.map(|(_, name)| *name).collect();
        let message = format!(
            "{} nodes are not free to follow a motion; the first is node {} in {}",
            clashes.len(),
            mesh.nodes[first].id,
            twice.join(", ")
        );
        let help = "another motion, a [[fix]] or a [[symmetry]] constrains them: remove them \
                    there, or name other `dofs` here";
        findings.add(Problem::error(&path, message, help));
    }
    nodes.iter().for_each(|&n| start.prescribe(n, dofs, motion.window));
    Some(PrescribedMotion {
        nodes: nodes.iter().map(|&n| mesh.nodes[n].id).collect(),
        dofs,
        ..motion
    })
}

/// Returns the distance from a plane of symmetry within which a node lies on it [length].
pub fn reach_of_plane(plane: &Symmetry, smallest: f64) -> f64 {
    if plane.tolerance > 0.0 { plane.tolerance } else { ON_PLANE * smallest }
}

/// Fixes the degrees of freedom that planes of symmetry constrain.
fn symmetry(
    job: &Job,
    mesh: &Mesh,
    smallest: f64,
    start: &mut NodeStart,
    findings: &mut JobProblems,
) {
    for (i, plane) in job.symmetry.iter().enumerate() {
        let path = format!("symmetry.{i}.normal");
        let largest = plane.normal.iter().fold(0.0f64, |m, c| m.max(c.abs()));
        let small = |c: f64| c.abs() <= ALONG * largest;
        let axis = (0..3).find(|&c| !small(plane.normal[c]));
        let Some(axis) = axis.filter(|&a| (0..3).all(|c| c == a || small(plane.normal[c]))) else {
            let message = format!(
                "the normal {:?} of a plane of symmetry is parallel to no axis",
                plane.normal
            );
            let help = "only [1, 0, 0], [0, 1, 0] and [0, 0, 1] are possible: rotate the model";
            findings.add(Problem::error(path, message, help));
            continue;
        };
        if plane.tolerance < 0.0 {
            let message = format!("`tolerance` is {:?}", plane.tolerance);
            let help = "it has to be 0 (a thousandth of the smallest side) or above";
            findings.add(Problem::error(format!("symmetry.{i}.tolerance"), message, help));
        }
        let tolerance = reach_of_plane(plane, smallest);
        let off = |n: usize| (mesh.nodes[n].x[axis] - plane.point[axis]).abs();
        let on: Vec<usize> = (0..mesh.nodes.len()).filter(|&n| off(n) <= tolerance).collect();
        if on.is_empty() {
            let nearest = (0..mesh.nodes.len()).map(off).fold(f64::INFINITY, f64::min);
            let message =
                format!("no node lies on the plane of symmetry; the nearest is {nearest:.3e} away");
            findings.add(Problem::error(
                format!("symmetry.{i}.point"),
                message,
                "correct its point or tolerance",
            ));
        }
        // The displacement along the normal, and the rotations about the other two axes.
        let bits = (1 << axis) | (0b11_1000 & !(1 << (axis + 3)));
        on.iter().for_each(|&n| start.hold(n, bits));
    }
}
