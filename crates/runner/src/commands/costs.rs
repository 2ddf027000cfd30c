//! What a job costs, in words: what `check` measures of a run, stage by stage.

use std::time::Instant;

use indicatif::HumanCount;

use crate::evaluate::evaluator::Evaluator;
use crate::evaluate::limits::expected_estimates;
use crate::evaluate::parts::Parts;
use crate::failure::Failure;
use crate::job::{Job, LimitAxis, LimitMethod, MapUse};
use crate::output::{counted, rate};
use crate::schedule::cost::{Time, Unmeasured};
use crate::schedule::engine::Engine;
use crate::schedule::integral_trial::try_integrals;
use crate::schedule::time_left::Duration;
use crate::schedule::trial::{SampleTrial, Trial};

/// Least seconds of set-up that are told, and their least share of the whole.
const TOLD_SECONDS: f64 = 1.0;
const TOLD_SHARE: f64 = 0.1;

/// Seconds in which a run starts, and writes its files to the disk, as measured with solid-state ones.
const FILES: f64 = 0.02;

/// The measured cost of a job.
pub(super) struct Cost {
    /// What it is, as comments.
    pub(super) text: String,
    /// How long the whole run takes, or why that is not known.
    pub(super) time: Result<Time, String>,
    /// Seconds of it in which the job is read and what all samples share is set up.
    pub(super) set_up: f64,
    /// Seconds that a sample takes on one thread, and the relative standard error; `None` if that is not known, or if no
    /// samples are drawn.
    pub(super) of_a_sample: Option<[f64; 2]>,
}

impl Cost {
    /// Of a job of which too little could be measured in so many seconds.
    pub(super) fn unknown(job: &Job, seconds: f64) -> Self {
        Self::of_reason(job, format!("{seconds:.1} seconds of measuring were too few"))
    }

    fn unmeasured(job: &Job, why: Unmeasured) -> Self {
        Self::of_reason(job, why.to_string())
    }

    fn of_reason(job: &Job, why: String) -> Self {
        let what = match job.draws_samples() {
            true => counted(job.total_samples(), "sample", "samples"),
            false => no_samples(job),
        };
        let text = format!("# {what}, in a time that is not known: {why}\n");
        Self { text, time: Err(why), set_up: 0.0, of_a_sample: None }
    }

    /// Of a job whose stages `text` describes.
    fn known(mut text: String, time: Time, set_up: f64, of_a_sample: Option<[f64; 2]>) -> Self {
        if set_up >= TOLD_SECONDS && set_up >= TOLD_SHARE * time.seconds {
            text += &format!(
                "# {} of that once: the job is read, and what its samples share is set up\n",
                Duration(set_up)
            );
        }
        Self { text, time: Ok(time), set_up, of_a_sample }
    }
}

/// Measures what a job costs that a command began to read then.
pub(super) fn measured(job: &Job, threads: usize, begun: Instant) -> Result<Cost, Failure> {
    let engine = Engine::new(threads)?;
    let evaluator = Evaluator::new(job)?;
    // A run reads its job and prepares it likewise.
    let preparation = begun.elapsed().as_secs_f64() + FILES;
    let stage = Stage { job, engine: &engine, threads, begun, preparation };
    match (job.uses_maps(), job.draws_samples()) {
        (true, _) => stage.maps(&evaluator),
        (false, false) => stage.integrals(&evaluator),
        (false, true) => stage.samples(&evaluator),
    }
}

/// What the stages of a run are measured with.
struct Stage<'a> {
    job: &'a Job,
    engine: &'a Engine,
    threads: usize,
    begun: Instant,
    /// Seconds until the first of them begins.
    preparation: f64,
}

impl Stage<'_> {
    /// The cost of samples that are decided one by one, with the plain ones beside them.
    fn samples(&self, evaluator: &Evaluator<'_>) -> Result<Cost, Failure> {
        let trial = match self.engine.try_samples(evaluator, self.begun)? {
            Ok(trial) => trial,
            Err(why) => return Ok(Cost::unmeasured(self.job, why)),
        };
        let (beside, _) = match self.audits(evaluator)? {
            Ok(audits) => audits,
            Err(why) => return Ok(Cost::unmeasured(self.job, why)),
        };
        let set_up = self.preparation + trial.cost.set_ups(evaluator.set_ups(), self.threads);
        let time = Time::known(set_up) + self.time_of(&trial) + beside;
        let (limits, line) = self.limits(trial.time(self.job.sampling.samples, 1, 1), beside);
        let text = format!("# {}\n{line}", self.line(&trial, time));
        Ok(Cost::known(text, time + limits, set_up, Some([trial.cost.unit, trial.cost.error])))
    }

    /// The cost of integrals without verdict maps, with the plain samples beside them.
    fn integrals(&self, evaluator: &Evaluator<'_>) -> Result<Cost, Failure> {
        let trial = match try_integrals(evaluator, self.begun) {
            Ok(trial) => trial,
            Err(why) => return Ok(Cost::unmeasured(self.job, why)),
        };
        let (beside, set_ups) = match self.audits(evaluator)? {
            Ok(audits) => audits,
            Err(why) => return Ok(Cost::unmeasured(self.job, why)),
        };
        let set_up = self.preparation + set_ups;
        let time = Time::known(set_up) + trial.cost.units(trial.integrals as f64, 1.0, self.threads) + beside;
        let (limits, line) = self.limits(trial.cost.units(1.0, 1.0, 1), beside);
        let text = format!("# {}, {} on {}\n{line}", no_samples(self.job), time.prediction(), self.on());
        Ok(Cost::known(text, time + limits, set_up, None))
    }

    /// The cost of verdict maps, estimated from some of their tiles, and whether the samples cost less.
    fn maps(&self, evaluator: &Evaluator<'_>) -> Result<Cost, Failure> {
        let (job, threads) = (self.job, self.threads);
        let trial = match self.engine.try_maps(evaluator, self.begun)? {
            Ok(trial) => trial,
            Err(why) => return Ok(Cost::unmeasured(job, why)),
        };
        let tiles = evaluator.maps().needed() as u64;
        let map_time = trial.cost.units(tiles as f64, 1.0, threads);
        let simulations = (trial.simulations * tiles as f64) as u64;
        let map = format!(
            "about {} for the verdict map of {} (measured on {} of them), {} on {}",
            counted(simulations.into(), "simulation", "simulations"),
            counted(tiles.into(), "tile", "tiles"),
            HumanCount(trial.tiles),
            map_time.prediction(),
            self.on(),
        );
        let audited = counted(job.audited_samples(), "simulation", "simulations");
        let audit_line = |time: Time| format!("{audited} for its audit, {}", time.prediction());
        if job.map_use() == MapUse::Integrate {
            let (audit, set_ups) = match self.audits(evaluator)? {
                Ok(audits) => audits,
                Err(why) => return Ok(Cost::unmeasured(job, why)),
            };
            let set_up = self.preparation + set_ups;
            let time = Time::known(set_up) + map_time + audit;
            let text = format!("# no samples; {map}\n# {}\n", audit_line(audit));
            return Ok(Cost::known(text, time, set_up, None));
        }
        let trial = match self.engine.try_samples(&Evaluator::new(job)?, self.begun)? {
            Ok(trial) => trial,
            Err(why) => return Ok(Cost::unmeasured(job, why)),
        };
        let audit = trial.cost.units(job.audited_samples() as f64, trial.serial as f64, threads);
        let set_up = self.preparation + trial.cost.set_ups(evaluator.set_ups(), threads);
        let each_time = self.time_of(&trial);
        let each = self.line(&trial, each_time);
        // Simulations of a map lie near boundaries and may be slower than those of samples.
        let hint = if each_time.seconds < map_time.seconds + audit.seconds {
            "# evaluate = \"each\" takes less time for this job\n"
        } else {
            ""
        };
        let time = Time::known(set_up) + map_time + audit;
        let text = format!("# {map}\n# {}\n# if each is simulated: {each}\n{hint}", audit_line(audit));
        Ok(Cost::known(text, time, set_up, Some([trial.cost.unit, trial.cost.error])))
    }

    /// How long the samples take that check the probabilities, and seconds in which they are set up.
    fn audits(&self, evaluator: &Evaluator<'_>) -> Result<Trial<(Time, f64)>, Failure> {
        let samples = Parts::of_audits(self.job).max_samples(0);
        if samples == 0 {
            return Ok(Ok((Time::default(), 0.0)));
        }
        let trial = self.engine.try_audits(evaluator, self.begun)?;
        let time = |trial: SampleTrial| {
            let set_ups = trial.cost.set_ups(evaluator.set_ups(), self.threads);
            (trial.time(samples, self.job.cells(), self.threads), set_ups)
        };
        Ok(trial.map(time))
    }

    /// How long the limits take that the job asks for, where a cell takes this time on one thread, and a line that says so. Each
    /// limit and each end of its axis has as many plain samples as a cell, those of all of which take the time `beside`.
    fn limits(&self, cell: Time, beside: Time) -> (Time, String) {
        let (job, none) = (self.job, (Time::default(), String::new()));
        let Some(request) = &job.limit else { return none };
        let Ok(axis) = LimitAxis::named(job, &request.of) else { return none };
        let Ok(method) = LimitMethod::for_axis(job, &axis) else { return none };
        let combinations = axis.combinations(job).len();
        // A thread searches a whole combination.
        let of_a_thread = combinations.div_ceil(self.threads) as f64;
        let cells = of_a_thread * expected_estimates(job, &axis, method, request.targets.len());
        let places = combinations as f64 * (request.targets.len() + 2) as f64 / job.cells() as f64;
        let time = Time { seconds: cells * cell.seconds, error: cells * cell.error }
            + Time { seconds: places * beside.seconds, error: places * beside.error };
        let what = counted(combinations as u128, "combination", "combinations");
        let line = format!("# {} more for the limits of {} in {what}\n", time.prediction(), request.of);
        (time, line)
    }

    fn time_of(&self, trial: &SampleTrial) -> Time {
        trial.time(self.job.sampling.samples, self.job.cells(), self.threads)
    }

    fn on(&self) -> String {
        counted(self.threads as u128, "thread", "threads")
    }

    /// What is said of samples that take this time.
    fn line(&self, trial: &SampleTrial, time: Time) -> String {
        let total = counted(self.job.total_samples(), "sample", "samples");
        let rate = rate(1.0 / trial.cost.unit.max(1e-12));
        let how = if trial.cost.fall.is_some() { "measured now, rising" } else { "measured now" };
        let measured = format!("{} on {} ({rate} samples/s on one, {how})", time.prediction(), self.on());
        match trial.until_stop {
            Some(stop) => {
                let expected = HumanCount((stop.samples * self.job.cells() as f64) as u64);
                format!("at most {total}, about {expected} expected, {measured}")
            }
            None if self.job.stops_by_precision() => format!("at most {total}, {measured} for all of them"),
            None => format!("{total}, {measured}"),
        }
    }
}

/// Why no samples are drawn.
fn no_samples(job: &Job) -> String {
    match job.integrated() {
        _ if job.uses_maps() => "no samples".to_owned(),
        Some(place) => format!("no samples: critical values of {} are found instead", job.quantity(place).name),
        None => "no samples: the boundary is known in closed form".to_owned(),
    }
}
