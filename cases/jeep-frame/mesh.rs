//! Ladder frame of a light off-road truck: two closed box rails with front and rear kick-ups, five
//! cross members. Lengths in mm. The vehicle points to -x: front tips at x = 0, rear ends at x =
//! `length`; y is across, z is up.
//!
//! Sizes and their reasons (light-duty ladder frame; there is no drawing of the published frame):
//! - The rails are 120 mm deep, 70 mm wide and 4 m long, and 780 mm apart inside. Their depth is in
//!   the middle of the usual 100 to 140 mm. The overall width of 920 mm is between the 0.75 m of a
//!   small jeep and the 1.0 m of a light truck.
//! - The rails rise 110 mm over the front axle and 80 mm over the rear one, enough for a live axle
//!   on leaf springs. The kick-ups are 2.0 m apart, the wheelbase of a short jeep.
//! - The horns reach 480 mm ahead of the engine member. Folding shortens about 0.73 of it: 0.35 m
//!   (README.md). They drop 18 mm towards the tips. With 35 mm and more they bend into a Z instead,
//!   at half the force.
//! - Over the first 120 mm the horns taper to 90 mm at the tips, so that the first fold starts
//!   there. The front beam is directly behind the tips and holds their free edges together.
//! - The engine member is as deep as the rails and about 96 mm long, so its four corners coincide
//!   with the corners of the rails, and its flanges are in the planes of their flanges. The other
//!   members are small tubes of 48 mm.
//! - The engine is on the middle 303 mm of its member, the width between two engine mounts. The
//!   load is bolted to the four edges of the last metre of both rails, like a bed.
//!
//! Quads: a fold is about 2 * 29 mm long, so the quads of the horns are 0.58 times as long as those
//! behind: 15 mm, and 26 mm behind the front of the engine member. Around the rail they are 23 to
//! 24 mm, at the tips 18 mm. Finer quads would have sides below half of the median side.
//!
//! Counts: a rail is a tube with open ends, 16 quads around (5 on each wall, 3 on each flange) and
//! 169 along. A cross member is a tube of n quads around and 36 along. Its end rings are nodes of
//! the inner walls of the rails; the walls continue through the rings. With n = 8 + 18 + 8 + 8 + 8
//! = 50: shells `2*16*169 + 36*50 = 7208`, nodes `2*16*170 + 35*50 = 7190`. `refine = 3` gives
//! 64,872 shells and 64,818 nodes, the class of the 65,000-element car.
//!
//! `horn_refine` refines the horns and the front beam further, because only they fold. One ring of
//! triangles, one quad ahead of the engine member, connects the fine mesh to the coarse one.

use crate::builder::Builder;
use crate::{Generator, OptionRow, Options};
use crumple_proto::mesh::Mesh;
use crumple_proto::problem::Problem;

/// The row of this file in the table of generators.
pub const GENERATOR: Generator = Generator { name: "jeep_frame", options: OPTIONS, build };

const OPTIONS: &[OptionRow] = &[
    ("refine", 1.0, "number of pieces of each side of a shell, 1 to 27"),
    (
        "horn_refine",
        1.0,
        "further number of pieces of each of these in the horns and the front beam, 1 to 9",
    ),
    ("length", 4000.0, "overall length [mm]"),
    ("rail_depth", 120.0, "height of the rail section, mid-surface [mm]"),
    ("rail_width", 70.0, "width of the rail section, mid-surface [mm]"),
    ("rail_gap", 780.0, "distance between the inner walls of the rails [mm]"),
    ("front_height", 110.0, "rise of the rails over the front axle [mm]"),
    ("rear_height", 80.0, "rise of the rails over the rear axle [mm]"),
    ("horn_length", 480.0, "front tips to the front of the engine member [mm]"),
    ("horn_drop", 18.0, "front tips below the engine member [mm]"),
    ("tip_depth", 90.0, "height of the rail section at the tips, mid-surface [mm]"),
    ("taper_to", 120.0, "x from which the section has its full height [mm]"),
    ("fine", 0.58, "length of the quads of the horns as a fraction of those behind"),
    ("fine_to", 460.0, "x up to which quads have that length [mm]"),
    ("fine_fade", 80.0, "length over which they grow to full length [mm]"),
    ("front_kick_from", 720.0, "x where the front kick-up starts [mm]"),
    ("front_kick_to", 1220.0, "x where the front kick-up ends [mm]"),
    ("rear_kick_from", 2650.0, "x where the rear kick-up starts [mm]"),
    ("rear_kick_to", 3250.0, "x where the rear kick-up ends [mm]"),
    ("front_beam_at", 30.0, "x of the middle of the front beam [mm]"),
    ("gearbox_member_at", 1500.0, "x of the middle of the gearbox member [mm]"),
    ("middle_member_at", 2550.0, "x of the middle of the middle member [mm]"),
    ("rear_member_at", 3500.0, "x of the middle of the rear member [mm]"),
    ("front_part_to", 700.0, "x where part rail-front ends [mm]"),
    ("rear_part_from", 2630.0, "x where part rail-rear starts [mm]"),
    ("engine_patch", 300.0, "width of the patch that carries the engine [mm]"),
    ("rear_patch", 1000.0, "length of the rear ends of the rails that carry the rear mass [mm]"),
];

/// Quads on a rail wall, on a rail flange, along a rail, along a cross member; each times `refine`.
const WALL: usize = 5;
const FLANGE: usize = 3;
const ALONG_RAIL: usize = 169;
const ALONG_MEMBER: usize = 36;

/// Part ids: three of the rails, then the members from front to rear.
const RAIL_FRONT: u32 = 1;
const RAIL_MIDDLE: u32 = 2;
const RAIL_REAR: u32 = 3;
const FIRST_MEMBER: u32 = 4;

/// A cross member: its end ring as a rectangle of the rail wall, in quads at `refine = 1`.
struct FrameMember {
    /// First station of the ring.
    first: usize,
    /// Quads along the rail.
    along: usize,
    /// Lowest row of the ring, counted from the rail's bottom.
    low: usize,
    /// Quads over the rail's depth.
    deep: usize,
}

/// Centre line of a rail in the x-z plane: steps of height joined by S-curves.
struct Path {
    /// Height at x = 0 [mm].
    start: f64,
    /// S-curves: from x, to x, rise [mm].
    curves: [(f64, f64, f64); 3],
    /// Overall length [mm].
    length: f64,
    /// Height of the section at x = 0, full height, and the x where it is reached [mm].
    taper: (f64, f64, f64),
    /// Length of the quads of the horns as a fraction of those behind; the x where it starts to
    /// grow, and the x where it ends [mm].
    fine: (f64, f64, f64),
}

impl Path {
    /// Height [mm] and slope at x. The S-curve 10u^3 - 15u^4 + 6u^5 is smooth to the second
    /// derivative.
    fn height(&self, x: f64) -> (f64, f64) {
        self.curves.iter().fold((self.start, 0.0), |(z, slope), &(from, to, rise)| {
            let u = ((x - from) / (to - from)).clamp(0.0, 1.0);
            let w = u * (1.0 - u);
            (
                z + rise * u * u * u * (10.0 + u * (6.0 * u - 15.0)),
                slope + rise / (to - from) * 30.0 * w * w,
            )
        })
    }

    /// Height of the section [mm].
    fn depth(&self, x: f64) -> f64 {
        let (tip, full, to) = self.taper;
        if x < to { tip + (full - tip) * (x / to) } else { full }
    }

    /// Length of quads as a fraction of that in the rear.
    fn fineness(&self, x: f64) -> f64 {
        let (fine, from, to) = self.fine;
        fine + (1.0 - fine) * ((x - from) / (to - from)).clamp(0.0, 1.0)
    }

    /// Returns x of `n + 1` stations that divide the line into `n` pieces, weighted by `fineness`.
    fn stations(&self, n: usize) -> Vec<f64> {
        let pieces = 64 * n;
        let step = self.length / pieces as f64;
        let mut arc = vec![0.0];
        for i in 0..pieces {
            let x = (i as f64 + 0.5) * step;
            let slope = self.height(x).1;
            arc.push(arc[i] + step * (1.0 + slope * slope).sqrt() / self.fineness(x));
        }
        let mut i = 0;
        (0..=n)
            .map(|k| {
                let target = arc[pieces] * (k as f64 / n as f64);
                while i + 1 < pieces && arc[i + 1] < target {
                    i += 1;
                }
                step * (i as f64 + (target - arc[i]) / (arc[i + 1] - arc[i]))
            })
            .collect()
    }
}

/// The checked options, converted to the quantities that define the mesh.
struct FramePlan {
    refine: usize,
    /// Pieces of a side in the horns and the front beam, in addition to `refine`.
    horns: usize,
    /// Station at `refine = 1` where the finer mesh of the horns ends.
    turn: usize,
    path: Path,
    width: f64,
    gap: f64,
    members: [FrameMember; 5],
    /// Stations at `refine = 1` where part rail-front ends and part rail-rear starts.
    parts: [usize; 2],
    /// Quads across of the engine patch, and along of the rear patch, at `refine = 1`.
    engine: usize,
    rear: usize,
}

impl FramePlan {
    fn new(options: &Options) -> Result<Self, Vec<Problem>> {
        let mut wrong = Vec::new();
        let refine = options.count("refine", 1..=27, &mut wrong);
        let horns = options.count("horn_refine", 1..=9, &mut wrong);
        let length = options.real("length", 2000.0..=8000.0, &mut wrong);
        let depth = options.real("rail_depth", 60.0..=250.0, &mut wrong);
        let width = options.real("rail_width", 40.0..=160.0, &mut wrong);
        let gap = options.real("rail_gap", 400.0..=1400.0, &mut wrong);
        let front = options.real("front_height", 0.0..=300.0, &mut wrong);
        let rear = options.real("rear_height", 0.0..=300.0, &mut wrong);
        let drop = options.real("horn_drop", -200.0..=200.0, &mut wrong);
        let horn = options.real("horn_length", 150.0..=1000.0, &mut wrong);
        let tip_depth = options.real("tip_depth", 40.0..=250.0, &mut wrong);
        let fine = options.real("fine", 0.25..=1.0, &mut wrong);
        let fade = options.real("fine_fade", 1.0..=2000.0, &mut wrong);
        let mut place = |key| options.real(key, 0.0..=length, &mut wrong);
        let taper = (tip_depth, depth, place("taper_to"));
        let fine_to = place("fine_to");
        let fine = (fine, fine_to, fine_to + fade);
        let front_kick = (place("front_kick_from"), place("front_kick_to"));
        let rear_kick = (place("rear_kick_from"), place("rear_kick_to"));
        let beam = place("front_beam_at");
        let middles =
            [place("gearbox_member_at"), place("middle_member_at"), place("rear_member_at")];
        let parts = [place("front_part_to"), place("rear_part_from")];
        let engine_patch = options.real("engine_patch", 20.0..=gap, &mut wrong);
        let rear_patch = options.real("rear_patch", 10.0..=1000.0, &mut wrong);

        // The horn bends between a quarter and nine tenths of its length, clear of front beam and
        // engine member.
        let curves = [
            (0.25 * horn, 0.9 * horn, drop),
            (front_kick.0, front_kick.1, -front),
            (rear_kick.0, rear_kick.1, rear),
        ];
        check_curves(&curves, depth, &mut wrong);
        if !wrong.is_empty() {
            return Err(wrong);
        }

        let path = Path { start: front - drop, curves, length, taper, fine };
        let coarse = path.stations(ALONG_RAIL);
        let station = |x: f64| {
            (1..ALONG_RAIL).min_by(|&a, &b| (coarse[a] - x).abs().total_cmp(&(coarse[b] - x).abs()))
        };
        let station = |x: f64| station(x).unwrap_or(1);
        let small = |x: f64, low| FrameMember { first: station(x) - 1, along: 2, low, deep: 2 };
        let members = [
            small(beam, 2),
            FrameMember { first: station(horn), along: 4, low: 0, deep: WALL },
            small(middles[0], 1),
            small(middles[1], 1),
            small(middles[2], 3),
        ];
        check_members(&members, &mut wrong);
        if parts[0] >= parts[1] {
            wrong.push(Problem::error(
                "scene.rear_part_from",
                "part rail-rear starts ahead of the end of part rail-front",
                "give an x behind front_part_to",
            ));
        }
        if !wrong.is_empty() {
            return Err(wrong);
        }
        // An even number of quads, so that the patch stays in the middle.
        let engine = 2 * ((0.5 * engine_patch * ALONG_MEMBER as f64 / gap).round() as usize).max(1);
        let parts = parts.map(station);
        let rear = ALONG_RAIL - station(length - rear_patch);
        let turn = members[1].first - 1;
        Ok(Self { refine, horns, turn, path, width, gap, members, parts, engine, rear })
    }

    /// Returns the number of pieces of a shell side at a station of `refine = 1`.
    fn pieces(&self, station: usize) -> usize {
        if station < self.turn { self.refine * self.horns } else { self.refine }
    }

    /// Returns the ring of nodes at a station of `refine = 1`.
    fn ring(&self, station: usize) -> usize {
        self.refine * (station + (self.horns - 1) * station.min(self.turn))
    }

    /// x of all rings.
    fn rings(&self) -> Vec<f64> {
        let coarse = self.path.stations(ALONG_RAIL * self.refine);
        if self.horns == 1 {
            return coarse;
        }
        let mut all = self.path.stations(ALONG_RAIL * self.refine * self.horns);
        all.truncate(self.ring(self.turn) + 1);
        all.extend(&coarse[self.turn * self.refine + 1..]);
        all
    }
}

/// Reports S-curves that are too sharp for the rail: start, end and rise [mm].
fn check_curves(curves: &[(f64, f64, f64); 3], depth: f64, wrong: &mut Vec<Problem>) {
    let keys = ["horn_length", "front_kick_to", "rear_kick_to"];
    for ((from, to, rise), key) in curves.iter().zip(keys) {
        // Largest curvature of the S-curve; a quad at the inner flange must keep two thirds of its
        // length.
        let needed = (0.5 * depth * 5.7735 * rise.abs() * 3.0).sqrt().max(1.0);
        if to - from < needed {
            wrong.push(Problem::error(
                format!("scene.{key}"),
                format!(
                    "an S-curve of height {rise} mm over {:.0} mm is too sharp for this rail",
                    to - from
                ),
                format!("make it at least {needed:.0} mm long, or lower"),
            ));
        }
    }
}

/// Reports cross members that touch each other.
fn check_members(members: &[FrameMember; 5], wrong: &mut Vec<Problem>) {
    let keys =
        ["front_beam_at", "horn_length", "gearbox_member_at", "middle_member_at", "rear_member_at"];
    for (pair, key) in members.windows(2).zip(&keys[1..]) {
        if pair[1].first <= pair[0].first + pair[0].along {
            wrong.push(Problem::error(
                format!("scene.{key}"),
                "this cross member touches the previous one or is ahead of it",
                format!("keep the order {} and a gap between them", keys.join(", ")),
            ));
        }
    }
}

/// Builds the frame.
fn build(options: &Options) -> Result<Mesh, Vec<Problem>> {
    let plan = FramePlan::new(options)?;
    let mut mesh = Builder::default();
    let rails = [1.0, -1.0].map(|side| add_rail(&mut mesh, &plan, side));
    for (member, part) in plan.members.iter().zip(FIRST_MEMBER..) {
        add_member(&mut mesh, &plan, &rails, member, part);
    }
    let rear = plan.rear * plan.refine;
    for rail in &rails {
        mesh.set("front", rail[0].iter().copied());
        // The edges of the section carry the load. The middle of a wall would only vibrate.
        let edges = [0, WALL, WALL + FLANGE, 2 * WALL + FLANGE].map(|j| j * plan.refine);
        mesh.set(
            "rear",
            rail[rail.len() - 1 - rear..].iter().flat_map(|ring| edges.map(|j| ring[j])),
        );
    }
    Ok(mesh.finish(plan.path.length / (ALONG_RAIL * plan.refine) as f64))
}

/// Adds the rail on one side (y > 0 for 1.0, y < 0 for -1.0) and returns its rings of nodes from
/// front to rear. A ring starts at the bottom of the inner wall, so its node `j` is row `j` of that
/// wall.
fn add_rail(mesh: &mut Builder, plan: &FramePlan, side: f64) -> Vec<Vec<usize>> {
    // The section: distance from the inner wall outwards and height above the bottom, as fractions.
    let section = |pieces: usize| {
        let (wall, flange) = (WALL * pieces, FLANGE * pieces);
        let mut section = Vec::new();
        section.extend((0..wall).map(|j| (0.0, j as f64 / wall as f64)));
        section.extend((0..flange).map(|j| (j as f64 / flange as f64, 1.0)));
        section.extend((0..wall).map(|j| (1.0, 1.0 - j as f64 / wall as f64)));
        section.extend((0..flange).map(|j| (1.0 - j as f64 / flange as f64, 0.0)));
        section
    };
    let (fine, coarse) = (section(plan.refine * plan.horns), section(plan.refine));

    let mut rings: Vec<Vec<usize>> = Vec::new();
    let turn = plan.ring(plan.turn);
    for (i, x) in plan.rings().into_iter().enumerate() {
        let (z, slope) = plan.path.height(x);
        let scale = 1.0 / (1.0 + slope * slope).sqrt();
        let place = |&(out, up): &(f64, f64)| {
            // Perpendicular to the centre line, so that no quad is skewed.
            let d = (up - 0.5) * plan.path.depth(x);
            [x - d * slope * scale, side * (0.5 * plan.gap + out * plan.width), z + d * scale]
        };
        let section = if i <= turn { &fine } else { &coarse };
        rings.push(section.iter().map(|s| mesh.point(place(s))).collect());
    }
    for (i, pair) in rings.windows(2).enumerate() {
        let part = match i {
            i if i < plan.ring(plan.parts[0]) => RAIL_FRONT,
            i if i < plan.ring(plan.parts[1]) => RAIL_MIDDLE,
            _ => RAIL_REAR,
        };
        if i == turn && plan.horns > 1 {
            mesh.fans(part, &pair[0], &pair[1]);
        } else {
            mesh.strip(part, &pair[0], &pair[1], true);
        }
    }
    rings
}

/// Adds a cross member between the rails; its end rings are nodes of their inner walls.
fn add_member(
    mesh: &mut Builder,
    plan: &FramePlan,
    rails: &[Vec<Vec<usize>>; 2],
    member: &FrameMember,
    part: u32,
) {
    let r = plan.pieces(member.first);
    let (i0, i1) = (plan.ring(member.first), plan.ring(member.first + member.along));
    let (j0, j1) = (member.low * r, (member.low + member.deep) * r);
    let mut rectangle: Vec<(usize, usize)> = (i0..i1).map(|i| (i, j0)).collect();
    rectangle.extend((j0..j1).map(|j| (i1, j)));
    rectangle.extend((i0 + 1..=i1).rev().map(|i| (i, j1)));
    rectangle.extend((j0 + 1..=j1).rev().map(|j| (i0, j)));
    let [left, right] =
        [0, 1].map(|side| rectangle.iter().map(|&(i, j)| rails[side][i][j]).collect::<Vec<_>>());

    let n = ALONG_MEMBER * r;
    let engine = n / 2 - plan.engine * r / 2..=n / 2 + plan.engine * r / 2;
    let mut row = left.clone();
    for k in 1..=n {
        let next = if k == n {
            right.clone()
        } else {
            let y = plan.gap * (0.5 - k as f64 / n as f64);
            let neighbour = |&i: &usize| {
                let [x, _, z] = mesh.at(i);
                mesh.point([x, y, z])
            };
            left.iter().map(neighbour).collect()
        };
        mesh.strip(part, &row, &next, true);
        if part == FIRST_MEMBER + 1 && engine.contains(&k) {
            mesh.set("engine", next.iter().copied());
        }
        row = next;
    }
}
