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
        warn_of_lost(&groups, elements, &in_groups, reading);
    }
    if !named && reading.mesh.parts.len() > 1 {
        let advice = "parts and sets have no names: name them by Physical Surface(\"plate\") = ...";
        reading.row(Fate::Read, "groups without name", groups.len(), advice);
    }
}

/// Warns of elements in no physical group that do not only bound others, such as a part that was
/// forgotten.
fn warn_of_lost(
    groups: &[Group],
    elements: &[MshElement],
    in_groups: &BTreeSet<usize>,
    reading: &mut MeshReading,
) {
    let mut lost: BTreeMap<DimensionTag, Vec<usize>> = BTreeMap::new();
    for (i, e) in elements.iter().enumerate().filter(|(i, _)| !in_groups.contains(i)) {
        lost.entry((e.cell.dimension(), e.entity)).or_default().push(i);
    }
    let known = groups.iter().map(|group| (group.key.0, &group.elements));
    let cells: Vec<CellGroup> = known
        .chain(lost.iter().map(|(key, list)| (key.0, list)))
        .map(|(dimension, list)| CellGroup {
            dimension,
            cells: list.iter().map(|&i| &elements[i].corners[..]).collect(),
        })
        .collect();
    let bounds = bounding(&cells);
    let mut kinds: BTreeMap<&str, usize> = BTreeMap::new();
    let mut first = None;
    for ((key, list), bounds) in lost.iter().zip(&bounds[groups.len()..]) {
        if *bounds || key.0 == 0 {
            continue;
        }
        for &i in list {
            *kinds.entry(elements[i].cell.name()).or_default() += 1;
            first.get_or_insert(elements[i].place);
        }
    }
    let Some(place) = first else { return };
    let count: usize = kinds.values().sum();
    let kinds: Vec<String> = kinds.iter().map(|(name, n)| format!("{n} of type {name}")).collect();
    let message =
        format!("{count} elements are in no physical group and are not read: {}", kinds.join(", "));
    let help = "add them to a physical group in Gmsh, or save the mesh without any group: then \
                each surface or volume is a part";
    reading.warning(place, message, help);
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

#[cfg(test)]
mod tests {
    use crate::input::mesh_file::read;

    /// Returns the warnings of a mesh of a triangle in a group, a line at its side and, next to
    /// it, a triangle of this group.
    fn warnings(group: u32) -> String {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("plates.msh");
        let text = format!(
            "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n5\n1 0 0 0\n2 1 0 0\n3 0 1 0\n\
             4 5 0 0\n5 5 1 0\n$EndNodes\n$Elements\n3\n1 2 2 7 1 1 2 3\n2 1 2 0 2 1 2\n\
             3 2 2 {group} 3 3 4 5\n$EndElements\n"
        );
        std::fs::write(&file, text).unwrap();
        let read = read(&file, false, None).expect("a mesh file");
        read.warnings.iter().map(ToString::to_string).collect()
    }

    #[test]
    fn elements_in_no_group_get_a_warning_unless_they_bound_others() {
        let said = warnings(0);
        assert!(said.contains("1 elements are in no physical group"), "{said}");
        assert!(said.contains("1 of type triangle (add them"), "{said}");
        assert_eq!(warnings(7), "");
    }
}
