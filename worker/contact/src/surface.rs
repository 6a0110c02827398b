//! Contact surface: both sides of shells with thickness, the faces of solids that belong to one
//! solid only, and beams all around. Nodes of the surface touch its segments.

use crate::beams;
use crate::detail::is_smooth;
use crate::geometry::{Nearest, nearest, nearest_on_line};
use crate::interfaces::Interfaces;
use crumple_fem::blocks::LocalElement;
use crumple_fem::nodes::Nodes;
use crumple_math::lanes::Lane;
use crumple_math::row::{Row, V3, xyz};
use crumple_math::vector_range::VectorRange;
use crumple_proto::boxes::Aabb;
use crumple_proto::ids::{ElemId, SegmentId};
use crumple_proto::job::Part;
use crumple_proto::mesh::Shape;
use crumple_proto::partition::{ElementRecord, Settings};
use std::collections::BTreeMap;
use std::sync::Arc;

/// Index of a corner that is not local on this worker.
pub const NOT_LOCAL: u32 = u32::MAX;

/// Scale of a solid's faces and nodes, as a fraction of its shortest edge at the start. With it
/// two solids are searched within REACH times half an edge, and a point in the middle of a solid
/// is not yet behind it.
const SOLID_SCALE: f64 = 0.25;

/// A face that nodes can touch, or the line of a beam.
#[derive(Clone, Copy, Debug)]
pub struct Segment {
    /// Element and face.
    pub id: SegmentId,
    /// Local nodes (a triangle repeats its third, a line its second).
    pub nodes: [u32; 4],
    /// Corners of a solid opposite to this face; they can never touch it. [`NOT_LOCAL`] for a
    /// shell.
    pub behind: [u32; 4],
    /// Half the shell's thickness, or the beam's radius; 0 for a solid [length].
    pub half_thickness: f64,
    /// Distance of a shell's middle surface from its nodes along its normal, if an interface uses
    /// it ([`shell_offset`](super::shell_offset)) [length].
    pub offset: f64,
    /// Its part of the contact thickness: half a shell's thickness, a fraction of a solid's
    /// shortest edge [length].
    pub scale: f64,
    /// Index of its part.
    pub part: u32,
    /// True if the element is this worker's own.
    pub own: bool,
    /// True if this worker searches for the pairs of its edges and of the segment itself.
    pub searched: bool,
}

/// Scales of the segments of a worker's own elements [length].
#[derive(Clone, Copy, Debug, Default)]
pub struct OwnScales {
    /// Largest scale, of hidden solids too.
    pub largest: f64,
    /// Smallest scale, infinite without segments.
    pub smallest: f64,
    /// See [`Surface::short`], of this worker.
    pub short: f64,
    /// Largest [`Segment::offset`], as an absolute value.
    pub offset: f64,
    /// Longest side at the start; 0 if the surface is flat. Hidden solids do not count: an update
    /// after erosion does not know them.
    pub longest: f64,
    /// Longest side or diagonal now, of hidden solids too; 0 if the surface is flat.
    pub diameter: f64,
}

/// Returns the distance of two corners of a face [length].
fn distance(x: &[Row], face: &[u32; 4], [a, b]: [usize; 2]) -> f64 {
    let at = |k: usize| V3::from(xyz(&x[face[k] as usize]));
    (at(a) - at(b)).norm()
}

impl OwnScales {
    /// Raises the longest side to that of a face.
    fn include_sides(&mut self, face: &[u32; 4], nodes: &Nodes) {
        let sides = [[0, 1], [1, 2], [2, 3], [3, 0]].map(|ends| distance(&nodes.x0, face, ends));
        self.longest = sides.into_iter().fold(self.longest, f64::max);
    }

    /// Raises the diameter to that of a face.
    fn include_diameter(&mut self, face: &[u32; 4], nodes: &Nodes) {
        let pairs = [[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [1, 3]];
        let distances = pairs.map(|ends| distance(&nodes.x, face, ends));
        self.diameter = distances.into_iter().fold(self.diameter, f64::max);
    }
}

/// Segments and nodes of the contact surface that a worker knows.
#[derive(Debug, Default)]
pub struct Surface {
    /// Segments of own and ghost elements, in ascending id.
    pub segments: Vec<Segment>,
    /// Nodes that may touch segments, for which this worker searches, ascending.
    pub slaves: Vec<u32>,
    /// Owned nodes on the surface, ascending; `None` if these are the slaves.
    pub owned: Option<Vec<u32>>,
    /// Nodes of own solids that come to the surface if solids fail, ascending; empty if none can
    /// fail.
    pub hidden: Vec<u32>,
    /// Scales of own segments.
    pub own_scales: OwnScales,
    /// Half thickness per local node, the largest of its shells and beams; 0 for nodes of solids
    /// and nodes that are not on the surface [length].
    pub node_half: Vec<f64>,
    /// [`Segment::scale`] per local node, the largest of its segments; 0 if it is not on the
    /// surface [length].
    pub node_scale: Vec<f64>,
    /// Largest [`Segment::offset`] of any worker, as an absolute value [length].
    pub largest_offset: f64,
    /// Longest side of any worker's segments at the start [length]; 0 if the surface is flat.
    pub longest_side: f64,
    /// Longest side or diagonal of any worker's segments at the last renewal [length]; 0 if the
    /// surface is flat.
    pub diameter: f64,
    /// Smallest scale of a segment of any worker [length].
    pub thinnest: f64,
    /// 10th percentile of the shortest edges of segments, minimum over all workers [length].
    pub short: f64,
    /// Per slave the start of its range in `faces`; see [`Surface::link_faces`].
    pub face_start: Vec<u32>,
    /// Indices of the segments around each slave, ascending.
    pub faces: Vec<u32>,
    /// Per local node the start of its range in `node_faces`; see [`Surface::link_nodes`].
    pub node_face_start: Vec<u32>,
    /// Indices of the segments around each node, ascending; empty if the surface is flat.
    pub node_faces: Vec<u32>,
    /// Per slave the lowest of the segments around it, by part and then by id; `u32::MAX` if it
    /// has none.
    pub first: Vec<u32>,
    /// Wave speed per part [length/time].
    pub speeds: Vec<f64>,
    /// Interfaces: which parts touch, and how.
    pub interfaces: Arc<Interfaces>,
    /// Index into `part_sets` per slave, the parts around it; empty if there is one interface.
    pub part_set: Vec<u32>,
    /// Sets of parts' indices, ascending.
    pub part_sets: Vec<Vec<u32>>,
    /// True if some segments are lines; see [`Surface::link_faces`].
    pub has_lines: bool,
    /// Nodes of own particles, ascending, each with the index of its part. They have no segments
    /// around them.
    pub points: Vec<(u32, u32)>,
}

impl Segment {
    /// Returns true if the segment is a solid's face, which is touched from outside only.
    pub fn is_solid(&self) -> bool {
        self.half_thickness == 0.0
    }

    /// Returns true if the segment is the line of a beam.
    pub fn is_line(&self) -> bool {
        self.nodes[1] == self.nodes[2] && self.is_triangle()
    }

    /// Computes its nearest point to `p`; `None` for a face without area.
    pub fn nearest(&self, p: &V3, x: &[Row]) -> Option<Nearest> {
        let q = self.corners(x);
        if self.is_line() {
            Some(nearest_on_line(p, [&q[0], &q[1]]))
        } else {
            nearest(p, &q, self.is_triangle())
        }
    }

    /// Returns true if the segment is a triangle.
    pub fn is_triangle(&self) -> bool {
        self.nodes[2] == self.nodes[3]
    }

    /// Returns the depth of the solid behind it, taken as its shortest edge at the start; zero
    /// for a shell [length].
    pub fn depth(&self) -> f64 {
        if self.is_solid() { self.scale / SOLID_SCALE } else { 0.0 }
    }

    /// Computes the unit normal at the middle by the right-hand rule over the nodes; `None`
    /// without area.
    pub fn middle_normal(&self, x: &[Row]) -> Option<V3> {
        let [a, b, c, d] = self.corners(x);
        (c - a).cross(&(d - b)).try_normalize(0.0)
    }

    /// Returns the coordinates of the corners [length].
    pub fn corners(&self, x: &[Row]) -> [V3; 4] {
        self.nodes.map(|n| V3::from(xyz(&x[n as usize])))
    }

    /// Returns the box around the corners, expanded by `reach` [length].
    pub fn bounds(&self, x: &[Row], reach: f64) -> Aabb {
        Aabb::around(self.nodes.map(|n| xyz(&x[n as usize]))).grown(reach)
    }
}

/// Parts that take part in contact, and their thickness in contact.
pub struct ContactParts {
    /// Per part, `None` if it takes no part: half thickness of shells, radius of beams and of
    /// particles, 0 for solids [length]; true if it overrides the thickness of single shells;
    /// factor on the result.
    half: Vec<Option<(f64, bool, f64)>>,
    /// Largest thickness of a shell as a multiple of its shortest side, or of a beam as a
    /// multiple of its length.
    limit: f64,
    /// Per part, the offset of its shells over half their thickness, and their thickness [length];
    /// empty if no interface uses offsets.
    offsets: Vec<(f64, f64)>,
    interfaces: Arc<Interfaces>,
    /// True if nodes touch the smooth surface.
    smooth: bool,
}

impl ContactParts {
    /// Reads the data of a job.
    pub fn from_settings(settings: &Settings) -> Self {
        let contact = settings.contact.as_ref();
        let interfaces = Arc::new(
            contact.map_or(Interfaces::default(), |c| Interfaces::of_parts(c, &settings.parts)),
        );
        let half = |(i, p): (usize, &Part)| {
            let takes_part =
                contact.is_some_and(|c| c.takes_part(p.id)) && interfaces.takes_part(i);
            if let Some(particles) = &p.particles {
                return takes_part.then_some((particles.radius(), true, 1.0));
            }
            if beams::has_bars(p) {
                return contact
                    .filter(|_| takes_part)
                    .and_then(|c| beams::half(c, p))
                    .map(|radius| (radius, true, 1.0));
            }
            let given = p.contact_thickness;
            takes_part.then_some((
                0.5 * given.unwrap_or(p.thickness),
                given.is_some(),
                p.contact_thickness_scale,
            ))
        };
        let is_shifted = contact.is_some() && interfaces.have_shell_offset();
        let offset = |p: &Part| (p.offset, p.thickness);
        Self {
            half: settings.parts.iter().enumerate().map(half).collect(),
            limit: contact.map_or(0.0, |c| c.thickness_limit),
            offsets: settings.parts.iter().filter(|_| is_shifted).map(offset).collect(),
            interfaces,
            smooth: contact.is_some_and(is_smooth),
        }
    }

    /// Returns the distance of the middle surface of a shell from its nodes, 0 if no interface
    /// uses it [length].
    fn offset(&self, record: &ElementRecord) -> f64 {
        let Some(&(offset, of_part)) = self.offsets.get(record.part as usize) else { return 0.0 };
        let own = record.own;
        0.5 * own.offset.unwrap_or(offset)
            * if own.thickness > 0.0 { own.thickness } else { of_part }
    }

    /// Returns the half thickness in contact of a shell of a part [length], without the limit by
    /// its sides; `None` if the part takes no part in contact. `own` is its individual thickness, 0
    /// without one [length]. The value of a solid has no meaning.
    pub fn half_thickness(&self, part: u32, own: f64) -> Option<f64> {
        let (of_part, instead, scale) = self.half[part as usize]?;
        let half = if own > 0.0 && !instead { 0.5 * own } else { of_part };
        Some(half * scale)
    }

    /// Returns the smallest value in any interface of a half thickness [length].
    pub fn least(&self, half: f64) -> f64 {
        self.interfaces.least(half)
    }
}

/// Returns the segments of an element.
pub fn segments_of(e: &LocalElement, nodes: &Nodes, parts: &ContactParts) -> Vec<Segment> {
    let Some(half) =
        parts.half_thickness(e.record.part, e.record.own.thickness).filter(|_| !e.record.failed)
    else {
        return Vec::new();
    };
    let shape = e.record.shape;
    if shape.is_bar() {
        return line_of(e, nodes, half, parts.limit).into_iter().collect();
    }
    let shell = shape.is_shell();
    let shortest = shortest_edge(e, nodes);
    // Shells thicker than their sides would touch surfaces beyond the next corner.
    let half = if parts.limit > 0.0 { half.min(0.5 * parts.limit * shortest) } else { half };
    let scale = if shell { half } else { SOLID_SCALE * shortest };
    let is_free = |face: &usize| shell || e.record.free_faces >> face & 1 == 1;
    let segment = |face: usize| {
        let corners = shape.faces()[face];
        let mut behind = [NOT_LOCAL; 4];
        if !shell {
            behind.iter_mut().zip(shape.behind(face)).for_each(|(b, c)| *b = e.nodes[c]);
        }
        Segment {
            id: SegmentId::new(e.record.id, face),
            nodes: corners.map(|c| e.nodes[c]),
            behind,
            half_thickness: if shell { half } else { 0.0 },
            offset: if shell { parts.offset(&e.record) } else { 0.0 },
            scale,
            part: e.record.part,
            own: true,
            searched: true,
        }
    };
    (0..shape.faces().len()).filter(is_free).map(segment).collect()
}

/// Returns the line of a beam or truss with a radius. Returns `None` for one without length if the
/// length limits the radius.
fn line_of(e: &LocalElement, nodes: &Nodes, radius: f64, limit: f64) -> Option<Segment> {
    let [a, b] = [e.nodes[0], e.nodes[1]];
    let [from, to] = [a, b].map(|n| V3::from(xyz(&nodes.x0[n as usize])));
    // Without the limit, next but one beams of a row would touch from the start.
    let half = if limit > 0.0 { radius.min(0.5 * limit * (to - from).norm()) } else { radius };
    (half > 0.0).then_some(Segment {
        id: SegmentId::new(e.record.id, 0),
        nodes: [a, b, b, b],
        behind: [NOT_LOCAL; 4],
        half_thickness: half,
        offset: 0.0,
        scale: half,
        part: e.record.part,
        own: true,
        searched: true,
    })
}

/// Returns the node and the part of a particle in contact, and its radius [length].
fn point_of(e: &LocalElement, parts: &ContactParts) -> Option<((u32, u32), f64)> {
    let is_point = e.record.shape == Shape::Point1 && !e.record.failed;
    let radius =
        parts.half_thickness(e.record.part, e.record.own.thickness).filter(|_| is_point)?;
    Some(((e.nodes[0], e.record.part), radius))
}

/// Computes the shortest edge of an element at the start [length].
fn shortest_edge(e: &LocalElement, nodes: &Nodes) -> f64 {
    let at = |c: usize| V3::from(xyz(&nodes.x0[e.nodes[c] as usize]));
    let sides = e
        .record
        .shape
        .faces()
        .iter()
        .flat_map(|f| (0..4).map(|i| (at(f[i]) - at(f[(i + 1) % 4])).norm()));
    sides.filter(|&s| s > 0.0).fold(f64::INFINITY, f64::min) // a triangle's face repeats a corner
}

impl Surface {
    /// Builds the segments of elements, and thickness and scale of the local nodes.
    pub fn new<'a>(
        elements: impl Iterator<Item = &'a LocalElement> + Clone,
        nodes: &Nodes,
        parts: &ContactParts,
    ) -> Self {
        let points = elements.clone().filter_map(|e| point_of(e, parts));
        let mut s = Self {
            points: points.clone().map(|(point, _)| point).collect(),
            segments: elements.flat_map(|e| segments_of(e, nodes, parts)).collect(),
            slaves: Vec::new(),
            node_half: vec![0.0; nodes.local_count],
            node_scale: vec![0.0; nodes.local_count],
            thinnest: f64::INFINITY,
            short: f64::INFINITY,
            interfaces: parts.interfaces.clone(),
            ..Self::default()
        };
        let mut own = OwnScales { smallest: f64::INFINITY, ..OwnScales::default() };
        for i in 0..s.segments.len() {
            let g = s.segments[i];
            g.nodes.iter().for_each(|&n| s.include_remote(n, g.half_thickness, g.scale));
            own.largest = own.largest.max(g.scale);
            own.smallest = own.smallest.min(g.scale);
            own.offset = own.offset.max(g.offset.abs());
        }
        for ((node, _), radius) in points {
            s.include_remote(node, radius, radius);
            own.largest = own.largest.max(radius);
            own.smallest = own.smallest.min(radius);
        }
        s.points.sort_unstable();
        if parts.smooth {
            for segment in &s.segments {
                own.include_sides(&segment.nodes, nodes);
                own.include_diameter(&segment.nodes, nodes);
            }
        }
        own.short = s.short_edge(nodes);
        (s.own_scales, s.largest_offset) = (own, own.offset);
        s
    }

    /// Adds the nodes and the scales of solids that come to the surface if others fail.
    pub fn include_hidden<'a>(
        &mut self,
        elements: impl Iterator<Item = &'a LocalElement>,
        nodes: &Nodes,
        parts: &ContactParts,
    ) {
        let takes_part = |e: &&LocalElement| {
            e.record.shape.is_solid()
                && !e.record.failed
                && parts.half_thickness(e.record.part, e.record.own.thickness).is_some()
        };
        for e in elements.filter(takes_part) {
            self.hidden.extend(&e.nodes[..e.record.shape.corners()]);
            let largest = &mut self.own_scales.largest;
            *largest = largest.max(SOLID_SCALE * shortest_edge(e, nodes));
            if parts.smooth {
                let faces = e.record.shape.faces().iter().map(|f| f.map(|c| e.nodes[c]));
                faces.for_each(|face| self.own_scales.include_diameter(&face, nodes));
            }
        }
        self.hidden.sort_unstable();
        self.hidden.dedup();
    }

    /// Raises the half thickness and scale of a local node to at least these values [length].
    pub fn include_remote(&mut self, node: u32, half: f64, scale: f64) {
        let (h, s) = (&mut self.node_half[node as usize], &mut self.node_scale[node as usize]);
        (*h, *s) = (h.max(half), s.max(scale));
    }

    /// Collects the segments around each slave. All of them are known to the worker that searches
    /// for the slave, because the worker knows all segments that the slave could touch, and the
    /// slave lies on these. `count` is the number of nodes.
    pub fn link_faces(&mut self, count: usize) {
        self.has_lines = self.segments.iter().any(Segment::is_line);
        let mut place = vec![u32::MAX; count];
        self.slaves.iter().enumerate().for_each(|(i, &s)| place[s as usize] = i as u32);
        let mut around: Vec<(u32, u32)> = Vec::new();
        for (g, s) in self.segments.iter().enumerate() {
            for &i in
                s.nodes.iter().filter_map(|&n| place.get(n as usize)).filter(|&&i| i != u32::MAX)
            {
                around.push((i, g as u32));
            }
        }
        around.sort_unstable();
        around.dedup(); // a triangle repeats its third node
        self.face_start = (0..=self.slaves.len())
            .map(|i| around.partition_point(|a| (a.0 as usize) < i) as u32)
            .collect();
        self.faces = around.into_iter().map(|a| a.1).collect();
        let rank = |&g: &u32| (self.segments[g as usize].part, self.segments[g as usize].id);
        let runs =
            self.face_start.windows(2).map(|run| &self.faces[run[0] as usize..run[1] as usize]);
        self.first =
            runs.map(|run| run.iter().copied().min_by_key(rank).unwrap_or(u32::MAX)).collect();
        self.link_parts();
    }

    /// Collects the parts around each slave if there is more than one interface.
    fn link_parts(&mut self) {
        (self.part_set, self.part_sets) = (Vec::new(), Vec::new());
        if self.interfaces.is_one() {
            return;
        }
        let mut known: BTreeMap<Vec<u32>, u32> = BTreeMap::new();
        for place in 0..self.slaves.len() {
            let mut parts: Vec<u32> = self.around(place).map(|s| s.part).collect();
            parts.extend(self.part_of_point(self.slaves[place]));
            parts.sort_unstable();
            parts.dedup();
            let next = known.len() as u32;
            let set = *known.entry(parts).or_insert(next);
            self.part_set.push(set);
        }
        self.part_sets = vec![Vec::new(); known.len()];
        known.into_iter().for_each(|(parts, set)| self.part_sets[set as usize] = parts);
    }

    /// Returns the interface of the slave with index `place` in `slaves` and a segment; `None`
    /// if they do not touch.
    pub fn interface(&self, place: usize, segment: &Segment) -> Option<u16> {
        self.interface_with(place, segment.part)
    }

    /// Returns the interface of the slave with index `place` in `slaves` and a part; `None` if
    /// they do not touch.
    pub fn interface_with(&self, place: usize, part: u32) -> Option<u16> {
        let parts: &[u32] = self.part_set.get(place).map_or(&[], |&s| &self.part_sets[s as usize]);
        self.interfaces.for_node(parts.iter().copied(), std::iter::once(part))
    }

    /// Returns the sum of the half thicknesses of a node and a segment in an interface, and the
    /// sum of their scales [length].
    pub fn sizes(&self, interface: u16, node: u32, segment: &Segment) -> (f64, f64) {
        let n = node as usize;
        let ahead = self.interfaces.measure(interface, (self.node_half[n], self.node_scale[n]));
        let behind = self.interfaces.measure(interface, (segment.half_thickness, segment.scale));
        (ahead.0 + behind.0, ahead.1 + behind.1)
    }

    /// Returns the half thicknesses of a node and of a segment in an interface [length].
    pub fn halves(&self, interface: u16, node: u32, segment: &Segment) -> [f64; 2] {
        let n = node as usize;
        let of = |half, scale| self.interfaces.measure(interface, (half, scale)).0;
        [of(self.node_half[n], self.node_scale[n]), of(segment.half_thickness, segment.scale)]
    }

    /// Returns true if a segment has a common node with another one, given by its id.
    pub fn is_adjacent(&self, id: SegmentId, segment: &Segment) -> bool {
        let other = self.segments.binary_search_by_key(&id, |s| s.id).map(|i| &self.segments[i]);
        other.is_ok_and(|other| other.nodes.iter().any(|n| segment.nodes.contains(n)))
    }

    /// Returns true if the surface is convex between two neighbouring segments, `from` with this
    /// normal and `to`.
    pub fn is_convex(&self, from: SegmentId, to: &Segment, normal: &V3, x: &[Row]) -> bool {
        let from = self.segments.binary_search_by_key(&from, |s| s.id).map(|i| &self.segments[i]);
        let sum = |s: &Segment| s.corners(x).iter().sum::<V3>();
        from.is_ok_and(|from| (sum(to) - sum(from)).dot(normal) < 0.0)
    }

    /// Returns the lowest part around the slave with index `i` in `slaves`, and the lowest
    /// segment of this part. A particle has its part and no segment.
    pub fn precedes(&self, i: usize) -> (u32, SegmentId) {
        let none = || (self.part_of_point(self.slaves[i]).unwrap_or(u32::MAX), SegmentId(u64::MAX));
        self.segments.get(self.first[i] as usize).map_or_else(none, |s| (s.part, s.id))
    }

    /// Returns the part of the particle at a node, if there is one.
    fn part_of_point(&self, node: u32) -> Option<u32> {
        let place = self.points.binary_search_by_key(&node, |p| p.0).ok()?;
        Some(self.points[place].1)
    }

    /// Returns the slower wave speed of two parts, of those that are known [length/time].
    pub fn slower(&self, one: u32, other: u32) -> f64 {
        let [a, b] = [one, other]
            .map(|part| self.speeds.get(part as usize).copied().unwrap_or(f64::INFINITY));
        a.min(b)
    }

    /// Returns the segments around the slave with index `i` in `slaves`.
    pub fn around(&self, i: usize) -> impl Iterator<Item = &Segment> {
        let run = self.face_start[i] as usize..self.face_start[i + 1] as usize;
        self.faces[run].iter().map(|&g| &self.segments[g as usize])
    }

    /// Computes the area of the surface that belongs to the slave node of a pair: a quarter
    /// of each quad around it, a third of each triangle and half of each beam, which is a strip as
    /// wide as its diameter; the square around a particle [length^2]. Faces of solids count with
    /// their projection against the pair's normal. If some nodes of a segment carry no
    /// contact force, their fraction of the area is left out: the contact surface below ends
    /// within the segment.
    pub fn area_of(
        &self,
        (slave, normal): (u32, &V3),
        x: &[Row],
        bears: impl Fn(u32) -> bool,
    ) -> f64 {
        let of = |s: &Segment| {
            let [a, b, c, d] = s.corners(x);
            let area = (c - a).cross(&(d - b)) * 0.5;
            let seen = match (s.is_solid(), s.is_line()) {
                (true, _) => (-area.dot(normal)).max(0.0),
                (_, true) => 2.0 * s.half_thickness * (b - a).norm(),
                _ => area.norm(),
            };
            let corners = match (s.is_line(), s.is_triangle()) {
                (true, _) => &s.nodes[..2],
                (_, true) => &s.nodes[..3],
                _ => &s.nodes[..],
            };
            let (count, borne) =
                (corners.len() as f64, corners.iter().filter(|&&n| bears(n)).count() as f64);
            seen * borne / (count * count)
        };
        if self.part_of_point(slave).is_some() {
            return 4.0 * self.node_half[slave as usize].powi(2);
        }
        self.around(self.slaves.partition_point(|&s| s < slave)).map(of).sum()
    }

    /// Returns the number of bytes in use, without spare capacity of lists.
    pub fn bytes(&self) -> usize {
        let lists = [&self.slaves, &self.hidden, &self.face_start, &self.faces, &self.first];
        size_of_val(&self.segments[..])
            + lists.iter().map(|l| size_of_val(&l[..])).sum::<usize>()
            + size_of_val(&self.node_half[..])
            + size_of_val(&self.node_scale[..])
    }

    /// Returns the 10th percentile of the shortest edges of the segments on this worker
    /// [length]. With it a few slivers do not count.
    pub fn short_edge(&self, nodes: &Nodes) -> f64 {
        let shortest = |s: &Segment| {
            let q = s.corners(&nodes.x);
            // A triangle repeats a node.
            let edges = (0..4).map(|k| (q[(k + 1) % 4] - q[k]).norm()).filter(|&l| l > 0.0);
            edges.fold(f64::INFINITY, f64::min)
        };
        let mut edges: Vec<f64> = self.segments.iter().map(shortest).collect();
        let tenth = edges.len() / 10;
        if edges.is_empty() {
            f64::INFINITY
        } else {
            *edges.select_nth_unstable_by(tenth, f64::total_cmp).1
        }
    }

    /// Returns the ghost elements with a segment, ascending. Segments must be ascending.
    pub fn ghost_elements(&self) -> impl Iterator<Item = ElemId> + '_ {
        let ghosts = self.segments.iter().filter(|s| !s.own).map(|s| s.id.elem());
        let mut last = None;
        ghosts.filter(move |&id| last.replace(id) != Some(id))
    }

    /// Returns the largest scale of a local node [length].
    pub fn largest_scale(&self) -> f64 {
        self.node_scale.iter().copied().fold(0.0, f64::max)
    }

    /// Returns the largest velocity components of the owned nodes on the surface, then the largest
    /// of their negatives; minus infinity if there are none [length/time].
    pub fn velocities(&self, nodes: &Nodes) -> [f64; 6] {
        let owned = self.owned.as_ref().unwrap_or(&self.slaves);
        let velocity = |k: usize| Lane::new(nodes.v[owned[k] as usize]);
        let [low, high] = VectorRange::side_by_side(owned.len(), velocity).bounds();
        std::array::from_fn(|c| if c < 3 { high[c] } else { -low[c - 3] })
    }

    /// Collects the slaves: owned nodes on the surface.
    pub fn collect_slaves(&mut self, nodes: &Nodes) {
        self.slaves = self.owned_nodes(nodes);
    }

    /// Collects the slaves if this worker searches for what lies in a region, whatever worker owns
    /// it: nodes there, and segments whose first node is there. The ghosts must be complete.
    pub fn collect_slaves_in(&mut self, nodes: &Nodes, contains: impl Fn([f64; 3]) -> bool) {
        self.node_half.resize(nodes.len(), 0.0);
        self.node_scale.resize(nodes.len(), 0.0);
        for i in 0..self.segments.len() {
            let g = self.segments[i];
            g.nodes.iter().for_each(|&n| self.include_remote(n, g.half_thickness, g.scale));
            self.segments[i].searched = contains(xyz(&nodes.x[g.nodes[0] as usize]));
        }
        self.owned = Some(self.owned_nodes(nodes));
        let is_slave = |&i: &usize| self.node_scale[i] > 0.0 && contains(xyz(&nodes.x[i]));
        self.slaves = (0..nodes.len()).filter(is_slave).map(|i| i as u32).collect();
    }

    /// Returns the owned nodes on the surface, ascending.
    fn owned_nodes(&self, nodes: &Nodes) -> Vec<u32> {
        let on_surface =
            |i: &u32| nodes.is_owned(*i as usize) && self.node_scale[*i as usize] > 0.0;
        (0..nodes.local_count as u32).filter(on_surface).collect()
    }
}
