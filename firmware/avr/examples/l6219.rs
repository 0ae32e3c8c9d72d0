//! Austin's L6219, which needs all levels of a motor's windings: quarter steps on six pins of one
//! port.
//!
//! | | PHASE1 | PHASE2 | I01 | I11 | I02 | I12 |
//! | --- | --- | --- | --- | --- | --- | --- |
//! | Uno, port B | D8 | D9 | D10 | D11 | D12 | D13 |
//! | Mega, port A | D22 | D23 | D24 | D25 | D26 | D27 |
//!
//! 803 accelerating quarter steps forward; then 401 back. The current goes on with each order and
//! off an interval after its last step. The EEPROM keeps the phase at which the motor stands then:
//! at the next power-up the phase is restored, and no step is lost.
#![no_std]
#![no_main]
#![feature(abi_avr_interrupt)]

use stepwright::drive::sequence::L6219_QUARTER;
use stepwright_avr::chip::EEPROM;
use stepwright_avr::eeprom::Eeprom;
use stepwright_avr::timed::{Windings, example};
use stepwright_device::Memory;
use stepwright_timed::{Control, Model, SetSpeed};

#[cfg(feature = "uno")]
stepwright_avr::timed_motor!(
    /// The motor on timer 1.
    mod motor, Timer1, PortB, TIMER1_COMPA
);
#[cfg(feature = "mega")]
stepwright_avr::timed_motor!(
    /// The motor on timer 1.
    mod motor, Timer1, PortA, TIMER1_COMPA
);

const ON: Control = Control::DRV_EN;

const ORDERS: [SetSpeed; 2] = [
    SetSpeed {
        control: ON.and(Control::SPEED_VARIABLE).and(Control::IRQ_TIMING).and(Control::FASTER),
        top: 48_000,
        limit: 803,
        modification: 1_000,
        update_ms: 20,
        mod_counts: 30,
    },
    SetSpeed { limit: 401, ..SetSpeed::fixed(ON.and(Control::DIRECTION), 24_000) },
];

/// Milliseconds from the end of one order to the next.
const PAUSE: u32 = 100;
/// The address of the phase in the EEPROM. A byte that was never written is not a phase.
const PLACE: u16 = 0;
const PHASES: u8 = L6219_QUARTER.len();

#[avr_device::entry]
fn main() -> ! {
    // SAFETY: called once, with interrupts off.
    let mut held = unsafe { motor::take((L6219_QUARTER, 0b11_1111), 0) };
    // SAFETY: nothing else has it.
    let mut memory = Eeprom::new(unsafe { EEPROM::steal() });
    let phase = memory.read(PLACE);
    held.restore(if phase < PHASES { phase } else { 0 });
    // SAFETY: called once, and everything that an interrupt uses is set up.
    let (mut console, mut driver) = unsafe { example::start(Model::Ideal) };
    for order in ORDERS {
        let now = console.millis();
        driver.set_speed(&mut held, &order, now);
        while held.is_moving() {
            console.millis();
        }
        let phase = held.phase();
        memory.start_write(PLACE, phase);
        console.text("phase ");
        console.number(phase.into());
        console.line("");
        let now = console.millis();
        console.wait_until(now.wrapping_add(PAUSE));
    }
    loop {}
}
