//! Writes metals with voids as cards.

use super::materials::{CardParameters, MaterialCards};
use super::metals::tangent;
use super::{Blank, DeckWriter, Id, Number};
use crumple_proto::partition::Param;

/// Keys that a reader has as they are.
const EXACT: [&str; 8] = [
    "void_fraction",
    "nucleation",
    "critical_void_fraction",
    "failure_void_fraction",
    "failure_void_fractions",
    "voids_only_grow",
    "voids_close",
    "hardening",
];

/// Writes a material as a card. Hardening by Swift has no card of its own, except the power law
/// that begins at the elastic line.
pub fn metal(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    cards.keep(read, &EXACT);
    let e = cards.number("youngs_modulus");
    let hardening = cards.curve(deck, "hardening");
    let mut form = [Blank; 4];
    if let [k, e0, n] = *cards.list("swift") {
        let sigy = e * e0;
        form = [Number(sigy), Number(1.0 / n), Blank, Number(1.0)];
        // The list that a reader makes of these fields.
        let (start, exponent) = (sigy / e, 1.0 / n);
        let of_reader = [sigy * start.powf(-1.0 / exponent), start, 1.0 / exponent];
        if [k, e0, n].iter().zip(of_reader).all(|(own, of)| (own / of - 1.0).abs() < 1e-12) {
            read.insert("swift".into(), Param::List(of_reader.to_vec()));
        }
    } else if matches!(hardening, Blank) {
        cards.keep(read, &["yield_stress"]);
        let [of_card, modulus] = tangent(e, cards.number("hardening_modulus"));
        form = [Number(cards.number("yield_stress")), Blank, Number(of_card), Number(2.0)];
        if modulus != 0.0 {
            read.insert("hardening_modulus".into(), Param::Number(modulus));
        }
    }
    let [sigy, n, etan, atyp] = form;
    let or =
        |key: &str, default: f64| Number(if cards.has(key) { cards.number(key) } else { default });
    let q = [or("q1", 1.5), or("q2", 1.0)];
    read.insert("q1".into(), param(q[0]));
    read.insert("q2".into(), param(q[1]));
    let nucleation = cards.list("nucleation");
    let [fraction, mean, deviation] =
        std::array::from_fn(|k| nucleation.get(k).map_or(Blank, |&x| Number(x)));
    let sizes = cards.curve(deck, "failure_void_fractions");
    let fails = ["failure_void_fraction", "failure_void_fractions"].iter().any(|k| cards.has(k));
    // Blank is one point.
    let points = if cards.has("failed_points") {
        cards.keep(read, &["failed_points"]);
        cards.field("failed_points")
    } else {
        if fails {
            read.insert("failed_points".into(), Param::Number(1.0));
        }
        Blank
    };
    let growth = match [cards.flag("voids_only_grow"), cards.flag("voids_close")] {
        [true, _] => Number(1.0),
        [_, true] => Number(2.0),
        _ => Blank,
    };
    cards.head(deck, "MAT_GURSON");
    deck.card(&[&cards.elastic()[..], &[sigy, n, q[0], q[1]]].concat());
    let [fc, f0] = ["critical_void_fraction", "void_fraction"].map(|key| cards.field(key));
    let failure = cards.field("failure_void_fraction");
    deck.card(&[fc, f0, mean, deviation, fraction, etan, atyp, failure]);
    (0..3).for_each(|_| deck.card(&[]));
    deck.card(&[hardening, sizes, points, Blank, Blank, Blank, growth]);
}

/// Returns the parameter of a field.
fn param(field: super::CardValue) -> Param {
    match field {
        Number(x) => Param::Number(x),
        Id(x) => Param::Number(x as f64),
        _ => Param::Number(0.0),
    }
}
