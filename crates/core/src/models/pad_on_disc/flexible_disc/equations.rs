//! The equations of motion of pad and flexible disc.
//!
//! The disc is a few modes of the annular plate in the space-fixed frame, `w = sum of a_k psi_k`, with cosine and sine
//! shapes. Beside the pad's equations ([`crate::models::pad_on_disc::pad::equations`]), with the pressure `P = k_en <g+>`, each pair of
//! amplitudes has
//!
//! ```text
//! c'' + eta1 c' + 2 Om n s' + (omega^2 - n^2 Om^2) c = -(h^3 k_en / (D m)) (<psi_c g+> + mu s <psi_c g+ w_theta / r>)
//! s'' + eta1 s' - 2 Om n c' + (omega^2 - n^2 Om^2) s = -(h^3 k_en / (D m)) (<psi_s g+> + mu s <psi_s g+ w_theta / r>)
//! ```
//!
//! (the paper's equation 2.5; `m` is the integral of `psi^2` over the disc, `Om = Omega tau`, `eta1 = 2 zeta omega_1`.)

use std::sync::Arc;

use crate::models::pad_on_disc::flexible_disc::contact::loads::ContactLoads;
use crate::models::pad_on_disc::flexible_disc::contact::patch::LENGTH_UNIT;
use crate::models::pad_on_disc::flexible_disc::contact::position::PadPosition;
use crate::models::pad_on_disc::flexible_disc::geometry::DiscGeometry;
use crate::models::pad_on_disc::flexible_disc::plate_modes::PlateMode;
use crate::models::pad_on_disc::pad::contact_state::ContactState;
use crate::models::pad_on_disc::pad::equations::{Contact, ContactForces, PAD, PadEquations, PadInputs};
use crate::models::pad_on_disc::rigid_disc::pad_on_disc::{PadOnDisc, RandomInputs};
use crate::numerics::row::{Number, numbers};
use crate::numerics::sine_cosine::sine_and_cosine;

numbers! {
    /// The equation of one amplitude of the disc. Its partner is the other of cosine and sine.
    #[derive(Debug, Clone, Copy, PartialEq, Default)]
    pub(crate) struct Amplitude<N> {
        /// omega^2 - n^2 Om^2.
        pub stiffness: N,
        /// 2 Om n, positive for the cosine and negative for the sine; 0 without partner.
        pub gyroscopic: N,
        /// Index of the partner among the amplitudes, its own without one.
        pub partner: usize,
        /// h^3 k_en / (D m).
        pub compliance: N,
    }
}

numbers! {
    /// Coefficients of the equations of pad and disc.
    #[derive(Debug, Clone, Default)]
    pub(crate) struct Coefficients<N> {
        pub pad: PadEquations<N>,
        pub amplitudes: Vec<Amplitude<N>>,
        /// eta1.
        pub disc_damping: N,
        /// [`LENGTH_UNIT`] over `h / b`: what `tan(phi)` is multiplied with for the patch.
        pub tilt_scale: N,
        /// Its reciprocal: what the follower loads of the patch are multiplied with.
        pub slope_scale: N,
    }
}

/// The loads on the modes: `<psi_k g+>`, and the follower loads of [`ContactLoads`].
#[derive(Debug, Clone, Copy)]
pub(crate) struct LoadsOnModes<'a, N> {
    pub on_modes: &'a [N],
    pub follower: &'a [N],
}

impl<N: Number> Coefficients<N> {
    /// The accelerations of all degrees of freedom under given loads, and the forces at the contact; see
    /// [`PadEquations::accelerations`].
    #[inline(always)]
    pub fn accelerations(
        &self,
        inputs: &PadInputs<N>,
        contact: Contact<N>,
        (q, u): (&[N], &[N]),
        (angle, pressure): ((N, N), N),
        loads: LoadsOnModes<'_, N>,
        accelerations: &mut [N],
    ) -> ContactForces<N> {
        let (of_pad, forces) = self.pad.accelerations(inputs, contact, q, u, angle, pressure);
        accelerations[..PAD].copy_from_slice(&of_pad);
        let ratio = forces.acting_ratio() * self.slope_scale;
        for (k, amplitude) in self.amplitudes.iter().enumerate() {
            accelerations[PAD + k] = -(amplitude.stiffness * q[PAD + k]
                + self.disc_damping * u[PAD + k]
                + amplitude.gyroscopic * u[PAD + amplitude.partner])
                - amplitude.compliance * (loads.on_modes[k] + ratio * loads.follower[k]);
        }
        forces
    }
}

/// The equations at one rotating speed; preload and static friction are given sample by sample. All but the geometry
/// are numbers of this brake, which cost little.
#[derive(Debug, Clone)]
pub(crate) struct FlexibleEquations {
    pub brake: PadOnDisc,
    pub geometry: Arc<DiscGeometry>,
    pub coefficients: Coefficients,
}

/// How steeply friction falls with the sliding speed in steady sliding.
pub(crate) fn friction_slope(brake: &PadOnDisc, pad: &PadEquations, static_friction: f64) -> f64 {
    brake.friction_law().with_static(static_friction).fall(pad.disc_speed)
}

impl FlexibleEquations {
    /// The equations of a brake with this geometry.
    pub fn new(brake: PadOnDisc, geometry: Arc<DiscGeometry>) -> Self {
        let parameters = brake.parameters();
        let disc = &parameters.disc;
        let modes = &geometry.modes;
        let spin = parameters.operating_point.rotating_speed * brake.scales().time;
        let gain = disc.thickness * disc.thickness * disc.thickness * parameters.stiffness.contact_normal
            / brake.scales().flexural_rigidity;
        let per_parameter = brake.frequency_per_parameter();
        let amplitude = |mode: &PlateMode, partner: usize, direction: f64| {
            let n = f64::from(mode.nodal_diameters);
            let frequency = mode.frequency_parameter * per_parameter;
            Amplitude {
                stiffness: frequency * frequency - n * n * spin * spin,
                gyroscopic: direction * 2.0 * spin * n,
                partner,
                compliance: gain / (disc.outer_radius * disc.outer_radius * mode.circle()),
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
        let first = geometry.lowest_parameter * per_parameter;
        let thickness = disc.thickness / disc.outer_radius;
        let coefficients = Coefficients {
            pad: PadEquations::new(&brake),
            amplitudes,
            disc_damping: 2.0 * disc.transverse_damping_ratio * first,
            tilt_scale: LENGTH_UNIT / thickness,
            slope_scale: thickness / LENGTH_UNIT,
        };
        Self { brake, geometry, coefficients }
    }

    /// Where the pad is for the patch, at displacements that begin with x, y and phi, with the sine and cosine of phi.
    #[inline(always)]
    pub fn position(&self, q: &[f64], (sine, cosine): (f64, f64)) -> PadPosition {
        PadPosition { normal: q[1], tilt: sine / cosine * self.coefficients.tilt_scale }
    }

    /// Degrees of freedom: x, y, phi, the cosine amplitudes and the sine amplitudes of the disc.
    pub fn size(&self) -> usize {
        PAD + self.coefficients.amplitudes.len()
    }

    /// The slowest damping rate of the normal, angular and disc motion, each taken alone: half of the damping, or for
    /// an overdamped motion its stiffness over its damping. Near flutter their coupling reduces it; that is left out.
    pub fn slowest_transient(&self) -> f64 {
        let rate = |damping: f64, stiffness: f64| (0.5 * damping).min(stiffness / damping.max(f64::MIN_POSITIVE));
        let pad = &self.coefficients.pad;
        let normal = rate(pad.normal_damping, pad.normal_stiffness + pad.pressure_gain);
        (0.5 * self.coefficients.disc_damping).min(normal).min(rate(pad.angular_damping, pad.angular_stiffness))
    }

    /// The accelerations of x, y and phi alone, and the forces at the contact: the same bits as
    /// [`FlexibleEquations::accelerations`], at little cost where the whole patch is in contact.
    pub fn pad_accelerations(
        &self,
        inputs: RandomInputs,
        contact: ContactState,
        q: &[f64],
        u: &[f64],
    ) -> ([f64; PAD], ContactForces) {
        let angle = sine_and_cosine(q[2]);
        let (position, patch, amplitudes) = (self.position(q, angle), &self.geometry.patch, &q[PAD..]);
        let pressure = if patch.is_surely_whole(position, amplitudes) {
            patch.averages.mean_gap(-position.normal, amplitudes)
        } else {
            let mut loads = ContactLoads::zero();
            patch.loads_of_pressed_part(position, amplitudes, &mut loads);
            loads.pressure
        };
        self.coefficients.pad.accelerations(
            &inputs.into(),
            contact.into(),
            q,
            u,
            angle,
            self.coefficients.pad.pressure_gain * pressure,
        )
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
        let position = self.position(q, (sine, cosine));
        let (patch, amplitudes) = (&self.geometry.patch, &q[PAD..]);
        if patch.is_surely_whole(position, amplitudes) {
            patch.loads_of_whole_patch(position, amplitudes, loads);
        } else {
            patch.loads_of_pressed_part(position, amplitudes, loads);
        }
        let pressure = self.coefficients.pad.pressure_gain * loads.pressure;
        let n = self.coefficients.amplitudes.len();
        let loads = LoadsOnModes { on_modes: &loads.on_modes[..n], follower: &loads.follower[..n] };
        let pressed = ((sine, cosine), pressure);
        self.coefficients.accelerations(&inputs.into(), contact.into(), (q, u), pressed, loads, accelerations)
    }
}
