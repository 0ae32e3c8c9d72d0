//! The boards: the name of each in QEMU, its description, and how its pins are observed. A new
//! board is a row here.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result, ensure};
use stepwright::Board;
use stepwright_mps2::board as mps2;
use stepwright_nrf51::board as nrf51;
use stepwright_virt::board as virt;

use crate::edges::View;

/// A board that QEMU simulates.
#[derive(Debug)]
pub struct Simulated {
    /// The folder of its programs in `firmware`.
    pub name: &'static str,
    /// The key of QEMU's arguments in its manifest.
    pub words: &'static str,
    /// The controller's description of the board.
    pub board: Board<3>,
    /// How its pins are observed.
    pub view: View,
}

/// BBC micro:bit.
pub static NRF51: Simulated =
    Simulated { name: "nrf51", words: "qemu", board: nrf51::BOARD, view: NRF51_VIEW };

const NRF51_VIEW: View = View::Traced { step: nrf51::STEP, dir: nrf51::DIR };

/// The same, with programs that have an executor, RTIC or their own main loop.
pub static MICROBIT: Simulated =
    Simulated { name: "microbit", words: "qemu", board: nrf51::BOARD, view: NRF51_VIEW };

/// QEMU's `virt`, RISC-V.
pub static VIRT: Simulated = Simulated {
    name: "virt",
    words: "qemu",
    board: virt::BOARD,
    view: View::Stored {
        set: virt::SET as u32,
        clear: virt::CLEAR as u32,
        size: virt::PORT_SIZE as u32,
        step: virt::STEP,
        dir: virt::DIR,
    },
};

/// ARM's MPS2 with a Cortex-M3.
pub static CORTEX_M3: Simulated =
    Simulated { name: "mps2", words: "qemu", board: mps2::BOARD, view: MPS2_VIEW };

/// The same image on a Cortex-M4.
pub static CORTEX_M4: Simulated =
    Simulated { name: "mps2", words: "qemu-m4", board: mps2::BOARD, view: MPS2_VIEW };

const MPS2_VIEW: View = View::Stored {
    set: mps2::SET as u32,
    clear: mps2::CLEAR as u32,
    size: mps2::PORT_SIZE as u32,
    step: mps2::STEP,
    dir: mps2::DIR,
};

/// All boards with the serial controller.
pub static CONTROLLERS: [&Simulated; 4] = [&NRF51, &VIRT, &CORTEX_M3, &CORTEX_M4];

/// The boards that also have programs with fewer features: laws and motor cycles.
pub static WITH_PROGRAMS: [&Simulated; 2] = [&NRF51, &VIRT];

impl Simulated {
    /// The arguments that start QEMU for it, from its manifest.
    ///
    /// # Errors
    /// The manifest has none.
    pub fn words(&self) -> Result<Vec<String>> {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).with_file_name(self.name);
        let file = folder.join("Cargo.toml");
        let text = fs::read_to_string(&file).with_context(|| file.display().to_string())?;
        let manifest: toml::Table = text.parse()?;
        let words = manifest["package"]["metadata"]["board"].get(self.words);
        let words = words.and_then(toml::Value::as_array).into_iter().flatten();
        let words: Vec<_> = words.filter_map(|word| Some(word.as_str()?.to_owned())).collect();
        ensure!(!words.is_empty(), "{} has no words `{}`", file.display(), self.words);
        Ok(words)
    }

    /// The ticks of its step timer in a microsecond.
    pub fn mhz(&self) -> f64 {
        f64::from(self.board.rate.hz()) / 1e6
    }
}
