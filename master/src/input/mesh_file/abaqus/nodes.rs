//! Nodes of Abaqus and the systems of their coordinates: `*NODE, SYSTEM=` and `*SYSTEM`.

use super::blocks::AbaqusBlock;
use super::scope::{field, id_of, number_of};
use crate::input::deck::Affine;
use crate::input::mesh_file::content::FileNode;
use crate::input::mesh_file::reading::{Fate, MeshReading};
use crate::input::mesh_file::systems::{CoordinateKind, between};

/// Reads the nodes of a keyword. Their coordinates are along the axes of the last `*SYSTEM`.
pub fn nodes(block: &AbaqusBlock, axes: &Affine, reading: &mut MeshReading) -> Vec<FileNode> {
    let system = block.value("SYSTEM").unwrap_or("R").to_uppercase();
    let (kind, became) = match system.as_str() {
        "R" => (CoordinateKind::Rectangular, None),
        "C" => (CoordinateKind::Cylindrical, Some("cylindrical coordinates")),
        "S" => (CoordinateKind::Spherical, Some("spherical coordinates")),
        _ => {
            let message = format!("*NODE: SYSTEM={system} is no kind of coordinates");
            let help = "write R for rectangular, C for cylindrical or S for spherical ones";
            reading.error("system", block.place, message, help);
            return Vec::new();
        }
    };
    let help = "write id, x, y, z";
    let mut found = Vec::with_capacity(block.data.len());
    for line in &block.data {
        let Some(id) = id_of(line, 0) else {
            let message = format!("`{}` is no node id", field(line, 0));
            reading.error("node", line.place, message, help);
            continue;
        };
        let mut own = [0.0; 3];
        for (axis, value) in own.iter_mut().enumerate() {
            match number_of(line, axis + 1) {
                Ok(number) => *value = number.unwrap_or(0.0),
                Err(text) => {
                    let message = format!("node {id}: `{text}` is no coordinate");
                    reading.error("coordinate", line.place, message, help);
                }
            }
        }
        if kind == CoordinateKind::Spherical {
            // The angle about the z axis comes first, then that from the plane of x and y.
            let [radius, about, above] = own;
            own = [radius, 90.0 - above, about];
        }
        let x = axes.point(kind.rectangular(own));
        found.push(FileNode { id, x, place: line.place });
    }
    if let Some(became) = became {
        let became = format!("{became} of nodes, which are rectangular now");
        reading.row(Fate::Read, format!("*NODE, SYSTEM={system}"), found.len(), became);
    }
    found
}

/// Returns the axes of the nodes after `*SYSTEM`: its origin, a point on the x axis and, in the
/// second line, one in the plane of x and y. Without that line the z axis is that of the mesh, and
/// the x axis that of the given point in the plane of x and y. Without lines they are those of the
/// mesh. Reports points that give no axes and returns `None`.
pub fn axes(block: &AbaqusBlock, reading: &mut MeshReading) -> Option<Affine> {
    let help = "write the origin and a point on the x axis in the first line, and in the second \
                one a point in the plane of x and y that is not on the x axis";
    let mut given = Vec::new();
    for line in block.data.iter().take(2) {
        let mut numbers = Vec::new();
        for index in 0..line.fields.len() {
            match number_of(line, index) {
                Ok(number) => numbers.push(number.unwrap_or(0.0)),
                Err(text) => {
                    let message = format!("*SYSTEM: `{text}` is no coordinate");
                    reading.error("system", line.place, message, help);
                    return None;
                }
            }
        }
        given.push(numbers);
    }
    let point = |line: usize, first: usize| -> Option<[f64; 3]> {
        let numbers = given.get(line)?.get(first..)?;
        let of = |c: usize| numbers.get(c).copied().unwrap_or(0.0);
        (!numbers.is_empty()).then(|| [of(0), of(1), of(2)])
    };
    let became = "axes of the nodes after it, which are in those of the mesh now";
    reading.row(Fate::Read, "*SYSTEM", 1, became);
    let Some(a) = point(0, 0) else { return Some(Affine::default()) };
    let Some(b) = point(0, 3) else { return Some(Affine::translation(a)) };
    let (b, c) = match point(1, 0) {
        Some(c) => (b, c),
        None => {
            let [x, y] = [b[0] - a[0], b[1] - a[1]];
            ([a[0] + x, a[1] + y, a[2]], [a[0] - y, a[1] + x, a[2]])
        }
    };
    let own = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
    let found = between(own, [a, b, c]);
    if found.is_none() {
        let message = "*SYSTEM: its points are on a line and give no axes";
        reading.error("system", block.place, message, help);
    }
    found
}

#[cfg(test)]
mod tests {
    use crate::input::mesh_file::abaqus::read;
    use crate::input::mesh_file::testing::{errors_of, mesh_of};

    /// Returns the coordinates of the first node of a triangle whose nodes follow these lines
    /// [length].
    fn first(lines: &str) -> [f64; 3] {
        let more =
            "*SYSTEM\n*NODE\n2, 50., 0., 0.\n3, 0., 50., 0.\n*ELEMENT, TYPE=S3\n1, 1, 2, 3\n";
        mesh_of(read, &format!("{lines}\n{more}")).nodes[0].x
    }

    fn close(found: [f64; 3], wanted: [f64; 3]) {
        let apart = (0..3).map(|c| (found[c] - wanted[c]).abs()).fold(0.0, f64::max);
        assert!(apart < 1e-14, "{found:?}, not {wanted:?}");
    }

    /// A point of a cylinder at 90 degrees; one of a sphere at 90 degrees about z and 30 degrees
    /// above the plane of x and y: `y = 2 cos 30`, `z = 2 sin 30`.
    #[test]
    fn nodes_have_cylindrical_and_spherical_coordinates() {
        assert_eq!(first("*NODE, SYSTEM=C\n1, 2., 90., 5."), [0.0, 2.0, 5.0]);
        close(first("*NODE, SYSTEM=s\n1, 2., 90., 30."), [0.0, 3.0_f64.sqrt(), 1.0]);
        assert_eq!(first("*NODE, SYSTEM=R\n1, 2., 90., 5."), [2.0, 90.0, 5.0]);
    }

    /// Axes at (1, 2, 3): moved only; x along the y axis of the mesh, also if its point is above
    /// the plane; x along its z axis and y along its x axis. Without lines they are those of the
    /// mesh, as nodes 2 and 3 have them.
    #[test]
    fn nodes_are_along_the_axes_of_their_system() {
        let node = "*NODE\n1, 10., 20., 30.";
        assert_eq!(first(&format!("*SYSTEM\n1., 2., 3.\n{node}")), [11.0, 22.0, 33.0]);
        let turned = [1.0 - 20.0, 2.0 + 10.0, 3.0 + 30.0];
        assert_eq!(first(&format!("*SYSTEM\n1., 2., 3., 1., 7., 3.\n{node}")), turned);
        assert_eq!(first(&format!("*SYSTEM\n1., 2., 3., 1., 7., 9.\n{node}")), turned);
        let three = "*SYSTEM\n1., 2., 3., 1., 2., 8.\n4., 2., 5.\n";
        assert_eq!(first(&format!("{three}{node}")), [1.0 + 20.0, 2.0 + 30.0, 3.0 + 10.0]);
        // An angle of 90 degrees is along y of the system, which is x of the mesh.
        assert_eq!(first(&format!("{three}*NODE, SYSTEM=C\n1, 2., 90., 5.")), [3.0, 7.0, 3.0]);
    }

    /// Errors name their line.
    #[test]
    fn systems_without_axes_are_errors() {
        let node = "*NODE\n1, 0., 0., 0.\n2, 1., 0., 0.\n3, 0., 1., 0.\n\
                    *ELEMENT, TYPE=S3\n1, 1, 2, 3\n";
        for (system, wanted) in [
            ("*SYSTEM\n0., 0., 0., 1., 1., 1.\n2., 2., 2.\n", ":1: *SYSTEM: its points are on a"),
            ("*SYSTEM\n0., 0., 0., 0., 0., 1.\n", ":1: *SYSTEM: its points are on a line"),
            ("*SYSTEM\n0., zero, 0.\n", ":2: *SYSTEM: `zero` is no coordinate"),
        ] {
            let found = errors_of(read, &format!("{system}{node}"));
            assert!(found.len() == 1 && found[0].contains(wanted), "{found:?}");
        }
    }
}
