//! The settled motion at one rotating speed after another.

use crate::models::pad_on_disc::criterion::time_domain::{System, TimeDomain, TimeDomainError};
use crate::models::pad_on_disc::motion::advance::advance;
use crate::models::pad_on_disc::motion::event_log::EventLog;
use crate::models::pad_on_disc::motion::flexible::FlexibleState;
use crate::models::pad_on_disc::motion::integrator::{Equations, Motion};
use crate::models::pad_on_disc::motion::rigid::RigidState;
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;

/// What the tangential motion does at one speed of a sweep.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SweepPoint {
    /// Omega, rad/s.
    pub rotating_speed: f64,
    /// Largest x of the settled motion.
    pub tangential_max: f64,
    /// Smallest x of the settled motion.
    pub tangential_min: f64,
    /// Share of the time spent in stick.
    pub stick_fraction: f64,
}

/// Sweeps the rotating speed as a braking driver would: at each criterion's speed the motion continues from where it
/// was at the speed before, for a scaled time `dwell`, and its last quarter is summarised.
///
/// All criteria must be of the same brake and disc, and `dwell` positive and finite. The first motion starts as its
/// settings say. A sweep ends where a motion breaks down.
///
/// # Errors
/// [`TimeDomainError`] if there is no equilibrium to start from.
pub fn sweep(criteria: &[TimeDomain], inputs: RandomInputs, dwell: f64) -> Result<Vec<SweepPoint>, TimeDomainError> {
    let mut points = Vec::with_capacity(criteria.len());
    let mut rigid: Option<Motion<RigidState>> = None;
    let mut flexible: Option<Motion<FlexibleState>> = None;
    for criterion in criteria {
        let h = criterion.step_length();
        let steps = (dwell / h).ceil() as u64;
        let settled = match &criterion.system {
            System::Rigid(motion) => {
                let sample = motion.sample(inputs);
                let start = rigid.unwrap_or_else(|| criterion.rigid_start(&sample, criterion.settings.start));
                let (end, settled) = dwell_on(&sample, start, h, steps);
                rigid = end;
                settled
            }
            System::Flexible(motion) => {
                let sample = motion.sample(inputs);
                let start = match flexible {
                    Some(motion) => motion,
                    None => criterion.flexible_start(&sample, criterion.settings.start)?.0,
                };
                let (end, settled) = dwell_on(&sample, start, h, steps);
                flexible = end;
                settled
            }
        };
        let Some((tangential_max, tangential_min, stick_fraction)) = settled else { break };
        let rotating_speed = criterion.brake.parameters().operating_point.rotating_speed;
        points.push(SweepPoint { rotating_speed, tangential_max, tangential_min, stick_fraction });
    }
    Ok(points)
}

/// Simulates a motion for some steps. Returns its end, and over the last quarter the largest and smallest x and the
/// share of stick; nothing if it breaks down.
#[allow(clippy::type_complexity, reason = "used once, right above")]
fn dwell_on<E: Equations>(
    equations: &E,
    mut motion: Motion<E::State>,
    h: f64,
    steps: u64,
) -> (Option<Motion<E::State>>, Option<(f64, f64, f64)>) {
    // At another speed of the disc a pad that stuck to it slips, until they have met again.
    if equations.tangential(&motion.state).1 < equations.disc_speed() {
        motion.contact = ContactState::Slip;
    } else {
        motion.contact = ContactState::Overtaking;
    }
    let mut log = EventLog::default();
    let from = steps - steps / 4;
    let (mut largest, mut smallest) = (f64::NEG_INFINITY, f64::INFINITY);
    for step in 0..steps {
        if advance(equations, &mut motion, step as f64 * h, h, &mut log).is_err() {
            return (None, None);
        }
        if step >= from {
            let x = equations.tangential(&motion.state).0;
            (largest, smallest) = (largest.max(x), smallest.min(x));
        }
    }
    let (start, end) = (from as f64 * h, steps as f64 * h);
    let turned = log.turns.iter().filter(|(time, _)| *time >= start).map(|turn| turn.1);
    let largest = turned.clone().fold(largest, f64::max);
    let smallest = turned.fold(smallest, f64::min);
    let stick_fraction = log.time_in_stick(start, end) / (end - start);
    (Some(motion), Some((largest, smallest, stick_fraction)))
}

#[cfg(test)]
mod tests;
