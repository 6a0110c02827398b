//! Converts parts of discrete beams: `*SECTION_BEAM` with elform 6 and the laws for it.

use super::DeckConverter;
use super::parts::DeckPart;
use super::sections::{DeckSection, SectionKind};
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::{NodeContent, Place};
use crumple_proto::mesh::{MeshElement, Shape};
use std::collections::BTreeSet;

/// Keywords of the laws.
const LAWS: [&str; 5] =
    [LINEAR, "MAT_NONLINEAR_ELASTIC_DISCRETE_BEAM", PLASTIC, UNLOADING, GENERAL];
const LINEAR: &str = "MAT_LINEAR_ELASTIC_DISCRETE_BEAM";
const PLASTIC: &str = "MAT_NONLINEAR_PLASTIC_DISCRETE_BEAM";
const UNLOADING: &str = "MAT_GENERAL_NONLINEAR_6DOF_DISCRETE_BEAM";
const GENERAL: &str = "MAT_GENERAL_SPRING_DISCRETE_BEAM";

/// Axes of the job, with the fields of stiffness and damping and those of their curves.
const AXES: [(&str, [&str; 2], [&str; 2]); 6] = [
    ("r", ["tkr", "tdr"], ["lcidtr", "lcidtdr"]),
    ("s", ["tks", "tds"], ["lcidts", "lcidtds"]),
    ("t", ["tkt", "tdt"], ["lcidtt", "lcidtdt"]),
    ("rr", ["rkr", "rdr"], ["lcidrr", "lcidrdr"]),
    ("rs", ["rks", "rds"], ["lcidrs", "lcidrds"]),
    ("rt", ["rkt", "rdt"], ["lcidrt", "lcidrdt"]),
];

/// Fields of all axes: preloads, and limits of forces and displacements.
const PRELOADS: [&str; 6] = ["for", "fos", "fot", "mor", "mos", "mot"];
const FORCE_LIMITS: [&str; 6] = ["ffailr", "ffails", "ffailt", "mfailr", "mfails", "mfailt"];
const LIMITS: [&str; 6] = ["ufailr", "ufails", "ufailt", "tfailr", "tfails", "tfailt"];
/// Curves of yield forces.
const YIELD_CURVES: [&str; 6] = ["lcpdr", "lcpds", "lcpdt", "lcpmr", "lcpms", "lcpmt"];
/// Curves of unloading, limits in tension and compression, and displacements of the start.
const UNLOADING_CURVES: [&str; 6] =
    ["lcidtur", "lcidtus", "lcidtut", "lcidrur", "lcidrus", "lcidrut"];
const LIMITS_IN_TENSION: [&str; 6] =
    ["utfailr", "utfails", "utfailt", "wtfailr", "wtfails", "wtfailt"];
const LIMITS_IN_COMPRESSION: [&str; 6] =
    ["ucfailr", "ucfails", "ucfailt", "wcfailr", "wcfails", "wcfailt"];
const STARTS: [&str; 6] = ["iur", "ius", "iut", "iwr", "iws", "iwt"];

/// Returns true for a section of discrete beams.
pub(super) fn is_discrete(section: &DeckSection) -> bool {
    section.kind == SectionKind::Beam && section.record.integer("elform") == 6
}

impl DeckConverter {
    /// Reads the laws.
    pub(super) fn discrete_beam_laws(&mut self) {
        for record in LAWS.iter().flat_map(|law| self.take_records(law)).collect::<Vec<_>>() {
            let (mid, place) = (record.integer("mid"), record.place("mid"));
            if self.discrete_beam_laws.insert(mid, record).is_some() {
                let message = format!("there are two materials with the id {mid}");
                self.trouble.error(place, message, "give each a different id");
            }
        }
    }

    /// Converts a part of discrete beams.
    pub(super) fn discrete_beam_part(
        &mut self,
        record: &CardRecord,
        section: &DeckSection,
        name: &str,
    ) {
        let (pid, mid, card) = (record.integer("pid"), record.integer("mid"), &section.record);
        let place = record.place("pid");
        self.parts.insert(pid, DeckPart { rigid: None, material: None, inertia: None, place });
        let has_axes = card.integer("cid") != 0;
        if let Ok(part) = u32::try_from(pid) {
            self.discrete_beam_parts.insert(part, has_axes);
        }
        let Some(law) = self.discrete_beam_laws.get(&mid).cloned() else {
            let known: Vec<String> = self.discrete_beam_laws.keys().map(i64::to_string).collect();
            let what = "*MAT_..._DISCRETE_BEAM of the kinds 66, 67, 68, 119 and 196";
            return self.missing(record.place("mid"), what, mid, &known);
        };
        let (ro, vol) = (law.real("ro"), card.real("vol"));
        let mut table = JobTable::new(card.head)
            .with("mass", card.place("vol"), ro * vol)
            .with("inertia", card.place("iner"), card.real("iner"))
            .with("turns_with", card.place("scoor"), self.turning_node(card));
        if card.real("scoor").abs() == 2.0 {
            if !self.alike_across(&law) {
                let why = "the springs on s and t differ, and where s and t are about the line \
                           between the nodes is not defined; use equal springs, or -3 or 3";
                self.unsupported_value(card, "scoor", why);
            }
            table.put("along_line", card.place("scoor"), true);
            self.beams_along_lines.extend(u32::try_from(pid));
        }
        if has_axes {
            match self.axes.get(&card.integer("cid")) {
                Some([x, y, _]) => {
                    table.put("axes", card.place("cid"), vec![x.to_vec(), y.to_vec()])
                }
                None => {
                    let known: Vec<String> = self.axes.keys().map(i64::to_string).collect();
                    let (at, id) = (card.place("cid"), card.integer("cid"));
                    self.missing(at, "*DEFINE_COORDINATE_...", id, &known);
                }
            }
        }
        let springs: Vec<JobTable> = match law.row.keyword.name {
            GENERAL => self.springs_by_cards(&law),
            _ => (0..AXES.len()).filter_map(|axis| self.axis_spring(&law, axis)).collect(),
        };
        if springs.iter().any(|spring| spring.has_start("failure_")) {
            let failure = match law.row.keyword.name {
                GENERAL => {
                    let used = "a beam fails when one axis reaches its limit";
                    self.map(law.name(), "cdf and tdf", used);
                    ("any", law.head)
                }
                UNLOADING if law.real("fcrit") == 0.0 => ("by_sign", law.place("fcrit")),
                UNLOADING if law.real("fcrit") != 1.0 => {
                    self.unsupported_value(&law, "fcrit", "use 0 or 1");
                    ("by_sign", law.place("fcrit"))
                }
                _ => ("together", law.head),
            };
            table.put("failure", failure.1, failure.0);
        }
        let used = format!("discrete beams with springs on {} axes", springs.len());
        self.map(format!("part {pid}"), format!("beams, elform 6, {}", law.name()), used);
        table.put("spring", law.head, springs);
        let part = JobTable::new(record.head)
            .with("id", record.place("pid"), pid)
            .with("name", record.place("heading"), name)
            .with("discrete_beam", card.head, table);
        self.add("part", part);
    }

    /// Returns the nodes that rotate the axes.
    fn turning_node(&mut self, card: &CardRecord) -> &'static str {
        match card.real("scoor") {
            0.0 => "both",
            -1.0 | -2.0 | -3.0 => "first",
            1.0 | 2.0 | 3.0 => "second",
            _ => {
                let why = "use -3, -2, -1, 0, 1, 2 or 3";
                self.unsupported_value(card, "scoor", why);
                "both"
            }
        }
    }

    /// Returns the spring on an axis, if the law has one.
    fn axis_spring(&mut self, law: &CardRecord, number: usize) -> Option<JobTable> {
        let (axis, fields, curves) = AXES[number];
        let kind = law.row.keyword.name;
        let mut own = JobTable::new(law.head);
        let mut negative = Vec::new();
        let mut copy = |field: &str, key: &str, size: bool| {
            let value = law.real(field);
            if value != 0.0 {
                own.put(key, law.place(field), if size { value.abs() } else { value });
            }
            if size && value < 0.0 {
                negative.push((format!("{field} {value}"), value.abs()));
            }
        };
        if kind == LINEAR || kind == PLASTIC {
            copy(fields[1], "damping", false);
        }
        if kind == LINEAR {
            copy(fields[0], "stiffness", false);
        }
        if kind == UNLOADING {
            copy(STARTS[number], "initial_displacement", false);
            copy(LIMITS_IN_TENSION[number], "failure_tension", true);
            copy(LIMITS_IN_COMPRESSION[number], "failure_compression", true);
        } else {
            copy(PRELOADS[number], "preload", false);
            if kind != LINEAR {
                copy(FORCE_LIMITS[number], "failure_force", true);
                copy(LIMITS[number], "failure_tension", true);
                copy(LIMITS[number], "failure_compression", true);
            }
        }
        for (asked, size) in negative {
            self.map(law.name(), asked, format!("{size}: a limit is a size"));
        }
        let of = |field: &str| (law.integer(field), law.place(field));
        match kind {
            LINEAR => {}
            PLASTIC => {
                let yields = of(YIELD_CURVES[number]);
                self.yielding(law, &mut own, (fields[0], yields));
            }
            UNLOADING => {
                self.unloading(law, &mut own, number);
                let (id, place) = of(curves[1]);
                if let Some(curve) = (id != 0).then(|| self.curve(id, place)).flatten() {
                    own.put("force_rate", curve.place, points(&curve.points));
                }
            }
            _ => {
                for (field, key) in curves.into_iter().zip(["force_elongation", "force_rate"]) {
                    let (id, at) = of(field);
                    if id != 0
                        && let Some((place, points)) = self.force_curve(law, (id, at))
                    {
                        own.put(key, place, points);
                    }
                }
            }
        }
        let at = law.head;
        (!own.is_empty()).then(|| own.with("axis", at, axis))
    }

    /// Sets the stiffness and the yield forces of an axis, with the field of the stiffness and the
    /// id of the curve.
    fn yielding(
        &mut self,
        law: &CardRecord,
        own: &mut JobTable,
        (field, (id, place)): (&str, (i64, Place)),
    ) {
        let stiffness = law.real(field);
        if stiffness < 0.0 {
            self.unsupported_value(law, field, "a curve of elastic forces");
        } else if id == 0 {
            if stiffness != 0.0 {
                own.put("stiffness", law.place(field), stiffness);
            }
        } else if let Some(law) = self.yield_curve(law, (law.place(field), stiffness), (id, place))
        {
            own.put("yielding", place, law);
        }
    }

    /// Returns the law with a curve of yield forces.
    fn yield_curve(
        &mut self,
        law: &CardRecord,
        (at, stiffness): (Place, f64),
        (id, place): (i64, Place),
    ) -> Option<JobTable> {
        let curve = self.curve(id, place)?;
        if curve.points.first().is_some_and(|p| p[0] >= 0.0) {
            let asked = format!("curve {id} has no negative plastic displacements");
            self.map(law.name(), asked, "the same in both directions");
        }
        Some(JobTable::new(law.head).with("stiffness", at, stiffness).with(
            "yield_force",
            curve.place,
            points(&curve.points),
        ))
    }

    /// Sets the curves of loading and unloading of an axis.
    fn unloading(&mut self, law: &CardRecord, own: &mut JobTable, number: usize) {
        let [loading, unloading] = [AXES[number].2[0], UNLOADING_CURVES[number]]
            .map(|field| (law.integer(field), law.place(field)));
        if loading.0 == 0 {
            return;
        }
        let Some(curve) = self.curve(loading.0, loading.1) else { return };
        let loads = points(&curve.points);
        let has_own = unloading.0 != 0 && unloading.0 != loading.0;
        let mut of_law = JobTable::new(law.head).with("loading", curve.place, loads.clone());
        let key = match law.integer("iunld") {
            1 if has_own => {
                let used = "the curve is shifted to the point where unloading begins, and leaves \
                            its displacement";
                self.map(law.name(), "iunld 1", used);
                "hysteresis"
            }
            2 if has_own => {
                let field = if number < 3 { "kt" } else { "kr" };
                let at = law.place(field);
                if law.real(field) == 0.0 {
                    let why = "a stiffness that the program computes; give that of unloading";
                    return self.unsupported_value(law, field, why);
                }
                of_law.put("stiffness", at, law.real(field));
                "between_curves"
            }
            3 => {
                let used = "a parabola with its vertex at the permanent set";
                self.map(law.name(), "iunld 3", used);
                of_law.put("fraction", law.place("offset"), law.real("offset"));
                return own.put("permanent_set", law.head, of_law);
            }
            0..=2 => return own.put("force_elongation", curve.place, loads),
            _ => return self.unsupported_value(law, "iunld", "use 0, 1, 2 or 3"),
        };
        if let Some(curve) = self.curve(unloading.0, unloading.1) {
            of_law.put("unloading", curve.place, points(&curve.points));
            own.put(key, law.head, of_law);
        }
    }

    /// Returns the points of a curve of forces, with its place. One that begins at the origin acts
    /// alike in both directions.
    fn force_points(
        &mut self,
        law: &CardRecord,
        (id, place): (i64, Place),
    ) -> Option<(Place, Vec<[f64; 2]>)> {
        let curve = self.curve(id, place)?;
        let mut points: Vec<[f64; 2]> = Vec::new();
        if curve.points.first() == Some(&[0.0, 0.0]) {
            points.extend(curve.points[1..].iter().rev().map(|p| p.map(|x| -x)));
            let asked = format!("curve {id} begins at the origin");
            self.map(law.name(), asked, "the same in both directions");
        }
        points.extend(curve.points.iter());
        Some((curve.place, points))
    }

    /// Returns them for the job.
    fn force_curve(
        &mut self,
        law: &CardRecord,
        curve: (i64, Place),
    ) -> Option<(Place, NodeContent)> {
        let (place, own) = self.force_points(law, curve)?;
        Some((place, points(&own)))
    }

    /// Returns the springs of a law with a card for each axis.
    fn springs_by_cards(&mut self, law: &CardRecord) -> Vec<JobTable> {
        let [cards, curves] =
            ["dof", "flcid"].map(|field| law.lines(field).cloned().collect::<Vec<_>>());
        let mut springs: Vec<JobTable> = Vec::new();
        let mut seen = BTreeSet::new();
        for (k, card) in cards.iter().enumerate() {
            let (dof, place) = (card.integer("dof"), card.place("dof"));
            // Cards at the end may be left out.
            if dof == 0 {
                continue;
            }
            let axis = usize::try_from(dof - 1).ok().and_then(|axis| AXES.get(axis));
            let Some(&(axis, ..)) = axis.filter(|_| seen.insert(dof)) else {
                let message = format!("{}: `dof` is {dof}", law.name());
                let help = "give each of 1 to 6 once: along r, s, t, then about them";
                self.trouble.error(place, message, help);
                continue;
            };
            let mut own = JobTable::new(law.head).with("axis", place, axis);
            // The last card may be left out.
            let more = curves.get(k);
            let of = |field: &str| {
                more.map(|more| (more.integer(field), more.place(field))).filter(|(id, _)| *id != 0)
            };
            let kind = card.integer("type");
            match (kind, of("flcid")) {
                (0, None) => own.put("stiffness", card.place("k"), card.real("k")),
                (0, Some(curve)) => {
                    let Some((at, points)) = self.force_curve(law, curve) else { continue };
                    own.put("force_elongation", at, points);
                }
                (1, Some(curve)) => {
                    let stiffness = (card.place("k"), card.real("k"));
                    let Some(yields) = self.yield_curve(law, stiffness, curve) else { continue };
                    own.put("yielding", curve.1, yields);
                }
                (1, None) => {
                    let asked = format!("dof {dof} of type 1 without flcid");
                    self.map(law.name(), asked, "elastic, as it has no yield forces");
                    own.put("stiffness", card.place("k"), card.real("k"));
                }
                _ => {
                    let message = format!("{}: `type` = {kind} is not supported", law.name());
                    self.unsupported(card.place("type"), message, format!("{} type", law.name()));
                    continue;
                }
            }
            let damping = card.real("d");
            match of("hlcid") {
                None if damping != 0.0 => own.put("damping", card.place("d"), damping),
                None => {}
                Some(curve) => {
                    let Some((at, mut points)) = self.force_points(law, curve) else { continue };
                    points.iter_mut().for_each(|p| p[1] += damping * p[0]);
                    own.put("force_rate", at, self::points(&points));
                }
            }
            for (field, key) in [("tdf", "failure_tension"), ("cdf", "failure_compression")] {
                if card.real(field) != 0.0 {
                    own.put(key, card.place(field), card.real(field).abs());
                }
                if field == "cdf" && card.real(field) != 0.0 {
                    let asked = format!("cdf of dof {dof}");
                    let used =
                        "acts on beams of any length; the format leaves out those without one";
                    self.map(law.name(), asked, used);
                }
            }
            springs.push(own);
        }
        springs
    }

    /// Returns true if a law has the same springs along s and t, and the same about them.
    fn alike_across(&self, law: &CardRecord) -> bool {
        let points = |id: f64| self.curves.get(&(id as i64)).map(|curve| &curve.points);
        // Both directions of an axis are alike too: points from 0 on, or odd ones.
        let is_odd = |id: f64| {
            points(id).is_none_or(|points| {
                let mirrored = points.iter().rev().map(|p| p.map(|x| 0.0 - x));
                points.first().is_none_or(|p| p[0] >= 0.0) || points.iter().copied().eq(mirrored)
            })
        };
        let same_curve = |a: f64, b: f64| a == b || points(a).is_some() && points(a) == points(b);
        if law.row.keyword.name == GENERAL {
            let [cards, curves] =
                ["dof", "flcid"].map(|field| law.lines(field).cloned().collect::<Vec<_>>());
            let of_axis = |dof: i64| cards.iter().position(|card| card.integer("dof") == dof);
            let same = |a: usize, b: usize| {
                let of = |k: usize, field| curves.get(k).map_or(0.0, |line| line.real(field));
                cards[a].real("cdf").abs() == cards[a].real("tdf").abs()
                    && ["flcid", "hlcid"].iter().all(|field| is_odd(of(a, field)))
                    && ["type", "k", "d", "cdf", "tdf"]
                        .iter()
                        .all(|field| cards[a].real(field) == cards[b].real(field))
                    && ["flcid", "hlcid"].iter().all(|field| same_curve(of(a, field), of(b, field)))
            };
            return [(2, 3), (5, 6)].iter().all(|&(s, t)| match (of_axis(s), of_axis(t)) {
                (Some(a), Some(b)) => same(a, b),
                (None, None) => true,
                _ => false,
            });
        }
        let [stiffness, damping] = [0, 1].map(|k| AXES.map(|axis| axis.1[k]));
        let [elastic, viscous] = [0, 1].map(|k| AXES.map(|axis| axis.2[k]));
        let numbers = [
            stiffness,
            damping,
            PRELOADS,
            FORCE_LIMITS,
            LIMITS,
            LIMITS_IN_TENSION,
            LIMITS_IN_COMPRESSION,
            STARTS,
        ];
        let curves = [elastic, viscous, YIELD_CURVES, UNLOADING_CURVES];
        let pairs = [(1, 2), (4, 5)];
        let number = |field: &str| law.real(field);
        let across = [1, 2, 4, 5];
        let is_directed = |c: usize| {
            number(PRELOADS[c]) != 0.0
                || number(STARTS[c]) != 0.0
                || number(LIMITS_IN_TENSION[c]) != number(LIMITS_IN_COMPRESSION[c])
                || curves.iter().any(|of| !is_odd(number(of[c])))
        };
        if across.into_iter().any(is_directed) {
            return false;
        }
        numbers.iter().all(|of| pairs.iter().all(|&(s, t)| number(of[s]) == number(of[t])))
            && curves
                .iter()
                .all(|of| pairs.iter().all(|&(s, t)| same_curve(number(of[s]), number(of[t]))))
    }

    /// Makes a beam of a part of discrete beams two nodes with a spring between them. Returns true
    /// if it is one.
    pub(super) fn discrete_beam(&mut self, index: usize) -> bool {
        let beam = self.rows.beams[index];
        let Some(&has_axes) = self.discrete_beam_parts.get(&beam.part) else { return false };
        let ends = [beam.nodes[0], beam.nodes[1]];
        if !has_axes && beam.nodes[2].0 != 0 {
            let message = format!(
                "*ELEMENT_BEAM: discrete beam {} has a third node (n3) and its section no cid; \
                 axes by n3 are not supported",
                beam.id
            );
            let place = self.rows.beam_place(index);
            self.unsupported(place, message, "*ELEMENT_BEAM n3 of discrete beams".into());
        }
        if self.beams_along_lines.contains(&beam.part)
            && let [Some(from), Some(to)] = ends.map(|node| self.rows.at(node))
            && from == to
        {
            let message = format!(
                "*ELEMENT_BEAM: the nodes of discrete beam {} are at one place, and its section \
                 has scoor -2 or 2",
                beam.id
            );
            let help = "use scoor -3 or 3, or move the nodes apart";
            self.trouble.error(self.rows.beam_place(index), message, help);
        }
        self.rows.beams[index] = MeshElement::new(beam.id, beam.part, Shape::Line2, &ends);
        true
    }
}

/// Returns points as a list of the job.
fn points(points: &[[f64; 2]]) -> NodeContent {
    points.iter().map(|p| p.to_vec()).collect::<Vec<_>>().into()
}
