//! Optional features of this build.

/// True if this build can write VTKHDF files.
pub const VTKHDF: bool = cfg!(feature = "vtkhdf");
/// Error message of a build without VTKHDF.
pub const NO_VTKHDF: &str = "this crumple was built without VTKHDF";
/// Advice in this case.
pub const ADD_VTKHDF: &str = "build it with `cargo build --release --features vtkhdf`";
