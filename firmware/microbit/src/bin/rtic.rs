//! RTIC 2: the program owns the step interrupt, and a task awaits moves.
#![no_std]
#![no_main]

#[rtic::app(device = nrf51_pac, dispatchers = [SWI0])]
mod app {
    use embassy_futures::{join::join, select::select};
    use stepwright::Axis;
    use stepwright_embassy::{Motors, News};
    use stepwright_microbit::{BOARD, Engine, Handle, say, start};

    static ENGINE: Engine = Engine::empty();
    static NEWS: News = News::new();

    #[shared]
    struct Shared {}

    #[local]
    struct Local {
        motors: Motors<'static, Handle, 3>,
    }

    #[init]
    fn init(_: init::Context) -> (Shared, Local) {
        // SAFETY: once.
        let (timer, pins) = unsafe { start() };
        let (engine, feeds) = ENGINE.fill(timer, pins, &BOARD).unwrap();
        moves::spawn().unwrap();
        (Shared {}, Local { motors: Motors::new(engine, feeds, BOARD, &NEWS) })
    }

    #[task(binds = TIMER0, priority = 2)]
    fn step(_: step::Context) {
        // SAFETY: this is the step interrupt.
        if unsafe { ENGINE.on_compare() } {
            NEWS.tell();
        }
    }

    #[task(local = [motors], priority = 1)]
    async fn moves(cx: moves::Context) {
        let motors = cx.local.motors;
        let moves = async {
            let (mut x, mut y) = (motors.axis(Axis::X), motors.axis(Axis::Y));
            assert!(matches!(join(x.move_to(400), y.move_to(-200)).await, (Ok(_), Ok(_))));
            assert!(matches!(join(x.move_to(100), y.move_to(-50)).await, (Ok(_), Ok(_))));
            say!("{:?} {:?} late {}", x.position(), y.position(), motors.late());
        };
        select(motors.plan(), moves).await;
    }
}
