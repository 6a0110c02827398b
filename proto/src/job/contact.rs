//! Contact and its interfaces, as they are written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Automatic single-surface contact of all parts, or of some, and interfaces with numbers of their
/// own.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Contact {
    /// Name for people.
    pub name: String,
    /// Name of the law in the worker's table: `lagrange`, `kinematic`, `penalty` or `mortar`. The
    /// first three hold where contact is strong (`cases/studies/README.md`, tube, corner, tumble);
    /// for contact stresses take one of the first two (hertz), or `mortar` where the meshes of two
    /// faces do not match (`tests/VERIFICATION.md`, A22). With `none` only the parts of interfaces
    /// touch.
    pub law: String,
    /// Static coefficient of Coulomb friction.
    pub friction: f64,
    /// Dynamic coefficient of friction: at the sliding speed v it is `d + (friction - d)
    /// exp(-friction_decay v)`; as `friction` if left out.
    pub friction_dynamic: Option<f64>,
    /// How fast friction decays with the sliding speed [time/length].
    pub friction_decay: f64,
    /// Largest shear stress of friction [force/length^2]; none if left out or 0. Where the normal
    /// pressure on a node, the mean of about ten steps, is above this by the coefficient of
    /// friction, the coefficient is this by the pressure. Edges on edges and lines of beams have no
    /// area and are not limited.
    pub friction_limit: Option<f64>,
    /// Time from which there is contact [time].
    pub birth: f64,
    /// Time at which contact ends [time]; never if left out. Before birth and after death its parts
    /// do not touch, not by an earlier interface either.
    pub death: Option<f64>,
    /// Thickness with which all shells and beams are met, in place of their own [length];
    /// `thickness_limit` does not bound it.
    pub thickness: Option<f64>,
    /// Factor of the thickness with which shells and beams are met.
    pub thickness_scale: f64,
    /// Global search: `cells` (linked cells) or `boxes` (point in box by sorted lists).
    pub search: String,
    /// Distance that candidates reach beyond contact, so that the search need not run every step
    /// [length]; 0 for a quarter of the median element side, or 0.4 of the largest thickness if
    /// that is more, but a side at most. It changes how long a search takes and how often one is
    /// made, no bit of the motion, and which parts count as near.
    pub skin: f64,
    /// How the forces of pairs that feel each other are brought into agreement (Lagrange):
    /// `gauss_seidel`, one after the other in ascending order of their names, the default
    /// (`cases/studies/README.md`, sandwich); `split`, all from the same state with nodal masses
    /// split among their pairs, which needs more sweeps.
    pub iteration: String,
    /// Most sweeps over all pairs within a step (Lagrange), most passes (kinematic; 1 as in
    /// PRONTO3D) before `accelerated` ones.
    pub sweeps: usize,
    /// Most accelerated sweeps after these in steps for which they are too few (they leave more
    /// than 1e-4 of what a force is there to do), as with layers below a hundredth of their
    /// neighbours' mass; 0 for none. None follow a single sweep (Lagrange); see
    /// `cases/studies/README.md`, sandwich.
    pub accelerated: usize,
    /// Velocity that a pair's force may leave unchanged, over the velocity that it is there to
    /// change (Lagrange); relative change below which the force is left as it is (kinematic); see
    /// `cases/studies/README.md`, bars.
    pub tolerance: f64,
    /// How a contact force is shared among a segment's nodes: `shape` (N_k) or `mass` (m_k/M2 of
    /// Wang 2007, eq. 7), which keeps no angular momentum where the masses of a segment differ
    /// (Lagrange); see `cases/studies/README.md`, hertz and tumble.
    pub weighting: String,
    /// Fraction beta of the correction that the surface of the lower part (within a part, of the
    /// lower element) takes as slave of the other, which takes the rest as slave of the first;
    /// pairs whose surfaces are not slaves of each other are not partitioned (kinematic). See
    /// `cases/studies/README.md`, bars-solids.
    pub partition: f64,
    /// Stiffness of the penalty (penalty; mortar, where it is that of a pressure): `soft`, from
    /// nodal masses and the step; `stiffness`, from the segment's Young's modulus and area, E A / d
    /// with a solid's shortest edge or a shell's longest diagonal d. See `cases/studies/README.md`,
    /// reversal and hertz.
    pub penalty_form: String,
    /// Scale of the penalty stiffness, of either form (penalty, mortar); see
    /// `cases/studies/README.md`, bars, reversal and penalty-map.
    pub penalty_scale: f64,
    /// Normal damping of the penalty, as a fraction of the critical damping of the masses that meet
    /// (penalty, mortar). Without it what slides on springs chatters and feels too little friction
    /// (`cases/studies/README.md`, slide); an impact of bars loses as much with 0.1 as with the
    /// Lagrange law.
    pub penalty_damping: f64,
    /// Lower penalty stiffness where it would make the step unstable, and say so (penalty, mortar).
    /// Without it a run may blow up (`cases/studies/README.md`, penalty-map).
    pub penalty_cap: bool,
    /// Whether edges meet edges too: free ones of shells, folds, and sharp ones of solids. Without
    /// it they pass each other between their nodes (`tests/VERIFICATION.md`, C04).
    pub edges: bool,
    /// Whether beams take part, as lines with a radius (`part.beam.contact_radius`): they meet each
    /// other and the edges of shells and solids along their length, and nodes meet them all along.
    /// As `edges` if left out. Without it other things pass through them.
    pub beams: Option<bool>,
    /// Largest thickness with which a shell is met, as a multiple of its shortest side, or a beam,
    /// as a multiple of its length; 0 for no limit. Shells finer than they are thick would touch
    /// what stands at an angle to them round a corner, from the start and at great cost
    /// (`cases/bench/RESULTS.md`).
    pub thickness_limit: f64,
    /// Parts that meet those of `against`, or each other and themselves without it; all parts if
    /// empty.
    pub parts: Vec<u32>,
    /// Parts that those of `parts` meet; they do not meet each other here.
    pub against: Vec<u32>,
    /// Parts that touch none but by an interface.
    pub exclude: Vec<u32>,
    /// Interfaces: which parts touch otherwise than said above, or not at all. The last one that
    /// names a pair of parts holds for it.
    pub interface: Vec<Interface>,
}

/// An interface: contact between some parts, with numbers of its own. What it does not say is as in
/// `[contact]`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Interface {
    /// Name for people and for `--set contact.interface.NAME.key`.
    pub name: String,
    /// Parts that meet those of `against`, or each other and themselves without it; all parts if
    /// empty.
    pub parts: Vec<u32>,
    /// Parts that those of `parts` meet; they do not meet each other here.
    pub against: Vec<u32>,
    /// Parts that have nothing to do with this interface.
    pub exclude: Vec<u32>,
    /// As in `[contact]`, `lagrange` where that says `none`; `none` keeps these parts from
    /// touching.
    pub law: Option<String>,
    /// As in `[contact]`. With another `friction` and neither this nor `friction_dynamic`, friction
    /// is the same at all speeds.
    pub friction: Option<f64>,
    /// As in `[contact]`.
    pub friction_dynamic: Option<f64>,
    /// As in `[contact]` [time/length].
    pub friction_decay: Option<f64>,
    /// As in `[contact]` [force/length^2].
    pub friction_limit: Option<f64>,
    /// As in `[contact]` [time].
    pub birth: Option<f64>,
    /// As in `[contact]` [time].
    pub death: Option<f64>,
    /// As in `[contact]` [length].
    pub thickness: Option<f64>,
    /// As in `[contact]`.
    pub thickness_scale: Option<f64>,
    /// As in `[contact]`.
    pub iteration: Option<String>,
    /// As in `[contact]`.
    pub sweeps: Option<usize>,
    /// As in `[contact]`.
    pub tolerance: Option<f64>,
    /// As in `[contact]`.
    pub partition: Option<f64>,
    /// As in `[contact]`.
    pub penalty_form: Option<String>,
    /// As in `[contact]`.
    pub penalty_scale: Option<f64>,
    /// As in `[contact]`.
    pub penalty_damping: Option<f64>,
    /// As in `[contact]`.
    pub penalty_cap: Option<bool>,
    /// As in `[contact]`. An interface without beams says nothing of them: what an earlier one says
    /// holds.
    pub beams: Option<bool>,
}

impl Contact {
    /// Law that lets nothing touch.
    pub const NO_LAW: &str = "none";

    /// The numbers of one of its interfaces.
    pub fn of(&self, interface: &Interface) -> Self {
        let Interface {
            name,
            parts,
            against,
            exclude,
            law,
            friction,
            friction_dynamic,
            friction_decay,
            friction_limit,
            birth,
            death,
            thickness,
            thickness_scale,
            iteration,
            sweeps,
            tolerance,
            partition,
            penalty_form,
            penalty_scale,
            penalty_damping,
            penalty_cap,
            beams,
        } = interface.clone();
        let default = Self::default().law;
        let of_all = if self.law == Self::NO_LAW { &default } else { &self.law };
        let dynamic = if friction.is_some() {
            friction_dynamic
        } else {
            friction_dynamic.or(self.friction_dynamic)
        };
        Self {
            name,
            law: law.unwrap_or_else(|| of_all.clone()),
            friction: friction.unwrap_or(self.friction),
            friction_dynamic: dynamic,
            friction_decay: friction_decay.unwrap_or(self.friction_decay),
            friction_limit: friction_limit.or(self.friction_limit),
            birth: birth.unwrap_or(self.birth),
            death: death.or(self.death),
            thickness: thickness.or(self.thickness.filter(|_| thickness_scale.is_none())),
            thickness_scale: thickness_scale.unwrap_or(self.thickness_scale),
            iteration: iteration.unwrap_or_else(|| self.iteration.clone()),
            sweeps: sweeps.unwrap_or(self.sweeps),
            tolerance: tolerance.unwrap_or(self.tolerance),
            partition: partition.unwrap_or(self.partition),
            penalty_form: penalty_form.unwrap_or_else(|| self.penalty_form.clone()),
            penalty_scale: penalty_scale.unwrap_or(self.penalty_scale),
            penalty_damping: penalty_damping.unwrap_or(self.penalty_damping),
            penalty_cap: penalty_cap.unwrap_or(self.penalty_cap),
            search: self.search.clone(),
            skin: self.skin,
            weighting: self.weighting.clone(),
            accelerated: self.accelerated,
            edges: self.edges,
            beams: beams.or(self.beams),
            thickness_limit: self.thickness_limit,
            parts,
            against,
            exclude,
            interface: Vec::new(),
        }
    }

    /// What it says itself, and its interfaces, in their order.
    pub fn each(&self) -> impl Iterator<Item = Self> + '_ {
        let own = Self { interface: Vec::new(), ..self.clone() };
        std::iter::once(own).chain(self.interface.iter().map(|i| self.of(i)))
    }

    /// Which parts, by their places in `ids`, meet which others by what it says itself, its
    /// interfaces left out.
    pub fn sides(&self, ids: &[u32]) -> [Vec<usize>; 2] {
        let named = |list: &[u32], id: u32| list.is_empty() || list.contains(&id);
        let against = if self.against.is_empty() { &self.parts } else { &self.against };
        let side = |list: &[u32]| {
            let is_in = |&(_, &id): &(usize, &u32)| named(list, id) && !self.exclude.contains(&id);
            ids.iter().enumerate().filter(is_in).map(|(place, _)| place).collect()
        };
        [side(&self.parts), side(against)]
    }

    /// Whether beams take part by what it says itself.
    pub fn has_beams(&self) -> bool {
        self.beams.unwrap_or(self.edges)
    }

    /// Whether a part takes part, by itself or by one of its interfaces.
    pub fn takes_part(&self, part: u32) -> bool {
        let named =
            |c: &Self| c.parts.is_empty() || c.parts.contains(&part) || c.against.contains(&part);
        self.each().any(|c| c.law != Self::NO_LAW && named(&c) && !c.exclude.contains(&part))
    }
}

impl Default for Contact {
    fn default() -> Self {
        Self {
            name: String::new(),
            law: "lagrange".into(),
            friction: 0.0,
            friction_dynamic: None,
            friction_decay: 0.0,
            friction_limit: None,
            birth: 0.0,
            death: None,
            thickness: None,
            thickness_scale: 1.0,
            search: "cells".into(),
            skin: 0.0,
            iteration: "gauss_seidel".into(),
            sweeps: 20,
            accelerated: 100,
            tolerance: 1e-6,
            weighting: "shape".into(),
            partition: 0.5,
            penalty_form: "soft".into(),
            penalty_scale: 0.35,
            penalty_damping: 0.1,
            penalty_cap: true,
            edges: true,
            beams: None,
            thickness_limit: 1.0,
            parts: Vec::new(),
            against: Vec::new(),
            exclude: Vec::new(),
            interface: Vec::new(),
        }
    }
}
