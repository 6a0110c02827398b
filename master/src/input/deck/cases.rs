//! Cases of a deck: `*CASE`, and keywords between `*CASE_BEGIN_n` and `*CASE_END_n` or with `CID=n`
//! on their line, which belong to subcase n. One case is read; keywords of no subcase belong to
//! all.
//!
//! Blocks of subcases may nest and overlap: a keyword belongs to all that are open. Without
//! `*CASE` each subcase is a case of its own.

use super::Mapping;
use super::diagnostics::Trouble;
use super::fields::{CardFormat, split};
use super::keywords;
use super::number;
use super::parameters::DeckParameters;
use super::record::{CardRecord, Cards};
use super::table::Card;
use super::text::{KeywordBlock, Texts};
use crate::input::job::tree::Place;
use std::collections::{BTreeMap, BTreeSet};

/// Subcases by number, with the place where each is named first.
type Subcases = BTreeMap<i64, Place>;

/// A case of `*CASE`.
struct Case {
    /// Name of the job, for messages.
    job: String,
    subcases: BTreeSet<i64>,
    place: Place,
}

/// Reports a case that is chosen from a deck without cases.
pub fn report_none(wanted: Option<u64>, trouble: &mut Trouble) {
    if let Some(case) = wanted {
        let message = format!("the deck has no cases, and case {case} is chosen");
        trouble.error(Place::Whole, message, "remove --case, and mesh.case from the job");
    }
}

/// Keeps the keywords of one case: that of `wanted`, or the only one. Returns the choice for the
/// mapping, if the deck has cases.
pub fn select(texts: &mut Texts, wanted: Option<u64>, trouble: &mut Trouble) -> Option<Mapping> {
    let is_case = |block: &KeywordBlock| block.name == "CASE" || block.name.starts_with("CASE_");
    let marked = |block: &KeywordBlock| subcase_on_line(&head(texts, block)).is_some();
    let Some(first) = texts.blocks.iter().find(|block| is_case(block) || marked(block)) else {
        report_none(wanted, trouble);
        return None;
    };
    let first = first.place();
    let (members, named) = members(texts, trouble);
    let cases = cases(texts, &named, trouble);
    let Some((id, case)) = choose(&cases, wanted, first, trouble) else {
        // Other problems depend on the choice.
        trouble.unsure();
        texts.blocks.clear();
        return None;
    };
    for (&subcase, &place) in &named {
        if !cases.values().any(|case| case.subcases.contains(&subcase)) {
            let message = format!("subcase {subcase} belongs to no *CASE");
            trouble.warning(place, message, "its keywords are not read: add it to a *CASE");
        }
    }
    let of_case = |of: &BTreeSet<i64>| of.is_empty() || !of.is_disjoint(&case.subcases);
    let mut members = members.iter();
    // New numbers of files of *INCLUDE_TRANSFORM; 0 for those of other cases, and outside of them.
    let mut numbers = vec![0];
    texts.blocks.retain_mut(|block| {
        let number = numbers.get(block.submodel as usize).copied().unwrap_or(0);
        let stays = members.next().is_some_and(of_case) && (block.submodel == 0 || number > 0);
        block.submodel = number;
        if block.name == "INCLUDE_TRANSFORM" {
            let next = 1 + numbers.iter().max().copied().unwrap_or(0);
            numbers.push(if stays { next } else { 0 });
        }
        stays && !is_case(block)
    });
    let list: Vec<String> = case.subcases.iter().map(i64::to_string).collect();
    let used = format!("keywords of the subcases {}, and those of no subcase", list.join(", "));
    Some(Mapping { of: "deck".into(), asked: format!("case {}", shown(id, case)), used })
}

/// Returns the subcases of each block, and all that blocks have.
fn members(texts: &Texts, trouble: &mut Trouble) -> (Vec<BTreeSet<i64>>, Subcases) {
    let (mut open, mut named) = (Subcases::new(), Subcases::new());
    let mut members = Vec::with_capacity(texts.blocks.len());
    for block in &texts.blocks {
        let place = block.place();
        let marker = ["CASE_BEGIN", "CASE_END"]
            .into_iter()
            .find_map(|word| block.name.strip_prefix(word).map(|rest| (word, number_of(rest))));
        match marker {
            Some((word, None)) => {
                let message = format!("*{} has no number of a subcase", block.name);
                trouble.error(place, message, format!("write *{word}_n with a number n above 0"));
            }
            Some(("CASE_BEGIN", Some(n))) => {
                named.entry(n).or_insert(place);
                if open.insert(n, place).is_some() {
                    let message = format!("subcase {n} begins again before it ends");
                    trouble.error(place, message, format!("write *CASE_END_{n} above this line"));
                }
            }
            Some((_, Some(n))) if open.remove(&n).is_none() => {
                let message = format!("subcase {n} ends, but it has not begun");
                let help = format!("write *CASE_BEGIN_{n} above it, or remove this line");
                trouble.error(place, message, help);
            }
            None if block.name.starts_with("CASE_") => {
                let message = format!("*{} is not supported", block.name);
                let help = "cases have the keywords *CASE, *CASE_BEGIN_n and *CASE_END_n: remove \
                            this one, or correct its name";
                trouble.error(place, message, help);
            }
            _ => {}
        }
        let mut of: BTreeSet<i64> = open.keys().copied().collect();
        match subcase_on_line(&head(texts, block)) {
            Some(Ok(n)) => {
                named.entry(n).or_insert(place);
                of.insert(n);
            }
            Some(Err(given)) => {
                let message = format!("*{}: CID is `{given}`, not a number above 0", block.name);
                trouble.error(place, message, "write CID=n with the number n of its subcase");
            }
            None => {}
        }
        members.push(of);
    }
    for (n, place) in open {
        let help = format!("write *CASE_END_{n} after its last keyword");
        trouble.error(place, format!("subcase {n} does not end"), help);
    }
    (members, named)
}

/// Returns the number after the underscore of a name.
fn number_of(rest: &str) -> Option<i64> {
    number::integer(rest.strip_prefix('_')?.as_bytes()).filter(|n| *n > 0)
}

/// Returns the line of a keyword.
fn head(texts: &Texts, block: &KeywordBlock) -> String {
    String::from_utf8_lossy(texts.line(block, block.head)).into_owned()
}

/// Returns the subcase of `CID=n` on the line of a keyword, or its text if that is no number above
/// 0; `None` without `CID`.
pub fn subcase_on_line(line: &str) -> Option<Result<i64, String>> {
    let spaced = line.to_ascii_uppercase().replace('=', " = ");
    let words = spaced.split(|c: char| c.is_ascii_whitespace() || c == ',');
    let mut words = words.skip(1).filter(|word| !word.is_empty());
    words.find(|word| *word == "CID")?;
    let given = words.find(|word| *word != "=").unwrap_or_default();
    let number = number::integer(given.as_bytes()).filter(|n| *n > 0);
    Some(number.ok_or_else(|| given.to_string()))
}

/// Reads the cards of `*CASE`: id and name of the job, then a command line, then subcases. Without
/// any, each subcase is a case.
fn cases(texts: &Texts, named: &Subcases, trouble: &mut Trouble) -> BTreeMap<i64, Case> {
    let mut cases = BTreeMap::new();
    for block in texts.blocks.iter().filter(|block| block.name == "CASE") {
        let Some((row, _)) = keywords::find(&block.name) else { continue };
        let parameters = DeckParameters::default();
        let records = Cards::of(texts, &parameters, trouble).records(row, &[], block);
        for record in &records {
            let id = record.integer("caseid");
            if id <= 0 {
                if !record.is_blank("caseid") {
                    let help = "write a whole number above 0";
                    trouble.error(record.place("caseid"), format!("*CASE has the id {id}"), help);
                }
                continue;
            }
            let subcases = subcases(texts, block, record, trouble);
            let case = Case { job: record.word("jobid").into(), subcases, place: block.place() };
            if cases.insert(id, case).is_some() {
                let message = format!("case {id} is defined twice");
                trouble.error(block.place(), message, "remove one, or renumber it");
            }
        }
    }
    if cases.is_empty() {
        let of = |(&n, &place): (&i64, &Place)| {
            (n, Case { job: String::new(), subcases: BTreeSet::from([n]), place })
        };
        cases.extend(named.iter().map(of));
    }
    cases
}

/// Returns the subcases of a case, its own number if it has no others. The command line before
/// them may be missing.
fn subcases(
    texts: &Texts,
    block: &KeywordBlock,
    record: &CardRecord,
    trouble: &mut Trouble,
) -> BTreeSet<i64> {
    let id = record.integer("caseid");
    let mut subcases: BTreeSet<i64> =
        record.lines("scid").flat_map(|line| line.integers("scid").map(|(n, _)| n)).collect();
    let second = block.lines.get(1).map_or(&[][..], |&line| texts.line(block, line));
    let mut words = second.split(|b| b.is_ascii_whitespace() || *b == b',');
    if !words.all(|word| word.is_empty() || number::integer(word).is_some()) {
        let message = format!("case {id}: its command line is not used");
        trouble.warning(record.place("commands"), message, "give options to `crumple run`");
    } else {
        let mut cards = record.row.cards.iter().map(|(card, _)| card);
        let card = cards.rfind(|card| card.index("scid").is_some());
        match card.and_then(|card| numbers(second, card, block.format)) {
            Some(more) => subcases.extend(more),
            None => {
                let message = format!("case {id}: its subcases are not in their columns");
                let help = "write whole numbers, ten columns each, or with commas between them";
                trouble.error(record.place("commands"), message, help);
            }
        }
    }
    subcases.remove(&0);
    if subcases.is_empty() {
        subcases.insert(id);
    }
    subcases
}

/// Returns the numbers of a line by the columns of a card; `None` if there is other text.
fn numbers(line: &[u8], card: &Card, format: CardFormat) -> Option<Vec<i64>> {
    let fields = split(line, card, format);
    let texts = (0..fields.count()).map(|index| fields.text(line, index));
    texts.filter(|text| !text.is_empty()).map(number::integer).collect()
}

/// Returns the case that is read; an error lists all if it is not clear which. `mark` is the place
/// of the first keyword of cases.
fn choose<'c>(
    cases: &'c BTreeMap<i64, Case>,
    wanted: Option<u64>,
    mark: Place,
    trouble: &mut Trouble,
) -> Option<(i64, &'c Case)> {
    let Some(first) = cases.iter().next() else {
        let help = "write *CASE with its id, or *CASE_BEGIN_n and *CASE_END_n around the keywords \
                    of a subcase n";
        trouble.error(mark, "the deck has keywords of cases, but no case", help);
        return None;
    };
    let list: Vec<String> = cases.iter().map(|(&id, case)| shown(id, case)).collect();
    let list = list.join(", ");
    let help = format!("choose one with --case N, or with mesh.case = N in a job: {list}");
    match wanted {
        None if cases.len() == 1 => Some((*first.0, first.1)),
        None => {
            let message = format!("the deck has {} cases, and none is chosen", cases.len());
            trouble.error(first.1.place, message, help);
            None
        }
        Some(wanted) => {
            let found = i64::try_from(wanted).ok().and_then(|id| cases.get_key_value(&id));
            if found.is_none() {
                trouble.error(first.1.place, format!("the deck has no case {wanted}"), help);
            }
            found.map(|(&id, case)| (id, case))
        }
    }
}

/// Returns the id of a case and the name of its job.
fn shown(id: i64, case: &Case) -> String {
    if case.job.is_empty() { id.to_string() } else { format!("{id} ({})", case.job) }
}
