//! The folder where the Stepwright programs of one user meet: the holder of a port has a socket there.
//!
//! Programs find the folder by its name alone, and without `XDG_RUNTIME_DIR` it is in a place where anybody
//! could have made it first. So neither side uses a folder that does not belong to its user, or that others can
//! reach into.

use std::fs::{self, DirBuilder, Metadata};
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use rustix::process::getuid;

/// The files of a port in a private folder.
pub struct Door {
    folder: PathBuf,
    /// The canonical name of the port, the same for all links to it.
    name: String,
}

impl Door {
    /// The door of a port, if the folder exists and is private.
    pub fn find(port: &Path) -> Option<Door> {
        let port = fs::canonicalize(port).ok()?;
        let name = port.to_str()?.trim_start_matches('/').replace('/', "-");
        let folder = folder();
        let about = fs::symlink_metadata(&folder).ok()?;
        is_private(&about, getuid().as_raw()).then_some(Door { folder, name })
    }

    /// As [`find`](Door::find), but makes the folder if it is missing.
    pub fn make(port: &Path) -> Option<Door> {
        let _ = DirBuilder::new().mode(0o700).create(folder());
        Door::find(port)
    }

    /// The socket on which the holder of the port listens.
    pub fn socket(&self) -> PathBuf {
        self.folder.join(format!("{}.socket", self.name))
    }

    /// The file that notes the holder's lease until the holder has given it back.
    pub fn lease(&self) -> PathBuf {
        self.folder.join(format!("{}.lease", self.name))
    }
}

fn folder() -> PathBuf {
    match std::env::var_os("XDG_RUNTIME_DIR") {
        Some(folder) if !folder.is_empty() => PathBuf::from(folder).join("stepwright"),
        _ => std::env::temp_dir().join(format!("stepwright-{}", getuid().as_raw())),
    }
}

/// Whether this is a folder of user `uid` that nobody else can reach into. A link is not a folder.
fn is_private(about: &Metadata, uid: u32) -> bool {
    about.is_dir() && about.uid() == uid && about.mode() & 0o077 == 0
}

#[cfg(test)]
mod tests {
    use std::fs::{Permissions, set_permissions};
    use std::os::unix::fs::{PermissionsExt, symlink};

    use super::*;

    #[test]
    fn a_folder_is_private_that_only_its_user_can_reach_into() {
        let within = tempfile::tempdir().unwrap();
        let folder = within.path().join("folder");
        let uid = getuid().as_raw();
        DirBuilder::new().mode(0o700).create(&folder).unwrap();
        let about = |path: &Path| fs::symlink_metadata(path).unwrap();
        assert!(is_private(&about(&folder), uid));
        // Another user made it first.
        assert!(!is_private(&about(&folder), uid.wrapping_add(1)));
        for mode in [0o710, 0o701, 0o777] {
            set_permissions(&folder, Permissions::from_mode(mode)).unwrap();
            assert!(!is_private(&about(&folder), uid), "{mode:o}");
        }
        set_permissions(&folder, Permissions::from_mode(0o700)).unwrap();
        let link = within.path().join("link");
        symlink(&folder, &link).unwrap();
        assert!(!is_private(&about(&link), uid));
        let file = within.path().join("file");
        fs::write(&file, "").unwrap();
        set_permissions(&file, Permissions::from_mode(0o600)).unwrap();
        assert!(!is_private(&about(&file), uid));
    }
}
