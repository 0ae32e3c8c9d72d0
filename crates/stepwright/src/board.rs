//! The description of a board, and whether the board can carry out an order.

use crate::clamp;
use crate::drive::Axes;
use crate::engine::Timing;
use crate::format;
use crate::order::Refusal;
use crate::planner::{Clock, Load};
use crate::profile::Fit;
use crate::units::{Rate, Speed, Ticks};

/// Ticks that a step costs: 16 bits with the feature `compact`.
pub type StepTicks = format::Step;

/// What a step costs, in ticks, while 1, 2 … N axes move.
///
/// The costs of the steps of all moving axes add up: two axes at v steps/s take 2v times the cost
/// of a step while two move.
///
/// Measured: the highest rates without a late step. If STEP must stay high for longer than the code
/// takes from edge to edge, holding it takes time from the other axes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Cost<const N: usize> {
    /// With pulses of at most [`pulse`](Cost::pulse) ticks.
    pub ticks: [StepTicks; N],
    /// The longest pulse for which `ticks` is right.
    pub pulse: StepTicks,
    /// With longer pulses, up to the longest that can be set.
    pub longer: [StepTicks; N],
    /// The shortest interval of an axis at which it is not late after waiting for one step of each
    /// other axis. Where a pulse is held, the pulses of the others are added.
    pub shortest: [StepTicks; N],
}

impl<const N: usize> Cost<N> {
    /// The cost of steps whose pulses are held by hardware: the same for all pulses.
    pub const fn any_pulse(ticks: [StepTicks; N]) -> Cost<N> {
        Cost { ticks, pulse: StepTicks::MAX, longer: ticks, shortest: [0; N] }
    }

    /// The cost of steps that take no time from other axes: each axis has hardware of its own,
    /// which makes at most one step every `ticks` (65,535 at most with the feature `compact`).
    ///
    /// ```
    /// use stepwright::{Board, Cost, Rate, Speed};
    /// let rate = Rate::of::<125_000_000>();
    /// let board = Board::<2> { cost: Cost::independent(500), ..Board::unmeasured(rate) };
    /// assert_eq!(board.step_cost(2), 0);
    /// ```
    pub const fn independent(ticks: Ticks) -> Cost<N> {
        let shortest = [format::step_ticks(ticks); N];
        Cost { ticks: [0; N], pulse: StepTicks::MAX, longer: [0; N], shortest }
    }

    /// The cost with all its ticks converted by `to`.
    pub fn map(&self, mut to: impl FnMut(StepTicks) -> StepTicks) -> Cost<N> {
        let Cost { ticks, pulse, longer, shortest } = *self;
        let (ticks, pulse) = (ticks.map(&mut to), to(pulse));
        Cost { ticks, pulse, longer: longer.map(&mut to), shortest: shortest.map(to) }
    }
}

/// A board: its timer, its drivers' times, and the cost of a step.
///
/// Without a fit, `Board<N, ()>` is the part that a planner keeps after deriving its numbers from
/// the fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Board<const N: usize, F = Fit> {
    /// The step timer's rate.
    pub rate: Rate,
    /// The drivers' times.
    pub timing: Timing,
    /// The cost of a step: an order is refused if the steps of all moving axes would take more than
    /// all the time.
    pub cost: Cost<N>,
    /// The runs that can be planned in a second while axes move. An order is refused if the ramps
    /// of all moving axes would need more: all of this for up to two axes, 15/16 of it for three
    /// and more, and 7/8 for any one axis.
    ///
    /// One axis with ramps of a steps/s² needs (612·a)^0.4 runs a second, or its top speed in
    /// steps/s if that is less, and four times as many with a jerk limit. Beside other axes a jerk
    /// of j steps/s³ needs 2.5·(612·√(2j))^0.5, or four times its top speed if that is less,
    /// however gentle the ramps are. Ramps of fewer than four steps each, with a cruise of less
    /// than 15 ms between them, need half the top speed; all of it if they are changed during the
    /// move. Beside a ramp of another axis, an axis needs a run for each 65.5 steps/s of its top
    /// speed, if that is more.
    ///
    /// Measured; `u16::MAX` where nothing waits for planning, as in a simulation.
    pub runs: u16,
    /// How closely runs follow the law.
    pub fit: F,
    /// How far ahead to plan, in ticks.
    pub horizon: Ticks,
    /// Ticks from the start of a travel to its first pulse, in addition to hold and set-up time.
    pub lead: Ticks,
}

impl<const N: usize> Board<N> {
    /// A board that has not been measured, with a step timer of this rate.
    ///
    /// A step is assumed to cost 100 µs: 10,000 steps/s of all axes together, and at most 5,000 of
    /// an axis beside another one, 3,333 beside two and so on.
    /// 2,900 runs can be planned in a second, which a chip of 16 MHz and more can do. Pulses last 2
    /// µs, DIR is set 1 µs before a step and held 1 µs after it, and steps are planned 16 ms ahead.
    /// All fields can be changed.
    ///
    /// ```
    /// use stepwright::{Board, Rate, Speed};
    /// let board = Board::<2>::unmeasured(Rate::MHZ);
    /// assert_eq!(board.max_speed(), Speed::from_steps(10_000)?);
    /// # Ok::<(), stepwright::OutOfRange>(())
    /// ```
    pub const fn unmeasured(rate: Rate) -> Board<N> {
        let (step, pulse, side) = (rate.micros(100), rate.nanos(2_000), rate.nanos(1_000));
        let each = format::step_ticks(step);
        // An axis may wait for a step of each other one.
        let (mut cost, mut all, mut axes) = (Cost::any_pulse([each; N]), each, 0);
        while axes < N {
            cost.shortest[axes] = all;
            all = all.saturating_add(each);
            axes += 1;
        }
        Board {
            rate,
            timing: Timing { pulse, setup: side, hold: side, min_interval: step },
            cost,
            runs: 2_900,
            fit: Fit::board(rate),
            horizon: rate.micros(16_000),
            lead: rate.micros(250),
        }
    }

    /// This board without its fit.
    pub(crate) const fn kept(self) -> Board<N, ()> {
        let Board { rate, timing, cost, runs, fit: _, horizon, lead } = self;
        Board { rate, timing, cost, runs, fit: (), horizon, lead }
    }
}

impl<const N: usize, F> Board<N, F> {
    /// The highest speed of an axis that moves alone.
    pub fn max_speed(&self) -> Speed {
        self.max_alone(&Clock::new(self.rate, &Fit::EXACT))
    }

    /// [`max_speed`](Board::max_speed) with a clock that exists already.
    pub(crate) fn max_alone(&self, clock: &Clock) -> Speed {
        self.max_beside(clock, 0, 1)
    }

    /// Ticks that a step costs while this many axes move, with the present pulse length.
    pub fn step_cost(&self, moving: usize) -> Ticks {
        let ticks = if self.holds() { &self.cost.longer } else { &self.cost.ticks };
        ticks.get(moving.saturating_sub(1)).map_or(Ticks::MAX, |&ticks| format::wide(ticks))
    }

    /// Whether the interrupt holds pulses to lengthen them.
    fn holds(&self) -> bool {
        self.timing.pulse > format::wide(self.cost.pulse)
    }

    /// The shortest interval of an axis while this many axes move.
    fn shortest(&self, moving: usize) -> Ticks {
        let others = moving.saturating_sub(1);
        let mut shortest = self.cost.shortest.get(others).map_or(0, |&ticks| format::wide(ticks));
        if self.holds() {
            // The pulse of each other axis once, in half of the interval.
            let held = self.timing.pulse.wrapping_mul(2).wrapping_mul(others as Ticks);
            shortest = clamp::sum(shortest, held);
        }
        shortest.max(self.timing.min_interval)
    }

    /// Sets the drivers' times. The minimum interval becomes a pulse and a pause of the same
    /// length, or the cost of a step if that is longer.
    pub fn set_drivers(&mut self, pulse: Ticks, setup: Ticks, hold: Ticks) {
        self.timing = Timing { pulse, setup, hold, min_interval: 0 };
        self.timing.min_interval = self.step_cost(1).max(clamp::sum(pulse, pulse));
    }

    /// The highest speed of an axis beside other axes, which make `others` thousandths of a step
    /// per second together; `moving` axes move in all.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    fn max_beside(&self, clock: &Clock, others: u32, moving: u8) -> Speed {
        // (With a step cost of 0 the limit is the largest number.)
        let shared = clock.in_a_second(self.step_cost(moving.into()));
        let alone = clock.in_a_second(self.shortest(moving.into()));
        Speed::from_millisteps(clamp::less(shared, others).min(alone)).unwrap_or(Speed::MAX)
    }

    /// Checks that the board can step these axes beside all that will move then, by the fastest of
    /// them. The top speeds add up to at most 2³² thousandths of a step/s.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn check_speed(
        &self,
        clock: &Clock,
        loads: &[Load; N],
        mut moving: Axes,
        mut axes: Axes,
    ) -> Result<(), Refusal> {
        let (mut all, mut own, mut count) = (0u32, 0u32, 0u8);
        for load in loads {
            if moving & 1 != 0 && load.peak != 0 {
                all = all.saturating_add(load.peak);
                count = count.wrapping_add(1);
            }
            if axes & 1 != 0 {
                own = own.max(load.peak);
            }
            moving >>= 1;
            axes >>= 1;
        }
        let max = self.max_beside(clock, clamp::less(all, own), count);
        if own > max.millisteps() { Err(Refusal::TooFast { max }) } else { Ok(()) }
    }

    /// Checks that the board can plan for all that will move then, if anything ramps. A change
    /// during a move takes the time of a few runs: for one axis an eighth is kept back for it; with
    /// two, the queues last longer. Three axes that are stopped at once while they accelerate need
    /// more: a sixteenth is kept back.
    #[cfg_attr(not(target_pointer_width = "64"), inline(never))]
    pub(crate) fn check_ramps(
        &self,
        loads: &[Load; N],
        mut moving: Axes,
        axis: u8,
    ) -> Result<(), Refusal> {
        if self.runs == u16::MAX {
            return Ok(());
        }
        // An axis that moves alone ramps only while it is slow.
        let alone = moving.is_power_of_two();
        let (mut left, mut own, mut ramps, mut count) = (self.runs, 0u16, 0u16, 0u8);
        for (other, load) in (0u8..).zip(loads) {
            if moving & 1 != 0 {
                count = count.wrapping_add(1);
                if count == 3 {
                    left = left.saturating_sub(self.runs >> 4);
                }
                ramps |= load.runs;
                let takes = if alone { load.runs } else { load.takes() };
                if other == axis {
                    own = takes;
                } else {
                    left = left.saturating_sub(takes);
                }
            }
            moving >>= 1;
        }
        let runs = left.min(self.runs.wrapping_sub(self.runs >> 3));
        if ramps != 0 && own > runs { Err(Refusal::TooSteep { runs }) } else { Ok(()) }
    }
}
