//! Writes materials.

use super::{Gap, Real, StarterWriter, Whole, named};
use crumple_proto::partition::{Material, Param};
use toml::{Table, Value};

/// Extension of a yield curve beyond its last point, as a factor of the strain.
const BEYOND: f64 = 2.0;

fn number(material: &Material, key: &str) -> f64 {
    match material.parameters.get(key) {
        Some(Param::Number(x)) => *x,
        _ => 0.0,
    }
}

fn numbers<const N: usize>(material: &Material, key: &str) -> Option<[f64; N]> {
    match material.parameters.get(key) {
        Some(Param::List(values)) => values.clone().try_into().ok(),
        _ => None,
    }
}

impl StarterWriter<'_> {
    /// Writes all materials; their ids are their numbers.
    pub(super) fn materials(&mut self) {
        let model = self.model;
        for (material, id) in model.settings.materials.iter().zip(1..) {
            match material.law.as_str() {
                "elastic" => self.elastic(material, id),
                "j2" => self.j2(material, id),
                "johnson_cook" => self.johnson_cook(material, id),
                law => {
                    self.lose(format!("material `{}`: law {law} has no keyword", material.name));
                }
            }
        }
    }

    /// Writes a keyword, the density and the elastic constants.
    fn head(&mut self, keyword: &str, material: &Material, id: u64) {
        self.titled(keyword, id, &material.name);
        self.card(&[Real(material.density)]);
        self.card(&[Real(number(material, "youngs_modulus")), Real(number(material, "poisson"))]);
    }

    fn elastic(&mut self, material: &Material, id: u64) {
        let mut own = self.model.job.part.iter().filter(|p| p.material == material.name).peekable();
        let is_skin = own.peek().is_some() && own.all(|p| p.skin);
        self.head(if is_skin { "MAT/LAW0" } else { "MAT/LAW1" }, material, id);
    }

    fn j2(&mut self, material: &Material, id: u64) {
        let fails = number(material, "failure_strain");
        let rate: Option<[f64; 2]> = numbers(material, "cowper_symonds");
        let Some(Param::Table(rows)) = material.parameters.get("hardening") else {
            let slope = number(material, "hardening_modulus");
            let yield_stress = number(material, "yield_stress");
            return match rate {
                Some([c, p]) => {
                    self.head("MAT/LAW44", material, id);
                    self.card(&[Real(yield_stress), Real(slope), Real(1.0)]);
                    self.card(&[Real(c), Real(p)]);
                    self.card(&[Real(fails)]);
                }
                None => {
                    self.head("MAT/LAW2", material, id);
                    self.card(&[Real(yield_stress), Real(slope), Real(1.0), Real(fails)]);
                    self.card(&[]);
                    self.card(&[]);
                }
            };
        };
        let mut points: Vec<[f64; 2]> =
            rows.iter().filter(|row| row.len() == 2).map(|row| [row[0], row[1]]).collect();
        if let [.., before, last] = points[..]
            && before[1] != last[1]
        {
            points.push([BEYOND * last[0], last[1]]);
        }
        let function = self.new_function(&format!("yield stress of {}", material.name), &points);
        self.titled("MAT/LAW36", id, &material.name);
        self.card(&[Real(material.density)]);
        let e = [number(material, "youngs_modulus"), number(material, "poisson"), fails];
        self.card(&e.map(Real));
        self.card(&[Whole(1)]);
        self.card(&[]);
        self.card(&[Whole(function)]);
        self.card(&[Real(1.0)]);
        self.card(&[Real(0.0)]);
        if let Some(pair) = rate {
            let own = Value::from(pair.to_vec());
            let table = Table::from_iter([named(&material.name), ("cowper_symonds".into(), own)]);
            self.rest("material", table);
        }
    }

    fn johnson_cook(&mut self, material: &Material, id: u64) {
        let of = |key: &str| number(material, key);
        let mut exact = Table::from_iter([named(&material.name)]);
        let damage: [f64; 5] = numbers(material, "damage").unwrap_or_default();
        let is_plain = damage[1..] == [0.0; 4];
        let limit = of("largest_stress");
        let is_cold = of("c") == 0.0 && of("specific_heat") == 0.0;
        let is_straight = is_cold && (of("n") == 1.0 || limit > 0.0);
        self.head("MAT/LAW2", material, id);
        let fails = if is_plain && !is_straight { damage[0] } else { 0.0 };
        let hardening = [of("a"), of("b"), of("n"), fails, limit].map(Real);
        self.card(&hardening[..if limit > 0.0 { 5 } else { 4 }]);
        self.card(&[Real(of("c")), Real(of("reference_rate"))]);
        let heat = of("specific_heat") * material.density;
        self.card(&[
            Real(of("m")),
            Real(of("melting_temperature")),
            Real(heat),
            Real(of("reference_temperature")),
        ]);
        if of("specific_heat") > 0.0 {
            if heat / material.density != of("specific_heat") {
                exact.insert("specific_heat".into(), of("specific_heat").into());
            }
            if of("reference_temperature") == 0.0 {
                exact.insert("reference_temperature".into(), 0.0.into());
            }
            let share = match material.parameters.get("taylor_quinney") {
                Some(Param::Number(share)) => *share,
                _ => DEFAULT_SHARE,
            };
            if share != 1.0 {
                exact.insert("taylor_quinney".into(), share.into());
            }
        }
        // A card of failure keeps the law, which is hardening by straight lines otherwise.
        if !is_plain || is_straight {
            self.keyword(&format!("FAIL/JOHNSON/{id}"));
            let own = if damage == [0.0; 5] { NEVER } else { damage };
            self.card(&own.map(Real));
            self.card(&[Real(of("reference_rate")), Gap, Gap]);
        }
        if exact.len() > 1 {
            self.rest("material", exact);
        }
    }
}

/// Fraction of plastic work that becomes heat, by default.
const DEFAULT_SHARE: f64 = 0.9;
/// Parameters of a failure that never happens.
const NEVER: [f64; 5] = [1e30, 0.0, 0.0, 0.0, 0.0];
