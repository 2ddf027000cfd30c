//! The font of images and pages, which is part of the program: they look the same on computers without fonts.

use std::io::Read as _;

use flate2::read::GzDecoder;
use ttf_parser::{Face, GlyphId, OutlineBuilder, Rect};

use crate::plot::canvas::{SUBSCRIPT, Side, parts};

/// DejaVu Sans; its licence lies beside it.
const DEJAVU: &[u8] = include_bytes!("font/DejaVuSans.ttf.gz");

/// The bytes of the font.
///
/// # Errors
/// That it cannot be unpacked.
pub fn unpacked() -> Result<Vec<u8>, String> {
    let mut bytes = Vec::new();
    GzDecoder::new(DEJAVU).read_to_end(&mut bytes).map_err(|why| format!("the font: {why}"))?;
    Ok(bytes)
}

/// The font, ready to set texts.
pub struct Font<'a> {
    face: Face<'a>,
}

/// A letter of a text: its glyph, and where it stands in the text, how far below its line and how large, over the size of the
/// font.
pub struct Letter {
    pub glyph: u16,
    pub character: char,
    pub at: f64,
    pub below: f64,
    pub size: f64,
}

impl<'a> Font<'a> {
    /// # Errors
    /// Bytes that are no font.
    pub fn new(bytes: &'a [u8]) -> Result<Self, String> {
        Face::parse(bytes, 0).map(|face| Self { face }).map_err(|why| format!("the font: {why}"))
    }

    /// The letters of a text that stands on this side of its place.
    pub fn letters(&self, text: &str, side: Side) -> Vec<Letter> {
        let mut end = 0.0;
        let mut letters = Vec::new();
        for (part, is_subscript) in parts(text) {
            let (size, below) = if is_subscript { SUBSCRIPT } else { (1.0, 0.0) };
            for character in part.chars() {
                let glyph = self.face.glyph_index(character).unwrap_or_default().0;
                letters.push(Letter { glyph, character, at: end, below, size });
                end += size * self.width(glyph);
            }
        }
        let before = match side {
            Side::Right => 0.0,
            Side::Middle => 0.5 * end,
            Side::Left => end,
        };
        letters.iter_mut().for_each(|letter| letter.at -= before);
        letters
    }

    /// The width of a glyph over the size of the font.
    pub fn width(&self, glyph: u16) -> f64 {
        f64::from(self.face.glyph_hor_advance(GlyphId(glyph)).unwrap_or(0)) / self.units()
    }

    /// Draws the outline of a glyph, in units of the font.
    pub fn outline(&self, glyph: u16, builder: &mut dyn OutlineBuilder) {
        // Spaces have none.
        let _ = self.face.outline_glyph(GlyphId(glyph), builder);
    }

    /// Units in the size of the font.
    pub fn units(&self) -> f64 {
        f64::from(self.face.units_per_em())
    }

    /// The box around all glyphs, and the heights of ascenders, capitals and descenders, in units of the font.
    pub fn extent(&self) -> (Rect, [i16; 3]) {
        let capitals = self.face.capital_height().unwrap_or_else(|| self.face.ascender());
        (self.face.global_bounding_box(), [self.face.ascender(), capitals, self.face.descender()])
    }
}
