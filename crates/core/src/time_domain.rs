//! The time-domain criterion: a sample is followed in time until its motion has shown what it will do.

use thiserror::Error;

use crate::flexible::{ContactState, FlexibleBrake, FlexibleError};
use crate::flexible_motion::FlexibleSample;
use crate::judgement::{Judge, Rules};
use crate::lanes::InstructionSet;
use crate::motion::{Equations, Motion, advance};
use crate::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::rigid::{RigidBrake, RigidSample, RigidState};
use crate::verdict::Verdict;

/// Horizon unless told otherwise, in scaled time.
pub const HORIZON: f64 = 10_000.0;

/// Version of how the time-domain criterion judges. It changes whenever a verdict does, so that runs of different versions
/// are never mixed; the samples themselves are the results version's.
///
/// 2: ringing of the disc after the tangential motion has died away is no growth.
pub const VERDICTS_VERSION: u32 = 2;

/// Steps to the horizon at the most.
const MOST_STEPS: f64 = 1e8;

/// Displacement of a start near the equilibrium unless told otherwise, relative to x0.
pub const DISPLACEMENT: f64 = 0.01;

/// Where a motion starts. All but the tangential motion starts from steady sliding of the model in use.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub enum Start {
    /// At the sliding equilibrium, x displaced outwards by a stated fraction of x0: does steady sliding hold?
    NearEquilibrium,
    /// x = x' = 0, a brake that has just been applied: does it squeal?
    Rest,
    /// At the release from stick: does stick-slip keep itself going?
    LimitCycle,
}

/// How the motion of a sample is followed and judged.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TimeDomainSettings {
    /// Where it starts.
    pub start: Start,
    /// Displacement over x0, greater than 0. Where a motion does not start there, it is the distance from the
    /// equilibrium at which a shrinking motion counts as having come home.
    pub displacement: f64,
    /// Scaled time after which a sample is undecided, greater than 0.
    pub horizon: f64,
    /// Unstable where the settled amplitude (half peak to peak of x) exceeds this, the paper's own index; `None` for
    /// the motion itself: unstable where it grows or keeps to stick-slip.
    pub amplitude_index: Option<f64>,
    /// Whether unstable motions are followed until their amplitude has settled.
    pub record_amplitude: bool,
}

impl Default for TimeDomainSettings {
    fn default() -> Self {
        Self {
            start: Start::NearEquilibrium,
            displacement: DISPLACEMENT,
            horizon: HORIZON,
            amplitude_index: None,
            record_amplitude: false,
        }
    }
}

/// A setting that makes no sense.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum SettingsError {
    /// Out of range or not a number.
    #[error("{key} = {value} is out of range: it must be greater than 0 and at most {largest}")]
    OutOfRange {
        /// Which setting.
        key: &'static str,
        /// Its value.
        value: f64,
        /// The limit.
        largest: f64,
    },
}

impl TimeDomainSettings {
    /// Checks every value.
    ///
    /// # Errors
    /// [`SettingsError`] with the first one that is out of range.
    pub fn validate(&self) -> Result<(), SettingsError> {
        let check = |key, value: f64, largest| {
            if value > 0.0 && value <= largest {
                Ok(())
            } else {
                Err(SettingsError::OutOfRange { key, value, largest })
            }
        };
        check("displacement", self.displacement, 1e3)?;
        check("horizon", self.horizon, 1e9)?;
        self.amplitude_index.map_or(Ok(()), |amplitude| check("index.amplitude", amplitude, 1e3))
    }

    fn until_settled(&self) -> bool {
        self.record_amplitude || self.amplitude_index.is_some()
    }
}

/// The disc that a motion is followed on.
#[derive(Debug, Clone)]
pub enum DiscModel {
    /// The pad alone: no disc, `sin(phi) = 0`, `cos(phi) = 1`.
    Rigid,
    /// All of the equations, with this many modes of the disc.
    Flexible {
        /// See [`FlexibleBrake::with_modes`].
        modes: usize,
    },
}

/// What became of a sample.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JudgedMotion {
    /// The verdict.
    pub verdict: Verdict,
    /// Settled amplitude of an unstable motion, where settings ask for it.
    pub amplitude: Option<f64>,
    /// Scaled time that was followed.
    pub time: f64,
}

impl JudgedMotion {
    pub(crate) const OUTSIDE_PHYSICS: Self = Self { verdict: Verdict::Stable, amplitude: None, time: 0.0 };
    pub(crate) const FAILED: Self = Self { verdict: Verdict::Failed, amplitude: None, time: 0.0 };
}

/// The time-domain criterion at one rotating speed.
#[derive(Debug, Clone)]
pub struct TimeDomain {
    pub(crate) settings: TimeDomainSettings,
    pub(crate) system: System,
    pub(crate) brake: PadOnDisc,
}

#[derive(Debug, Clone)]
pub(crate) enum System {
    Rigid(RigidBrake),
    Flexible(Box<FlexibleBrake>),
}

impl TimeDomain {
    /// Prepares the criterion.
    ///
    /// # Errors
    /// As [`FlexibleBrake::with_modes`]; settings out of range; more steps to the horizon than anyone could wait for; and
    /// on a flexible disc a model that is unstable even without falling friction, of which the tangential motion says
    /// nothing.
    pub fn new(brake: &PadOnDisc, disc: &DiscModel, settings: TimeDomainSettings) -> Result<Self, FlexibleError> {
        settings.validate()?;
        let system = match disc {
            DiscModel::Rigid => System::Rigid(RigidBrake::new(brake)),
            DiscModel::Flexible { modes } => {
                System::Flexible(Box::new(FlexibleBrake::with_modes(brake.clone(), *modes)?))
            }
        };
        let criterion = Self { settings, system, brake: brake.clone() };
        let longest = MOST_STEPS * criterion.step_length();
        if settings.horizon > longest {
            return Err(SettingsError::OutOfRange { key: "horizon", value: settings.horizon, largest: longest }.into());
        }
        criterion.check_other_modes()?;
        Ok(criterion)
    }

    /// Whether everything but the tangential motion is stable: with friction that does not fall with speed, nothing feeds
    /// the tangential motion, and what still grows is another mode.
    fn check_other_modes(&self) -> Result<(), FlexibleError> {
        let System::Flexible(flexible) = &self.system else { return Ok(()) };
        let parameters = self.brake.parameters();
        let preload = parameters.operating_point.preload;
        let inputs = RandomInputs {
            preload: if preload > 0.0 { preload } else { 0.1 },
            static_friction: self.brake.friction_law().kinetic_coefficient,
        };
        let growth_rate = flexible.growth_rate(inputs)?;
        if growth_rate <= 0.0 {
            return Ok(());
        }
        let rotating_speed = parameters.operating_point.rotating_speed;
        Err(FlexibleError::OtherInstability { rotating_speed, growth_rate })
    }

    /// The same criterion with steps shorter by a factor: for studies of convergence.
    #[must_use]
    pub fn with_steps_divided_by(mut self, divisor: f64) -> Self {
        match &mut self.system {
            System::Rigid(brake) => brake.step /= divisor,
            System::Flexible(brake) => brake.step /= divisor,
        }
        self
    }

    /// Follows one sample until it is decided. Inputs outside physics (`Delta <= 0`, `f_s < f_c`) are stable by
    /// definition and not followed.
    #[must_use]
    pub fn judge(&self, inputs: RandomInputs) -> JudgedMotion {
        if self.brake.is_outside_physics(inputs) {
            return JudgedMotion::OUTSIDE_PHYSICS;
        }
        match &self.system {
            System::Rigid(brake) => {
                let sample = brake.sample(inputs);
                let (motion, judge) = self.start_rigid(&sample);
                self.follow(&sample, motion, judge, brake.step, 0)
            }
            System::Flexible(brake) => {
                let sample = FlexibleSample::new(brake, inputs);
                match self.start_flexible(&sample) {
                    Ok((motion, judge)) => self.follow(&sample, motion, judge, brake.step_length(), 0),
                    Err(_) => JudgedMotion::FAILED,
                }
            }
        }
    }

    /// Follows every sample of a list as [`TimeDomain::judge`] does, with the same bits, many at once.
    #[must_use]
    pub fn judge_all(&self, inputs: &[RandomInputs]) -> Vec<JudgedMotion> {
        self.judge_all_with(inputs, InstructionSet::widest())
    }

    pub(crate) fn rules(&self) -> Rules {
        let slowest_transient = match &self.system {
            System::Rigid(_) => None,
            System::Flexible(brake) => Some(brake.slowest_transient()),
        };
        Rules { horizon: self.settings.horizon, slowest_transient, until_settled: self.settings.until_settled() }
    }

    /// The motion that a sample starts with, and its judge.
    pub(crate) fn start_rigid(&self, sample: &RigidSample<'_>) -> (Motion<RigidState>, Judge) {
        let equilibrium = sample.equilibrium();
        let (x, u, contact) = self.tangential_start(equilibrium, sample.release(), sample.brake.disc_speed);
        (Motion { state: RigidState { x, u }, contact }, self.judge_of(equilibrium, x, u))
    }

    pub(crate) fn start_flexible(
        &self,
        sample: &FlexibleSample<'_>,
    ) -> Result<(Motion<crate::flexible_motion::FlexibleState>, Judge), FlexibleError> {
        let mut state = sample.equilibrium()?;
        let equilibrium = state.q[0];
        let release = sample.release(&state);
        let (x, u, contact) = self.tangential_start(equilibrium, release, sample.brake.pad.disc_speed);
        state.q[0] = x;
        state.u[0] = u;
        Ok((Motion { state, contact }, self.judge_of(equilibrium, x, u)))
    }

    fn tangential_start(&self, equilibrium: f64, release: f64, disc_speed: f64) -> (f64, f64, ContactState) {
        match self.settings.start {
            Start::NearEquilibrium => (equilibrium * (1.0 + self.settings.displacement), 0.0, ContactState::Slip),
            Start::Rest => (0.0, 0.0, ContactState::Slip),
            Start::LimitCycle => (release, disc_speed, ContactState::Stick),
        }
    }

    fn judge_of(&self, equilibrium: f64, x: f64, u: f64) -> Judge {
        Judge::new(self.rules(), equilibrium, self.settings.displacement, (u == 0.0).then_some(x))
    }

    /// Follows a motion that has come `begun` steps far to its verdict or to the horizon.
    pub(crate) fn follow<E: Equations>(
        &self,
        equations: &E,
        mut motion: Motion<E::State>,
        mut judge: Judge,
        h: f64,
        begun: u64,
    ) -> JudgedMotion {
        let steps = self.steps_to_horizon(h);
        for step in begun..steps {
            let time = step as f64 * h;
            if advance(equations, &mut motion, time, h, &mut judge).is_err() {
                return self.conclude_without_verdict(Verdict::Failed, &judge, time);
            }
            if is_time_to_look(step + 1) {
                judge.looks(equations.tangential(&motion.state).0);
            }
            if let Some(verdict) = judge.verdict() {
                return self.conclude(verdict, &judge, (step + 1) as f64 * h);
            }
        }
        self.conclude_without_verdict(Verdict::Undecided, &judge, steps as f64 * h)
    }

    /// The outcome of a motion that ended at the horizon or broke down. One that is known to be unstable is so without
    /// a settled amplitude, unless that amplitude is what decides.
    pub(crate) fn conclude_without_verdict(&self, otherwise: Verdict, judge: &Judge, time: f64) -> JudgedMotion {
        let known = judge.is_unstable() && self.settings.amplitude_index.is_none();
        JudgedMotion { verdict: if known { Verdict::Unstable } else { otherwise }, amplitude: None, time }
    }

    pub(crate) fn steps_to_horizon(&self, h: f64) -> u64 {
        (self.settings.horizon / h).ceil() as u64
    }

    /// The outcome of a motion with this verdict; with the paper's index the settled amplitude has the last word.
    pub(crate) fn conclude(&self, verdict: Verdict, judge: &Judge, time: f64) -> JudgedMotion {
        let amplitude = (verdict == Verdict::Unstable && self.settings.until_settled()).then(|| judge.amplitude());
        let verdict = match (self.settings.amplitude_index, amplitude) {
            (Some(limit), Some(amplitude)) if amplitude <= limit => Verdict::Stable,
            _ => verdict,
        };
        JudgedMotion { verdict, amplitude: amplitude.filter(|_| verdict == Verdict::Unstable), time }
    }
}

/// Whether a motion is looked at after this many steps, see [`Judge::looks`].
pub(crate) fn is_time_to_look(steps: u64) -> bool {
    steps.is_multiple_of(256)
}

impl FlexibleBrake {
    /// The slowest damping rate of the normal, angular and disc motion, taken apart.
    pub(crate) fn slowest_transient(&self) -> f64 {
        0.5 * self.disc_damping.min(self.pad.normal_damping).min(self.pad.angular_damping)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::Observer;

    const NOMINAL: RandomInputs = RandomInputs { preload: 0.1, static_friction: 0.39 };

    fn criterion(speed: f64, disc: &DiscModel, settings: TimeDomainSettings) -> TimeDomain {
        TimeDomain::new(&PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]), disc, settings).unwrap()
    }

    const FLEXIBLE: DiscModel = DiscModel::Flexible { modes: 5 };

    /// The last amplitudes of a motion, and when it last stuck.
    struct Aftermath {
        judge: Judge,
        last_stick: f64,
    }

    impl Observer for Aftermath {
        fn turns(&mut self, time: f64, x: f64) {
            self.judge.turns(time, x);
        }
        fn sticks(&mut self, time: f64, _: f64) {
            self.last_stick = time;
        }
        fn slips(&mut self, _: f64) {}
    }

    /// Follows a sample for `time`, whatever a judge might think of it.
    fn aftermath(criterion: &TimeDomain, inputs: RandomInputs, time: f64) -> Aftermath {
        fn run<E: Equations>(
            equations: &E,
            mut motion: Motion<E::State>,
            judge: Judge,
            h: f64,
            time: f64,
        ) -> Aftermath {
            let mut aftermath = Aftermath { judge, last_stick: f64::NEG_INFINITY };
            for step in 0..(time / h) as u64 {
                advance(equations, &mut motion, step as f64 * h, h, &mut aftermath).unwrap();
            }
            aftermath
        }
        match &criterion.system {
            System::Rigid(brake) => {
                let sample = brake.sample(inputs);
                let (motion, judge) = criterion.start_rigid(&sample);
                run(&sample, motion, judge, brake.step, time)
            }
            System::Flexible(brake) => {
                let sample = FlexibleSample::new(brake, inputs);
                let (motion, judge) = criterion.start_flexible(&sample).unwrap();
                run(&sample, motion, judge, brake.step_length(), time)
            }
        }
    }

    /// Follows a sample ten times as long as its verdict took, and finds the same.
    fn assert_verdict_holds(criterion: &TimeDomain, inputs: RandomInputs, context: &str) -> Verdict {
        let judged = criterion.judge(inputs);
        let (soon, late) = (judged.time, 10.0 * judged.time);
        let at_verdict = aftermath(criterion, inputs, soon).judge.amplitude();
        let end = aftermath(criterion, inputs, late);
        let keeps_sticking = end.last_stick > late - 10.0;
        match judged.verdict {
            Verdict::Unstable => {
                let holds = keeps_sticking || end.judge.amplitude() > at_verdict;
                assert!(holds, "{context}: {inputs:?} {judged:?} then {} {}", end.judge.amplitude(), end.last_stick);
            }
            Verdict::Stable => {
                let holds = !keeps_sticking && end.judge.amplitude() < at_verdict;
                assert!(holds, "{context}: {inputs:?} {judged:?} {at_verdict} then {}", end.judge.amplitude());
            }
            other => panic!("{context}: {inputs:?} {other:?}"),
        }
        judged.verdict
    }

    #[test]
    fn verdicts_hold_ten_times_as_long_near_both_boundaries() {
        for (disc, boundaries) in [(DiscModel::Rigid, [15.56, 30.197]), (FLEXIBLE, [15.398, 30.6])] {
            for start in [Start::NearEquilibrium, Start::Rest, Start::LimitCycle] {
                let mut seen = [0; 4];
                for (boundary, offset) in
                    boundaries.into_iter().flat_map(|b| (0..24).map(move |i| (b, (f64::from(i) - 11.3) / 11.3)))
                {
                    // Denser towards the boundary: to one part in 1400 of it.
                    let speed = boundary * (1.0 + 0.05 * offset * offset * offset.signum());
                    let criterion = criterion(speed, &disc, TimeDomainSettings { start, ..Default::default() });
                    let verdict = assert_verdict_holds(&criterion, NOMINAL, &format!("{disc:?} {start:?} {speed}"));
                    seen[verdict as usize] += 1;
                }
                assert!(seen[0] >= 10 && seen[1] >= 10, "{disc:?} {start:?} {seen:?}: both verdicts must occur");
            }
        }
    }

    #[test]
    fn ringing_of_the_disc_is_no_instability() {
        // Much preload and little falling friction: the tangential motion dies away faster than the disc rings, and what
        // is left to see beats. No stick-slip exists there (22 rad/s, the limit cycle starts at f_s = 0.264 and more).
        for speed in [22.0, 30.0] {
            let criterion =
                criterion(speed, &FLEXIBLE, TimeDomainSettings { start: Start::Rest, ..Default::default() });
            for i in 0..60 {
                let (row, column) = (i / 10, i % 10);
                let preload = 0.35 + 0.13 * f64::from(row);
                let static_friction = 0.2502 + 0.0008 * f64::from(column);
                let inputs = RandomInputs { preload, static_friction };
                let end = aftermath(&criterion, inputs, 400.0);
                assert!(
                    end.judge.amplitude() < 2e-5 && end.last_stick < 50.0,
                    "{speed} {inputs:?}: it does not come to rest"
                );
                assert_eq!(criterion.judge(inputs).verdict, Verdict::Stable, "{speed} {inputs:?}");
            }
        }
    }

    #[test]
    fn the_threshold_in_time_is_that_of_the_eigenvalues() {
        for disc in [DiscModel::Rigid, FLEXIBLE] {
            // A small displacement: at one percent of x0 the falling friction is no longer quite linear.
            let settings = TimeDomainSettings { displacement: 1e-4, ..Default::default() };
            let boundary = |is_unstable: &dyn Fn(&TimeDomain) -> bool| {
                let (mut slow, mut fast) = (14.0, 17.0);
                while fast - slow > 1e-4 {
                    let middle = 0.5 * (slow + fast);
                    if is_unstable(&criterion(middle, &disc, settings)) { slow = middle } else { fast = middle }
                }
                slow
            };
            let in_time = boundary(&|criterion| criterion.judge(NOMINAL).verdict == Verdict::Unstable);
            let by_eigenvalues = boundary(&|criterion| match &criterion.system {
                System::Rigid(_) => criterion.brake.growth_rate() > 0.0,
                System::Flexible(brake) => brake.growth_rate(NOMINAL).unwrap() > 0.0,
            });
            // What is left is the damping of the method, a part in 10^5.
            assert!((in_time - by_eigenvalues).abs() < 1e-3, "{disc:?} {in_time} {by_eigenvalues}");
        }
    }

    #[test]
    fn what_a_brake_does_between_the_boundaries_depends_on_its_start() {
        for disc in [DiscModel::Rigid, FLEXIBLE] {
            for (speed, expected) in [
                (12.0, [Verdict::Unstable, Verdict::Unstable, Verdict::Unstable]),
                (22.0, [Verdict::Stable, Verdict::Unstable, Verdict::Unstable]),
                (34.0, [Verdict::Stable, Verdict::Stable, Verdict::Stable]),
            ] {
                for (start, expected) in
                    [Start::NearEquilibrium, Start::Rest, Start::LimitCycle].into_iter().zip(expected)
                {
                    let criterion = criterion(speed, &disc, TimeDomainSettings { start, ..Default::default() });
                    assert_eq!(criterion.judge(NOMINAL).verdict, expected, "{disc:?} {speed} {start:?}");
                }
            }
        }
    }

    #[test]
    fn the_settled_amplitude_is_that_of_the_limit_cycle() {
        let settings = TimeDomainSettings { record_amplitude: true, ..Default::default() };
        for speed in [8.0, 12.0, 15.0] {
            let brake = PadOnDisc::preset_with(&[("operating_point.rotating_speed", speed)]);
            let cycle = brake.limit_cycle().unwrap();
            let expected = 0.5 * (cycle.tangential_max - cycle.tangential_min);
            let rigid = criterion(speed, &DiscModel::Rigid, settings).judge(NOMINAL).amplitude.unwrap();
            assert!((rigid / expected - 1.0).abs() < 2e-4, "{speed}: {rigid} {expected}");
            let flexible = criterion(speed, &FLEXIBLE, settings).judge(NOMINAL).amplitude.unwrap();
            assert!((flexible / expected - 1.0).abs() < 0.05, "{speed}: {flexible} {expected}");
        }
    }

    #[test]
    fn the_papers_index_is_a_limit_on_the_settled_amplitude() {
        let judge = |limit: f64| {
            let settings = TimeDomainSettings { amplitude_index: Some(limit), ..Default::default() };
            criterion(12.0, &DiscModel::Rigid, settings).judge(NOMINAL).verdict
        };
        // The limit cycle at 12 rad/s has an amplitude of 0.0057.
        assert_eq!([judge(0.005), judge(0.006)], [Verdict::Unstable, Verdict::Stable]);
    }

    #[test]
    fn inputs_outside_physics_are_stable_and_blown_up_ones_failed() {
        let criterion = criterion(10.0, &FLEXIBLE, TimeDomainSettings::default());
        for (preload, static_friction) in [(0.0, 0.4), (-0.1, 0.4), (0.1, 0.2), (-0.1, 0.2)] {
            let judged = criterion.judge(RandomInputs { preload, static_friction });
            assert_eq!((judged.verdict, judged.time), (Verdict::Stable, 0.0));
        }
        let judged = criterion.judge(RandomInputs { preload: 1e9, static_friction: 1e9 });
        assert_eq!(judged.verdict, Verdict::Failed);
        assert_eq!(criterion.judge(RandomInputs { preload: f64::NAN, static_friction: 0.4 }).verdict, Verdict::Failed);
    }

    #[test]
    fn recording_the_amplitude_changes_no_verdict() {
        for (disc, horizon) in [(DiscModel::Rigid, 9.0), (FLEXIBLE, 40.0)] {
            for start in [Start::NearEquilibrium, Start::Rest] {
                let plain = TimeDomainSettings { start, horizon, ..Default::default() };
                let recording = TimeDomainSettings { record_amplitude: true, ..plain };
                let [plain, recording] = [plain, recording].map(|settings| criterion(15.0, &disc, settings));
                for i in 0..120 {
                    let inputs = RandomInputs { preload: 0.003 * f64::from(i), static_friction: 0.39 };
                    let (plain, recording) = (plain.judge(inputs), recording.judge(inputs));
                    assert_eq!(plain.verdict, recording.verdict, "{disc:?} {start:?} {inputs:?}");
                    assert!(recording.amplitude.is_none() || recording.verdict == Verdict::Unstable);
                }
            }
        }
    }

    #[test]
    fn a_displacement_beyond_the_limit_cycle_is_no_home_to_come_to() {
        for disc in [DiscModel::Rigid, FLEXIBLE] {
            for displacement in [0.5, 5.0, 20.0] {
                let settings = TimeDomainSettings { displacement, ..Default::default() };
                assert_eq!(
                    criterion(10.0, &disc, settings).judge(NOMINAL).verdict,
                    Verdict::Unstable,
                    "{displacement}"
                );
                assert_eq!(criterion(40.0, &disc, settings).judge(NOMINAL).verdict, Verdict::Stable, "{displacement}");
            }
        }
    }

    #[test]
    fn overdamped_and_stiff_motions_are_decided_too() {
        for damping in [6e3, 1e4, 1e5] {
            for disc in [DiscModel::Rigid, FLEXIBLE] {
                for start in [Start::NearEquilibrium, Start::Rest] {
                    let brake = PadOnDisc::preset_with(&[("damping.tangential", damping)]);
                    let settings = TimeDomainSettings { start, ..Default::default() };
                    let judged = TimeDomain::new(&brake, &disc, settings).unwrap().judge(NOMINAL);
                    assert_eq!(judged.verdict, Verdict::Stable, "{damping} {disc:?} {start:?} {judged:?}");
                }
            }
        }
        // The normal motion may be as stiff.
        let brake = PadOnDisc::preset_with(&[("damping.normal", 1e5)]);
        let judged = TimeDomain::new(&brake, &FLEXIBLE, TimeDomainSettings::default()).unwrap().judge(NOMINAL);
        assert_eq!(judged.verdict, Verdict::Stable, "{judged:?}");
    }

    #[test]
    fn a_brake_whose_disc_flutters_is_refused() {
        // Without damping the disc is unstable at any speed; with it, far beyond all that discs withstand.
        for changes in [
            [("disc.transverse_damping_ratio", 0.0), ("operating_point.rotating_speed", 20.0)],
            [("disc.transverse_damping_ratio", 0.02), ("operating_point.rotating_speed", 2e4)],
        ] {
            let brake = PadOnDisc::preset_with(&changes);
            let refused = TimeDomain::new(&brake, &FLEXIBLE, TimeDomainSettings::default()).unwrap_err();
            assert!(matches!(refused, FlexibleError::OtherInstability { .. }), "{refused}");
        }
    }

    #[test]
    fn a_short_horizon_leaves_samples_undecided() {
        let settings = TimeDomainSettings { horizon: 3.0, ..Default::default() };
        assert_eq!(criterion(15.5, &FLEXIBLE, settings).judge(NOMINAL).verdict, Verdict::Undecided);
    }

    #[test]
    fn silly_settings_are_refused() {
        for bad in [0.0, -1.0, f64::NAN, f64::INFINITY] {
            let good = TimeDomainSettings::default();
            assert!(TimeDomainSettings { horizon: bad, ..good }.validate().is_err());
            assert!(TimeDomainSettings { displacement: bad, ..good }.validate().is_err());
            assert!(TimeDomainSettings { amplitude_index: Some(bad), ..good }.validate().is_err());
        }
        assert!(TimeDomainSettings::default().validate().is_ok());
        // More steps than anyone could wait for.
        let brake = PadOnDisc::preset_with(&[]);
        let endless = TimeDomainSettings { horizon: 1e8, ..Default::default() };
        assert!(matches!(
            TimeDomain::new(&brake, &DiscModel::Rigid, endless).unwrap_err(),
            FlexibleError::Settings(SettingsError::OutOfRange { key: "horizon", .. })
        ));
    }
}
