//! Description of a job that `crumple check` prints.

use crate::input::deck::Mapping;
use crate::input::job::subcycles::{self, SubcycleClasses};
use crate::input::job::{AddedMesh, Model};
use crate::input::mesh_file;
use crumple_proto::job::{ContactInput, Part};
use crumple_proto::mesh::Shape;
use crumple_worker::contact::beams;
use std::fmt::Write;

/// Returns the description of a job that `crumple check` prints. Nothing is run.
pub fn describe(model: &Model) -> String {
    let mut out = String::new();
    // Writing to a string cannot fail.
    let _ = write(model, &mut out);
    out
}

fn write(model: &Model, out: &mut String) -> std::fmt::Result {
    let (job, mesh) = (&model.job, &model.mesh);
    let or =
        |text: &str, none: &str| if text.is_empty() { none.to_string() } else { text.to_string() };
    writeln!(out, "job          {}", model.path.display())?;
    writeln!(out, "title        {}", or(&job.title, "(none)"))?;
    writeln!(out, "units        {}", or(&job.units, "(not stated)"))?;
    let count = |shape: Shape| mesh.elements.iter().filter(|e| e.shape == shape).count();
    let kinds = [
        (Shape::Quad4, "quads"),
        (Shape::Tri3, "triangles"),
        (Shape::Hex8, "solids"),
        (Shape::Tet4, "tetrahedra"),
        (Shape::Wedge6, "wedges"),
        (Shape::Tet10, "ten-node tetrahedra"),
        (Shape::Cohesive8, "cohesive elements"),
        (Shape::Beam2, "beams"),
        (Shape::Truss2, "trusses"),
        (Shape::Point1, "particles"),
        (Shape::Line2, "springs"),
    ];
    let counts = kinds.map(|(shape, name)| (count(shape), name));
    let counts: Vec<_> =
        counts.iter().filter(|c| c.0 > 0).map(|c| format!("{} {}", c.0, c.1)).collect();
    writeln!(out, "elements     {}", counts.join(", "))?;
    writeln!(out, "nodes        {}", mesh.nodes.len())?;
    if let Some(r) = model.renumbered {
        let (before, after) = (figure(r.before), figure(r.after));
        writeln!(
            out,
            "numbering    changed internally, because node numbers of an element are far apart \
             ({before} cache lines fetched per element, now {after}); all output has the ids of \
             the mesh"
        )?;
    }
    let bound = |pick: fn(f64, f64) -> f64, start: f64| {
        mesh.nodes.iter().fold([start; 3], |b, n| [0, 1, 2].map(|c| pick(b[c], n.x[c])))
    };
    let (low, high) = (bound(f64::min, f64::INFINITY), bound(f64::max, f64::NEG_INFINITY));
    let range = |c: usize| format!("{} .. {}", figure(low[c]), figure(high[c]));
    writeln!(out, "box          x {}, y {}, z {}", range(0), range(1), range(2))?;
    parts(model, out)?;
    masses(model, out)?;
    steps(model, out)?;
    shapes(model, out)?;
    loads(model, out)?;
    out.push_str(&mapping(model));
    if !model.mesh_rows().is_empty() {
        writeln!(out, "\nmesh file")?;
        out.push_str(&mesh_file::table(model.mesh_rows()));
    }
    for added in model.added_meshes() {
        added_mesh(added, out)?;
    }
    writeln!(out)?;
    if model.warnings.is_empty() {
        return writeln!(out, "no warnings");
    }
    for warning in model.warnings.iter().take(crate::input::job::report::SHOWN) {
        writeln!(out, "{}", model.show(warning))?;
    }
    match model.warnings.len() {
        1 => writeln!(out, "1 warning"),
        n => writeln!(out, "{n} warnings"),
    }
}

/// Describes a mesh that was added to the mesh: its ids and names in the job, and its content.
fn added_mesh(added: &AddedMesh, out: &mut String) -> std::fmt::Result {
    let AddedMesh { file, format, part_offset, id_offset, .. } = added;
    writeln!(
        out,
        "\nadded mesh   {file}: {format}, part_offset {part_offset}, id_offset {id_offset}"
    )?;
    for (id, of_job, name) in &added.parts {
        let name = if name.is_empty() { String::new() } else { format!(" ({name})") };
        writeln!(out, "  part {id}{name} is part {of_job}")?;
    }
    for (old, new) in &added.renamed {
        writeln!(out, "  node set `{old}` is `{new}`")?;
    }
    if !added.rows.is_empty() {
        out.push_str(&mesh_file::table(&added.rows));
    }
    Ok(())
}

/// Figures of a part.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PartFigures {
    /// Number of elements.
    pub elements: usize,
    /// Mass, with mass scaling [mass].
    pub mass: f64,
    /// Smallest and largest thickness of its elements [length].
    thickness: [f64; 2],
    /// Smallest stable step, before the safety factor; infinite for a rigid part [time].
    pub smallest_step: f64,
}

impl PartFigures {
    /// Returns the thickness of the part, or the range of its elements.
    pub fn thickness(&self, part: &Part) -> String {
        let [least, most] = self.thickness;
        if least < most {
            format!("{} to {}", figure(least), figure(most))
        } else {
            part.thickness.to_string()
        }
    }
}

/// Returns the figures of all parts of the settings.
pub fn part_figures(model: &Model) -> Vec<PartFigures> {
    let parts = &model.settings.parts;
    let none = PartFigures {
        elements: 0,
        mass: 0.0,
        thickness: [f64::INFINITY, 0.0],
        smallest_step: f64::INFINITY,
    };
    let mut figures = vec![none; parts.len()];
    for (i, &part) in model.elements.part.iter().enumerate() {
        let (of, element) = (&mut figures[part as usize], &model.mesh.elements[i]);
        of.elements += 1;
        of.mass += model.elements.mass_with_scaling(i);
        of.smallest_step = of.smallest_step.min(model.elements.stable_dt[i]);
        let thickness = if element.own.thickness > 0.0 {
            element.own.thickness
        } else {
            parts[part as usize].thickness
        };
        of.thickness = [of.thickness[0].min(thickness), of.thickness[1].max(thickness)];
    }
    figures
}

fn parts(model: &Model, out: &mut String) -> std::fmt::Result {
    let parts = &model.settings.parts;
    let mut rows = vec![
        ["part", "name", "element", "material", "thickness", "elements", "mass"].map(String::from),
    ];
    for (index, (part, figures)) in parts.iter().zip(part_figures(model)).enumerate() {
        rows.push([
            part.id.to_string(),
            part.name.clone(),
            model.blocks.names(part, index).join(", "),
            part.materials().join(", "),
            figures.thickness(part),
            figures.elements.to_string(),
            figure(figures.mass),
        ]);
    }
    writeln!(out)?;
    let width: Vec<usize> =
        (0..7).map(|c| rows.iter().map(|row| row[c].chars().count()).max().unwrap_or(0)).collect();
    for row in rows {
        let mut line = String::new();
        for (c, cell) in row.iter().enumerate() {
            let gap = " ".repeat(width[c] - cell.chars().count());
            // Numbers are right-aligned, names left-aligned.
            if matches!(c, 0 | 4 | 5 | 6) {
                write!(line, "{gap}{cell}  ")?
            } else {
                write!(line, "{cell}{gap}  ")?
            }
        }
        writeln!(out, "  {}", line.trim_end())?;
    }
    writeln!(out)
}

/// Returns the mapping of the deck of a job.
pub fn mapping(model: &Model) -> String {
    mapping_of(&model.mapping, model.unsupported_of_deck())
}

/// Returns the mapping of a deck: requests and settings used, content left out. Requests with the
/// same result share a line.
pub fn mapping_of(mapping: &[Mapping], unsupported: &[String]) -> String {
    let mut rows: Vec<(String, &str, &str)> = Vec::new();
    for entry in mapping {
        match rows.iter_mut().find(|r| r.1 == entry.asked && r.2 == entry.used) {
            Some(row) => row.0 += &format!(", {}", entry.of),
            None => rows.push((entry.of.clone(), &entry.asked, &entry.used)),
        }
    }
    if rows.is_empty() && unsupported.is_empty() {
        return String::new();
    }
    let rows = rows.into_iter().map(|(of, asked, used)| format!("  {of}: {asked} -> {used}\n"));
    let left_out = unsupported.iter().map(|what| format!("  left out: {what}\n"));
    std::iter::once("\ndeck         asked -> used\n".to_string())
        .chain(rows)
        .chain(left_out)
        .collect()
}

fn masses(model: &Model, out: &mut String) -> std::fmt::Result {
    let (structure, scaled, lumped) =
        (model.structure_mass(), model.scaled_mass(), model.lumped_mass());
    let total = structure + scaled + lumped;
    write!(
        out,
        "mass         {} = {} structure + {} lumped",
        figure(total),
        figure(structure),
        figure(lumped)
    )?;
    if scaled > 0.0 {
        let percent = 100.0 * scaled / structure;
        write!(
            out,
            " + {} by mass scaling ({} % of the structure)",
            figure(scaled),
            figure(percent)
        )?;
    }
    writeln!(out)
}

fn steps(model: &Model, out: &mut String) -> std::fmt::Result {
    let (dt, at) = model.first_dt();
    let cycles = (model.settings.end_time / dt).ceil();
    let limit = match model.settings.max_cycles {
        0 => String::new(),
        n => format!(", limited to {n}"),
    };
    writeln!(
        out,
        "time step    {} (safety {} x {}), set by element {}",
        figure(dt),
        model.settings.safety,
        figure(dt / model.settings.safety),
        model.mesh.elements[at].id
    )?;
    writeln!(out, "cycles       about {cycles:.0} to end time {}{limit}", model.settings.end_time)?;
    if model.settings.subcycles > 1 {
        let (m, classes) = (model.settings.subcycles, SubcycleClasses::new(&model.elements));
        let work = figure(classes.work(m));
        writeln!(
            out,
            "subcycles    {m}: {} elements in each cycle, {} in one of {m}; {work} of the \
             computations without subcycles",
            classes.fast, classes.slow
        )?;
    } else if let Some((m, work)) =
        subcycles::best(&model.job.time, &model.mesh, &model.settings, &model.elements)
    {
        let work = figure(work);
        writeln!(
            out,
            "subcycles    none; time.subcycles = {m} would leave {work} of the element computations"
        )?;
    }
    if let Some(adaptivity) = &model.settings.adaptivity {
        let may = |part: &u32| adaptivity.parts.binary_search(part).is_ok();
        let elements = model.mesh.elements.iter().zip(&model.elements.part);
        let quads = elements.filter(|(e, part)| e.shape == Shape::Quad4 && may(part)).count();
        writeln!(
            out,
            "adaptivity   {} of {} elements may be divided, levels {}, from {} degrees on; each \
             level halves the step",
            quads - adaptivity.kept.len(),
            model.mesh.elements.len(),
            adaptivity.levels,
            figure(adaptivity.angle.to_degrees())
        )?;
    }
    Ok(())
}

fn shapes(model: &Model, out: &mut String) -> std::fmt::Result {
    let q = &model.quality;
    let (low, high) = (q.min_side, q.max_side);
    writeln!(
        out,
        "sides        {} (element {}) to {} (element {}), median {}",
        figure(low.value),
        low.element,
        figure(high.value),
        high.element,
        figure(q.median_side)
    )?;
    writeln!(
        out,
        "aspect       {} at most (element {})",
        figure(q.max_aspect.value),
        q.max_aspect.element
    )?;
    writeln!(
        out,
        "warpage      {} degrees at most (element {})",
        figure(q.max_warpage_deg.value),
        q.max_warpage_deg.element
    )?;
    let (worst, element) = (q.min_jacobian.value, q.min_jacobian.element);
    writeln!(out, "jacobian     ratio {} at least (element {element})", figure(worst))?;
    writeln!(
        out,
        "skew         {} degrees at most (element {})",
        figure(q.max_skew_deg.value),
        q.max_skew_deg.element
    )
}

fn loads(model: &Model, out: &mut String) -> std::fmt::Result {
    let fixed = model.nodes.fixed.iter().filter(|&&bits| bits != 0).count();
    let speed = |v: &[f64; 3]| v.iter().map(|c| c * c).sum::<f64>().sqrt();
    let fastest = model.nodes.velocity.iter().map(speed).fold(0.0, f64::max);
    writeln!(
        out,
        "start        fastest node at {}, {fixed} nodes fixed, in rigid bodies or with prescribed \
         motion, \
         {} rigid walls",
        figure(fastest),
        model.settings.walls.len()
    )?;
    let l = &model.settings.loads;
    if l.act() {
        let faces: usize = l.pressures.iter().map(|p| p.faces.len()).sum();
        let (gravity, forces, motions) = (l.gravity.len(), l.forces.len(), l.motions.len());
        writeln!(
            out,
            "loads        {gravity} gravity, {forces} nodal, pressure on {faces} faces, \
             {motions} motions"
        )?;
    }
    for bag in &l.airbags {
        let turned = bag.faces.iter().filter(|face| face.inwards).count();
        writeln!(
            out,
            "airbag       {}: {} faces, {turned} with their normal turned outwards",
            bag.name,
            bag.faces.len()
        )?;
    }
    let belts = &model.settings.belts;
    if !belts.is_empty() {
        let elements: usize = belts.paths.iter().map(|path| path.segments.len()).sum();
        writeln!(
            out,
            "seat belts   {}: {elements} elements, {} rings, {} retractors, {} pretensioners",
            belts.paths.len(),
            belts.rings.len(),
            belts.retractors.len(),
            belts.pretensioners.len()
        )?;
    }
    let ties = &model.settings.ties;
    if !ties.is_empty() {
        let turning = ties.iter().filter(|t| t.rotations).count();
        let away = ties.iter().filter(|t| t.offset).count();
        writeln!(
            out,
            "tied         {} nodes, {turning} with rotations, {away} with offset",
            ties.len()
        )?;
    }
    let bodies = &model.settings.rigid;
    if !bodies.is_empty() {
        let members: usize = bodies.iter().map(|b| b.nodes.len()).sum();
        let joints = match model.settings.joints.len() {
            0 => String::new(),
            count => format!(", {count} joints"),
        };
        writeln!(out, "rigid        {} bodies of {members} nodes{joints}", bodies.len())?;
    }
    match &model.settings.contact {
        None => writeln!(out, "contact      none"),
        Some(c) => writeln!(
            out,
            "contact      {}, search by {} with skin {}",
            touching(c),
            c.search,
            figure(c.skin)
        ),
    }?;
    for c in model.settings.contact.iter() {
        let radius =
            |p: &Part| Some(format!("part {} with radius {}", p.id, figure(beams::half(c, p)?)));
        let beams: Vec<String> = model.settings.parts.iter().filter_map(radius).collect();
        if !beams.is_empty() {
            writeln!(out, "             bars in contact as lines: {}", beams.join(", "))?;
        }
    }
    for c in model.settings.contact.iter().flat_map(|c| c.each().skip(1)) {
        writeln!(out, "  interface  {}", touching(&c))?;
    }
    let fields = model.settings.field_times.len();
    writeln!(
        out,
        "output       a history row every {}, {fields} field files",
        figure(model.settings.history_interval)
    )
}

/// Describes the parts and settings of a contact or of one of its interfaces.
fn touching(c: &ContactInput) -> String {
    let list = |parts: &[u32]| match parts {
        [] => "all parts".to_string(),
        some => format!("parts {}", some.iter().map(u32::to_string).collect::<Vec<_>>().join(", ")),
    };
    let mut words = if c.name.is_empty() { String::new() } else { format!("{}: ", c.name) };
    words += &list(&c.parts);
    if !c.against.is_empty() {
        let how = if c.one_way { "held by" } else { "against" };
        words += &format!(" {how} {}", list(&c.against));
    }
    if !c.exclude.is_empty() {
        words += &format!(" without {}", list(&c.exclude));
    }
    if c.law == ContactInput::NO_LAW {
        return words + ", without contact";
    }
    if c.friction_table.is_empty() {
        words += &format!(", {} with friction {}", c.law, figure(c.friction));
    } else {
        words += &format!(", {} with friction by pressure and speed", c.law);
    }
    let decays = c.friction_decay > 0.0 && c.friction_table.is_empty();
    if let Some(dynamic) = c.friction_dynamic.filter(|_| decays) {
        words += &format!(" decreasing to {} with the slip speed", figure(dynamic));
    }
    if let Some(limit) = c.friction_limit.filter(|&l| l > 0.0) {
        words += &format!(", friction stress up to {}", figure(limit));
    }
    if let Some(thickness) = c.thickness {
        words += &format!(", thickness {}", figure(thickness));
    }
    if c.thickness_scale != 1.0 {
        words += &format!(", thickness times {}", figure(c.thickness_scale));
    }
    if c.shell_offset {
        words += ", at the middle surface of shells";
    }
    if c.birth > 0.0 {
        words += &format!(", from time {}", figure(c.birth));
    }
    if let Some(death) = c.death.filter(|d| d.is_finite()) {
        words += &format!(", to time {}", figure(death));
    }
    words
}

/// Formats a number with five digits, without an exponent for usual magnitudes.
pub(crate) fn figure(x: f64) -> String {
    if x == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e7).contains(&x.abs()) {
        return format!("{x:.4e}");
    }
    let digits = (4 - x.abs().log10().floor() as i32).max(0) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').into() } else { text }
}

#[cfg(test)]
mod tests {
    use super::figure;

    #[test]
    fn figures_are_short() {
        let cases = [
            (0.0, "0"),
            (1.0, "1"),
            (1234.5678, "1234.6"),
            (0.0123456, "0.012346"),
            (7.85e-6, "7.8500e-6"),
            (-2.5, "-2.5"),
        ];
        for (x, text) in cases {
            assert_eq!(figure(x), text);
        }
        assert_eq!(figure(123_456.0), "123456");
    }
}
