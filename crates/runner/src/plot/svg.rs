//! A plot as SVG.

use std::fmt::{self, Display, Write as _};

use crate::output::printable;
use crate::plot::canvas::{Canvas, Pen, Place, Rgb, SUBSCRIPT, Shape, Side, Text, parts};

/// What browsers and other readers have as a sans-serif font.
const FONTS: &str = "DejaVu Sans, Verdana, Arial, sans-serif";

/// The plot as a file.
pub fn svg(canvas: &Canvas) -> String {
    with_attributes(canvas, "")
}

/// The plot as an element of an HTML page, which has the text `label` for readers who do not see it.
pub fn element(canvas: &Canvas, label: &str) -> String {
    with_attributes(canvas, &format!("role=\"img\" aria-label=\"{}\" ", escaped(label)))
}

fn with_attributes(canvas: &Canvas, attributes: &str) -> String {
    let (width, height) = (canvas.width, canvas.height);
    let shapes: String = canvas.shapes.iter().map(shape).collect();
    let remark = canvas.remark().map_or_else(String::new, |remark| format!("<metadata>{remark}</metadata>"));
    // With its own coordinates a browser can scale the plot.
    format!(
        "<svg {attributes}viewBox=\"0 0 {width} {height}\" xmlns=\"http://www.w3.org/2000/svg\" width=\"{}\" \
         height=\"{}\" font-family=\"{FONTS}\">{remark}<rect width=\"100%\" height=\"100%\" fill=\"#ffffff\" />{shapes}</svg>",
        Hundredths(width),
        Hundredths(height)
    )
}

fn shape(shape: &Shape) -> String {
    match shape {
        Shape::Line { from, to, pen } => {
            let [x1, y1, x2, y2] = [from.0, from.1, to.0, to.1].map(Hundredths);
            format!("<line x1=\"{x1}\" y1=\"{y1}\" x2=\"{x2}\" y2=\"{y2}\" {} />", stroke(*pen))
        }
        Shape::Lines { points, pen } => {
            let step = |(i, &(x, y)): (usize, &Place)| {
                format!("{} {} {} ", if i == 0 { 'M' } else { 'L' }, Hundredths(x), Hundredths(y))
            };
            let path: String = points.iter().enumerate().map(step).collect();
            format!("<path d=\"{path}\" {} fill=\"none\" />", stroke(*pen))
        }
        Shape::Area { polygons, fill, opacity, line } => {
            let path = closed(polygons);
            let line = if *line > 0.0 { format!(" {}", stroke(Pen::new(*fill, *line))) } else { String::new() };
            let opacity =
                if *opacity < 1.0 { format!(" fill-opacity=\"{}\"", Hundredths(*opacity)) } else { String::new() };
            format!("<path d=\"{path}\"{line} fill=\"{}\"{opacity} />", Colour(*fill))
        }
        Shape::Dot { at, radius, fill } => {
            let [x, y, radius] = [at.0, at.1, *radius].map(Hundredths);
            format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{radius}\" fill=\"{}\" />", Colour(*fill))
        }
        Shape::Text(words) => text(words),
    }
}

fn text(words: &Text) -> String {
    let [x, y] = [words.at.0, words.at.1].map(Hundredths);
    let anchor = match words.side {
        Side::Right => "start",
        Side::Middle => "middle",
        Side::Left => "end",
    };
    let turn = if words.turn == 0.0 {
        String::new()
    } else {
        format!(" transform=\"rotate({},{x},{y})\"", Hundredths(words.turn))
    };
    format!(
        "<text x=\"{x}\" y=\"{y}\" font-size=\"{}\" text-anchor=\"{anchor}\" fill=\"{}\"{turn}>{}</text>",
        words.size,
        Colour(words.fill),
        with_subscripts(&words.text, f64::from(words.size))
    )
}

/// A text with its subscripts in smaller letters below the line, after which the line goes on.
fn with_subscripts(text: &str, size: f64) -> String {
    let (share, below) = SUBSCRIPT;
    let [small, below] = [share * size, below * size].map(Hundredths);
    let mut set = String::new();
    let mut was_below = false;
    for (part, is_below) in parts(text) {
        let part = escaped(&part);
        set += &match (is_below, was_below) {
            (true, _) => format!("<tspan dy=\"{below}\" font-size=\"{small}\">{part}</tspan>"),
            (false, true) => format!("<tspan dy=\"-{below}\">{part}</tspan>"),
            (false, false) => part,
        };
        was_below = is_below;
    }
    set
}

/// Text for SVG and HTML. The codes of colours that a terminal takes are no XML.
pub fn escaped(text: &str) -> String {
    let text = printable(text).replace('\x1b', "\\u001b");
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// Closed polygons as one path, which may be long.
fn closed(polygons: &[Vec<Place>]) -> String {
    let mut path = String::new();
    for polygon in polygons {
        for (i, (x, y)) in polygon.iter().enumerate() {
            // Writing to a string cannot fail.
            let _ = write!(path, "{}{x:.2},{y:.2}", if i == 0 { 'M' } else { 'L' });
        }
        path.push('Z');
    }
    path
}

fn stroke(pen: Pen) -> String {
    format!("stroke=\"{}\" stroke-width=\"{}\"", Colour(pen.colour), Hundredths(pen.width))
}

struct Colour(Rgb);

impl Display for Colour {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let (red, green, blue) = self.0;
        write!(f, "#{red:02x}{green:02x}{blue:02x}")
    }
}

/// A number to two decimals, without zeros at its end.
struct Hundredths(f64);

impl Display for Hundredths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        // The sum makes -0 a 0.
        write!(f, "{}", (self.0 * 100.0).round() / 100.0 + 0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::{escaped, with_subscripts};

    #[test]
    fn a_subscript_is_smaller_and_below_and_the_line_goes_on() {
        assert_eq!(
            with_subscripts("f_s < f_c & 1", 10.0),
            "f<tspan dy=\"2.2\" font-size=\"7.2\">s</tspan><tspan dy=\"-2.2\"> &lt; f</tspan><tspan dy=\"2.2\" font-size=\"7.2\">c</tspan><tspan dy=\"-2.2\"> &amp; 1</tspan>"
        );
        assert_eq!(with_subscripts("lining_modulus", 10.0), "lining_modulus");
    }

    #[test]
    fn text_is_xml_whatever_characters_it_has() {
        assert_eq!(escaped("\x1b[1mP\u{ffff} < 1\u{fffe}\u{1}\t"), "\\u001b[1mP\\uffff &lt; 1\\ufffe\\u0001\t");
    }
}
