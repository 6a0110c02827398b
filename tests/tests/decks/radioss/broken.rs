//! Faulty decks: each mistake is named with its file, its line, and the way out.

use super::{deck, mesh, moves, properties, reading, steel, with};

/// A mistake: the deck, the text of the line where it is, and what the report says.
struct Mistake {
    text: String,
    /// Part of the line to which the report points.
    line: &'static str,
    said: &'static [&'static str],
}

fn of(text: String, line: &'static str, said: &'static [&'static str]) -> Mistake {
    Mistake { text, line, said }
}

/// Returns the base with one text replaced.
fn replaced(from: &str, to: &str) -> String {
    let base = with("");
    assert!(base.contains(from), "{from}");
    base.replacen(from, to, 1)
}

fn cards() -> Vec<Mistake> {
    vec![
        of(
            replaced("               207.0", "              207.0x"),
            "207.0x",
            &["/MAT/ELAST: `e` has to be a number, not `207.0x`", "20 columns each"],
        ),
        of(replaced("/MAT/ELAST/1", "/MAT/ELATS/1"), "/MAT/ELATS", &["/MAT/ELAST", "--allow"]),
        of(replaced("      2022", "       100"), "100", &["version 100", "110 or later"]),
        of(
            replaced("/PROP/SHELL/1\nsheet\n", "/PROP/SHELL/1\n"),
            "         3         0",
            &["`hm` has to be a number", "which has 2 words: check the columns", "card 3"],
        ),
        of(
            replaced(
                "         1         1         0\n/PART",
                "         1         7         0\n/PART",
            ),
            "         7",
            &["there is no /MAT/... with the id 7", "1"],
        ),
        of(
            replaced(
                "         2         1         0\n/PROP",
                "         9         1         0\n/PROP",
            ),
            "         9",
            &["there is no /PROP/... with the id 9"],
        ),
        of(replaced("/SHELL/1", "/SHELL/3"), "        11        12", &["part 3"]),
        of(
            replaced("        11                   0", "        1x                   0"),
            "1x",
            &["`nid` has to be a whole number, not `1x`"],
        ),
        of(
            replaced("         1        11        12", "         1        99        12"),
            "99",
            &["node 99"],
        ),
        of(replaced("/SHELL/1", "/SHELL"), "/SHELL", &["`id` has to be an id above 0"]),
        of(replaced("/PART/2\ncube", "/PART/1\ncube"), "/PART/1", &["two /PART with the id 1"]),
        of(replaced("/PROP/SOLID/2", "/PROP/SOLID/1"), "/PROP/SOLID/1", &["two properties"]),
        of(with("/MAT/ELAST/1\n=again\nr1 \nr2 r0.3"), "/MAT/ELAST/1", &["two materials"]),
        of(
            replaced("                 1.0\n/PROP/SOLID", "                -1.0\n/PROP/SOLID"),
            "-1.0",
            &["thickness"],
        ),
        of(
            replaced("        24         0         0", "        77         0         0"),
            "77",
            &["`ishell` = 77 is not supported", "24 (stabilised_quad)"],
        ),
        of(replaced("        24\n", "        77\n"), "77", &["`isolid` = 77 is not supported"]),
        of(format!("1 2 3\n{}", with("")), "1 2 3", &["a card precedes the first keyword"]),
        of(with("#include"), "#include", &["names no file"]),
        of(with("#include nowhere.inc"), "#include", &["nowhere.inc cannot be read", "names are"]),
    ]
}

fn conditions() -> Vec<Mistake> {
    let moved = "/FUNCT/1\n=one\nr0 r1\nr10 r1\n";
    let motion =
        |card: &str| with(&format!("{moved}/GRNOD/NODE/1\n=g\ni11\n/IMPVEL/1\n=v\n{card}"));
    vec![
        of(with("/BCS/1\n=fixed\n_ i0 i5"), "5", &["no /GRNOD/... with the id 5"]),
        of(
            with("/GRNOD/NODE/1\n=g\ni11\n/BCS/1\n=fixed") + "   121 111         0         1\n",
            "121",
            &["`tra` has to be three digits 0 or 1, not `121`", "columns 4 to 6"],
        ),
        of(
            with("/GRNOD/NODE/1\n=g\ni11\n/BCS/1\n=fixed") + "   111 111         3         1\n",
            "3",
            &["skew"],
        ),
        of(motion("i1 wQ i0 i0 i1"), "Q", &["`dir` has to be a direction, not `Q`", "X, Y or Z"]),
        of(motion("i7 wX i0 i0 i1"), "7", &["no /FUNCT with the id 7"]),
        of(motion("i1 wX i0 i4 i1"), "4", &["`sens` = 4 is not supported", "sensor"]),
        of(motion("i1 wX i0 i0 i1 i0\nr1 r1 r2 r0"), "2", &["`tstart` = 2"]),
        of(with("/FUNCT/1\n=empty"), "/FUNCT/1", &["has no points", "twenty columns"]),
        of(with("/GRNOD/PART/1\n=g\ni8"), "8", &["no /PART with the id 8"]),
        of(with("/GRNOD/BOX/1\n=g\ni8"), "8", &["no /BOX/RECTA with the id 8"]),
        of(with("/GRNOD/GRSHEL/1\n=g\ni8"), "8", &["no /GRSHEL/... with the id 8"]),
        of(with("/GRNOD/NODE/1\n=a\ni1\n/GRNOD/PART/1\n=b\ni1"), "/GRNOD/PART/1", &["two groups"]),
        of(with("/RBODY/1\n=b\ni99 i0 i0 i0 r0 i1"), "1", &["/GRNOD/..."]),
        of(
            with("/GRNOD/NODE/1\n=g\ni1 i2\n/RBODY/1\n=b\ni99 i0 i0 i0 r0 i1"),
            "99",
            &["no /NODE with the id 99"],
        ),
        of(
            with("/RWALL/PLANE/1\n=w\ni0 i0\nr99\nr0 r0 r0\nr0 r0 r0"),
            "0",
            &["M1 is M", "on the side of the model"],
        ),
        of(with("/INTER/TYPE25/1\n=c\ni4\ni0\n_\nr0 r0\n_"), "4", &["no /SURF/... with the id 4"]),
        of(with("/INTER/TYPE2/1\n=t\ni1 i1"), "1", &["/GRNOD/...", "/SURF/..."]),
        of(with("/SURF/PART/1\n=s\ni1\n/PLOAD/1\n=p\ni1 i3"), "3", &["no /FUNCT"]),
        of(with("/BRIC20/1\ni9 i1"), "/BRIC20", &["not supported yet", "mesh with eight"]),
        of(with("/TETRA10/1\ni9"), "9", &["ends before the nodes of its last element"]),
        of(with("/MAT/PLAS_ZERIL/3\n=z"), "/MAT/PLAS_ZERIL", &["Zerilli", "/MAT/LAW2"]),
        of(with("/FAIL/JOHNSON/1\nr0.1"), "/FAIL/JOHNSON", &["the law of the material is"]),
        of(
            with("/UNIT/3\n=other\nrg rmm rms\n/MAT/ELAST/2/3\n=m\nr1\nr1 r0"),
            "2/3",
            &["are not converted", "the units of /BEGIN"],
        ),
    ]
}

/// Every mistake gives an error that names the file and the line and says what to do.
#[test]
fn every_mistake_is_named_with_its_line_and_a_cure() {
    let all: Vec<Mistake> = cards().into_iter().chain(conditions()).collect();
    assert!(all.len() >= 35);
    let mut wrong = Vec::new();
    for Mistake { text, line, said } in all {
        let report = match reading(&text, &[]) {
            Err(report) => report,
            Ok(_) => {
                wrong.push(format!("it passes: {said:?}"));
                continue;
            }
        };
        let lacking = said.iter().chain(&["plate_0000.rad", "help:"]);
        wrong.extend(
            lacking
                .filter(|part| !report.contains(*part))
                .map(|p| format!("no `{p}` in\n{report}")),
        );
        // Lines of the deck are shown under their number, such as `12 | text`.
        let lines: Vec<&str> = text.lines().collect();
        let shown = report.lines().any(|l| {
            let Some((number, of)) = l.split_once('|') else { return false };
            let number = number.trim().parse::<usize>().ok().filter(|n| *n > 0);
            let own = number.and_then(|n| lines.get(n - 1));
            own.is_some_and(|own| own.trim_end() == of.trim() || own.trim() == of.trim())
                && of.contains(line.trim())
                && report.contains(&format!("plate_0000.rad:{}", number.unwrap_or(0)))
        });
        if !shown {
            wrong.push(format!("no line with `{line}` in\n{report}"));
        }
    }
    assert!(wrong.is_empty(), "{} of them:\n{}", wrong.len(), wrong.join("\n"));
}

/// All mistakes come at once: those of cards, of references and of unknown keywords.
#[test]
fn all_mistakes_are_reported_at_once() {
    let text = mesh()
        + &properties()
        + &steel()
        + &moves()
        + &deck("/NONSENSE/1\n/GRNOD/PART/1\n=g\ni8\n/BCS/1\n=b\n_ i0 i6");
    let report = reading(&text, &[]).err().unwrap();
    for part in ["/NONSENSE", "/PART with the id 8", "/GRNOD/... with the id 6"] {
        assert!(report.contains(part), "no {part} in\n{report}");
    }
    // Unsupported keywords can be ignored; the other mistakes stay.
    let report = reading(&text, &["mesh.allow_unsupported=true"]).err().unwrap();
    assert!(report.contains("/PART with the id 8"), "{report}");
    let allowed = with("/NONSENSE/1\n=x");
    let model = reading(&allowed, &["mesh.allow_unsupported=true"]).unwrap();
    assert!(model.unsupported.iter().any(|u| u.contains("/NONSENSE")), "{:?}", model.unsupported);
}

/// A number in the wrong columns is not read as another one.
#[test]
fn shifted_columns_are_an_error_or_a_warning() {
    let shifted = with("").replacen("               207.0", "207.0      205.0    ", 1);
    let report = reading(&shifted, &[]).err().unwrap();
    assert!(report.contains("has 2 words: check the columns"), "{report}");
    let beyond = with("").replacen("               207.0", &format!("{:>20}", "207.0"), 1);
    let long = beyond.replacen("                 0.3\n", &format!("{:>20}{:>30}\n", "0.3", 5), 1);
    let model = reading(&long, &[]).unwrap();
    let warned = model.warnings.iter().any(|w| w.message.contains("text after column 40"));
    assert!(warned, "{:?}", model.warnings);
}
