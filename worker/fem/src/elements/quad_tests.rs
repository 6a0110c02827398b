//! Helper for tests of quads: kernels on lanes against kernels on scalars.

use super::super::testing::Noise;
use super::super::{Element, ElementFields};
use super::*;
use crate::columns::HistoryColumns;
use crumple_math::lanes::{LANES, Lane};
use crumple_proto::job::Precision;
use crumple_proto::mesh::OwnSection;

/// Runs one kernel on lanes and on scalars through the same motions, small in the first lane and
/// large in the last, and compares bits; returns the fields of the lanes.
pub fn singles_and_lanes(
    shell: &dyn Element,
    lanes_of: impl Fn(&QuadGeometry<Lane>, &QuadModes<Lane>, &mut [Lane]) -> QuadResponse<Lane>,
    one_of: impl Fn(&QuadGeometry<f64>, &QuadModes<f64>, &mut [f64]) -> QuadResponse<f64>,
) -> [ElementFields; LANES] {
    let mut noise = Noise(41);
    let mut fresh = vec![0.0; shell.columns()];
    shell.start(&mut fresh, OwnSection::default());
    let mut wide: Vec<Lane> = fresh.iter().map(|&c| Lane::splat(c)).collect();
    let mut alone = vec![fresh; LANES];
    for _ in 0..40 {
        let mut random = |size: f64| -> [f64; LANES] {
            let sizes = [0.0, 0.01, 1.0, 10.0];
            std::array::from_fn(|lane| size * sizes[lane] * noise.next())
        };
        let shape = [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [0.0, 0.1, 0.05]];
        let x: [[[f64; LANES]; 3]; 3] = shape.map(|row| row.map(|c| random(0.002).map(|r| c + r)));
        let v: [[[f64; LANES]; 3]; 3] =
            std::array::from_fn(|_| std::array::from_fn(|_| random(1e-3)));
        let w: [[[f64; LANES]; 3]; 4] =
            std::array::from_fn(|_| std::array::from_fn(|_| random(1e-3)));
        let to = |v: [f64; LANES]| Lane::new(v);
        let geometry = QuadGeometry::new(&x.map(|r| r.map(to)));
        let modes = QuadModes { v: v.map(|r| r.map(to)), w: w.map(|r| r.map(to)) };
        let lanes = lanes_of(&geometry, &modes, &mut wide);
        for (lane, history) in alone.iter_mut().enumerate() {
            let to = |v: [f64; LANES]| v[lane];
            let geometry = QuadGeometry::new(&x.map(|r| r.map(to)));
            let modes = QuadModes { v: v.map(|r| r.map(to)), w: w.map(|r| r.map(to)) };
            let one = one_of(&geometry, &modes, history);
            let pairs =
                lanes.force.iter().zip(&one.force).chain(lanes.moment.iter().zip(&one.moment));
            for (many, one) in pairs.flat_map(|(many, one)| many.iter().zip(one)) {
                assert_eq!(many.as_array()[lane].to_bits(), one.to_bits());
            }
            for (many, one) in wide.iter().zip(history) {
                assert_eq!(many.as_array()[lane].to_bits(), one.to_bits());
            }
            assert_eq!(
                lanes.totals.stable_dt.as_array()[lane].to_bits(),
                one.totals.stable_dt.to_bits()
            );
            assert_eq!(
                lanes.totals.internal.as_array()[lane].to_bits(),
                one.totals.internal.to_bits()
            );
            assert_eq!(
                lanes.totals.hourglass.as_array()[lane].to_bits(),
                one.totals.hourglass.to_bits()
            );
        }
    }
    let square = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];
    let mut columns = HistoryColumns::new(Precision::Double, LANES, shell.columns());
    alone.iter().enumerate().for_each(|(lane, state)| columns.set(lane, state));
    std::array::from_fn(|lane| shell.fields(columns.element(lane), &square))
}
