//! `init`: an example job to start from, or one of those that come with the program.

use std::fs;
use std::path::{Path, PathBuf};

use super::shipped_jobs::{ShippedJob, listed};
use crate::cli::InitArguments;
use crate::failure::Failure;
use crate::files::bounded::holds;
use crate::files::publish::publish_first;
use crate::output::{note, output_file, quoted, result, shown};

/// A job that runs as it is, and shows the keys that it leaves out as comments.
const EXAMPLE: &str = include_str!("example.toml");

/// `stickslip init`.
pub fn init(arguments: &InitArguments) -> Result<(), Failure> {
    if arguments.list {
        return result(&listed());
    }
    let named = |name: &String| ShippedJob::named(name).map_err(|why| Failure::Usage(format!("--from: {why}")));
    let shipped = arguments.from.as_ref().map(named).transpose()?;
    let (default, text) = shipped.map_or(("job.toml".into(), EXAMPLE), |job| (format!("{}.toml", job.name), job.text));
    let file = arguments.file.clone().unwrap_or_else(|| default.into());
    let files = shipped.map_or(&[][..], |job| job.files);
    if file == Path::new("-") {
        for (path, _) in files {
            note(format_args!("the job names the file {path}, which `stickslip init --from` writes beside a FILE"));
        }
        return result(text);
    }
    let (directory, name) = output_file(&file)?;
    let files: Vec<(PathBuf, &[u8])> = files.iter().map(|(path, bytes)| (directory.join(path), *bytes)).collect();
    // What is there may be somebody's own.
    for (path, bytes) in &files {
        if path.symlink_metadata().is_ok() && !holds(path, bytes) {
            let message = format!("{} exists already and is another file; choose another folder", shown(path));
            return Err(Failure::CannotCreate(message));
        }
    }
    if !publish_first(&directory, &name, text.as_bytes())? {
        let option = arguments.from.as_ref().map_or(String::new(), |from| format!("--from {from} "));
        let message = format!("{} exists already; name another file: stickslip init {option}NAME.toml", file.display());
        return Err(Failure::CannotCreate(message));
    }
    for (path, bytes) in &files {
        let (folder, name) = (path.parent().unwrap_or(&directory), path.file_name().unwrap_or_default());
        fs::create_dir_all(folder).map_err(|error| Failure::creating(folder, error))?;
        publish_first(folder, &name.to_string_lossy(), bytes)?;
    }
    let written: String =
        files.iter().map(|(path, _)| format!(" and {}", shown(path.strip_prefix(".").unwrap_or(path)))).collect();
    let quoted = quoted(&file);
    let comments = " Its comments say what it computes and what you can change.";
    let comments = if shipped.is_none() { comments } else { "" };
    result(&format!(
        "Wrote {}{written}.{comments} Next:\n  stickslip check {quoted}\n  stickslip submit {quoted}\n",
        shown(&file)
    ))
}

#[cfg(test)]
mod tests {
    use super::EXAMPLE;
    use crate::job::JobSource;

    /// The keys that the example shows as comments: section, key, and the line without its comment sign.
    fn shown_keys(example: &str) -> Vec<(String, String, String)> {
        let mut section = String::new();
        let mut shown = Vec::new();
        for line in example.lines() {
            if line.starts_with('[') {
                line.trim_matches(['[', ']']).clone_into(&mut section);
            } else if let Some(line) = line.strip_prefix("# ")
                && line.parse::<toml::Table>().is_ok_and(|table| !table.is_empty())
            {
                let (key, _) = line.split_once(" = ").unwrap();
                shown.push((section.clone(), key.to_owned(), line.to_owned()));
            }
        }
        shown
    }

    /// The example with one of its comments turned into a key, in place of the same key where that is set.
    fn uncommented(example: &str, section: &str, key: &str, shown: &str) -> String {
        let mut within = String::new();
        let mut lines = Vec::new();
        for line in example.lines() {
            if line.starts_with('[') {
                line.trim_matches(['[', ']']).clone_into(&mut within);
            }
            let is_rival = within == section && line.starts_with(&format!("{key} = "));
            match line.strip_prefix("# ") {
                Some(bare) if within == section && bare == shown => lines.push(bare),
                _ if is_rival => {}
                _ => lines.push(line),
            }
        }
        lines.join("\n") + "\n"
    }

    #[test]
    fn every_key_that_the_example_shows_is_accepted() {
        let shown = shown_keys(EXAMPLE);
        let count = |wanted: &str| shown.iter().filter(|(section, ..)| section == wanted).count();
        assert!(count("model") >= 20 && count("sampling") >= 10, "{shown:?}");
        assert!(count("axes") >= 3 && count("random") >= 7 && count("criterion") >= 9, "{shown:?}");
        let read = |text: &str| JobSource { path: "job.toml".into(), text: text.to_owned() }.job().unwrap();
        let plain = read(EXAMPLE).normalised();
        for (section, key, line) in &shown {
            let mut job = uncommented(EXAMPLE, section, key, line);
            // What the comment beside the key says of other keys.
            let (from, to) = match (section.as_str(), key.as_str()) {
                ("criterion", "disc_modes") => ("kind = \"eigenvalue\"", "kind = \"coupled-eigenvalue\""),
                ("criterion", "disc") => ("kind = \"eigenvalue\"", "kind = \"time-domain\""),
                ("criterion", "start" | "displacement" | "horizon" | "record") => {
                    ("kind = \"eigenvalue\"", "kind = \"time-domain\"\ndisc = \"rigid\"")
                }
                ("axes", "preload_force") => ("\npreload = ", "\n# preload = "),
                ("sampling", "until") => ("\nsamples = 10_000", "\n"),
                ("sampling", "method") if line.contains("exact") => ("\nsamples = 10_000", "\n"),
                ("sampling", "randomisations") => ("\nsamples = 10_000", "\nmethod = \"sobol\"\nsamples = 10_000"),
                ("random", "distribution") if line.contains("measured") => {
                    ("\nrelative_std = 0.2", "\nrelative_std = { static_friction = 0.2 }")
                }
                _ => ("", ""),
            };
            assert!(job.contains(from), "{line}");
            job = job.replacen(from, to, 1);
            let job = read(&job);
            assert!(job.warnings().is_empty(), "{line}\n{:?}", job.warnings());
            // The values of the brake that are shown are those of the preset. One of them is not listed unless it is given,
            // as it follows another.
            let listed = job.normalised().replace("effective_radius = 0.135\n", "");
            assert!(section != "model" || listed == plain, "{line}");
        }
    }
}
