//! Two rules of the code. A module imports only modules that are declared before it, so that there are no circles and the
//! order of declaration is an order in which to read. Only a few modules of the runner know a model.

#![allow(clippy::unwrap_used, reason = "a test that cannot go on should say so and stop")]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::Path;

use proc_macro2::{Delimiter, Spacing, TokenStream, TokenTree};

/// Crates in the order in which they build on each other, with their root file.
const CRATES: [(&str, &str); 3] = [("core", "lib.rs"), ("sampler", "lib.rs"), ("runner", "main.rs")];

/// Modules of the runner that are about one model, or read the tables of one, or (the version) name the lanes of one.
const ABOUT_A_MODEL: &str = "job::models job::model job::validated commands::analyse commands::trajectory \
    commands::motion_report commands::one_brake commands::modes commands::reduce commands::parameters commands::fit \
    commands::fitted_job commands::fit_picture commands::brake_tests commands::replay cli::pad_on_disc cli::start \
    reproduce plot::motion version";

/// Words that `::` joins. A literal is a path of one word.
type Words = Vec<String>;

/// A module: those in it, in their order, and the paths that its code names, tests and comments apart.
struct Module {
    children: Vec<String>,
    paths: BTreeSet<Words>,
}

type Modules = BTreeMap<Words, Module>;

/// Adds the module in `file`, whose children lie in `folder`.
fn read(modules: &mut Modules, file: &Path, folder: &Path, place: Words) {
    let text = fs::read_to_string(file).unwrap();
    let before = text.lines().scan("", |last, line| Some(std::mem::replace(last, line)));
    let child = |(before, line): (&str, &str)| {
        let (visibility, name) = line.strip_suffix(';')?.split_once("mod ")?;
        let is_one = before != "#[cfg(test)]" && ["", "pub ", "pub(crate) ", "pub(super) "].contains(&visibility);
        is_one.then(|| name.to_owned())
    };
    let children: Vec<String> = before.zip(text.lines()).filter_map(child).collect();
    let mut paths = BTreeSet::new();
    add_paths(text.parse().unwrap(), &[], &mut paths);
    for child in &children {
        let (single, inside) = (folder.join(format!("{child}.rs")), folder.join(child));
        let file = if single.is_file() { single } else { inside.join("mod.rs") };
        read(modules, &file, &inside, [&place[..], std::slice::from_ref(child)].concat());
    }
    modules.insert(place, Module { children, paths });
}

/// Adds the paths in some code, each after `start`.
fn add_paths(code: TokenStream, start: &[String], paths: &mut BTreeSet<Words>) {
    let (mut path, mut is_joined) = (Vec::new(), false);
    let mut tokens = code.into_iter().peekable();
    while let Some(token) = tokens.next() {
        let goes_on = std::mem::take(&mut is_joined);
        match token {
            TokenTree::Ident(word) if goes_on => path.push(word.to_string()),
            TokenTree::Punct(mark) if goes_on && mark.as_char() == '*' => path.push("*".to_owned()),
            TokenTree::Group(group) if goes_on && group.delimiter() == Delimiter::Brace => {
                add_paths(group.stream(), &std::mem::take(&mut path), paths);
            }
            TokenTree::Punct(mark) if mark.as_char() == ':' && mark.spacing() == Spacing::Joint => {
                tokens.next();
                is_joined = true;
            }
            other => {
                paths.insert(std::mem::take(&mut path));
                match other {
                    TokenTree::Ident(word) => path = [start, &[word.to_string()]].concat(),
                    TokenTree::Literal(text) => _ = paths.insert(vec![text.to_string()]),
                    TokenTree::Group(group) => add_paths(group.stream(), &[], paths),
                    TokenTree::Punct(mark) if mark.as_char() == '#' => {
                        tokens.next_if(|token| token.to_string() == "!");
                        let attribute = tokens.next_if(|token| matches!(token, TokenTree::Group(_)));
                        match attribute.map(|group| group.to_string().replace(' ', "")) {
                            Some(text) if text == "[cfg(test)]" => {
                                let ends = |token: &TokenTree| {
                                    let text = token.to_string();
                                    text == ";" || text == "," || text.starts_with('{')
                                };
                                tokens.find(ends);
                            }
                            Some(text) if !text.starts_with("[doc=") => add_paths(text.parse().unwrap(), &[], paths),
                            _ => {}
                        }
                    }
                    TokenTree::Punct(_) => {}
                }
            }
        }
    }
    paths.insert(path);
}

/// A path from the root of the crate, if it leads into it.
fn resolved(place: &[String], module: &Module, path: &[String]) -> Option<Words> {
    let ups = path.iter().take_while(|word| *word == "super").count();
    match path.first()?.as_str() {
        // `pub(super)`, for example.
        _ if path.len() == 1 => None,
        "crate" => Some(path[1..].to_vec()),
        "self" => Some([place, &path[1..]].concat()),
        _ if ups > 0 => Some([&place[..place.len().checked_sub(ups)?], &path[ups..]].concat()),
        first if module.children.iter().any(|child| child == first) => Some([place, path].concat()),
        _ => None,
    }
}

/// What is wrong with the imports of a crate.
fn against_the_order(sources: &Path, root: &str) -> Vec<String> {
    let mut modules = Modules::new();
    read(&mut modules, &sources.join(root), sources, Vec::new());
    let target =
        |path: &[String]| (0..=path.len()).rev().find(|length| modules.contains_key(&path[..*length])).unwrap();
    let mut complaints = BTreeSet::new();
    for (from, module) in &modules {
        for path in module.paths.iter().filter_map(|path| resolved(from, module, path)) {
            let to = &path[..target(&path)];
            let common = from.iter().zip(to).take_while(|(a, b)| a == b).count();
            if common == from.len() {
                continue;
            }
            let of = &modules[&from[..common]];
            let is_later = if common == to.len() {
                // It imports what it lies in, which must not import what lies in it.
                let leads_inside = |path: Words| path.starts_with(to) && target(&path) > to.len();
                of.paths.iter().filter_map(|path| resolved(to, of, path)).any(leads_inside)
            } else {
                let place = |name| of.children.iter().position(|child| child == name);
                place(&to[common]) > place(&from[common])
            };
            if is_later {
                complaints.insert(format!("{} imports {}", from.join("::"), to.join("::")));
            }
        }
    }
    complaints.into_iter().collect()
}

/// The paths and words by which code knows a model.
fn of_models(paths: &BTreeSet<Words>) -> Vec<String> {
    let is_one = |path: &&Words| {
        path.starts_with(&["stickslip_core".to_owned(), "models".to_owned()])
            || path.iter().any(|word| word.to_lowercase().contains("preload"))
    };
    paths.iter().filter(is_one).map(|path| path.join("::")).collect()
}

fn sources(name: &str) -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("..").join(name).join("src")
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn modules_import_only_modules_declared_before_them() {
    for (name, root) in CRATES {
        assert_eq!(against_the_order(&sources(name), root), [""; 0], "{name}");
    }
}

#[test]
fn a_circle_is_found() {
    let place = tempfile::tempdir().unwrap();
    let complaints = |first: &str, inside: &str| {
        let write = |name: &str, text: &str| fs::write(place.path().join(name), text).unwrap();
        write("lib.rs", "pub mod first;\npub mod second;\n");
        write("first.rs", first);
        write("second.rs", "use crate::first::A;\nfn f() { third::g(); }\npub struct B;\nmod third;\n");
        fs::create_dir_all(place.path().join("second")).unwrap();
        write("second/third.rs", inside);
        against_the_order(place.path(), "lib.rs")
    };
    let sound = "/// See [`crate::second::B`].\npub struct A;\n#[cfg(test)]\nmod tests { use crate::second::B; }\n";
    assert_eq!(complaints(sound, "use super::super::first::A;"), [""; 0]);
    for back in [
        "use crate::second::B;",
        "use super::{second::{B as C}};",
        "fn f() -> Vec<crate::second::B> {}",
        "fn f() { print!(\"{}\", crate::second::B); }",
    ] {
        assert_eq!(complaints(back, ""), ["first imports second"], "{back}");
    }
    for back in ["use super::B;", "use super::*;", "fn g() { super::B; }"] {
        assert_eq!(complaints(sound, back), ["second::third imports second"], "{back}");
    }
}

#[test]
#[cfg_attr(debug_assertions, ignore = "slow: `make test` runs it")]
fn only_modules_about_a_model_know_one() {
    for (name, root) in CRATES {
        let mut modules = Modules::new();
        read(&mut modules, &sources(name).join(root), &sources(name), Vec::new());
        assert!(modules.len() > 40, "{name}: only {} modules", modules.len());
        for (place, module) in modules {
            let path = place.join("::");
            let is_about = |own: &str| path == own || path.starts_with(&format!("{own}::"));
            if name == "sampler" || name == "runner" && !ABOUT_A_MODEL.split(' ').any(is_about) {
                assert_eq!(of_models(&module.paths), [""; 0], "{name}: {path}");
            }
        }
    }
}

#[test]
fn code_that_knows_a_model_is_found() {
    let known = |code: &str| {
        let mut paths = BTreeSet::new();
        add_paths(code.parse().unwrap(), &[], &mut paths);
        of_models(&paths)
    };
    for code in [
        "use stickslip_core::models::pad_on_disc::model::PadModel;",
        "use stickslip_core::{grid, models};",
        "fn f(pad: &stickslip_core::models::pad_on_disc::model::PadModel) {}",
        "fn f() { let preload = 1.0; }",
        "struct Preload;",
        "fn f() { println!(\"the preload\"); }",
        "#[arg(default_value = \"preload\")] struct A;",
    ] {
        assert_eq!(known(code).len(), 1, "{code}");
    }
    for code in [
        "/// Such as a preload.\nstruct A;\n// preload\n",
        "use stickslip_core::model::Model;",
        "#[cfg(test)]\nmod tests { use stickslip_core::models::pad_on_disc; const A: &str = \"preload\"; }",
    ] {
        assert_eq!(known(code), [""; 0], "{code}");
    }
}

/// What is not declared is not compiled.
#[test]
fn every_file_of_tests_belongs_to_its_program() {
    let tests = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests");
    let mut count = 0;
    for program in ["physics", "numbers", "runs", "people"] {
        let root = fs::read_to_string(tests.join(program).join("main.rs")).unwrap();
        for entry in fs::read_dir(tests.join(program)).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_stem().unwrap().to_str().unwrap();
            let is_declared = root.lines().any(|line| line == format!("mod {name};"));
            assert!(name == "main" || is_declared, "{} is not declared in main.rs", path.display());
            count += 1;
        }
    }
    assert!(count > 40, "{count}");
}
