//! `limit`: the values of an axis at which the probability of instability passes a target.

mod report;

mod search;

mod publish;

use indicatif::HumanCount;

pub use self::publish::{check_limits, publish_limits, with_limits_of};
use self::search::{Tiles, Wanted};
use super::kept_beside::{KeptBeside, nothing_was_written};
use super::named_job::read_job;
use crate::cli::LimitArguments;
use crate::failure::Failure;
use crate::files::table::write_table;
use crate::interrupt::Interrupt;
use crate::job::{Job, LimitAxis, LimitMethod};
use crate::messages::Code;
use crate::output::{announce, output_file, result, warn};
use crate::schedule::engine::Engine;
use crate::store::directory::RunDirectory;

/// `stickslip limit`.
pub fn limit(arguments: &LimitArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    interrupt.remark(nothing_was_written());
    let LimitArguments { job: path, of, probabilities, out, json, threads } = arguments;
    let directory = path.is_dir().then(|| RunDirectory::view(path)).transpose()?;
    let job = directory.as_ref().map_or_else(|| read_job(path)?.job(), RunDirectory::job)?;
    let twice = probabilities.iter().enumerate().find(|(i, probability)| probabilities[..*i].contains(probability));
    if let Some((_, probability)) = twice {
        return Err(Failure::Usage(format!("--probability {probability} is given twice; give it once")));
    }
    let (of, targets) = request(&job, of.as_deref(), probabilities)?;
    let refused = |why: String| Failure::Usage(format!("--of {of}: {why}"));
    let axis = LimitAxis::named(&job, of).map_err(refused)?;
    let method = LimitMethod::for_axis(&job, &axis).map_err(refused)?;
    let out = out.as_deref().map(|out| output_file(out).map(|place| (out, place))).transpose()?;
    warn(job.warnings());
    let engine = Engine::new(threads.count())?;
    let wanted = Wanted { job: &job, axis: &axis, method, targets };
    let maps = directory.as_ref().map(RunDirectory::maps).transpose()?.flatten();
    let tiles = Tiles { known: maps.as_ref(), keep: None };
    let kept = out.as_ref().map(|(_, place)| KeptBeside::read(place, wanted.searches_of())).transpose()?;
    let stopped = kept.as_ref().map_or_else(nothing_was_written, KeptBeside::advice);
    interrupt.remark(stopped.clone());
    let found = wanted.find(&engine, tiles, interrupt, &stopped, kept.as_ref().map(KeptBeside::keeper))?;
    if let Some((out, (directory, name))) = out {
        write_table(&directory, &name, &found.table(), &found.footer())?;
        kept.into_iter().for_each(KeptBeside::forget);
        announce(Code::FileWritten, format_args!("{}: {} rows", out.display(), HumanCount(found.rows.len() as u64)));
    }
    result(&if *json { format!("{:#}\n", found.json()) } else { found.text() })?;
    let of_reduction = || job.reduction()?.contradiction().map(|why| format!("the matrices are reduced, and {why}"));
    found.contradiction().or_else(of_reduction).map_or(Ok(()), |why| Err(Failure::Audit(why)))
}

/// The name of the axis and the targets: those of the options, or of the table `[limit]`.
fn request<'a>(job: &'a Job, of: Option<&'a str>, probabilities: &'a [f64]) -> Result<(&'a str, &'a [f64]), Failure> {
    let of = of.or(job.limit.as_ref().map(|limit| &*limit.of));
    let targets =
        if probabilities.is_empty() { job.limit.as_ref().map(|limit| &limit.targets[..]) } else { Some(probabilities) };
    let missing = |option: &str| {
        Failure::Usage(format!(
            "{option} is missing, and the job \"{}\" has no [limit]; write for example --of {} --probability 0.01",
            job.name,
            example(job)
        ))
    };
    Ok((of.ok_or_else(|| missing("--of"))?, targets.ok_or_else(|| missing("--probability"))?))
}

/// The name of an axis along which a limit may be sought.
fn example(job: &Job) -> &str {
    let place = job.model().pair().map_or(0, |[first, _]| first);
    &job.quantity(place).name
}
