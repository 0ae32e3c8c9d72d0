//! Whatever comes, whenever: nothing panics, the controller's place is the machine's, and no axis
//! is faster, or gets faster or slower more suddenly, than its settings say.

use proptest::prelude::*;
use stepwright_grbl::{Grbl, GrblMachine, Inputs, Outputs};

/// Steps/mm, mm/min, mm/s² and mm/min of the axes.
const SETTINGS: [(u8, f64); 12] = [
    (100, 100.0),
    (101, 80.0),
    (102, 400.0),
    (110, 3_000.0),
    (111, 2_000.0),
    (112, 600.0),
    (120, 500.0),
    (121, 300.0),
    (122, 100.0),
    (140, 120.0),
    (141, 60.0),
    (142, 30.0),
];

/// Judges each step by the steps before it.
#[derive(Debug, Default)]
struct Judge {
    at: [i64; 3],
    /// The last two steps of each axis: when, and which way.
    last: [Vec<(f64, bool)>; 3],
    now: f64,
    limit: [bool; 3],
    probe: bool,
    door: bool,
}

fn of(number: u8) -> f64 {
    SETTINGS.iter().find(|(known, _)| *known == number).unwrap().1
}

impl GrblMachine for Judge {
    fn step(&mut self, time: f64, axis: usize, forward: bool) {
        assert!(time >= self.now, "time goes back");
        self.now = time;
        self.at[axis] += if forward { 1 } else { -1 };
        let n = axis as u8;
        let (step, most) = (1.0 / of(100 + n), of(110 + n) / 60.0);
        let (accel, jump) = (of(120 + n), of(140 + n) / 60.0);
        let last = &mut self.last[axis];
        if let [.., (before, a), (then, b)] = last[..]
            && a == b
            && b == forward
        {
            let (was, is) = (step / (then - before), step / (time - then));
            // A mean is met within its interval.
            let change = jump + accel * (time - before);
            assert!(is <= most * 1.000_001, "{axis}: {is} mm/s at {time}");
            assert!((is - was).abs() <= change * 1.000_001, "{axis}: {was} to {is} mm/s at {time}");
        }
        last.push((time, forward));
        if last.len() > 2 {
            last.remove(0);
        }
    }

    fn inputs(&mut self) -> Inputs {
        Inputs { limit: self.limit, probe: self.probe, door: self.door }
    }

    fn switch(&mut self, time: f64, outputs: Outputs) {
        assert!(time >= self.now, "time goes back");
        self.now = time;
        assert!(outputs.power >= 0.0 && outputs.power.is_finite());
    }
}

#[derive(Clone, Debug)]
enum Act {
    Line(String),
    Bytes(Vec<u8>),
    Pass(f64),
    Limit(usize, bool),
    Probe(bool),
    Door(bool),
}

fn coordinate() -> impl Strategy<Value = String> {
    (-3_000i32..3_000).prop_map(|x| format!("{:.3}", f64::from(x) / 100.0))
}

fn act() -> impl Strategy<Value = Act> {
    let line = prop_oneof![
        6 => (coordinate(), coordinate(), coordinate(), 1u32..4_000)
            .prop_map(|(x, y, z, f)| format!("G1X{x}Y{y}Z{z}F{f}")),
        4 => (coordinate(), coordinate()).prop_map(|(x, y)| format!("G91G1X{x}Y{y}F900G90")),
        2 => (coordinate(), coordinate()).prop_map(|(i, j)| format!("G2I{i}J{j}F2000")),
        2 => coordinate().prop_map(|x| format!("$J=G91X{x}F1500")),
        1 => coordinate().prop_map(|z| format!("G38.3Z{z}F300")),
        1 => coordinate().prop_map(|x| format!("G0X{x}")),
        // Lines that wait for others.
        4 => (0..40i32, 0..40i32).prop_map(|(x, y)| {
            format!("G91G1X{:.2}Y{:.2}F900G90", f64::from(x) / 100.0, f64::from(y) / 100.0)
        }),
        1 => prop::sample::select(vec![
            "M3S500", "M4S900", "M5", "M8", "M9", "G4P0.1", "M0", "M2", "$X", "$C", "$$", "$#",
            "$G", "G10L20P1X0", "G92X5", "$21=1", "$21=0", "$32=1", "$32=0", "$N0=G91G0X1G90", "$N0=",
            "G93G1X1F30", "G94", "$SLP", "G64P0.2", "G64P9", "G61",
        ])
        .prop_map(str::to_owned),
    ];
    let real_time = prop::sample::select(vec![
        b'!', b'~', b'?', 0x18, 0x84, 0x85, 0x90, 0x91, 0x92, 0x93, 0x95, 0x96, 0x97, 0x9A, 0x9E,
        0xA0, 0xA1, 0xC2,
    ]);
    prop_oneof![
        10 => line.prop_map(Act::Line),
        8 => real_time.prop_map(|byte| Act::Bytes(vec![byte])),
        1 => prop::collection::vec(any::<u8>(), 1..40).prop_map(Act::Bytes),
        10 => (0.0..2.0f64).prop_map(|x| Act::Pass(x * x)),
        1 => (0..3usize, any::<bool>()).prop_map(|(axis, closed)| Act::Limit(axis, closed)),
        1 => any::<bool>().prop_map(Act::Probe),
        1 => any::<bool>().prop_map(Act::Door),
    ]
}

proptest! {
    #![proptest_config(ProptestConfig { failure_persistence: None, ..ProptestConfig::with_cases(400) })]
    #[test]
    fn nothing_is_lost_and_nothing_breaks(acts in prop::collection::vec(act(), 1..60)) {
        let mut grbl = Grbl::new(Judge::default());
        for (number, value) in SETTINGS {
            grbl.receive(0.0, format!("${number}={value}\n").as_bytes());
        }
        let mut now = 0.0;
        for act in acts {
            match act {
                // GrblSettings of the axes stay as they are.
                Act::Line(line) => grbl.receive(now, format!("{line}\n").as_bytes()),
                Act::Bytes(bytes) => grbl.receive(now, &bytes),
                Act::Pass(time) => {
                    let end = now + time;
                    while now < end {
                        now += 0.005;
                        grbl.advance(now);
                        prop_assert_eq!(grbl.position(), grbl.machine().at);
                    }
                }
                Act::Limit(axis, closed) => grbl.machine_mut().limit[axis] = closed,
                Act::Probe(closed) => grbl.machine_mut().probe = closed,
                Act::Door(open) => grbl.machine_mut().door = open,
            }
        }
        // A reset ends everything, and it can be used again.
        grbl.machine_mut().door = false;
        grbl.machine_mut().limit = [false; 3];
        grbl.receive(now, b"\x18");
        for _ in 0..10_000 {
            now += 0.005;
            grbl.advance(now);
        }
        prop_assert!(!grbl.is_moving());
        grbl.receive(now, b"$X\n$N0=\n$21=0\n");
        grbl.receive(now, b"\x18");
        _ = grbl.take_answers();
        grbl.receive(now, b"G90G21G94\nG53G0X0Y0Z0\n");
        for _ in 0..20_000 {
            now += 0.005;
            grbl.advance(now);
        }
        let said = String::from_utf8(grbl.take_answers()).unwrap();
        prop_assert!(said == "ok\r\nok\r\n", "{}", said);
        prop_assert_eq!(grbl.machine().at, [0; 3]);
    }
}
