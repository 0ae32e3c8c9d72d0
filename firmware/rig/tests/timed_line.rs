//! The timed driver ordered over the serial line, as by `stepwright timed --port`: the published
//! cases, every drive, timer and end, compared with the virtual board's edges.

use stepwright::drive::Sequence;
use stepwright::drive::sequence::{
    BRIDGE_HALF, L6219_HALF, SHIELD, UNIPOLAR_FULL, UNIPOLAR_HALF, UNIPOLAR_WAVE,
};
use stepwright_protocol::crc;
use stepwright_rig::board::Pin;
use stepwright_rig::{Board, Chip};
use stepwright_sim::timed::{TimedBoard, published};
use stepwright_timed::fit::Hardware;
use stepwright_timed::line::{Line, Report, Wire};
use stepwright_timed::{Code, Control, Model, SetSpeed, Status};

use crate::common::{self, board};

const MILLIS: u64 = 16_000;
/// The longest time for which a query or a check holds off the interrupt, in cycles.
const HELD: u64 = 40;
/// The largest difference between an edge and the virtual board's, in cycles: the time for which
/// the interrupt is held off, and the instruction that it waits for.
const EDGE: u64 = HELD + 8;

fn chip() -> Chip {
    let board = board();
    let image = stepwright_rig::firmware::load(&format!("{}-timed", board.name()));
    let mut chip = Chip::new(board, &image.unwrap_or_else(|error| panic!("{error:#}")));
    common::wake(&mut chip);
    chip
}

#[track_caller]
fn ask(chip: &mut Chip, line: Line) -> String {
    chip.ask(&line.to_string()).unwrap_or_else(|| panic!("{line}: no answer"))
}

#[track_caller]
fn look(chip: &mut Chip, timer: u8) -> Report {
    let answer = ask(chip, Line::Look(timer));
    Report::read(answer.as_bytes()).unwrap_or_else(|| panic!("{answer}"))
}

/// The 16-bit timers.
fn timers() -> &'static [u8] {
    if board() == Board::Uno { &[1] } else { &[1, 3, 4, 5] }
}

fn shield() -> Wire {
    let bits = if board() == Board::Uno { [4, 5] } else { [6, 7] };
    wire('B', SHIELD.on_bits(&bits), &bits, true)
}

fn wire(port: char, sequence: Sequence, bits: &[u8], shield: bool) -> Wire {
    let mask = bits.iter().fold(0, |mask, bit| mask | 1 << bit);
    Wire { port: port as u8, mask, sequence, shield, phase: 0 }
}

/// The levels of the pins of a mask from each change on, all low at first.
fn levels(changes: &[(u64, u8, bool)], bits: &[u8]) -> Vec<(u64, u8)> {
    let (mut all, mut now): (Vec<(u64, u8)>, u8) = (Vec::new(), 0);
    for (time, which, level) in changes {
        let bit = 1 << bits[usize::from(*which)];
        now = if *level { now | bit } else { now & !bit };
        match all.last_mut() {
            Some(last) if last.0 == *time => last.1 = now,
            _ => all.push((*time, now)),
        }
    }
    all
}

/// Gives an order to a board whose pins have not been used yet, waits for its end, and compares
/// every edge with the virtual board's. Returns the largest difference in cycles.
#[track_caller]
fn play(chip: &mut Chip, timer: u8, wire: Wire, order: SetSpeed, latched: bool) -> u64 {
    let bits: Vec<u8> = (0..8).filter(|bit| wire.mask >> bit & 1 != 0).collect();
    let pins: Vec<Pin> = bits.iter().map(|bit| Pin(wire.port as char, *bit)).collect();
    chip.watch_pins(&pins);
    assert_eq!(ask(chip, Line::Wire(timer, wire)), "Y", "{wire:?}");
    assert_eq!(ask(chip, Line::Latched(timer, latched)), "Y");
    assert_eq!(ask(chip, Line::Move(timer, order, 0)), "0", "{order:?}");
    let mut looks = 0;
    while look(chip, timer).moving {
        chip.run_for(100 * MILLIS);
        looks += 1;
        assert!(looks < 500, "it never ends");
    }
    // The windings' current goes off an interval after the last step.
    chip.run_for(100 * MILLIS);
    let model = if latched { Model::Latched } else { Model::Ideal };
    let mut ideal = TimedBoard::new(Hardware::avr16(16_000_000), model, wire.sequence, 0);
    ideal.restore(wire.phase);
    ideal.set_speed(&order);
    while ideal.is_moving() {
        ideal.run_for_millis(100);
    }
    ideal.run_for_millis(100);
    // The current goes on with the order; from the first step on times are compared.
    let first = ideal.steps()[0];
    let wanted: Vec<(u64, u8)> = (ideal.changes().iter())
        .filter(|change| change.time >= first)
        .map(|change| (change.time, change.levels & wire.mask))
        .collect();
    let mut real = levels(chip.watched_changes(), &bits);
    let begin = real.len().saturating_sub(wanted.len());
    real.drain(..begin);
    let only = |all: &[(u64, u8)]| all.iter().map(|(_, levels)| *levels).collect::<Vec<_>>();
    assert_eq!(only(&real), only(&wanted), "{wire:?}");
    let (r0, i0) = (real[0].0, wanted[0].0);
    real.iter().zip(&wanted).map(|(r, w)| (r.0 - r0).abs_diff(w.0 - i0)).max().unwrap()
}

#[test]
fn the_board_says_what_it_is_and_refuses_what_it_is_not() {
    let mut chip = chip();
    let about = chip.ask("?").unwrap();
    let (name, timers) = if board() == Board::Uno { ("uno", "1") } else { ("mega", "1,3,4,5") };
    assert_eq!(
        about,
        format!("stepwright-timed {name} hz=16000000 axes=0 can=sum timers={timers}")
    );
    // The serial line's pins, and pins that the chip does not have.
    let (port, bits) = if board() == Board::Uno { ('D', [0, 1]) } else { ('E', [0, 1]) };
    for (port, bits) in [(port, bits), ('M', [0, 1]), ('@', [0, 1])] {
        let wire = wire(port, SHIELD.on_bits(&bits), &bits, false);
        assert_eq!(ask(&mut chip, Line::Wire(1, wire)), "E pins");
    }
    for (line, answer) in [
        (":?2", "E timer"),
        (":?9", "E timer"),
        ("", "E line"),
        ("PO", "E line"),
        (":M1,128", "E line"),
        ("?1", "E line"),
        ("V1", "E axis"),
        ("I1", "E axis"),
        ("F", "R"),
    ] {
        assert_eq!(chip.ask(line).as_deref(), Some(answer), "{line}");
    }
    // An order without pins would have no effect.
    let fixed = SetSpeed::fixed(Control::DRV_EN, 16_000);
    assert_eq!(ask(&mut chip, Line::Move(1, fixed, 0)), Code::NOT_WIRED.get().to_string());
    assert!(!look(&mut chip, 1).moving);
    assert_eq!(ask(&mut chip, Line::Move(1, SetSpeed::STOP, 0)), "0");
    // A top out of range is refused with its code, and so is a wiring while the motor moves.
    ask(&mut chip, Line::Wire(1, shield()));
    for (top, code) in [(639, "-1"), (0x0400_0000, "-2")] {
        let order = SetSpeed::fixed(Control::DRV_EN, top);
        assert_eq!(ask(&mut chip, Line::Move(1, order, 0)), code);
    }
    assert_eq!(ask(&mut chip, Line::Move(1, SetSpeed::fixed(Control::DRV_EN, 16_000), 0)), "0");
    assert_eq!(ask(&mut chip, Line::Wire(1, shield())), "E busy");
    assert_eq!(ask(&mut chip, Line::Latched(1, true)), "E busy");
    assert_eq!(ask(&mut chip, Line::Move(1, SetSpeed::STOP, 0)), "0");
    assert!(!look(&mut chip, 1).moving);
    // The common lines of every program stop it too.
    for line in ["Z", "K"] {
        let order = SetSpeed::fixed(Control::DRV_EN, 16_000);
        assert_eq!(ask(&mut chip, Line::Move(1, order, 0)), "0");
        assert_eq!(chip.ask("F").as_deref(), Some("B"));
        assert_eq!(chip.ask(line).as_deref(), Some("Y"));
        assert_eq!(chip.ask("F").as_deref(), Some("R"));
    }
}

#[test]
fn the_published_cases_step_as_on_the_virtual_board() {
    for case in [published::CASE_1, published::CASE_2, published::CASE_3] {
        let mut chip = chip();
        let wire = shield();
        ask(&mut chip, Line::Wire(1, wire));
        ask(&mut chip, Line::Latched(1, true));
        let polled = !case.order.control.has(Control::IRQ_TIMING);
        ask(&mut chip, Line::Check(1, if polled { 50 } else { 0 }));
        let bits: &[u8] = if board() == Board::Uno { &[4, 5] } else { &[6, 7] };
        chip.watch_pins(&[Pin('B', bits[0]), Pin('B', bits[1])]);
        assert_eq!(ask(&mut chip, Line::Move(1, case.order, published::CALL_MS)), "0");
        let mut ideal = TimedBoard::new(
            Hardware::avr16(16_000_000),
            Model::Latched,
            SHIELD,
            published::CALL_MS,
        );
        ideal.set_speed(&case.order);
        // The log's times, and ten seconds more.
        let mut last = 0;
        for n in 0..if polled { 100 } else { 40 } {
            chip.run_for(500 * MILLIS);
            let report = look(&mut chip, 1);
            while ideal.millis() < published::CALL_MS + report.ms {
                ideal.run_for_millis(1);
                if polled && (ideal.millis() - published::CALL_MS).is_multiple_of(50) {
                    ideal.update_check(|_| {});
                }
            }
            let dump = ideal.dump();
            let (top, counts) = (report.dump.top, report.dump.counts);
            // A query may come within the millisecond of an update.
            if (top, counts) == (dump.top, dump.counts) {
                assert_eq!(report.dump.time, dump.time, "{n}");
            } else {
                assert!(n > last + 2, "{top} and {}", dump.top);
                last = n;
            }
            assert!(report.dump.steps_left.abs_diff(dump.steps_left) <= 25);
            if !report.moving {
                break;
            }
        }
        let real: Vec<u64> = chip.watched_changes().iter().map(|(time, ..)| *time).collect();
        let steps = ideal.steps();
        let both = real.len().min(steps.len());
        assert!(real.len().abs_diff(steps.len()) <= 25 && both > 40, "{both}");
        let off =
            (0..both).map(|n| (real[n] - real[0]).abs_diff(steps[n] - steps[0])).max().unwrap();
        println!("case: {both} steps, {off} cycles");
        assert!(off <= EDGE, "{off} cycles");
        if polled {
            let report = look(&mut chip, 1);
            assert!(report.reached.is_some() && report.fault.is_none());
            assert!(report.dump.status.has(Status::REACHED.and(Status::REACH_CALLED)));
        }
    }
}

/// A board that is queried all the time checks like one that is left alone, and no edge is late for
/// longer than a query holds off the interrupt.
#[test]
fn questions_hold_neither_a_check_nor_an_edge_up() {
    let case = published::CASE_3;
    for apart in [0, 3] {
        let mut chip = chip();
        ask(&mut chip, Line::Wire(1, shield()));
        ask(&mut chip, Line::Latched(1, true));
        ask(&mut chip, Line::Check(1, 50));
        let bits: &[u8] = if board() == Board::Uno { &[4, 5] } else { &[6, 7] };
        chip.watch_pins(&[Pin('B', bits[0]), Pin('B', bits[1])]);
        assert_eq!(ask(&mut chip, Line::Move(1, case.order, published::CALL_MS)), "0");
        let mut ideal = TimedBoard::new(
            Hardware::avr16(16_000_000),
            Model::Latched,
            SHIELD,
            published::CALL_MS,
        );
        ideal.set_speed(&case.order);
        loop {
            chip.run_for(apart * MILLIS + 777);
            if !look(&mut chip, 1).moving {
                break;
            }
        }
        while ideal.is_moving() {
            ideal.run_for_millis(1);
            if (ideal.millis() - published::CALL_MS).is_multiple_of(50) {
                ideal.update_check(|_| {});
            }
        }
        let real: Vec<u64> = chip.watched_changes().iter().map(|(time, ..)| *time).collect();
        let steps = ideal.steps();
        assert_eq!(real.len(), steps.len());
        let off = real.iter().zip(steps).map(|(r, s)| (r - real[0]).abs_diff(s - steps[0])).max();
        println!("asked every {apart} ms: {off:?} cycles");
        assert!(off <= Some(EDGE), "{off:?} cycles");
        chip.clear_longest_off();
        look(&mut chip, 1);
        let (held, at) = chip.longest_off();
        assert!(held <= HELD, "{held} cycles without interrupts, to {at:#x}");
    }
}

/// On any pins of any port, with each timer.
#[test]
fn every_drive_turns_on_any_pins_by_any_timer() {
    let own = Sequence::new(&[0b0001, 0b0010], 0b0011).unwrap();
    let drives: &[(Sequence, usize)] = &[
        (UNIPOLAR_FULL, 4),
        (UNIPOLAR_WAVE, 4),
        (UNIPOLAR_HALF, 4),
        (BRIDGE_HALF, 4),
        (L6219_HALF, 6),
        (own, 2),
    ];
    // D4, D39, D40, D41 of the Mega, and six others.
    let places: &[(char, [u8; 6])] = match board() {
        Board::Uno => {
            &[('B', [3, 0, 1, 2, 4, 5]), ('C', [0, 1, 2, 3, 4, 5]), ('D', [7, 6, 5, 4, 3, 2])]
        }
        _ => &[('A', [0, 2, 4, 6, 7, 1]), ('K', [7, 6, 5, 4, 3, 2]), ('L', [0, 1, 2, 3, 4, 5])],
    };
    let order = SetSpeed { limit: 37, ..SetSpeed::fixed(Control::DRV_EN, 20_000) };
    for (n, (sequence, lines)) in drives.iter().enumerate() {
        let (port, bits) = places[n % places.len()];
        let timer = timers()[n % timers().len()];
        let bits = &bits[..*lines];
        let wire = wire(port, sequence.on_bits(bits), bits, false);
        for control in [Control::DRV_EN, Control::DRV_EN | Control::DIRECTION] {
            let off = play(&mut chip(), timer, wire, SetSpeed { control, ..order }, false);
            println!("drive {n} on port {port} by timer {timer}: {off} cycles");
            assert!(off <= EDGE, "{off} cycles");
        }
    }
    // Four pins of the Mega that share a port.
    if board() != Board::Uno {
        let bits = [5, 2, 1, 0];
        let wire = wire('G', UNIPOLAR_HALF.on_bits(&bits), &bits, false);
        assert!(play(&mut chip(), 5, wire, order, false) <= EDGE);
    }
}

/// The largest speed: a virtual top of 640, 25,000 steps/s.
#[test]
fn the_highest_rate_is_kept() {
    let order = SetSpeed { limit: 20_000, ..SetSpeed::fixed(Control::DRV_EN, 640) };
    for timer in timers() {
        let mut chip = chip();
        let off = play(&mut chip, *timer, shield(), order, false);
        println!("25,000 steps/s on timer {timer}: {off} cycles");
        assert!(off <= EDGE, "{off} cycles");
    }
}

/// Up to it by updates in the interrupt, each of which takes longer than a step there; and in
/// milliseconds.
#[test]
fn updates_lead_up_to_the_highest_rate_and_milliseconds_end_it() {
    let order = SetSpeed {
        control: Control::DRV_EN
            | Control::SPEED_VARIABLE
            | Control::IRQ_TIMING
            | Control::FASTER
            | Control::ENDPOINT_MILLIS,
        top: 6_400,
        limit: 700,
        modification: 576,
        update_ms: 50,
        mod_counts: 10,
    };
    let mut chip = chip();
    let off = play(&mut chip, 1, shield(), order, false);
    println!("up to 25,000 steps/s, 700 ms: {off} cycles");
    // The update's own step is made in time, the next ones while it is computed.
    assert!(off <= 1_000, "{off} cycles");
    assert_eq!(look(&mut chip, 1).dump.top, 640);
}

/// An update that would lead below 640 is not made: the driver reports a fault, calls back once,
/// and keeps its speed.
#[test]
fn a_fault_is_called_back_once() {
    let mut chip = chip();
    ask(&mut chip, Line::Wire(1, shield()));
    ask(&mut chip, Line::Check(1, 20));
    let order = SetSpeed {
        control: Control::DRV_EN | Control::SPEED_VARIABLE | Control::FASTER,
        top: 2_000,
        limit: 0,
        modification: 600,
        update_ms: 100,
        mod_counts: 5,
    };
    // 2: the updates lead out of the valid range.
    assert_eq!(ask(&mut chip, Line::Move(1, order, 0)), "2");
    chip.run_for(250 * MILLIS);
    let before = look(&mut chip, 1);
    assert_eq!((before.dump.top, before.fault, before.dump.counts), (800, None, 3));
    chip.run_for(200 * MILLIS);
    let report = look(&mut chip, 1);
    let fault = report.fault.expect("no fault");
    assert!((300..=320).contains(&fault), "{fault} ms");
    let status = Status::FAULT.and(Status::FAULT_CALLED).and(Status::SPIN_FIXED);
    assert!(report.dump.status.has(status) && report.moving && report.dump.top == 800);
    chip.run_for(1_000 * MILLIS);
    assert_eq!(look(&mut chip, 1).fault, Some(fault));
    // The next order has its own fault.
    ask(&mut chip, Line::Move(1, SetSpeed::STOP, 0));
    assert_eq!(look(&mut chip, 1).fault, None);
}

/// With checksums, every bit of an order, its end too: it is obeyed as sent, or not at all.
#[test]
fn a_flipped_bit_of_an_order_moves_nothing() {
    let summed = |line: &str| format!("{line}*{:02X}\r", line.bytes().fold(0, crc)).into_bytes();
    let order = SetSpeed { control: Control::DRV_EN, top: 2_000, limit: 0, ..SetSpeed::STOP };
    let order = summed(&Line::Move(1, order, 0).to_string());
    let bits: &[u8] = if board() == Board::Uno { &[4, 5] } else { &[6, 7] };
    let mut chip = chip();
    assert_eq!(ask(&mut chip, Line::Wire(1, wire('B', SHIELD.on_bits(bits), bits, false))), "Y");
    let moves = |chip: &mut Chip, line: &[u8]| {
        chip.send(line);
        chip.run_for(30 * MILLIS);
        // The board may hold half a line.
        chip.ask("");
        // After a common line without a checksum rows need none.
        chip.ask("F");
        let moves = look(chip, 1).moving;
        ask(chip, Line::Move(1, SetSpeed::STOP, 0));
        moves
    };
    assert!(moves(&mut chip, &order));
    for bit in 0..8 * order.len() {
        let mut line = order.clone();
        line[bit / 8] ^= 1 << (bit % 8);
        // A digit of the checksum as a small letter is the same.
        let digit = (order.len() - 3..order.len() - 1).contains(&(bit / 8));
        let same = digit && line.eq_ignore_ascii_case(&order);
        assert_eq!(
            moves(&mut chip, &line),
            same,
            "bit {bit}: {:?}",
            String::from_utf8_lossy(&line)
        );
    }
}

/// Lines that come while an answer is sent are received: three lines at once have three answers.
#[test]
fn a_line_behind_another_is_not_lost() {
    let mut chip = chip();
    chip.send(b"#\r?\rF\r");
    chip.run_for(40 * MILLIS);
    let said = String::from_utf8(chip.take_said()).unwrap();
    let (first, rest) = said.split_once('\r').unwrap();
    assert!(
        first == "E line" && rest.starts_with("stepwright-timed ") && rest.ends_with("\rR\r"),
        "{said:?}"
    );
}
