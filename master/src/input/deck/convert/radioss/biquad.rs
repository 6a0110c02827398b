//! Converts `/FAIL/BIQUAD`: plastic strain to failure by parabolas over the triaxiality of stress
//! (Radioss Reference Guide, `/FAIL/BIQUAD`), to points of the curve of GISSMO.
//!
//! The strains c1 to c5 are those in simple compression, shear, simple tension, plane strain and
//! biaxial tension. One parabola goes through c1, c2 and c3, for triaxialities up to 1/3. Above it
//! is one through c3, c4 and c5 (S-Flag 1), or one with its vertex at c4 on each side of it (2).
//! Damage grows by the increment of the plastic strain over this strain.

use super::StarterConverter;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;
use std::collections::BTreeSet;

/// Triaxialities of the five tests: those of plane stress.
const TESTS: [f64; 5] = [-1.0 / 3.0, 0.0, 1.0 / 3.0, 0.577_350_269_189_625_8, 2.0 / 3.0];
/// Index of plane strain in [`TESTS`].
const PLANE_STRAIN: usize = 3;
/// Number of straight lines of the curve for a triaxiality from 0 to 1. At the vertex of a parabola
/// `a x^2` a line is off by `a/1800`, 0.2 % of the strain in the tests of steel.
const LINES: i32 = 15;
/// Strain where a parabola is below it.
const LEAST: f64 = 1e-6;

/// M-Flag of the materials of the format: c3, and c1, c2, c4, c5 over c3.
const MATERIALS: [(f64, [f64; 4]); 7] = [
    (0.6, [3.5, 1.6, 0.6, 1.5]),
    (0.5, [4.3, 1.4, 0.6, 1.6]),
    (0.12, [5.2, 3.1, 0.8, 3.5]),
    (0.3, [5.0, 1.0, 0.4, 0.8]),
    (0.17, [7.8, 3.5, 0.6, 2.8]),
    (0.1, [3.6, 0.6, 0.5, 0.6]),
    (0.11, [10.0, 2.7, 0.6, 0.7]),
];
/// M-Flag for ratios on a card.
const RATIOS: i64 = 99;

impl StarterConverter {
    /// Adds the damage of a card to a material with plastic strain.
    pub(super) fn biquad(&mut self, card: &CardRecord, table: &mut JobTable) {
        let Some(strains) = self.strains_of_tests(card) else { return };
        let flag = card.integer("sflag");
        if flag == 3 && !self.is_on_shells(card.integer("id")) {
            let message = format!(
                "{}: `sflag` 3, localized necking, is for shells, and no shell has the material",
                card.name()
            );
            let help = "the parabolas are those of sflag 2";
            self.deck.trouble.warning(card.place("sflag"), message, help);
        } else if !(0..=2).contains(&flag) {
            let why =
                "localized necking; use 1 (two parabolas) or 2 (least strain in plane strain)";
            self.deck.unsupported_value(card, "sflag", why);
        }
        let rows: Vec<Vec<f64>> =
            triaxialities().map(|x| vec![x, strain_at(strains, flag != 1, x).max(LEAST)]).collect();
        let of = format!("material {}", card.integer("id"));
        let asked = format!("/FAIL/BIQUAD with strains {strains:?}");
        let used = format!("{} points of gissmo_failure_strain", rows.len());
        self.deck.map(of, asked, used);
        table.put("gissmo_failure_strain", card.place("c3"), rows);
        let given = card.real("pthick");
        let share = given.abs().min(1.0);
        let points = if share == 0.0 { 1.0 } else { -100.0 * share };
        if given > 0.0 {
            let of = format!("material {}", card.integer("id"));
            let asked = format!("/FAIL/BIQUAD with pthick {given}: a share of the thickness");
            self.deck.map(of, asked, "the same share of the points: gissmo_failed_points");
        }
        table.put("gissmo_failed_points", card.place("pthick"), points);
        self.softening(card, table);
        let function = card.integer("fctel");
        if function != 0
            && let Some(points) = self.points_of(function, card.place("fctel"))
        {
            let size = card.real_or("elref", 1.0);
            let rows: Vec<Vec<f64>> = points.iter().map(|p| vec![p[0] * size, p[1]]).collect();
            table.put("gissmo_size_factors", card.place("fctel"), rows);
        }
    }

    /// Returns true if a part of this material has shells.
    fn is_on_shells(&self, material: i64) -> bool {
        let parts = self.deck.records.get("/PART").into_iter().flatten();
        let own: BTreeSet<i64> =
            parts.filter(|r| r.integer("mat") == material).map(|r| r.integer("id")).collect();
        self.deck.rows.shells.iter().any(|shell| own.contains(&i64::from(shell.part)))
    }

    /// Returns the strains c1 to c5; `None` after an error.
    fn strains_of_tests(&mut self, card: &CardRecord) -> Option<[f64; 5]> {
        let given = ["c1", "c2", "c3", "c4", "c5"].map(|field| card.real(field));
        let own = ["r1", "r2", "r4", "r5"].map(|field| card.real(field));
        let is_tension_only = [0, 1, 3, 4].iter().all(|&k| given[k] == 0.0);
        let flag = card.integer("mflag");
        let (tension, ratios) = match usize::try_from(flag) {
            Ok(0) if !is_tension_only => return self.positive(card, given),
            Ok(0) => MATERIALS[0],
            Ok(flag) if flag <= MATERIALS.len() => MATERIALS[flag - 1],
            _ if flag == RATIOS => (MATERIALS[0].0, own),
            _ => {
                let why = "use 0 (c1 to c5), 1 to 7 (materials) or 99 (ratios)";
                self.deck.unsupported_card(card, "mflag", why);
                return None;
            }
        };
        let tension = card.real_or("c3", tension);
        let [c1, c2, c4, c5] = ratios.map(|ratio| ratio * tension);
        self.positive(card, [c1, c2, tension, c4, c5])
    }

    /// Returns strains that are all above 0; otherwise reports an error.
    fn positive(&mut self, card: &CardRecord, strains: [f64; 5]) -> Option<[f64; 5]> {
        if strains.iter().all(|c| *c > 0.0) {
            return Some(strains);
        }
        let message = format!(
            "{} {}: the strains to failure c1 to c5 are {strains:?}",
            card.name(),
            card.integer("id")
        );
        let help = "give all five above 0, or c3 alone for the ratios of mild steel";
        self.deck.trouble.error(card.place("c1"), message, help);
        None
    }

    /// Converts the loss of stress from a critical damage on.
    fn softening(&mut self, card: &CardRecord, table: &mut JobTable) {
        let critical = card.real("dcrit").max(0.0);
        match card.integer("icoup") {
            // With the damage 1 the point fails: there is no stress left to fade.
            0 | 1 if critical >= 1.0 => {
                let of = format!("material {}", card.integer("id"));
                let asked = format!("/FAIL/BIQUAD with dcrit {critical}");
                self.deck.map(of, asked, "no loss of stress before failure");
            }
            0 if critical == 0.0 => {}
            0 | 1 => {
                table.put("gissmo_critical_damage", card.place("dcrit"), critical);
                table.put(
                    "gissmo_fading_exponent",
                    card.place("exp"),
                    card.real_or("exp", 1.0).abs(),
                );
            }
            _ => {
                let why = "stress that fades after localized necking; use 1 with dcrit";
                self.deck.unsupported_value(card, "icoup", why);
            }
        }
    }
}

/// Returns the triaxialities of the points of the curve, ascending from -1 to 1.
fn triaxialities() -> impl Iterator<Item = f64> {
    let plane_strain = TESTS[PLANE_STRAIN];
    let at = |k: i32| f64::from(k) / f64::from(LINES);
    let below = (-LINES..=LINES).map(at).filter(move |x| *x < plane_strain);
    let above = (-LINES..=LINES).map(at).filter(move |x| *x > plane_strain);
    below.chain([plane_strain]).chain(above)
}

/// Returns the plastic strain to failure; `is_split` is true for vertices in plane strain.
fn strain_at(c: [f64; 5], is_split: bool, x: f64) -> f64 {
    let point = |k: usize| [TESTS[k], c[k]];
    // Parabola with its vertex at plane strain, through another point.
    let from_vertex = |k: usize| {
        let [[x0, y0], [x1, y1]] = [point(PLANE_STRAIN), point(k)];
        y0 + (y1 - y0) * ((x - x0) / (x1 - x0)).powi(2)
    };
    match x {
        _ if x <= TESTS[2] => through([point(0), point(1), point(2)], x),
        _ if !is_split => through([point(2), point(3), point(4)], x),
        _ if x <= TESTS[PLANE_STRAIN] => from_vertex(2),
        _ => from_vertex(4),
    }
}

/// Returns the value of the parabola through three points (Lagrange).
fn through(points: [[f64; 2]; 3], x: f64) -> f64 {
    let term = |k: usize| {
        let others = (0..3).filter(|&j| j != k);
        let factor = |j: usize| (x - points[j][0]) / (points[k][0] - points[j][0]);
        points[k][1] * others.map(factor).product::<f64>()
    };
    (0..3).map(term).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The coefficients that the starter prints for an example of the guide: 0.0918 x^2 - 0.1251 x
    /// + 0.19 and 0.03753 x^2 - 0.09483 x + 0.1859, to the digits of its strains.
    #[test]
    fn parabolas_are_those_of_the_guide() {
        let c = [0.2419, 0.19, 0.1585, 0.1437, 0.1394];
        for x in [-1.0, -0.2, 0.2, 0.3] {
            let guide = 0.0918 * x * x - 0.1251 * x + 0.19;
            assert!((strain_at(c, false, x) - guide).abs() < 1e-3, "{x}");
        }
        for x in [0.4, 0.6, 1.0] {
            let guide = 0.03753 * x * x - 0.09483 * x + 0.1859;
            assert!((strain_at(c, false, x) - guide).abs() < 1e-3, "{x}");
        }
        for (x, strain) in TESTS.iter().zip(c) {
            assert!((strain_at(c, true, *x) - strain).abs() < 1e-12);
        }
    }

    /// Plane strain is the minimum of split parabolas.
    #[test]
    fn plane_strain_is_a_vertex() {
        let c = [2.1, 0.96, 0.6, 0.36, 0.9];
        let all: Vec<f64> = triaxialities().map(|x| strain_at(c, true, x)).collect();
        let least = all.iter().copied().fold(f64::INFINITY, f64::min);
        assert_eq!((least, all.len()), (0.36, 32));
        assert!(triaxialities().is_sorted());
    }
}
