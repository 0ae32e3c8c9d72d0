//! A picture as PNG, drawn with our own font: it looks the same everywhere,
//! and needs nothing from the system.

use tiny_skia::{FillRule, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform};
use ttf_parser::{Face, OutlineBuilder};

use super::picture::{Anchor, Colour, DASH, Picture, Shape};

/// Pixels of the PNG for one of the picture: sharp on today's screens.
const SCALE: f32 = 2.0;

/// The picture, as the bytes of a file.
pub fn render(picture: &Picture) -> Result<Vec<u8>, String> {
    let pixels = |length: f64| (length * f64::from(SCALE)).round() as u32;
    let map = Pixmap::new(pixels(picture.width), pixels(picture.height));
    let mut canvas = Canvas { map: map.ok_or("no memory for the picture")?, fonts: Fonts::load()? };
    for shape in &picture.shapes {
        canvas.draw(shape);
    }
    canvas.map.encode_png().map_err(|error| error.to_string())
}

/// The two faces of the text.
struct Fonts {
    regular: Face<'static>,
    bold: Face<'static>,
}

impl Fonts {
    fn load() -> Result<Fonts, String> {
        let face = |bytes| Face::parse(bytes, 0).map_err(|error| format!("font: {error}"));
        Ok(Fonts { regular: face(ttf_noto_sans::REGULAR)?, bold: face(ttf_noto_sans::BOLD)? })
    }
}

struct Canvas {
    map: Pixmap,
    fonts: Fonts,
}

impl Canvas {
    fn draw(&mut self, shape: &Shape) {
        match shape {
            Shape::Box { x, y, width, height, fill, opacity } => {
                let rect = Rect::from_xywh(*x as f32, *y as f32, *width as f32, *height as f32);
                if let Some(rect) = rect {
                    self.fill(&PathBuilder::from_rect(rect), *fill, *opacity);
                }
            }
            Shape::Line { points, colour, width, dashed } => {
                if let Some(path) = through(points, false) {
                    let stroke = Stroke {
                        width: *width as f32,
                        line_join: tiny_skia::LineJoin::Round,
                        dash: dashed.then(dashes).flatten(),
                        ..Stroke::default()
                    };
                    let at = Transform::from_scale(SCALE, SCALE);
                    self.map.stroke_path(&path, &paint(*colour, 1.0), &stroke, at, None);
                }
            }
            Shape::Area { points, fill, opacity } => {
                if let Some(path) = through(points, true) {
                    self.fill(&path, *fill, *opacity);
                }
            }
            Shape::Dots { points, fill, radius } => {
                let mut path = PathBuilder::new();
                for (x, y) in points {
                    path.push_circle(*x as f32, *y as f32, *radius as f32);
                }
                if let Some(path) = path.finish() {
                    self.fill(&path, *fill, 1.0);
                }
            }
            Shape::Text { x, y, size, bold, anchor, colour, text } => {
                let face = if *bold { &self.fonts.bold } else { &self.fonts.regular };
                if let Some(path) = outline(face, text, (*x, *y), *size, *anchor) {
                    self.fill(&path, *colour, 1.0);
                }
            }
        }
    }

    fn fill(&mut self, path: &Path, colour: Colour, opacity: f64) {
        let at = Transform::from_scale(SCALE, SCALE);
        self.map.fill_path(path, &paint(colour, opacity), FillRule::Winding, at, None);
    }
}

fn dashes() -> Option<StrokeDash> {
    StrokeDash::new(DASH.map(|length| length as f32).to_vec(), 0.0)
}

fn paint([r, g, b]: Colour, opacity: f64) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(r, g, b, (opacity * 255.0).round() as u8);
    paint
}

fn through(points: &[(f64, f64)], closed: bool) -> Option<Path> {
    let mut path = PathBuilder::new();
    for (i, &(x, y)) in points.iter().enumerate() {
        match i {
            0 => path.move_to(x as f32, y as f32),
            _ => path.line_to(x as f32, y as f32),
        }
    }
    if closed {
        path.close();
    }
    path.finish()
}

/// A line of text as one outline.
fn outline(
    face: &Face<'_>,
    text: &str,
    (x, y): (f64, f64),
    size: f64,
    anchor: Anchor,
) -> Option<Path> {
    let scale = size as f32 / f32::from(face.units_per_em());
    let glyph = |c| face.glyph_index(c).unwrap_or_default();
    let advance = |c| f32::from(face.glyph_hor_advance(glyph(c)).unwrap_or(0)) * scale;
    let width: f32 = text.chars().map(advance).sum();
    let back = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => width / 2.0,
        Anchor::End => width,
    };
    let mut pen = Pen { path: PathBuilder::new(), x: x as f32 - back, y: y as f32, scale };
    for c in text.chars() {
        face.outline_glyph(glyph(c), &mut pen);
        pen.x += advance(c);
    }
    pen.path.finish()
}

/// Puts a glyph's curves, in font units and y upwards, where the text stands.
struct Pen {
    path: PathBuilder,
    x: f32,
    y: f32,
    scale: f32,
}

impl Pen {
    fn at(&self, x: f32, y: f32) -> (f32, f32) {
        (self.x + x * self.scale, self.y - y * self.scale)
    }
}

impl OutlineBuilder for Pen {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.at(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.at(x1, y1), self.at(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.at(x1, y1), self.at(x2, y2), self.at(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}
