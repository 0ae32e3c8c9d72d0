//! The assembly of the step interrupts: see `step.rs`.
//!
//! ```text
//! axis    now: interval 3, room 2, left 2, pins 1   next: the same
//!         growth 3, events 2, groups, then          due 3   starved   loaded 5
//!         queue: taken, pushed, open, played, backward, slots
//! GPIOR0  0-2 the next group is ready   3-5 it is waited for, with the axis's own
//!         interrupt off   6 axis 3 of an Uno waits long   7 a refill is at work
//! saved   r24 in GPIOR1, SREG in GPIOR2, r25 and r26 on the stack
//! ```
//!
//! A macro, because a program that has no queue does without it.

#[doc(hidden)]
#[macro_export]
macro_rules! step_text {
    () => {
        r#"
.set sw_flags, 0x1E
.set sw_keep, 0x2A
.set sw_keep_sreg, 0x2B
.set sw_busy, 7
.set sw_long, 6
.set sw_a0, {axes}
.set sw_a1, {axes}+{axis}
.set sw_a2, {axes}+2*{axis}

; One late step more. Uses r26.
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
    breq sw_load
    std Z+{groups}, r24
    ldd r24, Z+{next}
    ldd r25, Z+{growth}
    add r24, r25
    std Z+{next}, r24
    ldd r26, Z+{next}+1
    ldd r25, Z+{growth}+1
    adc r26, r25
    std Z+{next}+1, r26
    ldd r24, Z+{next}+2
    ldd r25, Z+{growth}+2
    adc r24, r25
    std Z+{next}+2, r24
    ldd r25, Z+{then}
sw_prepared: ; its interval's upper bytes in r24 and r26, its pins in r25
    std Z+{next}+7, r25
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
2:  std Z+{next}+3, r26
    std Z+{next}+4, r24
    ldd r24, Z+{events}
    std Z+{next}+5, r24
    ldd r26, Z+{events}+1
    std Z+{next}+6, r26
    andi r25, {steps}
    breq 5f
    cpi r24, 1 ; a low byte of 0 is 256
    brcc 3f
    inc r26
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
5:  std Z+{next}+3, r25 ; what is no step is not late
    std Z+{next}+4, r25
    ret
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
    std Z+{next}, r24
    ld r24, X+
    std Z+{next}+1, r24
    ld r24, X+
    std Z+{next}+2, r24
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
    ldd r24, Z+{next}+2
    ldd r26, Z+{next}+1
    rjmp sw_prepared
6:  set
    ret

; The next group of axis Z is the present one. 35
sw_turn:
    ldd r24, Z+{next}
    std Z+{now}, r24
    ldd r24, Z+{next}+1
    std Z+{now}+1, r24
    ldd r24, Z+{next}+2
    std Z+{now}+2, r24
    ldd r24, Z+{next}+3
    std Z+{now}+3, r24
    ldd r24, Z+{next}+4
    std Z+{now}+4, r24
    ldd r24, Z+{next}+5
    std Z+{now}+5, r24
    ldd r24, Z+{next}+6
    std Z+{now}+6, r24
    ldd r24, Z+{next}+7
    std Z+{now}+7, r24
    ret

; ---- all next groups ----

; From the foreground.
.global stepwright_refill
.type stepwright_refill, @function
stepwright_refill:
    cli
    sbi sw_flags, sw_busy
    rcall sw_refill
    sei
    ret

; From a step interrupt: r25 and r26 are saved already.
sw_nested:
    push r27
    push r30
    push r31
    rcall sw_refill
    pop r31
    pop r30
    pop r27
    pop r24
    out 0x3F, r24
    pop r24
    pop r26
    pop r25
    reti

; Prepares whatever is wanted, with interrupts on; they are off in the end.
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
    cli ; once more, now that nothing comes in between
    in r24, sw_flags
    or r24, r25
    andi r24, 0x3F
    cpi r24, 7
    brne sw_refill
    cbi sw_flags, sw_busy
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
    cli
    lds r24, {common}+{resting}
    brts 3f
    andi r24, 0xFF ^ (1<<\n)
    sts {common}+{resting}, r24
    lds r24, \a+{starved}
    tst r24
    brne 4f
    sbi sw_flags, \n
    rjmp sw_refill
4:  rcall sw_turn ; it waits for this
    lds r24, \a+{starved}
    ldi r25, 0
    sts \a+{starved}, r25
    sbis sw_flags, 3+\n
    rjmp sw_refill
    cpi r24, 1 ; its deadline came in between
    brne .Lsw_go\n
    rcall sw_count
    rjmp .Lsw_go\n
3:  ori r24, 1<<\n ; the queue is empty
    sts {common}+{resting}, r24
    sbis sw_flags, 3+\n
    rjmp sw_refill ; the present group is not over
    ldi r25, 0
    sts \a+{now}+7, r25
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
7:  sts \a+{now}+6, r25
    sts \a+{now}+4, r25
    sts \a+{now}+3, r25
    sts \a+{now}, r25
    ldi r25, 1
    sts \a+{now}+5, r25
    ldi r25, {poll}
    sts \a+{now}+1, r25
    sts \a+{now}+2, r25
    rjmp .Lsw_go\n
6:  sts \a+{starved}, r25 ; the end
    lds r24, \a+{queue}+{taken}
    sts \a+{queue}+{played}, r24
    cbi sw_flags, 3+\n
    rjmp sw_refill
.endm

; ---- the step ----

.macro sw_leave ; 11
    pop r26
    pop r25
    in r24, sw_keep_sreg
    out 0x3F, r24
    in r24, sw_keep
    reti
.endm

; Counts an event; over: where to go when it was the group's last. 6
.macro sw_counted a, over
    lds r24, \a+{now}+5
    dec r24
    sts \a+{now}+5, r24
    brne 1f
    lds r24, \a+{now}+6
    subi r24, 1
    brcs \over
    sts \a+{now}+6, r24
1:
.endm

; From a step interrupt: a refill is not at work. Others may come in at once.
.macro sw_begin_refill
    sbi sw_flags, sw_busy
    in r24, sw_keep
    push r24
    in r24, sw_keep_sreg
    sei
    push r24
    rjmp sw_nested
.endm

; The group of axis n is over.
.macro sw_over n, a, mask, bit
.Lsw_over\n:
    lds r24, {mask2}
    sbrs r24, {bit2}
    rjmp 1f ; no third axis: nobody waits long
    sbis sw_flags, sw_busy
    rjmp .Lsw_wait\n
1:  sbis sw_flags, \n
    rjmp .Lsw_wait\n
    cbi sw_flags, \n
    lds r24, \a+{next}
    sts \a+{now}, r24
    lds r24, \a+{next}+1
    sts \a+{now}+1, r24
    lds r24, \a+{next}+2
    sts \a+{now}+2, r24
    lds r24, \a+{next}+3
    sts \a+{now}+3, r24
    lds r24, \a+{next}+4
    sts \a+{now}+4, r24
    lds r24, \a+{next}+5
    sts \a+{now}+5, r24
    lds r24, \a+{next}+6
    sts \a+{now}+6, r24
    lds r24, \a+{next}+7
    sts \a+{now}+7, r24
    sbis sw_flags, sw_busy
    rjmp 2f
    sw_leave
.Lsw_wait\n: ; its interrupt waits until the next one is there
    sbi sw_flags, 3+\n
    lds r24, \mask
    andi r24, 0xFF ^ (1<<\bit)
    sts \mask, r24
    sbic sw_flags, sw_busy
    rjmp .Lsw_leave\n
2:  sw_begin_refill
.endm

; A late step of axis n: r25:r24 are the ticks to the next deadline.
.macro sw_rarely n, a
.Lsw_late\n:
    lds r26, {common}+{hold}
    tst r26
    brne 1f
    rcall sw_count
    rjmp 3f
1:  push r27 ; the pulse is held, and the room not told
    lds r26, \a+{now}+1
    lds r27, \a+{now}+2
    lsr r27
    ror r26
    subi r26, {look}
    sbci r27, 0
    brpl 1f
    ldi r26, 0
    ldi r27, 0
1:  cp r24, r26
    cpc r25, r27
    brge 2f
    rcall sw_count
2:  lds r26, {common}+{hold}
1:  dec r26
    brne 1b
    pop r27
3:
.endm

; An axis on a compare register of 16 bits.
.macro sw_wide vector, n, a, ocr, bit
.global \vector
.type \vector, @function
\vector:
    sw_enter
    out sw_keep, r24
    in r24, 0x3F
    out sw_keep_sreg, r24
    push r25
    push r26
.Lsw_serve\n:
    lds r24, \a+{now}+7
    sw_out\n
    lds r24, \a+{due}
    lds r25, \a+{now}
    add r24, r25
    sts \a+{due}, r24
    lds r24, \ocr
    lds r25, \a+{now}+1
    adc r24, r25
    lds r25, \ocr+1
    lds r26, \a+{now}+2
    adc r25, r26
    sts \ocr+1, r25
    sts \ocr, r24
    lds r26, {tcnt}
    sub r24, r26
    lds r26, {tcnt}+1
    sbc r25, r26
    lds r26, \a+{now}+3
    cp r24, r26
    lds r26, \a+{now}+4
    cpc r25, r26
    brlt .Lsw_late\n
.Lsw_intime\n:
    sw_drop\n
    lds r24, \a+{now}+5
    dec r24
    sts \a+{now}+5, r24
    breq .Lsw_zero\n
.Lsw_leave\n:
    sw_leave
.Lsw_zero\n:
    lds r24, \a+{now}+6
    subi r24, 1
    brcs 1f
    sts \a+{now}+6, r24
    sw_leave
1:  rjmp .Lsw_over\n
    sw_rarely \n, \a
    tst r25
    brmi 1f
    rjmp .Lsw_intime\n
1:  ; The next deadline has passed: that step as soon as it may be.
    sw_drop\n
    sw_counted \a, 4f
    cpi r25, {slip}
    brsh 2f
    lds r24, {tcnt} ; too far behind: from now on
    lds r25, {tcnt}+1
    sts \ocr+1, r25
    sts \ocr, r24
2:  ldi r24, 1<<\bit
    out {tifr}, r24
    in r24, sw_keep
    push r24
    in r24, sw_keep_sreg
    push r24
    lds r26, {common}+{pace}
    sei
3:  dec r26
    brne 3b
    cli
    pop r24
    out sw_keep_sreg, r24
    pop r24
    out sw_keep, r24
    rjmp .Lsw_serve\n
4:  rjmp .Lsw_wait\n
    sw_over \n, \a, {mask}, \bit
.endm

; Ticks until the deadline of an axis, as a sign.
.macro sw_ahead_wide ocr
    lds r24, \ocr
    lds r25, \ocr+1
    lds r26, {tcnt}
    sub r24, r26
    lds r26, {tcnt}+1
    sbc r25, r26
.endm
"#
    };
}

/// The Uno's three: OCR1A, OCR1B and OCR2A.
#[cfg(feature = "uno")]
#[doc(hidden)]
#[macro_export]
macro_rules! step_board_text {
    () => {
        r#"
.macro sw_out0
    out 0x09, r24
.endm
.macro sw_out1
    out 0x09, r24
.endm
.macro sw_out2
    out 0x09, r24
.endm
.macro sw_drop0
    cbi 0x0B, 2
.endm
.macro sw_drop1
    cbi 0x0B, 3
.endm
.macro sw_drop2
    cbi 0x0B, 4
.endm
.macro sw_ahead0
    sw_ahead_wide {ocr}
.endm
.macro sw_ahead1
    sw_ahead_wide {ocr}+2
.endm
.macro sw_ahead2 ; its match may come 8 ticks after its deadline
    lds r24, sw_a2+{due}+1
    lds r25, sw_a2+{due}+2
    lds r26, {tcnt}
    sub r24, r26
    lds r26, {tcnt}+1
    sbc r25, r26
    adiw r24, 8
.endm
    sw_fill 0, sw_a0, {mask}, 1, {tifr}, __vector_{vector0}
    sw_fill 1, sw_a1, {mask}, 2, {tifr}, __vector_{vector1}
    sw_fill 2, sw_a2, 0x70, 1, 0x17, __vector_{vector2}
    sw_wide __vector_{vector0}, 0, sw_a0, {ocr}, 1
    sw_wide __vector_{vector1}, 1, sw_a1, {ocr}+2, 2

; The third axis: 8 bits of 8 cycles each, and a deadline of 16 bits of one.
.global __vector_{vector2}
.type __vector_{vector2}, @function
__vector_{vector2}:
    sw_enter
    out sw_keep, r24
    in r24, 0x3F
    out sw_keep_sreg, r24
    push r25
    push r26
    sbic sw_flags, sw_long
    rjmp .Lsw_turns
.Lsw_serve2:
    lds r24, sw_a2+{now}+7
    sw_out2
    lds r24, sw_a2+{due}
    lds r25, sw_a2+{now}
    add r24, r25
    sts sw_a2+{due}, r24
    lds r24, sw_a2+{due}+1
    lds r25, sw_a2+{now}+1
    adc r24, r25
    sts sw_a2+{due}+1, r24
    lds r25, sw_a2+{due}+2
    lds r26, sw_a2+{now}+2
    adc r25, r26
    sts sw_a2+{due}+2, r25
    cpi r26, 7
    brsh .Lsw_far
.Lsw_near:
    mov r26, r24 ; the deadline / 8: three bits of r25, five of r24
    eor r26, r25
    andi r26, 0xF8
    eor r26, r25
    swap r26
    lsl r26
    brcc 1f
    inc r26
1:  sts 0xB3, r26
    lds r26, {tcnt}
    sub r24, r26
    lds r26, {tcnt}+1
    sbc r25, r26
    lds r26, sw_a2+{now}+3
    cp r24, r26
    lds r26, sw_a2+{now}+4
    cpc r25, r26
    brlt .Lsw_late2
.Lsw_intime2:
    sw_drop2
    lds r24, sw_a2+{now}+5
    dec r24
    sts sw_a2+{now}+5, r24
    breq .Lsw_zero2
.Lsw_leave2:
    sw_leave
.Lsw_zero2:
    lds r24, sw_a2+{now}+6
    subi r24, 1
    brcs 1f
    sts sw_a2+{now}+6, r24
    sw_leave
1:  rjmp .Lsw_over2
.Lsw_far: ; more than one turn of the timer
    sbi sw_flags, sw_long
    rjmp .Lsw_near
.Lsw_turns: ; is it due, or is this turn not the last?
    lds r24, {tcnt}
    lds r26, sw_a2+{due}+1
    sub r24, r26
    lds r25, {tcnt}+1
    lds r26, sw_a2+{due}+2
    sbc r25, r26
    brmi .Lsw_leave2
    cbi sw_flags, sw_long
    rjmp .Lsw_serve2
    sw_rarely 2, sw_a2
    adiw r24, 8 ; so late may its match be
    brmi 1f
    rjmp .Lsw_intime2
1:  sw_drop2
    sw_counted sw_a2, 4f
    cpi r25, {slip}
    brsh 2f
    lds r24, {tcnt}
    lds r25, {tcnt}+1
    sts sw_a2+{due}+1, r24
    sts sw_a2+{due}+2, r25
2:  in r24, sw_keep
    push r24
    in r24, sw_keep_sreg
    push r24
    ldi r26, 0
    sts 0x70, r26
    lds r26, {common}+{pace}
    sei
3:  dec r26
    brne 3b
    cli
    ldi r24, 2
    out 0x17, r24
    sts 0x70, r24
    cbi sw_flags, sw_long
    pop r24
    out sw_keep_sreg, r24
    pop r24
    out sw_keep, r24
    rjmp .Lsw_serve2
4:  rjmp .Lsw_wait2
    sw_over 2, sw_a2, 0x70, 1
"#
    };
}

/// The Mega's three: A, B and C of one timer. DIR of the second and third axis is on
/// port H, so that pins 1 << 3 mean a turn there.
#[cfg(feature = "mega")]
#[doc(hidden)]
#[macro_export]
macro_rules! step_board_text {
    () => {
        r#"
.macro sw_out0
    out 0x0C, r24
.endm
.macro sw_out1
    sbrc r24, 3
    rjmp .Lsw_side1
    out 0x0C, r24
.Lsw_sided1:
.endm
.macro sw_out2
    sbrc r24, 3
    rjmp .Lsw_side2
    out 0x12, r24
.Lsw_sided2:
.endm
.macro sw_drop0
    cbi 0x0E, 4
.endm
.macro sw_drop1
    cbi 0x0E, 5
.endm
.macro sw_drop2
    cbi 0x14, 5
.endm
.macro sw_ahead0
    sw_ahead_wide {ocr}
.endm
.macro sw_ahead1
    sw_ahead_wide {ocr}+2
.endm
.macro sw_ahead2
    sw_ahead_wide {ocr}+4
.endm
    sw_fill 0, sw_a0, {mask}, 1, {tifr}, __vector_{vector0}
    sw_fill 1, sw_a1, {mask}, 2, {tifr}, __vector_{vector1}
    sw_fill 2, sw_a2, {mask}, 3, {tifr}, __vector_{vector2}
    sw_wide __vector_{vector0}, 0, sw_a0, {ocr}, 1
    sw_wide __vector_{vector1}, 1, sw_a1, {ocr}+2, 2
    sw_wide __vector_{vector2}, 2, sw_a2, {ocr}+4, 3
.Lsw_side1:
    ldi r24, 1<<3
    sts 0x100, r24
    rjmp .Lsw_sided1
.Lsw_side2:
    ldi r24, 1<<4
    sts 0x100, r24
    rjmp .Lsw_sided2
"#
    };
}
