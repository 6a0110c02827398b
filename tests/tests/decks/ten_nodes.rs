//! Tetrahedra of ten nodes in all formats of meshes and decks.

use crate::base::{BASE, MOVES, STEEL, model_of, with};
use crumple::input::mesh_file::read;
use crumple_proto::ids::NodeId;
use crumple_proto::mesh::{MeshElement, Shape};
use crumple_proto::quality::corner_jacobians;
use crumple_tests::program::{crumple_with, run};
use std::fmt::Write;
use std::fs;

/// Nodes of one tetrahedron; those on edges are in the middle.
const NODES: [[f64; 3]; 10] = [
    [0.0, 0.0, 0.0],
    [2.0, 0.0, 0.0],
    [0.0, 3.0, 0.0],
    [0.0, 0.0, 4.0],
    [1.0, 0.0, 0.0],
    [1.0, 1.5, 0.0],
    [0.0, 1.5, 0.0],
    [0.0, 0.0, 2.0],
    [1.0, 0.0, 2.0],
    [0.0, 1.5, 2.0],
];

/// Returns the nodes as lines, by the form of one.
fn nodes(line: impl Fn(usize, [f64; 3]) -> String) -> String {
    (1..).zip(NODES).map(|(id, x)| line(id, x)).collect()
}

/// Returns the same element as file name and content, in each format. The face x = 0 is the group
/// `side` where the format has groups.
fn files() -> Vec<(&'static str, String)> {
    let plain = nodes(|id, [x, y, z]| format!("{id} {x} {y} {z}\n"));
    // Gmsh has the last two edges in the other order.
    let ten = "1 2 3 4 5 6 7 8 10 9";
    let side = "1 4 3 8 10 7";
    let names = "$PhysicalNames\n2\n2 1 \"side\"\n3 2 \"body\"\n$EndPhysicalNames\n";
    let gmsh2 = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{names}$Nodes\n10\n{plain}$EndNodes\n\
         $Elements\n2\n1 9 2 1 1 {side}\n2 11 2 2 1 {ten}\n$EndElements\n"
    );
    let ids = (1..=10).fold(String::new(), |mut all, id| {
        let _ = writeln!(all, "{id}");
        all
    });
    let points = nodes(|_, [x, y, z]| format!("{x} {y} {z}\n"));
    let gmsh4 = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n{names}$Entities\n0 0 1 1\n\
         1 0 0 0 0 3 4 1 1 0\n1 0 0 0 2 3 4 1 2 0\n$EndEntities\n\
         $Nodes\n1 10 1 10\n3 1 0 10\n{ids}{points}$EndNodes\n\
         $Elements\n2 2 1 2\n2 1 9 1\n1 {side}\n3 1 11 1\n2 {ten}\n$EndElements\n"
    );
    let abaqus = format!(
        "*Node\n{}*Element, type=C3D10M, elset=body\n2, 1,2,3,4,5,6,7,8,9,10\n\
         *Surface, name=side\n2, S4\n",
        nodes(|id, [x, y, z]| format!("{id}, {x}, {y}, {z}\n"))
    );
    let nastran = format!(
        "BEGIN BULK\n{}CTETRA,2,1,1,2,3,4,5,6,+\n+,7,8,9,10\nENDDATA\n",
        nodes(|id, [x, y, z]| format!("GRID,{id},,{x:?},{y:?},{z:?}\n"))
    );
    let vtk = format!(
        "# vtk DataFile Version 3.0\nten nodes\nASCII\nDATASET UNSTRUCTURED_GRID\n\
         POINTS 10 double\n{points}CELLS 1 11\n10 0 1 2 3 4 5 6 7 8 9\nCELL_TYPES 1\n24\n"
    );
    vec![("a.msh", gmsh2), ("b.msh", gmsh4), ("a.inp", abaqus), ("a.bdf", nastran), ("a.vtk", vtk)]
}

/// Returns the positions of an element's nodes.
fn places(corners: &[u64], at: impl Fn(u64) -> [f64; 3]) -> Vec<[f64; 3]> {
    corners.iter().map(|&n| at(n)).collect()
}

/// All formats give the nodes in one order: the Jacobian is that of straight edges at each node.
/// Six-node triangles that bound the volume are a set of nodes.
#[test]
fn all_formats_have_one_order_of_nodes() {
    let folder = tempfile::tempdir().unwrap();
    for (name, text) in files() {
        let path = folder.path().join(name);
        fs::write(&path, text).unwrap();
        let mesh =
            read(&path, false, None).unwrap_or_else(|problems| panic!("{name}: {problems:?}")).mesh;
        let [element] = &mesh.elements[..] else { panic!("{name}: {}", mesh.elements.len()) };
        assert_eq!(element.shape, Shape::Tet10, "{name}");
        let at = |id: u64| mesh.nodes.iter().find(|n| n.id == id).unwrap().x;
        assert_eq!(places(&element.corners, at), NODES, "{name}");
        let jacobians = corner_jacobians(Shape::Tet10, &places(&element.corners, at));
        assert!(jacobians.iter().all(|j| (j - 24.0).abs() < 1e-12), "{name}: {jacobians:?}");
        if name.ends_with("msh") || name.ends_with("inp") {
            let side = &mesh.node_sets["side"];
            let on_side = |id: &u64| at(*id)[0] == 0.0;
            assert!(side.len() == 6 && side.iter().all(on_side), "{name}: {side:?}");
        }
    }
}

/// Gmsh has one order for all elements. Shells are read by their corners, and nodes on their sides
/// that no other element has are left out, with rows of the table; the edge node 5 is that of the
/// tetrahedron too.
#[test]
fn shells_next_to_tetrahedra_of_ten_nodes_are_read_by_their_corners() {
    let more = [
        [1.0, -3.0, 0.0],
        [1.5, -1.5, 0.0],
        [0.5, -1.5, 0.0],
        [0.0, 0.0, 9.0],
        [2.0, 0.0, 9.0],
        [2.0, 2.0, 9.0],
        [0.0, 2.0, 9.0],
        [1.0, 0.0, 9.0],
        [2.0, 1.0, 9.0],
        [1.0, 2.0, 9.0],
        [0.0, 1.0, 9.0],
        [1.0, 1.0, 9.0],
    ];
    let all: Vec<[f64; 3]> = NODES.into_iter().chain(more).collect();
    let (mut lines, mut ids, mut points) = (String::new(), String::new(), String::new());
    for (id, [x, y, z]) in (1..).zip(all) {
        let _ = writeln!(lines, "{id} {x} {y} {z}");
        let _ = writeln!(ids, "{id}");
        let _ = writeln!(points, "{x} {y} {z}");
    }
    let (six, nine) = ("1 2 11 5 12 13", "14 15 16 17 18 19 20 21 22");
    let eight = nine.trim_end_matches(" 22");
    let ten = "1 2 3 4 5 6 7 8 10 9";
    let names = "$PhysicalNames\n2\n2 1 \"plate\"\n3 2 \"body\"\n$EndPhysicalNames\n";
    let gmsh2 = format!(
        "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n{names}$Nodes\n22\n{lines}$EndNodes\n\
         $Elements\n3\n1 9 2 1 1 {six}\n2 16 2 1 1 {eight}\n3 11 2 2 1 {ten}\n$EndElements\n"
    );
    let gmsh4 = format!(
        "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n{names}$Entities\n0 0 1 1\n\
         1 0 0 0 0 3 4 1 1 0\n1 0 0 0 2 3 4 1 2 0\n$EndEntities\n\
         $Nodes\n1 22 1 22\n3 1 0 22\n{ids}{points}$EndNodes\n\
         $Elements\n3 3 1 3\n2 1 9 1\n1 {six}\n2 1 10 1\n2 {nine}\n3 1 11 1\n3 {ten}\n\
         $EndElements\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.msh");
    for (text, quad) in [(&gmsh2, "quad with 8 nodes"), (&gmsh4, "quad with 9 nodes")] {
        fs::write(&path, text).unwrap();
        let found = read(&path, false, None).unwrap_or_else(|problems| panic!("{problems:?}"));
        let of = |shape| found.mesh.elements.iter().find(|e| e.shape == shape).unwrap();
        assert_eq!(of(Shape::Tri3).corners, [1, 2, 11]);
        assert_eq!(of(Shape::Quad4).corners, [14, 15, 16, 17]);
        assert_eq!(of(Shape::Tet10).corners.len(), 10);
        assert_eq!(found.mesh.nodes.len(), 10 + 1 + 4);
        assert_eq!(found.mesh.node_sets["plate"], [1, 2, 5, 11, 14, 15, 16, 17]);
        for what in ["triangle with 6 nodes", quad] {
            let rows = found.rows.iter().filter(|row| row.what == what && row.count == 1);
            let became: Vec<&str> = rows.map(|row| row.became.as_str()).collect();
            assert!(
                became.len() == 1 && became[0].contains("by the corners"),
                "{what}: {became:?}"
            );
        }
    }
    // Solids of second order are others than these: their corners alone would be stiffer.
    fs::write(
        &path,
        gmsh2.replace("2 16 2 1 1", "2 19 2 1 1").replace(eight, &format!("{eight} 1 2 3 4 5")),
    )
    .unwrap();
    let problems = read(&path, false, None).err().expect("a pyramid is refused");
    assert!(problems[0].message.contains("pyramid with 13 nodes"), "{problems:?}");
}

/// Nastran allows elements that lack some nodes on edges; they are an error, as those with some
/// blanks would get other nodes there.
#[test]
fn an_element_without_some_nodes_on_edges_is_an_error() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.bdf");
    let (_, text) = files().into_iter().find(|(name, _)| name.ends_with("bdf")).unwrap();
    let lacks = text.replace("CTETRA,2,1,1,2,3,4,5,6,+", "CTETRA,2,1,1,2,3,4,,6,+");
    assert_ne!(lacks, text);
    fs::write(&path, lacks).unwrap();
    let problems = read(&path, false, None).err().expect("it is refused");
    assert!(problems[0].message.contains("element 2 lacks nodes on its edges"), "{problems:?}");
}

/// A pressure on a segment with the three corners of a side acts on its edges.
#[test]
fn a_segment_of_corners_is_the_whole_side() {
    let curve = "*DEFINE_CURVE\n1\n0.0,1.0\n1.0,1.0\n";
    let load = "*LOAD_SEGMENT\n1,2.0,0.0,101,103,102\n";
    let model = with(&format!("{}{curve}{load}", deck_lines()));
    let [pressure] = &model.settings.loads.pressures[..] else { panic!("one pressure") };
    assert_eq!(pressure.faces.len(), 4, "{:?}", pressure.faces);
}

/// The lines of a deck with the element on two lines, in part 2.
fn deck_lines() -> String {
    let nodes = nodes(|id, [x, y, z]| format!("{},{x},{y},{}\n", 100 + id, z - 40.0));
    format!("*NODE\n{nodes}*ELEMENT_SOLID\n7,2\n101,102,103,104,105,106,107,108,109,110\n")
}

/// A deck's element of ten nodes is read with all of them and written again as it was.
#[test]
fn a_deck_keeps_all_ten_nodes() {
    let of = |elements: &[MeshElement]| -> Vec<[NodeId; 10]> {
        elements.iter().filter(|e| e.shape == Shape::Tet10).map(|e| e.nodes).collect()
    };
    let model = with(&deck_lines());
    let wanted = [std::array::from_fn(|n| NodeId(101 + n as u64))];
    assert_eq!(of(&model.mesh.elements), wanted);

    let folder = tempfile::tempdir().unwrap();
    let [path, copy] = ["deck.k", "copy.k"].map(|name| folder.path().join(name));
    fs::write(&path, format!("{BASE}{STEEL}{MOVES}{}*END\n", deck_lines())).unwrap();
    let asked = ["export-deck", &path.to_string_lossy(), "--out", &copy.to_string_lossy()];
    run(crumple_with(&asked)).with_code(0);
    let text = fs::read_to_string(&copy).unwrap();
    let again = model_of(text.trim_end().trim_end_matches("*END"));
    assert_eq!(of(&again.mesh.elements), wanted);
}

/// The same as a Radioss deck: an element has a line and one with its nodes. An element with a
/// negative volume is turned with the nodes between its corners.
#[test]
fn a_radioss_deck_keeps_all_ten_nodes() {
    let of = |path: &std::path::Path| -> Vec<[NodeId; 10]> {
        let model = crumple::input::job::read(path, &[]).unwrap_or_else(|r| panic!("{r}"));
        let own = model.mesh.elements.iter().filter(|e| e.shape == Shape::Tet10);
        own.map(|e| e.nodes).collect()
    };
    let wanted: [NodeId; 10] = std::array::from_fn(|n| NodeId(101 + n as u64));
    let folder = tempfile::tempdir().unwrap();
    let [path, copy] = ["deck.k", "copy_0000.rad"].map(|name| folder.path().join(name));
    // Radioss has parts with one kind of solids.
    let own = "*PART\nten\n3,2,1\n";
    let lines = deck_lines().replace("\n7,2\n", "\n7,3\n");
    fs::write(&path, format!("{BASE}{STEEL}{MOVES}{own}{lines}*END\n")).unwrap();
    let asked = ["convert", &path.to_string_lossy(), &copy.to_string_lossy()];
    run(crumple_with(&asked)).with_code(0);
    assert_eq!(of(&copy), [wanted]);

    let text = fs::read_to_string(&copy).unwrap();
    let written: Vec<&str> = text.lines().skip_while(|l| !l.starts_with("/TETRA10")).collect();
    let turned = [0, 2, 1, 3, 6, 5, 4, 7, 9, 8].map(|n: usize| format!("{:>10}", 101 + n));
    fs::write(&copy, text.replace(written[2], &turned.concat())).unwrap();
    assert_eq!(of(&copy), [wanted]);
}

/// Both kinds of solids in a part have no Radioss deck.
#[test]
fn a_radioss_part_has_one_kind_of_solids() {
    let model = with(&deck_lines());
    let refused = crumple::input::deck::radioss::export::export(&model, "a").expect_err("refused");
    assert!(refused.contains("part 2 has tetrahedra of ten nodes and other solids"), "{refused}");
}

/// A mid-edge node far off its edge inverts the element: the check names it.
#[test]
fn an_element_with_a_node_beyond_its_neighbour_is_an_error() {
    let wrong = deck_lines().replace("105,1,0,-40", "105,2.6,0,-40");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{BASE}{STEEL}{MOVES}{wrong}*END\n")).unwrap();
    let report = crumple::input::job::read(&path, &[]).err().expect("it is inverted");
    assert!(report.to_string().contains("is inverted or twisted"), "{report}");
}
