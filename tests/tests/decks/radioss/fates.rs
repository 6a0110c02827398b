//! Fates of the fields of a deck: nothing that is given has no effect without a word.

use super::{deck, mesh, model, moves, properties, reading, said, steel, with};

/// Fields of the deck of the first test, as the mapping or a warning names them.
const NAMED: &[&str] = &[
    "ismstr 4",
    "ish3n 2",
    "`ipinch` = 3",
    "`pthick` = 0.5",
    "hm 0.02",
    "hf 0.03",
    "hr 0.04",
    "`dm` = 0.05",
    "`dn` = 0.06",
    "istrain 1",
    "ashear 0.9",
    "iplas 2",
    "N 0",
    "icpre 1",
    "itetra10 1",
    "inpts 222",
    "iframe 2",
    "`dn` = 0.1",
    "`lambda` = 0.3",
    "`mu` = 0.4",
    "`dtmin`",
    "`more`",
    "rhoref",
    "`fsmooth` = 1",
    "`fcut` = 10",
    "`chard` = 0.5",
    "istf 2",
    "igap 2",
    "iremi2 3",
    "idel 2",
    "meshsize 0.3",
    "`gapmaxs` = 5",
    "`gapmaxm` = 6",
    "stmin 1",
    "stmax 2",
    "igap0 1",
    "ishape 2",
    "edgeangle 10",
    "stfac 0.5",
    "inacti 5",
    "viss 0.2",
    "ithick 1",
    "`pmax` = 9",
    "`ifiltr` = 1",
    "`xfreq` = 100",
];

/// Each field that has no counterpart is named: in the mapping, in a warning or in an error.
#[test]
fn no_given_field_is_without_a_word() {
    let properties = deck(
        "/PROP/SHELL/1
        =sheet
        i1 i4 i2 i1 i3 _ r0.5
        r0.02 r0.03 r0.04 r0.05 r0.06
        i0 i1 r1.0 r0.9 _ i1 i2
        /PROP/SOLID/2
        =block
        i1 i4 _ i1 i1 i222 i1 i2 r0.1
        r1.2 r0.06 r0.2 r0.3 r0.4
        r1e-9 i1",
    );
    let law = deck(
        "/MAT/LAW2/1
        =steel
        r7.85e-6 r7.8e-6
        r207.0 r0.3
        r0.3 r0.4 r0.5 r0.8
        r0.01 r1e-3 i1 i1 r10.0 r0.5",
    );
    let contact = deck(
        "/SURF/PART/1
        =all
        i1 i2
        /INTER/TYPE25/1
        =touch
        i1 i0 i2 i0 i2 i3 _ i2 i22
        i0 _ r0.9 r0.3 r5.0 r6.0
        r1.0 r2.0 i1 i2 r10.0
        r0.5 r0.1 _ _ r1.0 r5.0
        _ _ i0 i5 r0.2 i1 _ r9.0
        i4 i1 r100.0
        r0.05 r2.0
        _",
    );
    let all = said(&model(&(mesh() + &properties + &law + &contact + &moves())));
    for field in NAMED {
        assert!(all.contains(field), "missing: {field}\n{all}");
    }
}

/// A main node in no element is named as such, and not as a node that is left out.
#[test]
fn main_nodes_stand_for_their_bodies() {
    let body = "/NODE\ni90 r5 r5 r5\ni91 r9 r9 r9\n/GRNOD/PART/3\n=cube\ni2\n/RBODY/1\n=b\n\
                i90 i0 i0 i0 r0 i3";
    let all = said(&model(&with(body)));
    let words = "node 90: main node of /RBODY, in no element -> no part of the model";
    assert!(all.contains(words), "{all}");
    assert!(all.contains("node 91 belongs to no element and is left out"), "{all}");
}

/// Fields that would change the result are errors.
#[test]
fn fields_that_matter_are_refused() {
    let refused = |text: String| reading(&text, &[]).err().unwrap_or_else(|| panic!("{text}"));
    for (lines, field) in [
        ("/SH3N/1\ni7 i11 i12 i15 _ _ r45 r0", "`phi` of element 7"),
        ("/INTER/TYPE24/1\n=c\ni1\ni3\n_\nr0\n_\n_ _\n/SURF/PART/1\n=s\ni1", "`grnod` = 3"),
        ("/INTER/TYPE7/1\n=c\ni0 i1 i0 i1\nr0\nr0\nr0\n_\n/SURF/PART/1\n=s\ni1", "`ithe` = 1"),
        ("/INTER/TYPE25/1\n=c\ni1\ni0\n_\nr0\n_\ni1\nr1\n/SURF/PART/1\n=s\ni1", "`ifric` = 1"),
        ("/ADMAS/2/1\n=m\nr1 i1", "`kind` = 2"),
        ("/FUNCT/1\n=f\nr0 r1\nr1 r1\n/GRAV/1\n=g\ni1 wX i0 i5 i0 _ r1 r1", "`sens` = 5"),
    ] {
        let report = refused(with(lines));
        assert!(report.contains(field), "missing: {field}\n{report}");
    }
    let law = deck("/MAT/LAW2/1\n=m\nr1e-6\nr200 r0.3 i2\nr0.3 r0.1 r1 r0 r0.5\nr0.1 r1 i2");
    let report = refused(mesh() + &properties() + &law + &moves());
    for field in ["`iflag` = 2", "`icc` = 2"] {
        assert!(report.contains(field), "missing: {field}\n{report}");
    }
    // Text where nothing belongs.
    let odd = steel();
    let text =
        mesh() + &properties() + &odd + &moves() + &deck("/GRNOD/NODE/3\n=g\ni11\n/BCS/3\n=b");
    let report = model(&(text + "12 111 000         0         3\n"));
    assert!(said(&report).contains("`blank`"), "{}", said(&report));
}

/// Cards of control that have nothing to control are accepted: a noise of nodes only if it is 0,
/// otherwise with a warning.
#[test]
fn control_without_a_counterpart_is_no_error() {
    let cards = "/RANDOM\nr0 r0\n/SHFRA/V4\n/MEMORY\n_\n/ALE/BCS/1\n=b\n=   111 111";
    let all = said(&model(&with(cards)));
    for name in ["/SHFRA/V4", "/MEMORY", "/ALE/BCS"] {
        assert!(all.contains(&format!("{name} is not read")), "{name}: {all}");
    }
    assert!(!all.contains("/RANDOM"), "{all}");
    let all = said(&model(&with("/RANDOM\nr0.001 r0.5")));
    assert!(all.contains("/RANDOM: `noise` = 0.001 is ignored"), "{all}");
}

/// Output and frames that nothing refers to are accepted with a warning. A condition in such a
/// frame is an error.
#[test]
fn requests_of_output_are_no_errors() {
    let all = said(&model(&with(
        "/TH/SPRING/1\n=s\nwDEF\ni1\n/TH/QUAD/2\n=q\nwDEF\ni1\n/TH/SURF/3\n=s\nwDEF\ni1\n\
         /FRAME/MOV/4\n=f\ni1 i2 i3\n/SKEW/MOV/5\n=f\ni1 i2 i3",
    )));
    for name in ["/TH/SPRING", "/TH/QUAD", "/TH/SURF", "/FRAME/MOV", "/SKEW/MOV"] {
        assert!(all.contains(&format!("{name} is not read")), "{name}: {all}");
    }
    let lines = "/SKEW/MOV/5\n=f\ni1 i2 i3\n/INIVEL/TRA/2\n=v\nr1 r0 r0 i900 i5";
    let report = reading(&with(lines), &[]).err().expect("a report");
    assert!(report.contains("there is no /SKEW/FIX with the id 5"), "{report}");
}

/// The third number of `/DT/NODA/CST` is a ratio of added mass.
#[test]
fn a_ratio_of_added_mass_is_named() {
    let of = |numbers: &str| {
        let steps = format!("/DT/NODA/CST/0\n{numbers}\n/END/ENGINE\n");
        let model = model(&with("").replacen("/END/ENGINE\n", &steps, 1));
        (model.job.time.mass_scaling_dt, said(&model))
    };
    let (plain, of_plain) = of("0.9 1e-5");
    let (same, of_ratio) = of("0.9 1e-5 0.05");
    assert_eq!(plain, same);
    let words = "`massratio` = 0.05 is ignored";
    assert!(of_ratio.contains(words) && !of_plain.contains(words), "{of_ratio}");
}

#[test]
fn the_page_of_keywords_is_current() {
    let page = crumple::input::deck::radioss::page();
    expect_test::expect_file!["../../../../cases/RADIOSS.md"].assert_eq(&page);
}
