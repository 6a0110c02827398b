//! Converts `*DEFINE_TRANSFORMATION`, and applies it to included files (`*INCLUDE_TRANSFORM`) and
//! to node sets (`*NODE_TRANSFORM`).

use super::DeckConverter;
use super::sets::id;
use super::space::unit;
use crate::input::deck::affine::Affine;
use crate::input::deck::record::{CardLine, CardRecord};
use crate::input::deck::submodel::Submodel;
use crumple_proto::ids::NodeId;
use std::collections::{BTreeSet, HashMap};

/// Fields with the numbers of a line of `*DEFINE_TRANSFORMATION`.
const NUMBERS: [&str; 7] = ["a1", "a2", "a3", "a4", "a5", "a6", "a7"];

/// Points of a transformation by id, with the number of maps before each.
type NamedPoints = HashMap<i64, ([f64; 3], usize)>;

impl DeckConverter {
    /// Reads `*DEFINE_TRANSFORMATION`. `is_moved` is true in a file that itself has another
    /// position.
    pub(super) fn transformation(&mut self, record: &CardRecord, is_moved: bool) {
        let number = record.integer("tranid");
        let mut map = Affine::default();
        let (mut points, mut count) = (NamedPoints::new(), 0);
        for line in record.lines("option") {
            let given = NUMBERS.map(|name| line.real(name));
            let word = line.word("option").to_ascii_uppercase();
            if word == "POINT" {
                points.insert(given[0] as i64, ([given[1], given[2], given[3]], count));
                continue;
            }
            if is_moved && matches!(word.as_str(), "POS6N" | "TRANSL2ND") {
                let message = format!("*DEFINE_TRANSFORMATION: {word} in a file with a position");
                let help = "give points with their coordinates in the file (POINT, POS6P)";
                self.trouble.error(line.place("option"), message, help);
                continue;
            }
            let Some(next) = self.step_of(line, &word, (&points, count)) else { continue };
            map = map.then(&next);
            count += 1;
        }
        if self.transformations.insert(number, map).is_some() {
            let message = format!("there are two *DEFINE_TRANSFORMATION with the id {number}");
            self.trouble.error(record.place("tranid"), message, "give each a different id");
        }
    }

    /// Returns the map of one line.
    fn step_of(
        &mut self,
        line: &CardLine,
        word: &str,
        points: (&NamedPoints, usize),
    ) -> Option<Affine> {
        let given = NUMBERS.map(|name| line.real(name));
        let [a1, a2, a3, a4, a5, a6, a7] = given;
        let place = line.place("option");
        match word {
            "TRANSL" => Some(Affine::translation([a1, a2, a3])),
            "SCALE" => Some(Affine::scale([a1, a2, a3].map(super::curves::one))),
            // Without an angle nothing turns; a1 to a3 may be an axis or points.
            "ROTATE" if [a3, a4, a5, a6, a7] == [0.0; 5] => Some(Affine::default()),
            "ROTATE" if [a4, a5, a6, a7] == [0.0; 4] && points.0.contains_key(&(a1 as i64)) => {
                let [from, to] = [self.point(line, "a1", points), self.point(line, "a2", points)];
                let (from, to) = (from?, to?);
                let axis = unit([0, 1, 2].map(|c| to[c] - from[c]));
                self.axis_of(line, axis).map(|axis| Affine::rotation(axis, from, a3))
            }
            "ROTATE" => self
                .axis_of(line, unit([a1, a2, a3]))
                .map(|axis| Affine::rotation(axis, [a4, a5, a6], a7)),
            "MIRROR" => {
                if a7 != 0.0 {
                    let message =
                        format!("*DEFINE_TRANSFORMATION: MIRROR with a7 = {a7} is not supported");
                    self.unsupported(line.place("a7"), message, "MIRROR a7".into());
                }
                let normal = unit([a4 - a1, a5 - a2, a6 - a3]);
                self.axis_of(line, normal).map(|normal| Affine::mirror([a1, a2, a3], normal))
            }
            "POS6P" | "POS6N" => {
                let mut six = [[0.0; 3]; 6];
                for (place, name) in six.iter_mut().zip(NUMBERS) {
                    *place = match word {
                        "POS6P" => self.point(line, name, points)?,
                        _ => self.node_at(line, name)?,
                    };
                }
                let found = Affine::between(six);
                if found.is_none() {
                    let message = format!("*DEFINE_TRANSFORMATION: points of {word} are on a line");
                    let help = "give three points that are a triangle, and three targets";
                    self.trouble.error(place, message, help);
                }
                found
            }
            "TRANSL2ND" => {
                let (from, to) = (self.node_at(line, "a1")?, self.node_at(line, "a2")?);
                let axis = unit([0, 1, 2].map(|c| to[c] - from[c]));
                self.axis_of(line, axis).map(|axis| Affine::translation(axis.map(|c| c * a3)))
            }
            _ => {
                let message = format!("*DEFINE_TRANSFORMATION: option {word} is not supported");
                let what = format!("*DEFINE_TRANSFORMATION {word}");
                self.unsupported(place, message, what);
                None
            }
        }
    }

    /// Reports a direction of length 0.
    fn axis_of(&mut self, line: &CardLine, axis: Option<[f64; 3]>) -> Option<[f64; 3]> {
        if axis.is_none() {
            let message = "*DEFINE_TRANSFORMATION: an axis or normal has no direction";
            self.trouble.error(line.place("a1"), message, "give two different points");
        }
        axis
    }

    /// Returns the point whose id a field has.
    fn point(
        &mut self,
        line: &CardLine,
        field: &str,
        (points, count): (&NamedPoints, usize),
    ) -> Option<[f64; 3]> {
        let number = line.real(field) as i64;
        match points.get(&number) {
            Some(&(point, before)) if before == count => Some(point),
            Some(_) => {
                let message = format!(
                    "*DEFINE_TRANSFORMATION: POINT {number} precedes another transformation than \
                     the one that uses it"
                );
                let help = "give it again, with its coordinates after the transformations so far, \
                            on a line right before this one";
                self.trouble.error(line.place(field), message, help);
                None
            }
            None => {
                let known: Vec<String> = points.keys().map(i64::to_string).collect();
                self.missing(line.place(field), "POINT", number, &known);
                None
            }
        }
    }

    fn node_at(&mut self, line: &CardLine, field: &str) -> Option<[f64; 3]> {
        let number = line.real(field) as i64;
        let found = id(number).and_then(|node| self.rows.at(node));
        if found.is_none() {
            let message = format!("there is no node {number} above this line");
            let help = "define nodes of a transformation before it, or give points (POINT, POS6P)";
            self.trouble.error(line.place(field), message, help);
        }
        found
    }

    /// Reads the cards of `*INCLUDE_TRANSFORM`: the blocks of its file follow. `outer` is the
    /// change of the file that names it.
    pub(super) fn include_transform(&mut self, record: &CardRecord, outer: &Submodel) {
        let offset = |name: &str| record.integer(name);
        let factor = |name: &str| super::curves::one(record.real(name));
        let tranid = record.integer("tranid");
        let map = match self.transformations.get(&tranid) {
            Some(map) => *map,
            None if tranid == 0 => Affine::default(),
            None => {
                let message =
                    format!("there is no *DEFINE_TRANSFORMATION {tranid} above this line");
                let help = "define it before *INCLUDE_TRANSFORM, or correct the id";
                self.trouble.error(record.place("tranid"), message, help);
                Affine::default()
            }
        };
        if map.stretches() {
            let message = format!("*DEFINE_TRANSFORMATION {tranid} changes lengths of a file");
            let help = "thicknesses, radii, masses and other numbers of the file stay as they are: \
                        only points and vectors change";
            self.trouble.warning(record.place("tranid"), message, help);
        }
        let units = ["fctmas", "fctlen", "fcttim"].map(factor);
        if let Some(bad) = ["fctmas", "fctlen", "fcttim"].iter().find(|f| factor(f) < 0.0) {
            let message = format!("*INCLUDE_TRANSFORM: `{bad}` is below 0");
            self.trouble.error(record.place(bad), message, "give a factor above 0");
        }
        let texts = ["prefix", "suffix"].map(|name| record.word(name).to_string());
        let own = Submodel {
            offsets: [
                offset("idnoff"),
                offset("ideoff"),
                offset("idpoff"),
                offset("idsoff"),
                offset("idmoff"),
                offset("idfoff"),
                offset("iddoff"),
                offset("idroff"),
            ],
            units,
            map,
            affixes: texts,
        };
        self.submodels.push(own.within(outer));
    }

    /// Moves the nodes of `*NODE_TRANSFORM`.
    pub(super) fn node_transforms(&mut self) {
        let mut moved: HashMap<NodeId, Affine> = HashMap::new();
        for record in self.take_records("NODE_TRANSFORM") {
            if record.in_submodel {
                let message = "*NODE_TRANSFORM in a file of *INCLUDE_TRANSFORM is not supported";
                self.unsupported(record.head, message.into(), "*NODE_TRANSFORM".into());
                continue;
            }
            for line in record.lines("trsid") {
                let number = line.integer("trsid");
                let Some(map) = self.transformations.get(&number).copied() else {
                    let known: Vec<String> =
                        self.transformations.keys().map(i64::to_string).collect();
                    self.missing(line.place("trsid"), "*DEFINE_TRANSFORMATION", number, &known);
                    continue;
                };
                let nsid = line.integer("nsid");
                if self.node_set(nsid, line.place("nsid")).is_none() {
                    continue;
                }
                for &node in &self.node_sets[&nsid].0 {
                    let chain = moved.entry(node).or_default();
                    *chain = chain.then(&map);
                }
            }
        }
        if !moved.is_empty() {
            let nodes: BTreeSet<NodeId> = moved.keys().copied().collect();
            self.rows.move_nodes(&nodes, |node, x| moved[&node].point(x));
        }
    }
}
