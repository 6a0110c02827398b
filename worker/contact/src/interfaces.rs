//! Contact interfaces: the interface of two parts, its thickness and its friction.
//!
//! Surface, search and solver are common to all interfaces. A pair belongs to the interface of
//! its two parts. If a node or an edge belongs to several parts, the pair belongs to the last of
//! their interfaces. An interface can hold in one direction only: for nodes of one part and
//! segments of the other.

use crate::beams;
use crate::friction_table::FrictionTable;
use crumple_proto::job::{ContactInput, Part};

/// Entry for two parts that do not touch.
const NONE: u16 = u16::MAX;

/// Interfaces of a job. The first one is `[contact]` itself.
#[derive(Clone, Debug)]
pub struct Interfaces {
    numbers: Vec<InterfaceSettings>,
    /// Interface of the nodes of a part with the segments of another one, by their indices, with a
    /// row for the nodes of each part; empty if there is one interface and all parts of the surface
    /// are in it.
    table: Vec<u16>,
    /// Number of parts.
    parts: usize,
    /// Largest factor of a thickness, 1 or above, and the largest half thickness that replaces
    /// the shells' own [length].
    widest: (f64, f64),
    /// Smallest factor of a thickness, 1 or below, and the smallest half thickness that replaces
    /// the shells' own [length].
    narrowest: (f64, f64),
}

/// Data of an interface, apart from its law.
#[derive(Clone, Debug)]
struct InterfaceSettings {
    /// Half thickness of shells that replaces their own [length].
    half: Option<f64>,
    /// Factor of the thickness of shells.
    factor: f64,
    /// True if shells touch at their middle surface, see [`ContactInput::shell_offset`].
    shell_offset: bool,
    /// True if only the nodes of one side are held, see [`ContactInput::one_way`].
    one_way: bool,
    friction: f64,
    dynamic: f64,
    /// Decay constant of friction [time/length].
    decay: f64,
    /// Largest shear stress of friction [force/length^2].
    limit: f64,
    /// Coefficients by pressure and speed, which replace the three above.
    table: Option<FrictionTable>,
    birth: f64,
    death: f64,
}

impl Default for Interfaces {
    fn default() -> Self {
        Self::new(&ContactInput::default(), &[])
    }
}

impl Interfaces {
    /// Builds the interfaces of a job's contact, with its parts.
    pub fn of_parts(contact: &ContactInput, parts: &[Part]) -> Self {
        let ids: Vec<u32> = parts.iter().map(|p| p.id).collect();
        Self::with(contact, &ids, |part| beams::has_bars(&parts[part]))
    }

    /// Builds the interfaces of a job's contact, with the ids of its parts by their indices.
    /// None of the parts is of beams.
    pub fn new(contact: &ContactInput, parts: &[u32]) -> Self {
        Self::with(contact, parts, |_| false)
    }

    fn with(contact: &ContactInput, parts: &[u32], is_beam: impl Fn(usize) -> bool) -> Self {
        let all: Vec<ContactInput> = contact.each().collect();
        let numbers: Vec<InterfaceSettings> = all.iter().map(InterfaceSettings::new).collect();
        let mut table = Vec::new();
        if !contact.interface.is_empty() || !contact.against.is_empty() {
            table = vec![NONE; parts.len() * parts.len()];
            for (i, c) in (0u16..).zip(&all) {
                let interface = if c.law == ContactInput::NO_LAW { NONE } else { i };
                let named = |part: &usize| c.has_beams() || !is_beam(*part);
                let [ahead, behind] = c.sides(parts);
                for &a in ahead.iter().filter(|a| named(a)) {
                    for &b in behind.iter().filter(|b| named(b)) {
                        table[a * parts.len() + b] = interface;
                        if !c.one_way {
                            table[b * parts.len() + a] = interface;
                        }
                    }
                }
            }
        }
        let (own, given): (Vec<&InterfaceSettings>, Vec<&InterfaceSettings>) =
            numbers.iter().partition(|n| n.half.is_none());
        let range = |of: &[&InterfaceSettings], start: (f64, f64)| {
            let sizes = of.iter().map(|n| n.half.unwrap_or(1.0) * n.factor);
            sizes.fold(start, |(low, high), s| (low.min(s), high.max(s)))
        };
        let (factors, halves) = (range(&own, (1.0, 1.0)), range(&given, (f64::INFINITY, 0.0)));
        let (narrowest, widest) = ((factors.0, halves.0), (factors.1, halves.1));
        Self { numbers, table, parts: parts.len(), widest, narrowest }
    }

    /// Returns true if a part touches any part.
    pub fn takes_part(&self, part: usize) -> bool {
        let touches = |other: usize| {
            [(part, other), (other, part)]
                .iter()
                .any(|(a, b)| self.table[a * self.parts + b] != NONE)
        };
        self.is_one() || (0..self.parts).any(touches)
    }

    /// Returns true if all parts on the surface touch in the same way.
    pub fn is_one(&self) -> bool {
        self.table.is_empty()
    }

    /// Returns the interface of a node that belongs to the parts `ahead` with a segment that
    /// belongs to the parts `behind`, both given by indices; `None` if they do not touch.
    pub fn for_node(
        &self,
        ahead: impl Iterator<Item = u32>,
        behind: impl Iterator<Item = u32> + Clone,
    ) -> Option<u16> {
        if self.is_one() {
            return Some(0);
        }
        ahead.flat_map(|a| behind.clone().filter_map(move |b| self.cell(a, b))).max()
    }

    /// Returns the interface of two edges or two segments that belong to the parts `ahead` and
    /// `behind`, given by indices; `None` if they do not touch. Interfaces of one direction have
    /// none.
    pub fn for_pair(
        &self,
        ahead: impl Iterator<Item = u32>,
        behind: impl Iterator<Item = u32> + Clone,
    ) -> Option<u16> {
        if self.is_one() {
            return Some(0);
        }
        let mutual = |i: &u16| !self.numbers[*i as usize].one_way;
        let either = |a: u32, b: u32| {
            [self.cell(a, b), self.cell(b, a)].into_iter().flatten().filter(mutual).max()
        };
        ahead.flat_map(|a| behind.clone().filter_map(move |b| either(a, b))).max()
    }

    /// Returns the interface of the nodes of a part with the segments of another one.
    fn cell(&self, nodes: u32, segments: u32) -> Option<u16> {
        let place = nodes as usize * self.parts + segments as usize;
        Some(self.table[place]).filter(|&i| i != NONE)
    }

    /// Returns half thickness and scale in an interface of an entity that has `half` and `scale`
    /// on the surface [length]. An entity without thickness belongs to a solid.
    pub fn measure(&self, interface: u16, (half, scale): (f64, f64)) -> (f64, f64) {
        let measured = self.numbers[interface as usize].measured(half);
        if measured == half {
            return (half, scale);
        }
        // A node of solids and shells has the larger of the two scales.
        (measured, if scale == half { measured } else { scale.max(measured) })
    }

    /// Returns the largest value that two sizes on the surface with the sum `sum` can have in an
    /// interface [length].
    pub fn most(&self, sum: f64) -> f64 {
        self.widest.0 * sum + 2.0 * self.widest.1
    }

    /// Returns the smallest value that a size on the surface can have in an interface [length].
    pub fn least(&self, size: f64) -> f64 {
        (self.narrowest.0 * size).min(self.narrowest.1)
    }

    /// Returns true if shells touch at their middle surface in an interface.
    pub fn has_shell_offset(&self, interface: u16) -> bool {
        self.numbers[interface as usize].shell_offset
    }

    /// Returns true if shells touch at their middle surface in any interface.
    pub fn have_shell_offset(&self) -> bool {
        self.numbers.iter().any(|n| n.shell_offset)
    }

    /// Returns true if an interface has friction at any speed.
    pub fn has_friction(&self, interface: u16) -> bool {
        let n = &self.numbers[interface as usize];
        match &n.table {
            Some(table) => table.largest() > 0.0,
            None => n.friction > 0.0 || n.dynamic > 0.0,
        }
    }

    /// Returns true if any interface has friction.
    pub fn have_friction(&self) -> bool {
        (0..self.count() as u16).any(|i| self.has_friction(i))
    }

    /// Computes the coefficient of friction at a sliding speed [length/time] and a contact
    /// pressure [force/length^2].
    pub fn friction(&self, interface: u16, speed: impl Fn() -> f64, pressure: f64) -> f64 {
        let n = &self.numbers[interface as usize];
        if let Some(table) = &n.table {
            return table.coefficient(pressure, speed());
        }
        if n.decay == 0.0 || n.dynamic == n.friction {
            return n.friction;
        }
        n.dynamic + (n.friction - n.dynamic) * (-n.decay * speed()).exp()
    }

    /// Returns the largest shear stress of friction, infinite without a limit [force/length^2].
    pub fn friction_limit(&self, interface: u16) -> f64 {
        self.numbers[interface as usize].limit
    }

    /// Returns true if friction depends on the contact pressure in an interface.
    pub fn has_friction_by_pressure(&self, interface: u16) -> bool {
        let n = &self.numbers[interface as usize];
        n.limit < f64::INFINITY || n.table.is_some()
    }

    /// Returns true if friction depends on the contact pressure in any interface.
    pub fn have_friction_by_pressure(&self) -> bool {
        (0..self.count() as u16).any(|i| self.has_friction_by_pressure(i))
    }

    /// Returns true if an interface is active at a time.
    pub fn is_alive(&self, interface: u16, time: f64) -> bool {
        let n = &self.numbers[interface as usize];
        n.birth <= time && time < n.death
    }

    /// Returns true if an interface has ended by a time.
    pub fn is_over(&self, interface: u16, time: f64) -> bool {
        time >= self.numbers[interface as usize].death
    }

    /// Returns the number of interfaces.
    pub fn count(&self) -> usize {
        self.numbers.len()
    }
}

impl InterfaceSettings {
    fn new(contact: &ContactInput) -> Self {
        Self {
            half: contact.thickness.map(|t| 0.5 * t),
            factor: contact.thickness_scale,
            shell_offset: contact.shell_offset,
            one_way: contact.one_way,
            friction: contact.friction,
            dynamic: contact.friction_dynamic.unwrap_or(contact.friction),
            decay: contact.friction_decay,
            limit: contact.friction_limit.filter(|&limit| limit > 0.0).unwrap_or(f64::INFINITY),
            table: FrictionTable::new(&contact.friction_table),
            birth: contact.birth,
            death: contact.death.unwrap_or(f64::INFINITY),
        }
    }

    /// Returns the half thickness in this interface of a shell that has `half` on the surface
    /// [length].
    fn measured(&self, half: f64) -> f64 {
        if half > 0.0 { self.half.unwrap_or(half) * self.factor } else { half }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::job::Interface;

    const PARTS: [u32; 3] = [1, 2, 4];

    fn contact(law: &str, interface: Vec<Interface>) -> ContactInput {
        ContactInput { law: law.into(), interface, ..ContactInput::default() }
    }

    fn between(i: &Interfaces, a: u32, b: u32) -> Option<u16> {
        i.for_pair([a].into_iter(), [b].into_iter())
    }

    #[test]
    fn the_last_interface_that_names_two_parts_holds_for_them() {
        let pair = Interface { parts: vec![1], against: vec![2], ..Interface::default() };
        let off = Interface {
            parts: vec![1],
            against: vec![2, 4],
            law: Some("none".into()),
            ..Interface::default()
        };
        let only = Interfaces::new(&contact("none", vec![pair.clone()]), &PARTS);
        assert_eq!([between(&only, 0, 1), between(&only, 1, 0)], [Some(1), Some(1)], "either way");
        assert_eq!([between(&only, 0, 0), between(&only, 1, 1), between(&only, 2, 0)], [None; 3]);
        assert_eq!([0, 1, 2].map(|p| only.takes_part(p)), [true, true, false]);
        let later = Interfaces::new(&contact("lagrange", vec![off.clone(), pair.clone()]), &PARTS);
        assert_eq!(
            [between(&later, 0, 1), between(&later, 0, 2), between(&later, 0, 0)],
            [Some(2), None, Some(0)]
        );
        let earlier = Interfaces::new(&contact("lagrange", vec![pair, off]), &PARTS);
        assert_eq!([between(&earlier, 0, 1), between(&earlier, 1, 2)], [None, Some(0)]);
        let of_two = earlier.for_pair([0, 1].into_iter(), [2].into_iter());
        assert_eq!(
            of_two,
            Some(0),
            "a node of two parts has the interface of the part with contact"
        );
    }

    /// Nodes of part 1 meet segments of part 2. An interface of both directions stays for the other
    /// one, and for edges.
    #[test]
    fn an_interface_of_one_way_holds_the_nodes_of_its_parts() {
        let one_way =
            Interface { parts: vec![1], against: vec![2], one_way: true, ..Interface::default() };
        let node = |i: &Interfaces, a: u32, b: u32| i.for_node([a].into_iter(), [b].into_iter());
        let alone = Interfaces::new(&contact("none", vec![one_way.clone()]), &PARTS);
        assert_eq!([node(&alone, 0, 1), node(&alone, 1, 0)], [Some(1), None]);
        assert_eq!([between(&alone, 0, 1), between(&alone, 1, 0)], [None; 2]);
        assert_eq!([0, 1, 2].map(|p| alone.takes_part(p)), [true, true, false]);
        let over_all = Interfaces::new(&contact("lagrange", vec![one_way.clone()]), &PARTS);
        assert_eq!([node(&over_all, 0, 1), node(&over_all, 1, 0)], [Some(1), Some(0)]);
        assert_eq!([between(&over_all, 0, 1), between(&over_all, 1, 0)], [Some(0); 2]);
        let back =
            Interface { parts: vec![2], against: vec![1], one_way: true, ..Interface::default() };
        let both = Interfaces::new(&contact("none", vec![one_way, back]), &PARTS);
        assert_eq!([node(&both, 0, 1), node(&both, 1, 0)], [Some(1), Some(2)]);
        assert_eq!(between(&both, 0, 1), None);
    }

    #[test]
    fn parts_without_against_meet_each_other_and_themselves_but_for_what_is_excluded() {
        let own = Interface { parts: vec![1, 2], exclude: vec![2], ..Interface::default() };
        let i = Interfaces::new(&contact("none", vec![own]), &PARTS);
        assert_eq!(
            [between(&i, 0, 0), between(&i, 0, 1), between(&i, 1, 1)],
            [Some(1), None, None]
        );
        let all = Interface { friction: Some(0.5), ..Interface::default() };
        let i = Interfaces::new(&contact("none", vec![all]), &PARTS);
        assert_eq!([between(&i, 0, 0), between(&i, 0, 2)], [Some(1); 2]);
    }

    #[test]
    fn an_interface_without_beams_says_nothing_of_them() {
        let own = Interface { parts: vec![1, 2], beams: Some(false), ..Interface::default() };
        let with = |c: ContactInput| Interfaces::with(&c, &PARTS, |part| part == 1);
        let i = with(contact("lagrange", vec![own.clone()]));
        assert_eq!(
            [between(&i, 0, 0), between(&i, 0, 1), between(&i, 1, 1)],
            [Some(1), Some(0), Some(0)]
        );
        let i = with(ContactInput {
            edges: false,
            ..contact("lagrange", vec![Interface { beams: None, ..own.clone() }])
        });
        assert_eq!(
            [between(&i, 0, 0), between(&i, 0, 1), between(&i, 1, 1)],
            [Some(1), None, None]
        );
        let some = Interface { beams: Some(true), ..own };
        let i = with(ContactInput { beams: Some(false), ..contact("lagrange", vec![some]) });
        assert_eq!(
            [between(&i, 0, 1), between(&i, 1, 2)],
            [Some(1), None],
            "only interface 1 has beams"
        );
        assert!(i.takes_part(1));
    }

    #[test]
    fn thickness_is_given_or_scaled() {
        let thick = Interface { thickness: Some(8.0), ..Interface::default() };
        let scaled = Interface { thickness_scale: Some(0.5), ..Interface::default() };
        let i = Interfaces::new(&contact("lagrange", vec![thick, scaled]), &PARTS);
        assert_eq!(i.measure(0, (0.5, 0.5)), (0.5, 0.5));
        assert_eq!(i.measure(1, (0.5, 0.5)), (4.0, 4.0));
        assert_eq!(i.measure(2, (0.5, 0.5)), (0.25, 0.25));
        assert_eq!(i.measure(1, (0.0, 0.7)), (0.0, 0.7), "solids have no thickness");
        assert_eq!(i.measure(2, (0.5, 0.7)), (0.25, 0.7), "the scale of a solid is unchanged");
        assert_eq!((i.most(0.5), i.least(3.0), i.least(9.0)), (0.5 + 8.0, 1.5, 4.0));
    }

    #[test]
    fn friction_falls_from_the_static_to_the_dynamic_one() {
        let job = ContactInput {
            friction: 0.4,
            friction_dynamic: Some(0.1),
            friction_decay: 2.0,
            ..ContactInput::default()
        };
        let i = Interfaces::new(&job, &PARTS);
        assert_eq!(i.friction(0, || 0.0, 0.0), 0.4);
        let expected = 0.1 + 0.3 * (-3.0f64).exp();
        assert!((i.friction(0, || 1.5, 0.0) - expected).abs() < 1e-15);
        let job = ContactInput { friction_decay: 0.0, ..job };
        assert_eq!(
            Interfaces::new(&job, &PARTS).friction(0, || 1e9, 0.0),
            0.4,
            "without decay, the static coefficient"
        );
    }

    #[test]
    fn an_interface_is_there_from_its_birth_to_its_death() {
        let i = Interfaces::new(
            &ContactInput { birth: 1.0, death: Some(2.0), ..ContactInput::default() },
            &PARTS,
        );
        assert_eq!([0.5, 1.0, 1.5, 2.0].map(|t| i.is_alive(0, t)), [false, true, true, false]);
    }
}
