//! Helpers for element tests: parts and materials in a line, a mesh with its columns, a minimal
//! explicit solver.

use super::{
    Element, ElementFields, ElementNodalForces, ElementPass, PassTotals, build_block, energy_places,
};
use crate::columns::HistoryColumns;
use crate::materials::{LAWS, elastic_of};
use crate::nodes::NodeView;
use crumple_proto::job::{Part, Precision};
use crumple_proto::mesh::{OwnSection, Shape};
use crumple_proto::partition::{Material, Param, Settings};
use std::collections::BTreeMap;

/// Returns a part with the usual options.
pub fn part(thickness: f64) -> Part {
    Part {
        id: 1,
        name: String::new(),
        material: "sheet".into(),
        spring: None,
        belt: None,
        beam: None,
        truss: None,
        discrete_beam: None,
        particles: None,
        thickness,
        layer: Vec::new(),
        angles: Vec::new(),
        offset: 0.0,
        contact_thickness: None,
        contact_thickness_scale: 1.0,
        element: None,
        skin: false,
        parameters: BTreeMap::new(),
    }
}

/// Elastic constants and yield stress of [`steel`] [force/length^2].
pub const E: f64 = 210.0;
pub const NU: f64 = 0.3;
pub const YIELD: f64 = 0.25;
/// Both precisions.
pub const BOTH: [Precision; 2] = [Precision::Double, Precision::Single];

/// Formulations, with true for triangles.
pub const FORMULATIONS: [(&str, bool); 4] = [
    ("belytschko_tsay", false),
    ("stabilised_quad", false),
    ("fully_integrated_quad", false),
    ("c0_triangle", true),
];

/// Formulations of quads.
pub const QUADS: [&str; 3] = [FORMULATIONS[0].0, FORMULATIONS[1].0, FORMULATIONS[2].0];

/// Returns a part of one formulation with the usual options.
pub fn part_of(element: &str, thickness: f64) -> Part {
    Part { element: Some(element.into()), ..part(thickness) }
}

/// Returns a material from its law and numbers.
pub fn material(law: &str, density: f64, numbers: &[(&str, f64)]) -> Material {
    let parameters =
        numbers.iter().map(|&(key, value)| (key.to_string(), Param::Number(value))).collect();
    Material { name: "sheet".into(), law: law.into(), density, parameters }
}

/// Returns sheet steel with a law, and these parameters in addition to the elastic ones.
pub fn steel(law: &str, more: &[(&str, Param)]) -> Material {
    let mut m = material(law, 7.85e-6, &[("youngs_modulus", E), ("poisson", NU)]);
    m.parameters.extend(more.iter().map(|(key, value)| (key.to_string(), value.clone())));
    m
}

/// Returns a table of rows.
fn table<const N: usize>(rows: &[[f64; N]]) -> Param {
    Param::Table(rows.iter().map(|row| row.to_vec()).collect())
}

/// Returns all laws of solids only, and those of [`laws`].
pub fn laws_of_solids() -> Vec<Material> {
    let coefficients = Param::List(vec![30.0, 10.0, 1.0, 2.0, 0.5, 0.3]);
    let curve = [[0.0, 0.0], [0.02, 1.0], [0.1, 1.5], [0.5, 30.0]];
    let by_rate = [
        [0.01, 0.0, 0.0],
        [0.01, 0.02, 1.0],
        [0.01, 0.5, 30.0],
        [0.5, 0.0, 0.0],
        [0.5, 0.02, 1.5],
        [0.5, 0.5, 50.0],
    ];
    let of = |law: &str, numbers: &[(&str, f64)], others: &[(&str, Param)]| {
        let mut material = material(law, 7.85e-6, numbers);
        material
            .parameters
            .extend(others.iter().map(|(key, value)| (key.to_string(), value.clone())));
        material
    };
    let nu = ("poisson", 0.3);
    let test: [[f64; 2]; 21] = std::array::from_fn(|k| {
        let stretch = 0.5 + 0.05 * k as f64;
        [stretch - 1.0, if k == 10 { 0.0 } else { 40.0 * (stretch - stretch.powi(-2)) }]
    });
    let tests = [(0.01, 1.0), (0.5, 1.4)]
        .map(|(rate, factor)| test.map(|[strain, stress]| [rate, strain, factor * stress]))
        .concat();
    let compacted = [
        ("youngs_modulus", 200.0),
        ("poisson", 0.3),
        ("yield_stress", 0.8),
        ("compacted_volume", 0.6),
    ];
    let concrete = [
        ("youngs_modulus", 26.4),
        ("poisson", 0.15),
        ("tension_energy", 7e-5),
        ("compression_energy", 7e-3),
        ("shear_energy", 7e-5),
    ];
    let surfaces = [
        ("shear_surface", Param::List(vec![0.0145, 0.2965, 0.0105, 19.3])),
        ("torsion", Param::List(vec![0.747, 1.2, 0.17, 71.0])),
        ("extension", Param::List(vec![0.66, 1.4, 0.16, 72.0])),
        ("cap", Param::List(vec![5.0, 0.09, 0.05, 0.25, 0.349])),
    ];
    let ceramic = [
        ("intact_strength", Param::List(vec![0.9, 0.6])),
        ("fractured_strength", Param::List(vec![0.3, 0.7])),
        ("rate", Param::List(vec![0.05, 1e-3])),
        ("hugoniot_elastic_limit", Param::List(vec![5.0, 2.5])),
        ("damage", Param::List(vec![0.5, 0.7])),
        ("pressure", Param::List(vec![80.0, 20.0, 30.0])),
    ];
    let crushed = [
        ("strength_constants", Param::List(vec![0.8, 1.6, 0.6])),
        ("rate", Param::List(vec![0.05, 1e-3])),
        ("crushing_point", Param::List(vec![0.02, 1.6])),
        ("locking_point", Param::List(vec![0.1, 4.0])),
        ("damage", Param::List(vec![0.5, 1.0])),
        ("pressure", Param::List(vec![121.0, 20.0, 30.0])),
    ];
    let soil = [
        ("yield_constants", Param::List(vec![1.0, 0.5, 0.1])),
        ("pressure", table(&[[0.0, 0.0], [0.1, 2.0], [0.5, 30.0]])),
    ];
    let three_surfaces = [
        ("largest_surface", Param::List(vec![1.2, 0.45, 0.02])),
        ("yield_surface", Param::List(vec![0.9, 0.6, 0.06])),
        ("residual_surface", Param::List(vec![0.45, 0.03])),
        ("damage_curve", table(&[[0.0, 0.0], [1e-3, 1.0], [0.02, 0.0]])),
        ("damage_scaling", Param::List(vec![1.6, 1.35, 1.15])),
        ("dilatancy", Param::List(vec![0.5, 1.0])),
        ("rate_factors", table(&[[-1.0, 2.0], [0.0, 1.0], [1.0, 1.5]])),
        ("compaction", table(&[[0.0, 0.0, 80.0], [0.01, 0.6, 90.0], [0.1, 6.0, 140.0]])),
    ];
    let failure = [("tension_failure_strain", 2.0), ("shear_failure_strain", 3.0)];
    let honeycomb = [
        ("moduli", Param::List(vec![80.0, 30.0, 20.0, 25.0, 15.0, 10.0])),
        ("crush_a", table(&[[0.0, 0.5], [0.02, 1.0], [0.3, 3.0]])),
        ("crush_shear", table(&[[-0.1, 0.1], [0.1, 0.4]])),
    ];
    let more = [
        ("crush_b", table(&[[-0.1, 0.2], [0.2, 0.5]])),
        ("directional", Param::Flag(true)),
        ("rate_factors", table(&[[0.0, 1.0], [2.0, 1.5]])),
        ("direction", Param::List(vec![1.0, 2.0, 0.5])),
        ("direction_2", Param::List(vec![-1.0, 0.3, 0.0])),
    ];
    let hysteresis = [("youngs_modulus", 80.0), ("hysteresis", 0.2), ("shape", 2.0)];
    let mut all = vec![
        of("polynomial_rubber", &[nu], &[("coefficients", coefficients)]),
        of("ogden", &[nu], &[("terms", table(&[[60.0, 1.3], [1.0, 5.0], [-4.0, -2.0]]))]),
        of("blatz_ko", &[("shear_modulus", 40.0)], &[]),
        of("tabulated_rubber", &[("bulk_modulus", 80.0)], &[("curve", table(&test))]),
        of("tabulated_rubber", &[nu], &[("curve", table(&test))]),
        of("tabulated_rubber", &[("bulk_modulus", 120.0)], &[("curve_by_rate", table(&tests))]),
        of(
            "tabulated_rubber",
            &[nu, ("rate_averaging_time", 0.5)],
            &[("curve_by_rate", table(&tests)), ("nominal_rate", Param::Flag(true))],
        ),
        of("low_density_foam", &hysteresis, &[("compression", table(&curve))]),
        of("low_density_foam", &hysteresis[..1], &[("compression_by_rate", table(&by_rate))]),
        of(
            "crushable_foam",
            &[("youngs_modulus", 80.0), ("poisson", 0.1), ("tension_cutoff", 0.5)],
            &[("compression", table(&curve))],
        ),
        of(
            "viscous_foam",
            &[
                ("youngs_modulus", 40.0),
                ("poisson", 0.1),
                ("stiffness_exponent", 3.0),
                ("viscous_coefficient", 0.5),
                ("viscous_modulus", 40.0),
                ("viscous_exponent", 0.3),
            ],
            &[],
        ),
        of("cscm", &concrete, &surfaces),
        of(
            "johnson_holmquist_ceramic",
            &[("shear_modulus", 40.0), ("tensile_strength", 3.0), ("bulking", 1.0)],
            &ceramic,
        ),
        of(
            "johnson_holmquist_concrete",
            &[("shear_modulus", 39.7), ("tensile_strength", 3.0), ("compressive_strength", 2.0)],
            &crushed,
        ),
        of("karagozian_case_concrete", &[nu, ("tensile_strength", 0.4)], &three_surfaces),
        of(
            "soil",
            &[("shear_modulus", 40.0), ("bulk_modulus", 80.0), ("tension_cutoff", 2.0)],
            &soil,
        ),
        of(
            "fluid",
            &[("viscosity", 1e-3), ("eos_min_pressure", -0.5)],
            &[("eos_polynomial", Param::List(vec![80.0, 100.0, 50.0, 0.5, 0.2, 0.0]))],
        ),
        of("honeycomb", &compacted, &honeycomb),
        of("honeycomb", &[&compacted[..], &failure].concat(), &[&honeycomb[..], &more].concat()),
    ];
    let of_shells = |m: &Material| LAWS.iter().any(|row| row.name == m.law && row.solid.is_none());
    all.extend(laws().into_iter().filter(|m| !of_shells(m)));
    assert!(
        LAWS.iter()
            .filter(|row| row.solid.is_some())
            .all(|row| all.iter().any(|m| m.law == row.name)),
        "a law is missing in this list"
    );
    all
}

/// Returns all laws of shells, with all options that use powers, logarithms and exponentials.
pub fn laws() -> Vec<Material> {
    let number = Param::Number;
    let hardening = table(&[[0.0, YIELD], [0.02, 0.3], [0.05, 0.6]]);
    let by_rate =
        table(&[[0.001, 0.0, YIELD], [0.001, 0.05, 0.3], [1.0, 0.0, 0.5], [1.0, 0.05, 0.7]]);
    let viscoelastic = [("long_term_shear_modulus", number(20.0)), ("decay_rate", number(3.0))];
    let rate = Param::List(vec![0.04, 5.0]);
    let damage = Param::List(vec![0.05, 3.44, -2.12, 0.002, 0.61]);
    let johnson_cook = [
        ("a", number(0.79)),
        ("b", number(0.51)),
        ("n", number(0.26)),
        ("c", number(0.014)),
        ("reference_rate", number(1e-3)),
        ("m", number(1.03)),
        ("melting_temperature", number(1793.0)),
        ("reference_temperature", number(293.0)),
        ("specific_heat", number(477.0)),
        ("damage", damage),
    ];
    let ply = [
        ("youngs_modulus_b", number(100.0)),
        ("shear_modulus", number(30.0)),
        ("direction", Param::List(vec![1.0, 2.0, 0.0])),
        ("strength_tension_a", number(1.0)),
        ("strength_compression_a", number(0.8)),
        ("strength_tension_b", number(0.5)),
        ("strength_compression_b", number(0.7)),
        ("strength_shear", number(0.4)),
        ("shear_weight", number(0.5)),
        ("shear_nonlinearity", number(1e-3)),
        ("failure_strain_tension_a", number(0.3)),
    ];
    let rolled = [
        ("exponent", number(6.0)),
        ("lankford_0", number(1.8)),
        ("lankford_45", number(1.3)),
        ("lankford_90", number(2.2)),
        ("swift", Param::List(vec![0.5, 0.01, 0.2])),
        ("direction", Param::List(vec![1.0, 2.0, 0.0])),
    ];
    let all = vec![
        steel("elastic", &[]),
        steel(
            "elastic",
            &[
                ("erosion_principal_stress", number(1e3)),
                ("erosion_max_pressure", number(1e3)),
                ("erosion_von_mises", number(1e3)),
            ],
        ),
        steel("j2", &[("yield_stress", number(YIELD)), ("hardening_modulus", number(1.0))]),
        steel(
            "j2",
            &[("hardening", hardening), ("cowper_symonds", rate), ("failure_strain", number(0.3))],
        ),
        steel(
            "j2",
            &[
                ("yield_stress", number(YIELD)),
                ("hardening_modulus", number(0.5)),
                ("kinematic_modulus", number(1.0)),
                ("rate_factors", table(&[[0.0, 1.0], [5.0, 1.5], [50.0, 2.0]])),
                ("viscoplastic", Param::Flag(true)),
            ],
        ),
        steel("j2", &[("hardening_by_rate", by_rate), ("failure_strain", number(0.3))]),
        steel("viscoelastic", &viscoelastic),
        {
            let mut series = material("general_viscoelastic", 7.85e-6, &[("bulk_modulus", 100.0)]);
            let terms = [
                ("shear_terms", [[20.0, 0.0], [50.0, 3.0]]),
                ("bulk_terms", [[30.0, 2.0], [20.0, 0.5]]),
            ];
            series.parameters.extend(terms.map(|(key, rows)| (key.to_string(), table(&rows))));
            series
        },
        material("mooney_rivlin", 7.85e-6, &[("a", 30.0), ("b", 10.0), ("poisson", 0.45)]),
        steel("johnson_cook", &johnson_cook),
        steel("fabric", &[("damping", number(0.05))]),
        steel(
            "fabric",
            &[("youngs_modulus_b", number(100.0)), ("direction", Param::List(vec![1.0, 2.0, 0.0]))],
        ),
        steel(
            "orthotropic",
            &[("youngs_modulus_b", number(100.0)), ("shear_modulus", number(30.0))],
        ),
        steel("orthotropic", &ply),
        steel("barlat", &rolled),
        steel(
            "gurson",
            &[
                ("yield_stress", number(YIELD)),
                ("hardening_modulus", number(0.5)),
                ("void_fraction", number(0.01)),
                ("nucleation", Param::List(vec![0.04, 0.02, 0.01])),
                ("critical_void_fraction", number(0.05)),
                ("failure_void_fractions", table(&[[0.5, 0.2], [2.0, 0.15]])),
            ],
        ),
        steel(
            "polymer",
            &[
                (
                    "tension_by_rate",
                    table(&[[0.0, 0.0, YIELD], [0.0, 0.1, 0.5], [1.0, 0.0, 0.3], [1.0, 0.1, 0.7]]),
                ),
                ("compression", table(&[[0.0, 1.2 * YIELD], [0.1, 0.6]])),
                ("shear", table(&[[0.0, 0.7 * YIELD], [0.1, 0.35]])),
                ("plastic_poisson_curve", table(&[[0.0, 0.5], [0.1, 0.2]])),
                ("damage", table(&[[0.0, 0.0], [0.3, 0.2]])),
                ("failure_strain", number(0.5)),
                ("fading_strain", number(0.2)),
            ],
        ),
        steel(
            "j2",
            &[
                ("yield_stress", number(YIELD)),
                ("hardening_modulus", number(1.0)),
                ("gissmo_failure_strain", table(&[[-0.3, 2.0], [0.0, 0.5], [0.6, 0.3]])),
                ("gissmo_critical_strain", table(&[[0.0, 0.02], [0.6, 0.01]])),
                ("gissmo_exponent", number(1.7)),
                ("gissmo_fading_exponent", number(1.5)),
                ("gissmo_size_factors", table(&[[0.5, 1.0], [2.0, 0.8]])),
            ],
        ),
        steel(
            "j2",
            &[
                ("yield_stress", number(YIELD)),
                ("hardening_modulus", number(1.0)),
                ("diem_ductile", table(&[[-0.3, 2.0], [0.0, 0.05], [0.6, 0.02]])),
                ("diem_ductile_displacement", number(2.0)),
                ("diem_shear", table(&[[1.0, 0.1], [2.0, 0.02]])),
                ("diem_shear_energy", number(0.5)),
                ("diem_shear_multiplied", Param::Flag(true)),
                ("diem_principal", table(&[[0.5, 0.1], [1.5, 0.03]])),
                ("diem_principal_pressure", number(0.3)),
                ("diem_principal_displacement", number(1.5)),
                ("diem_principal_multiplied", Param::Flag(true)),
            ],
        ),
    ];
    assert!(
        LAWS.iter()
            .filter(|row| row.build.is_some())
            .all(|row| all.iter().any(|m| m.law == row.name)),
        "a law is missing in this list"
    );
    all
}

/// Returns an elastic material.
pub fn elastic(e: f64, nu: f64, rho: f64) -> Material {
    material("elastic", rho, &[("youngs_modulus", e), ("poisson", nu)])
}

/// Returns the speed of the dilatational wave of a material [length/time].
pub fn wave_speed(material: &Material) -> f64 {
    let elastic = elastic_of(material).map_err(|problems| format!("{problems:?}")).unwrap();
    elastic.expect("elastic constants").dilatational_wave_speed()
}

/// Returns the settings of a job that has one part of one material.
pub fn settings(part: Part, material: Material) -> Settings {
    let (materials, parts) = (vec![material], vec![part]);
    Settings { materials, parts, ..crate::testing::settings() }
}

/// Elements of one part with C slots each, with their nodes, columns and corner forces. Solids have
/// no moments.
pub struct Patch<const C: usize = 4> {
    pub shape: Shape,
    pub element: Box<dyn Element>,
    pub x: Vec<[f64; 4]>,
    pub v: Vec<[f64; 4]>,
    pub w: Vec<[f64; 4]>,
    pub cells: Vec<[u32; C]>,
    pub groups: Vec<u32>,
    pub history: HistoryColumns,
    pub unstrained: Vec<bool>,
    pub force: Vec<[f64; 4]>,
    pub moment: Vec<[f64; 4]>,
    /// Step below which solids may be deleted.
    pub least_dt: f64,
}

/// Result of a pass, with the energies that it added, summed over elements.
#[derive(Clone, Copy, Debug)]
pub struct Passed {
    pub stable_dt: f64,
    pub internal: f64,
    pub hourglass: f64,
    pub trouble: Option<usize>,
}

/// Runs a pass over a block with `count` elements in this number of `places`, which include
/// padding, in groups of `lanes`.
pub fn passed(
    (count, places, lanes): (usize, usize, usize),
    pass: impl FnOnce(&mut [f64]) -> PassTotals,
) -> Passed {
    let mut energies = vec![0.0; 2 * places];
    let PassTotals { stable_dt, trouble } = pass(&mut energies);
    let [mut internal, mut hourglass] = [0.0; 2];
    for i in 0..count {
        let places = energy_places(i, lanes);
        internal += energies[places[0]];
        hourglass += energies[places[1]];
    }
    Passed { stable_dt, internal, hourglass, trouble }
}

/// Returns the connectivity in groups, and the columns of new elements.
pub fn lay<const C: usize>(
    element: &dyn Element,
    precision: Precision,
    cells: &[[u32; C]],
) -> (Vec<u32>, HistoryColumns) {
    let mut columns = HistoryColumns::new(precision, cells.len(), element.columns());
    let (lanes, mut fresh) = (columns.lanes(), vec![0.0; element.columns()]);
    element.start(&mut fresh, OwnSection::default());
    let mut groups = Vec::new();
    for first in (0..cells.len()).step_by(lanes) {
        let of = |lane: usize| cells[(first + lane).min(cells.len() - 1)];
        (0..C).for_each(|corner| groups.extend((0..lanes).map(|lane| of(lane)[corner])));
        (0..lanes).for_each(|lane| columns.set(first + lane, &fresh));
    }
    (groups, columns)
}

impl<const C: usize> Patch<C> {
    pub fn new(part: Part, material: Material, nodes: &[[f64; 3]], cells: &[[u32; C]]) -> Self {
        Self::in_precision(Precision::Double, part, material, nodes, cells)
    }

    pub fn in_precision(
        precision: Precision,
        part: Part,
        material: Material,
        nodes: &[[f64; 3]],
        cells: &[[u32; C]],
    ) -> Self {
        let shape = match cells[0][..] {
            [_, _, _, _] if part.element.as_deref() == Some("tetrahedron") => Shape::Tet4,
            [_, _, c, d] if c == d => Shape::Tri3,
            [_, _, _, _] => Shape::Quad4,
            [_, _, _, _, _, _] => Shape::Wedge6,
            [_, _, _, _, _, _, _, _, _, _] => Shape::Tet10,
            _ if part.element.as_deref() == Some(super::COHESIVE) => Shape::Cohesive8,
            _ => Shape::Hex8,
        };
        // Tests that name no formulation use the simplest one.
        let part = match (&part.element, shape) {
            (None, Shape::Quad4) => Part { element: Some("belytschko_tsay".into()), ..part },
            // A fluid has this form only.
            (None, Shape::Hex8) if material.law == "fluid" => part.with("hourglass", "viscous"),
            _ => part,
        };
        let element =
            build_block(&settings(part, material), 0, shape).map_err(|e| format!("{e:?}")).unwrap();
        let (groups, mut history) = lay(&*element, precision, cells);
        for place in 0..groups.len() / C {
            let corners = cells[place.min(cells.len() - 1)].map(|n| nodes[n as usize]);
            let mut state = history.element(place).to_vec();
            element.measure(&mut state, &corners, OwnSection::default());
            history.set(place, &state);
        }
        let still = vec![[0.0; 4]; nodes.len()];
        let corners = vec![[0.0; 4]; groups.len()];
        let mut patch = Self {
            shape,
            unstrained: vec![false; groups.len() / (C * history.lanes())],
            element,
            x: nodes.iter().map(|x| [x[0], x[1], x[2], 0.0]).collect(),
            v: still.clone(),
            w: still,
            cells: cells.to_vec(),
            groups,
            history,
            moment: if shape.is_solid() { Vec::new() } else { corners.clone() },
            force: corners,
            least_dt: 0.0,
        };
        if shape.is_solid() {
            patch.forces(0.0); // the first pass stores the volume at the start
        }
        patch
    }

    /// Moves nodes with their velocities, then computes the forces.
    pub fn step(&mut self, dt: f64) -> Passed {
        for (x, v) in self.x.iter_mut().zip(&self.v) {
            (0..3).for_each(|i| x[i] += dt * v[i]);
        }
        self.forces(dt)
    }

    /// Computes the forces at the present positions of the nodes.
    pub fn forces(&mut self, dt: f64) -> Passed {
        let nodes = NodeView { x: &self.x, v: &self.v, w: &self.w };
        let out = ElementNodalForces { force: &mut self.force, moment: &mut self.moment };
        let lanes = self.history.lanes();
        passed((self.cells.len(), self.groups.len() / C, lanes), |energies| {
            self.element.forces(ElementPass {
                range: 0..self.groups.len() / (C * self.history.lanes()),
                count: self.cells.len(),
                groups: &self.groups,
                history: self.history.as_mut(),
                unstrained: &mut self.unstrained,
                nodes,
                dt,
                least_dt: self.least_dt,
                step_factors: &[],
                out,
                energies,
            })
        })
    }

    /// Sets velocities that move every node to `target` in a step; rotational ones as given.
    pub fn aim(&mut self, dt: f64, target: impl Fn([f64; 3]) -> [f64; 3], spin: [f64; 3]) {
        for ((x, v), w) in self.x.iter().zip(&mut self.v).zip(&mut self.w) {
            let to = target([x[0], x[1], x[2]]);
            (0..3).for_each(|i| v[i] = (to[i] - x[i]) / dt);
            w[..3].copy_from_slice(&spin);
        }
    }

    /// Moves every node to `target` in a step of 1.
    pub fn go(&mut self, target: impl Fn([f64; 3]) -> [f64; 3]) -> Passed {
        self.aim(1.0, target, [0.0; 3]);
        self.step(1.0)
    }

    pub fn corners(&self, element: usize) -> [[f64; 3]; C] {
        self.cells[element].map(|node| std::array::from_fn(|i| self.x[node as usize][i]))
    }

    pub fn fields(&self, element: usize) -> ElementFields {
        self.element.fields(self.history.element(element), &self.corners(element))
    }

    /// Returns corner force and moment of an element.
    pub fn corner(&self, element: usize, corner: usize) -> ([f64; 3], [f64; 3]) {
        let slot = element * C + corner;
        let three = |row: &[f64; 4]| [row[0], row[1], row[2]];
        (three(&self.force[slot]), self.moment.get(slot).map_or([0.0; 3], three))
    }

    /// Returns the forces and moments of the elements on the nodes.
    pub fn nodal(&self) -> (Vec<[f64; 3]>, Vec<[f64; 3]>) {
        let (mut force, mut moment) = (vec![[0.0; 3]; self.x.len()], vec![[0.0; 3]; self.x.len()]);
        for (e, cell) in self.cells.iter().enumerate() {
            for (c, &node) in cell.iter().enumerate() {
                let (f, m) = self.corner(e, c);
                (0..3).for_each(|i| force[node as usize][i] += f[i]);
                (0..3).for_each(|i| moment[node as usize][i] += m[i]);
            }
        }
        (force, moment)
    }

    /// Returns the largest magnitude of any corner force and of any corner moment.
    pub fn largest(&self) -> (f64, f64) {
        let largest =
            |rows: &[[f64; 4]]| rows.iter().flatten().fold(0.0, |m: f64, v| m.max(v.abs()));
        (largest(&self.force), largest(&self.moment))
    }

    /// Returns the sum of corner forces, and of moments about the origin, over all real elements.
    pub fn sums(&self) -> ([f64; 3], [f64; 3]) {
        let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
        let (forces, moments) = self.nodal();
        for ((f, m), x) in forces.iter().zip(&moments).zip(&self.x) {
            let arm =
                [x[1] * f[2] - x[2] * f[1], x[2] * f[0] - x[0] * f[2], x[0] * f[1] - x[1] * f[0]];
            for i in 0..3 {
                force[i] += f[i];
                moment[i] += m[i] + arm[i];
            }
        }
        (force, moment)
    }

    /// Returns the power of corner forces at the nodal velocities.
    pub fn power(&self) -> f64 {
        let (force, moment) = self.nodal();
        let of_node = |i: usize| {
            (0..3).map(|c| force[i][c] * self.v[i][c] + moment[i][c] * self.w[i][c]).sum::<f64>()
        };
        (0..self.x.len()).map(of_node).sum()
    }

    /// Returns nodal mass and inertia.
    pub fn masses(&self) -> Vec<(f64, f64)> {
        let mut masses = vec![(0.0, 0.0); self.x.len()];
        for (e, cell) in self.cells.iter().enumerate() {
            let (mass, inertia) = self.element.corner_mass(&self.corners(e), OwnSection::default());
            let corners = if C == 4 && cell[2] == cell[3] { 3 } else { C };
            for (c, &node) in cell[..corners].iter().enumerate() {
                let share = self.shape.mass_share(c);
                masses[node as usize].0 += share * mass;
                masses[node as usize].1 += share * inertia;
            }
        }
        masses
    }

    /// Returns the stable step of the mesh's elements.
    pub fn stable_dt(&self) -> f64 {
        (0..self.cells.len())
            .map(|e| self.element.stable_dt(&self.corners(e), OwnSection::default()))
            .fold(f64::INFINITY, f64::min)
    }

    /// Advances one explicit step: `load` adds to nodal forces, `fix` clears prescribed velocities.
    pub fn explicit(
        &mut self,
        dt: f64,
        masses: &[(f64, f64)],
        load: impl Fn(usize) -> [f64; 3],
        fix: impl Fn(usize, &mut [f64; 4], &mut [f64; 4]),
    ) -> Passed {
        let (force, moment) = self.nodal();
        for (node, &(mass, inertia)) in masses.iter().enumerate() {
            let load = load(node);
            for i in 0..3 {
                self.v[node][i] += dt * (load[i] - force[node][i]) / mass;
                if inertia > 0.0 {
                    self.w[node][i] -= dt * moment[node][i] / inertia;
                }
            }
            fix(node, &mut self.v[node], &mut self.w[node]);
        }
        self.step(dt)
    }
}

/// Returns nodes and quads of a rectangle of `nx` by `ny` elements; node `j (nx + 1) + i`.
pub fn grid(nx: usize, ny: usize, width: f64, height: f64) -> (Vec<[f64; 3]>, Vec<[u32; 4]>) {
    let at =
        |i: usize, j: usize| [width * i as f64 / nx as f64, height * j as f64 / ny as f64, 0.0];
    let nodes = (0..=ny).flat_map(|j| (0..=nx).map(move |i| at(i, j))).collect();
    let id = |i: usize, j: usize| (j * (nx + 1) + i) as u32;
    let quad = |i: usize, j: usize| [id(i, j), id(i + 1, j), id(i + 1, j + 1), id(i, j + 1)];
    let quads = (0..ny).flat_map(|j| (0..nx).map(move |i| quad(i, j))).collect();
    (nodes, quads)
}

/// Returns quads cut into triangles along alternate diagonals.
pub fn triangles(quads: &[[u32; 4]]) -> Vec<[u32; 4]> {
    let cut = |(index, q): (usize, &[u32; 4])| {
        let [a, b, c, d] = *q;
        if index % 2 == 0 { [[a, b, c, c], [a, c, d, d]] } else { [[a, b, d, d], [b, c, d, d]] }
    };
    quads.iter().enumerate().flat_map(cut).collect()
}

/// Returns shells of every formulation.
pub fn shells(precision: Precision, steel: &Material, at: [f64; 3]) -> [Patch; 4] {
    let (nodes, quads) = grid(5, 3, 5.0, 3.0);
    let mut noise = Noise(5);
    let moved = |x: &[f64; 3]| {
        std::array::from_fn(|i| at[i] + x[i] + if i < 2 { 0.1 } else { 0.02 } * noise.next())
    };
    let nodes: Vec<[f64; 3]> = nodes.iter().map(moved).collect();
    let base = part(0.3).with("thinning", true).with("warping", true);
    let of = |name: &str| Part { element: Some(name.into()), ..base.clone() };
    [
        Patch::in_precision(precision, of("belytschko_tsay"), steel.clone(), &nodes, &quads),
        Patch::in_precision(precision, of("stabilised_quad"), steel.clone(), &nodes, &quads),
        Patch::in_precision(precision, of("fully_integrated_quad"), steel.clone(), &nodes, &quads),
        Patch::in_precision(precision, base.clone(), steel.clone(), &nodes, &triangles(&quads)),
    ]
}

/// Numbers between -1 and 1, equal in every run.
pub struct Noise(pub u64);

impl Noise {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}

/// Returns `x` rotated by the length of `angle` about its direction (Rodrigues).
pub fn rotate(angle: [f64; 3], x: [f64; 3]) -> [f64; 3] {
    let phi = angle.iter().map(|c| c * c).sum::<f64>().sqrt();
    let k = angle.map(|c| c / phi);
    let dot: f64 = (0..3).map(|i| k[i] * x[i]).sum();
    let cross = [k[1] * x[2] - k[2] * x[1], k[2] * x[0] - k[0] * x[2], k[0] * x[1] - k[1] * x[0]];
    let (sin, cos) = phi.sin_cos();
    std::array::from_fn(|i| x[i] * cos + cross[i] * sin + k[i] * dot * (1.0 - cos))
}

/// Panics with the reason for the tolerance if the value differs by more than it.
#[track_caller]
pub fn assert_close(value: f64, wanted: f64, tolerance: f64, why: &str) {
    let off = (value - wanted).abs();
    assert!(
        off <= tolerance,
        "{value} for {wanted}: off by {off:e}, allowed {tolerance:e} ({why})"
    );
}
