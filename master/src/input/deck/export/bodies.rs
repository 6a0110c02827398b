//! Writes rigid bodies and prescribed motion as cards.

use super::inertia::InertiaCards;
use super::joints::JointNodes;
use super::{
    Blank, CardValue, DeckWriter, Id, LeftReason, Number, TimeCurves, id_in_name, line, list,
    named, switches,
};
use crate::input::job::Model;
use crumple_proto::job::{CurveInput, Job, MotionInput, Part, Rigid, RigidLoad, RigidStop};
use crumple_proto::partition::Material;
use std::collections::{BTreeMap, BTreeSet};
use toml::{Table, Value};

/// Bodies with their names in the deck.
#[derive(Default)]
pub struct DeckBodies {
    /// Material id by rigid part.
    pub materials: BTreeMap<u32, u64>,
    /// Mass properties of bodies by their leading parts.
    pub inertia: BTreeMap<u32, InertiaCards>,
    /// Sets of bodies that keep their ids with the nodes of joints.
    pub(super) joint_sets: BTreeSet<String>,
    /// Names of bodies whose given mass is in the densities on their cards.
    dense: BTreeSet<String>,
    /// Part for motions, by the name of the body in the job; empty if bodies are not written as
    /// cards.
    parts: BTreeMap<String, u64>,
    /// Names in the deck by names in the job.
    names: BTreeMap<String, String>,
}

impl DeckBodies {
    /// Returns the part for a body of the job in cards; `None` if it has no cards.
    pub(super) fn part(&self, body: &str) -> Option<u64> {
        self.parts.get(body).copied()
    }

    /// Returns the name in the deck of a body of the job.
    pub(super) fn name<'a>(&'a self, body: &'a str) -> &'a str {
        self.names.get(body).map_or(body, String::as_str)
    }
}

/// Writes the materials of rigid parts, with ids from `next` on.
pub fn materials(deck: &mut DeckWriter, model: &Model, mut next: u64) -> DeckBodies {
    let (job, materials) = (&model.job, &model.settings.materials);
    let mut bodies = DeckBodies::default();
    let (switched, whole): (Vec<&Rigid>, Vec<&Rigid>) =
        job.rigid.iter().partition(|body| switches::is_switched(body));
    let leads: Vec<Option<u32>> = whole.iter().map(|body| body.parts.first().copied()).collect();
    // Decks have bodies of parts in ascending ids, then those of nodes alone, then switches.
    let in_order = leads.is_sorted_by_key(|lead| lead.map_or(u64::MAX, u64::from))
        && job.rigid.iter().is_sorted_by_key(switches::is_switched)
        && switches::are_in_order(&switched);
    let known = job.rigid.iter().all(|b| b.fixed.iter().all(|d| DOFS.contains(&d.as_str())));
    if !in_order || !known {
        return bodies;
    }
    let mut free = 1 + job.part.iter().map(|p| u64::from(p.id)).max().unwrap_or(0);
    let of_bodies: BTreeSet<u32> = whole.iter().flat_map(|body| body.parts.clone()).collect();
    let deformable = job.part.iter().filter(|part| !of_bodies.contains(&part.id));
    let mut titles: BTreeSet<String> =
        deformable.flat_map(Part::materials).map(String::from).collect();
    for body in whole {
        let mut own: BTreeMap<&str, u64> = BTreeMap::new();
        let factor = density_factor(model, body).filter(|_| {
            // A reader would give another name to a material whose name is taken.
            let mut of = body.parts.iter().filter_map(|id| job.part.iter().find(|p| p.id == *id));
            of.all(|part| !titles.contains(&title(&part.material, body, job)))
        });
        if factor.is_some() {
            bodies.dense.insert(body.name.clone());
        }
        for id in &body.parts {
            let of = job.part.iter().find(|p| p.id == *id).map_or("", |p| p.material.as_str());
            let Some(material) = materials.iter().find(|m| m.name == of) else { continue };
            let mid = *own.entry(of).or_insert_with(|| {
                rigid_material(deck, material, (body, job), (next, factor));
                titles.insert(title(&material.name, body, job));
                next += 1;
                next - 1
            });
            bodies.materials.insert(*id, mid);
        }
        let (part, name) = match body.parts.first() {
            Some(&lead) => (u64::from(lead), format!("part-{lead}")),
            None => {
                free += 1;
                (free - 1, format!("body-{}", free - 1))
            }
        };
        bodies.parts.insert(body.name.clone(), part);
        bodies.names.insert(body.name.clone(), name);
    }
    for body in switched {
        bodies.names.insert(body.name.clone(), switches::name(body));
    }
    bodies
}

const DOFS: [&str; 6] = ["x", "y", "z", "rx", "ry", "rz"];

/// Returns the codes of the fixed displacements and rotations of a body: 1 x, 2 y, 3 z, 4 xy, 5 yz,
/// 6 zx, 7 all.
fn fixed_codes(body: &Rigid) -> [u64; 2] {
    [0, 3].map(|first| {
        let held = [0, 1, 2].map(|c| body.fixed.iter().any(|d| d == DOFS[first + c]));
        [0, 1, 2, 4, 3, 6, 5, 7]
            [usize::from(held[0]) + 2 * usize::from(held[1]) + 4 * usize::from(held[2])]
    })
}

/// Returns the factor on the densities of a body that gives it its mass, if mass is all that is
/// given.
fn density_factor(model: &Model, body: &Rigid) -> Option<f64> {
    if body.mass.is_none() || body.inertia.is_some() || body.centre.is_some() {
        return None;
    }
    let all = model.mesh.elements.iter().zip(&model.elements.mass_factor);
    let mut own = all.filter(|(element, _)| body.parts.contains(&element.part));
    own.next().map(|(_, factor)| *factor)
}

/// Returns the title of a material of a body in the deck. A body of a deck is named by its part,
/// and its materials have their names from the deck.
fn title(material: &str, body: &Rigid, job: &Job) -> String {
    let of_deck = body.parts.first().is_some_and(|lead| body.name == format!("part-{lead}"));
    let own = |part: &Part| !part.materials().contains(&material) || body.parts.contains(&part.id);
    match of_deck && job.part.iter().all(own) {
        true => line(material),
        false => format!("{}, {}", line(material), line(&body.name)),
    }
}

/// Writes the material of a body with this id. With a factor on its density, Crumple reads the
/// density of the job.
fn rigid_material(
    deck: &mut DeckWriter,
    material: &Material,
    (body, job): (&Rigid, &Job),
    (mid, factor): (u64, Option<f64>),
) {
    let number = |key: &str| match material.parameters.get(key) {
        Some(crumple_proto::partition::Param::Number(x)) => Number(*x),
        _ => Blank,
    };
    deck.keyword("MAT_RIGID_TITLE");
    let title = title(&material.name, body, job);
    deck.text(&title);
    let density = material.density * factor.unwrap_or(1.0);
    deck.card(&[Id(mid), Number(density), number("youngs_modulus"), number("poisson")]);
    if factor.is_some() {
        let density = ("density".to_string(), material.density.into());
        deck.comment("material", Table::from_iter([named(&title), density]));
    }
    let codes = fixed_codes(body);
    deck.card(&[Id(u64::from(codes != [0, 0])), Id(codes[0]), Id(codes[1])]);
    deck.card(&[]);
}

/// Writes what joins bodies, with the nodes of joints, and motions. Content without a card is
/// written after `$crumple:`.
pub fn write(
    deck: &mut DeckWriter,
    (model, bodies): (&Model, &DeckBodies),
    nodes: &JointNodes,
    set: impl Fn(&str) -> CardValue,
    curves: &mut TimeCurves<'_>,
) {
    let job = &model.job;
    if bodies.names.is_empty() {
        list(deck, "rigid", &job.rigid);
    } else {
        let mut switch = 1;
        for body in &job.rigid {
            if switches::is_switched(body) {
                switch += switches::write(deck, body, switch);
                continue;
            }
            let added = nodes.get(&body.name).map_or(&[][..], Vec::as_slice);
            join(deck, (model, body), bodies, added, &set);
            let part = bodies.parts[&body.name];
            body.stop.iter().for_each(|own| stop(deck, own, part, curves));
            if !follow(body) {
                body.load.iter().for_each(|own| load(deck, own, part, curves));
            }
        }
        let renamed = job.rigid.iter().filter(|body| bodies.name(&body.name) != body.name).count();
        if renamed > 0 {
            deck.note("rigid.name", LeftReason::Lost, renamed);
        }
    }
    motions(deck, job, bodies, set, curves);
}

/// Writes motions, a card for each degree of freedom. None is written as a card if one has none, or
/// if a reader would change their order.
fn motions(
    deck: &mut DeckWriter,
    job: &Job,
    bodies: &DeckBodies,
    set: impl Fn(&str) -> CardValue,
    curves: &mut TimeCurves<'_>,
) {
    let cards: Option<Vec<Vec<MotionCard>>> =
        job.motion.iter().map(|motion| cards_of(motion, job, bodies)).collect();
    let in_order = job.motion.iter().is_sorted_by_key(|motion| motion.rigid.is_some());
    let Some(cards) = cards.filter(|_| in_order) else {
        let renamed = |motion: &MotionInput| {
            let rigid = motion.rigid.as_ref().map(|name| bodies.name(name).to_string());
            MotionInput { rigid, ..motion.clone() }
        };
        return list(deck, "motion", &job.motion.iter().map(renamed).collect::<Vec<_>>());
    };
    for (motion, cards) in job.motion.iter().zip(cards) {
        let of = motion.nodes.as_deref().map(&set);
        let body = motion.rigid.as_deref().and_then(|body| bodies.part(body));
        let of = of.unwrap_or(Id(body.unwrap_or(0)));
        for card in cards {
            // A factor of 0 means 1.
            let (curve, amount) = match card.amount {
                0.0 => (curves.scaled(deck, None, 0.0), 1.0),
                amount => (curves.id(deck, motion.curve.as_deref()), amount),
            };
            deck.keyword(match motion.rigid {
                Some(_) => "BOUNDARY_PRESCRIBED_MOTION_RIGID",
                None => "BOUNDARY_PRESCRIBED_MOTION_SET",
            });
            let mut fields = vec![of, Id(card.dof), Id(card.vad), Id(curve), Number(amount)];
            if motion.birth > 0.0 || motion.death.is_some() {
                fields.extend([Blank, motion.death.map_or(Blank, Number), Number(motion.birth)]);
            }
            deck.card(&fields);
        }
    }
}

fn join(
    deck: &mut DeckWriter,
    (model, body): (&Model, &Rigid),
    bodies: &DeckBodies,
    added: &[u64],
    set: impl Fn(&str) -> CardValue,
) {
    let (part, name) = (bodies.parts[&body.name], &bodies.names[&body.name]);
    let nodes = body.nodes.as_deref().map(set);
    let mut own = Table::from_iter([named(name)]);
    if let (true, Ok(loads)) = (follow(body), Value::try_from(&body.load)) {
        deck.entry("rigid", Table::from_iter([named(name), ("load".to_string(), loads)]));
    }
    if body.parts.is_empty() {
        let nodes = match &body.nodes {
            Some(name) if !added.is_empty() => {
                let own = model.mesh.node_sets.get(name).map_or(&[][..], Vec::as_slice);
                let mut all: Vec<u64> = own.iter().map(|node| node.label()).collect();
                // A job by an exported deck has these nodes in its set.
                all.extend(added.iter().filter(|&node| !own.iter().any(|n| n.label() == *node)));
                let own_id = id_in_name("set-", name).filter(|_| bodies.joint_sets.contains(name));
                Id(match own_id {
                    Some(id) => deck.node_set_with_id(id, &all),
                    None => deck.node_set(&all),
                })
            }
            _ => nodes.unwrap_or(Blank),
        };
        let codes = fixed_codes(body);
        let option = if codes == [0, 0] { "" } else { "_SPC" };
        deck.keyword(&format!("CONSTRAINED_NODAL_RIGID_BODY{option}_TITLE"));
        deck.text(&line(&body.name));
        deck.card(&[Id(part), Blank, nodes]);
        if codes != [0, 0] {
            deck.card(&[Id(1), Id(codes[0]), Id(codes[1])]);
        }
    } else {
        let others: BTreeSet<u32> =
            body.parts.iter().copied().filter(|&p| u64::from(p) != part).collect();
        if !others.is_empty() {
            deck.keyword("CONSTRAINED_RIGID_BODIES");
            others.into_iter().for_each(|other| deck.card(&[Id(part), Id(u64::from(other))]));
        }
        if let Some(nodes) = nodes {
            deck.keyword("CONSTRAINED_EXTRA_NODES_SET");
            deck.card(&[Id(part), nodes]);
        }
        if !added.is_empty() {
            deck.keyword("CONSTRAINED_EXTRA_NODES_NODE");
            added.iter().for_each(|&node| deck.card(&[Id(part), Id(node)]));
        }
    }
    if let (Some(added), Some(node)) = (body.added_inertia, first_node(model, body)) {
        let [xx, yy, zz, xy, yz, zx] = added.map(Number);
        deck.keyword("ELEMENT_INERTIA");
        let at = model.job.rigid.iter().take_while(|other| other.name != body.name).count();
        deck.card(&[Id(at as u64 + 1), Id(node)]);
        deck.card(&[xx, xy, zx, yy, yz, zz]);
    }
    let centre = body.centre.map(|centre| ("centre".to_string(), Value::from(centre.to_vec())));
    match body.parts.first().and_then(|lead| bodies.inertia.get(lead)) {
        Some(on_card) if on_card.has_centre || centre.is_none() => {}
        Some(_) => {
            own.extend(centre);
            deck.digits("rigid", own);
        }
        None => {
            own.extend(body.mass.map(|mass| ("mass".to_string(), mass.into())));
            if bodies.dense.contains(&body.name) {
                return deck.digits("rigid", own);
            }
            own.extend(centre);
            own.extend(body.inertia.map(|i| ("inertia".to_string(), Value::from(i.to_vec()))));
            if own.len() > 1 {
                deck.entry("rigid", own);
            }
        }
    }
}

/// Returns the number of a node of a body.
fn first_node(model: &Model, body: &Rigid) -> Option<u64> {
    let at = model.job.rigid.iter().position(|other| other.name == body.name)?;
    model.settings.rigid.get(at)?.nodes.first().map(|node| node.label())
}

/// Returns true if a load of a body turns with it: the card of such a load has nodes.
fn follow(body: &Rigid) -> bool {
    body.load.iter().any(|load| load.follows)
}

/// Writes a load of the body of a part.
fn load(deck: &mut DeckWriter, load: &RigidLoad, part: u64, curves: &mut TimeCurves<'_>) {
    let curve = curves.id(deck, load.curve.as_deref());
    deck.keyword("LOAD_RIGID_BODY");
    let amounts = (1..).zip(load.force).chain((5..).zip(load.moment));
    for (dof, amount) in amounts.filter(|(_, amount)| *amount != 0.0) {
        deck.card(&[Id(part), Id(dof), Id(curve), Number(amount)]);
    }
}

/// Writes a stop of the body of a part.
fn stop(deck: &mut DeckWriter, stop: &RigidStop, part: u64, curves: &mut TimeCurves<'_>) {
    const SPACE: [[f64; 3]; 3] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    // A negative id is for a displacement.
    let mut bound = |deck: &mut DeckWriter, name: &Option<String>| match name {
        None => Blank,
        Some(name) => match curves.id(deck, Some(name)) {
            id if stop.position => Id(id),
            id => Number(-(id as f64)),
        },
    };
    let [upper, lower] = [&stop.upper, &stop.lower].map(|name| bound(deck, name));
    let (dir, vid) = match SPACE.iter().zip(1..).find(|(axis, _)| **axis == stop.direction) {
        Some((_, dir)) => (dir, Blank),
        None => {
            deck.systems += 1;
            deck.keyword("DEFINE_VECTOR");
            let tail = [Number(0.0); 3];
            let head = stop.direction.map(Number);
            deck.card(&[&[Id(deck.systems)][..], &tail, &head].concat());
            (4, Id(deck.systems))
        }
    };
    deck.keyword("CONSTRAINED_RIGID_BODY_STOPPERS");
    deck.card(&[Id(part), upper, lower, Blank, Blank, Blank, Id(dir), vid]);
    deck.card(&[Number(stop.birth), stop.death.map_or(Blank, Number)]);
}

/// A motion of one degree of freedom.
struct MotionCard {
    dof: u64,
    vad: u64,
    amount: f64,
}

/// Returns the cards of a motion; `None` if it has none: rotations that are fixed, and those of
/// nodes about a centre.
fn cards_of(motion: &MotionInput, job: &Job, bodies: &DeckBodies) -> Option<Vec<MotionCard>> {
    // A reader moves the start of the curve to the birth.
    let moves = |curve: &CurveInput| curve.points.first().is_some_and(|p| p[0] != motion.birth);
    let mut own = job.curve.iter().filter(|curve| Some(&curve.name) == motion.curve.as_ref());
    if motion.birth > 0.0 && own.any(moves) {
        return None;
    }
    if motion.rigid.as_ref().is_some_and(|name| bodies.part(name).is_none()) {
        return None;
    }
    let MotionInput { velocity, acceleration, displacement, spin, rotation, .. } = motion;
    let [v, a, u, w, turn] = [velocity, acceleration, displacement, spin, rotation];
    let forms = [(0, v, 0), (1, a, 0), (2, u, 0), (0, w, 3), (2, turn, 3)];
    let mut given = forms.into_iter().filter_map(|(vad, v, first)| Some((vad, (*v)?, first)));
    let (Some((vad, v, first)), None) = (given.next(), given.next()) else { return None };
    if first == 3 && motion.rigid.is_none() {
        return None;
    }
    let default: Vec<String> = DOFS[first..first + 3].iter().map(|d| d.to_string()).collect();
    let dofs = if motion.dofs.is_empty() { &default } else { &motion.dofs };
    let card = |dof: &String| {
        let axis = DOFS.iter().position(|d| d == dof)?;
        let along = axis.checked_sub(first).filter(|&c| c < 3)?;
        let dof = (along + if first == 0 { 1 } else { 5 }) as u64;
        Some(MotionCard { dof, vad, amount: v[along] })
    };
    dofs.iter().map(card).collect()
}
