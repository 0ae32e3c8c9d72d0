//! `stepwright timed`: the pins of a drive in csv, vcd and mcap.

use crate::common::{Scratch, stepwright};

/// Half steps of a unipolar motor on D8 to D11: what each pin has after each step.
#[test]
fn the_pins_of_a_drive_stand_in_csv_vcd_and_mcap() {
    let (vcd, mcap) = (Scratch::new("timed-pins.vcd"), Scratch::new("timed-pins.mcap"));
    let ended = stepwright(&[
        "timed",
        "--speed",
        "100",
        "--steps",
        "8",
        "--drive",
        "unipolar-half:D8,D9,D10,D11",
        "--format",
        "csv",
        "--vcd",
        vcd.path(),
        "--mcap",
        mcap.path(),
    ]);
    assert_eq!(ended.code(), Some(0), "{ended:?}");
    let mut lines = ended.stdout.lines();
    assert_eq!(lines.next(), Some("step,time,delay,speed,phase,D8,D9,D10,D11"));
    // One conducts or two side by side, in turn.
    let pins: Vec<&str> = lines.map(|line| line.splitn(6, ',').last().unwrap()).collect();
    let wanted =
        ["0,0,1,0", "0,0,1,1", "0,0,0,1", "1,0,0,1", "1,0,0,0", "1,1,0,0", "0,1,0,0", "0,1,1,0"];
    assert_eq!(pins, wanted);

    // The same edges in the dump: 10 ms a step, in units of 100 ps.
    let text = std::fs::read_to_string(vcd.path()).unwrap();
    assert!(text.contains("$timescale 100 ps $end"), "{text}");
    let names: Vec<&str> = (text.lines())
        .filter_map(|line| line.strip_prefix("$var wire 1 ")?.strip_suffix(" $end"))
        .collect();
    assert_eq!(names, ["a D8", "b D9", "c D10", "d D11"]);
    let (mut levels, mut at, mut seen) = ([0; 4], 0u64, Vec::new());
    for line in text.lines().skip_while(|line| !line.starts_with("$enddefinitions")).skip(1) {
        if let Some(time) = line.strip_prefix('#') {
            seen.push((at, levels));
            at = time.parse().unwrap();
            continue;
        }
        let (level, pin) = line.split_at(1);
        levels[usize::from(pin.as_bytes()[0] - b'a')] = level.parse().unwrap();
    }
    let steps: Vec<_> = (1..=8u64)
        .map(|step| {
            let time = step * 100_000_000;
            seen.iter().rfind(|(at, _)| *at <= time).map(|(_, levels)| *levels).unwrap()
        })
        .map(|levels| levels.map(|level: u8| level.to_string()).join(","))
        .collect();
    assert_eq!(steps, wanted);

    // And in the recording, in ns.
    let file = std::fs::read(mcap.path()).unwrap();
    let messages = mcap::MessageStream::new(&file).unwrap().map(Result::unwrap);
    let mut told: Vec<(u64, String, String)> = messages
        .map(|one| {
            let level = String::from_utf8(one.data.to_vec()).unwrap();
            (one.log_time, one.channel.topic.clone(), level)
        })
        .collect();
    told.sort_by_key(|(time, ..)| *time);
    assert!(told.iter().all(|(time, ..)| time % 10_000_000 == 0), "{told:?}");
    let steps = (1..=8u64).map(|step| {
        let pin = |pin: &str| {
            let mine = |(time, topic, _): &&(u64, String, String)| {
                *time <= step * 10_000_000 && topic == &format!("/{pin}")
            };
            told.iter()
                .rfind(mine)
                .map_or("0", |(.., level)| if level == r#"{"level":1}"# { "1" } else { "0" })
        };
        ["D8", "D9", "D10", "D11"].map(pin).join(",")
    });
    assert_eq!(steps.collect::<Vec<_>>(), wanted);
}

#[test]
fn a_board_needs_pins_and_has_no_single_steps_to_tell() {
    for (args, part) in [
        (&["--format", "csv"][..], "does not tell when each of its steps came"),
        (&["--plot", "x.svg"], "cannot be used with"),
    ] {
        let mut all = vec!["timed", "--speed", "100", "--port", "/dev/null"];
        all.extend(args);
        let ended = stepwright(&all);
        assert_eq!(ended.code(), Some(2), "{ended:?}");
        ended.assert_error(part);
    }
}

/// As in the source: a virtual top of 0, or no argument, stops.
#[test]
fn speed_0_stops() {
    for option in ["--speed", "--top"] {
        let ended = stepwright(&["timed", option, "0"]);
        assert_eq!(ended.code(), Some(0), "{ended:?}");
        assert_eq!(ended.stdout, "the motor stands, its driver is off\n");
    }
}
