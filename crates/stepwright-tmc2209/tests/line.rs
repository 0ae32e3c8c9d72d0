//! Registers according to the data sheet, over a line with noise.

use std::cell::RefCell;
use std::rc::Rc;

use crate::bench;
use crate::model::{
    CHOPCONF, Chip, DRV_STATUS, Delay, Framing, GCONF, GSTAT, IFCNT, IHOLD_IRUN, IOIN, SGTHRS,
    SLAVECONF, TCOOLTHRS, Wire, crc,
};
use stepwright::Speed;
use stepwright_tmc2209::{DriverAddress, DriverError, DriverFault, DriverSetup, Tmc2209};

/// Plays a scenario with a driver at address 2 of a chip.
fn with(chip: &Rc<RefCell<Chip>>, play: impl AsyncFnOnce(&mut Tmc2209<Wire, Delay>)) {
    bench::with(|bench, motors| {
        let mut driver = Tmc2209::new(
            Wire(Rc::clone(chip), Rc::clone(&bench.around)),
            Delay(Rc::clone(&bench.around)),
            DriverAddress::A2,
        );
        let task = Box::pin(async move { play(&mut driver).await });
        bench.run(motors, [task as _]);
    });
}

fn chip() -> Rc<RefCell<Chip>> {
    Rc::new(RefCell::new(Chip::new(2)))
}

const SETUP: DriverSetup =
    DriverSetup::new(110, 800).hold(400).microsteps(16).stall(60, Speed::of::<2_000>());

/// The registers of `SETUP`, computed by hand: 0.180 V / 0.13 Ω / √2 = 979 mA in 32 steps, so 800
/// mA are 26 steps and 400 mA 13; 12 MHz · 16 / 256 / 2,000 Hz = 375.
const WRITTEN: [(usize, u32); 7] = [
    (SLAVECONF, 2 << 8), // several drivers on a wire need 2 at least
    (GCONF, 1 << 6 | 1 << 7 | 1 << 8),
    (IHOLD_IRUN, 12 | 25 << 8 | 8 << 16),
    (CHOPCONF, 3 | 5 << 4 | 2 << 15 | 1 << 17 | 4 << 24 | 1 << 28),
    (SGTHRS, 60),
    (TCOOLTHRS, 375),
    (GSTAT, 0),
];

#[test]
fn checksums_are_those_of_others() {
    // Requests to read GCONF and IOIN, as other programs send them.
    assert_eq!(crc(&[0x05, 0x00, 0x00]), 0x48);
    assert_eq!(crc(&[0x05, 0x00, 0x06]), 0x6F);
}

#[test]
fn a_driver_is_set_up() {
    let chip = chip();
    with(&chip, async |driver| driver.set_up(&SETUP).await.unwrap());
    for (register, value) in WRITTEN {
        let real = chip.borrow().registers[register];
        assert_eq!(real, value, "{register:#x}: {real:#x}, not {value:#x}");
    }
}

/// Half of the lowest currents is below the step of 30.6 mA: the lowest step is used instead. An
/// explicit current at rest is refused with its name.
#[test]
fn the_lowest_currents_are_set_up() {
    let chip = chip();
    for (run, steps, hold) in [(31, 0, 0), (50, 0, 0), (61, 0, 0), (62, 1, 0), (124, 3, 1)] {
        with(&chip, async |driver| {
            driver.set_up(&DriverSetup::new(110, run)).await.unwrap();
            assert_eq!(
                chip.borrow().registers[IHOLD_IRUN],
                hold | steps << 8 | 8 << 16,
                "{run} mA"
            );
        });
    }
    with(&chip, async |driver| {
        let Err(DriverError::Range(range)) = driver.set_up(&SETUP.hold(20)).await else {
            panic!("20 mA at rest")
        };
        assert_eq!(range.to_string(), "current at rest out of range: 31 to 979 mA, or 0");
    });
}

/// Whichever byte is corrupted: of a request, of its echo or of an answer.
#[test]
fn a_spoiled_byte_is_made_good() {
    let clean = chip();
    with(&clean, async |driver| driver.set_up(&SETUP).await.unwrap());
    let bytes = clean.borrow().passed;
    assert!(bytes > 200);
    for (spoiled, framing) in (0..bytes).flat_map(|byte| [(byte, false), (byte, true)]) {
        let chip = chip();
        chip.borrow_mut().spoiled = Some(spoiled);
        chip.borrow_mut().framing = framing;
        with(&chip, async |driver| driver.set_up(&SETUP).await.unwrap());
        for (register, value) in WRITTEN {
            assert_eq!(chip.borrow().registers[register], value, "byte {spoiled}: {register:#x}");
        }
    }
}

#[test]
fn who_does_not_answer_or_obey_is_told() {
    let silent = chip();
    silent.borrow_mut().silent = true;
    with(&silent, async |driver| {
        assert_eq!(driver.set_up(&SETUP).await, Err(DriverError::Silent));
        assert_eq!(driver.set_run_current(100).await, Err(DriverError::NotSetUp));
        assert_eq!(driver.restore_current().await, Err(DriverError::NotSetUp));
    });
    let deaf = chip();
    deaf.borrow_mut().deaf = true;
    with(&deaf, async |driver| {
        assert_eq!(driver.set_up(&SETUP).await, Err(DriverError::NotTaken));
    });
    let other = chip();
    other.borrow_mut().registers[IOIN] = 0x30 << 24;
    with(&other, async |driver| {
        assert_eq!(driver.set_up(&SETUP).await, Err(DriverError::OtherChip(0x30)));
    });
}

/// A line that is out of order is an error, and no endless loop.
#[test]
fn a_line_that_fails_or_ends_is_told() {
    let broken = chip();
    broken.borrow_mut().broken = true;
    with(&broken, async |driver| {
        assert_eq!(driver.set_up(&SETUP).await, Err(DriverError::Line(Framing)));
    });
    let ended = chip();
    ended.borrow_mut().ended = true;
    with(&ended, async |driver| {
        assert_eq!(driver.set_up(&SETUP).await, Err(DriverError::Silent));
    });
}

/// Answers that came after their time, or for a future that was dropped, are no answers to later
/// requests.
#[test]
fn old_answers_are_dropped() {
    let chip = chip();
    with(&chip, async |driver| {
        driver.set_up(&SETUP).await.unwrap();
        for _ in 0..5 {
            chip.borrow_mut().answer(IFCNT);
        }
        let before = chip.borrow().registers[IFCNT];
        assert_eq!(driver.set_run_current(500).await, Ok(()));
        assert_eq!(chip.borrow().registers[IFCNT], before + 1);
    });
}

/// Wherever a second set-up fails, the motor's current is never above the one requested later.
#[test]
fn a_failed_set_up_leaves_no_old_scale() {
    let low = SETUP;
    let high = DriverSetup::new(110, 1_500);
    for (first, second) in [(low, high), (high, low)] {
        for writes in 0..10 {
            let chip = chip();
            with(&chip, async |driver| {
                driver.set_up(&first).await.unwrap();
                chip.borrow_mut().silent_in = Some(writes);
                assert_eq!(driver.set_up(&second).await, Err(DriverError::Silent));
                chip.borrow_mut().silent = false;
                let set = driver.set_run_current(700).await;
                let real = chip.borrow().milliamps();
                assert!(set == Err(DriverError::NotSetUp) || real <= 700, "{writes}: {real} mA");
                assert_eq!(driver.restore_current().await, Err(DriverError::NotSetUp));
                driver.set_up(&second).await.unwrap();
                assert_eq!(driver.set_run_current(700).await, Ok(()));
                assert!((640..=700).contains(&chip.borrow().milliamps()));
            });
        }
    }
}

/// A chip that loses its settings during its set-up is not taken for one that is set up.
#[test]
fn a_reset_during_the_set_up_is_told() {
    let mut told = 0;
    for writes in 0..20 {
        let chip = chip();
        chip.borrow_mut().reset_in = Some(writes);
        with(&chip, async |driver| match driver.set_up(&SETUP).await {
            Ok(()) => {
                for (register, value) in WRITTEN {
                    let real = chip.borrow().registers[register];
                    assert_eq!(real, value, "reset in write {writes}: {register:#x}");
                }
            }
            Err(error) => {
                assert_eq!(error, DriverError::Reset);
                assert_eq!(driver.set_run_current(500).await, Err(DriverError::NotSetUp));
                told += 1;
            }
        });
    }
    assert!(told > 5, "{told}");
}

/// Refused before anything is written.
#[test]
fn what_is_out_of_range_is_refused() {
    let chip = chip();
    with(&chip, async |driver| {
        for bad in [
            DriverSetup::new(110, 1_800),
            DriverSetup::new(110, 10),
            SETUP.hold(1_000),
            SETUP.microsteps(24),
            SETUP.microsteps(512),
            SETUP.microsteps(0),
            SETUP.stall(10, Speed::ZERO),
            SETUP.microsteps(1).stall(10, Speed::of::<50_000>()),
        ] {
            let refused = driver.set_up(&bad).await;
            assert!(matches!(refused, Err(DriverError::Range(_))), "{bad:?}: {refused:?}");
        }
        driver.set_up(&SETUP).await.unwrap();
        // Above the range of the sensitivity that the set-up chose.
        assert!(driver.set_run_current(980).await.is_err());
        driver.set_run_current(500).await.unwrap();
    });
    let chip = chip.borrow();
    // 500 of 979 mA in 32 steps: 16 steps.
    assert_eq!(chip.currents.iter().map(|(_, steps)| *steps).collect::<Vec<_>>(), [25, 15]);
}

/// Bits of DRV_STATUS and GSTAT according to the data sheet.
#[test]
fn faults_have_names() {
    let bits = [
        (DRV_STATUS, 0, DriverFault::Hot, "nearly overheated"),
        (DRV_STATUS, 1, DriverFault::Overheated, "overheated"),
        (DRV_STATUS, 2, DriverFault::ShortToGroundA, "coil A shorted to ground"),
        (DRV_STATUS, 3, DriverFault::ShortToGroundB, "coil B shorted to ground"),
        (DRV_STATUS, 4, DriverFault::ShortToSupplyA, "coil A shorted to the supply"),
        (DRV_STATUS, 5, DriverFault::ShortToSupplyB, "coil B shorted to the supply"),
        (DRV_STATUS, 6, DriverFault::OpenLoadA, "coil A perhaps not connected"),
        (DRV_STATUS, 7, DriverFault::OpenLoadB, "coil B perhaps not connected"),
        (GSTAT, 0, DriverFault::Reset, "it has lost its settings"),
        (GSTAT, 1, DriverFault::SwitchedOff, "switched off by an error"),
        (GSTAT, 2, DriverFault::ChargePump, "the charge pump's voltage is too low"),
    ];
    let chip = chip();
    with(&chip, async |driver| {
        for (register, bit, fault, words) in bits {
            chip.borrow_mut().registers[GSTAT] = 0;
            chip.borrow_mut().registers[DRV_STATUS] = 0xC01F_0F00;
            assert!(driver.faults().await.unwrap().is_empty());
            chip.borrow_mut().registers[register] |= 1 << bit;
            let faults = driver.faults().await.unwrap();
            assert_eq!(faults.iter().collect::<Vec<_>>(), [fault]);
            assert_eq!(faults.to_string(), words);
            let hint = [DriverFault::Hot, DriverFault::OpenLoadA, DriverFault::OpenLoadB];
            assert_eq!(faults.lets_go(), !hint.contains(&fault));
        }
        chip.borrow_mut().registers[GSTAT] = 0b111;
        driver.forget_faults().await.unwrap();
        assert_eq!(chip.borrow().registers[GSTAT], 0);
    });
}
