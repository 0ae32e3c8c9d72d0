//! Decimal numbers exactly as they were typed.

/// `digits` · 10^−`places`: the value as typed, without conversion to a binary fraction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Decimal {
    /// Below 10¹⁸.
    digits: u64,
    /// At most 18.
    places: u8,
}

/// A quotient rounded to the nearest whole number, halves up.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Rounded {
    /// The number; `u64::MAX` if it is larger.
    pub value: u64,
    /// Whether nothing was rounded.
    pub exact: bool,
}

/// The most digits of a number: 4π from a calculator has 17.
const MOST: u8 = 18;

/// 2⁶⁴ / 2π, rounded to nearest.
const PER_TAU: u128 = 2_935_890_503_282_001_226;

impl Decimal {
    /// A whole number.
    pub const fn whole(number: u32) -> Decimal {
        Decimal { digits: number as u64, places: 0 }
    }

    /// The number of bytes at the beginning of a text that are a number: 5 in `1.5e3mm`.
    pub fn length(text: &str) -> usize {
        let digits =
            |text: &str| text.find(|c: char| !matches!(c, '0'..='9' | '.')).unwrap_or(text.len());
        let end = digits(text);
        let Some(power) = text[end..].strip_prefix(['e', 'E']) else { return end };
        let unsigned = power.strip_prefix(['-', '+']).unwrap_or(power);
        match unsigned.find(|c: char| !c.is_ascii_digit()).unwrap_or(unsigned.len()) {
            0 => end,
            length => end + 1 + (power.len() - unsigned.len()) + length,
        }
    }

    /// Parses `12`, `12.5`, `.5`, `12.` or `1.2e3`; a sign is not part of it.
    pub fn parse(text: &str) -> Result<Decimal, String> {
        match text.split_once(['e', 'E']) {
            Some((number, power)) => {
                let power: i32 = power
                    .parse()
                    .map_err(|_| format!("'{text}' is not a number: write it like 1234 or 1e9"))?;
                Decimal::plain(number)?.shifted(power, text)
            }
            None => Decimal::plain(text),
        }
    }

    /// This number · 10^power.
    fn shifted(mut self, power: i32, text: &str) -> Result<Decimal, String> {
        let mut places = i32::from(self.places) - power.clamp(-100, 100);
        while places < 0 && self.digits < 10u64.pow(u32::from(MOST) - 1) {
            self.digits *= 10;
            places += 1;
        }
        match u8::try_from(places) {
            _ if self.digits == 0 => Ok(Decimal { digits: 0, places: 0 }),
            Ok(places) if places <= MOST => Ok(Decimal { places, ..self }),
            _ if places < 0 => Err(format!("'{text}' is too large")),
            _ => Err(format!("'{text}' has too many decimals: at most {MOST}")),
        }
    }

    /// Parses a number without a power of ten.
    fn plain(text: &str) -> Result<Decimal, String> {
        let (whole, part) = text.split_once('.').unwrap_or((text, ""));
        let part = part.trim_end_matches('0');
        if whole.is_empty() && !text.bytes().any(|b| b.is_ascii_digit()) {
            return Err(format!("'{text}' is not a number"));
        }
        let mut number = Decimal { digits: 0, places: 0 };
        for digit in whole.chars().chain(part.chars()) {
            let Some(digit) = digit.to_digit(10) else {
                return Err(format!("'{text}' is not a number: write it like 1234 or 0.5"));
            };
            number.digits = number.digits * 10 + u64::from(digit);
            if number.digits >= 10u64.pow(MOST.into()) {
                return Err(format!("'{text}' has too many digits: at most {MOST}"));
            }
        }
        number.places = u8::try_from(part.len())
            .ok()
            .filter(|&places| places <= MOST)
            .ok_or_else(|| format!("'{text}' has too many decimals: at most {MOST}"))?;
        Ok(number)
    }

    /// This number · `up` / `down`, rounded once; `up` < 2⁶⁰, `down` < 2⁶⁰.
    pub fn times(self, up: u64, down: u64) -> Rounded {
        divide(
            u128::from(self.digits) * u128::from(up),
            u128::from(self.unit()) * u128::from(down),
            0,
        )
    }

    /// This number · `up` / (2π · `down`), rounded once; `up` < 2⁴⁰,
    /// `down` < 2⁴⁰. The error of 2π is below 2⁻⁶⁰ of the value.
    pub fn times_per_tau(self, up: u64, down: u64) -> Rounded {
        let x = (u128::from(self.digits) * u128::from(up)) << 16;
        let (high, low) = (x >> 64, x & u128::from(u64::MAX));
        let x = high * PER_TAU + ((low * PER_TAU) >> 64);
        let rounded = divide(x, u128::from(self.unit()) * u128::from(down), 16);
        Rounded { exact: self.digits == 0, ..rounded }
    }

    /// The nearest binary number, or one next to it.
    pub fn to_f64(self) -> f64 {
        self.digits as f64 / self.unit() as f64
    }

    fn unit(self) -> u64 {
        10u64.pow(self.places.into())
    }
}

/// n / (d · 2^bits), rounded to nearest.
fn divide(n: u128, d: u128, bits: u8) -> Rounded {
    let d = d << bits;
    let value = (n + d / 2) / d;
    Rounded { value: u64::try_from(value).unwrap_or(u64::MAX), exact: n.is_multiple_of(d) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(text: &str) -> (u64, u8) {
        let d = Decimal::parse(text).unwrap();
        (d.digits, d.places)
    }

    #[test]
    fn numbers_as_people_write_them() {
        assert_eq!(of("12"), (12, 0));
        assert_eq!(of("0012.50"), (125, 1));
        assert_eq!(of(".5"), (5, 1));
        assert_eq!(of("7."), (7, 0));
        assert_eq!(of("1e9"), (1_000_000_000, 0));
        assert_eq!(of("1.25E+3"), (1250, 0));
        assert_eq!(of("1.25e1"), (125, 1));
        assert_eq!(of("5e-3"), (5, 3));
        assert_eq!(of("0e99"), (0, 0));
        assert_eq!(
            ["1.5e3mm", "12rpm", "1e", "3e-2", "7e+mm"].map(Decimal::length),
            [5, 2, 1, 4, 1]
        );
        assert_eq!(of("12.566370614359172"), (12_566_370_614_359_172, 15));
    }

    #[test]
    fn what_is_not_a_number_is_said() {
        for text in [
            "",
            ".",
            "1.2.3",
            "1,5",
            "1e",
            "e6",
            "1e99",
            "1e-19",
            "1e1.5",
            "-1",
            "٣",
            "1234567890123456789",
        ] {
            assert!(Decimal::parse(text).is_err(), "{text}");
        }
    }

    #[test]
    fn the_constant_is_the_nearest() {
        let f = PER_TAU as f64 / 2f64.powi(64);
        assert_eq!(f, 1.0 / std::f64::consts::TAU);
    }
}
