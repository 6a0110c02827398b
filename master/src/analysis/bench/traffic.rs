//! `crumple bench --traffic`: the data that a step touches, by kind.

use super::{model, scenes::BenchScene};
use crate::run::embedded::run_alone;
use crumple_worker::step_data::StepData;
use serde::Serialize;
use std::fmt::Write;
use std::ops::ControlFlow;

/// Cycle after which the data are counted: contact has its lists then.
const COUNTED: u64 = 2;

/// Data that a step of a scene touches.
#[derive(Serialize)]
pub struct SceneTraffic {
    scene: &'static str,
    elements: usize,
    rows: Vec<TrafficRow>,
}

/// One kind of data, per element.
#[derive(Serialize)]
struct TrafficRow {
    data: &'static str,
    /// Size [bytes per element].
    bytes: f64,
    /// Number of times that a step reads and writes it.
    passes: [usize; 2],
}

/// Counts the data of scenes on one worker.
///
/// # Errors
/// A scene cannot be run: the reason.
pub fn count(scenes: &[&'static BenchScene]) -> Result<Vec<SceneTraffic>, String> {
    scenes.iter().map(|scene| count_scene(scene)).collect()
}

fn count_scene(scene: &'static BenchScene) -> Result<SceneTraffic, String> {
    let model = model(scene)?;
    let elements = model.mesh.elements.len();
    let ended = run_alone(&model, |engine| match engine.clock.cycle {
        cycle if cycle < COUNTED => ControlFlow::Continue(()),
        _ => ControlFlow::Break(()),
    })
    .map_err(|lost| lost.to_string())?;
    let engine = ended.engine;
    let contact = engine.contact.as_ref().map_or(0, |contact| contact.bytes());
    let of_contact =
        StepData { data: "contact: all its lists", bytes: contact, reads: 1, writes: 0 };
    let all = engine.blocks.step_data().into_iter().chain(engine.nodes.step_data());
    let per_element = |d: StepData| TrafficRow {
        data: d.data,
        bytes: d.bytes as f64 / elements as f64,
        passes: [d.reads, d.writes],
    };
    let rows = all.chain([of_contact]).filter(|d| d.bytes > 0).map(per_element).collect();
    Ok(SceneTraffic { scene: scene.name, elements, rows })
}

/// Formats the tables as Markdown.
pub fn table(all: &[SceneTraffic]) -> String {
    let mut out = String::from(
        "Data that a step reads or writes, in bytes per element on one worker. A pass reads or \
         writes all of it once.\n\
         Most lists of contact are not read in every step.\n",
    );
    for scene in all {
        // Writing to a string cannot fail.
        let _ = write!(
            out,
            "\n| {}, {} elements | bytes | read | written | bytes in passes |\n\
             |---|---|---|---|---|\n",
            scene.scene, scene.elements
        );
        let moved = |row: &TrafficRow| row.bytes * (row.passes[0] + row.passes[1]) as f64;
        for row in &scene.rows {
            let [reads, writes] = row.passes;
            let (data, bytes) = (row.data, row.bytes);
            let _ =
                writeln!(out, "| {data} | {bytes:.0} | {reads} | {writes} | {:.0} |", moved(row));
        }
        let bytes: f64 = scene.rows.iter().map(|row| row.bytes).sum();
        let passes: f64 = scene.rows.iter().map(moved).sum();
        let _ = writeln!(out, "| **all** | **{bytes:.0}** | | | **{passes:.0}** |");
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::analysis::bench::scenes::SCENES;

    /// The hexahedra of the bar have eight corners in 32-byte rows, eight four-byte node numbers,
    /// and the columns of their formulation; contact is absent. In single precision the columns are
    /// half as large.
    #[test]
    fn sizes_follow_from_the_layout() {
        let of = |name: &str| {
            let scene = SCENES.iter().find(|s| s.name == name).unwrap();
            count_scene(scene).unwrap()
        };
        let bytes = |scene: &SceneTraffic, data: &str| {
            scene.rows.iter().find(|row| row.data == data).map_or(0.0, |row| row.bytes)
        };
        let [double, single] = ["hex-bar", "hex-bar-single"].map(of);
        let near = |a: f64, b: f64| (a / b - 1.0).abs() < 0.02; // padding of the last group
        assert!(near(bytes(&double, "element nodal forces"), 256.0));
        assert!(near(bytes(&double, "nodes of elements"), 32.0 + 0.25));
        assert_eq!(bytes(&double, "contact: all its lists"), 0.0);
        let columns = [&double, &single].map(|s| bytes(s, "history columns"));
        assert!(near(columns[0], 2.0 * columns[1]) && columns[0] > 100.0, "{columns:?}");
        let tube = of("tube");
        assert!(bytes(&tube, "contact: all its lists") > 0.0);
        // Forces and moments.
        assert!(near(bytes(&tube, "element nodal forces"), 2.0 * 4.0 * 32.0));
    }
}
