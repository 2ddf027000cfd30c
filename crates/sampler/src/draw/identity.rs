//! The identity of a sample: its random numbers are a function of seed, purpose, cell and sample number alone.
//!
//! The samples of a cell are drawn in blocks of [`BLOCK_SAMPLES`]. Each block has a generator of its own, Xoshiro256++,
//! whose 256 bits of state are the BLAKE3 hash of (results version, seed, purpose, cell, block). Any block can
//! therefore be drawn by itself, and no two blocks share a stream: the hash fills the whole state, whereas 64-bit seeds
//! would collide after some 10^9 blocks.

use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;

/// Version of everything that turns a job into results: samples, verdicts, verdict maps, estimates and intervals. It
/// changes whenever one of their values changes. Runs of different versions are never mixed.
pub const RESULTS_VERSION: u32 = 1;

/// Samples in one block. A change needs a new results version.
pub const BLOCK_SAMPLES: u64 = 1000;

/// The purpose of a stream of random numbers. Streams of different purposes are independent.
#[doc(hidden)]
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Purpose {
    /// The random inputs of a cell.
    Inputs,
    /// The random inputs that all cells of a job share (common random numbers).
    CommonInputs,
    /// The scrambling of the Sobol points of a cell; the number of the randomisation takes the place of the block.
    Scrambling,
    /// The scrambling of Sobol points that all cells of a job share.
    CommonScrambling,
    /// The choice of looked-up samples that are audited.
    Audit,
    /// The second set of random inputs of a cell, for Sobol indices.
    Sensitivity,
    /// The second set of random inputs that all cells of a job share.
    CommonSensitivity,
    /// A population that looks for rare events in a cell; its number takes the place of the block.
    Population,
    /// A population that all cells of a job share.
    CommonPopulation,
}

impl Purpose {
    /// Every purpose.
    #[cfg(test)]
    pub(crate) const ALL: [Self; 9] = [
        Self::Inputs,
        Self::CommonInputs,
        Self::Scrambling,
        Self::CommonScrambling,
        Self::Audit,
        Self::Sensitivity,
        Self::CommonSensitivity,
        Self::Population,
        Self::CommonPopulation,
    ];

    fn tag(self) -> u32 {
        match self {
            Self::Inputs => 0,
            Self::CommonInputs => 1,
            Self::Scrambling => 2,
            Self::CommonScrambling => 3,
            Self::Audit => 4,
            Self::Sensitivity => 5,
            Self::CommonSensitivity => 6,
            Self::Population => 7,
            Self::CommonPopulation => 8,
        }
    }
}

/// What generates random numbers.
pub type Generator = Xoshiro256PlusPlus;

/// The generator of one block of samples of a cell.
#[doc(hidden)]
#[must_use]
pub fn block_generator(seed: u64, purpose: Purpose, cell: u64, block: u64) -> Generator {
    let mut message = [0u8; 32];
    message[0..4].copy_from_slice(&RESULTS_VERSION.to_le_bytes());
    message[4..8].copy_from_slice(&purpose.tag().to_le_bytes());
    message[8..16].copy_from_slice(&seed.to_le_bytes());
    message[16..24].copy_from_slice(&cell.to_le_bytes());
    message[24..32].copy_from_slice(&block.to_le_bytes());
    Xoshiro256PlusPlus::from_seed(*blake3::hash(&message).as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::Rng;
    use std::collections::HashSet;

    #[test]
    fn every_part_of_the_identity_matters() {
        let mut seen = HashSet::new();
        for seed in [0, 1, u64::MAX] {
            for purpose in Purpose::ALL {
                for cell in [0, 1, 1 << 40] {
                    for block in [0, 1, 1 << 40] {
                        assert!(seen.insert(block_generator(seed, purpose, cell, block).next_u64()));
                    }
                }
            }
        }
    }

    #[test]
    fn the_first_words_are_pinned() {
        // Computed outside Rust: Python's blake3 package and the reference algorithm of Blackman and Vigna.
        let mut generator = block_generator(2018, Purpose::Inputs, 7, 3);
        assert_eq!(
            [generator.next_u64(), generator.next_u64()],
            [6_579_043_794_534_137_057, 16_330_598_624_863_430_190]
        );
    }
}
