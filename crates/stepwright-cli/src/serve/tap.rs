//! A link to a board whose lines are recorded.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use stepwright_host::link::Link;
use stepwright_keeper::tap::Tap;
use stepwright_serve::ServeDesk;

/// A link whose lines and answers are reported to a desk.
pub struct TappedLink {
    line: Box<dyn Link>,
    desk: Arc<ServeDesk>,
    tap: Tap,
}

impl TappedLink {
    /// Taps this link.
    pub fn new(line: Box<dyn Link>, desk: Arc<ServeDesk>) -> TappedLink {
        TappedLink { line, desk, tap: Tap::default() }
    }
}

impl Link for TappedLink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.tap.said(bytes, |line, answer| self.desk.heard(line, answer));
        self.line.write(bytes)
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        let count = self.line.read(buffer, limit)?;
        let bytes = buffer.get(..count).unwrap_or_default();
        self.tap.answered(bytes, |line, answer| self.desk.heard(line, answer));
        Ok(count)
    }

    fn now(&self) -> Duration {
        self.line.now()
    }

    fn name(&self) -> String {
        self.line.name()
    }

    fn is_alone(&mut self) -> bool {
        self.line.is_alone()
    }

    fn rest(&mut self, time: Duration) {
        self.line.rest(time);
    }

    fn finish(&mut self) -> io::Result<()> {
        self.line.finish()
    }
}
