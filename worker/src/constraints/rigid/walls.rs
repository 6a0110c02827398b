//! Contact of rigid bodies with rigid walls: no member may end a step behind a wall. Coulomb
//! friction. The bounds of the centre of a body (`stop`) act in the same sweeps, without friction.
//!
//! The impulses on members are found by projected Gauss-Seidel (Moreau 1988; Jean 1999), in
//! ascending (wall, node). All workers have the positions of all members, so all compute the
//! same. The impact is plastic, as it is for single nodes.

use super::body::Body;
use super::joints::Joints;
use crate::constraints::walls::Walls;
use crate::math::row::V3;
use crumple_proto::ids::NodeId;

/// Largest number of sweeps, and the relative change at which they end.
const SWEEPS: usize = 200;
const SETTLED: f64 = 1e-10;
/// Least compliance of a member with joints, as a fraction of that without: joints may hold it.
const REDUCED: f64 = 1e-9;

/// Impulse of a wall on a member, or of a bound on the centre.
#[derive(Clone, Copy, Debug)]
pub struct WallImpulse {
    /// Index of the body.
    pub body: usize,
    /// Index of the wall; `None` for a bound of the centre.
    pub wall: Option<usize>,
    /// Position of the member relative to the centre [length].
    pub arm: V3,
    /// Impulse [force time].
    pub impulse: V3,
    /// Part of it that is friction [force time].
    pub friction: V3,
}

/// Member near a wall, or a bound of the centre.
pub struct WallCandidate {
    /// Index of the wall; `None` for a bound.
    wall: Option<usize>,
    arm: V3,
    normal: V3,
    gap: f64,
    soft: f64,
    pressed: f64,
    sheared: V3,
}

/// Contact of all walls with the bodies, one after the other.
pub struct WallContact<'a> {
    /// The walls.
    pub walls: &'a Walls,
    /// Velocities of the walls, changed by the impulses of the bodies so far if a wall has a
    /// mass [length/time].
    pub velocity: &'a mut [V3],
    /// Step size [time].
    pub dt: f64,
    /// Impulses so far.
    pub pushes: &'a mut Vec<WallImpulse>,
}

impl WallContact<'_> {
    /// Keeps the members `near` of a body in front of all walls.
    pub fn sweep(&mut self, body: &mut Body, near: &mut [WallCandidate]) {
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0f64, 0.0f64);
            for n in near.iter_mut() {
                change = change.max(self.touch(body, n));
                largest = largest.max(n.pressed);
            }
            if change <= SETTLED * largest {
                break;
            }
        }
    }

    /// Keeps the members `near` of each body in front of all walls; after each change the joints
    /// are solved again.
    pub fn sweep_with_joints(
        &mut self,
        bodies: &mut [Body],
        joints: &mut Joints,
        near: &mut [Vec<WallCandidate>],
    ) {
        for (b, list) in near.iter_mut().enumerate() {
            for n in list {
                let reduced = n.soft - joints.reduction(bodies, b, &n.arm, &n.normal);
                n.soft = reduced.max(REDUCED * n.soft);
            }
        }
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0f64, 0.0f64);
            for (b, list) in near.iter_mut().enumerate() {
                for n in list {
                    let moved = self.touch(&mut bodies[b], n);
                    if moved > 0.0 {
                        joints.correct(bodies);
                    }
                    change = change.max(moved);
                    largest = largest.max(n.pressed);
                }
            }
            if change <= SETTLED * largest {
                break;
            }
        }
    }

    /// Updates the impulse on a member; returns the size of its change [force time].
    fn touch(&mut self, body: &mut Body, n: &mut WallCandidate) -> f64 {
        let wall = n.wall.map(|w| (&self.walls.each()[w], &mut self.velocity[w]));
        let moving = wall.as_ref().map_or_else(V3::zeros, |(_, velocity)| **velocity);
        let opening = n.gap / self.dt + n.normal.dot(&(body.velocity_at(&n.arm) - moving));
        let pressed = (n.pressed - opening / n.soft).max(0.0);
        let by = n.normal * (pressed - n.pressed);
        n.pressed = pressed;
        body.add_impulse(&by, &n.arm.cross(&by));
        let mut moved = by.norm();
        let Some((wall, velocity)) = wall else { return moved };
        *velocity -= wall.recoil(&by);
        if wall.friction > 0.0 && (pressed > 0.0 || n.sheared != V3::zeros()) {
            let v = body.velocity_at(&n.arm) - *velocity;
            let sliding = v - n.normal * n.normal.dot(&v);
            let soft = sliding.try_normalize(0.0).map_or(0.0, |d| body.compliance(&n.arm, &d));
            let wanted = if soft > 0.0 { n.sheared - sliding / soft } else { n.sheared };
            let (size, limit) = (wanted.norm(), wall.friction * pressed);
            let sheared = if size > limit { wanted * (limit / size) } else { wanted };
            let by = sheared - n.sheared;
            n.sheared = sheared;
            body.add_impulse(&by, &n.arm.cross(&by));
            moved = moved.max(by.norm());
        }
        moved
    }

    /// Records the impulses on the members `near` of body number `index`.
    pub fn record(&mut self, index: usize, near: &[WallCandidate]) {
        let pushed = near.iter().filter(|n| n.pressed > 0.0);
        self.pushes.extend(pushed.map(|n| {
            let impulse = n.normal * n.pressed + n.sheared;
            WallImpulse { body: index, wall: n.wall, arm: n.arm, impulse, friction: n.sheared }
        }));
    }

    /// Returns the members that walls may stop in the step, in ascending (wall, node). `arms` are
    /// positions of members relative to the centre at time 0; a member may get the speed `fastest`
    /// from other bodies.
    pub fn find_candidates(
        &self,
        body: &Body,
        (arms, ids): (&[V3], &[NodeId]),
        fastest: f64,
    ) -> Vec<WallCandidate> {
        let far = arms.iter().map(|a| a.norm()).fold(0.0, f64::max);
        let mut near: Vec<WallCandidate> = Vec::new();
        for ((number, wall), velocity) in
            self.walls.each().iter().enumerate().zip(self.velocity.iter())
        {
            if !wall.acts() {
                continue;
            }
            let own = body.next.velocity - velocity;
            let speed = (own.norm() + far * body.spin(&body.next.angular).norm())
                .max(fastest + velocity.norm() * f64::from(fastest > 0.0));
            // Twice the largest motion of the body in the step: impulses of other walls may
            // accelerate it.
            let reach = 2.0 * self.dt * speed;
            if wall.surface.distance(&body.centre) - far > reach {
                continue;
            }
            for (a, &id) in arms.iter().zip(ids) {
                let arm = body.turn * a;
                let Some((normal, gap)) = wall.surface.near(&(body.centre + arm), self.dt * speed)
                else {
                    continue;
                };
                let soft = body.compliance(&arm, &normal) + wall.softness();
                if gap <= reach && soft > 0.0 && wall.admits(id) {
                    near.push(WallCandidate {
                        wall: Some(number),
                        arm,
                        normal,
                        gap,
                        soft,
                        pressed: 0.0,
                        sheared: V3::zeros(),
                    });
                }
            }
        }
        near.extend(body.limits.iter().filter_map(|&(normal, gap)| {
            let (arm, soft) = (V3::zeros(), body.compliance(&V3::zeros(), &normal));
            let (pressed, sheared) = (0.0, V3::zeros());
            let bound = WallCandidate { wall: None, arm, normal, gap, soft, pressed, sheared };
            (soft > 0.0).then_some(bound)
        }));
        near
    }
}
