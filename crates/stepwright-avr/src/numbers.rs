//! The planner's arithmetic in assembly, a third as long as the core's Rust and twice as fast.
//!
//! The core calls it by name (its feature `external-numbers`; `num/external.rs` there has the
//! contract), and the tests require the same bits from both (`firmware/rig/tests/numbers.rs`).
//!
//! | routine | cycles, including call and return |
//! | --- | --- |
//! | `times`, `roughly` | 164, 86 |
//! | `over` | 600 … 765 |
//! | `root` | 720 … 850 |
//! | `plus`, `minus` | 67 … 180 |
//! | `load`, `store`, `copy` | 32 |
//!
//! C's calling convention: the address of an operand in r25–r24, that of a second one in r23–r22. A
//! number is four bytes m and two bytes e. The result is the number in hand, which has a fixed
//! address, so no routine returns an address.
//!
//! Inside, a mantissa is in r25–r22, a second one in r21–r18; their exponents are in r27–r26 and
//! r31–r30.

use core::arch::asm;

use stepwright::number_layout as layout;

/// The number in hand. Only the foreground uses it.
#[unsafe(no_mangle)]
static mut STEPWRIGHT_HAND: [u8; layout::SIZE] = [0; layout::SIZE];

// Code that uses X or Z reads a number from its first byte to its last.
const _: () = assert!(layout::MANTISSA == 0 && layout::EXPONENT == 4 && layout::SIZE == 6);

/// Contains the routines. (Assembly outside a function is not told that the chip can multiply.)
/// Never called; its own code is a `ret`.
#[rustfmt::skip] // // one line for a round of a loop, or for a column of a product
#[expect(named_asm_labels)] // // this is the only copy
#[unsafe(no_mangle)]
#[inline(never)]
extern "C" fn stepwright_numbers() {
    // SAFETY: jumps over all of it.
    unsafe {
        asm!(
            "rjmp 99f",

            // The common end of routines with a number as their result.
            "stepwright_zero:",
            "clr r22", "clr r23", "movw r24, r22",
            "clr r26", "ldi r27, 0xC0",
            "rjmp 20f",
            // From the upper half of a product, and the sum of exponents: the mantissa may lack one
            // bit.
            "stepwright_product_done:",
            "adiw r26, 32",
            "tst r25", "brmi 20f",
            "sbiw r26, 1",
            "lsl r22", "rol r23", "rol r24", "rol r25",
            "brpl stepwright_zero", // a product of 0
            "20:",
            "ldi r30, lo8({hand})", "ldi r31, hi8({hand})",
            "st Z, r22", "std Z+1, r23", "std Z+2, r24", "std Z+3, r25",
            "std Z+{e}, r26", "std Z+{e}+1, r27",
            "ret",

            // An integer, in r25–r22.
            ".global stepwright_hand_whole",
            "; stepwright_hand_whole takes r22 r23 r24 r25",
            "stepwright_hand_whole:",
            "clr r26", "clr r27",
            "stepwright_normal:",
            "ldi r20, 4",
            "21:",
            "tst r25", "brmi 20b",
            "brne 22f",
            "mov r25, r24", "mov r24, r23", "mov r23, r22", "clr r22",
            "sbiw r26, 8",
            "dec r20", "brne 21b",
            "rjmp stepwright_zero",
            "22:",
            "sbiw r26, 1",
            "lsl r22", "rol r23", "rol r24", "rol r25",
            "brpl 22b",
            "rjmp 20b",

            // Loads the other operand as the first, and the number in hand as the second.
            "stepwright_load_other:",
            "movw r26, r24",
            "ldi r30, lo8({hand})", "ldi r31, hi8({hand})",
            "rjmp 23f",
            // Loads two operands, whose addresses are in r25–r24 and r23–r22.
            "stepwright_load_two:",
            "movw r26, r24",
            "movw r30, r22",
            "rjmp 23f",
            // Loads the number in hand as the first, and the other operand as the second.
            "stepwright_load:",
            "movw r30, r24",
            "ldi r26, lo8({hand})", "ldi r27, hi8({hand})",
            "23:",
            "ld r22, X+", "ld r23, X+", "ld r24, X+", "ld r25, X+",
            "ld r0, X+", "ld r27, X", "mov r26, r0",
            "ld r18, Z", "ldd r19, Z+{m}+1", "ldd r20, Z+{m}+2", "ldd r21, Z+{m}+3",
            "ldd r0, Z+{e}", "ldd r31, Z+{e}+1", "mov r30, r0",
            "ret",

            ".global stepwright_hand_square",
            "; stepwright_hand_square takes",
            "stepwright_hand_square:",
            "ldi r24, lo8({hand})", "ldi r25, hi8({hand})",
            ".global stepwright_hand_times",
            "; stepwright_hand_times takes r24 r25",
            "stepwright_hand_times:",
            "rcall stepwright_load",
            "add r26, r30", "adc r27, r31",
            "push r26", "push r27",
            // Computes the schoolbook product column by column. The sum of a column rotates through
            // r26, r27 and r30, and from column 4 on it is stored in the result.
            "mul r22, r18",
            "mov r26, r1", "clr r27", "clr r30", "clr r31",
            // column 1: r26, r27, r30
            "mul r22, r19", "add r26, r0", "adc r27, r1", "adc r30, r31",
            "mul r23, r18", "add r26, r0", "adc r27, r1", "adc r30, r31",
            // column 2: r27, r30, r26
            "clr r26",
            "mul r22, r20", "add r27, r0", "adc r30, r1", "adc r26, r31",
            "mul r23, r19", "add r27, r0", "adc r30, r1", "adc r26, r31",
            "mul r24, r18", "add r27, r0", "adc r30, r1", "adc r26, r31",
            // column 3: r30, r26, r27
            "clr r27",
            "mul r22, r21", "add r30, r0", "adc r26, r1", "adc r27, r31",
            "mul r23, r20", "add r30, r0", "adc r26, r1", "adc r27, r31",
            "mul r24, r19", "add r30, r0", "adc r26, r1", "adc r27, r31",
            "mul r25, r18", "add r30, r0", "adc r26, r1", "adc r27, r31",
            // column 4: r26, r27, r30
            "clr r30",
            "mul r23, r21", "add r26, r0", "adc r27, r1", "adc r30, r31",
            "mul r24, r20", "add r26, r0", "adc r27, r1", "adc r30, r31",
            "mul r25, r19", "add r26, r0", "adc r27, r1", "adc r30, r31",
            "mov r22, r26",
            // column 5: r27, r30, r26
            "clr r26",
            "mul r24, r21", "add r27, r0", "adc r30, r1", "adc r26, r31",
            "mul r25, r20", "add r27, r0", "adc r30, r1", "adc r26, r31",
            "mov r23, r27",
            // column 6: r30, r26
            "mul r25, r21", "add r30, r0", "adc r26, r1",
            "mov r24, r30", "mov r25, r26",
            "clr r1",
            "pop r27", "pop r26",
            "rjmp stepwright_product_done",

            // Multiplies the upper halves only.
            ".global stepwright_hand_roughly",
            "; stepwright_hand_roughly takes r24 r25",
            "stepwright_hand_roughly:",
            "rcall stepwright_load",
            "add r26, r30", "adc r27, r31",
            "clr r30",
            "movw r18, r24", // r19, r18 times r21, r20
            "mul r18, r20", "movw r22, r0",
            "mul r19, r21", "movw r24, r0",
            "mul r19, r20", "add r23, r0", "adc r24, r1", "adc r25, r30",
            "mul r18, r21", "add r23, r0", "adc r24, r1", "adc r25, r30",
            "clr r1",
            "rjmp stepwright_product_done",

            ".global stepwright_hand_under",
            "; stepwright_hand_under takes r24 r25",
            "stepwright_hand_under:",
            "rcall stepwright_load_other",
            "rjmp 29f",
            ".global stepwright_hand_over",
            "; stepwright_hand_over takes r24 r25",
            "stepwright_hand_over:",
            "rcall stepwright_load",
            "29:",
            "tst r25", "breq 39f",
            "tst r21", "breq 38f",
            "sub r26, r30", "sbc r27, r31",
            // A quotient of 1 … 2, or ½ … 1.
            "cp r22, r18", "cpc r23, r19", "cpc r24, r20", "cpc r25, r21",
            "brcs 30f",
            "sub r22, r18", "sbc r23, r19", "sbc r24, r20", "sbc r25, r21",
            "sbiw r26, 31",
            "rcall 31f",
            "sec", "ror r25", "ror r24", "ror r23", "ror r22",
            "rjmp 20b",
            "30:",
            "sbiw r26, 32",
            "rcall 31f",
            "rjmp 20b",
            "38:", // // by 0: larger than any number used here
            "ldi r22, 255", "ldi r23, 255", "movw r24, r22",
            "ldi r26, 255", "ldi r27, 31",
            "rjmp 20b",
            "39:",
            "rjmp stepwright_zero",
            // r25–r22 · 2³² / r21–r18, for a quotient below 1, one bit a round. The quotient
            // accumulates, inverted, in r1, r0, r31, r30; the initial 1 is shifted out at the end.
            "31:",
            "clr r0", "clr r31", "ldi r30, 1",
            "32:",
            "lsl r22", "rol r23", "rol r24", "rol r25",
            "brcs 33f",
            "cp r22, r18", "cpc r23, r19", "cpc r24, r20", "cpc r25, r21",
            "brcs 34f", // too small: the inverted bit is the carry, 1
            "33:",
            "sub r22, r18", "sbc r23, r19", "sbc r24, r20", "sbc r25, r21",
            "clc",
            "34:",
            "rol r30", "rol r31", "rol r0", "rol r1",
            "brcc 32b",
            "movw r22, r30", "movw r24, r0",
            "com r22", "com r23", "com r24", "com r25",
            "clr r1",
            "ret",

            ".global stepwright_hand_plus",
            "; stepwright_hand_plus takes r24 r25",
            "stepwright_hand_plus:",
            "rcall stepwright_load",
            "cp r26, r30", "cpc r27, r31",
            "brge 40f",
            // The second is larger: exchange them.
            "movw r0, r26", "movw r26, r30", "movw r30, r0",
            "movw r0, r22", "movw r22, r18", "movw r18, r0",
            "movw r0, r24", "movw r24, r20", "movw r20, r0",
            "clr r1",
            "40:",
            "rcall 45f",
            "add r22, r18", "adc r23, r19", "adc r24, r20", "adc r25, r21",
            "brcc 41f",
            "ror r25", "ror r24", "ror r23", "ror r22",
            "adiw r26, 1",
            "41:",
            "rjmp 20b",

            ".global stepwright_hand_off",
            "; stepwright_hand_off takes r24 r25",
            "stepwright_hand_off:",
            "rcall stepwright_load_other",
            "rjmp 58f",
            ".global stepwright_hand_minus",
            "; stepwright_hand_minus takes r24 r25",
            "stepwright_hand_minus:",
            "rcall stepwright_load",
            "58:",
            "cp r26, r30", "cpc r27, r31",
            "brlt 59f",
            "rcall 45f",
            "sub r22, r18", "sbc r23, r19", "sbc r24, r20", "sbc r25, r21",
            "brcs 59f",
            "rjmp stepwright_normal",
            "59:",
            "rjmp stepwright_zero",

            // r21–r18 >> (r27–r26 less r31–r30), a difference that is not negative.
            "45:",
            "movw r0, r26",
            "sub r0, r30", "sbc r1, r31",
            "movw r30, r0",
            "clr r1",
            "tst r31", "brne 48f",
            "cpi r30, 32", "brsh 48f",
            "47:",
            "cpi r30, 8", "brlo 49f",
            "mov r18, r19", "mov r19, r20", "mov r20, r21", "clr r21",
            "subi r30, 8",
            "rjmp 47b",
            "48:",
            "clr r18", "clr r19", "movw r20, r18",
            "ret",
            "50:",
            "lsr r21", "ror r20", "ror r19", "ror r18",
            "49:",
            "subi r30, 1",
            "brcc 50b",
            "ret",

            "69:",
            "rjmp stepwright_zero",
            ".global stepwright_hand_root",
            "; stepwright_hand_root takes",
            "stepwright_hand_root:",
            "ldi r30, lo8({hand})", "ldi r31, hi8({hand})",
            "ld r22, Z", "ldd r23, Z+{m}+1", "ldd r24, Z+{m}+2", "ldd r25, Z+{m}+3",
            "ldd r26, Z+{e}", "ldd r27, Z+{e}+1",
            "tst r25", "breq 69b",
            // Makes the exponent even; the bit that is shifted out is half a unit.
            "clr r0",
            "sbrs r26, 0",
            "rjmp 60f",
            "adiw r26, 1",
            "lsr r25", "ror r24", "ror r23", "ror r22",
            "rol r0",
            "60:",
            "asr r27", "ror r26",
            "sbiw r26, 16",
            "push r26", "push r27",
            // First the root R of 16 bits: r21, r19, r18 is the remainder, r31, r27, r26 the trial
            // 4·R + 1, which becomes 2·trial + 3 or 2·trial − 1.
            "clr r18", "clr r19", "clr r21",
            "ldi r26, 1", "clr r27", "clr r31",
            "ldi r30, 16",
            "61:",
            "lsl r22", "rol r23", "rol r24", "rol r25", "rol r18", "rol r19", "rol r21",
            "lsl r22", "rol r23", "rol r24", "rol r25", "rol r18", "rol r19", "rol r21",
            "cp r18, r26", "cpc r19, r27", "cpc r21, r31",
            "brcs 62f",
            "sub r18, r26", "sbc r19, r27", "sbc r21, r31",
            "lsl r26", "rol r27", "rol r31",
            "subi r26, -3", // its last bits are 010: nothing to carry
            "rjmp 63f",
            "62:",
            "lsl r26", "rol r27", "rol r31",
            "dec r26",
            "63:",
            "dec r30",
            "brne 61b",
            // Then 17 bits of remainder / 2R: the trial less 1 is 4·R.
            "dec r26",
            "lsr r0", "rol r18", "rol r19", "rol r21",
            "clr r22", "clr r23", "clr r24",
            "ldi r30, 17",
            "64:",
            "lsl r22", "rol r23", "rol r24",
            "cp r18, r26", "cpc r19, r27", "cpc r21, r31",
            "brcs 65f",
            "sub r18, r26", "sbc r19, r27", "sbc r21, r31",
            "inc r22",
            "65:",
            "lsl r18", "rol r19", "rol r21",
            "dec r30",
            "brne 64b",
            // R · 2¹⁶ + quotient, at most 2³² − 1
            "lsr r31", "ror r27", "ror r26",
            "lsr r31", "ror r27", "ror r26",
            "mov r25, r27",
            "add r24, r26", "adc r25, r1",
            "brcc 66f",
            "ldi r22, 255", "ldi r23, 255", "movw r24, r22",
            "66:",
            "pop r27", "pop r26",
            "rjmp stepwright_normal",

            // The whole part in r25–r22, the fraction in r21–r18.
            ".global stepwright_hand_split",
            "; stepwright_hand_split takes",
            "stepwright_hand_split:",
            "ldi r24, lo8({hand})", "ldi r25, hi8({hand})",
            ".global stepwright_split",
            "; stepwright_split takes r24 r25",
            "stepwright_split:",
            "movw r30, r24",
            "ld r22, Z", "ldd r23, Z+{m}+1", "ldd r24, Z+{m}+2", "ldd r25, Z+{m}+3",
            "ldd r26, Z+{e}", "ldd r27, Z+{e}+1",
            "clr r18", "clr r19", "movw r20, r18",
            // by = −e
            "com r27", "neg r26", "sbci r27, 255",
            "tst r27", "brmi 73f",
            "brne 72f",
            "cpi r26, 64", "brsh 72f",
            "70:",
            "cpi r26, 8", "brlo 75f",
            "mov r18, r19", "mov r19, r20", "mov r20, r21", "mov r21, r22",
            "mov r22, r23", "mov r23, r24", "mov r24, r25", "clr r25",
            "subi r26, 8",
            "rjmp 70b",
            "72:", // less than 2⁻³²
            "movw r22, r18", "movw r24, r18",
            "ret",
            "73:", // e > 0
            "ldi r22, 255", "ldi r23, 255", "movw r24, r22",
            "ret",
            "74:",
            "lsr r25", "ror r24", "ror r23", "ror r22",
            "ror r21", "ror r20", "ror r19", "ror r18",
            "75:",
            "subi r26, 1",
            "brcc 74b",
            "ret",

            ".global stepwright_hand_at_least",
            "; stepwright_hand_at_least takes r24 r25",
            "stepwright_hand_at_least:",
            "rcall stepwright_load",
            "rjmp 79f",
            ".global stepwright_at_least",
            "; stepwright_at_least takes r22 r23 r24 r25",
            "stepwright_at_least:",
            "rcall stepwright_load_two",
            "79:",
            "clr r0",
            "cp r26, r30", "cpc r27, r31",
            "brlt 81f",
            "brne 80f",
            "cp r22, r18", "cpc r23, r19", "cpc r24, r20", "cpc r25, r21",
            "brcs 81f",
            "80:",
            "inc r0",
            "81:",
            "mov r24, r0",
            "ret",

            // The first exponent less the second, and one less if the first mantissa is smaller.
            ".global stepwright_doublings",
            "; stepwright_doublings takes r22 r23 r24 r25",
            "stepwright_doublings:",
            "rcall stepwright_load_two",
            "cp r22, r18", "cpc r23, r19", "cpc r24, r20", "cpc r25, r21",
            "sbc r26, r30",
            "mov r24, r26",
            "ret",

            ".global stepwright_hand_scale",
            "; stepwright_hand_scale takes r24",
            "stepwright_hand_scale:",
            "mov r25, r24", "lsl r25", "sbc r25, r25",
            "ldi r30, lo8({hand})", "ldi r31, hi8({hand})",
            "ldd r22, Z+{e}", "ldd r23, Z+{e}+1",
            "add r22, r24", "adc r23, r25",
            "std Z+{e}, r22", "std Z+{e}+1, r23",
            "ret",
            // Copies from the first address to the second.
            ".global stepwright_copy",
            "; stepwright_copy takes r22 r23 r24 r25",
            "stepwright_copy:",
            "movw r30, r24",
            "movw r26, r22",
            "rjmp 92f",
            ".global stepwright_hand_bits",
            "; stepwright_hand_bits takes",
            "stepwright_hand_bits:",
            "ldi r30, lo8({hand})", "ldi r31, hi8({hand})",
            "ldd r24, Z+{e}", "ldd r25, Z+{e}+1",
            "adiw r24, 32",
            "ldd r26, Z+{m}+3",
            "tst r26", "brne 91f",
            "clr r24", "ldi r25, 0xC0", // // for a 0
            "91:",
            "ret",
            ".global stepwright_hand_store",
            "; stepwright_hand_store takes r24 r25",
            "stepwright_hand_store:",
            "movw r26, r24",
            "ldi r30, lo8({hand})", "ldi r31, hi8({hand})",
            "rjmp 92f",
            ".global stepwright_hand_load",
            "; stepwright_hand_load takes r24 r25",
            "stepwright_hand_load:",
            "movw r30, r24",
            "ldi r26, lo8({hand})", "ldi r27, hi8({hand})",
            "92:", // six bytes from Z to X
            "ld r18, Z", "ldd r19, Z+{m}+1", "ldd r20, Z+{m}+2", "ldd r21, Z+{m}+3", "ldd r22, Z+{e}", "ldd r23, Z+{e}+1",
            "st X+, r18", "st X+, r19", "st X+, r20", "st X+, r21", "st X+, r22", "st X, r23",
            "ret",
            "99:",
            hand = sym STEPWRIGHT_HAND,
            m = const layout::MANTISSA,
            e = const layout::EXPONENT,
            options(nomem, nostack),
        );
    }
}
