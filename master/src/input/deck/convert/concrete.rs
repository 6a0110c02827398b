//! Converts `*MAT_CSCM` and `*MAT_CSCM_CONCRETE` to the law `cscm`. The constants by the strength
//! and the aggregate are those of Murray (2007), Users Manual for LS-DYNA Concrete Material Model
//! 159, FHWA-HRT-05-062, ch. 3; valid for strengths from 20 to 58 MPa and aggregates from 8 to
//! 32 mm.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;

/// Keywords of this file.
pub const KEYWORDS: [&str; 2] = ["MAT_CSCM", "MAT_CSCM_CONCRETE"];

/// Unit of stress in MPa, of length in mm and of time in s, by `units`: kN, mm, ms, kg; N, mm, ms,
/// g; N, mm, s, t; lbf, in, s; N, m, s, kg.
const UNITS: [[f64; 3]; 5] = [
    [1e3, 1.0, 1e-3],
    [1.0, 1.0, 1e-3],
    [1.0, 1.0, 1.0],
    [6.894757e-3, 25.4, 1.0],
    [1e-6, 1e3, 1.0],
];

/// Strength [MPa] and aggregate [mm] of blanks.
const USUAL: [f64; 2] = [30.0, 19.0];
/// Psi per MPa: the times of the rate are fitted over the strength in psi.
const PSI: f64 = 145.0377;

impl DeckConverter {
    /// Converts the parameters of concrete and returns Young's modulus [force/length^2].
    pub(super) fn concrete(
        &mut self,
        keyword: &str,
        record: &CardRecord,
        table: &mut JobTable,
    ) -> f64 {
        table.put("law", record.head, "cscm");
        let erode = record.real("erode");
        if erode >= 1.0 {
            table.put("erosion_strain", record.place("erode"), erode - 1.0);
        }
        match record.real("recov") {
            0.0 => {}
            share => table.put("recovery", record.place("recov"), share),
        }
        if record.integer("itretrc") != 0 {
            self.unsupported_value(record, "itretrc", "a cap that returns; use 0");
        }
        let irate = record.integer("irate");
        if !(0..=1).contains(&irate) {
            self.unsupported_value(record, "irate", "use 0 (no effect of the rate) or 1");
        }
        match keyword {
            "MAT_CSCM" => self.given(record, table, irate == 1),
            _ => self.fitted(record, table, irate == 1),
        }
    }

    fn given(&mut self, record: &CardRecord, table: &mut JobTable, by_rate: bool) -> f64 {
        let [g, k] = ["g", "k"].map(|field| record.real(field));
        let e = elastic(record, table, "g", g, k);
        if !matches!(record.real("nh"), 0.0 | 1.0) {
            self.unsupported_value(record, "nh", "hardening before the peak; use 1");
        }
        let lists = [
            ("shear_surface", ["alpha", "theta", "lamda", "beta"]),
            ("torsion", ["alpha1", "theta1", "lamda1", "beta1"]),
            ("extension", ["alpha2", "theta2", "lamda2", "beta2"]),
        ];
        for (key, fields) in lists {
            table.put(key, record.place(fields[0]), fields.map(|field| record.real(field)));
        }
        let cap = ["r", "xd", "w", "d1", "d2"].map(|field| record.real(field));
        table.put("cap", record.place("r"), cap);
        for (field, key) in [
            ("gft", "tension_energy"),
            ("gfc", "compression_energy"),
            ("gfs", "shear_energy"),
            ("d", "tension_shape"),
            ("b", "compression_shape"),
            ("pwrt", "tension_power"),
            ("pwrc", "compression_power"),
            ("pmod", "softening_power"),
        ] {
            table.put(key, record.place(field), record.real(field));
        }
        let [tension, compression] = [["eta0t", "nt", "overt"], ["eta0c", "nc", "overc"]];
        if by_rate {
            for (key, fields) in [("tension_rate", tension), ("compression_rate", compression)] {
                let [eta, n, over] = fields.map(|field| record.real(field));
                // A blank overstress is none; that of the modulus is never reached.
                let over = if over == 0.0 { e } else { over };
                table.put(key, record.place(fields[0]), [eta, n, over]);
            }
            table.put("shear_rate_ratio", record.place("srate"), record.real("srate"));
            table.put("rate_energy_power", record.place("repow"), record.real("repow"));
        }
        e
    }

    fn fitted(&mut self, record: &CardRecord, table: &mut JobTable, by_rate: bool) -> f64 {
        let units = usize::try_from(record.integer("units")).ok();
        let Some([mpa, mm, s]) = units.and_then(|units| UNITS.get(units)).copied() else {
            let message = format!("{}: units is {}", record.name(), record.integer("units"));
            let help = "use 0 (GPa, mm, ms), 1 (MPa, mm, ms), 2 (MPa, mm, s), 3 (psi, inch, s) \
                        or 4 (Pa, m, s)";
            self.trouble.error(record.place("units"), message, help);
            return 1.0;
        };
        let given = [record.real("fpc") * mpa, record.real("dagg") * mm];
        let [fc, aggregate]: [f64; 2] =
            std::array::from_fn(|k| if given[k] == 0.0 { USUAL[k] } else { given[k] });
        if !(20.0..=58.0).contains(&fc) || !(8.0..=32.0).contains(&aggregate) {
            let message = format!(
                "{}: the constants are fitted for strengths from 20 to 58 MPa and aggregates from \
                 8 to 32 mm; fpc is {fc:.4} MPa and dagg {aggregate:.4} mm by `units` = {}",
                record.name(),
                record.integer("units"),
            );
            let help = "check `units`; for other concrete give the constants by *MAT_CSCM";
            // Nothing can be fitted to a strength that may be one in other units.
            if (10.0..=90.0).contains(&fc) && (2.0..=64.0).contains(&aggregate) {
                self.trouble.warning(record.place("fpc"), message, help);
            } else {
                self.trouble.error(record.place("fpc"), message, help);
                return 1.0;
            }
        }
        let place = record.place("fpc");
        let square = |[a, b, c]: [f64; 3], x: f64| (a * x + b) * x + c;
        let stress = |value: f64| value / mpa;
        // E of CEB-FIP (1993), reduced to 0.85 of the tangent, as in the source.
        let modulus = 18_275.0 * (0.1 * fc).cbrt();
        let (g, k) = (modulus / (2.0 * 1.15), modulus / (3.0 * 0.7));
        let e = elastic(record, table, "fpc", stress(g), stress(k));
        let strength = [
            stress(square([-0.003, 0.316_974_7, 7.7047], fc)),
            square([1.3216e-5, 2.3548e-3, 0.214_005_8], fc),
            stress(10.5),
            1.929e-2 * mpa,
        ];
        let torsion = [
            0.74735,
            square([-4.0856e-7, -1.2132e-6, 1.5593e-3], fc) * mpa,
            0.17,
            square([-1.9972e-5, 2.2655e-4, 8.1748e-2], fc) * mpa,
        ];
        let extension = [
            0.66,
            square([-4.8697e-7, -1.8883e-6, 1.8822e-3], fc) * mpa,
            0.16,
            square([-1.9972e-5, 2.2655e-4, 8.2748e-2], fc) * mpa,
        ];
        table.put("shear_surface", place, strength);
        table.put("torsion", place, torsion);
        table.put("extension", place, extension);
        let start = square([8.769_178e-3, -7.330_230_6e-2, 84.85], fc);
        let cap = [5.0, stress(start), 0.05, 2.5e-4 * mpa, 3.49e-7 * mpa * mpa];
        table.put("cap", place, cap);
        // N/mm; over the aggregate the parabola through the values of CEB-FIP (1993), table 2.1.4.
        let energy = parabola(aggregate) * (0.1 * fc).powf(0.7) / (mpa * mm);
        for (key, factor) in
            [("tension_energy", 1.0), ("compression_energy", 100.0), ("shear_energy", 1.0)]
        {
            table.put(key, place, factor * energy);
        }
        if by_rate {
            let over = stress(square([1.309_663e-2, -0.392_765_9, 21.45], fc));
            let psi = fc * PSI;
            for (key, n, fit) in [
                ("tension_rate", 0.48, [8.061_477_4e-13, -9.777_367_19e-10, 5.075_235_1e-5]),
                ("compression_rate", 0.78, [1.277_233_7e-11, -1.061_372_2e-7, 3.203_497e-4]),
            ] {
                // eta/rate^n is a time: s^(1 - n).
                let eta = square(fit, psi) / s.powf(1.0 - n);
                table.put(key, place, [eta, n, over]);
            }
        }
        e
    }
}

/// Returns the energy of cracks of a strength of 10 MPa [N/mm] over the aggregate [mm]: the
/// parabola through 0.025 at 8 mm, 0.030 at 16 mm and 0.058 at 32 mm.
fn parabola(aggregate: f64) -> f64 {
    let [first, second, third] = [[8.0, 0.025], [16.0, 0.030], [32.0, 0.058]];
    let slope = |a: [f64; 2], b: [f64; 2]| (b[1] - a[1]) / (b[0] - a[0]);
    let curvature = (slope(second, third) - slope(first, second)) / (third[0] - first[0]);
    let along = slope(first, second) + curvature * (aggregate - second[0]);
    first[1] + along * (aggregate - first[0])
}

/// Puts the elastic constants by the moduli of shear and compression; returns Young's modulus.
fn elastic(record: &CardRecord, table: &mut JobTable, field: &str, g: f64, k: f64) -> f64 {
    let e = 9.0 * k * g / (3.0 * k + g);
    table.put("youngs_modulus", record.place(field), e);
    table.put("poisson", record.place(field), (3.0 * k - 2.0 * g) / (2.0 * (3.0 * k + g)));
    e
}
