//! STEP and DIR, or coils, and enable of the last seconds, as a logic analyser shows them; and as a file: VCD,
//! CSV, MCAP.

use std::borrow::Cow;
use std::fmt::Write;
use std::io;

use serde::{Deserialize, Serialize};

use crate::mcap::McapWriter;

/// The most seconds that are kept.
pub const LONGEST: f64 = 10.0;

/// The most pins of a file: STEP, DIR and four coils of eight axes, and enable; and the most edges.
const PINS: usize = 8 * 6 + 1;
const EDGES: usize = 2_500_000;

/// A source of edges.
pub trait ScopeSource: Send + Sync {
    /// The edges of the last seconds up to `now`, in seconds since the server began.
    fn record(&self, seconds: f64, now: f64) -> ScopeRecord;

    /// The plan of an axis is no longer valid from this time on, in seconds since the server began. For a
    /// source that knows plans only.
    fn unplan(&self, _axis: u8, _time: f64) {}
}

/// The recorded levels of a board's pins.
#[derive(Clone, Debug, Default, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct ScopeRecord {
    /// `pins`: the edges themselves, of a virtual board. `plan`: the planned pulses of a board at the end of a
    /// line.
    #[cfg_attr(feature = "http", schema(value_type = String))]
    pub source: Cow<'static, str>,
    /// The source in words.
    #[cfg_attr(feature = "http", schema(value_type = String))]
    pub words: Cow<'static, str>,
    /// Ticks per second of the times below.
    pub hz: u32,
    /// When the record begins, in ticks of the board's clock.
    pub begin: u64,
    /// When it ends.
    pub end: u64,
    /// The pins.
    pub signals: Vec<ScopeSignal>,
}

/// A pin.
#[derive(Clone, Debug, PartialEq, Eq, Deserialize, Serialize)]
#[cfg_attr(feature = "http", derive(utoipa::ToSchema))]
pub struct ScopeSignal {
    /// Its name: `step1`, `dir1`, `coil1a`, `enable`.
    pub name: String,
    /// The axis of the pin, if it has one.
    pub axis: Option<u8>,
    /// `step`, `dir`, `coil` or `enable`.
    #[cfg_attr(feature = "http", schema(value_type = String))]
    pub pin: Cow<'static, str>,
    /// Its level at the beginning of the record, if that is known.
    pub level: Option<bool>,
    /// The ticks from the beginning to the first edge, and from each edge to the next. The level changes at
    /// each edge.
    pub edges: Vec<u64>,
}

impl ScopeSignal {
    /// A pin without edges.
    pub fn new(axis: Option<u8>, pin: &'static str) -> ScopeSignal {
        let name = axis.map_or_else(|| pin.to_owned(), |axis| format!("{pin}{axis}"));
        ScopeSignal { name, axis, pin: pin.into(), level: None, edges: Vec::new() }
    }

    /// Its edges: the time in ticks from the beginning of the record, and the level after the edge.
    fn changes(&self) -> impl Iterator<Item = (u64, bool)> + '_ {
        let mut time = 0;
        let mut level = self.level.unwrap_or_default();
        self.edges.iter().map(move |ticks| {
            time = u64::saturating_add(time, *ticks);
            level = !level;
            (time, level)
        })
    }
}

/// A file format for a record.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ScopeFile {
    /// A Value Change Dump.
    Vcd,
    /// A table.
    Csv,
    /// For Foxglove and PlotJuggler.
    Mcap,
}

impl ScopeFile {
    /// The file format with this ending: `vcd`, `csv`, `mcap`.
    pub fn named(ending: &str) -> Option<ScopeFile> {
        Some(match ending {
            "vcd" => ScopeFile::Vcd,
            "csv" => ScopeFile::Csv,
            "mcap" => ScopeFile::Mcap,
            _ => return None,
        })
    }

    /// The bytes of the file.
    ///
    /// # Errors
    /// More pins, or more edges, than a board makes.
    pub fn of(self, record: &ScopeRecord) -> io::Result<Vec<u8>> {
        let (pins, edges) = (&record.signals, |one: &ScopeSignal| one.edges.len());
        if pins.len() > PINS || pins.iter().map(edges).sum::<usize>() > EDGES {
            let most = format!("more than {PINS} pins or {EDGES} edges");
            return Err(io::Error::new(io::ErrorKind::InvalidInput, most));
        }
        match self {
            ScopeFile::Vcd => Ok(vcd(record).into_bytes()),
            ScopeFile::Csv => Ok(csv(record).into_bytes()),
            ScopeFile::Mcap => mcap(record),
        }
    }
}

/// All edges in order of time: ticks from the beginning, the number of the signal, and its level.
fn merged(record: &ScopeRecord) -> Vec<(u64, usize, bool)> {
    let signals = record.signals.iter().enumerate();
    let edges =
        signals.flat_map(|(n, signal)| signal.changes().map(move |(t, level)| (t, n, level)));
    let mut edges: Vec<_> = edges.collect();
    edges.sort_by_key(|(time, ..)| *time);
    edges
}

/// The record as a Value Change Dump (VCD), for GTKWave and PulseView. Times count from the beginning.
///
/// The unit of time is the longest that holds a tick exactly, or else 1 ps, rounded down.
pub fn vcd(record: &ScopeRecord) -> String {
    let hz = u128::from(record.hz.max(1));
    let units: Vec<u128> = (0..=12).map(|power| 10u128.pow(power)).collect();
    let unit = units.iter().position(|unit| unit.is_multiple_of(hz)).unwrap_or(12);
    let name = ["s", "ms", "us", "ns", "ps"][unit.div_ceil(3)];
    let scale = 10u32.pow((3 - unit as u32 % 3) % 3);
    let letter = |n: usize| char::from(b'!' + (n % 90) as u8);
    let mut out = format!("$comment {} $end\n$timescale {scale} {name} $end\n", record.words);
    out.push_str("$scope module board $end\n");
    for (n, signal) in record.signals.iter().enumerate() {
        let _ = writeln!(out, "$var wire 1 {} {} $end", letter(n), signal.name);
    }
    out.push_str("$upscope $end\n$enddefinitions $end\n#0\n$dumpvars\n");
    for (n, signal) in record.signals.iter().enumerate() {
        let level = signal.level.map_or('x', |level| if level { '1' } else { '0' });
        let _ = writeln!(out, "{level}{}", letter(n));
    }
    out.push_str("$end\n");
    let at = |ticks: u64| u128::from(ticks) * units[unit] / hz;
    let mut last = None;
    for (time, n, level) in merged(record) {
        if last != Some(time) {
            last = Some(time);
            let _ = writeln!(out, "#{}", at(time));
        }
        let _ = writeln!(out, "{}{}", u8::from(level), letter(n));
    }
    let _ = writeln!(out, "#{}", at(record.end.saturating_sub(record.begin)));
    out
}

/// The record as a table, with a row for each time of a change: µs from the beginning, and all levels.
pub fn csv(record: &ScopeRecord) -> String {
    let mut out = String::from("time_us");
    let mut levels: Vec<_> = record.signals.iter().map(|signal| signal.level).collect();
    for signal in &record.signals {
        let _ = write!(out, ",{}", signal.name);
    }
    let row = |out: &mut String, time: u64, levels: &[Option<bool>]| {
        // At 16 MHz a tick is 0.0625 µs.
        let nanos = u128::from(time) * 10_000_000_000 / u128::from(record.hz.max(1));
        let _ = write!(out, "\n{}.{:04}", nanos / 10_000, nanos % 10_000);
        for level in levels {
            out.push_str(level.map_or(",", |level| if level { ",1" } else { ",0" }));
        }
    };
    row(&mut out, 0, &levels);
    let edges = merged(record);
    for (place, (time, n, level)) in edges.iter().enumerate() {
        levels[*n] = Some(*level);
        if edges.get(place + 1).is_none_or(|(next, ..)| next != time) {
            row(&mut out, *time, &levels);
        }
    }
    out.push('\n');
    out
}

/// The record as MCAP: the levels at the beginning, all edges in ns from there, rounded down, and the position
/// (0 at the beginning) and speed of each axis with STEP and DIR.
///
/// # Errors
/// More pins than MCAP has channels.
pub fn mcap(record: &ScopeRecord) -> io::Result<Vec<u8>> {
    let names = record.signals.iter().map(|signal| signal.name.as_str());
    let stepped = |signal: &&ScopeSignal| signal.pin == "step";
    let axes = record.signals.iter().filter(stepped).filter_map(|signal| signal.axis);
    let mut file = McapWriter::new(Vec::new(), names, axes, &record.words)?;
    let mut forward: Vec<_> = record.signals.iter().map(|signal| signal.level).collect();
    for (n, signal) in record.signals.iter().enumerate() {
        if let Some(level) = signal.level {
            file.level(n, 0, level)?;
        }
    }
    let hz = u128::from(record.hz.max(1));
    for (time, n, level) in merged(record) {
        let nanos = (u128::from(time) * 1_000_000_000 / hz) as u64;
        file.level(n, nanos, level)?;
        let signal = &record.signals[n];
        if let (Some(axis), "step", true) = (signal.axis, signal.pin.as_ref(), level) {
            let dir = |one: &ScopeSignal| (one.axis, one.pin.as_ref()) == (Some(axis), "dir");
            let dir = record.signals.iter().position(dir).and_then(|dir| forward[dir]);
            file.step(axis, nanos, dir.unwrap_or(true))?;
        }
        forward[n] = Some(level);
    }
    file.finish()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two pulses of 2 µs with a turn between them, at 16 MHz.
    fn record() -> ScopeRecord {
        let step = ScopeSignal::new(Some(1), "step");
        let step = ScopeSignal { level: Some(false), edges: vec![16, 32, 1600, 32], ..step };
        let dir = ScopeSignal::new(Some(1), "dir");
        let dir = ScopeSignal { level: Some(true), edges: vec![48], ..dir };
        let signals = vec![step, dir, ScopeSignal::new(None, "enable")];
        ScopeRecord {
            source: "pins".into(),
            words: "w".into(),
            hz: 16_000_000,
            begin: 7,
            end: 2007,
            signals,
        }
    }

    #[test]
    fn a_dump_has_every_edge_at_its_time() {
        let dump = vcd(&record());
        let body = dump.split("$enddefinitions $end\n").nth(1).unwrap();
        // 100 ps: 16 ticks of 62.5 ns are 1 µs.
        assert!(dump.contains("$timescale 100 ps $end\n"), "{dump}");
        assert!(dump.contains("$var wire 1 ! step1 $end\n$var wire 1 \" dir1 $end\n"), "{dump}");
        let right = "#0\n$dumpvars\n0!\n1\"\nx#\n$end\n#10000\n1!\n#30000\n0!\n0\"\n#1030000\n1!\n\
                     #1050000\n0!\n#1250000\n";
        assert_eq!(body, right);
    }

    #[test]
    fn a_table_has_a_row_for_each_change() {
        assert_eq!(
            csv(&record()),
            "time_us,step1,dir1,enable\n0.0000,0,1,\n1.0000,1,1,\n3.0000,0,0,\n103.0000,1,0,\n\
             105.0000,0,0,\n"
        );
        let odd = ScopeRecord { hz: 3, end: 9, begin: 0, ..record() };
        assert!(vcd(&odd).contains("$timescale 1 ps $end"));
        assert!(csv(&odd).contains("\n5333333.3333,1,1,\n"));
    }

    #[test]
    fn what_no_board_makes_is_no_file() {
        let pins = |count| ScopeRecord {
            signals: vec![ScopeSignal::new(None, "enable"); count],
            ..record()
        };
        let mut long = pins(1);
        long.signals[0].edges = vec![1; EDGES + 1];
        for form in [ScopeFile::Vcd, ScopeFile::Csv, ScopeFile::Mcap] {
            assert!(form.of(&pins(PINS)).is_ok());
            assert!(form.of(&pins(PINS + 1)).is_err());
            assert!(form.of(&long).is_err());
        }
    }

    /// The file as another reader sees it: topic, ns, and the level or position.
    fn read(file: &[u8]) -> Vec<(String, u64, i64)> {
        let messages = ::mcap::MessageStream::new(file).unwrap().map(Result::unwrap);
        let of = |message: ::mcap::Message<'_>| {
            let schema = message.channel.schema.as_ref().unwrap();
            let text: serde_json::Value = serde_json::from_slice(&schema.data).unwrap();
            assert_eq!((schema.encoding.as_str(), &text["type"]), ("jsonschema", &"object".into()));
            assert_eq!(message.channel.metadata.get("source").unwrap(), "w");
            let value: serde_json::Value = serde_json::from_slice(&message.data).unwrap();
            let number = value.get("level").or(value.get("position")).unwrap();
            (message.channel.topic.clone(), message.log_time, number.as_i64().unwrap())
        };
        messages.map(of).collect()
    }

    #[test]
    fn a_recording_has_the_levels_at_the_beginning_and_every_edge() {
        let file = mcap(&record()).unwrap();
        let message = |pin: &str, nanos, level| (format!("/{pin}"), nanos, level);
        let mut found = read(&file);
        assert!(found.is_sorted_by_key(|(_, nanos, _)| *nanos));
        found.sort_by_key(|(pin, ..)| pin.clone());
        let right = [
            // A step, a turn, and a step back.
            message("axis1", 1_000, 1),
            message("axis1", 103_000, 0),
            message("dir1", 0, 1),
            message("dir1", 3_000, 0),
            message("step1", 0, 0),
            message("step1", 1_000, 1),
            message("step1", 3_000, 0),
            message("step1", 103_000, 1),
            message("step1", 105_000, 0),
        ];
        assert_eq!(found, right);
        // The summary is complete: a pin without edges has its channel too.
        let summary = ::mcap::Summary::read(&file).unwrap().unwrap();
        assert_eq!((summary.channels.len(), summary.chunk_indexes.len()), (4, 1));
        assert_eq!(summary.stats.unwrap().message_count, 9);
        // A third of a second, rounded down.
        let odd = ScopeRecord { hz: 3, end: 9, begin: 0, ..record() };
        assert_eq!(read(&mcap(&odd).unwrap())[2], message("step1", 5_333_333_333, 1));
    }
}
