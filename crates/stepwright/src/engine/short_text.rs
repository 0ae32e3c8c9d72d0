//! The short way's assembly: see `short.rs`.
//!
//! ```text
//! track   0 due (fraction, ticks)   4 interval   8 add   12 left (low, high)
//!         14 group   15 suspect   17 loaded (8 bytes)
//! queue   0 taken   1 pushed   2 open   3 slots of 13 bytes, as a track's 4 to 16
//! GPIOR0  0-2 whose deadline it is   3-5 who steps   6 rare   7 several
//! saved   r24 in GPIOR1, SREG in GPIOR2, r25 and r26 on the stack
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
.set sw_f0, {engine}+{feeds}
.set sw_f1, {engine}+{feeds}+2
.set sw_f2, {engine}+{feeds}+4

.macro sw_leave ; 11
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

; Branches if that is less than the run's suspect. 7
.macro sw_suspect t, to
    lds r26, \t+15
    cp r24, r26
    lds r26, \t+16
    cpc r25, r26
    brlt \to
.endm

; One step of axis i, and all that can follow.
.macro sw_axis i, t, f, port, bit

.Lsw_wrapped\i: ; the low byte of left is 0
    lds r24, \t+13
    tst r24
    brne .Lsw_borrow\i
    rjmp .Lsw_reload\i
.Lsw_borrow\i:
    dec r24
    sts \t+13, r24
    clr r24
    rjmp .Lsw_counted\i

.Lsw_serve\i:
    sbi \port, \bit
    lds r24, \t+12
    dec r24
    sts \t+12, r24
    breq .Lsw_wrapped\i
.Lsw_counted\i:
    lds r25, \t+14
    and r25, r24
    brne .Lsw_steady\i
    lds r24, \t+4
    lds r25, \t+8
    add r24, r25
    sts \t+4, r24
    lds r24, \t+5
    lds r25, \t+9
    adc r24, r25
    sts \t+5, r24
    lds r24, \t+6
    lds r25, \t+10
    adc r24, r25
    sts \t+6, r24
    lds r24, \t+7
    lds r25, \t+11
    adc r24, r25
    sts \t+7, r24
.Lsw_steady\i:
    lds r24, \t+0
    lds r25, \t+4
    add r24, r25
    sts \t+0, r24
    lds r24, \t+1
    lds r25, \t+5
    adc r24, r25
    sts \t+1, r24
    lds r24, \t+2
    lds r25, \t+6
    adc r24, r25
    sts \t+2, r24
    lds r25, \t+3
    lds r26, \t+7
    adc r25, r26
    sts \t+3, r25
    sts {ocr}+1, r25
    sts {ocr}, r24
    cbi \port, \bit
    sw_wait
    brmi .Lsw_passed\i
    sw_suspect \t, .Lsw_suspect\i
    sbic sw_flags, 7
    rjmp .Lsw_select\i
    sw_leave

.Lsw_passed\i: ; the next deadline has come meanwhile
    sw_suspect \t, .Lsw_suspect\i
    sbis sw_flags, 7
    rjmp .Lsw_serve\i
    rjmp .Lsw_select\i

.Lsw_suspect\i:
    lds r24, {tcnt}
    lds r25, {tcnt}+1
    ldi r26, \i
    rjmp .Lsw_long

.Lsw_far\i: ; the next run is not for us
    ldi r26, 12+\i
    rjmp .Lsw_ended\i
.Lsw_empty\i:
    ldi r26, 8+\i
.Lsw_ended\i:
    pop r31
    pop r30
    lds r24, {tcnt}
    lds r25, {tcnt}+1
    cbi \port, \bit
    rjmp .Lsw_long

.Lsw_reload\i:
    push r30
    push r31
    lds r30, \f
    lds r31, \f+1
    ld r24, Z
    ldd r25, Z+1
    cp r24, r25
    breq .Lsw_empty\i
    andi r24, {mask}
    mov r25, r24 ; 13 times
    lsl r24
    add r24, r25
    lsl r24
    lsl r24
    add r24, r25
    add r30, r24
    brcc .Lsw_page\i
    inc r31
.Lsw_page\i:
    ldd r24, Z+15
    cpi r24, 0x80
    breq .Lsw_far\i
    sts \t+16, r24
    ldd r24, Z+14
    sts \t+15, r24
    ldd r24, Z+11
    ldd r25, Z+12
    sts \t+12, r24
    sts \t+13, r25
    cpi r24, 1 ; a low byte of 0 is 256 steps
    brcc .Lsw_count\i
    inc r25
.Lsw_count\i:
    lds r26, \t+17
    add r26, r24
    sts \t+17, r26
    lds r26, \t+18
    adc r26, r25
    sts \t+18, r26
    brcc .Lsw_loaded\i
    lds r26, \t+19
    inc r26
    sts \t+19, r26
    brne .Lsw_loaded\i
    lds r26, \t+20
    inc r26
    sts \t+20, r26
    brne .Lsw_loaded\i
    lds r26, \t+21
    inc r26
    sts \t+21, r26
.Lsw_loaded\i:
    cbi \port, \bit
    ldd r24, Z+13
    sts \t+14, r24
    ldd r24, Z+7
    sts \t+8, r24
    ldd r24, Z+8
    sts \t+9, r24
    ldd r24, Z+9
    sts \t+10, r24
    ldd r24, Z+10
    sts \t+11, r24
    ldd r26, Z+3
    sts \t+4, r26
    lds r24, \t+0
    add r24, r26
    sts \t+0, r24
    ldd r26, Z+4
    sts \t+5, r26
    lds r24, \t+1
    adc r24, r26
    sts \t+1, r24
    ldd r26, Z+5
    sts \t+6, r26
    lds r24, \t+2
    adc r24, r26
    sts \t+2, r24
    ldd r26, Z+6
    sts \t+7, r26
    lds r25, \t+3
    adc r25, r26
    sts \t+3, r25
    sts {ocr}+1, r25
    sts {ocr}, r24
    lds r30, \f
    lds r31, \f+1
    ld r26, Z
    inc r26
    st Z, r26
    pop r31
    pop r30
    sw_wait
    subi r24, 256-{later}
    sbci r25, 255
    sw_suspect \t, .Lsw_suspect_reloaded\i
    subi r24, {later}
    sbci r25, 0
    sbic sw_flags, 7
    rjmp .Lsw_select\i
    brmi .Lsw_again\i
    rjmp .Lsw_leave
.Lsw_again\i:
    rjmp .Lsw_serve\i

.Lsw_suspect_reloaded\i:
    lds r24, {tcnt}
    lds r25, {tcnt}+1
    ldi r26, 4+\i
    rjmp .Lsw_long
.endm

; Whose deadline is first? Compares axis j with the one in r25:r24. 9
.macro sw_compare j, t, better
    sbis sw_flags, 3+\j
    rjmp 1f
    lds r26, \t+2
    cp r26, r24
    lds r26, \t+3
    cpc r26, r25
    brmi \better
1:
.endm

; Axis i's deadline to r25:r24. 4
.macro sw_due t
    lds r24, \t+2
    lds r25, \t+3
.endm

; Axis i is first.
.macro sw_first i
.Lsw_first\i:
    sbic sw_flags, 6
    rjmp .Lsw_rare\i
.Lsw_sure\i:
    sts {ocr}+1, r25
    sts {ocr}, r24
    sw_wait
    brpl .Lsw_ahead\i
    rjmp .Lsw_serve\i
.Lsw_ahead\i:
    in r24, sw_flags
    andi r24, 0xF8
    ori r24, 1<<\i
    out sw_flags, r24
    sw_leave
.Lsw_rare\i:
    lds r26, {engine}+{rare}
    cp r26, r24
    lds r26, {engine}+{rare}+1
    cpc r26, r25
    brpl .Lsw_sure\i
    rjmp .Lsw_rare
.endm

.macro sw_handler
    out sw_keep, r24
    in r24, 0x3F
    out sw_keep_sreg, r24
    push r25
    push r26
    sbic sw_flags, 0
    rjmp .Lsw_serve0
.if {axes} > 1
    sbic sw_flags, 1
    rjmp .Lsw_serve1
.endif
.if {axes} > 2
    sbic sw_flags, 2
    rjmp .Lsw_serve2
.endif
.Lsw_rarely:
    ldi r26, 0xFF
.Lsw_long: ; r26: from where; r25:r24: the timer
    push r0
    push r1
    push r18
    push r19
    push r20
    push r21
    push r22
    push r23
    push r27
    push r30
    push r31
    clr r1
    mov r22, r24
    mov r23, r25
    mov r24, r26
    call {long}
    pop r31
    pop r30
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

    sw_axis 0, sw_t0, sw_f0, {port0}, {bit0}
.if {axes} > 1
    sw_axis 1, sw_t1, sw_f1, {port1}, {bit1}
.endif
.if {axes} > 2
    sw_axis 2, sw_t2, sw_f2, {port2}, {bit2}
.endif

.Lsw_select0:
    sw_due sw_t0
.if {axes} > 1
    sw_compare 1, sw_t1, .Lsw_1or2
.endif
.Lsw_0or2:
.if {axes} > 2
    sw_compare 2, sw_t2, .Lsw_to2
.endif
    sw_first 0
.if {axes} > 2
.Lsw_to2:
    rjmp .Lsw_is2
.endif
.if {axes} > 1
.Lsw_1or2:
    sw_due sw_t1
.Lsw_still1or2:
.if {axes} > 2
    sw_compare 2, sw_t2, .Lsw_to2
.endif
    sw_first 1
.Lsw_select1:
    sw_due sw_t1
    sw_compare 0, sw_t0, .Lsw_is0or2
    rjmp .Lsw_still1or2
.Lsw_is0or2:
    sw_due sw_t0
    rjmp .Lsw_0or2
.endif
.if {axes} > 2
.Lsw_is2:
    sw_due sw_t2
    sw_first 2
.Lsw_select2:
    sw_due sw_t2
    sw_compare 0, sw_t0, .Lsw_0or1
    sw_compare 1, sw_t1, .Lsw_is1
    rjmp .Lsw_first2
.Lsw_0or1:
    sw_due sw_t0
    sw_compare 1, sw_t1, .Lsw_is1
    rjmp .Lsw_first0
.Lsw_is1:
    sw_due sw_t1
    rjmp .Lsw_first1
.endif

.Lsw_rare: ; a rare event is first
    lds r24, {engine}+{rare}
    lds r25, {engine}+{rare}+1
    sts {ocr}+1, r25
    sts {ocr}, r24
    sw_wait
    brmi .Lsw_now_rare
    in r24, sw_flags
    andi r24, 0xF8
    out sw_flags, r24
    rjmp .Lsw_leave
.Lsw_now_rare:
    rjmp .Lsw_rarely
.endm
"#
    };
}
