//! The levels at which probabilities are drawn, and their colours.

use stickslip_sampler::special_functions::normal;

use crate::plot::canvas::Rgb;

/// Levels of probabilities that are not all small, and those that have a line with a label.
const LEVELS: [f64; 13] = [0.01, 0.05, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99];
const LINES: [f64; 4] = [0.01, 0.05, 0.5, 0.95];

/// Levels of small probabilities, all with a line.
const SMALL: [f64; 8] = [1e-9, 1e-8, 1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2];

/// A surface whose largest probability is below this has the levels of small ones.
const SMALL_BELOW: f64 = 0.02;

/// Probabilities beyond these are drawn as these.
const EXTREMES: (f64, f64) = (1e-12, 1.0 - 1e-12);

/// Fixed levels of probability.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Levels {
    levels: &'static [f64],
    lines: &'static [f64],
}

impl Levels {
    /// Those that show a surface with this largest probability.
    pub fn up_to(largest: f64) -> Self {
        if largest < SMALL_BELOW {
            Self { levels: &SMALL, lines: &SMALL }
        } else {
            Self { levels: &LEVELS, lines: &LINES }
        }
    }

    pub fn all(&self) -> &'static [f64] {
        self.levels
    }

    pub fn lines(&self) -> &'static [f64] {
        self.lines
    }

    /// The number of bands between the levels, the outer ones included.
    pub fn bands(&self) -> usize {
        self.levels.len() + 1
    }

    /// The band of a probability, from 0.
    pub fn band(&self, probability: f64) -> usize {
        self.levels.partition_point(|level| *level <= probability)
    }

    /// The colour of a band: pale where nothing is unstable, dark where everything is.
    pub fn colour(&self, band: usize) -> Rgb {
        let share = 1.0 - band as f64 / (self.bands() - 1) as f64;
        colorous::VIRIDIS.eval_continuous(share).as_tuple()
    }
}

/// A probability on the scale on which it changes steadily across a boundary that scatters: the normal deviate that it
/// is the distribution function of. Between the points of a grid, values on this scale are interpolated.
pub fn deviate(probability: f64) -> f64 {
    normal::quantile(probability.clamp(EXTREMES.0, EXTREMES.1))
}

/// A level as a label.
pub fn label(level: f64) -> String {
    if level < 1e-3 {
        let decade = libm::log10(level).round() as i32;
        format!("10{}", crate::picture::scale::superscript(decade))
    } else {
        level.to_string()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_probability_has_the_band_between_its_levels() {
        let levels = Levels::up_to(1.0);
        assert_eq!([0.0, 0.009, 0.01, 0.07, 0.99, 1.0].map(|p| levels.band(p)), [0, 0, 1, 2, 13, 13]);
        assert_eq!(levels.bands(), 14);
        assert_eq!(Levels::up_to(1e-4).band(3e-6), 4);
    }

    #[test]
    fn colours_grow_darker_with_the_probability() {
        for levels in [Levels::up_to(1.0), Levels::up_to(1e-3)] {
            let light = |band| {
                let (red, green, blue) = levels.colour(band);
                0.2126 * f64::from(red) + 0.7152 * f64::from(green) + 0.0722 * f64::from(blue)
            };
            assert!((1..levels.bands()).all(|band| light(band) < light(band - 1) - 3.0));
        }
    }

    #[test]
    fn levels_are_written_as_short_as_possible() {
        assert_eq!([0.01, 0.5, 0.95, 1e-3, 1e-6].map(label), ["0.01", "0.5", "0.95", "0.001", "10⁻⁶"]);
    }
}
