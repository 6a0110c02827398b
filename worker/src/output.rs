//! Field output of a worker: its piece of the fields at one time, and its ghost elements.

use crate::engine::Engine;
use crate::fem::blocks::Class;
use crate::fem::elements::PointFields;
use crate::math::row::{Row, xyz};
use crate::vtu::{self, Cells, FieldPiece, OptionalArrays};
use crumple_proto::ids::ElemId;
use crumple_proto::mesh::Shape;
use crumple_proto::report::PartRecord;
use std::collections::BTreeMap;
use std::io;
use std::path::Path;

/// Columns of a piece, cell by cell.
#[derive(Default)]
struct CellColumns {
    cells: Cells,
    plastic_strain: Vec<f32>,
    damage: Vec<f32>,
    von_mises: Vec<f32>,
    stress: Vec<[f32; 6]>,
    thickness: Vec<f32>,
    part: Vec<u32>,
    worker: Vec<u32>,
    /// Empty without a second decomposition of contact.
    contact_worker: Vec<u32>,
    class: Vec<u8>,
    element_id: Vec<i64>,
    /// Empty unless the job asks for all points.
    stress_of_points: Vec<f32>,
    plastic_strain_of_points: Vec<f32>,
}

/// Writes the fields of own elements and, if there are `several` workers, those of ghost
/// elements.
///
/// # Errors
/// The files cannot be written.
pub fn write_fields(engine: &Engine, index: usize, several: bool) -> io::Result<()> {
    let me = engine.nodes.me as usize;
    let folder = Path::new(&engine.settings.field_dir).join(vtu::step_folder(index));
    write_piece(
        engine,
        &folder.join(vtu::piece_name(me)),
        engine.nodes.local_count,
        &own_cells(engine),
    )?;
    if several {
        write_piece(
            engine,
            &folder.join(vtu::exterior_name(me)),
            engine.nodes.len(),
            &exterior_cells(engine),
        )?;
    }
    Ok(())
}

/// Writes the fields of own elements into a folder.
///
/// # Errors
/// The file cannot be written.
pub fn write_view(engine: &Engine, folder: &Path) -> io::Result<()> {
    let file = folder.join(vtu::piece_name(engine.nodes.me as usize));
    write_piece(engine, &file, engine.nodes.local_count, &own_cells(engine))
}

/// Returns the results by part, of own elements and of the surfaces on this worker.
pub fn part_records(engine: &Engine) -> Vec<PartRecord> {
    let mut parts = vec![PartRecord::default(); engine.settings.parts.len()];
    let mut around = BTreeMap::new();
    for b in &engine.blocks.blocks {
        for (i, e) in engine.blocks.elements[b.first..b.first + b.count].iter().enumerate() {
            if b.element.can_fail() && b.element.failed(b.state(i)) {
                let inverted = u64::from(b.element.is_deleted(b.state(i)));
                parts[e.record.part as usize].add(&PartRecord {
                    failed: 1,
                    inverted,
                    ..PartRecord::default()
                });
                continue; // failed elements are not shown
            }
            let x = e.nodes.map(|n| xyz(&engine.nodes.x[n as usize]));
            let f = b.element.fields(b.state(i), &x);
            for &n in &e.nodes[..e.record.shape.corners()] {
                let range: &mut [NodeRange; 2] = around.entry((e.record.part, n)).or_default();
                range[0].include(f.plastic_strain);
                range[1].include(f.von_mises);
            }
            let (plastic_strain, von_mises) = (f.plastic_strain, f.von_mises);
            let one =
                PartRecord { elements: 1, plastic_strain, von_mises, ..PartRecord::default() };
            parts[e.record.part as usize].add(&one);
        }
    }
    for ((part, _), [strain, stress]) in around {
        let (strain_jump, stress_jump) = (strain.width(), stress.width());
        parts[part as usize].add(&PartRecord { strain_jump, stress_jump, ..PartRecord::default() });
    }
    for (e, energies) in engine.blocks.energies() {
        let part = &mut parts[e.record.part as usize];
        part.internal.add(energies[0]);
        part.hourglass.add(energies[1]);
    }
    for (number, part) in parts.iter_mut().enumerate() {
        (part.near, part.touched) =
            engine.contact.as_ref().map_or((false, false), |c| c.record_of(number));
    }
    parts
}

/// Smallest and largest value of the elements around a node.
#[derive(Clone, Copy)]
struct NodeRange {
    low: f64,
    high: f64,
}

impl Default for NodeRange {
    fn default() -> Self {
        Self { low: f64::INFINITY, high: f64::NEG_INFINITY }
    }
}

impl NodeRange {
    fn include(&mut self, value: f64) {
        (self.low, self.high) = (self.low.min(value), self.high.max(value));
    }

    /// Returns the difference of both; zero if no value was included.
    fn width(&self) -> f64 {
        (self.high - self.low).max(0.0)
    }
}

fn own_cells(engine: &Engine) -> CellColumns {
    let mut c = CellColumns::default();
    for b in &engine.blocks.blocks {
        for (i, e) in engine.blocks.elements[b.first..b.first + b.count].iter().enumerate() {
            if e.record.failed {
                continue; // failed elements are not shown
            }
            let x = e.nodes.map(|n| xyz(&engine.nodes.x[n as usize]));
            let f = b.element.fields(b.state(i), &x);
            c.cells.push(e.record.shape, &e.nodes);
            c.plastic_strain.push(f.plastic_strain as f32);
            c.damage.push(f.damage as f32);
            c.von_mises.push(f.von_mises as f32);
            c.stress.push(f.stress.map(|s| s as f32));
            c.thickness.push(f.thickness as f32);
            c.points(engine.settings.field_points, || b.element.points(b.state(i), &x));
            c.class.push(match e.class {
                Class::Interior => vtu::INTERIOR,
                Class::Interface => vtu::INTERFACE,
            });
            c.name(engine, e.record.part, e.record.id, e.nodes[0]);
        }
    }
    c
}

fn exterior_cells(engine: &Engine) -> CellColumns {
    let mut c = CellColumns::default();
    let segments = engine.contact.iter().flat_map(|k| &k.surface.segments);
    for s in segments.filter(|s| !s.own) {
        let shape = match s {
            _ if s.is_line() => Shape::Beam2,
            _ if s.is_triangle() => Shape::Tri3,
            _ => Shape::Quad4,
        };
        c.cells.push(shape, &s.nodes);
        // A ghost has only position and thickness; its stress is with its owner.
        c.plastic_strain.push(0.0);
        c.damage.push(0.0);
        c.von_mises.push(0.0);
        c.stress.push([0.0; 6]);
        c.thickness.push(2.0 * s.half_thickness as f32);
        c.points(engine.settings.field_points, || vec![PointFields::default()]);
        c.class.push(vtu::EXTERIOR);
        c.name(engine, s.part, s.id.elem(), s.nodes[0]);
    }
    c
}

impl CellColumns {
    /// Adds the points of an element, `count` of them.
    fn points(&mut self, count: usize, points: impl Fn() -> Vec<PointFields>) {
        if count == 0 {
            return;
        }
        let own = points();
        for k in 0..count {
            let point = own[k.min(own.len() - 1)];
            self.stress_of_points.extend(point.stress.map(|s| s as f32));
            self.plastic_strain_of_points.push(point.plastic_strain as f32);
        }
    }

    fn name(&mut self, engine: &Engine, part: u32, id: ElemId, first_node: u32) {
        self.part.push(engine.settings.parts[part as usize].id);
        self.worker.push(engine.nodes.me);
        if let Some(regions) = &engine.halo.regions {
            let place = xyz(&engine.nodes.x[first_node as usize]);
            self.contact_worker.push(regions.tree.worker_of(place) as u32);
        }
        self.element_id.push(id.label() as i64);
    }
}

fn write_piece(engine: &Engine, path: &Path, points: usize, c: &CellColumns) -> io::Result<()> {
    let n = &engine.nodes;
    let single = |r: &Row| xyz(r).map(|a| a as f32);
    let rows = |rows: &[Row]| rows[..points].iter().map(single).collect::<Vec<_>>();
    let moved: Vec<[f32; 3]> =
        (0..points).map(|i| std::array::from_fn(|k| (n.x[i][k] - n.x0[i][k]) as f32)).collect();
    let velocity = rows(&n.v);
    let spin = if n.rotations { rows(&n.w) } else { vec![[0.0; 3]; points] };
    let mut cell_arrays = vec![
        vtu::PLASTIC_STRAIN.with(&c.plastic_strain),
        vtu::VON_MISES.with(&c.von_mises),
        vtu::STRESS.with(&c.stress),
        vtu::THICKNESS.with(&c.thickness),
        vtu::PART.with(&c.part),
        vtu::WORKER.with(&c.worker),
        vtu::CLASS.with(&c.class),
        vtu::ELEMENT_ID.with(&c.element_id),
    ];
    if engine.halo.regions.is_some() {
        cell_arrays.push(vtu::CONTACT_WORKER.with(&c.contact_worker));
    }
    if OptionalArrays::of(&engine.settings).damage {
        cell_arrays.push(vtu::DAMAGE.with(&c.damage));
    }
    let count = engine.settings.field_points;
    if count > 0 {
        cell_arrays.push(vtu::STRESS_OF_POINTS.of_points(count).with(&c.stress_of_points));
        let strains = vtu::PLASTIC_STRAIN_OF_POINTS.of_points(count);
        cell_arrays.push(strains.with(&c.plastic_strain_of_points));
    }
    let ids: Vec<i64> = n.id[..points].iter().map(|i| i.label() as i64).collect();
    let mut point_arrays = vec![
        vtu::DISPLACEMENT.with(&moved),
        vtu::VELOCITY.with(&velocity),
        vtu::ROTATIONAL_VELOCITY.with(&spin),
        vtu::NODE_ID.with(&ids),
    ];
    let forces = contact_forces(engine, points);
    if engine.settings.contact_forces {
        point_arrays.push(vtu::CONTACT_FORCE.with(&forces));
    }
    let piece = FieldPiece {
        time: engine.clock.time,
        points: &rows(&n.x),
        point_arrays: &point_arrays,
        cells: &c.cells,
        cell_arrays: &cell_arrays,
    };
    piece.write(path)
}

/// Returns the contact forces of the last step on the first `points` nodes; empty if the job does
/// not ask for them. Forces on ghosts are incomplete and are left out.
fn contact_forces(engine: &Engine, points: usize) -> Vec<[f32; 3]> {
    if !engine.settings.contact_forces {
        return Vec::new();
    }
    let local = engine.nodes.local_count;
    let contact = engine.contact.as_ref();
    let force = |i: usize| match contact.filter(|_| i < local) {
        Some(contact) => <[f64; 3]>::from(contact.force_on(i as u32)).map(|f| f as f32),
        None => [0.0; 3],
    };
    (0..points).map(force).collect()
}
