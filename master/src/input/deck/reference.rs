//! The table of keywords as a page; a test keeps `cases/DECKS.md` equal to it.

use super::keywords::{DIVISION, FAMILIES, OUTPUT};
use super::table::{Card, Effect, Field, FieldFate, FieldType, Keyword, Times};
use std::fmt::Write;

/// Text above the table.
const HEAD: &str = include_str!("reference_head.md");

/// Returns the page.
pub fn page() -> String {
    let mut page = String::from(HEAD);
    // Writing to a string cannot fail.
    let _ = write(&mut page);
    page
}

/// Families of keywords with their names.
pub type Families = &'static [(&'static str, &'static [Keyword])];

fn write(page: &mut String) -> std::fmt::Result {
    tables(page, FAMILIES)?;
    let output: Vec<String> = OUTPUT.iter().map(|o| format!("`{o}`")).collect();
    writeln!(
        page,
        "\nOther keywords that begin with {} request output,\nand those that begin with \
         `{DIVISION}` divide the model among processes;\neach gives a warning.",
        output.join(", ")
    )?;
    writeln!(
        page,
        "Every other keyword is an error that names its line; `--allow-unsupported` ignores it \
         with a\nwarning."
    )
}

/// Writes one table for each family.
pub fn tables(page: &mut String, families: Families) -> std::fmt::Result {
    for (family, keywords) in families {
        writeln!(
            page,
            "\n### {family}\n\n| keyword | result | fields that are read |\n|---|---|---|"
        )?;
        for keyword in *keywords {
            let mut names: Vec<String> = vec![format!("`{}`", keyword.name)];
            names.extend(keyword.aliases.iter().map(|a| format!("`{a}`")));
            let mut name = names.join(" ");
            let options: Vec<String> = keyword.options.iter().map(|o| format!("_{o}")).collect();
            if keyword.name.starts_with('/') && !options.is_empty() {
                name += " and further words";
            } else if !options.is_empty() {
                name += &format!(" ({})", options.join(" "));
            }
            let note = match keyword.effect {
                Effect::Model => format!("{}{}", keyword.note, unused(keyword)),
                Effect::Harmless => format!("warning: {}", keyword.note),
                Effect::NotYet => format!("**not supported yet**: {}", keyword.note),
            };
            let cards: Vec<String> =
                keyword.cards.iter().map(|(card, times)| fields(card, *times)).collect();
            writeln!(
                page,
                "| {name} | {} | {} |",
                note.replace("         ", ""),
                cards.join(" / ")
            )?;
        }
    }
    Ok(())
}

/// Returns the fields that are not converted, with their fates.
fn unused(keyword: &Keyword) -> String {
    let fate = |fate| match fate {
        FieldFate::NoEffect => "no effect",
        FieldFate::Ignored => "**ignored with a warning**",
        FieldFate::Refused => "**not supported**",
    };
    let line =
        |u: &super::table::UnusedFields| format!(" {}: {} ({})", u.names, fate(u.fate), u.why);
    match keyword.unused {
        [] => String::new(),
        list => {
            let lines: Vec<String> = list.iter().map(line).collect();
            format!(". Not converted:{}", lines.join(";"))
        }
    }
}

/// Returns a card's fields, with widths other than ten and defaults other than zero; in brackets
/// if the card is optional.
fn fields(card: &str, times: Times) -> String {
    let name = |f: &Field| {
        let width = if f.width == 10 || f.kind == FieldType::Line {
            String::new()
        } else {
            format!(":{}", f.width)
        };
        let default = if f.default == 0.0 { String::new() } else { format!("={:?}", f.default) };
        format!("{}{width}{}", f.name, default.trim_end_matches(".0"))
    };
    let mut names: Vec<String> = Card::parse(card).fields.iter().map(name).collect();
    names.dedup();
    let text = names.join(" ");
    match times {
        Times::Once => text,
        Times::Maybe | Times::Count(_) | Times::AtMost(_) => format!("[{text}]"),
        Times::Rest => format!("{text} ..."),
    }
}
