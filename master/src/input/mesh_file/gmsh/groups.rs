//! Parts and node sets from physical groups and entities.

use super::{DimensionTag, MshContent, MshElement};
use crate::input::mesh_file::boundary::{CellGroup, bounding};
use crate::input::mesh_file::reading::{Fate, MeshReading};
use std::collections::{BTreeMap, BTreeSet};

const DIMENSIONS: [&str; 4] = ["point", "curve", "surface", "volume"];

/// A physical group, or an entity in a file without groups, and the indices of its elements.
struct Group {
    key: DimensionTag,
    /// Name; empty without.
    name: String,
    elements: Vec<usize>,
}

impl Group {
    fn set_name(&self) -> String {
        match self.name.is_empty() {
            true => format!("{}_{}", DIMENSIONS[self.key.0], self.key.1),
            false => self.name.clone(),
        }
    }
}

/// Adds the content of the sections to the mesh.
pub fn add(content: MshContent, reading: &mut MeshReading) {
    let (elements, repeats) = (&content.elements, content.repeats);
    let groups = groups(&content);
    let bounds = bounding(
        &groups
            .iter()
            .map(|group| CellGroup {
                dimension: group.key.0,
                cells: group.elements.iter().map(|&i| &elements[i].corners[..]).collect(),
            })
            .collect::<Vec<_>>(),
    );
    reading.mesh.nodes = content.nodes;
    let mut of_part: Vec<Option<usize>> = vec![None; elements.len()];
    let named = groups.iter().any(|group| !group.name.is_empty());
    for (group, bounds) in groups.iter().zip(bounds) {
        add_group(group, bounds, elements, &mut of_part, reading);
    }
    let mut seen = BTreeSet::new();
    let mut again = 0;
    for (element, part) in elements.iter().zip(&of_part) {
        let Some(part) = *part else { continue };
        // Version 2.2 writes an element once for each of its groups.
        let is_first = !repeats || seen.insert((element.cell.dimension(), &element.corners));
        if is_first {
            let place = element.place;
            reading.add_element((element.id, part), element.cell, &element.corners, place);
        } else {
            again += 1;
        }
    }
    if again > 0 {
        let became = "they have the nodes of an element before: version 2.2 writes an element for \
                      each of its groups. It is in the part of the first one";
        reading.row(Fate::Ignored, "elements of several groups", again, became);
    }
    let in_groups: BTreeSet<usize> =
        groups.iter().flat_map(|g| g.elements.iter().copied()).collect();
    let lost = elements.len() - in_groups.len();
    if lost > 0 {
        let advice = "in no physical group: define one in Gmsh to use them";
        reading.row(Fate::Ignored, "elements", lost, advice);
    }
    if !named && reading.mesh.parts.len() > 1 {
        let advice = "parts and sets have no names: name them by Physical Surface(\"plate\") = ...";
        reading.row(Fate::Read, "groups without name", groups.len(), advice);
    }
}

/// Returns the physical groups with elements. Without groups of the highest dimension, the entities
/// of this dimension are groups too.
fn groups(content: &MshContent) -> Vec<Group> {
    let highest = content.elements.iter().map(|e| e.cell.dimension()).max().unwrap_or(0);
    let grouped =
        content.elements.iter().any(|e| e.cell.dimension() == highest && !e.groups.is_empty());
    let mut physical: BTreeMap<DimensionTag, Vec<usize>> = BTreeMap::new();
    let mut entities: BTreeMap<DimensionTag, Vec<usize>> = BTreeMap::new();
    for (index, element) in content.elements.iter().enumerate() {
        let dimension = element.cell.dimension();
        for &tag in &element.groups {
            physical.entry((dimension, tag)).or_default().push(index);
        }
        if element.groups.is_empty() && !grouped && dimension == highest {
            entities.entry((dimension, element.entity)).or_default().push(index);
        }
    }
    let name = |key: &DimensionTag| content.names.get(key).cloned().unwrap_or_default();
    let physical =
        physical.into_iter().map(|(key, elements)| Group { name: name(&key), key, elements });
    let entities =
        entities.into_iter().map(|(key, elements)| Group { name: String::new(), key, elements });
    physical.chain(entities).collect()
}

/// Adds the node set of a group and, if its elements do not only bound others, its part.
fn add_group(
    group: &Group,
    bounds: bool,
    elements: &[MshElement],
    of_part: &mut [Option<usize>],
    reading: &mut MeshReading,
) {
    let (dimension, tag) = group.key;
    let name = group.set_name();
    let second = format!("{name}_{}", DIMENSIONS[dimension]);
    let nodes = group.elements.iter().flat_map(|&i| elements[i].corners.iter().copied());
    reading.mesh.add_set(&name, &second, nodes);
    if bounds || dimension == 0 {
        let what = format!("{} group {tag} ({name})", DIMENSIONS[dimension]);
        let became = "only a node set: its elements bound others";
        reading.row(Fate::Read, what, group.elements.len(), became);
        return;
    }
    let taken = reading.mesh.parts.iter().any(|part| i64::from(part.id) == tag);
    let id = u32::try_from(tag).ok().filter(|&id| id > 0 && !taken);
    let id = id.unwrap_or_else(|| reading.mesh.free_part_id());
    let part = reading.mesh.part_with_id(id, &name);
    let mut others = 0;
    for &index in &group.elements {
        match of_part[index] {
            Some(_) => others += 1,
            None => of_part[index] = Some(part),
        }
    }
    if others > 0 {
        let what = format!("elements of {} group {tag} ({name})", DIMENSIONS[dimension]);
        reading.row(Fate::Ignored, what, others, "they are in the part of another group");
    }
}
