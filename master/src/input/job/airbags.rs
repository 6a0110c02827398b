//! Airbags: checks of their numbers, and their closed surfaces with normals outwards.

use super::loads::{Curves, part_faces};
use super::state::{ElementStart, NodeSets, NodeStart};
use super::validate::JobProblems;
use crumple_proto::airbag::{
    BagFace, BagLaw, GasInflow, GasLaw, GasVent, ResolvedAirbag, VentFlow,
};
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::job::{AirbagInput, InflowInput, Job, VentInput};
use crumple_proto::mesh::{Mesh, once_each};
use crumple_proto::problem::Problem;
use nalgebra::Vector3;
use std::collections::{BTreeMap, HashMap};
use std::f64::consts::PI;

/// Number of open edges that a message names.
const NAMED: usize = 4;
/// Volume over area^(3/2) of a body below which the normals of its elements decide what is inside,
/// if they agree: sheets that cross a little can have a volume of the wrong sign.
const THIN: f64 = 1e-3;
/// The same ratio below which a volume is round-off.
const FLAT: f64 = 1e-9;

/// Resolves all airbags. `smallest` is the shortest side of an element [length].
pub fn resolve(
    job: &Job,
    mesh: &Mesh,
    sets: &NodeSets<'_>,
    curves: &Curves<'_>,
    smallest: f64,
    findings: &mut JobProblems,
) -> Vec<ResolvedAirbag> {
    if job.airbag.is_empty() {
        return Vec::new();
    }
    if job.time.subcycles > 1 {
        let message = "airbags do not work with subcycles: their work would not be that of the gas";
        findings.add(Problem::error("time.subcycles", message, "remove it"));
    }
    let place = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let space = BagSpace { job, mesh, place, smallest };
    let mut bags = Vec::new();
    for (i, bag) in job.airbag.iter().enumerate() {
        let path = format!("airbag.{i}");
        if job.airbag[..i].iter().any(|other| other.name == bag.name) {
            let message = format!("two airbags have the name `{}`", bag.name);
            findings.add(Problem::error(format!("{path}.name"), message, "rename one of them"));
        }
        let law = law(bag, &path, curves, findings);
        let faces =
            part_faces((&bag.parts, &bag.nodes), &path, "airbag", (job, mesh, sets), findings);
        let surface = faces
            .filter(|faces| space.keeps(faces, bag, findings))
            .and_then(|faces| space.close(faces, bag, &path, findings));
        if let (Some(law), Some((faces, origin))) = (law, surface) {
            bags.push(ResolvedAirbag {
                name: bag.name.clone(),
                faces,
                origin,
                added_volume: bag.added_volume,
                ambient_pressure: bag.ambient_pressure,
                law,
            });
        }
    }
    bags
}

/// Reports nodes of airbags without mass of their own, such as tied or rigid ones with massless
/// elements: the step of a bag follows from the masses of its nodes.
pub fn check_masses(
    mesh: &Mesh,
    airbags: &[ResolvedAirbag],
    (elements, nodes): (&ElementStart, &NodeStart),
    findings: &mut JobProblems,
) {
    if airbags.is_empty() {
        return;
    }
    let mut masses: HashMap<NodeId, f64> =
        mesh.nodes.iter().zip(&nodes.added_mass).map(|(n, mass)| (n.id, *mass)).collect();
    let mut corners = HashMap::new();
    for (i, e) in mesh.elements.iter().enumerate() {
        let each = elements.mass_with_scaling(i) / e.shape.corners() as f64;
        for (c, id) in e.corners().iter().enumerate() {
            *masses.entry(*id).or_default() += each * e.shape.mass_share(c);
        }
        corners.insert(e.id, e);
    }
    for (i, bag) in airbags.iter().enumerate() {
        let nodes = bag.faces.iter().flat_map(|f| {
            let e = corners[&f.element];
            e.shape.faces()[usize::from(f.face)].map(|c| e.nodes[c])
        });
        if let Some(node) = nodes.into_iter().find(|n| masses[n] == 0.0) {
            let message = format!("node {node} of airbag `{}` has no mass", bag.name);
            let help = "give its elements a density, or the node a [[mass]]";
            findings.add(Problem::error(format!("airbag.{i}"), message, help));
        }
    }
}

/// Resolves the law of a bag and checks its numbers.
fn law(
    bag: &AirbagInput,
    path: &str,
    curves: &Curves<'_>,
    findings: &mut JobProblems,
) -> Option<BagLaw> {
    let mut numbers = BagNumbers { path, findings };
    numbers.need(bag.added_volume >= 0.0, "added_volume", bag.added_volume, "0 or above");
    numbers.need(
        bag.ambient_pressure >= 0.0,
        "ambient_pressure",
        bag.ambient_pressure,
        "0 or above",
    );
    let laws = [
        bag.cv.is_some() || bag.cp.is_some(),
        bag.inverse_pressure.is_some(),
        !bag.pressure_over_volume.is_empty(),
    ];
    if laws.iter().filter(|given| **given).count() != 1 {
        let message = format!("airbag `{}` has no law of its pressure, or several", bag.name);
        let help = "give exactly one of a gas (`cv`, `cp`), `inverse_pressure` and \
                    `pressure_over_volume`";
        findings.add(Problem::error(path, message, help));
        return None;
    }
    if let (false, Some(key)) = (laws[0], key_of_gas(bag)) {
        let message = format!("`{key}` needs a gas");
        let help = "give its heat capacities `cv` and `cp`, or remove the key";
        findings.add(Problem::error(format!("{path}.{key}"), message, help));
    }
    if bag.curve.is_some() && bag.inverse_pressure.is_none() {
        let message = "`curve` is the factor of `inverse_pressure`, which is not given";
        findings.add(Problem::error(format!("{path}.curve"), message, "remove it"));
    }
    if let Some(pressure) = bag.inverse_pressure {
        let curve = curves.find(&bag.curve, &format!("{path}.curve"), findings);
        return Some(BagLaw::Inverse { pressure, curve });
    }
    if laws[2] {
        points(&bag.pressure_over_volume, &format!("{path}.pressure_over_volume"), findings);
        return Some(BagLaw::Table { points: bag.pressure_over_volume.clone() });
    }
    gas(bag, path, curves, findings).map(BagLaw::Gas)
}

/// Returns the first key of a bag that needs a gas.
fn key_of_gas(bag: &AirbagInput) -> Option<&'static str> {
    let given = [
        ("pressure", bag.pressure.is_some()),
        ("temperature", bag.temperature.is_some()),
        ("inflow", !bag.inflow.is_empty()),
        ("vent", !bag.vent.is_empty()),
    ];
    given.into_iter().find(|(_, given)| *given).map(|(key, _)| key)
}

fn gas(
    bag: &AirbagInput,
    path: &str,
    curves: &Curves<'_>,
    findings: &mut JobProblems,
) -> Option<GasLaw> {
    let (Some(cv), Some(cp), Some(temperature)) = (bag.cv, bag.cp, bag.temperature) else {
        let message = format!("the gas of airbag `{}` is not complete", bag.name);
        let help = "give `cv`, `cp` and `temperature`, that of the gas at the start";
        findings.add(Problem::error(path, message, help));
        return None;
    };
    let pressure = bag.pressure.unwrap_or(bag.ambient_pressure);
    let mut numbers = BagNumbers { path, findings };
    numbers.need(cv > 0.0, "cv", cv, "above 0");
    numbers.need(cp > cv, "cp", cp, "above `cv`");
    numbers.need(temperature > 0.0, "temperature", temperature, "above 0, an absolute temperature");
    numbers.need(pressure >= 0.0, "pressure", pressure, "0 or above, an absolute pressure");
    let inflow = |(k, s): (usize, &InflowInput), findings: &mut JobProblems| {
        let path = format!("{path}.inflow.{k}");
        let mut numbers = BagNumbers { path: &path, findings };
        numbers.need(s.rate >= 0.0, "rate", s.rate, "0 or above");
        numbers.need(s.temperature > 0.0, "temperature", s.temperature, "above 0");
        GasInflow {
            rate: s.rate,
            curve: curves.find_positive(&s.curve, &format!("{path}.curve"), findings),
            temperature: s.temperature,
            temperature_curve: curves.find_positive(
                &s.temperature_curve,
                &format!("{path}.temperature_curve"),
                findings,
            ),
        }
    };
    let inflows = bag.inflow.iter().enumerate().map(|s| inflow(s, findings)).collect();
    let vents = bag.vent.iter().enumerate();
    let vents = vents.filter_map(|(k, v)| vent(v, &format!("{path}.vent.{k}"), curves, findings));
    Some(GasLaw { cv, cp, pressure, temperature, inflows, vents: vents.collect() })
}

fn vent(
    vent: &VentInput,
    path: &str,
    curves: &Curves<'_>,
    findings: &mut JobProblems,
) -> Option<GasVent> {
    let opening_pressure = vent.opening_pressure;
    let mut numbers = BagNumbers { path, findings };
    numbers.need(opening_pressure >= 0.0, "opening_pressure", opening_pressure, "0 or above");
    let curve = curves.find_positive(&vent.curve, &format!("{path}.curve"), findings);
    let (by_area, by_rate) = (&vent.area_over_pressure, &vent.rate_over_pressure);
    let flow = match (vent.area, by_area.is_empty(), by_rate.is_empty()) {
        (Some(area), true, true) => {
            BagNumbers { path, findings }.need(area >= 0.0, "area", area, "0 or above");
            vec![[0.0, area]]
        }
        (None, false, true) => {
            points(by_area, &format!("{path}.area_over_pressure"), findings);
            by_area.clone()
        }
        (None, true, false) => {
            points(by_rate, &format!("{path}.rate_over_pressure"), findings);
            for (key, given) in
                [("coefficient", vent.coefficient.is_some()), ("curve", curve.is_some())]
            {
                if given {
                    let message = format!("`{key}` is for a vent with an area");
                    findings.add(Problem::error(format!("{path}.{key}"), message, "remove it"));
                }
            }
            let flow = VentFlow::Rate { points: by_rate.clone() };
            return Some(GasVent { flow, opening_pressure });
        }
        _ => {
            let message = "a vent has no area or rate, or several";
            let help = "give exactly one of `area`, `area_over_pressure` and `rate_over_pressure`";
            findings.add(Problem::error(path, message, help));
            return None;
        }
    };
    let coefficient = vent.coefficient.unwrap_or(1.0);
    BagNumbers { path, findings }.need(
        coefficient >= 0.0,
        "coefficient",
        coefficient,
        "0 or above",
    );
    Some(GasVent { flow: VentFlow::Orifice { area: flow, coefficient, curve }, opening_pressure })
}

/// Reports points whose abscissae do not ascend, and negative ordinates.
fn points(points: &[[f64; 2]], path: &str, findings: &mut JobProblems) {
    if let Some(k) = points.windows(2).position(|p| p[1][0] <= p[0][0]) {
        let message = format!("{:?} is listed after {:?}", points[k + 1][0], points[k][0]);
        let help = "give the points in ascending order";
        findings.add(Problem::error(format!("{path}.{}", k + 1), message, help));
    }
    if let Some(k) = points.iter().position(|p| p[1] < 0.0) {
        let message = format!("{:?} is below 0", points[k][1]);
        findings.add(Problem::error(format!("{path}.{k}"), message, "give 0 or above"));
    }
}

/// Checks of numbers below a path.
struct BagNumbers<'f> {
    path: &'f str,
    findings: &'f mut JobProblems,
}

impl BagNumbers<'_> {
    fn need(&mut self, right: bool, key: &str, value: f64, wanted: &str) {
        if !right {
            let path = format!("{}.{key}", self.path);
            let message = format!("`{key}` is {value:?}");
            self.findings.add(Problem::error(path, message, format!("it has to be {wanted}")));
        }
    }
}

/// The model around a bag.
struct BagSpace<'j> {
    job: &'j Job,
    mesh: &'j Mesh,
    place: HashMap<NodeId, [f64; 3]>,
    smallest: f64,
}

/// A face with its different nodes in order.
struct Facet {
    face: BagFace,
    nodes: Vec<NodeId>,
}

impl BagSpace<'_> {
    /// Returns the faces of a closed surface with their orientations, and the point from which its
    /// volume is measured. Reports a surface that is not closed.
    fn close(
        &self,
        faces: Vec<(usize, usize)>,
        bag: &AirbagInput,
        path: &str,
        findings: &mut JobProblems,
    ) -> Option<(Vec<BagFace>, [f64; 3])> {
        let mut facets: Vec<Facet> = faces.into_iter().map(|(e, f)| self.facet(e, f)).collect();
        facets.sort_by_key(|f| f.face);
        let edges = edges(&facets);
        let planes = self.check_edges(&edges, bag, path, findings)?;
        let mut origin = self.centre(&facets);
        for (axis, at) in planes {
            origin[axis] = at;
        }
        let turned = match orient(&mut facets, &edges) {
            Some(bodies) => self.turn_outwards(&mut facets, &bodies, origin, bag.normals_inwards),
            None => Err((
                "has one side only".into(),
                "correct the elements: no order of their nodes gives all normals one side",
            )),
        };
        let problem = match turned {
            Ok(volume) if volume + bag.added_volume > 0.0 => {
                count_meeting(&mut facets);
                return Some((facets.into_iter().map(|f| f.face).collect(), origin));
            }
            Ok(volume) => (
                format!("has the volume {volume:.4e} at the start, which has to be above 0"),
                "keep its layers apart, or give it an `added_volume`, such as that of its \
                 inflator; if the normals of its elements point into it, set `normals_inwards`",
            ),
            Err(problem) => problem,
        };
        let message = format!("the surface of airbag `{}` {}", bag.name, problem.0);
        findings.add(Problem::error(path, message, problem.1));
        None
    }

    /// Reports faces of parts that are deleted when the run continues.
    fn keeps(
        &self,
        faces: &[(usize, usize)],
        bag: &AirbagInput,
        findings: &mut JobProblems,
    ) -> bool {
        let deleted = &self.job.restart.delete;
        let of = |&(e, _): &(usize, usize)| self.mesh.elements[e].part;
        let Some(part) = faces.iter().map(of).find(|part| deleted.contains(part)) else {
            return true;
        };
        let message = format!("part {part} belongs to the surface of airbag `{}`", bag.name);
        let help = "leave it out here: a bag without this part would be open";
        findings.add(Problem::error("restart.delete", message, help));
        false
    }

    fn facet(&self, element: usize, face: usize) -> Facet {
        let e = &self.mesh.elements[element];
        let corners = e.shape.faces()[face].map(|c| e.nodes[c]);
        let mut nodes = once_each(&corners).to_vec();
        nodes.dedup();
        if nodes.len() > 1 && nodes.first() == nodes.last() {
            nodes.pop();
        }
        Facet { face: face_of(e.id, face as u8), nodes }
    }

    /// Checks that each edge belongs to two faces, or lies in a plane of symmetry. Returns axis and
    /// coordinate of the planes that close the surface.
    fn check_edges(
        &self,
        edges: &EdgeFaces,
        bag: &AirbagInput,
        path: &str,
        findings: &mut JobProblems,
    ) -> Option<BTreeMap<usize, f64>> {
        let mut planes = BTreeMap::new();
        let (mut open, mut shared) = (Vec::new(), Vec::new());
        for (&edge, of) in edges {
            match of.len() {
                1 => match self.plane_of(edge) {
                    Some((axis, at)) if planes.get(&axis).is_none_or(|known| *known == at) => {
                        planes.insert(axis, at);
                    }
                    _ => open.push(edge),
                },
                2 => {}
                _ => shared.push(edge),
            }
        }
        let named = |edges: &[[NodeId; 2]]| {
            let first = edges.iter().take(NAMED).map(|[a, b]| format!("{a}-{b}"));
            let more = if edges.len() > NAMED { ", ..." } else { "" };
            first.collect::<Vec<_>>().join(", ") + more
        };
        let problem = |edges: &[[NodeId; 2]], what: &str, help: &str| {
            let message = format!(
                "the surface of airbag `{}` is not closed: {} of its edges {what}, between the \
                 nodes {}",
                bag.name,
                edges.len(),
                named(edges)
            );
            Problem::error(path, message, help)
        };
        if !open.is_empty() {
            let help = "add the parts that close it, merge nodes at the same place, or put a \
                        [[symmetry]] plane through the edges";
            findings.add(problem(&open, "are open", help));
            return None;
        }
        if !shared.is_empty() {
            let help = "leave out parts inside the bag, such as tethers";
            findings.add(problem(&shared, "belong to three or more faces", help));
            return None;
        }
        Some(planes)
    }

    /// Returns axis and coordinate of the plane of symmetry in which an edge lies.
    fn plane_of(&self, edge: [NodeId; 2]) -> Option<(usize, f64)> {
        self.job.symmetry.iter().find_map(|plane| {
            let of = |c: usize| plane.normal[c].abs();
            let axis = (0..3).max_by(|&a, &b| of(a).total_cmp(&of(b)))?;
            let reach = super::loads::reach_of_plane(plane, self.smallest);
            let on = |n: &NodeId| (self.place[n][axis] - plane.point[axis]).abs() <= reach;
            edge.iter().all(on).then_some((axis, plane.point[axis]))
        })
    }

    fn at(&self, node: NodeId) -> Vector3<f64> {
        Vector3::from(self.place[&node])
    }

    fn centre(&self, facets: &[Facet]) -> [f64; 3] {
        let nodes = || facets.iter().flat_map(|f| &f.nodes);
        let sum: Vector3<f64> = nodes().map(|&n| self.at(n)).sum();
        (sum / nodes().count().max(1) as f64).into()
    }

    /// Turns all normals out of the gas. Returns its volume [length^3].
    ///
    /// A body inside another one is a hole, a body in a hole is not, and so on. If the volume of a
    /// body is small and the normals of its elements agree, these decide; with `inwards` they point
    /// into the bag.
    fn turn_outwards(
        &self,
        facets: &mut [Facet],
        bodies: &SurfaceBodies,
        origin: [f64; 3],
        inwards: bool,
    ) -> Result<f64, (String, &'static str)> {
        let origin = Vector3::from(origin);
        let mut inside = 0.0;
        let mut turned = vec![false; bodies.mixed.len()];
        for (body, mixed) in bodies.mixed.iter().enumerate() {
            let of = |body: usize| {
                facets.iter().zip(&bodies.of).filter(move |(_, b)| **b == body).map(|f| f.0)
            };
            let (mut volume, mut area) = (0.0, 0.0);
            for facet in of(body) {
                let (v, a) = self.measure(facet, origin);
                (volume, area) = (volume + v, area + a);
            }
            let first = of(body).next().map_or(origin, |facet| self.at(facet.nodes[0]));
            let holds = |other: &usize| {
                let angle: f64 = of(*other).map(|facet| self.solid_angle(facet, first)).sum();
                *other != body && angle.abs() > 2.0 * PI
            };
            let depth = (0..bodies.mixed.len()).filter(holds).count();
            let ratio = volume.abs() / area.powf(1.5);
            turned[body] = if ratio > if *mixed { FLAT } else { THIN } {
                (volume < 0.0) != (depth % 2 == 1)
            } else if *mixed {
                let help = "order the nodes of its elements so that all normals point outwards";
                let message = "is flat at the start, and its elements do not show one side";
                return Err((message.into(), help));
            } else {
                inwards
            };
            inside += if turned[body] { -volume } else { volume };
        }
        for (facet, &body) in facets.iter_mut().zip(&bodies.of) {
            facet.face.inwards ^= turned[body];
        }
        Ok(inside)
    }

    /// Returns the triangles of a fan about the centre of a face, relative to a point, in its
    /// order; for a bilinear face they have its volume.
    fn fan(&self, facet: &Facet, from: Vector3<f64>) -> Vec<[Vector3<f64>; 3]> {
        let mut x: Vec<Vector3<f64>> = facet.nodes.iter().map(|&n| self.at(n) - from).collect();
        if facet.face.inwards {
            x.reverse();
        }
        let centre = x.iter().sum::<Vector3<f64>>() / x.len().max(1) as f64;
        (0..x.len()).map(|k| [centre, x[k], x[(k + 1) % x.len()]]).collect()
    }

    /// Returns the volume between a face and a point, and the area of the face.
    fn measure(&self, facet: &Facet, origin: Vector3<f64>) -> (f64, f64) {
        let of = |[a, b, c]: [Vector3<f64>; 3]| {
            let normal = (b - a).cross(&(c - a)) * 0.5;
            (normal.dot(&a) / 3.0, normal.norm())
        };
        let each = self.fan(facet, origin).into_iter().map(of);
        each.fold((0.0, 0.0), |(v, s), (volume, area)| (v + volume, s + area))
    }

    /// Returns the solid angle of a face at a point (van Oosterom & Strackee 1983, eq. 8).
    fn solid_angle(&self, facet: &Facet, at: Vector3<f64>) -> f64 {
        let of = |[a, b, c]: [Vector3<f64>; 3]| {
            let [la, lb, lc] = [a, b, c].map(|r| r.norm());
            let below = la * lb * lc + a.dot(&b) * lc + b.dot(&c) * la + c.dot(&a) * lb;
            2.0 * a.dot(&b.cross(&c)).atan2(below)
        };
        self.fan(facet, at).into_iter().map(of).sum()
    }
}

/// For each edge, as two nodes in ascending order, its faces and whether they run from the first to
/// the second node.
type EdgeFaces = BTreeMap<[NodeId; 2], Vec<(usize, bool)>>;

fn edges(facets: &[Facet]) -> EdgeFaces {
    let mut edges = EdgeFaces::new();
    for (i, facet) in facets.iter().enumerate() {
        for (k, &a) in facet.nodes.iter().enumerate() {
            let b = facet.nodes[(k + 1) % facet.nodes.len()];
            edges.entry([a.min(b), a.max(b)]).or_default().push((i, a < b));
        }
    }
    edges
}

/// Connected bodies of a surface.
#[derive(Debug, PartialEq)]
struct SurfaceBodies {
    /// Number of the body of each face.
    of: Vec<usize>,
    /// For each body, true if the normals of its elements do not show one side.
    mixed: Vec<bool>,
}

/// Orients all faces of each connected body as its first one; returns `None` if that is
/// impossible.
fn orient(facets: &mut [Facet], edges: &EdgeFaces) -> Option<SurfaceBodies> {
    let mut neighbours: Vec<Vec<(usize, bool)>> = vec![Vec::new(); facets.len()];
    for of in edges.values() {
        if let [(a, a_along), (b, b_along)] = of[..] {
            // Two faces agree if they run along their edge in opposite directions.
            neighbours[a].push((b, a_along == b_along));
            neighbours[b].push((a, a_along == b_along));
        }
    }
    let mut bodies = SurfaceBodies { of: vec![usize::MAX; facets.len()], mixed: Vec::new() };
    for start in 0..facets.len() {
        if bodies.of[start] != usize::MAX {
            continue;
        }
        let body = bodies.mixed.len();
        bodies.mixed.push(false);
        bodies.of[start] = body;
        let mut front = vec![start];
        while let Some(i) = front.pop() {
            for &(j, differs) in &neighbours[i] {
                let inwards = facets[i].face.inwards ^ differs;
                if bodies.of[j] == usize::MAX {
                    bodies.of[j] = body;
                    bodies.mixed[body] |= inwards;
                    facets[j].face.inwards = inwards;
                    front.push(j);
                } else if facets[j].face.inwards != inwards {
                    return None;
                }
            }
        }
    }
    Some(bodies)
}

/// Counts the faces that meet at the nodes of each face.
fn count_meeting(facets: &mut [Facet]) {
    let mut counts: HashMap<NodeId, u32> = HashMap::new();
    for node in facets.iter().flat_map(|f| &f.nodes) {
        *counts.entry(*node).or_default() += 1;
    }
    for facet in facets {
        facet.face.meeting = facet.nodes.iter().map(|n| counts[n]).max().unwrap_or(0);
    }
}

fn face_of(element: ElemId, face: u8) -> BagFace {
    BagFace { element, face, inwards: false, meeting: 0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn facet(id: u64, nodes: [u64; 3]) -> Facet {
        Facet { face: face_of(ElemId(id), 0), nodes: nodes.map(NodeId).to_vec() }
    }

    /// A tetrahedron whose third face is in the wrong order.
    #[test]
    fn faces_in_the_wrong_order_are_turned() {
        let mut facets = vec![
            facet(1, [1, 3, 2]),
            facet(2, [1, 2, 4]),
            facet(3, [2, 4, 3]),
            facet(4, [3, 1, 4]),
        ];
        let edges = edges(&facets);
        assert!(edges.values().all(|of| of.len() == 2));
        let bodies = orient(&mut facets, &edges).expect("two sides");
        assert_eq!(bodies, SurfaceBodies { of: vec![0; 4], mixed: vec![true] });
        let turned: Vec<bool> = facets.iter().map(|f| f.face.inwards).collect();
        assert_eq!(turned, [false, false, true, false]);
        count_meeting(&mut facets);
        assert!(facets.iter().all(|f| f.face.meeting == 3));
    }

    /// A strip of five triangles, joined with half a turn (the Moebius band of five vertices).
    #[test]
    fn a_surface_with_one_side_is_found() {
        let mut facets: Vec<Facet> =
            (0..5).map(|i| facet(i, [i, i + 1, i + 2].map(|n| n % 5))).collect();
        let edges = edges(&facets);
        assert_eq!(orient(&mut facets, &edges), None);
    }
}
