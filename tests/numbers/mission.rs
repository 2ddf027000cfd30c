//! The mission of `jobs/mission.toml`: the largest preload for 1 % and 10 ppm, with eight random inputs.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use crate::common::{Place, Table, repository, submitted};

/// The mission at one speed, with fewer samples.
fn mission(place: &Place, sampling: &str) -> String {
    fs::copy(repository().join("jobs/mission-friction.csv"), place.path("mission-friction.csv")).unwrap();
    let text = fs::read_to_string(repository().join("jobs/mission.toml")).unwrap();
    let (before, after) = (text.find("[sampling]").unwrap(), text.find("[limit]").unwrap());
    let speeds = "rotating_speed = [10.0, 12.5, 15.0, 17.5, 20.0]";
    assert!(text.contains(speeds));
    let text = format!("{}[sampling]\n{sampling}\n\n{}", &text[..before], &text[after..]);
    text.replace(speeds, "rotating_speed = 15.0").replace("[0.005, 0.1] ", "[0.013, 0.023] ")
}

#[test]
fn limits_of_rare_events_are_where_other_samples_have_their_probability() {
    let place = Place::new();
    let text = mission(&place, "method = \"importance\"\nsamples = 1024\nparticles = 50\nseed = 1");
    place.write("mission.toml", &text);
    place.run("limit mission.toml --out limits.parquet").done();
    let limits = Table::read(&place.path("limits.parquet"));
    let [values, low, high] = ["limit", "limit_low", "limit_high"].map(|name| limits.column(name).to_vec());
    assert_eq!(limits.column("target"), [0.01, 1e-5]);
    // Regression values of jobs/mission.toml, as the guide shows them.
    for (value, shown) in values.iter().zip([0.019_281, 0.015_426]) {
        assert!((value / shown - 1.0).abs() < 5e-3, "{value}, {shown}");
    }
    for row in 0..2 {
        assert!(low[row] < values[row] && values[row] < high[row] && high[row] - low[row] < 0.02 * values[row]);
    }
    // Another seed and another method there.
    let at = |name: &str, sampling: &str| {
        let text = mission(&place, sampling);
        let text = text[..text.find("[limit]").unwrap()]
            .replace("[0.013, 0.023] ", &format!("[{}, {}] ", values[1], values[0]));
        submitted(&place, name, &text)
    };
    let again = at("again", "method = \"importance\"\nsamples = 2048\nparticles = 100\nseed = 2\nconfidence = 0.999");
    let counted = at("counted", "method = \"sobol\"\nsamples = 262_144\nconfidence = 0.999");
    for (row, target) in [(0, 1e-5), (1, 0.01)] {
        let [from, to] = ["p_low", "p_high"].map(|name| again.column(name)[row]);
        assert!(from * 0.95 <= target && target <= to * 1.05, "{row}: {from} {to}");
        let [from, to] = ["p_low", "p_high"].map(|name| counted.column(name)[row]);
        assert!(from <= target && target <= to, "{row}: {from} {to}");
    }
}
