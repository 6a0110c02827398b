//! Pressure of an explosion in free air or on the ground on a face.
//!
//! Kingery & Bulmash 1984 (ARBRL-TR-02555) give the wave of a charge of TNT by polynomials of the
//! scaled distance `Z = R/W^(1/3)` [m/kg^(1/3)], each a base-10 logarithm over `U = a + b log10 Z`:
//! peak overpressures [kPa] and impulses per area and `W^(1/3)` [kPa ms] of the incident wave and
//! of the wave reflected by a rigid wall, arrival and duration of the positive phase over `W^(1/3)`
//! [ms]. From the arrival on each wave is (Friedlander)
//! ```text
//! p(s) = P (1 - s) exp(-k s),   s = (t - t_a)/t_d
//! ```
//! with k from its impulse, `I/(P t_d) = (k - 1 + exp(-k))/k^2`. The pressure on a face whose
//! normal makes the angle theta with the direction to the charge is (Randers-Pehrson & Bannister
//! 1997, ARL-TR-1310)
//! ```text
//! p = p_r cos^2 theta + p_i (1 + cos^2 theta - 2 cos theta)   for cos theta > 0, else p_i
//! ```
//! Distance and angle are those at the start. After the positive phase the pressure is below zero,
//! but not below that of a vacuum, 101.325 kPa less than the air; or it is zero on demand.
//! Shielding, the ground in the path of an air burst, and bodies behind others are not considered.
//!
//! The polynomials hold from Z = 0.0531 (air) or 0.0674 (ground) to 40, the durations from 0.147
//! and 0.178. Nearer faces get the values at these ends; beyond 40 there is no pressure. Very near
//! the charge the impulse of the tables is more than that of a wave that falls linearly: this wave
//! is used. After the positive phase k is at least 1.

use crumple_proto::loads::Blast;
use nalgebra::Vector3;

/// A polynomial: a and b of U, coefficients of its powers, upper end of its range [m/kg^(1/3)].
struct BlastFit {
    u: [f64; 2],
    of: &'static [f64],
    to: f64,
}

/// BlastFits of the waves of one kind of burst. Several fits follow each other.
struct BlastFits {
    /// Lower ends of the range, and of that of durations [m/kg^(1/3)].
    from: f64,
    durations_from: f64,
    incident_pressure: BlastFit,
    reflected_pressure: BlastFit,
    incident_impulse: [BlastFit; 2],
    reflected_impulse: BlastFit,
    arrival: BlastFit,
    duration: [BlastFit; 3],
}

/// Upper end of the range [m/kg^(1/3)].
const FARTHEST: f64 = 40.0;
/// Pressure of the air [kPa].
const AIR_PRESSURE: f64 = 101.325;

/// Returns the distances between which the tables of an explosion hold [length].
pub fn range(blast: &Blast) -> [f64; 2] {
    let fits = if blast.on_ground { &GROUND } else { &AIR };
    [fits.from, FARTHEST].map(|z| z * blast.mass.cbrt() / blast.si[0])
}

const AIR: BlastFits = BlastFits {
    from: 0.0531,
    durations_from: 0.147,
    incident_pressure: BlastFit {
        u: [-0.214362789151, 1.35034249993],
        of: &[
            2.611368669,
            -1.69012801396,
            0.00804973591951,
            0.336743114941,
            -0.00516226351334,
            -0.0809228619888,
            -0.00478507266747,
            0.00793030472242,
            0.0007684469735,
        ],
        to: FARTHEST,
    },
    reflected_pressure: BlastFit {
        u: [-0.214362789151, 1.35034249993],
        of: &[
            3.22958031387,
            -2.21400538997,
            0.035119031446,
            0.657599992109,
            0.0141818951887,
            -0.243076636231,
            -0.0158699803158,
            0.0492741184234,
            0.00227639644004,
            -0.00397126276058,
        ],
        to: FARTHEST,
    },
    incident_impulse: [
        BlastFit {
            u: [2.34723921354, 3.24299066475],
            of: &[2.38830516757, -0.443749377691, 0.168825414684, 0.0348138030308, -0.010435192824],
            to: 0.792,
        },
        BlastFit {
            u: [-1.75305660315, 2.30629231803],
            of: &[
                1.55197227115,
                -0.40463292088,
                -0.0142721946082,
                0.00912366316617,
                -0.0006750681404,
                -0.00800863718901,
                0.00314819515931,
                0.00152044783382,
                -0.0007470265899,
            ],
            to: FARTHEST,
        },
    ],
    reflected_impulse: BlastFit {
        u: [-0.204004553231, 1.37882996018],
        of: &[2.55875660396, -0.903118886091, 0.101771877942, -0.0242139751146],
        to: FARTHEST,
    },
    arrival: BlastFit {
        u: [-0.253273111999, 1.37407043777],
        of: &[
            0.0720707787637,
            1.36456871214,
            -0.0570035692784,
            -0.182832224796,
            0.0118851436014,
            0.0432648687627,
            -0.0007997367834,
            -0.00436073555033,
        ],
        to: FARTHEST,
    },
    duration: [
        BlastFit {
            u: [2.26367268496, 5.11588554305],
            of: &[
                -0.686608550419,
                0.164953518069,
                0.127788499497,
                0.00291430135946,
                0.00187957449227,
                0.0173413962543,
                0.00269739758043,
                -0.00361976502798,
                -0.00100926577934,
            ],
            to: 0.888,
        },
        BlastFit {
            u: [-1.33361206714, 9.2996288611],
            of: &[
                0.23031841078,
                -0.0297944268969,
                0.0306329542941,
                0.0183405574074,
                -0.0173964666286,
                -0.00106321963576,
                0.0056206003128,
                0.0001618217499,
                -0.0006860188944,
            ],
            to: 2.28,
        },
        BlastFit {
            u: [-3.13005805346, 3.1524725364],
            of: &[
                0.621036276475,
                0.0967031995552,
                -0.00801302059667,
                0.00482705779732,
                0.00187587272287,
                -0.00246738509321,
                -0.000841116668,
                0.0006193291052,
            ],
            to: FARTHEST,
        },
    ],
};

const GROUND: BlastFits = BlastFits {
    from: 0.0674,
    durations_from: 0.178,
    incident_pressure: BlastFit {
        u: [-0.214362789151, 1.35034249993],
        of: &[
            2.78076916577,
            -1.6958988741,
            -0.154159376846,
            0.514060730593,
            0.0988534365274,
            -0.293912623038,
            -0.0268112345019,
            0.109097496421,
            0.00162846756311,
            -0.0214631030242,
            0.0001456723382,
            0.00167847752266,
        ],
        to: FARTHEST,
    },
    reflected_pressure: BlastFit {
        u: [-0.240657322658, 1.36637719229],
        of: &[
            3.40283217581,
            -2.21030870597,
            -0.218536586295,
            0.895319589372,
            0.24989009775,
            -0.569249436807,
            -0.11791682383,
            0.224131161411,
            0.0245620259375,
            -0.0455116002694,
            -0.0019093073888,
            0.00361471193389,
        ],
        to: FARTHEST,
    },
    incident_impulse: [
        BlastFit {
            u: [2.06761908721, 3.0760329666],
            of: &[
                2.52455620925,
                -0.502992763686,
                0.171335645235,
                0.0450176963051,
                -0.0118964626402,
            ],
            to: 0.955,
        },
        BlastFit {
            u: [-1.94708846747, 2.40697745406],
            of: &[
                1.67281645863,
                -0.384519026965,
                -0.0260816706301,
                0.00595798753822,
                0.0145445261077,
                -0.00663289334734,
                -0.00284189327204,
                0.0013644816227,
            ],
            to: FARTHEST,
        },
    ],
    reflected_impulse: BlastFit {
        u: [-0.246208804814, 1.33422049854],
        of: &[2.70588058103, -0.949516092853, 0.112136118689, -0.0250659183287],
        to: FARTHEST,
    },
    arrival: BlastFit {
        u: [-0.202425716178, 1.37784223635],
        of: &[
            -0.0591634288046,
            1.35706496258,
            0.052492798645,
            -0.196563954086,
            -0.0601770052288,
            0.0696360270891,
            0.0215297490092,
            -0.0161658930785,
            -0.00232531970294,
            0.00147752067524,
        ],
        to: FARTHEST,
    },
    duration: [
        BlastFit {
            u: [1.92946154068, 5.25099193925],
            of: &[
                -0.614227603559,
                0.130143717675,
                0.134872511954,
                0.0391574276906,
                -0.00475933664702,
                -0.00428144598008,
            ],
            to: 1.01,
        },
        BlastFit {
            u: [-2.12492525216, 9.2996288611],
            of: &[
                0.315409245784,
                -0.0297944268976,
                0.030632954288,
                0.0183405574086,
                -0.0173964666211,
                -0.00106321963633,
                0.00562060030977,
                0.0001618217499,
                -0.0006860188944,
            ],
            to: 2.78,
        },
        BlastFit {
            u: [-3.53626218091, 3.46349745571],
            of: &[
                0.686906642409,
                0.0933035304009,
                -0.0005849420883,
                -0.00226884995013,
                -0.00295908591505,
                0.00148029868929,
            ],
            to: FARTHEST,
        },
    ],
};

impl BlastFit {
    fn at(&self, z: f64) -> f64 {
        let u = self.u[0] + self.u[1] * z.log10();
        10.0_f64.powf(self.of.iter().rev().fold(0.0, |sum, c| sum * u + c))
    }
}

/// Returns the value of the fit in whose range z is.
fn of_range(fits: &[BlastFit], z: f64) -> f64 {
    let fit = fits.iter().find(|fit| z <= fit.to).or(fits.last());
    fit.map_or(0.0, |fit| fit.at(z))
}

/// A pressure over time as a Friedlander wave.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Wave {
    /// Peak [force/length^2] and k.
    peak: f64,
    decay: f64,
}

impl Wave {
    /// Creates the wave with this peak and impulse, both in units of the peak times the duration.
    fn new(peak: f64, impulse: f64, duration: f64) -> Self {
        let share = impulse / (peak * duration);
        // The share falls from one half with k; it is nearly 1/k for large k.
        let of = |k: f64| if k < 1e-4 { 0.5 - k / 6.0 } else { (k - 1.0 + (-k).exp()) / (k * k) };
        let (mut low, mut high) = (0.0, 1.0 / share.max(1e-12) + 1.0);
        for _ in 0..100 {
            let middle = 0.5 * (low + high);
            if of(middle) > share { low = middle } else { high = middle }
        }
        Self { peak, decay: if share >= 0.5 { 0.0 } else { 0.5 * (low + high) } }
    }

    fn at(&self, s: f64) -> f64 {
        // A wave with little decay would have a pressure below zero for very long.
        let after = (s - 1.0).max(0.0) * (1.0 - self.decay).max(0.0);
        self.peak * (1.0 - s) * (-self.decay * s - after).exp()
    }
}

/// Pressure of an explosion on one face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlastOnFace {
    /// Time at which the wave arrives, and duration of its positive phase [time].
    arrival: f64,
    duration: f64,
    incident: Wave,
    reflected: Wave,
    /// Cosine of theta.
    cosine: f64,
    /// Least pressure [force/length^2]: that of a vacuum, or 0.
    least: f64,
}

impl BlastOnFace {
    /// Creates the pressure on a face with this middle [length] and outward normal, of any length;
    /// `None` if it is too far away.
    pub fn new(blast: &Blast, middle: [f64; 3], normal: [f64; 3]) -> Option<Self> {
        let [metre, second, pascal] = blast.si;
        let to_charge = Vector3::from(blast.position) - Vector3::from(middle);
        let distance = to_charge.norm();
        let size = blast.mass.cbrt();
        let fits = if blast.on_ground { &GROUND } else { &AIR };
        let z = (distance * metre / size).max(fits.from);
        if z > FARTHEST {
            return None;
        }
        // kPa and ms.
        let (pressure, time) = (1e3 / pascal, 1e-3 / second);
        let duration = size * of_range(&fits.duration, z.max(fits.durations_from));
        let wave = |peak: f64, impulse: f64| {
            let Wave { peak, decay } = Wave::new(peak, size * impulse, duration);
            Wave { peak: peak * pressure, decay }
        };
        let normal = Vector3::from(normal);
        let cosine = normal.dot(&to_charge) / (normal.norm() * distance);
        Some(Self {
            arrival: blast.time + time * size * fits.arrival.at(z),
            duration: time * duration,
            incident: wave(fits.incident_pressure.at(z), of_range(&fits.incident_impulse, z)),
            reflected: wave(fits.reflected_pressure.at(z), fits.reflected_impulse.at(z)),
            cosine: if cosine.is_finite() { cosine } else { 0.0 },
            least: if blast.suction { -AIR_PRESSURE * pressure } else { 0.0 },
        })
    }

    /// Returns the pressure at a time [force/length^2].
    pub fn pressure(&self, time: f64) -> f64 {
        let s = (time - self.arrival) / self.duration;
        if s < 0.0 {
            return 0.0;
        }
        let (incident, c) = (self.incident.at(s), self.cosine);
        let pressure = match c <= 0.0 {
            true => incident,
            false => self.reflected.at(s) * c * c + incident * (1.0 + c * c - 2.0 * c),
        };
        pressure.max(self.least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn blast(mass: f64, on_ground: bool) -> Blast {
        let si = [1.0, 1.0, 1.0];
        Blast { mass, position: [0.0; 3], time: 0.0, on_ground, suction: true, si }
    }

    /// Ranges that follow each other meet within 2.5 %, as in the report. Far away the reflected
    /// wave is twice the incident one, near the charge up to thirteen times.
    #[test]
    fn ranges_meet_and_far_waves_are_acoustic() {
        for fits in [&AIR, &GROUND] {
            let pairs = fits.duration.windows(2).chain(fits.incident_impulse.windows(2));
            for pair in pairs {
                let [one, other] = [0, 1].map(|k| pair[k].at(pair[0].to));
                assert!((one / other - 1.0).abs() < 0.025, "{one} {other}");
            }
            let ratio = |z: f64| fits.reflected_pressure.at(z) / fits.incident_pressure.at(z);
            assert!((ratio(FARTHEST) - 2.0).abs() < 0.1, "{}", ratio(FARTHEST));
            assert!((11.0..14.0).contains(&ratio(fits.from)), "{}", ratio(fits.from));
        }
    }

    /// Swisdak 1994 (Simplified Kingery airblast calculations): 10,000 kg at 500 m on the ground,
    /// incident and reflected peak, arrival, duration and impulse.
    #[test]
    fn waves_are_those_of_the_simplified_formulas() {
        let (size, z) = (1e4_f64.cbrt(), 500.0 / 1e4_f64.cbrt());
        let close = |value: f64, wanted: f64, tolerance: f64, what: &str| {
            assert!((value / wanted - 1.0).abs() < tolerance, "{what}: {value} for {wanted}");
        };
        close(GROUND.incident_pressure.at(z), 5.05496, 0.02, "incident [kPa]");
        close(GROUND.reflected_pressure.at(z), 10.2446, 0.02, "reflected [kPa]");
        close(size * GROUND.arrival.at(z), 1276.17, 0.02, "arrival [ms]");
        close(size * of_range(&GROUND.duration, z), 133.233, 0.03, "duration [ms]");
        close(size * of_range(&GROUND.incident_impulse, z), 295.877, 0.02, "impulse [kPa ms]");
    }

    /// The pressure over the positive phase has the impulse of the tables, by Simpson's rule; at
    /// right angles that of the reflected wave, edgewise and behind that of the incident one. Units
    /// mm, ms, kg: a pressure of 1 is 1 GPa.
    #[test]
    fn the_impulse_is_that_of_the_tables() {
        let mut charge = blast(2.0, false);
        charge.si = [1e-3, 1e-3, 1e9];
        charge.time = 3.0;
        let size = 2.0_f64.cbrt();
        for (normal, reflected) in
            [([1.0, 0.0, 0.0], true), ([0.0, 2.0, 0.0], false), ([-1.0, 0.0, 0.0], false)]
        {
            let on = BlastOnFace::new(&charge, [-1500.0, 0.0, 0.0], normal).unwrap();
            let z = 1.5 / size;
            let impulse = if reflected {
                AIR.reflected_impulse.at(z)
            } else {
                of_range(&AIR.incident_impulse, z)
            };
            let n = 20_000;
            let h = on.duration / f64::from(n);
            let of = |i: i32| match i {
                0 => 1.0,
                _ if i == n => 1.0,
                _ if i % 2 == 1 => 4.0,
                _ => 2.0,
            };
            let at = |i: i32| on.pressure(on.arrival + h * f64::from(i) * (1.0 - 1e-12));
            let sum: f64 = (0..=n).map(|i| of(i) * at(i) * h / 3.0).sum();
            let wanted = size * impulse * 1e-6;
            assert!((sum / wanted - 1.0).abs() < 1e-4, "{normal:?}: {sum} for {wanted}");
            assert_eq!(on.pressure(on.arrival - 1e-9), 0.0);
            assert!(on.pressure(on.arrival + 1.5 * on.duration) < 0.0);
            assert!(((on.arrival - 3.0) / (size * AIR.arrival.at(z)) - 1.0).abs() < 1e-12);
        }
    }

    /// At no distance and angle the pressure is below that of a vacuum, and it returns to that of
    /// the air.
    #[test]
    fn suction_is_at_most_that_of_a_vacuum() {
        for on_ground in [false, true] {
            for step in 0..60 {
                let distance = 0.05 * 1.118_f64.powi(step);
                for normal in [[-1.0, 0.0, 0.0], [-1.0, 1.0, 0.0], [1.0, 0.0, 0.0]] {
                    let charge = blast(1.0, on_ground);
                    let Some(on) = BlastOnFace::new(&charge, [distance, 0.0, 0.0], normal) else {
                        continue;
                    };
                    let at = |i: u32| on.pressure(on.arrival + 0.01 * f64::from(i) * on.duration);
                    let least = (0..5000).map(at).fold(0.0, f64::min);
                    assert!(least >= -1e3 * AIR_PRESSURE, "{distance}: {least}");
                    let late = on.pressure(on.arrival + 1e3 * on.duration).abs();
                    // k is at least 1 there: exp(-999) of the peak, or no pressure.
                    assert!(late < 1e-3 * on.reflected.peak, "{distance}: {late}");
                }
            }
        }
    }

    /// Far faces have no pressure, and suction can be left out.
    #[test]
    fn ends_of_the_range() {
        let far = BlastOnFace::new(&blast(1.0, true), [41.0, 0.0, 0.0], [1.0, 0.0, 0.0]);
        assert_eq!(far, None);
        let quiet = Blast { suction: false, ..blast(1.0, true) };
        let on = BlastOnFace::new(&quiet, [2.0, 0.0, 0.0], [-1.0, 0.0, 0.0]).unwrap();
        assert_eq!(on.pressure(on.arrival + 1.01 * on.duration), 0.0);
        let touching = BlastOnFace::new(&quiet, [0.0; 3], [0.0, 0.0, 1.0]).unwrap();
        assert!(touching.pressure(touching.arrival).is_finite());
    }
}
