//! Clips lines to a rectangle.

/// A point, or a range from low to high.
type Pair = (f64, f64);

/// The pieces of a line through `points` with x and y in the ranges, by the Liang–Barsky algorithm:
/// every segment is cut where it crosses an edge.
pub fn clip(points: &[Pair], x: Pair, y: Pair) -> Vec<Vec<Pair>> {
    let mut pieces: Vec<Vec<Pair>> = Vec::new();
    for pair in points.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let Some((from, to)) = within(a, b, x, y) else { continue };
        let at = |t: f64| (a.0 + t * (b.0 - a.0), a.1 + t * (b.1 - a.1));
        // Ends that are not cut stay unchanged to the last bit.
        let begin = if from > 0.0 { at(from) } else { a };
        let end = if to < 1.0 { at(to) } else { b };
        match pieces.last_mut() {
            Some(piece) if from == 0.0 && piece.last() == Some(&begin) => piece.push(end),
            _ => pieces.push(vec![begin, end]),
        }
    }
    pieces
}

/// The part of the segment from `a` to `b` within the ranges, as fractions of it from 0 to 1.
fn within(a: Pair, b: Pair, x: Pair, y: Pair) -> Option<Pair> {
    let (mut from, mut to) = (0.0f64, 1.0f64);
    for (start, end, (low, high)) in [(a.0, b.0, x), (a.1, b.1, y)] {
        let length = end - start;
        if length == 0.0 {
            if !(low..=high).contains(&start) {
                return None;
            }
            continue;
        }
        let (t, u) = ((low - start) / length, (high - start) / length);
        from = from.max(t.min(u));
        to = to.min(t.max(u));
    }
    (from < to).then_some((from, to))
}

#[cfg(test)]
mod tests {
    use super::*;

    const UNIT: Pair = (0.0, 1.0);

    #[test]
    fn what_lies_within_stays_one_line() {
        let line = [(0.0, 0.0), (0.3, 1.0), (0.3, 0.1), (1.0, 0.7)];
        assert_eq!(clip(&line, UNIT, UNIT), [line.to_vec()]);
    }

    #[test]
    fn what_leaves_and_returns_is_two() {
        let line = [(0.0, 0.5), (0.5, 1.5), (1.0, 0.5), (2.0, 0.5)];
        let inside = [[(0.0, 0.5), (0.25, 1.0)], [(0.75, 1.0), (1.0, 0.5)]];
        assert_eq!(clip(&line, UNIT, UNIT), inside);
    }

    #[test]
    fn what_lies_outside_is_nothing() {
        assert!(clip(&[(2.0, 0.0), (3.0, 9.0)], UNIT, UNIT).is_empty());
        assert!(clip(&[(-1.0, 3.0), (3.0, 3.0)], UNIT, UNIT).is_empty());
        assert!(clip(&[(0.5, 0.5)], UNIT, UNIT).is_empty());
    }
}
