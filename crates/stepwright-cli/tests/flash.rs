//! `stepwright flash` where there is nothing to write to. (Through a boot loader on the simulated
//! chip: `cargo xtask test --only flash`.)
#![cfg(unix)]

mod common;

use common::{Running, stepwright};

#[test]
fn a_dry_run_shows_the_image_and_leaves_the_board_alone() {
    for board in ["uno", "nano"] {
        let ended = stepwright(&["flash", board, "--own", "--dry-run", "--port", "/dev/none"]);
        assert_eq!(ended.code(), Some(0), "{ended:?}");
        let hash = ended.stdout.lines().next().unwrap().rsplit(' ').next().unwrap();
        assert!(hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit()), "{ended:?}");
        assert!(ended.stdout.contains("would write it to /dev/none at 115200 bits/s"), "{ended:?}");
    }
    let old = ["flash", "nano", "--old-boot-loader", "--own", "--dry-run", "--port", "x"];
    assert!(stepwright(&old).stdout.contains("57600"));
    let json = ["flash", "uno", "--own", "--dry-run", "--port", "x", "--format", "json"];
    assert!(stepwright(&json).last_line().contains(r#""by":"stepwright","bytes":"#));
}

#[test]
fn what_can_not_be_written_is_told() {
    let own = |words: &[&str]| stepwright(&[&["flash"], words, &["--own"]].concat());
    own(&["uno", "--port", "/dev/none"]).assert_error("there is no port /dev/none");
    own(&["mega", "--port", "/dev/none"]).assert_error("takes avrdude");
    let ended = own(&["uno", "--old-boot-loader", "--port", "/dev/none"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    // A board that answers, but not as a boot loader does.
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("pty ").replace("pty ", "");
    let ended = own(&["uno", "--port", &port]);
    ended.assert_error("no boot loader answers on");
    assert_eq!(ended.code(), Some(1), "{ended:?}");
}
