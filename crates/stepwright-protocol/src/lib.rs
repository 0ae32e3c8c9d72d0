#![no_std]
#![forbid(unsafe_code)]
//! The serial line, both sides.

mod axis;
mod command;
mod line;
mod machine;
mod master;
mod number;
mod order;
mod reply;
mod script;
mod slave;
mod text;

pub use axis::{AxisId, MAX_AXES, Selection};
pub use command::{BadLine, Command};
pub use machine::{Machine, Refusal};
pub use master::{Master, Waiting};
pub use number::{Direction, Distance, RampSteps, StartSpeed, Tens, TopSpeed, Whole, WholeAccel};
pub use order::{Order, Ramp, Travel};
pub use reply::{Info, Reply, VERSION};
pub use script::Script;
pub use slave::Slave;
pub use text::Bytes;
