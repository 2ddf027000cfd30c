//! The operating point that is asked about: one cell of the grid, by the values of its axes.

use stickslip_sampler::grid::GridAxis;
use toml::Spanned;

use super::diagnosis::Complaint;
use super::keys::nearest;
use super::target_spec::TargetSpec;
use super::validated::Job;
use crate::failure::Failure;

/// Which of some values of axes is refused, if it is one of them, and why.
type Refused = (Option<usize>, String);

/// The cell of the operating point of a table `[target]`, if it has one.
///
/// # Errors
/// Values that are no cell of the job, or more than one.
pub fn operating_point(spec: Option<&Spanned<TargetSpec>>, job: &Job) -> Result<Option<u64>, Complaint> {
    let Some(at) = spec.and_then(|spec| spec.get_ref().at.as_ref()) else { return Ok(None) };
    let entries: Vec<(&str, &Spanned<f64>)> =
        at.get_ref().iter().map(|(name, value)| (name.get_ref().as_str(), value)).collect();
    let values: Vec<(&str, f64)> = entries.iter().map(|(name, value)| (*name, *value.get_ref())).collect();
    job.cell_at(&values).map(Some).map_err(|(entry, why)| {
        let span = entry.map_or_else(|| at.span(), |entry| entries[entry].1.span());
        Complaint::at(span, format!("target.at: {why}"))
    })
}

impl Job {
    /// The cell that is asked about: the operating point, or the only one.
    pub fn asked_cell(&self) -> Option<u64> {
        self.operating_point.or((self.cells() == 1).then_some(0))
    }

    /// Where the cell lies that is shown if none is asked for, in words.
    pub fn place_of_shown_cell(&self) -> &'static str {
        if self.operating_point.is_some() { "the operating point" } else { "the middle of the axes" }
    }

    /// The same job asked about another target and another operating point, where these are given.
    ///
    /// # Errors
    /// Values that are no cell of the job, or more than one.
    pub fn asked(self, target: Option<f64>, at: &[(String, f64)]) -> Result<Self, Failure> {
        let values: Vec<(&str, f64)> = at.iter().map(|(name, value)| (name.as_str(), *value)).collect();
        let operating_point = match values[..] {
            [] => self.operating_point,
            _ => Some(self.cell_at(&values).map_err(|(_, why)| Failure::Usage(format!("--at: {why}")))?),
        };
        Ok(Self { target: target.or(self.target), operating_point, ..self })
    }

    /// The cell with these values on its axes; those of one value need not be among them.
    fn cell_at(&self, values: &[(&str, f64)]) -> Result<u64, Refused> {
        let axes = self.axes_and_scatter();
        let long = || axes.iter().filter(|(_, on_axis)| on_axis.len() > 1).map(|(name, _)| name.as_str());
        for (entry, (name, _)) in values.iter().enumerate() {
            if axes.iter().all(|(axis, _)| axis != name) {
                let hint = nearest(name, long()).map_or_else(String::new, |hint| format!("; did you mean {hint}?"));
                let long: Vec<&str> = long().collect();
                let has = if long.is_empty() { "none of several values".to_owned() } else { long.join(", ") };
                return Err((Some(entry), format!("{name} is no axis of the job, which has {has}{hint}")));
            }
            if let Some((_, other)) = values[..entry].iter().find(|(earlier, _)| earlier == name) {
                let value = values[entry].1;
                let why = format!("{name} is given twice, as {other} and as {value}; give one value of each axis");
                return Err((Some(entry), why));
            }
        }
        let mut cell = 0;
        for (name, on_axis) in &axes {
            let given = values.iter().position(|(axis, _)| axis == name);
            let place = match given {
                Some(entry) => {
                    let wanted = values[entry].1;
                    let is_it = |of: &f64| (of - wanted).abs() <= 1e-9 * wanted.abs();
                    on_axis.iter().position(is_it).ok_or_else(|| {
                        let nearest = on_axis.iter().min_by(|a, b| (*a - wanted).abs().total_cmp(&(*b - wanted).abs()));
                        let nearest = nearest.map_or_else(String::new, |nearest| format!("; the nearest is {nearest}"));
                        (Some(entry), format!("{name} has no value {wanted} on the grid{nearest}"))
                    })?
                }
                None if on_axis.len() == 1 => 0,
                None => {
                    let example = on_axis[(on_axis.len() - 1) / 2];
                    let why = format!(
                        "{name} is missing, which has {} values; give one of them, for example {example}, so that one cell is meant",
                        on_axis.len()
                    );
                    return Err((None, why));
                }
            };
            cell = cell * on_axis.len() as u64 + place as u64;
        }
        Ok(cell)
    }

    /// The values of a cell on its axes, slowest first, with which it is asked about; that of scatter only where it
    /// varies.
    pub fn point(&self, cell: u64) -> Vec<(String, f64)> {
        let mut point = Vec::new();
        let mut left = cell;
        for (name, on_axis) in self.axes_and_scatter().into_iter().rev() {
            let length = on_axis.len() as u64;
            if length > 1 || name != "relative_std" {
                point.push((name, on_axis[(left % length) as usize]));
            }
            left /= length;
        }
        point.reverse();
        point
    }

    /// The names of all axes with their values, slowest first. That of scatter has the values of the first input in
    /// which these differ.
    fn axes_and_scatter(&self) -> Vec<(String, Vec<f64>)> {
        let of_grid = |axis: &GridAxis| (self.quantity(axis.quantity).name.to_string(), axis.axis.values().to_vec());
        let mut axes: Vec<(String, Vec<f64>)> = self.grid.axes.iter().map(of_grid).collect();
        let input = self.random.first_varied();
        let stds = self.random.relative_stds.iter().map(|entry| input.map_or(0.0, |input| entry[input]));
        axes.insert(self.grid.slower_than_scatter, ("relative_std".to_owned(), stds.collect()));
        axes
    }
}

#[cfg(test)]
mod tests {
    use crate::job::{Job, JobSource};

    const JOB: &str = "name = \"point\"\n[axes]\nrotating_speed = [10, 15]\npreload = 0.1\nstatic_friction = { from = 0.3, to = 0.5, points = 5 }\n[random]\ninputs = [\"preload\"]\nrelative_std = [0.1, 0.2]\n[criterion]\nkind = \"eigenvalue\"\n[sampling]\nsamples = 10\nseed = 1\n";

    fn job(at: &str) -> Result<Job, String> {
        let text = format!("{JOB}[target]\nprobability = 0.05\n{at}\n");
        JobSource { path: "job.toml".into(), text }.job().map_err(|failure| failure.to_string())
    }

    #[test]
    fn a_point_is_a_cell() {
        assert_eq!(job("").unwrap().asked_cell(), None);
        let cell = |at: &str| job(at).unwrap().asked_cell().unwrap();
        let all = job("").unwrap();
        for index in 0..all.cells() {
            let of = all.grid.cell(index);
            let value = |name: &str| of.expected[all.model().place(name).unwrap()];
            let std = [0.1, 0.2][of.scatter];
            let (speed, friction) = (value("rotating_speed"), value("static_friction"));
            let at = format!("rotating_speed = {speed}, static_friction = {friction}, relative_std = {std}");
            assert_eq!(cell(&format!("at = {{ {at} }}")), index);
            assert_eq!(cell(&format!("at = {{ preload = 0.1, {at} }}")), index);
            let given = [("rotating_speed", speed), ("static_friction", friction), ("relative_std", std)];
            let given = given.map(|(name, value)| (name.to_owned(), value));
            let asked = all.clone().asked(Some(0.1), &given).unwrap();
            assert_eq!((asked.asked_cell(), asked.target), (Some(index), Some(0.1)));
            assert_eq!(all.clone().asked(None, &all.point(index)).unwrap().asked_cell(), Some(index));
        }
    }

    #[test]
    fn what_is_no_cell_is_refused_with_what_there_is() {
        for (at, why) in [
            (
                "at = { rotating_speed = 15 }",
                "target.at: relative_std is missing, which has 2 values; give one of them, for example 0.1, so that one cell is meant",
            ),
            (
                "at = { rotating_sped = 15 }",
                "target.at: rotating_sped is no axis of the job, which has rotating_speed, relative_std, static_friction; did you mean rotating_speed?",
            ),
            (
                "at = { rotating_speed = 13 }",
                "target.at: rotating_speed has no value 13 on the grid; the nearest is 15",
            ),
        ] {
            let refused = job(at).unwrap_err();
            assert!(refused.contains(why), "{refused}");
        }
        let at = [("rotating_speed", 15.0), ("relative_std", 0.1), ("static_friction", 0.3), ("preload", 0.2)];
        let at = at.map(|(name, value)| (name.to_owned(), value));
        let refused = job("").unwrap().asked(None, &at).unwrap_err();
        assert_eq!(refused.to_string(), "--at: preload has no value 0.2 on the grid; the nearest is 0.1");
        let twice =
            [("rotating_speed", 10.0), ("relative_std", 0.1), ("static_friction", 0.3), ("rotating_speed", 15.0)];
        let twice = twice.map(|(name, value)| (name.to_owned(), value));
        let refused = job("").unwrap().asked(None, &twice).unwrap_err();
        assert_eq!(
            refused.to_string(),
            "--at: rotating_speed is given twice, as 10 and as 15; give one value of each axis"
        );
    }
}
