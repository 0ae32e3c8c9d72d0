//! A picture as a list of shapes, for the SVG and the PNG writer.
//!
//! Points are in pixels of the SVG; y grows downward.

/// A colour: red, green, blue.
pub type Colour = [u8; 3];

/// The position of a text's anchor.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Anchor {
    /// Its left end.
    Start,
    /// Its middle.
    Middle,
    /// Its right end.
    End,
}

/// A shape to draw. Lengths are in pixels, y grows downward, an opacity is 0 to 1.
#[derive(Clone, Debug)]
#[allow(missing_docs)] // each field is what its name says
pub enum Shape {
    /// A filled rectangle.
    Box { x: f64, y: f64, width: f64, height: f64, fill: Colour, opacity: f64 },
    /// A line through points.
    Line { points: Vec<(f64, f64)>, colour: Colour, width: f64, dashed: bool },
    /// A filled outline.
    Area { points: Vec<(f64, f64)>, fill: Colour, opacity: f64 },
    /// Filled dots.
    Dots { points: Vec<(f64, f64)>, fill: Colour, radius: f64 },
    /// One line of text; y is its base line.
    Text { x: f64, y: f64, size: f64, bold: bool, anchor: Anchor, colour: Colour, text: String },
}

/// The dashes of a line: pixels drawn, and pixels left out.
pub const DASH: [f64; 2] = [9.0, 6.0];

/// Shapes in the order in which they are painted.
#[derive(Clone, Debug)]
pub struct Picture {
    /// In pixels.
    pub width: f64,
    /// In pixels.
    pub height: f64,
    /// The shapes, from the back to the front.
    pub shapes: Vec<Shape>,
    /// The panels' frames and values, for the read-out of the HTML page.
    pub probes: Vec<Probe>,
}

/// A panel under the mouse: the pixels of its frame, and its curves' points in
/// pixels with their values as text.
#[derive(Clone, Debug)]
pub struct Probe {
    /// The frame of the curves.
    pub frame: Frame,
    /// Unit of the x axis.
    pub x_unit: String,
    /// Unit of the y axis.
    pub y_unit: String,
    /// The curves that can be read out.
    pub curves: Vec<ProbeCurve>,
}

/// A curve that can be read out.
#[derive(Clone, Debug)]
pub struct ProbeCurve {
    /// The name as in the legend.
    pub name: String,
    /// x and y in pixels, and in the panel's units.
    pub points: Vec<[f64; 4]>,
}

/// A rectangle in pixels.
#[derive(Clone, Copy, Debug)]
pub struct Frame {
    /// Its left edge.
    pub left: f64,
    /// Its upper edge.
    pub top: f64,
    /// From left to right.
    pub width: f64,
    /// From top to bottom.
    pub height: f64,
}

impl Frame {
    /// Its right edge.
    pub fn right(&self) -> f64 {
        self.left + self.width
    }

    /// Its lower edge.
    pub fn bottom(&self) -> f64 {
        self.top + self.height
    }
}

impl Picture {
    /// An empty white picture.
    pub fn new(width: f64, height: f64) -> Picture {
        let mut picture = Picture { width, height, shapes: Vec::new(), probes: Vec::new() };
        picture.fill(Frame { left: 0.0, top: 0.0, width, height }, [255; 3], 1.0);
        picture
    }

    /// Adds a filled rectangle.
    pub fn fill(&mut self, frame: Frame, fill: Colour, opacity: f64) {
        let Frame { left: x, top: y, width, height } = frame;
        self.shapes.push(Shape::Box { x, y, width, height, fill, opacity });
    }

    /// Adds a line through points.
    pub fn line(&mut self, points: Vec<(f64, f64)>, colour: Colour, width: f64) {
        self.shapes.push(Shape::Line { points, colour, width, dashed: false });
    }

    /// Adds a line of text with its anchor on the base line at `at`.
    pub fn text(&mut self, at: (f64, f64), style: Style, text: impl Into<String>) {
        let Style { size, bold, anchor, colour } = style;
        let (x, y) = at;
        self.shapes.push(Shape::Text { x, y, size, bold, anchor, colour, text: text.into() });
    }
}

/// The style of a text.
#[derive(Clone, Copy, Debug)]
pub struct Style {
    /// Height in pixels.
    pub size: f64,
    /// Bold or regular.
    pub bold: bool,
    /// The anchor.
    pub anchor: Anchor,
    /// Its colour.
    pub colour: Colour,
}

impl Style {
    /// A regular style, anchored at the left end.
    pub const fn new(size: f64, colour: Colour) -> Style {
        Style { size, bold: false, anchor: Anchor::Start, colour }
    }

    /// The same in bold.
    pub const fn bold(self) -> Style {
        Style { bold: true, ..self }
    }

    /// The same, anchored at its middle.
    pub const fn middle(self) -> Style {
        Style { anchor: Anchor::Middle, ..self }
    }

    /// The same, anchored at its right end.
    pub const fn end(self) -> Style {
        Style { anchor: Anchor::End, ..self }
    }
}
