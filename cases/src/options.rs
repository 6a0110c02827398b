//! Reads the numbers of a job's `[scene]` table and checks them against the options of a generator.

use crate::Generator;
use crumple_proto::problem::Problem;
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Values of all options of a generator, from the job or by default.
#[derive(Clone, Debug)]
pub struct Options {
    values: BTreeMap<&'static str, f64>,
}

impl Options {
    /// Reads `scene` with the options of `generator`. A wrong key keeps its default and gives a
    /// problem.
    pub fn read(generator: &Generator, scene: &toml::Table) -> (Self, Vec<Problem>) {
        let mut values: BTreeMap<&'static str, f64> =
            generator.options.iter().map(|&(key, default, _)| (key, default)).collect();
        let mut problems = Vec::new();
        for (key, value) in scene {
            let path = format!("scene.{key}");
            let Some(&(known, default, meaning)) =
                generator.options.iter().find(|row| row.0 == key)
            else {
                let keys: Vec<&str> = generator.options.iter().map(|row| row.0).collect();
                let message = format!("the generator `{}` has no option `{key}`", generator.name);
                problems.push(Problem::error(path, message, nearest(key, &keys)));
                continue;
            };
            let number =
                value.as_float().or(value.as_integer().map(|i| i as f64)).filter(|x| x.is_finite());
            match number {
                Some(number) => {
                    values.insert(known, number);
                }
                None => problems.push(Problem::error(
                    path,
                    format!("`{key}` has to be a finite number, not {value}"),
                    format!("{meaning}; default {default}"),
                )),
            }
        }
        (Self { values }, problems)
    }

    /// Returns the value of an option. Adds a problem if it is outside `range`.
    ///
    /// # Panics
    /// If `key` is not in the generator's list.
    pub fn real(
        &self,
        key: &'static str,
        range: RangeInclusive<f64>,
        problems: &mut Vec<Problem>,
    ) -> f64 {
        let value = self.values[key];
        if !range.contains(&value) {
            problems.push(Problem::error(
                format!("scene.{key}"),
                format!("`{key}` = {value} is out of range"),
                format!("give a number from {} to {}", range.start(), range.end()),
            ));
        }
        value.clamp(*range.start(), *range.end())
    }

    /// Returns the value of an integer option. Adds a problem if it is not an integer in `range`.
    ///
    /// # Panics
    /// If `key` is not in the generator's list.
    pub fn count(
        &self,
        key: &'static str,
        range: RangeInclusive<usize>,
        problems: &mut Vec<Problem>,
    ) -> usize {
        let value = self.values[key];
        let (low, high) = (*range.start() as f64, *range.end() as f64);
        if value.fract() != 0.0 || !(low..=high).contains(&value) {
            problems.push(Problem::error(
                format!("scene.{key}"),
                format!("`{key}` = {value} is out of range"),
                format!("give a whole number from {low} to {high}"),
            ));
        }
        value.clamp(low, high) as usize
    }
}

/// Returns a sentence with the nearest name of `known`, and with all of them.
pub fn nearest(wrong: &str, known: &[&str]) -> String {
    let near = known
        .iter()
        .copied()
        .max_by(|a, b| strsim::jaro(wrong, a).total_cmp(&strsim::jaro(wrong, b)));
    match near {
        Some(near) if strsim::jaro(wrong, near) > 0.7 => {
            format!("did you mean `{near}`? There are: {}", known.join(", "))
        }
        _ => format!("there are: {}", known.join(", ")),
    }
}
