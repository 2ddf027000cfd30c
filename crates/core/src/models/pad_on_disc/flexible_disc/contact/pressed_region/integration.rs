//! The nodes of the pressed region.

use crate::models::pad_on_disc::flexible_disc::contact::position::PadPosition;
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::cuts::CUT_RESOLUTION;
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::line::{Line, MOST_HARMONICS, Radius, rotate};
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::shapes::PressedRegion;
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::survey::Survey;
use crate::numerics::sine_cosine::sine_and_cosine;

/// The extent of the pressed region.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pressed {
    /// All of the patch.
    Whole,
    /// Part of it, or nothing; the nodes have been visited.
    Partly,
}

/// A node of a line with what is needed there.
pub(crate) struct PressedNode<'a> {
    /// Share of the patch's area.
    pub weight: f64,
    /// g.
    pub gap: f64,
    /// w_theta / r.
    pub slope: f64,
    /// r theta, over h.
    pub arc: f64,
    /// Cosine and sine of `n theta`.
    pub waves: &'a [(f64, f64)],
}

/// What happens to the nodes: all nodes of a line in turn, then its end.
pub(crate) trait Visitor {
    /// A node in contact.
    fn node(&mut self, node: &PressedNode<'_>, radius: &Radius);
    /// The line has no further node.
    fn end_of_line(&mut self, radius: &Radius);
}

impl PressedRegion {
    /// Visits the nodes of the pressed region line by line, unless that is the whole patch.
    pub fn visit(&self, pad: PadPosition, amplitudes: &[f64], visitor: &mut impl Visitor) -> Pressed {
        let survey = Survey { region: self, pad, amplitudes };
        let Some(cuts) = survey.cuts() else { return Pressed::Whole };
        for panel in 1..cuts.count {
            let ends = (cuts.radii[panel - 1], cuts.radii[panel]);
            // The first and the last cut are the edges of the pad, where nothing is singular.
            survey.panel(ends, (panel > 1, panel + 1 < cuts.count), visitor);
        }
        Pressed::Partly
    }
}

impl Survey<'_> {
    /// The nodes between two cuts, which crowd towards the ends that are singular.
    fn panel(&self, (from, to): (f64, f64), singular: (bool, bool), visitor: &mut impl Visitor) {
        let region = self.region;
        let width = to - from;
        if width < CUT_RESOLUTION * (1.0 - region.inner) {
            return;
        }
        let area = (1.0 - region.inner * region.inner) * region.half_angle;
        let share = width / (1.0 - region.inner);
        let rule = if share > 0.25 {
            &region.radial_rules[0]
        } else if share > 0.02 {
            &region.radial_rules[1]
        } else {
            &region.radial_rules[2]
        };
        for &(t, weight) in rule {
            let t = 0.5 * (1.0 + t);
            // Of 0 to 1 onto itself, with the derivative zero at singular ends.
            let (share, stretch) = match singular {
                (true, true) => (t * t * (3.0 - 2.0 * t), 6.0 * t * (1.0 - t)),
                (true, false) => (t * t, 2.0 * t),
                (false, true) => (t * (2.0 - t), 2.0 * (1.0 - t)),
                (false, false) => (t, 1.0),
            };
            let line = self.line(region.at(from + width * share));
            let weight = 0.5 * weight * stretch * width * line.radius.r / area;
            self.pieces(&line, weight, visitor);
        }
    }

    /// The nodes of a line, `weight` for each radian.
    fn pieces(&self, line: &Line, weight: f64, visitor: &mut impl Visitor) {
        let psi = self.region.half_angle;
        let roots = self.roots(line, true);
        if roots.count == 0 && !roots.starts_pressed {
            return;
        }
        let (mut pressed, mut from) = (roots.starts_pressed, -psi);
        let ends = roots.angles[..roots.count].iter().copied().chain([psi]);
        for to in ends {
            if pressed {
                self.piece(line, (0.5 * (from + to), 0.5 * (to - from)), weight, visitor);
            }
            (pressed, from) = (!pressed, to);
        }
        visitor.end_of_line(&line.radius);
    }

    fn piece(&self, line: &Line, (middle, half): (f64, f64), weight: f64, visitor: &mut impl Visitor) {
        let mut waves = [(1.0, 0.0); MOST_HARMONICS];
        let per_radius = self.region.length_unit / line.radius.r;
        for &(x, node_weight) in &self.region.angular_rule {
            let theta = middle + half * x;
            let (sine, cosine) = sine_and_cosine(theta);
            let (mut deflection, mut slope, mut n) = (0.0, 0.0, 0.0);
            let mut wave = (1.0, 0.0);
            for (kept, &(a, b)) in waves.iter_mut().zip(&line.waves[..line.count]) {
                *kept = wave;
                deflection += a * wave.0 + b * wave.1;
                slope += n * (b * wave.0 - a * wave.1);
                wave = rotate(wave, (cosine, sine));
                n += 1.0;
            }
            let node = PressedNode {
                weight: weight * half * node_weight,
                gap: deflection - line.tilt * theta,
                slope: slope * per_radius,
                arc: line.radius.r * theta / self.region.length_unit,
                waves: &waves[..line.count],
            };
            visitor.node(&node, &line.radius);
        }
    }
}
