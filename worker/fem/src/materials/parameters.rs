//! Reads the parameters of a law and collects all problems of a material at once.

use super::{Elastic, LawResult, PlaneStress, Solid, SolidLawResult};
use crumple_proto::partition::{Material, Param};
use crumple_proto::problem::Problem;

/// A material's table while it is read. Parameters that were requested are known; the others are
/// not.
pub struct Parameters<'a> {
    material: &'a Material,
    known: Vec<&'static str>,
    problems: Vec<Problem>,
}

impl<'a> Parameters<'a> {
    /// Creates a reader without requested parameters.
    pub fn new(material: &'a Material) -> Self {
        Self { material, known: Vec::new(), problems: Vec::new() }
    }

    /// Records a problem of `key`.
    pub fn wrong(&mut self, key: &str, what: impl std::fmt::Display, help: impl Into<String>) {
        let message = format!("material '{}': {key} {what}", self.material.name);
        self.problems.push(Problem::error(key, message, help));
    }

    /// Returns the parameter as written, if it is given.
    pub fn get(&mut self, key: &'static str) -> Option<&'a Param> {
        self.known.push(key);
        self.material.parameters.get(key)
    }

    /// Returns true if the material has this parameter.
    pub fn given(&self, key: &str) -> bool {
        self.material.parameters.contains_key(key)
    }

    /// Returns an optional number. `wanted` describes in words which values `fits` accepts.
    pub fn optional(
        &mut self,
        key: &'static str,
        wanted: &str,
        fits: impl Fn(f64) -> bool,
    ) -> Option<f64> {
        match self.get(key)? {
            Param::Number(value) if value.is_finite() && fits(*value) => Some(*value),
            Param::Number(value) => {
                self.wrong(key, format_args!("is {value}"), format!("it has to be {wanted}"));
                None
            }
            Param::Flag(flag) => {
                self.wrong(key, format_args!("is {flag}"), format!("give one number, {wanted}"));
                None
            }
            Param::List(_) | Param::Table(_) => {
                self.wrong(key, "is a list", format!("give one number, {wanted}"));
                None
            }
        }
    }

    /// Returns a required number. The value returned for a missing or wrong one is never used,
    /// since [`Self::finish`] then fails.
    pub fn required(&mut self, key: &'static str, wanted: &str, fits: impl Fn(f64) -> bool) -> f64 {
        let value = self.optional(key, wanted, fits);
        if !self.given(key) {
            let law = &self.material.law;
            self.wrong(key, "is missing", format!("law '{law}' needs it: a number, {wanted}"));
        }
        value.unwrap_or(1.0)
    }

    /// Returns a flag; false if it is not given.
    pub fn flag(&mut self, key: &'static str) -> bool {
        match self.get(key) {
            None => false,
            Some(Param::Flag(flag)) => *flag,
            Some(_) => {
                self.wrong(key, "is not a flag", "give true or false");
                false
            }
        }
    }

    /// Returns an optional vector, not zero.
    pub fn direction(&mut self, key: &'static str) -> Option<[f64; 3]> {
        let vector = match self.get(key)? {
            Param::List(list) => <[f64; 3]>::try_from(list.as_slice()).ok(),
            _ => None,
        };
        let vector = vector.filter(|v| v.iter().all(|c| c.is_finite()) && *v != [0.0; 3]);
        if vector.is_none() {
            self.wrong(key, "is no direction", "give [x, y, z], not all of them 0");
        }
        vector
    }

    /// Returns the rows of an optional table of N finite numbers each; `form` describes the table.
    /// Reports an error, and returns no rows, if it has another form.
    pub fn rows<const N: usize>(&mut self, key: &'static str, form: &str) -> Option<Vec<[f64; N]>> {
        let given = self.get(key)?;
        let rows: Option<Vec<[f64; N]>> = match given {
            Param::Table(rows) => rows.iter().map(|row| row.as_slice().try_into().ok()).collect(),
            _ => None,
        };
        let sound = |rows: &Vec<[f64; N]>| {
            !rows.is_empty() && rows.iter().flatten().all(|value| value.is_finite())
        };
        let rows = rows.filter(sound);
        if rows.is_none() {
            self.wrong(key, format_args!("is not a table of rows {form}"), format!("give {form}"));
        }
        Some(rows.unwrap_or_default())
    }

    /// Returns the points of an optional curve whose abscissas ascend from 0 on. Reports an error,
    /// and returns no points, if they do not. `fits` checks a point, and `wanted` says in words
    /// what it accepts.
    pub fn curve(
        &mut self,
        key: &'static str,
        form: &str,
        (wanted, fits): (&str, impl Fn(&[f64; 2]) -> bool),
    ) -> Option<Vec<[f64; 2]>> {
        let rows = self.rows::<2>(key, form)?;
        let ascends = rows.windows(2).all(|two| two[0][0] < two[1][0]);
        if !(rows.is_empty() || ascends && rows[0][0] == 0.0 && rows.iter().all(fits)) {
            let help = format!("give {form} with increasing abscissas from 0 on, {wanted}");
            self.wrong(key, "is not such a curve", help);
            return Some(Vec::new());
        }
        Some(rows)
    }

    /// Returns the points of an optional curve whose abscissas ascend. Reports an error if they do
    /// not, or if `fits` does not accept one; `wanted` says in words what it accepts.
    pub fn ascending(
        &mut self,
        key: &'static str,
        (form, wanted): (&str, &str),
        fits: impl Fn(&[f64; 2]) -> bool,
    ) -> Option<Vec<[f64; 2]>> {
        let rows = self.rows::<2>(key, form)?;
        let ascends = rows.windows(2).all(|two| two[0][0] < two[1][0]);
        if !(ascends && rows.iter().all(fits)) {
            let help = format!("give {form} with increasing abscissas, {wanted}");
            self.wrong(key, "is not such a curve", help);
        }
        Some(rows)
    }

    /// Returns `youngs_modulus`, `poisson` and the density.
    pub fn elastic(&mut self) -> Elastic {
        let density = self.density();
        Elastic {
            youngs_modulus: self.required("youngs_modulus", "above 0", |e| e > 0.0),
            poisson: self
                .required("poisson", "above -1 and at most 0.5", |nu| nu > -1.0 && nu <= 0.5),
            density,
        }
    }

    /// Returns the density.
    pub fn density(&mut self) -> f64 {
        let density = self.material.density;
        if !(density.is_finite() && density > 0.0) {
            self.wrong("density", format_args!("is {density}"), "it has to be above 0");
        }
        density
    }

    /// Returns the elastic constants of a solid, whose bulk modulus must be finite.
    pub fn solid_elastic(&mut self) -> Elastic {
        let elastic = self.elastic();
        if elastic.poisson == 0.5 {
            let help = "a solid needs a finite bulk modulus: use 0.49 or 0.499 for a nearly \
                        incompressible one";
            self.wrong("poisson", "is 0.5", help);
        }
        elastic
    }

    /// Builds a law in plane stress from its elastic constants and the result of `read`.
    pub fn shell_law<L>(
        mut self,
        read: impl Fn(Self, Elastic) -> Result<L, Vec<Problem>>,
    ) -> LawResult
    where
        L: PlaneStress + 'static,
    {
        let elastic = self.elastic();
        Ok(Box::new(read(self, elastic)?))
    }

    /// Builds a law in three dimensions from its elastic constants and the result of `read`.
    pub fn solid_law<L>(
        mut self,
        read: impl Fn(Self, Elastic) -> Result<L, Vec<Problem>>,
    ) -> SolidLawResult
    where
        L: Solid + 'static,
    {
        let elastic = self.solid_elastic();
        Ok(Box::new(read(self, elastic)?))
    }

    /// Returns all problems, including parameters that no law requested.
    pub fn finish(mut self) -> Result<(), Vec<Problem>> {
        for key in self.material.parameters.keys() {
            if !self.known.contains(&key.as_str()) {
                let Material { name, law, .. } = self.material;
                let what = format!("material '{name}': law '{law}' has no parameter '{key}'");
                self.problems.push(unknown_name(key, what, key, &self.known));
            }
        }
        if self.problems.is_empty() { Ok(()) } else { Err(self.problems) }
    }
}

/// Returns a material with the keys that begin with `prefix`, and one with the others.
pub(super) fn divided(material: &Material, prefix: &str) -> (Material, Material) {
    let (mut own, mut rest) = (material.clone(), material.clone());
    own.parameters.retain(|key, _| key.starts_with(prefix));
    rest.parameters.retain(|key, _| !key.starts_with(prefix));
    (own, rest)
}

/// Returns the problem of an unknown name, with the nearest known name and all known names.
pub(crate) fn unknown_name(path: &str, what: String, name: &str, known: &[&str]) -> Problem {
    let list = known.join(", ");
    let help = match nearest(name, known) {
        Some(near) => format!("did you mean '{near}'? known: {list}"),
        None => format!("known: {list}"),
    };
    Problem::error(path, what, help)
}

/// Returns the known name nearest to `name`, if it is near enough to be a typing error.
pub(crate) fn nearest<'a>(name: &str, known: &[&'a str]) -> Option<&'a str> {
    let limit = name.chars().count().div_ceil(2);
    let distances = known.iter().map(|&other| (edits(name, other), other));
    distances
        .min_by_key(|&(distance, _)| distance)
        .filter(|&(distance, _)| distance <= limit)
        .map(|(_, other)| other)
}

/// Returns the smallest number of single-letter insertions, deletions and replacements that
/// change `a` into `b` (Levenshtein).
fn edits(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, ca) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &cb) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(ca != cb);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slip_finds_its_name_and_nonsense_does_not() {
        let known = ["youngs_modulus", "poisson", "yield_stress"];
        assert_eq!(nearest("young_modulus", &known), Some("youngs_modulus"));
        assert_eq!(nearest("possion", &known), Some("poisson"));
        assert_eq!(nearest("xyzzy", &known), None);
    }

    #[test]
    fn all_errors_are_reported_at_once() {
        let parameters = [
            ("young_modulus".to_string(), Param::Number(210.0)),
            ("poisson".to_string(), Param::Number(0.7)),
            ("yield_stress".to_string(), Param::List(vec![1.0])),
        ];
        let (name, law) = ("steel".to_string(), "j2".to_string());
        let material = Material { name, law, density: -1.0, parameters: parameters.into() };
        let problems = crate::materials::build(&material).err().expect("all parameters are wrong");
        let paths: Vec<_> = problems.iter().map(|problem| problem.path.as_str()).collect();
        assert_eq!(
            paths,
            ["density", "youngs_modulus", "poisson", "yield_stress", "young_modulus"]
        );
        assert!(problems[4].help.contains("'youngs_modulus'"), "{}", problems[4].help);
        assert!(problems.iter().all(|problem| problem.message.contains("'steel'")));

        let flags = ["youngs_modulus", "poisson", "yield_stress"];
        let parameters = flags.map(|key| (key.to_string(), Param::Flag(true))).into();
        let flagged = Material { parameters, density: 1.0, ..material.clone() };
        let problems = crate::materials::build(&flagged).err().expect("flags are no numbers");
        assert!(problems.len() == 3 && problems[0].message.contains("is true"), "{problems:?}");

        let material = Material { law: "j3".into(), ..material };
        let problems = crate::materials::build(&material).err().expect("no such law");
        assert!(
            problems[0].help.contains("'j2'") && problems[0].help.contains("elastic"),
            "{}",
            problems[0].help
        );
    }
}
