//! Writes parts and their properties. A property has the id of its part.

use super::{Gap, Real, StarterWriter, Whole, named};
use crate::input::deck::export::table_of;
use crumple_proto::job::{BeamSection, Part, Setting, SpringInput};
use crumple_proto::mesh::Shape;
use crumple_worker::fem::elements::{HourglassForm, formulation, points_of};
use std::collections::BTreeMap;
use toml::{Table, Value};

/// Shear area of a beam over its area.
const SHEAR: f64 = 5.0 / 6.0;
/// Shells of Belytschko and Tsay.
const BELYTSCHKO_TSAY: &str = "belytschko_tsay";

fn word<'p>(part: &'p Part, key: &str) -> Option<&'p str> {
    match part.parameters.get(key) {
        Some(Setting::Word(word)) => Some(word),
        _ => None,
    }
}

impl StarterWriter<'_> {
    pub(super) fn parts(&mut self) {
        let model = self.model;
        let mut shapes: BTreeMap<u32, Vec<Shape>> = BTreeMap::new();
        for element in &model.mesh.elements {
            let own = shapes.entry(element.part).or_default();
            if !own.contains(&element.shape) {
                own.push(element.shape);
            }
        }
        let materials = &model.settings.materials;
        for part in &model.settings.parts {
            let own = shapes.get(&part.id).cloned().unwrap_or_default();
            let mut left = Table::from_iter([("id".to_string(), Value::from(part.id))]);
            self.property(part, &own, &mut left);
            let material =
                materials.iter().position(|m| m.name == part.material).map_or(0, |i| i as u64 + 1);
            let id = u64::from(part.id);
            self.titled("PART", id, &part.name);
            let contact = part.contact_thickness.map_or(Gap, Real);
            self.card(&[Whole(id), Whole(material), Whole(0), contact]);
            if part.contact_thickness_scale != 1.0 {
                left.insert("contact_thickness_scale".into(), part.contact_thickness_scale.into());
            }
            if part.skin && !self.is_void(&part.material) {
                left.insert("skin".into(), true.into());
            }
            if left.len() > 1 {
                self.rest("part", left);
            }
        }
    }

    /// Returns true if a material is written as one that carries no load.
    fn is_void(&self, name: &str) -> bool {
        let is_elastic =
            self.model.settings.materials.iter().any(|m| m.name == name && m.law == "elastic");
        is_elastic && self.model.job.part.iter().filter(|p| p.material == name).all(|p| p.skin)
    }

    fn property(&mut self, part: &Part, shapes: &[Shape], left: &mut Table) {
        let id = u64::from(part.id);
        let mut carried: Vec<&str> = Vec::new();
        if let Some(spring) = &part.spring {
            self.spring(part, spring);
        } else if let Some(beam) = &part.beam {
            self.titled("PROP/TYPE3", id, &part.name);
            self.card(&[]);
            self.card(&[]);
            let [second, third] = beam.second_moments;
            self.card(&[Real(beam.area), Real(second), Real(third), Real(beam.torsion)]);
            let is_thin = beam.shear_areas == [0.0; 2];
            self.card(&[Gap, Whole(u64::from(is_thin))]);
            let default = [SHEAR * beam.area; 2];
            let is_exact = beam.section == BeamSection::General
                && beam.weld.is_none()
                && beam.contact_radius.is_none()
                && (is_thin || beam.shear_areas == default);
            if !is_exact && let Ok(value) = Value::try_from(beam) {
                left.insert("beam".into(), value);
            }
        } else if let Some(truss) = &part.truss {
            self.titled("PROP/TYPE2", id, &part.name);
            self.card(&[Real(truss.area)]);
            if let Some(radius) = truss.contact_radius {
                let own = Table::from_iter([("contact_radius".to_string(), radius.into())]);
                left.insert("truss".into(), own.into());
            }
        } else if shapes.iter().any(|s| s.is_solid()) {
            carried = self.solid(part, shapes, left);
        } else {
            carried = self.shell(part, left);
        }
        for (key, value) in part.parameters.iter().filter(|(k, _)| !carried.contains(&k.as_str())) {
            left.extend(Value::try_from(value).ok().map(|value| (key.clone(), value)));
        }
    }

    /// Writes the property of shells. Returns the keys of the part that it has.
    fn shell(&mut self, part: &Part, left: &mut Table) -> Vec<&'static str> {
        let mut carried = vec!["points", "thinning"];
        let is_bt = part.element.as_deref() == Some(BELYTSCHKO_TSAY);
        let form = word(part, "hourglass");
        let ishell = match part.element.as_deref() {
            Some("fully_integrated_quad") => 12,
            Some(BELYTSCHKO_TSAY) if form == Some(HourglassForm::Viscous.word()) => 1,
            Some(BELYTSCHKO_TSAY) => 3,
            _ => 24,
        };
        let mut drills = 0;
        if is_bt {
            carried.push("hourglass");
            match part.parameters.get("drilling").and_then(Setting::number) {
                None => drills = 1,
                Some(0.0) => carried.push("drilling"),
                Some(_) => {}
            }
        }
        let thins = part.parameters.get("thinning") == Some(&Setting::Flag(true));
        self.titled("PROP/TYPE1", u64::from(part.id), &part.name);
        self.card(&[Whole(ishell), Whole(0), Whole(0), Whole(drills)]);
        self.card(&[]);
        self.card(&[
            Whole(points_of(part) as u64),
            Gap,
            Real(part.thickness),
            Gap,
            Gap,
            Gap,
            Whole(if thins { 1 } else { 2 }),
        ]);
        if part.offset != 0.0 {
            left.insert("offset".into(), part.offset.into());
        }
        carried
    }

    /// Writes the property of solids. Returns the keys of the part that it has.
    fn solid(&mut self, part: &Part, shapes: &[Shape], left: &mut Table) -> Vec<&'static str> {
        let mut carried = vec!["bulk_viscosity"];
        let shape = shapes.iter().copied().find(|s| s.is_solid()).unwrap_or(Shape::Hex8);
        let form = word(part, "hourglass");
        let is_viscous = form == Some(HourglassForm::Viscous.word());
        let values = formulation(part, shape).map(|row| row.values(part));
        let [linear, quadratic] =
            values.as_ref().map_or([0.06, 1.5], |v| v.numbers("bulk_viscosity"));
        let root = quadratic.sqrt();
        // A blank means the default of the format.
        if root * root != quadratic || quadratic == 0.0 || linear == 0.0 {
            left.insert("bulk_viscosity".into(), Value::from(vec![linear, quadratic]));
        }
        let coefficient = match (&values, is_viscous) {
            (Some(values), true) => values.number("hourglass_coefficient"),
            _ => 0.0,
        };
        if is_viscous && coefficient != 0.0 {
            carried.push("hourglass_coefficient");
        }
        if form.is_none_or(|word| word != HourglassForm::Stiffness.word()) {
            carried.push("hourglass");
        }
        let nodal = word(part, "pressure") != Some("element");
        if shapes.contains(&Shape::Tet4) && !shapes.contains(&Shape::Hex8) {
            carried.push("pressure");
        }
        self.titled("PROP/TYPE14", u64::from(part.id), &part.name);
        let itetra = if nodal { 3 } else { 0 };
        let isolid = if is_viscous { 1 } else { 24 };
        self.card(&[Whole(isolid), Gap, Gap, Gap, Gap, Gap, Whole(itetra)]);
        self.card(&[Real(root), Real(linear), Real(coefficient)]);
        carried
    }

    fn spring(&mut self, part: &Part, spring: &SpringInput) {
        let function = match spring.force_elongation.is_empty() {
            true => 0,
            false => {
                let title = format!("force of {}", part.name);
                self.new_function(&title, &spring.force_elongation)
            }
        };
        self.titled("PROP/TYPE4", u64::from(part.id), &part.name);
        self.card(&[]);
        self.card(&[Real(spring.stiffness), Real(spring.damping)]);
        self.card(&[Whole(function), Whole(0)]);
        let mut own = Table::new();
        // No property here has these laws with all their keys.
        let laws = SpringInput {
            elastoplastic: spring.elastoplastic.clone(),
            hysteresis: spring.hysteresis.clone(),
            one_sided: spring.one_sided.clone(),
            maxwell: spring.maxwell.clone(),
            ..SpringInput::default()
        };
        own.extend(table_of(&laws).into_iter().filter(|(_, law)| law.is_table()));
        if !spring.force_rate.is_empty() {
            let rows =
                spring.force_rate.iter().map(|p| Value::from(p.to_vec())).collect::<Vec<_>>();
            own.insert("force_rate".into(), rows.into());
        }
        if spring.rotational {
            own.insert("rotational".into(), true.into());
        }
        if let Some(direction) = spring.direction {
            own.insert("direction".into(), Value::from(direction.to_vec()));
        }
        if let Some(nodes) = spring.direction_nodes {
            let ids = nodes.map(|id| i64::try_from(id).unwrap_or(i64::MAX));
            own.insert("direction_nodes".into(), Value::from(ids.to_vec()));
        }
        if spring.projected {
            own.insert("projected".into(), true.into());
        }
        if !own.is_empty() {
            let table = Table::from_iter([named(&part.name), ("spring".into(), own.into())]);
            self.rest("part", table);
        }
    }
}
