//! Builder of meshes and jobs: mesh rows by code, the rest as the text of a job file. Tests with
//! their own job text take [`Scene::mesh_text`] only. Units are SI, unless a scene has others.

use crumple_proto::mesh::EDGES_OF_TET10;
use std::collections::BTreeMap;
use std::fmt::Write;

/// Steel of the catalogue: Young's modulus [Pa], Poisson's ratio, density [kg/m^3].
pub const STEEL: Elastic = Elastic { e: 210e9, nu: 0.3, rho: 7850.0 };

/// An elastic material.
#[derive(Clone, Copy, Debug)]
pub struct Elastic {
    /// Young's modulus [Pa].
    pub e: f64,
    /// Poisson's ratio.
    pub nu: f64,
    /// Density [kg/m^3].
    pub rho: f64,
}

impl Elastic {
    /// Returns the material with another Poisson's ratio.
    pub fn with_nu(self, nu: f64) -> Self {
        Self { nu, ..self }
    }

    /// Returns the speed of waves in a bar, `sqrt(E/rho)` [m/s].
    pub fn c(&self) -> f64 {
        (self.e / self.rho).sqrt()
    }

    /// Returns the speed of waves in a plate, `sqrt(E/rho/(1-nu^2))` [m/s].
    pub fn c_plate(&self) -> f64 {
        self.c() / (1.0 - self.nu * self.nu).sqrt()
    }
}

/// How cubes are cut into elements.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Cut {
    /// One hexahedron.
    #[default]
    Whole,
    /// Six tetrahedra around a diagonal.
    Tetrahedra,
    /// Two wedges.
    Wedges,
    /// Six tetrahedra with nodes in the middle of their edges.
    QuadraticTetrahedra,
}

impl Cut {
    /// Returns the name of the elements.
    pub fn name(self) -> &'static str {
        match self {
            Cut::Whole => "hexahedron",
            Cut::Tetrahedra => "tetrahedron",
            Cut::Wedges => "wedge",
            Cut::QuadraticTetrahedra => "ten-node tetrahedron",
        }
    }
}

/// Builder of a job; ids of nodes and elements count from 1, until [`Scene::renumber`] changes
/// them.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    end_time: f64,
    units: &'static str,
    nodes: Vec<[f64; 3]>,
    /// How cubes are cut into elements.
    cut: Cut,
    /// Nodes in the middle between two nodes.
    middles: BTreeMap<[u32; 2], u32>,
    shells: Vec<Vec<u32>>,
    solids: Vec<Vec<u32>>,
    beams: Vec<Vec<u32>>,
    springs: Vec<Vec<u32>>,
    trusses: Vec<Vec<u32>>,
    particles: Vec<Vec<u32>>,
    /// Shells with their own thickness [m].
    thicknesses: Vec<(u32, f64)>,
    sets: Vec<(String, Vec<u32>)>,
    keys: String,
    /// Lines of `[time]`, a top-level table that may occur only once.
    time: String,
    /// Further lines of `[mesh]`.
    mesh: String,
    /// Ids of the nodes and of the elements in the job; those missing here are their numbers.
    node_ids: Vec<u32>,
    element_ids: Vec<u32>,
}

/// Regular grid of nodes.
#[derive(Clone, Debug)]
pub struct Grid {
    nodes: Vec<u32>,
    across: usize,
}

impl Grid {
    /// Returns the node at step i along, j across.
    pub fn at(&self, i: usize, j: usize) -> u32 {
        self.nodes[i * (self.across + 1) + j]
    }

    /// Returns all nodes.
    pub fn all(&self) -> &[u32] {
        &self.nodes
    }

    /// Returns the nodes at step i along.
    pub fn row(&self, i: usize) -> Vec<u32> {
        (0..=self.across).map(|j| self.at(i, j)).collect()
    }

    /// Returns the number of steps along.
    pub fn along(&self) -> usize {
        self.nodes.len() / (self.across + 1) - 1
    }

    /// Returns the nodes on the rim.
    pub fn rim(&self) -> Vec<u32> {
        let (n, m) = (self.along(), self.across);
        let on_rim = |i: usize, j: usize| i == 0 || j == 0 || i == n || j == m;
        (0..=n)
            .flat_map(|i| (0..=m).map(move |j| (i, j)))
            .filter(|&(i, j)| on_rim(i, j))
            .map(|(i, j)| self.at(i, j))
            .collect()
    }
}

impl Scene {
    /// Creates an empty scene that runs to `end_time` [s].
    pub fn new(end_time: f64) -> Self {
        Self { end_time, units: "m, s, kg", ..Self::default() }
    }

    /// Returns the scene with other units, such as `"mm, ms, kg"`.
    pub fn in_units(mut self, units: &'static str) -> Self {
        self.units = units;
        self
    }

    /// Returns the end time [s].
    pub fn end(&self) -> f64 {
        self.end_time
    }

    /// Returns the scene with another end time [s].
    pub fn until(mut self, end_time: f64) -> Self {
        self.end_time = end_time;
        self
    }

    /// Adds a node at the position `x` [m] and returns its id.
    pub fn node(&mut self, x: [f64; 3]) -> u32 {
        self.nodes.push(x);
        self.nodes.len() as u32
    }

    /// Returns the number of nodes.
    pub fn count(&self) -> u32 {
        self.nodes.len() as u32
    }

    /// Returns the initial position of a node [m].
    pub fn at(&self, node: u32) -> [f64; 3] {
        self.nodes[node as usize - 1]
    }

    /// Adds a shell of a part and returns its id.
    pub fn shell(&mut self, part: u32, corners: &[u32]) -> u32 {
        self.shells.push(std::iter::once(part).chain(corners.iter().copied()).collect());
        self.shells.len() as u32
    }

    /// Gives a shell its own thickness [m].
    pub fn thicken(&mut self, shell: u32, thickness: f64) {
        self.thicknesses.push((shell, thickness));
    }

    /// Cuts the solids that are added from now on.
    pub fn cut(&mut self, cut: Cut) {
        self.cut = cut;
    }

    /// Adds a solid of a part, cut as [`Scene::cut`] says: a face whose normal points into it, then
    /// the opposite nodes. Ids follow those of the shells.
    pub fn solid(&mut self, part: u32, c: [u32; 8]) {
        match self.cut {
            Cut::Whole => self.solid_of(part, &c),
            Cut::Tetrahedra | Cut::QuadraticTetrahedra => {
                let around = [1, 2, 3, 7, 4, 5].map(|k: usize| c[k]);
                for i in 0..6 {
                    let corners = [c[0], around[i], around[(i + 1) % 6], c[6]];
                    match self.cut {
                        Cut::Tetrahedra => self.solid_of(part, &corners),
                        _ => self.quadratic_tetrahedron(part, corners),
                    }
                }
            }
            Cut::Wedges => {
                self.solid_of(part, &[c[0], c[1], c[2], c[4], c[5], c[6]]);
                self.solid_of(part, &[c[0], c[2], c[3], c[4], c[6], c[7]]);
            }
        }
    }

    /// Adds a tetrahedron, a wedge or a hexahedron, by the number of nodes.
    pub fn solid_of(&mut self, part: u32, corners: &[u32]) {
        self.solids.push(std::iter::once(part).chain(corners.iter().copied()).collect());
    }

    /// Adds a tetrahedron with nodes in the middle of its edges, which it has in common with its
    /// neighbours.
    fn quadratic_tetrahedron(&mut self, part: u32, c: [u32; 4]) {
        let middles = EDGES_OF_TET10.map(|[a, b]: [usize; 2]| self.middle(c[a], c[b]));
        self.solid_of(part, &[&c[..], &middles[..]].concat());
    }

    /// Returns the node in the middle between two nodes, which is added if there is none yet.
    fn middle(&mut self, a: u32, b: u32) -> u32 {
        let ends = [a.min(b), a.max(b)];
        if let Some(&node) = self.middles.get(&ends) {
            return node;
        }
        let [from, to] = ends.map(|n| self.at(n));
        let node = self.node([0, 1, 2].map(|c| 0.5 * (from[c] + to[c])));
        self.middles.insert(ends, node);
        node
    }

    /// Returns the nodes in the middle between two nodes, with these.
    pub fn middles(&self) -> impl Iterator<Item = ([u32; 2], u32)> {
        self.middles.iter().map(|(&ends, &node)| (ends, node))
    }

    /// Adds a beam of a part between two nodes. The second axis of its section points towards
    /// the third node, which must be among the last nodes if no other element has it. Ids follow
    /// those of the solids.
    pub fn beam(&mut self, part: u32, nodes: [u32; 3]) {
        self.beams.push(std::iter::once(part).chain(nodes).collect());
    }

    /// Adds a spring of a part between two nodes. Ids follow those of the beams.
    pub fn spring(&mut self, part: u32, nodes: [u32; 2]) {
        self.springs.push(std::iter::once(part).chain(nodes).collect());
    }

    /// Adds a truss of a part between two nodes. Ids follow those of the springs.
    pub fn truss(&mut self, part: u32, nodes: [u32; 2]) {
        self.trusses.push(std::iter::once(part).chain(nodes).collect());
    }

    /// Adds a particle of a part at a node. Ids follow those of the trusses.
    pub fn particle(&mut self, part: u32, node: u32) {
        self.particles.push(vec![part, node]);
    }

    /// Adds a grid of n by m quads; `place` maps (0..1, 0..1) to coordinates [m].
    pub fn grid(&mut self, part: u32, n: [usize; 2], place: impl Fn(f64, f64) -> [f64; 3]) -> Grid {
        self.grid_of(part, n, place, Self::node)
    }

    /// Adds a grid of n by m quads; `node` adds or finds a node.
    pub fn grid_of(
        &mut self,
        part: u32,
        [n, m]: [usize; 2],
        place: impl Fn(f64, f64) -> [f64; 3],
        node: impl FnMut(&mut Self, [f64; 3]) -> u32,
    ) -> Grid {
        self.lattice_of(part, [n, m], |i, j| place(i as f64 / n as f64, j as f64 / m as f64), node)
    }

    /// Adds a grid of n by m quads; `at` maps numbers of steps along and across to coordinates
    /// [m].
    pub fn lattice(
        &mut self,
        part: u32,
        n: [usize; 2],
        at: impl Fn(usize, usize) -> [f64; 3],
    ) -> Grid {
        self.lattice_of(part, n, at, Self::node)
    }

    fn lattice_of(
        &mut self,
        part: u32,
        [n, m]: [usize; 2],
        at: impl Fn(usize, usize) -> [f64; 3],
        mut node: impl FnMut(&mut Self, [f64; 3]) -> u32,
    ) -> Grid {
        let nodes = (0..=n)
            .flat_map(|i| (0..=m).map(move |j| (i, j)))
            .map(|(i, j)| node(self, at(i, j)))
            .collect();
        let grid = Grid { nodes, across: m };
        for i in 0..n {
            for j in 0..m {
                self.shell(
                    part,
                    &[grid.at(i, j), grid.at(i + 1, j), grid.at(i + 1, j + 1), grid.at(i, j + 1)],
                );
            }
        }
        grid
    }

    /// Adds a set of nodes and returns its name.
    pub fn set(&mut self, nodes: &[u32]) -> String {
        let name = format!("set{}", self.sets.len() + 1);
        self.sets.push((name.clone(), nodes.to_vec()));
        name
    }

    /// Adds a set of nodes with a name.
    pub fn set_named(&mut self, name: &str, nodes: &[u32]) {
        self.sets.push((name.to_string(), nodes.to_vec()));
    }

    /// Gives all nodes and elements so far other ids in the job, by their numbers from 1. Elements
    /// count from shells to particles.
    pub fn renumber(&mut self, node: impl Fn(u32) -> u32, element: impl Fn(u32) -> u32) {
        let kinds = [
            &self.shells,
            &self.solids,
            &self.beams,
            &self.springs,
            &self.trusses,
            &self.particles,
        ];
        let elements: usize = kinds.iter().map(|rows| rows.len()).sum();
        self.node_ids = (1..=self.count()).map(node).collect();
        self.element_ids = (1..=elements as u32).map(element).collect();
    }

    /// Adds lines of a job file.
    pub fn add(&mut self, keys: &str) {
        self.keys.push_str(keys);
        self.keys.push('\n');
    }

    /// Adds a line to `[time]`.
    pub fn time(&mut self, line: &str) {
        self.time.push_str(line);
        self.time.push('\n');
    }

    /// Adds a line to `[mesh]`.
    pub fn mesh(&mut self, line: &str) {
        self.mesh.push_str(line);
        self.mesh.push('\n');
    }

    /// Adds an elastic material.
    pub fn elastic(&mut self, name: &str, m: Elastic) {
        self.add(&format!(
            "[[material]]\nname = \"{name}\"\nlaw = \"elastic\"\n\
             density = {:?}\nyoungs_modulus = {:?}\npoisson = {:?}",
            m.rho, m.e, m.nu
        ));
    }

    /// Adds a material with J2 plasticity: yield stress and plastic modulus [Pa].
    pub fn plastic(&mut self, name: &str, m: Elastic, yield_stress: f64, modulus: f64) {
        self.add(&format!(
            "[[material]]\nname = \"{name}\"\nlaw = \"j2\"\n\
             density = {:?}\nyoungs_modulus = {:?}\npoisson = {:?}\n\
             yield_stress = {yield_stress:?}\nhardening_modulus = {modulus:?}",
            m.rho, m.e, m.nu
        ));
    }

    /// Adds a part of shells; `more` are further keys of it.
    pub fn part(&mut self, id: u32, material: &str, thickness: f64, more: &str) {
        self.add(&format!(
            "[[part]]\nid = {id}\nmaterial = \"{material}\"\nthickness = {thickness:?}\n{more}"
        ));
    }

    /// Adds a part of solids; `more` are further keys of it.
    pub fn solid_part(&mut self, id: u32, material: &str, more: &str) {
        self.add(&format!("[[part]]\nid = {id}\nmaterial = \"{material}\"\n{more}"));
    }

    /// Adds a plane of symmetry with its normal along an axis.
    pub fn symmetry(&mut self, point: [f64; 3], normal: [f64; 3]) {
        self.add(&format!("[[symmetry]]\npoint = {point:?}\nnormal = {normal:?}"));
    }

    /// Fixes degrees of freedom, such as `"x y rz"`.
    pub fn fix(&mut self, nodes: &[u32], dofs: &str) {
        let set = self.set(nodes);
        let dofs: Vec<&str> = dofs.split(' ').collect();
        self.add(&format!("[[fix]]\nnodes = \"{set}\"\ndofs = {dofs:?}"));
    }

    /// Gives each node a velocity [m/s] and a spin about itself [1/s].
    pub fn start(&mut self, nodes: &[u32], velocity: [f64; 3], spin: [f64; 3]) {
        let set = self.set(nodes);
        if spin == [0.0; 3] {
            self.add(&format!("[[initial_velocity]]\nnodes = \"{set}\"\nvelocity = {velocity:?}"));
            return;
        }
        for &n in nodes {
            let (one, centre) = (self.set(&[n]), self.at(n));
            self.add(&format!(
                "[[initial_velocity]]\nnodes = \"{one}\"\nvelocity = {velocity:?}\n\
                 spin = {spin:?}\ncentre = {centre:?}"
            ));
        }
    }

    /// Adds a curve through these points: time [s] and factor.
    pub fn curve(&mut self, name: &str, points: impl IntoIterator<Item = (f64, f64)>) {
        let list: String = points.into_iter().map(|(t, f)| format!("[{t:?}, {f:?}],")).collect();
        self.add(&format!("[[curve]]\nname = \"{name}\"\npoints = [{list}]"));
    }

    /// Adds the curve `ramp`, from 0 to 1 at the time `until` [s].
    pub fn ramp(&mut self, until: f64) {
        self.curve("ramp", [(0.0, 0.0), (until, 1.0)]);
    }

    /// Adds a pressure [Pa] on the faces between these nodes, which follows the curve `ramp`.
    pub fn press(&mut self, nodes: &[u32], pressure: f64) {
        let set = self.set(nodes);
        self.add(&format!(
            "[[pressure]]\nnodes = \"{set}\"\npressure = {pressure:?}\ncurve = \"ramp\""
        ));
    }

    /// Adds mass to nodes, `mass` [kg] in total.
    pub fn mass(&mut self, nodes: &[u32], mass: f64) {
        let set = self.set(nodes);
        self.add(&format!("[[mass]]\nnodes = \"{set}\"\nmass = {mass:?}"));
    }

    /// Adds a rigid wall.
    pub fn wall(&mut self, point: [f64; 3], normal: [f64; 3], friction: f64) {
        self.add(&format!(
            "[[wall]]\npoint = {point:?}\nnormal = {normal:?}\nfriction = {friction:?}"
        ));
    }

    /// Returns the text of the job file.
    pub fn text(&self, title: &str) -> String {
        let mut text = format!(
            "title = \"{title}\"\nunits = \"{}\"\nend_time = {:?}\n{}",
            self.units,
            self.end_time,
            self.mesh_text()
        );
        // Writing into a string cannot fail.
        let _ = write!(text, "[time]\n{}[output]\nfield_interval = -1.0\n{}", self.time, self.keys);
        text
    }

    /// Returns the tables `[mesh]` and `[mesh.node_sets]` of the job file.
    pub fn mesh_text(&self) -> String {
        let id_of = |ids: &[u32], number: u32| *ids.get(number as usize - 1).unwrap_or(&number);
        let nodes_of = |numbers: &[u32]| -> Vec<u32> {
            numbers.iter().map(|&n| id_of(&self.node_ids, n)).collect()
        };
        let mut text = format!("[mesh]\n{}nodes = [\n", self.mesh);
        // Writing into a string cannot fail.
        for (number, [x, y, z]) in (1..).zip(&self.nodes) {
            let _ = writeln!(text, "[{}, {x:?}, {y:?}, {z:?}],", id_of(&self.node_ids, number));
        }
        let mut number = 0;
        for (kind, rows) in [
            ("shells", &self.shells),
            ("solids", &self.solids),
            ("beams", &self.beams),
            ("springs", &self.springs),
            ("trusses", &self.trusses),
            ("particles", &self.particles),
        ] {
            let _ = write!(text, "]\n{kind} = [\n");
            for row in rows {
                number += 1;
                let (id, part) = (id_of(&self.element_ids, number), row[0]);
                let nodes: Vec<String> = nodes_of(&row[1..]).iter().map(u32::to_string).collect();
                let _ = writeln!(text, "[{id}, {part}, {}],", nodes.join(", "));
            }
        }
        text.push_str("]\n");
        if !self.thicknesses.is_empty() {
            let row =
                |&(shell, t): &(u32, f64)| format!("[{}, {t:?}]", id_of(&self.element_ids, shell));
            let rows: Vec<String> = self.thicknesses.iter().map(row).collect();
            let _ = writeln!(text, "thicknesses = [{}]", rows.join(", "));
        }
        text.push_str("[mesh.node_sets]\n");
        for (name, nodes) in &self.sets {
            let _ = writeln!(text, "{name} = {:?}", nodes_of(nodes));
        }
        text
    }
}
