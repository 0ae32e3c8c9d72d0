//! The host's half of the line: what is said, and what an answer says.

use stepwright_protocol::{AxisId, BoardError, Command, Info, Master, Refusal, Reply, Setting};

/// What has come of a byte that was received.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u8)]
pub enum Heard {
    /// No answer yet.
    Nothing,
    /// `Y`.
    Yes,
    /// `E`.
    No,
    /// `R`.
    Ready,
    /// `B`.
    Busy,
    /// The answer to V: number 0.
    Position,
    /// The answer to `?`: numbers as [`HostHalf::INFO`] says.
    Info,
    /// The answer to `$`: a number for each [`Setting`], in the order of [`Setting::ALL`]; NaN
    /// for one that the board has not.
    Settings,
}

/// The conversation with a board, and what it has said last.
pub struct HostHalf {
    master: Master,
    numbers: [f64; HostHalf::NUMBERS],
}

impl Default for HostHalf {
    fn default() -> Self {
        HostHalf::new()
    }
}

impl HostHalf {
    /// Numbers of an answer, at most.
    pub const NUMBERS: usize = 32;

    /// The numbers of the answer to `?`, in their order. Sets are bits: of axes, 1 is axis 1.
    /// `last`: the place of the refusal in [`Refusal::ALL`]; `stop` … : the letter of the stop
    /// of each of eight axes. −1 stands for what the board does not say.
    pub const INFO: [&'static str; 11] = [
        "major",
        "minor",
        "axes",
        "max",
        "late",
        "refused",
        "last",
        "uncertain",
        "errors",
        "can",
        "stop",
    ];

    /// A conversation that has not begun.
    pub const fn new() -> HostHalf {
        HostHalf { master: Master::new(), numbers: [0.0; HostHalf::NUMBERS] }
    }

    /// The numbers of the last answer.
    pub fn numbers(&self) -> &[f64; HostHalf::NUMBERS] {
        &self.numbers
    }

    /// From now on every line has a checksum, or none.
    pub fn use_sums(&mut self, sums: bool) {
        self.master.use_sums(sums);
    }

    /// The bytes of a line, to be put on the line to the board. An answer that has not come is
    /// given up. `None` if it is no line of the protocol.
    pub fn say(&mut self, line: &[u8]) -> Option<impl Iterator<Item = u8> + use<>> {
        let command = Command::parse(line).ok()?;
        self.master.give_up();
        self.master.send(command).ok()
    }

    /// The bytes that get in step with a board again that was silent.
    pub fn resync(&mut self) -> impl Iterator<Item = u8> + use<> {
        self.master.resync()
    }

    /// A byte of the board.
    pub fn hear(&mut self, byte: u8) -> Heard {
        match self.master.receive(byte) {
            None => Heard::Nothing,
            Some(Reply::Yes) => Heard::Yes,
            Some(Reply::No) => Heard::No,
            Some(Reply::Ready) => Heard::Ready,
            Some(Reply::Busy) => Heard::Busy,
            Some(Reply::Position(steps)) => {
                self.put([steps as f64]);
                Heard::Position
            }
            Some(Reply::Info(info)) => {
                self.inform(&info);
                Heard::Info
            }
            Some(Reply::Settings(listed)) => {
                let number = |setting| listed.get(setting).map_or(f64::NAN, |v| v.number().into());
                self.put(Setting::ALL.map(number));
                Heard::Settings
            }
            // Nothing here asks for a single one.
            Some(Reply::Setting(_)) => Heard::Nothing,
        }
    }

    fn put<const N: usize>(&mut self, numbers: [f64; N]) {
        const { assert!(N <= HostHalf::NUMBERS) };
        for (place, number) in self.numbers.iter_mut().zip(numbers) {
            *place = number;
        }
    }

    fn inform(&mut self, info: &Info) {
        let place = |refusal| Refusal::ALL.iter().position(|one| *one == refusal);
        let last = info.last.and_then(place).map_or(-1.0, |place| place as f64);
        let bits = |errors: stepwright_protocol::Errors| {
            let set = errors.iter().map(|error| 1u32 << error as u32);
            f64::from(set.fold(0, |all, one| all | one))
        };
        let can = |can: stepwright_protocol::Abilities| {
            let all = stepwright_protocol::Ability::ALL.into_iter().filter(|one| can.has(*one));
            f64::from(all.fold(0u32, |all, one| all | 1 << one as u32))
        };
        let stop = |axis: u8| {
            let axis = AxisId::numbered(axis)?;
            info.stops.as_ref()?.of(axis)
        };
        let letter = |axis| stop(axis).map_or(0.0, |stop| f64::from(stop.letter()));
        const { assert!(BoardError::ALL.len() <= 32) };
        self.put([
            info.version.0.into(),
            info.version.1.into(),
            info.axes.into(),
            info.max.into(),
            info.late.into(),
            info.refused.into(),
            last,
            info.uncertain.into(),
            info.errors.map_or(-1.0, bits),
            info.can.map_or(-1.0, can),
            letter(1),
            letter(2),
            letter(3),
            letter(4),
            letter(5),
            letter(6),
            letter(7),
            letter(8),
        ]);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ask(host: &mut HostHalf, line: &[u8], answer: &[u8]) -> Heard {
        assert!(host.say(line).is_some());
        answer.iter().map(|byte| host.hear(*byte)).find(|heard| *heard != Heard::Nothing).unwrap()
    }

    #[test]
    fn an_answer_is_a_kind_and_its_numbers() {
        let mut host = HostHalf::new();
        assert_eq!(ask(&mut host, b"F", b"R\r"), Heard::Ready);
        assert_eq!(ask(&mut host, b"V2", b"-1234567\r"), Heard::Position);
        assert_eq!(host.numbers()[0], -1234567.0);
        let info = b"stepwright 0.1 axes=3 max=120000 late=2 refused=5 last=busy uncertain=2 \
                     stop=-KS errors=SK can=jerk,sum closed=0\r";
        assert_eq!(ask(&mut host, b"?", info), Heard::Info);
        let busy = Refusal::ALL.iter().position(|one| *one == Refusal::Busy).unwrap() as f64;
        let right = [0., 1., 3., 120_000., 2., 5., busy, 2., 5., 5., 0., 75., 83., 0.];
        assert_eq!(host.numbers()[..14], right);
        // A slave that knows only the oldest lines.
        assert_eq!(ask(&mut host, b"?", b"E\r"), Heard::No);
        host.use_sums(true);
        let bytes: Vec<u8> = host.say(b"E").unwrap().collect();
        assert_eq!(bytes, b"E*DC\r");
        assert!(host.say(b"G 5").is_none());
    }
}
