//! A number of the article beside the number by its equations.

use crate::sheet::Cell;

/// A value, and the article's value for it.
#[derive(Clone, Debug, PartialEq)]
pub struct Printed {
    /// The printed text without the comma between thousands: `2803.498`, `7.66E-4`.
    text: Option<&'static str>,
    /// The value by the equations.
    value: f64,
    /// Digits after the point where nothing is printed.
    decimals: usize,
    /// Why the two differ, if the article is wrong.
    wrong: Option<&'static str>,
}

impl Printed {
    /// A printed value that is right.
    pub fn right(text: &'static str, value: f64) -> Printed {
        Printed { text: Some(text), value, decimals: 0, wrong: None }
    }

    /// A printed value that is wrong, and why.
    pub fn wrong(text: &'static str, value: f64, why: &'static str) -> Printed {
        Printed { wrong: Some(why), ..Printed::right(text, value) }
    }

    /// A value that is not printed.
    pub fn none(value: f64, decimals: usize) -> Printed {
        Printed { text: None, value, decimals, wrong: None }
    }

    /// The number of the article.
    pub fn published(&self) -> Cell {
        let number = |text: &str| Cell::Real(text.parse().unwrap_or(f64::NAN), text.to_owned());
        self.text.map_or(Cell::Empty, number)
    }

    /// The number by the equations, in the article's form.
    pub fn computed(&self) -> Cell {
        match self.text {
            None => Cell::fixed(self.value, self.decimals),
            Some(text) => Cell::Real(self.value, like(text, self.value)),
        }
    }

    /// Why the two differ.
    pub fn remark(&self) -> Option<&'static str> {
        self.wrong
    }

    /// Whether the equations give the printed number to its last digit.
    pub fn agrees(&self) -> bool {
        self.text.is_none_or(|text| like(text, self.value) == text)
    }
}

/// A value with as many digits as a text has, in its notation.
fn like(text: &str, value: f64) -> String {
    let (number, power) = text.split_once('E').map_or((text, None), |(n, p)| (n, Some(p)));
    let decimals = number.split_once('.').map_or(0, |(_, part)| part.len());
    match power {
        None => format!("{value:.decimals$}"),
        Some(_) => format!("{value:.decimals$E}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_last_digit_counts() {
        assert!(Printed::right("0.00370", 0.003_695_4).agrees());
        assert!(!Printed::right("0.00370", 0.003_694_9).agrees());
        assert!(Printed::right("7.66E-4", 7.6649e-4).agrees());
        assert!(!Printed::right("7.66E-4", 7.67e-4).agrees());
        assert!(!Printed::wrong("2803.498", 2802.498, "a digit").agrees());
        assert!(Printed::right("432", 432.0).agrees());
    }
}
