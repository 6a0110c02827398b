//! Segment to segment contact: pressure from penetration over the area where segments penetrate
//! each other.
//!
//! Where two segments face each other, each pair is a quarter of one over a quarter of the other
//! (`contact/facets.rs`, `contact/overlap.rs`). Its pressure is `p = k_n d` with the depth d.
//! The nodes of both sides get the forces `int p N da` over the common area. This is the
//! kinematic description of mortar methods (Puso & Laursen 2004; for explicit dynamics Yang,
//! Laursen & Meng 2005) with the penalty in place of multipliers, as in Fischer & Wriggers
//! (2005). Both sides are treated equally, without two passes and without half weights.
//!
//! `k_n = k / A` follows from [`super::penalty`] with the area A of the pair, in both of its
//! forms:
//! - *soft*: with nodal masses split among pairs in proportion to their areas, the pair's
//!   compliance is c = (1/A) sum_r N_r A_r/m_r, with the contact area A_r of each node and its
//!   mass m_r. Therefore `k_n = scale / (dt^2 sum_r N_r A_r/m_r)`; it is uniform where the
//!   masses per area are uniform;
//! - *stiffness*: `k_n = scale E / d` of the softer side.
//!
//! Its stability bound holds with these masses. For the springs `k_n A_p b_p b_p^T` of all pairs
//! p, Cauchy's inequality with the fractions `m_r A_p N_pr / A_r` of the masses gives `omega^2
//! <= max_p k_n sum_r N_pr A_r/m_r`. Half of it is kept as reserve, since pressure varies within
//! a pair where the bound assumes one spring. Dashpot, friction and stick point are those of the
//! penalty law, per pair.
//!
//! Nodes and edges that no segment covers, such as the rim of a shell on a face, touch by the
//! penalty law; their area is `contact_thickness^2`.
//!
//! Not included: forces from the change of the area itself, with which a body that slides off an
//! edge while it is pressed down would release the energy of its springs.

use super::penalty::{PARAMETERS, Penalty, no_margin};
use super::{ContactLaw, Iteration, LawRow};
use crate::pairs::Pair;
use crate::surface::Segment;
use crumple_fem::time::StepSizes;
use crumple_math::row::{Row, V3};

pub(super) const LAW: LawRow = LawRow {
    name: "mortar",
    meaning: "Segment to segment penalty: pressure from penetration over the common area of two \
              segments, for any meshes.",
    parameters: PARAMETERS,
    global: &[],
    conflict: no_margin,
    build: |values, parts| Box::new(Mortar(Penalty::new(values, parts))),
};

struct Mortar(Penalty);

impl ContactLaw for Mortar {
    fn sweeps(&self) -> usize {
        self.0.sweeps()
    }

    fn iteration(&self) -> Iteration {
        self.0.iteration()
    }

    fn by_segments(&self) -> bool {
        true
    }

    fn segment_stiffness(&self, segment: &Segment, x0: &[Row]) -> Option<f64> {
        self.0.segment_stiffness(segment, x0)
    }

    fn initial_force(&self, pair: &Pair, steps: StepSizes) -> V3 {
        self.0.initial_force(pair, steps)
    }

    fn update(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> Option<V3> {
        self.0.update(pair, velocity, steps)
    }

    fn slip(&self, pair: &Pair, velocity: &V3, steps: StepSizes) -> V3 {
        self.0.slip(pair, velocity, steps)
    }

    fn is_capped(&self, pair: &Pair, steps: StepSizes) -> bool {
        self.0.is_capped(pair, steps)
    }
}
