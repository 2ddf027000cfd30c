//! A step of slip in the lanes of a flexible disc.

use crate::flexible_disc::equations::FlexibleEquations;
use crate::friction::shape::tustin_decay;
use crate::lanes::findings::{EVENT, findings};
use crate::motion::friction_steps::FrictionSteps;
use crate::numerics::sine_cosine::{SERIES_ANGLE, small_sine_and_cosine};
use crate::pad::equations::PAD;

/// Lanes: as many as keep all degrees of freedom of a step in the first-level cache.
pub(super) const LANES: usize = 16;

/// Rows of sums that are kept in registers together.
const ROWS_AT_ONCE: usize = 2;

/// One value for each lane of a flexible disc.
pub(super) type Row = [f64; LANES];

pub(super) struct InputRows {
    pub preload: Row,
    pub static_friction: Row,
}

pub(super) struct FlexibleArrays {
    pub inputs: InputRows,
    pub friction_steps: [FrictionSteps; LANES],
    pub q: Vec<Row>,
    pub u: Vec<Row>,
    pub next_q: Vec<Row>,
    pub next_u: Vec<Row>,
    pub stage_q: Vec<Row>,
    pub stage_u: Vec<Row>,
    pub k: [Vec<Row>; 4],
    pub contact: ContactRows,
    /// 1 in lanes whose step stayed where the fast path and the series hold, 0 in others.
    pub plain: [u64; LANES],
    pub findings: [u64; LANES],
}

/// Products of amplitudes, and the loads that come from them.
pub(super) struct ContactRows {
    pub even_products: Vec<Row>,
    pub odd_products: Vec<Row>,
    pub on_modes: Vec<Row>,
    pub follower: Vec<Row>,
}

/// The averages of [`crate::flexible_disc::contact`] product by product: the factors of a product in all loads are
/// neighbours.
pub(super) struct Tables {
    pub even_even: Vec<f64>,
    pub odd_odd: Vec<f64>,
    pub even_follower: Vec<f64>,
    pub odd_follower: Vec<f64>,
}

/// From one list of factors for each row to one list of rows for each factor.
pub(super) fn transposed(rows: &[Vec<f64>]) -> Vec<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    (0..columns).flat_map(|column| rows.iter().map(move |row| row[column])).collect()
}

pub(super) fn square(products: &[f64], size: usize) -> Vec<f64> {
    let rows: Vec<Vec<f64>> = products.chunks(size.max(1)).map(<[f64]>::to_vec).collect();
    transposed(&rows)
}

/// A row from a function of the lane. A macro and not a function: what is not inlined is compiled for the baseline.
macro_rules! row {
    (|$lane:ident| $value:expr) => {{
        let mut row = [0.0; LANES];
        for $lane in 0..LANES {
            row[$lane] = $value;
        }
        row
    }};
}

/// [`crate::motion::flexible`]'s step of slip.
#[inline(always)]
pub(super) fn flexible_step(brake: &FlexibleEquations, tables: &Tables, lanes: &mut FlexibleArrays, h: f64) {
    let (half, sixth) = (0.5 * h, h / 6.0);
    let n = brake.size();
    let FlexibleArrays {
        inputs,
        friction_steps: steps,
        q,
        u,
        next_q,
        next_u,
        stage_q,
        stage_u,
        k,
        contact,
        plain,
        findings: out,
    } = lanes;
    let [k1, k2, k3, k4] = k;
    *plain = [1; LANES];
    flexible_rates(brake, tables, inputs, (q, u), contact, plain, k1);
    for i in 0..n {
        let (q, u, k) = (&q[i], &u[i], &k1[i]);
        stage_q[i] = row!(|l| q[l] + half * u[l]);
        stage_u[i] = row!(|l| u[l] + half * k[l]);
    }
    flexible_rates(brake, tables, inputs, (stage_q, stage_u), contact, plain, k2);
    for i in 0..n {
        let (q, u, k, stage) = (&q[i], &u[i], &k2[i], stage_u[i]);
        stage_q[i] = row!(|l| q[l] + half * stage[l]);
        stage_u[i] = row!(|l| u[l] + half * k[l]);
    }
    flexible_rates(brake, tables, inputs, (stage_q, stage_u), contact, plain, k3);
    for i in 0..n {
        let (q, u, k, stage) = (&q[i], &u[i], &k3[i], stage_u[i]);
        stage_q[i] = row!(|l| q[l] + h * stage[l]);
        stage_u[i] = row!(|l| u[l] + h * k[l]);
    }
    flexible_rates(brake, tables, inputs, (stage_q, stage_u), contact, plain, k4);
    for i in 0..n {
        let (q, u, k1, k2, k3, k4) = (&q[i], &u[i], &k1[i], &k2[i], &k3[i], &k4[i]);
        next_q[i] = row!(|l| q[l] + h * (u[l] + sixth * (k1[l] + k2[l] + k3[l])));
        next_u[i] = row!(|l| u[l] + sixth * (k1[l] + 2.0 * (k2[l] + k3[l]) + k4[l]));
    }
    for l in 0..LANES {
        let (ends, acceleration) = ((u[0][l], next_u[0][l]), (k1[0][l], k4[0][l]));
        let met = findings(&steps[l], brake.pad.disc_speed, ends, next_q[0][l], acceleration, h);
        out[l] = met | ((1 - plain[l]) * EVENT);
    }
}

/// [`FlexibleEquations`]'s accelerations in slip with the whole patch in contact; clears `plain` where that may not
/// hold.
#[inline(always)]
fn flexible_rates(
    brake: &FlexibleEquations,
    tables: &Tables,
    inputs: &InputRows,
    (q, u): (&[Row], &[Row]),
    contact: &mut ContactRows,
    plain: &mut [u64; LANES],
    accelerations: &mut [Row],
) {
    let (pad, averages) = (&brake.pad, &brake.geometry.patch.averages);
    let (x, y, phi) = (&q[0], &q[1], &q[2]);
    let (x_speed, y_speed, phi_speed) = (&u[0], &u[1], &u[2]);
    let amplitudes = &q[PAD..];
    let (a, b) = amplitudes.split_at(brake.geometry.patch.even);
    let [mut sine, mut cosine] = [[0.0; LANES]; 2];
    for l in 0..LANES {
        (sine[l], cosine[l]) = small_sine_and_cosine(phi[l]);
    }
    let minus_tilt = row!(|l| -(sine[l] / cosine[l] * brake.tilt_scale));
    let minus_y = row!(|l| -y[l]);
    let mut margin = row!(|l| minus_y[l] - averages.largest_arc * minus_tilt[l].abs());
    for (amplitude, largest) in amplitudes.iter().zip(&averages.largest_shape) {
        margin = row!(|l| margin[l] - largest * amplitude[l].abs());
    }
    for l in 0..LANES {
        plain[l] &= u64::from((margin[l] > 0.0) & (phi[l].abs() <= SERIES_ANGLE));
    }

    let mut mean = minus_y;
    for (shape, a) in averages.shape.iter().zip(a) {
        mean = row!(|l| mean[l] + shape * a[l]);
    }
    let ContactRows { even_products, odd_products, on_modes, follower } = contact;
    let (even_on_modes, odd_on_modes) = on_modes.split_at_mut(brake.geometry.patch.even);
    let (even_follower, odd_follower) = follower.split_at_mut(brake.geometry.patch.even);
    for (load, shape) in even_on_modes.iter_mut().zip(&averages.shape) {
        *load = row!(|l| minus_y[l] * shape);
    }
    accumulate(even_on_modes, &tables.even_even, a);
    for (load, shape) in odd_on_modes.iter_mut().zip(&averages.arc_shape) {
        *load = row!(|l| minus_tilt[l] * shape);
    }
    accumulate(odd_on_modes, &tables.odd_odd, b);

    let (mixed, rest) = even_products.split_at_mut(a.len() * b.len());
    for (products, a) in mixed.chunks_exact_mut(b.len().max(1)).zip(a) {
        multiply(products, a, b);
    }
    let (by_normal, by_tilt) = rest.split_at_mut(b.len());
    multiply(by_normal, &minus_y, b);
    multiply(by_tilt, &minus_tilt, a);
    even_follower.fill([0.0; LANES]);
    accumulate(even_follower, &tables.even_follower, even_products);

    let mut rest = &mut odd_products[..];
    for amplitudes in [a, b] {
        for first in 0..amplitudes.len() {
            let others = &amplitudes[first..];
            let (products, further) = rest.split_at_mut(others.len());
            multiply(products, &amplitudes[first], others);
            rest = further;
        }
    }
    let (by_normal, by_tilt) = rest.split_at_mut(a.len());
    multiply(by_normal, &minus_y, a);
    multiply(by_tilt, &minus_tilt, b);
    odd_follower.fill([0.0; LANES]);
    accumulate(odd_follower, &tables.odd_follower, odd_products);

    let ratio = row!(|l| {
        let r = (pad.disc_speed - x_speed[l]) * pad.inverse_stribeck;
        pad.kinetic_friction + (inputs.static_friction[l] - pad.kinetic_friction) * tustin_decay(r)
    });
    let pressure = row!(|l| pad.pressure_gain * mean[l]);
    let spring = row!(|l| pad.contact_tangential * x[l] - pad.transmission * ratio[l] * pressure[l]);
    accelerations[0] = row!(|l| {
        let pull = pad.tangential_damping * x_speed[l] + pad.tangential_stiffness * x[l] + pressure[l] * sine[l];
        -(pull + spring[l] * cosine[l])
    });
    accelerations[1] = row!(|l| {
        -(pad.normal_damping * y_speed[l] + pad.normal_stiffness * (inputs.preload[l] + y[l]) - pressure[l] * cosine[l]
            + spring[l] * sine[l])
    });
    accelerations[2] =
        row!(|l| -(pad.angular_damping * phi_speed[l] + pad.angular_stiffness * phi[l] + pad.arm * spring[l]));
    let follower_ratio = row!(|l| ratio[l] * brake.slope_scale);
    for (k, amplitude) in brake.amplitudes.iter().enumerate() {
        let (value, speed, partner_speed) = (&q[PAD + k], &u[PAD + k], &u[PAD + amplitude.partner]);
        let (load, follower) = (&on_modes[k], &follower[k]);
        accelerations[PAD + k] = row!(|l| {
            -(amplitude.stiffness * value[l] + brake.disc_damping * speed[l] + amplitude.gyroscopic * partner_speed[l])
                - amplitude.compliance * (load[l] + follower_ratio[l] * follower[l])
        });
    }
}

/// One factor times each of some rows.
#[inline(always)]
fn multiply(products: &mut [Row], factor: &Row, rows: &[Row]) {
    for (product, other) in products.iter_mut().zip(rows) {
        *product = row!(|l| factor[l] * other[l]);
    }
}

/// Adds `factors * products` to rows, each sum in the order of the products. Some rows are taken at a time, so that
/// their sums stay in registers.
#[inline(always)]
fn accumulate(rows: &mut [Row], factors: &[f64], products: &[Row]) {
    let count = rows.len();
    let mut first = 0;
    while first < count {
        if count - first >= ROWS_AT_ONCE {
            accumulate_some::<ROWS_AT_ONCE>(rows, first, factors, products);
            first += ROWS_AT_ONCE;
        } else {
            accumulate_some::<1>(rows, first, factors, products);
            first += 1;
        }
    }
}

#[inline(always)]
fn accumulate_some<const ROWS: usize>(rows: &mut [Row], first: usize, factors: &[f64], products: &[Row]) {
    let count = rows.len();
    let mut sums = [[0.0; LANES]; ROWS];
    sums.copy_from_slice(&rows[first..first + ROWS]);
    for (product, factors) in products.iter().zip(factors.chunks_exact(count)) {
        let factors = &factors[first..first + ROWS];
        for row in 0..ROWS {
            for l in 0..LANES {
                sums[row][l] += factors[row] * product[l];
            }
        }
    }
    rows[first..first + ROWS].copy_from_slice(&sums);
}
