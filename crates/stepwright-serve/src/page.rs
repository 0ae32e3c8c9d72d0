//! The page itself: files within the binary.

use std::sync::Arc;

use axum::Router;
use axum::http::header::CONTENT_TYPE;
use axum::routing::get;

use crate::desk::ServeDesk;

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const PICTURE: &str = "image/svg+xml";
const WASM: &str = "application/wasm";

/// All files of the page: the address, the type and the bytes.
const FILES: &[(&str, &str, &[u8])] = &[
    ("/", HTML, include_bytes!("page/index.html")),
    ("/style.css", CSS, include_bytes!("page/style.css")),
    ("/icon.svg", PICTURE, include_bytes!("page/icon.svg")),
    ("/main.js", SCRIPT, include_bytes!("page/main.js")),
    ("/declined.js", SCRIPT, include_bytes!("page/declined.js")),
    ("/server.js", SCRIPT, include_bytes!("page/server.js")),
    ("/axis.js", SCRIPT, include_bytes!("page/axis.js")),
    ("/line.js", SCRIPT, include_bytes!("page/line.js")),
    ("/scope.js", SCRIPT, include_bytes!("page/scope.js")),
    ("/edges.js", SCRIPT, include_bytes!("page/edges.js")),
    ("/calc.js", SCRIPT, include_bytes!("page/calc.js")),
    ("/colours.js", SCRIPT, include_bytes!("page/colours.js")),
    ("/dom.js", SCRIPT, include_bytes!("page/dom.js")),
    ("/settings.js", SCRIPT, include_bytes!("page/settings.js")),
    ("/settings-fields.js", SCRIPT, include_bytes!("page/settings-fields.js")),
    ("/talk.js", SCRIPT, include_bytes!("page/talk.js")),
    ("/plots.js", SCRIPT, include_bytes!("page/plots.js")),
    ("/curves.js", SCRIPT, include_bytes!("page/curves.js")),
    ("/start.js", SCRIPT, include_bytes!("page/start.js")),
    ("/plan.css", CSS, include_bytes!("page/plan.css")),
    ("/plan.js", SCRIPT, include_bytes!("page/plan.js")),
    ("/plan-board.js", SCRIPT, include_bytes!("page/plan-board.js")),
    ("/plan-charts.js", SCRIPT, include_bytes!("page/plan-charts.js")),
    ("/plan-copy.js", SCRIPT, include_bytes!("page/plan-copy.js")),
    ("/paths.css", CSS, include_bytes!("page/paths.css")),
    ("/paths.js", SCRIPT, include_bytes!("page/paths.js")),
    ("/paths-draw.js", SCRIPT, include_bytes!("page/paths-draw.js")),
    ("/planner.js", SCRIPT, include_bytes!("page/planner.js")),
    ("/plan.wasm", WASM, include_bytes!("page/plan.wasm")),
    ("/uplot.css", CSS, include_bytes!("page/vendor/uPlot.min.css")),
    ("/uplot.js", SCRIPT, include_bytes!("page/vendor/uPlot.iife.min.js")),
];

/// The addresses of the files.
pub(crate) fn routes() -> Router<Arc<ServeDesk>> {
    FILES.iter().fold(Router::new(), |routes, (path, kind, bytes)| {
        routes.route(path, get(async move || ([(CONTENT_TYPE, *kind)], *bytes)))
    })
}

#[cfg(test)]
mod tests {
    use super::FILES;

    #[test]
    fn the_page_is_small_and_has_all_that_it_names() {
        let bytes: usize = FILES.iter().map(|(_, _, bytes)| bytes.len()).sum();
        assert!(bytes <= 300_000, "{bytes}");
        let own = |path: &str| !path.starts_with("/uplot") && !path.ends_with(".wasm");
        for (path, kind, bytes) in FILES.iter().filter(|(path, ..)| own(path)) {
            let text = str::from_utf8(bytes).unwrap();
            // Files only for a page without this server are in a folder of their own.
            let named = |word: &&str| word.starts_with("./") && !word.starts_with("./alone/");
            for quoted in text.split(['"', '\'']).filter(named) {
                let named = quoted.trim_start_matches('.');
                assert!(FILES.iter().any(|(path, ..)| *path == named), "{path} ({kind}): {named}");
            }
        }
    }
}
