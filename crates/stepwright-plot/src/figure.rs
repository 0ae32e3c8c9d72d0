//! Panels with axes, arranged under a title.

use crate::clip::clip;
use crate::font;
use crate::picture::{Colour, Frame, Picture, Probe, ProbeCurve, Shape, Style};
use crate::scale::{Scale, number};

pub(crate) const INK: Colour = [0x1f, 0x29, 0x37];
pub(crate) const SOFT: Colour = [0x6b, 0x72, 0x80];
pub(crate) const GRID: Colour = [0xe2, 0xe6, 0xec];
const AXIS: Colour = [0x9a, 0xa3, 0xaf];

/// The colours of the series, in order. They differ without colour vision too.
pub const PALETTE: [Colour; 6] = [
    [0x1d, 0x5f, 0xd1],
    [0xd9, 0x57, 0x0c],
    [0x0b, 0x87, 0x5b],
    [0x9b, 0x3b, 0xb8],
    [0xb4, 0x89, 0x06],
    [0x4b, 0x55, 0x63],
];

/// Panels in rows under a title.
#[derive(Clone, Debug)]
pub struct Figure {
    /// The heading.
    pub title: String,
    /// Smaller lines below it.
    pub notes: Vec<String>,
    /// The rows of panels, each with its height in pixels.
    pub rows: Vec<(f64, Vec<Panel>)>,
}

/// One pair of axes.
#[derive(Clone, Debug, Default)]
pub struct Panel {
    /// Name and unit of the y axis: ("speed", "steps/s").
    pub y: (String, String),
    /// Name and unit of the x axis.
    pub x: (String, String),
    /// The curves.
    pub curves: Vec<Curve>,
    /// Shaded ranges behind the curves.
    pub bands: Vec<Band>,
    /// Whether the bands' names are written in them.
    pub named: bool,
    /// The part of the plane that is shown.
    pub view: View,
    /// Names at the y axis instead of numbers, from the top down, for signals. Each lane has the
    /// height 1, and the lowest begins at 0.
    pub lanes: Vec<String>,
}

/// A part of the plane, from and to. `None` is a range that contains all curves, and 0.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct View {
    /// The range of x.
    pub x: Option<(f64, f64)>,
    /// The range of y.
    pub y: Option<(f64, f64)>,
}

/// A line in a panel.
#[derive(Clone, Debug, Default)]
pub struct Curve {
    /// The name in the legend.
    pub name: String,
    /// The colour of the line, the dots and the area below it.
    pub colour: Colour,
    /// The points, in the order of x.
    pub points: Vec<(f64, f64)>,
    /// Whether the area between the line and 0 is tinted.
    pub filled: bool,
    /// Points to mark with a dot.
    pub dots: Vec<(f64, f64)>,
    /// Whether the line is dashed: for a reference to which the others are compared.
    pub dashed: bool,
}

/// A shaded range of the x axis.
#[derive(Clone, Debug)]
pub struct Band {
    /// Its start.
    pub from: f64,
    /// Its end.
    pub to: f64,
    /// The name, which is written in it if it fits.
    pub name: String,
    /// The shade.
    pub tint: Colour,
}

/// The styles of a panel's heading and of a curve's name.
const HEADING: Style = Style::new(14.5, INK).bold();
const NAME: Style = Style::new(13.0, INK);

const WIDTH: f64 = 1200.0;
const EDGE: f64 = 28.0;
/// The height of a further row of a legend.
const LEGEND: f64 = 21.0;

impl Figure {
    /// The figure as SVG.
    pub fn svg(&self) -> String {
        crate::svg::render(&self.picture())
    }

    /// Arranges the figure.
    pub fn picture(&self) -> Picture {
        let notes: Vec<String> = self.notes.iter().flat_map(|note| broken(note)).collect();
        let head = 58.0 + 21.0 * notes.len() as f64 + 10.0;
        let tall: f64 = self.rows.iter().map(|(height, _)| height).sum();
        let mut picture = Picture::new(WIDTH, head + tall + 14.0);
        picture.text((EDGE, 46.0), Style::new(24.0, INK).bold(), &*self.title);
        for (i, note) in notes.iter().enumerate() {
            let y = 74.0 + 21.0 * i as f64;
            picture.text((EDGE, y), Style::new(14.0, SOFT), &**note);
        }
        let mut top = head;
        for (height, panels) in &self.rows {
            let wide = (WIDTH - 2.0 * EDGE) / panels.len().max(1) as f64;
            for (i, panel) in panels.iter().enumerate() {
                let left = EDGE + wide * i as f64;
                let width = wide - 66.0 - if i + 1 < panels.len() { 24.0 } else { 8.0 };
                let above = 40.0 + LEGEND * panel.legend_rows(width).len().saturating_sub(1) as f64;
                let frame = Frame {
                    left: left + 66.0,
                    top: top + above,
                    width,
                    height: height - above - 52.0,
                };
                panel.draw(&mut picture, frame);
            }
            top += height;
        }
        picture
    }
}

/// The separator of two facts of a note. A browser would merge plain spaces.
pub const GAP: &str = "\u{2002}·\u{2002}";

/// The most characters of a note in one line.
const NOTE: usize = 150;

/// Breaks a note into lines that fit, between two facts.
fn broken(note: &str) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for fact in note.split(GAP) {
        match lines.last_mut() {
            Some(line) if line.chars().count() + fact.chars().count() + 3 <= NOTE => {
                line.push_str(GAP);
                line.push_str(fact);
            }
            _ => lines.push(fact.to_owned()),
        }
    }
    lines
}

impl Panel {
    fn draw(&self, picture: &mut Picture, frame: Frame) {
        let (x, y) = self.scales(frame);
        for band in &self.bands {
            band.shade(picture, frame, &x);
        }
        self.axes(picture, frame, &x, &y);
        for band in self.bands.iter().filter(|_| self.named) {
            band.name(picture, frame, &x);
        }
        for curve in &self.curves {
            for piece in self.pieces(curve, &x, frame) {
                curve.draw(picture, &piece, &x, &y);
            }
            curve.mark(picture, &self.view, &x, &y);
        }
        self.legend(picture, frame);
        let probe = |curve: &Curve| ProbeCurve {
            name: curve.name.clone(),
            points: (self.pieces(curve, &x, frame).into_iter().flatten())
                .map(|(vx, vy)| [x.at(vx), y.at(vy), vx, vy])
                .collect(),
        };
        picture.probes.push(Probe {
            frame,
            x_unit: self.x.1.clone(),
            y_unit: self.y.1.clone(),
            curves: self.curves.iter().map(probe).collect(),
        });
    }

    fn scales(&self, frame: Frame) -> (Scale, Scale) {
        let points = || self.curves.iter().flat_map(|c| c.points.iter().copied());
        let range = |values: &mut dyn Iterator<Item = f64>| {
            values
                .filter(|v| v.is_finite())
                .fold((0.0f64, 0.0f64), |(low, high), v| (low.min(v), high.max(v)))
        };
        let all = || {
            let (low, high) = range(&mut points().map(|(_, y)| y));
            // Room above for the names of the bands, and so that no curve is cut off.
            let (low, high) = if high > low { (low, high) } else { (low - 1.0, low + 1.0) };
            let room = (high - low) * if self.named { 0.16 } else { 0.08 };
            let low = if low < 0.0 { low - room } else { low };
            (low, if high > 0.0 { high + room } else { high })
        };
        let bands = || self.bands.iter().flat_map(|band| [band.from, band.to]);
        let across = || range(&mut points().map(|(x, _)| x).chain(bands()));
        let across = self.view.x.unwrap_or_else(across);
        let up = self.view.y.unwrap_or_else(all);
        (
            Scale::new(across, (frame.left, frame.right())),
            Scale::new(up, (frame.bottom(), frame.top)),
        )
    }

    /// Whether all curves are 0 everywhere.
    fn is_flat(&self) -> bool {
        let mut points = self.curves.iter().flat_map(|curve| &curve.points);
        self.view.y.is_none() && points.all(|(_, y)| *y == 0.0)
    }

    /// The visible pieces of a curve. It has a gap where a value is not finite.
    fn pieces(&self, curve: &Curve, x: &Scale, frame: Frame) -> Vec<Vec<(f64, f64)>> {
        const ALL: (f64, f64) = (f64::NEG_INFINITY, f64::INFINITY);
        let runs = curve.points.split(|(x, y)| !(x.is_finite() && y.is_finite()));
        let runs = runs.map(|run| thin(run, x, frame));
        if self.view == View::default() {
            return runs.collect();
        }
        let (x, y) = (self.view.x.unwrap_or(ALL), self.view.y.unwrap_or(ALL));
        runs.flat_map(|run| clip(&run, x, y)).collect()
    }

    fn axes(&self, picture: &mut Picture, frame: Frame, x: &Scale, y: &Scale) {
        let label = Style::new(13.0, SOFT);
        for (name, above) in self.lanes.iter().rev().zip(0u32..) {
            let at = y.at(f64::from(above) + 0.35);
            picture.text((frame.left - 9.0, at + 4.5), label.end(), name.clone());
        }
        let (mut values, decimals) = y.ticks(((frame.height / 56.0) as usize).max(2));
        if self.is_flat() {
            // Only 0 is meaningful on such an axis.
            values.retain(|value| *value == 0.0);
        }
        let millions = if in_millions(&values) { 1e-6 } else { 1.0 };
        for value in values.iter().copied().filter(|_| self.lanes.is_empty()) {
            let at = y.at(value);
            picture.line(vec![(frame.left, at), (frame.right(), at)], GRID, 1.0);
            let (value, decimals) = match millions < 1.0 {
                true => (value * millions, fewest_decimals(&values)),
                false => (value, decimals),
            };
            picture.text((frame.left - 9.0, at + 4.5), label.end(), number(value, decimals));
        }
        let (values, decimals) = x.ticks((frame.width / 85.0) as usize);
        for value in values {
            let at = x.at(value);
            picture.line(vec![(at, frame.bottom()), (at, frame.bottom() + 5.0)], AXIS, 1.0);
            let text = number(value, decimals);
            picture.text((at, frame.bottom() + 21.0), label.middle(), text);
        }
        // The line y = 0, which is the x axis unless a value is negative. Lanes have no such line.
        let zero = if self.lanes.is_empty() { y.at(0.0) } else { frame.bottom() };
        let zero = zero.clamp(frame.top, frame.bottom());
        picture.line(vec![(frame.left, zero), (frame.right(), zero)], AXIS, 1.4);
        if zero < frame.bottom() - 1.0 {
            let bottom = frame.bottom();
            picture.line(vec![(frame.left, bottom), (frame.right(), bottom)], AXIS, 1.0);
        }
        let name = |(name, unit): &(String, String)| match unit.as_str() {
            "" => name.clone(),
            unit => format!("{name}, {unit}"),
        };
        let more = self.legend_rows(frame.width).len().saturating_sub(1);
        let over = frame.top - 15.0 - LEGEND * more as f64;
        let unit = if millions < 1.0 { "million " } else { "" };
        let y_name = (self.y.0.clone(), format!("{unit}{}", self.y.1));
        picture.text((frame.left - 66.0, over), HEADING, name(&y_name));
        if self.x.0.is_empty() {
            return;
        }
        let below = ((frame.left + frame.right()) / 2.0, frame.bottom() + 42.0);
        picture.text(below, Style::new(13.5, INK).middle(), name(&self.x));
    }

    /// Draws the names of several curves, right of the heading. Names without room there get rows
    /// below.
    fn legend(&self, picture: &mut Picture, frame: Frame) {
        let rows = self.legend_rows(frame.width);
        for (row, above) in rows.iter().zip((0..rows.len()).rev()) {
            let (mut right, y) = (frame.right(), frame.top - 15.0 - LEGEND * above as f64);
            for curve in row.iter().rev() {
                right -= name_width(&curve.name);
                picture.text((right, y), NAME, &*curve.name);
                right -= 8.0;
                let line = vec![(right - SAMPLE, y - 4.5), (right, y - 4.5)];
                picture.shapes.push(Shape::Line {
                    points: line,
                    colour: curve.colour,
                    width: 3.0,
                    dashed: curve.dashed,
                });
                right -= SAMPLE + 20.0;
            }
        }
    }

    /// The rows of the legend, for a frame of this width.
    fn legend_rows(&self, width: f64) -> Vec<Vec<&Curve>> {
        let named: Vec<&Curve> = self.curves.iter().filter(|c| !c.points.is_empty()).collect();
        if !self.lanes.is_empty() {
            return Vec::new();
        }
        if named.len() < 2 {
            return Vec::new();
        }
        let heading = font::width(&format!("{}, {}", self.y.0, self.y.1), HEADING);
        let (mut rows, mut left) = (vec![Vec::new()], width + 66.0 - heading - 20.0);
        for curve in named {
            let wide = name_width(&curve.name) + 8.0 + SAMPLE + 20.0;
            if wide > left {
                rows.push(Vec::new());
                left = width;
            }
            left -= wide;
            rows.last_mut().into_iter().for_each(|row| row.push(curve));
        }
        rows
    }
}

/// Whether the numbers of a y axis are too long to fit beside it.
fn in_millions(values: &[f64]) -> bool {
    values.iter().any(|value| value.abs() >= 1e7)
}

/// The number of decimals that these values need in millions.
fn fewest_decimals(values: &[f64]) -> usize {
    usize::from(values.iter().any(|value| value % 1e6 != 0.0))
}

/// The length of the line before a name in the legend, in pixels.
const SAMPLE: f64 = 24.0;

/// The width of a name in the legend, in pixels.
fn name_width(name: &str) -> f64 {
    font::width(name, NAME)
}

impl Band {
    fn shade(&self, picture: &mut Picture, frame: Frame, x: &Scale) {
        let (left, right) = (x.at(self.from), x.at(self.to));
        picture.fill(Frame { left, width: (right - left).max(0.0), ..frame }, self.tint, 1.0);
    }

    /// Draws the name, unless it does not fit.
    fn name(&self, picture: &mut Picture, frame: Frame, x: &Scale) {
        let (left, right) = (x.at(self.from), x.at(self.to));
        let style = Style::new(13.0, SOFT).middle();
        let width = 10.0 + font::width(&self.name, style);
        if right - left > width {
            let middle = (left + right) / 2.0;
            // A gap in the grid, so that no line runs through the name.
            let (top, left) = (frame.top + 2.0, middle - width / 2.0);
            picture.fill(Frame { left, top, width, height: 20.0 }, self.tint, 1.0);
            picture.text((middle, frame.top + 17.0), style, &*self.name);
        }
    }
}

impl Curve {
    /// Draws a piece of the curve.
    fn draw(&self, picture: &mut Picture, piece: &[(f64, f64)], x: &Scale, y: &Scale) {
        let points: Vec<_> = piece.iter().map(|&(vx, vy)| (x.at(vx), y.at(vy))).collect();
        if let (true, [first, .., last]) = (self.filled, points.as_slice()) {
            let zero = y.at(0.0);
            let ends = ((first.0, zero), (last.0, zero));
            let mut points = vec![ends.0];
            points.extend(piece.iter().map(|&(vx, vy)| (x.at(vx), y.at(vy))));
            points.push(ends.1);
            picture.shapes.push(Shape::Area { points, fill: self.colour, opacity: 0.10 });
        }
        let (colour, dashed, width) = (self.colour, self.dashed, stroke(&points));
        picture.shapes.push(Shape::Line { points, colour, width, dashed });
    }

    /// Draws the visible dots of the curve.
    fn mark(&self, picture: &mut Picture, view: &View, x: &Scale, y: &Scale) {
        let holds = |range: Option<(f64, f64)>, v: f64| range.is_none_or(|(a, b)| a <= v && v <= b);
        let seen = |&&(vx, vy): &&(f64, f64)| {
            vx.is_finite() && vy.is_finite() && holds(view.x, vx) && holds(view.y, vy)
        };
        let dots = self.dots.iter().filter(seen).map(|&(vx, vy)| (x.at(vx), y.at(vy)));
        let points: Vec<_> = dots.collect();
        if !points.is_empty() {
            picture.shapes.push(Shape::Dots { points, fill: self.colour, radius: 3.4 });
        }
    }
}

/// The width of a line. It is thinner where its turns up and down are so close that it would look
/// like a block.
fn stroke(points: &[(f64, f64)]) -> f64 {
    let [first, .., last] = points else { return 2.4 };
    let (mut turns, mut up) = (0u32, true);
    let mut extreme = first.1;
    for (_, y) in points {
        let further = if up { *y > extreme } else { *y < extreme };
        if further {
            extreme = *y;
        } else if (y - extreme).abs() > SWING {
            (turns, up, extreme) = (turns + 1, !up, *y);
        }
    }
    // The pixels between two turns.
    let apart = (last.0 - first.0) / f64::from(turns + 1);
    if turns < 100 { 2.4 } else { (apart * 0.27).clamp(1.0, 2.4) }
}

/// A line that goes up and down by less than this many pixels counts as level.
const SWING: f64 = 10.0;

/// Thins many points to the visible ones: the first, lowest, highest and last of every half pixel.
/// Points are in the order of x.
fn thin(points: &[(f64, f64)], x: &Scale, frame: Frame) -> Vec<(f64, f64)> {
    if points.len() as f64 <= 2.0 * frame.width {
        return points.to_vec();
    }
    let column = |p: &(f64, f64)| (x.at(p.0) * 2.0).floor();
    let mut out = Vec::new();
    for group in points.chunk_by(|a, b| column(a) == column(b)) {
        let by = |a: &&(f64, f64), b: &&(f64, f64)| a.1.total_cmp(&b.1);
        let (low, high) = (group.iter().min_by(by), group.iter().max_by(by));
        let mut kept: Vec<_> =
            group.first().into_iter().chain(low).chain(high).chain(group.last()).collect();
        kept.sort_by(|a, b| a.0.total_cmp(&b.0));
        kept.dedup();
        out.extend(kept.into_iter().copied());
    }
    out
}
