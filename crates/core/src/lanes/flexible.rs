//! Lanes of a flexible disc.

use std::ops::Deref;
use std::sync::Arc;

use crate::criterion::decision::Decision;
use crate::criterion::flexible_monitor::FlexibleMonitor;
use crate::criterion::time_domain::System;
use crate::flexible_disc::brake::FlexibleBrake;
use crate::flexible_disc::equations::FlexibleEquations;
use crate::flexible_disc::error::FlexibleError;
use crate::flexible_disc::geometry::DiscGeometry;
use crate::flexible_disc::linear_stability::LinearStability;
use crate::lanes::BLOCK;
use crate::lanes::bundle::{Begun, Bundle};
use crate::lanes::contact_loads::Tables;
use crate::lanes::dispatch::{InstructionSet, dispatch};
use crate::lanes::flexible_step::{FlexibleLanes, flexible_step};
use crate::lanes::linear_stability::OwnBrake;
use crate::lanes::pace::Pace;
use crate::lanes::queue::QueuedSample;
use crate::motion::flexible::{FlexibleMotion, FlexibleSample, FlexibleState, MOST_FREEDOMS};
use crate::motion::friction_steps::FrictionSteps;
use crate::motion::integrator::{Motion, Step};
use crate::pad::contact_state::ContactState;
use crate::pad::equations::PAD;
use crate::rigid_disc::pad_on_disc::RandomInputs;

/// Lanes of a flexible disc: as many as keep all degrees of freedom of a step in the first-level cache.
pub(super) const LANES: usize = BLOCK;

/// Lanes of flexible discs with the same mode shapes and patch.
pub(super) struct FlexibleBundle<'q> {
    lanes: FlexibleLanes,
    geometry: Arc<DiscGeometry>,
    samples: Vec<Option<Placed<'q>>>,
}

/// The equations in a lane.
struct Placed<'q> {
    motion: Held<'q>,
    inputs: RandomInputs,
    friction_steps: FrictionSteps,
}

/// The equations of a brake, of many samples or of one.
enum Held<'q> {
    Shared(&'q FlexibleMotion),
    Own(Box<FlexibleMotion>),
}

impl Deref for Held<'_> {
    type Target = FlexibleMotion;

    fn deref(&self) -> &FlexibleMotion {
        match self {
            Self::Shared(motion) => motion,
            Self::Own(motion) => motion,
        }
    }
}

impl<'q> FlexibleBundle<'q> {
    /// Lanes for brakes with the geometry of this one.
    pub fn new(motion: &FlexibleMotion) -> Self {
        let brake = &motion.brake.equations;
        let tables = Tables::new(&brake.geometry.patch.averages);
        let lanes = FlexibleLanes::idle(
            tables,
            brake.pad.friction_shape,
            brake.amplitudes.iter().map(|amplitude| amplitude.partner),
        );
        Self { lanes, geometry: Arc::clone(&brake.geometry), samples: (0..LANES).map(|_| None).collect() }
    }

    /// Whether a brake has the mode shapes, the patch and the friction law of these lanes.
    fn fits(&self, motion: &FlexibleMotion) -> bool {
        let FlexibleEquations { geometry, pad, .. } = &motion.brake.equations;
        let is_same = |other: &DiscGeometry| geometry.patch.averages == other.patch.averages;
        pad.friction_shape == self.lanes.shape && (Arc::ptr_eq(geometry, &self.geometry) || is_same(&self.geometry))
    }

    /// The equations of a sample, if the lanes can take them; or else its decision.
    fn equations_of(&self, sample: &QueuedSample<'q>) -> Result<Placed<'q>, Decision> {
        let System::Flexible(shared) = &sample.criterion.system else { return Err(sample.clone().decide()) };
        let motion = match &sample.brake {
            None => Held::Shared(shared),
            Some(brake) => {
                let own = shared.with_brake(brake.clone()).map_err(|_| Decision::FAILED)?;
                sample.criterion.check_horizon(own.step).map_err(|_| Decision::FAILED)?;
                Held::Own(Box::new(own))
            }
        };
        if !self.fits(&motion) {
            return Err(sample.clone().decide());
        }
        let friction_steps = motion.friction_steps(sample.inputs);
        Ok(Placed { motion, inputs: sample.inputs, friction_steps })
    }

    /// Sets the coefficients of a lane.
    fn set_sample(&mut self, l: usize, placed: Placed<'q>) {
        let lanes = &mut self.lanes;
        let (equations, rows) = (&placed.motion.brake.equations, &mut lanes.pad);
        let pad = &equations.pad;
        rows.tangential_damping[l] = pad.tangential_damping;
        rows.tangential_stiffness[l] = pad.tangential_stiffness;
        rows.contact_tangential[l] = pad.contact_tangential;
        rows.normal_damping[l] = pad.normal_damping;
        rows.normal_stiffness[l] = pad.normal_stiffness;
        rows.angular_damping[l] = pad.angular_damping;
        rows.angular_stiffness[l] = pad.angular_stiffness;
        rows.arm[l] = pad.arm;
        rows.pressure_gain[l] = pad.pressure_gain;
        rows.transmission[l] = pad.transmission;
        rows.kinetic_friction[l] = pad.kinetic_friction;
        rows.additional_friction[l] = pad.additional_friction;
        rows.static_friction[l] = placed.inputs.static_friction;
        rows.friction_at_rest[l] = pad.friction_at_rest(placed.inputs.static_friction);
        rows.preload[l] = placed.inputs.preload;
        for (rows, amplitude) in lanes.amplitudes.iter_mut().zip(&equations.amplitudes) {
            rows.stiffness[l] = amplitude.stiffness;
            rows.gyroscopic[l] = amplitude.gyroscopic;
            rows.compliance[l] = amplitude.compliance;
        }
        lanes.disc_damping[l] = equations.disc_damping;
        rows.tilt_scale[l] = equations.tilt_scale;
        rows.slope_scale[l] = equations.slope_scale;
        lanes.slip.disc_speed[l] = pad.disc_speed;
        lanes.slip.inverse_stribeck[l] = pad.inverse_stribeck;
        let law = placed.friction_steps.law;
        (lanes.slip.exponent[l], lanes.slip.steepest[l]) = (law.exponent, law.steepest);
        let pulls = FrictionSteps::pulls_of_pad(pad, placed.inputs);
        (lanes.slip.falling_pull[l], lanes.slip.additional_pull[l]) = pulls;
        lanes.slip.refinement[l] = placed.motion.refinement;
        self.samples[l] = Some(placed);
    }

    fn state(&self, q: &[[f64; BLOCK]], u: &[[f64; BLOCK]], lane: usize) -> FlexibleState {
        let mut state = FlexibleState { q: [0.0; MOST_FREEDOMS], u: [0.0; MOST_FREEDOMS] };
        for i in 0..PAD + self.lanes.amplitudes.len() {
            state.q[i] = q[i][lane];
            state.u[i] = u[i][lane];
        }
        state
    }
}

impl Placed<'_> {
    fn equations(&self) -> FlexibleSample<'_> {
        FlexibleSample { brake: &self.motion.brake, inputs: self.inputs, friction_steps: self.friction_steps }
    }
}

impl<'q> Bundle<'q> for FlexibleBundle<'q> {
    const LANES: usize = LANES;

    type State = FlexibleState;
    type Equations<'a>
        = FlexibleSample<'a>
    where
        Self: 'a;
    type Monitor = FlexibleMonitor;

    const AT_ONCE: usize = 16;
    type Known = Option<Result<LinearStability, FlexibleError>>;

    /// The linear stability of samples with brakes of their own.
    fn examine(&self, samples: &[QueuedSample<'q>]) -> Vec<Self::Known> {
        let own = |sample: &QueuedSample<'q>| {
            let brake = sample.brake.clone().filter(|_| sample.inputs.preload > 0.0)?;
            Some(OwnBrake { brake, inputs: sample.inputs })
        };
        let own: Vec<Option<OwnBrake>> = samples.iter().map(own).collect();
        let brakes: Vec<OwnBrake> = own.iter().flatten().cloned().collect();
        let shared = samples.iter().find_map(|sample| match &sample.criterion.system {
            System::Flexible(motion) => Some(&motion.brake),
            System::Rigid(_) => None,
        });
        let mut found = shared.map_or_else(Vec::new, |shared| shared.linear_stability_of(&brakes)).into_iter();
        own.iter().map(|own| own.as_ref().and_then(|_| found.next())).collect()
    }

    fn begin(
        &mut self,
        lane: usize,
        sample: QueuedSample<'q>,
        known: Self::Known,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Begun<FlexibleState, FlexibleMonitor>, Decision> {
        // Before anything is prepared for it.
        if sample.inputs.preload <= 0.0 {
            return Err(Decision::OUTSIDE_PHYSICS);
        }
        let placed = self.equations_of(&sample)?;
        let stability = |brake: &FlexibleBrake, inputs: RandomInputs| match &known {
            Some(known) => known.clone(),
            None => brake.linear_stability_until(inputs, is_stopped),
        };
        let start = sample.scaled_start();
        let (motion, monitor) = sample.criterion.start_flexible(&placed.equations(), start, stability)?;
        let step = placed.motion.step;
        self.set_sample(lane, placed);
        Ok(Begun { motion, monitor, step })
    }

    fn place(&mut self, lane: usize, sample: QueuedSample<'q>) -> Option<(Motion<FlexibleState>, f64)> {
        let placed = self.equations_of(&sample).ok()?;
        let (motion, _) = sample.criterion.flexible_start(&placed.equations(), sample.scaled_start()).ok()?;
        let step = placed.motion.step;
        self.set_sample(lane, placed);
        Some((motion, step))
    }

    #[inline]
    fn step(&mut self, set: InstructionSet) {
        let lanes = &mut self.lanes;
        // So many lanes of the loads at a time that their sums fit the registers.
        dispatch!(set, flexible_step::<4>, flexible_step::<8>, flexible_step::<16>, lanes: &mut FlexibleLanes);
    }

    #[inline]
    fn visits(&self) -> u64 {
        self.lanes.visits
    }

    #[inline]
    fn pace(&mut self, lane: usize) -> (&mut Pace<BLOCK>, usize) {
        (&mut self.lanes.pace, lane)
    }

    #[inline]
    fn equations(&self, lane: usize) -> Option<FlexibleSample<'_>> {
        self.samples[lane].as_ref().map(Placed::equations)
    }

    #[inline]
    fn tangential(&self, lane: usize) -> (f64, (f64, f64), (f64, f64)) {
        let FlexibleLanes { present, next, k, .. } = &self.lanes;
        (present.q[0][lane], (present.u[0][lane], next.u[0][lane]), (k[0][0][lane], k[3][0][lane]))
    }

    #[inline]
    fn next_tangential(&self, lane: usize) -> (f64, f64) {
        (self.lanes.next.q[0][lane], self.lanes.next.u[0][lane])
    }

    fn present(&self, lane: usize) -> FlexibleState {
        self.state(&self.lanes.present.q, &self.lanes.present.u, lane)
    }

    fn next(&self, lane: usize) -> FlexibleState {
        self.state(&self.lanes.next.q, &self.lanes.next.u, lane)
    }

    fn trial(&self, lane: usize) -> Option<Step<FlexibleState>> {
        let is_plain = self.lanes.plain[lane] != 0;
        is_plain.then(|| Step { next: self.next(lane), acceleration: self.tangential(lane).2 })
    }

    fn simulates(contact: ContactState) -> bool {
        contact != ContactState::Overtaking
    }

    fn set_next(&mut self, lane: usize, motion: &Motion<FlexibleState>) {
        self.lanes.sticks[lane] = u64::from(motion.contact == ContactState::Stick);
        for i in 0..PAD + self.lanes.amplitudes.len() {
            self.lanes.next.q[i][lane] = motion.state.q[i];
            self.lanes.next.u[i][lane] = motion.state.u[i];
        }
    }

    fn keep(&mut self, lane: usize) {
        let FlexibleLanes { present, next, .. } = &mut self.lanes;
        for (next, present) in next.q.iter_mut().chain(&mut next.u).zip(present.q.iter().chain(&present.u)) {
            next[lane] = present[lane];
        }
    }
}
