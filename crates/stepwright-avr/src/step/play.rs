//! The step interrupts: see `step.rs`, and `fill.rs` for the layout.
//!
//! r24 is saved in GPIOR1, SREG in GPIOR2, r25 and r26 on the stack.
//!
//! A macro, so that a program without queues does not contain it.

#[doc(hidden)]
#[macro_export]
macro_rules! step_play_text {
    () => {
        r#"
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
    lds r24, \a+{now}+{left}
    dec r24
    sts \a+{now}+{left}, r24
    brne 1f
    lds r24, \a+{now}+{left}+1
    subi r24, 1
    brcs \over
    sts \a+{now}+{left}+1, r24
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
    .set sw_byte, 0
    .rept {group}
    lds r24, \a+{next}+sw_byte
    sts \a+{now}+sw_byte, r24
    .set sw_byte, sw_byte+1
    .endr
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

; A pulse is held, and the room not told: the interval's upper bytes in r27 and r26.
sw_held:
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
    ret

; Interrupts are on for a late step's pause.
sw_pause:
    in r24, sw_keep
    push r24
    in r24, sw_keep_sreg
    push r24
    lds r26, {common}+{pace}
    sei
1:  dec r26
    brne 1b
    cli
    pop r24
    out sw_keep_sreg, r24
    pop r24
    out sw_keep, r24
    ret

; Whether the schedule slips: too far behind (r25 is the upper byte of that), or at steps which follow one
; another sooner than late ones can. Uses r26.
.macro sw_slips a, yes, no
    cpi r25, {slip}
    brlo \yes
    lds r26, \a+{now}+{wait}+2
    tst r26
    brne \no
    lds r26, \a+{now}+{wait}+1
    cpi r26, {caught}
    brsh \no
.endm

; A late step of axis n: r25:r24 are the ticks to the next deadline.
.macro sw_rarely n, a
.Lsw_late\n:
    lds r26, {common}+{hold}
    tst r26
    brne 1f
    rcall sw_count
    rjmp 3f
1:  push r27
    lds r26, \a+{now}+{wait}+1
    lds r27, \a+{now}+{wait}+2
    rcall sw_held
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
    lds r24, \a+{now}+{pins}
    sw_out\n
    lds r24, \a+{due}
    lds r25, \a+{now}+{wait}
    add r24, r25
    sts \a+{due}, r24
    lds r24, \ocr
    lds r25, \a+{now}+{wait}+1
    adc r24, r25
    lds r25, \ocr+1
    lds r26, \a+{now}+{wait}+2
    adc r25, r26
    sts \ocr+1, r25
    sts \ocr, r24
    lds r26, {tcnt}
    sub r24, r26
    lds r26, {tcnt}+1
    sbc r25, r26
    lds r26, \a+{now}+{room}
    cp r24, r26
    lds r26, \a+{now}+{room}+1
    cpc r25, r26
    brlt .Lsw_late\n
.Lsw_intime\n:
    sw_drop\n
    lds r24, \a+{now}+{left}
    dec r24
    sts \a+{now}+{left}, r24
    breq .Lsw_zero\n
.Lsw_leave\n:
    sw_leave
.Lsw_zero\n:
    lds r24, \a+{now}+{left}+1
    subi r24, 1
    brcs 1f
    sts \a+{now}+{left}+1, r24
    sw_leave
1:  rjmp .Lsw_over\n
    sw_rarely \n, \a
    tst r25
    brmi 1f
    rjmp .Lsw_intime\n
1:  ; The next deadline has passed: that step as soon as it may be.
    sw_drop\n
    sw_counted \a, 4f
    sw_slips \a, 3f, 2f
3:  rcall .Lsw_now\n
2:  ldi r24, 1<<\bit
    out {tifr}, r24
    rcall sw_pause
    rjmp .Lsw_serve\n
4:  rjmp .Lsw_wait\n
    sw_over \n, \a, {mask}, \bit
.Lsw_now\n: ; the schedule goes on from now on
    lds r24, {tcnt}
    lds r25, {tcnt}+1
    sts \ocr+1, r25
    sts \ocr, r24
    ret
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
