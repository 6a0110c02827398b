//! Converts spot welds as solids: limits of `*MAT_SPOTWELD...` and
//! `*DEFINE_HEX_SPOTWELD_ASSEMBLY` (LS-DYNA Keyword User's Manual, vol. II, material 100).

use super::DeckConverter;
use super::materials::DeckMaterial;
use super::space::cross;
use super::tree::JobTable;
use crate::input::deck::record::CardRecord;
use crate::input::job::tree::Place;
use crumple_proto::ids::NodeId;
use std::collections::{BTreeMap, HashMap, HashSet};

/// Largest area of a weld over the smallest one, of the welds of a material with limits as forces.
const LARGEST_RATIO: f64 = 1.2;

/// Limits of the stress in a weld: normal and shear.
const KEYS: [&str; 2] = ["erosion_weld_normal_stress", "erosion_weld_shear_stress"];

/// Limits of welds of a material, 0 for none.
#[derive(Clone, Copy, Debug)]
pub enum WeldLimits {
    /// Normal and shear force [force], bending and torsional moment [force length].
    Forces([f64; 4]),
    /// Normal and shear stress [force/length^2].
    Stresses([f64; 2]),
}

impl DeckConverter {
    /// Converts `*MAT_SPOTWELD_DAMAGE-FAILURE`, and returns the limits of its welds.
    pub(super) fn failing_weld(
        &mut self,
        record: &CardRecord,
        table: &mut JobTable,
    ) -> Option<(WeldLimits, Place)> {
        let weld = self.spot_weld(record, table);
        let (start, rupture) = (record.real("efail"), record.real("rs"));
        if rupture > 0.0 {
            if rupture > start && record.real("sigy") > 0.0 {
                table.remove("failure_strain");
                table.put("softening", record.place("rs"), [start, rupture]);
            } else {
                let why = "damage without a yield stress (sigy), or complete at efail or before";
                self.unsupported_value(record, "rs", why);
            }
        }
        if rupture > 0.0 && record.integer("asff") == 0 {
            self.weld_alone.insert(record.integer("mid"));
        }
        for (field, why) in [
            ("beta", "damage by another law than that of a straight line"),
            ("dmgopt", "another course of damage than that by plastic strain: use 0"),
        ] {
            if record.real(field) != 0.0 {
                self.unsupported_value(record, field, why);
            }
        }
        let place = record.place("nrr");
        match record.real("opt") {
            0.0 => {
                self.check_weld_directions(record);
                weld
            }
            1.0 => {
                let limits = ["nrr", "nrs"].map(|field| record.real(field).max(0.0));
                let given = limits.iter().any(|&limit| limit > 0.0);
                given.then_some((WeldLimits::Stresses(limits), place))
            }
            _ => {
                let why = "use 0 (forces) or 1 (stresses, with sigax as nrr and sigsh as nrs)";
                self.unsupported_value(record, "opt", why);
                None
            }
        }
    }

    /// Converts assemblies of solids, and gives the materials of welds as solids their limits.
    pub(super) fn solid_welds(&mut self, materials: &mut HashMap<i64, DeckMaterial>) {
        let at: HashMap<u64, usize> =
            self.rows.solids.iter().enumerate().map(|(at, e)| (e.id.label(), at)).collect();
        let assemblies = self.assemblies(&at, materials);
        let mut member: HashMap<usize, usize> = HashMap::new();
        for (number, solids) in assemblies.iter().enumerate() {
            member.extend(solids.iter().map(|&solid| (solid, number)));
        }
        let mut parts: BTreeMap<i64, (Vec<i64>, Place)> = BTreeMap::new();
        for (part, mid, place) in std::mem::take(&mut self.weld_parts) {
            parts.entry(mid).or_insert((Vec::new(), place)).0.push(part);
        }
        for (mid, (parts, place)) in parts {
            let Some(material) = materials.get_mut(&mid) else { continue };
            let Some((limits, at)) = material.weld else { continue };
            if self.weld_beams.contains(&mid) {
                let message =
                    format!("material {mid} is that of spot welds as beams and as solids");
                let help = "give the beams and the solids materials of their own";
                self.trouble.error(place, message, help);
                continue;
            }
            let stresses = match limits {
                WeldLimits::Stresses(stresses) => stresses,
                WeldLimits::Forces(forces) => {
                    let Some(area) = self.area_of_welds(mid, &parts, &member, place) else {
                        continue;
                    };
                    if forces[2..] != [0.0; 2] {
                        let of = format!("material {mid}");
                        let why = "not used: solids of one point have no moment";
                        self.map(of, "mss, mtt, mrr of spot welds as solids", why);
                    }
                    let asked = format!("forces {}, {} of spot welds", forces[0], forces[1]);
                    let used = format!("stresses: forces over the mean area {area:.6} of a weld");
                    self.map(format!("material {mid}"), asked, used);
                    [forces[0] / area, forces[1] / area]
                }
            };
            if let Some(table) = &mut material.table {
                for (key, limit) in KEYS.into_iter().zip(stresses).filter(|(_, s)| *s > 0.0) {
                    table.put(key, at, limit);
                }
            }
        }
    }

    /// Reads assemblies, adds those of two solids and more that can fail to the job, and returns
    /// the solids of each, by index.
    fn assemblies(
        &mut self,
        at: &HashMap<u64, usize>,
        materials: &HashMap<i64, DeckMaterial>,
    ) -> Vec<Vec<usize>> {
        let fails = |material: &&DeckMaterial| {
            let has = |table: &JobTable| {
                table.has("failure_strain") || table.has("softening") || table.has_start("erosion_")
            };
            material.weld.is_some() || material.table.as_ref().is_some_and(has)
        };
        let names = |chosen: &dyn Fn(i64, &DeckMaterial) -> bool| -> HashSet<&str> {
            let chosen = materials.iter().filter(|(mid, material)| chosen(**mid, material));
            chosen.map(|(_, material)| material.name.as_str()).collect()
        };
        let fallible = names(&|_, material| fails(&material));
        let alone = names(&|mid, _| self.weld_alone.contains(&mid));
        let some_left_out = self.left_out.has_parts();
        let mut all = Vec::new();
        for record in self.take_records("DEFINE_HEX_SPOTWELD_ASSEMBLY") {
            let id = record.integer("id_sw");
            let mut solids = Vec::new();
            for line in record.lines("eid") {
                for (eid, place) in line.integers("eid").filter(|eid| eid.0 != 0) {
                    let raised = u64::try_from(eid).map(|eid| eid + self.rows.raised[0]);
                    match raised.ok().and_then(|eid| at.get(&eid)) {
                        Some(&solid) => solids.push(solid),
                        // It may have been left out with its part.
                        None if some_left_out => {
                            let why = "not used: there is no such solid";
                            self.map(record.name(), format!("solid {eid} of weld {id}"), why);
                        }
                        None => {
                            let message = format!("{}: there is no solid {eid}", record.name());
                            let help = "list solids of the deck, or remove it";
                            self.trouble.error(place, message, help);
                        }
                    }
                }
            }
            let have = |names: &HashSet<&str>| {
                solids.iter().all(|&solid| {
                    let part = i64::from(self.rows.solids[solid].part);
                    let name = self.parts.get(&part).and_then(|part| part.material.as_deref());
                    name.is_some_and(|name| names.contains(name))
                })
            };
            let (can_fail, one_by_one) = (have(&fallible), have(&alone));
            if !can_fail || one_by_one {
                let why = match can_fail {
                    true => "its solids fail one by one (asff 0 with damage)",
                    false => "not used: its material has no criterion of failure",
                };
                self.map(record.name(), format!("weld {id}"), why);
            } else if solids.len() > 1 {
                let ids: Vec<i64> =
                    solids.iter().map(|&solid| self.rows.solids[solid].id.label() as i64).collect();
                let group = JobTable::new(record.head)
                    .with("name", record.place("id_sw"), format!("weld-{id}"))
                    .with("elements", record.place("eid"), ids);
                self.add("failure_group", group);
            }
            all.push(solids);
        }
        all
    }

    /// Returns the mean area of the welds of some parts; `member` is the assembly of a solid.
    /// `None` after an error.
    fn area_of_welds(
        &mut self,
        mid: i64,
        parts: &[i64],
        member: &HashMap<usize, usize>,
        place: Place,
    ) -> Option<f64> {
        let own: Vec<(usize, Vec<NodeId>)> = self
            .rows
            .solids
            .iter()
            .enumerate()
            .filter(|(_, e)| parts.contains(&i64::from(e.part)))
            .map(|(at, e)| (at, e.corners().to_vec()))
            .collect();
        let mut alone: Vec<f64> = Vec::new();
        let mut together: BTreeMap<usize, f64> = BTreeMap::new();
        for (solid, nodes) in own {
            let [Some(lower), Some(upper)] = [nodes.get(..4), nodes.get(4..8)] else {
                let message = format!(
                    "material {mid}: solid {} is a spot weld with limits, and no hexahedron",
                    self.rows.solids[solid].id.label()
                );
                let help = "mesh welds with hexahedra, or use beams";
                self.trouble.error(place, message, help);
                return None;
            };
            let area = 0.5 * (self.area(lower)? + self.area(upper)?);
            match member.get(&solid) {
                Some(&assembly) => *together.entry(assembly).or_default() += area,
                None => alone.push(area),
            }
        }
        let areas: Vec<f64> = alone.into_iter().chain(together.into_values()).collect();
        let (least, most) =
            areas.iter().fold((f64::INFINITY, 0.0_f64), |(l, m), &a| (l.min(a), m.max(a)));
        if areas.is_empty() {
            return None;
        }
        if most > LARGEST_RATIO * least {
            let message = format!(
                "material {mid}: its spot welds have areas from {least:.4} to {most:.4}, and its \
                 limits are forces"
            );
            let help = "give welds of different sizes materials of their own, or list the solids \
                        of each weld in *DEFINE_HEX_SPOTWELD_ASSEMBLY";
            self.trouble.error(place, message, help);
            return None;
        }
        Some(areas.iter().sum::<f64>() / areas.len() as f64)
    }

    /// Returns the area of a face of four nodes [length^2].
    fn area(&mut self, nodes: &[NodeId]) -> Option<f64> {
        let x: Vec<[f64; 3]> = nodes.iter().filter_map(|&n| self.rows.at(n)).collect();
        let [a, b, c, d] = x[..] else { return None };
        let side =
            |from: [f64; 3], to: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| to[i] - from[i]) };
        let normal = cross(side(a, c), side(b, d));
        Some(0.5 * normal.iter().map(|n| n * n).sum::<f64>().sqrt())
    }
}
