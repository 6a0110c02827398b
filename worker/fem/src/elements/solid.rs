//! Code that all solids with one integration point per law share: law and stress in the rotated
//! frame, bulk viscosity, energy, stable step of a mean gradient.
//!
//! The steps are those of [`hexahedron`](super::hexahedron).

use super::initial::{StateAtStart, TakenAtStart};
use super::parameters::{self, DELETE, DELETION_STEP};
use super::pass::{GroupCorners, GroupNodes};
use super::{ElementFields, damage_column, law_column};
use crate::columns::ElementState;
use crate::materials::tensor::rotated;
use crate::materials::{
    self, AXES_COLUMN, Elastic, HEAT_COLUMN, MaterialAxes, PointLanes, PointReal, SIZE_COLUMN,
    STRAIN_COLUMN, STRETCH_COLUMN, Solid, SolidPoint, VOLUME_COLUMN,
};
use crate::parameter::{DefaultValue, Form, ParameterRow, Range, Values};
use crumple_math::lanes::{Lane, Real, cross, dot};
use crumple_proto::initial::InitialPoint;
use crumple_proto::job::Part;
use crumple_proto::problem::Problem;

/// Keys of all solids.
pub const SOLID_KEYS: &[ParameterRow] = &[
    ParameterRow {
        key: "bulk_viscosity",
        form: Form::Numbers(2),
        otherwise: DefaultValue::Numbers(&[0.06, 1.5]),
        range: Some(Range {
            wanted: "[linear, quadratic], each from 0 to 10",
            fits: |b| (0.0..=10.0).contains(&b),
        }),
        meaning: "Bulk viscosity in compression: linear coefficient, as a fraction of \
                  critical damping, and quadratic coefficient (`cases/studies/README.md`, \
                  viscosity).",
    },
    ParameterRow {
        key: "inverted",
        form: Form::Word(&["stop", DELETE]),
        otherwise: DefaultValue::Word("stop"),
        range: None,
        meaning: "Treatment of an inverted solid, which has no volume or is strained by more than \
                  a half in one step, and of one whose stable step is below `time.dt_min_ratio` \
                  times the first step of the run. `stop` ends the run and names it. `delete` lets \
                  it fail as at a failure strain, as with shells. Elements with scaled masses, or \
                  that share the masses of nodes, are not deleted for their step.",
    },
    DELETION_STEP,
    ParameterRow {
        key: INTERIOR,
        form: Form::Numbers(2),
        otherwise: DefaultValue::Absent,
        range: Some(Range { wanted: "above 0", fits: |x| x > 0.0 && x.is_finite() }),
        meaning: "Contact inside of solids that are crushed: `[fraction, factor]`. Below this \
                  fraction of its first volume a pressure acts in an element, which grows without \
                  bound as the volume vanishes; the factor is on its modulus, that of the law in \
                  confined compression. Usual for foams: `[0.1, 1.0]`. It shortens the step.",
    },
];
const INTERIOR: &str = "interior_contact";

/// Returns a law with contact inside of its elements, if their part has it.
///
/// # Errors
/// The fraction is not below 1.
pub fn with_interior(
    part: &Part,
    values: &Values<'_>,
    law: Box<dyn Solid>,
) -> Result<Box<dyn Solid>, Vec<Problem>> {
    if !values.is_given(INTERIOR) {
        return Ok(law);
    }
    let given: [f64; 2] = values.numbers(INTERIOR);
    if given[0] >= 1.0 {
        let of = part.label();
        let message = format!("part {of}: {INTERIOR} begins at {} of the volume", given[0]);
        let help = "give a fraction below 1, such as [0.1, 1.0]";
        return Err(vec![Problem::error(INTERIOR, message, help)]);
    }
    Ok(materials::with_interior_contact(law, given))
}

/// Key of solids that average their volume strain at nodes; see
/// [`tetrahedron`](super::tetrahedron).
pub const PRESSURE_KEY: &[ParameterRow] = &[ParameterRow {
    key: "pressure",
    form: Form::Word(&[NODAL, "element"]),
    otherwise: DefaultValue::Word(NODAL),
    range: None,
    meaning: "Tetrahedra and wedges: volume strain averaged at nodes (`nodal`; in wedges a share \
              of it, if nu is above 0.3), or that of each element (`element`), which locks as nu \
              approaches 1/2 and in plastic flow. Foams take that of the element, and so do \
              wedges with nu up to 0.3.",
}];
const NODAL: &str = "nodal";

/// Returns true if the elements of a part average their volume strain at nodes.
///
/// # Errors
/// It is asked for, and the law does not allow it.
pub fn averages_volume(
    part: &Part,
    values: &Values<'_>,
    law: &dyn Solid,
) -> Result<bool, Vec<Problem>> {
    let nodal = values.word("pressure") == NODAL;
    if nodal && values.is_given("pressure") && !law.averages_volume() {
        let message = format!(
            "part {}: pressure = \"nodal\" does not keep the energy with the law of its material",
            part.label()
        );
        let help = "use pressure = \"element\", the default with foams";
        return Err(vec![Problem::error("pressure", message, help)]);
    }
    Ok(nodal && law.averages_volume())
}

/// Mark of a solid that was deleted, in the column of failure.
const DELETED: f64 = 2.0;
/// The law marks failure by 1.
const DELETED_FROM: f64 = 1.5;

/// Largest strain increment of a valid step.
pub const STRAIN_LIMIT: f64 = 0.5;
/// Number of stress components, at the start of the law's state.
pub const STRESS: usize = 6;

/// A law with the keys of all solids.
pub struct SolidMaterial {
    pub law: Box<dyn Solid>,
    pub elastic: Elastic,
    /// b1 and b2.
    pub bulk_viscosity: [f64; 2],
    /// Number of columns of stress and of the law.
    pub state: usize,
    /// Column of the law with its effective plastic strain, if it has any.
    plastic_strain: Option<usize>,
    damage: Option<usize>,
    /// Column of the law that marks failure, if it can fail.
    pub failed: Option<usize>,
    /// See [`Solid::tensors`].
    tensors: usize,
    /// First column of the law with the axes of the material, if it has any; see [`AXES_COLUMN`].
    axes: Option<usize>,
    /// First column of the law with its strain, if it keeps it; see [`STRAIN_COLUMN`].
    strain: Option<usize>,
    /// Column of the law with the size of the element, if it has one; see [`SIZE_COLUMN`].
    size: Option<usize>,
    /// Column of the law with its stiffening, if it stiffens; see [`Solid::history`].
    stiffening: Option<usize>,
    /// True if elements that are inverted, or have too short a step, fail.
    pub deletes: bool,
    /// Stable step below which elements are deleted, 0 for none [time].
    pub deletion_step: f64,
    /// Column of the law with its internal energy, if the pressure depends on it; see
    /// [`HEAT_COLUMN`].
    heat: Option<usize>,
}

/// Result of the update of the stress.
pub struct StressStep<R> {
    /// Stress at the start and at the end, in the axes of the middle of the step
    /// [force/length^2].
    pub before: [R; STRESS],
    pub after: [R; STRESS],
    /// Stress in global axes [force/length^2].
    pub stress: [R; STRESS],
    /// See [`Solid::update`].
    pub left: R,
}

impl SolidMaterial {
    /// Creates the law of a part with these values.
    pub fn new(values: &Values<'_>, law: Box<dyn Solid>) -> Self {
        let deletes = parameters::deletes_inverted(values);
        let law = if deletes { materials::that_can_fail(law) } else { law };
        let elastic = law.elastic();
        let (history, poisson) = (law.history(), elastic.poisson);
        debug_assert!(poisson < 0.5, "laws of solids require a finite bulk modulus");
        Self {
            elastic,
            bulk_viscosity: values.numbers("bulk_viscosity"),
            state: STRESS + history.len(),
            plastic_strain: law_column(history, "plastic_strain", STRESS),
            damage: damage_column(history, STRESS),
            failed: law_column(history, "failed", STRESS),
            tensors: law.tensors(),
            axes: law_column(history, AXES_COLUMN, STRESS),
            strain: law_column(history, STRAIN_COLUMN, STRESS),
            size: law_column(history, SIZE_COLUMN, STRESS),
            stiffening: law_column(history, "stiffening", STRESS),
            heat: law_column(history, HEAT_COLUMN, STRESS),
            deletes,
            deletion_step: values.number(DELETION_STEP.key),
            law,
        }
    }

    /// Updates stress and history, which begin `state`, by a strain increment in the rotated frame
    /// (see [`increment`]).
    #[inline(always)]
    pub fn update<R: PointReal>(
        &self,
        state: &mut [R],
        eps: &[R; STRESS],
        turn: &[[R; 3]; 3],
        dt: f64,
    ) -> StressStep<R> {
        let before = rotated(turn, state);
        state[..STRESS].copy_from_slice(&before);
        self.turn_history(state, turn);
        let left = R::update_solid(&*self.law, SolidPoint { state, strain: eps }, dt);
        let after: [R; STRESS] = std::array::from_fn(|c| state[c]);
        let stress = rotated(turn, state);
        state[..STRESS].copy_from_slice(&stress);
        self.turn_history(state, turn);
        StressStep { before, after, stress, left }
    }

    /// Deletes elements with so many points: no column of the law keeps a value but the mark of
    /// failure. Other columns keep finite ones.
    pub fn delete<R: Real>(&self, points: usize, history: &mut [R], lost: R::Mask) {
        let (zero, mark) = (R::zero(), R::splat(DELETED));
        let (of_law, others) = history.split_at_mut(points * self.state);
        for point in of_law.chunks_exact_mut(self.state) {
            for (column, value) in point.iter_mut().enumerate() {
                let kept = if Some(column) == self.failed { mark } else { zero };
                *value = R::select(lost, kept, *value);
            }
        }
        for value in others {
            let kept = R::select(value.abs().le(R::splat(R::LARGEST)), *value, zero);
            *value = R::select(lost, kept, *value);
        }
    }

    /// Returns true if an element was deleted.
    pub fn is_deleted(&self, history: ElementState<'_>) -> bool {
        self.failed.is_some_and(|column| history.at(column) > DELETED_FROM)
    }

    /// Returns the lanes with elements that were deleted.
    pub fn deleted<R: Real>(&self, history: &[R]) -> R::Mask {
        let mark = self.failed.map_or(R::zero(), |column| history[column]);
        mark.gt(R::splat(DELETED_FROM))
    }

    /// Rotates the tensors and the axes of the history.
    #[inline(always)]
    fn turn_history<R: PointReal>(&self, state: &mut [R], turn: &[[R; 3]; 3]) {
        if let Some(at) = self.axes {
            let (axes, _) = state[at..].as_chunks_mut::<3>();
            for (k, axis) in axes.iter_mut().take(2).enumerate() {
                // `R (n + s) - n` with the unit vector n: without a rotation s keeps its bits.
                let old = *axis;
                for i in 0..3 {
                    let unit = R::splat(if i == k { 1.0 } else { 0.0 });
                    axis[i] = dot(turn[i], old) + (turn[i][k] - unit);
                }
            }
        }
        let (tensors, _) = state.as_chunks_mut::<STRESS>();
        for tensor in tensors.iter_mut().skip(1).take(self.tensors) {
            *tensor = rotated(turn, tensor);
        }
        if let Some(at) = self.strain {
            let turned = rotated(turn, &state[at..at + STRESS]);
            state[at..at + STRESS].copy_from_slice(&turned);
        }
    }

    /// Stores the axes of the material and the size in the history of a new element with so many
    /// points, which begins with them. `x` are the coordinates of its slots, `volume` its volume
    /// [length^3].
    pub fn measure(&self, history: &mut [f64], x: &[[f64; 3]], points: usize, volume: f64) {
        if let Some(size) = self.size {
            (0..points).for_each(|p| history[p * self.state + size] = volume.cbrt());
        }
        self.orient(history, x, points);
    }

    /// Returns what the law takes of a state at the start.
    pub fn taken_at_start(&self) -> TakenAtStart {
        let stress = self.law.adds_stress();
        TakenAtStart { stress, plastic_strain: stress && self.plastic_strain.is_some() }
    }

    /// Gives all of so many points of a new element the mean stress and plastic strain of the
    /// given ones.
    pub fn set_initial(&self, history: &mut [f64], points: usize, given: &[InitialPoint]) {
        let TakenAtStart { stress, plastic_strain } = self.taken_at_start();
        if !stress {
            return;
        }
        let state = StateAtStart::of_solid(given);
        for point in history.chunks_exact_mut(self.state).take(points) {
            point[..STRESS].copy_from_slice(&state.stress);
            if let Some(column) = self.plastic_strain.filter(|_| plastic_strain) {
                point[column] = state.plastic_strain;
            }
        }
    }

    /// Stores the axes of the material; see [`Self::measure`].
    fn orient(&self, history: &mut [f64], x: &[[f64; 3]], points: usize) {
        let (Some(axes), Some(at)) = (self.law.axes(), self.axes) else { return };
        let side = |to: usize| each(|i| x[to][i] - x[0][i]);
        let [a, d] = match axes {
            MaterialAxes::Nodes => [side(1), side(3)],
            MaterialAxes::Vectors(vectors) => vectors,
        };
        let b = cross(cross(a, d), a);
        let [a, b] = [a, b].map(|v| v.map(|c| c / dot(v, v).sqrt()));
        for p in 0..points {
            let first = p * self.state + at;
            history[first..first + 6].copy_from_slice(&[
                a[0] - 1.0,
                a[1],
                a[2],
                b[0],
                b[1] - 1.0,
                b[2],
            ]);
        }
    }

    /// Returns true if all columns are zero, except the axes and the size in each of so many
    /// points and the volume at the start, which follows the points.
    pub fn is_unstrained(&self, history: ElementState<'_>, points: usize) -> bool {
        let volume = points * self.state;
        let is_of_start = |column: usize| {
            let within = column % self.state;
            let is_axis = self.axes.is_some_and(|at| (at..at + 6).contains(&within));
            column < volume && (is_axis || self.size == Some(within))
        };
        history.is_zero_where(|column| column != volume && !is_of_start(column))
    }

    /// Returns the slowness of waves [time/length] with the stiffening of the law.
    #[inline(always)]
    pub fn stiffened<R: Real>(&self, state: &[R], slowness: R) -> R {
        match self.stiffening {
            None => slowness,
            Some(column) => slowness / (R::splat(1.0) + state[column]).sqrt(),
        }
    }

    /// Returns the factor of the stiffening on the stable step, at a point whose columns begin at
    /// `first`.
    pub fn step_factor(&self, history: ElementState<'_>, first: usize) -> f64 {
        self.stiffening.map_or(1.0, |column| (1.0 + history.at(first + column)).sqrt().recip())
    }

    /// Returns the bulk viscosity at this rate of -ln V [force/length^2], and the stable step with
    /// it [time].
    #[inline(always)]
    pub fn viscosity<R: Real>(&self, rate: R, length: R, density: R, slowness: R) -> (R, R) {
        let rate = Real::max(rate, R::zero());
        let [b1, b2] = self.bulk_viscosity.map(R::splat);
        let rate = length * rate;
        let quadratic = b2 * rate;
        let linear = match self.stiffening {
            None => b1 * R::splat(self.modulus()) * slowness,
            Some(_) => b1 * density / slowness,
        };
        let q = rate * density.mul_add(quadratic, linear);
        let stable_dt = viscous(length * slowness, (quadratic + quadratic).mul_add(slowness, b1));
        (q, stable_dt)
    }

    /// Adds the work of the mean bulk viscosity of a step to the energy of the law. `trace` is the
    /// volume strain, `volume` the ratio of the volume in the middle of the step to that at the
    /// start.
    #[inline(always)]
    pub fn heat<R: Real>(&self, state: &mut [R], viscosity: R, trace: R, volume: R) {
        if let Some(column) = self.heat {
            state[column] = (viscosity * trace).neg_mul_add(volume, state[column]);
        }
    }

    /// Returns true if the law may compute in single precision. The rounding of a history that
    /// adds up the deformation drifts: near nu = 1/2 its volume then gives a wrong pressure.
    pub fn any_precision(&self) -> bool {
        let needs_double = |name: &&str| [STRETCH_COLUMN, VOLUME_COLUMN].contains(name);
        !self.law.history().iter().any(needs_double)
    }

    /// Returns lambda + 2 mu [force/length^2].
    pub fn modulus(&self) -> f64 {
        self.elastic.lame() + 2.0 * self.elastic.shear_modulus()
    }

    /// Returns the stable step without viscosity times c_d, from `sum B_I B_I'` over C corners with
    /// equal masses [length].
    #[inline(always)]
    pub fn length<const C: usize, R: Real>(&self, gram: &[R; 6]) -> R {
        // 2 c_d/omega with omega^2 = C stiffness/density.
        (R::splat(4.0 / C as f64 * self.modulus()) / self.stiffness(gram)).sqrt()
    }

    /// Returns `2 mu g + max(lambda, 0) tr G` of `G = sum B_I B_I'` [force/length^4].
    #[inline(always)]
    pub fn stiffness<R: Real>(&self, gram: &[R; 6]) -> R {
        let (largest, trace) = largest_and_trace(gram);
        let elastic = &self.elastic;
        R::splat(elastic.lame().max(0.0)) * trace
            + R::splat(2.0 * elastic.shear_modulus()) * largest
    }

    /// Returns the names of the columns of stress and law.
    pub fn names(&self) -> impl Iterator<Item = String> {
        let stress = ["xx", "yy", "zz", "xy", "yz", "zx"].map(|c| format!("stress {c}"));
        let law = self.law.history().iter().map(|name| name.to_string());
        stress.into_iter().chain(law)
    }

    /// Returns true if the law has failed at a point whose columns begin at `first`.
    pub fn has_failed(&self, history: ElementState<'_>, first: usize) -> bool {
        self.failed.is_some_and(|column| history.at(first + column) > 0.5)
    }

    /// Returns the fields of a point whose columns begin at `first`.
    pub fn fields(&self, history: ElementState<'_>, first: usize) -> ElementFields {
        let at = |column: usize| history.at(first + column);
        let stress: [f64; STRESS] = std::array::from_fn(at);
        let [x, y, z, xy, yz, zx] = stress;
        let direct = (x - y) * (x - y) + (y - z) * (y - z) + (z - x) * (z - x);
        ElementFields {
            plastic_strain: self.plastic_strain.map_or(0.0, at),
            damage: self.damage.map_or(0.0, at),
            stress,
            von_mises: (0.5 * direct + 3.0 * (xy * xy + yz * yz + zx * zx)).sqrt(),
            thickness: 0.0,
            failed: self.has_failed(history, first),
        }
    }
}

/// Returns a bound of the largest eigenvalue of a symmetric tensor, and its trace.
#[inline(always)]
pub fn largest_and_trace<R: Real>(tensor: &[R; 6]) -> (R, R) {
    let [a, b, c, d, e, f] = *tensor;
    let trace = a + b + c;
    let third = R::splat(1.0 / 3.0) * trace;
    let [a, b, c] = [a - third, b - third, c - third];
    let square = dot([a, b, c], [a, b, c]) + R::splat(2.0) * dot([d, e, f], [d, e, f]);
    (third + (R::splat(2.0 / 3.0) * square).sqrt(), trace)
}

/// Returns the strain increment (xx, yy, zz, twice xy, yz, zx) and the rotation of half the step,
/// from the gradient of the displacement increment.
#[inline(always)]
pub fn increment<R: Real>(k: &[[R; 3]; 3]) -> ([R; STRESS], [[R; 3]; 3]) {
    let eps = [k[0][0], k[1][1], k[2][2], k[0][1] + k[1][0], k[1][2] + k[2][1], k[2][0] + k[0][2]];
    let turn = half_turn([k[2][1] - k[1][2], k[0][2] - k[2][0], k[1][0] - k[0][1]]);
    (eps, turn)
}

/// Returns the work of a step per volume [force/length^2], the largest component of the strain
/// increment, and the sum of all of them. `pressure` is the mean bulk viscosity of the step.
#[inline(always)]
pub fn work_and_size<R: Real>(
    before: &[R; STRESS],
    after: &[R; STRESS],
    eps: &[R; STRESS],
    pressure: R,
) -> (R, R, R) {
    let half = R::splat(0.5);
    let mean: [R; STRESS] = std::array::from_fn(|c| half * (before[c] + after[c]));
    let mut work = -(pressure * (eps[0] + eps[1] + eps[2]));
    let mut total = R::zero();
    let mut largest = R::zero();
    for c in 0..STRESS {
        work = mean[c].mul_add(eps[c], work);
        let size = if c < 3 { eps[c].abs() } else { half * eps[c].abs() };
        largest = Real::max(largest, size);
        total += size;
    }
    (work, largest, total)
}

/// Returns the stable step with damping; z is the fraction of critical damping.
#[inline(always)]
pub fn viscous<R: Real>(step: R, z: R) -> R {
    step * (z.mul_add(z, R::splat(1.0)).sqrt() - z)
}

/// Returns the rotation of half the step from twice the axis of skew K, with one division.
#[inline(always)]
fn half_turn<R: Real>(twice: [R; 3]) -> [[R; 3]; 3] {
    let [one, quarter] = [1.0, 0.25].map(R::splat);
    let w = twice.map(|c| quarter * c);
    let s = (one + dot(w, w)).sqrt();
    let along = one / s.mul_add(s, s);
    let cos = along.mul_add(s, along);
    let spin = w.map(|c| cos * c);
    let r = w.map(|c| along * c);
    let dyad = |i: usize, j: usize| r[i] * w[j];
    let (xy, yz, zx) = (dyad(0, 1), dyad(1, 2), dyad(2, 0));
    [
        [r[0].mul_add(w[0], cos), xy - spin[2], zx + spin[1]],
        [xy + spin[2], r[1].mul_add(w[1], cos), yz - spin[0]],
        [zx - spin[1], yz + spin[0], r[2].mul_add(w[2], cos)],
    ]
}

/// Returns two nodal columns at a corner of a group; in single precision, their values relative to
/// the first corner.
#[inline(always)]
pub fn corner<L: PointLanes<W>, const C: usize, const W: usize>(
    group: &GroupNodes<C, W>,
    columns: [&[[f64; 4]]; 2],
    c: usize,
) -> [[L; 3]; 2] {
    if L::SHORT && c == 0 {
        return [[L::zero(); 3]; 2];
    }
    let of_node = |i: u32| columns.map(|rows| Lane::new(rows[i as usize]));
    let mut rows = [[L::row(Lane::splat(0.0)); W]; 2];
    for lane in 0..W {
        let [mut x, mut v] = of_node(group[c][lane]);
        if L::SHORT {
            let [x0, v0] = of_node(group[0][lane]);
            (x, v) = (x - x0, v - v0);
        }
        (rows[0][lane], rows[1][lane]) = (L::row(x), L::row(v));
    }
    rows.map(L::from_rows)
}

/// Returns a vector by its components.
#[inline(always)]
pub fn each<R>(of: impl Fn(usize) -> R) -> [R; 3] {
    [of(0), of(1), of(2)]
}

/// Returns two nodal columns at the nodes of a group, relative to node 0.
#[inline(always)]
pub fn gather<L: PointLanes<W>, const N: usize, const W: usize>(
    group: &GroupNodes<N, W>,
    [one, other]: [&[[f64; 4]]; 2],
) -> [[[L; 3]; N]; 2] {
    // One length for both columns, so that one bounds check per node is enough.
    let n = one.len();
    let columns = [&one[..n], &other[..n]];
    let nodes: [[[L; 3]; 2]; N] = std::array::from_fn(|c| corner::<L, N, W>(group, columns, c));
    std::array::from_fn(|of| std::array::from_fn(|c| each(|i| nodes[c][of][i] - nodes[0][of][i])))
}

/// Returns the nodes of one element [length], relative to node 0.
pub fn relative<const N: usize>(x: &[[f64; 3]]) -> [[f64; 3]; N] {
    std::array::from_fn(|c| each(|i| x[c][i] - x[0][i]))
}

/// Writes the nodal forces of a group of elements [force], lane by lane.
#[inline(always)]
pub fn scatter<L: PointLanes<W>, const N: usize, const W: usize>(
    forces: [[L; 3]; N],
    force: &mut GroupCorners<N, W>,
) {
    for (c, of_node) in forces.into_iter().enumerate() {
        for (lane, row) in L::to_rows(of_node).into_iter().enumerate() {
            force[lane][c] = row.to_array();
        }
    }
}
