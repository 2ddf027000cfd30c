//! Where the response crosses the imaginary axis near omega_x, and on which side of the origin.

use crate::models::pad_on_disc::flexible_disc::geometry::DiscGeometry;
use crate::models::pad_on_disc::flexible_disc::nyquist::batch::{Coefficients, Work};
use crate::models::pad_on_disc::flexible_disc::nyquist::bounds::{Couplings, norm};
use crate::models::pad_on_disc::flexible_disc::nyquist::elimination::{
    Complex, eliminate_complex, left_and_right, product, solve_complex,
};
use crate::models::pad_on_disc::flexible_disc::nyquist::matrices::Places;
use crate::numerics::row::{Number, Row};

/// What is left for rounding, for the last step of the equilibrium, and for the eigenvalues' own errors, relative to
/// the damping.
const MARGIN: f64 = 1e-6;

/// The side of the origin on which f crosses the imaginary axis: 1 above, -1 below, 0 if that is not known.
pub(super) struct Crossing<const L: usize> {
    /// With friction as it falls, and as if it did not fall with speed.
    pub falling: Row<L>,
    pub steady: Row<L>,
}

/// Finds the crossing by the response at omega_x and by bounds within `half_width`, over omega_x, of it.
#[inline(always)]
pub(super) fn crossing<const L: usize>(
    geometry: &DiscGeometry,
    of: &Coefficients<L>,
    work: &mut Work<L>,
    couplings: &Couplings<L>,
    omega: Row<L>,
    half_width: Row<L>,
) -> Crossing<L> {
    let Places { size, phi, x, .. } = Places::new(geometry);
    set_response(geometry, of, work, omega);
    let Work { damping_by_x, gyroscopic, real, imaginary, left, right, .. } = work;
    eliminate_complex(real, imaginary, size);
    let value = (real[x * size + x], imaginary[x * size + x]);
    left_and_right((real, imaginary), size, left, right);

    // Sizes, with phi scaled so that its row and its column have the same.
    let one = Row::splat(1.0);
    let range = half_width * omega;
    let near = couplings.between(omega - range, omega + range);
    let tiny = Row::splat(f64::MIN_POSITIVE);
    let (phi_row, phi_column) = (norm(&couplings.phi_row), norm(&couplings.phi_column));
    let weight = (phi_column + tiny) * (phi_row + tiny).reciprocal();
    let loop_gain = phi_row * phi_column;
    let inverse = near.core + near.phi * (one + near.core * (2.0 * loop_gain.sqrt() + near.core * loop_gain));
    let most_damping = of.pad.normal_damping.max(of.disc_damping).max(of.pad.angular_damping);
    let by_frequency = 2.0 * omega + range + most_damping + couplings.gyroscopic;
    let left_size = size_of(left, phi, weight.reciprocal());
    let per_right = left_size * inverse * by_frequency;

    // With c_B, the column of x in B: w c_B, and what c_B adds to the last term of h.
    let mut on_column: Complex<L> = (Row::ZERO, Row::ZERO);
    for ((re, im), by_x) in left.iter().zip(&damping_by_x[..x]) {
        on_column = (on_column.0 + *re * *by_x, on_column.1 + *im * *by_x);
    }
    let [at_y, at_amplitudes] = couplings.x_column_damping;
    let column_damping = norm(&[at_y, at_amplitudes, weight.sqrt() * couplings.phi_by_x_damping]);
    let (both, slope) = at_omega(geometry, of, gyroscopic, omega, (left, right));
    let weakening = damping_by_x[x];
    let response = Response {
        value,
        damping: of.pad.tangential_damping + weakening,
        slope: magnitude((slope.0 - on_column.1, slope.1 + on_column.0)),
        curvature: magnitude(both) + per_right * (by_frequency * size_of(right, phi, weight) + column_damping),
    };
    let least = MARGIN * (omega * (of.pad.tangential_damping + weakening.abs()));
    let falling = response.side(omega, range, least);

    // Without c_B: z becomes smaller by i omega R^-1 c_B.
    let by_damping = &mut work.further;
    solve_complex((real, imaginary), size, damping_by_x, by_damping);
    for (right, by_damping) in right.iter_mut().zip(&*by_damping) {
        *right = (right.0 + omega * by_damping.1, right.1 - omega * by_damping.0);
    }
    let (both, slope) = at_omega(geometry, of, gyroscopic, omega, (left, right));
    let response = Response {
        value: (value.0 - omega * on_column.1, value.1 + omega * (on_column.0 - weakening)),
        damping: of.pad.tangential_damping,
        slope: magnitude(slope),
        curvature: magnitude(both) + per_right * by_frequency * size_of(right, phi, weight),
    };
    Crossing { falling, steady: response.side(omega, range, least) }
}

/// L(i omega), complex, with x in the last row and column.
#[inline(always)]
fn set_response<const L: usize>(geometry: &DiscGeometry, of: &Coefficients<L>, work: &mut Work<L>, omega: Row<L>) {
    let Places { size, x, .. } = Places::new(geometry);
    let Work { matrix, damping_by_x, gyroscopic, real, imaginary, .. } = work;
    let square = omega * omega;
    real.copy_from_slice(matrix);
    imaginary.fill(Row::ZERO);
    for (i, by_x) in damping_by_x.iter().enumerate() {
        real[i * size + i] -= square;
        imaginary[i * size + x] = omega * *by_x;
    }
    for i in 0..=x {
        imaginary[i * size + i] += omega * damping_of(geometry, of, i);
    }
    let first = Places::FIRST_AMPLITUDE;
    for &(i, j) in &geometry.pairs {
        imaginary[(first + i) * size + first + j] = omega * gyroscopic[i];
        imaginary[(first + j) * size + first + i] = omega * gyroscopic[j];
    }
}

/// The damping of a degree of freedom by itself.
#[inline(always)]
fn damping_of<const L: usize>(geometry: &DiscGeometry, of: &Coefficients<L>, place: usize) -> Row<L> {
    let Places { phi, x, .. } = Places::new(geometry);
    if place == 0 {
        of.pad.normal_damping
    } else if place < phi {
        of.disc_damping
    } else if place < x {
        of.pad.angular_damping
    } else {
        of.pad.tangential_damping
    }
}

/// `w z`, and the slope `2 omega w z - i w B z`.
#[inline(always)]
fn at_omega<const L: usize>(
    geometry: &DiscGeometry,
    of: &Coefficients<L>,
    gyroscopic: &[Row<L>],
    omega: Row<L>,
    (left, right): (&[Complex<L>], &[Complex<L>]),
) -> (Complex<L>, Complex<L>) {
    let (mut both, mut damped) = ((Row::ZERO, Row::ZERO), (Row::ZERO, Row::ZERO));
    for i in 0..Places::new(geometry).x {
        let (re, im) = product(left[i], right[i]);
        let damping = damping_of(geometry, of, i);
        both = (both.0 + re, both.1 + im);
        damped = (damped.0 + damping * re, damped.1 + damping * im);
    }
    let first = Places::FIRST_AMPLITUDE;
    for &(i, j) in &geometry.pairs {
        for (i, j) in [(i, j), (j, i)] {
            let (re, im) = product(left[first + i], right[first + j]);
            damped = (damped.0 + gyroscopic[i] * re, damped.1 + gyroscopic[i] * im);
        }
    }
    (both, (2.0 * (omega * both.0) + damped.1, 2.0 * (omega * both.1) - damped.0))
}

#[inline(always)]
fn magnitude<const L: usize>((re, im): Complex<L>) -> Row<L> {
    (re * re + im * im).sqrt()
}

/// The size of a vector, with phi scaled by the root of `weight`.
#[inline(always)]
fn size_of<const L: usize>(vector: &[Complex<L>], phi: usize, weight: Row<L>) -> Row<L> {
    let mut sum = Row::ZERO;
    for (re, im) in &vector[..phi] {
        sum += *re * *re + *im * *im;
    }
    let (re, im) = vector[phi];
    (sum + weight * (re * re + im * im)).sqrt()
}

/// What is known of f near omega_x.
struct Response<const L: usize> {
    /// f at omega_x.
    value: Complex<L>,
    /// B_xx.
    damping: Row<L>,
    /// The size of the slope of h, and of what is left of h over the square of the distance from omega_x.
    slope: Row<L>,
    curvature: Row<L>,
}

impl<const L: usize> Response<L> {
    /// The side of the origin on which f crosses the imaginary axis within `range` of omega_x, by more than `least`.
    #[inline(always)]
    fn side(&self, omega: Row<L>, range: Row<L>, least: Row<L>) -> Row<L> {
        // The real part may vanish where offset >= linear delta - quadratic delta^2.
        let (linear, quadratic) = (2.0 * omega - self.slope, Row::splat(1.0) + self.curvature);
        let offset = self.value.0.abs() + MARGIN * (omega * omega);
        let covers = linear * range - quadratic * range * range - offset;
        let discriminant = linear * linear - 4.0 * (quadratic * offset);
        let delta = 2.0 * (offset * (linear + discriminant.sqrt()).reciprocal());
        let change = delta * (self.damping.abs() + self.slope + delta * self.curvature) + least;
        let mut side = Row::ZERO;
        for l in 0..L {
            let (value, change) = (self.value.1.0[l], change.0[l]);
            let known = (covers.0[l] > 0.0) & (linear.0[l] > 0.0);
            let above = f64::from(u8::from(known & (value > change)));
            let below = f64::from(u8::from(known & (value < -change)));
            side.0[l] = above - below;
        }
        side
    }
}
