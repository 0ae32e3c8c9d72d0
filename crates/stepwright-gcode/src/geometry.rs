//! The geometry of arcs, in integers.
//!
//! Coordinates are in picometres, at most 3 · 10¹⁵. Squares of distances are therefore below 2 · 10³¹, and a
//! million times that fits in 127 bits.

/// The distances of both ends from the centre may differ by this, whatever the radius: 0.005 mm.
const SLACK: i128 = 5_000_000;
/// Or by 0.1 % of the radius, but at most by this: 0.5 mm.
const MOST: i128 = 500_000_000;

/// The square of a distance from its two components, each at most 3 · 10¹⁵.
pub(crate) fn square([x, y]: [i64; 2]) -> i128 {
    i128::from(x) * i128::from(x) + i128::from(y) * i128::from(y)
}

/// Whether both ends of an arc are equally far from its centre, within the tolerances of grbl 1.1.
///
/// `start` and `end` are squares of the distances.
pub(crate) fn radii_agree(start: i128, end: i128) -> bool {
    // 0.1 %: 0.999² start ≤ end ≤ 1.001² start.
    let million_ends = 1_000_000 * end;
    let thousandth = (998_001 * start..=1_002_001 * start).contains(&million_ends);
    within(start, end, SLACK) || thousandth && within(start, end, MOST)
}

/// |√a − √b| ≤ t, exactly: for b ≥ a and e = b − a − t² that is e² ≤ 4 t² a, or e ≤ 0.
fn within(a: i128, b: i128, t: i128) -> bool {
    let (a, b) = (a.min(b), a.max(b));
    let root = a.unsigned_abs().isqrt() as i128;
    // The limit is b − a − t² = 2 t √a, and √a is `root` plus less than 1.
    let e = b - a - t * t - 2 * t * root;
    if e <= 0 || e > 2 * t {
        return e <= 0;
    }
    // (2 t root + e)² ≤ 4 t² a, without the terms that both sides share.
    4 * t * root * e + e * e <= 4 * t * t * (a - root * root)
}

/// The offset of the centre from the start of an arc by radius, within a picometre on each axis. `way` leads
/// from the start to the end and is not 0. The centre is to the left or to the right of it.
///
/// `None` if twice the radius is less than the length of `way`.
pub(crate) fn centre(way: [i64; 2], radius: i64, left: bool) -> Option<[i64; 2]> {
    let length = square(way);
    let height = 4 * square([radius, 0]) - length;
    if height < 0 {
        return None;
    }
    // The centre is at (way + turned way · √(height / length)) / 2.
    let [x, y] = way.map(|part| scaled_root(part, height as u128, length as u128));
    let [x, y] = if left { [-y, x] } else { [y, -x] };
    Some([(way[0] + x) / 2, (way[1] + y) / 2])
}

/// `part` · √(`over` / `under`), to the nearest, for `part`² ≤ `under`.
fn scaled_root(part: i64, over: u128, under: u128) -> i64 {
    if over == 0 {
        return 0;
    }
    // Roots of 62 bits or more: √x · 2ⁿ.
    let root = |x: u128| {
        let bits = x.leading_zeros().saturating_sub(2) / 2;
        ((x << (2 * bits)).isqrt(), bits)
    };
    let ((over, n), (under, m)) = (root(over), root(under));
    // part · over · 2ᵐ / (under · 2ⁿ), without the smaller shift: both are below 2¹¹⁶.
    let over = (u128::from(part.unsigned_abs()) * over) << m.saturating_sub(n);
    let under = under << n.saturating_sub(m);
    let size = (over + under / 2).checked_div(under).unwrap_or(0) as i64;
    if part < 0 { -size } else { size }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use std::string::ToString;

    use dashu_float::DBig;
    use proptest::prelude::*;

    use super::*;

    /// A number with a precision of 80 digits.
    fn big(number: i128) -> DBig {
        DBig::from(number).with_precision(80).value()
    }

    fn distance(a: DBig, b: DBig) -> DBig {
        if a < b { b - a } else { a - b }
    }

    fn whole(number: DBig) -> i128 {
        number.to_int().value().to_string().parse().unwrap()
    }

    fn root(number: i128) -> DBig {
        big(number).sqrt()
    }

    /// Coordinates of every size, up to 3 · 10¹⁵.
    fn part(most: i64) -> impl Strategy<Value = i64> {
        (0..52_u32, -most..=most).prop_map(|(shift, part)| part >> shift)
    }

    proptest! {
        #[test]
        fn tolerances_are_exact(x in part(1_000_000_000_000_000), y in part(1_000_000_000_000_000),
            near in -3_i128..=3, which in 0..3, shrunk in any::<bool>()) {
            let start = square([x, y]);
            // At the bound and a few units off it.
            let bound = match which {
                0 => big(SLACK),
                1 => big(MOST),
                _ => root(start) / big(1000),
            };
            let end = if shrunk { root(start) - &bound } else { root(start) + &bound };
            prop_assume!(end > big(0));
            let end = whole(&end * &end) + near;
            prop_assume!(end >= 0);
            let gap = distance(root(end), root(start));
            let thousandth = gap.clone() * big(1000) <= root(start);
            let agree = gap <= big(SLACK) || thousandth && gap <= big(MOST);
            prop_assert_eq!(radii_agree(start, end), agree);
        }

        #[test]
        fn a_centre_by_radius_is_within_a_picometre(
            x in part(2_000_000_000_000_000), y in part(2_000_000_000_000_000),
            more in part(1_000_000_000_000_000), left in any::<bool>()) {
            prop_assume!((x, y) != (0, 0));
            let length = square([x, y]);
            // From half the way on, rounded up or down.
            let radius = (length.isqrt() / 2) as i64 + more.abs();
            prop_assume!(radius <= 1_000_000_000_000_000);
            let height = 4 * square([radius, 0]) - length;
            let Some(found) = centre([x, y], radius, left) else {
                prop_assert!(height < 0);
                return Ok(());
            };
            prop_assert!(height >= 0);
            let ratio = root(height) / root(length);
            let sides = if left { [-y, x] } else { [y, -x] };
            for (found, (way, side)) in found.into_iter().zip([x, y].into_iter().zip(sides)) {
                let exact = (big(way.into()) + big(side.into()) * &ratio) / big(2);
                prop_assert!(distance(big(found.into()), exact) < big(1));
            }
        }
    }
}
