//! The faces, nodes, elements and times of the page, and their reduction if the page would be too
//! large.

use super::series::{MeshSeries, spread};
use super::surface::{NO_ELEMENT, VisibleFace, without_repeats};
use std::collections::{HashMap, HashSet};

/// A selection from a series. Faces refer to indices in `nodes` and `elements`, which hold
/// indices in the series.
#[derive(Clone, Debug)]
pub struct PageScene {
    /// Faces.
    pub faces: Vec<VisibleFace>,
    /// Nodes of the faces.
    pub nodes: Vec<u32>,
    /// Elements that own faces.
    pub elements: Vec<u32>,
    /// Times.
    pub frames: Vec<usize>,
    /// Number of faces before any were merged.
    pub faces_seen: usize,
}

impl PageScene {
    /// Selects all faces at all times.
    pub fn new(series: &MeshSeries, faces: Vec<VisibleFace>) -> Self {
        let faces_seen = faces.len();
        let mut scene =
            Self { faces, nodes: Vec::new(), elements: Vec::new(), frames: Vec::new(), faces_seen };
        scene.frames = (0..series.frames.len()).collect();
        scene.nodes = renumber(scene.faces.iter_mut().flat_map(|f| &mut f.corners));
        scene.elements = renumber(scene.faces.iter_mut().flat_map(|f| &mut f.owners));
        scene
    }

    /// Returns the selection with at most `most` times.
    pub fn with_times(&self, most: usize) -> Self {
        let frames = spread(self.frames.len(), most).into_iter().map(|i| self.frames[i]).collect();
        Self { frames, ..self.clone() }
    }

    /// Returns a coarser selection. The nodes in each cube of a grid are replaced by one of them;
    /// degenerate faces are removed. The grid has `cubes` cubes along the longest side of the
    /// initial model.
    pub fn coarser(&self, series: &MeshSeries, cubes: usize) -> Self {
        let (low, size) = extent(series, &self.nodes);
        let side = (size / cubes as f32).max(f32::MIN_POSITIVE);
        let place = |node: u32| {
            position(series, node).map(|x| std::array::from_fn(|c| (x[c] - low[c]) / side))
        };
        let cube = |node: u32| place(node).map(|p: [f32; 3]| p.map(|c| c as i32));
        // The node nearest to the middle of a cube replaces the others, because its motion is
        // that of the model.
        let mut of_cube: HashMap<[i32; 3], (f32, u32)> = HashMap::new();
        for (at, &node) in self.nodes.iter().enumerate() {
            let Some(p) = place(node) else { continue };
            let off = p.iter().map(|c| (c.fract() - 0.5).powi(2)).sum::<f32>();
            let best = of_cube.entry(p.map(|c| c as i32)).or_insert((off, at as u32));
            if off < best.0 {
                *best = (off, at as u32);
            }
        }
        let stands = |at: u32| cube(self.nodes[at as usize]).map_or(at, |c| of_cube[&c].1);
        let mut had = HashSet::new();
        let merged = |f: &VisibleFace| {
            let corners = f.corners.map(stands);
            let [a, b, c, _] = f.corners;
            let corners = match (a == b, b == c) {
                (true, true) => Some(corners),
                (false, true) => Some(corners).filter(|c| c[0] != c[1]),
                _ => without_repeats(corners),
            }?;
            let mut key = corners;
            key.sort_unstable();
            had.insert(key).then_some(VisibleFace { corners, owners: f.owners })
        };
        let mut faces: Vec<VisibleFace> = self.faces.iter().filter_map(merged).collect();
        let keep =
            |old: &[u32], new: Vec<u32>| new.into_iter().map(|at| old[at as usize]).collect();
        let nodes = keep(&self.nodes, renumber(faces.iter_mut().flat_map(|f| &mut f.corners)));
        let elements = keep(&self.elements, renumber(faces.iter_mut().flat_map(|f| &mut f.owners)));
        Self { faces, nodes, elements, frames: self.frames.clone(), faces_seen: self.faces_seen }
    }
}

/// Returns the initial position of a node [length].
fn position(series: &MeshSeries, node: u32) -> Option<[f32; 3]> {
    let x = series.frames.iter().find_map(|f| f.position.get(node as usize))?;
    x.iter().all(|c| c.is_finite()).then_some(*x)
}

/// Returns the lowest corner of the box around the initial nodes, and its longest side [length].
fn extent(series: &MeshSeries, nodes: &[u32]) -> ([f32; 3], f32) {
    let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
    for x in nodes.iter().filter_map(|&node| position(series, node)) {
        for c in 0..3 {
            (low[c], high[c]) = (low[c].min(x[c]), high[c].max(x[c]));
        }
    }
    (low, (0..3).map(|c| high[c] - low[c]).fold(0.0, f32::max))
}

/// Renumbers from zero in ascending order of the old numbers, which are returned.
fn renumber<'a>(numbers: impl Iterator<Item = &'a mut u32>) -> Vec<u32> {
    let mut places: Vec<&mut u32> = numbers.filter(|n| **n != NO_ELEMENT).collect();
    let mut old: Vec<u32> = places.iter().map(|n| **n).collect();
    old.sort_unstable();
    old.dedup();
    for place in &mut places {
        **place = old.partition_point(|&n| n < **place) as u32;
    }
    old
}

#[cfg(test)]
pub(super) mod tests {
    use super::super::series::FieldFrame;
    use super::super::surface::{faces, tests::row_of_cubes};
    use super::*;

    #[test]
    fn a_scene_has_only_what_its_faces_need() {
        let series = row_of_cubes(3, &[1, 1, 1]);
        let scene = PageScene::new(&series, faces(&series));
        assert_eq!((scene.faces.len(), scene.nodes.len(), scene.elements), (14, 16, vec![0, 1, 2]));
        let mut shells = vec![VisibleFace { corners: [9, 4, 7, 7], owners: [5, NO_ELEMENT] }];
        shells.push(VisibleFace { corners: [4, 9, 12, 30], owners: [8, 5] });
        let scene = PageScene::new(&series, shells);
        assert_eq!(scene.nodes, [4, 7, 9, 12, 30]);
        assert_eq!(scene.elements, [5, 8]);
        assert_eq!(scene.faces[0], VisibleFace { corners: [2, 0, 1, 1], owners: [0, NO_ELEMENT] });
        assert_eq!(scene.faces[1], VisibleFace { corners: [0, 2, 3, 4], owners: [1, 0] });
    }

    /// Returns a sheet of square quads of side 1, and its scene.
    pub fn sheet(long: u32, wide: u32) -> (MeshSeries, PageScene) {
        let row = wide + 1;
        let node = |i: u32, j: u32| row * i + j;
        let place = |n: u32| [(n / row) as f32, (n % row) as f32, 0.5];
        let nodes = row * (long + 1);
        let frame =
            FieldFrame { position: (0..nodes).map(place).collect(), ..FieldFrame::default() };
        let series = MeshSeries {
            node_ids: (0..nodes.into()).collect(),
            frames: vec![frame],
            ..MeshSeries::default()
        };
        let quad = |e: u32| {
            let (i, j) = (e / wide, e % wide);
            VisibleFace {
                corners: [node(i, j), node(i + 1, j), node(i + 1, j + 1), node(i, j + 1)],
                owners: [e, NO_ELEMENT],
            }
        };
        let scene = PageScene::new(&series, (0..long * wide).map(quad).collect());
        (series, scene)
    }

    /// A square of 16 by 16 quads, merged two by two: one of four quads is left.
    #[test]
    fn a_coarser_scene_has_the_same_outline() {
        let (series, fine) = sheet(16, 16);
        let coarse = fine.coarser(&series, 8);
        assert_eq!(
            (coarse.faces.len(), coarse.faces_seen, coarse.nodes.len(), coarse.elements.len()),
            (64, 256, 81, 64)
        );
        assert!(
            coarse.nodes.iter().all(|n| fine.nodes.contains(n)),
            "nodes are nodes of the model"
        );
        let length = extent(&series, &coarse.nodes).1;
        assert!((14.0..=16.0).contains(&length), "each end moves by less than one cube: {length}");
        assert_eq!(fine.coarser(&series, 1000).faces.len(), fine.faces.len());
        assert_eq!(
            fine.coarser(&series, 1).faces.len(),
            1,
            "nodes on the far sides have their own cubes"
        );
    }

    #[test]
    fn fewer_times_keep_the_first_and_the_last() {
        let series = row_of_cubes(1, &[1]);
        let mut scene = PageScene::new(&series, faces(&series));
        scene.frames = vec![3, 4, 5, 6, 9];
        assert_eq!(scene.with_times(3).frames, [3, 5, 9]);
    }
}
