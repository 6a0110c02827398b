//! Tables of the page from any content of `summary.json`, with its own keys as names.

use super::page::escape;
use serde_json::{Map, Value};

/// Keys that appear elsewhere on the page.
const ELSEWHERE: [&str; 2] = ["title", "walls"];
/// Keys that come first if they exist, in this order.
const FIRST: [&str; 14] = [
    "status",
    "reason",
    "id",
    "name",
    "end_time",
    "cycles",
    "nodes",
    "elements",
    "workers",
    "transport",
    "wall_s",
    "mean",
    "max",
    "law",
];

/// Returns the tables as HTML. The single values have the title `first`.
pub fn tables(summary: &Map<String, Value>, first: &str) -> String {
    let keys = || ordered(summary).into_iter().filter(|k| !ELSEWHERE.contains(k));
    let mut out = String::new();
    let single: Vec<_> = keys().filter(|k| !is_table(&summary[*k])).collect();
    out += &table(first, &pairs(single.into_iter().map(|k| (k, &summary[k]))));
    for key in keys().filter(|k| is_table(&summary[*k])) {
        let body = match &summary[key] {
            Value::Object(map) if map.values().all(Value::is_object) && !map.is_empty() => {
                grid(map.iter().map(|(name, row)| (Some(name.as_str()), row)))
            }
            Value::Object(map) => pairs(ordered(map).into_iter().map(|k| (k, &map[k]))),
            Value::Array(rows) => grid(rows.iter().map(|row| (None, row))),
            _ => String::new(),
        };
        out += &table(&words(key), &body);
    }
    out
}

/// Returns true for objects and for lists of objects.
fn is_table(value: &Value) -> bool {
    match value {
        Value::Object(_) => true,
        Value::Array(rows) => !rows.is_empty() && rows.iter().all(Value::is_object),
        _ => false,
    }
}

fn ordered(map: &Map<String, Value>) -> Vec<&str> {
    let mut keys: Vec<&str> = map.keys().map(String::as_str).collect();
    keys.sort_by_key(|key| FIRST.iter().position(|first| first == key).unwrap_or(FIRST.len()));
    keys
}

fn table(title: &str, body: &str) -> String {
    format!(
        "<section class=\"table\"><h3>{}</h3>\
         <div class=\"wide\"><table>{body}</table></div></section>\n",
        escape(title)
    )
}

fn pairs<'a>(rows: impl Iterator<Item = (&'a str, &'a Value)>) -> String {
    let row = |(key, value): (&str, &Value)| {
        format!("<tr><th scope=\"row\">{}</th>{}</tr>", escape(&words(key)), cell(value))
    };
    rows.map(row).collect()
}

/// Returns a table with a row for each object. Its columns are the keys of all objects.
fn grid<'a>(rows: impl Iterator<Item = (Option<&'a str>, &'a Value)>) -> String {
    let rows: Vec<_> = rows.collect();
    let mut all = Map::new();
    for object in rows.iter().filter_map(|row| row.1.as_object()) {
        all.extend(object.iter().map(|(k, _)| (k.clone(), Value::Null)));
    }
    let columns = ordered(&all);
    let named = rows.iter().any(|row| row.0.is_some());
    let corner = if named { "<td></td>" } else { "" };
    let head: String =
        columns.iter().map(|c| format!("<th scope=\"col\">{}</th>", escape(&words(c)))).collect();
    let row = |(name, object): &(Option<&str>, &Value)| {
        let name =
            name.map_or(String::new(), |n| format!("<th scope=\"row\">{}</th>", escape(&words(n))));
        let cells: String =
            columns.iter().map(|c| cell(object.get(*c).unwrap_or(&Value::Null))).collect();
        format!("<tr>{name}{cells}</tr>")
    };
    let body: String = rows.iter().map(row).collect();
    format!("<thead><tr>{corner}{head}</tr></thead><tbody>{body}</tbody>")
}

/// Returns `phase_s` as `phase [s]`, `wall_ns` likewise.
fn words(key: &str) -> String {
    for unit in ["s", "ns"] {
        if let Some(name) = key.strip_suffix(&format!("_{unit}")) {
            return format!("{} [{unit}]", name.replace('_', " "));
        }
    }
    key.replace('_', " ")
}

fn cell(value: &Value) -> String {
    let class = if value.is_number() { " class=\"number\"" } else { "" };
    format!("<td{class}>{}</td>", escape(&text(value)))
}

fn text(value: &Value) -> String {
    match value {
        Value::Null => "–".into(),
        Value::Bool(true) => "yes".into(),
        Value::Bool(false) => "no".into(),
        Value::String(s) => s.clone(),
        Value::Number(n) => {
            n.as_f64().filter(|_| !n.is_i64() && !n.is_u64()).map_or(n.to_string(), short)
        }
        Value::Array(items) if items.iter().any(Value::is_object) => items.len().to_string(),
        Value::Array(items) => items.iter().map(text).collect::<Vec<_>>().join(", "),
        Value::Object(map) => map
            .iter()
            .map(|(k, v)| format!("{} {}", text(v), words(k)))
            .collect::<Vec<_>>()
            .join(", "),
    }
}

/// Formats a number with five digits, with an exponent if it would have many zeros.
pub fn short(number: f64) -> String {
    let size = number.abs();
    if number == 0.0 {
        return "0".into();
    }
    if !(1e-3..1e6).contains(&size) {
        return format!("{number:.4e}");
    }
    let digits = (4.0 - size.log10().floor()).max(0.0) as usize;
    let fixed = format!("{number:.digits$}");
    match fixed.contains('.') {
        true => fixed.trim_end_matches('0').trim_end_matches('.').into(),
        false => fixed,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn everything_of_a_summary_is_there_and_escaped() {
        let summary = json!({
            "zeta": 1.0, "status": "failed", "reason": "element <7> & \"more\"", "title": "twice",
            "energy": { "kinetic": 1234567.0, "error": 0.0001 },
            "phase_s": {
                "elements": { "max": 2.0, "mean": 1.5 },
                "halo": { "max": 0.25, "mean": 0.125 }
            },
            "parts": [
                {
                    "law": "j2", "name": "<b>A&B</b>", "id": 1, "pieces": [{ "elements": 3 }],
                    "contact_near": null
                },
                { "id": 2, "name": "x", "law": "elastic", "rigid": true }
            ],
            "elements": { "quad4": 3 }
        });
        let html = tables(summary.as_object().unwrap(), "Run");
        for part in [
            "<tr><th scope=\"row\">status</th><td>failed</td></tr><tr><th scope=\"row\">reason</th>\
             <td>element &lt;7&gt; &amp; &quot;more&quot;</td></tr>",
            "<td class=\"number\">1.2346e6</td>",
            "<h3>phase [s]</h3>",
            "<tr><th scope=\"row\">halo</th><td class=\"number\">0.125</td>\
             <td class=\"number\">0.25</td></tr>",
            "<td class=\"number\">1</td><td>&lt;b&gt;A&amp;B&lt;/b&gt;</td><td>j2</td>",
            "<th scope=\"row\">quad4</th><td class=\"number\">3</td>",
        ] {
            assert!(html.contains(part), "no {part} in {html}");
        }
        assert!(!html.contains("twice") && !html.contains("<b>"), "{html}");
        assert_eq!(tables(&Map::new(), "Run").matches("<table>").count(), 1);
    }

    #[test]
    fn numbers_have_five_digits() {
        let numbers = [0.0, 1.0, 65.8, 0.012345678, -123456.7, 1e6, 2.5e-4, 999999.9];
        let all: Vec<String> = numbers.map(short).to_vec();
        assert_eq!(
            all,
            ["0", "1", "65.8", "0.012346", "-123457", "1.0000e6", "2.5000e-4", "1000000"]
        );
    }
}
