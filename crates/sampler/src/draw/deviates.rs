//! Standard normal deviates for any number of random inputs, from random numbers or from scrambled Sobol points.
//!
//! Deviates come in columns, one for each random input, and in chunks: a sample takes one deviate of each column, in
//! the order of the inputs.
//!
//! Random numbers are drawn sample by sample from the generator of the sample's block (see
//! [`identity`](super::identity)). They become normal by `rand_distr`'s ziggurat. Its rare tail and rejection steps
//! call `exp` and `ln`, which a build that enables `num-traits/std` (Parquet does) takes from the platform; golden values
//! in the tests, and a run without FMA and AVX2, guard that no result depends on it.

use std::ops::Range;

use rand::RngExt;
use rand_distr::StandardNormal;
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::draw::identity::{BLOCK_SAMPLES, Purpose, block_generator};
use crate::draw::sobol::ScrambledSobol;
use crate::special_functions::normal;

/// Samples of a chunk that fits into the first-level cache and fills vector registers.
pub const CHUNK_SAMPLES: usize = 250;

/// Where deviates come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Points {
    /// Independent random numbers.
    Random,
    /// The second, independent set of the same cell, for Sobol indices.
    SecondRandom,
    /// Scrambled Sobol points, mapped by the quantile of the normal distribution.
    Sobol,
}

/// The deviates of a job: those of a sample are a pure function of the seed, the cell (unless all cells share them) and
/// the sample's number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct DeviateStream {
    /// Seed of the job.
    pub seed: u64,
    /// Whether every cell draws the same deviates.
    pub common_random_numbers: bool,
    /// Random inputs.
    pub dimensions: usize,
    /// Where they come from.
    pub points: Points,
}

impl DeviateStream {
    /// The deviates of a cell from sample `first` on. `randomisation` says which scrambling of the Sobol points; random
    /// numbers have none.
    ///
    /// A start inside a block draws and drops the samples before it: less than one block.
    #[must_use]
    pub fn start(&self, cell: u64, randomisation: u64, first: u64) -> Deviates {
        let cell = if self.common_random_numbers { 0 } else { cell };
        let purpose = match (self.points, self.common_random_numbers) {
            (Points::Random, false) => Purpose::Inputs,
            (Points::Random, true) => Purpose::CommonInputs,
            (Points::SecondRandom, false) => Purpose::Sensitivity,
            (Points::SecondRandom, true) => Purpose::CommonSensitivity,
            (Points::Sobol, false) => Purpose::Scrambling,
            (Points::Sobol, true) => Purpose::CommonScrambling,
        };
        let source = match self.points {
            _ if self.dimensions == 0 => Source::Nothing,
            Points::Random | Points::SecondRandom => {
                let block = |block: u64| block_generator(self.seed, purpose, cell, block);
                let mut generator = block(first / BLOCK_SAMPLES);
                for _ in 0..first % BLOCK_SAMPLES * self.dimensions as u64 {
                    let _: f64 = generator.sample(StandardNormal);
                }
                Source::Generator { purpose, cell, generator }
            }
            Points::Sobol => {
                let mut generator = block_generator(self.seed, purpose, cell, randomisation);
                Source::Sobol(Box::new(ScrambledSobol::new(self.dimensions, &mut generator)))
            }
        };
        Deviates { seed: self.seed, dimensions: self.dimensions, next: first, source }
    }

    /// Hands the deviates of samples `range` of a cell to `visit`, in order and in chunks of columns. What `visit`
    /// makes of the columns is dropped.
    #[inline]
    pub fn for_each_chunk(
        &self,
        cell: u64,
        randomisation: u64,
        range: Range<u64>,
        mut visit: impl FnMut(&mut [Vec<f64>]),
    ) {
        let mut deviates = self.start(cell, randomisation, range.start);
        let mut columns = vec![Vec::with_capacity(CHUNK_SAMPLES); self.dimensions];
        let mut left = range.end.saturating_sub(range.start);
        while left > 0 {
            let samples = left.min(CHUNK_SAMPLES as u64);
            deviates.fill(samples as usize, &mut columns);
            visit(&mut columns);
            left -= samples;
        }
    }

    /// The deviates of samples `range` of a cell, sample by sample, [`DeviateStream::dimensions`] of each.
    #[must_use]
    pub fn draw(&self, cell: u64, randomisation: u64, range: Range<u64>) -> Vec<f64> {
        let mut deviates = Vec::with_capacity((range.end - range.start) as usize * self.dimensions);
        self.for_each_chunk(cell, randomisation, range, |columns| {
            let samples = columns.first().map_or(0, Vec::len);
            deviates.extend((0..samples).flat_map(|sample| columns.iter().map(move |column| column[sample])));
        });
        deviates
    }
}

/// The deviates of consecutive samples of one cell.
#[derive(Debug, Clone)]
pub struct Deviates {
    seed: u64,
    dimensions: usize,
    /// Number of the next sample.
    next: u64,
    source: Source,
}

#[derive(Debug, Clone)]
enum Source {
    Nothing,
    /// The generator of the block of the next sample.
    Generator {
        purpose: Purpose,
        cell: u64,
        generator: Xoshiro256PlusPlus,
    },
    Sobol(Box<ScrambledSobol>),
}

impl Deviates {
    /// Fills one column for each random input with the deviates of the next `samples` samples.
    ///
    /// # Panics
    /// If there are not as many columns as random inputs.
    #[inline]
    pub fn fill(&mut self, samples: usize, columns: &mut [Vec<f64>]) {
        assert_eq!(columns.len(), self.dimensions, "one column for each random input");
        columns.iter_mut().for_each(|column| column.resize(samples, 0.0));
        let first = self.next;
        self.next += samples as u64;
        match &mut self.source {
            Source::Nothing => {}
            Source::Generator { purpose, cell, generator } => {
                let mut filled = 0;
                while filled < samples {
                    let sample = first + filled as u64;
                    if sample.is_multiple_of(BLOCK_SAMPLES) {
                        *generator = block_generator(self.seed, *purpose, *cell, sample / BLOCK_SAMPLES);
                    }
                    let left_in_block = BLOCK_SAMPLES - sample % BLOCK_SAMPLES;
                    let end = samples.min(filled + left_in_block as usize);
                    fill_from(generator, columns, filled..end);
                    filled = end;
                }
            }
            Source::Sobol(sobol) => {
                let mut cursor = sobol.cursor(first);
                let mut point = vec![0.0; columns.len()];
                for sample in 0..samples {
                    cursor.next_point(&mut point);
                    for (column, &coordinate) in columns.iter_mut().zip(&point) {
                        column[sample] = normal::quantile(coordinate);
                    }
                }
            }
        }
    }
}

/// Draws samples `range` of the columns. One and two inputs are the usual cases, and the fastest.
#[inline]
fn fill_from(generator: &mut Xoshiro256PlusPlus, columns: &mut [Vec<f64>], range: Range<usize>) {
    let mut deviate = || -> f64 { generator.sample(StandardNormal) };
    match columns.len() {
        1 => columns[0][range].fill_with(deviate),
        2 => {
            if let [first, second] = columns {
                for (first, second) in first[range.clone()].iter_mut().zip(&mut second[range]) {
                    *first = deviate();
                    *second = deviate();
                }
            }
        }
        3 => fill_many::<3>(deviate, columns, range),
        4 => fill_many::<4>(deviate, columns, range),
        5 => fill_many::<5>(deviate, columns, range),
        6 => fill_many::<6>(deviate, columns, range),
        7 => fill_many::<7>(deviate, columns, range),
        8 => fill_many::<8>(deviate, columns, range),
        _ => {
            for sample in range {
                columns.iter_mut().for_each(|column| column[sample] = deviate());
            }
        }
    }
}

/// Draws sample by sample into one array, and from there to the columns: faster than writing to all columns in turn.
fn fill_many<const INPUTS: usize>(mut deviate: impl FnMut() -> f64, columns: &mut [Vec<f64>], range: Range<usize>) {
    const AT_ONCE: usize = 32;
    let mut drawn = [[0.0; INPUTS]; AT_ONCE];
    for first in range.clone().step_by(AT_ONCE) {
        let samples = AT_ONCE.min(range.end - first);
        drawn[..samples].as_flattened_mut().fill_with(&mut deviate);
        for (i, column) in columns.iter_mut().take(INPUTS).enumerate() {
            let column = &mut column[first..first + samples];
            column.iter_mut().zip(&drawn).for_each(|(to, from)| *to = from[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const STREAM: DeviateStream =
        DeviateStream { seed: 2018, common_random_numbers: false, dimensions: 2, points: Points::Random };

    #[test]
    fn a_sample_is_the_same_in_whatever_range_and_chunks_it_is_drawn() {
        for points in [Points::Random, Points::SecondRandom, Points::Sobol] {
            for dimensions in [1, 2, 5] {
                let stream = DeviateStream { dimensions, points, ..STREAM };
                let whole = stream.draw(3, 2, 0..3000);
                assert_eq!(whole.len(), 3000 * dimensions);
                for (from, to) in [(0, 1), (999, 1001), (1500, 2999), (2999, 3000), (250, 750), (2000, 2000)] {
                    let part = stream.draw(3, 2, from..to);
                    assert_eq!(part, whole[from as usize * dimensions..to as usize * dimensions], "{points:?}");
                }
                let mut columns = vec![Vec::new(); dimensions];
                let mut deviates = stream.start(3, 2, 700);
                for (first, samples) in [(700, 1500), (2200, 1), (2201, 799)] {
                    deviates.fill(samples, &mut columns);
                    for (i, column) in columns.iter().enumerate() {
                        let expected = (first..first + samples).map(|sample| whole[sample * dimensions + i]);
                        assert!(column.iter().copied().eq(expected), "{points:?}, {dimensions} inputs, from {first}");
                    }
                }
            }
        }
    }

    #[test]
    fn streams_of_different_purposes_and_cells_differ() {
        let mut firsts = Vec::new();
        for points in [Points::Random, Points::SecondRandom, Points::Sobol] {
            for common_random_numbers in [false, true] {
                for cell in [1, 2] {
                    let stream = DeviateStream { points, common_random_numbers, ..STREAM };
                    firsts.push((common_random_numbers, stream.draw(cell, 0, 0..1)));
                }
            }
        }
        for (i, (common, first)) in firsts.iter().enumerate() {
            let same = firsts.iter().filter(|(_, other)| other == first).count();
            assert_eq!(same, if *common { 2 } else { 1 }, "{i}: common numbers are those of every cell");
        }
    }

    #[test]
    fn deviates_are_standard_normal() {
        // Kolmogorov-Smirnov against the normal distribution function, and the correlation of the two inputs.
        let deviates = STREAM.draw(5, 0, 0..200_000);
        let n = deviates.len() as f64 / 2.0;
        let column = |i: usize| deviates.iter().skip(i).step_by(2).copied();
        for i in [0, 1] {
            let mut sorted: Vec<f64> = column(i).collect();
            sorted.sort_by(f64::total_cmp);
            let distance = sorted
                .iter()
                .enumerate()
                .map(|(i, &z)| {
                    let expected = normal::cumulative(z);
                    (expected - i as f64 / n).abs().max((expected - (i + 1) as f64 / n).abs())
                })
                .fold(0.0, f64::max);
            assert!(distance < 1.95 / n.sqrt(), "Kolmogorov-Smirnov distance {distance}");
        }
        let correlation = column(0).zip(column(1)).map(|(a, b)| a * b).sum::<f64>() / n;
        assert!(correlation.abs() < 4.0 / n.sqrt(), "{correlation}");
    }

    #[test]
    fn the_first_samples_are_pinned() {
        // Regression values of results version 1: inputs of expected values 0.1 and 0.39, relative standard deviations
        // 0.2 and 0.1.
        let samples: Vec<f64> = STREAM
            .draw(5, 0, 0..1_000_000)
            .chunks_exact(2)
            .flat_map(|z| [0.1 * (1.0 + 0.2 * z[0]), 0.39 * (1.0 + 0.1 * z[1])])
            .collect();
        assert_eq!(samples[..4], [0.10587119816196054, 0.39956993861776635, 0.10425970504497373, 0.39502072427012086]);
        let mut digest = blake3::Hasher::new();
        samples.iter().for_each(|sample| {
            digest.update(&sample.to_le_bytes());
        });
        let expected = "741a4286eef692db97fdf4336b27f4fea74853a6fae742e77f10867421ebff78";
        assert_eq!(digest.finalize().to_hex().to_string(), expected);
    }

    #[test]
    fn a_stream_is_drawn_for_its_own_purpose_and_no_other() {
        for (points, common_random_numbers, own) in [
            (Points::Random, false, Purpose::Inputs),
            (Points::Random, true, Purpose::CommonInputs),
            (Points::SecondRandom, false, Purpose::Sensitivity),
            (Points::SecondRandom, true, Purpose::CommonSensitivity),
            (Points::Sobol, false, Purpose::Scrambling),
            (Points::Sobol, true, Purpose::CommonScrambling),
        ] {
            let (cell, number) = (7, 3);
            let stream = DeviateStream { points, common_random_numbers, ..STREAM };
            let is_sobol = points == Points::Sobol;
            let first = if is_sobol { 0 } else { number * BLOCK_SAMPLES };
            let drawn = stream.draw(cell, number, first..first + 1);
            // Straight from the generator of each purpose.
            let of = |purpose: Purpose| -> Vec<f64> {
                let cell = if common_random_numbers { 0 } else { cell };
                let mut generator = block_generator(stream.seed, purpose, cell, number);
                if is_sobol {
                    let mut point = [0.0; 2];
                    ScrambledSobol::new(2, &mut generator).cursor(0).next_point(&mut point);
                    point.map(normal::quantile).to_vec()
                } else {
                    (0..2).map(|_| generator.sample(StandardNormal)).collect()
                }
            };
            for purpose in Purpose::ALL {
                assert_eq!(drawn == of(purpose), purpose == own, "{points:?} {common_random_numbers}: {purpose:?}");
            }
        }
    }

    #[test]
    fn each_input_has_deviates_of_its_own_in_the_order_of_the_generator() {
        for dimensions in 1..=11 {
            let stream = DeviateStream { dimensions, ..STREAM };
            let mut generator = block_generator(stream.seed, Purpose::Inputs, 4, 0);
            let expected: Vec<f64> = (0..100 * dimensions).map(|_| generator.sample(StandardNormal)).collect();
            assert_eq!(stream.draw(4, 0, 0..100), expected, "{dimensions} inputs");
        }
    }

    #[test]
    fn every_randomisation_scrambles_anew() {
        let stream = DeviateStream { points: Points::Sobol, ..STREAM };
        let drawn: Vec<Vec<f64>> = (0..8).map(|randomisation| stream.draw(1, randomisation, 0..4)).collect();
        for (i, one) in drawn.iter().enumerate() {
            assert!(drawn[..i].iter().all(|other| other != one), "{i}");
        }
    }
}
