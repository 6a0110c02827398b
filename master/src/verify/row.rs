//! A row of the table: a quantity, ours against the reference.

use serde::Serialize;

/// What ours may be.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tolerance {
    /// Off by at most this fraction of the reference.
    Relative(f64),
    /// Off by at most this, in the unit of the quantity.
    Absolute(f64),
    /// No more than the reference.
    AtMost,
    /// No less than the reference.
    AtLeast,
    /// Anything: shown for orientation, there is no bound in the source.
    Recorded,
}

/// One quantity of a case.
#[derive(Clone, Debug, Serialize)]
pub struct Row {
    /// What is compared.
    pub quantity: String,
    /// Contact law, element, mesh.
    pub variant: String,
    /// Unit, empty for a ratio.
    pub unit: &'static str,
    /// What the source says.
    pub reference: f64,
    /// What we get.
    pub ours: f64,
    /// What ours may be.
    pub tolerance: Tolerance,
    /// Mark and key of the source, or the formula.
    pub source: &'static str,
    /// Why a failure is expected; empty where it is not.
    pub known: &'static str,
}

impl Row {
    /// A quantity with no bound yet.
    pub fn new(
        quantity: impl Into<String>,
        variant: impl Into<String>,
        unit: &'static str,
        ours: f64,
    ) -> Self {
        Self {
            quantity: quantity.into(),
            variant: variant.into(),
            unit,
            reference: f64::NAN,
            ours,
            tolerance: Tolerance::Recorded,
            source: "",
            known: "",
        }
    }

    fn bound(self, reference: f64, tolerance: Tolerance, source: &'static str) -> Self {
        Self { reference, tolerance, source, ..self }
    }

    /// Within this fraction of the reference.
    pub fn near(self, reference: f64, fraction: f64, source: &'static str) -> Self {
        self.bound(reference, Tolerance::Relative(fraction), source)
    }

    /// Within this distance of the reference.
    pub fn within(self, reference: f64, distance: f64, source: &'static str) -> Self {
        self.bound(reference, Tolerance::Absolute(distance), source)
    }

    /// At most this.
    pub fn at_most(self, limit: f64, source: &'static str) -> Self {
        self.bound(limit, Tolerance::AtMost, source)
    }

    /// At least this.
    pub fn at_least(self, limit: f64, source: &'static str) -> Self {
        self.bound(limit, Tolerance::AtLeast, source)
    }

    /// Beside this value, without a bound.
    pub fn beside(self, reference: f64, source: &'static str) -> Self {
        self.bound(reference, Tolerance::Recorded, source)
    }

    /// Without its bound, but beside what that was about.
    pub fn recorded(self) -> Self {
        Self { tolerance: Tolerance::Recorded, ..self }
    }

    /// A failure that is known, and why.
    pub fn known(self, why: &'static str) -> Self {
        Self { known: why, ..self }
    }

    /// Ours less the reference, as a fraction of it unless the tolerance is in the quantity's own
    /// unit.
    pub fn error(&self) -> f64 {
        match self.tolerance {
            Tolerance::Absolute(_) => self.ours - self.reference,
            _ => (self.ours - self.reference) / self.reference.abs(),
        }
    }

    /// Whether ours is what it may be; a number that is none never is.
    pub fn passes(&self) -> bool {
        match self.tolerance {
            Tolerance::Relative(f) => self.error().abs() <= f,
            Tolerance::Absolute(d) => self.error().abs() <= d,
            Tolerance::AtMost => self.ours <= self.reference,
            Tolerance::AtLeast => self.ours >= self.reference,
            Tolerance::Recorded => self.ours.is_finite(),
        }
    }

    /// The verdict in a word.
    pub fn verdict(&self) -> &'static str {
        match (self.passes(), self.tolerance) {
            (true, Tolerance::Recorded) => "recorded",
            (true, _) => "pass",
            (false, _) => "**FAIL**",
        }
    }

    /// The tolerance in words, with its class.
    pub fn tolerance_text(&self) -> String {
        let class = |f: f64| match f {
            f if f <= 1e-8 => "exact",
            f if f <= 0.01 => "tight",
            f if f <= 0.05 => "good",
            f if f <= 0.15 => "engineering",
            _ => "model",
        };
        match self.tolerance {
            Tolerance::Relative(f) if f < 1e-4 => format!("{f:.0e} ({})", class(f)),
            Tolerance::Relative(f) => format!("{} % ({})", short(100.0 * f), class(f)),
            Tolerance::Absolute(d) => format!("+-{}", short(d)),
            Tolerance::AtMost => "at most".into(),
            Tolerance::AtLeast => "at least".into(),
            Tolerance::Recorded => "-".into(),
        }
    }

    /// The error in words.
    pub fn error_text(&self) -> String {
        match self.tolerance {
            _ if !self.error().is_finite() => "-".into(),
            Tolerance::Absolute(_) => short(self.error()),
            Tolerance::Relative(f) if f < 1e-4 => format!("{:.1e}", self.error()),
            Tolerance::Relative(_) => format!("{:+.2} %", 100.0 * self.error()),
            Tolerance::Recorded => format!("{:+.1} %", 100.0 * self.error()),
            Tolerance::AtMost | Tolerance::AtLeast => "-".into(),
        }
    }
}

/// A number with the digits that a reader wants.
pub fn short(x: f64) -> String {
    match x.abs() {
        0.0 => "0".into(),
        a if !(1e-3..1e5).contains(&a) => format!("{x:.3e}"),
        a => {
            let digits = (3 - a.log10().floor() as i32).clamp(0, 6) as usize;
            let text = format!("{x:.digits$}");
            if text.contains('.') {
                text.trim_end_matches('0').trim_end_matches('.').to_string()
            } else {
                text
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_row_passes_only_within_its_tolerance() {
        let row = |ours: f64| Row::new("x", "", "", ours);
        assert!(
            row(101.0).near(100.0, 0.0101, "").passes()
                && !row(102.0).near(100.0, 0.0101, "").passes()
        );
        assert!(
            row(-0.99).near(-1.0, 0.02, "").passes() && !row(0.99).near(-1.0, 0.02, "").passes()
        );
        assert!(row(0.1).within(0.0, 0.1, "").passes() && !row(0.2).within(0.0, 0.1, "").passes());
        assert!(row(1.0).at_most(1.0, "").passes() && !row(1.1).at_most(1.0, "").passes());
        assert!(row(1.0).at_least(1.0, "").passes() && !row(0.9).at_least(1.0, "").passes());
        for broken in [
            row(f64::NAN).near(1.0, 1.0, ""),
            row(f64::NAN).within(1.0, 1.0, ""),
            row(f64::NAN).at_most(1.0, ""),
            row(f64::NAN).at_least(1.0, ""),
            row(f64::NAN),
        ] {
            assert!(!broken.passes() && broken.verdict() == "**FAIL**");
        }
    }

    #[test]
    fn numbers_are_short_and_true() {
        assert_eq!(
            [386.68, 0.005, 2e11, 1.0, 0.0, -31.4].map(short),
            ["386.7", "0.005", "2.000e11", "1", "0", "-31.4"]
        );
    }
}
