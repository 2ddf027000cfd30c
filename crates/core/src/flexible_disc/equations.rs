//! The equations of motion of pad and flexible disc.
//!
//! The disc is a few modes of the annular plate in the space-fixed frame, `w = sum of a_k psi_k`, with cosine and sine
//! shapes. Beside the pad's equations ([`crate::pad::equations`]), with the pressure `P = k_en <g+>`, each pair of
//! amplitudes has
//!
//! ```text
//! c'' + eta1 c' + 2 Om n s' + (omega^2 - n^2 Om^2) c = -(h^3 k_en / (D m)) (<psi_c g+> + mu s <psi_c g+ w_theta / r>)
//! s'' + eta1 s' - 2 Om n c' + (omega^2 - n^2 Om^2) s = -(h^3 k_en / (D m)) (<psi_s g+> + mu s <psi_s g+ w_theta / r>)
//! ```
//!
//! (the paper's equation 2.5; `m` is the integral of `psi^2` over the disc, `Om = Omega tau`, `eta1 = 2 zeta omega_1`.)

use crate::flexible_disc::contact::loads::ContactLoads;
use crate::flexible_disc::contact::patch::ContactPatch;
use crate::flexible_disc::contact::points::sufficient_points;
use crate::flexible_disc::contact::position::PadPosition;
use crate::flexible_disc::plate_modes::PlateMode;
use crate::numerics::sine_cosine::sine_and_cosine;
use crate::pad::contact_state::ContactState;
use crate::pad::equations::{ContactForces, PAD, PadEquations};
use crate::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};

/// One amplitude of the disc: its equation and its partner, the other of cosine and sine.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Amplitude {
    /// omega^2 - n^2 Om^2.
    pub stiffness: f64,
    /// 2 Om n, positive for the cosine and negative for the sine; 0 without partner.
    pub gyroscopic: f64,
    /// Index of the partner among the amplitudes, its own without one.
    pub partner: usize,
    /// h^3 k_en / (D m).
    pub compliance: f64,
}

/// The equations at one rotating speed; preload and static friction are given sample by sample.
#[derive(Debug, Clone)]
pub(crate) struct FlexibleEquations {
    pub brake: PadOnDisc,
    pub modes: Vec<PlateMode>,
    pub patch: ContactPatch,
    pub amplitudes: Vec<Amplitude>,
    pub pad: PadEquations,
    /// eta1.
    pub disc_damping: f64,
    /// Shapes of the cosine amplitudes at the outer edge, and a quarter of the way to it.
    pub shapes_at_edge: Vec<f64>,
    pub shapes_inside: Vec<f64>,
}

impl FlexibleEquations {
    /// The equations with these modes of the disc, and as many points on the patch as they need.
    pub fn new(brake: PadOnDisc, modes: &[PlateMode]) -> Self {
        let points = sufficient_points(brake.parameters(), modes);
        Self::with_points(brake, modes, points)
    }

    /// With a given number of points along the radius and along the angle of the patch.
    pub fn with_points(brake: PadOnDisc, modes: &[PlateMode], (radial, angular): (usize, usize)) -> Self {
        let parameters = brake.parameters();
        let disc = &parameters.disc;
        let patch = ContactPatch::new(parameters, modes, radial, angular);
        let spin = parameters.operating_point.rotating_speed * brake.scales().time;
        let gain = disc.thickness * disc.thickness * disc.thickness * parameters.stiffness.contact_normal
            / brake.scales().flexural_rigidity;
        let amplitude = |mode: &PlateMode, partner: usize, direction: f64| {
            let n = f64::from(mode.nodal_diameters);
            let frequency = brake.disc_frequency(mode);
            let circle = if mode.nodal_diameters == 0 { 2.0 } else { 1.0 } * std::f64::consts::PI;
            Amplitude {
                stiffness: frequency * frequency - n * n * spin * spin,
                gyroscopic: direction * 2.0 * spin * n,
                partner,
                compliance: gain / (disc.outer_radius * disc.outer_radius * circle),
            }
        };
        let mut amplitudes = Vec::with_capacity(2 * modes.len());
        let mut odd = modes.len();
        for (index, mode) in modes.iter().enumerate() {
            let has_partner = mode.nodal_diameters > 0;
            amplitudes.push(amplitude(mode, if has_partner { odd } else { index }, 1.0));
            odd += usize::from(has_partner);
        }
        for (index, mode) in modes.iter().enumerate().filter(|(_, mode)| mode.nodal_diameters > 0) {
            amplitudes.push(amplitude(mode, index, -1.0));
        }
        let first = modes.iter().map(|mode| brake.disc_frequency(mode)).fold(f64::INFINITY, f64::min);
        let disc_damping = 2.0 * disc.transverse_damping_ratio * first;
        let clamped = disc.inner_radius / disc.outer_radius;
        let shapes_at = |r: f64| modes.iter().map(|mode| mode.shape(r)).collect();
        Self {
            patch,
            amplitudes,
            pad: PadEquations::new(&brake),
            disc_damping,
            shapes_at_edge: shapes_at(1.0),
            shapes_inside: shapes_at(clamped + 0.25 * (1.0 - clamped)),
            modes: modes.to_vec(),
            brake,
        }
    }

    /// Degrees of freedom: x, y, phi, the cosine amplitudes and the sine amplitudes of the disc.
    pub fn size(&self) -> usize {
        PAD + self.amplitudes.len()
    }

    /// The slowest damping rate of the normal, angular and disc motion, each taken alone: half of the damping, or for
    /// an overdamped motion its stiffness over its damping. Near flutter their coupling reduces it; that is left out.
    pub fn slowest_transient(&self) -> f64 {
        let rate = |damping: f64, stiffness: f64| (0.5 * damping).min(stiffness / damping.max(f64::MIN_POSITIVE));
        let pad = &self.pad;
        let normal = rate(pad.normal_damping, pad.normal_stiffness + pad.pressure_gain);
        (0.5 * self.disc_damping).min(normal).min(rate(pad.angular_damping, pad.angular_stiffness))
    }

    /// The accelerations of all degrees of freedom, and the forces at the contact, at displacements `q` and speeds `u`.
    #[inline]
    pub fn accelerations(
        &self,
        inputs: RandomInputs,
        contact: ContactState,
        q: &[f64],
        u: &[f64],
        loads: &mut ContactLoads,
        accelerations: &mut [f64],
    ) -> ContactForces {
        let (sine, cosine) = sine_and_cosine(q[2]);
        let position = PadPosition { normal: q[1], tilt: sine / cosine };
        let amplitudes = &q[PAD..];
        if self.patch.is_surely_whole(position, amplitudes) {
            self.patch.loads_of_whole_patch(position, amplitudes, loads);
        } else {
            self.patch.loads_of_pressed_part(position, amplitudes, loads);
        }
        let pressure = self.pad.pressure_gain * loads.pressure;
        let (of_pad, forces) = self.pad.accelerations(inputs, contact, q, u, (sine, cosine), pressure);
        accelerations[..PAD].copy_from_slice(&of_pad);
        let ratio = forces.acting_ratio();
        for (k, amplitude) in self.amplitudes.iter().enumerate() {
            accelerations[PAD + k] = -(amplitude.stiffness * q[PAD + k]
                + self.disc_damping * u[PAD + k]
                + amplitude.gyroscopic * u[PAD + amplitude.partner])
                - amplitude.compliance * (loads.on_modes[k] + ratio * loads.follower[k]);
        }
        forces
    }
}
