//! Every command that goes by quantities runs jobs of any model: a test model of a few lines, beside the pad on the disc.

use std::fs;
use std::path::{Path, PathBuf};

use clap::Parser as _;
use tempfile::TempDir;

use crate::cli::Cli;
use crate::dispatch;
use crate::failure::Failure;
use crate::interrupt::Interrupt;
use crate::tables::finished::FinishedSurface;

/// A place with the job `job.toml` of two masses.
struct Place(TempDir);

impl Place {
    fn new(axes: &str, sampling: &str) -> Self {
        let place = Self(TempDir::new().unwrap());
        place.write("job", axes, sampling);
        place
    }

    fn write(&self, name: &str, axes: &str, sampling: &str) {
        let text = format!(
            "name = \"{name}\"\n[model]\nkind = \"two-masses\"\nfriction = 0.7\nstiffness = [2.0, 1.0, 2.0]\n[axes]\n{axes}\n\
             [random]\ninputs = [\"friction\", \"k12\"]\nrelative_std = {{ friction = 0.1, k12 = 0.05 }}\n\
             [sampling]\nseed = 5\n{sampling}\n"
        );
        fs::write(self.path(&format!("{name}.toml")), text).unwrap();
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Runs a command, of which words with a slash are paths here.
    fn run(&self, command: &str) -> Result<(), Failure> {
        let word = |word: &str| match word.strip_prefix("./") {
            Some(name) => self.path(name).to_str().unwrap().to_owned(),
            None => word.to_owned(),
        };
        let words = ["stickslip"].into_iter().chain(command.split(' ')).map(word);
        dispatch(Cli::try_parse_from(words).unwrap().command, &Interrupt::unwatched())
    }

    /// Columns of a surface.
    fn surface<const N: usize>(&self, run: &str, names: [&str; N]) -> [Vec<Option<f64>>; N] {
        FinishedSurface::open(&self.path(run)).unwrap().numbers(names).unwrap()
    }
}

const AXIS: &str = "friction = { from = 0.6, to = 0.8, points = 5 }";

/// `P(4 mu / 3 > k12)` with both normal, of which the difference is: k11 = k22.
fn exact(friction: f64) -> f64 {
    let (mean, std) = (4.0 * friction / 3.0 - 1.0, libm::hypot(4.0 * 0.1 * friction / 3.0, 0.05));
    stickslip_sampler::special_functions::normal::upper_tail(-mean / std)
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn samples_of_any_model_are_submitted_resumed_drawn_and_compared() {
    let place = Place::new(AXIS, "samples = 20_000");
    place.run("check ./job.toml").unwrap();
    place.run("submit ./job.toml --out ./run").unwrap();
    let [friction, p, low, high] = place.surface("run", ["friction", "p_unstable", "p_low", "p_high"]);
    for i in 0..5 {
        let exact = exact(friction[i].unwrap());
        assert!((p[i].unwrap() - exact).abs() < 0.015, "{friction:?} {p:?} {exact}");
        assert!(low[i].unwrap() - 0.01 < exact && exact < high[i].unwrap() + 0.01);
    }
    // What is lost is computed again, to the same bytes.
    let bytes = fs::read(place.path("run/surface.parquet")).unwrap();
    let pieces: Vec<PathBuf> =
        fs::read_dir(place.path("run/shards")).unwrap().map(|entry| entry.unwrap().path()).collect();
    fs::remove_file(&pieces[0]).unwrap();
    for file in ["surface.parquet", "digests.json"] {
        fs::remove_file(place.path("run").join(file)).unwrap();
    }
    place.run("resume ./run").unwrap();
    assert_eq!(fs::read(place.path("run/surface.parquet")).unwrap(), bytes);
    // More samples, in shards and merged, are those of one process.
    place.run("submit ./job.toml --out ./more --samples 40000").unwrap();
    for shard in ["1/2", "2/2"] {
        place.run(&format!("submit ./job.toml --out ./shards --samples 40000 --shard {shard}")).unwrap();
    }
    place.run("merge ./shards").unwrap();
    let [more, shards] = ["more", "shards"].map(|run| fs::read(place.path(run).join("surface.parquet")).unwrap());
    assert!(more == shards);
    for command in
        ["plot ./run --out ./p.svg", "report ./run ./more --out ./r.html", "compare ./run ./more", "verify ./run"]
    {
        place.run(command).unwrap();
    }
    let drawn = fs::read_to_string(place.path("p.svg")).unwrap();
    assert!(drawn.contains("friction") && !drawn.contains("preload"));
    place.run("export ./run --format csv --out ./s.csv").unwrap();
    place.run("samples ./run --cell 1 --out ./s.parquet").unwrap();
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn sobol_points_rare_events_and_limits_go_by_the_quantities_of_any_model() {
    let place = Place::new(AXIS, "method = \"sobol\"\nsamples = 32_768");
    place.run("submit ./job.toml --out ./sobol").unwrap();
    let [friction, p] = place.surface("sobol", ["friction", "p_unstable"]);
    assert!((0..5).all(|i| (p[i].unwrap() - exact(friction[i].unwrap())).abs() < 2e-3), "{p:?}");
    place.write("rare", "friction = [0.45, 0.5]", "method = \"importance\"\nsamples = 4096");
    place.run("submit ./rare.toml --out ./rare").unwrap();
    let [friction, p, low, high] = place.surface("rare", ["friction", "p_unstable", "p_low", "p_high"]);
    for i in 0..2 {
        let exact = exact(friction[i].unwrap());
        assert!(exact < 1e-3 && (p[i].unwrap() / exact - 1.0).abs() < 0.1, "{p:?} {exact:e}");
        assert!(low[i].unwrap() < 1.02 * exact && 0.98 * exact < high[i].unwrap(), "{low:?} {high:?} {exact:e}");
    }
    place.write("limit", "friction = [0.45, 0.6]", "method = \"importance\"\nsamples = 4096");
    place.run("limit ./limit.toml --of friction --probability 1e-3 --out ./l.parquet").unwrap();
    let [value] = crate::tables::finished::read_numbers(&place.path("l.parquet"), ["limit"]).unwrap();
    assert!((exact(value[0].unwrap()) / 1e-3 - 1.0).abs() < 0.1, "{value:?}");
}

#[test]
fn what_a_model_cannot_do_is_refused_with_the_remedy() {
    let refused = |sampling: &str, text: &str| {
        let place = Place::new("", sampling);
        let error = place.run("check ./job.toml").unwrap_err().to_string();
        assert!(error.contains(text), "{error}");
    };
    refused("method = \"exact\"", "this model has no such pair; use method = \"monte-carlo\" or \"sobol\"");
    refused("method = \"conditional\"\nsamples = 1024", "use method = \"sobol\"");
    refused("samples = 100\nderivatives = true", "remove it (sampling.sensitivity");
    let place = Place::new("", "samples = 100");
    let error = place.run("analyse --job ./job.toml").unwrap_err().to_string();
    assert!(error.contains("another model than the pad on the disc"), "{error}");
    assert!(!Path::new("runs").exists());
}
