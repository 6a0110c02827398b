//! Writes rubbers, foams, honeycombs, fabrics, concrete and viscoelastic materials as cards.

use super::materials::{CardParameters, MaterialCards};
use super::{Blank, CardValue, DeckWriter, Id, Number};
use crumple_proto::partition::Param;

/// Most terms of a rubber on its card.
const MOST_TERMS: usize = 8;
/// Tension from which on there is no limit [force/length^2].
const NO_LIMIT: f64 = 1e19;
/// Curves of honeycombs in the order of their fields.
const CRUSH: [&str; 7] =
    ["crush_a", "crush_b", "crush_c", "crush_shear", "crush_ab", "crush_bc", "crush_ca"];

/// Writes the card of a law; returns false if it has none.
pub fn write(
    deck: &mut DeckWriter,
    law: &str,
    cards: &MaterialCards<'_>,
    read: &mut CardParameters,
) -> bool {
    match law {
        "viscoelastic" => viscoelastic(deck, cards, read),
        "general_viscoelastic" => general_viscoelastic(deck, cards, read),
        "viscous_foam" => viscous_foam(deck, cards, read),
        "mooney_rivlin" | "polynomial_rubber" | "ogden" | "blatz_ko"
            if cards.rows("terms").len() <= MOST_TERMS =>
        {
            rubber(deck, law, cards, read);
        }
        // The card takes a ratio of 0 for none: the material would be a rubber.
        "tabulated_rubber" if !cards.has("poisson") || cards.number("poisson") > 0.0 => {
            simplified_rubber(deck, cards, read);
        }
        "low_density_foam" => low_density_foam(deck, cards, read),
        "crushable_foam" => crushable_foam(deck, cards, read),
        "fabric" => fabric(deck, cards, read),
        "cscm" => concrete(deck, cards, read),
        "honeycomb" => honeycomb(deck, cards, read),
        _ => return false,
    }
    true
}

/// Returns id and density.
fn first(cards: &MaterialCards<'_>) -> [CardValue; 2] {
    [Id(cards.mid), Number(cards.material.density)]
}

fn viscoelastic(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let [e, nu] = ["youngs_modulus", "poisson"].map(|key| cards.number(key));
    let [bulk, fast] = [e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))];
    read.insert("youngs_modulus".into(), Param::Number(9.0 * bulk * fast / (3.0 * bulk + fast)));
    let nu = (3.0 * bulk - 2.0 * fast) / (2.0 * (3.0 * bulk + fast));
    read.insert("poisson".into(), Param::Number(nu));
    let keys = ["long_term_shear_modulus", "decay_rate"];
    cards.keep(read, &keys);
    cards.head(deck, "MAT_VISCOELASTIC");
    let slow = keys.map(|key| Number(cards.number(key)));
    deck.card(&[&first(cards)[..], &[Number(bulk), Number(fast)], &slow].concat());
}

fn general_viscoelastic(
    deck: &mut DeckWriter,
    cards: &MaterialCards<'_>,
    read: &mut CardParameters,
) {
    let terms = |key: &str| -> Vec<Vec<f64>> {
        cards
            .rows(key)
            .iter()
            .filter(|row| row.first().is_some_and(|g| *g != 0.0))
            .cloned()
            .collect()
    };
    let (shear, mut bulk) = (terms("shear_terms"), terms("bulk_terms"));
    let mut stays = cards.number("bulk_modulus");
    if !bulk.is_empty() {
        // The card has one or the other.
        if stays != 0.0 {
            bulk.push(vec![stays, 0.0]);
        }
        stays = 0.0;
        read.insert("bulk_terms".into(), Param::Table(bulk.clone()));
    }
    read.insert("bulk_modulus".into(), Param::Number(stays));
    read.insert("shear_terms".into(), Param::Table(shear.clone()));
    cards.head(deck, "MAT_GENERAL_VISCOELASTIC");
    deck.card(&[&first(cards)[..], &[Number(stays)]].concat());
    deck.card(&[]);
    for k in 0..shear.len().max(bulk.len()) {
        let of = |terms: &[Vec<f64>]| match terms.get(k) {
            Some(term) => [Number(term[0]), Number(term[1])],
            None => [Blank; 2],
        };
        deck.card(&[of(&shear), of(&bulk)].concat());
    }
}

fn viscous_foam(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let keys = ["stiffness_exponent", "viscous_coefficient", "viscous_modulus", "viscous_exponent"];
    cards.keep(read, &keys);
    cards.head(deck, "MAT_VISCOUS_FOAM");
    let own = ["youngs_modulus"].into_iter().chain(keys).chain(["poisson"]);
    let own: Vec<CardValue> = own.map(|key| Number(cards.number(key))).collect();
    deck.card(&[&first(cards)[..], &own].concat());
}

fn concrete(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let [e, nu] = ["youngs_modulus", "poisson"].map(|key| cards.number(key));
    let [k, g] = [e / (3.0 * (1.0 - 2.0 * nu)), e / (2.0 * (1.0 + nu))];
    read.insert("youngs_modulus".into(), Param::Number(9.0 * k * g / (3.0 * k + g)));
    let nu = (3.0 * k - 2.0 * g) / (2.0 * (3.0 * k + g));
    read.insert("poisson".into(), Param::Number(nu));
    let lists =
        ["shear_surface", "torsion", "extension", "cap", "tension_rate", "compression_rate"];
    cards.keep(read, &lists);
    let damage = [
        ("compression_shape", 100.0),
        ("compression_energy", 0.0),
        ("tension_shape", 0.1),
        ("tension_energy", 0.0),
        ("shear_energy", 0.0),
        ("compression_power", 5.0),
        ("tension_power", 1.0),
        ("softening_power", 0.0),
    ];
    let rates = [("shear_rate_ratio", 1.0), ("rate_energy_power", 1.0)];
    cards.keep(read, &["erosion_strain", "recovery"]);
    for (key, _) in damage.into_iter().chain(rates) {
        cards.keep(read, &[key]);
    }
    let number = |(key, otherwise): (&str, f64)| {
        Number(if cards.has(key) { cards.number(key) } else { otherwise })
    };
    let list = |key: &str| cards.list(key).iter().map(|&x| Number(x)).collect::<Vec<_>>();
    let by_rate = cards.has("tension_rate");
    let erode = match cards.has("erosion_strain") {
        true => Number(1.0 + cards.number("erosion_strain")),
        false => Blank,
    };
    cards.head(deck, "MAT_CSCM");
    let irate = Id(u64::from(by_rate));
    let rest = [Blank, Blank, irate, erode, cards.field("recovery")];
    deck.card(&[&first(cards)[..], &rest].concat());
    deck.card(&[Number(0.0)]);
    deck.card(&[&[Number(g), Number(k)][..], &list("shear_surface")].concat());
    deck.card(&[list("torsion"), list("extension")].concat());
    deck.card(&list("cap"));
    deck.card(&damage.map(number));
    if by_rate {
        let [tension, compression] =
            ["tension_rate", "compression_rate"].map(|key| cards.list(key).to_vec());
        let mut card: Vec<CardValue> = [&compression[..2], &tension[..2]]
            .concat()
            .into_iter()
            .chain([compression[2], tension[2]])
            .map(Number)
            .collect();
        card.extend(rates.map(number));
        deck.card(&card);
    }
}

fn rubber(deck: &mut DeckWriter, law: &str, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    cards.keep(read, &["a", "b", "shear_modulus", "coefficients", "terms"]);
    let number = |key: &str| Number(cards.number(key));
    let (keyword, own) = match law {
        "mooney_rivlin" => {
            ("MAT_MOONEY-RIVLIN_RUBBER", vec![number("poisson"), number("a"), number("b")])
        }
        "polynomial_rubber" => ("MAT_HYPERELASTIC_RUBBER", vec![number("poisson")]),
        "ogden" => ("MAT_OGDEN_RUBBER", vec![number("poisson")]),
        _ => ("MAT_BLATZ-KO_RUBBER", vec![number("shear_modulus")]),
    };
    cards.head(deck, keyword);
    deck.card(&[&first(cards)[..], &own].concat());
    let terms = cards.rows("terms");
    if !terms.is_empty() {
        for column in 0..2 {
            deck.card(&terms.iter().map(|term| Number(term[column])).collect::<Vec<_>>());
        }
    }
    let coefficients: Vec<CardValue> =
        cards.list("coefficients").iter().map(|&c| Number(c)).collect();
    if !coefficients.is_empty() {
        deck.card(&coefficients);
    }
}

fn simplified_rubber(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    cards.keep(read, &["curve", "curve_by_rate", "bulk_modulus", "poisson"]);
    let by_rate = cards.has("curve_by_rate");
    let curve = match by_rate {
        true => cards.table(deck, "curve_by_rate"),
        false => cards.curve(deck, "curve"),
    };
    let mut rates = [Blank; 3];
    if by_rate {
        // Rates act in loading, and unloading follows the slowest curve.
        rates[0] = Number(-1.0);
        if cards.flag("nominal_rate") {
            cards.keep(read, &["nominal_rate"]);
            rates[1] = Number(1.0);
        }
        let time = cards.number("rate_averaging_time");
        if time > 0.0 {
            cards.keep(read, &["rate_averaging_time"]);
            rates[2] = Number(-time);
        }
    }
    cards.head(deck, "MAT_SIMPLIFIED_RUBBER/FOAM");
    deck.card(&[&first(cards)[..], &[cards.field("bulk_modulus")]].concat());
    // A specimen of unit length and area has the nominal strain and stress of the curve.
    let one = Number(1.0);
    deck.card(&[&[one, one, one, curve][..], &rates, &[cards.field("poisson")]].concat());
}

fn low_density_foam(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let by_rate = cards.has("compression_by_rate");
    let curve = match by_rate {
        true => {
            cards.keep(read, &["compression_by_rate"]);
            cards.table(deck, "compression_by_rate")
        }
        false => {
            cards.keep(read, &["compression"]);
            cards.curve(deck, "compression")
        }
    };
    // A blank field is no limit, or no loss in unloading.
    let limit = cards.number("tension_cutoff");
    let given = |key: &str, fits: bool, read: &mut CardParameters| {
        if fits && cards.number(key) != 0.0 {
            cards.keep(read, &[key]);
        }
        cards.field(key)
    };
    let tc = given("tension_cutoff", limit < NO_LIMIT, read);
    let hu = given("hysteresis", true, read);
    let shape = given("shape", true, read);
    let e = Number(cards.number("youngs_modulus"));
    if by_rate {
        cards.head(deck, "MAT_FU_CHANG_FOAM");
        let own = [e, Blank, tc, Blank, Blank, curve];
        deck.card(&[&first(cards)[..], &own].concat());
        deck.card(&[Blank, Blank, Blank, Blank, Blank, Blank, Blank, hu]);
        deck.card(&[]);
        deck.card(&[Blank, Blank, Blank, Blank, Blank, Blank, Blank, shape]);
        deck.card(&[]);
    } else {
        cards.head(deck, "MAT_LOW_DENSITY_FOAM");
        deck.card(&[&first(cards)[..], &[e, curve, tc, hu]].concat());
        deck.card(&[shape]);
    }
}

fn crushable_foam(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    // A reader adds a point to a curve that begins later.
    if cards.rows("compression").first().is_some_and(|row| row[0] == 0.0) {
        cards.keep(read, &["compression"]);
    }
    let curve = cards.curve(deck, "compression");
    cards.keep(read, &["tension_cutoff"]);
    cards.head(deck, "MAT_CRUSHABLE_FOAM");
    deck.card(&[&cards.elastic()[..], &[curve, cards.field("tension_cutoff")]].concat());
}

fn fabric(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let keys = ["youngs_modulus_b", "shear_modulus", "damping"];
    let nonzero = |key: &&&str| cards.number(key) != 0.0;
    cards.keep(read, &keys.iter().filter(nonzero).copied().collect::<Vec<_>>());
    let liner = ["liner_youngs_modulus", "liner_poisson", "liner_fraction"];
    let has_liner = cards.number("liner_fraction") > 0.0;
    if has_liner {
        cards.keep(read, &liner.iter().filter(nonzero).copied().collect::<Vec<_>>());
    }
    let compresses = cards.flag("compression");
    cards.keep(read, &["compression"]);
    // Only yarns have axes on the card, and the format has no angle with a direction.
    let has_yarns = keys[..2].iter().any(|key| cards.number(key) != 0.0);
    let direction = if has_yarns { cards.list("direction") } else { &[] };
    let along: [CardValue; 3] =
        std::array::from_fn(|c| direction.get(c).map_or(Blank, |&x| Number(x)));
    if !direction.is_empty() {
        cards.keep(read, &["direction"]);
    }
    let has_angle = has_yarns && direction.is_empty() && !cards.turned;
    if has_angle && cards.number("angle") != 0.0 {
        cards.keep(read, &["angle"]);
    }
    let [el, prl, lratio] = liner.map(|key| if has_liner { cards.field(key) } else { Blank });
    let cse = if compresses { Blank } else { Number(1.0) };
    cards.head(deck, "MAT_FABRIC");
    let e = Number(cards.number("youngs_modulus"));
    let own = [e, cards.field("youngs_modulus_b"), Blank, cards.field("poisson")];
    deck.card(&[&first(cards)[..], &own].concat());
    let shear = cards.field("shear_modulus");
    deck.card(&[shear, Blank, Blank, cse, el, prl, lratio, cards.field("damping")]);
    deck.card(&[if direction.is_empty() { Blank } else { Number(2.0) }]);
    deck.card(&[&[Blank; 3][..], &along].concat());
    let beta = if has_angle { cards.field("angle") } else { Blank };
    deck.card(&[&[Blank; 6][..], &[beta]].concat());
}

fn honeycomb(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let directional = cards.flag("directional");
    // A curve over the volume that begins above 0 is over the relative volume.
    let fits = |key: &str| {
        directional || cards.rows(key).first().is_none_or(|row| row.first() == Some(&0.0))
    };
    let mut curves = CRUSH.map(|key| if fits(key) { cards.curve(deck, key) } else { Blank });
    cards.keep(read, &CRUSH.into_iter().filter(|key| fits(key)).collect::<Vec<_>>());
    if let Blank = curves[0] {
        // The card needs this curve.
        curves[0] = cards.curve(deck, "crush_a");
    }
    let rates = cards.curve(deck, "rate_factors");
    cards.keep(read, &["yield_stress", "compacted_volume", "rate_factors"]);
    let moduli = cards.list("moduli");
    if !moduli.contains(&0.0) {
        cards.keep(read, &["moduli"]);
    }
    if directional {
        cards.keep(read, &["directional"]);
    }
    let vectors = ["direction", "direction_2"].map(|key| cards.list(key));
    let has_axes = vectors.iter().all(|v| !v.is_empty());
    if has_axes {
        cards.keep(read, &["direction", "direction_2"]);
    }
    let [a, d] = vectors.map(|v| -> [CardValue; 3] {
        std::array::from_fn(|c| v.get(c).filter(|_| has_axes).map_or(Blank, |&x| Number(x)))
    });
    let strains = ["tension_failure_strain", "shear_failure_strain"];
    let above = |key: &&&str| cards.number(key) > 0.0;
    cards.keep(read, &strains.iter().filter(above).copied().collect::<Vec<_>>());
    cards.head(deck, if directional { "MAT_MODIFIED_HONEYCOMB" } else { "MAT_HONEYCOMB" });
    let own = ["yield_stress", "compacted_volume"].map(|key| Number(cards.number(key)));
    deck.card(&[&cards.elastic()[..], &own].concat());
    deck.card(&[&curves[..], &[rates]].concat());
    let moduli: Vec<CardValue> = moduli.iter().map(|&m| Number(m)).collect();
    deck.card(&[&moduli[..], &[if has_axes { Number(2.0) } else { Blank }]].concat());
    deck.card(&[&[Blank; 3][..], &a].concat());
    deck.card(&[&d[..], &strains.map(|key| cards.field(key))].concat());
}
