//! `stepwright grbl`: its three lines, what it keeps, how it ends.

use std::fs;
use std::io::{BufRead, BufReader, Write};
use std::net::TcpStream;

use crate::common::{self, LIMIT, Running, Scratch, stepwright, stepwright_with};

/// What is said on standard input, as fast as the machine can.
fn says(options: &[&str], lines: &str) -> common::Ended {
    stepwright_with(&[&["grbl", "--stdio", "--fast"], options].concat(), lines.as_bytes())
}

#[test]
fn a_job_on_standard_input_runs_to_its_end() {
    let ended = says(&[], "G21 G91 G1 X10 F600\nY-10\nM2\n");
    assert_eq!(ended.stdout, "\r\nGrbl 1.1h ['$' for help]\r\nok\r\nok\r\n[MSG:Pgm End]\r\nok\r\n");
    assert_eq!((ended.stderr.trim_end(), ended.code()), ("position 2500 -2500 0 steps", Some(0)));
}

#[test]
fn an_error_ends_what_was_sent_ahead_unless_told_otherwise() {
    let job = "G1 F600 X1\nX\nX5\n";
    let ended = says(&[], job);
    assert!(ended.stdout.ends_with("ok\r\nerror:2\r\nerror:9\r\n"), "{}", ended.stdout);
    assert!(ended.stderr.starts_with("position 250 0 0"), "{}", ended.stderr);
    assert!(ended.stderr.contains("refused, and alarms: 2"), "{}", ended.stderr);
    assert_eq!(ended.code(), Some(1));
    let ended = says(&["--after-error", "go-on"], job);
    assert!(ended.stdout.ends_with("ok\r\nerror:2\r\nok\r\n"), "{}", ended.stdout);
    assert!(ended.stderr.starts_with("position 1250 0 0"), "{}", ended.stderr);
}

/// A hold has no end of its own; the last line may have none either.
#[test]
fn the_end_of_the_input_is_the_end() {
    let ended = says(&[], "G91G1X1F600\nM0\nX1\n");
    assert_eq!(ended.code(), Some(1));
    assert!(ended.stderr.starts_with("position 250 0 0 steps\nerror: the input ended in a hold"));
    let ended = says(&[], "G91G1X1F600\nX1");
    assert_eq!((ended.stderr.as_str(), ended.code()), ("position 500 0 0 steps\n", Some(0)));
    assert!(ended.stdout.ends_with("ok\r\nok\r\n"));
}

/// Whoever pipes a file can't wait for an `ok`: no line of it is lost, however long it is.
#[test]
fn a_long_file_on_standard_input_is_executed_whole() {
    let line = format!("X0.1 ;{}\n", "-".repeat(200));
    let ended = says(&[], &format!("G91G1F1000\n{}", line.repeat(700)));
    assert_eq!((ended.stderr.as_str(), ended.code()), ("position 17500 0 0 steps\n", Some(0)));
    assert_eq!(ended.stdout.matches("ok\r\n").count(), 701);
}

/// As after ^X, but for the start-up lines.
#[cfg(unix)]
#[test]
fn ctrl_c_executes_no_start_up_line() {
    let mut running = Running::start(&["grbl", "--stdio"]);
    running.child.stdin.as_mut().unwrap().write_all(b"$N0=G91G1X10F600\n").unwrap();
    running.wait_out("ok");
    running.signal(rustix::process::Signal::INT);
    let ended = running.end();
    assert!(ended.stderr.starts_with("position 0 0 0 steps\n"), "{ended:#?}");
    assert!(!ended.stdout.contains(">G91"), "{ended:#?}");
}

/// A file that can't be written is told before anything moves.
#[test]
fn a_folder_that_is_not_there_is_told() {
    let ended = says(&["--keep", "no/such/folder.txt"], "G1X1F100\n");
    assert_eq!((ended.stdout.as_str(), ended.code()), ("", Some(1)));
    assert!(ended.stderr.contains("can't write no/such/folder.txt"), "{}", ended.stderr);
}

#[test]
fn settings_and_offsets_stay_in_a_file() {
    let scratch = Scratch::new("grbl-keep");
    let file = scratch.path();
    says(&["--keep", file], "$100=80\n$N0=G55\nG10L2P2X5\n");
    let ended = says(&["--keep", file], "$$\n$#\n");
    for part in [">G55:ok", "$100=80.000", "[G55:5.000,0.000,0.000]"] {
        assert!(ended.stdout.contains(part), "{part}: {}", ended.stdout);
    }
    fs::write(file, "$100=80\nrubbish\n").unwrap();
    let ended = says(&["--keep", file], "");
    assert_eq!(ended.code(), Some(1));
    assert!(ended.stderr.contains("line 2 is no kept value"), "{}", ended.stderr);
    assert_eq!(fs::read_to_string(file).unwrap(), "$100=80\nrubbish\n");
}

/// The power may go off behind any `ok`, also on the way to the next place.
#[test]
fn what_is_answered_is_kept() {
    let scratch = Scratch::new("grbl-answered");
    let file = scratch.path();
    let orders = ["$100=80\n", "$N0=G55\n", "G10L2P2X5\nG1X500F100\n"];
    let kept = ["$100=80\n", "$N0=G55\n", "G55=5000000000,"];
    for (order, kept) in orders.iter().zip(kept) {
        let mut running = Running::start(&["grbl", "--stdio", "--keep", file]);
        running.child.stdin.as_mut().unwrap().write_all(order.as_bytes()).unwrap();
        running.wait_out("ok");
        running.child.kill().unwrap();
        running.child.wait().unwrap();
        let found = fs::read_to_string(file).unwrap();
        assert!(found.contains(kept), "{order}{found}");
    }
}

/// A file that could not be written when something changed is written at the end.
#[test]
fn a_file_that_comes_back_is_written() {
    let folder = tempfile::tempdir().unwrap();
    let [here, away] = ["here", "away"].map(|name| folder.path().join(name));
    fs::create_dir(&here).unwrap();
    let file = here.join("mill.txt");
    let mut running = Running::start(&["grbl", "--stdio", "--keep", file.to_str().unwrap()]);
    running.wait_out("Grbl");
    fs::rename(&here, &away).unwrap();
    running.child.stdin.as_mut().unwrap().write_all(b"$100=80\n").unwrap();
    running.wait_err("warning: can't write");
    fs::rename(&away, &here).unwrap();
    running.child.stdin = None;
    let ended = running.end();
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    assert!(fs::read_to_string(&file).unwrap().contains("$100=80\n"));
}

/// A full disk: its error is of the file that was asked for, and the old one stays.
#[cfg(unix)]
#[test]
fn a_full_disk_is_told_of_the_file_itself() {
    let scratch = Scratch::new("grbl-full");
    let file = scratch.path();
    fs::write(file, "$100=80\n").unwrap();
    // No file may grow, and the shell's children do not die of it.
    let script = "trap '' XFSZ; ulimit -f 0; exec \"$0\" grbl --stdio --fast --keep \"$1\"";
    let mut shell = std::process::Command::new("sh");
    let ended = Running::of(shell.args(["-c", script]).arg(common::program()).arg(file)).end();
    assert_eq!((ended.stdout.as_str(), ended.code()), ("", Some(1)), "{ended:#?}");
    assert!(ended.stderr.starts_with(&format!("error: can't write {file}: File too large")));
    assert!(!ended.stderr.contains(".stepwright-"), "{ended:#?}");
    assert_eq!(fs::read_to_string(file).unwrap(), "$100=80\n");
}

#[test]
fn switches_and_a_probe_are_where_they_are_put() {
    let ended = says(
        &["--limit", "Z:250", "--limit", "x:-500", "--limit", "Y:500", "--probe", "-1000"],
        "$22=1\n$23=1\n$25=1000\n$H\nG38.2 Z-150 F500\n",
    );
    assert!(ended.stdout.contains(":1]\r\nok"), "{}", ended.stdout);
    for wrong in ["W:5", "X", "X:a"] {
        let ended = stepwright(&["grbl", "--stdio", "--limit", wrong]);
        assert_eq!(ended.code(), Some(2));
        assert!(ended.stderr.contains("write X:2000 or Z:-300"), "{}", ended.stderr);
    }
}

/// A network's sender: the banner when it comes, answers, and the next one when it has gone.
#[test]
fn senders_come_and_go_over_a_network() {
    let mut running = Running::start(&["grbl", "--tcp", "127.0.0.1:0"]);
    let first = running.wait_out("");
    let address = first.strip_prefix("tcp ").expect("the first line").to_owned();
    for n in 1..=2 {
        let mut sender = TcpStream::connect(&address).unwrap();
        sender.set_read_timeout(Some(LIMIT)).unwrap();
        let mut lines = BufReader::new(sender.try_clone().unwrap()).lines();
        let mut hear = || lines.next().unwrap().unwrap();
        assert_eq!((hear().as_str(), hear().as_str()), ("", "Grbl 1.1h ['$' for help]"));
        sender.write_all(format!("G1F1000X0.{n}\n").as_bytes()).unwrap();
        assert_eq!(hear(), "ok");
        loop {
            sender.write_all(b"?").unwrap();
            let status = hear();
            if status.starts_with("<Idle") {
                assert!(status.starts_with(&format!("<Idle|MPos:0.{n}00,")), "{status}");
                break;
            }
        }
    }
    #[cfg(unix)]
    running.signal(rustix::process::Signal::INT);
    let ended = running.end();
    assert!(ended.stderr.ends_with("position 50 0 0 steps\n"), "{}", ended.stderr);
}
