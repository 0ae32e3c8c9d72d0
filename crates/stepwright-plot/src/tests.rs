//! Tests of all formats of a plot.

use super::*;

/// Three axes: one goes there and back, one is slow, one never moves.
fn axes() -> MotionPlot {
    let there = (0..=400).map(|i| {
        let t = f64::from(i) * 0.01;
        (t, 900.0 * (t * std::f64::consts::FRAC_PI_2).sin())
    });
    let slow = vec![(0.0, 0.0), (0.5, 300.0), (3.5, 300.0), (4.0, 0.0)];
    MotionPlot {
        title: "Three axes <&>".into(),
        notes: vec!["as the virtual board stepped them".into()],
        series: vec![
            AxisSeries { name: "axis 1".into(), speed: there.collect(), ..AxisSeries::default() },
            AxisSeries { name: "axis 2".into(), speed: slow, ..AxisSeries::default() },
            AxisSeries { name: "axis 3".into(), ..AxisSeries::default() },
        ],
        ..MotionPlot::default()
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
        let file: PlotFile = path.to_str().unwrap().parse().unwrap();
        file.save(&axes().figure()).unwrap();
        fs::read(path).unwrap()
    };
    assert!(bytes("a.png").starts_with(b"\x89PNG"));
    let svg = String::from_utf8(bytes("a.svg")).unwrap();
    assert!(svg.starts_with("<svg xmlns="));
    assert!(svg.contains(">Three axes &lt;&amp;&gt;</text>"));
    assert!(svg.contains(">time, s</text>") && svg.contains(">Speed, steps/s</text>"));
    assert!(svg.contains(">Acceleration, steps/s²</text>"));
    assert!(svg.contains(">Position, steps from the start</text>"));
    let page = String::from_utf8(bytes("a.html")).unwrap();
    assert!(page.starts_with("<!doctype html>") && page.contains(&svg));
    // The page is one file without references.
    assert!(!page.contains("src=") && !page.contains("href="));
    fs::remove_dir_all(directory).unwrap();
}

/// The check whether a file can be written changes nothing.
#[cfg(unix)]
#[test]
fn a_look_at_a_link_or_a_pipe_leaves_it_alone() {
    use std::os::unix::fs::{FileTypeExt, symlink};
    use std::process::Command;

    let directory = std::env::temp_dir().join(format!("stepwright-look-{}", std::process::id()));
    fs::create_dir_all(&directory).unwrap();
    let file = |name: &str| -> PlotFile { directory.join(name).to_str().unwrap().parse().unwrap() };
    // A link to a file that does not exist yet.
    symlink("later.svg", directory.join("link.svg")).unwrap();
    file("link.svg").check().unwrap();
    assert!(directory.join("link.svg").is_symlink() && !directory.join("later.svg").exists());
    file("link.svg").save(&axes().figure()).unwrap();
    assert!(directory.join("link.svg").is_symlink() && directory.join("later.svg").is_file());
    symlink("nowhere/later.svg", directory.join("stray.svg")).unwrap();
    assert!(file("stray.svg").check().is_err() && directory.join("stray.svg").is_symlink());
    // Opening a pipe would block without a reader, and end the reader otherwise.
    let made = Command::new("mkfifo").arg(directory.join("pipe.svg")).status();
    assert!(made.unwrap().success());
    let (looked, wait) = std::sync::mpsc::channel();
    let pipe = file("pipe.svg");
    std::thread::spawn(move || looked.send(pipe.check().is_ok()));
    assert_eq!(wait.recv_timeout(std::time::Duration::from_secs(10)), Ok(true));
    assert!(fs::metadata(directory.join("pipe.svg")).unwrap().file_type().is_fifo());
    assert!(file("new.svg").check().is_ok() && !directory.join("new.svg").exists());
    fs::remove_dir_all(directory).unwrap();
}

#[test]
fn where_nothing_can_be_written_it_is_said() {
    let file: PlotFile = "/nonexistent/a.svg".parse().unwrap();
    assert!(matches!(file.save(&axes().figure()), Err(PlotError::Write(..))));
}

#[test]
fn a_million_points_stay_a_small_file() {
    let points = (0..1_000_000).map(|i| (f64::from(i) * 1e-5, f64::from(i % 7))).collect();
    let series = vec![AxisSeries { name: "a".into(), speed: points, ..AxisSeries::default() }];
    let plot = MotionPlot { title: "Noise".into(), series, ..MotionPlot::default() };
    assert!(svg::render(&plot.figure().picture()).len() < 300_000);
}

#[test]
fn nothing_at_all_is_a_picture_too() {
    let plot = MotionPlot::default();
    let svg = svg::render(&plot.figure().picture());
    assert!(!svg.contains("NaN") && !svg.contains("inf"));
}

/// A figure with one panel, and a curve for each name.
fn panel(names: &[&str], view: View) -> Figure {
    let curve = |name: &&str| Curve {
        name: (*name).into(),
        points: (0..=100).map(|i| (f64::from(i), f64::from(i))).collect(),
        dots: vec![(10.0, 10.0), (50.0, 50.0)],
        ..Curve::default()
    };
    let y = ("Speed".to_owned(), "rpm".to_owned());
    let curves = names.iter().map(curve).collect();
    let panel = Panel { y, curves, view, ..Panel::default() };
    Figure { title: String::new(), notes: Vec::new(), rows: vec![(400.0, vec![panel])] }
}

/// The points of the curves' lines, which are wider than those of axes.
fn drawn(figure: &Figure) -> Vec<(f64, f64)> {
    let shapes = figure.picture().shapes;
    let lines = shapes.into_iter().filter_map(|shape| match shape {
        picture::Shape::Line { points, width: 2.4, .. } => Some(points),
        picture::Shape::Dots { points, .. } => Some(points),
        _ => None,
    });
    lines.flatten().collect()
}

#[test]
fn a_view_cuts_what_lies_outside() {
    let view = View { x: Some((20.0, 60.0)), y: Some((30.0, 90.0)) };
    let figure = panel(&["one"], view);
    let frame = figure.picture().probes[0].frame;
    let points = drawn(&figure);
    // From (30, 30) to (60, 60), and one of the dots.
    let within = |(x, y): &(f64, f64)| {
        (frame.left - 1e-9..=frame.right() + 1e-9).contains(x)
            && (frame.top - 1e-9..=frame.bottom() + 1e-9).contains(y)
    };
    assert!(points.len() == 32 && points.iter().all(within), "{points:?}");
    assert_eq!(points[0], (frame.left + frame.width / 4.0, frame.bottom()));
    // Without a view all is shown: 101 points and both dots.
    assert_eq!(drawn(&panel(&["one"], View::default())).len(), 103);
}

#[test]
fn a_legend_that_is_too_long_takes_more_rows() {
    let top = |names: &[&str]| panel(names, View::default()).picture().probes[0].frame.top;
    let long = "a name that is as long as some of them are";
    let (one, two) = (top(&["a", "b"]), top(&[long; 4]));
    assert_eq!(two - one, 21.0);
    // No two names overlap, and none is beyond the edges.
    let shapes = panel(&[long; 4], View::default()).picture().shapes;
    let names = shapes.into_iter().filter_map(|shape| match shape {
        picture::Shape::Text { x, y, text, .. } if text == long => Some((x, y)),
        _ => None,
    });
    let names: Vec<_> = names.collect();
    assert_eq!(names.len(), 4);
    for (i, a) in names.iter().enumerate() {
        assert!(a.0 > 0.0 && a.1 > 0.0);
        assert!(names[..i].iter().all(|b| a.1 != b.1 || (a.0 - b.0).abs() > 200.0), "{names:?}");
    }
}

#[test]
fn dashes_are_dashes() {
    let mut figure = panel(&["one"], View::default());
    let svg = |figure: &Figure| svg::render(&figure.picture());
    assert!(!svg(&figure).contains("stroke-dasharray"));
    figure.rows[0].1[0].curves[0].dashed = true;
    assert!(svg(&figure).contains("stroke-dasharray"));
}

#[test]
fn several_files_have_names_of_their_own() {
    let file: PlotFile = "dir/figure.png".parse().unwrap();
    assert_eq!(file.numbered("8").path, PathBuf::from("dir/figure-8.png"));
}

/// A panel whose y axis contains these values.
fn far(values: [f64; 2]) -> String {
    let mut figure = panel(&["one"], View::default());
    figure.rows[0].1[0].curves[0].points = vec![(0.0, values[0]), (1.0, values[1])];
    svg::render(&figure.picture())
}

#[test]
fn long_numbers_are_in_millions() {
    let svg = far([0.0, 2_147_483_647.0]);
    assert!(svg.contains(">Speed, million rpm</text>") && svg.contains(">2000</text>"), "{svg}");
    let svg = far([-90_000_000.0, 0.0]);
    assert!(svg.contains(">Speed, million rpm</text>") && svg.contains(">−80</text>"), "{svg}");
    assert!(far([0.0, 900_000.0]).contains(">Speed, rpm</text>"));
}

/// Shaded ranges are visible even without a curve, and never beyond the frame.
#[test]
fn bands_stay_within_their_panel() {
    let mut figure = panel(&["one"], View::default());
    let panel = &mut figure.rows[0].1[0];
    panel.curves[0].points.clear();
    panel.bands = vec![Band { from: 0.0, to: 63.0, name: "up".into(), tint: [1, 2, 3] }];
    let picture = figure.picture();
    let frame = picture.probes[0].frame;
    let band = picture.shapes.iter().find_map(|shape| match shape {
        Shape::Box { x, width, fill: [1, 2, 3], .. } => Some((*x, *width)),
        _ => None,
    });
    assert_eq!(band, Some((frame.left, frame.width)));
}

/// A line with hundreds of turns is thin, so that its strokes stay separate.
#[test]
fn hundreds_of_joints_are_drawn_thin() {
    let widths = |turns: u32| -> Vec<f64> {
        let mut figure = panel(&["one"], View::default());
        figure.rows[0].1[0].curves[0].points =
            (0..turns).map(|n| (f64::from(n), f64::from(n % 2) * 9.0)).collect();
        let lines = figure.picture().shapes.into_iter().filter_map(|shape| match shape {
            Shape::Line { points, width, .. } if points.len() > 2 => Some(width),
            _ => None,
        });
        lines.collect()
    };
    assert_eq!(widths(40), [2.4]);
    assert!(widths(700)[0] < 1.3, "{:?}", widths(700));
}

/// A note that is too long is broken between two facts. A small jitter does not make the line
/// thinner.
#[test]
fn notes_are_broken_and_jitter_is_no_joint() {
    let mut figure = panel(&["one"], View::default());
    figure.rows[0].1[0].curves[0].points =
        (0..700).map(|n| (f64::from(n), 9.0 + f64::from(n % 2) * 0.1)).collect();
    let facts: Vec<_> = (0..12).map(|n| format!("fact number {n} of twelve")).collect();
    figure.notes = vec![facts.join(GAP)];
    let svg = svg::render(&figure.picture());
    assert!(svg.contains("stroke-width=\"2.4\""));
    let line = |n: usize| svg.lines().find(|l| l.contains(&format!("number {n} of"))).unwrap();
    assert!(line(0) == line(4) && line(0) != line(6) && line(6) != line(11), "{svg:.2000}");
}

/// Values that are not finite leave gaps, and nothing hangs.
#[test]
fn values_without_end_are_gaps() {
    let wrong = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY];
    for (n, value) in wrong.into_iter().enumerate() {
        for at in [(1.0, value), (value, 1.0)] {
            let points = vec![(0.0, 1.0), (0.5, 2.0), at, (2.0, 2.0), (3.0, 1.0)];
            let mut figure = panel(&["one"], View::default());
            figure.rows[0].1[0].curves[0].points = points.clone();
            figure.rows[0].1[0].curves[0].dots = points.clone();
            let picture = figure.picture();
            assert_eq!(picture.probes[0].curves[0].points.len(), 4, "{n}");
            let series = AxisSeries { speed: points, ..AxisSeries::default() };
            let plot = MotionPlot { series: vec![series], ..MotionPlot::default() };
            for svg in [svg::render(&picture), plot.figure().svg()] {
                assert!(!svg.contains("NaN") && !svg.contains("inf"), "{value}");
            }
        }
    }
}
