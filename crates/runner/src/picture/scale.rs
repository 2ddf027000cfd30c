//! Where values lie along an axis, and its ticks.

/// Least ratio of the ends of an axis that is drawn logarithmically.
const LEAST_RATIO: f64 = 10.0;

/// Space around a range, over the range, and the least range of values, over the largest of them.
const SPACE: f64 = 0.05;
const LEAST_SPAN: f64 = 1e-6;

/// The scale of an axis.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Scale {
    from: f64,
    to: f64,
    is_logarithmic: bool,
}

/// A tick: its value, and what is written at it.
#[derive(Debug, Clone, PartialEq)]
pub struct Tick {
    pub value: f64,
    pub label: String,
}

/// The least and the greatest of some values; infinity and minus infinity if there are none.
pub fn ends(values: impl Iterator<Item = f64>) -> [f64; 2] {
    values.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], value| [low.min(value), high.max(value)])
}

impl Scale {
    /// From one value to another.
    pub fn linear(from: f64, to: f64) -> Self {
        let (from, to) = (from.min(to), from.max(to));
        // An axis of one value is as wide as the value.
        let around = if from == to { if from == 0.0 { 1.0 } else { 0.5 * from.abs() } } else { 0.0 };
        Self { from: from - around, to: to + around, is_logarithmic: false }
    }

    /// From one positive value to another, equal ratios as equal distances.
    pub fn logarithmic(from: f64, to: f64) -> Self {
        Self { from: from.min(to), to: from.max(to), is_logarithmic: true }
    }

    /// The range of values with some space around it. Values that hardly differ are drawn as one.
    pub fn around(values: impl Iterator<Item = f64>) -> Self {
        let [low, high] = ends(values.filter(|value| value.is_finite()));
        if low > high {
            return Self::linear(0.0, 1.0);
        }
        if high - low <= LEAST_SPAN * low.abs().max(high.abs()) {
            // Not quite in the middle, which lies between two dots of a terminal: a constant would waver there.
            let Self { from, to, .. } = Self::linear(low, low);
            return Self { from, to: to + 0.02 * (to - from), is_logarithmic: false };
        }
        let space = SPACE * (high - low);
        Self::linear(low - space, high + space)
    }

    /// The scale that the values of an axis of a job were made with: logarithmic where neighbours have one ratio.
    pub fn for_values(values: &[f64]) -> Self {
        let (Some(&first), Some(&last)) = (values.first(), values.last()) else { return Self::linear(0.0, 1.0) };
        let (low, high) = (first.min(last), first.max(last));
        let step = libm::pow(last / first, 1.0 / (values.len().max(2) - 1) as f64);
        let is_geometric = || values.windows(2).all(|pair| (pair[1] / pair[0] / step - 1.0).abs() < 1e-6);
        if values.len() > 2 && low > 0.0 && high >= LEAST_RATIO * low && is_geometric() {
            Self { from: low, to: high, is_logarithmic: true }
        } else {
            Self::linear(first, last)
        }
    }

    /// The same with space for cells about the values: half a step more at each end.
    pub fn with_cells(values: &[f64]) -> Self {
        let scale = Self::for_values(values);
        let [.., before, last] = values else { return scale };
        let (Some(first), Some(second)) = (values.first(), values.get(1)) else { return scale };
        // Half a step beyond a value, seen from its neighbour.
        let beyond = |neighbour: f64, end: f64| {
            if scale.is_logarithmic { end * libm::sqrt(end / neighbour) } else { end + 0.5 * (end - neighbour) }
        };
        let ends = [beyond(*second, *first), beyond(*before, *last)];
        Self { from: ends[0].min(ends[1]), to: ends[0].max(ends[1]), ..scale }
    }

    /// Whether equal ratios are equal distances.
    pub fn is_logarithmic(&self) -> bool {
        self.is_logarithmic
    }

    /// Where a value lies: 0 at the beginning, 1 at the end.
    pub fn at(&self, value: f64) -> f64 {
        if self.is_logarithmic {
            libm::log(value / self.from) / libm::log(self.to / self.from)
        } else {
            (value - self.from) / (self.to - self.from)
        }
    }

    /// The value at a place: the inverse of [`Scale::at`].
    pub fn value(&self, at: f64) -> f64 {
        if self.is_logarithmic {
            self.from * libm::exp(at * libm::log(self.to / self.from))
        } else {
            self.from + at * (self.to - self.from)
        }
    }

    /// At most `most` ticks at round values, and the power of ten that their labels are to be multiplied with.
    pub fn ticks(&self, most: usize) -> (Vec<Tick>, i32) {
        if self.is_logarithmic {
            return (self.decades(most), 0);
        }
        let rough = (self.to - self.from) / most.max(1) as f64;
        let decade = libm::pow(10.0, libm::log10(rough).floor());
        let step = [1.0, 2.0, 5.0, 10.0].map(|factor| factor * decade);
        let step = step.into_iter().find(|step| *step >= rough * (1.0 - 1e-9)).unwrap_or(10.0 * decade);
        let largest = self.from.abs().max(self.to.abs());
        let power = libm::log10(largest).floor() as i32;
        // Small steps would have long labels.
        let is_small = power == -2 && step < 0.0099;
        let power = if (-2..4).contains(&power) && !is_small { 0 } else { 3 * power.div_euclid(3) };
        let unit = power_of_ten(power);
        let decimals = (0..12).find(|&decimals| {
            let scaled = step / unit * power_of_ten(decimals);
            (scaled - scaled.round()).abs() < 1e-6 * scaled
        });
        let decimals = decimals.unwrap_or(3) as usize;
        let (first, last) = ((self.from / step - 1e-9).ceil() as i64, (self.to / step + 1e-9).floor() as i64);
        let tick = |count: i64| {
            let value = count as f64 * step;
            // Minus zero would be written with its sign.
            Tick { value, label: format!("{:.decimals$}", value / unit + 0.0) }
        };
        ((first..=last).map(tick).collect(), power)
    }

    /// Powers of ten, and their multiples by 2 and 5 where there are few.
    fn decades(&self, most: usize) -> Vec<Tick> {
        let (first, last) = (libm::log10(self.from).floor() as i32, libm::log10(self.to).ceil() as i32);
        let within = |factors: &[f64], every: i32| -> Vec<Tick> {
            (first..=last)
                .filter(|decade| decade.rem_euclid(every) == 0)
                .flat_map(|decade| factors.iter().map(move |factor| (decade, factor * power_of_ten(decade))))
                .filter(|(_, value)| (-1e-9..=1.0 + 1e-9).contains(&self.at(*value)))
                .map(|(decade, value)| Tick { value, label: short(value, decade) })
                .collect()
        };
        let several = within(&[1.0, 2.0, 5.0], 1);
        if several.len() <= most {
            return several;
        }
        (1..).map(|every| within(&[1.0], every)).find(|ticks| ticks.len() <= most.max(2)).unwrap_or_default()
    }
}

/// A round value in as few characters as it takes.
fn short(value: f64, decade: i32) -> String {
    if (-3..4).contains(&decade) {
        format!("{:.*}", usize::try_from(-decade).unwrap_or(0), value)
    } else {
        let mantissa = (value / power_of_ten(decade)).round();
        let exponent = superscript(decade);
        if mantissa == 1.0 { format!("10{exponent}") } else { format!("{mantissa}·10{exponent}") }
    }
}

fn power_of_ten(exponent: i32) -> f64 {
    libm::pow(10.0, f64::from(exponent))
}

/// A whole number in raised digits.
pub fn superscript(number: i32) -> String {
    let raised = |c: char| match c {
        '-' => '⁻',
        '1' => '¹',
        '2' => '²',
        '3' => '³',
        digit => char::from_u32('⁰' as u32 + digit as u32 - '0' as u32).unwrap_or(digit),
    };
    number.to_string().chars().map(raised).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn labels(scale: Scale, most: usize) -> (Vec<String>, i32) {
        let (ticks, power) = scale.ticks(most);
        (ticks.into_iter().map(|tick| tick.label).collect(), power)
    }

    #[test]
    fn ticks_are_round_values_inside_the_axis() {
        for (from, to, most, expected, power) in [
            (0.01, 0.3, 6, vec!["0.05", "0.10", "0.15", "0.20", "0.25", "0.30"], 0),
            (0.25, 0.5, 5, vec!["0.25", "0.30", "0.35", "0.40", "0.45", "0.50"], 0),
            (-1.0, 1.0, 4, vec!["-1.0", "-0.5", "0.0", "0.5", "1.0"], 0),
            (1e7, 5e7, 4, vec!["10", "20", "30", "40", "50"], 6),
            (2e-4, 8e-4, 3, vec!["200", "400", "600", "800"], -6),
            (-0.01, 0.015, 5, vec!["-10", "-5", "0", "5", "10", "15"], -3),
        ] {
            let (labels, found) = labels(Scale::linear(from, to), most);
            assert!(labels.len() <= most + 1, "{from} to {to}: {labels:?}");
            assert_eq!((labels, found), (expected.into_iter().map(str::to_owned).collect(), power));
        }
    }

    #[test]
    fn an_axis_with_a_constant_ratio_is_logarithmic() {
        let scale = Scale::for_values(&[1e6, 1e7, 1e8, 1e9]);
        assert_eq!(scale.at(1e6), 0.0);
        assert!((scale.at(libm::pow(10.0, 7.5)) - 0.5).abs() < 1e-12);
        assert_eq!(labels(scale, 5).0, ["10⁶", "10⁷", "10⁸", "10⁹"]);
        assert_eq!(labels(Scale::for_values(&[0.1, 1.0, 10.0]), 7).0, ["0.1", "0.2", "0.5", "1", "2", "5", "10"]);
        assert_eq!(Scale::for_values(&[1.0, 2.0, 3.0, 30.0]).at(15.5), 0.5);
    }

    #[test]
    fn cells_have_half_a_step_at_the_ends() {
        for (values, ends) in [
            ([1.0, 2.0, 3.0], [0.5, 3.5]),
            ([3.0, 2.0, 1.0], [0.5, 3.5]),
            ([1.0, 10.0, 100.0], [libm::sqrt(0.1), libm::sqrt(1e5)]),
        ] {
            let (scale, [from, to]) = (Scale::with_cells(&values), ends);
            assert!(scale.at(from).abs() < 1e-12 && (scale.at(to) - 1.0).abs() < 1e-12, "{values:?}");
        }
    }

    #[test]
    fn an_axis_of_one_value_has_a_width() {
        for value in [0.0, -2.0, 15.0] {
            assert_eq!(Scale::for_values(&[value]).at(value), 0.5, "{value}");
        }
    }
}
