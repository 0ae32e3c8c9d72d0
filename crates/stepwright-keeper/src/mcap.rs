//! The levels of pins over time, and the motion of their motors, as an MCAP file for Foxglove and PlotJuggler.
//!
//! A pin is a channel, with the topic `/step1`. A message has the level from its log time on, in JSON with a
//! schema: `{"level":1}`. An axis is a channel too, `/axis1`, with a message for each step:
//! `{"position":40,"speed":-812.5}`, in steps and steps/s.

use std::collections::BTreeMap;
use std::io::{self, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};

/// The schema of the levels.
const SCHEMA: &str = r#"{"type":"object","properties":{"level":{"type":"integer","minimum":0,"maximum":1,"description":"1 high, 0 low"}}}"#;

/// The schema of an axis' motion.
const MOTION: &str = r#"{"type":"object","properties":{"position":{"type":"integer","description":"steps from the beginning of the file"},"speed":{"type":"number","description":"steps/s, by the time since the step before; 0 at the first step and behind the last one of a motion"}}}"#;

/// The schema of a laser's power.
const POWER: &str = r#"{"type":"object","properties":{"power":{"type":"number","description":"of full power, from 0, off, to 1"}}}"#;

/// A step counts as coming after a pause if its interval is this many times longer than the interval before.
const PAUSE: u64 = 5;

/// Writes levels as they change, from front to end, so the output may be a pipe.
pub struct McapWriter<W: Write> {
    writer: Writer<NoSeek<W>>,
    /// The channels of the pins.
    pins: Vec<Channel>,
    /// The numbers of the axes, and their channels.
    axes: Vec<(u8, Channel, Motion)>,
    laser: Option<Channel>,
}

/// A channel, and the number of its messages so far.
#[derive(Clone, Copy)]
struct Channel {
    id: u16,
    count: u32,
}

/// The motion of an axis so far.
#[derive(Clone, Copy, Default)]
struct Motion {
    position: i64,
    forward: bool,
    /// The time of the last step in ns, and the interval before it in the same motion.
    last: Option<u64>,
    interval: Option<u64>,
}

/// Every error here is one of the file.
fn failed(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

impl<W: Write> McapWriter<W> {
    /// Begins a file for pins of these names and axes of these numbers. `words` describe the source of the
    /// edges.
    ///
    /// # Errors
    /// Errors of the writer; more than 65,535 pins.
    pub fn new<'n>(
        out: W,
        names: impl IntoIterator<Item = &'n str>,
        axes: impl IntoIterator<Item = u8>,
        words: &str,
    ) -> io::Result<McapWriter<W>> {
        let library = concat!("stepwright ", env!("CARGO_PKG_VERSION"));
        let options = WriteOptions::new().compression(None).library(library).disable_seeking(true);
        let mut writer = options.create(NoSeek::new(out)).map_err(failed)?;
        let mut schema = |name, text: &str| {
            writer.add_schema(name, "jsonschema", text.as_bytes()).map_err(failed)
        };
        let (level, motion) =
            (schema("stepwright.Level", SCHEMA)?, schema("stepwright.Motion", MOTION)?);
        let metadata = BTreeMap::from([("source".to_owned(), words.to_owned())]);
        let mut channel = |schema, topic: &str| {
            let id = writer.add_channel(schema, topic, "json", &metadata).map_err(failed)?;
            Ok::<_, io::Error>(Channel { id, count: 0 })
        };
        let pins = names.into_iter().map(|name| channel(level, &format!("/{name}")));
        let pins = pins.collect::<io::Result<_>>()?;
        let axes = axes
            .into_iter()
            .map(|axis| Ok((axis, channel(motion, &format!("/axis{axis}"))?, Motion::default())));
        let axes = axes.collect::<io::Result<_>>()?;
        Ok(McapWriter { writer, pins, axes, laser: None })
    }

    /// Sets the level of the pin at this place of the names, from `nanos` on. Ignores a pin that the file does
    /// not have.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn level(&mut self, pin: usize, nanos: u64, level: bool) -> io::Result<()> {
        let Some(channel) = self.pins.get_mut(pin) else { return Ok(()) };
        let data: &[u8] = if level { br#"{"level":1}"# } else { br#"{"level":0}"# };
        channel.say(&mut self.writer, nanos, data)
    }

    /// Sets the power of the laser, 0 to 1, from `nanos` on, on a channel of its own.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn laser(&mut self, nanos: u64, power: f64) -> io::Result<()> {
        if self.laser.is_none() {
            let schema = self.writer.add_schema("stepwright.Power", "jsonschema", POWER.as_bytes());
            let schema = schema.map_err(failed)?;
            let id = self.writer.add_channel(schema, "/laser", "json", &BTreeMap::new());
            self.laser = Some(Channel { id: id.map_err(failed)?, count: 0 });
        }
        let Some(channel) = &mut self.laser else { return Ok(()) };
        channel.say(&mut self.writer, nanos, format!(r#"{{"power":{power:.4}}}"#).as_bytes())
    }

    /// Adds a step of the axis of this number at `nanos`. Ignores an axis that the file does not have.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn step(&mut self, axis: u8, nanos: u64, forward: bool) -> io::Result<()> {
        let found = self.axes.iter_mut().find(|(number, ..)| *number == axis);
        let Some((_, channel, motion)) = found else { return Ok(()) };
        let since = motion.last.map(|last| nanos.saturating_sub(last));
        let turned = motion.forward != forward;
        let pause = since
            .zip(motion.interval)
            .is_some_and(|(now, before)| now > before.saturating_mul(PAUSE));
        if (turned || pause)
            && let Some((rests, data)) = motion.rest()
        {
            channel.say(&mut self.writer, rests.min(nanos), data.as_bytes())?;
        }
        motion.interval = since.filter(|_| !turned && !pause);
        motion.last = Some(nanos);
        motion.forward = forward;
        motion.position += if forward { 1 } else { -1 };
        let data = motion.told();
        channel.say(&mut self.writer, nanos, data.as_bytes())
    }

    /// Ends the file.
    ///
    /// # Errors
    /// Errors of the writer.
    pub fn finish(mut self) -> io::Result<W> {
        for (_, channel, motion) in &mut self.axes {
            if let Some((rests, data)) = motion.rest() {
                channel.say(&mut self.writer, rests, data.as_bytes())?;
            }
        }
        self.writer.finish().map_err(failed)?;
        let mut out = self.writer.into_inner().into_inner();
        out.flush()?;
        Ok(out)
    }
}

impl Channel {
    fn say<W: Write>(
        &mut self,
        writer: &mut Writer<NoSeek<W>>,
        nanos: u64,
        data: &[u8],
    ) -> io::Result<()> {
        let (log_time, publish_time) = (nanos, nanos);
        let header =
            MessageHeader { channel_id: self.id, sequence: self.count, log_time, publish_time };
        self.count = self.count.wrapping_add(1);
        writer.write_to_known_channel(&header, data).map_err(failed)
    }
}

impl Motion {
    /// The position, and the speed by the last interval.
    fn told(&self) -> String {
        let speed = self.interval.map_or(0.0, |nanos| 1e9 / nanos.max(1) as f64);
        let speed = if self.forward { speed } else { 0.0 - speed };
        format!(r#"{{"position":{},"speed":{speed:.3}}}"#, self.position)
    }

    /// The time at which the axis rests after its last step, and the message; `None` for a motion of one step.
    fn rest(&self) -> Option<(u64, String)> {
        let rests = self.last?.saturating_add(self.interval?);
        Some((rests, Motion { interval: None, ..*self }.told()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The messages of `/axis1`, in order of time.
    fn told(steps: &[(u64, bool)]) -> Vec<(u64, String)> {
        let mut file = McapWriter::new(Vec::new(), ["step1"], [1], "w").unwrap();
        for (nanos, forward) in steps {
            file.step(1, *nanos, *forward).unwrap();
        }
        let bytes = file.finish().unwrap();
        let messages = mcap::MessageStream::new(&bytes).unwrap().map(Result::unwrap);
        let mine = messages.filter(|one| one.channel.topic == "/axis1");
        let mut all: Vec<_> = mine
            .map(|one| (one.log_time, String::from_utf8(one.data.into_owned()).unwrap()))
            .collect();
        all.sort();
        all
    }

    #[test]
    fn each_step_has_its_position_and_speed() {
        // Two steps at 1000 steps/s, a pause, and one step back.
        let steps = [(1_000_000, true), (2_000_000, true), (50_000_000, false)];
        let right = [
            (1_000_000, r#"{"position":1,"speed":0.000}"#),
            (2_000_000, r#"{"position":2,"speed":1000.000}"#),
            (3_000_000, r#"{"position":2,"speed":0.000}"#),
            (50_000_000, r#"{"position":1,"speed":0.000}"#),
        ];
        let right = right.map(|(time, text)| (time, text.to_owned()));
        assert_eq!(told(&steps), right);
    }

    #[test]
    fn backward_is_negative_and_a_pause_is_no_speed() {
        let steps = [(0, false), (500_000, false), (1_000_000, false), (9_000_000, false)];
        let speeds: Vec<_> = told(&steps)
            .iter()
            .map(|(_, text)| text.rsplit(':').next().unwrap().trim_end_matches('}').to_owned())
            .collect();
        assert_eq!(speeds, ["0.000", "-2000.000", "-2000.000", "0.000", "0.000"]);
    }
}
