//! The options for a motor's geometry, and the preparation of typed numbers for clap.
//!
//! `stepwright-units` parses the numbers.

use std::ffi::OsString;

use serde_json::{Map, Value, json};
use stepwright::Geometry;
pub use stepwright_machine::STEPS_PER_REV;
pub use stepwright_units::measure::whole_in;
pub use stepwright_units::{
    AccelArg, DistanceArg, JerkArg, MachineUnit, MmArg, Rounded, SignedSpeedArg, SpeedArg,
};
use stepwright_units::{TURN, is_known, needs_motor, number_length};

use crate::failure::Failure;

/// The options that say how a motor's steps relate to the world.
#[derive(clap::Args, Clone, Debug)]
#[command(next_help_heading = "Motor")]
pub struct GeometryArgs {
    /// Steps of one turn, microsteps included: 200 for 1.8°, 3200 with 1/16 [default: 200]
    #[arg(long, value_name = "N")]
    #[arg(value_parser = whole_in::<u32>(STEPS_PER_REV))]
    steps_per_rev: Option<u32>,
    /// Millimetres that the load travels in one turn; needed for mm/s
    #[arg(long, value_name = "MM")]
    mm_per_rev: Option<MmArg>,
}

impl GeometryArgs {
    /// The known properties of a motor.
    pub fn new(steps_per_rev: Option<u32>, mm_per_rev: Option<MmArg>) -> GeometryArgs {
        GeometryArgs { steps_per_rev, mm_per_rev }
    }

    /// These properties, or those of another motor where they are missing.
    pub fn or(&self, other: &GeometryArgs) -> GeometryArgs {
        GeometryArgs {
            steps_per_rev: self.steps_per_rev.or(other.steps_per_rev),
            mm_per_rev: self.mm_per_rev.or(other.mm_per_rev),
        }
    }

    /// The geometry for the core.
    pub fn geometry(&self) -> Result<Geometry, Failure> {
        let geometry = Geometry::new(self.steps_per_rev.unwrap_or(TURN))?;
        Ok(match self.mm_per_rev {
            Some(mm) => geometry.travelling_nm(mm.nm())?,
            None => geometry,
        })
    }
}

impl GeometryArgs {
    /// The unit of a machine with these properties.
    pub fn unit(&self) -> Option<MachineUnit> {
        MachineUnit::of(self.steps_per_rev, self.mm_per_rev.map(MmArg::nm))
    }

    /// The unit in which the page shows positions, and the steps of one unit.
    pub fn page_unit(&self) -> Result<(&'static str, f64), Failure> {
        self.geometry()?;
        Ok(self.unit().map_or(("steps", 1.0), |unit| (unit.name, unit.steps)))
    }
}

/// The words of a command line, prepared for clap: a number and its unit after a space become one
/// word, and `-120rpm` and `-.5mm` get a minus (U+2212) in place of the hyphen, which clap would
/// take for the start of an option.
pub fn words(typed: impl Iterator<Item = OsString>) -> Vec<OsString> {
    let mut words: Vec<OsString> = Vec::new();
    for word in typed {
        match words.last_mut() {
            Some(last) if is_number(last) && word.to_str().is_some_and(is_known) => {
                last.push(word);
            }
            _ => words.push(word),
        }
    }
    words.into_iter().map(minus).collect()
}

/// Whether this word, or the part after its `=`, is a number whose unit depends on the motor.
pub fn is_of_motor(word: &OsString) -> bool {
    let Some(word) = word.to_str() else { return false };
    let text = word.rsplit('=').next().unwrap_or(word);
    let size = text.strip_prefix(['-', '+', '\u{2212}']).unwrap_or(text);
    let (number, unit) = size.split_at(number_length(size));
    !number.is_empty() && needs_motor(unit)
}

/// Whether a word is a number without a unit.
fn is_number(word: &OsString) -> bool {
    let Some(word) = word.to_str() else { return false };
    let size = word.strip_prefix(['-', '+', '\u{2212}']).unwrap_or(word);
    !size.is_empty() && number_length(size) == size.len()
}

fn minus(word: OsString) -> OsString {
    match word.to_str().and_then(|word| word.strip_prefix('-')) {
        Some(rest) if rest.starts_with(|c: char| c == '.' || c.is_ascii_digit()) => {
            // A number that clap can parse stays unchanged.
            if rest.parse::<f64>().is_ok() { word } else { format!("\u{2212}{rest}").into() }
        }
        _ => word,
    }
}

/// Adds the member `in_unit` to a JSON result: those of the members `names` that are present, in
/// the unit of the machine; `steps` is named `distance` there. Without a unit the result stays
/// unchanged.
pub fn in_unit(unit: Option<MachineUnit>, mut result: Value, names: &[&str]) -> Value {
    if let (Some(unit), Value::Object(members)) = (unit, &mut result) {
        let known = names.iter().filter_map(|name| members.get_key_value(*name));
        let mut shown: Map<_, _> =
            known.map(|(name, value)| (renamed(name), divided(value, unit.steps))).collect();
        shown.insert("unit".to_owned(), json!(unit.name));
        members.insert("in_unit".to_owned(), Value::Object(shown));
    }
    result
}

/// Like [`in_unit`], for a result whose lists have a number for each axis. If one axis is in
/// millimetres and another in degrees, nothing is added.
pub fn in_units(units: &[Option<MachineUnit>], mut result: Value, names: &[&str]) -> Value {
    let first = units.first().copied().flatten();
    if units.iter().all(|unit| *unit == first) {
        return in_unit(first, result, names);
    }
    let known: Option<Vec<MachineUnit>> = units.iter().copied().collect();
    let Some(units) = known else { return result };
    if units.iter().any(|unit| Some(unit.name) != first.map(|first| first.name)) {
        return result;
    }
    let Value::Object(members) = &mut result else { return result };
    let known = names.iter().filter_map(|name| members.get_key_value(*name));
    let mut shown: Map<_, _> = known
        .filter_map(|(name, value)| Some((renamed(name), value.as_array()?)))
        .map(|(name, all)| {
            let all = all.iter().zip(&units).map(|(one, unit)| divided(one, unit.steps));
            (name, all.collect())
        })
        .collect();
    shown.insert("unit".to_owned(), json!(first.map(|unit| unit.name)));
    members.insert("in_unit".to_owned(), Value::Object(shown));
    result
}

fn renamed(name: &str) -> String {
    if name == "steps" { "distance".to_owned() } else { name.to_owned() }
}

/// Divides numbers, also those in lists and objects.
fn divided(value: &Value, by: f64) -> Value {
    match value {
        Value::Number(number) => json!(number.as_f64().map(|steps| steps / by)),
        Value::Array(all) => all.iter().map(|one| divided(one, by)).collect(),
        Value::Object(all) => {
            Value::Object(all.iter().map(|(name, one)| (renamed(name), divided(one, by))).collect())
        }
        other => other.clone(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn in_unit_of(name: &str, mut members: Value) -> Value {
        members["unit"] = json!(name);
        members
    }

    #[test]
    fn results_keep_their_steps() {
        let mm = Some(MachineUnit { name: "mm", steps: 400.0 });
        let result =
            json!({ "axis": 1, "position": 4000, "from": null, "to": [400, -200], "steps": 8 });
        let shown = in_unit(mm, result.clone(), &["position", "from", "to", "steps", "speed"]);
        let there = json!({ "position": 10.0, "from": null, "to": [1.0, -0.5], "distance": 0.02 });
        assert_eq!(shown["in_unit"], in_unit_of("mm", there));
        assert_eq!((&shown["axis"], &shown["position"]), (&json!(1), &json!(4000)));
        assert_eq!(in_unit(None, result.clone(), &["position"]), result);
    }
}
