//! Overrides of the ordered feed rate, rapid rate and spindle speed, in percent.

use crate::motion::Scales;

/// The present overrides.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Overrides {
    pub feed: u8,
    pub rapid: u8,
    pub spindle: u8,
}

impl Overrides {
    pub const NONE: Overrides = Overrides { feed: 100, rapid: 100, spindle: 100 };

    /// The scales of the speeds. For a `plain` move (a jog, a probe or homing) the feed rate is as
    /// ordered.
    pub fn scales(self, plain: bool) -> Scales {
        let feed = if plain { 1.0 } else { f64::from(self.feed) / 100.0 };
        Scales { feed, rapid: f64::from(self.rapid) / 100.0 }
    }

    /// The overrides after a real-time byte; `None` if the byte is not for overrides.
    pub fn after(self, byte: u8) -> Option<Overrides> {
        let by = |value: u8, by: i16| (i16::from(value) + by).clamp(10, 200) as u8;
        let Overrides { feed, spindle, .. } = self;
        let part = |offset: u8, value: u8| match offset {
            0 => 100,
            1 => by(value, 10),
            2 => by(value, -10),
            3 => by(value, 1),
            _ => by(value, -1),
        };
        Some(match byte {
            0x90..=0x94 => Overrides { feed: part(byte - 0x90, feed), ..self },
            0x95 => Overrides { rapid: 100, ..self },
            0x96 => Overrides { rapid: 50, ..self },
            0x97 => Overrides { rapid: 25, ..self },
            0x99..=0x9D => Overrides { spindle: part(byte - 0x99, spindle), ..self },
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn they_stay_within_their_range() {
        let mut now = Overrides::NONE;
        for _ in 0..20 {
            now = now.after(0x91).unwrap();
        }
        assert_eq!(now.feed, 200);
        for _ in 0..30 {
            now = now.after(0x92).unwrap().after(0x9D).unwrap();
        }
        assert_eq!((now.feed, now.spindle), (10, 70));
        assert_eq!(
            now.after(0x93).unwrap().after(0x97),
            Some(Overrides { feed: 11, rapid: 25, spindle: 70 })
        );
        assert_eq!((now.after(0x98), now.after(0x9E)), (None, None));
    }
}
