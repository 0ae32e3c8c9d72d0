//! A line to a board that is listened to.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use stepwright_host::link::Link;
use stepwright_keeper::tap::Tap;
use stepwright_serve::ServeDesk;

/// A line whose conversation is told to a desk.
pub struct TappedLink {
    line: Box<dyn Link>,
    desk: Arc<ServeDesk>,
    tap: Tap,
}

impl TappedLink {
    /// Listens to this line.
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
