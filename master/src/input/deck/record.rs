//! Cards read by the table: values with their places.

use super::diagnostics::Trouble;
use super::fields::{CardFormat, cut_number, split, words_of_broken_columns};
use super::keywords::KeywordRow;
use super::number;
use super::parameters::{DeckParameters, Parameter};
use super::submodel::{CurveUnits, Submodel};
use super::table::{Card, Field, FieldType, Times};
use super::text::{KeywordBlock, Texts};
use crate::input::job::tree::Place;
use std::cell::Cell;
use std::rc::Rc;

/// Content of a field.
#[derive(Clone, Debug, PartialEq)]
pub enum Given {
    /// No content.
    Blank,
    /// An integer.
    Integer(i64),
    /// A real number.
    Real(f64),
    /// Text.
    Word(String),
    /// Content that could not be read and has been reported.
    Wrong,
}

/// A field with its place.
#[derive(Clone, Debug)]
pub struct Value {
    /// Content.
    pub given: Given,
    /// Place.
    pub place: Place,
}

/// A line that was read. It records which of its fields the conversion asks for; copies share
/// their values and this record.
#[derive(Clone, Debug)]
pub struct CardLine {
    card: &'static Card,
    /// One value for each field of the card.
    values: Rc<[Value]>,
    /// One bit for each field that was asked for.
    asked: Rc<Cell<u32>>,
    /// The whole line.
    pub place: Place,
}

impl CardLine {
    /// Returns a field by its name; the first one of a list.
    pub fn value(&self, name: &str) -> Option<&Value> {
        let index = self.card.index(name)?;
        self.asked.set(self.asked.get() | 1 << index);
        self.values.get(index)
    }

    /// Returns the fields of its card.
    pub fn fields(&self) -> &'static [Field] {
        &self.card.fields
    }

    /// Returns its values, one for each field; none once copies of the line exist.
    pub fn values_mut(&mut self) -> &mut [Value] {
        Rc::get_mut(&mut self.values).unwrap_or_default()
    }

    /// Forgets which fields were asked for.
    pub fn forget_asked(&mut self) {
        self.asked.set(0);
    }

    /// Returns the number of fields that were asked for, without the ids in the keyword's line.
    pub fn asked(&self) -> u32 {
        if self.card.is_header() { 0 } else { self.asked.get().count_ones() }
    }

    /// Returns the fields with a value other than zero and the default, without headings and the
    /// ids in the keyword's line; true for those that were asked for.
    pub fn given(&self) -> impl Iterator<Item = (&'static Field, &Value, bool)> {
        let is_name = |field: &Field| {
            field.kind == FieldType::Line
                || field.width == 0
                || ["heading", "title"].contains(&field.name.as_str())
        };
        let fields = self.card.fields.iter().zip(self.values.iter()).enumerate();
        fields.filter(move |(_, (field, _))| !is_name(field)).filter_map(
            |(index, (field, value))| {
                let said = match &value.given {
                    Given::Blank | Given::Wrong => false,
                    Given::Integer(i) => *i != 0 && *i as f64 != field.default,
                    Given::Real(x) => *x != 0.0 && *x != field.default,
                    // The solver of a set, mechanical by default; flags that are all off.
                    Given::Word(word) => {
                        !word.eq_ignore_ascii_case("MECH")
                            && !word.bytes().all(|b| b == b'0' || b == b' ')
                    }
                };
                said.then_some((field, value, self.asked.get() & 1 << index != 0))
            },
        )
    }

    /// Returns the fields of a list with their values, and records that they were asked for.
    fn list(&self, name: &str) -> impl Iterator<Item = (&'static Field, &Value)> {
        let fields = || self.card.fields.iter().enumerate().filter(move |(_, f)| f.name == name);
        let bits = fields().fold(0, |bits, (index, _)| bits | 1 << index);
        self.asked.set(self.asked.get() | bits);
        let chosen = self.card.fields.iter().zip(self.values.iter()).enumerate();
        chosen.filter(move |(index, _)| bits & 1 << index != 0).map(|(_, pair)| pair)
    }

    /// Returns an integer; the default if it is blank.
    pub fn integer(&self, name: &str) -> i64 {
        match self.value(name).map(|v| &v.given) {
            Some(Given::Integer(i)) => *i,
            _ => self.default(name) as i64,
        }
    }

    /// Returns a number; the default if it is blank.
    pub fn real(&self, name: &str) -> f64 {
        match self.value(name).map(|v| &v.given) {
            Some(Given::Real(x)) => *x,
            Some(Given::Integer(i)) => *i as f64,
            _ => self.default(name),
        }
    }

    /// Returns a word, empty if it is blank.
    pub fn word(&self, name: &str) -> &str {
        match self.value(name).map(|v| &v.given) {
            Some(Given::Word(word)) => word,
            _ => "",
        }
    }

    /// Returns the place of a field; that of the line if it is blank.
    pub fn place(&self, name: &str) -> Place {
        let value = self.card.index(name).and_then(|index| self.values.get(index));
        value.map_or(self.place, |v| v.place)
    }

    /// Returns all integers of a list that are not blank or zero, with their places.
    pub fn integers(&self, name: &str) -> impl Iterator<Item = (i64, Place)> {
        self.list(name).filter_map(|(_, v)| match v.given {
            Given::Integer(i) if i != 0 => Some((i, v.place)),
            _ => None,
        })
    }

    /// Returns the integers of all fields of a list; 0 for blanks.
    pub fn all_integers(&self, name: &str) -> Vec<i64> {
        let number = |(_, value): (&'static Field, &Value)| match value.given {
            Given::Integer(i) => i,
            _ => 0,
        };
        self.list(name).map(number).collect()
    }

    /// Returns all numbers of a list, with the default for blanks.
    pub fn reals(&self, name: &str) -> Vec<f64> {
        let number = |(field, value): (&'static Field, &Value)| match value.given {
            Given::Real(x) => x,
            Given::Integer(i) => i as f64,
            _ => field.default,
        };
        self.list(name).map(number).collect()
    }

    /// Returns the places of all fields of a list.
    pub fn places(&self, name: &str) -> Vec<Place> {
        self.list(name).map(|(_, value)| value.place).collect()
    }

    /// Returns true if a field is blank.
    pub fn is_blank(&self, name: &str) -> bool {
        self.value(name).is_none_or(|v| v.given == Given::Blank)
    }

    fn default(&self, name: &str) -> f64 {
        self.card.index(name).map_or(0.0, |i| self.card.fields[i].default)
    }
}

/// The cards of one entity: a material, a section, a set.
#[derive(Clone, Debug)]
pub struct CardRecord {
    /// Its keyword's row.
    pub row: &'static KeywordRow,
    /// The keyword's name as written.
    pub written: String,
    /// Options in the keyword's name.
    pub options: Vec<&'static str>,
    /// The keyword's own line.
    pub head: Place,
    /// Number of its block in the order of the deck.
    pub block: usize,
    /// True if it is in a file that `*INCLUDE_TRANSFORM` changes.
    pub in_submodel: bool,
    /// Its lines.
    lines: Vec<CardLine>,
}

impl CardRecord {
    /// Returns true if the keyword's name has this option.
    pub fn has(&self, option: &str) -> bool {
        self.options.contains(&option)
    }

    /// Returns the keyword for messages.
    pub fn name(&self) -> String {
        self.row.keyword.shown()
    }

    /// Returns all its lines.
    pub fn all_lines(&self) -> &[CardLine] {
        &self.lines
    }

    /// Returns all its lines for changes.
    pub fn all_lines_mut(&mut self) -> &mut [CardLine] {
        &mut self.lines
    }

    /// Sets a number by the name of its field, if its card is there.
    pub fn put(&mut self, name: &str, x: f64) {
        for line in &mut self.lines {
            if let Some(index) = line.card.index(name) {
                // Copies of the line share its values.
                let mut own = line.values.to_vec();
                own.iter_mut().skip(index).take(1).for_each(|value| value.given = Given::Real(x));
                line.values = own.into();
                return;
            }
        }
    }

    /// Returns the first line with a field of this name.
    pub fn line(&self, name: &str) -> Option<&CardLine> {
        self.lines.iter().find(|l| l.card.index(name).is_some())
    }

    /// Returns the lines with a field of this name.
    pub fn lines<'r>(&'r self, name: &'r str) -> impl Iterator<Item = &'r CardLine> + 'r {
        self.lines.iter().filter(move |l| l.card.index(name).is_some())
    }

    /// Returns an integer by the name of its field; the default if it is blank.
    pub fn integer(&self, name: &str) -> i64 {
        self.line(name).map_or_else(|| self.default(name) as i64, |l| l.integer(name))
    }

    /// Returns a number by the name of its field; the default if it is blank.
    pub fn real(&self, name: &str) -> f64 {
        self.line(name).map_or_else(|| self.default(name), |l| l.real(name))
    }

    /// Returns a number by the name of its field; `default` if it is zero, blank or absent.
    pub fn real_or(&self, name: &str, default: f64) -> f64 {
        let given = self.real(name);
        if given == 0.0 { default } else { given }
    }

    /// Returns a word by the name of its field, empty if it is blank.
    pub fn word(&self, name: &str) -> &str {
        self.line(name).map_or("", |l| l.word(name))
    }

    /// Returns the place of a field.
    pub fn place(&self, name: &str) -> Place {
        self.line(name).map_or(self.head, |l| l.place(name))
    }

    /// Returns true if a field is blank or its card is absent.
    pub fn is_blank(&self, name: &str) -> bool {
        self.line(name).is_none_or(|l| l.is_blank(name))
    }

    fn default(&self, name: &str) -> f64 {
        let fields = self.row.cards.iter().flat_map(|c| &c.0.fields);
        fields.filter(|f| f.name == name).map(|f| f.default).next().unwrap_or(0.0)
    }
}

/// Context for reading cards.
pub struct Cards<'c> {
    /// The files.
    pub texts: &'c Texts,
    /// Parameters so far.
    pub parameters: &'c DeckParameters,
    /// Problems.
    pub trouble: &'c mut Trouble,
    /// Change of the file that is read, and the units of its curves.
    pub submodel: Option<(&'c Submodel, &'c mut CurveUnits)>,
}

impl<'c> Cards<'c> {
    /// Creates the context of files that are read as they are.
    pub fn of(texts: &'c Texts, parameters: &'c DeckParameters, trouble: &'c mut Trouble) -> Self {
        Self { texts, parameters, trouble, submodel: None }
    }
}

impl Cards<'_> {
    /// Reads all records of a block.
    pub fn records(
        &mut self,
        row: &'static KeywordRow,
        options: &[&'static str],
        block: &KeywordBlock,
    ) -> Vec<CardRecord> {
        let mut records = Vec::new();
        let mut at = 0;
        let filled =
            |from: usize| block.lines[from.min(block.lines.len())..].iter().any(|l| l.0 < l.1);
        while at == 0 || (row.keyword.repeats && filled(at)) {
            let before = at;
            let mut record = CardRecord {
                row,
                written: block.name.clone(),
                options: options.to_vec(),
                head: block.place(),
                block: block.number,
                in_submodel: false,
                lines: Vec::new(),
            };
            let mut whole = true;
            for (card, times) in &row.cards {
                let left = block.lines.len() - at;
                let count = match times {
                    Times::Once => 1,
                    Times::Maybe => left.min(1),
                    Times::Rest => left,
                    Times::Count(count) => count(&record),
                    Times::AtMost(count) => count(&record).min(left),
                };
                if count > left && whole {
                    let names: Vec<&str> = card.fields.iter().map(|f| f.name.as_str()).collect();
                    let message = format!(
                        "{} ends before its card {}: {}",
                        block.shown(),
                        record.lines.len() + 1 - usize::from(is_header(row)),
                        names.join(" ")
                    );
                    let place = block
                        .lines
                        .last()
                        .map_or(block.place(), |&l| block.span(l, 0, (l.1 - l.0) as usize));
                    self.trouble.error(place, message, missing_line(row));
                    self.trouble.unsure();
                    whole = false;
                }
                for _ in 0..count.min(left) {
                    let span = block.lines[at];
                    at += 1;
                    if matches!(times, Times::Rest) && span.0 == span.1 {
                        continue;
                    }
                    let heads = usize::from(is_header(row) && !record.lines.is_empty());
                    let number = record.lines.len() - heads;
                    record.lines.push(self.line(card, block, span, number));
                }
            }
            if whole {
                if let Some((submodel, curves)) = &mut self.submodel {
                    submodel.apply(&mut record, curves, self.trouble);
                }
                records.push(record);
            }
            if at == before {
                break;
            }
        }
        if !row.keyword.repeats && filled(at) {
            let span = block.lines[at..].iter().find(|l| l.0 < l.1).copied().unwrap_or(block.head);
            let message = format!(
                "{} has more lines than its {} cards: this one is not read",
                block.shown(),
                at - usize::from(is_header(row))
            );
            let place = block.span(span, 0, (span.1 - span.0) as usize);
            self.trouble.warning(place, message, "remove it, or check the keyword above it");
        }
        records
    }

    /// Reads one line.
    fn line(
        &mut self,
        card: &'static Card,
        block: &KeywordBlock,
        span: (u32, u32),
        number: usize,
    ) -> CardLine {
        let text = self.texts.line(block, span);
        let mut fields = split(text, card, block.format);
        if let Some(words) = words_of_broken_columns(text, card, block.format, &fields) {
            let message = format!(
                "{}: the numbers of card {} are not in their columns; the line is read word by \
                 word",
                block.shown(),
                number + 1
            );
            let help = format!("write numbers in their columns: {}", layout(card, block.format));
            self.trouble.warning(block.span(span, 0, text.len()), message, help);
            fields = words;
        } else if let Some((index, range)) = cut_number(text, card, block.format) {
            let shown = |part: &[u8]| String::from_utf8_lossy(part).into_owned();
            let message = format!(
                "{}: the border of the columns of `{}` and `{}` of card {} cuts {}: they are {} \
                 and {}",
                block.shown(),
                card.fields[index].name,
                card.fields[index + 1].name,
                number + 1,
                shown(&text[range.clone()]),
                shown(fields.text(text, index)),
                shown(fields.text(text, index + 1)),
            );
            let help = format!("write numbers in their columns: {}", layout(card, block.format));
            self.trouble.warning(block.span(span, range.start, range.end), message, help);
        }
        if fields.count() > card.fields.len() {
            let (from, to) = fields.span(card.fields.len());
            let message = format!(
                "{}: card {} has {} fields, not {}",
                block.shown(),
                number + 1,
                fields.count(),
                card.fields.len()
            );
            self.trouble.error(block.span(span, from, to), message, layout(card, block.format));
        }
        self.beyond(card, block, span, text);
        let (place, line) = (block.span(span, 0, text.len()), block.span(span, 0, text.len()));
        let mut values = Vec::with_capacity(card.fields.len());
        for (index, field) in card.fields.iter().enumerate() {
            let (from, to) = fields.span(index);
            let text = &text[from..to];
            let place = if from == to { place } else { block.span(span, from, to) };
            let given = self.given(field, text, place, (block, card, number, line));
            if given == Given::Blank && field.needed {
                let message =
                    format!("{}: `{}` of card {} is blank", block.shown(), field.name, number + 1);
                self.trouble.error(place, message, layout(card, block.format));
                self.trouble.unsure();
            }
            values.push(Value { given, place });
        }
        CardLine { card, values: values.into(), asked: Rc::default(), place }
    }

    /// Warns of text after the last column of a card that has columns only.
    fn beyond(&mut self, card: &Card, block: &KeywordBlock, span: (u32, u32), text: &[u8]) {
        let width: usize = card.fields.iter().map(|f| usize::from(f.width)).sum();
        let is_line = card.fields.iter().any(|f| f.kind == FieldType::Line);
        if block.format != CardFormat::Columns || is_line || card.is_header() {
            return;
        }
        let rest = text.get(width..).unwrap_or_default();
        if !rest.trim_ascii().is_empty() && !text.contains(&b'\t') {
            let place = block.span(span, width, text.len());
            let message = format!("{}: text after column {width} is not read", block.shown());
            let help = format!("check the columns: {}", layout(card, block.format));
            self.trouble.warning(place, message, help);
        }
    }

    fn given(
        &mut self,
        field: &Field,
        text: &[u8],
        place: Place,
        of: (&KeywordBlock, &Card, usize, Place),
    ) -> Given {
        if text.is_empty() {
            return Given::Blank;
        }
        let word = String::from_utf8_lossy(text);
        if field.kind == FieldType::Line {
            return Given::Word(word.into_owned());
        }
        let (block, card, number, line) = of;
        if let Some((minus, name)) = super::parameters::reference(&word) {
            return match self.parameters.get(name) {
                Some(parameter) => match (field.kind, parameter.clone()) {
                    (FieldType::Word, Parameter::Text(text)) => Given::Word(text),
                    (FieldType::Integer, Parameter::Integer(i)) => {
                        Given::Integer(if minus { -i } else { i })
                    }
                    (FieldType::Integer, Parameter::Real(x))
                        if x.fract() == 0.0 && x.abs() < 9.0e15 =>
                    {
                        Given::Integer(if minus { -x as i64 } else { x as i64 })
                    }
                    (FieldType::Real, Parameter::Integer(i)) => {
                        Given::Real(if minus { -(i as f64) } else { i as f64 })
                    }
                    (FieldType::Real, Parameter::Real(x)) => {
                        Given::Real(if minus { -x } else { x })
                    }
                    _ => {
                        let message = format!(
                            "{}: parameter `{name}` has the wrong type for `{}`",
                            block.shown(),
                            field.name
                        );
                        let help = format!("it has to be {}", wanted(field.kind));
                        self.trouble.misread(line, None, place, message, help);
                        Given::Wrong
                    }
                },
                None => {
                    let help = self.parameters.nearest(name);
                    let message = format!("there is no parameter `{name}` yet");
                    self.trouble.misread(line, Some(&message), place, message.clone(), help);
                    Given::Wrong
                }
            };
        }
        let given = match field.kind {
            FieldType::Integer => number::integer(text).map(Given::Integer),
            FieldType::Real => number::real(text).map(Given::Real),
            FieldType::Word | FieldType::Line => Some(Given::Word(word.to_string())),
        };
        given.unwrap_or_else(|| {
            let what = match word.split_whitespace().count() {
                0 | 1 => format!("not `{word}`"),
                n => format!("not `{word}`, which has {n} words: check the columns"),
            };
            let message = format!(
                "{}: `{}` has to be {}, {what}",
                block.shown(),
                field.name,
                wanted(field.kind)
            );
            let help = format!("card {}: {}", number + 1, layout(card, block.format));
            self.trouble.misread(line, None, place, message, help);
            Given::Wrong
        })
    }
}

/// Returns true if the first card of a keyword is in the keyword's own line.
fn is_header(row: &KeywordRow) -> bool {
    row.cards.first().is_some_and(|(card, _)| card.is_header())
}

/// Returns the remedy for a record that ends too early.
fn missing_line(row: &KeywordRow) -> &'static str {
    let headed = row.cards.first().is_some_and(|(card, times)| {
        matches!(times, Times::Once) && card.fields.iter().all(|f| f.kind == FieldType::Line)
    });
    match headed {
        true => "add the line; the first line is a heading, which is required even if blank",
        false => "add the line; a blank line means the defaults",
    }
}

fn wanted(kind: FieldType) -> &'static str {
    match kind {
        FieldType::Integer => "a whole number",
        FieldType::Real => "a number",
        FieldType::Word | FieldType::Line => "text",
    }
}

/// Returns the fields of a card for a message.
pub fn layout(card: &Card, format: CardFormat) -> String {
    let mut names: Vec<&str> = card.fields.iter().map(|f| f.name.as_str()).collect();
    names.dedup();
    let width = |f: &Field| if format == CardFormat::Long { 20 } else { f.width };
    let widths: Vec<u16> = card.fields.iter().map(width).collect();
    let even = widths.windows(2).all(|w| w[0] == w[1]);
    if format == CardFormat::Words || card.is_header() {
        let separator = if card.is_header() { "slashes" } else { "blanks" };
        return format!("the fields are {}, with {separator} between them", names.join(" "));
    }
    let columns = match (even, widths.first()) {
        (true, Some(width)) => format!("{width} columns each"),
        _ => format!(
            "columns of {}",
            widths.iter().map(u16::to_string).collect::<Vec<_>>().join(", ")
        ),
    };
    if format == CardFormat::Columns {
        return format!("the fields are {}, {columns}", names.join(" "));
    }
    let ids =
        if widths.first() == Some(&8) { "; longer ids need *KEYWORD I10=Y, or commas" } else { "" };
    format!("the fields are {}, {columns} or with commas between them{ids}", names.join(" "))
}
