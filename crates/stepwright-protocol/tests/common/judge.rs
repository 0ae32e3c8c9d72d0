//! The expected effect of a line, derived from the log of lines.
//!
//! The judge has no state machine: it derives each answer from the log of exact lines alone, as a
//! person with a listing would. So it shares no code, and no mistake, with the slave.

use crate::common::Bench;

/// The number of axes of the board.
pub const AXES: usize = 3;

/// A line that was answered.
pub struct Entry {
    pub line: String,
    pub answer: String,
    /// The busy axes before the line.
    pub busy: [bool; AXES],
    /// The positions of the axes before the line, where known.
    pub position: [Option<i64>; AXES],
    /// The starts that the machine was asked for, in words.
    pub asked: Vec<String>,
    /// The requested changes of travels in progress, in words.
    pub changed: Vec<String>,
    /// Whether the machine refused them.
    pub refused: bool,
}

impl Entry {
    /// An entry with the state of the bench before the next line.
    pub fn before(bench: &Bench) -> Entry {
        Entry {
            line: String::new(),
            answer: String::new(),
            busy: std::array::from_fn(|n| bench.axes[n].running.is_some()),
            position: std::array::from_fn(|n| {
                (!bench.axes[n].uncertain).then_some(bench.axes[n].position)
            }),
            asked: Vec::new(),
            changed: Vec::new(),
            refused: false,
        }
    }
}

/// A line for the log. A line that is too long or not UTF-8 is stored as another invalid line.
pub fn exact(line: &[u8]) -> String {
    match std::str::from_utf8(line) {
        Ok(line) if line.len() <= 24 => line.into(),
        _ => "neither".into(),
    }
}

/// The remainder of these bytes, followed by eight zeros, by x⁸ + x² + x + 1.
pub fn remainder(bytes: &[u8]) -> u8 {
    let bits = bytes.iter().chain(&[0]).flat_map(|byte| (0..8).rev().map(move |n| byte >> n & 1));
    bits.fold(0u16, |rest, bit| {
        let next = rest * 2 + u16::from(bit);
        if next > 0xFF { next ^ 0x107 } else { next }
    }) as u8
}

/// The log's entry for a line with a wrong checksum.
const WRONG: &str = "wrong sum";

/// A line for the log without its checksum, and whether its answer needs one.
pub fn unsummed(line: &[u8]) -> (String, bool) {
    if line.len() > 27 || !line.contains(&b'*') {
        return (exact(line), false);
    }
    let (bare, tail) = line.split_at(line.len().saturating_sub(3));
    let sum = format!("*{:02x}", remainder(bare));
    let right = tail.to_ascii_lowercase() == sum.as_bytes();
    // An empty line gets a master in step; with a checksum it is a bad line.
    let line = match (right, bare) {
        (false, _) => WRONG.into(),
        (true, []) => "neither".into(),
        (true, bare) => exact(bare),
    };
    (line, true)
}

/// An answer without the reason of the last refusal, which the judge does not derive.
pub fn comparable(answer: &str) -> String {
    let words = answer.split(' ').filter(|word| !word.starts_with("last="));
    words.collect::<Vec<_>>().join(" ")
}

fn number(digits: &str, from: u64, to: u64) -> Option<u64> {
    if digits.is_empty() || !digits.bytes().all(|b| b.is_ascii_digit()) {
        return None;
    }
    digits.parse().ok().filter(|n| (from..=to).contains(n))
}

fn signed(text: &str) -> Option<i64> {
    let n = number(text.get(1..)?, 0, 1 << 31)? as i64;
    match &text[..1] {
        "+" if n < 1 << 31 => Some(n),
        "-" => Some(-n),
        _ => None,
    }
}

/// The new target of an @ line.
fn target(line: &str) -> Option<i64> {
    line.strip_prefix('@').and_then(signed)
}

/// The letter of a line that sets a motion parameter, and the number.
fn setting(line: &str) -> Option<(char, u64)> {
    let letter = line.chars().next()?;
    let (from, to) = match letter {
        'S' | 'T' | 'R' => (1, 999),
        's' => (0, 1_000_000),
        't' => (1, 1_000_000),
        'a' | 'd' => (1, 100_000_000),
        'j' => (0, 4_000_000_000),
        _ => return None,
    };
    Some((letter, number(&line[1..], from, to)?))
}

/// The settings of a board, their ranges and their defaults.
const BOARD: [(&str, u64, u64, u64); 27] = [
    ("max-speed", 1, 1_000_000, 1_000_000),
    ("max-accel", 1, 100_000_000, 100_000_000),
    ("idle-ms", 0, 3_600_000, 0),
    ("ahead-x", 0, 1_000_000_000, 0),
    ("ahead-y", 0, 1_000_000_000, 0),
    ("ahead-z", 0, 1_000_000_000, 0),
    ("behind-x", 0, 1_000_000_000, 0),
    ("behind-y", 0, 1_000_000_000, 0),
    ("behind-z", 0, 1_000_000_000, 0),
    ("timeout-ms", 0, 60_000, 0),
    ("enable-ms", 0, 1000, 1),
    ("setup-us", 0, 1000, 1),
    ("hold-us", 0, 1000, 1),
    ("pulse-us", 1, 20, 2),
    ("reverse", 0, 7, 0),
    ("enable-high", 0, 1, 0),
    ("switches", 0, 7, 0),
    ("switch-forward", 0, 7, 0),
    ("switch-high", 0, 7, 0),
    ("debounce-ms", 0, 250, 25),
    ("law", 0, 1, 1),
    ("safe-start", 0, 1, 0),
    ("home-first", 0, 1, 0),
    ("estop", 0, 2, 0),
    ("driver-fault", 0, 2, 0),
    ("kill-off", 0, 1, 0),
    ("soft-limits", 0, 7, 0),
];

/// A line that sets a board setting: its index and the value.
fn board_setting(line: &str) -> Option<(usize, u64)> {
    let (name, n) = line.strip_prefix('$')?.split_once('=')?;
    let which = BOARD.iter().position(|(known, ..)| *known == name)?;
    Some((which, number(n, BOARD[which].1, BOARD[which].2)?))
}

/// Whether a setting that is 0 or 1 is 1 at the end of this log.
fn is_on(log: &[Entry], name: &str) -> bool {
    let which = BOARD.iter().position(|(known, ..)| *known == name).unwrap();
    board_setting_now(log, which).ends_with("=1")
}

/// Setting `which` of the board at the end of this log, as the slave answers it.
fn board_setting_now(log: &[Entry], which: usize) -> String {
    let taken = log.iter().rev().filter(|entry| entry.answer == "Y");
    let value = taken.into_iter().find_map(|entry| match board_setting(&entry.line) {
        Some((other, n)) if other == which => Some(n),
        _ => (entry.line == "$reset").then_some(BOARD[which].3),
    });
    format!("{}={}", BOARD[which].0, value.unwrap_or(BOARD[which].3))
}

/// The answer to a line that begins with `$`.
fn should_answer_dollar(log: &[Entry], now: &Entry) -> String {
    let idle = now.busy.iter().all(|busy| !busy);
    let name = &now.line[1..];
    if name.is_empty() {
        let all: Vec<_> = (0..BOARD.len()).map(|n| board_setting_now(log, n)).collect();
        all.join(" ")
    } else if let Some(which) = BOARD.iter().position(|(known, ..)| *known == name) {
        board_setting_now(log, which)
    } else if idle && (name == "reset" || board_setting(&now.line).is_some()) {
        "Y".into()
    } else {
        "E".into()
    }
}

/// The travel of a G or g line, in words.
fn travel(line: &str) -> Option<String> {
    match line {
        "g+" => Some("forward".into()),
        "g-" => Some("backward".into()),
        _ => Some(format!("{:+}", signed(line.strip_prefix('G')?)?)),
    }
}

/// The axes that `A0` … `A3` selects.
fn selection(line: &str) -> Option<Vec<usize>> {
    match number(line.strip_prefix('A')?, 0, AXES as u64)? {
        0 => Some((0..AXES).collect()),
        n => Some(vec![n as usize - 1]),
    }
}

/// The milliseconds of a lease.
fn lease(line: &str) -> Option<u64> {
    number(line.strip_prefix('L')?, 0, 60_000)
}

fn own_axis(line: &str, letter: char) -> Option<usize> {
    Some(number(line.strip_prefix(letter)?, 1, AXES as u64)? as usize - 1)
}

fn opens(entry: &Entry) -> bool {
    matches!(entry.line.as_str(), "PO" | "P0") && entry.answer == "Y"
}

/// The axes that a line after this log addresses.
fn selected(log: &[Entry]) -> Vec<usize> {
    let Some(named) = log.iter().rposition(|entry| selection(&entry.line).is_some()) else {
        return vec![0];
    };
    let (mut axes, later) = (selection(&log[named].line).unwrap(), &log[named..]);
    match later.iter().filter(|entry| opens(entry)).count() {
        0 => {}
        1 if nameless(log) && !axes.contains(&0) => axes.insert(0, 0),
        1 if nameless(log) => {}
        _ => axes = vec![0],
    }
    axes
}

/// Whether one PO has come after an A that named axes other than axis 1, before an E carried out an
/// order for them.
fn nameless(log: &[Entry]) -> bool {
    let Some(named) = log.iter().rposition(|entry| selection(&entry.line).is_some()) else {
        return false;
    };
    let later = &log[named..];
    let Some(order) = later.iter().position(opens) else { return false };
    let used = later[..order].iter().any(|entry| entry.line == "E" && entry.answer == "Y");
    let again = later[order + 1..].iter().any(opens);
    selection(&log[named].line) != Some(vec![0]) && !used && !again
}

/// Whether a line sets or moves the selected axes.
fn addresses(line: &str) -> bool {
    let target = target(line).is_some();
    target || setting(line).is_some() || travel(line).is_some()
}

/// The index of the PO of the order that is open at the end of this log.
fn open(log: &[Entry]) -> Option<usize> {
    let po = log.iter().rposition(opens)?;
    let done = log[po..].iter().any(|entry| entry.line == "E" && entry.answer == "Y");
    (!done).then_some(po)
}

/// The settings of an axis at the end of this log, in words.
fn settings(log: &[Entry], axis: usize) -> String {
    let taken: Vec<(char, u64)> = (0..log.len())
        .filter(|&n| log[n].answer == "Y" && selected(&log[..n]).contains(&axis))
        .filter_map(|n| setting(&log[n].line))
        .collect();
    let last = |letters: &str| taken.iter().rposition(|(letter, _)| letters.contains(*letter));
    let speed = |letters: &str, initial: u64| match last(letters) {
        Some(n) if taken[n].0.is_uppercase() => taken[n].1 * 10,
        Some(n) => taken[n].1,
        None => initial,
    };
    let ramp = |own: char| match last(&format!("R{own}")) {
        Some(n) if taken[n].0 != 'R' => format!("{}/s2", taken[n].1),
        Some(n) => format!("R{}", taken[n].1),
        None => "R200".into(),
    };
    format!("{}-{} {} {}", speed("Ss", 50), speed("Tt", 1000), ramp('a'), ramp('d'))
}

/// The jerk of an axis at the end of this log, in words: PO resets it.
fn jerk(log: &[Entry], axis: usize) -> String {
    let since = log.iter().rposition(opens).unwrap_or(0);
    let taken = (since..log.len())
        .filter(|&n| log[n].answer == "Y" && selected(&log[..n]).contains(&axis))
        .filter_map(|n| setting(&log[n].line).filter(|(letter, _)| *letter == 'j'))
        .map(|(_, n)| n);
    match taken.fold(None, |_, n| Some(n)) {
        Some(n) if n != 0 => format!(" {n}/s3"),
        _ => String::new(),
    }
}

/// Whether the board's settings allow these parameters of an axis, in words.
fn allowed(log: &[Entry], words: &str) -> bool {
    let limit = |which| board_setting_now(log, which).split_once('=').unwrap().1.parse().unwrap();
    let (speeds, ramps) = words.split_once(' ').unwrap();
    let (start, top) = speeds.split_once('-').unwrap();
    let (start, top): (u64, u64) = (start.parse().unwrap(), top.parse().unwrap());
    let (max_speed, max_accel): (u64, u64) = (limit(0), limit(1));
    let gentle = |ramp: &str| match ramp.strip_prefix('R') {
        None => ramp.strip_suffix("/s2").unwrap().parse::<u64>().unwrap() <= max_accel,
        Some(_) if top <= start || max_accel == 100_000_000 => true,
        Some(n) => top * top - start * start <= 2 * n.parse::<u64>().unwrap() * max_accel,
    };
    top <= max_speed && ramps.split(' ').all(gentle)
}

/// Whether a K without a later `!` keeps orders from starting.
fn locked(log: &[Entry]) -> bool {
    errors(log).contains('K') && is_on(log, "safe-start")
}

/// Whether this axis has to be homed before it may travel to a target.
fn lost(log: &[Entry], now: &Entry, axis: usize) -> bool {
    now.position[axis].is_none() && is_on(log, "home-first")
}

/// The letters of the errors at the end of this log.
fn errors(log: &[Entry]) -> String {
    let since = log.iter().rposition(|entry| entry.line == "!").map_or(0, |n| n + 1);
    let came = |line| log[since..].iter().any(|entry| entry.line == line);
    let letters: String = [("K", 'K'), (WRONG, 'c')]
        .iter()
        .filter(|(line, _)| came(*line))
        .map(|(_, c)| *c)
        .collect();
    if letters.is_empty() { "-".into() } else { letters }
}

/// The start that the last line of the log should have caused, in words.
pub fn should_start(log: &[Entry]) -> Option<String> {
    let (entry, before) = log.split_last()?;
    let mut staged: [Option<String>; AXES] = Default::default();
    match (entry.line.as_str(), open(before)) {
        ("E", Some(po)) => {
            for n in po + 1..before.len() {
                let Entry { line, answer, .. } = &before[n];
                if line == "K" || answer == "E" {
                    return None; // spoiled
                }
                if let Some(travel) = travel(line) {
                    for axis in selected(&before[..n]) {
                        staged[axis] = Some(travel.clone());
                    }
                }
            }
        }
        ("g+" | "g-", None) if !nameless(before) => {
            for axis in selected(before) {
                staged[axis] = travel(&entry.line);
            }
        }
        _ => return None,
    }
    let mut orders = Vec::new();
    for (axis, travel) in staged.iter().enumerate() {
        let Some(travel) = travel else { continue };
        if entry.busy[axis] {
            return None;
        }
        let (settings, jerk) = (settings(before, axis), jerk(before, axis));
        let curves = is_on(before, "law");
        if !allowed(before, &settings) || !jerk.is_empty() && !curves {
            return None;
        }
        if locked(before) || signed(travel).is_some() && lost(before, entry, axis) {
            return None;
        }
        orders.push(format!("{} {settings}{jerk} {travel}", axis + 1));
    }
    (!orders.is_empty()).then(|| orders.join("; "))
}

/// The changes of travels in progress that the last line of the log should have caused, in words.
pub fn should_change(log: &[Entry]) -> Option<String> {
    let (entry, before) = log.split_last()?;
    let line = entry.line.as_str();
    if nameless(before) {
        return None;
    }
    let mut axes = selected(before);
    let what = if let Some(steps) = target(line) {
        if axes.iter().any(|axis| !entry.busy[*axis] || lost(before, entry, *axis)) {
            return None;
        }
        if locked(before) {
            return None;
        }
        format!("@{steps:+}")
    } else {
        let (letter, n) = setting(line).filter(|(letter, _)| "tad".contains(*letter))?;
        axes.retain(|axis| entry.busy[*axis]);
        let limit = board_setting_now(before, usize::from(letter != 't'));
        let allowed = n <= limit.split_once('=').unwrap().1.parse().unwrap();
        if axes.is_empty() || open(before).is_some() || !allowed {
            return None;
        }
        format!("{letter}{n}")
    };
    let named: Vec<_> = axes.iter().map(|axis| (axis + 1).to_string()).collect();
    Some(format!("change {}: {what}", named.join(" ")))
}

/// The expected answer to the last line of the log.
pub fn should_answer(log: &[Entry]) -> String {
    let (entry, before) = log.split_last().unwrap();
    let line = entry.line.as_str();
    let yes = |yes: bool| if yes { "Y" } else { "E" }.to_string();
    let idle = || selected(before).iter().all(|axis| !entry.busy[*axis]);
    if addresses(line) && nameless(before) {
        return yes(false);
    }
    if should_start(log).is_some() || should_change(log).is_some() {
        return yes(!entry.refused);
    }
    match line {
        "PO" | "P0" => yes(idle()),
        "F" => if idle() { "R" } else { "B" }.into(),
        "Z" | "K" | "!" => yes(true),
        "?" => should_tell(before, entry),
        _ if line.starts_with('$') => should_answer_dollar(before, entry),
        _ if setting(line).is_some() => yes(idle()),
        _ if travel(line).is_some() => yes(open(before).is_some() && idle()),
        _ if selection(line).is_some() || lease(line).is_some() => yes(true),
        _ => {
            if let Some(axis) = own_axis(line, 'I') {
                yes(!entry.busy[axis])
            } else if let Some(axis) = own_axis(line, 'V') {
                entry.position[axis].map_or("E".into(), |steps| steps.to_string())
            } else {
                yes(false)
            }
        }
    }
}

/// The letters of the stops at the end of this log: for each axis the first Z or the last K since
/// the axis was last started, retargeted or cleared.
fn stops(log: &[Entry]) -> String {
    let letter = |axis: usize| {
        let fate = |n: usize| {
            let (entry, before) = (&log[n], &log[..n]);
            let selected = selected(before).contains(&axis);
            match entry.line.as_str() {
                "K" if entry.busy[axis] => Some('K'),
                "Z" if entry.busy[axis] && selected => Some('Z'),
                "!" => Some('-'),
                _ if entry.answer != "Y" => None,
                line if line.starts_with('@') && selected => Some('-'),
                _ => {
                    let orders = should_start(&log[..=n])?;
                    let number = format!("{} ", axis + 1);
                    orders.split("; ").any(|order| order.starts_with(&number)).then_some('-')
                }
            }
        };
        (0..log.len()).rev().find_map(fate).unwrap_or('-')
    };
    (0..AXES).map(letter).collect()
}

/// The expected answer to a `?` at the end of this log.
fn should_tell(log: &[Entry], now: &Entry) -> String {
    let since = log.iter().rposition(|entry| entry.line == "!").map_or(0, |n| n + 1);
    let refused = log[since..].iter().filter(|e| e.answer == "E" && !e.line.is_empty()).count();
    let uncertain: u8 = (0..AXES).map(|n| u8::from(now.position[n].is_none()) << n).sum();
    format!(
        "stepwright 0.1 axes={AXES} max=120000 late=0 refused={refused} uncertain={uncertain} \
         stop={} errors={} can=jerk,safety,sum closed=0",
        stops(log),
        errors(log)
    )
}
