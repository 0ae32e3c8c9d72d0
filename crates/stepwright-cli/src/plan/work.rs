//! How far a long calculation is, on standard error: billions of steps take minutes.

use crate::order::progress::Line;

/// Steps between two looks at the clock.
const STRIDE: u32 = 1 << 20;

/// A walk over the steps of a travel, told once a second.
pub struct Work {
    what: &'static str,
    of: u32,
    next: u32,
    line: Option<Line>,
}

impl Work {
    /// Over `of` steps; of a short walk nothing is said.
    pub fn new(what: &'static str, of: u32) -> Work {
        Work { what, of, next: STRIDE, line: None }
    }

    /// At step `n`.
    pub fn at(&mut self, n: u32) {
        if n >= self.next {
            self.tell(n);
        }
    }

    #[cold]
    fn tell(&mut self, n: u32) {
        self.next = n.saturating_add(STRIDE);
        let line = self.line.get_or_insert_with(Line::new);
        let percent = f64::from(n) * 100.0 / f64::from(self.of.max(1));
        let short = format!("{} {percent:.0} %", self.what);
        let long = format!("{short} of {} steps", self.of);
        line.show(&[&long, &short], &long, false);
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        if let Some(line) = &self.line {
            line.end();
        }
    }
}
