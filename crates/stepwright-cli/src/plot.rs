//! Writes figures into files, with a note about each.

use stepwright_plot::{Figure, Picture, PlotError, PlotFile};

use crate::failure::Failure;
use crate::say;

/// Draws into the file, and prints a note on standard error.
pub fn save(file: &PlotFile, figure: &Figure) -> Result<(), Failure> {
    save_picture(file, &figure.title, &figure.picture())
}

/// Like [`save`], for a picture that is not a [`Figure`].
pub fn save_picture(file: &PlotFile, title: &str, picture: &Picture) -> Result<(), Failure> {
    file.save_picture(title, picture)?;
    say::note(format_args!("plot written to {}", file.path().display()));
    Ok(())
}

impl From<PlotError> for Failure {
    fn from(error: PlotError) -> Failure {
        Failure::new(error.to_string())
    }
}
