//! Lanes of a flexible disc.

use crate::criterion::decision::Decision;
use crate::criterion::flexible_monitor::CoupledJudge;
use crate::criterion::time_domain::TimeDomain;
use crate::flexible_disc::brake::FlexibleBrake;
use crate::flexible_disc::equations::FlexibleEquations;
use crate::friction::tustin_decay;
use crate::lanes::dispatch::{InstructionSet, dispatch};
use crate::lanes::findings::{EVENT, Finding, findings, found};
use crate::lanes::scheduling::{Bundle, Slot};
use crate::motion::flexible::{FlexibleMotion, FlexibleSample, FlexibleState, MOST_FREEDOMS};
use crate::motion::friction_steps::FrictionSteps;
use crate::motion::integrator::{Breakdown, Motion, advance};
use crate::numerics::sine_cosine::{SERIES_ANGLE, small_sine_and_cosine};
use crate::pad::contact_state::ContactState;
use crate::pad::equations::PAD;
use crate::rigid_disc::pad_on_disc::RandomInputs;

/// Lanes: as many as keep all degrees of freedom of a step in the first-level cache.
pub(super) const LANES: usize = 16;

/// Rows of sums that are kept in registers together.
const ROWS_AT_ONCE: usize = 2;

/// One value for each lane of a flexible disc.
type Row = [f64; LANES];

/// Lanes of a flexible disc.
pub(super) struct FlexibleBundle<'a> {
    motion: &'a FlexibleMotion,
    tables: Tables,
    inputs: [RandomInputs; LANES],
    lanes: FlexibleArrays,
}

struct InputRows {
    preload: Row,
    static_friction: Row,
}

struct FlexibleArrays {
    inputs: InputRows,
    friction_steps: [FrictionSteps; LANES],
    q: Vec<Row>,
    u: Vec<Row>,
    next_q: Vec<Row>,
    next_u: Vec<Row>,
    stage_q: Vec<Row>,
    stage_u: Vec<Row>,
    k: [Vec<Row>; 4],
    contact: ContactRows,
    /// 1 in lanes whose step stayed where the fast path and the series hold, 0 in others.
    plain: [u64; LANES],
    findings: [u64; LANES],
}

/// Products of amplitudes, and the loads that come from them.
struct ContactRows {
    even_products: Vec<Row>,
    odd_products: Vec<Row>,
    on_modes: Vec<Row>,
    follower: Vec<Row>,
}

/// The averages of [`crate::flexible_disc::contact`], one after the other: for each product its factors in the loads on some rows.
struct Tables {
    even_even: Vec<f64>,
    odd_odd: Vec<f64>,
    even_follower: Vec<f64>,
    odd_follower: Vec<f64>,
}

/// From one list of factors for each row to one list of rows for each factor.
fn transposed(rows: &[Vec<f64>]) -> Vec<f64> {
    let columns = rows.first().map_or(0, Vec::len);
    (0..columns).flat_map(|column| rows.iter().map(move |row| row[column])).collect()
}

fn square(products: &[f64], size: usize) -> Vec<f64> {
    let rows: Vec<Vec<f64>> = products.chunks(size.max(1)).map(<[f64]>::to_vec).collect();
    transposed(&rows)
}

impl<'a> FlexibleBundle<'a> {
    pub fn new(motion: &'a FlexibleMotion) -> Self {
        let brake = &motion.brake.equations;
        let (size, averages) = (brake.size(), &brake.patch.averages);
        let inputs = RandomInputs { preload: 0.0, static_friction: 0.0 };
        let rows = |count: usize| vec![[0.0; LANES]; count];
        let tables = Tables {
            even_even: square(&averages.even_even, brake.patch.even),
            odd_odd: square(&averages.odd_odd, brake.patch.odd),
            even_follower: transposed(&averages.even_follower),
            odd_follower: transposed(&averages.odd_follower),
        };
        let contact = ContactRows {
            even_products: rows(averages.even_follower.first().map_or(0, Vec::len)),
            odd_products: rows(averages.odd_follower.first().map_or(0, Vec::len)),
            on_modes: rows(size - PAD),
            follower: rows(size - PAD),
        };
        let lanes = FlexibleArrays {
            inputs: InputRows { preload: [0.0; LANES], static_friction: [0.0; LANES] },
            friction_steps: [motion.friction_steps(inputs); LANES],
            q: rows(size),
            u: rows(size),
            next_q: rows(size),
            next_u: rows(size),
            stage_q: rows(size),
            stage_u: rows(size),
            k: [rows(size), rows(size), rows(size), rows(size)],
            contact,
            plain: [0; LANES],
            findings: [0; LANES],
        };
        Self { motion, tables, inputs: [inputs; LANES], lanes }
    }

    fn size(&self) -> usize {
        self.motion.brake.equations.size()
    }

    fn present(&self, lane: usize) -> FlexibleState {
        let mut state = FlexibleState { q: [0.0; MOST_FREEDOMS], u: [0.0; MOST_FREEDOMS] };
        for i in 0..self.size() {
            state.q[i] = self.lanes.q[i][lane];
            state.u[i] = self.lanes.u[i][lane];
        }
        state
    }

    fn set_sample(&mut self, lane: usize, sample: &FlexibleSample<'_>) {
        self.inputs[lane] = sample.inputs;
        self.lanes.inputs.preload[lane] = sample.inputs.preload;
        self.lanes.inputs.static_friction[lane] = sample.inputs.static_friction;
        self.lanes.friction_steps[lane] = sample.friction_steps;
    }

    fn set_next(&mut self, lane: usize, state: &FlexibleState) {
        for i in 0..self.size() {
            self.lanes.next_q[i][lane] = state.q[i];
            self.lanes.next_u[i][lane] = state.u[i];
        }
    }
}

impl Bundle for FlexibleBundle<'_> {
    const LANES: usize = LANES;

    type Judge = CoupledJudge;

    fn begin(
        &mut self,
        criterion: &TimeDomain,
        lane: usize,
        inputs: RandomInputs,
    ) -> Result<(ContactState, CoupledJudge), Decision> {
        let sample = self.motion.sample(inputs);
        let (motion, judge) = criterion.start_flexible(&sample, FlexibleBrake::linear_stability)?;
        self.set_sample(lane, &sample);
        self.set_next(lane, &motion.state);
        Ok((motion.contact, judge))
    }

    fn place(&mut self, criterion: &TimeDomain, lane: usize, inputs: RandomInputs) {
        let sample = self.motion.sample(inputs);
        if let Ok((motion, _)) = criterion.flexible_start(&sample) {
            self.set_sample(lane, &sample);
            self.set_next(lane, &motion.state);
        }
    }

    fn step(&mut self, set: InstructionSet) {
        let (brake, h) = (&self.motion.brake.equations, self.motion.step);
        let (tables, lanes) = (&self.tables, &mut self.lanes);
        dispatch!(set, flexible_step, brake: &FlexibleEquations, tables: &Tables, lanes: &mut FlexibleArrays, h: f64);
    }

    fn finding(&self, lane: usize) -> Finding {
        found(self.lanes.findings[lane])
    }

    fn tangential(&self, lane: usize) -> (f64, (f64, f64), (f64, f64)) {
        let lanes = &self.lanes;
        let acceleration = (lanes.k[0][0][lane], lanes.k[3][0][lane]);
        (lanes.q[0][lane], (lanes.u[0][lane], lanes.next_u[0][lane]), acceleration)
    }

    fn next(&self, lane: usize) -> (f64, f64) {
        (self.lanes.next_q[0][lane], self.lanes.next_u[0][lane])
    }

    fn scalar_step(
        &mut self,
        lane: usize,
        contact: ContactState,
        time: f64,
        judge: &mut Self::Judge,
    ) -> Result<ContactState, Breakdown> {
        let mut motion = Motion { state: self.present(lane), contact };
        advance(&self.motion.sample(self.inputs[lane]), &mut motion, time, self.motion.step, judge)?;
        self.set_next(lane, &motion.state);
        Ok(motion.contact)
    }

    fn commit(&mut self) {
        std::mem::swap(&mut self.lanes.q, &mut self.lanes.next_q);
        std::mem::swap(&mut self.lanes.u, &mut self.lanes.next_u);
    }

    fn step_length(&self) -> f64 {
        self.motion.step
    }

    fn finish(&self, criterion: &TimeDomain, lane: usize, slot: &Slot<Self::Judge>, steps: u64) -> Decision {
        let sample = self.motion.sample(self.inputs[lane]);
        let motion = Motion { state: self.present(lane), contact: slot.contact };
        criterion.follow(&sample, motion, slot.judge, self.motion.step, steps)
    }
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
fn flexible_step(brake: &FlexibleEquations, tables: &Tables, lanes: &mut FlexibleArrays, h: f64) {
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

/// [`FlexibleEquations`]'s accelerations in slip with the whole patch in contact; clears `plain` where that may not hold.
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
    let (pad, averages) = (&brake.pad, &brake.patch.averages);
    let (x, y, phi) = (&q[0], &q[1], &q[2]);
    let (x_speed, y_speed, phi_speed) = (&u[0], &u[1], &u[2]);
    let amplitudes = &q[PAD..];
    let (a, b) = amplitudes.split_at(brake.patch.even);
    let [mut sine, mut cosine] = [[0.0; LANES]; 2];
    for l in 0..LANES {
        (sine[l], cosine[l]) = small_sine_and_cosine(phi[l]);
    }
    let minus_tilt = row!(|l| -(sine[l] / cosine[l]));
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
    let (even_on_modes, odd_on_modes) = on_modes.split_at_mut(brake.patch.even);
    let (even_follower, odd_follower) = follower.split_at_mut(brake.patch.even);
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
    for (k, amplitude) in brake.amplitudes.iter().enumerate() {
        let (value, speed, partner_speed) = (&q[PAD + k], &u[PAD + k], &u[PAD + amplitude.partner]);
        let (load, follower) = (&on_modes[k], &follower[k]);
        accelerations[PAD + k] = row!(|l| {
            -(amplitude.stiffness * value[l] + brake.disc_damping * speed[l] + amplitude.gyroscopic * partner_speed[l])
                - amplitude.compliance * (load[l] + ratio[l] * follower[l])
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
