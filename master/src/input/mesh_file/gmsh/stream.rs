//! Numbers of an MSH file, as text or as binary data.

use crate::input::deck::number;

/// Fault of a row of numbers.
#[derive(Clone, Debug, PartialEq)]
pub struct RowFault {
    /// Description.
    pub message: String,
    /// True if the rest of the section cannot be read.
    pub fatal: bool,
}

type MshNumber<T> = Result<T, RowFault>;

/// Form of the data.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum MshForm {
    /// One row in each line.
    Text,
    /// Numbers one after the other.
    Binary {
        /// True if the most significant byte comes first.
        big_endian: bool,
        /// Size of counts and tags of version 4 [byte].
        size: usize,
    },
}

/// A file and the position in it.
pub struct MshStream<'a> {
    bytes: &'a [u8],
    at: usize,
    /// Line of the position, from 1. Within binary data, that of its begin.
    pub line: u32,
    /// Form of the data.
    pub form: MshForm,
    row: std::str::SplitAsciiWhitespace<'a>,
    given: usize,
}

impl<'a> MshStream<'a> {
    /// Begins to read.
    pub fn new(bytes: &'a [u8]) -> Self {
        let row = "".split_ascii_whitespace();
        MshStream { bytes, at: 0, line: 0, form: MshForm::Text, row, given: 0 }
    }

    /// Returns the next line without blanks around it; `None` at the end.
    pub fn text_line(&mut self) -> Option<&'a str> {
        if self.at >= self.bytes.len() {
            return None;
        }
        let rest = &self.bytes[self.at..];
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.at += length + 1;
        self.line += 1;
        Some(std::str::from_utf8(&rest[..length]).unwrap_or("\u{fffd}").trim())
    }

    /// Returns the next line with text, without moving on.
    fn peek(&self) -> Option<&'a str> {
        let mut ahead = MshStream { row: "".split_ascii_whitespace(), ..*self };
        std::iter::from_fn(|| ahead.text_line()).find(|line| !line.is_empty())
    }

    /// Returns true if the next line begins or ends a section.
    pub fn at_section(&self) -> bool {
        self.peek().is_none_or(|line| line.starts_with('$'))
    }

    /// Begins a row. In text, this is the next line with text.
    pub fn begin_row(&mut self) -> MshNumber<()> {
        if self.form != MshForm::Text {
            return Ok(());
        }
        if self.at_section() {
            let message = "the section ends before all its rows are there".into();
            return Err(RowFault { message, fatal: true });
        }
        let line = std::iter::from_fn(|| self.text_line()).find(|line| !line.is_empty());
        self.row = line.unwrap_or_default().split_ascii_whitespace();
        self.given = self.row.clone().count();
        Ok(())
    }

    /// Ends a row. In text, it must not have more numbers.
    pub fn end_row(&mut self) -> MshNumber<()> {
        match self.row.next() {
            Some(more) if self.form == MshForm::Text => Err(fault(format!(
                "the line has {} numbers, more than expected: {more}",
                self.given
            ))),
            _ => Ok(()),
        }
    }

    fn word(&mut self) -> MshNumber<&'a str> {
        self.row.next().ok_or_else(|| {
            fault(format!("the line has {} numbers, fewer than expected", self.given))
        })
    }

    fn raw<const N: usize>(&mut self) -> MshNumber<[u8; N]> {
        let end = self.at.saturating_add(N);
        let found = self.bytes.get(self.at..end).and_then(|b| <[u8; N]>::try_from(b).ok());
        self.at = end;
        found.ok_or_else(|| {
            let message = format!("the file ends at byte {} within binary data", self.bytes.len());
            RowFault { message, fatal: true }
        })
    }

    /// Returns the next 32-bit integer.
    pub fn int(&mut self) -> MshNumber<i64> {
        match self.form {
            MshForm::Text => {
                let word = self.word()?;
                number::integer(word.as_bytes())
                    .ok_or_else(|| fault(format!("`{word}` is no whole number")))
            }
            MshForm::Binary { big_endian: true, .. } => {
                self.raw().map(|b| i64::from(i32::from_be_bytes(b)))
            }
            MshForm::Binary { .. } => self.raw().map(|b| i64::from(i32::from_le_bytes(b))),
        }
    }

    /// Returns the next count or tag, from 0.
    pub fn size(&mut self) -> MshNumber<u64> {
        let signed = match self.form {
            MshForm::Binary { size: 8, big_endian: true } => self.raw().map(i64::from_be_bytes)?,
            MshForm::Binary { size: 8, .. } => self.raw().map(i64::from_le_bytes)?,
            _ => self.int()?,
        };
        let fatal = self.form != MshForm::Text;
        u64::try_from(signed)
            .map_err(|_| RowFault { message: format!("{signed} is no count and no id"), fatal })
    }

    /// Returns the next number.
    pub fn double(&mut self) -> MshNumber<f64> {
        match self.form {
            MshForm::Text => {
                let word = self.word()?;
                number::real(word.as_bytes())
                    .ok_or_else(|| fault(format!("`{word}` is no finite number")))
            }
            MshForm::Binary { big_endian: true, .. } => self.raw().map(f64::from_be_bytes),
            MshForm::Binary { .. } => self.raw().map(f64::from_le_bytes),
        }
    }

    /// Returns three numbers.
    pub fn point(&mut self) -> MshNumber<[f64; 3]> {
        Ok([self.double()?, self.double()?, self.double()?])
    }

    /// Moves to the line that ends a section; returns false if it is missing.
    pub fn skip_to(&mut self, end: &str) -> bool {
        if self.form != MshForm::Text {
            // The text of a section follows its binary data after a line feed.
            let rest = self.bytes.get(self.at..).unwrap_or_default();
            let found = rest.windows(end.len()).position(|w| w == end.as_bytes());
            let Some(found) = found else { return false };
            self.at += found;
        }
        while let Some(line) = self.text_line() {
            if line == end {
                return true;
            }
        }
        false
    }
}

fn fault(message: String) -> RowFault {
    RowFault { message, fatal: false }
}
