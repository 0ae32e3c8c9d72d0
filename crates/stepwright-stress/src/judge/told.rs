//! Checks the answers of a board about itself.

use super::{Asked, Judge, KEPT};
use crate::fault::{Fault, Rule};
use crate::grammar::Line;
use crate::settings::{self, Settings};
use crate::track::Known;

impl Judge {
    /// Checks the answer to F.
    pub(super) fn told(&mut self, answer: &str, asked: &Asked, now: u64) -> Result<(), Fault> {
        let busy = self.busy(self.slave.selected, now);
        match answer {
            "R" if busy != Known::Yes => self.settle(self.slave.selected, now),
            "B" if busy != Known::No => Ok(()),
            "R" => {
                let goals: Vec<_> = self.tracks.iter().map(|t| (t.count, t.goal)).collect();
                self.broken(Rule::Count, now, || format!("R before the end: {goals:?}"))
            }
            "B" => {
                let goals: Vec<_> = self.tracks.iter().map(|t| (t.count, t.goal)).collect();
                self.broken(Rule::Stop, now, || format!("B after the end: {goals:?}"))
            }
            _ => self.wrong(asked, answer, now),
        }
    }

    /// Checks the answer to V.
    pub(super) fn stands(
        &mut self,
        axis: u8,
        answer: &str,
        asked: &Asked,
        now: u64,
    ) -> Result<(), Fault> {
        let (least, most) = asked.positions;
        let Some(track) = self.tracks.get_mut(usize::from(axis) - 1) else {
            return self.wrong(asked, answer, now);
        };
        track.known = Known::Yes;
        match answer.parse::<i64>() {
            Ok(at) if (least..=most).contains(&at) && at.to_string() == answer => Ok(()),
            _ => self.broken(Rule::Position, now, || {
                format!("V{axis} is {answer}, by the edges {least} … {most}")
            }),
        }
    }

    /// Checks the answer to `?`.
    pub(super) fn described(&mut self, answer: &str, now: u64) -> Result<(), Fault> {
        let word = |name: &str| {
            answer.split(' ').find_map(|word| word.strip_prefix(name)?.strip_prefix('='))
        };
        let number = |name: &str| word(name).and_then(|word| word.parse::<u64>().ok());
        match number("late") {
            Some(0) => {}
            _ => self.broken(Rule::Late, now, || format!("late steps: {answer}"))?,
        }
        let last = match self.slave.last {
            None => word("last") == Some("none"),
            Some(why) => word("last").is_some_and(|word| why.has(word)),
        };
        let fits = answer.starts_with("stepwright ")
            && number("axes") == Some(self.tracks.len() as u64)
            && number("refused") == Some(self.slave.refusals)
            && number("max")
                .is_some_and(|max| max > 0 && max <= self.settings.get(settings::MAX_SPEED).into())
            && last;
        if !fits {
            let (refused, last) = (self.slave.refusals, self.slave.last);
            self.broken(Rule::Answer, now, || {
                format!("? is {answer:?}; refused should be {refused}, last {last:?}")
            })?;
        }
        let stops = word("stop").unwrap_or("").as_bytes();
        let measure = self.measure;
        let known = stops.len() == self.tracks.len()
            && self
                .tracks
                .iter_mut()
                .zip(stops)
                .all(|(track, stop)| track.shows(*stop, now, &measure));
        if !known {
            let stops: Vec<_> = self.tracks.iter().map(|track| track.stops).collect();
            self.broken(Rule::Answer, now, || format!("stop= of {answer:?} should be {stops:?}"))?;
        }
        self.told_errors(word("errors"), number("late").unwrap_or(0), now)?;
        let uncertain = number("uncertain").unwrap_or(u64::MAX);
        for track in &mut self.tracks {
            let known = uncertain >> track.axis & 1 == 0;
            if track.known == if known { Known::No } else { Known::Yes } {
                return self
                    .broken(Rule::Position, now, || format!("the positions known: {answer}"));
            }
            track.known = if known { Known::Yes } else { Known::No };
        }
        Ok(())
    }

    /// Learns the settings after a loss of power.
    fn learn(&mut self, answer: &str, now: u64) {
        if now > self.stored.1 + self.board.ticks(KEPT) {
            let old = self.stored.0.len().saturating_sub(1);
            self.stored.0.drain(..old);
        }
        let can = self.board.can;
        let told = |settings: &Settings| {
            let has = |name: settings::Name| {
                let want = format!("{}={}", name.word(), settings.get(name));
                answer.split(' ').any(|word| word == want)
            };
            settings::Name::all(can).all(has)
        };
        if let Some(at) = self.stored.0.iter().position(told) {
            self.settings = self.stored.0.swap_remove(at);
            self.stored = (vec![self.settings.clone()], 0);
        }
        self.unsure = false;
        self.set_up(now);
    }

    /// Checks the answer to `$` and `$name`.
    pub(super) fn listed(
        &mut self,
        line: Line,
        answer: &str,
        asked: &Asked,
        now: u64,
    ) -> Result<(), Fault> {
        if self.unsure {
            self.learn(answer, now);
        }
        let has = |name: settings::Name| {
            let want = format!("{}={}", name.word(), self.settings.get(name));
            answer.split(' ').any(|word| word == want)
        };
        let fits = match line {
            Line::Get(name) => has(name) && !answer.contains(' '),
            _ => settings::Name::all(self.board.can).all(has),
        };
        if fits { Ok(()) } else { self.wrong(asked, answer, now) }
    }
}
