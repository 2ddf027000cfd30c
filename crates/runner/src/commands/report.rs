//! `report`: runs as one HTML file.

use crate::cli::ReportArguments;
use crate::commands::cell;
use crate::commands::compare::{CONFIDENCE, Differences, Run, differences_of, interval_name};
use crate::commands::modes::{lines, squeal};
use crate::commands::one_brake::shown_cell;
use crate::failure::Failure;
use crate::files::publish::publish;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::output::{note, output_file, result, shown};
use crate::report::{ComparedCell, Comparison, PICTURE_WIDTH, Picture, PictureKind, ReportedRun, page};
use crate::schedule::engine::Engine;

/// Samples whose frequencies are shown.
const SAMPLES: u64 = 2000;

/// `stickslip report`.
pub fn report(arguments: &ReportArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let out = match (&arguments.out, &arguments.runs[..]) {
        (Some(out), _) => out.clone(),
        (None, [run]) => run.join("report.html"),
        (None, _) => "report.html".into(),
    };
    let mut runs: Vec<ReportedRun> =
        arguments.runs.iter().map(|run| ReportedRun::read(run)).collect::<Result<_, _>>()?;
    let (directory, name) = output_file(&out)?;
    for (run, path) in runs.iter_mut().zip(&arguments.runs) {
        run.values.job = run.values.job.clone().asked(arguments.asked.target, &arguments.asked.at)?;
        let of_cells = cell::pictures(&run.values.job, path)?;
        run.pictures.extend(of_cells);
        let pictures = pictures_of_modes(&run.values.job, arguments.threads.count(), interrupt)?;
        run.pictures.extend(pictures);
    }
    let comparisons = if runs.len() > 1 { comparisons(arguments, interrupt)? } else { Vec::new() };
    let page = page(&runs, &comparisons)?;
    publish(&directory, &name, page.as_bytes())?;
    result(&format!("{}\n", shown(&out)))
}

/// The pictures of the modes of a run whose model is given by matrices, in the cell that is [shown](shown_cell).
fn pictures_of_modes(job: &Job, threads: usize, interrupt: &Interrupt) -> Result<Vec<Picture>, Failure> {
    if let Some(why) = job.model.unread() {
        note(format_args!("the report leaves the pictures of modes out of `{}`: {why}", job.name));
    }
    if job.model.as_matrices().is_none() {
        return Ok(Vec::new());
    }
    let cell = job.grid.cell(shown_cell(job));
    if job.model().has_slow_samples() {
        note(format_args!("finding the modes of cell {} for the pictures", cell.index));
    }
    let modes = lines::along(job, &cell, None, threads, interrupt).map(|plot| plot.figure(PICTURE_WIDTH));
    let frequencies = squeal::frequencies(job, &cell, SAMPLES, threads, interrupt);
    let frequencies = frequencies.map(|plot| plot.figure(PICTURE_WIDTH));
    let mut pictures = Vec::new();
    for (kind, figure) in [(PictureKind::Modes, modes), (PictureKind::SquealFrequencies, frequencies)] {
        match figure {
            Ok(canvas) => pictures.push(Picture { kind, canvas }),
            Err(why) if why.is_of_job() => note(format_args!("the report leaves a picture of modes out: {why}")),
            Err(why) => return Err(why),
        }
    }
    Ok(pictures)
}

/// The runs after the first, compared with it as `stickslip compare` does.
fn comparisons(arguments: &ReportArguments, interrupt: &Interrupt) -> Result<Vec<Comparison>, Failure> {
    let runs: Vec<Run> = arguments.runs.iter().map(|path| Run::open(path)).collect::<Result<_, _>>()?;
    let engine = Engine::new(arguments.threads.count())?;
    let compared = match differences_of(&runs, CONFIDENCE, false, &engine, interrupt) {
        Err(why) if why.is_of_job() => {
            note(format_args!("the runs stand beside each other without a comparison: {why}"));
            return Ok(Vec::new());
        }
        compared => compared?,
    };
    Ok(compared
        .iter()
        .enumerate()
        .map(|(i, differences)| comparison(i + 1, interval_name(&[&runs[0], &runs[i + 1]]), differences))
        .collect())
}

fn comparison(run: usize, interval_name: String, differences: &Differences<'_>) -> Comparison {
    let mut cells: Vec<Option<ComparedCell>> = (0..differences.job.cells()).map(|_| None).collect();
    for row in &differences.rows {
        let compared = ComparedCell {
            first: row.first,
            second: row.second,
            difference: row.difference.value,
            low: row.difference.low,
            high: row.difference.high,
        };
        cells[row.cell.index as usize] = Some(compared);
    }
    Comparison { run, interval_name, cells }
}
