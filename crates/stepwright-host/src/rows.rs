//! The rows of a program with other features than the controller's: Austin's laws, the timed
//! driver, motor cycles.
//!
//! Frame, checksum and the common rows are those of every conversation; so such a program is
//! watched, stopped and killed as the controller is. A row is one of its own.

use stepwright_protocol::{AxisId, Selection, crc};

use crate::conversation::{Conversation, LinkError};
use crate::motion::NotBegun;

/// How often a row is said to a board that answers: of a report of 100 bytes noise leaves few
/// whole. (One that does not answer counts as silent after the first.)
const TRIES: usize = 32;

/// What `E` and this reason say: the board has obeyed nothing of the line.
const DAMAGED: &str = "E sum";

impl Conversation {
    /// Gets in step with the board, and asks what it is: its answer to `?`, or `stepwright` of a
    /// controller.
    ///
    /// # Errors
    /// [`LinkError::Silent`] after 4 s.
    pub async fn meet_program(&mut self) -> Result<String, LinkError> {
        self.greet().await?;
        // Its first answer may have lost a byte; this one has a checksum.
        if self.program.is_some() { self.about().await } else { Ok("stepwright".to_owned()) }
    }

    /// What the program says of itself now.
    ///
    /// # Errors
    /// [`LinkError`]
    pub async fn about(&mut self) -> Result<String, LinkError> {
        let about = self.row("?", true).await?.ok_or(LinkError::Silent)?;
        self.program = Some(about.clone());
        Ok(about)
    }

    /// Says a row with its checksum, and gives its answer without. A row that the board found
    /// damaged is said again, and so is one that is harmless `twice` whose answer was lost or
    /// spoiled; of any other `None` says so.
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
                // Which line's answer was spoiled is not known.
                Heard::Spoiled | Heard::Nothing => self.resync().await?,
            }
            if !twice {
                return Ok(None);
            }
        }
        Err(LinkError::Silent)
    }

    /// Waits for the answer to a row. One without a checksum is to no line of ours but the `#` by
    /// which we get in step, and `R` and `B` are to the F behind it.
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

    /// Starts an axis that stands at `from` by a row; its answer. A row whose answer was lost is
    /// said again, but only once the board has shown that nothing came of it.
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
        }
        Err(NotBegun::Noise)
    }
}

/// What came of waiting for an answer.
enum Heard {
    /// One with the right checksum, without it.
    Answer(String),
    /// One with the checksum of another.
    Spoiled,
    Nothing,
}
