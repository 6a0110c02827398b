//! Converts a job file to a [`Model`] that can be decomposed and distributed, or to a list of all
//! its errors.
//!
//! 1. `tree.rs`: TOML with the place of every value, merged over the files that the job includes
//!    (`include.rs`) and over its deck (`deck`); `sets.rs` applies the command line, `library.rs`
//!    the library of materials; `inline_sets.rs` moves rules of node sets to `[[set]]`;
//!    `part_names.rs` replaces names in lists of parts by ids
//! 2. `validate.rs`: unknown keys, types and missing keys, by the schema of
//!    [`crumple_proto::job::Job`]
//! 3. `mesh.rs`: the mesh, meshes that are added to it, and its checks; `node_sets/`: sets by rule;
//!    `numbering.rs`: new numbers for badly numbered meshes
//! 4. `resolve.rs`: ranges and defaults; `laws.rs`: materials and elements of the worker;
//!    `units.rs`
//! 5. `state.rs`: initial state of nodes and elements, `springs.rs`: stable step of springs;
//!    `loads.rs`, `airbags.rs`, `belts`, `walls.rs`: loads, airbags, seat belts and walls;
//!    `histories.rs`: recorded quantities
//!
//! A stage that finds errors repairs the data as well as possible, so that the next stage can
//! continue. `report.rs` shows all errors at once. No input may cause a panic here; a panic is a
//! defect of the program.

mod adaptivity;
mod airbags;
pub mod axes;
mod belts;
pub mod centre;
mod contact;
mod failure_groups;
mod files;
pub mod histories;
mod include;
mod initial_stresses;
pub mod inline_sets;
mod joints;
pub mod laws;
mod layers;
pub mod library;
mod loads;
mod mesh;
mod model;
pub mod node_sets;
mod non_reflecting;
mod numbering;
mod part_names;
mod particles;
mod placeholders;
pub mod report;
mod requirements;
mod resolve;
mod restart;
mod rigid;
mod search_skin;
mod separate_bodies;
mod sets;
mod springs;
pub mod state;
pub mod subcycles;
mod ties;
pub mod tree;
pub mod units;
mod unused;
mod validate;
mod walls;
mod warnings;

pub use laws::BuiltElements;
pub(in crate::input) use loads::outer_faces;
pub use mesh::added::AddedMesh;
pub use model::Model;
pub use numbering::Renumbered;
pub use report::{Located, Report, SourceFiles, Spot};
pub use state::{ElementStart, NodeStart, fastest_wave};
pub use units::{fit as units_fit, modulus_fits, steel_in};
pub use validate::nearest;

use crate::input::deck;
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Job, Part};
use crumple_proto::mesh::{Mesh, MeshElement, Shape};
use crumple_proto::partition::Settings;
use crumple_proto::problem::Problem;
use crumple_proto::quality::{Quality, quality};
use crumple_worker::contact::diagnostics::initial_penetration::initial;
use crumple_worker::fem::elements::COHESIVE;
use crumple_worker::math::threads;
use crumple_worker::parallel::decomposition::BoxDecomposition;
use files::{job_file, load, read_mesh};
use report::{DeckSource, SourceFile};
use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::path::{Path, PathBuf};
use ties::ResolvedTies;
use tree::Node;
use validate::JobProblems;

/// Reads and checks a job: a folder that contains `job.toml`, or a `.toml` file. `sets` are the
/// `key=value` of the command line.
pub fn read(path: &Path, sets: &[String]) -> Result<Model, Report> {
    let path = job_file(path).map_err(Report::from_problem)?;
    if deck::is_deck(&path) {
        return read_tree(path.clone(), deck_job(&path), sets, JobProblems::default());
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
    let job = SourceFile { file: path.display().to_string(), text, tree };
    let mut findings = JobProblems::default();
    for (message, help, place) in errors {
        findings.add_faulty(Problem::error("", message, help), Some(place));
    }
    read_tree(path, job, sets, findings)
}

/// Returns the problems of the keys of a job given as text: unknown and missing keys, types and
/// invalid numbers. Nothing else is checked, and no file is read: if the job includes others or
/// names a deck, keys that it lacks may be there, and are no problem.
pub fn check_keys(text: &str) -> Vec<Problem> {
    let mut tree = match Node::parse(text) {
        Ok(tree) => tree,
        Err(errors) => {
            let problem = |(message, help, _)| Problem::error("", message, help);
            return errors.into_iter().map(problem).collect();
        }
    };
    let mut findings = JobProblems::default();
    let is_part = tree.get("include").is_some()
        || tree.get("mesh").is_some_and(|mesh| mesh.get("deck").is_some());
    contact::from_list(&mut tree);
    library::expand(&mut tree, &mut findings);
    inline_sets::hoist(&mut tree);
    validate::job(&mut tree, &mut findings);
    let is_fault = |problem: &Problem| !(is_part && validate::is_missing_key(problem));
    findings.list.into_iter().map(|found| found.problem).filter(is_fault).collect()
}

/// Returns a job that consists only of this deck.
fn deck_job(path: &Path) -> SourceFile {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let whole = tree::Place::Whole;
    let entry = |node| tree::Entry { key: whole, node };
    let table = |key: &str, node| {
        let entries = [(key.to_string(), entry(node))].into_iter().collect();
        Node { kind: tree::NodeContent::Table(entries), place: whole }
    };
    let tree =
        table("mesh", table("deck", Node { kind: tree::NodeContent::String(name), place: whole }));
    SourceFile { file: path.display().to_string(), text: String::new(), tree }
}

fn read_tree(
    path: PathBuf,
    mut job: SourceFile,
    sets: &[String],
    mut findings: JobProblems,
) -> Result<Model, Report> {
    let own = std::mem::replace(&mut job.tree, Node::table(tree::Place::Whole));
    let (merged, included) = include::merge(own, &path, &mut findings);
    job.tree = merged;
    let mut sources = SourceFiles {
        job,
        included,
        mesh: None,
        mesh_rows: Vec::new(),
        added: Vec::new(),
        mesh_files: Vec::new(),
        deck: None,
        sets: sets.to_vec(),
    };
    if findings.any_error() {
        return Err(Report::new(findings.list, &sources));
    }
    let built = build(&mut sources, &path, sets, &mut findings);
    match built {
        Some(built) if !findings.any_error() => {
            let warnings =
                findings.list.into_iter().map(|f| f.problem).chain(built.warnings).collect();
            let mut model = Model {
                decomposition: BoxDecomposition::new(&built.job.parallel),
                job: built.job,
                mesh: built.mesh,
                settings: built.settings,
                nodes: built.nodes,
                elements: built.elements,
                quality: built.quality,
                renumbered: built.renumbered,
                given: built.given,
                blocks: built.blocks,
                warnings,
                mapping: built.mapping,
                unsupported: built.unsupported,
                path,
                sources,
            };
            let (elements, nodes) = model.records();
            let cores = std::thread::available_parallelism().map_or(1, usize::from);
            let initial = threads::with(cores, || initial(&model.settings, &elements, &nodes));
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
    given: BTreeMap<NodeId, [f64; 3]>,
    blocks: BuiltElements,
    warnings: Vec<Problem>,
    mapping: Vec<deck::Mapping>,
    unsupported: Vec<String>,
}

/// Reads the deck of a job and merges the job's own keys over it.
fn under_deck(
    sources: &mut SourceFiles,
    path: &Path,
    findings: &mut JobProblems,
) -> Option<deck::Deck> {
    let mut tree = sources.job.tree.clone();
    if sources.sets.iter().any(|set| set.trim_start().starts_with("mesh.")) {
        sets::apply(&mut tree, &sources.sets, &mut JobProblems::default());
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
    let allow_unsupported = matches!(
        mesh.get("allow_unsupported").map(|n| &n.kind),
        Some(tree::NodeContent::Boolean(true))
    );
    let case = match mesh.get("case").map(|n| &n.kind) {
        Some(tree::NodeContent::Integer(case)) => u64::try_from(*case).ok(),
        _ => None,
    };
    let file = path.parent().unwrap_or(Path::new("")).join(name);
    let choice = deck::DeckChoice { leave_out, allow_unsupported, case };
    let mut deck = deck::read(&file, &choice);
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
    sources: &mut SourceFiles,
    path: &Path,
    sets: &[String],
    findings: &mut JobProblems,
) -> Option<Built> {
    let mut deck = under_deck(sources, path, findings);
    if let Some(deck) = deck.take_if(|_| findings.any_error()) {
        // References to a faulty card would be reported as errors. Of the remaining data, only
        // the mesh can be checked.
        if deck.whole && !deck.mesh.elements.is_empty() {
            let read = mesh::PlacedMesh::of_deck(deck.mesh, deck.lists, deck.stand_ins);
            mesh::check(read, None, findings);
        }
        return None;
    }
    let (mapping, mut unsupported) = match &mut deck {
        Some(deck) => (std::mem::take(&mut deck.mapping), std::mem::take(&mut deck.unsupported)),
        None => Default::default(),
    };
    let (tree, job) = read_keys(sources, sets, findings)?;
    let read = read_mesh(&job, path, deck, sources, findings);
    unsupported.extend(sources.left_out().map(|row| format!("{} {}", row.count, row.what)));
    let workers_given = tree.get("parallel").is_some_and(|p| p.get("workers").is_some());
    resolve::check(&job, workers_given, findings);
    let mut checked = check_mesh(&job, read, findings);
    let (mut settings, blocks) = choose_laws(&tree, &job, &mut checked, findings);
    let CheckedMesh { mesh, renumbered, quality, ties, .. } = checked;
    let (mesh, given) = (mesh?, ties.given);
    let smallest = quality.as_ref().map_or(0.0, |q| q.min_side.value);
    let nodes = constrain(&job, &mesh, &mut settings, smallest, findings);
    settings.initial = initial_stresses::resolve(&job, &mesh, &settings, &blocks, findings);
    settings.failure_groups = failure_groups::resolve(&job, &mesh, (&settings, &blocks), findings);
    particles::check(&job, &mesh, &settings, findings);
    if findings.any_error() {
        return None;
    }
    let mut elements = state::elements(&job, &mesh, &settings, &blocks, &nodes, findings);
    if let Some((_, dt)) = state::smallest(&elements.stable_dt).filter(|(_, dt)| dt.is_finite()) {
        walls::behind(&job, &settings, &mesh, &nodes, dt, findings);
    }
    airbags::check_masses(&mesh, &settings.loads.airbags, (&elements, &nodes), findings);
    if findings.any_error() {
        return None;
    }
    subcycles::divide(&job.time, &mesh, &mut settings, &mut elements, findings);
    settings.adaptivity = adaptivity::resolve(&job, &mesh, &settings, findings);
    if findings.any_error() {
        return None;
    }
    let gives_skin = job.contact.as_ref().is_some_and(|contact| contact.skin > 0.0);
    if let Some(quality) = quality.as_ref().filter(|_| !gives_skin) {
        search_skin::widen(&mut settings, &mesh, &nodes, &elements, quality.median_side);
    }
    loads::share_masses(&job, &mesh, &mut settings, (&elements, &nodes), findings);
    let mut warnings = placeholders::check(&job);
    warnings.extend(warnings::of_model(&job, &mesh, &settings, &elements, &nodes));
    Some(Built {
        quality: quality?,
        renumbered,
        given,
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

/// Applies the command line, checks all keys and returns them, as a tree and as a job.
fn read_keys(
    sources: &mut SourceFiles,
    sets: &[String],
    findings: &mut JobProblems,
) -> Option<(Node, Job)> {
    contact::from_list(&mut sources.job.tree);
    let mut tree = sources.job.tree.clone();
    sets::apply(&mut tree, sets, findings);
    library::expand(&mut tree, findings);
    inline_sets::hoist(&mut tree);
    // Places of problems are looked up in the tree as written, with `--set` but before repairs.
    sources.job.tree = tree.clone();
    part_names::replace(&mut tree, findings);
    validate::job(&mut tree, findings);
    let mut job: Job = match tree.to_value().try_into() {
        Ok(job) => job,
        Err(error) => {
            findings.add(Problem::error("", error.message(), "correct the job"));
            return None;
        }
    };
    layers::resolve(&mut job, findings);
    restart::add(&mut job, findings);
    Some((tree, job))
}

/// The mesh after its checks, if there is one.
struct CheckedMesh {
    mesh: Option<Mesh>,
    axes: mesh::Axes,
    renumbered: Option<Renumbered>,
    ties: ResolvedTies,
    quality: Option<Quality>,
}

/// Checks the mesh, adds sets by rule, renumbers the mesh if that is useful, and moves tied nodes
/// onto their surfaces.
fn check_mesh(
    job: &Job,
    read: Option<mesh::PlacedMesh>,
    findings: &mut JobProblems,
) -> CheckedMesh {
    let part_ids: Vec<u32> = job.part.iter().map(|p| p.id).collect();
    let parts_known = !findings.any_faulty_below("part");
    let of_part = |p: &&Part| p.element.as_deref() == Some(COHESIVE);
    let cohesive: Vec<u32> = job.part.iter().filter(of_part).map(|p| p.id).collect();
    let read = read.map(|m| m.with_cohesive(&cohesive));
    let mut mesh =
        read.map(|m| mesh::check(m, parts_known.then_some(part_ids.as_slice()), findings));
    if let Some((mesh, _)) = mesh.as_mut().filter(|_| !findings.any_error()) {
        node_sets::resolve(job, mesh, findings);
    }
    let sound = mesh.as_mut().filter(|_| !findings.any_error());
    let renumbered = sound.and_then(|(mesh, axes)| numbering::renumber(mesh, axes, findings));
    let (mut mesh, axes) = mesh.unzip();
    let ties = mesh
        .as_mut()
        .filter(|_| !findings.any_error())
        .map(|mesh| ties::resolve(job, mesh, findings))
        .unwrap_or_default();
    let quality = mesh.as_ref().and_then(quality);
    CheckedMesh { mesh, axes: axes.unwrap_or_default(), renumbered, ties, quality }
}

/// Chooses the element formulations and laws of all parts, and reports keys that they do not use.
fn choose_laws(
    tree: &Node,
    job: &Job,
    checked: &mut CheckedMesh,
    findings: &mut JobProblems,
) -> (Settings, BuiltElements) {
    let sides = checked.quality.as_ref().map(|q| (q.min_side.value, q.median_side));
    let mesh = checked.mesh.as_ref();
    let (mut settings, order) =
        resolve::settings(job, sides, &mesh.map(thickest).unwrap_or_default());
    settings.axes = std::mem::take(&mut checked.axes);
    settings.with_own_offsets = mesh.map_or(Vec::new(), |mesh| with_own_offsets(mesh, &settings));
    settings.ties = std::mem::take(&mut checked.ties.ties);
    let used = match mesh {
        Some(mesh) => state::shapes_in_use(mesh, &settings),
        None => vec![laws::Used::default(); order.len()],
    };
    let blocks = BuiltElements::build(&settings, &order, &used, findings);
    let mut of_job = vec![laws::Used::default(); job.part.len()];
    order.iter().zip(&used).for_each(|(&place, used)| of_job[place] = *used);
    unused::check(tree, job, &of_job, findings);
    (settings, blocks)
}

/// Adds loads, walls, rigid bodies, ties and histories to the settings. Returns the initial state
/// of the nodes. `smallest` is the shortest side of an element [length].
fn constrain(
    job: &Job,
    mesh: &Mesh,
    settings: &mut Settings,
    smallest: f64,
    findings: &mut JobProblems,
) -> NodeStart {
    let sets = state::NodeSets::new(job, mesh);
    let mut nodes = state::nodes(job, mesh, &sets, findings);
    settings.loads = loads::resolve(job, mesh, &sets, smallest, &mut nodes, findings);
    settings.loads.absorbers = non_reflecting::resolve(job, mesh, settings, &sets, findings);
    settings.walls = walls::resolve(job, &sets, findings);
    settings.belts = belts::resolve(job, mesh, settings, &sets, &mut nodes, findings);
    settings.rigid = rigid::resolve(job, mesh, settings, &sets, &mut nodes, findings);
    settings.joints = joints::resolve(job, findings);
    ties::join(&mut settings.ties, &mut settings.rigid, &sets, &mut nodes, findings);
    ties::lead(&settings.ties, &mut settings.loads.motions, findings);
    belts::loosen(settings, mesh, &sets, &nodes);
    settings.histories = histories::resolve(job, mesh, settings, &sets, findings);
    settings.followed = springs::followed(job, settings, &sets, findings);
    let turning = turning_parts(job);
    settings.rotations =
        !settings.rigid.is_empty() || mesh.elements.iter().any(|e| turns(e, &turning));
    nodes.free_timed();
    nodes
}

/// Returns the ids of the parts of discrete beams.
fn turning_parts(job: &Job) -> BTreeSet<u32> {
    job.part.iter().filter(|part| part.discrete_beam.is_some()).map(|part| part.id).collect()
}

/// Returns true if the nodes of an element have rotational degrees of freedom. `turning` are the
/// parts of discrete beams.
fn turns(element: &MeshElement, turning: &BTreeSet<u32>) -> bool {
    element.shape.turns() || element.shape == Shape::Line2 && turning.contains(&element.part)
}

/// Returns the nodes of the mesh with rotational degrees of freedom.
fn turning_nodes(job: &Job, mesh: &Mesh) -> HashSet<NodeId> {
    let parts = turning_parts(job);
    let turning = mesh.elements.iter().filter(|e| turns(e, &parts));
    turning.flat_map(|e| e.corners()).copied().collect()
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
