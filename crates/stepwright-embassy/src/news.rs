//! What the step interrupt tells the planner.

use embassy_sync::blocking_mutex::raw::CriticalSectionRawMutex;
use embassy_sync::signal::Signal;

/// The news of a step interrupt, for a static beside the
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
    /// Nothing has happened yet.
    pub const fn new() -> News {
        News(Signal::new())
    }

    /// There is news: wakes the planner. For any context; it takes a critical section of some
    /// twenty instructions.
    pub fn tell(&self) {
        self.0.signal(());
    }

    /// Waits for news; at once if there was some since the last time. One task at a time: that of
    /// [`Motors::plan`](crate::Motors::plan), or a planner of one's own.
    pub fn wait(&self) -> impl Future<Output = ()> {
        self.0.wait()
    }
}

impl Default for News {
    fn default() -> News {
        News::new()
    }
}
