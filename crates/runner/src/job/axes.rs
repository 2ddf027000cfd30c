//! The axes of a job, checked.

use stickslip_core::model::quantity::{Quantity, Role};
use stickslip_sampler::grid::{Axis, Grid, GridAxis};

use super::axes_spec::{AxesSpec, AxisEntry, AxisSpec, RangeSpec, ScaleSpec};
use super::diagnosis::{Complaint, Complaints};
use super::model::Draft;

/// Largest number of cells; their results are held in memory.
pub const MOST_CELLS: u64 = 1_000_000;

/// The axes of a job, each checked alone.
pub struct CheckedAxes {
    /// Each with the place of its quantity, in the order of the quantities. Those that are left out are not among them.
    pub given: Vec<(usize, Axis)>,
    /// Whether none was refused.
    pub are_whole: bool,
}

impl CheckedAxes {
    /// Checks every axis.
    pub fn new(axes: &AxesSpec, draft: &dyn Draft, complaints: &mut Complaints) -> Self {
        let before = complaints.len();
        let is_read = |(_, entry): &(usize, &AxisEntry)| !complaints.has_unread_parameter(entry.name.get_ref());
        let read: Vec<(usize, &AxisEntry)> = axes.0.iter().enumerate().filter(is_read).collect();
        for (i, entry) in read {
            complaints.push_some(unknown(entry, draft).or_else(|| given_twice(entry, &axes.0[..i], draft)));
        }
        let mut given = Vec::new();
        let mut converted = Vec::new();
        for (place, quantity) in draft.quantities().iter().enumerate() {
            let entry = axes.0.iter().find(|entry| draft.place_of_axis(entry.name.get_ref()) == Some(place));
            if draft.converted(place, entry, &[], axes).is_some() {
                converted.push((place, entry));
            } else if let Some(entry) = entry
                && let Some(axis) = complaints.take(checked(entry, place, quantity, draft))
            {
                given.push((place, axis));
            }
        }
        // They may depend on the others.
        for (place, entry) in converted {
            let axis = draft.converted(place, entry, &given, axes).and_then(|axis| complaints.take(axis));
            given.extend(axis.map(|axis| (place, axis)));
        }
        given.sort_by_key(|(place, _)| *place);
        Self { given, are_whole: complaints.len() == before && !complaints.has_unread(&["axes"]) }
    }

    /// The grid of these axes, with expected values of all quantities, and so many entries of scatter.
    ///
    /// What belongs to a configuration varies slowest, then the start; of these, quantities that results always show vary
    /// fastest, then the scatter, then the pair.
    pub fn grid(&self, quantities: &[Quantity], expected: Vec<f64>, scatters: usize) -> Grid {
        let rank = |quantity: &Quantity| match (quantity.role, quantity.is_always_shown) {
            (Role::Configuration, false) => 0,
            (Role::Start, _) => 1,
            (Role::Configuration, true) => 2,
            (Role::Input, _) => 3,
        };
        let mut axes = Vec::new();
        let mut slower_than_scatter = 0;
        for wanted in 0..4 {
            for (quantity, of) in quantities.iter().enumerate().filter(|(_, quantity)| rank(quantity) == wanted) {
                let given = self.given.iter().find(|(place, _)| *place == quantity).map(|(_, axis)| axis.clone());
                let shown = || Axis::from_values(vec![expected[quantity]]).ok().filter(|_| of.is_always_shown);
                axes.extend(given.or_else(shown).map(|axis| GridAxis { quantity, axis }));
            }
            if wanted == 2 {
                slower_than_scatter = axes.len();
            }
        }
        let of_configuration = quantities.iter().map(|quantity| quantity.role == Role::Configuration).collect();
        Grid { expected, axes, scatters, slower_than_scatter, of_configuration }
    }
}

/// A complaint about an axis of something that does not exist.
fn unknown(entry: &AxisEntry, draft: &dyn Draft) -> Option<Complaint> {
    let name = entry.name.get_ref();
    draft.place_of_axis(name).is_none().then(|| Complaint::at(entry.name.span(), draft.unknown_axis(name)))
}

/// A complaint about an axis that one of those `before` is, too.
fn given_twice(entry: &AxisEntry, before: &[AxisEntry], draft: &dyn Draft) -> Option<Complaint> {
    let place = |entry: &AxisEntry| draft.place_of_axis(entry.name.get_ref());
    let other = before.iter().find(|other| place(other).is_some() && place(other) == place(entry))?;
    let message = format!(
        "axes.{} is the same axis as axes.{}; remove one of the two",
        entry.name.get_ref(),
        other.name.get_ref()
    );
    Some(Complaint::at(entry.name.span(), message).and_at(other.name.span()))
}

/// The values of an axis, within the limits of its quantity.
fn checked(entry: &AxisEntry, place: usize, quantity: &Quantity, draft: &dyn Draft) -> Result<Axis, Complaint> {
    let name = entry.name.get_ref();
    let complain = |message: String| Complaint::at(entry.axis.span(), format!("axes.{name}: {message}"));
    let axis = values(entry.axis.get_ref()).map_err(complain)?;
    match axis.values().iter().find(|value| !quantity.limits.contain(**value)) {
        None => Ok(axis),
        Some(&value) => {
            let unit = if quantity.unit == "1" { String::new() } else { format!(" (in {})", quantity.unit) };
            let hint = draft.hint(place, value);
            Err(complain(format!("{value} is out of range: it must be {}{unit}{hint}", quantity.limits)))
        }
    }
}

/// The values of an axis as written.
pub fn values(spec: &AxisSpec) -> Result<Axis, String> {
    let built = match spec {
        AxisSpec::Values(values) => Axis::from_values(values.clone()),
        // Refused before it is filled: a slipped digit must not fill the memory.
        AxisSpec::Range(range) if u64::from(range.points) > MOST_CELLS => {
            return Err(format!("{} points are too many; the limit is {MOST_CELLS}", range.points));
        }
        AxisSpec::Range(RangeSpec { from, to, points, scale }) => match scale {
            ScaleSpec::Linear => Axis::evenly_spaced(*from, *to, *points as usize),
            ScaleSpec::Log => Axis::log_spaced(*from, *to, *points as usize),
        },
    };
    built.map_err(|error| error.to_string())
}
