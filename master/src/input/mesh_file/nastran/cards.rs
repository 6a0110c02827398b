//! Cards of Nastran bulk data in the three formats: fields of 8 or 16 columns, or with commas.

use crate::input::deck::number;
use crate::input::mesh_file::content::FilePlace;
use crate::input::mesh_file::reading::MeshReading;

/// A card: its name, and its fields after the name.
pub struct BulkCard {
    /// Name in capitals, without the asterisk of wide fields.
    pub name: String,
    /// Fields of all its lines, eight for each pair of a wide or each other line.
    pub fields: Vec<String>,
    /// Its place.
    pub place: FilePlace,
}

/// A field that cannot be read: its number, from 2 as in Nastran, and its text.
pub struct FieldFault {
    pub number: usize,
    pub text: String,
}

impl BulkCard {
    /// Returns the text of a field; the first one after the name has the index 0.
    pub fn text(&self, index: usize) -> &str {
        self.fields.get(index).map_or("", String::as_str)
    }

    /// Returns a whole number from 0; `None` if the field is blank.
    ///
    /// # Errors
    /// The field is no such number.
    pub fn id(&self, index: usize) -> Result<Option<u64>, FieldFault> {
        match self.text(index) {
            "" => Ok(None),
            text => match number::integer(text.as_bytes()).and_then(|n| u64::try_from(n).ok()) {
                Some(id) => Ok(Some(id)),
                None => Err(self.fault(index)),
            },
        }
    }

    /// Returns a number; `None` if the field is blank.
    ///
    /// # Errors
    /// The field is no number.
    pub fn real(&self, index: usize) -> Result<Option<f64>, FieldFault> {
        match self.text(index) {
            "" => Ok(None),
            text => match number::real(text.as_bytes()) {
                Some(number) => Ok(Some(number)),
                None => Err(self.fault(index)),
            },
        }
    }

    fn fault(&self, index: usize) -> FieldFault {
        FieldFault { number: index + 2, text: self.text(index).to_string() }
    }
}

/// Returns the content of a file and of those that it includes.
pub fn cards(reading: &mut MeshReading, bytes: &[u8]) -> BulkText {
    let mut found = BulkText::default();
    found.add_file(reading, bytes, 0);
    found
}

/// Cards, case control and names of a file and of those that it includes.
#[derive(Default)]
pub struct BulkText {
    /// Cards of the bulk data.
    pub cards: Vec<BulkCard>,
    /// Lines of the case control.
    pub control: Vec<(String, FilePlace)>,
    /// Names in comments of pre-processors.
    pub names: Vec<NamedId>,
    ended: bool,
}

/// Something that a comment of a pre-processor names.
#[derive(Debug, PartialEq, Eq)]
pub struct NamedId {
    /// The kind of thing.
    pub of: NamedKind,
    /// Its id.
    pub id: u64,
    /// Its name.
    pub name: String,
}

/// Kind of thing that a comment of a pre-processor names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NamedKind {
    /// A property.
    Property,
    /// A component of HyperMesh, with the id of its property; its own id without one.
    Component,
    /// A set.
    Set(SetKind),
}

/// Kind of the ids of a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SetKind {
    /// Nodes.
    Nodes,
    /// Elements.
    Elements,
    /// Properties.
    Properties,
}

impl BulkText {
    fn add_file(&mut self, reading: &mut MeshReading, bytes: &[u8], file: u32) {
        let text = String::from_utf8_lossy(bytes).into_owned();
        let is_begin = |line: &str| {
            let words: Vec<String> =
                line.split_whitespace().take(2).map(str::to_uppercase).collect();
            words == ["BEGIN", "BULK"] || words.first().is_some_and(|w| w.starts_with("BEGIN,"))
        };
        let begin = text.lines().position(is_begin);
        for (index, line) in text.lines().enumerate() {
            let place = FilePlace { file, line: index as u32 + 1 };
            if self.ended {
                return;
            }
            if line.starts_with('$') {
                self.names.extend(name_in_comment(line));
                continue;
            }
            let line = line.split('$').next().unwrap_or_default().trim_end();
            match begin {
                _ if line.trim().is_empty() => {}
                Some(begin) if index < begin => self.control.push((line.to_string(), place)),
                Some(begin) if index == begin => {}
                _ => self.add_line(reading, line, place),
            }
        }
    }

    fn add_line(&mut self, reading: &mut MeshReading, line: &str, place: FilePlace) {
        let upper = line.trim().to_uppercase();
        if upper.starts_with("ENDDATA") {
            self.ended = true;
            return;
        }
        if upper.starts_with("INCLUDE") {
            let name = line.trim()["INCLUDE".len()..].trim();
            let name = name.trim_matches(|c| c == '\'' || c == '"');
            if let Some((file, bytes)) = reading.include(name, place) {
                self.add_file(reading, &bytes, file);
            }
            return;
        }
        let (head, fields) = split(line);
        let name = head.trim().trim_end_matches('*').to_uppercase();
        let continues = name.is_empty() || head.trim_start().starts_with(['+', '*']);
        if !continues {
            self.cards.push(BulkCard { name, fields, place });
            return;
        }
        match self.cards.last_mut() {
            Some(card) => card.fields.extend(fields),
            None => {
                let message = "the line continues a card, and there is none before it";
                let help = "begin with a card, such as GRID; the file may be cut";
                reading.error("continuation", place, message, help);
            }
        }
    }
}

/// Returns name and fields of a line: always eight, or four for wide fields.
fn split(line: &str) -> (String, Vec<String>) {
    let line = without_tabs(line);
    if line.contains(',') {
        let mut words = line.split(',').map(|word| word.trim().to_string());
        let head = words.next().unwrap_or_default();
        let count = if head.contains('*') { 4 } else { 8 };
        let mut fields: Vec<String> = words.take(count).collect();
        // A mark of continuation stands in the ninth field, or is the last one.
        if fields.last().is_some_and(|last| {
            last.starts_with('+') && last.len() > 1 && number::real(last.as_bytes()).is_none()
        }) {
            fields.pop();
        }
        fields.resize(count, String::new());
        return (head, fields);
    }
    let columns: Vec<char> = line.chars().collect();
    let cut = |from: usize, width: usize| -> String {
        let piece = columns.iter().skip(from).take(width).collect::<String>();
        piece.trim().to_string()
    };
    let head = cut(0, 8);
    let (count, width) = if head.contains('*') { (4, 16) } else { (8, 8) };
    (head, (0..count).map(|i| cut(8 + i * width, width)).collect())
}

/// Returns a line with blanks up to the next multiple of 8 columns instead of each tab.
fn without_tabs(line: &str) -> String {
    let mut found = String::new();
    let mut column = 0;
    for character in line.chars() {
        let width = if character == '\t' { 8 - column % 8 } else { 1 };
        match character {
            '\t' => found.extend(std::iter::repeat_n(' ', width)),
            _ => found.push(character),
        }
        column += width;
    }
    found
}

/// Returns what a comment of HyperMesh or Femap names.
fn name_in_comment(line: &str) -> Option<NamedId> {
    let named = |of: NamedKind, id: &str, name: &str| {
        Some(NamedId { of, id: id.trim().parse().ok()?, name: name.trim().to_string() })
    };
    if let Some(rest) = line.strip_prefix("$HMNAME PROP") {
        let (id, name) = rest.split_once('"')?;
        return named(NamedKind::Property, id, name.split('"').next()?);
    }
    if let Some(rest) = line.strip_prefix("$HMNAME COMP") {
        let mut pieces = rest.split('"');
        let (own, name) = (pieces.next()?, pieces.next()?);
        let of_property = pieces.next().map(str::trim).filter(|id| !id.is_empty());
        return named(NamedKind::Component, of_property.unwrap_or(own), name);
    }
    if let Some(rest) = line.strip_prefix("$HMSET ") {
        let (numbers, name) = rest.split_once('"')?;
        let (id, kind) = numbers.trim().split_once(' ')?;
        let of = match kind.trim() {
            "1" => NamedKind::Set(SetKind::Nodes),
            "2" => NamedKind::Set(SetKind::Elements),
            _ => return None,
        };
        return named(of, id, name.split('"').next()?);
    }
    let rest = line.strip_prefix("$ Femap")?.split("Property ").nth(1)?;
    let (id, name) = rest.split_once(':')?;
    named(NamedKind::Property, id, name)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_of_all_formats_are_split_into_fields() {
        let small = split("GRID           5        -.707107.70710680.0     ");
        let free = split("GRID,5,,-.707107,.7071068,0.0");
        let wide =
            split("GRID*                  5                        -.707107        .7071068*");
        assert_eq!(small.1[..5], ["5", "", "-.707107", ".7071068", "0.0"]);
        assert_eq!(small.1[..5], free.1[..5]);
        assert_eq!(wide.1, ["5", "", "-.707107", ".7071068"]);
        assert_eq!(split("+       1       2").1[..2], ["1", "2"]);
    }

    /// A tab ends a field of 8 columns, whatever the length of the text before it.
    #[test]
    fn a_tab_goes_to_the_next_field() {
        let (head, fields) = split("GRID\t5\t\t-.707107\t12345678.0");
        assert_eq!(head, "GRID");
        // The text of 8 columns fills its field, so that the tab after it skips one.
        assert_eq!(fields[..6], ["5", "", "-.707107", "", "12345678", ".0"]);
        let (_, fields) = split("GRID\t5\t\t1.5\t2.5\t3.5");
        assert_eq!(fields[..5], ["5", "", "1.5", "2.5", "3.5"]);
    }

    #[test]
    fn comments_name_properties_and_sets() {
        for (line, of, id, name) in [
            ("$HMNAME PROP                   3\"rail\" 4", NamedKind::Property, 3, "rail"),
            ("$HMNAME COMP                   1\"a b\" ", NamedKind::Component, 1, "a b"),
            ("$HMNAME COMP  1\"a\" 7 \"plate\" 4", NamedKind::Component, 7, "a"),
            ("$ Femap with NX Nastran Property 2 : plate", NamedKind::Property, 2, "plate"),
            ("$HMSET        5        1 \"rim\" 18", NamedKind::Set(SetKind::Nodes), 5, "rim"),
            ("$HMSET        6        2 \"skin\" 18", NamedKind::Set(SetKind::Elements), 6, "skin"),
        ] {
            let wanted = NamedId { of, id, name: name.into() };
            assert_eq!(name_in_comment(line), Some(wanted), "{line}");
        }
        for line in [
            "$HMNAME MAT 1\"a\"",
            "$HMNAME COMP 1",
            "$HMSET 5 4 \"a\"",
            "$HMSETTYPE 5 \"regular\" 18",
        ] {
            assert_eq!(name_in_comment(line), None, "{line}");
        }
    }
}
