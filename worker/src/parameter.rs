//! Keys of laws: every law publishes a table of its keys. Schema, checks, reference and warnings
//! of the master follow from these tables.

use crumple_proto::job::Setting;
use std::collections::BTreeMap;

/// A key of a law.
#[derive(Clone, Copy, Debug)]
pub struct ParameterRow {
    /// Key in the job.
    pub key: &'static str,
    /// Form of the value.
    pub form: Form,
    /// Default value.
    pub otherwise: DefaultValue,
    /// Valid values of a number; `None` if all are valid, or if the law itself checks them.
    pub range: Option<Range>,
    /// Meaning, with the dimension in brackets.
    pub meaning: &'static str,
}

/// Form of a value.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Form {
    /// A number.
    Number,
    /// A whole number, 0 or above.
    Whole,
    /// True or false.
    Flag,
    /// One of these words.
    Word(&'static [&'static str]),
    /// A list, described as `[C, p]`.
    List(&'static str),
}

/// Value of a key that is not given.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DefaultValue {
    /// None: the key is required.
    Needed,
    /// The property does not exist.
    Absent,
    /// A number.
    Number(f64),
    /// A whole number.
    Whole(i64),
    /// True or false.
    Flag(bool),
    /// A word.
    Word(&'static str),
    /// The default depends on other keys, as this text explains.
    Depends(&'static str),
}

/// Valid values of a number.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Valid values in words, to follow "it has to be".
    pub wanted: &'static str,
    /// Returns true for a valid value.
    pub fits: fn(f64) -> bool,
}

/// The values of a law: those that the job gives, and defaults for the others.
pub struct Values<'a> {
    /// Tables of the law.
    tables: [&'static [ParameterRow]; 2],
    given: &'a BTreeMap<String, Setting>,
}

impl<'a> Values<'a> {
    /// Creates the values of a law with the keys of two tables, of which `given` holds some.
    pub fn new(tables: [&'static [ParameterRow]; 2], given: &'a BTreeMap<String, Setting>) -> Self {
        Self { tables, given }
    }

    /// Returns the value as given, or its default.
    ///
    /// # Panics
    /// If no table of the law has the key, or if a required key is missing. The master checks the
    /// keys of a job.
    fn value(&self, key: &str) -> Setting {
        let row = self.tables.into_iter().flatten().find(|row| row.key == key);
        let row = row.unwrap_or_else(|| panic!("the table of the law has no key {key}"));
        let default = || match row.otherwise {
            DefaultValue::Number(value) => value.into(),
            DefaultValue::Whole(value) => value.into(),
            DefaultValue::Flag(value) => value.into(),
            DefaultValue::Word(word) => word.into(),
            DefaultValue::Needed | DefaultValue::Absent | DefaultValue::Depends(_) => {
                panic!("{key} is not given")
            }
        };
        self.given.get(key).cloned().unwrap_or_else(default)
    }

    /// Returns a number. Panics if it is not one; the master checks types.
    pub fn number(&self, key: &str) -> f64 {
        self.value(key).number().unwrap_or_else(|| panic!("{key} is not a number"))
    }

    /// Returns a whole number. Panics if it is not one, 0 or above; the master checks types.
    pub fn whole(&self, key: &str) -> usize {
        match self.value(key) {
            Setting::Whole(value) => usize::try_from(value).ok(),
            _ => None,
        }
        .unwrap_or_else(|| panic!("{key} is not a whole number, 0 or above"))
    }

    /// Returns a flag. Panics if it is not one; the master checks types.
    pub fn flag(&self, key: &str) -> bool {
        let Setting::Flag(value) = self.value(key) else { panic!("{key} is not true or false") };
        value
    }

    /// Returns a word. Panics if it is not one; the master checks types.
    pub fn word(&self, key: &str) -> String {
        let Setting::Word(word) = self.value(key) else { panic!("{key} is not a word") };
        word
    }
}
