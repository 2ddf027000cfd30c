//! The axis along which limits are sought, and the combinations of the others.

use stickslip_core::model::quantity::Role;
use stickslip_sampler::grid::{Axis, GridAxis};

use super::keys::nearest;
use super::validated::Job;

/// An axis of a job with at least two values.
#[derive(Debug, Clone)]
pub struct LimitAxis {
    /// Its name in a job.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// What varies along it.
    pub quantity: usize,
    /// Its place among the axes and the scatter, slowest first.
    pub place: usize,
    /// Which quantity of the pair varies along it, if one does.
    pub varied: Option<usize>,
    /// Its values, as the job has them.
    pub values: Vec<f64>,
}

impl LimitAxis {
    /// The axis with a name.
    ///
    /// # Errors
    /// If the job has no such axis, or with one value only: what would be right.
    pub fn named(job: &Job, name: &str) -> Result<Self, String> {
        let axes = Self::all(job);
        let names: Vec<String> =
            axes.iter().filter(|axis| axis.values.len() > 1).map(|axis| axis.name.clone()).collect();
        let several = match &names[..] {
            [] => "it has no axis with two values or more".to_owned(),
            names => format!("its axes with two values or more: {}", names.join(", ")),
        };
        let place = job.model().place(name);
        let Some(axis) = axes.into_iter().find(|axis| Some(axis.quantity) == place) else {
            return Err(match place {
                Some(place) if job.quantity(place).role == Role::Start => format!(
                    "limits are sought along the brake and its operating point, and this is a number of the start (the job \"{}\": {several})",
                    job.name
                ),
                Some(_) => format!(
                    "the job \"{}\" has no such axis ({several}); give it two values or more under [axes], between which the limit is sought",
                    job.name
                ),
                None if ["std", "relative_std"].contains(&name) || name.starts_with("std_") => format!(
                    "limits are sought along expected values, and this is a scatter (the job \"{}\": {several}); to find the largest scatter, compare p_high of each standard deviation in surface.parquet",
                    job.name
                ),
                None => job.model.no_limit_axis(name).unwrap_or_else(|| {
                    let hint = nearest(name, names.iter().map(String::as_str));
                    let hint = hint.map_or(String::new(), |hint| format!("; did you mean {hint}?"));
                    format!("there is no such axis{hint} (the job \"{}\": {several})", job.name)
                }),
            });
        };
        if axis.values.len() < 2 {
            return Err(format!(
                "this axis of the job \"{}\" has one value, {} ({several}); give it two or more under [axes], between which the limit is sought",
                job.name, axis.values[0]
            ));
        }
        Ok(axis)
    }

    /// The axes but those of the start, slowest first.
    fn all(job: &Job) -> Vec<Self> {
        let grid = &job.grid;
        let pair = job.model().pair();
        let axis = |(place, GridAxis { quantity, axis }): (usize, &GridAxis)| {
            let of = job.quantity(*quantity);
            (of.role != Role::Start).then(|| Self {
                name: of.name.to_string(),
                unit: of.unit.to_string(),
                quantity: *quantity,
                place: place + usize::from(place >= grid.slower_than_scatter),
                varied: pair.and_then(|pair| pair.iter().position(|own| own == quantity)),
                values: axis.values().to_vec(),
            })
        };
        grid.axes.iter().enumerate().filter_map(axis).collect()
    }

    /// The smallest and the largest value.
    pub fn range(&self) -> [f64; 2] {
        let values = || self.values.iter().copied();
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// The job with `value` in place of the first value of this axis. The cells of the combinations keep their numbers,
    /// and so their deviates; no other cell has a meaning.
    pub fn job_at(&self, job: &Job, value: f64) -> Job {
        let mut values = vec![value];
        // Values of an axis differ from each other.
        while values.len() < self.values.len() {
            values.push(values[values.len() - 1].next_up());
        }
        self.job_with(job, values)
    }

    /// The job with other values of this axis, which must differ from each other.
    pub fn job_with(&self, job: &Job, values: Vec<f64>) -> Job {
        let mut job = job.clone();
        let own = job.grid.axes.iter_mut().find(|axis| axis.quantity == self.quantity);
        if let (Some(own), Ok(axis)) = (own, Axis::from_values(values)) {
            own.axis = axis;
        }
        job
    }

    /// For every combination of the other axes the cell with the first value of this one.
    pub fn combinations(&self, job: &Job) -> Vec<u64> {
        let lengths = job.grid.lengths();
        let stride: u64 = lengths[self.place + 1..].iter().product();
        let length = lengths[self.place];
        (0..job.cells()).filter(|cell| (cell / stride).is_multiple_of(length)).collect()
    }
}
