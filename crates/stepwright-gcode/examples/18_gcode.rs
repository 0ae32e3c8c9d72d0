//! The moves of a G-code file, in millimetres: `18_gcode FILE`, or of two lines.

use stepwright_gcode::{Effect, Reader};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).map(std::fs::read).transpose()?;
    let job = file.unwrap_or(b"G0 X1 Y1\nG2 X3 I1 F600\n".to_vec());
    let mut reader = Reader::default();
    for byte in job.into_iter().chain(*b"\n") {
        let effects = reader.push(byte).transpose()?.unwrap_or_default();
        for part in effects.effects() {
            if let Effect::Move(part) = part {
                println!("{} to {}: {:?}", part.from, part.to, part.kind);
            }
        }
    }
    Ok(())
}
