//! `plot`: the result of a run, or a simulated motion, as a figure.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use indicatif::HumanCount;

use super::cell;
use super::compare::{CONFIDENCE, Row, Run, differences_of, interval_name};
use super::modes::{lines, squeal};
use super::one_brake::cell_of;
use crate::cli::{PlotArguments, PlotQuantity};
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::output::{note, result, shown};
use crate::picture::panels::{MOST_PANELS, left_out};
use crate::picture::view::{GridView, rounded};
use crate::plot::area::step_of;
use crate::plot::canvas::Canvas;
use crate::plot::cells;
use crate::plot::difference::Difference;
use crate::plot::drawing::{WIDTHS, write};
use crate::plot::form::Form;
use crate::plot::motion::{self, Excerpt};
use crate::plot::sobol::Sobol;
use crate::plot::surface;
use crate::plot::values::Values;
use crate::plot::verdict_map::VerdictMaps;
use crate::schedule::engine::Engine;
use crate::store::directory::RunDirectory;
use crate::store::outdated;
use crate::tables::finished::FinishedSurface;

/// `stickslip plot`.
pub fn plot(arguments: &PlotArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let width = WIDTHS[usize::from(arguments.columns.clamp(1, 2)) - 1];
    check(arguments)?;
    let (mut canvas, beside) = if is_of_a_cell(arguments) {
        cell::figure(arguments, width, interrupt)?
    } else if arguments.run.is_file() && !is_of_modes(arguments.of) {
        let PlotArguments { from, to, title, .. } = arguments;
        let excerpt = Excerpt { from: *from, to: *to, title: title.as_deref() };
        (motion::figure(&arguments.run, excerpt, width)?, arguments.run.clone())
    } else {
        of_run(arguments, width, interrupt)?
    };
    if matches!(arguments.of, PlotQuantity::Probability | PlotQuantity::Sobol) {
        let runs = [Some(&arguments.run), arguments.against.as_ref()].into_iter().flatten();
        canvas.results = runs.filter_map(|run| outdated::results(&RunDirectory::view(run).ok()?)).collect();
    }
    let files = match &arguments.out {
        Some(out) => vec![out.clone()],
        None => ["svg", "png"].map(|extension| beside.with_extension(extension)).to_vec(),
    };
    let mut text = String::new();
    for file in files {
        write(&canvas, &file)?;
        // Writing to a string cannot fail.
        let _ = writeln!(text, "{}", shown(&file));
    }
    result(&text)
}

/// Whether a path is the file of a job.
fn is_job(path: &Path) -> bool {
    path.is_file() && path.extension().is_some_and(|extension| extension.eq_ignore_ascii_case("toml"))
}

/// Whether a plot shows modes, which are those of a job or of the job of a run.
fn is_of_modes(of: PlotQuantity) -> bool {
    matches!(of, PlotQuantity::Modes | PlotQuantity::SquealFrequencies)
}

/// Whether a plot shows one cell of a job. Of a job alone there are its inputs to see, if nothing else is asked for.
fn is_of_a_cell(arguments: &PlotArguments) -> bool {
    match arguments.of {
        PlotQuantity::Inputs
        | PlotQuantity::Samples
        | PlotQuantity::Convergence
        | PlotQuantity::Distribution
        | PlotQuantity::Friction => true,
        PlotQuantity::Probability => arguments.against.is_none() && is_job(&arguments.run),
        _ => false,
    }
}

/// The figure of the modes of a job, and where it is written if no file is given, without an extension.
fn of_modes(arguments: &PlotArguments, width: f64, interrupt: &Interrupt) -> Result<(Canvas, PathBuf), Failure> {
    let (path, threads) = (arguments.run.as_path(), arguments.threads.count());
    let (job, cell) = cell_of(path, arguments.cell)?;
    let (canvas, name) = if arguments.of == PlotQuantity::Modes {
        let plot = lines::along(&job, &cell, arguments.along.as_deref(), threads, interrupt)?;
        (plot.figure(width), "modes")
    } else {
        let plot = squeal::frequencies(&job, &cell, squeal::SAMPLES, threads, interrupt)?;
        (plot.figure(width), "squeal-frequencies")
    };
    Ok((canvas, cell::beside(path, name)))
}

/// Refuses options that do not go together.
fn check(arguments: &PlotArguments) -> Result<(), Failure> {
    let is_probability = arguments.of == PlotQuantity::Probability;
    let is_of_modes = is_of_modes(arguments.of);
    let of_a_cell = is_of_a_cell(arguments);
    let is_motion = arguments.run.is_file() && !is_of_modes && !of_a_cell;
    if is_motion && is_job(&arguments.run) {
        return Err(Failure::Usage(format!(
            "{} is a job, and what is to be drawn needs a run of it: submit the job, and name its directory",
            arguments.run.display()
        )));
    }
    if is_motion && (!is_probability || arguments.against.is_some()) {
        return Err(Failure::Usage(format!(
            "{} is a file; --of and --against need a run directory. Leave them out to draw a motion",
            arguments.run.display()
        )));
    }
    let is_of_run = is_probability && !arguments.run.is_file();
    let has_heading = of_a_cell && !matches!(arguments.of, PlotQuantity::Probability | PlotQuantity::Inputs);
    let is_of = |quantities: &[PlotQuantity]| quantities.contains(&arguments.of);
    // Options that are given, whether they may be, and what is said if not.
    let rules = [
        (
            arguments.against.is_some(),
            is_probability,
            "--against draws the difference of probabilities; leave --of out",
        ),
        (
            arguments.cell.is_some(),
            is_of(&[PlotQuantity::Sobol]) || is_of_modes || of_a_cell,
            "--cell chooses the cell of --of sobol, modes, squeal-frequencies, inputs, samples, convergence, distribution and friction; other plots show all cells",
        ),
        (
            !arguments.at.is_empty(),
            is_of_run,
            "--at is for the probability of a run and for --against; leave it out, or --of",
        ),
        (
            arguments.target.is_some(),
            is_of_run && arguments.against.is_none(),
            "--target is for the probability of a run; leave it out, or --of and --against",
        ),
        (
            arguments.title.is_some(),
            is_of_run || is_motion || has_heading,
            "--title is for the probability of a run, for --against, motions, samples, convergence, distribution and friction; leave it out",
        ),
        (
            arguments.from.or(arguments.to).is_some(),
            is_motion,
            "--from and --to choose the time of a motion, and need a file that trajectory or replay wrote",
        ),
        (
            arguments.result.is_some(),
            is_of(&[PlotQuantity::Sobol, PlotQuantity::Distribution]),
            "--result chooses the result of --of sobol and distribution; leave it out",
        ),
        (arguments.x.is_some(), is_of(&[PlotQuantity::Samples]), "--x chooses what --of samples draws; leave it out"),
        (arguments.y.is_some(), is_of(&[PlotQuantity::Samples]), "--y chooses what --of samples draws; leave it out"),
        (arguments.samples == Some(0), false, "--samples 0: there is nothing to draw; give 1 or more"),
        (
            arguments.samples.is_some(),
            is_of(&[PlotQuantity::Samples, PlotQuantity::Convergence]),
            "--samples is for --of samples and convergence; leave it out",
        ),
        (
            arguments.along.is_some(),
            is_of(&[PlotQuantity::Modes]),
            "--along chooses the parameter of --of modes; leave it out",
        ),
    ];
    let broken = rules.into_iter().find(|(is_given, may_be, _)| *is_given && !may_be);
    broken.map_or(Ok(()), |(.., message)| Err(Failure::Usage(message.to_owned())))
}

/// The figure of a run, and where it is written if no file is given, without an extension.
fn of_run(arguments: &PlotArguments, width: f64, interrupt: &Interrupt) -> Result<(Canvas, PathBuf), Failure> {
    let run = &arguments.run;
    if let Some(against) = &arguments.against {
        let difference = difference(arguments, against, interrupt)?;
        let view = view_of(&difference.job, arguments)?;
        let canvas = difference.figure(&view, width).ok_or_else(|| {
            let Difference { values, low, high, .. } = &difference;
            single_cell(run, &difference.job, &view, "the difference of its probabilities", (values, low, high))
        })?;
        return Ok((canvas, run.join("difference")));
    }
    match arguments.of {
        PlotQuantity::Probability => {
            let mut values = Values::read(run)?;
            values.job.target = arguments.target.or(values.job.target);
            let view = view_of(&values.job, arguments)?;
            left_out(&view).iter().for_each(|what| note(format_args!("{what}")));
            if !values.is_certain() {
                note_steps(&view);
            }
            let canvas = if values.is_certain() {
                cells::figure(&values, &view, width)
            } else {
                surface::figure(&values, &view, width)
            };
            let canvas = canvas.ok_or_else(|| {
                let Values { probability, low, high, .. } = &values;
                single_cell(run, &values.job, &view, "its probability of instability", (probability, low, high))
            })?;
            Ok((canvas, run.join("surface")))
        }
        PlotQuantity::Sobol => {
            let sobol = Sobol::read(run, arguments.result.as_deref())?;
            let cells = sobol.cells(run, arguments.cell)?;
            let name = arguments.result.as_ref().map_or_else(|| "sobol".to_owned(), |of| format!("sobol-{of}"));
            Ok((sobol.figure(&cells, width), run.join(name)))
        }
        PlotQuantity::Verdicts => {
            let maps = VerdictMaps::read(run)?;
            if maps.panels() > MOST_PANELS {
                note(format_args!(
                    "{} panels are too many for one figure; {MOST_PANELS} of them are drawn, from the first to the last",
                    maps.panels()
                ));
            }
            Ok((maps.figure(width), run.join("verdicts")))
        }
        // What shows a cell is not drawn here.
        _ => of_modes(arguments, width, interrupt),
    }
}

/// The view of a job's grid that is asked for.
fn view_of(job: &Job, arguments: &PlotArguments) -> Result<GridView, Failure> {
    let mut view = GridView::new(job).titled(arguments.title.clone());
    for (name, value) in &arguments.at {
        view.hold(name, *value).map_err(|why| Failure::Usage(format!("--at {name}={value}: {why}")))?;
    }
    Ok(view)
}

/// Says which axes of an area have more values than a figure shows.
fn note_steps(view: &GridView) {
    let Some(Form::Area { vertical, horizontal }) = Form::for_grid(view) else { return };
    for axis in [vertical, horizontal] {
        let step = step_of(axis.values.len());
        if step > 1 {
            note(format_args!(
                "the {} values of {} are finer than a figure can show; one of {step} is drawn",
                HumanCount(axis.values.len() as u64),
                axis.name_in_job
            ));
        }
    }
}

/// The values of all cells with the ends of their intervals.
type Known<'a> = (&'a [Option<f64>], &'a [f64], &'a [f64]);

/// The failure of a view that has nothing to draw: the number of its cell with the ends of its interval.
fn single_cell(run: &Path, job: &Job, view: &GridView, what: &str, (values, low, high): Known<'_>) -> Failure {
    let cell = view.slice(0).first as usize;
    let range = format!("{} to {}", rounded(low[cell]), rounded(high[cell]));
    let known = values[cell].map_or_else(
        || format!("{what} is not known, only {range}"),
        |value| format!("{what} is {} ({range})", rounded(value)),
    );
    if job.cells() > 1 {
        return Failure::Usage(format!("--at leaves a single cell of {}: {known}. Leave an axis out", run.display()));
    }
    Failure::Job(format!(
        "{} has a single cell: {known}. A plot needs several; give a quantity in [axes] more than one value, for example {} = {{ from = ..., to = ..., points = 26 }}",
        run.display(),
        job.quantity(0).name
    ))
}

/// The difference of a run and another with the same axes, as `compare` finds it.
fn difference(arguments: &PlotArguments, against: &Path, interrupt: &Interrupt) -> Result<Difference, Failure> {
    let run = arguments.run.as_path();
    let jobs = [run, against].map(|run| FinishedSurface::open(run).map(|surface| surface.job));
    let [job, other] = jobs;
    let (job, other) = (job?, other?);
    require_same_axes([run, against], [&job, &other])?;
    let view = view_of(&job, arguments)?;
    left_out(&view).iter().for_each(|what| note(format_args!("{what}")));
    note_steps(&view);
    let engine = Engine::new(arguments.threads.count())?;
    let runs = [Run::open(against)?, Run::open(run)?];
    let compared = differences_of(&runs, CONFIDENCE, false, &engine, interrupt)?;
    let rows = compared.first().map_or(&[][..], |differences| &differences.rows);
    let is_matched = |(cell, row): (u64, &Row)| row.cell.index == cell && row.second_cell == cell;
    if rows.len() as u64 != job.cells() || !(0..).zip(rows).all(is_matched) {
        return Err(Failure::Job(format!(
            "{} and {} have the same [axes], but not in every cell the same random.relative_std, so that no picture of all cells can be drawn; `stickslip compare` compares the cells that both have",
            run.display(),
            against.display()
        )));
    }
    let name = |path: &Path| path.file_name().unwrap_or(path.as_os_str()).to_string_lossy().into_owned();
    let is_saturated = |row: &Row| row.first == row.second && (row.first == Some(0.0) || row.first == Some(1.0));
    Ok(Difference {
        name: format!("P of {} minus P of {}", name(run), name(against)),
        intervals: interval_name(&[&runs[0], &runs[1]]),
        values: rows.iter().map(|row| row.difference.value).collect(),
        low: rows.iter().map(|row| row.difference.low).collect(),
        high: rows.iter().map(|row| row.difference.high).collect(),
        is_saturated: rows.iter().map(is_saturated).collect(),
        job,
    })
}

/// Refuses runs whose cells lie at different places. An axis of one value may be missing in one of them.
fn require_same_axes(runs: [&Path; 2], jobs: [&Job; 2]) -> Result<(), Failure> {
    let views = jobs.map(GridView::new);
    let of =
        |view: usize, name: &str| views[view].axes().iter().find(|axis| axis.name == name).map(|axis| &axis.values);
    let names = views.iter().flat_map(GridView::axes).map(|axis| &*axis.name);
    let count = |values: Option<&Vec<f64>>| values.map_or(1, Vec::len);
    let differing = names
        .map(|name| (name, of(0, name), of(1, name)))
        .find(|(_, a, b)| if a.is_some() && b.is_some() { a != b } else { count(*a) != count(*b) });
    let Some((name, a, b)) = differing else { return Ok(()) };
    let described = |values: Option<&Vec<f64>>| match values.map(|values| &values[..]) {
        None => "no axis".to_owned(),
        Some([value]) => format!("the value {}", rounded(*value)),
        Some(values) => {
            let ends = [values.first(), values.last()].map(|end| rounded(end.copied().unwrap_or(f64::NAN)));
            format!("{} values from {} to {}", values.len(), ends[0], ends[1])
        }
    };
    Err(Failure::Job(format!(
        "{} and {} have different axes, so their difference cannot be drawn: {name} has {} in the first, and {} in the second. Submit one of them again with the [axes] and random.relative_std of the other; `stickslip compare` compares the cells that both have",
        runs[0].display(),
        runs[1].display(),
        described(a),
        described(b)
    )))
}
