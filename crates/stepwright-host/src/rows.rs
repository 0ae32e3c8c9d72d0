//! The rows of programs other than the controller: Austin's laws, the timed driver, motor cycles.
//!
//! The frame, the checksum and the common rows are the same in all programs, so watching, stopping and killing
//! work as with the controller. Rows are a program's own lines.

use stepwright_protocol::{AxisId, Selection, crc};

use crate::conversation::{Conversation, LinkError};
use crate::motion::NotBegun;

/// How often a row is said to a board that answers: noise spoils most reports of 100 bytes. A board that does
/// not answer counts as silent after the first attempt.
const TRIES: usize = 32;

/// The answer to a damaged line, of which the board has obeyed nothing.
const DAMAGED: &str = "E sum";

impl Conversation {
    /// Gets in step with the board, and returns its answer to `?`, or `stepwright` for a controller.
    ///
    /// # Errors
    /// [`LinkError::Silent`] after 4 s.
    pub async fn meet_program(&mut self) -> Result<String, LinkError> {
        self.greet().await?;
        // The first answer has no checksum and may be damaged; this one has a checksum.
        if self.program.is_some() { self.about().await } else { Ok("stepwright".to_owned()) }
    }

    /// Asks the program for its answer to `?` again.
    ///
    /// # Errors
    /// [`LinkError`]
    pub async fn about(&mut self) -> Result<String, LinkError> {
        let about = self.row("?", true).await?.ok_or(LinkError::Silent)?;
        self.program = Some(about.clone());
        Ok(about)
    }

    /// Says a row with its checksum, and returns its answer without the checksum. A row that reached the board
    /// damaged is repeated. A row whose answer was lost or spoiled is repeated if it is harmless `twice`;
    /// otherwise returns `None`.
    ///
    /// # Errors
    /// [`LinkError`]
    pub async fn row(&mut self, row: &str, twice: bool) -> Result<Option<String>, LinkError> {
        for _ in 0..TRIES {
            self.in_step().await?;
            self.pipe.forget_incoming();
            let sum = row.bytes().fold(0, crc);
            self.pipe.write(format!("{row}*{sum:02X}\r").bytes());
            let heard = self.row_answer().await?;
            self.unheard = false;
            match heard {
                Heard::Answer(answer) if answer == DAMAGED => continue,
                Heard::Answer(answer) => return Ok(Some(answer)),
                // It is unknown which line's answer was spoiled.
                Heard::Spoiled | Heard::Nothing => self.resync().await?,
            }
            if !twice {
                return Ok(None);
            }
        }
        Err(LinkError::Silent)
    }

    /// Waits for the answer to a row. Answers without a checksum belong to the `#` that gets in step; `R` and
    /// `B` belong to the F after it.
    async fn row_answer(&mut self) -> Result<Heard, LinkError> {
        while let Some(text) = self.line().await? {
            match text.rsplit_once('*') {
                Some((bare, sum)) if sum == format!("{:02X}", bare.bytes().fold(0, crc)) => {
                    if !self.hear(bare) {
                        return Ok(Heard::Answer(bare.to_owned()));
                    }
                }
                Some(_) => return Ok(Heard::Spoiled),
                None => _ = self.hear(&text),
            }
        }
        Ok(Heard::Nothing)
    }

    /// Starts an axis that rests at `from` by a row, and returns the answer. A row whose answer was lost is
    /// repeated only once the board has shown that the row had no effect.
    ///
    /// # Errors
    /// [`NotBegun::Trouble`], [`NotBegun::Noise`]
    pub async fn begin_by(
        &mut self,
        axis: AxisId,
        row: &str,
        from: Option<i64>,
    ) -> Result<String, NotBegun> {
        for _ in 0..TRIES {
            if let Some(answer) = self.row(row, false).await.map_err(NotBegun::unsure)? {
                return Ok(answer);
            }
            let moves = self.is_busy(Selection::One(axis)).await.map_err(NotBegun::unsure)?;
            if moves || self.rest_position(axis).await.map_err(NotBegun::unsure)? != from {
                return Ok("Y".to_owned());
            }
            // Without a position a travel that is over leaves no trace: it is not repeated.
            if from.is_none() {
                break;
            }
        }
        Err(NotBegun::Noise)
    }
}

/// The result of waiting for an answer.
enum Heard {
    /// An answer with the right checksum, which is removed.
    Answer(String),
    /// An answer with a wrong checksum.
    Spoiled,
    Nothing,
}
