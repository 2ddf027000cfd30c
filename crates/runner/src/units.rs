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

/// Units that people write behind numbers, in the unit that parameters have, and which that is.
const WRITTEN: [(&str, f64, &str); 17] = [
    ("rpm", std::f64::consts::PI / 30.0, "rad/s"),
    ("1/min", std::f64::consts::PI / 30.0, "rad/s"),
    ("rad/s", 1.0, "rad/s"),
    ("mm", 1e-3, "m"),
    ("cm", 1e-2, "m"),
    ("um", 1e-6, "m"),
    ("m", 1.0, "m"),
    ("m/s", 1.0, "m/s"),
    ("km/h", 1.0 / 3.6, "m/s"),
    ("N", 1.0, "N"),
    ("kN", 1e3, "N"),
    ("Pa", 1.0, "Pa"),
    ("MPa", 1e6, "Pa"),
    ("GPa", 1e9, "Pa"),
    ("kHz", 1e3, "Hz"),
    ("g", 1e-3, "kg"),
    ("kg", 1.0, "kg"),
];

/// What is wrong with a number that has its unit behind it; `None` of anything else.
pub fn number_with_unit(text: &str) -> Option<String> {
    let end = text.find(|c: char| !c.is_ascii_digit() && !"+-.eE_".contains(c))?;
    let (number, unit) = (text[..end].trim(), text[end..].trim());
    let value: f64 = number.replace('_', "").parse().ok()?;
    let is_unit = unit.starts_with(|c: char| c.is_alphabetic() || "°µ1".contains(c)) && unit.chars().count() <= 12;
    if !is_unit || unit.contains(['=', ',', '[', ']', '"']) {
        return None;
    }
    let same = WRITTEN.iter().find(|(name, ..)| *name == unit);
    let same = same.map_or(String::new(), |(_, factor, si)| {
        let value: f64 = format!("{:.8e}", value * factor).parse().unwrap_or(value);
        format!("; {number} {unit} = {value} {si}")
    });
    Some(format!("{text} has a unit; write the number alone, in the unit of the parameter{same}"))
}

/// What is wrong with a number with a comma, and what to write.
pub fn with_comma(number: &str) -> String {
    let decimal = number.replacen(',', ".", 1);
    let (whole, groups) = number.split_once(',').unwrap_or((number, ""));
    let digits = whole.trim_start_matches(['-', '+']);
    let are_digits = [digits, groups].iter().all(|part| part.bytes().all(|byte| byte.is_ascii_digit()));
    let has_thousands = are_digits && (1..=3).contains(&digits.len()) && !digits.starts_with('0') && groups.len() == 3;
    if has_thousands {
        format!(
            "{number} has a comma; write {whole}{groups} if it parts thousands, and {decimal} if it is a decimal comma"
        )
    } else {
        format!("{number} has a decimal comma; write {decimal}")
    }
}

/// What is wrong with a text that should be a number and cannot be read as one.
pub fn not_a_number(text: &str) -> String {
    if text.is_empty() {
        return "there is no number; write one, for example 0.4".to_owned();
    }
    let otherwise = [
        ("a dash that is no minus sign", text.replace(['−', '–', '—'], "-")),
        ("an underscore", text.replace('_', "")),
    ];
    if text.replacen(',', ".", 1).parse::<f64>().is_ok() {
        return with_comma(text);
    }
    if let Some((what, right)) = otherwise.iter().find(|(_, right)| right.parse::<f64>().is_ok()) {
        return format!("{text} has {what}; write {right}");
    }
    let percent = text.strip_suffix('%').and_then(|number| number.trim().parse::<f64>().ok());
    match percent {
        Some(percent) => format!("{text} is in per cent; write {}", hundredth(percent)),
        None => number_with_unit(text).unwrap_or_else(|| format!("{text:?} is not a number")),
    }
}

/// A hundredth of a number, with the digits that it has.
pub fn hundredth(number: f64) -> f64 {
    let hundredth = number / 100.0;
    format!("{hundredth:.12e}").parse().unwrap_or(hundredth)
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
    fn a_number_with_a_unit_is_told_from_other_words() {
        let said = number_with_unit("143rpm").unwrap();
        assert!(said.starts_with("143rpm has a unit; ") && said.ends_with("; 143 rpm = 14.974925 rad/s"), "{said}");
        assert!(number_with_unit("2 mm").unwrap().ends_with("; 2 mm = 0.002 m"));
        assert!(number_with_unit("3.5 furlongs").unwrap().ends_with("alone, in the unit of the parameter"));
        for text in ["143", "abc", "1e4", "0.1:0.2", "[1 2]", "1, 2 m", "2 = m"] {
            assert_eq!(number_with_unit(text), None, "{text}");
        }
    }

    #[test]
    fn what_is_no_number_is_answered_with_one() {
        for (text, said) in [
            ("", "there is no number; write one, for example 0.4"),
            ("0,4", "0,4 has a decimal comma; write 0.4"),
            ("0,125", "0,125 has a decimal comma; write 0.125"),
            ("-0,125", "-0,125 has a decimal comma; write -0.125"),
            ("1,5e3", "1,5e3 has a decimal comma; write 1.5e3"),
            ("20,000", "20,000 has a comma; write 20000 if it parts thousands, and 20.000 if it is a decimal comma"),
            ("−0.4", "−0.4 has a dash that is no minus sign; write -0.4"),
            ("1_000.5", "1_000.5 has an underscore; write 1000.5"),
            ("7 %", "7 % is in per cent; write 0.07"),
            ("40%", "40% is in per cent; write 0.4"),
            ("a tenth", "\"a tenth\" is not a number"),
            ("1/3", "\"1/3\" is not a number"),
        ] {
            assert_eq!(not_a_number(text), said);
        }
        assert!(not_a_number("143rpm").starts_with("143rpm has a unit; "));
    }

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
