//! The font of the text: the glyphs of the PNG, and the widths of text in all formats. (The fonts
//! of browsers for an SVG have about the same widths.)

use std::sync::OnceLock;

use ttf_parser::{Face, GlyphId};

use crate::picture::Style;

/// The two faces of the text; `None` if they can't be read.
pub fn faces() -> Option<&'static Faces> {
    static FACES: OnceLock<Option<Faces>> = OnceLock::new();
    let parse = |bytes| Face::parse(bytes, 0).ok();
    let load = || {
        let (regular, bold) = (parse(ttf_noto_sans::REGULAR)?, parse(ttf_noto_sans::BOLD)?);
        Some(Faces { regular, bold })
    };
    FACES.get_or_init(load).as_ref()
}

/// The regular and the bold face.
pub struct Faces {
    regular: Face<'static>,
    bold: Face<'static>,
}

impl Faces {
    /// The bold or the regular face.
    pub fn face(&self, bold: bool) -> &Face<'static> {
        if bold { &self.bold } else { &self.regular }
    }
}

/// The glyph of a character.
pub fn glyph(face: &Face<'_>, c: char) -> GlyphId {
    face.glyph_index(c).unwrap_or_default()
}

/// The distance from the origin of a character to that of the next, in pixels, at this font size.
pub fn advance(face: &Face<'_>, c: char, size: f64) -> f64 {
    let units = face.glyph_hor_advance(glyph(face, c)).unwrap_or(0);
    f64::from(units) * size / f64::from(face.units_per_em())
}

/// The width of a text in pixels.
pub fn width(text: &str, style: Style) -> f64 {
    match faces() {
        Some(faces) => {
            let face = faces.face(style.bold);
            text.chars().map(|c| advance(face, c, style.size)).sum()
        }
        None => 0.6 * style.size * text.chars().count() as f64,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_text_is_as_wide_as_its_letters() {
        let style = Style::new(20.0, [0; 3]);
        assert_eq!(width("", style), 0.0);
        let (narrow, wide) = (width("illi", style), width("WMWM", style));
        assert!(narrow * 2.5 < wide, "{narrow} {wide}");
        assert!((width("start", style) - width("sta", style) - width("rt", style)).abs() < 1e-9);
        assert!(width("start", style.bold()) > width("start", style));
        assert!(
            (width("start", Style::new(10.0, [0; 3])) * 2.0 - width("start", style)).abs() < 1e-9
        );
    }
}
