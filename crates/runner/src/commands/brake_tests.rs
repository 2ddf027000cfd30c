//! Tests of brakes from a CSV file, for `fit`.

use std::path::Path;

use csv::{ReaderBuilder, StringRecord, Trim};
use stickslip_core::model::pair_boundary::PairBoundary;
use stickslip_core::models::pad_on_disc::parameters::Parameters;
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::PadOnDisc;
use stickslip_sampler::fit::TestData;

use crate::failure::Failure;
use crate::job::{read_csv, unreadable};
use crate::messages::Place;
use crate::output::shown;

/// Most rows that are read.
const MOST_ROWS: u64 = 100_000;

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

/// What the tests say, and of which kind they are.
pub struct BrakeTests {
    /// The tests with their boundaries.
    pub data: TestData,
    /// Whether each has an onset speed.
    pub has_onsets: bool,
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

/// The rows of a file, with what a message about one says first.
struct Rows<'a> {
    path: &'a Path,
    names: StringRecord,
}

/// Reads tests of a brake from a file.
///
/// # Errors
/// A file that cannot be read, and a row that cannot be right, with line, column, value and remedy.
pub fn read_tests(path: &Path, brake: &PadOnDisc) -> Result<BrakeTests, Failure> {
    let bytes = read_csv(path).map_err(|why| Failure::InputOutput(why).at(Place::file(path)))?;
    let brake = Brake { parameters: brake.parameters(), steepest: brake.steepest_speed() };
    read(path, &bytes, &brake)
}

fn read(path: &Path, bytes: &[u8], brake: &Brake<'_>) -> Result<BrakeTests, Failure> {
    let mut reader = ReaderBuilder::new().trim(Trim::All).from_reader(bytes);
    let names = reader.headers().map_err(|error| Failure::Job(unreadable(path, &error)).at(Place::file(path)))?.clone();
    let rows = Rows { path, names };
    let has_onsets = rows.check_names()?;
    let steepest = match (has_onsets, brake.steepest) {
        (true, None) => {
            let why = "onset speeds cannot be used with friction.law = \"table\", whose curve may fall in several places; give verdicts: the columns rotating_speed, preload, squealed";
            return Err(refused(path, 1, why));
        }
        (_, steepest) => steepest.unwrap_or(0.0),
    };
    let mut data = TestData::default();
    for (number, record) in (1..).zip(reader.records()) {
        let record = record.map_err(|error| Failure::Job(unreadable(path, &error)).at(Place::file(path)))?;
        let row = Row { rows: &rows, line: line_of(&record, bytes), record: &record };
        if number > MOST_ROWS {
            return Err(
                row.wrong(&format!("there are more than {MOST_ROWS} rows; add up equal tests in a column count"))
            );
        }
        data.begin_row(row.line);
        if has_onsets {
            row.add_onset(&mut data, brake, steepest)?;
        } else {
            row.add_verdict(&mut data, brake)?;
        }
        if data.conditions() > MOST_CONDITIONS {
            let remedy =
                if has_onsets { "give fewer tests" } else { "round speeds and preloads, so that more tests are alike" };
            return Err(row.wrong(&format!("there are more than {MOST_CONDITIONS} different tests; {remedy}")));
        }
    }
    Ok(BrakeTests { data, has_onsets })
}

/// What is wrong in a line of the file.
fn refused(path: &Path, line: u64, message: &str) -> Failure {
    Failure::Job(format!("{}:{line}: {message}", shown(path))).at(Place::line(path, line))
}

/// The line of a record, whose position is before the empty lines that it follows.
fn line_of(record: &StringRecord, bytes: &[u8]) -> u64 {
    record.position().map_or(0, |position| {
        let rest = bytes.get(position.byte() as usize..).unwrap_or_default();
        let empty = rest.iter().take_while(|byte| byte.is_ascii_whitespace()).filter(|byte| **byte == b'\n').count();
        position.line() + empty as u64
    })
}

impl Rows<'_> {
    /// Checks the first line, and returns whether the tests have onset speeds.
    fn check_names(&self) -> Result<bool, Failure> {
        let has = |name: &str| self.place(name).is_some();
        let wrong = |message: String| Err(refused(self.path, 1, &format!("{message}; {HEADERS}")));
        let (columns, needed): (&[&str], usize) = match (has("onset_speed"), has("rotating_speed")) {
            (true, true) => return wrong("there are both onset_speed and rotating_speed".to_owned()),
            (false, false) if self.names.iter().all(str::is_empty) => {
                return wrong("the file has no first line with the names of columns".to_owned());
            }
            (false, false) => {
                let there: Vec<String> = self.names.iter().map(|name| format!("{name:?}")).collect();
                return wrong(format!(
                    "there is no column rotating_speed or onset_speed, and commas should separate columns; it has {}",
                    there.join(", ")
                ));
            }
            (true, false) => (&ONSET_COLUMNS, 2),
            (false, true) => (&VERDICT_COLUMNS, 3),
        };
        if let Some(unknown) = self.names.iter().find(|name| !columns.contains(name)) {
            return wrong(format!("there is a column {unknown:?}"));
        }
        if let Some(missing) = columns[..needed].iter().find(|name| !has(name)) {
            return wrong(format!("there is no column {missing}"));
        }
        let is_twice = |name: &&&str| self.names.iter().filter(|other| other == *name).count() > 1;
        if let Some(twice) = columns.iter().find(is_twice) {
            return wrong(format!("two columns are named {twice}"));
        }
        Ok(has("onset_speed"))
    }

    fn place(&self, name: &str) -> Option<usize> {
        self.names.iter().position(|other| other == name)
    }
}

/// A row of the file.
struct Row<'a> {
    rows: &'a Rows<'a>,
    line: u64,
    record: &'a StringRecord,
}

impl Row<'_> {
    fn wrong(&self, message: &str) -> Failure {
        refused(self.rows.path, self.line, message)
    }

    /// The text in a column; `None` without that column.
    fn text(&self, column: &str) -> Option<&str> {
        self.record.get(self.rows.place(column)?)
    }

    /// A number in a column, from `least` to `most`.
    fn number(&self, column: &str, least: f64, most: f64, unit: &str) -> Result<f64, Failure> {
        let text = self.text(column).unwrap_or_default();
        let number = text.parse::<f64>().ok().filter(|number| number.is_finite());
        let Some(number) = number else {
            return Err(self.wrong(&format!("{text:?} in column {column} is not a number, such as 0.1 or 1.5e1")));
        };
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

    fn add_verdict(&self, data: &mut TestData, brake: &Brake<'_>) -> Result<(), Failure> {
        let (speed, preload) = (self.speed("rotating_speed")?, self.preload()?);
        let squealed = self.flag("squealed")?.unwrap_or(false);
        let boundary = brake.boundary(speed).map_err(|error| self.wrong(&error))?;
        data.add_verdict(preload, &boundary, squealed, self.count()?);
        Ok(())
    }

    fn add_onset(&self, data: &mut TestData, brake: &Brake<'_>, steepest: f64) -> Result<(), Failure> {
        let (speed, preload) = (self.speed("onset_speed")?, self.preload()?);
        let boundary = |speed: f64| brake.boundary(speed).map_err(|error| self.wrong(&error));
        if self.flag("censored")?.unwrap_or(false) {
            // A brake that is stable where friction falls most steeply is so at each lower speed.
            data.add_verdict(preload, &boundary(speed.max(steepest))?, false, 1);
            return Ok(());
        }
        let ends = [speed * (1.0 - HALF_WIDTH), speed * (1.0 + HALF_WIDTH)];
        if ends[0] <= steepest {
            return Err(self.wrong(&format!(
                "onset_speed = {speed} is not above {steepest:.6} rad/s, where the friction of the job falls most steeply: a brake that is stable there does not begin to squeal as it slows down further; correct friction.stribeck_exponent or stribeck_velocity of the job, or remove the row"
            )));
        }
        let boundaries = [boundary(ends[0])?, boundary(ends[1])?];
        data.add_onset(preload, boundaries, ends);
        Ok(())
    }
}
