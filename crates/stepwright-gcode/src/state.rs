//! The state on which a block is executed: modes, position and parameters.

use crate::modal::MotionMode;
use crate::words::{AXES, Action, At, CoolantCode, Home, Letter, Refused, Words};
use crate::{
    Block, Coolant, Decimal, Effect, Fault, FeedRate, Length, Modal, Move, MoveKind, Parameter,
    Point, Spindle, SpindleMode, Stop, System,
};

/// Modes, position and parameters.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct State {
    pub modal: Modal,
    pub position: Point,
    systems: [Point; System::ALL.len()],
    g28: Point,
    g30: Point,
    g92: Point,
    tool_length: Length,
}

impl State {
    /// Executes a block in the order of the standard. After a fault `self` is not valid any more.
    pub fn execute(&mut self, mut words: Words) -> Result<Block, Refused> {
        let mut block = Block { number: number(&mut words)?, ..Block::default() };
        let moves = self.moves(&words)?;
        self.set_modes(&words);
        let feed = self.feed(&mut words)?;
        self.tools(&mut words, &mut block)?;
        if let Some(At { it: Action::Dwell, column }) = words.action {
            let seconds = not_negative(&mut words, Letter::P)?;
            let seconds = seconds.ok_or((Fault::Missing('P'), column))?;
            block.add(Effect::Dwell(seconds.it));
        }
        if let Some(set) = words.tool_length {
            self.tool_length(&mut words, set, &mut block)?;
        }
        if let Some(At { it: action, column }) = words.action {
            self.act(&mut words, action, column, &mut block)?;
        }
        if let Some(set) = words.path_control {
            self.tolerance(&mut words, set.it)?;
        }
        if moves {
            self.go(&mut words, feed, &mut block)?;
        }
        if let Some(stop) = words.stop {
            self.stop(stop.it, &mut block);
        }
        match words.unused() {
            Some(unused) => Err(unused),
            None => Ok(block),
        }
    }

    /// Whether the axis words belong to the motion mode. Only one code may use them.
    fn moves(&self, words: &Words) -> Result<bool, Refused> {
        let axis_words = words.any(AXES);
        let motion = words.motion.map_or(self.modal.motion, |code| code.it);
        if let Some(At { it: Action::Machine, column }) = words.action
            && !matches!(motion, MotionMode::Rapid | MotionMode::Feed)
        {
            return Err((Fault::MachineMode, column));
        }
        let moves = words.motion.filter(|code| code.it != MotionMode::Off);
        let acts = words.action.filter(|code| {
            matches!(code.it, Action::SetSystem | Action::Return(_) | Action::SetOffset)
        });
        let columns = [
            moves.map(|code| code.column),
            acts.map(|code| code.column),
            words.tool_length.map(|code| code.column),
        ];
        let mut columns = columns.into_iter().flatten();
        let user = columns.next();
        if let (Some(one), Some(other)) = (user, columns.next()) {
            return Err((Fault::AxisConflict, one.max(other)));
        }
        match (axis_words, motion) {
            _ if user.is_some() && moves.is_none() => Ok(false),
            (Some(column), MotionMode::Off) => Err((Fault::AxisUnused, column)),
            (Some(_), _) => Ok(true),
            // Without axis words, G0 and G1 only set the mode.
            (None, MotionMode::Rapid | MotionMode::Feed) => Ok(false),
            (None, _) => user.map_or(Ok(false), |column| Err((Fault::NoAxis, column))),
        }
    }

    fn set_modes(&mut self, words: &Words) {
        let modal = &mut self.modal;
        let or = |code: Option<At<bool>>, now| code.map_or(now, |code| code.it);
        modal.inches = or(words.units, modal.inches);
        modal.incremental = or(words.distance, modal.incremental);
        let inverse_time = or(words.feed_mode, modal.inverse_time);
        if inverse_time != modal.inverse_time {
            modal.inverse_time = inverse_time;
            modal.feed = None;
        }
        modal.plane = words.plane.map_or(modal.plane, |code| code.it);
        modal.system = words.system.map_or(modal.system, |code| code.it);
        modal.motion = words.motion.map_or(modal.motion, |code| code.it);
    }

    /// The feed rate of a move of this block, if it is known.
    fn feed(&mut self, words: &mut Words) -> Result<Option<FeedRate>, Refused> {
        let given = not_negative(words, Letter::F)?;
        if self.modal.inverse_time {
            let moves = given.filter(|given| given.it != Decimal::ZERO);
            return Ok(moves.map(|moves| FeedRate::Inverse(moves.it)));
        }
        if let Some(given) = given {
            self.modal.feed = Some(self.length(given)?).filter(|&feed| feed != Length::ZERO);
        }
        Ok(self.modal.feed.map(FeedRate::PerMinute))
    }

    /// Spindle, tool and coolant.
    fn tools(&mut self, words: &mut Words, block: &mut Block) -> Result<(), Refused> {
        if let Some(tool) = not_negative(words, Letter::T)? {
            let number = whole(tool, 'T')?;
            let number = u8::try_from(number).map_err(|_| tool.fault(Fault::Tool))?;
            if number != self.modal.tool {
                self.modal.tool = number;
                block.add(Effect::Tool(number));
            }
        }
        let was = self.modal.spindle;
        let speed = not_negative(words, Letter::S)?.map_or(was.speed, |speed| speed.it);
        let mode = words.spindle.map_or(was.mode, |code| code.it);
        self.set_spindle(Spindle { mode, speed }, block);
        let was = self.modal.coolant;
        let coolant = match words.coolant.map(|code| code.it) {
            None => was,
            Some(CoolantCode::Mist) => Coolant { mist: true, ..was },
            Some(CoolantCode::Flood) => Coolant { flood: true, ..was },
            Some(CoolantCode::Off) => Coolant::default(),
        };
        self.set_coolant(coolant, block);
        Ok(())
    }

    fn set_spindle(&mut self, spindle: Spindle, block: &mut Block) {
        if spindle != self.modal.spindle {
            self.modal.spindle = spindle;
            block.add(Effect::Spindle(spindle));
        }
    }

    fn set_coolant(&mut self, coolant: Coolant, block: &mut Block) {
        if coolant != self.modal.coolant {
            self.modal.coolant = coolant;
            block.add(Effect::Coolant(coolant));
        }
    }

    /// G61, and G64 with a P or without.
    fn tolerance(&mut self, words: &mut Words, goes_on: bool) -> Result<(), Refused> {
        let given = if goes_on { not_negative(words, Letter::P)? } else { None };
        self.modal.tolerance = given.map_or(Ok(Length::ZERO), |given| self.length(given))?;
        Ok(())
    }

    fn tool_length(
        &mut self,
        words: &mut Words,
        set: At<bool>,
        block: &mut Block,
    ) -> Result<(), Refused> {
        self.tool_length = Length::ZERO;
        if set.it {
            let others = [Letter::X, Letter::Y].iter().filter_map(|&axis| words.column(axis));
            if let Some(column) = others.min() {
                return Err((Fault::ToolAxis, column));
            }
            let z = words.take(Letter::Z).ok_or(set.fault(Fault::ToolAxis))?;
            self.tool_length = self.length(z)?;
        }
        block.add(self.parameter_effect(Parameter::ToolLength));
        Ok(())
    }

    /// Executes a code that acts once, except G4 and G53.
    fn act(
        &mut self,
        words: &mut Words,
        action: Action,
        column: u16,
        block: &mut Block,
    ) -> Result<(), Refused> {
        let parameter = match action {
            Action::Dwell | Action::Machine => return Ok(()),
            Action::SetSystem => self.set_system(words, column)?,
            Action::Return(home) => return self.return_home(words, home, block),
            Action::Keep(home) => {
                *self.home(home) = self.position;
                match home {
                    Home::G28 => Parameter::G28,
                    Home::G30 => Parameter::G30,
                }
            }
            Action::SetOffset => {
                self.g92 = self.zero_for(words, self.g92, column)?;
                Parameter::G92
            }
            Action::ClearOffset => {
                self.g92 = Point::ZERO;
                Parameter::G92
            }
        };
        block.add(self.parameter_effect(parameter));
        Ok(())
    }

    /// G10 L2 and G10 L20.
    fn set_system(&mut self, words: &mut Words, column: u16) -> Result<Parameter, Refused> {
        let missing = |letter: Letter| (Fault::Missing(letter.name()), column);
        let l = words.take(Letter::L).ok_or(missing(Letter::L))?;
        let p = not_negative(words, Letter::P)?.ok_or(missing(Letter::P))?;
        let system = match whole(p, 'P')? {
            0 => self.modal.system,
            1 => System::G54,
            2 => System::G55,
            3 => System::G56,
            4 => System::G57,
            5 => System::G58,
            6 => System::G59,
            _ => return Err(p.fault(Fault::NoSystem)),
        };
        let was = self.parameter(Parameter::System(system));
        let zero = match whole(l, 'L')? {
            2 => self.given(words, was, column)?,
            20 => {
                // As if the system were the present one.
                let present = core::mem::replace(&mut self.modal.system, system);
                let zero = self.zero_for(words, was, column)?;
                self.modal.system = present;
                zero
            }
            _ => return Err(l.fault(Fault::GCode)),
        };
        self.set_parameter(Parameter::System(system), zero);
        Ok(Parameter::System(system))
    }

    /// The point with the axis words put in, as they are.
    fn given(&self, words: &mut Words, mut point: Point, column: u16) -> Result<Point, Refused> {
        words.any(AXES).ok_or((Fault::NoAxis, column))?;
        for (axis, letter) in point.0.iter_mut().zip(AXES) {
            if let Some(word) = words.take(letter) {
                *axis = self.length(word)?;
            }
        }
        Ok(point)
    }

    /// The offset `was`, changed so that the present position gets the coordinates of the words.
    fn zero_for(&self, words: &mut Words, was: Point, column: u16) -> Result<Point, Refused> {
        words.any(AXES).ok_or((Fault::NoAxis, column))?;
        let (mut zero, origin) = (was, self.origin());
        for (axis, letter) in AXES.into_iter().enumerate() {
            if let Some(word) = words.take(letter) {
                // Position = origin + coordinate, and the offset is a part of the origin.
                let [here, rest] = [self.position.0[axis], was.0[axis]];
                let coordinate = self.length(word)?;
                let others = origin[axis].map(|term| -term);
                let [system, g92, tool] = others;
                zero.0[axis] = Length::sum(&[here, rest, system, g92, tool, -coordinate])
                    .ok_or(word.fault(Fault::TooFar))?;
            }
        }
        Ok(zero)
    }

    /// G28 and G30: first to the position that the axis words give, then home with the axes that they name, or
    /// with all if there are none.
    fn return_home(
        &mut self,
        words: &mut Words,
        home: Home,
        block: &mut Block,
    ) -> Result<(), Refused> {
        let named = AXES.map(|axis| words.column(axis).is_some());
        let mut end = *self.home(home);
        if named.contains(&true) {
            let between = self.target(words)?;
            self.line(between, MoveKind::Rapid, block);
            for ((end, named), here) in end.0.iter_mut().zip(named).zip(between.0) {
                if !named {
                    *end = here;
                }
            }
        }
        self.line(end, MoveKind::Rapid, block);
        Ok(())
    }

    fn home(&mut self, home: Home) -> &mut Point {
        match home {
            Home::G28 => &mut self.g28,
            Home::G30 => &mut self.g30,
        }
    }

    /// Executes the axis words in the motion mode.
    fn go(
        &mut self,
        words: &mut Words,
        feed: Option<FeedRate>,
        block: &mut Block,
    ) -> Result<(), Refused> {
        let first = words.any(AXES).unwrap_or_default();
        let column = words.motion.map_or(first, |code| code.column);
        let feed = feed.ok_or((Fault::NoFeed, column));
        let in_plane = self.modal.plane.axes().map(|axis| words.column(AXES[axis]).is_some());
        let to = self.target(words)?;
        match self.modal.motion {
            MotionMode::Off => {}
            MotionMode::Rapid => self.line(to, MoveKind::Rapid, block),
            MotionMode::Feed => self.line(to, MoveKind::Feed(feed?), block),
            MotionMode::Probe(_) if to == self.position => {
                return Err((Fault::ProbeHere, column));
            }
            MotionMode::Probe(probe) => self.line(to, MoveKind::Probe(probe, feed?), block),
            MotionMode::Clockwise | MotionMode::CounterClockwise => {
                let feed = feed?;
                if !in_plane[0] && !in_plane[1] {
                    return Err((Fault::ArcEnd, first));
                }
                let arc = self.arc(words, to, column)?;
                self.add_move(to, MoveKind::Arc(arc, feed), block);
            }
        }
        Ok(())
    }

    /// The end that the axis words give, in machine coordinates.
    fn target(&self, words: &mut Words) -> Result<Point, Refused> {
        let machine = matches!(words.action, Some(At { it: Action::Machine, .. }));
        let (mut to, origin) = (self.position, self.origin());
        for ((end, letter), origin) in to.0.iter_mut().zip(AXES).zip(origin) {
            if let Some(word) = words.take(letter) {
                let length = self.length(word)?;
                let [system, g92, tool] = origin;
                let sum = match (machine, self.modal.incremental) {
                    (true, _) => Some(length),
                    (false, true) => Length::sum(&[*end, length]),
                    (false, false) => Length::sum(&[length, system, g92, tool]),
                };
                *end = sum.ok_or(word.fault(Fault::TooFar))?;
            }
        }
        Ok(to)
    }

    /// For each axis, the terms of the machine position of coordinate 0.
    fn origin(&self) -> [[Length; 3]; 3] {
        let (system, tool) = (self.systems[self.modal.system as usize], self.tool_length);
        let axis = |axis: usize, tool| [system.0[axis], self.g92.0[axis], tool];
        [axis(0, Length::ZERO), axis(1, Length::ZERO), axis(2, tool)]
    }

    /// Adds a straight move, if its end differs from the position.
    fn line(&mut self, to: Point, kind: MoveKind, block: &mut Block) {
        if to != self.position {
            self.add_move(to, kind, block);
        }
    }

    fn add_move(&mut self, to: Point, kind: MoveKind, block: &mut Block) {
        let from = core::mem::replace(&mut self.position, to);
        block.add(Effect::Move(Move { from, to, kind }));
    }

    fn stop(&mut self, stop: Stop, block: &mut Block) {
        if let Stop::End | Stop::Rewind = stop {
            let Modal { inches, feed, spindle, tool, coolant, tolerance, .. } = self.modal;
            self.modal =
                Modal { inches, feed, spindle, tool, coolant, tolerance, ..Modal::default() };
            self.modal.motion = MotionMode::Feed;
            self.set_spindle(Spindle { mode: SpindleMode::Off, ..spindle }, block);
            self.set_coolant(Coolant::default(), block);
        }
        block.add(Effect::Stop(stop));
    }

    /// A word as a length.
    pub fn length(&self, word: At<Decimal>) -> Result<Length, Refused> {
        Length::of(word.it, self.modal.inches).ok_or(word.fault(Fault::TooLarge))
    }

    /// The value of a parameter.
    pub fn parameter(&self, parameter: Parameter) -> Point {
        match parameter {
            Parameter::System(system) => {
                self.systems.get(system as usize).copied().unwrap_or_default()
            }
            Parameter::G28 => self.g28,
            Parameter::G30 => self.g30,
            Parameter::G92 => self.g92,
            Parameter::ToolLength => Point([Length::ZERO, Length::ZERO, self.tool_length]),
        }
    }

    fn parameter_effect(&self, parameter: Parameter) -> Effect {
        Effect::Parameter(parameter, self.parameter(parameter))
    }

    /// Sets a parameter. Of the length of the tool only Z is used.
    pub fn set_parameter(&mut self, parameter: Parameter, value: Point) {
        match parameter {
            Parameter::System(system) => {
                if let Some(zero) = self.systems.get_mut(system as usize) {
                    *zero = value;
                }
            }
            Parameter::G28 => self.g28 = value,
            Parameter::G30 => self.g30 = value,
            Parameter::G92 => self.g92 = value,
            Parameter::ToolLength => self.tool_length = value.0[2],
        }
    }
}

/// The line number, N.
fn number(words: &mut Words) -> Result<Option<u32>, Refused> {
    let Some(word) = not_negative(words, Letter::N)? else { return Ok(None) };
    let number = word.it.whole().and_then(|number| u32::try_from(number).ok());
    // Rounded up from a fraction, it may have one digit more.
    let number = number.filter(|&number| number <= 9_999_999);
    number.map(Some).ok_or(word.fault(Fault::LineNumber))
}

/// The value of a letter that takes no negative number.
fn not_negative(words: &mut Words, letter: Letter) -> Result<Option<At<Decimal>>, Refused> {
    match words.take(letter) {
        Some(word) if word.it < Decimal::ZERO => Err(word.fault(Fault::Negative(letter.name()))),
        word => Ok(word),
    }
}

/// A word that takes a whole number.
fn whole(word: At<Decimal>, letter: char) -> Result<i64, Refused> {
    word.it.whole().ok_or(word.fault(Fault::Fraction(letter)))
}
