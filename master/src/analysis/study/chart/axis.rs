//! Scales of axes, and readable ticks.

/// A scale: linear, logarithmic, or a row of words.
#[derive(Clone, Debug)]
pub struct ChartAxis {
    log: bool,
    /// Ends of the scale; their logarithms (base 10) on a logarithmic scale.
    ends: [f64; 2],
    /// Positions of the ends on the page.
    page: [f64; 2],
    /// Words at 0, 1, 2 ...; empty on a scale of numbers.
    words: Vec<String>,
}

/// A tick: position and label. Ticks without a label are short.
#[derive(Clone, Debug, PartialEq)]
pub struct Tick {
    /// Value.
    pub value: f64,
    /// Text, if any.
    pub label: Option<String>,
}

/// Margin outside the outermost values, as a fraction of their distance.
const ROOM: f64 = 0.06;

impl ChartAxis {
    /// Creates a scale that shows all values. Values that it cannot show are ignored.
    pub fn around(values: impl Iterator<Item = f64>, log: bool, page: [f64; 2]) -> Self {
        let on_scale = values.map(|v| if log { v.log10() } else { v }).filter(|v| v.is_finite());
        let (low, high) =
            on_scale.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| (l.min(v), h.max(v)));
        let (low, high) = if low > high { (0.0, 1.0) } else { (low, high) };
        let flat = if log { 0.3 } else { 0.5 * low.abs().max(1e-12) };
        let room = if high - low > 1e-9 * high.abs() { ROOM * (high - low) } else { flat };
        Self { log, ends: [low - room, high + room], page, words: Vec::new() }
    }

    /// Creates a scale from one value to another, without margin.
    pub fn between(low: f64, high: f64, log: bool, page: [f64; 2]) -> Self {
        let on = |v: f64| if log { v.log10() } else { v };
        Self { log, ends: [on(low), on(high)], page, words: Vec::new() }
    }

    /// Creates a row of words at 0, 1, 2 ...
    pub fn of_words(words: Vec<String>, page: [f64; 2]) -> Self {
        let last = words.len() as f64 - 0.5;
        Self { log: false, ends: [-0.5, last], page, words }
    }

    /// Returns the position of a value on the page, NaN if the scale cannot show it.
    pub fn at(&self, value: f64) -> f64 {
        let on_scale = if self.log { value.log10() } else { value };
        let s = (on_scale - self.ends[0]) / (self.ends[1] - self.ends[0]);
        let at = self.page[0] + s * (self.page[1] - self.page[0]);
        if at.is_finite() { at } else { f64::NAN }
    }

    /// Returns the value at a fraction of the scale.
    pub fn value(&self, fraction: f64) -> f64 {
        let on_scale = self.ends[0] + fraction * (self.ends[1] - self.ends[0]);
        if self.log { 10f64.powf(on_scale) } else { on_scale }
    }

    /// Returns true if a position on the page lies between the ends.
    pub fn holds(&self, place: f64) -> bool {
        let [a, b] = self.page;
        place >= a.min(b) - 1e-6 && place <= a.max(b) + 1e-6
    }

    /// Returns the ticks from end to end.
    pub fn ticks(&self) -> Vec<Tick> {
        if !self.words.is_empty() {
            let tick = |(i, w): (usize, &String)| Tick { value: i as f64, label: Some(w.clone()) };
            return self.words.iter().enumerate().map(tick).collect();
        }
        if !self.log {
            return linear_ticks(self.ends[0], self.ends[1]);
        }
        let inside = |v: f64| v >= self.ends[0] - 1e-9 && v <= self.ends[1] + 1e-9;
        let decades = self.ends[1] - self.ends[0];
        if decades < 0.3 {
            // Too few digits lie in so short a range.
            return linear_ticks(10f64.powf(self.ends[0]), 10f64.powf(self.ends[1]));
        }
        let labelled: &[u32] = match decades {
            d if d < 0.7 => &[1, 2, 3, 4, 5, 6, 7, 8, 9],
            d if d < 2.5 => &[1, 2, 5],
            _ => &[1],
        };
        let every = (decades / 8.0).ceil().max(1.0) as i32;
        let mut ticks = Vec::new();
        for power in self.ends[0].floor() as i32..=self.ends[1].ceil() as i32 {
            for digit in 1..=9u32 {
                let on_scale = f64::from(power) + f64::from(digit).log10();
                if inside(on_scale) {
                    let value = 10f64.powf(on_scale);
                    let said =
                        labelled.contains(&digit) && (labelled.len() > 1 || power % every == 0);
                    let text =
                        || if labelled.len() == 1 { power_of_ten(power) } else { short(value) };
                    ticks.push(Tick { value, label: said.then(text) });
                }
            }
        }
        ticks
    }
}

/// Returns ticks at equal distances from one value to another.
fn linear_ticks(low: f64, high: f64) -> Vec<Tick> {
    let step = nice_step((high - low) / 6.0);
    let first = (low / step - 1e-9).ceil() as i64;
    let last = (high / step + 1e-9).floor() as i64;
    let digits = (-step.log10().floor()).max(0.0) as usize;
    let tick = |i: i64| {
        let value = i as f64 * step;
        let label =
            if !(1e-4..1e5).contains(&step) { short(value) } else { format!("{value:.digits$}") };
        Tick { value, label: Some(label) }
    };
    (first..=last).map(tick).collect()
}

/// Returns 1, 2 or 5 times a power of ten, at least `step`.
fn nice_step(step: f64) -> f64 {
    let power = 10f64.powf(step.log10().floor());
    [1.0, 2.0, 5.0, 10.0]
        .into_iter()
        .map(|d| d * power)
        .find(|s| *s >= step * (1.0 - 1e-9))
        .unwrap_or(10.0 * power)
}

/// Formats a power of ten with a raised exponent.
fn power_of_ten(power: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        c => char::from_u32(0x2070 + c.to_digit(10).unwrap_or(0)).unwrap_or(c),
    };
    format!("10{}", power.to_string().chars().map(raised).collect::<String>())
}

/// Formats a number in a few characters.
pub fn short(value: f64) -> String {
    let size = value.abs();
    if size == 0.0 {
        "0".into()
    } else if (1e-3..1e5).contains(&size) {
        let digits = (2 - size.log10().floor() as i32).max(0) as usize;
        let text = format!("{value:.digits$}");
        if text.contains('.') {
            text.trim_end_matches('0').trim_end_matches('.').into()
        } else {
            text
        }
    } else {
        let text = format!("{value:.1e}"); // rounds 9.96e-5 up to 1.0e-4
        let (head, power) = text.split_once('e').unwrap_or((&text, "0"));
        let power = power.parse().unwrap_or(0);
        let head = head.trim_end_matches('0').trim_end_matches('.');
        if head == "1" { power_of_ten(power) } else { format!("{head}·{}", power_of_ten(power)) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(axis: &ChartAxis) -> Vec<String> {
        axis.ticks().into_iter().filter_map(|t| t.label).collect()
    }

    #[test]
    fn ticks_stand_at_round_numbers() {
        let page = [0.0, 100.0];
        assert_eq!(
            labels(&ChartAxis::between(0.0, 1.0, false, page)),
            ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]
        );
        assert_eq!(
            labels(&ChartAxis::between(1e-4, 1.0, true, page)),
            ["10⁻⁴", "10⁻³", "10⁻²", "10⁻¹", "10⁰"]
        );
        assert_eq!(labels(&ChartAxis::between(0.1, 1.0, true, page)), ["0.1", "0.2", "0.5", "1"]);
        assert_eq!(
            labels(&ChartAxis::between(21.5, 22.6, true, page)),
            ["21.6", "21.8", "22.0", "22.2", "22.4", "22.6"]
        );
        assert_eq!(labels(&ChartAxis::of_words(vec!["a".into(), "b".into()], page)), ["a", "b"]);
    }

    #[test]
    fn values_go_where_the_scale_says() {
        let axis = ChartAxis::between(0.01, 100.0, true, [200.0, 0.0]);
        assert_eq!(axis.at(1.0), 100.0);
        assert!(axis.at(0.0).is_nan() && axis.at(-1.0).is_nan());
        assert!(axis.holds(axis.at(100.0)) && !axis.holds(axis.at(1000.0)));
        assert!((axis.value(0.25) - 0.1).abs() < 1e-15);
    }

    #[test]
    fn numbers_are_short() {
        let small =
            [(1e-6, "10⁻⁶"), (2.5e-7, "2.5·10⁻⁷"), (9.96e-5, "10⁻⁴"), (-2.04e-8, "-2·10⁻⁸")];
        let cases = [(0.0, "0"), (0.05, "0.05"), (12.345, "12.3"), (1000.0, "1000")]
            .into_iter()
            .chain(small);
        for (value, text) in cases {
            assert_eq!(short(value), text);
        }
    }
}
