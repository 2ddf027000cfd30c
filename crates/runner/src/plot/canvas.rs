//! What plots are drawn on: lines, areas and text at places in pixels, 96 of them an inch.

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
    /// The results that it shows, by the hashes that identify them.
    pub results: Vec<String>,
}

/// The size of a subscript and how far it is below its line, over the size of the font.
pub const SUBSCRIPT: (f64, f64) = (0.72, 0.22);

/// Most letters of a subscript.
const MOST_LETTERS: usize = 2;

/// A text in parts, each with whether it is a subscript, as s and c in "f_s < f_c". Symbols are single letters; longer words with
/// an underscore are names, which stay as they are.
pub fn parts(text: &str) -> Vec<(String, bool)> {
    let letters: Vec<char> = text.chars().collect();
    let mut parts: Vec<(String, bool)> = Vec::new();
    let mut add = |added: &[char], is_subscript: bool| match parts.last_mut() {
        Some((part, kind)) if *kind == is_subscript => part.extend(added),
        _ => parts.push((added.iter().collect(), is_subscript)),
    };
    let mut next = 0;
    while next < letters.len() {
        let begins = next == 0 || !(letters[next - 1].is_alphanumeric() || "_.".contains(letters[next - 1]));
        let is_symbol = begins && letters[next].is_alphabetic() && letters.get(next + 1) == Some(&'_');
        let index = letters.get(next + 2..).unwrap_or_default();
        let length = index.iter().take_while(|letter| letter.is_alphanumeric()).count();
        add(&letters[next..=next], false);
        next += 1;
        if is_symbol && (1..=MOST_LETTERS).contains(&length) && index.get(length) != Some(&'_') {
            add(&index[..length], true);
            next += 1 + length;
        }
    }
    parts
}

/// The width of a text in a font of this size.
pub fn width_of(text: &str, size: u32) -> f64 {
    LETTER * f64::from(size) * text.chars().count() as f64
}

impl Canvas {
    pub fn new(width: f64, height: f64) -> Self {
        Self { width, height, shapes: Vec::new(), results: Vec::new() }
    }

    /// What its files say of the results that they show.
    pub fn remark(&self) -> Option<String> {
        (!self.results.is_empty()).then(|| format!("stickslip results {}", self.results.join(" ")))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn symbols_have_subscripts_and_names_keep_their_underscores() {
        let marked = |text: &str| -> String {
            let mark = |(part, is_subscript): (String, bool)| if is_subscript { format!("[{part}]") } else { part };
            parts(text).into_iter().map(mark).collect()
        };
        for (text, set) in [
            ("", ""),
            ("Static friction coefficient f_s", "Static friction coefficient f[s]"),
            ("preload at or below 0, or f_s < f_c; they", "preload at or below 0, or f[s] < f[c]; they"),
            ("Effective radius r_e (m)", "Effective radius r[e] (m)"),
            ("f_s.", "f[s]."),
            ("k_n1", "k[n1]"),
            ("Δ_x", "Δ[x]"),
            ("lining_modulus", "lining_modulus"),
            ("m_lining", "m_lining"),
            ("a_b_c", "a_b_c"),
            ("damping.c_x", "damping.c_x"),
            ("p_", "p_"),
            ("_s f_", "_s f_"),
        ] {
            assert_eq!(marked(text), set);
        }
    }
}
