//! The rubber of shells against closed forms, and against the same rubber of solids.

use crate::materials::testing::material;
use crate::materials::{PlaneStress, Points, SolidPoint, build, build_solid};
use crumple_proto::partition::Material;

const A: f64 = 0.3;
const B: f64 = 0.1;
/// Steps of a path; `stretch` has an error of the strain of a step squared.
const STEPS: u32 = 2000;

fn rubber(nu: f64) -> Material {
    material("mooney_rivlin", &[("a", A), ("b", B), ("poisson", nu)], &[])
}

fn shell(nu: f64) -> Box<dyn PlaneStress> {
    build(&rubber(nu)).map_err(|problems| format!("{problems:?}")).unwrap()
}

/// Advances a point by a strain increment and returns the strain through the thickness.
fn advance(law: &dyn PlaneStress, state: &mut [f64; 7], strain: [f64; 3]) -> f64 {
    let mut thinning = [0.0];
    let points = Points { state, strain: &[strain], thickness_strain: &mut thinning };
    law.update_one(points, 1.0);
    thinning[0]
}

/// Nearly incompressible rubber has `2 (l^2 - l^-4) (a + b l^2)` at a stretch l in both directions,
/// and `2 (l^2 - l^-2) (a + b)` along x at a stretch of x alone; the thickness keeps the volume.
#[test]
fn stress_is_that_of_closed_forms() {
    const NU: f64 = 0.499999;
    let law = shell(NU);
    for stretch in [0.6_f64, 0.95, 1.2, 2.0, 3.0] {
        let l2 = stretch * stretch;
        let both = 2.0 * (l2 - l2.powi(-2)) * (A + B * l2);
        let one = 2.0 * (l2 - 1.0 / l2) * (A + B);
        for (share, wanted) in [(1.0, both), (0.0, one)] {
            let step = stretch.ln() / f64::from(STEPS);
            let (mut state, mut thinning) = ([0.0; 7], 0.0);
            for _ in 0..STEPS {
                thinning += advance(&*law, &mut state, [step, share * step, 0.0]);
            }
            // The volume changes by about the stress over K, 2e-6, and a step is not infinitesimal.
            assert!(
                (state[0] - wanted).abs() < 1e-4 * wanted.abs(),
                "{stretch}, {share}: {} for {wanted}",
                state[0]
            );
            let volume = thinning + (1.0 + share) * stretch.ln();
            assert!(volume.abs() < 2e-5, "{stretch}, {share}: volume strain {volume}");
        }
    }
}

/// A solid with the strains of the shell and the strain through its thickness has the stress of the
/// shell, and none through the thickness; also with shear and far from incompressibility.
#[test]
fn a_solid_with_the_same_strains_has_the_same_stress() {
    for nu in [0.4999, 0.495, 0.465] {
        let law = shell(nu);
        let solid = build_solid(&rubber(nu)).map_err(|problems| format!("{problems:?}")).unwrap();
        let (mut plane, mut cube) = ([0.0; 7], [0.0; 13]);
        for k in 0..STEPS {
            let turn = 4.0 * f64::from(k) / f64::from(STEPS);
            let strain = [1e-3 * turn.cos(), 0.6e-3 * (2.0 * turn).cos(), 0.8e-3 * turn.sin()];
            let through = advance(&*law, &mut plane, strain);
            let whole = [strain[0], strain[1], through, strain[2], 0.0, 0.0];
            solid.update_one(SolidPoint { state: &mut cube, strain: &whole }, 1.0);
        }
        let largest = plane[..3].iter().fold(0.0_f64, |most, s| most.max(s.abs()));
        // Through the thickness the logarithm of the stretch and the rational stretch of a step
        // differ by a twelfth of its cube, 1e-10 for each step; K is up to 5000 times G.
        for (found, wanted) in [(cube[0], plane[0]), (cube[1], plane[1]), (cube[3], plane[2])] {
            assert!((found - wanted).abs() < 2e-3 * largest, "{nu}: {found} for {wanted}");
        }
        assert!(cube[2].abs() < 2e-3 * largest, "{nu}: {} through the thickness", cube[2]);
    }
}
