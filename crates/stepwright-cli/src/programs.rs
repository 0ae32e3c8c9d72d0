//! The programs for boards: which one answers, and what to flash for another.

use crate::failure::Failure;

/// A program, recognized by its answer to `?`.
struct Program {
    /// The first word of the answer.
    greeting: &'static str,
    /// The program's name in messages.
    what: &'static str,
    /// The command for this program.
    order: &'static str,
}

/// The greeting of the controller.
pub const CONTROLLER: &str = "stepwright";

/// The greeting of the program `stream`.
pub const STREAM: &str = "stepwright-stream";

const PROGRAMS: [Program; 5] = [
    Program { greeting: CONTROLLER, what: "the controller", order: "stepwright move" },
    Program {
        greeting: stepwright_timed::line::NAME,
        what: "the timed driver",
        order: "stepwright timed",
    },
    Program {
        greeting: stepwright_austin::line::NAME,
        what: "Austin's laws",
        order: "stepwright move --law",
    },
    Program {
        greeting: stepwright_cycle::line::NAME,
        what: "motor cycles",
        order: "stepwright cycle",
    },
    Program { greeting: STREAM, what: "streamed runs", order: "stepwright gcode" },
];

/// The controller's name for `--program`.
pub const SLAVE: &str = "slave";

/// Whether this answer to `?` is from the program that greets with `wanted`; `None` if it is from
/// no known program.
///
/// # Errors
/// The answer is from another program. The failure names it, and the program to flash, which may
/// depend on the board.
pub fn is_wanted(
    at: &str,
    answer: &str,
    wanted: &str,
    program: impl Fn(&str) -> &'static str,
) -> Result<Option<()>, Failure> {
    let greeting = answer.split(' ').next().unwrap_or_default();
    match PROGRAMS.iter().find(|program| program.greeting == greeting) {
        None => Ok(None),
        Some(_) if greeting == wanted => Ok(Some(())),
        Some(there) => Err(Failure::new(format!(
            "{at} runs {}, which has no such orders: `{} … --port` is for it",
            there.what, there.order
        ))
        .hint(flash(answer, program(answer)))),
    }
}

/// The command to flash a program onto the board that gave this answer.
pub fn flash(answer: &str, program: &str) -> String {
    let board = answer.split(' ').nth(1).filter(|name| matches!(*name, "uno" | "nano" | "mega"));
    let board = board.unwrap_or("uno");
    // The controller is the default of `--program`.
    let program = if program == SLAVE { String::new() } else { format!(" --program {program}") };
    format!("flash the program for it: `stepwright flash {board}{program} --port PATH`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_program_is_named_with_what_to_flash() {
        assert_eq!(
            is_wanted("x", "stepwright 0.1 axes=3", CONTROLLER, |_| SLAVE).unwrap(),
            Some(())
        );
        assert_eq!(is_wanted("x", "E", CONTROLLER, |_| SLAVE).unwrap(), None);
        for (answer, part) in [
            ("stepwright-timed mega hz=16000000 timers=1,3,4,5", "the timed driver"),
            ("stepwright-laws mega hz=16000000 can=austin", "Austin's laws"),
            ("stepwright-cycle mega hz=16000000 axes=4", "motor cycles"),
        ] {
            let failure = is_wanted("x", answer, CONTROLLER, |_| SLAVE).unwrap_err();
            assert!(failure.message().contains(part), "{failure:?}");
            assert!(
                format!("{failure:?}").contains("`stepwright flash mega --port PATH`"),
                "{failure:?}"
            );
        }
    }
}
