//! A board and its axes for tokio, over any stream that reads and writes bytes.

use std::future::poll_fn;
use std::io::ErrorKind;
use std::pin::pin;
use std::task::Poll;
use std::time::Duration;

use stepwright::Speed;
use stepwright_protocol::{AxisId, Direction};
use tokio::io::{AsyncRead, AsyncReadExt, AsyncWrite, AsyncWriteExt};
use tokio::net::{TcpStream, ToSocketAddrs};
use tokio::time::{Instant, sleep_until, timeout};

use crate::calls::{AxisCalls, axis, axis_calls, kill_all, stop_all};
use crate::conversation::{Conversation, PATIENCE};
use crate::link::OpenError;
use crate::motion::{Action, Sight};
use crate::outcome::{Error, MotionLimits, Outcome};
use crate::pipe::Pipe;

/// A board whose calls are futures. A future that is dropped before its end leaves the motors as they are; the
/// next call first gets in step with the board. The futures are `Send` if the stream is, so a task that holds
/// them may be spawned on any runtime of tokio.
///
/// ```no_run
/// # async fn example() -> Result<(), stepwright_host::Error> {
/// use stepwright_host::{AsyncBoard, MotionLimits};
///
/// let mut board = AsyncBoard::connect("192.168.0.7:4000").await?;
/// println!("{}", board.axis(1)?.move_to(2_000, &MotionLimits::default()).await?);
/// # Ok(())
/// # }
/// ```
pub struct AsyncBoard<S> {
    stream: S,
    pipe: Pipe,
    talk: Conversation,
    opened: Instant,
}

impl AsyncBoard<TcpStream> {
    /// Connects to a board over a plain socket, as `ser2net` provides for a serial port.
    ///
    /// # Errors
    /// [`Error::Open`]; [`Error::Lost`] if no board answers within 4 s.
    pub async fn connect(address: impl ToSocketAddrs) -> Result<AsyncBoard<TcpStream>, Error> {
        let open = |error| Error::Open(OpenError::Io(error));
        let stream = TcpStream::connect(address).await.map_err(open)?;
        // Without a delay: a line is a few bytes, and the next one waits for its answer.
        stream.set_nodelay(true).map_err(open)?;
        AsyncBoard::on(stream).await
    }
}

impl<S: AsyncRead + AsyncWrite + Unpin> AsyncBoard<S> {
    /// Meets the board at the other end of a stream, such as a socket or a serial port of `tokio-serial`.
    ///
    /// # Errors
    /// [`Error::Lost`] if no board answers within 4 s.
    pub async fn on(stream: S) -> Result<AsyncBoard<S>, Error> {
        let pipe = Pipe::new();
        let talk = Conversation::new(pipe.clone());
        let mut board = AsyncBoard { stream, pipe, talk, opened: Instant::now() };
        let met = board.part(async |talk| talk.meet().await).await;
        met.map_err(|trouble| Error::Lost { trouble, moving: false })?;
        Ok(board)
    }

    /// An axis by its number: 1 is X.
    ///
    /// # Errors
    /// [`Error::NoAxis`]
    pub fn axis(&mut self, number: u8) -> Result<AsyncAxis<'_, S>, Error> {
        let id = axis(&self.talk, number)?;
        Ok(AsyncAxis { board: self, id })
    }

    /// Brakes every axis along its ramp, and waits until all rest. The positions stay known.
    ///
    /// # Errors
    /// [`Error::Lost`]
    pub async fn stop(&mut self) -> Result<(), Error> {
        self.part(async |talk| stop_all(talk).await).await
    }

    /// Stops every axis at once: the position of an axis that moves becomes unknown.
    ///
    /// # Errors
    /// [`Error::Lost`] if the board does not confirm the kill: switch its power off.
    pub async fn kill(&mut self) -> Result<(), Error> {
        self.part(async |talk| kill_all(talk).await).await
    }

    /// Runs a part of the conversation to its end, for what this type has no method for.
    pub async fn part<T>(&mut self, part: impl AsyncFnOnce(&mut Conversation) -> T) -> T {
        let AsyncBoard { stream, pipe, talk, opened } = self;
        let mut part = pin!(part(talk));
        let mut buffer = [0; 256];
        loop {
            pipe.pass(opened.elapsed());
            let polled = poll_fn(|context| Poll::Ready(part.as_mut().poll(context))).await;
            let output = pipe.take_output();
            // Without time for a byte no answer will come either; the part handles that.
            if !output.is_empty()
                && let Ok(Err(error)) = timeout(PATIENCE, stream.write_all(&output)).await
            {
                pipe.lose(error);
            }
            if let Poll::Ready(result) = polled {
                return result;
            }
            let until = *opened + pipe.deadline().unwrap_or_default();
            tokio::select! {
                read = stream.read(&mut buffer) => match read {
                    Ok(0) => pipe.lose(ErrorKind::UnexpectedEof.into()),
                    Ok(count) => pipe.feed(buffer.get(..count).unwrap_or_default()),
                    Err(error) => pipe.lose(error),
                },
                () = sleep_until(until) => {}
            }
        }
    }
}

/// An axis of a board.
pub struct AsyncAxis<'b, S> {
    board: &'b mut AsyncBoard<S>,
    id: AxisId,
}

/// The calls of an axis, as futures.
macro_rules! awaited {
    ($($(#[$doc:meta])* $name:ident($($arg:ident: $type:ty),*) -> $out:ty;)*) => {
        $($(#[$doc])*
        pub async fn $name(&mut self, $($arg: $type),*) -> Result<$out, Error> {
            let id = self.id;
            let part = async |talk: &mut Conversation| {
                AxisCalls { talk, id }.$name($($arg),*).await
            };
            self.board.part(part).await
        })*
    };
}

impl<S: AsyncRead + AsyncWrite + Unpin> AsyncAxis<'_, S> {
    axis_calls!(awaited);
}
