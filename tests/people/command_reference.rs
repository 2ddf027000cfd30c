//! What docs/reference/command-line.md promises: its table has every command, and its sections have every key of
//! `--json`. Options are left to `stickslip COMMAND --help`; `crates/runner/src/help.rs` tests that each says what it
//! does.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::fs;

use serde_json::Value;

use crate::common::{Place, commands_of_the_program, repository, surface_job};

/// The text of the page.
fn page() -> String {
    fs::read_to_string(repository().join("docs/reference/command-line.md")).unwrap()
}

/// What stands below a heading, up to the next one.
fn section(page: &str, heading: &str) -> String {
    let is_wanted = |line: &str| line.starts_with('#') && line.trim_start_matches('#').trim() == heading;
    let below = page.lines().skip_while(|line| !is_wanted(line)).skip(1);
    below.take_while(|line| !line.starts_with('#')).collect::<Vec<_>>().join("\n")
}

/// Objects whose keys are names of axes, parameters or inputs.
const BY_NAME: [&str; 6] = ["at", "estimates", "from_job", "derivatives", "critical_values", "parameters"];

/// What another section or page describes.
const ELSEWHERE: [&str; 4] = ["decision", "job", "largest", "limits"];

/// Asserts that a text names every key of an object, of those within it, and of the first entry of each list. A quantity
/// in several units may stand there by its name alone.
#[track_caller]
fn assert_names(text: &str, value: &Value) {
    let is_named = |key: &str| text.contains(&format!("`{key}`"));
    if let Some(first) = value.get(0) {
        assert_names(text, first);
    }
    for (key, value) in value.as_object().into_iter().flatten() {
        let in_any_unit = ["_rad_s", "_m_s", "_mm"].iter().filter_map(|unit| key.strip_suffix(*unit)).any(is_named);
        assert!(is_named(key) || in_any_unit, "docs/reference/command-line.md does not have {key}: {text}");
        match value.as_object().filter(|_| BY_NAME.contains(&key.as_str())) {
            Some(named) => named.values().for_each(|value| assert_names(text, value)),
            None if ELSEWHERE.contains(&key.as_str()) => (),
            None => assert_names(text, value),
        }
    }
}

#[test]
fn the_table_has_every_command_in_the_order_of_help() {
    let table = section(&page(), "Commands");
    let rows = table.lines().filter_map(|row| row.strip_prefix("| `")?.split([' ', '`']).next());
    assert_eq!(rows.collect::<Vec<_>>(), commands_of_the_program(&Place::new()));
}

#[test]
fn the_page_has_every_key_that_json_has() {
    let page = page();
    let place = Place::new();
    place.write("job.toml", &surface_job("keys", 2, 100, 7));
    place.write(
        "tests.csv",
        "rotating_speed,preload,squealed,count\n14,0.1,1,35\n14,0.1,0,5\n16,0.1,1,19\n16,0.1,0,21\n",
    );
    for name in ["belt-oscillator", "hulten"] {
        place.run(&format!("init --from {name}")).done();
    }
    let answer = |command: &str| -> Value {
        let said: Value = serde_json::from_str(&place.run(&format!("{command} --json")).done().stdout).unwrap();
        // Of a list, its first entry.
        said.get(0).cloned().unwrap_or(said)
    };

    let submitted = answer("submit job.toml --at preload=0.03 --at static_friction=0.27 --target 0.1");
    assert!(submitted.is_object() && submitted["decision"].is_object(), "{submitted}");
    assert_names(&section(&page, "submit"), &submitted);
    assert_names(&section(&page, "The decision for programs"), &submitted["decision"]);
    answer("submit job.toml --out other");
    for (heading, command) in [
        ("status", "status runs/keys"),
        ("status", "status"),
        ("check", "check job.toml"),
        ("parameters", "parameters"),
        ("analyse", "analyse"),
        ("analyse", "analyse belt-oscillator.toml"),
        ("analyse", "analyse hulten.toml"),
        ("trajectory", "trajectory --disc rigid --horizon 50"),
        ("compare", "compare runs/keys other"),
        ("fit", "fit tests.csv --job job.toml"),
        ("limit", "limit job.toml --of preload --probability 0.5"),
        ("verify", "verify runs/keys"),
    ] {
        assert_names(&section(&page, heading), &answer(command));
    }
    let of_a_motion = ["replay", "trajectory"].map(|heading| section(&page, heading)).join("\n");
    assert_names(&of_a_motion, &answer("replay runs/keys --cell 0 --sample 0"));
}
