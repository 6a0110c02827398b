//! A row of the table: a computed quantity and its reference.

use serde::Serialize;

/// Allowed deviation of the computed value.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Tolerance {
    /// Largest deviation as a fraction of the reference.
    Relative(f64),
    /// Largest deviation in the unit of the quantity.
    Absolute(f64),
    /// At most the reference.
    AtMost,
    /// At least the reference.
    AtLeast,
    /// No bound: the source has none, and the row is for orientation.
    Recorded,
}

/// One quantity of a case.
#[derive(Clone, Debug, Serialize)]
pub struct CheckRow {
    /// Name of the quantity.
    pub quantity: String,
    /// Contact law, element, mesh.
    pub variant: String,
    /// Unit, empty for a ratio.
    pub unit: &'static str,
    /// Value of the source.
    pub reference: f64,
    /// Computed value.
    pub ours: f64,
    /// Allowed deviation.
    pub tolerance: Tolerance,
    /// Mark and key of the source, or the formula.
    pub source: &'static str,
    /// Reason of an expected failure, or empty.
    pub known: &'static str,
}

impl CheckRow {
    /// Creates a row without a bound.
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

    /// Requires a value within this fraction of the reference.
    pub fn near(self, reference: f64, fraction: f64, source: &'static str) -> Self {
        self.bound(reference, Tolerance::Relative(fraction), source)
    }

    /// Requires a value within this distance of the reference.
    pub fn within(self, reference: f64, distance: f64, source: &'static str) -> Self {
        self.bound(reference, Tolerance::Absolute(distance), source)
    }

    /// Requires at most this value.
    pub fn at_most(self, limit: f64, source: &'static str) -> Self {
        self.bound(limit, Tolerance::AtMost, source)
    }

    /// Requires at least this value.
    pub fn at_least(self, limit: f64, source: &'static str) -> Self {
        self.bound(limit, Tolerance::AtLeast, source)
    }

    /// Sets a reference without a bound.
    pub fn reference(self, reference: f64, source: &'static str) -> Self {
        self.bound(reference, Tolerance::Recorded, source)
    }

    /// Removes the bound and keeps the reference.
    pub fn recorded(self) -> Self {
        Self { tolerance: Tolerance::Recorded, ..self }
    }

    /// Marks a known failure and gives its reason.
    pub fn known(self, why: &'static str) -> Self {
        Self { known: why, ..self }
    }

    /// Returns the deviation from the reference, as a fraction of it unless the tolerance is in
    /// the quantity's own unit.
    pub fn error(&self) -> f64 {
        match self.tolerance {
            Tolerance::Absolute(_) => self.ours - self.reference,
            _ => (self.ours - self.reference) / self.reference.abs(),
        }
    }

    /// Returns true if the value is within its tolerance; NaN never is.
    pub fn passes(&self) -> bool {
        match self.tolerance {
            Tolerance::Relative(f) => self.error().abs() <= f,
            Tolerance::Absolute(d) => self.error().abs() <= d,
            Tolerance::AtMost => self.ours <= self.reference,
            Tolerance::AtLeast => self.ours >= self.reference,
            Tolerance::Recorded => self.ours.is_finite(),
        }
    }

    /// Returns the deviation over the allowed one; `None` if the bound is one-sided or there is
    /// none.
    pub fn share(&self) -> Option<f64> {
        match self.tolerance {
            Tolerance::Relative(allowed) | Tolerance::Absolute(allowed) if allowed > 0.0 => {
                Some(self.error().abs() / allowed)
            }
            _ => None,
        }
    }

    /// Returns the verdict in a word.
    pub fn verdict(&self) -> &'static str {
        match (self.passes(), self.tolerance) {
            (true, Tolerance::Recorded) => "recorded",
            (true, _) => "pass",
            (false, _) => "**FAIL**",
        }
    }

    /// Returns the tolerance in words, with its class.
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

    /// Returns the deviation in words.
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

/// Formats a number with the digits that a reader needs.
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
        let row = |ours: f64| CheckRow::new("x", "", "", ours);
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
