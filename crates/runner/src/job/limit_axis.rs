//! The axis along which limits are sought, and the combinations of the others.

use stickslip_core::parameters::{Scalar, scalar};
use stickslip_sampler::grid::{Axis, Grid};
use stickslip_sampler::limits::spans::Varied;

use super::keys::{axis_of, nearest, parameter_of_axis};
use super::validated::Job;

/// An axis of a job with at least two values.
#[derive(Debug, Clone)]
pub struct LimitAxis {
    /// Its name in a job.
    pub name: &'static str,
    /// What it has the values of.
    pub scalar: &'static Scalar,
    /// Its place among the axes, slowest first.
    pub place: usize,
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
        let names: Vec<&str> = axes.iter().filter(|axis| axis.values.len() > 1).map(|axis| axis.name).collect();
        let several = match &names[..] {
            [] => "it has no axis with two values or more".to_owned(),
            names => format!("its axes with two values or more: {}", names.join(", ")),
        };
        let key = parameter_of_axis(name).unwrap_or(name);
        let Some(axis) = axes.into_iter().find(|axis| axis.scalar.key == key) else {
            return Err(match scalar(key) {
                Some(_) => format!(
                    "the job \"{}\" has no such axis ({several}); give it two values or more under [axes], between which the limit is sought",
                    job.name
                ),
                None if name.ends_with("preload_force") => {
                    "limits are told as preloads; name the axis preload. Force and preload are proportional".to_owned()
                }
                None => {
                    let hint = nearest(name, names.iter().copied());
                    let hint = hint.map_or(String::new(), |hint| format!("; did you mean {hint}?"));
                    format!("there is no such axis{hint} (the job \"{}\": {several})", job.name)
                }
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

    /// The axes of the brake, of preload and static friction, slowest first.
    fn all(job: &Job) -> Vec<Self> {
        let grid = &job.grid;
        let of_start = grid.of_start.len();
        let of_brake = grid.of_brake.iter().map(|further| (further.name.as_str(), &further.axis)).enumerate();
        let usual = grid.of_brake.len() + of_start;
        // After the rotating speed there are the standard deviations.
        let usual = [
            (usual, ("operating_point.rotating_speed", &grid.rotating_speed)),
            (usual + 2, ("operating_point.preload", &grid.preload)),
            (usual + 3, ("friction.static_coefficient", &grid.static_friction)),
        ];
        let axis = |(place, (key, axis)): (usize, (&str, &Axis))| {
            let scalar = scalar(key)?;
            let name = axis_of(scalar.key).unwrap_or(scalar.key);
            Some(Self { name, scalar, place, values: axis.values().to_vec() })
        };
        of_brake.chain(usual).filter_map(axis).collect()
    }

    /// The smallest and the largest value.
    pub fn range(&self) -> [f64; 2] {
        let values = || self.values.iter().copied();
        [values().fold(f64::INFINITY, f64::min), values().fold(f64::NEG_INFINITY, f64::max)]
    }

    /// Preload or static friction, if the axis is of one of these.
    pub fn varied(&self) -> Option<Varied> {
        match self.scalar.key {
            "operating_point.preload" => Some(Varied::Preload),
            "friction.static_coefficient" => Some(Varied::StaticFriction),
            _ => None,
        }
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
        if let Ok(axis) = Axis::from_values(values) {
            *self.of_grid(&mut job.grid) = axis;
        }
        job
    }

    fn of_grid<'a>(&self, grid: &'a mut Grid) -> &'a mut Axis {
        match self.name {
            "rotating_speed" => &mut grid.rotating_speed,
            "preload" => &mut grid.preload,
            "static_friction" => &mut grid.static_friction,
            _ => &mut grid.of_brake[self.place].axis,
        }
    }

    /// For every combination of the other axes the cell with the first value of this one.
    pub fn combinations(&self, job: &Job) -> Vec<u64> {
        let lengths = job.grid.lengths();
        let stride: u64 = lengths[self.place + 1..].iter().product();
        let length = lengths[self.place];
        (0..job.cells()).filter(|cell| (cell / stride).is_multiple_of(length)).collect()
    }
}
