//! The job as it is written in `job.toml`: plain data. The master reads and checks it.

mod adaptivity;
mod added_mesh;
mod airbag;
mod beam;
mod belt;
mod checkpoint;
mod contact;
mod discrete_beam;
mod failure_group;
mod joint;
mod loads;
mod output;
mod part_ref;
mod particles;
mod require;
mod restart;
mod rigid;
mod set;
mod setting;
mod spring;
mod tie;
mod truss;
mod wall;

pub use adaptivity::AdaptivityInput;
pub use added_mesh::{AddedMeshInput, RotationInput};
pub use airbag::{AirbagInput, InflowInput, VentInput};
pub use beam::{BeamInput, BeamSection, Weld};
pub use belt::{
    BeltInput, BeltSensorInput, BeltsInput, PretensionerInput, RetractorInput, SlipRingInput,
};
pub use checkpoint::{Checkpoint, Compression};
pub use contact::{ContactInput, Interface};
pub use discrete_beam::{
    AxisSpring, BeamAxis, BeamFailure, BetweenCurvesSpring, DiscreteBeamInput, PermanentSetSpring,
    TurningNode, YieldingSpring,
};
pub use failure_group::FailureGroupInput;
pub use joint::{JointInput, JointKind, JointResistance};
pub use loads::{
    BlastInput, Burst, CurveInput, DampingInput, GravityInput, LoadInput, MotionInput,
    NonReflectingInput, PressureInput, Symmetry,
};
pub use output::{NodeHistory, Output, SectionHistory, TransducerHistory};
pub use part_ref::PartRef;
pub use particles::ParticlesInput;
pub use require::{
    ElementReduction, FilterClass, ObjectTable, Quantity, Requirement, RowReduction,
};
pub use restart::{PartVelocity, Restart};
pub use rigid::{Rigid, RigidLoad, RigidStop};
pub use set::{SetInput, SetRule};
pub use setting::Setting;
pub use spring::{
    ElastoplasticSpring, HysteresisSpring, MaxwellSpring, OneSidedSpring, SpringHardening,
    SpringInput, SpringSide,
};
pub use tie::{TieFailureInput, TieInput, TieLimits};
pub use truss::TrussInput;
pub use wall::WallInput;

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Complete job file.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Job {
    /// Title of the job, one line.
    #[serde(default)]
    pub title: String,
    /// Consistent set of units, as a note for readers; the engine is unit-free.
    #[serde(default)]
    pub units: String,
    /// Job files whose keys are merged below those of this one, such as `["parts.toml"]`. Paths are
    /// relative to the folder of the file that includes.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub include: Vec<String>,
    /// Simulated time at which the run ends [time].
    pub end_time: f64,
    /// Keys whose values are placeholders, such as `part.plate.thickness`: `crumple import` writes
    /// them for values that a mesh file does not have. `crumple check` and `crumple run` warn of
    /// each. Set the value, then remove the key from this list.
    #[serde(default)]
    pub placeholders: Vec<String>,
    /// Source of the mesh: exactly one of `generator`, `file`, `deck`, `exodus`, or `nodes` with
    /// `shells`, `solids`, `beams`, `springs`, `trusses` or `particles`. `[[mesh.add]]` adds
    /// further mesh files.
    pub mesh: MeshSource,
    /// Options of the mesh generator.
    #[serde(default)]
    #[schemars(with = "BTreeMap<String, serde_json::Value>")]
    pub scene: toml::Table,
    /// Node sets by rule.
    #[serde(default)]
    pub set: Vec<SetInput>,
    /// Settings of the time step.
    #[serde(default)]
    pub time: Time,
    /// Settings of all elements.
    #[serde(default)]
    pub elements: Elements,
    /// Division of shells where they bend. Without this table the mesh stays as it is.
    #[serde(default)]
    pub adaptivity: Option<AdaptivityInput>,
    /// Files that are written, and their intervals.
    #[serde(default)]
    pub output: Output,
    /// Decomposition and redecomposition.
    #[serde(default)]
    pub parallel: Parallel,
    /// Checkpoints.
    #[serde(default)]
    pub checkpoint: Checkpoint,
    /// Changes when a run continues.
    #[serde(default)]
    pub restart: Restart,
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
    pub wall: Vec<WallInput>,
    /// Initial velocities; a later entry overrides an earlier one.
    #[serde(default)]
    pub initial_velocity: Vec<InitialVelocity>,
    /// Fixed degrees of freedom.
    #[serde(default)]
    pub fix: Vec<Fix>,
    /// Planes of symmetry.
    #[serde(default)]
    pub symmetry: Vec<Symmetry>,
    /// Factors as functions of time, for loads and motions.
    #[serde(default)]
    pub curve: Vec<CurveInput>,
    /// Gravity and other body forces; all entries are added.
    #[serde(default)]
    pub gravity: Vec<GravityInput>,
    /// Damping of parts in proportion to their masses; all entries are added.
    #[serde(default)]
    pub damping: Vec<DampingInput>,
    /// Forces on node sets; all entries are added.
    #[serde(default)]
    pub load: Vec<LoadInput>,
    /// Pressures on faces; all entries are added.
    #[serde(default)]
    pub pressure: Vec<PressureInput>,
    /// Boundaries that let waves out; all entries are added.
    #[serde(default)]
    pub non_reflecting: Vec<NonReflectingInput>,
    /// Airbags.
    #[serde(default)]
    pub airbag: Vec<AirbagInput>,
    /// Rings, retractors, pretensioners and sensors of seat belts.
    #[serde(default)]
    pub belts: BeltsInput,
    /// Rigid bodies.
    #[serde(default)]
    pub rigid: Vec<Rigid>,
    /// Joints between rigid bodies.
    #[serde(default)]
    pub joint: Vec<JointInput>,
    /// Solids that fail together.
    #[serde(default)]
    pub failure_group: Vec<FailureGroupInput>,
    /// Nodes tied to surfaces.
    #[serde(default)]
    pub tie: Vec<TieInput>,
    /// Prescribed motions of node sets and rigid bodies.
    #[serde(default)]
    pub motion: Vec<MotionInput>,
    /// Requirements on the results.
    #[serde(default)]
    pub require: Vec<Requirement>,
    /// Contact. Without this table there is no contact, only rigid walls. It may be written as a
    /// list `[[contact]]`: the first entry is this table, each further entry is a
    /// `[[contact.interface]]`.
    #[serde(default)]
    pub contact: Option<ContactInput>,
}

impl Job {
    /// Returns the JSON Schema of a job: every key, its type, default and meaning. The reader
    /// checks files against it.
    pub fn schema() -> serde_json::Value {
        schemars::schema_for!(Job).to_value()
    }
}

/// Source of the mesh: exactly one of `generator`, `file`, `deck`, `exodus`, or `nodes` with
/// `shells`, `solids`, `beams`, `springs`, `trusses` or `particles`. `[[mesh.add]]` adds further
/// mesh files.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct MeshSource {
    /// Name of a generator of the `cases` crate; its options are in `[scene]`.
    #[serde(default)]
    pub generator: Option<String>,
    /// Mesh file in the folder of the job: Gmsh MSH, Abaqus input, Nastran bulk data, VTK (XML and
    /// legacy), STL, EXODUS II or a Radioss starter file, recognised by its content; or a TOML file
    /// with `nodes`, `shells`, `solids`, `beams`, `springs`, `trusses`, `particles` and `node_sets`
    /// as below. Its parts and node sets are listed by `crumple import`, which writes a job for it.
    #[serde(default)]
    pub file: Option<String>,
    /// LS-DYNA keyword deck, or Radioss starter file, in the folder of the job: mesh, node sets,
    /// parts, materials and all other supported keywords. Keys of the job override those of the
    /// deck. An entry of a list in the job is merged with the entry of the deck that has the same
    /// id or name; otherwise it is added.
    #[serde(default)]
    pub deck: Option<String>,
    /// GENESIS or EXODUS II file in the folder of the job: nodes, element blocks, node sets and
    /// side sets. A block is a part: its id is that of `[[part]]`. A side set becomes the set of
    /// its nodes. Sets without a name are `nodeset_ID` and `sideset_ID`.
    #[serde(default)]
    pub exodus: Option<String>,
    /// Keywords of the deck that are not read, such as `DEFORMABLE_TO_RIGID`.
    #[serde(default)]
    pub leave_out: Vec<String>,
    /// Case of the deck that is read (`*CASE`, `*CASE_BEGIN_n`); needed if it has several.
    #[serde(default)]
    pub case: Option<u64>,
    /// Ignore unsupported content of the deck or the mesh files. Without it, unsupported content is
    /// an error.
    #[serde(default)]
    pub allow_unsupported: bool,
    /// Nodes as `[id, x, y, z]` [length].
    #[serde(default)]
    pub nodes: Vec<[f64; 4]>,
    /// Shells as `[id, part id, n1, n2, n3, n4]`; a triangle has three nodes.
    #[serde(default)]
    pub shells: Vec<Vec<u64>>,
    /// Solids as `[id, part id, n1, ..., n8]`: the four nodes of a face whose right-hand normal
    /// points into the solid, then the four opposite nodes. A wedge has six nodes: those of a
    /// triangle, then those of the opposite one. A tetrahedron has four, or ten: then follow those
    /// on the edges 1-2, 2-3, 3-1, 1-4, 2-4, 3-4.
    #[serde(default)]
    pub solids: Vec<Vec<u64>>,
    /// Beams as `[id, part id, n1, n2, n3]`. The second axis of the section points from the line n1
    /// n2 towards n3. Node n3 need not belong to an element.
    #[serde(default)]
    pub beams: Vec<Vec<u64>>,
    /// Springs, dampers, discrete beams and seat belts as `[id, part id, n1, n2]`.
    #[serde(default)]
    pub springs: Vec<Vec<u64>>,
    /// Trusses as `[id, part id, n1, n2]`.
    #[serde(default)]
    pub trusses: Vec<Vec<u64>>,
    /// Particles as `[id, part id, n1]`; no other element has their nodes.
    #[serde(default)]
    pub particles: Vec<Vec<u64>>,
    /// Thicknesses of single shells as `[id, thickness]` [length]; all other shells have the
    /// thickness of their part. This also applies to shells of a generator or a deck. A mesh file
    /// has its own list.
    #[serde(default)]
    pub thicknesses: Vec<[f64; 2]>,
    /// Offsets of single shells as `[id, offset]`, over half the thickness as `part.offset`; all
    /// other shells have the offset of their part. This also applies to shells of a generator or a
    /// deck. A mesh file has its own list.
    #[serde(default)]
    pub offsets: Vec<[f64; 2]>,
    /// Angles of single shells as `[id, angle]`, about the normal [degrees], by which the axis a of
    /// their material is turned at the start, in addition to that of the material and the layer.
    /// This also applies to shells of a generator or a deck. A mesh file has its own list.
    #[serde(default)]
    pub angles: Vec<[f64; 2]>,
    /// Stresses of shells and solids at the start, a row for each given point: `[element, point,
    /// position, xx, yy, zz, xy, yz, zx, plastic strain]`. The point is 1, or the number of one of
    /// several in the plane of a shell or in a solid; the position of a point of a shell is its
    /// place over half the thickness, -1 inside to 1 outside, and 0 in solids. The stress is that
    /// in global axes [force/length^2]. The points may be others than those of the element: a
    /// shell takes values between them, a solid their mean. All other history of the material, the
    /// internal energy and hourglass forces are 0 at the start. Laws whose stress follows from the
    /// whole deformation take none. This also applies to elements of a generator or a deck. A mesh
    /// file has its own list.
    #[serde(default)]
    pub stresses: Vec<[f64; 10]>,
    /// Named sets of node ids. With a deck or a mesh file of another program, they are added to its
    /// sets.
    #[serde(default)]
    pub node_sets: BTreeMap<String, Vec<u64>>,
    /// Mesh files that are added to this mesh, `[[mesh.add]]` for each.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub add: Vec<AddedMeshInput>,
}

/// Settings of the time step.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Time {
    /// Safety factor: fraction of the smallest stable step of the elements that is used; see
    /// `cases/studies/README.md`, penalty-map.
    pub safety: f64,
    /// Number of cycles after which the run stops; 0 for no limit.
    pub max_cycles: u64,
    /// Smallest permitted ratio of the step to the first step. The run fails below it.
    pub dt_min_ratio: f64,
    /// Smallest stable step that mass scaling ensures at the start, before `safety` [time]. Mass is
    /// added to elements with a smaller one. 0 for no mass scaling.
    pub mass_scaling_dt: f64,
    /// Largest mass that mass scaling may add, as a fraction of the mass of the structure. A job
    /// that needs more is rejected.
    pub mass_scaling_limit: f64,
    /// Number m of cycles in an outer step. Elements whose stable step at the start is at least m
    /// times the smallest one are computed in one of m cycles, all others in every cycle. 1 for no
    /// subcycles. Elements of parts in contact are computed in every cycle, see `subcycle_contact`.
    pub subcycles: u64,
    /// Number of layers of neighbours around the small elements that are also computed in every
    /// cycle. Without such layers, fast motion of the small elements can resonate with the
    /// intermittent forces of their neighbours.
    pub subcycle_layers: u64,
    /// Also apply subcycles to elements of parts in contact. Their forces then act in one of m
    /// cycles, and contact reacts in that cycle. A body that rests or slides under load then loses
    /// friction and gains energy; the effect grows with `subcycles`.
    pub subcycle_contact: bool,
    /// Coefficient of mass-proportional damping, for dynamic relaxation: a force
    /// `-damping * mass * velocity` on every node, and the corresponding moment [1/time].
    pub damping: f64,
    /// Name of a curve: factor [1] over time on `damping`. Without one it is 1.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub damping_curve: Option<String>,
    /// Largest step [time]; 0 for no limit. A model of rigid bodies alone needs one.
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
            damping_curve: None,
            dt_max: 0.0,
        }
    }
}

/// Settings of all elements.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Elements {
    /// Floating-point precision of the stresses and forces of shells and solids: `double` or
    /// `single`. `single` computes twice as many elements at once and halves the size of their
    /// state. Nodes, their motion and masses, contact, beams, trusses, springs and particles are
    /// always in double precision. For the loss of accuracy see `cases/studies/README.md`,
    /// precision.
    pub precision: Precision,
}

/// Floating-point precision.
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
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub struct Parallel {
    /// Number of workers when they are threads; 0 for one per core, or per `threads` cores.
    /// `--workers` and mpirun override it.
    pub workers: usize,
    /// Settings of the decomposition, by key. The worker publishes the keys.
    #[serde(flatten)]
    #[schemars(skip)]
    pub parameters: BTreeMap<String, Setting>,
}

/// Material: name of a law and its parameters.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
pub struct MaterialSpec {
    /// Name that parts refer to.
    pub name: String,
    /// Name of a material of the library, which `crumple materials` lists. It gives the law and all
    /// values, in the units of the job; keys of the job replace them.
    #[serde(default, rename = "use", skip_serializing_if = "Option::is_none")]
    pub library: Option<String>,
    /// Name of the material law.
    pub law: String,
    /// Mass density [mass/length^3].
    pub density: f64,
    /// Parameters of the law: a number, true or false, a list, or a list of lists.
    #[serde(flatten)]
    #[schemars(schema_with = "any_parameters")]
    pub parameters: BTreeMap<String, toml::Value>,
}

/// Returns the schema of any key whose value is a number, true or false, a list, or a list of
/// lists. The parameters of a law are not part of this schema.
fn any_parameters(_: &mut SchemaGenerator) -> Schema {
    let list = json_schema!({ "type": "array", "items": { "type": "number" } });
    json_schema!({ "type": "object", "additionalProperties": { "anyOf": [
        { "type": "number" }, { "type": "boolean" }, list, { "type": "array", "items": list }
    ] } })
}

/// Part: elements of one formulation, material and section.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[schemars(deny_unknown_fields)]
pub struct Part {
    /// Id that elements refer to.
    pub id: u32,
    /// Name in messages, in results and for `--set part.NAME.key`.
    #[serde(default)]
    pub name: String,
    /// Name of the material. A part of springs, belts, discrete beams or particles has none.
    #[serde(default)]
    pub material: String,
    /// Makes this a part of springs and dampers.
    #[serde(default)]
    pub spring: Option<SpringInput>,
    /// Makes this a part of seat belts.
    #[serde(default)]
    pub belt: Option<BeltInput>,
    /// Makes this a part of beams.
    #[serde(default)]
    pub beam: Option<BeamInput>,
    /// Makes this a part of trusses.
    #[serde(default)]
    pub truss: Option<TrussInput>,
    /// Makes this a part of discrete beams.
    #[serde(default)]
    pub discrete_beam: Option<DiscreteBeamInput>,
    /// Makes this a part of particles of a fluid.
    #[serde(default)]
    pub particles: Option<ParticlesInput>,
    /// Shell thickness [length]. A part of solids has none; that of a part with layers follows from
    /// them.
    #[serde(default)]
    pub thickness: f64,
    /// Layers of its shells, from the inner surface to the outer one, to which the normal points.
    /// A part with layers has no `thickness` of its own.
    #[serde(default)]
    pub layer: Vec<LayerInput>,
    /// Angles of the axis a of the material at the points through the thickness, from the inner
    /// surface to the outer one, in addition to that of the material [degrees]. Their number is
    /// `points`. Layers have angles of their own.
    #[serde(default)]
    pub angles: Vec<f64>,
    /// Shell offset: distance from the nodes to the middle surface along the normal, as a fraction
    /// of half the thickness. 1 if the nodes are on the bottom face, from which the normal points
    /// into the shell; -1 if they are on the top face; 0 if they are on the middle surface. An
    /// offset couples membrane and bending. It multiplies the stable step by
    /// `1/sqrt(1 + |e|/sqrt(t^2/12 + e^2))`, where e is the distance from the nodes to the middle
    /// surface and t the thickness. The factor is closer to 1 if sides are much longer than t.
    #[serde(default)]
    pub offset: f64,
    /// Contact thickness of its shells [length]; without it their own thickness. An interface can
    /// override it.
    #[serde(default)]
    pub contact_thickness: Option<f64>,
    /// Factor on the thickness of its shells in contact.
    #[serde(default = "one")]
    pub contact_thickness_scale: f64,
    /// Formulation of the four-node shells or of the solids. Shells: `stabilised_quad` (default),
    /// `belytschko_tsay` or `fully_integrated_quad`. Solids: `hexahedron` (default); other
    /// solids have one formulation each.
    /// `stabilised_quad` bends exactly in distorted quads and takes its hourglass stiffness from
    /// material and shape. In folds it is closest to converged forces (`cases/studies/README.md`,
    /// crush and twist-thin). `belytschko_tsay` is a fifth cheaper and agrees with it where the
    /// shell neither folds nor twists (plate-shells, panel, beam-shells). `fully_integrated_quad`
    /// has 2 x 2 points in its plane and no hourglass control. It is the reference for the others,
    /// at about two and a half times the cost.
    #[serde(default)]
    pub element: Option<String>,
    /// Make this part a skin. It has mass and takes part in contact. Its elements have no forces
    /// and do not limit the time step.
    #[serde(default)]
    pub skin: bool,
    /// Settings of its elements, by key. Each formulation publishes the keys that it uses.
    #[serde(flatten)]
    #[schemars(skip)]
    pub parameters: BTreeMap<String, Setting>,
}

/// Layer of a part of shells.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LayerInput {
    /// Thickness of the layer [length].
    pub thickness: f64,
    /// Name of its material; without it that of the part.
    #[serde(default)]
    pub material: String,
    /// Angle about the normal by which the axis a of its material is turned from that of the
    /// material [degrees].
    #[serde(default)]
    pub angle: f64,
    /// Number of Gauss points through the layer, 1 to 10. Two give linear bending exactly. All
    /// layers together have at most 40.
    #[serde(default = "two")]
    pub points: usize,
}

fn one() -> f64 {
    1.0
}

fn two() -> usize {
    2
}

impl Part {
    /// Returns the id in messages, with the name if there is one.
    pub fn label(&self) -> String {
        if self.name.is_empty() {
            self.id.to_string()
        } else {
            format!("{} ({})", self.id, self.name)
        }
    }

    /// Returns the names of the materials of its elements, each once: that of the part, or those of
    /// its layers.
    pub fn materials(&self) -> Vec<&str> {
        let own = std::iter::once(self.material.as_str()).filter(|_| self.layer.is_empty());
        let of_layers = self.layer.iter().map(|layer| match layer.material.as_str() {
            "" => self.material.as_str(),
            of_layer => of_layer,
        });
        let mut names: Vec<&str> = Vec::new();
        for name in own.chain(of_layers) {
            if !names.contains(&name) {
                names.push(name);
            }
        }
        names
    }

    /// Returns the same part with a key of its elements set to `value`.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Into<Setting>) -> Self {
        self.parameters.insert(key.into(), value.into());
        self
    }
}

/// Mass added to the nodes of a set, in equal shares.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LumpedMass {
    /// Node set.
    pub nodes: String,
    /// Mass added to the whole set [mass].
    pub mass: f64,
}

/// Initial velocity of a node set, or of all nodes: a rigid motion about a centre.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InitialVelocity {
    /// Node set; without it all nodes.
    #[serde(default)]
    pub nodes: Option<String>,
    /// Translational velocity [length/time].
    pub velocity: [f64; 3],
    /// Rotational velocity about the centre [1/time].
    #[serde(default)]
    pub spin: [f64; 3],
    /// Centre of rotation [length].
    #[serde(default)]
    pub centre: [f64; 3],
}

/// Fixed degrees of freedom of a node set.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Fix {
    /// Node set.
    pub nodes: String,
    /// Fixed degrees of freedom: any of x, y, z (displacements) and rx, ry, rz (rotations).
    pub dofs: Vec<String>,
}
