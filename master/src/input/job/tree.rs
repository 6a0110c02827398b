//! A job file as a tree in which every value has its place in the file.

use std::collections::BTreeMap;
use std::ops::Range;
use toml::de::{DeTable, DeValue};

/// Origin of a key or a value.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// Bytes of the file.
    File {
        /// First byte.
        start: u32,
        /// One past the last byte.
        end: u32,
    },
    /// Bytes of a file of the deck.
    Deck {
        /// Number of the file.
        file: u32,
        /// First byte.
        start: u32,
        /// One past the last byte.
        end: u32,
    },
    /// Bytes of a file that the job includes.
    Included {
        /// Number of the file.
        file: u32,
        /// First byte.
        start: u32,
        /// One past the last byte.
        end: u32,
    },
    /// The numbered `--set` of the command line.
    Set(u32),
    /// The whole file, if no key is the cause.
    Whole,
}

impl Place {
    fn from_span(span: Range<usize>) -> Self {
        // Files beyond 4 GiB are rejected before they are parsed.
        Place::File { start: span.start as u32, end: span.end as u32 }
    }

    /// Returns the same place in the deck's file with this number.
    fn of_deck(self, file: u32) -> Self {
        match self {
            Place::File { start, end } => Place::Deck { file, start, end },
            other => other,
        }
    }

    /// Returns the same place in the included file with this number.
    pub fn of_included(self, file: u32) -> Self {
        match self {
            Place::File { start, end } => Place::Included { file, start, end },
            other => other,
        }
    }
}

/// A value and its place; for a table the place of its header.
#[derive(Clone, Debug)]
pub struct Node {
    /// Its kind.
    pub kind: NodeContent,
    /// Its place.
    pub place: Place,
}

/// Kind and content of a value.
#[derive(Clone, Debug)]
pub enum NodeContent {
    /// Keys and values.
    Table(BTreeMap<String, Entry>),
    /// A list, or the entries of an array of tables.
    Array(Vec<Node>),
    /// Text.
    String(String),
    /// An integer.
    Integer(i64),
    /// A number with a fraction or exponent; also an integer too large for 64 bits.
    Float(f64),
    /// True or false.
    Boolean(bool),
    /// A date or time, which no job key has.
    Datetime(toml::value::Datetime),
}

/// A key's place and its value.
#[derive(Clone, Debug)]
pub struct Entry {
    /// Place of the key.
    pub key: Place,
    /// The value.
    pub node: Node,
}

/// A syntax error: message, advice, and place.
pub type SyntaxError = (String, &'static str, Place);

impl Node {
    /// Parses TOML; returns all syntax errors at once.
    pub fn parse(text: &str) -> Result<Node, Vec<SyntaxError>> {
        let (table, errors) = DeTable::parse_recoverable(text);
        let mut errors: Vec<SyntaxError> = errors
            .iter()
            .map(|e| {
                (
                    e.message().to_string(),
                    e.span()
                        .and_then(|span| decimal_comma(text, span.start))
                        .unwrap_or_else(|| syntax_help(e.message())),
                    e.span().map_or(Place::Whole, Place::from_span),
                )
            })
            .collect();
        if !errors.is_empty() {
            return Err(errors);
        }
        let root = from_table(table.get_ref(), Place::Whole, &mut errors);
        if errors.is_empty() { Ok(root) } else { Err(errors) }
    }

    /// Parses one value as after `key =`; `None` if it is not a TOML value.
    pub fn parse_value(text: &str, place: Place) -> Option<Node> {
        let line = format!("value = {text}");
        let table = DeTable::parse(&line).ok()?;
        let mut errors = Vec::new();
        let mut root = from_table(table.get_ref(), place, &mut errors);
        let NodeContent::Table(entries) = &mut root.kind else { return None };
        // A line break in `text` could insert further keys.
        if entries.len() != 1 || !errors.is_empty() {
            return None;
        }
        let mut node = entries.remove("value")?.node;
        node.change_places(&|_| place);
        Some(node)
    }

    /// Creates an empty table.
    pub fn table(place: Place) -> Node {
        Node { kind: NodeContent::Table(BTreeMap::new()), place }
    }

    /// Marks all its places as those of a file of the deck.
    pub fn move_to(&mut self, file: u32) {
        self.change_places(&|place| place.of_deck(file));
    }

    /// Marks all its places as those of an included file.
    pub fn move_to_included(&mut self, file: u32) {
        self.change_places(&|place| place.of_included(file));
    }

    /// Replaces its place, and those of all keys and values below it.
    fn change_places(&mut self, changed: &impl Fn(Place) -> Place) {
        self.place = changed(self.place);
        match &mut self.kind {
            NodeContent::Table(entries) => {
                for entry in entries.values_mut() {
                    entry.key = changed(entry.key);
                    entry.node.change_places(changed);
                }
            }
            NodeContent::Array(items) => {
                items.iter_mut().for_each(|item| item.change_places(changed));
            }
            _ => {}
        }
    }

    /// Returns the value of `key` if this is a table with this key.
    pub fn get(&self, key: &str) -> Option<&Node> {
        match &self.kind {
            NodeContent::Table(entries) => entries.get(key).map(|e| &e.node),
            _ => None,
        }
    }

    /// Returns the place of the value at a dotted path, or of the nearest table that contains it.
    pub fn locate(&self, path: &str) -> Place {
        let (mut node, mut rest, mut found) = (self, path, self.place);
        while !rest.is_empty() {
            match &node.kind {
                NodeContent::Table(entries) => {
                    let Some((key, tail)) = split_first(rest, entries.keys().map(String::as_str))
                    else {
                        break;
                    };
                    let entry = &entries[key];
                    (node, rest) = (&entry.node, tail);
                    found = entry.place();
                }
                NodeContent::Array(items) => {
                    let (head, tail) = rest.split_once('.').unwrap_or((rest, ""));
                    let Some(item) = head.parse().ok().and_then(|i: usize| items.get(i)) else {
                        break;
                    };
                    (node, rest) = (item, tail);
                    found = item.place;
                }
                _ => break,
            }
        }
        found
    }

    /// Converts the tree to a value without places. Numbers that TOML cannot hold do not occur,
    /// because the reader rejects them.
    pub fn to_value(&self) -> toml::Value {
        match &self.kind {
            NodeContent::Table(entries) => toml::Value::Table(
                entries.iter().map(|(k, e)| (k.clone(), e.node.to_value())).collect(),
            ),
            NodeContent::Array(items) => {
                toml::Value::Array(items.iter().map(Node::to_value).collect())
            }
            NodeContent::String(s) => toml::Value::String(s.clone()),
            NodeContent::Integer(i) => toml::Value::Integer(*i),
            NodeContent::Float(x) => toml::Value::Float(*x),
            NodeContent::Boolean(b) => toml::Value::Boolean(*b),
            NodeContent::Datetime(d) => toml::Value::Datetime(*d),
        }
    }
}

impl Entry {
    /// Returns the place to show for a faulty value: `key = value` if both are together.
    pub fn place(&self) -> Place {
        match (&self.node.kind, self.key, self.node.place) {
            (NodeContent::Table(_), _, place) => place,
            (_, Place::File { start, end: key_end }, Place::File { start: value, end })
                if key_end <= value =>
            {
                Place::File { start, end }
            }
            (
                _,
                Place::Included { file, start, end: key_end },
                Place::Included { start: value, end, .. },
            ) if key_end <= value => Place::Included { file, start, end },
            (_, _, place) => place,
        }
    }
}

/// Splits a dotted path after its first key, which is one of `keys`; a key may itself contain
/// dots.
pub fn split_first<'p, 'k>(
    path: &'p str,
    keys: impl Iterator<Item = &'k str>,
) -> Option<(&'k str, &'p str)> {
    let fits = |key: &&str| {
        path.strip_prefix(*key).is_some_and(|rest| rest.is_empty() || rest.starts_with('.'))
    };
    let key = keys.filter(fits).max_by_key(|key| key.len())?;
    Some((key, path[key.len()..].strip_prefix('.').unwrap_or("")))
}

/// Returns the help for a number with a decimal comma in the line at this offset.
fn decimal_comma(text: &str, at: usize) -> Option<&'static str> {
    let before = text.get(..at)?;
    let line = text[before.rfind('\n').map_or(0, |end| end + 1)..].lines().next()?;
    let value = line.split_once('=')?.1.split('#').next()?.trim();
    let (whole, rest) = value.split_once(',')?;
    whole.parse::<i64>().ok()?;
    let number = format!("{whole}.{rest}");
    let is_number = rest.starts_with(|c: char| c.is_ascii_digit()) && number.parse::<f64>().is_ok();
    is_number.then_some("numbers have a decimal point, as in 1.5")
}

fn syntax_help(message: &str) -> &'static str {
    if message.contains("duplicate") {
        "write each key and each [section] once; [[section]] adds an entry to a list"
    } else if message.contains("string") {
        "write text in quotes: key = \"text\""
    } else {
        "write TOML: key = value, [section], [[entry of a list]]; text in quotes, lists in \
         brackets with commas"
    }
}

fn from_table(table: &DeTable<'_>, place: Place, errors: &mut Vec<SyntaxError>) -> Node {
    let entries = table
        .iter()
        .map(|(key, value)| {
            let node = from_value(value.get_ref(), Place::from_span(value.span()), errors);
            (key.get_ref().to_string(), Entry { key: Place::from_span(key.span()), node })
        })
        .collect();
    Node { kind: NodeContent::Table(entries), place }
}

fn from_value(value: &DeValue<'_>, place: Place, errors: &mut Vec<SyntaxError>) -> Node {
    let kind = match value {
        DeValue::Table(table) => return from_table(table, place, errors),
        DeValue::Array(items) => NodeContent::Array(
            items
                .iter()
                .map(|item| from_value(item.get_ref(), Place::from_span(item.span()), errors))
                .collect(),
        ),
        DeValue::String(s) => NodeContent::String(s.to_string()),
        DeValue::Integer(i) => match i64::from_str_radix(i.as_str(), i.radix()) {
            Ok(i) => NodeContent::Integer(i),
            Err(_) if i.radix() == 10 => NodeContent::Float(i.as_str().parse().unwrap_or(f64::NAN)),
            Err(_) => {
                errors.push((
                    "the number does not fit in 64 bits".into(),
                    "write a smaller number",
                    place,
                ));
                NodeContent::Integer(0)
            }
        },
        DeValue::Float(x) => match x.as_str().parse() {
            Ok(x) => NodeContent::Float(x),
            Err(_) => {
                errors.push((
                    "the number cannot be read".into(),
                    "write it like 1.5 or 1.5e-3",
                    place,
                ));
                NodeContent::Float(0.0)
            }
        },
        DeValue::Boolean(b) => NodeContent::Boolean(*b),
        DeValue::Datetime(d) => NodeContent::Datetime(*d),
    };
    Node { kind, place }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cut<'t>(text: &'t str, tree: &Node, path: &str) -> &'t str {
        match tree.locate(path) {
            Place::File { start, end } => &text[start as usize..end as usize],
            _ => "",
        }
    }

    #[test]
    fn values_are_found_where_they_are_written() {
        let text =
            "end_time = 1.5\n[[part]]\nid = 1\n[[part]]\nid = 2\n[sets]\n\"a.b\" = [1, 22]\n";
        let tree = Node::parse(text).unwrap();
        assert_eq!(cut(text, &tree, "end_time"), "end_time = 1.5");
        assert_eq!(cut(text, &tree, "part.1.id"), "id = 2");
        assert_eq!(cut(text, &tree, "part.1.thickness"), "[[part]]");
        assert_eq!(cut(text, &tree, "sets.a.b.1"), "22");
        assert_eq!(tree.locate("nothing"), Place::Whole);
    }

    #[test]
    fn a_decimal_comma_is_named() {
        let help = |text| Node::parse(text).unwrap_err()[0].1;
        assert!(help("a = 2\nthickness = 1,5 # mm\n").contains("a decimal point, as in 1.5"));
        assert!(!help("a = 2\nthickness = 1 5\n").contains("decimal point"));
    }

    #[test]
    fn all_syntax_errors_come_at_once() {
        assert_eq!(Node::parse("a = 1\na = 2\n[b]\n[b]\nc = 1e\n").unwrap_err().len(), 3);
    }

    #[test]
    fn numbers_are_read_in_all_notations() {
        let tree =
            Node::parse("a = 1_000\nb = 0x1F\nc = 1_0.5e-1\nd = -inf\ne = 99999999999999999999\n")
                .unwrap();
        let value = |key| tree.get(key).unwrap().to_value();
        assert_eq!(value("a").as_integer(), Some(1000));
        assert_eq!(value("b").as_integer(), Some(31));
        assert_eq!(value("c").as_float(), Some(1.05));
        assert_eq!(value("d").as_float(), Some(f64::NEG_INFINITY));
        assert_eq!(value("e").as_float(), Some(1e20));
    }

    #[test]
    fn one_value_stays_one_value() {
        assert!(Node::parse_value("1\nb = 2", Place::Set(0)).is_none());
        assert!(Node::parse_value("steel", Place::Set(0)).is_none());
        assert!(matches!(
            Node::parse_value("[1, 2]", Place::Set(0)).unwrap().kind,
            NodeContent::Array(_)
        ));
    }
}
