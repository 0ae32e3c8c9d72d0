//! A link over TCP: a plain socket, as `ser2net` provides for a serial port (`raw`, not `telnet`).

use std::io::{self, ErrorKind, Read, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::time::{Duration, Instant};

use super::Link;

/// How long a connection may take, and how long a write may block.
const PATIENCE: Duration = Duration::from_secs(5);

/// A link over TCP.
pub struct TcpLink {
    stream: TcpStream,
    name: String,
    opened: Instant,
}

impl TcpLink {
    /// Connects to `HOST:PORT`.
    ///
    /// # Errors
    /// No program listens there, or none answers within 5 s; the address does not exist.
    pub fn open(address: &str) -> io::Result<TcpLink> {
        let mut last = io::Error::from(ErrorKind::AddrNotAvailable);
        for place in address.to_socket_addrs()? {
            match TcpStream::connect_timeout(&place, PATIENCE) {
                Ok(stream) => {
                    // Without a delay: a line is a few bytes, and the next one waits for its answer.
                    stream.set_nodelay(true)?;
                    stream.set_write_timeout(Some(PATIENCE))?;
                    let name = format!("tcp://{address}");
                    return Ok(TcpLink { stream, name, opened: Instant::now() });
                }
                Err(error) => last = error,
            }
        }
        Err(last)
    }
}

impl Link for TcpLink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<()> {
        self.stream.write_all(bytes).map_err(|error| match error.kind() {
            ErrorKind::WouldBlock => ErrorKind::TimedOut.into(),
            _ => error,
        })
    }

    fn read(&mut self, buffer: &mut [u8], limit: Duration) -> io::Result<usize> {
        self.stream.set_read_timeout(Some(limit.max(Duration::from_millis(1))))?;
        match self.stream.read(buffer) {
            Ok(0) => Err(ErrorKind::UnexpectedEof.into()),
            Ok(count) => Ok(count),
            Err(error) => match error.kind() {
                ErrorKind::TimedOut | ErrorKind::Interrupted | ErrorKind::WouldBlock => Ok(0),
                _ => Err(error),
            },
        }
    }

    fn now(&self) -> Duration {
        self.opened.elapsed()
    }

    fn name(&self) -> String {
        self.name.clone()
    }
}
