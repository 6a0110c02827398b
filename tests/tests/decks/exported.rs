//! Every scene as an exported deck: read back, it is the same model with the same bits. What stays
//! in comments is pinned, so that a new key without a card fails here until its fate is decided, if
//! a scene or one of the jobs `every-*.toml` gives it. These jobs need every list and every law,
//! and only the keys that somebody has added to them.

use crumple::input::deck::BEYOND_ALL_STRAINS;
use crumple::input::deck::export::{ExportedDeck, export};
use crumple::input::job::{Model, read};
use crumple_proto::ids::ElemId;
use crumple_proto::job::Job;
use crumple_proto::mesh::Shape;
use crumple_proto::partition::{ElementRecord, Material, Param, Settings};
use crumple_worker::fem::materials::LAWS;
use serde_json::Value;
use std::fmt::Write as _;
use std::fs;
use std::path::{Path, PathBuf};

/// Keys of the settings of workers that the bits of a run show: parts and materials may name their
/// defaults, and curves have another order.
const BY_BITS: [&str; 5] = ["parts", "materials", "contact", "loads", "checkpoint"];

/// Returns the jobs of the scenes.
fn jobs() -> Vec<PathBuf> {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases");
    let mut jobs = Vec::new();
    for folder in fs::read_dir(&scenes).expect("cases").map(|entry| entry.unwrap().path()) {
        if !folder.join("job.toml").is_file() {
            continue;
        }
        let files = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path());
        jobs.extend(files.filter(|path| path.extension().is_some_and(|e| e == "toml")));
    }
    jobs.sort();
    assert!(jobs.len() > 20, "{jobs:?}");
    jobs
}

/// Returns lines, each after two blanks.
fn indented(lines: &[String]) -> String {
    lines.iter().map(|line| format!("  {line}\n")).collect()
}

/// Returns the model of a deck with this text.
fn read_back(text: &str, sets: &[String]) -> Model {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("exported.k");
    fs::write(&path, text).unwrap();
    read(&path, sets).unwrap_or_else(|report| panic!("{report}\n{}", &text[..text.len().min(4000)]))
}

/// Returns what all workers have, by key, without what the bits of a run show.
fn settings(of: &Settings) -> Vec<(String, Value)> {
    let Value::Object(all) = serde_json::to_value(of).expect("a value") else { panic!("a table") };
    all.into_iter().filter(|(key, _)| !BY_BITS.contains(&key.as_str())).collect()
}

/// Returns the settings of a job that do not reach workers, or only in another form.
fn beyond(job: &Job) -> Value {
    let mut output = serde_json::to_value(&job.output).unwrap();
    let histories = ["node", "section", "transducer"];
    histories.iter().for_each(|key| drop(output.as_object_mut().unwrap().remove(*key)));
    serde_json::json!({
        "time": job.time, "elements": job.elements, "output": output, "parallel": job.parallel,
        "checkpoint": job.checkpoint, "restart": job.restart, "require": job.require,
        "title": job.title, "units": job.units, "symmetry": job.symmetry,
    })
}

/// Moves particles to the end, in the order of their ids, and removes these: cards have none.
fn without_particle_ids(elements: &mut [ElementRecord]) {
    elements.sort_by_key(|e| (e.shape == Shape::Point1, e.id));
    elements.iter_mut().filter(|e| e.shape == Shape::Point1).for_each(|e| e.id = ElemId(0));
}

/// Checks that two models have the same settings and records. Particles may have other ids in the
/// same order.
fn assert_same(one: &Model, other: &Model, of: &str) {
    for ((key, a), (_, b)) in settings(&one.settings).iter().zip(&settings(&other.settings)) {
        assert_eq!(a, b, "{of}: {key}");
    }
    let (mut elements, nodes) = one.records();
    let (mut elements_back, nodes_back) = other.records();
    without_particle_ids(&mut elements);
    without_particle_ids(&mut elements_back);
    assert_eq!(elements.len(), elements_back.len(), "{of}");
    for (a, b) in elements.iter().zip(&elements_back) {
        assert_eq!(a, b, "{of}");
    }
    assert_eq!(nodes.len(), nodes_back.len(), "{of}");
    for (a, b) in nodes.iter().zip(&nodes_back) {
        assert_eq!(a, b, "{of}");
    }
    assert_eq!(beyond(&one.job), beyond(&other.job), "{of}");
}

/// Checks that two models move in the same way.
fn assert_same_motion(one: &Model, other: &Model, of: &str) {
    let [a, b] = [one, other].map(|model| crumple_tests::run_alone(model, |_| ()).nodes);
    assert!(a.x == b.x && a.v == b.v, "{of}: the coordinates differ");
}

/// Returns the lines of a deck without comments for readers.
fn cards(deck: &str) -> Vec<&str> {
    deck.lines().filter(|line| !line.starts_with("$ ")).collect()
}

/// Checks that a deck of a deck has the same cards, so that a model does not grow with each export.
/// Only the first deck of a job may have other names and numbers, but it has as many sets and
/// curves.
fn assert_steady(first: &ExportedDeck, again: &Model, of: &str) {
    let second = export(again).expect("a deck");
    for start in ["*SET_NODE_LIST", "*DEFINE_CURVE", "*MAT_", "$crumple: [[curve]]"] {
        let [one, two] = [first, &second]
            .map(|deck| deck.text.lines().filter(|line| line.starts_with(start)).count());
        assert_eq!(one, two, "{of}: {start}");
    }
    let third = export(&read_back(&second.text, &[])).expect("a deck");
    let (second, third) = (cards(&second.text), cards(&third.text));
    let differs = second.iter().zip(&third).find(|(a, b)| a != b);
    assert_eq!(differs, None, "{of}");
    assert_eq!(second.len(), third.len(), "{of}");
}

/// Each scene gives the same model and the same bits over some cycles. Those that a deck cannot
/// hold are refused with a cure.
#[test]
fn every_scene_is_the_same_as_a_deck() {
    let mut left = String::new();
    let few = ["time.max_cycles=8".to_string()];
    for path in jobs() {
        let name = path.strip_prefix(Path::new(env!("CARGO_MANIFEST_DIR")).join("../cases"));
        let name = name.unwrap().display().to_string();
        let model = read(&path, &few).unwrap_or_else(|report| panic!("{report}"));
        let _ = writeln!(left, "{name}");
        match export(&model) {
            Ok(deck) => {
                left += &indented(&deck.left);
                let again = read_back(&deck.text, &few);
                assert_same(&model, &again, &name);
                assert_same_motion(&model, &again, &name);
                assert_steady(&deck, &again, &name);
            }
            Err(refused) => left += &indented(&[format!("refused: {refused}")]),
        }
    }
    expect_test::expect_file!["../../decks/exported/scenes.txt"].assert_eq(&left);
}

/// A job with every list of the schema, as a deck.
#[test]
fn no_list_of_a_job_is_lost() {
    let path = exported().join("every-list.toml");
    let model = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
    let deck = export(&model).expect("a deck");
    let again = read_back(&deck.text, &[]);
    assert_steady(&deck, &again, "every list");
    let [before, after] = [&model.job, &again.job].map(|job| serde_json::to_value(job).unwrap());
    let schema = Job::schema();
    let mut fates = String::new();
    for (list, of) in schema["properties"].as_object().expect("keys") {
        let is_list = of["type"] == "array" && of["items"].get("$ref").is_some();
        if !is_list {
            continue;
        }
        let count = |job: &Value| job[list].as_array().map_or(0, Vec::len);
        assert!(count(&before) > 0, "{list}: add an entry of it to {}", path.display());
        // Sets by rule become lists of nodes.
        assert!(list == "set" || count(&after) >= count(&before), "{list}: entries are lost");
        let start = format!("{list}: no card for ");
        let fate = match deck.left.iter().find_map(|line| line.strip_prefix(&start)) {
            Some(number) => format!("{number} of {} in comments", count(&before)),
            None => "on cards".to_string(),
        };
        let _ = writeln!(fates, "[[{list}]] {fate}");
    }
    let _ = writeln!(fates, "\nnot on cards alone:");
    fates += &indented(&deck.left);
    assert_same(&model, &again, "every list");
    assert_same_motion(&model, &again, "every list");
    // A second export: names from a deck must not be mistaken for others.
    let twice = read_back(&export(&again).expect("a deck").text, &[]);
    assert_same(&model, &twice, "exported twice");
    assert_eq!(entries(&again), entries(&twice), "a second export adds entries");
    expect_test::expect_file!["../../decks/exported/every-list.txt"].assert_eq(&fates);
}

/// A set to which joints add nodes without mass keeps its id only if nothing else uses it: a load
/// on it must not act on these nodes.
#[test]
fn loads_do_not_act_on_the_nodes_of_joints() {
    let path = exported().join("every-list.toml");
    let model = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
    let text = export(&model).expect("a deck").text;
    let lines: Vec<&str> = text.lines().collect();
    let body = lines.iter().position(|l| l.starts_with("*CONSTRAINED_NODAL_RIGID_BODY"));
    let set = lines[body.expect("a body") + 2].split_whitespace().last().expect("a set");
    let curve =
        lines[lines.iter().position(|l| *l == "*DEFINE_CURVE").expect("a curve") + 1].trim();
    let nodes_of = |text: &str, set: &str| -> Vec<String> {
        let lines: Vec<&str> = text.lines().collect();
        let is_set = |at: &usize| lines[*at].starts_with("*SET_NODE_LIST");
        let head = |at: usize| at + 1 + usize::from(lines[at].ends_with("_TITLE"));
        let found = (0..lines.len()).find(|at| is_set(at) && lines[head(*at)].trim() == set);
        let first = head(found.expect("the set")) + 1;
        let cards = lines[first..].iter().take_while(|line| !line.starts_with('*'));
        cards.flat_map(|line| line.split_whitespace().map(String::from)).collect()
    };
    let loaded = text.replace("*END\n", &format!("*LOAD_NODE_SET\n{set},1,{curve},1.0\n*END\n"));
    let again = export(&read_back(&loaded, &[])).expect("a deck").text;
    let load = again.split("*LOAD_NODE_SET\n").last().expect("a load");
    let set_of_load = load.split_whitespace().next().expect("a set");
    assert_eq!(nodes_of(&text, set).len(), 7, "with three nodes of joints");
    assert_eq!(nodes_of(&again, set_of_load), ["71", "72", "73", "74"]);
}

/// Returns rows of hardening curves without the points that keep them constant for other programs.
fn without_constant_ends(rows: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let stress_before = |place: usize| place.checked_sub(1).and_then(|p| rows[p].last());
    let is_end = |(place, row): &(usize, &Vec<f64>)| {
        let is_far = row[row.len() - 2] == BEYOND_ALL_STRAINS;
        assert!(!is_far || row.last() == stress_before(*place), "{rows:?}");
        is_far
    };
    rows.iter().enumerate().filter(|row| !is_end(row)).map(|(_, row)| row.clone()).collect()
}

/// Every law with its keys: a deck has all of them with the same values, and those that it adds are
/// defaults, since the motion has the same bits.
#[test]
fn every_law_keeps_its_keys() {
    let path = exported().join("every-law.toml");
    let model = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
    for law in LAWS.iter() {
        let is_used = |m: &Material| m.law == law.name;
        assert!(model.settings.materials.iter().any(is_used), "add {} to the job", law.name);
    }
    let deck = export(&model).expect("a deck");
    let again = read_back(&deck.text, &[]);
    let mut left = String::new();
    for material in &model.settings.materials {
        let back = again.settings.materials.iter().find(|m| m.name == material.name);
        let back = back.unwrap_or_else(|| panic!("{} is lost", material.name));
        assert_eq!((&back.law, back.density), (&material.law, material.density));
        for (key, param) in &material.parameters {
            let found = back.parameters.get(key).map(|param| match (key.as_str(), param) {
                ("hardening" | "hardening_by_rate", Param::Table(rows)) => {
                    Param::Table(without_constant_ends(rows))
                }
                ("tension" | "tension_by_rate" | "compression" | "shear", Param::Table(rows)) => {
                    Param::Table(without_constant_ends(rows))
                }
                _ => param.clone(),
            });
            assert_eq!(found.as_ref(), Some(param), "{}: {key}", material.name);
        }
        let added = back.parameters.keys().filter(|key| !material.parameters.contains_key(*key));
        left.extend(added.map(|key| format!("{}: {key} is added\n", material.name)));
    }
    left.extend(deck.left.iter().map(|line| format!("{line}\n")));
    assert_same(&model, &again, "every law");
    assert_same_motion(&model, &again, "every law");
    assert_steady(&deck, &again, "every law");
    expect_test::expect_file!["../../decks/exported/every-law.txt"].assert_eq(&left);
}

/// Returns the folder of the jobs of these tests.
fn exported() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("decks/exported")
}

/// Returns a job of this folder as a deck that is read back, and checks that the models are the
/// same, also after a second export. Returns the deck and the model by it.
fn same_as_deck(name: &str, sets: &[String]) -> (ExportedDeck, Model) {
    let path = exported().join(name);
    let model = read(&path, sets).unwrap_or_else(|report| panic!("{report}"));
    let deck = export(&model).expect("a deck");
    let again = read_back(&deck.text, &[]);
    assert_same(&model, &again, name);
    assert_same_motion(&model, &again, name);
    let twice = read_back(&export(&again).expect("a deck").text, &[]);
    assert_same(&model, &twice, name);
    assert_same_motion(&model, &twice, name);
    assert_eq!(entries(&again), entries(&twice), "{name}: a second export adds entries");
    (deck, again)
}

/// Returns the number of entries of each list of a job. Each export writes its own curves.
fn entries(model: &Model) -> Vec<(String, usize)> {
    let Value::Object(job) = serde_json::to_value(&model.job).unwrap() else { panic!("a table") };
    let lists = job.into_iter().filter(|(key, _)| key != "curve");
    lists.filter_map(|(key, list)| Some((key, list.as_array()?.len()))).collect()
}

/// Returns how often a deck has a keyword.
fn count(deck: &ExportedDeck, keyword: &str) -> usize {
    deck.text.lines().filter(|line| line.strip_prefix('*') == Some(keyword)).count()
}

/// Ties of each kind keep their order and their limits. A card that adds a contact is written only
/// where the job has this contact.
#[test]
fn ties_have_cards() {
    let (deck, again) = same_as_deck("ties.toml", &[]);
    for (keyword, times) in [
        ("CONTACT_TIED_NODES_TO_SURFACE_ID", 1),
        ("CONTACT_TIEBREAK_NODES_ONLY_ID", 2),
        ("CONTACT_TIEBREAK_SURFACE_TO_SURFACE_ONLY_ID", 2),
        ("CONTACT_AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE_TIEBREAK_ID", 4),
        ("CONSTRAINED_INTERPOLATION", 4),
        ("CONSTRAINED_NODE_SET", 1),
    ] {
        assert_eq!(count(&deck, keyword), times, "{keyword}: {}", deck.text);
    }
    expect_test::expect_file!["../../decks/exported/ties.txt"].assert_eq(&deck.left.join("\n"));
    let contacts: Vec<_> = again.job.contact.as_ref().expect("contact").each().collect();
    for name in ["damage", "turning"] {
        let contact = contacts.iter().find(|c| c.name == name).expect("a contact of the card");
        assert_eq!((contact.friction, contact.friction_limit), (0.3, Some(0.2)));
    }
    // Another contact between the parts: a reader would have that of the card.
    let thick = ["contact.interface.uppers on all.thickness=0.7".to_string()];
    let (deck, _) = same_as_deck("ties.toml", &thick);
    assert_eq!(count(&deck, "CONTACT_TIEBREAK_SURFACE_TO_SURFACE_ONLY_ID"), 6, "{}", deck.text);
}

/// Names that are written for ties without one, and those that a reader gives, are no names of
/// other ties: a reader would merge these.
#[test]
fn ties_with_names_of_cards_are_not_merged() {
    let path = exported().join("ties.toml");
    let given = fs::read_to_string(&path).unwrap();
    let last = |name: &str| format!("\nname = \"{name}\"\nnodes = \"upper12\"\n");
    let two = "\n[[tie]]\nname = \"tie 1\"\nnodes = \"upper13\"\nnode = 1207\n";
    for (name, more) in [("tie 1", ""), ("interpolation 1", ""), ("tie 1", two)] {
        let text = given
            .replace("name = \"lasting\"", "name = \"\"")
            .replace("upper12 = [1205, 1206, 1208]", "upper12 = [1205, 1206]\nupper13 = [1208]")
            .replace("\nnodes = \"upper12\"\n", &last(name))
            + more;
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("ties.toml");
        fs::write(&path, text).unwrap();
        let model = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
        let again = read_back(&export(&model).expect("a deck").text, &[]);
        // The tie to a mean has a card for each of its four nodes.
        assert_eq!(again.job.tie.len(), model.job.tie.len() + 3, "{name}");
        assert_same(&model, &again, name);
        assert_same_motion(&model, &again, name);
    }
}

/// Given mass, centre and inertia of a body are on the card of its leading part, with its motion at
/// the start; what is fixed of a body of nodes is on its card.
#[test]
fn mass_properties_of_bodies_have_cards() {
    let (deck, again) = same_as_deck("bodies.toml", &[]);
    // The motion of a body is on its own card, too, for programs that take it from there.
    let given = read(&exported().join("bodies.toml"), &[]).unwrap_or_else(|r| panic!("{r}"));
    assert_eq!(again.job.initial_velocity.len(), given.job.initial_velocity.len());
    // The second deck also has the sets that a reader makes of parts, and the third one no others.
    let second = export(&again).expect("a deck");
    let third = export(&read_back(&second.text, &[])).expect("a deck");
    let sets =
        |deck: &ExportedDeck| deck.text.lines().filter(|l| l.starts_with("*SET_NODE")).count();
    assert_eq!((sets(&deck), sets(&second), sets(&third)), (2, 5, 5));
    for (keyword, times) in [
        ("PART_INERTIA", 2),
        ("PART_INERTIA_CONTACT", 1),
        ("CONSTRAINED_RIGID_BODIES", 1),
        ("CONSTRAINED_NODAL_RIGID_BODY_SPC_TITLE", 1),
        ("CONSTRAINED_GLOBAL", 2),
    ] {
        assert_eq!(count(&deck, keyword), times, "{keyword}: {}", deck.text);
    }
    // A sheet of 0.785 g has the given 10 g.
    let heavy =
        deck.text.lines().skip_while(|line| *line != "steel, heavy").nth(1).expect("a card");
    // Columns of 20; all of them are full, so that the exponent has no letter.
    let density: f64 = heavy[20..40].trim().replace("-4", "e-4").parse().expect("a density");
    assert!((density * 100.0 / 0.01 - 1.0).abs() < 1e-12, "{heavy}");
    // The velocity at the centre (13, 5, 7) by the spin about (5.1, 4.9, 5.3).
    let lines: Vec<&str> = deck.text.lines().collect();
    let part = lines.iter().position(|line| *line == "*PART_INERTIA").expect("a part");
    let motion: Vec<f64> =
        lines[part + 5].split_whitespace().map(|v| v.parse().expect("a number")).collect();
    let (arm, spin) = ([7.9, 0.1, 1.7], [0.1234567, 0.7654321, 3.3333]);
    let turned = [1, 2, 0].map(|c| {
        let next = (c + 1) % 3;
        spin[c] * arm[next] - spin[next] * arm[c]
    });
    let expected = [0.123, 2.017, 0.31].iter().zip(turned).map(|(v, w)| v + w);
    assert!(motion.iter().zip(expected).all(|(a, b)| (a - b).abs() < 1e-12), "{motion:?}");
    assert_eq!(motion[3..], spin);
    expect_test::expect_file!["../../decks/exported/bodies.txt"].assert_eq(&deck.left.join("\n"));
}

/// The weights of a tie to a mean, and the first node of a tie to a node, follow the ids of the
/// user, also if the mesh is numbered again.
#[test]
fn ties_of_a_renumbered_mesh_keep_their_weights() {
    const SIDE: usize = 160;
    const NODES: usize = (SIDE + 1) * (SIDE + 1);
    // Without a factor in common with NODES = 7^2 23^2, each id comes once.
    let id = |i: usize, j: usize| 1 + ((i * (SIDE + 1) + j) * 9973) % NODES;
    let mut nodes = String::new();
    let mut shells = String::new();
    for (i, j) in (0..=SIDE).flat_map(|i| (0..=SIDE).map(move |j| (i, j))) {
        writeln!(nodes, "[{}, {i}.0, {j}.0, 0.0],", id(i, j)).unwrap();
        if i < SIDE && j < SIDE {
            let corners = [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
            writeln!(shells, "[{}, 1, {corners:?}],", 1 + i * SIDE + j).unwrap();
        }
    }
    let shells = shells.replace(", [", ", ").replace("]],", "],");
    for (k, (x, y)) in [(80, 80), (81, 80), (81, 81), (80, 81)].into_iter().enumerate() {
        writeln!(nodes, "[{}, {x}.0, {y}.0, 2.0],", NODES + 1 + k).unwrap();
    }
    let [a, b, c, d] = [1, 2, 3, 4].map(|k| NODES + k);
    let masters = [id(80, 80), id(81, 80), id(81, 81), id(80, 81)];
    assert!(!masters.is_sorted(), "the order of the ids is not that of the places");
    // The smallest id of a row is between these ends, whichever end has the first place.
    let ends = [id(40, 20), id(40, 90)];
    let carrier = (21..90).map(|j| id(40, j)).min().unwrap();
    assert!(ends.iter().all(|&end| carrier < end));
    let text = format!(
        "title = \"Ties\"\nend_time = 0.01\nunits = \"mm, ms, kg\"\n[time]\nmax_cycles = 8\n\
         [mesh]\nnodes = [\n{nodes}]\nshells = [\n{shells}[99999, 2, {a}, {b}, {c}, {d}],\n]\n\
         [mesh.node_sets]\nslave = [{a}]\nmasters = {masters:?}\nends = {ends:?}\n\
         [[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
         youngs_modulus = 207.0\npoisson = 0.3\n\
         [[part]]\nid = 1\nmaterial = \"steel\"\nthickness = 1.0\n\
         [[part]]\nid = 2\nmaterial = \"steel\"\nthickness = 1.0\n\
         [[initial_velocity]]\nnodes = \"masters\"\nvelocity = [0.0, 0.3, 5.0]\n\
         [[tie]]\nname = \"interpolation 1\"\nnodes = \"slave\"\nmean_of = \"masters\"\n\
         weights = [1.0, 2.0, 3.0, 4.0]\n\
         [[tie]]\nnodes = \"ends\"\nnode = {carrier}\n"
    );
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("job.toml");
    fs::write(&path, text).unwrap();
    let model = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
    let is_renumbered = model.mesh.nodes.iter().any(|n| n.id.0 != n.id.label());
    assert!(is_renumbered, "the mesh is large enough to be numbered again");
    let deck = export(&model).expect("a deck");
    for keyword in ["CONSTRAINED_INTERPOLATION", "CONSTRAINED_NODE_SET"] {
        assert_eq!(count(&deck, keyword), 1, "{keyword}");
    }
    let again = read_back(&deck.text, &[]);
    assert_same(&model, &again, "ties of a renumbered mesh");
    assert_same_motion(&model, &again, "ties of a renumbered mesh");
}

/// Other programs take tetrahedra and wedges of the formulation of hexahedra for collapsed
/// hexahedra, so that each shape has its own.
#[test]
fn each_shape_of_solids_has_its_formulation() {
    let (deck, _) = same_as_deck("solids.toml", &[]);
    let lines: Vec<&str> = deck.text.lines().collect();
    let elforms: Vec<(u64, u64)> = (lines.windows(3))
        .filter(|three| three[0] == "*SECTION_SOLID")
        .map(|three| {
            let card = three[1..].iter().find(|line| !line.starts_with('$')).expect("a card");
            let mut fields = card.split_whitespace().map(|f| f.parse().expect("an integer"));
            (fields.next().expect("an id"), fields.next().expect("an elform"))
        })
        .collect();
    let expected = [(1, 1), (2, 13), (3, 10), (4, 15), (5, 15), (6, 13), (7, 16), (8, 13), (9, 1)];
    assert_eq!(elforms, expected, "{}", deck.text);
    // Wedges without averaging have no formulation.
    let left = "part.pressure: no card for 1";
    assert!(deck.left.iter().any(|line| line == left), "{:?}", deck.left);
}

/// Settings of output and units have cards, with the same values in the job by them. What is not on
/// cards alone is in the comments.
#[test]
fn settings_of_output_and_units_have_cards() {
    let text = "end_time = 4.0\nunits = \"mm, ms, kg\"\n[time]\nmax_cycles = 8\n\
                [mesh]\nnodes = [[1, 0.0, 0.0, 0.0], [2, 1.0, 0.0, 0.0], [3, 1.0, 1.0, 0.0], \
                [4, 0.0, 1.0, 0.0]]\nshells = [[1, 1, 1, 2, 3, 4]]\n\
                [[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
                youngs_modulus = 207.0\npoisson = 0.3\n\
                [[part]]\nid = 1\nmaterial = \"steel\"\nthickness = 1.0\n[output]\n";
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("job.toml");
    let units = |units: &str| text.replace("mm, ms, kg", units);
    for (given, cards, left) in [
        (format!("{text}strains = true"), &["*DATABASE_EXTENT_BINARY", "1"][..], &[][..]),
        (
            format!("{text}field_interval = -1.0\nfield_times = [0.5, 3.0]"),
            &["*DATABASE_BINARY_D3PLOT", "1", "3"],
            &[],
        ),
        (
            format!("{text}field_interval = -1.0\nfield_times = [0.5]"),
            &["*DEFINE_CURVE", "1", "0.5 0.", "8. 0."],
            &[],
        ),
        // Other programs take all times from the curve.
        (
            format!("{text}field_interval = 2.0\nfield_times = [0.5, 2.0]"),
            &["*DEFINE_CURVE", "1", "0. 0.", "0.5 0.", "2. 0.", "4. 0."],
            &["output.field_times: no card for 1"],
        ),
        (
            format!("{text}field_interval = -1.0\nfield_times = [3.0, 0.5]"),
            &[],
            &["output.field_interval: no card for 1", "output.field_times: no card for 1"],
        ),
        (units("in, s, slinch"), &["*CONTROL_UNITS", "in sec slinch"], &[]),
        (units("mm, s, tonne"), &["*CONTROL_UNITS", "mm sec mtrc_ton"], &[]),
        (units("kg, m, s"), &[], &["units: no card for 1"]),
        (units("mm, ms, kg (guessed)"), &[], &["units: no card for 1"]),
    ] {
        fs::write(&path, &given).unwrap();
        let model = read(&path, &[]).unwrap_or_else(|report| panic!("{report}"));
        let deck = export(&model).expect("a deck");
        let lines: Vec<String> = (deck.text.lines())
            .map(|line| line.split_whitespace().collect::<Vec<_>>().join(" "))
            .collect();
        let is_there = lines.windows(cards.len().max(1)).any(|some| some == cards);
        assert!(cards.is_empty() || is_there, "{cards:?} in {}", deck.text);
        assert_eq!(deck.left, left, "{given}");
        assert_same(&model, &read_back(&deck.text, &[]), &given);
    }
}

/// Units that a deck states count, also those of blanks; others are named, and units are guessed.
#[test]
fn stated_units_of_a_deck_count() {
    let text = fs::read_to_string(exported().join("solids.toml")).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("job.toml");
    fs::write(&path, text).unwrap();
    let deck = export(&read(&path, &[]).unwrap_or_else(|report| panic!("{report}"))).unwrap();
    let card = format!("{:>20}{:>20}{:>20}\n", "mm", "ms", "kg");
    assert!(deck.text.contains(&card), "{}", deck.text);
    for (words, units) in [
        (["CM", "MICRO_S", "G"], "cm, us, g"),
        (["", "", ""], "m, s, kg"),
        (["mile", "ms", "kg"], "mm, ms, kg (guessed)"),
    ] {
        let [length, time, mass] = words;
        let stated = format!("{length:>20}{time:>20}{mass:>20}\n");
        let model = read_back(&deck.text.replace(&card, &stated), &[]);
        assert_eq!(model.job.units, units);
    }
}
