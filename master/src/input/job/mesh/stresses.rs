//! Stresses and plastic strains of elements at the start, from the rows of a job.

use super::{Few, LARGEST_ID};
use crumple_proto::ids::ElemId;
use crumple_proto::initial::InitialPoint;
use crumple_proto::mesh::{Mesh, MeshElement};
use std::collections::{HashMap, HashSet};

/// Name of a row in messages.
const ROW: &str = "a row is [element, point, position, xx, yy, zz, xy, yz, zx, plastic strain]";

/// Adds the rows of the list below `path` to those of a mesh; they replace those that its elements
/// had. Reports rows that do not fit it.
pub(super) fn assign(mesh: &mut Mesh, rows: &[[f64; 10]], path: &str, few: &mut Few<'_>) {
    if rows.is_empty() {
        return;
    }
    let at: HashMap<ElemId, &MeshElement> = mesh.elements.iter().map(|e| (e.id, e)).collect();
    let mut points = Vec::with_capacity(rows.len());
    let mut taken = HashSet::with_capacity(rows.len());
    for (index, row) in rows.iter().enumerate() {
        let path = || format!("{path}.stresses.{index}");
        let whole = |number: f64, least: f64, most: f64| {
            number.fract() == 0.0 && (least..=most).contains(&number)
        };
        let id = row[0];
        let element = at.get(&ElemId(id as u64)).filter(|_| whole(id, 0.0, LARGEST_ID));
        let Some(element) = element else {
            few.error("no element", path(), format!("there is no element {id}"), ROW);
            continue;
        };
        if !(element.shape.is_shell() || element.shape.is_solid()) {
            let message = format!("element {id} is neither a shell nor a solid");
            few.error("no element", path(), message, "remove this row");
        }
        if !whole(row[1], 1.0, 1e4) {
            let message = format!("element {id}: `{}` is no number of a point", row[1]);
            few.error("point", path(), message, ROW);
        }
        // A sum has no negative zero.
        let position = if element.shape.is_shell() { row[2] + 0.0 } else { 0.0 };
        if !(-1.0..=1.0).contains(&position) {
            let message = format!("element {id}: its point is at {position:?}");
            few.error("position", path(), message, "a position is from -1 to 1");
        }
        if row[3..].iter().any(|value| !value.is_finite()) || row[9] < 0.0 {
            let message = format!("element {id}: a stress is not finite, or its plastic strain is");
            let help = "stresses are finite, and plastic strains at least 0";
            few.error("value", path(), format!("{message} below 0"), help);
        }
        let point =
            InitialPoint { position, ..InitialPoint::of_row(element.id, row[1] as u32, row) };
        if !taken.insert((point.element, point.number, position.to_bits())) {
            let message =
                format!("element {id}: two rows for its point {} at {position:?}", row[1]);
            few.error("given twice", path(), message, "remove one of them");
        }
        points.push(point);
    }
    let given: HashSet<ElemId> = points.iter().map(|point| point.element).collect();
    mesh.initial.retain(|point| !given.contains(&point.element));
    mesh.initial.extend(points);
}
