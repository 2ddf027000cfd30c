//! Lines of one state of the patch.

use crate::models::pad_on_disc::flexible_disc::contact::position::PadPosition;
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::line::{
    Line, MOST_HARMONICS, Radius, Roots, SampleAngle,
};
use crate::models::pad_on_disc::flexible_disc::contact::pressed_region::shapes::PressedRegion;

/// The state of the patch that is being integrated.
pub(super) struct Survey<'a> {
    pub region: &'a PressedRegion,
    pub pad: PadPosition,
    pub amplitudes: &'a [f64],
}

impl Survey<'_> {
    pub fn line(&self, radius: Radius) -> Line {
        let region = self.region;
        let mut waves = [(0.0, 0.0); MOST_HARMONICS];
        waves[0].0 = -self.pad.normal;
        let (even, odd) = self.amplitudes.split_at(region.harmonics.len());
        for (mode, amplitude) in even.iter().enumerate() {
            waves[region.harmonics[mode]].0 += amplitude * radius.shapes[mode];
        }
        for (&mode, amplitude) in region.odd_modes.iter().zip(odd) {
            waves[region.harmonics[mode]].1 += amplitude * radius.shapes[mode];
        }
        Line { radius, waves, count: region.harmonic_count, tilt: radius.r * self.pad.tilt / region.length_unit }
    }

    /// The roots of the gap on a line: sought between sample angles, and about an extremum between two of them. Not
    /// `refined`, they only count.
    pub fn roots(&self, line: &Line, refined: bool) -> Roots {
        let (mean, swing) = line.bounds(self.region.half_angle);
        if mean.abs() > swing {
            return Roots::none(mean > 0.0);
        }
        let mut samples = self.region.samples.iter();
        let Some(first) = samples.next() else { return Roots::none(mean > 0.0) };
        let (mut from, mut before) = (first.theta, line.gap_at_sample(first));
        let mut roots = Roots::none(before.0 > 0.0);
        let root = |from, to| if refined { line.root(from, to) } else { 0.0 };
        for sample in samples {
            let (to, here) = (sample.theta, line.gap_at_sample(sample));
            let pressed = before.0 > 0.0;
            if pressed != (here.0 > 0.0) {
                roots.push(root((from, before.0), (to, here.0)));
            } else if (before.1 > 0.0) != pressed && (here.1 > 0.0) == pressed {
                // An extremum towards zero. It lies on the near side of where the tangents meet, if that is not beyond
                // 0.
                let meeting =
                    (before.1 * here.0 - here.1 * before.0 - before.1 * here.1 * (to - from)) / (before.1 - here.1);
                if (meeting > 0.0) != pressed {
                    let extremum = line.extremum((from, to), before.1 > 0.0);
                    let gap = line.gap(extremum).0;
                    if (gap > 0.0) != pressed {
                        roots.push(root((from, before.0), (extremum, gap)));
                        roots.push(root((extremum, gap), (to, here.0)));
                    }
                }
            }
            (from, before) = (to, here);
        }
        roots
    }

    pub fn roots_at(&self, r: f64) -> Roots {
        self.roots(&self.line(self.region.at(r)), true)
    }

    pub fn count_at(&self, r: f64) -> usize {
        self.roots(&self.line(self.region.at(r)), false).count
    }

    /// The gap at an end of the line at a radius.
    pub fn gap_at_end(&self, r: f64, end: &SampleAngle) -> f64 {
        self.line(self.region.at(r)).gap_at_sample(end).0
    }
}
