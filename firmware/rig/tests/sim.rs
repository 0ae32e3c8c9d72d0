//! `cargo xtask sim`: the firmware behind a pseudo-terminal whose path it prints, in real time.

use std::fs::OpenOptions;
use std::io::{BufRead, BufReader, Read, Write};
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use crate::common::board;

/// Ends with the test, whatever its result.
struct Sim(Child);

impl Drop for Sim {
    fn drop(&mut self) {
        let _ = self.0.kill();
        let _ = self.0.wait();
    }
}

#[test]
fn the_simulated_chip_says_its_path_and_answers_there() {
    let mut command = Command::new(env!("CARGO_BIN_EXE_sim"));
    command.arg(board().name()).stdin(Stdio::piped());
    command.stdout(Stdio::piped()).stderr(Stdio::null());
    let mut sim = Sim(command.spawn().unwrap());
    let mut said = BufReader::new(sim.0.stdout.take().unwrap());
    let mut heard = || {
        let mut line = String::new();
        said.read_line(&mut line).unwrap();
        line.trim_end().to_owned()
    };
    let first = heard();
    let path = first.strip_prefix("pty ").expect("the first line");
    let mut port = OpenOptions::new().read(true).write(true).open(path).unwrap();
    let mut ask = |line: &str| {
        port.write_all(format!("{line}\r").as_bytes()).unwrap();
        let mut answer = Vec::new();
        while answer.last() != Some(&b'\r') {
            let mut byte = [0];
            port.read_exact(&mut byte).unwrap();
            answer.extend(byte);
        }
        String::from_utf8(answer).unwrap().trim_end().to_owned()
    };
    // Bytes that come during its start are lost; they end a line at the latest now.
    std::thread::sleep(Duration::from_millis(500));
    assert!(ask("?").starts_with("stepwright "), "no answer");
    for line in ["PO", "S50", "T50", "G+250", "E"] {
        assert_eq!(ask(line), "Y", "{line}");
    }
    let begun = Instant::now();
    while ask("F") == "B" {
        std::thread::sleep(Duration::from_millis(10));
    }
    // Half a second at 500 steps/s, and at least that on a busy machine.
    assert!(begun.elapsed() > Duration::from_millis(450), "{:?}", begun.elapsed());
    assert_eq!(ask("V1"), "250");
    // Its switch is pressed and released, its plug pulled.
    assert_eq!(ask("$switches=1"), "Y");
    let mut acts = sim.0.stdin.take().unwrap();
    // Its pins agree.
    writeln!(acts, "where").unwrap();
    assert!(heard().starts_with("cycles "));
    assert_eq!(heard(), "axis 1: 250 steps, from 0 to 250");
    assert_eq!(heard(), "axis 2: 0 steps, from 0 to 0");
    assert_eq!(heard(), "axis 3: 0 steps, from 0 to 0");
    for (act, answer) in [("press 1", "E"), ("foo", "E"), ("release 1", "Y")] {
        writeln!(acts, "{act}").unwrap();
        let begun = Instant::now();
        loop {
            std::thread::sleep(Duration::from_millis(20));
            for line in ["PO", "S50", "T50", "G-5"] {
                assert_eq!(ask(line), "Y", "{line}");
            }
            let said = ask("E");
            while ask("F") == "B" {}
            if said == answer {
                break;
            }
            assert!(begun.elapsed() < Duration::from_secs(20), "{act}: {said}");
        }
    }
    assert_ne!(ask("V1"), "0");
    // The settings are in the EEPROM within half a second.
    std::thread::sleep(Duration::from_millis(1000));
    writeln!(acts, "power").unwrap();
    std::thread::sleep(Duration::from_millis(500));
    assert_eq!((ask("#"), ask("$switches")), ("E".to_owned(), "switches=1".to_owned()));
}
