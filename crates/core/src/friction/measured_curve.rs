//! A measured friction curve, interpolated monotonically.

use std::ops::Deref;
use std::sync::{Mutex, PoisonError};

use thiserror::Error;

use crate::numerics::monotone_cubic::monotone_slopes;
use crate::numerics::smoothing_spline::SmoothingSpline;

/// Largest number of rows.
pub const MOST_ROWS: usize = 1000;

/// Largest speed (m/s), and largest coefficient and standard deviation: beyond any brake, to catch wrong units.
pub const HIGHEST_SPEED: f64 = 1e3;
/// See [`HIGHEST_SPEED`].
pub const LARGEST_COEFFICIENT: f64 = 5.0;

/// Least distance of two speeds, relative to the higher one.
pub const LEAST_GAP: f64 = 1e-4;

/// Most cubics between two rows of a smoothed curve.
const FINER: usize = 8;

/// Least number of rows of a curve that is smoothed.
pub const LEAST_SMOOTHED: usize = 5;

/// A coefficient of no more than this is 0: a row of 0 is met but for rounding.
pub(crate) const NOTHING: f64 = 1e-12;

/// Places for rows in the arrays of a curve: a power of two, so that a mask keeps any index inside.
const PLACES: usize = 1024;
const PLACE: usize = PLACES - 1;

/// Why a measured curve was refused. Rows are counted from 0.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum CurveError {
    /// Fewer than two rows.
    #[error(
        "a friction curve needs at least two rows, and this one has {rows}; give the coefficient at two or more speeds"
    )]
    TooFewRows {
        /// How many there are.
        rows: usize,
    },
    /// Fewer than [`LEAST_SMOOTHED`] rows of a curve that is to be smoothed.
    #[error(
        "a friction curve that is smoothed needs at least {LEAST_SMOOTHED} rows, and this one has {rows}; give the coefficient at more speeds, or leave the smoothing out"
    )]
    TooFewToSmooth {
        /// How many there are.
        rows: usize,
    },
    /// More rows than [`MOST_ROWS`].
    #[error("{rows} rows are too many for a friction curve; the limit is {MOST_ROWS}")]
    TooManyRows {
        /// How many there are.
        rows: usize,
    },
    /// Columns of different lengths.
    #[error("there are {speeds} speeds but {values} values of {column}; give one for each speed")]
    UnequalColumns {
        /// Number of speeds.
        speeds: usize,
        /// Number of values in the other column.
        values: usize,
        /// The other column.
        column: &'static str,
    },
    /// A value outside its limits, or no number.
    #[error("{column} = {value} is out of range: it must be at least 0 and at most {largest}{unit}")]
    OutOfRange {
        /// Its row.
        row: usize,
        /// Its column.
        column: &'static str,
        /// The value.
        value: f64,
        /// The limit.
        largest: f64,
        /// Its unit in words.
        unit: &'static str,
    },
    /// Speeds that do not rise from row to row.
    #[error(
        "speed = {speed} does not exceed {before}, the speed of the row before; sort the rows by rising speed, and make one row of those with the same speed, for example with the mean of their coefficients"
    )]
    NotRising {
        /// The row of the smaller speed.
        row: usize,
        /// The speed there.
        speed: f64,
        /// The speed before.
        before: f64,
    },
    /// Speeds that are too near each other.
    #[error(
        "speed = {speed} is nearer than a ten-thousandth to {before}, the speed of the row before; make one row of the two"
    )]
    TooNear {
        /// The row of the higher speed.
        row: usize,
        /// The speed there.
        speed: f64,
        /// The speed before.
        before: f64,
    },
    /// A curve that begins without friction: there is nothing to scale it by.
    #[error(
        "coefficient = 0 at the lowest speed: the curve is scaled by the static friction coefficient over this value, so it must be positive"
    )]
    NothingAtRest,
}

/// What a smoothed curve was made of.
#[derive(Debug, Clone, PartialEq)]
pub struct Smoothing {
    /// The coefficients as measured.
    pub coefficients: Vec<f64>,
    /// Their standard deviations, if they were measured.
    pub deviations: Option<Vec<f64>>,
    /// Root mean square of what the coefficients differ by from the curve.
    pub residual: f64,
    /// The number of free parameters of the curve, from 2 of a straight line up to that of its rows.
    pub parameters: f64,
}

/// A friction curve as measured: coefficients, and perhaps their standard deviations, at some sliding speeds.
///
/// Between its knots it is interpolated by piecewise cubics that are monotone where the knots are (Fritsch and Carlson's
/// method with the slopes of Fritsch and Butland, SciPy's `PchipInterpolator`). The knots are the rows, and of a smoothed
/// curve further points of its spline besides. Below the first and beyond the last speed it is constant, and its slope is
/// continuous everywhere.
///
/// ```
/// use stickslip_core::friction::measured_curve::MeasuredCurve;
/// let curve = MeasuredCurve::new(&[0.0, 0.5, 2.0], &[0.45, 0.3, 0.35], None)?;
/// assert_eq!(curve.coefficient(0.5), 0.3);
/// assert_eq!(curve.coefficient(7.0), 0.35);
/// # Ok::<(), stickslip_core::friction::measured_curve::CurveError>(())
/// ```
#[derive(Debug, PartialEq)]
pub struct MeasuredCurve {
    speeds: Vec<f64>,
    /// Those that the curve goes through: of a smoothed one not as measured.
    coefficients: Vec<f64>,
    deviations: Option<Vec<f64>>,
    smoothing: Option<Smoothing>,
    /// Speeds between which it is a cubic.
    knots: Vec<f64>,
    /// T / T(0).
    shape: Cubics,
    /// S.
    deviation: Cubics,
    least_shape: f64,
    largest_deviation: f64,
    index: SpeedIndex,
}

impl MeasuredCurve {
    /// A curve from its columns: speeds in m/s, rising from 0 or more; coefficients; standard deviations of these.
    ///
    /// # Errors
    /// [`CurveError`] with the first thing that is wrong.
    pub fn new(speeds: &[f64], coefficients: &[f64], deviations: Option<&[f64]>) -> Result<Self, CurveError> {
        check_columns(speeds, coefficients, deviations)?;
        let zero = vec![0.0; speeds.len()];
        let knots = Knots { speeds, coefficients, deviations: deviations.unwrap_or(&zero), slopes: None };
        Self::through(&knots, (speeds, coefficients, deviations))
    }

    /// A curve through its knots, with the rows that it is known by.
    fn through(
        knots: &Knots<'_>,
        (speeds, coefficients, deviations): (&[f64], &[f64], Option<&[f64]>),
    ) -> Result<Self, CurveError> {
        let at_rest = knots.coefficients[0];
        if at_rest == 0.0 {
            return Err(CurveError::NothingAtRest);
        }
        let shape: Vec<f64> = knots.coefficients.iter().map(|value| value / at_rest).collect();
        let monotone = slopes_between(knots.speeds, &shape);
        let slopes = match knots.slopes {
            Some(wanted) => {
                let wanted: Vec<f64> = wanted.iter().map(|slope| slope / at_rest).collect();
                limited_slopes(knots.speeds, &shape, &wanted, &monotone)
            }
            None => monotone,
        };
        let deviation_slopes = slopes_between(knots.speeds, knots.deviations);
        Ok(Self {
            speeds: speeds.to_vec(),
            coefficients: coefficients.to_vec(),
            deviations: deviations.map(<[f64]>::to_vec),
            smoothing: None,
            knots: knots.speeds.to_vec(),
            shape: Cubics::new(knots.speeds, &shape, &slopes),
            deviation: Cubics::new(knots.speeds, knots.deviations, &deviation_slopes),
            least_shape: shape.iter().copied().fold(f64::INFINITY, f64::min),
            largest_deviation: knots.deviations.iter().copied().fold(0.0, f64::max),
            index: SpeedIndex::new(knots.speeds),
        })
    }

    /// The same through rows that are smoothed first, so that their noise makes no slopes.
    ///
    /// The curve becomes a cubic smoothing spline over the root of the speed, on which friction bends about as much near rest
    /// as far from it. How smooth it is follows from the rows by generalised cross-validation. The standard deviations are
    /// smoothed as much. What is below 0 then becomes 0.
    ///
    /// Between two rows there are up to eight cubics of the speed, which have the values and slopes of the spline at
    /// their ends, but at rest, where these are infinite, where the spline turns and at the last row.
    ///
    /// ```
    /// use stickslip_core::friction::measured_curve::MeasuredCurve;
    /// let speeds = [0.0, 0.5, 1.0, 1.5, 2.0, 2.5];
    /// let curve = MeasuredCurve::smoothed(&speeds, &[0.45, 0.36, 0.34, 0.29, 0.30, 0.27], None)?;
    /// assert_eq!(curve.falls_and_rises(), [1, 0]);
    /// assert!(curve.smoothing().is_some_and(|smoothing| smoothing.residual < 0.02));
    /// # Ok::<(), stickslip_core::friction::measured_curve::CurveError>(())
    /// ```
    ///
    /// # Errors
    /// As [`MeasuredCurve::new`], and if there are too few rows.
    pub fn smoothed(speeds: &[f64], coefficients: &[f64], deviations: Option<&[f64]>) -> Result<Self, CurveError> {
        check_columns(speeds, coefficients, deviations)?;
        let rows = speeds.len();
        if rows < LEAST_SMOOTHED {
            return Err(CurveError::TooFewToSmooth { rows });
        }
        let roots: Vec<f64> = speeds.iter().map(|speed| speed.sqrt()).collect();
        let spline = SmoothingSpline::new(&roots);
        let softness = spline.best_softness(coefficients);
        let admissible = |value: f64| value.clamp(0.0, LARGEST_COEFFICIENT);
        let of_coefficients = spline.smoothed(coefficients, softness);
        let of_deviations = deviations.map(|values| spline.smoothed(values, softness));
        let fitted: Vec<f64> = of_coefficients.0.iter().copied().map(admissible).collect();
        let fitted_deviations: Option<Vec<f64>> =
            of_deviations.as_ref().map(|(values, _)| values.iter().copied().map(admissible).collect());
        let (mut knots, mut values, mut slopes, mut spread) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        let most = (MOST_ROWS - 1) / (rows - 1);
        for row in 0..rows - 1 {
            let piece = |(values, slopes): &(Vec<f64>, Vec<f64>)| {
                let pair = |of: &[f64]| [of[row], of[row + 1]];
                Piece::between(pair(&roots), pair(values), pair(slopes))
            };
            let (coefficient, deviation) = (piece(&of_coefficients), of_deviations.as_ref().map(piece));
            // As far apart as an index of the speeds needs them.
            let room = (speeds[row + 1] - speeds[row]) / (10.0 * LEAST_GAP * speeds[row + 1]);
            let parts = (room as usize).clamp(1, most.clamp(1, FINER));
            for part in 0..parts {
                let share = part as f64 / parts as f64;
                let root = roots[row] + share * (roots[row + 1] - roots[row]);
                knots.push(if part == 0 { speeds[row] } else { root * root });
                values.push(admissible(coefficient.value(root)));
                // By the chain rule, from a slope over the root of the speed.
                slopes.push(coefficient.slope(root) / (2.0 * root));
                spread.push(deviation.map_or(0.0, |deviation| admissible(deviation.value(root))));
            }
        }
        // Beyond the last row the curve is constant.
        knots.push(speeds[rows - 1]);
        values.push(fitted[rows - 1]);
        slopes.push(0.0);
        spread.push(fitted_deviations.as_ref().map_or(0.0, |fitted| fitted[rows - 1]));
        let knots = Knots { speeds: &knots, coefficients: &values, deviations: &spread, slopes: Some(&slopes) };
        let curve = Self::through(&knots, (speeds, &fitted, fitted_deviations.as_deref()))?;
        let differences = coefficients.iter().zip(&fitted).map(|(measured, fitted)| measured - fitted);
        let squares = differences.map(|difference| difference * difference);
        let smoothing = Smoothing {
            coefficients: coefficients.to_vec(),
            deviations: deviations.map(<[f64]>::to_vec),
            residual: (squares.sum::<f64>() / rows as f64).sqrt(),
            parameters: spline.parameters(softness),
        };
        Ok(Self { smoothing: Some(smoothing), ..curve })
    }

    /// What a smoothed curve was made of.
    #[must_use]
    pub fn smoothing(&self) -> Option<&Smoothing> {
        self.smoothing.as_ref()
    }

    /// Speeds of the rows, m/s.
    #[must_use]
    pub fn speeds(&self) -> &[f64] {
        &self.speeds
    }

    /// Coefficients of the rows that the curve goes through.
    #[must_use]
    pub fn coefficients(&self) -> &[f64] {
        &self.coefficients
    }

    /// Standard deviations of the rows that the curve goes through, if they were measured.
    #[must_use]
    pub fn deviations(&self) -> Option<&[f64]> {
        self.deviations.as_deref()
    }

    /// T(0), the coefficient at rest.
    #[must_use]
    pub fn at_rest(&self) -> f64 {
        self.coefficients[0]
    }

    /// In how many ranges of speed it falls from knot to knot, and in how many it rises. Knots of one coefficient end none.
    #[must_use]
    pub fn falls_and_rises(&self) -> [usize; 2] {
        let mut counts = [0, 0];
        let mut before = None;
        for pair in self.shape.at_knots(self.knots.len()).windows(2).filter(|pair| pair[0] != pair[1]) {
            let rises = pair[1] > pair[0];
            if before != Some(rises) {
                counts[usize::from(rises)] += 1;
            }
            before = Some(rises);
        }
        counts
    }

    /// T at a sliding speed (either sign), m/s.
    #[must_use]
    pub fn coefficient(&self, speed: f64) -> f64 {
        self.at_rest() * self.values(speed.abs()).0
    }

    /// S, the standard deviation of the coefficient, at a sliding speed (either sign), m/s.
    #[must_use]
    pub fn deviation(&self, speed: f64) -> f64 {
        self.values(speed.abs()).1
    }

    /// `T / T(0)` and S at a sliding speed in m/s, without a branch. A step of an integration may reach a little beyond
    /// the moment at which the sliding speed vanishes: the first cubic of a curve that begins at rest is continued as
    /// far to negative speeds as it reaches to positive ones.
    #[inline(always)]
    pub(crate) fn values(&self, speed: f64) -> (f64, f64) {
        let (i, t) = self.index.place(speed);
        (self.shape.value(i, t), self.deviation.value(i, t))
    }

    /// The least value at rest with which the curve, shifted by `shift` standard deviations, has friction at rest and at a
    /// speed in m/s, more than [`NOTHING`]; infinite if none gives it any.
    #[inline(always)]
    pub(crate) fn least_at_rest(&self, speed: f64, shift: f64) -> f64 {
        // A curve that is not shifted vanishes with its value at rest alone.
        let margin = if shift < 0.0 { NOTHING } else { f64::MIN_POSITIVE };
        self.at_rest_with(speed, shift, margin)
    }

    /// The value at rest with which it is 0 at rest or at that speed, and below 0 at neither; infinite if there is none.
    pub(crate) fn vanishes_at_rest(&self, speed: f64, shift: f64) -> f64 {
        self.at_rest_with(speed, shift, 0.0)
    }

    /// The least value at rest with which it is no less than `coefficient` at rest and at that speed.
    #[inline(always)]
    fn at_rest_with(&self, speed: f64, shift: f64, coefficient: f64) -> f64 {
        let (shape, deviation) = self.values(speed);
        let [at_rest, needed] = [self.values(0.0).1, deviation].map(|deviation| coefficient - shift * deviation);
        let at_speed = if shape > NOTHING {
            needed / shape
        } else if needed < 0.0 {
            f64::NEG_INFINITY
        } else {
            f64::INFINITY
        };
        at_rest.max(at_speed)
    }

    /// A lower bound of the curve with this value at rest and this shift, at all speeds.
    pub(crate) fn lower_bound(&self, at_rest: f64, shift: f64) -> f64 {
        at_rest * self.least_shape + shift.min(0.0) * self.largest_deviation
    }

    /// The first of [`MeasuredCurve::values`]; without standard deviations the second is 0.
    #[inline(always)]
    pub(crate) fn shape_alone(&self, speed: f64) -> f64 {
        let (i, t) = self.index.place(speed);
        self.shape.value(i, t)
    }

    /// The slopes of `T / T(0)` and of S, s/m.
    #[inline(always)]
    pub(crate) fn slopes(&self, speed: f64) -> (f64, f64) {
        let (i, t) = self.index.place(speed);
        (self.shape.slope(i, t), self.deviation.slope(i, t))
    }

    /// The number of the interval that a speed lies in, as [`MeasuredCurve::window`] counts them.
    #[inline(always)]
    pub(crate) fn interval(&self, speed: f64) -> usize {
        self.index.place(speed).0
    }

    /// What limits the steps that begin or end in an interval.
    #[inline(always)]
    pub(crate) fn window(&self, interval: usize) -> Window {
        let i = interval & PLACE;
        Window {
            steepest: (self.shape.steepest[i], self.deviation.steepest[i]),
            bend: (self.shape.bend[i], self.deviation.bend[i]),
        }
    }
}

/// What limits the steps that begin or end in an interval of a curve: the largest value over this interval and its
/// neighbours, of `T / T(0)` and of S.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Window {
    /// Largest slope, of either sign.
    pub steepest: (f64, f64),
    /// How much the second derivative varies over an interval, the jumps at its ends included.
    pub bend: (f64, f64),
}

/// A cubic between two speeds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    pub from: f64,
    pub to: f64,
    /// Of powers of the speed above `from`.
    coefficients: [f64; 4],
}

impl Piece {
    /// The cubic with these values and slopes at its ends.
    fn between([from, to]: [f64; 2], [first, last]: [f64; 2], [at_first, at_last]: [f64; 2]) -> Self {
        let width = to - from;
        let secant = (last - first) / width;
        let cubic = (at_first - 2.0 * secant + at_last) / (width * width);
        let square = (secant - at_first) / width - cubic * width;
        Self { from, to, coefficients: [first, at_first, square, cubic] }
    }

    pub fn value(&self, speed: f64) -> f64 {
        let ([a, b, c, d], t) = (self.coefficients, speed - self.from);
        a + t * (b + t * (c + t * d))
    }

    pub fn slope(&self, speed: f64) -> f64 {
        let ([_, b, c, d], t) = (self.coefficients, speed - self.from);
        b + t * (2.0 * c + t * (3.0 * d))
    }

    /// Its second derivative.
    pub fn curvature(&self, speed: f64) -> f64 {
        let ([_, _, c, d], t) = (self.coefficients, speed - self.from);
        2.0 * c + 6.0 * d * t
    }

    /// Bounds of its values in `from..=to`: a cubic lies between the least and the largest of its Bezier points.
    pub fn bounds(&self, from: f64, to: f64) -> (f64, f64) {
        let third = (to - from) / 3.0;
        let (first, last) = (self.value(from), self.value(to));
        let inner = [first + third * self.slope(from), last - third * self.slope(to)];
        let points = [first, last].into_iter().chain(inner);
        points.fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), y| (least.min(y), most.max(y)))
    }

    /// The speed in `from..=to`, inside the piece, at which it falls most steeply.
    pub fn steepest_fall(&self, from: f64, to: f64) -> f64 {
        let [_, _, c, d] = self.coefficients;
        let turning = self.from - c / (3.0 * d);
        let candidates = [from, to, if turning > from && turning < to { turning } else { from }];
        candidates.into_iter().fold(from, |best, speed| if self.slope(speed) < self.slope(best) { speed } else { best })
    }

    /// The speeds at which the slope passes through `slope`, in rising order, strictly inside the piece.
    pub fn speeds_of_slope(&self, slope: f64) -> Vec<f64> {
        let [_, b, c, d] = self.coefficients;
        // 3 d t^2 + 2 c t + (b - slope) = 0
        let (constant, half) = (b - slope, c);
        let mut roots = if d == 0.0 {
            if half == 0.0 { vec![] } else { vec![-constant / (2.0 * half)] }
        } else {
            let discriminant = half * half - 3.0 * d * constant;
            if discriminant <= 0.0 {
                vec![]
            } else {
                // The root of larger modulus first, the other by Vieta: no cancellation.
                let larger = -(half + discriminant.sqrt().copysign(half));
                vec![larger / (3.0 * d), constant / larger]
            }
        };
        roots.retain(|t| *t > 0.0 && *t < self.to - self.from);
        roots.sort_by(f64::total_cmp);
        roots.into_iter().map(|t| self.from + t).collect()
    }
}

fn check_columns(speeds: &[f64], coefficients: &[f64], deviations: Option<&[f64]>) -> Result<(), CurveError> {
    let rows = speeds.len();
    for (column, values) in [("coefficient", Some(coefficients)), ("std", deviations)] {
        if let Some(values) = values.filter(|values| values.len() != rows) {
            return Err(CurveError::UnequalColumns { speeds: rows, values: values.len(), column });
        }
    }
    if rows < 2 {
        return Err(CurveError::TooFewRows { rows });
    }
    if rows > MOST_ROWS {
        return Err(CurveError::TooManyRows { rows });
    }
    for row in 0..rows {
        let columns = [
            ("speed", Some(speeds), HIGHEST_SPEED, " m/s"),
            ("coefficient", Some(coefficients), LARGEST_COEFFICIENT, ""),
            ("std", deviations, LARGEST_COEFFICIENT, ""),
        ];
        for (column, values, largest, unit) in columns {
            let Some(value) = values.map(|values| values[row]) else { continue };
            if !(0.0..=largest).contains(&value) {
                return Err(CurveError::OutOfRange { row, column, value, largest, unit });
            }
        }
        let Some(before) = row.checked_sub(1).map(|before| speeds[before]) else { continue };
        let speed = speeds[row];
        if speed <= before {
            return Err(CurveError::NotRising { row, speed, before });
        }
        if speed - before < LEAST_GAP * speed || speed < f64::MIN_POSITIVE {
            return Err(CurveError::TooNear { row, speed, before });
        }
    }
    Ok(())
}

/// What a curve goes through.
struct Knots<'a> {
    speeds: &'a [f64],
    coefficients: &'a [f64],
    deviations: &'a [f64],
    /// The slopes of the coefficients, if they are known.
    slopes: Option<&'a [f64]>,
}

/// The slopes of a monotone curve through these values.
fn slopes_between(speeds: &[f64], values: &[f64]) -> Vec<f64> {
    monotone_slopes(speeds, values, speeds[0] > 0.0, true)
}

/// The wanted slopes, as far as the curve stays monotone between two knots with them: of the sign of the secants on both
/// sides, and up to three times the flatter of them (de Boor and Swartz 1977). At both ends the slopes are those of a curve
/// without wanted ones.
fn limited_slopes(speeds: &[f64], values: &[f64], wanted: &[f64], monotone: &[f64]) -> Vec<f64> {
    let last = speeds.len() - 1;
    let secant = |i: usize| (values[i + 1] - values[i]) / (speeds[i + 1] - speeds[i]);
    let limited = |i: usize| {
        let (before, after) = (secant(i - 1), secant(i));
        let steepest = if before * after > 0.0 { 3.0 * before.abs().min(after.abs()) } else { 0.0 };
        if before > 0.0 { wanted[i].clamp(0.0, steepest) } else { wanted[i].clamp(-steepest, 0.0) }
    };
    (0..=last).map(|i| if i == 0 || i == last { monotone[i] } else { limited(i) }).collect()
}

/// Piecewise cubics over the speeds of a curve, each in powers of the speed above its own beginning. Behind the last
/// row comes a constant.
#[derive(Debug, PartialEq)]
struct Cubics {
    coefficients: [Box<[f64; PLACES]>; 4],
    steepest: Box<[f64; PLACES]>,
    bend: Box<[f64; PLACES]>,
}

impl Cubics {
    /// Through the values `y` with these slopes.
    fn new(x: &[f64], y: &[f64], slopes: &[f64]) -> Self {
        let empty = || Box::new([0.0; PLACES]);
        let mut coefficients = [empty(), empty(), empty(), empty()];
        let last = x.len() - 1;
        for i in 0..last {
            let pair = |of: &[f64]| [of[i], of[i + 1]];
            let piece = Piece::between(pair(x), pair(y), pair(slopes));
            for (coefficients, value) in coefficients.iter_mut().zip(piece.coefficients) {
                coefficients[i] = value;
            }
        }
        coefficients[0][last] = y[last];
        let mut cubics = Self { coefficients, steepest: empty(), bend: empty() };
        let own: Vec<(f64, f64)> = (0..=last).map(|i| cubics.extremes(x, i)).collect();
        for i in 0..=last {
            let window = &own[i.saturating_sub(1)..=(i + 1).min(last)];
            cubics.steepest[i] = window.iter().fold(0.0, |most, own| own.0.max(most));
            cubics.bend[i] = window.iter().fold(0.0, |most, own| own.1.max(most));
        }
        cubics
    }

    /// Its values at so many first knots.
    fn at_knots(&self, count: usize) -> &[f64] {
        &self.coefficients[0][..count]
    }

    /// The steepest slope in an interval, and the variation of its second derivative with the jumps at its ends.
    fn extremes(&self, x: &[f64], i: usize) -> (f64, f64) {
        let last = x.len() - 1;
        let [_, _, square, cubic] = [0, 1, 2, 3].map(|power| self.coefficients[power][i]);
        let second = |i: usize, t: f64| 2.0 * self.coefficients[2][i] + 6.0 * self.coefficients[3][i] * t;
        let width = |i: usize| if i < last { x[i + 1] - x[i] } else { 0.0 };
        let before = match i {
            0 if x[0] > 0.0 => 0.0,
            0 => second(0, 0.0),
            i => second(i - 1, width(i - 1)),
        };
        let after = if i < last { second(i + 1, 0.0) } else { 0.0 };
        let (first, end) = (second(i, 0.0), second(i, width(i)));
        let bend = (first - before).abs() + (end - first).abs() + (after - end).abs();
        let turning = (-square / (3.0 * cubic)).clamp(0.0, width(i));
        let turning = if turning.is_finite() { turning } else { 0.0 };
        let slopes = [0.0, turning, width(i)].map(|t| self.slope(i, t).abs());
        (slopes.into_iter().fold(0.0, f64::max), bend)
    }

    #[inline(always)]
    fn value(&self, i: usize, t: f64) -> f64 {
        let [a, b, c, d] = &self.coefficients;
        let i = i & PLACE;
        a[i] + t * (b[i] + t * (c[i] + t * d[i]))
    }

    fn slope(&self, i: usize, t: f64) -> f64 {
        let [_, b, c, d] = &self.coefficients;
        b[i] + t * (2.0 * c[i] + t * (3.0 * d[i]))
    }
}

/// Finds the interval of a speed by an index over the bits of the number, which are nearly its logarithm: a cell of the
/// index has at most one speed of the curve in it, so that one comparison with this speed remains.
#[derive(Debug, PartialEq)]
struct SpeedIndex {
    /// Speeds of the rows, then infinity.
    knots: Box<[f64; PLACES]>,
    /// For each cell, how many rows but the first lie below it. A power of two of cells.
    cells: Box<[u32]>,
    /// Bits that do not count for the cell.
    shift: u32,
    /// The cell of the second row, before the first one is subtracted.
    first_cell: u64,
    /// Speeds are kept between these: where the continuation of the first cubic ends, and the last row.
    least: f64,
    second: f64,
    last: f64,
}

impl SpeedIndex {
    fn new(speeds: &[f64]) -> Self {
        let mut knots = Box::new([f64::INFINITY; PLACES]);
        knots[..speeds.len()].copy_from_slice(speeds);
        let above = &speeds[1..];
        let cell = |speed: f64, shift: u32| speed.to_bits() >> shift;
        let has_own_cells = |shift: &u32| above.windows(2).all(|pair| cell(pair[0], *shift) < cell(pair[1], *shift));
        // Neighbours differ by a ten-thousandth, and so in the first 14 bits behind the exponent.
        let shift = (36..=52).rev().find(has_own_cells).unwrap_or(36);
        let first_cell = cell(above[0], shift);
        let count = (cell(above[above.len() - 1], shift) - first_cell + 1) as usize;
        let mut cells = vec![0_u32; count.next_power_of_two()].into_boxed_slice();
        for (number, entry) in cells.iter_mut().enumerate() {
            let below = above.iter().filter(|&&speed| cell(speed, shift) - first_cell < number as u64).count();
            *entry = below as u32;
        }
        let least = if speeds[0] > 0.0 { speeds[0] } else { -above[0] };
        Self { knots, cells, shift, first_cell, least, second: above[0], last: above[above.len() - 1] }
    }

    /// The number of the interval that a speed lies in, and the speed above its beginning.
    #[inline(always)]
    fn place(&self, speed: f64) -> (usize, f64) {
        let speed = if speed < self.least { self.least } else { speed };
        let speed = if speed > self.last { self.last } else { speed };
        let indexed = if speed < self.second { self.second } else { speed };
        let cell = (indexed.to_bits() >> self.shift).wrapping_sub(self.first_cell) as usize & (self.cells.len() - 1);
        let below = self.cells[cell] as usize;
        let interval = below + usize::from(speed >= self.knots[(below + 1) & PLACE]);
        (interval, speed - self.knots[interval & PLACE])
    }
}

/// A measured curve that is shared by everything that computes with it.
///
/// A program reads a handful of curves and needs them until it ends, while a brake is cloned for every sample. So a
/// curve is never freed, the same curve is stored once, and what holds a curve is as cheap to copy as a number.
#[derive(Debug, Clone, Copy)]
pub struct SharedCurve(&'static MeasuredCurve);

static CURVES: Mutex<Vec<&'static MeasuredCurve>> = Mutex::new(Vec::new());

impl SharedCurve {
    /// Shares a curve.
    #[must_use]
    pub fn new(curve: MeasuredCurve) -> Self {
        let mut curves = CURVES.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(same) = curves.iter().find(|other| ***other == curve) {
            return Self(same);
        }
        let shared: &'static MeasuredCurve = Box::leak(Box::new(curve));
        curves.push(shared);
        Self(shared)
    }
}

impl SharedCurve {
    /// The knots between two speeds in m/s.
    pub(crate) fn knots_between(self, from: f64, to: f64) -> &'static [f64] {
        let knots = &self.0.knots;
        let first = knots.partition_point(|knot| *knot <= from);
        let last = knots.partition_point(|knot| *knot < to);
        &knots[first..last.max(first)]
    }

    /// The pieces of `by_shape T / T(0) + by_deviation S` that reach into the speeds between two. Beyond the last row it is
    /// constant.
    pub(crate) fn pieces_between(
        self,
        [from, to]: [f64; 2],
        (by_shape, by_deviation): (f64, f64),
    ) -> impl Iterator<Item = Piece> + Clone {
        let MeasuredCurve { knots, shape, deviation, .. } = self.0;
        let last = knots.len() - 1;
        let piece = move |i: usize| Piece {
            from: knots[i],
            to: knots[i + 1],
            coefficients: [0, 1, 2, 3]
                .map(|power| by_shape * shape.coefficients[power][i] + by_deviation * deviation.coefficients[power][i]),
        };
        let constant = (knots[0] > from.max(0.0)).then(|| Piece {
            from: 0.0,
            to: knots[0],
            coefficients: [piece(0).coefficients[0], 0.0, 0.0, 0.0],
        });
        let first = knots.partition_point(|knot| *knot <= from).saturating_sub(1);
        let end = knots.partition_point(|knot| *knot < to).min(last);
        constant.into_iter().chain((first..end).map(piece))
    }
}

impl Deref for SharedCurve {
    type Target = MeasuredCurve;

    #[inline(always)]
    fn deref(&self) -> &MeasuredCurve {
        self.0
    }
}

impl PartialEq for SharedCurve {
    fn eq(&self, other: &Self) -> bool {
        std::ptr::eq(self.0, other.0)
    }
}

#[cfg(test)]
mod tests;
