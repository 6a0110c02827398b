//! Node sets of a job besides those of its mesh: sets by rule (`[[set]]`), and the nodes of parts
//! and rigid bodies that a key names as a set.
//!
//! Rules see the mesh at time 0, before nodes move onto tied surfaces. The results are added to
//! the node sets of the mesh, so that all later stages only know named sets.
//!
//! - `check.rs`: the keys of each rule
//! - `region.rs`: rules by coordinates
//! - `outline.rs`: rules by edges and faces

mod check;
mod outline;
mod region;
#[cfg(test)]
mod tests;

use super::validate::{JobProblems, nearest};
use crumple_proto::ids::NodeId;
use crumple_proto::job::{Job, Rigid, SetInput, SetRule};
use crumple_proto::mesh::{Mesh, MeshElement};
use crumple_proto::problem::Problem;
use crumple_proto::quality::quality;
use region::SetRegion;
use std::collections::{HashMap, HashSet};
use std::rc::Rc;

/// Distance outside of a region up to which a node counts as inside, as a fraction of the shortest
/// side of an element.
const TOLERANCE: f64 = 1e-3;

/// Indices of nodes in the mesh, ascending.
type Members = Rc<Vec<usize>>;

/// Adds the sets by rule, and the parts and rigid bodies that a key names, to the node sets of a
/// mesh.
pub fn resolve(job: &Job, mesh: &mut Mesh, findings: &mut JobProblems) {
    let mut resolver = Resolver::new(job, mesh, findings);
    let mut found: HashMap<&str, Members> = HashMap::new();
    for (i, set) in job.set.iter().enumerate() {
        found.extend(resolver.rule(i).map(|nodes| (set.name.as_str(), nodes)));
    }
    for (path, name) in references(job) {
        if let Some(nodes) = resolver.named(name, &path)
            && !mesh.node_sets.contains_key(name)
        {
            found.insert(name, nodes);
        }
    }
    let ids = |nodes: &Members| nodes.iter().map(|&n| mesh.nodes[n].id).collect();
    let sets: Vec<(String, Vec<NodeId>)> =
        found.iter().map(|(name, nodes)| (name.to_string(), ids(nodes))).collect();
    mesh.node_sets.extend(sets);
}

/// A key of a list of a job that names a node set.
pub struct SetKey {
    /// The list, such as `output.node`.
    pub list: &'static str,
    /// The key in its entries.
    pub key: &'static str,
    /// Returns the names, each with the index of its entry.
    names: fn(&Job) -> Vec<(usize, &str)>,
}

/// Returns the names that entries have, with the indices of the entries.
fn names<T>(entries: &[T], of: fn(&T) -> Option<&String>) -> Vec<(usize, &str)> {
    entries.iter().enumerate().filter_map(|(i, one)| Some((i, of(one)?.as_str()))).collect()
}

/// Creates a row of [`SET_KEYS`].
const fn row(
    list: &'static str,
    key: &'static str,
    names: fn(&Job) -> Vec<(usize, &str)>,
) -> SetKey {
    SetKey { list, key, names }
}

/// All keys outside of `[[set]]` that name a node set.
pub const SET_KEYS: &[SetKey] = &[
    row("mass", "nodes", |job| names(&job.mass, |m| Some(&m.nodes))),
    row("fix", "nodes", |job| names(&job.fix, |f| Some(&f.nodes))),
    row("initial_velocity", "nodes", |job| names(&job.initial_velocity, |v| v.nodes.as_ref())),
    row("gravity", "nodes", |job| names(&job.gravity, |g| g.nodes.as_ref())),
    row("load", "nodes", |job| names(&job.load, |l| Some(&l.nodes))),
    row("pressure", "nodes", |job| names(&job.pressure, |p| p.nodes.as_ref())),
    row("non_reflecting", "nodes", |job| names(&job.non_reflecting, |b| b.nodes.as_ref())),
    row("airbag", "nodes", |job| names(&job.airbag, |bag| bag.nodes.as_ref())),
    row("motion", "nodes", |job| names(&job.motion, |m| m.nodes.as_ref())),
    row("rigid", "nodes", |job| names(&job.rigid, |r| r.nodes.as_ref())),
    row("tie", "nodes", |job| names(&job.tie, |t| Some(&t.nodes))),
    row("tie", "faces", |job| names(&job.tie, |t| t.faces.as_ref())),
    row("tie", "mean_of", |job| names(&job.tie, |t| t.mean_of.as_ref())),
    row("wall", "nodes", |job| names(&job.wall, |w| w.nodes.as_ref())),
    row("wall", "except", |job| names(&job.wall, |w| w.except.as_ref())),
    row("output.node", "nodes", |job| names(&job.output.node, |n| n.nodes.as_ref())),
    row("output.section", "nodes", |job| names(&job.output.section, |s| Some(&s.nodes))),
    row("output.transducer", "nodes", |job| names(&job.output.transducer, |t| t.nodes.as_ref())),
    row("output.transducer", "from_nodes", |job| {
        names(&job.output.transducer, |t| t.from_nodes.as_ref())
    }),
];

/// Returns the names that keys of a job use as node sets, with the paths of the keys.
fn references(job: &Job) -> impl Iterator<Item = (String, &str)> {
    SET_KEYS.iter().flat_map(move |row| {
        let path = move |i| format!("{}.{i}.{}", row.list, row.key);
        (row.names)(job).into_iter().map(move |(i, name)| (path(i), name))
    })
}

/// Progress of a set by rule.
#[derive(Clone)]
enum SetProgress {
    Open,
    /// Its rule refers to sets that are being resolved.
    Begun,
    /// `None` if it has an error.
    Done(Option<Members>),
}

/// Elements that a rule by edges and faces looks at.
enum Scope {
    Mesh,
    /// Those of the parts with these ids.
    Parts(Vec<u32>),
    /// Those with all of their nodes in a set; true for each node in it.
    Nodes(Vec<bool>),
}

struct Resolver<'a> {
    job: &'a Job,
    mesh: &'a Mesh,
    findings: &'a mut JobProblems,
    /// Indices of nodes.
    index: HashMap<NodeId, usize>,
    progress: Vec<SetProgress>,
    /// Default tolerance [length].
    tolerance: f64,
}

impl<'a> Resolver<'a> {
    fn new(job: &'a Job, mesh: &'a Mesh, findings: &'a mut JobProblems) -> Self {
        let valid = check::check(job, mesh, findings);
        let open = |valid| if valid { SetProgress::Open } else { SetProgress::Done(None) };
        let side = || quality(mesh).map_or(0.0, |quality| quality.min_side.value);
        let by_side = job.set.iter().any(|s| s.tolerance.is_none());
        Self {
            job,
            mesh,
            findings,
            index: mesh.nodes.iter().enumerate().map(|(i, n)| (n.id, i)).collect(),
            progress: valid.into_iter().map(open).collect(),
            tolerance: if by_side { TOLERANCE * side() } else { 0.0 },
        }
    }

    /// Returns the nodes of the set by rule with this index; `None` if it has an error.
    fn rule(&mut self, i: usize) -> Option<Members> {
        match &self.progress[i] {
            SetProgress::Done(nodes) => return nodes.clone(),
            SetProgress::Begun => {
                let message = format!("set `{}` refers to itself", self.job.set[i].name);
                let help = "remove one of the references: a set comes from the mesh, parts, and \
                            sets that do not need it";
                self.findings.add(Problem::error(format!("set.{i}"), message, help));
                return None;
            }
            SetProgress::Open => {}
        }
        self.progress[i] = SetProgress::Begun;
        let nodes = self.select(i).filter(|nodes| self.check_empty(i, nodes)).map(Rc::new);
        self.progress[i] = SetProgress::Done(nodes.clone());
        nodes
    }

    /// Reports a set without nodes and returns false, unless it may be empty.
    fn check_empty(&mut self, i: usize, nodes: &[usize]) -> bool {
        let set = &self.job.set[i];
        if !nodes.is_empty() || set.allow_empty {
            return true;
        }
        let nearest = SetRegion::of(set).map(|region| {
            let outside = self.mesh.nodes.iter().map(|n| region.outside(n.x));
            outside.fold(f64::INFINITY, f64::min)
        });
        let help = match nearest.filter(|&least| least > 0.0) {
            Some(least) => format!(
                "the nearest node of the mesh is {least:.3e} outside: correct the rule, or set \
                 allow_empty = true"
            ),
            None => "correct the rule, or set allow_empty = true".into(),
        };
        let message = format!("set `{}` has no nodes", set.name);
        self.findings.add(Problem::error(format!("set.{i}"), message, help));
        false
    }

    /// Returns the nodes that fit a rule, ascending; `None` if the rule has an error.
    fn select(&mut self, i: usize) -> Option<Vec<usize>> {
        let (job, mesh) = (self.job, self.mesh);
        let set = &job.set[i];
        let within = match &set.of {
            None => None,
            Some(name) => Some(self.required(name, &format!("set.{i}.of"))?),
        };
        let all: Vec<usize> = match &within {
            None => (0..mesh.nodes.len()).collect(),
            Some(nodes) => nodes.to_vec(),
        };
        Some(match set.rule {
            SetRule::Part => intersection(&self.of_parts(&set.parts), &all),
            SetRule::Nodes => intersection(&self.of_ids(set, i)?, &all),
            SetRule::Nearest => region::nearest_nodes(set, i, mesh, all, self.findings)?,
            SetRule::Within => {
                let from = self.required(set.from.as_ref()?, &format!("set.{i}.from"))?;
                region::within(mesh, &from, set.distance?, &all)
            }
            SetRule::FreeEdges | SetRule::Boundary | SetRule::Surface => {
                let scope = self.scope(set.of.as_deref(), &all);
                outline::nodes(set.rule, mesh, &self.index, &|e| self.is_in(&scope, e))
            }
            SetRule::Union | SetRule::Intersection | SetRule::Difference => {
                intersection(&self.combined(set, i)?, &all)
            }
            SetRule::Box
            | SetRule::Sphere
            | SetRule::Plane
            | SetRule::HalfSpace
            | SetRule::Cylinder => {
                let region = SetRegion::of(set)?;
                let tolerance = set.tolerance.unwrap_or(self.tolerance);
                let is_inside = |&n: &usize| region.outside(mesh.nodes[n].x) <= tolerance;
                all.into_iter().filter(is_inside).collect()
            }
        })
    }

    /// Combines the sets of an entry.
    fn combined(&mut self, set: &SetInput, i: usize) -> Option<Vec<usize>> {
        let named = set.sets.iter().enumerate();
        let parts: Vec<Option<Members>> =
            named.map(|(k, name)| self.required(name, &format!("set.{i}.sets.{k}"))).collect();
        let parts: Vec<Members> = parts.into_iter().collect::<Option<_>>()?;
        let (first, others) = parts.split_first()?;
        let count = |n: &usize| others.iter().filter(|set| set.binary_search(n).is_ok()).count();
        let mut nodes = match set.rule {
            SetRule::Intersection => {
                first.iter().copied().filter(|n| count(n) == others.len()).collect()
            }
            SetRule::Difference => first.iter().copied().filter(|n| count(n) == 0).collect(),
            _ => parts.iter().flat_map(|set| set.iter().copied()).collect::<Vec<usize>>(),
        };
        nodes.sort_unstable();
        nodes.dedup();
        Some(nodes)
    }

    /// Returns the nodes of a set, part or rigid body; reports an error at `path` if there is none.
    fn required(&mut self, name: &str, path: &str) -> Option<Members> {
        let is_rule = self.job.set.iter().any(|s| s.name == name);
        if is_rule || self.is_known(name) || part_of_id(self.job, name).is_some() {
            return self.named(name, path);
        }
        let own = self.job.set.iter().map(|s| s.name.as_str());
        let known: Vec<&str> = own.chain(known_names(self.job, self.mesh)).collect();
        let message = format!("there is no node set, part or rigid body `{name}`");
        self.findings.add(Problem::error(path, message, nearest(name, &known)));
        None
    }

    fn is_known(&self, name: &str) -> bool {
        known_names(self.job, self.mesh).any(|known| known == name)
    }

    /// Returns the nodes of a set, part or rigid body, if there is one that has no error. Reports
    /// an error at `path` if several have this name and other nodes; in a job with a deck, the set
    /// wins.
    fn named(&mut self, name: &str, path: &str) -> Option<Members> {
        if let Some(i) = self.job.set.iter().position(|s| s.name == name) {
            return self.rule(i);
        }
        let mut found: Vec<(&str, Members)> = Vec::new();
        if let Some(ids) = self.mesh.node_sets.get(name) {
            found.push(("node set", Rc::new(self.indices(ids))));
        }
        let parts = self.job.part.iter().filter(|p| !name.is_empty() && p.name == name);
        found.extend(parts.map(|p| ("part", Rc::new(self.of_parts(&[p.id])))));
        let body = self.job.rigid.iter().position(|r| !name.is_empty() && r.name == name);
        if let Some(nodes) = body.and_then(|i| self.of_body(i)) {
            found.push(("rigid body", Rc::new(nodes)));
        }
        if !self.is_known(name)
            && let Some(id) = part_of_id(self.job, name)
        {
            found.push(("part", Rc::new(self.of_parts(&[id]))));
        }
        let (kind, nodes) = found.first()?;
        // Titles in a deck need not differ, because its cards refer to numbers: the set wins.
        let set_wins = self.job.mesh.deck.is_some() && *kind == "node set";
        let mut others = found.iter().filter(|_| !set_wins);
        if let Some((other, _)) = others.find(|(_, others)| others != nodes) {
            let message = format!("`{name}` is a {kind} and a {other}, which have other nodes");
            let help = "rename one of them, so that the name of a set is unique";
            self.findings.add(Problem::error(path, message, help));
            return None;
        }
        Some(nodes.clone())
    }

    /// Returns the nodes of a rigid body; `None` if its nodes are a set with an error.
    fn of_body(&mut self, i: usize) -> Option<Vec<usize>> {
        let Rigid { name, parts, nodes, .. } = &self.job.rigid[i];
        let mut all = self.of_parts(parts);
        match nodes {
            Some(set) if set != name => {
                all.extend(self.named(set, &format!("rigid.{i}.nodes"))?.iter());
            }
            Some(set) => all.extend(self.indices(self.mesh.node_sets.get(set)?)),
            None => {}
        }
        all.sort_unstable();
        all.dedup();
        Some(all)
    }

    /// Returns the nodes of parts.
    fn of_parts(&self, ids: &[u32]) -> Vec<usize> {
        let elements = self.mesh.elements.iter().filter(|e| ids.contains(&e.part));
        let nodes: HashSet<NodeId> = elements.flat_map(|e| e.corners()).copied().collect();
        self.indices(&nodes)
    }

    /// Returns the indices of nodes that elements use, ascending.
    fn indices<'i>(&self, ids: impl IntoIterator<Item = &'i NodeId>) -> Vec<usize> {
        let mut nodes: Vec<usize> =
            ids.into_iter().filter_map(|id| self.index.get(id).copied()).collect();
        nodes.sort_unstable();
        nodes.dedup();
        nodes
    }

    /// Returns the nodes of a list of ids. Reports ids that no element has.
    fn of_ids(&mut self, set: &SetInput, i: usize) -> Option<Vec<usize>> {
        let mut whole = true;
        for (k, id) in set.ids.iter().enumerate() {
            if !self.index.contains_key(&NodeId(*id)) {
                let message = format!("set `{}`: no element has the node {id}", set.name);
                let help = "list ids of nodes that elements have, or remove this one";
                self.findings.add(Problem::error(format!("set.{i}.ids.{k}"), message, help));
                whole = false;
            }
        }
        let ids: Vec<NodeId> = set.ids.iter().copied().map(NodeId).collect();
        whole.then(|| self.indices(&ids))
    }

    /// Returns the elements of `of`, whose nodes are given.
    fn scope(&self, of: Option<&str>, nodes: &[usize]) -> Scope {
        let Some(name) = of else { return Scope::Mesh };
        let parts = self.job.part.iter().filter(|p| p.name == name).map(|p| p.id);
        let bodies = self.job.rigid.iter().filter(|r| r.name == name && r.nodes.is_none());
        let by_id = part_of_id(self.job, name).filter(|_| !self.is_known(name));
        let bodies = bodies.flat_map(|r| r.parts.iter().copied());
        let parts: Vec<u32> = parts.chain(bodies).chain(by_id).collect();
        if !parts.is_empty() {
            return Scope::Parts(parts);
        }
        let mut inside = vec![false; self.mesh.nodes.len()];
        nodes.iter().for_each(|&n| inside[n] = true);
        Scope::Nodes(inside)
    }

    fn is_in(&self, scope: &Scope, element: &MeshElement) -> bool {
        match scope {
            Scope::Mesh => true,
            Scope::Parts(parts) => parts.contains(&element.part),
            Scope::Nodes(inside) => {
                let mut nodes = element.corners().iter().map(|id| self.index.get(id));
                nodes.all(|n| n.is_some_and(|&n| inside[n]))
            }
        }
    }
}

/// Returns the id of a part that is given as the text of a name: a part need not have a name.
fn part_of_id(job: &Job, name: &str) -> Option<u32> {
    let id = name.parse().ok()?;
    job.part.iter().any(|part| part.id == id).then_some(id)
}

/// Returns the names of the sets of a mesh, of parts and of rigid bodies.
pub fn known_names<'a>(job: &'a Job, mesh: &'a Mesh) -> impl Iterator<Item = &'a str> {
    let parts = job.part.iter().map(|p| p.name.as_str());
    let bodies = job.rigid.iter().map(|r| r.name.as_str());
    let named = parts.chain(bodies).filter(|name| !name.is_empty());
    mesh.node_sets.keys().map(String::as_str).chain(named)
}

/// Returns the nodes in both of two ascending lists.
fn intersection(nodes: &[usize], within: &[usize]) -> Vec<usize> {
    nodes.iter().copied().filter(|n| within.binary_search(n).is_ok()).collect()
}
