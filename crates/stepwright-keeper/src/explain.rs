//! The meaning of the lines between a host and a board, for a person who reads along.

use stepwright_protocol::{Command, Form, Reply};

use crate::report::Exchange;

/// A line and its answer, explained.
pub fn explain(time: f64, line: &str, answer: Option<&str>) -> Exchange {
    let (bare, means) = meaning(line);
    let command = Command::parse(bare.as_bytes()).ok();
    Exchange {
        time,
        line: line.to_owned(),
        means,
        answer: answer.map(str::to_owned),
        answer_means: answer.map_or("no answer".to_owned(), answer_meaning),
        question: command.is_some_and(asks),
    }
}

/// Whether a line asks, or selects the axis of the next question.
fn asks(command: Command) -> bool {
    matches!(command, Command::Status | Command::Position(_) | Command::Info | Command::Select(_))
}

/// Removes the checksum: `*` and two digits.
fn without_sum(line: &str) -> &str {
    line.split('*').next().unwrap_or_default()
}

fn meaning(line: &str) -> (&str, String) {
    let bare = without_sum(line);
    let means = match Form::of(bare.as_bytes()) {
        _ if bare.is_empty() => "an empty line, to get in step",
        Some(form) => form.help(),
        None => "no line of the protocol",
    };
    (bare, means.to_owned())
}

fn answer_meaning(answer: &str) -> String {
    match Reply::parse(without_sum(answer).as_bytes()) {
        Some(Reply::Yes) => "accepted".to_owned(),
        Some(Reply::No) => "refused: nothing has changed".to_owned(),
        Some(Reply::Ready) => "at rest".to_owned(),
        Some(Reply::Busy) => "on its way".to_owned(),
        Some(Reply::Position(steps)) => format!("at {steps} steps"),
        Some(Reply::Info(info)) => match info.last {
            Some(last) => format!("what the board is; refused last: {last}"),
            None => "what the board is".to_owned(),
        },
        Some(Reply::Setting(value)) => {
            format!("{} {}", value.number(), value.setting().unit()).trim_end().to_owned()
        }
        Some(Reply::Settings(_)) => "all settings and their numbers".to_owned(),
        None => "damaged on its way".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_line_is_explained() {
        for (line, answer, means, answer_means, question) in [
            ("G+4000*0B", Some("Y*88"), "travel by this many steps", "accepted", false),
            ("V1", Some("-12"), "the position of this axis", "at -12 steps", true),
            ("F", Some("B"), "are the selected axes ready", "on its way", true),
            ("K", None, "stops all axes at once", "no answer", false),
            ("$pulse-us=3", Some("E"), "sets this setting", "refused", false),
            ("$pulse-us", Some("pulse-us=3"), "this setting", "3 µs", false),
            ("x", Some("~"), "no line of the protocol", "damaged on its way", false),
            ("", Some("E"), "an empty line", "refused", false),
        ] {
            let said = explain(1.5, line, answer);
            assert!(said.means.starts_with(means), "{said:?}");
            assert!(said.answer_means.starts_with(answer_means), "{said:?}");
            assert_eq!((said.question, said.line.as_str()), (question, line));
        }
    }
}
