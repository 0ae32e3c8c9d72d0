//! The programs that a board may have in it: which one answers, and what to flash for another.

use crate::failure::Failure;

/// A program by its answer to `?`.
struct Program {
    /// The first word of the answer.
    greeting: &'static str,
    /// What it is.
    what: &'static str,
    /// Its name for `--program`.
    name: &'static str,
    /// What orders it.
    order: &'static str,
}

/// The controller's.
pub const CONTROLLER: &str = "stepwright";

const PROGRAMS: [Program; 4] = [
    Program {
        greeting: CONTROLLER,
        what: "the controller",
        name: "slave",
        order: "stepwright move",
    },
    Program {
        greeting: stepwright_timed::line::NAME,
        what: "the timed driver",
        name: "timed",
        order: "stepwright timed",
    },
    Program {
        greeting: stepwright_austin::line::NAME,
        what: "Austin's laws",
        name: "laws",
        order: "stepwright move --law",
    },
    Program {
        greeting: "stepwright-cycle",
        what: "motor cycles",
        name: "cycle",
        order: "stepwright cycle",
    },
];

/// Whether this answer to `?` is of the program that is wanted, by its greeting; `None` if it is
/// of no program of ours.
///
/// # Errors
/// It is of another one: which, and what to flash.
pub fn is_wanted(at: &str, answer: &str, wanted: &str) -> Result<Option<()>, Failure> {
    let greeting = answer.split(' ').next().unwrap_or_default();
    let of = |greeting: &str| PROGRAMS.iter().find(|program| program.greeting == greeting);
    match (of(greeting), of(wanted)) {
        (None, _) => Ok(None),
        (Some(_), _) if greeting == wanted => Ok(Some(())),
        (Some(there), wanted) => {
            let failure = Failure::new(format!(
                "{at} runs {}, which has no such orders: `{} … --port` is for it",
                there.what, there.order
            ));
            Err(match wanted {
                Some(wanted) => failure.hint(flash(answer, wanted.name)),
                None => failure,
            })
        }
    }
}

/// How to get a program onto the board that gave this answer.
pub fn flash(answer: &str, program: &str) -> String {
    let board = answer.split(' ').nth(1).filter(|name| matches!(*name, "uno" | "nano" | "mega"));
    let board = board.unwrap_or("uno");
    format!("flash the other program: `cargo xtask flash {board} --program {program} --port PATH`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn another_program_is_named_with_what_to_flash() {
        assert_eq!(is_wanted("x", "stepwright 0.1 axes=3", CONTROLLER).unwrap(), Some(()));
        assert_eq!(is_wanted("x", "E", CONTROLLER).unwrap(), None);
        for (answer, part) in [
            ("stepwright-timed mega hz=16000000 timers=1,3,4,5", "the timed driver"),
            ("stepwright-laws mega hz=16000000 can=austin", "Austin's laws"),
            ("stepwright-cycle mega", "motor cycles"),
        ] {
            let failure = is_wanted("x", answer, CONTROLLER).unwrap_err();
            assert!(failure.message().contains(part), "{failure:?}");
            assert!(format!("{failure:?}").contains("flash mega --program slave"), "{failure:?}");
        }
    }
}
