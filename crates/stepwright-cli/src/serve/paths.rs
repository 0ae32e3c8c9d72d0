//! Files of paths for pages, read by who reads them for `stepwright cycle`.

use stepwright_serve::Declined;
use stepwright_serve::path::{PathDrawing, PathFile, PathReader};

use crate::cycle::drawing;
use crate::failure::Failure;

/// The examples, as they lie in the folder `examples/cycles`.
const EXAMPLES: [(&str, &str); 6] = [
    ("drawing.toml", include_str!("paths/drawing.toml")),
    ("feed.toml", include_str!("paths/feed.toml")),
    ("triangle.toml", include_str!("paths/triangle.toml")),
    ("series.toml", include_str!("paths/series.toml")),
    ("readme.toml", include_str!("paths/readme.toml")),
    ("calibrate.toml", include_str!("paths/calibrate.toml")),
];

/// Reads cycle files.
pub struct CycleFiles;

impl PathReader for CycleFiles {
    fn examples(&self) -> Vec<PathFile> {
        let file = |(name, text): (&str, &str)| PathFile { name: name.into(), text: text.into() };
        EXAMPLES.map(file).into()
    }

    fn draw(&self, file: &PathFile) -> Result<PathDrawing, Declined> {
        drawing::draw(&file.name, &file.text).map_err(|failure| declined(&failure, &file.name))
    }
}

/// What is wrong with a file, in one line.
fn declined(failure: &Failure, name: &str) -> Declined {
    let declined = Declined::range(match failure.place() {
        Some(place) => format!("{name}, line {}: {}", place.line, place.what),
        None => failure.message().to_owned(),
    });
    match failure.hinted() {
        Some(hint) => declined.remedy(hint),
        None => declined,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    #[test]
    fn examples_are_those_of_the_folder() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../examples/cycles");
        let there = std::fs::read_dir(&folder).unwrap().count();
        assert_eq!(there, EXAMPLES.len());
        for (name, text) in EXAMPLES {
            let own = std::fs::read_to_string(folder.join(name)).unwrap();
            assert_eq!(
                text, own,
                "copy it: cp examples/cycles/{name} crates/stepwright-cli/src/serve/paths"
            );
        }
    }

    #[test]
    fn a_mistake_is_told_with_its_line() {
        let file = PathFile { name: "a.toml".into(), text: "[[motor]]\nname = 1\n".into() };
        let declined = CycleFiles.draw(&file).unwrap_err();
        assert_eq!(declined.status(), 422);
        assert!(declined.what.starts_with("a.toml, line 2: invalid type"), "{declined:?}");
    }
}
