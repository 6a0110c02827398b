//! Contact cards and the interfaces that they become.

use super::base::{BASE, MOVES, STEEL, assert_refused, model_of, read_with, refused, with};
use crumple::input::job::{Model, read};
use crumple_tests::run_alone;
use std::fs;

#[test]
fn contacts_become_interfaces() {
    let model = with(
        "*CONTACT_AUTOMATIC_SINGLE_SURFACE_ID\n1,first\n1,0,3\n0.1,0.1\n\n\
        *CONTACT_AUTOMATIC_SURFACE_TO_SURFACE\n1,2,3,3\n\
        0.4,0.2,3.0\n\n2\n",
    );
    let contact = model.job.contact.as_ref().unwrap();
    assert_eq!(
        (contact.name.as_str(), contact.friction, contact.parts.as_slice()),
        ("first", 0.1, [1].as_slice())
    );
    let [pair] = contact.interface.as_slice() else {
        panic!("one interface: {:?}", contact.interface)
    };
    assert_eq!((pair.parts.as_slice(), pair.against.as_slice()), ([1].as_slice(), [2].as_slice()));
    assert_eq!(
        (pair.friction, pair.friction_dynamic, pair.friction_decay),
        (Some(0.4), Some(0.2), Some(3.0))
    );
    let pair = contact.each().nth(1).unwrap();
    assert_eq!(
        (pair.thickness, pair.thickness_scale, pair.birth, pair.death),
        (None, 1.0, 0.0, None)
    );
    assert!(
        crumple::input::check::describe(&model)
            .contains("soft 2 -> not used: contact needs no stiffness")
    );
    assert!(
        with("*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5\n\n\n")
            .job
            .contact
            .unwrap()
            .parts
            .is_empty(),
        "all"
    );
}

/// Contacts of nodes, and those of one way, hold the nodes of surfa only; that of segments (soft 2)
/// holds both sides.
#[test]
fn contacts_of_one_way_hold_one_side() {
    for (keyword, soft, one_way) in [
        ("AUTOMATIC_NODES_TO_SURFACE", 0, true),
        ("AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE", 1, true),
        ("ONE_WAY_SURFACE_TO_SURFACE", 0, true),
        ("FORMING_ONE_WAY_SURFACE_TO_SURFACE", 0, true),
        ("AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE", 2, false),
        ("AUTOMATIC_SURFACE_TO_SURFACE", 0, false),
    ] {
        let model = with(&format!("*CONTACT_{keyword}\n1,2,3,3\n\n\n{soft}\n"));
        let contact = model.job.contact.as_ref().unwrap();
        assert_eq!(contact.one_way, one_way, "{keyword}, soft {soft}");
        let words = crumple::input::check::describe(&model);
        assert_eq!(words.contains("parts 1 held by parts 2"), one_way, "{words}");
    }
}

/// A box selects the parts that have nodes in it; one that cuts a part is a warning. The plate is
/// at z 12, the cube from 0 to 10.
#[test]
fn boxes_select_parts_of_contacts() {
    let lines = |top: &str| {
        format!(
            "*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5,0,6\n\n\n\
             *DEFINE_BOX\n6,-1.0,30.0,-1.0,30.0,-1.0,{top}\n"
        )
    };
    let warned = |model: &Model| {
        model
            .warnings
            .iter()
            .any(|w| w.message.contains("box 6 has only some nodes of the parts 2"))
    };
    for (top, parts, cut) in
        [("11.0", vec![2], false), ("20.0", vec![1, 2], false), ("5.0", vec![2], true)]
    {
        let model = with(&lines(top));
        assert_eq!(model.job.contact.as_ref().unwrap().parts, parts, "{top}");
        assert_eq!(warned(&model), cut, "{top}: {:?}", model.warnings);
    }
    let missing = refused(&lines("9.0").replace("*DEFINE_BOX\n6", "*DEFINE_BOX\n7"));
    assert!(missing.contains("*DEFINE_BOX") && missing.contains('7'), "{missing}");
}

/// fs 2 selects the table fd: curves of the coefficient over the speed at ascending pressures. They
/// follow the table, or it names them.
#[test]
fn friction_of_a_table_depends_on_pressure_and_speed() {
    let curves = "*DEFINE_CURVE\n31\n0.0,0.3\n2.0,0.2\n*DEFINE_CURVE\n30\n0.0,0.1\n";
    let contact = "*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE\n1,2,3,3\n2.0,7,0.0,0.05\n\n";
    let rows = vec![[0.0, 0.0, 0.3], [0.0, 2.0, 0.2], [0.5, 0.0, 0.1]];
    for table in [
        format!("*DEFINE_TABLE\n7,0.001\n0.0\n500.0\n{curves}"),
        format!("{curves}*DEFINE_TABLE_2D\n7\n0.0,31\n0.5,30\n"),
    ] {
        let model = with(&format!("{contact}{table}"));
        let found = model.job.contact.as_ref().unwrap();
        assert_eq!((&found.friction_table, found.friction_limit), (&rows, Some(0.05)), "{table}");
        assert!(crumple::input::check::describe(&model).contains("fs 2, fd 7: a table"));
    }
    for (table, problem) in [
        ("", "there is no *DEFINE_TABLE with the id 7"),
        ("*DEFINE_TABLE\n7\n0.0\n1.0\n*DEFINE_CURVE\n31\n0.0,0.3\n", "2 values"),
        ("*DEFINE_TABLE_2D\n7\n0.0,32\n", "there is no *DEFINE_CURVE with the id 32"),
        ("*DEFINE_TABLE_2D\n7\n1.0,31\n1.0,30\n", "do not ascend"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deck.k");
        let text = format!("{BASE}{STEEL}{MOVES}{contact}{table}*END\n");
        fs::write(&path, text).unwrap();
        let report = read(&path, &[]).err().expect("a report").to_string();
        assert!(report.contains(problem), "{report}");
    }
}

/// fsf is a factor on both coefficients of friction, vsf on the limit; blank and 0 mean 1.
#[test]
fn factors_of_friction_act() {
    for (factors, wanted) in [("0.5,2.0", (0.2, 0.1, 0.1)), ("0,", (0.4, 0.2, 0.05))] {
        let model = with(&format!(
            "*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0\n0.4,0.2,0.7,0.05\n,,,,,,{factors}\n"
        ));
        let found = model.job.contact.as_ref().unwrap();
        let dynamic = found.friction_dynamic.expect("a dynamic coefficient");
        let limit = found.friction_limit.expect("a limit");
        assert_eq!((found.friction, dynamic, limit), wanted, "{factors}");
    }
}

/// Only the contact whose card asks for it is of segments; the map of the deck shows it.
#[test]
fn mortar_contacts_take_the_law_of_segments() {
    let pair = "*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE_MORTAR_ID\n2,second\n1,2,3,3\n\n\n";
    let law = |model: &Model| {
        model.job.contact.as_ref().unwrap().each().map(|c| c.law).collect::<Vec<_>>()
    };
    let model = with(&format!("*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5\n\n\n{pair}"));
    assert_eq!(law(&model), ["lagrange", "mortar"]);
    assert!(crumple::input::check::describe(&model).contains("second: MORTAR -> law mortar"));
    let model = with(
        "*CONTACT_AUTOMATIC_SINGLE_SURFACE_MORTAR\n1,0,3\n\n\n\
         *CONTACT_AUTOMATIC_SURFACE_TO_SURFACE\n1,2,3,3\n\n\n",
    );
    assert_eq!(law(&model), ["mortar", "lagrange"]);
}

#[test]
fn contacts_of_a_single_surface_come_before_those_of_two() {
    let model = with(
        "*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE\n1,2,3,3\n0.4,0.4,,,,,0.25,0.5\n,,0.6,0.2\n\
         *CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5\n0.1,0.1\n,,,,0.5\n",
    );
    let contact = model.job.contact.as_ref().unwrap();
    assert!(contact.parts.is_empty(), "all");
    assert_eq!((contact.friction, contact.thickness_scale), (0.1, 0.5));
    let pair = contact.each().nth(1).unwrap();
    assert_eq!(
        (pair.friction, pair.thickness, pair.thickness_scale),
        (0.4, Some(0.4), 1.0),
        "no values of the first contact"
    );
    assert_eq!((pair.birth, pair.death), (0.25, Some(0.5)));
}

/// Two of three parts have the same friction; each pair of different kinds gets the mean.
#[test]
fn friction_of_parts_is_what_a_contact_asks_for() {
    let deck = BASE.replace(
        "*PART\nplate\n1,1,1\ncube\n2,2,1\n",
        "*PART_CONTACT\nplate\n1,1,1\n0.3,0.1,2.0,0.05,1.5,0.8\ncube\n2,2,1\n0.1,0.1\n",
    );
    let contact = "*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5\n-1.0\n\n";
    let model = model_of(&format!("{deck}{STEEL}{MOVES}{contact}"));
    let all: Vec<_> = model.job.contact.as_ref().unwrap().each().collect();
    let of = |one: u32, other: u32| {
        let ids: Vec<u32> = model.job.part.iter().map(|p| p.id).collect();
        let meets = |side: &[usize], part: u32| side.iter().any(|&place| ids[place] == part);
        let between = |c: &&crumple_proto::job::ContactInput| {
            let [a, b] = c.sides(&ids);
            meets(&a, one) && meets(&b, other) || meets(&a, other) && meets(&b, one)
        };
        let c = all.iter().rfind(between).unwrap();
        (c.friction, c.friction_dynamic, c.friction_decay, c.friction_limit.filter(|&l| l > 0.0))
    };
    assert_eq!(of(1, 1), (0.3, Some(0.1), 2.0, Some(0.05)));
    assert_eq!((of(2, 2).0, of(2, 2).1, of(2, 2).3), (0.1, None, None));
    assert_eq!(
        of(1, 2),
        (0.2, Some(0.1), 1.0, Some(0.05)),
        "the mean friction and the lower limit"
    );
    let plate = &model.job.part[0];
    assert_eq!((plate.contact_thickness, plate.contact_thickness_scale), (Some(1.5), 0.8));
    let said = crumple::input::check::describe(&model);
    assert!(
        said.contains(
            "fs -1: friction of the parts -> 3 interfaces; for two parts the mean of their values"
        ),
        "{said}"
    );
    let alike = deck.replace("0.1,0.1\n", "0.3,0.1,2.0,0.05\n");
    let model = model_of(&format!("{alike}{STEEL}{MOVES}{contact}"));
    let contact = model.job.contact.as_ref().unwrap();
    assert_eq!(
        (contact.friction, contact.friction_limit, contact.interface.len()),
        (0.3, Some(0.05), 0)
    );
}

/// An exported deck that is read again has the same contact: several cards, sets of parts, and
/// settings that no card has.
#[test]
fn exported_contacts_are_read_as_they_were() {
    let contacts = "*CONTACT_AUTOMATIC_SINGLE_SURFACE_ID\n1,all of it\n0,0,5\n\
         0.1,0.05,2.0,0.3,,,0.1,0.75\n,,,,0.5\n\
         *CONTACT_AUTOMATIC_SINGLE_SURFACE\n1,0,3\n0.2,0.2\n,,1.5\n\
         *CONTACT_AUTOMATIC_SURFACE_TO_SURFACE_ID\n2,pair\n1,2,3,3\n0.4,0.4,,,,,0.25,0.5\n\n";
    let job = read_with(&["contact.interface.pair.law=penalty", "contact.sweeps=7"], contacts);
    let numbers = |model: &Model| -> Vec<String> {
        let ids: Vec<u32> = model.job.part.iter().map(|p| p.id).collect();
        let all = model.job.contact.as_ref().unwrap().each();
        let plain = |c: crumple_proto::job::ContactInput| {
            let sides = c.sides(&ids);
            // A limit of 0 means no limit, and sides are distinguished by their parts.
            let limit = c.friction_limit.filter(|&l| l > 0.0);
            let death = c.death.filter(|&t| t < model.job.end_time);
            format!(
                "{sides:?} {:?}",
                crumple_proto::job::ContactInput {
                    friction_limit: limit,
                    death,
                    parts: vec![],
                    against: vec![],
                    ..c
                }
            )
        };
        all.map(plain).collect()
    };
    let text = crumple::input::deck::export::export(&job).unwrap().text;
    for card in [
        "*CONTACT_AUTOMATIC_SINGLE_SURFACE_ID",
        "*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE_ID",
        "*SET_PART_LIST",
    ] {
        assert!(text.lines().any(|l| l == card), "no {card} in\n{text}");
    }
    assert_eq!(text.matches("*CONTACT_").count(), 3, "{text}");
    let again = model_of(&text.replace("*END\n", ""));
    assert_eq!(numbers(&job), numbers(&again), "{text}");
    let twice = crumple::input::deck::export::export(&again).unwrap().text;
    assert_eq!(numbers(&job), numbers(&model_of(&twice.replace("*END\n", ""))), "exported twice");
}

/// A side without a given contact thickness has that of its shells; solids have none.
#[test]
fn a_thickness_of_one_side_leaves_that_of_the_other() {
    let deck = |solid: bool, card: &str| {
        let sections = if solid { "*SECTION_SOLID\n1,1\n" } else { "*SECTION_SHELL\n1,2\n0.4\n" };
        let element = if solid {
            "*ELEMENT_SOLID\n1,1,1,2,3,4,5,6,7,8\n"
        } else {
            "*ELEMENT_SHELL\n1,1,1,2,3,4\n5,1,5,6,7,8\n"
        };
        format!(
            "*KEYWORD\n*CONTROL_TERMINATION\n0.004\n*PART\none\n1,1,1\n*PART\nother\n2,2,1\n\
             {sections}*SECTION_SHELL\n2,2\n1.0\n*MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n\
             *NODE\n1,0,0,0\n2,10,0,0\n3,10,10,0\n4,0,10,0\n5,0,0,10\n6,10,0,10\n7,10,10,10\n\
             8,0,10,10\n11,0,0,20\n12,10,0,20\n13,10,10,20\n14,0,10,20\n{element}\
             *ELEMENT_SHELL\n9,2,11,12,13,14\n*CONTACT_AUTOMATIC_SURFACE_TO_SURFACE\n1,2,3,3\n0.1\n\
             1,1,{card}\n"
        )
    };
    let thickness =
        |solid: bool, card: &str| model_of(&deck(solid, card)).job.contact.unwrap().thickness;
    assert_eq!(thickness(true, "0,0.6"), Some(0.6), "solids");
    let full = model_of(&deck(true, "0,0.6").replace("SECTION_SOLID\n1,1", "SECTION_SOLID\n1,2"));
    assert!(full.warnings.iter().any(|w| w.message.contains("elform 2 has several points")));
    assert_eq!(thickness(false, "0,0.6"), Some(0.5), "shells of 0.4");
    assert_eq!(thickness(false, "0.6,0"), Some(0.8), "shells of 1.0 on the other side");
    assert_eq!(thickness(false, "0.6,0.2"), Some(0.4));
    assert_refused(&deck(false, "-0.6,0"), &["give a thickness above 0"]);
    let differ = deck(false, "0,0.6").replace(
        "*ELEMENT_SHELL\n9,2",
        "*PART\nthird\n3,3,1\n*SECTION_SHELL\n3,2\n0.7\n*SET_PART_LIST\n5\n1,3\n*ELEMENT_SHELL\n\
         7,3,5,6,7,8\n9,2",
    );
    let differ = differ.replace("1,2,3,3", "5,2,2,3").replace("5,1,5,6,7,8\n", "");
    assert_refused(&differ, &["the elements of the other side have no common one"]);
}

/// The tools of a forming contact have no thickness, or that of sbst: a sheet that falls onto a
/// fixed tool comes as near as half of its own thickness, and half of sbst.
#[test]
fn tools_of_forming_have_no_thickness() {
    let deck = |card: &str| {
        format!(
            "*KEYWORD\n*CONTROL_TERMINATION\n0.004\n*PART\nsheet\n1,1,1\n*PART\ntool\n2,2,2\n\
             *SECTION_SHELL\n1,2,1.0,3\n1.0\n*SECTION_SHELL\n2,2,1.0,3\n2.0\n\
             *MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n*MAT_RIGID\n2,7.85e-6,207.0,0.3\n1,7,7\n\
             *NODE\n1,-5,-5,0\n2,15,-5,0\n3,15,15,0\n4,-5,15,0\n\
             11,0,0,2\n12,10,0,2\n13,10,10,2\n14,0,10,2\n*ELEMENT_SHELL\n\
             1,2,1,2,3,4\n2,1,11,12,13,14\n*SET_NODE_LIST\n3\n11,12,13,14\n\
             *INITIAL_VELOCITY\n3\n0,0,-1000\n{card}"
        )
    };
    let card = |thickness: &str| {
        format!("*CONTACT_FORMING_ONE_WAY_SURFACE_TO_SURFACE\n1,2,3,3\n0.1\n1,1,0,{thickness}\n")
    };
    for (thickness, nearest) in [("0", 0.501), ("0.6", 0.8)] {
        let model = model_of(&deck(&card(thickness)));
        let mut least = f64::INFINITY;
        run_alone(&model, |engine| {
            let z = engine.nodes.id.iter().zip(&engine.nodes.x).filter(|(id, _)| id.0 > 10);
            least = z.map(|(_, x)| x[2]).fold(least, f64::min);
        });
        // The law closes the gap exactly at the end of a step, and the sheet rebounds.
        assert!((least - nearest).abs() < 1e-9, "{thickness}: {least}");
    }
    for (lines, words) in [
        (card("-0.6"), "`sbst` = -0.6"),
        (card("0.6") + &card("0.7"), "one contact thickness for each tool"),
        (card("0.6").replace("1,1,0,", "1,1,2,"), "`sast` = 2"),
        (card("0.6").replace("0.6\n", "0.6,2\n"), "`sfsat` = 2"),
        (card("0").replace("1,2,3,3", "1,9,3,3"), "known: 1, 2"),
    ] {
        assert_refused(&deck(&lines), &[words]);
    }
}
