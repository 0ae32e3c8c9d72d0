//! Numbers for programs, without the rounding noise of binary fractions.

use serde_json::{Number, Value};

/// The significant digits of a measurement or a calculation.
const DIGITS: usize = 12;

/// The value with its fractions rounded to 12 digits: 0.3, not 0.30000000000000004; 0 for -0.
pub fn tidy(value: Value) -> Value {
    match value {
        Value::Number(number) => Value::Number(rounded(&number).unwrap_or(number)),
        Value::Array(all) => all.into_iter().map(tidy).collect(),
        Value::Object(all) => all.into_iter().map(|(key, one)| (key, tidy(one))).collect(),
        other => other,
    }
}

/// The value, with 0 for -0.
pub fn unsigned_zero(value: f64) -> f64 {
    value + 0.0
}

fn rounded(number: &Number) -> Option<Number> {
    let value = number.as_f64().filter(|_| number.is_f64())?;
    let digits = DIGITS - 1;
    let value: f64 = format!("{value:.digits$e}").parse().ok()?;
    Number::from_f64(unsigned_zero(value))
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn fractions_have_no_noise_and_whole_numbers_all_their_digits() {
        let noisy =
            json!({ "a": 0.1 + 0.2, "b": [-0.0, 1e-9 / 3.0, u64::MAX, "0.30000000000000004"] });
        let clean =
            json!({ "a": 0.3, "b": [0.0, 3.33333333333e-10, u64::MAX, "0.30000000000000004"] });
        assert_eq!(tidy(noisy).to_string(), clean.to_string());
    }
}
