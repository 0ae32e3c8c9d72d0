//! Every format of a plot, down to its bytes' kind.

use super::*;

/// Three axes: one there and back, one slow, one that never moves.
fn axes() -> SpeedPlot {
    let there = (0..=400).map(|i| {
        let t = f64::from(i) * 0.01;
        (t, 900.0 * (t * std::f64::consts::FRAC_PI_2).sin())
    });
    let slow = vec![(0.0, 0.0), (0.5, 300.0), (3.5, 300.0), (4.0, 0.0)];
    SpeedPlot {
        title: "Three axes <&>".into(),
        notes: vec!["as the virtual board stepped them".into()],
        series: vec![
            Series { name: "axis 1".into(), points: there.collect() },
            Series { name: "axis 2".into(), points: slow },
            Series { name: "axis 3".into(), points: Vec::new() },
        ],
    }
}

#[test]
fn the_name_says_the_format() {
    for name in ["a.svg", "a.png", "dir/a.HTML"] {
        assert!(name.parse::<PlotFile>().is_ok(), "{name}");
    }
    for name in ["a.pdf", "svg", "", "."] {
        assert!(name.parse::<PlotFile>().is_err(), "{name}");
    }
}

#[test]
fn every_format_is_written() {
    let directory = std::env::temp_dir().join(format!("stepwright-plot-{}", std::process::id()));
    fs::create_dir_all(&directory).unwrap();
    let bytes = |name: &str| {
        let path = directory.join(name);
        axes().save(&path.to_str().unwrap().parse().unwrap()).unwrap();
        fs::read(path).unwrap()
    };
    assert!(bytes("a.png").starts_with(b"\x89PNG"));
    let svg = String::from_utf8(bytes("a.svg")).unwrap();
    assert!(svg.starts_with("<svg xmlns="));
    assert!(svg.contains(">Three axes &lt;&amp;&gt;</text>"));
    assert!(svg.contains(">time, s</text>") && svg.contains(">Speed, steps/s</text>"));
    let page = String::from_utf8(bytes("a.html")).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.contains(&svg));
    // One file, which asks nobody for anything.
    assert!(!page.contains("src=") && !page.contains("href="));
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn where_nothing_can_be_written_it_is_said() {
    let file: PlotFile = "/nonexistent/a.svg".parse().unwrap();
    assert!(axes().save(&file).is_err());
}

#[test]
fn a_million_points_stay_a_small_file() {
    let points = (0..1_000_000).map(|i| (f64::from(i) * 1e-5, f64::from(i % 7))).collect();
    let series = vec![Series { name: "a".into(), points }];
    let plot = SpeedPlot { title: "Noise".into(), notes: Vec::new(), series };
    assert!(svg::render(&plot.figure().picture()).len() < 300_000);
}

#[test]
fn nothing_at_all_is_a_picture_too() {
    let plot = SpeedPlot { title: String::new(), notes: Vec::new(), series: Vec::new() };
    let svg = svg::render(&plot.figure().picture());
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}
