//! Particles in decks: cards and jobs, exports, errors. Units mm, ms, kg.

use crate::base::{BASE, MOVES, STEEL, model_of, refused, with};
use crumple::input::deck::export::export;
use crumple::input::job::{Model, read};
use crumple_proto::job::ParticlesInput;
use crumple_proto::mesh::Shape;
use std::fs;

/// Three particles of water, 2 mm apart, above the plate: a mass of 8e-6 kg is a volume of 8 mm^3.
const NODES: &str = "*NODE\n31,4,4,20\n32,6,4,20\n33,8,4,20\n";
const WATER: &str = "*PART\nwater\n3,3,3,3\n*SECTION_SPH\n3,1.3,1.0,1.0\n\
    *MAT_NULL\n3,1.0e-6,-0.25\n*EOS_MURNAGHAN\n3,7.0,0.343\n";
const ELEMENTS: &str = "*ELEMENT_SPH\n31,3,8.0e-6\n32,3,8.0e-6\n33,3,8.0e-6\n";

fn fluid(model: &Model) -> ParticlesInput {
    let part = model.job.part.iter().find(|part| part.id == 3).expect("the part");
    part.particles.clone().expect("particles")
}

/// Returns the cards with these changes.
fn changed(changes: &[(&str, &str)]) -> String {
    let mut text = format!("{NODES}{WATER}{ELEMENTS}");
    for (from, to) in changes {
        assert!(text.contains(from), "no {from} in\n{text}");
        text = text.replace(from, to);
    }
    text
}

fn assert_near(a: f64, b: f64) {
    assert!((a - b).abs() <= 4.0 * f64::EPSILON * b.abs(), "{a} is not {b}");
}

/// k0 gamma / ro = 2.401e6 is the square of 1549.5 mm/ms; the last digits are round-off.
#[test]
fn cards_become_particles() {
    let model = with(&changed(&[]));
    let water = fluid(&model);
    assert_near(water.spacing, 2.0);
    assert_near(water.sound_speed, 2.401e6_f64.sqrt());
    assert_eq!((water.density, water.exponent(), water.tension), (1e-6, 7.0, 0.25));
    assert_eq!((water.smoothing, water.viscosity), (1.3, [1.0, 2.0]));
    let particles: Vec<_> =
        model.mesh.elements.iter().filter(|e| e.shape == Shape::Point1).collect();
    // The shells and the solid, whose id is raised, have ids up to 11.
    let rows: Vec<_> = particles.iter().map(|e| (e.id.0, e.part, e.nodes[0].0)).collect();
    assert_eq!(rows, [(12, 3, 31), (13, 3, 32), (14, 3, 33)]);
}

/// A number below 0 and VOLUME are volumes; nend is the last of several nodes.
#[test]
fn masses_below_zero_are_volumes() {
    let one_line = format!("*ELEMENT_SPH\n{}\n", "31,3,-8.0,33");
    let volumes = ELEMENTS.replace("8.0e-6", "-8.0");
    let option = ELEMENTS.replace("8.0e-6", "8.0").replace("_SPH", "_SPH_VOLUME");
    let given = with(&changed(&[]));
    for elements in [one_line, volumes, option] {
        let model = with(&changed(&[(ELEMENTS, &elements)]));
        assert_near(fluid(&model).spacing, 2.0);
        assert_eq!(model.mesh.elements, given.mesh.elements, "{elements}");
    }
}

/// Other fields: smoothing length, viscosity of the part and of the deck, a linear equation.
#[test]
fn other_fields_become_keys() {
    let sphini = with(&changed(&[("3,1.3,1.0,1.0\n", "3,,,,3.0\n")]));
    assert_near(fluid(&sphini).smoothing, 1.5);
    let blank = with(&changed(&[("3,1.3,1.0,1.0\n", "3\n")]));
    assert_eq!(fluid(&blank).smoothing, 1.2);
    let hourglass =
        format!("{}*HOURGLASS\n9,,,,1.5,0.5\n", changed(&[("3,3,3,3\n", "3,3,3,3,9\n")]));
    assert_eq!(fluid(&with(&hourglass)).viscosity, [0.5, 1.5]);
    let of_deck = format!("{}*CONTROL_BULK_VISCOSITY\n1.25,0.75\n", changed(&[]));
    assert_eq!(fluid(&with(&of_deck)).viscosity, [0.75, 1.25]);
    let linear = "*EOS_LINEAR_POLYNOMIAL\n3,,2.25\n";
    let linear = fluid(&with(&changed(&[("*EOS_MURNAGHAN\n3,7.0,0.343\n", linear)])));
    assert_eq!(linear.exponent(), 1.0);
    assert_near(linear.sound_speed, 1500.0);
    // A viscosity far below the artificial one is not used.
    let thin = with(&changed(&[("-0.25", "-0.25,1e-9")]));
    assert_eq!(fluid(&thin), fluid(&with(&changed(&[]))));
    assert!(crumple::input::check::describe(&thin).contains("mu 1e-9"));
    let shocks = "*EOS_GRUNEISEN\n3,1647.0,1.92,-0.1,0.2,0.5,0.3\n";
    let shocks = fluid(&with(&changed(&[("*EOS_MURNAGHAN\n3,7.0,0.343\n", shocks)])));
    assert_eq!(shocks.hugoniot, Some([1.92, -0.1, 0.2, 0.5, 0.3]));
    assert_eq!((shocks.sound_speed, shocks.exponent), (1647.0, None));
    let control = "*CONTROL_SPH\n2,,,3,200,2,,1e18\n";
    assert_eq!(fluid(&with(&format!("{}{control}", changed(&[])))), fluid(&with(&changed(&[]))));
}

/// A file in other units: lengths in m, masses in g. Both kinds of sizes are converted.
#[test]
fn sizes_in_other_units_are_converted() {
    let folder = tempfile::tempdir().unwrap();
    let [deck, part] = ["deck.k", "part.k"].map(|name| folder.path().join(name));
    let include = "*INCLUDE_TRANSFORM\npart.k\n0,0,0,0,0,0,0\n0\n1.0e-3,1.0,1000.0\n0\n";
    for size in ["8.0e-3", "-8.0e-9"] {
        let nodes = "*NODE\n31,0.004,0.004,0.02\n32,0.006,0.004,0.02\n33,0.008,0.004,0.02\n";
        let water = WATER.replace("1.0e-6,-0.25", "1.0e6,-0.25e6").replace("0.343", "3.43e5");
        let elements = ELEMENTS.replace("8.0e-6", size);
        fs::write(&part, format!("*KEYWORD\n{nodes}{water}{elements}*END\n")).unwrap();
        fs::write(&deck, format!("{BASE}{STEEL}{MOVES}{include}*END\n")).unwrap();
        let model = read(&deck, &[]).unwrap_or_else(|report| panic!("{report}"));
        let water = fluid(&model);
        for (found, wanted) in [(water.spacing, 2.0), (water.density, 1e-6), (water.tension, 0.25)]
        {
            assert!((found - wanted).abs() < 1e-12 * wanted, "{size}: {found}, {wanted}");
        }
    }
}

/// A contact by a set of their nodes is one of their part.
#[test]
fn contact_of_a_set_of_particles_is_that_of_their_part() {
    let contact = "*CONTACT_AUTOMATIC_NODES_TO_SURFACE\n5,1,4,3\n\n\n*SET_NODE_LIST\n5\n31,32,33\n";
    let model = with(&format!("{}{contact}", changed(&[])));
    let contact = model.job.contact.as_ref().expect("a contact");
    assert_eq!((&contact.parts[..], &contact.against[..]), (&[3][..], &[1][..]));
}

/// Each card that particles cannot have is named with its value.
#[test]
fn wrong_cards_are_named() {
    let equation = "*EOS_MURNAGHAN\n3,7.0,0.343\n";
    let cases: &[(&[(&str, &str)], &str)] = &[
        (&[("33,3,8.0e-6", "33,3,9.0e-6")], "part 3 has particles of different sizes"),
        (&[("33,3,8.0e-6", "33,3,-8.0")], "part 3 has particles of different sizes"),
        (&[("33,3,8.0e-6", "33,3,0.0")], "`mass` is 0"),
        (&[("33,3,8.0e-6", "32,3,8.0e-6")], "node 32 is a particle twice"),
        (&[("33,3,8.0e-6", "33,3,8.0e-6,40")], "not all nodes from 33 to nend = 40 exist"),
        (&[("33,3,8.0e-6", "33,3,8.0e-6,1")], "not all nodes from 33 to nend = 1 exist"),
        (&[("33,3,8.0e-6", "-33,3,8.0e-6")], "particle -33 has an invalid id"),
        (&[("3,3,3,3\n", "3,3,1,3\n")], "particles are a fluid, but material 1 is none"),
        (&[("3,3,3,3\n", "3,3,3\n")], "part 3: particles need an equation of state"),
        (&[("3,3,3,3\n", "3,3,3,4\n")], "there is no *EOS_... with the id 4"),
        (&[("3,3,3,3\n", "3,3,3,3,4\n")], "there is no *HOURGLASS with the id 4"),
        (&[(ELEMENTS, "")], "part 3 has a *SECTION_SPH, but no particles"),
        (&[("-0.25", "0.25")], "`pc` = 0.25 is not supported"),
        (&[("-0.25", "-0.25,0.5")], "`mu` = 0.5 is not supported"),
        (&[("-0.25", "-0.25,,1.5")], "`terod` = 1.5 is not supported"),
        (&[("1.3,1.0,1.0", "1.3,1.0,1.0,,5.0")], "`death` = 5 is not supported"),
        (&[("1.3,1.0,1.0", "1.3,1.0,1.0,,,,1")], "`sphkern` = 1 is not supported"),
        (&[("0.343", "0.343,0.9")], "`v0` = 0.9 is not supported"),
        (&[("1.3,1.0,1.0", "2.5,1.0,1.0")], "smoothing is 2.5"),
        (
            &[(equation, "*EOS_TABULATED\n3,1.0,,,5\n")],
            "*EOS_TABULATED of particles is not supported",
        ),
        (
            &[(equation, "*EOS_LINEAR_POLYNOMIAL\n3,,2.25,1.0\n")],
            "*EOS_LINEAR_POLYNOMIAL of particles is not supported",
        ),
        (&[("31,3,8.0e-6", "31,1,8.0e-6")], "part 1 (plate): it has particles"),
        (&[(ELEMENTS, "*CONTROL_SPH\n,,,2\n*ELEMENT_SPH\n31,3,8.0e-6\n")], "`idim` = 2"),
        (&[(ELEMENTS, "*CONTROL_SPH\n,,,,,7\n*ELEMENT_SPH\n31,3,8.0e-6\n")], "`form` = 7"),
        (&[(ELEMENTS, "*CONTROL_SPH\n\n1\n*ELEMENT_SPH\n31,3,8.0e-6\n")], "`cont` = 1"),
        (&[(ELEMENTS, "*CONTROL_SPH\n,,,,,,,1e5\n*ELEMENT_SPH\n31,3,8.0e-6\n")], "`maxv` = 100000"),
    ];
    for (changes, what) in cases {
        let said = refused(&changed(changes));
        assert!(said.contains(what), "no {what} in\n{said}");
    }
    let erosion = format!("{}*MAT_ADD_EROSION\n3,,0.5\n\n", changed(&[]));
    assert!(refused(&erosion).contains("*MAT_ADD_EROSION of particles is not supported"));
}

/// Forms of fluids that differ get a warning next to an error of another card.
#[test]
fn other_forms_get_a_warning() {
    let wrong = changed(&[("33,3,8.0e-6", "33,3,0.0")]);
    let said = refused(&format!("{wrong}*CONTROL_SPH\n,7,,,,5\n,,,,,,1\n"));
    for what in ["`form` = 5 is ignored", "`iavis` = 1 is ignored", "`boxid` = 7 is ignored"] {
        assert!(said.contains(what), "no {what} in\n{said}");
    }
}

/// An export of a fluid whose numbers do not fit the cards has all of them, and the same elements.
#[test]
fn exported_particles_are_the_same() {
    let own = "$crumple: [[part]]\n$crumple: id = 3\n$crumple: [part.particles]\n\
               $crumple: spacing = 2.1\n$crumple: sound_speed = 1480.7\n\
               $crumple: viscosity = [0.0, 0.0]\n$crumple: contact_radius = 0.7\n";
    let text = format!("{BASE}{STEEL}{MOVES}{}", changed(&[]));
    let model = model_of(&text.replace("*KEYWORD\n", &format!("*KEYWORD\n{own}")));
    assert_eq!((fluid(&model).spacing, fluid(&model).viscosity), (2.1, [0.0; 2]));
    let deck = export(&model).expect("a deck");
    let again = model_of(deck.text.trim_end_matches("*END\n"));
    assert_eq!(fluid(&again), fluid(&model));
    assert_eq!(again.mesh.elements, model.mesh.elements);
    let left = deck.left.join("\n");
    for what in ["part.particles.viscosity: no card for 1", "contact_radius: no card for 1"] {
        assert!(left.contains(what), "no {what} in\n{left}");
    }
    assert!(!left.contains("element ids"), "{left}");
}
