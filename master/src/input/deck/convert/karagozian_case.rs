//! Converts `*MAT_CONCRETE_DAMAGE_REL3` and its `*EOS_TABULATED_COMPACTION` (LS-DYNA Keyword User's
//! Manual, vol. I and II, material 72R3), with constants by the strength where a0 is below 0.
//!
//! Constants by the strength f_c: the three surfaces, b1, b2, b3 and the damage curve of the
//! concrete of 45.4 MPa of Malvar, Crawford, Wesevich & Simons (1997), scaled as there: stresses by
//! f_c, a2 by 1/f_c, and the compaction by the root of f_c. The tensile strength is
//! `1.58 (f_c^2)^(1/3)` in psi (Magallanes, Wu, Malvar & Crawford 2010). The damage curve, and the
//! compaction over its bulk modulus, are confirmed by two published decks; the other numbers are
//! those of the papers from memory, the bulk modulus of 14.53 GPa without a confirmation.

use super::DeckConverter;
use super::equations::PartEquation;
use super::materials::DeckMaterial;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// The keyword of the pressure.
pub(super) const COMPACTION: &str = "EOS_TABULATED_COMPACTION";

/// Psi per MPa.
const PSI: f64 = 145.0377;
/// Strengths for which the constants may be meant [psi]: 7 to 140 MPa.
const STRENGTHS: [f64; 2] = [1e3, 2e4];
/// Strength and bulk modulus of the reference concrete [MPa].
const REFERENCE: [f64; 2] = [45.4, 14_530.0];
/// lambda and eta of the reference concrete.
const DAMAGE: [[f64; 2]; 13] = [
    [0.0, 0.0],
    [8e-6, 0.85],
    [2.4e-5, 0.97],
    [4e-5, 0.99],
    [5.6e-5, 1.0],
    [7.2e-5, 0.99],
    [8.8e-5, 0.97],
    [3.2e-4, 0.5],
    [5.2e-4, 0.1],
    [5.7e-4, 0.0],
    [1.0, 0.0],
    [10.0, 0.0],
    [1e10, 0.0],
];
/// Volume strain, and pressure and modulus of unloading over the bulk modulus.
const PRESSURES: [[f64; 3]; 10] = [
    [0.0, 0.0, 1.0],
    [0.0015, 0.0015, 1.0],
    [0.0043, 0.00327, 1.014],
    [0.0101, 0.00525, 1.065],
    [0.0305, 0.009975, 1.267],
    [0.0513, 0.015045, 1.47],
    [0.0726, 0.021345, 1.672],
    [0.0943, 0.032655, 1.825],
    [0.174, 0.19065, 4.106],
    [0.208, 0.2916, 5.0],
];

impl DeckConverter {
    /// Converts the parameters of the material and returns its bulk modulus [force/length^2], 1 if
    /// its equation of state has it.
    pub(super) fn three_surfaces(&mut self, record: &CardRecord, table: &mut JobTable) -> f64 {
        table.put("law", record.head, "karagozian_case_concrete");
        table.put("poisson", record.place("pr"), record.real("pr"));
        if ![0.0, 13.0].contains(&record.real("npts")) {
            self.unsupported_value(record, "npts", "the card has 13 points");
        }
        match record.integer("lcrate") {
            0 => {}
            id if id > 0 => {
                let place = record.place("lcrate");
                if let Some(curve) = self.curve(id, place) {
                    table.put("rate_factors", place, super::materials::rows(&curve.points));
                }
            }
            _ => self.unsupported_value(record, "lcrate", "give a curve of factors"),
        }
        let a0 = record.real("a0");
        let by_strength = a0 < 0.0;
        let factor = match record.real("ucf") {
            0.0 => 1.0,
            psi => psi,
        };
        let psi = -a0 * factor;
        if by_strength && !(STRENGTHS[0]..=STRENGTHS[1]).contains(&psi) {
            let message = format!(
                "{}: a0 is {a0}, a strength of {psi:.4} psi by `ucf` = {}",
                record.name(),
                record.real("ucf")
            );
            let help = "check `ucf`, psi over the unit of stress: 145.04 for MPa, 145038 for GPa; \
                        or give the constants, with a0 above 0";
            self.trouble.error(record.place("a0"), message, help);
            return 1.0;
        }
        // A number that is given replaces that by the strength.
        let or = |field: &str, by: f64| match record.real(field) {
            0.0 if by_strength => by,
            given => given,
        };
        let fc = a0.abs();
        let tension = or("ft", 1.58 * psi.abs().powf(2.0 / 3.0) / factor);
        let first = if by_strength { 0.2956 * fc } else { a0 };
        let place = |field: &str| record.place(field);
        table.put("tensile_strength", place("ft"), tension);
        let surfaces = [
            ("largest_surface", "a0", [first, or("a1", 0.4463), or("a2", 0.0808 / fc)]),
            (
                "yield_surface",
                "a0y",
                [or("a0y", 0.2232 * fc), or("a1y", 0.625), or("a2y", 0.2575 / fc)],
            ),
            ("damage_scaling", "b1", [or("b1", 1.6), or("b2", 1.35), or("b3", 1.15)]),
        ];
        for (key, field, numbers) in surfaces {
            table.put(key, place(field), numbers);
        }
        let residual = [or("a1f", 0.4417), or("a2f", 0.1183 / fc)];
        table.put("residual_surface", place("a1f"), residual);
        table.put("dilatancy", place("omega"), [or("omega", 0.5), or("edrop", 1.0)]);
        let points = |names: [&str; 2]| -> Vec<f64> {
            names
                .into_iter()
                .flat_map(|name| record.lines(name).flat_map(move |l| l.reals(name)))
                .collect()
        };
        let [lambda, eta] = [["lambda", "lambda9"], ["eta", "eta9"]].map(points);
        let given = eta.iter().any(|eta| *eta != 0.0);
        let curve: Vec<Vec<f64>> = if given || !by_strength {
            // Blanks at the end are no points.
            let last = lambda.iter().rposition(|x| *x != 0.0).map_or(0, |last| last + 1);
            lambda.iter().zip(&eta).take(last).map(|(x, y)| vec![*x, *y]).collect()
        } else {
            DAMAGE.map(|point| point.to_vec()).to_vec()
        };
        if curve.is_empty() {
            let message = format!("{}: it has no damage curve", record.name());
            self.trouble.error(place("lambda"), message, "give lambda and eta");
            return 1.0;
        }
        table.put("damage_curve", place("lambda"), curve);
        if !by_strength {
            return 1.0;
        }
        let [strength, modulus] = REFERENCE;
        let bulk = modulus * (psi / PSI / strength).sqrt() * PSI / factor;
        let rows = PRESSURES.map(|[e, p, k]| vec![e, bulk * p, bulk * k]);
        table.put("compaction", place("a0"), rows.to_vec());
        let used = format!(
            "constants by the strength: tensile_strength {tension}, bulk modulus {bulk} from \
             14.53 GPa at 45.4 MPa, a number from memory; an eosid of the part replaces its \
             compaction"
        );
        self.map(format!("material {}", record.integer("mid")), format!("a0 {a0}"), used);
        bulk
    }

    /// Gives a material the compaction of a part.
    pub(super) fn compaction_of_part(
        &mut self,
        &PartEquation { ids: [part, mid, eosid], place }: &PartEquation,
        material: &mut DeckMaterial,
    ) {
        let Some(table) = &mut material.table else { return };
        if eosid == 0 {
            if !table.has("compaction") {
                let message = format!("part {part}: its material {mid} has no pressure");
                let help = "give eosid, the id of an *EOS_TABULATED_COMPACTION";
                self.trouble.error(place, message, help);
            }
            return;
        }
        let Some(card) = self.equation_card(eosid, place) else { return };
        if card.row.keyword.name != COMPACTION {
            let message = format!("part {part}: {} is not for material {mid}", card.name());
            self.trouble.error(place, message, "give it an *EOS_TABULATED_COMPACTION");
            return;
        }
        let Some(rows) = self.compaction_rows(&card) else { return };
        let bulk = rows.first().map_or(1.0, |row| row[2]);
        if let Some(table) = &mut material.table {
            let poisson = table.float("poisson").unwrap_or(0.0);
            material.youngs_modulus = 3.0 * bulk * (1.0 - 2.0 * poisson);
            table.remove("compaction");
            table.put("compaction", card.head, rows);
        }
        let used = format!("compaction of material {}", material.name);
        self.map(format!("part {part}"), format!("eosid {eosid}"), used);
    }

    /// Returns the rows -ln V, pressure and modulus of unloading of a card.
    fn compaction_rows(&mut self, card: &CardRecord) -> Option<Vec<Vec<f64>>> {
        let heated = card.lines("t").flat_map(|l| l.reals("t")).any(|t| t != 0.0);
        if card.real("gama") != 0.0 && (heated || card.integer("lct") != 0) {
            self.unsupported_value(card, "gama", "a pressure by heat; use 0");
        }
        let mut rows: Vec<[f64; 3]> = if card.integer("lcc") != 0 {
            let cold = self.curve(card.integer("lcc"), card.place("lcc"))?.points;
            let moduli = self.curve(card.integer("lck"), card.place("lck"))?.points;
            if !cold.iter().map(|p| p[0]).eq(moduli.iter().map(|p| p[0])) {
                let why = "a curve with other abscissas than those of lcc";
                self.unsupported_value(card, "lck", why);
            }
            cold.iter().zip(moduli).map(|(c, k)| [c[0], c[1], k[1]]).collect()
        } else {
            let [ev, c, k] = ["ev", "c", "k"]
                .map(|name| card.lines(name).flat_map(|l| l.reals(name)).collect::<Vec<_>>());
            ev.into_iter().zip(c).zip(k).map(|((ev, c), k)| [ev, c, k]).collect()
        };
        // Blank points at the end are no points.
        let blank = rows.iter().rev().take_while(|row| **row == [0.0; 3]).count();
        rows.truncate(rows.len() - blank);
        let mut rows: Vec<Vec<f64>> =
            rows.into_iter().map(|[ev, c, k]| vec![0.0 - ev, c, k]).collect();
        rows.sort_by(|a, b| a[0].total_cmp(&b[0]));
        if rows.iter().any(|row| row[0] < 0.0) {
            let used = "tension has the modulus of unloading, up to the tensile strength";
            self.map(card.name(), "points in tension", used);
            rows.retain(|row| row[0] >= 0.0);
        }
        Some(rows)
    }
}
