//! SI numbers as text, with their units.

/// Four significant digits without an exponent between 1e-4 and 1e6, else with one.
pub fn significant(value: f64) -> String {
    let text = format!("{value:.3e}");
    let Some(exponent) = text.split_once('e').and_then(|(_, exponent)| exponent.parse::<i32>().ok()) else {
        return text;
    };
    match exponent {
        _ if value == 0.0 => "0".to_owned(),
        -4..=5 => format!("{value:.*}", usize::try_from(3 - exponent).unwrap_or(0)),
        _ => text,
    }
}

/// A frequency, in Hz or kHz.
pub fn frequency(hertz: f64) -> String {
    if hertz < 1e3 { format!("{} Hz", significant(hertz)) } else { format!("{} kHz", significant(1e-3 * hertz)) }
}

/// A force, in N or kN.
pub fn force(newtons: f64) -> String {
    if newtons.abs() < 1e3 {
        format!("{} N", significant(newtons))
    } else {
        format!("{} kN", significant(1e-3 * newtons))
    }
}

/// A time, in ms.
pub fn duration(seconds: f64) -> String {
    format!("{} ms", significant(1e3 * seconds))
}

/// A length, in mm.
pub fn length(metres: f64) -> String {
    format!("{} mm", significant(1e3 * metres))
}

/// A speed, in m/s.
pub fn speed(metres_per_second: f64) -> String {
    format!("{} m/s", significant(metres_per_second))
}

/// A growth rate, in 1/s.
pub fn growth_rate(per_second: f64) -> String {
    let sign = if per_second > 0.0 { "+" } else { "" };
    format!("{sign}{} 1/s", significant(per_second))
}

/// Two numbers as a range; one where they look alike.
pub fn range(from: f64, to: f64) -> String {
    let (from, to) = (significant(from), significant(to));
    if from == to { from } else { format!("{from} to {to}") }
}

/// A row of a table: what it is, in scaled units, in SI.
pub fn row(label: &str, scaled: &str, si: &str) -> String {
    format!("{}\n", format!("{label:<18} {scaled:<24} {si}").trim_end())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_four_digits_and_a_fitting_unit() {
        for (value, text) in [
            (0.0, "0"),
            (2.0, "2.000"),
            (-0.167_42, "-0.1674"),
            (1234.56, "1235"),
            (99.996, "100.0"),
            (0.9999e-4, "9.999e-5"),
            (1.0e-4, "0.0001000"),
            (2.5e7, "2.500e7"),
        ] {
            assert_eq!(significant(value), text);
        }
        assert_eq!(frequency(332.74), "332.7 Hz");
        assert_eq!(frequency(3694.0), "3.694 kHz");
        assert_eq!(force(35_097.5), "35.10 kN");
        assert_eq!(force(12.345), "12.35 N");
        assert_eq!(growth_rate(12.0), "+12.00 1/s");
        assert_eq!(growth_rate(f64::INFINITY), "+inf 1/s");
        assert_eq!(range(0.05, 0.31), "0.05000 to 0.3100");
        assert_eq!(range(34.0112, 34.0113), "34.01");
    }
}
