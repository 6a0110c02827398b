//! Values of keys that laws and elements publish.

use serde::{Deserialize, Serialize};
use std::fmt::{Display, Formatter};

/// Value of a key that a law or an element publishes.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Setting {
    /// True or false.
    Flag(bool),
    /// A number written without a point.
    Whole(i64),
    /// A number written with a point.
    Number(f64),
    /// A word.
    Word(String),
    /// A list of numbers.
    List(Vec<f64>),
}

impl Setting {
    /// Returns the value of a number; `None` for a flag, a word or a list.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Whole(value) => Some(*value as f64),
            Self::Flag(_) | Self::Word(_) | Self::List(_) => None,
        }
    }
}

impl From<bool> for Setting {
    fn from(value: bool) -> Self {
        Self::Flag(value)
    }
}

impl From<i64> for Setting {
    fn from(value: i64) -> Self {
        Self::Whole(value)
    }
}

impl From<f64> for Setting {
    fn from(value: f64) -> Self {
        Self::Number(value)
    }
}

impl From<&str> for Setting {
    fn from(value: &str) -> Self {
        Self::Word(value.into())
    }
}

impl<const N: usize> From<[f64; N]> for Setting {
    fn from(values: [f64; N]) -> Self {
        Self::List(values.into())
    }
}

/// Writes the value as in a message: words without quotes.
impl Display for Setting {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Flag(value) => write!(f, "{value}"),
            Self::Whole(value) => write!(f, "{value}"),
            Self::Number(value) => write!(f, "{value}"),
            Self::Word(value) => write!(f, "{value}"),
            Self::List(values) => write!(f, "{values:?}"),
        }
    }
}
