//! What joins parts in keyword decks, beams and welds: each deck here adds lines to two plates above each other.

use crumple::job::{Model, read};
use crumple_proto::job::BeamSection;
use std::fs;

/// Units mm, ms, kg. Part 1: two shells at z = 0, nodes 1 to 6; part 2: two at z = 2, nodes 11 to 16.
const BASE: &str = "*KEYWORD\n*CONTROL_TERMINATION\n1.0\n*PART\nlow\n1,1,1\nhigh\n2,1,1\n*SECTION_SHELL\n1,2,1.0,3\n1.0\n\
    *MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n*INITIAL_VELOCITY\n0\n1.0\n*NODE\n1,0,0,0\n2,10,0,0\n3,20,0,0\n4,0,10,0\n5,10,10,0\n\
    6,20,10,0\n11,0,0,2\n12,10,0,2\n13,20,0,2\n14,0,10,2\n15,10,10,2\n16,20,10,2\n*ELEMENT_SHELL\n1,1,1,2,5,4\n\
    2,1,2,3,6,5\n3,2,11,12,15,14\n4,2,12,13,16,15\n";

fn with(lines: &str) -> Model {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{BASE}{lines}*END\n")).unwrap();
    read(&path, &[]).unwrap_or_else(|report| panic!("{report}"))
}

/// Vectors towards the second axes of beams, made square to their lines and of length 1.
fn second_axes(model: &Model) -> Vec<[f64; 3]> {
    let at = |id| model.mesh.nodes.iter().find(|n| n.id == id).map(|n| n.x).unwrap();
    let beam = |id| model.mesh.elements.iter().find(|e| e.id == id).unwrap();
    let axis = |&(id, towards): &(crumple_proto::ids::ElemId, [f64; 3])| {
        let [a, b] = [0, 1].map(|c| at(beam(id).nodes[c]));
        let line = [0, 1, 2].map(|c| b[c] - a[c]);
        let dot = |a: [f64; 3], b: [f64; 3]| (0..3).map(|c| a[c] * b[c]).sum::<f64>();
        let across = [0, 1, 2].map(|c| towards[c] - line[c] * dot(line, towards) / dot(line, line));
        across.map(|c| (c / dot(across, across).sqrt() * 1e12).round() / 1e12)
    };
    model.settings.axes.iter().map(axis).collect()
}

#[test]
fn beams_have_their_sections_and_axes() {
    let model = with(
        "*PART\nrib\n3,3,1\ntube\n4,4,1\n*SECTION_BEAM\n3,1\n3.0,3.0,2.0,2.0\n*SECTION_BEAM\n4,1,1.0,2,1.0\n\
        4.0,4.0,3.0,3.0\n*NODE\n99,0,50,0\n*ELEMENT_BEAM\n21,3,1,2,99\n22,4,2,3\n*ELEMENT_BEAM_ORIENTATION\n23,3,1,4\n\
        3.0,4.0,4.0\n",
    );
    let [rib, tube] = [2, 3].map(|i| model.job.part[i].beam.clone().unwrap());
    assert_eq!((rib.section, rib.height, rib.width), (BeamSection::Rectangle, 3.0, 2.0), "s is the second axis");
    assert_eq!((tube.section, tube.radius, tube.wall), (BeamSection::Tube, 2.0, 0.5), "diameters 4 and 3");
    let slanted = 1.0 / 25.0f64.sqrt();
    let rounded = |x: f64| (x * 1e12).round() / 1e12;
    assert_eq!(second_axes(&model)[0], [0.0, 1.0, 0.0], "towards node 99");
    assert_eq!(second_axes(&model)[2], [rounded(3.0 * slanted), 0.0, rounded(4.0 * slanted)], "a vector");
    assert_eq!(second_axes(&model)[1].map(f64::abs).iter().sum::<f64>(), 1.0, "along an axis of space, square to it");
    assert_eq!(model.mesh.nodes.len(), 12, "what shows the way is no node of the model");
    let text = crumple::check::describe(&model);
    assert!(
        text.contains("beams, elform 1 (Hughes-Liu) -> corotating beam, section tube; no transverse shear"),
        "{text}"
    );
}

#[test]
fn resultants_and_trusses_are_general_sections() {
    let model = with(
        "*PART\nbeam\n3,3,1\ntruss\n4,4,2\n*MAT_003\n2,7.85e-6,207.0,0.3,0.2\n*SECTION_BEAM\n3,2\n\
        5.0,7.0,9.0\n*SECTION_BEAM\n4,3\n6.0\n*ELEMENT_BEAM\n1,3,1,2,4\n22,4,2,3\n",
    );
    let [beam, truss] = [2, 3].map(|i| model.job.part[i].beam.clone().unwrap());
    assert_eq!((beam.area, beam.second_moments, beam.torsion), (5.0, [7.0, 9.0], 16.0), "j is iss + itt if blank");
    assert_eq!((truss.area, truss.second_moments, truss.torsion), (6.0, [0.0, 0.0], 0.0));
    assert!(crumple::check::describe(&model).contains("beams: ids that other elements have too -> ids raised by 100"));
}

#[test]
fn spot_welds_of_beams_break() {
    let model = with(
        "*PART\nweld\n3,3,2\n*SECTION_BEAM\n3,9,1.0,2,1.0\n5.0\n*MAT_100\n2,7.85e-6,207.0,0.3,0.4,2.0\n\
        0.5,3.0,4.0,4.0,0.0,6.0,6.0\n*ELEMENT_BEAM\n21,3,2,12\n",
    );
    let weld = model.job.part[2].beam.clone().unwrap().weld.unwrap();
    assert_eq!([weld.normal, weld.shear, weld.bending, weld.torsion], [3.0, 4.0, 6.0, 0.0]);
    let steel = model.job.material.iter().find(|m| m.law == "j2").unwrap();
    let number = |key: &str| steel.parameters[key].as_float().unwrap();
    let numbers = ["yield_stress", "hardening_modulus", "failure_strain"].map(number);
    assert_eq!(numbers, [0.4, 2.0, 0.5]);
}
