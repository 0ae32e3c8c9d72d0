//! Reduces a picture to at most 256 colours. A plot of lines and tints then takes a quarter of the
//! bytes.

use std::collections::HashMap;

use crate::picture::Colour;

/// The number of entries of a palette.
const ROOM: usize = 256;

/// Pixels as indices into a palette.
pub struct Indexed {
    /// At most 256 colours.
    pub palette: Vec<Colour>,
    /// A byte for each pixel, row by row.
    pub pixels: Vec<u8>,
}

impl Indexed {
    /// Indexes these pixels, row by row. The most frequent colours stay exact. A rarer one, at the
    /// edge of a line or a letter, is replaced by a similar colour.
    pub fn of(colours: &[Colour]) -> Indexed {
        let mut counts = HashMap::new();
        for run in colours.chunk_by(|a, b| a == b) {
            *counts.entry(run[0]).or_insert(0) += run.len();
        }
        let mut ranked: Vec<_> = counts.into_iter().collect();
        ranked.sort_by_key(|(colour, count)| (usize::MAX - count, *colour));
        let mut bound = 0;
        let (palette, places) = loop {
            match within(&ranked, bound) {
                Some(found) => break found,
                None => bound += bound / 2 + 1,
            }
        };
        let mut pixels = Vec::with_capacity(colours.len());
        for run in colours.chunk_by(|a, b| a == b) {
            let place = places.get(&run[0]).copied().unwrap_or_default();
            pixels.resize(pixels.len() + run.len(), place);
        }
        Indexed { palette, pixels }
    }
}

/// A palette, and the index of each colour in it.
type Places = (Vec<Colour>, HashMap<Colour, u8>);

/// A palette that has for each of the colours one that differs by at most `bound` in red, green and
/// blue; `None` if 256 entries are too few.
fn within(ranked: &[(Colour, usize)], bound: u8) -> Option<Places> {
    let (mut palette, mut places) = (Vec::new(), HashMap::new());
    for (colour, _) in ranked {
        let close = |other: &Colour| distance(*colour, *other) <= bound;
        let place = match palette.iter().position(close) {
            Some(place) => place,
            None if palette.len() == ROOM => return None,
            None => {
                palette.push(*colour);
                palette.len() - 1
            }
        };
        places.insert(*colour, u8::try_from(place).ok()?);
    }
    Some((palette, places))
}

/// The largest difference in red, green or blue.
fn distance(a: Colour, b: Colour) -> u8 {
    a.iter().zip(b).map(|(a, b)| a.abs_diff(b)).max().unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn worst(colours: &[Colour]) -> u8 {
        let Indexed { palette, pixels } = Indexed::of(colours);
        assert!(palette.len() <= ROOM && pixels.len() == colours.len());
        let pairs = colours.iter().zip(&pixels);
        pairs.map(|(c, place)| distance(*c, palette[usize::from(*place)])).max().unwrap_or(0)
    }

    #[test]
    fn few_colours_stay_as_they_are() {
        assert_eq!(worst(&[]), 0);
        let all: Vec<Colour> = (0..=255).map(|n| [n, 255 - n, n / 2]).collect();
        assert_eq!(worst(&all), 0);
    }

    #[test]
    fn of_many_colours_the_frequent_ones_stay() {
        let ink = [[0x1d, 0x5f, 0xd1], [0xfd, 0xf2, 0xe9], [0x77; 3]];
        let mut colours: Vec<Colour> = ink.iter().flat_map(|colour| [*colour; 500]).collect();
        // 4,096 more, once each.
        for n in 0..4096u16 {
            colours.push([(n >> 8) as u8 * 16, (n >> 4 & 15) as u8 * 16, (n & 15) as u8 * 16]);
        }
        // Steps of 16, some of which share an entry.
        assert!((16..=63).contains(&worst(&colours)));
        let palette = Indexed::of(&colours).palette;
        assert_eq!(palette[..3], [[0x1d, 0x5f, 0xd1], [0x77; 3], [0xfd, 0xf2, 0xe9]]);
    }
}
