//! A picture as PNG, drawn with the built-in font: it looks the same everywhere, and needs nothing
//! of the system.

use tiny_skia::{FillRule, Paint, Path, PathBuilder, Pixmap, Rect, Stroke, StrokeDash, Transform};
use ttf_parser::{Face, OutlineBuilder};

use crate::font::{self, Faces};
use crate::palette::Indexed;
use crate::picture::{Anchor, Colour, DASH, Picture, Shape};

/// The pixels of the PNG for each pixel of the picture, to be sharp on high-resolution screens.
const SCALE: f32 = 2.0;

/// The picture, as the bytes of a file.
pub fn render(picture: &Picture) -> Result<Vec<u8>, String> {
    encode(&drawn(picture)?).map_err(|error| error.to_string())
}

/// The picture with all colours.
fn drawn(picture: &Picture) -> Result<Pixmap, String> {
    let pixels = |length: f64| (length * f64::from(SCALE)).round() as u32;
    let map = Pixmap::new(pixels(picture.width), pixels(picture.height));
    let faces = font::faces().ok_or("its font can't be read")?;
    let mut canvas = Canvas { map: map.ok_or("no memory for the picture")?, faces };
    for shape in &picture.shapes {
        canvas.draw(shape);
    }
    Ok(canvas.map)
}

/// The bytes of a file with a palette. No filter is used: neighbouring pixels are either equal or
/// unrelated.
fn encode(map: &Pixmap) -> Result<Vec<u8>, png::EncodingError> {
    // The background covers the whole picture, so no pixel is transparent.
    let colours: Vec<Colour> =
        map.pixels().iter().map(|pixel| [pixel.red(), pixel.green(), pixel.blue()]).collect();
    let indexed = Indexed::of(&colours);
    let mut bytes = Vec::new();
    let mut encoder = png::Encoder::new(&mut bytes, map.width(), map.height());
    encoder.set_color(png::ColorType::Indexed);
    encoder.set_depth(png::BitDepth::Eight);
    encoder.set_palette(indexed.palette.concat());
    encoder.set_compression(png::Compression::High);
    encoder.set_filter(png::Filter::NoFilter);
    let mut writer = encoder.write_header()?;
    writer.write_image_data(&indexed.pixels)?;
    writer.finish()?;
    Ok(bytes)
}

struct Canvas {
    map: Pixmap,
    faces: &'static Faces,
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
                if let Some(path) = outline(self.faces.face(*bold), text, (*x, *y), *size, *anchor)
                {
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
    let advance = |c| font::advance(face, c, size) as f32;
    let width: f32 = text.chars().map(advance).sum();
    let back = match anchor {
        Anchor::Start => 0.0,
        Anchor::Middle => width / 2.0,
        Anchor::End => width,
    };
    let mut pen = Pen { path: PathBuilder::new(), x: x as f32 - back, y: y as f32, scale };
    for c in text.chars() {
        face.outline_glyph(font::glyph(face, c), &mut pen);
        pen.x += advance(c);
    }
    pen.path.finish()
}

/// Adds a glyph's curves, in font units with y upward, at the position of the text.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Band, Curve, Figure, PALETTE, Panel};

    /// Six curves over two tints: more colours than a palette has.
    fn colourful() -> Picture {
        let curve = |n: usize| Curve {
            name: format!("curve {n}"),
            colour: PALETTE[n],
            points: (0..=300).map(f64::from).map(|x| (x, (x / (9.0 + n as f64)).sin())).collect(),
            filled: n == 0,
            ..Curve::default()
        };
        let band = |from: f64, tint| Band { from, to: from + 90.0, name: "up".into(), tint };
        let panel = Panel {
            y: ("Speed".into(), "rpm".into()),
            curves: (0..6).map(curve).collect(),
            bands: vec![band(20.0, [0xeb, 0xf2, 0xfd]), band(150.0, [0xfd, 0xf2, 0xe9])],
            named: true,
            ..Panel::default()
        };
        let title = "Six curves".to_owned();
        Figure { title, notes: Vec::new(), rows: vec![(500.0, vec![panel])] }.picture()
    }

    #[test]
    fn a_file_shows_what_was_drawn_in_few_bytes() {
        let map = drawn(&colourful()).unwrap();
        let bytes = encode(&map).unwrap();
        let mut reader = png::Decoder::new(std::io::Cursor::new(&bytes)).read_info().unwrap();
        assert_eq!((reader.info().width, reader.info().height), (map.width(), map.height()));
        let palette = reader.info().palette.clone().unwrap();
        let mut places = vec![0; reader.output_buffer_size().unwrap()];
        reader.next_frame(&mut places).unwrap();
        let colours = |place: &u8| &palette[3 * usize::from(*place)..][..3];
        let mut worst = 0;
        for (pixel, place) in map.pixels().iter().zip(&places) {
            assert_eq!(pixel.alpha(), 255, "what is transparent would be lost");
            let pixel = [pixel.red(), pixel.green(), pixel.blue()];
            for (drawn, stored) in pixel.iter().zip(colours(place)) {
                worst = worst.max(drawn.abs_diff(*stored));
            }
        }
        // The deviation is at the edges of lines, where it is not visible.
        assert!((1..=31).contains(&worst), "{worst}");
        let mut all = Vec::new();
        let mut encoder = png::Encoder::new(&mut all, map.width(), map.height());
        encoder.set_color(png::ColorType::Rgba);
        encoder.write_header().unwrap().write_image_data(map.data()).unwrap();
        assert!(2 * bytes.len() < all.len(), "{} bytes of {}", bytes.len(), all.len());
    }
}
