//! Elements at rest or in uniform motion, whose forces are not computed: the results have the same
//! bits as if they were computed.

use super::solid_testing::solids;
use super::testing::{BOTH, FORMULATIONS, Passed, Patch, laws, laws_of_solids, lay, shells};
use super::{Element, HourglassForm};
use crate::columns::HistoryColumns;
use crumple_proto::job::Precision;
use crumple_proto::partition::Material;

/// A mesh of new elements.
trait Mesh {
    fn view(&mut self) -> View<'_>;
    fn step(&mut self, dt: f64) -> Passed;
    fn cells(&self) -> Vec<Vec<usize>>;
}

/// Contents of a mesh. Solids have no moments.
struct View<'a> {
    element: &'a dyn Element,
    history: &'a HistoryColumns,
    unstrained: &'a mut [bool],
    v: &'a mut [[f64; 4]],
    w: &'a mut [[f64; 4]],
    force: &'a mut [[f64; 4]],
    moment: &'a mut [[f64; 4]],
}

impl<const C: usize> Mesh for Patch<C> {
    fn view(&mut self) -> View<'_> {
        let Self { element, history, unstrained, v, w, force, moment, .. } = self;
        View { element: &**element, history, unstrained, v, w, force, moment }
    }

    fn step(&mut self, dt: f64) -> Passed {
        self.step(dt)
    }

    fn cells(&self) -> Vec<Vec<usize>> {
        self.cells.iter().map(|cell| cell.iter().map(|&node| node as usize).collect()).collect()
    }
}

/// Returns the bits of a number, with -0 as +0: no sum of forces can distinguish them.
fn bits(number: f64) -> u64 {
    (number + 0.0).to_bits()
}

/// Change that ends rest or uniform motion, for a component of velocity.
#[derive(Clone, Copy, Debug)]
enum Kick {
    /// Another velocity of this corner of the last element.
    Move(usize),
    /// A rotational velocity of this corner of the last element.
    Turn(usize),
    /// One rotational velocity of all nodes.
    TurnAll,
}

/// Runs rest, uniform motion and a kick with unstrained elements left out, and with all computed.
fn compare_runs(
    [mut left_out, mut computed]: [Box<dyn Mesh>; 2],
    (kick, component): (Kick, usize),
    name: &str,
) {
    let name = format!("{name}, {kick:?} {component}");
    let (cells, lanes) = (computed.cells(), computed.view().history.lanes());
    left_out.view().unstrained.fill(true);
    let (nodes, turned) = match kick {
        Kick::Move(corner) => (vec![cells[cells.len() - 1][corner]], false),
        Kick::Turn(corner) => (vec![cells[cells.len() - 1][corner]], true),
        Kick::TurnAll => ((0..computed.view().v.len()).collect(), true),
    };
    let kicked: Vec<bool> =
        cells.iter().map(|cell| cell.iter().any(|node| nodes.contains(node))).collect();
    for cycle in 0..15 {
        let now = [&mut left_out, &mut computed].map(|mesh| {
            let View { v, w, force, moment, .. } = mesh.view();
            v.fill(if cycle < 5 { [0.0; 4] } else { [1.3, -0.7, 0.45, 0.0] });
            w.fill([0.0; 4]);
            if cycle >= 10 {
                let column = if turned { w } else { v };
                nodes.iter().for_each(|&node| column[node][component] += 0.3);
            }
            // Corners that no element writes would show as NaN in later sums.
            [force, moment].into_iter().for_each(|rows| rows.fill([f64::NAN; 4]));
            let report = mesh.step(if cycle == 0 { 0.0 } else { 0.01 });
            assert_eq!(report.trouble, None, "{name}, cycle {cycle}");
            let View { history, force, moment, .. } = mesh.view();
            let history = (0..cells.len()).flat_map(|e| history.element(e).to_vec());
            let rows = force.iter().chain(&*moment).flatten().copied();
            let report = [report.stable_dt, report.internal, report.hourglass];
            report.into_iter().chain(rows).chain(history).map(bits).collect::<Vec<_>>()
        });
        assert!(now[0] == now[1], "{name}, cycle {cycle}");
        let marks = kicked.chunks(lanes).map(|group| cycle < 10 || !group.contains(&true));
        assert!(marks.eq(left_out.view().unstrained.iter().copied()), "{name}, cycle {cycle}");
        let View { element, history, .. } = computed.view();
        let strained = (0..cells.len()).map(|e| !element.is_unstrained(history.element(e)));
        assert!(
            strained.eq(kicked.iter().map(|&kicked| kicked && cycle >= 10)),
            "{name}, cycle {cycle}"
        );
    }
}

fn fresh_shells(precision: Precision, law: &Material, kind: usize) -> Box<dyn Mesh> {
    Box::new(shells(precision, law, [3.0, 100.0, -7.0]).into_iter().nth(kind).expect("one of them"))
}

/// Returns solids whose volume at the start is not yet set.
fn fresh_solids(precision: Precision, law: &Material, form: HourglassForm) -> Box<dyn Mesh> {
    let mut all = solids(precision, law, form);
    all.history = lay(&*all.element, precision, &all.cells).1;
    Box::new(all)
}

const FORMS: [HourglassForm; 3] =
    [HourglassForm::Stiffness, HourglassForm::Viscous, HourglassForm::AssumedStrain];

#[test]
fn every_law_in_every_element_keeps_its_bits() {
    for (precision, law) in
        BOTH.into_iter().flat_map(|precision| laws().into_iter().map(move |law| (precision, law)))
    {
        for kind in 0..FORMULATIONS.len() {
            let meshes = [0; 2].map(|_| fresh_shells(precision, &law, kind));
            compare_runs(
                meshes,
                (Kick::Move(0), 1),
                &format!("{precision:?} {} shell {kind}", law.law),
            );
        }
    }
    let solids = laws_of_solids();
    for (precision, law) in
        BOTH.into_iter().flat_map(|precision| solids.iter().map(move |law| (precision, law)))
    {
        for form in FORMS {
            let meshes = [0; 2].map(|_| fresh_solids(precision, law, form));
            compare_runs(
                meshes,
                (Kick::Move(0), 1),
                &format!("{precision:?} {} solid {form:?}", law.law),
            );
        }
    }
}

#[test]
fn whatever_any_corner_does_is_seen() {
    let elastic = &laws()[0];
    for component in 0..3 {
        let kicks = (0..4)
            .flat_map(|corner| [Kick::Move(corner), Kick::Turn(corner)])
            .chain([Kick::TurnAll]);
        for (kick, kind) in
            kicks.flat_map(|kick| (0..FORMULATIONS.len()).map(move |kind| (kick, kind)))
        {
            let meshes = [0; 2].map(|_| fresh_shells(Precision::Double, elastic, kind));
            compare_runs(meshes, (kick, component), &format!("shell {kind}"));
        }
        for corner in 0..8 {
            let meshes = [0; 2].map(|_| fresh_solids(Precision::Double, elastic, FORMS[0]));
            compare_runs(meshes, (Kick::Move(corner), component), "solid");
        }
    }
}
