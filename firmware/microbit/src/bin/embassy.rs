//! Embassy: moves that are awaited, joined and raced.
#![no_std]
#![no_main]

use embassy_executor::Spawner;
use embassy_futures::{join::join, select::select};
use nrf51_pac::interrupt;
use stepwright::Axis;
use stepwright_embassy::{Motors, News};
use stepwright_microbit::{BOARD, Engine, say, start};

static ENGINE: Engine = Engine::empty();
static NEWS: News = News::new();

#[interrupt]
fn TIMER0() {
    // SAFETY: this is the step interrupt.
    if unsafe { ENGINE.on_compare() } {
        NEWS.tell();
    }
}

#[embassy_executor::main]
async fn main(_spawner: Spawner) {
    // SAFETY: once.
    let (timer, pins) = unsafe { start() };
    let (engine, feeds) = ENGINE.fill(timer, pins, &BOARD).unwrap();
    let motors = Motors::new(engine, feeds, BOARD, &NEWS);
    let moves = async {
        let (mut x, mut y) = (motors.axis(Axis::X), motors.axis(Axis::Y));
        _ = x.move_to(400).await.unwrap();
        assert!(matches!(join(x.move_to(100), y.move_by(-200)).await, (Ok(_), Ok(_))));
        assert!(select(x.run(500), y.move_to(0)).await.is_second()); // X is dropped, and brakes
        say!("{:?} {:?} late {}", x.rest().await, y.position(), motors.late());
    };
    select(motors.plan(), moves).await;
}
