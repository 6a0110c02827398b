//! `*PARAMETER` and `*PARAMETER_EXPRESSION`: names of values, which fields use as `&name`. Decks
//! of Radioss have them in `/PARAMETER/GLOBAL`.

use super::diagnostics::Trouble;
use super::expression;
use super::fields::{CardFormat, expand};
use super::number;
use super::text::{KeywordBlock, Texts};
use crate::input::job::tree::Place;
use std::collections::BTreeMap;

/// Value of a parameter.
#[derive(Clone, Debug, PartialEq)]
pub enum Parameter {
    /// An integer.
    Integer(i64),
    /// A real number.
    Real(f64),
    /// Text.
    Text(String),
}

/// All parameters so far, with names in lower case.
#[derive(Debug, Default)]
pub struct DeckParameters {
    known: BTreeMap<String, Parameter>,
    /// Treatment of a second value of a name.
    duplicates: Duplicates,
    /// True while a block of local parameters is read, which hide others of the same name.
    local: bool,
    /// Keyword that defines parameters, if it is not `*PARAMETER`.
    card: Option<&'static str>,
}

/// Treatment of a second value of a parameter (`*PARAMETER_DUPLICATION`).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
enum Duplicates {
    /// The first value stays, with a warning.
    #[default]
    KeepFirst,
    /// The first value stays.
    KeepSilently,
    /// The second value is taken, with a warning.
    TakeLast,
    /// The second value is taken.
    TakeSilently,
    /// It is an error.
    Refuse,
}

/// Returns the name to which a field refers, and true if a minus precedes it.
pub fn reference(text: &str) -> Option<(bool, &str)> {
    match text.strip_prefix('&') {
        Some(name) => Some((false, name)),
        None => text.strip_prefix("-&").map(|name| (true, name)),
    }
}

impl DeckParameters {
    /// Creates the parameters of a deck in which other keywords define them, each once.
    pub fn of(card: &'static str) -> Self {
        Self { card: Some(card), duplicates: Duplicates::Refuse, ..Self::default() }
    }

    /// Adds a parameter.
    pub fn define(&mut self, name: &str, value: Parameter, place: Place, trouble: &mut Trouble) {
        self.set(name, value, place, trouble);
    }

    /// Returns the value of a name.
    pub fn get(&self, name: &str) -> Option<&Parameter> {
        self.known.get(&name.to_ascii_lowercase())
    }

    /// Returns the advice for an unknown name.
    pub fn nearest(&self, name: &str) -> String {
        let known: Vec<&str> = self.known.keys().map(String::as_str).collect();
        if let Some(card) = self.card {
            let near = crate::input::job::nearest(name, &known);
            return format!("define it with {card}; {near}");
        }
        match known.is_empty() {
            true => format!(
                "define it above this line: *PARAMETER, and a line `R {name}` with its value"
            ),
            false => format!(
                "define it above this line with *PARAMETER; {}",
                crate::input::job::nearest(name, &known)
            ),
        }
    }

    /// Reads the card of `*PARAMETER_DUPLICATION`: 1 and 5 keep the first value, 2 and 4 take the
    /// last one, 3 refuses a second one; 4 and 5 without a warning.
    pub fn read_duplication(&mut self, block: &KeywordBlock, texts: &Texts, trouble: &mut Trouble) {
        let Some(&span) = block.lines.first() else { return };
        let line = String::from_utf8_lossy(texts.line(block, span)).into_owned();
        let first = line.split(',').next().unwrap_or_default();
        let flag: String = first.chars().take(10).collect();
        self.duplicates = match (flag.trim(), number::integer(flag.trim().as_bytes())) {
            ("", _) | (_, Some(0 | 1)) => Duplicates::KeepFirst,
            (_, Some(2)) => Duplicates::TakeLast,
            (_, Some(3)) => Duplicates::Refuse,
            (_, Some(4)) => Duplicates::TakeSilently,
            (_, Some(5)) => Duplicates::KeepSilently,
            (flag, _) => {
                let message = format!("*PARAMETER_DUPLICATION: dflag is {flag}");
                let help = "give 1 or 5 (the first value holds), 2 or 4 (the last one), or 3 (an \
                            error)";
                return trouble.error(block.place(), message, help);
            }
        };
    }

    /// Reads a block of `*PARAMETER` (pairs of name and value) or `*PARAMETER_EXPRESSION` (a name
    /// and a formula per line).
    pub fn read(&mut self, block: &KeywordBlock, texts: &Texts, trouble: &mut Trouble) {
        let expressions = block.name.contains("EXPRESSION");
        self.local = block.name.ends_with("_LOCAL");
        let width = if block.format == CardFormat::Long { 20 } else { 10 };
        let mut formula: Option<(String, String, Place)> = None;
        for &span in &block.lines {
            let text = expand(&String::from_utf8_lossy(texts.line(block, span)));
            let place = block.span(span, 0, (span.1 - span.0) as usize);
            if text.trim().is_empty() {
                continue;
            }
            if !expressions {
                self.pairs(&text, width, place, trouble);
                continue;
            }
            let (name, rest) = head(&text, width);
            match &mut formula {
                Some(open) if name.trim().is_empty() => open.1 += rest.trim(),
                _ => {
                    let done =
                        formula.replace((name.trim().to_string(), rest.trim().to_string(), place));
                    self.formula(done, trouble);
                }
            }
        }
        self.formula(formula, trouble);
    }

    fn pairs(&mut self, text: &str, width: usize, place: Place, trouble: &mut Trouble) {
        let fields: Vec<&str> = match text.contains(',') {
            true => text.split(',').map(str::trim).collect(),
            false => match long_value(text, width) {
                Some(pair) => {
                    let message = {
                        let name = pair[0].split_whitespace().last().unwrap_or_default();
                        format!("the value of `{name}` has more columns than its field")
                    };
                    let help = format!(
                        "all of {} is read; give {width} columns, or commas between name and value",
                        pair[1]
                    );
                    trouble.warning(place, message, help);
                    pair.to_vec()
                }
                None => columns(text, width),
            },
        };
        for pair in fields.chunks(2) {
            let (name, value) = (pair[0], pair.get(1).copied().unwrap_or_default());
            if name.is_empty() && value.is_empty() {
                continue;
            }
            let Some((kind, name)) = declared(name, place, trouble) else { continue };
            let given = match (kind, reference(value)) {
                ('C', _) => Some(Parameter::Text(value.into())),
                (_, Some((minus, other))) => self.get(other).and_then(|p| match (kind, p) {
                    ('I', Parameter::Integer(i)) => {
                        Some(Parameter::Integer(if minus { -i } else { *i }))
                    }
                    ('R', Parameter::Integer(i)) => {
                        Some(Parameter::Real(if minus { -*i as f64 } else { *i as f64 }))
                    }
                    ('R', Parameter::Real(x)) => Some(Parameter::Real(if minus { -x } else { *x })),
                    _ => None,
                }),
                ('I', _) => number::integer(value.as_bytes()).map(Parameter::Integer),
                _ => number::real(value.as_bytes()).map(Parameter::Real),
            };
            match given {
                Some(given) => self.set(&name, given, place, trouble),
                None => {
                    let message = format!("the value of parameter `{name}` cannot be `{value}`");
                    trouble.error(
                        place,
                        message,
                        "give a number for R, a whole number for I, text for C; ten columns each, \
                         or with commas",
                    );
                    self.set(&name, Parameter::Integer(0), place, trouble);
                }
            }
        }
    }

    fn formula(&mut self, formula: Option<(String, String, Place)>, trouble: &mut Trouble) {
        let Some((name, text, place)) = formula else { return };
        let Some((kind, name)) = declared(&name, place, trouble) else { return };
        let value = match (kind, expression::evaluate(&text, &|n| self.get(n).cloned())) {
            ('C', _) => Parameter::Text(text),
            ('I', Ok(Parameter::Real(x))) if x.abs() < 9.0e15 => Parameter::Integer(x as i64),
            ('R', Ok(Parameter::Integer(i))) => Parameter::Real(i as f64),
            (_, Ok(value)) => value,
            (_, Err(why)) => {
                let help =
                    "write numbers, &names, + - * / ** and functions such as sqrt() and min()";
                trouble.error(place, format!("parameter `{name}`: {why}"), help);
                Parameter::Integer(0)
            }
        };
        self.set(&name, value, place, trouble);
    }

    fn set(&mut self, name: &str, value: Parameter, place: Place, trouble: &mut Trouble) {
        let name = name.to_ascii_lowercase();
        if !self.local && self.known.get(&name).is_some_and(|known| *known != value) {
            let message = format!("parameter `{name}` has two values");
            match self.duplicates {
                Duplicates::KeepFirst => {
                    let help = "the first one holds; *PARAMETER_DUPLICATION with 2 takes the last";
                    return trouble.warning(place, message, help);
                }
                Duplicates::KeepSilently => return,
                Duplicates::TakeSilently => {}
                Duplicates::TakeLast => {
                    trouble.warning(place, message, "the last one holds from here on");
                }
                Duplicates::Refuse => {
                    return trouble.error(place, message, "remove one of its definitions");
                }
            }
        }
        self.known.insert(name, value);
    }
}

/// Returns kind and name of `R name`.
fn declared(text: &str, place: Place, trouble: &mut Trouble) -> Option<(char, String)> {
    let mut letters = text.trim().chars();
    let kind = letters.next().unwrap_or(' ').to_ascii_uppercase();
    let name = letters.as_str().trim();
    let sound = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_');
    if !matches!(kind, 'R' | 'I' | 'C') || !sound {
        let help = "write R, I or C, then the name, such as `R dt`";
        trouble.error(place, format!("`{}` is not a parameter name", text.trim()), help);
        return None;
    }
    Some((kind, name.to_string()))
}

/// Returns the first columns, or the text before the first comma, and the rest.
fn head(text: &str, width: usize) -> (String, String) {
    match text.split_once(',') {
        Some((name, rest)) if name.len() <= width => (name.into(), rest.into()),
        _ => {
            let rest: String = text.chars().skip(width).collect();
            (text.chars().take(width).collect(), rest)
        }
    }
}

/// Returns the only name of a line and its value, if this is a number that goes on beyond its
/// columns.
fn long_value(text: &str, width: usize) -> Option<[&str; 2]> {
    let fields = columns(text, width);
    let [name, value, rest, ..] = fields[..] else { return None };
    let at = text.char_indices().nth(width)?.0;
    let whole = text[at..].trim();
    let is_number =
        !whole.contains(char::is_whitespace) && number::real(whole.as_bytes()).is_some();
    (!value.is_empty() && !rest.is_empty() && is_number).then_some([name, whole])
}

fn columns(text: &str, width: usize) -> Vec<&str> {
    let mut fields = Vec::new();
    let mut rest = text;
    while !rest.is_empty() {
        let cut = rest.char_indices().nth(width).map_or(rest.len(), |(at, _)| at);
        fields.push(rest[..cut].trim());
        rest = &rest[cut..];
    }
    fields
}
