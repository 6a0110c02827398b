//! Writes materials as cards. What a card does not hold is written after `$crumple:` with the name
//! of the material.

use super::{Blank, CardValue, DeckWriter, Id, Number, line, named, points};
use super::{
    barlat, cohesive, composites, damage, gurson, metals, polymers, pressure_dependent,
    soft_materials, writer::LeftReason,
};
use crate::input::deck::BEYOND_ALL_STRAINS;
use crate::input::job::Model;
use crumple_proto::job::Part;
use crumple_proto::partition::{Material, Param};
use std::collections::BTreeMap;
use toml::Table;

/// Parameters that a reader gives a material by its cards.
pub(super) type CardParameters = BTreeMap<String, Param>;

/// Criteria of failure: field of the card, key, and sign of the field. Only those of pressure and
/// volume may be negative.
const EROSION: [[(&str, f64); 8]; 2] = [
    [
        ("", 0.0),
        ("", 0.0),
        ("erosion_max_pressure", 1.0),
        ("", 0.0),
        (PLASTIC, -1.0),
        ("erosion_volume_strain", 1.0),
        (FAILED_POINTS, 1.0),
        ("", 0.0),
    ],
    [
        ("erosion_min_pressure", 1.0),
        ("erosion_principal_stress", 1.0),
        ("erosion_von_mises", 1.0),
        ("erosion_major_strain", 1.0),
        ("", 0.0),
        ("", 0.0),
        ("", 0.0),
        ("", 0.0),
    ],
];
const PLASTIC: &str = "erosion_plastic_strain";
const FAILED_POINTS: &str = "erosion_failed_points";
const EFFECTIVE: &str = "erosion_effective_strain";
const OF_BOTH_SIGNS: [&str; 4] =
    ["erosion_max_pressure", "erosion_min_pressure", "erosion_volume_strain", FAILED_POINTS];

/// Equations of state: key, keyword, and number of fields before the first constant.
const EQUATIONS: [(&str, &str, usize); 2] =
    [("eos_gruneisen", "EOS_GRUNEISEN", 1), ("eos_polynomial", "EOS_LINEAR_POLYNOMIAL", 2)];

/// Key of an equation of state by a table.
const TABLE: &str = "eos_table";

/// Law of thermoplastics.
const POLYMER: &str = "polymer";
/// Law of fluids of solids, and the key of their least pressure.
const FLUID: &str = "fluid";
const LEAST_PRESSURE: &str = "eos_min_pressure";
/// Key of the limit of compression.
const COMPRESSION: &str = "erosion_compression";

/// A material under construction.
pub(super) struct MaterialCards<'m> {
    pub material: &'m Material,
    /// Its id in the deck.
    pub mid: u64,
    /// True if shells have angles of their own, which replace that of the material.
    pub turned: bool,
    /// First part that has it.
    pub part: Option<&'m Part>,
}

impl MaterialCards<'_> {
    /// Returns a number, 0 if it is not given.
    pub fn number(&self, key: &str) -> f64 {
        match self.material.parameters.get(key) {
            Some(Param::Number(x)) => *x,
            _ => 0.0,
        }
    }

    /// Returns a list of numbers, empty if it is not given.
    pub fn list(&self, key: &str) -> &[f64] {
        match self.material.parameters.get(key) {
            Some(Param::List(list)) => list,
            _ => &[],
        }
    }

    /// Returns the rows of a table, none if it is not given.
    pub fn rows(&self, key: &str) -> &[Vec<f64>] {
        match self.material.parameters.get(key) {
            Some(Param::Table(rows)) => rows,
            _ => &[],
        }
    }

    /// Returns true if a flag is set.
    pub fn flag(&self, key: &str) -> bool {
        self.material.parameters.get(key) == Some(&Param::Flag(true))
    }

    /// Returns true if the material has a key.
    pub fn has(&self, key: &str) -> bool {
        self.material.parameters.contains_key(key)
    }

    /// Returns the field of a number, blank for 0.
    pub fn field(&self, key: &str) -> CardValue {
        match self.number(key) {
            0.0 => Blank,
            x => Number(x),
        }
    }

    /// Notes that a reader has these keys as they are.
    pub fn keep(&self, read: &mut CardParameters, keys: &[&str]) {
        let given =
            |key: &&str| Some((key.to_string(), self.material.parameters.get(*key)?.clone()));
        read.extend(keys.iter().filter_map(given));
    }

    /// Writes the keyword and the title.
    pub fn head(&self, deck: &mut DeckWriter, keyword: &str) {
        deck.keyword(&format!("{keyword}_TITLE"));
        deck.text(&line(&self.material.name));
    }

    /// Returns id, density and elastic constants.
    pub fn elastic(&self) -> [CardValue; 4] {
        let [e, nu] = ["youngs_modulus", "poisson"].map(|key| Number(self.number(key)));
        [Id(self.mid), Number(self.material.density), e, nu]
    }

    /// Writes a table of two columns as a curve, and returns its id; blank without it.
    pub fn curve(&self, deck: &mut DeckWriter, key: &str) -> CardValue {
        let pairs = pairs(self.rows(key));
        if pairs.is_empty() { Blank } else { Id(points(deck, &pairs)) }
    }

    /// Writes a table of curves at ascending values, and returns its id.
    pub fn table(&self, deck: &mut DeckWriter, key: &str) -> CardValue {
        let curves: Vec<(f64, u64)> = self
            .rows(key)
            .chunk_by(|a, b| a[0] == b[0])
            .map(|rows| (rows[0][0], points(deck, &pairs_of(rows, 1))))
            .collect();
        deck.curves += 1;
        let id = Id(deck.curves);
        deck.keyword("DEFINE_TABLE_2D");
        deck.card(&[id]);
        curves.iter().for_each(|&(value, curve)| deck.card(&[Number(value), Id(curve)]));
        id
    }
}

/// Returns the points of a table of two columns.
fn pairs(rows: &[Vec<f64>]) -> Vec<[f64; 2]> {
    pairs_of(rows, 0)
}

/// Returns the points of a table in two columns from `first` on.
fn pairs_of(rows: &[Vec<f64>], first: usize) -> Vec<[f64; 2]> {
    let pair = |row: &Vec<f64>| Some([*row.get(first)?, *row.get(first + 1)?]);
    rows.iter().filter_map(pair).collect()
}

/// Writes the materials of deformable parts. `rigid` holds the parts with a material of a rigid
/// body. Returns the ids of equations of state by the names of materials.
pub fn write<'m>(
    deck: &mut DeckWriter,
    model: &'m Model,
    rigid: &BTreeMap<u32, u64>,
) -> BTreeMap<&'m str, u64> {
    let deforms = |m: &Material| {
        let has = |p: &Part| p.materials().contains(&m.name.as_str());
        model.job.part.iter().any(|p| has(p) && !rigid.contains_key(&p.id))
    };
    let of_solids = |m: &Material| {
        let mut solids = model.mesh.elements.iter().filter(|e| e.shape.is_solid());
        let is_own =
            |p: &Part, id: u32| p.id == id && p.material == m.name && !rigid.contains_key(&p.id);
        solids.any(|e| model.job.part.iter().any(|p| is_own(p, e.part)))
    };
    let turned = model.mesh.elements.iter().any(|e| e.own.angle != 0.0);
    let mut equations = BTreeMap::new();
    for (material, mid) in model.settings.materials.iter().zip(1..).filter(|(m, _)| deforms(m)) {
        let part = model.settings.parts.iter().find(|p| p.material == material.name);
        let written = constant_beyond_last_points(material);
        let cards = MaterialCards { material: &written, mid, turned, part };
        let mut read = law(deck, &cards);
        erosion(deck, &cards, &mut read);
        damage::gissmo(deck, &cards, &mut read);
        damage::diem(deck, &cards, &mut read);
        if ["johnson_cook", FLUID].contains(&&*material.law) && of_solids(material) {
            equations.extend(equation(deck, &cards, &mut read).map(|id| (&*material.name, id)));
        }
        if material.law == "karagozian_case_concrete" && of_solids(material) {
            let id = pressure_dependent::compaction(deck, &cards, &mut read);
            equations.insert(&*material.name, id);
        }
        account(deck, &written, &read);
    }
    equations
}

/// Returns a material whose hardening curves have one more point each. Without it a reader
/// continues them with their last slope.
fn constant_beyond_last_points(material: &Material) -> Material {
    let mut written = material.clone();
    let keys: &[&str] = match material.law.as_str() {
        POLYMER => &["tension", "tension_by_rate", "compression", "shear"],
        _ => &["hardening", "hardening_by_rate"],
    };
    for key in keys {
        let Some(Param::Table(rows)) = written.parameters.get_mut(*key) else { continue };
        let is_of_rate = key.ends_with("_by_rate");
        let mut all: Vec<Vec<f64>> = Vec::new();
        for curve in rows.chunk_by(|a, b| !is_of_rate || a[0] == b[0]) {
            all.extend_from_slice(curve);
            if let [.., before, last] = curve
                && before.last() != last.last()
                && last[last.len() - 2] < BEYOND_ALL_STRAINS
            {
                let mut beyond = last.clone();
                beyond[last.len() - 2] = BEYOND_ALL_STRAINS;
                all.push(beyond);
            }
        }
        *rows = all;
    }
    written
}

/// Writes the card of a law and returns what a reader has by it.
fn law(deck: &mut DeckWriter, cards: &MaterialCards<'_>) -> CardParameters {
    let mut read = CardParameters::new();
    cards.keep(&mut read, &["youngs_modulus", "poisson"]);
    match cards.material.law.as_str() {
        "elastic" => {
            cards.head(deck, "MAT_ELASTIC");
            deck.card(&cards.elastic());
        }
        "j2" => metals::j2(deck, cards, &mut read),
        "johnson_cook" => metals::johnson_cook(deck, cards, &mut read),
        FLUID => fluid(deck, cards, &mut read),
        "barlat" => barlat::sheet(deck, cards, &mut read),
        "gurson" => gurson::metal(deck, cards, &mut read),
        POLYMER => polymers::polymer(deck, cards, &mut read),
        "orthotropic" => {
            composites::ply(deck, cards);
            // The ply has accounted for all of its own keys.
            let own =
                cards.material.parameters.iter().filter(|(key, _)| !key.starts_with("erosion"));
            read.extend(own.map(|(key, param)| (key.clone(), param.clone())));
        }
        law if soft_materials::write(deck, law, cards, &mut read) => {}
        law if cohesive::write(deck, law, cards, &mut read) => {}
        law if pressure_dependent::write(deck, law, cards, &mut read) => {}
        other => {
            cards.head(deck, "MAT_ELASTIC");
            deck.card(&cards.elastic());
            deck.note(&format!("law {}", line(other)), LeftReason::NoCard, 1);
            let law = ("law".to_string(), other.into());
            deck.comment("material", Table::from_iter([named(&cards.material.name), law]));
        }
    }
    read
}

/// Writes a fluid of solids. Blank is a fluid without tension.
fn fluid(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let cutoff = match cards.has(LEAST_PRESSURE) {
        true => cards.field(LEAST_PRESSURE),
        false => Number(-1e20),
    };
    cards.head(deck, "MAT_NULL");
    let density = Number(cards.material.density);
    let mut card = vec![Id(cards.mid), density, cutoff, cards.field("viscosity")];
    if cards.has(COMPRESSION) {
        let ratio = (-cards.number(COMPRESSION)).exp();
        card.extend([Blank, Number(ratio)]);
        read.insert(COMPRESSION.into(), Param::Number(-ratio.ln()));
    }
    deck.card(&card);
    cards.keep(read, &["viscosity", LEAST_PRESSURE]);
}

/// Writes criteria of failure.
fn erosion(deck: &mut DeckWriter, cards: &MaterialCards<'_>, read: &mut CardParameters) {
    let given = |key: &str| {
        let x = cards.number(key);
        let is_limit = x > 0.0 || (x < 0.0 && OF_BOTH_SIGNS.contains(&key));
        // The card of the law may have it.
        is_limit && !read.contains_key(key)
    };
    let own = EROSION.as_flattened().iter().map(|f| f.0);
    // One field has the limit of the plastic strain, or that of the effective strain.
    let shared = (!given(PLASTIC)).then_some(EFFECTIVE);
    let keys: Vec<&str> = own.chain(shared).filter(|key| given(key)).collect();
    if keys.is_empty() {
        return;
    }
    deck.keyword("MAT_ADD_EROSION");
    for (row, fields) in EROSION.iter().enumerate() {
        let mut values = fields.map(|(key, sign)| match given(key) {
            true => Number(sign * cards.number(key)),
            false if key == PLASTIC && given(EFFECTIVE) => Number(cards.number(EFFECTIVE)),
            // All points; a blank field is the first one.
            false if key == FAILED_POINTS => Number(-100.0),
            false => Blank,
        });
        if row == 0 {
            values[0] = Id(cards.mid);
        }
        deck.card(&values);
    }
    cards.keep(read, &keys);
}

/// Writes the equation of state of a material, and returns its id.
fn equation(
    deck: &mut DeckWriter,
    cards: &MaterialCards<'_>,
    read: &mut CardParameters,
) -> Option<u64> {
    if cards.has(TABLE) {
        let rows: Vec<&Vec<f64>> = cards.rows(TABLE).iter().rev().collect();
        // A curve ascends in ln V.
        let mut curve = |column: usize| {
            let curve: Vec<[f64; 2]> = rows.iter().map(|row| [0.0 - row[0], row[column]]).collect();
            Id(points(deck, &curve))
        };
        let [cold, thermal] = [curve(1), curve(2)];
        deck.keyword("EOS_TABULATED");
        deck.card(&[Id(cards.mid), Number(1.0), Blank, Blank, cold, thermal]);
        cards.keep(read, &[TABLE]);
    } else {
        let &(key, keyword, before) = EQUATIONS.iter().find(|(key, ..)| cards.has(key))?;
        deck.keyword(keyword);
        let blanks = vec![Blank; before - 1];
        let constants: Vec<CardValue> = cards.list(key).iter().map(|&c| Number(c)).collect();
        deck.card(&[&[Id(cards.mid)][..], &blanks, &constants].concat());
        cards.keep(read, &[key]);
    }
    if cards.number(LEAST_PRESSURE) < 0.0 {
        cards.keep(read, &[LEAST_PRESSURE]);
    }
    Some(cards.mid)
}

/// Writes what a reader does not have by the cards after `$crumple:`.
fn account(deck: &mut DeckWriter, material: &Material, read: &CardParameters) {
    let [mut without, mut digits] = [(); 2].map(|()| Table::from_iter([named(&material.name)]));
    for (key, param) in &material.parameters {
        match read.get(key.as_str()) {
            Some(known) if known == param => {}
            Some(_) => drop(digits.insert(key.clone(), value_of(param))),
            None => drop(without.insert(key.clone(), value_of(param))),
        }
    }
    if without.len() > 1 {
        deck.entry("material", without);
    }
    if digits.len() > 1 {
        deck.digits("material", digits);
    }
}

/// Returns a parameter as a value of a job.
fn value_of(param: &Param) -> toml::Value {
    let list = |numbers: &[f64]| toml::Value::from(numbers.to_vec());
    match param {
        Param::Flag(flag) => (*flag).into(),
        Param::Number(x) => (*x).into(),
        Param::List(numbers) => list(numbers),
        Param::Table(rows) => rows.iter().map(|row| list(row)).collect::<Vec<_>>().into(),
    }
}
