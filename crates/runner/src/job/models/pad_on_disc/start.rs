//! Where the motions of a job start, checked: by name, or in numbers, each of which may be an axis or a random input.

use stickslip_core::models::pad_on_disc::motion::start::{GivenStart, Start};
use stickslip_core::models::pad_on_disc::motion::start_value::StartValue;
use toml::Spanned;

use super::corners::start_value_at;
use super::criterion_spec::{CriterionKind, CriterionSpec, DiscKind};
use crate::job::axes_spec::{AxesSpec, AxisEntry};
use crate::job::diagnosis::{Complaint, Complaints};
use crate::job::models::start_spec::StartSpec;
use crate::job::random_spec::RandomSpec;

/// The parts of a job spec that say where motions start.
#[derive(Clone, Copy)]
pub struct StartSpecs<'a> {
    /// The criterion, which has the start itself.
    pub criterion: &'a CriterionSpec,
    /// The axes.
    pub axes: &'a AxesSpec,
    /// The random inputs as written.
    pub random: &'a RandomSpec,
    /// The random inputs, as places of quantities.
    pub inputs: &'a [usize],
}

impl StartSpecs<'_> {
    /// A number of the start that scatters.
    fn random_numbers(&self) -> impl Iterator<Item = StartValue> {
        self.inputs.iter().filter_map(|input| start_value_at(*input))
    }

    /// The first axis of a number of the start.
    pub fn axis_of_start(&self) -> Option<&AxisEntry> {
        self.axes.0.iter().find(|entry| StartValue::from_key(entry.name.get_ref()).is_some())
    }

    /// A complaint about what makes the numbers vary: an axis or a random input, preferably of `number`.
    fn complain(&self, number: Option<StartValue>, message: impl Fn(&str) -> String) -> Option<Complaint> {
        let of_axis = |value: StartValue| self.axes.0.iter().find(|entry| entry.name.get_ref() == value.key());
        let axis = number.map_or_else(|| self.axis_of_start(), of_axis);
        if let Some(entry) = axis {
            return Some(Complaint::at(entry.name.span(), message(&format!("axes.{}", entry.name.get_ref()))));
        }
        let random = self.random_numbers().find(|random| number.is_none_or(|number| number == *random))?;
        let span = self.random.inputs.as_ref().map(Spanned::span);
        Some(Complaint::maybe_at(span, message(&format!("random.inputs \"{}\"", random.key()))))
    }

    /// Checks the start. What is refused is complained about, and left out.
    pub fn checked(&self, kind: CriterionKind, complaints: &mut Complaints) -> Start {
        if kind != CriterionKind::TimeDomain {
            complaints.push_some(self.complain(None, |what| {
                format!("{what}: a start belongs to criterion.kind = \"time-domain\"; remove it, or change the kind")
            }));
            return Start::NearEquilibrium;
        }
        let start = match self.criterion.start.as_ref().map(Spanned::get_ref) {
            Some(StartSpec::Named(start)) => {
                let span = self.criterion.start.as_ref().map(Spanned::span);
                let name = start.name();
                complaints.push_some(self.complain(None, |what| {
                    format!("{what} is a number of a start, but criterion.start = \"{name}\" has none; remove criterion.start, and the motion starts from steady sliding with this number changed, or give the other numbers as start = {{ tangential = ..., velocity = ... }}")
                }).map(|complaint| match span { Some(span) => complaint.and_at(span), None => complaint }));
                return (*start).into();
            }
            Some(StartSpec::Given(given)) => Some(GivenStart::from(given)),
            None if self.axis_of_start().is_some() || self.random_numbers().next().is_some() => {
                Some(GivenStart::default())
            }
            None => None,
        };
        let Some(mut start) = start else { return Start::NearEquilibrium };
        for number in StartValue::ALL {
            let axis = self.axes.0.iter().find(|entry| entry.name.get_ref() == number.key());
            if let (Some(value), Some(entry), Some(spec)) = (number.value_in(&start), axis, &self.criterion.start) {
                let message = format!(
                    "criterion.{} = {value} is given a second time as axes.{}, which has the values that are used; remove one of the two",
                    number.key(),
                    number.key()
                );
                complaints.push(Complaint::at(spec.span(), message).and_at(entry.axis.span()));
            }
            let scatters = self.random_numbers().any(|random| random == number);
            if scatters && axis.is_none() && number.value_in(&start).is_none() {
                if number.is_zero_when_left_out(&start) {
                    number.set(&mut start, 0.0);
                } else {
                    let message = format!(
                        "random.inputs lists \"{key}\", which has no expected value: give criterion.start = {{ {name} = ... }}, or from_equilibrium = true to scatter about steady sliding",
                        key = number.key(),
                        name = number.name()
                    );
                    let span = self.random.inputs.as_ref().map(Spanned::span);
                    complaints.push(Complaint::maybe_at(span, message));
                }
            }
        }
        self.refuse_without_effect(&start, complaints);
        Start::Given(start)
    }

    /// Refuses numbers that have no effect on a rigid disc.
    fn refuse_without_effect(&self, start: &GivenStart, complaints: &mut Complaints) {
        let is_rigid = self.criterion.disc.as_ref().is_some_and(|disc| *disc.get_ref() == DiscKind::Rigid);
        if !is_rigid {
            return;
        }
        for number in [StartValue::Normal, StartValue::Angle] {
            let message = |what: &str| {
                format!(
                    "{what} has no effect with disc = \"rigid\", on which normal motion and rotation do not act on the tangential one; remove it, or use disc = \"flexible\""
                )
            };
            let varies = self.complain(Some(number), message);
            let span = self.criterion.start.as_ref().map(Spanned::span);
            let given = || {
                number
                    .value_in(start)
                    .map(|_| Complaint::maybe_at(span, message(&format!("criterion.{}", number.key()))))
            };
            complaints.push_some(varies.or_else(given));
        }
    }
}
