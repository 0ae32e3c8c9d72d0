//! A board and its axes, for a thread that blocks.

use std::time::Duration;

use stepwright::Speed;
use stepwright_protocol::{AxisId, Direction};

use crate::calls::{AxisCalls, axis, axis_calls, kill_all, stop_all};
use crate::conversation::{Conversation, LinkError};
use crate::link::tcp::TcpLink;
use crate::link::{Link, OpenError};
use crate::motion::{Action, Sight};
use crate::outcome::{Error, MotionLimits, Outcome};
use crate::session::Session;

/// A connected board. When it is dropped its motors go on; [`stop`](Board::stop) brakes them. It stays in the
/// thread that opened it (it is not `Send`).
pub struct Board {
    session: Session,
}

impl Board {
    /// Opens the board on a serial port, at 115,200 baud. While this program waits for the board, other
    /// programs of this user may ask it and change its travels. `tcp://HOST:PORT` is a plain socket, as
    /// `ser2net` provides for a serial port.
    ///
    /// # Errors
    /// [`Error::Open`]; [`Error::Lost`] if no board answers within 4 s.
    #[cfg(feature = "serial")]
    pub fn open(path: impl AsRef<std::path::Path>) -> Result<Board, Error> {
        use crate::link::serial::{SerialLink, Share};
        if let Some(address) = path.as_ref().to_str().and_then(|path| path.strip_prefix("tcp://")) {
            return Board::connect(address);
        }
        let path = path.as_ref();
        #[cfg(unix)]
        let free = |path: &std::path::Path| crate::link::lease::let_run_out(path, |_| (), || false);
        #[cfg(not(unix))]
        let free = |_: &std::path::Path| crate::link::serial::LeaseWait::Over;
        let link = SerialLink::open(path, 115_200, Share::Host, free).map_err(Error::Open)?;
        #[cfg_attr(not(unix), expect(unused_mut))]
        let mut session = Session::new(Box::new(link));
        #[cfg(unix)]
        if let Some(host) = crate::link::host::Host::open(path) {
            session.serve(Box::new(host));
        }
        Board::of(session)
    }

    /// Connects to a board over a plain socket, `HOST:PORT`.
    ///
    /// # Errors
    /// [`Error::Open`]; [`Error::Lost`] if no board answers within 4 s.
    pub fn connect(address: &str) -> Result<Board, Error> {
        let link = TcpLink::open(address).map_err(|error| Error::Open(OpenError::Io(error)))?;
        Board::on(Box::new(link))
    }

    /// Joins the board on a port that another program of this user holds, through that program. Questions,
    /// changes of travels and stops are answered; orders and settings are refused.
    ///
    /// # Errors
    /// [`Error::Open`] if no program that holds the port lets others in; [`Error::Lost`].
    #[cfg(all(unix, feature = "serial"))]
    pub fn join(path: impl AsRef<std::path::Path>) -> Result<Board, Error> {
        use crate::link::guest::{GuestLink, PATIENCE};
        let link = GuestLink::open(path.as_ref(), PATIENCE);
        let nobody = || Error::Open(OpenError::Io(std::io::ErrorKind::NotFound.into()));
        Board::on(Box::new(link.ok_or_else(nobody)?))
    }

    /// A virtual Uno in this process: the engine of the chip with simulated pins. Its time passes in real time,
    /// or, if it is `fast`, as fast as it can be simulated.
    ///
    /// # Errors
    /// None is known.
    #[cfg(feature = "virtual")]
    pub fn virtual_uno(fast: bool) -> Result<Board, Error> {
        use crate::link::simulated::{VirtualLink, VirtualUno};
        Board::on(Box::new(VirtualLink::new(VirtualUno::new(), fast)))
    }

    /// Meets the board at the other end of a line.
    ///
    /// # Errors
    /// [`Error::Lost`] if no board answers within 4 s.
    pub fn on(link: Box<dyn Link>) -> Result<Board, Error> {
        Board::of(Session::new(link))
    }

    /// Meets the board. This program has started no motion yet.
    fn of(mut session: Session) -> Result<Board, Error> {
        session.meet().map_err(|trouble| Error::Lost { trouble, moving: false })?;
        Ok(Board { session })
    }

    /// An axis by its number: 1 is X. It borrows the board: with two axes, take one for each call.
    ///
    /// ```
    /// use stepwright_host::{Action, Board, MotionLimits};
    /// # fn main() -> Result<(), stepwright_host::Error> {
    /// let mut board = Board::virtual_uno(true)?;
    /// let limits = MotionLimits::default();
    /// board.axis(1)?.travel(400, &limits)?;
    /// board.axis(2)?.travel(-200, &limits)?;
    /// println!("{}", board.axis(1)?.wait(|_| Action::GoOn)?); // reached 400
    /// println!("{}", board.axis(2)?.wait(|_| Action::GoOn)?); // reached -200
    /// # Ok(())
    /// # }
    /// ```
    ///
    /// # Errors
    /// [`Error::NoAxis`]
    pub fn axis(&mut self, number: u8) -> Result<Axis<'_>, Error> {
        let id = axis(self.session.talk(), number)?;
        Ok(Axis { session: &mut self.session, id })
    }

    /// Brakes every axis along its ramp, and waits until all rest. The positions stay known.
    ///
    /// # Errors
    /// [`Error::Lost`]
    pub fn stop(&mut self) -> Result<(), Error> {
        self.session.wait(async |talk| stop_all(talk).await)?
    }

    /// Stops every axis at once: the position of an axis that moves becomes unknown.
    ///
    /// # Errors
    /// [`Error::Lost`] if the board does not confirm the kill: switch its power off.
    pub fn kill(&mut self) -> Result<(), Error> {
        self.session.set_guard(None);
        self.session.wait(async |talk| kill_all(talk).await)?
    }

    /// The session, for what this type has no method for: settings, questions.
    ///
    /// ```
    /// use stepwright_host::stepwright_protocol::{Command, Reply, Setting, Value};
    /// # fn main() -> Result<(), stepwright_host::Error> {
    /// let mut board = stepwright_host::Board::virtual_uno(true)?;
    /// // X has a limit switch.
    /// let switches = Value::new(Setting::Switches, 1).expect("0 to 7");
    /// assert_eq!(board.session().ask(Command::Set(switches))?, Reply::Yes);
    /// # Ok(())
    /// # }
    /// ```
    pub fn session(&mut self) -> &mut Session {
        &mut self.session
    }
}

/// An axis of a board.
pub struct Axis<'b> {
    session: &'b mut Session,
    id: AxisId,
}

/// The calls of an axis, each of which blocks until it is done.
macro_rules! waited {
    ($($(#[$doc:meta])* $name:ident($($arg:ident: $type:ty),*) -> $out:ty;)*) => {
        $($(#[$doc])*
        pub fn $name(&mut self, $($arg: $type),*) -> Result<$out, Error> {
            let id = self.id;
            let part = async |talk: &mut Conversation| {
                AxisCalls { talk, id }.$name($($arg),*).await
            };
            match self.session.wait(part) {
                Ok(done) => done,
                Err(trouble) => Err(self.ended(trouble)),
            }
        })*
    };
}

impl Axis<'_> {
    axis_calls!(waited);

    /// Ends a call that the guard has ended or whose line is gone. Kills if the guard asked for that.
    fn ended(&mut self, trouble: LinkError) -> Error {
        match trouble {
            LinkError::Killed => match self.session.kill() {
                Ok(true) => Error::Lost { trouble: LinkError::Killed, moving: false },
                Ok(false) => LinkError::Silent.into(),
                Err(trouble) => trouble.into(),
            },
            trouble => trouble.into(),
        }
    }
}
