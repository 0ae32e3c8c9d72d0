//! A digest of files, which tells whether a build is up to date with its sources.

use std::fs;
use std::path::Path;

use anyhow::{Context, Result};

/// FNV-1a in 64 bits: finds forgotten builds, but no manipulation.
pub struct Digest(u64);

impl Digest {
    /// The digest of nothing.
    pub const NEW: Digest = Digest(0xcbf2_9ce4_8422_2325);

    /// Adds bytes.
    pub fn add(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0100_0000_01b3);
        }
    }

    /// The value of the digest.
    pub fn value(&self) -> u64 {
        self.0
    }

    /// Adds a file with its name, or all files below a folder in the order of their names.
    pub fn add_all(&mut self, root: &Path, path: &Path) -> Result<()> {
        if path.is_dir() {
            let mut inside =
                fs::read_dir(path)?.map(|entry| Ok(entry?.path())).collect::<Result<Vec<_>>>()?;
            inside.sort();
            return inside.iter().try_for_each(|path| self.add_all(root, path));
        }
        let name = path.strip_prefix(root).unwrap_or(path).to_string_lossy().replace('\\', "/");
        self.add(name.as_bytes());
        self.add(&fs::read(path).with_context(|| path.display().to_string())?);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_digest_is_the_published_one() {
        let mut digest = Digest::NEW;
        digest.add(b"foobar");
        assert_eq!(digest.0, 0x8594_4171_f739_67e8);
    }
}
