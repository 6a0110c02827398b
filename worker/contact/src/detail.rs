//! Options of the contact detail: the surface that nodes touch, where a new contact is judged,
//! which of several contacts of a node comes first, and the normal at convex edges. The
//! alternatives to the defaults are those of PRONTO3D; Attaway et al. (1998), "Detailed contact
//! check".

use crumple_proto::job::ContactInput;

/// Options of the local search of nodes; all are false by default.
#[derive(Clone, Copy, Debug, Default)]
pub struct ContactDetail {
    /// True if nodes touch the smooth surface.
    pub smooth: bool,
    /// True if a new contact is the first touch of the node and the moving segment.
    pub on_moving_surface: bool,
    /// True if the segment that is most opposed to the node's normal comes first.
    pub by_node_normal: bool,
    /// True if a node that comes over a convex edge of a solid is pushed back along the normal of
    /// the face from which it came.
    pub along_last_face: bool,
}

impl ContactDetail {
    /// Returns the options of a job.
    pub fn new(job: &ContactInput) -> Self {
        Self {
            smooth: is_smooth(job),
            on_moving_surface: job.impact == "moving_surface",
            by_node_normal: job.choice == "node_normal",
            along_last_face: job.push_back == "last_face",
        }
    }

    /// Returns true if an option changes the point or the normal of pairs.
    pub fn is_set(&self) -> bool {
        self.on_moving_surface || self.along_last_face
    }
}

/// Returns true if nodes touch the smooth surface.
pub fn is_smooth(job: &ContactInput) -> bool {
    job.surface == "smooth"
}
