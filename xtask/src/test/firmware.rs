//! Builds the firmwares, and checks properties of their code.

use anyhow::{Result, bail, ensure};

use crate::firmware::{Board, Build, Built};
use crate::listing::{Listing, symbols};
use crate::program::{CONTROLLER, Program, REFUSED};
use crate::workspace::Workspace;

/// The size that the slave should have in an Uno's flash, in bytes, to leave room for the user's
/// code. It is larger; `docs/benchmarks.md` gives the reasons.
const AIM: u32 = 20_480;
/// The most flash of any program except the slave: all that a Nano's old boot loader leaves.
const FLASH: u32 = 30_720;
/// The most RAM of a program, without its stack.
const RAM: u32 = 1_229;
/// The most RAM of the examples of a user's own firmware: three planners, each with both shapes of a
/// ramp.
const PLANNED: [&str; 3] = ["first-move", "homing", "straight-line"];
const PLANNED_RAM: u32 = 1_304;
/// The most RAM of the controller, whose planner has both shapes of a ramp. A change of three axes
/// takes 505 bytes of stack; the rig's `change` checks that some are left.
const CONTROLLER_RAM: u32 = 1_395;
/// The most RAM of motor cycles over the line.
const CYCLES_RAM: u32 = 1_348;
/// The most RAM of the player of streamed runs, 896 bytes of which hold the waiting runs: as many
/// as leave a stack and some bytes to spare, which the rig's `stream` checks.
const STREAM: &str = "stream";
const STREAM_RAM: u32 = 1_771;
/// The flash that the boot loader of an Uno and of a Nano from 2018 on leaves, for the slave and
/// for programs that are only for an Uno.
const ALONE: u32 = 32_256;

/// The step interrupt's vector on each chip.
const STEP_328P: &str = "__vector_11";
const STEP_2560: &str = "__vector_17";
/// The vector of the timer's overflow, for fast PWM.
const OVERFLOW_328P: &str = "__vector_13";

/// Builds all programs for all boards, and checks them.
pub fn run(ws: &Workspace) -> Result<()> {
    let mut programs = Program::all(ws)?;
    programs.retain(|program| !program.is_test());
    let mut complaints = complaints(ws, &programs)?;
    complaints.extend(refused(ws)?);
    ensure!(complaints.is_empty(), "{}", complaints.join("\n"));
    Ok(())
}

/// The faults of these programs.
fn complaints(ws: &Workspace, programs: &[Program]) -> Result<Vec<String>> {
    let mut complaints = Vec::new();
    for board in [Board::Uno, Board::Nano, Board::Mega] {
        let build = Build { board, timer: 1, bench: false };
        for program in programs.iter().filter(|one| one.fits(&build)) {
            match build.make(ws, program) {
                Ok(built) => {
                    for complaint in look(board, program, &built)? {
                        complaints.push(format!("{}: {complaint}", built.elf.display()));
                    }
                }
                // Continues with the other boards.
                Err(error) => complaints.push(format!("{}: {error:#}", board.name())),
            }
        }
    }
    Ok(complaints)
}

/// Checks that arguments on the stack are refused where the compiler gets them wrong, and only
/// there. Returns the fault.
fn refused(ws: &Workspace) -> Result<Option<String>> {
    let program = Program::named(ws, REFUSED)?;
    let stacked = |board| Build { board, timer: 1, bench: false }.make(ws, &program);
    if let Err(error) = stacked(Board::Uno) {
        return Ok(Some(format!("arguments on the stack are right on an Uno: {error:#}")));
    }
    Ok(match stacked(Board::Mega) {
        Ok(_) => Some("arguments on the stack are not refused for a Mega".into()),
        Err(error) if format!("{error:#}").contains("7stacked") => None,
        Err(error) => Some(format!("not what was refused: {error:#}")),
    })
}

/// The faults of a firmware.
fn look(board: Board, program: &Program, built: &Built) -> Result<Vec<String>> {
    let mut wrong: Vec<String> =
        symbols(&built.elf)?.iter().filter_map(|name| forbidden(name)).collect();
    let listing = Listing::of(&built.elf)?;
    // The step interrupt of motor cycles calls programs and callbacks, and divides near a bound.
    // That of the demo computes Austin's law, which is a division.
    if !program.divides() {
        let vector = match board {
            _ if program.overflows() => OVERFLOW_328P,
            Board::Mega => STEP_2560,
            _ => STEP_328P,
        };
        let reached = listing.reached(vector);
        if reached.is_empty() {
            bail!("{}: there is no {vector}", built.elf.display());
        }
        for name in reached {
            if divides(name) || listing.jumps_anywhere(name) {
                wrong.push(format!("the step interrupt reaches {name}"));
            }
        }
    }
    if board != Board::Mega {
        let everywhere = program.fits(&Build { board: Board::Nano, timer: 1, bench: false });
        let for_new = !everywhere || program.name == CONTROLLER;
        let flash = if for_new { ALONE } else { FLASH };
        let ram = match &*program.name {
            CONTROLLER => CONTROLLER_RAM,
            name if PLANNED.contains(&name) => PLANNED_RAM,
            STREAM => STREAM_RAM,
            _ if program.is_controller() => CYCLES_RAM,
            _ => RAM,
        };
        for (what, used, most) in [("flash", built.flash, flash), ("RAM", built.ram, ram)] {
            if used > most {
                wrong.push(format!("{used} bytes of {what}, and only {most} are allowed"));
            }
        }
        if program.name != CONTROLLER {
            return Ok(wrong);
        }
        let script = include_str!("../../../firmware/avr/build.rs");
        let names = symbols(&built.elf)?;
        wrong.extend(gone(script, &names).map(|part| {
            format!("no symbol has `{part}`, by which firmware/avr/build.rs orders code")
        }));
        if built.flash <= AIM {
            wrong.push(format!(
                "{} bytes of flash: the aim is met, let it be the limit",
                built.flash
            ));
        } else {
            println!("{}: {} bytes of flash, the aim is {AIM}: open", board.name(), built.flash);
        }
    }
    Ok(wrong)
}

/// The parts of symbols in the build script's `ORDER` that occur in none of these names.
fn gone<'a>(script: &'a str, names: &'a [String]) -> impl Iterator<Item = &'a str> {
    let order = script.split_once("const ORDER").and_then(|(_, rest)| rest.split_once("];"));
    let parts = order.map_or("", |(order, _)| order).split('"').skip(1).step_by(2);
    // A part may end in a pattern: `[!9]`.
    let plain = |part: &'a str| part.split_once('[').map_or(part, |(plain, _)| plain);
    parts.filter(move |part| !names.iter().any(|name| name.contains(plain(part))))
}

/// Why a symbol is forbidden.
fn forbidden(name: &str) -> Option<String> {
    let float = name.contains("5float")
        || (name.starts_with("__") && (name.contains("sf") || name.contains("df")));
    if name.contains("panic") {
        Some(format!("it can panic: {name}"))
    } else if float {
        Some(format!("it computes in floats: {name}"))
    } else {
        None
    }
}

/// Whether a function is one of the compiler's divisions.
fn divides(name: &str) -> bool {
    name.contains("div") || ["modqi", "modhi", "modsi", "moddi"].iter().any(|m| name.contains(m))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_function_that_is_ordered_and_gone_is_named() {
        let script =
            "const ORDER: &[&str] = &[\n    \"4plan\", // first\n    \"6device[!9]\",\n];\n\"x\"";
        let names = |names: &[&str]| names.iter().map(|name| name.to_string()).collect::<Vec<_>>();
        let there = names(&["_R4plan", "_R6device7machine"]);
        assert_eq!(gone(script, &there).count(), 0);
        let there = names(&["_R4idea", "_R6device7machine"]);
        assert_eq!(gone(script, &there).collect::<Vec<_>>(), ["4plan"]);
    }

    #[test]
    fn names_tell() {
        assert!(forbidden("_RNvNtCs1_4core9panicking5panic").is_some());
        assert!(forbidden("__addsf3").is_some() && forbidden("__floatundidf").is_some());
        assert!(forbidden("__udivmodsi4").is_none() && forbidden("__vector_11").is_none());
        assert!(divides("__udivmodsi4") && !divides("__mulsi3"));
    }
}
