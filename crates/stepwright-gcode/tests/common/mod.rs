//! What a text of G-code comes to, in short words.
#![allow(dead_code)] // rs274.rs uses its part

use stepwright_gcode::{
    Arc, Block, Effect, Error, FeedRate, MoveKind, Options, Parameter, Plane, Probe, Reader,
    SpindleMode,
};

/// All blocks and errors of a text.
pub fn blocks(reader: &mut Reader, text: &[u8]) -> Vec<Result<Block, Error>> {
    let mut blocks: Vec<_> = text.iter().filter_map(|&byte| reader.push(byte)).collect();
    blocks.extend(reader.finish());
    blocks
}

/// The effects of a text, one a line.
pub fn read(text: &str) -> String {
    read_with(Options::default(), text)
}

/// The same, of a reader with options.
pub fn read_with(options: Options, text: &str) -> String {
    let blocks = blocks(&mut Reader::new(options), text.as_bytes());
    let lines = blocks.into_iter().flat_map(|block| match block {
        Ok(block) => block.effects().map(words).collect(),
        Err(error) => vec![refusal(error)],
    });
    lines.collect::<Vec<_>>().join("\n")
}

/// `error 22 at 1:4`.
pub fn refusal(error: Error) -> String {
    format!("error {} at {}:{}", error.fault.number(), error.line, error.column)
}

/// An effect.
pub fn words(effect: Effect) -> String {
    match effect {
        Effect::Tool(number) => format!("tool {number}"),
        Effect::Spindle(spindle) => {
            let mode = match spindle.mode {
                SpindleMode::Off => "off",
                SpindleMode::Clockwise => "cw",
                SpindleMode::CounterClockwise => "ccw",
            };
            format!("spindle {mode} {}", spindle.speed)
        }
        Effect::Coolant(coolant) => {
            let is_on = |on, name| if on { name } else { "" };
            format!("coolant{}{}", is_on(coolant.mist, " mist"), is_on(coolant.flood, " flood"))
        }
        Effect::Dwell(seconds) => format!("dwell {seconds}"),
        Effect::Parameter(Parameter::System(system), value) => format!("{system:?} = {value}"),
        Effect::Parameter(parameter, value) => format!("{parameter:?} = {value}"),
        Effect::Stop(stop) => format!("{stop:?}"),
        Effect::Move(part) => match part.kind {
            MoveKind::Rapid => format!("rapid {}", part.to),
            MoveKind::Feed(rate) => format!("feed {} {}", feed(rate), part.to),
            MoveKind::Probe(Probe { toward, must }, rate) => {
                let (way, or) = (if toward { "to" } else { "off" }, if must { "!" } else { "?" });
                format!("probe {way}{or} {} {}", feed(rate), part.to)
            }
            MoveKind::Arc(Arc { plane, clockwise, centre: [a, b] }, rate) => {
                let turn = if clockwise { "cw" } else { "ccw" };
                let centre = match plane {
                    Plane::Xy => format!("X{a} Y{b}"),
                    Plane::Zx => format!("Z{a} X{b}"),
                    Plane::Yz => format!("Y{a} Z{b}"),
                };
                format!("{turn} {} {} about {centre}", feed(rate), part.to)
            }
        },
    }
}

fn feed(rate: FeedRate) -> String {
    match rate {
        FeedRate::PerMinute(rate) => format!("F{rate}"),
        FeedRate::Inverse(moves) => format!("1/{moves}"),
    }
}

/// Every text of a table comes to what stands beside it.
#[track_caller]
pub fn table(rows: &[(&str, &str)]) {
    for (text, expected) in rows {
        assert_eq!(&read(text), expected, "{text:?}");
    }
}
