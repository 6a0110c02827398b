//! One step of a mesh of shells for a device on which a thread computes one element or one node.
//! The same functions run on a CPU, one after the other.
//!
//! Columns are stored one after the other, each over all elements: neighbouring threads then read
//! neighbouring numbers. Only rows of nodes keep their four numbers together.
#![cfg_attr(
    target_arch = "nvptx64",
    feature(abi_ptx, asm_experimental_arch, link_llvm_intrinsics),
    // The compiler warns that it may change the names of registers.
    allow(internal_features)
)]

#[cfg(target_arch = "nvptx64")]
mod device;
mod direct;

pub use direct::Direct;

use crumple_fem::elements::thread_shell::ThreadShell;
use crumple_fem::materials::plasticity::{
    Anisotropy, Coefficients, FailureCriterion, Plasticity, Rate, YieldCurve,
};
use crumple_fem::materials::{Elastic, PlaneStress, PointLanes};
use crumple_fem::nodes::NodeView;
use crumple_proto::job::Part;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU32, AtomicU64, Ordering};

/// Points through the thickness.
pub const POINTS: usize = 5;
/// Columns of a point: stress xx, yy, xy, and the plastic strain.
pub const POINT_COLUMNS: usize = 4;
/// Columns of an element: those of the section and its points, nine of hourglass and drilling
/// forces.
pub const COLUMNS: usize = SECTION_COLUMNS + POINTS * POINT_COLUMNS + 9;
/// Columns of corner forces: for each corner the force x, y, z, then for each its moment.
pub const CORNER_COLUMNS: usize = 24;

/// Part of the stable step that a step takes.
pub const SAFETY: f64 = 0.9;
/// Number of [`Step`]s in memory, which are used in turn: a kernel prepares the next one while its
/// other threads read the present one, and the next kernel must not find an old minimum.
pub const STEPS: u32 = 3;
/// Columns of a section before those of its points.
pub const SECTION_COLUMNS: usize = 5;

/// A step.
#[repr(C)]
pub struct Step {
    /// Step to the present coordinates [time].
    pub dt: f64,
    /// Bits of the least stable step of all elements so far [time]. Those of positive numbers have
    /// the order of the numbers.
    pub least: AtomicU64,
}

impl Step {
    /// Returns a step for which no element has been computed.
    pub fn new(dt: f64) -> Self {
        Self { dt, least: AtomicU64::new(f64::INFINITY.to_bits()) }
    }
}

/// Numbers of a sheet.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Sheet {
    /// Thickness [length].
    pub thickness: f64,
    /// Density [mass/length^3].
    pub density: f64,
    /// Young's modulus [force/length^2].
    pub youngs_modulus: f64,
    /// Poisson's ratio.
    pub poisson: f64,
    /// Yield stress [force/length^2].
    pub yield_stress: f64,
    /// Slope of the yield stress over the plastic strain [force/length^2].
    pub hardening_modulus: f64,
}

impl Sheet {
    /// Returns the law: von Mises plasticity with a straight line of hardening.
    pub fn law(&self) -> Plasticity {
        let Self { density, youngs_modulus, poisson, yield_stress, .. } = *self;
        let elastic = Elastic { youngs_modulus, poisson, density };
        Plasticity {
            elastic,
            yield_stress,
            curve: YieldCurve::lines(yield_stress, self.hardening_modulus, &[]),
            rate: Rate::None,
            thermal: None,
            failure: FailureCriterion::None,
            coefficients: Coefficients::anisotropic(&elastic, yield_stress, Anisotropy::NONE),
        }
    }

    /// Returns the shells.
    ///
    /// # Panics
    /// With numbers that no part can have.
    pub fn shell(&self) -> ThreadShell {
        let part = Part {
            id: 1,
            name: String::new(),
            material: String::new(),
            spring: None,
            belt: None,
            beam: None,
            truss: None,
            discrete_beam: None,
            particles: None,
            thickness: self.thickness,
            layer: Vec::new(),
            angles: Vec::new(),
            offset: 0.0,
            contact_thickness: None,
            contact_thickness_scale: 1.0,
            element: None,
            skin: false,
            parameters: BTreeMap::new(),
        };
        let law: Box<dyn PlaneStress> = Box::new(self.law());
        let Ok(shell) = ThreadShell::new(&part, law) else { panic!("a sheet with wrong numbers") };
        shell
    }
}

/// Columns of the elements of a mesh, and its nodes.
#[derive(Clone, Copy)]
#[repr(C)]
pub struct Mesh {
    /// Number of elements.
    pub count: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Corners: four columns.
    pub corners: *const u32,
    /// History: [`COLUMNS`] columns.
    pub history: *mut f64,
    /// Internal energies, then hourglass and drilling energies.
    pub energies: *mut f64,
    /// Corner forces: [`CORNER_COLUMNS`] columns.
    pub forces: *mut f64,
    /// 1 if an element was inverted or not finite, or strained too much in a step; else 0.
    pub trouble: *const AtomicU32,
    /// Coordinates of the nodes: x, y, z, padding [length].
    pub x: *mut [f64; 4],
    /// Velocities of the nodes [length/time].
    pub v: *mut [f64; 4],
    /// Rotational velocities of the nodes [1/time].
    pub w: *mut [f64; 4],
    /// Inverse mass [1/mass] and inertia [1/(mass length^2)] of each node.
    pub inverse: *const [f64; 2],
    /// For each node the start of its slots, then the end of those of the last one.
    pub start: *const u32,
    /// The slots of the nodes: `4 element + corner`, in ascending element.
    pub slots: *const u32,
}

/// Computes element `i` over the last step `dt` [time] and returns its stable step [time]; see
/// [`ThreadShell::compute`]. A part that it refuses is trouble.
///
/// # Safety
/// The pointers of `mesh` are valid, and no other thread uses the columns of this element; the
/// trouble is atomic. `shell` is one of [`Sheet::shell`], whose law [`Direct`] assumes.
#[inline(always)]
pub unsafe fn element<L: PointLanes<1>>(
    shell: &ThreadShell,
    mesh: &Mesh,
    i: usize,
    dt: f64,
) -> f64 {
    let n = mesh.count;
    // SAFETY: as the caller promises.
    unsafe {
        let corners = std::array::from_fn(|c| *mesh.corners.add(c * n + i));
        let rows = |rows: *mut [f64; 4]| std::slice::from_raw_parts(rows.cast_const(), mesh.nodes);
        let nodes = NodeView { x: rows(mesh.x), v: rows(mesh.v), w: rows(mesh.w) };
        let mut history: [L; COLUMNS] =
            std::array::from_fn(|c| L::splat(*mesh.history.add(c * n + i)));
        let result = shell.compute::<L, POINTS, POINT_COLUMNS>(corners, &nodes, &mut history, dt);
        let Some(result) = result else {
            (*mesh.trouble).store(1, Ordering::Relaxed);
            return 0.0;
        };
        for (c, column) in history.iter().enumerate() {
            *mesh.history.add(c * n + i) = column.lane(0);
        }
        for (c, more) in result.energies.iter().enumerate() {
            *mesh.energies.add(c * n + i) += more;
        }
        for corner in 0..4 {
            for c in 0..3 {
                *mesh.forces.add((corner * 3 + c) * n + i) = result.force[corner][c];
                *mesh.forces.add((12 + corner * 3 + c) * n + i) = result.moment[corner][c];
            }
        }
        if !result.sound {
            (*mesh.trouble).store(1, Ordering::Relaxed);
        }
        result.stable_dt
    }
}

/// Adds up the corner forces of node `i` in ascending order of elements, and moves it by the step
/// `dt`; its velocities change over `dt_velocity`.
///
/// # Safety
/// The pointers of `mesh` are valid, and no other thread uses the rows of this node.
#[inline(always)]
pub unsafe fn node(mesh: &Mesh, i: usize, dt_velocity: f64, dt: f64) {
    let n = mesh.count;
    let (mut force, mut moment) = ([0.0; 3], [0.0; 3]);
    // SAFETY: as the caller promises.
    unsafe {
        for k in *mesh.start.add(i)..*mesh.start.add(i + 1) {
            let slot = *mesh.slots.add(k as usize) as usize;
            let (element, corner) = (slot / 4, slot % 4);
            for c in 0..3 {
                force[c] -= *mesh.forces.add((corner * 3 + c) * n + element);
                moment[c] -= *mesh.forces.add((12 + corner * 3 + c) * n + element);
            }
        }
        let [inverse_mass, inverse_inertia] = *mesh.inverse.add(i);
        let (x, v, w) = (&mut *mesh.x.add(i), &mut *mesh.v.add(i), &mut *mesh.w.add(i));
        for c in 0..3 {
            v[c] += dt_velocity * (force[c] * inverse_mass);
            w[c] += dt_velocity * (moment[c] * inverse_inertia);
            x[c] += dt * v[c];
        }
    }
}
