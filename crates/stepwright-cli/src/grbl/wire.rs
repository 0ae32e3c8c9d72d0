//! The line to a sender: a pseudo-terminal, a TCP socket, standard input and output.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{self, Receiver, RecvTimeoutError};
use std::thread;
use std::time::Duration;

use crate::failure::Failure;
#[cfg(unix)]
use crate::pty::{Pty, failed};

/// The result of a read.
#[derive(Default)]
pub struct Heard {
    pub bytes: Vec<u8>,
    /// Whether a sender has connected, as when a serial port is opened.
    pub came: bool,
    /// Whether no sender is connected.
    pub nobody: bool,
    /// Whether the input has ended.
    pub ended: bool,
}

/// A line to one sender at a time.
pub enum Wire {
    #[cfg(unix)]
    Pty {
        pty: Pty,
        visited: bool,
    },
    Tcp {
        listener: TcpListener,
        sender: Option<TcpStream>,
    },
    Stdio {
        input: Receiver<Vec<u8>>,
    },
}

impl Wire {
    #[cfg(unix)]
    pub fn pty() -> Result<Wire, Failure> {
        let pty = Pty::open().map_err(failed)?;
        crate::say::result(format_args!("pty {}", pty.path.display()));
        Ok(Wire::Pty { pty, visited: false })
    }

    pub fn tcp(address: SocketAddr) -> Result<Wire, Failure> {
        let busy = |error: io::Error| {
            Failure::new(format!("can't listen on {address}: {error}"))
                .hint("another port, or 0 for a free one: --tcp 127.0.0.1:0")
        };
        let listener = TcpListener::bind(address).map_err(busy)?;
        listener.set_nonblocking(true).map_err(busy)?;
        crate::say::result(format_args!("tcp {}", listener.local_addr().map_err(busy)?));
        Ok(Wire::Tcp { listener, sender: None })
    }

    /// Reads standard input on a separate thread, because a read can't have a time limit on every
    /// system.
    pub fn stdio() -> Wire {
        let (tell, input) = mpsc::sync_channel(16);
        thread::spawn(move || {
            let mut stdin = io::stdin().lock();
            let mut buffer = [0; 1024];
            loop {
                match stdin.read(&mut buffer) {
                    Ok(0) => return,
                    Ok(count) => {
                        if tell.send(buffer[..count].to_vec()).is_err() {
                            return;
                        }
                    }
                    Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
                    Err(_) => return,
                }
            }
        });
        Wire::Stdio { input }
    }

    /// Waits for bytes for at most this long. If `full`, reads none.
    pub fn hear(&mut self, most: Duration, full: bool) -> Result<Heard, Failure> {
        match self {
            _ if full => {
                thread::sleep(most);
                Ok(Heard::default())
            }
            #[cfg(unix)]
            Wire::Pty { pty, visited } => {
                let seen = pty.wait(false, most).map_err(failed)?;
                let came = !seen.nobody && !*visited;
                *visited = !seen.nobody;
                if seen.nobody {
                    thread::sleep(most);
                }
                Ok(Heard { bytes: seen.bytes, came, nobody: seen.nobody, ended: false })
            }
            Wire::Tcp { listener, sender } => Ok(hear_tcp(listener, sender, most)),
            Wire::Stdio { input } => Ok(match input.recv_timeout(most) {
                Ok(bytes) => Heard { bytes, ..Heard::default() },
                Err(RecvTimeoutError::Timeout) => Heard::default(),
                Err(RecvTimeoutError::Disconnected) => Heard { ended: true, ..Heard::default() },
            }),
        }
    }

    /// Sends as many bytes as the line takes now.
    pub fn say(&mut self, bytes: &[u8]) -> Result<usize, Failure> {
        if bytes.is_empty() {
            return Ok(0);
        }
        match self {
            #[cfg(unix)]
            Wire::Pty { pty, .. } => pty.write(bytes).map_err(failed),
            Wire::Tcp { sender, .. } => Ok(match sender {
                // The next read shows whether the sender has disconnected.
                Some(stream) => stream.write(bytes).unwrap_or(0),
                None => bytes.len(),
            }),
            Wire::Stdio { .. } => {
                let mut out = io::stdout().lock();
                let written = out.write_all(bytes).and_then(|()| out.flush());
                let lost = |error| {
                    Failure::new(format!("can't write answers to standard output: {error}"))
                };
                written.map(|()| bytes.len()).map_err(lost)
            }
        }
    }
}

/// Serves one sender at a time. A second one waits until the first disconnects.
fn hear_tcp(listener: &TcpListener, sender: &mut Option<TcpStream>, most: Duration) -> Heard {
    let mut heard = Heard::default();
    if sender.is_none()
        && let Ok((stream, _)) = listener.accept()
    {
        // Without `TCP_NODELAY`, an answer may be delayed until the sender's next line.
        _ = stream.set_nodelay(true);
        if stream.set_nonblocking(true).is_ok() {
            (*sender, heard.came) = (Some(stream), true);
        }
    }
    let mut buffer = [0; 1024];
    match sender.as_mut().map(|stream| stream.read(&mut buffer)) {
        Some(Ok(0)) | None => *sender = None,
        Some(Ok(count)) => heard.bytes = buffer[..count].to_vec(),
        Some(Err(error)) => match error.kind() {
            io::ErrorKind::WouldBlock | io::ErrorKind::Interrupted => {}
            _ => *sender = None,
        },
    }
    heard.nobody = sender.is_none();
    if heard.bytes.is_empty() && !heard.came {
        thread::sleep(most);
    }
    heard
}
