//! Checks of speed and acceleration by the intervals between steps.

use super::{Braked, Goal, Measure, Track};
use crate::fault::{Fault, Rule};

impl Track {
    /// Checks that the last interval of a leg was slow enough to end it.
    pub(super) fn stopped(&self, now: u64, measure: &Measure) -> Result<(), Fault> {
        let Some(interval) = self.interval else { return Ok(()) };
        // The board travels from rest to a target that comes after the end was planned. The last interval
        // may be that rest, before a leg of one step.
        let rest = self.rests * measure.hz;
        if self.retargeted && interval as f64 + measure.jitter >= rest * 0.99 {
            return Ok(());
        }
        if !self.may_end(interval, measure) {
            let (axis, limits) = (self.axis + 1, self.by);
            let v = measure.hz / (interval as f64 + measure.jitter + measure.fit);
            measure.rules.broken(Rule::Fall, now, || {
                format!("axis {axis} stops dead at {v:.1} steps/s; {limits:?}")
            })?;
        }
        Ok(())
    }

    /// Whether an interval is slow enough for the last of a leg.
    pub(super) fn may_end(&self, interval: u64, measure: &Measure) -> bool {
        let wide = interval as f64 + measure.jitter + measure.fit;
        let slowest = self.by.start + self.by.down * wide / 2.0 / measure.hz;
        measure.hz / wide <= slowest * 1.001
    }

    /// Checks that an axis neither turns nor speeds up after a soft stop. A travel on its way back that
    /// rests when the stop comes still has one step to make.
    pub(super) fn slows(
        &mut self,
        now: u64,
        forward: bool,
        measure: &Measure,
    ) -> Result<(), Fault> {
        let (Goal::Stop(_), Some(Braked { told, planned, falls }), Some(rise)) =
            (self.goal, self.braked, self.rise)
        else {
            return Ok(());
        };
        let axis = self.axis + 1;
        if !self.fresh && rise > told && self.forward == Some(!forward) {
            measure.rules.broken(Rule::Order, now, || {
                format!("axis {axis} turns, which was told to stop at tick {told}")
            })?;
        }
        let Some(last) = self.interval.filter(|_| !planned.has(self.rise, now)) else {
            return Ok(());
        };
        // Each of the three edges is rounded to a tick, or off its time by the jitter. The speed at the end
        // of what was planned may be above the mean speed of its last interval, and continues.
        let mut least = last as f64;
        if !falls {
            let v = measure.hz / least;
            least = measure.hz / self.by.end_speed(v);
        }
        self.braked = Some(Braked { told, planned, falls: true });
        if ((now - rise) as f64) < least - 2.0 * measure.jitter {
            let ticks = now - rise;
            measure.rules.broken(Rule::Stop, now, || {
                format!("axis {axis} speeds up, which was told to stop at tick {told}: interval {ticks} after {last}")
            })?;
        }
        Ok(())
    }

    /// Checks speed and acceleration at a step.
    pub(super) fn pace(&mut self, now: u64, forward: bool, measure: &Measure) -> Result<(), Fault> {
        let Some(rise) = self.rise else { return Ok(()) };
        let ticks = now - rise;
        let turn = self.forward.is_some_and(|was| was != forward);
        if self.fresh || turn {
            let stopped = if self.fresh { Ok(()) } else { self.stopped(now, measure) };
            (self.interval, self.ahead) = (None, (0.0, 0.0));
            self.end_falls(now);
            return stopped.and(self.dwell(now, ticks, measure));
        }
        let before = self.interval.replace(ticks);
        let Measure { hz, jitter, rules, .. } = *measure;
        let jitter = jitter + measure.fit;
        if before.is_some_and(|last| ticks as f64 + 2.0 * jitter < last as f64) {
            self.end_falls(now);
        }
        let limits = self.in_force(now);
        // Each of two intervals counts by its own limits: a change may be between them.
        let earlier = std::mem::replace(&mut self.by, limits);
        let axis = self.axis + 1;
        // Each step may be off its time, and the next steps make up for it: any number of steps is at most
        // that far ahead of the top speed. A single interval may be shorter by as much, which at 100,000
        // steps/s is several per cent. Steps are within 1 µs of their law, or within a tick if that is longer.
        // Another axis may have delayed a step, and may rest by now.
        let (ahead, most) = self.ahead;
        let ahead = (ahead + hz / limits.top - ticks as f64).max(0.0);
        self.ahead = (ahead, if ahead > 0.0 { jitter.max(most) } else { jitter });
        if ahead > self.ahead.1 {
            self.ahead = (0.0, jitter);
            rules.broken(Rule::Top, now, || {
                let top = limits.top;
                format!("axis {axis} is {ahead:.1} ticks ahead of a top speed of {top} steps/s, interval {ticks}")
            })?;
        }
        let (wide, narrow) = (ticks as f64 + jitter, (ticks as f64 - jitter).max(0.5));
        let v = hz / wide;
        // From rest or from the interval before.
        let mut most = limits.start + limits.up * wide / 2.0 / hz;
        if let Some(last) = before {
            let last = last as f64;
            let both = |of: f64, own: f64| (of * (last + jitter) + own * wide) / 2.0 / hz;
            most = most.max(hz / (last - jitter).max(0.5) + both(earlier.up, limits.up));
            let fast = hz / (last + jitter);
            let down = earlier.down.max(limits.down);
            let ends = (limits.start + down * (last + jitter) / 2.0 / hz) * 1.001;
            if hz / narrow < (fast - both(earlier.down, limits.down)) * 0.999
                && fast > ends
                && last < self.rests * hz
            {
                rules.broken(Rule::Fall, now, || {
                    format!("axis {axis} falls from {fast:.1} to {v:.1} steps/s; {limits:?}")
                })?;
            }
        }
        if v > most * 1.001 {
            let last = before;
            rules.broken(Rule::Rise, now, || {
                format!("axis {axis} rises to {v:.1} steps/s, at most {most:.1}, from an interval of {last:?}; {limits:?}")
            })?;
        }
        Ok(())
    }

    /// Checks the rest before the first step of a leg.
    fn dwell(&self, now: u64, ticks: u64, measure: &Measure) -> Result<(), Fault> {
        let least = self.rests.min(self.rested) * measure.hz;
        if (ticks as f64) + measure.jitter < least * 0.99 {
            let axis = self.axis + 1;
            measure.rules.broken(Rule::Dwell, now, || {
                format!("axis {axis} starts {ticks} ticks after its last step, not {least:.0}")
            })?;
        }
        Ok(())
    }
}
