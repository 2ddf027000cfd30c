//! Regions of one verdict, and their colours.

use stickslip_core::model::verdict::Verdict;

use crate::plot::canvas::{Canvas, Place, Rgb};
use crate::plot::legend::Legend;

/// What is known of the samples at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Region {
    Stable,
    Unstable,
    Undecided,
    Failed,
    /// Their verdicts differ, or are not known.
    Open,
}

/// How many kinds of regions there are.
const KINDS: usize = 5;

/// The colour of each kind, in their order. They differ in lightness too.
const COLOURS: [Rgb; KINDS] =
    [(0xb3, 0xd9, 0xf2), (0xdf, 0x82, 0x44), (0x99, 0x99, 0x99), (0x1a, 0x1a, 0x1a), (0xf0, 0xe4, 0x42)];

impl Region {
    /// All kinds, in their order.
    pub const ALL: [Self; KINDS] = [Self::Stable, Self::Unstable, Self::Undecided, Self::Failed, Self::Open];

    /// Its colour.
    pub fn colour(self) -> Rgb {
        COLOURS[self as usize]
    }
}

impl From<Verdict> for Region {
    fn from(verdict: Verdict) -> Self {
        match verdict {
            Verdict::Stable => Self::Stable,
            Verdict::Unstable => Self::Unstable,
            Verdict::Undecided => Self::Undecided,
            Verdict::Failed => Self::Failed,
        }
    }
}

/// The regions of a panel or of a figure.
#[derive(Default)]
pub struct Regions {
    polygons: [Vec<Vec<Place>>; KINDS],
}

impl Regions {
    /// Adds a part of a region.
    pub fn add(&mut self, region: Region, polygon: Vec<Place>) {
        self.polygons[region as usize].push(polygon);
    }

    /// Draws all of them.
    pub fn draw(&self, canvas: &mut Canvas) {
        for (polygons, colour) in self.polygons.iter().zip(COLOURS) {
            canvas.mosaic(polygons, colour);
        }
    }

    /// A legend of those that some panel has, with a name for each kind.
    pub fn legend(panels: &[Self], names: [&str; KINDS], width: f64) -> Legend {
        let is_there = |kind: &usize| panels.iter().any(|panel| !panel.polygons[*kind].is_empty());
        let entry = |kind: usize| (COLOURS[kind], names[kind].to_owned());
        Legend::new((0..KINDS).filter(is_there).map(entry).collect(), width)
    }
}
