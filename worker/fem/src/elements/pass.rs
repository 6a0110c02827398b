//! Pass over the elements of a block: groups of elements, the call of the kernel for each, and the
//! minima over all.

use super::quad::magnitude;
use super::section::Section;
use super::solid::SolidMaterial;
use crate::columns::{HistoryColumnsMut, HistoryStorage};
use crate::materials::PointLanes;
use crate::nodes::NodeView;
use crumple_math::lanes::{LANES, LANES32, Lane, Real};
use crumple_math::row::xyz;
use std::ops::Range;

/// Element nodal forces. The slot is `(group * lanes + lane) * slots + corner`, with
/// [`Shape::slots`](crumple_proto::mesh::Shape::slots) slots per element; the components are x, y,
/// z, padding.
pub struct ElementNodalForces<'a> {
    /// Internal force on the corner, to be subtracted from the external force of the node [force].
    pub force: &'a mut [[f64; 4]],
    /// Internal moment on the corner [force length]. Solids have none and do not write it.
    pub moment: &'a mut [[f64; 4]],
}

/// Minima over the elements of a pass.
#[derive(Clone, Copy, Debug)]
pub struct PassTotals {
    /// Smallest stable step of the elements passed, before the safety factor [time].
    pub stable_dt: f64,
    /// First element of the pass that is inverted, is not finite, or has a strain increment of more
    /// than one half in one step.
    pub trouble: Option<usize>,
}

impl PassTotals {
    /// Totals of no elements.
    pub const NONE: Self = Self { stable_dt: f64::INFINITY, trouble: None };

    /// Adds the totals of another pass.
    pub fn add(&mut self, o: &Self) {
        self.stable_dt = self.stable_dt.min(o.stable_dt);
        self.trouble = self.trouble.or(o.trouble);
    }
}

/// Returns the places of an element's internal energy, and of its hourglass and drilling energy, in
/// [`ElementPass::energies`] for groups of this number of lanes.
pub fn energy_places(index: usize, lanes: usize) -> [usize; 2] {
    let first = index / lanes * 2 * lanes + index % lanes;
    [first, first + lanes]
}

/// Local nodes of a group of W elements with C slots, per corner and lane. Padding lanes repeat the
/// last real element.
pub type GroupNodes<const C: usize, const W: usize = LANES> = [[u32; W]; C];

/// Corner forces or moments of a group of W elements with C slots: rows x, y, z, padding by element
/// and slot.
pub(super) type GroupCorners<const C: usize, const W: usize> = [[[f64; 4]; C]; W];

/// A group of shells: its number and nodes, its history, the mark of unstrained ones, and its
/// forces and moments.
type ShellGroup<'a, L, const W: usize> = (
    (((usize, &'a GroupNodes<4, W>), &'a mut [L]), &'a mut bool),
    (&'a mut GroupCorners<4, W>, &'a mut GroupCorners<4, W>),
);

/// Groups of a block that a pass computes, with their data. After [`ElementPass::split_at`] the
/// block is a piece of the block: groups and elements count from the first of the piece.
pub struct ElementPass<'a, H = HistoryColumnsMut<'a>> {
    /// Groups to compute.
    pub range: Range<usize>,
    /// Number of real elements of the block. The rest of the last group is padding.
    pub count: usize,
    /// Local nodes of the whole block: one row per slot in each group.
    pub groups: &'a [u32],
    /// History of the whole block.
    pub history: H,
    /// Marks of the groups of the whole block whose elements are unstrained, see
    /// [`Element::is_unstrained`](super::Element::is_unstrained). A pass clears a mark if the nodes
    /// no longer have one velocity.
    pub unstrained: &'a mut [bool],
    /// Nodal columns.
    pub nodes: NodeView<'a>,
    /// Last step [time].
    pub dt: f64,
    /// Stable step below which solids of a part that deletes inverted ones are deleted [time].
    pub least_dt: f64,
    /// Ratio of the stable step of each element and padding of the block to that of its kernel,
    /// which knows neither scaled nor shared masses; empty if all are 1.
    pub step_factors: &'a [f64],
    /// Element nodal forces of the whole block.
    pub out: ElementNodalForces<'a>,
    /// Energies of the whole block so far, to which the pass adds: for each group W internal
    /// energies, then W hourglass and drilling energies. Each element has its own sum in ascending
    /// time, which does not depend on the other elements of its worker [energy].
    pub energies: &'a mut [f64],
}

impl ElementPass<'_> {
    /// Cuts a pass over all groups of a block into two: over the first `groups` groups, and over
    /// the rest. Groups and elements of each count from 0.
    pub fn split_at(self, groups: usize) -> [Self; 2] {
        debug_assert_eq!(self.range, 0..self.unstrained.len(), "a pass over all groups");
        let (all, lanes) = (self.unstrained.len().max(1), self.history.lanes());
        let of_group = |length: usize| groups * (length / all);
        let elements = (groups * lanes).min(self.count);
        let (first, rest) = self.groups.split_at(of_group(self.groups.len()));
        let factors = self.step_factors.split_at(of_group(self.step_factors.len()));
        let history = self.history.split_at(groups, all);
        let unstrained = self.unstrained.split_at_mut(groups);
        let ElementNodalForces { force, moment } = self.out;
        let force = force.split_at_mut(groups * (force.len() / all));
        let moment = moment.split_at_mut(groups * (moment.len() / all));
        let energies = self.energies.split_at_mut(groups * (self.energies.len() / all));
        [
            ElementPass {
                range: 0..groups,
                count: elements,
                groups: first,
                history: history.0,
                unstrained: unstrained.0,
                nodes: self.nodes,
                dt: self.dt,
                least_dt: self.least_dt,
                step_factors: factors.0,
                out: ElementNodalForces { force: force.0, moment: moment.0 },
                energies: energies.0,
            },
            ElementPass {
                range: 0..all - groups,
                count: self.count - elements,
                groups: rest,
                history: history.1,
                unstrained: unstrained.1,
                nodes: self.nodes,
                dt: self.dt,
                least_dt: self.least_dt,
                step_factors: factors.1,
                out: ElementNodalForces { force: force.1, moment: moment.1 },
                energies: energies.1,
            },
        ]
    }
}

/// One element of a pass, see [`ElementPass::one_by_one`].
pub(super) struct SingleElement<'a, const C: usize> {
    /// Its index in the block. Its slots are C times this index and those that follow.
    pub index: usize,
    /// Its local nodes.
    pub nodes: [usize; C],
    /// Its history columns, which are stored afterwards.
    pub state: &'a mut [f64],
    /// Its internal energy so far [energy].
    pub internal: &'a mut f64,
}

impl ElementPass<'_> {
    /// Computes elements with C nodes and this number of history columns one by one, because a
    /// scene has few of them. `compute` sets the element nodal forces of an element, and returns
    /// its stable step [time] and true if the element is valid.
    pub(super) fn one_by_one<const C: usize>(
        self,
        columns: usize,
        mut compute: impl FnMut(SingleElement<'_, C>, &mut ElementNodalForces<'_>) -> (f64, bool),
    ) -> PassTotals {
        let ElementPass { range, count, groups, history, mut out, energies, .. } = self.double();
        let groups = groups.as_chunks::<LANES>().0;
        let (mut totals, mut state) = (PassTotals::NONE, vec![0.0; columns]);
        for index in range.start * LANES..(range.end * LANES).min(count) {
            let (group, lane) = (index / LANES, index % LANES);
            let of_group = &mut history[group * columns..(group + 1) * columns];
            for (s, column) in state.iter_mut().zip(of_group.iter()) {
                *s = column.as_array()[lane];
            }
            let element = SingleElement {
                index,
                nodes: std::array::from_fn(|c| groups[group * C + c][lane] as usize),
                state: &mut state,
                internal: &mut energies[energy_places(index, LANES)[0]],
            };
            let (stable_dt, is_valid) = compute(element, &mut out);
            totals.add(&PassTotals { stable_dt, trouble: (!is_valid).then_some(index) });
            for (s, column) in state.iter().zip(of_group) {
                column.as_mut_array()[lane] = *s;
            }
        }
        totals
    }
}

/// Results of a kernel for a group, in addition to the forces.
pub(super) struct Totals<R: Real> {
    /// Stable step [time].
    pub stable_dt: R,
    /// Increases of internal energy, and of hourglass and drilling energy [energy].
    pub internal: R,
    pub hourglass: R,
    /// Lanes whose element is finite, is not inverted, and has strain increments within the limit.
    pub sound: R::Mask,
}

impl<R: Real> Totals<R> {
    /// Returns the totals of elements without forces.
    #[inline(always)]
    pub(super) fn inactive(stable_dt: R, sound: R::Mask) -> Self {
        Self { stable_dt, internal: R::zero(), hourglass: R::zero(), sound }
    }

    /// Removes failed elements from the totals: they add no energy, do not limit the step and are
    /// never reported as trouble.
    #[inline(always)]
    pub(super) fn zero_failed(&mut self, failed: R::Mask) {
        self.internal = R::select(failed, R::zero(), self.internal);
        self.hourglass = R::select(failed, R::zero(), self.hourglass);
        self.stable_dt = R::select(failed, R::splat(f64::INFINITY), self.stable_dt);
        self.sound = R::either(self.sound, failed);
    }
}

/// Returns true if a group is unstrained and remains so in this step; otherwise clears its mark.
#[inline(always)]
fn stays_unstrained<const C: usize, const W: usize>(
    unstrained: &mut bool,
    group: &GroupNodes<C, W>,
    nodes: &NodeView<'_>,
    turning: bool,
) -> bool {
    if *unstrained {
        *unstrained = has_uniform_velocity(group, nodes.v) && !(turning && turn(group, nodes.w));
    }
    *unstrained
}

/// Returns true if the nodes of each element of a group have the same velocity. It is not inlined,
/// as strained groups do not need it and the kernel in the same loop needs the registers.
#[inline(never)]
fn has_uniform_velocity<const C: usize, const W: usize>(
    group: &GroupNodes<C, W>,
    v: &[[f64; 4]],
) -> bool {
    group[1..].iter().all(|nodes| {
        nodes.iter().zip(&group[0]).all(|(&i, &first)| v[i as usize] == v[first as usize])
    })
}

/// Returns true if a node of a group has a rotational velocity.
#[inline(never)]
fn turn<const C: usize, const W: usize>(group: &GroupNodes<C, W>, w: &[[f64; 4]]) -> bool {
    group.iter().flatten().any(|&i| w[i as usize] != [0.0; 4])
}

/// Kernel for groups of shells, for any type of lanes.
pub(super) trait ShellGroups {
    /// Computes the corner forces and moments of a group from its connectivity and history.
    fn group<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<4, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
        dt: f64,
        out: [&mut GroupCorners<4, W>; 2],
    ) -> Totals<L>;

    /// Returns the totals for unstrained elements whose nodes have one velocity. Their forces are
    /// zero.
    fn forceless<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<4, W>,
        nodes: &NodeView<'_>,
        history: &[L],
    ) -> Totals<L>;

    /// Returns the section through the thickness.
    fn section(&self) -> &Section;
}

/// Kernel for groups of solids with C nodes, for any type of lanes.
pub(super) trait SolidGroups<const C: usize> {
    /// Computes the corner forces of a group from its connectivity and history.
    fn group<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<C, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
        dt: f64,
        force: &mut GroupCorners<C, W>,
    ) -> Totals<L>;

    /// Returns the totals for unstrained elements whose nodes have one velocity. Their forces are
    /// zero.
    fn forceless<L: PointLanes<W>, const W: usize>(
        &self,
        group: &GroupNodes<C, W>,
        nodes: &NodeView<'_>,
        history: &mut [L],
    ) -> Totals<L>;

    /// Returns the material, and the number of points whose columns begin the history; `None` if
    /// the elements have a section.
    fn material(&self) -> Option<(&SolidMaterial, usize)>;

    /// Returns the section of elements with one; their kernel deletes inverted ones itself.
    fn section(&self) -> Option<&Section> {
        None
    }
}

impl<'a, H> ElementPass<'a, H> {
    /// Returns the history of the pass, and the pass with another one.
    #[inline(always)]
    fn exchange<T>(self, other: T) -> (H, ElementPass<'a, T>) {
        let Self {
            range,
            count,
            groups,
            history,
            unstrained,
            nodes,
            dt,
            least_dt,
            step_factors,
            out,
            energies,
        } = self;
        let pass = ElementPass {
            range,
            count,
            groups,
            history: other,
            unstrained,
            nodes,
            dt,
            least_dt,
            step_factors,
            out,
            energies,
        };
        (history, pass)
    }
}

impl<'a> ElementPass<'a> {
    /// Calls `kernel` for each group of shells with `columns` history columns per element, and sums
    /// up the totals.
    #[inline(always)]
    pub(super) fn shells(self, columns: usize, kernel: &impl ShellGroups) -> PassTotals {
        let (history, pass) = self.exchange(());
        match history {
            HistoryStorage::Double(history) => {
                pass.exchange(history).1.shells_in::<LANES>(columns, kernel)
            }
            HistoryStorage::Single(history) => {
                pass.exchange(history).1.shells_in::<LANES32>(columns, kernel)
            }
        }
    }

    /// Calls `kernel` for each group of solids with C nodes, as [`Self::shells`] does for shells.
    #[inline(always)]
    pub(super) fn solids<const C: usize>(
        self,
        columns: usize,
        kernel: &impl SolidGroups<C>,
    ) -> PassTotals {
        let (history, pass) = self.exchange(());
        match history {
            HistoryStorage::Double(history) => {
                pass.exchange(history).1.solids_in::<C, LANES>(columns, kernel)
            }
            HistoryStorage::Single(history) => {
                pass.exchange(history).1.solids_in::<C, LANES32>(columns, kernel)
            }
        }
    }

    /// Calls `kernel` as [`Self::solids`] does, for elements that have double precision only.
    #[inline(always)]
    pub(super) fn double_solids<const C: usize>(
        self,
        columns: usize,
        kernel: &impl SolidGroups<C>,
    ) -> PassTotals {
        self.double().solids_in::<C, LANES>(columns, kernel)
    }

    /// Returns the pass with its history in double precision, for elements that have no other
    /// precision.
    ///
    /// # Panics
    /// If the block stores its columns in single precision.
    pub(super) fn double(self) -> ElementPass<'a, &'a mut [Lane]> {
        let (history, pass) = self.exchange(());
        let HistoryStorage::Double(history) = history else {
            panic!("this element exists in double precision only")
        };
        pass.exchange(history).1
    }
}

impl<L> ElementPass<'_, &mut [L]> {
    #[inline(always)]
    fn shells_in<const W: usize>(self, columns: usize, kernel: &impl ShellGroups) -> PassTotals
    where
        L: PointLanes<W>,
    {
        let Self {
            range,
            count,
            groups,
            history,
            unstrained,
            nodes,
            dt,
            step_factors,
            out,
            energies,
            ..
        } = self;
        let corners = range.start * W..range.end * W;
        let force = out.force.as_chunks_mut::<4>().0[corners.clone()].as_chunks_mut::<W>().0;
        let moment = out.moment.as_chunks_mut::<4>().0[corners].as_chunks_mut::<W>().0;
        let states = history[range.start * columns..range.end * columns].chunks_exact_mut(columns);
        let groups = &groups.as_chunks::<W>().0.as_chunks::<4>().0[range.clone()];
        let deletion_step = kernel.section().deletion_step;
        let each = range
            .clone()
            .zip(groups)
            .zip(states)
            .zip(&mut unstrained[range.clone()])
            .zip(force.iter_mut().zip(moment));
        let respond =
            |((((index, group), state), unstrained), (force, moment)): ShellGroup<'_, L, W>| {
                if stays_unstrained(unstrained, group, &nodes, true) {
                    (*force, *moment) = ([[[0.0; 4]; 4]; W], [[[0.0; 4]; 4]; W]);
                    return kernel.forceless(group, &nodes, state);
                }
                let mut totals =
                    kernel.group(group, &nodes, state, dt, [&mut *force, &mut *moment]);
                if deletion_step > 0.0 {
                    let least: L = least_steps(0.0, deletion_step, step_factors, index);
                    if L::any(totals.stable_dt.lt(least)) {
                        let of = (kernel.section(), || magnitude(group, &nodes));
                        delete_short(of, least, state, &mut [force, moment], &mut totals);
                    }
                }
                totals
            };
        total(range, count, energies, each.map(respond))
    }

    #[inline(always)]
    fn solids_in<const C: usize, const W: usize>(
        self,
        columns: usize,
        kernel: &impl SolidGroups<C>,
    ) -> PassTotals
    where
        L: PointLanes<W>,
    {
        let Self {
            range,
            count,
            groups,
            history,
            unstrained,
            nodes,
            dt,
            least_dt,
            step_factors,
            out,
            energies,
        } = self;
        let force =
            out.force.as_chunks_mut::<C>().0[range.start * W..range.end * W].as_chunks_mut::<W>().0;
        let states = history[range.start * columns..range.end * columns].chunks_exact_mut(columns);
        let groups = &groups.as_chunks::<W>().0.as_chunks::<C>().0[range.clone()];
        let numbered = range.clone().zip(groups);
        let each = numbered.zip(states).zip(&mut unstrained[range.clone()]).zip(force);
        let respond = |((((index, group), state), unstrained), force): (
            (((usize, &_), _), &mut bool),
            &mut _,
        )| {
            if stays_unstrained(unstrained, group, &nodes, false) {
                *force = [[[0.0; 4]; C]; W];
                return kernel.forceless(group, &nodes, state);
            }
            let deleting = kernel.material().filter(|(material, _)| material.deletes);
            // Laws may mark a deleted element as one that has failed by itself.
            let gone =
                deleting.map(|(material, points)| (material, points, material.deleted(state)));
            let mut totals: Totals<L> = kernel.group(group, &nodes, state, dt, force);
            if let Some((material, points, gone)) = gone {
                let least = least_steps(least_dt, material.deletion_step, step_factors, index);
                let long = totals.stable_dt.ge(least);
                let marks = L::select(L::both(totals.sound, long), L::zero(), L::splat(1.0));
                if L::any(gone) || L::any(marks.gt(L::zero())) {
                    let of = (material, points);
                    delete_lost(of, (gone, marks), (group, &nodes), state, force, &mut totals);
                }
            }
            if let Some(section) = kernel.section().filter(|section| section.deletion_step > 0.0) {
                let least: L = least_steps(0.0, section.deletion_step, step_factors, index);
                if L::any(totals.stable_dt.lt(least)) {
                    let of = (section, || moves_of(group, &nodes));
                    delete_short(of, least, state, &mut [force], &mut totals);
                }
            }
            totals
        };
        total(range, count, energies, each.map(respond))
    }
}

/// Returns the stable steps below which the elements of a group are deleted [time]: the largest of
/// `least_dt`, which is that of kernels, and of `own`, which is that of the elements with their
/// masses.
#[inline(always)]
fn least_steps<L: PointLanes<W>, const W: usize>(
    least_dt: f64,
    own: f64,
    factors: &[f64],
    group: usize,
) -> L {
    match factors.as_chunks::<W>().0.get(group) {
        Some(factors) if own > 0.0 => L::from_array(factors.map(|f| least_dt.max(own / f))),
        _ => L::splat(least_dt.max(own)),
    }
}

/// Deletes elements of a group whose stable step is below `least` [time] or NaN. One whose
/// coordinates or velocities are not finite stays; `moves` returns the sum of their magnitudes.
/// `corners` are the forces, and the moments if there are any.
#[cold]
#[inline(never)]
fn delete_short<L: PointLanes<W>, const C: usize, const W: usize>(
    (section, moves): (&Section, impl FnOnce() -> L),
    least: L,
    history: &mut [L],
    corners: &mut [&mut GroupCorners<C, W>],
    totals: &mut Totals<L>,
) {
    let long = totals.stable_dt.ge(least);
    let gone = section.delete_inverted(history, long, long, moves);
    totals.zero_failed(gone);
    let gone = L::select(gone, L::splat(1.0), L::zero()).to_array();
    for lane in (0..W).filter(|&lane| gone[lane] > 0.0) {
        corners.iter_mut().for_each(|rows| rows[lane] = [[0.0; 4]; C]);
    }
}

/// Returns the sum of the magnitudes of the coordinates and velocities of each solid of a group.
fn moves_of<L: PointLanes<W>, const C: usize, const W: usize>(
    group: &GroupNodes<C, W>,
    nodes: &NodeView<'_>,
) -> L {
    L::from_array(std::array::from_fn(|lane| {
        let corners = group.iter().map(|corner| corner[lane] as usize);
        let rows = corners.flat_map(|n| [nodes.x[n], nodes.v[n]]);
        rows.flat_map(|row| xyz(&row)).map(f64::abs).sum()
    }))
}

/// Deletes the solids of a group that are marked, since they are not valid or their stable step is
/// too short, and again those that have gone before: they keep no state, since their shape gives no
/// valid one. If the coordinates or velocities of an element are not finite, it is not deleted, and
/// the run must stop.
#[cold]
#[inline(never)]
fn delete_lost<L: PointLanes<W>, const C: usize, const W: usize>(
    (material, points): (&SolidMaterial, usize),
    (gone, marks): (L::Mask, L),
    (group, nodes): (&GroupNodes<C, W>, &NodeView<'_>),
    history: &mut [L],
    force: &mut GroupCorners<C, W>,
    totals: &mut Totals<L>,
) {
    let marks = marks.to_array();
    let finite = |lane: usize| {
        let corners = group.iter().map(|corner| corner[lane] as usize);
        let rows = corners.flat_map(|n| [nodes.x[n], nodes.v[n]]);
        rows.flat_map(|row| xyz(&row)).all(f64::is_finite)
    };
    let is_lost = |lane: usize| marks[lane] != 0.0 && finite(lane);
    let lost = L::from_array(std::array::from_fn(|lane| f64::from(u8::from(is_lost(lane)))));
    let lost = lost.gt(L::splat(0.5));
    // The shape of an element that has gone may give no finite stress.
    material.delete(points, history, L::either(lost, gone));
    totals.zero_failed(lost);
    (0..W).filter(|&lane| is_lost(lane)).for_each(|lane| force[lane] = [[0.0; 4]; C]);
}

/// Adds the energies of the groups in `range` to those of their elements, and returns the minima.
#[inline(always)]
fn total<L: PointLanes<W>, const W: usize>(
    range: Range<usize>,
    count: usize,
    energies: &mut [f64],
    groups: impl Iterator<Item = Totals<L>>,
) -> PassTotals {
    let mut minima = GroupMinima::<L, W>::new();
    let sums = &mut energies.as_chunks_mut::<W>().0.as_chunks_mut::<2>().0[range.clone()];
    range.zip(groups).zip(sums).for_each(|((index, totals), [internal, hourglass])| {
        let more = (totals.internal.to_array(), totals.hourglass.to_array());
        for lane in 0..W {
            internal[lane] += more.0[lane];
            hourglass[lane] += more.1[lane];
        }
        minima.include(index, count, &totals);
    });
    minima.finish()
}

/// Minima over groups, lane by lane.
struct GroupMinima<L, const W: usize> {
    stable_dt: L,
    trouble: Option<usize>,
}

/// Factor on a stable step in single precision, so that round-off does not make a step longer. The
/// error is largest where the squared frequency has the root of a difference of equal numbers, as
/// for squares at nu = 0: `sqrt(3 * 2^-24)` of the squared frequency, and half as much of the step.
const SHORT_STEP: f64 = 1.0 - 1.0 / 4096.0;

impl<L: PointLanes<W>, const W: usize> GroupMinima<L, W> {
    #[inline(always)]
    fn new() -> Self {
        Self { stable_dt: L::splat(f64::INFINITY), trouble: None }
    }

    #[inline(always)]
    fn include(&mut self, index: usize, count: usize, totals: &Totals<L>) {
        // Padding repeats a real element, so its stable step and its soundness are valid.
        self.stable_dt = Real::min(totals.stable_dt, self.stable_dt);
        let sound = L::select(totals.sound, L::zero(), L::splat(1.0));
        if L::any(sound.gt(L::zero())) && self.trouble.is_none() {
            let lane = sound.to_array().iter().position(|&l| l > 0.0).unwrap_or(0);
            self.trouble = Some((index * W + lane).min(count - 1));
        }
    }

    fn finish(self) -> PassTotals {
        let stable_dt = self.stable_dt.to_array().into_iter().fold(f64::INFINITY, f64::min);
        PassTotals {
            stable_dt: if L::SHORT { SHORT_STEP * stable_dt } else { stable_dt },
            trouble: self.trouble,
        }
    }
}
