//! The progress of a long calculation, on standard error: billions of steps take minutes.

use std::cell::RefCell;

use crate::order::progress::Line;

/// The progress through the steps of a travel, shown once a second.
#[derive(Default)]
pub struct Work(RefCell<Option<(&'static str, Line)>>);

impl Work {
    /// Shows the activity, the present step, and the number of steps.
    pub fn tell(&self, what: &'static str, n: u32, of: u32) {
        let mut told = self.0.borrow_mut();
        if let Some((_, line)) = told.take_if(|(before, _)| *before != what) {
            line.end();
        }
        let (_, line) = told.get_or_insert_with(|| (what, Line::new()));
        let percent = f64::from(n) * 100.0 / f64::from(of.max(1));
        let short = format!("{what} {percent:.0} %");
        let long = format!("{short} of {of} steps");
        line.show(&[&long, &short], &long, false);
    }
}

impl Drop for Work {
    fn drop(&mut self) {
        if let Some((_, line)) = self.0.get_mut() {
            line.end();
        }
    }
}
