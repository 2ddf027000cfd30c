//! The bounds, the crossing and the linearisation against dense algebra, for invented brakes in which any coupling may be
//! the only one that matters: on real ones most of them are so small that a bound holds without them.

use nalgebra::{Complex, DMatrix};

use super::*;
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::compliance::lowest_modes;
use crate::models::pad_on_disc::flexible_disc::linearisation::first_order;
use crate::models::pad_on_disc::flexible_disc::nyquist::batch::{Coefficients, Work};
use crate::models::pad_on_disc::pad::equations::PAD;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs, uniform_draws};
use crate::numerics::eigenvalues::eigenvalues;
use crate::numerics::row::Number;

const FIRST: usize = Places::FIRST_AMPLITUDE;

fn lane(value: f64) -> Row<1> {
    Row::splat(value)
}

/// An invented brake in one lane, whose matrix has the structure of a real one.
struct Invented<'a> {
    geometry: &'a DiscGeometry,
    batch: Batch<1>,
}

impl<'a> Invented<'a> {
    /// Each coupling is left out as often as not; the others are of the size `strength`.
    fn new(geometry: &'a DiscGeometry, strength: f64, draw: &mut impl FnMut() -> f64) -> Self {
        let Places { size, phi, x, even, odd } = Places::new(geometry);
        let averages = &geometry.patch.averages;
        let mut batch = Batch::<1>::new(geometry);
        let Batch { coefficients: of, work, .. } = &mut batch;
        of.pad.normal_stiffness = lane(0.5 + 3.0 * draw());
        of.pad.pressure_gain = lane(0.1 + draw());
        of.pad.normal_damping = lane(0.3 + 2.0 * draw());
        of.disc_damping = lane(0.3 + 2.0 * draw());
        of.pad.angular_damping = lane(0.1 + 2.0 * draw());
        of.pad.tangential_damping = lane(0.1 * draw());
        let mut coupling = |share: f64| {
            let size = strength * (2.0 * draw() - 1.0);
            lane(if draw() < share { size } else { 0.0 })
        };
        let pressure: Vec<f64> = averages.shape.iter().map(|shape| -of.pad.pressure_gain.0[0] * shape).collect();
        // Rows that the pressure couples: the entry at y is free, those at the even amplitudes are parallel.
        let mut rows = [0, phi, x];
        for row in &mut rows {
            let parallel = if *row == 0 { lane(1.0) } else { coupling(0.5) };
            for (entry, pressure) in work.matrix[*row * size + FIRST..].iter_mut().zip(&pressure) {
                *entry = parallel * lane(*pressure);
            }
            work.matrix[*row * size] = coupling(0.5);
        }
        for row in 0..phi {
            // Columns of phi and x, the follower load of y, and what the columns of x are by speed.
            work.matrix[row * size + phi] = coupling(0.3);
            work.matrix[row * size + x] = coupling(0.3);
            work.damping_by_x[row] = coupling(0.3);
        }
        for row in FIRST..phi {
            work.matrix[row * size] = 0.2 * coupling(0.3);
            for column in FIRST..phi {
                work.matrix[row * size + column] = 0.1 * coupling(0.1);
            }
        }
        work.matrix[x * size + phi] = coupling(0.5);
        work.matrix[phi * size + x] = coupling(0.5);
        work.damping_by_x[phi] = coupling(0.5);
        work.damping_by_x[x] = 0.1 * coupling(0.5);
        work.matrix[phi * size + phi] = lane(0.5 + 8.0 * draw());
        work.matrix[x * size + x] = lane(0.5 + 4.0 * draw());
        let contact = of.pad.normal_stiffness + of.pad.pressure_gain;
        work.matrix[0] += contact;
        for (stiffness, compliance) in work.stiffness.iter_mut().zip(&mut work.compliance) {
            *stiffness = lane(1.0 + 9.0 * draw());
            *compliance = lane(0.05 + draw());
        }
        let turning = if draw() < 0.5 { 0.0 } else { 2.0 * draw() };
        for &(i, j) in &geometry.pairs {
            (work.stiffness[j], work.compliance[j]) = (work.stiffness[i], work.compliance[i]);
            (work.gyroscopic[i], work.gyroscopic[j]) = (lane(turning), lane(-turning));
        }
        for k in 0..even + odd {
            let (products, start) = match k.checked_sub(even) {
                None => (&averages.even_even[k * even..(k + 1) * even], FIRST),
                Some(j) => (&averages.odd_odd[j * odd..(j + 1) * odd], FIRST + even),
            };
            let row = &mut work.matrix[(FIRST + k) * size..(FIRST + k + 1) * size];
            for (entry, product) in row[start..].iter_mut().zip(products) {
                *entry += *product * work.compliance[k];
            }
            row[FIRST + k] += work.stiffness[k];
            if k < even {
                row[0] -= averages.shape[k] * work.compliance[k];
            }
        }
        Self { geometry, batch }
    }

    /// The couplings; this scales the core.
    fn couplings(&mut self) -> Couplings<1> {
        let Batch { coefficients: of, work, .. } = &mut self.batch;
        Couplings::of_scaled(Places::new(self.geometry), &self.geometry.patch.averages, of, work)
    }

    /// A and B as they are in `work` now; without what x adds by its speed if `is_falling` is false.
    fn matrices(&self, is_falling: bool) -> (DMatrix<f64>, DMatrix<f64>) {
        let Places { size, phi, x, .. } = Places::new(self.geometry);
        let Batch { coefficients: of, work, .. } = &self.batch;
        let stiffness = DMatrix::from_fn(size, size, |i, j| work.matrix[i * size + j].0[0]);
        let mut damping = DMatrix::from_fn(size, size, |i, j| match (i == j, i) {
            (false, _) => 0.0,
            (_, 0) => of.pad.normal_damping.0[0],
            (_, i) if i < phi => of.disc_damping.0[0],
            (_, i) if i < x => of.pad.angular_damping.0[0],
            _ => of.pad.tangential_damping.0[0],
        });
        for &(i, j) in &self.geometry.pairs {
            damping[(FIRST + i, FIRST + j)] = work.gyroscopic[i].0[0];
            damping[(FIRST + j, FIRST + i)] = work.gyroscopic[j].0[0];
        }
        for i in 0..size {
            damping[(i, x)] += if is_falling { work.damping_by_x[i].0[0] } else { 0.0 };
        }
        (stiffness, damping)
    }

    /// The inverse of the core's least singular value, `1 / |S|` and `|h|` at a frequency.
    fn response(&self, omega: f64) -> [f64; 3] {
        let Places { size, phi, x, .. } = Places::new(self.geometry);
        let (stiffness, damping) = self.matrices(true);
        let all = DMatrix::from_fn(size, size, |i, j| {
            let square = if i == j { omega * omega } else { 0.0 };
            Complex::new(stiffness[(i, j)] - square, omega * damping[(i, j)])
        });
        let core = all.view((0, 0), (phi, phi)).into_owned();
        let least = core.clone().singular_values().min();
        let row = all.view((phi, 0), (1, phi));
        let s = all[(phi, phi)] - (row * core.lu().solve(&all.view((0, phi), (phi, 1))).unwrap())[(0, 0)];
        let rest = all.view((0, 0), (x, x)).into_owned();
        let h = (all.view((x, 0), (1, x)) * rest.lu().solve(&all.view((0, x), (x, 1))).unwrap())[(0, 0)];
        [1.0 / least, 1.0 / s.norm_sqr().sqrt(), h.norm_sqr().sqrt()]
    }

    fn growth_rate(&self, is_falling: bool) -> f64 {
        let (stiffness, damping) = self.matrices(is_falling);
        eigenvalues(&first_order(&-stiffness, &-damping)).unwrap()[0].re
    }

    /// Sets the tangential damping so that the growth rate vanishes, if any does.
    fn make_critical(&mut self, is_falling: bool) -> bool {
        let (mut low, mut high) = (-3.0, 3.0);
        let at = |invented: &mut Self, damping: f64| {
            invented.batch.coefficients.pad.tangential_damping = lane(damping);
            invented.growth_rate(is_falling)
        };
        if at(self, low) < 0.0 || at(self, high) > 0.0 {
            return false;
        }
        for _ in 0..45 {
            let middle = 0.5 * (low + high);
            if at(self, middle) > 0.0 { low = middle } else { high = middle }
        }
        true
    }
}

/// The preset with so few modes that each coupling weighs.
fn flexible(modes: usize) -> FlexibleBrake {
    let brake = PadOnDisc::preset_with(&[]);
    FlexibleBrake::of_modes(brake.clone(), &lowest_modes(&brake).unwrap()[..modes])
}

#[test]
fn no_response_exceeds_its_bounds_whichever_couplings_there_are() {
    let mut draw = uniform_draws(3);
    let (mut finite, mut close) = ([0; 3], [0; 3]);
    for modes in [2, 3] {
        let brake = flexible(modes);
        let geometry = &*brake.equations.geometry;
        for _ in 0..400 {
            let strength = libm::exp(-6.0 * draw());
            let mut invented = Invented::new(geometry, strength, &mut draw);
            let couplings = invented.couplings();
            let low = if draw() < 0.2 { 0.0 } else { 5.0 * draw() };
            let high = low + 0.3 * draw();
            let within = couplings.between(lane(low), lane(high));
            let beyond = couplings.beyond(lane(high));
            for step in 0..4 {
                // Within the interval, and beyond it, where h grows no faster than the square of the frequency.
                let omega = low + (high - low) * f64::from(step) / 3.0;
                let factor = 1.0 + f64::from(step) * f64::from(step);
                for (bounds, omega, growth) in [(&within, omega, 1.0), (&beyond, factor * high, factor * factor)] {
                    let [core, phi, x] = invented.response(omega);
                    let bounds = [bounds.core, bounds.phi, growth * bounds.x].map(|bound| bound.0[0]);
                    for (i, (exact, bound)) in [core, phi, x].into_iter().zip(bounds).enumerate() {
                        assert!(
                            bound.is_nan() || exact <= bound * (1.0 + 1e-9) + 1e-12,
                            "{i} at {omega}: {exact} {bound}"
                        );
                        finite[i] += u32::from(bound.is_finite());
                        close[i] += u32::from(exact > 0.5 * bound);
                    }
                }
            }
        }
    }
    assert!(finite.iter().all(|count| *count > 1300) && close.iter().all(|count| *count > 80), "{finite:?} {close:?}");
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn the_side_of_the_crossing_is_that_of_the_eigenvalues_next_to_stability() {
    let mut draw = uniform_draws(5);
    let mut decided = [0; 3];
    for modes in [2, 3] {
        let brake = flexible(modes);
        let geometry = &*brake.equations.geometry;
        for round in 0..160 {
            let is_falling = round % 2 == 0;
            let strength = libm::exp(-1.0 - 3.0 * draw());
            let mut invented = Invented::new(geometry, strength, &mut draw);
            let couplings = invented.couplings();
            if !invented.make_critical(is_falling) {
                continue;
            }
            let critical = invented.batch.coefficients.pad.tangential_damping.0[0];
            let omega = couplings.x_stiffness.sqrt();
            let half_width = half_width(&couplings, omega);
            for beside in [1e-7, 1e-5, 1e-4, 1e-3, 1e-2, 0.1, 1.0] {
                for sign in [-1.0, 1.0] {
                    invented.batch.coefficients.pad.tangential_damping = lane(critical + sign * beside * strength);
                    let Batch { coefficients: of, work, .. } = &mut invented.batch;
                    let Crossing { falling, steady } = crossing(geometry, of, work, &couplings, omega, half_width);
                    for (which, side) in [falling.0[0], steady.0[0]].into_iter().enumerate() {
                        if side != 0.0 {
                            let rate = invented.growth_rate(which == 0);
                            assert!(side * rate < 0.0, "{which} {is_falling} {beside}: {side} {rate} {strength}");
                            decided[which] += 1;
                        }
                    }
                    decided[2] += 1;
                }
            }
        }
    }
    let [falling, steady, all] = decided;
    assert!(2 * falling > all && 2 * steady > all, "{decided:?}");
}

#[test]
fn the_linearisation_is_that_of_the_equations_at_any_displacements() {
    let mut draw = uniform_draws(7);
    for changes in [vec![], vec![("disc.thickness", 0.013), ("operating_point.rotating_speed", 300.0)]] {
        let brake = FlexibleBrake::with_modes(PadOnDisc::preset_with(&changes), 6).unwrap();
        let geometry = &*brake.equations.geometry;
        let places = Places::new(geometry);
        let Places { size, phi, x, .. } = places;
        // The order of the elimination: y, the amplitudes, phi, x.
        let place = |i: usize| {
            if i == 0 {
                1
            } else if i < phi {
                PAD + i - 1
            } else if i == phi {
                2
            } else {
                0
            }
        };
        for _ in 0..20 {
            let inputs = RandomInputs { preload: 0.05 + 0.3 * draw(), static_friction: 0.25 + 0.3 * draw() };
            let mut batch = Batch::<1>::new(geometry);
            batch.set(0, geometry, brake.brake(), inputs);
            let Batch { coefficients: of, work, .. } = &mut batch;
            set_amplitudes(geometry, of, work);
            for (i, q) in work.q.iter_mut().enumerate() {
                // Pressed all over, and nothing small beside it.
                *q = lane(if i == 0 {
                    -0.5 - draw()
                } else if i == phi {
                    0.02 * (draw() - 0.5)
                } else {
                    0.1 * (draw() - 0.5)
                });
            }
            set_matrix(places, &geometry.patch.averages, of, work, true);
            let q: Vec<f64> = (0..size).map(|i| work.q[(0..size).find(|&k| place(k) == i).unwrap()].0[0]).collect();
            let (stiffness, damping) = brake.equations.linearise(inputs, &q);
            let largest = stiffness.amax();
            let (of_work, of_x) = matrix_and_column(work, of, size, x);
            for i in 0..size {
                for j in 0..size {
                    let (exact, found) = (-stiffness[(place(i), place(j))], of_work[(i, j)]);
                    assert!((exact - found).abs() < 1e-11 * largest, "{i} {j}: {found} {exact}");
                }
                let (exact, found) = (-damping[(place(i), 0)], of_x[i]);
                assert!((exact - found).abs() < 1e-11 * damping.amax(), "damping {i}: {found} {exact}");
            }
        }
    }
}

/// A and the column of x in B, as they are in `work`.
fn matrix_and_column(work: &Work<1>, of: &Coefficients<1>, size: usize, x: usize) -> (DMatrix<f64>, Vec<f64>) {
    let mut of_x: Vec<f64> = work.damping_by_x.iter().map(|entry| entry.0[0]).collect();
    of_x[x] += of.pad.tangential_damping.0[0];
    (DMatrix::from_fn(size, size, |i, j| work.matrix[i * size + j].0[0]), of_x)
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn a_patch_that_may_be_lifted_by_its_tilt_is_left_to_the_eigenvalues() {
    let mut draw = uniform_draws(11);
    let mut counts = [0; 2];
    for _ in 0..200 {
        let arm = 0.008 * libm::exp(4.0 * draw());
        let stiffness = 0.3 + draw();
        let changes = [("pad.moment_arm", arm), ("disc.youngs_modulus", 2.1e11 * stiffness)];
        let brake = FlexibleBrake::with_modes(PadOnDisc::preset_with(&changes), 5).unwrap();
        let geometry = &*brake.equations.geometry;
        let Places { phi, .. } = Places::new(geometry);
        let mut batch = Batch::<1>::new(geometry);
        batch.set(0, geometry, brake.brake(), RandomInputs { preload: 0.1, static_friction: 0.39 });
        let Batch { coefficients: of, work, .. } = &mut batch;
        set_amplitudes(geometry, of, work);
        let [found] = find_equilibrium(geometry, of, work);
        let amplitudes: Vec<f64> = work.q[FIRST..phi].iter().map(|amplitude| amplitude.0[0]).collect();
        let angle = work.q[phi].0[0];
        let q = [0.0, work.q[0].0[0], angle];
        let position = brake.equations.position(&q, (libm::sin(angle), libm::cos(angle)));
        let is_whole = geometry.patch.is_surely_whole(position, &amplitudes);
        assert!(found == 0 || is_whole, "{arm} {angle}");
        counts[usize::from(found == 0)] += 1;
    }
    assert!(counts.iter().all(|count| *count > 20), "{counts:?}");
}
