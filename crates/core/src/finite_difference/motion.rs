//! The pad on the disc of [`crate::finite_difference::brake`], followed in time.

use crate::criterion::judge::{CoupledJudge, Judge, Rules};
use crate::criterion::time_domain::{Start, TimeDomainSettings};
use crate::finite_difference::brake::{Allotment, FiniteDifferenceBrake, FiniteDifferenceError};
use crate::finite_difference::patch::{Foothold, MovingPatch, Passage, Surface};
use crate::finite_difference::plate::PlateMotion;
use crate::flexible_disc::brake::{ContactForces, ContactState, FlexibleError, PadEquations, sine_and_cosine};
use crate::flexible_disc::linear_stability::LinearStability;
use crate::motion::friction_steps::FrictionSteps;
use crate::motion::integrator::{Equations, Motion, Observer, Reserve, Step, advance};
use crate::rigid_disc::pad_on_disc::RandomInputs;
use crate::trajectory::{Diary, Moment, Trajectory};
use crate::verdict::Verdict;

/// Rounds of the search for an equilibrium at the most; a disc of the preset's stiffness needs some twenty.
const ROUNDS: usize = 500;

/// Change in a round, relative to the pad's displacements, at which an equilibrium is found.
const FOUND: f64 = 1e-13;

/// x, y and phi with their speeds, at a time after the beginning of a step.
#[derive(Debug, Clone, Copy, PartialEq)]
struct PadState {
    q: [f64; 3],
    u: [f64; 3],
    time: f64,
}

/// The equations of the pad on a surface that moves in a known way.
struct PadOnSurface<'a> {
    pad: PadEquations,
    inputs: RandomInputs,
    patch: &'a MovingPatch,
    /// The surface at the beginning of a step, and after its length.
    before: &'a Surface,
    after: &'a Surface,
    length: f64,
    friction_steps: FrictionSteps,
}

impl PadOnSurface<'_> {
    /// `g+` of every point.
    fn gaps(&self, state: &PadState) -> impl Iterator<Item = f64> {
        let (sine, cosine) = sine_and_cosine(state.q[2]);
        let (normal, tilt, share) = (state.q[1], sine / cosine, state.time / self.length);
        let surface = self.before.deflections.iter().zip(&self.after.deflections);
        surface.zip(&self.patch.points).map(move |((before, after), point)| {
            let gap = before + share * (after - before) - normal - point.arc * tilt;
            if gap > 0.0 { gap } else { 0.0 }
        })
    }

    /// Forces and accelerations in a state, from the pad's three equations (2.5).
    fn rates(&self, state: &PadState, contact: ContactState) -> (ContactForces, [f64; 3]) {
        let (pad, [x, y, phi], [x_speed, y_speed, phi_speed]) = (&self.pad, state.q, state.u);
        let (sine, cosine) = sine_and_cosine(phi);
        let pressure = pad.pressure_gain * self.patch.average(self.gaps(state));
        let held = pad.tangential_damping * x_speed + pad.tangential_stiffness * x + pressure * sine;
        let sliding = pad.disc_speed - x_speed;
        let friction_ratio = match contact {
            ContactState::Slip => pad.friction_coefficient(sliding, self.inputs.static_friction),
            ContactState::Overtaking => -pad.friction_coefficient(-sliding, self.inputs.static_friction),
            // No acceleration: what the friction has to be.
            ContactState::Stick if pressure > 0.0 => {
                (pad.contact_tangential * x + held / cosine) / (pad.transmission * pressure)
            }
            ContactState::Stick => f64::INFINITY,
        };
        let spring = match contact {
            ContactState::Stick => -held / cosine,
            _ => pad.contact_tangential * x - pad.transmission * friction_ratio * pressure,
        };
        let tangential = if contact == ContactState::Stick { 0.0 } else { -held - spring * cosine };
        let normal = pressure * cosine
            - spring * sine
            - pad.normal_damping * y_speed
            - pad.normal_stiffness * (self.inputs.preload + y);
        let angular = -pad.angular_damping * phi_speed - pad.angular_stiffness * phi - pad.arm * spring;
        (ContactForces { pressure, friction_ratio }, [tangential, normal, angular])
    }

    /// The loads on the points at the beginning of the step, with a unit of contact gain.
    fn loads(&self, state: &PadState, contact: ContactState, loads: &mut Vec<f64>) {
        let ratio = self.rates(state, contact).0.friction_ratio;
        // Without pressure there is no friction, however much of it would be needed.
        let ratio = if ratio.is_finite() { ratio } else { 0.0 };
        let weighted = self.gaps(state).zip(&self.before.slopes).zip(&self.patch.points);
        loads.clear();
        loads.extend(weighted.map(|((gap, slope), point)| -point.weight * gap * (1.0 + ratio * slope)));
    }

    /// The tangential displacement at which static friction can just hold the pad.
    fn release(&self, state: &PadState) -> f64 {
        let pad = &self.pad;
        let pressure = self.rates(state, ContactState::Slip).0.pressure;
        let (sine, cosine) = sine_and_cosine(state.q[2]);
        let friction = pad.transmission * self.inputs.static_friction * pressure;
        (friction * cosine - pressure * sine - pad.tangential_damping * pad.disc_speed)
            / (pad.tangential_stiffness + pad.contact_tangential * cosine)
    }
}

impl Equations for PadOnSurface<'_> {
    type State = PadState;

    fn step(&self, state: &PadState, contact: ContactState, h: f64) -> Step<PadState> {
        // The state after a part of the step with the speeds and accelerations of a stage.
        let after = |part: f64, u: [f64; 3], a: [f64; 3]| PadState {
            q: std::array::from_fn(|i| state.q[i] + part * u[i]),
            u: std::array::from_fn(|i| state.u[i] + part * a[i]),
            time: state.time + part,
        };
        let k1 = self.rates(state, contact).1;
        let second = after(0.5 * h, state.u, k1);
        let k2 = self.rates(&second, contact).1;
        let third = after(0.5 * h, second.u, k2);
        let k3 = self.rates(&third, contact).1;
        let fourth = after(h, third.u, k3);
        let k4 = self.rates(&fourth, contact).1;
        let mean = |i: usize| (k1[i] + 2.0 * (k2[i] + k3[i]) + k4[i]) / 6.0;
        let mean_speed = |i: usize| state.u[i] + h / 6.0 * (k1[i] + k2[i] + k3[i]);
        let next = after(h, std::array::from_fn(mean_speed), std::array::from_fn(mean));
        Step { next, acceleration: (k1[0], k4[0]) }
    }

    fn tangential(&self, state: &PadState) -> (f64, f64) {
        (state.q[0], state.u[0])
    }

    fn disc_speed(&self) -> f64 {
        self.pad.disc_speed
    }

    fn moving_with_disc(&self, state: &PadState) -> PadState {
        PadState { u: [self.pad.disc_speed, state.u[1], state.u[2]], ..*state }
    }

    fn reserve(&self, state: &PadState) -> Reserve {
        let needed = self.rates(state, ContactState::Stick).0.friction_ratio;
        let available = self.inputs.static_friction;
        Reserve { against_slip: available - needed, against_overtaking: available + needed }
    }

    fn meeting_rate(&self) -> f64 {
        self.pad.meeting_rate()
    }

    fn friction_steps(&self) -> &FrictionSteps {
        &self.friction_steps
    }
}

/// Writes down what happens, and judges it until that is certain.
struct Witness {
    diary: Diary,
    judge: CoupledJudge,
    verdict: Option<Verdict>,
}

impl Witness {
    fn tell(&mut self, what: impl Fn(&mut dyn Observer)) {
        what(&mut self.diary);
        if self.verdict.is_none() {
            what(&mut self.judge);
            self.verdict = self.judge.verdict();
        }
    }
}

impl Observer for Witness {
    fn turns(&mut self, time: f64, x: f64) {
        self.tell(|observer| observer.turns(time, x));
    }
    fn sticks(&mut self, time: f64, x: f64) {
        self.tell(|observer| observer.sticks(time, x));
    }
    fn slips(&mut self, time: f64) {
        self.tell(|observer| observer.slips(time));
    }
}

/// A motion of pad and disc on its way, and room for what its steps need.
struct Course<'a> {
    brake: &'a FiniteDifferenceBrake,
    inputs: RandomInputs,
    allotment: Allotment,
    steps: u64,
    pad: Motion<PadState>,
    plate: PlateMotion,
    footing: Vec<Foothold>,
    loads: Vec<f64>,
    before: Surface,
    after: Surface,
}

impl Course<'_> {
    fn time(&self) -> f64 {
        self.steps as f64 * self.brake.step_length
    }

    /// One step of disc and pad; false if the computation broke down.
    fn step(&mut self, observer: &mut impl Observer) -> bool {
        let (brake, time) = (self.brake, self.time());
        let (plate, patch, step) = (&brake.plate, &brake.patch, &brake.step);
        let standing = brake.pad_on(self.inputs, &self.before, &self.before);
        standing.loads(&self.pad.state, self.pad.contact, &mut self.loads);
        plate.accelerate(step, &mut self.plate);
        patch.allot(plate, &self.footing, &self.loads, |ring, column, load| {
            plate.push(step, &mut self.plate, ring, column, brake.contact_gain * load);
        });
        plate.drift(step, &mut self.plate);
        self.steps += 1;
        patch.stand(plate, brake.passage(self.allotment, self.steps), &mut self.footing);
        patch.read(plate, &self.plate, &self.footing, &mut self.after);
        let moving = brake.pad_on(self.inputs, &self.before, &self.after);
        let advanced = advance(&moving, &mut self.pad, time, brake.step_length, observer);
        self.pad.state.time = 0.0;
        std::mem::swap(&mut self.before, &mut self.after);
        advanced.is_ok()
    }

    /// Everything that a trajectory tells of this moment.
    fn moment(&self) -> Moment {
        let (brake, Motion { state, contact }) = (self.brake, &self.pad);
        let pad = brake.pad_on(self.inputs, &self.before, &self.before);
        let forces = pad.rates(state, *contact).0;
        let scales = brake.modal.brake();
        let contact_force = forces.pressure * scales.scaled_mass() * scales.scales().length;
        let ratio = if contact_force > 0.0 { forces.friction_ratio } else { 0.0 };
        let touching = pad.gaps(state).map(|gap| if gap > 0.0 { 1.0 } else { 0.0 });
        Moment {
            time: self.time(),
            tangential: (state.q[0], state.u[0]),
            normal: (state.q[1], state.u[1]),
            angle: (state.q[2], state.u[2]),
            sliding_speed: brake.modal.pad.disc_speed - state.u[0],
            friction_coefficient: ratio,
            friction_force: ratio * contact_force,
            contact_force,
            sticks: *contact == ContactState::Stick,
            contact_share: brake.patch.average(touching),
            deflection: brake.patch.middle(&brake.plate, &self.plate, brake.passage(self.allotment, self.steps)),
        }
    }
}

impl FiniteDifferenceBrake {
    fn pad_on<'a>(&'a self, inputs: RandomInputs, before: &'a Surface, after: &'a Surface) -> PadOnSurface<'a> {
        PadOnSurface {
            pad: self.modal.pad,
            inputs,
            patch: &self.patch,
            before,
            after,
            length: self.step_length,
            friction_steps: self.modal.friction_steps(inputs),
        }
    }

    /// How far the disc has passed after some steps.
    pub(crate) fn passage(&self, allotment: Allotment, steps: u64) -> Passage {
        let (element, around) = (self.steps_per_element, self.plate.columns as u64);
        let whole = |elements: u64| (elements % around) as usize;
        match allotment {
            Allotment::Nodal => Passage { whole: whole((steps + element / 2) / element), part: 0.0 },
            Allotment::Linear => {
                Passage { whole: whole(steps / element), part: (steps % element) as f64 / element as f64 }
            }
        }
    }

    /// Steady sliding: the pad at rest, and the deflection (ring by ring) that the disc has under it.
    fn equilibrium(&self, inputs: RandomInputs) -> Result<(PadState, Vec<f64>), FiniteDifferenceError> {
        if inputs.preload.is_nan() || inputs.preload <= 0.0 {
            return Err(FlexibleError::NotPressed { preload: inputs.preload }.into());
        }
        let pad = &self.modal.pad;
        let rigid = self.modal.brake().sliding_equilibrium_at(inputs);
        let mut state = PadState { q: [rigid.tangential, rigid.normal, rigid.angle], u: [0.0; 3], time: 0.0 };
        let mut deflection = vec![0.0; self.plate.rings * self.plate.columns];
        let mut loads = Vec::new();
        let stiffness = [
            pad.tangential_stiffness + pad.contact_tangential,
            pad.normal_stiffness + pad.pressure_gain,
            pad.angular_stiffness,
        ];
        // Each displacement against its own stiffness in turn with the disc: the couplings between them are weak.
        for _ in 0..ROUNDS {
            let surface = self.surface(&self.plate.at_rest(&deflection));
            let standing = self.pad_on(inputs, &surface, &surface);
            let accelerations = standing.rates(&state, ContactState::Slip).1;
            standing.loads(&state, ContactState::Slip, &mut loads);
            let still = |change: f64| change.abs() <= FOUND * rigid.normal.abs();
            let mut found = true;
            for ((q, acceleration), stiffness) in state.q.iter_mut().zip(accelerations).zip(stiffness) {
                *q += acceleration / stiffness;
                found &= still(acceleration / stiffness);
            }
            if !state.q.iter().all(|q| q.is_finite()) {
                break;
            }
            loads.iter_mut().for_each(|load| *load *= self.contact_gain);
            let before = std::mem::replace(&mut deflection, self.steady_deflection(self.spin, &loads)?);
            if found && deflection.iter().zip(&before).all(|(now, before)| still(now - before)) {
                return Ok((state, deflection));
            }
        }
        let RandomInputs { preload, static_friction } = inputs;
        Err(FlexibleError::NoEquilibrium { preload, static_friction }.into())
    }

    /// The motion of pad and disc for a time `horizon`, from steady sliding with x where `start` says (with
    /// `displacement` as in [`TimeDomainSettings`]). Its moments are a whole number of steps apart, about as far as
    /// those of [`TimeDomain::trajectory`](crate::criterion::time_domain::TimeDomain::trajectory). The verdict is that of the motion up to
    /// `horizon`.
    ///
    /// # Errors
    /// [`FiniteDifferenceError::Settings`] if `displacement` or `horizon` is out of range,
    /// [`FiniteDifferenceError::Brake`] if there is no equilibrium to start from.
    pub fn trajectory(
        &self,
        inputs: RandomInputs,
        start: Start,
        displacement: f64,
        horizon: f64,
        allotment: Allotment,
    ) -> Result<Trajectory, FiniteDifferenceError> {
        TimeDomainSettings { start, displacement, horizon, ..Default::default() }.validate()?;
        let (mut course, equilibrium) = self.start(inputs, start, displacement, allotment)?;
        let (x, u) = (course.pad.state.q[0], course.pad.state.u[0]);
        let slowest_transient = self.modal.slowest_transient();
        // Linear stability is that of the modes: a motion on the grid would take long to show it.
        let repelled_by = match self.modal.by_eigenvalues(inputs)? {
            LinearStability::Stable => None,
            LinearStability::Unstable { fed_by } => Some(fed_by),
        };
        let smallest_cycle = self.modal.pad.smallest_cycle();
        let rules = Rules { slowest_transient, smallest_cycle, until_settled: false, repelled_by };
        let judge = CoupledJudge::new(rules, equilibrium, displacement, (u == 0.0).then_some(x));
        let rises = inputs.static_friction < self.modal.pad.kinetic_friction;
        let verdict = judge.verdict().or(rises.then_some(Verdict::Stable));
        let mut witness = Witness { diary: Diary::default(), judge, verdict };

        let every = (self.modal.step_length() / self.step_length).round().max(1.0) as u64;
        let interval = every as f64 * self.step_length;
        let intervals = (horizon / interval).ceil() as u64;
        let mut moments = vec![course.moment()];
        let mut broken = false;
        while !broken && moments.len() as u64 <= intervals {
            broken = (0..every).any(|_| !course.step(&mut witness));
            if !broken {
                moments.push(course.moment());
            }
        }
        let at_end = if broken { Verdict::Failed } else { Verdict::Undecided };
        let settled = witness.diary.settled_motion(&moments, intervals, interval);
        let verdict = witness.verdict.unwrap_or(at_end);
        let fed_by = (verdict == Verdict::Unstable).then(|| witness.judge.fed_by());
        Ok(Trajectory { moments, interval, settled, verdict, fed_by })
    }

    /// A motion at its beginning, and the equilibrium's x.
    fn start(
        &self,
        inputs: RandomInputs,
        start: Start,
        displacement: f64,
        allotment: Allotment,
    ) -> Result<(Course<'_>, f64), FiniteDifferenceError> {
        let (mut state, deflection) = self.equilibrium(inputs)?;
        let plate = self.plate.standing_still(&deflection, self.spin, self.step_length);
        let before = self.surface(&plate);
        let equilibrium = state.q[0];
        let contact = match start {
            Start::NearEquilibrium => {
                state.q[0] *= 1.0 + displacement;
                ContactState::Slip
            }
            Start::Rest => {
                state.q[0] = 0.0;
                ContactState::Slip
            }
            Start::LimitCycle => {
                state.q[0] = self.pad_on(inputs, &before, &before).release(&state);
                state.u[0] = self.modal.pad.disc_speed;
                ContactState::Stick
            }
        };
        let mut footing = Vec::new();
        self.patch.stand(&self.plate, Passage::default(), &mut footing);
        let course = Course {
            brake: self,
            inputs,
            allotment,
            steps: 0,
            pad: Motion { state, contact },
            plate,
            footing,
            loads: Vec::new(),
            before,
            after: Surface::default(),
        };
        Ok((course, equilibrium))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::criterion::time_domain::{DiscModel, TimeDomain};
    use crate::finite_difference::brake::DiscGrid;
    use crate::flexible_disc::brake::FlexibleBrake;
    use crate::rigid_disc::pad_on_disc::PadOnDisc;

    const NOMINAL: RandomInputs = RandomInputs { preload: 0.1, static_friction: 0.39 };

    fn brake(speed: f64) -> PadOnDisc {
        PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)])
    }

    fn on_grid(speed: f64, points: usize) -> FiniteDifferenceBrake {
        FiniteDifferenceBrake::new(brake(speed), DiscGrid { radial: points, per_pad: points }).unwrap()
    }

    /// With sixteen modes: what five of them leave out is as much as a grid of 16.
    fn modal(speed: f64, start: Start, displacement: f64, horizon: f64) -> Trajectory {
        let settings = TimeDomainSettings { start, displacement, ..Default::default() };
        let criterion = TimeDomain::new(&brake(speed), &DiscModel::Flexible { modes: 16 }, settings).unwrap();
        criterion.trajectory(NOMINAL, horizon).unwrap()
    }

    /// x, y and phi at any time, from the cubics through displacements and speeds.
    fn between_moments(trajectory: &Trajectory, time: f64) -> [f64; 3] {
        let h = trajectory.interval;
        let index = ((time / h) as usize).min(trajectory.moments.len() - 2);
        let [a, b] = [&trajectory.moments[index], &trajectory.moments[index + 1]];
        let s = (time - a.time) / h;
        let cubic = |(x, u): (f64, f64), (next, next_u): (f64, f64)| {
            let (left, right) = (1.0 - s, s);
            left * left * ((1.0 + 2.0 * s) * x + s * h * u)
                + right * right * ((3.0 - 2.0 * s) * next - left * h * next_u)
        };
        [cubic(a.tangential, b.tangential), cubic(a.normal, b.normal), cubic(a.angle, b.angle)]
    }

    /// Largest differences of x, y and phi between two motions.
    fn farthest(a: &Trajectory, b: &Trajectory) -> [f64; 3] {
        let mut farthest = [0.0_f64; 3];
        for moment in a.moments.iter().filter(|moment| moment.time <= b.moments[b.moments.len() - 1].time) {
            let other = between_moments(b, moment.time);
            for (k, x) in [moment.tangential.0, moment.normal.0, moment.angle.0].into_iter().enumerate() {
                farthest[k] = farthest[k].max((x - other[k]).abs());
            }
        }
        farthest
    }

    #[test]
    fn stick_slip_is_that_of_the_modal_disc() {
        for speed in [10.0, 20.0] {
            let exact = modal(speed, Start::Rest, 0.01, 80.0).settled.unwrap();
            let deviations = |points: usize| {
                let trajectory = on_grid(speed, points).trajectory(NOMINAL, Start::Rest, 0.01, 80.0, Allotment::Linear);
                let settled = trajectory.unwrap().settled.unwrap();
                [
                    settled.period.unwrap() - exact.period.unwrap(),
                    settled.tangential_max - exact.tangential_max,
                    settled.tangential_min - exact.tangential_min,
                    settled.stick_fraction - exact.stick_fraction,
                ]
            };
            let (coarse, fine) = (deviations(8), deviations(16));
            for (k, tolerance) in [2.5e-4, 3e-6, 1.5e-6, 1e-4].into_iter().enumerate() {
                // The amplitude is 0.005 to 0.007, the period 3.1 to 3.5.
                assert!(fine[k].abs() < tolerance, "{speed} {k}: {coarse:?} {fine:?}");
                assert!(fine[k].abs() < 0.4 * coarse[k].abs(), "{speed} {k}: {coarse:?} {fine:?}");
            }
        }
    }

    #[test]
    fn both_allotments_give_one_motion() {
        let speed = 20.0;
        let [coarse, fine] = [8, 16].map(|points| {
            let brake = on_grid(speed, points);
            // On its way the load jumps, or the test would compare nothing.
            let elements = speed * brake.modal.brake().scales().time * 80.0 / brake.plate.angle;
            assert!(elements > 1.0, "{elements}");
            let [linear, nodal] = [Allotment::Linear, Allotment::Nodal]
                .map(|allotment| brake.trajectory(NOMINAL, Start::Rest, 0.01, 80.0, allotment).unwrap());
            farthest(&linear, &nodal)
        });
        // x goes up to 0.016, y is -0.048, phi 0.001: a thousandth of each.
        for (k, tolerance) in [2e-5, 2e-5, 1e-6].into_iter().enumerate() {
            assert!(fine[k] < tolerance && fine[k] < 0.6 * coarse[k] && fine[k] > 0.0, "{k}: {coarse:?} {fine:?}");
        }
    }

    #[test]
    fn nothing_moves_at_the_equilibrium_but_what_the_nodes_stir() {
        let [coarse, fine] = [8, 16].map(|points| {
            let brake = on_grid(40.0, points);
            let trajectory = brake.trajectory(NOMINAL, Start::NearEquilibrium, 1e-9, 120.0, Allotment::Linear).unwrap();
            let first = trajectory.moments[0];
            let mut stirred = [0.0_f64; 3];
            for moment in &trajectory.moments {
                let ratios = [
                    moment.tangential.0 / first.tangential.0,
                    moment.contact_force / first.contact_force,
                    moment.deflection.0 / first.deflection.0,
                ];
                stirred = std::array::from_fn(|k| stirred[k].max((ratios[k] - 1.0).abs()));
            }
            stirred
        });
        for (k, tolerance) in [6e-5, 3e-5, 2e-3].into_iter().enumerate() {
            assert!(fine[k] < tolerance && fine[k] < 0.5 * coarse[k], "{k}: {coarse:?} {fine:?}");
        }
    }

    #[test]
    fn steady_sliding_is_that_of_the_modal_disc() {
        // A press and a friction strong enough that the friction's following the deflected surface shows.
        let inputs = RandomInputs { preload: 1.0, static_friction: 3.0 };
        let modes = FlexibleBrake::with_modes(brake(2.0), 16).unwrap();
        let q = modes.sliding_equilibrium(inputs).unwrap();
        let averages = &modes.patch.averages;
        let (even, odd) = q[3..].split_at(averages.shape.len());
        let sum = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
        let exact = [q[0], q[1], q[2], sum(even, &averages.shape), sum(odd, &averages.arc_shape)];
        let [coarse, fine] = [8, 16].map(|points| {
            let brake = on_grid(2.0, points);
            let (state, deflection) = brake.equilibrium(inputs).unwrap();
            let surface = brake.surface(&brake.plate.at_rest(&deflection));
            let w = &surface.deflections;
            let by_arc = brake.patch.average(w.iter().zip(&brake.patch.points).map(|(w, point)| w * point.arc));
            let found = [state.q[0], state.q[1], state.q[2], brake.patch.average(w.iter().copied()), by_arc];
            std::array::from_fn::<_, 5, _>(|k| found[k] / exact[k] - 1.0)
        });
        // Of x, y, phi and the disc's mean deflection and tilt under the pad; 4 % of the tilt are the follower's.
        for (k, tolerance) in [3e-4, 3e-4, 3e-4, 8e-3, 1e-2].into_iter().enumerate() {
            assert!(fine[k].abs() < tolerance && fine[k].abs() < 0.4 * coarse[k].abs(), "{k}: {coarse:?} {fine:?}");
        }
    }

    #[test]
    fn contact_is_lost_and_found_as_on_the_modal_disc() {
        let (start, displacement) = (Start::NearEquilibrium, 150.0);
        let exact = modal(20.0, start, displacement, 6.0);
        let [coarse, fine] = [8, 16].map(|points| {
            let trajectory =
                on_grid(20.0, points).trajectory(NOMINAL, start, displacement, 6.0, Allotment::Linear).unwrap();
            for motion in [&trajectory, &exact] {
                let shares = motion.moments.iter().map(|moment| moment.contact_share);
                let (least, last) = shares.fold((1.0_f64, 1.0), |(least, _), share| (least.min(share), share));
                assert!(least < 0.75 && last > 0.999, "{least} {last}");
            }
            farthest(&trajectory, &exact)
        });
        // x starts at 1.2, y goes to -0.05, phi to 0.04. The patches' own points show in y, of the one as of the other.
        for (k, (tolerance, shrinks)) in [(3e-4, 0.4), (1e-4, 1.0), (8e-6, 0.4)].into_iter().enumerate() {
            assert!(fine[k] < tolerance && fine[k] < shrinks * coarse[k], "{k}: {coarse:?} {fine:?}");
        }
    }

    #[test]
    fn verdicts_are_those_of_the_modal_disc() {
        for (speed, start, horizon, expected) in [
            (10.0, Start::LimitCycle, 60.0, Verdict::Unstable),
            (22.0, Start::Rest, 60.0, Verdict::Unstable),
            (22.0, Start::Rest, 5.0, Verdict::Undecided),
            (35.0, Start::Rest, 400.0, Verdict::Stable),
        ] {
            let trajectory = on_grid(speed, 6).trajectory(NOMINAL, start, 0.01, horizon, Allotment::Linear).unwrap();
            assert_eq!(trajectory.verdict, expected, "{speed} {start:?}");
            let first = trajectory.moments[0];
            assert_eq!(first.sticks, start == Start::LimitCycle);
            if first.sticks {
                assert!((first.friction_coefficient - 0.39).abs() < 1e-12, "{first:?}");
            }
            assert!((trajectory.interval - 0.1).abs() < 0.02, "{}", trajectory.interval);
            for (index, moment) in trajectory.moments.iter().enumerate() {
                assert!((moment.time - index as f64 * trajectory.interval).abs() < 1e-9);
                assert_eq!(moment.sticks, moment.sliding_speed == 0.0, "{moment:?}");
            }
        }
        // Rising friction is stable by definition.
        let inputs = RandomInputs { static_friction: 0.2, ..NOMINAL };
        let rising = on_grid(10.0, 6).trajectory(inputs, Start::Rest, 0.01, 1.0, Allotment::Linear).unwrap();
        assert_eq!(rising.verdict, Verdict::Stable);
    }

    #[test]
    fn what_cannot_be_followed_is_refused() {
        let brake = on_grid(10.0, 6);
        let follow = |inputs, displacement, horizon| {
            brake.trajectory(inputs, Start::Rest, displacement, horizon, Allotment::Linear).unwrap_err()
        };
        for preload in [0.0, -0.1, f64::NAN] {
            let error = follow(RandomInputs { preload, ..NOMINAL }, 0.01, 10.0);
            assert!(matches!(error, FiniteDifferenceError::Brake(FlexibleError::NotPressed { .. })), "{error}");
        }
        for static_friction in [1e6, f64::NAN] {
            let error = follow(RandomInputs { static_friction, ..NOMINAL }, 0.01, 10.0);
            assert!(matches!(error, FiniteDifferenceError::Brake(FlexibleError::NoEquilibrium { .. })), "{error}");
        }
        assert!(matches!(follow(NOMINAL, 0.0, 10.0), FiniteDifferenceError::Settings(_)));
        assert!(matches!(follow(NOMINAL, 0.01, f64::NAN), FiniteDifferenceError::Settings(_)));
    }
}
