//! Prints how a motor with 3200 steps and 8 mm per turn takes the given speeds.

use stepwright::Geometry;
use stepwright_units::SpeedArg;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let motor = Geometry::new(3200)?.travelling_nm(8_000_000)?;
    let given: Vec<String> = std::env::args().skip(1).collect();
    let texts = if given.is_empty() { vec!["120rpm".into(), "50mm/s".into()] } else { given };
    for text in texts {
        println!("{}", text.parse::<SpeedArg>()?.resolve(&motor, "speed")?);
    }
    Ok(())
}
