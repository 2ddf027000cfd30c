//! The patch where part of it has lifted off: integrals over the pressed region, whose edge is found first.
//!
//! On a line of constant radius the gap is a constant, a linear function and a few harmonics of the angle,
//!
//! ```text
//! g(theta) = -y - r theta tan(phi) + sum over n of ( A_n(r) cos(n theta) + B_n(r) sin(n theta) )
//! ```
//!
//! and its roots in theta part the line into pieces that press and pieces that do not. Gauss points on every pressed piece
//! see a smooth integrand. Along the radius the integral of a line is smooth too, except where the edge of the pressed
//! region meets an end of the lines (`theta = +-psi`) and where it touches a line: there pieces appear, vanish, part or
//! join, and the length of a piece begins like a square root. The radius is cut at those places, and nodes crowd towards
//! them (`r = r_0 + t^2` near `r_0`), which makes the integrand smooth in t. A rule with fixed nodes has the kinks inside,
//! and its errors fall only like a power of the number of nodes.
//!
//! A lifted or pressed island that lies between two neighbouring probe lines and touches neither is not seen; the probes
//! are an eighth of the pad's width apart. For the preset's disc bent and tilted at random, loads are within 1e-7 of those
//! with twice the points in most states, and within 2e-4 in all of 198.

use crate::flexible_disc::brake::sine_and_cosine;
use crate::flexible_disc::contact::PadPosition;
use crate::flexible_disc::plate_modes::{
    MOST_DISC_MODES, PlateMode, RADIAL_FUNCTIONS, RadialFunctions, gauss_legendre,
};

/// Intervals between the lines on which the pressed region is looked for, along the radius.
const PROBE_INTERVALS: usize = 8;

/// Harmonics in the angle, n = 0 included.
pub(crate) const MOST_HARMONICS: usize = MOST_DISC_MODES;

/// Roots of the gap on one line at the most: more than the harmonics and the linear term can make on most pads. What is
/// beyond is left out.
const MOST_ROOTS: usize = 2 * MOST_HARMONICS + 2;

/// Places where the radius is cut, at the most; what is beyond is left out.
const MOST_CUTS: usize = 4 * PROBE_INTERVALS;

/// Last step of Newton's method, in radians; its square is what is left.
const ROOT_STEP: f64 = 1e-7;

/// Cuts are found to this share of the pad's width: the error of an integral grows like its power 3/2.
const CUT_RESOLUTION: f64 = 1e-8;

/// What the pressed region looks like.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Pressed {
    /// All of the patch.
    Whole,
    /// Part of it, or nothing; the nodes have been visited.
    Partly,
}

/// The disc's modes on the patch, at any radius and angle; lengths are over b here.
#[derive(Debug, Clone)]
pub(crate) struct PressedRegion {
    inner: f64,
    /// h / b.
    pub thickness: f64,
    half_angle: f64,
    /// n of every mode.
    pub harmonics: Vec<usize>,
    /// Modes with a sine shape, in the order of the odd amplitudes.
    pub odd_modes: Vec<usize>,
    /// One more than the largest n.
    harmonic_count: usize,
    /// a / b.
    radius_ratio: f64,
    /// Of the radial functions, each in all modes.
    coefficients: Vec<[f64; MOST_DISC_MODES]>,
    probes: Vec<Radius>,
    samples: Vec<SampleAngle>,
    /// For panels wider than a quarter of the pad, and for narrower ones, which count for less.
    radial_rules: [Vec<(f64, f64)>; 3],
    angular_rule: Vec<(f64, f64)>,
}

/// The expansions of modes, function by function.
fn coefficients(modes: &[PlateMode]) -> Vec<[f64; MOST_DISC_MODES]> {
    let mut rows = vec![[0.0; MOST_DISC_MODES]; RADIAL_FUNCTIONS];
    for (index, mode) in modes.iter().enumerate() {
        for (row, coefficient) in rows.iter_mut().zip(mode.coefficients()) {
            row[index] = *coefficient;
        }
    }
    rows
}

/// A radius with the radial shapes of the modes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Radius {
    pub r: f64,
    pub shapes: [f64; MOST_DISC_MODES],
}

/// An angle at which the gap of every line is looked at.
#[derive(Debug, Clone)]
struct SampleAngle {
    theta: f64,
    /// Cosine and sine of `n theta`.
    waves: Vec<(f64, f64)>,
}

/// The gap on one line of constant radius.
struct Line {
    radius: Radius,
    /// A_n; -y is in the first. And B_n.
    waves: [(f64, f64); MOST_HARMONICS],
    count: usize,
    /// r tan(phi), over h.
    tilt: f64,
}

/// Where the gap of a line changes its sign.
struct Roots {
    starts_pressed: bool,
    count: usize,
    angles: [f64; MOST_ROOTS],
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

/// What becomes of the nodes: all nodes of a line in turn, then its end.
pub(crate) trait Visitor {
    /// A node in contact.
    fn node(&mut self, node: &PressedNode<'_>, radius: &Radius);
    /// The line has no further node.
    fn end_of_line(&mut self, radius: &Radius);
}

impl Line {
    /// The gap with its first two derivatives by the angle.
    fn gap(&self, theta: f64) -> (f64, f64, f64) {
        let (sine, cosine) = sine_and_cosine(theta);
        let (mut wave, mut n) = ((1.0, 0.0), 0.0);
        let (mut gap, mut first, mut second) = (-self.tilt * theta, -self.tilt, 0.0);
        for &(a, b) in &self.waves[..self.count] {
            let value = a * wave.0 + b * wave.1;
            gap += value;
            first += n * (b * wave.0 - a * wave.1);
            second -= n * n * value;
            wave = rotate(wave, (cosine, sine));
            n += 1.0;
        }
        (gap, first, second)
    }

    fn gap_at_sample(&self, sample: &SampleAngle) -> (f64, f64) {
        let (mut gap, mut first, mut n) = (-self.tilt * sample.theta, -self.tilt, 0.0);
        for (&(a, b), wave) in self.waves[..self.count].iter().zip(&sample.waves) {
            gap += a * wave.0 + b * wave.1;
            first += n * (b * wave.0 - a * wave.1);
            n += 1.0;
        }
        (gap, first)
    }

    /// The mean of the gap's bounds, and half of their distance.
    fn bounds(&self, half_angle: f64) -> (f64, f64) {
        let swing: f64 = self.waves[1..self.count].iter().map(|(a, b)| a.abs() + b.abs()).sum();
        (self.waves[0].0, swing + self.tilt.abs() * half_angle)
    }

    /// The root between two angles of which one presses and the other does not: Newton's method from where the chord of the
    /// gaps vanishes, kept between them.
    fn root(&self, from: (f64, f64), to: (f64, f64)) -> f64 {
        let pressed_at_from = from.1 > 0.0;
        let mut theta = (from.0 * to.1 - to.0 * from.1) / (to.1 - from.1);
        let (mut from, mut to) = (from.0, to.0);
        for _ in 0..60 {
            let (gap, slope, _) = self.gap(theta);
            if (gap > 0.0) == pressed_at_from {
                from = theta;
            } else {
                to = theta;
            }
            let newton = theta - gap / slope;
            // The next step would be the square of this one.
            if (newton - theta).abs() < ROOT_STEP {
                return newton;
            }
            theta = if newton > from && newton < to { newton } else { 0.5 * (from + to) };
            if to - from < ROOT_STEP {
                return theta;
            }
        }
        theta
    }

    /// The extremum between two angles of which the gap falls at one and rises at the other.
    fn extremum(&self, (mut from, mut to): (f64, f64), rises_at_from: bool) -> f64 {
        let mut theta = 0.5 * (from + to);
        for _ in 0..60 {
            let (_, slope, curvature) = self.gap(theta);
            if (slope > 0.0) == rises_at_from {
                from = theta;
            } else {
                to = theta;
            }
            let newton = theta - slope / curvature;
            let next = if newton > from && newton < to { newton } else { 0.5 * (from + to) };
            // The gap is flat there: half of the digits are enough.
            if (next - theta).abs() < ROOT_STEP {
                return next;
            }
            theta = next;
        }
        theta
    }
}

/// The next multiple of an angle, (cosine, sine).
fn rotate(wave: (f64, f64), by: (f64, f64)) -> (f64, f64) {
    (wave.0 * by.0 - wave.1 * by.1, wave.1 * by.0 + wave.0 * by.1)
}

impl Roots {
    fn none(starts_pressed: bool) -> Self {
        Self { starts_pressed, count: 0, angles: [0.0; MOST_ROOTS] }
    }

    fn push(&mut self, angle: f64) {
        if self.count < MOST_ROOTS {
            self.angles[self.count] = angle;
            self.count += 1;
        }
    }

    fn ends_pressed(&self) -> bool {
        self.starts_pressed == self.count.is_multiple_of(2)
    }

    /// Whether the lines have the same pieces in the same order.
    fn is_like(&self, other: &Self) -> bool {
        self.count == other.count && self.starts_pressed == other.starts_pressed
    }

    /// Square of the smallest distance of two neighbouring roots. Where two roots are about to meet, it goes to zero in
    /// proportion to the distance in radius.
    fn nearness(&self) -> f64 {
        let distances = self.angles[..self.count].windows(2).map(|pair| pair[1] - pair[0]);
        let nearest = distances.fold(f64::INFINITY, f64::min);
        nearest * nearest
    }
}

/// The state of the patch that is being integrated.
struct Survey<'a> {
    region: &'a PressedRegion,
    pad: PadPosition,
    amplitudes: &'a [f64],
}

/// Where the radius is cut, ends of the pad included, in ascending order.
struct Cuts {
    count: usize,
    radii: [f64; MOST_CUTS],
}

impl Cuts {
    fn push(&mut self, r: f64) {
        if self.count < MOST_CUTS {
            self.radii[self.count] = r;
            self.count += 1;
        }
    }
}

impl PressedRegion {
    /// `radial` points between two cuts of the radius, `angular` points on each piece of a line.
    pub fn new(
        modes: &[PlateMode],
        (inner, thickness, half_angle): (f64, f64, f64),
        radial: usize,
        angular: usize,
    ) -> Self {
        let harmonics: Vec<usize> = modes.iter().map(|mode| mode.nodal_diameters as usize).collect();
        let most_waves = harmonics.iter().copied().max().unwrap_or(0);
        let mut region = Self {
            inner,
            thickness,
            half_angle,
            odd_modes: (0..modes.len()).filter(|&mode| harmonics[mode] > 0).collect(),
            harmonic_count: most_waves + 1,
            radius_ratio: modes.first().map_or(0.0, PlateMode::radius_ratio),
            coefficients: coefficients(modes),
            probes: Vec::new(),
            samples: Vec::new(),
            radial_rules: [radial, 3 * radial / 4, radial / 2].map(gauss_legendre),
            angular_rule: gauss_legendre(angular),
            harmonics,
        };
        let share = |i: usize| i as f64 / PROBE_INTERVALS as f64;
        region.probes = (0..=PROBE_INTERVALS).map(|i| region.at(inner + (1.0 - inner) * share(i))).collect();
        // Half a radian of the shortest wave at the most.
        let intervals = ((4.0 * most_waves as f64 * half_angle).ceil() as usize).max(8);
        let sample = |i: usize| {
            let theta = half_angle * (2.0 * i as f64 / intervals as f64 - 1.0);
            let wave = |n: usize| (libm::cos(n as f64 * theta), libm::sin(n as f64 * theta));
            SampleAngle { theta, waves: (0..=most_waves).map(wave).collect() }
        };
        region.samples = (0..=intervals).map(sample).collect();
        region
    }

    fn at(&self, r: f64) -> Radius {
        let functions = RadialFunctions::at(r, self.radius_ratio);
        let (mut shapes, modes) = ([0.0; MOST_DISC_MODES], self.harmonics.len());
        for (function, coefficients) in functions.values().zip(&self.coefficients) {
            for (shape, coefficient) in shapes[..modes].iter_mut().zip(coefficients) {
                *shape += coefficient * function;
            }
        }
        Radius { r, shapes }
    }

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
    fn line(&self, radius: Radius) -> Line {
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
        Line { radius, waves, count: region.harmonic_count, tilt: radius.r * self.pad.tilt / region.thickness }
    }

    /// The roots of the gap on a line: sought between sample angles, and about an extremum between two of them. Not
    /// `refined`, they only count.
    fn roots(&self, line: &Line, refined: bool) -> Roots {
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
                // An extremum towards zero. It lies on the near side of where the tangents meet, if that is not beyond 0.
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

    fn roots_at(&self, r: f64) -> Roots {
        self.roots(&self.line(self.region.at(r)), true)
    }

    fn count_at(&self, r: f64) -> usize {
        self.roots(&self.line(self.region.at(r)), false).count
    }

    /// The gap at an end of the line at a radius.
    fn gap_at_end(&self, r: f64, end: &SampleAngle) -> f64 {
        self.line(self.region.at(r)).gap_at_sample(end).0
    }

    /// Where the pieces of the lines change along the radius; `None` if every probe presses everywhere.
    fn cuts(&self) -> Option<Cuts> {
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

    /// The cuts between two probes with different pieces: first those where the edge of the pressed region leaves the patch
    /// at an end of the lines, then, between them, those where it touches a line.
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

    /// The radius between two at which the gap at an end of the lines vanishes: the secant of a bracket, with the Illinois
    /// rule.
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

    /// The radius between two at which roots meet, and lines have fewer of them beyond. The square of the distance of two
    /// roots is nearly linear in the radius; each prediction of its zero is approached by nine tenths, from the side where
    /// the roots are.
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
                if (predicted - last).abs() < resolution {
                    return predicted;
                }
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
        let per_radius = self.region.thickness / line.radius.r;
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
                arc: line.radius.r * theta / self.region.thickness,
                waves: &waves[..line.count],
            };
            visitor.node(&node, &line.radius);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::flexible_disc::contact::{ContactLoads, ContactPatch, sufficient_points};
    use crate::rigid_disc::pad_on_disc::{PadOnDisc, uniform_draws};

    fn modes() -> Vec<PlateMode> {
        let plate = PadOnDisc::preset_with(&[]).annular_plate();
        (0..5).flat_map(|n| plate.modes(n, 1).unwrap()).collect()
    }

    fn patch(half_angle: f64, points: usize) -> ContactPatch {
        let brake = PadOnDisc::preset_with(&[("pad.half_angle", half_angle)]);
        let (radial, angular) = sufficient_points(brake.parameters(), &modes());
        ContactPatch::new(brake.parameters(), &modes(), points * radial, points * angular)
    }

    /// States with the pad tilted and the disc bent, from a simple generator.
    fn state(seed: u64) -> (PadPosition, Vec<f64>) {
        let mut uniform = uniform_draws(seed);
        let mut draw = || uniform() - 0.5;
        let pad = PadPosition { normal: -0.01 * (draw() + 0.3), tilt: 4e-3 * draw() };
        (pad, (0..9).map(|_| 0.01 * draw()).collect())
    }

    /// Pressure, load and follower load on every amplitude by the midpoint rule with `points` points each way.
    fn brute_force(half_angle: f64, pad: PadPosition, amplitudes: &[f64], points: usize) -> Vec<f64> {
        let disc = &PadOnDisc::preset_with(&[]).parameters().clone();
        let modes = modes();
        let inner = disc.pad.inner_radius / disc.disc.outer_radius;
        let thickness = disc.disc.thickness / disc.disc.outer_radius;
        let at = |i: usize| (i as f64 + 0.5) / points as f64;
        let theta: Vec<f64> = (0..points).map(|i| half_angle * (2.0 * at(i) - 1.0)).collect();
        let waves: Vec<[(f64, f64); 5]> =
            theta.iter().map(|t| [0.0, 1.0, 2.0, 3.0, 4.0].map(|n| (libm::cos(n * t), libm::sin(n * t)))).collect();
        let mut sums = vec![0.0; 19];
        for i in 0..points {
            let r = inner + (1.0 - inner) * at(i);
            let shapes: Vec<f64> = modes.iter().map(|mode| mode.shape(r)).collect();
            let a: Vec<f64> = (0..5).map(|n| shapes[n] * amplitudes[n]).collect();
            let b: Vec<f64> = (0..5).map(|n| if n > 0 { shapes[n] * amplitudes[4 + n] } else { 0.0 }).collect();
            let weight = r * 2.0 / ((1.0 + inner) * (points * points) as f64);
            let mut line = [0.0; 19];
            for (theta, waves) in theta.iter().zip(&waves) {
                let (mut gap, mut slope) = (-pad.normal - r / thickness * theta * pad.tilt, 0.0);
                for n in 0..5 {
                    gap += a[n] * waves[n].0 + b[n] * waves[n].1;
                    slope += n as f64 * (b[n] * waves[n].0 - a[n] * waves[n].1);
                }
                if gap > 0.0 {
                    let share = weight * gap;
                    let follower = share * slope * thickness / r;
                    line[0] += share;
                    for n in 0..5 {
                        line[1 + n] += share * waves[n].0;
                        line[10 + n] += follower * waves[n].0;
                    }
                    for n in 1..5 {
                        line[5 + n] += share * waves[n].1;
                        line[14 + n] += follower * waves[n].1;
                    }
                }
            }
            sums[0] += line[0];
            for k in 0..9 {
                let shape = shapes[if k < 5 { k } else { k - 4 }];
                sums[1 + k] += shape * line[1 + k];
                sums[10 + k] += shape * line[10 + k];
            }
        }
        sums
    }

    fn loads(patch: &ContactPatch, pad: PadPosition, amplitudes: &[f64]) -> Vec<f64> {
        let mut loads = ContactLoads::zero();
        patch.loads_of_pressed_part(pad, amplitudes, &mut loads);
        let on_modes = loads.on_modes[..9].iter();
        [loads.pressure].iter().chain(on_modes).chain(&loads.follower[..9]).copied().collect()
    }

    fn error(found: &[f64], exact: &[f64]) -> (f64, f64) {
        let part = |range: std::ops::Range<usize>| {
            // Nothing is compared where nothing presses.
            let scale = exact[range.clone()].iter().fold(1e-300_f64, |m, v| m.max(v.abs()));
            range.map(|k| (found[k] - exact[k]).abs() / scale).fold(0.0, f64::max)
        };
        (part(0..10), part(10..19))
    }

    /// The midpoint rule, extrapolated: its error falls with the square of the distance of the points.
    fn reference(half_angle: f64, pad: PadPosition, amplitudes: &[f64]) -> Vec<f64> {
        let [coarse, fine] = [500, 1000].map(|points| brute_force(half_angle, pad, amplitudes, points));
        coarse.iter().zip(&fine).map(|(coarse, fine)| fine + (fine - coarse) / 3.0).collect()
    }

    #[test]
    fn loads_agree_with_the_midpoint_rule() {
        // Seeds 1, 2 and 7: the edge runs from one end of the lines to the other, 13 and 21: from an end to a radius, 3 and
        // 10: a corner has lifted off. The extrapolated midpoint rule itself is good to some 1e-6.
        let mut partly = 0;
        for half_angle in [0.5, 1.5] {
            let patch = patch(half_angle, 1);
            for seed in [1, 2, 3, 7, 10, 13, 17, 21] {
                let (pad, amplitudes) = state(seed);
                let share = patch.contact_share(pad, &amplitudes);
                partly += u32::from(share > 0.1 && share < 0.99);
                let error = error(&loads(&patch, pad, &amplitudes), &reference(half_angle, pad, &amplitudes));
                assert!(error.0 < 3e-6 && error.1 < 1e-5, "{half_angle} {seed}: {share} {error:?}");
            }
        }
        assert!(partly > 12, "{partly}");
    }

    #[test]
    fn twice_the_points_change_little() {
        let mut typical = 0;
        for half_angle in [0.5, 1.5] {
            let [patch, fine] = [1, 2].map(|points| patch(half_angle, points));
            for seed in 1..100 {
                let (pad, amplitudes) = state(seed);
                let error = error(&loads(&patch, pad, &amplitudes), &loads(&fine, pad, &amplitudes));
                typical += u32::from(error.0 < 1e-7);
                // The worst are edges that turn sharply between two lines, and islands that no probe line meets.
                assert!(error.0.max(error.1) < 3e-4, "{half_angle} {seed}: {error:?}");
            }
        }
        assert!(typical > 150, "{typical}");
    }

    #[test]
    fn loads_are_continuous_where_the_patch_begins_to_lift_off() {
        // What remains is what the rule for the whole patch misses.
        let patch = patch(0.5, 1);
        for seed in 1..20 {
            let (mut pad, amplitudes) = state(seed);
            let share = |normal: f64| patch.contact_share(PadPosition { normal, ..pad }, &amplitudes);
            let (mut whole, mut partly) = (-1.0, 1.0);
            for _ in 0..100 {
                let middle = 0.5 * (whole + partly);
                if share(middle) > 1.0 - 1e-15 { whole = middle } else { partly = middle }
            }
            pad.normal = whole;
            let before = loads(&patch, pad, &amplitudes);
            pad.normal = partly + 1e-12;
            let error = error(&loads(&patch, pad, &amplitudes), &before);
            assert!(error.0 < 1e-6 && error.1 < 1e-5, "{seed}: {error:?}");
        }
    }
}
