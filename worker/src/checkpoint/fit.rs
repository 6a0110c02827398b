//! Checks that the files of a checkpoint are a state of a job: that of its mesh, with its parts,
//! bodies, walls, ties and interfaces. The sums of the files do not show that: a program with a
//! fault writes wrong contents with right sums.

use super::CheckpointPiece;
use crate::engine::checkpoint::CommonState;
use crate::fem::blocks::Block;
use crate::fem::elements::build_block;
use crumple_proto::checkpoint::{Captured, FileRecord, read};
use crumple_proto::ids::{ElemId, NodeId, SegmentId};
use crumple_proto::mesh::OwnSection;
use crumple_proto::partition::{ElementRecord, NodeRecord, Settings};
use crumple_proto::wire;
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// The job and its mesh at time 0.
#[derive(Clone, Copy)]
pub struct InitialModel<'a> {
    /// Settings of the job.
    pub settings: &'a Settings,
    /// All elements, in ascending id.
    pub elements: &'a [ElementRecord],
    /// All nodes, in ascending id.
    pub nodes: &'a [NodeRecord],
}

/// The state that a checkpoint should have.
#[derive(Clone, Copy)]
pub struct Expected {
    /// The cycle and what the master had received until then.
    pub captured: Captured,
    /// Number of elements.
    pub elements: usize,
}

/// Reads all files of a checkpoint and checks that they are a state of a job.
///
/// # Errors
/// They are not; the message names the file.
pub fn verify(
    folder: &Path,
    common: &FileRecord,
    pieces: &[FileRecord],
    source: InitialModel<'_>,
    expected: Expected,
) -> Result<(), String> {
    let named = |record: &FileRecord| {
        let path = folder.join(&record.name);
        move |why: String| format!("{}: {why}", path.display())
    };
    let mut fit = Fit::new(source);
    let words = read(folder, common)?;
    fit.add_common(&words, &expected.captured).map_err(named(common))?;
    for record in pieces {
        let words = read(folder, record)?;
        fit.add_piece(&words).map_err(named(record))?;
    }
    fit.finish(expected.elements).map_err(|why| format!("{}: {why}", folder.display()))
}

/// Returns the common state of these words.
///
/// # Errors
/// They are none, or that of another time: the reason.
pub fn read_common(words: &[u64], captured: &Captured) -> Result<CommonState, String> {
    let common: CommonState =
        wire::decode(words).ok_or("it is not the state that all workers share")?;
    common.clock.validate(captured)?;
    Ok(common)
}

/// The contents of a checkpoint that were checked so far.
pub struct Fit<'a> {
    settings: &'a Settings,
    /// Elements and nodes of the job, with those that divisions have made.
    elements: Cow<'a, [ElementRecord]>,
    nodes: Cow<'a, [NodeRecord]>,
    /// Number of elements that divisions have added.
    added: usize,
    /// Number of columns by part and shape, of the kinds so far.
    columns: BTreeMap<(u32, u8), usize>,
    ids: Vec<ElemId>,
}

impl<'a> Fit<'a> {
    /// Prepares the check.
    pub fn new(source: InitialModel<'a>) -> Self {
        let InitialModel { settings, elements, nodes } = source;
        Self {
            settings,
            elements: elements.into(),
            nodes: nodes.into(),
            added: 0,
            columns: BTreeMap::new(),
            ids: Vec::new(),
        }
    }

    /// Checks the common state.
    ///
    /// # Errors
    /// It is not that of the job: the reason.
    pub fn add_common(&mut self, words: &[u64], captured: &Captured) -> Result<(), String> {
        let common = read_common(words, captured)?;
        common.validate(self.settings)?;
        let adaptivity = common.adaptivity.and_then(|a| a.with_settings(self.settings));
        if let Some(adaptivity) = adaptivity.filter(|a| a.divided() > 0) {
            let before = self.elements.len();
            adaptivity.divide_at_start(self.elements.to_mut(), self.nodes.to_mut())?;
            self.added = self.elements.len() - before;
        }
        Ok(())
    }

    /// Checks the file of a worker.
    ///
    /// # Errors
    /// It is not one of the job: the reason.
    pub fn add_piece(&mut self, words: &[u64]) -> Result<(), String> {
        let piece = CheckpointPiece::new(words)?;
        piece.own.validate(self.settings)?;
        fit_columns(self.settings, &piece.share.elements, &mut self.columns)?;
        for (element, _) in &piece.share.elements {
            self.fit_element(element)?;
        }
        for node in &piece.share.nodes {
            self.fit_node(node)?;
        }
        let means: BTreeSet<NodeId> = piece.share.means.iter().map(|mean| mean.id).collect();
        let wanted = if self.settings.subcycles > 1 { piece.share.nodes.len() } else { 0 };
        if means.len() != wanted || piece.share.means.len() != wanted {
            let count = means.len();
            return Err(format!("it has mean velocities of {count} nodes instead of {wanted}"));
        }
        let knows = |id: NodeId| self.node(id).is_some();
        let is_face =
            |id: SegmentId| self.element(id.elem()).is_some_and(|e| has_face(e, id.face()));
        for (&node, list) in &piece.share.memories {
            if !list.iter().all(|history| history.is_valid(node, knows, is_face)) {
                return Err(format!("node {node} has a contact history that is not valid"));
            }
        }
        self.ids.extend(piece.share.elements.iter().map(|(e, _)| e.id));
        Ok(())
    }

    /// Checks that each element was there once.
    ///
    /// # Errors
    /// One was there twice, or the number is another one: the reason.
    pub fn finish(mut self, elements: usize) -> Result<(), String> {
        self.ids.sort_unstable();
        if let Some(twice) = self.ids.windows(2).find(|pair| pair[0] == pair[1]) {
            return Err(format!("it has element {} twice", twice[0]));
        }
        let wanted = elements + self.added;
        if self.ids.len() == wanted {
            return Ok(());
        }
        Err(format!("it has {} of {wanted} elements", self.ids.len()))
    }

    fn element(&self, id: ElemId) -> Option<&ElementRecord> {
        let all = &self.elements;
        Some(&all[all.binary_search_by_key(&id, |e| e.id).ok()?])
    }

    fn node(&self, id: NodeId) -> Option<&NodeRecord> {
        let all = &self.nodes;
        Some(&all[all.binary_search_by_key(&id, |n| n.id).ok()?])
    }

    fn fit_element(&self, e: &ElementRecord) -> Result<(), String> {
        let Some(known) = self.element(e.id) else {
            return Err(format!("the job has no element {}", e.id));
        };
        let bits = |OwnSection { thickness, offset, angle }: OwnSection| {
            (thickness.to_bits(), offset.map(f64::to_bits), angle.to_bits())
        };
        let differs = if (e.part, e.shape) != (known.part, known.shape) {
            "another part or shape"
        } else if e.nodes != known.nodes {
            "other nodes"
        } else if bits(e.own) != bits(known.own) {
            "another thickness, offset or angle"
        } else if u32::from(e.free_faces & !known.free_faces) >> e.shape.faces().len() != 0 {
            "faces that do not exist"
        } else if e.slow != known.slow {
            "other subcycles"
        } else if e.mass_factor.to_bits() != known.mass_factor.to_bits()
            || e.share.to_bits() != known.share.to_bits()
            || e.stable_dt.to_bits() != known.stable_dt.to_bits()
        {
            "another mass or stable step"
        } else {
            return Ok(());
        };
        Err(format!("element {} has {differs}", e.id))
    }

    fn fit_node(&self, n: &NodeRecord) -> Result<(), String> {
        let Some(known) = self.node(n.id) else {
            return Err(format!("the job has no node {}", n.id));
        };
        if n.x0.map(f64::to_bits) != known.x0.map(f64::to_bits) {
            return Err(format!("node {} has another position at time 0", n.id));
        }
        let all = [n.x, n.seen, n.v, n.w];
        let is_finite = all.as_flattened().iter().all(|a| a.is_finite());
        let masses = [n.mass, n.inertia];
        if !is_finite || masses.iter().any(|m| !m.is_finite() || *m < 0.0) {
            return Err(format!(
                "node {} has a state that is not finite, or a negative mass",
                n.id
            ));
        }
        Ok(())
    }
}

fn has_face(element: &ElementRecord, face: usize) -> bool {
    face < element.shape.faces().len()
}

/// Checks that the elements are those of parts of the job, with their columns. `known` are the
/// numbers of columns of the kinds so far.
pub(super) fn fit_columns(
    settings: &Settings,
    elements: &[(ElementRecord, Vec<f64>)],
    known: &mut BTreeMap<(u32, u8), usize>,
) -> Result<(), String> {
    for (e, columns) in elements {
        let kind = (e.part, e.shape as u8);
        let wanted = match known.get(&kind) {
            Some(&wanted) => wanted,
            None => {
                let built = (e.part as usize) < settings.parts.len();
                let built = built.then(|| build_block(settings, e.part as usize, e.shape));
                let Some(Ok(element)) = built else {
                    return Err(format!("element {} belongs to no part of the job", e.id));
                };
                known.insert(kind, Block::columns_of(&*element));
                known[&kind]
            }
        };
        if columns.len() != wanted {
            return Err(format!(
                "element {} has {} columns, and the element of its part has {wanted}",
                e.id,
                columns.len()
            ));
        }
    }
    Ok(())
}
