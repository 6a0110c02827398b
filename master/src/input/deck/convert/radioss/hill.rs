//! Converts `/MAT/LAW43` (HILL_TAB), orthotropic plasticity of sheets, to the law `barlat` with the
//! exponent 2, which is the yield condition of Hill. In Radioss the function of the yield stress is
//! that of
//! ```text
//! sigma^2 = A1 s_1^2 + A2 s_2^2 - A3 s_1 s_2 + A12 s_12^2,   A1 = H (1 + 1/r00),
//! H = r/(1 + r),   r = (r00 + 2 r45 + r90)/4
//! ```
//! and with `Iyield` 1 that of tension along the first axis, as in a job. The first one is the
//! second one times sqrt(A1); its plastic strain, which does the same work, is divided by it.

use super::StarterConverter;
use crate::input::deck::convert::materials::hardening_curve;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// Exponent of the yield condition.
const SQUARES: f64 = 2.0;

impl StarterConverter {
    /// Adds the yield condition and its hardening; the axes are those of the parts.
    pub(super) fn hill(&mut self, record: &CardRecord, table: &mut JobTable) {
        table.put("law", record.head, "barlat");
        table.put("exponent", record.head, SQUARES);
        let fields = ["r00", "r45", "r90"];
        let ratios = fields.map(|field| record.real_or(field, 1.0));
        for ((field, key), ratio) in
            fields.into_iter().zip(["lankford_0", "lankford_45", "lankford_90"]).zip(ratios)
        {
            if ratio <= 0.0 {
                let message = format!("{}: {field} is {ratio}", record.name());
                let help = "give the ratio of the plastic strains across and through the sheet, \
                            above 0";
                return self.deck.trouble.error(record.place(field), message, help);
            }
            table.put(key, record.place(field), ratio);
        }
        let along = match record.integer("iyield") {
            0 => {
                let [first, between, second] = ratios;
                let mean = (first + 2.0 * between + second) / 4.0;
                (mean / (1.0 + mean) * (1.0 + 1.0 / first)).sqrt()
            }
            _ => 1.0,
        };
        let lines: Vec<_> = record.lines("func").cloned().collect();
        let given: Vec<_> = lines.iter().filter(|line| line.integer("func") != 0).collect();
        let [line] = given[..] else {
            let message = format!("{}: {} functions", record.name(), given.len());
            let what = "functions of the yield stress by strain rate; give one".to_string();
            let place = given.get(1).map_or(record.head, |line| line.place("func"));
            return self.deck.unsupported(place, message, what);
        };
        let place = line.place("func");
        let Some(points) = self.points_of(line.integer("func"), place) else { return };
        let scale = match line.real("fscale") {
            0.0 => 1.0,
            scale => scale,
        };
        if line.real("rate") != 0.0 {
            self.deck.map(record.name(), "the rate of the function", "it holds for all rates");
        }
        let points = points.iter().map(|p| [p[0] * along, scale * p[1] / along]).collect();
        let rows: Vec<Vec<f64>> =
            hardening_curve(points).iter().map(|point| point.to_vec()).collect();
        table.put("hardening", place, rows);
        if along != 1.0 {
            let of = format!("material {}", record.integer("id"));
            let used = format!("its stress over {along:.4}, its strain times this: along axis 1");
            self.deck.map(of, "a yield stress that is a mean over the directions", used);
        }
        self.fabrics.expect(record.integer("id"));
    }
}
