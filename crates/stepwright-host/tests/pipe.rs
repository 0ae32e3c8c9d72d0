//! The conversation without I/O: a board of the test's own, fed byte by byte.

use std::pin::pin;
use std::task::{Context, Poll, Waker};
use std::time::Duration;

use stepwright_host::{Conversation, LinkError, Pipe};
use stepwright_protocol::{AxisId, Command, Reply};

fn poll<T>(part: std::pin::Pin<&mut impl Future<Output = T>>) -> Poll<T> {
    part.poll(&mut Context::from_waker(Waker::noop()))
}

const fn ms(ms: u64) -> Duration {
    Duration::from_millis(ms)
}

#[test]
fn bytes_and_time_go_in_bytes_and_a_deadline_come_out() {
    let pipe = Pipe::new();
    let mut talk = Conversation::new(pipe.clone());
    let mut asked = pin!(talk.once(Command::Position(AxisId::FIRST)));
    assert!(poll(asked.as_mut()).is_pending());
    assert_eq!(pipe.take_output(), b"V1\r");
    assert_eq!(pipe.deadline(), Some(ms(500)));
    // Half of it, and a byte at a time.
    for byte in b"-12" {
        pipe.feed(&[*byte]);
        assert!(poll(asked.as_mut()).is_pending());
    }
    pipe.pass(ms(499));
    assert!(poll(asked.as_mut()).is_pending());
    pipe.feed(b"3\r");
    let Poll::Ready(answer) = poll(asked.as_mut()) else { panic!() };
    assert_eq!(answer.unwrap(), Some(Reply::Position(-123)));
    assert_eq!(pipe.deadline(), None);
}

#[test]
fn silence_ends_at_the_deadline_and_a_lost_line_at_once() {
    let pipe = Pipe::new();
    let mut talk = Conversation::new(pipe.clone());
    {
        let mut asked = pin!(talk.once(Command::Status));
        assert!(poll(asked.as_mut()).is_pending());
        pipe.pass(ms(500));
        assert!(matches!(poll(asked), Poll::Ready(Ok(None))));
    }
    let mut asked = pin!(talk.once(Command::Status));
    assert!(poll(asked.as_mut()).is_pending());
    pipe.lose(std::io::ErrorKind::UnexpectedEof.into());
    assert!(matches!(poll(asked), Poll::Ready(Err(LinkError::Gone(_)))));
}

/// A clock that is asked twice may go back: the pipe's does not.
#[test]
fn time_never_goes_back() {
    let pipe = Pipe::new();
    let mut talk = Conversation::new(pipe.clone());
    pipe.pass(ms(900));
    pipe.pass(ms(100));
    let mut asked = pin!(talk.once(Command::Status));
    assert!(poll(asked.as_mut()).is_pending());
    assert_eq!(pipe.deadline(), Some(ms(1_400)));
}

/// A future may be dropped anywhere: what is said next is understood.
#[test]
fn a_dropped_question_is_forgotten() {
    let pipe = Pipe::new();
    let mut talk = Conversation::new(pipe.clone());
    {
        let mut asked = pin!(talk.once(Command::Status));
        assert!(poll(asked.as_mut()).is_pending());
    }
    let mut asked = pin!(talk.once(Command::Position(AxisId::FIRST)));
    assert!(poll(asked.as_mut()).is_pending());
    // The answer to the first is none to the second.
    pipe.feed(b"R\r77\r");
    assert!(matches!(poll(asked), Poll::Ready(Ok(Some(Reply::Position(77))))));
}
