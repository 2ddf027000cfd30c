//! Tests of brakes from a CSV file, for `fit`.

use std::path::Path;

use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::fit::TestData;

use crate::failure::Failure;
use crate::files::csv_file::{self, CsvError, CsvFile, MOST_ROWS, read_csv};
use crate::messages::Place;

/// Most onset speeds and different conditions of verdicts: each takes an integral for each step of the search.
const MOST_CONDITIONS: usize = 2000;

/// Most brakes that a row counts.
const MOST_BRAKES: u64 = 1_000_000_000;

/// The columns of the two kinds of tests; the last of each may be left out.
const VERDICT_COLUMNS: [&str; 4] = ["rotating_speed", "preload", "squealed", "count"];
const ONSET_COLUMNS: [&str; 3] = ["onset_speed", "preload", "censored"];

/// What the first line should be.
const HEADERS: &str = "the first line should be rotating_speed,preload,squealed,count (verdicts; count may be left out) or onset_speed,preload,censored (onset speeds; censored may be left out)";

/// Half of the relative width of the interval around an onset speed over which its density is found.
const HALF_WIDTH: f64 = 1e-5;

/// Tests as their rows say.
pub struct Observed {
    /// The speed of the test, or at which it ended.
    pub speed: f64,
    /// The nominal preload.
    pub preload: f64,
    pub squealed: bool,
    pub count: u64,
}

/// What the tests say, and of which kind they are.
pub struct BrakeTests {
    /// The tests with their boundaries.
    pub data: TestData,
    pub observed: Vec<Observed>,
    /// Whether each has an onset speed.
    pub has_onsets: bool,
    /// With onset speeds: the speed above which they lie.
    pub steepest: f64,
}

/// The brake at its rotating speeds.
struct Brake<'a> {
    parameters: &'a Parameters,
    /// Where its friction falls most steeply; `None` for a measured curve.
    steepest: Option<f64>,
}

impl Brake<'_> {
    fn boundary(&self, rotating_speed: f64) -> Result<PairBoundary, String> {
        let mut parameters = self.parameters.clone();
        parameters.operating_point.rotating_speed = rotating_speed;
        PadOnDisc::new(parameters).map(|brake| brake.stability_boundary()).map_err(|error| error.to_string())
    }
}

/// The file, with its columns checked.
struct Rows<'a> {
    path: &'a Path,
    file: &'a CsvFile,
}

/// Reads tests of a brake from a file.
///
/// # Errors
/// A file that cannot be read, and a row that cannot be right, with line, column, value and remedy.
pub fn read_tests(path: &Path, brake: &PadOnDisc) -> Result<BrakeTests, Failure> {
    let bytes = read_csv(path).map_err(|why| Failure::InputOutput(why).at(Place::file(path)))?;
    let brake = Brake { parameters: brake.parameters(), steepest: brake.steepest_speed() };
    let file = CsvFile::new(path, bytes).map_err(|error| refused(path, &error))?;
    Rows { path, file: &file }.read(&brake)
}

/// What is wrong in the file.
fn refused(path: &Path, error: &CsvError) -> Failure {
    let place = error.line.map_or_else(|| Place::file(path), |line| Place::line(path, line));
    Failure::Job(error.to_string()).at(place)
}

impl Rows<'_> {
    fn read(&self, brake: &Brake<'_>) -> Result<BrakeTests, Failure> {
        let has_onsets = self.check_names()?;
        let steepest = match (has_onsets, brake.steepest) {
            (true, None) => {
                let why = "onset speeds cannot be used with friction.law = \"table\", whose curve may fall in several places; give verdicts: the columns rotating_speed, preload, squealed";
                return Err(self.wrong(1, why));
            }
            (_, steepest) => steepest.unwrap_or(0.0),
        };
        let numbers = ["rotating_speed", "onset_speed", "preload"].map(|name| self.file.place(name));
        let rows = self.file.rows(&numbers.into_iter().flatten().collect::<Vec<_>>());
        let (mut data, mut observed) = (TestData::default(), Vec::new());
        for (number, row) in rows.map_err(|error| refused(self.path, &error))?.into_iter().enumerate() {
            let row = Row { rows: self, row };
            if number >= MOST_ROWS {
                return Err(
                    row.wrong(&format!("there are more than {MOST_ROWS} rows; add up equal tests in a column count"))
                );
            }
            data.begin_row(row.row.line);
            observed.push(if has_onsets {
                row.add_onset(&mut data, brake, steepest)?
            } else {
                row.add_verdict(&mut data, brake)?
            });
            if data.conditions() > MOST_CONDITIONS {
                let remedy = if has_onsets {
                    "give fewer tests"
                } else {
                    "round speeds and preloads, so that more tests are alike"
                };
                return Err(row.wrong(&format!("there are more than {MOST_CONDITIONS} different tests; {remedy}")));
            }
        }
        Ok(BrakeTests { data, observed, has_onsets, steepest })
    }

    /// What is wrong in a line.
    fn wrong(&self, line: u64, message: &str) -> Failure {
        refused(self.path, &self.file.error(line, message))
    }

    /// Checks the first line, and returns whether the tests have onset speeds.
    fn check_names(&self) -> Result<bool, Failure> {
        let has = |name: &str| self.file.place(name).is_some();
        let wrong = |message: String| Err(self.wrong(1, &format!("{message}; {HEADERS}")));
        let names = &self.file.names;
        let (columns, needed): (&[&str], usize) = match (has("onset_speed"), has("rotating_speed")) {
            (true, true) => return wrong("there are both onset_speed and rotating_speed".to_owned()),
            (false, false) if names.iter().all(str::is_empty) => {
                return wrong("the file has no first line with the names of columns".to_owned());
            }
            (false, false) => {
                let there: Vec<String> = names.iter().map(|name| format!("{name:?}")).collect();
                return wrong(format!(
                    "there is no column rotating_speed or onset_speed, and commas or semicolons should separate columns; it has {}",
                    there.join(", ")
                ));
            }
            (true, false) => (&ONSET_COLUMNS, 2),
            (false, true) => (&VERDICT_COLUMNS, 3),
        };
        if let Some(unknown) = names.iter().find(|name| !columns.contains(name)) {
            return wrong(format!("there is a column {unknown:?}"));
        }
        if let Some(missing) = columns[..needed].iter().find(|name| !has(name)) {
            return wrong(format!("there is no column {missing}"));
        }
        if let Some(twice) = self.file.twice() {
            return wrong(format!("two columns are named {twice}"));
        }
        Ok(has("onset_speed"))
    }
}

/// A row of the file.
struct Row<'a> {
    rows: &'a Rows<'a>,
    row: csv_file::Row,
}

impl Row<'_> {
    fn wrong(&self, message: &str) -> Failure {
        self.rows.wrong(self.row.line, message)
    }

    /// The text in a column; `None` without that column.
    fn text(&self, column: &str) -> Option<&str> {
        self.rows.file.place(column).map(|place| self.row.text(place))
    }

    /// A number in a column, which exists, from `least` to `most`.
    fn number(&self, column: &str, least: f64, most: f64, unit: &str) -> Result<f64, Failure> {
        let place = self.rows.file.place(column).unwrap_or(usize::MAX);
        let number = self.row.number(place, column).map_err(|message| self.wrong(&message))?;
        if number >= least && number <= most {
            return Ok(number);
        }
        Err(self.wrong(&format!(
            "{column} = {number} is out of range: it must be at least {least} and at most {most}{unit}"
        )))
    }

    fn speed(&self, column: &str) -> Result<f64, Failure> {
        self.number(column, 1e-6, 1e5, " (rad/s; rpm times 0.10472)")
    }

    fn preload(&self) -> Result<f64, Failure> {
        self.number("preload", 1e-6, 1.0, " (displacement of the calliper over the thickness of the disc)")
    }

    /// A column of 0 and 1.
    fn flag(&self, column: &str) -> Result<Option<bool>, Failure> {
        match self.text(column) {
            None => Ok(None),
            Some("0") => Ok(Some(false)),
            Some("1") => Ok(Some(true)),
            Some(text) => Err(self.wrong(&format!("{text:?} in column {column} is neither 0 (no) nor 1 (yes)"))),
        }
    }

    fn count(&self) -> Result<u64, Failure> {
        let Some(text) = self.text("count") else { return Ok(1) };
        let count = text.parse().ok().filter(|count| (1..=MOST_BRAKES).contains(count));
        count.ok_or_else(|| {
            self.wrong(&format!(
                "{text:?} in column count is not a whole number from 1 to {MOST_BRAKES}; leave out rows without tests"
            ))
        })
    }

    fn add_verdict(&self, data: &mut TestData, brake: &Brake<'_>) -> Result<Observed, Failure> {
        let (speed, preload) = (self.speed("rotating_speed")?, self.preload()?);
        let squealed = self.flag("squealed")?.unwrap_or(false);
        let boundary = brake.boundary(speed).map_err(|error| self.wrong(&error))?;
        let count = self.count()?;
        data.add_verdict(preload, &boundary, squealed, count);
        Ok(Observed { speed, preload, squealed, count })
    }

    fn add_onset(&self, data: &mut TestData, brake: &Brake<'_>, steepest: f64) -> Result<Observed, Failure> {
        let (speed, preload) = (self.speed("onset_speed")?, self.preload()?);
        let boundary = |speed: f64| brake.boundary(speed).map_err(|error| self.wrong(&error));
        if self.flag("censored")?.unwrap_or(false) {
            // A brake that is stable where friction falls most steeply is so at each lower speed.
            data.add_censored(preload, &boundary(speed.max(steepest))?);
            return Ok(Observed { speed, preload, squealed: false, count: 1 });
        }
        let ends = [speed * (1.0 - HALF_WIDTH), speed * (1.0 + HALF_WIDTH)];
        if ends[0] <= steepest {
            return Err(self.wrong(&format!(
                "onset_speed = {speed} is not above {steepest:.6} rad/s, where the friction of the job falls most steeply: a brake that is stable there does not begin to squeal as it slows down further; correct friction.stribeck_exponent or stribeck_velocity of the job, or remove the row"
            )));
        }
        let boundaries = [boundary(ends[0])?, boundary(ends[1])?];
        data.add_onset(preload, boundaries, ends);
        Ok(Observed { speed, preload, squealed: true, count: 1 })
    }
}
