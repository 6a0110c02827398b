//! Cards of keywords that are not supported: one error each, and none for what refers to them.

use super::base::{BASE, MOVES, STEEL, model_of, with};
use super::fates::{reading, said};
use super::radioss;
use crumple::input::check::describe;
use crumple::input::job::Model;
use std::collections::BTreeSet;

const ALLOWED: &[&str] = &["mesh.allow_unsupported=true"];

/// A part of beams and springs whose materials, a section, sets and a curve are not supported.
const UNSUPPORTED: &str = "*PART\nbeams\n3,3,3\nsprings\n4,4,4\nfoil\n5,5,1\n*SECTION_BEAM\n\
    3,1,1.0,2,1\n2.0,2.0\n*SECTION_DISCRETE\n4\n\n*NODE\n21,0,0,30\n22,10,0,30\n23,10,10,30\n\
    24,0,10,30\n*ELEMENT_BEAM\n1,3,21,22\n*ELEMENT_DISCRETE\n1,4,21,22\n*ELEMENT_SHELL_THICKNESS\n\
    7,5,21,22,23,24\n0.1,0.1,0.1,0.1\n8,1,11,12,15,14\n0.5,0.5,0.5,0.5\n\
    *MAT_ELASTIC_FLUID\n3,7.85e-6,207.0,0.3\n*MAT_SPRING_SQUIB\n4,1.0\n*SECTION_FPD\n5,1\n\
    *MAT_ADD_EROSION\n3\n,0.3\n*SET_NODE_LIST_SMOOTH_TITLE\nboth\n7\n1,2\n\
    *BOUNDARY_SPC_SET\n7,0,1,1,1\n*SET_NODE_ADD\n9\n7,10\n*SET_NODE_LIST\n10\n1,2\n\
    *SET_PART_SMOOTH\n8\n3\n*CONTACT_AUTOMATIC_SINGLE_SURFACE\n8,0,2,0\n\n\n\
    *LOAD_NODE_SET\n10,1,9\n\
    *LOAD_NODE_SET\n7,1,5\n*DEFINE_FUNCTION\n9\nf(t)=t\n*DEFINE_CURVE\n5\n0,0\n1,1\n\
    *LOAD_SEGMENT\n5,1.0,0.0,21,22,23,24\n5,1.0,0.0,11,12,15,14\n*SET_PART_LIST\n11\n1,3,5\n\
    *INITIAL_VELOCITY_RIGID_BODY\n3,1.0\n*LOAD_BODY_PARTS\n11\n*LOAD_BODY_Z\n5,1.0\n";

fn errors(report: &str) -> Vec<&str> {
    report.lines().filter(|line| line.starts_with("error:")).collect()
}

/// References to a card that is not supported give no further errors. With unsupported content, the
/// parts of such cards are left out and the rest runs.
#[test]
fn follow_up_errors_of_unsupported_cards_are_none() {
    let text = format!("{BASE}{STEEL}{MOVES}{UNSUPPORTED}");
    let report = reading(&text, &[]).err().expect("a report");
    let found = errors(&report);
    assert_eq!(found.len(), 6, "{report}");
    assert!(found.iter().all(|line| line.contains("is not supported")), "{report}");
    let words = "part 3 and its elements are left out: it needs mid 3, and *MAT_ELASTIC_FLUID is \
                 not supported";
    assert!(report.contains(words), "{report}");
    let model = reading(&text, ALLOWED).unwrap_or_else(|report| panic!("{report}"));
    let parts: BTreeSet<u32> = model.mesh.elements.iter().map(|e| e.part).collect();
    assert_eq!(parts, [1, 2].into());
    let shell = model.mesh.elements.iter().find(|e| e.id.0 == 8).expect("a shell");
    assert_eq!(shell.own.thickness, 0.5, "thicknesses stay with their shells");
    assert_eq!(model.mesh.node_sets["set-9"].len(), 2, "the other set of the union");
    let said = said(&model);
    for words in [
        "part 4 and its elements are left out: it needs mid 4",
        "part 5 and its elements are left out: it needs secid 5",
        "there is no *SET_NODE_... with the id 7: *SET_NODE_LIST_SMOOTH_TITLE is not supported",
        "there is no *DEFINE_CURVE with the id 9: *DEFINE_FUNCTION is not supported",
        "there is no *SET_PART_... with the id 8",
        "there is no *PART with the id 3: part 3 is left out",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// Conditions, loads, masses, histories and bodies of nodes of parts that are left out go with
/// them. The other nodes of a set keep theirs.
#[test]
fn nodes_of_parts_that_are_left_out_go_with_them() {
    let lines = "*BOUNDARY_SPC_NODE\n21,0,1,1,1\n*LOAD_NODE_POINT\n22,1,5,1.0\n\
        *ELEMENT_MASS\n1,21,0.5\n2,11,0.5\n*BOUNDARY_PRESCRIBED_MOTION_NODE\n23,1,2,5,1.0\n\
        *DATABASE_HISTORY_NODE\n24\n*SET_NODE_LIST\n20\n21,22,23\n\
        *CONSTRAINED_NODAL_RIGID_BODY\n50,0,20\n\
        *BOUNDARY_PRESCRIBED_MOTION_RIGID\n50,1,2,5,1.0\n\
        *SET_NODE_LIST\n22\n1,2,3,4\n*CONSTRAINED_NODAL_RIGID_BODY\n51,0,22\n\
        *CONSTRAINED_JOINT_SPHERICAL\n21,1\n*SET_NODE_LIST\n21\n12,21\n\
        *BOUNDARY_SPC_SET\n21,0,0,0,1\n*LOAD_SHELL_ELEMENT\n7,5,1.0\n\
        *CONSTRAINED_INTERPOLATION\n1,11,123\n21,123,1.0\n22,123,1.0\n";
    let text = format!("{BASE}{STEEL}{MOVES}{UNSUPPORTED}{lines}");
    let model = reading(&text, ALLOWED).unwrap_or_else(|report| panic!("{report}"));
    let job = &model.job;
    assert_eq!((job.fix.len(), job.motion.len(), job.rigid.len()), (1, 0, 1));
    assert_eq!(job.joint.len(), 0);
    assert_eq!(job.mass.iter().map(|m| m.mass).sum::<f64>(), 0.5);
    assert_eq!(job.output.node.len(), 0);
    let held: Vec<u64> = model.mesh.node_sets["set-21"].iter().map(|n| n.0).collect();
    assert_eq!(held, [12]);
    for words in [
        "all its nodes are those of parts that are left out",
        "the rigid body `body-50` is left out with all its nodes",
    ] {
        assert!(said(&model).contains(words), "{words}: {}", said(&model));
    }
}

/// Without its parts gravity does not act on the others.
#[test]
fn gravity_of_parts_that_are_left_out_does_not_act() {
    let gravity = |lines: &str| {
        let added = UNSUPPORTED.replace("*LOAD_BODY_PARTS\n11\n", lines);
        let text = format!("{BASE}{STEEL}{MOVES}{added}");
        reading(&text, ALLOWED).unwrap_or_else(|report| panic!("{report}"))
    };
    assert_eq!(gravity("*LOAD_BODY_PARTS\n11\n").job.gravity.len(), 1);
    for lines in ["*LOAD_BODY_PARTS\n8\n", "*LOAD_BODY_PARTS\n12\n*SET_PART_LIST\n12\n3,4\n"] {
        let model = gravity(lines);
        assert_eq!(model.job.gravity.len(), 0, "{lines}");
        let words = "*LOAD_BODY_PARTS: the model has no part of its sets";
        assert!(said(&model).contains(words), "{}", said(&model));
    }
}

/// A vector in a system that is left out has no direction: what has it is left out, too.
#[test]
fn vectors_in_a_system_that_is_left_out_are_left_out() {
    let base = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2\n");
    let rigid = "*MAT_RIGID\n2,7.85e-6,207.0,0.3\n*DEFINE_CURVE\n5\n0,0\n1,1\n\
        *DEFINE_COORDINATE_SYSTEM\n3,0,0,0,0,1,0\n-1,0,0\n\
        *INITIAL_VELOCITY\n0,0,0,0,3\n2.0\n*INITIAL_VELOCITY_NODE\n11,2.0,0,0,0,0,0,3\n\
        *INITIAL_VELOCITY_RIGID_BODY\n2,2.0,0,0,0,0,0,3\n\
        *INITIAL_VELOCITY_GENERATION\n1,2,0,2.0,0,0,0,3\n0,0,0\n\
        *LOAD_RIGID_BODY\n2,1,5,1.0,3\n*DEFINE_VECTOR\n4,0,0,0,1,0,0,3\n\
        *CONSTRAINED_RIGID_BODY_STOPPERS\n2,-5,0,0,0,0,4,4\n0,1e20,0\n";
    let text = format!("{base}{STEEL}{MOVES}{rigid}");
    let of = |sets: &[&str]| reading(&text, sets).unwrap_or_else(|report| panic!("{report}"));
    let count = |model: &Model| {
        let body = &model.job.rigid[0];
        (model.job.initial_velocity.len(), body.load.len(), body.stop.len())
    };
    assert_eq!(count(&of(&[])), (5, 1, 1));
    let model = of(&["mesh.leave_out=[\"DEFINE_COORDINATE_SYSTEM\"]"]);
    assert_eq!(count(&model), (1, 0, 0));
    let said = said(&model);
    for words in [
        "the initial velocity is left out: its nodes start without it",
        "the load is left out: it does not act on the body",
        "the stop is left out: it does not bound the motion of the body",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// A velocity of a box that is left out has no nodes, and is no error.
#[test]
fn a_velocity_of_a_box_that_is_left_out_is_left_out() {
    let text =
        format!("{BASE}{STEEL}{MOVES}*DEFINE_BOX\n8,0,1,0,1,0,1\n*INITIAL_VELOCITY\n0,0,8\n2.0\n");
    let of = |sets: &[&str]| reading(&text, sets).unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(of(&[]).job.initial_velocity.len(), 2);
    let model = of(&["mesh.leave_out=[\"DEFINE_BOX\"]"]);
    assert_eq!(model.job.initial_velocity.len(), 1);
    let words = "there is no *DEFINE_BOX with the id 8: *DEFINE_BOX is left out";
    assert!(said(&model).contains(words), "{}", said(&model));
}

/// The id of a thermal material is none of a mechanical one.
#[test]
fn thermal_materials_have_ids_of_their_own() {
    let thermal = "*MAT_THERMAL_ISOTROPIC\n9,7.85e-6\n0.5,0.05\n*PART\nextra\n3,1,9\n";
    let report = reading(&format!("{BASE}{STEEL}{MOVES}{thermal}"), ALLOWED);
    let report = report.err().expect("a report");
    assert!(report.contains("there is no *MAT_... with the id 9"), "{report}");
}

/// A fluid without its equation of state has no pressure; a metal has its own.
#[test]
fn parts_without_their_equation_of_state_are_left_out() {
    let of = |material: &str| {
        let base = BASE.replace("cube\n2,2,1\n", "cube\n2,2,2,9\n");
        let text = format!("{base}{STEEL}{MOVES}{material}*EOS_IDEAL_GAS\n9,718.0,1005.0\n");
        let report = reading(&text, &[]).err().expect("a report");
        assert_eq!(errors(&report).len(), 1, "{report}");
        reading(&text, ALLOWED).unwrap_or_else(|report| panic!("{report}")).mesh.elements.len()
    };
    assert_eq!(of("*MAT_NULL\n2,1e-9\n"), 2);
    let metal = "*MAT_JOHNSON_COOK\n2,7.85e-6,80.0,207.0,0.3\n0.3,0.5,0.3,0,1.0,1800,300,1e-3\n\
                 450,0,2.0\n0\n";
    assert_eq!(of(metal), 3);
}

/// An id that nothing has is still an error, also next to cards that are not supported.
#[test]
fn other_wrong_ids_are_errors() {
    let text = format!("{BASE}{STEEL}{MOVES}{UNSUPPORTED}*LOAD_NODE_SET\n77,1,5\n");
    let report = reading(&text, ALLOWED).err().expect("a report");
    assert_eq!(errors(&report), ["error: there is no *SET_NODE_... with the id 77"], "{report}");
    // A load on a set by an option that is not read does not vanish.
    let load = "*SET_SHELL_GENERAL\n6\nVOL,1\n*LOAD_SHELL_SET\n6,5,1.0\n";
    let report = reading(&format!("{BASE}{STEEL}{MOVES}{UNSUPPORTED}{load}"), ALLOWED);
    let report = report.err().expect("a report");
    assert!(report.contains("set 6 has no shells of the deck"), "{report}");
}

/// Beams whose section is refused, or that lack a third node, have one error.
#[test]
fn beams_have_one_error() {
    let beams = "*NODE\n21,0,0,30\n22,10,0,30\n*ELEMENT_BEAM\n1,3,21,22\n*PART\nbeams\n3,3,1\n";
    let of = |section: &str| {
        let text = format!("{BASE}{STEEL}{MOVES}{beams}*SECTION_BEAM\n{section}");
        let report = reading(&text, &[]).err().expect("a report");
        let found: Vec<String> = errors(&report).iter().map(|line| line.to_string()).collect();
        assert_eq!(found.len(), 1, "{report}");
        (found[0].clone(), reading(&text, ALLOWED))
    };
    let (error, allowed) = of("3,8,1.0,2,1\n2.0,2.0\n");
    assert!(error.contains("`elform` = 8 is not supported"), "{error}");
    let model = allowed.unwrap_or_else(|report| panic!("{report}"));
    assert!(said(&model).contains("part 3 and its elements are left out"), "{}", said(&model));
    let (error, _) = of("3,1,1.0,2,0\n2.0,2.0,2.0,2.0\n");
    assert!(error.contains("beam 101 has no third node"), "{error}");
}

/// The same for Radioss: materials and properties by name or number.
#[test]
fn radioss_decks_have_no_follow_up_errors() {
    let text = radioss::with(
        "/NODE
        i21 r0 r0 r30
        i22 r10 r0 r30
        /BEAM/3
        i1 i21 i22
        /SPRING/4
        i2 i21 i22
        /PART/3
        =beams
        i3 i7
        /PART/4
        =springs
        i8 i0
        /PROP/BEAM/3
        =bar
        _
        r0 r0
        r4 r1 r1 r2
        /MAT/FOAM_TAB/7
        =foam
        r1e-6
        /FAIL/TENSSTRAIN/7
        r0.1 r0.2
        /PROP/SPR_GENE/8
        =general
        r1
        /GRNOD/XYZ/30
        =far
        i1
        /BCS/1
        =held
        =   111 111         0        30
        /GRBEAM/BEAM/31
        =one
        i1
        /GRNOD/GRBEAM/32
        =its nodes
        i31
        /SURF/XYZ/40
        =far
        i1
        /GRNOD/SURF/41
        =on it
        i40",
    );
    let report = radioss::reading(&text, &[]).err().expect("a report");
    let found = errors(&report);
    assert_eq!(found.len(), 4, "{report}");
    let model = radioss::reading(&text, ALLOWED).unwrap_or_else(|report| panic!("{report}"));
    let said = radioss::said(&model);
    for words in [
        "part 4 and its elements are left out: it needs prop 8, and /PROP/SPR_GENE is not",
        "there is no /GRNOD/... with the id 30: /GRNOD/XYZ is not supported",
        "there is no /SURF/... with the id 40: /SURF/XYZ is not supported",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

/// Names of Radioss are known by number and by word; a name with another number is no typing
/// error.
#[test]
fn names_by_number_and_by_word_have_the_same_message() {
    let message = |lines: &str| {
        let report = radioss::reading(&radioss::with(lines), &[]).err().expect("a report");
        report.lines().next().unwrap_or_default().to_string()
    };
    let foam = |name: &str| message(&format!("/MAT/{name}/7\n=foam\nr1e-6"));
    assert_eq!(foam("LAW70").replace("LAW70", "FOAM_TAB"), foam("FOAM_TAB"));
    assert!(foam("LAW70").contains("is not supported yet: foam"), "{}", foam("LAW70"));
    let void = message("/PROP/VOID/7\n=void\nr1");
    assert!(void.contains("/PROP/VOID is not supported yet"), "{void}");
    for name in ["LAW37", "LAW45", "PLAS_TAP"] {
        let near = foam(name).contains("the nearest supported keyword");
        assert_eq!(near, name == "PLAS_TAP", "{}", foam(name));
    }
}

/// Without its second card an initial velocity has the defaults of the format; a spin needs it.
#[test]
fn an_initial_velocity_has_defaults_without_its_second_card() {
    let generation = "*INITIAL_VELOCITY_GENERATION\n2,2,0,3.0\n";
    for rest in ["", "*SET_NODE_LIST\n5\n1,2\n"] {
        let model = with(&format!("{generation}{rest}"));
        let text = describe(&model);
        assert!(text.contains("no second card -> its defaults"), "{text}");
        let velocity = &model.job.initial_velocity[1];
        assert_eq!((velocity.velocity[0], velocity.spin), (3.0, [0.0; 3]));
    }
    let spin = format!("{BASE}{STEEL}*INITIAL_VELOCITY_GENERATION\n2,2,1.0,3.0\n");
    let report = reading(&spin, &[]).err().expect("a report");
    assert!(report.contains("the axis of the initial spin has no direction"), "{report}");
    let model = model_of(&format!("{BASE}{STEEL}{generation}0,0,0\n"));
    assert!(!describe(&model).contains("no second card"));
}
