//! A board behind a plain socket, as `ser2net` provides for a serial port: from a thread that blocks, and from
//! tokio.

use std::io::{ErrorKind, Read, Write};
use std::net::{TcpListener, TcpStream};
use std::thread;
use std::time::Duration;

use stepwright::{Accel, Speed};
use stepwright_host::link::Link;
use stepwright_host::link::simulated::{VirtualLink, VirtualUno};
use stepwright_host::motion::Action;
use stepwright_host::{AsyncBoard, Board, Error, LinkError, MotionLimits, Outcome};
use stepwright_protocol::Stop;

/// The address at which a virtual board listens, for one connection; the socket carries bytes and nothing else.
fn served() -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || {
        let (socket, _) = listener.accept().unwrap();
        carry(socket, VirtualLink::new(VirtualUno::new(), false));
    });
    address
}

/// Carries bytes until the other end is gone.
fn carry(mut socket: TcpStream, mut link: VirtualLink<VirtualUno>) -> Option<()> {
    socket.set_read_timeout(Some(Duration::from_millis(1))).unwrap();
    let mut bytes = [0; 64];
    loop {
        match socket.read(&mut bytes) {
            Ok(0) => return None,
            Ok(count) => link.write(&bytes[..count]).ok()?,
            Err(error) if matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut) => {}
            Err(_) => return None,
        }
        let count = link.read(&mut bytes, Duration::from_millis(1)).ok()?;
        socket.write_all(&bytes[..count]).ok()?;
    }
}

fn motion() -> MotionLimits {
    MotionLimits::new(Speed::from_steps(4_000).unwrap(), Accel::from_steps(20_000).unwrap())
}

#[test]
fn a_board_behind_a_socket_goes_where_it_is_sent() {
    let mut board = Board::open(format!("tcp://{}", served())).unwrap();
    let mut x = board.axis(1).unwrap();
    assert_eq!(x.move_to(800, &motion()).unwrap(), Outcome::Reached { at: 800 });
    assert_eq!(x.position().unwrap(), Some(800));
}

#[test]
fn a_socket_where_nobody_listens_is_no_board() {
    let free = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let refused = Board::open(format!("tcp://{free}")).err().unwrap();
    assert!(matches!(refused, Error::Open(_)), "{refused}");
    assert!(Board::open("tcp://nowhere").is_err());
}

fn tokio<T>(part: impl Future<Output = T>) -> T {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().unwrap();
    runtime.block_on(part)
}

#[test]
fn the_same_calls_are_futures() {
    let address = served();
    tokio(async {
        let mut board = AsyncBoard::connect(address).await.unwrap();
        let mut x = board.axis(1).unwrap();
        assert_eq!(x.move_to(800, &motion()).await.unwrap(), Outcome::Reached { at: 800 });
        assert!(matches!(board.axis(4), Err(Error::NoAxis { axes: 3 })));
        // One task begins a travel, watches it and stops it.
        let mut y = board.axis(2).unwrap();
        y.travel(1_000_000, &motion()).await.unwrap();
        let mut looks = 0;
        let stop = |_: &_| {
            looks += 1;
            if looks > 3 { Action::Stop } else { Action::GoOn }
        };
        let outcome = y.wait(stop).await.unwrap();
        let Outcome::Stopped { at, reason: Some(Stop::Soft) } = outcome else {
            panic!("{outcome}")
        };
        assert_eq!(y.position().await.unwrap(), Some(at));
    });
}

/// A future may be dropped: the motor goes on, and the next call works.
#[test]
fn a_wait_that_is_given_up_leaves_the_motor_on_its_way() {
    let address = served();
    tokio(async {
        let mut board = AsyncBoard::connect(address).await.unwrap();
        let mut x = board.axis(1).unwrap();
        let slow = MotionLimits { top: Speed::from_steps(500).unwrap(), ..motion() };
        let waited = Duration::from_millis(300);
        x.travel(5_000, &slow).await.unwrap();
        let moved = tokio::time::timeout(waited, x.wait(|_| Action::GoOn)).await;
        assert!(moved.is_err(), "it takes 10 s");
        assert!(matches!(x.travel(1, &slow).await, Err(Error::Moving)));
        board.stop().await.unwrap();
        let at = board.axis(1).unwrap().position().await.unwrap().unwrap();
        assert!((1..5_000).contains(&at), "{at}");
    });
}

#[test]
fn a_board_that_goes_is_lost() {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = listener.local_addr().unwrap().to_string();
    thread::spawn(move || drop(listener.accept().unwrap()));
    tokio(async {
        let lost = AsyncBoard::connect(address).await.err().unwrap();
        let gone = |error: &Error| {
            matches!(error, Error::Lost { trouble: LinkError::Gone(_), moving: false })
        };
        assert!(gone(&lost), "{lost}");
    });
}

/// A board whose buffer is full and stays so.
#[test]
fn a_board_that_takes_no_byte_is_silent() {
    tokio(async {
        let (stream, _board) = tokio::io::duplex(1);
        let met = tokio::time::timeout(Duration::from_secs(20), AsyncBoard::on(stream)).await;
        let lost = met.expect("it ends").err().unwrap();
        let silent = matches!(lost, Error::Lost { trouble: LinkError::Silent, moving: false });
        assert!(silent, "{lost}");
    });
}
