//! A friction law with its coefficients.

use crate::friction::measured_curve::{NOTHING, Piece, SharedCurve};
use crate::friction::shape::Shape;
use crate::numerics::root_location::bisect;

/// A friction law without its values.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum LawKind {
    /// `f_c + (f_s - f_c) exp(-(|v| / v_s)^delta)`, with a viscous term.
    Stribeck,
    /// `f_c + (f_s - f_c) / (1 + |v| / v_s)`, with a viscous term.
    Rational,
    /// A measured curve, scaled by the static friction coefficient.
    Table(SharedCurve),
}

impl LawKind {
    /// Its name in a job.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Stribeck => "stribeck",
            Self::Rational => "rational",
            Self::Table(_) => "table",
        }
    }

    /// The measured curve, if it is one.
    #[must_use]
    pub fn table(&self) -> Option<&SharedCurve> {
        match self {
            Self::Table(curve) => Some(curve),
            Self::Stribeck | Self::Rational => None,
        }
    }
}

/// Bisections to the last digits of any speed, at most.
const MOST_HALVINGS: usize = 200;

/// A friction law: the coefficient of friction over the sliding speed, [`crate::friction`].
///
/// ```text
/// mu(v) = f_c + (f_s - f_c) a(|v| / v_s) + e b(|v| / v_s)
/// ```
///
/// For Stribeck's law (the paper's equation 2.6 with the sign of its exponent corrected) `a(r) = exp(-r^delta)`. Speeds
/// and the speed scale `v_s` share a unit; inside this crate they are scaled speeds.
///
/// ```
/// use stickslip_core::friction::law::FrictionLaw;
/// let law = FrictionLaw::stribeck(0.39, 0.25, 0.72, 1.0);
/// assert_eq!(law.coefficient(0.0), 0.39);
/// assert!((law.coefficient(0.72) - (0.25 + 0.14 / std::f64::consts::E)).abs() < 1e-15);
/// ```
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FrictionLaw {
    /// f_s; the coefficient at rest is [`FrictionLaw::at_rest`].
    pub static_coefficient: f64,
    /// f_c, the limit of the falling part at high sliding speed; 0 for a table.
    pub kinetic_coefficient: f64,
    /// e: the viscous friction at the Stribeck velocity, or the number of standard deviations by which a measured curve
    /// is shifted.
    pub additional: f64,
    /// v_s > 0, the Stribeck velocity; for a table 1 m/s.
    pub speed_scale: f64,
    /// delta > 0 of Stribeck's law; 1 is Tustin's law, 2 the Gaussian one.
    pub exponent: f64,
    pub(crate) shape: Shape,
}

impl FrictionLaw {
    /// Stribeck's law without a viscous term.
    #[must_use]
    pub fn stribeck(static_coefficient: f64, kinetic_coefficient: f64, stribeck_velocity: f64, exponent: f64) -> Self {
        Self {
            static_coefficient,
            kinetic_coefficient,
            additional: 0.0,
            speed_scale: stribeck_velocity,
            exponent,
            shape: Shape::of_stribeck(exponent),
        }
    }

    /// The rational law without a viscous term.
    #[must_use]
    pub fn rational(static_coefficient: f64, kinetic_coefficient: f64, stribeck_velocity: f64) -> Self {
        let law = Self::stribeck(static_coefficient, kinetic_coefficient, stribeck_velocity, 1.0);
        Self { shape: Shape::Rational, ..law }
    }

    /// A measured curve with its value at rest changed to `static_coefficient`, where `metre_per_second` is the speed 1
    /// m/s in the unit of speeds.
    #[must_use]
    pub fn table(curve: SharedCurve, static_coefficient: f64, metre_per_second: f64) -> Self {
        let law = Self::stribeck(static_coefficient, 0.0, metre_per_second, 1.0);
        Self { shape: Shape::Table(curve), ..law }
    }

    /// The same with another additional term e.
    #[must_use]
    pub fn with_additional(self, additional: f64) -> Self {
        Self { additional, ..self }
    }

    /// The same with another static coefficient f_s, such as that of a sample.
    pub(crate) fn with_static(self, static_coefficient: f64) -> Self {
        Self { static_coefficient, ..self }
    }

    /// The law of a force: all coefficients multiplied.
    pub(crate) fn times(self, factor: f64) -> Self {
        Self {
            static_coefficient: factor * self.static_coefficient,
            kinetic_coefficient: factor * self.kinetic_coefficient,
            additional: factor * self.additional,
            ..self
        }
    }

    /// The friction coefficient mu at sliding speed `speed` (either sign).
    #[must_use]
    pub fn coefficient(&self, speed: f64) -> f64 {
        let r = speed.abs() / self.speed_scale;
        let (a, b) = self.parts(r);
        self.kinetic_coefficient + self.falling() * a + self.additional * b
    }

    /// The parts a and b of the law at r, by the mathematics of `libm`.
    fn parts(&self, r: f64) -> (f64, f64) {
        match self.shape {
            Shape::Tustin | Shape::Gaussian | Shape::Stribeck => (libm::exp(-self.power(r)), r),
            Shape::Rational => (1.0 / (1.0 + r), r),
            Shape::Table(curve) => curve.values(r),
        }
    }

    /// `r^delta`.
    fn power(&self, r: f64) -> f64 {
        if self.exponent == 1.0 { r } else { libm::pow(r, self.exponent) }
    }

    /// mu at rest: f_s, for a shifted curve with its shift there.
    #[must_use]
    pub fn at_rest(&self) -> f64 {
        self.static_coefficient + self.additional_at_rest()
    }

    /// e b(0).
    pub(crate) fn additional_at_rest(&self) -> f64 {
        match self.shape {
            Shape::Table(curve) => self.additional * curve.values(0.0).1,
            _ => 0.0,
        }
    }

    /// The static friction coefficient below which a sample that slides steadily at this speed is outside physics: f_c, or
    /// what leaves a measured curve without friction at rest or at this speed. Above it the other laws have friction at
    /// every speed, as neither f_c nor the viscous term is below 0.
    #[must_use]
    pub fn least_static_coefficient(&self, speed: f64) -> f64 {
        match self.shape {
            Shape::Table(curve) => curve.least_at_rest(speed / self.speed_scale, self.additional),
            _ => self.kinetic_coefficient,
        }
    }

    /// The ranges of sliding speed at which the coefficient is at or below 0, in rising order; only a measured curve has
    /// some. What it has after its last row goes on to infinity.
    #[must_use]
    pub fn without_friction(&self) -> Vec<[f64; 2]> {
        let mut ranges: Vec<[f64; 2]> = Vec::new();
        let Shape::Table(curve) = self.shape else { return ranges };
        if curve.lower_bound(self.falling(), self.additional) > NOTHING {
            return ranges;
        }
        let mut last = 0.0;
        for piece in self.pieces() {
            let has_none = |speed: f64| piece.value(speed) <= NOTHING;
            // Between its ends and the speeds at which it turns, a cubic rises or falls.
            let mut from = piece.from;
            for to in piece.speeds_of_slope(0.0).into_iter().chain([piece.to]) {
                let range = match [from, to].map(has_none) {
                    [false, false] => None,
                    [true, true] => Some([from, to]),
                    [false, true] => Some([bisect((from, to), MOST_HALVINGS, 1e-15, |at| !has_none(at)).1, to]),
                    [true, false] => Some([from, bisect((from, to), MOST_HALVINGS, 1e-15, has_none).0]),
                };
                match (range, ranges.last_mut()) {
                    (Some([from, to]), Some(before)) if before[1] >= from => before[1] = to,
                    (Some(range), _) => ranges.push(range),
                    (None, _) => {}
                }
                from = to;
            }
            last = piece.to;
        }
        if let Some(range) = ranges.last_mut().filter(|range| range[1] >= last) {
            range[1] = f64::INFINITY;
        }
        ranges.into_iter().map(|range| range.map(|speed| speed * self.speed_scale)).collect()
    }

    /// The next sliding speeds below and above this one at which the coefficient is at or below 0; infinite where there is
    /// none.
    pub(crate) fn positive_about(&self, speed: f64) -> [f64; 2] {
        let everywhere = [f64::NEG_INFINITY, f64::INFINITY];
        self.without_friction().into_iter().fold(everywhere, |[below, above], [from, to]| {
            if from >= speed { [below, above.min(from)] } else { [to.min(speed), above] }
        })
    }

    /// `f_s - f_c`.
    pub(crate) fn falling(&self) -> f64 {
        self.static_coefficient - self.kinetic_coefficient
    }

    /// The fall of friction with speed, per unit of `f_s - f_c` and without the additional term; for Stribeck's law
    ///
    /// ```text
    /// w(v) = (delta / v_s) (v / v_s)^(delta - 1) exp(-(v / v_s)^delta)
    /// d mu / d v = -(f_s - f_c) w(v) + rise(v)
    /// ```
    ///
    /// It does not depend on the friction coefficients; where a measured curve rises it is negative. `speed` > 0; for
    /// exponents below 1 it grows without bound towards zero speed.
    pub(crate) fn weakening(&self, speed: f64) -> f64 {
        let r = speed / self.speed_scale;
        match self.shape {
            Shape::Rational => 1.0 / ((1.0 + r) * (1.0 + r)) / self.speed_scale,
            Shape::Table(curve) => -curve.slopes(r).0 / self.speed_scale,
            Shape::Tustin | Shape::Gaussian | Shape::Stribeck => {
                let power = self.power(r);
                let decay = libm::exp(-power);
                if self.exponent == 1.0 {
                    decay / self.speed_scale
                } else if decay == 0.0 {
                    0.0
                } else {
                    self.exponent * power / speed * decay
                }
            }
        }
    }

    /// The rise of the additional term with speed.
    pub(crate) fn rise(&self, speed: f64) -> f64 {
        match self.shape {
            Shape::Table(curve) => self.additional * curve.slopes(speed / self.speed_scale).1 / self.speed_scale,
            _ => self.additional / self.speed_scale,
        }
    }

    /// How steeply friction falls at a sliding speed, `-d mu / d v`.
    pub(crate) fn fall(&self, speed: f64) -> f64 {
        let falling = self.falling();
        // Without a fall there is nothing to multiply a slope with that may be infinite.
        let fall = if falling == 0.0 { 0.0 } else { falling * self.weakening(speed) };
        fall - self.rise(speed)
    }

    /// `d^2 mu / d v^2` of Stribeck's law at a sliding speed above 0.
    pub(crate) fn curvature(&self, speed: f64) -> f64 {
        let power = self.power(speed / self.speed_scale);
        let bend = self.exponent * power * (self.exponent * power - self.exponent + 1.0);
        self.falling() * bend * libm::exp(-power) / (speed * speed)
    }

    /// How far friction falls, and the scale of speed on which it does: `f_s - f_c` and v_s; of a measured curve the
    /// distance between its largest and smallest value, and the speed of its first row beyond rest.
    pub(crate) fn drop_and_width(&self) -> (f64, f64) {
        let Some(first) = self.pieces().next() else { return (self.falling(), self.speed_scale) };
        let ends = self.pieces().flat_map(|piece| [piece.from, piece.to]);
        let values = ends.map(|speed| self.coefficient(speed * self.speed_scale));
        let (least, most) =
            values.fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), mu| (mu.min(low), mu.max(high)));
        (most - least, first.to * self.speed_scale)
    }

    /// Whether all derivatives of mu but those of the viscous term alternate in sign: Stribeck's law with exponents up
    /// to 1, and the rational law. The first one is negative if `f_s > f_c`; otherwise nothing falls.
    pub(crate) fn is_completely_monotone(&self) -> bool {
        match self.shape {
            Shape::Tustin | Shape::Gaussian | Shape::Stribeck => self.exponent <= 1.0,
            Shape::Rational => true,
            Shape::Table(_) => false,
        }
    }

    /// Whether it falls infinitely steeply at rest.
    pub(crate) fn is_infinitely_steep_at_rest(&self) -> bool {
        self.shape == Shape::Stribeck && self.exponent < 1.0 && self.falling() > 0.0
    }

    /// Whether it is a measured curve.
    pub(crate) fn is_table(&self) -> bool {
        matches!(self.shape, Shape::Table(_))
    }

    /// Whether friction surely falls at no speed.
    pub(crate) fn never_falls(&self) -> bool {
        !self.is_table() && self.falling() <= 0.0
    }

    /// The speed in `from..=to` at which friction falls most steeply, for `f_s >= f_c`; `from` > 0.
    ///
    /// For the rational law and for exponents up to 1 the slope falls with speed; for exponents above 1 it has its
    /// crest at `v_s (1 - 1 / delta)^(1 / delta)`. On a table each cubic has one of its own.
    pub(crate) fn steepest_between(&self, from: f64, to: f64) -> f64 {
        match self.shape {
            Shape::Table(_) => self
                .pieces_between(from, to)
                .map(|piece| {
                    let ends = (from / self.speed_scale, to / self.speed_scale);
                    let steepest = piece.steepest_fall(ends.0.max(piece.from), ends.1.min(piece.to));
                    (steepest * self.speed_scale).clamp(from, to)
                })
                .fold(to, |best, speed| if self.fall(speed) > self.fall(best) { speed } else { best }),
            Shape::Stribeck | Shape::Gaussian if self.exponent > 1.0 => {
                let crest = libm::pow(1.0 - 1.0 / self.exponent, 1.0 / self.exponent);
                (self.speed_scale * crest).clamp(from, to)
            }
            _ => from,
        }
    }

    /// The largest sliding speed below `v` at which friction may fall more steeply than `steep`, and the least friction
    /// at speeds up to there; of a measured curve, the end of the cubic. Nothing where it does not.
    ///
    /// `last` finds the speed in a bracket between one where it does and one where it does not.
    pub(crate) fn last_steeper_than(
        &self,
        steep: f64,
        v: f64,
        last: impl FnOnce((f64, f64)) -> f64,
    ) -> Option<(f64, f64)> {
        if self.is_table() {
            let pieces = self.pieces_between(0.0, v);
            let piece = pieces.clone().filter(|piece| {
                let at = piece.steepest_fall(piece.from, piece.to);
                -piece.slope(at) > steep * self.speed_scale
            });
            let to = piece.map(|piece| piece.to).last()?;
            let least = pieces.filter(|piece| piece.to <= to).map(|piece| piece.bounds(piece.from, piece.to).0);
            return Some(((to * self.speed_scale).min(v), least.fold(f64::INFINITY, f64::min)));
        }
        let steepest = self.steepest_between(1e-9 * v, v);
        if self.falling() <= 0.0 || self.fall(steepest) <= steep {
            return None;
        }
        let sliding = if self.fall(v) > steep { v } else { last((steepest, v)) };
        Some((sliding, self.coefficient(sliding)))
    }

    /// The cubics of a table, over r; those of other laws are none.
    pub(crate) fn pieces(&self) -> impl Iterator<Item = Piece> + Clone + use<> {
        self.pieces_between(0.0, f64::INFINITY)
    }

    /// Those that reach into the sliding speeds between two.
    pub(crate) fn pieces_between(&self, from: f64, to: f64) -> impl Iterator<Item = Piece> + Clone + use<> {
        let (ends, parts) = ([from, to].map(|speed| speed / self.speed_scale), (self.falling(), self.additional));
        self.curve().into_iter().flat_map(move |curve| curve.pieces_between(ends, parts))
    }

    /// The sliding speeds between two at which a table has a knot, in rising order.
    pub(crate) fn knots_between(&self, from: f64, to: f64) -> impl DoubleEndedIterator<Item = f64> + Clone + use<> {
        let scale = self.speed_scale;
        let knots = self.curve().map(|curve| curve.knots_between(from / scale, to / scale));
        knots.into_iter().flatten().map(move |knot| knot * scale)
    }

    fn curve(&self) -> Option<SharedCurve> {
        match self.shape {
            Shape::Table(curve) => Some(curve),
            _ => None,
        }
    }

    /// An upper bound, exact for convex curves, of `[mu(v - u) - mu(v)] / u` over all `0 < |u| <= reach`: what friction
    /// takes away at most, per unit of speed, from the damping of a motion with speeds up to `reach` on a disc of speed
    /// `v` > `reach`.
    pub(crate) fn steepest_chord(&self, v: f64, reach: f64) -> f64 {
        if let Shape::Table(_) = self.shape {
            return self.steepest_chord_of_table(v, reach);
        }
        let steepest = self.steepest_between(v - reach, v + reach);
        if steepest <= v - reach && reach > 1e-6 * v {
            // The curve is convex there, and the chord to its upper end the steepest.
            (self.coefficient(v - reach) - self.coefficient(v)) / reach
        } else {
            self.falling() * self.weakening(steepest) - self.rise(steepest)
        }
    }

    /// From knot to knot the chord is bounded in two ways: by the steepest slope from v to the farther one, and by the
    /// largest or smallest value of the cubic, which is monotone between them, over its distance.
    fn steepest_chord_of_table(&self, v: f64, reach: f64) -> f64 {
        let at_v = self.coefficient(v);
        let towards = |knots: &mut dyn Iterator<Item = f64>, end: f64| {
            let (mut near, mut slope, mut most) = (v, f64::NEG_INFINITY, f64::NEG_INFINITY);
            for far in knots.chain([end]) {
                slope = slope.max(self.fall(self.steepest_between(near.min(far), near.max(far))));
                // A shifted curve need not be monotone between its knots: by its slopes only.
                let by_value = if self.additional != 0.0 || near == v {
                    f64::INFINITY
                } else {
                    let values = [self.coefficient(near), self.coefficient(far)];
                    let drop = if far < v { values[0].max(values[1]) - at_v } else { at_v - values[0].min(values[1]) };
                    drop / (v - if drop > 0.0 { near } else { far }).abs()
                };
                most = most.max(slope.min(by_value));
                near = far;
            }
            most
        };
        let below = towards(&mut self.knots_between(v - reach, v).rev(), v - reach);
        below.max(towards(&mut self.knots_between(v, v + reach), v + reach))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::friction::measured_curve::MeasuredCurve;

    fn law(exponent: f64) -> FrictionLaw {
        FrictionLaw::stribeck(0.4, 0.25, 0.7, exponent)
    }

    #[test]
    fn the_coefficient_falls_from_static_to_kinetic() {
        for exponent in [0.5, 1.0, 2.0, 3.7] {
            let law = law(exponent);
            assert_eq!(law.coefficient(0.0), 0.4);
            assert!((law.coefficient(1e9) - 0.25).abs() < 1e-15);
            assert_eq!(law.coefficient(-0.3), law.coefficient(0.3));
            let curve: Vec<f64> = (0..100).map(|i| law.coefficient(0.05 * f64::from(i))).collect();
            assert!(curve.windows(2).all(|pair| pair[1] <= pair[0]), "exponent {exponent}");
        }
    }

    #[test]
    fn weakening_is_the_slope_of_the_coefficient() {
        for exponent in [0.5, 1.0, 2.0, 3.7] {
            let law = law(exponent);
            for speed in [0.01, 0.1, 0.7, 1.3, 2.0] {
                let step = 1e-5 * speed;
                let slope = (law.coefficient(speed + step) - law.coefficient(speed - step)) / (2.0 * step);
                let expected = -0.15 * law.weakening(speed);
                assert!(
                    (slope - expected).abs() < 1e-7 * (1.0 + expected.abs()),
                    "{exponent} {speed}: {slope} {expected}"
                );
            }
        }
    }

    #[test]
    fn nothing_in_a_range_is_steeper_than_the_steepest() {
        for exponent in [0.5, 1.0, 1.3, 2.0, 3.7] {
            let law = law(exponent);
            for (from, to) in [(0.01, 3.0), (0.6, 0.8), (1.0, 3.0), (0.01, 0.1)] {
                let steepest = law.weakening(law.steepest_between(from, to));
                for i in 0..=1000 {
                    let speed = from + (to - from) * f64::from(i) / 1000.0;
                    assert!(law.weakening(speed) <= steepest * (1.0 + 1e-12), "{exponent} {from} {to} {speed}");
                }
            }
        }
    }

    /// Rows at 0, 1, ... m/s, shifted down by a tenth of `shift`. The unit of speed is 0.5 m/s.
    fn shifted_down(coefficients: &[f64], shift: f64) -> FrictionLaw {
        let speeds: Vec<f64> = (0_u8..).map(f64::from).take(coefficients.len()).collect();
        let deviations = vec![0.1; coefficients.len()];
        let curve = MeasuredCurve::new(&speeds, coefficients, Some(&deviations)).unwrap();
        FrictionLaw::table(SharedCurve::new(curve), coefficients[0], 2.0).with_additional(-shift)
    }

    #[test]
    fn no_chord_of_a_table_is_steeper_than_its_bound() {
        let flat_then_steep = [0.4, 0.39, 0.385, 0.38, 0.2, 0.1, 0.09];
        let mut tightened = 0;
        for (coefficients, shift) in [
            (&[0.4, 0.1, 0.3, 0.15, 0.35, 0.2][..], 0.0),
            (&[0.4, 0.1, 0.3, 0.15, 0.35, 0.2], 1.5),
            (&[0.2, 0.3, 0.35, 0.2, 0.25, 0.1], -0.5),
            (&flat_then_steep, 0.0),
        ] {
            let law = shifted_down(coefficients, shift);
            for (v, reach) in [(3.0, 2.9), (3.1, 0.02), (6.3, 6.1), (9.0, 8.5), (4.0, 2.0), (2.0, 1.5), (30.0, 5.0)] {
                let (bound, at_v) = (law.steepest_chord(v, reach), law.coefficient(v));
                let chords = (1..=2000).flat_map(|i| {
                    let u = reach * f64::from(i) / 2000.0;
                    [u, -u].map(|u| (law.coefficient(v - u) - at_v) / u)
                });
                let steepest = chords.fold(f64::NEG_INFINITY, f64::max);
                let fall = law.fall(law.steepest_between(v - reach, v + reach));
                assert!(bound >= steepest - 1e-12, "{coefficients:?} {v} {reach}: {bound} {steepest}");
                assert!(bound <= fall + 1e-15, "{coefficients:?} {v} {reach}: {bound} {fall}");
                tightened += usize::from(bound < 0.9 * fall);
            }
        }
        assert!(tightened >= 5, "{tightened}");
    }

    #[test]
    fn the_cubics_between_two_speeds_are_those_that_reach_there() {
        let law = shifted_down(&[0.4, 0.1, 0.3, 0.15, 0.35, 0.2], 0.5);
        for (from, to) in [(0.0, 20.0), (1.0, 1.5), (2.0, 4.0), (3.9, 4.1), (9.5, 30.0), (11.0, 12.0)] {
            let reaches = |piece: &Piece| 2.0 * piece.to > from && 2.0 * piece.from < to;
            let expected: Vec<Piece> = law.pieces().filter(reaches).collect();
            let found: Vec<Piece> = law.pieces_between(from, to).collect();
            assert_eq!(found, expected, "{from} {to}");
            let inside = [0.0, 2.0, 4.0, 6.0, 8.0, 10.0].into_iter().filter(|knot| from < *knot && *knot < to);
            assert!(inside.eq(law.knots_between(from, to)), "{from} {to}");
        }
    }

    #[test]
    fn the_ranges_without_friction_are_those_of_a_fine_grid() {
        for (coefficients, shift, count) in [
            (&[0.4, 0.2, 0.3, 0.1][..], 0.5, 0),
            (&[0.4, 0.2, 0.3, 0.1][..], 2.2, 2),
            (&[0.4, 0.1, 0.3, 0.15, 0.35][..], 1.7, 2),
            (&[0.4, 0.1, 0.3, 0.15, 0.35][..], 4.5, 1),
            (&[0.4, 0.0, 0.3][..], 0.0, 1),
        ] {
            let law = shifted_down(coefficients, shift);
            let ranges = law.without_friction();
            assert_eq!(ranges.len(), count, "{ranges:?}");
            for i in 0..600 {
                let speed = 0.02 * f64::from(i);
                let is_near = |[from, to]: &[f64; 2]| (from - speed).abs().min((to - speed).abs()) < 1e-5;
                let is_inside = ranges.iter().any(|[from, to]| *from <= speed && speed <= *to);
                assert!(is_inside == (law.coefficient(speed) <= 0.0) || ranges.iter().any(is_near), "{speed}");
                let expected = ranges.iter().filter(|range| range[1] < speed).map(|range| range[1]);
                let above = ranges.iter().filter(|range| range[0] > speed).map(|range| range[0]);
                if !is_inside {
                    let found = [expected.fold(f64::NEG_INFINITY, f64::max), above.fold(f64::INFINITY, f64::min)];
                    assert_eq!(law.positive_about(speed), found);
                }
            }
        }
        assert_eq!(law(1.0).without_friction(), Vec::<[f64; 2]>::new());
    }

    #[test]
    fn friction_vanishes_at_rest_or_at_the_speed_with_the_least_static_coefficient() {
        for (shift, speed) in [(1.3, 2.0), (2.7, 0.3), (-1.5, 1.0), (3.0, 50.0)] {
            let law = shifted_down(&[0.4, 0.1, 0.3, 0.15], shift);
            let least = law.least_static_coefficient(speed);
            let at = |static_coefficient: f64| {
                let law = law.with_static(static_coefficient);
                law.at_rest().min(law.coefficient(speed))
            };
            assert!(at(least).abs() < 2.0 * NOTHING, "{shift} {speed}");
            assert!(at(least + 1e-6) > 0.0 && at(least - 1e-6) < 0.0, "{shift} {speed}");
        }
        // Nothing gives friction at a row of 0 but a shift up.
        assert_eq!(shifted_down(&[0.4, 0.0, 0.3], 0.0).least_static_coefficient(2.0), f64::INFINITY);
        assert!(shifted_down(&[0.4, 0.0, 0.3], -1.0).least_static_coefficient(2.0) < 0.0);
        assert_eq!(law(1.0).least_static_coefficient(2.0), 0.25);
    }

    #[test]
    fn what_is_0_at_a_speed_is_below_the_least_static_coefficient_and_among_the_speeds_without_friction() {
        // 0.3 - 0.1 shift at 2 m/s, and the unshifted curve without any.
        for (shift, static_coefficient) in [(3.0, 0.4), (0.0, 0.0)] {
            let law = FrictionLaw { static_coefficient, ..shifted_down(&[0.4, 0.1, 0.3, 0.35], shift) };
            let speed = 4.0;
            assert!(law.coefficient(speed).abs() < 1e-15);
            assert!(static_coefficient < law.least_static_coefficient(speed), "{shift}");
            assert!(law.without_friction().iter().any(|[from, to]| *from <= speed && speed <= *to), "{shift}");
        }
    }

    #[test]
    fn weakening_vanishes_without_nan_at_extreme_speed() {
        for exponent in [0.5, 1.0, 2.0, 10.0] {
            assert_eq!(law(exponent).weakening(1e300), 0.0);
        }
    }
}
