//! Types of the table of keywords: a keyword, its cards, their fields.
//!
//! A card is written as `name:kind width!=default` for each field, such as `nid:i8 x:r16 y:r16
//! sf:r=1`. The kind is `i` for an integer, `r` for a real number, `a` for a word, `l` for the
//! whole line. The default width is ten columns; a width of 0 is for the ids in the line of a
//! keyword of Radioss, which slashes separate; `!` marks a field that may not be blank. A
//! repeated field (`n:i*8`) is a list.

use super::record::CardRecord;

/// Type of a field.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldType {
    /// An integer.
    Integer,
    /// A real number.
    Real,
    /// A word.
    Word,
    /// The whole line.
    Line,
}

/// A field of a card.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name as in manuals of the format, in lower case.
    pub name: String,
    /// Its type.
    pub kind: FieldType,
    /// Columns in the standard format.
    pub width: u16,
    /// Value of a blank.
    pub default: f64,
    /// True if it may not be blank.
    pub needed: bool,
}

/// The fields of one line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Card {
    /// In the order of the line.
    pub fields: Vec<Field>,
}

impl Card {
    /// Parses a card of the table.
    ///
    /// # Panics
    /// Panics if it is invalid: an error in the table, which the tests parse completely.
    pub fn parse(text: &str) -> Self {
        let mut fields = Vec::new();
        for word in text.split_whitespace() {
            let (name, rest) = word.split_once(':').expect("name:kind");
            let (rest, times) = match rest.split_once('*') {
                Some((rest, times)) => (rest, times.parse().expect("a count")),
                None => (rest, 1),
            };
            let (rest, default) = match rest.split_once('=') {
                Some((rest, default)) => (rest, default.parse().expect("a default")),
                None => (rest, 0.0),
            };
            let needed = rest.ends_with('!');
            let rest = rest.trim_end_matches('!');
            let (kind, width) = rest.split_at(1);
            let kind = match kind {
                "i" => FieldType::Integer,
                "r" => FieldType::Real,
                "a" => FieldType::Word,
                "l" => FieldType::Line,
                _ => panic!("unknown kind of field: {word}"),
            };
            let width = if width.is_empty() { 10 } else { width.parse().expect("a width") };
            fields.extend((0..times).map(|_| Field {
                name: name.into(),
                kind,
                width,
                default,
                needed,
            }));
        }
        Card { fields }
    }

    /// Returns true for the ids in the line of a keyword.
    pub fn is_header(&self) -> bool {
        self.fields.first().is_some_and(|f| f.width == 0)
    }

    /// Returns the index of a field in the card.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|f| f.name == name)
    }
}

/// Number of times that a card appears in a record.
#[derive(Clone, Copy)]
pub enum Times {
    /// Once.
    Once,
    /// Once, unless the keyword ends before it: then all its fields are blank.
    Maybe,
    /// As often as the function says, unless the keyword ends before it: then all its fields are
    /// blank.
    AtMost(fn(&CardRecord) -> usize),
    /// For all remaining lines.
    Rest,
    /// As a function of the cards before it and the options in the keyword's name.
    Count(fn(&CardRecord) -> usize),
}

/// Effect of a keyword in Crumple.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// It is part of the model.
    Model,
    /// It has no effect here; a warning states that it is not read.
    Harmless,
    /// Its cards are read, but the engine does not support it yet: an error unless it is allowed.
    NotYet,
}

/// Fate of a value in a field that no code converts.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FieldFate {
    /// It has no effect in this engine: a line of the mapping.
    NoEffect,
    /// It is ignored, and results may differ from those of other programs: a warning.
    Ignored,
    /// It would change the result: an error unless unsupported content is allowed.
    Refused,
}

/// Fields of a keyword that no code converts. Blanks, zeros and defaults of these fields are not
/// reported.
#[derive(Clone, Copy, Debug)]
pub struct UnusedFields {
    /// Their names, with blanks between them.
    pub names: &'static str,
    /// Fate of their values.
    pub fate: FieldFate,
    /// Its meaning for the user.
    pub why: &'static str,
}

/// Creates fields without an effect.
pub const fn no_effect(names: &'static str, why: &'static str) -> UnusedFields {
    UnusedFields { names, fate: FieldFate::NoEffect, why }
}

/// Creates fields that are ignored with a warning.
pub const fn ignored(names: &'static str, why: &'static str) -> UnusedFields {
    UnusedFields { names, fate: FieldFate::Ignored, why }
}

/// Creates fields that are not supported.
pub const fn refused(names: &'static str, why: &'static str) -> UnusedFields {
    UnusedFields { names, fate: FieldFate::Refused, why }
}

/// A row of the table.
pub struct Keyword {
    /// Name: without asterisk and options, or with the slashes of Radioss and without ids.
    pub name: &'static str,
    /// Other names of the keyword.
    pub aliases: &'static [&'static str],
    /// Options after the name, in any order.
    pub options: &'static [&'static str],
    /// Its effect.
    pub effect: Effect,
    /// Cards of a record, in order.
    pub cards: &'static [(&'static str, Times)],
    /// True if records follow each other until the next keyword.
    pub repeats: bool,
    /// Fields that no code converts.
    pub unused: &'static [UnusedFields],
    /// Description of the conversion for users.
    pub note: &'static str,
}

impl Keyword {
    /// Creates a keyword with one record and no options.
    pub const fn new(
        name: &'static str,
        cards: &'static [(&'static str, Times)],
        note: &'static str,
    ) -> Self {
        Self {
            name,
            aliases: &[],
            options: &[],
            effect: Effect::Model,
            cards,
            repeats: false,
            unused: &[],
            note,
        }
    }

    /// Returns the name for messages, with the sign that begins a keyword.
    pub fn shown(&self) -> String {
        if self.name.starts_with('/') { self.name.into() } else { format!("*{}", self.name) }
    }

    /// Returns the keyword with other names.
    pub const fn aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }

    /// Returns the keyword with options.
    pub const fn options(mut self, options: &'static [&'static str]) -> Self {
        self.options = options;
        self
    }

    /// Returns the keyword with records until the next keyword.
    pub const fn repeats(mut self) -> Self {
        self.repeats = true;
        self
    }

    /// Returns the keyword with fields that no code converts.
    pub const fn unused(mut self, unused: &'static [UnusedFields]) -> Self {
        self.unused = unused;
        self
    }

    /// Returns the keyword with another effect.
    pub const fn effect(mut self, effect: Effect) -> Self {
        self.effect = effect;
        self
    }
}
