//! The page and its files. They are part of the program; nothing in them depends on a user.

use super::App;
use axum::Router;
use axum::http::header::{CACHE_CONTROL, CONTENT_TYPE};
use axum::response::IntoResponse;
use axum::routing::get;

const HTML: &str = "text/html; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const STYLE: &str = "text/css; charset=utf-8";

/// Path, kind and text of each file.
const FILES: &[(&str, &str, &str)] = &[
    ("/", HTML, include_str!("../../../assets/service/page.html")),
    ("/assets/page.css", STYLE, include_str!("../../../assets/service/page.css")),
    ("/assets/report.css", STYLE, include_str!("../../../assets/report/page.css")),
    ("/assets/uplot.css", STYLE, include_str!("../../../assets/vendor/uPlot.min.css")),
    ("/assets/uplot.js", SCRIPT, include_str!("../../../assets/vendor/uPlot.min.js")),
    ("/assets/three.js", SCRIPT, include_str!("../../../assets/vendor/three.min.js")),
    ("/assets/decode.js", SCRIPT, include_str!("../../../assets/report/decode.js")),
    ("/assets/legend.js", SCRIPT, include_str!("../../../assets/report/legend.js")),
    ("/assets/coarse.js", SCRIPT, include_str!("../../../assets/report/coarse.js")),
    ("/assets/surface.js", SCRIPT, include_str!("../../../assets/report/surface.js")),
    ("/assets/walls.js", SCRIPT, include_str!("../../../assets/report/walls.js")),
    ("/assets/keys.js", SCRIPT, include_str!("../../../assets/report/keys.js")),
    ("/assets/view.js", SCRIPT, include_str!("../../../assets/report/view.js")),
    ("/assets/colours.js", SCRIPT, include_str!("../../../assets/report/colours.js")),
    ("/assets/plots.js", SCRIPT, include_str!("../../../assets/report/plots.js")),
    ("/assets/api.js", SCRIPT, include_str!("../../../assets/service/api.js")),
    ("/assets/findings.js", SCRIPT, include_str!("../../../assets/service/findings.js")),
    ("/assets/jobs.js", SCRIPT, include_str!("../../../assets/service/jobs.js")),
    ("/assets/live.js", SCRIPT, include_str!("../../../assets/service/live.js")),
    ("/assets/times.js", SCRIPT, include_str!("../../../assets/service/times.js")),
    ("/assets/compare.js", SCRIPT, include_str!("../../../assets/service/compare.js")),
    ("/assets/run.js", SCRIPT, include_str!("../../../assets/service/run.js")),
    ("/assets/main.js", SCRIPT, include_str!("../../../assets/service/main.js")),
];

/// Returns the routes of the page.
pub fn routes() -> Router<App> {
    FILES.iter().fold(Router::new(), |router, (path, kind, text)| {
        let answer = move || async move {
            ([(CONTENT_TYPE, *kind), (CACHE_CONTROL, "no-cache")], *text).into_response()
        };
        router.route(path, get(answer))
    })
}
