//! Writes contact and its interfaces, each as a card with sets of its parts. Keys without a field
//! on the card, such as laws, are written after `$crumple:` with the name of the interface.

use super::writer::unique_names;
use super::{Blank, CardValue, DeckWriter, Id, LeftReason, Number, differing, named};
use crumple_proto::job::{ContactInput, Interface, Job};
use toml::{Table, Value};

/// Keys of `[contact]` and of interfaces that cards hold.
const CARRIED: [&str; 13] = [
    "name",
    "parts",
    "against",
    "one_way",
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
    if !has_cards(&all, &ids) {
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
    for (one, name) in all.iter().zip(&names) {
        deck.contacts += 1;
        let number = deck.contacts;
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

/// Returns true if each contact becomes a card. `ids` are those of all parts.
fn has_cards(all: &[ContactInput], ids: &[u32]) -> bool {
    let touches = |c: &ContactInput| {
        c.law != ContactInput::NO_LAW && c.sides(ids).iter().all(|side| !side.is_empty())
    };
    all.iter().map(|c| !c.against.is_empty()).is_sorted() && all.iter().all(touches)
}

/// Returns the contact that applies to all pairs of a part of one side and a part of the other one,
/// if the card of a tie between them has all its settings.
pub(super) fn between(job: &Job, sides: [&[u32]; 2]) -> Option<ContactInput> {
    let ids: Vec<u32> = job.part.iter().map(|p| p.id).collect();
    let all: Vec<ContactInput> = job.contact.as_ref()?.each().collect();
    if !has_cards(&all, &ids) {
        return None;
    }
    let pairs: Vec<[Vec<u32>; 2]> = all
        .iter()
        .map(|c| c.sides(&ids).map(|side| side.into_iter().map(|place| ids[place]).collect()))
        .collect();
    let of = |a: u32, b: u32| {
        pairs.iter().rposition(|[ahead, behind]| {
            ahead.contains(&a) && behind.contains(&b) || ahead.contains(&b) && behind.contains(&a)
        })
    };
    let mut found = sides[0].iter().flat_map(|&a| sides[1].iter().map(move |&b| of(a, b)));
    let first = found.next()??;
    let one = &all[first];
    // An interface inherits from the first contact what its card does not have.
    let inherits = one.law != MORTAR
        && one.law == all[0].law
        && one.shell_offset == all[0].shell_offset
        && one.parameters == all[0].parameters;
    let plain = !one.one_way
        && one.birth == 0.0
        && one.death.is_none()
        && one.thickness.is_none()
        && one.thickness_scale == 1.0
        && one.friction_table.is_empty();
    (inherits && plain && found.all(|other| other == Some(first))).then(|| one.clone())
}

/// Returns the fields of the friction of a contact.
pub(super) fn friction(c: &ContactInput) -> [CardValue; 4] {
    let dynamic = c.friction_dynamic.unwrap_or(c.friction);
    let limit = or_blank(c.friction_limit.unwrap_or(0.0));
    [Number(c.friction), Number(dynamic), or_blank(c.friction_decay), limit]
}

/// Returns a number above zero as a field; no other one has a meaning there.
fn or_blank(x: f64) -> CardValue {
    if x > 0.0 && x.is_finite() { Number(x) } else { Blank }
}

/// Returns unique names of the interfaces.
pub(in crate::input::deck) fn names(all: &[ContactInput]) -> Vec<String> {
    unique_names("contact", all.iter().map(|c| c.name.as_str()))
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
    let keyword = match (single, c.one_way) {
        (true, _) => "CONTACT_AUTOMATIC_SINGLE_SURFACE",
        (false, false) => "CONTACT_AUTOMATIC_SURFACE_TO_SURFACE",
        (false, true) => "CONTACT_AUTOMATIC_ONE_WAY_SURFACE_TO_SURFACE",
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
    let (birth, death) = (or_blank(c.birth), or_blank(c.death.filter(|&t| t < end).unwrap_or(0.0)));
    deck.card(&[&friction(c)[..], &[Blank, Blank, birth, death]].concat());
    let thickness = or_blank(c.thickness.unwrap_or(0.0));
    let scale = if c.thickness_scale == 1.0 { Blank } else { Number(c.thickness_scale) };
    let of_other = |field: CardValue| if single { Blank } else { field };
    deck.card(&[Blank, Blank, thickness, of_other(thickness), scale, of_other(scale)]);
}
