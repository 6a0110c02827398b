//! Contact of rigid bodies with rigid walls: no member may end a step behind a wall. Coulomb
//! friction.
//!
//! The impulses on members are found by projected Gauss-Seidel (Moreau 1988; Jean 1999), in
//! ascending (wall, node). All workers have the positions of all members, so all compute the
//! same. The impact is plastic, as it is for single nodes.

use super::body::Body;
use crate::constraints::walls::Walls;
use crate::math::row::V3;
use crumple_proto::ids::NodeId;

/// Largest number of sweeps, and the relative change at which they end.
const SWEEPS: usize = 200;
const SETTLED: f64 = 1e-10;

/// Impulse of a wall on a member.
#[derive(Clone, Copy, Debug)]
pub struct WallImpulse {
    /// Index of the body.
    pub body: usize,
    /// Index of the wall.
    pub wall: usize,
    /// Position of the member relative to the centre [length].
    pub arm: V3,
    /// Impulse [force time].
    pub impulse: V3,
}

/// Member near a wall.
pub struct WallCandidate {
    wall: usize,
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
        let dt = self.dt;
        for _ in 0..SWEEPS {
            let (mut change, mut largest) = (0.0f64, 0.0f64);
            for n in near.iter_mut() {
                let wall = &self.walls.each()[n.wall];
                let velocity = &mut self.velocity[n.wall];
                let opening = n.gap / dt + n.normal.dot(&(body.velocity_at(&n.arm) - *velocity));
                let pressed = (n.pressed - opening / n.soft).max(0.0);
                let by = n.normal * (pressed - n.pressed);
                n.pressed = pressed;
                body.add_impulse(&by, &n.arm.cross(&by));
                *velocity -= wall.recoil(&by);
                let mut moved = by.norm();
                if wall.friction > 0.0 && (pressed > 0.0 || n.sheared != V3::zeros()) {
                    let v = body.velocity_at(&n.arm) - *velocity;
                    let sliding = v - n.normal * n.normal.dot(&v);
                    let soft =
                        sliding.try_normalize(0.0).map_or(0.0, |d| body.compliance(&n.arm, &d));
                    let wanted = if soft > 0.0 { n.sheared - sliding / soft } else { n.sheared };
                    let (size, limit) = (wanted.norm(), wall.friction * pressed);
                    let sheared = if size > limit { wanted * (limit / size) } else { wanted };
                    let by = sheared - n.sheared;
                    n.sheared = sheared;
                    body.add_impulse(&by, &n.arm.cross(&by));
                    moved = moved.max(by.norm());
                }
                change = change.max(moved);
                largest = largest.max(pressed);
            }
            if change <= SETTLED * largest {
                break;
            }
        }
    }

    /// Records the impulses on the members `near` of body number `index`.
    pub fn record(&mut self, index: usize, near: &[WallCandidate]) {
        let pushed = near.iter().filter(|n| n.pressed > 0.0);
        self.pushes.extend(pushed.map(|n| {
            let impulse = n.normal * n.pressed + n.sheared;
            WallImpulse { body: index, wall: n.wall, arm: n.arm, impulse }
        }));
    }

    /// Returns the members that walls may stop in the step, in ascending (wall, node). `arms` are
    /// positions of members relative to the centre at time 0.
    pub fn find_candidates(
        &self,
        body: &Body,
        (arms, ids): (&[V3], &[NodeId]),
    ) -> Vec<WallCandidate> {
        let far = arms.iter().map(|a| a.norm()).fold(0.0, f64::max);
        let mut near: Vec<WallCandidate> = Vec::new();
        for ((number, wall), velocity) in
            self.walls.each().iter().enumerate().zip(self.velocity.iter())
        {
            let speed =
                (body.next.velocity - velocity).norm() + far * body.spin(&body.next.angular).norm();
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
                        wall: number,
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
        near
    }
}
