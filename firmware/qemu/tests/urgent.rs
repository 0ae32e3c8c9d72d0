//! A program's own interrupt that is more urgent than the step interrupt waits neither for the main
//! loop nor for a visit of the step interrupt.
//!
//! Two measurements. The shipped controller: the longest sequence of instructions in which all
//! interrupts are masked. And a program with such an interrupt, from its own timer, at random
//! moments: from the request to where its handler reads that timer, including the way into the
//! handler.

use std::env;
use std::fs;

use stepwright_qemu::boards::{CONTROLLERS, NRF51, VIRT};
use stepwright_qemu::machine::symbol;
use stepwright_qemu::{Machine, Pace, Simulated};

/// The instructions that it may wait.
const MOST: f64 = 100.0;

/// Orders for one axis and for three, with ramps throughout.
const ORDERS: [&str; 3] = [
    "PO s0 t4000 a4000 d4000 G+4000 E",
    "PO s0 t4000 a3000 d3000 j20000 G-4000 E",
    "PO s0 t2000 a2000 d2000 G+1900 A2 s0 t1900 a1900 d1900 G-1800 A3 s0 t1800 a1800 d1800 G+1700 E",
];

/// Makes a program carry out the orders, queries it continuously, and returns the output of the
/// plugin.
fn carry_out(
    board: &'static Simulated,
    program: &str,
    task: &str,
    words: &[&str],
) -> Vec<(u64, String)> {
    let name = format!("stepwright-{program}-{}-{}", board.name, std::process::id());
    let out = env::temp_dir().join(name);
    let task = format!("{task},out={}", out.display());
    let mut chip = Machine::watched(board, program, Pace::Chip, &task, words).unwrap();
    for order in ORDERS {
        for line in order.split_whitespace() {
            let answer = chip.ask(line).unwrap();
            assert_eq!(answer, "Y", "{}, {line}: {}", board.name, chip.ask("?").unwrap());
        }
        // It queries until all axes rest.
        chip.rest().unwrap();
    }
    for (line, position) in [("V1", "1900"), ("V2", "-1800"), ("V3", "1700")] {
        assert_eq!(chip.ask(line).unwrap(), position, "{}, {line}", board.name);
    }
    let health = chip.ask("?").unwrap();
    assert!(health.contains(" late=0 "), "{}: {health}", board.name);
    drop(chip);
    let text = fs::read_to_string(&out).unwrap();
    fs::remove_file(&out).unwrap();
    let read = |line: &str| {
        let (number, rest) = line.split_once(' ').unwrap_or((line, ""));
        (number.parse().unwrap(), rest.to_owned())
    };
    text.lines().map(read).collect()
}

/// A RISC-V's traps begin masked, a Cortex-M's don't.
#[test]
fn the_controller_never_masks_all_interrupts_for_long() {
    for board in CONTROLLERS {
        let trap =
            symbol(board, "controller", "_start_MachineTimer_trap").map_or(0, |trap| trap.start);
        assert_eq!(trap != 0, std::ptr::eq(board, &VIRT));
        let stretches = carry_out(board, "controller", &format!("trap={trap}"), &[]);
        let (longest, end) = stretches.last().expect("it masks where it fills the engine");
        println!("{}: {longest} instructions, to {end}", board.name);
        assert!(*longest as f64 <= MOST, "{}: {longest} instructions, to {end}", board.name);
    }
}

/// On RISC-V the interrupt may wait for the end of a visit and for the beginning of the next: QEMU
/// 7.2 takes the timer's interrupt first if both are pending, the privileged architecture an
/// external one.
#[test]
fn a_more_urgent_interrupt_does_not_wait() {
    // The units of a wait in a microsecond, and QEMU's option for the clock of its timers.
    for (board, units, words) in
        [(&NRF51, NRF51.mhz(), &[][..]), (&VIRT, 1e3 / 16.0, &["-rtc", "clock=vm"])]
    {
        let told = symbol(board, "urgent", "WAITS").unwrap();
        let task = format!("told={}-{}", told.start, told.start + 1024);
        let mut waits = carry_out(board, "urgent", &task, words);
        // The start-up code clears them, word by word.
        assert!((0..).zip(waits.drain(..256)).all(|(word, (at, _))| at == 4 * word));
        let longest = waits.iter().map(|(wait, _)| *wait).max().unwrap_or(0);
        let (count, longest) = (waits.len(), longest as f64 / units / Pace::Chip.micros());
        println!("{}: {count} waits, the longest {longest:.1} instructions", board.name);
        assert!(count > 10_000, "{}: {count} waits", board.name);
        assert!(longest <= MOST, "{}: {longest:.1} instructions", board.name);
    }
}
