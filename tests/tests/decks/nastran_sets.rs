//! Sets of Nastran files as node sets: cards of the bulk data, and lines of the case control.

use super::mesh_details::{changed, good, refused, row, text_of};
use crumple::input::mesh_file::Fate;

/// A composite that no element has, and its material, are ignored; one that an element has is
/// refused.
#[test]
fn composites_without_elements_are_ignored() {
    let plate = text_of("broken/plate.bdf");
    let with = |cards: &str| changed(&plate, "ENDDATA", &format!("{cards}\nENDDATA"));
    let ply = "MAT8,30,150000.,9000.,.3,4000.\nPCOMP,20\n+,30,.1,0.,,30,.1,90.";
    let found = good("a.bdf", &with(ply));
    assert_eq!(row(&found, "PCOMP"), Some((Fate::Ignored, 1)));
    assert_eq!(row(&found, "MAT8"), Some((Fate::Ignored, 1)));
    let ids: Vec<u32> = found.mesh.parts.iter().map(|part| part.id).collect();
    assert_eq!(ids, [7, 8]);
    let used = changed(&with(ply), "CQUAD4         2       7", "CQUAD4         2      20");
    refused("a.bdf", &used, ":18: material MAT8 30 is not supported");
    let used = used.replace("MAT8,30,150000.,9000.,.3,4000.\n", "");
    refused("a.bdf", &used, ":18: property 20 is a composite");
    // A material that nothing names is refused, as are all others of its kind.
    refused("a.bdf", &with("MAT8,30,150000.,9000.,.3,4000."), "material MAT8 30 is not supported");
}

/// Comments name properties: their own names, or that of the only component of HyperMesh that has
/// them, by the id of its property or its own.
#[test]
fn names_of_hypermesh_are_those_of_parts() {
    let plate = text_of("broken/plate.bdf");
    let names = |comments: &str| {
        let text = changed(&plate, "ENDDATA", &format!("{comments}\nENDDATA"));
        let found = good("a.bdf", &text);
        found.mesh.parts.into_iter().map(|part| (part.id, part.name)).collect::<Vec<_>>()
    };
    for (comments, plate, bar) in [
        ("$HMNAME COMP                   7\"skin\" ", "skin", ""),
        ("$HMNAME COMP 1\"skin\" 7 \"shell\" 4\n$HMNAME COMP 2\"rib\" 8 \"rod\" 1", "skin", "rib"),
        ("$HMNAME PROP 7\"shell\" 4\n$HMNAME COMP 7\"skin\"", "shell", ""),
        ("$HMNAME COMP 1\"a\" 7 \"p\" 4\n$HMNAME COMP 2\"b\" 7 \"p\" 4", "", ""),
        ("$HMNAME COMP 3\"other\"", "", ""),
    ] {
        assert_eq!(names(comments), [(7, plate.to_string()), (8, bar.to_string())], "{comments}");
    }
}

/// Sets of the bulk data of Nastran are node sets, under the names that comments give them. Those
/// of elements and of properties have the nodes of their elements.
#[test]
fn sets_of_nastran_bulk_data_are_node_sets() {
    let plate = text_of("broken/plate.bdf");
    for (cards, name, nodes) in [
        ("SET1,4,1,3,6", "set_4", &[1, 3, 6][..]),
        ("SET1           4       2    THRU       4       6", "set_4", &[2, 3, 4, 6]),
        (
            "SET1*                  4               2            THRU               4\n*",
            "set_4",
            &[2, 3, 4],
        ),
        ("$HMSET        4        1 \"rim\" 18\nSET1,4,1,3", "rim", &[1, 3]),
        ("$HMSET        4        2 \"skin\" 18\nSET1,4,2", "skin", &[2, 3, 5, 6]),
        // There is no node 11, but an element.
        ("SET1,4,2,11", "set_4", &[2, 3, 5, 6]),
        ("SET3,4,GRID,5,6", "set_4", &[5, 6]),
        ("SET3,4,ELEM,1,THRU,2", "set_4", &[1, 2, 3, 4, 5, 6]),
        ("SET3,4,PROP,8", "set_4", &[3, 6]),
        ("SET,4,GRID,LIST\n+,1,THRU,5,EXCEPT,2,3", "set_4", &[1, 4, 5]),
        ("SET,4,ELEM\n+,1", "set_4", &[1, 2, 4, 5]),
    ] {
        let found = good("a.bdf", &changed(&plate, "ENDDATA", &format!("{cards}\nENDDATA")));
        assert_eq!(found.mesh.node_sets.get(name).map(Vec::as_slice), Some(nodes), "{cards}");
    }
    let with = |cards: &str| changed(&plate, "ENDDATA", &format!("{cards}\nENDDATA"));
    refused("a.bdf", &with("SET3,4,GRID,1,9"), ":18: set `set_4` has node 9, which is missing");
    // A set that does not say what it has may be one of elements that are not read.
    let found = good("a.bdf", &with("SET1,4,1,9\nSET1,5,30,THRU,40\nSET1,6,11,THRU,20"));
    assert_eq!(found.mesh.node_sets["set_4"], [1]);
    assert_eq!(row(&found, "ids of set set_4"), Some((Fate::Ignored, 1)));
    assert_eq!(row(&found, "SET1 5"), Some((Fate::Ignored, 1)));
    assert_eq!(found.mesh.node_sets["set_6"], [3, 6], "there is no node from 11 to 20");
    refused("a.bdf", &with("SET1,4,1,x"), ":18: SET1: set 4: `x` is not expected");
    refused("a.bdf", &with("SET1,,1,2"), ":18: SET1: the set has no id");
    let found = good("a.bdf", &with("SET3,4,POINT,1\nSET,5,MAT\n+,1\nSET3,6,ELEM,1,77"));
    assert_eq!(row(&found, "SET3 4 of POINT"), Some((Fate::Ignored, 1)));
    assert_eq!(row(&found, "SET 5 of MAT"), Some((Fate::Ignored, 1)));
    assert_eq!(row(&found, "ids of set set_6"), Some((Fate::Ignored, 1)));
    assert_eq!(found.mesh.node_sets["set_6"], [1, 2, 4, 5]);
}

/// Sets of the case control have nodes or elements, as the requests for output that name them.
/// Each keeps its content, also if another set has its number.
#[test]
fn sets_of_the_case_control_follow_their_requests() {
    let plate = text_of("broken/plate.bdf");
    let with = |lines: &str| changed(&plate, "SOL 101\n", &format!("SOL 101\nCEND\n{lines}\n"));
    let sets = "SET 4 = 1 THRU 5 EXCEPT 2,\n  3, 6\n set 5 = 2\nSET 6 = ALL\nSET 7 = 1.5, 2.5\n\
                DISP(PLOT) = 4\nSUBCASE 1\n  Stress = 5\n  SET 4 = 1\n  SPC = 7";
    let text = changed(&with(sets), "ENDDATA", "SET1,5,1\nENDDATA");
    let found = good("a.bdf", &text);
    for (name, nodes) in [
        ("set_4", &[1, 4, 5, 6][..]),
        ("set_4-2", &[1]),
        ("set_5", &[1]),
        ("set_5-2", &[2, 3, 5, 6]),
    ] {
        assert_eq!(found.mesh.node_sets[name], nodes, "{name}");
    }
    assert_eq!(row(&found, "SET 5 of the case control"), Some((Fate::Read, 1)));
    for unused in ["SET 6 of the case control", "SET 7 of the case control"] {
        assert_eq!(row(&found, unused), Some((Fate::Ignored, 1)));
        assert!(!found.mesh.node_sets.contains_key(&unused[..5].replace(' ', "_").to_lowercase()));
    }
    let named = good("a.bdf", &with("$HMSET 6 2 \"skin\"\nSET 6 = 1"));
    assert_eq!(named.mesh.node_sets["skin"], [1, 2, 4, 5]);
    refused("a.bdf", &with("SET 4 = 1, 9\nDISP = 4"), ":3: set `set_4` has node 9");
    refused("a.bdf", &with("SET 4 = 1, THRU\nDISP = 4"), ":3: SET 4: `THRU` is not expected");
}
