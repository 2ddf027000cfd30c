//! Verdicts on a rigid disc with every friction law, against an independent fate: the adaptive method, swing after
//! swing, until the motion sticks for the second time, keeps to a cycle or has come to rest.

use super::*;
use crate::friction::law::{FrictionLaw, LawKind};
use crate::friction::measured_curve::{MeasuredCurve, SharedCurve};
use crate::models::pad_on_disc::parameters::Parameters;
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::uniform_draws;
use crate::models::pad_on_disc::rigid_disc::planar_motion::{PlanarMotion, SlipEnd};

/// Swings after which a motion is too slow for this reference.
const MOST_SWINGS: u32 = 4000;

/// An amplitude, over that of a pad as fast as the disc, below which a motion has come to rest.
const AT_REST: f64 = 1e-5;

fn fate(motion: &PlanarMotion, start: Start, displacement: f64) -> Option<Verdict> {
    let equilibrium = motion.equilibrium();
    let cycle = motion.disc_speed / motion.stiffness.sqrt();
    if motion.damping_at_equilibrium() < 0.0 {
        return Some(Verdict::Unstable);
    }
    let (mut state, mut sticks) = match start {
        Start::NearEquilibrium => ([equilibrium * (1.0 + displacement), 0.0], 0),
        Start::Rest => ([0.0, 0.0], 0),
        Start::LimitCycle => ([motion.release(), motion.disc_speed], 1),
        Start::Given(_) => return None,
    };
    let mut last: Option<f64> = None;
    let mut constant = 0;
    for _ in 0..MOST_SWINGS {
        let size = (state[0] - equilibrium).abs().max(state[1] / motion.stiffness.sqrt());
        let slip = motion.slip(state, size);
        match slip.end {
            SlipEnd::Equilibrium => return Some(Verdict::Stable),
            SlipEnd::Unresolved => return None,
            SlipEnd::Captured => {
                sticks += 1;
                if sticks > 1 {
                    return Some(Verdict::Unstable);
                }
                if slip.x >= motion.release() {
                    return None;
                }
                state = [motion.release(), motion.disc_speed];
                last = None;
            }
            SlipEnd::Turned => {
                let amplitude = slip.x - equilibrium;
                if amplitude.abs() < AT_REST * cycle {
                    return Some(Verdict::Stable);
                }
                let change = last.map_or(f64::INFINITY, |last| amplitude / last - 1.0);
                constant = if change.abs() < 1e-9 { constant + 1 } else { 0 };
                if constant > 20 {
                    return Some(Verdict::Unstable);
                }
                last = Some(amplitude);
                state = [slip.x, 0.0];
            }
        }
    }
    None
}

#[derive(Debug, Clone, Copy)]
enum Kind {
    Stribeck,
    Viscous,
    Rational,
    Table,
}

struct Draws<D: FnMut() -> f64>(D);

impl<D: FnMut() -> f64> Draws<D> {
    fn between(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.0)()
    }

    fn spread(&mut self, low: f64, high: f64) -> f64 {
        libm::exp(self.between(libm::log(low), libm::log(high)))
    }

    /// A curve that falls and rises again, with some scatter of measurement.
    fn curve(&mut self) -> SharedCurve {
        let rows = self.between(3.0, 31.0) as usize;
        let (fall, rise, width) = (self.between(0.0, 0.2), self.between(0.0, 0.15), self.spread(0.05, 2.0));
        let (least, highest, scatter) = (self.between(0.1, 0.3), self.spread(1.0, 8.0), self.between(0.0, 0.004));
        let begins_at_rest = (self.0)() < 0.7;
        let is_even = (self.0)() < 0.5;
        let mut speed = if begins_at_rest { 0.0 } else { 0.02 };
        let (mut speeds, mut coefficients) = (Vec::new(), Vec::new());
        for row in 0..rows {
            let share = speed / width;
            let mu = least + fall * libm::exp(-share) + rise * speed / highest + self.between(-scatter, scatter);
            speeds.push(speed);
            coefficients.push(mu);
            let even = highest / rows as f64;
            speed += self.between(0.5, 1.5) * if is_even { even } else { even * 2.0 * (row + 1) as f64 / rows as f64 };
        }
        let deviations: Vec<f64> = speeds.iter().map(|_| self.between(0.0, 0.02)).collect();
        SharedCurve::new(MeasuredCurve::new(&speeds, &coefficients, Some(&deviations)).unwrap())
    }

    fn brake(&mut self, kind: Kind) -> Option<PadOnDisc> {
        let mut parameters = Parameters::sui_ding_2018();
        parameters.damping.tangential = self.spread(5.0, 3000.0);
        parameters.operating_point.preload = self.spread(0.01, 0.3);
        let friction = &mut parameters.friction;
        friction.stribeck_velocity = self.spread(0.05, 3.0);
        friction.kinetic_coefficient = self.between(0.1, 0.4);
        friction.static_coefficient = friction.kinetic_coefficient * self.between(1.0, 2.5);
        match kind {
            Kind::Stribeck => friction.stribeck_exponent = self.spread(0.3, 5.0),
            Kind::Viscous => {
                friction.stribeck_exponent = self.spread(0.3, 5.0);
                friction.viscous = self.spread(1e-4, 0.1);
            }
            Kind::Rational => {
                friction.law = LawKind::Rational;
                if (self.0)() < 0.5 {
                    friction.viscous = self.spread(1e-4, 0.1);
                }
            }
            Kind::Table => {
                friction.use_table(self.curve());
                friction.static_coefficient *= self.between(0.7, 1.3);
                friction.band = self.between(-1.0, 1.0);
            }
        }
        let brake = PadOnDisc::new(parameters.clone()).ok()?;
        let ends: Vec<f64> = brake.unstable_speeds().iter().flat_map(|range| [range.from, range.to]).collect();
        let boundaries: Vec<f64> =
            ends.into_iter().chain(brake.saddle_node_speed()).filter(|speed| *speed > 1e-3 && *speed < 1e4).collect();
        let offset = self.between(-1.0, 1.0);
        let factor = libm::exp(1.1 * offset * offset * offset);
        let place = (boundaries.len() as f64 * (self.0)()) as usize;
        let speed = boundaries.get(place).copied().unwrap_or_else(|| self.spread(1.0, 60.0));
        parameters.operating_point.rotating_speed = factor * speed;
        PadOnDisc::new(parameters).ok()
    }
}

/// Wrong, undecided and compared verdicts on `brakes` random brakes.
#[allow(clippy::print_stdout, reason = "which brakes, for those who look into it")]
fn compare(kind: Kind, brakes: u64, seed: u64) -> [u32; 3] {
    let mut counts = [0; 3];
    for number in 0..brakes {
        let mut draws = Draws(uniform_draws(seed + number));
        // The first numbers of the generator are those of its seed.
        for _ in 0..10 {
            let _ = (draws.0)();
        }
        let Some(brake) = draws.brake(kind) else { continue };
        let parameters = brake.parameters();
        let inputs = RandomInputs {
            preload: parameters.operating_point.preload,
            static_friction: parameters.friction.static_coefficient,
        };
        let motion = RigidBrake::new(&brake).sample(inputs).planar_motion();
        if brake.is_outside_physics(inputs) {
            continue;
        }
        for start in [Start::NearEquilibrium, Start::Rest, Start::LimitCycle] {
            let displacement = 0.01;
            let settings = TimeDomainSettings { start, displacement, horizon: 1e5, ..TimeDomainSettings::default() };
            let criterion = TimeDomain::new(&brake, &DiscModel::Rigid, settings).unwrap();
            let decision = criterion.decide(inputs);
            let Some(expected) = fate(&motion, start, displacement) else { continue };
            counts[2] += 1;
            if matches!(decision.verdict, Verdict::Undecided | Verdict::Failed) {
                counts[1] += 1;
                println!("{kind:?} {number} {start:?}: {:?} for {expected:?}, {:?}", decision, describe(&brake));
            } else if decision.verdict != expected {
                counts[0] += 1;
                println!("{kind:?} {number} {start:?}: {:?} for {expected:?}, {:?}", decision, describe(&brake));
            }
        }
    }
    counts
}

fn describe(brake: &PadOnDisc) -> (FrictionLaw, f64, f64) {
    let parameters = brake.parameters();
    (
        FrictionLaw { shape: crate::friction::shape::Shape::Tustin, ..*brake.friction_law() },
        parameters.damping.tangential,
        parameters.operating_point.rotating_speed,
    )
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn verdicts_are_right_for_every_law() {
    for (kind, least) in [(Kind::Stribeck, 30), (Kind::Viscous, 30), (Kind::Rational, 30), (Kind::Table, 30)] {
        let [wrong, undecided, compared] = compare(kind, 15, 100);
        assert_eq!((wrong, undecided), (0, 0), "{kind:?}");
        assert!(compared >= least, "{kind:?} {compared}");
    }
}

/// The same on many brakes: cargo test --release -p stickslip-core --lib study_of_every_law -- --ignored --nocapture
#[test]
#[ignore = "a study of some minutes"]
#[allow(clippy::print_stdout, reason = "its result")]
fn study_of_every_law() {
    for kind in [Kind::Stribeck, Kind::Viscous, Kind::Rational, Kind::Table] {
        println!("{kind:?}: wrong, undecided, compared: {:?}", compare(kind, 300, 10_000));
    }
}
