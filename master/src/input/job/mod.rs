//! Converts a job file to a [`Model`] that can be decomposed and distributed, or to a list of all
//! its errors.
//!
//! 1. `tree.rs`: TOML with the place of every value, merged over the deck of the job if it has
//!    one (`deck`); `sets.rs` applies the command line
//! 2. `validate.rs`: unknown keys, types and missing keys, by the schema of
//!    [`crumple_proto::job::Job`]
//! 3. `mesh.rs`: the mesh and its checks; `numbering.rs`: new numbers for badly numbered meshes
//! 4. `resolve.rs`: ranges and defaults; `laws.rs`: materials and elements of the worker;
//!    `units.rs`
//! 5. `state.rs`: initial state of nodes and elements, `springs.rs`: stable step of springs;
//!    `loads.rs`, `walls.rs`: loads and walls; `histories.rs`: recorded quantities
//!
//! A stage that finds errors repairs the data as well as possible, so that the next stage can
//! continue. `report.rs` shows all errors at once. No input may cause a panic here; a panic is a
//! defect of the program.

mod contact;
mod histories;
pub mod laws;
mod loads;
mod mesh;
mod numbering;
pub mod report;
mod resolve;
mod restart;
mod rigid;
mod sets;
mod springs;
pub mod state;
pub mod subcycles;
mod ties;
pub mod tree;
mod units;
mod unused;
mod validate;
mod walls;

pub use laws::Blocks;
pub use numbering::Renumbered;
pub use report::{Located, Report, Sources, Spot};
pub use state::{ElementStart, NodeStart, fastest_wave};
pub use units::fit as units_fit;
pub use validate::nearest;

use crate::input::deck;
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Job, MeshSource};
use crumple_proto::mesh::{Mesh, free_faces};
use crumple_proto::partition::{ElementRecord, NodeRecord, Settings};
use crumple_proto::problem::Problem;
use crumple_proto::quality::{Quality, quality};
use crumple_worker::contact::diagnostics::initial_penetration::initial;
use report::{DeckSource, Source};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use tree::Node;
use validate::Findings;

/// Largest job or mesh file that is read [byte], because places in it have 32 bits.
const LARGEST_FILE: u64 = u32::MAX as u64;

/// A valid job: read, checked, with its mesh and all defaults.
pub struct Model {
    /// The job as written, with `--set`.
    pub job: Job,
    /// The mesh, sorted by id, without nodes that no element uses.
    pub mesh: Mesh,
    /// Settings of every worker. `field_dir` is empty until the run sets it.
    pub settings: Settings,
    /// Initial state of the nodes, in the order of the mesh.
    pub nodes: NodeStart,
    /// Initial state of the elements, in the order of the mesh.
    pub elements: ElementStart,
    /// Shape quality of the elements.
    pub quality: Quality,
    /// Data of the renumbering, if nodes and elements were renumbered.
    pub renumbered: Option<Renumbered>,
    /// The formulations of all parts.
    pub blocks: Blocks,
    /// Warnings. [`Model::show`] adds the line in the job. The run may add more warnings.
    pub warnings: Vec<Problem>,
    /// Requests of a deck, and the settings used for them.
    pub mapping: Vec<deck::Mapping>,
    /// Content of a deck that is not supported and was ignored.
    pub unsupported: Vec<String>,
    /// The job file that was read.
    pub path: PathBuf,
    sources: Sources,
}

/// Reads and checks a job: a folder that contains `job.toml`, or a `.toml` file. `sets` are the
/// `key=value` of the command line.
pub fn read(path: &Path, sets: &[String]) -> Result<Model, Report> {
    let path = job_file(path).map_err(Report::from_problem)?;
    if deck::is_deck(&path) {
        return read_tree(path.clone(), deck_job(&path), sets, Findings::default());
    }
    let text = load(&path).map_err(Report::from_problem)?;
    read_text(path, text, sets)
}

/// Reads and checks a job given as text. Paths in it are relative to the folder of `path`.
pub fn read_text(path: PathBuf, text: String, sets: &[String]) -> Result<Model, Report> {
    let (tree, errors) = match Node::parse(&text) {
        Ok(tree) => (tree, Vec::new()),
        Err(errors) => (Node::table(tree::Place::Whole), errors),
    };
    let job = Source { file: path.display().to_string(), text, tree };
    let mut findings = Findings::default();
    for (message, help, place) in errors {
        findings.add_faulty(Problem::error("", message, help), Some(place));
    }
    read_tree(path, job, sets, findings)
}

/// Returns a job that consists only of this deck.
fn deck_job(path: &Path) -> Source {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let whole = tree::Place::Whole;
    let entry = |node| tree::Entry { key: whole, node };
    let table = |key: &str, node| {
        let entries = [(key.to_string(), entry(node))].into_iter().collect();
        Node { kind: tree::NodeContent::Table(entries), place: whole }
    };
    let tree =
        table("mesh", table("deck", Node { kind: tree::NodeContent::String(name), place: whole }));
    Source { file: path.display().to_string(), text: String::new(), tree }
}

fn read_tree(
    path: PathBuf,
    job: Source,
    sets: &[String],
    mut findings: Findings,
) -> Result<Model, Report> {
    let mut sources = Sources { job, mesh: None, deck: None, sets: sets.to_vec() };
    if findings.any_error() {
        return Err(Report::new(findings.list, &sources));
    }
    let built = build(&mut sources, &path, sets, &mut findings);
    match built {
        Some(built) if !findings.any_error() => {
            let warnings =
                findings.list.into_iter().map(|f| f.problem).chain(built.warnings).collect();
            let mut model = Model {
                job: built.job,
                mesh: built.mesh,
                settings: built.settings,
                nodes: built.nodes,
                elements: built.elements,
                quality: built.quality,
                renumbered: built.renumbered,
                blocks: built.blocks,
                warnings,
                mapping: built.mapping,
                unsupported: built.unsupported,
                path,
                sources,
            };
            let (elements, nodes) = model.records();
            let initial = initial(&model.settings, &elements, &nodes);
            model.warnings.extend(laws::thinned(&model.settings, &initial));
            model.warnings.extend(laws::penetrations(&initial));
            Ok(model)
        }
        _ => Err(Report::new(findings.list, &sources)),
    }
}

struct Built {
    job: Job,
    mesh: Mesh,
    settings: Settings,
    nodes: NodeStart,
    elements: ElementStart,
    quality: Quality,
    renumbered: Option<Renumbered>,
    blocks: Blocks,
    warnings: Vec<Problem>,
    mapping: Vec<deck::Mapping>,
    unsupported: Vec<String>,
}

/// Reads the deck of a job and merges the job's own keys over it.
fn under_deck(sources: &mut Sources, path: &Path, findings: &mut Findings) -> Option<deck::Deck> {
    let mut tree = sources.job.tree.clone();
    if sources.sets.iter().any(|set| set.trim_start().starts_with("mesh.")) {
        sets::apply(&mut tree, &sources.sets, &mut Findings::default());
    }
    let mesh = tree.get("mesh")?;
    let tree::NodeContent::String(name) = &mesh.get("deck")?.kind else { return None };
    let words = |node: &Node| match &node.kind {
        tree::NodeContent::String(word) => Some(word.clone()),
        _ => None,
    };
    let leave_out = match mesh.get("leave_out").map(|n| &n.kind) {
        Some(tree::NodeContent::Array(items)) => items.iter().filter_map(words).collect(),
        _ => Vec::new(),
    };
    let allowed = matches!(
        mesh.get("allow_unsupported").map(|n| &n.kind),
        Some(tree::NodeContent::Boolean(true))
    );
    let file = path.parent().unwrap_or(Path::new("")).join(name);
    let mut deck = deck::read(&file, &leave_out, allowed);
    contact::from_list(&mut sources.job.tree);
    let own = std::mem::replace(&mut sources.job.tree, Node::table(tree::Place::Whole));
    let from_deck = std::mem::replace(&mut deck.tree, Node::table(tree::Place::Whole));
    sources.job.tree = deck::merge(from_deck, own);
    let (files, places) = (std::mem::take(&mut deck.files), std::mem::take(&mut deck.places));
    sources.deck = Some(DeckSource { files, places });
    findings.list.append(&mut deck.findings);
    Some(deck)
}

/// Runs all stages after parsing; returns `None` if there is too little data to continue.
fn build(
    sources: &mut Sources,
    path: &Path,
    sets: &[String],
    findings: &mut Findings,
) -> Option<Built> {
    let mut deck = under_deck(sources, path, findings);
    if let Some(deck) = deck.take_if(|_| findings.any_error()) {
        // References to a faulty card would be reported as errors. Of the remaining data, only
        // the mesh can be checked.
        if deck.whole && !deck.mesh.elements.is_empty() {
            mesh::check(mesh::Read::of_deck(deck.mesh, deck.lists), None, findings);
        }
        return None;
    }
    let (mapping, unsupported) = match &mut deck {
        Some(deck) => (std::mem::take(&mut deck.mapping), std::mem::take(&mut deck.unsupported)),
        None => Default::default(),
    };
    contact::from_list(&mut sources.job.tree);
    let mut tree = sources.job.tree.clone();
    sets::apply(&mut tree, sets, findings);
    // Places of problems are looked up in the tree as written, with `--set` but before repairs.
    sources.job.tree = tree.clone();
    validate::job(&mut tree, findings);
    let workers_given = tree.get("parallel").is_some_and(|p| p.get("workers").is_some());
    let mut job: Job = match tree.to_value().try_into() {
        Ok(job) => job,
        Err(error) => {
            findings.add(Problem::error("", error.message(), "correct the job"));
            return None;
        }
    };
    restart::add(&mut job, findings);
    let mesh = read_mesh(&job, path, deck, sources, findings);
    resolve::check(&job, workers_given, findings);

    let part_ids: Vec<u32> = job.part.iter().map(|p| p.id).collect();
    let parts_known = !findings.any_faulty_below("part");
    let mut mesh =
        mesh.map(|m| mesh::check(m, parts_known.then_some(part_ids.as_slice()), findings));
    let sound = mesh.as_mut().filter(|_| !findings.any_error());
    let renumbered = sound.and_then(|(mesh, axes)| numbering::renumber(mesh, axes, findings));
    let (mut mesh, axes) = mesh.unzip();
    let ties = mesh
        .as_mut()
        .filter(|_| !findings.any_error())
        .map(|mesh| ties::resolve(&job, mesh, findings))
        .unwrap_or_default();
    let figures = mesh.as_ref().and_then(quality);
    let (mut settings, order) = {
        let sides = figures.as_ref().map(|q| (q.min_side.value, q.median_side));
        resolve::settings(&job, sides, &mesh.as_ref().map(thickest).unwrap_or_default())
    };
    settings.axes = axes.unwrap_or_default();
    settings.with_own_offsets =
        mesh.as_ref().map_or(Vec::new(), |mesh| with_own_offsets(mesh, &settings));
    settings.ties = ties;
    let used = match &mesh {
        Some(mesh) => state::shapes_in_use(mesh, &settings),
        None => vec![laws::Used::default(); order.len()],
    };
    let blocks = Blocks::build(&settings, &order, &used, findings);
    let mut of_job = vec![laws::Used::default(); job.part.len()];
    order.iter().zip(&used).for_each(|(&place, used)| of_job[place] = *used);
    unused::check(&tree, &job, &of_job, findings);
    let mesh = mesh?;
    let sets = state::NodeSets::new(&mesh);
    let mut nodes = state::nodes(&job, &mesh, &sets, findings);
    let smallest = figures.as_ref().map_or(0.0, |q| q.min_side.value);
    settings.loads = loads::resolve(&job, &mesh, &sets, smallest, &mut nodes, findings);
    settings.walls = walls::resolve(&job, &sets, findings);
    settings.rigid = rigid::resolve(&job, &mesh, &settings, &sets, &mut nodes, findings);
    ties::join(&mut settings.ties, &mut settings.rigid, &sets, &mut nodes, findings);
    ties::lead(&settings.ties, &mut settings.loads.motions);
    settings.histories = histories::resolve(&job, &mesh, &settings, &sets, findings);
    settings.rotations =
        !settings.rigid.is_empty() || mesh.elements.iter().any(|e| e.shape.turns());
    if findings.any_error() {
        return None;
    }
    let mut elements = state::elements(&job, &mesh, &settings, &blocks, &nodes, findings);
    if let Some((_, dt)) = state::smallest(&elements.stable_dt).filter(|(_, dt)| dt.is_finite()) {
        walls::behind(&job, &settings, &mesh, &nodes, dt, findings);
    }
    if findings.any_error() {
        return None;
    }
    subcycles::divide(&job.time, &mesh, &mut settings, &mut elements, findings);
    let warnings = state::warnings(&job, &mesh, &settings, &elements, &nodes);
    Some(Built {
        quality: figures?,
        renumbered,
        job,
        mesh,
        settings,
        nodes,
        elements,
        blocks,
        warnings,
        mapping,
        unsupported,
    })
}

/// Returns the indices of the parts with shells of individual offset, ascending.
fn with_own_offsets(mesh: &Mesh, settings: &Settings) -> Vec<u32> {
    let own: BTreeSet<u32> =
        mesh.elements.iter().filter(|e| e.own.offset.is_some()).map(|e| e.part).collect();
    (0..).zip(&settings.parts).filter(|(_, p)| own.contains(&p.id)).map(|(i, _)| i).collect()
}

/// Returns the parts with shells of individual thickness, and the largest of these [length].
fn thickest(mesh: &Mesh) -> BTreeMap<u32, f64> {
    let mut thickest = BTreeMap::new();
    for e in mesh.elements.iter().filter(|e| e.own.thickness > 0.0) {
        let most: &mut f64 = thickest.entry(e.part).or_default();
        *most = most.max(e.own.thickness);
    }
    thickest
}

/// Reads the mesh from the source that the job names. Reports errors and returns `None` if there
/// is no mesh to check.
fn read_mesh(
    job: &Job,
    path: &Path,
    deck: Option<deck::Deck>,
    sources: &mut Sources,
    findings: &mut Findings,
) -> Option<mesh::Read> {
    let MeshSource {
        generator,
        file,
        nodes,
        shells,
        solids,
        beams,
        springs,
        node_sets,
        thicknesses,
        offsets,
        ..
    } = &job.mesh;
    let rows = ![
        nodes.is_empty(),
        shells.is_empty(),
        solids.is_empty(),
        beams.is_empty(),
        springs.is_empty(),
    ]
    .iter()
    .all(|&empty| empty);
    if findings.any_faulty_below("mesh") {
        return None;
    }
    if let Some(deck) = deck.filter(|_| generator.is_none() && file.is_none() && !rows) {
        let mut mesh = deck.mesh;
        let own = node_sets
            .iter()
            .map(|(name, ids)| (name.clone(), ids.iter().copied().map(NodeId).collect()));
        mesh.node_sets.extend(own);
        let read = mesh::Read::of_deck(mesh, deck.lists);
        return Some(mesh::with_own_sections(read, [thicknesses, offsets], findings));
    }
    match (generator, file, rows) {
        (Some(_), None, false) | (None, Some(_), false) if !node_sets.is_empty() => {
            let help = "remove them: a generator or a mesh file defines its own node sets";
            findings.add(Problem::error(
                "mesh.node_sets",
                "mesh.node_sets is for mesh.nodes or a deck only",
                help,
            ));
            None
        }
        (None, Some(_), false) if !thicknesses.is_empty() || !offsets.is_empty() => {
            let key = if thicknesses.is_empty() { "mesh.offsets" } else { "mesh.thicknesses" };
            let message = format!("{key} is for mesh.nodes, a generator or a deck only");
            findings.add(Problem::error(key, message, "write them in the mesh file"));
            None
        }
        (Some(generator), None, false) => {
            let read = mesh::generate(generator, job, findings)?;
            Some(mesh::with_own_sections(read, [thicknesses, offsets], findings))
        }
        (None, Some(file), false) => {
            let file = path.parent().unwrap_or(Path::new("")).join(file);
            read_mesh_file(&file, sources, findings)
        }
        (None, None, true) => mesh::from_rows(&job.mesh, findings),
        (None, None, false) => {
            let help = "give mesh.generator, mesh.file, mesh.deck, or mesh.nodes with mesh.shells \
                        or mesh.solids";
            findings.add(Problem::error("mesh", "the job has no mesh", help));
            None
        }
        _ => {
            let help = "give one of mesh.generator, mesh.file, mesh.deck, or mesh.nodes with \
                        mesh.shells or mesh.solids";
            findings.add(Problem::error("mesh", "the job has more than one mesh", help));
            None
        }
    }
}

fn read_mesh_file(
    file: &Path,
    sources: &mut Sources,
    findings: &mut Findings,
) -> Option<mesh::Read> {
    let text = match load(file) {
        Ok(text) => text,
        Err(problem) => {
            findings.add(Problem { path: "mesh.file".into(), ..problem });
            return None;
        }
    };
    let parsed = Node::parse(&text);
    let tree = parsed.as_ref().cloned().unwrap_or_else(|_| Node::table(tree::Place::Whole));
    sources.mesh = Some(Source { file: file.display().to_string(), text, tree });
    let mut tree = match parsed {
        Ok(tree) => tree,
        Err(errors) => {
            validate::mesh_file_syntax(errors, findings);
            return None;
        }
    };
    validate::mesh_file(&mut tree, findings);
    if findings.any_faulty_below("mesh") {
        return None;
    }
    match tree.to_value().try_into::<MeshSource>() {
        Ok(source) => mesh::from_rows(&source, findings),
        Err(error) => {
            findings.add(Problem::error("mesh", error.message(), "correct the mesh file"));
            None
        }
    }
}

/// Returns the job file for a path of the command line.
fn job_file(path: &Path) -> Result<PathBuf, Problem> {
    let shown = path.display();
    if path.is_dir() {
        let inside = path.join("job.toml");
        if inside.is_file() {
            return Ok(inside);
        }
        return Err(Problem::error(
            "",
            format!("the folder {shown} holds no job.toml"),
            "name a job file, or a folder with one",
        ));
    }
    let extension =
        path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    match extension.as_str() {
        _ if !path.exists() => {
            let help = "name a .toml job file, a .k deck, or a folder that holds job.toml";
            Err(Problem::error("", format!("there is no file {shown}"), help))
        }
        "toml" | "k" | "key" | "dyn" => Ok(path.to_path_buf()),
        _ => Err(Problem::error(
            "",
            format!("{shown} is not a .toml file"),
            "name a .toml file, a .k, .key or .dyn deck, or a folder that holds job.toml",
        )),
    }
}

fn load(path: &Path) -> Result<String, Problem> {
    let shown = path.display();
    let cannot = |error: std::io::Error| {
        Problem::error(
            "",
            format!("{shown} cannot be read: {error}"),
            "check its name and permissions",
        )
    };
    let length = std::fs::metadata(path).map_err(cannot)?.len();
    if length > LARGEST_FILE {
        return Err(Problem::error("", format!("{shown} is larger than 4 GiB"), "split the model"));
    }
    let bytes = std::fs::read(path).map_err(cannot)?;
    String::from_utf8(bytes).map_err(|error| {
        let good = error.utf8_error().valid_up_to();
        let line = 1 + error.as_bytes()[..good].iter().filter(|&&b| b == b'\n').count();
        Problem::error("", format!("{shown}:{line}: not UTF-8 text"), "save the file as UTF-8")
    })
}

impl Model {
    /// Returns a problem with its line in the job.
    pub fn show(&self, problem: &Problem) -> Located {
        self.sources.locate(problem)
    }

    /// Returns the records for the distribution: elements and nodes by ascending id.
    pub fn records(&self) -> (Vec<ElementRecord>, Vec<NodeRecord>) {
        let free = free_faces(&self.mesh.elements);
        let element = |(i, e): (usize, &crumple_proto::mesh::MeshElement)| ElementRecord {
            id: e.id,
            part: self.elements.part[i],
            shape: e.shape,
            nodes: e.nodes,
            free_faces: free[i],
            failed: false,
            mass_factor: self.elements.mass_factor[i],
            share: self.elements.share[i],
            slow: self.elements.slow.get(i).is_some_and(|&slow| slow),
            own: e.own,
            stable_dt: self.elements.massless_dt(i),
        };
        let node = |(i, n): (usize, &crumple_proto::mesh::MeshNode)| NodeRecord {
            id: n.id,
            fixed: self.nodes.fixed[i],
            x0: n.x,
            x: n.x,
            seen: n.x,
            v: self.nodes.velocity[i],
            w: self.nodes.spin[i],
            mass: self.nodes.added_mass[i],
            inertia: 0.0,
        };
        (
            self.mesh.elements.iter().enumerate().map(element).collect(),
            self.mesh.nodes.iter().enumerate().map(node).collect(),
        )
    }

    /// Frees the data that only the distribution needs: the mesh, and the initial state of its
    /// nodes and elements.
    pub fn forget_mesh(&mut self) {
        self.mesh = Mesh::default();
        self.nodes = NodeStart::default();
        self.elements = ElementStart::default();
    }

    /// Returns the first time step, which is safety times the smallest stable step and at most
    /// `dt_max` [time], and the index of the element that controls it.
    pub fn first_dt(&self) -> (f64, usize) {
        let (at, dt) =
            state::smallest(&self.elements.stable_dt).expect("a valid model has elements");
        let most = if self.settings.dt_max > 0.0 { self.settings.dt_max } else { f64::INFINITY };
        ((self.settings.safety * dt).min(most), at)
    }

    /// Returns the mass of all elements without mass scaling [mass].
    pub fn structure_mass(&self) -> f64 {
        self.elements.mass.iter().sum()
    }

    /// Returns the mass added by mass scaling to a given step [mass].
    pub fn scaled_mass(&self) -> f64 {
        state::scaled_mass(&self.elements)
    }

    /// Returns the mass of all `[[mass]]` [mass].
    pub fn lumped_mass(&self) -> f64 {
        self.nodes.added_mass.iter().sum()
    }

    /// Returns the total mass, with mass scaling and `[[mass]]` [mass].
    pub fn total_mass(&self) -> f64 {
        self.structure_mass() + self.scaled_mass() + self.lumped_mass()
    }

    /// Returns the number of workers: as requested by the command line or mpirun, otherwise as in
    /// the job, otherwise at most `cores`. Returns an error if it is 0 or larger than the number
    /// of elements.
    pub fn workers(&self, asked: Option<usize>, cores: usize) -> Result<usize, Report> {
        let elements = self.mesh.elements.len();
        let from_job = Some(self.job.parallel.workers).filter(|&n| n > 0);
        let (count, path) = match (asked, from_job) {
            (Some(n), _) => (n, ""),
            (None, Some(n)) => (n, "parallel.workers"),
            (None, None) => return Ok(cores.clamp(1, elements)),
        };
        let problem = match count {
            0 => Problem::error(
                path,
                "0 workers cannot run a job",
                "give at least 1, or omit the number for one per core",
            ),
            n if n > elements => {
                let message =
                    format!("{n} workers are more than the {elements} elements of the job");
                Problem::error(path, message, format!("give at most {elements}"))
            }
            n => return Ok(n),
        };
        match path {
            "" => Err(Report::from_problem(problem)),
            _ => Err(Report { problems: vec![self.show(&problem)] }),
        }
    }
}
