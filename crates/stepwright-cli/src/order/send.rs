//! `stepwright send`: sends lines unchanged.

use stepwright_protocol::Form;

use super::target::{self, PortArgs};
use crate::failure::Failure;
use crate::say;
use stepwright_host::link::serial::Share;

/// Send lines of the serial protocol as they are, and print each answer
#[derive(clap::Args)]
#[command(after_help = help())]
pub struct Args {
    #[command(flatten)]
    port: PortArgs,
    /// Lines to send, without CR
    #[arg(required = true, value_name = "LINE", value_parser = line)]
    lines: Vec<String>,
}

/// The help text: all lines of the protocol, and examples.
fn help() -> String {
    let mut help = String::from(
        "Each line is sent with a CR once the line before it has been answered; each answer is
a line on standard output. The exit status is 1 if any answer was E. Quote ? ! and $ for the
shell.

Lines (\u{b1}: + or -):
",
    );
    for form in Form::ALL {
        help += &format!("  {:<19} {}\n", form.to_string(), form.help());
    }
    help + "
Examples:
  stepwright send --port /dev/ttyUSB0 PO S5 T100 R200 G+4000 E
  stepwright send --port /dev/ttyUSB0 F V1 '?'"
}

/// Parses a line; refuses line breaks in it.
fn line(text: &str) -> Result<String, String> {
    if text.contains(['\r', '\n']) {
        return Err("give each line as an argument of its own, without its end".to_owned());
    }
    Ok(text.to_owned())
}

/// Sends the lines one by one.
pub fn run(args: Args) -> Result<(), Failure> {
    let mut session = args.port.meet("send", Share::Alone)?;
    let mut refused = Vec::new();
    for line in &args.lines {
        let answer = session.say(line.as_bytes()).map_err(target::trouble(&mut session))?;
        let Some(answer) = answer else {
            let name = session.link().name();
            return Err(Failure::new(format!("{name}: no answer to {line}"))
                .hint("it may have been carried out all the same: look with `stepwright status`"));
        };
        // If the line has a checksum, so has the answer.
        if answer.split('*').next() == Some("E") {
            refused.push(line.as_str());
        }
        say::result(&answer);
    }
    if refused.is_empty() {
        return Ok(());
    }
    let why = session.why().map_err(target::trouble(&mut session))?;
    let failure = Failure::new(format!("refused: {}", refused.join(" ")));
    let form = refused.last().and_then(|line| Form::of(line.as_bytes()));
    let form = form.map(|form| format!("`{form}`: {}; when: {}", form.help(), form.when()));
    let why = why.map(|why| format!("the reason for the last: {why}"));
    let hints: Vec<_> = why.into_iter().chain(form).collect();
    Err(if hints.is_empty() { failure } else { failure.hint(hints.join("; ")) })
}
