//! Contact and its interfaces, as they are written.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// Automatic single-surface contact of all parts or of some parts, and interfaces with their own
/// settings.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Contact {
    /// Name in messages.
    pub name: String,
    /// Contact law: `lagrange`, `kinematic`, `penalty`, `mortar` or `none`. The first three are
    /// robust in severe contact (`cases/studies/README.md`, tube, corner, tumble). For contact
    /// stresses use `lagrange` or `kinematic` (hertz), or `mortar` if the meshes of two faces do
    /// not match (`tests/VERIFICATION.md`, A22). With `none` only the parts of interfaces are in
    /// contact.
    pub law: String,
    /// Static coefficient of Coulomb friction.
    pub friction: f64,
    /// Dynamic coefficient d of friction: at the sliding speed v the coefficient is
    /// `d + (friction - d) exp(-friction_decay v)`. Without it, as `friction`.
    pub friction_dynamic: Option<f64>,
    /// Decay constant of friction with the sliding speed [time/length].
    pub friction_decay: f64,
    /// Largest shear stress of friction [force/length^2]; without it, or with 0, no limit. It is
    /// compared with the coefficient of friction times the normal pressure on a node, a mean over
    /// about ten steps. If this product is larger, the coefficient becomes the limit over the
    /// pressure. Pairs of edges and pairs with beams have no area and are not limited.
    pub friction_limit: Option<f64>,
    /// Time at which contact starts [time].
    pub birth: f64,
    /// Time at which contact ends [time]; without it, never. Before `birth` and after `death` the
    /// parts are not in contact, not even by an earlier interface.
    pub death: Option<f64>,
    /// Contact thickness of all shells and beams, in place of their own [length]. `thickness_limit`
    /// does not bound it.
    pub thickness: Option<f64>,
    /// Factor on the thickness of shells and beams in contact.
    pub thickness_scale: f64,
    /// Global search: `cells` (linked cells) or `boxes` (point in box by sorted lists).
    pub search: String,
    /// Distance that the global search looks beyond the reach, so that it need not run in every
    /// step [length]. 0 for a quarter of the median element side, or 0.4 of the largest thickness
    /// if that is more, at most one median side. It changes the number and duration of searches and
    /// which parts count as near, but no bit of the motion.
    pub skin: f64,
    /// Iteration for coupled pairs (Lagrange). `gauss_seidel` (default) updates one pair after the
    /// other in ascending order of their keys (`cases/studies/README.md`, sandwich). `split`
    /// updates all pairs from the same state, with nodal masses split among their pairs; it needs
    /// more sweeps.
    pub iteration: String,
    /// Largest number of plain sweeps over all pairs in a step (Lagrange), or of passes (kinematic;
    /// 1 in PRONTO3D).
    pub sweeps: usize,
    /// Largest number of accelerated sweeps in a step (Lagrange); 0 for none. They follow the plain
    /// sweeps if these leave more than 1e-4 of the velocity that a force has to change. This
    /// happens with layers of less than a hundredth of the mass of their neighbours. With
    /// `sweeps = 1` none follow. See `cases/studies/README.md`, sandwich.
    pub accelerated: usize,
    /// Velocity that a force leaves to be changed, over the velocity that it has to change
    /// (Lagrange). Relative change below which a force stays as it is (kinematic). See
    /// `cases/studies/README.md`, bars.
    pub tolerance: f64,
    /// Distribution of a contact force to the nodes of a segment: `shape` (N_k) or `mass` (m_k/M2
    /// of Wang 2007, eq. 7). `mass` does not conserve angular momentum if the nodal masses of a
    /// segment differ (Lagrange). See `cases/studies/README.md`, hertz and tumble.
    pub weighting: String,
    /// Partition factor beta (kinematic): fraction of the correction that one surface takes as
    /// slave of the other. It is the surface of the lower part, or within a part of the lower
    /// element. The other surface takes the rest as slave of the first. Pairs whose surfaces are
    /// not slaves of each other are not partitioned. See `cases/studies/README.md`, bars-solids.
    pub partition: f64,
    /// Form of the penalty stiffness (penalty, mortar): `soft`, from nodal masses and the step, or
    /// `stiffness`. `stiffness` is E A / d with Young's modulus E and area A of the segment, and d
    /// the shortest edge of a solid or the longest diagonal of a shell. With the law `mortar` it is
    /// the stiffness of a pressure. See `cases/studies/README.md`, reversal and hertz.
    pub penalty_form: String,
    /// Factor on the penalty stiffness of either form (penalty, mortar). See
    /// `cases/studies/README.md`, bars, reversal and penalty-map.
    pub penalty_scale: f64,
    /// Normal damping of the penalty, as a fraction of the critical damping of the masses in
    /// contact (penalty, mortar). Without damping, a sliding body bounces on the contact springs,
    /// and its friction is too small (`cases/studies/README.md`, slide). With 0.1 an impact of bars
    /// loses as much as with the Lagrange law.
    pub penalty_damping: f64,
    /// Reduce the penalty stiffness where it would make the step unstable, with a warning (penalty,
    /// mortar). Without it a run may become unstable (`cases/studies/README.md`, penalty-map).
    pub penalty_cap: bool,
    /// Contact between edges: free edges of shells, folds, and sharp edges of solids. Without it
    /// edges pass through each other between their nodes (`tests/VERIFICATION.md`, C04).
    pub edges: bool,
    /// Contact of beams, as lines with a radius (`part.beam.contact_radius`): with each other, with
    /// edges of shells and solids, and with nodes, along their whole length. Without this key as
    /// `edges`. If false, other bodies pass through beams.
    pub beams: Option<bool>,
    /// Largest contact thickness of a shell as a multiple of its shortest side, and of a beam as a
    /// multiple of its length; 0 for no limit. Without a limit, shells with sides shorter than
    /// their thickness would touch the shells at an angle to them around a corner. They would do so
    /// from the start and at great cost (`cases/bench/RESULTS.md`).
    pub thickness_limit: f64,
    /// Parts in contact with those of `against`; without `against`, with each other and with
    /// themselves. All parts if empty.
    pub parts: Vec<u32>,
    /// Parts in contact with those of `parts`. They are not in contact with each other by this
    /// table.
    pub against: Vec<u32>,
    /// Parts that are in contact by interfaces only.
    pub exclude: Vec<u32>,
    /// Interfaces: pairs of parts with other settings than above, or without contact. The last
    /// interface that names a pair of parts applies to it.
    pub interface: Vec<Interface>,
}

/// Interface: contact between some parts, with its own settings. A key that is not given is as in
/// `[contact]`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct Interface {
    /// Name in messages and for `--set contact.interface.NAME.key`.
    pub name: String,
    /// Parts in contact with those of `against`; without `against`, with each other and with
    /// themselves. All parts if empty.
    pub parts: Vec<u32>,
    /// Parts in contact with those of `parts`. They are not in contact with each other by this
    /// table.
    pub against: Vec<u32>,
    /// Parts that do not belong to this interface.
    pub exclude: Vec<u32>,
    /// As in `[contact]`, or `lagrange` if the law there is `none`. With `none` these parts are not
    /// in contact.
    pub law: Option<String>,
    /// As in `[contact]`. If this is given without `friction_dynamic`, friction is the same at all
    /// speeds.
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
    /// As in `[contact]`. If false, this interface does not apply to beams, and an earlier
    /// interface remains in effect for them.
    pub beams: Option<bool>,
}

impl Contact {
    /// Name of the law for no contact.
    pub const NO_LAW: &str = "none";

    /// Returns the settings of one of its interfaces.
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

    /// Returns its own settings and those of its interfaces, in their order.
    pub fn each(&self) -> impl Iterator<Item = Self> + '_ {
        let own = Self { interface: Vec::new(), ..self.clone() };
        std::iter::once(own).chain(self.interface.iter().map(|i| self.of(i)))
    }

    /// Returns the parts on both sides, as indices into `ids`, by its own settings without its
    /// interfaces.
    pub fn sides(&self, ids: &[u32]) -> [Vec<usize>; 2] {
        let named = |list: &[u32], id: u32| list.is_empty() || list.contains(&id);
        let against = if self.against.is_empty() { &self.parts } else { &self.against };
        let side = |list: &[u32]| {
            let is_in = |&(_, &id): &(usize, &u32)| named(list, id) && !self.exclude.contains(&id);
            ids.iter().enumerate().filter(is_in).map(|(place, _)| place).collect()
        };
        [side(&self.parts), side(against)]
    }

    /// Returns true if its own settings include beams.
    pub fn has_beams(&self) -> bool {
        self.beams.unwrap_or(self.edges)
    }

    /// Returns true if a part is in contact by its own settings or by an interface.
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
