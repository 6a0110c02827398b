//! The page: a template with markers, scripts and styles, and escaped text.

use base64::{Engine, prelude::BASE64_STANDARD};
use serde::Serialize;

const TEMPLATE: &str = include_str!("../../../assets/report/page.html");
const STYLE: [&str; 2] = [
    include_str!("../../../assets/vendor/uPlot.min.css"),
    include_str!("../../../assets/report/page.css"),
];
const SCRIPTS: [&str; 11] = [
    include_str!("../../../assets/vendor/three.min.js"),
    include_str!("../../../assets/vendor/uPlot.min.js"),
    include_str!("../../../assets/report/decode.js"),
    include_str!("../../../assets/report/colours.js"),
    include_str!("../../../assets/report/legend.js"),
    include_str!("../../../assets/report/surface.js"),
    include_str!("../../../assets/report/walls.js"),
    include_str!("../../../assets/report/keys.js"),
    include_str!("../../../assets/report/view.js"),
    include_str!("../../../assets/report/plots.js"),
    include_str!("../../../assets/report/main.js"),
];

/// Content that differs between reports.
#[derive(Clone, Debug, Default)]
pub struct Content<'a> {
    /// Title, as text.
    pub title: &'a str,
    /// Subtitle, as text.
    pub subtitle: &'a str,
    /// Warnings, the most severe first, as text.
    pub warnings: &'a [String],
    /// Omitted content, as text.
    pub left_out: &'a [String],
    /// Tables, as HTML.
    pub tables: &'a str,
    /// Data for the scripts, as JSON.
    pub facts: &'a str,
    /// The picture, compressed.
    pub picture: &'a [u8],
}

/// Returns the complete page.
pub fn page(content: &Content<'_>) -> String {
    let items =
        |all: &[String]| all.iter().map(|w| format!("<li>{}</li>", escape(w))).collect::<String>();
    let warnings = match content.warnings {
        [] => "<p class=\"none\">No warnings.</p>".into(),
        all => format!("<ul>{}</ul>", items(all)),
    };
    let scripts: String =
        SCRIPTS.iter().map(|script| format!("<script>\n{script}\n</script>\n")).collect();
    fill(
        TEMPLATE,
        &[
            ("title", &escape(content.title)),
            ("subtitle", &escape(content.subtitle)),
            ("kind", if content.warnings.is_empty() { "calm" } else { "warned" }),
            ("warnings", &warnings),
            ("left_out", &items(content.left_out)),
            ("tables", content.tables),
            ("facts", content.facts),
            ("picture", &BASE64_STANDARD.encode(content.picture)),
            ("style", &STYLE.concat()),
            ("scripts", &scripts),
            ("version", env!("CARGO_PKG_VERSION")),
        ],
    )
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
        let warnings = [hostile.to_owned()];
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
            "title", "subtitle", "kind", "warnings", "left_out", "tables", "facts", "picture",
            "style", "scripts",
        ] {
            assert!(TEMPLATE.contains(&format!("{{{{{name}}}}}")), "{name} is missing on the page");
        }
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
