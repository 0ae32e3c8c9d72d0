//! `stepwright selftest`: judges the result line of a board's self-test.

use std::io::{self, BufRead, BufReader, Read};
use std::path::PathBuf;
use std::time::{Duration, Instant};

use serde_json::json;
use serial2::SerialPort;
use stepwright_selftest::{CHIPS, FORMAT, Fault, Judgement, Line, LineError, ORDERS, WORD, judge};

use crate::failure::Failure;
use crate::order::target::{Format, RATE};
use crate::say;

/// The most bytes that are read while waiting for a line.
const MOST: usize = 65_536;

/// The longest wait for a board's line; the test takes some seconds.
const PATIENCE: Duration = Duration::from_secs(60);

/// Check the result of a board's self-test
///
/// The self-test is a separate firmware: it plays seeded orders, captures its own STEP, and prints one
/// result line again and again. This command plans the same orders and compares the plans, the number of
/// steps, the largest error of a step's time, the late steps and the chip's clock.
#[derive(clap::Args)]
#[command(after_help = "\
Examples:
  stepwright selftest --port /dev/ttyACM0       from a connected board
  stepwright selftest 'stepwright-selftest …'   from a line that somebody has sent
  stepwright selftest < line.txt

Exit status: 0 if the test was passed, 1 if it was not or the line can't be read.")]
pub struct Args {
    /// The result line, quoted or not; without it, the first one on standard input
    #[arg(value_name = "LINE", conflicts_with = "port")]
    line: Vec<String>,
    /// Serial port of a board with the self-test, at 115200 bits/s
    #[arg(long, value_name = "PATH")]
    port: Option<PathBuf>,
    /// How to write the result
    #[arg(long, value_enum, default_value_t = Format::Text)]
    format: Format,
}

/// Judges the line, and prints the result.
pub fn run(args: Args) -> Result<(), Failure> {
    let text = match (&args.port, &args.line[..]) {
        (Some(path), _) => {
            let mut port = SerialPort::open(path, RATE)
                .map_err(|error| Failure::file("open", path, &error))?;
            let _ = port.set_read_timeout(Duration::from_secs(1));
            // If the port has DTR, the board waits for it.
            let _ = port.set_dtr(true);
            say::note(format_args!("waiting for the line, {} s at most", PATIENCE.as_secs()));
            heard(port).map_err(|error| Failure::file("read", path, &error))?
        }
        (None, []) => heard(io::stdin().lock())
            .map_err(|error| Failure::new(format!("can't read standard input: {error}")))?,
        (None, words) => Some(words.join(" ")),
    };
    let text = text.ok_or_else(|| {
        Failure::new(format!("no line came that begins with `{WORD}`")).hint(
            "give the line, or --port PATH of a board with the self-test in it: a Pico by \
             `stepwright flash pico --program selftest`, others by docs/selftest.md",
        )
    })?;
    let line = Line::read(&text).map_err(unread)?;
    let judgement = judge(&line).ok_or_else(|| {
        let names: Vec<_> = CHIPS.iter().map(|chip| chip.name).collect();
        Failure::new(format!("no chip {} is known to this command", line.chip))
            .hint(format!("it knows {}; a newer one may know more", names.join(", ")))
    })?;
    tell(&line, &judgement, args.format);
    let faults: Vec<_> = judgement.faults().collect();
    let Some(first) = faults.first() else { return Ok(()) };
    let all: Vec<_> = faults.iter().map(ToString::to_string).collect();
    Err(Failure::new(format!("the self-test was not passed: {}", all.join("; ")))
        .hint(advice(*first)))
}

/// The first complete line in the input that begins with [`WORD`]. The bytes of a port may begin in
/// the middle of another line.
fn heard(from: impl Read) -> io::Result<Option<String>> {
    let mut from = BufReader::new(from.take(MOST as u64));
    let (begun, mut line) = (Instant::now(), Vec::new());
    loop {
        let (done, length) = match from.fill_buf() {
            Ok([]) => (true, 0),
            Ok(bytes) => {
                let end = bytes.iter().position(|byte| matches!(byte, b'\r' | b'\n'));
                line.extend_from_slice(&bytes[..end.unwrap_or(bytes.len())]);
                (end.is_some(), end.map_or(bytes.len(), |end| end + 1))
            }
            // Nothing has come yet.
            Err(error)
                if matches!(error.kind(), io::ErrorKind::TimedOut | io::ErrorKind::WouldBlock) =>
            {
                if begun.elapsed() > PATIENCE {
                    return Ok(None);
                }
                continue;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => continue,
            Err(error) => return Err(error),
        };
        from.consume(length);
        if done {
            let text = String::from_utf8_lossy(&line).trim().to_owned();
            if text.starts_with(WORD) {
                return Ok(Some(text));
            }
            if length == 0 {
                return Ok(None);
            }
            line.clear();
        }
    }
}

/// The failure for a line that can't be parsed, with a hint.
fn unread(error: LineError<'_>) -> Failure {
    let hint = match error {
        LineError::Format(format) if format > FORMAT => {
            "a newer stepwright reads it: compare `stepwright --version`".to_owned()
        }
        LineError::Format(_) => "take the self-test of this release".to_owned(),
        _ => format!("copy the whole line, from `{WORD}` to the eight digits behind `crc=`"),
    };
    Failure::new(error.to_string()).hint(hint)
}

/// The hint for a fault.
fn advice(fault: Fault) -> &'static str {
    match fault {
        Fault::Rate(..) | Fault::Orders(_) | Fault::Plan(..) | Fault::Steps(..) => {
            "is the self-test of the same release as this command? If it is, please send the line"
        }
        Fault::Edges(..) => {
            "is anything but a driver on the STEP pins? Take all off them, and try again"
        }
        Fault::Clock(..) | Fault::NoClock => "has the board another crystal? Please send the line",
        Fault::Off(..) | Fault::Late(_) => "try again; if it stays, please send the line",
    }
}

fn tell(line: &Line<'_>, judgement: &Judgement, format: Format) {
    let (found, [off, allowed]) = (line.found, judgement.off);
    if format == Format::Json {
        let faults: Vec<_> = judgement.faults().map(|fault| fault.to_string()).collect();
        say::json(json!({
            "chip": line.chip,
            "version": line.version,
            "flash": format!("{:08x}", line.flash),
            "hz": line.hz,
            "khz": line.khz,
            "orders": found.orders,
            "plan": format!("{:08x}", found.plan),
            "steps": found.steps,
            "edges": found.edges,
            "off_us": f64::from(off) / 1e3,
            "allowed_us": f64::from(allowed) / 1e3,
            "late": found.late,
            "passed": judgement.is_kept(),
            "faults": faults,
        }));
        return;
    }
    let [off, allowed] = [off, allowed].map(|nanos| f64::from(nanos) / 1e3);
    say::result(format_args!(
        "chip        {}, firmware {}, flash {:08x}",
        line.chip, line.version, line.flash
    ));
    match line.khz {
        Some(khz) => say::result(format_args!("clock       {khz} kHz by its second clock")),
        None => say::result("clock       not measured: it has no second one"),
    }
    say::result(format_args!("orders      {} of {ORDERS}, plan {:08x}", found.orders, found.plan));
    say::result(format_args!("edges       {} of {}", found.edges, found.steps));
    say::result(format_args!("worst edge  {off:.3} µs from its time; {allowed:.3} µs are allowed"));
    say::result(format_args!("late        {}", found.late));
    if judgement.is_kept() {
        say::result("passed");
    }
}
