//! The three loops that planning on an AVR spends its time in.
//!
//! What rustc 1.96 makes of the same loops in Rust takes 2 to 3 times as long
//! (`mod.rs` has them, for other chips and to be tested against). Cycles are
//! counted from the listing, call and return included:
//!
//! | routine | cycles | from Rust |
//! | --- | --- | --- |
//! | `product` | 107 | 280 (`u64` multiplication 1,100) |
//! | `fraction` | 570 … 700 | 1,530 |
//! | `root` | 690 … 770 | 1,840 |
//!
//! They are functions of C's calling convention, arguments in r25–r22 and
//! r21–r18, the result in r25–r22, so that nothing has to be moved.

use core::arch::asm;

/// floor(a · b / 2³²).
///
/// A column of the schoolbook product after another; its sum moves round r26,
/// r27 and r30, and from column 4 on into the result.
#[inline(never)]
#[rustfmt::skip] // a round of a loop, a column of a product to a line
pub(super) extern "C" fn high_product(a: u32, b: u32) -> u32 {
    let [mut a0, mut a1, mut a2, mut a3] = a.to_le_bytes();
    let [b0, b1, b2, b3] = b.to_le_bytes();
    // SAFETY: computes from registers into registers, and leaves r1 at 0.
    unsafe {
        asm!(
            "mul r22, r18",
            "mov r26, r1",
            "clr r27",
            "clr r30",
            "clr r31",
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
            // column 4: r26, r27, r30; from here on the sums are the result
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
            "mov r24, r30",
            "mov r25, r26",
            "clr r1",
            inout("r22") a0, inout("r23") a1, inout("r24") a2, inout("r25") a3,
            in("r18") b0, in("r19") b1, in("r20") b2, in("r21") b3,
            out("r26") _, out("r27") _, out("r30") _, out("r31") _,
            options(nomem, nostack),
        );
    }
    u32::from_le_bytes([a0, a1, a2, a3])
}

/// a · b.
#[inline(always)]
#[rustfmt::skip]
pub(super) fn short_product(a: u16, b: u16) -> u32 {
    let ([a0, a1], [b0, b1]) = (a.to_le_bytes(), b.to_le_bytes());
    let (p0, p1, p2, p3): (u8, u8, u8, u8);
    // SAFETY: computes from registers into registers, and leaves r1 at 0.
    unsafe {
        asm!(
            "mul {a0}, {b0}", "movw r18, r0",
            "mul {a1}, {b1}", "movw r20, r0",
            "clr r26",
            "mul {a1}, {b0}", "add r19, r0", "adc r20, r1", "adc r21, r26",
            "mul {a0}, {b1}", "add r19, r0", "adc r20, r1", "adc r21, r26",
            "clr r1",
            a0 = in(reg) a0, a1 = in(reg) a1, b0 = in(reg) b0, b1 = in(reg) b1,
            out("r18") p0, out("r19") p1, out("r20") p2, out("r21") p3, out("r26") _,
            options(nomem, nostack),
        );
    }
    u32::from_le_bytes([p0, p1, p2, p3])
}

/// m · 2³² >> by, as the whole part and the rest in 2⁻³²; `by` < 64.
#[inline(never)]
#[rustfmt::skip]
pub(super) extern "C" fn shifted(m: u32, by: u8) -> u64 {
    let [mut a0, mut a1, mut a2, mut a3] = m.to_le_bytes();
    let (b0, b1, b2, b3): (u8, u8, u8, u8);
    // SAFETY: computes from registers into registers, in 7 + 7 rounds at most.
    unsafe {
        asm!(
            "clr r18", "clr r19", "clr r21",
            "mov r26, r20",
            "clr r20",
            "1:",
            "cpi r26, 8",
            "brlo 2f",
            "mov r18, r19", "mov r19, r20", "mov r20, r21", "mov r21, r22",
            "mov r22, r23", "mov r23, r24", "mov r24, r25", "clr r25",
            "subi r26, 8",
            "rjmp 1b",
            "2:",
            "tst r26",
            "breq 4f",
            "3:",
            "lsr r25", "ror r24", "ror r23", "ror r22",
            "ror r21", "ror r20", "ror r19", "ror r18",
            "dec r26",
            "brne 3b",
            "4:",
            inout("r22") a0, inout("r23") a1, inout("r24") a2, inout("r25") a3,
            inout("r20") by => b2,
            out("r18") b0, out("r19") b1, out("r21") b3,
            out("r26") _,
            options(nomem, nostack),
        );
    }
    u64::from_le_bytes([b0, b1, b2, b3, a0, a1, a2, a3])
}

/// floor(n · 2³² / d), for n < d and 2³¹ ≤ d: a bit a round.
///
/// The quotient gathers, inverted, in r31–r26; the 1 that it begins with falls
/// out after 32 rounds, whatever the arguments are.
#[inline(never)]
#[rustfmt::skip] // a round of a loop, a column of a product to a line
pub(super) extern "C" fn fraction(n: u32, d: u32) -> u32 {
    let [mut a0, mut a1, mut a2, mut a3] = n.to_le_bytes();
    let [b0, b1, b2, b3] = d.to_le_bytes();
    // SAFETY: computes from registers into registers.
    unsafe {
        asm!(
            "ldi r26, 1",
            "clr r27",
            "clr r30",
            "clr r31",
            "1:",
            "lsl r22", "rol r23", "rol r24", "rol r25",
            "brcs 2f",
            "cp r22, r18", "cpc r23, r19", "cpc r24, r20", "cpc r25, r21",
            "brcs 3f", // too small: the inverted bit is the carry, 1
            "2:",
            "sub r22, r18", "sbc r23, r19", "sbc r24, r20", "sbc r25, r21",
            "clc",
            "3:",
            "rol r26", "rol r27", "rol r30", "rol r31",
            "brcc 1b",
            "movw r22, r26",
            "movw r24, r30",
            "com r22", "com r23", "com r24", "com r25",
            inout("r22") a0, inout("r23") a1, inout("r24") a2, inout("r25") a3,
            in("r18") b0, in("r19") b1, in("r20") b2, in("r21") b3,
            out("r26") _, out("r27") _, out("r30") _, out("r31") _,
            options(nomem, nostack),
        );
    }
    u32::from_le_bytes([a0, a1, a2, a3])
}

/// √((m + half/2) · 2³²), for m ≥ 2³⁰.
///
/// First the root R of 16 bits: r21, r19, r18 is the rest, r31, r27, r26 the
/// trial 4·R + 1, which becomes 2·trial + 3 or 2·trial − 1. Then 17 bits of
/// rest / 2R: the trial less 1 is 4·R.
#[inline(never)]
#[rustfmt::skip] // a round of a loop, a column of a product to a line
pub(super) extern "C" fn root_of(m: u32, half: u8) -> u32 {
    let [mut a0, mut a1, mut a2, mut a3] = m.to_le_bytes();
    // SAFETY: computes from registers into registers, in 16 and 17 rounds.
    unsafe {
        asm!(
            "mov r0, r20",
            "clr r18",
            "clr r19",
            "clr r21",
            "ldi r26, 1",
            "clr r27",
            "clr r31",
            "ldi r30, 16",
            "1:",
            "lsl r22", "rol r23", "rol r24", "rol r25", "rol r18", "rol r19", "rol r21",
            "lsl r22", "rol r23", "rol r24", "rol r25", "rol r18", "rol r19", "rol r21",
            "cp r18, r26", "cpc r19, r27", "cpc r21, r31",
            "brcs 2f",
            "sub r18, r26", "sbc r19, r27", "sbc r21, r31",
            "lsl r26", "rol r27", "rol r31",
            "subi r26, -3", // its last bits are 010: nothing to carry
            "rjmp 3f",
            "2:",
            "lsl r26", "rol r27", "rol r31",
            "dec r26",
            "3:",
            "dec r30",
            "brne 1b",
            // Then 17 bits of rest / 2R: the trial less 1 is 4·R.
            "dec r26",
            "lsr r0",
            "rol r18", "rol r19", "rol r21",
            "clr r22",
            "clr r23",
            "clr r24",
            "ldi r30, 17",
            "4:",
            "lsl r22", "rol r23", "rol r24",
            "cp r18, r26", "cpc r19, r27", "cpc r21, r31",
            "brcs 5f",
            "sub r18, r26", "sbc r19, r27", "sbc r21, r31",
            "inc r22",
            "5:",
            "lsl r18", "rol r19", "rol r21",
            "dec r30",
            "brne 4b",
            // R · 2¹⁶ + quotient, at most 2³² − 1
            "lsr r31", "ror r27", "ror r26",
            "lsr r31", "ror r27", "ror r26",
            "mov r25, r27",
            "add r24, r26",
            "adc r25, r1",
            "brcc 6f",
            "ldi r22, 255",
            "ldi r23, 255",
            "movw r24, r22",
            "6:",
            inout("r22") a0, inout("r23") a1, inout("r24") a2, inout("r25") a3,
            inout("r20") half => _,
            out("r18") _, out("r19") _, out("r21") _,
            out("r26") _, out("r27") _, out("r30") _, out("r31") _,
            options(nomem, nostack),
        );
    }
    u32::from_le_bytes([a0, a1, a2, a3])
}
