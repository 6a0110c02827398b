//! Rigid bodies against rigid walls: no member may end a step behind one. Coulomb friction.
//!
//! Impulses on the members by projected Gauss-Seidel (Moreau 1988; Jean 1999), in ascending (wall, node). All workers
//! have all members' places, so all compute the same. Like that of single nodes the impact is plastic.

use super::body::Body;
use crate::contact::geometry::V3;
use crate::wall::Walls;

/// Most sweeps, and the relative change at which they end.
const SWEEPS: usize = 200;
const SETTLED: f64 = 1e-10;

/// The impulse of a wall on a member.
#[derive(Clone, Copy, Debug)]
pub struct Push {
    /// The body.
    pub body: usize,
    /// The wall.
    pub wall: usize,
    /// Place of the member against the centre [length].
    pub arm: V3,
    /// Impulse [force time].
    pub impulse: V3,
}

/// A member near a wall.
struct Near {
    wall: usize,
    arm: V3,
    normal: V3,
    friction: f64,
    gap: f64,
    soft: f64,
    pressed: f64,
    sheared: V3,
}

/// Keeps the members of body number `index`, at `arms` from its centre at time 0, out of all walls; notes the impulses.
pub fn keep_out(index: usize, body: &mut Body, arms: &[V3], walls: &Walls, dt: f64, pushes: &mut Vec<Push>) {
    let far = arms.iter().map(|a| a.norm()).fold(0.0, f64::max);
    // Twice what the body can move in the step: impulses of other walls may speed it up.
    let reach = 2.0 * dt * (body.next.velocity.norm() + far * body.spin(&body.next.angular).norm());
    let mut near: Vec<Near> = Vec::new();
    for (wall, (normal, offset, friction)) in walls.planes().enumerate() {
        if normal.dot(&body.centre) - offset - far > reach {
            continue;
        }
        for a in arms {
            let arm = body.turn * a;
            let gap = normal.dot(&(body.centre + arm)) - offset;
            let soft = body.compliance(&arm, &normal);
            if gap <= reach && soft > 0.0 {
                near.push(Near { wall, arm, normal, friction, gap, soft, pressed: 0.0, sheared: V3::zeros() });
            }
        }
    }
    for _ in 0..SWEEPS {
        let (mut change, mut largest) = (0.0f64, 0.0f64);
        for n in &mut near {
            let opening = n.gap / dt + n.normal.dot(&body.velocity_at(&n.arm));
            let pressed = (n.pressed - opening / n.soft).max(0.0);
            let by = n.normal * (pressed - n.pressed);
            n.pressed = pressed;
            body.push(&by, &n.arm.cross(&by));
            let mut moved = by.norm();
            if n.friction > 0.0 && (pressed > 0.0 || n.sheared != V3::zeros()) {
                let v = body.velocity_at(&n.arm);
                let sliding = v - n.normal * n.normal.dot(&v);
                let soft = sliding.try_normalize(0.0).map_or(0.0, |d| body.compliance(&n.arm, &d));
                let wanted = if soft > 0.0 { n.sheared - sliding / soft } else { n.sheared };
                let (size, limit) = (wanted.norm(), n.friction * pressed);
                let sheared = if size > limit { wanted * (limit / size) } else { wanted };
                let by = sheared - n.sheared;
                n.sheared = sheared;
                body.push(&by, &n.arm.cross(&by));
                moved = moved.max(by.norm());
            }
            change = change.max(moved);
            largest = largest.max(pressed);
        }
        if change <= SETTLED * largest {
            break;
        }
    }
    let pushed = near.iter().filter(|n| n.pressed > 0.0);
    pushes.extend(pushed.map(|n| {
        let impulse = n.normal * n.pressed + n.sheared;
        Push { body: index, wall: n.wall, arm: n.arm, impulse }
    }));
}
