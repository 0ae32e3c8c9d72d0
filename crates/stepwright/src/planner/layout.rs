//! Sets up a travel from rest one piece per call: an order of several axes keeps the main loop busy
//! no longer than a piece of planning does.

use super::{Clock, Planner, twice};
use crate::clamp;
use crate::num::{Num, hand, whole};
use crate::order::{Order, Travel};
use crate::profile::{Ramp, Unfit};
use crate::units::{Accel, Speed};

/// The next piece of setting up a travel. Until its piece is done, a value of the order is kept in
/// a field that is not used yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Layout {
    /// Start and top speed, which are in `risen` and `level`.
    Speeds,
    /// The slope of the rise: from an acceleration in `a2`, or from a number of steps in `rise`.
    Up,
    /// The slope of the fall: from `d2` or `fall`.
    Down,
    /// The first interval.
    First,
    /// The last interval, if it differs.
    Last,
    /// Check that all intervals are short enough, and the ramps steep enough.
    Limits,
    /// The first speed to try.
    Rise,
    /// The length of a fall from the speed that is tried.
    Fall,
    /// The growth of the fall with the speed. For straight ramps the speed that fits; likewise in
    /// `Join`.
    Spare,
    /// The length of the rise.
    Meet,
    /// The growth of the rise with the speed.
    Join,
    /// Check whether rise and fall fit.
    Try,
    /// The travel is set up: its highest speed.
    Load,
    /// The number of runs that it needs.
    Runs,
    /// Check whether the board can step it.
    Check,
    /// Check whether the board can plan for it.
    Plan,
    /// Both checks passed: how long it waits with the others.
    Wait,
    /// Queue its beginning.
    Begin,
    /// There is no order.
    Nothing,
}

impl Planner {
    /// Takes a travel from rest to rest, or an endless one, which [`lay`](Planner::lay) then sets
    /// up. The first pulse, at time 0, is not part of the runs.
    ///
    /// In place, because copying 100 bytes is expensive on a chip.
    ///
    /// # Errors
    /// [`Unfit`] if the order is no motion, or not one that this planner supports.
    pub(crate) fn accept(&mut self, order: &Order) -> Result<(), Unfit> {
        if matches!(order.up, Ramp::Steps(0)) || matches!(order.down, Ramp::Steps(0)) {
            return Err(Unfit::NoRamp);
        }
        if order.top == Speed::ZERO {
            return Err(Unfit::Standstill);
        }
        if !cfg!(feature = "jerk") && order.jerk.is_some() {
            return Err(Unfit::Jerk);
        }
        self.size = first_size(order.start.millisteps());
        (self.risen, self.level) = (order.start.millisteps(), order.top.millisteps());
        set_ramp(&mut self.a2, &mut self.rise, &order.up);
        set_ramp(&mut self.d2, &mut self.fall, &order.down);
        self.endless = matches!(order.travel, Travel::Endless(_));
        self.limit_jerk(order.jerk);
        Ok(())
    }

    /// Does a piece of setting up the accepted travel, of this many pulses. Returns the next piece.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't represent it.
    pub(crate) fn lay(
        &mut self,
        clock: &Clock,
        piece: Layout,
        pulses: u32,
    ) -> Result<Layout, Unfit> {
        let steps = clamp::less(pulses, 1);
        Ok(match piece {
            Layout::Speeds => {
                whole(self.level).to(&mut self.top);
                let start = whole(self.risen.min(self.level));
                start.to(&mut self.v_end);
                whole(0).to(&mut self.v);
                Layout::Up
            }
            Layout::Up => {
                self.set_slope(true);
                Layout::Down
            }
            Layout::Down => {
                self.set_slope(false);
                Layout::First
            }
            Layout::First | Layout::Last | Layout::Limits => self.check_piece(clock, piece)?,
            Layout::Rise => {
                self.begin_again();
                self.divide_piece(piece, steps)
            }
            Layout::Fall | Layout::Spare | Layout::Meet | Layout::Join | Layout::Try => {
                self.divide_piece(piece, steps)
            }
            Layout::Load
            | Layout::Runs
            | Layout::Check
            | Layout::Plan
            | Layout::Wait
            | Layout::Begin
            | Layout::Nothing => piece,
        })
    }

    /// Sets the slope of a ramp. The slope of a ramp in steps is at least that of [`Accel::MIN`];
    /// it is 0 if the ramp gains nothing: there is no ramp.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn set_slope(&mut self, up: bool) {
        let (slope, steps) = if up { (&mut self.a2, self.rise) } else { (&mut self.d2, self.fall) };
        if steps == 0 {
            return twice(slope);
        }
        hand(&self.v_end).square().to(slope);
        hand(&self.top).square().minus(slope).to(slope);
        // Rounded to the nearest 10⁻⁶, as in the law.
        let nearest = whole(steps).under(slope).also(slope).rounded_whole();
        if hand(slope).below(32) {
            let least = 2000 * Accel::MIN.millisteps() as u32;
            whole(if nearest == 0 { 0 } else { nearest.max(least) }).to(slope);
        }
    }

    /// Sets up a whole travel at once.
    #[cfg(test)]
    pub(crate) fn lay_out(&mut self, clock: &Clock, order: &Order) -> Result<(), Unfit> {
        self.accept(order)?;
        let pulses = match order.travel {
            Travel::By(steps) => steps.unsigned_abs(),
            Travel::Endless(_) => 0,
        };
        let mut piece = Layout::Speeds;
        while piece != Layout::Check {
            piece = self.lay(clock, piece, pulses)?;
        }
        Ok(())
    }
}

/// The length of a travel's first run that is tried first, as a power of two. The faster the travel
/// starts, the shorter a run of few steps lasts: the steps queued at the start have to last while
/// more are planned. For straight ramps up to 100,000 steps/s² at 16 MHz these runs are not too
/// long.
fn first_size(start: u32) -> u8 {
    // 2^21 thousandths are 2097 steps/s.
    if start >> 24 == 0 { (start >> 21) as u8 } else { 6 }
}

/// Sets an acceleration, or the number of steps of a ramp.
fn set_ramp(accel: &mut Num, steps: &mut u32, ramp: &Ramp) {
    *steps = match ramp {
        Ramp::Steps(steps) => (*steps).into(),
        Ramp::Accel(a) => {
            accel.set_wide(a.millisteps());
            0
        }
    };
}
