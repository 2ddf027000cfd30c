//! The sparse quadratic eigenproblem of a brake given by its matrices, and its reduction.
//!
//! A brake that slides steadily, disturbed a little, moves by
//!
//! ```text
//! M q'' + (sum_i c_i C_i) q' + (sum_j k_j K_j) q = 0
//! ```
//!
//! with sparse real matrices and coefficients that depend on parameters such as friction and speed. Motions
//! `q = x exp(lambda t)` are the eigenpairs of `Q(lambda) = lambda^2 M + lambda C + K`: `Q(lambda) x = 0` for a right
//! eigenvector, `y^T Q(lambda) = 0` (transposed, not conjugated) for a left one. The real part of lambda is a growth rate
//! in 1/s, its imaginary part an angular frequency in rad/s, and `-Re lambda / |lambda|` is the damping ratio. K is not
//! symmetric where friction acts, so left and right eigenvectors differ, and pairs of modes can flutter.
//!
//! | module | contents |
//! |---|---|
//! | [`quadratic`] | the matrices, products with them, their LU factorisation |
//! | [`band`] | all eigenpairs of a frequency band |
//! | [`along`] | the same along a path of parameters |
//! | [`modes`] | modes without damping and friction |
//! | [`reduction`] | a basis for a range of parameters, and the reduced matrices |
//! | [`audit`] | reduced pairs made full; modes that a reduction misses |
//!
//! faer factorises. It picks instructions by the processor, so the last bits of vectors differ between processors: see
//! [`has_common_instructions`].
//! Eigenvalues are evaluated from left and right vectors together by [compensated](self) sums of plain code: errors of
//! the vectors enter only as products, and each pair has an estimate of what is left.

mod compensated;

pub mod quadratic;

mod refine;

mod krylov;

pub mod band;

pub mod along;

pub mod modes;

pub mod reduction;

pub mod audit;

/// Whether this processor has the instructions with which full matrices give the same bits everywhere: AVX2 and FMA of
/// x86-64, and those that pulp, which has the vectors of faer, wants beside them.
///
/// AVX-512 changes nothing. Vectors are of four numbers with it, too, unless faer's `nightly` is turned on. Products of
/// matrices do take longer ones, but each sum of a product is a single chain of fused operations over at most 512 terms,
/// whatever its lane: there is a test of that. Sizes of caches decide what is copied, and in which order sums are begun.
/// Without AVX2 and FMA, and on aarch64, they also decide where sums are cut.
#[must_use]
pub fn has_common_instructions() -> bool {
    #[cfg(target_arch = "x86_64")]
    {
        use std::arch::is_x86_feature_detected;

        is_x86_feature_detected!("avx2")
            && is_x86_feature_detected!("fma")
            && is_x86_feature_detected!("bmi1")
            && is_x86_feature_detected!("bmi2")
            && is_x86_feature_detected!("lzcnt")
            && is_x86_feature_detected!("popcnt")
    }
    #[cfg(not(target_arch = "x86_64"))]
    {
        false
    }
}

#[cfg(test)]
mod tests;
