//! The gap on one line of constant radius, and where it changes its sign.

use crate::models::pad_on_disc::flexible_disc::plate_modes::MOST_REFERENCE_MODES;
use crate::numerics::sine_cosine::sine_and_cosine;

/// Harmonics in the angle, n = 0 included.
pub(crate) const MOST_HARMONICS: usize = MOST_REFERENCE_MODES;

/// Largest number of roots of the gap on one line: more than the harmonics and the linear term can make on most pads.
/// What is beyond is left out.
const MOST_ROOTS: usize = 2 * MOST_HARMONICS + 2;

/// Last step of Newton's method, in radians; its square is what is left.
const ROOT_STEP: f64 = 1e-7;

/// A radius with the radial shapes of the modes.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Radius {
    pub r: f64,
    pub shapes: [f64; MOST_REFERENCE_MODES],
}

/// An angle at which the gap of every line is evaluated.
#[derive(Debug, Clone)]
pub(super) struct SampleAngle {
    pub theta: f64,
    /// Cosine and sine of `n theta`.
    pub waves: Vec<(f64, f64)>,
}

/// The gap on one line of constant radius.
pub(super) struct Line {
    pub radius: Radius,
    /// A_n; -y is in the first. And B_n.
    pub waves: [(f64, f64); MOST_HARMONICS],
    pub count: usize,
    /// r tan(phi), over h.
    pub tilt: f64,
}

/// Where the gap of a line changes its sign.
pub(super) struct Roots {
    pub starts_pressed: bool,
    pub count: usize,
    pub angles: [f64; MOST_ROOTS],
}

impl Line {
    /// The gap with its first two derivatives by the angle.
    pub fn gap(&self, theta: f64) -> (f64, f64, f64) {
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

    pub fn gap_at_sample(&self, sample: &SampleAngle) -> (f64, f64) {
        let (mut gap, mut first, mut n) = (-self.tilt * sample.theta, -self.tilt, 0.0);
        for (&(a, b), wave) in self.waves[..self.count].iter().zip(&sample.waves) {
            gap += a * wave.0 + b * wave.1;
            first += n * (b * wave.0 - a * wave.1);
            n += 1.0;
        }
        (gap, first)
    }

    /// The mean of the gap's bounds, and half of their distance.
    pub fn bounds(&self, half_angle: f64) -> (f64, f64) {
        let swing: f64 = self.waves[1..self.count].iter().map(|(a, b)| a.abs() + b.abs()).sum();
        (self.waves[0].0, swing + self.tilt.abs() * half_angle)
    }

    /// The root between two angles of which one presses and the other does not: Newton's method from where the chord of
    /// the gaps vanishes, kept between them.
    pub fn root(&self, from: (f64, f64), to: (f64, f64)) -> f64 {
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
    pub fn extremum(&self, (mut from, mut to): (f64, f64), rises_at_from: bool) -> f64 {
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
pub(super) fn rotate(wave: (f64, f64), by: (f64, f64)) -> (f64, f64) {
    (wave.0 * by.0 - wave.1 * by.1, wave.1 * by.0 + wave.0 * by.1)
}

impl Roots {
    pub fn none(starts_pressed: bool) -> Self {
        Self { starts_pressed, count: 0, angles: [0.0; MOST_ROOTS] }
    }

    pub fn push(&mut self, angle: f64) {
        if self.count < MOST_ROOTS {
            self.angles[self.count] = angle;
            self.count += 1;
        }
    }

    pub fn ends_pressed(&self) -> bool {
        self.starts_pressed == self.count.is_multiple_of(2)
    }

    /// Whether the lines have the same pieces in the same order.
    pub fn is_like(&self, other: &Self) -> bool {
        self.count == other.count && self.starts_pressed == other.starts_pressed
    }

    /// Square of the smallest distance of two neighbouring roots. Where two roots are about to meet, it goes to zero in
    /// proportion to the distance in radius.
    pub fn nearness(&self) -> f64 {
        let distances = self.angles[..self.count].windows(2).map(|pair| pair[1] - pair[0]);
        let nearest = distances.fold(f64::INFINITY, f64::min);
        nearest * nearest
    }
}
