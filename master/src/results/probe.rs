//! Values of a field over the elements of a part, from the field files of a run.
//!
//! The value of a point array for an element is the mean over its corners. The mean over equal
//! elements of a part is then the mean over its mass.

use crate::results::field_file::{PieceArrays, pieces_of_folder};
use crate::results::fields;
use crumple_worker::vtu::{self, Array, CELL_ARRAYS, POINT_ARRAYS};
use std::path::{Path, PathBuf};

/// Returns the values of a field per element at the output step nearest to `at`, or at the last
/// step.
///
/// # Errors
/// There is no such field, component or part, or no field file. The message lists those that
/// exist.
pub fn values(
    folder: &Path,
    field: &str,
    component: Option<&str>,
    part: Option<u32>,
    at: Option<f64>,
) -> Result<Vec<f64>, String> {
    let array = find(field)?;
    let pick = picker(array, component)?;
    let mut of_all = Vec::new();
    let mut parts = Vec::new();
    for path in pieces(folder, at)? {
        let piece = PieceArrays::read(&path)?;
        let numbers: Vec<f64> =
            piece.array(array.name)?.chunks(array.components).map(&pick).collect();
        let of_part = piece.array(vtu::PART.name)?;
        let keep = |e: usize| part.is_none_or(|p| f64::from(p) == of_part[e]);
        let on_points = POINT_ARRAYS.contains(array);
        let (corners, ends) = (piece.array("connectivity")?, piece.array("offsets")?);
        for (e, &end) in ends.iter().enumerate().filter(|(e, _)| keep(*e)) {
            let begin = if e == 0 { 0.0 } else { ends[e - 1] };
            let corners = &corners[begin as usize..end as usize];
            let mean =
                || corners.iter().map(|&c| numbers[c as usize]).sum::<f64>() / corners.len() as f64;
            of_all.push(if on_points { mean() } else { numbers[e] });
        }
        parts.extend(of_part.iter().map(|&p| p as u32));
    }
    if of_all.is_empty() {
        parts.sort_unstable();
        parts.dedup();
        return Err(format!(
            "no elements of part {part:?} in the field files; there are parts: {parts:?}"
        ));
    }
    Ok(of_all)
}

/// Returns the error in the names of a field and its component, if any.
pub fn unknown(field: &str, component: Option<&str>) -> Option<String> {
    find(field).and_then(|array| picker(array, component).map(|_| ())).err()
}

fn find(field: &str) -> Result<&'static Array, String> {
    let mut all = POINT_ARRAYS.iter().chain(CELL_ARRAYS);
    all.clone().find(|a| a.name == field).ok_or_else(|| {
        let names: Vec<&str> = all.by_ref().map(|a| a.name).collect();
        format!("there is no field `{field}`; there are: {}", names.join(", "))
    })
}

/// Returns the function that makes one number of the components.
fn picker(
    array: &Array,
    component: Option<&str>,
) -> Result<impl Fn(&[f64]) -> f64 + use<>, String> {
    let names: &[&str] = match array.components {
        3 => &["x", "y", "z"],
        6 => &["xx", "yy", "zz", "xy", "yz", "zx"],
        _ => &[],
    };
    let at = match component {
        None if array.components == 6 => {
            return Err(format!("give a component of `{}`: {}", array.name, names.join(", ")));
        }
        None => None,
        Some(c) => {
            Some(names.iter().position(|n| *n == c).ok_or_else(|| match names.is_empty() {
                true => format!("`{}` has no components", array.name),
                false => format!(
                    "`{}` has no component `{c}`; there are: {}",
                    array.name,
                    names.join(", ")
                ),
            })?)
        }
    };
    Ok(move |v: &[f64]| match at {
        Some(at) => v[at],
        None if v.len() == 1 => v[0],
        None => v.iter().map(|c| c * c).sum::<f64>().sqrt(),
    })
}

/// Returns the files of all workers at the step nearest to a time, or at the last step.
fn pieces(folder: &Path, at: Option<f64>) -> Result<Vec<PathBuf>, String> {
    let fields = folder.join(fields::DIR);
    let cannot = |error: std::io::Error| {
        format!("{}: {error}; check that the job writes fields", fields.display())
    };
    let mut steps = Vec::new();
    for entry in std::fs::read_dir(&fields).map_err(cannot)? {
        let pieces = pieces_of_folder(&entry.map_err(cannot)?.path());
        if let Some(first) = pieces.first() {
            steps.push((PieceArrays::read(first)?.time, pieces));
        }
    }
    let distance = |time: f64| at.map_or(-time, |at| (time - at).abs());
    let nearest = steps.into_iter().min_by(|a, b| distance(a.0).total_cmp(&distance(b.0)));
    nearest
        .map(|step| step.1)
        .ok_or_else(|| format!("{} contains no output step", fields.display()))
}
