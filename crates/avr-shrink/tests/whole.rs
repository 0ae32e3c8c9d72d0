//! The whole pass on whole programs: the chip of `common` runs them before and after.

mod common;

use avr_shrink::{Spared, shrink};
use common::Random;
use common::chip::{Chip, Flash, Interrupts, SEEN};
use common::programs::{HANDLER, MAIN, program};

/// The number of random programs; `AVR_SHRINK_PROGRAMS` sets another number.
const PROGRAMS: u64 = 400;

/// The registers that a function preserves, or returns its result in.
const KEPT: [usize; 26] = [
    2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15, 16, 17, 28, 29, 18, 19, 20, 21, 22, 23, 24, 25,
];

/// Runs a function before and after the pass, from one state of the chip. Returns the cycles of
/// each.
///
/// # Errors
/// The results differ.
fn same(
    (before, after): (&Flash, &Flash),
    name: &str,
    start: &Chip,
    when: Interrupts,
) -> Result<(Chip, Chip), String> {
    let (mut a, mut b) = (start.clone(), start.clone());
    let ends = a.run(before, name, when).map_err(|error| format!("before: {error}"))?;
    let too = b.run(after, name, when).map_err(|error| format!("after: {error}"))?;
    let seen = |chip: &Chip| chip.memory[..usize::from(SEEN)].to_vec();
    let kept = |chip: &Chip| KEPT.map(|register| chip.r[register]);
    if ends != too || ends && (kept(&a), a.sp) != (kept(&b), b.sp) || ends && b.r[1] != 0 {
        return Err(format!("registers\n{:?} {}\n{:?} {}", a.r, a.sp, b.r, b.sp));
    }
    if (seen(&a), &a.stores) != (seen(&b), &b.stores) {
        return Err(format!("stores\n{:?}\n{:?}", a.stores, b.stores));
    }
    Ok((a, b))
}

/// A state of the chip in which a function may begin.
fn any_state(random: &mut Random) -> Chip {
    let mut chip = Chip::new();
    chip.r = std::array::from_fn(|_| random.byte());
    chip.r[1] = 0;
    chip.sreg = 0x80 | random.byte() & 0x3F;
    chip.memory.iter_mut().for_each(|byte| *byte = random.byte());
    chip
}

/// The most cycles that a program may take, given its cycles before the pass and the registers that
/// it saved by a routine.
fn bound(before: u32, after: &Chip) -> u32 {
    let more = after.calls.iter().map(|(label, times)| {
        let cost = match label.strip_prefix("avr_shrink_save_") {
            Some(lowest) if label.contains("bare") => {
                let lowest: u32 = lowest.trim_start_matches("bare_").parse().unwrap();
                38 + 4 * (20 - lowest)
            }
            Some(_) => 22,
            None => 0,
        };
        times * cost
    });
    before + more.sum::<u32>()
}

/// Tests the program of a seed.
fn try_one(seed: u64) -> Result<(), String> {
    let mut random = Random::new(seed);
    let text = program(&mut random);
    let spared = Spared {
        busy: if random.one_in(3) { vec![MAIN.into()] } else { Vec::new() },
        whole: if random.one_in(3) { vec!["_Rf1".into()] } else { Vec::new() },
    };
    let small = shrink(&text, &spared)?;
    let flashes = (&Flash::read(&text), &Flash::read(&small));
    for n in 0..6 {
        let start = any_state(&mut random);
        let when = Interrupts {
            everywhere: n % 3 == 1,
            handler: (n % 3 == 2).then_some((HANDLER, 1 + n)),
        };
        let (a, b) = same(flashes, MAIN, &start, when)
            .map_err(|error| format!("seed {seed}: {error}\n{text}\nbecame\n{small}"))?;
        let most = bound(a.cycles, &b);
        if when.handler.is_none() && b.cycles > most {
            let (before, after) = (a.cycles, b.cycles);
            let what = format!("seed {seed}: {before} cycles became {after}, over {most}");
            return Err(format!("{what}\n{text}\nbecame\n{small}"));
        }
    }
    Ok(())
}

#[test]
fn random_programs_do_the_same_before_and_after() {
    let count = std::env::var("AVR_SHRINK_PROGRAMS").ok().and_then(|count| count.parse().ok());
    for seed in 0..count.unwrap_or(PROGRAMS) {
        if let Err(error) = try_one(seed) {
            panic!("{error}");
        }
    }
}

/// A function of the compiler.
fn function(name: &str, body: &str) -> String {
    let body = body.replace("; ", "\n\t");
    let section = format!("\t.section\t.text.{name},\"ax\",@progbits");
    format!("{section}\n\t.type\t{name},@function\n{name}:\n\t{body}\n.Lfunc_end_{name}:\n")
}

/// Compares a program before and after the pass, from random states.
fn same_everywhere(text: &str, name: &str) -> String {
    let small = shrink(text, &Spared::default()).unwrap();
    let flashes = (&Flash::read(text), &Flash::read(&small));
    let mut random = Random::new(1);
    for _ in 0..50 {
        let start = any_state(&mut random);
        if let Err(error) = same(flashes, name, &start, Interrupts::default()) {
            panic!("{error}\n{text}\nbecame\n{small}");
        }
    }
    small
}

const MOVE: &str = "in r0, 63; cli; out 62, r29; out 63, r0; out 61, r28";

/// A function with a frame of 4 bytes.
fn framed(body: &str) -> String {
    let begin = "push r16; push r17; push r28; push r29; in r28, 61; in r29, 62; sbiw r28, 4";
    let end = "pop r29; pop r28; pop r17; pop r16; ret";
    format!("{begin}; {MOVE}; {body}; adiw r28, 4; {MOVE}; {end}")
}

#[test]
fn a_prologue_stays_in_its_function() {
    // One frame size and one beginning.
    let both = |last: &str| framed(&format!("movw r16, r24; std Y+1, r22; std Y+2, r23; {last}"));
    let text = function("_Rf", &both("inc r16; mov r24, r16"))
        + &function("_Rg", &both("dec r17; mov r24, r17"));
    for name in ["_Rf", "_Rg"] {
        let small = same_everywhere(&text, name);
        assert_eq!(small.matches("call\tavr_shrink_save_16").count(), 2, "{small}");
    }
}

#[test]
fn an_argument_on_the_stack_is_found() {
    let take = framed("ldd r24, Y+11; sts M+1, r24");
    let make = "in r30, 61; in r31, 62; sbiw r30, 2; in r0, 63; cli; out 62, r31; out 63, r0; \
                out 61, r30; std Z+1, r22; std Z+2, r22; movw r24, r20; ldi r20, 1; call _Rh; \
                in r30, 61; in r31, 62; adiw r30, 2; in r0, 63; cli; out 62, r31; out 63, r0; \
                out 61, r30; ret";
    let text = function("_Rf", make) + &function("_Rh", &take);
    let small = same_everywhere(&text, "_Rf");
    assert!(small.contains("call\tavr_shrink_save_16"), "{small}");
}

#[test]
fn a_product_in_r1_is_not_taken_for_0() {
    let body = "mul r24, r22; mov r18, r0; mov r19, r1; cp r18, r1; cpc r19, r1; brne .L1; \
                sts M+3, r22\n.L1:\n\tclr r1; sts M+4, r19; ret";
    same_everywhere(&function("_Rf", body), "_Rf");
}

#[test]
fn a_function_that_never_returns_finds_its_arguments() {
    let begin = "push r16; push r17; push r28; push r29; in r28, 61; in r29, 62; sbiw r28, 2";
    let body = format!("{begin}; {MOVE}; ldd r24, Y+9; sts M+1, r24\n.L1:\n\trjmp .L1");
    same_everywhere(&function("_Rf", &body), "_Rf");
    // Without a frame it has no stack arguments, so nothing is saved.
    let bare = "push r16; push r17; mov r16, r24; sts M+1, r16\n.L1:\n\trjmp .L1";
    let small = same_everywhere(&function("_Rf", bare), "_Rf");
    assert!(!small.contains("push"), "{small}");
}

#[test]
fn it_costs_the_cycles_that_are_documented() {
    let cost = |text: &str| {
        let small = shrink(text, &Spared::default()).unwrap();
        let flashes = (&Flash::read(text), &Flash::read(&small));
        let (a, b) = same(flashes, "_Rf", &Chip::new(), Interrupts::default()).unwrap();
        (i64::from(b.cycles) - i64::from(a.cycles), b.calls)
    };
    let (frame, calls) = cost(&function("_Rf", &framed("std Y+1, r24")));
    assert!(calls.contains_key("avr_shrink_save_16"));
    assert_eq!(frame, 22);
    let saved = "push r16; push r17; push r28; push r29";
    let restored = "pop r29; pop r28; pop r17; pop r16; ret";
    let body = "lds r16, M+3; sts M+4, r16; lds r28, M+5; sts M+6, r28";
    let bare = format!("{saved}; {body}; {restored}");
    assert_eq!(cost(&function("_Rf", &bare)).0, 38);
}
