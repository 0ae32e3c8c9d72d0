//! Compares the command over `--port` on a simulated chip with the same command on the virtual
//! board, edge by edge, for every program that moves motors.
//!
//! Positions, answers and other output are tested elsewhere (`firmware/rig/tests`). This step
//! compares only the pins, from a command line to a dump of the chip's pins.

mod chip;
mod cycles;
mod dump;
mod steps;

use std::collections::HashMap;
use std::collections::hash_map::Entry;
use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};

use crate::firmware::{Board, Build};
use crate::program::{CONTROLLER, Program};
use crate::rig;
use crate::workspace::Workspace;
use chip::{Ended, SimChip, command, typed};
use cycles::{PAUSE, homes, worst_of_cycles};
use dump::Dump;
use steps::{Step, first, levels, worst, worst_of_levels, worst_of_runs, worst_of_ways};

/// An order, and its chip.
#[derive(Clone, Copy)]
struct Case {
    board: Board,
    /// The program in its flash.
    program: &'static str,
    /// The arguments of the command.
    words: &'static str,
    how: How,
    /// The largest difference of an edge, in cycles.
    bound: f64,
}

/// The kind of the comparison.
#[derive(Clone, Copy)]
enum How {
    /// The first axes, up to this one, travel to an end.
    Travel(usize),
    /// Axis 1 runs until it is stopped.
    Run,
    /// Axis 1 runs as long as a key is held.
    Jog,
    /// Axis 1 homes with these switches.
    Home(&'static [&'static str]),
    /// The shield's two directions are compared, to the order's end or until the command ends.
    Timed { whole: bool },
    /// The motors of a file, with their STEP and DIR, and the machine's switches.
    Cycles(&'static [[&'static str; 3]], &'static [&'static str]),
    /// Nothing moves, and this message is printed.
    Refused(&'static str),
}

/// The bound of the difference to the virtual board's edge, in cycles: other interrupts, and the
/// entry into the step interrupt.
const ALONE: f64 = 250.0;
/// The bound while other axes move.
const BESIDE: f64 = 1_500.0;
/// The bound with one of Austin's laws.
const LAW: f64 = 40.0;
/// The bound with the timed driver: a query delays its interrupt by up to 40 cycles
/// (`firmware/rig/tests/timed_line.rs`), and the current instruction is finished first.
const TIMED: f64 = 48.0;
/// The bounds in a motor cycle, and while another leg reverses.
const CYCLE: f64 = 1_600.0;
const TURNS: f64 = 6_400.0;

/// STEP and DIR of a CNC shield.
const SHIELD: [[&str; 2]; 3] = [["D2", "D5"], ["D3", "D6"], ["D4", "D7"]];
/// The pins of the motor shield's directions.
const COILS: [&str; 2] = ["D12", "D13"];
const XYZ: &[[&str; 3]] = &[["X", "D2", "D5"], ["Y", "D3", "D6"], ["Z", "D4", "D7"]];
const XY: &[[&str; 3]] = &[XYZ[0], XYZ[1]];
/// `drawing.toml` homes X from 30 mm to its switch at -5 mm, in steps of 12.5 µm.
const DRAWING: How = How::Cycles(XY, &["1:-2800"]);
/// The positions of the switches in `calibrate.toml`, from 50 mm on, in steps of 12.5 µm.
const CALIBRATE: How = How::Cycles(&[["X", "D2", "D5"]], &["1:-3000", "1:13600@D12"]);
const SERIES: How = How::Cycles(
    &[
        ["list", "D2", "D5"],
        ["series", "D3", "D6"],
        ["callback", "D4", "D7"],
        ["bounded", "A0", "A1"],
    ],
    &[],
);

const fn case(
    board: Board,
    program: &'static str,
    words: &'static str,
    how: How,
    bound: f64,
) -> Case {
    Case { board, program, words, how, bound }
}

use Board::{Mega, Uno};
use How::{Cycles, Home, Jog, Refused, Run, Timed, Travel};

const CASES: &[Case] = &[
    case(Uno, CONTROLLER, "move 900 --top-speed 3000 --accel 20000", Travel(1), ALONE),
    case(Uno, CONTROLLER, "move -700 --law trapezoid --decel 4000", Travel(1), ALONE),
    case(Uno, CONTROLLER, "run 2000 --accel 20000 --for 600ms", Run, ALONE),
    case(Uno, CONTROLLER, "line 900 -400 150", Travel(3), BESIDE),
    case(Uno, CONTROLLER, "home --within 3000 --accel 20000", Home(&["1:-1000"]), ALONE),
    case(Uno, CONTROLLER, "jog --accel 20000", Jog, ALONE),
    case(Uno, "laws", "move 700 --law austin --accel 2000 --change 100:500", Travel(1), LAW),
    case(Uno, "laws", "move -700 --law austin-fixed --accel 2000", Travel(1), LAW),
    case(Uno, "laws", "run -900 --law austin --accel 9000 --for 600ms", Run, LAW),
    case(Uno, "transitions", "move 700 --law linear-factor --accel 2000", Travel(1), LAW),
    case(Uno, "transitions", "run 900 --law linear-factor --accel 9000 --for 600ms", Run, LAW),
    case(
        Uno,
        "transitions",
        "move 500 --law piecewise --top-speed 450 --accel 900",
        Travel(1),
        LAW,
    ),
    case(Uno, "power-term", "move -150 --law power --top-speed 95 --accel 200", Travel(1), LAW),
    case(Uno, "cycles", "cycle examples/cycles/readme.toml", Cycles(XYZ, &[]), CYCLE),
    case(Uno, "cycles", "cycle examples/cycles/calibrate.toml", CALIBRATE, CYCLE),
    case(
        Uno,
        "cycles",
        "cycle examples/cycles/triangle.toml",
        Refused("no room for the fixed"),
        0.0,
    ),
    case(Uno, "cycles", "cycle examples/cycles/series.toml", Refused("moves 3 motors"), 0.0),
    case(Uno, "cycles", "cycle examples/cycles/drawing.toml", Refused("no room for homing"), 0.0),
    case(
        Uno,
        "cycles",
        "cycle examples/cycles/feed.toml",
        Refused("no room for lines and arcs"),
        0.0,
    ),
    case(Uno, "timed", "timed --case 1 --latched", Timed { whole: true }, TIMED),
    case(Uno, "timed", "timed --case 2 --latched", Timed { whole: false }, TIMED),
    case(Uno, "timed", "timed --case 3 --latched", Timed { whole: true }, TIMED),
    case(Mega, CONTROLLER, "move 900 --law s-curve --jerk 40000", Travel(1), ALONE),
    case(Mega, CONTROLLER, "line -300 700 500 --accel 1700 --jerk 30000", Travel(3), BESIDE),
    case(Mega, CONTROLLER, "home --within 3000 --slow 90 --jerk 40000", Home(&["1:-1000"]), ALONE),
    case(Mega, CONTROLLER, "jog --top-speed 700 --jerk 200000", Jog, ALONE),
    case(Mega, "laws", "move 500 --law piecewise --top-speed 450 --accel 900", Travel(1), LAW),
    case(Mega, "cycles", "cycle examples/cycles/series.toml", SERIES, TURNS),
    case(Mega, "cycles", "cycle examples/cycles/triangle.toml", Cycles(XYZ, &[]), CYCLE),
    case(Mega, "cycles", "cycle examples/cycles/drawing.toml", DRAWING, TURNS),
    case(Mega, "cycles", "cycle examples/cycles/feed.toml", Cycles(XY, &[]), TURNS),
    case(Mega, "timed", "timed --speed 2000 --steps 4000", Timed { whole: true }, TIMED),
];

/// Orders for another program, and the program to flash for them.
const ELSEWHERE: &[(&str, &str, &str)] = &[
    (CONTROLLER, "move 100 --law austin", "flash uno --program laws"),
    (CONTROLLER, "timed --speed 100 --steps 10", "flash uno --program timed"),
    (CONTROLLER, "cycle examples/cycles/readme.toml", "--program cycles"),
    (CONTROLLER, "run 50 --law power --for 1s", "flash uno --program power-term"),
    ("laws", "move 100", "`stepwright flash uno --port"),
    ("laws", "move 100 --law power --top-speed 50", "flash uno --program power-term"),
    ("laws", "move 100 --law piecewise --top-speed 50", "flash uno --program transitions"),
    ("timed", "line 100 50", "`stepwright flash uno --port"),
    ("timed", "run 100 --law austin --for 1s", "flash uno --program laws"),
    ("cycles", "home --within 3000", "`stepwright flash uno --port"),
    ("cycles", "timed --speed 100 --steps 10", "flash uno --program timed"),
];

/// Runs all cases one after another, and reports all that fail.
pub fn run(ws: &Workspace) -> Result<()> {
    let sim = rig::program(ws, "sim")?;
    ws.shipped()?;
    let mut programs = HashMap::new();
    let mut failed = 0;
    let elsewhere = ELSEWHERE
        .iter()
        .map(|&(program, words, hint)| case(Uno, program, words, Refused(hint), 0.0));
    let cases: Vec<Case> = CASES.iter().copied().chain(elsewhere).collect();
    for case in &cases {
        let key = (case.board.name(), case.program);
        if let Entry::Vacant(place) = programs.entry(key) {
            let build = Build { board: case.board, timer: 1, bench: false };
            place.insert(build.make(ws, &Program::named(ws, case.program)?)?.elf);
        }
        let Case { words, bound, .. } = case;
        let named = format!("{} with {}: stepwright {words}", key.0, key.1);
        match case.play(ws, &sim, &programs[&key]) {
            Ok(_) if matches!(case.how, Refused(_)) => println!("{named}: refused"),
            Ok(Worst { edge, paused }) if edge <= *bound && paused <= PAUSE => {
                println!("{named}: {edge:.0} of {bound} cycles");
            }
            Ok(Worst { edge, paused }) => {
                failed += 1;
                println!(
                    "{named}: {edge:.0} cycles, of {bound}; after a pause {paused:.0} of {PAUSE}"
                );
            }
            Err(error) => {
                failed += 1;
                println!("{named}: {error:#}");
            }
        }
    }
    ensure!(failed == 0, "{failed} of {} are not as on the virtual board", cases.len());
    Ok(())
}

/// The largest differences of edges in cycles.
#[derive(Default)]
struct Worst {
    edge: f64,
    /// The largest difference after a pause.
    paused: f64,
}

impl Case {
    fn play(&self, ws: &Workspace, sim: &Path, elf: &Path) -> Result<Worst> {
        let words: Vec<_> = self.words.split(' ').collect();
        let switches = match self.how {
            Cycles(_, switches) | Home(switches) => switches,
            _ => &[],
        };
        let chip = SimChip::new(ws, sim, self.board, elf, switches)?;
        let port = chip.port().to_owned();
        if let Home(_) = self.how {
            let known = command(ws, &["settings", "set", "--port", &port, "switches=1"])?;
            ensure!(known.status == Some(0), "{}", known.text);
        }
        let ended = self.order(ws, &[&words[..], &["--port", &port]].concat())?;
        let real = chip.end()?;
        if let Refused(why) = self.how {
            ensure!(ended.status == Some(1) && ended.text.contains(why), "{}", ended.text);
            for [step, _] in SHIELD {
                ensure!(real.wire(step)?.is_empty(), "{step} has moved");
            }
            return Ok(Worst::default());
        }
        ensure!(ended.status == Some(0), "on the chip: {}", ended.text);
        self.compare(ws, &words, &real, &ended.text)
    }

    /// Runs the command with these arguments, and with keys if it reads them.
    fn order(&self, ws: &Workspace, words: &[&str]) -> Result<Ended> {
        let Jog = self.how else { return command(ws, words) };
        // Holds → for 1.5 s, then ends.
        let held = ["\x1b[C"; 30];
        typed(ws, words, "q end", &[&held[..], &["q"]].concat())
    }

    /// Compares the chip's dump with the virtual board.
    fn compare(&self, ws: &Workspace, words: &[&str], real: &Dump, said: &str) -> Result<Worst> {
        let file = ws.target.join("ports-virtual.vcd");
        let path = file.to_str().context("a path in UTF-8")?;
        let more: &[&str] = match self.how {
            Cycles(..) => &["--format", "csv"],
            Timed { .. } => &["--drive", "shield", "--board", self.board.name(), "--vcd", path],
            Jog => &["--virtual", "--vcd", path],
            _ => &["--virtual", "--fast", "--vcd", path],
        };
        let ended = self.order(ws, &[words, more].concat())?;
        ensure!(ended.status == Some(0), "on the virtual board: {}", ended.text);
        let ideal = || Dump::read(&file);
        let worst_edge = |edge| Ok(Worst { edge, paused: 0.0 });
        match &self.how {
            Travel(axes) => {
                let (real, ideal) = (wired(real, *axes)?, axes_of(&ideal()?, *axes)?);
                let begun = (first(&real), first(&ideal));
                let mut edge = 0f64;
                for (real, ideal) in real.iter().zip(&ideal) {
                    edge = edge.max(worst(real, ideal, begun)?);
                }
                worst_edge(edge)
            }
            Run | Jog => {
                let (real, ideal) = (wired(real, 1)?, axes_of(&ideal()?, 1)?);
                if let Jog = self.how {
                    for (steps, said) in [(&real[0], said), (&ideal[0], &ended.text)] {
                        ends(said, &format!("position {} ready", steps.len()))?;
                    }
                }
                worst_edge(worst_of_runs(&real[0], &ideal[0], self.bound)?)
            }
            Home(_) => {
                for said in [said, &ended.text] {
                    ends(said, "position 50 ready")?;
                }
                let (real, ideal) = (wired(real, 1)?, axes_of(&ideal()?, 1)?);
                worst_edge(worst_of_ways(&real[0], &ideal[0])?)
            }
            Timed { whole } => {
                let (real, ideal) = (levels(real, &COILS)?, levels(&ideal()?, &COILS)?);
                worst_edge(worst_of_levels(&real, &ideal, *whole)?)
            }
            Cycles(motors, _) => {
                let text = fs::read_to_string(ws.root.join(words[1]))?;
                let real = motors.iter().map(|[_, step, dir]| steps::steps(real, step, dir));
                let real: Vec<_> = real.collect::<Result<_>>()?;
                let names: Vec<_> = motors.iter().map(|[name, ..]| *name).collect();
                let (edge, paused) = worst_of_cycles(&real, &ended.text, &names, &homes(&text))?;
                Ok(Worst { edge, paused })
            }
            Refused(_) => Ok(Worst::default()),
        }
    }
}

/// Checks the last line of a command's output.
fn ends(said: &str, last: &str) -> Result<()> {
    let ended = said.lines().map(str::trim).rfind(|line| !line.is_empty()).unwrap_or_default();
    ensure!(ended.ends_with(last), "it ends {ended:?}, and not {last:?}");
    Ok(())
}

/// The steps of a controller's first axes, from its pins.
fn wired(dump: &Dump, axes: usize) -> Result<Vec<Vec<Step>>> {
    SHIELD[..axes].iter().map(|[step, dir]| steps::steps(dump, step, dir)).collect()
}

/// The steps of a virtual board's first axes.
fn axes_of(dump: &Dump, axes: usize) -> Result<Vec<Vec<Step>>> {
    (1..=axes).map(|n| steps::steps(dump, &format!("step{n}"), &format!("dir{n}"))).collect()
}
