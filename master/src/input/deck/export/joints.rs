//! Writes joints between rigid bodies and their resistance as cards. A card names nodes of both
//! bodies at the joint and on its axis, which are added to the bodies. Values that cards do not
//! hold to the last bit are written after `$crumple:` with the name of the joint.

use super::beams::end_of;
use super::bodies::DeckBodies;
use super::writer::{exact_quotient, id_in_name};
use super::{Blank, CardValue, DeckWriter, Id, Number, named, points, table_of, used_names};
use crate::input::deck::convert::space::{cross, unit};
use crumple_proto::job::{Job, JointInput, JointKind, JointResistance};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::TAU;
use toml::{Table, Value};

/// Longest name of a joint on its card.
const LONGEST: usize = 70;
/// Stop from which on there is none.
const FAR: f64 = 1e19;
/// Angle or distance over which other programs build up friction, as a fraction of a radian or of
/// a unit of length; here friction and stops are exact.
const SLIP: f64 = 0.01;

/// Nodes that joints add to bodies, by the names of the bodies in the job.
pub type JointNodes = BTreeMap<String, Vec<u64>>;

/// Writes joints with cards up to the first one without; it and all others stay in comments, so
/// that their order is kept. Returns the nodes that the bodies get.
pub fn write(deck: &mut DeckWriter, job: &Job, bodies: &DeckBodies) -> JointNodes {
    let mut added = JointNodes::new();
    let (with, without) = job.joint.split_at(count_with_cards(job, bodies));
    for (joint, number) in with.iter().zip(1..) {
        one(deck, joint, number, bodies, &mut added);
    }
    for joint in without {
        let bodies = joint.bodies.iter().map(|body| bodies.name(body).to_string()).collect();
        deck.whole("joint", table_of(&JointInput { bodies, ..joint.clone() }));
    }
    added
}

/// Returns the number of joints before the first one without a card.
fn count_with_cards(job: &Job, bodies: &DeckBodies) -> usize {
    job.joint.iter().take_while(|joint| has_card(joint, bodies)).count()
}

/// Returns the sets of bodies of nodes that a reader has named by their ids, to which joints add
/// nodes, and which nothing else uses: they keep their ids.
pub fn sets_of_nodes(job: &Job, bodies: &DeckBodies) -> BTreeSet<String> {
    let others = used_names(job, "rigid");
    let with = &job.joint[..count_with_cards(job, bodies)];
    let joined: BTreeSet<&String> = with.iter().flat_map(|joint| &joint.bodies).collect();
    let of = job.rigid.iter().filter(|b| b.parts.is_empty() && joined.contains(&b.name));
    let sets = of.filter_map(|body| body.nodes.clone());
    sets.filter(|set| id_in_name("set-", set).is_some() && !others.contains(set)).collect()
}

/// Returns true for a joint between two bodies of the deck. Cards have no joint with the ground.
fn has_card(joint: &JointInput, bodies: &DeckBodies) -> bool {
    joint.bodies.len() == 2
        && joint.bodies.iter().all(|body| bodies.part(body).is_some())
        && joint.name == super::line(&joint.name)
        && joint.name.chars().count() <= LONGEST
}

fn keyword(kind: JointKind) -> &'static str {
    match kind {
        JointKind::Spherical => "SPHERICAL",
        JointKind::Revolute => "REVOLUTE",
        JointKind::Cylindrical => "CYLINDRICAL",
        JointKind::Translational => "TRANSLATIONAL",
        JointKind::Universal => "UNIVERSAL",
        JointKind::Planar => "PLANAR",
        JointKind::Screw => "SCREW",
        JointKind::Fixed => "LOCKING",
    }
}

fn one(
    deck: &mut DeckWriter,
    joint: &JointInput,
    number: u64,
    bodies: &DeckBodies,
    added: &mut JointNodes,
) {
    let axis = joint.axis.unwrap_or([1.0, 0.0, 0.0]);
    let along = unit(axis).unwrap_or(axis);
    let across = perpendicular(along);
    let mut exact = Table::from_iter([named(&joint.name)]);
    let mut end = |key: &str, given: Option<[f64; 3]>, along: [f64; 3]| {
        let end: [f64; 3] = std::array::from_fn(|c| end_of(joint.point[c], along[c]));
        let read = unit(std::array::from_fn(|c| end[c] - joint.point[c]));
        if let Some(given) = given.filter(|given| read != Some(*given)) {
            exact.insert(key.into(), Value::from(given.to_vec()));
        }
        end
    };
    let third = end("axis", joint.axis, axis);
    let fourth = match joint.second_axis {
        Some(second) => end("second_axis", Some(second), second),
        None => third,
    };
    let aside = end("", None, across);
    let places = match joint.kind {
        JointKind::Spherical => vec![joint.point; 2],
        JointKind::Translational | JointKind::Fixed => {
            vec![joint.point, joint.point, third, third, aside, aside]
        }
        _ => vec![joint.point, joint.point, third, fourth],
    };
    deck.keyword("NODE");
    let mut nodes = Vec::new();
    for (place, body) in places.into_iter().zip(joint.bodies.iter().cycle()) {
        deck.last_node += 1;
        let [x, y, z] = place.map(Number);
        deck.card(&[Id(deck.last_node), x, y, z]);
        added.entry(body.clone()).or_default().push(deck.last_node);
        nodes.push(Id(deck.last_node));
    }
    deck.keyword(&format!("CONSTRAINED_JOINT_{}_ID", keyword(joint.kind)));
    deck.named_card(number, &joint.name);
    deck.card(&nodes);
    if let Some(pitch) = joint.pitch {
        let per_radian = divided(pitch, TAU);
        if TAU * per_radian != pitch {
            exact.insert("pitch".into(), pitch.into());
        }
        deck.card(&[Number(per_radian)]);
    }
    if joint.rotation.is_some() || joint.sliding.is_some() {
        let pair = [0, 1].map(|end| Id(bodies.part(&joint.bodies[end]).unwrap_or(0)));
        let system = system(deck, along, across);
        for (key, keyword, resistance, scale) in [
            ("rotation", "GENERALIZED", &joint.rotation, TAU / 360.0),
            ("sliding", "TRANSLATIONAL", &joint.sliding, 1.0),
        ] {
            let Some(given) = resistance else { continue };
            let head = [Id(number), pair[0], pair[1], system, system, Id(number)];
            let read = resists(deck, keyword, &head, (given, scale));
            if read != *given
                && let Ok(all) = Value::try_from(given)
            {
                exact.insert(key.into(), all);
            }
        }
    }
    if exact.len() > 1 {
        deck.digits("joint", exact);
    }
}

/// Writes a system whose first axis is that of the joint, and returns its id.
fn system(deck: &mut DeckWriter, along: [f64; 3], across: [f64; 3]) -> CardValue {
    deck.systems += 1;
    let id = Id(deck.systems);
    deck.keyword("DEFINE_COORDINATE_SYSTEM");
    deck.card(&[&[id][..], &[Number(0.0); 3], &along.map(Number)].concat());
    deck.card(&across.map(Number));
    id
}

/// Writes a resistance about or along the first axis, and returns it as a reader has it.
fn resists(
    deck: &mut DeckWriter,
    keyword: &str,
    head: &[CardValue],
    (given, scale): (&JointResistance, f64),
) -> JointResistance {
    let mut read = JointResistance { friction: given.friction, ..JointResistance::default() };
    let slope = |k: f64| vec![[-1.0, -k], [1.0, k]];
    read.table = match given.stiffness {
        0.0 => given.table.clone(),
        stiffness => slope(stiffness),
    };
    let curve = if read.table.is_empty() { Blank } else { Id(points(deck, &read.table)) };
    read.damping = given.damping;
    let rates = match given.damping {
        0.0 => Blank,
        damping => Id(points(deck, &slope(damping))),
    };
    let held = given.stops.map(|[low, high]| {
        let field = |stop: f64| if stop.abs() >= FAR { 0.0 } else { divided(stop.abs(), scale) };
        [field(low), field(high)]
    });
    let fields = held.unwrap_or_default();
    if fields != [0.0; 2] {
        let or_far = |field: f64| if field == 0.0 { 10.0 * FAR } else { scale * field };
        read.stops = Some([-or_far(fields[0]), or_far(fields[1])]);
    }
    let steepest = read.table.windows(2).fold(0.0, |most: f64, two| {
        most.max(((two[1][1] - two[0][1]) / (two[1][0] - two[0][0])).abs())
    });
    let acts = given.friction != 0.0 || read.stops.is_some();
    let slip = if acts { Number((given.friction / SLIP).max(steepest).max(1.0)) } else { Blank };
    deck.keyword(&format!("CONSTRAINED_JOINT_STIFFNESS_{keyword}"));
    deck.card(head);
    deck.card(&[curve, Blank, Blank, rates]);
    deck.card(&[slip, if given.friction == 0.0 { Blank } else { Number(given.friction) }]);
    deck.card(&fields.map(|field| if field == 0.0 { Blank } else { Number(field) }));
    read
}

/// Returns the number that gives `product` times `factor`, to the last bit if there is one.
fn divided(product: f64, factor: f64) -> f64 {
    exact_quotient(product, factor).unwrap_or(product / factor)
}

/// Returns a unit vector perpendicular to a unit vector.
fn perpendicular(along: [f64; 3]) -> [f64; 3] {
    let least = (0..3).min_by(|&a, &b| along[a].abs().total_cmp(&along[b].abs())).unwrap_or(0);
    let mut other = [0.0; 3];
    other[least] = 1.0;
    unit(cross(along, other)).unwrap_or(other)
}
