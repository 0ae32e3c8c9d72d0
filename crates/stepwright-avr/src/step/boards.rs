//! Pins and compare registers of the boards, for the step interrupts in `play.rs`.

/// The Uno's channels: OCR1A, OCR1B and OCR2A.
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
    lds r24, sw_a2+{now}+{pins}
    sw_out2
    lds r24, sw_a2+{due}
    lds r25, sw_a2+{now}+{wait}
    add r24, r25
    sts sw_a2+{due}, r24
    lds r24, sw_a2+{due}+1
    lds r25, sw_a2+{now}+{wait}+1
    adc r24, r25
    sts sw_a2+{due}+1, r24
    lds r25, sw_a2+{due}+2
    lds r26, sw_a2+{now}+{wait}+2
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
    lds r26, sw_a2+{now}+{room}
    cp r24, r26
    lds r26, sw_a2+{now}+{room}+1
    cpc r25, r26
    brlt .Lsw_late2
.Lsw_intime2:
    sw_drop2
    lds r24, sw_a2+{now}+{left}
    dec r24
    sts sw_a2+{now}+{left}, r24
    breq .Lsw_zero2
.Lsw_leave2:
    sw_leave
.Lsw_zero2:
    lds r24, sw_a2+{now}+{left}+1
    subi r24, 1
    brcs 1f
    sts sw_a2+{now}+{left}+1, r24
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
    sw_slips sw_a2, 3f, 2f
3:  rcall .Lsw_now2
2:  ldi r26, 0
    sts 0x70, r26
    rcall sw_pause
    ldi r24, 2
    out 0x17, r24
    sts 0x70, r24
    cbi sw_flags, sw_long
    rjmp .Lsw_serve2
4:  rjmp .Lsw_wait2
    sw_over 2, sw_a2, 0x70, 1
.Lsw_now2:
    lds r24, {tcnt}
    lds r25, {tcnt}+1
    sts sw_a2+{due}+1, r24
    sts sw_a2+{due}+2, r25
    ret
"#
    };
}

/// The Mega's channels: A, B and C of one timer. DIR of the second and third axis is on port H, so
/// pins 1 << 3 mean a turn there.
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
