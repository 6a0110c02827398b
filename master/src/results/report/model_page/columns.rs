//! The mesh of a job as a state without results, and the values of its elements and nodes.
//!
//! Order of the bytes: the scalars of elements, then those of nodes (bits of f32, each minus the
//! one before); for each node set the places of its nodes in the picture (u32, each minus the one
//! before); then the marks of the conditions, see [`super::conditions`]. `model.js` is the decoder.

use super::super::encode::PackedColumns;
use super::super::scene::PageScene;
use super::super::series::{CellShape, FieldFrame, MeshSeries, SeriesElement};
use super::UnitNames;
use crate::input::job::Model;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{Mesh, MeshElement, Shape};
use crumple_proto::quality::{ElementQuality, measure};
use crumple_worker::contact::diagnostics::initial_penetration::Penetration;
use serde_json::{Value, json};
use std::collections::HashMap;

/// A value of each element or node of the mesh, not a number where there is none.
pub struct ModelScalar {
    /// Title on the page.
    pub title: &'static str,
    /// Unit, empty if it has none or if the job states none.
    pub unit: String,
    /// True if small values are the ones to look at.
    pub is_worst_low: bool,
    /// Values, in the order of the mesh.
    pub values: Vec<f64>,
}

/// All values of elements and of nodes.
pub struct ModelColumns {
    elements: Vec<ModelScalar>,
    nodes: Vec<ModelScalar>,
}

/// Returns the mesh as a series with one state.
pub fn series(model: &Model) -> MeshSeries {
    let mesh = &model.mesh;
    let place: HashMap<_, u32> = mesh.nodes.iter().zip(0..).map(|(n, i)| (n.id, i)).collect();
    let element = |e: &MeshElement| SeriesElement {
        shape: shape(e.shape),
        corners: e.nodes.map(|id| place[&id]),
        part: e.part,
        id: e.id.label(),
    };
    let frame = FieldFrame {
        position: mesh.nodes.iter().map(|n| n.x.map(|c| c as f32)).collect(),
        state: vec![1; mesh.elements.len()],
        ..FieldFrame::default()
    };
    MeshSeries {
        elements: mesh.elements.iter().map(element).collect(),
        node_ids: mesh.nodes.iter().map(|n| n.id.label()).collect(),
        frames: vec![frame],
        written: 1,
        unknown_shapes: 0,
    }
}

fn shape(shape: Shape) -> CellShape {
    match shape {
        Shape::Quad4 => CellShape::Quad,
        Shape::Tri3 => CellShape::Triangle,
        Shape::Hex8 | Shape::Cohesive8 => CellShape::Hexahedron,
        Shape::Tet4 => CellShape::Tetrahedron,
        Shape::Wedge6 => CellShape::Wedge,
        Shape::Tet10 => CellShape::QuadraticTetrahedron,
        Shape::Line2 | Shape::Beam2 | Shape::Truss2 => CellShape::Line,
        Shape::Point1 => CellShape::Point,
    }
}

impl ModelColumns {
    /// Computes all values.
    pub(super) fn new(model: &Model, penetrations: &[Penetration], units: &UnitNames) -> Self {
        Self { elements: of_elements(model, units), nodes: of_nodes(model, penetrations, units) }
    }

    /// Adds the values of the elements and nodes of a scene, and describes them: of elements, of
    /// nodes.
    pub fn pack(&self, scene: &PageScene, out: &mut PackedColumns) -> [Vec<Value>; 2] {
        let mut pack = |scalar: &ModelScalar, places: &[u32]| {
            let values = places.iter().map(|&p| scalar.values[p as usize] as f32);
            out.chain(values.clone().map(f32::to_bits));
            let range = values.filter(|v| v.is_finite()).fold(None, |range, v| {
                Some(range.map_or([v; 2], |[low, high]: [f32; 2]| [low.min(v), high.max(v)]))
            });
            json!({
                "title": scalar.title,
                "unit": scalar.unit,
                "worst_low": scalar.is_worst_low,
                "range": range,
            })
        };
        let elements = self.elements.iter().map(|s| pack(s, &scene.elements)).collect();
        [elements, self.nodes.iter().map(|s| pack(s, &scene.nodes)).collect()]
    }
}

/// Returns the values of elements: thickness, step, scaled mass, quality.
fn of_elements(model: &Model, units: &UnitNames) -> Vec<ModelScalar> {
    let (mesh, start) = (&model.mesh, &model.elements);
    let at: HashMap<_, [f64; 3]> = mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let all = 0..mesh.elements.len();
    let thickness = |e: usize| {
        let element = &mesh.elements[e];
        match (element.shape.is_shell(), element.own.thickness > 0.0) {
            (false, _) => f64::NAN,
            (true, true) => element.own.thickness,
            (true, false) => model.settings.parts[start.part[e] as usize].thickness,
        }
    };
    let quality = |e: usize| {
        let element = &mesh.elements[e];
        let x: Vec<[f64; 3]> = element.corners().iter().map(|id| at[id]).collect();
        let has_faces = element.shape.is_shell() || element.shape.is_solid();
        has_faces.then(|| measure(element, &x))
    };
    let qualities: Vec<Option<ElementQuality>> = all.clone().map(quality).collect();
    let of_quality = |value: fn(&ElementQuality) -> f64| -> Vec<f64> {
        qualities.iter().map(|q| q.as_ref().map_or(f64::NAN, value)).collect()
    };
    let scalar = |title, unit: &str, is_worst_low, values| ModelScalar {
        title,
        unit: unit.into(),
        is_worst_low,
        values,
    };
    let steps = start.stable_dt.iter().map(|dt| model.settings.safety * dt).collect();
    let mut scalars = vec![
        scalar("thickness", &units.length, false, all.clone().map(thickness).collect()),
        scalar("time step", &units.time, true, steps),
        scalar("aspect ratio", "", false, of_quality(|q| q.aspect)),
        scalar("warpage", "degrees", false, of_quality(|q| q.warpage_deg)),
        scalar("Jacobian ratio", "", true, of_quality(|q| q.jacobian)),
        scalar("skew", "degrees", false, of_quality(|q| q.skew_deg)),
    ];
    if model.scaled_mass() > 0.0 {
        let added = all.map(|e| 100.0 * (start.mass_with_scaling(e) / start.mass[e] - 1.0));
        scalars.push(scalar("mass added by scaling", "%", false, added.collect()));
    }
    scalars
}

/// Returns the values of nodes: velocity, added mass, initial penetration.
fn of_nodes(model: &Model, penetrations: &[Penetration], units: &UnitNames) -> Vec<ModelScalar> {
    let nodes = &model.nodes;
    let scalar = |title, unit: &str, values| ModelScalar {
        title,
        unit: unit.into(),
        is_worst_low: false,
        values,
    };
    let speeds = nodes.velocity.iter().map(|v| v.iter().map(|c| c * c).sum::<f64>().sqrt());
    let mut scalars = vec![scalar("initial velocity", &units.velocity, speeds.collect())];
    if model.lumped_mass() > 0.0 {
        scalars.push(scalar("lumped mass", &units.mass, nodes.added_mass.clone()));
    }
    if !penetrations.is_empty() {
        let depth: HashMap<_, f64> = penetrations.iter().map(|p| (p.node, p.depth)).collect();
        let depths =
            model.mesh.nodes.iter().map(|n| depth.get(&n.id).copied().unwrap_or(0.0)).collect();
        scalars.push(scalar("initial penetration", &units.length, depths));
    }
    scalars
}

/// Adds the node sets as places in the scene, and describes them.
pub fn pack_sets(mesh: &Mesh, scene: &PageScene, out: &mut PackedColumns) -> Vec<Value> {
    let place: HashMap<u64, u32> =
        mesh.nodes.iter().zip(0..).map(|(n, i)| (n.id.label(), i)).collect();
    let pack = |(name, ids): (&String, &Vec<NodeId>)| {
        let places = ids.iter().filter_map(|id| place.get(&id.label()));
        let shown = in_scene(places.copied(), &scene.nodes);
        out.chain(shown.iter().copied());
        json!({ "name": name, "count": ids.len(), "marks": shown.len() })
    };
    mesh.node_sets.iter().map(pack).collect()
}

/// Returns the places in a scene, whose nodes are ascending, of nodes of the mesh, ascending.
pub fn in_scene(nodes: impl Iterator<Item = u32>, scene: &[u32]) -> Vec<u32> {
    let mut places: Vec<u32> =
        nodes.filter_map(|n| scene.binary_search(&n).ok()).map(|place| place as u32).collect();
    places.sort_unstable();
    places
}
