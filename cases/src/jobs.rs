//! Texts of jobs as constants, for `EXAMPLES`, for benchmarks, and for other packages, which cannot
//! include files of this one.

/// A box beam that is crushed, with a mesh of Abaqus.
pub const ABAQUS_BEAM: &str = include_str!("../examples/abaqus-beam/job.toml");
/// Two bars that collide.
pub const BARS: &str = include_str!("../bars/job.toml");
/// A rubber block between plates.
pub const BLOCK: &str = include_str!("../block/job.toml");
/// A tube of a composite that is crushed.
pub const COMPOSITE_TUBE: &str = include_str!("../composite-tube/job.toml");
/// A sphere that hits a plate, with a mesh of Gmsh.
pub const GMSH_SPHERE: &str = include_str!("../examples/gmsh-sphere/job.toml");
/// A bar of solids, for benchmarks.
pub const HEX_BAR: &str = include_str!("../bench/hex-bar.toml");
/// The frame of a jeep into a wall.
pub const JEEP_FRAME: &str = include_str!("../jeep-frame/job.toml");
/// A clamped plate that bulges.
pub const PLATE: &str = include_str!("../plate/job.toml");
/// A block that slides.
pub const SLIDE: &str = include_str!("../slide/job.toml");
/// A square tube that is crushed.
pub const TUBE: &str = include_str!("../tube/job.toml");
/// A longer tube, for benchmarks.
pub const TUBE_CRUSH: &str = include_str!("../tube-crush/job.toml");
/// Bodies that tumble.
pub const TUMBLE: &str = include_str!("../tumble/job.toml");
