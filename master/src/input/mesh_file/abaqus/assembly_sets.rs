//! Sets, surfaces and rigid bodies of the assembly: each id with the instance that it belongs to.

use super::AbaqusModel;
use super::assembly::Placed;
use super::blocks::{AbaqusBlock, DataLine};
use super::scope::{ScopeElement, field, ids_of, is_node_surface, rigid_set, set_name};
use crate::input::mesh_file::content::FilePlace;
use crate::input::mesh_file::reading::{Fate, MeshReading};
use std::cell::OnceCell;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Ids of nodes or elements, each with the index of its scope.
type ScopedIds = Vec<(usize, u64)>;

/// A set of the assembly.
struct AssemblySet {
    /// Name as it is written.
    name: String,
    ids: ScopedIds,
    /// True if the program that wrote the file made it for itself.
    internal: bool,
}

/// Kind of the ids of a set.
#[derive(Clone, Copy, PartialEq, Eq)]
enum IdKind {
    Node,
    Element,
}

/// Sets, surfaces and rigid bodies of the assembly.
pub struct AssemblySets<'a> {
    model: &'a AbaqusModel,
    placed: &'a [Placed<'a>],
    /// Sets by their name in capitals.
    node_sets: BTreeMap<String, AssemblySet>,
    /// The same for elements.
    element_sets: BTreeMap<String, AssemblySet>,
    /// Nodes of surfaces.
    surfaces: BTreeMap<String, AssemblySet>,
    /// Elements of rigid bodies.
    rigid: HashSet<(usize, u64)>,
    /// Elements of each scope by id, for surfaces.
    elements: Vec<OnceCell<HashMap<u64, &'a ScopeElement>>>,
}

impl<'a> AssemblySets<'a> {
    /// Finds the nodes and elements of all sets, surfaces and rigid bodies of the assembly.
    pub fn read(
        model: &'a AbaqusModel,
        placed: &'a [Placed<'a>],
        reading: &mut MeshReading,
    ) -> Self {
        let mut sets = AssemblySets {
            model,
            placed,
            node_sets: BTreeMap::new(),
            element_sets: BTreeMap::new(),
            surfaces: BTreeMap::new(),
            rigid: HashSet::new(),
            elements: placed.iter().map(|_| OnceCell::new()).collect(),
        };
        for block in &model.assembly {
            match block.keyword.as_str() {
                "NSET" => sets.node_set(block, reading),
                "ELSET" => sets.element_set(block, reading),
                "SURFACE" => sets.surface(block, reading),
                _ => {}
            }
        }
        for block in model.assembly.iter().filter(|block| block.keyword == "RIGID BODY") {
            sets.rigid_body(block, reading);
        }
        sets
    }

    /// Returns the elements of rigid bodies: indices of scopes, and ids.
    pub fn rigid(&self) -> &HashSet<(usize, u64)> {
        &self.rigid
    }

    /// Adds the node sets to the mesh. Sets of nodes and elements of one name are one node set.
    pub fn add(&self, reading: &mut MeshReading) {
        let mut found: BTreeMap<&str, Vec<u64>> = BTreeMap::new();
        let shifted = |&(scope, id): &(usize, u64)| self.placed[scope].id(id);
        for set in self.node_sets.values().filter(|set| !set.internal) {
            found.entry(&set.name).or_default().extend(set.ids.iter().map(shifted));
        }
        for set in self.element_sets.values().filter(|set| !set.internal) {
            let nodes = self.nodes_of(&set.ids);
            found.entry(&set.name).or_default().extend(nodes.iter().map(shifted));
        }
        let mut add = |name: &str, second: &str, nodes: Vec<u64>| {
            if nodes.is_empty() {
                reading.row(Fate::Ignored, format!("set {name}"), 1, "it has no nodes");
            } else {
                reading.mesh.add_set(name, second, nodes);
            }
        };
        for (name, nodes) in found {
            add(name, &format!("{name}_assembly"), nodes);
        }
        for set in self.surfaces.values().filter(|set| !set.internal) {
            let nodes = set.ids.iter().map(shifted).collect();
            add(&set.name, &format!("{}_surface", set.name), nodes);
        }
    }

    fn node_set(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let Some(name) = set_name(block, "NSET", reading) else { return };
        let mut ids = self.ids(block, IdKind::Node, reading);
        if let Some(set) = block.value("ELSET") {
            match self.named(set, block, IdKind::Element) {
                Some(elements) => ids.extend(self.nodes_of(&elements)),
                None => no_set(set, block.place, reading),
            }
        }
        self.check_nodes(block, name, &ids, reading);
        extend(&mut self.node_sets, block, name, ids);
    }

    /// Reports the nodes of a set that are missing, with the numbers of the file.
    fn check_nodes(
        &self,
        block: &AbaqusBlock,
        name: &str,
        ids: &ScopedIds,
        reading: &mut MeshReading,
    ) {
        let is_missing = |&&(scope, id): &&(usize, u64)| {
            let one = &self.placed[scope];
            !one.has_node(id) && !reading.is_reported(one.id(id))
        };
        let missing: ScopedIds = ids.iter().filter(is_missing).copied().collect();
        let own: Vec<u64> = missing.iter().map(|&(_, id)| id).collect();
        reading.set_lacks(name, &own, block.place);
        reading.reported(missing.iter().map(|&(scope, id)| self.placed[scope].id(id)));
    }

    fn element_set(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let Some(name) = set_name(block, "ELSET", reading) else { return };
        let ids = self.ids(block, IdKind::Element, reading);
        extend(&mut self.element_sets, block, name, ids);
    }

    fn surface(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let Some(name) = set_name(block, "NAME", reading) else { return };
        let mut nodes = Vec::new();
        for line in &block.data {
            let kind = if is_node_surface(block) { IdKind::Node } else { IdKind::Element };
            let text = field(line, 0);
            let ids = match text.parse::<u64>() {
                Ok(id) => self.scoped(vec![id], block, kind, line.place, reading),
                Err(_) => self.named(text, block, kind).unwrap_or_else(|| {
                    let message = format!("surface: there is no set `{text}`");
                    reading.error("no set", line.place, message, "define it before the surface");
                    Vec::new()
                }),
            };
            match kind {
                IdKind::Node => nodes.extend(ids),
                IdKind::Element => nodes.extend(self.faces(&ids, line, reading)),
            }
        }
        self.check_nodes(block, name, &nodes, reading);
        extend(&mut self.surfaces, block, name, nodes);
    }

    /// Returns the nodes of the faces that a line of a surface names.
    fn faces(&self, ids: &ScopedIds, line: &DataLine, reading: &mut MeshReading) -> ScopedIds {
        let mut nodes = Vec::new();
        for (scope, ids) in by_scope(ids) {
            let own = self.placed[scope].scope;
            let by_id = self.elements[scope].get_or_init(|| own.elements_by_id());
            let found = super::scope::nodes_of_faces(by_id, &ids, line, reading);
            nodes.extend(found.into_iter().map(|id| (scope, id)));
        }
        nodes
    }

    fn rigid_body(&mut self, block: &AbaqusBlock, reading: &mut MeshReading) {
        let Some(set) = rigid_set(block, reading) else { return };
        match self.named(set, block, IdKind::Element) {
            Some(ids) => self.rigid.extend(ids),
            None => no_set(set, block.place, reading),
        }
    }

    fn nodes_of(&self, elements: &ScopedIds) -> ScopedIds {
        let of = |(scope, ids): (usize, Vec<u64>)| {
            let nodes = self.placed[scope].scope.nodes_of(&ids);
            nodes.into_iter().map(move |id| (scope, id))
        };
        by_scope(elements).into_iter().flat_map(of).collect()
    }

    /// Returns the ids of the lines of a set.
    fn ids(&self, block: &AbaqusBlock, kind: IdKind, reading: &mut MeshReading) -> ScopedIds {
        if block.has("GENERATE") {
            let ids = ids_of(block, &BTreeMap::new(), reading);
            return self.scoped(ids, block, kind, block.place, reading);
        }
        let (mut numbers, mut found) = (Vec::new(), Vec::new());
        for line in &block.data {
            for text in line.fields.iter().filter(|text| !text.is_empty()) {
                if let Ok(id) = text.parse::<u64>() {
                    numbers.push(id);
                    continue;
                }
                let Some(ids) = self.named(text, block, kind) else {
                    let message = format!("`{text}` is no id and no set that was defined before");
                    reading.error("no set", line.place, message, super::scope::SET_HELP);
                    continue;
                };
                if !reading.has_room(ids.len(), line.place) {
                    return found;
                }
                found.extend(ids);
            }
        }
        if !numbers.is_empty() || block.has("INSTANCE") {
            found.extend(self.scoped(numbers, block, kind, block.place, reading));
        }
        found
    }

    /// Returns ids with the scope that the block means. Reports an error if there is none.
    fn scoped(
        &self,
        ids: Vec<u64>,
        block: &AbaqusBlock,
        kind: IdKind,
        place: FilePlace,
        reading: &mut MeshReading,
    ) -> ScopedIds {
        if let Some(scope) = self.scope_of(block, kind) {
            return ids.into_iter().map(|id| (scope, id)).collect();
        }
        match block.value("INSTANCE") {
            None => {
                let message =
                    format!("*{} has ids, and it is open of which instance", block.keyword);
                let help = "add INSTANCE=NAME, or name a set of an instance";
                reading.error("instance", place, message, help);
            }
            Some(name) if self.model.has_instance(name) => {
                let what = format!("*{} of instance {name}", block.keyword);
                reading.row(Fate::Ignored, what, 1, "the instance has no mesh");
            }
            Some(name) => {
                let message = format!("*{}: there is no instance `{name}`", block.keyword);
                let help = "correct INSTANCE=, or add the instance";
                reading.error("instance", place, message, help);
            }
        }
        Vec::new()
    }

    /// Returns the scope of a block: that of its instance, or without one that of the assembly, or
    /// the only one.
    fn scope_of(&self, block: &AbaqusBlock, kind: IdKind) -> Option<usize> {
        let has_ids = |one: &Placed| match kind {
            IdKind::Node => !one.scope.nodes.is_empty(),
            IdKind::Element => !one.scope.elements.is_empty(),
        };
        let find = |fits: &dyn Fn(&Placed) -> bool| self.placed.iter().position(fits);
        if let Some(name) = block.value("INSTANCE") {
            return find(&|one| one.name.eq_ignore_ascii_case(name) && !name.is_empty());
        }
        find(&|one| one.name.is_empty() && has_ids(one)).or_else(|| {
            let several = self.placed.iter().filter(|one| has_ids(one)).count() > 1;
            find(&has_ids).filter(|_| !several)
        })
    }

    /// Returns the ids of a set that is given by its name, or as `INSTANCE.NAME`; `None` if there
    /// is none.
    fn named(&self, text: &str, block: &AbaqusBlock, kind: IdKind) -> Option<ScopedIds> {
        let upper = text.to_uppercase();
        let of_assembly = || {
            let sets = match kind {
                IdKind::Node => &self.node_sets,
                IdKind::Element => &self.element_sets,
            };
            sets.get(&upper).map(|set| set.ids.clone())
        };
        let of_scope = |scope: usize, name: &str| {
            let own = self.placed[scope].scope;
            let sets = match kind {
                IdKind::Node => &own.node_sets,
                IdKind::Element => &own.element_sets,
            };
            let ids = sets.get(name)?.ids.iter();
            Some(ids.map(|&id| (scope, id)).collect::<ScopedIds>())
        };
        let of_default = || of_scope(self.scope_of(block, kind)?, &upper);
        let found = match block.has("INSTANCE") {
            true => of_default().or_else(of_assembly),
            false => of_assembly().or_else(of_default),
        };
        found.or_else(|| {
            self.placed.iter().enumerate().find_map(|(scope, one)| {
                let start = format!("{}.", one.name.to_uppercase());
                let rest = upper.strip_prefix(&start).filter(|_| !one.name.is_empty())?;
                match rest.parse::<u64>() {
                    Ok(id) => Some(vec![(scope, id)]),
                    Err(_) => of_scope(scope, rest),
                }
            })
        })
    }
}

/// Adds ids to a set of the assembly: a set of several instances has a block for each.
fn extend(
    sets: &mut BTreeMap<String, AssemblySet>,
    block: &AbaqusBlock,
    name: &str,
    ids: ScopedIds,
) {
    let internal = block.has("INTERNAL");
    let new = || AssemblySet { name: name.into(), ids: Vec::new(), internal };
    let set = sets.entry(name.to_uppercase()).or_insert_with(new);
    set.ids.extend(ids);
    set.ids.sort_unstable();
    set.ids.dedup();
}

fn by_scope(ids: &ScopedIds) -> BTreeMap<usize, Vec<u64>> {
    let mut found: BTreeMap<usize, Vec<u64>> = BTreeMap::new();
    for &(scope, id) in ids {
        found.entry(scope).or_default().push(id);
    }
    found
}

fn no_set(set: &str, place: FilePlace, reading: &mut MeshReading) {
    let message = format!("there is no element set `{set}`");
    reading.error("no set", place, message, "define it before this line, or correct ELSET=");
}
