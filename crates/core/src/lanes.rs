//! Many samples at once, in the lanes of vector registers.
//!
//! The scalar code (modules `rigid`, `flexible_motion` and `motion`) is the truth; this file is its
//! speed. Lanes take one whole step of slip together, by the same operations in the same order, so that every lane has
//! the bits that the scalar code has, on every instruction set: nothing here is contracted, reassociated or approximated.
//! Whatever is not plain slip (sticking, release, lift-off, large angles, breakdown) sends the lane through the scalar
//! step from the same state. A lane whose sample is decided takes the next one; when samples run out, the last few are
//! finished by the scalar code.
//!
//! Loops over arrays of lanes are left to the compiler to vectorise, once for each instruction set; the widest one that
//! the processor has is chosen at run time. Only Tustin's law (exponent 1) has lanes: other exponents need a power
//! function, and are followed one by one.

#![allow(unsafe_code, reason = "calls to functions compiled for an instruction set, after asking the processor for it")]

use crate::criterion::judge::{CoupledJudge, Judge, PlanarJudge, is_time_to_look};
use crate::criterion::time_domain::{Decision, System, TimeDomain};
use crate::flexible_disc::brake::{ContactState, FlexibleBrake, PAD, SERIES_ANGLE, small_sine_and_cosine};
use crate::motion::flexible::{FlexibleSample, FlexibleState, MOST_FREEDOMS};
use crate::motion::friction_steps::FrictionSteps;
use crate::motion::integrator::{
    Breakdown, Equations, FARTHEST, Motion, Observer as _, advance, grazes_at_end, may_touch, turning_point, turns,
};
use crate::motion::rigid::{RigidBrake, RigidSample, RigidState};
use crate::numerics::exponential::exp;
use crate::rigid_disc::pad_on_disc::RandomInputs;
use crate::verdict::Verdict;

/// Lanes of a rigid disc: enough independent chains to hide the latency of the friction law.
const RIGID_LANES: usize = 64;

/// Lanes of a flexible disc: as many as keep all degrees of freedom of a step in the first-level cache.
const FLEXIBLE_LANES: usize = 16;

/// Rows of sums that are kept in registers together.
const ROWS_AT_ONCE: usize = 2;

/// When no samples are left and no more than this share of the lanes is busy, the scalar code is faster.
const FEWEST_BUSY: usize = 8;

/// An instruction set that lanes are compiled for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum InstructionSet {
    /// What every processor of the architecture has (SSE2 on x86-64, NEON on aarch64).
    Baseline,
    /// AVX2, four lanes in a register.
    Avx2,
    /// AVX-512, eight lanes in a register.
    Avx512,
}

impl InstructionSet {
    /// Those that this processor has, the widest last.
    #[must_use]
    pub fn available() -> Vec<Self> {
        [Self::Baseline, Self::Avx2, Self::Avx512].into_iter().filter(|set| set.is_available()).collect()
    }

    fn is_available(self) -> bool {
        #[cfg(target_arch = "x86_64")]
        match self {
            Self::Baseline => {}
            Self::Avx2 => return std::arch::is_x86_feature_detected!("avx2"),
            Self::Avx512 => {
                return std::arch::is_x86_feature_detected!("avx512f")
                    && std::arch::is_x86_feature_detected!("avx512dq");
            }
        }
        self == Self::Baseline
    }

    /// The widest that this processor has.
    #[must_use]
    pub fn widest() -> Self {
        Self::available().pop().unwrap_or(Self::Baseline)
    }
}

/// Compiles a function three times and calls the one for `$set`.
macro_rules! dispatch {
    ($set:expr, $body:ident, $($argument:ident: $type:ty),*) => {{
        #[cfg(target_arch = "x86_64")]
        {
            #[target_feature(enable = "avx2")]
            fn avx2($($argument: $type),*) {
                $body($($argument),*);
            }
            #[target_feature(enable = "avx512f,avx512dq")]
            fn avx512($($argument: $type),*) {
                $body($($argument),*);
            }
            match $set {
                // SAFETY: `InstructionSet::available` lists a set only if the processor has it, and a criterion takes
                // none that it does not list.
                InstructionSet::Avx512 => return unsafe { avx512($($argument),*) },
                // SAFETY: as above.
                InstructionSet::Avx2 => return unsafe { avx2($($argument),*) },
                InstructionSet::Baseline => {}
            }
        }
        #[cfg(not(target_arch = "x86_64"))]
        let _ = $set;
        $body($($argument),*);
    }};
}

/// What a step found in a lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Finding {
    /// Plain slip.
    Nothing,
    /// Plain slip with a turning point.
    Turn,
    /// Something for the scalar code.
    Event,
}

/// Bits of a finding as the lanes write them: numbers of the width of a lane, so that writing them is one vector
/// operation too.
const TURN: u64 = 1;
const EVENT: u64 = 2;

/// A bundle of lanes with one set of equations.
trait Bundle {
    /// Lanes.
    const LANES: usize;

    type Judge: Judge;

    /// Puts a sample into the next state of a lane, or says what is known of it without following it.
    fn begin(
        &mut self,
        criterion: &TimeDomain,
        lane: usize,
        inputs: RandomInputs,
    ) -> Result<(ContactState, Self::Judge), Decision>;

    /// Puts the motion of a sample into the next state of a lane, decided or not.
    fn place(&mut self, criterion: &TimeDomain, lane: usize, inputs: RandomInputs);

    /// One step of slip in every lane, from the present states to the next ones.
    fn step(&mut self, set: InstructionSet);

    fn finding(&self, lane: usize) -> Finding;

    /// x, and x' and x'' at both ends of the step.
    fn tangential(&self, lane: usize) -> (f64, (f64, f64), (f64, f64));

    /// x and x' at the end of the step.
    fn next(&self, lane: usize) -> (f64, f64);

    /// The scalar step from the present state of a lane to its next one.
    fn scalar_step(
        &mut self,
        lane: usize,
        contact: ContactState,
        time: f64,
        judge: &mut Self::Judge,
    ) -> Result<ContactState, Breakdown>;

    /// The next states become the present ones.
    fn commit(&mut self);

    /// Length of a step.
    fn step_length(&self) -> f64;

    /// Follows the sample of a lane to its end by the scalar code, `steps` steps after its beginning.
    fn finish(&self, criterion: &TimeDomain, lane: usize, slot: &Slot<Self::Judge>, steps: u64) -> Decision;
}

/// What is known of the sample in a lane.
#[derive(Clone, Copy)]
struct Slot<J> {
    /// Its place in the list.
    index: usize,
    judge: J,
    contact: ContactState,
    /// The step of the bundle at which it began.
    began: u64,
}

impl TimeDomain {
    /// Follows every sample of a list as [`TimeDomain::judge`] does, with the same bits, by the lanes of `set`.
    ///
    /// # Panics
    /// If this processor does not have `set`.
    #[must_use]
    pub fn decide_all_with(&self, inputs: &[RandomInputs], set: InstructionSet) -> Vec<Decision> {
        assert!(InstructionSet::available().contains(&set), "this processor has no {set:?}");
        match &self.system {
            System::Rigid(brake) if brake.stribeck_exponent == 1.0 => {
                run(self, inputs, &mut RigidBundle::new(brake), set)
            }
            System::Flexible(brake) if brake.pad.stribeck_exponent == 1.0 => {
                run(self, inputs, &mut FlexibleBundle::new(brake), set)
            }
            _ => inputs.iter().map(|&inputs| self.decide(inputs)).collect(),
        }
    }
}

impl TimeDomain {
    /// Takes `steps` steps of every sample of a list, for benchmarks of the steps alone: nobody looks at the motions, and
    /// all must be plain slip. By the scalar code one after the other, or by full bundles of lanes. Samples that do not
    /// fill a bundle are left out.
    ///
    /// # Panics
    /// If this processor does not have `set`.
    pub fn take_steps(&self, inputs: &[RandomInputs], steps: u32, set: Option<InstructionSet>) {
        match (&self.system, set) {
            (System::Rigid(brake), Some(set)) => {
                take_bundle_steps(self, inputs, steps, &mut RigidBundle::new(brake), set);
            }
            (System::Flexible(brake), Some(set)) => {
                take_bundle_steps(self, inputs, steps, &mut FlexibleBundle::new(brake), set);
            }
            (System::Rigid(brake), None) => {
                for &inputs in inputs {
                    let sample = brake.sample(inputs);
                    take_scalar_steps(&sample, self.rigid_start(&sample), steps, brake.step);
                }
            }
            (System::Flexible(brake), None) => {
                for &inputs in inputs {
                    let sample = FlexibleSample::new(brake, inputs);
                    if let Ok((motion, _)) = self.flexible_start(&sample) {
                        take_scalar_steps(&sample, motion, steps, brake.step_length());
                    }
                }
            }
        }
    }
}

fn take_scalar_steps<E: Equations>(equations: &E, motion: Motion<E::State>, steps: u32, h: f64) {
    let mut state = motion.state;
    for _ in 0..steps {
        state = equations.step(&state, ContactState::Slip, h).next;
    }
    std::hint::black_box(equations.tangential(&state));
}

fn take_bundle_steps<B: Bundle>(
    criterion: &TimeDomain,
    inputs: &[RandomInputs],
    steps: u32,
    bundle: &mut B,
    set: InstructionSet,
) {
    assert!(InstructionSet::available().contains(&set), "this processor has no {set:?}");
    for inputs in inputs.chunks_exact(B::LANES) {
        for (lane, &inputs) in inputs.iter().enumerate() {
            bundle.place(criterion, lane, inputs);
        }
        bundle.commit();
        for _ in 0..steps {
            bundle.step(set);
            bundle.commit();
        }
        std::hint::black_box(bundle.tangential(0));
    }
}

/// Runs a list of samples through a bundle.
fn run<B: Bundle>(
    criterion: &TimeDomain,
    inputs: &[RandomInputs],
    bundle: &mut B,
    set: InstructionSet,
) -> Vec<Decision> {
    let h = bundle.step_length();
    let limit = criterion.steps_to_horizon(h);
    let mut outcomes = vec![Decision::OUTSIDE_PHYSICS; inputs.len()];
    let mut waiting = 0..inputs.len();
    let mut slots: Vec<Option<Slot<B::Judge>>> = vec![None; B::LANES];
    let mut busy = 0;
    let mut now = 0_u64;
    // The first step at which a lane may have reached its horizon.
    let mut deadline = limit;
    let mut refill = |bundle: &mut B, lane: usize, outcomes: &mut [Decision], now: u64| {
        for index in waiting.by_ref() {
            match bundle.begin(criterion, lane, inputs[index]) {
                Err(known) => outcomes[index] = known,
                Ok((contact, judge)) => return Some(Slot { index, judge, contact, began: now }),
            }
        }
        None
    };
    for (lane, slot) in slots.iter_mut().enumerate() {
        *slot = refill(bundle, lane, &mut outcomes, now);
        busy += usize::from(slot.is_some());
    }
    bundle.commit();
    let mut exhausted = busy < B::LANES;
    while busy > 0 {
        if exhausted && busy * FEWEST_BUSY <= B::LANES {
            for (lane, slot) in slots.iter().enumerate() {
                if let Some(slot) = slot {
                    outcomes[slot.index] = bundle.finish(criterion, lane, slot, now - slot.began);
                }
            }
            break;
        }
        bundle.step(set);
        let at_deadline = now + 1 >= deadline;
        if at_deadline {
            deadline = u64::MAX;
        }
        for (lane, place) in slots.iter_mut().enumerate() {
            let Some(slot) = place else { continue };
            let steps = now - slot.began;
            let time = steps as f64 * h;
            let finding = if slot.contact == ContactState::Slip { bundle.finding(lane) } else { Finding::Event };
            let outcome = match finding {
                Finding::Nothing => None,
                Finding::Turn => {
                    let (x, u, acceleration) = bundle.tangential(lane);
                    let (part, at) = turning_point(x, u, acceleration, h);
                    slot.judge.turns(time + part, at);
                    None
                }
                Finding::Event => match bundle.scalar_step(lane, slot.contact, time, &mut slot.judge) {
                    Ok(contact) => {
                        slot.contact = contact;
                        None
                    }
                    Err(Breakdown) => Some(criterion.conclude_without_verdict(Verdict::Failed, &slot.judge, time)),
                },
            };
            let looks = is_time_to_look(steps + 1);
            if looks && outcome.is_none() {
                let (x, u) = bundle.next(lane);
                slot.judge.looks(x, u);
            }
            let outcome = outcome.or_else(|| {
                let verdict = if finding == Finding::Nothing && !looks { None } else { slot.judge.verdict() };
                let end = (steps + 1) as f64 * h;
                match verdict {
                    Some(verdict) => Some(criterion.conclude(verdict, &slot.judge, end)),
                    None => (at_deadline && steps + 1 >= limit)
                        .then(|| criterion.conclude_without_verdict(Verdict::Undecided, &slot.judge, end)),
                }
            });
            if let Some(outcome) = outcome {
                outcomes[slot.index] = outcome;
                // Written to the next state, which becomes the present one below.
                *place = refill(bundle, lane, &mut outcomes, now + 1);
                if place.is_none() {
                    busy -= 1;
                    exhausted = true;
                }
            }
            if at_deadline && let Some(slot) = place {
                deadline = deadline.min(slot.began + limit);
            }
        }
        bundle.commit();
        now += 1;
    }
    outcomes
}

/// Lanes of a rigid disc.
struct RigidBundle<'a> {
    brake: &'a RigidBrake,
    inputs: [RandomInputs; RIGID_LANES],
    lanes: RigidArrays,
}

struct RigidArrays {
    kinetic_pull: [f64; RIGID_LANES],
    falling_pull: [f64; RIGID_LANES],
    x: [f64; RIGID_LANES],
    u: [f64; RIGID_LANES],
    next_x: [f64; RIGID_LANES],
    next_u: [f64; RIGID_LANES],
    first_acceleration: [f64; RIGID_LANES],
    last_acceleration: [f64; RIGID_LANES],
    findings: [u64; RIGID_LANES],
}

impl<'a> RigidBundle<'a> {
    fn new(brake: &'a RigidBrake) -> Self {
        let zero = [0.0; RIGID_LANES];
        Self {
            brake,
            inputs: [RandomInputs { preload: 0.0, static_friction: 0.0 }; RIGID_LANES],
            lanes: RigidArrays {
                kinetic_pull: zero,
                falling_pull: zero,
                x: zero,
                u: zero,
                next_x: zero,
                next_u: zero,
                first_acceleration: zero,
                last_acceleration: zero,
                findings: [0; RIGID_LANES],
            },
        }
    }

    fn present(&self, lane: usize) -> RigidState {
        RigidState { x: self.lanes.x[lane], u: self.lanes.u[lane] }
    }

    fn set_next(&mut self, lane: usize, inputs: RandomInputs, sample: &RigidSample<'_>, state: &RigidState) {
        self.inputs[lane] = inputs;
        self.lanes.kinetic_pull[lane] = sample.kinetic_pull;
        self.lanes.falling_pull[lane] = sample.falling_pull;
        self.lanes.next_x[lane] = state.x;
        self.lanes.next_u[lane] = state.u;
    }
}

impl Bundle for RigidBundle<'_> {
    const LANES: usize = RIGID_LANES;

    type Judge = PlanarJudge;

    fn begin(
        &mut self,
        criterion: &TimeDomain,
        lane: usize,
        inputs: RandomInputs,
    ) -> Result<(ContactState, PlanarJudge), Decision> {
        let sample = self.brake.sample(inputs);
        let (motion, judge) = criterion.start_rigid(&sample, inputs)?;
        self.set_next(lane, inputs, &sample, &motion.state);
        Ok((motion.contact, judge))
    }

    fn place(&mut self, criterion: &TimeDomain, lane: usize, inputs: RandomInputs) {
        let sample = self.brake.sample(inputs);
        let state = criterion.rigid_start(&sample).state;
        self.set_next(lane, inputs, &sample, &state);
    }

    fn step(&mut self, set: InstructionSet) {
        let (brake, lanes) = (self.brake, &mut self.lanes);
        dispatch!(set, rigid_step, brake: &RigidBrake, lanes: &mut RigidArrays);
    }

    fn finding(&self, lane: usize) -> Finding {
        found(self.lanes.findings[lane])
    }

    fn tangential(&self, lane: usize) -> (f64, (f64, f64), (f64, f64)) {
        let lanes = &self.lanes;
        let acceleration = (lanes.first_acceleration[lane], lanes.last_acceleration[lane]);
        (lanes.x[lane], (lanes.u[lane], lanes.next_u[lane]), acceleration)
    }

    fn next(&self, lane: usize) -> (f64, f64) {
        (self.lanes.next_x[lane], self.lanes.next_u[lane])
    }

    fn scalar_step(
        &mut self,
        lane: usize,
        contact: ContactState,
        time: f64,
        judge: &mut Self::Judge,
    ) -> Result<ContactState, Breakdown> {
        let sample = self.brake.sample(self.inputs[lane]);
        let mut motion = Motion { state: self.present(lane), contact };
        advance(&sample, &mut motion, time, self.brake.step, judge)?;
        self.lanes.next_x[lane] = motion.state.x;
        self.lanes.next_u[lane] = motion.state.u;
        Ok(motion.contact)
    }

    fn commit(&mut self) {
        self.lanes.x = self.lanes.next_x;
        self.lanes.u = self.lanes.next_u;
    }

    fn step_length(&self) -> f64 {
        self.brake.step
    }

    fn finish(&self, criterion: &TimeDomain, lane: usize, slot: &Slot<Self::Judge>, steps: u64) -> Decision {
        let sample = self.brake.sample(self.inputs[lane]);
        let motion = Motion { state: self.present(lane), contact: slot.contact };
        criterion.follow(&sample, motion, slot.judge, self.brake.step, steps)
    }
}

fn found(bits: u64) -> Finding {
    if bits & EVENT != 0 {
        Finding::Event
    } else if bits & TURN != 0 {
        Finding::Turn
    } else {
        Finding::Nothing
    }
}

/// What a step of slip from `u` to `next_u` has met; the conditions of [`crate::motion::integrator`], as bits.
#[inline(always)]
fn findings(
    steps: &FrictionSteps,
    disc_speed: f64,
    u: (f64, f64),
    next_x: f64,
    acceleration: (f64, f64),
    h: f64,
) -> u64 {
    let sliding = (disc_speed - u.0, disc_speed - u.1);
    let touches = may_touch(sliding, (-acceleration.0, -acceleration.1), h);
    let ordinary = (sliding.1 > 0.0) & (sliding.1 < f64::MAX) & (next_x.abs() < FARTHEST);
    let too_long = steps.is_too_long_for_tustin(u, acceleration, h);
    let grazes = grazes_at_end(sliding, disc_speed);
    u64::from(touches | grazes | too_long | !ordinary) * EVENT + u64::from(turns(u.0, u.1)) * TURN
}

/// [`crate::motion::rigid`]'s step of slip.
#[inline(always)]
fn rigid_step(brake: &RigidBrake, lanes: &mut RigidArrays) {
    type Lanes = [f64; RIGID_LANES];
    let h = brake.step;
    let (half, sixth) = (0.5 * h, h / 6.0);
    let acceleration = |x: &Lanes, u: &Lanes, kinetic: &Lanes, falling: &Lanes, out: &mut Lanes| {
        for i in 0..RIGID_LANES {
            let ratio = (brake.disc_speed - u[i]) * brake.inverse_stribeck;
            let power = if ratio < -1.0 { -1.0 } else { ratio };
            let pull = kinetic[i] + falling[i] * exp(-power);
            out[i] = pull - brake.stiffness * x[i] - brake.damping * u[i];
        }
    };
    let RigidArrays { kinetic_pull, falling_pull, x, u, .. } = lanes;
    let [mut k1, mut k2, mut k3, mut k4] = [[0.0; RIGID_LANES]; 4];
    let [mut stage_x, mut stage_u] = [[0.0; RIGID_LANES]; 2];
    acceleration(x, u, kinetic_pull, falling_pull, &mut k1);
    for i in 0..RIGID_LANES {
        stage_x[i] = x[i] + half * u[i];
        stage_u[i] = u[i] + half * k1[i];
    }
    acceleration(&stage_x, &stage_u, kinetic_pull, falling_pull, &mut k2);
    for i in 0..RIGID_LANES {
        stage_x[i] = x[i] + half * stage_u[i];
        stage_u[i] = u[i] + half * k2[i];
    }
    acceleration(&stage_x, &stage_u, kinetic_pull, falling_pull, &mut k3);
    for i in 0..RIGID_LANES {
        stage_x[i] = x[i] + h * stage_u[i];
        stage_u[i] = u[i] + h * k3[i];
    }
    acceleration(&stage_x, &stage_u, kinetic_pull, falling_pull, &mut k4);
    for i in 0..RIGID_LANES {
        lanes.next_x[i] = lanes.x[i] + h * (lanes.u[i] + sixth * (k1[i] + k2[i] + k3[i]));
        lanes.next_u[i] = lanes.u[i] + sixth * (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]);
    }
    for i in 0..RIGID_LANES {
        let (u, acceleration) = ((lanes.u[i], lanes.next_u[i]), (k1[i], k4[i]));
        let steps = brake.friction_steps(lanes.falling_pull[i]);
        lanes.findings[i] = findings(&steps, brake.disc_speed, u, lanes.next_x[i], acceleration, h);
    }
    lanes.first_acceleration = k1;
    lanes.last_acceleration = k4;
}

/// One value for each lane of a flexible disc.
type Row = [f64; FLEXIBLE_LANES];

/// Lanes of a flexible disc.
struct FlexibleBundle<'a> {
    brake: &'a FlexibleBrake,
    tables: Tables,
    inputs: [RandomInputs; FLEXIBLE_LANES],
    lanes: FlexibleArrays,
    step: f64,
}

struct InputRows {
    preload: Row,
    static_friction: Row,
}

struct FlexibleArrays {
    inputs: InputRows,
    friction_steps: [FrictionSteps; FLEXIBLE_LANES],
    q: Vec<Row>,
    u: Vec<Row>,
    next_q: Vec<Row>,
    next_u: Vec<Row>,
    stage_q: Vec<Row>,
    stage_u: Vec<Row>,
    k: [Vec<Row>; 4],
    contact: ContactRows,
    /// 1 in lanes whose step stayed where the fast path and the series hold, 0 in others.
    plain: [u64; FLEXIBLE_LANES],
    findings: [u64; FLEXIBLE_LANES],
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
    fn new(brake: &'a FlexibleBrake) -> Self {
        let (size, averages) = (brake.size(), &brake.patch.averages);
        let inputs = RandomInputs { preload: 0.0, static_friction: 0.0 };
        let rows = |count: usize| vec![[0.0; FLEXIBLE_LANES]; count];
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
            inputs: InputRows { preload: [0.0; FLEXIBLE_LANES], static_friction: [0.0; FLEXIBLE_LANES] },
            friction_steps: [brake.friction_steps(inputs); FLEXIBLE_LANES],
            q: rows(size),
            u: rows(size),
            next_q: rows(size),
            next_u: rows(size),
            stage_q: rows(size),
            stage_u: rows(size),
            k: [rows(size), rows(size), rows(size), rows(size)],
            contact,
            plain: [0; FLEXIBLE_LANES],
            findings: [0; FLEXIBLE_LANES],
        };
        Self { brake, tables, inputs: [inputs; FLEXIBLE_LANES], lanes, step: brake.step_length() }
    }

    fn present(&self, lane: usize) -> FlexibleState {
        let mut state = FlexibleState { q: [0.0; MOST_FREEDOMS], u: [0.0; MOST_FREEDOMS] };
        for i in 0..self.brake.size() {
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
        for i in 0..self.brake.size() {
            self.lanes.next_q[i][lane] = state.q[i];
            self.lanes.next_u[i][lane] = state.u[i];
        }
    }
}

impl Bundle for FlexibleBundle<'_> {
    const LANES: usize = FLEXIBLE_LANES;

    type Judge = CoupledJudge;

    fn begin(
        &mut self,
        criterion: &TimeDomain,
        lane: usize,
        inputs: RandomInputs,
    ) -> Result<(ContactState, CoupledJudge), Decision> {
        let sample = FlexibleSample::new(self.brake, inputs);
        let (motion, judge) = criterion.start_flexible(&sample, FlexibleBrake::linear_stability)?;
        self.set_sample(lane, &sample);
        self.set_next(lane, &motion.state);
        Ok((motion.contact, judge))
    }

    fn place(&mut self, criterion: &TimeDomain, lane: usize, inputs: RandomInputs) {
        let sample = FlexibleSample::new(self.brake, inputs);
        if let Ok((motion, _)) = criterion.flexible_start(&sample) {
            self.set_sample(lane, &sample);
            self.set_next(lane, &motion.state);
        }
    }

    fn step(&mut self, set: InstructionSet) {
        let (brake, tables, lanes, h) = (self.brake, &self.tables, &mut self.lanes, self.step);
        dispatch!(set, flexible_step, brake: &FlexibleBrake, tables: &Tables, lanes: &mut FlexibleArrays, h: f64);
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
        advance(&FlexibleSample::new(self.brake, self.inputs[lane]), &mut motion, time, self.step, judge)?;
        self.set_next(lane, &motion.state);
        Ok(motion.contact)
    }

    fn commit(&mut self) {
        std::mem::swap(&mut self.lanes.q, &mut self.lanes.next_q);
        std::mem::swap(&mut self.lanes.u, &mut self.lanes.next_u);
    }

    fn step_length(&self) -> f64 {
        self.step
    }

    fn finish(&self, criterion: &TimeDomain, lane: usize, slot: &Slot<Self::Judge>, steps: u64) -> Decision {
        let sample = FlexibleSample::new(self.brake, self.inputs[lane]);
        let motion = Motion { state: self.present(lane), contact: slot.contact };
        criterion.follow(&sample, motion, slot.judge, self.step, steps)
    }
}

/// A row from a function of the lane. A macro and not a function: what is not inlined is compiled for the baseline.
macro_rules! row {
    (|$lane:ident| $value:expr) => {{
        let mut row = [0.0; FLEXIBLE_LANES];
        for $lane in 0..FLEXIBLE_LANES {
            row[$lane] = $value;
        }
        row
    }};
}

/// [`crate::motion::flexible`]'s step of slip.
#[inline(always)]
fn flexible_step(brake: &FlexibleBrake, tables: &Tables, lanes: &mut FlexibleArrays, h: f64) {
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
    *plain = [1; FLEXIBLE_LANES];
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
    for l in 0..FLEXIBLE_LANES {
        let (ends, acceleration) = ((u[0][l], next_u[0][l]), (k1[0][l], k4[0][l]));
        let met = findings(&steps[l], brake.pad.disc_speed, ends, next_q[0][l], acceleration, h);
        out[l] = met | ((1 - plain[l]) * EVENT);
    }
}

/// [`FlexibleBrake`]'s accelerations in slip with the whole patch in contact; clears `plain` where that may not hold.
#[inline(always)]
fn flexible_rates(
    brake: &FlexibleBrake,
    tables: &Tables,
    inputs: &InputRows,
    (q, u): (&[Row], &[Row]),
    contact: &mut ContactRows,
    plain: &mut [u64; FLEXIBLE_LANES],
    accelerations: &mut [Row],
) {
    let (pad, averages) = (&brake.pad, &brake.patch.averages);
    let (x, y, phi) = (&q[0], &q[1], &q[2]);
    let (x_speed, y_speed, phi_speed) = (&u[0], &u[1], &u[2]);
    let amplitudes = &q[PAD..];
    let (a, b) = amplitudes.split_at(brake.patch.even);
    let [mut sine, mut cosine] = [[0.0; FLEXIBLE_LANES]; 2];
    for l in 0..FLEXIBLE_LANES {
        (sine[l], cosine[l]) = small_sine_and_cosine(phi[l]);
    }
    let minus_tilt = row!(|l| -(sine[l] / cosine[l]));
    let minus_y = row!(|l| -y[l]);
    let mut margin = row!(|l| minus_y[l] - averages.largest_arc * minus_tilt[l].abs());
    for (amplitude, largest) in amplitudes.iter().zip(&averages.largest_shape) {
        margin = row!(|l| margin[l] - largest * amplitude[l].abs());
    }
    for l in 0..FLEXIBLE_LANES {
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
    even_follower.fill([0.0; FLEXIBLE_LANES]);
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
    odd_follower.fill([0.0; FLEXIBLE_LANES]);
    accumulate(odd_follower, &tables.odd_follower, odd_products);

    let ratio = row!(|l| {
        let r = (pad.disc_speed - x_speed[l]) * pad.inverse_stribeck;
        let power = if r < -1.0 { -1.0 } else { r };
        pad.kinetic_friction + (inputs.static_friction[l] - pad.kinetic_friction) * exp(-power)
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
    let mut sums = [[0.0; FLEXIBLE_LANES]; ROWS];
    sums.copy_from_slice(&rows[first..first + ROWS]);
    for (product, factors) in products.iter().zip(factors.chunks_exact(count)) {
        let factors = &factors[first..first + ROWS];
        for row in 0..ROWS {
            for l in 0..FLEXIBLE_LANES {
                sums[row][l] += factors[row] * product[l];
            }
        }
    }
    rows[first..first + ROWS].copy_from_slice(&sums);
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::criterion::time_domain::{DiscModel, Start, TimeDomainSettings};
    use crate::rigid_disc::pad_on_disc::PadOnDisc;

    /// Inputs all over the plane, in no order: deep in either region, near the boundary, outside physics.
    fn inputs(count: usize) -> Vec<RandomInputs> {
        let mut state = 88_172_645_463_325_252_u64;
        let mut draw = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..count).map(|_| RandomInputs { preload: 0.4 * draw() - 0.01, static_friction: 0.2 + 0.4 * draw() }).collect()
    }

    fn criterion(disc: &DiscModel, settings: TimeDomainSettings, changes: &[(&str, f64)]) -> TimeDomain {
        TimeDomain::new(&PadOnDisc::preset_with(changes), disc, settings).unwrap()
    }

    #[track_caller]
    fn assert_lanes_agree(criterion: &TimeDomain, inputs: &[RandomInputs]) -> [usize; 4] {
        let expected: Vec<Decision> = inputs.iter().map(|&inputs| criterion.decide(inputs)).collect();
        for set in InstructionSet::available() {
            let found = criterion.decide_all_with(inputs, set);
            for ((inputs, expected), found) in inputs.iter().zip(&expected).zip(&found) {
                let bits =
                    |judged: &Decision| (judged.verdict, judged.time.to_bits(), judged.amplitude.map(f64::to_bits));
                assert_eq!(bits(found), bits(expected), "{set:?} {inputs:?} {found:?} {expected:?}");
            }
        }
        let mut seen = [0; 4];
        expected.iter().for_each(|judged| seen[judged.verdict as usize] += 1);
        seen
    }

    #[test]
    fn every_lane_has_the_bits_of_the_scalar_code() {
        for (disc, count) in [(DiscModel::Rigid, 3000), (DiscModel::Flexible { modes: 5 }, 500)] {
            for start in [Start::NearEquilibrium, Start::Rest, Start::LimitCycle] {
                for record_amplitude in [false, true] {
                    // The settled amplitude keeps its bits only if every step did.
                    let settings = TimeDomainSettings { start, record_amplitude, ..Default::default() };
                    let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 15.0)]);
                    let count = if record_amplitude { count / 5 } else { count };
                    let seen = assert_lanes_agree(&criterion, &inputs(count));
                    assert!(seen[0] > count / 10 && seen[1] > count / 10, "{seen:?}");
                }
            }
        }
    }

    #[test]
    fn lanes_agree_at_the_horizon_and_in_breakdown_too() {
        for disc in [DiscModel::Rigid, DiscModel::Flexible { modes: 4 }] {
            let settings = TimeDomainSettings { horizon: 4.0, start: Start::Rest, ..Default::default() };
            let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 25.0)]);
            let mut inputs = inputs(300);
            for i in (0..300).step_by(17) {
                inputs[i] = RandomInputs { preload: 0.1 * i as f64, static_friction: f64::NAN };
            }
            let seen = assert_lanes_agree(&criterion, &inputs);
            assert!(seen[Verdict::Undecided as usize] > 10 && seen[Verdict::Failed as usize] > 10, "{seen:?}");
        }
    }

    #[test]
    fn other_discs_patches_and_exponents_agree_as_well() {
        let settings = TimeDomainSettings::default();
        for changes in [
            // So soft a contact with so wide a pad that part of it lifts off, and a pad that tilts far.
            [("stiffness.calliper_angular", 1.2e3), ("pad.half_angle", 1.2)],
            [("friction.stribeck_exponent", 2.0), ("operating_point.rotating_speed", 9.0)],
            [("disc.inner_radius", 0.03), ("operating_point.rotating_speed", 12.0)],
        ] {
            for disc in [DiscModel::Rigid, DiscModel::Flexible { modes: 7 }] {
                assert_lanes_agree(&criterion(&disc, settings, &changes), &inputs(60));
            }
        }
    }

    #[test]
    fn outcomes_are_pinned() {
        // Regression values, the same on every architecture: an FNV-1a hash of every verdict, time and amplitude.
        let settings = TimeDomainSettings { record_amplitude: true, start: Start::Rest, ..Default::default() };
        let hashes = [DiscModel::Rigid, DiscModel::Flexible { modes: 5 }].map(|disc| {
            let criterion = criterion(&disc, settings, &[("operating_point.rotating_speed", 15.0)]);
            let mut hash = 0xcbf2_9ce4_8422_2325_u64;
            for judged in criterion.decide_all(&inputs(40)) {
                for word in [judged.verdict as u64, judged.time.to_bits(), judged.amplitude.map_or(0, f64::to_bits)] {
                    for byte in word.to_le_bytes() {
                        hash = (hash ^ u64::from(byte)).wrapping_mul(0x0100_0000_01b3);
                    }
                }
            }
            hash
        });
        assert_eq!(hashes, [17_903_389_124_153_164_030, 1_000_063_740_259_384_411]);
    }

    #[test]
    fn the_list_may_be_of_any_length() {
        let criterion =
            criterion(&DiscModel::Rigid, TimeDomainSettings::default(), &[("operating_point.rotating_speed", 15.0)]);
        for count in [0, 1, 2, RIGID_LANES - 1, RIGID_LANES, RIGID_LANES + 1, 3 * RIGID_LANES + 7] {
            assert_lanes_agree(&criterion, &inputs(count));
        }
    }
}
