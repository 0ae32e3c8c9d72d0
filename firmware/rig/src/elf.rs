//! Reads the parts of an ELF file that a chip needs.
//!
//! 32 bits, little endian, AVR. RAM is at 0x800000 and the EEPROM at 0x810000
//! in the addresses of the AVR linker; below that is flash.

use std::ops::Range;
use std::path::Path;

use anyhow::{Context, Result, ensure};

/// The linker's address of RAM.
const DATA: u32 = 0x80_0000;
/// The linker's address of the EEPROM.
const EEPROM: u32 = 0x81_0000;

/// A named address.
#[derive(Clone, Debug)]
pub struct Symbol {
    /// The linker's name, mangled.
    pub name: String,
    /// The address in bytes; in flash, if below 0x800000.
    pub address: u32,
    /// The size in bytes; 0 if unknown.
    pub size: u32,
    /// Whether it stands in for a missing definition, as the unhandled vectors do.
    pub weak: bool,
}

/// A firmware as it is in flash.
#[derive(Clone, Debug)]
pub struct Image {
    /// The bytes from address 0; gaps are 0xFF.
    pub flash: Vec<u8>,
    /// The bytes of RAM in statics: `.data`, `.bss` and `.noinit`.
    pub ram: u32,
    /// All named addresses.
    pub symbols: Vec<Symbol>,
}

impl Image {
    /// Reads a file.
    ///
    /// # Errors
    /// The file can't be read, or is not an ELF file for an AVR.
    pub fn read(path: &Path) -> Result<Image> {
        let bytes =
            std::fs::read(path).with_context(|| format!("no firmware at {}", path.display()))?;
        Image::parse(&bytes).with_context(|| format!("{} is no firmware", path.display()))
    }

    fn parse(bytes: &[u8]) -> Result<Image> {
        let file = File(bytes);
        ensure!(bytes.starts_with(b"\x7fELF\x01\x01"), "not an ELF file of 32 bits");
        ensure!(file.half(18)? == 83, "not for an AVR");
        let mut flash = Vec::new();
        let (segments, size, count) = (file.word(28)?, file.half(42)?, file.half(44)?);
        for n in 0..u32::from(count) {
            let at = segments + n * u32::from(size);
            let (kind, offset) = (file.word(at)?, file.word(at + 4)?);
            // The address in flash: for initialised RAM, that of its copy.
            let (place, length) = (file.word(at + 12)?, file.word(at + 16)?);
            if kind != 1 || length == 0 || place >= DATA {
                continue;
            }
            let end = (place + length) as usize;
            if flash.len() < end {
                flash.resize(end, 0xFF);
            }
            flash[place as usize..end].copy_from_slice(file.bytes(offset, length)?);
        }
        ensure!(!flash.is_empty(), "nothing for flash in it");
        let (ram, symbols) = file.sections()?;
        Ok(Image { flash, ram, symbols })
    }

    /// Reads the bytes of a flash from address 0. It has no symbols.
    ///
    /// # Errors
    /// The file can't be read.
    pub fn flash(path: &Path) -> Result<Image> {
        let flash =
            std::fs::read(path).with_context(|| format!("no firmware at {}", path.display()))?;
        Ok(Image { flash, ram: 0, symbols: Vec::new() })
    }

    /// Reads a boot loader from an Intel HEX file, for a chip with `room` bytes of flash. The rest
    /// of the flash is erased; at address 0 is a jump to the boot loader, in place of the fuse that
    /// makes a chip start there.
    ///
    /// # Errors
    /// The file can't be read, or is not a boot loader.
    pub fn boot_loader(path: &Path, room: usize) -> Result<Image> {
        let text = std::fs::read_to_string(path)
            .with_context(|| format!("no boot loader at {}", path.display()))?;
        let mut flash = vec![0xFF; room];
        let (mut begin, mut base) = (room, 0);
        for line in text.lines() {
            let digits = line.trim().strip_prefix(':').context("a line without its colon")?;
            let record: Vec<u8> = (0..digits.len() / 2)
                .map(|n| u8::from_str_radix(&digits[2 * n..2 * n + 2], 16))
                .collect::<Result<_, _>>()?;
            let [_, high, low, kind, data @ .., _] = record.as_slice() else { continue };
            let at = base + usize::from(u16::from_be_bytes([*high, *low]));
            // The base of the following addresses: in units of 16 bytes, or of 64 KiB.
            if let (2 | 4, [high, low]) = (*kind, data) {
                let shift = if *kind == 2 { 4 } else { 16 };
                base = usize::from(u16::from_be_bytes([*high, *low])) << shift;
            }
            if *kind == 0 {
                let place = flash.get_mut(at..at + data.len()).context("beyond the flash")?;
                place.copy_from_slice(data);
                // A single instruction at the end of the flash is the version.
                if data.len() > 2 {
                    begin = begin.min(at);
                }
            }
        }
        // JMP has the 17th bit of its word address as its own lowest bit.
        let [low, high, top, ..] = (begin / 2).to_le_bytes();
        flash[..4].copy_from_slice(&[0x0C | top & 1, 0x94, low, high]);
        Ok(Image { flash, ram: 0, symbols: Vec::new() })
    }

    /// The functions whose names contain all of `parts`.
    pub fn functions<'a>(&'a self, parts: &'a [&str]) -> impl Iterator<Item = &'a Symbol> {
        self.symbols.iter().filter(move |symbol| {
            symbol.address < DATA && parts.iter().all(|part| symbol.name.contains(part))
        })
    }

    /// Whether it has its own definition of `name`.
    pub fn defines(&self, name: &str) -> bool {
        self.symbols.iter().any(|symbol| symbol.name == name && !symbol.weak)
    }

    /// The only function whose name ends in this: address and size in bytes.
    ///
    /// # Panics
    /// There is none, or more than one: for tests.
    #[track_caller]
    pub fn function(&self, end: &str) -> (u32, u32) {
        self.only(end, 0..DATA)
    }

    /// The only static whose name ends in this: address in the data space, and size.
    ///
    /// # Panics
    /// As [`function`](Image::function).
    #[track_caller]
    pub fn variable(&self, end: &str) -> (u16, u16) {
        let (address, size) = self.only(end, DATA..EEPROM);
        ((address - DATA) as u16, size as u16)
    }

    #[track_caller]
    fn only(&self, end: &str, memory: Range<u32>) -> (u32, u32) {
        let named = |symbol: &&Symbol| {
            symbol.name.ends_with(end) && memory.contains(&symbol.address) && !symbol.weak
        };
        let found: Vec<_> = self.symbols.iter().filter(named).collect();
        assert_eq!(found.len(), 1, "symbols that end with {end}: {found:?}");
        (found[0].address, found[0].size)
    }
}

struct File<'a>(&'a [u8]);

impl File<'_> {
    fn bytes(&self, at: u32, length: u32) -> Result<&[u8]> {
        let end = at.checked_add(length).context("an impossible offset")?;
        self.0.get(at as usize..end as usize).context("the file is cut short")
    }

    fn half(&self, at: u32) -> Result<u16> {
        Ok(u16::from_le_bytes(self.bytes(at, 2)?.try_into()?))
    }

    fn word(&self, at: u32) -> Result<u32> {
        Ok(u32::from_le_bytes(self.bytes(at, 4)?.try_into()?))
    }

    /// The bytes of RAM in use, and the symbols.
    fn sections(&self) -> Result<(u32, Vec<Symbol>)> {
        let (table, size, count) = (self.word(32)?, self.half(46)?, self.half(48)?);
        let header = |n: u32| table + n * u32::from(size);
        let (mut ram, mut symbols) = (0, Vec::new());
        for n in 0..u32::from(count) {
            let at = header(n);
            let (kind, flags) = (self.word(at + 4)?, self.word(at + 8)?);
            let (address, offset, length) =
                (self.word(at + 12)?, self.word(at + 16)?, self.word(at + 20)?);
            // Allocated, and in RAM.
            if flags & 2 != 0 && (DATA..EEPROM).contains(&address) {
                ram += length;
            }
            if kind == 2 {
                let names = self.word(header(self.word(at + 24)?) + 16)?;
                for entry in (offset..offset + length).step_by(16) {
                    let name = self.name(names + self.word(entry)?);
                    let (address, size) = (self.word(entry + 4)?, self.word(entry + 8)?);
                    let weak = self.bytes(entry + 12, 1)?[0] >> 4 == 2;
                    symbols.push(Symbol { name, address, size, weak });
                }
            }
        }
        Ok((ram, symbols))
    }

    fn name(&self, at: u32) -> String {
        let rest = self.0.get(at as usize..).unwrap_or(&[]);
        let name = rest.split(|&byte| byte == 0).next().unwrap_or(&[]);
        String::from_utf8_lossy(name).into_owned()
    }
}
