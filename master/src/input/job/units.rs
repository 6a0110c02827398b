//! Checks if the numbers of a material are plausible in the units of the job.

use crumple_proto::job::{Job, MaterialSpec};
use crumple_proto::problem::Problem;

/// Densities of solid construction materials, from foam to osmium [kg/m^3].
const DENSITIES: std::ops::RangeInclusive<f64> = 5.0..=23_000.0;
/// Wave speeds `sqrt(E/rho)`, from soft rubber to diamond, and those of materials as dense as a
/// metal, from lead on [m/s].
const WAVE_SPEEDS: std::ops::RangeInclusive<f64> = 5.0..=19_000.0;
const OF_METALS: std::ops::RangeInclusive<f64> = 1000.0..=19_000.0;
/// Young's moduli, from soft foam to diamond [Pa].
const MODULI: std::ops::RangeInclusive<f64> = 1e5..=1.3e12;
/// Largest density of soft materials [kg/m^3].
const SOFT: f64 = 2600.0;

/// Units of length, time and mass, in SI.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Units {
    length: f64,
    time: f64,
    mass: f64,
}

impl Units {
    /// Metre, second, kilogram.
    pub const SI: Units = Units { length: 1.0, time: 1.0, mass: 1.0 };

    /// Returns the unit of a quantity in SI; its dimension is given by the powers of length, time
    /// and mass.
    pub fn factor(&self, [length, time, mass]: [i32; 3]) -> f64 {
        self.length.powi(length) * self.time.powi(time) * self.mass.powi(mass)
    }
}

/// Warns of every material whose density or wave speed does not exist in the stated units.
pub fn check(job: &Job) -> Vec<Problem> {
    // A material that carries no load may have any numbers.
    let bears = |name: &str| {
        let mut own = job.part.iter().filter(|p| p.materials().contains(&name)).peekable();
        own.peek().is_none() || own.any(|p| !p.skin)
    };
    let mut problems = yields(job, bears);
    let Some(units) = read(&job.units) else {
        if !job.units.trim().is_empty() {
            let message = format!("`units` = \"{}\" names no units that are known", job.units);
            let help = "write one unit each of length, time and mass, such as \"mm, ms, kg\": with \
                        them densities and moduli are checked";
            problems.push(Problem::warning("units", message, help));
        }
        return problems;
    };
    for (index, material) in job.material.iter().enumerate().filter(|(_, m)| bears(&m.name)) {
        let density = material.density * units.mass / units.length.powi(3);
        if density.is_finite() && density > 0.0 && !DENSITIES.contains(&density) {
            let message = format!(
                "material `{}`: in {} its density is {density:.3e} kg/m3",
                material.name, job.units
            );
            let steel = 7850.0 * units.length.powi(3) / units.mass;
            let help = format!(
                "check it and `units`: no solid has this density; steel has {steel:.3e} in these \
                 units"
            );
            problems.push(Problem::warning(format!("material.{index}.density"), message, help));
        }
        // The modulus of a honeycomb is that of its walls, the density that of the whole.
        if material.law == "honeycomb" {
            continue;
        }
        let Some(modulus) = youngs_modulus(material) else { continue };
        let speed = (modulus / material.density).sqrt() * units.length / units.time;
        if speed.is_finite() && speed > 0.0 && !wave_speeds(density).contains(&speed) {
            let message = format!(
                "material `{}`: in {} its wave speed sqrt(E/rho) is {speed:.3e} m/s",
                material.name, job.units
            );
            let steel = 207e9 * units.length * units.time * units.time / units.mass;
            let help = format!(
                "check it and `units`: no solid has this wave speed; steel has E = {steel:.3e} in \
                 these units"
            );
            problems.push(Problem::warning(
                format!("material.{index}.youngs_modulus"),
                message,
                help,
            ));
        }
    }
    problems
}

/// Returns true for a law of metals: elastic in all directions alike until it yields.
pub fn is_metal(law: &str) -> bool {
    matches!(law, "j2" | "johnson_cook" | "barlat")
}

/// Largest yield stress over Young's modulus: that of a perfect crystal (Frenkel 1926) is a tenth
/// to a fifth of the shear modulus.
const LARGEST_YIELD: f64 = 0.1;

/// Warns of every material that yields at strains at which no solid is elastic.
fn yields(job: &Job, bears: impl Fn(&str) -> bool) -> Vec<Problem> {
    let number = |value: &toml::Value| value.as_float().or(value.as_integer().map(|i| i as f64));
    let of = |(index, material): (usize, &MaterialSpec)| {
        let modulus = youngs_modulus(material)?;
        let (key, yields) = ["yield_stress", "a"]
            .into_iter()
            .find_map(|key| Some((key, number(material.parameters.get(key)?)?)))?;
        let is_metal = is_metal(&material.law);
        (is_metal && modulus > 0.0 && yields > LARGEST_YIELD * modulus).then(|| {
            let message = format!(
                "material `{}`: it yields at {yields:.3e}, {:.2} of its Young's modulus",
                material.name,
                yields / modulus
            );
            let help = "check both and `units`: metals yield below 0.02 of Young's modulus";
            Problem::warning(format!("material.{index}.{key}"), message, help)
        })
    };
    job.material.iter().enumerate().filter(|(_, m)| bears(&m.name)).filter_map(of).collect()
}

/// Returns the wave speeds [m/s] that exist at a density [kg/m^3].
fn wave_speeds(density: f64) -> &'static std::ops::RangeInclusive<f64> {
    if density > SOFT { &OF_METALS } else { &WAVE_SPEEDS }
}

/// Returns Young's modulus of a material that has one [force/length^2].
pub fn youngs_modulus(material: &MaterialSpec) -> Option<f64> {
    number(material, "youngs_modulus")
}

/// Returns a number among the parameters of a material, if it has it.
pub fn number(material: &MaterialSpec, key: &str) -> Option<f64> {
    let given = material.parameters.get(key)?;
    given.as_float().or(given.as_integer().map(|i| i as f64))
}

/// Returns true if a solid can have this density [mass/length^3] and Young's modulus
/// [force/length^2] in these units. A density of 0 or less is accepted.
pub fn fit(units: &str, density: f64, youngs_modulus: f64) -> bool {
    let Some(units) = read(units) else { return false };
    let speed = (youngs_modulus / density).sqrt() * units.length / units.time;
    let density = density * units.mass / units.length.powi(3);
    density.is_nan()
        || density <= 0.0
        || (DENSITIES.contains(&density) && (wave_speeds(density).contains(&speed) || speed == 0.0))
}

/// Returns true if a solid of any density can have this Young's modulus [force/length^2] in these
/// units.
pub fn modulus_fits(units: &str, youngs_modulus: f64) -> bool {
    let pascals = read(units).map(|units| youngs_modulus * units.factor([-1, -2, 1]));
    pascals.is_some_and(|modulus| MODULI.contains(&modulus))
}

/// Returns density and Young's modulus of mild steel in these units, with four digits
/// [mass/length^3, force/length^2].
pub fn steel_in(units: &str) -> Option<[f64; 2]> {
    let units = read(units)?;
    let value = |si: f64, powers| format!("{:.3e}", si / units.factor(powers)).parse().ok();
    Some([value(7850.0, [-3, 0, 1])?, value(207e9, [-1, -2, 1])?])
}

/// Reads `mm, ms, kg` and similar texts; `None` if the text does not name one unit each of
/// length, time and mass.
pub fn read(text: &str) -> Option<Units> {
    let words: Vec<&str> = text
        .split(|c: char| !c.is_alphanumeric() && c != 'µ')
        .filter(|word| !word.is_empty())
        .collect();
    let first = |known: &[(&str, f64)]| {
        words
            .iter()
            .find_map(|word| known.iter().find(|(name, _)| name == word).map(|(_, factor)| *factor))
    };
    Some(Units {
        length: first(&[
            ("mm", 1e-3),
            ("cm", 1e-2),
            ("m", 1.0),
            ("in", 0.0254),
            ("inch", 0.0254),
            ("ft", 0.3048),
        ])?,
        time: first(&[("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("µs", 1e-6)])?,
        mass: first(&[
            ("kg", 1.0),
            ("g", 1e-3),
            ("t", 1e3),
            ("tonne", 1e3),
            ("ton", 1e3),
            ("Mg", 1e3),
            // lbf s2/in and lbf s2/ft.
            ("slinch", 175.126_835),
            ("slug", 14.593_903),
        ])?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 7850 and 207 describe steel in no system of units. Where the density fits, a metal is
    /// stiffer.
    #[test]
    fn metals_are_not_as_soft_as_rubber() {
        assert!(fit("m, ms, kg", 7850.0, 207e3) && !fit("m, ms, kg", 7850.0, 207.0));
        assert!(fit("m, ms, kg", 1100.0, 5.0), "rubber");
    }

    /// A yield stress in MPa with a modulus in GPa, and units that are not known.
    #[test]
    fn wrong_units_of_one_value_are_noticed() {
        let job = |units: &str, yields: f64| -> Job {
            let text = format!(
                "units = \"{units}\"\nend_time = 1.0\n[mesh]\ngenerator = \"block\"\n\
                 [[material]]\nname = \"steel\"\nlaw = \"j2\"\ndensity = 7.85e-6\n\
                 youngs_modulus = 207.0\npoisson = 0.3\nyield_stress = {yields:?}\n"
            );
            toml::from_str(&text).unwrap()
        };
        let paths = |units: &str, yields: f64| -> Vec<String> {
            check(&job(units, yields)).into_iter().map(|problem| problem.path).collect()
        };
        assert!(paths("mm, ms, kg", 0.3).is_empty() && paths("", 0.3).is_empty());
        assert_eq!(paths("mm, ms, kg", 300.0), ["material.0.yield_stress"]);
        assert_eq!(paths("mm, ms, kgs", 0.3), ["units"]);
    }

    #[test]
    fn common_sets_are_read() {
        assert_eq!(read("mm, ms, kg"), Some(Units { length: 1e-3, time: 1e-3, mass: 1.0 }));
        assert_eq!(read("mm, ms, kg (so kN, GPa, J)"), read("mm-ms-kg"));
        assert_eq!(read("t mm s"), Some(Units { length: 1e-3, time: 1.0, mass: 1e3 }));
        assert_eq!(read("SI"), None);
        assert!(fit("in, s, slinch", 7.35e-4, 30e6), "steel in inches and pounds of force");
    }
}
