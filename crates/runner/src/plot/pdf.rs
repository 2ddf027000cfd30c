//! Plots as PDF: one page of the size of the figure, with text that can be searched and the letters of its font.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::{CidFontType, FontFlags, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish as _, Name, Pdf, Rect, Ref, Str, TextStr};
use subsetter::{Profile, subset};

use crate::plot::canvas::{Canvas, Place, Rgb, Shape, Text};
use crate::plot::font::{Font, unpacked};

/// Points of a page for each pixel of a canvas.
const POINTS: f64 = 72.0 / 96.0;

/// Control points of a quarter of a circle over its radius.
const QUARTER: f64 = 0.5523;

/// The objects of the file.
const CATALOG: Ref = Ref::new(1);
const PAGES: Ref = Ref::new(2);
const PAGE: Ref = Ref::new(3);
const CONTENT: Ref = Ref::new(4);
const FONT: Ref = Ref::new(5);
const CID_FONT: Ref = Ref::new(6);
const DESCRIPTOR: Ref = Ref::new(7);
const FONT_FILE: Ref = Ref::new(8);
const CHARACTERS: Ref = Ref::new(9);
const INFORMATION: Ref = Ref::new(10);

/// The name of the font on the page, and how its letters are numbered.
const NAME: Name<'static> = Name(b"F");
const IDENTITY: SystemInfo<'static> = SystemInfo { registry: Str(b"Adobe"), ordering: Str(b"Identity"), supplement: 0 };

/// A plot as PDF. The same plot has the same bytes: there is no date in them.
///
/// # Errors
/// A font that cannot be read.
pub fn pdf(canvas: &Canvas) -> Result<Vec<u8>, String> {
    let bytes = unpacked()?;
    let font = Font::new(&bytes)?;
    let mut page = Page { content: Content::new(), font: &font, letters: BTreeMap::new(), opacities: BTreeSet::new() };
    page.draw(canvas);
    let Page { content, letters, opacities, .. } = page;

    let mut pdf = Pdf::new();
    pdf.catalog(CATALOG).pages(PAGES);
    if let Some(remark) = canvas.remark() {
        pdf.document_info(INFORMATION).keywords(TextStr(&remark));
    }
    pdf.pages(PAGES).kids([PAGE]).count(1);
    let mut entry = pdf.page(PAGE);
    entry.media_box(Rect::new(0.0, 0.0, rounded(POINTS * canvas.width), rounded(POINTS * canvas.height)));
    entry.parent(PAGES).contents(CONTENT);
    let mut resources = entry.resources();
    resources.fonts().pair(NAME, FONT);
    let mut states = resources.ext_g_states();
    for percent in opacities {
        let mut state =
            states.insert(Name(state_name(percent).as_bytes())).start::<pdf_writer::writers::ExtGraphicsState<'_>>();
        state.non_stroking_alpha(f32::from(percent) / 100.0);
    }
    states.finish();
    resources.finish();
    entry.finish();
    compressed(&mut pdf, CONTENT, &content.finish())?;
    write_font(&mut pdf, &font, &bytes, &letters)?;
    Ok(pdf.finish())
}

/// What is drawn on the page, with the letters and opacities that it needs.
struct Page<'a> {
    content: Content,
    font: &'a Font<'a>,
    letters: BTreeMap<u16, char>,
    /// In per cent.
    opacities: BTreeSet<u8>,
}

impl Page<'_> {
    fn draw(&mut self, canvas: &Canvas) {
        // From here on in pixels, and downwards.
        let height = rounded(POINTS * canvas.height);
        self.content.transform([POINTS as f32, 0.0, 0.0, -POINTS as f32, 0.0, height]);
        for shape in &canvas.shapes {
            match shape {
                Shape::Line { from, to, pen } => self.lines(&[*from, *to], pen.colour, pen.width),
                Shape::Lines { points, pen } => self.lines(points, pen.colour, pen.width),
                Shape::Area { polygons, fill, opacity, line } => self.area(polygons, *fill, *opacity, *line),
                Shape::Dot { at, radius, fill } => self.dot(*at, *radius, *fill),
                Shape::Text(text) => self.text(text),
            }
        }
    }

    fn path(&mut self, points: &[Place]) {
        for (i, &(x, y)) in points.iter().enumerate() {
            if i == 0 {
                self.content.move_to(rounded(x), rounded(y));
            } else {
                self.content.line_to(rounded(x), rounded(y));
            }
        }
    }

    fn fill(&mut self, fill: Rgb) {
        let [red, green, blue] = parts(fill);
        self.content.set_fill_rgb(red, green, blue);
    }

    fn pen(&mut self, colour: Rgb, width: f64) {
        let [red, green, blue] = parts(colour);
        self.content.set_stroke_rgb(red, green, blue).set_line_width(rounded(width));
    }

    fn lines(&mut self, points: &[Place], colour: Rgb, width: f64) {
        self.pen(colour, width);
        self.path(points);
        self.content.stroke();
    }

    fn area(&mut self, polygons: &[Vec<Place>], fill: Rgb, opacity: f64, line: f64) {
        let is_opaque = opacity >= 1.0;
        if !is_opaque {
            let percent = (100.0 * opacity).round() as u8;
            self.opacities.insert(percent);
            self.content.save_state().set_parameters(Name(state_name(percent).as_bytes()));
        }
        self.fill(fill);
        if line > 0.0 {
            self.pen(fill, line);
        }
        for polygon in polygons {
            self.path(polygon);
            self.content.close_path();
        }
        if line > 0.0 {
            self.content.fill_nonzero_and_stroke();
        } else {
            self.content.fill_nonzero();
        }
        if !is_opaque {
            self.content.restore_state();
        }
    }

    fn dot(&mut self, (x, y): Place, radius: f64, fill: Rgb) {
        self.fill(fill);
        let at = |right: f64, down: f64| [rounded(x + right * radius), rounded(y + down * radius)];
        let [start_x, start_y] = at(1.0, 0.0);
        self.content.move_to(start_x, start_y);
        for (cosine, sine) in [(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)] {
            let [x1, y1] = at(cosine - QUARTER * sine, sine + QUARTER * cosine);
            let [x2, y2] = at(QUARTER * cosine - sine, QUARTER * sine + cosine);
            let [x3, y3] = at(-sine, cosine);
            self.content.cubic_to(x1, y1, x2, y2, x3, y3);
        }
        self.content.fill_nonzero();
    }

    fn text(&mut self, text: &Text) {
        let letters = self.font.letters(&text.text, text.side);
        if letters.is_empty() {
            return;
        }
        let size = f64::from(text.size);
        let (sine, cosine) = libm::sincos(text.turn.to_radians());
        let [turned_cosine, turned_sine] = [cosine, sine].map(|part| ((1e6 * part).round() / 1e6) as f32);
        self.letters.extend(letters.iter().map(|letter| (letter.glyph, letter.character)));
        self.fill(text.fill);
        // Letters of one size are shown together.
        for part in letters.chunk_by(|a, b| a.size == b.size) {
            let (along, below) = (size * part[0].at, size * part[0].below);
            let x = text.at.0 + along * cosine - below * sine;
            let y = text.at.1 + along * sine + below * cosine;
            let numbers: Vec<u8> = part.iter().flat_map(|letter| letter.glyph.to_be_bytes()).collect();
            self.content
                .begin_text()
                .set_font(NAME, (size * part[0].size) as f32)
                .set_text_matrix([turned_cosine, turned_sine, turned_sine, -turned_cosine, rounded(x), rounded(y)])
                .show(Str(&numbers))
                .end_text();
        }
    }
}

/// Writes the font with the letters of the page alone.
fn write_font(pdf: &mut Pdf, font: &Font<'_>, bytes: &[u8], letters: &BTreeMap<u16, char>) -> Result<(), String> {
    let glyphs: Vec<u16> = letters.keys().copied().collect();
    let part = subset(bytes, 0, Profile::pdf(&glyphs)).map_err(|why| format!("the font: {why}"))?;
    // Parts of a font have names of their own, by which programs that join pages tell them apart.
    let hash = blake3::hash(&part);
    let tag: String = hash.as_bytes()[..6].iter().map(|byte| char::from(b'A' + byte % 26)).collect();
    let name = format!("{tag}+DejaVuSans");
    let name = Name(name.as_bytes());
    let thousandths = |units: f64| (1000.0 * units / font.units()) as f32;

    pdf.type0_font(FONT)
        .base_font(name)
        .encoding_predefined(Name(b"Identity-H"))
        .descendant_font(CID_FONT)
        .to_unicode(CHARACTERS);
    let mut cid_font = pdf.cid_font(CID_FONT);
    cid_font.subtype(CidFontType::Type2).base_font(name).system_info(IDENTITY);
    cid_font.font_descriptor(DESCRIPTOR).default_width(0.0).cid_to_gid_map_predefined(Name(b"Identity"));
    let mut widths = cid_font.widths();
    for &glyph in letters.keys() {
        widths.consecutive(glyph, [(1000.0 * font.width(glyph)) as f32]);
    }
    widths.finish();
    cid_font.finish();

    let (bounds, [ascent, capitals, descent]) = font.extent();
    let [left, bottom, right, top] =
        [bounds.x_min, bounds.y_min, bounds.x_max, bounds.y_max].map(|units| thousandths(units.into()));
    pdf.font_descriptor(DESCRIPTOR)
        .name(name)
        .flags(FontFlags::SYMBOLIC)
        .bbox(Rect::new(left, bottom, right, top))
        .italic_angle(0.0)
        .ascent(thousandths(ascent.into()))
        .descent(thousandths(descent.into()))
        .cap_height(thousandths(capitals.into()))
        .stem_v(80.0)
        .font_file2(FONT_FILE);
    compressed(pdf, FONT_FILE, &part)?;

    let mut characters = UnicodeCmap::new(Name(b"Characters"), IDENTITY);
    letters.iter().for_each(|(&glyph, &character)| characters.pair(glyph, character));
    compressed(pdf, CHARACTERS, &characters.finish())
}

/// Writes bytes as a compressed stream.
fn compressed(pdf: &mut Pdf, reference: Ref, bytes: &[u8]) -> Result<(), String> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish()).map_err(|why| why.to_string())?;
    pdf.stream(reference, &packed).filter(Filter::FlateDecode);
    Ok(())
}

fn state_name(percent: u8) -> String {
    format!("A{percent}")
}

fn parts((red, green, blue): Rgb) -> [f32; 3] {
    [red, green, blue].map(|part| (f64::from(part) / 255.0 * 1e4).round() as f32 / 1e4)
}

/// A length to a hundredth, as it is in SVG.
fn rounded(length: f64) -> f32 {
    ((100.0 * length).round() / 100.0) as f32
}
