//! Where the pieces of the pressed region change along the radius.

use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::line::{Roots, SampleAngle};
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::shapes::PROBE_INTERVALS;
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::survey::Survey;

/// Largest number of places where the radius is cut; what is beyond is left out.
const MOST_CUTS: usize = 4 * PROBE_INTERVALS;

/// Cuts are found to this share of the pad's width: the error of an integral grows like its power 3/2.
pub(super) const CUT_RESOLUTION: f64 = 1e-8;

/// Where the radius is cut, ends of the pad included, in ascending order.
pub(super) struct Cuts {
    pub count: usize,
    pub radii: [f64; MOST_CUTS],
}

impl Cuts {
    fn push(&mut self, r: f64) {
        if self.count < MOST_CUTS {
            self.radii[self.count] = r;
            self.count += 1;
        }
    }
}

impl Survey<'_> {
    /// Where the pieces of the lines change along the radius; `None` if every probe presses everywhere.
    pub fn cuts(&self) -> Option<Cuts> {
        let region = self.region;
        let mut cuts = Cuts { count: 0, radii: [0.0; MOST_CUTS] };
        cuts.push(region.inner);
        let mut whole = true;
        let mut before: Option<(f64, Roots)> = None;
        for probe in &region.probes {
            let roots = self.roots(&self.line(*probe), false);
            whole &= roots.starts_pressed && roots.count == 0;
            if let Some((r, before)) = &before
                && !before.is_like(&roots)
            {
                self.cuts_between((*r, before), (probe.r, &roots), &mut cuts);
            }
            before = Some((probe.r, roots));
        }
        cuts.push(1.0);
        (!whole).then_some(cuts)
    }

    /// The cuts between two probes with different pieces: first those where the edge of the pressed region leaves the
    /// patch at an end of the lines, then, between them, those where it touches a line.
    fn cuts_between(&self, (from, at_from): (f64, &Roots), (to, at_to): (f64, &Roots), cuts: &mut Cuts) {
        let samples = &self.region.samples;
        let changes = |changes: bool, end: Option<&SampleAngle>| match end {
            Some(end) if changes => self.exit(from, to, end),
            _ => to,
        };
        let first = changes(at_from.starts_pressed != at_to.starts_pressed, samples.first());
        let second = changes(at_from.ends_pressed() != at_to.ends_pressed(), samples.last());
        let (first, second) = (first.min(second), first.max(second));
        // Lines that are not quite at an exit show what is to either side of it.
        let aside = 1e-7 * (to - from);
        let mut left = (from, at_from.count);
        for exit in [first, second, to] {
            let is_last = exit >= to - aside;
            let right = if is_last { (to, at_to.count) } else { (exit - aside, self.count_at(exit - aside)) };
            if right.0 > left.0 && right.1 != left.1 {
                cuts.push(self.touch(left, right));
            }
            if is_last {
                break;
            }
            cuts.push(exit);
            left = (exit + aside, self.count_at(exit + aside));
        }
    }

    /// The radius between two at which the gap at an end of the lines vanishes: the secant of a bracket, with the
    /// Illinois rule.
    fn exit(&self, from: f64, to: f64, end: &SampleAngle) -> f64 {
        let resolution = CUT_RESOLUTION * (to - from);
        let (mut a, mut b) = ((from, self.gap_at_end(from, end)), (to, self.gap_at_end(to, end)));
        for _ in 0..60 {
            let r = (a.0 * b.1 - b.0 * a.1) / (b.1 - a.1);
            if (r - b.0).abs() < 0.01 * resolution || r.is_nan() {
                break;
            }
            let gap = self.gap_at_end(r, end);
            if (gap > 0.0) != (b.1 > 0.0) {
                a = b;
            } else {
                a.1 *= 0.5;
            }
            b = (r, gap);
        }
        b.0
    }

    /// The radius between two at which roots meet, and lines have fewer of them beyond. The square of the distance of
    /// two roots is nearly linear in the radius; each prediction of its zero is approached by nine tenths, from the
    /// side where the roots are.
    fn touch(&self, from: (f64, usize), to: (f64, usize)) -> f64 {
        let (many, mut few) = if from.1 > to.1 { (from, to.0) } else { (to, from.0) };
        let resolution = CUT_RESOLUTION * (1.0 - self.region.inner);
        let mut near = (many.0, self.roots_at(many.0).nearness());
        let mut before: Option<(f64, f64)> = None;
        let mut predicted = f64::NAN;
        for _ in 0..60 {
            let last = predicted;
            if let Some(before) = before {
                predicted = near.0 + near.1 * (near.0 - before.0) / (before.1 - near.1);
            }
            // Away from where they meet, two other roots may be the nearest, and their distance predicts nothing.
            let between = predicted > near.0.min(few) - resolution && predicted < near.0.max(few) + resolution;
            if between && (predicted - last).abs() < resolution {
                return predicted;
            }
            let inside = (predicted - near.0) * (predicted - few) < 0.0;
            let r = if inside { near.0 + 0.9 * (predicted - near.0) } else { 0.5 * (near.0 + few) };
            if (near.0 - few).abs() < resolution {
                return r;
            }
            let roots = self.roots_at(r);
            if roots.count >= many.1 {
                before = Some(near);
                near = (r, roots.nearness());
            } else {
                few = r;
                // A prediction that went too far is not made again.
                before = before.filter(|_| !inside);
            }
        }
        0.5 * (near.0 + few)
    }
}
