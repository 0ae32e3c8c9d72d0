//! A picture as a page of its own, which tells the values under the mouse.

use serde_json::{Value, json};

use crate::picture::{Picture, Probe};
use crate::svg::{escaped, render};

/// The page: style, picture, data and script in one file, nothing from a
/// network.
pub fn page(title: &str, picture: &Picture) -> String {
    let probes: Vec<Value> = picture.probes.iter().map(probe).collect();
    // "</" can't stand in a script element.
    let data = json!(probes).to_string().replace("</", "<\\/");
    TEMPLATE
        .replace("{title}", &escaped(title))
        .replace("{svg}", &render(picture))
        .replace("{data}", &data)
}

fn probe(probe: &Probe) -> Value {
    let frame = probe.frame;
    let curves: Vec<Value> = probe
        .curves
        .iter()
        .map(|curve| {
            let points: Vec<_> = curve.points.iter().map(|p| p.map(short)).collect();
            json!({ "name": curve.name, "points": points })
        })
        .collect();
    json!({
        "left": frame.left,
        "right": frame.right(),
        "top": frame.top,
        "bottom": frame.bottom(),
        "x": probe.x_unit,
        "y": probe.y_unit,
        "curves": curves,
    })
}

/// Seven significant digits: the page need not carry more.
fn short(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

const TEMPLATE: &str = include_str!("page.html");
