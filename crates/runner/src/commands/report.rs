//! `report`: runs as one HTML file.

use crate::cli::ReportArguments;
use crate::commands::compare::{CONFIDENCE, Differences, Run, differences_of, interval_name};
use crate::failure::Failure;
use crate::files::publish::publish;
use crate::interrupt::Interrupt;
use crate::output::{note, output_file, result, shown};
use crate::report::{ComparedCell, Comparison, ReportedRun, page};
use crate::schedule::engine::Engine;

/// `stickslip report`.
pub fn report(arguments: &ReportArguments, interrupt: &Interrupt) -> Result<(), Failure> {
    let out = match (&arguments.out, &arguments.runs[..]) {
        (Some(out), _) => out.clone(),
        (None, [run]) => run.join("report.html"),
        (None, _) => "report.html".into(),
    };
    let runs: Vec<ReportedRun> = arguments.runs.iter().map(|run| ReportedRun::read(run)).collect::<Result<_, _>>()?;
    let (directory, name) = output_file(&out)?;
    let comparisons = if runs.len() > 1 { comparisons(arguments, interrupt)? } else { Vec::new() };
    let page = page(&runs, &comparisons)?;
    publish(&directory, &name, page.as_bytes())?;
    result(&format!("{}\n", shown(&out)))
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
