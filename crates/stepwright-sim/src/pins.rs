//! Simulated pins: every change goes to the recorder.

use core::cell::Cell;

use stepwright::drive::{Axes, Coils, Drive, Port, Sequence};

use crate::board::AXES;
use crate::clock::{LentNow, Present};
use crate::edge::{Edge, Pin, Recorder};

/// The lines to the windings of a motor.
#[derive(Debug, Default)]
pub(crate) struct Lines(pub(crate) u8);

impl Port for Lines {
    fn set(&mut self, mask: u8) {
        self.0 |= mask;
    }
    fn clear(&mut self, mask: u8) {
        self.0 &= !mask;
    }
}

/// The pins of a board's axes: STEP and DIR, or the lines to the windings.
pub(crate) struct Pins<'q, R> {
    now: LentNow<'q>,
    /// The directions in which the axes are told to turn.
    forward: [bool; AXES],
    /// The reversed axes.
    reverse: &'q Cell<Axes>,
    /// The levels of DIR; for a motor on coils, whether it goes forward through its table.
    levels: [Option<bool>; AXES],
    coils: [Option<Coils<Lines>>; AXES],
    pub(crate) recorder: R,
}

impl<'q, R: Recorder> Pins<'q, R> {
    /// The pins of motors at the first row of their table, with current.
    pub(crate) fn new(
        now: LentNow<'q>,
        reverse: &'q Cell<Axes>,
        coils: &[Option<Sequence>; AXES],
        recorder: R,
    ) -> Pins<'q, R> {
        let on = |sequence: Sequence| {
            let mut coils = Coils::new(Lines::default(), sequence, u8::MAX);
            coils.on();
            coils
        };
        let coils = coils.map(|sequence| sequence.map(on));
        Pins { now, forward: [true; AXES], reverse, levels: [None; AXES], coils, recorder }
    }

    fn steps(&mut self, axes: Axes, level: bool) {
        let time = self.now.get();
        for (axis, coils) in (0..).zip(&mut self.coils).filter(|(axis, _)| axes >> axis & 1 != 0) {
            match coils {
                None => self.recorder.edge(Edge { time, axis, pin: Pin::Step, level }),
                // Coils have no falling edge of a step.
                Some(coils) if level => {
                    let before = coils.port().0;
                    coils.step();
                    let now = coils.port().0;
                    for line in (0..8).filter(|line| (before ^ now) >> line & 1 != 0) {
                        let level = now >> line & 1 != 0;
                        self.recorder.edge(Edge { time, axis, pin: Pin::Coil(line), level });
                    }
                }
                Some(_) => {}
            }
        }
    }

    /// Sets DIR of all axes to their present directions.
    pub(crate) fn face(&mut self) {
        for (axis, (level, coils)) in self.levels.iter_mut().zip(&mut self.coils).enumerate() {
            let forward = self.forward.get(axis).copied().unwrap_or(true);
            let high = forward != (self.reverse.get() >> axis & 1 != 0);
            if *level == Some(high) {
                continue;
            }
            *level = Some(high);
            match coils {
                Some(coils) => coils.set_forward(high),
                None => {
                    let (time, axis) = (self.now.get(), axis as u8);
                    self.recorder.edge(Edge { time, axis, pin: Pin::Direction, level: high });
                }
            }
        }
    }
}

impl<R: Recorder> Drive for Pins<'_, R> {
    fn begin(&mut self, axes: Axes) {
        self.steps(axes, true);
    }

    fn end(&mut self, axes: Axes) {
        self.steps(axes, false);
    }

    fn direction(&mut self, axis: u8, forward: bool) {
        if let Some(known) = self.forward.get_mut(usize::from(axis)) {
            *known = forward;
            self.face();
        }
    }
}
