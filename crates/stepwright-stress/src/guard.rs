//! The conditions that boards check before motion, and the errors that they keep, after docs/safety.md:
//! kept errors, safe start, homing first, soft limits, leases, stop inputs.

use crate::fault::{Fault, Rule};
use crate::judge::Judge;
use crate::reason::Reason;
use crate::settings;
use crate::slave::Expect;
use crate::story::Input;
use crate::track::{Goal, Known};

/// The letters of `errors=`; those that lock a board come first.
const LETTERS: &[u8; 9] = b"STKEDRlcg";
/// The number of letters that lock it.
const LOCKS: usize = 6;

/// A board's state of errors, leases and inputs.
#[derive(Clone, Debug)]
pub struct Guard {
    errors: [Known; LETTERS.len()],
    /// After this many ms of silence moving axes brake once.
    pub(crate) lease: (u32, Known),
    /// Levels of the input pins: emergency stop, driver fault.
    levels: [bool; 2],
    /// The active input, the time since when, and whether it has been obeyed.
    stopper: Option<(u8, u64, bool)>,
    /// The time from which the drivers are off after a stop at once.
    pub(crate) off: Option<u64>,
}

impl Guard {
    /// The state at power-up.
    pub fn new() -> Guard {
        Guard {
            errors: [Known::No; LETTERS.len()],
            lease: (0, Known::No),
            levels: [true; 2],
            stopper: None,
            off: None,
        }
    }

    /// Handles a reset of the board. The pins keep their levels.
    pub fn reset(&mut self, lost: Known) {
        *self = Guard { levels: self.levels, ..Guard::new() };
        self.note(b'R', lost);
    }

    /// Notes an error that has occurred, or may have.
    pub fn note(&mut self, letter: u8, come: Known) {
        if let Some(at) = LETTERS.iter().position(|known| *known == letter) {
            self.errors[at] = self.errors[at].or(come);
        }
    }

    /// Handles `!`. If an active input stops the board, it notes its error again.
    pub fn clear(&mut self, now: u64) {
        self.errors = [Known::No; LETTERS.len()];
        if let Some((letter, since, obeyed)) = &mut self.stopper {
            (*since, *obeyed) = (now, false);
            let letter = *letter;
            self.note(letter, Known::Maybe);
        }
    }

    /// Whether a stop input is active.
    pub fn is_stopping(&self) -> bool {
        self.stopper.is_some()
    }

    /// Whether an error is noted that locks a board with `safe-start`.
    fn locks(&self) -> Known {
        self.errors[..LOCKS].iter().fold(Known::No, |all, one| all.or(*one))
    }
}

impl Default for Guard {
    fn default() -> Guard {
        Guard::new()
    }
}

/// The travel of an order.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Travel {
    /// A travel of this many steps.
    By(i64),
    /// An endless travel, forward or not.
    Endless(bool),
}

impl Travel {
    /// Whether the travel is forward.
    pub fn forward(self) -> bool {
        match self {
            Travel::By(steps) => steps >= 0,
            Travel::Endless(forward) => forward,
        }
    }
}

impl Judge {
    /// Whether safe start allows any motion of an axis now.
    fn may_start(&self) -> Expect {
        let locked = match self.settings.get(settings::SAFE_START) {
            0 => Known::No,
            _ => self.guard.locks(),
        };
        Expect::unless(locked, Reason::Stopped)
    }

    /// Whether safe start, homing and the soft limits allow this travel from rest.
    pub(crate) fn admit(&self, n: usize, travel: Travel) -> Expect {
        let expect = self.may_start();
        let track = &self.tracks[n];
        let limited = self.settings.has(settings::SOFT_LIMITS, n);
        let here = track.count - track.zero;
        match travel {
            Travel::By(steps) => expect.and(self.admit_end(n, here, steps, steps == 0)),
            Travel::Endless(forward) if limited && !self.is_homing(n, forward) => {
                let way = self.way_to_limit(n, forward);
                // The board counts a travel up to 2³¹ − 1 steps.
                let far = way.abs() > 0x7FFF_FFFF;
                let bad = way == 0 || forward != (way > 0) || far;
                let why = if far { Reason::Travel | Reason::Limit } else { Reason::Limit.into() };
                match (track.known, bad) {
                    (Known::No, _) | (_, false) => expect,
                    (Known::Yes, true) => expect.and(Expect::no(why)),
                    (Known::Maybe, true) => Expect { yes: expect.yes, no: expect.no | why },
                }
            }
            Travel::Endless(_) => expect,
        }
    }

    /// Whether an axis may travel this many steps from `from`. An axis that `stays` may do so beyond a soft
    /// limit.
    fn admit_end(&self, n: usize, from: i64, steps: i64, stays: bool) -> Expect {
        let known = self.tracks[n].known;
        let limited = self.settings.has(settings::SOFT_LIMITS, n);
        let mut expect = Expect::YES;
        if limited || self.settings.get(settings::HOME_FIRST) != 0 {
            expect = expect.and(Expect::unless(known.not(), Reason::Uncertain));
        }
        let [behind, ahead] = self.range(n);
        if limited && !stays && !(behind..=ahead).contains(&(from + steps)) {
            // If the position is not known, the end is not known either.
            let beyond = if known == Known::No { Known::No } else { known };
            expect = expect.and(Expect::unless(beyond, Reason::Limit));
        }
        expect
    }

    /// Whether a moving axis may get this target.
    pub(crate) fn admit_target(&self, n: usize, steps: i64) -> Expect {
        let track = &self.tracks[n];
        self.may_start().and(self.admit_end(n, track.origin - track.zero, steps, false))
    }

    /// Whether a moving axis may get another deceleration: not if a soft limit depends on it.
    pub(crate) fn admit_decel(&self, n: usize, busy: Known) -> Expect {
        let counts = match (self.settings.has(settings::SOFT_LIMITS, n), self.tracks[n].known) {
            (false, _) | (_, Known::No) => Known::No,
            (true, Known::Yes) => busy,
            (true, Known::Maybe) => Known::Maybe,
        };
        Expect::unless(counts, Reason::Limit)
    }

    /// The soft limits of an axis from its 0, both inclusive.
    fn range(&self, n: usize) -> [i64; 2] {
        let of = |names: [settings::Name; 3]| {
            names.get(n).map_or(0, |name| i64::from(self.settings.get(*name)))
        };
        [-of(settings::BEHIND), of(settings::AHEAD)]
    }

    fn way_to_limit(&self, n: usize, forward: bool) -> i64 {
        let [behind, ahead] = self.range(n);
        let track = &self.tracks[n];
        (if forward { ahead } else { behind }) - (track.count - track.zero)
    }

    /// Whether the axis' own switch ends this travel. Such a travel has no soft limit.
    fn is_homing(&self, n: usize, forward: bool) -> bool {
        self.settings.has(settings::SWITCHES, n)
            && self.settings.has(settings::SWITCH_FORWARD, n) == forward
    }

    /// Whether an endless travel ends at a soft limit.
    pub(crate) fn is_bounded(&self, n: usize, travel: Travel) -> Known {
        match travel {
            Travel::Endless(forward)
                if self.settings.has(settings::SOFT_LIMITS, n) && !self.is_homing(n, forward) =>
            {
                self.tracks[n].known
            }
            _ => Known::No,
        }
    }

    /// The least and the most steps that a travel may take.
    pub(crate) fn steps(&self, n: usize, travel: Travel) -> (f64, f64) {
        let way = || self.way_to_limit(n, travel.forward()).abs() as f64;
        match (travel, self.is_bounded(n, travel)) {
            (Travel::By(steps), _) => (steps.abs() as f64, steps.abs() as f64),
            (_, Known::No) => (f64::INFINITY, f64::INFINITY),
            (_, Known::Maybe) => (way(), f64::INFINITY),
            (_, Known::Yes) => (way(), way()),
        }
    }

    /// Begins an admitted travel: a soft limit gives it a fence, and gives an endless travel an end.
    pub(crate) fn fence(&mut self, n: usize, travel: Travel) -> Travel {
        let bounded = self.is_bounded(n, travel);
        let homes = bounded == Known::No && matches!(travel, Travel::Endless(_));
        let limited = self.settings.has(settings::SOFT_LIMITS, n) && !homes;
        let [behind, ahead] = self.range(n);
        let way = self.way_to_limit(n, travel.forward());
        let track = &mut self.tracks[n];
        // An axis beyond a limit may come back.
        let fence = (track.count.min(track.zero + behind), track.count.max(track.zero + ahead));
        track.fence = (limited && track.known == Known::Yes).then_some(fence);
        track.bounded = bounded;
        if bounded == Known::Yes { Travel::By(way) } else { travel }
    }

    /// Sets the level of a stop input.
    ///
    /// # Errors
    /// A rule that was broken before this time.
    pub fn input(&mut self, input: Input, high: bool, now: u64) -> Result<(), Fault> {
        self.advance(now)?;
        self.guard.levels[usize::from(input == Input::Driver)] = high;
        self.look_at_inputs(now);
        Ok(())
    }

    /// Re-evaluates the inputs after a change of settings or levels.
    pub(crate) fn look_at_inputs(&mut self, now: u64) {
        let active = |name, high: bool| match self.settings.get(name) {
            0 => false,
            1 => !high,
            _ => high,
        };
        let [emergency, driver] = self.guard.levels;
        let letter = if active(settings::EMERGENCY, emergency) {
            Some(b'E')
        } else if active(settings::DRIVER_FAULT, driver) {
            Some(b'D')
        } else {
            None
        };
        let before = self.guard.stopper.map(|(letter, ..)| letter);
        if letter == before {
            return;
        }
        // While the input was active it spoiled every order, and its error came back after every `!`.
        for letter in before.into_iter().chain(letter) {
            self.guard.note(letter, Known::Maybe);
            self.slave.may_spoil(Reason::Fault.into());
        }
        self.guard.stopper = letter.map(|letter| (letter, now, false));
        self.tracks.iter_mut().for_each(|track| track.doomed = Known::No);
        let Some(letter) = letter else { return };
        // The board may see it from now on, and sees it within 2 ms.
        self.ordered = Some(now);
        for track in self.tracks.iter_mut().filter(|track| track.goal != Goal::Rest) {
            if track.goal == Goal::Endless && !track.is_fresh() {
                track.doomed = Known::Yes;
            }
            track.open(letter);
            if track.known == Known::Yes {
                track.known = Known::Maybe;
            }
        }
    }

    /// Stops everything if an input has been active for 2 ms.
    pub(crate) fn obey_inputs(&mut self, now: u64) {
        let Some((letter, since, false)) = self.guard.stopper else { return };
        if now <= since + self.measure().switch {
            return;
        }
        self.guard.stopper = Some((letter, since, true));
        self.guard.note(letter, Known::Yes);
        self.slave.spoil(Reason::Fault.into());
        if self.settings.get(settings::KILL_OFF) != 0 {
            self.guard.off = Some(now);
        }
        for track in &mut self.tracks {
            let doomed = std::mem::replace(&mut track.doomed, Known::No);
            if doomed != Known::No {
                track.known = Known::No;
                track.stops.hard(letter, doomed);
            }
            track.halt();
        }
    }

    /// Whether an active input refuses orders now.
    pub(crate) fn stopped(&self) -> Expect {
        let stops = if self.guard.is_stopping() { Known::Yes } else { Known::No };
        Expect::unless(stops, Reason::Fault)
    }

    /// Checks `errors=` in the answer to `?`, which counts this many late steps.
    ///
    /// # Errors
    /// [`Rule::Errors`], if it does not match what has happened.
    pub(crate) fn told_errors(
        &mut self,
        told: Option<&str>,
        late: u64,
        now: u64,
    ) -> Result<(), Fault> {
        let Some(told) = told else {
            return self.broken(Rule::Errors, now, || "? says nothing of errors".into());
        };
        self.guard.errors[LOCKS] = match late {
            0 => Known::No,
            _ => Known::Yes,
        };
        // The cause of a stop since the last `!` is an error.
        let shown = |letter: u8| self.tracks.iter().any(|track| track.stops.says(letter));
        let errors = LETTERS.map(|letter| told.as_bytes().contains(&letter));
        let mut fits = told == "-" || told.bytes().all(|letter| LETTERS.contains(&letter));
        fits &= (told == "-") == errors.iter().all(|there| !there);
        for (at, there) in errors.into_iter().enumerate() {
            let wrong = if there { Known::No } else { Known::Yes };
            fits &= self.guard.errors[at] != wrong && (there || !shown(LETTERS[at]));
        }
        if !fits {
            let known: Vec<_> = LETTERS
                .iter()
                .zip(self.guard.errors)
                .map(|(letter, known)| format!("{} {known:?}", char::from(*letter)))
                .collect();
            self.broken(Rule::Errors, now, || format!("errors={told}; {}", known.join(", ")))?;
        }
        self.guard.errors = errors.map(|there| if there { Known::Yes } else { Known::No });
        Ok(())
    }
}
