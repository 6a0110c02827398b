//! Crush figures and head injury criteria of a run, for `summary.json`, from the files of its
//! histories. The report shows the same by default.

pub(crate) mod signal;

use super::report::histories::ReportHistories;
use super::report::mass_centres::MASS_CENTRE;
use serde::Serialize;
use std::path::Path;

/// Filter class of accelerations of heads [Hz].
const HEAD_CLASS: f64 = 1000.0;
/// Longest windows of the head injury criteria [s].
const HEAD_WINDOWS: [f64; 2] = [0.015, 0.036];
/// Maximum number of nodes with a head injury criterion: the search of intervals takes time.
const MOST_HEADS: usize = 10;
/// Standard gravity [m/s^2].
const GRAVITY: f64 = 9.80665;
/// Seconds per unit of time.
const SECONDS: [(&str, f64); 5] =
    [("s", 1.0), ("ms", 1e-3), ("us", 1e-6), ("\u{b5}s", 1e-6), ("\u{3bc}s", 1e-6)];
/// Metres per unit of length.
const METRES: [(&str, f64); 5] =
    [("m", 1.0), ("cm", 1e-2), ("mm", 1e-3), ("in", 0.0254), ("ft", 0.3048)];

/// Crush figures of a force that acts, over the displacement of the wall that moves the farthest;
/// if a node moves more than twice as far, of that node; without both, of the mass centre of a
/// rigid part.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct CrushFigures {
    /// Object of the force: a wall, a section, a transducer, a part in contact.
    pub force: String,
    /// Object of the displacement.
    pub over: String,
    /// Largest force up to the stroke, without a filter [force].
    pub peak: f64,
    /// Displacement at the peak [length].
    pub peak_displacement: f64,
    /// Absorbed energy over stroke; none without a stroke [force].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub mean: Option<f64>,
    /// Largest displacement from the start [length].
    pub stroke: f64,
    /// Absorbed energy: integral of the force over the displacement up to the stroke
    /// [force length].
    pub energy: f64,
    /// Absorbed energy over the mass of all parts at the start; none without a mass
    /// [force length/mass].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub specific_energy: Option<f64>,
}

/// Head injury criteria of a node with an acceleration.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct HeadInjuryFigures {
    /// Name of the node.
    pub node: String,
    /// Largest acceleration after the filter CFC 1000; none if the filter needs more rows [g].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub peak_g: Option<f64>,
    /// Criterion with intervals of at most 15 ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hic15: Option<f64>,
    /// Its interval [ms].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval15_ms: Option<[f64; 2]>,
    /// Criterion with intervals of at most 36 ms.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub hic36: Option<f64>,
    /// Its interval [ms].
    #[serde(skip_serializing_if = "Option::is_none")]
    pub interval36_ms: Option<[f64; 2]>,
    /// Why there are no values; empty if there are.
    #[serde(skip_serializing_if = "String::is_empty")]
    pub why: String,
}

/// Histories of a run, and the places of vectors in them.
struct RunHistories {
    all: ReportHistories,
}

/// Components of a vector over time, and its unit.
struct VectorHistory<'a> {
    components: [&'a [f32]; 3],
    unit: &'a str,
}

impl VectorHistory<'_> {
    /// Returns the magnitude at a row, not finite where a component is missing.
    fn magnitude(&self, row: usize) -> f64 {
        self.components.iter().map(|c| f64::from(c[row]).powi(2)).sum::<f64>().sqrt()
    }
}

/// Returns the figures of the run in a folder. Both lists are empty if the run has no such
/// histories. `rigid` are the ids of rigid parts, `heads` the names of the groups of nodes that are
/// heads.
pub fn read(
    dir: &Path,
    rigid: &[u32],
    heads: &[String],
) -> (Vec<CrushFigures>, Vec<HeadInjuryFigures>) {
    let histories = RunHistories { all: ReportHistories::whole(dir, rigid) };
    (histories.crush(), histories.heads(heads))
}

impl RunHistories {
    /// Returns the first vector of an object whose name ends in a word.
    fn vector(&self, object: usize, word: &str) -> Option<VectorHistory<'_>> {
        let quantities = &self.all.objects[object].quantities;
        let is_vector = |i: &usize| {
            let names = quantities.get(*i..*i + 3);
            let base = quantities[*i][0].strip_suffix(" x").filter(|base| base.ends_with(word));
            base.zip(names).is_some_and(|(base, names)| {
                names[1][0] == format!("{base} y") && names[2][0] == format!("{base} z")
            })
        };
        let first = (0..quantities.len()).find(is_vector)?;
        let components = [0, 1, 2].map(|c| self.all.column(object, first + c));
        Some(VectorHistory { components, unit: &quantities[first][1] })
    }

    fn label(&self, object: usize) -> String {
        let object = &self.all.objects[object];
        format!("{} {}", object.kind, object.name).trim_end().into()
    }

    fn objects(&self) -> std::ops::Range<usize> {
        0..self.all.objects.len()
    }

    /// Returns the mass of all parts at the start [mass].
    fn mass(&self) -> f64 {
        let of_part = |&object: &usize| {
            let about = &self.all.objects[object];
            let place = about.quantities.iter().position(|q| q[0] == "mass");
            place
                .filter(|_| about.kind == "part")
                .map(|place| self.all.column(object, place).first().map_or(0.0, |m| f64::from(*m)))
        };
        self.objects().filter_map(|object| of_part(&object)).sum()
    }

    /// Returns the object whose displacement is the stroke. A node of a fold can move farther than
    /// the wall that crushes it, so that a wall comes first unless its displacement is less than
    /// half as large. Mass centres, whose displacements follow from momenta, come last.
    fn moved(&self) -> Option<usize> {
        let far = |object: usize| {
            let vector = self.vector(object, "displacement")?;
            let most = (0..self.all.rows).map(|row| vector.magnitude(row)).fold(0.0, f64::max);
            (most > 0.0).then_some((most, object))
        };
        let farthest = |of: &dyn Fn(&str) -> bool| {
            let all = self.objects().filter(|&object| of(self.all.objects[object].kind));
            all.filter_map(far).reduce(|a, b| if b.0 > a.0 { b } else { a })
        };
        let wall = farthest(&|kind| kind == "wall");
        let recorded = farthest(&|kind| kind != MASS_CENTRE);
        let is_stroke = |wall: &(f64, usize)| recorded.is_none_or(|most| 2.0 * wall.0 >= most.0);
        let of = wall.filter(is_stroke).or(recorded).or_else(|| farthest(&|_| true));
        of.map(|(_, object)| object)
    }

    fn crush(&self) -> Vec<CrushFigures> {
        let Some(over) = self.moved() else { return Vec::new() };
        let Some(moved) = self.vector(over, "displacement") else { return Vec::new() };
        let mass = self.mass();
        let figures = |object: usize| {
            let force = self.vector(object, "force")?;
            let points = (0..self.all.rows).map(|row| [moved.magnitude(row), force.magnitude(row)]);
            let (x, y): (Vec<f64>, Vec<f64>) =
                points.filter(|p| p.iter().all(|v| v.is_finite())).map(|[x, y]| (x, y)).unzip();
            if y.iter().all(|&force| force == 0.0) {
                return None;
            }
            let found = signal::crush(&x, &y)?;
            Some(CrushFigures {
                force: self.label(object),
                over: self.label(over),
                peak: found.peak,
                peak_displacement: found.at,
                mean: found.mean.is_finite().then_some(found.mean),
                stroke: found.stroke,
                energy: found.energy,
                specific_energy: (mass > 0.0).then(|| found.energy / mass),
            })
        };
        let is_object = |object: &usize| self.all.objects[*object].kind != "model";
        self.objects().filter(is_object).filter_map(figures).collect()
    }

    fn heads(&self, groups: &[String]) -> Vec<HeadInjuryFigures> {
        // The name of a node is that of its group and its id.
        let is_head = |object: &usize| {
            let group = self.all.objects[*object].name.rsplit_once(' ').map_or("", |n| n.0);
            groups.iter().any(|name| name == group)
        };
        let with_peak = |object: usize| {
            let vector = self.vector(object, "acceleration")?;
            let most = (0..self.all.rows).map(|row| vector.magnitude(row)).fold(0.0, f64::max);
            Some((most, object))
        };
        let mut nodes: Vec<(f64, usize)> =
            self.objects().filter(is_head).filter_map(with_peak).collect();
        nodes.sort_by(|a, b| b.0.total_cmp(&a.0));
        nodes.truncate(MOST_HEADS);
        let figures = |(_, object): (f64, usize)| {
            let node = self.label(object);
            self.head(object).unwrap_or_else(|why| HeadInjuryFigures {
                node,
                why,
                ..HeadInjuryFigures::default()
            })
        };
        nodes.into_iter().map(figures).collect()
    }

    /// Returns the criteria of a node.
    fn head(&self, object: usize) -> Result<HeadInjuryFigures, String> {
        let vector = self.vector(object, "acceleration").ok_or("it has no acceleration")?;
        let (unit, second) = acceleration_unit(vector.unit)
            .ok_or("the unit of accelerations is not known: set `units` of the job")?;
        let finite = (0..self.all.rows).filter(|&row| vector.magnitude(row).is_finite());
        let rows: Vec<usize> = finite.collect();
        let time: Vec<f64> = rows.iter().map(|&row| second * self.all.time()[row]).collect();
        if time.len() < 2 {
            return Err("it has fewer than two rows".into());
        }
        // Each channel is filtered, and the criterion takes the resultant.
        let channel = |c: &[f32]| {
            let values: Vec<f64> = rows.iter().map(|&row| f64::from(c[row])).collect();
            signal::filtered(&time, &values, HEAD_CLASS)
        };
        let [x, y, z] = vector.components.map(channel);
        let (x, y, z) = (x?, y?, z?);
        let g = |i: usize| (x[i].powi(2) + y[i].powi(2) + z[i].powi(2)).sqrt() * unit / GRAVITY;
        let values: Vec<f64> = (0..time.len()).map(g).collect();
        let [short, long] = HEAD_WINDOWS.map(|window| signal::head_injury(&time, &values, window));
        let ms = |found: signal::Injury| found.interval.map(|t| 1e3 * t);
        Ok(HeadInjuryFigures {
            node: self.label(object),
            peak_g: Some(values.iter().copied().fold(0.0, f64::max)),
            hic15: short.map(|found| found.value),
            interval15_ms: short.map(ms),
            hic36: long.map(|found| found.value),
            interval36_ms: long.map(ms),
            why: String::new(),
        })
    }
}

/// Returns a unit of time in s, if it is known.
pub(crate) fn seconds(unit: &str) -> Option<f64> {
    SECONDS.iter().find(|known| known.0 == unit).map(|known| known.1)
}

/// Returns a unit such as `mm/ms^2` in m/s^2, and its unit of time in s.
fn acceleration_unit(unit: &str) -> Option<(f64, f64)> {
    let (length, time) = unit.strip_suffix("^2")?.split_once('/')?;
    let metre = METRES.iter().find(|known| known.0 == length).map(|known| known.1)?;
    let second = seconds(time)?;
    Some((metre / (second * second), second))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fmt::Write;

    /// A force of 2 u up to u = 30, and a constant acceleration of 50 g: energy F u / 2, mean half
    /// of the peak, and HIC = T a^2.5 for T = 15 ms and for T = 30 ms, the whole run.
    #[test]
    fn a_run_has_its_figures() {
        let dir = tempfile::tempdir().unwrap();
        let mut history = String::from("time [ms],kinetic [J]\n");
        let mut walls = String::from(
            "time [ms],wall,displacement x [mm],displacement y [mm],displacement z [mm],\
             force x [kN],force y [kN],force z [kN]\n",
        );
        let mut nodes = String::from(
            "time [ms],nodes,id,acceleration x [mm/ms^2],acceleration y [mm/ms^2],\
             acceleration z [mm/ms^2]\n",
        );
        let mut parts = String::from("time [ms],part,name,mass [kg]\n");
        let g = GRAVITY * 1e-3;
        for i in 0..=600 {
            let t = f64::from(i) * 0.05;
            writeln!(history, "{t:.9e},1").unwrap();
            writeln!(walls, "{t:.9e},ram,0,0,{u},0,0,{f}", u = -t, f = 2.0 * t).unwrap();
            writeln!(nodes, "{t:.9e},head,7,{x},{y},0", x = 30.0 * g, y = 40.0 * g).unwrap();
            writeln!(parts, "{t:.9e},1,tube,1.5\n{t:.9e},2,cap,0.5").unwrap();
        }
        let files = [("history", history), ("walls", walls), ("nodes", nodes), ("parts", parts)];
        for (name, text) in &files {
            std::fs::write(dir.path().join(format!("{name}.csv")), text).unwrap();
        }
        let (crush, heads) = read(dir.path(), &[], &["head".into()]);
        assert_eq!(crush.len(), 1);
        let c = &crush[0];
        assert_eq!((&c.force[..], &c.over[..]), ("wall ram", "wall ram"));
        // Values of histories have single precision.
        let close = |value: f64, exact: f64| {
            assert!((value / exact - 1.0).abs() < 1e-6, "{value} for {exact}");
        };
        close(c.peak, 60.0);
        close(c.stroke, 30.0);
        close(c.energy, 900.0);
        close(c.mean.unwrap(), 30.0);
        close(c.specific_energy.unwrap(), 450.0);
        assert_eq!(heads.len(), 1);
        let h = &heads[0];
        assert_eq!(h.node, "node head 7");
        close(h.peak_g.unwrap(), 50.0);
        close(h.hic15.unwrap(), 0.015 * 50f64.powf(2.5));
        close(h.hic36.unwrap(), 0.030 * 50f64.powf(2.5));
        let longer = h.interval36_ms.unwrap();
        assert!((longer[1] - longer[0] - 30.0).abs() < 1e-6, "{longer:?}");
        assert_eq!(read(dir.path(), &[], &[]).1, [], "no node is said to be a head");
        assert_eq!(read(dir.path(), &[], &["neck".into(), "hea".into()]).1, []);
    }

    /// A rigid ram that is stopped by a constant force of 6 kN from 4 mm/ms: with its mass of 3 kg
    /// it moves 4 mm, and the wall absorbs its 24 J. A displacement of a node comes first.
    #[test]
    fn a_rigid_part_gives_a_displacement_where_no_node_has_one() {
        let dir = tempfile::tempdir().unwrap();
        let write = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
        let mut history = String::from("time [ms],kinetic [J]\n");
        let mut walls = String::from(
            "time [ms],wall,displacement x [mm],displacement y [mm],displacement z [mm],\
             force x [kN],force y [kN],force z [kN]\n",
        );
        let mut parts = String::from(
            "time [ms],part,name,mass [kg],momentum x [kg mm/ms],momentum y [kg mm/ms],\
             momentum z [kg mm/ms]\n",
        );
        let mut nodes = String::from(
            "time [ms],nodes,id,displacement x [mm],displacement y [mm],displacement z [mm]\n",
        );
        for i in 0..=20 {
            let t = f64::from(i) * 0.1;
            writeln!(history, "{t:.9e},1").unwrap();
            writeln!(walls, "{t:.9e},stop,0,0,0,6,0,0").unwrap();
            writeln!(parts, "{t:.9e},4,ram,3,{:.9e},0,0", -3.0 * (4.0 - 2.0 * t)).unwrap();
            writeln!(nodes, "{t:.9e},mark,7,0,0,{t:.9e}").unwrap();
        }
        write("history.csv", &history);
        write("walls.csv", &walls);
        write("parts.csv", &parts);
        assert_eq!(read(dir.path(), &[], &[]).0, [], "no displacement");
        let crush = read(dir.path(), &[4], &[]).0;
        assert_eq!((crush.len(), &crush[0].over[..]), (1, "mass centre of part 4 ram"));
        assert!((crush[0].stroke - 4.0).abs() < 1e-6, "{crush:?}");
        assert!((crush[0].energy - 24.0).abs() < 1e-5, "{crush:?}");
        write("nodes.csv", &nodes);
        assert_eq!(read(dir.path(), &[4], &[]).0[0].over, "node mark 7");
    }

    /// A ram that moves 10 mm under 6 kN absorbs 60 J, over any node of a fold that moves less than
    /// twice as far. A wall that nothing touches has no figures.
    #[test]
    fn a_wall_that_moves_comes_before_a_node_of_a_fold() {
        let crush = |of_node: f64| {
            let dir = tempfile::tempdir().unwrap();
            let vector = |name: &str, unit: &str| {
                ["x", "y", "z"].map(|axis| format!("{name} {axis} [{unit}]")).join(",")
            };
            let mut history = String::from("time [ms],kinetic [J]\n");
            let (moves, pushes) = (vector("displacement", "mm"), vector("force", "kN"));
            let mut walls = format!("time [ms],wall,{moves},{pushes}\n");
            let mut nodes = format!("time [ms],nodes,id,{moves}\n");
            for t in 0..=10 {
                writeln!(history, "{t},1").unwrap();
                writeln!(walls, "{t},foot,0,0,0,0,0,0\n{t},ram,0,0,-{t},0,0,-6").unwrap();
                writeln!(nodes, "{t},head,7,{},0,0", of_node * f64::from(t)).unwrap();
            }
            for (name, text) in [("history", history), ("walls", walls), ("nodes", nodes)] {
                std::fs::write(dir.path().join(format!("{name}.csv")), text).unwrap();
            }
            let all = read(dir.path(), &[], &[]).0;
            assert_eq!(all.len(), 1, "{all:?}");
            assert_eq!(all[0].force, "wall ram");
            (all[0].over.clone(), all[0].energy)
        };
        for of_node in [0.0, 0.5, 1.9] {
            let (over, energy) = crush(of_node);
            assert_eq!(over, "wall ram");
            assert!((energy / 60.0 - 1.0).abs() < 1e-6, "{energy}");
        }
        assert_eq!(crush(2.1).0, "node head 7");
    }

    #[test]
    fn a_run_without_such_histories_has_none_and_coarse_rows_say_why() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(read(dir.path(), &[], &[]), (Vec::new(), Vec::new()));
        let file = |name: &str, text: &str| std::fs::write(dir.path().join(name), text).unwrap();
        file("history.csv", "time [ms],kinetic [J]\n0,1\n1,1\n2,1\n3,1\n");
        let head = "time [ms],nodes,id,acceleration x [mm/ms^2],acceleration y [mm/ms^2],\
                    acceleration z [mm/ms^2]\n";
        file("nodes.csv", &format!("{head}0,head,7,1,0,0\n1,head,7,1,0,0\n2,head,7,1,0,0\n"));
        let (crush, heads) = read(dir.path(), &[], &["head".into()]);
        assert!(crush.is_empty() && heads[0].hic15.is_none());
        assert!(heads[0].why.contains("output.history_interval"), "{}", heads[0].why);
        assert_eq!(acceleration_unit("m/s^2"), Some((1.0, 1.0)));
        assert_eq!(acceleration_unit("[length/time^2]"), None);
    }
}
