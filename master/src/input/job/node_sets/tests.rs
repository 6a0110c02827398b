//! Tests of sets by rule on a mesh whose sets can be counted by hand.

use super::super::tree::Node;
use super::super::{Model, inline_sets, read_text};
use super::SET_KEYS;
use std::fmt::Write;

/// Returns a job with a sheet of 4 x 3 quads of side 1 in the plane z = 0 (part 1, nodes 1 to 20,
/// by rows along x) and a block of 2 x 2 x 2 solids of side 1 from z = 5 (part 2, nodes 101 to
/// 127). Part 3 is a strip of 4 quads along the upper edge of the sheet (nodes 16 to 20 and 201
/// to 205).
fn job(more: &str) -> String {
    let mut nodes: Vec<(u64, [u64; 3])> = Vec::new();
    let grid = |nx: u64, k: u64| [k % nx, k / nx % nx, k / (nx * nx)];
    nodes.extend((0..20).map(|k| (1 + k, [k % 5, k / 5, 0])));
    nodes.extend((0..5).map(|k| (201 + k, [k, 4, 0])));
    nodes.extend((0..27).map(|k| {
        let [x, y, z] = grid(3, k);
        (101 + k, [x, y, 5 + z])
    }));
    let mut text = "end_time = 1.0\n[mesh]\nnodes = [".to_string();
    for (id, [x, y, z]) in &nodes {
        let _ = write!(text, "[{id}, {x}.0, {y}.0, {z}.0], ");
    }
    text += "]\nshells = [";
    for k in 0..12 {
        let first = 1 + k % 4 + 5 * (k / 4);
        let _ =
            write!(text, "[{}, 1, {first}, {}, {}, {}], ", k + 1, first + 1, first + 6, first + 5);
    }
    for k in 0..4 {
        let (low, high) = (16 + k, 201 + k);
        let _ = write!(text, "[{}, 3, {low}, {}, {}, {high}], ", 13 + k, low + 1, high + 1);
    }
    text += "]\nsolids = [";
    for k in 0..8 {
        let [x, y, z] = grid(2, k);
        let first = 101 + x + 3 * y + 9 * z;
        let face = |n: u64| format!("{n}, {}, {}, {}", n + 1, n + 4, n + 3);
        let _ = write!(text, "[{}, 2, {}, {}], ", 50 + k, face(first), face(first + 9));
    }
    text += "]\nnode_sets = { corner = [1, 2], sheet = [1, 2, 3] }\n";
    text += "[[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
             youngs_modulus = 207.0\npoisson = 0.3\n";
    for (id, name, thickness) in [(1, "plate", 1.0), (2, "block", 0.0), (3, "strip", 1.0)] {
        let _ = write!(
            text,
            "[[part]]\nid = {id}\nname = \"{name}\"\nmaterial = \"steel\"\n\
             thickness = {thickness}\n"
        );
    }
    text + more
}

fn model(more: &str) -> Model {
    read_text("sets.toml".into(), job(more), &[]).unwrap_or_else(|report| panic!("{report}"))
}

/// Returns the text of all problems of a job.
fn problems(more: &str) -> String {
    match read_text("sets.toml".into(), job(more), &[]) {
        Ok(_) => "none".into(),
        Err(report) => report.to_string(),
    }
}

/// Returns the node ids of a set with this rule and these keys.
fn ids(rule: &str) -> Vec<u64> {
    let model = model(&format!("[[set]]\nname = \"s\"\n{rule}\n"));
    model.mesh.node_sets["s"].iter().map(|id| id.0).collect()
}

/// A rule in the place of a name selects the nodes of the entry of `[[set]]` with this rule, also
/// within another rule and by `--set`. Its name is the path of the key, or its own.
#[test]
fn a_rule_may_stand_where_a_name_may() {
    let plane = "{ rule = \"plane\", point = [0.0, 0.0, 6.0], normal = [0.0, 0.0, 1.0] }";
    let inner = format!(
        "{{ rule = \"difference\", of = \"block\", sets = [{plane}, {{ rule = \"nodes\", \
         ids = [110] }}] }}"
    );
    let text = format!("[[fix]]\nnodes = {inner}\ndofs = [\"x\"]\n");
    let sets = model(&text).mesh.node_sets;
    let ids = |name: &str| sets[name].iter().map(|id| id.0).collect::<Vec<_>>();
    assert_eq!(ids("fix.0.nodes"), (111..119).collect::<Vec<u64>>());
    assert_eq!(ids("fix.0.nodes.sets.0"), (110..119).collect::<Vec<u64>>());
    assert_eq!(ids("fix.0.nodes.sets.1"), [110]);

    let one = format!("[[fix]]\nnodes = {plane}\ndofs = [\"x\"]\n");
    let moved = ["fix.0.nodes.point=[0.0, 0.0, 5.0]".to_string()];
    let model_of = |text: &str, sets: &[String]| {
        read_text("sets.toml".into(), job(text), sets).unwrap_or_else(|report| panic!("{report}"))
    };
    assert_eq!(model_of(&one, &moved).mesh.node_sets["fix.0.nodes"][0].0, 101);
    let named = one.replace("{ rule", "{ name = \"middle\", rule");
    let used = format!("{named}[[mass]]\nnodes = \"middle\"\nmass = 1.0\n");
    assert_eq!(model_of(&used, &[]).mesh.node_sets["middle"].len(), 9);

    let wrong = one.replace("plane\"", "plain\"");
    let report = problems(&wrong);
    assert!(report.contains("plain") && report.contains("nodes = {"), "{report}");
    let far = problems(&one.replace("6.0]", "60.0]"));
    assert!(far.contains("set `fix.0.nodes` has no nodes") && far.contains("nodes = {"), "{far}");
}

/// All keys that name a set take a rule.
#[test]
fn every_key_of_a_set_takes_a_rule() {
    for row in SET_KEYS {
        let rule = "{ rule = \"nearest\", point = [0.0, 0.0, 0.0] }";
        let text = format!("[[{}]]\n{} = {rule}\n", row.list, row.key);
        let mut tree = Node::parse(&text).unwrap_or_else(|_| panic!("{text}"));
        inline_sets::hoist(&mut tree);
        let value = tree.to_value();
        let path = format!("{}.0.{}", row.list, row.key);
        let list = row.list.split('.').fold(&value, |at, key| &at[key]);
        assert_eq!(list[0][row.key].as_str(), Some(path.as_str()), "{text}");
        assert_eq!(value["set"][0]["name"].as_str(), Some(path.as_str()), "{text}");
    }
}

/// Rules by coordinates, on nodes with whole coordinates: counts by hand. Nodes on the surface of
/// a region count as inside.
#[test]
fn regions_have_the_nodes_inside_and_on_their_surface() {
    let rule = "rule = \"box\"\nmin = [1.0, 1.0, 0.0]\nmax = [2.0, 9.0, 1.0]";
    assert_eq!(ids(rule), [7, 8, 12, 13, 17, 18, 202, 203]);
    assert_eq!(ids(&format!("{rule}\nof = \"plate\"")), [7, 8, 12, 13, 17, 18]);
    let sphere = "rule = \"sphere\"\npoint = [1.0, 1.0, 6.0]\nradius = 1.0";
    assert_eq!(ids(sphere), [105, 111, 113, 114, 115, 117, 123], "the centre and six neighbours");
    let plane = "rule = \"plane\"\npoint = [0.0, 0.0, 6.0]\nnormal = [0.0, 0.0, 2.0]";
    assert_eq!(ids(plane), (110..119).collect::<Vec<u64>>());
    assert_eq!(ids(&plane.replace("plane", "half_space")), (110..128).collect::<Vec<u64>>());
    let cylinder = "rule = \"cylinder\"\npoint = [1.0, 1.0, 0.0]\naxis = [0.0, 0.0, 3.0]\n\
                    radius = 1.0";
    assert_eq!(ids(cylinder).len(), 5 + 3 * 5, "a cross of five nodes in each of four layers");
    assert_eq!(ids(&format!("{cylinder}\nlength = 5.0")).len(), 5 + 5);
}

/// A tolerance is a length: 0.009 takes in nodes 0.008 outside; the default is a thousandth of
/// the shortest side, here 0.001.
#[test]
fn tolerances_are_lengths() {
    let plane = |z: f64, more: &str| {
        format!(
            "rule = \"plane\"\npoint = [0.0, 0.0, {z}]\nnormal = [0.0, 0.0, 1.0]\n\
             allow_empty = true\n{more}"
        )
    };
    assert_eq!(ids(&plane(7.0009, "")).len(), 9);
    assert_eq!(ids(&plane(7.0011, "")).len(), 0);
    assert_eq!(ids(&plane(7.008, "tolerance = 0.009")).len(), 9);
    assert_eq!(ids(&plane(7.008, "tolerance = 0.007")).len(), 0);
}

/// Nearest nodes, with equal distances by id, and nodes within a distance of others.
#[test]
fn distances_select_nodes() {
    let nearest = "rule = \"nearest\"\npoint = [0.4, 0.0, -3.0]";
    assert_eq!(ids(nearest), [1]);
    let four = "rule = \"nearest\"\npoint = [0.5, 0.5, 0.0]\ncount = 3";
    assert_eq!(ids(four), [1, 2, 6], "four are at the same distance: the lowest ids");
    let within = "rule = \"within\"\nfrom = \"corner\"\ndistance = 1.0";
    assert_eq!(ids(within), [1, 2, 3, 6, 7]);
    let within = "rule = \"within\"\nfrom = \"block\"\ndistance = 5.0\nof = \"plate\"";
    assert_eq!(ids(within), [1, 2, 3, 6, 7, 8, 11, 12, 13], "below the block");
    let across = "rule = \"within\"\nfrom = \"corner\"\ndistance = 4.13\nof = \"strip\"";
    assert_eq!(ids(across), [16, 17, 18, 19, 201, 202, 203], "sqrt(17) = 4.123 to node 203");
}

/// Free edges are those of the whole mesh, boundaries those of the part: the sheet and the strip
/// share the nodes 16 to 20.
#[test]
fn edges_and_faces_have_the_nodes_of_the_outline() {
    assert_eq!(ids("rule = \"free_edges\"").len(), 2 * 5 + 2 * 3, "of 4 x 4 quads");
    let free = ids("rule = \"free_edges\"\nof = \"plate\"");
    assert_eq!(free, [1, 2, 3, 4, 5, 6, 10, 11, 15, 16, 20], "the sides end at the strip");
    let boundary = ids("rule = \"boundary\"\nof = \"plate\"");
    assert_eq!(boundary, [1, 2, 3, 4, 5, 6, 10, 11, 15, 16, 17, 18, 19, 20]);
    let solids = ids("rule = \"boundary\"\nof = \"block\"");
    assert_eq!(
        solids,
        (101..128).filter(|&n| n != 114).collect::<Vec<u64>>(),
        "all but the centre"
    );
    assert_eq!(ids("rule = \"surface\"\nof = \"block\""), solids);
    assert_eq!(ids("rule = \"surface\"").len(), 25 + 26);
}

/// The layer of solids below is a set: its boundary has the inner faces, its surface does not.
#[test]
fn boundary_counts_elements_of_the_set_only() {
    let layer = "[[set]]\nname = \"low\"\nrule = \"box\"\nmin = [0.0, 0.0, 5.0]\n\
                 max = [2.0, 2.0, 6.0]\n";
    let of = |rule: &str| {
        let text = format!("{layer}[[set]]\nname = \"s\"\nrule = \"{rule}\"\nof = \"low\"\n");
        model(&text).mesh.node_sets["s"].iter().map(|id| id.0).collect::<Vec<u64>>()
    };
    assert_eq!(of("boundary"), (101..119).collect::<Vec<u64>>());
    assert_eq!(of("surface"), (101..119).filter(|&n| n != 114).collect::<Vec<u64>>());
}

/// Sets combine sets by rule, sets of the mesh, parts and bodies, in any order in the file.
#[test]
fn sets_combine_sets_parts_and_bodies() {
    let text = "[[set]]\nname = \"both\"\nrule = \"union\"\nsets = [\"seam\", \"corner\"]\n\
                [[set]]\nname = \"seam\"\nrule = \"intersection\"\nsets = [\"plate\", \"strip\"]\n\
                [[set]]\nname = \"rest\"\nrule = \"difference\"\nsets = [\"strip\", \"seam\"]\n\
                [[set]]\nname = \"hard\"\nrule = \"box\"\nmin = [0.0, 0.0, 7.0]\n\
                max = [9.0, 9.0, 9.0]\nof = \"body\"\n\
                [[set]]\nname = \"three\"\nrule = \"part\"\nparts = [3]\n\
                [[set]]\nname = \"listed\"\nrule = \"nodes\"\nids = [5, 101]\n\
                [[rigid]]\nname = \"body\"\nparts = [2]\n";
    let model = model(text);
    let of = |name: &str| model.mesh.node_sets[name].iter().map(|id| id.0).collect::<Vec<_>>();
    assert_eq!(of("seam"), [16, 17, 18, 19, 20]);
    assert_eq!(of("both"), [1, 2, 16, 17, 18, 19, 20]);
    assert_eq!(of("rest"), [201, 202, 203, 204, 205]);
    assert_eq!(of("hard"), (119..128).collect::<Vec<u64>>());
    assert_eq!(of("three").len(), 10);
    assert_eq!(of("listed"), [5, 101]);
}

/// The id of a part is its name, unless something has this name; also within a rule.
#[test]
fn a_part_may_be_meant_by_its_id() {
    let fix = |set: &str| format!("[[fix]]\nnodes = {set}\ndofs = [\"x\"]\n");
    let of = |text: &str, name: &str| {
        let model = model(text);
        model.mesh.node_sets[name].iter().map(|id| id.0).collect::<Vec<_>>()
    };
    let strip: Vec<u64> = (16..21).chain(201..206).collect();
    assert_eq!(of(&fix("\"3\""), "3"), strip);
    let edges = "rule = \"free_edges\"\nof = \"3\"";
    assert_eq!(ids(edges), ids(&edges.replace("\"3\"", "\"strip\"")));
    assert_eq!(ids("rule = \"union\"\nsets = [\"3\"]"), strip);
    let own = "[[set]]\nname = \"3\"\nrule = \"nodes\"\nids = [7]\n";
    assert_eq!(of(&format!("{own}{}", fix("\"3\"")), "3"), [7]);
    let report = problems(&fix("\"4\""));
    assert!(report.contains("there is no node set `4`"), "{report}");
}

/// Keys that take a set take a part, a rigid body or a rule.
#[test]
fn keys_take_parts_bodies_and_rules() {
    let text = "[[set]]\nname = \"rim\"\nrule = \"free_edges\"\n\
                [[fix]]\nnodes = \"rim\"\ndofs = [\"x\"]\n\
                [[initial_velocity]]\nnodes = \"strip\"\nvelocity = [0.0, 0.0, 1.0]\n\
                [[wall]]\npoint = [0.0, 0.0, -1.0]\nnormal = [0.0, 0.0, 1.0]\nexcept = \"body\"\n\
                [[rigid]]\nname = \"body\"\nparts = [2]\n";
    let model = model(text);
    assert_eq!(model.nodes.fixed.iter().filter(|&&f| f & 1 == 1).count(), 16 + 27);
    assert_eq!(model.nodes.velocity.iter().filter(|v| v[2] == 1.0).count(), 10);
    assert_eq!(model.settings.walls[0].except.len(), 27);
}

#[test]
fn errors_name_the_set_and_the_remedy() {
    let set = |rest: &str| format!("[[set]]\nname = \"s\"\n{rest}\n");
    let plane = "rule = \"plane\"\npoint = [0.0, 0.0, 9.0]\nnormal = [0.0, 0.0, 1.0]";
    let fix = |name: &str| format!("[[fix]]\nnodes = \"{name}\"\ndofs = [\"x\"]\n");
    let twice = "[[set]]\nname = \"a\"\nrule = \"union\"\nsets = [\"b\"]\n\
                 [[set]]\nname = \"b\"\nrule = \"union\"\nsets = [\"a\"]\n";
    let body = "[[rigid]]\nname = \"sheet\"\nparts = [2]\n";
    for (text, said) in [
        (set(plane), "set `s` has no nodes"),
        (set(plane), "the nearest node of the mesh is 2.000e0 outside"),
        (set("rule = \"sphere\"\nradius = 1.0"), "set `s` has no `point`"),
        (set(&format!("{plane}\ncount = 2")), "the rule of set `s` has no `count`"),
        (set("rule = \"sphere\"\npoint = [0, 0, 0]\nradius = 0.0"), "`radius` is 0.0"),
        (set("rule = \"box\"\nmin = [0, 0, 1]\nmax = [1, 1, 0]"), "at least `min`"),
        (set("rule = \"plane\"\npoint = [0, 0, 0]\nnormal = [0, 0, 0]"), "a direction, such as"),
        (set("rule = \"part\"\nparts = [4]"), "set `s`: there is no part 4"),
        (set("rule = \"nodes\"\nids = [77]"), "no element has the node 77"),
        (set("rule = \"nearest\"\npoint = [0, 0, 0]\ncount = 99"), "there are only 52 nodes"),
        (set("rule = \"nearest\"\npoint = [0, 0, 0]\ncount = 0"), "at least 1"),
        (set("rule = \"surface\"\nof = \"blok\""), "did you mean `block`"),
        (set("rule = \"circle\""), "`rule` cannot be the text \"circle\""),
        (set("rule = \"union\"\nsets = [\"s\"]"), "set `s` refers to itself"),
        (twice.into(), "set `a` refers to itself"),
        (format!("{}{}", set(plane), set("rule = \"surface\"")), "two entries of [[set]]"),
        (set("rule = \"surface\"").replace("\"s\"", "\"strip\""), "a set by rule and a part"),
        (set("rule = \"surface\"").replace("\"s\"", "\"corner\""), "and a node set of the mesh"),
        (set("rule = \"surface\"").replace("\"s\"", "\"\""), "a set has no name"),
        (format!("{body}{}", fix("sheet")), "`sheet` is a node set and a rigid body"),
        (fix("platte"), "did you mean `plate`"),
        (
            format!("{}{}", set(&format!("{plane}\nallow_empty = true")), fix("s")),
            "node set `s` is empty",
        ),
    ] {
        let report = problems(&text);
        assert!(report.contains(said), "{said}: {report}");
    }
}

/// A key that names a set with an error adds no error of its own.
#[test]
fn a_faulty_set_is_reported_once() {
    let text = "[[set]]\nname = \"s\"\nrule = \"part\"\nparts = [4]\n\
                [[fix]]\nnodes = \"s\"\ndofs = [\"x\"]\n";
    let report = problems(text);
    assert!(report.contains("1 error: nothing was run"), "{report}");
}
