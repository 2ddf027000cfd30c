//! A trial step in the lanes of a flexible disc.

use crate::models::pad_on_disc::flexible_disc::equations::{Coefficients, LoadsOnModes};
use crate::models::pad_on_disc::lanes::contact_loads::{Amplitudes, LoadRows, Tables, contact_loads};
use crate::models::pad_on_disc::lanes::findings::findings;
use crate::models::pad_on_disc::lanes::pace::Pace;
use crate::models::pad_on_disc::lanes::{BLOCK, Row};
use crate::models::pad_on_disc::motion::friction_steps::{FrictionSteps, MOST_GROWTH};
use crate::models::pad_on_disc::pad::equations::{Contact, PAD, PadInputs};
use crate::numerics::row::{self, Number};
use crate::numerics::runge_kutta::{Accelerations, step_in_place};
use crate::numerics::sine_cosine::{SERIES_ANGLE, small_sine_and_cosine};

/// Displacements and speeds.
#[derive(Debug, Clone)]
pub(super) struct StateRows {
    pub q: Vec<Row>,
    pub u: Vec<Row>,
}

/// The lanes of a flexible disc.
pub(super) struct FlexibleLanes {
    pub tables: Tables,
    pub coefficients: Coefficients<Row>,
    pub inputs: PadInputs<Row>,
    pub friction_steps: FrictionSteps<Row>,
    /// 1 in lanes whose pad sticks, 0 in others.
    pub sticks: Row,
    pub present: StateRows,
    pub next: StateRows,
    pub k: [Vec<Row>; 4],
    pub loads: LoadRows,
    /// 1 in lanes whose step stayed where the fast path and the series hold, 0 in others.
    pub plain: [u64; BLOCK],
    pub pace: Pace<BLOCK>,
    pub visits: u64,
}

impl FlexibleLanes {
    /// Without samples.
    pub fn idle(tables: Tables) -> Self {
        let amplitudes = tables.even + tables.odd;
        let rows = |count: usize| vec![Row::ZERO; count];
        let state = || StateRows { q: rows(PAD + amplitudes), u: rows(PAD + amplitudes) };
        Self {
            tables,
            coefficients: Coefficients { amplitudes: vec![Default::default(); amplitudes], ..Default::default() },
            inputs: PadInputs::default(),
            friction_steps: FrictionSteps::default(),
            sticks: Row::ZERO,
            present: state(),
            next: state(),
            k: std::array::from_fn(|_| rows(PAD + amplitudes)),
            loads: LoadRows { on_modes: rows(amplitudes), follower: rows(amplitudes) },
            plain: [0; BLOCK],
            pace: Pace::default(),
            visits: 0,
        }
    }
}

/// [`crate::models::pad_on_disc::motion::flexible`]'s step of slip or stick, with `W` lanes of the contact's loads at a time.
#[inline(always)]
pub(super) fn flexible_step<const W: usize>(lanes: &mut FlexibleLanes) {
    std::mem::swap(&mut lanes.present, &mut lanes.next);
    let FlexibleLanes { tables, coefficients, inputs, friction_steps, sticks, loads, plain, pace, .. } = lanes;
    let (StateRows { q, u }, StateRows { q: next_q, u: next_u }) = (&lanes.present, &mut lanes.next);
    let h = row::Row(pace.length);
    *plain = [1; BLOCK];
    let contact = Contact { sticks: *sticks, direction: 1.0 };
    let mut equations = InLanes::<W> { tables, coefficients, inputs, contact, loads, plain, first_ratio: None };
    step_in_place(&mut equations, (q, u), h, (next_q, next_u), &mut lanes.k);
    let first_ratio = equations.first_ratio.unwrap_or_default();
    let [first, .., last] = &lanes.k;
    let mut trials = findings(friction_steps, &next_q[0], (&u[0], &next_u[0]), (&first[0], &last[0]), &h);
    let released = if sticks.any() {
        let mut whole = *plain;
        let patch = WholePatch::at(tables, coefficients, next_q, &mut whole);
        let (_, last_ratio) = coefficients.pad.hold(next_q, next_u, patch.angle, patch.pressure);
        let held = coefficients.pad.friction_at_rest(inputs.static_friction);
        let mut released = [0; BLOCK];
        for l in 0..BLOCK {
            let holds = |ratio: f64| (held.0[l] - ratio > 0.0) & (held.0[l] + ratio > 0.0);
            released[l] = u64::from(!(holds(first_ratio.0[l]) & holds(last_ratio.0[l]))) | (1 - whole[l]);
        }
        released
    } else {
        [0; BLOCK]
    };
    for l in 0..BLOCK {
        let sticks = u64::from(sticks.0[l] != 0.0);
        let slips = 1 - sticks;
        trials.is_too_long[l] &= slips & plain[l];
        trials.turns[l] &= slips;
        trials.factor[l] = if sticks == 1 { MOST_GROWTH } else { trials.factor[l] };
        trials.is_event[l] = (trials.is_event[l] & slips) | (released[l] & sticks) | (1 - plain[l]);
    }
    pace.judge(&trials);
    lanes.visits = pace.visits();
}

/// A patch that is pressed as a whole.
struct WholePatch {
    /// Sine and cosine of phi.
    angle: (Row, Row),
    minus_tilt: Row,
    minus_y: Row,
    /// P / (M eta0).
    pressure: Row,
}

impl WholePatch {
    /// At displacements `q`; clears `plain` where the patch may have lifted off in part, or the series do not hold.
    #[inline(always)]
    fn at(tables: &Tables, coefficients: &Coefficients<Row>, q: &[Row], plain: &mut [u64; BLOCK]) -> Self {
        let (y, phi, amplitudes) = (q[1], &q[2], &q[PAD..]);
        let (mut sine, mut cosine) = (Row::ZERO, Row::ZERO);
        for l in 0..BLOCK {
            (sine.0[l], cosine.0[l]) = small_sine_and_cosine(phi.0[l]);
        }
        let (minus_y, minus_tilt) = (-y, -(sine / cosine * coefficients.tilt_scale));
        let least = tables.averages.least_gap(minus_y, minus_tilt, amplitudes);
        for (plain, (least, phi)) in plain.iter_mut().zip(least.0.iter().zip(&phi.0)) {
            *plain &= u64::from((*least > 0.0) & (phi.abs() <= SERIES_ANGLE));
        }
        let pressure = coefficients.pad.pressure_gain * tables.averages.mean_gap(minus_y, amplitudes);
        Self { angle: (sine, cosine), minus_tilt, minus_y, pressure }
    }
}

/// [`FlexibleEquations`](crate::models::pad_on_disc::flexible_disc::equations::FlexibleEquations) with the whole patch
/// in contact; clears `plain` where that may not hold.
struct InLanes<'a, const W: usize> {
    tables: &'a Tables,
    coefficients: &'a Coefficients<Row>,
    inputs: &'a PadInputs<Row>,
    contact: Contact<Row>,
    loads: &'a mut LoadRows,
    plain: &'a mut [u64; BLOCK],
    /// The friction over the pressure at the first stage.
    first_ratio: Option<Row>,
}

impl<const W: usize> Accelerations<Row> for InLanes<'_, W> {
    #[inline(always)]
    fn accelerations(&mut self, q: &[Row], u: &[Row], accelerations: &mut [Row]) {
        let WholePatch { angle, minus_tilt, minus_y, pressure } =
            WholePatch::at(self.tables, self.coefficients, q, self.plain);
        let (even, odd) = q[PAD..].split_at(self.tables.even);
        let amplitudes = Amplitudes { minus_y: &minus_y, minus_tilt: &minus_tilt, even, odd };
        contact_loads::<W>(self.tables, amplitudes, self.loads);
        let loads = LoadsOnModes { on_modes: &self.loads.on_modes, follower: &self.loads.follower };
        let forces =
            self.coefficients.accelerations(self.inputs, self.contact, (q, u), (angle, pressure), loads, accelerations);
        self.first_ratio.get_or_insert(forces.friction_ratio);
    }
}
