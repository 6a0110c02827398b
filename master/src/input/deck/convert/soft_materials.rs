//! Converts materials of rubber, foam and honeycomb, and failure that is added to any material.

use super::DeckConverter;
use super::materials::{DeckMaterial, rows};
use super::tree::JobTable;
use super::viscous_materials::{viscoelastic, viscous_foam};
use crate::input::deck::record::CardRecord;
use std::collections::HashMap;

/// Keywords of this file.
pub const KEYWORDS: [&str; 16] = [
    "MAT_FABRIC",
    "MAT_VISCOELASTIC",
    "MAT_KELVIN-MAXWELL_VISCOELASTIC",
    "MAT_GENERAL_VISCOELASTIC",
    "MAT_VISCOUS_FOAM",
    "MAT_BLATZ-KO_RUBBER",
    "MAT_MOONEY-RIVLIN_RUBBER",
    "MAT_HYPERELASTIC_RUBBER",
    "MAT_OGDEN_RUBBER",
    "MAT_SIMPLIFIED_RUBBER/FOAM",
    "MAT_SOFT_TISSUE",
    "MAT_LOW_DENSITY_FOAM",
    "MAT_CRUSHABLE_FOAM",
    "MAT_FU_CHANG_FOAM",
    "MAT_HONEYCOMB",
    "MAT_MODIFIED_HONEYCOMB",
];

/// Criteria of failure: field, key, and sign of the field.
const CRITERIA: [(&str, &str, f64); 8] = [
    ("mxpres", "erosion_max_pressure", 1.0),
    ("mnpres", "erosion_min_pressure", 1.0),
    ("sigp1", "erosion_principal_stress", 1.0),
    ("sigvm", "erosion_von_mises", 1.0),
    ("mxeps", "erosion_major_strain", 1.0),
    ("effeps", "erosion_effective_strain", 1.0),
    ("effeps", "erosion_plastic_strain", -1.0),
    ("voleps", "erosion_volume_strain", 1.0),
];

/// Percentage of the points, as numfip, for all points.
const ALL_POINTS: f64 = -100.0;

/// Stress from which on a limit of tension is none [force/length^2].
const NO_LIMIT: f64 = 1e19;

impl DeckConverter {
    /// Converts the parameters of a material and returns Young's modulus [force/length^2].
    pub(super) fn soft_material(
        &mut self,
        keyword: &str,
        record: &CardRecord,
        table: &mut JobTable,
    ) -> f64 {
        match keyword {
            "MAT_FABRIC" => self.fabric(record, table),
            "MAT_VISCOELASTIC" => viscoelastic(record, table),
            "MAT_KELVIN-MAXWELL_VISCOELASTIC" => self.kelvin_maxwell(record, table),
            "MAT_GENERAL_VISCOELASTIC" => self.general_viscoelastic(record, table),
            "MAT_VISCOUS_FOAM" => viscous_foam(record, table),
            "MAT_BLATZ-KO_RUBBER" => {
                table.put("law", record.head, "blatz_ko");
                number(record, table, "g", "shear_modulus");
                2.926 * record.real("g")
            }
            "MAT_MOONEY-RIVLIN_RUBBER" => {
                table.put("law", record.head, "mooney_rivlin");
                for (field, key) in [("pr", "poisson"), ("a", "a"), ("b", "b")] {
                    number(record, table, field, key);
                }
                let is_fit = ["sgl", "sw", "st"].iter().any(|field| record.real(field) != 0.0);
                if record.integer("lcid") != 0 || is_fit {
                    self.unsupported_value(record, "lcid", "a fit to a test; give a and b");
                }
                2.0 * (1.0 + record.real("pr")) * 2.0 * (record.real("a") + record.real("b"))
            }
            "MAT_HYPERELASTIC_RUBBER" => {
                table.put("law", record.head, "polynomial_rubber");
                let c = ["c10", "c01", "c11", "c20", "c02", "c30"].map(|c| record.real(c));
                table.put("coefficients", record.place("c10"), c);
                self.rubber_options(record, table);
                2.0 * (1.0 + record.real("pr")) * 2.0 * (c[0] + c[1])
            }
            "MAT_OGDEN_RUBBER" => self.ogden(record, table),
            "MAT_SOFT_TISSUE" => self.soft_tissue(record, table),
            "MAT_SIMPLIFIED_RUBBER/FOAM" => self.simplified_rubber(record, table),
            "MAT_CRUSHABLE_FOAM" => self.crushable_foam(record, table),
            "MAT_HONEYCOMB" => self.honeycomb(record, table, false),
            "MAT_MODIFIED_HONEYCOMB" => self.honeycomb(record, table, true),
            _ => self.low_density_foam(keyword, record, table),
        }
    }

    /// Converts a soft tissue without fibres. Its energy is `c1 (I1 - 3) + c2 (I2 - 3) + xk/2
    /// (ln J)^2` with the invariants of the isochoric part (LS-DYNA Keyword User's Manual, vol. II,
    /// material 91): that of a rubber, except for the energy of the volume.
    fn soft_tissue(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        let [c1, c2, bulk] = ["c1", "c2", "xk"].map(|field| record.real(field));
        for field in ["c3", "c4", "c5"].into_iter().filter(|field| record.real(field) != 0.0) {
            let why = "fibres: only a tissue with c3, c4 and c5 of 0 is supported";
            self.unsupported_value(record, field, why);
        }
        let relaxes = record.lines("s").flat_map(|line| line.reals("s")).any(|s| s != 0.0);
        if relaxes {
            self.unsupported_value(record, "s", "relaxation of the stress");
        }
        let shear = 2.0 * (c1 + c2);
        if bulk <= 0.0 || shear <= 0.0 {
            let message = format!("{}: xk is {bulk}, c1 + c2 is {}", record.name(), c1 + c2);
            let help = "give a bulk modulus xk and c1 above 0";
            self.trouble.error(record.place("xk"), message, help);
        }
        let nu = (3.0 * bulk - 2.0 * shear) / (6.0 * bulk + 2.0 * shear);
        table.put("law", record.head, "polynomial_rubber");
        table.put("poisson", record.place("xk"), nu);
        table.put("coefficients", record.place("c1"), [c1, c2, 0.0, 0.0, 0.0, 0.0]);
        self.map(
            format!("material {}", record.integer("mid")),
            format!("xk {bulk}, the energy xk/2 (ln J)^2 of the volume"),
            format!("xk/2 (J - 1)^2, the same for small changes of the volume; poisson {nu}"),
        );
        2.0 * shear * (1.0 + nu)
    }

    /// Converts `*MAT_ADD_EROSION` to criteria of the materials.
    pub(super) fn erosion(&mut self, materials: &mut HashMap<i64, DeckMaterial>) {
        for record in self.take_records("MAT_ADD_EROSION") {
            let (id, place) = (record.integer("mid"), record.place("mid"));
            let excluded = record.real("excl");
            let given = |field: &str| ![0.0, excluded].contains(&record.real(field));
            for field in
                ["mneps", "epssh", "sigth", "impulse", "failtm", "epsthin", "engcrt", "radcrt"]
                    .iter()
                    .filter(|field| given(field))
            {
                let why =
                    "this criterion; use mxpres, mnpres, sigp1, sigvm, mxeps, voleps or effeps";
                self.unsupported_value(&record, field, why);
            }
            if record.integer("lcfld") != 0 {
                self.unsupported_value(&record, "lcfld", "forming limits");
            }
            if ![0, 1].contains(&record.integer("idam")) {
                self.unsupported_value(&record, "idam", "use 1, GISSMO");
            }
            if record.real("ncs") > 1.0 {
                self.unsupported_value(&record, "ncs", "failure by several criteria together");
            }
            for field in ["sigp1", "sigvm", "mxeps"].iter().filter(|field| record.real(field) < 0.0)
            {
                self.unsupported_value(&record, field, "a curve over the strain rate");
            }
            let Some(material) = materials.get_mut(&id) else {
                let known: Vec<String> = materials.keys().map(i64::to_string).collect();
                self.missing(place, "*MAT_...", id, &known);
                continue;
            };
            let Some(table) = &mut material.table else { continue };
            let mut has_criterion = false;
            for (field, key, sign) in CRITERIA {
                let value = sign * record.real(field);
                if given(field) && (value > 0.0 || matches!(field, "voleps" | "mnpres" | "mxpres"))
                {
                    match table.place_of(key) {
                        Some(first) => {
                            self.second_card(&record, field, [first, record.place(field)]);
                        }
                        None => {
                            table.put(key, record.place(field), value);
                            has_criterion = true;
                        }
                    }
                }
            }
            // By default the first point that fails removes its element.
            let points = record.real_or("numfip", 1.0);
            if has_criterion && points != ALL_POINTS {
                table.put("erosion_failed_points", record.place("numfip"), points);
            }
            if record.integer("idam") == 1 {
                self.gissmo(&record, "dmgtyp", table);
            }
        }
    }

    /// Converts what both rubbers with fits have in common.
    fn rubber_options(&mut self, record: &CardRecord, table: &mut JobTable) {
        number(record, table, "pr", "poisson");
        if record.integer("n") != 0 {
            self.unsupported_value(record, "n", "a fit to a test; give the constants with n 0");
        }
        let relaxes = record.lines("gi").any(|line| line.real("gi") != 0.0);
        if relaxes || record.real("g") != 0.0 {
            let field = if relaxes { "gi" } else { "g" };
            self.unsupported_value(record, field, "the rubber has no relaxation and no damping");
        }
    }

    fn ogden(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "ogden");
        let list = |name| record.line(name).map(|line| line.reals(name)).unwrap_or_default();
        let terms: Vec<Vec<f64>> = list("mu")
            .into_iter()
            .zip(list("alpha"))
            .filter(|&(mu, alpha)| mu != 0.0 || alpha != 0.0)
            .map(|(mu, alpha)| vec![mu, alpha])
            .collect();
        let shear = 0.5 * terms.iter().map(|term| term[0] * term[1]).sum::<f64>();
        if !terms.is_empty() {
            table.put("terms", record.place("mu"), terms);
        }
        self.rubber_options(record, table);
        2.0 * (1.0 + record.real("pr")) * shear
    }

    /// Converts rubber or foam by the force over the change of length of a specimen.
    fn simplified_rubber(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "tabulated_rubber");
        match record.real("prbeta") {
            0.0 => number(record, table, "km", "bulk_modulus"),
            nu if nu > 0.0 && nu < 0.5 => number(record, table, "prbeta", "poisson"),
            _ => self.unsupported_value(record, "prbeta", "viscous stress; use 0 for rubber"),
        }
        let hu = record.real("hu");
        let curve = record.integer("lctbid");
        for (field, given, why) in [
            ("g", record.real("g") != 0.0, "the rubber has no friction; use 0"),
            ("lcunld", record.integer("lcunld") != 0, "unloading follows the curve; use 0"),
            ("hu", hu != 0.0 && hu != 1.0, "unloading follows the curve; use 1"),
            ("visco", record.real("visco") != 0.0, "the rubber has no relaxation; use 0"),
        ] {
            if given {
                self.unsupported_value(record, field, why);
            }
        }
        let [length, width, thickness] = ["sgl", "sw", "st"].map(|field| record.real(field));
        if length.min(width).min(thickness) <= 0.0 {
            self.unsupported_value(record, "sgl", "give sgl, sw and st above 0");
            return 1.0;
        }
        let place = record.place("lctbid");
        let area = width * thickness;
        let nominal = |[x, y]: [f64; 2]| [x / length, y / area];
        if self.tables.contains_key(&curve) {
            let Some(rows) = self.table_rows(curve, place) else { return 1.0 };
            let tests = rows.iter().map(|row| {
                let [strain, stress] = nominal([row[1], row[2]]);
                [row[0], strain, stress]
            });
            return self.tests_by_rate(record, &tests.collect::<Vec<_>>(), table);
        }
        let Some(curve) = self.curve(curve, place) else { return 1.0 };
        let points: Vec<[f64; 2]> = curve.points.iter().map(|&point| nominal(point)).collect();
        table.put("curve", place, rows(&points));
        first_slope(&points)
    }

    /// Converts tests at several rates, with rows [rate, strain, stress]. Returns Young's modulus
    /// of the slowest one.
    fn tests_by_rate(
        &mut self,
        record: &CardRecord,
        tests: &[[f64; 3]],
        table: &mut JobTable,
    ) -> f64 {
        let of = format!("material {}", record.integer("mid"));
        let mut curves: Vec<(f64, Vec<[f64; 2]>)> = tests
            .chunk_by(|a, b| a[0] == b[0])
            .map(|rows| (rows[0][0], rows.iter().map(|row| [row[1], row[2]]).collect()))
            .collect();
        if curves.is_empty() {
            return 1.0; // empty curves are reported where they stand
        }
        match record.real("tension") {
            -1.0 => {}
            0.0 => {
                // In tension all curves are the slowest one.
                let pulled: Vec<[f64; 2]> =
                    curves[0].1.iter().copied().filter(|point| point[0] > 0.0).collect();
                for (_, points) in &mut curves {
                    points.retain(|point| point[0] <= 0.0);
                    points.extend(&pulled);
                }
            }
            1.0 => {
                let used = "by the rate in loading only: unloading follows the slowest curve, so \
                            that no cycle gives energy";
                self.map(of.clone(), "tension 1", used);
            }
            _ => self.unsupported_value(record, "tension", "use -1, 0 or 1"),
        }
        match record.real("rtype") {
            0.0 => {}
            1.0 => table.put("nominal_rate", record.place("rtype"), true),
            _ => self.unsupported_value(record, "rtype", "use 0 or 1"),
        }
        match record.real("avgopt") {
            0.0 => {}
            time if time < 0.0 => {
                table.put("rate_averaging_time", record.place("avgopt"), -time);
            }
            option => {
                self.map(of, format!("avgopt {option}"), "a running mean over 12 steps or more");
            }
        }
        let all: Vec<Vec<f64>> = curves
            .iter()
            .flat_map(|(rate, points)| points.iter().map(move |p| vec![*rate, p[0], p[1]]))
            .collect();
        table.put("curve_by_rate", record.place("lctbid"), all);
        first_slope(&curves[0].1)
    }

    fn crushable_foam(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "crushable_foam");
        number(record, table, "e", "youngs_modulus");
        number(record, table, "pr", "poisson");
        number(record, table, "tsc", "tension_cutoff");
        if record.real("model") != 0.0 {
            self.unsupported_value(record, "model", "use 0: limits of the principal stresses");
        }
        let place = record.place("lcid");
        if let Some(curve) = self.curve(record.integer("lcid"), place) {
            let points = self.compression(record, curve.points);
            table.put("compression", place, points);
        }
        record.real("e")
    }

    fn low_density_foam(
        &mut self,
        keyword: &str,
        record: &CardRecord,
        table: &mut JobTable,
    ) -> f64 {
        table.put("law", record.head, "low_density_foam");
        number(record, table, "e", "youngs_modulus");
        let given = |field: &str| record.real(field) != 0.0;
        if given("tc") && record.real("tc") < NO_LIMIT {
            number(record, table, "tc", "tension_cutoff");
        }
        for (field, key) in [("hu", "hysteresis"), ("shape", "shape")] {
            if given(field) {
                number(record, table, field, key);
            }
        }
        if given("fail") {
            let why = "tension ends at `tc` and does not fall; use 0";
            self.unsupported_value(record, "fail", why);
        }
        if keyword == "MAT_LOW_DENSITY_FOAM" {
            if given("beta") {
                self.unsupported_value(record, "beta", "unloaded foam does not creep");
            }
            let place = record.place("lcid");
            if let Some(curve) = self.curve(record.integer("lcid"), place) {
                let points = from_origin(self.compression(record, curve.points));
                table.put("compression", place, points);
            }
        } else {
            for (field, why) in
                [("tflag", "tension is linear"), ("pvid", "pressure has no curve of its own")]
            {
                if given(field) {
                    self.unsupported_value(record, field, why);
                }
            }
            self.curves_by_rate(record, table);
        }
        record.real("e")
    }

    /// Converts the curves of `*MAT_FU_CHANG_FOAM`, or its only one.
    fn curves_by_rate(&mut self, record: &CardRecord, table: &mut JobTable) {
        let (id, place) = (record.integer("tbid"), record.place("tbid"));
        if !self.tables.contains_key(&id) && self.curves.contains_key(&id) {
            if let Some(curve) = self.curve(id, place) {
                let points = from_origin(self.compression(record, curve.points));
                table.put("compression", place, points);
            }
            return;
        }
        let Some(rows) = self.table_rows(id, place) else { return };
        let mut all: Vec<Vec<f64>> = Vec::new();
        for curve in rows.chunk_by(|a, b| a[0] == b[0]) {
            let points = curve.iter().map(|row| [row[1], row[2]]).collect();
            let points = from_origin(self.compression(record, points));
            all.extend(points.iter().map(|point| vec![curve[0][0], point[0], point[1]]));
        }
        table.put("compression_by_rate", place, all);
    }

    /// Returns the points of a curve of compression from a strain of zero on. Notes points before
    /// it, which are for tension.
    fn compression(&mut self, record: &CardRecord, mut points: Vec<[f64; 2]>) -> Vec<Vec<f64>> {
        if points.iter().any(|point| point[0] < 0.0) {
            let of = format!("material {}", record.integer("mid"));
            self.map(of, "points of its curve at strains below 0", "not used: tension is linear");
            points.retain(|point| point[0] >= 0.0);
        }
        if let Some(&[first, stress]) = points.first()
            && first > 0.0
        {
            points.insert(0, [0.0, stress]);
        }
        points.iter().map(|point| point.to_vec()).collect()
    }
}

/// Puts a field under a key.
pub(super) fn number(record: &CardRecord, table: &mut JobTable, field: &str, key: &str) {
    table.put(key, record.place(field), record.real(field));
}

/// Returns a curve that begins without stress: a first point that was added keeps the line.
fn from_origin(mut points: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    if let Some(first) = points.first_mut() {
        first[1] = 0.0;
    }
    points
}

/// Returns the slope of a test from a strain of zero on [force/length^2]; 1 if it has none.
pub(in crate::input::deck) fn first_slope(points: &[[f64; 2]]) -> f64 {
    let slope = points.windows(2).find(|two| two[1][0] > 0.0).or(points.windows(2).last());
    slope.map_or(1.0, |two| (two[1][1] - two[0][1]) / (two[1][0] - two[0][0]))
}
