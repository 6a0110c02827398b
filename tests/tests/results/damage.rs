//! Damage in the field files: on any number of workers, and only in jobs with a material that has
//! one.

use crumple::results::field_file::{PieceArrays, pieces, steps};
use crumple_tests::fields::assert_same_fields;
use crumple_tests::program::{Ended, crumple_with, run};
use std::fs;
use std::path::PathBuf;

/// A row of four bricks that hits a wall end on.
fn row_of_bricks(law: &str, workers: &str) -> Ended {
    let corners = [[0.0, 0.0], [10.0, 0.0], [10.0, 10.0], [0.0, 10.0]];
    let node = |k: usize| {
        let [x, y] = corners[k % 4];
        format!("[{}, {x:?}, {y:?}, {:?}]", k + 1, 10.0 * (k / 4) as f64)
    };
    let nodes: Vec<String> = (0..20).map(node).collect();
    let brick = |k: usize| {
        let ids: Vec<String> = (0..8).map(|c| (4 * k + c + 1).to_string()).collect();
        format!("[{}, 1, {}]", k + 1, ids.join(", "))
    };
    let solids: Vec<String> = (0..4).map(brick).collect();
    let folder = tempfile::tempdir().unwrap();
    let job = folder.path().join("bricks.toml");
    let text = format!(
        "title = \"Bricks\"\nunits = \"mm, ms, kg\"\nend_time = 0.012\n[mesh]\nnodes = [{}]\n\
         solids = [{}]\n[output]\nfield_interval = 0.004\n[[material]]\nname = \"brick\"\n\
         density = 3.7e-6\n{law}\n[[part]]\nid = 1\nname = \"bricks\"\nmaterial = \"brick\"\n\
         [[wall]]\npoint = [0.0, 0.0, 0.0]\nnormal = [0.0, 0.0, 1.0]\n\
         [[initial_velocity]]\nvelocity = [0.0, 0.0, -400.0]\n",
        nodes.join(", "),
        solids.join(", "),
    );
    fs::write(&job, text).unwrap();
    let job = job.to_str().unwrap();
    run(crumple_with(&["run", job, "--quiet", "--workers", workers])).with_code(0)
}

const CERAMIC: &str = "law = \"johnson_holmquist_ceramic\"\nshear_modulus = 90.0\n\
    intact_strength = [0.93, 0.6]\nfractured_strength = [0.31, 0.6]\ntensile_strength = 0.2\n\
    hugoniot_elastic_limit = [2.79, 1.46]\npressure = [131.0, 0.0, 0.0]\ndamage = [0.02, 1.0]";

/// Returns the largest damage of each field file, none without the array.
fn largest(ended: &Ended) -> Vec<Option<f64>> {
    let of_step = |step: &crumple::results::field_file::FieldStep| {
        let all = pieces(&step.file).unwrap();
        let of_piece = |piece: &PathBuf| PieceArrays::read(piece).unwrap().array("damage").ok();
        let arrays: Option<Vec<_>> = all.iter().map(of_piece).collect();
        arrays.map(|arrays| arrays.concat().into_iter().fold(0.0, f64::max))
    };
    steps(&ended.out().join("fields/fields.pvd")).unwrap().iter().map(of_step).collect()
}

/// Bricks of ceramic break at the wall; the file has no damage at the start.
#[test]
fn damage_is_in_the_field_files() {
    let alone = row_of_bricks(CERAMIC, "1");
    let damage: Vec<f64> = largest(&alone).into_iter().map(|d| d.expect("an array")).collect();
    let last = *damage.last().expect("field files");
    assert_eq!(damage[0], 0.0);
    assert!(damage.is_sorted() && last > 0.1 && last <= 1.0, "{damage:?}");
    let other = row_of_bricks(CERAMIC, "2");
    assert_eq!(alone.digest(), other.digest());
    assert_same_fields(&alone.out(), &other.out());
    alone.read_fields();
}

#[test]
fn materials_without_damage_have_no_such_array() {
    let elastic = "law = \"elastic\"\nyoungs_modulus = 200.0\npoisson = 0.2";
    assert!(largest(&row_of_bricks(elastic, "1")).iter().all(Option::is_none));
}
