//! Optional features of this build, and its commit.

use std::sync::OnceLock;

/// Commit from which the program was built; the program sets it, if it knows it.
pub static COMMIT: OnceLock<&'static str> = OnceLock::new();

/// True if this build can write VTKHDF files.
pub const VTKHDF: bool = cfg!(feature = "vtkhdf");
/// Error message of a build without VTKHDF.
pub const NO_VTKHDF: &str = "this crumple was built without VTKHDF";
/// Advice in this case.
pub const ADD_VTKHDF: &str = "build it with `cargo build --release --features vtkhdf`";
