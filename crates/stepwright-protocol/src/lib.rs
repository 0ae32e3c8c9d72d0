#![no_std]
#![deny(unsafe_code)] // // except in `flash`, on an AVR
#![cfg_attr(target_arch = "avr", feature(asm_experimental_arch))]
//! The serial line of a stepper controller, both sides.
//!
//! A master sends a line, the slave answers it, and the master sends the next. The Nano slave's
//! document defines the basic grammar; more axes and faster boards extend it without a change for a
//! master that was written for that document.
//!
//! Both halves are state machines over bytes. They do no I/O, hold no clock, allocate nothing and
//! don't panic, so the same slave runs on an ATmega328P, behind a pseudo-terminal and in a test,
//! and the same master in the command and on a second chip.
//!
//! ```text
//!  Script ─► Command ─► bytes ─────── the line ──────► bytes ─► Command ─► Slave ─► Machine
//!  Master ◄─ Reply   ◄─ bytes ◄────── the line ─────── bytes ◄─ Reply   ◄───┘
//! ```
//!
//! # The grammar
//!
//! A line is one of these forms and a CR; an LF before or after it is skipped. `±` stands for a `+`
//! or a `-`, which is required. Leading zeros are allowed, spaces are not. On a board that can
//! `sum`, a line may end with its checksum, `*` and two hexadecimal digits. Axis numbers begin at 1.
//! "Axis ready" means every axis that the line addresses. No line of text has a byte of 0x80 or
//! more: a line with such a byte is damaged, and refused. A first byte of 0x80 or more is reserved
//! for binary frames.
//!
#![doc = include_str!("grammar.md")]
//!
//! Every line has exactly one answer, which ends with a CR: `Y` for accepted, `E` for refused with
//! nothing changed, or the value that the line asks for. The controller's `E` stands alone, because
//! the masters of the Nano slave expect that. Another program adds the reason, a word and its
//! numbers if it has any: `E busy`, `E range 2,0,9` ([`Fault`]). Such a program answers `?` with
//! its name, the board's name, and words of which `axes`, `late` and `can` mean the same as for the
//! controller; implement [`BoardProgram`] for a program with rows of your own. The controller's
//! answer to `?` is
//!
//! ```text
//! stepwright 0.1 axes=3 max=120000 late=0 refused=0 last=none uncertain=0 stop=---
//!    … errors=- can=jerk,safety,sum closed=0                  (it is one line)
//! ```
//!
//! - the protocol's version;
//! - `axes`: the number of axes;
//! - `max`: the fastest rate at which the board can step one axis, in steps/s;
//! - `late`: steps that came late;
//! - `refused`: lines that were refused;
//! - `last`: the reason of the last refusal, one of the names of [`Refusal`];
//! - `uncertain`: the axes whose position is not known, as the sum of 1 for axis 1, 2 for axis 2, 4
//!   for axis 3, and so on;
//! - `stop`: why each axis has stopped before the end of its order, one letter of [`Stop`] per
//!   axis, `-` for an axis that went as ordered;
//! - `errors`, on a board that can `safety`: the letters of the [`BoardError`]s since the last `!`,
//!   or `-`;
//! - `can`: the [`Ability`]s of the board, or `none`;
//! - `closed`: the axes in the setting `switches` whose limit switch is closed now, as a sum like
//!   `uncertain`.
//!
//! The firmware of a board whose answer has no `can` or no `closed` is older than that word.
//!
//! The answer to `$` is all [`Setting`]s of the board with their numbers; the answer to `$` and a
//! name is that setting alone:
//!
//! ```text
//! max-speed=1000000 max-accel=100000000 idle-ms=0 ahead-x=0 ahead-y=0 ahead-z=0
//!    … behind-x=0 behind-y=0 behind-z=0 timeout-ms=0 enable-ms=1
//!    … setup-us=1 hold-us=1 pulse-us=2 reverse=0 enable-high=0 switches=0
//!    … switch-forward=0 switch-high=0 debounce-ms=25 law=1 safe-start=0 home-first=0
//!    … estop=0 driver-fault=0 kill-off=0 soft-limits=0                        (it is one line)
//! ```
//!
//! # A conversation
//!
//! ```
//! use core::task::Poll;
//! use stepwright_protocol::*;
//!
//! /// A machine with one axis that reaches every target at once.
//! #[derive(Default)]
//! struct Teleporter {
//!     here: i64,
//!     ahead: i64,
//! }
//!
//! impl Machine for Teleporter {
//!     fn axes(&self) -> u8 { 1 }
//!     fn busy(&self, _: AxisId) -> bool { false }
//!     fn prepare(&mut self, _: AxisId, order: &stepwright::Order) -> Result<(), Refusal> {
//!         match order.travel {
//!             stepwright::Travel::By(steps) => self.ahead = i64::from(steps),
//!             stepwright::Travel::Endless(_) => return Err(Refusal::Travel),
//!         }
//!         Ok(())
//!     }
//!     fn commit(&mut self) -> Poll<Result<(), Refusal>> {
//!         self.here += self.ahead;
//!         Poll::Ready(Ok(()))
//!     }
//!     fn cancel(&mut self) {}
//!     fn stop(&mut self, _: AxisId) {}
//!     fn kill(&mut self) {}
//!     fn position(&self, _: AxisId) -> Option<i64> { Some(self.here) }
//!     fn zero(&mut self, _: AxisId) { self.here = 0 }
//!     fn max_rate(&self) -> u32 { 120_000 }
//!     fn late(&self) -> u32 { 0 }
//!     fn clear_late(&mut self) {}
//! }
//!
//! let mut slave = Slave::<1>::new();
//! let mut machine = Teleporter::default();
//! let mut answers = Vec::new();
//! for byte in *b"PO\rS5\rT100\rR200\rG+4000\rE\rF\rV1\rT1000\rg-\r" {
//!     if let Some(reply) = slave.push(byte, &mut machine) {
//!         answers.extend(reply.bytes());
//!     }
//! }
//! assert_eq!(answers, b"Y\rY\rY\rY\rY\rY\rR\r4000\rE\rE\r");
//! ```
//!
//! # Open questions of the Nano slave's document
//!
//! | open question | decided |
//! | --- | --- |
//! | `PO` or `P0`? | both |
//! | speeds of 0, ramps of 0, numbers out of range | E: a clear refusal rather than the Nano slave's "no checking" |
//! | `G5`, `G+`, `G+-5`, `S 5`, `po`, an empty line, 25 bytes, binary | E at the CR, and the next line starts clean |
//! | what is taken while busy? | F, V, Z, K, A, `@`, t, a, d, `?`, `!`, `$`, `$` and a name. No setting can be changed while any axis is busy. Every other line that addresses a busy axis is answered E |
//! | t, a, d while busy | they take effect at once, on the travel in progress and on later ones; E in an open order, because an order is for axes at rest. S, T, R and s are answered E: a travel keeps its start speed, and a ramp counted in steps can't begin on the way |
//! | t below the start speed while busy | E: the travel ends at its start speed |
//! | t while the ramps are counted in steps | the travel in progress keeps its acceleration; the next has R steps again |
//! | `@` from where? | from where the travel in progress began: `@+n` on the way sets the target that `G+n` would have set; an endless `g` then ends there |
//! | `@` behind, or nearer than the ramp down is long | Y: the axis brakes to rest, turns and comes back; it is busy all the while |
//! | `@` after Z | the axis travels on to the new target |
//! | `@` at rest, `@` beyond 2³¹ steps of a g | E, with the reasons `no-travel` and `travel`; an axis whose travel has just ended is at rest, so G is the line to send then |
//! | `@`, t, a, d with A0 | all or none: E if any of the axes can't. `@` requires all of them to travel; with t, a and d the axes at rest keep the number for later |
//! | `stop` | a letter is kept until the axis starts again, a new target (`@`) is accepted or `!` comes. Z and the time-out keep the letter of a soft stop that has begun; a stop at once replaces it |
//! | `A2`, `PO` without an A after it | it is not clear which axis is meant: PO selects axis 1, as masters that know no A expect, and A named another axis that no order has used. S, T, R, s, t, a, d, j, G, g and `@` are answered E as `no-axis`, until an A names the axis; F and Z apply to both. Either guess would move the wrong motor for one kind of master. A second PO without an A comes from a master that knows no A: axis 1 |
//! | `safe-start` | with 1, while `errors` has one of S, T, K, E, D, R: g, `@` and the E of an order are answered E as `stopped`, until `!`. All other lines are taken: a stop, a question, I, a setting |
//! | `home-first` | with 1, while the position of an axis is not known: `@` and the E of an order with a G for it are answered E as `uncertain`. g is allowed, because homing uses it |
//! | soft limits, position known | G and `@` beyond: E as `limit`, at E of the order. g towards a limit becomes a travel that ends exactly there, and `stop` says L; E as `limit` where the axis is there already. d on the way is E as `limit`: a lower deceleration could carry the axis beyond |
//! | soft limits, position beyond ±2³¹ | every travel is E as `limit`, until I or homing: no limit is so far from 0 |
//! | soft limits, position not known | G and `@` are E as `uncertain`; g has no limit, because homing uses it |
//! | soft limits, g towards the axis's limit switch | no limit: this is homing, and the switch ends it |
//! | `errors` | the E of an order that a wrong checksum spoiled does not count as another wrong checksum |
//! | j on a board without S-curves | E as `no-jerk`; with `law` 0 so is the E of an order with a jerk |
//! | `PO` while busy | E if the *selected* axis is busy (with A0: any), so `A2`, `PO`, `A2` … starts axis 2 while axis 1 runs |
//! | S, T, R … outside PO | taken when the axis is idle: they set values and move nothing. The values are kept from order to order; at power-up they are S5 T100 R200 |
//! | R, a and d | R sets both ramps, a and d replace their own half, a later R both |
//! | G outside PO | E |
//! | g outside PO | starts at once; inside PO it waits for E |
//! | any line refused inside PO: noise, a number out of range, E without G or g, E that the machine refuses | spoils the order: its E is answered E, until the next PO. This holds for all lines: after a refusal the slave's order is not the order that the master means, and PO brings both back in step. Otherwise a mistyped top speed would start the order with the old one, and a G that comes late would start after its E was refused. Values that accepted lines set are kept |
//! | K inside PO | spoils the order as well: a g that is still under way must not start a motor after an emergency stop |
//! | Z inside PO | brakes the moving axes; the order stays open |
//! | PO inside PO | starts afresh: the travels are forgotten, the other values are kept |
//! | two travels for one axis | the later counts |
//! | `G+0` | Y, and ready at once |
//! | Z and K when idle | Y; the position stays known |
//! | V after K | E until I, for the axes that K stopped |
//! | F, Z with A0 | B if any is busy; all stop |
//! | what counts as refused? | every line answered E, except an empty one: masters send it to get in step |
//! | `last` after the E of a spoiled order | the reason of the line that spoiled it |
//!
//! # Checksums
//!
//! A digit that turns into another digit on the wire is still an order. Where that matters, and the
//! board can `sum`, a line ends with `*` and the CRC-8 of the bytes before it in two hexadecimal
//! digits (polynomial 0x07, initial value 0: CRC-8/SMBUS), and so does its answer: `G+4000*0B` is
//! answered `Y*88`. A line whose checksum is wrong or incomplete is answered E with a checksum; its
//! reason is `sum`, and it spoils an order as any other refused line does. A line without a `*` is
//! answered without a checksum, so a master chooses line by line. [`Master::use_sums`] does it for
//! every line.
//!
//! A flipped bit is always noticed. A lost `*` may leave a line without a checksum, as `G+4*25`
//! leaves `G+425`. The slave answers such a line without a checksum, so a master that uses
//! checksums accepts no answer, and sends no `E`. Of the lines that act at once, `@`, t, a, d and L
//! may have taken effect then.
//!
//! Report a byte that a receiver noticed as lost or damaged with [`Slave::garbled`].

mod answer;
mod axis;
mod can;
mod command;
mod controller;
mod crc;
mod errors;
mod flash;
mod grammar;
mod line;
mod machine;
mod master;
mod motion_params;
mod number;
mod order;
mod program;
mod raw_line;
mod reply;
mod script;
mod setting;
mod slave;
mod stop;
mod sum;
mod text;

pub use axis::{AxisId, MAX_AXES, Selection};
pub use can::{Abilities, Ability};
pub use command::{BadLine, Command};
pub use crc::crc;
pub use errors::{BoardError, Errors};
pub use flash::Text;
#[doc(hidden)] // `flash_text!` uses it
pub use flash::bytes as flash_bytes;
pub use grammar::Form;
pub use machine::{Machine, Refusal};
pub use master::{Master, Waiting};
pub use number::{
    Direction, Distance, LeaseMillis, MilliSpeed, RampSteps, StartSpeed, Tens, TopSpeed, Whole,
    WholeAccel, WholeJerk,
};
pub use order::{Order, Ramp, Travel};
pub use program::{
    BoardProgram, Fault, Incoming, Numbers, OwnFault, ProgramSlave, ROW, Said, read_row,
};
pub use reply::{Info, Reply, VERSION};
pub use script::Script;
pub use setting::Listed;
pub use setting::{Setting, Settings, Value};
pub use slave::Slave;
pub use stop::{Stop, Stops};
pub use text::{Bytes, Piece};
