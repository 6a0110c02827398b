//! Materials of Abaqus: density, elasticity, plasticity with its strain rate.
//!
//! The rate of Abaqus is that of the plastic strain. `POWER LAW` with D and n is the law of Cowper
//! and Symonds with C = D and p = n (Abaqus Analysis User's Guide, "Rate-dependent yield").

use super::blocks::{AbaqusBlock, DataLine};
use super::scope::{number_of, set_name};
use crate::input::mesh_file::content::{FileMaterial, FilePlace, FileRate};
use crate::input::mesh_file::reading::{Fate, MeshReading};

/// Keywords that belong to a material and are not read: name, and what to write in the job.
const NOT_READ: &[(&str, &str)] = &[
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
    let mut curves = Vec::new();
    let mut rate = None;
    if let Some(name) = set_name(block, "NAME", reading) {
        material.name = name.to_string();
    }
    let mut count = 0;
    for next in following.iter().take_while(|next| !ends_material(&next.keyword)) {
        further_columns(next, &material.name, reading);
        match next.keyword.as_str() {
            "DENSITY" => material.density = first(next, 0, reading),
            "ELASTIC" => elastic(next, &mut material, reading),
            "PLASTIC" => plastic(next, &mut material, &mut curves, reading),
            "RATE DEPENDENT" => rate = rate_effect(next, &material.name, reading),
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
    settle_curves(&mut material, curves, reading);
    if let Some(rate) = rate {
        settle_rate(&mut material, rate, reading);
    }
    if reading.mesh.materials.iter().any(|m| m.name.eq_ignore_ascii_case(&material.name)) {
        let message = format!("material `{}` is defined twice", material.name);
        reading.error("material twice", block.place, message, "give each its own name");
    }
    reading.mesh.materials.push(material);
    count
}

/// Says that a keyword has columns that are not used, so that a decimal comma is seen.
fn further_columns(block: &AbaqusBlock, material: &str, reading: &mut MeshReading) {
    let is_word =
        |key, word: &str| block.value(key).is_none_or(|v| v.to_uppercase().starts_with(word));
    let used = match block.keyword.as_str() {
        "DENSITY" => 1,
        "ELASTIC" if is_word("TYPE", "ISO") => 2,
        "PLASTIC" if is_word("HARDENING", "ISO") => 2,
        _ => return,
    };
    let has_more = |line: &&DataLine| line.fields.iter().skip(used).any(|f| !f.trim().is_empty());
    let lines = block.data.iter().filter(has_more).count();
    if lines > 0 {
        let what = format!("further columns of *{} of material {material}", block.keyword);
        let became = "they are temperatures, which are not used; numbers with a decimal comma \
                      would look like this, too";
        reading.row(Fate::Ignored, what, lines, became);
    }
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

/// Yield stress over plastic strain at one strain rate.
struct AbaqusYieldCurve {
    /// Rate [1/time].
    rate: f64,
    /// Plastic strain and yield stress.
    rows: Vec<[f64; 2]>,
}

fn plastic(
    block: &AbaqusBlock,
    material: &mut FileMaterial,
    curves: &mut Vec<AbaqusYieldCurve>,
    reading: &mut MeshReading,
) {
    let kind = block.value("HARDENING").unwrap_or("ISOTROPIC").to_uppercase();
    if kind.split_whitespace().eq(["JOHNSON", "COOK"]) {
        match material.johnson_cook.is_some() || !curves.is_empty() {
            true => plastic_twice(block, material, reading),
            false => johnson_cook(block, material, reading),
        }
        return;
    }
    if !kind.starts_with("ISO") {
        let message = format!("material `{}`: hardening {kind} is not supported", material.name);
        let help =
            "use isotropic hardening, with yield stress over plastic strain, or JOHNSON COOK";
        reading.unsupported("law", block.place, message, help);
        return;
    }
    let rate = block.value("RATE").unwrap_or("0").parse::<f64>().ok();
    let Some(rate) = rate.filter(|rate| rate.is_finite() && *rate >= 0.0) else {
        let message = format!("`{}` is no strain rate", block.value("RATE").unwrap_or_default());
        reading.error("material", block.place, message, "write RATE= and a number from 0 on");
        return;
    };
    if material.johnson_cook.is_some() || curves.iter().any(|curve| curve.rate == rate) {
        plastic_twice(block, material, reading);
        return;
    }
    let mut rows: Vec<[f64; 2]> = Vec::new();
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
        let last = rows.last().map_or(-1.0, |row| row[0]);
        if stress <= 0.0 || strain <= last || rows.is_empty() && strain != 0.0 {
            let message = format!("yield stress {stress} at plastic strain {strain}");
            let help = "stresses have to be above 0, and strains to begin at 0 and to grow";
            reading.error("material", line.place, message, help);
            continue;
        }
        rows.push([strain, stress]);
    }
    if block.data.is_empty() {
        let message = "*PLASTIC has no values";
        reading.error("material", block.place, message, "write stress, plastic strain");
    }
    curves.push(AbaqusYieldCurve { rate, rows });
}

fn plastic_twice(block: &AbaqusBlock, material: &FileMaterial, reading: &mut MeshReading) {
    let message = format!("material `{}` has *PLASTIC twice", material.name);
    reading.error("material", block.place, message, "remove one, or write RATE=");
}

/// Reads A, B, n of Johnson and Cook; m and the temperatures that follow are not carried.
fn johnson_cook(block: &AbaqusBlock, material: &mut FileMaterial, reading: &mut MeshReading) {
    let Some((place, numbers)) = numbers(block, 6, reading) else { return };
    let [Some(a), Some(b), Some(n)] = [numbers[0], numbers[1], numbers[2]] else {
        let message = format!("material `{}` lacks A, B or n of Johnson and Cook", material.name);
        reading.error("material", place, message, "write A, B, n, m and two temperatures");
        return;
    };
    if a <= 0.0 || b < 0.0 || n <= 0.0 {
        let message = format!("Johnson and Cook: A is {a}, B is {b}, n is {n}");
        reading.error("material", place, message, "A and n have to be above 0, B from 0 on");
        return;
    }
    material.johnson_cook = Some([a, b, n]);
    let what = format!("*PLASTIC, HARDENING=JOHNSON COOK of material {}", material.name);
    reading.row(Fate::Read, what, 1, "law johnson_cook with a, b, n");
    if numbers[3].is_some_and(|m| m != 0.0) {
        let what = format!("m and temperatures of material {}", material.name);
        let advice = "softening by heat: material.m with melting_temperature, \
                      reference_temperature and specific_heat";
        reading.row(Fate::LeftOut, what, 1, advice);
    }
}

/// Returns the numbers of the first line, `None` for blank fields. Further lines, which are for
/// other temperatures, are a row of the table.
fn numbers(
    block: &AbaqusBlock,
    count: usize,
    reading: &mut MeshReading,
) -> Option<(FilePlace, Vec<Option<f64>>)> {
    let Some(line) = block.data.first() else {
        let message = format!("*{} has no values", block.keyword);
        reading.error("material", block.place, message, "write its values in the next line");
        return None;
    };
    if block.data.len() > 1 {
        let what = format!("further temperatures of *{}", block.keyword);
        reading.row(Fate::Ignored, what, block.data.len() - 1, "the first temperature is used");
    }
    match (0..count).map(|index| number_of(line, index)).collect() {
        Ok(numbers) => Some((line.place, numbers)),
        Err(text) => {
            let message = format!("*{}: `{text}` is no number", block.keyword);
            reading.error("material", line.place, message, "correct the value");
            None
        }
    }
}

/// Reads the effect of the strain rate.
fn rate_effect(block: &AbaqusBlock, material: &str, reading: &mut MeshReading) -> Option<FileRate> {
    let kind = block.value("TYPE").unwrap_or("POWER LAW").to_uppercase();
    let kind = kind.split_whitespace().collect::<Vec<_>>().join(" ");
    if kind == "YIELD RATIO" {
        return rate_factors(block, reading);
    }
    if !["POWER LAW", "JOHNSON COOK"].contains(&kind.as_str()) {
        let what = format!("*RATE DEPENDENT, TYPE={kind} of material {material}");
        reading.row(Fate::LeftOut, what, 1, "strain rates: material.rate_factors");
        return None;
    }
    let (place, found) = numbers(block, 2, reading)?;
    let [Some(first), Some(second)] = found[..] else {
        let message = format!("*RATE DEPENDENT of material `{material}` lacks a value");
        let help = "write D, n for POWER LAW; C and the reference rate for JOHNSON COOK";
        reading.error("material", place, message, help);
        return None;
    };
    // A factor C of 0 is no effect; D and n are divisors.
    let least = if kind == "POWER LAW" { f64::MIN_POSITIVE } else { 0.0 };
    if !(first >= least && second > 0.0) {
        let message = format!("*RATE DEPENDENT has the values {first} and {second}");
        reading.error("material", place, message, "correct the values: they have to be above 0");
        return None;
    }
    Some(match kind.as_str() {
        "POWER LAW" => FileRate::CowperSymonds([first, second]),
        _ => FileRate::JohnsonCook([first, second]),
    })
}

/// Reads the ratio of the yield stress at a strain rate to that of slow loads, with the rate.
fn rate_factors(block: &AbaqusBlock, reading: &mut MeshReading) -> Option<FileRate> {
    let mut rows: Vec<[f64; 2]> = Vec::new();
    for line in &block.data {
        if number_of(line, 2) != number_of(&block.data[0], 2) {
            let what = format!("further temperatures of *{}", block.keyword);
            reading.row(Fate::Ignored, what, 1, "the first temperature is used");
            continue;
        }
        let pair = [0, 1].map(|index| number_of(line, index));
        let last = rows.last().map_or([-1.0, 0.0], |row| *row);
        match pair {
            [Ok(Some(ratio)), Ok(Some(rate))] if rate > last[0] && ratio >= last[1] => {
                rows.push([rate, ratio]);
            }
            _ => {
                let message = format!("`{}` is no ratio and rate", line.fields.join(", "));
                let help = "write the ratio and the rate; both grow from line to line";
                reading.error("material", line.place, message, help);
            }
        }
    }
    (!rows.is_empty()).then_some(FileRate::Factors(rows))
}

/// Gives a material its curve, or those of several rates.
fn settle_curves(
    material: &mut FileMaterial,
    mut curves: Vec<AbaqusYieldCurve>,
    reading: &mut MeshReading,
) {
    curves.retain(|curve| !curve.rows.is_empty());
    if curves.len() < 2 {
        material.hardening = curves.pop().map(|curve| curve.rows).unwrap_or_default();
        return;
    }
    curves.sort_by(|a, b| a.rate.total_cmp(&b.rate));
    let rows = curves.iter().flat_map(|c| c.rows.iter().map(|row| [c.rate, row[0], row[1]]));
    material.hardening_by_rate = rows.collect();
    let what = format!("*PLASTIC, RATE= of material {}", material.name);
    reading.row(Fate::Read, what, curves.len(), "material.hardening_by_rate");
}

/// Gives a material the effect of the strain rate, if its law has it.
fn settle_rate(material: &mut FileMaterial, rate: FileRate, reading: &mut MeshReading) {
    let what = format!("*RATE DEPENDENT of material {}", material.name);
    let became = match (&rate, material.law()) {
        (FileRate::JohnsonCook(_), "johnson_cook") => {
            "material.c and reference_rate; the rate is that of the total strain"
        }
        (FileRate::CowperSymonds(_), "j2") if !material.hardening.is_empty() => {
            "material.cowper_symonds"
        }
        (FileRate::Factors(_), "j2") if !material.hardening.is_empty() => "material.rate_factors",
        _ => {
            let advice = "the law has no such rate with its yield stress: material.rate_factors \
                          of j2, or c of johnson_cook";
            reading.row(Fate::LeftOut, what, 1, advice);
            return;
        }
    };
    reading.row(Fate::Read, what, 1, became);
    material.rate = Some(rate);
}

#[cfg(test)]
mod tests {
    use crate::input::mesh_file::{ImportRow, read};

    /// A density with a decimal comma has two columns.
    #[test]
    fn columns_that_are_not_used_are_in_the_table() {
        let dir = tempfile::tempdir().unwrap();
        let rows = |density: &str| -> Vec<ImportRow> {
            let file = dir.path().join("sheet.inp");
            let text = format!(
                "*NODE\n1,0.,0.,0.\n2,1.,0.,0.\n3,0.,1.,0.\n*ELEMENT,TYPE=S3,ELSET=E\n1,1,2,3\n\
                 *SHELL SECTION,ELSET=E,MATERIAL=M\n1.\n*MATERIAL,NAME=M\n*DENSITY\n{density}\n\
                 *ELASTIC\n210000.,0.3\n"
            );
            std::fs::write(&file, text).unwrap();
            let read = read(&file, false, None).expect("a mesh file");
            read.rows.into_iter().filter(|row| row.what.contains("further columns")).collect()
        };
        assert_eq!(rows("7.85e-09,").len(), 0, "a comma at the end is no column");
        let found = rows("7,85e-09,");
        assert!(found[0].what.contains("*DENSITY of material M"), "{}", found[0].what);
        assert!(found[0].became.contains("decimal comma"), "{}", found[0].became);
    }
}
