//! A trial step in the lanes of a flexible disc.

use crate::friction::shape::Shape;
use crate::lanes::BLOCK;
use crate::lanes::contact_loads::{Amplitudes, LoadRows, Row, Tables, contact_loads};
use crate::lanes::findings::{Slip, findings};
use crate::lanes::pace::Pace;
use crate::motion::friction_steps::MOST_GROWTH;
use crate::numerics::sine_cosine::{SERIES_ANGLE, small_sine_and_cosine};
use crate::pad::equations::PAD;

/// Coefficients of the pad's equations ([`crate::pad::equations::PadEquations`]) and the inputs of the samples.
#[derive(Debug, Clone)]
pub(super) struct PadRows {
    pub tangential_damping: Row,
    pub tangential_stiffness: Row,
    pub contact_tangential: Row,
    pub normal_damping: Row,
    pub normal_stiffness: Row,
    pub angular_damping: Row,
    pub angular_stiffness: Row,
    pub arm: Row,
    pub pressure_gain: Row,
    pub transmission: Row,
    pub kinetic_friction: Row,
    /// e of the friction law.
    pub additional_friction: Row,
    /// mu at rest.
    pub friction_at_rest: Row,
    pub static_friction: Row,
    pub preload: Row,
    /// See [`crate::flexible_disc::equations::FlexibleEquations`].
    pub tilt_scale: Row,
    pub slope_scale: Row,
}

/// Coefficients of an amplitude of the disc.
#[derive(Debug, Clone)]
pub(super) struct AmplitudeRows {
    pub stiffness: Row,
    pub gyroscopic: Row,
    pub compliance: Row,
    pub partner: usize,
}

/// Displacements and speeds.
#[derive(Debug, Clone)]
pub(super) struct StateRows {
    pub q: Vec<Row>,
    pub u: Vec<Row>,
}

/// The lanes of a flexible disc.
pub(super) struct FlexibleLanes {
    pub tables: Tables,
    pub shape: Shape,
    pub pad: PadRows,
    pub amplitudes: Vec<AmplitudeRows>,
    pub disc_damping: Row,
    pub slip: Slip<BLOCK>,
    /// 1 in lanes whose pad sticks, 0 in others.
    pub sticks: [u64; BLOCK],
    pub present: StateRows,
    pub next: StateRows,
    pub stage: StateRows,
    pub k: [Vec<Row>; 4],
    pub loads: LoadRows,
    /// 1 in lanes whose step stayed where the fast path and the series hold, 0 in others.
    pub plain: [u64; BLOCK],
    pub pace: Pace<BLOCK>,
    pub visits: u64,
}

impl FlexibleLanes {
    /// Without samples; `partners` are those of the amplitudes.
    pub fn idle(tables: Tables, shape: Shape, partners: impl Iterator<Item = usize>) -> Self {
        let zero = [0.0; BLOCK];
        let amplitude = |partner: usize| AmplitudeRows { stiffness: zero, gyroscopic: zero, compliance: zero, partner };
        let amplitudes: Vec<AmplitudeRows> = partners.map(amplitude).collect();
        let size = PAD + amplitudes.len();
        let rows = |count: usize| vec![zero; count];
        let state = || StateRows { q: rows(size), u: rows(size) };
        Self {
            tables,
            shape,
            pad: PadRows {
                tangential_damping: zero,
                tangential_stiffness: zero,
                contact_tangential: zero,
                normal_damping: zero,
                normal_stiffness: zero,
                angular_damping: zero,
                angular_stiffness: zero,
                arm: zero,
                pressure_gain: zero,
                transmission: zero,
                kinetic_friction: zero,
                additional_friction: zero,
                friction_at_rest: zero,
                static_friction: zero,
                preload: zero,
                tilt_scale: zero,
                slope_scale: zero,
            },
            loads: LoadRows { on_modes: rows(amplitudes.len()), follower: rows(amplitudes.len()) },
            amplitudes,
            disc_damping: zero,
            slip: Slip::idle(),
            sticks: [0; BLOCK],
            present: state(),
            next: state(),
            stage: state(),
            k: [rows(size), rows(size), rows(size), rows(size)],
            plain: [0; BLOCK],
            pace: Pace::idle(),
            visits: 0,
        }
    }
}

/// A row from a function of the lane. A macro and not a function: what is not inlined is compiled for the baseline.
macro_rules! row {
    (|$lane:ident| $value:expr) => {{
        let mut row = [0.0; BLOCK];
        for $lane in 0..BLOCK {
            row[$lane] = $value;
        }
        row
    }};
}

/// [`crate::motion::flexible`]'s step of slip or stick, with `W` lanes of the contact's loads at a time.
#[inline(always)]
pub(super) fn flexible_step<const W: usize>(lanes: &mut FlexibleLanes) {
    std::mem::swap(&mut lanes.present, &mut lanes.next);
    let FlexibleLanes { tables, shape, pad, amplitudes, disc_damping, slip, sticks, loads, plain, pace, .. } = lanes;
    let coefficients = Coefficients { tables, shape: *shape, pad, amplitudes, disc_damping, slip, sticks };
    let (StateRows { q, u }, StateRows { q: stage_q, u: stage_u }) = (&lanes.present, &mut lanes.stage);
    let (StateRows { q: next_q, u: next_u }, k) = (&mut lanes.next, &mut lanes.k);
    let n = q.len();
    let h = pace.length;
    let (half, sixth) = (row!(|l| 0.5 * h[l]), row!(|l| h[l] / 6.0));
    *plain = [1; BLOCK];
    stage_q.copy_from_slice(q);
    stage_u.copy_from_slice(u);
    let mut first_ratio = [0.0; BLOCK];
    // One copy of the rates, not four: the loop over stages has to stay in the processor's cache of instructions.
    for (stage, k) in k.iter_mut().enumerate() {
        let ratio = rates::<W>(&coefficients, (stage_q, stage_u), loads, plain, k);
        let part = if stage < 2 { half } else { h };
        if stage == 0 {
            first_ratio = ratio;
        }
        if stage == 3 {
            break;
        }
        for i in 0..n {
            let (q, u, k, stage) = (&q[i], &u[i], &k[i], stage_u[i]);
            stage_q[i] = row!(|l| q[l] + part[l] * stage[l]);
            stage_u[i] = row!(|l| u[l] + part[l] * k[l]);
        }
    }
    let [k1, k2, k3, k4] = k;
    for i in 0..n {
        let (q, u, k1, k2, k3, k4) = (&q[i], &u[i], &k1[i], &k2[i], &k3[i], &k4[i]);
        next_q[i] = row!(|l| q[l] + h[l] * (u[l] + sixth[l] * (k1[l] + k2[l] + k3[l])));
        next_u[i] = row!(|l| u[l] + sixth[l] * (k1[l] + 2.0 * (k2[l] + k3[l]) + k4[l]));
    }
    let ends = ((&u[0], &next_u[0]), &next_q[0], (&k1[0], &k4[0]));
    let mut trials = match *shape {
        Shape::Tustin => findings(slip, Shape::Tustin, ends.0, ends.1, ends.2, &h),
        Shape::Gaussian => findings(slip, Shape::Gaussian, ends.0, ends.1, ends.2, &h),
        Shape::Stribeck => findings(slip, Shape::Stribeck, ends.0, ends.1, ends.2, &h),
        Shape::Rational => findings(slip, Shape::Rational, ends.0, ends.1, ends.2, &h),
        Shape::Table(curve) => findings(slip, Shape::Table(curve), ends.0, ends.1, ends.2, &h),
    };
    let released = if coefficients.any_sticks() {
        let mut whole = *plain;
        let contact = Contact::of(&coefficients, next_q, &mut whole);
        let friction = contact.friction_in_stick(pad, next_q, next_u);
        let mut released = [0; BLOCK];
        for l in 0..BLOCK {
            let held = pad.friction_at_rest[l];
            let holds = |ratio: f64| (held - ratio > 0.0) & (held + ratio > 0.0);
            released[l] = u64::from(!(holds(first_ratio[l]) & holds(friction.1[l]))) | (1 - whole[l]);
        }
        released
    } else {
        [0; BLOCK]
    };
    for l in 0..BLOCK {
        let (sticks, slips) = (sticks[l], 1 - sticks[l]);
        trials.is_too_long[l] &= slips & plain[l];
        trials.turns[l] &= slips;
        trials.factor[l] = if sticks == 1 { MOST_GROWTH } else { trials.factor[l] };
        trials.is_event[l] = (trials.is_event[l] & slips) | (released[l] & sticks) | (1 - plain[l]);
    }
    pace.judge(&trials);
    lanes.visits = pace.visits();
}

/// What the rates of change depend on beside the state.
struct Coefficients<'a> {
    tables: &'a Tables,
    shape: Shape,
    pad: &'a PadRows,
    amplitudes: &'a [AmplitudeRows],
    disc_damping: &'a Row,
    slip: &'a Slip<BLOCK>,
    sticks: &'a [u64; BLOCK],
}

impl Coefficients<'_> {
    #[inline(always)]
    fn any_sticks(&self) -> bool {
        self.sticks.iter().fold(0, |any, sticks| any | sticks) != 0
    }
}

/// The contact of a patch that is pressed as a whole.
struct Contact {
    sine: Row,
    cosine: Row,
    minus_tilt: Row,
    minus_y: Row,
    /// P / (M eta0).
    pressure: Row,
}

impl Contact {
    /// At displacements `q`; clears `plain` where the patch may have lifted off in part, or the series do not hold.
    #[inline(always)]
    fn of(coefficients: &Coefficients<'_>, q: &[Row], plain: &mut [u64; BLOCK]) -> Self {
        let (tables, pad) = (coefficients.tables, coefficients.pad);
        let (y, phi, amplitudes) = (&q[1], &q[2], &q[PAD..]);
        let [mut sine, mut cosine] = [[0.0; BLOCK]; 2];
        for l in 0..BLOCK {
            (sine[l], cosine[l]) = small_sine_and_cosine(phi[l]);
        }
        let minus_tilt = row!(|l| -(sine[l] / cosine[l] * pad.tilt_scale[l]));
        let minus_y = row!(|l| -y[l]);
        let mut margin = row!(|l| minus_y[l] - tables.largest_arc * minus_tilt[l].abs());
        for (amplitude, largest) in amplitudes.iter().zip(&tables.largest_shape) {
            margin = row!(|l| margin[l] - largest * amplitude[l].abs());
        }
        for l in 0..BLOCK {
            plain[l] &= u64::from((margin[l] > 0.0) & (phi[l].abs() <= SERIES_ANGLE));
        }
        let mut mean = minus_y;
        for (shape, a) in tables.shape.iter().zip(amplitudes) {
            mean = row!(|l| mean[l] + shape * a[l]);
        }
        let pressure = row!(|l| pad.pressure_gain[l] * mean[l]);
        Self { sine, cosine, minus_tilt, minus_y, pressure }
    }

    /// The force of all springs and dampers but the tangential contact's, against x.
    #[inline(always)]
    fn pull(&self, pad: &PadRows, q: &[Row], u: &[Row]) -> Row {
        let (x, x_speed) = (&q[0], &u[0]);
        row!(|l| {
            pad.tangential_damping[l] * x_speed[l]
                + pad.tangential_stiffness[l] * x[l]
                + self.pressure[l] * self.sine[l]
        })
    }

    /// The force of the tangential contact's spring that keeps the pad moving with the disc, and the friction that it
    /// takes over the pressure.
    #[inline(always)]
    fn friction_in_stick(&self, pad: &PadRows, q: &[Row], u: &[Row]) -> (Row, Row) {
        let (x, pull) = (&q[0], self.pull(pad, q, u));
        let spring = row!(|l| -pull[l] / self.cosine[l]);
        let ratio = row!(|l| {
            let friction = pad.contact_tangential[l] * x[l] - spring[l];
            friction / (pad.transmission[l] * self.pressure[l])
        });
        (spring, ratio)
    }
}

/// [`crate::flexible_disc::equations::FlexibleEquations`]'s accelerations with the whole patch in contact; clears
/// `plain` where that may not hold. Returns the friction over the pressure.
#[inline(always)]
fn rates<const W: usize>(
    coefficients: &Coefficients<'_>,
    (q, u): (&[Row], &[Row]),
    loads: &mut LoadRows,
    plain: &mut [u64; BLOCK],
    accelerations: &mut [Row],
) -> Row {
    let Coefficients { tables, shape, pad, amplitudes, disc_damping, slip, sticks } = coefficients;
    let contact = Contact::of(coefficients, q, plain);
    let (even, odd) = q[PAD..].split_at(tables.even);
    let Contact { minus_y, minus_tilt, .. } = &contact;
    contact_loads::<W>(tables, Amplitudes { minus_y, minus_tilt, even, odd }, loads);

    let Contact { sine, cosine, pressure, .. } = &contact;
    let (x, phi) = (&q[0], &q[2]);
    let (x_speed, y_speed, phi_speed) = (&u[0], &u[1], &u[2]);
    // The shape is matched once, and each arm has a loop of its own.
    let (a, b) = match *shape {
        Shape::Tustin => slip.friction_parts(Shape::Tustin, x_speed),
        Shape::Gaussian => slip.friction_parts(Shape::Gaussian, x_speed),
        Shape::Stribeck => slip.friction_parts(Shape::Stribeck, x_speed),
        Shape::Rational => slip.friction_parts(Shape::Rational, x_speed),
        Shape::Table(curve) => slip.friction_parts(Shape::Table(curve), x_speed),
    };
    let mut ratio = row!(|l| {
        let falling = pad.static_friction[l] - pad.kinetic_friction[l];
        pad.kinetic_friction[l] + falling * a[l] + pad.additional_friction[l] * b[l]
    });
    let mut spring = row!(|l| pad.contact_tangential[l] * x[l] - pad.transmission[l] * ratio[l] * pressure[l]);
    let pull = contact.pull(pad, q, u);
    let mut tangential = row!(|l| -(pull[l] + spring[l] * cosine[l]));
    if coefficients.any_sticks() {
        let (stuck_spring, stuck_ratio) = contact.friction_in_stick(pad, q, u);
        for l in 0..BLOCK {
            let sticks = sticks[l] != 0;
            ratio[l] = if sticks { stuck_ratio[l] } else { ratio[l] };
            spring[l] = if sticks { stuck_spring[l] } else { spring[l] };
            tangential[l] = if sticks { 0.0 } else { tangential[l] };
        }
    }
    accelerations[0] = tangential;
    accelerations[1] = row!(|l| {
        -(pad.normal_damping[l] * y_speed[l] + pad.normal_stiffness[l] * (pad.preload[l] + q[1][l])
            - pressure[l] * cosine[l]
            + spring[l] * sine[l])
    });
    accelerations[2] = row!(|l| {
        -(pad.angular_damping[l] * phi_speed[l] + pad.angular_stiffness[l] * phi[l] + pad.arm[l] * spring[l])
    });
    let follower_ratio = row!(|l| ratio[l] * pad.slope_scale[l]);
    for (k, amplitude) in amplitudes.iter().enumerate() {
        let (value, speed, partner_speed) = (&q[PAD + k], &u[PAD + k], &u[PAD + amplitude.partner]);
        let (load, follower) = (&loads.on_modes[k], &loads.follower[k]);
        accelerations[PAD + k] = row!(|l| {
            -(amplitude.stiffness[l] * value[l]
                + disc_damping[l] * speed[l]
                + amplitude.gyroscopic[l] * partner_speed[l])
                - amplitude.compliance[l] * (load[l] + follower_ratio[l] * follower[l])
        });
    }
    ratio
}
