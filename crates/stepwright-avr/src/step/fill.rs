//! Preparation of the next groups of all axes, with interrupts on: see `step.rs`.
//!
//! ```text
//! axis    now: interval 3, room 2, left 2, pins 1   next: the same
//!         growth 3, events 2, groups, then          due 3   starved   loaded 5
//!         queue: taken, pushed, open, played, backward, slots
//! GPIOR0  0-2 the next group is ready   3-5 it is waited for, with the axis's own
//!         interrupt off   6 axis 3 of an Uno waits long   7 a refill is at work
//! ```
//!
//! Only one refill is in progress at a time: an interrupt that finds one sets its request in bits 3
//! to 5. So a refill owns the data that it changes, and interrupts are off only where it accesses
//! the timer.

/// Adds the steps of the next group, in r26:r24, to `loaded`; `5:` is for a group without steps. Z
/// is the axis.
#[cfg(not(feature = "stream"))]
#[doc(hidden)]
#[macro_export]
macro_rules! step_loaded_text {
    () => {
        r#"
3:  ldd r25, Z+{loaded}
    add r25, r24
    std Z+{loaded}, r25
    ldd r25, Z+{loaded}+1
    adc r25, r26
    std Z+{loaded}+1, r25
    brcc 4f
    ldd r25, Z+{loaded}+2
    inc r25
    std Z+{loaded}+2, r25
    brne 4f
    ldd r25, Z+{loaded}+3
    inc r25
    std Z+{loaded}+3, r25
    brne 4f
    ldd r25, Z+{loaded}+4
    inc r25
    std Z+{loaded}+4, r25
4:  ret
5:  std Z+{next}+{room}, r25 ; what is no step is not late
    std Z+{next}+{room}+1, r25
    ret
"#
    };
}

/// The same for entries with turns: backward steps are subtracted. Bit 0 of the byte after
/// `loaded`: the last prepared group is backward.
#[cfg(feature = "stream")]
#[doc(hidden)]
#[macro_export]
macro_rules! step_loaded_text {
    () => {
        r#"
3:  ldd r25, Z+{loaded}+5
    sbrc r25, 0
    rjmp 7f
    ldd r25, Z+{loaded}
    add r25, r24
    std Z+{loaded}, r25
    ldd r25, Z+{loaded}+1
    adc r25, r26
    std Z+{loaded}+1, r25
    brcc 4f
    ldd r25, Z+{loaded}+2
    inc r25
    std Z+{loaded}+2, r25
    brne 4f
    ldd r25, Z+{loaded}+3
    inc r25
    std Z+{loaded}+3, r25
    brne 4f
    ldd r25, Z+{loaded}+4
    inc r25
    std Z+{loaded}+4, r25
4:  ret
7:  ldd r25, Z+{loaded} ; backward
    sub r25, r24
    std Z+{loaded}, r25
    ldd r25, Z+{loaded}+1
    sbc r25, r26
    std Z+{loaded}+1, r25
    brcc 4b
    ldd r25, Z+{loaded}+2
    subi r25, 1
    std Z+{loaded}+2, r25
    brcc 4b
    ldd r25, Z+{loaded}+3
    subi r25, 1
    std Z+{loaded}+3, r25
    brcc 4b
    ldd r25, Z+{loaded}+4
    subi r25, 1
    std Z+{loaded}+4, r25
    ret
5:  std Z+{next}+{room}, r25 ; what is no step is not late
    std Z+{next}+{room}+1, r25
    ldd r24, Z+{next}+{pins}
    tst r24
    breq 4b
    ldd r24, Z+{loaded}+5 ; a turn
    com r24
    std Z+{loaded}+5, r24
    ret
"#
    };
}

/// Branches to load the next entry if the last group of the present one was prepared.
#[cfg(not(feature = "stream"))]
#[doc(hidden)]
#[macro_export]
macro_rules! step_load_branch {
    () => {
        "breq sw_load"
    };
}

/// The same for a larger distance.
#[cfg(feature = "stream")]
#[doc(hidden)]
#[macro_export]
macro_rules! step_load_branch {
    () => {
        "brne 9f\nrjmp sw_load\n9:"
    };
}

#[doc(hidden)]
#[macro_export]
macro_rules! step_fill_text {
    () => {
        concat!(
            r#"
.set sw_flags, 0x1E
.set sw_keep, 0x2A
.set sw_keep_sreg, 0x2B
.set sw_busy, 7
.set sw_long, 6
.set sw_a0, {axes}
.set sw_a1, {axes}+{axis}
.set sw_a2, {axes}+2*{axis}

; One late step more; from 2^24 - 1 on the highest byte stays. Uses r26.
sw_count:
    lds r26, {common}+{late}
    subi r26, 0xFF
    sts {common}+{late}, r26
    brcs 1f
    lds r26, {common}+{late}+1
    subi r26, 0xFF
    sts {common}+{late}+1, r26
    brcs 1f
    lds r26, {common}+{late}+2
    inc r26
    breq 1f
    sts {common}+{late}+2, r26
1:  ret

; ---- the next group ----

; Prepares the next group of axis Z; T is set if there is none. Uses r24 to r27.
sw_prepare:
    ldd r24, Z+{queue}+{taken} ; the entry of the present group is played, no others
    dec r24
    std Z+{queue}+{played}, r24
    ldd r24, Z+{groups}
    dec r24
"#,
            $crate::step_load_branch!(),
            r#"
    std Z+{groups}, r24
    ldd r24, Z+{next}+{wait}
    ldd r25, Z+{growth}
    add r24, r25
    std Z+{next}+{wait}, r24
    ldd r26, Z+{next}+{wait}+1
    ldd r25, Z+{growth}+1
    adc r26, r25
    std Z+{next}+{wait}+1, r26
    ldd r24, Z+{next}+{wait}+2
    ldd r25, Z+{growth}+2
    adc r24, r25
    std Z+{next}+{wait}+2, r24
    ldd r25, Z+{then}
sw_prepared: ; its interval's upper bytes in r24 and r26, its pins in r25
    std Z+{next}+{pins}, r25
    lsr r24
    ror r26
    subi r26, {look}
    sbci r24, 0
    brpl 1f ; else a deadline that has passed would not be seen
    ldi r26, 0
    ldi r24, 0
1:  lds r27, {common}+{hold}
    tst r27
    breq 2f
    ldi r24, 0x7F ; a pulse to be held goes the late way
2:  std Z+{next}+{room}, r26
    std Z+{next}+{room}+1, r24
    ldd r24, Z+{events}
    std Z+{next}+{left}, r24
    ldd r26, Z+{events}+1
    std Z+{next}+{left}+1, r26
    andi r25, {steps}
    breq 5f
    cpi r24, 1 ; a low byte of 0 is 256
    brcc 3f
    inc r26
"#,
            $crate::step_loaded_text!(),
            r#"
sw_load:
    ldd r26, Z+{queue}+{taken}
    ldd r24, Z+{queue}+{pushed}
    cp r24, r26
    breq 6f
    mov r24, r26
    inc r24
    std Z+{queue}+{taken}, r24
    andi r26, {slots} - 1
    mov r25, r26 ; times 11
    lsl r26
    add r25, r26
    lsl r26
    lsl r26
    add r26, r25
    subi r26, lo8(-({queue}+{slots_at}))
    ldi r27, 0
    add r26, r30
    adc r27, r31
    ld r24, X+
    std Z+{next}+{wait}, r24
    ld r24, X+
    std Z+{next}+{wait}+1, r24
    ld r24, X+
    std Z+{next}+{wait}+2, r24
    ld r24, X+
    std Z+{growth}, r24
    ld r24, X+
    std Z+{growth}+1, r24
    ld r24, X+
    std Z+{growth}+2, r24
    ld r24, X+
    std Z+{events}, r24
    ld r24, X+
    std Z+{events}+1, r24
    ld r24, X+
    std Z+{groups}, r24
    ld r24, X+
    std Z+{then}, r24
    ld r25, X
    ldd r24, Z+{next}+{wait}+2
    ldd r26, Z+{next}+{wait}+1
    rjmp sw_prepared
6:  set
    ret

; The next group of axis Z is the present one. 35
sw_turn:
    .set sw_byte, 0
    .rept {group}
    ldd r24, Z+{next}+sw_byte
    std Z+{now}+sw_byte, r24
    .set sw_byte, sw_byte+1
    .endr
    ret

; ---- all next groups ----

; From the foreground: r24 are axes that rest no longer. Nothing is held up, as who comes in
; between does all that is wanted.
; stepwright_refill takes r24
.global stepwright_refill
.type stepwright_refill, @function
stepwright_refill:
    sbi sw_flags, sw_busy
    lds r25, {common}+{resting}
    com r24
    and r25, r24
    sts {common}+{resting}, r25
1:  rcall sw_refill
    cbi sw_flags, sw_busy
    in r24, sw_flags
    or r24, r25
    andi r24, 0x3F
    cpi r24, 7
    breq 2f
    sbi sw_flags, sw_busy
    rjmp 1b
2:  ret

; From a step interrupt: r25 and r26 are saved already.
sw_nested:
    push r27
    push r30
    push r31
1:  rcall sw_refill
    cli ; once more, now that nothing comes in between
    in r24, sw_flags
    or r24, r25
    andi r24, 0x3F
    cpi r24, 7
    brne 1b
    cbi sw_flags, sw_busy
    pop r31
    pop r30
    pop r27
    pop r24
    out 0x3F, r24
    pop r24
    pop r26
    pop r25
    reti

; Prepares whatever is wanted, with interrupts on; r25 are the axes that rest.
sw_refill:
    sei
    sbic sw_flags, 3
    rjmp .Lsw_turn0
    sbic sw_flags, 4
    rjmp .Lsw_turn1
    sbic sw_flags, 5
    rjmp .Lsw_turn2
    in r24, sw_flags
    lds r25, {common}+{resting}
    or r24, r25
    sbrs r24, 0
    rjmp .Lsw_fill0
    sbrs r24, 1
    rjmp .Lsw_fill1
    sbrs r24, 2
    rjmp .Lsw_fill2
    ret

; Axis n: mask and bit of its interrupt, its vector.
.macro sw_fill n, a, mask, bit, flag, vector
.Lsw_turn\n: ; its group has ended
    ldi r30, lo8(\a)
    ldi r31, hi8(\a)
    sbis sw_flags, \n
    rjmp 1f
    rcall sw_turn
    cbi sw_flags, \n
    cli
.Lsw_go\n: ; on again
    cbi sw_flags, 3+\n
    lds r24, \mask
    ori r24, 1<<\bit
    sts \mask, r24
    sw_ahead\n
    brmi 2f
    rjmp sw_refill
2:  ldi r24, 1<<\bit ; its deadline has passed unseen
    out \flag, r24
    rcall \vector ; as the interrupt; which they are on after
    rjmp sw_refill
.Lsw_fill\n:
    ldi r30, lo8(\a)
    ldi r31, hi8(\a)
1:  clt
    rcall sw_prepare
    lds r24, {common}+{resting}
    brts 3f
    andi r24, 0xFF ^ (1<<\n)
    sts {common}+{resting}, r24
    lds r24, \a+{starved}
    tst r24
    brne 4f
    sbi sw_flags, \n
    rjmp sw_refill
4:  cli
    rcall sw_turn ; it waits for this
    lds r24, \a+{starved}
    ldi r25, 0
    sts \a+{starved}, r25
    cpi r24, 2
    breq 5f
    sbis sw_flags, 3+\n
    rjmp sw_refill ; its deadline is ahead
    rcall sw_count ; it came in between
5:  rcall .Lsw_now\n
    rjmp .Lsw_go\n
3:  ori r24, 1<<\n ; the queue is empty
    sts {common}+{resting}, r24
    sbis sw_flags, 3+\n
    rjmp sw_refill ; the present group is not over
    cli
    ldi r25, 0
    sts \a+{now}+{pins}, r25
    lds r24, \a+{queue}+{open}
    tst r24
    breq 6f
    lds r24, \a+{starved} ; what is next may still come in time …
    cpi r24, 1
    brlo 5f
    brne 7f
    rcall sw_count ; … and now it is late
5:  inc r24
    sts \a+{starved}, r24
7:  sts \a+{now}+{left}+1, r25
    sts \a+{now}+{room}+1, r25
    sts \a+{now}+{room}, r25
    sts \a+{now}+{wait}, r25
    ldi r25, 1
    sts \a+{now}+{left}, r25
    ldi r25, {poll}
    sts \a+{now}+{wait}+1, r25
    sts \a+{now}+{wait}+2, r25
    rjmp .Lsw_go\n
6:  sts \a+{starved}, r25 ; the end
    lds r24, \a+{queue}+{taken}
    sts \a+{queue}+{played}, r24
    cbi sw_flags, 3+\n
    rjmp sw_refill
.endm
"#
        )
    };
}
