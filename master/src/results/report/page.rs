//! The page: a template with markers, scripts and styles, and escaped text.

use base64::{Engine, prelude::BASE64_STANDARD};
use serde::Serialize;

const TEMPLATE: &str = include_str!("../../../assets/report/page.html");
/// Sections of the page of a run next to the picture, and below it.
const OF_RUN: [&str; 2] = [
    include_str!("../../../assets/report/run_plots.html"),
    include_str!("../../../assets/report/run_figures.html"),
];
/// The same of the page of a job before its run.
const OF_MODEL: [&str; 2] = [include_str!("../../../assets/report/model.html"), ""];
const STYLE: [&str; 2] = [
    include_str!("../../../assets/vendor/uPlot.min.css"),
    include_str!("../../../assets/report/page.css"),
];
const SCRIPTS: [&str; 25] = [
    include_str!("../../../assets/vendor/three.min.js"),
    include_str!("../../../assets/vendor/uPlot.min.js"),
    include_str!("../../../assets/report/decode.js"),
    include_str!("../../../assets/report/colours.js"),
    include_str!("../../../assets/report/legend.js"),
    include_str!("../../../assets/report/coarse.js"),
    include_str!("../../../assets/report/surface.js"),
    include_str!("../../../assets/report/walls.js"),
    include_str!("../../../assets/report/keys.js"),
    include_str!("../../../assets/report/view.js"),
    include_str!("../../../assets/report/pick.js"),
    include_str!("../../../assets/report/stage.js"),
    include_str!("../../../assets/report/arrows.js"),
    include_str!("../../../assets/report/forces.js"),
    include_str!("../../../assets/report/plots.js"),
    include_str!("../../../assets/report/signal.js"),
    include_str!("../../../assets/report/histories.js"),
    include_str!("../../../assets/report/chart.js"),
    include_str!("../../../assets/report/workbench.js"),
    include_str!("../../../assets/report/figures.js"),
    include_str!("../../../assets/report/share.js"),
    include_str!("../../../assets/report/second.js"),
    include_str!("../../../assets/report/main.js"),
    include_str!("../../../assets/report/model.js"),
    include_str!("../../../assets/report/begin.js"),
];

/// Subject of a page.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum PageKind {
    /// A run, or two.
    #[default]
    Run,
    /// A job before its run.
    Model,
}

/// Content that differs between reports.
#[derive(Clone, Debug, Default)]
pub struct Content<'a> {
    /// Subject of the page.
    pub kind: PageKind,
    /// Title, as text.
    pub title: &'a str,
    /// Subtitle, as text.
    pub subtitle: &'a str,
    /// Warnings, the most severe first: number of the run, and text.
    pub warnings: &'a [(usize, String)],
    /// Omitted content, as text.
    pub left_out: &'a [String],
    /// Tables, as HTML.
    pub tables: &'a str,
    /// Data for the scripts, as JSON.
    pub facts: &'a str,
    /// The pictures of up to two runs, compressed.
    pub pictures: [&'a [u8]; 2],
    /// The histories of up to two runs, compressed.
    pub histories: [&'a [u8]; 2],
    /// Values and marks of a model before its run, compressed.
    pub setup: &'a [u8],
}

/// Returns the complete page.
pub fn page(content: &Content<'_>) -> String {
    let items =
        |all: &[String]| all.iter().map(|w| format!("<li>{}</li>", escape(w))).collect::<String>();
    let warned = |all: &[(usize, String)]| {
        all.iter().map(|(run, text)| warning(text, *run == 0)).collect::<String>()
    };
    let warnings = match content.warnings {
        [] => "<p class=\"none\">No warnings.</p>".into(),
        all => format!("<ul>{}</ul>", warned(all)),
    };
    let scripts: String =
        SCRIPTS.iter().map(|script| format!("<script>\n{script}\n</script>\n")).collect();
    let (page_kind, [aside, below], source) = match content.kind {
        PageKind::Run => ("run", OF_RUN, "the results in its folder"),
        PageKind::Model => ("model", OF_MODEL, "the job, before its run"),
    };
    fill(
        TEMPLATE,
        &[
            ("page_kind", page_kind),
            ("aside", aside),
            ("below", below),
            ("source", source),
            ("setup", &BASE64_STANDARD.encode(content.setup)),
            ("title", &escape(content.title)),
            ("subtitle", &escape(content.subtitle)),
            ("kind", if content.warnings.is_empty() { "calm" } else { "warned" }),
            ("warnings", &warnings),
            ("left_out", &items(content.left_out)),
            ("tables", content.tables),
            ("facts", content.facts),
            ("picture", &BASE64_STANDARD.encode(content.pictures[0])),
            ("histories", &BASE64_STANDARD.encode(content.histories[0])),
            ("second_picture", &BASE64_STANDARD.encode(content.pictures[1])),
            ("second_histories", &BASE64_STANDARD.encode(content.histories[1])),
            ("style", &STYLE.concat()),
            ("scripts", &scripts),
            ("version", env!("CARGO_PKG_VERSION")),
        ],
    )
}

/// Returns a warning as an item of a list, with the time that it names, so that the scripts can
/// show it; with the element or node as well if `places` is true: the first run has the pointer.
fn warning(text: &str, places: bool) -> String {
    let after = |word: &str| {
        let number = |rest: &str| {
            let end = rest.find(|c: char| !(c.is_ascii_alphanumeric() || "+-.".contains(c)));
            rest[..end.unwrap_or(rest.len())].trim_end_matches('.').parse::<f64>().ok()
        };
        let mut all = text.match_indices(word).map(|(at, _)| number(&text[at + word.len()..]));
        all.find_map(|n| n.filter(|n| n.is_finite()))
    };
    let named = [("time", "time "), ("element", "element "), ("node", "node ")];
    let data: String = named
        .into_iter()
        .take(if places { 3 } else { 1 })
        .filter_map(|(key, word)| Some(format!(" data-{key}=\"{}\"", after(word)?)))
        .collect();
    format!("<li{data}>{}</li>", escape(text))
}

/// Returns the template with each `{{name}}` replaced once. Inserted text is not searched again.
fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut out =
        String::with_capacity(template.len() + values.iter().map(|v| v.1.len()).sum::<usize>());
    let mut rest = template;
    while let Some((before, after)) = rest.split_once("{{") {
        out += before;
        let (name, after) = after.split_once("}}").unwrap_or((after, ""));
        out += values.iter().find(|v| v.0 == name).map_or("", |v| v.1);
        rest = after;
    }
    out + rest
}

/// Escapes text for HTML, inside elements and quoted attributes.
pub fn escape(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            '\'' => out += "&#39;",
            c => out.push(c),
        }
    }
    out
}

/// Returns JSON that is safe inside a script element for any strings. Numbers that are not finite
/// become null.
pub fn json(value: &impl Serialize) -> String {
    serde_json::to_string(value).unwrap_or_else(|_| "null".into()).replace('<', "\\u003c")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_marker_of_the_template_is_filled_and_what_is_put_in_is_left_alone() {
        let hostile = "</script><script>alert(1)</script> & \"{{facts}}\" '";
        let facts = json(&hostile);
        let warnings = [(0, hostile.to_owned())];
        let content = Content {
            title: hostile,
            subtitle: hostile,
            warnings: &warnings,
            facts: &facts,
            ..Content::default()
        };
        let page = page(&content);
        assert!(!page.contains("alert(1)</script> &"), "a string ends a script");
        assert_eq!(
            page.matches("&lt;script&gt;alert(1)").count(),
            4,
            "title twice, subtitle, warning"
        );
        assert!(
            page.contains(
                r#""\u003c/script>\u003cscript>alert(1)\u003c/script> & \"{{facts}}\" '""#
            )
        );
        let without = fill(TEMPLATE, &[]);
        assert!(!without.contains("{{") && !without.contains("}}"));
        for name in [
            "page_kind",
            "aside",
            "below",
            "source",
            "setup",
            "title",
            "subtitle",
            "kind",
            "warnings",
            "left_out",
            "tables",
            "facts",
            "picture",
            "histories",
            "second_picture",
            "second_histories",
            "style",
            "scripts",
        ] {
            assert!(TEMPLATE.contains(&format!("{{{{{name}}}}}")), "{name} is missing on the page");
        }
    }

    #[test]
    fn a_warning_has_its_time_and_place() {
        let text = "at time 2.500000e0 part `a`: it sinks; element 7000000000001 at (1, 2, 3). Why";
        assert!(
            warning(text, true)
                .starts_with("<li data-time=\"2.5\" data-element=\"7000000000001\">at")
        );
        assert_eq!(warning("a node 17.", true), "<li data-node=\"17\">a node 17.</li>");
        assert!(warning(text, false).starts_with("<li data-time=\"2.5\">at"));
        let bare = "an element inverts, time nan";
        assert_eq!(warning(bare, true), format!("<li>{bare}</li>"));
    }

    /// The page makes no network request: no file, font or picture has an address.
    #[test]
    fn the_page_is_whole() {
        let page = page(&Content::default());
        for word in ["src=\"", "@import", "url(http", "<link", "import("] {
            assert!(!page.contains(word), "{word}");
        }
        for script in SCRIPTS {
            assert!(!script.contains("</script"), "a script contains its end tag");
        }
        assert!(page.contains("three.js authors, MIT"), "the licence is named");
    }

    #[test]
    fn numbers_that_are_none_are_null() {
        assert_eq!(json(&[1.5, f64::NAN, f64::INFINITY]), "[1.5,null,null]");
    }
}
