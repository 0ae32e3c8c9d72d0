//! Levels of pins over time as an MCAP file, for Foxglove and PlotJuggler.
//!
//! A pin is a channel, its topic the name behind a slash: `/step1`. A message is a level from its
//! log time on, in JSON with a schema: `{"level":1}`.

use std::collections::BTreeMap;
use std::io::{self, Seek, Write};

use mcap::records::MessageHeader;
use mcap::{McapError, WriteOptions, Writer};

/// The schema of every message. The page's `mcap.js` has the same.
const SCHEMA: &str = r#"{"type":"object","properties":{"level":{"type":"integer","minimum":0,"maximum":1,"description":"1 high, 0 low"}}}"#;

/// Writes levels as they change.
pub struct McapWriter<W: Write + Seek> {
    writer: Writer<W>,
    /// The channel of each pin, and its messages so far.
    channels: Vec<(u16, u32)>,
}

/// What has gone wrong is of the file: nothing else here can.
fn failed(error: McapError) -> io::Error {
    match error {
        McapError::Io(error) => error,
        other => io::Error::other(other),
    }
}

impl<W: Write + Seek> McapWriter<W> {
    /// Begins a file of pins of these names; `words` say where their edges are from.
    ///
    /// # Errors
    /// Those of the writer; more than 65,535 pins.
    pub fn new<'n>(
        out: W,
        names: impl IntoIterator<Item = &'n str>,
        words: &str,
    ) -> io::Result<McapWriter<W>> {
        let library = concat!("stepwright ", env!("CARGO_PKG_VERSION"));
        let options = WriteOptions::new().compression(None).library(library);
        let mut writer = options.create(out).map_err(failed)?;
        let schema = writer.add_schema("stepwright.Level", "jsonschema", SCHEMA.as_bytes());
        let schema = schema.map_err(failed)?;
        let metadata = BTreeMap::from([("source".to_owned(), words.to_owned())]);
        let channels = names.into_iter().map(|name| {
            let topic = format!("/{name}");
            let id = writer.add_channel(schema, &topic, "json", &metadata).map_err(failed)?;
            Ok((id, 0))
        });
        let channels = channels.collect::<io::Result<_>>()?;
        Ok(McapWriter { writer, channels })
    }

    /// From `nanos` on the pin at this place of the names has this level. A pin that is not
    /// there is left out.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn level(&mut self, pin: usize, nanos: u64, level: bool) -> io::Result<()> {
        let Some((channel_id, count)) = self.channels.get_mut(pin) else { return Ok(()) };
        let (log_time, publish_time) = (nanos, nanos);
        let header =
            MessageHeader { channel_id: *channel_id, sequence: *count, log_time, publish_time };
        *count = count.wrapping_add(1);
        let data: &[u8] = if level { br#"{"level":1}"# } else { br#"{"level":0}"# };
        self.writer.write_to_known_channel(&header, data).map_err(failed)
    }

    /// Ends the file.
    ///
    /// # Errors
    /// Those of the writer.
    pub fn finish(mut self) -> io::Result<W> {
        self.writer.finish().map_err(failed)?;
        let mut out = self.writer.into_inner();
        out.flush()?;
        Ok(out)
    }
}
