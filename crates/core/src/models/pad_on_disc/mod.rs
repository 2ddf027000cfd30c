//! Physics of a brake pad pressed on a rotating disc: parameters, friction law, steady sliding and its stability, the
//! modes of the disc, contact, the motion of pad and disc in time, and the criteria that decide samples.
//!
//! The model is the pad-on-disc system of X. Sui and Q. Ding, "Instability and stochastic analyses of a
//! pad-on-disc frictional system in moving interactions", Nonlinear Dynamics (2018),
//! doi 10.1007/s11071-018-4280-4, called "the paper" below. Its Table 1 (the parameter values) did not survive in
//! the copy that this model was written from: the preset
//! [`Parameters::sui_ding_2018`](parameters::Parameters::sui_ding_2018) is a reconstruction.
//!
//! # Notation
//!
//! Lengths are scaled by the disc thickness `h`, time by `tau = sqrt(rho h^4 / D)`, speeds by
//! `sqrt(D / (rho h^2)) = h / tau`, with the flexural rigidity `D = E h^3 / (12 (1 - nu^2))` and
//! `eta0 = D / (rho h^4) = 1 / tau^2`. In SI units these scales are numbers rather than true dimensionless groups
//! (`tau` carries a stray square root of a metre); the paper uses them so, and so does this crate. Forces of
//! the scaled equations are divided by `h` and therefore carry N/m. The rotating speed `Omega` is in rad/s
//! everywhere; the disc passes under the pad at `V = r_e Omega`, scaled `v`.
//!
//! | paper | here | meaning |
//! |---|---|---|
//! | Delta | `preload` | displacement that the calliper imposes on the pad, divided by `h` |
//! | f_s, f_c | `static_coefficient`, `kinetic_coefficient` | friction at rest and at high sliding speed |
//! | v_s, delta | `stribeck_velocity`, `stribeck_exponent` | speed scale and shape of the falling friction curve |
//! | Omega | `rotating_speed` | of the disc, rad/s |
//! | x, y, phi | `tangential`, `normal`, `angle` | pad motion, scaled by `h` (angle in rad) |
//! | N, P | `normal_force` | contact force between pad and disc |
//! | m1 / 2 | `growth_rate` | real part of the tangential eigenvalue pair, per unit of scaled time |
//!
//! # Modules
//!
//! Modules are declared in reading order, and each imports only earlier ones.
//!
//! | module | contents |
//! |---|---|
//! | [`parameters`] | all parameters with keys, units, limits and the preset |
//! | [`degree_of_freedom`] | what feeds an unstable motion |
//! | [`rigid_disc`] | the pad on a rigid disc: steady sliding, its stability in closed form, limit cycle, return map, basin |
//! | `pad` | states of contact, and the pad's equations of motion on any disc |
//! | [`flexible_disc`] | modes of the disc, contact over the patch, equations, equilibrium, linear stability |
//! | [`motion`] | starts, steps with stick and slip, the motions on a rigid and on a flexible disc |
//! | [`criterion`] | the simulation in time until the verdict is certain, its settings and its range of validity |
//! | [`lanes`] | the same for many samples at once, in vector registers |
//! | [`trajectory`] | single motions recorded, what they settle to, sweeps of the rotating speed |
//! | [`finite_difference`] | the paper's own discretisation of the disc, as a reference |

pub mod parameters;

pub mod degree_of_freedom;

pub mod rigid_disc;

mod pad;

pub mod flexible_disc;

pub mod motion;

pub mod criterion;

pub mod lanes;

pub mod trajectory;

pub mod finite_difference;

pub mod model;
