//! The descriptors of the USB device, and its answers to requests; also for a host.

/// A request of the host.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Setup {
    /// The request type, which has recipient and direction, and the request.
    pub request: (u8, u8),
    /// The request's value.
    pub value: u16,
    /// The interface or endpoint that it means.
    pub index: u16,
    /// The most bytes of the answer.
    pub length: u16,
}

impl Setup {
    /// The request in these two words.
    pub const fn of([low, high]: [u32; 2]) -> Setup {
        let [kind, request, value, above] = low.to_le_bytes();
        let [index, further, length, longer] = high.to_le_bytes();
        Setup {
            request: (kind, request),
            value: u16::from_le_bytes([value, above]),
            index: u16::from_le_bytes([index, further]),
            length: u16::from_le_bytes([length, longer]),
        }
    }
}

/// The reaction to a request.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Answer {
    /// Send these bytes, or the first of them.
    Bytes(&'static [u8]),
    /// Take this address after the acknowledgement.
    Address(u8),
    /// Start the pipes, or stop them.
    Configured(bool),
    /// Say whether the pipes are started.
    Configuration,
    /// Begin an endpoint again, with DATA0.
    Unhalted(u8),
    /// A program has opened the port, or closed it.
    Opened(bool),
    /// Receive some bytes more from the host, then acknowledge.
    Takes,
    /// Acknowledge.
    Done,
    /// Refuse: the device does not support the request.
    Refused,
}

/// pid.codes' number for tests: the project has none of its own.
const DEVICE: [u8; 18] =
    [18, 1, 0x00, 0x02, 2, 0, 0, 64, 0x09, 0x12, 0x01, 0x00, 0x00, 0x01, 1, 2, 3, 1];

/// Two interfaces, of control and of data; powered by the bus, 100 mA.
const CONFIGURATION: [u8; 67] = [
    9, 2, 67, 0, 2, 1, 0, 0x80, 50, //
    9, 4, 0, 0, 1, 2, 2, 1, 0, // control: abstract control model
    5, 0x24, 0, 0x10, 0x01, // CDC 1.10
    5, 0x24, 1, 0, 1, // no calls
    4, 0x24, 2, 2, // line coding and state
    5, 0x24, 6, 0, 1, // interfaces 0 and 1
    7, 5, 0x81, 3, 8, 0, 255, // notes, which never come
    9, 4, 1, 0, 2, 10, 0, 0, 0, // data
    7, 5, 0x82, 2, 64, 0, 0, // sent
    7, 5, 0x02, 2, 64, 0, 0, // received
];

const LANGUAGES: [u8; 4] = [4, 3, 0x09, 0x04];
const MAKER: [u8; 22] = string(b"Stepwright");
const PRODUCT: [u8; 44] = string(b"Stepwright controller");
const SERIAL: [u8; 4] = string(b"1");

/// A string descriptor.
const fn string<const N: usize>(text: &[u8]) -> [u8; N] {
    assert!(N == 2 + 2 * text.len());
    let mut bytes = [0; N];
    (bytes[0], bytes[1]) = (N as u8, 3);
    let mut n = 0;
    while n < text.len() {
        bytes[2 + 2 * n] = text[n];
        n += 1;
    }
    bytes
}

/// 115200 bits/s, 8 bits, whatever the host has requested: there is no physical line.
const CODING: [u8; 7] = [0x00, 0xC2, 0x01, 0x00, 0, 0, 8];

/// The endpoints of data, sent and received.
const SENT: u16 = 0x82;
const HEARD: u16 = 0x02;

/// The reaction to a host's request.
pub const fn answer(setup: &Setup) -> Answer {
    let [index, kind] = setup.value.to_le_bytes();
    match setup.request {
        (0x80, 6) => match (kind, index) {
            (1, _) => Answer::Bytes(&DEVICE),
            (2, _) => Answer::Bytes(&CONFIGURATION),
            (3, 0) => Answer::Bytes(&LANGUAGES),
            (3, 1) => Answer::Bytes(&MAKER),
            (3, 2) => Answer::Bytes(&PRODUCT),
            (3, 3) => Answer::Bytes(&SERIAL),
            _ => Answer::Refused,
        },
        (0x80..=0x82, 0) => Answer::Bytes(&[0, 0]),
        (0x80, 8) => Answer::Configuration,
        (0x81, 10) => Answer::Bytes(&[0]),
        (0x00, 5) => Answer::Address(index & 0x7F),
        (0x00, 9) if setup.value <= 1 => Answer::Configured(setup.value == 1),
        // ENDPOINT_HALT: hosts clear it when they open a port. It is never set.
        (0x02, 1) => match (setup.value, setup.index) {
            (0, 0x00 | 0x80 | 0x81 | SENT | HEARD) => Answer::Unhalted(setup.index as u8),
            _ => Answer::Refused,
        },
        (0x00, 1 | 3) | (0x01, 11) => Answer::Done,
        // (Some hosts address the device, not its interface.)
        (0x20 | 0x21, 0x20) => Answer::Takes,
        (0x20 | 0x21, 0x22) => Answer::Opened(index & 1 != 0),
        (0xA1, 0x21) => Answer::Bytes(&CODING),
        _ => Answer::Refused,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Each descriptor states its length, and the first one states the total.
    #[test]
    fn the_configuration_is_whole() {
        let (mut at, mut parts, mut ends) = (0, 0, 0);
        while at < CONFIGURATION.len() {
            assert!(CONFIGURATION[at] >= 4);
            parts += usize::from(CONFIGURATION[at + 1] == 4);
            ends += usize::from(CONFIGURATION[at + 1] == 5);
            at += usize::from(CONFIGURATION[at]);
        }
        assert_eq!((at, parts, ends), (67, 2, 3));
        assert_eq!(u16::from_le_bytes([CONFIGURATION[2], CONFIGURATION[3]]), 67);
        assert_eq!(usize::from(DEVICE[0]), DEVICE.len());
        assert_eq!(PRODUCT[..8], [44, 3, b'S', 0, b't', 0, b'e', 0]);
    }

    #[test]
    fn a_request_is_read_from_its_words() {
        // GET_DESCRIPTOR of the configuration, 9 bytes.
        let setup = Setup::of([0x0200_0680, 0x0009_0000]);
        assert_eq!(setup, Setup { request: (0x80, 6), value: 0x0200, index: 0, length: 9 });
        assert_eq!(answer(&setup), Answer::Bytes(&CONFIGURATION));
        assert_eq!(answer(&Setup::of([0x0007_0500, 0])), Answer::Address(7));
        assert_eq!(answer(&Setup::of([0x0003_2221, 0])), Answer::Opened(true));
        assert_eq!(answer(&Setup::of([0x0600_0680, 0x0009_0000])), Answer::Refused);
        assert_eq!(answer(&Setup::of([0x0000_0900, 0])), Answer::Configured(false));
        assert_eq!(answer(&Setup::of([0x0001_0900, 0])), Answer::Configured(true));
        assert_eq!(answer(&Setup::of([0x0002_0900, 0])), Answer::Refused);
        assert_eq!(answer(&Setup::of([0x0000_0102, 0x82])), Answer::Unhalted(0x82));
        // No such feature, no such endpoint.
        assert_eq!(answer(&Setup::of([0x0001_0102, 0x82])), Answer::Refused);
        assert_eq!(answer(&Setup::of([0x0000_0102, 0x83])), Answer::Refused);
    }
}
