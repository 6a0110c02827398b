//! Sets of Nastran as node sets: `SET1` and `SET3` of the bulk data, `SET` of OptiStruct and of the
//! case control.
//!
//! A `SET1` does not say if its ids are those of nodes or of elements. A comment of HyperMesh does;
//! without it they are nodes, unless only elements have all of them. A `SET` of the case control
//! has what the requests for output that name it are for. Sets of elements and of properties become
//! the nodes of their elements.

use super::BulkReader;
use super::cards::{BulkCard, FieldFault, NamedId, NamedKind, SetKind};
use crate::input::mesh_file::content::{FileElement, FilePlace};
use crate::input::mesh_file::reading::Fate;
use std::collections::{BTreeSet, HashMap};

/// Requests for output of nodes and of elements, by the letters that are enough.
const NODAL: &[&str] =
    &["DISP", "VECT", "PRES", "VELO", "ACCE", "SPCF", "MPCF", "OLOA", "GPFO", "THER"];
const OF_ELEMENTS: &[&str] = &["STRE", "ELST", "STRA", "FORC", "ELFO", "ESE", "EKE", "EDE"];

/// Returns true for cards of sets.
pub fn is_set(name: &str) -> bool {
    ["SET1", "SET3", "SET"].contains(&name)
}

/// Reads the sets of a file whose nodes and elements are known.
pub fn read(
    reader: &mut BulkReader<'_>,
    cards: &[BulkCard],
    control: &[(String, FilePlace)],
    names: &[NamedId],
) {
    let has_sets = cards.iter().any(|card| is_set(&card.name)) || !control.is_empty();
    if !has_sets {
        return;
    }
    let mut sets = SetReader::new(reader, names);
    for card in cards.iter().filter(|card| is_set(&card.name)) {
        if let Err(fault) = sets.card(card) {
            sets.reader.reported(card, |_, _| Err(fault));
        }
    }
    sets.control(control);
}

struct SetReader<'r, 'a> {
    reader: &'r mut BulkReader<'a>,
    /// Kinds and names of sets in comments.
    names: HashMap<u64, (SetKind, String)>,
    nodes: BTreeSet<u64>,
    elements: BTreeSet<u64>,
    parts: BTreeSet<u64>,
}

impl<'r, 'a> SetReader<'r, 'a> {
    fn new(reader: &'r mut BulkReader<'a>, names: &[NamedId]) -> Self {
        let of_set = |named: &NamedId| match named.of {
            NamedKind::Set(kind) => Some((named.id, (kind, named.name.clone()))),
            NamedKind::Property | NamedKind::Component => None,
        };
        let names = names.iter().filter_map(of_set).collect();
        let nodes = reader.at.keys().copied().collect();
        let mesh = &reader.reading.mesh;
        let elements = mesh.elements.iter().map(|element| element.id).collect();
        let parts = mesh.parts.iter().map(|part| u64::from(part.id)).collect();
        SetReader { reader, names, nodes, elements, parts }
    }

    /// Reads a card of the bulk data.
    fn card(&mut self, card: &BulkCard) -> Result<(), FieldFault> {
        let Some(id) = card.id(0)? else {
            let help = "write the id in field 2";
            self.reader.error("id", card, "the set has no id".into(), help);
            return Ok(());
        };
        let upper = |index: usize| card.text(index).to_uppercase();
        let (kind, first) = match card.name.as_str() {
            "SET1" => (self.names.get(&id).map(|named| named.0), 1),
            "SET3" => match upper(1).as_str() {
                "GRID" => (Some(SetKind::Nodes), 2),
                "ELEM" | "ELEMENT" => (Some(SetKind::Elements), 2),
                "PROP" => (Some(SetKind::Properties), 2),
                _ => return self.ignored(card, id, 1),
            },
            _ if !["", "LIST"].contains(&upper(2).as_str()) => return self.ignored(card, id, 2),
            _ => match upper(1).as_str() {
                "GRID" => (Some(SetKind::Nodes), 8),
                "ELEM" => (Some(SetKind::Elements), 8),
                "PROP" => (Some(SetKind::Properties), 8),
                _ => return self.ignored(card, id, 1),
            },
        };
        let words = card.fields.iter().skip(first).map(String::as_str);
        let words: Vec<&str> = words.filter(|word| !word.is_empty()).collect();
        match IdList::parse(&words) {
            Ok(list) => self.add(&format!("{} {id}", card.name), id, kind, &list, card.place),
            Err(word) => {
                let message = format!("set {id}: `{word}` is not expected");
                self.reader.error("set", card, message, LIST_HELP);
            }
        }
        Ok(())
    }

    /// Notes a set of something that is not read.
    fn ignored(&mut self, card: &BulkCard, id: u64, field: usize) -> Result<(), FieldFault> {
        let what = format!("{} {id} of {}", card.name, card.text(field));
        let became = "only lists of nodes, elements and properties are read";
        self.reader.reading.row(Fate::Ignored, what, 1, became);
        Ok(())
    }

    /// Reads the sets of the case control.
    fn control(&mut self, lines: &[(String, FilePlace)]) {
        let mut commands: Vec<(String, FilePlace)> = Vec::new();
        for (line, place) in lines {
            match commands.last_mut() {
                Some((before, _)) if before.ends_with(',') => before.push_str(line.trim()),
                _ => commands.push((line.trim().to_uppercase(), *place)),
            }
        }
        let kinds: HashMap<u64, SetKind> = commands.iter().filter_map(|c| request(&c.0)).collect();
        for (command, place) in &commands {
            let Some((head, list)) = command.split_once('=') else { continue };
            let mut words = head.split_whitespace();
            let (Some("SET"), Some(id), None) = (words.next(), words.next(), words.next()) else {
                continue;
            };
            let Ok(id) = id.parse() else { continue };
            let what = format!("SET {id} of the case control");
            let named = self.names.get(&id).map(|named| named.0);
            let Some(kind) = kinds.get(&id).copied().or(named) else {
                let became = "no request for output of nodes or elements names it";
                self.reader.reading.row(Fate::Ignored, what, 1, became);
                continue;
            };
            let words: Vec<&str> =
                list.split([',', ' ', '\t']).filter(|word| !word.is_empty()).collect();
            match IdList::parse(&words) {
                Ok(list) => self.add(&what, id, Some(kind), &list, *place),
                Err(word) => {
                    let message = format!("SET {id}: `{word}` is not expected");
                    self.reader.reading.error("set", *place, message, LIST_HELP);
                }
            }
        }
    }

    /// Adds a set. Without a kind its ids are those of nodes, unless only elements have all of
    /// them: each single id, and at least one of a range.
    fn add(
        &mut self,
        what: &str,
        id: u64,
        given: Option<SetKind>,
        list: &IdList,
        place: FilePlace,
    ) {
        let has_all =
            |known: &BTreeSet<u64>| list.single.is_subset(known) && !list.ids_of(known).is_empty();
        let kind =
            given.unwrap_or_else(|| match !has_all(&self.nodes) && has_all(&self.elements) {
                true => SetKind::Elements,
                false => SetKind::Nodes,
            });
        let named = self.names.get(&id).filter(|named| named.0 == kind);
        let name = named.map_or_else(|| format!("set_{id}"), |named| named.1.clone());
        let known = match kind {
            SetKind::Nodes => &self.nodes,
            SetKind::Elements => &self.elements,
            SetKind::Properties => &self.parts,
        };
        let missing: Vec<u64> = list.single.difference(known).copied().collect();
        let mut found = list.ids_of(known);
        let mesh = &self.reader.reading.mesh;
        if kind != SetKind::Nodes {
            let is_in = |element: &&FileElement| match kind {
                SetKind::Properties => found.contains(&u64::from(mesh.parts[element.part].id)),
                _ => found.contains(&element.id),
            };
            let elements = mesh.elements.iter().filter(is_in);
            found = elements.flat_map(|element| &element.corners).copied().collect();
        }
        let reading = &mut self.reader.reading;
        if given == Some(SetKind::Nodes) && !missing.is_empty() {
            return reading.set_lacks(&name, &missing, place);
        }
        if !missing.is_empty() {
            let became = "not read, or not in the file";
            reading.row(Fate::Ignored, format!("ids of set {name}"), missing.len(), became);
        }
        if !reading.has_room(found.len(), place) {
            return;
        }
        let found: Vec<u64> = found.into_iter().collect();
        if found.is_empty() {
            if missing.is_empty() {
                reading.row(Fate::Ignored, what, 1, "none of its ids is in the file");
            }
            return;
        }
        let sets = &mut reading.mesh.node_sets;
        if sets.get(&name) == Some(&found) {
            return;
        }
        let mut own = name.clone();
        for number in 2.. {
            if !sets.contains_key(&own) {
                break;
            }
            own = format!("{name}-{number}");
        }
        if own != name {
            let became = format!("node set {own}: another set has its name");
            reading.row(Fate::Read, what, 1, became);
        }
        reading.mesh.add_set(&own, &own, found);
    }
}

const LIST_HELP: &str = "write ids, ranges `1 THRU 9` and, after a range, `EXCEPT` with ids";

/// Returns the id and the kind of the set that a request for output names.
fn request(command: &str) -> Option<(u64, SetKind)> {
    let (head, value) = command.split_once('=')?;
    let head = head.split('(').next().unwrap_or_default().trim();
    let starts = |words: &[&str]| words.iter().any(|word| head.starts_with(word));
    let kind = match () {
        () if starts(NODAL) => SetKind::Nodes,
        () if starts(OF_ELEMENTS) => SetKind::Elements,
        () => return None,
    };
    Some((value.trim().parse().ok()?, kind))
}

/// Ids as a set lists them.
#[derive(Debug, Default, PartialEq, Eq)]
struct IdList {
    /// Ids that are listed one by one.
    single: BTreeSet<u64>,
    /// First and last id of ranges.
    ranges: Vec<(u64, u64)>,
    /// First and last id of what ranges leave out, with the number of their range.
    except: Vec<(usize, u64, u64)>,
}

impl IdList {
    /// Reads `3 7 THRU 20 EXCEPT 9 25`: an id above the range is no exception.
    ///
    /// # Errors
    /// The first word that is no part of a list.
    fn parse<'w>(words: &[&'w str]) -> Result<Self, &'w str> {
        let mut list = IdList::default();
        let mut excepts = false;
        let mut words = words.iter().copied().peekable();
        while let Some(word) = words.next() {
            if word.eq_ignore_ascii_case("ALL") {
                list.ranges.push((0, u64::MAX));
                continue;
            }
            if word.eq_ignore_ascii_case("EXCEPT") && !list.ranges.is_empty() {
                excepts = true;
                continue;
            }
            let first: u64 = word.parse().map_err(|_| word)?;
            let mut last = first;
            let is_range = words.next_if(|w| w.eq_ignore_ascii_case("THRU"));
            if let Some(thru) = is_range {
                let end = words.next().ok_or(thru)?;
                last = end.parse().map_err(|_| end)?;
            }
            let end = list.ranges.last().map_or(0, |range| range.1);
            excepts &= first <= end;
            match (excepts, is_range) {
                (true, _) => list.except.push((list.ranges.len() - 1, first, last)),
                (false, Some(_)) => list.ranges.push((first, last)),
                (false, None) => {
                    list.single.insert(first);
                }
            }
        }
        Ok(list)
    }

    /// Returns the ids of the list among those that exist.
    fn ids_of(&self, known: &BTreeSet<u64>) -> BTreeSet<u64> {
        let within = |(first, last): (u64, u64)| known.range(first..=last.max(first)).copied();
        let mut found: BTreeSet<u64> = BTreeSet::new();
        for (number, &range) in self.ranges.iter().enumerate().filter(|(_, r)| r.0 <= r.1) {
            let mut own: BTreeSet<u64> = within(range).collect();
            for &(_, first, last) in self.except.iter().filter(|except| except.0 == number) {
                for id in within((first, last)) {
                    own.remove(&id);
                }
            }
            found.append(&mut own);
        }
        found.extend(self.single.intersection(known));
        found
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ids(text: &str) -> Vec<u64> {
        let list = IdList::parse(&text.split_whitespace().collect::<Vec<_>>()).expect("a list");
        list.ids_of(&(1..=30).collect()).into_iter().collect()
    }

    /// The example of the reference guide has exceptions within a range and ids after them.
    #[test]
    fn lists_have_ranges_and_exceptions() {
        assert_eq!(ids("5 6 10 THRU 14 EXCEPT 12 13 17 19"), [5, 6, 10, 11, 14, 17, 19]);
        assert_eq!(ids("1 thru 9 except 3 thru 8 20 THRU 22"), [1, 2, 9, 20, 21, 22]);
        assert!(ids("4 THRU 1").is_empty());
        assert_eq!(ids("1 THRU 3 EXCEPT 2 9 2"), [1, 2, 3, 9]);
        assert_eq!(ids("ALL").len(), 30);
    }

    #[test]
    fn words_that_are_no_list_are_named() {
        for (words, wrong) in [
            (&["1", "2.5"][..], "2.5"),
            (&["1", "THRU"], "THRU"),
            (&["THRU", "5"], "THRU"),
            (&["1", "EXCEPT", "5"], "EXCEPT"),
            (&["1", "THRU", "x"], "x"),
            (&["-1"], "-1"),
        ] {
            assert_eq!(IdList::parse(words), Err(wrong));
        }
    }

    #[test]
    fn requests_name_the_kind_of_their_set() {
        assert_eq!(request("DISPLACEMENT(SORT1,REAL) = 5"), Some((5, SetKind::Nodes)));
        assert_eq!(request("STRESS=7"), Some((7, SetKind::Elements)));
        assert_eq!(request("DISP = ALL"), None);
        assert_eq!(request("SPC = 1"), None);
    }
}
