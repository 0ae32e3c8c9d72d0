//! A loss of power at any byte leaves the old settings or the new ones.

use proptest::prelude::*;
use stepwright_device::{Memory, Store};
use stepwright_protocol::{Setting, Settings, Value};

/// An EEPROM that loses power after some writes.
#[derive(Clone)]
struct Eeprom {
    bytes: Vec<u8>,
    /// The number of writes until the loss of power.
    power: usize,
    /// The contents of the byte that was being written then; unchanged if `None`.
    torn: Option<u8>,
    /// The number of polls that a write takes.
    busy: u8,
    waiting: std::cell::Cell<u8>,
    writes: usize,
}

impl Eeprom {
    fn new(bytes: Vec<u8>) -> Eeprom {
        Eeprom {
            bytes,
            power: usize::MAX,
            torn: None,
            busy: 2,
            waiting: Default::default(),
            writes: 0,
        }
    }

    fn empty() -> Eeprom {
        Eeprom::new(vec![0xFF; Store::SIZE.into()])
    }

    /// Loads the settings after the loss of power.
    fn settings(&self) -> Settings {
        Store::load(&mut Eeprom::new(self.bytes.clone())).1
    }
}

impl Memory for Eeprom {
    fn read(&mut self, address: u16) -> u8 {
        assert_eq!(self.waiting.get(), 0, "read while writing");
        self.bytes[usize::from(address)]
    }

    fn start_write(&mut self, address: u16, byte: u8) {
        assert_eq!(self.waiting.get(), 0, "written while writing");
        self.waiting.set(self.busy);
        self.writes += 1;
        let place = &mut self.bytes[usize::from(address)];
        match self.power {
            0 => {}
            1 => *place = self.torn.unwrap_or(*place),
            _ => *place = byte,
        }
        self.power = self.power.saturating_sub(1);
    }

    fn is_writing(&self) -> bool {
        let left = self.waiting.get();
        self.waiting.set(left.saturating_sub(1));
        left != 0
    }
}

fn save(store: &mut Store, memory: &mut Eeprom, settings: &Settings) {
    store.save();
    let mut polls = 0;
    while store.is_saving() {
        store.poll(memory, settings);
        polls += 1;
        assert!(polls < 1000, "it does not end");
    }
    memory.waiting.set(0);
}

fn with(setting: Setting, number: u32) -> Settings {
    let mut settings = Settings::new();
    settings.set(Value::new(setting, number).unwrap());
    settings
}

/// Three settings that differ in many bytes.
fn three() -> [Settings; 3] {
    let mut first = with(Setting::MaxSpeed, 123_456);
    first.set(Value::new(Setting::Idle, 3_000_000).unwrap());
    let mut second = with(Setting::Pulse, 17);
    second.set(Value::new(Setting::Timeout, 54_321).unwrap());
    [first, second, with(Setting::Reverse, 5)]
}

#[test]
fn an_empty_memory_gives_the_defaults() {
    let (store, settings) = Store::load(&mut Eeprom::empty());
    assert_eq!(settings, Settings::new());
    assert!(!store.is_saving());
}

#[test]
fn what_is_saved_is_found_again_300_times_over() {
    let mut memory = Eeprom::empty();
    let (mut store, _) = Store::load(&mut memory);
    for n in 0..300 {
        let settings = with(Setting::MaxSpeed, n + 1);
        save(&mut store, &mut memory, &settings);
        assert_eq!(memory.settings(), settings);
        if n % 7 == 0 {
            store = Store::load(&mut memory).0;
        }
    }
}

#[test]
fn only_bytes_that_differ_are_written() {
    let mut memory = Eeprom::empty();
    let (mut store, _) = Store::load(&mut memory);
    for n in 1..=3 {
        save(&mut store, &mut memory, &with(Setting::Pulse, n));
    }
    let before = memory.writes;
    save(&mut store, &mut memory, &with(Setting::Pulse, 4));
    // Both marks twice, the sequence, the pulse and the sum.
    assert!(memory.writes - before <= 8, "{} bytes", memory.writes - before);
}

/// Every byte of the first save, of the second and of a later one; the byte that was being written
/// may hold anything.
#[test]
fn a_loss_of_power_leaves_the_old_settings_or_the_new_ones() {
    for saves in 0..4 {
        let mut before = Eeprom::empty();
        let (mut store, mut old) = Store::load(&mut before);
        for settings in three().iter().cycle().take(saves) {
            save(&mut store, &mut before, settings);
            old = *settings;
        }
        let new = with(Setting::MaxAccel, 77_777_777);
        let mut whole = before.clone();
        save(&mut store.clone(), &mut whole, &new);
        let writes = whole.writes - before.writes;
        let mut changes = 0;
        for power in 1..=writes {
            for torn in (0..=255).map(Some).chain([None]) {
                let mut memory = Eeprom { power, torn, ..before.clone() };
                save(&mut store.clone(), &mut memory, &new);
                let found = memory.settings();
                assert!(found == old || found == new, "byte {power} of {writes}, torn {torn:?}");
                changes += usize::from(found == new);
                // The board goes on from there.
                let mut memory = Eeprom::new(memory.bytes);
                let (mut again, _) = Store::load(&mut memory);
                let next = with(Setting::Hold, 999);
                save(&mut again, &mut memory, &next);
                assert_eq!(memory.settings(), next);
            }
        }
        assert!(changes >= 1 && writes >= 5, "{changes} changes in {writes} bytes");
    }
}

/// A change during a save, at every step of the save.
#[test]
fn a_change_in_the_middle_of_writing_is_written_as_well() {
    let [first, second, third] = three();
    for steps in 0..100 {
        let mut memory = Eeprom::empty();
        let (mut store, _) = Store::load(&mut memory);
        save(&mut store, &mut memory, &first);
        store.save();
        for _ in 0..steps {
            store.poll(&mut memory, &second);
        }
        let between = memory.settings();
        assert!(between == first || between == second, "{steps}");
        save(&mut store, &mut memory, &third);
        assert_eq!(memory.settings(), third, "{steps}");
    }
}

#[test]
fn every_flipped_bit_is_found() {
    let [first, second, _] = three();
    let mut memory = Eeprom::empty();
    let (mut store, _) = Store::load(&mut memory);
    save(&mut store, &mut memory, &first);
    let one = memory.clone();
    save(&mut store, &mut memory, &second);
    for (memory, newest, older) in [(&one, first, Settings::new()), (&memory, second, first)] {
        let mut lost = 0;
        for bit in 0..8 * usize::from(Store::SIZE) {
            let mut flipped = memory.clone();
            flipped.bytes[bit / 8] ^= 1 << (bit % 8);
            let found = flipped.settings();
            assert!(found == newest || found == older, "bit {bit}");
            lost += usize::from(found == older);
        }
        // All bytes of one copy: two marks, sequence, settings and sum.
        assert_eq!(lost, 8 * (3 + Settings::SIZE + 2));
    }
}

/// One life of a board: it is switched on, saves something, and loses power.
#[derive(Clone, Copy, Debug)]
struct Life {
    /// The setting that it saves.
    number: u32,
    /// The polls before it saves another setting, if it does.
    change: Option<usize>,
    /// The number of writes until the loss of power.
    power: usize,
    /// The contents of the byte that is being written then.
    torn: Torn,
}

#[derive(Clone, Copy, Debug)]
enum Torn {
    /// Unchanged.
    Old,
    /// Some bits are new, the others old.
    Bits(u8),
    /// Anything.
    Any(u8),
}

/// After each life, the settings found are those found before it, or those that were being written
/// when the power went, if they were written completely. So no copy comes back that was once found
/// to be lost, or that is older than the last complete one.
fn live(lives: &[Life]) -> Result<(), TestCaseError> {
    let mut memory = Eeprom::empty();
    let mut before = Settings::new();
    for life in lives {
        memory = Eeprom::new(memory.bytes);
        memory.power = life.power;
        let (mut store, found) = Store::load(&mut memory);
        prop_assert_eq!(found, before);
        let mut settings = with(Setting::MaxSpeed, life.number);
        let mut may = vec![before];
        store.save();
        if let Some(polls) = life.change {
            for _ in 0..polls {
                poll(&mut store, &mut memory, &settings, life.torn);
            }
            may.push(settings);
            settings.set(Value::new(Setting::Idle, life.number).unwrap());
            store.save();
        }
        may.push(settings);
        for _ in 0..200 {
            poll(&mut store, &mut memory, &settings, life.torn);
        }
        before = memory.settings();
        prop_assert!(may.contains(&before), "{:?} of {:?}", before, may);
        if memory.power > 0 {
            prop_assert_eq!(before, settings, "written whole");
        }
    }
    Ok(())
}

fn poll(store: &mut Store, memory: &mut Eeprom, settings: &Settings, torn: Torn) {
    // The effect of an interrupted write depends on the byte written: the poll is tried on a copy
    // first.
    let mut copy = Eeprom { power: usize::MAX, ..memory.clone() };
    store.clone().poll(&mut copy, settings);
    let wrote = (0..copy.bytes.len()).find(|&at| copy.bytes[at] != memory.bytes[at]);
    memory.torn = wrote.map(|at| {
        let (old, new) = (memory.bytes[at], copy.bytes[at]);
        match torn {
            Torn::Old => old,
            Torn::Bits(mask) => old & !mask | new & mask,
            Torn::Any(byte) => byte,
        }
    });
    store.poll(memory, settings);
    memory.waiting.set(0);
}

fn any_life() -> impl Strategy<Value = Life> {
    let torn = prop_oneof![
        Just(Torn::Old),
        any::<u8>().prop_map(Torn::Bits),
        any::<u8>().prop_map(Torn::Any),
        // The bytes with a meaning.
        proptest::sample::select(vec![0x50u8, 0x51, 0x52, 0x53, 0x54, 0x55, 0xFF])
            .prop_map(Torn::Any),
    ];
    let change = prop_oneof![4 => Just(None), 1 => (0usize..40).prop_map(Some)];
    // Few numbers, so that copies differ in few bytes, or in none.
    let number = prop_oneof![1u32..4, 1u32..1_000_000];
    let power = prop_oneof![4 => 0usize..12, 1 => 0usize..80];
    (number, change, power, torn).prop_map(|(number, change, power, torn)| Life {
        number,
        change,
        power,
        torn,
    })
}

/// The first save is cut off at its last byte, the second at its first.
#[test]
fn two_torn_writes_in_a_row_revive_nothing() {
    let mut one = Eeprom::empty();
    let (mut store, _) = Store::load(&mut one);
    let [first, second, third] = three();
    save(&mut store, &mut one, &first);
    let mut whole = one.clone();
    save(&mut store.clone(), &mut whole, &second);
    let writes = whole.writes - one.writes;
    for power in 1..=writes {
        for torn in (0..=255).step_by(17).chain(0x50..=0x5F) {
            let mut lost = Eeprom { power, torn: Some(torn), ..one.clone() };
            save(&mut store.clone(), &mut lost, &second);
            if lost.settings() != first {
                continue;
            }
            for again in 1..=4 {
                for torn in 0..=255 {
                    let mut memory = Eeprom { power: again, torn: Some(torn), ..lost.clone() };
                    let (mut store, found) = Store::load(&mut memory);
                    assert_eq!(found, first);
                    save(&mut store, &mut memory, &third);
                    let now = memory.settings();
                    assert!(now == first || now == third, "{power} of {writes}, {again} {torn}");
                }
            }
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(4000))]

    #[test]
    fn torn_writes_never_bring_an_older_copy_back(
        lives in proptest::collection::vec(any_life(), 1..12)
    ) {
        live(&lives)?;
    }
}

proptest! {
    #[test]
    fn garbage_is_no_settings(bytes in proptest::collection::vec(any::<u8>(), usize::from(Store::SIZE))) {
        let mut memory = Eeprom::new(bytes);
        let (mut store, settings) = Store::load(&mut memory);
        prop_assert_eq!(settings, Settings::new());
        let new = with(Setting::Enable, 500);
        save(&mut store, &mut memory, &new);
        prop_assert_eq!(memory.settings(), new);
    }
}
