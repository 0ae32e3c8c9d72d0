//! Draws the speed of two axes into a file: .svg, .png or .html.

use stepwright_plot::{AxisSeries, MotionPlot, PlotFile};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let ramp = |top: f64| vec![(0.0, 0.0), (0.5, top), (1.5, top), (2.0, 0.0)];
    let series = [("axis 1", 1000.0), ("axis 2", 400.0)].map(|(name, top)| AxisSeries {
        name: name.into(),
        speed: ramp(top),
        ..AxisSeries::default()
    });
    let plot =
        MotionPlot { title: "Two axes".into(), series: series.into(), ..MotionPlot::default() };
    match std::env::args().nth(1) {
        Some(name) => name.parse::<PlotFile>()?.save(&plot.figure())?,
        None => println!("{} bytes of svg; give a file for a plot", plot.figure().svg().len()),
    }
    Ok(())
}
