//! Reads mesh and states from the field files of a run.

use crate::results::field_file::PieceArrays;
use crate::results::fields::{COLLECTION, DIR};
use crate::results::summary;
use crumple_worker::vtu;
use std::collections::HashMap;
use std::path::{Path, PathBuf};

/// Nodes, elements and parts, by ascending ids.
#[derive(Debug, Default)]
pub struct FieldMesh {
    /// Title of the run.
    pub title: String,
    /// Ids of nodes.
    pub nodes: Vec<i32>,
    /// Initial coordinates [length].
    pub x: Vec<[f32; 3]>,
    /// Solids.
    pub solids: Vec<ElementIds>,
    /// Indices of the nodes of the solids.
    pub solid_corners: Vec<[i32; 8]>,
    /// Shells.
    pub shells: Vec<ElementIds>,
    /// Indices of the nodes of the shells. A triangle repeats its third node.
    pub shell_corners: Vec<[i32; 4]>,
    /// Ids and names of parts.
    pub parts: Vec<(i32, String)>,
    /// Number of points of each shell in the fields; 0 if there is only the middle surface.
    pub points: usize,
}

/// Ids of an element.
#[derive(Clone, Copy, Debug)]
pub struct ElementIds {
    /// Id of the element.
    pub id: i32,
    /// Id of its part.
    pub part: i32,
}

impl FieldMesh {
    /// Returns the index of a part, from 1.
    pub fn part_of(&self, id: i32) -> i32 {
        self.parts.binary_search_by_key(&id, |p| p.0).map_or(0, |i| i as i32 + 1)
    }
}

/// Values at one time.
#[derive(Debug, Default)]
pub struct DatabaseState {
    /// Simulated time [time].
    pub time: f64,
    /// Kinetic, internal and total energy [energy].
    pub energies: [f64; 3],
    /// Coordinates [length].
    pub x: Vec<[f32; 3]>,
    /// Velocities [length/time].
    pub v: Vec<[f32; 3]>,
    /// Values per solid.
    pub solids: Vec<StateValues>,
    /// Values per shell.
    pub shells: Vec<StateValues>,
    /// Points of the shells, as many for each as the mesh says; empty if it has none.
    pub points: Vec<PointValues>,
}

/// Values of an element.
#[derive(Clone, Copy, Debug, Default)]
pub struct StateValues {
    /// False if the element is deleted.
    pub alive: bool,
    /// Stress xx, yy, zz, xy, yz, zx [force/length^2].
    pub stress: [f32; 6],
    /// Effective plastic strain.
    pub plastic_strain: f32,
    /// Largest von Mises stress [force/length^2].
    pub von_mises: f32,
    /// Thickness of a shell [length].
    pub thickness: f32,
}

/// Values of a point through the thickness of a shell.
#[derive(Clone, Copy, Debug, Default)]
pub struct PointValues {
    /// Stress xx, yy, zz, xy, yz, zx [force/length^2].
    pub stress: [f32; 6],
    /// Effective plastic strain.
    pub plastic_strain: f32,
}

/// Position of an element's values in the state.
#[derive(Clone, Copy)]
enum StatePosition {
    Solid(usize),
    Shell(usize),
}

/// The field files of a run.
pub struct FieldSource {
    dir: PathBuf,
    /// Folder and time of each step.
    steps: Vec<(PathBuf, f64)>,
    /// Rows of the history: time, kinetic and internal energy.
    energies: Vec<[f64; 3]>,
    nodes: HashMap<i64, usize>,
    elements: HashMap<i64, StatePosition>,
    state: DatabaseState,
    points: usize,
    /// Number of particles, and of beams, trusses and springs, which the database does not have.
    left_out: [usize; 2],
}

impl FieldSource {
    /// Opens the run in `dir`.
    pub fn open(dir: &Path) -> Result<Self, String> {
        let fields = dir.join(DIR);
        let collection = fields.join(COLLECTION);
        let shown = collection.display();
        let text = std::fs::read_to_string(&collection).map_err(|e| {
            format!("{shown}: {e}; name the folder of a run that has written fields")
        })?;
        let attribute = |line: &str, name: &str| {
            let (_, rest) = line.split_once(&format!(" {name}=\""))?;
            rest.split('"').next().map(String::from)
        };
        let step = |line: &str| {
            let (time, file) =
                (attribute(line, "timestep")?.parse().ok()?, attribute(line, "file")?);
            Some((fields.join(file).parent()?.to_path_buf(), time))
        };
        let steps: Vec<_> =
            text.lines().filter(|l| l.starts_with("<DataSet")).filter_map(step).collect();
        if steps.is_empty() {
            return Err(format!("{shown} lists no step; run the job with fields"));
        }
        let energies = energies(&dir.join("history.csv"));
        let (nodes, elements, state) = (HashMap::new(), HashMap::new(), DatabaseState::default());
        let dir = dir.to_owned();
        Ok(Self { dir, steps, energies, nodes, elements, state, points: 0, left_out: [0; 2] })
    }

    /// Returns a text on the elements that the database does not have, empty if it has all.
    pub fn missing(&self) -> String {
        let kinds = ["particles", "beams, trusses and springs"];
        let counts = self.left_out.iter().zip(kinds).filter(|(count, _)| **count > 0);
        let named: Vec<String> = counts.map(|(count, kind)| format!("{count} {kind}")).collect();
        match named.is_empty() {
            true => String::new(),
            false => format!(
                "\nnot in it: {}; crumple export-exodus writes all elements",
                named.join(" and ")
            ),
        }
    }

    /// Returns the number of states.
    pub fn states(&self) -> usize {
        self.steps.len()
    }

    fn pieces(&self, step: usize) -> Result<Vec<PieceArrays>, String> {
        let folder = &self.steps[step].0;
        let paths = (0..)
            .map(|worker| folder.join(vtu::piece_name(worker)))
            .take_while(|path| path.is_file());
        let pieces: Vec<PieceArrays> =
            paths.map(|path| PieceArrays::read(&path)).collect::<Result<_, _>>()?;
        if pieces.is_empty() {
            Err(format!("{} contains no pieces", folder.display()))
        } else {
            Ok(pieces)
        }
    }

    /// Returns the mesh of the first step. Must be called before any state is read.
    pub fn mesh(&mut self) -> Result<FieldMesh, String> {
        let pieces = self.pieces(0)?;
        let id = |id: f64| -> Result<i32, String> {
            let whole = id as i64;
            i32::try_from(whole)
                .map_err(|_| format!("id {whole} does not fit into the 32 bits of the format"))
        };
        let mut nodes: Vec<(i32, [f32; 3])> = Vec::new();
        let mut solids: Vec<(ElementIds, [i64; 8])> = Vec::new();
        let mut shells: Vec<(ElementIds, [i64; 4])> = Vec::new();
        for piece in &pieces {
            self.points = self.points.max(piece.components(vtu::PLASTIC_STRAIN_OF_POINTS.name));
            let (points, moved) = (piece.array("Points")?, piece.array(vtu::DISPLACEMENT.name)?);
            let node_ids = piece.array(vtu::NODE_ID.name)?;
            for ((&n, x), u) in node_ids.iter().zip(points.chunks(3)).zip(moved.chunks(3)) {
                nodes.push((id(n)?, std::array::from_fn(|c| (x[c] - u[c]) as f32)));
            }
            let (corners, ends) = (piece.array("connectivity")?, piece.array("offsets")?);
            let (ids, parts) = (piece.array(vtu::ELEMENT_ID.name)?, piece.array(vtu::PART.name)?);
            let kinds = piece.array("types")?;
            let mut begin = 0;
            for (((&e, &part), &end), &kind) in ids.iter().zip(&parts).zip(&ends).zip(&kinds) {
                let element = ElementIds { id: id(e)?, part: id(part)? };
                let at: Vec<i64> = corners[begin..end as usize]
                    .iter()
                    .map(|&c| node_ids[c as usize] as i64)
                    .collect();
                let corner = |k: usize| at[k.min(at.len() - 1)];
                match (kind as u8, at.len()) {
                    // The format's solids have eight corners; the nodes on edges are left out.
                    (10 | 12, _) => solids.push((element, std::array::from_fn(corner))),
                    (24, 10) => {
                        solids.push((element, std::array::from_fn(|k| at[k.min(3)])));
                    }
                    (13, 6) => {
                        let degenerate = [0, 2, 5, 3, 1, 1, 4, 4].map(corner);
                        solids.push((element, degenerate));
                    }
                    (_, ends @ (1 | 2)) => self.left_out[ends - 1] += 1,
                    _ => shells.push((element, std::array::from_fn(corner))),
                }
                begin = end as usize;
            }
        }
        nodes.sort_by_key(|n| n.0);
        nodes.dedup_by_key(|n| n.0);
        solids.sort_by_key(|e| e.0.id);
        shells.sort_by_key(|e| e.0.id);
        self.nodes = nodes.iter().enumerate().map(|(i, n)| (i64::from(n.0), i)).collect();
        let solid =
            |(i, e): (usize, &(ElementIds, _))| (i64::from(e.0.id), StatePosition::Solid(i));
        let shell =
            |(i, e): (usize, &(ElementIds, _))| (i64::from(e.0.id), StatePosition::Shell(i));
        self.elements = solids.iter().enumerate().map(solid).collect();
        self.elements.extend(shells.iter().enumerate().map(shell));
        let place = |n: i64| self.nodes[&n] as i32;
        let parts = parts(&self.dir, solids.iter().map(|e| e.0).chain(shells.iter().map(|e| e.0)));
        let x: Vec<[f32; 3]> = nodes.iter().map(|n| n.1).collect();
        self.state = DatabaseState {
            x: x.clone(),
            v: vec![[0.0; 3]; x.len()],
            solids: vec![StateValues::default(); solids.len()],
            shells: vec![StateValues::default(); shells.len()],
            points: vec![PointValues::default(); self.points * shells.len()],
            ..DatabaseState::default()
        };
        Ok(FieldMesh {
            title: format!(
                "crumple {}",
                self.dir.file_name().unwrap_or_default().to_string_lossy()
            ),
            nodes: nodes.iter().map(|n| n.0).collect(),
            x,
            solid_corners: solids.iter().map(|e| e.1.map(place)).collect(),
            solids: solids.iter().map(|e| e.0).collect(),
            shell_corners: shells.iter().map(|e| e.1.map(place)).collect(),
            shells: shells.iter().map(|e| e.0).collect(),
            parts,
            points: self.points,
        })
    }

    /// Returns the state of a step. A failed element keeps its last values, and a node without
    /// elements its last position.
    pub fn state(&mut self, step: usize) -> Result<&DatabaseState, String> {
        let pieces = self.pieces(step)?;
        let s = &mut self.state;
        s.time = self.steps[step].1;
        s.energies = at(&self.energies, s.time);
        s.solids.iter_mut().chain(&mut s.shells).for_each(|v| v.alive = false);
        for piece in &pieces {
            let (points, velocities) = (piece.array("Points")?, piece.array(vtu::VELOCITY.name)?);
            let node_ids = piece.array(vtu::NODE_ID.name)?;
            for ((&n, x), v) in node_ids.iter().zip(points.chunks(3)).zip(velocities.chunks(3)) {
                let Some(&i) = self.nodes.get(&(n as i64)) else {
                    return Err(format!(
                        "{}: node {n} is not in the first step, and the format has one mesh for \
                         all times: the fields of a run with [adaptivity] are for ParaView",
                        self.steps[step].0.display()
                    ));
                };
                s.x[i] = std::array::from_fn(|c| x[c] as f32);
                s.v[i] = std::array::from_fn(|c| v[c] as f32);
            }
            let stress = piece.array(vtu::STRESS.name)?;
            let scalars =
                [vtu::PLASTIC_STRAIN, vtu::VON_MISES, vtu::THICKNESS].map(|a| piece.array(a.name));
            let [plastic_strain, von_mises, thickness] = scalars;
            let (plastic_strain, von_mises, thickness) = (plastic_strain?, von_mises?, thickness?);
            let count = piece.components(vtu::PLASTIC_STRAIN_OF_POINTS.name);
            if piece.cells > 0 && count != self.points {
                return Err(format!(
                    "{}: the fields have {count} points of shells, and {} at the start",
                    self.steps[step].0.display(),
                    self.points
                ));
            }
            let of_points = match self.points {
                0 => [Vec::new(), Vec::new()],
                _ => [
                    piece.array(vtu::STRESS_OF_POINTS.name)?,
                    piece.array(vtu::PLASTIC_STRAIN_OF_POINTS.name)?,
                ],
            };
            for (e, id) in piece.array(vtu::ELEMENT_ID.name)?.iter().enumerate() {
                if let Some(&StatePosition::Shell(shell)) = self.elements.get(&(*id as i64)) {
                    for k in 0..self.points {
                        let at = e * self.points + k;
                        s.points[shell * self.points + k] = PointValues {
                            stress: std::array::from_fn(|c| of_points[0][6 * at + c] as f32),
                            plastic_strain: of_points[1][at] as f32,
                        };
                    }
                }
                let values = match self.elements.get(&(*id as i64)) {
                    Some(&StatePosition::Solid(i)) => &mut s.solids[i],
                    Some(&StatePosition::Shell(i)) => &mut s.shells[i],
                    None => continue,
                };
                *values = StateValues {
                    alive: true,
                    stress: std::array::from_fn(|c| stress[6 * e + c] as f32),
                    plastic_strain: plastic_strain[e] as f32,
                    von_mises: von_mises[e] as f32,
                    thickness: thickness[e] as f32,
                };
            }
        }
        Ok(s)
    }
}

/// Returns the ids of the parts of elements, ascending, with the names in the summary of the run.
fn parts(dir: &Path, elements: impl Iterator<Item = ElementIds>) -> Vec<(i32, String)> {
    let names = summary::part_names(dir);
    let name = |id: i32| names.get(&u32::try_from(id).ok()?).cloned();
    let mut ids: Vec<i32> = elements.map(|e| e.part).collect();
    ids.sort_unstable();
    ids.dedup();
    ids.into_iter().map(|id| (id, name(id).unwrap_or_else(|| format!("part {id}")))).collect()
}

/// Returns time, kinetic and internal energy of each row of a history; empty if the file cannot
/// be read.
fn energies(path: &Path) -> Vec<[f64; 3]> {
    let Ok(mut reader) = csv::Reader::from_path(path) else { return Vec::new() };
    let header = reader.headers().cloned().unwrap_or_default();
    let column = |name: &str| header.iter().position(|h| h.split(" [").next() == Some(name));
    let Some(columns) =
        ["time", "kinetic", "internal"].into_iter().map(column).collect::<Option<Vec<_>>>()
    else {
        return Vec::new();
    };
    let row = |record: csv::StringRecord| {
        let numbers =
            columns.iter().map(|&c| record.get(c)?.parse().ok()).collect::<Option<Vec<f64>>>()?;
        numbers.try_into().ok()
    };
    reader.records().filter_map(|r| r.ok().and_then(row)).collect()
}

/// Interpolates kinetic, internal and total energy at a time.
fn at(rows: &[[f64; 3]], time: f64) -> [f64; 3] {
    let next = rows.partition_point(|r| r[0] < time);
    let (Some(a), Some(b)) = (rows.get(next.saturating_sub(1)), rows.get(next).or(rows.last()))
    else {
        return [0.0; 3];
    };
    let t = if b[0] > a[0] { ((time - a[0]) / (b[0] - a[0])).clamp(0.0, 1.0) } else { 0.0 };
    let [kinetic, internal] = [1, 2].map(|c| a[c] + t * (b[c] - a[c]));
    [kinetic, internal, kinetic + internal]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn energies_are_interpolated_and_held_at_the_ends() {
        let rows = [[0.0, 10.0, 0.0], [1.0, 6.0, 4.0], [2.0, 6.0, 5.0]];
        assert_eq!(at(&rows, 0.0), [10.0, 0.0, 10.0]);
        assert_eq!(at(&rows, 0.25), [9.0, 1.0, 10.0]);
        assert_eq!(at(&rows, 2.0), [6.0, 5.0, 11.0]);
        assert_eq!(at(&rows, 9.0), [6.0, 5.0, 11.0]);
        assert_eq!(at(&[], 1.0), [0.0; 3]);
    }
}
