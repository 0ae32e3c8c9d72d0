//! The validation cases of the Arduino driver as published: the orders, and the dumps of the main loop.
//!
//! Only what can be checked is here: the logs' patterns and the host's times are left out, and numbers that
//! changed while they were printed are repaired.

use stepwright_timed::{Control, SetSpeed};

/// A validation case.
#[derive(Clone, Copy, Debug)]
pub struct Case {
    /// The call.
    pub order: SetSpeed,
    /// The dumps, in order.
    pub log: &'static [Row],
}

/// The top, its modification, the steps left, the time and the updates left of a dump.
pub type Row = [u32; 5];

/// The value of `millis()` at the call, in both logs.
pub const CALL_MS: u32 = 1_009;
/// The time from the call to the first dump of the main loop.
pub const FIRST_DUMP_MS: f64 = 166.9;
/// The time between two dumps.
pub const DUMP_EVERY_MS: f64 = 1_001.0;

const VARIABLE: Control = Control::DRV_EN.and(Control::SPEED_VARIABLE).and(Control::VARIABLE_PWR);

/// Slower while the motor spins, until 8900 steps are made.
pub const CASE_1: Case = Case {
    order: SetSpeed {
        control: VARIABLE.and(Control::IRQ_TIMING),
        top: 15_000,
        limit: 8_900,
        modification: 64,
        update_ms: 1_000,
        mod_counts: 19,
    },
    log: CASE_1_LOG,
};

/// Faster while the motor spins, without an end.
pub const CASE_2: Case = Case {
    order: SetSpeed {
        control: VARIABLE.and(Control::IRQ_TIMING).and(Control::FASTER),
        top: 4_800_000,
        limit: 0,
        modification: 2_385_000,
        update_ms: 1_000,
        mod_counts: 11,
    },
    log: CASE_2_LOG,
};

/// As case 2, but checked by the main loop every [`POLL_MS`], until 10000 steps are made. It has no log.
pub const CASE_3: Case = Case {
    order: SetSpeed { control: VARIABLE.and(Control::FASTER), limit: 10_000, ..CASE_2.order },
    log: &[],
};

/// How often the main loop of case 3 checks.
pub const POLL_MS: u32 = 50;

const CASE_1_LOG: &[Row] = &[
    [15_000, 64, 8_722, 1_009, 19],
    [15_064, 128, 7_656, 2_009, 18],
    [15_192, 256, 6_594, 3_009, 17],
    [15_448, 512, 5_543, 4_009, 16],
    [15_960, 1_024, 4_512, 5_009, 15],
    [16_984, 2_048, 3_519, 6_009, 14],
    [19_032, 4_096, 2_593, 7_009, 13],
    [23_128, 8_192, 1_777, 8_009, 12],
    [31_320, 16_384, 1_116, 9_009, 11],
    [47_704, 32_768, 634, 10_009, 10],
    [80_472, 65_536, 326, 11_009, 9],
    [146_008, 131_072, 143, 12_009, 8],
    [277_080, 262_144, 42, 13_009, 7],
];

const CASE_2_LOG: &[Row] = &[
    [4_800_000, 2_385_000, 0, 1_009, 11],
    [4_800_000, 2_385_000, 0, 1_009, 11],
    [1_222_500, 596_250, 0, 3_009, 9],
    [626_250, 298_125, 0, 4_009, 8],
    [328_125, 149_062, 0, 5_009, 7],
    [179_063, 74_531, 0, 6_009, 6],
    [104_532, 37_265, 0, 7_009, 5],
    [67_267, 18_632, 0, 8_009, 4],
    [48_635, 9_316, 0, 9_009, 3],
    [39_319, 4_658, 0, 10_009, 2],
    [34_661, 2_329, 0, 11_009, 1],
];
