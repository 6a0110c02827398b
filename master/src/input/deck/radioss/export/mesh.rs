//! Writes nodes and elements, part by part.

use super::{Gap, Real, StarterWriter, Whole};
use crate::input::deck::export::beams::third_nodes;
use crumple_proto::ids::ElemId;
use crumple_proto::mesh::{MeshElement, Shape};
use std::collections::{BTreeMap, HashMap};
use toml::{Table, Value};

/// Returns the keyword of a shape.
fn keyword(shape: Shape) -> Option<&'static str> {
    Some(match shape {
        Shape::Quad4 => "SHELL",
        Shape::Tri3 => "SH3N",
        Shape::Hex8 => "BRICK",
        Shape::Tet4 => "TETRA4",
        Shape::Wedge6 => "PENTA6",
        Shape::Beam2 => "BEAM",
        Shape::Truss2 => "TRUSS",
        Shape::Line2 => "SPRING",
        Shape::Tet10 => "TETRA10",
        Shape::Point1 | Shape::Cohesive8 => return None,
    })
}

impl StarterWriter<'_> {
    pub(super) fn mesh(&mut self) {
        let model = self.model;
        self.keyword("NODE");
        for node in &model.mesh.nodes {
            let [x, y, z] = model.given_position(node).map(Real);
            self.card(&[Whole(node.id.label()), x, y, z]);
        }
        let third = third_nodes(model, self.last.node);
        self.last.node += third.len() as u64;
        let mut shown: Vec<(u64, [f64; 3])> = third.values().copied().collect();
        shown.sort_by_key(|node| node.0);
        for (id, x) in std::mem::take(&mut self.added).into_iter().chain(shown) {
            let [x, y, z] = x.map(Real);
            self.card(&[Whole(id), x, y, z]);
        }
        let mut groups: BTreeMap<(u32, usize), Vec<&MeshElement>> = BTreeMap::new();
        let shapes = [
            Shape::Quad4,
            Shape::Tri3,
            Shape::Hex8,
            Shape::Tet4,
            Shape::Tet10,
            Shape::Wedge6,
            Shape::Beam2,
            Shape::Truss2,
            Shape::Line2,
        ];
        for element in &model.mesh.elements {
            let at = shapes.iter().position(|s| *s == element.shape).unwrap_or(0);
            groups.entry((element.part, at)).or_default().push(element);
        }
        for ((part, at), elements) in groups {
            let Some(name) = keyword(shapes[at]) else { continue };
            self.keyword(&format!("{name}/{part}"));
            elements.into_iter().for_each(|element| self.element(element, &third));
        }
        self.offsets();
    }

    fn element(&mut self, element: &MeshElement, third: &HashMap<ElemId, (u64, [f64; 3])>) {
        let mut fields = vec![Whole(element.id.label())];
        let corners = element.corners();
        if element.shape == Shape::Tet10 {
            self.card(&fields);
            return self.card(&element.nodes.map(|n| Whole(n.label())));
        }
        fields.extend(corners.iter().map(|n| Whole(n.label())));
        fields.extend(third.get(&element.id).map(|node| Whole(node.0)));
        if element.own.thickness > 0.0 {
            fields.resize(8, Gap);
            fields.push(Real(element.own.thickness));
        }
        self.card(&fields);
    }

    /// Notes offsets of single shells, for which there is no field.
    fn offsets(&mut self) {
        let own =
            self.model.mesh.elements.iter().filter_map(|e| Some((e.id.label(), e.own.offset?)));
        let rows: Vec<Value> =
            own.map(|(id, offset)| Value::from(vec![id as f64, offset])).collect();
        if !rows.is_empty() {
            let mesh = Table::from_iter([("offsets".to_string(), Value::from(rows))]);
            self.deck.rest.insert("mesh".into(), mesh.into());
        }
    }
}
