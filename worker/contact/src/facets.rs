//! Contact of segments with segments, for laws that need it. A pair is the overlap of a quarter
//! of one segment with a quarter of another (`overlap.rs`).
//!
//! Two segments face each other if the product of their normals is below `-FACING`; each normal
//! is taken on the side where the other segment is. Both are projected onto the plane
//! perpendicular to the mean of these normals, so that neither is preferred. The segment with
//! the lower number is the slave, so that no pair exists twice. The worker of the slave owns the
//! pairs. Its ghosts reach as far around all nodes of own segments as around slaves
//! (`parallel/partition.rs`).
//!
//! This does not find nodes and edges of shells that stand on a face or touch another rim. There
//! nodes touch segments ([`Facets::covers`]), and edges touch edges.
//!
//! A new pair continues the history of a neighbouring pair, so that contact is not interrupted
//! where a surface slides over to the next segment. It takes the history of another pair of the
//! same quarter, or of the same slave, with the stick point. If there is none, it takes the
//! history of a neighbour of the slave on the same segment, without the stick point. This
//! neighbour may belong to another worker. Therefore the history of all pairs that are known
//! here is stored, not only of own pairs, as for edges.

use crate::geometry::Sphere;
use crate::local_search::{is_in_middle, moved, tolerated};
use crate::overlap::{Overlap, Plane, ProjectedSegment};
use crate::pairs::{Pair, PairHistory, PairKey};
use crate::reach::{ACTIVE, BEHIND, REACH};
use crate::search::{Search, accepted};
use crate::shell_offset;
use crate::surface::{NOT_LOCAL, Segment, Surface};
use crate::surroundings::Exclusions;
use crumple_fem::nodes::Nodes;
use crumple_math::row::{V3, xyz};
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::{NodeId, SegmentId};

/// Limit of the product of normals of facing segments, see above; an angle of about 70 degrees.
const FACING: f64 = 0.3;
/// Product of normals above which the histories of neighbouring pairs belong to the same
/// contact.
const ALIKE: f64 = 0.7;

/// History of a pair of segments.
#[derive(Clone, Copy, Debug)]
struct FacetPairHistory {
    memory: PairHistory,
    /// Local nodes of the slave, or [`NOT_LOCAL`].
    nodes: [u32; 4],
    /// True if this worker searches for the slave.
    own: bool,
}

/// Pairs of segments that could touch, and the pair histories of own segments.
#[derive(Debug, Default)]
pub struct Facets {
    /// For each interface, true if segments touch segments there.
    wanted: Vec<bool>,
    /// Contact stiffness of each segment over its initial area [force/length^3]; empty if not
    /// needed.
    stiffness: Vec<f64>,
    /// Slave segment and other segment of all pairs that could touch before the next search,
    /// ascending.
    found: Vec<[u32; 2]>,
    /// Those of `found` that are near.
    near: Vec<[u32; 2]>,
    /// Histories in ascending order of their keys.
    memories: Vec<FacetPairHistory>,
    /// Target segments of the histories, ascending, with the indices of the histories.
    by_met: Vec<(SegmentId, u32)>,
    /// True if the histories are as they were collected, with no step since then. They are then
    /// equal on all workers that have them.
    gathered: bool,
}

impl Facets {
    /// Returns an empty set of pairs. `wanted` states for each interface if segments touch
    /// segments there.
    pub fn new(wanted: Vec<bool>) -> Self {
        Self { wanted, ..Self::default() }
    }

    /// Returns true if there is an interface where segments touch segments.
    pub fn are_wanted(&self) -> bool {
        self.wanted.contains(&true)
    }

    /// Takes a new surface and collects the histories at its nodes. `stiffness` is per segment,
    /// or empty [force/length].
    pub fn renew(
        &mut self,
        surface: &Surface,
        stiffness: &[f64],
        nodes: &Nodes,
        memory_of: impl Fn(NodeId) -> Vec<PairHistory>,
    ) {
        if !self.are_wanted() {
            return;
        }
        let per_area = |(s, k): (&Segment, &f64)| {
            let [a, b, c, d] = s.corners(&nodes.x0);
            k / (0.5 * (c - a).cross(&(d - b)).norm())
        };
        self.stiffness = surface.segments.iter().zip(stiffness).map(per_area).collect();
        (self.found, self.near) = (Vec::new(), Vec::new());
        let mut corners: Vec<NodeId> = searched_segments(surface)
            .flat_map(|(_, s)| s.nodes)
            .map(|n| nodes.id[n as usize])
            .collect();
        corners.sort_unstable();
        corners.dedup();
        let mut memories: Vec<PairHistory> =
            corners.into_iter().flat_map(memory_of).filter(|m| m.name.is_segment()).collect();
        memories.sort_unstable_by_key(|m| m.name);
        memories.dedup_by_key(|m| m.name);
        let remembered = |memory: PairHistory| {
            let slave = place(surface, memory.name.slave_quarter().0).map(|i| &surface.segments[i]);
            FacetPairHistory {
                memory,
                nodes: slave.map_or([NOT_LOCAL; 4], |s| s.nodes),
                own: slave.is_some_and(|s| s.searched),
            }
        };
        self.memories = memories.into_iter().map(remembered).collect();
        self.gathered = true;
        self.index();
    }

    /// Returns the number of bytes in use.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.stiffness[..])
            + size_of_val(&self.found[..])
            + size_of_val(&self.near[..])
    }

    /// Finds the pairs of an own segment and another segment that could touch before nodes have
    /// moved by more than `skin` against each other [length]. [`Self::pick`] must follow.
    pub fn search(
        &mut self,
        (surface, spheres): (&Surface, &[Sphere]),
        nodes: &Nodes,
        joined: &dyn Exclusions,
        find: Search,
        skin: f64,
    ) {
        self.found.clear();
        if !self.are_wanted() {
            return;
        }
        let slaves: Vec<u32> = searched_segments(surface).map(|(i, _)| i as u32).collect();
        let centres: Vec<[f64; 3]> =
            slaves.iter().map(|&i| spheres[i as usize].centre().into()).collect();
        let most = |of: &dyn Fn(u32) -> f64| slaves.iter().map(|&i| of(i)).fold(0.0, f64::max);
        let largest = most(&|i| surface.segments[i as usize].scale);
        let widest = most(&|i| spheres[i as usize].radius());
        let added = surface.shift_reach() + skin;
        let reach = |one: f64, other: f64| REACH * surface.interfaces.most(one + other) + added;
        let grown = |s: &Segment| s.bounds(&nodes.x, reach(s.scale, largest) + widest);
        let boxes: Vec<Aabb> = surface.segments.iter().map(grown).collect();
        let may_meet = |b: u32, p: u32| {
            let places = [slaves[p as usize], b];
            let [slave, met] = places.map(|i| &surface.segments[i as usize]);
            let [one, other] = places.map(|i| &spheres[i as usize]);
            slave.id < met.id
                && !one.are_separated(other, reach(slave.scale, met.scale))
                && self.may_meet(surface, joined, [slave, met]).is_some()
        };
        let found = accepted(find, &boxes, &centres, may_meet);
        self.found = found.into_iter().map(|[b, p]| [slaves[p as usize], b]).collect();
        self.found.sort_unstable();
    }

    /// Selects from the pairs found those that could touch in a step. In such a step nodes move
    /// by at most `step` against each other [length]. The selection is valid until they have
    /// moved by more than `skin` [length].
    pub fn pick(&mut self, nodes: &Nodes, surface: &Surface, skin: f64, step: f64) {
        let is_near = |pair: &&[u32; 2]| {
            let segments = pair.map(|i| &surface.segments[i as usize]);
            let [one, other] = segments.map(|s| Sphere::around(&s.corners(&nodes.x)));
            let reach = REACH * surface.interfaces.most(segments[0].scale + segments[1].scale)
                + surface.shift_reach()
                + skin
                + step;
            !one.are_separated(&other, reach)
                && segments[0]
                    .bounds(&nodes.x, reach)
                    .intersects(&segments[1].bounds(&nodes.x, 0.0))
        };
        self.near.clear();
        self.near.extend(self.found.iter().filter(is_near));
    }

    /// Returns a node of the slave and the other segment for each pair that is near.
    pub fn near<'a>(&'a self, surface: &'a Surface) -> impl Iterator<Item = (u32, &'a Segment)> {
        self.near
            .iter()
            .map(|&[a, b]| (surface.segments[a as usize].nodes[0], &surface.segments[b as usize]))
    }

    fn interface(&self, surface: &Surface, [slave, met]: [&Segment; 2]) -> Option<u16> {
        let of = |s: &Segment| std::iter::once(s.part);
        surface.interfaces.for_pair(of(slave), of(met)).filter(|&i| self.wanted[i as usize])
    }

    /// Returns the interface in which two segments may touch as segments, the first one with the
    /// lower id. Returns `None` if they may not.
    fn may_meet(
        &self,
        surface: &Surface,
        joined: &dyn Exclusions,
        [slave, met]: [&Segment; 2],
    ) -> Option<u16> {
        let is_free = slave.id.elem() != met.id.elem()
            && !slave.nodes.iter().any(|n| met.nodes.contains(n))
            && !slave
                .nodes
                .iter()
                .any(|&n| joined.excludes(n, &met.nodes) || met.behind.contains(&n))
            && !met.nodes.iter().any(|&n| joined.excludes(n, &slave.nodes));
        self.interface(surface, [slave, met]).filter(|_| is_free)
    }

    /// Returns true if a segment around the node of a pair touches the pair's segment too. The
    /// pair of the node is then left out. `alive` states for each interface if it is active.
    pub fn covers(
        &self,
        nodes: &Nodes,
        (surface, alive): (&Surface, &[bool]),
        joined: &dyn Exclusions,
        pair: &Pair,
    ) -> bool {
        if !self.wanted[pair.interface as usize] {
            return false;
        }
        let (Ok(slave), Some(met)) =
            (surface.slaves.binary_search(&pair.nodes[0]), place(surface, pair.segment))
        else {
            return false;
        };
        let met = &surface.segments[met];
        let Some(normal) = met.middle_normal(&nodes.x).filter(|n| is_convex(met, n, nodes)) else {
            return false;
        };
        surface.around(slave).any(|s| {
            let faces = |outward: &V3, other: &V3, both: bool| {
                let along = outward.dot(other);
                if both { along.abs() > FACING } else { along < -FACING }
            };
            let both = if s.id < met.id { [s, met] } else { [met, s] };
            self.may_meet(surface, joined, both).is_some_and(|i| alive[i as usize])
                && s.middle_normal(&nodes.x).is_some_and(|outward| {
                    is_convex(s, &outward, nodes)
                        && faces(&outward, &pair.normal, !s.is_solid())
                        && faces(&outward, &normal, !s.is_solid() || !met.is_solid())
                })
        })
    }

    /// Appends the active pairs of own segments in this step to `out`. `alive` states for each
    /// interface if it is active.
    pub fn find_pairs(
        &self,
        nodes: &Nodes,
        (surface, alive): (&Surface, &[bool]),
        dt: f64,
        out: &mut Vec<Pair>,
    ) {
        for &places in &self.near {
            let segments = places.map(|i| &surface.segments[i as usize]);
            let interface = self.interface(surface, segments).filter(|&i| alive[i as usize]);
            let Some(interface) = interface else { continue };
            if let Some(visit) = self.evaluate_pair(nodes, surface, interface, places) {
                visit.find_pairs(self, dt, out);
            }
        }
    }

    /// Computes the relative position of two segments; `None` if they cannot touch.
    fn evaluate_pair<'a>(
        &self,
        nodes: &'a Nodes,
        surface: &'a Surface,
        interface: u16,
        places: [u32; 2],
    ) -> Option<FacetPairGeometry<'a>> {
        let segments = places.map(|i| &surface.segments[i as usize]);
        let [slave, met] = segments;
        let corners = segments.map(|s| s.corners(&nodes.x));
        let [one, other] = [0, 1].map(|i| Sphere::around(&corners[i]));
        let [ahead, behind] =
            segments.map(|s| surface.interfaces.measure(interface, (s.half_thickness, s.scale)));
        let (thickness, scale) = (ahead.0 + behind.0, ahead.1 + behind.1);
        let shifts = segments.map(|s| surface.shift_of_segment(interface, s, &nodes.x));
        if one.are_separated(&other, REACH * scale + shifts[0].norm() + shifts[1].norm()) {
            return None;
        }
        let (of_slave, of_met) = (slave.middle_normal(&nodes.x)?, met.middle_normal(&nodes.x)?);
        // Side of the other segment on which the slave is, along the normal of the other
        // segment.
        let side = match (slave.is_solid(), met.is_solid()) {
            (_, true) => 1.0,
            (true, false) => -of_slave.dot(&of_met).signum(),
            (false, false) => {
                let before = self.side(slave.id, (surface, met), &of_met);
                let apart = || one.centre() + shifts[0] - other.centre() - shifts[1];
                before.unwrap_or_else(|| apart().dot(&of_met)).signum()
            }
        };
        let away = of_met * side;
        let to = if slave.is_solid() { of_slave } else { of_slave * -of_slave.dot(&away).signum() };
        if to.dot(&away) >= -FACING {
            return None;
        }
        let normal = (away - to).normalize();
        let per_area = places.map(|i| self.stiffness.get(i as usize).copied().unwrap_or(0.0));
        let arm =
            if surface.interfaces.has_friction(interface) { [ahead.0, behind.0] } else { [0.0; 2] };
        Some(FacetPairGeometry {
            nodes,
            surface,
            segments,
            interface,
            thickness,
            towards: [-shifts[0].dot(&normal), shifts[1].dot(&normal)],
            arm,
            scale,
            corners,
            normal,
            side,
            per_area,
        })
    }

    /// Returns the product of `normal` with the normal in the history of a slave with a segment
    /// or with its neighbour. Returns `None` if there is no history with a similar normal.
    fn side(
        &self,
        slave: SegmentId,
        (surface, met): (&Surface, &Segment),
        normal: &V3,
    ) -> Option<f64> {
        let of_met = self.of_slave(slave).iter().filter(|r| is_of(&r.memory, surface, met));
        let products = of_met.map(|r| (r.memory.age, r.memory.normal.dot(normal)));
        products.filter(|p| p.1.abs() > ALIKE).min_by_key(|p| p.0).map(|p| p.1)
    }

    fn of_slave(&self, slave: SegmentId) -> &[FacetPairHistory] {
        let number = NodeId(slave.0);
        let from = self.memories.partition_point(|r| r.memory.name.slave < number);
        let to = self.memories.partition_point(|r| r.memory.name.slave <= number);
        &self.memories[from..to]
    }

    /// Returns the history of a pair of these segments with this normal. If it has none, returns
    /// the history of a neighbouring pair that it continues.
    fn recall_history(
        &self,
        name: &PairKey,
        normal: &V3,
        surface: &Surface,
        [slave, met]: [&Segment; 2],
    ) -> Option<PairHistory> {
        let alike = |m: &PairHistory| m.normal.dot(normal) > ALIKE && is_of(m, surface, met);
        let own = self.of_slave(slave.id).iter().map(|r| r.memory).filter(alike);
        // Existing contact comes before lost contact, then the nearest pair, then the order of
        // the keys.
        let rank = |m: &PairHistory| {
            let other = m.name.slave_quarter() != name.slave_quarter();
            (m.age > 0, m.name != *name, other, m.name.target[0] != name.target[0], m.age, m.name)
        };
        let same = own.min_by_key(rank);
        same.or_else(|| {
            let from = self.by_met.partition_point(|e| e.0 < met.id);
            let of_met = self.by_met[from..].iter().take_while(|e| e.0 == met.id);
            let neighbours = of_met.map(|e| self.memories[e.1 as usize].memory).filter(|m| {
                let before = m.name.slave_quarter().0;
                before != slave.id && alike(m) && surface.is_adjacent(before, slave)
            });
            // Other workers do not know the stick point.
            neighbours
                .min_by_key(|m| (m.age, m.name))
                .map(|m| PairHistory { slip: V3::zeros(), ..m })
        })
    }

    /// Stores the history of all pairs of a step that are known here, and keeps the history of
    /// lost pairs for some steps.
    pub fn store_history<'a>(&mut self, pairs: impl Iterator<Item = &'a Pair>) {
        if !self.are_wanted() {
            return;
        }
        let before = std::mem::take(&mut self.memories);
        self.gathered = false;
        self.memories.extend(pairs.filter(|p| p.key.is_segment()).map(|p| FacetPairHistory {
            memory: p.to_history(),
            nodes: [0, 1, 2, 3].map(|r: usize| p.nodes[r]),
            own: p.is_owned,
        }));
        let touched = self.memories.len();
        for r in before {
            let found =
                self.memories[..touched].binary_search_by_key(&r.memory.name, |n| n.memory.name);
            if let (Err(_), Some(memory)) = (found, r.memory.after_loss()) {
                // Pairs from other workers have no side, and lost pairs need none.
                self.memories
                    .push(FacetPairHistory { memory: PairHistory { side: 0.0, ..memory }, ..r });
            }
        }
        self.memories.sort_unstable_by_key(|r| r.memory.name);
        self.index();
    }

    fn index(&mut self) {
        self.by_met.clear();
        self.by_met.extend(
            (0..).zip(&self.memories).map(|(i, r)| (SegmentId(r.memory.name.target[0]), i)),
        );
        self.by_met.sort_unstable();
    }

    /// Returns the histories of own segments, once for each of their nodes; see
    /// [`Edges::pair_histories`](super::edges::Edges::pair_histories).
    pub fn pair_histories(&self) -> impl Iterator<Item = (u32, &PairHistory)> {
        let sent = self.memories.iter().filter(|r| r.own || self.gathered || r.memory.age > 0);
        sent.flat_map(|r| r.nodes.map(|n| (n, &r.memory))).filter(|(n, _)| *n != NOT_LOCAL)
    }
}

/// Returns the segments for which this worker searches, its own ones below, with their indices.
fn searched_segments(surface: &Surface) -> impl Iterator<Item = (usize, &Segment)> {
    surface.segments.iter().enumerate().filter(|(_, s)| s.searched)
}

fn place(surface: &Surface, id: SegmentId) -> Option<usize> {
    surface.segments.binary_search_by_key(&id, |s| s.id).ok()
}

/// Two segments that face each other.
struct FacetPairGeometry<'a> {
    nodes: &'a Nodes,
    surface: &'a Surface,
    /// The slave segment and the other segment.
    segments: [&'a Segment; 2],
    interface: u16,
    /// Distance of their middle surfaces at which they touch [length].
    thickness: f64,
    /// Shifts of the middle surfaces towards the other segment [length].
    towards: [f64; 2],
    /// Half thicknesses of both segments; zero without friction [length].
    arm: [f64; 2],
    /// Contact thickness [length].
    scale: f64,
    corners: [[V3; 4]; 2],
    /// Unit vector from the other segment to the slave.
    normal: V3,
    side: f64,
    /// Contact stiffness over area of both segments [force/length^3].
    per_area: [f64; 2],
}

/// Returns true if the history is of a pair with this segment, or with one that has a common
/// node with it.
fn is_of(memory: &PairHistory, surface: &Surface, met: &Segment) -> bool {
    let before = SegmentId(memory.name.target[0]);
    before == met.id || surface.is_adjacent(before, met)
}

/// Returns true if a segment with this normal is convex. A segment that is not convex cannot be
/// divided into convex quarters.
fn is_convex(segment: &Segment, normal: &V3, nodes: &Nodes) -> bool {
    let c = segment.corners(&nodes.x);
    let turns = |i: usize| {
        (c[(i + 1) % 4] - c[i]).cross(&(c[(i + 2) % 4] - c[(i + 1) % 4])).dot(normal) > 0.0
    };
    segment.is_triangle() || (0..4).all(turns)
}

impl FacetPairGeometry<'_> {
    fn find_pairs(&self, facets: &Facets, dt: f64, out: &mut Vec<Pair>) {
        let [slave, met] = self.segments;
        let plane = Plane::perpendicular(self.normal, self.corners[1].iter().sum::<V3>() * 0.25);
        let laid = [0, 1].map(|i| {
            ProjectedSegment::on(&plane, &self.corners[i], self.segments[i].is_triangle())
        });
        let [Some(above), Some(below)] = laid else { return };
        let along = |n: &u32| V3::from(xyz(&self.nodes.v_next[*n as usize])).dot(&self.normal);
        let least = slave.nodes.iter().map(along).fold(f64::INFINITY, f64::min);
        let closing =
            (met.nodes.iter().map(along).fold(f64::NEG_INFINITY, f64::max) - least).max(0.0);
        let moved = slave
            .nodes
            .iter()
            .map(|&n| moved(self.nodes, met.nodes.into_iter(), n, dt, self.scale));
        let moved = moved.fold(0.0, f64::max);
        // The shifts bring the surfaces nearer to each other.
        let apart = self.thickness + self.towards[0] + self.towards[1];
        above.gap_at(&below, apart, |quarters, overlap| {
            if overlap.gap - dt * closing < ACTIVE * self.scale {
                out.extend(self.pair(facets, quarters, &overlap, moved, dt));
            }
        });
    }

    /// Returns the lever arms of friction, in proportion to each other [length].
    fn levers(&self, overlap: &Overlap) -> [f64; 2] {
        if self.towards == [0.0; 2] || self.arm == [0.0; 2] {
            return self.arm;
        }
        let apart = self.thickness + self.towards[0] + self.towards[1] + overlap.gap;
        shell_offset::lever_arms(self.arm, self.towards, apart, [1.0; 2])
    }

    fn pair(
        &self,
        facets: &Facets,
        quarters: [usize; 2],
        overlap: &Overlap,
        moved: f64,
        dt: f64,
    ) -> Option<Pair> {
        let [slave, met] = self.segments;
        let name = PairKey::of_segments([slave.id, met.id], quarters);
        let old = facets
            .recall_history(&name, &self.normal, self.surface, self.segments)
            .filter(|m| m.is_fresh(moved, self.scale));
        let solid = slave.is_solid() || met.is_solid();
        let deepest = if old.is_none() && solid { BEHIND } else { REACH };
        if overlap.gap < -deepest * self.scale {
            return None;
        }
        let [a, b] = overlap.shape;
        let shape = std::array::from_fn(|r| if r < 4 { a[r] } else { b[r - 4] });
        let speed = self.surface.slower(slave.part, met.part);
        let [i, j, k, l] = slave.nodes;
        let [p, q, r, s] = met.nodes;
        let pair = Pair {
            shape,
            weight: shape,
            area: overlap.area,
            normal: self.normal,
            lever_arms: self.levers(overlap),
            side: self.side,
            interface: self.interface,
            contact_thickness: self.scale,
            speed,
            stiffness: self.per_area[0].min(self.per_area[1]) * overlap.area,
            slave_surface_first: (slave.part, slave.id) < (met.part, met.id),
            is_owned: true,
            ..Pair::new(name, met.id, [i, j, k, l, p, q, r, s])
        };
        let tolerated = tolerated(old.as_ref(), overlap.gap, moved, dt, speed);
        let mut pair = pair.with_history(old.as_ref(), overlap.gap, tolerated);
        if !solid && old.is_none() {
            if is_in_middle(&pair, self.thickness) {
                return None;
            }
            pair.keep_if_deep(self.thickness);
        }
        Some(pair)
    }
}
