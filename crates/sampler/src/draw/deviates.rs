//! Standard normal deviates for any number of random inputs, by random numbers or by scrambled Sobol points.

use std::ops::Range;

use rand::RngExt;
use rand_distr::StandardNormal;

use crate::draw::identity::{BLOCK_SAMPLES, Purpose, block_generator};
use crate::draw::sobol::ScrambledSobol;
use crate::special_functions::normal;

/// Where deviates come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Points {
    /// Independent random numbers, as in [`SampleStream`](crate::draw::samples::SampleStream): with two inputs the same deviates.
    Random,
    /// The second, independent set of the same cell, for Sobol indices.
    SecondRandom,
    /// Scrambled Sobol points, mapped by the quantile of the normal distribution.
    Sobol,
}

/// The deviates of a job: those of a sample are a pure function of the seed, the cell (unless all cells share them) and the
/// sample's number.
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
    /// The deviates of samples `range` of a cell, sample by sample, [`DeviateStream::dimensions`] of each. `randomisation`
    /// says which scrambling of the Sobol points; random numbers have none.
    #[must_use]
    pub fn draw(&self, cell: u64, randomisation: u64, range: Range<u64>) -> Vec<f64> {
        let samples = (range.end - range.start) as usize;
        let mut deviates = vec![0.0; samples * self.dimensions];
        if self.dimensions == 0 {
            return deviates;
        }
        let cell = if self.common_random_numbers { 0 } else { cell };
        match self.points {
            Points::Random => {
                self.draw_random(self.purpose(Purpose::Inputs, Purpose::CommonInputs), cell, range, &mut deviates);
            }
            Points::SecondRandom => {
                self.draw_random(
                    self.purpose(Purpose::Sensitivity, Purpose::CommonSensitivity),
                    cell,
                    range,
                    &mut deviates,
                );
            }
            Points::Sobol => {
                let purpose = self.purpose(Purpose::Scrambling, Purpose::CommonScrambling);
                let sobol =
                    ScrambledSobol::new(self.dimensions, &mut block_generator(self.seed, purpose, cell, randomisation));
                let mut cursor = sobol.cursor(range.start);
                for point in deviates.chunks_exact_mut(self.dimensions) {
                    cursor.next_point(point);
                    for coordinate in point {
                        *coordinate = normal::quantile(*coordinate);
                    }
                }
            }
        }
        deviates
    }

    fn purpose(&self, own: Purpose, common: Purpose) -> Purpose {
        if self.common_random_numbers { common } else { own }
    }

    fn draw_random(&self, purpose: Purpose, cell: u64, range: Range<u64>, deviates: &mut [f64]) {
        let mut rest = deviates;
        let mut next = range.start;
        while next < range.end {
            let block = next / BLOCK_SAMPLES;
            let end = range.end.min((block + 1) * BLOCK_SAMPLES);
            let mut generator = block_generator(self.seed, purpose, cell, block);
            for _ in 0..(next - block * BLOCK_SAMPLES) * self.dimensions as u64 {
                let _: f64 = generator.sample(StandardNormal);
            }
            let (mine, others) = rest.split_at_mut((end - next) as usize * self.dimensions);
            mine.fill_with(|| generator.sample(StandardNormal));
            rest = others;
            next = end;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::draw::samples::SampleStream;
    use crate::grid::{Cell, RelativeStd};

    const STREAM: DeviateStream =
        DeviateStream { seed: 11, common_random_numbers: false, dimensions: 2, points: Points::Random };

    #[test]
    fn two_inputs_draw_what_the_sample_stream_draws() {
        let relative_std = RelativeStd { preload: 0.2, static_friction: 0.3 };
        let cell = Cell { index: 5, rotating_speed: 15.0, relative_std, preload: 0.1, static_friction: 0.4 };
        for common_random_numbers in [false, true] {
            let stream = SampleStream {
                seed: 11,
                common_random_numbers,
                preload_is_random: true,
                static_friction_is_random: true,
            };
            let mut expected = Vec::new();
            stream.for_each(&cell, 900..2100, |samples| {
                for (preload, static_friction) in samples.preloads.iter().zip(samples.static_frictions) {
                    expected.extend([*preload, *static_friction]);
                }
            });
            let deviates = DeviateStream { common_random_numbers, ..STREAM }.draw(5, 0, 900..2100);
            let samples: Vec<f64> =
                deviates.chunks_exact(2).flat_map(|z| [0.1 * (1.0 + 0.2 * z[0]), 0.4 * (1.0 + 0.3 * z[1])]).collect();
            assert_eq!(samples, expected);
        }
    }

    #[test]
    fn a_sample_is_the_same_whatever_range_it_is_drawn_in() {
        for points in [Points::Random, Points::SecondRandom, Points::Sobol] {
            for dimensions in [1, 2, 5] {
                let stream = DeviateStream { dimensions, points, ..STREAM };
                let whole = stream.draw(3, 2, 0..3000);
                for (from, to) in [(0, 1), (999, 1001), (1500, 2999), (2999, 3000)] {
                    let part = stream.draw(3, 2, from..to);
                    assert_eq!(part, whole[from as usize * dimensions..to as usize * dimensions], "{points:?}");
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
}
