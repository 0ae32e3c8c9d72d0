//! The signal of the step interrupt to the planner.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

/// The news of a step interrupt. Put it in a static beside the
/// [`SharedEngine`](stepwright::SharedEngine).
///
/// ```
/// use stepwright_embassy::News;
///
/// static NEWS: News = News::new();
///
/// # fn on_compare() -> bool { true }
/// // The timer's interrupt; on a chip `unsafe { ENGINE.on_compare() }`.
/// if on_compare() {
///     NEWS.tell();
/// }
/// ```
pub struct News(Signal<CriticalSectionRawMutex, ()>);

impl News {
    /// Without news.
    pub const fn new() -> News {
        News(Signal::new())
    }

    /// Signals news and wakes the planner. Callable from any context; it takes a critical section
    /// of some twenty instructions.
    pub fn tell(&self) {
        self.0.signal(());
    }

    /// Waits for news; returns at once if there was some since the last wait. For one task at a
    /// time: that of [`Motors::plan`](crate::Motors::plan), or a planner of your own.
    pub fn wait(&self) -> impl Future<Output = ()> {
        self.0.wait()
    }
}

impl Default for News {
    fn default() -> News {
        News::new()
    }
}
