//! Writes metals as cards.

use super::materials::{CardParameters, MaterialCards};
use super::{Blank, CardValue, DeckWriter, Id, Number};
use crumple_proto::partition::Param;

/// Card of the law `j2`, by the keys that only this card has.
#[derive(Clone, Copy, PartialEq, Eq)]
enum MetalCard {
    Kinematic,
    Anisotropic,
    Damage,
    Strains,
    Piecewise,
}

/// Writes a metal of the law `j2`.
pub fn j2(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let has = |keys: &[&str]| keys.iter().any(|key| cards.has(key));
    let by_curve = has(&["hardening", "hardening_by_rate"]);
    let card = match () {
        () if has(&["kinematic_modulus"]) && !by_curve => MetalCard::Kinematic,
        () if has(&["lankford"]) && !has(&["hardening_by_rate"]) => MetalCard::Anisotropic,
        () if has(&["softening"]) => MetalCard::Damage,
        () if has(&["erosion_thinning", "erosion_major_strain"]) => MetalCard::Strains,
        () => MetalCard::Piecewise,
    };
    match card {
        MetalCard::Kinematic => kinematic(deck, cards, read),
        MetalCard::Anisotropic => anisotropic(deck, cards, read),
        _ => piecewise(deck, cards, card, read),
    }
}

/// Returns the tangent modulus for a plastic modulus, and the plastic modulus that a reader has
/// from it.
pub(super) fn tangent(e: f64, modulus: f64) -> [f64; 2] {
    let tangent = e * modulus / (e + modulus);
    [tangent, e * tangent / (e - tangent)]
}

/// Returns both constants of Cowper and Symonds as fields.
fn rates(cards: &MaterialCards<'_>, read: &mut CardParameters) -> [CardValue; 2] {
    match cards.list("cowper_symonds") {
        &[c, p] if c > 0.0 && p > 0.0 => {
            cards.keep(read, &["cowper_symonds"]);
            [Number(c), Number(p)]
        }
        _ => [Blank; 2],
    }
}

fn kinematic(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let [h, k] = ["hardening_modulus", "kinematic_modulus"].map(|key| cards.number(key));
    let [tangent, modulus] = tangent(cards.number("youngs_modulus"), h + k);
    let beta = h / (h + k);
    for (key, share) in [("hardening_modulus", beta), ("kinematic_modulus", 1.0 - beta)] {
        if modulus * share != 0.0 {
            read.insert(key.into(), Param::Number(modulus * share));
        }
    }
    let [c, p] = rates(cards, read);
    cards.keep(read, &["yield_stress", "failure_strain"]);
    let vp = viscoplastic(cards, !matches!(c, Blank), read);
    cards.head(deck, "MAT_PLASTIC_KINEMATIC");
    let own = [Number(cards.number("yield_stress")), Number(tangent), Number(beta)];
    deck.card(&[&cards.elastic()[..], &own].concat());
    deck.card(&[c, p, cards.field("failure_strain"), vp]);
}

fn anisotropic(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let curve = cards.curve(deck, "hardening");
    let [sigy, etan] = stress_and_tangent(cards, curve, read);
    cards.keep(read, &["lankford", "hardening"]);
    cards.head(deck, "MAT_TRANSVERSELY_ANISOTROPIC_ELASTIC_PLASTIC");
    let own = [sigy, etan, Number(cards.number("lankford")), curve];
    deck.card(&[&cards.elastic()[..], &own].concat());
}

/// Returns the fields of the yield stress and the tangent modulus; blank next to a curve.
fn stress_and_tangent(
    cards: &MaterialCards<'_>,
    curve: CardValue,
    read: &mut CardParameters,
) -> [CardValue; 2] {
    if !matches!(curve, Blank) {
        return [Blank; 2];
    }
    cards.keep(read, &["yield_stress"]);
    let [tangent, modulus] =
        tangent(cards.number("youngs_modulus"), cards.number("hardening_modulus"));
    if modulus != 0.0 {
        read.insert("hardening_modulus".into(), Param::Number(modulus));
    }
    [Number(cards.number("yield_stress")), Number(tangent)]
}

/// Returns the field for rates of the plastic strain, which only laws with rates have.
fn viscoplastic(
    cards: &MaterialCards<'_>,
    has_rates: bool,
    read: &mut CardParameters,
) -> CardValue {
    let is_set = has_rates && cards.flag("viscoplastic");
    if is_set {
        cards.keep(read, &["viscoplastic"]);
    }
    if is_set { Number(1.0) } else { Blank }
}

fn piecewise(
    deck: &mut DeckWriter,
    cards: &MaterialCards<'_>,
    card: MetalCard,
    read: &mut CardParameters,
) {
    let by_rate = cards.has("hardening_by_rate");
    let curve = match by_rate {
        true => cards.table(deck, "hardening_by_rate"),
        false => cards.curve(deck, "hardening"),
    };
    cards.keep(read, &["hardening", "hardening_by_rate"]);
    let [c, p] = rates(cards, read);
    // A reader takes one of both kinds of rates.
    let factors = match c {
        Blank => {
            cards.keep(read, &["rate_factors"]);
            cards.curve(deck, "rate_factors")
        }
        _ => Blank,
    };
    let has_rates = by_rate || !matches!((c, factors), (Blank, Blank));
    let vp = viscoplastic(cards, has_rates, read);
    let [sigy, etan] = stress_and_tangent(cards, curve, read);
    let softening = cards.list("softening");
    let limit = |at: usize| softening.get(at).map_or(Blank, |&strain| Number(strain));
    let (keyword, fail, others) = match card {
        MetalCard::Damage => {
            cards.keep(read, &["softening"]);
            ("MAT_PLASTICITY_WITH_DAMAGE", limit(0), vec![limit(1), vp])
        }
        MetalCard::Strains => {
            cards.keep(read, &["failure_strain", "erosion_thinning", "erosion_major_strain"]);
            let strains = ["erosion_thinning", "erosion_major_strain"].map(|key| cards.field(key));
            let keyword = "MAT_MODIFIED_PIECEWISE_LINEAR_PLASTICITY";
            (keyword, cards.field("failure_strain"), [&[vp][..], &strains].concat())
        }
        _ => {
            cards.keep(read, &["failure_strain"]);
            ("MAT_PIECEWISE_LINEAR_PLASTICITY", cards.field("failure_strain"), vec![vp])
        }
    };
    cards.head(deck, keyword);
    deck.card(&[&cards.elastic()[..], &[sigy, etan, fail]].concat());
    deck.card(&[&[c, p, curve, factors][..], &others].concat());
    deck.card(&[]);
    deck.card(&[]);
}

/// Writes a metal of Johnson and Cook.
pub fn johnson_cook(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let [e, nu] = ["youngs_modulus", "poisson"].map(|key| cards.number(key));
    let damage: [f64; 5] = cards.list("damage").try_into().unwrap_or_default();
    let fails = damage[..3].iter().any(|d| *d != 0.0);
    cards.keep(read, &["a", "b", "n"]);
    if cards.number("c") > 0.0 || (fails && damage[3] != 0.0) {
        cards.keep(read, &["c", "reference_rate"]);
    }
    if cards.number("specific_heat") > 0.0 && cards.number("melting_temperature") > 0.0 {
        cards.keep(read, &["m", "melting_temperature", "reference_temperature", "specific_heat"]);
    }
    if fails {
        cards.keep(read, &["damage"]);
    }
    let least = cards.number("eos_min_pressure");
    let [pc, spall] = if least < 0.0 { [Number(least), Id(1)] } else { [Blank; 2] };
    cards.head(deck, "MAT_JOHNSON_COOK");
    let shear = Number(e / (2.0 * (1.0 + nu)));
    deck.card(&[Id(cards.mid), Number(cards.material.density), shear, Number(e), Number(nu)]);
    let keys =
        ["a", "b", "n", "c", "m", "melting_temperature", "reference_temperature", "reference_rate"];
    deck.card(&keys.map(|key| Number(cards.number(key))));
    let heat = [Number(cards.number("specific_heat")), pc, spall, Blank];
    let [d1, d2, d3, d4, d5] = damage.map(Number);
    deck.card(&[&heat[..], &[d1, d2, d3, d4]].concat());
    deck.card(&[d5]);
}
