//! An engine over a player.

use stepwright::drive::Axes;
use stepwright::queue::Consumer;
use stepwright::{Control, Playing, Report, Ticks, Timing};

use crate::player::Player;
use crate::track::{Phase, Track};

/// An engine over a player of N ≤ 8 axes: keeps it filled from the queues, and reports the positions.
///
/// It plans nothing and steps nothing. The player's interrupt calls [`serve`](SinkEngine::serve), or a loop
/// does that takes less time than [`DEPTH`](Player::DEPTH) groups. For an engine in a static, behind an
/// interrupt, see [`SharedSink`](crate::SharedSink).
///
/// A step counts as [late](Control::late) if the player stood still before it, as its group came too late.
pub struct SinkEngine<'q, P, const N: usize, const Q: usize> {
    player: P,
    tracks: [Track<'q, Q>; N],
    timing: Timing,
    /// The axes that are to be started together, and the earliest time for it.
    starting: Axes,
    ready: u64,
}

impl<'q, P: Player, const N: usize, const Q: usize> SinkEngine<'q, P, N, Q> {
    const AT_MOST_8_AXES: () = assert!(N >= 1 && N <= 8);
    const REMEMBERS: () = assert!(P::DEPTH >= 1 && P::DEPTH <= 7);

    /// An engine whose axes rest at position 0, facing forward. Each step is at most `bound` ticks from its
    /// planned time. A good bound is 1 µs, see [`Grouper::new`](crate::Grouper::new).
    pub fn new(player: P, entries: [Consumer<'q, Q>; N], timing: Timing, bound: Ticks) -> Self {
        let () = Self::AT_MOST_8_AXES;
        let () = Self::REMEMBERS;
        let tracks = entries.map(|source| Track::new(source, bound));
        let mut engine = SinkEngine { player, tracks, timing, starting: 0, ready: 0 };
        engine.set_timing(timing);
        engine
    }

    /// The player.
    pub fn player(&mut self) -> &mut P {
        &mut self.player
    }

    /// Fills the player's FIFOs of these axes: for its interrupt, when a group has begun. Returns whether there
    /// is news for the main loop: a queue has room again, or is empty.
    #[cfg_attr(feature = "in-ram", unsafe(link_section = ".data.stepwright"))]
    pub fn serve(&mut self, axes: Axes) -> bool {
        let (mut news, mut left) = (false, axes);
        for (axis, track) in (0u8..).zip(&mut self.tracks) {
            if left == 0 {
                break;
            }
            let asked = left & 1 != 0;
            left >>= 1;
            if asked {
                news |= track.fill(&mut self.player, axis, self.timing.hold);
            }
        }
        if self.starting != 0 {
            self.start_all();
        }
        news
    }

    /// Serves the axes whose player waits for entries, which the foreground may have queued meanwhile. Cheap if
    /// there are none.
    #[inline]
    pub fn catch_up(&mut self) {
        let mut hungry = self.starting;
        for (axis, track) in (0u8..).zip(&self.tracks) {
            hungry |= u8::from(track.hungry) << axis;
        }
        if hungry != 0 {
            self.serve(hungry);
        }
    }

    /// Starts the axes that are to be started, if they have a group and DIR may change.
    #[inline(never)]
    fn start_all(&mut self) {
        let (mut axes, mut waiting): (Axes, Axes) = (0, 0);
        for (axis, track) in (0u8..).zip(&self.tracks) {
            if self.starting >> axis & 1 != 0 {
                if track.is_ready() {
                    axes |= 1 << axis;
                } else if track.phase == Phase::Begins {
                    waiting |= 1 << axis;
                } else {
                    self.starting &= !(1 << axis);
                }
            }
        }
        if axes | waiting == 0 {
            return;
        }
        let now = self.player.now();
        if now < self.ready {
            return;
        }
        if waiting != 0 {
            for (axis, track) in (0u8..).zip(&mut self.tracks) {
                if waiting >> axis & 1 != 0 {
                    track.waits(now);
                }
            }
        }
        if axes == 0 {
            return;
        }
        self.player.start(axes);
        let now = self.player.now();
        for (axis, track) in (0u8..).zip(&mut self.tracks) {
            if axes >> axis & 1 != 0 {
                track.started(now);
            }
        }
        self.starting &= !axes;
    }
}

impl<P: Player, const N: usize, const Q: usize> Control for SinkEngine<'_, P, N, Q> {
    fn start(&mut self, axes: Axes) {
        let mut began: Axes = 0;
        for (axis, track) in (0u8..).zip(&mut self.tracks) {
            if axes >> axis & 1 != 0 && track.is_idle(&self.player, axis, self.timing.hold) {
                // After a halt the hold time of DIR is still running.
                let held = track.end.saturating_add(self.timing.hold.into());
                self.ready = self.ready.max(held);
                track.begin();
                // Groups that are put from now on wait for the start.
                self.player.halt(1 << axis);
                self.player.forget(axis);
                began |= 1 << axis;
            }
        }
        self.starting |= began;
        self.serve(began);
    }

    fn kill(&mut self, axes: Axes) {
        self.player.halt(axes);
        self.starting &= !axes;
        for (axis, track) in (0u8..).zip(&mut self.tracks) {
            if axes >> axis & 1 != 0 {
                track.halted(&mut self.player, axis);
            }
        }
    }

    /// The position of a moving axis is computed from the time. Just after an edge it may be a step behind.
    fn report(&self, axis: u8) -> Report {
        let none = Report { position: 0, idle: true, forward: true };
        let Some(track) = self.tracks.get(usize::from(axis)) else { return none };
        Report {
            position: track.made(&self.player, axis),
            idle: track.is_idle(&self.player, axis, self.timing.hold),
            forward: track.grouper.is_forward(),
        }
    }

    fn is_idle(&self, axis: u8) -> bool {
        let track = self.tracks.get(usize::from(axis));
        track.is_none_or(|track| track.is_idle(&self.player, axis, self.timing.hold))
    }

    fn playing(&mut self, axis: u8) -> Playing {
        self.catch_up();
        let track = self.tracks.get(usize::from(axis));
        track.map_or(Playing::Unknown, |track| track.playing(&self.player))
    }

    fn set_position(&mut self, axis: u8, position: i64) {
        if let Some(track) = self.tracks.get_mut(usize::from(axis)) {
            let made = track.made(&self.player, axis);
            track.displace(position.wrapping_sub(made));
        }
    }

    fn set_timing(&mut self, timing: Timing) {
        self.timing = timing;
        self.player.set_timing(&timing);
        for track in &mut self.tracks {
            track.grouper.set_timing(&timing, P::LAG);
        }
    }

    fn late(&self) -> u32 {
        self.tracks.iter().fold(0, |dry, track| dry.saturating_add(track.dry))
    }

    fn clear_late(&mut self) {
        self.tracks.iter_mut().for_each(|track| track.dry = 0);
    }

    fn refill(&mut self) {
        self.serve(Axes::MAX);
    }
}
