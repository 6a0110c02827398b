//! Writes contact and its interfaces, each as a card with sets of its parts. Keys without a field
//! on the card, such as laws, are written after `$crumple:` with the name of the interface.

use super::{Blank, CardValue, DeckWriter, Id, LeftReason, Number, differing, line, named};
use crumple_proto::job::{ContactInput, Interface, Job};
use std::collections::BTreeSet;
use toml::{Table, Value};

/// Keys of `[contact]` and of interfaces that cards hold.
const CARRIED: [&str; 12] = [
    "name",
    "parts",
    "against",
    "exclude",
    "friction",
    "friction_dynamic",
    "friction_decay",
    "friction_limit",
    "birth",
    "death",
    "thickness",
    "thickness_scale",
];

/// Law that cards name by an option.
const MORTAR: &str = "mortar";

/// Writes the contact of a job. Interfaces become cards if those of one surface come before those
/// of two, as the reader of cards assumes, and if all of them have a law and parts on each side.
pub fn write(deck: &mut DeckWriter, job: &Job) {
    let Some(contact) = &job.contact else { return };
    let ids: Vec<u32> = job.part.iter().map(|p| p.id).collect();
    let all: Vec<ContactInput> = contact.each().collect();
    let touches = |c: &ContactInput| {
        c.law != ContactInput::NO_LAW && c.sides(&ids).iter().all(|side| !side.is_empty())
    };
    let in_order = all.iter().map(|c| !c.against.is_empty()).is_sorted();
    if !(in_order && all.iter().all(touches)) {
        let plain = ContactInput {
            friction: contact.friction,
            parts: contact.parts.clone(),
            ..ContactInput::default()
        };
        card(deck, &plain, (&ids, job.end_time), None);
        return differing(
            deck,
            "contact",
            contact,
            &ContactInput::default(),
            &["friction", "parts"],
        );
    }
    let names = names(&all);
    for (number, (one, name)) in (1..).zip(all.iter().zip(&names)) {
        let heading =
            (!(number == 1 && contact.name.is_empty())).then_some((number, name.as_str()));
        card(deck, one, (&ids, job.end_time), heading);
    }
    let carried = |c: &ContactInput| -> Vec<&str> {
        CARRIED.into_iter().chain((c.law == MORTAR).then_some("law")).collect()
    };
    let excluded: Vec<&str> = carried(contact).into_iter().chain(["interface"]).collect();
    differing(deck, "contact", contact, &ContactInput::default(), &excluded);
    let entries: Vec<Value> = contact
        .interface
        .iter()
        .zip(names[1..].iter().zip(&all[1..]))
        .filter_map(|(i, (name, whole))| rest(i, name, &carried(whole)))
        .collect();
    for entry in entries.iter().filter_map(Value::as_table) {
        deck.note_leaves("contact.interface", entry, LeftReason::NoCard);
    }
    if !entries.is_empty()
        && let Value::Table(of) =
            deck.rest.entry("contact").or_insert_with(|| Value::Table(Table::new()))
    {
        of.insert("interface".into(), Value::Array(entries));
    }
}

/// Returns unique names of the interfaces.
pub(in crate::input::deck) fn names(all: &[ContactInput]) -> Vec<String> {
    let numbered = |number: usize| format!("contact {number}");
    let name = |(number, c): (usize, &ContactInput)| match line(&c.name)
        .chars()
        .take(70)
        .collect::<String>()
    {
        name if name.is_empty() => numbered(number),
        name => name,
    };
    let names: Vec<String> = (1..).zip(all).map(name).collect();
    let are_unique = names.iter().collect::<BTreeSet<_>>().len() == names.len();
    if are_unique { names } else { (1..=all.len()).map(numbered).collect() }
}

/// Returns the keys of an interface that are not among `carried`; `None` if there are none.
pub(in crate::input::deck) fn rest(
    interface: &Interface,
    name: &str,
    carried: &[&str],
) -> Option<Value> {
    let Ok(Value::Table(said)) = Value::try_from(interface) else { return None };
    let Ok(Value::Table(silent)) = Value::try_from(Interface::default()) else { return None };
    let more = |(key, value): &(String, Value)| {
        !carried.contains(&key.as_str()) && silent.get(key) != Some(value)
    };
    let mut said: Table = said.into_iter().filter(more).collect();
    if said.is_empty() {
        return None;
    }
    said.extend([named(name)]);
    Some(Value::Table(said))
}

/// Writes one card with its heading and its sets. The job ends at `end` [time].
fn card(
    deck: &mut DeckWriter,
    c: &ContactInput,
    (ids, end): (&[u32], f64),
    heading: Option<(u64, &str)>,
) {
    let single = c.against.is_empty();
    let keyword = if single {
        "CONTACT_AUTOMATIC_SINGLE_SURFACE"
    } else {
        "CONTACT_AUTOMATIC_SURFACE_TO_SURFACE"
    };
    let keyword = format!("{keyword}{}", if c.law == MORTAR { "_MORTAR" } else { "" });
    // Sets come first, because the numbers of a card must directly follow its keyword.
    let resolved =
        c.sides(ids).map(|side| side.into_iter().map(|place| ids[place]).collect::<Vec<u32>>());
    let [ahead, behind] = resolved;
    let all = c.parts.is_empty() && c.exclude.is_empty();
    let mut side = |parts: &[u32]| [Id(deck.part_set(parts)), Id(2)];
    let [surfa, typea] = if all { [Id(0), Id(5)] } else { side(&ahead) };
    let [surfb, typeb] = if single { [Blank, Blank] } else { side(&behind) };
    match heading {
        Some((number, name)) => {
            deck.keyword(&format!("{keyword}_ID"));
            deck.named_card(number, name);
        }
        None => deck.keyword(&keyword),
    }
    deck.card(&[surfa, surfb, typea, typeb]);
    let dynamic = c.friction_dynamic.unwrap_or(c.friction);
    let or_blank = |x: f64| if x > 0.0 && x.is_finite() { Number(x) } else { Blank };
    let limit = or_blank(c.friction_limit.unwrap_or(0.0));
    let (birth, death) = (or_blank(c.birth), or_blank(c.death.filter(|&t| t < end).unwrap_or(0.0)));
    deck.card(&[
        Number(c.friction),
        Number(dynamic),
        or_blank(c.friction_decay),
        limit,
        Blank,
        Blank,
        birth,
        death,
    ]);
    let thickness = or_blank(c.thickness.unwrap_or(0.0));
    let scale = if c.thickness_scale == 1.0 { Blank } else { Number(c.thickness_scale) };
    let of_other = |field: CardValue| if single { Blank } else { field };
    deck.card(&[Blank, Blank, thickness, of_other(thickness), scale, of_other(scale)]);
}
