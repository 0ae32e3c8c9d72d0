//! The conversation without I/O, with the test as the board, which feeds single bytes.

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
    // Half of the answer, one byte at a time.
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

/// The time of a pipe does not go back, even if the clock does.
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

/// A future may be dropped at any time: the answer to the next line is still recognized.
#[test]
fn a_dropped_question_is_forgotten() {
    let pipe = Pipe::new();
    let mut talk = Conversation::new(pipe.clone());
    {
        let mut asked = pin!(talk.once(Command::Status));
        assert!(poll(asked.as_mut()).is_pending());
    }
    assert_eq!(pipe.take_output(), b"F\r");
    let mut asked = pin!(talk.once(Command::Status));
    assert!(poll(asked.as_mut()).is_pending());
    assert_eq!(pipe.take_output(), b"#\rF\r");
    // The answer to the first line belongs neither to that F nor to the second line.
    pipe.feed(b"R\rE\r");
    assert!(poll(asked.as_mut()).is_pending());
    assert_eq!(pipe.take_output(), b"");
    pipe.feed(b"R\r");
    assert!(poll(asked.as_mut()).is_pending());
    assert_eq!(pipe.take_output(), b"F\r");
    pipe.feed(b"B\r");
    assert!(matches!(poll(asked), Poll::Ready(Ok(Some(Reply::Busy)))));
}

/// The position of one axis is not taken for that of another.
#[test]
fn the_answer_to_a_dropped_question_is_none_to_the_next() {
    let pipe = Pipe::new();
    let mut talk = Conversation::new(pipe.clone());
    let axis = |number| AxisId::numbered(number).unwrap();
    {
        let mut asked = pin!(talk.position(axis(1)));
        assert!(poll(asked.as_mut()).is_pending());
    }
    let mut asked = pin!(talk.position(axis(2)));
    assert!(poll(asked.as_mut()).is_pending());
    pipe.feed(b"800\rE\rR\r");
    assert!(poll(asked.as_mut()).is_pending());
    pipe.feed(b"-5\r");
    assert!(matches!(poll(asked), Poll::Ready(Ok(Some(-5)))));
}

/// Only half of a dropped line may have been sent, so no answer to it is waited for.
#[test]
fn half_a_line_is_not_waited_for() {
    let pipe = Pipe::new();
    let mut talk = Conversation::new(pipe.clone());
    {
        let mut asked = pin!(talk.once(Command::Status));
        assert!(poll(asked.as_mut()).is_pending());
    }
    let mut asked = pin!(talk.once(Command::Position(AxisId::FIRST)));
    assert!(poll(asked.as_mut()).is_pending());
    pipe.feed(b"E\rR\r");
    assert!(poll(asked.as_mut()).is_pending());
    pipe.take_output();
    pipe.pass(ms(500));
    assert!(poll(asked.as_mut()).is_pending());
    assert_eq!(pipe.take_output(), b"V1\r");
}

/// A kill does not first get in step: K is sent at once, and again for its answer.
#[test]
fn a_kill_after_a_dropped_question_goes_out_at_once() {
    let pipe = Pipe::new();
    let mut talk = Conversation::new(pipe.clone());
    {
        let mut asked = pin!(talk.once(Command::Zero(AxisId::FIRST)));
        assert!(poll(asked.as_mut()).is_pending());
        pipe.take_output();
    }
    let mut killed = pin!(talk.kill());
    assert!(poll(killed.as_mut()).is_pending());
    assert_eq!(pipe.take_output(), b"#\rK\r#\rF\r");
    // The Y of the dropped line is not taken for that of K.
    pipe.feed(b"Y\rE\r");
    assert!(poll(killed.as_mut()).is_pending());
    pipe.feed(b"Y\rE\rR\r");
    assert!(poll(killed.as_mut()).is_pending());
    assert_eq!(pipe.take_output(), b"K\r");
    pipe.feed(b"Y\r");
    assert!(matches!(poll(killed), Poll::Ready(Ok(true))));
}
