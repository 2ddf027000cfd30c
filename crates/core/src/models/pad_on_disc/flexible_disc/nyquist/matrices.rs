//! Steady sliding of the samples of a batch, and the equations linearised there, with the whole patch in contact.

use crate::models::pad_on_disc::flexible_disc::contact::averages::Averages;
use crate::models::pad_on_disc::flexible_disc::geometry::DiscGeometry;
use crate::models::pad_on_disc::flexible_disc::nyquist::batch::{Coefficients, Work};
use crate::models::pad_on_disc::flexible_disc::nyquist::elimination::{eliminate, solve};
use crate::numerics::row::{Number, Row};
use crate::numerics::sine_cosine::{SERIES_ANGLE, small_sine_and_cosine};

/// Steps of the search for the equilibrium. The error shrinks a hundredfold and more in each, or the sample is left to
/// the eigenvalues.
const MOST_STEPS: usize = 12;

/// Size of the last step, relative to the displacements, at which the search ends. It changes a growth rate by less
/// than the margin of the decision.
const LAST_STEP: f64 = 1e-10;

/// Places of the degrees of freedom: y is first, the amplitudes follow.
#[derive(Debug, Clone, Copy)]
pub(super) struct Places {
    pub size: usize,
    pub phi: usize,
    pub x: usize,
    pub even: usize,
    pub odd: usize,
}

impl Places {
    pub const FIRST_AMPLITUDE: usize = 1;

    #[inline(always)]
    pub fn new(geometry: &DiscGeometry) -> Self {
        let (even, odd) = (geometry.patch.even, geometry.patch.odd);
        let amplitudes = even + odd;
        Self { size: amplitudes + 3, phi: amplitudes + 1, x: amplitudes + 2, even, odd }
    }

    pub const fn amplitudes(&self) -> usize {
        self.even + self.odd
    }
}

/// Sine and cosine of phi, and its tangent over the unit of length.
struct Angle<const L: usize> {
    sine: Row<L>,
    cosine: Row<L>,
    tilt: Row<L>,
}

impl<const L: usize> Angle<L> {
    #[inline(always)]
    fn new(phi: Row<L>, tilt_scale: Row<L>) -> Self {
        let (mut sine, mut cosine) = (Row::ZERO, Row::ZERO);
        for l in 0..L {
            (sine.0[l], cosine.0[l]) = small_sine_and_cosine(phi.0[l]);
        }
        Self { sine, cosine, tilt: sine * cosine.reciprocal() * tilt_scale }
    }
}

/// Fills in what each amplitude has of its own.
#[inline(always)]
pub(super) fn set_amplitudes<const L: usize>(geometry: &DiscGeometry, of: &Coefficients<L>, work: &mut Work<L>) {
    let Work { stiffness, gyroscopic, compliance, .. } = work;
    let odd = geometry.modes.iter().filter(|mode| mode.nodal_diameters > 0);
    let amplitudes = geometry.modes.iter().map(|mode| (mode, 1.0)).chain(odd.map(|mode| (mode, -1.0)));
    for (((mode, direction), stiffness), (gyroscopic, compliance)) in
        amplitudes.zip(stiffness).zip(gyroscopic.iter_mut().zip(compliance))
    {
        let frequency = mode.frequency_parameter * of.frequency;
        let turning = f64::from(mode.nodal_diameters) * of.spin;
        *stiffness = frequency * frequency - turning * turning;
        *gyroscopic = (2.0 * direction) * turning;
        *compliance = (1.0 / mode.circle()) * of.compliance;
    }
}

/// Finds steady sliding by Newton's method with one linearisation, that of the disc without follower loads about steady
/// sliding on a rigid one. Returns 1 for lanes that found it with the whole patch in contact, else 0.
#[inline(always)]
pub(super) fn find_equilibrium<const L: usize>(
    geometry: &DiscGeometry,
    of: &Coefficients<L>,
    work: &mut Work<L>,
) -> [u64; L] {
    let (places, averages) = (Places::new(geometry), &geometry.patch.averages);
    let Places { size, phi, x, .. } = places;
    // On a rigid disc.
    let contact = (of.pad.normal_stiffness + of.pad.pressure_gain).reciprocal();
    let y = -(of.pad.normal_stiffness * of.preload * contact);
    let friction = of.pad.transmission * of.friction * of.pad.pressure_gain * -y;
    let tangential = friction * (of.pad.tangential_stiffness + of.pad.contact_tangential).reciprocal();
    let spring = of.pad.contact_tangential * tangential - friction;
    work.q.fill(Row::ZERO);
    work.q[0] = y;
    work.q[x] = tangential;
    work.q[phi] = -(of.pad.arm * spring * of.pad.angular_stiffness.reciprocal());
    set_matrix(places, averages, of, work, false);
    work.real.copy_from_slice(&work.matrix);
    eliminate(&mut work.real, size);

    // 1 while the search goes on, 2 where it has ended at the equilibrium, 0 where it was given up.
    let mut found = [1_u64; L];
    let mut before = Row::splat(f64::INFINITY);
    for _ in 0..MOST_STEPS {
        set_forces(places, averages, of, work);
        solve(&work.real, size, &mut work.forces);
        let (mut largest, mut scale, mut sum) = (Row::ZERO, Row::ZERO, Row::ZERO);
        for (q, step) in work.q.iter_mut().zip(&work.forces) {
            *q -= *step;
            largest = largest.max(step.abs());
            scale = scale.max(q.abs());
            // What is no number stays none in the sum.
            sum += step.abs();
        }
        for (l, state) in found.iter_mut().enumerate() {
            let small = (largest.0[l] <= LAST_STEP * scale.0[l]) & sum.0[l].is_finite();
            // A search that hardly converges may end elsewhere than that for the eigenvalues.
            let shrinks = largest.0[l] <= 0.1 * before.0[l];
            if *state == 1 {
                *state = if small { 2 } else { u64::from(shrinks) };
            }
        }
        before = largest;
        if found.iter().all(|state| *state != 1) {
            break;
        }
    }
    let angle = work.q[phi];
    let tilt = Angle::new(angle, of.tilt_scale).tilt;
    let margin = averages.least_gap(-work.q[0], tilt, &work.q[Places::FIRST_AMPLITUDE..phi]);
    let mut whole = [0; L];
    for l in 0..L {
        let upright = angle.0[l].abs() <= SERIES_ANGLE;
        whole[l] = u64::from((found[l] == 2) & (margin.0[l] > 0.0) & upright);
    }
    whole
}

/// The forces at rest: the accelerations of
/// [`FlexibleEquations`](crate::models::pad_on_disc::flexible_disc::equations::FlexibleEquations) with the sign changed.
#[inline(always)]
fn set_forces<const L: usize>(places: Places, averages: &Averages, of: &Coefficients<L>, work: &mut Work<L>) {
    let Places { phi, x, even, odd, .. } = places;
    let Work { q, forces, stiffness, compliance, .. } = work;
    let angle = Angle::new(q[phi], of.tilt_scale);
    let (y, amplitudes) = (q[0], &q[Places::FIRST_AMPLITUDE..phi]);
    let (a, b) = amplitudes.split_at(even);
    let pressure = of.pad.pressure_gain * averages.mean_gap(-y, a);
    let spring = of.pad.contact_tangential * q[x] - of.pad.transmission * of.friction * pressure;
    forces[x] = of.pad.tangential_stiffness * q[x] + pressure * angle.sine + spring * angle.cosine;
    forces[0] = of.pad.normal_stiffness * (of.preload + y) - pressure * angle.cosine + spring * angle.sine;
    forces[phi] = of.pad.angular_stiffness * q[phi] + of.pad.arm * spring;
    let ratio = of.friction * of.slope_scale;
    let (minus_y, minus_tilt) = (-y, -angle.tilt);
    for i in 0..even {
        let mut load = averages.shape[i] * minus_y;
        for (product, a) in averages.even_even[i * even..].iter().zip(a) {
            load += *product * *a;
        }
        let mut factors = averages.even_follower[i].iter();
        let mut follower = Row::ZERO;
        for a in a {
            let mut sum = Row::ZERO;
            for (b, factor) in b.iter().zip(&mut factors) {
                sum += *factor * *b;
            }
            follower += *a * sum;
        }
        let mut sum = Row::ZERO;
        for (b, factor) in b.iter().zip(&mut factors) {
            sum += *factor * *b;
        }
        follower += minus_y * sum;
        let mut sum = Row::ZERO;
        for (a, factor) in a.iter().zip(&mut factors) {
            sum += *factor * *a;
        }
        follower += minus_tilt * sum;
        forces[Places::FIRST_AMPLITUDE + i] = stiffness[i] * a[i] + compliance[i] * (load + ratio * follower);
    }
    for j in 0..odd {
        let mut load = averages.arc_shape[j] * minus_tilt;
        for (product, b) in averages.odd_odd[j * odd..].iter().zip(b) {
            load += *product * *b;
        }
        let mut factors = averages.odd_follower[j].iter();
        let mut follower = Row::ZERO;
        for amplitudes in [a, b] {
            for (first, amplitude) in amplitudes.iter().enumerate() {
                let mut sum = Row::ZERO;
                for (other, factor) in amplitudes[first..].iter().zip(&mut factors) {
                    sum += *factor * *other;
                }
                follower += *amplitude * sum;
            }
        }
        for (amplitudes, by) in [(a, minus_y), (b, minus_tilt)] {
            let mut sum = Row::ZERO;
            for (amplitude, factor) in amplitudes.iter().zip(&mut factors) {
                sum += *factor * *amplitude;
            }
            follower += by * sum;
        }
        let k = even + j;
        forces[Places::FIRST_AMPLITUDE + k] = stiffness[k] * b[j] + compliance[k] * (load + ratio * follower);
    }
}

/// A of the module documentation in the displacements `work.q`, and the column of x in B; not scaled. Without follower
/// loads if `with_follower` is false.
#[inline(always)]
pub(super) fn set_matrix<const L: usize>(
    places: Places,
    averages: &Averages,
    of: &Coefficients<L>,
    work: &mut Work<L>,
    with_follower: bool,
) {
    let Places { size, phi, x, even, odd } = places;
    let Work { q, matrix, damping_by_x, stiffness, compliance, .. } = work;
    let first = Places::FIRST_AMPLITUDE;
    let angle = Angle::new(q[phi], of.tilt_scale);
    let Angle { sine, cosine, tilt } = angle;
    let tilt_by_angle = of.tilt_scale * (cosine * cosine).reciprocal();
    let (y, amplitudes) = (q[0], &q[first..phi]);
    let (a, b) = amplitudes.split_at(even);
    matrix.fill(Row::ZERO);
    damping_by_x.fill(Row::ZERO);
    let pressure = of.pad.pressure_gain * averages.mean_gap(-y, a);
    let grip = of.pad.transmission * of.friction;
    let spring = of.pad.contact_tangential * q[x] - grip * pressure;

    // By y and the even amplitudes, through the pressure.
    for column in 0..=even {
        let by =
            if column == 0 { -of.pad.pressure_gain } else { averages.shape[column - first] * of.pad.pressure_gain };
        let spring_by = -(grip * by);
        matrix[column] = spring_by * sine - by * cosine;
        matrix[phi * size + column] = of.pad.arm * spring_by;
        matrix[x * size + column] = by * sine + spring_by * cosine;
    }
    matrix[0] += of.pad.normal_stiffness;
    // By phi.
    matrix[phi] = pressure * sine + spring * cosine;
    matrix[phi * size + phi] = of.pad.angular_stiffness;
    matrix[x * size + phi] = pressure * cosine - spring * sine;
    // By x.
    matrix[x] = of.pad.contact_tangential * sine;
    matrix[phi * size + x] = of.pad.arm * of.pad.contact_tangential;
    matrix[x * size + x] = of.pad.tangential_stiffness + of.pad.contact_tangential * cosine;
    let spring_by_speed = -(of.pad.transmission * of.friction_slope * pressure);
    damping_by_x[0] = spring_by_speed * sine;
    damping_by_x[phi] = of.pad.arm * spring_by_speed;
    damping_by_x[x] = spring_by_speed * cosine;

    let ratio = if with_follower { of.friction * of.slope_scale } else { Row::ZERO };
    let (minus_y, minus_tilt) = (-y, -tilt);
    for i in 0..even {
        let row = &mut matrix[(first + i) * size..(first + i + 1) * size];
        let mut follower = Row::ZERO;
        if with_follower {
            let (by_even, by_odd) = row[first..].split_at_mut(even);
            let mut factors = averages.even_follower[i].iter();
            for (by_a, a) in by_even.iter_mut().zip(a) {
                let mut sum = Row::ZERO;
                for ((by_b, b), factor) in by_odd.iter_mut().zip(b).zip(&mut factors) {
                    *by_b += *factor * *a;
                    sum += *factor * *b;
                }
                *by_a += sum;
                follower += *a * sum;
            }
            let mut by_y = Row::ZERO;
            for ((by_b, b), factor) in by_odd.iter_mut().zip(b).zip(&mut factors) {
                *by_b += *factor * minus_y;
                by_y -= *factor * *b;
            }
            let mut by_tilt = Row::ZERO;
            for ((by_a, a), factor) in by_even.iter_mut().zip(a).zip(&mut factors) {
                *by_a += *factor * minus_tilt;
                by_tilt -= *factor * *a;
            }
            follower += by_tilt * tilt + by_y * y;
            row[0] = by_y;
            row[phi] = by_tilt * tilt_by_angle;
        }
        let gain = compliance[i] * ratio;
        for entry in &mut row[..=phi] {
            *entry = gain * *entry;
        }
        row[0] -= averages.shape[i] * compliance[i];
        for (entry, product) in row[first..].iter_mut().zip(&averages.even_even[i * even..(i + 1) * even]) {
            *entry += *product * compliance[i];
        }
        row[first + i] += stiffness[i];
        damping_by_x[first + i] = compliance[i] * of.friction_slope * of.slope_scale * follower;
    }
    for j in 0..odd {
        let k = even + j;
        let row = &mut matrix[(first + k) * size..(first + k + 1) * size];
        let mut follower = Row::ZERO;
        if with_follower {
            let (by_even, by_odd) = row[first..].split_at_mut(even);
            let mut factors = averages.odd_follower[j].iter();
            let (mut by_y, mut by_tilt) = (Row::ZERO, Row::ZERO);
            for (by, amplitudes) in [(&mut *by_even, a), (&mut *by_odd, b)] {
                for (l, amplitude) in amplitudes.iter().enumerate() {
                    let mut sum = Row::ZERO;
                    for ((by_other, other), factor) in by[l..].iter_mut().zip(&amplitudes[l..]).zip(&mut factors) {
                        *by_other += *factor * *amplitude;
                        sum += *factor * *other;
                    }
                    by[l] += sum;
                    follower += *amplitude * sum;
                }
            }
            for ((by_a, a), factor) in by_even.iter_mut().zip(a).zip(&mut factors) {
                *by_a += *factor * minus_y;
                by_y -= *factor * *a;
            }
            for ((by_b, b), factor) in by_odd.iter_mut().zip(b).zip(&mut factors) {
                *by_b += *factor * minus_tilt;
                by_tilt -= *factor * *b;
            }
            follower += by_tilt * tilt + by_y * y;
            row[0] = by_y;
            row[phi] = by_tilt * tilt_by_angle;
        }
        let gain = compliance[k] * ratio;
        for entry in &mut row[..=phi] {
            *entry = gain * *entry;
        }
        row[phi] -= averages.arc_shape[j] * (compliance[k] * tilt_by_angle);
        for (entry, product) in row[first + even..].iter_mut().zip(&averages.odd_odd[j * odd..(j + 1) * odd]) {
            *entry += *product * compliance[k];
        }
        row[first + k] += stiffness[k];
        damping_by_x[first + k] = compliance[k] * of.friction_slope * of.slope_scale * follower;
    }
}
