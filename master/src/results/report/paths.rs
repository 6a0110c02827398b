//! Displacement of rigid walls over time, from `walls.csv`.

use super::plots::named;
use serde::{Deserialize, Serialize};
use std::path::Path;

/// Maximum number of times of a path. Longer histories are thinned.
const MOST_TIMES: usize = 1000;

/// Displacement of a wall over time.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct WallPath {
    /// Ascending times [time].
    pub times: Vec<f64>,
    /// Displacement at these times [length].
    pub moved: Vec<[f64; 3]>,
}

impl WallPath {
    /// Returns true if the wall ever moves.
    pub fn moves(&self) -> bool {
        self.moved.iter().any(|u| *u != [0.0; 3])
    }
}

/// Reads the paths of the walls in their order, as far as the file is intact. Returns none if it
/// is missing, or from a version that does not write displacements.
pub fn read(file: &Path) -> Vec<WallPath> {
    let Ok(mut reader) = csv::ReaderBuilder::new().flexible(true).from_path(file) else {
        return Vec::new();
    };
    let header: Vec<String> =
        reader.headers().into_iter().flatten().map(|h| named(h)[0].clone()).collect();
    let Some(first) = header.iter().position(|name| name == "displacement x") else {
        return Vec::new();
    };
    let mut paths: Vec<WallPath> = Vec::new();
    let mut wall = 0;
    for record in reader.records().map_while(Result::ok) {
        let number = |at: usize| record.get(at).and_then(|field| field.parse::<f64>().ok());
        let [Some(time), Some(x), Some(y), Some(z)] = [0, first, first + 1, first + 2].map(number)
        else {
            break;
        };
        // Rows come time by time, with the walls in their order.
        let again = paths.first().and_then(|p| p.times.last()) == Some(&time);
        wall = if again { wall + 1 } else { 0 };
        if wall == paths.len() {
            paths.push(WallPath::default());
        }
        let path = &mut paths[wall];
        path.times.push(time);
        path.moved.push([x, y, z]);
    }
    let every = paths.first().map_or(0, |p| p.times.len()).div_ceil(MOST_TIMES).max(1);
    for path in &mut paths {
        let last = path.times.len().saturating_sub(1);
        let kept = |row: &usize| row.is_multiple_of(every) || *row == last;
        path.times = (0..path.times.len()).filter(kept).map(|row| path.times[row]).collect();
        path.moved = (0..path.moved.len()).filter(kept).map(|row| path.moved[row]).collect();
    }
    paths
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn walls_have_the_places_of_their_rows() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("walls.csv");
        let mut text = "time [ms],wall,impulse x [kg mm/ms],\
             displacement x [mm],displacement y [mm],displacement z [mm]\n"
            .to_string();
        for row in 0..=2500 {
            text += &format!("{row}.0,a,1.0,{row}.5,0,0\n{row}.0,a,1.0,0,0,0\n");
        }
        text += "2501.0,a,1.0,7"; // truncated
        std::fs::write(&file, text).unwrap();
        let paths = read(&file);
        assert_eq!((paths.len(), paths[0].moves(), paths[1].moves()), (2, true, false));
        assert_eq!(
            (paths[0].times[..3].to_vec(), paths[0].moved[1]),
            (vec![0.0, 3.0, 6.0], [3.5, 0.0, 0.0])
        );
        assert_eq!((paths[0].times.len(), *paths[1].times.last().unwrap()), (835, 2500.0));
        std::fs::write(&file, "time [ms],wall,impulse x\n0,a,1\n").unwrap();
        assert!(read(&file).is_empty() && read(&dir.path().join("none")).is_empty());
    }
}
