//! The quantities of the pad on the disc, and their places.

use crate::model::ModelError;
use crate::model::quantity::{Quantity, Role};
use crate::models::pad_on_disc::motion::start::GivenStart;
use crate::models::pad_on_disc::motion::start_value::StartValue;
use crate::models::pad_on_disc::parameters::{SCALARS, Scalar};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::RandomInputs;

/// Places of the pair in the list of quantities.
pub const PRELOAD: usize = 0;
/// See [`PRELOAD`].
pub const STATIC_FRICTION: usize = 1;
/// The place of the rotating speed: of the parameters it is the last.
pub const ROTATING_SPEED: usize = SCALARS.len() - 1;

/// The pair among values of all quantities.
#[must_use]
pub fn inputs(values: &[f64]) -> RandomInputs {
    RandomInputs { preload: values[PRELOAD], static_friction: values[STATIC_FRICTION] }
}

/// The parameters that belong to a configuration, in the order of the quantities: all but the pair.
pub fn configuration_scalars() -> impl Iterator<Item = &'static Scalar> {
    SCALARS.iter().filter(|scalar| scalar.key != PRELOAD_KEY && scalar.key != STATIC_FRICTION_KEY)
}

/// Keys of the pair.
pub const PRELOAD_KEY: &str = "operating_point.preload";
/// See [`PRELOAD_KEY`].
pub const STATIC_FRICTION_KEY: &str = "friction.static_coefficient";
const ROTATING_SPEED_KEY: &str = "operating_point.rotating_speed";

/// The place of the first number of the start in the list of quantities.
#[must_use]
pub fn first_of_start() -> usize {
    SCALARS.len()
}

/// The quantities: preload and static friction coefficient, the other parameters, the numbers of a start.
#[must_use]
pub fn quantities(start: &GivenStart) -> Vec<Quantity> {
    let pair = [PRELOAD_KEY, STATIC_FRICTION_KEY].into_iter().filter_map(|key| SCALARS.iter().find(|s| s.key == key));
    let parameters = pair.chain(configuration_scalars()).map(|scalar| {
        let quantity = Quantity {
            symbol: scalar.symbol.into(),
            limits: scalar.limits,
            // The shift of a measured curve counts standard deviations itself.
            scatters_absolutely: scalar.key == "friction.band",
            ..Quantity::new(scalar.key, scalar.unit, scalar.description)
        };
        let shown = |name: &'static str, column: &'static str, label: &'static str, role: Role| Quantity {
            name: name.into(),
            column: column.into(),
            label: label.into(),
            role,
            is_always_shown: true,
            ..quantity.clone()
        };
        match scalar.key {
            PRELOAD_KEY => Quantity { is_over_length: true, ..shown("preload", "preload", "preload", Role::Input) },
            STATIC_FRICTION_KEY => shown("static_friction", "static_friction", "static friction", Role::Input),
            ROTATING_SPEED_KEY => Quantity {
                title: Some("Rotating speed Ω".into()),
                ..shown("rotating_speed", "rotating_speed_rad_s", "rotating speed", Role::Configuration)
            },
            _ => quantity,
        }
    });
    let numbers = StartValue::ALL.into_iter().map(|number| Quantity {
        role: Role::Start,
        scatters_absolutely: true,
        title: Some(number.title().into()),
        is_rate: number == StartValue::Velocity,
        ..Quantity::new(number.key(), number.unit(start.units), number.description(start))
    });
    parameters.chain(numbers).collect()
}

/// An error of the brake as one of the model.
#[expect(clippy::needless_pass_by_value, reason = "it is what errors are mapped with")]
pub(super) fn error(error: impl ToString) -> ModelError {
    ModelError(error.to_string())
}
