//! A valid job with its mesh, and what follows from both.

use super::mesh::added::AddedMesh;
use super::report::{Located, Report, SourceFiles};
use super::{BuiltElements, ElementStart, NodeStart, Renumbered, state};
use crate::input::deck;
use crate::input::mesh_file::ImportRow;
use crumple_proto::ids::NodeId;
use crumple_proto::job::Job;
use crumple_proto::mesh::{Mesh, MeshNode, free_faces};
use crumple_proto::partition::{ElementRecord, NodeRecord, Settings};
use crumple_proto::problem::Problem;
use crumple_proto::quality::Quality;
use crumple_worker::parallel::decomposition::BoxDecomposition;
use std::collections::BTreeMap;
use std::path::PathBuf;

/// A valid job: read, checked, with its mesh and all defaults.
pub struct Model {
    /// The job as written, with `--set`.
    pub job: Job,
    /// The mesh, sorted by id, without nodes that no element uses.
    pub mesh: Mesh,
    /// Settings of every worker. `field_dir` is empty until the run sets it.
    pub settings: Settings,
    /// Settings of the decomposition.
    pub decomposition: BoxDecomposition,
    /// Initial state of the nodes, in the order of the mesh.
    pub nodes: NodeStart,
    /// Initial state of the elements, in the order of the mesh.
    pub elements: ElementStart,
    /// Shape quality of the elements.
    pub quality: Quality,
    /// Data of the renumbering, if nodes and elements were renumbered.
    pub renumbered: Option<Renumbered>,
    /// Positions in the input of nodes that ties have moved [length].
    pub given: BTreeMap<NodeId, [f64; 3]>,
    /// The formulations of all parts.
    pub blocks: BuiltElements,
    /// Warnings. [`Model::show`] adds the line in the job. The run may add more warnings.
    pub warnings: Vec<Problem>,
    /// Requests of a deck, and the settings used for them.
    pub mapping: Vec<deck::Mapping>,
    /// Content of a deck or a mesh file that is not supported and was ignored.
    pub unsupported: Vec<String>,
    /// The job file that was read.
    pub path: PathBuf,
    pub(super) sources: SourceFiles,
}

impl Model {
    /// Returns a problem with its line in the job.
    pub fn show(&self, problem: &Problem) -> Located {
        self.sources.locate(problem)
    }

    /// Returns what became of the content of a mesh file of another program.
    pub fn mesh_rows(&self) -> &[ImportRow] {
        &self.sources.mesh_rows
    }

    /// Returns what became of the meshes that were added to the mesh.
    pub fn added_meshes(&self) -> &[AddedMesh] {
        &self.sources.added
    }

    /// Returns the content of a deck that is not supported and was ignored, without that of mesh
    /// files, which is in their tables.
    pub fn unsupported_of_deck(&self) -> &[String] {
        &self.unsupported[..self.unsupported.len() - self.sources.left_out().count()]
    }

    /// Returns the files that were read: the job, its meshes and decks, and what all of them
    /// include.
    pub fn files(&self) -> Vec<PathBuf> {
        let deck = self.sources.deck.iter().flat_map(|deck| &deck.files).map(|text| &text.path);
        let mut all = vec![self.path.clone()];
        let included = self.sources.included.iter().map(|file| &file.path);
        for path in included.chain(&self.sources.mesh_files).chain(deck) {
            if !all.contains(path) {
                all.push(path.clone());
            }
        }
        all
    }

    /// Returns the position of a node in the input [length].
    pub fn given_position(&self, node: &MeshNode) -> [f64; 3] {
        self.given.get(&node.id).copied().unwrap_or(node.x)
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
        self.settings.initial = Vec::new();
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
    /// the job, otherwise as many as have all their threads on `cores`. Returns an error if it is 0
    /// or larger than the number of elements.
    pub fn workers(&self, asked: Option<usize>, cores: usize) -> Result<usize, Report> {
        let elements = self.mesh.elements.len();
        let from_job = Some(self.job.parallel.workers).filter(|&n| n > 0);
        let (count, path) = match (asked, from_job) {
            (Some(n), _) => (n, ""),
            (None, Some(n)) => (n, "parallel.workers"),
            (None, None) => return Ok((cores / self.settings.threads).clamp(1, elements)),
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
            _ => Err(self.report(&[problem])),
        }
    }

    /// Returns a report of problems, with their lines in the job.
    pub fn report(&self, problems: &[Problem]) -> Report {
        Report { problems: problems.iter().map(|problem| self.show(problem)).collect() }
    }
}
