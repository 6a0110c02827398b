//! The page of a report while it plays, and its keys.

use super::report_page::{crushed, opened, sound};
use crumple_tests::browser::Browser;

/// Triangles that are drawn, pixels of a line, and the place of each drawn corner.
const DRAWN: &str = "(() => { const { areas } = crumple.view.surface; \
                     const index = Array.from(areas.index.array.subarray(0, areas.used)); \
                     return [areas.used / 3, crumple.view.canvas.width, \
                     index.flatMap((corner) => areas.place(corner, 0))]; })()";

fn drawn(browser: &mut Browser) -> (f64, f64, Vec<f64>) {
    serde_json::from_value(browser.evaluate(DRAWN)).unwrap()
}

/// A slow machine draws fewer faces and pixels while it plays: fewer triangles between corners of
/// the mesh, with the same ends. When it stops, everything is there again.
#[test]
fn a_large_model_plays_coarser_and_stops_whole() {
    let ended = crushed(&["scene.elements=8"]);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    let whole = drawn(&mut browser);
    let ends = |places: &[f64], c: usize| {
        let of_axis = places.chunks(3).map(|x| x[c]);
        of_axis.fold([f64::INFINITY, f64::NEG_INFINITY], |e, x| [e[0].min(x), e[1].max(x)])
    };
    // This model is small. A large one gets its share of the faces by the quality.
    browser.evaluate("crumple.qualities = [[1, 1], [0.8, 1]], crumple.quality = 1");
    browser.evaluate(
        "crumple.playing = true, crumple.simplify(1), \
         crumple.view.surface.coarsen(0.25), crumple.redraw()",
    );
    let coarse = drawn(&mut browser);
    // A quarter is asked for; how many faces vanish depends on where the cubes cut the tube.
    let share = coarse.0 / whole.0;
    assert!((0.15..0.4).contains(&share), "{} of {} triangles", coarse.0, whole.0);
    assert!((coarse.1 / whole.1 - 0.8).abs() < 0.01, "{} of {} pixels", coarse.1, whole.1);
    let known: Vec<&[f64]> = whole.2.chunks(3).collect();
    assert!(coarse.2.chunks(3).all(|x| known.contains(&x)), "a corner that the mesh has not");
    for c in 0..3 {
        let [before, now] = [ends(&whole.2, c), ends(&coarse.2, c)];
        // A cube has the sides of two of the eight elements over a side, 0.25, and the node nearest
        // to its middle stands in.
        let room = 0.2 * (before[1] - before[0]);
        assert!((now[0] - before[0]).abs() <= room && (now[1] - before[1]).abs() <= room);
    }
    browser.evaluate("crumple.play(false), crumple.go(crumple.begin)");
    assert_eq!(drawn(&mut browser), whole);
    sound(&mut browser);
}

/// Small models keep their faces, large ones at least 8000 of them.
#[test]
fn qualities_follow_the_size_of_the_model() {
    let ended = crushed(&["end_time=0.01"]);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    let mut of = |faces: u32| -> Vec<[f64; 2]> {
        serde_json::from_value(browser.evaluate(&format!("qualitiesOf({{ faces: {faces} }})")))
            .unwrap()
    };
    let small = of(7000);
    assert!(small.len() > 2 && small.iter().all(|[_, faces]| *faces == 1.0), "{small:?}");
    let large = of(64872);
    let least = large.iter().map(|[_, faces]| faces * 64872.0).fold(f64::INFINITY, f64::min);
    assert!((least - 8000.0).abs() < 1.0, "{large:?}");
    for all in [small, large] {
        assert_eq!(all[0], [1.0, 1.0]);
        assert_eq!(all[all.len() - 1][0], 0.5);
        assert!(all.windows(2).all(|q| q[1][0] <= q[0][0] && q[1][1] <= q[0][1] && q[0] != q[1]));
    }
}

#[test]
fn keys_play_step_look_and_draw_edges() {
    let ended = crushed(&[]);
    let Some(mut browser) = opened(&ended.out().join("report.html"), "") else { return };
    let mut press = |key: &str, sees: &str| {
        browser.press(key);
        assert_eq!(browser.evaluate(sees), true, "after {key}: {sees}");
    };
    press("End", "crumple.time === crumple.end");
    press("ArrowLeft", "crumple.time === crumple.stops.at(-2)");
    press("ArrowRight", "crumple.time === crumple.end");
    press("Home", "crumple.time === crumple.begin");
    press("e", "byId('edges').checked === false");
    press("e", "byId('edges').checked === true");
    let along = |c: usize| {
        format!(
            "(() => {{ const {{ camera, controls }} = crumple.view; \
             const way = camera.position.clone().sub(controls.target).normalize().toArray(); \
             return Math.abs(way[{c}]) > 0.999; }})()"
        )
    };
    press("2", &along(0));
    press("3", &along(1));
    press("4", &along(2));
    press(" ", "crumple.playing");
    press(" ", "!crumple.playing");
    sound(&mut browser);
}
