//! The job as it is written in `job.toml`. Reading and checking live in the master; this is the
//! plain data.

mod beam;
mod contact;
mod loads;
mod output;
mod rigid;
mod spring;
mod tie;
mod wall;

pub use beam::{Beam, BeamSection, Weld};
pub use contact::{Contact, Interface};
pub use loads::{Curve, Gravity, Load, Motion, Pressure, Symmetry};
pub use output::{NodeHistory, Output, SectionHistory, TransducerHistory};
pub use rigid::Rigid;
pub use spring::Spring;
pub use tie::Tie;
pub use wall::Wall;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// A whole job file.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// What the scene is, one line.
    #[serde(default)]
    pub title: String,
    /// The consistent set of units, for people (the engine is unit-free).
    #[serde(default)]
    pub units: String,
    /// Simulated time to run to [time].
    pub end_time: f64,
    /// Where the mesh comes from.
    pub mesh: MeshSource,
    /// Options of the mesh generator.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub scene: toml::Table,
    /// Time step.
    #[serde(default)]
    pub time: Time,
    /// What elements compute with.
    #[serde(default)]
    pub elements: Elements,
    /// What is written, how often.
    #[serde(default)]
    pub output: Output,
    /// Decomposition and redecomposition.
    #[serde(default)]
    pub parallel: Parallel,
    /// Materials.
    #[serde(default)]
    pub material: Vec<MaterialSpec>,
    /// Parts.
    #[serde(default)]
    pub part: Vec<Part>,
    /// Lumped masses.
    #[serde(default)]
    pub mass: Vec<LumpedMass>,
    /// Rigid walls.
    #[serde(default)]
    pub wall: Vec<Wall>,
    /// Initial velocities; later entries win.
    #[serde(default)]
    pub initial_velocity: Vec<InitialVelocity>,
    /// Fixed degrees of freedom.
    #[serde(default)]
    pub fix: Vec<Fix>,
    /// Planes of symmetry.
    #[serde(default)]
    pub symmetry: Vec<Symmetry>,
    /// Factors over time that loads and motions refer to.
    #[serde(default)]
    pub curve: Vec<Curve>,
    /// Gravity and other body forces; they add up.
    #[serde(default)]
    pub gravity: Vec<Gravity>,
    /// Forces on node sets; they add up.
    #[serde(default)]
    pub load: Vec<Load>,
    /// Pressures on faces; they add up.
    #[serde(default)]
    pub pressure: Vec<Pressure>,
    /// Rigid bodies.
    #[serde(default)]
    pub rigid: Vec<Rigid>,
    /// Nodes tied to surfaces.
    #[serde(default)]
    pub tie: Vec<Tie>,
    /// Prescribed motions of node sets and rigid bodies.
    #[serde(default)]
    pub motion: Vec<Motion>,
    /// Contact; without this table nothing touches anything but rigid walls. Written as a list,
    /// `[[contact]]`, the first entry is this table and each further one a `[[contact.interface]]`.
    #[serde(default)]
    pub contact: Option<Contact>,
}

impl Job {
    /// The JSON Schema of a job: every key, its type, default and meaning. The reader checks files
    /// against it.
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(Job).to_value()
    }
}

/// Where the mesh comes from: exactly one of generator, file, deck, or nodes with shells, solids,
/// beams or springs.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshSource {
    /// Name of a generator of the `cases` crate; its options are in `[scene]`.
    #[serde(default)]
    pub generator: Option<String>,
    /// A TOML file beside the job with `nodes`, `shells`, `solids`, `beams`, `springs` and
    /// `node_sets` as below.
    #[serde(default)]
    pub file: Option<String>,
    /// An LS-DYNA keyword deck beside the job: mesh, node sets, parts, materials and all else that
    /// it says. The job's own keys go before those of the deck; entries of its lists are merged
    /// with the deck's of the same id or name, and added if there is none.
    #[serde(default)]
    pub deck: Option<String>,
    /// Keywords of the deck that are not read, such as `DEFORMABLE_TO_RIGID`.
    #[serde(default)]
    pub leave_out: Vec<String>,
    /// Go on without what the deck has and the engine cannot do; it is an error otherwise.
    #[serde(default)]
    pub allow_unsupported: bool,
    /// Nodes as `[id, x, y, z]` [length].
    #[serde(default)]
    pub nodes: Vec<[f64; 4]>,
    /// Shells as `[id, part id, n1, n2, n3, n4]`, or three nodes for a triangle.
    #[serde(default)]
    pub shells: Vec<Vec<u64>>,
    /// Solids as `[id, part id, n1, ..., n8]`: the nodes of a face, whose right-hand normal points
    /// into the solid, then those opposite.
    #[serde(default)]
    pub solids: Vec<Vec<u64>>,
    /// Beams as `[id, part id, n1, n2, n3]`; the second axis of the section points from the line n1
    /// n2 towards n3, which may belong to no element.
    #[serde(default)]
    pub beams: Vec<Vec<u64>>,
    /// Springs and dampers as `[id, part id, n1, n2]`.
    #[serde(default)]
    pub springs: Vec<Vec<u64>>,
    /// Thicknesses of single shells as `[id, thickness]` [length]; all others have that of their
    /// part. Also for the shells of a generator or a deck; a mesh file has its own.
    #[serde(default)]
    pub thicknesses: Vec<[f64; 2]>,
    /// Named sets of node ids; with a deck, further ones.
    #[serde(default)]
    pub node_sets: BTreeMap<String, Vec<u64>>,
}

/// Time step settings.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Time {
    /// Fraction of the smallest element step that is used; `cases/studies/README.md`, penalty-map.
    pub safety: f64,
    /// Stop after this many cycles, 0 for no limit.
    pub max_cycles: u64,
    /// The run stops as failed when the step falls below this fraction of the first one.
    pub dt_min_ratio: f64,
    /// Add mass to elements so that none has a stable step, before `safety`, below this at the
    /// start [time]; 0 for none.
    pub mass_scaling_dt: f64,
    /// Most mass that may be added so, as a fraction of the structure's: a job that would get more
    /// is refused.
    pub mass_scaling_limit: f64,
    /// Elements whose stable step at the start is at least this many times the smallest one are
    /// computed every so many cycles only, the small ones in each; 1 for all in each. Elements of
    /// parts in contact are in each, see `subcycle_contact`.
    pub subcycles: u64,
    /// Layers of neighbours around the small elements that are computed in each cycle too. Without
    /// any, fast motion of the small elements can resonate with the forces that their neighbours
    /// give now and then.
    pub subcycle_layers: u64,
    /// Let subcycles take elements of parts in contact too. Their forces then act in one of so many
    /// cycles, and contact answers in that one: what rests or slides under load loses friction and
    /// gains energy, the more the more subcycles.
    pub subcycle_contact: bool,
    /// Damping in proportion to mass, for dynamic relaxation: a force `-damping * mass * velocity`
    /// on every node, and the like for rotations [1/time].
    pub damping: f64,
    /// Largest step that is used [time]; 0 for no limit. A model of rigid bodies alone needs one.
    pub dt_max: f64,
}

impl Default for Time {
    fn default() -> Self {
        Self {
            safety: 0.9,
            max_cycles: 0,
            dt_min_ratio: 1e-3,
            mass_scaling_dt: 0.0,
            mass_scaling_limit: 0.1,
            subcycles: 1,
            subcycle_layers: 1,
            subcycle_contact: false,
            damping: 0.0,
            dt_max: 0.0,
        }
    }
}

/// What elements compute with.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Elements {
    /// Precision of the stresses and forces of shells and solids: `double`, or `single`, which
    /// computes twice as many elements at once and keeps half of their state. Nodes, their motion,
    /// masses, contact, beams and springs are in double precision always. See
    /// `cases/studies/README.md`, precision, for what it costs in accuracy.
    pub precision: Precision,
}

/// Length of numbers.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Precision {
    /// 64 bits, 16 digits.
    #[default]
    Double,
    /// 32 bits, 7 digits.
    Single,
}

/// Decomposition and redecomposition.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Parallel {
    /// Workers when run as threads; one per core if left out. `--workers` and mpirun go before it.
    pub workers: usize,
    /// Width b of the buffer that straddles each box face [length]; 0 for the median side of the
    /// elements, four times the smallest at most.
    pub buffer: f64,
    /// Boxes are recomputed when max/mean step cost stays above this.
    pub imbalance: f64,
    /// Least cycles between two recomputations of the boxes.
    pub low_every_at_least: u64,
    /// Force a redecomposition of alternating kind every so many cycles, 0 for never (for tests).
    pub force_every: u64,
}

impl Default for Parallel {
    fn default() -> Self {
        Self { workers: 0, buffer: 0.0, imbalance: 1.1, low_every_at_least: 500, force_every: 0 }
    }
}

/// A material as written: a law's name and its numbers. Laws are known to the worker only.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MaterialSpec {
    /// Name that parts refer to.
    pub name: String,
    /// Name of the law in the worker's table.
    pub law: String,
    /// Mass density [mass/length^3].
    pub density: f64,
    /// Parameters of the law: a number, a list, or a list of lists.
    #[serde(flatten)]
    #[schemars(schema_with = "any_parameters")]
    pub parameters: BTreeMap<String, toml::Value>,
}

/// Any key, with a number, a list, or a list of lists: the job file alone does not tell a law's
/// parameters.
fn any_parameters(_: &mut SchemaGenerator) -> Schema {
    let list = json_schema!({ "type": "array", "items": { "type": "number" } });
    json_schema!({ "type": "object", "additionalProperties": { "anyOf": [
        { "type": "number" }, list, { "type": "array", "items": list }
    ] } })
}

/// A part: elements of one formulation, material and section.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Part {
    /// Id that elements refer to.
    pub id: u32,
    /// Name for people and for `--set part.NAME.key`.
    #[serde(default)]
    pub name: String,
    /// Name of the material; a part of springs has none.
    #[serde(default)]
    pub material: String,
    /// Makes it a part of springs and dampers.
    #[serde(default)]
    pub spring: Option<Spring>,
    /// Makes it a part of beams.
    #[serde(default)]
    pub beam: Option<Beam>,
    /// Shell thickness [length]; a part of solids has none.
    #[serde(default)]
    pub thickness: f64,
    /// Where the middle of shells lies from their nodes along the normal, as a fraction of half the
    /// thickness: 1 if the nodes are on the face that the normal leaves behind, -1 if they are on
    /// the one that it points to, 0 in the middle. Membrane and bending are then coupled. The
    /// stable step is that of shells without offset times `1/sqrt(1 + |e|/sqrt(t^2/12 + e^2))`, e
    /// the distance of the middle from the nodes, or nearer to one where sides are much longer than
    /// the thickness t.
    #[serde(default)]
    pub offset: f64,
    /// Thickness with which its shells are met in contact, in place of their own [length]; an
    /// interface may say another.
    #[serde(default)]
    pub contact_thickness: Option<f64>,
    /// Factor of the thickness with which its shells are met in contact.
    #[serde(default = "one")]
    pub contact_thickness_scale: f64,
    /// Formulation of the four-node shells or the solids. Shells: `stabilised_quad` if left out,
    /// which bends exactly where quads are distorted, takes its hourglass stiffness from material
    /// and shape, and in folds is the nearest to converged forces (`cases/studies/README.md`, crush
    /// and twist-thin); or `belytschko_tsay`, a fifth cheaper, which agrees with it where nothing
    /// folds or twists (plate-shells, panel, beam-shells). `fully_integrated_quad` has 2 x 2 points
    /// in its plane and no hourglass control: the reference for the others, at about two and a half
    /// times the cost. Solids: `hexahedron`.
    #[serde(default)]
    pub element: Option<String>,
    /// Integration points through the thickness, 1 to 10; see `cases/studies/README.md`,
    /// plate-points, beam-shells and panel.
    #[serde(default = "five")]
    pub points: usize,
    /// Hourglass control of `belytschko_tsay` and solids: `stiffness` or `viscous`, for solids also
    /// `assumed_strain`. Without it `stiffness` for shells, `assumed_strain` for solids: it bends
    /// right without a coefficient, and nothing locks as nu comes near 1/2
    /// (`cases/studies/README.md`, hourglass, hourglass-solids, incompressible).
    #[serde(default)]
    pub hourglass: Option<HourglassForm>,
    /// Hourglass coefficient (fraction of the element's own stiffness, or of critical damping);
    /// without it 0.03 for shells and 0.05 for solids. For `stabilised_quad` the least fraction of
    /// its elastic stabilisation that is left in plastic flow. `assumed_strain` and
    /// `fully_integrated_quad` have none. Forces of shells of a plastic law are bounded, whatever
    /// the form. See `cases/studies/README.md`, hourglass and hourglass-solids.
    #[serde(default)]
    pub hourglass_coefficient: Option<f64>,
    /// Bulk viscosity of solids in compression: linear coefficient, a fraction of critical damping,
    /// and quadratic one; without it `[0.06, 1.5]` (`cases/studies/README.md`, viscosity). Shells
    /// have none.
    #[serde(default)]
    pub bulk_viscosity: Option<[f64; 2]>,
    /// Add the Belytschko-Wong-Chiang coupling terms for warped quads to `belytschko_tsay`; they
    /// change little (`cases/studies/README.md`, twist, twist-thin and panel).
    #[serde(default)]
    pub warping: bool,
    /// Makes it a skin: it has mass and touches, but its elements bear nothing and do not limit the
    /// time step.
    #[serde(default)]
    pub skin: bool,
    /// What becomes of a shell that is inverted: without area, or strained by more than a half in
    /// one step. `stop` ends the run and names it; `delete` lets it fail as by a failure strain: it
    /// bears nothing from then on and leaves the contact surface, the work done on it stays in the
    /// internal energy, and a warning names it. Coordinates or forces that are no numbers end the
    /// run in either case, and so does a step that falls below `time.dt_min_ratio` of the first.
    #[serde(default)]
    pub inverted: Inverted,
    /// Update the thickness from the strain through it (`cases/studies/README.md`, panel).
    #[serde(default)]
    pub thinning: bool,
    /// Drilling stiffness as a fraction of the shear stiffness G h A / 4
    /// (`cases/studies/README.md`, twist and twist-thin). In quads of a plastic law its moments are
    /// bounded by a hundredth of the plastic moment of a side.
    #[serde(default = "drilling")]
    pub drilling: f64,
}

fn one() -> f64 {
    1.0
}
fn five() -> usize {
    5
}
fn drilling() -> f64 {
    0.01
}

/// What becomes of an inverted shell.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum Inverted {
    /// The run ends and names it.
    #[default]
    Stop,
    /// It fails and leaves the contact surface.
    Delete,
}

/// Hourglass control of one-point elements.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum HourglassForm {
    /// Elastic resistance that remembers the mode's deformation.
    Stiffness,
    /// Resistance to the mode's rate.
    Viscous,
    /// Solids only: the strains that the modes bring with them, so that bending is right without a
    /// coefficient.
    AssumedStrain,
}

/// Mass added to nodes, shared equally over a node set.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LumpedMass {
    /// Node set.
    pub nodes: String,
    /// Mass of the whole set [mass].
    pub mass: f64,
}

/// Initial velocity of a node set, or of all nodes: rigid motion about a centre.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialVelocity {
    /// Node set; all nodes without it.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Translation [length/time].
    pub velocity: [f64; 3],
    /// Spin [1/time].
    #[serde(default)]
    pub spin: [f64; 3],
    /// Centre of the spin [length].
    #[serde(default)]
    pub centre: [f64; 3],
}

/// Degrees of freedom of a node set that do not move.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fix {
    /// Node set.
    pub nodes: String,
    /// Any of x, y, z (displacements) and rx, ry, rz (rotations).
    pub dofs: Vec<String>,
}
