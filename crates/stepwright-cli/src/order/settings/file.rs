//! Settings as a file: TOML, one `name = number` a line.

use std::fmt::Write;

use stepwright_protocol::{Listed, Value};

use super::words;

/// The text of a file with these settings and their meanings.
pub fn write(listed: &Listed, board: &str) -> String {
    let mut text = format!(
        "# Settings of {board}.\n# `stepwright settings load FILE` gives them to a board. \
         What a file leaves out stays as it is.\n"
    );
    for value in listed.values() {
        let (setting, number) = (value.setting(), value.number());
        let _ = write!(text, "\n# {}\n{} = {number}\n", words::about(setting), setting.name());
    }
    text
}

/// Parses a file. The errors are those of all bad lines.
pub fn read(text: &str) -> Result<Vec<Value>, Vec<String>> {
    let (mut values, mut wrong) = (Vec::<(usize, Value)>::new(), Vec::new());
    for (line, number) in text.lines().zip(1..) {
        let line = line.split('#').next().unwrap_or_default().trim();
        if line.is_empty() {
            continue;
        }
        match read_line(line) {
            Err(what) => wrong.push(format!("line {number}: {what}")),
            Ok(value) => {
                let setting = value.setting();
                match values.iter().find(|(_, other)| other.setting() == setting) {
                    None => values.push((number, value)),
                    Some((first, _)) => wrong.push(format!(
                        "line {number}: {} stands in line {first} already",
                        setting.name()
                    )),
                }
            }
        }
    }
    if wrong.is_empty() {
        Ok(values.into_iter().map(|(_, value)| value).collect())
    } else {
        Err(wrong)
    }
}

fn read_line(line: &str) -> Result<Value, String> {
    let Some((name, number)) = line.split_once('=') else {
        return Err(format!("{line:?} is not `name = number`"));
    };
    // TOML allows a key in quotes.
    let name = name.trim();
    let name = name.strip_prefix('"').and_then(|name| name.strip_suffix('"')).unwrap_or(name);
    words::setting(name).and_then(|setting| words::value(setting, number.trim()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use stepwright_protocol::{Setting, Settings};

    #[test]
    fn what_is_written_is_read_back() {
        let mut settings = Settings::new();
        for setting in Setting::ALL {
            settings.set(Value::new(setting, *setting.range().end()).unwrap());
        }
        let text = write(&Listed::all(settings), "a board");
        assert!(text.contains("(1 to 20 µs, default 2)\npulse-us = 20\n"), "{text}");
        let mut back = Settings::new();
        for value in read(&text).unwrap() {
            back.set(value);
        }
        assert_eq!(back, settings);
    }

    #[test]
    fn a_file_may_hold_some_and_look_otherwise() {
        let values = read("\n  idle-ms=60_000 # a minute\r\n\"pulse-us\" = 3").unwrap();
        let numbers: Vec<_> = values.iter().map(|value| value.number()).collect();
        assert_eq!(numbers, [60_000, 3]);
        assert_eq!(read("# nothing\n"), Ok(Vec::new()));
    }

    #[test]
    fn every_bad_line_is_reported() {
        let text = "pulse-us = 0\nhold-us = 5\npuls = 3\n[board]\nhold-us = 6\nidle-ms =\n";
        let wrong = read(text).unwrap_err();
        let lines: Vec<_> = wrong.iter().map(|line| &line[..7]).collect();
        assert_eq!(lines, ["line 1:", "line 3:", "line 4:", "line 5:", "line 6:"], "{wrong:#?}");
        assert!(wrong[0].contains("1 to 20 µs") && wrong[3].contains("line 2 already"));
    }
}
