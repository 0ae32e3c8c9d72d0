//! A travel from rest, set up a piece a call: an order of several axes keeps the main loop
//! for no longer than a piece of planning does.

use super::{Clock, Planner, twice};
use crate::clamp;
use crate::num::{Num, hand, whole};
use crate::order::{Order, Travel};
use crate::profile::{Ramp, Unfit};
use crate::units::{Accel, Speed};

/// The next piece of laying a travel out. Until its piece an order's number is where
/// nothing else is yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Layout {
    /// Start and top speed, which are in `risen` and `level`.
    Speeds,
    /// The slope of the rise: of an acceleration, which is in `a2`, or of this many steps, in
    /// `rise`.
    Up,
    /// The slope of the fall, likewise in `d2` and `fall`.
    Down,
    /// The first interval.
    First,
    /// The last one, if that is another.
    Last,
    /// Whether all intervals are short enough, and the ramps steep enough.
    Limits,
    /// The speed to try first.
    Rise,
    /// The length of a fall from the speed that is tried.
    Fall,
    /// What a higher speed makes of it. Of straight ramps the speed that fits, and likewise below.
    Spare,
    /// The length of the rise.
    Meet,
    /// What a higher speed makes of it.
    Join,
    /// Whether rise and fall fit.
    Try,
    /// It is set up: its highest speed,
    Load,
    /// and how many runs it asks for.
    Runs,
    /// Whether the board can step it,
    Check,
    /// and plan for it.
    Plan,
    /// It can: how long it waits with the others.
    Wait,
    /// Its beginning is queued.
    Begin,
    /// There is no order.
    Nothing,
}

impl Planner {
    /// Takes a travel from rest to rest, or on and on, which [`lay`](Planner::lay) then lays
    /// out. The first pulse, at time 0, is not part of the runs.
    ///
    /// In place: a chip has better things to do than to hand 100 bytes on.
    ///
    /// # Errors
    /// [`Unfit`] for what is no motion, or not of this planner.
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

    /// Does a piece of setting up the travel that was accepted, of this many pulses, and tells
    /// the next.
    ///
    /// # Errors
    /// [`Unfit`] if the timer can't hold it.
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

    /// The slope of a ramp. One in steps is at least that of [`Accel::MIN`]; 0 where it has
    /// nothing to gain: there is none.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn set_slope(&mut self, up: bool) {
        let (slope, steps) = if up { (&mut self.a2, self.rise) } else { (&mut self.d2, self.fall) };
        if steps == 0 {
            return twice(slope);
        }
        hand(&self.v_end).square().to(slope);
        hand(&self.top).square().minus(slope).to(slope);
        // To the nearest 10⁻⁶, as the law holds it.
        let nearest = whole(steps).under(slope).also(slope).rounded_whole();
        if hand(slope).below(32) {
            let least = 2000 * Accel::MIN.millisteps() as u32;
            whole(if nearest == 0 { 0 } else { nearest.max(least) }).to(slope);
        }
    }

    /// All at once.
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

/// The length of a travel's first run, as a power of two, that is tried first. The faster it
/// starts, the fewer steps a short run of it lasts for: what is queued at the start has to last
/// while more is planned. Of straight ramps up to 100,000 steps/s² at 16 MHz these are not too long.
fn first_size(start: u32) -> u8 {
    // 2^21 thousandths are 2097 steps/s.
    if start >> 24 == 0 { (start >> 21) as u8 } else { 6 }
}

/// Sets an acceleration, or the number of steps of a ramp.
fn set_ramp(accel: &mut Num, steps: &mut u32, ramp: &Ramp) {
    *steps = match ramp {
        Ramp::Steps(steps) => (*steps).into(),
        Ramp::Accel(a) => {
            *accel = Num::from_wide(a.millisteps());
            0
        }
    };
}
