//! The path of two motors, both axes to the same scale.

use crate::figure::{GRID, INK, PALETTE, SOFT};
use crate::picture::{Frame, Picture, Shape, Style};
use crate::scale::{Scale, number};
use crate::speed_way::straight;
use crate::{clip, width};

/// The most points that are kept: more than can be distinguished.
const POINTS: usize = 200_000;

/// The number of further points that are collected before thinning.
const WAITING: usize = 50_000;

/// The path of two motors.
pub struct WayPlot {
    /// The names of the motors, in the order of the axes.
    pub names: (String, String),
    unit: String,
    points: Vec<(i64, i64)>,
    /// The number of points that were thinned. Of the visible ones, one in `every` is kept.
    settled: usize,
    every: usize,
}

impl WayPlot {
    /// The empty path of two motors with these names, in this unit.
    pub fn new(names: (String, String), unit: String) -> WayPlot {
        WayPlot { names, unit, points: Vec::new(), settled: 0, every: 1 }
    }

    /// Adds a line to this point. Only the ends of a straight line are kept.
    pub fn go(&mut self, x: i64, y: i64) {
        if self.points.last() == Some(&(x, y)) {
            return;
        }
        if let [.., a, b] = self.points.as_slice() {
            let way = |a: &(i64, i64), b: &(i64, i64)| {
                (i128::from(b.0) - i128::from(a.0), i128::from(b.1) - i128::from(a.1))
            };
            let (before, after) = (way(a, b), way(b, &(x, y)));
            let straight = before.0.checked_mul(after.1) == before.1.checked_mul(after.0);
            let onward =
                before.0.signum() == after.0.signum() && before.1.signum() == after.1.signum();
            if straight && onward {
                self.points.pop();
            }
        }
        if self.points.len() >= self.settled + WAITING {
            self.settle();
        }
        self.points.push((x, y));
    }

    /// Drops points that are not visible in a picture. If too many are left, drops every second one
    /// from now on.
    fn settle(&mut self) {
        let range = |of: fn(&(i64, i64)) -> i64| {
            let values = self.points.iter().map(of);
            values.fold((i64::MAX, i64::MIN), |(low, high), v| (low.min(v), high.max(v)))
        };
        let span = [range(|p| p.0), range(|p| p.1)].map(|(low, high)| high.abs_diff(low));
        let pixel = SIDE / span[0].max(span[1]).max(1) as f64;
        let waiting = self.points.split_off(self.settled);
        let seen = thinned(&waiting, |p| (p.0 as f64 * pixel, p.1 as f64 * pixel));
        self.points.extend(seen.into_iter().step_by(self.every));
        if self.points.len() > POINTS {
            self.every *= 2;
            let mut odd = false;
            self.points.retain(|_| {
                odd = !odd;
                odd
            });
        }
        self.settled = self.points.len();
    }

    /// Draws the path.
    pub fn picture(&self, title: &str) -> Picture {
        let largest = self
            .points
            .iter()
            .map(|p| p.0.unsigned_abs().max(p.1.unsigned_abs()))
            .max()
            .unwrap_or(0);
        let (unit, per) = shown_in(&self.unit, largest as f64);
        let points: Vec<_> =
            self.points.iter().map(|&(x, y)| (x as f64 / per, y as f64 / per)).collect();
        let names = [&*self.names.0, &*self.names.1];
        let Paper { mut picture, frame, x, y } = Paper::new(title, names, &unit, &points);
        let line: Vec<_> = points.iter().map(|p| (x.at(p.0), y.at(p.1))).collect();
        let line = thinned(&line, |p| p);
        let ends = [line.first().copied(), line.last().copied()];
        // With very many corners a wide line would look like a block.
        let corners = corners(&line) as f64;
        picture.line(line.clone(), PALETTE[0], (300.0 / corners.max(1.0)).clamp(1.0, 2.0));
        // A larger dot at the start, a smaller one at the end.
        for ((end, fill), radius) in ends.into_iter().flatten().zip(PALETTE).zip([6.0, 4.0]) {
            picture.shapes.push(Shape::Dots { points: vec![end], fill, radius });
        }
        if let [Some(start), Some(end)] = ends {
            let mut labels = Labels { picture: &mut picture, frame, line: &line, taken: None };
            if near(start, end) {
                let name = if start == end { "start and end" } else { "start, end" };
                labels.add(start, name);
            } else {
                labels.add(start, "start");
                labels.add(end, "end");
            }
        }
        picture
    }
}

/// Drops the points that are less than a twentieth of a pixel off the line through the others.
fn thinned<P: Copy>(points: &[P], pixels: impl Fn(P) -> (f64, f64)) -> Vec<P> {
    let mut kept: Vec<P> = Vec::new();
    for &point in points {
        if let [.., a, b] = kept[..]
            && straight(&[pixels(a), pixels(b)], pixels(point))
        {
            kept.pop();
        }
        kept.push(point);
    }
    kept
}

/// The empty drawing of a path: its frame, the grid, and the scales.
pub(crate) struct Paper {
    pub picture: Picture,
    pub frame: Frame,
    pub x: Scale,
    pub y: Scale,
}

impl Paper {
    /// A drawing around these points, both axes to the same scale.
    pub fn new(title: &str, names: [&str; 2], unit: &str, points: &[(f64, f64)]) -> Paper {
        let range = |values: &mut dyn Iterator<Item = f64>| {
            let (low, high) = values.fold((f64::MAX, f64::MIN), |(a, b), v| (a.min(v), b.max(v)));
            if low > high { (0.0, 0.0) } else { (low, high) }
        };
        let (x, y) =
            (range(&mut points.iter().map(|p| p.0)), range(&mut points.iter().map(|p| p.1)));
        let span = (x.1 - x.0).max(y.1 - y.0);
        let span = if span > 0.0 { span } else { 1.0 };
        // A margin around the path, and a minimum height for a straight line.
        let side = |(low, high): (f64, f64)| {
            let half = (high - low).max(span * 0.2) / 2.0 + span * 0.06;
            ((low + high) / 2.0 - half, (low + high) / 2.0 + half)
        };
        let (x, y) = (side(x), side(y));
        let pixel = SIDE / (x.1 - x.0).max(y.1 - y.0);
        let (width, height) = ((x.1 - x.0) * pixel, (y.1 - y.0) * pixel);
        let frame = Frame { left: 110.0, top: 104.0, width, height };
        let x = Scale::new(x, (frame.left, frame.right()));
        let y = Scale::new(y, (frame.bottom(), frame.top));
        let mut picture = Picture::new((frame.right() + 40.0).max(640.0), frame.bottom() + 66.0);
        picture.text((28.0, 46.0), Style::new(21.0, INK).bold(), title);
        let label = Style::new(13.0, SOFT);
        let (values, decimals) = x.ticks((width / 85.0) as usize);
        for value in values {
            let at = x.at(value);
            picture.line(vec![(at, frame.top), (at, frame.bottom())], GRID, 1.0);
            picture.text((at, frame.bottom() + 20.0), label.middle(), number(value, decimals));
        }
        let (values, decimals) = y.ticks((height / 56.0) as usize);
        for value in values {
            let at = y.at(value);
            picture.line(vec![(frame.left, at), (frame.right(), at)], GRID, 1.0);
            picture.text((frame.left - 9.0, at + 4.5), label.end(), number(value, decimals));
        }
        let heading = Style::new(14.5, INK).bold();
        picture.text((28.0, frame.top - 16.0), heading, format!("{}, {unit}", names[1]));
        let below = ((frame.left + frame.right()) / 2.0, frame.bottom() + 46.0);
        picture.text(below, heading.middle(), format!("{}, {unit}", names[0]));
        Paper { picture, frame, x, y }
    }
}

/// The longer side of the drawing, in pixels.
const SIDE: f64 = 860.0;

/// A unit with short numbers, and its size in units of the file.
fn shown_in(unit: &str, largest: f64) -> (String, f64) {
    match unit {
        "nm" if largest >= 1e6 => ("mm".to_owned(), 1e6),
        "nm" if largest >= 1e3 => ("µm".to_owned(), 1e3),
        _ => (unit.to_owned(), 1.0),
    }
}

/// The number of corners between segments that can be distinguished; the steps of an arc are no
/// corners.
fn corners(line: &[(f64, f64)]) -> usize {
    let length = |a: &(f64, f64), b: &(f64, f64)| (a.0 - b.0).hypot(a.1 - b.1);
    let seen = |three: &&[(f64, f64)]| {
        length(&three[0], &three[1]) > 9.0 && length(&three[1], &three[2]) > 9.0
    };
    line.windows(3).filter(seen).count()
}

/// Whether names at both points would overlap.
fn near(a: (f64, f64), b: (f64, f64)) -> bool {
    (a.0 - b.0).abs() < 60.0 && (a.1 - b.1).abs() < 28.0
}

/// Places names of points where they hide as little as possible.
struct Labels<'a> {
    picture: &'a mut Picture,
    frame: Frame,
    line: &'a [(f64, f64)],
    /// The frame of a name that is placed already.
    taken: Option<Frame>,
}

/// The style of a name, and the height of its background.
const LABEL: Style = Style::new(13.5, INK).bold();
const HEIGHT: f64 = 20.0;

impl Labels<'_> {
    /// Adds a name beside a point, on a background, where it hides least of the line.
    fn add(&mut self, (x, y): (f64, f64), name: &str) {
        let width = 10.0 + width(name, LABEL);
        let middle = -width / 2.0;
        let places = [
            (8.0, -30.0),
            (8.0, 10.0),
            (-8.0 - width, -30.0),
            (-8.0 - width, 10.0),
            (12.0, -HEIGHT / 2.0),
            (-12.0 - width, -HEIGHT / 2.0),
            (middle, -34.0),
            (middle, 14.0),
        ];
        let place = |(dx, dy)| Frame { left: x + dx, top: y + dy, width, height: HEIGHT };
        // Of equally good positions, takes the first.
        let best =
            places.map(place).into_iter().min_by(|a, b| self.cost(a).total_cmp(&self.cost(b)));
        let Some(paper) = best else { return };
        self.picture.fill(paper, [0xff; 3], 0.88);
        self.picture.text((paper.left + 5.0, paper.top + 15.0), LABEL, name);
        self.taken = Some(paper);
    }

    /// The pixels of the line that would be hidden. A position outside the frame or over another
    /// name costs more than any line.
    fn cost(&self, paper: &Frame) -> f64 {
        // A margin, because a line has a width.
        let x = (paper.left - 3.0, paper.right() + 3.0);
        let y = (paper.top - 3.0, paper.bottom() + 3.0);
        let out = x.0 < self.frame.left
            || x.1 > self.frame.right()
            || y.0 < self.frame.top
            || y.1 > self.frame.bottom();
        let over = self.taken.is_some_and(|other| {
            x.0 < other.right() && other.left < x.1 && y.0 < other.bottom() && other.top < y.1
        });
        let length = |pair: &[(f64, f64)]| (pair[0].0 - pair[1].0).hypot(pair[0].1 - pair[1].1);
        let hidden = clip(self.line, x, y);
        let hidden: f64 = hidden.iter().flat_map(|piece| piece.windows(2)).map(length).sum();
        hidden + if out || over { 1e9 } else { 0.0 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The texts of a path's picture, and their positions.
    fn texts(points: &[(i64, i64)]) -> Vec<(String, f64, f64)> {
        let mut way = WayPlot::new(("X".into(), "Y".into()), "nm".into());
        points.iter().for_each(|(x, y)| way.go(*x, *y));
        let shapes = way.picture("A way").shapes.into_iter();
        let texts = shapes.filter_map(|shape| match shape {
            Shape::Text { text, x, y, .. } => Some((text, x, y)),
            _ => None,
        });
        texts.collect()
    }

    fn place(texts: &[(String, f64, f64)], name: &str) -> (f64, f64) {
        let found: Vec<_> = texts.iter().filter(|(text, ..)| text == name).collect();
        assert_eq!(found.len(), 1, "{name}: {texts:?}");
        (found[0].1, found[0].2)
    }

    /// Turns of a circle, step by step, as with motors.
    fn circles(turns: u32) -> WayPlot {
        let mut way = WayPlot::new(("X".into(), "Y".into()), "nm".into());
        for n in 0..=turns * 5_000 {
            let (sin, cos) = (f64::from(n) * std::f64::consts::TAU / 5_000.0).sin_cos();
            way.go((cos * 1e9 / 1250.0).round() as i64, (sin * 1e9 / 1250.0).round() as i64);
        }
        way
    }

    /// For any number of turns, memory and file size are bounded, and the circle stays round.
    #[test]
    fn a_thousand_turns_are_a_small_file() {
        let way = circles(1_000);
        assert!(way.points.len() <= POINTS + WAITING, "{}", way.points.len());
        let picture = way.picture("Circles");
        assert!(crate::svg::render(&picture).len() < 3_000_000);
        let lines = picture.shapes.iter().filter_map(|shape| match shape {
            Shape::Line { points, .. } if points.len() > 2 => Some(points),
            _ => None,
        });
        let lines: Vec<_> = lines.collect();
        let [line] = lines[..] else { panic!("{}", lines.len()) };
        let side = line.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.0), b.max(p.0)));
        let (middle, radius) = ((side.0 + side.1) / 2.0, (side.1 - side.0) / 2.0);
        let tops = line.iter().fold((f64::MAX, f64::MIN), |(a, b), p| (a.min(p.1), b.max(p.1)));
        let level = (tops.0 + tops.1) / 2.0;
        for pair in line.windows(2) {
            let (x, y) = ((pair[0].0 + pair[1].0) / 2.0, (pair[0].1 + pair[1].1) / 2.0);
            let off = (x - middle).hypot(y - level) - radius;
            assert!(off.abs() < 0.5, "{off} {pair:?}");
        }
        // The line ends at the motors' positions.
        let end = (line[line.len() - 1].0 - middle - radius).hypot(line[line.len() - 1].1 - level);
        assert!(end < 0.1, "{end}");
    }

    #[test]
    fn start_and_end_have_their_names() {
        let mm = 1_000_000;
        let open = texts(&[(0, 0), (50 * mm, 0), (50 * mm, 30 * mm)]);
        let (start, end) = (place(&open, "start"), place(&open, "end"));
        assert!(start.0 + 300.0 < end.0 && end.1 + 200.0 < start.1, "{open:?}");
        // If both are at the same or nearly the same place, they get one name.
        place(&texts(&[(0, 0), (50 * mm, 0), (50 * mm, 30 * mm), (0, 0)]), "start and end");
        place(&texts(&[(0, 0), (50 * mm, 0), (50 * mm, 30 * mm), (mm, mm)]), "start, end");
        // A path of one point.
        place(&texts(&[(5, 5)]), "start and end");
    }

    /// The line runs above the start, so the name is below it.
    #[test]
    fn names_hide_no_line() {
        let mm = 1_000_000;
        let low = [(0, 0), (0, 1_400_000), (50 * mm, 1_400_000), (50 * mm, 50 * mm)];
        let texts = texts(&low);
        let bottom = place(&texts, "X, mm").1 - 46.0;
        // The path begins 46 pixels above the edge.
        let start = place(&texts, "start");
        assert!(start.1 > bottom - 40.0 && start.1 < bottom, "{start:?} {bottom}");
    }

    /// Both axes can be read, also for a straight line.
    #[test]
    fn each_axis_has_its_numbers() {
        for end in [(50, 0), (0, 50), (50, 50), (3, 2000), (123_456, 7)] {
            let texts = texts(&[(0, 0), end]);
            let numbers = |x_axis: bool| {
                let (_, _, y) = texts.iter().find(|(t, ..)| t.starts_with("X, ")).unwrap();
                let name = y - 26.0;
                let is_number =
                    |text: &str| text.starts_with(|c: char| c.is_ascii_digit() || c == '−');
                texts.iter().filter(|(t, _, y)| is_number(t) && (*y == name) == x_axis).count()
            };
            assert!(numbers(true) >= 4 && numbers(false) >= 4, "{end:?}: {texts:?}");
        }
    }

    /// At the limits of the range of positions.
    #[test]
    fn the_ends_of_the_range_are_places_too() {
        let far = texts(&[(i64::MIN, 0), (i64::MAX, i64::MIN)]);
        assert!(far.iter().any(|(text, ..)| text == "end"), "{far:?}");
    }
}
