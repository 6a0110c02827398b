//! Fates of the fields of a deck: nothing that is given has no effect without a word.

use super::base::{BASE, MOVES, STEEL, model_of, with};
use crumple::input::check::describe;
use crumple::input::job::{Model, read};
use crumple_proto::job::Setting;
use std::fs;

/// Reads a deck; returns the model, or the report of its errors.
pub fn reading(text: &str, sets: &[&str]) -> Result<Model, String> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("deck.k");
    fs::write(&path, format!("{text}*END\n")).unwrap();
    let sets: Vec<String> = sets.iter().map(|s| s.to_string()).collect();
    read(&path, &sets).map_err(|report| report.to_string())
}

fn refused(text: &str) -> String {
    reading(text, &[]).err().unwrap_or_else(|| panic!("it passes: {text}"))
}

fn based(lines: &str) -> String {
    format!("{BASE}{STEEL}{MOVES}{lines}")
}

/// Returns everything that is said of a model: its description and its warnings with their help.
pub fn said(model: &Model) -> String {
    let warnings = model.warnings.iter().map(|w| format!("{}: {}\n", w.message, w.help));
    describe(model) + &warnings.collect::<String>()
}

/// Each field that was silent once is named: in the mapping, in a warning, or in an error.
#[test]
fn no_given_field_is_without_a_word() {
    let control = "*CONTROL_SHELL\n25.0,0,-2,0,2,0,3,1\n2.0,1,1,2,1\n0,0,0,0,0,0,0.0,1\n\
                   1,1,0,0,1\n";
    let steps = "*CONTROL_TIMESTEP\n1e-5,0.9,1,1e-6,0,0,1,1\n";
    let contact = "*CONTACT_AUTOMATIC_SINGLE_SURFACE\n0,0,5,0,0,0,1,1\n0.1,0.1,0.0,0.0,20.0,1\n\
                   1.5,1.0,0,0,1,1,1,1\n2,0.2,0,1.05,3,2,0,1\n0,0,0,1,0,0,0,1\n2,1,0,0,0,0,1,1\n";
    let lines = format!(
        "{control}{steps}{contact}*CONTROL_BULK_VISCOSITY\n1.5,0.06,-2\n*DAMPING_GLOBAL\n0,1.0\n\
         *INITIAL_VELOCITY_GENERATION\n1,2,0,1.0,0,0,1\n0,0,0,0,0,0,0,1\n\
         *DATABASE_GLSTAT\n0.1,3,0,1\n"
    );
    let all = said(&with(&lines));
    for field in [
        "wrpang 25",
        "irnxx -2",
        "miter 3",
        "`proj` = 1",
        "`rotascl` = 2",
        "`intgrd` = 1",
        "lamsht 1",
        "`thshel` = 1",
        "`icrq` = 1",
        "`nfail1` = 1",
        "`nfail4` = 1",
        "`delfr` = 1",
        "dtinit",
        "isdo 1",
        "`tslimt`",
        "erode 1",
        "ms1st 1",
        "vdc 20",
        "sapr 1",
        "soft 2",
        "`flangl` = 1",
        "`type` = -2",
        "`ivatn` = 1",
        "`irigid` = 1",
        "binary 3",
    ] {
        assert!(all.contains(field), "missing: {field}\n{all}");
    }
    let parts = BASE
        .replace("plate\n1,1,1\n", "plate\n1,1,1,0,4,1,1,7\n")
        .replace("1,2,1.0,3\n1.0\n", "1,2,1.0,3,2\n1.0,,,,,,3\n");
    let law = "*MAT_024\n1,7.85e-6,207.0,0.3,0.2\n40.0,5.0,0,0,1.0\n";
    let all =
        said(&model_of(&format!("{parts}{law}{MOVES}*HOURGLASS\n4,1,0.1,2,1.5,0.06,0.2,0.3\n")));
    for field in [
        "grav 1",
        "`adpopt` = 1",
        "`tmid` = 7",
        "propt 2",
        "`idof` = 3",
        "ibq 2",
        "`qb` = 0.2",
        "`qw` = 0.3",
    ] {
        assert!(all.contains(field), "missing: {field}\n{all}");
    }
    let end = BASE.replace("10.0\n*PART", "10.0,0,0,1.0,2.0,1\n*PART");
    let all = said(&model_of(&format!("{end}{STEEL}{MOVES}")));
    for field in ["`endeng` = 1", "`endmas` = 2", "`nosol` = 1"] {
        assert!(all.contains(field), "missing: {field}\n{all}");
    }
    for (lines, field) in [
        ("*CONTROL_SHELL\n0\n0\n1,0,0,0,0,0,0.3\n", "`psstupd` = 1"),
        ("*CONTROL_SHELL\n0\n0\n1,0,0,0,0,0,0.3\n", "`stretch` = 0.3"),
        ("*RIGIDWALL_PLANAR\n0\n0,0,-5,0,0,-4,0.0,3.0\n", "`wvel` = 3"),
        ("*CONTROL_TIMESTEP\n0\n0.1\n", "`dt2msf` = 0.1"),
        ("*DAMPING_GLOBAL\n0,1.0,1.0\n", "damping that depends on the direction"),
    ] {
        let report = refused(&based(lines));
        assert!(report.contains(field), "missing: {field}\n{report}");
    }
    let report =
        refused(&format!("{}{STEEL}{MOVES}", BASE.replace("1,2,1.0,3\n", "1,2,1.0,3,0,0,0,2\n")));
    assert!(report.contains("`setyp` = 2 is not supported"), "{report}");
}

/// A field for which the conversion has no use in this deck is reported as well: the points of
/// eps and es next to a curve.
#[test]
fn fields_that_others_make_void_are_reported() {
    let law = "*MAT_024\n1,7.85e-6,207.0,0.3\n0,0,9\n0.0,0.1\n0.3,0.4\n*DEFINE_CURVE\n9\n0.0,0.3\n\
               0.5,0.4\n";
    let model = model_of(&format!("{BASE}{law}{MOVES}"));
    let warnings: Vec<&str> = model.warnings.iter().map(|w| w.message.as_str()).collect();
    assert!(
        warnings.iter().any(|w| w.contains("`es` = 0.3 is not used, and 1 more")),
        "{warnings:?}"
    );
    assert!(!said(&with("")).contains("is not used"), "{}", said(&with("")));
    let help = model.warnings.iter().find(|w| w.message.contains("`es`")).map(|w| w.help.as_str());
    assert!(help.is_some_and(|help| help.contains("lcss has their place")), "{help:?}");
}

/// The same field in many cards is one finding with their number.
#[test]
fn findings_of_one_kind_are_one() {
    let curve = |id: i32| format!("*DEFINE_CURVE\n{id},0,1,1,0,0,6\n0.0,0.0\n20.0,1.0\n");
    let curves: String = (1..=7).map(curve).collect();
    let text = describe(&with(&curves));
    assert!(text.contains("*DEFINE_CURVE: dattyp 6, and 6 more -> not used"), "{text}");
}

/// The mass per area of a section is in the mass of the part (13.7 times that of the shell alone
/// in the deck in which it was found).
#[test]
fn mass_per_area_counts() {
    let marea = BASE.replace("1,2,1.0,3\n1.0\n", "1,2,1.0,3\n1.0,,,,,1.0e-4\n");
    let (plain, heavy) = (with(""), model_of(&format!("{marea}{STEEL}{MOVES}")));
    let added = heavy.structure_mass() - plain.structure_mass();
    assert!((added - 200.0 * 1.0e-4).abs() < 1e-12, "{added}: 200 mm2 of 1e-4 kg/mm2");
    assert!(describe(&heavy).contains("marea 0.0001"), "{}", describe(&heavy));
}

/// A curve with sidr 1 is for dynamic relaxation: what uses it does not act in the run.
#[test]
fn curves_of_dynamic_relaxation_do_not_act() {
    let loads = |sidr: i32| {
        let model = with(&format!(
            "*LOAD_NODE_POINT\n5,1,4,0.5\n*LOAD_SEGMENT\n4,2.0,0,11,12,15,14\n*DEFINE_CURVE\n\
             4,{sidr}\n0.0,1.0\n20.0,1.0\n"
        ));
        (model.job.load.len(), model.job.pressure.len(), said(&model))
    };
    let (run, relaxed) = (loads(0), loads(1));
    assert_eq!((run.0, run.1), (1, 1));
    assert_eq!((relaxed.0, relaxed.1), (0, 0));
    assert!(relaxed.2.contains("*DEFINE_CURVE 4 is for dynamic relaxation only"), "{}", relaxed.2);
}

/// Equal factors scale the damping; without factors it has its value.
#[test]
fn damping_has_its_factors() {
    let damping = |card: &str| with(&format!("*DAMPING_GLOBAL\n{card}\n")).job.time.damping;
    assert_eq!(damping("0,3.0"), 3.0);
    assert_eq!(damping("0,3.0,0.5,0.5,0.5,0.5,0.5,0.5"), 1.5);
    assert_eq!(damping("0,3.0,1,1,1"), 3.0);
}

/// The defaults of the format: viscous hourglass control with 0.1 for shells and solids, no
/// drilling stiffness.
#[test]
fn hourglass_control_has_the_defaults_of_the_format() {
    let of = |part: usize, lines: &str| {
        let model = with(lines);
        let parameters = &model.job.part[part].parameters;
        let Setting::Word(form) = &parameters["hourglass"] else { panic!("{parameters:?}") };
        (form.clone(), parameters.get("hourglass_coefficient").and_then(Setting::number))
    };
    for lines in ["", "*CONTROL_HOURGLASS\n0,0.0\n", "*CONTROL_HOURGLASS\n1,0.0\n"] {
        for part in [0, 1] {
            assert_eq!(of(part, lines), ("viscous".into(), Some(0.1)), "{lines}");
        }
    }
    assert_eq!(of(1, "*CONTROL_HOURGLASS\n5,0.05\n"), ("stiffness".into(), Some(0.05)));
    assert_eq!(of(1, "*CONTROL_HOURGLASS\n6,0.1\n"), ("assumed_strain".into(), None));
    assert_eq!(of(0, "*CONTROL_HOURGLASS\n6,0.1\n"), ("viscous".into(), Some(0.1)));
    let report = refused(&based("*CONTROL_HOURGLASS\n8,0.1\n"));
    assert!(report.contains("ihq 8 is not supported"), "{report}");
    // Without the form its coefficient has no meaning.
    let text = based("*CONTROL_HOURGLASS\n16,1.0\n");
    let left = reading(&text, &["mesh.allow_unsupported=true"]).unwrap_or_else(|r| panic!("{r}"));
    let coefficient = &left.job.part[1].parameters["hourglass_coefficient"];
    assert_eq!(coefficient.number(), Some(0.1));
    let drilling = |lines: &str| with(lines).job.part[0].parameters.get("drilling").cloned();
    assert_eq!(drilling("").as_ref().and_then(Setting::number), Some(0.0));
    assert_eq!(drilling("*CONTROL_SHELL\n0\n0\n0\n0,0,0,0,0,1\n"), None, "that of the job");
}

/// Constraints of all nodes of a rigid part hold its body.
#[test]
fn constraints_of_all_nodes_hold_a_body() {
    let fixed = |lines: &str| {
        let model = with(&format!("*DEFORMABLE_TO_RIGID\n2\n{lines}"));
        let held = model.job.rigid[0].fixed.clone();
        (held, model.job.fix.len(), said(&model))
    };
    let set = "*SET_NODE_LIST\n5\n1,2,3,4,5,6,7,8\n";
    let (held, fixes, text) = fixed(&format!("{set}*BOUNDARY_SPC_SET\n5,0,1,1,1\n"));
    assert_eq!((held.len(), fixes), (6, 0), "{held:?}: displacements hold rotations too");
    assert!(text.contains("rigid part 2: constraints of all its nodes"), "{text}");
    let (held, ..) = fixed(&format!("{set}*BOUNDARY_SPC_SET\n5,0,0,0,1\n"));
    assert_eq!(held, ["rx", "ry", "z"]);
    let more = "*SET_NODE_LIST\n5\n1,2,3,4,5,6,7,8\n11,12\n*BOUNDARY_SPC_SET\n5,0,1\n";
    let model = with(&format!("*DEFORMABLE_TO_RIGID\n2\n{more}"));
    let set = &model.mesh.node_sets[&model.job.fix[0].nodes];
    assert_eq!(set.iter().map(|n| n.0).collect::<Vec<_>>(), [11, 12], "nodes outside of the body");
}

/// Walls for display need no card for it.
#[test]
fn walls_for_display_are_walls() {
    for wall in [
        "*RIGIDWALL_PLANAR_DISPLAY\n0\n0,0,-5,0,0,-4\n",
        "*RIGIDWALL_PLANAR_DISPLAY\n0\n0,0,-5,0,0,-4\n9,1.0,1.0,0.3\n",
        "*RIGIDWALL_GEOMETRIC_FLAT_DISPLAY\n0\n0,0,-5,0,0,-4\n1,0,-5,20,30\n",
    ] {
        assert_eq!(with(wall).job.wall.len(), 1, "{wall}");
    }
}

/// Names without a heading have the ids of the deck.
#[test]
fn names_have_the_ids_of_the_deck() {
    let model = with(
        "*CONTACT_AUTOMATIC_SINGLE_SURFACE_ID\n70\n0,0,5\n\n\n\
         *RIGIDWALL_PLANAR_ID\n80\n0\n0,0,-5,0,0,-4\n\
         *CONTACT_FORCE_TRANSDUCER_PENALTY_ID\n90\n1,0,3\n\n\n",
    );
    assert_eq!(model.job.contact.as_ref().unwrap().name, "contact 70");
    assert_eq!(model.job.wall[0].name, "wall-80");
    assert_eq!(model.job.output.transducer[0].name, "transducer 90");
}

/// A keyword is left out under all its names and with its options.
#[test]
fn left_out_keywords_have_options() {
    let lines = "*AIRBAG_SOMETHING_TITLE\nname\n1\n*MAT_123_TITLE\nname\n9\n";
    let sets = ["mesh.leave_out=[\"AIRBAG_SOMETHING\", \"MAT_123\"]"];
    assert!(reading(&based(lines), &sets).is_ok());
    let alias = "*MAT_PLASTIC_KINEMATIC_TITLE\nname\n9\n";
    assert!(reading(&based(alias), &["mesh.leave_out=[\"MAT_003\"]"]).is_ok());
}

/// A part whose material or section is not supported names the keyword; a run without unsupported
/// content says what is gone.
#[test]
fn what_is_left_out_has_a_name() {
    let law = "*MAT_ELASTIC_FLUID_TITLE\ncore\n         1   7.85e-6     207.0\n";
    let report = reading(&format!("{BASE}{law}{MOVES}"), &["mesh.allow_unsupported=true"]);
    let report = report.err().expect("a report");
    assert!(
        report.contains("it needs mid 1, and *MAT_ELASTIC_FLUID_TITLE is not supported"),
        "{report}"
    );
    assert!(!report.contains("there is no *MAT_"), "{report}");
    let bag = based(
        "*AIRBAG_HYBRID\n1\n*CONTROL_TIMESTEP\n0,0,0,0,0,7\n\
                     *DEFINE_CURVE\n7\n0.0,0.0\n1.0,2e-3\n",
    );
    let model = reading(&bag, &["mesh.allow_unsupported=true"]).unwrap_or_else(|r| panic!("{r}"));
    assert!(said(&model).contains("bags have no pressure"), "{}", said(&model));
    assert!(said(&model).contains("acts as if `lctm` were blank"), "{}", said(&model));
}

/// The smallest value of a curve within the run limits the time step of a job.
#[test]
fn a_curve_limits_the_step() {
    let cards = "*CONTROL_TIMESTEP\n0,0,0,0,0,7\n*DEFINE_CURVE\n7\n0.0,1e-3\n1.0,1e-3\n";
    let model = reading(&based(cards), &[]).unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(model.settings.dt_max, 1e-3);
    // A factor on the ordinates.
    let cards = "*CONTROL_TIMESTEP\n0,0,0,0,0,7\n*DEFINE_CURVE\n7,0,1.0,0.25\n\
                 0.0,8e-3\n1.0,8e-3\n";
    let model = reading(&based(cards), &[]).unwrap_or_else(|report| panic!("{report}"));
    assert_eq!(model.settings.dt_max, 2e-3);
    for (points, least, changes) in [
        ("0.0,1e-3\n5.0,4e-3\n20.0,4e-3", 1e-3, true),
        ("0.0,3e-3\n5.0,2e-3\n10.0,4e-3\n11.0,1e-9", 2e-3, true),
        ("0.0,3e-3\n10.0,3e-3\n11.0,1e-3", 3e-3, false),
    ] {
        let cards = format!("*CONTROL_TIMESTEP\n0,0,0,0,0,7\n*DEFINE_CURVE\n7\n{points}\n");
        let model = reading(&based(&cards), &[]).unwrap_or_else(|report| panic!("{report}"));
        assert_eq!(model.settings.dt_max, least, "{points}");
        let words = format!("at most {least} in the whole run");
        assert_eq!(said(&model).contains(&words), changes, "{points}: {}", said(&model));
    }
    let zeros = "*CONTROL_TIMESTEP\n0,0,0,0,0,7\n*DEFINE_CURVE\n7\n0.0,0.0\n1.0,0.0\n";
    let report = refused(&based(zeros));
    assert!(report.contains("`lctm` = 7 is not supported"), "{report}");
    let report = reading(&based("*CONTROL_TIMESTEP\n0,0,0,0,0,7\n"), &[]).err().unwrap();
    assert!(report.contains("there is no *DEFINE_CURVE with the id 7"), "{report}");
}

/// Implicit decks are named as such; without imflag their keywords have no effect.
#[test]
fn implicit_decks_hear_that_the_code_is_explicit() {
    let cards = |flag: i32| {
        based(&format!("*CONTROL_IMPLICIT_GENERAL\n{flag},0.1\n*CONTROL_IMPLICIT_SOLUTION\n2\n"))
    };
    let report = refused(&cards(1));
    assert!(report.contains("this is an explicit code"), "{report}");
    let model = reading(&cards(0), &[]).unwrap_or_else(|report| panic!("{report}"));
    assert!(said(&model).contains("the deck is explicit"), "{}", said(&model));
}

/// A relaxation before the run is refused; without one its card and those on the division of the
/// model change nothing.
#[test]
fn relaxation_and_division_of_a_model() {
    let cards = |flag: i32| {
        based(&format!("*CONTROL_DAMPING\n0,,,,,,,{flag}\n*CONTROL_MPP_DECOMPOSITION_SHOW\n1\n"))
    };
    let report = refused(&cards(1));
    assert!(report.contains("`idrflg` = 1 is not supported"), "{report}");
    for flag in [0, -999] {
        let model = reading(&cards(flag), &[]).unwrap_or_else(|report| panic!("{report}"));
        assert!(said(&model).contains("*CONTROL_MPP_DECOMPOSITION_SHOW is not read"));
    }
}

/// The option MORTAR of contacts without such a law, and of ties, is named.
#[test]
fn mortar_contacts_without_a_law_are_the_plain_ones() {
    let model = with(
        "*CONTACT_AUTOMATIC_GENERAL_MORTAR\n0,0,5\n\n\n\
         *CONTACT_TIED_SURFACE_TO_SURFACE_MORTAR\n1,2,3,3\n\n,,10.0,10.0\n",
    );
    let text = describe(&model);
    assert!(text.contains("MORTAR -> the contact without MORTAR"), "{text}");
    assert!(text.contains("MORTAR -> the tie without MORTAR"), "{text}");
}

#[test]
fn decks_in_inches_and_pounds_have_units() {
    let model = model_of(&format!("{BASE}*MAT_ELASTIC\n1,7.35e-4,30e6,0.3\n{MOVES}"));
    assert_eq!(model.job.units, "in, s, slinch (guessed)");
}

/// The end of a run can be changed for a check, as for a run.
#[test]
fn a_check_has_an_end_time() {
    use crumple_tests::program::{crumple_with, run};
    let deck = "tests/decks/good/fixed.k";
    let text = run(crumple_with(&["check", deck, "--end-time", "0.125"])).with_code(0);
    assert!(text.said().contains("0.125"), "{}", text.said());
}

/// Spot welds of two layers of solids: the nodes between the layers are not tied, and no solid is
/// flattened.
#[test]
fn welds_of_two_layers_keep_their_shape() {
    let mut lines = String::from("*PART\nweld\n3,2,1\n*NODE\n");
    for (layer, z) in [12.0, 12.5, 13.0].into_iter().enumerate() {
        for (corner, (x, y)) in [(4, 4), (6, 4), (6, 6), (4, 6)].into_iter().enumerate() {
            lines += &format!("{},{x},{y},{z}\n", 100 + 10 * layer + corner);
        }
    }
    lines += "200,0,0,13\n201,10,0,13\n202,10,10,13\n203,0,10,13\n*ELEMENT_SHELL\n\
              50,1,200,201,202,203\n*ELEMENT_SOLID\n51,3,100,101,102,103,110,111,112,113\n\
              52,3,110,111,112,113,120,121,122,123\n*CONTACT_SPOTWELD\n3,1,3,3\n\n\n";
    let model = with(&lines);
    let tied: Vec<u64> = model.settings.ties.iter().map(|t| t.node.0).collect();
    assert_eq!(tied, [100, 101, 102, 103, 120, 121, 122, 123]);
    let z = |id: u64| model.mesh.nodes.iter().find(|n| n.id.0 == id).unwrap().x[2];
    assert_eq!([100, 110, 120].map(z), [12.0, 12.5, 13.0]);
}

/// The abscissas of lcdt are times of fields with ioopt 3. Intervals that change, and units that
/// are not known, are named.
#[test]
fn times_of_fields_and_units_are_used_or_named() {
    let curve = "*DEFINE_CURVE\n7\n0,0.1\n2.5,0.5\n12,1\n";
    let model = with(&format!(
        "{curve}*DATABASE_BINARY_D3PLOT\n0.5,7\n1\n*CONTROL_UNITS\nmile,ms,kg\n\
         *DATABASE_EXTENT_BINARY\n3,0,0,11\n"
    ));
    let all = said(&model);
    for words in ["lcdt 7 is not used", "length mile is not known", "neiph 3"] {
        assert!(all.contains(words), "{words}: {all}");
    }
    let output = &model.job.output;
    assert_eq!((output.field_interval, &output.field_times[..]), (0.5, &[][..]));
    assert!(output.strains && model.job.units == "mm, ms, kg (guessed)");
    for (card, interval) in [(",7", -1.0), ("0.5,7", 0.5)] {
        let model = with(&format!("{curve}*DATABASE_BINARY_D3PLOT\n{card}\n3\n"));
        let output = &model.job.output;
        assert_eq!((output.field_interval, &output.field_times[..]), (interval, &[0.0, 2.5][..]));
    }
    let model = with("*CONTROL_UNITS\nmm,ms,kg\n");
    assert_eq!(model.job.units, "mm, ms, kg");
}

/// Conditions that end a run are named.
#[test]
fn conditions_of_the_end_are_ignored_with_a_warning() {
    for name in ["NODE", "BODY", "CONTACT", "CURVE"] {
        let said = said(&with(&format!("*TERMINATION_{name}\n1,1,5.0\n")));
        assert!(said.contains(&format!("*TERMINATION_{name} is not read")), "{said}");
        assert!(said.contains("it goes on to its end time"), "{said}");
    }
}

/// Stresses without increasing strains are named with the field of the card.
#[test]
fn points_of_hardening_need_increasing_strains() {
    let card = |eps: &str, es: &str| {
        format!("{BASE}*MAT_024\n1,7.85e-6,207.0,0.3,0.3\n0\n{eps}\n{es}\n{MOVES}")
    };
    let report = refused(&card("0,0,0", "0.3,0.4,0.5"));
    for words in
        ["eps2 is 0, which is not above eps1 = 0, but es2 is 0.4", "all eps are 0", "deck.k:"]
    {
        assert!(report.contains(words), "{words}: {report}");
    }
    assert!(refused(&card("0,0.1,0.1", "0.3,0.4,0.5")).contains("eps3 is 0.1"));
    model_of(&card("0,0.1,0.2", "0.3,0.4,0.5"));
}

/// A strain of failure in the place of vp is no flag of rates.
#[test]
fn vp_of_a_power_law_is_a_flag() {
    let of = |card: &str| {
        model_of(&format!(
            "{BASE}*MAT_POWER_LAW_PLASTICITY\n1,7.85e-6,200.0,0.3,0.5,0.2\n{card}\n{MOVES}"
        ))
    };
    let says = |model: &Model| model.warnings.iter().any(|w| w.message.contains("neither 0 nor 1"));
    let given = of("0.3,0.4876");
    assert!(says(&given), "{:?}", given.warnings);
    let right = of("0.3,0,0.4876");
    assert!(!says(&right));
    assert_eq!(right.job.material[0].parameters["failure_strain"].to_string(), "0.4876");
}

/// Elements of two dimensions are no shells of another formulation.
#[test]
fn plane_elements_are_refused_as_such() {
    for (elform, words) in [(15, "mesh the body with solids"), (22, "use 2 or 16")] {
        let text =
            based("").replace("*SECTION_SHELL\n1,2,", &format!("*SECTION_SHELL\n1,{elform},"));
        let report = refused(&text);
        assert!(report.contains(words), "{report}");
    }
}
