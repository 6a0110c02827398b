//! Strains of elements from the positions of their nodes, for databases that are to have them.
//!
//! The strain is `h = ln(B)/2` with the left Cauchy-Green tensor `B = F F'` (Hencky 1928), in
//! global axes. F maps the nodes around their centre at the start to those now, by least squares:
//! for a linear motion it is exact. A shell has F in its plane; along its normal it has ln(t/t_0).
//! Its bending is the change of the gradient of its nodal normals, which are means over the shells
//! of its part around a node: `h(z) = h_m + z (K - K_0)`, with K from the normals now and `K_0`
//! from those at the start, in the axes of the shell. Shells at an angle of more than 60 degrees
//! are no part of the mean, so that folds of the mesh have no curvature.

use super::source::{DatabaseState, FieldMesh, StateValues};
use nalgebra::{Matrix2, Matrix3, Vector3};

/// Strain xx, yy, zz, xy, yz, zx.
pub type Strain = [f32; 6];

/// Smallest cosine between two shells with a common normal.
const SMOOTH: f64 = 0.5;

/// Strains of all elements at one time: of solids, and of shells at the inner and the outer
/// surface.
pub struct StateStrains {
    /// Per solid.
    pub solids: Vec<Strain>,
    /// Per shell.
    pub shells: Vec<[Strain; 2]>,
}

/// A mesh with what strains need of its start.
pub struct StrainedMesh {
    x: Vec<[f32; 3]>,
    solids: Vec<Vec<i32>>,
    shells: Vec<[i32; 4]>,
    parts: Vec<i32>,
    /// Thickness of the shells in the first state that has them [length].
    thickness: Vec<f32>,
}

impl StrainedMesh {
    /// Takes the nodes and elements of a mesh at the start.
    pub fn new(mesh: &FieldMesh) -> Self {
        let corners = |corners: &[i32; 8]| {
            let mut once = corners.to_vec();
            once.sort_unstable();
            once.dedup();
            once
        };
        Self {
            x: mesh.x.clone(),
            solids: mesh.solid_corners.iter().map(corners).collect(),
            shells: mesh.shell_corners.clone(),
            parts: mesh.shells.iter().map(|e| e.part).collect(),
            thickness: vec![0.0; mesh.shells.len()],
        }
    }

    /// Returns the strains of a state. States have to come in the order of time.
    pub fn at(&mut self, state: &DatabaseState) -> StateStrains {
        for (first, values) in self.thickness.iter_mut().zip(&state.shells) {
            if *first == 0.0 && values.alive {
                *first = values.thickness;
            }
        }
        let alive: Vec<bool> = state.shells.iter().map(|values| values.alive).collect();
        let shells = ShellStrains::new(&self.shells, &self.parts, &alive, self.x.len());
        let (start, now) = (shells.positions(&self.x), shells.positions(&state.x));
        let of_shell = |(i, values): (usize, &StateValues)| {
            let thickness = [self.thickness[i], values.thickness].map(f64::from);
            shells.strains(i, [&start, &now], thickness)
        };
        StateStrains {
            solids: self.solids.iter().map(|c| of_solid(c, [&self.x, &state.x])).collect(),
            shells: state.shells.iter().enumerate().map(of_shell).collect(),
        }
    }
}

/// Shells and the positions of the nodes.
pub struct ShellStrains<'a> {
    /// Indices of the nodes; a triangle repeats its third one.
    pub corners: &'a [[i32; 4]],
    /// Index of the part of each shell.
    pub parts: &'a [i32],
    /// Shells around each node.
    around: Vec<Vec<u32>>,
}

/// A position of all nodes, with the area vectors of all shells.
pub struct ShellPositions<'a> {
    x: &'a [[f32; 3]],
    areas: Vec<Vector3<f64>>,
}

fn at(x: &[[f32; 3]], node: i32) -> Vector3<f64> {
    Vector3::from(x[node as usize].map(f64::from))
}

impl<'a> ShellStrains<'a> {
    /// Finds the shells around each of `nodes` nodes, without those that are not `alive`: their
    /// nodes no longer move with the others.
    pub fn new(corners: &'a [[i32; 4]], parts: &'a [i32], alive: &[bool], nodes: usize) -> Self {
        let mut around = vec![Vec::new(); nodes];
        for ((shell, of), _) in (0..).zip(corners).zip(alive).filter(|(_, alive)| **alive) {
            of.iter().for_each(|&n| around[n as usize].push(shell));
        }
        around.iter_mut().for_each(Vec::dedup);
        Self { corners, parts, around }
    }

    /// Returns the positions with the area vectors of the shells.
    pub fn positions<'x>(&self, x: &'x [[f32; 3]]) -> ShellPositions<'x> {
        let area = |c: &[i32; 4]| {
            let [a, b, c, d] = c.map(|n| at(x, n));
            0.5 * (c - a).cross(&(d - b))
        };
        // The diagonals of a triangle that repeats its third node are two of its sides.
        ShellPositions { x, areas: self.corners.iter().map(area).collect() }
    }

    /// Returns the strain at the inner and the outer surface of a shell with these thicknesses at
    /// the start and now [length].
    pub fn strains(
        &self,
        shell: usize,
        [start, now]: [&ShellPositions<'_>; 2],
        [thickness_0, thickness]: [f64; 2],
    ) -> [Strain; 2] {
        let (Some(start), Some(now)) = (self.frame(shell, start), self.frame(shell, now)) else {
            return [[0.0; 6]; 2];
        };
        let Some(inverse) = start.moment(&start.x).try_inverse() else { return [[0.0; 6]; 2] };
        let gradient = now.cross_moment(&now.x, &start.x) * inverse;
        let parts = (gradient * gradient.transpose()).symmetric_eigen();
        let logarithms = Matrix2::from_diagonal(&parts.eigenvalues.map(half_logarithm));
        let membrane = parts.eigenvectors * logarithms * parts.eigenvectors.transpose();
        let bent = now.curvature() - start.curvature();
        let through = match thickness > 0.0 && thickness_0 > 0.0 {
            true => (thickness / thickness_0).ln(),
            false => 0.0,
        };
        [-0.5, 0.5].map(|share| {
            let plane = membrane + share * thickness * bent;
            let local = Matrix3::new(
                plane.m11, plane.m12, 0.0, plane.m21, plane.m22, 0.0, 0.0, 0.0, through,
            );
            components(&(now.axes * local * now.axes.transpose()))
        })
    }

    /// Returns axes, corners and normals of a shell; `None` if it has no area.
    fn frame(&self, shell: usize, positions: &ShellPositions<'_>) -> Option<ShellFrame> {
        let corners = &self.corners[shell];
        let count = if corners[2] == corners[3] { 3 } else { 4 };
        let normal = positions.areas[shell].try_normalize(0.0)?;
        let place: Vec<Vector3<f64>> =
            corners[..count].iter().map(|&n| at(positions.x, n)).collect();
        let side = place[1] - place[0];
        let first = (side - normal * side.dot(&normal)).try_normalize(0.0)?;
        let axes = Matrix3::from_columns(&[first, normal.cross(&first), normal]);
        let centre = place.iter().sum::<Vector3<f64>>() / count as f64;
        let within = |v: Vector3<f64>| {
            let local = axes.transpose() * v;
            [local.x, local.y]
        };
        let x = place.iter().map(|p| within(p - centre)).collect();
        let normals = corners[..count].iter().map(|&node| {
            let mut sum = Vector3::zeros();
            for &other in &self.around[node as usize] {
                let area = positions.areas[other as usize];
                let cosine = area.dot(&normal) / area.norm().max(f64::MIN_POSITIVE);
                if self.parts[other as usize] == self.parts[shell] && cosine.abs() > SMOOTH {
                    sum += area * cosine.signum();
                }
            }
            within(sum.try_normalize(0.0).unwrap_or(normal))
        });
        let normals: Vec<[f64; 2]> = normals.collect();
        Some(ShellFrame { axes, x, normals })
    }
}

/// Axes of a shell as columns, and its corners and their normals in its plane.
struct ShellFrame {
    axes: Matrix3<f64>,
    /// From the centre [length].
    x: Vec<[f64; 2]>,
    normals: Vec<[f64; 2]>,
}

impl ShellFrame {
    /// Returns `sum a_i b_i'` over the corners.
    fn cross_moment(&self, a: &[[f64; 2]], b: &[[f64; 2]]) -> Matrix2<f64> {
        let sum = |i: usize, j: usize| a.iter().zip(b).map(|(a, b)| a[i] * b[j]).sum::<f64>();
        Matrix2::new(sum(0, 0), sum(0, 1), sum(1, 0), sum(1, 1))
    }

    fn moment(&self, x: &[[f64; 2]]) -> Matrix2<f64> {
        self.cross_moment(x, x)
    }

    /// Returns the symmetric gradient of the normals [1/length].
    fn curvature(&self) -> Matrix2<f64> {
        let inverse = self.moment(&self.x).try_inverse().unwrap_or_else(Matrix2::zeros);
        let gradient = self.cross_moment(&self.normals, &self.x) * inverse;
        0.5 * (gradient + gradient.transpose())
    }
}

/// Half the logarithm of an eigenvalue of the left Cauchy-Green tensor.
fn half_logarithm(value: f64) -> f64 {
    0.5 * value.max(f64::MIN_POSITIVE).ln()
}

/// Returns the strain of a solid with these nodes at the start and now.
pub fn of_solid(corners: &[i32], [start, now]: [&[[f32; 3]]; 2]) -> Strain {
    let count = corners.len() as f64;
    let centred = |x: &[[f32; 3]]| {
        let place: Vec<Vector3<f64>> = corners.iter().map(|&n| at(x, n)).collect();
        let centre = place.iter().sum::<Vector3<f64>>() / count;
        place.into_iter().map(|p| p - centre).collect::<Vec<_>>()
    };
    let (start, now) = (centred(start), centred(now));
    let moment = |a: &[Vector3<f64>]| {
        a.iter().zip(&start).map(|(a, b)| a * b.transpose()).sum::<Matrix3<f64>>()
    };
    let Some(inverse) = moment(&start).try_inverse() else { return [0.0; 6] };
    let gradient = moment(&now) * inverse;
    let parts = (gradient * gradient.transpose()).symmetric_eigen();
    let logarithms = Matrix3::from_diagonal(&parts.eigenvalues.map(half_logarithm));
    components(&(parts.eigenvectors * logarithms * parts.eigenvectors.transpose()))
}

fn components(tensor: &Matrix3<f64>) -> Strain {
    [tensor.m11, tensor.m22, tensor.m33, tensor.m12, tensor.m23, tensor.m31].map(|c| c as f32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    /// A strip of quads along x, `n` of them, each `side` long and wide.
    fn strip(n: i32, side: f64) -> (Vec<[i32; 4]>, Vec<[f64; 3]>) {
        let quads = (0..n).map(|i| [2 * i, 2 * i + 2, 2 * i + 3, 2 * i + 1]).collect();
        let node = |k: i32| [f64::from(k / 2) * side, f64::from(k % 2) * side, 0.0];
        (quads, (0..2 * n + 2).map(node).collect())
    }

    fn single(x: &[[f64; 3]]) -> Vec<[f32; 3]> {
        x.iter().map(|x| x.map(|c| c as f32)).collect()
    }

    fn strains(quads: &[[i32; 4]], x: [&[[f64; 3]]; 2], t: [f64; 2], shell: usize) -> [Strain; 2] {
        let parts = vec![0; quads.len()];
        let [start, now] = x.map(single);
        let all = ShellStrains::new(quads, &parts, &vec![true; quads.len()], start.len());
        all.strains(shell, [&all.positions(&start), &all.positions(&now)], t)
    }

    /// A stretch by 1.5 along a direction, after a rotation: ln 1.5 along it, and the thinning.
    #[test]
    fn stretched_shells_have_the_logarithmic_strain() {
        let (quads, x) = strip(3, 2.0);
        let (s, c) = 0.6_f64.sin_cos();
        let turn = |[x, y, z]: [f64; 3]| [c * x - s * y, s * x + c * y, z];
        let now: Vec<[f64; 3]> = x.iter().map(|&[x, y, z]| turn([1.5 * x, y, z])).collect();
        let [inner, outer] = strains(&quads, [&x, &now], [1.0, 0.8], 1);
        let h = 1.5_f64.ln();
        let wanted = [h * c * c, h * s * s, 0.8_f64.ln(), h * s * c, 0.0, 0.0];
        for (found, wanted) in inner.iter().chain(&outer).zip(wanted.iter().chain(&wanted)) {
            assert!((f64::from(*found) - wanted).abs() < 1e-6, "{inner:?} {outer:?}: {wanted}");
        }
    }

    /// A strip that is bent to a full circle: plus and minus t/(2 R) along the circle, and none at
    /// a shell that was bent from the start.
    #[test]
    fn bent_shells_have_strains_of_both_signs() {
        let (quads, x) = strip(60, 1.0);
        let radius = 60.0 / TAU;
        let bent = |&[x, y, _]: &[f64; 3]| {
            let (s, c) = (x / radius).sin_cos();
            // Chords of the length of the sides, as far as membrane strain matters.
            [radius * s, y, radius * (1.0 - c)]
        };
        let now: Vec<[f64; 3]> = x.iter().map(bent).collect();
        let [inner, outer] = strains(&quads, [&x, &now], [0.5, 0.5], 30);
        // The normals of the strip are along +z, inside the circle: the outer surface is shorter.
        let wanted = 0.25 / radius;
        assert!((f64::from(inner[0]) - wanted).abs() < 0.03 * wanted, "{inner:?} {wanted}");
        assert!((f64::from(outer[0]) + wanted).abs() < 0.03 * wanted, "{outer:?} {wanted}");
        let [inner, outer] = strains(&quads, [&now, &now], [0.5, 0.5], 7);
        assert!(inner.iter().chain(&outer).all(|h| h.abs() < 1e-6), "{inner:?} {outer:?}");
    }

    /// A fold of 90 degrees in the mesh has no curvature.
    #[test]
    fn folds_have_no_curvature() {
        let (quads, x) = strip(2, 1.0);
        let fold = |&[x, y, _]: &[f64; 3]| if x > 1.0 { [1.0, y, x - 1.0] } else { [x, y, 0.0] };
        let folded: Vec<[f64; 3]> = x.iter().map(fold).collect();
        let [inner, outer] = strains(&quads, [&folded, &folded], [0.5, 0.5], 0);
        assert_eq!(inner, outer);
        let [inner, outer] = strains(&quads, [&x, &folded], [0.5, 0.5], 0);
        assert!(inner.iter().chain(&outer).all(|h| h.abs() < 1e-6), "{inner:?} {outer:?}");
    }

    /// A cube in simple shear: the strain of Hencky in closed form.
    #[test]
    fn sheared_solids_have_the_strain_of_hencky() {
        let cube: Vec<[f64; 3]> =
            (0..8).map(|k| [k & 1, k >> 1 & 1, k >> 2].map(|c: i32| f64::from(c))).collect();
        let gamma = 0.8;
        let sheared: Vec<[f64; 3]> = cube.iter().map(|&[x, y, z]| [x + gamma * y, y, z]).collect();
        let corners: Vec<i32> = (0..8).collect();
        let found = of_solid(&corners, [&single(&cube), &single(&sheared)]);
        // ln of the larger principal stretch, along the angle a with tan 2a = 2/gamma.
        let h = (0.5 * gamma + (1.0 + 0.25 * gamma * gamma).sqrt()).ln();
        let double = (2.0_f64).atan2(gamma);
        let wanted = [h * double.cos(), -h * double.cos(), 0.0, h * double.sin(), 0.0, 0.0];
        for (found, wanted) in found.iter().zip(wanted) {
            assert!((f64::from(*found) - wanted).abs() < 1e-6, "{found} {wanted}");
        }
    }
}
