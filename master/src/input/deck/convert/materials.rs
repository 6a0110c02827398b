//! Converts `*MAT_...`: laws and their parameters.

use super::DeckConverter;
use super::cohesive::{self, CohesiveIntegration};
use super::solid_welds::WeldLimits;
use super::tree::JobTable;
use super::{composites, concrete, metals, polymers, pressure_dependent, soft_materials};
use crate::input::deck::BEYOND_ALL_STRAINS;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use std::collections::HashMap;

/// A material of the deck.
#[derive(Debug)]
pub struct DeckMaterial {
    /// Name in the job.
    pub name: String,
    /// Its table in the job, until a part uses it.
    pub table: Option<JobTable>,
    /// Degrees of freedom that a rigid part of this material fixes; `None` if it is not rigid.
    pub rigid: Option<Vec<&'static str>>,
    /// True if it carries no load.
    pub skin: bool,
    /// Its card, if particles can have it.
    pub fluid: Option<CardRecord>,
    /// True if it is elastic.
    pub elastic: bool,
    /// True if it has axes in the plane of a shell.
    pub has_axes: bool,
    /// Angle of these axes that the angle of a shell replaces [degrees].
    pub turn: f64,
    /// Integration of cohesive elements, if it is for them.
    pub cohesive: Option<CohesiveIntegration>,
    /// Limits of welds, with their place.
    pub weld: Option<(WeldLimits, Place)>,
    /// Stable step below which elements are deleted, if any [time].
    pub deletion_step: Option<(f64, Place)>,
    /// Density [mass/length^3].
    pub density: f64,
    /// Young's modulus [force/length^2].
    pub youngs_modulus: f64,
    /// True if it has the pressure of an equation of state.
    pub takes_equation: bool,
    /// True if its pressure is a table of compaction.
    pub compacts: bool,
    /// True for a metal whose card has no bulk modulus.
    pub is_hydro: bool,
    /// Least pressure that it has with an equation of state, if any [force/length^2].
    pub least_pressure: Option<(f64, Place)>,
    /// Place of the keyword.
    pub place: Place,
}

impl DeckMaterial {
    /// Returns true if solids of this material have no pressure without an equation of state.
    pub fn needs_equation(&self) -> bool {
        self.fluid.is_some() || self.is_hydro
    }
}

/// Young's modulus of a material that carries no load and has none, because a law needs one.
const NO_MODULUS: f64 = 1.0;

const HYDRO: &str = "MAT_ELASTIC_PLASTIC_HYDRO";
const FAILING_WELD: &str = "MAT_SPOTWELD_DAMAGE-FAILURE";

/// Poisson's ratio of a metal whose bulk modulus is that of its equation of state: only its shear
/// modulus has an influence.
const OF_HYDRO: f64 = 0.3;

/// Keywords with a step below which elements are deleted.
const DELETING: [&str; 3] = [
    "MAT_PIECEWISE_LINEAR_PLASTICITY",
    "MAT_PLASTICITY_WITH_DAMAGE",
    "MAT_MODIFIED_PIECEWISE_LINEAR_PLASTICITY",
];

const KEYWORDS: [&str; 9] = [
    "MAT_ELASTIC",
    "MAT_PLASTIC_KINEMATIC",
    "MAT_PIECEWISE_LINEAR_PLASTICITY",
    "MAT_JOHNSON_COOK",
    HYDRO,
    "MAT_RIGID",
    "MAT_SPOTWELD",
    FAILING_WELD,
    "MAT_NULL",
];

impl DeckConverter {
    pub(super) fn materials(&mut self) -> HashMap<i64, DeckMaterial> {
        let mut materials: HashMap<i64, DeckMaterial> = HashMap::new();
        let others = metals::KEYWORDS
            .into_iter()
            .chain(soft_materials::KEYWORDS)
            .chain(concrete::KEYWORDS)
            .chain(polymers::KEYWORDS)
            .chain(pressure_dependent::KEYWORDS)
            .chain(composites::KEYWORDS)
            .chain(cohesive::KEYWORDS);
        for keyword in KEYWORDS.into_iter().chain(others) {
            for record in self.take_records(keyword) {
                let id = record.integer("mid");
                let title = record.word("heading").to_string();
                let taken = title.is_empty() || materials.values().any(|m| m.name == title);
                let name = if taken { format!("mat-{id}") } else { title };
                let place = record.place("mid");
                let is_soft = soft_materials::KEYWORDS.contains(&keyword);
                let is_ply = composites::KEYWORDS.contains(&keyword);
                let is_cohesive = cohesive::KEYWORDS.contains(&keyword);
                let is_hydro = keyword == HYDRO;
                let is_concrete = concrete::KEYWORDS.contains(&keyword);
                let by_pressure = pressure_dependent::KEYWORDS.contains(&keyword);
                let is_polymer = polymers::KEYWORDS.contains(&keyword);
                let is_solid = is_concrete || by_pressure;
                let has_own =
                    is_soft || is_ply || is_cohesive || is_hydro || is_solid || is_polymer;
                let (mut table, mut e) = if has_own {
                    (without_constants(&record, &name), 0.0)
                } else {
                    elastic(&record, &name)
                };
                let (mut rigid, mut weld, mut cohesive) = (None, None, None);
                let elastic = match keyword {
                    "MAT_SPOTWELD" | FAILING_WELD => record.real("sigy") == 0.0,
                    _ => matches!(keyword, "MAT_ELASTIC" | "MAT_RIGID" | "MAT_NULL"),
                };
                match keyword {
                    "MAT_PLASTIC_KINEMATIC" => self.plastic_kinematic(&record, &mut table),
                    "MAT_PIECEWISE_LINEAR_PLASTICITY" => self.piecewise(&record, &mut table),
                    "MAT_JOHNSON_COOK" => e = self.johnson_cook(&record, &mut table),
                    HYDRO => e = hydro(&record, &mut table),
                    "MAT_RIGID" => rigid = Some(self.rigid_material(&record)),
                    "MAT_NULL" => {
                        let given = record.real("ym");
                        e = if given > 0.0 { given } else { NO_MODULUS };
                        table.put("youngs_modulus", record.place("ym"), e);
                    }
                    "MAT_SPOTWELD" => {
                        weld = self.spot_weld(&record, &mut table);
                        self.check_weld_directions(&record);
                    }
                    FAILING_WELD => weld = self.failing_weld(&record, &mut table),
                    _ if is_cohesive => {
                        cohesive = Some(self.cohesive(keyword, &record, &mut table));
                    }
                    _ if is_ply => e = self.ply(keyword, &record, &mut table),
                    _ if is_polymer => e = self.polymer(&record, &mut table),
                    _ if is_concrete => e = self.concrete(keyword, &record, &mut table),
                    _ if by_pressure => e = self.pressure_dependent(keyword, &record, &mut table),
                    _ if is_soft => e = self.soft_material(keyword, &record, &mut table),
                    _ if metals::KEYWORDS.contains(&keyword) => {
                        self.metal(keyword, &record, &mut table);
                    }
                    _ => {}
                }
                if elastic {
                    table.put("law", record.head, "elastic");
                }
                let density = record.real("ro");
                let deletion_step = self.deletion_step(keyword, &record);
                let (table, skin) = (Some(table), keyword == "MAT_NULL");
                let material = DeckMaterial {
                    name,
                    skin,
                    fluid: skin.then(|| record.clone()),
                    table,
                    rigid,
                    elastic,
                    turn: match keyword {
                        "MAT_ENHANCED_COMPOSITE_DAMAGE" => composites::own_turn(&record, "mangle"),
                        "MAT_ORTHOTROPIC_ELASTIC"
                        | "MAT_COMPOSITE_DAMAGE"
                        | "MAT_FABRIC"
                        | metals::BARLAT => composites::own_turn(&record, "beta"),
                        _ => 0.0,
                    },
                    has_axes: is_ply || matches!(keyword, "MAT_FABRIC" | metals::BARLAT),
                    cohesive,
                    weld,
                    deletion_step,
                    density,
                    youngs_modulus: e,
                    takes_equation: matches!(keyword, "MAT_JOHNSON_COOK" | "MAT_NULL" | HYDRO),
                    compacts: keyword == pressure_dependent::THREE_SURFACES,
                    is_hydro,
                    least_pressure: self.least_pressure(keyword, &record),
                    place,
                };
                if materials.insert(id, material).is_some() {
                    self.trouble.error(
                        place,
                        format!("there are two materials with the id {id}"),
                        "give each a different id",
                    );
                }
            }
        }
        self.erosion(&mut materials);
        self.damage(&mut materials);
        self.damage_from_onset(&mut materials);
        materials
    }

    fn plastic_kinematic(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "j2");
        let (e, tangent) = (record.real("e"), record.real("etan"));
        table.put("yield_stress", record.place("sigy"), record.real("sigy"));
        let beta = record.real("beta");
        if (0.0..=1.0).contains(&beta) {
            let modulus = self.plastic_modulus((record, "etan"), e, tangent);
            for (key, share) in [("hardening_modulus", beta), ("kinematic_modulus", 1.0 - beta)] {
                if modulus * share != 0.0 {
                    table.put(key, record.place("etan"), modulus * share);
                }
            }
        } else {
            let message = format!("{}: beta is {beta}", record.name());
            let help = "give a share of isotropic hardening from 0 (kinematic) to 1 (isotropic)";
            self.trouble.error(record.place("beta"), message, help);
        }
        if rates(record, "src", "srp", table) {
            self.viscoplastic(record, table);
        }
        if record.real("fs") > 0.0 {
            table.put("failure_strain", record.place("fs"), record.real("fs"));
        }
    }

    /// Returns the stable step below which elements of a material are deleted.
    fn deletion_step(&mut self, keyword: &str, record: &CardRecord) -> Option<(f64, Place)> {
        if !DELETING.contains(&keyword) {
            return None;
        }
        let step = record.real("tdel");
        if step < 0.0 {
            self.unsupported_value(record, "tdel", "a step below 0: give a time, or 0 for none");
        }
        (step > 0.0).then(|| (step, record.place("tdel")))
    }

    /// Sets the rate that counts for a law with rates: that of the total strain (vp 0) or of the
    /// plastic strain (vp 1).
    pub(super) fn viscoplastic(&mut self, record: &CardRecord, table: &mut JobTable) {
        match record.real("vp") {
            1.0 => table.put("viscoplastic", record.place("vp"), true),
            0.0 | -1.0 => {}
            _ => self.unsupported_value(record, "vp", "use 0 or 1"),
        }
    }

    pub(super) fn hardening_modulus(
        &mut self,
        record: &CardRecord,
        e: f64,
        tangent: f64,
        table: &mut JobTable,
    ) {
        let modulus = self.plastic_modulus((record, "etan"), e, tangent);
        if modulus != 0.0 {
            table.put("hardening_modulus", record.place("etan"), modulus);
        }
    }

    /// Returns the plastic modulus of a tangent modulus, which a field gives; 0 after an error.
    pub(super) fn plastic_modulus(
        &mut self,
        (record, field): (&CardRecord, &str),
        e: f64,
        tangent: f64,
    ) -> f64 {
        if tangent >= e {
            let message = format!(
                "{}: the tangent modulus {tangent} is not below Young's modulus {e}",
                record.name()
            );
            self.trouble.error(
                record.place(field),
                message,
                "give the slope of stress over total strain after yield",
            );
            return 0.0;
        }
        e * tangent / (e - tangent)
    }

    /// Converts the hardening, rates and failure strain of a metal with curves.
    pub(super) fn piecewise(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "j2");
        let mut has_rates = rates(record, "c", "p", table);
        let fail = record.real("fail");
        if fail < 0.0 {
            self.unsupported_value(record, "fail", "failure by a user routine");
        } else if fail > 0.0 && fail < 1e20 {
            table.put("failure_strain", record.place("fail"), fail);
        }
        let lcsr = record.integer("lcsr");
        if lcsr > 0 && !has_rates {
            let place = record.place("lcsr");
            if let Some(curve) = self.curve(lcsr, place) {
                let place = curve.lines.first().copied().unwrap_or(place);
                table.put("rate_factors", place, rows(&curve.points));
                has_rates = true;
            }
        } else if lcsr != 0 {
            let why = "a curve of factors over the strain rate, without c and p next to it";
            self.unsupported_value(record, "lcsr", why);
        }
        let lcss = record.integer("lcss");
        let by_rate = self.tables.contains_key(&lcss);
        if has_rates || by_rate {
            self.viscoplastic(record, table);
        }
        if by_rate {
            self.hardening_by_rate(record, lcss, table);
            return;
        }
        if lcss > 0 {
            if [record.real("sigy"), record.real("etan")] != [0.0; 2] {
                let of = format!("material {}", record.integer("mid"));
                self.map(of, "sigy and etan next to lcss", "not used: the curve has their place");
            }
            let place = record.place("lcss");
            if let Some(curve) = self.curve(lcss, place) {
                let points = hardening_curve(curve.points);
                table.put(
                    "hardening",
                    curve.lines.first().copied().unwrap_or(place),
                    rows(&points),
                );
            }
            return;
        }
        if lcss < 0 {
            self.unsupported_value(record, "lcss", "a negative id");
        }
        let points = pairs(record, "eps", "es");
        if points.is_empty() {
            if record.real("sigy") == 0.0 {
                let message = format!("{}: there is no yield stress", record.name());
                self.trouble.error(
                    record.place("sigy"),
                    message,
                    "give sigy, or lcss, or eps and es",
                );
            }
            table.put("yield_stress", record.place("sigy"), record.real("sigy"));
            self.hardening_modulus(record, record.real("e"), record.real("etan"), table);
        } else if self.strains_increase(record, &points) {
            table.put("hardening", record.place("es"), rows(&hardening_curve(points)));
        }
    }

    /// Returns false after it has reported that the strains eps of a metal do not increase.
    pub(super) fn strains_increase(&mut self, record: &CardRecord, points: &[[f64; 2]]) -> bool {
        let Some(at) = points.windows(2).position(|pair| pair[0][0] >= pair[1][0]) else {
            return true;
        };
        let [[before, _], [strain, stress]] = [points[at], points[at + 1]];
        let message = format!(
            "{}: eps{} is {strain}, which is not above eps{} = {before}, but es{} is {stress}",
            record.name(),
            at + 2,
            at + 1,
            at + 2
        );
        let help = match points.iter().all(|point| point[0] == 0.0) {
            true => {
                "all eps are 0, so the stresses es belong to no strains: give eps, or leave es \
                 blank for sigy and etan, or a curve (lcss)"
            }
            false => "give eps in increasing order, and leave fields blank that have no point",
        };
        let places: Vec<Place> = record.lines("eps").flat_map(|line| line.places("eps")).collect();
        let place = places.get(at + 1).copied().unwrap_or_else(|| record.place("eps"));
        self.trouble.error(place, message, help);
        false
    }

    /// Converts a table of curves by strain rate.
    fn hardening_by_rate(&mut self, record: &CardRecord, lcss: i64, table: &mut JobTable) {
        let place = record.place("lcss");
        let Some(rows) = self.table_rows(lcss, place) else { return };
        if rows.iter().any(|row| row[0] < 0.0) {
            self.unsupported_value(record, "lcss", "logarithms of the rates; give the rates");
            return;
        }
        let curves = rows.chunk_by(|a, b| a[0] == b[0]);
        let points = |curve: &[Vec<f64>]| curve.iter().map(|row| [row[1], row[2]]).collect();
        let curves = curves.map(|curve| (curve[0][0], points(curve))).collect();
        let of = format!("material {}", record.integer("mid"));
        table.put("hardening_by_rate", place, self.rate_rows(&of, curves));
    }

    /// Converts a Johnson-Cook material and returns Young's modulus [force/length^2].
    fn johnson_cook(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "johnson_cook");
        let (g, pr) = (record.real("g"), record.real("pr"));
        let e = if record.real("e") > 0.0 { record.real("e") } else { 2.0 * g * (1.0 + pr) };
        table.put("youngs_modulus", record.place("e"), e);
        let number = |table: &mut JobTable, field: &str, key: &str| {
            table.put(key, record.place(field), record.real(field));
        };
        number(table, "a", "a");
        number(table, "b", "b");
        // Without hardening n has no influence, but must be 1.
        let n =
            if record.real("n") > 0.0 || record.real("b") > 0.0 { record.real("n") } else { 1.0 };
        table.put("n", record.place("n"), n);
        let damage = ["d1", "d2", "d3", "d4", "d5"].map(|d| record.real(d));
        let fails = damage[..3].iter().any(|d| *d != 0.0);
        if record.real("c") > 0.0 || (fails && damage[3] != 0.0) {
            number(table, "c", "c");
            number(table, "epso", "reference_rate");
        }
        if record.real("cp") > 0.0 && record.real("tm") > 0.0 {
            number(table, "m", "m");
            number(table, "tm", "melting_temperature");
            number(table, "tr", "reference_temperature");
            number(table, "cp", "specific_heat");
        }
        if fails {
            table.put("damage", record.place("d1"), damage);
        }
        for (field, why) in
            [("dtf", "failure by the time step"), ("rateop", "another form of the rate term")]
        {
            if record.real(field) != 0.0 {
                self.unsupported_value(record, field, why);
            }
        }
        e
    }

    /// Converts `*MAT_SPOTWELD` and returns the limits of its beams, with zeros for none.
    pub(super) fn spot_weld(
        &mut self,
        record: &CardRecord,
        table: &mut JobTable,
    ) -> Option<(WeldLimits, Place)> {
        if record.real("sigy") > 0.0 {
            table.put("law", record.head, "j2");
            table.put("yield_stress", record.place("sigy"), record.real("sigy"));
            if record.real("eh") != 0.0 {
                table.put("hardening_modulus", record.place("eh"), record.real("eh"));
            }
            if record.real("efail") > 0.0 {
                table.put("failure_strain", record.place("efail"), record.real("efail"));
            }
        }
        if record.real("sigy") < 0.0 {
            self.unsupported_value(record, "sigy", "a curve of the yield stress: give sigy and eh");
        }
        let tfail = record.real("tfail");
        if tfail > 0.0 && tfail < self.end_time {
            self.unsupported_value(record, "tfail", "welds that fail at a given time");
        }
        let unused: Vec<&str> =
            ["dt", "nf"].into_iter().filter(|f| record.real(f) != 0.0).collect();
        if !unused.is_empty() {
            self.map(format!("material {}", record.integer("mid")), unused.join(", "), "not used");
        }
        for field in ["nrr", "nrs", "mss", "mrr"].iter().filter(|f| record.real(f) < 0.0) {
            self.unsupported_value(record, field, "limits as curves over the rate");
        }
        let limits = ["nrr", "nrs", "mss", "mrr"].map(|field| record.real(field).max(0.0));
        let given = limits.iter().any(|&limit| limit > 0.0);
        given.then_some((WeldLimits::Forces(limits), record.place("nrr")))
    }

    /// Checks that limits of welds are the same in both directions across.
    pub(super) fn check_weld_directions(&mut self, record: &CardRecord) {
        for (one, other) in [("nrs", "nrt"), ("mss", "mtt")] {
            if record.real(one) != record.real(other) {
                self.unsupported_value(
                    record,
                    other,
                    "limits of both directions across a weld have to be the same",
                );
            }
        }
    }

    /// Returns the degrees of freedom that a rigid material fixes.
    fn rigid_material(&mut self, record: &CardRecord) -> Vec<&'static str> {
        if record.real("n") != 0.0 {
            self.unsupported_value(record, "n", "coupling with another program");
        }
        self.held_centre(record)
    }

    /// Returns the degrees of freedom of a rigid body that the codes of a card fix.
    pub(super) fn held_centre(&mut self, record: &CardRecord) -> Vec<&'static str> {
        match record.real("cmo") {
            1.0 => {
                let mut held = held(record.real("con1"), ["x", "y", "z"]);
                held.extend(self::held(record.real("con2"), ["rx", "ry", "rz"]));
                held
            }
            0.0 => Vec::new(),
            _ if record.real("con1") == 0.0 && record.real("con2") == 0.0 => Vec::new(),
            _ => {
                self.unsupported_value(record, "cmo", "constraints in local axes; use cmo 1");
                Vec::new()
            }
        }
    }
}

/// Converts name, density and elastic constants; also returns Young's modulus [force/length^2].
fn elastic(record: &CardRecord, name: &str) -> (JobTable, f64) {
    let e = record.real("e");
    let table = without_constants(record, name).with("youngs_modulus", record.place("e"), e).with(
        "poisson",
        record.place("pr"),
        record.real("pr"),
    );
    (table, e)
}

/// Converts name and density.
fn without_constants(record: &CardRecord, name: &str) -> JobTable {
    JobTable::new(record.head).with("name", record.place("mid"), name).with(
        "density",
        record.place("ro"),
        record.real("ro"),
    )
}

/// Converts a metal with the pressure of an equation of state. Returns Young's modulus.
fn hydro(record: &CardRecord, table: &mut JobTable) -> f64 {
    let e = 2.0 * record.real("g") * (1.0 + OF_HYDRO);
    table.put("law", record.head, "j2");
    table.put("youngs_modulus", record.place("g"), e);
    table.put("poisson", record.place("g"), OF_HYDRO);
    let points = pairs(record, "eps", "es");
    if points.is_empty() {
        table.put("yield_stress", record.place("sigy"), record.real("sigy"));
        table.put("hardening_modulus", record.place("eh"), record.real("eh"));
    } else {
        table.put("hardening", record.place("es"), rows(&hardening_curve(points)));
    }
    if record.real("fs") > 0.0 {
        table.put("failure_strain", record.place("fs"), record.real("fs"));
    }
    e
}

/// Returns the degrees of freedom that the constraint codes 0 to 7 fix.
pub fn held(code: f64, dofs: [&'static str; 3]) -> Vec<&'static str> {
    let [x, y, z] = dofs;
    match code as i64 {
        1 => vec![x],
        2 => vec![y],
        3 => vec![z],
        4 => vec![x, y],
        5 => vec![y, z],
        6 => vec![z, x],
        7 => vec![x, y, z],
        _ => Vec::new(),
    }
}

/// Converts C and p of Cowper and Symonds; returns true if they are given.
pub(super) fn rates(record: &CardRecord, c: &str, p: &str, table: &mut JobTable) -> bool {
    let are_given = record.real(c) > 0.0 && record.real(p) > 0.0;
    if are_given {
        table.put("cowper_symonds", record.place(c), [record.real(c), record.real(p)]);
    }
    are_given
}

/// Returns the points as rows of a table.
pub(super) fn rows(points: &[[f64; 2]]) -> Vec<Vec<f64>> {
    points.iter().map(|p| p.to_vec()).collect()
}

/// Returns the points of two lists of fields. Blank pairs at the end are no points; the first point
/// may be at zero.
pub(super) fn pairs(record: &CardRecord, first: &str, second: &str) -> Vec<[f64; 2]> {
    let list = |name| record.lines(name).flat_map(|line| line.reals(name)).collect::<Vec<_>>();
    let mut points: Vec<[f64; 2]> =
        list(first).into_iter().zip(list(second)).map(|(x, y)| [x, y]).collect();
    while points.last() == Some(&[0.0, 0.0]) {
        points.pop();
    }
    points
}

/// Returns a hardening curve as the formats mean it, from plastic strain zero on: constant before
/// its first point, continued with its last slope beyond its last one. A curve that falls at its
/// end stays constant.
pub(in crate::input::deck) fn hardening_curve(mut points: Vec<[f64; 2]>) -> Vec<[f64; 2]> {
    if let Some(&[first, stress]) = points.first()
        && first > 0.0
    {
        points.insert(0, [0.0, stress]);
    }
    if let [.., [before, lower], [last, stress]] = points[..]
        && before < last
        && last < BEYOND_ALL_STRAINS
        && lower < stress
    {
        let slope = (stress - lower) / (last - before);
        points.push([BEYOND_ALL_STRAINS, stress + slope * (BEYOND_ALL_STRAINS - last)]);
    }
    points
}

/// Returns the points of the curve whose value is the smaller one of that of `points` and `limit`.
/// The curve is constant after its last point.
pub(in crate::input::deck) fn at_most(points: &[[f64; 2]], limit: f64) -> Vec<[f64; 2]> {
    let mut limited: Vec<[f64; 2]> = Vec::with_capacity(points.len());
    for (i, &[x, y]) in points.iter().enumerate() {
        if let Some([x0, y0]) = i.checked_sub(1).map(|before| points[before])
            && (y0 - limit) * (y - limit) < 0.0
        {
            limited.push([x0 + (x - x0) * (limit - y0) / (y - y0), limit]);
        }
        limited.push([x, y.min(limit)]);
    }
    while let [.., [_, before], [_, last]] = limited[..]
        && before == limit
        && last == limit
    {
        limited.pop();
    }
    limited
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_limit_cuts_a_curve_where_it_is_above() {
        let points = [[0.0, 2.0], [1.0, 6.0], [2.0, 1.0], [3.0, 4.0]];
        let limited = [[0.0, 2.0], [0.5, 4.0], [1.0, 4.0], [1.4, 4.0], [2.0, 1.0], [3.0, 4.0]];
        assert_eq!(at_most(&points, 4.0), limited);
        assert_eq!(at_most(&points, 9.0), points);
        assert_eq!(at_most(&points[..2], 1.0), [[0.0, 1.0]]);
        assert_eq!(at_most(&points[..2], 4.0), [[0.0, 2.0], [0.5, 4.0]]);
    }
}
