//! The friction oscillator on a belt: a mass on a spring and a damper, which a belt drags along.
//!
//! ```text
//! m x'' + c x' + k x = N mu(V - x')
//! ```
//!
//! with the mass m, the damping c, the stiffness k, the normal force N, the belt speed V, and a friction law mu of the
//! sliding speed ([`friction`](crate::friction)); all in SI units. It sticks while static friction can hold it. Steady
//! sliding is unstable exactly when `-N mu'(V) > c`.
//!
//! This is the tangential equation of the pad on a rigid disc ([`pad_on_disc`](crate::models::pad_on_disc)), which the
//! model is computed by: the stiffness is shared between calliper and contact (halves, which rounding leaves exact), the
//! disc is one whose scales of length, time and speed are 1, and the belt speed that of its edge.

use crate::friction::law::LawKind;
use crate::model::behaviour::Behaviours;
use crate::model::quantity::{Limits, Quantity, Role};
use crate::model::recorded::RecordedResult;
use crate::model::{Configuration, Model, ModelError, SampleQueue, Simulation};
use crate::models::pad_on_disc::criterion::settings::TimeDomainSettings;
use crate::models::pad_on_disc::criterion::time_domain::DiscModel;
use crate::models::pad_on_disc::model::{Criterion, LinearRecord, PadModel};
use crate::models::pad_on_disc::motion::start_value::StartValue;
use crate::models::pad_on_disc::parameters::{Damping, Disc, Friction, OperatingPoint, Pad, Parameters, Stiffness};

use self::configuration::{OnBelt, Queue};

mod configuration;

/// A recorded result of the pad as one of the oscillator. Its values are the same: see [`BeltOscillator::pad`].
fn of_belt(result: &RecordedResult) -> RecordedResult {
    match result.name {
        "amplitude" => RecordedResult { unit: "m", meaning: "half peak to peak of x", ..*result },
        "critical_speed" => RecordedResult {
            unit: "m/s",
            meaning: "highest belt speed at which steady sliding is unstable, 0 if it is stable at every speed",
            ..*result
        },
        "critical_preload" => RecordedResult {
            name: "critical_normal_force",
            unit: "N",
            noun: "critical normal force",
            meaning: "normal force above which steady sliding is unstable",
            ..*result
        },
        _ => *result,
    }
}

/// The values of an oscillator, in SI units.
#[derive(Debug, Clone, PartialEq)]
pub struct Oscillator {
    /// m, kg.
    pub mass: f64,
    /// k, N/m.
    pub stiffness: f64,
    /// c, N s/m.
    pub damping: f64,
    /// N, N.
    pub normal_force: f64,
    /// V, m/s.
    pub belt_speed: f64,
    /// The friction law and its values.
    pub friction: Friction,
}

impl Oscillator {
    /// The pad on a rigid disc that moves in the same way, its displacement in m and its time in s. It is pressed with the
    /// normal force.
    #[must_use]
    pub fn as_pad(&self) -> Parameters {
        if self.normal_force > 0.0 {
            return self.pressed(self.normal_force);
        }
        // Springs have a stiffness, so that nothing is pressed by a preload of 0.
        let pad = self.pressed(1.0);
        Parameters { operating_point: OperatingPoint { preload: 0.0, ..pad.operating_point }, ..pad }
    }

    /// The same with springs that make the preload `1` press with this force.
    fn pressed(&self, force: f64) -> Parameters {
        let half = 0.5 * self.stiffness;
        Parameters {
            disc: Disc {
                density: 1000.0,
                youngs_modulus: 12_000.0,
                poissons_ratio: 0.0,
                thickness: 1.0,
                inner_radius: 0.25,
                outer_radius: 1.0,
                transverse_damping_ratio: 0.0,
            },
            pad: Pad {
                mass: self.mass,
                moment_of_inertia: 1.0,
                inner_radius: 0.5,
                effective_radius: None,
                half_angle: 0.5,
                moment_arm: 0.0,
            },
            stiffness: Stiffness {
                calliper_tangential: half,
                calliper_normal: 2.0 * force,
                calliper_angular: 1.0,
                contact_normal: 2.0 * force,
                contact_tangential_1: half,
                contact_tangential_2: half,
            },
            damping: Damping { tangential: self.damping, normal: 1.0, angular: 1.0 },
            friction: self.friction.clone(),
            operating_point: OperatingPoint { preload: 1.0, rotating_speed: self.belt_speed },
        }
    }
}

/// What decides.
#[derive(Debug, Clone, Copy)]
pub enum BeltCriterion {
    /// The eigenvalues of steady sliding, in closed form.
    Eigenvalue {
        /// What is recorded of samples.
        record: LinearRecord,
    },
    /// The motion itself.
    TimeDomain(TimeDomainSettings),
}

/// The friction oscillator on a belt with a criterion.
#[derive(Debug, Clone)]
pub struct BeltOscillator {
    oscillator: Oscillator,
    /// The pad that moves in the same way; preload 1 presses with 1 N, so that its preload is the normal force.
    pad: PadModel,
    quantities: Vec<Quantity>,
    recorded: Vec<RecordedResult>,
}

/// A quantity of the oscillator: its name, symbol, unit and meaning, and the parameters of the pad that follow it, each
/// with the factor by which it does.
struct Entry {
    name: &'static str,
    symbol: &'static str,
    unit: &'static str,
    description: &'static str,
    limits: Limits,
    pad: &'static [(&'static str, f64)],
}

const HALF: f64 = 0.5;

/// All quantities but those of the start: the pair first.
#[rustfmt::skip]
const ENTRIES: [Entry; 10] = [
    Entry { name: "normal_force", symbol: "N", unit: "N", description: "normal force", limits: Limits::from(0.0, 1e12), pad: &[("operating_point.preload", 1.0)] },
    Entry { name: "static_coefficient", symbol: "f_s", unit: "1", description: "static friction coefficient", limits: Limits::from(0.0, 5.0), pad: &[("friction.static_coefficient", 1.0)] },
    Entry { name: "mass", symbol: "m", unit: "kg", description: "mass", limits: Limits::above(0.0, 1e3), pad: &[("pad.mass", 1.0)] },
    Entry { name: "stiffness", symbol: "k", unit: "N/m", description: "stiffness of the spring", limits: Limits::above(0.0, 1e13), pad: &[("stiffness.calliper_tangential", HALF), ("stiffness.contact_tangential_1", HALF), ("stiffness.contact_tangential_2", HALF)] },
    Entry { name: "damping", symbol: "c", unit: "N s/m", description: "damping", limits: Limits::from(0.0, 1e9), pad: &[("damping.tangential", 1.0)] },
    Entry { name: "kinetic_coefficient", symbol: "f_c", unit: "1", description: "kinetic friction coefficient", limits: Limits::from(0.0, 5.0), pad: &[("friction.kinetic_coefficient", 1.0)] },
    Entry { name: "stribeck_velocity", symbol: "v_s", unit: "m/s", description: "Stribeck velocity", limits: Limits::above(0.0, 1e3), pad: &[("friction.stribeck_velocity", 1.0)] },
    Entry { name: "stribeck_exponent", symbol: "delta", unit: "1", description: "Stribeck exponent, 1 = Tustin", limits: Limits::above(0.0, 10.0), pad: &[("friction.stribeck_exponent", 1.0)] },
    Entry { name: "viscous", symbol: "k_v", unit: "s/m", description: "viscous friction, coefficient for each m/s", limits: Limits::from(0.0, 100.0), pad: &[("friction.viscous", 1.0)] },
    Entry { name: "band", symbol: "z", unit: "1", description: "shift of a measured friction curve in its standard deviations", limits: Limits::from(-10.0, 10.0), pad: &[("friction.band", 1.0)] },
];

/// The belt speed, which results always show.
const BELT_SPEED: Entry = Entry {
    name: "belt_speed",
    symbol: "V",
    unit: "m/s",
    description: "speed of the belt",
    limits: Limits::from(1e-6, 1e5),
    pad: &[("operating_point.rotating_speed", 1.0)],
};

/// The numbers of a start that an oscillator has, with their names.
const STARTS: [(StartValue, &str, &str); 2] = [
    (StartValue::Tangential, "start.displacement", "displacement at the start"),
    (StartValue::Velocity, "start.velocity", "speed at the start"),
];

/// All entries in the order of the quantities.
fn entries() -> impl Iterator<Item = &'static Entry> {
    ENTRIES.iter().chain([&BELT_SPEED])
}

/// The quantities of an oscillator.
#[must_use]
pub fn quantities() -> Vec<Quantity> {
    let of = |entry: &Entry| {
        let is_pair = ["normal_force", "static_coefficient"].contains(&entry.name);
        let is_of_friction = entry.pad[0].0.starts_with("friction.");
        let path = if is_of_friction { entry.pad[0].0 } else { entry.name };
        Quantity {
            path: path.into(),
            label: entry.name.replace('_', " ").into(),
            symbol: entry.symbol.into(),
            limits: entry.limits,
            role: if is_pair { Role::Input } else { Role::Configuration },
            is_always_shown: is_pair || entry.name == "belt_speed",
            scatters_absolutely: entry.name == "band",
            ..Quantity::new(entry.name, entry.unit, entry.description)
        }
    };
    let starts = STARTS.iter().map(|(number, name, description)| Quantity {
        role: Role::Start,
        scatters_absolutely: true,
        is_rate: *number == StartValue::Velocity,
        ..Quantity::new(*name, number.unit(Default::default()), *description)
    });
    entries().map(of).chain(starts).collect()
}

impl Default for BeltCriterion {
    fn default() -> Self {
        Self::Eigenvalue { record: LinearRecord::default() }
    }
}

impl BeltOscillator {
    /// An oscillator, of which the expected values of the quantities replace those given here.
    #[must_use]
    pub fn new(oscillator: Oscillator, criterion: BeltCriterion) -> Self {
        let criterion = match criterion {
            BeltCriterion::Eigenvalue { record } => Criterion::Eigenvalue { record: record.tangential() },
            BeltCriterion::TimeDomain(settings) => Criterion::TimeDomain { disc: DiscModel::Rigid, settings },
        };
        let pad = PadModel::new(oscillator.pressed(1.0), criterion);
        let recorded = pad.recorded().iter().map(of_belt).collect();
        Self { oscillator, pad, quantities: quantities(), recorded }
    }

    /// The oscillator with these expected values of all quantities.
    #[must_use]
    pub fn oscillator(&self, expected: &[f64]) -> Oscillator {
        let value = |name: &str| self.place(name).map_or(f64::NAN, |place| expected[place]);
        let friction = &self.oscillator.friction;
        Oscillator {
            mass: value("mass"),
            stiffness: value("stiffness"),
            damping: value("damping"),
            normal_force: value("normal_force"),
            belt_speed: value("belt_speed"),
            friction: Friction {
                law: friction.law,
                static_coefficient: value("static_coefficient"),
                kinetic_coefficient: value("kinetic_coefficient"),
                stribeck_velocity: value("stribeck_velocity"),
                stribeck_exponent: value("stribeck_exponent"),
                viscous: value("viscous"),
                band: value("band"),
            },
        }
    }

    /// The criterion, as that of the pad.
    #[must_use]
    pub fn criterion(&self) -> &Criterion {
        self.pad.criterion()
    }

    /// The expected values of all quantities, where nothing else is said.
    #[must_use]
    pub fn expected(&self) -> Vec<f64> {
        let Oscillator { mass, stiffness, damping, normal_force, belt_speed, friction } = &self.oscillator;
        let of = |entry: &Entry| match entry.name {
            "normal_force" => *normal_force,
            "mass" => *mass,
            "stiffness" => *stiffness,
            "damping" => *damping,
            "belt_speed" => *belt_speed,
            "static_coefficient" => friction.static_coefficient,
            "kinetic_coefficient" => friction.kinetic_coefficient,
            "stribeck_velocity" => friction.stribeck_velocity,
            "stribeck_exponent" => friction.stribeck_exponent,
            "viscous" => friction.viscous,
            _ => friction.band,
        };
        let start = self.pad.criterion().given_start().unwrap_or_default();
        let starts = STARTS.iter().map(|(number, ..)| number.value_in(&start).unwrap_or(f64::NAN));
        entries().map(of).chain(starts).collect()
    }

    /// The expected values of the pad's quantities.
    fn of_pad(&self, expected: &[f64]) -> Vec<f64> {
        let mut of_pad = self.pad.expected();
        for (place, value) in expected.iter().enumerate() {
            for (own, factor) in self.followers(place) {
                of_pad[own] = factor * value;
            }
        }
        of_pad
    }

    /// The quantities of the pad that follow one of the oscillator, each with its factor.
    fn followers(&self, place: usize) -> Vec<(usize, f64)> {
        let of_start = || {
            let (number, ..) = STARTS.get(place.checked_sub(ENTRIES.len() + 1)?)?;
            Some(vec![(self.pad.place(number.key())?, 1.0)])
        };
        match entries().nth(place) {
            Some(entry) => {
                let follower = |(key, factor): &(&str, f64)| Some((self.pad.place(key)?, *factor));
                entry.pad.iter().filter_map(follower).collect()
            }
            None => of_start().unwrap_or_default(),
        }
    }

    /// For the pad's varying quantities, of which the first two are the pair: the column of the oscillator that each
    /// follows, with its factor.
    fn columns(&self, varying: &[usize]) -> (Vec<usize>, Vec<(usize, f64)>) {
        let followers = varying.iter().enumerate().flat_map(|(column, place)| {
            self.followers(*place).into_iter().map(move |(own, factor)| (own, (column, factor)))
        });
        followers.unzip()
    }
}

impl Model for BeltOscillator {
    fn quantities(&self) -> &[Quantity] {
        &self.quantities
    }

    fn configure(
        &self,
        expected: &[f64],
        varying: &[usize],
        like: Option<&dyn Configuration>,
    ) -> Result<Box<dyn Configuration>, ModelError> {
        let (of_pad, columns) = self.columns(varying);
        let like = like.and_then(OnBelt::from_any).map(|like| &*like.pad);
        let pad = self.pad.configure(&self.of_pad(expected), &of_pad, like).map_err(|error| self.reworded(&error))?;
        Ok(Box::new(OnBelt { pad: pad.into(), columns }))
    }

    fn length_scale(&self, _: &[f64]) -> Option<f64> {
        Some(1.0)
    }

    fn recorded(&self) -> &[RecordedResult] {
        &self.recorded
    }

    fn has_closed_form(&self) -> bool {
        self.pad.has_closed_form()
    }

    fn simulation(&self) -> Option<&dyn Simulation> {
        self.pad.simulation().is_some().then_some(self)
    }

    fn outside_meaning(&self) -> &'static str {
        match self.oscillator.friction.law {
            LawKind::Table(_) => "normal force at or below 0, or a friction coefficient at or below 0",
            LawKind::Stribeck | LawKind::Rational => "normal force at or below 0, or f_s < f_c",
        }
    }

    fn verdict_names(&self) -> [&'static str; 2] {
        self.pad.verdict_names()
    }

    fn behaviours(&self) -> Option<Behaviours<'_>> {
        let criterion = self.criterion().clone();
        Some(Box::new(move |expected| {
            let oscillator = self.oscillator(expected);
            let pad = PadModel::new(oscillator.as_pad(), criterion.clone());
            let mut behaviours = pad.behaviours()?;
            behaviours(&pad.expected())
        }))
    }
}

impl Simulation for BeltOscillator {
    fn outline(&self, expected: &[f64], varying: &[usize]) -> Result<Box<dyn Configuration>, ModelError> {
        let (of_pad, columns) = self.columns(varying);
        let pad = Simulation::outline(&self.pad, &self.of_pad(expected), &of_pad)?;
        Ok(Box::new(OnBelt { pad: pad.into(), columns }))
    }

    fn run<'q>(&self, queue: &mut dyn SampleQueue<'q>) {
        self.pad.run(&mut Queue::new(queue));
    }
}

impl BeltOscillator {
    /// An error of the pad in the words of the oscillator.
    fn reworded(&self, error: &ModelError) -> ModelError {
        let mut text = error.0.clone();
        for entry in entries().filter(|entry| entry.pad.len() == 1) {
            text = text.replace(entry.pad[0].0, entry.name);
        }
        ModelError(text)
    }
}

#[cfg(test)]
mod tests;
