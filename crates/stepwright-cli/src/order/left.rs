//! The time that is left of a travel, also after changes.

use stepwright_oracle::IdealTrapezoid;
use stepwright_protocol::{Command, Order, Ramp, Travel};

/// The target and the limits of a travel, in steps and seconds.
pub struct Aim {
    /// The start of the travel, from which targets count.
    from: f64,
    /// The target; `None` if endless.
    target: Option<f64>,
    start: f64,
    top: f64,
    accel: f64,
    decel: f64,
}

impl Aim {
    /// The aim of an order that begins at `from`.
    pub fn of(order: &Order, from: i64) -> Aim {
        let from = from as f64;
        let (start, top) = (steps(order.start.millisteps()), steps(order.top.millisteps()));
        let slope = |ramp| match ramp {
            Ramp::Accel(accel) => accel.millisteps() as f64 / 1000.0,
            Ramp::Steps(n) => (top * top - start * start).max(0.0) / (2.0 * f64::from(n.get())),
        };
        let target = match order.travel {
            Travel::By(distance) => Some(from + f64::from(distance.get())),
            Travel::Endless(_) => None,
        };
        Aim { from, target, start, top, accel: slope(order.up), decel: slope(order.down) }
    }

    /// Applies a line that changes the travel.
    pub fn change(&mut self, line: Command) {
        match line {
            Command::Top(top) => self.top = f64::from(top.get()),
            Command::Milli(top) => self.top = steps(top.get()),
            Command::Accel(accel) => self.accel = f64::from(accel.get()),
            Command::Decel(decel) => self.decel = f64::from(decel.get()),
            Command::Retarget(by) => self.target = Some(self.from + f64::from(by.get())),
            _ => {}
        }
    }

    /// The steps of the whole travel; `None` if endless.
    pub fn whole(&self) -> Option<f64> {
        self.target.map(|target| (target - self.from).abs())
    }

    /// Seconds to the target from a position and a speed, positive forward; `None` if there is no
    /// target.
    pub fn seconds(&self, at: f64, speed: f64) -> Option<f64> {
        let left = self.target? - at;
        // Mirrored, so that the target is ahead.
        let (left, speed) = if left < 0.0 { (-left, -speed) } else { (left, speed) };
        if speed < 0.0 {
            // It moves away from the target: it brakes to rest, and travels back.
            let speed = -speed;
            let beyond = self.braking(speed);
            return Some(self.slow(speed) + self.ahead(left + beyond, self.start));
        }
        let needed = self.braking(speed);
        if needed > left {
            return Some(self.slow(speed) + self.ahead(needed - left, self.start));
        }
        Some(self.ahead(left, speed.max(self.start.min(self.top))))
    }

    /// Steps from this speed to rest.
    fn braking(&self, speed: f64) -> f64 {
        (speed * speed - self.start * self.start).max(0.0) / (2.0 * self.decel.max(1e-3))
    }

    /// Seconds from this speed to rest.
    fn slow(&self, speed: f64) -> f64 {
        (speed - self.start).max(0.0) / self.decel.max(1e-3)
    }

    /// Seconds for these steps ahead, from a speed down to the start speed.
    fn ahead(&self, steps: f64, speed: f64) -> f64 {
        let (up, down) = (self.accel.max(1e-3), self.decel.max(1e-3));
        let end = self.start.min(self.top);
        if speed > self.top {
            // It brakes to the new top speed first.
            let way = (speed * speed - self.top * self.top) / (2.0 * down);
            let time = (speed - self.top) / down;
            return time + self.ahead((steps - way).max(0.0), self.top);
        }
        let ideal =
            IdealTrapezoid::new((speed, end), self.top.max(1e-3), (2.0 * up, 2.0 * down), steps);
        ideal.total()
    }
}

fn steps(millisteps: u32) -> f64 {
    f64::from(millisteps) / 1000.0
}

#[cfg(test)]
mod tests {
    use super::Aim;
    use stepwright::{Accel, Speed};
    use stepwright_host::course::Course;
    use stepwright_protocol::{Command, Distance, Order, Ramp, TopSpeed, Travel};

    fn order(steps: i32) -> Order {
        Order {
            start: Speed::ZERO,
            top: Speed::from_steps(1000).unwrap(),
            up: Ramp::Accel(Accel::from_steps(2000).unwrap()),
            down: Ramp::Accel(Accel::from_steps(1000).unwrap()),
            jerk: None,
            travel: Travel::By(Distance::new(steps)),
        }
    }

    #[test]
    fn from_the_beginning_it_takes_what_the_law_says() {
        for steps in [100, 749, 751, 4000, -4000] {
            let order = order(steps);
            let law = Course::of(&order.into()).unwrap().duration();
            let seconds = Aim::of(&order, 70).seconds(70.0, 0.0).unwrap();
            // The law has whole pulses; the last one comes a moment before the rest.
            assert!((seconds - law).abs() < 0.02, "{steps}: {seconds} {law}");
        }
    }

    #[test]
    fn on_the_way_and_after_changes() {
        let mut aim = Aim::of(&order(4000), 0);
        let close = |is: Option<f64>, right: f64| {
            assert!(is.is_some_and(|is| (is - right).abs() < 1e-9), "{is:?} {right}");
        };
        // 500 steps down take a second at 1000 steps/s².
        close(aim.seconds(1000.0, 1000.0), 2.5 + 1.0);
        close(aim.seconds(3500.0, 1000.0), 1.0);
        aim.change(Command::Top(TopSpeed::new(500).unwrap()));
        // Down to 500 in 0.5 s and 375 steps, 2500 level, 125 down in 0.5 s.
        close(aim.seconds(1000.0, 1000.0), 0.5 + 5.0 + 0.5);
        // A target behind: 1 s and 500 steps to rest, then 1500 back: 62.5 up, 1312.5 level, 125
        // down.
        aim.change(Command::Retarget(Distance::new(0)));
        close(aim.seconds(1000.0, 1000.0), 1.0 + 0.25 + 1312.5 / 500.0 + 0.5);
        // A target too near to stop at: 500 steps to rest, then 400 back.
        aim.change(Command::Retarget(Distance::new(1100)));
        close(aim.seconds(1000.0, 1000.0), 1.0 + 0.25 + 212.5 / 500.0 + 0.5);
        assert_eq!(aim.whole(), Some(1100.0));
    }

    #[test]
    fn without_a_target_there_is_no_end() {
        let endless = Travel::Endless(stepwright_protocol::Direction::Forward);
        let mut aim = Aim::of(&Order { travel: endless, ..order(1) }, 5);
        assert_eq!(aim.seconds(5.0, 100.0), None);
        aim.change(Command::Retarget(Distance::new(1000)));
        assert!(aim.seconds(5.0, 100.0).is_some());
    }
}
