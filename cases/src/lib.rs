//! The mesh generators that job files name. This crate does not solve the scenes.
//!
//! A scene is a folder next to `src` with a `job.toml`. It has a `mesh.rs` if it needs its own
//! generator. A new generator is one such file and one row of [`GENERATORS`].

mod builder;
pub mod jobs;
mod options;

#[path = "../airbag/mesh.rs"]
mod airbag;
#[path = "../bars/mesh.rs"]
mod bars;
#[path = "../beam/mesh.rs"]
mod beam;
#[path = "../block/mesh.rs"]
mod block;
#[path = "../brick-wall/mesh.rs"]
mod brick_wall;
#[path = "../can-crush/mesh.rs"]
mod can_crush;
#[path = "../corner/mesh.rs"]
mod corner;
#[path = "../drop/mesh.rs"]
mod drop;
#[path = "../drum/mesh.rs"]
mod drum;
#[path = "../hertz/mesh.rs"]
mod hertz;
#[path = "../jeep-frame/mesh.rs"]
mod jeep_frame;
#[path = "../panel/mesh.rs"]
mod panel;
#[path = "../plate/mesh.rs"]
mod plate;
#[path = "../slide/mesh.rs"]
mod slide;
#[path = "../splash/mesh.rs"]
mod splash;
#[path = "../strip/mesh.rs"]
mod strip;
#[path = "../tube/mesh.rs"]
mod tube;
#[path = "../tumble/mesh.rs"]
mod tumble;
#[path = "../twist/mesh.rs"]
mod twist;

#[cfg(test)]
mod tests;

pub use builder::graded;
pub use options::Options;

use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// A job that the program has in itself: `crumple init`.
#[derive(Clone, Copy)]
pub struct Example {
    /// Name of the example.
    pub name: &'static str,
    /// Text of `job.toml`.
    pub job: &'static str,
    /// Name and content of its mesh file; a mesh without one comes from a generator.
    pub mesh: Option<(&'static str, &'static [u8])>,
}

/// All examples.
pub const EXAMPLES: [Example; 8] = [
    Example { name: "bars", job: jobs::BARS, mesh: None },
    Example { name: "tube", job: jobs::TUBE, mesh: None },
    Example { name: "plate", job: jobs::PLATE, mesh: None },
    Example { name: "slide", job: jobs::SLIDE, mesh: None },
    Example { name: "block", job: jobs::BLOCK, mesh: None },
    Example { name: "jeep-frame", job: jobs::JEEP_FRAME, mesh: None },
    Example {
        name: "gmsh-sphere",
        job: jobs::GMSH_SPHERE,
        mesh: Some((
            "plate-and-sphere.msh",
            include_bytes!("../examples/gmsh-sphere/plate-and-sphere.msh"),
        )),
    },
    Example {
        name: "abaqus-beam",
        job: jobs::ABAQUS_BEAM,
        mesh: Some(("box-beam.inp", include_bytes!("../examples/abaqus-beam/box-beam.inp"))),
    },
];

/// An option of a generator: key in `[scene]`, default, meaning with its unit.
pub type OptionRow = (&'static str, f64, &'static str);

/// A mesh generator: name, options and function.
pub struct Generator {
    /// Name in `mesh.generator`.
    pub name: &'static str,
    /// All keys that `[scene]` may have.
    pub options: &'static [OptionRow],
    /// Builds the mesh, or returns all problems of the options.
    pub build: fn(&Options) -> Result<Mesh, Vec<Problem>>,
}

/// All generators.
pub const GENERATORS: &[Generator] = &[
    jeep_frame::GENERATOR,
    airbag::GENERATOR,
    bars::GENERATOR,
    beam::GENERATOR,
    block::GENERATOR,
    brick_wall::GENERATOR,
    can_crush::GENERATOR,
    corner::GENERATOR,
    drop::GENERATOR,
    drum::GENERATOR,
    hertz::GENERATOR,
    panel::GENERATOR,
    plate::GENERATOR,
    slide::GENERATOR,
    splash::GENERATOR,
    strip::GENERATOR,
    tube::GENERATOR,
    tumble::GENERATOR,
    twist::GENERATOR,
];

/// Jobs in the program. The name is the path of the file in `cases` without the parts that all
/// paths have in common.
const JOBS: &[(&str, &str)] = &[
    ("bench/hex-bar", jobs::HEX_BAR),
    ("jeep-frame", jobs::JEEP_FRAME),
    ("tube-crush", jobs::TUBE_CRUSH),
];

/// Returns the text of a job in the program, such as `tube-crush`.
pub fn job(name: &str) -> Option<&'static str> {
    JOBS.iter().find(|j| j.0 == name).map(|j| j.1)
}

/// Builds the mesh of the generator `name` with the options of the job's `[scene]` table.
///
/// Keys that are not in the table keep their defaults. All problems are returned at once.
pub fn generate(name: &str, scene: &toml::Table) -> Result<Mesh, Vec<Problem>> {
    let Some(generator) = GENERATORS.iter().find(|g| g.name == name) else {
        let names: Vec<&str> = GENERATORS.iter().map(|g| g.name).collect();
        return Err(vec![Problem::error(
            "mesh.generator",
            format!("there is no mesh generator `{name}`"),
            options::nearest(name, &names),
        )]);
    };
    let (options, mut problems) = Options::read(generator, scene);
    match (generator.build)(&options) {
        Ok(mesh) if problems.is_empty() => Ok(mesh),
        Ok(_) => Err(problems),
        Err(more) => {
            problems.extend(more);
            Err(problems)
        }
    }
}
