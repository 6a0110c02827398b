//! Converts `/MAT/...`, `/FAIL/JOHNSON` and `/FAIL/TENSSTRAIN`: laws and their parameters.
//! `biquad.rs` converts `/FAIL/BIQUAD`.

use super::StarterConverter;
use crate::input::deck::BEYOND_ALL_STRAINS;
use crate::input::deck::convert::materials::{DeckMaterial, at_most, hardening_curve};
use crate::input::deck::convert::soft_materials::first_slope;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;
use std::collections::BTreeMap;

/// Limit above which a value means that there is none.
const NONE: f64 = 1e20;
/// Young's modulus of a material that carries no load and has none, because a law needs one.
const NO_MODULUS: f64 = 1.0;
/// Density of a material that carries no load and has none, so that its nodes have some mass.
const NO_DENSITY: f64 = 1e-20;
/// Plastic strains of the straight lines of a power law: the smallest, the largest, and the number
/// of lines between them.
const LINES: (f64, f64, i32) = (1e-4, 2.0, 60);
/// Reference temperature of a card without one [K].
const ROOM: f64 = 300.0;
/// ICC of a largest stress that the rate does not scale.
const LIMIT_WITHOUT_RATE: i64 = 2;
/// Exponent of a power law that is a straight line.
const STRAIGHT: f64 = 1.0;

/// Names of the keywords of materials.
const KEYWORDS: [&str; 10] = [
    "/MAT/LAW0",
    "/MAT/LAW1",
    "/MAT/LAW2",
    "/MAT/LAW19",
    "/MAT/LAW36",
    "/MAT/LAW42",
    "/MAT/LAW43",
    "/MAT/LAW44",
    "/MAT/LAW69",
    "/MAT/PLAS_PREDEF",
];

impl StarterConverter {
    /// Returns all materials by id.
    pub(super) fn materials(&mut self) -> BTreeMap<i64, DeckMaterial> {
        let failures = self.failures("/FAIL/JOHNSON");
        let strains = self.failures("/FAIL/TENSSTRAIN");
        let parabolas = self.failures("/FAIL/BIQUAD");
        let mut found: BTreeMap<i64, DeckMaterial> = BTreeMap::new();
        for record in self.take(&KEYWORDS) {
            let (id, place) = (record.integer("id"), record.place("id"));
            let title = record.word("title").to_string();
            let is_taken = title.is_empty() || found.values().any(|m| m.name == title);
            let name = if is_taken { format!("mat-{id}") } else { title };
            let keyword = record.row.keyword.name;
            let mut density = record.real("rho");
            let (mut table, youngs_modulus) = match keyword {
                "/MAT/LAW42" => ogden(&record, &name),
                "/MAT/LAW19" => self.fabric(&record, &name),
                "/MAT/LAW69" => self.tabulated_rubber(&record, &name),
                "/MAT/PLAS_PREDEF" => {
                    let Some((table, [own, e])) = self.predefined(&record, &name) else {
                        let why = "has no values".to_string();
                        self.deck.left_out.leave_out("MAT", id, format!("{} {why}", record.name()));
                        continue;
                    };
                    density = own;
                    (table, e)
                }
                _ => elastic(&record, &name),
            };
            let skin = keyword == "/MAT/LAW0";
            match keyword {
                "/MAT/LAW2" => self.johnson_cook(&record, failures.get(&id), &mut table),
                "/MAT/LAW36" => self.yield_table(&record, &mut table),
                "/MAT/LAW43" => self.hill(&record, &mut table),
                "/MAT/LAW44" => self.cowper_symonds(&record, &mut table),
                "/MAT/LAW42" => self.volume_energy(&record),
                "/MAT/PLAS_PREDEF" | "/MAT/LAW19" | "/MAT/LAW69" => {}
                _ => table.put("law", record.head, "elastic"),
            }
            if let (Some(failure), true) = (failures.get(&id), keyword != "/MAT/LAW2") {
                let message = format!("/FAIL/JOHNSON/{id}: the law of the material is {keyword}");
                self.deck.unsupported(failure.head, message, "/FAIL/JOHNSON".into());
            }
            if let Some(limits) = strains.get(&id) {
                self.largest_strain(limits, &mut table);
            }
            match parabolas.get(&id) {
                Some(card)
                    if !matches!(
                        keyword,
                        "/MAT/LAW0" | "/MAT/LAW1" | "/MAT/LAW19" | "/MAT/LAW42" | "/MAT/LAW69"
                    ) =>
                {
                    self.biquad(card, &mut table);
                }
                Some(card) => {
                    let message =
                        format!("/FAIL/BIQUAD/{id}: the law {keyword} has no plastic strain");
                    self.deck.unsupported(card.head, message, "/FAIL/BIQUAD".into());
                }
                None => {}
            }
            let material = DeckMaterial {
                name,
                table: Some(table),
                rigid: None,
                skin,
                fluid: None,
                has_axes: false,
                cohesive: None,
                turn: 0.0,
                deletion_step: None,
                elastic: matches!(keyword, "/MAT/LAW0" | "/MAT/LAW1"),
                weld: None,
                density,
                youngs_modulus,
                takes_equation: false,
                compacts: false,
                is_hydro: false,
                least_pressure: None,
                place,
            };
            if found.insert(id, material).is_some() {
                self.twice("materials", id, place);
            }
        }
        for (id, failure) in failures
            .iter()
            .chain(&strains)
            .chain(&parabolas)
            .filter(|(id, _)| !found.contains_key(id))
        {
            let known: Vec<String> = found.keys().map(i64::to_string).collect();
            self.deck.missing(failure.place("id"), "/MAT/...", *id, &known);
        }
        found
    }

    /// Notes the energy of the volume of a rubber.
    fn volume_energy(&mut self, record: &CardRecord) {
        if record.integer("iform") != 2 {
            let of = format!("{} {}", record.name(), record.integer("id"));
            let used = "K (J - 1 - ln J), the same for small changes of the volume";
            self.deck.map(of, "the energy K/2 (J - 1)^2 of the volume", used);
        }
    }

    /// Returns the cards of failure by the id of their material.
    fn failures(&mut self, keyword: &'static str) -> BTreeMap<i64, CardRecord> {
        let records = self.take(&[keyword]);
        records.into_iter().map(|record| (record.integer("id"), record)).collect()
    }

    /// Converts limits of the largest principal strain.
    fn largest_strain(&mut self, card: &CardRecord, table: &mut JobTable) {
        let given = |field: &str| Some(card.real(field)).filter(|e| *e > 0.0 && *e < NONE);
        let [start, end, sudden] = ["epst1", "epst2", "epsf1"].map(given);
        match card.integer("sflag") {
            0..=2 => {}
            _ => {
                let why = "a limit of strains that are mainly tensile; use 1 or 2 for the largest \
                           principal strain";
                self.deck.unsupported_value(card, "sflag", why);
            }
        }
        let (limit, field) = match (end, sudden) {
            (Some(end), _) => (end, "epst2"),
            (None, Some(sudden)) => (sudden, "epsf1"),
            (None, None) => {
                let message = format!("{} {} has no limit", card.name(), card.integer("id"));
                self.deck.trouble.warning(card.head, message, "give epst2, or epsf1");
                return;
            }
        };
        if sudden.is_some_and(|sudden| sudden < limit) {
            let why = "a limit below epst2: give one of them";
            self.deck.unsupported_value(card, "epsf1", why);
        }
        table.put("erosion_major_strain", card.place(field), limit);
        match start {
            Some(start) if start < limit && end.is_some() => {
                table.put("erosion_major_strain_start", card.place("epst1"), start);
            }
            Some(start) => {
                let of = format!("{} {}", card.name(), card.integer("id"));
                self.deck.map(of, format!("epst1 {start}"), "not used: it is not below epst2");
            }
            None => {}
        }
        // A shell goes with its first failed point.
        table.put("erosion_failed_points", card.place(field), 1.0);
        if table.has("erosion_major_strain_start") {
            let message =
                "/FAIL/TENSSTRAIN: faded stress does not rise again when the strain falls";
            let help = "expect less stress where the load reverses before failure";
            self.deck.trouble.warning(card.place(field), message, help);
        }
    }

    /// Converts the law of Johnson and Cook; without rate, temperature and exponent it is linear
    /// hardening.
    fn johnson_cook(
        &mut self,
        record: &CardRecord,
        failure: Option<&CardRecord>,
        table: &mut JobTable,
    ) {
        let [a, b, n] = self.power_law(record);
        let [c, heat] = ["c", "rhocp"].map(|field| record.real(field));
        let [melt, fails] = ["tmelt", "epsmax"].map(|field| record.real(field));
        let hot = heat > 0.0 && melt > 0.0 && melt < NONE;
        let rate = record.real("eps0");
        let m = record.real_or("m", 1.0);
        let reference = match record.real("tr") {
            given if given > 0.0 => given,
            _ => ROOM,
        };
        let put = |table: &mut JobTable, key: &str, field: &str, value: f64| {
            table.put(key, record.place(field), value);
        };
        let plain = c == 0.0 && !hot && failure.is_none();
        let limit = largest_stress(record);
        if plain && limit.is_some() {
            return self.hardening_lines(record, [a, b, n], limit, table);
        }
        if n == STRAIGHT && plain {
            table.put("law", record.head, "j2");
            put(table, "yield_stress", "a", a);
            if b != 0.0 {
                put(table, "hardening_modulus", "b", b);
            }
            if fails > 0.0 && fails < NONE {
                put(table, "failure_strain", "epsmax", fails);
            }
            return;
        }
        table.put("law", record.head, "johnson_cook");
        // A limit below a is the yield stress.
        let at_limit = limit.filter(|&limit| limit <= a);
        put(table, "a", "a", at_limit.unwrap_or(a));
        put(table, "b", "b", if at_limit.is_some() { 0.0 } else { b });
        put(table, "n", "n", n);
        if let Some(limit) = limit {
            if c > 0.0 && record.integer("icc") == LIMIT_WITHOUT_RATE {
                let why = "a largest stress on which the rate has no effect; give 1, or the yield \
                           stress as functions by /MAT/LAW36";
                self.deck.unsupported_value(record, "icc", why);
            }
            put(table, "largest_stress", "sigmax", limit);
        }
        if c > 0.0 && rate <= 0.0 {
            let message = format!(
                "{} {}: c = {c} without a reference rate eps0",
                record.name(),
                record.integer("id")
            );
            let help = "give eps0 above 0 in the columns 21 to 40 of the card of c, or c 0";
            self.deck.trouble.error(record.place("eps0"), message, help);
        } else if c > 0.0 {
            put(table, "c", "c", c);
            put(table, "reference_rate", "eps0", rate);
        }
        if hot {
            put(table, "m", "m", m);
            put(table, "melting_temperature", "tmelt", melt);
            put(table, "reference_temperature", "tr", reference);
            put(table, "specific_heat", "rhocp", heat / record.real("rho"));
            put(table, "taylor_quinney", "rhocp", 1.0);
        }
        match failure {
            Some(card) => {
                if matches!(card.integer("ifailsh"), 0 | 1) {
                    let message = "/FAIL/JOHNSON: Ifail_sh 1 removes a shell with its first \
                                   failed point, here it goes with its last one";
                    let help = "give Ifail_sh 2, or expect shells to fail later";
                    self.deck.trouble.warning(card.place("ifailsh"), message, help);
                }
                let damage = ["d1", "d2", "d3", "d4", "d5"].map(|field| card.real(field));
                table.put("damage", card.place("d1"), damage);
                if damage[3] != 0.0 && c == 0.0 {
                    table.put("reference_rate", card.place("eps0"), card.real_or("eps0", 1.0));
                }
                if fails > 0.0 && fails < NONE {
                    let of = format!("material {}", record.integer("id"));
                    self.deck.map(of, "epsmax next to /FAIL/JOHNSON", "not used");
                }
            }
            None if fails > 0.0 && fails < NONE => {
                table.put("damage", record.place("epsmax"), [fails, 0.0, 0.0, 0.0, 0.0]);
            }
            None => {}
        }
    }

    /// Returns a, b and n of the yield stress `a + b eps^n`. With iflag 1 the card has instead of b
    /// and n the largest engineering stress and its engineering strain.
    fn power_law(&mut self, record: &CardRecord) -> [f64; 3] {
        let ([a, given], e) =
            (["a", "b"].map(|field| record.real(field)), record.real_or("n", 1.0));
        match record.integer("iflag") {
            0 => return [a, given, e],
            1 => {}
            _ => {
                let why = "use 0 for a, b and n, 1 for the yield stress and the ultimate stress";
                self.deck.unsupported_value(record, "iflag", why);
                return [a, given, e];
            }
        }
        if e <= 0.0 || given <= 0.0 {
            let message = format!(
                "{} {}: with iflag 1 the ultimate stress is {given} at the strain {e}",
                record.name(),
                record.integer("id")
            );
            let help = "give both above 0: b is the largest engineering stress, n its strain";
            self.deck.trouble.error(record.place("b"), message, help);
            return [a, 0.0, 1.0];
        }
        let [a, b, n] = hardening_to([a, given, e], record.real("e"));
        self.deck.map(
            format!("material {}", record.integer("id")),
            format!("iflag 1: yield stress {a}, ultimate stress {given} at {e}"),
            format!("a + b eps^n with b {b:.6e}, n {n:.6e}"),
        );
        [a, b, n]
    }

    /// Converts a yield stress by functions of plastic strain, one for each strain rate.
    fn yield_table(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "j2");
        let all: Vec<_> = record.lines("fcts").flat_map(|line| line.integers("fcts")).collect();
        let [scales, rates] = ["fscales", "rates"].map(|field| {
            record.lines(field).flat_map(|line| line.reals(field)).collect::<Vec<_>>()
        });
        let count = usize::try_from(record.integer("nfunc")).unwrap_or(0).max(1);
        let functions = &all[..count.min(all.len())];
        if functions.len() < count {
            let message = format!(
                "{} {} has {} of {count} functions",
                record.name(),
                record.integer("id"),
                functions.len()
            );
            let help = "give N_funct and the ids of functions of the yield stress";
            return self.deck.trouble.error(record.place("nfunc"), message, help);
        }
        let rate = |k: usize| rates.get(k).copied().unwrap_or(0.0);
        let mut curves: Vec<(f64, Vec<[f64; 2]>)> = Vec::new();
        for (k, &(id, place)) in functions.iter().enumerate() {
            let Some(points) = self.points_of(id, place) else { return };
            let scale = scales.get(k).copied().filter(|s| *s != 0.0).unwrap_or(1.0);
            curves.push((rate(k), points.iter().map(|p| [p[0], scale * p[1]]).collect()));
        }
        let place = functions[0].1;
        if count > 1 {
            let of = format!("material {}", record.integer("id"));
            table.put("hardening_by_rate", place, self.deck.rate_rows(&of, curves));
            let to = "hardening_by_rate, constant beyond the last rate";
            self.deck.map(of, format!("{count} functions by the rate"), to);
        } else {
            let points = curves.into_iter().flat_map(|curve| hardening_curve(curve.1));
            table.put("hardening", place, points.map(|p| p.to_vec()).collect::<Vec<_>>());
            if rate(0) != 0.0 {
                self.deck.map("/MAT/LAW36", "the rate of the function", "it holds for all rates");
            }
        }
        fail(record, table);
    }

    /// Converts rubber by the function of a uniaxial test; also returns Young's modulus
    /// [force/length^2]. The bulk modulus is that of the slope at 0.
    fn tabulated_rubber(&mut self, record: &CardRecord, name: &str) -> (JobTable, f64) {
        let (place, nu) = (record.place("fct"), record.real_or("nu", 0.495));
        let mut table = JobTable::new(record.head)
            .with("name", record.place("title"), name)
            .with("law", record.head, "tabulated_rubber")
            .with("density", record.place("rho"), record.real("rho"));
        let Some(points) = self.points_of(record.integer("fct"), place) else {
            return (table, 1.0);
        };
        let modulus = first_slope(&points);
        if points.len() < 2 || !modulus.is_finite() || modulus <= 0.0 {
            let why = "a function without two points and a slope above 0 at the strain 0";
            self.deck.unsupported_value(record, "fct", why);
            return (table, 1.0);
        }
        if !(nu > -1.0 && nu < 0.5) {
            let why = "a Poisson ratio that is not between -1 and 0.5: give one such as 0.495";
            self.deck.unsupported_value(record, "nu", why);
            return (table, 1.0);
        }
        table.put("curve", place, points.iter().map(|p| p.to_vec()).collect::<Vec<_>>());
        table.put("bulk_modulus", record.place("nu"), modulus / (3.0 * (1.0 - 2.0 * nu)));
        let terms = match record.integer("law") {
            2 => "terms of Mooney and Rivlin fitted to the function",
            _ => "terms of Ogden fitted to the function",
        };
        self.deck.map(format!("material {}", record.integer("id")), terms, "the function itself");
        (table, modulus)
    }

    /// Converts a yield stress with the factor of Cowper and Symonds.
    fn cowper_symonds(&mut self, record: &CardRecord, table: &mut JobTable) {
        let (c, p) = (record.real("c"), record.real_or("p", 1.0));
        let (limit, icc) = (largest_stress(record), record.integer("icc"));
        if limit.is_some() && c > 0.0 && icc == 2 {
            let why = "a largest stress without the factor of the rate: use icc 1";
            self.deck.unsupported_value(record, "icc", why);
        }
        if record.integer("fcty") == 0 {
            if record.real("a") <= 0.0 {
                let message = format!("{}: `a` is blank or not above 0", record.name());
                let help = "give the yield stress a, or the function fcty";
                self.deck.trouble.error(record.place("a"), message, help);
            }
            let power = [record.real("a"), record.real("b"), record.real_or("n", 1.0)];
            self.hardening_lines(record, power, limit, table);
        } else {
            self.yield_function(record, limit, table);
        }
        if c > 0.0 {
            table.put("cowper_symonds", record.place("c"), [c, p]);
        }
    }

    /// Converts a yield stress by a function of the plastic strain, at most `limit`, to the law
    /// `j2`; with its failure.
    fn yield_function(&mut self, record: &CardRecord, limit: Option<f64>, table: &mut JobTable) {
        table.put("law", record.head, "j2");
        fail(record, table);
        let place = record.place("fcty");
        let Some(points) = self.points_of(record.integer("fcty"), place) else { return };
        let scale = record.real_or("fscaley", 1.0);
        let mut rows = hardening_curve(points.iter().map(|p| [p[0], scale * p[1]]).collect());
        if let Some(limit) = limit {
            rows = at_most(&rows, limit);
        }
        table.put("hardening", place, rows.iter().map(|p| p.to_vec()).collect::<Vec<_>>());
    }

    /// Converts a yield stress `a + b eps^n`, at most `limit`, to the law `j2` with straight lines;
    /// with its failure.
    fn hardening_lines(
        &mut self,
        record: &CardRecord,
        [a, b, n]: [f64; 3],
        limit: Option<f64>,
        table: &mut JobTable,
    ) {
        table.put("law", record.head, "j2");
        fail(record, table);
        if limit.is_none() && (b == 0.0 || n == STRAIGHT) {
            table.put("yield_stress", record.place("a"), a);
            if b != 0.0 {
                table.put("hardening_modulus", record.place("b"), b);
            }
            return;
        }
        let (least, most, count) = LINES;
        let step = (most / least).powf(1.0 / f64::from(count));
        let at = |eps: f64| [eps, a + b * eps.powf(n)];
        let mut rows = vec![[0.0, a]];
        rows.extend((0..=count).map(|k| at(least * step.powi(k))));
        if let Some(limit) = limit {
            rows.retain(|row| row[1] < limit);
            let end = if rows.is_empty() { 0.0 } else { ((limit - a) / b).powf(1.0 / n) };
            let reaches = b > 0.0 && end < BEYOND_ALL_STRAINS;
            if reaches || rows.is_empty() {
                rows.push([end, limit]);
            }
        }
        let (lines, last) = (rows.len() - 1, rows[rows.len() - 1]);
        table.put(
            "hardening",
            record.place("n"),
            rows.iter().map(|p| p.to_vec()).collect::<Vec<_>>(),
        );
        self.deck.map(
            format!("material {}", record.integer("id")),
            format!(
                "a + b eps^n with n {n}{}",
                limit.map_or(String::new(), |l| format!(", sigmax {l}"))
            ),
            format!("{lines} straight lines up to {:.4e} at a strain of {:.4e}", last[1], last[0]),
        );
    }
}

/// Returns a, b and n of the yield stress `a + b eps^n` from a, the largest engineering stress S
/// and its engineering strain e, for Young's modulus E. At the true strain `g = ln(1 + e)` the true
/// stress `s = S (1 + e)` equals its slope (Considere), so `n = s g/(s - a)` and
/// `b = s/(n g^(n - 1))`. If n is above 1, it is 1, and b is the slope from the yield stress to s
/// over `g - (s + a)/E`; if s is below a, there is no hardening. So it is in Radioss.
pub(super) fn hardening_to([a, given, e]: [f64; 3], modulus: f64) -> [f64; 3] {
    let (s, g) = (given * (1.0 + e), (1.0 + e).ln());
    let n = s * g / (s - a);
    let (b, n) = match n {
        _ if s <= a => (0.0, 1.0),
        n if n > 1.0 => ((s - a) / (g - (s + a) / modulus), 1.0),
        n => (s / (n * g.powf(n - 1.0)), n),
    };
    [a, b, n]
}

/// Returns the largest stress of a material, if it has one [force/length^2].
fn largest_stress(record: &CardRecord) -> Option<f64> {
    Some(record.real("sigmax")).filter(|&limit| limit > 0.0 && limit < NONE)
}

/// Converts the plastic strain at which an element fails.
fn fail(record: &CardRecord, table: &mut JobTable) {
    let strain = record.real("epsmax");
    if strain > 0.0 && strain < NONE {
        table.put("failure_strain", record.place("epsmax"), strain);
    }
}

/// Returns the table of a rubber of Ogden, and its Young's modulus at the start.
fn ogden(record: &CardRecord, name: &str) -> (JobTable, f64) {
    let all = |fields: [&str; 2]| -> Vec<f64> {
        let of = |field| record.line(field).map(|line| line.reals(field)).unwrap_or_default();
        fields.map(of).concat()
    };
    let terms: Vec<Vec<f64>> = all(["mu", "moremu"])
        .into_iter()
        .zip(all(["alpha", "morealpha"]))
        .filter(|(mu, _)| *mu != 0.0)
        .map(|(mu, alpha)| vec![mu, alpha])
        .collect();
    let shear: f64 = terms.iter().map(|term| 0.5 * term[0] * term[1]).sum();
    let nu = record.real_or("nu", 0.495);
    let table = JobTable::new(record.head)
        .with("name", record.place("title"), name)
        .with("law", record.head, "ogden")
        .with("density", record.place("rho"), record.real("rho"))
        .with("poisson", record.place("nu"), nu)
        .with("terms", record.place("mu"), terms);
    (table, 2.0 * shear * (1.0 + nu))
}

/// Converts name, density and elastic constants; also returns Young's modulus [force/length^2].
fn elastic(record: &CardRecord, name: &str) -> (JobTable, f64) {
    let is_void = record.row.keyword.name == "/MAT/LAW0";
    let or = |value: f64, other: f64| if is_void && value <= 0.0 { other } else { value };
    let (density, e) = (or(record.real("rho"), NO_DENSITY), or(record.real("e"), NO_MODULUS));
    let table = JobTable::new(record.head)
        .with("name", record.place("title"), name)
        .with("density", record.place("rho"), density)
        .with("youngs_modulus", record.place("e"), e)
        .with("poisson", record.place("nu"), record.real("nu"));
    (table, e)
}
