//! A line to a board that is listened to.

use std::io;
use std::sync::Arc;
use std::time::Duration;

use stepwright_serve::ServeDesk;

use stepwright_host::link::Link;

/// No line and no answer is longer.
const LONGEST: usize = 1024;

/// A line whose conversation is told to a desk.
pub struct Tap {
    line: Box<dyn Link>,
    desk: Arc<ServeDesk>,
    /// What was said since the last CR, and what was answered.
    saying: Vec<u8>,
    answer: Vec<u8>,
    /// Said, and not answered yet.
    said: Option<String>,
}

impl Tap {
    /// Listens to this line.
    pub fn new(line: Box<dyn Link>, desk: Arc<ServeDesk>) -> Tap {
        Tap { line, desk, saying: Vec::new(), answer: Vec::new(), said: None }
    }

    fn unanswered(&mut self) {
        if let Some(said) = self.said.take() {
            self.desk.heard(&said, None);
        }
    }
}

/// Puts a byte to a line; the line, if it is whole.
fn whole(line: &mut Vec<u8>, byte: u8) -> Option<String> {
    match byte {
        b'\n' => None,
        b'\r' => Some(String::from_utf8_lossy(&std::mem::take(line)).into_owned()),
        byte => {
            if line.len() < LONGEST {
                line.push(byte);
            }
            None
        }
    }
}

impl Link for Tap {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        for &byte in bytes {
            if let Some(said) = whole(&mut self.saying, byte) {
                self.unanswered();
                self.answer.clear();
                self.said = Some(said);
            }
        }
        self.line.write(bytes)
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        let count = self.line.read(buffer, limit)?;
        for &byte in buffer.iter().take(count) {
            if let Some(answer) = whole(&mut self.answer, byte)
                && let Some(said) = self.said.take()
            {
                self.desk.heard(&said, Some(&answer));
            }
        }
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
