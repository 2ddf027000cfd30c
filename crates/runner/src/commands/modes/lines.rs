//! The modes of a job over one parameter: those of the expected values joined to lines, and those of samples.

use stickslip_core::model::IsStopped;
use stickslip_core::models::matrices::modes::ModesError;
use stickslip_core::models::matrices::region::{Region, damping_ratio};
use stickslip_core::numerics::eigenvalues::Eigenvalue;
use stickslip_sampler::draw::deviates::Points;
use stickslip_sampler::grid::Cell;

use super::{JobModes, failed};
use crate::evaluate::samples::Drawing;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::job::Job;
use crate::job::keys::nearest;
use crate::output::note;
use crate::picture::scale::Scale;
use crate::picture::title::title;
use crate::picture::view::{rounded, scatter};
use crate::plot::modes::{ModePlot, ModePoint};
use crate::plot::panel::Axis;
use crate::schedule::engine::{Engine, Outcome};

/// Places of a line; of a model whose modes take long.
const PLACES: usize = 241;
const FEW_PLACES: usize = 25;

/// Parts of the way between two places where a mode becomes unstable.
const PARTS: usize = 16;

/// Samples of the cloud at most and at least, and how many of a problem of one state the time is enough for.
const SAMPLES: (f64, f64) = (100.0, 2000.0);
const TIME: f64 = 4e9;

/// Points of the cloud at most.
const MOST_POINTS: usize = 2500;

/// A parameter that is no axis is varied by this share of its value.
const AROUND: f64 = 0.5;

/// Two eigenvalues at neighbouring places are of one mode if they are this near to each other, relative to them.
const NEAR: f64 = 0.05;

/// A mode goes on straight by this many of its last steps at most.
const LONGEST: f64 = 2.0;

/// Where along a parameter modes are drawn.
struct Along {
    /// Its place among the quantities.
    place: usize,
    from: f64,
    to: f64,
    is_logarithmic: bool,
}

/// The picture of the modes of a cell of a job over a parameter.
pub fn along(
    job: &Job,
    cell: &Cell,
    name: Option<&str>,
    threads: usize,
    interrupt: &Interrupt,
) -> Result<ModePlot, Failure> {
    let problem = JobModes::new(job)?;
    let along = Along::new(job, &problem, cell, name)?;
    let regions = problem.regions(&cell.expected);
    let is_large = problem.is_sparse();
    if is_large && !job.random.inputs.is_empty() {
        note(format_args!("modes of so large a model are drawn at the expected values alone, without samples"));
    }
    let engine = Engine::new(threads)?;
    let find = |points: Vec<Vec<f64>>| found(job, &problem, &regions, points, &engine, interrupt);
    let nominal = |share: f64| {
        let mut values = cell.expected.clone();
        values[along.place] = along.value(share);
        values
    };
    let places = if is_large { FEW_PLACES } else { PLACES };
    let mut shares: Vec<f64> = (0..places).map(|i| i as f64 / (places - 1) as f64).collect();
    let mut expected = find(shares.iter().copied().map(nominal).collect())?;
    // Closer where modes become unstable.
    let is_unstable = |value: &Eigenvalue| regions.iter().any(|region| region.contains(*value));
    let count = |found: &Found| found.eigenvalues.iter().filter(|value| is_unstable(value)).count();
    let changes = |i: usize| (1..places).contains(&i) && count(&expected[i - 1]) != count(&expected[i]);
    let changes = (1..places).filter(|&i| !is_large && (changes(i - 1) || changes(i) || changes(i + 1)));
    let between =
        |i: usize| (1..PARTS).map(move |part| (i as f64 - 1.0 + part as f64 / PARTS as f64) / (PLACES - 1) as f64);
    let further: Vec<f64> = changes.flat_map(between).collect();
    expected.extend(find(further.iter().copied().map(nominal).collect())?);
    shares.extend(further);
    let mut expected: Vec<(f64, Found)> = shares.into_iter().zip(expected).collect();
    expected.sort_by(|a, b| a.0.total_cmp(&b.0));
    let cloud = if is_large { Vec::new() } else { find(along.samples(job, &problem, cell))? };
    let point = |at: &Found, value: Eigenvalue| ModePoint {
        value: at.values[along.place],
        frequency: value.im / std::f64::consts::TAU,
        damping_ratio: damping_ratio(value),
        is_unstable: is_unstable(&value),
    };
    let of_line = |line: Line| line.values.iter().map(|(at, value)| point(&expected[*at].1, *value)).collect();
    let places: Vec<(f64, &[Eigenvalue])> =
        expected.iter().map(|(share, found)| (*share, &found.eigenvalues[..])).collect();
    let lines: Vec<Vec<ModePoint>> = followed(&places).into_iter().map(of_line).collect();
    // All modes of some samples, so that none is favoured.
    let every = cloud.iter().map(|at| at.eigenvalues.len()).sum::<usize>().div_ceil(MOST_POINTS).max(1);
    let drawn = cloud.len().div_ceil(every);
    let cloud: Vec<ModePoint> =
        cloud.iter().step_by(every).flat_map(|at| at.eigenvalues.iter().map(move |value| point(at, *value))).collect();
    if lines.is_empty() && cloud.is_empty() {
        return Err(Failure::Job(format!(
            "the job \"{}\" has no mode in its band{} that oscillates, with {} from {} to {}; widen criterion.frequency (Hz)",
            job.name,
            in_words(&regions),
            job.quantity(along.place).name,
            rounded(along.from),
            rounded(along.to)
        )));
    }
    let mut plot = ModePlot {
        along: along.axis(job),
        title: fixed(job, cell, along.place),
        notes: notes(job, cell, along.place, drawn),
        threshold: problem.model.criterion().damping_ratio,
        lines,
        cloud,
    };
    plot.leave_out_damped();
    Ok(plot)
}

/// The values of all quantities at a point, and the eigenvalues there that oscillate; others have no frequency to draw.
#[derive(Clone)]
struct Found {
    values: Vec<f64>,
    eigenvalues: Vec<Eigenvalue>,
}

/// The eigenvalues at these values of all quantities, on all threads.
fn found(
    job: &Job,
    problem: &JobModes<'_>,
    regions: &[Region],
    points: Vec<Vec<f64>>,
    engine: &Engine,
    interrupt: &Interrupt,
) -> Result<Vec<Found>, Failure> {
    let mut found = vec![Ok(Vec::new()); points.len()];
    let modes = |unit: u64, _: IsStopped<'_>| {
        let parameters = problem.parameters(&points[unit as usize]);
        (unit as usize, problem.model.eigenvalues(parameters, regions))
    };
    let outcome = engine.for_each_in_parallel(points.len() as u64, interrupt, modes, |(unit, result)| {
        found[unit] = result;
    })?;
    if let Outcome::Stopped(signal) = outcome {
        return Err(Failure::stopped(signal, &"nothing was written".into()));
    }
    let with_values = |(values, result): (Vec<f64>, Result<Vec<Eigenvalue>, ModesError>)| {
        let mut eigenvalues = result.map_err(|error| failed(job, &error))?;
        eigenvalues.retain(|value| value.im > 0.0);
        Ok(Found { values, eigenvalues })
    };
    points.into_iter().zip(found).map(with_values).collect()
}

fn in_words(regions: &[Region]) -> String {
    let of = |region: &Region| {
        let [low, high] = [region.lowest, region.highest].map(|end| rounded(end / std::f64::consts::TAU));
        format!(" {low} to {high} Hz")
    };
    regions.iter().map(of).collect::<Vec<_>>().join(",")
}

/// What is fixed in the picture.
pub fn fixed(job: &Job, cell: &Cell, but: usize) -> String {
    let quantities = job.model().quantities().iter().enumerate();
    let values = quantities.filter(|(place, _)| *place != but).map(|(place, quantity)| {
        let unit = if quantity.unit == "1" { String::new() } else { format!(" {}", quantity.unit) };
        format!("{} = {}{unit}", quantity.label, rounded(cell.expected[place]))
    });
    values.collect::<Vec<_>>().join(", ")
}

fn notes(job: &Job, cell: &Cell, along: usize, samples: usize) -> Vec<String> {
    if samples == 0 {
        return Vec::new();
    }
    let own = if job.random.position(along).is_some() {
        format!(", without the scatter of {} itself", job.quantity(along).label)
    } else {
        String::new()
    };
    vec![format!("{samples} samples, {}{own}", scatter(job, cell.index))]
}

impl Along {
    /// The parameter of this name, or the longest axis of a job, or that of friction among its random inputs.
    fn new(job: &Job, problem: &JobModes<'_>, cell: &Cell, name: Option<&str>) -> Result<Self, Failure> {
        let parameters = problem.own();
        let place = match name {
            Some(name) => parameters.iter().position(|own| own.name == name).ok_or_else(|| {
                let names = || parameters.iter().map(|own| own.name.as_str());
                let near = nearest(name, names()).map_or(String::new(), |near| format!("; did you mean {near}?"));
                let known = names().collect::<Vec<_>>().join(", ");
                Failure::Usage(format!("--along {name}: there is no parameter {name}{near} (there are {known})"))
            })?,
            None => {
                let axes = job.grid.axes.iter().filter(|axis| axis.quantity < parameters.len());
                let longest = axes.max_by_key(|axis| axis.axis.values().len());
                let longest = longest.filter(|axis| axis.axis.values().len() > 1).map(|axis| axis.quantity);
                let inputs = &job.random.inputs;
                let input = || job.model().integrated(inputs).or_else(|| inputs.first().copied());
                longest.or_else(input).ok_or_else(|| {
                    let first = parameters.first().map_or("NAME", |own| own.name.as_str());
                    Failure::Job(format!(
                        "the job \"{}\" has neither an axis with several values nor a random input; name the parameter to draw modes over, for example --along {first}",
                        job.name
                    ))
                })?
            }
        };
        if let Some(axis) = job.grid.axes.iter().find(|axis| axis.quantity == place)
            && let [from, to] = axis.axis.extremes()
            && from < to
        {
            let is_logarithmic = Scale::for_values(axis.axis.values()).is_logarithmic();
            return Ok(Self { place, from, to, is_logarithmic });
        }
        let value = cell.expected[place];
        let around = if value == 0.0 { 1.0 } else { AROUND * value.abs() };
        let range = parameters[place].range;
        let (from, to) = ((value - around).max(range.minimum), (value + around).min(range.maximum));
        Ok(Self { place, from, to, is_logarithmic: false })
    }

    /// The value at a share of the way.
    fn value(&self, share: f64) -> f64 {
        if self.is_logarithmic {
            self.from * libm::pow(self.to / self.from, share)
        } else {
            self.from + share * (self.to - self.from)
        }
    }

    fn axis(&self, job: &Job) -> Axis {
        let quantity = job.quantity(self.place);
        let unit = if quantity.unit == "1" { String::new() } else { quantity.unit.to_string() };
        let scale = if self.is_logarithmic { Scale::logarithmic } else { Scale::linear };
        Axis { scale: scale(self.from, self.to), title: title(quantity), unit }
    }

    /// Samples of a cell, spread evenly over the range of this parameter, whose own scatter they leave out.
    fn samples(&self, job: &Job, problem: &JobModes<'_>, cell: &Cell) -> Vec<Vec<f64>> {
        let inputs = &job.random.inputs;
        let stds = &job.random.relative_stds[cell.scatter];
        if !inputs.iter().zip(stds).any(|(&input, &std)| input != self.place && std != 0.0) {
            return Vec::new();
        }
        let states = 2.0 * problem.model.matrices().size() as f64;
        let count = (TIME / (states * states * states)).clamp(SAMPLES.0, SAMPLES.1) as usize;
        let mut drawing = Drawing::new(job, cell, 0, 0..count as u64, Points::Random);
        let mut samples = Vec::with_capacity(count);
        while let Some(chunk) = drawing.next_chunk(count) {
            for sample in 0..chunk.len() {
                let mut values = cell.expected.clone();
                inputs.iter().zip(chunk.values(sample)).for_each(|(&input, value)| values[input] = value);
                values[self.place] = self.value((samples.len() as f64 + 0.5) / count as f64);
                samples.push(values);
            }
        }
        let is_inside = |values: &Vec<f64>| {
            let mut own = problem.parameters(values).iter().zip(problem.own());
            own.all(|(value, parameter)| parameter.range.contain(*value))
        };
        samples.retain(is_inside);
        samples
    }
}

/// A mode followed along places: at which of them, and its eigenvalue there.
struct Line {
    values: Vec<(usize, Eigenvalue)>,
}

impl Line {
    /// Where it is at a share of the way if it goes on straight.
    fn next(&self, share: f64, places: &[(f64, &[Eigenvalue])]) -> Eigenvalue {
        match self.values[..] {
            [.., (before, from), (last, to)] => {
                let step = (share - places[last].0) / (places[last].0 - places[before].0);
                // Where modes meet, one turns off its way.
                to + (to - from) * step.min(LONGEST)
            }
            [(_, last)] => last,
            [] => Eigenvalue::default(),
        }
    }
}

fn distance(a: Eigenvalue, b: Eigenvalue) -> f64 {
    libm::hypot(a.re - b.re, a.im - b.im)
}

/// The eigenvalues at successive places, each with its share of the way, joined to lines: each goes on at the one nearest to
/// where it leads, the nearest first.
fn followed(places: &[(f64, &[Eigenvalue])]) -> Vec<Line> {
    let mut ended: Vec<Line> = Vec::new();
    let mut lines: Vec<Line> = Vec::new();
    for (place, (share, values)) in places.iter().enumerate() {
        let mut pairs: Vec<(f64, usize, usize)> = Vec::new();
        for (line, next) in lines.iter().map(|line| line.next(*share, places)).enumerate() {
            let near = values.iter().map(|value| (distance(next, *value), value.im)).enumerate();
            pairs.extend(near.filter(|(_, (apart, im))| *apart <= NEAR * im).map(|(i, (apart, _))| (apart, line, i)));
        }
        pairs.sort_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)));
        let mut joined = vec![None; lines.len()];
        let mut is_taken = vec![false; values.len()];
        for (_, line, i) in pairs {
            if joined[line].is_none() && !is_taken[i] {
                joined[line] = Some(values[i]);
                is_taken[i] = true;
            }
        }
        let mut going = Vec::new();
        for (mut line, value) in std::mem::take(&mut lines).into_iter().zip(joined) {
            if let Some(value) = value {
                line.values.push((place, value));
                going.push(line);
            } else {
                ended.push(line);
            }
        }
        let new = values.iter().zip(&is_taken).filter(|(_, is_taken)| !**is_taken);
        going.extend(new.map(|(value, _)| Line { values: vec![(place, *value)] }));
        lines = going;
    }
    ended.extend(lines);
    ended
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_that_cross_go_on_straight() {
        let values = (0..41).map(|i| {
            // Places that are not even.
            let share = f64::from(i * i) / 1600.0;
            let x = 40.0 * share;
            let mut values = vec![Eigenvalue::new(-1.0, 100.0 + x), Eigenvalue::new(-2.0, 120.5 - x)];
            values.sort_by(|a, b| a.im.total_cmp(&b.im));
            // A third one leaves the band half way.
            if i < 20 {
                values.push(Eigenvalue::new(0.0, 200.0));
            }
            (share, values)
        });
        let values: Vec<(f64, Vec<Eigenvalue>)> = values.collect();
        let places: Vec<(f64, &[Eigenvalue])> = values.iter().map(|(share, values)| (*share, &values[..])).collect();
        let lines = followed(&places);
        assert_eq!(lines.len(), 3);
        for line in &lines {
            assert!(line.values.iter().all(|(_, value)| value.re == line.values[0].1.re), "{:?}", line.values);
        }
        assert_eq!(lines[0].values.len(), 20);
    }
}
