//! Results, plots and positions in what the machine counts in, beside steps.

use crate::common::{Ended, Scratch, stepwright};
use serde_json::{Value, json};

const MILL: &str = "\
[axis.1]
steps-per-rev = 3200
mm-per-rev = 8
[axis.2]
steps-per-rev = 720
";

fn mill(name: &str) -> Scratch {
    let file = Scratch::new(name);
    std::fs::write(&file.0, MILL).unwrap();
    file
}

fn on(file: &Scratch, args: &[&str]) -> Ended {
    stepwright(&[args, &["--machine", file.path()]].concat())
}

fn object(ended: &Ended) -> Value {
    serde_json::from_str(&ended.stdout).unwrap_or_else(|error| panic!("{error}: {ended:#?}"))
}

#[test]
fn a_result_has_the_unit_beside_its_steps() {
    let mill = mill("units-result.toml");
    let moved = object(&on(&mill, &["move", "10mm", "--fast", "--format", "json"]));
    assert_eq!((&moved["steps"], &moved["position"]), (&json!(4000), &json!(4000)));
    assert_eq!(
        moved["in_unit"],
        json!({ "unit": "mm", "from": 0.0, "distance": 10.0, "target": 10.0, "position": 10.0 })
    );
    let motion = &moved["motion"];
    assert_eq!(
        (&motion["top_speed"], &motion["in_unit"]["top_speed"]),
        (&json!(1000.0), &json!(2.5))
    );
    // Another axis turns.
    let turned =
        object(&on(&mill, &["move", "90deg", "--axis", "2", "--fast", "--format", "json"]));
    assert_eq!(turned["in_unit"]["unit"], "deg");
    assert_eq!((&turned["position"], &turned["in_unit"]["position"]), (&json!(180), &json!(90.0)));
    let ran = on(&mill, &["run", "800", "--for", "1s", "--fast", "--format", "json"]);
    let at = object(&ran);
    let mm = at["position"].as_f64().unwrap() / 400.0;
    assert_eq!(at["in_unit"]["position"].as_f64(), Some(mm), "{ran:#?}");
    // Where nothing is known of the machine there is none.
    let bare = stepwright(&["move", "40", "--fast", "--format", "json", "--machine", "none"]);
    assert_eq!(object(&bare)["in_unit"], Value::Null);
    assert_eq!(object(&bare)["motion"]["in_unit"], Value::Null);
}

#[test]
fn a_plan_has_it_too() {
    let args =
        ["plan", "trapezoid", "--steps", "10mm", "--accel", "200mm/s2", "--top-speed", "40mm/s"];
    let machine = ["--steps-per-rev", "3200", "--mm-per-rev", "8", "--format", "json"];
    let plan = object(&stepwright(&[&args[..], &machine].concat()));
    assert_eq!((&plan["steps"], &plan["in_unit"]["distance"]), (&json!(4000), &json!(10.0)));
    assert_eq!(plan["in_unit"]["peak_speed"], 40.0);
}

#[test]
fn plots_have_its_scales() {
    let mill = mill("units-plots.toml");
    let move_svg = Scratch::new("units-move.svg");
    on(
        &mill,
        &[
            "move",
            "10mm",
            "--jerk",
            "200mm/s3",
            "--accel",
            "20mm/s2",
            "--fast",
            "--plot",
            move_svg.path(),
        ],
    )
    .assert(0, "position 4000 ready");
    let svg = std::fs::read_to_string(&move_svg.0).unwrap();
    for text in [
        "Position, mm from the start",
        "Speed, mm/s",
        "Acceleration, mm/s²",
        "Jerk, mm/s³",
        "1 mm is 400 steps",
    ] {
        assert!(svg.contains(text), "{text}: {}", svg.len());
    }
    let plan_svg = Scratch::new("units-plan.svg");
    let plan = [
        "plan",
        "s-curve",
        "--steps",
        "4000",
        "--accel",
        "8000",
        "--top-speed",
        "4000",
        "--jerk",
        "80000",
    ];
    let ended =
        stepwright(&[&plan[..], &["--mm-per-rev", "8", "--plot", plan_svg.path()]].concat());
    assert_eq!(ended.code(), Some(0), "{ended:#?}");
    let svg = std::fs::read_to_string(&plan_svg.0).unwrap();
    assert!(svg.contains("Speed, mm/s") && svg.contains("Jerk, mm/s³"));
    // Without a limit there is no jerk to look at, and without a machine there are steps.
    let bare = Scratch::new("units-bare.svg");
    let ended = stepwright(&["move", "400", "--fast", "--machine", "none", "--plot", bare.path()]);
    ended.assert(0, "position 400 ready");
    let svg = std::fs::read_to_string(&bare.0).unwrap();
    assert!(svg.contains("Speed, steps/s") && !svg.contains("Jerk"));
}

#[cfg(unix)]
#[test]
fn positions_are_said_in_it() {
    use crate::common::Running;
    let mut board = Running::start(&["board", "--pty"]);
    let port = board.wait_out("pty ").replace("pty ", "");
    let mill = mill("units-position.toml");
    let ask = |args: &[&str]| on(&mill, &[args, &["--port", &port]].concat());
    ask(&["move", "1mm"]).assert(0, "position 400 ready");
    ask(&["position"]).assert(0, "position 400 ready (1 mm)");
    ask(&["watch"]).assert(0, "position 400 ready (1 mm)");
    ask(&["position", "--mm-per-rev", "16"]).assert(0, "position 400 ready (2 mm)");
    ask(&["position", "--axis", "3"]).assert(0, "position 0 ready");
    let told = object(&ask(&["position", "--format", "json"]));
    assert_eq!(told["in_unit"], json!({ "unit": "mm", "position": 1.0 }));
    // Each axis in its own.
    let status = ask(&["status"]).stdout;
    for line in [
        "axis 1      position 400 ready (1 mm)\n",
        "axis 2      position 0 ready (0 deg)\n",
        "axis 3      position 0 ready\n",
    ] {
        assert!(status.contains(line), "{line}{status}");
    }
    let told = object(&ask(&["status", "--format", "json"]));
    assert_eq!(told["axes"][1]["in_unit"]["unit"], "deg");
    assert_eq!(told["axes"][2]["in_unit"], Value::Null);
    ask(&["zero"]).assert(0, "position 0 ready (0 mm)");
    // Also of what goes on by itself, and is changed on its way.
    let is_in_mm = |ended: &Ended| {
        let told = object(ended);
        let steps = told["position"].as_f64().unwrap();
        assert_eq!(told["in_unit"], json!({ "unit": "mm", "position": steps / 400.0 }), "{told}");
    };
    is_in_mm(&ask(&["move", "1000mm", "--detach", "--format", "json"]));
    is_in_mm(&ask(&["retarget", "900mm", "--format", "json"]));
    let changed = ask(&["retarget", "800mm"]);
    assert!(changed.last_line().ends_with(" mm)"), "{changed:#?}");
    assert_eq!(ask(&["stop"]).code(), Some(0));
    is_in_mm(&ask(&["run", "10mm/s", "--detach", "--format", "json"]));
    assert_eq!(ask(&["stop"]).code(), Some(0));
    let left = ask(&["run", "10mm/s", "--detach"]);
    assert!(left.last_line().ends_with(" mm)"), "{left:#?}");
}
