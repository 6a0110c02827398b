//! Offsets of the shells of Nastran (ZOFFS).
//!
//! ZOFFS is the distance from the nodes to the middle surface, along the normal [length]. The
//! offset of a job has the same sign and is over half the thickness: `2 ZOFFS / t`.

use crate::input::mesh_file::reading::{Fate, MeshReading};
use crumple_worker::fem::elements::LARGEST_OFFSET;
use std::collections::HashMap;

/// Offsets as the cards give them [length].
#[derive(Default)]
pub struct BulkOffsets {
    /// By elements.
    pub of_elements: HashMap<u64, f64>,
    /// By properties, for the elements that give none.
    pub of_properties: HashMap<u32, f64>,
}

impl BulkOffsets {
    /// Gives parts their offset if it is that of all their shells, and the shells of other parts
    /// their own.
    pub fn assign(&self, reading: &mut MeshReading) {
        let mut shells: Vec<Vec<(usize, f64)>> = vec![Vec::new(); reading.mesh.parts.len()];
        let elements = reading.mesh.elements.iter().enumerate();
        for (index, element) in elements.filter(|(_, e)| e.shape.is_shell()) {
            let of_property = self.of_properties.get(&reading.mesh.parts[element.part].id);
            let given = self.of_elements.get(&element.id).or(of_property);
            shells[element.part].push((index, given.copied().unwrap_or(0.0)));
        }
        for (part, shells) in shells.into_iter().enumerate() {
            assign_to_part(part, &shells, reading);
        }
    }
}

/// Assigns the offsets of the shells of a part [length].
fn assign_to_part(part: usize, shells: &[(usize, f64)], reading: &mut MeshReading) {
    let count = shells.iter().filter(|(_, offset)| *offset != 0.0).count();
    let Some(&(first, given)) = shells.iter().find(|(_, offset)| *offset != 0.0) else { return };
    let (id, place) = (reading.mesh.parts[part].id, reading.mesh.elements[first].place);
    let element = reading.mesh.elements[first].id;
    let Some(thickness) = reading.mesh.parts[part].thickness else {
        let message = format!(
            "element {element} has an offset (ZOFFS), and its property {id} has no thickness"
        );
        let help = "add a PSHELL with a thickness, or leave ZOFFS blank and set part.offset in \
                    the job";
        reading.unsupported("offset", place, message, help);
        reading.row(Fate::LeftOut, "ZOFFS", count, "part.offset");
        return;
    };
    let over_half = |offset: f64| 2.0 * offset / thickness;
    let too_large = |(_, offset): &&(usize, f64)| over_half(*offset).abs() > LARGEST_OFFSET;
    if let Some(&(index, offset)) = shells.iter().find(too_large) {
        let element = &reading.mesh.elements[index];
        let (message, place) = (
            format!(
                "element {} has the offset {offset} (ZOFFS), {} times half its thickness",
                element.id,
                over_half(offset)
            ),
            element.place,
        );
        let help = "it has to be from -10 to 10 times half the thickness (-1 to 1 is usual): \
                    move its nodes, or correct the thickness";
        reading.error("offset", place, message, help);
        return;
    }
    if shells.iter().all(|(_, offset)| *offset == given) {
        let offset = over_half(given);
        reading.mesh.parts[part].offset = Some(offset);
        reading.row(Fate::Read, "ZOFFS", count, format!("offset {offset:?} of part {id}"));
        return;
    }
    for &(index, offset) in shells {
        reading.mesh.elements[index].own.offset = Some(over_half(offset));
    }
    let became = format!("offsets of the {} shells of part {id}, one for each", shells.len());
    reading.row(Fate::Read, "ZOFFS", count, became);
}

#[cfg(test)]
mod tests {
    use crate::input::mesh_file::content::FileMesh;
    use crate::input::mesh_file::nastran::read;
    use crate::input::mesh_file::testing::{errors_of, mesh_of};

    /// Returns a plate of the thickness 0.5 on z = 0 with the normal z, of a quad and a triangle
    /// with these fields, and more fields of its property.
    fn plate(quad: &str, triangle: &str, property: &str) -> String {
        format!(
            "GRID,1,,0.,0.,0.\nGRID,2,,1.,0.,0.\nGRID,3,,1.,1.,0.\nGRID,4,,0.,1.,0.\n\
             GRID,5,,2.,0.,0.\nCQUAD4,1,7,1,2,3,4,,{quad}\nCTRIA3,2,7,2,5,3,,{triangle}\n\
             PSHELL,7,1,.5{property}\nMAT1,1,1.,,.3\n"
        )
    }

    fn offsets(mesh: &FileMesh) -> (Option<f64>, Vec<Option<f64>>) {
        (mesh.parts[0].offset, mesh.elements.iter().map(|e| e.own.offset).collect())
    }

    /// With ZOFFS 0.25 the middle surface is at z = +0.25, half the thickness above the nodes, so
    /// that the nodes are on the bottom face: the offset of a job is +1. With -0.1 it is below the
    /// nodes, 0.1/0.25 of half the thickness.
    #[test]
    fn one_offset_of_all_shells_is_that_of_the_part() {
        for (given, wanted) in [(".25", 1.0), ("-.25", -1.0), ("-.1", -0.4), (".5", 2.0)] {
            let mesh = mesh_of(read, &plate(given, given, ""));
            assert_eq!(offsets(&mesh), (Some(wanted), vec![None; 2]), "{given}");
        }
        for zero in ["", "0.", "-0."] {
            assert_eq!(offsets(&mesh_of(read, &plate(zero, "", ""))), (None, vec![None; 2]));
        }
    }

    /// Shells with different offsets have their own, also those with a blank field.
    #[test]
    fn different_offsets_are_those_of_the_shells() {
        let mesh = mesh_of(read, &plate(".25", "-.125", ""));
        assert_eq!(offsets(&mesh), (None, vec![Some(1.0), Some(-0.5)]));
        let mesh = mesh_of(read, &plate("", "-.125", ""));
        assert_eq!(offsets(&mesh), (None, vec![Some(0.0), Some(-0.5)]));
        let own: Vec<_> = mesh.to_mesh().elements.iter().map(|e| e.own.offset).collect();
        assert_eq!(own, [Some(0.0), Some(-0.5)]);
    }

    /// The offset of a property of OptiStruct is for the shells that give none.
    #[test]
    fn the_offset_of_a_property_is_for_blank_fields() {
        let property = ",,,,,\n+,,,,,.25";
        let mesh = mesh_of(read, &plate("", "", property));
        assert_eq!(offsets(&mesh), (Some(1.0), vec![None; 2]));
        let mesh = mesh_of(read, &plate("0.", "", property));
        assert_eq!(offsets(&mesh), (None, vec![Some(0.0), Some(1.0)]));
        // A whole number there is a choice of another program.
        let mesh = mesh_of(read, &plate("", "", ",,,,,\n+,,,,,1"));
        assert_eq!(offsets(&mesh), (None, vec![None; 2]));
    }

    /// 2.6 is 10.4 times half the thickness. Without a property there is no thickness.
    #[test]
    fn offsets_without_measure_are_errors() {
        let found = errors_of(read, &plate("0.1", "2.6", ""));
        let wanted = ":7: element 2 has the offset 2.6 (ZOFFS), 10.4 times half its thickness";
        assert!(found.len() == 1 && found[0].contains(wanted), "{found:?}");
        let bare = plate("0.1", "0.1", "").replace("PSHELL,7", "PSHELL,8");
        let found = errors_of(read, &bare);
        let wanted = ":6: element 1 has an offset (ZOFFS), and its property 7 has no thickness";
        assert!(found.len() == 1 && found[0].contains(wanted), "{found:?}");
        let found = errors_of(read, &plate("TOP", "", ""));
        assert!(found[0].contains(":6: CQUAD4: field 9 is `TOP`"), "{found:?}");
    }
}
