//! Files of `*INCLUDE_TRANSFORM`: their ids are offset, their numbers are in other units, and their
//! points are moved, when their cards are read.

use super::affine::Affine;
use super::convert::segment_sets::number_of_ids;
use super::diagnostics::Trouble;
use super::record::{CardLine, CardRecord, Given, Value};
use super::roles::{FieldRole, OffsetKind, UnitPowers, roles_of};
use super::table::FieldType;
use crate::input::job::tree::Place;
use crumple_proto::ids::{ElemId, NodeId};
use std::collections::HashMap;

/// Keyword of bounds of the motion of rigid bodies.
const STOPPERS: &str = "CONSTRAINED_RIGID_BODY_STOPPERS";
/// Keyword of rigid bodies of nodes.
const NODAL_BODY: &str = "CONSTRAINED_NODAL_RIGID_BODY";

/// Offsets of ids by kind, in the order of [`OffsetKind`].
pub type IdOffsets = [i64; 8];

/// Change of a file that is included with `*INCLUDE_TRANSFORM`, relative to the whole deck.
#[derive(Clone, Debug, PartialEq)]
pub struct Submodel {
    /// Offsets of ids.
    pub offsets: IdOffsets,
    /// Factors on mass, length and time.
    pub units: [f64; 3],
    /// Map of points, after the change of units.
    pub map: Affine,
    /// Text before and after headings.
    pub affixes: [String; 2],
}

impl Default for Submodel {
    fn default() -> Self {
        Self {
            offsets: [0; 8],
            units: [1.0; 3],
            map: Affine::default(),
            affixes: [String::new(), String::new()],
        }
    }
}

/// Curves whose numbers have to be converted: their factors of units, and the dimensions of
/// abscissa and ordinate by their use.
#[derive(Debug, Default)]
pub struct CurveUnits {
    /// Factors on mass, length and time by curve.
    pub factors: HashMap<i64, [f64; 3]>,
    /// Dimensions by curve, with the place of a use; `None` after two different uses.
    pub uses: HashMap<i64, (Option<[UnitPowers; 2]>, Place)>,
}

/// Returns the factor of a number with a dimension.
pub fn factor(units: &[f64; 3], dimension: &UnitPowers) -> f64 {
    units.iter().zip(dimension).map(|(unit, &power)| unit.powi(power)).product()
}

impl Submodel {
    /// Returns the change of a file that a file with the change `outer` includes.
    pub fn within(self, outer: &Self) -> Self {
        // The map of the file is in the units of the file that includes it.
        let lengths = outer.units[1];
        let map = match lengths == 1.0 {
            true => self.map,
            false => {
                Affine::scale([1.0 / lengths; 3]).then(&self.map).then(&Affine::scale([lengths; 3]))
            }
        };
        let [mut before, mut after] = self.affixes;
        before = joined(&outer.affixes[0], &before);
        after = joined(&after, &outer.affixes[1]);
        Self {
            offsets: std::array::from_fn(|k| self.offsets[k].saturating_add(outer.offsets[k])),
            units: std::array::from_fn(|k| self.units[k] * outer.units[k]),
            map: map.then(&outer.map),
            affixes: [before, after],
        }
    }

    /// Returns an id of the whole deck; 0 stays 0, and a sign is kept.
    pub fn id(&self, kind: OffsetKind, id: i64) -> i64 {
        let offset = self.offsets[kind as usize];
        match id {
            0 => 0,
            i64::MIN..=-1 => id.saturating_sub(offset),
            _ => id.saturating_add(offset),
        }
    }

    /// Returns the id of a node.
    pub fn node(&self, id: NodeId) -> NodeId {
        NodeId(self.unsigned(OffsetKind::Node, id.0))
    }

    /// Returns the id of an element.
    pub fn element(&self, id: ElemId) -> ElemId {
        ElemId(self.unsigned(OffsetKind::Element, id.0))
    }

    /// Returns the id of a part.
    pub fn part(&self, id: u64) -> u64 {
        self.unsigned(OffsetKind::Part, id)
    }

    fn unsigned(&self, kind: OffsetKind, id: u64) -> u64 {
        let id = i64::try_from(id).unwrap_or(i64::MAX);
        u64::try_from(self.id(kind, id)).unwrap_or(0)
    }

    /// Returns the coordinates of a point in the whole deck [length].
    pub fn point(&self, x: [f64; 3]) -> [f64; 3] {
        self.map.point(x.map(|c| c * self.units[1]))
    }

    /// Returns a length of the whole deck.
    pub fn length(&self, x: f64) -> f64 {
        x * self.units[1]
    }

    /// Returns true if numbers have other units.
    pub fn has_units(&self) -> bool {
        self.units != [1.0; 3]
    }

    /// Changes a record of the file, and notes the units of its curves.
    pub fn apply(&self, record: &mut CardRecord, curves: &mut CurveUnits, trouble: &mut Trouble) {
        let keyword = record.row.keyword.name;
        let roles = roles_of(keyword);
        if self.has_units() && !roles.has_units {
            let message = format!(
                "{} is in a file with factors of units (*INCLUDE_TRANSFORM), which cannot convert \
                 its numbers",
                record.name()
            );
            let help = "convert them in the file, or move the keyword to a file without factors";
            trouble.error(record.head, message, help);
        }
        self.condition(record, trouble);
        let by_type: Vec<_> =
            record.all_lines().iter().map(|line| ids_by_type(record, line)).collect();
        for (line, by_type) in record.all_lines_mut().iter_mut().zip(&by_type) {
            let fields = line.fields();
            let values = line.values_mut();
            let is_local = by_type.contains_key(LOCAL_AXES);
            for (index, field) in fields.iter().enumerate() {
                let role =
                    by_type.get(field.name.as_str()).copied().or_else(|| roles.of(&field.name));
                let is_vector = index + 3 <= fields.len();
                match role {
                    _ if field.kind == FieldType::Line || field.name == "heading" => {
                        self.affix(&mut values[index].given);
                    }
                    Some(FieldRole::Id(kind)) => self.integer(&mut values[index].given, kind),
                    Some(FieldRole::Curve(x, y)) => {
                        self.integer(&mut values[index].given, OffsetKind::Function);
                        if let Given::Integer(id) = values[index].given {
                            // A negative id selects another meaning of the values.
                            curves.note(id.saturating_abs(), [x, y], values[index].place);
                        }
                    }
                    Some(FieldRole::Number(dimension)) => {
                        if let Given::Real(x) = &mut values[index].given {
                            *x *= factor(&self.units, &dimension);
                        }
                    }
                    Some(role) if is_vector => {
                        self.vector(role, is_local, &mut values[index..index + 3]);
                    }
                    Some(_) | None => {}
                }
            }
        }
        self.special(record, trouble);
        if self.has_units() && keyword == "DEFINE_CURVE" {
            curves.factors.insert(record.integer("lcid"), self.units);
        }
        record.in_submodel = true;
        record.all_lines_mut().iter_mut().for_each(CardLine::forget_asked);
    }

    /// Reports what the new position does not apply to.
    fn condition(&self, record: &CardRecord, trouble: &mut Trouble) {
        let keyword = record.row.keyword.name;
        let along_axes = [
            "BOUNDARY_SPC",
            "BOUNDARY_PRESCRIBED_MOTION",
            "LOAD_NODE",
            "LOAD_RIGID_BODY",
            "LOAD_BODY",
            "LOAD_GRAVITY",
            "MAT_RIGID",
            NODAL_BODY,
            "CONSTRAINED_GLOBAL",
            "CONSTRAINED_LINEAR_GLOBAL",
            "CONSTRAINED_INTERPOLATION",
            "CONSTRAINED_NODE_SET",
            STOPPERS,
        ];
        let is_rotation = keyword.starts_with("BOUNDARY_PRESCRIBED_MOTION")
            && record.integer("dof").unsigned_abs() >= 9;
        if is_rotation && self.map != Affine::default() {
            let message = format!(
                "{}: a rotation about an axis with offsets, in a file that *INCLUDE_TRANSFORM \
                 moves",
                record.name()
            );
            let help = "move the keyword to a file that is not moved, with the new offsets";
            trouble.error(record.place("dof"), message, help);
        } else if keyword == STOPPERS
            && ["lcmax", "lcmin"].iter().any(|field| record.integer(field) > 0)
            && self.map != Affine::default()
        {
            let message = format!(
                "{}: bounds of a coordinate, in a file that *INCLUDE_TRANSFORM moves",
                record.name()
            );
            let help = "give negative ids, for bounds of the displacement, or move the keyword to \
                        a file that is not moved, with the new coordinates";
            trouble.error(record.head, message, help);
        } else if !self.map.turns() || follows_a_vector(record) {
            // Directions stay as they are.
        } else if along_axes.iter().any(|k| keyword.starts_with(k))
            && (!["MAT_RIGID", NODAL_BODY].contains(&keyword) || record.real("cmo") != 0.0)
        {
            let message = format!(
                "{} is in a file that *INCLUDE_TRANSFORM turns, but its degrees of freedom are \
                 along the axes of the whole deck",
                record.name()
            );
            let help = "check these directions: only points and vectors turn with the file";
            trouble.warn_once(&format!("submodel axes {keyword}"), record.head, message, help);
        }
    }

    /// Changes the ids of curves that fields give as negative numbers.
    fn negative_curves(&self, record: &mut CardRecord, fields: &[&str]) {
        for field in fields {
            let given = record.real(field);
            if given < 0.0 {
                let curve = self.id(OffsetKind::Function, -given as i64);
                record.put(field, -(curve as f64));
            }
        }
    }

    /// Changes fields that depend on several others.
    fn special(&self, record: &mut CardRecord, trouble: &mut Trouble) {
        match record.row.keyword.name {
            name if name.starts_with("SET_") && name.ends_with("_GENERAL") => {
                self.general_set(record);
            }
            "DEFINE_BOX" => self.sides(record, trouble),
            _ if self.map.reflects() && record.line("xhev").is_some() => {
                let message = format!(
                    "{}: a rectangle in a file that *INCLUDE_TRANSFORM reflects",
                    record.name()
                );
                let help = "move the keyword to a file that is not reflected";
                trouble.error(record.place("xhev"), message, help);
            }
            "CONSTRAINED_JOINT_SCREW" if self.map.reflects() => {
                let message = format!(
                    "{}: a screw in a file that *INCLUDE_TRANSFORM reflects keeps its lead",
                    record.name()
                );
                let help = "change the sign of parm for a screw that is reflected too";
                trouble.warning(record.place("parm"), message, help);
            }
            "SET_SEGMENT" | "LOAD_SEGMENT" if self.map.reflects() => reverse_faces(record),
            name if name.starts_with("AIRBAG_") => self.negative_curves(record, &["cn", "area"]),
            "MAT_ADD_DAMAGE_GISSMO" | "MAT_ADD_EROSION" => {
                self.negative_curves(record, &["ecrit"]);
            }
            // A rule of integration.
            "SECTION_BEAM" if record.real("qr") < 0.0 => {
                let rule = self.id(OffsetKind::Other, -record.real("qr") as i64);
                record.put("qr", -(rule as f64));
            }
            "PART" | "CONSTRAINED_NODAL_RIGID_BODY" if record.line("ixx").is_some() => {
                self.inertia(record);
            }
            "INITIAL_VELOCITY_GENERATION" if record.real("nx") == -999.0 => {
                for name in ["ny", "nz"] {
                    let node = self.id(OffsetKind::Node, record.real(name) as i64) as f64;
                    record.put(name, node);
                }
            }
            _ => {}
        }
    }

    fn general_set(&self, record: &mut CardRecord) {
        let is_of_segments = record.row.keyword.name == "SET_SEGMENT_GENERAL";
        for line in record.all_lines_mut() {
            let word = line.word("option").to_ascii_uppercase();
            let kind = match word.strip_prefix('D').unwrap_or(&word) {
                "NODE" | "SEG" => OffsetKind::Node,
                "PART" => OffsetKind::Part,
                "SHELL" | "ELEM" => OffsetKind::Element,
                "BOX" | "BOX_SHELL" | "BOX_SOLID" => OffsetKind::Definition,
                _ => OffsetKind::Set,
            };
            let count = match is_of_segments {
                true => number_of_ids(&word),
                false => usize::MAX,
            };
            let fields = line.fields();
            let values = line.values_mut();
            let ids = values.iter_mut().zip(fields).filter(|(_, f)| f.name == "e").take(count);
            for (value, _) in ids {
                // The ids of segments are on a card that has attributes too.
                if let Given::Real(x) = value.given
                    && x.fract() == 0.0
                {
                    value.given = Given::Integer(x as i64);
                }
                self.integer(&mut value.given, kind);
            }
            if word == "SEG" && self.map.reflects() {
                reverse_face(line, "e");
            }
        }
    }

    fn sides(&self, record: &mut CardRecord, trouble: &mut Trouble) {
        let names = [["xmn", "xmx"], ["ymn", "ymx"], ["zmn", "zmx"]];
        let given = names.map(|pair| pair.map(|name| self.length(record.real(name))));
        match self.map.sides(given) {
            Some(image) => {
                for (name, x) in names.iter().flatten().zip(image.iter().flatten()) {
                    record.put(name, *x);
                }
            }
            None => {
                let message = "*DEFINE_BOX is in a file that *INCLUDE_TRANSFORM turns by other \
                               than right angles";
                let help = "move the box to a file that is not turned";
                trouble.error(record.head, message, help);
            }
        }
    }

    fn inertia(&self, record: &mut CardRecord) {
        let names = [["ixx", "ixy", "ixz"], ["ixy", "iyy", "iyz"], ["ixz", "iyz", "izz"]];
        if record.integer("ircs") != 0 {
            return;
        }
        let image = self.map.tensor(names.map(|row| row.map(|name| record.real(name))));
        for (name, x) in names.iter().flatten().zip(image.iter().flatten()) {
            record.put(name, *x);
        }
    }

    fn integer(&self, given: &mut Given, kind: OffsetKind) {
        if let Given::Integer(id) = given {
            *id = self.id(kind, *id);
        }
    }

    /// Adds the texts before and after a heading.
    fn affix(&self, given: &mut Given) {
        if let Given::Word(text) = given {
            let [before, after] = &self.affixes;
            *text = joined(&joined(before, text), after);
        }
    }

    /// Changes the components of a vector; those of a velocity with axes of its own only change
    /// their units.
    fn vector(&self, role: FieldRole, is_local: bool, values: &mut [Value]) {
        let number = |given: &Given| match given {
            Given::Real(x) => *x,
            Given::Integer(i) => *i as f64,
            _ => 0.0,
        };
        let given = [0, 1, 2].map(|c| number(&values[c].given));
        let rate =
            |v: [f64; 3], dimension: UnitPowers| v.map(|c| c * factor(&self.units, &dimension));
        let image = match role {
            // The axes turn with the file.
            FieldRole::Point if is_local => given.map(|c| c * self.units[1]),
            FieldRole::Direction if is_local => given,
            FieldRole::Point => self.point(given),
            FieldRole::Direction => self.map.direction(given),
            FieldRole::Velocity if is_local => rate(given, [0, 1, -1]),
            FieldRole::Velocity => self.map.direction(rate(given, [0, 1, -1])),
            FieldRole::Spin if is_local => rate(given, [0, 0, -1]),
            FieldRole::Spin => self.map.axial(rate(given, [0, 0, -1])),
            _ => return,
        };
        for (value, x) in values.iter_mut().zip(image) {
            if x != 0.0 || value.given != Given::Blank {
                value.given = Given::Real(x);
            }
        }
    }
}

/// Returns true if the directions of a record are those of a vector, which turns with the file.
fn follows_a_vector(record: &CardRecord) -> bool {
    match record.row.keyword.name {
        STOPPERS => record.integer("dir") == 4,
        "LOAD_BODY_VECTOR" => true,
        keyword if keyword.starts_with("BOUNDARY_PRESCRIBED_MOTION") => {
            matches!(record.integer("dof").unsigned_abs(), 4 | 8)
        }
        _ => false,
    }
}

/// Reverses the order of the nodes of faces, whose normals a reflection would turn.
fn reverse_faces(record: &mut CardRecord) {
    record.all_lines_mut().iter_mut().for_each(|line| reverse_face(line, "n"));
}

/// Reverses the order of the four nodes of the face that a list of a line begins with.
fn reverse_face(line: &mut CardLine, list: &str) {
    let fields = line.fields();
    let ids = (0..fields.len()).filter(|&k| fields[k].name == list);
    let ids: Vec<usize> = ids.take(4).collect();
    let values = line.values_mut();
    let mut nodes: Vec<Given> = ids.iter().map(|&k| values[k].given.clone()).collect();
    let is_node = |given: &Given| matches!(given, Given::Integer(i) if *i != 0);
    nodes.retain(is_node);
    nodes.dedup();
    let Some(last) = nodes.last().cloned() else { return };
    nodes[1..].reverse();
    let end = nodes.last().cloned().unwrap_or(last);
    nodes.resize(ids.len(), end);
    for (&k, given) in ids.iter().zip(nodes) {
        values[k].given = given;
    }
}

/// Key of [`ids_by_type`] for lines whose velocities are along axes of their own.
const LOCAL_AXES: &str = "local axes";

/// Returns the roles of fields whose kind another field of the line or record gives.
fn ids_by_type(record: &CardRecord, line: &CardLine) -> HashMap<&'static str, FieldRole> {
    let mut roles = HashMap::new();
    let keyword = record.row.keyword.name;
    let id = FieldRole::Id;
    let integer = |name: &str| match line.fields().iter().any(|field| field.name == name) {
        true => line.integer(name),
        false => record.integer(name),
    };
    for (field, of) in [("surfa", "surfatyp"), ("surfb", "surfbtyp")] {
        let kind = if integer(of) == 3 { OffsetKind::Part } else { OffsetKind::Set };
        roles.insert(field, id(kind));
    }
    if keyword.ends_with("_IN_SOLID") {
        let sides =
            [("bsid", "bstyp"), ("ssid", "sstyp"), ("lstrsid", "lstrsty"), ("alesid", "alesty")];
        for (field, of) in sides {
            let kind = if integer(of) == 1 { OffsetKind::Part } else { OffsetKind::Set };
            roles.insert(field, id(kind));
        }
    }
    let has_axes = ["DEFINE_VECTOR", "LOAD_BODY_VECTOR"].contains(&keyword) && integer("cid") != 0;
    if has_axes || integer("icid") != 0 {
        roles.insert(LOCAL_AXES, FieldRole::Number([0; 3]));
    }
    if keyword == "INITIAL_VELOCITY_GENERATION" {
        let kind = if integer("styp") == 2 { OffsetKind::Part } else { OffsetKind::Set };
        roles.insert("id", id(kind));
        if record.real("nx") == -999.0 {
            roles.insert("nx", FieldRole::Number([0; 3]));
        }
        if record.real("omega") == 0.0 {
            roles.insert("xc", FieldRole::Number([0, 1, 0])); // without a spin no centre moves
        }
    }
    // The energy over an area, in place of a displacement.
    if keyword == "MAT_ADD_DAMAGE_DIEM" && integer("detyp") == 1 {
        roles.insert("q1", FieldRole::Number([1, 0, -2]));
    }
    let is_volume = line.real("mass") < 0.0 || record.has("VOLUME");
    if keyword == "ELEMENT_SPH" && is_volume {
        roles.insert("mass", FieldRole::Number([0, 3, 0]));
    }
    if line.word("ptype").eq_ignore_ascii_case("PSET") {
        roles.insert("pid", id(OffsetKind::Set));
        roles.insert("rpid", id(OffsetKind::Set));
    }
    if line.word("dptype").eq_ignore_ascii_case("PSET") {
        roles.insert("dpid", id(OffsetKind::Set));
    }
    if keyword == "CONSTRAINED_INTERPOLATION" && integer("ityp") == 1 {
        roles.insert("inid", id(OffsetKind::Set));
    }
    let dof = integer("dof").unsigned_abs();
    let rotates = matches!(dof, 5..=11);
    if keyword.starts_with("LOAD_NODE") || keyword == "LOAD_RIGID_BODY" {
        let amount = if dof < 5 { [1, 1, -2] } else { [1, 2, -2] };
        roles.insert("lcid", FieldRole::Curve([0, 0, 1], amount));
    }
    if keyword.starts_with("BOUNDARY_PRESCRIBED_MOTION") {
        let rate = match integer("vad") {
            0 => -1,
            1 => -2,
            _ => 0,
        };
        roles.insert("lcid", FieldRole::Curve([0, 0, 1], [0, i32::from(!rotates), rate]));
    }
    roles
}

impl CurveUnits {
    /// Notes the dimensions with which a curve is used.
    fn note(&mut self, id: i64, dimensions: [UnitPowers; 2], place: Place) {
        let of = self.uses.entry(id).or_insert((Some(dimensions), place));
        if of.0.is_some_and(|known| known != dimensions) {
            *of = (None, place);
        }
    }

    /// Returns the factors on abscissa and ordinate of a curve. Reports a curve whose dimensions
    /// are not known.
    pub fn of(&self, id: i64, place: Place, trouble: &mut Trouble) -> [f64; 2] {
        let Some(units) = self.factors.get(&id) else { return [1.0; 2] };
        match self.uses.get(&id) {
            Some((Some(dimensions), _)) => {
                [factor(units, &dimensions[0]), factor(units, &dimensions[1])]
            }
            found => {
                let why = match found {
                    Some(_) => "it is used as two different quantities",
                    None => "the dimensions of its use are not known",
                };
                let message =
                    format!("*DEFINE_CURVE {id} is in a file with factors of units, and {why}");
                let help = "give it in the units of the whole deck, in a file without factors";
                trouble.error(place, message, help);
                [1.0; 2]
            }
        }
    }
}

/// Joins two texts by a dot, unless one of them is empty.
fn joined(first: &str, second: &str) -> String {
    match (first.is_empty(), second.is_empty()) {
        (true, _) => second.into(),
        (_, true) => first.into(),
        _ => format!("{first}.{second}"),
    }
}
