//! ARCHITECTURE.md against the repository: its paths exist, its map has all Rust files, and its
//! rules for imports and for names of types hold.

use crumple_tests::imports::{Source, files, sources};
use crumple_tests::program::root;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;

fn text() -> String {
    fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap()
}

/// Returns true if a word in backticks is a path: it has a slash, or an ending of files in this
/// repository. `DIR/...` is output of a run.
fn is_path(word: &str) -> bool {
    const ENDINGS: [&str; 6] = [".rs", ".sh", ".py", ".md", ".toml", ".sbatch"];
    let plain = word.chars().all(|c| c.is_ascii_alphanumeric() || "._-/".contains(c));
    plain
        && !word.starts_with("DIR/")
        && (word.contains('/') || ENDINGS.iter().any(|ending| word.ends_with(ending)))
}

#[test]
fn every_path_of_the_map_exists() {
    let (mut paths, mut missing) = (0, Vec::new());
    for (number, line) in text().lines().enumerate() {
        for word in line.split('`').skip(1).step_by(2).filter(|word| is_path(word)) {
            paths += 1;
            if !root().join(word).exists() {
                missing.push(format!("ARCHITECTURE.md:{}: {word} does not exist", number + 1));
            }
        }
    }
    assert!(missing.is_empty(), "{}", missing.join("\n"));
    assert!(paths > 20, "only {paths} paths found: check that the map has backticks");
}

#[test]
fn every_file_is_on_the_map() {
    let text = text();
    let map = text.split("\n## ").find(|section| section.starts_with("Map\n")).unwrap();
    let cell = |line: &str| line.strip_prefix("| ")?.split(" | ").next().map(String::from);
    let cells: Vec<String> = map.lines().filter_map(cell).collect();
    let words: BTreeSet<&str> =
        cells.iter().flat_map(|cell| cell.split('`').skip(1).step_by(2)).collect();
    let folders: Vec<&str> = words.iter().copied().filter(|word| word.ends_with('/')).collect();
    let on_map =
        |path: &str| words.contains(path) || folders.iter().any(|folder| path.starts_with(folder));
    let missing: Vec<String> = files(root()).into_iter().filter(|path| !on_map(path)).collect();
    assert!(missing.is_empty(), "the map of ARCHITECTURE.md lacks {}", missing.join(", "));
}

/// Imports that a folder or file must not have.
struct Rule {
    /// Paths from the root of the repository to which the rule applies.
    of: &'static [&'static str],
    /// Paths to which it does not apply.
    but: &'static [&'static str],
    /// Modules that must not be imported, and what is in them.
    not: &'static [&'static str],
    /// Modules in `not` that are allowed.
    except: &'static [&'static str],
    /// Number of imports that break the rule today. It may only fall.
    broken: usize,
    /// The rule as a row of the table in ARCHITECTURE.md.
    row: &'static str,
}

const RULE: Rule = Rule { of: &[], but: &[], not: &[], except: &[], broken: 0, row: "" };

const RULES: &[Rule] = &[
    Rule {
        of: &["proto/"],
        not: &[
            "crumple_worker",
            "crumple_contact",
            "crumple_fem",
            "crumple_math",
            "crumple_cases",
            "crumple",
            "crumple_verification",
        ],
        row: "| `proto/` | other crates of Crumple |",
        ..RULE
    },
    Rule {
        of: &["cases/"],
        not: &["crumple_worker", "crumple", "crumple_verification"],
        row: "| `cases/` | crates of Crumple except `proto` |",
        ..RULE
    },
    Rule {
        of: &["worker/"],
        not: &["crumple_cases", "crumple", "crumple_verification"],
        row: "| `worker/` | cases, master, verification |",
        ..RULE
    },
    Rule {
        of: &["worker/src/constraints/"],
        not: &[
            "crumple_worker::parallel",
            "crumple_worker::fem",
            "crumple_fem",
            "crumple_worker::engine",
        ],
        row: "| `worker/src/constraints/` | parallel, fem, engine |",
        ..RULE
    },
    Rule {
        of: &["worker/src/parallel/"],
        not: &["crumple_worker::constraints", "crumple_worker::engine", "crumple_worker::step"],
        row: "| `worker/src/parallel/` | constraints, engine, step |",
        ..RULE
    },
    Rule {
        of: &["master/src/input/"],
        not: &[
            "crumple::run",
            "crumple::results",
            "crumple::analysis",
            "crumple::serve",
            "crumple::client",
        ],
        row: "| `master/src/input/` | run, results, analysis, serve, client |",
        ..RULE
    },
    Rule {
        of: &["master/src/run/"],
        not: &["crumple::analysis", "crumple::serve", "crumple::client"],
        row: "| `master/src/run/` | analysis and so charts, serve, client |",
        ..RULE
    },
    Rule {
        of: &["master/src/results/"],
        not: &["crumple::run", "crumple::analysis", "crumple::serve", "crumple::client"],
        row: "| `master/src/results/` | run, analysis, serve, client |",
        ..RULE
    },
    Rule {
        of: &["master/src/analysis/"],
        not: &["crumple::serve", "crumple::client"],
        row: "| `master/src/analysis/` | serve, client |",
        ..RULE
    },
    Rule {
        of: &[""],
        but: &["master/src/serve/"],
        not: &["axum", "hyper", "rusqlite"],
        row: "| all but `master/src/serve/` | axum, hyper, rusqlite |",
        ..RULE
    },
    Rule {
        of: &[""],
        but: &["master/src/run/service/", "master/src/serve/"],
        not: &["tokio"],
        row: "| all but `master/src/run/service/` and `master/src/serve/` | tokio |",
        ..RULE
    },
    Rule {
        of: &[""],
        but: &["proto/src/transport/mpi.rs"],
        not: &["mpi"],
        row: "| all but `proto/src/transport/mpi.rs` | the MPI library |",
        ..RULE
    },
];

/// Returns the imports of the sources that break a rule.
fn broken(rule: &Rule, sources: &[Source]) -> Vec<String> {
    let starts = |path: &str, list: &[&str]| list.iter().any(|start| path.starts_with(start));
    let within = |import: &str, list: &[&str]| {
        list.iter()
            .any(|m| import.strip_prefix(m).is_some_and(|r| r.is_empty() || r.starts_with("::")))
    };
    let mut found = Vec::new();
    for source in sources.iter().filter(|s| starts(&s.path, rule.of) && !starts(&s.path, rule.but))
    {
        let imports = source.imports.iter().map(|path| path.join("::"));
        let bad = imports.filter(|i| within(i, rule.not) && !within(i, rule.except));
        found.extend(bad.map(|import| format!("{} imports {import}", source.path)));
    }
    found
}

#[test]
fn imports_keep_the_rules() {
    let (sources, text) = (sources(root()), text());
    let mut wrong = Vec::new();
    for rule in RULES {
        let found = broken(rule, &sources);
        let goal = rule.row.trim_end_matches(" |");
        let row = match rule.broken {
            0 => format!("{goal} | |"),
            n => format!("{goal} | {n} |"),
        };
        if !text.lines().any(|line| line == row) {
            wrong.push(format!("ARCHITECTURE.md has no row {row}"));
        }
        if found.len() != rule.broken {
            wrong.push(format!(
                "{}: {} imports break the rule, {} are known; remove new ones, and lower the \
                 number if there are fewer:\n  {}",
                rule.row,
                found.len(),
                rule.broken,
                found.join("\n  ")
            ));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_forbidden_import_breaks_its_rule() {
    let source = |path: &str, import: &str| Source {
        path: path.into(),
        module: Vec::new(),
        imports: vec![import.split("::").map(String::from).collect()],
        types: Vec::new(),
    };
    for (path, import, wanted) in [
        ("worker/src/parallel/ghosts.rs", "crumple_worker::step::step", 1),
        ("worker/src/parallel/ghosts.rs", "crumple_worker::steps", 0),
        ("worker/src/serve.rs", "tokio::select", 1),
        ("master/src/run/service/signals.rs", "tokio::select", 0),
        ("master/src/run/launch.rs", "crumple::serve::api", 1),
    ] {
        let source = [source(path, import)];
        let found: usize = RULES.iter().map(|rule| broken(rule, &source).len()).sum();
        assert_eq!(found, wanted, "{path} imports {import}");
    }
}

/// Returns the top-level modules of each crate that lie on circles of imports.
fn circles(sources: &[Source]) -> BTreeMap<String, Vec<BTreeSet<String>>> {
    type Edges = BTreeMap<String, BTreeSet<String>>;
    let mut crates: BTreeMap<String, Edges> = BTreeMap::new();
    for source in sources {
        let [name, module, ..] = &source.module[..] else { continue };
        let edges = crates.entry(name.clone()).or_default().entry(module.clone()).or_default();
        let own = source.imports.iter().filter(|path| path.len() > 1 && path[0] == *name);
        edges.extend(own.map(|path| path[1].clone()));
    }
    let reached = |edges: &Edges, from: &String| {
        let mut seen = BTreeSet::new();
        let mut open: Vec<&String> = edges[from].iter().collect();
        while let Some(module) = open.pop() {
            if let Some(next) = edges.get(module).filter(|_| seen.insert(module.clone())) {
                open.extend(next);
            }
        }
        seen
    };
    let mut found: BTreeMap<String, Vec<BTreeSet<String>>> = BTreeMap::new();
    for (name, edges) in &crates {
        let reach: BTreeMap<&String, BTreeSet<String>> =
            edges.keys().map(|module| (module, reached(edges, module))).collect();
        for (module, after) in &reach {
            let circle: BTreeSet<String> =
                after.iter().filter(|other| reach[other].contains(*module)).cloned().collect();
            let list = found.entry(name.clone()).or_default();
            if circle.len() > 1 && !list.contains(&circle) {
                list.push(circle);
            }
        }
    }
    found
}

#[test]
fn no_modules_import_each_other_in_a_circle() {
    let found = circles(&sources(root()));
    let found: Vec<_> = found.iter().filter(|(_, circles)| !circles.is_empty()).collect();
    assert!(found.is_empty(), "circles of modules: {found:?}");
}

/// Returns the names of types that two modules of the product define, with the files.
fn shared_names(sources: &[Source]) -> Vec<String> {
    let product = |source: &&Source| !source.path.starts_with("tests/");
    let mut files: BTreeMap<&str, BTreeSet<&str>> = BTreeMap::new();
    for source in sources.iter().filter(product) {
        for name in &source.types {
            files.entry(name).or_default().insert(&source.path);
        }
    }
    let shared = files.into_iter().filter(|(_, files)| files.len() > 1);
    shared.map(|(name, files)| format!("{name} in {files:?}")).collect()
}

#[test]
fn each_type_has_a_name_of_its_own() {
    let sources = sources(root());
    let types: usize = sources.iter().map(|source| source.types.len()).sum();
    assert!(types > 500, "only {types} types found: check that they start in the first column");
    let shared = shared_names(&sources);
    assert!(shared.is_empty(), "rename one by the thing it is:\n  {}", shared.join("\n  "));
}

#[test]
fn a_name_of_two_types_is_found() {
    let source = |path: &str| Source {
        path: path.into(),
        module: Vec::new(),
        imports: Vec::new(),
        types: vec!["Wall".into()],
    };
    let wall = source("worker/src/constraints/walls.rs");
    assert!(shared_names(&[wall, source("tests/src/tools.rs")]).is_empty());
    let two = [source("worker/src/constraints/walls.rs"), source("proto/src/wall.rs")];
    assert_eq!(shared_names(&two).len(), 1);
}
