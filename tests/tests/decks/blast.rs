//! Explosions of decks: the momentum of a plate in free flight, units, what is refused. Units mm,
//! ms, kg, so kN and GPa.

use crate::base::{assert_refused, model_of, report_of};
use crumple::input::job::Model;
use crumple_proto::job::Burst;
use crumple_proto::problem::Problem;
use crumple_tests::{run_alone, run_side_by_side};

/// A free square shell of 10 by 10 by 1, 1 m from the charge, with its normal towards it.
fn plate(loads: &str) -> String {
    format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n4.0\n*PART\nplate\n1,1,1\n*SECTION_SHELL\n1,2,1.0,3\n1.0\n\
         *MAT_ELASTIC\n1,7.85e-6,207.0,0.3\n*NODE\n1,-5,-5,0\n2,5,-5,0\n3,5,5,0\n4,-5,5,0\n\
         *ELEMENT_SHELL\n1,1,1,2,3,4\n*SET_SEGMENT\n7\n1,2,3,4\n{loads}"
    )
}

const AT: &str = "0,0,1000";
const ON_SET: &str = "*LOAD_BLAST_SEGMENT_SET\n3,7\n";

fn velocity(model: &Model) -> f64 {
    let end = run_alone(model, |_| {});
    end.nodes.v.iter().map(|v| v[2]).sum::<f64>() / 4.0
}

/// Swisdak 1994: the reflected impulse of 1 kg on the ground at 1 m is exp(6.7853) kPa ms.
#[test]
fn a_plate_gets_the_impulse_of_the_wave() {
    let deck = format!("*LOAD_BLAST_ENHANCED\n3,1.0,{AT},0.5,6,1\n,,,,,,1\n{ON_SET}");
    let impulse = 6.7853_f64.exp() * 1e-6 * 100.0;
    let wanted = -impulse / (7.85e-6 * 100.0);
    let model = model_of(&plate(&deck));
    let found = velocity(&model);
    assert!((found / wanted - 1.0).abs() < 0.01, "{found} {wanted}");
    // The other side of the plate, whose normal points away: the wave is not reflected.
    let away = plate(&deck).replace("1,2,3,4\n*LOAD", "4,3,2,1\n*LOAD");
    let behind = velocity(&model_of(&away));
    assert!(behind > 0.0 && behind < -0.5 * wanted, "{behind}: pressed from behind");
    // With the pressure below that of the air.
    let sucked = velocity(&model_of(&plate(&deck.replace(",,,,,,1\n", ""))));
    assert!(sucked > found && sucked < 0.0, "{sucked} after {found}");
}

/// Both cards give the same explosion; units are those of the cards.
#[test]
fn cards_become_an_explosion() {
    let enhanced = format!(
        "*LOAD_BLAST_ENHANCED\n3,2.0,{AT},0.5,8,2\n{ON_SET}*LOAD_BLAST_SEGMENT\n3,1,2,3,4\n"
    );
    let old = format!(
        "*LOAD_BLAST\n2.0,{AT},0.5,5,1\n2.204623,3.2808399e-3,1.0,145037.74\n\
         *LOAD_SEGMENT_SET\n7,-2,0.5\n"
    );
    let of = |deck: &str| {
        let model = model_of(&plate(deck));
        let loads: Vec<_> = model.job.pressure.iter().map(|p| p.pressure).collect();
        let input = model.job.pressure[0].blast.clone().expect("an explosion");
        let resolved = model.settings.loads.pressures[0].blast.expect("an explosion");
        assert_eq!((input.position, input.time), ([0.0, 0.0, 1000.0], 0.5));
        (loads, input.burst, resolved)
    };
    let (loads, burst, resolved) = of(&enhanced);
    assert_eq!((loads, burst), (vec![1.0, 1.0], Burst::Air));
    // A factor of zero is its default.
    let zero = model_of(&plate(&enhanced.replace(ON_SET, "*LOAD_BLAST_SEGMENT_SET\n3,7,0,0,0\n")));
    assert_eq!(zero.job.pressure[0].pressure, 1.0);
    // Grams, and MPa.
    assert!((resolved.mass - 2e-3).abs() < 1e-15 && !resolved.on_ground && resolved.suction);
    assert!((resolved.si[2] / 1e6 - 1.0).abs() < 1e-12, "{:?}", resolved.si);
    let (loads, burst, resolved) = of(&old);
    assert_eq!((loads, burst), (vec![0.5], Burst::Ground));
    assert!((resolved.mass - 2.0).abs() < 1e-6, "{resolved:?}");
    assert!((resolved.si[2] / 1e9 - 1.0).abs() < 1e-5, "{:?}", resolved.si);
}

#[test]
fn what_is_not_supported_is_refused() {
    let enhanced = |card: &str, second: &str| {
        plate(&format!("*LOAD_BLAST_ENHANCED\n{card}\n{second}{ON_SET}"))
    };
    for (deck, words) in [
        (enhanced("3,2.0,0,0,0,0,6,3", ""), "`blast` = 3"),
        (enhanced("3,2.0,0,0,0,0,1,2", ""), "`unit` = 1"),
        (enhanced("3,2.0,0,0,0,0,5,2", ""), "`cfm` is 0"),
        (enhanced("3,2.0,0,0,0,0,5,2", "1,1,1,1\n"), "cfp is not the unit of pressure"),
        (enhanced("4,2.0,0,0,0,0,6,2", ""), "no *LOAD_BLAST_ENHANCED with the id 3"),
        (enhanced("-2,2.0,0,0,0,0,6,2", ""), "bid is -2"),
        (enhanced("3,2.0,0,0,0,0,6,2", ",,,,,,2\n"), "`negphs` = 2"),
        (enhanced("3,0.0,0,0,0,0,6,2", ""), "the mass of a charge is 0"),
        (enhanced("3,2.0,0,0,0,0,6,2", ",,,,,1.0\n"), "`death` = 1"),
        (plate("*LOAD_SEGMENT_SET\n7,-2\n"), "*DEFINE_CURVE"),
    ] {
        assert_refused(&deck, &[words]);
    }
    // The card of the ground or of a moving charge is no further explosion.
    for (blast, more) in [(4, "1,1\n"), (3, "3.0,70,1.0,1\n")] {
        let card = format!("3,2.0,0,0,0,0,6,{blast}");
        let report = report_of(&enhanced(&card, &format!("0,0,0,0,0,0,0\n{more}")));
        assert!(report.contains(&format!("`blast` = {blast}")), "{report}");
        assert!(report.contains("1 error") && !report.contains("two explosions"), "{report}");
    }
    // A refused explosion causes no further errors, and one without segments a warning.
    let report = report_of(&enhanced("3,2.0,0,0,0,0,6,3", ""));
    assert!(report.contains("1 error"), "{report}");
    let model = model_of(&plate(&format!(
        "*LOAD_BLAST_ENHANCED\n3,1.0,{AT},0.5,6,1\n{ON_SET}\
         *LOAD_BLAST_ENHANCED\n4,1.0,{AT},0.5,6,1\n"
    )));
    let unused = |w: &&Problem| w.message.contains("explosion 4 loads no segment");
    assert_eq!(model.warnings.iter().filter(unused).count(), 1, "{:?}", model.warnings);
}

/// Explosions on a strip of shells that bends give the same bits on any number of workers.
#[test]
fn bits_do_not_depend_on_the_workers() {
    let nodes: String = (0..=12)
        .flat_map(|i| [0, 1].map(|k| format!("{},{},{},0\n", 11 + 2 * i + k, 5 * i, 5 * k)))
        .collect();
    let shells: String = (0..12)
        .map(|i| {
            let n = 11 + 2 * i;
            format!("{},1,{n},{},{},{}\n", i + 1, n + 2, n + 3, n + 1)
        })
        .collect();
    let segments: String = (0..12)
        .map(|i| {
            let n = 11 + 2 * i;
            format!("{n},{},{},{}\n", n + 2, n + 3, n + 1)
        })
        .collect();
    let deck = format!(
        "*KEYWORD\n*CONTROL_TERMINATION\n0.5\n*PART\nstrip\n1,1,1\n*SECTION_SHELL\n\
         1,2,1.0,3\n1.0\n*MAT_PLASTIC_KINEMATIC\n1,7.85e-6,207.0,0.3,0.3\n*NODE\n{nodes}\
         *ELEMENT_SHELL\n{shells}*SET_SEGMENT\n7\n{segments}\
         *BOUNDARY_SPC_NODE\n11,0,1,1,1,1,1,1\n12,0,1,1,1,1,1,1\n\
         *LOAD_BLAST_ENHANCED\n3,0.01,30,2,200,0.0,6,2\n{ON_SET}"
    );
    let model = model_of(&deck);
    let digest = |workers| run_side_by_side(&model, workers, 300, 0).digest();
    let one = digest(1);
    assert!([2, 3, 4].into_iter().all(|workers| digest(workers) == one));
    let loaded = run_alone(&model, |_| {});
    let tip = loaded.nodes.x.iter().map(|x| x[2]).fold(0.0, f64::min);
    assert!(tip < -1.0, "the wave bends the strip: {tip}");
}

/// A job needs units for an explosion.
#[test]
fn a_job_without_units_is_refused() {
    let job = |units: &str, mass: f64| {
        let text = format!(
            "{units}end_time = 1.0\n[mesh]\nnodes = [[1, 0.0, 0.0, 0.0], [2, 9.0, 0.0, 0.0], \
             [3, 9.0, 9.0, 0.0], [4, 0.0, 9.0, 0.0]]\nshells = [[1, 1, 1, 2, 3, 4]]\n\
             [[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
             youngs_modulus = 207.0\npoisson = 0.3\n[[part]]\nid = 1\nmaterial = \"steel\"\n\
             thickness = 1.0\n[[pressure]]\nparts = [1]\npressure = 1.0\n[pressure.blast]\n\
             mass = {mass:?}\nposition = [0.0, 0.0, 500.0]\nburst = \"ground\"\n"
        );
        crumple::input::job::read_text("job.toml".into(), text, &[])
    };
    let report = job("", 0.0).err().expect("no units").to_string();
    assert!(report.contains("an explosion needs units"), "{report}");
    let report = job("units = \"mm, ms, kg\"\n", -1.0).err().expect("no charge").to_string();
    assert!(report.contains("the mass of a charge is -1"), "{report}");
    let model = job("units = \"mm, ms, kg\"\n", 2.0).unwrap_or_else(|report| panic!("{report}"));
    let blast = model.settings.loads.pressures[0].blast.expect("an explosion");
    assert_eq!((blast.mass, blast.si[0], blast.si[1]), (2.0, 1e-3, 1e-3));
    assert!((blast.si[2] / 1e9 - 1.0).abs() < 1e-12, "{:?}", blast.si);
    // 2 kg at 0.5 m is within the tables; at 5 mm and at 60 m it is not.
    let at = |position: f64| {
        let card = format!("*LOAD_BLAST_ENHANCED\n3,2.0,0,0,{position},0,6,1\n{ON_SET}");
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deck.k");
        std::fs::write(&path, format!("{}*END\n", plate(&card))).unwrap();
        crumple::input::job::read(&path, &[])
    };
    let near = at(5.0).unwrap_or_else(|report| panic!("{report}"));
    let words = "1 of 1 faces are nearer than 8.49";
    assert!(near.warnings.iter().any(|w| w.message.contains(words)), "{:?}", near.warnings);
    let far = at(60_000.0).err().expect("too far").to_string();
    assert!(far.contains("1 of 1 faces are farther than 5.0397e4"), "{far}");
}
