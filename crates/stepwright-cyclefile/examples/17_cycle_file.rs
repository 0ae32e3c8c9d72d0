//! Checks the cycle files that are named.

use stepwright_cyclefile::{CycleText, read};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for name in std::env::args().skip(1) {
        let plan = read(&CycleText::named(&name, std::fs::read_to_string(&name)?))?;
        println!("{name}: {} cycles of {}", plan.stages.len(), plan.names.join(", "));
    }
    Ok(())
}
