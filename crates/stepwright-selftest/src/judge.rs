//! The judgement of a line.

use core::fmt;

use crate::{Chip, Crc32, Line, ORDERS, plan};

/// The tolerance of a measured clock: a thousandth. A chip's own clocks can only reveal a wrong
/// divider or another crystal.
const CLOCK: u32 = 1_000;

/// A fault of a chip.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Fault {
    /// It stamps edges at another rate: the reported rate, and the expected one.
    Rate(u32, u32),
    /// It took fewer orders than it was given.
    Orders(u32),
    /// Its plan differs: the reported checksum, and the one computed here.
    Plan(u32, u32),
    /// It planned another number of steps: the reported number, and the one planned here.
    Steps(u32, u32),
    /// It captured another number of edges than it planned steps: edges, and steps.
    Edges(u32, u32),
    /// The largest distance of an edge from its time, and the bound, in nanoseconds.
    Off(u32, u32),
    /// The number of late steps.
    Late(u32),
    /// Its clock is wrong: the measured frequency, and the expected one, in kHz.
    Clock(u32, u32),
    /// It reports no clock though it has a second one, or a clock though it has none.
    NoClock,
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match *self {
            Fault::Rate(is, should) => {
                write!(f, "it counts at {is} Hz, and a chip of this name at {should} Hz")
            }
            Fault::Orders(taken) => write!(f, "it took {taken} of {ORDERS} orders"),
            Fault::Plan(is, should) => write!(
                f,
                "it planned something else than this command: {is:08x} and not {should:08x}"
            ),
            Fault::Steps(is, should) => {
                write!(f, "it planned {is} steps, and this command {should}")
            }
            Fault::Edges(edges, steps) => {
                write!(f, "{edges} edges were captured on STEP, and {steps} were planned")
            }
            Fault::Off(is, allowed) => {
                let [is, allowed] = [is, allowed].map(Micros);
                write!(f, "an edge came {is} µs from its time, and {allowed} µs are allowed")
            }
            Fault::Late(1) => f.write_str("1 step was late"),
            Fault::Late(late) => write!(f, "{late} steps were late"),
            Fault::Clock(is, should) => {
                write!(f, "its clock is {is} kHz by its second one, and should be {should} kHz")
            }
            Fault::NoClock => f.write_str("what it says of its clock is not what such a chip says"),
        }
    }
}

/// Nanoseconds, printed as microseconds.
struct Micros(u32);

impl fmt::Display for Micros {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}.{:03}", self.0 / 1_000, self.0 % 1_000)
    }
}

/// The result of a judgement.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Judgement {
    /// The worst distance of an edge from its time, and its bound, in nanoseconds.
    pub off: [u32; 2],
    faults: [Option<Fault>; 8],
}

impl Judgement {
    /// The faults; none if the test was passed.
    pub fn faults(&self) -> impl Iterator<Item = Fault> + '_ {
        self.faults.iter().copied().flatten()
    }

    /// Whether there are no faults.
    pub fn is_kept(&self) -> bool {
        self.faults().next().is_none()
    }
}

/// Judges a line: plans the chip's orders and compares. `None` if there is no such chip.
pub fn judge(line: &Line<'_>) -> Option<Judgement> {
    let chip = Chip::named(line.chip)?;
    let (found, hz) = (line.found, chip.rate.hz());
    let (mut sum, mut steps) = (Crc32::new(), 0u32);
    for number in 0..ORDERS {
        plan(chip, number, &mut sum, |_| steps = steps.wrapping_add(1));
    }
    let planned = sum.end();
    let nanos = |ticks: u32| {
        let nanos = u64::from(ticks) * 1_000_000_000 / u64::from(hz);
        u32::try_from(nanos).unwrap_or(u32::MAX)
    };
    let when = |is: bool, fault: Fault| is.then_some(fault);
    let khz = hz / 1_000;
    let clock = match line.khz {
        None => when(chip.has_second_clock, Fault::NoClock),
        Some(_) if !chip.has_second_clock => Some(Fault::NoClock),
        Some(is) => when(is.abs_diff(khz) > khz / CLOCK, Fault::Clock(is, khz)),
    };
    let faults = [
        when(line.hz != hz, Fault::Rate(line.hz, hz)),
        when(found.orders != ORDERS, Fault::Orders(found.orders)),
        when(found.plan != planned, Fault::Plan(found.plan, planned)),
        when(found.steps != steps, Fault::Steps(found.steps, steps)),
        when(found.edges != found.steps, Fault::Edges(found.edges, found.steps)),
        when(found.off > chip.bound, Fault::Off(nanos(found.off), nanos(chip.bound))),
        when(found.late != 0, Fault::Late(found.late)),
        clock,
    ];
    Some(Judgement { off: [nanos(found.off), nanos(chip.bound)], faults })
}
