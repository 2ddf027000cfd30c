//! Plain samples beside probabilities that do not come from such.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use crate::common::{BOTH, EIGENVALUE, Place, Table, change_piece, job, submitted};
use serde_json::json;

/// Two masses whose modes couple with friction, with this method.
fn two_masses(name: &str, inputs: &str, sampling: &str) -> String {
    format!(
        "name = \"{name}\"\n[model]\nkind = \"matrices\"\nmass = {{ matrix = [[1, 0], [0, 1]] }}\n\
         damping = {{ matrix = [[0.001, 0], [0, 0.001]] }}\nstiffness = [{{ matrix = [[2, 1], [1, 2]], factor = \"k\" }}, \
         {{ matrix = [[0, -1.3333333333333333], [0, 0]], factor = \"friction\" }}]\n[model.parameters]\nfriction = 0.7\n\
         k = 1.0\n[random]\ninputs = [{inputs}]\nrelative_std = 0.1\n[criterion]\nkind = \"complex-eigenvalue\"\n\
         [sampling]\n{sampling}\n"
    )
}

/// Counts beside the probability of each method that does not count are those of samples, from a stream of their own.
#[test]
fn every_method_that_does_not_count_has_plain_samples() {
    let place = Place::new();
    for (name, inputs, sampling) in [
        ("exact", "\"friction\"", "method = \"exact\"\naudit = 5000\nseed = 3"),
        ("conditional", "\"friction\", \"k\"", "method = \"conditional\"\nsamples = 256\naudit = 5000\nseed = 3"),
        ("importance", "\"friction\", \"k\"", "method = \"importance\"\nsamples = 512\naudit = 5000\nseed = 3"),
        ("subset", "\"friction\", \"k\"", "method = \"subset\"\naudit = 5000\nseed = 3"),
    ] {
        let table = submitted(&place, name, &two_masses(name, inputs, sampling));
        let p = table.column("p_unstable")[0];
        let (decided, unstable) = (table.column("n_audit")[0], table.column("n_audit_unstable")[0]);
        assert_eq!(decided, 5000.0, "{name}");
        let error = (p * (1.0 - p) / decided).sqrt();
        assert!(p > 0.05 && (unstable / decided - p).abs() < 5.0 * error, "{name}: {unstable} {p}");
        assert_eq!(table.column("distrust"), [0.0], "{name}");
        // The closed form of the pad as well; and none where none are wanted.
        let without = submitted(&place, "without", &two_masses("without", inputs, &sampling.replace("5000", "0")));
        assert!(!without.names().iter().any(|column| column.starts_with("n_audit")));
        assert_eq!(without.column("p_unstable"), table.column("p_unstable"));
        place.run("verify without").done();
        std::fs::remove_dir_all(place.path("without")).unwrap();
    }
    let table = submitted(&place, "pad", &job("pad", EIGENVALUE, BOTH, "method = \"exact\"\nderivatives = true"));
    let expected: f64 = table.column("p_unstable").iter().map(|p| 300.0 * p).sum();
    let found: f64 = table.column("n_audit_unstable").iter().sum();
    assert!(found > 100.0 && (found - expected).abs() < 5.0 * expected.sqrt(), "{found} {expected}");
}

#[test]
fn plain_samples_that_contradict_a_probability_take_it_away() {
    let place = Place::new();
    let sampling = "method = \"exact\"\nseed = 3";
    submitted(&place, "two", &two_masses("two", "\"friction\"", sampling));
    // As if the integral had missed what the samples saw: they say that all is unstable.
    let piece = std::fs::read_dir(place.path("two/audit")).unwrap().next().unwrap().unwrap().path();
    change_piece(&piece, |lines| lines[1][3] = json!([0, 300, 0, 0]));
    std::fs::remove_file(place.path("two/surface.parquet")).unwrap();
    let outcome = place.run("resume two");
    assert!(outcome.stdout.contains("p_unstable is null in 1 cell: plain samples contradict"), "{}", outcome.stdout);
    outcome.refused(70, &["plain samples contradict the probability in 1 of 1 cell", "monte-carlo"]);
    let table = Table::read(&place.path("two/surface.parquet"));
    assert_eq!((table.column("distrust")[0], table.column("n_audit_unstable")[0]), (5.0, 300.0));
    assert!(table.column("p_unstable")[0].is_nan());
    place.run("plot two").refused(65, &["two has a single cell: its probability of instability is not known, only"]);
    place.run("report two --out two.html").done();
    let report = std::fs::read_to_string(place.path("two.html")).unwrap();
    assert!(report.contains("p_unstable is null in 1 cell: plain samples contradict p_low to p_high"));

    // It is compared with nothing.
    submitted(&place, "sound", &two_masses("sound", "\"friction\"", sampling));
    let compared = place.run("compare two sound --out compared.parquet").done();
    let said = "in 1 of 1 cells plain samples contradict the probability of two or sound";
    assert!(compared.stderr.contains(said), "{}", compared.stderr);
    let table = Table::read(&place.path("compared.parquet"));
    assert!(table.column("p_first")[0].is_nan() && table.column("p_second")[0] > 0.05);
    assert!(table.column("difference")[0].is_nan());
}

#[test]
fn plain_samples_do_not_depend_on_how_the_work_is_shared() {
    let place = Place::new();
    let sampling = "method = \"conditional\"\nsamples = 1024\naudit = 500_000\nseed = 5";
    let text = two_masses("shared", "\"friction\", \"k\"", sampling);
    submitted(&place, "whole", &text);
    place.run("submit whole.toml --out one --threads 1").done();
    for shard in 1..=2 {
        place.run(&format!("submit whole.toml --out shards --shard {shard}/2")).done();
    }
    place.run("merge shards").done();
    assert!(place.surface("whole") == place.surface("one") && place.surface("whole") == place.surface("shards"));
    for run in ["whole", "shards"] {
        place.run(&format!("verify {run}")).done();
    }
    place.write("job.toml", &text);
    place.assert_survives_kills("whole", &[200, 400, 700], 1);
}

/// A tenth of its samples by default: with more samples there are more of them, the same as if there had been so many from the
/// start.
#[test]
fn plain_samples_grow_with_the_samples_of_a_run() {
    let place = Place::new();
    let of = |sampling: &str| two_masses("job", "\"friction\", \"k\"", &format!("method = \"importance\"\n{sampling}"));
    for (name, sampling) in [
        ("few", "samples = 2048"),
        ("many", "samples = 8192"),
        ("many-audited", "samples = 8192\naudit = 400"),
        ("few-audited", "samples = 2048\naudit = 400"),
        ("more-less-audited", "samples = 16_384\naudit = 399"),
    ] {
        place.write(&format!("{name}.toml"), &of(sampling));
    }
    let decided = |run: &str| Table::read(&place.path(run).join("surface.parquet")).column("n_audit")[0];
    for (few, run, plain) in [("few", "grown", 819.0), ("few-audited", "grown-audited", 819.0)] {
        place.run(&format!("submit {few}.toml --out {run}")).done();
        assert!(decided(run) < 500.0);
        place.run(&format!("submit many.toml --out {run}")).done();
        assert_eq!(decided(run), plain);
        place.run(&format!("verify {run}")).done();
        place.run(&format!("submit many.toml --out whole-{run}")).done();
        assert!(place.surface(run) == place.surface(&format!("whole-{run}")), "{run}");
    }
    // Neither fewer of them nor other ones belong to it.
    for (other, said) in [("many-audited", "400"), ("more-less-audited", "399")] {
        let said = format!("grown holds a run of another job: the job has `sampling.audit = {said}`, the run does not");
        place.run(&format!("submit {other}.toml --out grown")).refused(65, &[&said]);
    }
    std::fs::remove_file(place.path("grown/job.toml")).unwrap();
    place
        .run("submit many-audited.toml --out grown")
        .refused(65, &["sample 818 of cell 0", "audit hold", "the job has only 400 plain samples"]);
    assert!(!place.path("grown/job.toml").exists());
    place.write("none.toml", &of("samples = 8192\naudit = 0"));
    place.run("submit none.toml --out grown").refused(65, &["audit hold", "the job has only 0 plain samples"]);
    place.run("submit many.toml --out grown").done();
    place.write("grown/job.toml", "damaged");
    place.run("submit many-audited.toml --out grown").refused(74, &["grown/job.toml was damaged or edited"]);
    place.run("submit many.toml --out grown").done();
    // Beside it, each number of them has a place of its own, where it goes on with more samples.
    place.write("other.toml", &of("samples = 2048\naudit = 500"));
    for name in ["few-audited", "many-audited", "other"] {
        let apart = place.run(&format!("submit {name}.toml --out whole-grown --apart")).done();
        assert!(apart.stderr.contains("whole-grown holds a run of another job; this one goes to"), "{}", apart.stderr);
    }
    let all = std::fs::read_dir(place.path("")).unwrap().map(|entry| entry.unwrap().file_name().into_string().unwrap());
    let beside = all.filter(|name| name.starts_with("whole-grown-") && name != "whole-grown-audited");
    let mut found: Vec<[f64; 2]> = beside
        .map(|run| Table::read(&place.path(&run).join("surface.parquet")))
        .map(|table| ["n_samples", "n_audit"].map(|name| table.column(name)[0]))
        .collect();
    found.sort_by(|a, b| a[0].total_cmp(&b[0]));
    assert_eq!(found, [[2048.0, 500.0], [8192.0, 400.0]]);
}

#[test]
fn a_share_is_no_number_of_plain_samples() {
    let place = Place::new();
    place.write("job.toml", &two_masses("job", "\"friction\"", "method = \"exact\"\naudit = 0.5"));
    place.run("submit job.toml").refused(65, &["sampling.audit = 0.5 is a share", "audit = 1000"]);
    place.write("job.toml", &two_masses("job", "\"friction\"", "audit = 500"));
    place.run("submit job.toml").refused(65, &["sampling.audit belongs to"]);
}

/// Two undamped modes of one frequency, of which friction couples one with the other: a double eigenvalue with a single vector,
/// which rounding splits into one that grows and one that decays. Nothing says where it is unstable.
#[test]
fn what_critical_values_leave_open_is_said_without_plain_samples_too() {
    let place = Place::new();
    let text = two_masses("open", "\"friction\"", "method = \"exact\"\naudit = 0");
    let open = text.replace("[[2, 1], [1, 2]]", "[[1, 0], [0, 1]]").replace("0.001", "0.0");
    let table = submitted(&place, "open", &open);
    assert!(table.column("p_high")[0] - table.column("p_low")[0] > 1e-3);
    assert_eq!(table.column("distrust"), [6.0]);
    assert!(table.column("p_unstable")[0].is_nan());
    let said = place.run("submit open.toml --out open").done();
    assert!(said.stdout.contains("no probability, only "), "{}", said.stdout);
    // So it is of conditional probabilities that are open.
    let conditional = open.replace("[\"friction\"]", "[\"friction\", \"k\"]");
    let conditional = conditional.replace("method = \"exact\"", "method = \"conditional\"\nsamples = 64");
    let table = submitted(&place, "conditional", &conditional);
    assert_eq!([table.column("n_undecided")[0], table.column("distrust")[0]], [64.0, 6.0]);
    assert!(table.column("p_unstable")[0].is_nan());
    // No limit is read from what is open; a target beyond the bounds is another matter.
    place.write("open.toml", &open.replace("[random]", "[axes]\nfriction = [0.6, 0.7]\n[random]"));
    place
        .run("limit open.toml --of friction --probability 0.5")
        .refused(65, &["with friction = 0.6", "the probability is left open between 0", "the target 0.5 is between"]);
}

/// Values of drawn inputs beyond their range are stable, whatever the method.
#[test]
fn conditional_probabilities_obey_the_ranges_of_drawn_inputs() {
    let place = Place::new();
    let of = |name: &str, sampling: &str| {
        let text = two_masses(name, "\"friction\", \"k\"", sampling);
        let text = text.replace("k = 1.0", "k = { value = 1.0, range = [0.95, 1.2] }");
        submitted(&place, name, &text).column("p_unstable")[0]
    };
    let conditional = of("conditional", "method = \"conditional\"\nsamples = 4096\naudit = 3000\nseed = 3");
    let counted = of("counted", "samples = 40_000\nseed = 5");
    // A third of the values of k are below the range.
    assert!((conditional - counted).abs() < 5.0 * (0.25 / 40_000.0_f64).sqrt(), "{conditional} {counted}");
    assert!(conditional > 0.05);
}

/// `check` says how many there will be, and what goes on with a finished run that lost them says that it draws them.
#[test]
fn plain_samples_are_said_before_they_are_drawn() {
    let place = Place::new();
    let conditional = "method = \"conditional\"\nsamples = 64";
    for (name, inputs, sampling, again) in [
        ("drawn", "\"friction\", \"k\"", conditional, "drawn has all its samples but 300 plain samples beside its"),
        ("exact", "\"friction\"", "method = \"exact\"", "exact lacked 300 plain samples beside its probabilities"),
    ] {
        submitted(&place, name, &two_masses(name, inputs, sampling));
        let checked = place.run(&format!("check {name}.toml")).done().stdout;
        let line =
            "# 300 plain samples beside each cell, to check that its probability misses no region (sampling.audit)";
        assert!(checked.lines().any(|own| own == line), "{checked}");
        for command in [format!("resume {name}"), format!("submit {name}.toml --out {name}")] {
            std::fs::remove_dir_all(place.path(name).join("audit")).unwrap();
            let said = place.run(&command).done().stderr;
            assert!(said.contains(again) && !said.contains("nothing to") && !said.contains("finished"), "{said}");
            let said = place.run(&command).done().stderr;
            assert!(said.contains("nothing to") || said.contains("is finished already"), "{said}");
        }
    }
    // None where none are wanted, or where probabilities are counted.
    for (sampling, plain) in
        [(format!("{conditional}\naudit = 0"), 0), ("samples = 64".to_owned(), 0), (conditional.to_owned(), 300)]
    {
        place.write("job.toml", &two_masses("job", "\"friction\", \"k\"", &sampling));
        let checked: serde_json::Value =
            serde_json::from_str(&place.run("check job.toml --json").done().stdout).unwrap();
        assert_eq!(checked["plain_samples_per_cell"], plain, "{sampling}");
        assert_eq!(checked["plain_samples_at_limits"], 0, "{sampling}");
        assert_eq!(place.run("check job.toml").done().stdout.contains("plain samples"), plain > 0, "{sampling}");
    }
    // Those beside limits as well, where the job asks for limits; over a verdict map there are none beside cells.
    let limit = "[limit]\nof = \"preload\"\nprobability = 0.05\n";
    let exact = format!("{}\n{limit}", job("job", EIGENVALUE, BOTH, "method = \"exact\""));
    let motion = "kind = \"time-domain\"\ndisc = \"rigid\"\nstart = \"near-equilibrium\"";
    for (text, said, [cells, limits]) in [
        (
            exact.clone(),
            "# 300 plain samples beside each cell, and at each limit and both ends of its axis, to",
            [300, 300],
        ),
        (
            exact.replace(EIGENVALUE, motion),
            "# 300 plain samples at each limit and both ends of its axis, to",
            [0, 300],
        ),
        (exact.replace("\"exact\"", "\"exact\"\naudit = 0"), "", [0, 0]),
    ] {
        place.write("job.toml", &text);
        let checked = place.run("check job.toml").done().stdout;
        assert!(checked.contains(said) && checked.contains("plain samples") != said.is_empty(), "{checked}");
        let checked: serde_json::Value =
            serde_json::from_str(&place.run("check job.toml --json").done().stdout).unwrap();
        let found = ["plain_samples_per_cell", "plain_samples_at_limits"].map(|key| checked[key].as_u64().unwrap());
        assert_eq!(found, [cells, limits]);
    }
}

/// A run that ended among its plain samples has no surface yet, and no command writes one from what is there.
#[test]
fn no_surface_is_written_before_its_plain_samples() {
    let place = Place::new();
    let sampling = "method = \"importance\"\nsamples = 512\naudit = 5000\nseed = 3";
    submitted(&place, "two", &two_masses("two", "\"friction\", \"k\"", sampling));
    let whole = place.surface("two");
    std::fs::remove_dir_all(place.path("two/audit")).unwrap();
    std::fs::remove_file(place.path("two/surface.parquet")).unwrap();
    let verified = place.run("verify two").done().stdout;
    assert!(verified.contains("1 of 1 cells are complete, and plain samples are missing"), "{verified}");
    assert!(!place.path("two/surface.parquet").exists());
    place.run("resume two").done();
    assert!(place.surface("two") == whole);
}
