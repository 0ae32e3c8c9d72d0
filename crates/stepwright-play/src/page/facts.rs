//! The facts of a job's plan, as text for a page.

use stepwright_keeper::drawing::PathFact;
use stepwright_plan::gcode::{JobPlan, MoveSum};

use crate::gcode::NAMES;

/// The time, the extents, the moves, and the corners that cost most.
pub fn of(plan: &JobPlan) -> Vec<PathFact> {
    let survey = &plan.survey;
    let mut facts = vec![fact("Time", format!("{:.6} s{}", plan.time, clock(plan.time)))];
    let extents = NAMES.iter().zip(survey.extents.0).zip(survey.cut.0);
    facts.extend(extents.filter_map(|((name, all), cut)| {
        let [from, to] = all?;
        let cut = match cut {
            Some([low, high]) if [low, high] != [from, to] => {
                format!("; cuts {} to {}", mm(low), mm(high))
            }
            _ => String::new(),
        };
        Some(fact(name, format!("{} to {} mm{cut}", mm(from), mm(to))))
    }));
    let times = [
        ("At the ordered speed", plan.at_feed),
        ("At what the axes can do", plan.at_axes),
        ("Speeding up and braking", plan.ramps),
        ("Dwells", survey.dwell),
    ];
    let times = times.into_iter().filter(|(_, time)| *time > 0.0);
    facts.extend(times.map(|(name, time)| fact(name, format!("{time:.3} s"))));
    if let Some(laser) = plan.laser {
        facts.push(fact("Laser on", format!("{:.3} s, {} mm", laser.time, mm(laser.way))));
        if laser.highest > laser.most {
            let beyond = format!("from S{} on, of S{}", laser.most, laser.highest);
            facts.push(fact("Full power", beyond));
        }
    }
    let sums = [
        ("Rapid moves", survey.rapids),
        ("Lines", survey.feeds),
        ("Arcs", survey.arcs),
        ("Probes", survey.probes),
    ];
    let made = |(_, sum): &(&str, MoveSum)| sum.count > 0;
    facts.extend(sums.into_iter().filter(made).map(|(name, MoveSum { count, distance })| {
        fact(name, format!("{count}, {} mm", mm(distance)))
    }));
    facts.extend(plan.corners.iter().map(|corner| {
        let passed = match corner.speed {
            speed if speed < 0.005 => "at rest".to_owned(),
            speed => format!("at {speed:.2} mm/s"),
        };
        let [x, y, z] = corner.place.map(mm);
        PathFact {
            name: format!("{x}, {y}, {z}"),
            value: format!("{:.3} s, {passed}", corner.cost),
            line: Some(corner.line as usize),
        }
    }));
    facts
}

fn fact(name: &str, value: String) -> PathFact {
    PathFact { name: name.to_owned(), value, line: None }
}

/// Millimetres to a µm, without trailing zeros.
fn mm(value: f64) -> String {
    let text = format!("{value:.3}");
    match text.trim_end_matches('0').trim_end_matches('.') {
        "-0" => "0".to_owned(),
        short => short.to_owned(),
    }
}

/// A time of a minute or more as minutes and seconds, or hours; empty for less.
fn clock(seconds: f64) -> String {
    let whole = seconds.round() as u64;
    match (whole / 3_600, whole / 60 % 60, whole % 60) {
        (0, 0, _) => String::new(),
        (0, minutes, seconds) => format!(" ({minutes}:{seconds:02} min)"),
        (hours, minutes, seconds) => format!(" ({hours}:{minutes:02}:{seconds:02} h)"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_are_as_short_as_they_are_exact() {
        for (value, text) in [(0.0, "0"), (-0.0001, "0"), (12.5, "12.5"), (100.0, "100")] {
            assert_eq!(mm(value), text);
        }
        for (value, text) in [(59.4, ""), (83.2, " (1:23 min)"), (3_661.0, " (1:01:01 h)")] {
            assert_eq!(clock(value), text);
        }
    }
}
