//! The rig's connections to the simulator: pins, bytes, interrupts.
//!
//! simavr calls back in the middle of an instruction; the cycle is the one at which the instruction
//! began. All callbacks write to one [`Heard`], which lives as long as the chip.

use std::collections::VecDeque;
use std::os::raw::c_void;

use simavr_ffi as ffi;
use stepwright_sim::{Edge, Pin as Role};

use crate::board::{AXES, Board, Pin, StepTimer};
use crate::eeprom::Eeprom;
use crate::silicon::{Silicon, opaque};

/// One stay in an interrupt: the cycles of its first instruction and of the first one after its
/// RETI.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IsrSpan {
    /// The first cycle inside.
    pub entry: u64,
    /// The first cycle outside.
    pub exit: u64,
}

/// Everything observed since the chip was created, with cycles that continue through resets.
pub(crate) struct Heard {
    avr: *mut ffi::avr_t,
    /// The cycles before the last reset.
    pub base: u64,
    pub edges: Vec<Edge>,
    /// Levels of ENABLE.
    pub enable: Vec<(u64, bool)>,
    /// Levels of the LED.
    pub led: Vec<(u64, bool)>,
    /// The levels of the watched pins: cycle, index, level.
    pub watched: Vec<(u64, u8, bool)>,
    /// The bytes from USART0 with the cycle at which they are complete.
    pub said: VecDeque<(u64, u8)>,
    /// The stays in the step interrupt, if requested.
    pub visits: Vec<IsrSpan>,
    pub keep_visits: bool,
    /// The cycles in all interrupts together.
    pub inside: u64,
    /// Whether an interrupt runs now.
    pub running: bool,
    entry: u64,
    step_entry: u64,
    reti: u64,
    pub eeprom: Eeprom,
    silicon: *const Silicon,
}

/// A timer whose compare match is also computed here.
struct Match {
    timer: *mut ffi::avr_timer_t,
    of: StepTimer,
}

impl Match {
    /// The cycles after which the counter wraps.
    fn round(&self) -> u64 {
        1 << (self.of.bits + self.of.prescaler)
    }
}

/// A pin with its purpose.
struct Tap {
    heard: *mut Heard,
    wire: Wire,
    level: bool,
}

#[derive(Clone, Copy)]
enum Wire {
    Drive(u8, Role),
    Enable,
    Led,
    /// A pin that a test watches: its index.
    Watched(u8),
}

/// Owns the objects that simavr has pointers to.
pub(crate) struct Taps {
    pub heard: Box<Heard>,
    probes: Box<[Tap]>,
    /// The taps of the pins that a test watches.
    watched: Vec<Box<[Tap]>>,
    /// The corrected timers.
    _matches: Box<[Match]>,
    #[expect(clippy::vec_box, reason = "the simulator knows their addresses")]
    _watches: Vec<Box<Watch>>,
}

/// A callback for the write of a register.
type OnWrite = unsafe extern "C" fn(*mut ffi::avr_t, ffi::avr_io_addr_t, u8, param: *mut c_void);

/// A register that is watched: simavr's own way to share one has room for four.
struct Watch {
    own: Option<OnWrite>,
    own_param: *mut c_void,
    then: OnWrite,
    param: *mut c_void,
}

impl Watch {
    /// Calls `then` with `param` after each write of a register.
    fn new(
        avr: *mut ffi::avr_t,
        register: ffi::avr_io_addr_t,
        then: OnWrite,
        param: *mut c_void,
    ) -> Box<Watch> {
        // SAFETY: the registers begin after the 32 of the processor; the box does not move and
        // lives as long as the chip.
        unsafe {
            let write = &raw mut (*avr).io[usize::from(register) - 32].w;
            let (own, own_param) = ((*write).c, (*write).param);
            let mut watch = Box::new(Watch { own, own_param, then, param });
            (*write).c = Some(on_write);
            (*write).param = opaque(&mut *watch);
            watch
        }
    }
}

unsafe extern "C" fn on_write(
    avr: *mut ffi::avr_t,
    register: ffi::avr_io_addr_t,
    value: u8,
    param: *mut c_void,
) {
    // SAFETY: `param` is a watch, and its callbacks get the values that they were registered with.
    unsafe {
        let watch = &*param.cast::<Watch>();
        if let Some(own) = watch.own {
            own(avr, register, value, watch.own_param);
        } else {
            *(*avr).data.add(usize::from(register)) = value;
        }
        (watch.then)(avr, register, value, watch.param);
    }
}

impl Taps {
    /// Connects to `silicon`, which must not move.
    pub(crate) fn new(board: Board, timers: &[StepTimer], silicon: &Silicon) -> Taps {
        let avr = silicon.avr;
        let mut heard = Box::new(Heard {
            avr,
            base: 0,
            edges: Vec::new(),
            enable: Vec::new(),
            led: Vec::new(),
            watched: Vec::new(),
            said: VecDeque::new(),
            visits: Vec::new(),
            keep_visits: false,
            inside: 0,
            running: false,
            entry: 0,
            step_entry: 0,
            reti: board.reti(),
            eeprom: Eeprom::default(),
            silicon,
        });
        let mut wires = vec![(board.enable(), Wire::Enable), (board.led(), Wire::Led)];
        for axis in 0..AXES {
            wires.push((board.step()[axis], Wire::Drive(axis as u8, Role::Step)));
            wires.push((board.direction()[axis], Wire::Drive(axis as u8, Role::Direction)));
        }
        let all = &raw mut *heard;
        let tap = |&(_, wire): &(_, Wire)| Tap { heard: all, wire, level: false };
        let mut probes: Box<[Tap]> = wires.iter().map(tap).collect();
        for ((pin, _), tap) in wires.iter().zip(&mut probes) {
            // SAFETY: the boxed probes do not move and live as long as the chip.
            unsafe { ffi::avr_irq_register_notify(silicon.pin(*pin), Some(on_pin), opaque(tap)) }
        }
        let param = opaque(&mut *heard);
        // SAFETY: as above; vectors and registers are simavr's own.
        unsafe {
            ffi::avr_irq_register_notify(silicon.sent(), Some(on_byte), param);
            let table = &raw mut (*avr).interrupts;
            let running = ffi::AVR_INT_IRQ_RUNNING as usize;
            let any = &raw mut (*table).irq[running];
            ffi::avr_irq_register_notify(any, Some(on_interrupt), param);
            let step = ffi::avr_get_interrupt_irq(avr, timers[0].vector);
            assert!(!step.is_null(), "no step interrupt");
            ffi::avr_irq_register_notify(step.add(running), Some(on_step_interrupt), param);
        }
        let mut watches = Vec::new();
        // TIMSK0 … TIMSK5.
        for register in 0x6E..=0x73 {
            watches.push(Watch::new(avr, register, on_timer_mask, param));
        }
        watches.push(Watch::new(avr, EECR, on_eeprom, param));
        // The firmware's own timers.
        let mut matches: Box<[Match]> =
            timers.iter().map(|&of| Match { timer: silicon.timer(of.number), of }).collect();
        for (timer, matched) in timers.iter().zip(&mut matches) {
            watches.push(Watch::new(avr, timer.compare, on_compare_value, opaque(matched)));
        }
        Taps { heard, probes, watched: Vec::new(), _matches: matches, _watches: watches }
    }

    /// Records the levels of these pins from now on.
    pub(crate) fn watch(&mut self, silicon: &Silicon, pins: &[Pin]) {
        let all = &raw mut *self.heard;
        let tap = |which| Tap { heard: all, wire: Wire::Watched(which), level: false };
        let mut probes: Box<[Tap]> = (0..pins.len() as u8).map(tap).collect();
        for (pin, tap) in pins.iter().zip(&mut probes) {
            // SAFETY: the boxed probes do not move and live as long as the chip.
            unsafe { ffi::avr_irq_register_notify(silicon.pin(*pin), Some(on_pin), opaque(tap)) }
        }
        self.watched.push(probes);
    }

    /// After a reset every pin is an input: high pins have fallen.
    pub(crate) fn release(&mut self) {
        for tap in self.probes.iter_mut().chain(self.watched.iter_mut().flatten()) {
            if std::mem::take(&mut tap.level) {
                let time = self.heard.base;
                self.heard.note(tap.wire, time, false);
            }
        }
    }
}

impl Heard {
    fn now(&self) -> u64 {
        // SAFETY: simavr's chip outlives its callbacks and `Heard` is dropped
        // with it.
        self.base + unsafe { (*self.avr).cycle }
    }

    fn note(&mut self, wire: Wire, time: u64, level: bool) {
        match wire {
            Wire::Drive(axis, pin) => self.edges.push(Edge { time, axis, pin, level }),
            Wire::Enable => self.enable.push((time, level)),
            Wire::Led => self.led.push((time, level)),
            Wire::Watched(which) => self.watched.push((time, which, level)),
        }
    }
}

unsafe extern "C" fn on_pin(_: *mut ffi::avr_irq_t, value: u32, param: *mut c_void) {
    // SAFETY: `param` is the tap that was registered with this function; both it and `Heard` are
    // only used while no instruction runs, or in here.
    unsafe {
        let tap = &mut *param.cast::<Tap>();
        let level = value & 1 != 0;
        if tap.level != level {
            tap.level = level;
            let heard = &mut *tap.heard;
            heard.note(tap.wire, heard.now(), level);
        }
    }
}

unsafe extern "C" fn on_byte(_: *mut ffi::avr_irq_t, value: u32, param: *mut c_void) {
    // SAFETY: as in `on_pin`. simavr assumes 11 bits for a byte; it reads the time of a byte after
    // this call.
    unsafe {
        let heard = &mut *param.cast::<Heard>();
        let time = (*heard.silicon).byte_time();
        (*heard.silicon).set_byte_time(time);
        let done = heard.now() + time;
        heard.said.push_back((done, value as u8));
    }
}

/// `value` is the vector that runs now, or 0. Interrupts may nest; when the outer one continues, it
/// is reported again.
unsafe extern "C" fn on_interrupt(_: *mut ffi::avr_irq_t, value: u32, param: *mut c_void) {
    // SAFETY: as in `on_pin`.
    let heard = unsafe { &mut *param.cast::<Heard>() };
    if value == 0 {
        heard.inside += heard.now() + heard.reti - heard.entry;
        heard.running = false;
    } else if !heard.running {
        heard.entry = heard.now();
        heard.running = true;
    }
}

unsafe extern "C" fn on_step_interrupt(_: *mut ffi::avr_irq_t, value: u32, param: *mut c_void) {
    // SAFETY: as in `on_pin`.
    let heard = unsafe { &mut *param.cast::<Heard>() };
    if value != 0 {
        heard.step_entry = heard.now();
    } else if heard.keep_visits {
        let exit = heard.now() + heard.reti;
        heard.visits.push(IsrSpan { entry: heard.step_entry, exit });
    }
}

/// An interrupt that is enabled while its flag is set comes at once on a chip; simavr does not
/// raise it.
unsafe extern "C" fn on_timer_mask(
    avr: *mut ffi::avr_t,
    register: ffi::avr_io_addr_t,
    value: u8,
    _: *mut c_void,
) {
    // SAFETY: the register is inside `data`; the table holds `vector_count`
    // live vectors.
    unsafe {
        *(*avr).data.add(usize::from(register)) = value;
        let count = usize::from((*avr).interrupts.vector_count);
        for &vector in &(&(*avr).interrupts.vector)[..count] {
            let (enable, raised) = ((*vector).enable, (*vector).raised);
            let here = enable.reg() == u32::from(register);
            if here && value >> enable.bit() & 1 != 0 && (*vector).pending() == 0 {
                let flags = *(*avr).data.add(raised.reg() as usize);
                if flags >> raised.bit() & 1 != 0 {
                    ffi::avr_raise_interrupt(avr, vector);
                }
            }
        }
    }
}

/// simavr misses a match within an instruction after the counter's overflow; the chip does not. So
/// the match is computed here as well.
unsafe extern "C" fn on_compare_value(
    avr: *mut ffi::avr_t,
    register: ffi::avr_io_addr_t,
    _: u8,
    param: *mut c_void,
) {
    // SAFETY: as in `on_pin`; all bytes of the register are inside `data`.
    unsafe {
        let matched = &*param.cast::<Match>();
        let low = (*avr).data.add(usize::from(register));
        let high = if matched.of.bits > 8 { *low.add(1) } else { 0 };
        let value = u64::from(u16::from_le_bytes([*low, high]));
        let count = (*avr).cycle.wrapping_sub((*matched.timer).tov_base);
        // The flag is set one count after the counter has the value.
        let round = matched.round();
        let ahead = ((value + 1) << matched.of.prescaler).wrapping_sub(count) % round;
        let ahead = if ahead == 0 { round } else { ahead };
        ffi::avr_cycle_timer_register(avr, ahead, Some(on_match), param);
    }
}

unsafe extern "C" fn on_match(
    avr: *mut ffi::avr_t,
    when: ffi::avr_cycle_count_t,
    param: *mut c_void,
) -> ffi::avr_cycle_count_t {
    // SAFETY: as in `on_pin`; raising twice in a cycle has the effect of once.
    unsafe {
        let matched = &*param.cast::<Match>();
        let channel = &raw mut (*matched.timer).comp[matched.of.channel];
        ffi::avr_raise_interrupt(avr, &raw mut (*channel).interrupt);
        when + matched.round()
    }
}

/// EEPROM control register, the same on both chips.
const EECR: u16 = 0x3F;
/// Bit EEPE: a byte is being written.
const EEPE: u8 = 1 << 1;
/// Bit EEMPE: enables the next EEPE.
const EEMPE: u8 = 1 << 2;

/// simavr has written the byte at once; here the write continues for 3.4 ms.
unsafe extern "C" fn on_eeprom(
    avr: *mut ffi::avr_t,
    _: ffi::avr_io_addr_t,
    value: u8,
    param: *mut c_void,
) {
    // SAFETY: as in `on_pin`; the registers are inside `data`.
    unsafe {
        let heard = &mut *param.cast::<Heard>();
        let now = heard.now();
        let control = (*avr).data.add(usize::from(EECR));
        // simavr clears EEMPE when it writes.
        if value & EEPE != 0 && *control & EEMPE == 0 && !heard.eeprom.is_busy() {
            let address = u16::from_le_bytes([*(*avr).data.add(0x41), *(*avr).data.add(0x42)]);
            heard.eeprom.begin(now, address);
            let cycles = heard.eeprom.cycles();
            ffi::avr_cycle_timer_register(avr, cycles, Some(on_written), param);
        }
        if heard.eeprom.is_busy() {
            *control |= EEPE;
        }
    }
}

unsafe extern "C" fn on_written(
    avr: *mut ffi::avr_t,
    _: ffi::avr_cycle_count_t,
    param: *mut c_void,
) -> ffi::avr_cycle_count_t {
    // SAFETY: as in `on_eeprom`.
    unsafe {
        (*param.cast::<Heard>()).eeprom.end();
        *(*avr).data.add(usize::from(EECR)) &= !EEPE;
    }
    0
}
