//! A picture as an HTML page, which shows the values under the mouse.

use serde_json::{Value, json};

use crate::picture::{Picture, Probe};
use crate::svg::{escaped, render};

/// The page: style, picture, data and script in one file, without network access.
pub fn page(title: &str, picture: &Picture) -> String {
    let probes: Vec<Value> = picture.probes.iter().map(probe).collect();
    // Text after a "<" could end the script element.
    let data = json!(probes).to_string().replace('<', "\\u003c");
    // Searches each mark after the one before, because inserted text may contain marks.
    let mut page = String::new();
    let mut rest = TEMPLATE;
    for (mark, text) in [("{title}", escaped(title)), ("{svg}", render(picture)), ("{data}", data)]
    {
        let Some((before, behind)) = rest.split_once(mark) else { continue };
        page.extend([before, &text]);
        rest = behind;
    }
    page + rest
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

/// Rounds to seven significant digits, to keep the page small.
fn short(value: f64) -> f64 {
    format!("{value:.6e}").parse().unwrap_or(value)
}

const TEMPLATE: &str = include_str!("page.html");

#[cfg(test)]
mod tests {
    use super::*;
    use crate::picture::{Frame, ProbeCurve, Style};

    /// Names are inserted as text, even if they look like marks of the template or like tags.
    #[test]
    fn names_are_text() {
        let names = [
            "{data}",
            "{svg}{title}",
            "<img src=x onerror=alert(1)>",
            "<!--<script>",
            "</script>",
            "a & \"b\"",
        ];
        let mut picture = Picture::new(100.0, 100.0);
        for name in names {
            picture.text((0.0, 0.0), Style::new(9.0, [0; 3]), name);
        }
        let curves = names.map(|name| ProbeCurve { name: name.into(), points: Vec::new() });
        picture.probes.push(Probe {
            frame: Frame { left: 0.0, top: 0.0, width: 9.0, height: 9.0 },
            x_unit: "s".into(),
            y_unit: "<b>".into(),
            curves: curves.into(),
        });
        let page = page(&names.concat(), &picture);
        let title = format!("<title>{}</title>", escaped(&names.concat()));
        assert!(page.contains(&title) && page.contains(&render(&picture)), "{page}");
        let data = page.split("const probes = ").nth(1).unwrap().split(";\n").next().unwrap();
        assert!(!data.contains('<'), "{data}");
        let data: Value = serde_json::from_str(data).unwrap();
        let told: Vec<_> = (data[0]["curves"].as_array().unwrap().iter())
            .map(|curve| curve["name"].as_str().unwrap())
            .collect();
        assert_eq!((told, data[0]["y"].as_str()), (names.to_vec(), Some("<b>")));
        assert_eq!(page.matches("<script").count(), 1);
    }
}
