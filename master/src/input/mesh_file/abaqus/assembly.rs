//! From parts and instances to one mesh with parts, sets and sections.

use super::AbaqusModel;
use super::assembly_sets::AssemblySets;
use super::blocks::AbaqusBlock;
use super::scope::{MeshScope, ScopeElement, foreign_id, number_of};
use super::sections::{SectionBlock, is_general};
use crate::input::mesh_file::boundary::{CellGroup, bounding};
use crate::input::mesh_file::cells::{Cell, CellUse};
use crate::input::mesh_file::content::FileNode;
use crate::input::mesh_file::reading::{Fate, MeshReading, NODE_HELP};
use crate::input::mesh_file::systems::{cross, dot};
use crumple_proto::job::{BeamInput, BeamSection};
use std::collections::{BTreeMap, HashMap, HashSet};

/// An instance of a part: its place in space, and what it defines itself.
pub struct InstanceBlock {
    pub name: String,
    part: String,
    shift: [f64; 3],
    /// Two points of an axis, and an angle [degree].
    turn: Option<[f64; 7]>,
    place: crate::input::mesh_file::content::FilePlace,
    pub own: MeshScope,
}

impl InstanceBlock {
    /// Reads the place of an instance.
    pub fn new(block: &AbaqusBlock, reading: &mut MeshReading) -> Self {
        let of = |name: &str| block.value(name).unwrap_or_default().to_string();
        let mut instance = InstanceBlock {
            name: of("NAME"),
            part: of("PART"),
            shift: [0.0; 3],
            turn: None,
            place: block.place,
            own: MeshScope::default(),
        };
        for (index, line) in block.data.iter().enumerate().take(2) {
            let count = if index == 0 { 3 } else { 7 };
            let mut numbers = [0.0; 7];
            for (place, number) in numbers.iter_mut().enumerate().take(count) {
                match number_of(line, place) {
                    Ok(value) => *number = value.unwrap_or(0.0),
                    Err(text) => {
                        let message =
                            format!("instance `{}`: `{text}` is no number", instance.name);
                        let help = "write x, y, z, and in a second line the axis and its angle";
                        reading.error("instance", line.place, message, help);
                    }
                }
            }
            match index {
                0 => instance.shift.copy_from_slice(&numbers[..3]),
                _ => instance.turn = Some(numbers),
            }
        }
        instance
    }

    /// Returns the position of a point of its part.
    fn position(&self, x: [f64; 3]) -> [f64; 3] {
        let moved: [f64; 3] = std::array::from_fn(|c| x[c] + self.shift[c]);
        let Some([ax, ay, az, bx, by, bz, degrees]) = self.turn else { return moved };
        let (start, axis) = ([ax, ay, az], [bx - ax, by - ay, bz - az]);
        let length = dot(axis, axis).sqrt();
        if length == 0.0 {
            return moved;
        }
        let k = axis.map(|c| c / length);
        let r: [f64; 3] = std::array::from_fn(|c| moved[c] - start[c]);
        let (sin, cos) = degrees.to_radians().sin_cos();
        let (across, along) = (cross(k, r), dot(k, r));
        // Rodrigues' formula.
        std::array::from_fn(|c| {
            start[c] + r[c] * cos + across[c] * sin + k[c] * along * (1.0 - cos)
        })
    }
}

/// A scope at its place in the mesh.
pub struct Placed<'a> {
    pub scope: &'a MeshScope,
    instance: Option<&'a InstanceBlock>,
    /// Name of its instance or part; empty for the assembly and for a file without parts.
    pub name: String,
    /// Prefix of the names of sets.
    prefix: String,
    /// Number that is added to the ids of nodes and elements.
    shift: u64,
    /// Places of its own nodes in the list of the scope.
    own: HashMap<u64, usize>,
    /// Nodes of other scopes that its elements have, by the ids that stand for them.
    foreign: HashMap<u64, FileNode>,
}

impl Placed<'_> {
    /// Returns the id of one of its nodes or elements in the mesh.
    pub fn id(&self, own: u64) -> u64 {
        match self.foreign.get(&own) {
            Some(node) => node.id,
            None if foreign_id(self.scope.foreign.len()) < own => own,
            None => own.saturating_add(self.shift),
        }
    }

    /// Returns true if it has a node.
    pub fn has_node(&self, id: u64) -> bool {
        self.own.contains_key(&id) || self.foreign.contains_key(&id)
    }

    /// Returns one of its own nodes as it is in the mesh.
    fn node(&self, own: u64) -> Option<FileNode> {
        Some(self.in_mesh(&self.scope.nodes[*self.own.get(&own)?]))
    }

    fn in_mesh(&self, node: &FileNode) -> FileNode {
        let x = self.instance.map_or(node.x, |instance| instance.position(node.x));
        FileNode { id: self.id(node.id), x, place: node.place }
    }

    /// Returns a direction of its part in space.
    fn turned(&self, axis: [f64; 3]) -> [f64; 3] {
        let Some(instance) = self.instance else { return axis };
        let (end, start) = (instance.position(axis), instance.position([0.0; 3]));
        std::array::from_fn(|c| end[c] - start[c])
    }
}

/// Adds everything to the mesh.
pub fn assemble(model: AbaqusModel, reading: &mut MeshReading) {
    let mut placed = placed(&model, reading);
    placed.iter().for_each(|one| add_nodes(one, reading));
    reading.check_nodes();
    find_foreign(&model, &mut placed, reading);
    check_missing(&placed, !model.instances.is_empty(), reading);
    let sets = AssemblySets::read(&model, &placed, reading);
    let mut parts = PartTable { known: BTreeMap::new(), rigid: sets.rigid() };
    for (index, one) in placed.iter().enumerate() {
        parts.add_elements(index, one, reading);
        for set in one.scope.node_sets.values().filter(|set| !set.internal) {
            let name = format!("{}{}", one.prefix, set.name);
            let second = format!("{name}_nodes");
            reading.mesh.add_set(&name, &second, set.ids.iter().map(|id| one.id(*id)));
        }
        for set in one.scope.element_sets.values().filter(|set| !set.internal) {
            let name = format!("{}{}", one.prefix, set.name);
            let second = format!("{name}_elements");
            let nodes = one.scope.nodes_of(&set.ids);
            reading.mesh.add_set(&name, &second, nodes.iter().map(|id| one.id(*id)));
        }
    }
    sets.add(reading);
}

/// Returns all scopes with nodes or elements and their places.
fn placed<'a>(model: &'a AbaqusModel, reading: &mut MeshReading) -> Vec<Placed<'a>> {
    let mut found: Vec<(&MeshScope, Option<&InstanceBlock>, String)> = Vec::new();
    found.push((&model.model, None, String::new()));
    for instance in &model.instances {
        let part = model.parts.iter().find(|p| p.name.eq_ignore_ascii_case(&instance.part));
        match part {
            Some(part) => found.push((part, Some(instance), instance.name.clone())),
            None => {
                let message =
                    format!("instance `{}`: there is no part `{}`", instance.name, instance.part);
                let help = "correct PART= of the instance, or add the part";
                reading.error("instance", instance.place, message, help);
            }
        }
        let own = &instance.own;
        let sets = own.node_sets.len() + own.element_sets.len();
        if own.nodes.is_empty() && own.elements.is_empty() && sets > 0 {
            let became = "left out: define them in the part or in the assembly";
            reading.row(Fate::LeftOut, format!("sets of instance {}", instance.name), sets, became);
        }
        found.push((own, Some(instance), instance.name.clone()));
    }
    if model.instances.is_empty() {
        found.extend(model.parts.iter().map(|part| (part, None, part.name.clone())));
    }
    found.retain(|(scope, ..)| !scope.nodes.is_empty() || !scope.elements.is_empty());
    // Points and masses need no prefix, and do not change the ids of the scopes with a mesh.
    found.sort_by_key(|(scope, _, name)| (!scope.has_mesh(), name.is_empty()));
    let several = found.iter().filter(|(scope, ..)| scope.has_mesh()).count() > 1;
    let mut next = 0;
    let mut all = Vec::new();
    for (index, (scope, instance, name)) in found.into_iter().enumerate() {
        let largest = scope.nodes.iter().map(|n| n.id).chain(scope.elements.iter().map(|e| e.id));
        let shift = next;
        next += largest.max().unwrap_or(0).min(1 << 40);
        let prefix = match name.is_empty() || index == 0 && !several {
            true => String::new(),
            false => format!("{name}."),
        };
        if shift > 0 && !scope.nodes.is_empty() {
            let of = if name.is_empty() { "the assembly" } else { name.as_str() };
            let became = format!("ids of the file plus {shift}");
            reading.row(Fate::Read, format!("ids of {of}"), scope.nodes.len(), became);
        }
        let own = scope.nodes.iter().zip(0..).map(|(node, index)| (node.id, index)).collect();
        let foreign = HashMap::new();
        all.push(Placed { scope, instance, name, prefix, shift, own, foreign });
    }
    all
}

/// Finds the nodes that elements name as `INSTANCE.NODE`. Reports those that are missing.
fn find_foreign(model: &AbaqusModel, placed: &mut [Placed], reading: &mut MeshReading) {
    for index in 0..placed.len() {
        let scope = placed[index].scope;
        let mut found = HashMap::new();
        for (node, one) in scope.foreign.iter().enumerate() {
            let id = foreign_id(node);
            let mut owners = placed.iter().filter(|p| p.name.eq_ignore_ascii_case(&one.instance));
            match owners.find_map(|owner| owner.node(one.node)) {
                Some(node) => {
                    found.insert(id, node);
                    continue;
                }
                None if model.has_instance(&one.instance) => {
                    let name = format!("{}.{}", one.instance, one.node);
                    reading.lacks_node(one.element, name, one.place, NODE_HELP);
                }
                None => {
                    let message =
                        format!("element {}: there is no instance `{}`", one.element, one.instance);
                    let help = "correct its nodes, or add the instance";
                    reading.error("instance", one.place, message, help);
                }
            }
            reading.reported([placed[index].id(id)]);
        }
        placed[index].foreign = found;
    }
}

/// Reports the nodes of elements and sets that are missing, with the numbers of the file: those of
/// the mesh are shifted.
fn check_missing(placed: &[Placed], has_instances: bool, reading: &mut MeshReading) {
    for (index, one) in placed.iter().enumerate() {
        let scope = one.scope;
        // A part that is placed again has the same errors.
        let is_first = !placed[..index].iter().any(|before| std::ptr::eq(before.scope, scope));
        let help = match has_instances && one.instance.is_none() {
            true => "define the node in *ASSEMBLY, or write INSTANCE.NODE for that of an instance",
            false => NODE_HELP,
        };
        let mut missing = HashSet::new();
        let is_refused = |e: &&ScopeElement| matches!(e.cell.usage(), CellUse::Refused(_));
        for element in scope.elements.iter().filter(|e| !is_refused(e)) {
            let towards = element.towards.filter(|_| has_beams(scope));
            let nodes = element.corners.iter().copied().chain(towards);
            let lost: Vec<u64> = nodes
                .filter(|&node| !one.has_node(node) && !reading.is_reported(one.id(node)))
                .collect();
            if let Some(first) = lost.first().filter(|_| is_first) {
                reading.lacks_node(element.id, first, element.place, help);
            }
            missing.extend(lost);
        }
        reading.reported(missing.iter().map(|&node| one.id(node)));
        for set in scope.node_sets.values().filter(|set| !set.internal) {
            let is_lost = |id: u64| !one.has_node(id) && !reading.is_reported(one.id(id));
            let lost = (0..).zip(&set.ids).filter(|(_, id)| is_lost(**id));
            let (at, lost): (Vec<usize>, Vec<u64>) = lost.map(|(at, id)| (at, *id)).unzip();
            if let Some(&at) = at.first().filter(|_| is_first) {
                reading.set_lacks(&set.name, &lost, set.place(at));
            }
            reading.reported(lost.iter().map(|&id| one.id(id)));
        }
    }
}

/// Returns true if a scope has sections of beams, which need directions.
fn has_beams(scope: &MeshScope) -> bool {
    scope.sections.iter().any(|section| section.kind.starts_with("BEAM"))
}

fn add_nodes(one: &Placed, reading: &mut MeshReading) {
    reading.mesh.nodes.extend(one.scope.nodes.iter().map(|node| one.in_mesh(node)));
}

/// Parts by the scope, section or set of elements that they come from.
struct PartTable<'a> {
    known: BTreeMap<String, usize>,
    /// Elements of rigid bodies of the assembly: indices of scopes, and ids.
    rigid: &'a HashSet<(usize, u64)>,
}

impl PartTable<'_> {
    /// Adds the elements of a scope: to the parts of their sections, or of their blocks.
    fn add_elements(&mut self, index: usize, one: &Placed, reading: &mut MeshReading) {
        let scope = one.scope;
        let of_section = sections_of(scope, reading);
        let mut free: BTreeMap<&str, Vec<&ScopeElement>> = BTreeMap::new();
        for element in scope.elements.iter().filter(|e| !of_section.contains_key(&e.id)) {
            free.entry(&element.block).or_default().push(element);
        }
        let dropped = bounding_blocks(scope, &free, &of_section);
        for (block, bounds) in free.keys().zip(&dropped) {
            if *bounds {
                let what = format!("elements of {block}");
                let became = "only a node set: they have no section and bound others";
                reading.row(Fate::Read, what, free[block].len(), became);
            }
        }
        let dropped: Vec<&str> =
            free.keys().zip(&dropped).filter(|(_, bounds)| **bounds).map(|(b, _)| *b).collect();
        let of_bodies = scope.rigid_elements(reading);
        let nodes = scope.nodes.iter().map(|node| (node.id, node.x));
        // A scope with nodes of others has no place of its own.
        let nodes = nodes.chain(one.foreign.iter().map(|(&id, node)| (id, node.x)));
        let has_beams = has_beams(scope);
        let at: HashMap<u64, [f64; 3]> = nodes.filter(|_| has_beams).collect();
        for element in &scope.elements {
            let section = of_section.get(&element.id).map(|&index| &scope.sections[index]);
            if section.is_none() && dropped.contains(&element.block.as_str()) {
                continue;
            }
            let rigid = element.rigid
                || of_bodies.contains(&element.id)
                || self.rigid.contains(&(index, element.id));
            let part = self.part(one, (element, rigid), section, reading);
            let corners: Vec<u64> = element.corners.iter().map(|id| one.id(*id)).collect();
            let id = one.id(element.id);
            let before = reading.mesh.elements.len();
            reading.add_element((id, part), element.cell, &corners, element.place);
            if let (Some(added), Some(section)) = (reading.mesh.elements.get_mut(before), section) {
                let axis = beam_axis(section, &at, element);
                added.axis = axis.map(|axis| one.turned(axis));
            }
        }
    }

    /// Returns the part of an element. Rigid and deformable elements are different parts.
    fn part(
        &mut self,
        one: &Placed,
        (element, rigid): (&ScopeElement, bool),
        section: Option<&SectionBlock>,
        reading: &mut MeshReading,
    ) -> usize {
        let block = section.map_or(element.block.as_str(), |section| &section.elements);
        // Instances of one part are one part, unless they have elements of their own.
        let owner = match one.scope.name.is_empty() {
            true => format!("instance {}", one.name),
            false => format!("part {}", one.scope.name),
        };
        let key = format!("{owner}/{}/{rigid}", block.to_uppercase());
        if let Some(&part) = self.known.get(&key) {
            return part;
        }
        // Sets whose names begin with `_` were made by the program that wrote the file.
        let name = match block.starts_with('_') && !one.scope.name.is_empty() {
            true => one.scope.name.clone(),
            false => block.to_string(),
        };
        let taken = reading.mesh.parts.iter().any(|part| part.name == name);
        let id = reading.mesh.free_part_id();
        let name = if taken { format!("{name}-{id}") } else { name };
        let index = reading.mesh.part_with_id(id, &name);
        let part = &mut reading.mesh.parts[index];
        part.rigid = rigid;
        if let Some(section) = section {
            part.material.clone_from(&section.material);
            match element.cell {
                Cell::Line => part.beam = beam(section),
                // Stiffnesses are reported where they are read.
                _ if is_general(&section.kind) && section.material.is_none() => {}
                _ if section.kind.starts_with("S") || section.kind.starts_with("M") => {
                    part.thickness = section.numbers.first().and_then(|row| row.first()).copied();
                    part.thickness = part.thickness.filter(|&t| t > 0.0);
                    part.offset = section.offset;
                }
                _ => {}
            }
            let offset = part.offset.map(|offset| format!("offset {offset:?} of part {id}"));
            check_section(section, element.cell, part.beam.is_some(), part.thickness, reading);
            if let Some(became) = offset {
                reading.row(Fate::Read, format!("OFFSET of {block}"), 1, became);
            }
        }
        self.known.insert(key, index);
        index
    }
}

/// Reports a section without the numbers that its elements need.
fn check_section(
    section: &SectionBlock,
    cell: Cell,
    beam: bool,
    thickness: Option<f64>,
    reading: &mut MeshReading,
) {
    let is_shell = matches!(cell, Cell::Quad | Cell::Triangle);
    let has_stiffness = is_general(&section.kind) && section.material.is_none();
    if is_shell && section.kind.contains("SHELL") && !has_stiffness && thickness.is_none() {
        let message = format!("the section of `{}` has no thickness above 0", section.elements);
        let help = "write the thickness in the first line after the keyword";
        reading.error("thickness", section.place, message, help);
    }
    if cell == Cell::Line && !beam {
        let message =
            format!("the beam section {} of `{}` is not read", section.profile, section.elements);
        let help = "RECT, CIRC, PIPE, symmetric I, general sections and areas of trusses are read; \
                    part.beam is a placeholder in the job";
        reading.warning(section.place, message, help);
    }
}

/// Returns the index of the section of each element that has one.
fn sections_of(scope: &MeshScope, reading: &mut MeshReading) -> HashMap<u64, usize> {
    let mut found = HashMap::new();
    for (index, section) in scope.sections.iter().enumerate() {
        match scope.element_sets.get(&section.elements.to_uppercase()) {
            Some(set) => {
                for id in &set.ids {
                    found.entry(*id).or_insert(index);
                }
            }
            None => {
                let message = format!("there is no element set `{}`", section.elements);
                let help = "correct ELSET= of the section, or define the set";
                reading.error("no set", section.place, message, help);
            }
        }
        if let Some(material) = &section.material
            && !reading.mesh.materials.iter().any(|m| m.name == *material)
        {
            let known =
                reading.mesh.materials.iter().find(|m| m.name.eq_ignore_ascii_case(material));
            match known.map(|m| m.name.clone()) {
                // Names of Abaqus are the same in small and capital letters.
                Some(name) => {
                    let all = reading.mesh.materials.iter_mut().filter(|m| m.name == name);
                    all.for_each(|m| m.name.clone_from(material));
                }
                None => {
                    let message = format!("there is no material `{material}`");
                    let help = "correct MATERIAL= of the section; the job has a placeholder";
                    reading.warning(section.place, message, help);
                }
            }
        }
    }
    found
}

/// Returns for each block of elements without a section whether it only bounds other elements.
fn bounding_blocks(
    scope: &MeshScope,
    free: &BTreeMap<&str, Vec<&ScopeElement>>,
    of_section: &HashMap<u64, usize>,
) -> Vec<bool> {
    let cells = |elements: &[&'_ ScopeElement]| -> usize {
        elements.iter().map(|e| e.cell.dimension()).max().unwrap_or(3)
    };
    let mut groups: Vec<CellGroup> = free
        .values()
        .map(|elements| CellGroup {
            dimension: cells(elements),
            cells: elements.iter().map(|e| &e.corners[..]).collect(),
        })
        .collect();
    for dimension in 2..=3 {
        let own = scope
            .elements
            .iter()
            .filter(|e| of_section.contains_key(&e.id) && e.cell.dimension() == dimension);
        groups.push(CellGroup { dimension, cells: own.map(|e| &e.corners[..]).collect() });
    }
    let mut bounds = bounding(&groups);
    bounds.truncate(free.len());
    // Masses and springs are no part of the mesh, whatever they touch.
    let no_mesh = |group: &CellGroup| group.dimension == 0;
    bounds.iter().zip(&groups).map(|(&bounds, group)| bounds && !no_mesh(group)).collect()
}

/// Returns the section of beams; `None` if its profile is not read.
fn beam(section: &SectionBlock) -> Option<BeamInput> {
    let row = section.numbers.first()?;
    let at = |index: usize| row.get(index).copied().unwrap_or(0.0);
    let empty = BeamInput::of(BeamSection::General);
    let beam = match (section.kind.as_str(), section.profile.as_str()) {
        ("SOLID SECTION", _) => BeamInput { area: at(0), ..empty },
        ("BEAM GENERAL SECTION", "" | "GENERAL") => {
            BeamInput { area: at(0), second_moments: [at(1), at(3)], torsion: at(4), ..empty }
        }
        (_, "RECT") => {
            BeamInput { height: at(0), width: at(1), ..BeamInput::of(BeamSection::Rectangle) }
        }
        (_, "CIRC") => BeamInput { radius: at(0), ..BeamInput::of(BeamSection::Tube) },
        (_, "PIPE") => BeamInput { radius: at(0), wall: at(1), ..BeamInput::of(BeamSection::Tube) },
        (_, "I") if at(2) == at(3) && at(4) == at(5) && at(0) * 2.0 == at(1) => BeamInput {
            height: at(1),
            width: at(2),
            flange: at(4),
            web: at(6),
            ..BeamInput::of(BeamSection::I)
        },
        _ => return None,
    };
    let sizes = [beam.area, beam.height, beam.radius];
    sizes.iter().any(|&size| size > 0.0).then_some(beam)
}

/// Returns the direction of the second axis of a beam. That of Abaqus is the first one, n1, and for
/// an I, whose height is along it, n2 = t x n1.
fn beam_axis(
    section: &SectionBlock,
    at: &HashMap<u64, [f64; 3]>,
    element: &ScopeElement,
) -> Option<[f64; 3]> {
    if !section.kind.starts_with("BEAM") {
        return None;
    }
    let row = section.numbers.get(1);
    let given: [f64; 3] =
        std::array::from_fn(|c| row.and_then(|r| r.get(c)).copied().unwrap_or(0.0));
    let (a, b) = (at.get(&element.corners[0])?, at.get(&element.corners[1])?);
    let towards: Option<[f64; 3]> = element
        .towards
        .and_then(|node| at.get(&node))
        .map(|node| std::array::from_fn(|c| node[c] - a[c]));
    let of_section = if dot(given, given) > 0.0 { given } else { [0.0, 0.0, -1.0] };
    let n1 = towards.unwrap_or(of_section);
    let along: [f64; 3] = std::array::from_fn(|c| b[c] - a[c]);
    let n2 = cross(along, n1);
    match dot(n2, n2) > 1e-12 * dot(along, along) * dot(n1, n1) {
        true if section.profile == "I" => Some(n2),
        true => Some(n1),
        // A direction along the beam gives no axis.
        false => None,
    }
}
