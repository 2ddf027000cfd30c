//! The parameters of the model: names, units, valid ranges, and the preset reconstructed from the paper.
//!
//! Every value is known by its key, `section.name`. [`SCALARS`] is the one list of keys, through which values are set,
//! printed and validated.

use thiserror::Error;

use crate::friction::law::LawKind;
use crate::friction::measured_curve::SharedCurve;
use crate::model::quantity::Limits;

/// The disc: a thin annular plate, clamped at the inner radius and free at the outer one.
#[derive(Debug, Clone, PartialEq)]
pub struct Disc {
    /// Density rho, kg/m^3.
    pub density: f64,
    /// Young's modulus E, Pa.
    pub youngs_modulus: f64,
    /// Poisson's ratio nu.
    pub poissons_ratio: f64,
    /// Thickness h, m.
    pub thickness: f64,
    /// Clamped inner radius a, m.
    pub inner_radius: f64,
    /// Free outer radius b, m.
    pub outer_radius: f64,
    /// Damping ratio zeta of the first disc mode.
    pub transverse_damping_ratio: f64,
}

/// The pad: a rigid body that moves tangentially, normally and in rotation.
#[derive(Debug, Clone, PartialEq)]
pub struct Pad {
    /// Mass M, kg.
    pub mass: f64,
    /// Moment of inertia I_s, kg m^2.
    pub moment_of_inertia: f64,
    /// Inner radius r_a of the contact patch, m; the patch reaches to the outer edge of the disc.
    pub inner_radius: f64,
    /// Effective radius r_e at which the pad slides, m; where not given, the outer radius of the disc, as in the paper.
    pub effective_radius: Option<f64>,
    /// Half of the angle psi that the pad covers, rad.
    pub half_angle: f64,
    /// Moment arm q of the friction force, m.
    pub moment_arm: f64,
}

/// Springs of the calliper and of the contact, N/m (angular: N m/rad).
#[derive(Debug, Clone, PartialEq)]
pub struct Stiffness {
    /// k_x, N/m.
    pub calliper_tangential: f64,
    /// k_y, N/m.
    pub calliper_normal: f64,
    /// k_s, N m/rad.
    pub calliper_angular: f64,
    /// k_en, N/m.
    pub contact_normal: f64,
    /// k_t1, N/m.
    pub contact_tangential_1: f64,
    /// k_t2, N/m.
    pub contact_tangential_2: f64,
}

impl Stiffness {
    /// Contact and calliper in series, `k_en k_y / (k_en + k_y)`, N/m.
    #[must_use]
    pub fn normal_in_series(&self) -> f64 {
        self.contact_normal * self.calliper_normal / (self.contact_normal + self.calliper_normal)
    }
}

/// Dampers of the pad, N s/m (angular: N m s/rad).
#[derive(Debug, Clone, PartialEq)]
pub struct Damping {
    /// c_x, N s/m.
    pub tangential: f64,
    /// c_y, N s/m.
    pub normal: f64,
    /// c_s, N m s/rad.
    pub angular: f64,
}

/// The friction law, see the module [`friction`](crate::friction).
#[derive(Debug, Clone, PartialEq)]
pub struct Friction {
    /// Which law.
    pub law: LawKind,
    /// Static friction coefficient f_s.
    pub static_coefficient: f64,
    /// Kinetic friction coefficient f_c, the limit at high sliding speed; 0 for a table.
    pub kinetic_coefficient: f64,
    /// Stribeck velocity v_s, m/s.
    pub stribeck_velocity: f64,
    /// Stribeck exponent delta; 1 is Tustin's law.
    pub stribeck_exponent: f64,
    /// Viscous friction, s/m: what each m/s of sliding speed adds to the coefficient.
    pub viscous: f64,
    /// By how many of its standard deviations a measured curve is shifted.
    pub band: f64,
}

impl Friction {
    /// Changes the law to a measured curve, with the coefficients of the curve.
    pub fn use_table(&mut self, curve: SharedCurve) {
        self.law = LawKind::Table(curve);
        self.static_coefficient = curve.at_rest();
        self.kinetic_coefficient = 0.0;
    }
}

/// The point at which the brake is operated.
#[derive(Debug, Clone, PartialEq)]
pub struct OperatingPoint {
    /// Preload Delta, displacement of the calliper divided by the disc thickness.
    pub preload: f64,
    /// Rotating speed Omega, rad/s.
    pub rotating_speed: f64,
}

/// All parameters of the model, in SI units.
///
/// A plain record: `PadOnDisc::new` validates it once, and everything that computes takes the validated type.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// The disc.
    pub disc: Disc,
    /// The pad.
    pub pad: Pad,
    /// The springs.
    pub stiffness: Stiffness,
    /// The dampers of the pad.
    pub damping: Damping,
    /// The friction law.
    pub friction: Friction,
    /// Preload and rotating speed.
    pub operating_point: OperatingPoint,
}

/// One parameter: its key, symbol, unit, limits and meaning.
#[derive(Debug, Clone, Copy)]
pub struct Scalar {
    /// `section.name`.
    pub key: &'static str,
    /// The paper's symbol.
    pub symbol: &'static str,
    /// SI unit; `1` for a pure number.
    pub unit: &'static str,
    /// Admissible values.
    pub limits: Limits,
    /// One line of explanation.
    pub description: &'static str,
    get: fn(&Parameters) -> f64,
    get_mut: fn(&mut Parameters) -> &mut f64,
}

/// The key of the one parameter that has no value of its own unless it is given one.
pub const EFFECTIVE_RADIUS_KEY: &str = "pad.effective_radius";

impl Scalar {
    /// The section part of the key.
    #[must_use]
    pub fn section(&self) -> &'static str {
        self.key.split_once('.').map_or("", |(section, _)| section)
    }

    /// The name part of the key.
    #[must_use]
    pub fn name(&self) -> &'static str {
        self.key.split_once('.').map_or(self.key, |(_, name)| name)
    }

    /// The value of this parameter in `parameters`.
    #[must_use]
    pub fn value(&self, parameters: &Parameters) -> f64 {
        (self.get)(parameters)
    }

    /// Whether the value in `parameters` is its own, and not that of another parameter: where `pad.effective_radius` is
    /// not given, it has the value of `disc.outer_radius`.
    #[must_use]
    pub fn is_given(&self, parameters: &Parameters) -> bool {
        self.key != EFFECTIVE_RADIUS_KEY || parameters.pad.effective_radius.is_some()
    }

    /// Sets this parameter in `parameters`, whatever the value.
    pub(crate) fn assign(&self, parameters: &mut Parameters, value: f64) {
        *(self.get_mut)(parameters) = value;
    }

    /// Whether `value` is admissible for this parameter taken alone.
    ///
    /// # Errors
    /// [`ParameterError::OutOfRange`] with the key, the value and the limits.
    pub fn check(&self, value: f64) -> Result<(), ParameterError> {
        if self.limits.contain(value) {
            Ok(())
        } else {
            Err(ParameterError::OutOfRange { key: self.key, value, unit: self.unit, limits: self.limits })
        }
    }
}

macro_rules! scalar {
    ($section:ident . $name:ident, $symbol:literal, $unit:literal, $limits:expr, $description:literal) => {
        Scalar {
            key: concat!(stringify!($section), ".", stringify!($name)),
            symbol: $symbol,
            unit: $unit,
            limits: $limits,
            description: $description,
            get: |parameters| parameters.$section.$name,
            get_mut: |parameters| &mut parameters.$section.$name,
        }
    };
}

/// Every parameter of the model, in the order of the preset.
///
/// The upper limits are far beyond any brake; they catch wrong units (GPa for Pa, mm for m), not bad designs.
#[rustfmt::skip]
pub static SCALARS: [Scalar; 30] = [
    scalar!(disc.density, "rho", "kg/m^3", Limits::above(0.0, 1e5), "density of the disc"),
    scalar!(disc.youngs_modulus, "E", "Pa", Limits::above(0.0, 1e13), "Young's modulus of the disc"),
    scalar!(disc.poissons_ratio, "nu", "1", Limits::from_below(0.0, 0.5), "Poisson's ratio of the disc"),
    scalar!(disc.thickness, "h", "m", Limits::above(0.0, 1.0), "thickness of the disc, the length scale"),
    scalar!(disc.inner_radius, "a", "m", Limits::above(0.0, 10.0), "radius at which the disc is clamped"),
    scalar!(disc.outer_radius, "b", "m", Limits::above(0.0, 10.0), "free edge of the disc"),
    scalar!(disc.transverse_damping_ratio, "zeta", "1", Limits::from_below(0.0, 1.0), "damping ratio of the first disc mode"),
    scalar!(pad.mass, "M", "kg", Limits::above(0.0, 1e3), "mass of the pad"),
    scalar!(pad.moment_of_inertia, "I_s", "kg m^2", Limits::above(0.0, 1e3), "moment of inertia of the pad"),
    scalar!(pad.inner_radius, "r_a", "m", Limits::above(0.0, 10.0), "inner radius of the contact patch"),
    Scalar {
        key: EFFECTIVE_RADIUS_KEY,
        symbol: "r_e",
        unit: "m",
        limits: Limits::above(0.0, 10.0),
        description: "radius at which the pad slides; disc.outer_radius where not given",
        get: Parameters::effective_radius,
        get_mut: |parameters| parameters.pad.effective_radius.get_or_insert(parameters.disc.outer_radius),
    },
    scalar!(pad.half_angle, "psi", "rad", Limits::above(0.0, std::f64::consts::PI), "half of the angle that the pad covers"),
    scalar!(pad.moment_arm, "q", "m", Limits::from(0.0, 1.0), "moment arm of the friction force"),
    scalar!(stiffness.calliper_tangential, "k_x", "N/m", Limits::above(0.0, 1e13), "tangential stiffness of the calliper"),
    scalar!(stiffness.calliper_normal, "k_y", "N/m", Limits::above(0.0, 1e13), "normal stiffness of the calliper"),
    scalar!(stiffness.calliper_angular, "k_s", "N m/rad", Limits::above(0.0, 1e13), "angular stiffness of the calliper"),
    scalar!(stiffness.contact_normal, "k_en", "N/m", Limits::above(0.0, 1e13), "normal stiffness of the contact"),
    scalar!(stiffness.contact_tangential_1, "k_t1", "N/m", Limits::above(0.0, 1e13), "tangential stiffness of the contact, disc side"),
    scalar!(stiffness.contact_tangential_2, "k_t2", "N/m", Limits::above(0.0, 1e13), "tangential stiffness of the contact, pad side"),
    scalar!(damping.tangential, "c_x", "N s/m", Limits::from(0.0, 1e9), "tangential damping of the pad"),
    scalar!(damping.normal, "c_y", "N s/m", Limits::from(0.0, 1e9), "normal damping of the pad"),
    scalar!(damping.angular, "c_s", "N m s/rad", Limits::from(0.0, 1e9), "angular damping of the pad"),
    scalar!(friction.static_coefficient, "f_s", "1", Limits::from(0.0, 5.0), "static friction coefficient"),
    scalar!(friction.kinetic_coefficient, "f_c", "1", Limits::from(0.0, 5.0), "kinetic friction coefficient"),
    scalar!(friction.stribeck_velocity, "v_s", "m/s", Limits::above(0.0, 1e3), "Stribeck velocity"),
    scalar!(friction.stribeck_exponent, "delta", "1", Limits::above(0.0, 10.0), "Stribeck exponent, 1 = Tustin"),
    scalar!(friction.viscous, "k_v", "s/m", Limits::from(0.0, 100.0), "viscous friction, coefficient for each m/s"),
    scalar!(friction.band, "z", "1", Limits::from(-10.0, 10.0), "shift of a measured friction curve in its standard deviations"),
    scalar!(operating_point.preload, "Delta", "1", Limits::from(0.0, 1.0), "preload, calliper displacement over disc thickness"),
    scalar!(operating_point.rotating_speed, "Omega", "rad/s", Limits::from(1e-6, 1e5), "rotating speed of the disc"),
];

/// The parameter known by `key`.
#[must_use]
pub fn scalar(key: &str) -> Option<&'static Scalar> {
    SCALARS.iter().find(|scalar| scalar.key == key)
}

/// Why a set of parameters was refused.
#[derive(Debug, Clone, PartialEq, Error)]
#[non_exhaustive]
pub enum ParameterError {
    /// No parameter has this key.
    #[error("there is no parameter `{key}`")]
    Unknown {
        /// The key as given.
        key: String,
    },
    /// The value lies outside the limits of its parameter, or is not a number.
    #[error("{key} = {value} is out of range: it must be {limits}{}", unit_phrase(.unit))]
    OutOfRange {
        /// Key of the parameter.
        key: &'static str,
        /// The value as given.
        value: f64,
        /// Unit of value and limits.
        unit: &'static str,
        /// Admissible values.
        limits: Limits,
    },
    /// Values, each admissible alone, that together lead out of the range of numbers.
    #[error("the parameters give {quantity} = {value}: some value is too small or too large to compute with")]
    NotComputable {
        /// What could not be computed.
        quantity: &'static str,
        /// What came out.
        value: f64,
    },
    /// Two values, each admissible alone, contradict each other.
    #[error("{key} = {value} must be {relation} {other_key} = {other_value}")]
    Contradiction {
        /// Key of the offending parameter.
        key: &'static str,
        /// Its value.
        value: f64,
        /// What it has to be, for example "less than".
        relation: &'static str,
        /// Key of the parameter that it is compared with.
        other_key: &'static str,
        /// The value of that one.
        other_value: f64,
    },
}

fn unit_phrase(unit: &str) -> String {
    if unit == "1" { String::new() } else { format!(" (in {unit})") }
}

impl Parameters {
    /// The set recovered from the numbers that the paper prints (its Table 1 is lost).
    ///
    /// Constrained by printed eigenvalues, critical speed, equilibrium, Table 3 and the saddle-node: all of
    /// `stiffness`, `damping`, `friction`, `disc.inner_radius`, `disc.outer_radius` and `disc.thickness`. Free
    /// choices of a realistic brake: disc material and damping, `pad.mass`, `pad.moment_of_inertia`,
    /// `pad.inner_radius`, `pad.moment_arm`. `stickslip reproduce scoreboard` computes how well the set does.
    #[must_use]
    pub fn sui_ding_2018() -> Self {
        Self {
            disc: Disc {
                density: 7800.0,
                youngs_modulus: 2.1e11,
                poissons_ratio: 0.3,
                thickness: 0.020,
                inner_radius: 0.064,
                outer_radius: 0.135,
                transverse_damping_ratio: 0.02,
            },
            pad: Pad {
                mass: 0.10,
                moment_of_inertia: 2.0e-4,
                inner_radius: 0.090,
                effective_radius: None,
                half_angle: std::f64::consts::FRAC_PI_6,
                moment_arm: 0.008,
            },
            stiffness: Stiffness {
                calliper_tangential: 3.249e7,
                calliper_normal: 3.249e7,
                calliper_angular: 2.472e4,
                contact_normal: 3.816e7,
                contact_tangential_1: 2.138e7,
                contact_tangential_2: 2.138e7,
            },
            damping: Damping { tangential: 369.0, normal: 106.1, angular: 0.08882 },
            friction: Friction {
                law: LawKind::Stribeck,
                static_coefficient: 0.39,
                kinetic_coefficient: 0.25,
                stribeck_velocity: 0.72,
                stribeck_exponent: 1.0,
                viscous: 0.0,
                band: 0.0,
            },
            operating_point: OperatingPoint { preload: 0.1, rotating_speed: 16.0 },
        }
    }

    /// Sets the parameter known by `key`, without looking at the others.
    ///
    /// # Errors
    /// [`ParameterError::Unknown`] for a key that does not exist, [`ParameterError::OutOfRange`] for a value
    /// outside its limits.
    pub fn set(&mut self, key: &str, value: f64) -> Result<(), ParameterError> {
        let scalar = scalar(key).ok_or_else(|| ParameterError::Unknown { key: key.to_owned() })?;
        scalar.check(value)?;
        *(scalar.get_mut)(self) = value;
        Ok(())
    }

    /// The effective radius r_e, m: the disc passes under the pad at `V = r_e Omega`.
    #[must_use]
    pub fn effective_radius(&self) -> f64 {
        self.pad.effective_radius.unwrap_or(self.disc.outer_radius)
    }

    /// The preload at which steady sliding on a rigid disc has this contact force (N), the inverse of
    /// `N = h Delta k_en k_y / (k_en + k_y)`.
    #[must_use]
    pub fn preload_of(&self, contact_force: f64) -> f64 {
        contact_force / (self.stiffness.normal_in_series() * self.disc.thickness)
    }

    /// Checks every value against its limits, and those that must agree against each other.
    ///
    /// # Errors
    /// The first violation found, in the order of [`SCALARS`].
    pub fn validate(&self) -> Result<(), ParameterError> {
        for scalar in &SCALARS {
            scalar.check(scalar.value(self))?;
        }
        self.check_relations()
    }

    /// Checks values that must agree against each other.
    pub(crate) fn check_relations(&self) -> Result<(), ParameterError> {
        let order = |(key, value): (&'static str, f64), relation, (other_key, other_value): (&'static str, f64)| {
            let holds = if relation == "less than" { value < other_value } else { value <= other_value };
            if holds {
                return Ok(());
            }
            Err(ParameterError::Contradiction { key, value, relation, other_key, other_value })
        };
        let inner = ("disc.inner_radius", self.disc.inner_radius);
        let outer = ("disc.outer_radius", self.disc.outer_radius);
        let of_pad = ("pad.inner_radius", self.pad.inner_radius);
        let effective = (EFFECTIVE_RADIUS_KEY, self.effective_radius());
        let kinetic = ("friction.kinetic_coefficient", self.friction.kinetic_coefficient);
        let static_coefficient = ("friction.static_coefficient", self.friction.static_coefficient);
        order(inner, "less than", outer)?;
        order(inner, "at most", of_pad)?;
        order(of_pad, "less than", outer)?;
        order(of_pad, "at most", effective)?;
        order(effective, "at most", outer)?;
        order(kinetic, "at most", static_coefficient)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_preset_is_valid() {
        assert_eq!(Parameters::sui_ding_2018().validate(), Ok(()));
    }

    #[test]
    fn every_scalar_reads_and_writes_its_own_value() {
        for (index, scalar) in SCALARS.iter().enumerate() {
            let mut parameters = Parameters::sui_ding_2018();
            parameters.pad.effective_radius = Some(0.115);
            let before: Vec<f64> = SCALARS.iter().map(|s| s.value(&parameters)).collect();
            let changed = before[index] * 0.5 + 0.001 * f64::from(u8::from(before[index] == 0.0));
            *(scalar.get_mut)(&mut parameters) = changed;
            for (other, s) in SCALARS.iter().enumerate() {
                let expected = if other == index { changed } else { before[other] };
                assert_eq!(s.value(&parameters), expected, "{} after setting {}", s.key, scalar.key);
            }
        }
    }

    #[test]
    fn the_effective_radius_is_the_outer_one_until_it_is_given() {
        let mut parameters = Parameters::sui_ding_2018();
        let of_pad = scalar(EFFECTIVE_RADIUS_KEY).unwrap();
        parameters.set("disc.outer_radius", 0.15).unwrap();
        assert_eq!((of_pad.value(&parameters), of_pad.is_given(&parameters)), (0.15, false));
        parameters.set(EFFECTIVE_RADIUS_KEY, 0.115).unwrap();
        parameters.set("disc.outer_radius", 0.16).unwrap();
        assert_eq!((of_pad.value(&parameters), of_pad.is_given(&parameters)), (0.115, true));
    }

    #[test]
    fn refusals_name_key_value_and_limit() {
        let mut parameters = Parameters::sui_ding_2018();
        let message = parameters.set("disc.thickness", 0.0).unwrap_err().to_string();
        assert_eq!(message, "disc.thickness = 0 is out of range: it must be greater than 0 and at most 1 (in m)");
        assert!(parameters.set("disc.thickness", f64::NAN).is_err());
        assert!(parameters.set("disc.thickness", f64::INFINITY).is_err());
        assert!(matches!(parameters.set("disc.thicknes", 0.1), Err(ParameterError::Unknown { .. })));
        assert_eq!(parameters, Parameters::sui_ding_2018(), "a refused value changes nothing");
    }

    #[test]
    fn contradictions_are_refused() {
        let cases = [
            (
                "friction.kinetic_coefficient",
                0.5,
                "friction.kinetic_coefficient = 0.5 must be at most friction.static_coefficient = 0.39",
            ),
            ("disc.inner_radius", 0.2, "disc.inner_radius = 0.2 must be less than disc.outer_radius = 0.135"),
            ("pad.inner_radius", 0.05, "disc.inner_radius = 0.064 must be at most pad.inner_radius = 0.05"),
            ("pad.inner_radius", 0.135, "pad.inner_radius = 0.135 must be less than disc.outer_radius = 0.135"),
            ("pad.effective_radius", 0.089, "pad.inner_radius = 0.09 must be at most pad.effective_radius = 0.089"),
            ("pad.effective_radius", 0.14, "pad.effective_radius = 0.14 must be at most disc.outer_radius = 0.135"),
        ];
        for (key, value, message) in cases {
            let mut parameters = Parameters::sui_ding_2018();
            parameters.set(key, value).unwrap();
            assert_eq!(parameters.validate().unwrap_err().to_string(), message);
        }
    }
}
