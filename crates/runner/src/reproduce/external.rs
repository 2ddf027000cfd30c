//! Two friction oscillators that others published: numbers that nobody here wrote.
//!
//! - M. Stender, N. Hoffmann, "bSTAB: an open-source software for computing the basin stability of multi-stable
//!   dynamical systems", Nonlinear Dynamics (2021), doi 10.1007/s11071-021-06786-5.
//! - V. Veraszto, G. Stepan, International Journal of Non-Linear Mechanics (2017), doi
//!   10.1016/j.ijnonlinmec.2017.01.006.
//!
//! The model of both is `x'' = G mu(v - x') - K x - C x'` with Tustin's friction. The job specs hold their parameters.

use std::path::{Path, PathBuf};

use stickslip_core::models::pad_on_disc::rigid_disc::basin::Window;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;

use super::part::{Part, Table};
use super::score::{self, Score};
use crate::cli::ReproduceArguments;
use crate::commands::{FinishedRun, complete_run};
use crate::failure::Failure;
use crate::files::table::{DescribedColumn, write_columns};
use crate::interrupt::Interrupt;
use crate::job::{Job, JobSource};
use crate::picture::chart::{Chart, ChartAxis, Series};
use crate::picture::scale::Scale;

/// Limits of an oscillator, belt speeds in m/s.
struct Limits {
    critical: f64,
    end_of_stick_slip: f64,
}

/// An oscillator: its job, and its limits by SciPy.
struct Oscillator {
    name: &'static str,
    job: &'static str,
    limits: Limits,
}

const BSTAB: Oscillator = Oscillator {
    name: "bstab",
    job: include_str!("../../jobs/bstab.toml"),
    limits: Limits { critical: 1.151293, end_of_stick_slip: 1.836601 },
};

/// SciPy 1.17.1: the critical speed is where b + 0.2 = 40 exp(-10 v); the end of stick-slip by solve_ivp (DOP853, rtol
/// 1e-12, atol 1e-14) and brentq on the largest speed of the return of the slip phase released from stick.
const VERASZTO: Oscillator = Oscillator {
    name: "veraszto",
    job: include_str!("../../jobs/veraszto.toml"),
    limits: Limits { critical: 0.190616, end_of_stick_slip: 0.271789 },
};

/// The window of the authors' starts.
const WINDOW: Window = Window { tangential: (-2.0, 2.0), speed: (0.0, 2.0) };

/// The authors' starts for each speed, random and uniform.
const THEIR_STARTS: f64 = 5000.0;

/// How far a share may be from the authors', in standard errors of theirs.
const LARGEST_Z: f64 = 3.0;

/// How far the area may be from the reference.
const AREA_TOLERANCE: f64 = 1e-4;

/// The speed at which the authors' horizon is too short.
const SLOW: f64 = 1.175;

/// Share of the window that ends in steady sliding, for a belt speed v_d.
struct Share {
    speed: f64,
    /// As the authors' toolbox prints it.
    printed: f64,
    /// The area inside the unstable cycle, over that of the window, by SciPy (solve_ivp with DOP853, rtol 1e-13).
    area: f64,
}

const SHARES: [Share; 6] = [
    Share { speed: 1.175, printed: 0.0126, area: 0.018774 },
    Share { speed: 1.25, printed: 0.0838, area: 0.080197 },
    Share { speed: 1.4, printed: 0.2110, area: 0.212265 },
    Share { speed: 1.5, printed: 0.3120, area: 0.307126 },
    Share { speed: 1.625, printed: 0.4336, area: 0.428098 },
    Share { speed: 1.775, printed: 0.5552, area: 0.558367 },
];

impl Oscillator {
    fn source(&self) -> JobSource {
        JobSource { path: PathBuf::from(format!("jobs/{}.toml", self.name)), text: self.job.to_owned() }
    }

    /// The pad on a rigid disc that moves as it does, at a belt speed.
    fn at(&self, belt_speed: f64) -> Result<PadOnDisc, Failure> {
        let job = self.source().job()?;
        let mut expected = job.grid.cell(0).expected;
        expected[speed_of(&job)] = belt_speed;
        let pad = job.model.rigid_pad(&expected).transpose().map_err(|error| Failure::Job(error.to_string()))?;
        pad.ok_or_else(|| Failure::Internal(format!("jobs/{}.toml is of no oscillator", self.name)))
    }

    fn scores(&self, symbol: &str) -> Result<Vec<Score>, Failure> {
        let missing =
            |what: &str| Failure::InputOutput(format!("{} has no {what}; please report this as a bug", self.name));
        let brake = self.at(self.limits.critical)?;
        let critical = brake.unstable_speeds().pop().ok_or_else(|| missing("critical speed"))?.to;
        let end = brake.saddle_node_speed().ok_or_else(|| missing("end of stick-slip"))?;
        let row = |what: &str, printed, ours| Score {
            quantity: format!("{}, {what}, {symbol}", self.name),
            printed,
            decimals: 6,
            ours,
            role: "nothing fitted",
        };
        Ok(vec![
            row("critical speed", self.limits.critical, critical),
            row("end of stick-slip", self.limits.end_of_stick_slip, end),
        ])
    }

    /// Its job, and whether a motion released from stick sticks again up to the end of stick-slip and no further.
    fn stick_slip(&self, run: &FinishedRun) -> String {
        let surface = run.surface();
        let is_right = surface.rows().all(|row| {
            let sticks = row.cell.expected[speed_of(&run.job)] < self.limits.end_of_stick_slip;
            row.estimate.probability == Some(f64::from(u8::from(sticks)))
        });
        format!(
            "  released from stick in the time domain (jobs/{}.toml):\n  stick-slip up to its end, none above: {}\n",
            self.name,
            holds(is_right)
        )
    }
}

/// The limits of both oscillators and the areas of the first one, beside ours.
pub fn score_table() -> Result<Table, Failure> {
    let mut scores = BSTAB.scores("v_d")?;
    for Share { speed, area, .. } in SHARES {
        scores.push(Score {
            quantity: format!("bstab, share that returns, v_d {speed}"),
            printed: area,
            decimals: 6,
            ours: share(&BSTAB.at(speed)?)?,
            role: "nothing fitted",
        });
    }
    scores.extend(VERASZTO.scores("m/s")?);
    Ok(score::table("", "by independent integration", "reference", "ours", &scores))
}

/// `reproduce external`.
pub fn oscillators(
    directory: &Path,
    arguments: &ReproduceArguments,
    interrupt: &Interrupt,
) -> Result<Vec<Part>, Failure> {
    let run = |oscillator: &Oscillator| {
        let out = directory.join(oscillator.name);
        complete_run(&oscillator.source(), &out, arguments.threads.count(), interrupt)
    };
    let mut parts = vec![
        Part::text("Two published friction oscillators. Nothing was fitted to their numbers.\n\n"),
        Part::Table(score_table()?),
        Part::text("\nbstab: Stender and Hoffmann, Nonlinear Dynamics (2021),\n    doi 10.1007/s11071-021-06786-5\n\n"),
    ];
    parts.extend(shares(&run(&BSTAB)?)?);
    parts.extend(basins(directory)?);
    parts.push(Part::Text(format!(
        "veraszto: Veraszto and Stepan, Int. J. Non-Linear Mech. (2017),\n    \
         doi 10.1016/j.ijnonlinmec.2017.01.006\n\n{}",
        VERASZTO.stick_slip(&run(&VERASZTO)?)
    )));
    Ok(parts)
}

/// The share of the window that ends in steady sliding, exact and by random starts.
fn shares(run: &FinishedRun) -> Result<[Part; 3], Failure> {
    let introduction = format!(
        "Share of initial states on [-2, 2] x [0, 2] that end in steady sliding: the\n\
         authors' toolbox, {THEIR_STARTS} random states each; the area inside the unstable cycle\n\
         by SciPy; the same here; and jobs/bstab.toml, as many random states each\n\n"
    );
    let mut rows = Vec::new();
    let (mut largest_difference, mut largest_z, mut our_largest_z, mut slow_z) = (0.0_f64, 0.0_f64, 0.0_f64, 0.0);
    let mut ends_hold = true;
    let mut undecided_when_slow = 0;
    for row in run.surface().rows() {
        let (speed, counts) = (row.cell.expected[speed_of(&run.job)], row.counts);
        let exact = share(&BSTAB.at(speed)?)?;
        let ours = counts.stable as f64 / counts.total() as f64;
        let Some(Share { printed, area, .. }) = SHARES.iter().find(|share| share.speed == speed) else {
            ends_hold &= exact == ours && (exact == 0.0 || exact == 1.0);
            continue;
        };
        let standard_errors = |of: f64, starts: f64| (of - exact) / (of * (1.0 - of) / starts).sqrt();
        let (z, our_z) = (standard_errors(*printed, THEIR_STARTS), standard_errors(ours, counts.total() as f64));
        largest_difference = largest_difference.max((exact - area).abs());
        our_largest_z = our_largest_z.max(our_z.abs());
        if speed == SLOW {
            (slow_z, undecided_when_slow) = (z, counts.undecided);
        } else {
            largest_z = largest_z.max(z.abs());
        }
        rows.push([
            format!("{speed:.3}"),
            format!("{printed:.4}"),
            format!("{area:.6}"),
            format!("{exact:.6}"),
            format!("{ours:.4}"),
            counts.undecided.to_string(),
            format!("{z:+.1} s.e."),
            format!("{our_z:+.1} s.e."),
        ]);
    }
    let headings = ["v_d", "authors", "SciPy", "area", "ours", "undecided", "authors-area", "ours-area"];
    let table = Table::new("", headings, rows);
    let mut text = format!(
        "\n  s.e.: standard errors of the share\n\
         \x20 areas within {AREA_TOLERANCE} of SciPy's: {}; none at 1.1 and all at 1.85: {}\n\
         \x20 authors' shares within {LARGEST_Z} s.e. of the area, {SLOW} apart: {}, at most {largest_z:.1}\n\
         \x20 shares of jobs/bstab.toml within {LARGEST_Z}: {}, at most {our_largest_z:.1}\n",
        holds(largest_difference <= AREA_TOLERANCE),
        holds(ends_hold),
        holds(largest_z <= LARGEST_Z),
        holds(our_largest_z <= LARGEST_Z),
    );
    text += &format!(
        "  At {SLOW} the authors' share is {:.1} standard errors low. Small motions decay\n  \
         there with the time constant {:.0}, those near the unstable cycle more slowly\n  \
         still, and their simulation ends at t = 500. With this horizon {undecided_when_slow} of our states are\n  \
         undecided there: swings that shrink or grow decide, and the return map where\n  \
         swings hardly differ.\n\n",
        -slow_z,
        -1.0 / BSTAB.at(SLOW)?.growth_rate(),
    );
    Ok([Part::Text(introduction), Part::Table(table), Part::Text(text)])
}

/// The exact share of the window.
fn share(brake: &PadOnDisc) -> Result<f64, Failure> {
    brake.share_in_basin(&WINDOW).ok_or_else(|| {
        Failure::InputOutput("bstab has no basin of steady sliding; please report this as a bug".to_owned())
    })
}

/// The unstable cycles that bound the basins, drawn and written.
fn basins(directory: &Path) -> Result<[Part; 2], Failure> {
    let mut lines = Vec::new();
    let mut columns = [const { Vec::new() }; 3];
    for Share { speed, .. } in SHARES {
        let outline = BSTAB.at(speed)?.basin_outline().unwrap_or_default();
        for &(x, u) in &outline {
            for (column, value) in columns.iter_mut().zip([speed, x, u]) {
                column.push(value);
            }
        }
        lines.push(Series::numbered(lines.len(), format!("v_d {speed}"), outline));
    }
    let [speeds, x, u] = columns;
    let ends = (x.clone(), u.clone());
    let column = |name, unit, long_name, values: Vec<f64>| DescribedColumn { name, unit, long_name, values };
    let name = "basins.parquet";
    write_columns(
        directory,
        name,
        &[
            column("belt_speed", "m/s", "belt speed, v_d of the authors", speeds),
            column("x", "m", "displacement on the boundary of the basin", x),
            column("x_speed", "m/s", "speed on the boundary of the basin", u),
        ],
    )?;
    let chart = Chart::new(
        "The basins of steady sliding at six speeds: inside the curves the pad returns",
        ChartAxis::new("Displacement x at the start", "", Scale::around(ends.0.into_iter())),
        ChartAxis::new("Velocity x′ at the start", "", Scale::around(ends.1.into_iter())),
        lines,
    );
    Ok([Part::chart(chart), Part::Text(format!("data: {}\n\n", directory.join(name).display()))])
}

/// The place of the belt speed among the quantities of a job.
fn speed_of(job: &Job) -> usize {
    job.model().place("belt_speed").unwrap_or_default()
}

fn holds(condition: bool) -> &'static str {
    if condition { "holds" } else { "DOES NOT HOLD" }
}
