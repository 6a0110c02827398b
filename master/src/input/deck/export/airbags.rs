//! Writes airbags as cards. Values that cards do not hold to the last bit, or have no field for,
//! are written after `$crumple:` with the name of the bag.

use super::faces::{corners, segments};
use super::{Blank, CardValue, DeckWriter, Id, Number, TimeCurves, line, named, points, value_of};
use crate::input::job::Model;
use crumple_proto::ids::NodeId;
use crumple_proto::job::{AirbagInput, InflowInput, VentInput};
use serde::Serialize;
use std::collections::BTreeSet;
use toml::Table;

/// Longest name of a bag on its card.
const LONGEST: usize = 70;

/// Writes bags with cards up to the first one without; it and all others stay in comments, so that
/// their order is kept.
pub fn write(deck: &mut DeckWriter, model: &Model, curves: &mut TimeCurves<'_>) {
    let bags = &model.job.airbag;
    let cards: Vec<BagCard> = bags.iter().map_while(BagCard::new).collect();
    for (place, card) in cards.iter().enumerate() {
        one(deck, (model, place), card, curves);
    }
    super::list(deck, "airbag", &bags[cards.len()..]);
}

/// Card of a bag, by what it has inside.
enum BagCard<'b> {
    /// A pressure in inverse proportion to the volume [force/length^2].
    Inverse(f64),
    /// A pressure over the volume.
    Table,
    /// A gas of constant mass.
    Closed(BagGas),
    /// A gas that leaves, without an inflow.
    Leaking(BagGas, Vents<'b>),
    /// A gas with an inflow.
    Filled(BagGas, &'b InflowInput, Vents<'b>),
}

/// A gas at the start.
#[derive(Clone, Copy)]
struct BagGas {
    cv: f64,
    cp: f64,
    temperature: f64,
    pressure: f64,
}

/// The vents of a bag by their fields.
struct Vents<'b> {
    /// Orifices; the first one may open at a pressure.
    orifices: Vec<&'b VentInput>,
    /// A vent by its mass rate.
    by_rate: Option<&'b VentInput>,
    /// True if a reader returns them in the order of the job.
    ordered: bool,
}

impl<'b> Vents<'b> {
    fn new(bag: &'b AirbagInput) -> Option<Self> {
        let is_rate = |vent: &&VentInput| !vent.rate_over_pressure.is_empty();
        let (rates, mut orifices): (Vec<&VentInput>, Vec<&VentInput>) =
            bag.vent.iter().partition(is_rate);
        let mut ordered = bag.vent.iter().is_sorted_by_key(|vent| is_rate(&vent));
        if let [first, second] = orifices[..]
            && second.opening_pressure > 0.0
        {
            orifices = vec![second, first];
            ordered = false;
        }
        let opens = |vent: &&VentInput| vent.opening_pressure > 0.0;
        let fits = rates.len() < 2
            && orifices.len() < 3
            && !rates.iter().any(opens)
            && !orifices.iter().skip(1).any(opens);
        fits.then_some(Self { orifices, by_rate: rates.first().copied(), ordered })
    }
}

impl<'b> BagCard<'b> {
    /// Returns the card of a bag; `None` if there is none.
    fn new(bag: &'b AirbagInput) -> Option<Self> {
        let name = line(&bag.name);
        if name != bag.name || name.is_empty() || name.chars().count() > LONGEST {
            return None;
        }
        if let Some(pressure) = bag.inverse_pressure {
            return (pressure > 0.0).then_some(Self::Inverse(pressure));
        }
        if !bag.pressure_over_volume.is_empty() {
            return Some(Self::Table);
        }
        let gas = BagGas {
            cv: bag.cv?,
            cp: bag.cp?,
            temperature: bag.temperature?,
            pressure: bag.pressure.unwrap_or(bag.ambient_pressure),
        };
        let vents = Vents::new(bag)?;
        match &bag.inflow[..] {
            [] if bag.vent.is_empty() && gas.pressure > 0.0 => Some(Self::Closed(gas)),
            [] if vents.is_simple() && gas.pressure > 0.0 => Some(Self::Leaking(gas, vents)),
            [inflow] => Some(Self::Filled(gas, inflow, vents)),
            _ => None,
        }
    }
}

impl Vents<'_> {
    /// Returns true for at most one orifice with a constant coefficient, and one vent by its rate.
    fn is_simple(&self) -> bool {
        self.orifices.len() < 2
            && self.orifices.iter().all(|v| v.curve.is_none() && v.opening_pressure == 0.0)
    }
}

fn one(
    deck: &mut DeckWriter,
    (model, place): (&Model, usize),
    card: &BagCard<'_>,
    curves: &mut TimeCurves<'_>,
) {
    let bag = &model.job.airbag[place];
    let mut exact = Table::from_iter([named(&bag.name)]);
    let surface = surface(deck, model, place);
    let (keyword, lines) = match card {
        BagCard::Inverse(pressure) => {
            let [cn, beta] = match &bag.curve {
                None => [*pressure, 1.0],
                Some(curve) => [-(curves.id(deck, Some(curve)) as f64), *pressure],
            };
            ("SIMPLE_PRESSURE_VOLUME", vec![vec![Number(cn), Number(beta)]])
        }
        BagCard::Table => {
            let curve = points(deck, &bag.pressure_over_volume);
            ("SIMPLE_PRESSURE_VOLUME", vec![vec![Blank, Blank, Id(curve)]])
        }
        BagCard::Closed(gas) => ("ADIABATIC_GAS_MODEL", vec![closed(bag, gas, &mut exact)]),
        BagCard::Leaking(gas, vents) => {
            ("SIMPLE_AIRBAG_MODEL", leaking(deck, bag, (gas, vents), &mut exact))
        }
        BagCard::Filled(gas, inflow, vents) => {
            ("WANG_NEFSKE", filled(deck, bag, (gas, inflow, vents), curves, &mut exact))
        }
    };
    deck.keyword(&format!("AIRBAG_{keyword}_ID"));
    deck.named_card(place as u64 + 1, &bag.name);
    deck.card(&surface);
    lines.iter().for_each(|fields| deck.card(fields));
    if exact.len() > 1 {
        let shown = ["inflow", "vent"].iter().any(|key| exact.contains_key(*key));
        deck.digits("airbag", exact);
        if shown {
            let names = bag.inflow.iter().flat_map(|i| [&i.curve, &i.temperature_curve]);
            let names = names.chain(bag.vent.iter().map(|vent| &vent.curve)).flatten();
            for name in names.collect::<BTreeSet<_>>() {
                curves.write_table(deck, Some(name));
            }
        }
    }
    let mut without = Table::from_iter([named(&bag.name)]);
    if bag.added_volume != 0.0 {
        without.insert("added_volume".into(), bag.added_volume.into());
    }
    if bag.normals_inwards && bag.nodes.is_none() {
        without.insert("normals_inwards".into(), true.into());
    }
    if bag.ambient_pressure != 0.0 && matches!(card, BagCard::Inverse(_) | BagCard::Table) {
        without.insert("ambient_pressure".into(), bag.ambient_pressure.into());
    }
    if without.len() > 1 {
        deck.entry("airbag", without);
    }
}

/// Writes the surface of a bag and returns the fields that name it.
fn surface(deck: &mut DeckWriter, model: &Model, place: usize) -> [CardValue; 2] {
    let bag = &model.job.airbag[place];
    if bag.nodes.is_none() {
        return [Id(deck.part_set(&bag.parts)), Id(1)];
    }
    let mut seen = BTreeSet::new();
    let own = model.settings.loads.airbags[place].faces.iter();
    let own = own.filter(|face| seen.insert((face.element, face.face)));
    let element = |id| model.mesh.elements.binary_search_by_key(&id, |e| e.id).ok();
    let faces = own.filter_map(|f| Some(corners(model, (element(f.element)?, f.face.into()))));
    // Segments in the other direction than elements ask for their inner side.
    let turned = |face: [NodeId; 4]| match bag.normals_inwards {
        true => [face[0], face[3], face[2], face[1]],
        false => face,
    };
    let faces: Vec<[NodeId; 4]> = faces.map(turned).collect();
    [Id(segments(deck, &faces)), Id(0)]
}

/// Adds a value unless a reader has it.
fn keep(exact: &mut Table, key: &str, given: f64, read: f64) {
    if given != read {
        exact.insert(key.into(), given.into());
    }
}

/// Adds a list as a whole.
fn keep_list(exact: &mut Table, key: &str, list: &[impl Serialize]) {
    exact.insert(key.into(), value_of(&list));
}

fn closed(bag: &AirbagInput, gas: &BagGas, exact: &mut Table) -> Vec<CardValue> {
    let gamma = gas.cp / gas.cv;
    let density = gas.pressure / ((gas.cp - gas.cv) * gas.temperature);
    let cv = 1.0 / (gamma - 1.0);
    keep(exact, "cv", gas.cv, cv);
    keep(exact, "cp", gas.cp, gamma * cv);
    keep(exact, "temperature", gas.temperature, gas.pressure / density);
    let [p0, pe] = [gas.pressure, bag.ambient_pressure].map(Number);
    vec![Blank, Blank, Number(gamma), p0, pe, Number(density)]
}

fn leaking(
    deck: &mut DeckWriter,
    bag: &AirbagInput,
    (gas, vents): (&BagGas, &Vents<'_>),
    exact: &mut Table,
) -> Vec<Vec<CardValue>> {
    let ambient = bag.ambient_pressure;
    let density = ambient / ((gas.cp - gas.cv) * gas.temperature);
    // Without an ambient pressure the temperature is that of the inflow, which is not there.
    let read = match ambient > 0.0 {
        true => ambient / ((gas.cp - gas.cv) * density),
        false => gas.temperature,
    };
    keep(exact, "temperature", gas.temperature, read);
    keep(exact, "pressure", gas.pressure, ambient);
    let mut fields = [Blank; 2];
    let mut whole = vents.ordered;
    if let Some(vent) = vents.orifices.first() {
        let coefficient = vent.coefficient.unwrap_or(1.0);
        whole &= coefficient > 0.0;
        fields = [
            Number(coefficient),
            match vent.area {
                Some(area) => {
                    whole &= area > 0.0;
                    Number(area)
                }
                None => Number(-(points(deck, &vent.area_over_pressure) as f64)),
            },
        ];
    }
    let rate = vents.by_rate.map(|vent| vec![Id(points(deck, &vent.rate_over_pressure))]);
    if !whole {
        keep_list(exact, "vent", &bag.vent);
    }
    let [coefficient, area] = fields;
    let [cv, cp, t] = [gas.cv, gas.cp, gas.temperature].map(Number);
    let first = vec![cv, cp, t, Blank, coefficient, area, Number(ambient), Number(density)];
    std::iter::once(first).chain(rate).collect()
}

fn filled(
    deck: &mut DeckWriter,
    bag: &AirbagInput,
    (gas, inflow, vents): (&BagGas, &InflowInput, &Vents<'_>),
    curves: &mut TimeCurves<'_>,
    exact: &mut Table,
) -> Vec<Vec<CardValue>> {
    let mut factor = |deck: &mut DeckWriter, curve: &Option<String>, scale: f64| match scale == 1.0
    {
        true => curves.id(deck, curve.as_deref()),
        false => curves.scaled(deck, curve.as_deref(), scale),
    };
    let rates = factor(deck, &inflow.curve, inflow.rate);
    let heats = inflow.temperature_curve.is_some();
    let [t, lct] = match heats {
        true => [Blank, Id(factor(deck, &inflow.temperature_curve, inflow.temperature))],
        false => [Number(inflow.temperature), Blank],
    };
    let kept = inflow.rate == 1.0 && inflow.curve.is_some();
    if !(kept && (!heats || inflow.temperature == 1.0)) {
        keep_list(exact, "inflow", &bag.inflow);
    }
    let mut whole = vents.ordered;
    let mut orifice = |deck: &mut DeckWriter, vent: Option<&&VentInput>| -> [CardValue; 4] {
        let Some(vent) = vent else { return [Blank; 4] };
        let coefficient = vent.coefficient.unwrap_or(1.0);
        let [c, lcc] = match vent.curve {
            None => [Number(coefficient), Blank],
            Some(_) => [Blank, Id(factor(deck, &vent.curve, coefficient))],
        };
        whole &= coefficient == 1.0 || (coefficient > 0.0 && vent.curve.is_none());
        whole &= vent.area.is_none_or(|area| area > 0.0);
        let [a, lca] = match vent.area {
            Some(area) => [Number(area), Blank],
            None => [Blank, Id(points(deck, &vent.area_over_pressure))],
        };
        [c, lcc, a, lca]
    };
    let exit = orifice(deck, vents.orifices.first());
    let leak = orifice(deck, vents.orifices.get(1));
    if !whole {
        keep_list(exact, "vent", &bag.vent);
    }
    let rate = vents.by_rate.map_or(Blank, |vent| Id(points(deck, &vent.rate_over_pressure)));
    let over = gas.pressure - bag.ambient_pressure;
    if bag.ambient_pressure + over != gas.pressure {
        exact.insert("pressure".into(), gas.pressure.into());
    }
    let opening = vents.orifices.first().map_or(0.0, |vent| vent.opening_pressure);
    let [cv, cp, start] = [gas.cv, gas.cp, gas.temperature].map(Number);
    let density = bag.ambient_pressure / ((gas.cp - gas.cv) * gas.temperature);
    vec![
        vec![cv, cp, t, lct, Id(rates), Blank, Blank, start],
        [exit, leak].concat(),
        vec![
            Number(bag.ambient_pressure),
            Number(density),
            Blank,
            rate,
            if over == 0.0 { Blank } else { Number(over) },
            if opening == 0.0 { Blank } else { Number(opening) },
        ],
    ]
}
