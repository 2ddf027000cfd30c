//! Drawing the samples of a cell.

use std::ops::Range;

use rand::RngExt;
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::draw::identity::{BLOCK_SAMPLES, Purpose, block_generator};
use crate::grid::Cell;

/// Samples handed over at once: small enough for the first-level cache, long enough to fill vector registers.
const CHUNK: usize = 250;

/// Some consecutive samples of one cell.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// `Delta (1 + sigma_Delta z1)`.
    pub preloads: &'a [f64],
    /// `f_s (1 + sigma_f z2)`.
    pub static_frictions: &'a [f64],
}

/// Where the samples of a job come from.
///
/// Sample `j` of a cell is `Delta (1 + sigma_Delta z1)`, `f_s (1 + sigma_f z2)` with standard normal `z1`, `z2`,
/// drawn in this order from the generator of block `j / BLOCK_SAMPLES`; an input that is not random draws nothing.
/// Values outside physics (`Delta <= 0`, `f_s < f_c`) are neither clipped nor redrawn; the criterion judges them
/// stable.
///
/// The deviates are `rand_distr`'s ziggurat. Its rare tail and rejection steps call `exp` and `ln`, which a build
/// that enables `num-traits/std` (Arrow does) takes from the platform; golden values in the tests and a run
/// without FMA and AVX2 guard that no result depends on it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SampleStream {
    /// Seed of the job.
    pub seed: u64,
    /// Whether every cell draws the same deviates.
    pub common_random_numbers: bool,
    /// Whether the preload is random.
    pub preload_is_random: bool,
    /// Whether the static friction coefficient is random.
    pub static_friction_is_random: bool,
}

impl SampleStream {
    /// Hands the samples `range` of `cell` to `visit`, in order and in pieces.
    ///
    /// A range that starts inside a block draws and drops the samples before it: at most one block.
    #[inline]
    pub fn for_each<F: FnMut(Samples<'_>)>(&self, cell: &Cell, range: Range<u64>, mut visit: F) {
        let mut preloads = [cell.preload; CHUNK];
        let mut static_frictions = [cell.static_friction; CHUNK];
        let mut next = range.start;
        while next < range.end {
            let block = next / BLOCK_SAMPLES;
            let first = block * BLOCK_SAMPLES;
            let end = range.end.min(first + BLOCK_SAMPLES);
            let mut generator = self.generator(cell, block);
            self.skip(&mut generator, next - first);
            while next < end {
                let length = (end - next).min(CHUNK as u64) as usize;
                self.fill(&mut generator, cell, &mut preloads[..length], &mut static_frictions[..length]);
                visit(Samples { preloads: &preloads[..length], static_frictions: &static_frictions[..length] });
                next += length as u64;
            }
        }
    }

    fn generator(&self, cell: &Cell, block: u64) -> Xoshiro256PlusPlus {
        if self.common_random_numbers {
            block_generator(self.seed, Purpose::CommonInputs, 0, block)
        } else {
            block_generator(self.seed, Purpose::Inputs, cell.index, block)
        }
    }

    fn skip(&self, generator: &mut Xoshiro256PlusPlus, samples: u64) {
        let inputs = u64::from(self.preload_is_random) + u64::from(self.static_friction_is_random);
        for _ in 0..samples * inputs {
            let _: f64 = generator.sample(StandardNormal);
        }
    }

    #[inline]
    fn fill(
        &self,
        generator: &mut Xoshiro256PlusPlus,
        cell: &Cell,
        preloads: &mut [f64],
        static_frictions: &mut [f64],
    ) {
        let mut deviate = || -> f64 { generator.sample(StandardNormal) };
        match (self.preload_is_random, self.static_friction_is_random) {
            (true, true) => {
                for (preload, static_friction) in preloads.iter_mut().zip(static_frictions.iter_mut()) {
                    *preload = deviate();
                    *static_friction = deviate();
                }
            }
            (true, false) => preloads.fill_with(deviate),
            (false, true) => static_frictions.fill_with(deviate),
            (false, false) => {}
        }
        if self.preload_is_random {
            perturb(preloads, cell.preload, cell.relative_std.preload);
        }
        if self.static_friction_is_random {
            perturb(static_frictions, cell.static_friction, cell.relative_std.static_friction);
        }
    }
}

/// Turns standard normal deviates into samples with the given expected value and relative standard deviation.
#[inline]
fn perturb(deviates: &mut [f64], expected: f64, relative_std: f64) {
    for deviate in deviates {
        *deviate = expected * (1.0 + relative_std * *deviate);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grid::RelativeStd;
    use crate::special_functions::normal;

    const CELL: Cell = Cell {
        index: 5,
        rotating_speed: 16.0,
        relative_std: RelativeStd { preload: 0.2, static_friction: 0.1 },
        preload: 0.1,
        static_friction: 0.39,
    };

    fn stream(preload_is_random: bool, static_friction_is_random: bool) -> SampleStream {
        SampleStream { seed: 2018, common_random_numbers: false, preload_is_random, static_friction_is_random }
    }

    fn draw(stream: &SampleStream, cell: &Cell, range: Range<u64>) -> Vec<(f64, f64)> {
        let mut all = Vec::new();
        stream.for_each(cell, range, |samples| {
            all.extend(samples.preloads.iter().copied().zip(samples.static_frictions.iter().copied()));
        });
        all
    }

    #[test]
    fn a_sample_does_not_depend_on_the_range_it_is_drawn_in() {
        let stream = stream(true, true);
        let whole = draw(&stream, &CELL, 0..5321);
        assert_eq!(whole.len(), 5321);
        for (start, end) in [(0, 1), (999, 1001), (1, 5321), (2000, 3000), (3333, 3334), (250, 750), (4000, 4000)] {
            assert_eq!(draw(&stream, &CELL, start..end), whole[start as usize..end as usize], "{start}..{end}");
        }
    }

    #[test]
    fn an_input_that_is_not_random_keeps_its_expected_value() {
        assert!(draw(&stream(true, false), &CELL, 0..100).iter().all(|s| s.1 == 0.39 && s.0 != 0.1));
        assert!(draw(&stream(false, true), &CELL, 0..100).iter().all(|s| s.0 == 0.1 && s.1 != 0.39));
        assert!(draw(&stream(false, false), &CELL, 0..100).iter().all(|s| *s == (0.1, 0.39)));
    }

    #[test]
    fn cells_share_deviates_only_when_asked() {
        let other = Cell { index: 6, ..CELL };
        let mut stream = stream(true, true);
        assert_ne!(draw(&stream, &CELL, 0..10), draw(&stream, &other, 0..10));
        stream.common_random_numbers = true;
        assert_eq!(draw(&stream, &CELL, 0..10), draw(&stream, &other, 0..10));
    }

    #[test]
    fn deviates_are_standard_normal() {
        // Kolmogorov-Smirnov against the normal distribution function, and the correlation of the two inputs.
        let samples = draw(&stream(true, true), &CELL, 0..200_000);
        let n = samples.len() as f64;
        let z1: Vec<f64> = samples.iter().map(|s| (s.0 / 0.1 - 1.0) / 0.2).collect();
        let z2: Vec<f64> = samples.iter().map(|s| (s.1 / 0.39 - 1.0) / 0.1).collect();
        for z in [&z1, &z2] {
            let mut sorted = z.clone();
            sorted.sort_by(f64::total_cmp);
            let distance = sorted
                .iter()
                .enumerate()
                .map(|(i, &z)| {
                    let expected = 1.0 - normal::upper_tail(z);
                    (expected - i as f64 / n).abs().max((expected - (i + 1) as f64 / n).abs())
                })
                .fold(0.0, f64::max);
            assert!(distance < 1.95 / n.sqrt(), "Kolmogorov-Smirnov distance {distance}");
        }
        let correlation = z1.iter().zip(&z2).map(|(a, b)| a * b).sum::<f64>() / n;
        assert!(correlation.abs() < 4.0 / n.sqrt(), "{correlation}");
    }

    #[test]
    fn the_first_samples_are_pinned() {
        // Regression values of results version 1.
        let samples = draw(&stream(true, true), &CELL, 0..2);
        assert_eq!(samples, [(0.10587119816196054, 0.39956993861776635), (0.10425970504497373, 0.39502072427012086)]);
        let mut digest = blake3::Hasher::new();
        for (preload, static_friction) in draw(&stream(true, true), &CELL, 0..1_000_000) {
            digest.update(&preload.to_le_bytes());
            digest.update(&static_friction.to_le_bytes());
        }
        assert_eq!(
            digest.finalize().to_hex().as_str(),
            "741a4286eef692db97fdf4336b27f4fea74853a6fae742e77f10867421ebff78"
        );
    }
}
