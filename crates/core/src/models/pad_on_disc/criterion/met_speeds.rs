//! Which sliding speeds a motion meets, and whether there is friction at all of them.
//!
//! A measured curve that is shifted by its standard deviations may be at or below 0 at some speeds. A brake whose motion
//! meets one of these is outside the model: friction would push the pad against the sliding, or not at all. The law says
//! how far friction reaches about steady sliding, and a motion whether it goes beyond. Where a curve has friction at every
//! speed, as all other laws have, no motion is followed.
//!
//! The motion is followed by the scalar code, in steps of the first simulation, whether its verdict takes a simulation or
//! not: from its start until it meets no new speeds, be that at rest or on a limit cycle. So a verdict does not depend on
//! how soon it is certain.
//!
//! | disc | a motion meets no new speeds |
//! |---|---|
//! | rigid | after [`PERIODS`] natural periods of sliding without one: orbits do not cross |
//! | flexible | as soon as it has settled, as its monitor finds, since disc and contact ring along |

use std::f64::consts::TAU;

use crate::friction::law::FrictionLaw;
use crate::models::pad_on_disc::criterion::monitor::{Monitor as _, is_check_due};
use crate::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use crate::models::pad_on_disc::criterion::time_domain::{System, TimeDomain};
use crate::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use crate::models::pad_on_disc::motion::advance::{Substeps, advance_counted};
use crate::models::pad_on_disc::motion::flexible::FlexibleMotion;
use crate::models::pad_on_disc::motion::integrator::{Equations, Motion, Observer};
use crate::models::pad_on_disc::motion::rigid::RigidSample;
use crate::models::pad_on_disc::motion::start::Start;
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;

/// Natural periods of sliding without a new speed after which a motion on a rigid disc meets none.
const PERIODS: f64 = 5.0;

/// A range of speeds that grows by no more than this share of it does not grow.
const NEW: f64 = 1e-6;

impl TimeDomain {
    /// Whether a sample that has friction at rest and in steady sliding moves at a sliding speed without friction: its
    /// coefficient is at or below 0 there.
    #[must_use]
    pub fn meets_no_friction(&self, inputs: RandomInputs) -> bool {
        self.meets_no_friction_from(inputs, self.settings.start)
    }

    /// The same for a motion that starts elsewhere than the settings say.
    pub(crate) fn meets_no_friction_from(&self, inputs: RandomInputs, start: Start) -> bool {
        let start = start.scaled(self.brake.scales());
        match &self.system {
            System::Rigid(brake) => self.rigid_meets_no_friction(&brake.sample(inputs), inputs, start),
            System::Flexible(motion) => self.flexible_meets_no_friction(motion, inputs, start),
        }
    }

    /// The same for a sample on a rigid disc and a scaled start.
    pub(crate) fn rigid_meets_no_friction(&self, sample: &RigidSample, inputs: RandomInputs, start: Start) -> bool {
        let Some(positive) = positive_speeds(&sample.brake.law, inputs, sample.brake.disc_speed) else { return false };
        if self.check_rigid_start(sample, start).is_err() {
            return false;
        }
        let (h, longest) = (sample.brake.step, PERIODS * TAU / sample.brake.stiffness.sqrt());
        let (mut width, mut slid) = (0.0, 0.0);
        let is_over = |_: &mut Unobserved, _, motion: &Motion<_>, met: &MetSpeeds| {
            if met.width() > (1.0 + NEW) * width {
                (width, slid) = (met.width(), 0.0);
            } else if motion.contact != ContactState::Stick {
                slid += h;
            }
            slid > longest
        };
        self.leaves(sample, self.rigid_start(sample, start), h, positive, &mut Unobserved, is_over)
    }

    /// The same for a sample on a flexible disc.
    pub(crate) fn flexible_meets_no_friction(
        &self,
        motion: &FlexibleMotion,
        inputs: RandomInputs,
        start: Start,
    ) -> bool {
        let brake = motion.brake.brake();
        let Some(positive) = positive_speeds(brake.friction_law(), inputs, brake.disc_speed()) else { return false };
        let settings = TimeDomainSettings { record_amplitude: true, ..self.settings };
        let until_settled = Self { settings, ..self.clone() };
        let sample = motion.sample(inputs);
        let begun = until_settled.start_flexible(&sample, start, FlexibleBrake::by_eigenvalues);
        // Without a motion there is nothing to meet.
        let Ok((begun, mut monitor)) = begun else { return false };
        self.leaves(&sample, begun, motion.step, positive, &mut monitor, |monitor, steps, motion, _| {
            if is_check_due(steps) {
                let (x, u) = sample.tangential(&motion.state);
                monitor.check(x, u);
            }
            monitor.verdict().is_some()
        })
    }

    /// Whether a motion in steps of length `h` meets a sliding speed outside the `positive` ones before it `is_over`, which
    /// is asked after each step with the number of steps so far.
    fn leaves<E: Equations, O: Observer>(
        &self,
        equations: &E,
        mut motion: Motion<E::State>,
        h: f64,
        positive: [f64; 2],
        observer: &mut O,
        mut is_over: impl FnMut(&mut O, u64, &Motion<E::State>, &MetSpeeds) -> bool,
    ) -> bool {
        let relative = |motion: &Motion<E::State>| equations.disc_speed() - equations.tangential(&motion.state).1;
        let mut met = MetSpeeds::new(relative(&motion));
        let mut substeps = Substeps::at_most(self.most_substeps(h));
        for step in 0..self.steps_to_horizon(h) {
            if met.leave(positive) {
                return true;
            }
            let time = step as f64 * h;
            if advance_counted(equations, &mut motion, (time, h), &mut substeps, observer).is_err() {
                return false;
            }
            met.add(relative(&motion));
            if is_over(observer, step + 1, &motion, &met) {
                break;
            }
        }
        met.leave(positive)
    }
}

/// The sliding speeds about steady sliding between which a sample has friction; nothing if it has some at every speed.
fn positive_speeds(law: &FrictionLaw, inputs: RandomInputs, disc_speed: f64) -> Option<[f64; 2]> {
    let positive = law.with_static(inputs.static_friction).positive_about(disc_speed);
    positive.iter().any(|speed| speed.is_finite()).then_some(positive)
}

/// Of a motion of which only the speeds count, not the events.
struct Unobserved;

impl Observer for Unobserved {
    fn turns(&mut self, _: f64, _: f64) {}
    fn sticks(&mut self, _: f64, _: f64) {}
    fn slips(&mut self, _: f64) {}
}

/// The speeds of the disc against the pad that a motion has met: those between the least and the largest.
struct MetSpeeds {
    least: f64,
    most: f64,
    /// Those at the ends of the last two steps.
    last: [f64; 2],
}

impl MetSpeeds {
    fn new(speed: f64) -> Self {
        Self { least: speed, most: speed, last: [speed; 2] }
    }

    /// Adds the speed at the end of a step, and the crest of a parabola through the last three where the one in the middle
    /// is the least or the largest.
    fn add(&mut self, speed: f64) {
        let [before, middle] = self.last;
        self.last = [middle, speed];
        let (first, second) = (middle - before, speed - middle);
        let change = speed - before;
        let crest = if first * second < 0.0 { middle + change * change / (8.0 * (first - second)) } else { speed };
        self.least = self.least.min(speed).min(crest);
        self.most = self.most.max(speed).max(crest);
    }

    fn width(&self) -> f64 {
        self.most - self.least
    }

    /// Whether one of them is no sliding speed between these two.
    fn leave(&self, [below, above]: [f64; 2]) -> bool {
        let fastest = self.most.max(-self.least);
        let slowest = self.least.max(-self.most).max(0.0);
        fastest >= above || slowest <= below
    }
}

#[cfg(test)]
mod tests;
