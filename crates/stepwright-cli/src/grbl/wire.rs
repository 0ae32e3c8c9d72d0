//! The line to a sender: a pseudo-terminal, a TCP socket, standard input and output.

use std::io::{self, Read, Write};
use std::net::{SocketAddr, TcpListener, TcpStream};
use std::sync::mpsc::{Receiver, RecvTimeoutError};
use std::thread;
use std::time::{Duration, Instant};

use crate::failure::Failure;
use crate::files;
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
        sender: Option<Peer>,
    },
    Stdio {
        input: Receiver<io::Result<Vec<u8>>>,
    },
}

/// A sender that has said nothing for this long may be replaced by another one.
const SILENT: Duration = Duration::from_secs(10);

/// A sender at the end of a TCP connection.
pub struct Peer {
    stream: TcpStream,
    /// Its first bytes, until it is known whether they begin a request of a web browser.
    head: Option<Vec<u8>>,
    /// When it has last said something.
    heard: Instant,
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

    pub fn stdio() -> Wire {
        Wire::Stdio { input: files::standard_input() }
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
                Ok(bytes) => Heard { bytes: bytes.unwrap_or_default(), ..Heard::default() },
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
                Some(peer) => peer.stream.write(bytes).unwrap_or(0),
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

/// Serves one sender at a time. A second one waits until the first disconnects, or has said nothing for some
/// time: a computer that sleeps does not disconnect.
fn hear_tcp(listener: &TcpListener, sender: &mut Option<Peer>, most: Duration) -> Heard {
    let mut heard = Heard::default();
    if sender.as_ref().is_none_or(|peer| peer.heard.elapsed() > SILENT)
        && let Ok((stream, _)) = listener.accept()
    {
        // Without `TCP_NODELAY`, an answer may be delayed until the sender's next line.
        _ = stream.set_nodelay(true);
        if stream.set_nonblocking(true).is_ok() {
            *sender = Some(Peer { stream, head: Some(Vec::new()), heard: Instant::now() });
            heard.came = true;
        }
    }
    let mut buffer = [0; 1024];
    let read = sender.as_mut().map(|peer| (peer.stream.read(&mut buffer), peer));
    match read {
        Some((Ok(0), _)) | None => *sender = None,
        Some((Ok(count), peer)) => {
            peer.heard = Instant::now();
            heard.bytes = buffer[..count].to_vec();
            if let Some(mut head) = peer.head.take() {
                head.append(&mut heard.bytes);
                match is_http(&head) {
                    Some(false) => heard.bytes = head,
                    Some(true) => *sender = None,
                    None => peer.head = Some(head),
                }
            }
        }
        Some((Err(error), _)) => match error.kind() {
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

/// Whether a connection begins with a request of a web browser, whose body any page can choose: `POST `, `GET `.
/// `None` if it is too early to say. No line of a sender begins with three letters and a blank.
fn is_http(head: &[u8]) -> Option<bool> {
    let letters = head.iter().take_while(|byte| byte.is_ascii_uppercase()).count();
    match head.get(letters) {
        None if letters < 8 => None,
        next => Some(letters >= 3 && next == Some(&b' ')),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn listener() -> (TcpListener, SocketAddr) {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        listener.set_nonblocking(true).unwrap();
        let address = listener.local_addr().unwrap();
        (listener, address)
    }

    /// What is heard within a while, until there are as many bytes.
    fn hear(listener: &TcpListener, sender: &mut Option<Peer>, count: usize) -> Vec<u8> {
        let (mut bytes, end) = (Vec::new(), Instant::now() + Duration::from_secs(9));
        while bytes.len() < count && Instant::now() < end {
            bytes.extend(hear_tcp(listener, sender, Duration::from_millis(1)).bytes);
            if sender.is_none() {
                break;
            }
        }
        bytes
    }

    #[test]
    fn a_web_page_is_no_sender() {
        for (text, count) in [
            ("$J=G91X5F3000\n", 14),
            ("M3 S100\n", 8),
            ("?", 1),
            ("POST / HTTP/1.1\r\nHost: x\r\n\r\n$J=G91X5F3000\n", 0),
            ("GET / HTTP/1.1\r\n\r\n$X\n", 0),
            ("OPTIONS * HTTP/1.1\r\n$X\n", 0),
        ] {
            for first in [1, text.len()] {
                let (listener, address) = listener();
                let (mut sender, mut stream) = (None, TcpStream::connect(address).unwrap());
                hear(&listener, &mut sender, 0);
                stream.write_all(&text.as_bytes()[..first]).unwrap();
                let mut heard = hear_tcp(&listener, &mut sender, Duration::from_millis(20)).bytes;
                stream.write_all(&text.as_bytes()[first..]).unwrap();
                heard.extend(hear(&listener, &mut sender, count.max(1) - heard.len()));
                assert_eq!(heard, &text.as_bytes()[..count], "{text}");
                assert_eq!(sender.is_some(), count > 0, "{text}");
            }
        }
    }

    #[test]
    fn a_silent_sender_is_replaced() {
        let (listener, address) = listener();
        let (mut sender, _first) = (None, TcpStream::connect(address).unwrap());
        assert!(hear_tcp(&listener, &mut sender, SILENT).came);
        let mut second = TcpStream::connect(address).unwrap();
        second.write_all(b"?").unwrap();
        for _ in 0..20 {
            assert_eq!(hear_tcp(&listener, &mut sender, Duration::from_millis(5)).bytes, b"");
        }
        let long_ago = Instant::now().checked_sub(2 * SILENT).unwrap();
        sender.as_mut().unwrap().heard = long_ago;
        assert_eq!(hear(&listener, &mut sender, 1), b"?");
    }
}
