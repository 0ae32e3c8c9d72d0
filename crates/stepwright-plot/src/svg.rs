//! A picture as SVG.

use std::fmt::Write;

use crate::picture::{Anchor, Colour, DASH, Picture, Shape};

/// Fonts to try, in this order. The picture does not depend on their widths.
const FONTS: &str = "'Noto Sans', 'Segoe UI', 'Helvetica Neue', Arial, sans-serif";

/// The picture, as the text of an `<svg>` element.
pub fn render(picture: &Picture) -> String {
    let Picture { width, height, shapes, .. } = picture;
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" \
         width=\"{width}\" height=\"{height}\" font-family=\"{FONTS}\">\n"
    );
    for shape in shapes {
        // Writing to a string can't fail.
        let _ = one(&mut svg, shape);
    }
    svg.push_str("</svg>\n");
    svg
}

fn one(svg: &mut String, shape: &Shape) -> std::fmt::Result {
    match shape {
        Shape::Box { x, y, width, height, fill, opacity } => {
            write!(svg, "<rect x=\"{x:.1}\" y=\"{y:.1}\" width=\"{width:.1}\"")?;
            write!(svg, " height=\"{height:.1}\" fill=\"{}\"", hex(*fill))?;
            faded(svg, *opacity)
        }
        Shape::Line { points, colour, width, dashed } => {
            svg.push_str("<polyline fill=\"none\" stroke-linejoin=\"round\" points=\"");
            list(svg, points)?;
            write!(svg, "\" stroke=\"{}\" stroke-width=\"{width}\"", hex(*colour))?;
            if *dashed {
                let [ink, gap] = DASH;
                write!(svg, " stroke-dasharray=\"{ink} {gap}\"")?;
            }
            svg.push_str("/>\n");
            Ok(())
        }
        Shape::Area { points, fill, opacity } => {
            svg.push_str("<polygon points=\"");
            list(svg, points)?;
            write!(svg, "\" fill=\"{}\"", hex(*fill))?;
            faded(svg, *opacity)
        }
        Shape::Dots { points, fill, radius } => {
            writeln!(svg, "<g fill=\"{}\">", hex(*fill))?;
            for (x, y) in points {
                writeln!(svg, "<circle cx=\"{x:.1}\" cy=\"{y:.1}\" r=\"{radius}\"/>")?;
            }
            svg.push_str("</g>\n");
            Ok(())
        }
        Shape::Text { x, y, size, bold, anchor, colour, text } => {
            write!(svg, "<text x=\"{x:.1}\" y=\"{y:.1}\" font-size=\"{size}\"")?;
            write!(svg, " fill=\"{}\"", hex(*colour))?;
            if *bold {
                svg.push_str(" font-weight=\"bold\"");
            }
            match anchor {
                Anchor::Start => {}
                Anchor::Middle => svg.push_str(" text-anchor=\"middle\""),
                Anchor::End => svg.push_str(" text-anchor=\"end\""),
            }
            writeln!(svg, ">{}</text>", escaped(text))
        }
    }
}

fn faded(svg: &mut String, opacity: f64) -> std::fmt::Result {
    match opacity < 1.0 {
        true => writeln!(svg, " fill-opacity=\"{opacity}\"/>"),
        false => writeln!(svg, "/>"),
    }
}

fn list(svg: &mut String, points: &[(f64, f64)]) -> std::fmt::Result {
    points.iter().enumerate().try_for_each(|(i, (x, y))| {
        let gap = if i == 0 { "" } else { " " };
        write!(svg, "{gap}{x:.1},{y:.1}")
    })
}

fn hex([r, g, b]: Colour) -> String {
    format!("#{r:02x}{g:02x}{b:02x}")
}

/// Escapes text for use between tags and in attributes.
pub fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out.push_str("&amp;"),
            '<' => out.push_str("&lt;"),
            '>' => out.push_str("&gt;"),
            '"' => out.push_str("&quot;"),
            // XML does not allow these characters.
            '\0'..='\u{8}' | '\u{b}'..='\u{1f}' | '\u{fffe}' | '\u{ffff}' => out.push('\u{fffd}'),
            c => out.push(c),
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    /// XML does not allow these characters, not even escaped.
    #[test]
    fn characters_that_xml_lacks_are_replaced() {
        let wrong = ['\0', '\u{1}', '\u{1b}', '\u{1f}', '\r', '\u{b}', '\u{fffe}', '\u{ffff}'];
        for c in wrong {
            assert_eq!(escaped(&format!("a{c}b")), "a\u{fffd}b", "{c:?}");
        }
        assert_eq!(escaped("a\tb\nc\u{7f}\u{e000}ä😀"), "a\tb\nc\u{7f}\u{e000}ä😀");
    }
}
