//! A symmetric banded matrix and a gradient: a step of Newton's method.

pub struct Bands {
    /// Row by row, from the diagonal on.
    rows: Vec<f64>,
    wide: usize,
    pub slope: Vec<f64>,
}

impl Bands {
    pub fn new(count: usize, wide: usize) -> Bands {
        Bands { rows: vec![0.0; count * wide], wide, slope: vec![0.0; count] }
    }

    /// Adds to the entry of two variables, of which `row` comes first.
    pub fn add(&mut self, row: usize, column: usize, by: f64) {
        self.rows[row * self.wide + column - row] += by;
    }

    /// The x of H·x = −gradient, with a part of the diagonal added to it. It is 0 for a variable on which
    /// nothing depends.
    pub fn step(&mut self, damp: f64) -> Vec<f64> {
        let (count, wide) = (self.slope.len(), self.wide);
        let mut x: Vec<f64> = self.slope.iter().map(|slope| -slope).collect();
        // The part of the diagonal that rounding may leave.
        let least: Vec<f64> = (0..count).map(|row| 1e-13 * self.rows[row * wide]).collect();
        for row in 0..count {
            self.rows[row * wide] *= 1.0 + damp;
        }
        for row in 0..count {
            let (done, rest) = self.rows.split_at_mut((row + 1) * wide);
            let here = &mut done[row * wide..];
            here[0] = here[0].max(least[row]);
            if here[0] == 0.0 {
                (here[0], x[row]) = (1.0, 0.0);
            }
            for a in 1..wide.min(count - row) {
                let part = here[a] / here[0];
                if part != 0.0 {
                    for b in a..wide {
                        rest[(a - 1) * wide + b - a] -= part * here[b];
                    }
                    x[row + a] -= part * x[row];
                }
            }
        }
        for row in (0..count).rev() {
            let here = &self.rows[row * wide..];
            let known: f64 = (1..wide.min(count - row)).map(|a| here[a] * x[row + a]).sum();
            x[row] = (x[row] - known) / here[0];
        }
        x
    }
}
