//! The folder where a second terminal looks for the first one's socket: what another user has
//! made there is not believed.
#![cfg(unix)]

use std::fs::{self, DirBuilder};
use std::io::{BufRead, BufReader, Write};
use std::os::unix::fs::{DirBuilderExt, PermissionsExt, chown, symlink};
use std::os::unix::net::UnixListener;
use std::path::Path;
use std::process::Command;

use crate::common::{self, Ended, Running};

/// Answers every line as a board that stands at 424242.
fn lie(socket: &Path) {
    let listener = UnixListener::bind(socket).unwrap();
    std::thread::spawn(move || {
        for guest in listener.incoming().flatten() {
            let mut answers = guest.try_clone().unwrap();
            for line in BufReader::new(guest).split(b'\r').map_while(Result::ok) {
                let answer = match line.first() {
                    Some(b'F') => "R",
                    Some(b'V') => "424242",
                    Some(b'A') => "Y",
                    _ => "E",
                };
                if answers.write_all(format!("{answer}\r").as_bytes()).is_err() {
                    break;
                }
            }
        }
    });
}

/// `position` with this folder for temporary files, and none at run time.
fn position(port: &str, temporary: &Path) -> Ended {
    let mut command = Command::new(common::program());
    command.args(["position", "--machine", "none", "--port", port]);
    Running::of(command.env_remove("XDG_RUNTIME_DIR").env("TMPDIR", temporary)).end()
}

#[test]
fn only_a_folder_of_our_own_is_believed() {
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("pty ").replace("pty ", "");
    let temporary = tempfile::tempdir().unwrap();
    let uid = rustix::process::getuid();
    let folder = temporary.path().join(format!("stepwright-{}", uid.as_raw()));
    let name = fs::canonicalize(&port).unwrap().display().to_string();
    let name = name.trim_start_matches('/').replace('/', "-") + ".socket";
    let make = |folder: &Path, mode| {
        DirBuilder::new().mode(mode).create(folder).unwrap();
        fs::set_permissions(folder, fs::Permissions::from_mode(mode)).unwrap();
        lie(&folder.join(&name));
    };

    // Ours alone: this is where the first terminal is. (It is the folder that makes the
    // difference, not the liar.)
    make(&folder, 0o700);
    position(&port, temporary.path()).assert(0, "position 424242 ready");
    if uid.is_root() {
        // Another user was the first to make it; only root can play that one.
        chown(&folder, Some(65_534), None).unwrap();
        position(&port, temporary.path()).assert(0, "position 0 ready");
        chown(&folder, Some(0), None).unwrap();
    }
    // Others can write to it.
    for mode in [0o770, 0o702, 0o777] {
        fs::set_permissions(&folder, fs::Permissions::from_mode(mode)).unwrap();
        position(&port, temporary.path()).assert(0, "position 0 ready");
    }
    fs::remove_dir_all(&folder).unwrap();
    // A link leads wherever its maker likes.
    let elsewhere = temporary.path().join("elsewhere");
    make(&elsewhere, 0o700);
    symlink(&elsewhere, &folder).unwrap();
    position(&port, temporary.path()).assert(0, "position 0 ready");
}
