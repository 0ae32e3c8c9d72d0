//! The plot of an order.

use super::*;
use clap::Parser;
use stepwright_plot::Figure;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    args: Args,
}

fn figure(line: &str) -> Figure {
    let args = Line::parse_from(format!("timed {line}").split_whitespace()).args;
    let hardware = args.clock.hardware().unwrap();
    let order = args.order.order(&hardware).unwrap();
    let wiring = args.wiring.wiring(None).unwrap();
    let play = TimedPlay {
        hardware,
        latched: args.latched,
        order: &order,
        wiring: &wiring,
        for_ms: args.for_ms,
        log: args.log.as_ref(),
    };
    figure::draw(&TimedCourse::play(&play).unwrap(), &wiring, args.window)
}

/// Every drive shows its pins below the speed, on the same time axis, including the call.
#[test]
fn pins_and_speed_are_on_one_time() {
    for (drive, lanes) in [
        ("shield", 6),
        ("lower-shield", 4),
        ("second-shield", 4),
        ("unipolar:D4,D5,D6,D7", 4),
        ("unipolar-half:D8,D9,D10,D11", 4),
        ("bridge-half", 4),
        ("l6219", 6),
        ("l6219-quarter", 6),
    ] {
        let figure = figure(&format!("--speed 100 --steps 10 --drive {drive}"));
        let [speed, pins] = [0, 1].map(|row| &figure.rows[row].1[0]);
        assert_eq!(speed.view.x, pins.view.x, "{drive}");
        let (from, to) = pins.view.x.unwrap();
        assert!(from < 0.0 && to > 100.0, "{drive}: {from} to {to}");
        assert_eq!((pins.lanes.len(), pins.curves.len()), (lanes, lanes), "{drive}");
        for curve in &pins.curves {
            let (first, last) = (curve.points[0], curve.points[curve.points.len() - 1]);
            assert_eq!((first.0, last.0), (from, to), "{drive}: {}", curve.name);
        }
    }
}

/// Of many steps only the first 16 are shown, or those in the chosen window.
#[test]
fn of_many_steps_few_are_shown() {
    let shown = |more: &str| {
        let figure = figure(&format!("--speed 100 --steps 400 --drive shield {more}"));
        figure.rows[1].1[0].view.x.unwrap()
    };
    assert_eq!(shown("").1, 165.0);
    assert_eq!(shown("--plot x.svg --window 20..60"), (20.0, 60.0));
}
