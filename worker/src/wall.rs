//! Fixed planar rigid walls: a node may not end a step behind one. Coulomb friction on the wall.

use crate::contact::enforce::Steps;
use crate::energy::Work;
use crate::nodes::{Nodes, Row};
use crumple_proto::job::Wall as WallJob;
use nalgebra::Vector3;

/// One wall.
#[derive(Clone, Debug)]
struct Wall {
    normal: Vector3<f64>,
    /// n . point [length].
    offset: f64,
    friction: f64,
}

/// All walls of the scene.
#[derive(Clone, Debug, Default)]
pub struct Walls {
    walls: Vec<Wall>,
    /// Impulse that each wall has given to owned nodes so far [force time].
    pub impulse: Vec<[f64; 3]>,
}

impl Walls {
    /// From the job; normals are made unit vectors.
    pub fn new(jobs: &[WallJob]) -> Self {
        let walls: Vec<Wall> = jobs
            .iter()
            .map(|w| {
                let normal = Vector3::from(w.normal).normalize();
                Wall { normal, offset: normal.dot(&Vector3::from(w.point)), friction: w.friction }
            })
            .collect();
        Self { impulse: vec![[0.0; 3]; walls.len()], walls }
    }

    /// Whether the scene has none.
    pub fn is_empty(&self) -> bool {
        self.walls.is_empty()
    }

    /// Unit normal, distance of the plane from the origin along it, and friction of each wall.
    pub fn planes(&self) -> impl Iterator<Item = (Vector3<f64>, f64, f64)> + '_ {
        self.walls.iter().map(|w| (w.normal, w.offset, w.friction))
    }

    /// The velocity with which a free node at `x` that wants to move with `v` ends the step outside of all walls.
    /// Depends on nothing else, so every holder of a node computes the same.
    #[inline]
    pub fn stop(&self, x: &Row, mut v: Row, inv_mass: &Row, dt: f64) -> Row {
        for w in &self.walls {
            if let Some(change) = w.change(x, &v, dt) {
                for c in 0..3 {
                    v[c] += if inv_mass[c] > 0.0 { change[c] } else { 0.0 };
                }
            }
        }
        v
    }

    /// Keeps all held nodes out, starting from their velocities in `next_v`, or from those in `pushed`
    /// for nodes that contact pairs touch (ascending). Returns the work done on owned nodes [energy].
    pub fn keep_out(&mut self, nodes: &mut Nodes, pushed: &[(u32, Row)], steps: Steps) -> Work {
        let mut pushed = pushed.iter().peekable();
        let mut work = Work::default();
        for i in 0..nodes.held {
            let free = pushed.next_if(|p| p.0 as usize == i).map_or(nodes.next_v[i], |p| p.1);
            nodes.next_v[i] = self.stop(&nodes.x[i], free, &nodes.inv_mass[i], steps.dt);
            if nodes.is_own(i) && nodes.next_v[i] != free {
                work += self.book(nodes, i, free, steps);
            }
        }
        work
    }

    /// Books the impulses that bring owned node `i` from velocity `v` to its next one. Returns the work [energy].
    fn book(&mut self, nodes: &Nodes, i: usize, mut v: Row, steps: Steps) -> Work {
        let mut work = Work::default();
        for (w, impulse) in self.walls.iter().zip(&mut self.impulse) {
            let Some(change) = w.change(&nodes.x[i], &v, steps.dt) else { continue };
            for c in (0..3).filter(|&c| nodes.inv_mass[i][c] > 0.0) {
                v[c] += change[c];
                let p = nodes.mass[i] * change[c] * (steps.mid / steps.push);
                impulse[c] += p;
                work += Work::of(p, nodes.v[i][c], nodes.next_v[i][c]);
            }
        }
        work
    }
}

impl Wall {
    /// Change of velocity that keeps the node out, friction included.
    #[inline]
    fn change(&self, x: &Row, v: &Row, dt: f64) -> Option<Vector3<f64>> {
        let (x, v) = (Vector3::new(x[0], x[1], x[2]), Vector3::new(v[0], v[1], v[2]));
        let gap = self.normal.dot(&x) - self.offset + dt * self.normal.dot(&v);
        if gap >= 0.0 {
            return None;
        }
        let normal = -gap / dt;
        let sliding = v - self.normal * self.normal.dot(&v);
        let speed = sliding.norm();
        let held = if speed > self.friction * normal { self.friction * normal / speed } else { 1.0 };
        Some(self.normal * normal - sliding * held)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crumple_proto::ids::NodeId;
    use crumple_proto::partition::NodeRecord;

    fn wall(friction: f64) -> Walls {
        let point = [0.0, 0.0, 1.0];
        Walls::new(&[WallJob { name: String::new(), point, normal: [0.0, 0.0, 2.0], friction }])
    }

    #[test]
    fn node_ends_on_the_wall_and_friction_obeys_the_cone() {
        let v = wall(0.1).stop(&[0.0, 0.0, 1.5, 0.0], [10.0, 0.0, -10.0, 0.0], &[1.0; 4], 0.1);
        assert!((v[2] + 5.0).abs() < 1e-12, "stops at the plane: {v:?}");
        assert!((v[0] - 9.5).abs() < 1e-12, "slowed by mu times the normal change of 5: {v:?}");
        let v = wall(10.0).stop(&[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, -1.0, 0.0], &[1.0; 4], 0.1);
        assert_eq!([v[0], v[2]], [0.0, 0.0], "sticks");
        let v = wall(0.1).stop(&[0.0, 0.0, 1.0, 0.0], [1.0, 0.0, 0.1, 0.0], &[1.0; 4], 0.1);
        assert_eq!(v, [1.0, 0.0, 0.1, 0.0], "leaves freely");
    }

    /// A mass on the wall under a constant force, for `count` steps of 1e-3. Returns velocity, place and booked work.
    fn slide(walls: &mut Walls, v: [f64; 3], force: [f64; 3], count: usize) -> (Row, Row, f64) {
        let at = [0.0, 0.0, 1.0];
        let block = NodeRecord { id: NodeId(1), x0: at, x: at, v, mass: 2.0, ..NodeRecord::default() };
        let mut nodes = Nodes::new(&[block], 0, true);
        nodes.force[0] = crate::nodes::row(force);
        let mut work = 0.0;
        let steps = Steps { dt: 1e-3, mid: 1e-3, push: 1e-3, whole: 1e-3 };
        for _ in 0..count {
            nodes.accelerate(1e-3);
            work += walls.keep_out(&mut nodes, &[], steps).total();
            nodes.advance(1e-3);
        }
        (nodes.v[0], nodes.x[0], work)
    }

    /// A07: friction slows a sliding block of mass m under a force N with `mu N / m` until it rests, holds it against
    /// a pull below mu N and lets it go above. The wall's force is constant, so steps add no error but round-off,
    /// and the last of them, in which the block stops.
    #[test]
    fn coulomb_friction_slows_holds_and_lets_go() {
        let (mu, n, m) = (0.3, 50.0, 2.0);
        let slowing = mu * n / m;
        let mut walls = wall(mu);
        let (v, x, _) = slide(&mut walls, [10.0, 0.0, 0.0], [0.0, 0.0, -n], 1000);
        assert!((v[0] - (10.0 - slowing)).abs() < 1e-10 && v[2] == 0.0, "{v:?}");
        assert!((x[0] - (10.0 - 0.5 * slowing)).abs() < 0.5e-3 * slowing * 1.01, "mid-step velocities: {x:?}");
        let impulse = walls.impulse[0];
        assert!((impulse[2] - n).abs() < 1e-9 && (impulse[0] + mu * n).abs() < 1e-9, "over a time of 1: {impulse:?}");

        let (v, x, work) = slide(&mut wall(mu), [10.0, 0.0, 0.0], [0.0, 0.0, -n], 2000);
        assert_eq!(v[0], 0.0, "rests");
        assert!((x[0] / (100.0 / (2.0 * slowing)) - 1.0).abs() < 1e-3, "stopping way, to a step: {x:?}");
        assert!((work / (-0.5 * m * 100.0) - 1.0).abs() < 1e-3, "friction took all of it: {work}");

        let (v, x, _) = slide(&mut wall(mu), [0.0; 3], [0.9 * mu * n, 0.0, -n], 1000);
        assert_eq!([v[0], x[0]], [0.0, 0.0], "held");
        let (v, ..) = slide(&mut wall(mu), [0.0; 3], [1.1 * mu * n, 0.0, -n], 1000);
        assert!((v[0] - 0.1 * slowing).abs() < 1e-10, "let go: {v:?}");
    }

    /// Coming down on the wall is a plastic impact: all of the normal part of the energy is lost, friction takes its
    /// part of the sliding at once, and no more than the cone allows.
    #[test]
    fn an_impact_loses_its_normal_part_and_friction_its_share() {
        for mu in [0.0, 0.2, 5.0] {
            let mut walls = wall(mu);
            let (v, x, work) = slide(&mut walls, [3.0, 0.0, -10.0], [0.0; 3], 3);
            let slid = (3.0 - mu * 10.0f64).max(0.0);
            assert!((v[0] - slid).abs() < 1e-12 && v[2].abs() < 1e-12 && (x[2] - 1.0).abs() < 1e-12, "{v:?} {x:?}");
            let lost = 0.5 * 2.0 * (9.0 + 100.0 - slid * slid);
            assert!((work + lost).abs() < 1e-9, "mu {mu}: {work}, not {lost}");
            let p = walls.impulse[0];
            assert!((p[0] - 2.0 * (slid - 3.0)).abs() < 1e-12 && (p[2] - 20.0).abs() < 1e-12, "{p:?}");
        }
    }

    /// In the corner of two walls a node keeps out of both; one that is held fixed is not moved by any.
    #[test]
    fn a_corner_keeps_out_and_a_held_node_stays() {
        let to = |normal| WallJob { name: String::new(), point: [0.0; 3], normal, friction: 0.0 };
        let corner = Walls::new(&[to([1.0, 0.0, 0.0]), to([0.0, 1.0, 0.0])]);
        let v = corner.stop(&[0.1, 0.2, 0.0, 0.0], [-5.0, -5.0, 1.0, 0.0], &[1.0; 4], 0.1);
        assert!((v[0] + 1.0).abs() < 1e-12 && (v[1] + 2.0).abs() < 1e-12 && v[2] == 1.0, "{v:?}");
        let v = corner.stop(&[-1.0, 0.0, 0.0, 0.0], [0.0; 4], &[0.0; 4], 0.1);
        assert_eq!(v, [0.0; 4]);
    }
}
