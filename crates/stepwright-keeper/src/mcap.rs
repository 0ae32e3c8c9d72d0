//! Levels of pins over time, and what their motors do, as an MCAP file for Foxglove and PlotJuggler.
//!
//! A pin is a channel, its topic the name behind a slash: `/step1`. A message is a level from its
//! log time on, in JSON with a schema: `{"level":1}`. So is an axis, `/axis1`, with a message for
//! each step: `{"position":40,"speed":-812.5}`, in steps and steps/s.

use std::collections::BTreeMap;
use std::io::{self, Write};

use mcap::records::MessageHeader;
use mcap::write::NoSeek;
use mcap::{McapError, WriteOptions, Writer};

/// The schema of every message. The page's `mcap.js` has the same.
const SCHEMA: &str = r#"{"type":"object","properties":{"level":{"type":"integer","minimum":0,"maximum":1,"description":"1 high, 0 low"}}}"#;

/// The schema of what an axis does.
const MOTION: &str = r#"{"type":"object","properties":{"position":{"type":"integer","description":"steps from the beginning of the file"},"speed":{"type":"number","description":"steps/s, by the time since the step before; 0 at the first step and behind the last one of a motion"}}}"#;

/// The schema of a laser's power.
const POWER: &str = r#"{"type":"object","properties":{"power":{"type":"number","description":"of full power, from 0, off, to 1"}}}"#;

/// A pause is this many times longer than the interval before it.
const PAUSE: u64 = 5;

/// Writes levels as they change, from the front to the end: into a pipe, too.
pub struct McapWriter<W: Write> {
    writer: Writer<NoSeek<W>>,
    /// The channel of each pin.
    pins: Vec<Channel>,
    /// Axes by their numbers, with their channels.
    axes: Vec<(u8, Channel, Motion)>,
    laser: Option<Channel>,
}

/// A channel, and its messages so far.
#[derive(Clone, Copy)]
struct Channel {
    id: u16,
    count: u32,
}

/// What an axis has done.
#[derive(Clone, Copy, Default)]
struct Motion {
    position: i64,
    forward: bool,
    /// The last step, in ns, and the time since the one before it in the same motion.
    last: Option<u64>,
    interval: Option<u64>,
}

/// What has gone wrong is of the file: nothing else here can.
fn failed(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

impl<W: Write> McapWriter<W> {
    /// Begins a file of pins of these names, and axes of these numbers; `words` say where their
    /// edges are from.
    ///
    /// # Errors
    /// Those of the writer; more than 65,535 pins.
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

    /// From `nanos` on the pin at this place of the names has this level. A pin that is not
    /// there is left out.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn level(&mut self, pin: usize, nanos: u64, level: bool) -> io::Result<()> {
        let Some(channel) = self.pins.get_mut(pin) else { return Ok(()) };
        let data: &[u8] = if level { br#"{"level":1}"# } else { br#"{"level":0}"# };
        channel.say(&mut self.writer, nanos, data)
    }

    /// From `nanos` on the laser has this power, 0 to 1, on a channel of its own.
    ///
    /// # Errors
    /// Those of the writer.
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

    /// The axis of this number makes a step at `nanos`. One that is not there is left out.
    ///
    /// # Errors
    /// Those of the writer.
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
    /// Those of the writer.
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
    /// Where it is, and how fast by its last interval.
    fn told(&self) -> String {
        let speed = self.interval.map_or(0.0, |nanos| 1e9 / nanos.max(1) as f64);
        let speed = if self.forward { speed } else { 0.0 - speed };
        format!(r#"{{"position":{},"speed":{speed:.3}}}"#, self.position)
    }

    /// After its last step: when, and that it rests. Nothing of a motion of one step.
    fn rest(&self) -> Option<(u64, String)> {
        let rests = self.last?.saturating_add(self.interval?);
        Some((rests, Motion { interval: None, ..*self }.told()))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is told of `/axis1`, in the order of time.
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
        // Two steps at 1000 a second, a pause, and one back.
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
