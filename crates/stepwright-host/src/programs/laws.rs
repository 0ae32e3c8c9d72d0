//! A board that runs Austin's laws: axis 1, with one ramp law at a time.

use std::time::Duration;

use stepwright::Accel;
use stepwright_austin::line::{Line, NAME, Refused, can};
use stepwright_austin::{LawName, Recipe};
use stepwright_protocol::{AxisId, Selection};

use super::{ProgramRow, ProgramSession, RowProblem, obeyed, value};
use crate::conversation::LinkError;
use crate::motion::{Action, Adrift, Ended, NotBegun, RestPlace, Sight};
use crate::outcome::Outcome;

/// A board that moves by Austin's laws.
///
/// ```
/// use stepwright_austin::Recipe;
/// use stepwright_host::link::simulated::{VirtualLink, VirtualProgram};
/// use stepwright_host::programs::LawSession;
/// use stepwright_sim::{Description, LawBoard, Queues};
///
/// # fn main() -> Result<(), stepwright_host::programs::LawProblem> {
/// let queues = Box::leak(Box::<Queues>::default());
/// let board: LawBoard<'_, ()> = LawBoard::new(queues, Description::uno(), ());
/// let link = VirtualLink::new(VirtualProgram::new(board, 16_000_000, 1_388), true);
/// let mut board = LawSession::on(Box::new(link))?;
/// // The published listing: the first delay 5,000 µs, the shortest 1,000 µs.
/// board.set_law(&Recipe::AustinFixed(5_000, 1_000), &[])?;
/// assert_eq!(board.move_by(400)?.to_string(), "reached 400");
/// # Ok(())
/// # }
/// ```
pub type LawSession = ProgramSession<Line>;

/// Why an order by a law was not carried out.
pub type LawProblem = RowProblem<Line>;

impl ProgramRow for Line {
    const GREETING: &'static str = NAME;
    type Reason = Refused;

    /// A repeated change would count as two. A repeated law is harmless, as it clears all changes.
    fn is_harmless_twice(&self) -> bool {
        matches!(self, Line::Law(_))
    }
}

impl LawSession {
    /// The laws that the board has.
    pub fn laws(&self) -> impl Iterator<Item = LawName> {
        can(self.word("can").unwrap_or_default())
    }

    /// The number of late steps since the board was switched on, if it counts them.
    ///
    /// # Errors
    /// [`RowProblem::Lost`]
    pub fn late(&mut self) -> Result<Option<u32>, LawProblem> {
        let about = self.session.about()?;
        Ok(value(&about, "late").and_then(|late| late.parse().ok()))
    }

    /// Sets the law of the following travels, and its changes: after this many steps, this acceleration.
    ///
    /// # Errors
    /// [`RowProblem::Refused`] if the board does not have this law, or the law is too fast; and the others.
    pub fn set_law(&mut self, recipe: &Recipe, changes: &[(u32, Accel)]) -> Result<(), LawProblem> {
        self.say(&Line::Law(*recipe))?;
        changes.iter().try_for_each(|(steps, accel)| self.say(&Line::Change(*steps, *accel)))
    }

    /// Begins to move from `from`, by [`Line::Go`] or [`Line::Run`]. A row whose answer was lost is repeated
    /// only once the board has shown that the row had no effect.
    ///
    /// # Errors
    /// [`RowProblem::Refused`], [`RowProblem::Noise`]: nothing moves. After [`RowProblem::Lost`] the
    /// motor may be moving.
    pub fn begin(&mut self, row: &Line, from: Option<i64>) -> Result<(), LawProblem> {
        self.session.begins(AxisId::FIRST, from);
        if let Line::Go(steps) = *row {
            self.session.wait(async |talk| talk.travels.goes(AxisId::FIRST, steps))?;
        }
        match self.session.begin_by(AxisId::FIRST, &row.to_string(), from) {
            Ok(answer) => obeyed(row, &answer),
            Err(NotBegun::Trouble { trouble, .. }) => Err(RowProblem::Lost(trouble)),
            Err(NotBegun::Noise | NotBegun::Refused(..)) => Err(RowProblem::Noise { row: *row }),
        }
    }

    /// Moves by a number of steps, and waits.
    ///
    /// # Errors
    /// As for [`begin`](LawSession::begin).
    pub fn move_by(&mut self, steps: i32) -> Result<Outcome, LawProblem> {
        let from = self.session.rest_position(AxisId::FIRST)?;
        self.begin(&Line::Go(steps), from)?;
        let target = from.map(|from| from.saturating_add(steps.into()));
        self.watch(None, target)
    }

    /// Runs for a time, brakes by the law, and waits until the motor rests.
    ///
    /// # Errors
    /// As for [`begin`](LawSession::begin).
    pub fn run(&mut self, forward: bool, time: Duration) -> Result<Outcome, LawProblem> {
        let from = self.session.rest_position(AxisId::FIRST)?;
        self.begin(&Line::Run(forward), from)?;
        let until = self.session.now().saturating_add(time);
        self.watch(Some(until), None)
    }

    /// Brakes by the law, and waits until the motor rests. The position stays known. `Reached` means that its
    /// travel had ended.
    ///
    /// # Errors
    /// [`RowProblem::Lost`]
    pub fn stop(&mut self) -> Result<Outcome, LawProblem> {
        self.session.stop(Selection::One(AxisId::FIRST))?;
        let end = self.session.talk().travels.end(AxisId::FIRST);
        self.watch(None, end)
    }

    /// Watches the motor until it rests. `Reached` means that it rests at `target`, or that it was braked at
    /// `until`.
    fn watch(
        &mut self,
        until: Option<Duration>,
        target: Option<i64>,
    ) -> Result<Outcome, LawProblem> {
        let axis = AxisId::FIRST;
        let watched = self.session.watch(axis, until, |_, _| Action::GoOn);
        let over = until.is_some() && matches!(watched, Ok(Sight { braking: true, .. }));
        let Ended { end, adrift, .. } = self.session.conclude(axis, watched);
        match (end, adrift) {
            (_, Some(Adrift::Lost(trouble))) => Err(trouble.into()),
            (_, Some(Adrift::Unconfirmed)) => Err(LinkError::Silent.into()),
            (RestPlace::At(at), _) if over || target == Some(at) => Ok(Outcome::Reached { at }),
            (RestPlace::At(at), _) => Ok(Outcome::Stopped { at, reason: None }),
            (RestPlace::Uncertain, _) => Ok(Outcome::Uncertain),
        }
    }
}
