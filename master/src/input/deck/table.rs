//! What the table of keywords is made of: a keyword, its cards, their fields.
//!
//! A card is written as `name:kind width!=default` for each field, such as `nid:i8 x:r16 y:r16
//! sf:r=1`: kind `i` a whole number, `r` a number, `a` a word, `l` the whole line; ten columns if
//! no width is given; `!` if it may not be blank. A name that stands twice in a card (`n:i*8`) is a
//! list.

use super::record::Record;

/// What a field holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// A whole number.
    Integer,
    /// A number.
    Real,
    /// A word.
    Word,
    /// The whole line.
    Line,
}

/// A field of a card.
#[derive(Clone, Debug, PartialEq)]
pub struct Field {
    /// Name, as manuals of the format call it, in lower case.
    pub name: String,
    /// What it holds.
    pub kind: Kind,
    /// Columns in the standard format.
    pub width: u16,
    /// What a blank stands for.
    pub default: f64,
    /// Whether it may not be blank.
    pub needed: bool,
}

/// The fields of one line.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Card {
    /// In the order of the line.
    pub fields: Vec<Field>,
}

impl Card {
    /// Reads a card as the table writes it.
    ///
    /// # Panics
    /// When it is written wrongly: a mistake in the table, which the tests read as a whole.
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
                "i" => Kind::Integer,
                "r" => Kind::Real,
                "a" => Kind::Word,
                "l" => Kind::Line,
                _ => panic!("no kind of field: {word}"),
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

    /// Place of a field in the card.
    pub fn index(&self, name: &str) -> Option<usize> {
        self.fields.iter().position(|f| f.name == name)
    }
}

/// How often a card stands in a record.
#[derive(Clone, Copy)]
pub enum Times {
    /// Once.
    Once,
    /// Once, unless the keyword ends before it: then all its fields are blank.
    Maybe,
    /// As often as there are lines left.
    Rest,
    /// So often, by the cards before it and the options in the keyword's name.
    Count(fn(&Record) -> usize),
}

/// What a keyword is to Crumple.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Effect {
    /// It is part of the model.
    Model,
    /// It changes nothing that matters here: a warning says that it is not read.
    Harmless,
    /// Its cards are read, but the engine cannot do it yet: an error unless it is allowed.
    NotYet,
}

/// A row of the table.
pub struct Keyword {
    /// Name without asterisk and options.
    pub name: &'static str,
    /// Other names of the same.
    pub aliases: &'static [&'static str],
    /// What may follow the name, in any order.
    pub options: &'static [&'static str],
    /// What it is to Crumple.
    pub effect: Effect,
    /// Cards of a record, in order.
    pub cards: &'static [(&'static str, Times)],
    /// Whether records follow each other until the next keyword.
    pub repeats: bool,
    /// What becomes of it, for people.
    pub note: &'static str,
}

impl Keyword {
    /// A keyword with one record and no options.
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
            note,
        }
    }

    /// The same with other names.
    pub const fn aliases(mut self, aliases: &'static [&'static str]) -> Self {
        self.aliases = aliases;
        self
    }

    /// The same with options.
    pub const fn options(mut self, options: &'static [&'static str]) -> Self {
        self.options = options;
        self
    }

    /// The same with records until the next keyword.
    pub const fn repeats(mut self) -> Self {
        self.repeats = true;
        self
    }

    /// The same with another effect.
    pub const fn effect(mut self, effect: Effect) -> Self {
        self.effect = effect;
        self
    }
}
