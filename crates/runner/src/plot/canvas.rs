//! What plots are drawn on: lines, areas and text at places in pixels, 96 of them an inch.

use kuva::backend::svg::SvgBackend;
use kuva::render::color::Color;
use kuva::render::render::{PathData, Primitive, Scene, TextAnchor};

/// A place on a canvas, from the left and from the top.
pub type Place = (f64, f64);

/// Width of a letter over the size of its font, on average.
const LETTER: f64 = 0.58;

/// A colour by its parts.
pub type Rgb = (u8, u8, u8);

/// Colours of lines and text.
pub const BLACK: Rgb = (0x1a, 0x1a, 0x1a);
pub const GREY: Rgb = (0x70, 0x70, 0x70);
pub const WHITE: Rgb = (0xff, 0xff, 0xff);

/// How a line is drawn.
#[derive(Debug, Clone, Copy)]
pub struct Pen {
    pub colour: Rgb,
    pub width: f64,
}

impl Pen {
    pub const fn new(colour: Rgb, width: f64) -> Self {
        Self { colour, width }
    }
}

/// Lengths of a dash and of the space after it.
const DASH: (f64, f64) = (5.0, 3.5);

/// Width of a line that only closes seams.
const HAIRLINE: f64 = 0.3;

/// On which side of its place a text stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    Right,
    Middle,
    Left,
}

/// What is drawn.
#[derive(Debug)]
pub enum Shape {
    Line {
        from: Place,
        to: Place,
        pen: Pen,
    },
    Lines {
        points: Vec<Place>,
        pen: Pen,
    },
    /// Polygons filled as one area, with a line of its colour around them if that is wider than 0.
    Area {
        polygons: Vec<Vec<Place>>,
        fill: Rgb,
        opacity: f64,
        line: f64,
    },
    Dot {
        at: Place,
        radius: f64,
        fill: Rgb,
    },
    Text(Text),
}

/// A text beside a place; the turn is in degrees, clockwise.
#[derive(Debug)]
pub struct Text {
    pub at: Place,
    pub text: String,
    pub size: u32,
    pub side: Side,
    pub turn: f64,
    pub fill: Rgb,
}

/// A plot while it is drawn.
pub struct Canvas {
    pub width: f64,
    pub height: f64,
    /// In the order in which they are drawn over each other.
    pub shapes: Vec<Shape>,
}

/// The width of a text in a font of this size.
pub fn width_of(text: &str, size: u32) -> f64 {
    LETTER * f64::from(size) * text.chars().count() as f64
}

impl Canvas {
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, shapes: Vec::new() }
    }

    /// The plot as SVG.
    pub fn svg(&self) -> Vec<u8> {
        self.svg_with("").into_bytes()
    }

    /// The plot as an SVG element of an HTML page, which has the text `label` for readers who do not see it.
    pub fn element(&self, label: &str) -> String {
        self.svg_with(&format!("role=\"img\" aria-label=\"{label}\" "))
    }

    fn svg_with(&self, attributes: &str) -> String {
        let (width, height) = (self.width, self.height);
        let mut scene = Scene::new(width, height).with_background(Some("#ffffff"));
        scene.font_family = Some("DejaVu Sans, Verdana, Arial, sans-serif".to_owned());
        self.shapes.iter().for_each(|shape| scene.add(primitive(shape)));
        let mut text = SvgBackend::default().render_scene(&scene);
        // With its own coordinates a browser can scale the plot.
        if let Some(element) = text.find("<svg ") {
            // In place: it may be long.
            text.insert_str(element + "<svg ".len(), &format!("{attributes}viewBox=\"0 0 {width} {height}\" "));
        }
        text
    }

    pub fn line(&mut self, from: Place, to: Place, pen: Pen) {
        self.shapes.push(Shape::Line { from, to, pen });
    }

    pub fn lines(&mut self, points: &[Place], pen: Pen) {
        if points.len() > 1 {
            self.shapes.push(Shape::Lines { points: points.to_vec(), pen });
        }
    }

    /// The same in dashes, of one length whatever the distance of the points.
    pub fn dashes(&mut self, points: &[Place], pen: Pen) {
        let mut dash: Vec<Place> = points.first().copied().into_iter().collect();
        let (mut is_drawn, mut left) = (true, DASH.0);
        for pair in points.windows(2) {
            let (mut from, to) = (pair[0], pair[1]);
            let mut length = libm::hypot(to.0 - from.0, to.1 - from.1);
            while length > left {
                let share = left / length;
                from = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
                length -= left;
                if is_drawn {
                    dash.push(from);
                    self.lines(&dash, pen);
                }
                dash = vec![from];
                is_drawn = !is_drawn;
                left = if is_drawn { DASH.0 } else { DASH.1 };
            }
            left -= length;
            dash.push(to);
        }
        if is_drawn {
            self.lines(&dash, pen);
        }
    }

    /// Fills several polygons as one area, so that nothing shows between them.
    pub fn area(&mut self, polygons: &[Vec<Place>], fill: Rgb, opacity: f64) {
        self.filled(polygons, fill, opacity, 0.0);
    }

    /// The same for polygons side by side, with a hairline around each of them that hides the seams.
    pub fn mosaic(&mut self, polygons: &[Vec<Place>], fill: Rgb) {
        self.filled(polygons, fill, 1.0, HAIRLINE);
    }

    fn filled(&mut self, polygons: &[Vec<Place>], fill: Rgb, opacity: f64, line: f64) {
        if !polygons.is_empty() {
            self.shapes.push(Shape::Area { polygons: polygons.to_vec(), fill, opacity, line });
        }
    }

    pub fn dot(&mut self, at: Place, radius: f64, fill: Rgb) {
        self.shapes.push(Shape::Dot { at, radius, fill });
    }

    /// A text beside a place; a turn is in degrees, clockwise.
    pub fn text(&mut self, at: Place, text: &str, size: u32, side: Side, turn: f64, fill: Rgb) {
        self.shapes.push(Shape::Text(Text { at, text: text.to_owned(), size, side, turn, fill }));
    }
}

/// A shape as the crate that writes SVG has it.
fn primitive(shape: &Shape) -> Primitive {
    match shape {
        Shape::Line { from, to, pen } => Primitive::Line {
            x1: from.0,
            y1: from.1,
            x2: to.0,
            y2: to.1,
            stroke: colour(pen.colour),
            stroke_width: pen.width,
            stroke_dasharray: None,
        },
        Shape::Lines { points, pen } => Primitive::PolyLine {
            points: points.clone(),
            stroke: colour(pen.colour),
            stroke_width: pen.width,
            stroke_dasharray: None,
        },
        Shape::Area { polygons, fill, opacity, line } => Primitive::Path(Box::new(PathData {
            d: polygons.iter().map(|polygon| path(polygon)).collect(),
            fill: Some(colour(*fill)),
            stroke: if *line > 0.0 { colour(*fill) } else { Color::None },
            stroke_width: *line,
            opacity: (*opacity < 1.0).then_some(*opacity),
            stroke_dasharray: None,
        })),
        Shape::Dot { at, radius, fill } => Primitive::Circle {
            cx: at.0,
            cy: at.1,
            r: *radius,
            fill: colour(*fill),
            fill_opacity: None,
            stroke: None,
            stroke_width: None,
        },
        Shape::Text(text) => Primitive::Text {
            x: text.at.0,
            y: text.at.1,
            content: text.text.clone(),
            size: text.size,
            anchor: match text.side {
                Side::Right => TextAnchor::Start,
                Side::Middle => TextAnchor::Middle,
                Side::Left => TextAnchor::End,
            },
            rotate: (text.turn != 0.0).then_some(text.turn),
            bold: false,
            color: Some(colour(text.fill)),
        },
    }
}

fn colour((red, green, blue): Rgb) -> Color {
    Color::Rgb(red, green, blue)
}

/// A closed polygon as SVG writes it, to a hundredth of a pixel.
fn path(polygon: &[Place]) -> String {
    use std::fmt::Write as _;
    let mut text = String::new();
    for (i, (x, y)) in polygon.iter().enumerate() {
        // Writing to a string cannot fail.
        let _ = write!(text, "{}{x:.2},{y:.2}", if i == 0 { 'M' } else { 'L' });
    }
    text + "Z"
}
