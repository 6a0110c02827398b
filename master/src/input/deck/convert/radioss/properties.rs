//! Converts `/PROP/...`, `/DEF_SHELL` and `/DEF_SOLID`.

use super::StarterConverter;
use crate::input::deck::convert::parts::Shapes;
use crate::input::deck::convert::sections::SectionKind;
use crate::input::deck::convert::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crumple_worker::fem::elements::THICK_SHELL;
use std::collections::BTreeMap;

/// Shear area of a beam over its area.
const SHEAR: f64 = 5.0 / 6.0;
/// Difference of two second moments over their sum that counts as none.
const ROUND: f64 = 1e-9;

/// Formulations of solids that one of the engine can replace.
const SOLIDS: [i64; 8] = [0, 1, 2, 12, 14, 17, 18, 24];

/// Formulations of solids with several points, which one with a single point replaces.
const FULL: [i64; 3] = [14, 17, 18];

/// A property.
#[derive(Debug)]
pub struct StarterProperty {
    /// Kind of its elements.
    pub kind: SectionKind,
    /// Its card.
    pub record: CardRecord,
}

/// Properties by id, and their defaults.
#[derive(Debug, Default)]
pub struct StarterProperties {
    /// By id.
    pub by_id: BTreeMap<i64, StarterProperty>,
    /// Card of the defaults of shells.
    shells: Option<CardRecord>,
    /// Card of the defaults of solids.
    solids: Option<CardRecord>,
}

impl StarterProperties {
    /// Returns a flag of a property; where it is 0, that of the defaults.
    fn flag(&self, of: &StarterProperty, field: &str) -> i64 {
        let defaults = match of.kind {
            SectionKind::Shell => &self.shells,
            _ => &self.solids,
        };
        match of.record.integer(field) {
            0 => defaults.as_ref().map_or(0, |card| card.integer(field)),
            given => given,
        }
    }
}

impl StarterConverter {
    pub(super) fn properties(&mut self) -> StarterProperties {
        let mut found = StarterProperties {
            shells: self.take(&["/DEF_SHELL"]).pop(),
            solids: self.take(&["/DEF_SOLID"]).pop(),
            ..StarterProperties::default()
        };
        // Defaults of which no property makes use are used all the same.
        let _ = found
            .shells
            .as_ref()
            .map(|card| ["ishell", "ithick", "idril"].map(|f| card.integer(f)));
        let _ = found.solids.as_ref().map(|card| ["isolid", "itetra4"].map(|f| card.integer(f)));
        for (name, kind) in [
            ("/PROP/TYPE1", SectionKind::Shell),
            ("/PROP/TYPE9", SectionKind::Shell),
            ("/PROP/TYPE14", SectionKind::Solid),
            ("/PROP/TYPE20", SectionKind::ThickShell),
            ("/PROP/TYPE2", SectionKind::Beam),
            ("/PROP/TYPE3", SectionKind::Beam),
            ("/PROP/TYPE4", SectionKind::Discrete),
        ] {
            for record in self.take(&[name]) {
                let (id, place) = (record.integer("id"), record.place("id"));
                if found.by_id.insert(id, StarterProperty { kind, record }).is_some() {
                    self.twice("properties", id, place);
                }
            }
        }
        found
    }

    /// Converts the property of shells of a part with this thickness [length].
    pub(super) fn shell_property(
        &mut self,
        part: i64,
        (of, all): (&StarterProperty, &StarterProperties),
        thickness: f64,
        table: &mut JobTable,
    ) {
        let card = &of.record;
        table.put("thickness", card.place("thick"), thickness);
        let points = match card.integer("n") {
            0 => {
                self.deck.map(format!("part {part}"), "N 0: resultants", "3 points");
                3
            }
            n => n,
        };
        table.put("points", card.place("n"), points);
        if all.flag(of, "ithick") == 1 {
            table.put("thinning", card.place("ithick"), true);
        }
        let ishell = all.flag(of, "ishell");
        let (element, hourglass) = match ishell {
            24 => ("stabilised_quad", None),
            12 => ("fully_integrated_quad", None),
            3 => ("belytschko_tsay", Some("stiffness")),
            0 | 1 | 2 | 4 => ("belytschko_tsay", Some("viscous")),
            _ => {
                let why = "use 24 (stabilised_quad), 12 (fully_integrated_quad) or 1 to 4";
                return self.deck.unsupported_value(card, "ishell", why);
            }
        };
        let place = card.place("ishell");
        table.put("element", place, element);
        let mut used = element.to_string();
        if let Some(form) = hourglass {
            table.put("hourglass", place, form);
            used += &format!("; hourglass {form}");
            if all.flag(of, "idril") != 1 {
                table.put("drilling", card.place("idril"), 0.0);
            }
        }
        self.deck.map(format!("part {part}"), format!("shells, Ishell {ishell}"), used);
    }

    /// Converts the property of solids of a part.
    pub(super) fn solid_property(
        &mut self,
        part: i64,
        (of, all): (&StarterProperty, &StarterProperties),
        shapes: Shapes,
        table: &mut JobTable,
    ) {
        let quadratic_ones = shapes.only_quadratic_tetrahedra();
        let tetrahedra = shapes.tetrahedra && !shapes.solids;
        let wedges = shapes.wedges && !shapes.solids && !shapes.tetrahedra;
        let card = &of.record;
        let (isolid, itetra) = (all.flag(of, "isolid"), all.flag(of, "itetra4"));
        if !SOLIDS.contains(&isolid) {
            let why = "use 1 or 2 (one point, viscous), or 12, 14, 17, 18 or 24";
            self.deck.unsupported_value(card, "isolid", why);
        }
        let or = |field: &str, default: f64| match card.real(field) {
            0.0 => default,
            given => given,
        };
        let [quadratic, linear] = [or("qa", 1.1), or("qb", 0.05)];
        table.put("bulk_viscosity", card.place("qa"), [linear, quadratic * quadratic]);
        let is_mean =
            !tetrahedra && !quadratic_ones && FULL.contains(&isolid) || tetrahedra && itetra == 1;
        if is_mean {
            let field = if tetrahedra { "itetra4" } else { "isolid" };
            let message = format!(
                "part {part}: {field} {} has several points per element, here there is one",
                if tetrahedra { itetra } else { isolid }
            );
            let help = "compare with a finer mesh where solids bend";
            self.deck.trouble.warning(card.place(field), message, help);
        }
        let used = if wedges {
            "wedges".to_string()
        } else if quadratic_ones {
            "tetrahedra of ten nodes".to_string()
        } else if tetrahedra {
            let pressure = if itetra == 3 { "nodal" } else { "element" };
            table.put("element", card.place("itetra4"), "tetrahedron");
            table.put("pressure", card.place("itetra4"), pressure);
            format!("tetrahedra; pressure {pressure}")
        } else {
            table.put("element", card.place("isolid"), "hexahedron");
            let form = if matches!(isolid, 0..=2) { "viscous" } else { "assumed_strain" };
            table.put("hourglass", card.place("isolid"), form);
            let coefficient = or("h", 0.1);
            if form == "viscous" {
                table.put("hourglass_coefficient", card.place("h"), coefficient);
            }
            format!("hexahedron; hourglass {form}")
        };
        self.deck.map(format!("part {part}"), format!("solids, Isolid {isolid}"), used);
    }

    /// Converts the property of thick shells of a part. Without points through the thickness there
    /// are as many as the format has then: 2, or 3 with Isolid 15.
    pub(super) fn thick_shell_property(
        &mut self,
        part: i64,
        (of, all): (&StarterProperty, &StarterProperties),
        table: &mut JobTable,
    ) {
        let card = &of.record;
        let (isolid, given) = (all.flag(of, "isolid"), card.integer("inpts"));
        let (points, differs) = match isolid {
            // The digits of inpts are the points along r, s and t; s is the thickness.
            14 if given == 0 => (2, "; it has one point in its plane, not four"),
            14 => (given / 10 % 10, "; it has one point in its plane, not several"),
            15 if given == 0 => (3, ""),
            15 => (given, ""),
            _ => {
                let why = "use 14 or 15, thick shells with eight nodes";
                return self.deck.unsupported_value(card, "isolid", why);
            }
        };
        // 010 is read as 10.
        if isolid == 14 && ![0, 10].contains(&card.integer("icstr")) {
            let why = "a thickness in another direction than from nodes 1-4 to nodes 5-8 (010): \
                       change the order of the nodes";
            self.deck.unsupported_value(card, "icstr", why);
        }
        table.put("element", card.place("isolid"), THICK_SHELL);
        table.put("points", card.place("inpts"), points);
        let to = format!("{THICK_SHELL} with {points} points{differs}");
        self.deck.map(format!("part {part}"), format!("thick shells, Isolid {isolid}"), to);
    }

    /// Converts the property of beams or trusses of a part.
    pub(super) fn beam_property(&mut self, part: i64, of: &StarterProperty, table: &mut JobTable) {
        let card = &of.record;
        let area = card.real("area");
        if card.row.keyword.name == "/PROP/TYPE2" {
            let truss = JobTable::new(card.head).with("area", card.place("area"), area);
            return table.put("truss", card.head, truss);
        }
        let [second, third, torsion] = ["iyy", "izz", "ixx"].map(|field| card.real(field));
        let mut beam = JobTable::new(card.head)
            .with("section", card.head, "general")
            .with("area", card.place("area"), area)
            .with("second_moments", card.place("iyy"), [second, third])
            .with("torsion", card.place("ixx"), torsion);
        if card.integer("ishear") != 1 {
            beam.put("shear_areas", card.place("area"), [SHEAR * area; 2]);
        }
        let is_round = (second - third).abs() <= ROUND * (second + third).abs();
        if let (true, Ok(part)) = (is_round, u32::try_from(part)) {
            self.deck.round_parts.insert(part);
        }
        table.put("beam", card.head, beam);
        self.deck.map(
            format!("part {part}"),
            "beams by area and second moments",
            "corotational beam, section general: four fibres",
        );
    }

    /// Converts the property of springs of a part; `None` without its function.
    pub(super) fn spring_property(&mut self, of: &StarterProperty) -> Option<JobTable> {
        let card = &of.record;
        let mut spring = JobTable::new(card.head);
        let or_one = |field: &str| match card.real(field) {
            0.0 => 1.0,
            given => given,
        };
        let [scale, stretch] = [or_one("a1"), or_one("ascale1")];
        let (function, form) = (card.integer("fct1"), card.integer("h1"));
        if function != 0 {
            if form != 0 {
                let why = "springs that do not unload on their function (H1 other than 0)";
                self.deck.unsupported_value(card, "h1", why);
            }
            let points = self.points_of(function, card.place("fct1"))?;
            let rows: Vec<Vec<f64>> =
                points.iter().map(|p| vec![p[0] * stretch, p[1] * scale]).collect();
            spring.put("force_elongation", card.place("fct1"), rows);
            // With a function K1 is for unloading only.
            card.real("k1");
        } else {
            spring.put("stiffness", card.place("k1"), card.real("k1"));
        }
        if card.real("c1") != 0.0 {
            spring.put("damping", card.place("c1"), card.real("c1"));
        }
        Some(spring)
    }
}
