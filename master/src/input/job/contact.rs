//! `[contact]` and its interfaces: list form and checks.

use super::laws;
use super::resolve::NumberChecks;
use super::tree::{Entry, Node, NodeContent};
use super::validate::nearest;
use crumple_proto::job::{ContactInput, Interface, Job};
use crumple_proto::problem::Problem;

/// Converts the list `[[contact]]` to `[contact]`, with the other entries of the list as its
/// interfaces. Values keep their places.
pub fn from_list(tree: &mut Node) {
    let NodeContent::Table(keys) = &mut tree.kind else { return };
    let Some(entry) = keys.get_mut("contact") else { return };
    let NodeContent::Array(list) = &mut entry.node.kind else { return };
    if !list.iter().all(|node| matches!(node.kind, NodeContent::Table(_))) {
        return; // the check against the schema reports it
    }
    let mut list = std::mem::take(list).into_iter();
    let Some(mut first) = list.next() else {
        keys.remove("contact");
        return;
    };
    let NodeContent::Table(own) = &mut first.kind else { return };
    let interfaces: Vec<Node> = list.collect();
    if !interfaces.is_empty() {
        let at = interfaces[0].place;
        let all = own.entry("interface".into()).or_insert_with(|| Entry {
            key: at,
            node: Node { kind: NodeContent::Array(Vec::new()), place: at },
        });
        if let NodeContent::Array(all) = &mut all.node.kind {
            all.extend(interfaces);
        }
    }
    entry.node = first;
}

/// Checks ranges, and words against the tables of the worker.
pub(super) fn check(contact: &ContactInput, job: &Job, numbers: &mut NumberChecks<'_>) {
    numbers.word("contact.search", &contact.search, &laws::searches());
    numbers.word("contact.weighting", &contact.weighting, &["shape", "mass"]);
    numbers.word("contact.surface", &contact.surface, &["flat", "smooth"]);
    numbers.word("contact.impact", &contact.impact, &["end_of_step", "moving_surface"]);
    numbers.word("contact.choice", &contact.choice, &["gap", "node_normal"]);
    numbers.word("contact.push_back", &contact.push_back, &["own_face", "last_face"]);
    check_surface(contact, numbers);
    let limit = contact.thickness_limit;
    numbers.need(
        limit >= 0.0,
        "contact.thickness_limit",
        limit,
        "0 (for none) or above; 1 is usual",
    );
    numbers.need(contact.skin >= 0.0, "contact.skin", contact.skin, "0 (for the default) or above");
    let said: Vec<String> = std::iter::once("contact".to_string())
        .chain((0..contact.interface.len()).map(|i| format!("contact.interface.{i}")))
        .collect();
    for (i, (path, one)) in said.iter().zip(contact.each()).enumerate() {
        // Inherited values are reported only where they are written.
        let own = i.checked_sub(1).and_then(|i| toml::Table::try_from(&contact.interface[i]).ok());
        check_one(path, &one, |key| own.as_ref().is_none_or(|own| own.contains_key(key)), numbers);
    }
    let conflict = |c: &ContactInput| {
        let law = laws::contact_law(&c.law)?;
        let values = law.values(c);
        if values.missing().next().is_some() {
            None
        } else {
            (law.conflict)(&values, job.time.safety)
        }
    };
    if let Some(problem) = contact.each().find_map(|c| conflict(&c)) {
        numbers.findings.add(problem);
    }
    if contact.interface.len() >= usize::from(u16::MAX) {
        let message = format!("{} interfaces are too many", contact.interface.len());
        numbers.findings.add(Problem::error("contact.interface", message, "give at most 65534"));
    }
    if numbers.findings.any_faulty_below("part") {
        return;
    }
    let lists = |path: &str, parts: &[u32], against: &[u32], exclude: &[u32]| {
        [("parts", parts), ("against", against), ("exclude", exclude)]
            .into_iter()
            .flat_map(|(key, list)| {
                list.iter().enumerate().map(move |(i, id)| (format!("{key}.{i}"), *id))
            })
            .map(|(key, id)| (format!("{path}.{key}"), id))
            .collect::<Vec<_>>()
    };
    let mut named = lists("contact", &contact.parts, &contact.against, &contact.exclude);
    for (path, i) in said[1..].iter().zip(&contact.interface) {
        let Interface { parts, against, exclude, .. } = i;
        named.extend(lists(path, parts, against, exclude));
    }
    for (path, id) in named {
        if !job.part.iter().any(|p| p.id == id) {
            let known: Vec<String> = job.part.iter().map(|p| p.id.to_string()).collect();
            let known: Vec<&str> = known.iter().map(String::as_str).collect();
            let message = format!("contact: there is no part {id}");
            numbers.findings.add(Problem::error(path, message, nearest(&id.to_string(), &known)));
        }
    }
    hidden(contact, job, &said, numbers);
}

/// Refuses a smooth surface with what computes with the mesh.
fn check_surface(contact: &ContactInput, numbers: &mut NumberChecks<'_>) {
    if contact.surface != "smooth" {
        return;
    }
    let mut refuse = |what: &str, help: &str| {
        let message = format!("a smooth surface does not work with {what}");
        numbers.findings.add(Problem::error("contact.surface", message, help));
    };
    if contact.each().any(|c| c.law == "mortar") {
        refuse("contact law mortar", "choose another law, or surface = \"flat\"");
    }
    if contact.impact == "moving_surface" {
        refuse("impact = \"moving_surface\"", "choose impact = \"end_of_step\"");
    }
    if contact.push_back == "last_face" {
        refuse("push_back = \"last_face\"", "choose push_back = \"own_face\"");
    }
}

/// Warns of each interface that applies to no pair of parts: later interfaces name all its pairs,
/// or it names no parts.
fn hidden(contact: &ContactInput, job: &Job, said: &[String], numbers: &mut NumberChecks<'_>) {
    let all: Vec<ContactInput> = contact.each().collect();
    let ids: Vec<u32> = job.part.iter().map(|p| p.id).collect();
    let mut last = vec![0; ids.len() * ids.len()];
    for (i, c) in all.iter().enumerate().skip(1) {
        let [ahead, behind] = c.sides(&ids);
        for (&a, &b) in ahead.iter().flat_map(|a| behind.iter().map(move |b| (a, b))) {
            last[a * ids.len() + b] = i;
            if !c.one_way {
                last[b * ids.len() + a] = i;
            }
        }
    }
    for (i, path) in said.iter().enumerate().skip(1) {
        if !last.contains(&i) {
            let what =
                if all[i].name.is_empty() { String::new() } else { format!(" `{}`", all[i].name) };
            let message = format!("no pair of parts uses the interface{what}");
            let help = "the last interface that names two parts applies to them: put it after the \
                        others, or remove it";
            numbers.findings.add(Problem::warning(path.clone(), message, help));
        }
    }
}

/// Checks one interface. `is_own` returns true for the keys that are written for this interface.
fn check_one(
    path: &str,
    contact: &ContactInput,
    is_own: impl Fn(&str) -> bool,
    numbers: &mut NumberChecks<'_>,
) {
    let at = |key: &str| format!("{path}.{key}");
    let laws: Vec<&str> = laws::contact_laws().into_iter().chain([ContactInput::NO_LAW]).collect();
    if is_own("law") {
        numbers.word(&at("law"), &contact.law, &laws);
    }
    for row in laws::contact_law(&contact.law)
        .filter(|_| is_own("law"))
        .into_iter()
        .flat_map(|law| law.values(contact).missing().collect::<Vec<_>>())
    {
        let message = format!("{path}: law \"{}\" has no `{}`", contact.law, row.key);
        let help = format!("add `{} = ...`: {}", row.key, row.meaning);
        numbers.findings.add(Problem::error(at(row.key), message, help));
    }
    for (row, _) in laws::contact_keys().into_iter().filter(|(row, _)| is_own(row.key)) {
        numbers.setting(path, row, contact.parameters.get(row.key));
    }
    let mut need = |right: bool, key: &str, value: f64, wanted: &str| {
        numbers.need(right || !is_own(key), &at(key), value, wanted);
    };
    let is_some = |x: f64| x >= 0.0 && x.is_finite();
    need(is_some(contact.friction), "friction", contact.friction, "0 or above");
    let dynamic = contact.friction_dynamic.unwrap_or(0.0);
    need(is_some(dynamic), "friction_dynamic", dynamic, "0 or above");
    need(is_some(contact.friction_decay), "friction_decay", contact.friction_decay, "0 or above");
    let limit = contact.friction_limit.unwrap_or(0.0);
    need(is_some(limit), "friction_limit", limit, "above 0, or 0 for none");
    let given = contact.thickness.unwrap_or(1.0);
    need(given > 0.0 && given.is_finite(), "thickness", given, "above 0");
    let factor = contact.thickness_scale;
    need(factor > 0.0 && factor.is_finite(), "thickness_scale", factor, "above 0; 1 is usual");
    need(!contact.birth.is_nan(), "birth", contact.birth, "a time");
    let death = contact.death.unwrap_or(f64::INFINITY);
    need(death > contact.birth, "death", death, "later than `birth`");
    need(death > contact.birth || is_own("death"), "birth", contact.birth, "before `death`");
    if contact.one_way && is_own("one_way") {
        check_one_way(&at("one_way"), contact, numbers);
    }
    if is_own("friction_table") {
        check_friction_table(&at("friction_table"), contact, is_own("friction"), numbers);
    }
}

/// Refuses contact of one direction without two sides, and in a law without nodes.
fn check_one_way(path: &str, contact: &ContactInput, numbers: &mut NumberChecks<'_>) {
    let mut refuse = |message: &str, help: &str| {
        numbers.findings.add(Problem::error(path, message, help));
    };
    if contact.against.is_empty() {
        refuse(
            "`one_way` needs two sides",
            "name in `against` the parts whose faces hold the nodes of `parts`",
        );
    }
    if contact.law == "mortar" {
        refuse(
            "law \"mortar\" has no `one_way`: it holds faces against faces",
            "choose another law, or remove `one_way`",
        );
    }
}

/// Checks the coefficients of friction by pressure and speed. `is_constant_own` is true if
/// `friction` is written for the same interface.
fn check_friction_table(
    path: &str,
    contact: &ContactInput,
    is_constant_own: bool,
    numbers: &mut NumberChecks<'_>,
) {
    let rows = &contact.friction_table;
    let mut report = |row: usize, message: String, help: &str| {
        numbers.findings.add(Problem::error(format!("{path}.{row}"), message, help));
    };
    for (i, row) in rows.iter().enumerate() {
        if !row.iter().all(|x| *x >= 0.0 && x.is_finite()) {
            let message = format!("`friction_table` has the row {row:?}");
            report(i, message, "a row is [pressure, speed, coefficient], each 0 or above");
        }
    }
    for (i, two) in rows.windows(2).enumerate() {
        let [a, b] = [&two[0], &two[1]];
        if b[0] < a[0] || b[0] == a[0] && b[1] <= a[1] {
            let message = format!("`friction_table`: the row {b:?} follows {a:?}");
            let help = "sort the rows by pressure, and those of one pressure by speed; each speed \
                        once";
            report(i + 1, message, help);
        }
    }
    if !rows.is_empty() && is_constant_own && contact.friction > 0.0 {
        let message = "`friction` and `friction_table` are both given".to_string();
        report(0, message, "remove one of them: the table replaces the coefficients");
    }
}
