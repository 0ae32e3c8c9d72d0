//! The page itself: files that the binary carries.

use std::sync::Arc;

use axum::Router;
use axum::http::header::CONTENT_TYPE;
use axum::routing::get;

use crate::desk::ServeDesk;

const HTML: &str = "text/html; charset=utf-8";
const CSS: &str = "text/css; charset=utf-8";
const SCRIPT: &str = "text/javascript; charset=utf-8";
const PICTURE: &str = "image/svg+xml";

/// Every file of the page: its address, its type and its text.
const FILES: &[(&str, &str, &str)] = &[
    ("/", HTML, include_str!("page/index.html")),
    ("/style.css", CSS, include_str!("page/style.css")),
    ("/icon.svg", PICTURE, include_str!("page/icon.svg")),
    ("/main.js", SCRIPT, include_str!("page/main.js")),
    ("/server.js", SCRIPT, include_str!("page/server.js")),
    ("/axis.js", SCRIPT, include_str!("page/axis.js")),
    ("/scope.js", SCRIPT, include_str!("page/scope.js")),
    ("/edges.js", SCRIPT, include_str!("page/edges.js")),
    ("/calc.js", SCRIPT, include_str!("page/calc.js")),
    ("/settings.js", SCRIPT, include_str!("page/settings.js")),
    ("/talk.js", SCRIPT, include_str!("page/talk.js")),
    ("/plots.js", SCRIPT, include_str!("page/plots.js")),
    ("/curves.js", SCRIPT, include_str!("page/curves.js")),
    ("/uplot.css", CSS, include_str!("page/vendor/uPlot.min.css")),
    ("/uplot.js", SCRIPT, include_str!("page/vendor/uPlot.iife.min.js")),
];

/// Their addresses.
pub(crate) fn routes() -> Router<Arc<ServeDesk>> {
    FILES.iter().fold(Router::new(), |routes, (path, kind, text)| {
        routes.route(path, get(async move || ([(CONTENT_TYPE, *kind)], *text)))
    })
}

#[cfg(test)]
mod tests {
    use super::FILES;

    #[test]
    fn the_page_is_small_and_has_all_that_it_names() {
        let bytes: usize = FILES.iter().map(|(_, _, text)| text.len()).sum();
        assert!(bytes <= 300_000, "{bytes}");
        for (path, kind, text) in FILES.iter().filter(|(path, ..)| !path.starts_with("/uplot")) {
            for quoted in text.split(['"', '\'']).filter(|word| word.starts_with("./")) {
                let named = quoted.trim_start_matches('.');
                assert!(FILES.iter().any(|(path, ..)| *path == named), "{path} ({kind}): {named}");
            }
        }
    }
}
