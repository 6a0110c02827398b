//! Converts `*MAT_HONEYCOMB` and `*MAT_MODIFIED_HONEYCOMB` (LS-DYNA Keyword User's Manual, vol. II,
//! materials 26 and 126).

use super::DeckConverter;
use super::curves::DeckCurve;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// Curves: field and key.
const CURVES: [(&str, &str); 7] = [
    ("lca", "crush_a"),
    ("lcb", "crush_b"),
    ("lcc", "crush_c"),
    ("lcs", "crush_shear"),
    ("lcab", "crush_ab"),
    ("lcbc", "crush_bc"),
    ("lcca", "crush_ca"),
];

impl DeckConverter {
    /// Converts the parameters of a honeycomb and returns its largest modulus before compaction
    /// [force/length^2]. `directional` is true if its curves are over the strain of their own
    /// direction.
    pub(super) fn honeycomb(
        &mut self,
        record: &CardRecord,
        table: &mut JobTable,
        directional: bool,
    ) -> f64 {
        table.put("law", record.head, "honeycomb");
        for (field, key) in [
            ("e", "youngs_modulus"),
            ("pr", "poisson"),
            ("sigy", "yield_stress"),
            ("vf", "compacted_volume"),
        ] {
            table.put(key, record.place(field), record.real(field));
        }
        let (e, pr) = (record.real("e"), record.real("pr"));
        let shear = 0.5 * e / (1.0 + pr);
        // A blank modulus is that of the solid.
        let moduli = [
            ("eaau", e),
            ("ebbu", e),
            ("eccu", e),
            ("gabu", shear),
            ("gbcu", shear),
            ("gcau", shear),
        ]
        .map(|(field, solid)| match record.real(field) {
            0.0 => solid,
            modulus => modulus,
        });
        table.put("moduli", record.place("eaau"), moduli);
        if directional {
            table.put("directional", record.head, true);
            self.map(
                format!("material {}", record.integer("mid")),
                "curves over the strain of their direction, logarithmic but with elform 0 and 9",
                "over the nominal strain with any elform",
            );
        }
        for (field, key) in CURVES {
            let (id, place) = (record.integer(field), record.place(field));
            if id < 0 {
                let why = "a yield surface over the angle to the axes; give a curve of stress";
                self.unsupported_value(record, field, why);
            } else if id > 0
                && let Some(curve) = self.curve(id, place)
            {
                let points = self.crush_curve(record, field, curve, directional);
                table.put(key, place, points);
            }
        }
        let (rates, place) = (record.integer("lcsr"), record.place("lcsr"));
        if rates < 0 {
            self.unsupported_value(record, "lcsr", "a curve of factors for each component");
        } else if rates > 0
            && let Some(curve) = self.curve(rates, place)
        {
            let points: Vec<Vec<f64>> = curve.points.iter().map(|p| p.to_vec()).collect();
            table.put("rate_factors", place, points);
        }
        for (field, key) in [("tsef", "tension_failure_strain"), ("ssef", "shear_failure_strain")] {
            let strain = record.real(field);
            if strain > 0.0 {
                table.put(key, record.place(field), strain);
            } else if strain < 0.0 {
                self.unsupported_value(record, field, "a curve; give one strain");
            }
        }
        self.solid_axes(record, table);
        moduli.into_iter().fold(0.0, f64::max)
    }

    /// Returns the points of a curve over the strain that is positive in compression. A curve over
    /// the volume of material 26 that begins above zero is over the relative volume.
    fn crush_curve(
        &mut self,
        record: &CardRecord,
        field: &str,
        curve: DeckCurve,
        directional: bool,
    ) -> Vec<Vec<f64>> {
        let by_volume = !directional && curve.points.first().is_some_and(|point| point[0] > 0.0);
        if !by_volume {
            return curve.points.iter().map(|point| point.to_vec()).collect();
        }
        self.map(
            format!("material {}, {field}", record.integer("mid")),
            "a curve that begins above 0: stress over the relative volume V",
            "the volume strain 1 - V",
        );
        curve.points.iter().rev().map(|point| vec![1.0 - point[0], point[1]]).collect()
    }

    /// Converts the axes of the material of solids.
    fn solid_axes(&mut self, record: &CardRecord, table: &mut JobTable) {
        match record.real("aopt") {
            0.0 => {}
            2.0 => {
                for (field, others, key) in
                    [("a1", ["a2", "a3"], "direction"), ("d1", ["d2", "d3"], "direction_2")]
                {
                    let [y, z] = others.map(|other| record.real(other));
                    let vector = [record.real(field), y, z];
                    if vector == [0.0; 3] {
                        let message = format!("aopt 2 without the vector of {field}");
                        let help = "give the vectors a and d, or aopt 0 for the nodes 1, 2 and 4";
                        self.trouble.error(record.place("aopt"), message, help);
                    } else {
                        table.put(key, record.place(field), vector);
                    }
                }
            }
            _ => self.unsupported_value(record, "aopt", "use aopt 0 or 2"),
        }
        if ![0.0, 1.0].contains(&record.real("macf")) {
            self.unsupported_value(record, "macf", "exchanged axes; give them in order");
        }
    }
}
