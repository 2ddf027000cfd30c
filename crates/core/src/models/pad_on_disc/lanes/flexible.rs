//! Lanes of a flexible disc.

use std::ops::Deref;
use std::sync::Arc;

use crate::model::decision::Decision;
use crate::models::pad_on_disc::criterion::flexible_monitor::FlexibleMonitor;
use crate::models::pad_on_disc::criterion::time_domain::System;
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::flexible_disc::equations::FlexibleEquations;
use crate::models::pad_on_disc::flexible_disc::error::FlexibleError;
use crate::models::pad_on_disc::flexible_disc::geometry::DiscGeometry;
use crate::models::pad_on_disc::flexible_disc::linear_stability::LinearStability;
use crate::models::pad_on_disc::lanes::BLOCK;
use crate::models::pad_on_disc::lanes::bundle::{Begun, Bundle};
use crate::models::pad_on_disc::lanes::contact_loads::Tables;
use crate::models::pad_on_disc::lanes::dispatch::{InstructionSet, dispatch};
use crate::models::pad_on_disc::lanes::flexible_step::{FlexibleLanes, StateRows, flexible_step};
use crate::models::pad_on_disc::lanes::linear_stability::OwnBrake;
use crate::models::pad_on_disc::lanes::pace::Pace;
use crate::models::pad_on_disc::lanes::queue::QueuedSample;
use crate::models::pad_on_disc::motion::flexible::{FlexibleMotion, FlexibleSample, FlexibleState, MOST_FREEDOMS};
use crate::models::pad_on_disc::motion::friction_steps::FrictionSteps;
use crate::models::pad_on_disc::motion::integrator::{Motion, Step};
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::equations::Contact;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;
use crate::numerics::row::Lanes;

/// Lanes of a flexible disc: as many as keep all degrees of freedom of a step in the first-level cache.
pub(super) const LANES: usize = BLOCK;

/// Lanes of flexible discs with the same mode shapes, patch and friction law.
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
    /// Lanes for brakes with the geometry and the friction law of this one.
    pub fn new(motion: &FlexibleMotion) -> Self {
        let brake = &motion.brake.equations;
        let tables = Tables::new(&brake.geometry.patch.averages);
        let mut lanes = FlexibleLanes::idle(tables);
        for lane in 0..LANES {
            lanes.coefficients.set(lane, &brake.coefficients);
        }
        Self { lanes, geometry: Arc::clone(&brake.geometry), samples: (0..LANES).map(|_| None).collect() }
    }

    /// Whether a brake has the mode shapes, the patch and the friction law of these lanes.
    fn fits(&self, motion: &FlexibleMotion) -> bool {
        let FlexibleEquations { geometry, coefficients, .. } = &motion.brake.equations;
        let is_same = |other: &DiscGeometry| geometry.patch.averages == other.patch.averages;
        coefficients.pad.friction_shape == self.lanes.coefficients.pad.friction_shape
            && (Arc::ptr_eq(geometry, &self.geometry) || is_same(&self.geometry))
    }

    /// The equations of a sample for steps divided by `divisor`, if the lanes can take them; or else its decision.
    fn equations_of(&self, sample: &QueuedSample<'q>, divisor: f64) -> Result<Placed<'q>, Decision> {
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
        let friction_steps = motion.friction_steps(sample.inputs, divisor);
        Ok(Placed { motion, inputs: sample.inputs, friction_steps })
    }

    /// Sets the coefficients of a lane.
    fn set_sample(&mut self, l: usize, placed: Placed<'q>) {
        let lanes = &mut self.lanes;
        lanes.coefficients.set(l, &placed.motion.brake.equations.coefficients);
        lanes.inputs.set(l, &placed.inputs.into());
        lanes.friction_steps.set(l, &placed.friction_steps);
        self.samples[l] = Some(placed);
    }

    fn state(&self, StateRows { q, u }: &StateRows, lane: usize) -> FlexibleState {
        let mut state = FlexibleState { q: [0.0; MOST_FREEDOMS], u: [0.0; MOST_FREEDOMS] };
        for i in 0..self.lanes.next.q.len() {
            state.q[i] = q[i].0[lane];
            state.u[i] = u[i].0[lane];
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
        sample: &QueuedSample<'q>,
        divisor: f64,
        known: Self::Known,
        is_stopped: &dyn Fn() -> bool,
    ) -> Result<Begun<FlexibleState, FlexibleMonitor>, Decision> {
        // Before anything is prepared for it.
        if sample.inputs.preload <= 0.0 {
            return Err(Decision::OUTSIDE_PHYSICS);
        }
        let placed = self.equations_of(sample, divisor)?;
        let stability = |brake: &FlexibleBrake, inputs: RandomInputs| match &known {
            // Only motions about a stable equilibrium are simulated again.
            _ if divisor > 1.0 => Ok(LinearStability::Stable),
            Some(known) => known.clone(),
            None => brake.linear_stability_until(inputs, is_stopped),
        };
        let start = sample.scaled_start();
        // That of a motion which is simulated again is known.
        if divisor == 1.0 && sample.criterion.flexible_meets_no_friction(&placed.motion, sample.inputs, start) {
            return Err(Decision::OUTSIDE_PHYSICS);
        }
        let (motion, monitor) = sample.criterion.start_flexible(&placed.equations(), start, stability)?;
        let step = placed.motion.step / divisor;
        self.set_sample(lane, placed);
        Ok(Begun { motion, monitor, step })
    }

    fn place(&mut self, lane: usize, sample: &QueuedSample<'q>) -> Option<(Motion<FlexibleState>, f64)> {
        let placed = self.equations_of(sample, 1.0).ok()?;
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
        (present.q[0].0[lane], (present.u[0].0[lane], next.u[0].0[lane]), (k[0][0].0[lane], k[3][0].0[lane]))
    }

    #[inline]
    fn next_tangential(&self, lane: usize) -> (f64, f64) {
        (self.lanes.next.q[0].0[lane], self.lanes.next.u[0].0[lane])
    }

    fn present(&self, lane: usize) -> FlexibleState {
        self.state(&self.lanes.present, lane)
    }

    fn next(&self, lane: usize) -> FlexibleState {
        self.state(&self.lanes.next, lane)
    }

    fn trial(&self, lane: usize) -> Option<Step<FlexibleState>> {
        let is_plain = self.lanes.plain[lane] != 0;
        is_plain.then(|| Step { next: self.next(lane), acceleration: self.tangential(lane).2 })
    }

    fn simulates(contact: ContactState) -> bool {
        contact != ContactState::Overtaking
    }

    fn set_next(&mut self, lane: usize, motion: &Motion<FlexibleState>) {
        self.lanes.sticks.0[lane] = Contact::from(motion.contact).sticks;
        for i in 0..self.lanes.next.q.len() {
            self.lanes.next.q[i].0[lane] = motion.state.q[i];
            self.lanes.next.u[i].0[lane] = motion.state.u[i];
        }
    }

    fn keep(&mut self, lane: usize) {
        let FlexibleLanes { present, next, .. } = &mut self.lanes;
        for (next, present) in next.q.iter_mut().chain(&mut next.u).zip(present.q.iter().chain(&present.u)) {
            next.0[lane] = present.0[lane];
        }
    }
}
