//! Pairs followed along a path of parameters, and where their damping ratios pass a threshold.

use super::error::Error;
use super::pair::{Complex, Pair, damping_ratio_slope, dot};
use super::region::{Region, ZERO, magnitude};

/// Steps of Newton's method for a critical value.
const NEWTON_STEPS: usize = 30;

/// How often a step along the path may be halved.
const HALVINGS: usize = 20;

/// Two vectors are of one pair if they overlap by this.
const OVERLAP: f64 = 0.7;

/// The coefficients of the matrices along a path, those of damping first.
pub trait Path {
    /// The coefficients at `p + d` as `[c_0, c_1, c_2, c_3]` with `c_0 + c_1 d + c_2 d^2`, which is off by at most `c_3` for all d
    /// from `-step` to `step`.
    fn series(&self, p: f64, step: f64) -> Vec<[f64; 4]>;

    /// The coefficients at `p`.
    fn coefficients(&self, p: f64) -> Vec<f64> {
        self.series(p, 0.0).into_iter().map(|[value, ..]| value).collect()
    }

    /// Their derivatives by p.
    fn derivative(&self, p: f64) -> Vec<f64> {
        self.series(p, 0.0).into_iter().map(|[_, slope, ..]| slope).collect()
    }
}

/// The coefficients `from + p direction`: a parameter that enters as a factor.
#[derive(Debug, Clone, PartialEq)]
pub struct Line {
    /// At p = 0.
    pub from: Vec<f64>,
    /// What is added for p = 1.
    pub direction: Vec<f64>,
}

impl Path for Line {
    fn series(&self, p: f64, _: f64) -> Vec<[f64; 4]> {
        self.from.iter().zip(&self.direction).map(|(from, by)| [from + p * by, *by, 0.0, 0.0]).collect()
    }
}

/// What finds the pairs of a problem along a path.
pub trait Branches {
    /// The problem at `p`.
    ///
    /// # Errors
    /// [`Error::NotFinite`] for coefficients that are not finite.
    fn at(&self, p: f64) -> Result<Box<dyn Place + '_>, Error>;
}

/// A problem at one place on a path.
pub trait Place {
    /// All pairs whose damping ratio may be below the threshold of a region, or come below it near by, with frequencies in
    /// its band and a little beyond. A pair without vectors is one that could not be told from others.
    ///
    /// # Errors
    /// [`Error`], if they are not found.
    fn pairs(&self, region: &Region) -> Result<Vec<Pair>, Error>;

    /// The pair near an approximate one.
    ///
    /// # Errors
    /// [`Error::NotConverged`], and what factorisations say.
    fn refine(&self, start: &Pair) -> Result<Pair, Error>;

    /// `M x` and `C x` of the right vector of a pair, for [`overlap`].
    fn images(&self, pair: &Pair) -> Images;

    /// `-y_a^T (dQ/dp) x_b` at the mean of both eigenvalues: `d lambda / dp` for a pair with itself, what couples two along
    /// the path otherwise. Not finite for a pair without vectors.
    fn coupling(&self, a: &Pair, b: &Pair) -> Complex;
}

/// `M x` and `C x`.
pub type Images = [Vec<Complex>; 2];

/// How much of one pair is in another, 1 for the same: `(y_a^T Q' x_b) (y_b^T Q' x_a)` with `Q' = (lambda_a + lambda_b) M + C`,
/// in magnitude; 0 for a pair without vectors. Images are those at one place.
#[must_use]
pub fn overlap(a: (&Pair, &Images), b: (&Pair, &Images)) -> f64 {
    let sum = a.0.eigenvalue + b.0.eigenvalue;
    let share = |left: &[Complex], [mass, damping]: &Images| sum * dot(left, mass) + dot(left, damping);
    magnitude(share(&a.0.left, b.1) * share(&b.0.left, a.1))
}

/// A pair at a place on a path, with its change along it.
#[derive(Debug, Clone, PartialEq)]
pub struct Followed {
    /// The parameter of the path.
    pub p: f64,
    /// The pair.
    pub pair: Pair,
    /// `d lambda / dp`.
    pub slope: Complex,
}

impl Followed {
    /// A pair of a place.
    #[must_use]
    pub fn new(p: f64, pair: Pair, place: &dyn Place) -> Self {
        let slope = place.coupling(&pair, &pair);
        Self { p, pair, slope }
    }

    /// The derivative of the damping ratio by p.
    #[must_use]
    pub fn damping_ratio_slope(&self) -> f64 {
        damping_ratio_slope(self.pair.eigenvalue, self.slope)
    }
}

/// What a critical value is a root of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Target {
    /// The damping ratio has this value.
    DampingRatio(f64),
    /// The angular frequency has this value: a pair leaves or enters a band.
    Frequency(f64),
    /// A real eigenvalue is zero: divergence begins or ends.
    Growth,
}

impl Target {
    /// How far a pair is from it, and the derivative of that by p.
    #[must_use]
    pub fn distance(self, followed: &Followed) -> (f64, f64) {
        match self {
            Self::DampingRatio(ratio) => (followed.pair.damping_ratio() - ratio, followed.damping_ratio_slope()),
            Self::Frequency(frequency) => (followed.pair.eigenvalue.im - frequency, followed.slope.im),
            Self::Growth => (ZERO - followed.pair.eigenvalue.re, -followed.slope.re),
        }
    }

    /// The error of the distance that the error of a pair makes.
    #[must_use]
    pub fn error(self, pair: &Pair) -> f64 {
        match self {
            Self::DampingRatio(_) => pair.damping_ratio_error(),
            Self::Frequency(_) | Self::Growth => pair.error,
        }
    }
}

/// A critical value of the parameter of a path.
#[derive(Debug, Clone, PartialEq)]
pub struct Critical {
    /// The pair there.
    pub at: Followed,
    /// An estimate of the error of p.
    pub error: f64,
}

impl dyn Branches + '_ {
    /// The pair at another place on the path: steps along it, halved where vectors change much.
    ///
    /// # Errors
    /// [`Error::NotConverged`] where two pairs meet and cannot be told apart, and what factorisations say.
    pub fn follow(&self, from: &Followed, to: f64) -> Result<Followed, Error> {
        let mut here = from.clone();
        let mut step = to - here.p;
        let mut halvings = 0;
        while here.p != to {
            let p = if (to - here.p).abs() <= step.abs() { to } else { here.p + step };
            let mut start = here.pair.clone();
            start.eigenvalue += here.slope * (p - here.p);
            let place = self.at(p)?;
            let is_same = |pair: &Pair| {
                let [before, after] = [&here.pair, pair].map(|pair| (pair, place.images(pair)));
                overlap((before.0, &before.1), (after.0, &after.1)) >= OVERLAP
            };
            match place.refine(&start) {
                Ok(pair) if is_same(&pair) => here = Followed::new(p, pair, &*place),
                Ok(_) | Err(Error::NotConverged { .. }) if halvings < HALVINGS => {
                    halvings += 1;
                    step *= 0.5;
                }
                Ok(pair) => return Err(Error::NotConverged { re: pair.eigenvalue.re, im: pair.eigenvalue.im }),
                Err(error) => return Err(error),
            }
        }
        Ok(here)
    }

    /// The value of p between `low` and `high` at which a pair meets a target: Newton's method from a pair in between, with
    /// bisection where it leaves the interval. Its distances at both ends must have different signs.
    ///
    /// # Errors
    /// [`Error::NotConverged`], and what factorisations say.
    pub fn critical(&self, target: Target, start: &Followed, [low, high]: [f64; 2]) -> Result<Critical, Error> {
        let (mut low, mut high) = (low.min(high), low.max(high));
        let mut here = start.clone();
        let mut rising = None;
        let width = high - low;
        for _ in 0..NEWTON_STEPS {
            let (distance, slope) = target.distance(&here);
            let error = (target.error(&here.pair) / slope).abs() + 2.0 * f64::EPSILON * here.p.abs();
            let step = -distance / slope;
            if step.abs() <= error || high - low <= error {
                return Ok(Critical { at: here, error: error + step.abs() });
            }
            // The interval shrinks on the side on which the distance has the sign of that end.
            let is_rising = *rising.get_or_insert(slope > 0.0);
            if (distance > 0.0) == is_rising {
                high = high.min(here.p);
            } else {
                low = low.max(here.p);
            }
            let newton = here.p + step;
            let slack = 1e-9 * width;
            let next = if newton.is_finite() && newton > low - slack && newton < high + slack {
                newton
            } else {
                0.5 * (low + high)
            };
            if next == here.p {
                return Ok(Critical { at: here, error });
            }
            here = self.follow(&here, next)?;
        }
        Err(Error::NotConverged { re: here.pair.eigenvalue.re, im: here.pair.eigenvalue.im })
    }
}
