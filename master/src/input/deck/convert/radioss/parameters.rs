//! Reads `/PARAMETER/GLOBAL` of Radioss: names of values, which fields use as `&name`.

use super::StarterConverter;
use crate::input::deck::expression;
use crate::input::deck::parameters::Parameter;
use crate::input::deck::radioss::keywords;
use crate::input::deck::record::{CardRecord, Cards};
use crate::input::deck::text::Texts;

/// Begin of the names of these keywords.
pub const PARAMETER: &str = "/PARAMETER/GLOBAL/";

impl StarterConverter {
    /// Reads all parameters before other cards, since a deck may define them after their use.
    pub(super) fn read_parameters(&mut self, texts: &Texts, is_left_out: &dyn Fn(&str) -> bool) {
        let blocks = texts.blocks.iter().filter(|block| block.name.starts_with(PARAMETER));
        for block in blocks.filter(|block| !is_left_out(&block.name)) {
            let Some(row) = keywords::find(&block.name) else { continue };
            let mut cards = Cards::of(texts, &self.parameters, &mut self.deck.trouble);
            for record in cards.records(row, &[], block) {
                let name = record.word("name").to_string();
                if let Some(value) = self.value(&name, &record) {
                    let (place, trouble) = (record.place("name"), &mut self.deck.trouble);
                    self.parameters.define(&name, value, place, trouble);
                }
                self.deck.read.push(record);
            }
        }
    }

    /// Returns the value of a parameter, or reports why it has none.
    fn value(&mut self, name: &str, record: &CardRecord) -> Option<Parameter> {
        let card = record.name();
        let error = match (card.as_str(), name) {
            (_, "") => format!("{card}: a parameter has no name"),
            (_, name) if !name.chars().all(|c| c.is_alphanumeric() || c == '_') => {
                format!("{card}: `{name}` is not a parameter name")
            }
            ("/PARAMETER/GLOBAL/REAL", _) => return Some(Parameter::Real(record.real("value"))),
            ("/PARAMETER/GLOBAL/INTEGER", _) => {
                return Some(Parameter::Integer(record.integer("value")));
            }
            _ => {
                let known = |name: &str| self.parameters.get(name).cloned();
                match (card.as_str(), expression::evaluate(record.word("expression"), &known)) {
                    ("/PARAMETER/GLOBAL/INT_EXPR", Ok(Parameter::Real(x))) if x.abs() < 9.0e15 => {
                        return Some(Parameter::Integer(x as i64));
                    }
                    ("/PARAMETER/GLOBAL/REAL_EXPR", Ok(Parameter::Integer(i))) => {
                        return Some(Parameter::Real(i as f64));
                    }
                    (_, Ok(value)) => return Some(value),
                    (_, Err(why)) => format!("{card}: parameter `{name}`: {why}"),
                }
            }
        };
        let help = "write its name of letters and digits in ten columns, then its value, or a \
                    formula of numbers and of names that are defined above";
        self.deck.trouble.error(record.place("name"), error, help);
        None
    }
}
