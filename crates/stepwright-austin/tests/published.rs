//! The program that the article prints, delay for delay, against another implementation of its
//! states.

use proptest::prelude::*;
use stepwright_austin::Fixed;

/// The delays between `m` pulses by the published program's states, in its integers.
fn published(m: i64, c0: i64, c_min: i64) -> Vec<u32> {
    enum State {
        Up,
        Max { down: i64 },
        Down,
    }
    let (mut c32, mut c, mut denominator, mut state) = (c0 << 8, c0, 1, State::Up);
    let mut delays = vec![c0 as u32];
    for step in 0..m - 2 {
        let mut ramp = true;
        match state {
            State::Up if step == (m - 1) / 2 => {
                state = State::Down;
                denominator = 4 * (step - m) + 1;
                if m % 2 == 0 {
                    denominator += 4;
                    ramp = false;
                }
            }
            State::Max { down } => {
                ramp = false;
                if step == down {
                    state = State::Down;
                    denominator = 4 * (step - m) + 5;
                }
            }
            _ => {}
        }
        if ramp {
            denominator += 4;
            c32 -= 2 * c32 / denominator;
            c = (c32 + 128) >> 8;
            if matches!(state, State::Up) && c <= c_min {
                (state, c) = (State::Max { down: m - step }, c_min);
            }
        }
        delays.push(c as u32);
    }
    delays
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2_000))]

    /// Delay for delay, wherever the program's 16 and 24.8 bits suffice.
    #[test]
    fn the_published_program(m in 2u32..4_000, c0 in 2_001u32..65_536, c_min in 300u32..2_000) {
        let got: Vec<_> = Fixed::new(m, c0, c_min).skip(1).collect();
        prop_assert_eq!(got, published(m.into(), c0.into(), c_min.into()));
    }
}

/// The vectors of the published form.
#[test]
fn fixed_point_vectors() {
    let demo: Vec<_> = Fixed::new(1_000, 50_000, 2_500).collect();
    assert_eq!(demo[995..], [15_654, 17_302, 19_608, 23_174, 29_795]);
    assert_eq!(published(1_000, 50_000, 2_500), demo[1..]);

    assert_eq!(Fixed::new(3, 50_000, 2_500).collect::<Vec<_>>(), [0, 50_000, 30_000]);
    assert_eq!(
        Fixed::new(10, 50_000, 2_500).collect::<Vec<_>>(),
        [0, 50_000, 30_000, 23_333, 19_744, 17_421, 17_421, 19_744, 23_333, 30_000]
    );
}
