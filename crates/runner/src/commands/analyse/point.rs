//! One parameter point: what is computed of it, and its numbers by name.

use std::f64::consts::TAU;

use serde_json::{Map, Value, json};
use stickslip_core::models::pad_on_disc::degree_of_freedom::DegreeOfFreedom;
use stickslip_core::models::pad_on_disc::flexible_disc::brake::FlexibleBrake;
use stickslip_core::models::pad_on_disc::flexible_disc::error::FlexibleError;
use stickslip_core::models::pad_on_disc::flexible_disc::linear_stability::LinearStability;
use stickslip_core::models::pad_on_disc::flexible_disc::mode_count::ModeCheck;
use stickslip_core::models::pad_on_disc::parameters::SCALARS;
use stickslip_core::models::pad_on_disc::rigid_disc::basin::Basin;
use stickslip_core::models::pad_on_disc::rigid_disc::limit_cycle::{CycleEnds, LimitCycle};
use stickslip_core::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs, SlidingEquilibrium};
use stickslip_core::models::pad_on_disc::rigid_disc::stability::SpeedRange;
use stickslip_core::numerics::eigenvalues::{Eigenvalue, eigenvalues};

use super::without_friction::WithoutFriction;
use crate::failure::Failure;

/// Disc frequencies are shown up to this number of nodal diameters.
const MOST_NODAL_DIAMETERS: u32 = 4;

/// One parameter point.
pub struct Analysis {
    pub equilibrium: SlidingEquilibrium,
    pub stable: bool,
    pub coupled: Result<Coupled, FlexibleError>,
    pub disc_frequencies: Vec<f64>,
    pub unstable_speeds: Vec<SpeedRange>,
    /// The end of stick-slip, and that of all limit cycles.
    pub ends: CycleEnds,
    pub limit_cycle: Option<LimitCycle>,
    pub basin: Basin,
    pub critical_static_friction: f64,
    pub critical_preload: f64,
    pub without_friction: WithoutFriction,
    pub brake: PadOnDisc,
}

impl Analysis {
    /// Of a brake. `modes` of the disc are kept, by default as many as the growth rate needs.
    pub fn new(brake: PadOnDisc, modes: Option<usize>) -> Self {
        let parameters = brake.parameters();
        let preload = parameters.operating_point.preload;
        let static_friction = parameters.friction.static_coefficient;
        let inputs = RandomInputs { preload, static_friction };
        let flexible = match modes {
            Some(modes) => FlexibleBrake::with_modes(brake.clone(), modes).map(|flexible| (flexible, None)),
            None => FlexibleBrake::with_enough_modes(brake.clone()).map(|(flexible, check)| (flexible, Some(check))),
        };
        let coupled = flexible.and_then(|(flexible, check)| {
            let q = flexible.sliding_equilibrium(inputs)?;
            Ok(Coupled {
                equilibrium: [q[0], q[1], q[2]],
                growth_rate: flexible.growth_rate(inputs)?,
                stability: flexible.by_eigenvalues(inputs)?,
                modes: flexible.modes(),
                too_few: check.filter(|check| !check.is_enough),
            })
        });
        let boundary = brake.stability_boundary();
        let limit_cycle = brake.limit_cycle();
        Self {
            equilibrium: brake.sliding_equilibrium(),
            stable: brake.growth_rate() <= 0.0,
            coupled,
            disc_frequencies: disc_frequencies(&brake),
            unstable_speeds: brake.unstable_speeds(),
            ends: brake.cycle_ends(),
            limit_cycle,
            basin: brake.basin(),
            critical_static_friction: boundary.critical_second(preload),
            critical_preload: boundary.critical_first(static_friction),
            without_friction: WithoutFriction::of(&brake, limit_cycle.is_some()),
            brake,
        }
    }

    /// Everything by name; JSON has no infinity and no NaN, they become null.
    pub fn json(&self) -> Result<Value, Failure> {
        let eigenvalues = eigenvalues(&self.brake.jacobian())
            .map_err(|error| Failure::InputOutput(format!("eigenvalues of steady sliding: {error}")))?;
        let (scales, parameters) = (self.brake.scales(), self.brake.parameters());
        let point = &parameters.operating_point;
        let values: Map<String, Value> =
            SCALARS.iter().map(|scalar| (scalar.key.to_owned(), json!(scalar.value(parameters)))).collect();
        let coupled = self.coupled.as_ref().ok();
        let [x, _, y, _, phi, _] = self.brake.sliding_eigenvalues();
        let mode = |value: Eigenvalue| {
            json!({
                "growth_rate_per_s": scales.per_second(value.re),
                "frequency_hz": scales.hertz(value.im / TAU),
            })
        };
        let critical = self.unstable_speeds.last().map(|speeds| speeds.to);
        let lower_critical = self.unstable_speeds.last().map(|speeds| speeds.from).filter(|from| *from > 0.0);
        let in_m_s = |speed: Option<f64>| speed.map(|speed| self.brake.speed_under_pad(speed));
        let displacements = |[x, y, phi]: [f64; 3]| {
            let [x_mm, y_mm] = [x, y].map(|value| scales.millimetres(value));
            json!({ "x": x, "y": y, "phi": phi, "x_mm": x_mm, "y_mm": y_mm })
        };
        let SlidingEquilibrium { tangential, normal, angle, .. } = self.equilibrium;
        let mut analysis = json!({
            "equilibrium": displacements([tangential, normal, angle]),
            "coupled_equilibrium": coupled.map(|coupled| displacements(coupled.equilibrium)),
            "normal_force_n": scales.newtons(self.equilibrium.normal_force),
            "friction_coefficient": self.equilibrium.friction_coefficient,
            "eigenvalues": eigenvalues.iter().map(|value| [value.re, value.im]).collect::<Vec<_>>(),
            "growth_rate": self.brake.growth_rate(),
            "stable": self.stable,
            "coupled_growth_rate": coupled.map(|coupled| coupled.growth_rate),
            "coupled_stable": coupled.map(|coupled| coupled.stability == LinearStability::Stable),
            "coupled_fed_by": coupled.and_then(Coupled::fed_by).map(|freedom| freedom.to_string()),
            "disc_modes": coupled.map(|coupled| coupled.modes),
            "unstable_speeds": match *self.unstable_speeds {
                [] => json!("none"),
                [speeds] if speeds.to.is_infinite() => json!("all"),
                [speeds] => json!([speeds.from, speeds.to]),
                ref several => json!(several.iter().map(|speeds| [speeds.from, speeds.to]).collect::<Vec<_>>()),
            },
            "critical_speed_rad_s": critical,
            "lower_critical_speed_rad_s": lower_critical,
            "saddle_node_speed_rad_s": self.ends.stick_slip,
            "end_of_cycles_rad_s": self.ends.any,
            "limit_cycle": self.limit_cycle.map(|cycle| json!({
                "period": cycle.period,
                "x_max": cycle.tangential_max,
                "x_min": cycle.tangential_min,
                "stick_fraction": cycle.stick_fraction,
                "period_s": scales.seconds(cycle.period),
                "frequency_hz": scales.hertz(1.0 / cycle.period),
                "x_max_mm": scales.millimetres(cycle.tangential_max),
                "x_min_mm": scales.millimetres(cycle.tangential_min),
            })),
            "smallest_knock": self.basin.smallest_knock().map(|knock| json!({
                "speed": knock.speed(),
                "displacement": knock.displacement(),
                "forward": knock.forward,
                "backward": knock.backward,
                "outward": knock.outward,
                "inward": knock.inward,
                "speed_m_s": scales.metres_per_second(knock.speed()),
                "displacement_mm": scales.millimetres(knock.displacement()),
                "forward_m_s": scales.metres_per_second(knock.forward),
                "backward_m_s": scales.metres_per_second(knock.backward),
                "outward_mm": scales.millimetres(knock.outward),
                "inward_mm": scales.millimetres(knock.inward),
            })),
            "basin_area": self.basin.area(),
            "critical_static_friction": self.critical_static_friction,
            "critical_preload": self.critical_preload,
            "time_scale_s": scales.time,
            "parameters": values,
        });
        let in_si = json!({
            "speed_under_pad_m_s": self.brake.speed_under_pad(point.rotating_speed),
            "preload_mm": scales.millimetres(point.preload),
            "pad_modes": { "tangential": mode(x), "normal": mode(y), "angular": mode(phi) },
            "growth_rate_per_s": scales.per_second(self.brake.growth_rate()),
            "coupled_growth_rate_per_s": coupled.map(|coupled| scales.per_second(coupled.growth_rate)),
            "disc_frequencies_hz": self.disc_frequencies,
            "critical_speed_m_s": in_m_s(critical),
            "lower_critical_speed_m_s": in_m_s(lower_critical),
            "saddle_node_speed_m_s": in_m_s(self.ends.stick_slip),
            "end_of_cycles_m_s": in_m_s(self.ends.any),
            "basin_area_m2_s": self.basin.area().map(|area| scales.square_metres_per_second(area)),
            "critical_preload_mm": scales.millimetres(self.critical_preload),
            "critical_normal_force_n": self.brake.contact_force(self.critical_preload),
            "without_friction": self.without_friction.json(),
            "length_scale_m": scales.length,
            "speed_scale_m_s": scales.speed,
        });
        if let (Value::Object(analysis), Value::Object(in_si)) = (&mut analysis, in_si) {
            analysis.extend(in_si);
        }
        Ok(analysis)
    }
}

/// Lowest frequency of the disc with 0, 1, ... nodal diameters, Hz: at rest and without the pad. Empty if the plate has
/// no modes that can be computed.
fn disc_frequencies(brake: &PadOnDisc) -> Vec<f64> {
    let plate = brake.annular_plate();
    let lowest = |nodal_diameters| {
        let modes = plate.modes(nodal_diameters, 1).ok()?;
        Some(brake.scales().hertz(brake.disc_frequency(modes.first()?) / TAU))
    };
    (0..=MOST_NODAL_DIAMETERS).map_while(lowest).collect()
}

/// Steady sliding of pad and flexible disc, and what the eigenvalues say of it.
pub struct Coupled {
    /// x and y over h, and phi in rad.
    pub equilibrium: [f64; 3],
    pub growth_rate: f64,
    pub stability: LinearStability,
    pub modes: usize,
    /// Where no number of modes is enough: how far off the most of them are.
    pub too_few: Option<ModeCheck>,
}

impl Coupled {
    pub fn fed_by(&self) -> Option<DegreeOfFreedom> {
        match self.stability {
            LinearStability::Stable => None,
            LinearStability::Unstable { fed_by } => Some(fed_by),
        }
    }
}
