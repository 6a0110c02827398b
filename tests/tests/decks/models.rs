//! Keywords and the job that they become, except contacts.

use super::base::{BASE, MOVES, STEEL, model_of, with};
use crumple::input::job::{Model, read};
use crumple_proto::job::Setting;
use crumple_proto::mesh::Shape;
use std::fs;

fn parameter(model: &Model, key: &str) -> f64 {
    let value = &model.job.material[0].parameters[key];
    value.as_float().unwrap_or_else(|| panic!("{key}: {value}"))
}

fn set(model: &Model, name: &str) -> Vec<u64> {
    model
        .mesh
        .node_sets
        .get(name)
        .unwrap_or_else(|| panic!("no {name}"))
        .iter()
        .map(|n| n.0)
        .collect()
}

#[test]
fn ids_that_shells_and_solids_share_are_distinguished() {
    let model = with("");
    let solid = model.mesh.elements.iter().find(|e| e.shape == Shape::Hex8).unwrap();
    assert_eq!((solid.id.0, model.mesh.elements.len()), (11, 3), "id 1 raised by 10");
    assert!(crumple::input::check::describe(&model).contains("ids raised by 10"));
}

#[test]
fn plastic_materials_keep_their_curves() {
    let kinematic =
        format!("{BASE}{MOVES}*MAT_003\n1,7.85e-6,200.0,0.3,0.25,0.5,1.0\n40.0,5.0,0.2\n");
    let model = model_of(&kinematic);
    assert_eq!(
        parameter(&model, "hardening_modulus"),
        200.0 * 0.5 / 199.5,
        "from the tangent modulus"
    );
    assert_eq!(
        (parameter(&model, "yield_stress"), parameter(&model, "failure_strain")),
        (0.25, 0.2)
    );
    let rows = |text: &str| {
        let table =
            model_of(&format!("{BASE}{MOVES}{text}")).job.material[0].parameters["hardening"]
                .clone();
        let row = |r: &toml::Value| [0, 1].map(|c| r[c].as_float().unwrap());
        table.as_array().unwrap().iter().map(row).collect::<Vec<_>>()
    };
    let points =
        "*MAT_PIECEWISE_LINEAR_PLASTICITY\n1,7.85e-6,200.0,0.3\n\n0.0,0.1,0.5\n0.3,0.4,0.6\n";
    let continued = |rows: &[[f64; 2]], stress: f64| {
        let [strain, reached] = rows[3];
        assert!(strain == 10.0 && (reached - stress).abs() < 1e-12, "{rows:?}");
    };
    assert_eq!(rows(points)[..3], [[0.0, 0.3], [0.1, 0.4], [0.5, 0.6]]);
    continued(&rows(points), 0.6 + 0.5 * 9.5);
    let curve = "*MAT_024\n1,7.85e-6,200.0,0.3\n0.0,0.0,9\n*DEFINE_CURVE\n9,0,1.0,1000.0\n\
                 0.1,3.0e-4\n0.5,4.0e-4\n";
    assert_eq!(
        rows(curve)[..3],
        [[0.0, 0.3], [0.1, 0.3], [0.5, 0.4]],
        "in other units, and constant before the first point"
    );
    continued(&rows(curve), 0.4 + 0.25 * 9.5);
    let jc = "*MAT_JOHNSON_COOK\n1,7.85e-6,80.0,0,0.25\n0.4,0.3,0.3,0.01,1.0,1800.0,293.0,0.001\n\
              450.0e-6\n";
    let model = model_of(&format!("{BASE}{MOVES}{jc}"));
    assert_eq!(model.job.material[0].law, "johnson_cook");
    assert_eq!(parameter(&model, "youngs_modulus"), 2.0 * 80.0 * 1.25, "from the shear modulus");
    assert_eq!(
        (parameter(&model, "reference_rate"), parameter(&model, "melting_temperature")),
        (0.001, 1800.0)
    );
}

#[test]
fn rigid_parts_are_bodies_with_what_joins_them() {
    let rigid = "*PART\ndriver\n3,1,2\n*MAT_RIGID\n2,7.85e-6,207.0,0.3\n1.0,4,7\n*NODE\n21,30,0,0\n\
        22,40,0,0\n23,40,10,0\n\
        24,30,10,0\n*ELEMENT_SHELL\n7,3,21,22,23,24\n*CONSTRAINED_EXTRA_NODES_SET\n3,5\n\
        *SET_NODE_LIST\n5\n13,16\n";
    let model = with(&format!("{rigid}*INITIAL_VELOCITY_RIGID_BODY\n3,1.0,0,0,0,0,2.0\n"));
    let body = &model.job.rigid[0];
    assert_eq!((body.name.as_str(), body.parts.as_slice()), ("part-3", [3].as_slice()));
    assert_eq!(
        body.fixed,
        ["rx", "ry", "rz", "x", "y"],
        "code 4 for translations, 7 for rotations"
    );
    assert_eq!(set(&model, body.nodes.as_ref().unwrap()), [13, 16]);
    let start = &model.job.initial_velocity[1];
    assert_eq!(
        (start.velocity, start.spin, start.centre),
        ([1.0, 0.0, 0.0], [0.0, 0.0, 2.0], [35.0, 5.0, 0.0])
    );
    let switched = with("*DEFORMABLE_TO_RIGID\n1\n");
    assert_eq!(switched.job.rigid[0].parts, [1]);
    let lines = "*CONSTRAINED_NODAL_RIGID_BODY\n9,0,5\n*SET_NODE_LIST\n5\n1,2,3,4\n*DEFINE_CURVE\n\
                 3\n0.0,0.0\n1.0,1.0\n";
    let led = with(&format!("{lines}*BOUNDARY_PRESCRIBED_MOTION_RIGID\n9,3,2,3,-4.0\n"));
    assert_eq!(
        (led.job.rigid[0].name.as_str(), led.job.rigid[0].nodes.as_deref()),
        ("body-9", Some("set-5"))
    );
    let motion = &led.job.motion[0];
    assert_eq!(
        (motion.rigid.as_deref(), motion.displacement),
        (Some("body-9"), Some([0.0, 0.0, -4.0]))
    );
    assert_eq!(
        (motion.dofs.as_slice(), motion.curve.as_deref()),
        (["z".to_string()].as_slice(), Some("curve-3"))
    );
}

#[test]
fn rigid_parts_with_nodes_in_common_are_one_body() {
    let model = with(
        "*DEFORMABLE_TO_RIGID\n1\n3\n*PART\nedge\n3,1,1\n*NODE\n31,30,0,12\n32,30,10,12\n\
         *ELEMENT_SHELL\n9,3,13,31,32,16\n",
    );
    assert_eq!(
        (model.job.rigid.len(), model.job.rigid[0].parts.as_slice()),
        (1, [1, 3].as_slice())
    );
}

#[test]
fn initial_velocities_of_all_forms() {
    let model = with(
        "*INITIAL_VELOCITY_GENERATION\n1,2,3.0,0,0,0,0,7\n1.0,2.0,3.0,0.0,4.0,0.0\n\
        *INITIAL_VELOCITY_NODE\n2,5.0\n3,5.0\n\
        4,0,6.0\n*INITIAL_VELOCITY\n0,0,8\n0,0,9.0\n*DEFINE_BOX\n8,-1,1,-1,1,-1,1\n\
        *DEFINE_COORDINATE_SYSTEM\n7,0,0,0,1,0,0\n0,1,0\n",
    );
    let start = &model.job.initial_velocity;
    assert_eq!(start[0].nodes, None);
    let box_of = start.iter().find(|v| v.nodes.as_deref() == Some("box-8")).unwrap();
    assert_eq!((set(&model, "box-8"), box_of.velocity), (vec![1], [0.0, 0.0, 9.0]));
    let spin = start.iter().find(|v| v.nodes.as_deref() == Some("part-1")).unwrap();
    assert_eq!((spin.spin, spin.centre), ([0.0, 3.0, 0.0], [1.0, 2.0, 3.0]), "along a unit vector");
    let equal = start.iter().find(|v| v.velocity == [5.0, 0.0, 0.0]).unwrap();
    assert_eq!(set(&model, equal.nodes.as_ref().unwrap()), [2, 3]);
}

#[test]
fn pressure_and_gravity_have_their_signs() {
    let curve = "*DEFINE_CURVE\n4\n0.0,1.0\n20.0,1.0\n";
    let segments = "*LOAD_SEGMENT\n4,2.0,0,11,12,15,14\n4,2.0,0,12,15,16,13\n4,2.0,0,1,4,3,2\n";
    let model =
        with(&format!("{curve}{segments}*LOAD_BODY_Z\n4,9.81\n*LOAD_NODE_POINT\n5,1,4,0.5\n"));
    let loads = &model.settings.loads;
    let of = |sign: f64| {
        loads.pressures.iter().filter(move |p| p.pressure == sign * 2.0).flat_map(|p| &p.faces)
    };
    let ids = |sign: f64| of(sign).map(|f| f.0.0).collect::<Vec<_>>();
    assert_eq!(
        (ids(1.0), ids(-1.0)),
        (vec![1, 11], vec![2]),
        "against the normal of a segment, towards solids"
    );
    assert_eq!(
        model.job.gravity[0].acceleration,
        [0.0, 0.0, -9.81],
        "the frame of reference accelerates upwards"
    );
    assert_eq!((set(&model, "load-node-5"), model.job.load[0].force), (vec![5], [0.5, 0.0, 0.0]));
}

/// Gravity and forces along the axes of a system, and gravity along a vector. The system turns the
/// axes by a quarter about z.
#[test]
fn gravity_and_forces_in_the_axes_of_a_system() {
    let system = "*DEFINE_COORDINATE_SYSTEM\n3,0,0,0,0,1,0\n-1,0,0\n\
                  *DEFINE_CURVE\n4\n0.0,1.0\n20.0,1.0\n";
    let loads = "*LOAD_BODY_X\n4,9.0,0,0,0,0,3\n*LOAD_NODE_POINT\n5,1,4,0.5,3\n\
                 *LOAD_BODY_VECTOR\n4,2.0\n0.0,0.0,3.0\n";
    let job = with(&format!("{system}{loads}")).job;
    let along: Vec<_> = job.gravity.iter().map(|g| g.acceleration).collect();
    assert_eq!(along, [[0.0, -9.0, 0.0], [0.0, 0.0, -6.0]]);
    assert_eq!(job.load[0].force, [0.0, 0.5, 0.0]);
}

/// A section with dro 1 makes rotational springs, between rigid bodies only.
#[test]
fn rotational_springs() {
    let link = "*PART\nlink\n3,3,11\n*SECTION_DISCRETE\n3,1\n\n*MAT_SPRING_ELASTIC\n11,4.0\n\
                *ELEMENT_DISCRETE\n101,3,5,11\n";
    let rigid = "*MAT_RIGID\n1,7.85e-6,207.0,0.3\n";
    let model = model_of(&format!("{BASE}{rigid}{MOVES}{link}"));
    let part = model.job.part.iter().find(|part| part.id == 3).expect("part 3");
    let spring = part.spring.as_ref().expect("a spring");
    assert_eq!((spring.rotational, spring.stiffness), (true, 4.0));
    // To the ground, about a direction: the node of the ground does not turn.
    let grounded = link.replace("101,3,5,11", "101,3,5,0,7");
    model_of(&format!("{BASE}{rigid}{MOVES}{grounded}*DEFINE_SD_ORIENTATION\n7,0,0,0,1\n"));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{BASE}{STEEL}{MOVES}{link}*END\n")).unwrap();
    let text = crumple::input::job::read(&path, &[]).err().expect("no bodies").to_string();
    assert!(text.contains("2 ends of rotational springs"), "{text}");
}

/// Pressure on shells acts against their normals; a set and an element that do not exist are named.
#[test]
fn pressure_on_shells() {
    let curve = "*DEFINE_CURVE\n4\n0.0,1.0\n20.0,1.0\n";
    let set = "*SET_SHELL_LIST\n9\n2\n*SET_SHELL_LIST\n10\n11\n";
    let loads = "*LOAD_SHELL_ELEMENT\n1,4,2.0\n*LOAD_SHELL_SET\n9,4,3.0\n";
    let model = with(&format!("{curve}{set}{loads}"));
    let of = |pressure: f64| {
        let all = model.settings.loads.pressures.iter().filter(|p| p.pressure == pressure);
        all.flat_map(|p| &p.faces).map(|face| face.0.0).collect::<Vec<_>>()
    };
    assert_eq!((of(2.0), of(3.0)), (vec![1], vec![2]));
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    let wrong = "*LOAD_SHELL_ELEMENT\n7,4\n*LOAD_SHELL_SET\n8,4\n10,4\n";
    fs::write(&path, format!("{BASE}{STEEL}{MOVES}{curve}{set}{wrong}*END\n")).unwrap();
    let text = crumple::input::job::read(&path, &[]).err().expect("no such shell").to_string();
    for words in [
        "there is no shell 7",
        "no *SET_SHELL_... with the id 8",
        "set 10 has no shells of the deck",
    ] {
        assert!(text.contains(words), "{words}: {text}");
    }
}

#[test]
fn what_is_held_comes_from_cards_and_codes() {
    let model = with(
        "*BOUNDARY_SPC_NODE\n2,0,1,0,1\n3,0,1,0,1\n*SET_NODE_GENERAL\n6\nPART,2\nDBOX,1\n\
        *DEFINE_BOX\n1,-1,11,-1,11,9,11\n\
        *BOUNDARY_SPC_SET\n6,0,0,1\n",
    );
    let held = |node: u64| {
        model.nodes.fixed[model.mesh.nodes.iter().position(|n| n.id.0 == node).unwrap()]
    };
    assert_eq!([1, 2, 3, 5].map(held), [0b10, 0b111, 0b111, 0]);
    let coded =
        model_of(&format!("{}{STEEL}{MOVES}", BASE.replace("16,20,10,12", "16,20,10,12,5,7")));
    assert_eq!(coded.nodes.fixed[13], 0b11_1110, "y and z, and all rotations");
}

/// Constraints with a birth or a death are motions at rest; others hold for the whole run.
#[test]
fn constraints_may_hold_for_a_time() {
    let model = with(
        "*SET_NODE_LIST\n6\n11,14\n*BOUNDARY_SPC_SET_BIRTH_DEATH\n6,0,1,0,1,0,1\n2.0,5.0\n\
         *BOUNDARY_SPC_NODE_BIRTH_DEATH_ID\n9,held\n13,0,0,1\n0.0\n\
         *BOUNDARY_SPC_NODE_BIRTH_DEATH\n16,0,0,0,1\n1.0\n",
    );
    let held = |node: u64| {
        model.nodes.fixed[model.mesh.nodes.iter().position(|n| n.id.0 == node).unwrap()]
    };
    assert_eq!([11, 13, 16].map(held), [0, 0b10, 0]);
    let motions: Vec<_> =
        model.job.motion.iter().map(|m| (m.dofs.join(" "), m.velocity, m.birth, m.death)).collect();
    let rest = Some([0.0; 3]);
    let wanted = [("x z ry".to_string(), rest, 2.0, Some(5.0)), ("z".to_string(), rest, 1.0, None)];
    assert_eq!(motions, wanted);
    let nodes = |m: usize| {
        let set = model.job.motion[m].nodes.as_deref().expect("a set");
        model.mesh.node_sets[set].iter().map(|n| n.0).collect::<Vec<_>>()
    };
    assert_eq!([nodes(0), nodes(1)], [vec![11, 14], vec![16]]);
}

/// A curve of damping is its value, if it is constant from 0 to the end of the run.
#[test]
fn a_curve_of_damping_is_a_number_or_a_curve() {
    let card = |points: &str| format!("*DAMPING_GLOBAL\n4,9.0\n*DEFINE_CURVE\n4\n{points}\n");
    for points in ["0,3.0\n10,3.0", "-1,3.0\n5,3.0\n20,3.0", "0,3.0\n10,3.0\n11,0.0"] {
        assert_eq!(with(&card(points)).job.time.damping, 3.0, "{points}");
    }
    for points in ["0,3.0\n5,3.0", "0,3.0\n10,4.0", "2,3.0\n20,3.0", "0,3.0\n9,3.0\n11,0.0"] {
        let time = with(&card(points)).job.time;
        assert_eq!((time.damping, time.damping_curve.as_deref()), (1.0, Some("curve-4")));
    }
    let half = with("*DAMPING_GLOBAL\n4,9.0,0.5,0.5,0.5,0.5,0.5,0.5\n*DEFINE_CURVE\n4\n0,3\n9,4\n");
    assert_eq!(half.job.time.damping, 0.5);
    let report = crate::base::refused(&card("0,3.0\n10,-1.0"));
    assert!(report.contains("has the factor -1.0 at 10.0"), "{report}");
}

/// Rotations of nodes about an axis by their velocity or their angle.
#[test]
fn nodes_turn_about_an_axis_by_their_angle() {
    let model = with(
        "*SET_NODE_LIST\n6\n11,14\n*BOUNDARY_PRESCRIBED_MOTION_SET\n6,10,2,4,0.5\n3.0,2.0\n\
         *DEFINE_CURVE\n4\n0,0\n10,1\n",
    );
    let motion = &model.job.motion[0];
    assert_eq!((motion.rotation, motion.spin), (Some([0.0, 0.5, 0.0]), None));
    assert_eq!(motion.centre, [2.0, 0.0, 3.0]);
}

/// A line with a word for each field is read by its words where its columns are broken, with a
/// warning; with fewer words it is an error.
#[test]
fn numbers_beyond_their_columns_are_read_as_words() {
    let curve = |line: &str| {
        format!(
            "*LOAD_BODY_Z\n4,1.0\n*DEFINE_CURVE\n         4\n{line}\n\
             {:>20}{:>20}\n",
            "10.0", "2.0"
        )
    };
    let model = with(&curve("0.000000000000000E+00                 1.0"));
    assert_eq!(model.job.curve[0].points, [[0.0, 1.0], [10.0, 2.0]]);
    let says = |w: &str| model.warnings.iter().any(|warning| warning.message.contains(w));
    assert!(
        says("are not in their columns; the line is read word by word"),
        "{:?}",
        model.warnings
    );
    let report = crate::base::refused(&curve("0.000000000000000E+00                 1.0x"));
    assert!(report.contains("has to be a number"), "{report}");
    let mass = "*ELEMENT_MASS\n   1   11   1.0\n";
    let report = crate::base::refused(mass);
    assert!(report.contains("*ELEMENT_MASS"), "{report}");
}

#[test]
fn control_cards_set_the_run() {
    let model = with(
        "*CONTROL_TIMESTEP\n0,0.67,0,0,-1.0e-3\n*CONTROL_SHELL\n20,0,0,1,2,1\n*CONTROL_HOURGLASS\n\
        1,0.07\n\
        *CONTROL_BULK_VISCOSITY\n1.2,0.05\n*DATABASE_BINARY_D3PLOT\n0.5\n*DAMPING_GLOBAL\n0,3.0\n\
        *TITLE\nTwo\n",
    );
    let (time, plate, cube) = (&model.job.time, &model.job.part[0], &model.job.part[1]);
    assert_eq!((time.safety, time.mass_scaling_dt, time.damping), (0.67, 1e-3, 3.0));
    assert_eq!(
        ["warping", "thinning", "hourglass_coefficient"].map(|key| &plate.parameters[key]),
        [&true.into(), &true.into(), &0.07.into()]
    );
    assert_eq!(
        (&cube.parameters["bulk_viscosity"], model.job.output.field_interval),
        (&[0.05, 1.2].into(), 0.5)
    );
    assert_eq!(model.job.title, "Two");
}

#[test]
fn single_thicknesses_and_masses() {
    let shells = BASE.replace(
        "*ELEMENT_SHELL\n1,1,11,12,15,14\n2,1,12,13,16,15\n",
        "*ELEMENT_SHELL_THICKNESS\n1,1,11,12,15,14\n2.5,2.5,2.5,2.5\n2,1,12,13,16,15\n\
         2.5,2.5,2.5,2.5\n",
    );
    let model =
        model_of(&format!("{shells}{STEEL}{MOVES}*ELEMENT_MASS\n1,5,0.25\n2,6,0.25\n3,7,1.0\n"));
    assert_eq!(model.job.part[0].thickness, 2.5);
    assert!(
        model.mesh.elements.iter().all(|e| e.own.thickness == 0.0),
        "elements have the thickness \
        of the part"
    );
    // Corners without a thickness have that of the section, 1.
    let several = shells.replacen("2.5,2.5,2.5,2.5", "2.5,0.0,2.0,2.5", 1);
    let two = model_of(&format!("{several}{STEEL}{MOVES}"));
    let own: Vec<f64> =
        two.mesh.elements.iter().filter(|e| e.shape.is_shell()).map(|e| e.own.thickness).collect();
    assert_eq!((own, two.job.part[0].thickness), (vec![2.0, 2.5], 1.0));
    let text = crumple::input::deck::export::export(&two).unwrap().text;
    assert!(text.contains("*ELEMENT_SHELL_THICKNESS\n"), "{text}");
    assert_eq!(model_of(&text.replace("*END\n", "")).mesh.elements, two.mesh.elements);
    let below = model_of(&format!(
        "{}{STEEL}{MOVES}",
        BASE.replace("1,2,1.0,3\n1.0\n", "1,2,1.0,3\n1.0,1.0,1.0,1.0,-1.0\n")
    ));
    assert_eq!(below.job.part[0].offset, 1.0, "nodes on the lower face");
    let text = crumple::input::deck::export::export(&below).unwrap().text;
    assert_eq!(model_of(&text.replace("*END\n", "")).job.part[0].offset, 1.0);
    let masses: Vec<f64> = model.job.mass.iter().map(|m| m.mass).collect();
    assert_eq!(masses, [0.5, 1.0], "two nodes with 0.25 each, one with 1.0");
}

#[test]
fn planar_walls_have_their_sides_their_mass_and_their_nodes() {
    let sets =
        "*SET_NODE_LIST\n5\n1,2,3,4\n*SET_NODE_LIST\n6\n3\n*DEFINE_BOX\n7,-1,11,-1,11,-1,11\n";
    let walls = "*RIGIDWALL_PLANAR_FINITE_MOVING_FORCES_ID\n1,sled\n5,6\n0,0,-5,0,0,-3,0.2\n\
        8,0,-5,20,30\n100,4\n10,0\n\
        *RIGIDWALL_PLANAR\n5,0,7\n30,0,0,29,0,0\n0,0,0,1.5\n0,-1,0,0,0,0\n";
    let model = with(&format!("{sets}{walls}"));
    let sled = &model.job.wall[0];
    assert_eq!(
        (sled.name.as_str(), sled.point, sled.normal),
        ("sled", [0.0, 0.0, -5.0], Some([0.0, 0.0, 2.0]))
    );
    assert_eq!(
        (sled.edge, sled.lengths),
        (Some([8.0, 0.0, 0.0]), Some([20.0, 30.0])),
        "from the tail to its head"
    );
    assert_eq!((sled.mass, sled.speed, sled.friction), (Some(100.0), 4.0, 0.2));
    assert_eq!((sled.nodes.as_deref(), sled.except.as_deref()), (Some("set-5"), Some("set-6")));
    let plane = &model.job.wall[1];
    assert_eq!((plane.edge, plane.mass, plane.except.as_deref()), (None, None, None));
    assert_eq!(
        set(&model, plane.nodes.as_ref().unwrap()),
        [1, 2, 3, 4],
        "the nodes of the set in the box"
    );
    let near = &model.job.wall[2];
    assert_eq!(near.normal, Some([0.0, 1.0, 0.0]));
    assert_eq!(
        set(&model, near.nodes.as_ref().unwrap()),
        [1, 2, 5, 6, 11, 12, 13],
        "the nodes with y = 0"
    );
    let said = crumple::input::check::describe(&model);
    assert!(
        said.contains(
            "sled: soft 10: nodes are stopped within some cycles -> nodes are stopped at once"
        ),
        "{said}"
    );
    assert!(
        said.contains(
            "wall-2: stops nodes by nsid 5, boxid 7, offset 0.0 -> the 4 nodes of wall-2-nodes"
        ),
        "{said}"
    );
}

#[test]
fn shaped_walls_follow_curves() {
    let model = with(
        "*RIGIDWALL_GEOMETRIC_CYLINDER_MOTION_ID\n3,punch\n0\n0,-50,30,0,1,30,0.1\n5,100\n\
        4,1,0,0,-2\n\
        *RIGIDWALL_GEOMETRIC_SPHERE_ID\n8,ball\n0\n1,2,60,1,2,61,0.2\n7.5\n\
        *RIGIDWALL_GEOMETRIC_FLAT_MOTION_DISPLAY\n0\n0,0,-5,0,0,-4\n1,0,-5,20,30\n4,0,0,0,1\n9\n\
        *DEFINE_CURVE\n4\n0.0,0.0\n20.0,40.0\n",
    );
    let walls = &model.job.wall;
    let punch = walls.iter().find(|w| w.name == "punch").unwrap();
    assert_eq!(
        (punch.axis, punch.radius, punch.length),
        (Some([0.0, 51.0, 0.0]), Some(5.0), 100.0)
    );
    assert_eq!(
        (punch.displacement, punch.curve.as_deref()),
        (Some([0.0, 0.0, -1.0]), Some("curve-4")),
        "made a unit"
    );
    let ball = walls.iter().find(|w| w.name == "ball").unwrap();
    assert_eq!(
        (ball.point, ball.radius, ball.axis, ball.normal, ball.friction),
        ([1.0, 2.0, 60.0], Some(7.5), None, None, 0.2)
    );
    let plate = walls.iter().find(|w| w.lengths.is_some()).unwrap();
    assert_eq!((plate.velocity, plate.nodes.as_deref()), (Some([0.0, 0.0, 1.0]), None));
    assert!(
        crumple::input::check::describe(&model)
            .contains("punch: a cylinder of length 100 -> its ends are open")
    );
}

#[test]
fn springs_go_along_their_vectors_and_to_the_ground() {
    let parts = "*PART\nlink\n3,3,11\n*SECTION_DISCRETE\n3\n\n*MAT_SPRING_ELASTIC\n11,4.0\n\
                 *DEFINE_SD_ORIENTATION\n7,0,0,0,2\n";
    let model = with(&format!("{parts}*ELEMENT_DISCRETE\n101,3,5,0,7\n102,3,6,0,7\n"));
    let springs: Vec<_> = model.mesh.elements.iter().filter(|e| e.shape == Shape::Line2).collect();
    let ends: Vec<[u64; 2]> = springs.iter().map(|e| [e.nodes[0].0, e.nodes[1].0]).collect();
    assert_eq!(ends, [[5, 17], [6, 18]], "separate nodes");
    assert_eq!(model.job.part[2].spring.as_ref().unwrap().direction, Some([0.0, 0.0, 2.0]));
    let node = |id: u64| model.mesh.nodes.iter().position(|n| n.id.0 == id).unwrap();
    assert_eq!(
        (model.mesh.nodes[node(17)].x, model.nodes.fixed[node(17)]),
        ([0.0, 0.0, 10.0], 0b11_1111),
        "it neither moves nor turns"
    );
}

#[test]
fn springs_and_dampers_have_their_laws_and_scales() {
    let parts = "*PART\nlink\n3,3,11\n\n4,3,12\n\n5,3,13\n\n6,3,14\n*SECTION_DISCRETE\n3\n\n\
        *MAT_SPRING_ELASTIC\n11,4.0\n\
        *MAT_S02\n12,0.25\n*MAT_SPRING_NONLINEAR_ELASTIC\n13,8\n*MAT_DAMPER_NONLINEAR_VISCOUS\n\
        14,9\n\
        *DEFINE_CURVE\n8\n0.0,0.0\n1.0,3.0\n*DEFINE_CURVE\n9\n-1.0,-2.0\n1.0,2.0\n";
    let model = with(&format!(
        "{parts}*ELEMENT_DISCRETE\n1,3,5,11,0,0.5\n2,3,6,12,0,0.5\n3,4,7,15\n4,5,8,14,0,2.0\n\
         5,6,1,16\n"
    ));
    let springs: Vec<_> = model.mesh.elements.iter().filter(|e| e.shape == Shape::Line2).collect();
    assert_eq!(
        springs.iter().map(|e| (e.id.0, e.part)).collect::<Vec<_>>(),
        [(101, 3), (102, 3), (103, 4), (104, 5), (105, 6)]
    );
    assert_eq!((springs[0].nodes[0].0, springs[0].nodes[1].0), (5, 11));
    let law = |part: usize| model.job.part[part].spring.clone().unwrap();
    assert_eq!(
        (law(2).stiffness, law(2).damping, model.job.part[2].name.as_str()),
        (2.0, 0.0, "link"),
        "4 scaled by 0.5"
    );
    assert_eq!((law(3).damping, law(3).stiffness), (0.25, 0.0));
    assert_eq!(law(4).force_elongation, [[0.0, 0.0], [1.0, 6.0]]);
    assert_eq!(law(5).force_rate, [[-1.0, -2.0], [1.0, 2.0]]);
    let said = crumple::input::check::describe(&model);
    for line in [
        "part 3: *MAT_SPRING_ELASTIC scaled by 0.5 -> springs with stiffness",
        "part 5: curve 8 has no points for negative elongations -> extrapolated with its first \
         slope",
        "springs: ids that other elements have too -> ids raised by 100",
    ] {
        assert!(said.contains(line), "missing text: {line}\n{said}");
    }
}

/// Reads the base with an offset of each shell and a contact of all parts, or returns the report.
fn shifted(thicknesses: [f64; 2], offsets: [f64; 2], lines: &str) -> Result<Model, String> {
    let [t, u] = thicknesses.map(|t| format!("{t:>16}{t:>16}{t:>16}{t:>16}"));
    let [o, p] = offsets;
    let rows = format!(
        "*ELEMENT_SHELL_THICKNESS_OFFSET\n1,1,11,12,15,14\n{t}\n{o:>16}\n2,1,12,13,16,15\n{u}\n\
         {p:>16}\n"
    );
    let deck = BASE
        .replace("*ELEMENT_SHELL\n1,1,11,12,15,14\n2,1,12,13,16,15\n", &rows)
        .replace("11,0,0,12", "11,0,0,15");
    let contact = "*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5\n\n";
    let text = format!("{deck}{STEEL}{MOVES}{contact}{lines}*END\n");
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, text).unwrap();
    read(&path, &[]).map_err(|report| report.to_string())
}

/// Offsets of elements become the offset of their part; cntco asks for contact at the middle
/// surface.
#[test]
fn offsets_of_shells_and_contact_at_their_middle_surface() {
    let offset = |model: &Model| {
        (model.job.part[0].offset, model.job.contact.as_ref().unwrap().shell_offset)
    };
    let of = |thicknesses, offsets, lines: &str| {
        offset(&shifted(thicknesses, offsets, lines).unwrap_or_else(|report| panic!("{report}")))
    };
    let cntco = |value: i64| format!("\n*CONTROL_SHELL\n0\n0\n0,0,{value}\n");
    assert_eq!(of([2.0; 2], [0.5; 2], "\n"), (0.5, false));
    assert_eq!(of([2.0, 4.0], [-0.5, -1.0], &cntco(2)), (-0.5, true), "the same fraction");
    assert_eq!(of([2.0; 2], [0.5; 2], &cntco(1)), (0.5, true));
    assert_eq!(of([2.0; 2], [0.5; 2], &format!(",,,,0.5\n{}", cntco(2))), (0.5, true));
    assert_eq!(of([2.0; 2], [0.0; 2], &cntco(3)), (0.0, false), "no offset, no effect");
    let nloc =
        BASE.replace("*SECTION_SHELL\n1,2,1.0,3\n1.0\n", "*SECTION_SHELL\n1,2,1.0,3\n1,,,,1\n");
    let contact = "*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5\n\n\n";
    let model = model_of(&format!("{nloc}{STEEL}{MOVES}{contact}{}", cntco(2)));
    assert_eq!(offset(&model), (-1.0, true));
    let each = shifted([2.0, 4.0], [0.5, -0.5], &cntco(2)).unwrap_or_else(|r| panic!("{r}"));
    let own: Vec<Option<f64>> = each.mesh.elements.iter().map(|e| e.own.offset).collect();
    assert_eq!((own, offset(&each)), (vec![Some(0.5), Some(-0.25), None], (0.0, true)));
    for (offsets, lines, words) in [
        ([0.5, 25.0], "\n".to_string(), "they have to be from -10 to 10"),
        ([0.5; 2], format!(",,,,0.5\n{}", cntco(1)), "set cntco to 2"),
        ([0.5; 2], cntco(3), "set it to 0 (contact is at the nodes), 1 or 2"),
    ] {
        let report = shifted([2.0; 2], offsets, &lines).err().expect("it is refused");
        assert!(report.contains(words), "{words} in\n{report}");
    }
}

/// Beams with elform 3 are trusses, with any law.
#[test]
fn beams_without_moments_are_trusses() {
    let model =
        with("*PART\nrod\n3,3,1\n*SECTION_BEAM\n3,3\n2.5\n*ELEMENT_BEAM\n31,3,5,11,6\n32,3,6,12\n");
    let trusses: Vec<_> = model.mesh.elements.iter().filter(|e| e.part == 3).collect();
    let ends: Vec<_> = trusses.iter().map(|e| (e.shape, e.corners().len())).collect();
    assert_eq!(ends, [(Shape::Truss2, 2), (Shape::Truss2, 2)]);
    assert_eq!(model.job.part[2].truss.as_ref().unwrap().area, 2.5);
}

/// Beams with the parts that they join are beams, and a mass of a part is spread over its nodes.
#[test]
fn beams_of_welds_and_masses_of_parts() {
    let model = with(
        "*PART\nweld\n3,3,1\n*SECTION_BEAM\n3,3\n2.5\n*ELEMENT_BEAM_PID\n31,3,5,11,6\n1,2\n\
         32,3,6,12\n1,2\n*ELEMENT_MASS_PART\n1,0.6\n",
    );
    let welds = model.mesh.elements.iter().filter(|e| e.part == 3);
    assert_eq!(welds.map(|e| e.nodes[0].0).collect::<Vec<_>>(), [5, 6]);
    let mass = &model.job.mass[0];
    assert_eq!((mass.mass, model.job.mass.len()), (0.6, 1));
    for (node, mass) in model.mesh.nodes.iter().zip(&model.nodes.added_mass) {
        let share = if (11..=16).contains(&node.id.0) { 0.1 } else { 0.0 };
        assert!((mass - share).abs() < 1e-12, "node {}: {mass}", node.id);
    }
    for (card, words) in [
        ("1,0.6,0.9", "`finmass` = 0.9"),
        ("1,0.6,0.0,4", "`lcid` = 4"),
        ("9,0.6", "no *PART with the id 9"),
    ] {
        let said = crate::base::refused(&format!("*ELEMENT_MASS_PART\n{card}\n"));
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// dof 9 to 11 turn nodes about an axis through both offsets, which are in cyclic order.
#[test]
fn nodes_turn_about_an_axis_through_their_offsets() {
    let of = |dof: i32| {
        let model = with(&format!(
            "*SET_NODE_LIST\n5\n1,2\n*DEFINE_CURVE\n4\n0,1.0\n20,1.0\n\
             *BOUNDARY_PRESCRIBED_MOTION_SET\n5,{dof},0,4,0.5\n3.0,-2.0\n"
        ));
        let motion = model.job.motion[0].clone();
        (motion.dofs, motion.spin.unwrap(), motion.centre)
    };
    let names = |dofs: [&str; 2]| dofs.map(String::from).to_vec();
    assert_eq!(of(9), (names(["y", "z"]), [0.5, 0.0, 0.0], [0.0, 3.0, -2.0]));
    assert_eq!(of(10), (names(["z", "x"]), [0.0, 0.5, 0.0], [-2.0, 0.0, 3.0]));
    assert_eq!(of(11), (names(["x", "y"]), [0.0, 0.0, 0.5], [3.0, -2.0, 0.0]));
}

/// dof 4 and 8 are along a vector that is parallel to an axis, with the other axes free; -4 and -8
/// are along any vector.
#[test]
fn nodes_move_along_a_vector() {
    let lines = |dof: i32, head: &str| {
        format!(
            "*SET_NODE_LIST\n5\n1,2\n*DEFINE_CURVE\n4\n0,1.0\n20,1.0\n\
             *DEFINE_VECTOR\n6,1.0,0.0,0.0,{head}\n\
             *BOUNDARY_PRESCRIBED_MOTION_SET\n5,{dof},0,4,5.0,6\n"
        )
    };
    let names = |dofs: &[&str]| dofs.iter().map(|d| d.to_string()).collect::<Vec<_>>();
    let along = with(&lines(4, "1.0,0.0,-3.0")).job.motion[0].clone();
    assert_eq!((along.dofs, along.velocity.unwrap()), (names(&["z"]), [0.0, 0.0, -5.0]));
    let oblique = with(&lines(-4, "4.0,0.0,4.0")).job.motion[0].clone();
    assert_eq!(oblique.dofs, names(&["x", "y", "z"]));
    let velocity = oblique.velocity.unwrap();
    let expected = [3.0, 0.0, 4.0];
    assert!((0..3).all(|c| (velocity[c] - expected[c]).abs() < 1e-12), "{velocity:?}");
    let turns = with(&lines(8, "1.0,2.0,0.0")).job.motion[0].clone();
    assert_eq!((turns.dofs, turns.spin.unwrap()), (names(&["ry"]), [0.0, 5.0, 0.0]));
    for (dof, head, words) in
        [(4, "4.0,0.0,4.0", "use dof -4 or -8"), (-4, "1.0,0.0,0.0", "its vector has no length")]
    {
        let said = crate::base::refused(&lines(dof, head));
        assert!(said.contains(words), "{said}");
    }
    let missing = crate::base::refused(&lines(4, "1.0,0.0,1.0").replace("\n6,1.0", "\n7,1.0"));
    assert!(missing.contains("*DEFINE_VECTOR") && missing.contains('6'), "{missing}");
}

/// The first value of a parameter holds, unless *PARAMETER_DUPLICATION says otherwise.
#[test]
fn a_second_value_of_a_parameter_is_noticed() {
    let twice = |flag: &str| {
        let text = format!(
            "*KEYWORD\n{flag}*PARAMETER\nR end,4.0\n*PARAMETER\nR end,5.0\n{}{STEEL}{MOVES}",
            BASE.replace("*KEYWORD\n", "")
                .replace("*CONTROL_TERMINATION\n10.0", "*CONTROL_TERMINATION\n&end")
        );
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deck.k");
        fs::write(&path, format!("{text}*END\n")).unwrap();
        read(&path, &[]).map_err(|report| report.to_string())
    };
    let first = twice("").unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(first.job.end_time, 4.0);
    assert!(first.warnings.iter().any(|w| w.message == "parameter `end` has two values"));
    let last = twice("*PARAMETER_DUPLICATION\n2\n").unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(last.job.end_time, 5.0);
    assert!(twice("*PARAMETER_DUPLICATION\n3\n").is_err());
    for (flag, end) in [(5, 4.0), (4, 5.0)] {
        let silent = twice(&format!("*PARAMETER_DUPLICATION\n{flag}\n")).unwrap();
        assert_eq!(silent.job.end_time, end, "{flag}");
        assert!(!silent.warnings.iter().any(|w| w.message.contains("two values")), "{flag}");
    }
    let wrong = twice("*PARAMETER_DUPLICATION\n7\n").err().unwrap_or_default();
    assert!(wrong.contains("dflag is 7"), "{wrong}");
}

/// The inertia card of a rigid part sets mass, inertia and motion of its body; another centre of
/// mass than that of the elements is a warning.
#[test]
fn rigid_parts_may_have_their_own_inertia() {
    let with_card = |centre: &str| {
        let deck = BASE.replace(
            "*PART\nplate\n1,1,1\ncube\n2,2,1\n",
            &format!(
                "*PART\nplate\n1,1,1\n*PART_INERTIA\ncube\n2,2,2\n{centre},0.5\n\
                 1.0,0.1,0.2,2.0,0.3,2.5\n0,0,-3.0,0,0.7\n"
            ),
        );
        model_of(&format!("{deck}{STEEL}{MOVES}*MAT_RIGID\n2,7.85e-6,207.0,0.3\n"))
    };
    let model = with_card("5,5,5");
    let body = &model.job.rigid[0];
    assert_eq!((body.mass, body.inertia), (Some(0.5), Some([1.0, 2.0, 2.5, 0.1, 0.3, 0.2])));
    let start = model.job.initial_velocity.iter().find(|v| v.spin != [0.0; 3]).unwrap();
    assert_eq!(
        (start.velocity, start.spin, start.centre),
        ([0.0, 0.0, -3.0], [0.0, 0.7, 0.0], [5.0; 3])
    );
    let moved = |model: &Model| model.warnings.iter().any(|w| w.message.contains("centre of mass"));
    assert!(!moved(&model) && moved(&with_card("5,5,7")));
}

/// Wedges of elform 10 have the volume strain of each element, as tetrahedra have; those of elform
/// 15 have the default.
#[test]
fn wedges_take_the_volume_strain_of_their_section() {
    let cube = "1,2,1,2,3,4,5,6,7,8";
    assert!(BASE.contains(cube) && BASE.contains("*SECTION_SOLID\n2,1\n"));
    for (elform, wanted) in [(10, Some("element")), (15, None)] {
        let wedge = BASE
            .replace(cube, "1,2,1,2,3,4,5,5,8,8")
            .replace("*SECTION_SOLID\n2,1\n", &format!("*SECTION_SOLID\n2,{elform}\n"));
        let model = model_of(&format!("{wedge}{STEEL}{MOVES}"));
        let part = model.job.part.iter().find(|part| part.id == 2).expect("the wedge");
        let given = part.parameters.get("pressure");
        assert_eq!(given, wanted.map(Setting::from).as_ref(), "elform {elform}");
    }
}
