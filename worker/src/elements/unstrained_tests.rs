//! Elements at rest or in uniform flight, whose forces are not computed: the same bits as if they were.

use super::precision_tests::{BOTH, laws, shells, solids};
use super::testing::{Patch, lay};
use super::{CornerForces, Element, NodeView, Pass, PassTotals};
use crate::columns::Columns;
use crumple_proto::job::{HourglassForm, Precision};

/// Fresh elements of C slots and their nodes.
struct Mesh<const C: usize> {
    element: Box<dyn Element>,
    cells: Vec<[u32; C]>,
    groups: Vec<u32>,
    history: Columns,
    unstrained: Vec<bool>,
    x: Vec<[f64; 4]>,
    v: Vec<[f64; 4]>,
    w: Vec<[f64; 4]>,
    force: Vec<[f64; 4]>,
    moment: Vec<[f64; 4]>,
}

impl<const C: usize> Mesh<C> {
    fn new(
        precision: Precision,
        left_out: bool,
        element: Box<dyn Element>,
        cells: Vec<[u32; C]>,
        x: Vec<[f64; 4]>,
    ) -> Self {
        let (groups, history) = lay(&*element, precision, &cells);
        let unstrained = vec![left_out; cells.len().div_ceil(history.lanes())];
        let (corners, still) = (vec![[0.0; 4]; groups.len()], vec![[0.0; 4]; x.len()]);
        let (v, force) = (still.clone(), corners.clone());
        Self { element, cells, groups, history, unstrained, x, v, w: still, force, moment: corners }
    }

    fn step(&mut self, dt: f64) -> PassTotals {
        for (x, v) in self.x.iter_mut().zip(&self.v) {
            (0..3).for_each(|i| x[i] += dt * v[i]);
        }
        self.element.forces(Pass {
            range: 0..self.unstrained.len(),
            count: self.cells.len(),
            groups: &self.groups,
            history: self.history.as_mut(),
            unstrained: &mut self.unstrained,
            nodes: NodeView { x: &self.x, v: &self.v, w: &self.w },
            dt,
            out: CornerForces { force: &mut self.force, moment: &mut self.moment },
        })
    }

    /// Corner forces and moments, then the history of all elements.
    fn numbers(&self) -> impl Iterator<Item = u64> {
        let history = (0..self.cells.len()).flat_map(|e| self.history.of(e).to_vec());
        let corners = self.force.iter().chain(&self.moment).flatten().copied();
        corners.chain(history).map(bits)
    }

    fn is_unstrained(&self, element: usize) -> bool {
        self.element.unstrained(self.history.of(element))
    }
}

/// Bits of a number; minus nought is nought, which no sum of forces tells apart.
fn bits(number: f64) -> u64 {
    (number + 0.0).to_bits()
}

/// Goes with both through rest and flight to a kick of a node of the last element, which is far beyond yield.
fn follow<const C: usize>([mut left_out, mut computed]: [Mesh<C>; 2], turned: bool, name: &str) {
    let (count, lanes) = (computed.cells.len(), computed.history.lanes());
    assert!((0..count).all(|e| computed.is_unstrained(e)), "{name}: fresh elements bear nothing");
    let kicked = computed.cells[count - 1][0];
    let touched: Vec<bool> = computed.cells.iter().map(|cell| cell.contains(&kicked)).collect();
    for cycle in 0..60 {
        let totals = [&mut left_out, &mut computed].map(|mesh| {
            mesh.v.fill(if cycle < 20 { [0.0; 4] } else { [1.3, -0.7, 0.45, 0.0] });
            if cycle >= 40 {
                (if turned { &mut mesh.w } else { &mut mesh.v })[kicked as usize][1] += 0.3;
            }
            mesh.step(if cycle == 0 { 0.0 } else { 0.01 })
        });
        let [a, b] = totals.map(|t| ([t.stable_dt, t.internal, t.hourglass].map(bits), t.trouble));
        assert_eq!(a, b, "{name}, cycle {cycle}");
        assert_eq!(a.1, None, "{name}, cycle {cycle}");
        assert!(left_out.numbers().eq(computed.numbers()), "{name}, cycle {cycle}");
        let is_left_out =
            |group: usize| cycle < 40 || !touched.chunks(lanes).nth(group).expect("a group").contains(&true);
        assert!((0..count.div_ceil(lanes)).all(|g| left_out.unstrained[g] == is_left_out(g)), "{name}, cycle {cycle}");
    }
    assert!((0..count).all(|e| computed.is_unstrained(e) != touched[e]), "{name}: what was kicked bears something");
}

#[test]
fn leaving_out_what_is_nought_changes_no_bit() {
    for (precision, law) in BOTH.into_iter().flat_map(|precision| laws().map(|law| (precision, law))) {
        for (kind, turned) in (0..3).flat_map(|kind| [(kind, false), (kind, true)]) {
            let meshes = [true, false].map(|left_out| {
                let patch = shells(precision, &law, [3.0, 100.0, -7.0]).into_iter().nth(kind).expect("one of three");
                let Patch { element, quads, x, .. } = patch;
                Mesh::new(precision, left_out, element, quads, x)
            });
            follow(meshes, turned, &format!("{precision:?} {} shell {kind}", law.law));
        }
        for form in [HourglassForm::Stiffness, HourglassForm::Viscous, HourglassForm::AssumedStrain] {
            let meshes = [true, false].map(|left_out| {
                let all = solids(precision, &law, form);
                Mesh::new(precision, left_out, all.element, all.cells, all.x)
            });
            follow(meshes, false, &format!("{precision:?} {} solid {form:?}", law.law));
        }
    }
}
