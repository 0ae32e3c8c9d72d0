//! Records: what is decoded is what was encoded, and nothing is decoded that can't be.

use proptest::prelude::*;
use stepwright::entry::Wiring;
use stepwright_stream::frame::FILL;
use stepwright_stream::record::{self, FAR, Record, RecordAct, RecordBytes, Trail};

fn acts() -> impl Strategy<Value = RecordAct> {
    prop_oneof![
        (1u16..).prop_map(RecordAct::Steps),
        (1u16..300).prop_map(RecordAct::Steps),
        (0u8..=8, 2u8..).prop_map(|(bits, count)| RecordAct::Groups { bits, count }),
        (0u8..8, any::<bool>())
            .prop_map(|(halvings, goes_on)| RecordAct::Step { halvings, goes_on }),
        (0u8..8, any::<bool>()).prop_map(|(halvings, turn)| RecordAct::Wait { halvings, turn }),
    ]
}

/// Such as a fitter makes, with whole sixteenths where a record has no more.
fn records() -> impl Strategy<Value = Record> {
    (acts(), 72u32 << 8..FAR, prop_oneof![Just(0i32), -4_000i32..4_000, -0x1F_0000..0x1F_0000])
        .prop_map(|(act, interval, growth)| {
            let grows = matches!(act, RecordAct::Groups { .. });
            let few = !matches!(act, RecordAct::Steps(64..)) && (!grows || act.steps() < 64);
            let mask = if few { !15 } else { !0 };
            let growth = if grows { growth & mask as i32 } else { 0 };
            Record { act, interval: interval & mask, growth }
        })
}

proptest! {
    #[test]
    fn a_chain_comes_back(chain in prop::collection::vec((0u8..3, records()), 1..60)) {
        let (mut sent, mut heard) = ([Trail::NONE; 3], [Trail::NONE; 3]);
        let (mut bytes, mut kept) = (Vec::new(), Vec::new());
        for (axis, record) in chain {
            let trail = &mut sent[usize::from(axis)];
            let one = RecordBytes::new(axis, &record, trail);
            let apart = i64::from(record.interval) - i64::from(trail.next() & 0xFF_FFFF);
            let few = matches!(record.act, RecordAct::Step { .. } | RecordAct::Wait { .. })
                || record.act.steps() < 64;
            // 22 bits: whole sixteenths reach any wait of a few steps.
            prop_assert!(one.is_some() || !few || apart.abs() >= 1 << 25 || record.growth.abs() >= 1 << 20);
            prop_assert!(one.is_some() || apart.abs() >= 1 << 21, "{:?} behind {:?}", record, trail);
            if let Some(one) = one {
                bytes.extend(one.as_bytes());
                trail.pass(&record);
                kept.push((axis, record));
            }
        }
        let chain = kept;
        prop_assert!(!bytes.windows(4).any(|four| four == [FILL; 4]));
        let mut bytes = bytes.into_iter();
        for (axis, record) in &chain {
            let head = bytes.next().unwrap();
            prop_assert_eq!(record::axis_of(head), Some(*axis));
            let trail = &mut heard[usize::from(*axis)];
            let got = record::decode(head, trail, || bytes.next().unwrap());
            prop_assert_eq!(got, *record);
        }
        prop_assert_eq!(bytes.next(), None);
        prop_assert_eq!(sent, heard);
    }

    /// No bytes make it panic, and what is playable keeps the promise of an entry.
    #[test]
    fn any_bytes_are_some_record(bytes in prop::collection::vec(any::<u8>(), 8), last: u32, growth: i32) {
        let mut trail = Trail { last, growth, halvings: 0, moves: true };
        let mut rest = bytes[1..].iter().copied();
        let record = record::decode(bytes[0], &mut trail, || rest.next().unwrap_or(0));
        if record.is_playable(72) {
            let entry = record.entry(Wiring::new(1, 2));
            for (_, _, wait) in [entry.groups().next(), entry.groups().last()].into_iter().flatten() {
                prop_assert!((72 << 16..0x7F00 << 16).contains(&wait), "{:?} {:x}", record, wait);
            }
        }
    }

    /// An entry lasts as long as its record says, and has its steps.
    #[test]
    fn an_entry_is_its_record(record in records()) {
        prop_assume!(record.is_playable(72));
        let (mut time, mut steps) = (0u64, 0);
        for (pins, events, wait) in record.entry(Wiring::new(1, 2)).groups() {
            time += u64::from(events) * u64::from(wait >> 8);
            steps += if pins == 1 { events } else { 0 };
        }
        prop_assert_eq!((time, steps), (record.time(), record.act.steps()));
    }
}
