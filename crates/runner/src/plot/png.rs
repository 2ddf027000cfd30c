//! Plots as PNG.

use flate2::Crc;
use tiny_skia::{Color, FillRule, Paint, Path, PathBuilder, Pixmap, Stroke, Transform};
use ttf_parser::OutlineBuilder;

use crate::plot::canvas::{Canvas, Place, Rgb, Shape, Text};
use crate::plot::font::{Font, unpacked};

/// Dots of an image for each pixel of a canvas: 300 dots an inch.
const DENSITY: f32 = 300.0 / 96.0;

/// Largest number of dots, which take four bytes each.
const MOST_DOTS: u64 = 200_000_000;

/// A plot as PNG.
///
/// # Errors
/// An image that is too large.
pub fn png(canvas: &Canvas) -> Result<Vec<u8>, String> {
    let bytes = unpacked()?;
    let font = Font::new(&bytes)?;
    let [width, height] = [canvas.width, canvas.height].map(|length| (length as f32 * DENSITY).round() as u32);
    let too_large = || format!("an image of {width} by {height} dots is too large; write it as SVG or PDF");
    let is_small = u64::from(width) * u64::from(height) <= MOST_DOTS;
    let mut image = is_small.then(|| Pixmap::new(width, height)).flatten().ok_or_else(too_large)?;
    image.fill(Color::WHITE);
    for shape in &canvas.shapes {
        draw(&mut image, shape, &font);
    }
    let image = image.encode_png().map_err(|why| why.to_string())?;
    Ok(match canvas.remark() {
        Some(remark) => with_comment(&image, &remark),
        None => image,
    })
}

/// Length of the signature of a PNG and of its first chunk.
const FIRST: usize = 8 + 25;

/// An image with a comment as its second chunk.
fn with_comment(image: &[u8], comment: &str) -> Vec<u8> {
    let kind = "tEXt";
    let chunk = format!("{kind}Comment\0{comment}");
    let length = (chunk.len() - kind.len()) as u32;
    let mut sum = Crc::new();
    sum.update(chunk.as_bytes());
    let (first, rest) = image.split_at(FIRST.min(image.len()));
    [first, &length.to_be_bytes()[..], chunk.as_bytes(), &sum.sum().to_be_bytes()[..], rest].concat()
}

fn draw(image: &mut Pixmap, shape: &Shape, font: &Font<'_>) {
    let scale = Transform::from_scale(DENSITY, DENSITY);
    let fill = |image: &mut Pixmap, path: &Path, paint: &Paint<'_>, transform| {
        image.fill_path(path, paint, FillRule::Winding, transform, None);
    };
    let stroke = |image: &mut Pixmap, path: &Path, paint: &Paint<'_>, width: f64| {
        image.stroke_path(path, paint, &Stroke { width: width as f32, ..Stroke::default() }, scale, None);
    };
    match shape {
        Shape::Line { from, to, pen } => {
            if let Some(path) = path([&[*from, *to][..]], false) {
                stroke(image, &path, &paint(pen.colour, 1.0), pen.width);
            }
        }
        Shape::Lines { points, pen } => {
            if let Some(path) = path([&points[..]], false) {
                stroke(image, &path, &paint(pen.colour, 1.0), pen.width);
            }
        }
        Shape::Area { polygons, fill: colour, opacity, line } => {
            if let Some(path) = path(polygons.iter().map(Vec::as_slice), true) {
                fill(image, &path, &paint(*colour, *opacity), scale);
                if *line > 0.0 {
                    stroke(image, &path, &paint(*colour, *opacity), *line);
                }
            }
        }
        Shape::Dot { at, radius, fill: colour } => {
            if let Some(path) = PathBuilder::from_circle(at.0 as f32, at.1 as f32, *radius as f32) {
                fill(image, &path, &paint(*colour, 1.0), scale);
            }
        }
        Shape::Text(text) => {
            if let Some(path) = outlines(text, font) {
                let place = scale.pre_translate(text.at.0 as f32, text.at.1 as f32).pre_concat(turned(text.turn));
                fill(image, &path, &paint(text.fill, 1.0), place);
            }
        }
    }
}

fn paint((red, green, blue): Rgb, opacity: f64) -> Paint<'static> {
    let mut paint = Paint { anti_alias: true, ..Paint::default() };
    paint.set_color_rgba8(red, green, blue, (255.0 * opacity).round() as u8);
    paint
}

/// Several lines, or polygons if they are closed, as a path; none of nothing.
fn path<'a>(lines: impl IntoIterator<Item = &'a [Place]>, is_closed: bool) -> Option<Path> {
    let mut builder = PathBuilder::new();
    for line in lines {
        for (i, &(x, y)) in line.iter().enumerate() {
            if i == 0 {
                builder.move_to(x as f32, y as f32);
            } else {
                builder.line_to(x as f32, y as f32);
            }
        }
        if is_closed {
            builder.close();
        }
    }
    builder.finish()
}

/// A turn in degrees, clockwise.
fn turned(degrees: f64) -> Transform {
    let (sine, cosine) = libm::sincos(degrees.to_radians());
    Transform::from_row(cosine as f32, sine as f32, -sine as f32, cosine as f32, 0.0, 0.0)
}

/// The outlines of a text about its place, with y downwards.
fn outlines(text: &Text, font: &Font<'_>) -> Option<Path> {
    let size = f64::from(text.size);
    let mut builder = Outlines { path: PathBuilder::new(), at: 0.0, below: 0.0, scale: 0.0 };
    for letter in font.letters(&text.text, text.side) {
        builder.at = (size * letter.at) as f32;
        builder.below = (size * letter.below) as f32;
        builder.scale = (size * letter.size / font.units()) as f32;
        font.outline(letter.glyph, &mut builder);
    }
    builder.path.finish()
}

/// Glyphs beside each other.
struct Outlines {
    path: PathBuilder,
    at: f32,
    below: f32,
    scale: f32,
}

impl Outlines {
    fn place(&self, x: f32, y: f32) -> (f32, f32) {
        (self.at + self.scale * x, self.below - self.scale * y)
    }
}

impl OutlineBuilder for Outlines {
    fn move_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.move_to(x, y);
    }

    fn line_to(&mut self, x: f32, y: f32) {
        let (x, y) = self.place(x, y);
        self.path.line_to(x, y);
    }

    fn quad_to(&mut self, x1: f32, y1: f32, x: f32, y: f32) {
        let ((x1, y1), (x, y)) = (self.place(x1, y1), self.place(x, y));
        self.path.quad_to(x1, y1, x, y);
    }

    fn curve_to(&mut self, x1: f32, y1: f32, x2: f32, y2: f32, x: f32, y: f32) {
        let ((x1, y1), (x2, y2), (x, y)) = (self.place(x1, y1), self.place(x2, y2), self.place(x, y));
        self.path.cubic_to(x1, y1, x2, y2, x, y);
    }

    fn close(&mut self) {
        self.path.close();
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plot::canvas::{BLACK, Side};

    /// How dark the dots of a text are in sum, and how many of them are neither dark nor light.
    fn ink(turn: f64) -> (f64, usize) {
        let mut canvas = Canvas::new(120.0, 120.0);
        canvas.text((60.0, 60.0), "Preload Δ, f_s", 11, Side::Middle, turn, BLACK);
        let image = Pixmap::decode_png(&png(&canvas).unwrap()).unwrap();
        assert_eq!((image.width(), image.height()), (375, 375));
        let dark: Vec<f64> = image.pixels().iter().map(|dot| 1.0 - f64::from(dot.green()) / 255.0).collect();
        (dark.iter().sum(), dark.iter().filter(|dark| (0.1..0.8).contains(*dark)).count())
    }

    #[test]
    fn a_turned_text_is_as_thin_and_as_crisp_as_an_upright_one() {
        let (upright, blurred) = ink(0.0);
        for turn in [-90.0, 90.0, 30.0] {
            let (turned, soft) = ink(turn);
            assert!((turned / upright - 1.0).abs() < 0.02, "{turn}: {turned} for {upright}");
            assert!(soft < 2 * blurred, "{turn}: {soft} for {blurred}");
        }
    }

    #[test]
    fn a_comment_is_part_of_the_image() {
        let mut canvas = Canvas::new(20.0, 10.0);
        canvas.dot((10.0, 5.0), 2.0, BLACK);
        let plain = png(&canvas).unwrap();
        canvas.results = vec!["0123".to_owned(), "4567".to_owned()];
        let remarked = png(&canvas).unwrap();
        let comment = b"\0\0\0\x23tEXtComment\0stickslip results 0123 4567";
        assert_eq!(remarked.len(), plain.len() + comment.len() + 4);
        assert_eq!(&remarked[FIRST..FIRST + comment.len()], comment);
        // The decoder checks the sum.
        let [plain, remarked] = [plain, remarked].map(|image| Pixmap::decode_png(&image).unwrap());
        assert!(plain.data() == remarked.data());
        assert!(png(&Canvas::new(1e8, 1e8)).is_err_and(|why| why.contains("too large")));
    }
}
