//! Converts the laws of springs and dampers, `*MAT_SPRING_...` and `*MAT_DAMPER_...`, to keys of
//! `[part.spring]`.

use super::DeckConverter;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;

/// Keywords of the laws.
pub(super) const LAWS: [&str; 8] = [
    "MAT_SPRING_ELASTIC",
    "MAT_DAMPER_VISCOUS",
    "MAT_SPRING_NONLINEAR_ELASTIC",
    "MAT_DAMPER_NONLINEAR_VISCOUS",
    "MAT_SPRING_ELASTOPLASTIC",
    "MAT_SPRING_GENERAL_NONLINEAR",
    "MAT_SPRING_MAXWELL",
    "MAT_SPRING_INELASTIC",
];

/// Smallest time that means never.
const NEVER: f64 = 1e19;

/// A law for the springs of a part.
pub(super) struct SpringCard<'a> {
    /// Its card.
    pub card: &'a CardRecord,
    /// Id of the part.
    pub pid: i64,
    /// Factor on its forces.
    pub scale: f64,
}

impl SpringCard<'_> {
    /// Copies force-like numbers of the card, times the scale: pairs of field and key.
    fn scaled(&self, table: &mut JobTable, fields: &[(&str, &str)]) {
        for (field, key) in fields {
            table.put(key, self.card.place(field), self.scale * self.card.real(field));
        }
    }
}

impl DeckConverter {
    /// Sets the keys of a law in `[part.spring]`. Returns the name of the most important one;
    /// `None` if a curve does not exist.
    pub(super) fn spring_law(
        &mut self,
        law: &SpringCard<'_>,
        spring: &mut JobTable,
    ) -> Option<&'static str> {
        let (card, mut own) = (law.card, JobTable::new(law.card.head));
        let key = match card.row.keyword.name {
            "MAT_SPRING_ELASTIC" => {
                law.scaled(spring, &[("k", "stiffness")]);
                return Some("stiffness");
            }
            "MAT_DAMPER_VISCOUS" => {
                law.scaled(spring, &[("dc", "damping")]);
                return Some("damping");
            }
            "MAT_SPRING_NONLINEAR_ELASTIC" => {
                if card.integer("lcr") != 0 {
                    self.unsupported_value(card, "lcr", "a curve over the rate");
                }
                let (points, at) = self.spring_curve(law, "lcd", Some("negative elongations"))?;
                spring.put("force_elongation", at, points);
                return Some("force_elongation");
            }
            "MAT_DAMPER_NONLINEAR_VISCOUS" => {
                let (points, at) = self.spring_curve(law, "lcdr", Some("negative rates"))?;
                spring.put("force_rate", at, points);
                return Some("force_rate");
            }
            "MAT_SPRING_ELASTOPLASTIC" => {
                let fields =
                    [("k", "stiffness"), ("kt", "tangent_stiffness"), ("fy", "yield_force")];
                law.scaled(&mut own, &fields);
                "elastoplastic"
            }
            "MAT_SPRING_GENERAL_NONLINEAR" => {
                self.two_curves(law, &mut own)?;
                "hysteresis"
            }
            "MAT_SPRING_MAXWELL" => {
                let fields = [("k0", "short_time_stiffness"), ("ki", "long_time_stiffness")];
                law.scaled(&mut own, &fields);
                own.put("decay", card.place("beta"), card.real("beta"));
                own.put("ageing", card.place("copt"), card.real("copt") != 0.0);
                let cutoff = card.real("tc");
                if cutoff != 0.0 && cutoff < NEVER {
                    own.put("cutoff_time", card.place("tc"), cutoff);
                    law.scaled(&mut own, &[("fc", "cutoff_force")]);
                }
                "maxwell"
            }
            _ => {
                let carries = match card.real("ctf") {
                    -1.0 => "tension",
                    0.0 | 1.0 => "compression",
                    _ => {
                        self.unsupported_value(card, "ctf", "use -1 (tension) or 1 (compression)");
                        "compression"
                    }
                };
                own.put("carries", card.place("ctf"), carries);
                let (points, at) = self.spring_curve(law, "lcfd", None)?;
                own.put("loading", at, points);
                law.scaled(&mut own, &[("ku", "unloading_stiffness")]);
                "one_sided"
            }
        };
        spring.put(key, card.head, own);
        Some(key)
    }

    /// Converts a law with a curve of loading and one of unloading.
    fn two_curves(&mut self, law: &SpringCard<'_>, own: &mut JobTable) -> Option<()> {
        let card = law.card;
        let beta = card.real("beta");
        if beta == 1.0 {
            own.put("hardening", card.place("beta"), "isotropic");
            let forces = ["cyi", "tyi"].map(|field| law.scale * card.real(field));
            if forces != [0.0; 2] {
                own.put("yield_forces", card.place("tyi"), forces);
            }
        } else if beta != 0.0 {
            let why = "kinematic hardening; use 0 (independent sides) or 1 (isotropic)";
            self.unsupported_value(card, "beta", why);
        }
        let loading = self.spring_curve(law, "lcdl", Some("negative elongations"));
        let unloading = self.spring_curve(law, "lcdu", None);
        let ((loading, at), (unloading, below)) = (loading?, unloading?);
        own.put("loading", at, loading);
        own.put("unloading", below, unloading);
        Some(())
    }

    /// Returns the points of a curve with its forces times the scale, and its place. `below` are
    /// the values that it should have points for.
    fn spring_curve(
        &mut self,
        law: &SpringCard<'_>,
        field: &str,
        below: Option<&str>,
    ) -> Option<(Vec<Vec<f64>>, Place)> {
        let id = law.card.integer(field);
        let curve = self.curve(id, law.card.place(field))?;
        if let Some(below) = below
            && curve.points.first().is_some_and(|p| p[0] >= 0.0)
        {
            let asked = format!("curve {id} has no points for {below}");
            self.map(format!("part {}", law.pid), asked, "extrapolated with its first slope");
        }
        let points = curve.points.iter().map(|p| vec![p[0], law.scale * p[1]]).collect();
        Some((points, curve.place))
    }
}
