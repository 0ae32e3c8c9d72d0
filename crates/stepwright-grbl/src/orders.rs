//! Orders: lines that begin with `$`.

use stepwright_gcode::Point;

use crate::homing::Homing;
use crate::machine::GrblMachine;
use crate::motion::BLOCKS;
use crate::report::modes;
use crate::session::{Grbl, RX};
use crate::settings::GrblSettings;
use crate::state::{After, State};

impl<M: GrblMachine> Grbl<M> {
    /// Carries out a line that began with `$`.
    pub(crate) fn order(&mut self, order: &[u8]) {
        if let Some(jog) = order.strip_prefix(b"J=") {
            return self.jog(jog);
        }
        let rests = matches!(self.state, State::Idle | State::Alarm { .. });
        match order {
            b"" => self
                .say("[HLP:$$ $# $G $I $N $x=val $Nx=line $J=line $SLP $C $X $H ~ ! ? ctrl-x]\r\n"),
            b"$" if self.state == State::Run => return self.error(8),
            b"$" => {
                let lines = GrblSettings::numbers().filter_map(|number| self.settings.line(number));
                let text: String = lines.map(|line| line + "\r\n").collect();
                self.say(&text);
            }
            b"G" => {
                let text = modes(&self.reader.modal()) + "\r\n";
                self.say(&text);
            }
            b"C" => return self.check(),
            b"X" => self.unlock(),
            b"J" => return self.error(3),
            _ if !rests => return self.error(8),
            b"#" => self.parameters(),
            b"H" => return self.home(),
            b"I" => {
                let text = format!(
                    "[VER:1.1h.20190830:{}]\r\n[OPT:V,{BLOCKS},{RX}]\r\n",
                    if self.build.is_empty() { "Stepwright" } else { &self.build }
                );
                self.say(&text);
            }
            b"N" => {
                let text = format!("$N0={}\r\n$N1={}\r\n", self.startup[0], self.startup[1]);
                self.say(&text);
            }
            b"SLP" => {
                self.ok();
                self.say("[MSG:Sleeping]\r\n");
                return self.brake(After::Sleep);
            }
            b"RST=$" | b"RST=#" | b"RST=*" => {
                self.restore_defaults(order[4]);
                self.ok();
                return self.brake(After::Reset);
            }
            _ => return self.assign(order),
        }
        self.ok();
    }

    /// `$C`: check mode, which reads lines without a motion; a second `$C` ends it.
    fn check(&mut self) {
        match self.state {
            State::Check => {
                self.say("[MSG:Disabled]\r\n");
                self.ok();
                self.state = State::Idle;
                self.brake(After::Reset);
            }
            State::Idle => {
                self.unchecked = Some(self.reader);
                self.state = State::Check;
                self.say("[MSG:Enabled]\r\n");
                self.ok();
            }
            _ => self.error(8),
        }
    }

    /// `$X`
    fn unlock(&mut self) {
        self.lock.open();
        if matches!(self.state, State::Alarm { .. }) {
            self.say("[MSG:Caution: Unlocked]\r\n");
            self.state = State::Idle;
        }
    }

    fn home(&mut self) {
        if !self.settings.is_on(22) {
            return self.error(5);
        }
        self.state = State::Home;
        self.homing = Some(Homing::new());
        self.begin_homing_work();
    }

    fn restore_defaults(&mut self, which: u8) {
        if which != b'#' {
            self.settings = GrblSettings::default();
        }
        if which != b'$' {
            for parameter in crate::kept::PARAMETERS {
                self.reader.set_parameter(parameter, Point::ZERO);
            }
            self.seldom.offsets = 0;
        }
        if which == b'*' {
            self.startup = Default::default();
            self.build.clear();
        }
        self.find_place();
        self.say("[MSG:Restoring defaults]\r\n");
    }

    /// `$100=250`, `$N0=G54`, `$I=words`
    fn assign(&mut self, order: &[u8]) {
        let Ok(text) = std::str::from_utf8(order) else { return self.error(3) };
        let Some((name, value)) = text.split_once('=') else { return self.error(3) };
        match name {
            "I" => value.clone_into(&mut self.build),
            "N0" | "N1" => return self.set_startup(usize::from(name == "N1"), value),
            _ => return self.set(name, value),
        }
        self.ok();
    }

    fn set_startup(&mut self, which: usize, value: &str) {
        if self.state != State::Idle {
            return self.error(8);
        }
        // Parses the line as it will be, without an effect.
        let was = self.reader;
        let read = self.read(value.as_bytes());
        self.reader = was;
        if let Err(number) = read {
            return self.error(number);
        }
        value.clone_into(&mut self.startup[which]);
        self.ok();
    }

    fn set(&mut self, name: &str, value: &str) {
        let Ok(number) = name.parse::<u8>() else { return self.error(3) };
        let plain = |byte: u8| byte.is_ascii_digit() || b"+-.".contains(&byte);
        let value = value.parse::<f64>().ok().filter(|_| value.bytes().all(plain));
        let Some(value) = value else { return self.error(2) };
        // A fed board has no switches for homing.
        let lacks = self.motion.fed && (number == 22 || number == 32 && !self.lasers);
        if lacks && value != 0.0 {
            return self.error(3);
        }
        match self.settings.set(number, value) {
            Ok(()) => {
                // The position in steps stays; in millimetres it may change.
                self.find_place();
                self.switch();
                self.ok();
            }
            Err(fault) => self.error(fault.number()),
        }
    }
}
