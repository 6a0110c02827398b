//! Content of a mesh file, the same for all formats.

use crate::input::exodus::off_axis;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::job::BeamInput;
use crumple_proto::mesh::{Mesh, MeshElement, MeshNode, OwnSection, Shape};
use std::collections::{BTreeMap, HashMap, HashSet};

/// Place in the files that are read.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub struct FilePlace {
    /// Number of the file; 0 for the one that the job names.
    pub file: u32,
    /// Line, from 1; 0 for the file as a whole.
    pub line: u32,
}

/// Node of a file.
#[derive(Clone, Copy, Debug)]
pub struct FileNode {
    /// Id.
    pub id: u64,
    /// Coordinates [length].
    pub x: [f64; 3],
    /// Its place.
    pub place: FilePlace,
}

/// Element of a file.
#[derive(Clone, Debug)]
pub struct FileElement {
    /// Id.
    pub id: u64,
    /// Index of its part.
    pub part: usize,
    /// Shape.
    pub shape: Shape,
    /// Ids of its corners.
    pub corners: Vec<u64>,
    /// Vector towards the second axis of a beam; `None` for the choice of [`off_axis`] [length].
    pub axis: Option<[f64; 3]>,
    /// Values of a shell that replace those of its part.
    pub own: OwnSection,
    /// Its place.
    pub place: FilePlace,
}

/// Part of a file.
#[derive(Clone, Debug, Default)]
pub struct FilePart {
    /// Id.
    pub id: u32,
    /// Name; empty without.
    pub name: String,
    /// Name of its material, if the file has it.
    pub material: Option<String>,
    /// Thickness of its shells, if the file has it [length].
    pub thickness: Option<f64>,
    /// Distance from the nodes of its shells to their middle surface along the normal, over half
    /// the thickness, if the file has one.
    pub offset: Option<f64>,
    /// Section of its beams, if the file has it.
    pub beam: Option<BeamInput>,
    /// True if it is rigid.
    pub rigid: bool,
}

/// Elastic and plastic values of a material, as far as the file has them.
#[derive(Clone, Debug, Default)]
pub struct FileMaterial {
    /// Name.
    pub name: String,
    /// Density [mass/length^3].
    pub density: Option<f64>,
    /// Young's modulus [force/length^2].
    pub youngs_modulus: Option<f64>,
    /// Poisson's ratio.
    pub poisson: Option<f64>,
    /// Plastic strain and yield stress [-, force/length^2]; empty without such a curve.
    pub hardening: Vec<[f64; 2]>,
    /// Rate, plastic strain and yield stress, if the file has curves for several rates
    /// [1/time, -, force/length^2].
    pub hardening_by_rate: Vec<[f64; 3]>,
    /// A, B and n of Johnson and Cook, if the file has them instead of curves
    /// [force/length^2, force/length^2, -].
    pub johnson_cook: Option<[f64; 3]>,
    /// Effect of the rate on the yield stress.
    pub rate: Option<FileRate>,
}

impl FileMaterial {
    /// Returns the name of its law.
    pub fn law(&self) -> &'static str {
        match self.johnson_cook {
            Some(_) => "johnson_cook",
            None if self.hardening.is_empty() && self.hardening_by_rate.is_empty() => "elastic",
            None => "j2",
        }
    }
}

/// Effect of the strain rate on the yield stress of a material.
#[derive(Clone, Debug, PartialEq)]
pub enum FileRate {
    /// C and p: the factor `1 + (rate/C)^(1/p)` [1/time, -].
    CowperSymonds([f64; 2]),
    /// Rates and factors [1/time, -].
    Factors(Vec<[f64; 2]>),
    /// C and the reference rate: the factor `1 + C ln(rate/reference_rate)` [-, 1/time].
    JohnsonCook([f64; 2]),
}

/// Everything that is read from a file.
#[derive(Clone, Debug, Default)]
pub struct FileMesh {
    /// Nodes in the order of the file.
    pub nodes: Vec<FileNode>,
    /// Elements in the order of the file.
    pub elements: Vec<FileElement>,
    /// Parts.
    pub parts: Vec<FilePart>,
    /// Node sets.
    pub node_sets: BTreeMap<String, Vec<u64>>,
    /// Materials.
    pub materials: Vec<FileMaterial>,
    /// End of the analysis, if the file has one [time].
    pub end_time: Option<f64>,
    /// Units, if the file states them, as in a job.
    pub units: Option<String>,
}

impl FileMesh {
    /// Creates it from a mesh whose parts have no other values. The third nodes of beams are left
    /// out: [`FileMesh::to_mesh`] makes them.
    pub fn from_mesh(mesh: &Mesh) -> Self {
        let mut found = FileMesh::default();
        let place = FilePlace::default();
        let has_third = |e: &&MeshElement| e.shape == Shape::Beam2 && e.nodes[2] != e.nodes[1];
        let beams = mesh.elements.iter().filter(has_third);
        let third: HashSet<NodeId> = beams.map(|beam| beam.nodes[2]).collect();
        let nodes = mesh.nodes.iter().filter(|node| !third.contains(&node.id));
        found.nodes.extend(nodes.map(|n| FileNode { id: n.id.0, x: n.x, place }));
        for element in &mesh.elements {
            let part = found.part_with_id(element.part, "");
            let thickness = element.own.thickness;
            let values = &mut found.parts[part];
            values.thickness = values.thickness.or((thickness > 0.0).then_some(thickness));
            let corners = element.corners().iter().map(|n| n.0).collect();
            let (id, shape, own) = (element.id.0, element.shape, element.own);
            found.elements.push(FileElement { id, part, shape, corners, axis: None, own, place });
        }
        for (name, ids) in &mesh.node_sets {
            found.node_sets.insert(name.clone(), ids.iter().map(|n| n.0).collect());
        }
        found
    }

    /// Returns the index of the part with this id. Adds one with this name if there is none.
    pub fn part_with_id(&mut self, id: u32, name: &str) -> usize {
        if let Some(index) = self.parts.iter().position(|part| part.id == id) {
            return index;
        }
        self.parts.push(FilePart { id, name: name.into(), ..FilePart::default() });
        self.parts.len() - 1
    }

    /// Returns the smallest id of a part that is free, from 1.
    pub fn free_part_id(&self) -> u32 {
        let taken: HashSet<u32> = self.parts.iter().map(|part| part.id).collect();
        (1..).find(|id| !taken.contains(id)).unwrap_or(u32::MAX)
    }

    /// Adds a node set. If its name is taken, it gets the second name.
    pub fn add_set(&mut self, name: &str, second: &str, nodes: impl IntoIterator<Item = u64>) {
        let name = if self.node_sets.contains_key(name) { second } else { name };
        let set = self.node_sets.entry(name.into()).or_default();
        set.extend(nodes);
        set.sort_unstable();
        set.dedup();
    }

    /// Removes the nodes that no element has, also from sets, and sets without nodes. Returns the
    /// number of removed nodes and the names of the removed sets.
    pub fn prune(&mut self) -> (usize, Vec<String>) {
        let used: HashSet<u64> = self.elements.iter().flat_map(|e| &e.corners).copied().collect();
        let before = self.nodes.len();
        self.nodes.retain(|node| used.contains(&node.id));
        let mut emptied = Vec::new();
        self.node_sets.retain(|name, ids| {
            ids.retain(|id| used.contains(id));
            if ids.is_empty() {
                emptied.push(name.clone());
            }
            !ids.is_empty()
        });
        (before - self.nodes.len(), emptied)
    }

    /// Gives each part a name of its own: a name that an earlier part has gets the id of its part.
    /// Returns the old name, the id and the new name of each such part.
    pub fn make_names_unique(&mut self) -> Vec<(String, u32, String)> {
        let mut taken: HashSet<String> = self.parts.iter().map(|part| part.name.clone()).collect();
        let mut seen = HashSet::new();
        let mut changed = Vec::new();
        for part in self.parts.iter_mut().filter(|part| !part.name.is_empty()) {
            if seen.insert(part.name.clone()) {
                continue;
            }
            let mut name = format!("{}-{}", part.name, part.id);
            while !taken.insert(name.clone()) {
                name.push('+');
            }
            changed.push((std::mem::replace(&mut part.name, name.clone()), part.id, name));
        }
        changed
    }

    /// Adds the set of its nodes for each part whose name no set has; without a name, it is that of
    /// `part_ID`.
    pub fn add_sets_of_parts(&mut self) {
        let mut nodes: Vec<Vec<u64>> = vec![Vec::new(); self.parts.len()];
        for element in &self.elements {
            nodes[element.part].extend(&element.corners);
        }
        for (index, nodes) in nodes.into_iter().enumerate() {
            let part = &self.parts[index];
            let name = match part.name.is_empty() {
                true => format!("part_{}", part.id),
                false => part.name.clone(),
            };
            if !self.node_sets.contains_key(&name) && !nodes.is_empty() {
                self.add_set(&name, &name, nodes);
            }
        }
    }

    /// Returns the mesh. Each beam gets a node that gives its second axis.
    pub fn to_mesh(&self) -> Mesh {
        let at: HashMap<u64, [f64; 3]> = self.nodes.iter().map(|n| (n.id, n.x)).collect();
        let mut mesh = Mesh::default();
        mesh.nodes.extend(self.nodes.iter().map(|n| MeshNode { id: NodeId(n.id), x: n.x }));
        let mut free = self.nodes.iter().map(|n| n.id).max().unwrap_or(0).saturating_add(1);
        for element in &self.elements {
            let mut corners: Vec<NodeId> = element.corners.iter().copied().map(NodeId).collect();
            if element.shape == Shape::Beam2
                && let [Some(&a), Some(&b)] = [0, 1].map(|c| at.get(&element.corners[c]))
            {
                let x = match element.axis {
                    Some(axis) => std::array::from_fn(|c| a[c] + axis[c]),
                    None => off_axis([a, b]),
                };
                mesh.nodes.push(MeshNode { id: NodeId(free), x });
                corners.push(NodeId(free));
                free = free.saturating_add(1);
            }
            let part = self.parts[element.part].id;
            let whole = MeshElement::new(ElemId(element.id), part, element.shape, &corners);
            mesh.elements.push(MeshElement { own: element.own, ..whole });
        }
        for (name, ids) in &self.node_sets {
            mesh.node_sets.insert(name.clone(), ids.iter().copied().map(NodeId).collect());
        }
        mesh
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The third node of a beam is made from its axis, so that it is no node of the file.
    #[test]
    fn third_nodes_of_beams_are_no_nodes_of_the_file() {
        let at = |id, x| MeshNode { id: NodeId(id), x };
        let nodes =
            vec![at(1, [0.0; 3]), at(2, [1.0, 0.0, 0.0]), at(3, [0.0, 0.0, 1.0]), at(4, [9.0; 3])];
        let beam = MeshElement::new(ElemId(1), 1, Shape::Beam2, &[1, 2, 3].map(NodeId));
        let mesh = Mesh { nodes, elements: vec![beam], ..Mesh::default() };
        let mut found = FileMesh::from_mesh(&mesh);
        assert_eq!(found.nodes.iter().map(|n| n.id).collect::<Vec<_>>(), [1, 2, 4]);
        assert_eq!(found.prune().0, 1);
        assert_eq!(found.to_mesh().nodes.len(), 3);
    }

    /// The second part `a` has the id 2; its new name must not be that of the third part either.
    #[test]
    fn parts_of_one_name_get_their_ids() {
        let mut mesh = FileMesh::default();
        for (id, name) in [(1, "a"), (2, "a"), (3, "a-2"), (4, ""), (5, "")] {
            mesh.part_with_id(id, name);
        }
        assert_eq!(mesh.make_names_unique(), [("a".into(), 2, "a-2+".into())]);
        let names: Vec<&str> = mesh.parts.iter().map(|part| part.name.as_str()).collect();
        assert_eq!(names, ["a", "a-2+", "a-2", "", ""]);
    }
}
