//! Edges on the virtual board's pins, and their recorders.

/// A pin of an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Pin {
    /// Rises for a step.
    Step,
    /// High for forward.
    Direction,
    /// A line to the motor's windings, 0 …, in the order of its drive.
    Coil(u8),
    /// Low turns the driver on.
    Enable,
    /// The switch at the minimum: high while it is closed.
    Min,
    /// The switch at the maximum: high while it is closed.
    Max,
}

#[cfg(feature = "std")]
impl Pin {
    /// The name of the pin of an axis, 0 …: `step1`, `coil1a`.
    pub fn of(self, axis: u8) -> String {
        let axis = u32::from(axis) + 1;
        match self {
            Pin::Step => format!("step{axis}"),
            Pin::Direction => format!("dir{axis}"),
            Pin::Coil(line) => format!("coil{axis}{}", char::from(b'a'.saturating_add(line))),
            Pin::Enable => format!("enable{axis}"),
            Pin::Min => format!("min{axis}"),
            Pin::Max => format!("max{axis}"),
        }
    }
}

/// A change of a pin at a time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Edge {
    /// Ticks of the step timer since the board was switched on.
    pub time: u64,
    /// The axis: 0 … 7.
    pub axis: u8,
    /// The pin of that axis.
    pub pin: Pin,
    /// The level after the edge.
    pub level: bool,
}

impl Edge {
    /// Whether the edge is a rising edge of STEP, at which the motor steps.
    pub fn is_step(&self) -> bool {
        self.pin == Pin::Step && self.level
    }
}

/// A recorder of all edges, in order of time.
pub trait Recorder {
    /// Records an edge.
    fn edge(&mut self, edge: Edge);

    /// Records the laser's power from this time in ticks on: 0, off, to 255.
    fn laser(&mut self, time: u64, power: u8) {
        let _ = (time, power);
    }
}

/// Records nothing.
impl Recorder for () {
    fn edge(&mut self, _: Edge) {}
}

#[cfg(feature = "std")]
impl Recorder for Vec<Edge> {
    fn edge(&mut self, edge: Edge) {
        self.push(edge);
    }
}

/// Two recorders at once.
impl<A: Recorder, B: Recorder> Recorder for (A, B) {
    fn edge(&mut self, edge: Edge) {
        self.0.edge(edge);
        self.1.edge(edge);
    }

    fn laser(&mut self, time: u64, power: u8) {
        self.0.laser(time, power);
        self.1.laser(time, power);
    }
}

/// A recorder that may be absent.
impl<R: Recorder> Recorder for Option<R> {
    fn edge(&mut self, edge: Edge) {
        if let Some(recorder) = self {
            recorder.edge(edge);
        }
    }
}
