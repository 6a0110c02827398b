//! Sections of elements: numbers, material and offset.

use super::blocks::AbaqusBlock;
use super::scope::number_of;
use crate::input::deck::number;
use crate::input::mesh_file::content::FilePlace;
use crate::input::mesh_file::reading::MeshReading;
use crumple_worker::fem::elements::LARGEST_OFFSET;

/// A section of elements.
pub struct SectionBlock {
    /// Keyword.
    pub kind: String,
    /// Set of its elements.
    pub elements: String,
    pub material: Option<String>,
    /// Value of `SECTION`, in capitals.
    pub profile: String,
    /// Numbers of its lines.
    pub numbers: Vec<Vec<f64>>,
    /// Distance from the nodes of shells to their middle surface along the normal, over half the
    /// thickness.
    pub offset: Option<f64>,
    pub place: FilePlace,
}

/// Parameters with which the thickness of shells is not that of the first line.
const OTHER_THICKNESS: [&str; 2] = ["NODAL THICKNESS", "SHELL THICKNESS"];

impl SectionBlock {
    /// Reads the section of a set of elements. Reports what is not supported.
    pub fn read(block: &AbaqusBlock, elements: &str, reading: &mut MeshReading) -> Self {
        let mut numbers = Vec::new();
        for line in &block.data {
            // Fields that are no numbers name materials of layers and the like.
            let row = (0..line.fields.len()).map(|i| number_of(line, i));
            numbers.push(row.map(|n| n.ok().flatten().unwrap_or(0.0)).collect());
        }
        let mut unsupported = |kind: &'static str, message: &str, help: &str| {
            let message = format!("the section of `{elements}` {message}");
            reading.unsupported(kind, block.place, message, help);
        };
        if block.has("COMPOSITE") {
            unsupported("composite", "is a composite", "use a section of one material");
        }
        if is_general(&block.keyword) && !block.has("MATERIAL") && !block.has("COMPOSITE") {
            let help = "use *SHELL SECTION with a thickness and MATERIAL=";
            unsupported("general section", "has stiffnesses and no material", help);
        }
        for parameter in OTHER_THICKNESS.into_iter().filter(|parameter| block.has(parameter)) {
            let message = format!("has {parameter}, a thickness that changes from place to place");
            let help = "write one thickness in the first line, without this parameter, and those \
                        of single shells in the job: mesh.thicknesses";
            unsupported("thickness of nodes", &message, help);
        }
        let has_shells = block.keyword.starts_with("SHELL");
        if block.has("OFFSET") && !has_shells {
            unsupported("offset", "has an OFFSET", "remove it, and move the nodes");
        }
        let given = block.value("OFFSET").filter(|_| has_shells);
        let offset = given.and_then(|given| match offset(given) {
            Ok(offset) => offset,
            Err(OffsetFault { message, help }) => {
                let message = format!("the section of `{elements}`: OFFSET={given} {message}");
                reading.error("offset", block.place, message, help);
                None
            }
        });
        let of = |name: &str| block.value(name).map(String::from);
        SectionBlock {
            kind: block.keyword.clone(),
            elements: elements.to_string(),
            material: of("MATERIAL"),
            profile: of("SECTION").unwrap_or_default().to_uppercase(),
            numbers,
            offset,
            place: block.place,
        }
    }
}

/// Returns true for sections of shells that may have stiffnesses instead of a thickness.
pub fn is_general(kind: &str) -> bool {
    kind == "SHELL GENERAL SECTION"
}

/// An offset that cannot be read.
#[derive(Debug, PartialEq, Eq)]
struct OffsetFault {
    message: &'static str,
    help: &'static str,
}

/// Returns the offset of shells over half the thickness; `None` for that of the middle surface.
///
/// Abaqus has the distance from the middle surface to the nodes, over the thickness. With SPOS it
/// is 1/2: the nodes are on the top face, and the middle surface is half the thickness below them.
/// A job has the distance from the nodes to the middle surface, over half the thickness. So the
/// sign is the opposite one, and the number is twice that of Abaqus.
fn offset(given: &str) -> Result<Option<f64>, OffsetFault> {
    let of_thickness = match given.to_uppercase().as_str() {
        "SPOS" => 0.5,
        "SNEG" => -0.5,
        text => number::real(text.as_bytes()).ok_or(OffsetFault {
            message: "is no number, SPOS or SNEG",
            help: "write SPOS, SNEG or a fraction of the thickness; for a distribution write one \
                   number, and the offsets of single shells in the job: mesh.offsets",
        })?,
    };
    let offset = -2.0 * of_thickness;
    if offset.abs() > LARGEST_OFFSET {
        return Err(OffsetFault {
            message: "is not from -5 to 5",
            help: "it is a fraction of the thickness (-0.5 to 0.5 is usual): correct it, or move \
                   the nodes",
        });
    }
    Ok((offset != 0.0).then_some(offset))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A shell on z = 0 with the normal z and the thickness 2. With SPOS its nodes are on the top
    /// face, so that the middle surface is at z = -1: -1 times half the thickness from the nodes.
    /// With SNEG it is at z = +1. With 0.25 the nodes are 0.25 * 2 = 0.5 above the middle surface,
    /// which is at z = -0.5: half of half the thickness below them.
    #[test]
    fn an_offset_is_that_from_the_nodes_over_half_the_thickness() {
        for (given, wanted) in [
            ("SPOS", Some(-1.0)),
            ("spos", Some(-1.0)),
            ("SNEG", Some(1.0)),
            ("0.25", Some(-0.5)),
            ("-1.", Some(2.0)),
            ("0.", None),
            ("-0.0", None),
        ] {
            assert_eq!(offset(given), Ok(wanted), "{given}");
        }
        for given in ["", "top", "5.1", "-1e9"] {
            assert!(offset(given).is_err(), "{given}");
        }
    }
}
