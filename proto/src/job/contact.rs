//! Contact and its interfaces, as they are written.

use super::{PartRef, Setting};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Automatic single-surface contact of all parts or of some parts, and interfaces with their own
/// settings.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub struct ContactInput {
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
    /// pressure. Two edges touch on the common area of two strips, each as wide as its edge is
    /// thick in contact; their limit is this stress times that area. A beam is a strip as wide as
    /// its diameter.
    pub friction_limit: Option<f64>,
    /// Coefficient of friction by contact pressure and sliding speed, in place of `friction`,
    /// `friction_dynamic` and `friction_decay`: rows of `[pressure, speed, coefficient]`
    /// [force/length^2, length/time, 1]. Rows with the same pressure are one curve over the speed.
    /// Pressures are ascending, and so are the speeds of a curve. Interpolation is linear, with
    /// constant values beyond the ends. The pressure is that of `friction_limit`.
    pub friction_table: Vec<[f64; 3]>,
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
    /// If true, shells with an `offset` touch at half their contact thickness from their middle
    /// surface. If false, they touch at this distance from their nodes.
    pub shell_offset: bool,
    /// Global search: `cells` (linked cells) or `boxes` (point in box by sorted lists).
    pub search: String,
    /// Distance that the global search looks beyond the reach, so that it need not run in every
    /// step [length]. 0 for a quarter of the median element side, or 0.4 of the largest thickness
    /// if that is more, at most one median side; up to two median sides if initial velocities move
    /// a node through the thinnest shell in one step of the elements. It changes the number and
    /// duration of searches and which parts count as near. It changes the motion only where
    /// contact limits the step.
    pub skin: f64,
    /// Distribution of a contact force to the nodes of a segment: `shape` (N_k) or `mass` (m_k/M2
    /// of Wang 2007, eq. 7). `mass` does not conserve angular momentum if the nodal masses of a
    /// segment differ (Lagrange). See `cases/studies/README.md`, hertz and tumble.
    pub weighting: String,
    /// Surface that nodes touch: `flat` (the bilinear quads and triangles of the mesh) or `smooth`
    /// (curved patches over them, with the mean normals of the nodes; Nagata 2005). With `smooth`,
    /// nodes slide over curved bodies without a jump from segment to segment. Corners of more than
    /// 45 degrees stay sharp. Edges and law `mortar` use the mesh. See
    /// `docs/theory/contact-search.md`.
    pub surface: String,
    /// Where a new contact of a node with a segment is judged: `end_of_step` (nearest point at the
    /// start of the step, and for solids if the node is over the face at the end) or
    /// `moving_surface` (time, point and normal of the first touch with the moving segment, the
    /// velocity check of PRONTO3D). See `docs/theory/contact-search.md`.
    pub impact: String,
    /// Order of the segments that a node touches: `gap` (existing contacts by gap, new ones by time
    /// and normal velocity) or `node_normal` (at the same time the segment that is most opposed to
    /// the normal of the node, the strength of contact of PRONTO3D; for nodes of solids). See
    /// `docs/theory/contact-search.md`.
    pub choice: String,
    /// Normal of a contact with a face of a solid in the step in which the node comes to it over a
    /// convex edge: `own_face` or `last_face` (that of the face from which the node came, as in
    /// PRONTO3D). See `docs/theory/contact-search.md`.
    pub push_back: String,
    /// Contact between edges: free edges of shells, folds, and sharp edges of solids. Without it
    /// edges pass through each other between their nodes (`tests/VERIFICATION.md`, C04).
    pub edges: bool,
    /// Contact of beams and trusses, as lines with a radius (`part.beam.contact_radius`,
    /// `part.truss.contact_radius`): with each other, with edges of shells and solids, and with
    /// nodes, along their whole length. Without this key as `edges`. If false, other bodies pass
    /// through beams and trusses.
    pub beams: Option<bool>,
    /// Largest contact thickness of a shell as a multiple of its shortest side, and of a beam as a
    /// multiple of its length; 0 for no limit. Without a limit, shells with sides shorter than
    /// their thickness would touch the shells at an angle to them around a corner. They would do so
    /// from the start and at great cost (`cases/bench/RESULTS.md`).
    pub thickness_limit: f64,
    /// Parts in contact with those of `against`; without `against`, with each other and with
    /// themselves. All parts if empty.
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Parts in contact with those of `parts`. They are not in contact with each other by this
    /// table.
    #[schemars(with = "Vec<PartRef>")]
    pub against: Vec<u32>,
    /// If true, segments of `against` hold nodes of `parts`, but not the other way round: unless
    /// an earlier contact holds them too, nodes of `against` go through segments of `parts`, and
    /// edges of the two do not touch. Not for law `mortar`, which has no nodes.
    pub one_way: bool,
    /// Parts that are in contact by interfaces only.
    #[schemars(with = "Vec<PartRef>")]
    pub exclude: Vec<u32>,
    /// Settings of the laws, by key. Each law publishes the keys that it uses.
    #[serde(flatten)]
    #[schemars(skip)]
    pub parameters: BTreeMap<String, Setting>,
    /// Interfaces: pairs of parts with other settings than above, or without contact. The last
    /// interface that names a pair of parts applies to it.
    pub interface: Vec<Interface>,
}

/// Interface: contact between some parts, with its own settings. A key that is not given is as in
/// `[contact]`.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(default)]
#[schemars(deny_unknown_fields)]
pub struct Interface {
    /// Name in messages and for `--set contact.interface.NAME.key`.
    pub name: String,
    /// Parts in contact with those of `against`; without `against`, with each other and with
    /// themselves. All parts if empty.
    #[schemars(with = "Vec<PartRef>")]
    pub parts: Vec<u32>,
    /// Parts in contact with those of `parts`. They are not in contact with each other by this
    /// table.
    #[schemars(with = "Vec<PartRef>")]
    pub against: Vec<u32>,
    /// As in `[contact]`, but false unless it is given here.
    pub one_way: bool,
    /// Parts that do not belong to this interface.
    #[schemars(with = "Vec<PartRef>")]
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
    /// As in `[contact]`. If `friction` is given without it, there is no table.
    pub friction_table: Option<Vec<[f64; 3]>>,
    /// As in `[contact]` [time].
    pub birth: Option<f64>,
    /// As in `[contact]` [time].
    pub death: Option<f64>,
    /// As in `[contact]` [length].
    pub thickness: Option<f64>,
    /// As in `[contact]`.
    pub thickness_scale: Option<f64>,
    /// As in `[contact]`.
    pub shell_offset: Option<bool>,
    /// As in `[contact]`. If false, this interface does not apply to beams, and an earlier
    /// interface remains in effect for them.
    pub beams: Option<bool>,
    /// Settings of the laws, by key. Those that are not given are as in `[contact]`.
    #[serde(flatten)]
    #[schemars(skip)]
    pub parameters: BTreeMap<String, Setting>,
}

impl ContactInput {
    /// Name of the law for no contact.
    pub const NO_LAW: &str = "none";

    /// Returns the same settings with a key of a law set to `value`.
    #[must_use]
    pub fn with(mut self, key: &str, value: impl Into<Setting>) -> Self {
        self.parameters.insert(key.into(), value.into());
        self
    }

    /// Returns the settings of one of its interfaces.
    pub fn with_interface(&self, interface: &Interface) -> Self {
        let Interface {
            name,
            parts,
            against,
            one_way,
            exclude,
            law,
            friction,
            friction_dynamic,
            friction_decay,
            friction_limit,
            friction_table,
            birth,
            death,
            thickness,
            thickness_scale,
            shell_offset,
            beams,
            parameters: own,
        } = interface.clone();
        let mut parameters = self.parameters.clone();
        parameters.extend(own);
        let default = Self::default().law;
        let of_all = if self.law == Self::NO_LAW { &default } else { &self.law };
        let dynamic = if friction.is_some() {
            friction_dynamic
        } else {
            friction_dynamic.or(self.friction_dynamic)
        };
        let table =
            friction_table.or_else(|| friction.is_none().then(|| self.friction_table.clone()));
        Self {
            name,
            law: law.unwrap_or_else(|| of_all.clone()),
            friction: friction.unwrap_or(self.friction),
            friction_dynamic: dynamic,
            friction_decay: friction_decay.unwrap_or(self.friction_decay),
            friction_limit: friction_limit.or(self.friction_limit),
            friction_table: table.unwrap_or_default(),
            birth: birth.unwrap_or(self.birth),
            death: death.or(self.death),
            thickness: thickness.or(self.thickness.filter(|_| thickness_scale.is_none())),
            thickness_scale: thickness_scale.unwrap_or(self.thickness_scale),
            shell_offset: shell_offset.unwrap_or(self.shell_offset),
            search: self.search.clone(),
            skin: self.skin,
            weighting: self.weighting.clone(),
            surface: self.surface.clone(),
            impact: self.impact.clone(),
            choice: self.choice.clone(),
            push_back: self.push_back.clone(),
            edges: self.edges,
            beams: beams.or(self.beams),
            thickness_limit: self.thickness_limit,
            parts,
            against,
            one_way,
            exclude,
            parameters,
            interface: Vec::new(),
        }
    }

    /// Returns its own settings and those of its interfaces, in their order.
    pub fn each(&self) -> impl Iterator<Item = Self> + '_ {
        let own = Self { interface: Vec::new(), ..self.clone() };
        std::iter::once(own).chain(self.interface.iter().map(|i| self.with_interface(i)))
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

impl Default for ContactInput {
    fn default() -> Self {
        Self {
            name: String::new(),
            law: "lagrange".into(),
            friction: 0.0,
            friction_dynamic: None,
            friction_decay: 0.0,
            friction_limit: None,
            friction_table: Vec::new(),
            birth: 0.0,
            death: None,
            thickness: None,
            thickness_scale: 1.0,
            shell_offset: false,
            search: "cells".into(),
            skin: 0.0,
            weighting: "shape".into(),
            surface: "flat".into(),
            impact: "end_of_step".into(),
            choice: "gap".into(),
            push_back: "own_face".into(),
            edges: true,
            beams: None,
            thickness_limit: 1.0,
            parts: Vec::new(),
            against: Vec::new(),
            one_way: false,
            exclude: Vec::new(),
            parameters: BTreeMap::new(),
            interface: Vec::new(),
        }
    }
}
