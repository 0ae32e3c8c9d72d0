//! Frames through a board's link: whole, spoilt, repeated, without room.

use proptest::prelude::*;
use stepwright_stream::credit::{Answered, Credit, CreditReader};
use stepwright_stream::frame::{FILL, FrameBytes, Kind, LONGEST, MOST};
use stepwright_stream::link::{Came, FrameLink};
use stepwright_stream::send::{FrameSender, LinkTimes};

/// What a link makes of bytes, and what its FIFO has then.
fn heard(link: &mut FrameLink<256>, bytes: &[u8]) -> Vec<Came> {
    let came = bytes.iter().map(|byte| link.hear(Some(*byte)));
    came.filter(|came| !matches!(came, Came::Nothing | Came::Garbled | Came::Called)).collect()
}

fn stored(link: &mut FrameLink<256>) -> Vec<u8> {
    (0..link.fifo().used()).map(|_| link.fifo().read()).collect()
}

#[test]
fn frames_and_text_share_the_line() {
    let mut link = FrameLink::new();
    let frame = FrameBytes::new(Kind::Data, 9, b"?V\rK");
    let bytes = [b"?", frame.as_bytes(), b"\r"].concat();
    let came = heard(&mut link, &bytes);
    assert_eq!(came, [Came::Text(b'?'), Came::Frame(Kind::Data, 9), Came::Text(b'\r')]);
    assert_eq!(link.fifo().used(), 0, "before it is committed");
}

/// Every single bit of every byte.
#[test]
fn no_frame_with_a_spoilt_bit_is_taken() {
    for payload in [&b""[..], b"K\r", &[0x55; 20], &[0xFF, 0, 13, b'K', 13, 0x80, 0x81, 1]] {
        for kind in [Kind::Data, Kind::Start, Kind::Cut] {
            let whole = FrameBytes::new(kind, 3, payload);
            for bit in 0..8 * whole.as_bytes().len() {
                let mut bytes = whole.as_bytes().to_vec();
                bytes[bit / 8] ^= 1 << (bit % 8);
                let mut link = FrameLink::new();
                // What follows a shortened frame may be taken for its end: another frame does.
                let came = heard(&mut link, &[&bytes[..], whole.as_bytes(), &[FILL; 4]].concat());
                let frames = came.iter().filter(|came| matches!(came, Came::Frame(..)));
                assert!(frames.clone().count() <= 1, "bit {bit} of {bytes:?}: {came:?}");
                assert!(frames.clone().all(|came| *came == Came::Frame(kind, 3)), "{came:?}");
                // And afterwards it hears again.
                let came = heard(&mut link, whole.as_bytes());
                assert_eq!(came, [Came::Frame(kind, 3)], "bit {bit} of {bytes:?}");
            }
        }
    }
}

#[test]
fn a_lost_head_makes_it_deaf() {
    let frame = FrameBytes::new(Kind::Data, 3, b"\x12\rK\rK\r");
    let mut link = FrameLink::new();
    assert_eq!(heard(&mut link, &frame.as_bytes()[1..]), [Came::Broken]);
    assert!(link.is_deaf());
    assert_eq!(heard(&mut link, b"K\r"), []);
    assert_eq!(heard(&mut link, &[FILL; 3]), []);
    assert_eq!(heard(&mut link, b"K"), []);
    assert_eq!(heard(&mut link, &[FILL, FILL, FILL, FILL, b'K']), [Came::Text(b'K')]);
    // One that was lost spoils a line, and a frame.
    assert_eq!(link.hear(None), Came::Garbled);
    let lost = [Some(0x81), Some(3), None, Some(1), Some(2), Some(3), Some(4), Some(5)];
    let came: Vec<Came> = lost.iter().map(|byte| link.hear(*byte)).collect();
    assert_eq!(came.last(), Some(&Came::Broken));
}

#[test]
fn a_frame_without_room_is_not_stored() {
    let mut link = FrameLink::<256>::new();
    let long = FrameBytes::new(Kind::Data, 0, &[7; LONGEST]);
    let mut stored_whole = 0;
    for _ in 0..6 {
        assert_eq!(heard(&mut link, long.as_bytes()), [Came::Frame(Kind::Data, 0)]);
        stored_whole += u16::from(link.data());
    }
    assert_eq!((stored_whole, link.fifo().used()), (4, 240));
    for _ in 0..4 {
        let bytes: Vec<u8> = (0..60).map(|_| link.fifo().read()).collect();
        assert_eq!((bytes[0], &bytes[1..]), (59, &[7; 59][..]));
    }
}

fn kinds() -> impl Strategy<Value = Kind> {
    prop::sample::select(vec![Kind::Data, Kind::Start, Kind::Cut, Kind::End, Kind::Ping])
}

proptest! {
    /// Whatever was before: after four FILL a frame is heard, and it is as it was sent.
    #[test]
    fn four_fills_bring_it_back(
        noise in prop::collection::vec(any::<u8>(), 0..200),
        payload in prop::collection::vec(any::<u8>(), 0..=LONGEST),
        number: u8,
    ) {
        let mut link = FrameLink::new();
        heard(&mut link, &noise);
        heard(&mut link, &[FILL; 4]);
        let frame = FrameBytes::new(Kind::Data, number, &payload);
        prop_assume!(!frame.is_barred());
        let before = stored(&mut link).len();
        prop_assert_eq!(before, 0);
        prop_assert_eq!(heard(&mut link, frame.as_bytes()), vec![Came::Frame(Kind::Data, number)]);
        prop_assert!(link.data());
        let mut whole = vec![payload.len() as u8];
        whole.extend(payload);
        prop_assert_eq!(stored(&mut link), whole);
    }

    /// A burst of up to 16 spoilt bits is always seen.
    #[test]
    fn no_burst_gets_through(
        kind in kinds(),
        payload in prop::collection::vec(any::<u8>(), 0..=LONGEST),
        number: u8, at: prop::sample::Index, burst in 1u16..,
    ) {
        let whole = FrameBytes::new(kind, number, &payload);
        let mut bytes = whole.as_bytes().to_vec();
        // The kind and the length say where the sum is: behind them.
        let from = 16 + at.index(8 * bytes.len() - 16 - 15);
        for bit in 0..16 {
            if burst >> bit & 1 != 0 {
                bytes[(from + bit) / 8] ^= 1 << ((from + bit) % 8);
            }
        }
        let mut link = FrameLink::new();
        let frames = heard(&mut link, &bytes);
        prop_assert!(!frames.iter().any(|came| matches!(came, Came::Frame(..))), "{:?}", frames);
    }

    /// Credits among text, one of whose bytes is spoilt: no other credit is found.
    #[test]
    fn a_spoilt_credit_is_none(
        next: u8, opened: u8, free: u8, flags: u8, bit in 0usize..56,
        text in prop::collection::vec(0u8..0x80, 0..20), cut: prop::sample::Index,
    ) {
        let credit = Credit { next, opened, free, flags };
        let mut spoilt = credit.bytes();
        spoilt[bit / 8] ^= 1 << (bit % 8);
        let at = cut.index(text.len() + 1);
        let bytes = [&text[..at], &spoilt, &text[at..], &credit.bytes(), &[b'x'; 7]].concat();
        let (mut reader, mut found, mut said) = (CreditReader::new(), vec![], vec![]);
        for byte in bytes {
            reader.hear(byte, |told| match told {
                Answered::Credit(credit) => found.push(credit),
                Answered::Text(byte) => said.push(byte),
            });
        }
        prop_assert_eq!(found, vec![credit]);
        prop_assert!(said.iter().all(|byte| *byte < 0x80));
    }
}

/// A board that answers and takes nothing: that it is sent again is no progress.
#[test]
fn a_sender_that_is_not_heard_is_stuck() {
    let mut sender = FrameSender::new(LinkTimes::of_baud(115_200));
    let mut out = [0; MOST];
    assert!(sender.offer(Kind::Setup, &[0; 18], 0));
    for millis in 0..4_000 {
        let now = millis * 1_000;
        while sender.next(now, &mut out) != 0 {}
        if millis % 20 == 0 {
            sender.hear(Credit { next: 0, opened: 0, free: 100, flags: 0 }, now);
        }
    }
    assert!(
        sender.again() > 50 && sender.stuck(4_000_000) > 3_900_000,
        "{}",
        sender.stuck(4_000_000)
    );
}
