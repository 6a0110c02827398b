//! Materials of Abaqus: density, elasticity, plasticity.

use super::blocks::AbaqusBlock;
use super::scope::{number_of, set_name};
use crate::input::mesh_file::content::FileMaterial;
use crate::input::mesh_file::reading::{Fate, MeshReading};

/// Keywords that belong to a material and are not read: name, and what to write in the job.
const NOT_READ: &[(&str, &str)] = &[
    ("RATE DEPENDENT", "strain rates: material.cowper_symonds"),
    ("DAMAGE INITIATION", "damage: material.failure_strain"),
    ("DAMAGE EVOLUTION", "damage: material.failure_strain"),
    ("SHEAR FAILURE", "failure: material.failure_strain"),
    ("DAMPING", "damping: time.damping"),
    ("EXPANSION", "thermal values"),
    ("CONDUCTIVITY", "thermal values"),
    ("SPECIFIC HEAT", "thermal values"),
    ("DEPVAR", "user values"),
    ("TENSILE FAILURE", "failure: material.failure_strain"),
];

/// Keywords that would give another law; they are not supported.
const OTHER_LAWS: &[&str] = &[
    "HYPERELASTIC",
    "HYPERFOAM",
    "VISCOELASTIC",
    "USER MATERIAL",
    "CRUSHABLE FOAM",
    "DRUCKER PRAGER",
    "CONCRETE DAMAGED PLASTICITY",
    "EOS",
    "FABRIC",
];

/// Keywords that end a material and are in no other table.
const OTHER_LEVEL: &[&str] = &[
    "MATERIAL",
    "PART",
    "ASSEMBLY",
    "INSTANCE",
    "NODE",
    "ELEMENT",
    "NSET",
    "ELSET",
    "SURFACE",
    "RIGID BODY",
    "ORIENTATION",
    "TRANSFORM",
    "RESTART",
    "OUTPUT",
];

/// Returns true for keywords that no material has.
fn ends_material(keyword: &str) -> bool {
    OTHER_LEVEL.contains(&keyword)
        || keyword.starts_with("END ")
        || keyword.ends_with(" SECTION")
        || super::MAKE_MESH.contains(&keyword)
        || super::IGNORED.iter().any(|row| row.0 == keyword)
}

/// Returns true for keywords that give the law of a material, so that they have to be in one.
pub fn gives_law(keyword: &str) -> bool {
    ["DENSITY", "ELASTIC", "PLASTIC"].contains(&keyword) || OTHER_LAWS.contains(&keyword)
}

/// Reads a material from `*MATERIAL` and the keywords that follow. Returns their number.
pub fn read(block: &AbaqusBlock, following: &[AbaqusBlock], reading: &mut MeshReading) -> usize {
    let mut material = FileMaterial::default();
    if let Some(name) = set_name(block, "NAME", reading) {
        material.name = name.to_string();
    }
    let mut count = 0;
    for next in following.iter().take_while(|next| !ends_material(&next.keyword)) {
        match next.keyword.as_str() {
            "DENSITY" => material.density = first(next, 0, reading),
            "ELASTIC" => elastic(next, &mut material, reading),
            "PLASTIC" => plastic(next, &mut material, reading),
            keyword if OTHER_LAWS.contains(&keyword) => {
                let message = format!("material `{}`: *{keyword} is not supported", material.name);
                let help = "use *ELASTIC and *PLASTIC; the laws are elastic, j2 and johnson_cook";
                reading.unsupported("law", next.place, message, help);
            }
            keyword => {
                let advice = NOT_READ.iter().find(|row| row.0 == keyword).map(|row| row.1);
                let advice = advice.unwrap_or("not needed for the material, or not supported");
                let what = format!("*{keyword} of material {}", material.name);
                reading.row(Fate::Ignored, what, 1, advice);
            }
        }
        count += 1;
    }
    if reading.mesh.materials.iter().any(|m| m.name.eq_ignore_ascii_case(&material.name)) {
        let message = format!("material `{}` is defined twice", material.name);
        reading.error("material twice", block.place, message, "give each its own name");
    }
    reading.mesh.materials.push(material);
    count
}

/// Returns a number of the first line. Reports an error if it is missing or no positive number.
fn first(block: &AbaqusBlock, index: usize, reading: &mut MeshReading) -> Option<f64> {
    let line = block.data.first();
    match line.map(|line| number_of(line, index)) {
        Some(Ok(Some(number))) if number > 0.0 => return Some(number),
        found => {
            let (place, text) = match (line, found) {
                (Some(line), Some(Err(text))) => (line.place, format!("`{text}`")),
                (Some(line), Some(Ok(Some(number)))) => (line.place, number.to_string()),
                _ => (block.place, "nothing".into()),
            };
            let message = format!("*{} needs a number above 0, not {text}", block.keyword);
            reading.error("material", place, message, "correct the value");
        }
    }
    None
}

fn elastic(block: &AbaqusBlock, material: &mut FileMaterial, reading: &mut MeshReading) {
    let kind = block.value("TYPE").unwrap_or("ISOTROPIC").to_uppercase();
    if !kind.starts_with("ISO") {
        let message = format!("material `{}`: elasticity {kind} is not supported", material.name);
        reading.unsupported("law", block.place, message, "use an isotropic material");
        return;
    }
    material.youngs_modulus = first(block, 0, reading);
    let poisson = block.data.first().map_or(Ok(None), |line| number_of(line, 1));
    match poisson {
        Ok(number) => {
            let number = number.unwrap_or(0.0);
            if (-1.0..0.5).contains(&number) {
                material.poisson = Some(number);
            } else {
                let message = format!("Poisson's ratio is {number}");
                let help = "it has to be at least -1 and below 0.5";
                reading.error("material", block.data[0].place, message, help);
            }
        }
        Err(text) => {
            let message = format!("Poisson's ratio is `{text}`, which is no number");
            reading.error("material", block.data[0].place, message, "correct the value");
        }
    }
    if block.data.len() > 1 {
        let what = format!("further temperatures of material {}", material.name);
        reading.row(Fate::Ignored, what, block.data.len() - 1, "the first temperature is used");
    }
}

fn plastic(block: &AbaqusBlock, material: &mut FileMaterial, reading: &mut MeshReading) {
    let kind = block.value("HARDENING").unwrap_or("ISOTROPIC").to_uppercase();
    if !kind.starts_with("ISO") {
        let message = format!("material `{}`: hardening {kind} is not supported", material.name);
        let help = "use isotropic hardening, with yield stress over plastic strain";
        reading.unsupported("law", block.place, message, help);
        return;
    }
    if !material.hardening.is_empty() {
        if block.has("RATE") {
            let what = format!("*PLASTIC, RATE= of material {}", material.name);
            let advice = "the first rate is used; strain rates: material.cowper_symonds";
            reading.row(Fate::LeftOut, what, 1, advice);
        } else {
            let message = format!("material `{}` has *PLASTIC twice", material.name);
            reading.error("material", block.place, message, "remove one, or write RATE=");
        }
        return;
    }
    let mut temperature = None;
    for line in &block.data {
        let [stress, strain, at] = [0, 1, 2].map(|index| number_of(line, index));
        let (Ok(Some(stress)), Ok(strain), Ok(at)) = (stress, strain, at) else {
            let message =
                format!("`{}` is no yield stress and plastic strain", line.fields.join(", "));
            reading.error("material", line.place, message, "write stress, plastic strain");
            continue;
        };
        // Curves for further temperatures follow the first one.
        if *temperature.get_or_insert(at) != at {
            let what = format!("further temperatures of material {}", material.name);
            reading.row(Fate::Ignored, what, 1, "the first temperature is used");
            continue;
        }
        let strain = strain.unwrap_or(0.0);
        let last = material.hardening.last().map_or(-1.0, |row| row[0]);
        if stress <= 0.0 || strain <= last || material.hardening.is_empty() && strain != 0.0 {
            let message = format!("yield stress {stress} at plastic strain {strain}");
            let help = "stresses have to be above 0, and strains to begin at 0 and to grow";
            reading.error("material", line.place, message, help);
            continue;
        }
        material.hardening.push([strain, stress]);
    }
    if block.data.is_empty() {
        let message = "*PLASTIC has no values";
        reading.error("material", block.place, message, "write stress, plastic strain");
    }
}
