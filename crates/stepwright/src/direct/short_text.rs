//! The direct way's assembly: see `short.rs`.
//!
//! ```text
//! track   1 due (fraction, ticks)   6 loaded (8 bytes)
//! Z       0 ready   4 delay   8 divisor   12 margin   16 rest
//!         20 shortest   24 top   28 end   32 down
//! saved   r24 in GPIOR1, SREG in GPIOR2, r25, r26, r27, Z on the stack;
//!         T: too far behind
//! ```
//!
//! A macro, because the text is assembled where the engine's static is known.

#[doc(hidden)]
#[macro_export]
macro_rules! direct_way_text {
    () => {
        r#"
.set sd_flags, 0x1E
.set sd_keep, 0x2A
.set sd_keep_sreg, 0x2B
.set sd_t0, {engine}+{tracks}
.set sd_t1, {engine}+{tracks}+{track}
.set sd_t2, {engine}+{tracks}+2*{track}
.set sd_d0, {engine}+{feeds}
.set sd_d1, {engine}+{feeds}+{feed}
.set sd_d2, {engine}+{feeds}+2*{feed}

; r25:r24 = ticks until the deadline in r25:r24. 6
.macro sd_wait
    lds r26, {tcnt}
    sub r24, r26
    lds r26, {tcnt}+1
    sbc r25, r26
.endm

; Four bytes of the travel from \at on: into registers, and back. 8
.macro sd_load a, b, c, d, at
    ldd \a, Z+\at
    ldd \b, Z+\at+1
    ldd \c, Z+\at+2
    ldd \d, Z+\at+3
.endm
.macro sd_store a, b, c, d, at
    std Z+\at, \a
    std Z+\at+1, \b
    std Z+\at+2, \c
    std Z+\at+3, \d
.endm
; Compares four bytes of the travel with registers. 12
.macro sd_compare a, b, c, d, at, by
    ldd \by, Z+\at
    cp \by, \a
    ldd \by, Z+\at+1
    cpc \by, \b
    ldd \by, Z+\at+2
    cpc \by, \c
    ldd \by, Z+\at+3
    cpc \by, \d
.endm

; r21-18 = twice the interval in r26-24 (r27: 0) and the rest.
.macro sd_twice
    movw r18, r24
    movw r20, r26
    lsl r18
    rol r19
    rol r20
    rol r21
    ldd r22, Z+16
    add r18, r22
    ldd r22, Z+17
    adc r19, r22
    ldd r22, Z+18
    adc r20, r22
    ldd r22, Z+19
    adc r21, r22
.endm

; A step of axis i, and the interval after the next one.
.macro sd_axis i, t, d, port, bit
.Lsd_to_far\i:
    rjmp .Lsd_far\i
.Lsd_serve\i:
    sbi \port, \bit
    ldi r30, lo8(\d)
    ldi r31, hi8(\d)
    ldd r24, Z+3
    tst r24
    brne .Lsd_to_far\i
    ldd r25, Z+2
    cpi r25, {near}
    brsh .Lsd_to_far\i
    lds r24, \t+1
    ldd r26, Z+0
    add r24, r26
    sts \t+1, r24
    lds r24, \t+2
    ldd r26, Z+1
    adc r24, r26
    sts \t+2, r24
    lds r26, \t+3
    adc r25, r26
    sts \t+3, r25
    sts {ocr}+1, r25
    sts {ocr}, r24
    lds r26, \t+6
    inc r26
    sts \t+6, r26
    breq .Lsd_carry\i
.Lsd_carried\i:
    cbi \port, \bit
    sd_wait
    ldd r26, Z+1
    ldd r27, Z+2
    sts \t+{own}+2, r26
    sts \t+{own}+3, r27
    lsr r27
    ror r26
    sbiw r26, {look}
    cp r24, r26
    cpc r25, r27
    brge .Lsd_in_time\i
    rcall .Lsd_late
.Lsd_in_time\i:
    rcall .Lsd_law
    brts .Lsd_behind\i
    lds r24, \t+2
    lds r25, \t+3
    sd_wait
    brpl .Lsd_done\i
    sbi {tifr}, 1 ; it may have come to match: served here, not again
    rjmp .Lsd_serve\i
.Lsd_done\i:
    rjmp .Lsd_leave

.Lsd_carry\i:
    lds r26, \t+7
    inc r26
    sts \t+7, r26
    brne .Lsd_carried\i
    lds r26, \t+8
    inc r26
    sts \t+8, r26
    brne .Lsd_carried\i
    lds r26, \t+9
    inc r26
    sts \t+9, r26
    brne .Lsd_carried\i
    lds r26, \t+10
    inc r26
    sts \t+10, r26
    rjmp .Lsd_carried\i

.Lsd_far\i: ; the engine's: as if a run had ended
    lds r24, \t+{own}+2
    lds r25, \t+{own}+3
    lsr r25
    ror r24
    sbiw r24, {reach}
    sts \t+{own}+11, r24
    sts \t+{own}+12, r25
    ldi r24, 8 ; a pulse of full width
.Lsd_hold\i:
    dec r24
    brne .Lsd_hold\i
    cbi \port, \bit
    ldi r26, 1<<\i
    rcall .Lsd_ended
    lds r24, {tcnt}
    lds r25, {tcnt}+1
    sbiw r24, 12 ; as if the look had come as after a step
    rjmp .Lsd_long

.Lsd_behind\i:
    ldi r26, 0x80
    rcall .Lsd_ended
    rjmp .Lsd_look_and_long
.endm

.macro sd_handler
    out sd_keep, r24
    in r24, 0x3F
    out sd_keep_sreg, r24
    push r25
    push r26
    push r27
    push r30
    push r31
    clt
    sbic sd_flags, 0
    rjmp .Lsd_serve0
.if {axes} > 1
    sbic sd_flags, 1
    rjmp .Lsd_serve1
.endif
.if {axes} > 2
    sbic sd_flags, 2
    rjmp .Lsd_serve2
.endif
.Lsd_look_and_long:
    lds r24, {tcnt}
    lds r25, {tcnt}+1
.Lsd_long: ; r25:r24: the timer, if an axis has ended
    push r0
    push r1
    push r18
    push r19
    push r20
    push r21
    push r22
    push r23
    clr r1
    call {long}
    pop r23
    pop r22
    pop r21
    pop r20
    pop r19
    pop r18
    pop r1
    pop r0
.Lsd_leave:
    pop r31
    pop r30
    pop r27
    pop r26
    pop r25
    in r24, sd_keep_sreg
    out 0x3F, r24
    in r24, sd_keep
    reti

.Lsd_ended: ; adds r26 to the axes that have ended
    lds r24, {engine}+{ended_at}
    or r24, r26
    sts {engine}+{ended_at}, r24
    ret

.Lsd_late: ; counts; T if it is too far behind
    lds r26, {engine}+{late_at}
    inc r26
    sts {engine}+{late_at}, r26
    brne .Lsd_counted
    lds r26, {engine}+{late_at}+1
    inc r26
    sts {engine}+{late_at}+1, r26
    brne .Lsd_counted
    lds r26, {engine}+{late_at}+2
    inc r26
    sts {engine}+{late_at}+2, r26
.Lsd_counted:
    cpi r25, 0x80
    brlo .Lsd_near
    cpi r25, 256-{far_behind}
    brsh .Lsd_near
    set
.Lsd_near:
    ret

; ready = the next interval of the travel at Z: Ramp::step.
.Lsd_law:
    push r18
    push r19
    push r20
    push r21
    push r22
    push r23
    sd_load r24, r25, r26, r27, 4
    sd_load r18, r19, r20, r21, 12
    subi r18, 1
    sbci r19, 0
    sbci r20, 0
    sbci r21, 0
    brcc .Lsd_on
    rjmp .Lsd_down
.Lsd_on:
    sd_store r24, r25, r26, r27, 0
    mov r22, r18
    or r22, r19
    or r22, r20
    or r22, r21
    breq .Lsd_margin ; the middle of an even travel
    sd_compare r24, r25, r26, r27, 20, r22
    brsh .Lsd_margin ; at top speed
    ldd r22, Z+11
    sbrc r22, 7
    rjmp .Lsd_margin ; the ramp is as long as one can be
    subi r18, 1
    sbci r19, 0
    sbci r20, 0
    sbci r21, 0
    sd_store r18, r19, r20, r21, 12
    sd_twice
    sd_load r24, r25, r26, r27, 8
    subi r24, 256-4
    sbci r25, 255
    sbci r26, 255
    sbci r27, 255
    sd_store r24, r25, r26, r27, 8
    rjmp .Lsd_divide

.Lsd_margin:
    sd_store r18, r19, r20, r21, 12
.Lsd_law_done:
    pop r23
    pop r22
    pop r21
    pop r20
    pop r19
    pop r18
    ret

.Lsd_nothing: ; the travel is over
    ldi r22, 255
    std Z+3, r22
    rjmp .Lsd_law_done

.Lsd_down:
    sd_load r18, r19, r20, r21, 8
    sd_compare r18, r19, r20, r21, 28, r22
    breq .Lsd_nothing
    sd_store r24, r25, r26, r27, 0
    ldd r22, Z+32
    tst r22
    brne .Lsd_falling
    ldi r22, 1
    std Z+32, r22
    clr r22
    sd_store r22, r22, r22, r22, 16
    sd_load r18, r19, r20, r21, 24
    or r22, r18
    or r22, r19
    or r22, r20
    or r22, r21
    breq .Lsd_falling
    movw r24, r18
    movw r26, r20
    sd_store r24, r25, r26, r27, 4
.Lsd_falling:
    sd_twice
    sd_load r24, r25, r26, r27, 8
    sbiw r24, 4
    sbci r26, 0
    sbci r27, 0
    sd_store r24, r25, r26, r27, 8
    adiw r24, 2 ; 4n-1; the low bits are 01, so there is no carry

; r21-18 / r27-24: the quotient changes the interval, the rest stays.
.Lsd_divide:
    clr r22
.Lsd_small:
    sub r18, r24
    sbc r19, r25
    sbc r20, r26
    sbc r21, r27
    brcs .Lsd_divided
    inc r22
    cpi r22, 6
    brne .Lsd_small
    rjmp .Lsd_long_division
.Lsd_divided:
    add r18, r24
    adc r19, r25
    adc r20, r26
    adc r21, r27
    sd_store r18, r19, r20, r21, 16
    mov r18, r22
    clr r19
    clr r20
    clr r21
.Lsd_quotient: ; in r21-18
    sd_load r24, r25, r26, r27, 4
    ldd r22, Z+32
    tst r22
    brne .Lsd_slower
    sub r24, r18
    sbc r25, r19
    sbc r26, r20
    sbc r27, r21
    sd_compare r24, r25, r26, r27, 20, r22
    brlo .Lsd_store
    sd_store r24, r25, r26, r27, 24 ; the top speed cuts it short
    sd_load r24, r25, r26, r27, 20
    rjmp .Lsd_store
.Lsd_slower:
    add r24, r18
    adc r25, r19
    adc r26, r20
    adc r27, r21
.Lsd_store:
    sd_store r24, r25, r26, r27, 4
    rjmp .Lsd_law_done

.Lsd_long_division: ; 6 divisors are off already
    push r0
    push r15
    push r16
    push r17
    clr r0
    clr r15
    clr r16
    clr r17
    clr r23
.Lsd_align:
    cp r18, r24
    cpc r19, r25
    cpc r20, r26
    cpc r21, r27
    brlo .Lsd_bits
    sbrc r27, 7
    rjmp .Lsd_bit ; it can't go higher
    inc r0
    lsl r24
    rol r25
    rol r26
    rol r27
    rjmp .Lsd_align
.Lsd_bits:
    tst r0
    breq .Lsd_all_bits
    dec r0
    lsr r27
    ror r26
    ror r25
    ror r24
.Lsd_bit:
    lsl r16
    rol r17
    rol r23
    rol r15
    sub r18, r24
    sbc r19, r25
    sbc r20, r26
    sbc r21, r27
    brcs .Lsd_back
    inc r16
    rjmp .Lsd_bits
.Lsd_back:
    add r18, r24
    adc r19, r25
    adc r20, r26
    adc r21, r27
    rjmp .Lsd_bits
.Lsd_all_bits:
    sd_store r18, r19, r20, r21, 16
    movw r18, r16
    mov r20, r23
    mov r21, r15
    subi r18, 256-6
    sbci r19, 255
    sbci r20, 255
    sbci r21, 255
    pop r17
    pop r16
    pop r15
    pop r0
    rjmp .Lsd_quotient

; The same for the engine: the travel in r25:r24.
.global stepwright_direct_step
.type stepwright_direct_step,@function
stepwright_direct_step:
    movw r30, r24
    rjmp .Lsd_law

    sd_axis 0, sd_t0, sd_d0, {port0}, {bit0}
.if {axes} > 1
    sd_axis 1, sd_t1, sd_d1, {port1}, {bit1}
.endif
.if {axes} > 2
    sd_axis 2, sd_t2, sd_d2, {port2}, {bit2}
.endif
.endm
"#
    };
}
