//! The surface of a tie: search for the face of each tied node, and for nodes near faces between
//! tied nodes.

use super::{Projected, TieContext, failure, name, whole};
use crate::input::job::loads::outer_faces;
use crate::input::job::validate::JobProblems;
use crumple_proto::ids::NodeId;
use crumple_proto::job::TieInput;
use crumple_proto::mesh::{Mesh, MeshElement, Shape, once_each};
use crumple_proto::problem::Problem;
use crumple_proto::tie::Tie;
use crumple_worker::constraints::ties::project::{FaceCorners, Foot, diagonal, feet};
use std::collections::{HashMap, HashSet};

/// Default tolerance, as a fraction of the sum of thicknesses, and of the shorter diagonal of the
/// face.
const OF_THICKNESSES: f64 = 0.6;
const OF_DIAGONAL: f64 = 0.05;
/// Shape value below which it is round-off of the projection.
const NO_SHARE: f64 = 1e-12;

/// The surface of an entry.
pub(super) struct TieSurface<'a> {
    spec: &'a TieInput,
    context: &'a TieContext<'a>,
    /// Element and number of each face.
    faces: Vec<(usize, usize)>,
    /// Nodes of each face, and their places.
    corners: Vec<[NodeId; 4]>,
    places: Vec<FaceCorners>,
    /// Mean centres of the elements of nodes, if ties can fail [length].
    centres: HashMap<NodeId, [f64; 3]>,
}

impl<'a> TieSurface<'a> {
    /// Finds the faces of an entry, if its nodes are known. Reports an entry without a surface.
    pub(super) fn new(
        spec: &'a TieInput,
        entry: usize,
        context: &'a TieContext<'a>,
        with_nodes: bool,
        findings: &mut JobProblems,
    ) -> Option<Self> {
        let TieContext { job, mesh, sets, free, .. } = context;
        if spec.parts.is_empty() && spec.faces.is_none() {
            let help = "name `parts`, a node set as `faces`, or both; or a `node`";
            findings.add(Problem::error(format!("tie.{entry}"), "a tie has no surface", help));
            return None;
        }
        let within = match &spec.faces {
            None => None,
            Some(set) => Some(sets.ids(set, format!("tie.{entry}.faces"), findings)?),
        };
        if !with_nodes {
            return None;
        }
        let of_part = |part: u32| spec.parts.is_empty() || spec.parts.contains(&part);
        let faces = outer_faces(mesh, free, of_part, within.as_deref());
        if faces.is_empty() {
            let message = format!("{}: its surface has no face", name(job, entry));
            let help = "name a part that has shells or solids, or a set that holds all nodes of \
                        each face";
            findings.add(Problem::error(format!("tie.{entry}"), message, help));
            return None;
        }
        let corners: Vec<[NodeId; 4]> = faces.iter().map(|&face| corners_of(mesh, face)).collect();
        let places = corners.iter().map(|c| c.map(|id| context.place(id))).collect();
        let centres = match spec.failure {
            Some(_) => failure::centres(context),
            None => HashMap::new(),
        };
        Some(Self { spec, context, faces, corners, places, centres })
    }

    fn element(&self, face: usize) -> &MeshElement {
        &self.context.mesh.elements[self.faces[face].0]
    }

    fn id(&self, node: usize) -> NodeId {
        self.context.mesh.nodes[node].id
    }

    /// Returns the thickness of a face [length].
    fn face_thickness(&self, face: usize) -> f64 {
        let element = self.element(face);
        match self.spec.thicknesses[1] {
            given if given > 0.0 => given,
            _ if element.shape.is_shell() => shell_thickness(element, &self.context.thick),
            _ => 0.0,
        }
    }

    /// Returns the thickness at a node that is to be tied [length].
    fn node_thickness(&self, node: usize) -> f64 {
        match self.spec.thicknesses[0] {
            given if given > 0.0 => given,
            _ => self.context.shells.get(&self.id(node)).copied().unwrap_or(0.0),
        }
    }

    /// Returns the largest thickness at these nodes [length].
    pub(super) fn thickest(&self, nodes: &[usize]) -> f64 {
        nodes.iter().map(|&n| self.node_thickness(n)).fold(0.0, f64::max)
    }

    /// Returns the distance from a face within which a node of this thickness is tied [length].
    fn reach(&self, face: usize, thickness: f64) -> f64 {
        match self.spec.tolerance {
            given if given > 0.0 => given,
            _ => (OF_THICKNESSES * (self.face_thickness(face) + thickness))
                .max(OF_DIAGONAL * diagonal(&self.places[face])),
        }
    }

    /// Projects nodes onto the nearest face within reach. `thickest` is their largest thickness.
    pub(super) fn project(&self, nodes: &[usize], thickest: f64) -> Vec<Option<Foot>> {
        let points: Vec<[f64; 3]> = nodes.iter().map(|&n| self.context.mesh.nodes[n].x).collect();
        let tolerance =
            |face: usize, p: usize| match self.corners[face].contains(&self.id(nodes[p])) {
                true => -1.0,
                false => self.reach(face, self.node_thickness(nodes[p])),
            };
        feet(&self.places, &points, |face| self.reach(face, thickest), tolerance)
    }

    /// Ties a node at its projection.
    pub(super) fn tied(&self, entry: usize, node: usize, foot: &Foot) -> Projected {
        let (spec, element) = (self.spec, self.element(foot.face));
        let masters = shape_values(&self.corners[foot.face], &foot.shape);
        let turns = masters.iter().all(|c| self.context.turning.contains(&c.0));
        // Members of a rigid body keep their positions.
        let is_rigid = self.context.rigid.contains(&element.part);
        let stays = is_rigid || spec.offset && turns;
        let moved = foot.distance / diagonal(&self.places[foot.face]);
        let centre = self.centres.get(&self.id(node)).copied().unwrap_or(foot.point);
        let facing =
            failure::facing(self.corners[foot.face], &self.places[foot.face], foot.point, centre);
        Projected {
            tie: Tie {
                node: self.id(node),
                masters,
                near: Vec::new(),
                faces: vec![element.id],
                rotations: spec.rotations && turns,
                offset: spec.offset && turns && !is_rigid,
                mean: false,
                failure: failure::strength(spec, facing),
            },
            entry,
            node,
            point: if stays { self.context.mesh.nodes[node].x } else { foot.point },
            moved: if stays { 0.0 } else { moved },
        }
    }

    /// Multiplies limits of stresses by the areas of the nodes. Reports nodes whose limits have no
    /// meaning.
    pub(super) fn scale_limits(
        &self,
        entry: usize,
        projected: &mut [Projected],
        findings: &mut JobProblems,
    ) {
        let own: HashSet<(usize, usize)> = self.faces.iter().copied().collect();
        failure::refuse_without_side(self.context, entry, &self.centres, projected, findings);
        failure::scale(self.context, entry, |face| own.contains(face), projected, findings);
    }

    /// Records which nodes of the surface project onto faces between tied nodes. `thickest` is the
    /// largest thickness at tied nodes [length].
    pub(super) fn face_back(&self, projected: &mut [Projected], thickest: f64) {
        let TieContext { mesh, free, .. } = self.context;
        let mut tied: Vec<NodeId> = projected.iter().map(|s| s.tie.node).collect();
        tied.sort_unstable();
        let mut reach: HashMap<NodeId, f64> = HashMap::new();
        for (face, corners) in self.corners.iter().enumerate() {
            let own = self.reach(face, thickest);
            for &id in corners {
                let most = reach.entry(id).or_insert(own);
                *most = most.max(own);
            }
        }
        let own: HashSet<(usize, usize)> = self.faces.iter().copied().collect();
        let between: Vec<[NodeId; 4]> = outer_faces(mesh, free, |_| true, Some(&tied))
            .into_iter()
            .filter(|face| !own.contains(face))
            .map(|face| corners_of(mesh, face))
            .collect();
        let mut points: Vec<NodeId> =
            reach.keys().copied().filter(|id| tied.binary_search(id).is_err()).collect();
        points.sort_unstable();
        let places: Vec<FaceCorners> =
            between.iter().map(|c| c.map(|id| self.context.place(id))).collect();
        let widest = reach.values().copied().fold(0.0, f64::max);
        let found = feet(
            &places,
            &points.iter().map(|&id| self.context.place(id)).collect::<Vec<_>>(),
            |_| widest,
            |_, p| reach[&points[p]],
        );
        let mut near: HashMap<NodeId, Vec<NodeId>> = HashMap::new();
        for (point, foot) in points.iter().zip(found).filter_map(|(p, foot)| Some((p, foot?))) {
            between[foot.face].iter().for_each(|tied| near.entry(*tied).or_default().push(*point));
        }
        for s in projected {
            s.tie.near = near.remove(&s.tie.node).unwrap_or_default();
            s.tie.near.dedup();
        }
    }
}

/// Returns the nodes of a face, given by element and number.
fn corners_of(mesh: &Mesh, (element, face): (usize, usize)) -> [NodeId; 4] {
    let element = &mesh.elements[element];
    element.shape.faces()[face].map(|c| element.nodes[c])
}

/// Returns the thickness of a shell [length].
fn shell_thickness(e: &MeshElement, thick: &HashMap<u32, f64>) -> f64 {
    if e.own.thickness > 0.0 { e.own.thickness } else { thick.get(&e.part).copied().unwrap_or(0.0) }
}

/// Returns the thickness of the thickest shell at each node [length].
pub(super) fn thickest_shells(mesh: &Mesh, thick: &HashMap<u32, f64>) -> HashMap<NodeId, f64> {
    let mut all: HashMap<NodeId, f64> = HashMap::new();
    for e in mesh.elements.iter().filter(|e| matches!(e.shape, Shape::Quad4 | Shape::Tri3)) {
        let own = shell_thickness(e, thick);
        for &n in e.corners() {
            let most = all.entry(n).or_insert(own);
            *most = most.max(own);
        }
    }
    all
}

/// Returns the shape values of the corners of a face or solid by ascending node, without those of
/// round-off.
pub(super) fn shape_values(corners: &[NodeId], shape: &[f64]) -> Vec<(NodeId, f64)> {
    let mut shares: Vec<(NodeId, f64)> =
        corners.iter().copied().zip(shape.iter().copied()).filter(|s| s.1 > NO_SHARE).collect();
    whole(&mut shares);
    shares
}

/// Returns the corners of each edge of a solid: every edge is in two faces, once in each direction.
fn edges(shape: Shape) -> impl Iterator<Item = (usize, usize)> {
    let around = |face: &'static [usize; 4]| {
        let corners = once_each(face);
        (0..corners.len()).map(move |i| (corners[i], corners[(i + 1) % corners.len()]))
    };
    shape.faces().iter().flat_map(around).filter(|(from, to)| from < to)
}

/// Smallest length of an edge of a solid after its nodes are moved onto a surface, as a fraction
/// of its length before.
const SMALLEST_EDGE: f64 = 0.5;

/// Releases nodes that would flatten solids, such as those between two layers of a weld: of two
/// nodes of an edge whose feet are too near to each other, the one that is farther from its foot.
pub(super) fn keep_solids(mesh: &Mesh, nodes: &[usize], found: &mut [Option<Foot>]) {
    let places: HashMap<NodeId, usize> =
        nodes.iter().enumerate().map(|(p, &n)| (mesh.nodes[n].id, p)).collect();
    let distance =
        |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt();
    for element in mesh.elements.iter().filter(|e| e.shape.is_solid()) {
        let corner = |c: usize| places.get(&element.nodes[c]).copied();
        for (one, other) in edges(element.shape) {
            let (Some(a), Some(b)) = (corner(one), corner(other)) else { continue };
            let (Some(foot), Some(second)) = (&found[a], &found[b]) else { continue };
            let before = distance(mesh.nodes[nodes[a]].x, mesh.nodes[nodes[b]].x);
            if distance(foot.point, second.point) < SMALLEST_EDGE * before {
                let farther = if foot.distance > second.distance { a } else { b };
                found[farther] = None;
            }
        }
    }
}
