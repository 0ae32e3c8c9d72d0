//! An ATmega328P's instructions, stack, interrupts and cycles.

use std::collections::HashMap;

/// Bytes of memory. Programs use those below [`SEEN`]; the stack is above [`FLOOR`].
const MEMORY: usize = 1024;
/// The memory that is compared.
pub const SEEN: u16 = 128;
/// The lowest address for the stack.
const FLOOR: u16 = 300;
/// The bytes below the stack pointer that an interrupt may overwrite.
const SCRIBBLED: u16 = 24;
/// The return address of a program that has ended.
const END: u16 = 0xFFFF;
/// The most instructions of a program.
const LONGEST: u32 = 60_000;

/// A program in the chip's flash.
pub struct Flash {
    ops: Vec<Op>,
    labels: HashMap<String, usize>,
}

struct Op {
    name: String,
    a: String,
    b: String,
}

impl Flash {
    /// Reads assembly. Sections follow one another: running from one into the next is an error.
    pub fn read(text: &str) -> Flash {
        let (mut ops, mut labels) = (Vec::new(), HashMap::new());
        let op = |name: &str, operands: &str| {
            let (a, b) = operands.split_once(',').unwrap_or((operands, ""));
            Op { name: name.into(), a: a.trim().into(), b: b.trim().into() }
        };
        for line in text.lines() {
            let line = line.split(';').next().unwrap_or("").trim();
            if let Some(label) = line.strip_suffix(':') {
                labels.insert(label.to_string(), ops.len());
            } else if line.starts_with(".section") {
                ops.push(op("end of section", ""));
            } else if !line.is_empty() && !line.starts_with('.') {
                let (name, operands) = line.split_once(char::is_whitespace).unwrap_or((line, ""));
                ops.push(op(name, operands));
            }
        }
        ops.push(op("end of section", ""));
        Flash { ops, labels }
    }
}

/// The times of interrupts.
#[derive(Clone, Copy, Default)]
pub struct Interrupts {
    /// Between any two instructions where an interrupt is possible: it overwrites the bytes below
    /// the stack.
    pub everywhere: bool,
    /// A function that ends in `reti`, run at each n-th store of the other functions.
    pub handler: Option<(&'static str, usize)>,
}

/// Registers, flags and memory.
#[derive(Clone, PartialEq, Eq, Debug)]
pub struct Chip {
    pub r: [u8; 32],
    /// C, Z, N, V, S, H, T, I, as bits 0 to 7 of SREG.
    pub sreg: u8,
    pub sp: u16,
    pub memory: Vec<u8>,
    /// The stores below [`SEEN`], in order.
    pub stores: Vec<(u16, u8)>,
    pub cycles: u32,
    /// The number of calls of each label.
    pub calls: HashMap<String, u32>,
}

const C: u8 = 0;
const Z: u8 = 1;
const N: u8 = 2;
const V: u8 = 3;
const S: u8 = 4;
const H: u8 = 5;
const T: u8 = 6;
const I: u8 = 7;

impl Chip {
    pub fn new() -> Chip {
        Chip {
            r: [0; 32],
            sreg: 1 << I,
            sp: MEMORY as u16 - 33,
            memory: vec![0; MEMORY],
            stores: Vec::new(),
            cycles: 0,
            calls: HashMap::new(),
        }
    }

    /// Runs a function to its return, or to an endless loop. Returns whether it has returned.
    ///
    /// # Errors
    /// An operation that a program must not do.
    pub fn run(&mut self, flash: &Flash, name: &str, when: Interrupts) -> Result<bool, String> {
        let mut pc = *flash.labels.get(name).ok_or_else(|| format!("no label {name}"))?;
        self.call(END)?;
        // After SEI, RETI and a write of SREG one instruction runs before an interrupt.
        let (mut guarded, mut handling, mut stores) = (false, false, 0);
        for _ in 0..LONGEST {
            let op = &flash.ops[pc];
            if self.flag(I) && !guarded {
                if when.everywhere {
                    self.scribble();
                }
                if let Some((handler, _)) = when.handler.filter(|(_, each)| stores >= *each) {
                    (handling, stores) = (true, 0);
                    self.set(I, false);
                    self.call(pc as u16)?;
                    pc = flash.labels[handler];
                    continue;
                }
            }
            guarded = matches!((&*op.name, &*op.a), ("sei" | "reti", _) | ("out", "63"));
            let before = self.stores.len();
            let ends = op.name == "reti";
            match self.step(flash, pc)? {
                Some(to) if to == usize::from(END) => return Ok(true),
                Some(to) if to == pc => return Ok(false),
                Some(to) => pc = to,
                None => pc += 1,
            }
            if !handling {
                stores += self.stores.len() - before;
            }
            handling &= !ends;
        }
        Err("no end".into())
    }

    /// Executes an instruction. Returns the next address, if it is not the following one.
    fn step(&mut self, flash: &Flash, pc: usize) -> Result<Option<usize>, String> {
        let Op { name, a, b } = &flash.ops[pc];
        let (d, s) = (register(a).unwrap_or(0), register(b).unwrap_or(0));
        let (x, y, carry) = (self.r[d], self.r[s], self.flag(C));
        let number = number(b);
        self.cycles += match &**name {
            "adiw" | "sbiw" | "mul" | "ld" | "ldd" | "st" | "std" | "lds" | "sts" | "push"
            | "pop" | "rjmp" | "ijmp" => 2,
            "jmp" => 3,
            "call" | "ret" | "reti" => 4,
            _ => 1,
        };
        let label = |text: &str| {
            let at = flash.labels.get(text).copied();
            at.ok_or_else(|| format!("no label {text}"))
        };
        if let Some(holds) = self.condition(name) {
            self.cycles += u32::from(holds);
            return if holds { label(a).map(Some) } else { Ok(None) };
        }
        let skips = match &**name {
            "sbrc" => Some(x >> number & 1 == 0),
            "sbrs" => Some(x >> number & 1 == 1),
            "cpse" => Some(x == y),
            _ => None,
        };
        if let Some(skips) = skips {
            let long = ["call", "jmp", "lds", "sts"].contains(&&*flash.ops[pc + 1].name);
            self.cycles += if skips { 1 + u32::from(long) } else { 0 };
            return Ok(skips.then_some(pc + 2));
        }
        match &**name {
            "nop" => {}
            "cli" => self.set(I, false),
            "sei" => self.set(I, true),
            "mov" => self.r[d] = y,
            "movw" => self.set_word(d, self.word(s)),
            "ldi" => self.r[d] = number as u8,
            "clr" => self.logic(d, 0),
            "and" => self.logic(d, x & y),
            "or" => self.logic(d, x | y),
            "eor" => self.logic(d, x ^ y),
            "andi" => self.logic(d, x & number as u8),
            "ori" => self.logic(d, x | number as u8),
            "tst" => self.logic(d, x),
            "inc" => {
                self.r[d] = x.wrapping_add(1);
                self.signs(self.r[d], x == 127);
            }
            "dec" => {
                self.r[d] = x.wrapping_sub(1);
                self.signs(self.r[d], x == 128);
            }
            "swap" => self.r[d] = x.rotate_left(4),
            "com" => {
                self.logic(d, !x);
                self.set(C, true);
            }
            "neg" => self.r[d] = self.less(0, x, None),
            "add" => self.r[d] = self.sum(x, y, false),
            "adc" => self.r[d] = self.sum(x, y, carry),
            "lsl" => self.r[d] = self.sum(x, x, false),
            "rol" => self.r[d] = self.sum(x, x, carry),
            "lsr" => self.shift(d, x >> 1, x),
            "ror" => self.shift(d, x >> 1 | u8::from(carry) << 7, x),
            "asr" => self.shift(d, x >> 1 | x & 128, x),
            "sub" => self.r[d] = self.less(x, y, None),
            "sbc" => self.r[d] = self.less(x, y, Some(carry)),
            "subi" => self.r[d] = self.less(x, number as u8, None),
            "sbci" => self.r[d] = self.less(x, number as u8, Some(carry)),
            "cp" => drop(self.less(x, y, None)),
            "cpc" => drop(self.less(x, y, Some(carry))),
            "cpi" => drop(self.less(x, number as u8, None)),
            "adiw" | "sbiw" => {
                let (old, more) = (self.word(d), number as u16);
                let up = name == "adiw";
                let new = if up { old.wrapping_add(more) } else { old.wrapping_sub(more) };
                let (from, to) = (old >> 15 != 0, new >> 15 != 0);
                self.set(C, if up { from && !to } else { !from && to });
                self.signs((new >> 8) as u8, if up { !from && to } else { from && !to });
                self.set(Z, new == 0);
                self.set_word(d, new);
            }
            "mul" => {
                let product = u16::from(x) * u16::from(y);
                self.set_word(0, product);
                self.set(Z, product == 0);
                self.set(C, product >> 15 != 0);
            }
            "bst" => self.set(T, x >> number & 1 != 0),
            "bld" => self.r[d] = x & !(1 << number) | u8::from(self.flag(T)) << number,
            "set" => self.set(T, true),
            "clt" => self.set(T, false),
            "lds" => self.r[d] = self.load(number as u16)?,
            "sts" => self.store(self::number(a) as u16, y)?,
            "ld" | "ldd" => {
                let at = self.place(b);
                self.r[d] = self.load(at)?;
            }
            "st" | "std" => {
                let at = self.place(a);
                self.store(at, y)?;
            }
            "push" => self.push(x)?,
            "pop" => self.r[d] = self.pop()?,
            "in" => {
                self.r[d] = match number {
                    61 => self.sp as u8,
                    62 => (self.sp >> 8) as u8,
                    63 => self.sreg,
                    _ => return Err(format!("port {b}")),
                }
            }
            "out" => match self::number(a) {
                61 => self.sp = self.sp & 0xFF00 | u16::from(y),
                62 => self.sp = self.sp & 0xFF | u16::from(y) << 8,
                63 => self.sreg = y,
                _ => return Err(format!("port {a}")),
            },
            "rjmp" | "jmp" => return label(a).map(Some),
            "ijmp" => return Ok(Some(self.word(30).into())),
            "call" | "rcall" => {
                *self.calls.entry(a.clone()).or_default() += 1;
                self.call(pc as u16 + 1)?;
                return label(a).map(Some);
            }
            "ret" | "reti" => {
                if name == "reti" {
                    self.set(I, true);
                }
                let (high, low) = (self.pop()?, self.pop()?);
                return Ok(Some(u16::from_le_bytes([low, high]).into()));
            }
            name => return Err(format!("{name}?")),
        }
        Ok(None)
    }

    fn flag(&self, flag: u8) -> bool {
        self.sreg >> flag & 1 != 0
    }

    fn set(&mut self, flag: u8, to: bool) {
        self.sreg = self.sreg & !(1 << flag) | u8::from(to) << flag;
    }

    /// Whether the condition of a branch holds; `None` if it is not a branch.
    fn condition(&self, name: &str) -> Option<bool> {
        let (flag, wanted) = match name {
            "brlo" | "brcs" => (C, true),
            "brsh" | "brcc" => (C, false),
            "breq" => (Z, true),
            "brne" => (Z, false),
            "brmi" => (N, true),
            "brpl" => (N, false),
            "brlt" => (S, true),
            "brge" => (S, false),
            "brts" => (T, true),
            "brtc" => (T, false),
            _ => return None,
        };
        Some(self.flag(flag) == wanted)
    }

    /// Sets Z, N, V and S for a result.
    fn signs(&mut self, result: u8, overflow: bool) {
        self.set(Z, result == 0);
        self.set(N, result > 127);
        self.set(V, overflow);
        self.set(S, overflow != (result > 127));
    }

    fn logic(&mut self, to: usize, result: u8) {
        self.r[to] = result;
        self.signs(result, false);
    }

    fn sum(&mut self, a: u8, b: u8, carry: bool) -> u8 {
        let sum = u16::from(a) + u16::from(b) + u16::from(carry);
        let result = sum as u8;
        self.set(H, (a & 15) + (b & 15) + u8::from(carry) > 15);
        self.set(C, sum > 255);
        self.signs(result, (a ^ result) & (b ^ result) & 128 != 0);
        result
    }

    /// A difference. With a carry, Z stays unchanged if the result is 0.
    fn less(&mut self, a: u8, b: u8, carry: Option<bool>) -> u8 {
        let zero = self.flag(Z);
        let less = i16::from(a) - i16::from(b) - i16::from(carry == Some(true));
        let result = less as u8;
        self.set(H, i16::from(a & 15) - i16::from(b & 15) - i16::from(carry == Some(true)) < 0);
        self.set(C, less < 0);
        self.signs(result, (a ^ b) & (a ^ result) & 128 != 0);
        if carry.is_some() {
            self.set(Z, result == 0 && zero);
        }
        result
    }

    fn shift(&mut self, to: usize, result: u8, old: u8) {
        self.r[to] = result;
        let carry = old & 1 != 0;
        self.set(C, carry);
        self.signs(result, (result > 127) != carry);
    }

    fn word(&self, low: usize) -> u16 {
        u16::from_le_bytes([self.r[low], self.r[low + 1]])
    }

    fn set_word(&mut self, low: usize, word: u16) {
        [self.r[low], self.r[low + 1]] = word.to_le_bytes();
    }

    /// The address of `X`, `Y+`, `-Z` or `Z+3`; updates the pointer.
    fn place(&mut self, text: &str) -> u16 {
        let name = text.trim_start_matches('-');
        let low = match &name[..1] {
            "X" => 26,
            "Y" => 28,
            _ => 30,
        };
        let before = u16::from(text.starts_with('-'));
        let at = self.word(low).wrapping_sub(before);
        self.set_word(low, at.wrapping_add(name.ends_with('+').into()));
        let distance = name.split_once('+').and_then(|(_, distance)| distance.parse().ok());
        at.wrapping_add(distance.unwrap_or(0))
    }

    fn load(&self, at: u16) -> Result<u8, String> {
        self.memory.get(usize::from(at)).copied().ok_or_else(|| format!("a load from {at}"))
    }

    fn store(&mut self, at: u16, byte: u8) -> Result<(), String> {
        *self.memory.get_mut(usize::from(at)).ok_or_else(|| format!("a store to {at}"))? = byte;
        if at < SEEN {
            self.stores.push((at, byte));
        }
        Ok(())
    }

    fn push(&mut self, byte: u8) -> Result<(), String> {
        self.store(self.sp, byte)?;
        self.sp -= 1;
        if self.sp > FLOOR { Ok(()) } else { Err("the stack is too deep".into()) }
    }

    fn pop(&mut self) -> Result<u8, String> {
        self.sp += 1;
        self.load(self.sp)
    }

    fn call(&mut self, back: u16) -> Result<(), String> {
        let [low, high] = back.to_le_bytes();
        self.push(low)?;
        self.push(high)
    }

    /// Overwrites the bytes below the stack, as an interrupt does.
    fn scribble(&mut self) {
        let sp = usize::from(self.sp);
        self.memory[sp - usize::from(SCRIBBLED)..=sp].fill(0xA5);
    }
}

/// The number of a register.
fn register(text: &str) -> Option<usize> {
    text.strip_prefix('r')?.parse().ok()
}

/// A number, or an address of the memory M, which begins at 0.
fn number(text: &str) -> i32 {
    text.strip_prefix("M+").unwrap_or(text).parse().unwrap_or(0)
}
