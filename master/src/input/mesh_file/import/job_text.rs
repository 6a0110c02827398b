//! Text of a job for a mesh file.

use super::super::content::FileElement;
use super::super::{FileMaterial, FileMesh, FilePart, FileRate, ReadMesh};
use crate::input::job::{modulus_fits, steel_in, units_fit};
use crumple_proto::job::{BeamInput, BeamSection};
use crumple_proto::mesh::Shape;
use std::fmt::Write as _;
use toml::Value;

/// Mesh file for which a job is written.
pub struct ImportedJob<'a> {
    /// Name of the job.
    pub name: &'a str,
    /// Name of the mesh file in the folder of the job.
    pub file: &'a str,
    /// The file.
    pub read: &'a ReadMesh,
    /// True if the job leaves out what is not supported.
    pub allowed: bool,
}

/// Text of a job, and its keys whose values are placeholders.
pub struct ImportedText {
    /// Text of `job.toml`.
    pub job: String,
    /// Keys.
    pub placeholders: Vec<String>,
    /// Units of the job, and why; empty with a deck.
    pub units: String,
    /// How to add the mesh to that of another job, if all of it is rigid; empty otherwise.
    pub to_add: String,
}

/// Name of the material of parts for which the file has none.
const NO_MATERIAL: &str = "placeholder";
const POISSON: f64 = 0.3;

/// Units with density and Young's modulus of mild steel.
const UNITS: [(&str, f64, f64); 4] = [
    ("mm, ms, kg", 7.85e-6, 207.0),
    ("mm, s, t", 7.85e-9, 207e3),
    ("m, s, kg", 7850.0, 207e9),
    ("mm, ms, g", 7.85e-3, 207e3),
];

/// Returns the text of a job that has a deck with parts.
pub fn of_deck(name: &str, file: &str, allowed: bool) -> ImportedText {
    let quoted = Value::from(file);
    let mut job = format!(
        "# {name}: a job for the deck {file}, which has mesh, parts, materials, loads and the end\n\
         # of the run. Keys here override those of the deck.\n\n[mesh]\ndeck = {quoted}\n"
    );
    if allowed {
        job += "allow_unsupported = true\n";
    }
    ImportedText { job, placeholders: Vec::new(), units: String::new(), to_add: String::new() }
}

/// Returns the text of the job.
pub fn write(job: &ImportedJob) -> ImportedText {
    let mesh = &job.read.mesh;
    let mut placeholders = Vec::new();
    if mesh.end_time.is_none() {
        placeholders.push("end_time".to_string());
    }
    let (units, density, modulus, origin) = units(mesh);
    let body = materials(mesh, (density, modulus), &mut placeholders)
        + &parts(mesh, &mut placeholders)
        + &rigid(mesh)
        + &hints(mesh);
    let mut out = format!(
        "# Written by `crumple import` for a file of the format {}.\n",
        job.read.format.name
    );
    if !placeholders.is_empty() {
        out += "# Set each value that `placeholders` names, then remove it from the list.\n";
    }
    let _ = writeln!(out, "title = {}", quoted(job.name));
    let _ = writeln!(out, "units = \"{units}\"            # {origin}");
    let _ = writeln!(out, "end_time = {:?}", mesh.end_time.unwrap_or(1.0));
    if !placeholders.is_empty() {
        let list: Vec<String> =
            placeholders.iter().map(|key| format!("    {},\n", quoted(key))).collect();
        let _ = writeln!(out, "placeholders = [\n{}]", list.concat());
    }
    let _ = writeln!(out, "\n[mesh]\nfile = {}", quoted(job.file));
    if job.allowed {
        let _ = writeln!(out, "allow_unsupported = true");
    }
    for (name, ids) in &mesh.node_sets {
        let _ = writeln!(out, "# node set {}: {} nodes", quoted(name), ids.len());
    }
    let to_add = to_add(mesh, job.file);
    if !to_add.is_empty() {
        let comments = to_add.lines().map(|line| format!("# {line}").trim_end().to_string() + "\n");
        out.extend(std::iter::once("\n".to_string()).chain(comments.skip(1)));
    }
    ImportedText { job: out + &body, placeholders, units: format!("{units}: {origin}"), to_add }
}

/// Number that is added to the ids of parts in the example of a mesh that is added.
const PART_OFFSET: u32 = 1000;

/// Returns how to add a mesh to that of another job, if all of it is rigid: alone it sets no time
/// step.
fn to_add(mesh: &FileMesh, file: &str) -> String {
    if mesh.parts.iter().any(|part| !part.rigid) {
        return String::new();
    }
    let mut out = format!(
        "\nAll of the mesh is rigid, so that it sets no time step: a job of it alone needs dt_max\n\
         in [time]. To let it meet another mesh, copy the file to the job of that mesh, and add\n\
         there:\n\n\
         [[mesh.add]]\n\
         file = {}\n\
         part_offset = {PART_OFFSET}\n\
         # scale = 0.001               # for a file in mm in a job in m\n\
         # move = [0.0, 0.0, 100.0]\n",
        quoted(file)
    );
    for part in &mesh.parts {
        let id = part.id.saturating_add(PART_OFFSET);
        let name = name_of(part);
        let name = quoted(&name);
        let _ = writeln!(
            out,
            "\n[[part]]\nid = {id}\nname = {name}\nmaterial = \"MATERIAL\"         # of that job\n\
             thickness = 1.0\n\n[[rigid]]\nname = {name}\nparts = [{id}]\n\
             # mass = 1.0                  # of the whole body"
        );
    }
    out
}

/// Returns the name of a part; one with its id if it has none.
fn name_of(part: &FilePart) -> String {
    if part.name.is_empty() { format!("part-{}", part.id) } else { part.name.clone() }
}

fn quoted(text: &str) -> String {
    Value::String(text.into()).to_string()
}

/// Returns the units of the file, or units in which all its materials are plausible, with density
/// and modulus of steel, and the reason. A material with one of density and Young's modulus is
/// judged by it alone.
fn units(mesh: &FileMesh) -> (&str, f64, f64, String) {
    let stated = mesh.units.as_deref();
    if let Some((units, [density, modulus])) = stated.and_then(|u| Some((u, steel_in(u)?))) {
        return (units, density, modulus, "as the file says".to_string());
    }
    let materials = &mesh.materials;
    let fits = |units: &str| {
        materials.iter().all(|m| match (m.density, m.youngs_modulus) {
            (Some(density), modulus) => units_fit(units, density, modulus.unwrap_or(0.0)),
            (None, Some(modulus)) => modulus_fits(units, modulus),
            (None, None) => true,
        })
    };
    let found = UNITS.into_iter().find(|(units, ..)| fits(units));
    let has_density = materials.iter().any(|m| m.density.is_some());
    let by_modulus = materials.iter().find_map(|m| Some((&m.name, m.youngs_modulus?)));
    let origin = match (found, by_modulus) {
        _ if materials.is_empty() => {
            "the file has no materials: check that its lengths fit".to_string()
        }
        (None, _) => "the materials of the file fit no common units: correct them".to_string(),
        (_, None) if !has_density => "the materials of the file have neither density nor Young's \
                                      modulus: check that its lengths fit"
            .to_string(),
        (Some(_), Some((name, modulus))) if !has_density => format!(
            "the file has no density, and in these units {name} can have Young's modulus \
             {modulus:?}: check them"
        ),
        (Some(_), _) => "the materials of the file fit: check them".to_string(),
    };
    let (units, density, modulus) = found.unwrap_or(UNITS[0]);
    (units, density, modulus, origin)
}

fn materials(mesh: &FileMesh, steel: (f64, f64), placeholders: &mut Vec<String>) -> String {
    let mut out = String::new();
    for material in &mesh.materials {
        let _ = writeln!(out, "\n[[material]]\nname = {}", quoted(&material.name));
        let _ = writeln!(out, "law = \"{}\"", material.law());
        for (key, value, otherwise) in [
            ("density", material.density, steel.0),
            ("youngs_modulus", material.youngs_modulus, steel.1),
            ("poisson", material.poisson, POISSON),
        ] {
            let _ = writeln!(out, "{key} = {:?}", value.unwrap_or(otherwise));
            if value.is_none() {
                placeholders.push(format!("material.{}.{key}", material.name));
            }
        }
        match &material.hardening[..] {
            [] => {}
            [[_, stress]] => {
                let _ = writeln!(out, "yield_stress = {stress:?}");
            }
            rows => {
                let _ = writeln!(out, "hardening = {rows:?}    # true stress over plastic strain");
            }
        }
        out += &rates(material);
    }
    if mesh.parts.iter().any(|part| material_of(part, mesh) == NO_MATERIAL) {
        placeholders.push(format!("material.{NO_MATERIAL}"));
        let _ = writeln!(
            out,
            "\n[[material]]\nname = \"{NO_MATERIAL}\"           # mild steel\nlaw = \"elastic\"\n\
             density = {:?}\nyoungs_modulus = {:?}\npoisson = {POISSON:?}",
            steel.0, steel.1
        );
    }
    out
}

/// Returns the keys of a material that depend on the strain rate, and those of Johnson and Cook.
fn rates(material: &FileMaterial) -> String {
    let mut out = String::new();
    if let Some([a, b, n]) = material.johnson_cook {
        let _ = writeln!(out, "a = {a:?}\nb = {b:?}\nn = {n:?}");
    }
    let by_rate = &material.hardening_by_rate;
    if !by_rate.is_empty() {
        let _ = writeln!(out, "hardening_by_rate = {by_rate:?}    # rate, plastic strain, stress");
    }
    match &material.rate {
        None => {}
        Some(FileRate::CowperSymonds(values)) => {
            let _ = writeln!(out, "cowper_symonds = {values:?}");
        }
        Some(FileRate::Factors(rows)) => {
            let _ = writeln!(out, "rate_factors = {rows:?}");
        }
        Some(FileRate::JohnsonCook([c, reference])) => {
            let _ = writeln!(out, "c = {c:?}\nreference_rate = {reference:?}");
        }
    }
    let has_rate = material.rate.is_some() || !by_rate.is_empty();
    if has_rate && material.law() == "j2" {
        let _ =
            writeln!(out, "viscoplastic = true    # the rate of Abaqus is that of plastic strain");
    }
    out
}

/// Returns the name of the material of a part; that of the placeholder if the file has none.
fn material_of<'a>(part: &'a FilePart, mesh: &FileMesh) -> &'a str {
    let given = part.material.as_deref();
    let known = given.filter(|name| mesh.materials.iter().any(|m| m.name == *name));
    known.unwrap_or(NO_MATERIAL)
}

fn parts(mesh: &FileMesh, placeholders: &mut Vec<String>) -> String {
    let mut out = String::new();
    let thickness = placeholder_thickness(mesh);
    for (index, part) in mesh.parts.iter().enumerate() {
        let count =
            |shape| mesh.elements.iter().filter(|e| e.part == index && e.shape == shape).count();
        let [quads, triangles, beams] = [Shape::Quad4, Shape::Tri3, Shape::Beam2].map(count);
        let key = |rest: &str| match part.name.is_empty() {
            true => format!("part.{}.{rest}", part.id),
            false => format!("part.{}.{rest}", part.name),
        };
        let _ = writeln!(out, "\n[[part]]\nid = {}", part.id);
        if !part.name.is_empty() {
            let _ = writeln!(out, "name = {}", quoted(&part.name));
        }
        let _ = writeln!(out, "material = {}", quoted(material_of(part, mesh)));
        if quads + triangles > 0 {
            let _ = writeln!(out, "thickness = {:?}", part.thickness.unwrap_or(thickness));
            if part.thickness.is_none() {
                placeholders.push(key("thickness"));
            }
            if let Some(offset) = part.offset {
                let _ = writeln!(
                    out,
                    "offset = {offset:?}    # from the nodes to the middle surface, over half the \
                     thickness"
                );
            }
            let has_own = |e: &FileElement| e.part == index && e.own.offset.is_some();
            if mesh.elements.iter().any(has_own) {
                out += "# its shells have the offsets of the file\n";
            }
        }
        if beams > 0 {
            out += &beam_section(part.beam.as_ref(), thickness);
            if part.beam.is_none() {
                placeholders.push(key("beam"));
            }
        }
    }
    out
}

/// Returns a thickness for shells without one: a tenth of the mean side, rounded to one digit
/// [length].
fn placeholder_thickness(mesh: &FileMesh) -> f64 {
    let at: std::collections::HashMap<u64, [f64; 3]> =
        mesh.nodes.iter().map(|n| (n.id, n.x)).collect();
    let sides = mesh.elements.iter().filter_map(|e| {
        let [a, b] = [0, 1].map(|c| at.get(&e.corners[c]));
        let (a, b) = (a?, b?);
        Some((0..3).map(|c| (a[c] - b[c]).powi(2)).sum::<f64>().sqrt())
    });
    let (sum, count) = sides.fold((0.0, 0.0), |(sum, count), side| (sum + side, count + 1.0));
    let tenth = 0.1 * sum / f64::max(count, 1.0);
    format!("{tenth:.0e}").parse().ok().filter(|&t: &f64| t > 0.0).unwrap_or(1.0)
}

fn beam_section(beam: Option<&BeamInput>, thickness: f64) -> String {
    let Some(beam) = beam else {
        return format!("[part.beam]\nsection = \"tube\"\nradius = {thickness:?}\n");
    };
    let (name, keys): (&str, Vec<(&str, f64)>) = match beam.section {
        BeamSection::Rectangle => {
            ("rectangle", vec![("height", beam.height), ("width", beam.width)])
        }
        BeamSection::Tube => ("tube", vec![("radius", beam.radius), ("wall", beam.wall)]),
        BeamSection::I => (
            "i",
            vec![
                ("height", beam.height),
                ("width", beam.width),
                ("flange", beam.flange),
                ("web", beam.web),
            ],
        ),
        BeamSection::General => ("general", vec![("area", beam.area), ("torsion", beam.torsion)]),
    };
    let mut out = format!("[part.beam]\nsection = \"{name}\"\n");
    for (key, value) in keys {
        let _ = writeln!(out, "{key} = {value:?}");
    }
    if beam.section == BeamSection::General {
        let _ = writeln!(out, "second_moments = {:?}", beam.second_moments);
    }
    out
}

fn rigid(mesh: &FileMesh) -> String {
    let mut out = String::new();
    for part in mesh.parts.iter().filter(|part| part.rigid) {
        let name = quoted(&name_of(part));
        let _ = writeln!(out, "\n[[rigid]]\nname = {name}\nparts = [{}]", part.id);
        let _ = writeln!(out, "# mass = 1.0                  # of the whole body");
    }
    out
}

/// Returns sections that most jobs need, as comments.
fn hints(mesh: &FileMesh) -> String {
    let has_offsets = mesh.parts.iter().any(|part| part.offset.is_some())
        || mesh.elements.iter().any(|element| element.own.offset.is_some());
    let shell_offset = match has_offsets {
        true => {
            "# shell_offset = true           # contact at the true faces of shells with offsets\n"
        }
        false => "",
    };
    let sets: Vec<String> = mesh.node_sets.keys().map(|name| quoted(name)).collect();
    let sets = match &sets[..] {
        [] => "a rule or the name of a part".to_string(),
        all => format!("one of {}", all.join(", ")),
    };
    format!(
        "\n# Sections that most jobs need:\n\
         #\n\
         # [[fix]]\n\
         # nodes = \"SET\"                     # {sets}\n\
         # dofs = [\"x\", \"y\", \"z\", \"rx\", \"ry\", \"rz\"]\n\
         #\n\
         # [[initial_velocity]]\n\
         # nodes = \"SET\"\n\
         # velocity = [0.0, 0.0, -1.0]\n\
         #\n\
         # [contact]                       # all parts touch each other and themselves\n\
         # friction = 0.2\n\
         {shell_offset}"
    )
}
