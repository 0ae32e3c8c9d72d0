//! The short way's assembly: see `short.rs`.
//!
//! ```text
//! track   0 due (fraction, ticks)   4 at   6 loaded (8 bytes)
//! queue   0 taken   1 pushed   2 open   3 slots
//! slot    0 interval   4 add   8 left (low, high)   10 group   11 room
//! GPIOR0  0-2 who steps alone   3-5 who steps   6 rare   7 several
//! saved   r24 in GPIOR1, SREG in GPIOR2, r25, r26, Z on the stack
//! ```
//!
//! A macro, because the text is assembled where the engine's static is known.

#[doc(hidden)]
#[macro_export]
macro_rules! short_way_text {
    () => {
        r#"
.set sw_flags, 0x1E
.set sw_keep, 0x2A
.set sw_keep_sreg, 0x2B
.set sw_t0, {engine}+{tracks}
.set sw_t1, {engine}+{tracks}+{track}
.set sw_t2, {engine}+{tracks}+2*{track}
.set sw_q0, {queues}
.set sw_q1, {queues}+{queue}
.set sw_q2, {queues}+2*{queue}

.macro sw_leave ; 15
    pop r31
    pop r30
    pop r26
    pop r25
    in r24, sw_keep_sreg
    out 0x3F, r24
    in r24, sw_keep
    reti
.endm

; r25:r24 = ticks until the deadline in r25:r24. 6
.macro sw_wait
    lds r26, {tcnt}
    sub r24, r26
    lds r26, {tcnt}+1
    sbc r25, r26
.endm

; Compares that with the run's room. 6
.macro sw_room
    ldd r26, Z+11
    cp r24, r26
    ldd r26, Z+12
    cpc r25, r26
.endm

; The low byte of left is 0.
.macro sw_wrapped i, w
.Lsw_wrapped\w\i:
    ldd r24, Z+9
    tst r24
    brne .Lsw_borrow\w\i
    rjmp .Lsw_reload\w\i
.Lsw_borrow\w\i:
    dec r24
    std Z+9, r24
    clr r24
    ldd r25, Z+10
    inc r25 ; a group of 255 is no growth
    brne .Lsw_counted\w\i
    rjmp .Lsw_steady\w\i
.endm

; Counts a step of axis i, lets the interval grow, and gives the next deadline
; in r25:r24. w: the labels of its caller.
.macro sw_step i, t, w
    ldd r24, Z+8
    dec r24
    std Z+8, r24
    breq .Lsw_wrapped\w\i
.Lsw_counted\w\i:
    ldd r25, Z+10
    and r25, r24
    brne .Lsw_steady\w\i
    ldd r24, Z+0
    ldd r25, Z+4
    add r24, r25
    std Z+0, r24
    ldd r24, Z+1
    ldd r25, Z+5
    adc r24, r25
    std Z+1, r24
    ldd r24, Z+2
    ldd r25, Z+6
    adc r24, r25
    std Z+2, r24
    ldd r24, Z+3
    ldd r25, Z+7
    adc r24, r25
    std Z+3, r24
.Lsw_steady\w\i:
    lds r24, \t+0
    ldd r25, Z+0
    add r24, r25
    sts \t+0, r24
    lds r24, \t+1
    ldd r25, Z+1
    adc r24, r25
    sts \t+1, r24
    lds r24, \t+2
    ldd r25, Z+2
    adc r24, r25
    sts \t+2, r24
    lds r25, \t+3
    ldd r26, Z+3
    adc r25, r26
    sts \t+3, r25
.endm

; The run has ended: the next one, in place.
.macro sw_reload i, t, q, w, mark
.Lsw_reload\w\i:
    lds r24, \q
    inc r24
    lds r25, \q+1
    cp r24, r25
    breq .Lsw_empty\w\i
    adiw r30, 13
    ldi r25, lo8(\q+3+{slots})
    cp r30, r25
    brne .Lsw_next\w\i
    ldi r30, lo8(\q+3)
    ldi r31, hi8(\q+3)
.Lsw_next\w\i:
    ldd r25, Z+12
    cpi r25, 0x80
    breq .Lsw_far\w\i
    \mark
    sts \q, r24
    sts \t+4, r30
    sts \t+5, r31
    ldd r24, Z+8
    ldd r25, Z+9
    cpi r24, 1 ; a low byte of 0 is 256 steps
    brcc .Lsw_full\w\i
    inc r25
.Lsw_full\w\i:
    lds r26, \t+6
    add r26, r24
    sts \t+6, r26
    lds r26, \t+7
    adc r26, r25
    sts \t+7, r26
    brcc .Lsw_loaded\w\i
    lds r26, \t+8
    inc r26
    sts \t+8, r26
    brne .Lsw_loaded\w\i
    lds r26, \t+9
    inc r26
    sts \t+9, r26
    brne .Lsw_loaded\w\i
    lds r26, \t+10
    inc r26
    sts \t+10, r26
.Lsw_loaded\w\i:
    rjmp .Lsw_steady\w\i

.endm

; One step of axis i, alone.
.macro sw_axis i, t, q, port, bit
    sw_wrapped \i, a
.Lsw_serve\i:
    sbi \port, \bit
    clt
    lds r30, \t+4
    lds r31, \t+5
    sw_step \i, \t, a
    sts {ocr}+1, r25
    sts {ocr}, r24
    cbi \port, \bit
    sw_wait
    brmi .Lsw_passed\i
    sw_room
    brlt .Lsw_late\i
    sw_leave

.Lsw_late\i:
    brtc .Lsw_surely\i
    adiw r24, {reloaded} ; the look was later
    sw_room
    brge .Lsw_not_late\i
.Lsw_surely\i:
    rcall .Lsw_count_late
.Lsw_not_late\i:
    rjmp .Lsw_leave
.Lsw_passed\i: ; the next deadline has come meanwhile
    sbi {tifr}, 1 ; it may have come to match: served here, not again
    sw_room
    brlt .Lsw_slowly\i
    rjmp .Lsw_serve\i
.Lsw_slowly\i:
    brtc .Lsw_too_late\i
    adiw r24, {reloaded}
    sw_room
    brlt .Lsw_too_late\i
    rjmp .Lsw_serve\i
.Lsw_too_late\i:
    rcall .Lsw_count_late
    lds r26, {engine}+{pace_at}
.Lsw_pace\i:
    dec r26
    brne .Lsw_pace\i
    rjmp .Lsw_serve\i

    sw_reload \i, \t, \q, a, set
.Lsw_fara\i: ; the next run is not for us
    ldi r26, 3
    rjmp .Lsw_ended\i
.Lsw_emptya\i:
    ldi r26, 15
.Lsw_ended\i:
    lds r24, {engine}+{ended_at}
    ori r24, 1<<\i
    sts {engine}+{ended_at}, r24
    cbi \port, \bit
    lds r24, {tcnt}
    lds r25, {tcnt}+1
    add r24, r26 ; as if the look had come as after a step
    ldi r26, 0
    adc r25, r26
    rjmp .Lsw_long
.endm

; Sees whether axis j is due, and steps; else whether it is first of the others.
.macro sw_look i, t, port, bit
    sbis sw_flags, 3+\i
    rjmp .Lsw_looked\i
    lds r24, \t+2
    lds r25, \t+3
    cp r18, r24
    cpc r19, r25
    brmi .Lsw_ahead\i
    sbi \port, \bit
    rjmp .Lsw_looked\i
.Lsw_ahead\i:
    cp r24, r22
    cpc r25, r23
    brpl .Lsw_looked\i
    movw r22, r24
.Lsw_looked\i:
.endm

; Axis i's step, if it has begun one.
.macro sw_finish i, t, q, port, bit
    sbic \port, \bit
    rjmp .Lsw_begun\i
    rjmp .Lsw_done\i
    sw_wrapped \i, b
.Lsw_begun\i:
    lds r30, \t+4
    lds r31, \t+5
    sw_step \i, \t, b
    cbi \port, \bit
    sub r24, r18
    sbc r25, r19
    sw_room
    brge .Lsw_counted_too\i
    rcall .Lsw_count
.Lsw_counted_too\i:
    add r24, r18
    adc r25, r19
    cp r24, r22
    cpc r25, r23
    brpl .Lsw_done\i
    movw r22, r24
.Lsw_done\i:
.endm

; The rare parts of that.
.macro sw_rarely i, t, q, port, bit
    sw_reload \i, \t, \q, b, nop
.Lsw_farb\i:
.Lsw_emptyb\i:
    lds r24, {engine}+{ended_at}
    ori r24, 1<<\i
    sts {engine}+{ended_at}, r24
    cbi \port, \bit
    set
    rjmp .Lsw_done\i
.endm

.macro sw_handler
    out sw_keep, r24
    in r24, 0x3F
    out sw_keep_sreg, r24
    push r25
    push r26
    push r30
    push r31
    sbic sw_flags, 0
    rjmp .Lsw_serve0
.if {axes} > 1
    sbic sw_flags, 7
    rjmp .Lsw_several
    sbic sw_flags, 1
    rjmp .Lsw_serve1
.endif
.if {axes} > 2
    sbic sw_flags, 2
    rjmp .Lsw_serve2
.endif
.Lsw_long: ; r25:r24: the timer, if an axis has ended
    push r0
    push r1
    push r18
    push r19
    push r20
    push r21
    push r22
    push r23
    push r27
    clr r1
    call {long}
    pop r27
    pop r23
    pop r22
    pop r21
    pop r20
    pop r19
    pop r18
    pop r1
    pop r0
.Lsw_leave:
    sw_leave

.Lsw_count_late: ; one axis alone: the look may have been later than usual
    push r27
    brts .Lsw_as_usual ; reloaded: allowed for
    ldd r26, Z+8
    ldd r27, Z+10
    and r27, r26
    brne .Lsw_as_usual
    adiw r24, {grown}
.Lsw_as_usual:
    pop r27
.Lsw_count: ; counts the step if r25:r24 is less than the room
    sw_room
    brge .Lsw_not_late
    lds r26, {engine}+{late_at}
    inc r26
    sts {engine}+{late_at}, r26
    brne .Lsw_counted
    lds r26, {engine}+{late_at}+1
    inc r26
    sts {engine}+{late_at}+1, r26
    brne .Lsw_counted
    lds r26, {engine}+{late_at}+2
    inc r26
    sts {engine}+{late_at}+2, r26
.Lsw_counted:
    cpi r25, 0x80 ; too far behind?
    brlo .Lsw_not_late
    cpi r25, 256-{far_behind}
    brsh .Lsw_not_late
    lds r26, {engine}+{ended_at}
    ori r26, 0x80
    sts {engine}+{ended_at}, r26
    set
    sbic sw_flags, 7
    ret
    pop r26
    pop r26
    rjmp .Lsw_long
.Lsw_not_late:
    ret

    sw_axis 0, sw_t0, sw_q0, {port0}, {bit0}
.if {axes} > 1
    sw_axis 1, sw_t1, sw_q1, {port1}, {bit1}
.endif
.if {axes} > 2
    sw_axis 2, sw_t2, sw_q2, {port2}, {bit2}
.endif

.if {axes} > 1
.Lsw_several:
    push r18
    push r19
    push r22
    push r23
.Lsw_again:
    clt
    lds r18, {tcnt}
    lds r19, {tcnt}+1
    movw r22, r18
    subi r23, 0x90 ; 0x7000 ahead
    sw_look 0, sw_t0, {port0}, {bit0}
    sw_look 1, sw_t1, {port1}, {bit1}
.if {axes} > 2
    sw_look 2, sw_t2, {port2}, {bit2}
.endif
    subi r18, 256-{edges} ; from the look before the edges to that after one
    sbci r19, 255
    sw_finish 0, sw_t0, sw_q0, {port0}, {bit0}
    sw_finish 1, sw_t1, sw_q1, {port1}, {bit1}
.if {axes} > 2
    sw_finish 2, sw_t2, sw_q2, {port2}, {bit2}
.endif
    brts .Lsw_ended
    sbic sw_flags, 6
    rjmp .Lsw_rare
    sts {ocr}+1, r23
    sts {ocr}, r22
    movw r24, r22
    sw_wait
    brmi .Lsw_more
    pop r23
    pop r22
    pop r19
    pop r18
    sw_leave
.Lsw_more:
    rjmp .Lsw_again

.Lsw_rare: ; is a rare event first?
    lds r24, {engine}+{rare_at}
    lds r25, {engine}+{rare_at}+1
    cp r24, r22
    cpc r25, r23
    brpl .Lsw_not_rare
    movw r22, r24
    set
.Lsw_not_rare:
    sts {ocr}+1, r23
    sts {ocr}, r22
    movw r24, r22
    sw_wait
    brpl .Lsw_later
    brtc .Lsw_more
.Lsw_ended: ; the long way
    movw r24, r18
    pop r23
    pop r22
    pop r19
    pop r18
    rjmp .Lsw_long
.Lsw_later:
    pop r23
    pop r22
    pop r19
    pop r18
    rjmp .Lsw_leave

    sw_rarely 0, sw_t0, sw_q0, {port0}, {bit0}
    sw_rarely 1, sw_t1, sw_q1, {port1}, {bit1}
.if {axes} > 2
    sw_rarely 2, sw_t2, sw_q2, {port2}, {bit2}
.endif
.endif
.endm
"#
    };
}
