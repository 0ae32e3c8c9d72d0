//! Panels with axes, laid out under a title.

use super::picture::{Colour, Frame, Picture, Probe, ProbeCurve, Shape, Style};
use super::scale::{Scale, number};

const INK: Colour = [0x1f, 0x29, 0x37];
const SOFT: Colour = [0x6b, 0x72, 0x80];
const GRID: Colour = [0xe2, 0xe6, 0xec];
const AXIS: Colour = [0x9a, 0xa3, 0xaf];

/// Series, in their order; told apart without colour vision too.
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
    /// Each with its height in pixels.
    pub rows: Vec<(f64, Vec<Panel>)>,
}

/// One pair of axes.
#[derive(Clone, Debug)]
pub struct Panel {
    /// Name and unit of the y axis: ("speed", "steps/s").
    pub y: (String, String),
    /// Name and unit of the x axis.
    pub x: (String, String),
    /// What it shows.
    pub curves: Vec<Curve>,
    /// Shaded stretches behind it.
    pub bands: Vec<Band>,
    /// Whether the bands' names are written in them.
    pub named: bool,
}

/// A line in a panel.
#[derive(Clone, Debug)]
pub struct Curve {
    /// For the legend.
    pub name: String,
    /// Of the line, the dots and the tint below it.
    pub colour: Colour,
    /// In the order of x.
    pub points: Vec<(f64, f64)>,
    /// Whether the area between the line and 0 is tinted.
    pub filled: bool,
    /// Points to mark with a dot.
    pub dots: Vec<(f64, f64)>,
}

/// A stretch of the x axis, shaded.
#[derive(Clone, Debug)]
pub struct Band {
    /// Its begin.
    pub from: f64,
    /// Its end.
    pub to: f64,
    /// Written in it, if it fits.
    pub name: String,
    /// The shade.
    pub tint: Colour,
}

const WIDTH: f64 = 1200.0;
const EDGE: f64 = 28.0;

impl Figure {
    /// Lays it out.
    pub fn picture(&self) -> Picture {
        let head = 58.0 + 21.0 * self.notes.len() as f64 + 10.0;
        let tall: f64 = self.rows.iter().map(|(height, _)| height).sum();
        let mut picture = Picture::new(WIDTH, head + tall + 14.0);
        picture.text((EDGE, 46.0), Style::new(24.0, INK).bold(), &*self.title);
        for (i, note) in self.notes.iter().enumerate() {
            let y = 74.0 + 21.0 * i as f64;
            picture.text((EDGE, y), Style::new(14.0, SOFT), &**note);
        }
        let mut top = head;
        for (height, panels) in &self.rows {
            let wide = (WIDTH - 2.0 * EDGE) / panels.len().max(1) as f64;
            for (i, panel) in panels.iter().enumerate() {
                let left = EDGE + wide * i as f64;
                let frame = Frame {
                    left: left + 66.0,
                    top: top + 40.0,
                    width: wide - 66.0 - if i + 1 < panels.len() { 24.0 } else { 8.0 },
                    height: height - 40.0 - 52.0,
                };
                panel.draw(&mut picture, frame);
            }
            top += height;
        }
        picture
    }
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
            curve.draw(picture, frame, &x, &y);
        }
        self.legend(picture, frame);
        let probe = |curve: &Curve| ProbeCurve {
            name: curve.name.clone(),
            points: thin(&curve.points, &x, frame)
                .into_iter()
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
            values.fold((0.0f64, 0.0f64), |(low, high), v| (low.min(v), high.max(v)))
        };
        let (left, right) = range(&mut points().map(|(x, _)| x));
        let (low, high) = range(&mut points().map(|(_, y)| y));
        // Room above for the names of the bands, and so that no line is cut.
        let high = if high > low { high } else { low + 1.0 };
        let room = (high - low) * if self.named { 0.16 } else { 0.08 };
        let low = if low < 0.0 { low - room } else { low };
        let high = if high > 0.0 { high + room } else { high };
        (
            Scale::new((left, right), (frame.left, frame.right())),
            Scale::new((low, high), (frame.bottom(), frame.top)),
        )
    }

    fn axes(&self, picture: &mut Picture, frame: Frame, x: &Scale, y: &Scale) {
        let label = Style::new(13.0, SOFT);
        let (values, decimals) = y.ticks((frame.height / 56.0) as usize);
        for value in values {
            let at = y.at(value);
            picture.line(vec![(frame.left, at), (frame.right(), at)], GRID, 1.0);
            picture.text((frame.left - 9.0, at + 4.5), label.end(), number(value, decimals));
        }
        let (values, decimals) = x.ticks((frame.width / 85.0) as usize);
        for value in values {
            let at = x.at(value);
            picture.line(vec![(at, frame.bottom()), (at, frame.bottom() + 5.0)], AXIS, 1.0);
            let text = number(value, decimals);
            picture.text((at, frame.bottom() + 21.0), label.middle(), text);
        }
        // The line y = 0, which is the x axis unless something is negative.
        let zero = y.at(0.0).min(frame.bottom());
        picture.line(vec![(frame.left, zero), (frame.right(), zero)], AXIS, 1.4);
        if zero < frame.bottom() - 1.0 {
            let bottom = frame.bottom();
            picture.line(vec![(frame.left, bottom), (frame.right(), bottom)], AXIS, 1.0);
        }
        let name = |(name, unit): &(String, String)| match unit.as_str() {
            "" => name.clone(),
            unit => format!("{name}, {unit}"),
        };
        let heading = Style::new(14.5, INK).bold();
        picture.text((frame.left - 66.0, frame.top - 15.0), heading, name(&self.y));
        let below = ((frame.left + frame.right()) / 2.0, frame.bottom() + 42.0);
        picture.text(below, Style::new(13.5, INK).middle(), name(&self.x));
    }

    /// Names of several curves, right of the heading.
    fn legend(&self, picture: &mut Picture, frame: Frame) {
        if self.curves.len() < 2 {
            return;
        }
        let (mut right, y) = (frame.right(), frame.top - 15.0);
        for curve in self.curves.iter().rev().filter(|curve| !curve.points.is_empty()) {
            picture.text((right, y), Style::new(13.0, INK).end(), &*curve.name);
            right -= 7.0 * curve.name.chars().count() as f64 + 8.0; // about its width
            picture.line(vec![(right - 22.0, y - 4.5), (right, y - 4.5)], curve.colour, 3.0);
            right -= 22.0 + 20.0;
        }
    }
}

impl Band {
    fn shade(&self, picture: &mut Picture, frame: Frame, x: &Scale) {
        let (left, right) = (x.at(self.from), x.at(self.to));
        picture.fill(Frame { left, width: (right - left).max(0.0), ..frame }, self.tint, 1.0);
    }

    /// A name that would not fit is left out; the neighbours tell.
    fn name(&self, picture: &mut Picture, frame: Frame, x: &Scale) {
        let (left, right) = (x.at(self.from), x.at(self.to));
        let width = 10.0 + 8.0 * self.name.len() as f64;
        if right - left > width {
            let middle = (left + right) / 2.0;
            // A gap in the grid, so that no line runs through the name.
            let (top, left) = (frame.top + 2.0, middle - width / 2.0);
            picture.fill(Frame { left, top, width, height: 20.0 }, self.tint, 1.0);
            let style = Style::new(13.0, SOFT).middle();
            picture.text((middle, frame.top + 17.0), style, &*self.name);
        }
    }
}

impl Curve {
    fn draw(&self, picture: &mut Picture, frame: Frame, x: &Scale, y: &Scale) {
        let pixels = |points: &[(f64, f64)]| -> Vec<(f64, f64)> {
            points.iter().map(|&(vx, vy)| (x.at(vx), y.at(vy))).collect()
        };
        let line = pixels(&thin(&self.points, x, frame));
        if let (true, [first, .., last]) = (self.filled, line.as_slice()) {
            let zero = y.at(0.0);
            let ends = ((first.0, zero), (last.0, zero));
            let mut points = vec![ends.0];
            points.extend(&line);
            points.push(ends.1);
            picture.shapes.push(Shape::Area { points, fill: self.colour, opacity: 0.10 });
        }
        picture.line(line, self.colour, 2.4);
        let (points, fill) = (pixels(&self.dots), self.colour);
        if !points.is_empty() {
            picture.shapes.push(Shape::Dots { points, fill, radius: 3.4 });
        }
    }
}

/// What can be seen of many points: the first, lowest, highest and last of
/// every half pixel. Points are in the order of x.
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
