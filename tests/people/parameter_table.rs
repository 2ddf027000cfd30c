//! docs/your-brake-in-numbers.md knows every parameter of the brake, and its tables of what ten per cent do are what
//! the program computes.
//!
//! `STICKSLIP_UPDATE=1 cargo test -p stickslip --test people parameter_table` writes the tables again.

#![allow(clippy::unwrap_used, clippy::panic, reason = "a test that cannot go on should say so and stop")]

use std::fs;
use std::thread;

use crate::common::{BOTH, EIGENVALUE, Place, repository, submitted};
use serde_json::Value;

const PAGE: &str = "docs/your-brake-in-numbers.md";
const BEGIN: &str = "<!-- ten per cent -->\n";
const END: &str = "<!-- end -->";

/// A measured curve has to be there before it can be shifted.
const WITHOUT_ROW: &str = "friction.band";

fn page() -> String {
    fs::read_to_string(repository().join(PAGE)).unwrap()
}

fn parameters(place: &Place) -> Vec<Value> {
    let listed: Value = serde_json::from_str(&place.run("parameters --json").done().stdout).unwrap();
    let all = listed["parameters"].as_array().unwrap().iter();
    all.filter(|parameter| parameter["preset"].is_number()).cloned().collect()
}

fn text<'a>(parameter: &'a Value, key: &str) -> &'a str {
    parameter[key].as_str().unwrap()
}

/// What a brake does: as numbers, and with the digits of the table.
struct Response {
    probability: f64,
    critical_speed: f64,
    saddle_node: f64,
    growth: f64,
}

impl Response {
    fn cells(&self) -> [String; 4] {
        [
            format!("{:.2}", self.probability),
            format!("{:.2}", self.critical_speed),
            format!("{:.1}", self.saddle_node),
            format!("{:.0}", self.growth),
        ]
    }
}

/// The preset with one parameter at other values.
fn responses(place: &Place, key: &str, values: &[f64]) -> Vec<Response> {
    let name = format!("{}-{}", key.replace('.', "-"), values.len());
    let job = format!(
        "name = \"{name}\"\n[axes]\n\"{key}\" = {values:?}\n[random]\n{BOTH}\n[criterion]\n{EIGENVALUE}\n[sampling]\nmethod = \"exact\"\n"
    );
    let surface = submitted(place, &name, &job);
    let probabilities = surface.column("p_unstable");
    assert_eq!(probabilities.len(), values.len());
    let analyse = |value: &f64| -> Value {
        let analysed = place.run(&format!("analyse --json --set {key}={value:?}")).done();
        serde_json::from_str(&analysed.stdout).unwrap()
    };
    // At the same time, as debug builds take seconds.
    let analysed: Vec<Value> = thread::scope(|scope| {
        let running: Vec<_> = values.iter().map(|value| scope.spawn(move || analyse(value))).collect();
        running.into_iter().map(|analysed| analysed.join().unwrap()).collect()
    });
    let of = |(analysed, &probability): (Value, &f64)| Response {
        probability,
        critical_speed: analysed["critical_speed_rad_s"].as_f64().unwrap(),
        saddle_node: analysed["saddle_node_speed_rad_s"].as_f64().unwrap(),
        growth: analysed["coupled_growth_rate_per_s"].as_f64().unwrap(),
    };
    analysed.into_iter().zip(probabilities).map(of).collect()
}

/// A growth rate that differs by more than this is shown, where nothing else differs.
const LEAST_GROWTH: f64 = 2.0;

/// The tables, with the strongest effects first: of parameters that change what a rigid disc shows, and of those that
/// change the growth on a flexible disc alone.
fn tables(place: &Place) -> String {
    let preset = responses(place, "operating_point.preload", &[0.1]).remove(0);
    let (growth_of_preset, preset) = (preset.growth.round(), preset.cells());
    let mut rows: Vec<(f64, f64, bool, String)> = Vec::new();
    for parameter in parameters(place).iter().filter(|parameter| text(parameter, "key") != WITHOUT_ROW) {
        let (key, value) = (text(parameter, "key"), parameter["preset"].as_f64().unwrap());
        let ends = match key {
            _ if value == 0.0 => [0.0, 0.01],
            // It ends at the edge of the disc.
            "pad.effective_radius" => [0.9 * value, value],
            _ => [0.9 * value, 1.1 * value],
        };
        let [lower, higher] = <[Response; 2]>::try_from(responses(place, key, &ends)).ok().unwrap();
        let (low, high) = (lower.cells(), higher.cells());
        let is_same: Vec<bool> = (0..preset.len()).map(|i| low[i] == preset[i] && high[i] == preset[i]).collect();
        let is_growth_alone = is_same[..preset.len() - 1].iter().all(|same| *same);
        let grows = [&lower, &higher].map(|of| (of.growth.round() - growth_of_preset).abs());
        if is_growth_alone && grows[0].max(grows[1]) <= LEAST_GROWTH {
            continue;
        }
        let first = if is_growth_alone { preset.len() - 1 } else { 0 };
        let cells = (first..preset.len())
            .map(|i| if is_same[i] { "same".to_owned() } else { format!("{} / {}", low[i], high[i]) });
        let row = format!("| `{key}` | {} |\n", cells.collect::<Vec<_>>().join(" | "));
        let effects = (lower.probability - higher.probability, lower.growth - higher.growth);
        // Probabilities that differ by rounding only are the same.
        rows.push(((effects.0.abs() * 1e6).round(), effects.1.abs(), is_growth_alone, row));
    }
    rows.sort_by(|a, b| (b.0, b.1).partial_cmp(&(a.0, a.1)).unwrap());
    let [p, critical, saddle_node, growth] = preset;
    let head = format!(
        "| parameter, -10 % / +10 % | probability P ({p}) | critical speed ({critical} rad/s) | saddle-node ({saddle_node} rad/s) | growth, flexible disc ({growth} 1/s) |\n|---|---|---|---|---|\n"
    );
    let those = |alone: bool| rows.iter().filter(|row| row.2 == alone).map(|row| row.3.as_str()).collect::<String>();
    format!(
        "\n{head}{}\nThese change the growth on a flexible disc alone; parameters in neither table change it by at most \
         {LEAST_GROWTH} 1/s:\n\n| parameter, -10 % / +10 % | growth, flexible disc ({growth} 1/s) |\n|---|---|\n{}\n",
        those(false),
        those(true)
    )
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn what_ten_per_cent_do_is_what_the_program_computes() {
    let (before, rest) = page().split_once(BEGIN).map(|(a, b)| (a.to_owned(), b.to_owned())).unwrap();
    let (shown, after) = rest.split_once(END).unwrap();
    let computed = tables(&Place::new());
    if std::env::var_os("STICKSLIP_UPDATE").is_some() {
        fs::write(repository().join(PAGE), format!("{before}{BEGIN}{computed}{END}{after}")).unwrap();
        return;
    }
    assert_eq!(shown, computed, "{PAGE}: run this test with STICKSLIP_UPDATE=1");
}

#[test]
fn every_parameter_is_explained_with_its_symbol_unit_and_value() {
    let page = page();
    for parameter in parameters(&Place::new()) {
        let (key, symbol, unit) = (text(&parameter, "key"), text(&parameter, "symbol"), text(&parameter, "unit"));
        let start = format!("| `{key}`, {symbol} | ");
        let row = page.lines().find_map(|line| line.strip_prefix(&start));
        let row = row.unwrap_or_else(|| panic!("{PAGE}: no row begins with {start}"));
        let cells: Vec<&str> = row.split(" | ").collect();
        let (value, shown_unit) = cells[0].split_once(' ').unwrap_or((cells[0], "1"));
        let (value, preset) = (value.parse::<f64>().unwrap(), parameter["preset"].as_f64().unwrap());
        assert!((value - preset).abs() <= 1e-5 * preset, "{PAGE}: {key} = {value}, in the preset {preset}");
        assert_eq!(shown_unit, unit, "{PAGE}: unit of {key}");
        assert!(cells.len() == 3 && cells.iter().all(|cell| !cell.is_empty()), "{PAGE}: {key}: {cells:?}");
    }
}
