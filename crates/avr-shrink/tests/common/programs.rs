//! Random programs in the form that LLVM writes: functions with frames, saved registers, arguments
//! on the stack, skips, branches far and near, calls of each other, and an interrupt handler.

use super::Random;

/// The function that is run, and the interrupt handler.
pub const MAIN: &str = "main";
pub const HANDLER: &str = "__vector_1";

/// Branches.
const BRANCHES: [&str; 10] =
    ["breq", "brne", "brlo", "brsh", "brmi", "brpl", "brlt", "brge", "brts", "brtc"];
/// Moves the stack pointer to a pair of registers.
fn moves(low: usize) -> [String; 5] {
    let port = |port: u8, register: usize| format!("out {port}, r{register}");
    ["in r0, 63".into(), "cli".into(), port(62, low + 1), "out 63, r0".into(), port(61, low)]
}

/// A function that may be called.
#[derive(Clone)]
struct Callee {
    name: String,
    /// The bytes of its arguments on the stack.
    takes: usize,
}

/// A program.
pub fn program(random: &mut Random) -> String {
    let (mut text, mut callees) = (String::new(), Vec::new());
    // The last one first: each calls those after it.
    for number in (0..2 + random.below(3)).rev() {
        let name = if number == 0 { MAIN.into() } else { format!("_Rf{number}") };
        let one = function(random, &name, number, 0, &callees);
        text.insert_str(0, &one.0);
        callees.push(one.1);
    }
    let (below, called) = function(random, "_Rh", 8, 64, &[]);
    text + &below + &handler(&called.name)
}

/// A handler with C's convention, which calls a function.
fn handler(called: &str) -> String {
    let kept: Vec<usize> = [0, 1].into_iter().chain(18..28).chain([30, 31]).collect();
    let mut out = String::from("\t.section\t.text.v,\"ax\",@progbits\n");
    out += &format!("\t.type\t{HANDLER},@function\n{HANDLER}:\n");
    let mut emit = |text: String| out += &format!("\t{text}\n");
    kept.iter().for_each(|register| emit(format!("push r{register}")));
    ["in r0, 63", "push r0", "clr r1"].into_iter().for_each(|text| emit(text.into()));
    // It sets its own arguments: the interrupted function's registers may hold anything.
    (18..26).for_each(|register| emit(format!("ldi r{register}, {}", 3 * register)));
    emit(format!("call {called}"));
    ["pop r0", "out 63, r0"].into_iter().for_each(|text| emit(text.into()));
    kept.iter().rev().for_each(|register| emit(format!("pop r{register}")));
    emit("reti".into());
    out + ".Lfunc_end_v:\n"
}

/// A function with its memory from `base` on, and its description for callers.
fn function(
    random: &mut Random,
    name: &str,
    number: usize,
    base: usize,
    callees: &[Callee],
) -> (String, Callee) {
    let lowest = random.of(&[2, 6, 8, 12, 14, 16]);
    // It saves nothing, some registers, or all of them and has a frame.
    let kind = random.below(3);
    let saved: Vec<usize> = match kind {
        0 => Vec::new(),
        1 => (lowest..18).chain([28, 29]).filter(|_| !random.one_in(3)).collect(),
        // Some omit a register, which LLVM does not use then.
        _ => {
            let gap = if random.one_in(4) { 17 - random.below(2) } else { 0 };
            (lowest..18).chain([28, 29]).filter(|&register| register != gap).collect()
        }
    };
    let any = 1 + random.below(8);
    let frame = if kind == 2 { random.of(&[2, 2, 4, any]) } else { 0 };
    let takes = if kind == 2 && base == 0 && random.one_in(3) { 2 } else { 0 };
    let ends = name != MAIN || !random.one_in(5);
    let mut registers: Vec<usize> = saved.iter().copied().filter(|&one| one < 28).collect();
    registers.extend((18..28).chain([30, 31, 24, 25]));
    let mut maker = Maker { random, out: Vec::new(), labels: 0, number, registers, base, frame };
    maker.begin(&saved);
    // Arguments on the stack are above the frame, the registers and the return address.
    for n in 1..=takes {
        maker.emit(format!("ldd r24, Y+{}", frame + saved.len() + 2 + n));
        maker.emit(format!("sts M+{}, r24", base + n));
    }
    maker.blocks(callees);
    if ends {
        maker.end(&saved);
    } else {
        let label = maker.label();
        maker.out.push(format!("{label}:"));
        maker.emit(format!("rjmp {label}"));
    }
    let lines = maker.out.join("\n");
    let section = format!("\t.section\t.text.{name},\"ax\",@progbits\n\t.type\t{name},@function\n");
    let text = format!("{section}{name}:\n{lines}\n.Lfunc_end{number}:\n");
    (text, Callee { name: name.into(), takes })
}

struct Maker<'a> {
    random: &'a mut Random,
    out: Vec<String>,
    labels: usize,
    number: usize,
    /// The registers that it may use.
    registers: Vec<usize>,
    base: usize,
    frame: usize,
}

impl Maker<'_> {
    fn emit(&mut self, text: impl Into<String>) {
        self.out.push(format!("\t{}", text.into()));
    }

    fn label(&mut self) -> String {
        self.labels += 1;
        format!(".LBB{}_{}", self.number, self.labels)
    }

    fn begin(&mut self, saved: &[usize]) {
        saved.iter().for_each(|register| self.emit(format!("push r{register}")));
        if self.frame > 0 {
            self.emit("in r28, 61");
            self.emit("in r29, 62");
            self.emit(format!("sbiw r28, {}", self.frame));
            moves(28).into_iter().for_each(|text| self.emit(text));
        }
        self.forget();
        // Nothing of the caller is read.
        let pointer = self.frame > 0;
        for &register in saved.iter().filter(|&&register| register < 28 || !pointer) {
            self.emit(format!("mov r{register}, r24"));
        }
        for at in 1..=self.frame {
            self.emit(format!("std Y+{at}, r22"));
        }
    }

    fn end(&mut self, saved: &[usize]) {
        if self.frame > 0 {
            self.emit(format!("adiw r28, {}", self.frame));
            moves(28).into_iter().for_each(|text| self.emit(text));
        }
        saved.iter().rev().for_each(|register| self.emit(format!("pop r{register}")));
        self.emit("ret");
    }

    /// Gives a value to registers and flags that a call may have changed.
    fn forget(&mut self) {
        for register in [26, 27, 30, 31] {
            let byte = self.random.byte();
            self.emit(format!("ldi r{register}, {byte}"));
        }
        self.emit("cp r24, r24");
        self.emit("clt");
    }

    fn blocks(&mut self, callees: &[Callee]) {
        let count = 1 + self.random.below(4);
        let labels: Vec<String> = (0..=count).map(|_| self.label()).collect();
        for block in 0..count {
            self.out.push(format!("{}:", labels[block]));
            for _ in 0..self.random.below(9) {
                match self.random.below(6) {
                    0 if !callees.is_empty() => self.call(callees),
                    1 => self.phrase(),
                    _ => self.instruction(),
                }
            }
            let to = &labels[block + 1 + self.random.below(count - block)];
            let branch = self.random.of(&BRANCHES);
            match self.random.below(4) {
                0 => self.emit(format!("{branch} {to}")),
                1 => self.emit(format!("rjmp {to}")),
                2 => {
                    // A far branch, as LLVM writes it.
                    let near = self.label();
                    self.emit(format!("{branch} {near}"));
                    self.emit(format!("rjmp {to}"));
                    self.out.push(format!("{near}:"));
                }
                _ => {}
            }
        }
        self.out.push(format!("{}:", labels[count]));
    }

    /// A call, preceded by arguments that other calls have too.
    fn call(&mut self, callees: &[Callee]) {
        let callee = callees[self.random.below(callees.len())].clone();
        if callee.takes > 0 {
            self.emit("in r30, 61");
            self.emit("in r31, 62");
            self.emit(format!("sbiw r30, {}", callee.takes));
            moves(30).into_iter().for_each(|text| self.emit(text));
            for n in 1..=callee.takes {
                let register = self.random.of(&[20, 24, 25]);
                self.emit(format!("std Z+{n}, r{register}"));
            }
        }
        for _ in 0..self.random.below(3) {
            let text = self.random.of(&["movw r24, r20", "movw r22, r18", "ldi r20, 1", "clr r21"]);
            self.emit(text);
        }
        if self.random.one_in(4) && callee.takes == 0 {
            let over = self.random.of(&["sbrc r20, 0", "cpse r18, r19"]);
            self.emit(over);
        }
        self.emit(format!("call {}", callee.name));
        if callee.takes > 0 {
            self.emit("in r30, 61");
            self.emit("in r31, 62");
            self.emit(format!("adiw r30, {}", callee.takes));
            moves(30).into_iter().for_each(|text| self.emit(text));
        }
        self.forget();
    }

    /// Instructions that occur in many places.
    fn phrase(&mut self) {
        let at = self.base + self.random.of(&[4, 9]);
        let phrases = [
            format!("lds r24, M+{at}; lds r25, M+{}; adiw r24, 1; sts M+{at}, r24", at + 1),
            format!("mul r24, r25; mov r20, r0; mov r21, r1; clr r1; sts M+{at}, r21"),
            // A 16-bit number whose high byte comes from a product.
            format!("mul r20, r24; mov r19, r1; clr r1; cp r18, r1; cpc r19, r1; sts M+{at}, r19"),
            "lsl r24; rol r25; subi r24, 3; sbci r25, 0".into(),
            "bst r24, 3; bld r20, 1; eor r21, r20".into(),
            "sbiw r24, 3; cp r24, r1; cpc r25, r1".into(),
            "sub r22, r18; sbc r23, r19; cp r22, r1; cpc r23, r1".into(),
            // The zero flag is that of both bytes, the sign that of the difference.
            "sub r22, r18; sbc r23, r19; cpi r23, 0".into(),
            "subi r24, 3; cpi r24, 0".into(),
            // Pairs that are not compared with 0, or not always.
            "cp r18, r20; cpc r19, r1".into(),
            "cp r18, r1; cpc r21, r1".into(),
            "sbrc r20, 0; cp r24, r1; cpc r25, r1".into(),
        ];
        let phrase = match self.random.below(phrases.len() + 3) {
            condition if condition >= phrases.len() => return self.condition(),
            number => phrases[number].clone(),
        };
        phrase.split("; ").for_each(|text| self.emit(text));
        if self.random.one_in(3) {
            let over = self.label();
            let branch = self.random.of(&["brne", "brne", "brlt"]);
            self.emit(format!("{branch} {over}"));
            self.simple();
            self.out.push(format!("{over}:"));
        }
    }

    /// A condition that is made a byte, and tested by a branch, or two.
    fn condition(&mut self) {
        let [a, b, byte] = [self.register(), self.register(), 18 + self.random.below(8)];
        let (made, first, second) = (self.label(), self.label(), self.label());
        self.emit(format!("ldi r{byte}, 1"));
        let compare = self.random.of(&["cp", "sub"]);
        self.emit(format!("{compare} r{a}, r{b}"));
        let branch = self.random.of(&BRANCHES[..8]);
        if self.random.one_in(8) {
            self.emit(format!("sbrc r{b}, 0"));
        }
        self.emit(format!("{branch} {made}"));
        self.emit(format!("mov r{byte}, r1"));
        self.out.push(format!("{made}:"));
        // The flags may be others then.
        if self.random.one_in(4) {
            self.simple();
        }
        let ask = self.random.of(&["cpi r{}, 0", "tst r{}", "andi r{}, 1"]);
        self.emit(ask.replace("{}", &byte.to_string()));
        for label in [first, second] {
            let branch = self.random.of(&["brne", "breq"]);
            self.emit(format!("{branch} {label}"));
            if self.random.one_in(4) {
                self.simple();
            } else {
                let register = self.register();
                self.emit(format!("mov r{register}, r24"));
            }
            self.out.push(format!("{label}:"));
            if self.random.one_in(3) {
                return;
            }
        }
        // Most often the byte is not read again.
        if !self.random.one_in(3) {
            self.emit(format!("mov r{byte}, r1"));
            self.emit("cp r24, r25");
        }
    }

    fn register(&mut self) -> usize {
        self.registers[self.random.below(self.registers.len())]
    }

    fn high(&mut self) -> usize {
        self.register().max(16)
    }

    /// Both registers of a usable pair.
    fn pair(&mut self) -> usize {
        loop {
            let low = self.register() & !1;
            if self.registers.contains(&low) && self.registers.contains(&(low + 1)) {
                return low;
            }
        }
    }

    /// One instruction that computes.
    fn simple(&mut self) {
        let (a, b, byte) = (self.register(), self.register(), self.random.byte());
        let high = self.registers[self.registers.len() - 1 - self.random.below(8)];
        let text = match self.random.below(5) {
            0 => format!("mov r{a}, r{b}"),
            1 => format!("ldi r{high}, {byte}"),
            2 => format!("add r{a}, r{b}"),
            3 => format!("inc r{a}"),
            _ => format!("sbc r{a}, r{b}"),
        };
        self.emit(text);
    }

    /// An instruction, or several that belong together.
    fn instruction(&mut self) {
        const TWO: [&str; 9] = ["and", "or", "eor", "add", "sub", "adc", "sbc", "cp", "cpc"];
        const NUMBER: [&str; 5] = ["andi", "ori", "subi", "sbci", "cpi"];
        const ONE: [&str; 11] =
            ["inc", "dec", "swap", "com", "neg", "lsl", "lsr", "ror", "rol", "asr", "tst"];
        let (a, b) = (self.register(), self.register());
        let (p, q) = (self.pair(), self.pair());
        let (byte, bit) = (self.random.byte(), self.random.below(8));
        let at = self.base + self.random.below(60);
        let text = match self.random.below(16) {
            0 => format!("movw r{p}, r{q}"),
            1 => format!("mov r{a}, r1"),
            2 | 3 => format!("{} r{a}, r{b}", self.random.of(&TWO)),
            4 => format!("{} r{}, {byte}", self.random.of(&NUMBER), self.high_own()),
            5 => format!("{} r{a}", self.random.of(&ONE)),
            6 => {
                format!("{} r{}, {}", self.random.of(&["adiw", "sbiw"]), [24, 26, 30][bit % 3], at)
            }
            7 => format!("lds r{a}, M+{at}"),
            8 | 9 => format!("sts M+{at}, r{a}"),
            10 => {
                self.emit(format!("ldi r30, {}", at));
                self.emit("ldi r31, 0");
                self.random.of(&["ldd r24, Z+2", "std Z+3, r25", "st Z+, r20", "ld r21, Z"]).into()
            }
            11 if self.frame > 0 => format!("std Y+{}, r{a}", 1 + bit % self.frame),
            12 if self.frame > 0 => format!("ldd r{a}, Y+{}", 1 + bit % self.frame),
            13 => {
                let skip = [format!("sbrc r{a}, {bit}"), format!("cpse r{a}, r{b}")];
                self.emit(skip[bit % 2].clone());
                return self.simple();
            }
            14 => {
                let over = self.label();
                self.emit(format!("sbrs r{a}, {bit}"));
                self.emit(format!("rjmp {over}"));
                self.simple();
                self.out.push(format!("{over}:"));
                return;
            }
            15 => {
                let by_hand =
                    ["nop".into(), format!("mov r{a}, r{b}"), format!("sts M+{at}, r{a}")];
                format!(";APP\n\t{}\n\t;NO_APP", by_hand[bit % 3])
            }
            _ => return self.simple(),
        };
        self.emit(text);
    }

    /// A register that accepts a constant.
    fn high_own(&mut self) -> usize {
        let register = self.high();
        if self.registers.contains(&register) { register } else { 24 }
    }
}
