//! Rings, retractors, pretensioners and sensors of seat belts: their places in the paths, and
//! checks of their numbers.

use super::super::state::NodeSets;
use super::super::validate::nearest;
use super::super::walls::unit;
use super::BeltSpace;
use crumple_proto::belt::{BeltPath, BeltSensor, BeltSystem, Pretensioner, Retractor, SlipRing};
use crumple_proto::ids::NodeId;
use crumple_proto::job::{BeltSensorInput, PretensionerInput, RetractorInput, SlipRingInput};
use crumple_worker::fem::elements::is_steeper;
use crumple_worker::piecewise_linear::PiecewiseLinear;

/// Distance over the smallest length of elements up to which nodes are at the same place.
const SAME: f64 = 1e-6;

/// Resolves all devices into `system`, which has its paths.
pub fn resolve(system: &mut BeltSystem, space: &mut BeltSpace<'_>, sets: &NodeSets<'_>) {
    let belts = &space.job.belts;
    let names = |names: Vec<&String>| names.into_iter().cloned().collect::<Vec<String>>();
    let lists = [
        ("ring", names(belts.ring.iter().map(|r| &r.name).collect())),
        ("retractor", names(belts.retractor.iter().map(|r| &r.name).collect())),
        ("pretensioner", names(belts.pretensioner.iter().map(|p| &p.name).collect())),
        ("sensor", names(belts.sensor.iter().map(|s| &s.name).collect())),
    ];
    for (list, names) in &lists {
        for (i, name) in names.iter().enumerate() {
            let path = format!("belts.{list}.{i}.name");
            if name.is_empty() {
                space.fault(path, format!("a {list} of a belt has no name"), "give it a name");
            } else if names[..i].contains(name) {
                let message = format!("two entries of belts.{list} have the name `{name}`");
                space.fault(path, message, "give each its own name");
            }
        }
    }
    let mut taken: Vec<NodeId> = Vec::new();
    for (i, ring) in belts.ring.iter().enumerate() {
        let mut check = DeviceCheck { place: format!("belts.ring.{i}"), space };
        system.rings.extend(check.ring(ring, &system.paths, sets, &mut taken));
    }
    for (i, retractor) in belts.retractor.iter().enumerate() {
        let mut check = DeviceCheck { place: format!("belts.retractor.{i}"), space };
        let found = check.retractor(retractor, system, sets, (&mut taken, &lists[3].1));
        system.retractors.extend(found);
    }
    for (i, sensor) in belts.sensor.iter().enumerate() {
        let mut check = DeviceCheck { place: format!("belts.sensor.{i}"), space };
        system.sensors.extend(check.sensor(sensor, &lists[1].1, sets));
    }
    for (i, pretensioner) in belts.pretensioner.iter().enumerate() {
        let mut check = DeviceCheck { place: format!("belts.pretensioner.{i}"), space };
        let found = check.pretensioner(pretensioner, &lists[1].1, &lists[3].1);
        if let Some(twice) = found.as_ref().filter(|found| {
            system.pretensioners.iter().any(|other| other.retractor == found.retractor)
        }) {
            let name = &lists[1].1[twice.retractor];
            let message = format!("retractor `{name}` has two pretensioners");
            check.fault("retractor", message, "give each its own retractor");
        }
        system.pretensioners.extend(found);
    }
    for ring in &belts.ring {
        check_inside(system, space, sets, ring);
    }
    for (index, path) in system.paths.iter().enumerate() {
        let has_device = system.rings.iter().any(|r| r.path == index)
            || system.retractors.iter().any(|r| r.path == index);
        let first = path.segments.first().map_or(0, |s| s.law);
        if let Some(other) = path.segments.iter().find(|s| has_device && s.law != first) {
            let message = format!(
                "the belt with element {} has several parts, and belt slides along it",
                other.element
            );
            space.fault("mesh", message, "give all elements of a belt with rings one part");
        }
    }
}

/// Reports a ring among wound up nodes.
fn check_inside(
    system: &BeltSystem,
    space: &mut BeltSpace<'_>,
    sets: &NodeSets<'_>,
    ring: &SlipRingInput,
) {
    let Some(node) = sets.labelled(ring.node) else { return };
    for reel in &system.retractors {
        let nodes = &system.paths[reel.path].nodes;
        let at = |id: NodeId| nodes.iter().position(|n| *n == id);
        let (Some(own), Some(of_reel)) = (at(node), at(reel.node)) else { continue };
        if (own < of_reel) == reel.before && own != of_reel {
            let message =
                format!("ring `{}` is among the wound up nodes of `{}`", ring.name, reel.name);
            space.fault("belts.ring", message, "put it where the belt is outside");
        }
    }
}

/// A device under examination.
struct DeviceCheck<'s, 'a> {
    place: String,
    space: &'s mut BeltSpace<'a>,
}

impl DeviceCheck<'_, '_> {
    fn fault(&mut self, key: &str, message: impl Into<String>, help: impl Into<String>) {
        self.space.fault(format!("{}.{key}", self.place), message.into(), help);
    }

    fn need(&mut self, key: &str, value: f64, right: bool, wanted: &str) {
        if !(right && value.is_finite()) {
            let help = format!("it has to be {wanted}");
            self.fault(key, format!("`{key}` is {value:?}"), help);
        }
    }

    /// Returns the id of a node; reports one that no element has.
    fn node(&mut self, key: &str, label: u64, sets: &NodeSets<'_>) -> Option<NodeId> {
        let id = sets.labelled(label);
        if id.is_none() {
            self.fault(key, format!("no element has node {label}"), "name a node of an element");
        }
        id
    }

    /// Returns the node, the path and the place in it.
    fn on_path(
        &mut self,
        label: u64,
        paths: &[BeltPath],
        sets: &NodeSets<'_>,
        taken: &mut Vec<NodeId>,
    ) -> Option<(NodeId, usize, usize)> {
        let id = self.node("node", label, sets)?;
        let at = |path: &BeltPath| path.nodes.iter().position(|n| *n == id);
        let found: Vec<(usize, usize)> =
            paths.iter().enumerate().filter_map(|(p, path)| Some((p, at(path)?))).collect();
        let help = "name a node of elements of a part with [part.belt], of one belt";
        match found[..] {
            _ if taken.contains(&id) => {
                let message = format!("node {label} has another ring or retractor");
                self.fault("node", message, "give each its own node");
                None
            }
            [(path, place)] => {
                taken.push(id);
                Some((id, path, place))
            }
            [] => {
                self.fault("node", format!("node {label} belongs to no belt"), help);
                None
            }
            _ => {
                self.fault("node", format!("several belts end at node {label}"), help);
                None
            }
        }
    }

    fn ring(
        &mut self,
        ring: &SlipRingInput,
        paths: &[BeltPath],
        sets: &NodeSets<'_>,
        taken: &mut Vec<NodeId>,
    ) -> Option<SlipRing> {
        self.need("friction", ring.friction, ring.friction >= 0.0, "0 or above");
        let rest = ring.static_friction.unwrap_or(ring.friction);
        self.need("static_friction", rest, rest >= 0.0, "0 or above");
        self.need("decay", ring.decay, ring.decay >= 0.0, "0 or above");
        let lock_time = ring.lock_time.unwrap_or(f64::MAX);
        self.need("lock_time", lock_time, lock_time >= 0.0, "0 or above");
        let (node, path, place) = self.on_path(ring.node, paths, sets, taken)?;
        if place == 0 || place + 1 == paths[path].nodes.len() {
            let message =
                format!("node {} is an end of its belt, and nothing can slide", ring.node);
            self.fault("node", message, "name a node between two elements of a belt");
            return None;
        }
        Some(SlipRing {
            name: ring.name.clone(),
            node,
            path,
            friction: [ring.friction, rest],
            decay: ring.decay,
            lock_time,
        })
    }

    /// Returns the indices of sensors.
    fn sensors(&mut self, names: &[String], known: &[String]) -> Vec<usize> {
        let mut found = Vec::new();
        for (k, name) in names.iter().enumerate() {
            let index = known.iter().position(|other| other == name);
            if index.is_none() {
                let known: Vec<&str> = known.iter().map(String::as_str).collect();
                let message = format!("there is no sensor `{name}` of belts");
                self.fault(&format!("sensors.{k}"), message, nearest(name, &known));
            }
            found.extend(index);
        }
        found
    }

    /// Reports faults of points: they have to ascend from `first`; the second numbers too, or with
    /// `flat` not fall. Returns true if there are none.
    fn points(
        &mut self,
        key: &str,
        points: &[[f64; 2]],
        first: [Option<f64>; 2],
        flat: bool,
    ) -> bool {
        let fault = match PiecewiseLinear::fault(points) {
            None if points.is_empty() => Some("has no points".to_string()),
            None if !points.iter().flatten().all(|x| x.is_finite()) => Some("is not finite".into()),
            fault => fault,
        };
        if let Some(fault) = fault {
            let help = "give at least two points with ascending first numbers";
            self.fault(key, format!("{key} {fault}"), help);
            return false;
        }
        let differs = |c: usize| first[c].is_some_and(|wanted| points[0][c] != wanted);
        if differs(0) || differs(1) || points[0][1] < 0.0 {
            let wanted = first.map(|x| x.map_or("a force".into(), |x| format!("{x:?}"))).join(", ");
            let message = format!("{key} begins with {:?}", points[0]);
            self.fault(key, message, format!("begin it with [{wanted}]"));
            return false;
        }
        let falls = |p: &[[f64; 2]]| p[1][1] < p[0][1] || !flat && p[1][1] == p[0][1];
        if let Some(p) = points.windows(2).find(|p| falls(p)) {
            let message = format!("{key} goes from {:?} to {:?}", p[0][1], p[1][1]);
            self.fault(key, message, if flat { "let it not fall" } else { "let it ascend" });
            return false;
        }
        true
    }

    fn retractor(
        &mut self,
        reel: &RetractorInput,
        system: &BeltSystem,
        sets: &NodeSets<'_>,
        (taken, sensors): (&mut Vec<NodeId>, &[String]),
    ) -> Option<Retractor> {
        self.need("delay", reel.delay, reel.delay >= 0.0, "0 or above");
        self.need("pull_out", reel.pull_out, reel.pull_out >= 0.0, "0 or above");
        let fed = reel.fed_length.unwrap_or(1.0);
        self.need("fed_length", fed, fed > 0.0, "above 0");
        let loads = self.points("force_pull_out", &reel.force_pull_out, [Some(0.0), None], true);
        let unloads = reel.unloading.is_empty()
            || self.points("unloading", &reel.unloading, [Some(0.0); 2], false);
        if loads
            && unloads
            && !reel.unloading.is_empty()
            && !is_steeper(&reel.unloading, &reel.force_pull_out)
        {
            let message = "unloading is less steep than force_pull_out at the same force";
            let help = "it would give back more energy than it took: correct one of the curves";
            self.fault("unloading", message, help);
        }
        let sensors = self.sensors(&reel.sensors, sensors);
        let (node, path, place) = self.on_path(reel.node, &system.paths, sets, taken)?;
        let before = self.wound_side(reel, system, path, place)?;
        let own = &system.paths[path];
        let mouth = own.segments[if before { place } else { place - 1 }];
        let least = system.laws[mouth.law].min_length;
        Some(Retractor {
            name: reel.name.clone(),
            node,
            path,
            before,
            sensors,
            delay: reel.delay,
            pull_out: reel.pull_out,
            loading: reel.force_pull_out.clone(),
            unloading: reel.unloading.clone(),
            fed_length: reel.fed_length.unwrap_or((2.0 * least).max(mouth.length)),
        })
    }

    /// Returns true if what comes before a retractor is wound up, false for what comes after it.
    fn wound_side(
        &mut self,
        reel: &RetractorInput,
        system: &BeltSystem,
        path: usize,
        place: usize,
    ) -> Option<bool> {
        let path = &system.paths[path];
        let least = path.segments.first().map_or(0.0, |s| system.laws[s.law].min_length);
        let at_one_place = |ends: &[NodeId]| {
            ends.windows(2).all(|pair| self.space.distance(pair[0], pair[1]) <= SAME * least)
        };
        let wound = [at_one_place(&path.nodes[..=place]), at_one_place(&path.nodes[place..])];
        match wound {
            [true, false] => Some(true),
            [false, true] => Some(false),
            _ => {
                let message = match wound[0] {
                    true => format!("the belt at node {} has no length", reel.node),
                    false => format!("node {} is not at an end of its belt", reel.node),
                };
                let help = "name the node at which the belt ends, or beyond which all its nodes \
                            are at the same place and wound up";
                self.fault("node", message, help);
                None
            }
        }
    }

    fn pretensioner(
        &mut self,
        input: &PretensionerInput,
        retractors: &[String],
        sensors: &[String],
    ) -> Option<Pretensioner> {
        self.need("delay", input.delay, input.delay >= 0.0, "0 or above");
        let limit = input.force_limit.unwrap_or(f64::MAX);
        self.need("force_limit", limit, limit > 0.0, "above 0");
        let sound = self.points("pull_in", &input.pull_in, [Some(0.0); 2], true);
        if input.sensors.is_empty() {
            self.fault("sensors", "no sensor fires it", "name at least one of [[belts.sensor]]");
        }
        let sensors = self.sensors(&input.sensors, sensors);
        let retractor = self.retractor_named("retractor", &input.retractor, retractors)?;
        sound.then(|| Pretensioner {
            retractor,
            sensors,
            delay: input.delay,
            pull_in: input.pull_in.clone(),
            force_limit: limit,
        })
    }

    fn retractor_named(&mut self, key: &str, name: &str, known: &[String]) -> Option<usize> {
        let index = known.iter().position(|other| other == name);
        if index.is_none() {
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            self.fault(key, format!("there is no retractor `{name}`"), nearest(name, &known));
        }
        index
    }

    fn sensor(
        &mut self,
        sensor: &BeltSensorInput,
        retractors: &[String],
        sets: &NodeSets<'_>,
    ) -> Option<BeltSensor> {
        let BeltSensorInput { time, acceleration, pull_out_rate, nodes, duration, .. } = *sensor;
        self.need("duration", duration, duration >= 0.0, "0 or above");
        let given =
            [time.is_some(), acceleration.is_some(), pull_out_rate.is_some(), nodes.is_some()];
        if given.iter().filter(|given| **given).count() != 1 {
            let message = format!("sensor `{}` has no kind or several", sensor.name);
            let help = "give one of `time`, `acceleration`, `pull_out_rate` and `nodes`";
            self.fault("name", message, help);
            return None;
        }
        let for_others = [
            ("node", sensor.node.is_some(), given[1]),
            ("direction", sensor.direction.is_some(), given[1]),
            ("retractor", sensor.retractor.is_some(), given[2]),
            ("duration", duration != 0.0, given[1] || given[2]),
            ("max_distance", sensor.max_distance.is_some(), given[3]),
            ("min_distance", sensor.min_distance.is_some(), given[3]),
        ];
        for (key, _, _) in for_others.into_iter().filter(|(_, given, used)| *given && !used) {
            self.fault(key, format!("sensors of this kind do not use `{key}`"), "remove it");
        }
        if let Some(time) = time {
            self.need("time", time, true, "a time");
            return Some(BeltSensor::Time(time));
        }
        if let Some(limit) = acceleration {
            self.need("acceleration", limit, limit > 0.0, "above 0");
            let direction = sensor.direction.and_then(unit);
            if direction.is_none() {
                let help = "give `direction`, such as [1, 0, 0]";
                self.fault("direction", "the direction of the acceleration is missing", help);
            }
            let node = match sensor.node {
                Some(node) => self.node("node", node, sets),
                None => {
                    let help = "give `node`, whose acceleration it measures";
                    self.fault("node", "its node is missing", help);
                    None
                }
            };
            let (node, direction) = (node?, direction?);
            return Some(BeltSensor::Acceleration { node, direction, limit, duration });
        }
        if let Some(limit) = pull_out_rate {
            self.need("pull_out_rate", limit, limit >= 0.0, "0 or above");
            let name = sensor.retractor.as_deref().unwrap_or_default();
            let retractor = self.retractor_named("retractor", name, retractors)?;
            return Some(BeltSensor::PullOutRate { retractor, limit, duration });
        }
        let [a, b] = nodes?.map(|label| self.node("nodes", label, sets));
        let limits = [sensor.min_distance.unwrap_or(0.0), sensor.max_distance.unwrap_or(f64::MAX)];
        if limits == [0.0, f64::MAX] {
            let help = "give `min_distance` or `max_distance`";
            self.fault("nodes", "no distance of the nodes triggers it", help);
        }
        self.need("min_distance", limits[0], limits[0] >= 0.0, "0 or above");
        self.need("max_distance", limits[1], limits[1] >= limits[0], "above min_distance");
        Some(BeltSensor::Distance { nodes: [a?, b?], limits })
    }
}
