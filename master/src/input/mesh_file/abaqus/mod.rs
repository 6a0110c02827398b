//! Abaqus input files: nodes, elements, sets, surfaces, sections, elastic and plastic materials,
//! of parts and instances or of a file without parts (Abaqus Keywords Reference).
//!
//! Elements with a section are a part; its name is that of the element set. Elements without a
//! section are a part if they do not only bound others. Node sets keep their names; element sets
//! and surfaces become the sets of their nodes. With several instances that have elements,
//! `INSTANCE.` comes before the names of their sets, and ids are shifted from the second instance
//! on; reference points of the assembly come last.

mod assembly;
mod assembly_sets;
mod blocks;
mod elements;
mod materials;
mod nodes;
mod scope;
mod sections;

use super::content::FilePlace;
use super::reading::{Fate, MeshReading};
use assembly::InstanceBlock;
use blocks::AbaqusBlock;
use scope::MeshScope;

/// Returns true if the first line that is no comment is a keyword of Abaqus.
pub fn recognises(head: &[u8], _: usize) -> bool {
    let text = String::from_utf8_lossy(head).into_owned();
    let mut lines = text.lines().map(str::trim);
    let first = lines.find(|line| !line.is_empty() && !line.starts_with("**"));
    let begins = |line: &str| {
        let word = line.trim_start_matches('*').trim_start();
        line.starts_with('*') && word.starts_with(|c: char| c.is_ascii_alphabetic())
    };
    first.is_some_and(begins)
}

/// The part or instance to which keywords belong.
#[derive(Clone, Copy)]
enum AbaqusLevel {
    Model,
    Part(usize),
    Assembly,
    Instance(usize),
}

/// An Abaqus file while it is read.
#[derive(Default)]
struct AbaqusModel {
    model: MeshScope,
    parts: Vec<MeshScope>,
    instances: Vec<InstanceBlock>,
    /// Sets, surfaces and rigid bodies of the assembly.
    assembly: Vec<AbaqusBlock>,
}

/// Keywords that are ignored: name, and what to write in the job.
const IGNORED: &[(&str, &str)] = &[
    ("HEADING", "a comment"),
    ("PREPRINT", "output"),
    ("BOUNDARY", "supports and prescribed motion: [[fix]], [[motion]]"),
    ("CLOAD", "forces: [[load]]"),
    ("DLOAD", "pressure, gravity: [[pressure]], [[gravity]]"),
    ("DSLOAD", "pressure: [[pressure]]"),
    ("AMPLITUDE", "curves: [[curve]]"),
    ("INITIAL CONDITIONS", "initial values: [[initial_velocity]]"),
    ("MASS", "point masses: [[mass]]"),
    ("ROTARY INERTIA", "point inertia: rigid.added_inertia"),
    ("SPRING", "springs: mesh.springs of a job with its own mesh"),
    ("DASHPOT", "dampers: mesh.springs of a job with its own mesh"),
    ("CONNECTOR SECTION", "connectors: [[rigid]] or [[tie]]"),
    ("CONTACT", "contact: [contact]"),
    ("CONTACT PAIR", "contact: [contact]"),
    ("SURFACE INTERACTION", "contact: [contact]"),
    ("FRICTION", "friction: contact.friction"),
    ("TIE", "ties: [[tie]]"),
    ("EQUATION", "constraints: [[tie]] or [[rigid]]"),
    ("MPC", "constraints: [[tie]] or [[rigid]]"),
    ("COUPLING", "constraints: [[rigid]]"),
    ("KINEMATIC COUPLING", "constraints: [[rigid]]"),
    ("STEP", "the analysis: end_time, [time], [output]"),
    ("DYNAMIC", "the analysis: end_time"),
    ("BULK VISCOSITY", "part.bulk_viscosity"),
    ("SECTION CONTROLS", "part.hourglass"),
    ("TRANSVERSE SHEAR STIFFNESS", "shear stiffness, which follows from the material"),
    ("HOURGLASS STIFFNESS", "part.hourglass"),
    ("NODAL THICKNESS", "thicknesses at nodes, which no section here has: mesh.thicknesses"),
];

/// Keywords that make nodes or elements; a mesh without them is wrong.
const MAKE_MESH: &[&str] =
    &["NGEN", "NFILL", "NCOPY", "NMAP", "ELGEN", "ELCOPY", "PARAMETER", "SUBSTRUCTURE"];

/// Reads a file.
pub fn read(reading: &mut MeshReading, bytes: &[u8]) {
    let blocks = blocks::blocks(reading, bytes);
    let mut model = AbaqusModel::default();
    let mut level = AbaqusLevel::Model;
    let mut place_in_list = 0;
    while let Some(block) = blocks.get(place_in_list) {
        place_in_list += 1;
        match model.change_level(level, block, reading) {
            Some(next) => level = next,
            None if block.keyword == "MATERIAL" => {
                let following = &blocks[place_in_list..];
                place_in_list += materials::read(block, following, reading);
            }
            None => model.read(level, block, reading),
        }
    }
    if let AbaqusLevel::Part(index) = level {
        model.report_open(index, Default::default(), reading);
    }
    if !reading.has_errors() {
        assembly::assemble(model, reading);
    }
}

impl AbaqusModel {
    /// Returns the level after a keyword that begins or ends one.
    fn change_level(
        &mut self,
        level: AbaqusLevel,
        block: &AbaqusBlock,
        reading: &mut MeshReading,
    ) -> Option<AbaqusLevel> {
        let name = || block.value("NAME").unwrap_or_default().to_string();
        if let (AbaqusLevel::Part(index), "PART" | "ASSEMBLY") = (level, block.keyword.as_str()) {
            self.report_open(index, block.place, reading);
        }
        Some(match (block.keyword.as_str(), level) {
            ("PART", _) => {
                self.parts.push(MeshScope { name: name(), ..MeshScope::default() });
                AbaqusLevel::Part(self.parts.len() - 1)
            }
            ("ASSEMBLY", _) | ("END INSTANCE", _) => AbaqusLevel::Assembly,
            ("END PART" | "END ASSEMBLY", _) => AbaqusLevel::Model,
            ("INSTANCE", _) => {
                self.instances.push(InstanceBlock::new(block, reading));
                AbaqusLevel::Instance(self.instances.len() - 1)
            }
            _ => return None,
        })
    }

    /// Returns true if there is an instance of this name.
    fn has_instance(&self, name: &str) -> bool {
        self.instances.iter().any(|instance| instance.name.eq_ignore_ascii_case(name))
    }

    /// Reports a part that does not end.
    fn report_open(&self, part: usize, place: FilePlace, reading: &mut MeshReading) {
        let message = format!("*PART, NAME={} has no *END PART", self.parts[part].name);
        reading.error("end", place, message, "add it; the file may be cut: export it again");
    }

    fn read(&mut self, level: AbaqusLevel, block: &AbaqusBlock, reading: &mut MeshReading) {
        let scope = match level {
            AbaqusLevel::Model => &mut self.model,
            AbaqusLevel::Part(index) => &mut self.parts[index],
            AbaqusLevel::Instance(index) => &mut self.instances[index].own,
            AbaqusLevel::Assembly => match block.keyword.as_str() {
                "NSET" | "ELSET" | "SURFACE" | "RIGID BODY" => {
                    self.assembly.push(block.clone());
                    return;
                }
                // Reference points and their elements are nodes of the assembly.
                _ => &mut self.model,
            },
        };
        if scope.read(block, reading) {
            return;
        }
        let keyword = block.keyword.as_str();
        // The second number is the duration of the step; the first one is its first increment.
        let numbers = block.data.first().filter(|_| keyword == "DYNAMIC");
        let duration = numbers.and_then(|line| line.fields.get(1)?.parse::<f64>().ok());
        if let Some(duration) = duration.filter(|t| t.is_finite() && *t > 0.0) {
            let end = reading.mesh.end_time.unwrap_or(0.0) + duration;
            reading.mesh.end_time = Some(end);
            reading.row(Fate::Read, "*DYNAMIC", 1, "end_time, the sum of the dynamic steps");
            return;
        }
        if MAKE_MESH.contains(&keyword) {
            let message = format!("*{keyword} is not read, and the mesh depends on it");
            let help = "write the nodes and elements that it makes into the file";
            reading.error("generator", block.place, message, help);
            return;
        }
        if materials::gives_law(keyword) {
            let message = format!("*{keyword} belongs to no *MATERIAL");
            let help = "write it after *MATERIAL, NAME=... and before the next keyword of a mesh \
                        or step";
            reading.error("law", block.place, message, help);
            return;
        }
        let advice = IGNORED.iter().find(|row| row.0 == keyword).map(|row| row.1);
        let advice = advice.unwrap_or("not needed for the mesh, or not supported");
        reading.row(Fate::Ignored, format!("*{keyword}"), 1, advice);
    }
}
