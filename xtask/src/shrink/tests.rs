//! Random functions do the same before and after: what they store, and what they leave.
//!
//! The instructions are carried out by an interpreter of its own, by the chip's instruction set
//! manual; it knows nothing of what the passes think of an instruction.
//!
//! What a pass does with some lines is tested beside the pass, by `left`.

use std::collections::HashMap;

use super::asm::{Code, Line, Program};
use super::machine::Taken;
use super::{bases, branches, copies, flow, renames, routines, selects, shrink, truths};

/// A chip: registers, flags, and 256 bytes of memory.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Chip {
    r: [u8; 32],
    c: bool,
    z: bool,
    n: bool,
    v: bool,
    memory: Vec<u8>,
    stack: Vec<u8>,
    stores: Vec<(usize, u8)>,
}

impl Chip {
    fn word(&self, low: usize) -> u16 {
        u16::from_le_bytes([self.r[low], self.r[low + 1]])
    }

    fn set_word(&mut self, low: usize, word: u16) {
        [self.r[low], self.r[low + 1]] = word.to_le_bytes();
    }

    fn sign(&mut self, value: u8) {
        (self.z, self.n) = (value == 0, value > 127);
    }

    fn logic(&mut self, to: usize, value: u8) {
        self.r[to] = value;
        self.v = false;
        self.sign(value);
    }

    fn add(&mut self, to: usize, b: u8, carry: bool) {
        let a = self.r[to];
        let sum = u16::from(a) + u16::from(b) + u16::from(carry);
        let value = sum as u8;
        self.c = sum > 255;
        self.v = (a ^ value) & (b ^ value) & 128 != 0;
        self.sign(value);
        self.r[to] = value;
    }

    /// What is left of a difference; with a borrow the zero flag stays clear once it is.
    fn less(&mut self, a: u8, b: u8, carry: Option<bool>) -> u8 {
        let old = self.z;
        let rest = i16::from(a) - i16::from(b) - i16::from(carry.unwrap_or(false));
        let value = rest as u8;
        self.c = rest < 0;
        self.v = (a ^ b) & (a ^ value) & 128 != 0;
        self.sign(value);
        self.z &= carry.is_none() || old;
        value
    }

    fn shift(&mut self, to: usize, value: u8, carry: bool) {
        self.r[to] = value;
        self.c = carry;
        self.sign(value);
        self.v = self.n != self.c;
    }

    /// The place in memory of a pointer, with what is changed.
    fn place(&mut self, text: &str) -> usize {
        let low = match text.trim_start_matches('-').as_bytes()[0] {
            b'X' => 26,
            b'Y' => 28,
            _ => 30,
        };
        if text.starts_with('-') {
            let word = self.word(low).wrapping_sub(1);
            self.set_word(low, word);
        }
        let more = text.split_once('+').map_or("", |(_, more)| more);
        let place = self.word(low).wrapping_add(more.parse().unwrap_or(0));
        if text.ends_with('+') {
            let word = self.word(low).wrapping_add(1);
            self.set_word(low, word);
        }
        usize::from(place) % self.memory.len()
    }

    fn store(&mut self, at: usize, value: u8) {
        self.memory[at] = value;
        self.stores.push((at, value));
    }

    /// Carries an instruction out. Where it branches, if it does.
    fn step(&mut self, code: &Code) -> Option<String> {
        let (a, b) = code.operands.split_once(", ").unwrap_or((&code.operands, ""));
        let register = |text: &str| text.strip_prefix('r').and_then(|n| n.parse::<usize>().ok());
        let (to, from) = (register(a).unwrap_or(0), register(b).unwrap_or(0));
        let number = address(b) as u8;
        let (x, y, c) = (self.r[to], self.r[from], self.c);
        let branch = |taken: bool| taken.then(|| code.operands.clone());
        match &*code.name {
            "mov" => self.r[to] = y,
            "movw" => self.set_word(to, self.word(from)),
            "ldi" => self.r[to] = number,
            "clr" => self.logic(to, 0),
            "eor" => self.logic(to, x ^ y),
            "and" => self.logic(to, x & y),
            "or" => self.logic(to, x | y),
            "andi" => self.logic(to, x & number),
            "ori" => self.logic(to, x | number),
            "tst" => self.logic(to, x),
            "inc" => {
                self.logic(to, x.wrapping_add(1));
                self.v = x == 127;
            }
            "dec" => {
                self.logic(to, x.wrapping_sub(1));
                self.v = x == 128;
            }
            "swap" => self.r[to] = x.rotate_left(4),
            "com" => {
                self.logic(to, !x);
                self.c = true;
            }
            "neg" => self.r[to] = self.less(0, x, None),
            "add" => self.add(to, y, false),
            "adc" => self.add(to, y, c),
            "lsl" => self.add(to, x, false),
            "rol" => self.add(to, x, c),
            "lsr" => self.shift(to, x >> 1, x & 1 != 0),
            "ror" => self.shift(to, x >> 1 | u8::from(c) << 7, x & 1 != 0),
            "asr" => self.shift(to, x >> 1 | x & 128, x & 1 != 0),
            "sub" => self.r[to] = self.less(x, y, None),
            "sbc" => self.r[to] = self.less(x, y, Some(c)),
            "subi" => self.r[to] = self.less(x, number, None),
            "sbci" => self.r[to] = self.less(x, number, Some(c)),
            "cp" => drop(self.less(x, y, None)),
            "cpc" => drop(self.less(x, y, Some(c))),
            "cpi" => drop(self.less(x, number, None)),
            "adiw" | "sbiw" => {
                let old = self.word(to);
                let more = u16::from(number);
                let up = code.name == "adiw";
                let word = if up { old.wrapping_add(more) } else { old.wrapping_sub(more) };
                self.c = if up { word < old } else { word > old };
                self.v = (if up { !old & word } else { old & !word }) >> 15 != 0;
                (self.z, self.n) = (word == 0, word >> 15 != 0);
                self.set_word(to, word);
            }
            "mul" => {
                let product = u16::from(x) * u16::from(y);
                self.set_word(0, product);
                (self.z, self.c) = (product == 0, product >> 15 != 0);
            }
            "ld" | "ldd" => {
                let at = self.place(b);
                self.r[to] = self.memory[at];
            }
            "st" | "std" => {
                let at = self.place(a);
                self.store(at, y);
            }
            "lds" => self.r[to] = self.memory[usize::from(number)],
            "sts" => self.store(address(a) as usize, y),
            "push" => self.stack.push(x),
            "pop" => self.r[to] = self.stack.pop().expect("something pushed"),
            "breq" => return branch(self.z),
            "brne" => return branch(!self.z),
            "brlo" | "brcs" => return branch(self.c),
            "brsh" | "brcc" => return branch(!self.c),
            "brmi" => return branch(self.n),
            "brpl" => return branch(!self.n),
            "brlt" => return branch(self.n != self.v),
            "brge" => return branch(self.n == self.v),
            "rjmp" => return branch(true),
            name => panic!("{name}?"),
        }
        None
    }

    /// Runs a function of a program to its `ret`.
    fn run(&mut self, functions: &HashMap<String, Vec<Line>>, name: &str) {
        let lines = &functions[name];
        let mut at = 0;
        for _ in 0..10_000 {
            if let Line::Code(code) = &lines[at] {
                match &*code.name {
                    "ret" => return,
                    "call" => self.run(functions, &code.operands),
                    "jmp" => return self.run(functions, &code.operands),
                    _ => {
                        if let Some(label) = self.step(code) {
                            let label = Line::Label(label);
                            at = lines.iter().position(|line| *line == label).expect("a label");
                        }
                    }
                }
            }
            at += 1;
        }
        panic!("no end");
    }

    /// What a caller may look at.
    fn seen(mut self) -> Chip {
        for lost in [0, 26, 27, 30, 31] {
            self.r[lost] = 0;
        }
        (self.c, self.z, self.n, self.v) = (false, false, false, false);
        self
    }
}

/// A number, a place behind the symbol M, which is 0, or a half of one.
fn address(text: &str) -> i16 {
    let place = |text: &str| text.strip_prefix("M+").unwrap_or(text).parse().unwrap_or(0);
    match (text.strip_prefix("lo8("), text.strip_prefix("hi8(")) {
        (Some(low), _) => place(low.trim_end_matches(')')) & 255,
        (_, Some(high)) => place(high.trim_end_matches(')')) >> 8,
        _ => place(text),
    }
}

/// Numbers of no meaning.
struct Random(u64);

impl Random {
    fn below(&mut self, limit: usize) -> usize {
        self.0 ^= self.0 << 13;
        self.0 ^= self.0 >> 7;
        self.0 ^= self.0 << 17;
        (self.0 >> 33) as usize % limit
    }

    fn of<'a>(&mut self, all: &[&'a str]) -> &'a str {
        all[self.below(all.len())]
    }

    /// A register of few, so that they meet.
    fn register(&mut self) -> usize {
        [2, 3, 4, 5, 16, 17, 18, 19, 20, 21, 24, 25, 26, 27, 30, 31][self.below(16)]
    }

    fn high(&mut self) -> usize {
        self.register() | 16
    }

    fn pair(&mut self) -> usize {
        self.register() & !1
    }

    fn number(&mut self) -> usize {
        [0, 0, 1, 1, 2, 255, self.below(256)][self.below(7)]
    }

    /// An instruction, or some that the compiler writes together.
    fn instructions(&mut self, label: &mut usize, to: &mut Vec<String>) {
        let (a, b) = (self.register(), self.register());
        let (h, n) = (self.high(), self.number());
        let (p, q) = (self.pair(), self.pair());
        let line = match self.below(26) {
            0..4 => format!("mov r{a}, r{b}"),
            4..8 => format!("movw r{p}, r{q}"),
            8..10 => format!("ldi r{h}, {n}"),
            10 => format!("mov r{a}, r1"),
            11 => format!("clr r{a}"),
            12 => {
                format!("{} r{a}, r{b}", self.of(&["and", "or", "eor", "add", "sub", "adc", "sbc"]))
            }
            13 => format!("{} r{h}, {n}", self.of(&["andi", "ori", "subi", "sbci", "cpi"])),
            14 => format!(
                "{} r{a}",
                self.of(&[
                    "inc", "dec", "swap", "com", "neg", "lsl", "lsr", "ror", "rol", "asr", "tst"
                ])
            ),
            15 => format!(
                "{} r{}, {}",
                self.of(&["adiw", "sbiw"]),
                [24, 26, 30][self.below(3)],
                self.below(64)
            ),
            16 => format!("{} r{a}, r{b}", self.of(&["cp", "cpc"])),
            17 => format!("{} r{a}, {}", self.of(&["ldd", "ldd"]), self.of(&["Z+1", "Z+2", "Y+1"])),
            18 => format!("std {}, r{a}", self.of(&["Z+1", "Z+2", "Y+1"])),
            19 => {
                to.push(format!("mul r{a}, r{b}"));
                to.push(format!("mov r{h}, {}", self.of(&["r0", "r1"])));
                "clr r1".into()
            }
            // A condition as a byte, asked at once or later.
            20 | 21 => {
                let name = self.of(&["brlo", "breq", "brne", "brsh", "brmi", "brge"]);
                *label += 1;
                to.push(format!("ldi r{h}, 1"));
                to.push(format!("cp r{a}, r{b}"));
                to.push(format!("{name} .LBB0_{label}"));
                to.push(format!("mov r{h}, r1"));
                to.push(format!(".LBB0_{label}:"));
                if self.below(2) == 0 {
                    to.push(format!("movw r{p}, r{q}"));
                }
                format!("{} r{h}, {}", self.of(&["cpi", "andi"]), self.below(2))
            }
            23 => {
                for _ in 0..1 + self.below(5) {
                    let (at, r) = (self.below(90), self.register());
                    to.push(match self.below(2) {
                        0 => format!("lds r{r}, M+{at}"),
                        _ => format!("sts M+{at}, r{r}"),
                    });
                }
                return;
            }
            // A choice of 16 bits.
            22 => {
                for _ in 0..2 {
                    *label += 1;
                    let (p, q) = (self.pair(), self.pair());
                    to.push(format!("cpi r{h}, 0"));
                    to.push(format!("brne .LBB0_{label}"));
                    to.push(format!("movw r{p}, r{q}"));
                    to.push(format!(".LBB0_{label}:"));
                }
                return;
            }
            _ => {
                to.push(format!("or r{a}, r{b}"));
                to.push(format!("cp r{a}, r1"));
                format!("cpc r{h}, r1")
            }
        };
        to.push(line);
    }

    /// A function: forward branches, and a loop that ends.
    fn function(&mut self) -> String {
        let mut label = 0;
        let blocks = 2 + self.below(5);
        let mut lines = Vec::new();
        for block in 0..blocks {
            lines.push(format!(".LBB1_{block}:"));
            for _ in 0..self.below(9) {
                self.instructions(&mut label, &mut lines);
            }
            let to = block + 1 + self.below(blocks - block);
            let branch =
                self.of(&["breq", "brne", "brlo", "brsh", "brmi", "brpl", "brlt", "brge", "rjmp"]);
            match self.below(4) {
                0 => lines.push(format!("{branch} .LBB1_{to}")),
                1 => {
                    // As LLVM branches far.
                    lines.push(format!("{branch} .LBB2_{block}"));
                    lines.push(format!("rjmp .LBB1_{to}"));
                    lines.push(format!(".LBB2_{block}:"));
                }
                2 => {
                    // r6 is nobody else's.
                    lines.push("dec r6".into());
                    lines.push(format!("brmi .LBB2_{block}"));
                    lines.push(format!("rjmp .LBB1_{}", self.below(block + 1)));
                    lines.push(format!(".LBB2_{block}:"));
                }
                _ => {}
            }
        }
        lines.push(format!(".LBB1_{blocks}:"));
        lines.push("ret".into());
        let body: String = lines
            .iter()
            .map(
                |line| {
                    if line.ends_with(':') { format!("{line}\n") } else { format!("\t{line}\n") }
                },
            )
            .collect();
        format!("\t.type\tf,@function\nf:\n{body}.Lfunc_end0:\n")
    }
}

/// All functions of a program, as text says.
fn functions(program: &Program) -> HashMap<String, Vec<Line>> {
    let mut all: HashMap<String, Vec<Line>> = HashMap::new();
    let mut name = String::new();
    for line in program.to_string().lines().map(str::trim) {
        if let Some(label) = line.strip_suffix(':') {
            if !label.starts_with('.') {
                name = label.into();
            }
            all.entry(name.clone()).or_default().push(Line::Label(label.into()));
        } else if !line.is_empty() && !line.starts_with('.') {
            all.entry(name.clone()).or_default().push(Line::Code(Code::parse(line)));
        }
    }
    all
}

/// A function does the same before and after.
fn same(text: &str, random: &mut Random) {
    let before = functions(&Program::parse(text));
    let mut program = Program::parse(text);
    let taken = flow::taken(&mut program);
    for _ in 0..2 {
        copies::leave_out(&mut program, &taken);
        truths::branch(&mut program, &taken);
        selects::join(&mut program, &taken);
        renames::leave_out(&mut program, &taken);
        bases::reach(&mut program, &taken);
    }
    routines::share(&mut program);
    branches::turn(&mut program);
    let after = functions(&program);
    for _ in 0..20 {
        let mut chip = Chip {
            r: std::array::from_fn(|_| random.number() as u8),
            c: false,
            z: false,
            n: false,
            v: false,
            memory: (0..256).map(|_| random.number() as u8).collect(),
            stack: Vec::new(),
            stores: Vec::new(),
        };
        chip.r[1] = 0;
        chip.r[6] %= 8;
        let mut other = chip.clone();
        chip.run(&before, "f");
        other.run(&after, "f");
        assert_eq!(chip.seen(), other.seen(), "{text}\nbecame\n{program}");
    }
}

#[test]
fn random_functions_do_the_same_before_and_after() {
    let mut random = Random(0x9E37_79B9_7F4A_7C15);
    for _ in 0..300 {
        let text = random.function();
        same(&text, &mut random);
    }
}

/// What a pass leaves of these instructions, without labels; `.L7` is a return behind them.
pub(super) fn left(body: &str, pass: impl Fn(&mut Program, &Taken)) -> String {
    let body = body.replace("; ", "\n\t");
    let text = format!("\t.type\tf,@function\nf:\n\t{body}\n.L7:\n\tret\n.Lfunc_end0:\n");
    let mut program = Program::parse(&text);
    let taken = flow::taken(&mut program);
    pass(&mut program, &taken);
    let function = program.functions_mut().next().expect("a function");
    let code: Vec<String> = function
        .code()
        .map(|(_, code)| format!("{} {}", code.name, code.operands).trim().into())
        .collect();
    let code = code.join("; ");
    code.strip_suffix("; ret").unwrap_or(&code).into()
}

#[test]
fn what_a_person_wrote_goes_through_all_passes_as_it_is() {
    const REPEATED: &str = "\tldi\tr16, 1\n\tldi\tr16, 1\n";
    // The compiler's own lines here all become less.
    let with = |mark: &str| {
        let twice = format!("\tpush\tr16\n{REPEATED}");
        let branch = "\tbreq\t.L1\n\trjmp\t.L2\n.L1:\n";
        let bytes = "\tlds\tr24, M\n\tlds\tr25, M+1\n\tsts\tM+2, r24\n";
        format!("{twice}{branch}{mark}{bytes}.L2:\n\tpop\tr16\n\tret\t\n")
    };
    let made_smaller = |body: &str| {
        let section = "\t.section\t.text.f,\"ax\",@progbits";
        shrink(&format!("{section}\n\t.type\tf,@function\nf:\n{body}.Lfunc_end0:\n"))
    };
    for mark in ["\treti\t\n", ".Ltmp3:\n", ".Lsw_go:\n", "again:\n"] {
        let small = made_smaller(&with(mark));
        assert!(small.contains(&with(mark)), "{small}");
    }
    // In a function of the compiler's only what stands between these is a person's.
    let mark = format!("\t;APP\n{REPEATED}\t;NO_APP\n");
    let small = made_smaller(&with(&mark));
    assert!(small.contains(&mark), "{small}");
    for gone in ["rjmp", "lds"] {
        assert!(!small.contains(gone), "{gone} in {small}");
    }
    assert_eq!(small.matches(REPEATED).count(), 1, "{small}");
}
