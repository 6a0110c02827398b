//! One state of a run as a picture, for the page of the service: the scene of the report at one
//! time, with a limited number of faces.

use super::encode::encode;
use super::paths;
use super::scene::PageScene;
use super::series::{MeshSeries, read_state};
use super::sources::{self, RunFiles};
use super::surface::faces;
use super::{node_scalars, scalars};
use crate::results::field_file::{self, FieldStep};
use crate::results::fields::{COLLECTION, DIR};
use base64::{Engine, prelude::BASE64_STANDARD};
use serde_json::{Map, Value, json};
use std::path::{Path, PathBuf};

/// Maximum number of faces: 100,000 triangles.
const MOST_FACES: usize = 50_000;
/// Number of trials to find a scene with fewer faces: the number of cubes is found to 7 %.
const TRIALS: usize = 7;
/// Maximum size of the files of a state [bytes]; about twice that is needed in memory.
const MOST_BYTES: u64 = 150_000_000;

/// A state of a run in files.
#[derive(Clone, Debug, PartialEq)]
pub struct PictureState {
    /// Simulated time [time].
    pub time: f64,
    /// Files of the workers' pieces.
    pub pieces: Vec<PathBuf>,
}

impl PictureState {
    /// Returns the newest output of the run in `dir` up to a time, else the first one; none
    /// without output.
    pub fn output_at(dir: &Path, time: f64) -> Option<Self> {
        let steps = outputs(dir);
        let step = steps.iter().rev().find(|step| step.time <= time).or(steps.first())?;
        Some(Self { time: step.time, pieces: field_file::pieces(&step.file).ok()? })
    }

    /// Checks the size of the files.
    ///
    /// # Errors
    /// They are too large for a picture.
    pub fn check_size(&self) -> Result<(), String> {
        let size = |file: &PathBuf| std::fs::metadata(file).map_or(0, |about| about.len());
        let bytes: u64 = self.pieces.iter().map(size).sum();
        let mb = |bytes: u64| bytes / 1_000_000;
        match bytes > MOST_BYTES {
            true => Err(format!(
                "the state has {} MB; the page shows states of at most {} MB",
                mb(bytes),
                mb(MOST_BYTES)
            )),
            false => Ok(()),
        }
    }

    /// Returns the picture as JSON: `model`, which describes it, the bytes `picture` in base64,
    /// `scalars`, `part_names` and `walls`, and the `times` of all outputs. `about` has the keys
    /// `units`, `parts` and `walls` of `summary.json`; without it, that file of the run in `dir` is
    /// read, if it exists.
    ///
    /// # Errors
    /// The files cannot be read.
    pub fn picture(&self, dir: &Path, about: Option<&Map<String, Value>>) -> Result<Value, String> {
        let series = read_state(&self.pieces, self.time)?;
        let scene = limited(PageScene::new(&series, faces(&series)), &series, MOST_FACES);
        let (model, picture) = encode(&series, &scene);
        let summary = match about {
            Some(about) => Some(about.clone()),
            None => sources::summary(&dir.join("summary.json")).ok(),
        };
        let paths = paths::read(&dir.join("walls.csv"));
        let sources = RunFiles { summary, paths, ..RunFiles::default() };
        Ok(json!({
            "faces_seen": scene.faces_seen,
            "times": outputs(dir).iter().map(|step| step.time).collect::<Vec<_>>(),
            "scalars": scalars(&sources),
            "node_scalars": node_scalars(&sources),
            "length_unit": sources.length_and_stress()[0],
            "part_names": sources.part_names(),
            "walls": sources.walls(),
            "model": model,
            "picture": BASE64_STANDARD.encode(picture),
        }))
    }
}

/// Returns the outputs of the run in `dir`, with ascending times.
fn outputs(dir: &Path) -> Vec<FieldStep> {
    field_file::steps(&dir.join(DIR).join(COLLECTION)).unwrap_or_default()
}

/// Returns the scene, coarser if it has more than `most` faces: by as little as a few trials find.
/// Slender models need more cubes along their length than others, so that their faces stay.
fn limited(whole: PageScene, series: &MeshSeries, most: usize) -> PageScene {
    if whole.faces.len() <= most {
        return whole;
    }
    let (mut few, mut many) = (1.0, whole.faces.len() as f64);
    let mut scene = whole.coarser(series, 1);
    for _ in 0..TRIALS {
        let cubes = f64::sqrt(few * many);
        let trial = whole.coarser(series, cubes as usize);
        if trial.faces.len() > most {
            many = cubes;
        } else {
            (few, scene) = (cubes, trial);
        }
    }
    scene
}

#[cfg(test)]
mod tests {
    use super::super::scene::tests::sheet;
    use super::*;

    /// A slender sheet keeps more than half of the faces that it may have.
    #[test]
    fn a_scene_is_coarser_if_it_has_too_many_faces() {
        let (series, whole) = sheet(1000, 4);
        assert_eq!(limited(whole.clone(), &series, MOST_FACES).faces.len(), 4000);
        let coarse = limited(whole, &series, 1500);
        assert!((750..=1500).contains(&coarse.faces.len()), "{}", coarse.faces.len());
        assert_eq!(coarse.faces_seen, 4000);
    }

    #[test]
    fn a_folder_without_fields_has_no_state_and_damaged_files_are_named() {
        let dir = tempfile::tempdir().unwrap();
        assert_eq!(PictureState::output_at(dir.path(), f64::INFINITY), None);
        let file = dir.path().join("piece.vtu");
        std::fs::write(&file, "<VTKFile").unwrap();
        let state = PictureState { time: 0.0, pieces: vec![file] };
        assert!(state.picture(dir.path(), None).unwrap_err().contains("piece.vtu"));
        let large = dir.path().join("large.vtu");
        std::fs::File::create(&large).unwrap().set_len(MOST_BYTES + 1_000_000).unwrap();
        let state = PictureState { time: 0.0, pieces: vec![large] };
        assert!(state.check_size().unwrap_err().contains("at most 150 MB"));
    }
}
