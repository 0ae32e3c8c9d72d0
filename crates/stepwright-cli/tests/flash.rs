//! `stepwright flash` where there is nothing to write to. (Through a boot loader on the simulated
//! chip: `cargo xtask test --only flash`.)
#![cfg(unix)]

use std::fs::{self, Permissions};
use std::os::unix::fs::PermissionsExt;
use std::process::Command;

use crate::common::{self, Running, Scratch, stepwright};

#[test]
fn a_dry_run_shows_the_image_and_leaves_the_board_alone() {
    for board in ["uno", "nano", "mega"] {
        let ended = stepwright(&["flash", board, "--own", "--dry-run", "--port", "/dev/none"]);
        assert_eq!(ended.code(), Some(0), "{ended:?}");
        let hash = ended.stdout.lines().next().unwrap().rsplit(' ').next().unwrap();
        assert!(hash.len() == 64 && hash.bytes().all(|b| b.is_ascii_hexdigit()), "{ended:?}");
        assert!(ended.stdout.contains("would write it to /dev/none at 115200 bits/s"), "{ended:?}");
    }
    let old = ["flash", "nano", "--old-boot-loader", "--own", "--dry-run", "--port", "x"];
    let timed = [&old[..], &["--program", "timed"]].concat();
    assert!(stepwright(&timed).stdout.contains("57600"));
    let json = ["flash", "uno", "--own", "--dry-run", "--port", "x", "--format", "json"];
    assert!(stepwright(&json).last_line().contains(r#""by":"stepwright","bytes":"#));
}

#[test]
fn every_program_is_carried_for_the_boards_that_it_fits() {
    let dry = |board, more: &[&str]| {
        let words = ["flash", board, "--own", "--dry-run", "--port", "x"];
        stepwright(&[&words, more].concat())
    };
    let image = |board, more: &[&str]| {
        let ended = dry(board, more);
        let shown = ended.stdout.strip_prefix("image       ").expect("an image");
        let shown = shown.strip_prefix(&format!("{board} ")).expect("of this board");
        shown.lines().next().unwrap_or_default().to_string()
    };
    for program in ["slave", "timed", "cycles", "laws", "transitions", "power-term", "stream"] {
        let uno = image("uno", &["--program", program]);
        assert!(uno.starts_with(&format!("{program}, ")), "{uno}");
        // A Nano is an Uno; its old boot loader leaves less room.
        assert_eq!(image("nano", &["--program", program]), uno);
        let (_, size) = uno.split_once(", ").expect("a size");
        let size: usize = size.split(' ').next().unwrap().parse().expect("a size");
        let old = ["--old-boot-loader", "--program", program];
        if size <= 30_720 {
            assert_eq!(image("nano", &old), uno);
        } else {
            let ended = dry("nano", &old);
            assert_eq!(ended.code(), Some(2), "{ended:?}");
            ended.assert_error(&format!(
                "{program} has {size} bytes, and the old boot loader leaves 30720"
            ));
            assert!(ended.stderr.contains("A Nano from before 2018"), "{ended:?}");
        }
    }
    let ended = dry("mega", &["--program", "power-term"]);
    ended.assert_error("there is no program power-term for a mega");
    assert!(ended.stderr.contains("one of slave, timed, cycles, laws"), "{ended:?}");
}

#[test]
fn what_can_not_be_written_is_told() {
    let own = |words: &[&str]| stepwright(&[&["flash"], words, &["--own"]].concat());
    own(&["uno", "--port", "/dev/none"]).assert_error("there is no port /dev/none");
    own(&["mega", "--port", "/dev/none"]).assert_error("there is no port /dev/none");
    let ended = own(&["uno", "--old-boot-loader", "--port", "/dev/none"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    // A board that answers, but not as a boot loader does.
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("pty ").replace("pty ", "");
    for name in ["uno", "mega"] {
        let ended = own(&[name, "--port", &port]);
        ended.assert_error("no boot loader answers on");
        assert_eq!(ended.code(), Some(1), "{ended:?}");
    }
}

/// Where avrdude is, it writes: it is told the chip, the boot loader, the rate and the port,
/// and gets the image that was shown.
#[test]
fn avrdude_is_told_all_of_it_and_believed() {
    let folder = Scratch::new("bin");
    fs::create_dir_all(&folder.0).unwrap();
    let avrdude = folder.0.join("avrdude");
    // Asked for nothing it says how it is used, as the real one does.
    let script = "#!/bin/sh\n[ $# = 0 ] && exit 0\necho \"$@\" > \"$0.told\"\n\
                  for word; do case $word in flash:w:*:r) file=${word#flash:w:}; \
                  cp \"${file%:r}\" \"$0.image\";; esac; done\n\
                  case \"$*\" in *broken*) exit 1;; esac\n";
    fs::write(&avrdude, script).unwrap();
    fs::set_permissions(&avrdude, Permissions::from_mode(0o755)).unwrap();
    let path = format!("{}:{}", folder.path(), std::env::var("PATH").unwrap());
    let flash = |words: &[&str]| {
        let mut command = Command::new(common::program());
        let output = command.arg("flash").args(words).env("PATH", &path).output().unwrap();
        let text = |bytes| String::from_utf8(bytes).unwrap();
        (output.status.code(), text(output.stdout), text(output.stderr))
    };
    for (board, old, told) in [
        ("uno", false, "-p m328p -c arduino -b 115200 -D -P /dev/x -U flash:w:"),
        ("nano", true, "-p m328p -c arduino -b 57600 -D -P /dev/x -U flash:w:"),
        ("mega", false, "-p m2560 -c wiring -b 115200 -D -P /dev/x -U flash:w:"),
    ] {
        let mut words = vec![board, "--program", "timed", "--port", "/dev/x"];
        words.extend(old.then_some("--old-boot-loader"));
        let (code, stdout, stderr) = flash(&words);
        assert_eq!(code, Some(0), "{stdout}{stderr}");
        assert!(stdout.ends_with("written     by avrdude, and compared\n"), "{stdout}");
        assert!(stderr.contains("stepwright timed --case 1 --port /dev/x"), "{stderr}");
        let said = fs::read_to_string(folder.0.join("avrdude.told")).unwrap();
        assert!(said.starts_with(told), "{said}");
        let image = fs::read(folder.0.join("avrdude.image")).unwrap();
        assert!(
            stdout.contains(&format!("image       {board} timed, {} bytes", image.len())),
            "{stdout}"
        );
    }
    let (code, _, stderr) = flash(&["uno", "--port", "/dev/broken"]);
    assert_eq!(code, Some(1), "{stderr}");
    assert!(stderr.contains("error: avrdude has not written it"), "{stderr}");
    assert!(stderr.contains(" hint: what it says is above"), "{stderr}");
    fs::remove_dir_all(&folder.0).unwrap();
}

/// A folder that is a Pico's drive until it has a whole file.
#[test]
fn a_pico_is_written_through_its_drive() {
    let folder = Scratch::new("drive");
    fs::create_dir_all(&folder.0).unwrap();
    let (path, info) = (folder.path(), folder.0.join("INFO_UF2.TXT"));
    fs::write(&info, "UF2 Bootloader v3.0\r\nBoard-ID: RPI-RP2\r\n").unwrap();
    let flash = |words: &[&str]| stepwright(&[&["flash", "pico"], words].concat());

    let ended = flash(&["--dry-run", "--drive", path]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(ended.stdout.starts_with("image       pico slave, "), "{ended:?}");
    assert!(ended.stdout.ends_with(&format!("would copy it to {path}\n")), "{ended:?}");
    assert!(!folder.0.join("STEPWRIGHT.UF2").exists());

    // The board restarts with the last block.
    let (file, there) = (folder.0.join("STEPWRIGHT.UF2"), info.clone());
    let board = std::thread::spawn(move || {
        loop {
            let bytes = fs::read(&file).unwrap_or_default();
            let all = bytes.get(24..28).map(|count| u32::from_le_bytes(count.try_into().unwrap()));
            if all.is_some_and(|all| bytes.len() == 512 * all as usize) {
                return fs::remove_file(&there).unwrap();
            }
            std::thread::sleep(std::time::Duration::from_millis(5));
        }
    });
    let ended = flash(&["--drive", path]);
    board.join().unwrap();
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    assert!(
        ended.stdout.ends_with(&format!("written     to {path}, and the board has restarted\n"))
    );

    let ended = flash(&["--drive", path]);
    assert_eq!(ended.code(), Some(1), "{ended:?}");
    ended.assert_error(&format!("{path} is no boot loader's drive: there is no INFO_UF2.TXT"));
    assert!(ended.stderr.contains("hold BOOTSEL while you plug the Pico in"), "{ended:?}");
    fs::write(&info, "UF2 Bootloader v1.0\nBoard-ID: SAMD21G18A\n").unwrap();
    let ended = flash(&["--drive", path]);
    ended.assert_error(&format!("{path} is no Pico's drive: Board-ID: SAMD21G18A"));
    fs::remove_dir_all(&folder.0).unwrap();

    for program in ["stream", "selftest"] {
        let ended = flash(&["--program", program, "--dry-run"]);
        assert!(ended.stdout.starts_with(&format!("image       pico {program}, ")), "{ended:?}");
    }
    let ended = flash(&["--program", "timed"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    ended.assert_error("there is no program timed for a pico");
    assert!(ended.stderr.contains("--program is one of slave, stream, selftest"), "{ended:?}");
    let ended = flash(&["--port", "/dev/x"]);
    assert_eq!(ended.code(), Some(2), "{ended:?}");
    ended.assert_error("a Pico is written through its drive");
}
