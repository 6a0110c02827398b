//! Cross sections of beams as fibres.
//!
//! Strips have two Gauss points in each half, so that area, second moments and the plastic moment
//! of a rectangle are exact. Rings have 16 points, at the middles of equal angles: area and second
//! moments are exact, the plastic moment is `(pi/16)/sin(pi/16)`, 0.6 %, too large. General
//! sections have four points at the radii of gyration: area and second moments are exact, but the
//! plastic moment of the true section is unknown.

use crumple_proto::job::{BeamInput, BeamSection};
use std::f64::consts::{PI, TAU};

/// Number of points around a ring.
const AROUND: usize = 16;

/// A fibre of a cross section.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fibre {
    /// Coordinates along the second and third axis [length].
    pub y: f64,
    /// See `y`.
    pub z: f64,
    /// Area [length^2].
    pub area: f64,
    /// Shear strain around the axis per twist [length]; 0 if fibres do not carry the torque.
    pub arm: f64,
}

/// A cross section.
#[derive(Clone, Debug)]
pub struct FibreSection {
    /// Fibres of the section.
    pub fibres: Vec<Fibre>,
    /// Torsion constant for an elastic torque in addition to that of the fibres [length^4].
    pub torsion: f64,
}

/// Returns middles and lengths of two Gauss points in each half of a strip from `from` to `to`.
fn strip(from: f64, to: f64) -> [(f64, f64); 4] {
    let (quarter, middle) = (0.25 * (to - from), 0.5 * (from + to));
    let off = 1.0 / f64::sqrt(3.0);
    [-1.0 - off, -1.0 + off, 1.0 - off, 1.0 + off].map(|at| (middle + at * quarter, quarter))
}

/// Returns the torsion constant of a rectangle, within 4e-3 (Roark & Young 1975, table 20).
fn rectangle_torsion(a: f64, b: f64) -> f64 {
    let (long, short) = (a.max(b), a.min(b));
    let ratio = short / long;
    long * short.powi(3) * (1.0 / 3.0 - 0.21 * ratio * (1.0 - ratio.powi(4) / 12.0))
}

impl FibreSection {
    /// Builds the section from the job, whose values have been checked.
    pub fn new(job: &BeamInput) -> Self {
        let (h, w) = (0.5 * job.height, 0.5 * job.width);
        match job.section {
            BeamSection::Rectangle => Self {
                fibres: rectangle([-h, h], [-w, w]),
                torsion: rectangle_torsion(job.height, job.width),
            },
            BeamSection::I => {
                let inner = h - job.flange;
                let mut fibres = rectangle([-h, -inner], [-w, w]);
                fibres.extend(rectangle([-inner, inner], [-0.5 * job.web, 0.5 * job.web]));
                fibres.extend(rectangle([inner, h], [-w, w]));
                // Torsion constant of thin walls.
                let torsion =
                    (2.0 * job.width * job.flange.powi(3) + 2.0 * inner * job.web.powi(3)) / 3.0;
                Self { fibres, torsion }
            }
            BeamSection::General => {
                Self { fibres: gyration(job.area, job.second_moments), torsion: job.torsion }
            }
            BeamSection::Tube => {
                let inside = if job.wall > 0.0 { job.radius - job.wall } else { 0.0 };
                Self { fibres: tube(inside, job.radius), torsion: 0.0 }
            }
        }
    }

    /// Returns the area [length^2], the second moments for bending about the second and the third
    /// axis, and the torsion constant [length^4].
    pub fn moments(&self) -> [f64; 4] {
        let sum = |of: fn(&Fibre) -> f64| self.fibres.iter().map(|f| f.area * of(f)).sum::<f64>();
        [
            sum(|_| 1.0),
            sum(|f| f.z * f.z),
            sum(|f| f.y * f.y),
            self.torsion + sum(|f| f.arm * f.arm),
        ]
    }
}

fn rectangle(y: [f64; 2], z: [f64; 2]) -> Vec<Fibre> {
    let (rows, columns) = (strip(y[0], y[1]), strip(z[0], z[1]));
    let cell =
        |&(y, dy): &(f64, f64), &(z, dz): &(f64, f64)| Fibre { y, z, area: dy * dz, arm: 0.0 };
    rows.iter().flat_map(|row| columns.iter().map(|column| cell(row, column))).collect()
}

/// Returns four fibres with these moments, for bending about the second and the third axis.
fn gyration(area: f64, [about_y, about_z]: [f64; 2]) -> Vec<Fibre> {
    let (y, z) = ((about_z / area).sqrt(), (about_y / area).sqrt());
    [[y, z], [-y, z], [-y, -z], [y, -z]]
        .map(|[y, z]| Fibre { y, z, area: 0.25 * area, arm: 0.0 })
        .to_vec()
}

/// Returns two rings at the Gauss points of the area integral over r dr, each with the area of its
/// weight.
fn tube(inside: f64, outside: f64) -> Vec<Fibre> {
    let (middle, half) = (0.5 * (inside + outside), 0.5 * (outside - inside));
    let off = half / f64::sqrt(3.0);
    let ring = |r: f64| {
        (0..AROUND).map(move |k| {
            let angle = (k as f64 + 0.5) * TAU / AROUND as f64;
            Fibre {
                y: r * angle.cos(),
                z: r * angle.sin(),
                area: half * r * 2.0 * PI / AROUND as f64,
                arm: r,
            }
        })
    };
    ring(middle - off).chain(ring(middle + off)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_within(ours: f64, exact: f64, within: f64) {
        assert!((ours / exact - 1.0).abs() < within, "{ours} {exact}");
    }

    fn beam(section: BeamSection) -> BeamInput {
        BeamInput {
            section,
            height: 6.0,
            width: 4.0,
            flange: 0.5,
            web: 0.3,
            radius: 5.0,
            wall: 1.0,
            area: 7.0,
            second_moments: [11.0, 13.0],
            torsion: 17.0,
            shear_areas: [0.0; 2],
            weld: None,
            contact_radius: None,
            preload: Vec::new(),
            preload_bending: false,
        }
    }

    /// Returns the plastic moment over the yield stress for bending about the third axis.
    fn plastic(s: &FibreSection) -> f64 {
        s.fibres.iter().map(|f| f.area * f.y.abs()).sum()
    }

    #[test]
    fn sections_have_their_moments() {
        let s = FibreSection::new(&beam(BeamSection::Rectangle));
        let [a, iy, iz, j] = s.moments();
        for (ours, exact) in [(a, 24.0), (iy, 32.0), (iz, 72.0), (plastic(&s), 36.0)] {
            assert_within(ours, exact, 1e-14);
        }
        assert_within(j, 0.196 * 6.0 * 64.0, 4e-3); // Timoshenko & Goodier, a/b = 1.5

        let s = FibreSection::new(&beam(BeamSection::I));
        let [a, iy, iz, _] = s.moments();
        assert_within(a, 2.0 * 2.0 + 5.0 * 0.3, 1e-14);
        assert_within(iz, (4.0 * 216.0 - 3.7 * 125.0) / 12.0, 1e-14);
        assert_within(iy, (2.0 * 0.5 * 64.0 + 5.0 * 0.027) / 12.0, 1e-14);
        assert_within(plastic(&s), 2.0 * 2.0 * 2.75 + 0.3 * 6.25, 1e-14);

        for (ours, exact) in FibreSection::new(&beam(BeamSection::General))
            .moments()
            .into_iter()
            .zip([7.0, 11.0, 13.0, 17.0])
        {
            assert_within(ours, exact, 1e-14);
        }
        let truss =
            BeamInput { second_moments: [0.0; 2], torsion: 0.0, ..beam(BeamSection::General) };
        assert_eq!(FibreSection::new(&truss).moments(), [7.0, 0.0, 0.0, 0.0]);

        for wall in [1.0, 0.0] {
            let s = FibreSection::new(&BeamInput { wall, ..beam(BeamSection::Tube) });
            let inside: f64 = if wall > 0.0 { 4.0 } else { 0.0 };
            let [a, iy, iz, j] = s.moments();
            assert_within(a, PI * (25.0 - inside.powi(2)), 1e-14);
            let i = 0.25 * PI * (625.0 - inside.powi(4));
            for (ours, exact) in [(iy, i), (iz, i), (j, 2.0 * i)] {
                assert_within(ours, exact, 1e-13);
            }
            assert_within(plastic(&s), 4.0 / 3.0 * (125.0 - inside.powi(3)), 0.0066);
        }
    }
}
