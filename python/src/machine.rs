//! The virtual board with limit switches on its machine.

use stepwright_host::link::simulated::Simulated;
use stepwright_sim::{
    AXES, Description, Edge, Queues, Recorder, Shaft, Switch, Switched, VirtualBoard, run_switched,
};

use crate::edges::Edges;

/// The shafts of the motors, and the recorder of the edges that move them.
struct Shafts([Shaft; AXES], Edges);

impl Recorder for Shafts {
    fn edge(&mut self, edge: Edge) {
        if let Some(shaft) = self.0.get_mut(usize::from(edge.axis)) {
            shaft.follow(edge);
        }
        self.1.edge(edge);
    }
}

/// The board, and the shafts that its edges move.
struct Board(VirtualBoard<'static, u16, Shafts>);

/// A virtual Uno with a machine.
pub struct Machine {
    board: Board,
    description: Description,
    switches: Vec<Switch>,
    edges: Edges,
}

impl Machine {
    /// The edges of the pins, while they are recorded.
    pub fn edges(&self) -> Edges {
        self.edges.clone()
    }

    /// Switches a machine on. The memory of its queues is never freed.
    pub fn new(switches: Vec<Switch>) -> Machine {
        let queues = Box::leak(Box::<Queues>::default());
        let description = Description::uno();
        let edges = Edges::new(&description);
        let mut axis = 0;
        let shafts = [(); AXES].map(|()| {
            axis += 1;
            Shaft::of(&description, axis - 1)
        });
        Machine {
            board: Board(VirtualBoard::new(queues, description, Shafts(shafts, edges.clone()))),
            description,
            switches,
            edges,
        }
    }
}

impl Switched for Board {
    fn now(&self) -> u64 {
        self.0.now()
    }

    fn run_until(&mut self, time: u64) {
        self.0.run_until(time);
    }

    fn shaft(&mut self, axis: u8) -> i64 {
        self.0.recorder().0.get(usize::from(axis)).map_or(0, Shaft::position)
    }

    fn set_switch(&mut self, axis: u8, high: bool) {
        self.0.set_switch(axis, high);
    }
}

impl Simulated for Machine {
    fn hz(&self) -> u32 {
        self.description.board.rate.hz()
    }

    fn byte_time(&self) -> u64 {
        self.description.byte_time()
    }

    fn now(&self) -> u64 {
        self.board.0.now()
    }

    fn run_until(&mut self, time: u64) {
        run_switched(&mut self.board, &self.switches, self.description.board.rate, time);
        self.edges.pass(self.board.0.now());
    }

    fn receive(&mut self, byte: u8) {
        self.board.0.receive(byte);
    }

    fn take_answers(&mut self) -> Vec<u8> {
        self.board.0.take_answers()
    }
}
