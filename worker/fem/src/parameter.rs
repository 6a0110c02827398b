//! Keys of laws and elements: each of them publishes a table of its keys. Schema, checks, reference
//! and warnings of the master follow from these tables.

use crumple_proto::job::Setting;
use crumple_proto::problem::Problem;
use std::collections::BTreeMap;
use std::fmt::{Display, Formatter};

/// A key of a law or an element.
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

impl ParameterRow {
    /// Returns the valid values in words, to follow "it has to be", if `value` is not valid.
    fn fault(&self, value: &Setting) -> Option<String> {
        let is_right = match (self.form, value) {
            (Form::Number, value) => value.number().is_some(),
            (Form::Whole, Setting::Whole(value)) => *value >= 0,
            (Form::Flag, Setting::Flag(_)) | (Form::List(_), Setting::List(_)) => true,
            (Form::Word(words), Setting::Word(word)) => words.contains(&word.as_str()),
            (Form::Numbers(count), Setting::List(list)) => list.len() == count,
            _ => false,
        };
        if !is_right {
            return Some(self.form.to_string());
        }
        let range = self.range?;
        let is_within = match value {
            Setting::List(list) => list.iter().all(|x| (range.fits)(*x)),
            value => value.number().is_none_or(range.fits),
        };
        (!is_within).then(|| range.wanted.to_string())
    }
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
    /// So many numbers.
    Numbers(usize),
    /// A list, described as `[C, p]`.
    List(&'static str),
}

/// Writes the form in words, as in "it has to be a number".
impl Display for Form {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Number => write!(f, "a number"),
            Self::Whole => write!(f, "a whole number, 0 or above"),
            Self::Flag => write!(f, "true or false"),
            Self::Word(words) => write!(f, "one of {}", words.join(", ")),
            Self::Numbers(count) => write!(f, "a list of {count} numbers"),
            Self::List(form) => write!(f, "a list {form}"),
        }
    }
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
    /// Numbers.
    Numbers(&'static [f64]),
    /// The default depends on other keys, as this text explains.
    Depends(&'static str),
}

/// Valid values of a number, or of each number of a list.
#[derive(Clone, Copy, Debug)]
pub struct Range {
    /// Valid values in words, to follow "it has to be".
    pub wanted: &'static str,
    /// Returns true for a valid value.
    pub fits: fn(f64) -> bool,
}

/// The values of a law or an element: those that the job gives, and defaults for the others.
pub struct Values<'a> {
    /// Its tables.
    tables: [&'static [ParameterRow]; 2],
    given: &'a BTreeMap<String, Setting>,
}

impl<'a> Values<'a> {
    /// Creates the values of the keys of two tables, of which `given` holds some.
    pub fn new(tables: [&'static [ParameterRow]; 2], given: &'a BTreeMap<String, Setting>) -> Self {
        Self { tables, given }
    }

    /// Returns the value as given, or its default.
    ///
    /// # Panics
    /// If no table has the key, or if a required key is missing ([`Self::missing`]). The master
    /// checks the keys of a job.
    fn value(&self, key: &str) -> Setting {
        let row = self.tables.into_iter().flatten().find(|row| row.key == key);
        let row = row.unwrap_or_else(|| panic!("no table has the key {key}"));
        let default = || match row.otherwise {
            DefaultValue::Number(value) => value.into(),
            DefaultValue::Whole(value) => value.into(),
            DefaultValue::Flag(value) => value.into(),
            DefaultValue::Word(word) => word.into(),
            DefaultValue::Numbers(list) => Setting::List(list.into()),
            DefaultValue::Needed | DefaultValue::Absent | DefaultValue::Depends(_) => {
                panic!("{key} is not given")
            }
        };
        self.given.get(key).cloned().unwrap_or_else(default)
    }

    /// Returns true if the job gives this key.
    pub fn is_given(&self, key: &str) -> bool {
        self.given.contains_key(key)
    }

    /// Returns a number. Panics if it is not one; the master checks types.
    pub fn number(&self, key: &str) -> f64 {
        self.value(key).number().unwrap_or_else(|| panic!("{key} is not a number"))
    }

    /// Returns true if the tables have this key.
    pub fn has(&self, key: &str) -> bool {
        self.tables.into_iter().flatten().any(|row| row.key == key)
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

    /// Returns a list of N numbers. Panics if it is not one; the master checks types.
    pub fn numbers<const N: usize>(&self, key: &str) -> [f64; N] {
        match self.value(key) {
            Setting::List(list) => list.try_into().ok(),
            _ => None,
        }
        .unwrap_or_else(|| panic!("{key} is not a list of {N} numbers"))
    }

    /// Returns the required keys that are not given.
    pub fn missing(&self) -> impl Iterator<Item = &'static ParameterRow> {
        let rows = self.tables.into_iter().flatten();
        rows.filter(|row| {
            row.otherwise == DefaultValue::Needed && !self.given.contains_key(row.key)
        })
    }

    /// Returns the problems of the given values: wrong types, and values out of range. The path of
    /// a problem is the key; `owner` is the object that has the keys, in words.
    pub fn faults(&self, owner: &str) -> Vec<Problem> {
        let fault = |row: &ParameterRow| {
            let value = self.given.get(row.key)?;
            let wanted = row.fault(value)?;
            let message = format!("{owner}: {} is {value}", row.key);
            Some(Problem::error(row.key, message, format!("it has to be {wanted}")))
        };
        self.tables.into_iter().flatten().filter_map(fault).collect()
    }
}
