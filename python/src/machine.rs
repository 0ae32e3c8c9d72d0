//! The virtual board with limit switches on its machine.

use stepwright_host::link::simulated::Simulated;
use stepwright_sim::{AXES, Description, Edge, Queues, Recorder, Shaft, Switch, VirtualBoard};

use crate::edges::Edges;

/// Between two looks at the switches, in µs.
const LOOK: u32 = 100;

/// The shafts of the motors, and the edges that move them.
struct Shafts([Shaft; AXES], Edges);

impl Recorder for Shafts {
    fn edge(&mut self, edge: Edge) {
        if let Some(shaft) = self.0.get_mut(usize::from(edge.axis)) {
            shaft.follow(edge);
        }
        self.1.edge(edge);
    }
}

/// A virtual Uno on a machine.
pub struct Machine {
    board: VirtualBoard<'static, u16, Shafts>,
    description: Description,
    switches: Vec<Switch>,
    edges: Edges,
}

impl Machine {
    /// The edges of its pins, while they are recorded.
    pub fn edges(&self) -> Edges {
        self.edges.clone()
    }

    /// Switches one on. What it needs for its queues stays allocated.
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
            board: VirtualBoard::new(queues, description, Shafts(shafts, edges.clone())),
            description,
            switches,
            edges,
        }
    }

    fn set_switches(&mut self) {
        for switch in &self.switches {
            let axis = switch.axis.index();
            let shaft = self.board.recorder().0.get(axis).map_or(0, Shaft::position);
            // To ground, and the pin is pulled up.
            self.board.set_switch(axis as u8, !switch.is_closed(shaft));
        }
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
        self.board.now()
    }

    fn run_until(&mut self, time: u64) {
        if !self.switches.is_empty() {
            let look = u64::from(self.description.board.rate.micros(LOOK));
            while self.board.now().saturating_add(look) < time {
                self.board.run_until(self.board.now() + look);
                self.set_switches();
            }
        }
        self.board.run_until(time);
        self.set_switches();
        self.edges.pass(self.board.now());
    }

    fn receive(&mut self, byte: u8) {
        self.board.receive(byte);
    }

    fn take_answers(&mut self) -> Vec<u8> {
        self.board.take_answers()
    }
}
