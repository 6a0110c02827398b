//! Jobs that include jobs: `include = ["parts.toml"]`.
//!
//! Included files are merged as a deck is: tables key by key, entries of lists by their `id` or
//! `name`, further entries are added. A later file of the list wins over an earlier one, and a file
//! wins over those that it includes. A file that is included several times is read once.

use super::contact;
use super::files::load;
use super::tree::{Entry, Node, NodeContent, Place};
use super::validate::JobProblems;
use crate::input::deck;
use crumple_proto::problem::Problem;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

const KEY: &str = "include";
/// Keys of which each is a whole mesh.
const MESH_SOURCES: [&str; 5] = ["deck", "exodus", "file", "generator", "nodes"];
/// Largest number of included files. Each may include the next one.
const MOST_FILES: usize = 200;

/// A job file that another one includes.
#[derive(Debug)]
pub(crate) struct IncludedFile {
    /// Its path.
    pub path: PathBuf,
    /// Its text.
    pub text: String,
}

/// Reads the files that a job includes and merges its own keys over theirs. Returns the merged
/// tree, and the files by the numbers in its places.
pub fn merge(tree: Node, job: &Path, findings: &mut JobProblems) -> (Node, Vec<IncludedFile>) {
    let mut reader = IncludeReader { files: Vec::new(), open: vec![real(job)], findings };
    let folder = job.parent().unwrap_or(Path::new(""));
    let tree = reader.expand(tree, folder, Path::new(""));
    (tree, reader.files)
}

/// Returns a path without links, if the file exists.
fn real(path: &Path) -> PathBuf {
    std::fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf())
}

struct IncludeReader<'f> {
    files: Vec<IncludedFile>,
    /// The job and the files that include each other, down to the one that is read.
    open: Vec<PathBuf>,
    findings: &'f mut JobProblems,
}

impl IncludeReader<'_> {
    /// Merges a tree over the files that it includes. `folder` is that of its file, `below` the
    /// same from the folder of the job.
    fn expand(&mut self, mut tree: Node, folder: &Path, below: &Path) -> Node {
        let Some(names) = take(&mut tree) else { return tree };
        let mut base = Node::table(tree.place);
        for (name, place) in names {
            if let Some(included) = self.read(&name, place, folder, below) {
                self.warn_of_mesh(&base, &included);
                base = deck::merge(base, included);
            }
        }
        self.warn_of_mesh(&base, &tree);
        deck::merge(base, tree)
    }

    /// Warns if the mesh of a file gives way to that of a file that is merged over it.
    fn warn_of_mesh(&mut self, base: &Node, over: &Node) {
        fn source<'t>(tree: &'t Node, key: &str) -> Option<&'t Node> {
            tree.get("mesh")?.get(key)
        }
        let named = |key: &str, node: &Node| match &node.kind {
            NodeContent::String(name) => format!("mesh.{key} = \"{name}\""),
            _ => format!("mesh.{key}"),
        };
        for key in MESH_SOURCES {
            let Some(old) = source(base, key) else { continue };
            // A mesh takes the place of that of a deck. Other sources together are an error.
            let others = MESH_SOURCES.iter().filter(|_| key == "deck").copied();
            let keys = std::iter::once(key).chain(others);
            let mut news = keys.filter_map(|key| Some((key, source(over, key)?)));
            let Some((winner, new)) = news.next() else { continue };
            if winner == key && old.to_value() == new.to_value() {
                continue;
            }
            let file = match old.place {
                Place::Included { file, .. } => self.files.get(file as usize),
                _ => None,
            };
            let file = file.map_or(String::new(), |file| format!(" of {}", file.path.display()));
            let message = format!(
                "{}{file} is replaced by {}: a job has one [mesh]",
                named(key, old),
                named(winner, new)
            );
            let help = match [key, winner] {
                ["deck", _] => "keep mesh.deck, and add the other file by a [[mesh.add]]",
                ["generator", "generator"] | [_, "deck"] => "remove the mesh that is replaced",
                _ => {
                    "to have both meshes, name a file of them in a [[mesh.add]]; otherwise remove \
                     the mesh that is replaced"
                }
            };
            self.findings.add(Problem::warning(format!("mesh.{winner}"), message, help));
        }
    }

    /// Reads an included file, with those that it includes. Returns `None` if it has an error or
    /// was read before.
    fn read(&mut self, name: &str, place: Place, folder: &Path, below: &Path) -> Option<Node> {
        let path = folder.join(name);
        let shown = path.display().to_string();
        let mut error = |message: String, help: String| {
            self.findings.add_faulty(Problem::error(KEY, message, help), Some(place));
        };
        if path.extension().is_none_or(|extension| extension != "toml") {
            let help = "include job files in TOML; a deck is `mesh.deck`, a mesh `mesh.file`";
            error(format!("{shown} is not a .toml file"), help.into());
            return None;
        }
        let real = real(&path);
        if let Some(first) = self.open.iter().position(|open| *open == real) {
            let chain = self.open[first..].iter().chain([&real]).map(|p| p.display().to_string());
            let message =
                format!("{shown} includes itself: {}", chain.collect::<Vec<_>>().join(" > "));
            error(message, "remove one of these `include`".into());
            return None;
        }
        if self.files.iter().any(|file| self::real(&file.path) == real) {
            return None;
        }
        if self.files.len() == MOST_FILES {
            let message = format!("{shown} is one of more than {MOST_FILES} included files");
            error(message, "put the contents of several files into one".into());
            return None;
        }
        let text = match load(&path) {
            Ok(text) => text,
            Err(problem) => {
                error(problem.message, problem.help);
                return None;
            }
        };
        let number = self.files.len() as u32;
        let parsed = Node::parse(&text);
        self.files.push(IncludedFile { path: path.clone(), text });
        let mut tree = match parsed {
            Ok(tree) => tree,
            Err(errors) => {
                for (message, help, place) in errors {
                    let place = place.of_included(number);
                    self.findings.add_faulty(Problem::error(KEY, message, help), Some(place));
                }
                return None;
            }
        };
        tree.move_to_included(number);
        contact::from_list(&mut tree);
        let parent = Path::new(name).parent().unwrap_or(Path::new(""));
        let below = below.join(parent);
        rebase(&mut tree, &below);
        self.open.push(real);
        let tree = self.expand(tree, &folder.join(parent), &below);
        self.open.pop();
        Some(tree)
    }
}

/// Removes the list of included files from a tree and returns it. A value that is no list of texts
/// stays, and the check against the schema reports it.
fn take(tree: &mut Node) -> Option<Vec<(String, Place)>> {
    let NodeContent::Table(entries) = &mut tree.kind else { return None };
    let NodeContent::Array(items) = &entries.get(KEY)?.node.kind else { return None };
    let name = |item: &Node| match &item.kind {
        NodeContent::String(name) => Some((name.clone(), item.place)),
        _ => None,
    };
    let names: Vec<(String, Place)> = items.iter().map(name).collect::<Option<_>>()?;
    entries.remove(KEY);
    Some(names)
}

/// Makes the paths of meshes relative to the folder of the job.
fn rebase(tree: &mut Node, below: &Path) {
    let NodeContent::Table(entries) = &mut tree.kind else { return };
    let mesh = entries.get_mut("mesh").map(|entry| &mut entry.node.kind);
    let Some(NodeContent::Table(mesh)) = mesh else { return };
    for key in ["file", "deck", "exodus"] {
        rebase_key(mesh, key, below);
    }
    let added = mesh.get_mut("add").map(|entry| &mut entry.node.kind);
    let Some(NodeContent::Array(added)) = added else { return };
    for added in added {
        if let NodeContent::Table(added) = &mut added.kind {
            rebase_key(added, "file", below);
        }
    }
}

/// Makes the path of a file relative to the folder of the job.
fn rebase_key(table: &mut BTreeMap<String, Entry>, key: &str, below: &Path) {
    if let Some(Entry { node: Node { kind: NodeContent::String(name), .. }, .. }) =
        table.get_mut(key)
    {
        *name = below.join(&*name).to_string_lossy().into_owned();
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Model, Report, read};
    use std::fs;
    use std::path::Path;

    const MESH: &str = "[mesh]\nfile = \"mesh.toml\"\n";
    const NODES: &str = "nodes = [[1, 0.0, 0.0, 0.0], [2, 1.0, 0.0, 0.0], [3, 0.0, 1.0, 0.0]]\n\
                         shells = [[1, 1, 1, 2, 3]]\nnode_sets = { tip = [3] }\n";
    const STEEL: &str = "[[material]]\nname = \"steel\"\nlaw = \"elastic\"\ndensity = 7.85e-6\n\
                         youngs_modulus = 207.0\npoisson = 0.3\n";
    const PART: &str = "[[part]]\nid = 1\nname = \"a\"\nmaterial = \"steel\"\nthickness = 0.1\n\
                        [[fix]]\nnodes = \"tip\"\ndofs = [\"x\"]\n";

    fn write(folder: &Path, files: &[(&str, &str)]) -> Result<Model, Report> {
        for (name, text) in files {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, text).unwrap();
        }
        read(&folder.join("job.toml"), &[])
    }

    fn said(files: &[(&str, &str)]) -> String {
        let folder = tempfile::tempdir().unwrap();
        write(folder.path(), files).map(|_| ()).unwrap_err().to_string()
    }

    /// Keys of the job win, entries of lists are merged by id and name or added, a file within a
    /// folder finds its mesh there, and a file that two others include is read once.
    #[test]
    fn files_are_merged_in_order() {
        let folder = tempfile::tempdir().unwrap();
        let part = format!("include = [\"../steel.toml\"]\n{PART}");
        let files = [
            (
                "job.toml",
                "include = [\"steel.toml\", \"model/mesh.part.toml\", \"model/part.toml\"]\n\
                 end_time = 2.0\n[[part]]\nid = 1\nthickness = 0.3\n\
                 [[fix]]\nnodes = \"tip\"\ndofs = [\"y\"]\n",
            ),
            ("steel.toml", &format!("end_time = 5.0\n[time]\nsafety = 0.7\n{STEEL}")),
            ("model/mesh.part.toml", &format!("[time]\nsafety = 0.6\n{MESH}")),
            ("model/mesh.toml", NODES),
            ("model/part.toml", &part),
        ];
        let model = write(folder.path(), &files).unwrap_or_else(|report| panic!("{report}"));
        let job = &model.job;
        assert_eq!((job.end_time, job.time.safety), (2.0, 0.6));
        assert_eq!((job.part.len(), job.part[0].thickness, &*job.part[0].name), (1, 0.3, "a"));
        assert_eq!((job.material.len(), job.fix.len()), (1, 2));
        assert_eq!(model.nodes.fixed[2] & 0b11, 0b11, "both fix the node");
        let read: Vec<_> = model.files();
        let names = ["job.toml", "steel.toml", "model/mesh.part.toml", "model/part.toml"];
        for name in names.iter().chain(&["model/mesh.toml"]) {
            let one = |path: &&std::path::PathBuf| path.ends_with(name);
            assert_eq!(read.iter().filter(one).count(), 1, "{name}: {read:?}");
        }
    }

    /// Errors name the file that has them and its line.
    #[test]
    fn errors_are_placed_in_the_included_file() {
        let job = ("job.toml", "include = [\"a.toml\"]\nend_time = 1.0\n");
        let files =
            [job, ("a.toml", &format!("{MESH}{STEEL}{PART}lenght = 3\n")), ("mesh.toml", NODES)];
        let report = said(&files);
        assert!(
            report.contains("a.toml:17:1") && report.contains("unknown key `lenght`"),
            "{report}"
        );
        let wrong = format!("{MESH}{STEEL}{PART}").replace("poisson = 0.3", "poisson = 0.8");
        let report = said(&[job, ("a.toml", &wrong), ("mesh.toml", NODES)]);
        assert!(report.contains("a.toml:8:1") && report.contains("poisson = 0.8"), "{report}");
        let report = said(&[job, ("a.toml", "end_time = 1\nend_time = 2\n")]);
        assert!(report.contains("a.toml:2:1"), "{report}");
    }

    #[test]
    fn files_that_cannot_be_included_are_errors() {
        let job = |list: &str| format!("include = {list}\nend_time = 1.0\n");
        for (list, said_too) in [
            ("[\"gone.toml\"]", "there is no file"),
            ("[\"mesh.k\"]", "is not a .toml file"),
            ("[\"job.toml\"]", "includes itself"),
            ("[\"a.toml\"]", "b.toml includes itself"),
            ("[3]", "an entry of `include` has to be text in quotes"),
            ("\"a.toml\"", "`include` has to be a list"),
        ] {
            let (a, b) = ("include = [\"b.toml\"]\n", "include = [\"a.toml\", \"b.toml\"]\n");
            let report = said(&[("job.toml", &job(list)), ("a.toml", a), ("b.toml", b)]);
            assert!(report.contains(said_too), "{list}: {report}");
            assert!(report.contains(".toml:1:"), "the line of the include: {report}");
        }
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("job.toml"), job("[]")).unwrap();
        let set = ["include=[\"a.toml\"]".to_string()];
        let report = read(&folder.path().join("job.toml"), &set).map(|_| ()).unwrap_err();
        assert!(report.to_string().contains("--set cannot include files"), "{report}");
    }
}
