//! The documents' tables, and the property of every table: its field turns.

extern crate std;
use super::*;
use std::vec::Vec;

fn rows_of(sequence: &Sequence) -> Vec<u8> {
    (0..sequence.len()).map(|phase| sequence.levels(phase)).collect()
}

/// The current in both windings, each −1 to 1.
type Field = (f64, f64);

fn shield(levels: u8) -> Field {
    let sign = |bit: u8| if levels >> bit & 1 != 0 { 1.0 } else { -1.0 };
    (sign(0), sign(1))
}

fn bridge(levels: u8) -> Field {
    let winding = |a: u8, b: u8| f64::from(levels >> a & 1) - f64::from(levels >> b & 1);
    (winding(0, 1), winding(2, 3))
}

/// Phases A and C are the halves of one winding, B and D of the other.
fn unipolar(levels: u8) -> Field {
    let winding = |a: u8, b: u8| f64::from(levels >> a & 1) - f64::from(levels >> b & 1);
    (winding(0, 2), winding(1, 3))
}

fn l6219_field(levels: u8) -> Field {
    let current = |shift: u8| [1.0, 0.67, 0.33, 0.0][usize::from(levels >> shift & 3)];
    let (one, two) = shield(levels);
    (one * current(2), two * current(4))
}

/// A table, the field of its lines, and the degrees of its step.
type Row = (Sequence, fn(u8) -> Field, f64);

const ALL: [Row; 10] = [
    (SHIELD, shield, 90.0),
    (BRIDGE_FULL, bridge, 90.0),
    (BRIDGE_WAVE, bridge, 90.0),
    (BRIDGE_HALF, bridge, 45.0),
    (UNIPOLAR_FULL, unipolar, 90.0),
    (UNIPOLAR_WAVE, unipolar, 90.0),
    (UNIPOLAR_HALF, unipolar, 45.0),
    (L6219_FULL, l6219_field, 90.0),
    (L6219_HALF, l6219_field, 45.0),
    (L6219_QUARTER, l6219_field, 22.5),
];

#[test]
fn the_documents_tables() {
    // D12 and D13: 00, 10, 11, 01.
    assert_eq!(rows_of(&SHIELD), [0b00, 0b01, 0b11, 0b10]);
    // 1001, 1100, 0110, 0011 from A on the left; a 1 does not conduct.
    let not_conducting = [[1, 0, 0, 1], [1, 1, 0, 0], [0, 1, 1, 0], [0, 0, 1, 1]];
    for (row, digits) in rows_of(&UNIPOLAR_FULL).iter().zip(not_conducting) {
        let conducting = digits.iter().rev().fold(0, |all, digit| all << 1 | (1 - digit));
        assert_eq!(*row, conducting);
    }
    // Gray order of the L6219's phases.
    let phases: Vec<_> = rows_of(&L6219_FULL).iter().map(|row| row & 3).collect();
    assert_eq!(phases, [0b00, 0b01, 0b11, 0b10]);
}

/// Forward turns the field by a step, in the same direction for every table.
#[test]
fn every_table_turns_the_field_by_its_step() {
    for (number, (sequence, field, degrees)) in ALL.into_iter().enumerate() {
        let angle = |phase: u8| {
            let (a, b) = field(sequence.levels(phase));
            b.atan2(a).to_degrees()
        };
        for phase in 0..sequence.len() {
            let turned = (angle(sequence.after(phase, true)) - angle(phase)).rem_euclid(360.0);
            // 33 % to 100 % is 18.3°, not 22.5°.
            assert!((turned - degrees).abs() < 4.3, "table {number}, {phase}: {turned}°");
            assert_eq!(sequence.after(sequence.after(phase, true), false), phase);
        }
        assert_eq!(f64::from(sequence.len()) * degrees, 360.0);
    }
}

#[test]
fn finer_tables_contain_the_coarser_ones_in_step() {
    for (coarse, fine, every) in [
        (BRIDGE_FULL, BRIDGE_HALF, 2),
        (UNIPOLAR_FULL, UNIPOLAR_HALF, 2),
        (L6219_HALF, L6219_QUARTER, 2),
    ] {
        for phase in 0..coarse.len() {
            assert_eq!(coarse.levels(phase), fine.levels(phase * every));
        }
    }
    // The full step's angle is that of the half step, at another current.
    for phase in 0..4 {
        assert_eq!(L6219_FULL.levels(phase) & 3, L6219_HALF.levels(phase * 2) & 3);
    }
}

#[test]
fn the_l6219s_torque_is_even() {
    for (sequence, low, high) in [(L6219_HALF, 0.94, 1.0), (L6219_QUARTER, 0.94, 1.06)] {
        for row in rows_of(&sequence) {
            let (a, b) = l6219_field(row);
            assert!((low..=high).contains(&a.hypot(b)), "{row:06b}: {}", a.hypot(b));
        }
        let (a, b) = l6219_field(sequence.off());
        assert_eq!((a.abs(), b.abs()), (0.0, 0.0));
    }
}

#[test]
fn tables_move_to_any_bits() {
    let moved = UNIPOLAR_FULL.on_bits(&[5, 2, 1, 0]); // D4, D39, D40, D41 of port G
    let bits = |row: u8| [row >> 5 & 1, row >> 2 & 1, row >> 1 & 1, row & 1];
    for phase in 0..4 {
        let row = UNIPOLAR_FULL.levels(phase);
        assert_eq!(bits(moved.levels(phase)), [row & 1, row >> 1 & 1, row >> 2 & 1, row >> 3]);
    }
    assert!(L6219_HALF.on_bits(&[0, 1, 2, 3, 4, 5]).rests() && !moved.rests());
    assert_eq!(SHIELD.inverted().levels(0), 0b11);
    assert_eq!(L6219_FULL.on_bits(&[0, 1, 2, 3, 4, 5]).off(), L6219_OFF);
    assert_eq!(SHIELD.on_bits(&[9, 200]).levels(2), 0); // no such bits
}

#[test]
fn what_is_no_table_is_refused() {
    assert_eq!(Sequence::new(&[1, 2, 4], 7), Err(BadSequence::Length));
    assert_eq!(Sequence::new(&[1], 1), Err(BadSequence::Length));
    assert_eq!(Sequence::new(&[0; 32], 1), Err(BadSequence::Length));
    assert_eq!(Sequence::new(&[1, 2, 4, 8], 7), Err(BadSequence::Outside));
}
