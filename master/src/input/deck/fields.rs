//! Splits a card into its fields: by columns, by commas, or by blanks if tabs have shifted the
//! columns.

use super::number;
use super::table::{Card, FieldType};
use std::ops::Range;

/// Maximum number of fields of a card; the largest has sixteen of five columns.
pub const MOST: usize = 20;
/// Distance of tab stops [columns].
const TAB: usize = 8;
/// Columns of a field in the long format.
const LONG: usize = 20;

/// Width of the fields of a card.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum CardFormat {
    /// As in the keyword's table.
    Standard,
    /// Eight columns become ten.
    I10,
    /// All fields have twenty columns.
    Long,
    /// As in the keyword's table, by columns only: a comma is no separator.
    Columns,
    /// Words with blanks or commas between them.
    Words,
}

impl CardFormat {
    fn width(self, standard: u16) -> usize {
        match self {
            // A heading after an id extends to the end of the line.
            CardFormat::Long => LONG.max(usize::from(standard)),
            CardFormat::I10 if standard == 8 => 10,
            _ => usize::from(standard),
        }
    }
}

/// The fields of a card, as bytes of its line, without surrounding blanks.
#[derive(Clone, Copy, Debug)]
pub struct Fields {
    count: usize,
    spans: [(u32, u32); MOST],
}

impl Fields {
    /// Returns the number of fields of the card, without blank ones at its end.
    pub fn count(&self) -> usize {
        self.count
    }

    /// Returns the first byte of field `index` and one past its last; equal if it is blank.
    pub fn span(&self, index: usize) -> (usize, usize) {
        let (start, end) = self.spans.get(index).copied().unwrap_or_default();
        (start as usize, end as usize)
    }

    /// Returns the text of field `index`, empty if it is blank.
    pub fn text<'l>(&self, line: &'l [u8], index: usize) -> &'l [u8] {
        let (start, end) = self.span(index);
        line.get(start..end).unwrap_or_default()
    }

    fn push(&mut self, line: &[u8], from: usize, to: usize) {
        if self.count == MOST {
            return;
        }
        let to = to.min(line.len());
        let mut start = from.min(to);
        let mut end = to;
        while start < end && line[start].is_ascii_whitespace() {
            start += 1;
        }
        while end > start && line[end - 1].is_ascii_whitespace() {
            end -= 1;
        }
        self.spans[self.count] = (start as u32, end as u32);
        self.count += 1;
    }

    fn drop_blanks(mut self) -> Self {
        while self.count > 0 && self.spans[self.count - 1].0 == self.spans[self.count - 1].1 {
            self.count -= 1;
        }
        self
    }
}

/// Splits a line into the fields of a card.
pub fn split(line: &[u8], card: &Card, format: CardFormat) -> Fields {
    let mut fields = Fields { count: 0, spans: [(0, 0); MOST] };
    if card.fields.first().is_some_and(|f| f.kind == FieldType::Line) {
        fields.push(line, 0, line.len());
        return fields.drop_blanks();
    }
    if card.is_header() {
        return parts(line, |b| b == b'/', fields);
    }
    if format == CardFormat::Words {
        return words(line, fields);
    }
    if format != CardFormat::Columns && line.contains(&b',') {
        return parts(line, |b| b == b',', fields);
    }
    if line.contains(&b'\t') {
        return tabbed(line, card, format, fields);
    }
    let mut from = 0;
    for field in &card.fields {
        if from >= line.len() {
            break;
        }
        let width = format.width(field.width);
        fields.push(line, from, from + width);
        from += width;
    }
    fields.drop_blanks()
}

/// Largest shift of a line for which its columns are found again.
const SHIFT: usize = 3;

/// Returns the words of a line as the fields of a card whose columns they do not fit: a field of a
/// number has something else in its columns, such as two words or a part of a number, or a border
/// cuts a number. Words are fields if there is one for each field, if all columns are some columns
/// farther right, or if each word has most of its columns in the next field. Otherwise it would not
/// be known which fields are blank. `None` if the line fits its columns, or its words do not fit
/// either.
pub fn words_of_broken_columns(
    line: &[u8],
    card: &Card,
    format: CardFormat,
    by_columns: &Fields,
) -> Option<Fields> {
    let fits = |fields: &Fields| {
        card.fields.iter().enumerate().all(|(index, field)| {
            let text = fields.text(line, index);
            match field.kind {
                _ if text.is_empty() || text.contains(&b'&') => true,
                FieldType::Integer => number::integer(text).is_some(),
                FieldType::Real => number::real(text).is_some(),
                FieldType::Word | FieldType::Line => true,
            }
        })
    };
    let is_number = |kind: FieldType| matches!(kind, FieldType::Integer | FieldType::Real);
    let numbers = card.fields.iter().all(|field| is_number(field.kind));
    if !has_columns(line, format) || !numbers {
        return None;
    }
    if fits(by_columns) && cut_number(line, card, format).is_none() {
        return None;
    }
    let none = || Fields { count: 0, spans: [(0, 0); MOST] };
    let words = words(line, none());
    if words.count() > card.fields.len() {
        return shifted(line, card, format).find(fits);
    }
    if !fits(&words) {
        return shifted(line, card, format).find(fits);
    }
    if words.count() == card.fields.len() {
        return Some(words);
    }
    shifted(line, card, format).find(fits).or_else(|| {
        let mut border = 0;
        let in_order = card.fields.iter().enumerate().take(words.count()).all(|(index, field)| {
            let from = border;
            border += format.width(field.width);
            let (start, end) = words.span(index);
            // Twice the middle of the word, to stay with whole numbers.
            (2 * from..2 * border).contains(&(start + end))
        });
        in_order.then_some(words)
    })
}

/// Returns true if the fields of a line are its columns.
fn has_columns(line: &[u8], format: CardFormat) -> bool {
    format != CardFormat::Words && !line.iter().any(|b| b",\t".contains(b))
}

/// Returns the range of the first number that a border between columns cuts into two numbers, of
/// which neither fills its field, and the index of the field of the first one. Numbers of two
/// fields that touch do fill them, at least one of the two.
pub fn cut_number(line: &[u8], card: &Card, format: CardFormat) -> Option<(usize, Range<usize>)> {
    if !has_columns(line, format) {
        return None;
    }
    let mut start = 0;
    card.fields.windows(2).enumerate().find_map(|(index, two)| {
        let from = start;
        start += format.width(two[0].width);
        let end = start + format.width(two[1].width);
        let is_number = |kind: FieldType| matches!(kind, FieldType::Integer | FieldType::Real);
        let numbers = two.iter().all(|field| is_number(field.kind));
        let word = divided(line, start).filter(|word| {
            numbers
                && word.start > from
                && word.end < end
                && number::real(&line[word.clone()]).is_some()
        })?;
        Some((index, word))
    })
}

/// Splits a line by columns that begin later than those of its card, by one column, by two and so
/// on; the first field is so much wider. No border divides a number, and none is inside of the last
/// word.
fn shifted<'l>(
    line: &'l [u8],
    card: &'l Card,
    format: CardFormat,
) -> impl Iterator<Item = Fields> + 'l {
    (1..=SHIFT).filter_map(move |shift| {
        let mut fields = Fields { count: 0, spans: [(0, 0); MOST] };
        let (mut from, mut to) = (0, shift);
        for (index, field) in card.fields.iter().enumerate() {
            to += format.width(field.width);
            let is_last = index + 1 == card.fields.len();
            if divided(line, to).is_some_and(|at| is_last || number::real(&line[at]).is_some()) {
                return None;
            }
            fields.push(line, from, to);
            from = to;
        }
        Some(fields.drop_blanks())
    })
}

/// Returns the range of the word that a border between columns divides.
fn divided(line: &[u8], border: usize) -> Option<Range<usize>> {
    let (before, after) = line.split_at_checked(border)?;
    let is_blank = |b: &u8| b.is_ascii_whitespace();
    let start = before.iter().rposition(is_blank).map_or(0, |at| at + 1);
    let end = border + after.iter().position(is_blank).unwrap_or(after.len());
    (start < border && end > border).then_some(start..end)
}

/// Splits a line at separators.
fn parts(line: &[u8], separates: impl Fn(u8) -> bool, mut fields: Fields) -> Fields {
    let mut from = 0;
    for part in line.split(|&b| separates(b)) {
        fields.push(line, from, from + part.len());
        from += part.len() + 1;
    }
    fields.drop_blanks()
}

/// Splits a line into its words, which blanks or commas separate.
fn words(line: &[u8], mut fields: Fields) -> Fields {
    let mut at = 0;
    for word in line.split(|b| b.is_ascii_whitespace() || *b == b',') {
        if !word.is_empty() {
            fields.push(line, at, at + word.len());
        }
        at += word.len() + 1;
    }
    fields
}

/// Splits a line with tabs: by columns with tab stops at multiples of eight, if number fields
/// then hold numbers, otherwise word by word.
fn tabbed(line: &[u8], card: &Card, format: CardFormat, fields: Fields) -> Fields {
    // The byte in each column; a tab fills several columns.
    let mut columns: Vec<usize> = Vec::with_capacity(2 * line.len());
    for (at, &b) in line.iter().enumerate() {
        let end = if b == b'\t' { (columns.len() / TAB + 1) * TAB } else { columns.len() + 1 };
        columns.resize(end, at);
    }
    let byte = |column: usize| columns.get(column).copied().unwrap_or(line.len());
    let (mut fixed, mut from) = (fields, 0);
    let mut fits = true;
    for (index, field) in card.fields.iter().enumerate().take_while(|f| f.0 < MOST) {
        let to = from + format.width(field.width);
        fixed.push(line, byte(from), byte(to));
        let text = fixed.text(line, index);
        fits &= match field.kind {
            _ if text.is_empty() || text.contains(&b'&') => true,
            FieldType::Integer => number::integer(text).is_some(),
            FieldType::Real => number::real(text).is_some(),
            FieldType::Word | FieldType::Line => true,
        };
        from = to;
    }
    if fits {
        return fixed.drop_blanks();
    }
    words(line, fields)
}

/// Returns the line with its tabs replaced by blanks.
pub fn expand(line: &str) -> String {
    let mut out = String::with_capacity(line.len());
    let mut column = 0;
    for c in line.chars() {
        let width = if c == '\t' { TAB - column % TAB } else { 1 };
        match c {
            '\t' => out.extend(std::iter::repeat_n(' ', width)),
            _ => out.push(c),
        }
        column += width;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut(spec: &str, line: &str, format: CardFormat) -> Vec<String> {
        let card = Card::parse(spec);
        let fields = split(line.as_bytes(), &card, format);
        let text = |i| String::from_utf8_lossy(fields.text(line.as_bytes(), i)).into_owned();
        (0..fields.count()).map(text).collect()
    }

    #[test]
    fn fields_that_touch_are_cut_by_columns() {
        let card = "mid:i ro:r e:r";
        assert_eq!(
            cut(card, "         17.83000E-6     207.0", CardFormat::Standard),
            ["1", "7.83000E-6", "207.0"]
        );
        assert_eq!(
            cut("a:r b:r", "       0.01.00000E20", CardFormat::Standard),
            ["0.0", "1.00000E20"]
        );
        assert_eq!(
            cut("n:i8 x:r16 y:r16", "       1             1.0-2.0", CardFormat::Standard),
            ["1", "1.0", "-2.0"]
        );
    }

    #[test]
    fn all_formats_give_the_same_fields() {
        let card = "eid:i8 pid:i8 n1:i8 n2:i8";
        let fixed = format!("{:>8}{:>8}{:>8}{:>8}", 1, 2, "", 4);
        let long = format!("{:>20}{:>20}{:>20}{:>20}", 1, 2, "", 4);
        let i10 = format!("{:>10}{:>10}{:>10}{:>10}", 1, 2, "", 4);
        assert_eq!(cut(card, &fixed, CardFormat::Standard), ["1", "2", "", "4"]);
        assert_eq!(cut(card, &long, CardFormat::Long), ["1", "2", "", "4"]);
        assert_eq!(cut(card, &i10, CardFormat::I10), ["1", "2", "", "4"]);
        assert_eq!(cut(card, "1, 2,,4", CardFormat::Standard), ["1", "2", "", "4"]);
        assert_eq!(cut(card, "1,2,,4", CardFormat::Long), ["1", "2", "", "4"]);
    }

    /// A number that a border cuts has blanks on both sides of its two fields; numbers of two
    /// fields that touch fill one of them.
    #[test]
    fn a_border_that_cuts_a_number_is_found() {
        let card = Card::parse("e:r20 nu:r20 iflag:i");
        let found = |line: &str| {
            let fields = split(line.as_bytes(), &card, CardFormat::Columns);
            words_of_broken_columns(line.as_bytes(), &card, CardFormat::Columns, &fields).map(
                |words| {
                    let text = |i| String::from_utf8_lossy(words.text(line.as_bytes(), i));
                    (0..words.count()).map(|i| text(i).into_owned()).collect::<Vec<_>>()
                },
            )
        };
        let cut = "                 204                  .33         0";
        assert_eq!(found(cut), Some(["204", ".33", "0"].map(String::from).to_vec()));
        let at = |line: &str| cut_number(line.as_bytes(), &card, CardFormat::Columns);
        assert_eq!(at(cut), Some((1, 38..41)));
        // Words that fit no other columns, and two numbers that may also be one: the columns count.
        let unknown = "                 204                  1.33e-1";
        assert_eq!((found(unknown), at(unknown)), (None, Some((1, 38..45))));
        let aligned_to_the_border = "                 2041.0000000000000e-01         0";
        let reading = (found(aligned_to_the_border), at(aligned_to_the_border));
        assert_eq!(reading, (None, Some((0, 17..39))));
        for whole in [
            "                 204                 .33         0",
            "                 204 1.000000000000e-01         0",
            "204.0000000000000000.33                          0",
        ] {
            assert_eq!((found(whole), at(whole)), (None, None), "{whole}");
        }
    }

    #[test]
    fn tabs_are_columns_where_they_fit_and_blanks_where_not() {
        let card = "eid:i8 pid:i8 n1:i8 n2:i8";
        assert_eq!(cut(card, "1\t2\t\t4", CardFormat::Standard), ["1", "2", "", "4"]);
        assert_eq!(
            cut("a:r b:r c:r", "1.0\t2.0\t3.0", CardFormat::Standard),
            ["1.0", "2.0", "3.0"]
        );
        assert_eq!(cut("a:i b:a", "\t 7name", CardFormat::Standard), ["7", "name"]);
    }

    #[test]
    fn lines_of_text_are_whole() {
        assert_eq!(cut("title:l", "  a, b\tc  ", CardFormat::Standard), ["a, b\tc"]);
    }
}
