//! The display of a moving motor, its keys, and Ctrl-C.

use stepwright_host::Conversation;
use stepwright_host::motion::{Action, Sight};
use stepwright_protocol::AxisId;

use super::keys::{Act, KeyControl};
use super::motion::Motion;
use super::progress::Progress;
use crate::interrupt;

/// Shows a motor, and returns the user's wishes.
pub struct Screen {
    axis: AxisId,
    hand: KeyControl,
    progress: Progress,
    /// Once it brakes: whether because of a signal, rather than at the end of its time.
    cut: Option<bool>,
}

impl Screen {
    /// The screen of a motor that has begun this motion at `from`, on a connected board.
    pub fn of(talk: &Conversation, motion: &Motion, from: i64) -> Screen {
        let hand = KeyControl::on(talk, &motion.order);
        let progress = Progress::new(motion, from, hand.listens());
        Screen { axis: motion.axis(), hand, progress, cut: None }
    }

    /// Shows what was seen of the motor. Returns the user's action.
    pub fn see(&mut self, talk: &mut Conversation, sight: &Sight) -> Action {
        let (mut told, mut change) = (None, None);
        if let Some((line, taken)) = sight.said {
            told = Some(self.hand.said(line, taken));
            change = taken.is_ok().then_some(line);
        } else if let Some(made) = talk.next_change().filter(|made| made.axes.contains(self.axis)) {
            change = Some(made.command);
            told = Some(format!("another terminal: {made}"));
        }
        if sight.braking {
            self.cut.get_or_insert_with(interrupt::asked);
        }
        self.progress.see(sight, told.as_deref(), change);
        if interrupt::asked() {
            return Action::Stop;
        }
        match self.hand.act() {
            Some(Act::Stop) => Action::Stop,
            Some(Act::Say(line)) => Action::Say(line),
            Some(Act::Help) => {
                self.progress.note(super::keys::HELP);
                Action::GoOn
            }
            None => Action::GoOn,
        }
    }

    /// Clears the display. Returns whether the motor was braked because of a signal, if it was
    /// braked.
    pub fn end(self) -> Option<bool> {
        drop(self.hand);
        self.progress.end();
        self.cut
    }
}
