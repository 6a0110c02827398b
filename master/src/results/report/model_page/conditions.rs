//! Boundary conditions, loads and findings of a job, as marks in the picture: nodes, arrows, spots.
//!
//! Bytes of a condition: for nodes their places in the picture (u32, each minus the one before);
//! for spots x, y and z; for arrows x, y, z of the start and of the vector (bits of f32, each minus
//! the one before).

use super::super::encode::PackedColumns;
use super::UnitNames;
use super::columns::in_scene;
use crate::input::check::figure;
use crate::input::job::Model;
use crumple_proto::airbag::BagFace;
use crumple_proto::ids::{ElemId, NodeId};
use crumple_proto::job::JointInput;
use crumple_proto::joint::ResolvedJoint;
use crumple_proto::loads::{MotionForm, PrescribedMotion};
use crumple_proto::mesh::once_each;
use crumple_proto::wall::WallMotion;
use crumple_worker::contact::diagnostics::initial_penetration::Penetration;
use serde_json::{Value, json};
use std::collections::{BTreeMap, HashMap};

/// Maximum number of arrows or spots of a condition.
pub const MOST_MARKS: usize = 200;
/// Number of elements with the smallest steps that are marked.
const LIMITING: usize = 20;
/// Names of the degrees of freedom by their bits.
const DOFS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

type SpaceVector = [f64; 3];

/// Places of a condition.
#[derive(Clone, Debug, PartialEq)]
pub enum Marks {
    /// Nodes, by their places in the mesh.
    Nodes(Vec<u32>),
    /// Start and vector of each arrow.
    Arrows(Vec<[SpaceVector; 2]>),
    /// Points [length].
    Spots(Vec<SpaceVector>),
}

/// A condition of the model.
#[derive(Clone, Debug, PartialEq)]
pub struct Condition {
    /// Kind, such as `fixed x y z`.
    pub title: String,
    /// Values and names.
    pub detail: String,
    /// Number of nodes, faces or elements of the model.
    pub count: usize,
    /// Marks in the picture.
    pub marks: Marks,
    /// True if it is shown when the page opens.
    pub is_on: bool,
}

impl Condition {
    fn new(
        title: impl Into<String>,
        detail: impl Into<String>,
        count: usize,
        marks: Marks,
    ) -> Self {
        Self { title: title.into(), detail: detail.into(), count, marks, is_on: true }
    }

    /// Adds the marks to the bytes of the page, whose picture has these nodes of the mesh, and
    /// describes the condition.
    pub fn pack(&self, scene: &[u32], out: &mut PackedColumns) -> Value {
        let mut floats = |columns: Vec<Vec<f64>>| {
            for column in columns {
                out.chain(column.into_iter().map(|c| (c as f32).to_bits()));
            }
        };
        let (form, marks) = match &self.marks {
            Marks::Nodes(nodes) => {
                let places = in_scene(nodes.iter().copied(), scene);
                out.chain(places.iter().copied());
                ("nodes", places.len())
            }
            Marks::Arrows(arrows) => {
                let arrows = thinned(arrows);
                let column = |k: usize| arrows.iter().map(|a| a[k / 3][k % 3]).collect();
                floats((0..6).map(column).collect());
                ("arrows", arrows.len())
            }
            Marks::Spots(spots) => {
                let spots = thinned(spots);
                floats((0..3).map(|c| spots.iter().map(|x| x[c]).collect()).collect());
                ("spots", spots.len())
            }
        };
        json!({
            "title": self.title,
            "detail": self.detail,
            "count": self.count,
            "form": form,
            "marks": marks,
            "on": self.is_on,
        })
    }
}

/// Returns at most [`MOST_MARKS`] of the items, evenly.
fn thinned<T: Copy>(items: &[T]) -> Vec<T> {
    super::super::series::spread(items.len(), MOST_MARKS).into_iter().map(|i| items[i]).collect()
}

/// A model with its nodes by number.
struct PlacedModel<'a> {
    model: &'a Model,
    units: &'a UnitNames,
    place: HashMap<u64, u32>,
}

/// Returns all conditions, in the order of the page.
pub(super) fn all(
    model: &Model,
    penetrations: &[Penetration],
    units: &UnitNames,
) -> Vec<Condition> {
    let place = model.mesh.nodes.iter().zip(0..).map(|(n, i)| (n.id.label(), i)).collect();
    let placed = PlacedModel { model, units, place };
    let mut out = placed.fixed();
    out.extend(placed.motions());
    out.extend(placed.rigid());
    out.extend(placed.joints());
    out.extend(placed.initial_velocity());
    out.extend(placed.loads());
    out.extend(placed.masses());
    out.extend(placed.ties());
    out.extend(placed.walls());
    out.extend(placed.penetrations(penetrations));
    out.extend(placed.limiting());
    out
}

/// Returns the places of the elements with the smallest finite steps, ascending by step.
pub(super) fn limiting(model: &Model) -> Vec<usize> {
    let dt = &model.elements.stable_dt;
    let mut order: Vec<usize> = (0..dt.len()).filter(|&e| dt[e].is_finite()).collect();
    order.sort_by(|&a, &b| dt[a].total_cmp(&dt[b]));
    order.truncate(LIMITING);
    order
}

/// Returns the names of degrees of freedom.
fn dofs(bits: u64) -> String {
    let named = (0..6).filter(|d| bits >> d & 1 == 1).map(|d| DOFS[d]);
    named.collect::<Vec<_>>().join(" ")
}

fn vector(v: SpaceVector) -> String {
    format!("({})", v.map(figure).join(", "))
}

impl PlacedModel<'_> {
    fn places(&self, ids: &[NodeId]) -> Vec<u32> {
        ids.iter().filter_map(|id| self.place.get(&id.label()).copied()).collect()
    }

    fn at(&self, node: u32) -> SpaceVector {
        self.model.mesh.nodes[node as usize].x
    }

    fn middle(&self, nodes: &[u32]) -> SpaceVector {
        let count = nodes.len().max(1) as f64;
        [0, 1, 2].map(|c| nodes.iter().map(|&n| self.at(n)[c]).sum::<f64>() / count)
    }

    /// Returns a factor over time in words, empty if it is constant.
    fn curve(&self, curve: Option<usize>) -> String {
        let name = |i: usize| self.model.job.curve.get(i).map_or("", |c| c.name.as_str());
        curve.map_or(String::new(), |i| format!(", times curve `{}`", name(i)))
    }

    /// Nodes by their fixed degrees of freedom, without those of motions and rigid bodies.
    fn fixed(&self) -> Vec<Condition> {
        let settings = &self.model.settings;
        let mut fixed = self.model.nodes.fixed.clone();
        for motion in &settings.loads.motions {
            self.places(&motion.nodes).iter().for_each(|&n| fixed[n as usize] &= !motion.dofs);
        }
        for body in &settings.rigid {
            self.places(&body.nodes).iter().for_each(|&n| fixed[n as usize] = 0);
        }
        let mut groups: BTreeMap<u64, Vec<u32>> = BTreeMap::new();
        for (n, &bits) in fixed.iter().enumerate().filter(|(_, bits)| **bits != 0) {
            groups.entry(bits).or_default().push(n as u32);
        }
        let condition = |(bits, nodes): (u64, Vec<u32>)| {
            Condition::new(format!("fixed {}", dofs(bits)), "", nodes.len(), Marks::Nodes(nodes))
        };
        groups.into_iter().map(condition).collect()
    }

    /// Returns quantity and amount of a motion in words.
    fn motion_words(&self, motion: &PrescribedMotion) -> (&'static str, String) {
        let what = match motion.form {
            MotionForm::Displacement => "prescribed displacement",
            MotionForm::Velocity => "prescribed velocity",
            MotionForm::Acceleration => "prescribed acceleration",
            MotionForm::Spin { .. } => "prescribed spin",
            MotionForm::Rotation { .. } => "prescribed rotation",
        };
        let about = match motion.form.centre() {
            Some(centre) => format!(" about {}", vector(centre)),
            None => String::new(),
        };
        let curve = self.curve(motion.curve);
        let until = |[begin, end]: [f64; 2]| match end == f64::MAX {
            true => format!(", from {begin}"),
            false => format!(", from {begin} to {end}"),
        };
        let window = motion.window.map_or(String::new(), until);
        let words =
            format!("{}{about}{curve}{window}, in {}", vector(motion.amount), dofs(motion.dofs));
        (what, words)
    }

    /// Returns the direction of a motion at a place.
    fn motion_at(motion: &PrescribedMotion, x: SpaceVector) -> SpaceVector {
        let amount = motion.amount;
        let moved = match motion.form.centre() {
            Some(centre) => {
                let r = [0, 1, 2].map(|c| x[c] - centre[c]);
                [0, 1, 2].map(|c| {
                    amount[(c + 1) % 3] * r[(c + 2) % 3] - amount[(c + 2) % 3] * r[(c + 1) % 3]
                })
            }
            None => amount,
        };
        [0, 1, 2].map(|c| if motion.dofs >> c & 1 == 1 { moved[c] } else { 0.0 })
    }

    fn motions(&self) -> Vec<Condition> {
        let condition = |motion: &PrescribedMotion| {
            let nodes = self.places(&motion.nodes);
            let arrow = |&n: &u32| [self.at(n), Self::motion_at(motion, self.at(n))];
            let arrows: Vec<[SpaceVector; 2]> = nodes.iter().map(arrow).collect();
            let moves = arrows.iter().any(|a| a[1] != [0.0; 3]);
            let (what, words) = self.motion_words(motion);
            let count = nodes.len();
            let marks = if moves { Marks::Arrows(arrows) } else { Marks::Nodes(nodes) };
            Condition::new(what, words, count, marks)
        };
        self.model.settings.loads.motions.iter().map(condition).collect()
    }

    fn rigid(&self) -> Vec<Condition> {
        let mut out = Vec::new();
        for (i, body) in self.model.settings.rigid.iter().enumerate() {
            let name = self.model.job.rigid.get(i).map_or("", |r| r.name.as_str());
            let nodes = self.places(&body.nodes);
            let middle = self.middle(&nodes);
            let fixed = match body.fixed {
                0 => String::new(),
                bits => format!("fixed {}", dofs(bits)),
            };
            let count = nodes.len();
            let mut condition =
                Condition::new(format!("rigid body {name}"), fixed, count, Marks::Nodes(nodes));
            condition.is_on = body.fixed != 0;
            out.push(condition);
            for motion in &body.motions {
                let (what, words) = self.motion_words(motion);
                let arrow = match motion.form.centre() {
                    Some(_) => [middle, motion.amount],
                    None => [middle, Self::motion_at(motion, middle)],
                };
                let title = format!("{what} of rigid body {name}");
                out.push(Condition::new(title, words, count, Marks::Arrows(vec![arrow])));
            }
        }
        out
    }

    /// Joints, with their axes.
    fn joints(&self) -> Vec<Condition> {
        let joints = self.model.job.joint.iter().zip(&self.model.settings.joints);
        let condition = |(input, joint): (&JointInput, &ResolvedJoint)| {
            let bodies = input.bodies.join(" and ");
            let ground = if joint.first.is_none() { " and the ground" } else { "" };
            let kind = serde_json::to_value(input.kind).unwrap_or_default();
            let detail = format!("{} of {bodies}{ground}", kind.as_str().unwrap_or_default());
            let marks = Marks::Arrows(vec![[joint.point, joint.axes[0]]]);
            Condition::new(format!("joint {}", input.name), detail, 1, marks)
        };
        joints.map(condition).collect()
    }

    fn initial_velocity(&self) -> Option<Condition> {
        let all = self.model.nodes.velocity.iter().zip(0..);
        let moving: Vec<u32> = all.filter(|(v, _)| **v != [0.0; 3]).map(|(_, n)| n).collect();
        let arrows: Vec<[SpaceVector; 2]> =
            moving.iter().map(|&n| [self.at(n), self.model.nodes.velocity[n as usize]]).collect();
        let speed = |a: &[SpaceVector; 2]| a[1].iter().map(|c| c * c).sum::<f64>().sqrt();
        let fastest = arrows.iter().map(speed).fold(0.0, f64::max);
        let detail = format!("up to {} {}", figure(fastest), self.units.velocity);
        let marks = Marks::Arrows(arrows);
        let condition =
            || Condition::new("initial velocity", detail.trim_end(), moving.len(), marks);
        (!moving.is_empty()).then(condition)
    }

    /// Gravity, nodal forces and moments, pressures, airbags.
    fn loads(&self) -> Vec<Condition> {
        let loads = &self.model.settings.loads;
        let everything: Vec<u32> = (0..self.model.mesh.nodes.len() as u32).collect();
        let middle = self.middle(&everything);
        let gravity = loads.gravity.iter().map(|g| {
            let detail = vector(g.acceleration) + &self.curve(g.curve);
            let marks = Marks::Arrows(vec![[middle, g.acceleration]]);
            let count = g.shares.as_ref().map_or(everything.len(), Vec::len);
            Condition::new("gravity", detail, count, marks)
        });
        let damping = loads.part_damping.iter().map(|d| {
            let nodes: Vec<NodeId> = d.shares.iter().map(|s| s.0).collect();
            let detail = format!("{} of parts{}", figure(d.coefficient), self.curve(d.curve));
            Condition::new("damping", detail, nodes.len(), Marks::Nodes(self.places(&nodes)))
        });
        let forces = loads.forces.iter().flat_map(|force| {
            let nodes = self.places(&force.nodes);
            let both = [("force", force.force), ("moment", force.moment)];
            let acting = both.into_iter().filter(|(_, v)| *v != [0.0; 3]);
            acting.map(move |(what, v)| {
                let arrows = nodes.iter().map(|&n| [self.at(n), v]).collect();
                let detail = format!("{} on each node{}", vector(v), self.curve(force.curve));
                Condition::new(what, detail, nodes.len(), Marks::Arrows(arrows))
            })
        });
        let elements: HashMap<ElemId, usize> =
            self.model.mesh.elements.iter().zip(0..).map(|(e, i)| (e.id, i)).collect();
        let pressures = loads.pressures.iter().map(|p| {
            let arrows: Vec<[SpaceVector; 2]> = p
                .faces
                .iter()
                .filter_map(|(id, face)| {
                    let (middle, normal) = self.face(*elements.get(id)?, *face);
                    Some([middle, normal.map(|c| -p.pressure * c)])
                })
                .collect();
            let (what, detail) = match &p.blast {
                Some(blast) => {
                    let place = if blast.on_ground { "on the ground" } else { "in free air" };
                    let at = vector(blast.position);
                    ("blast", format!("{} kg of TNT {place} at {at}", figure(blast.mass)))
                }
                None => ("pressure", figure(p.pressure)),
            };
            let detail = detail + &self.curve(p.curve);
            Condition::new(what, detail, p.faces.len(), Marks::Arrows(arrows))
        });
        let airbags = loads.airbags.iter().map(|bag| {
            let arrow = |f: &BagFace| {
                let (middle, normal) = self.face(*elements.get(&f.element)?, f.face);
                let sign = if f.inwards { -1.0 } else { 1.0 };
                Some([middle, normal.map(|c| sign * c)])
            };
            let arrows = bag.faces.iter().filter_map(arrow).collect();
            Condition::new("airbag", &bag.name, bag.faces.len(), Marks::Arrows(arrows))
        });
        gravity.chain(damping).chain(forces).chain(pressures).chain(airbags).collect()
    }

    /// Returns the middle of a face of an element, and its unit normal.
    fn face(&self, element: usize, face: u8) -> (SpaceVector, SpaceVector) {
        let element = &self.model.mesh.elements[element];
        let corners = element.shape.faces()[face as usize].map(|c| element.nodes[c]);
        let places = self.places(once_each(&corners));
        let middle = self.middle(&places);
        let x: Vec<SpaceVector> = places.iter().map(|&n| self.at(n)).collect();
        let across = |a: usize, b: usize| [0, 1, 2].map(|c| x[b][c] - x[a][c]);
        let last = x.len() - 1;
        let (a, b) =
            if last == 3 { (across(0, 2), across(1, 3)) } else { (across(0, 1), across(0, 2)) };
        let n: SpaceVector =
            [0, 1, 2].map(|c| a[(c + 1) % 3] * b[(c + 2) % 3] - a[(c + 2) % 3] * b[(c + 1) % 3]);
        let length = n.iter().map(|c| c * c).sum::<f64>().sqrt().max(f64::MIN_POSITIVE);
        (middle, n.map(|c| c / length))
    }

    fn masses(&self) -> Option<Condition> {
        let all = self.model.nodes.added_mass.iter().zip(0..);
        let heavy: Vec<u32> = all.filter(|(m, _)| **m > 0.0).map(|(_, n)| n).collect();
        let total = figure(self.model.lumped_mass());
        let detail = format!("{total} {} in total", self.units.mass);
        let condition =
            || Condition::new("lumped mass", detail, heavy.len(), Marks::Nodes(heavy.clone()));
        (!heavy.is_empty()).then(condition)
    }

    fn ties(&self) -> Option<Condition> {
        let ties: Vec<NodeId> = self.model.settings.ties.iter().map(|tie| tie.node).collect();
        let marks = Marks::Nodes(self.places(&ties));
        let mut condition = Condition::new("tied nodes", "", ties.len(), marks);
        condition.is_on = false;
        (!ties.is_empty()).then_some(condition)
    }

    /// Walls that move; the picture has the walls themselves.
    fn walls(&self) -> Vec<Condition> {
        let walls = self.model.settings.walls.iter().enumerate();
        let moving = walls.filter_map(|(number, wall)| {
            let label = wall.label(number);
            let (what, detail, along) = match &wall.motion {
                WallMotion::Still => return None,
                WallMotion::Pushed { mass, speed } => {
                    let detail = format!(
                        "{label}: mass {} {}, {} {} along its normal",
                        figure(*mass),
                        self.units.mass,
                        figure(*speed),
                        self.units.velocity
                    );
                    ("wall with a mass", detail, wall.direction.map(|c| c * speed))
                }
                WallMotion::Led(motion) => {
                    let (_, words) = self.motion_words(motion);
                    ("moving wall", format!("{label}: {words}"), motion.amount)
                }
            };
            Some(Condition::new(what, detail, 1, Marks::Arrows(vec![[wall.point, along]])))
        });
        moving.collect()
    }

    fn penetrations(&self, found: &[Penetration]) -> Option<Condition> {
        let nodes: Vec<NodeId> = found.iter().map(|p| p.node).collect();
        let deepest = found.iter().map(|p| p.depth).fold(0.0, f64::max);
        let detail = format!("up to {} {}", figure(deepest), self.units.length);
        let marks = Marks::Nodes(self.places(&nodes));
        let condition =
            || Condition::new("initial penetrations", detail.trim_end(), nodes.len(), marks);
        (!nodes.is_empty()).then(condition)
    }

    fn limiting(&self) -> Option<Condition> {
        let order = limiting(self.model);
        let middle = |&e: &usize| self.middle(&self.places(self.model.mesh.elements[e].corners()));
        let spots: Vec<SpaceVector> = order.iter().map(middle).collect();
        let mut condition =
            Condition::new("smallest time steps", "", spots.len(), Marks::Spots(spots));
        condition.is_on = false;
        (!order.is_empty()).then_some(condition)
    }
}
