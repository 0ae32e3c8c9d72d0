//! The path of two axes, with the speed or the power of a laser as its colour.

use crate::figure::{GRID, INK, SOFT};
use crate::picture::{Colour, Frame, Picture, Shape, Style};
use crate::scale::number;
use crate::way::Paper;

/// The colours of the speed, from rest to the highest: dark blue, then green, then yellow. Each is
/// lighter than the one before, so that they differ without colour vision too.
const SPEEDS: [Colour; 12] = [
    [0x3b, 0x0f, 0x70],
    [0x42, 0x2f, 0x8a],
    [0x3a, 0x50, 0x9a],
    [0x2f, 0x6b, 0xa0],
    [0x26, 0x84, 0x9f],
    [0x1f, 0x9c, 0x96],
    [0x34, 0xb0, 0x80],
    [0x62, 0xc0, 0x63],
    [0x95, 0xcb, 0x48],
    [0xc4, 0xd0, 0x3a],
    [0xe8, 0xcb, 0x3f],
    [0xf7, 0xb8, 0x2d],
];

/// A line, and the index of its colour in [`SPEEDS`].
type Stroke = (Option<usize>, Vec<(f64, f64)>);

/// The colour of a path without a speed.
const PALE: Colour = [0xb8, 0xbc, 0xc2];

/// The path of two axes, and their speeds.
///
/// ```
/// use stepwright_plot::SpeedWay;
/// let mut way = SpeedWay::new(["X", "Y"], "mm", "mm/s");
/// for n in 0..=100 {
///     let x = f64::from(n);
///     way.go(x, 10.0 * (x / 10.0).sin(), 40.0 + x);
/// }
/// assert_eq!(way.fastest(), 140.0);
/// assert!(way.picture("A wave").shapes.len() > 20);
/// ```
#[derive(Clone, Debug)]
pub struct SpeedWay {
    names: [String; 2],
    unit: String,
    speed_unit: String,
    /// Points, and for each the speed on the path to it; `None` where no speed is shown.
    points: Vec<(f64, f64)>,
    speeds: Vec<Option<f64>>,
}

impl SpeedWay {
    /// The empty path of two axes with these names, in this unit, and the unit of the speed.
    pub fn new(names: [&str; 2], unit: &str, speed_unit: &str) -> SpeedWay {
        SpeedWay {
            names: names.map(str::to_owned),
            unit: unit.to_owned(),
            speed_unit: speed_unit.to_owned(),
            points: Vec::new(),
            speeds: Vec::new(),
        }
    }

    /// Adds a line to this point, at this speed.
    pub fn go(&mut self, x: f64, y: f64, speed: f64) {
        self.points.push((x, y));
        self.speeds.push(Some(speed));
    }

    /// Adds a line to this point without a speed: thin and pale, below the others.
    pub fn go_pale(&mut self, x: f64, y: f64) {
        self.points.push((x, y));
        self.speeds.push(None);
    }

    /// The highest speed.
    pub fn fastest(&self) -> f64 {
        self.speeds.iter().skip(1).copied().flatten().fold(0.0, f64::max)
    }

    /// Draws the path.
    pub fn picture(&self, title: &str) -> Picture {
        let names = [&*self.names[0], &*self.names[1]];
        let Paper { mut picture, frame, x, y } = Paper::new(title, names, &self.unit, &self.points);
        let fastest = self.fastest();
        let count = SPEEDS.len();
        let colour = |speed: f64| {
            let part = if fastest > 0.0 { speed / fastest } else { 0.0 };
            ((part * count as f64) as usize).min(count - 1)
        };
        let mut lines: Vec<Stroke> = Vec::new();
        let mut line: Vec<(f64, f64)> = Vec::new();
        let mut last = None;
        for (point, speed) in self.points.iter().zip(&self.speeds) {
            let (point, now) = ((x.at(point.0), y.at(point.1)), speed.map(colour));
            // No line leads to the first point.
            if line.len() > 1 && now != last {
                let end = line.last().copied();
                lines.push((last, std::mem::take(&mut line)));
                line.extend(end);
            }
            if line.len() > 1 && straight(&line[line.len() - 2..], point) {
                line.pop();
            }
            last = now;
            line.push(point);
        }
        if line.len() > 1 {
            lines.push((last, line));
        }
        // Pale lines come first, so that the others cover them.
        lines.sort_by_key(|(colour, _)| colour.is_some());
        for (colour, line) in lines {
            match colour.and_then(|n| SPEEDS.get(n)) {
                Some(colour) => picture.line(line, *colour, 2.0),
                None => picture.line(line, PALE, 1.0),
            }
        }
        if let Some(start) = self.points.first() {
            let points = vec![(x.at(start.0), y.at(start.1))];
            picture.shapes.push(Shape::Dots { points, fill: INK, radius: 5.0 });
        }
        self.legend(&mut picture, frame, fastest);
        picture
    }

    /// Draws a strip of the colours above the frame, with the speeds at its ends.
    fn legend(&self, picture: &mut Picture, frame: Frame, fastest: f64) {
        let (wide, high) = (16.0, 12.0);
        let all = wide * SPEEDS.len() as f64;
        let (left, top) = ((frame.right() - all).max(frame.left + 140.0), frame.top - 28.0);
        for (n, fill) in SPEEDS.into_iter().enumerate() {
            let left = left + wide * n as f64;
            picture.fill(Frame { left, top, width: wide, height: high }, fill, 1.0);
        }
        let label = Style::new(13.0, SOFT);
        let decimals = if fastest < 10.0 { 2 } else { 0 };
        let end = format!("{} {}", number(fastest, decimals), self.speed_unit);
        picture.text((left, top - 6.0), label, "0");
        picture.text((left + all, top - 6.0), label.end(), end);
        let edge = vec![(left, top + high), (left + all, top + high)];
        picture.line(edge, GRID, 1.0);
    }
}

/// Whether a point continues the straight line through two others. A bend with the chord c and the
/// angle θ to its end is c·θ/4 off in its middle; the limit is a twentieth of a pixel.
pub(crate) fn straight(line: &[(f64, f64)], point: (f64, f64)) -> bool {
    let &[a, b] = line else { return false };
    let (before, after) = ((b.0 - a.0, b.1 - a.1), (point.0 - b.0, point.1 - b.1));
    let off = (before.0 * after.1 - before.1 * after.0).abs();
    off <= 0.2 * after.0.hypot(after.1) && before.0 * after.0 + before.1 * after.1 >= 0.0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The coloured lines, without those of the grid.
    fn lines(way: &SpeedWay) -> Vec<(Colour, Vec<(f64, f64)>)> {
        let shapes = way.picture("A way").shapes.into_iter();
        let lines = shapes.filter_map(|shape| match shape {
            Shape::Line { points, colour, width: 2.0, .. } => Some((colour, points)),
            _ => None,
        });
        lines.collect()
    }

    #[test]
    fn the_colour_is_the_speed() {
        let mut way = SpeedWay::new(["X", "Y"], "mm", "mm/s");
        // The speed at the first point has no effect: no line leads there.
        way.go(0.0, 0.0, 999.0);
        for (x, y, speed) in [(10.0, 0.0, 100.0), (20.0, 0.0, 100.0), (20.0, 10.0, 1.0)] {
            way.go(x, y, speed);
        }
        let found = lines(&way);
        assert_eq!(found.iter().map(|line| line.0).collect::<Vec<_>>(), [SPEEDS[11], SPEEDS[0]]);
        // A straight line is a single segment, and the next line begins at its end.
        assert_eq!((found[0].1.len(), found[1].1.len()), (2, 2));
        assert_eq!(found[0].1[1], found[1].1[0]);
    }

    /// A pale path is thin, below the others; a line of another kind begins at its end.
    #[test]
    fn a_way_without_a_speed_is_pale() {
        let mut way = SpeedWay::new(["X", "Y"], "mm", "%");
        way.go_pale(0.0, 0.0);
        way.go(10.0, 0.0, 50.0);
        way.go_pale(20.0, 0.0);
        way.go_pale(20.0, 10.0);
        way.go(30.0, 10.0, 100.0);
        assert_eq!(way.fastest(), 100.0);
        let burnt = lines(&way);
        assert_eq!(burnt.iter().map(|line| line.0).collect::<Vec<_>>(), [SPEEDS[6], SPEEDS[11]]);
        let shapes = way.picture("A way").shapes;
        let at = |wanted: Colour| {
            let is =
                |shape: &Shape| matches!(shape, Shape::Line { colour, .. } if *colour == wanted);
            shapes.iter().position(is)
        };
        let pale = at(PALE).unwrap();
        assert!(Some(pale) < at(SPEEDS[6]));
        let Shape::Line { points, width, .. } = &shapes[pale] else { panic!() };
        assert_eq!((points.len(), *width, points[0]), (3, 1.0, burnt[0].1[1]));
    }

    #[test]
    fn a_bend_stays_a_bend() {
        let mut way = SpeedWay::new(["X", "Y"], "mm", "mm/s");
        for n in 0..=7_200 {
            let angle = f64::from(n).to_radians() / 20.0;
            way.go(50.0 * angle.cos(), 50.0 * angle.sin(), 10.0);
        }
        // The drawn circle stays round even if its points are very close.
        let found = lines(&way);
        let points = &found[0].1;
        let middle = [0, 1].map(|n| {
            let at = |point: &(f64, f64)| if n == 0 { point.0 } else { point.1 };
            let (low, high) =
                points.iter().map(at).fold((1e9f64, 0.0f64), |(a, b), v| (a.min(v), b.max(v)));
            (low + high) / 2.0
        });
        let away = |x: f64, y: f64| (x - middle[0]).hypot(y - middle[1]);
        let radius = away(points[0].0, points[0].1);
        for pair in points.windows(2) {
            let [(a, b), (c, d)] = [pair[0], pair[1]];
            assert!((away((a + c) / 2.0, (b + d) / 2.0) - radius).abs() < 0.3, "{pair:?}");
        }
        // A path there and back is not a straight line.
        let mut way = SpeedWay::new(["X", "Y"], "mm", "mm/s");
        [0.0, 10.0, 5.0].into_iter().for_each(|x| way.go(x, 0.0, 1.0));
        assert_eq!(lines(&way)[0].1.len(), 3);
    }

    #[test]
    fn a_way_of_nothing_is_paper() {
        assert!(lines(&SpeedWay::new(["X", "Y"], "mm", "mm/s")).is_empty());
    }
}
