//! The suite passes the model, and finds each fault of players that have one.

use std::cell::Cell;
use std::rc::Rc;

use stepwright::drive::Axes;
use stepwright::{Ticks, Timing};
use stepwright_sink::{
    Halted, ModelEdge, ModelPlayer, Player, PlayerFault, PlayerPort, StepGroup, Tried, check,
};

const TIMING: Timing = Timing { pulse: 125, setup: 125, hold: 125, min_interval: 250 };

/// What is wrong with a player.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Wrong {
    Nothing,
    OneMore,
    OneLess,
    PresentWaits,
    LongGroups,
    ShortGroups,
    NeverDry,
    AlwaysDry,
    Unasked,
    NoRoom,
    OneByOne,
}

struct Faulty<F> {
    model: ModelPlayer<2, F>,
    wrong: Wrong,
}

impl<F: FnMut(ModelEdge)> Player for Faulty<F> {
    const DEPTH: u8 = 4;
    const LAG: Ticks = 0;

    fn now(&self) -> u64 {
        self.model.now()
    }
    fn set_timing(&mut self, timing: &Timing) {
        self.model.set_timing(timing);
    }
    fn has_room(&self, axis: u8) -> bool {
        self.wrong != Wrong::NoRoom && self.model.has_room(axis)
    }
    fn put(&mut self, axis: u8, mut group: StepGroup) {
        match self.wrong {
            Wrong::LongGroups => group.interval += 3,
            Wrong::ShortGroups => group.interval -= 3,
            _ => {}
        }
        self.model.put(axis, group);
        if self.wrong == Wrong::Unasked {
            self.model.start(1 << axis);
        }
    }
    fn start(&mut self, axes: Axes) {
        self.model.start(if self.wrong == Wrong::OneByOne { axes & 1 } else { axes });
    }
    fn waiting(&self, axis: u8) -> u8 {
        self.model.waiting(axis)
    }
    fn rests(&self, axis: u8) -> bool {
        self.model.rests(axis)
    }
    fn ran_dry(&mut self, axis: u8) -> bool {
        let dry = self.model.ran_dry(axis);
        dry && self.wrong != Wrong::NeverDry || self.wrong == Wrong::AlwaysDry
    }
    fn halt(&mut self, axes: Axes) {
        self.model.halt(axes);
    }
    fn forget(&mut self, axis: u8) -> Halted {
        let Halted { waiting, left } = self.model.forget(axis);
        match self.wrong {
            Wrong::OneMore if left != 0 => Halted { waiting, left: left + 1 },
            Wrong::OneLess if left > 1 => Halted { waiting, left: left - 1 },
            Wrong::PresentWaits if left != 0 => Halted { waiting: waiting + 1, left: 0 },
            _ => Halted { waiting, left },
        }
    }
}

struct Port<F> {
    player: Faulty<F>,
    seen: Rc<[Cell<i64>; 2]>,
    watched: bool,
}

impl<F: FnMut(ModelEdge)> PlayerPort for Port<F> {
    type Player = Faulty<F>;
    fn player(&mut self) -> &mut Faulty<F> {
        &mut self.player
    }
    fn idle(&mut self) {
        self.player.model.pass(7);
    }
    fn seen(&mut self, axis: u8) -> Option<i64> {
        self.watched.then(|| self.seen[usize::from(axis)].get())
    }
}

fn tried(wrong: Wrong, watched: bool) -> Result<Tried, PlayerFault> {
    let seen = Rc::new([Cell::new(0), Cell::new(0)]);
    let own = seen.clone();
    let model = ModelPlayer::new(move |edge: ModelEdge| {
        let seen = &own[usize::from(edge.axis)];
        match edge.step {
            Some(true) => seen.set(seen.get() + 1),
            Some(false) => seen.set(seen.get() - 1),
            None => {}
        }
    });
    let player = Faulty { model, wrong };
    check(&mut Port { player, seen, watched }, 2, &TIMING, 1_000, 20)
}

#[test]
fn the_model_keeps_the_contract() {
    for watched in [true, false] {
        let tried = tried(Wrong::Nothing, watched).unwrap();
        assert_eq!((tried.halts, tried.watched), (120, watched));
        assert!(tried.groups > 500);
    }
}

#[test]
fn every_fault_is_found() {
    let found = |wrong| tried(wrong, true).unwrap_err();
    assert!(matches!(found(Wrong::OneMore), PlayerFault::Count(0, ..)));
    assert!(matches!(found(Wrong::OneLess), PlayerFault::Count(0, ..)));
    assert!(matches!(found(Wrong::PresentWaits), PlayerFault::Count(0, ..)));
    assert!(matches!(found(Wrong::LongGroups), PlayerFault::Slow(0, _)));
    assert!(matches!(found(Wrong::ShortGroups), PlayerFault::Fast(0, _)));
    assert_eq!(found(Wrong::NeverDry), PlayerFault::Dry(0));
    assert_eq!(found(Wrong::AlwaysDry), PlayerFault::Dry(0));
    assert!(matches!(found(Wrong::Unasked), PlayerFault::Moved(0) | PlayerFault::Waiting(0, _)));
    assert_eq!(found(Wrong::NoRoom), PlayerFault::Room(0));
    assert!(matches!(found(Wrong::OneByOne), PlayerFault::Slow(1, _)));
    // Two steps too many are seen by the time alone.
    assert!(tried(Wrong::PresentWaits, false).is_err());
}
