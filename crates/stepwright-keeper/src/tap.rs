//! Splits the bytes of a conversation into lines and answers.

/// The most bytes of a line or an answer.
const LONGEST: usize = 1024;

/// Listens to a host and a board.
#[derive(Default)]
pub struct Tap {
    /// The bytes from the host since its last CR, and those from the board.
    saying: Vec<u8>,
    answer: Vec<u8>,
    /// The line that has no answer yet.
    said: Option<String>,
}

/// Adds a byte to a line, and returns the line once it is complete.
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

impl Tap {
    /// Takes bytes from the host; `heard` is called for each line that gets no answer.
    pub fn said(&mut self, bytes: &[u8], mut heard: impl FnMut(&str, Option<&str>)) {
        for &byte in bytes {
            if let Some(said) = whole(&mut self.saying, byte) {
                if let Some(before) = self.said.take() {
                    heard(&before, None);
                }
                self.answer.clear();
                self.said = Some(said);
            }
        }
    }

    /// Takes bytes from the board; `heard` is called for each line and its answer.
    pub fn answered(&mut self, bytes: &[u8], mut heard: impl FnMut(&str, Option<&str>)) {
        for &byte in bytes {
            if let Some(answer) = whole(&mut self.answer, byte)
                && let Some(said) = self.said.take()
            {
                heard(&said, Some(&answer));
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::Tap;

    #[test]
    fn each_line_has_its_answer_or_none() {
        let (mut tap, mut heard) = (Tap::default(), Vec::new());
        let mut note = |line: &str, answer: Option<&str>| {
            heard.push((line.to_owned(), answer.map(str::to_owned)));
        };
        tap.said(b"V", &mut note);
        tap.said(b"1\r", &mut note);
        tap.answered(b"\r\n", &mut note);
        tap.answered(b"7", &mut note);
        tap.said(b"F\rZ\r", &mut note);
        // Half an answer to an earlier line is dropped.
        tap.answered(b"Y\rnoise\r", &mut note);
        let right = [("V1", Some("")), ("F", None), ("Z", Some("Y"))];
        let right = right.map(|(line, answer)| (line.to_owned(), answer.map(str::to_owned)));
        assert_eq!(heard, right);
    }
}
