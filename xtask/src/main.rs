//! The project's chores: `cargo xtask <chore>`.
//!
//! Each chore is a file. To add one, write `src/<chore>.rs` with a `#[derive(clap::Args)]` struct
//! and its `run(self, &Workspace)`, and name it in [`Chore`]. Shared files:
//!
//! | file | what |
//! | --- | --- |
//! | `workspace` | the paths of the checkout; running programs |
//! | `setup` | the programs that the machine must have, and their installation |
//! | `toolchain` | the compiler that builds for small chips |
//! | `digest` | whether a build is up to date with its sources |
//! | `listing` | a firmware's symbols and instructions |
//! | `program` | the programs of the AVR firmware |
//! | `outside` | a firmware outside the repository |
//! | `rig` | the firmware on a simulated chip |
//! | `qemu` | QEMU, and the firmware for chips of 32 bits |
//! | `python` | Python environments with packages |
//! | `node` | a Node with packages: avr8js, Playwright, CNCjs |

mod bench;
mod book;
mod check;
mod digest;
mod elf;
mod firmware;
mod flash;
mod image;
mod listing;
mod node;
mod outside;
mod page;
mod processor;
mod program;
mod python;
mod qemu;
mod rig;
mod rs274;
mod senders;
mod setup;
mod shrink;
mod silence;
mod sim;
mod small;
mod stress;
mod test;
mod ticks;
mod toolchain;
mod wasm;
mod workspace;

use anyhow::Result;
use clap::{Parser, Subcommand};
use workspace::Workspace;

/// Stepwright's chores.
#[derive(Parser)]
#[command(name = "cargo xtask", bin_name = "cargo xtask")]
struct Cli {
    #[command(subcommand)]
    chore: Chore,
}

#[derive(Subcommand)]
enum Chore {
    Bench(bench::Bench),
    Book(book::Book),
    Check(check::Check),
    Firmware(firmware::Firmware),
    Flash(flash::Flash),
    Image(image::Image),
    Page(page::Page),
    Rs274(rs274::Rs274),
    Senders(senders::Senders),
    Setup(setup::Setup),
    Silence(silence::Silence),
    Sim(sim::Sim),
    Stress(stress::Stress),
    Test(test::Test),
    Ticks(ticks::Ticks),
    Wasm(wasm::Wasm),
}

fn main() -> Result<()> {
    let ws = Workspace::load;
    match Cli::parse().chore {
        Chore::Bench(bench) => bench.run(&ws()?),
        Chore::Book(book) => book.run(&ws()?),
        Chore::Check(check) => check.run(),
        Chore::Firmware(firmware) => firmware.run(&ws()?),
        Chore::Flash(flash) => flash.run(&ws()?),
        Chore::Image(image) => image.run(&ws()?),
        Chore::Page(page) => page.run(&ws()?),
        Chore::Rs274(rs274) => rs274.run(&ws()?),
        Chore::Senders(senders) => senders.run(&ws()?),
        Chore::Setup(setup) => setup.run(&ws()?),
        Chore::Silence(silence) => silence.run(&ws()?),
        Chore::Sim(sim) => sim.run(&ws()?),
        Chore::Stress(stress) => stress.run(&ws()?),
        Chore::Test(test) => test.run(&ws()?),
        Chore::Ticks(ticks) => ticks.run(&ws()?),
        Chore::Wasm(wasm) => wasm.run(&ws()?),
    }
}
