//! Converts particles: `*ELEMENT_SPH`, parts with a `*SECTION_SPH`, `*CONTROL_SPH`.

use super::DeckConverter;
use super::equations::{GRUNEISEN, MURNAGHAN};
use super::materials::DeckMaterial;
use super::sections::{DeckSection, Sections};
use super::sets::id;
use super::tree::JobTable;
use crate::input::deck::record::{CardLine, CardRecord};
use crumple_proto::ids::{ElemId, NodeId};
use std::collections::BTreeSet;

/// Constants of `*EOS_LINEAR_POLYNOMIAL` that are 0 for a pressure linear in the density.
const NOT_LINEAR: [&str; 5] = ["c2", "c3", "c4", "c5", "c6"];

/// Largest difference of masses of a part that counts as equal, over the mass: cards have eight
/// digits or more.
const EQUAL: f64 = 1e-6;

/// Speed of particles from which on a limit is none, in the units of any deck: light in mm/s has
/// 3e11.
const FASTEST: f64 = 1e12;

/// Forms of the sums for fluids that are not those of the engine.
const OTHER_FORMS: [i64; 6] = [1, 3, 5, 6, 15, 16];

/// Size of a particle as the deck gives it.
#[derive(Clone, Copy, Debug)]
pub enum ParticleSize {
    /// Mass [mass].
    Mass(f64),
    /// Volume [length^3].
    Volume(f64),
}

impl ParticleSize {
    /// Returns the spacing of particles with this density [length].
    pub(in crate::input::deck) fn spacing(self, density: f64) -> f64 {
        match self {
            Self::Mass(mass) => (mass / density).cbrt(),
            Self::Volume(volume) => volume.cbrt(),
        }
    }

    fn is(self, other: Self) -> bool {
        let equal = |a: f64, b: f64| (a - b).abs() <= EQUAL * a;
        match (self, other) {
            (Self::Mass(a), Self::Mass(b)) | (Self::Volume(a), Self::Volume(b)) => equal(a, b),
            _ => false,
        }
    }
}

/// Returns the speed of sound without pressure, for the pressure `k0 ((rho/density)^gamma - 1)`
/// [length/time].
pub(in crate::input::deck) fn sound_speed(k0: f64, gamma: f64, density: f64) -> f64 {
    (k0 * gamma / density).sqrt()
}

impl DeckConverter {
    /// Converts the elements and `*CONTROL_SPH`.
    pub(super) fn particles(&mut self) {
        self.control_sph();
        let records = self.take_records("ELEMENT_SPH");
        if records.is_empty() {
            return;
        }
        let mut all: Vec<NodeId> = self.rows.nodes.iter().map(|node| node.id).collect();
        all.sort_unstable();
        all.dedup();
        let mut next = self.rows.elements().map(|e| e.id.0).max().unwrap_or(0);
        let mut seen = BTreeSet::new();
        for record in &records {
            for line in record.lines("nid") {
                let Some((nodes, part)) = self.particle_ids(record, line, &all) else { continue };
                if !self.particle_size(record, line, part) {
                    continue;
                }
                for node in nodes {
                    if !seen.insert(node) {
                        let message = format!("{}: node {node} is a particle twice", record.name());
                        self.trouble.error(line.place("nid"), message, "remove one of the lines");
                        continue;
                    }
                    next = next.saturating_add(1);
                    self.rows.particle(ElemId(next), part, node, line.place);
                }
            }
        }
    }

    /// Returns nodes and part of a line; `all` has the ids of all nodes, ascending.
    fn particle_ids(
        &mut self,
        record: &CardRecord,
        line: &CardLine,
        all: &[NodeId],
    ) -> Option<(Vec<NodeId>, u32)> {
        let (first, last) = (line.integer("nid"), line.integer("nend"));
        let part = u32::try_from(line.integer("pid")).ok().filter(|&part| part > 0);
        let (Some(node), Some(part)) = (id(first), part) else {
            let message = format!("{}: particle {first} has an invalid id", record.name());
            let help = "give whole numbers above 0; the largest part id is 4294967295";
            self.trouble.error(line.place, message, help);
            return None;
        };
        if last == 0 {
            return Some((vec![node], part));
        }
        let last = id(last).filter(|&last| last >= node);
        let nodes = last.map_or(&[][..], |last| {
            &all[all.partition_point(|&n| n < node)..all.partition_point(|&n| n <= last)]
        });
        if last.is_none_or(|last| nodes.len() as u64 != last.0 - node.0 + 1) {
            let message = format!(
                "{}: not all nodes from {node} to nend = {} exist",
                record.name(),
                line.integer("nend")
            );
            let help = "give the last node of a range without gaps, or a line for each node";
            self.trouble.error(line.place("nend"), message, help);
            return None;
        }
        Some((nodes.to_vec(), part))
    }

    /// Notes mass or volume of a particle. Returns false after an error.
    fn particle_size(&mut self, record: &CardRecord, line: &CardLine, part: u32) -> bool {
        let (given, place) = (line.real("mass"), line.place("mass"));
        if given == 0.0 || !given.is_finite() {
            let message = format!("{}: `mass` is {given}", record.name());
            let help = "give a mass above 0, or a volume as a number below 0";
            self.trouble.error(place, message, help);
            return false;
        }
        let size = match given < 0.0 || record.has("VOLUME") {
            true => ParticleSize::Volume(given.abs()),
            false => ParticleSize::Mass(given),
        };
        let first = self.particle_sizes.entry(i64::from(part)).or_insert((size, place)).0;
        if !first.is(size) {
            let message = format!(
                "{}: part {part} has particles of different sizes ({first:?} and {size:?}), which \
                 is not supported: give those of each size a part of their own",
                record.name()
            );
            self.unsupported(place, message, format!("{} mass", record.name()));
        }
        true
    }

    /// Reads the form of the sums and the number of dimensions.
    fn control_sph(&mut self) {
        for record in self.take_records("CONTROL_SPH") {
            if ![0, 3].contains(&record.integer("idim")) {
                let why = "particles move in three dimensions; use 3";
                self.unsupported_value(&record, "idim", why);
            }
            if record.real("maxv") < FASTEST {
                let why = "particles are not deleted at a speed; leave it blank";
                self.unsupported_value(&record, "maxv", why);
            }
            match record.integer("form") {
                0 | 2 => {}
                form if OTHER_FORMS.contains(&form) => {
                    let message = format!("{}: `form` = {form} is ignored", record.name());
                    let help = "the sums are those of form 2: without renormalisation, for \
                                particles of about equal density; see docs/theory/particles.md";
                    self.trouble.warning(record.place("form"), message, help);
                }
                _ => {
                    let why = "it is no form for a fluid; use 0 or 2";
                    self.unsupported_value(&record, "form", why);
                }
            }
        }
    }

    /// Converts a part of particles.
    pub(super) fn particle_part(
        &mut self,
        record: &CardRecord,
        name: &str,
        material: &DeckMaterial,
        (section, sections): (&DeckSection, &Sections),
    ) {
        let (pid, card) = (record.integer("pid"), &section.record);
        let Some(null) = &material.fluid else {
            let message = format!(
                "part {pid}: particles are a fluid, but material {} is none",
                record.integer("mid")
            );
            let help = "give the part a *MAT_NULL and an *EOS_MURNAGHAN or *EOS_GRUNEISEN";
            return self.trouble.error(record.place("mid"), message, help);
        };
        let Some(&(size, at)) = self.particle_sizes.get(&pid) else {
            let message = format!("part {pid} has a *SECTION_SPH, but no particles");
            let help = "add its *ELEMENT_SPH, or remove the part";
            return self.trouble.error(record.place("pid"), message, help);
        };
        let density = null.real("ro");
        let spacing = size.spacing(density);
        let mut fluid = JobTable::new(card.head).with("spacing", at, spacing).with(
            "density",
            null.place("ro"),
            density,
        );
        let Some(asked) = self.fluid_pressure(record, density, &mut fluid) else { return };
        if let Some(table) = &material.table
            && table.has_start("erosion")
        {
            let message = format!("part {pid}: *MAT_ADD_EROSION of particles is not supported");
            self.unsupported(record.place("mid"), message, "*MAT_ADD_EROSION of particles".into());
        }
        let (cslh, sphini) = (card.real("cslh"), card.real("sphini"));
        if sphini > 0.0 {
            fluid.put("smoothing", card.place("sphini"), sphini / spacing);
        } else if cslh != 0.0 {
            fluid.put("smoothing", card.place("cslh"), cslh);
        }
        let [hmin, hmax] = ["hmin", "hmax"].map(|field| card.real(field));
        if [hmin, hmax] != [1.0; 2] {
            let asked = format!("hmin {hmin}, hmax {hmax}");
            self.map(card.name(), asked, "a constant smoothing length, as with 1 and 1");
        }
        self.check_hourglass(record, sections);
        let viscosity = sections.bulk_viscosity(record.integer("hgid"));
        if let Some((bulk, place)) = viscosity {
            fluid.put("viscosity", place, bulk);
        }
        self.fluid_tension(null, viscosity.map_or(1.0, |(bulk, _)| bulk[0]), &mut fluid);
        let mut used = format!("particles with a spacing of {spacing}");
        if viscosity.is_none() {
            used += "; the default viscosity of a job, since the deck has none";
        }
        self.map(format!("part {pid}"), asked, used);
        let mut table = JobTable::new(record.head)
            .with("id", record.place("pid"), pid)
            .with("name", record.place("heading"), name)
            .with("particles", card.head, fluid);
        self.contact_card(record, pid, section.kind, &mut table);
        self.add("part", table);
    }

    /// Sets speed of sound and exponent of a fluid by the equation of state of its part. Returns
    /// the name of the equation; `None` after an error.
    fn fluid_pressure(
        &mut self,
        record: &CardRecord,
        density: f64,
        fluid: &mut JobTable,
    ) -> Option<String> {
        let (pid, eosid, place) =
            (record.integer("pid"), record.integer("eosid"), record.place("eosid"));
        if eosid == 0 {
            let message = format!("part {pid}: particles need an equation of state");
            self.trouble.error(
                place,
                message,
                "give eosid, the id of an *EOS_MURNAGHAN or *EOS_GRUNEISEN",
            );
            return None;
        }
        let equation = self.equation_card(eosid, place)?;
        let (modulus, gamma) = match equation.row.keyword.name {
            GRUNEISEN => {
                fluid.put("sound_speed", equation.place("c"), equation.real("c"));
                let constants = ["s1", "s2", "s3", "gamao", "a"].map(|field| equation.real(field));
                fluid.put("hugoniot", equation.place("s1"), constants);
                return Some(equation.name());
            }
            MURNAGHAN => ("k0", equation.real("gamma")),
            "EOS_LINEAR_POLYNOMIAL" if NOT_LINEAR.iter().all(|c| equation.real(c) == 0.0) => {
                ("c1", 1.0)
            }
            _ => {
                let message =
                    format!("part {pid}: {} of particles is not supported", equation.name());
                let help = "use *EOS_GRUNEISEN, or *EOS_MURNAGHAN with k0 = ro c^2 / gamma and the \
                            speed of sound c; gamma is 7 for water";
                self.trouble.error(place, message, help);
                return None;
            }
        };
        let c = sound_speed(equation.real(modulus), gamma, density);
        fluid.put("sound_speed", equation.place(modulus), c);
        let exponent = if modulus == "k0" { "gamma" } else { modulus };
        fluid.put("exponent", equation.place(exponent), gamma);
        Some(equation.name())
    }

    /// Sets the tension of a fluid, and refuses what particles do not have. `alpha` is the linear
    /// coefficient of their viscosity.
    fn fluid_tension(&mut self, null: &CardRecord, alpha: f64, fluid: &mut JobTable) {
        let cutoff = null.real("pc");
        if cutoff > 0.0 {
            self.unsupported_value(null, "pc", "a cutoff above 0; use minus the largest tension");
        } else if cutoff < 0.0 {
            fluid.put("tension", null.place("pc"), -cutoff);
        }
        let mu = null.real("mu");
        let number = |key| fluid.float(key).unwrap_or(0.0);
        // About the viscosity of a flow that the artificial one stands for.
        let artificial =
            0.1 * alpha * number("density") * number("sound_speed") * number("spacing");
        if mu > 0.01 * artificial {
            let why = "particles have the artificial viscosity only, which has to be far larger";
            self.unsupported_value(null, "mu", why);
        } else if mu != 0.0 {
            let why =
                format!("not used: the artificial viscosity is {:.0e} times it", artificial / mu);
            self.map(null.name(), format!("mu {mu:?}"), why);
        }
        for (field, why) in [
            ("terod", "particles are not deleted; use 0"),
            ("cerod", "particles are not deleted; use 0"),
        ] {
            if null.real(field) != 0.0 {
                self.unsupported_value(null, field, why);
            }
        }
    }
}
