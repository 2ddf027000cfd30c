//! The structure of the code: modules import only modules that are declared before them, so that no circle of imports
//! can arise and the order of declaration is an order in which to read. What ARCHITECTURE.md says of the modules and of
//! places in the code is up to date.

#![allow(
    clippy::unwrap_used,
    clippy::expect_used,
    clippy::panic,
    reason = "a test that cannot go on should say so and stop"
)]

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::Visit;
use syn::{Attribute, Item, ItemMod, ItemUse, UseName, UseRename, UseTree};

/// Crates in the order in which they build on each other, with their root file.
const CRATES: [(&str, &str); 3] = [("core", "lib.rs"), ("sampler", "lib.rs"), ("runner", "main.rs")];

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../..")
}

/// The modules of a crate: for each its children in the order of declaration, and the modules that its code names.
#[derive(Default)]
struct Modules {
    children: BTreeMap<Vec<String>, Vec<String>>,
    /// Paths as written, resolved to segments after `crate`.
    named: BTreeMap<Vec<String>, BTreeSet<Vec<String>>>,
    /// The code of each.
    texts: BTreeMap<Vec<String>, String>,
}

impl Modules {
    fn read(sources: &Path, root: &str) -> Self {
        let mut modules = Self::default();
        modules.add(&sources.join(root), sources, Vec::new());
        modules
    }

    /// Adds the module in `file`, whose children lie in `folder`.
    fn add(&mut self, file: &Path, folder: &Path, module: Vec<String>) {
        let text = fs::read_to_string(file).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let syntax = syn::parse_file(&text).unwrap_or_else(|error| panic!("{}: {error}", file.display()));
        let mut names = Names { module: &module, found: BTreeSet::new() };
        names.visit_file(&syntax);
        self.named.insert(module.clone(), names.found);
        self.texts.insert(module.clone(), text);
        let mut children = Vec::new();
        for item in &syntax.items {
            if let Item::Mod(ItemMod { ident, content: None, attrs, .. }) = item
                && !is_for_tests(attrs)
            {
                let child = ident.to_string();
                let path = [module.clone(), vec![child.clone()]].concat();
                let inside = folder.join(&child);
                let single = folder.join(format!("{child}.rs"));
                let file = if single.is_file() { single } else { inside.join("mod.rs") };
                self.add(&file, &inside, path);
                children.push(child);
            }
        }
        self.children.insert(module, children);
    }

    /// The module that a path leads to: its longest beginning that is one.
    fn module_of<'a>(&self, path: &'a [String]) -> &'a [String] {
        let is_module = |length: &usize| self.children.contains_key(&path[..*length]);
        let longest = (0..=path.len()).rev().find(is_module).unwrap_or(0);
        &path[..longest]
    }

    /// Imports from one module to another, without those of a module's own items.
    fn imports(&self) -> impl Iterator<Item = (&[String], &[String])> {
        let of = move |(module, paths): (&'_ Vec<String>, &'_ BTreeSet<Vec<String>>)| {
            let module: &[String] = self.children.get_key_value(module).map_or(&[], |(module, _)| module);
            let targets: BTreeSet<&[String]> = paths
                .iter()
                .map(|path| {
                    let target = self.module_of(path).to_vec();
                    self.children.get_key_value(&target).map_or(&[][..], |(target, _)| target)
                })
                .filter(|target| *target != module)
                .collect();
            targets.into_iter().map(move |target| (module, target)).collect::<Vec<_>>()
        };
        self.named.iter().flat_map(of)
    }

    /// What is wrong with an import, if anything is.
    fn complaint(&self, from: &[String], to: &[String]) -> Option<String> {
        let common = from.iter().zip(to).take_while(|(a, b)| a == b).count();
        let names = (from.join("::"), to.join("::"));
        if common == to.len() {
            // A child of the module that it imports. If that one imports its children too, there is a circle.
            let imports_back = self.imports().any(|(a, b)| a == to && b.starts_with(to) && b.len() > to.len());
            return imports_back.then(|| format!("{} imports {}, which imports its own children", names.0, names.1));
        }
        if common == from.len() {
            return None;
        }
        let siblings = &self.children[&from[..common]];
        let place = |name: &String| siblings.iter().position(|sibling| sibling == name);
        (place(&to[common]) > place(&from[common]))
            .then(|| format!("{} imports {}, but {} is declared before {}", names.0, names.1, from[common], to[common]))
    }
}

fn is_for_tests(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("cfg")
            && attribute.meta.require_list().is_ok_and(|list| list.tokens.to_string() == "test")
    })
}

/// Collects the paths into the crate that the code of a module names, tests apart.
struct Names<'a> {
    module: &'a [String],
    found: BTreeSet<Vec<String>>,
}

impl Names<'_> {
    fn add(&mut self, segments: &[String]) {
        let Some(first) = segments.first() else { return };
        let mut path = match first.as_str() {
            "crate" => Vec::new(),
            "self" | "super" => self.module.to_vec(),
            _ => return,
        };
        let mut rest = &segments[1..];
        if first == "super" {
            path.pop();
            while rest.first().is_some_and(|segment| segment == "super") {
                path.pop();
                rest = &rest[1..];
            }
        }
        path.extend_from_slice(rest);
        self.found.insert(path);
    }

    fn add_tree(&mut self, tree: &UseTree, mut before: Vec<String>) {
        match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.add_tree(&path.tree, before);
            }
            UseTree::Name(name) => {
                before.push(name.ident.to_string());
                self.add(&before);
            }
            UseTree::Rename(name) => {
                before.push(name.ident.to_string());
                self.add(&before);
            }
            UseTree::Glob(_) => self.add(&before),
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_tree(tree, before.clone())),
        }
    }
}

impl<'ast> Visit<'ast> for Names<'_> {
    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !is_for_tests(&item.attrs) {
            syn::visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        if is_for_tests(&item.attrs) {
            return;
        }
        self.add_tree(&item.tree, Vec::new());
        // `pub use child::Type` in a folder's mod.rs names a child without `self`.
        if let UseTree::Path(path) = &item.tree {
            let child = path.ident.to_string();
            if !matches!(child.as_str(), "crate" | "self" | "super") {
                self.found.insert([self.module, &[child]].concat());
            }
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        if segments.len() > 1 {
            self.add(&segments);
        }
        syn::visit::visit_path(self, path);
    }
}

#[test]
fn modules_import_only_modules_declared_before_them() {
    let mut complaints = Vec::new();
    for (name, file) in CRATES {
        let modules = Modules::read(&root().join("crates").join(name).join("src"), file);
        let imports: Vec<_> = modules.imports().collect();
        assert!(imports.len() > 20, "{name}: only {} imports found", imports.len());
        complaints.extend(
            imports.iter().filter_map(|(from, to)| modules.complaint(from, to)).map(|why| format!("{name}: {why}")),
        );
    }
    assert!(complaints.is_empty(), "{} imports against the order:\n{}", complaints.len(), complaints.join("\n"));
}

#[test]
fn a_circle_is_found() {
    let place = tempfile::tempdir().unwrap();
    let write = |name: &str, text: &str| fs::write(place.path().join(name), text).unwrap();
    write("lib.rs", "pub mod first;\npub mod second;\n");
    write("second.rs", "use crate::first::A;\npub struct B;\n#[cfg(test)]\nmod tests { use crate::third; }\n");
    let complaints = |first: &str| -> Vec<String> {
        write("first.rs", first);
        let modules = Modules::read(place.path(), "lib.rs");
        let imports: Vec<_> = modules.imports().collect();
        imports.iter().filter_map(|(from, to)| modules.complaint(from, to)).collect()
    };
    assert_eq!(complaints("pub struct A;\n#[cfg(test)]\nuse crate::second::B;\n"), Vec::<String>::new());
    for back in ["use crate::second::B;", "use super::second::{B as C};", "fn f() -> crate::second::B { todo!() }"] {
        assert_eq!(complaints(back), ["first imports second, but first is declared before second"], "{back}");
    }
}

/// Modules of the runner that are about the pad on the disc or the modes of matrices, or read the tables of a model. All others know no model.
const ABOUT_A_MODEL: [&str; 20] = [
    "job::models",
    "commands::analyse",
    "commands::trajectory",
    "commands::motion_report",
    "commands::one_brake",
    "commands::modes",
    "commands::reduce",
    "commands::parameters",
    "commands::fit",
    "commands::fitted_job",
    "commands::fit_picture",
    "commands::brake_tests",
    "commands::replay",
    "cli::pad_on_disc",
    "cli::start",
    "reproduce",
    "plot::motion",
    // Names the instruction set of the lanes.
    "version",
    // Hand the pad on the disc of a job to the commands about it.
    "job::model",
    "job::validated",
];

/// Collects what code names of a model: paths into `stickslip_core::models`, and the word preload. Tests and comments do not
/// count.
#[derive(Default)]
struct OfModels {
    found: BTreeSet<String>,
}

impl OfModels {
    fn read(text: &str) -> BTreeSet<String> {
        let mut found = Self::default();
        found.visit_file(&syn::parse_file(text).unwrap());
        found.found
    }

    fn add_word(&mut self, text: &str) {
        if text.to_lowercase().contains("preload") {
            self.found.insert(format!("has the word preload: {text}"));
        }
    }

    fn add_tree(&mut self, tree: &UseTree, mut before: Vec<String>) {
        match tree {
            UseTree::Path(path) => {
                before.push(path.ident.to_string());
                self.add_path(&before);
                self.add_tree(&path.tree, before);
            }
            UseTree::Group(group) => group.items.iter().for_each(|tree| self.add_tree(tree, before.clone())),
            UseTree::Name(UseName { ident }) | UseTree::Rename(UseRename { ident, .. }) => {
                before.push(ident.to_string());
                self.add_path(&before);
            }
            UseTree::Glob(_) => {}
        }
    }

    fn add_path(&mut self, segments: &[String]) {
        if matches!(segments, [first, second, ..] if first == "stickslip_core" && second == "models") {
            self.found.insert("imports stickslip_core::models".to_owned());
        }
    }
}

impl<'ast> Visit<'ast> for OfModels {
    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        if !is_for_tests(&item.attrs) {
            syn::visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        if !is_for_tests(&item.attrs) {
            self.add_tree(&item.tree, Vec::new());
            syn::visit::visit_item_use(self, item);
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> = path.segments.iter().map(|segment| segment.ident.to_string()).collect();
        self.add_path(&segments);
        syn::visit::visit_path(self, path);
    }

    fn visit_ident(&mut self, ident: &'ast syn::Ident) {
        self.add_word(&ident.to_string());
    }

    fn visit_lit_str(&mut self, text: &'ast syn::LitStr) {
        self.add_word(&text.value());
    }

    fn visit_macro(&mut self, called: &'ast syn::Macro) {
        self.add_word(&called.tokens.to_string());
        syn::visit::visit_macro(self, called);
    }

    fn visit_attribute(&mut self, attribute: &'ast Attribute) {
        // Doc comments are attributes of this name.
        if !attribute.path().is_ident("doc") {
            if let Ok(list) = attribute.meta.require_list() {
                self.add_word(&list.tokens.to_string());
            }
            syn::visit::visit_attribute(self, attribute);
        }
    }
}

#[test]
fn only_modules_about_a_model_know_one() {
    let mut complaints = Vec::new();
    for (name, file) in &CRATES[1..] {
        let modules = Modules::read(&root().join("crates").join(name).join("src"), file);
        assert!(modules.texts.len() > 40, "{name}: only {} modules", modules.texts.len());
        for (module, text) in &modules.texts {
            let path = module.join("::");
            let is_about =
                |own: &&str| path == **own || path.strip_prefix(*own).is_some_and(|rest| rest.starts_with("::"));
            if *name != "runner" || !ABOUT_A_MODEL.iter().any(is_about) {
                complaints.extend(OfModels::read(text).iter().map(|why| format!("{name}: {path} {why}")));
            }
        }
    }
    assert!(complaints.is_empty(), "{} places know a model:\n{}", complaints.len(), complaints.join("\n"));
}

#[test]
fn code_that_knows_a_model_is_found() {
    let planted = [
        "use stickslip_core::models::pad_on_disc::model::PadModel;",
        "use stickslip_core::{grid, models};",
        "fn f(pad: &stickslip_core::models::pad_on_disc::model::PadModel) {}",
        "fn f() { let preload = 1.0; }",
        "struct Preload;",
        "const NAME: &str = \"preload\";",
        "fn f() { println!(\"the preload\"); }",
        "#[arg(default_value = \"preload\")] struct A;",
    ];
    for code in planted {
        assert_eq!(OfModels::read(code).len(), 1, "{code}");
    }
    let harmless = [
        "/// Such as a preload.\nstruct A;\n// preload\n",
        "use stickslip_core::model::Model;",
        "#[cfg(test)]\nmod tests { use stickslip_core::models::pad_on_disc; const A: &str = \"preload\"; }",
    ];
    for code in harmless {
        assert!(OfModels::read(code).is_empty(), "{code}");
    }
}

/// The modules whose children the picture shows, too.
const OPENED: [&[&str]; 2] = [&["models"], &["models", "pad_on_disc"]];

/// For each crate its modules in order, each with the modules beside it that it imports.
fn picture() -> String {
    let mut text = String::new();
    for (name, file) in CRATES {
        let modules = Modules::read(&root().join("crates").join(name).join("src"), file);
        text += &format!("{name}\n");
        let imports: Vec<_> = modules.imports().collect();
        add_children(&modules, &imports, &[], &mut text);
    }
    text
}

/// Adds the children of a module to the picture.
fn add_children(modules: &Modules, imports: &[(&[String], &[String])], parent: &[String], text: &mut String) {
    let depth = parent.len();
    let child_on = |path: &[String]| path.starts_with(parent).then(|| path.get(depth).cloned()).flatten();
    for child in &modules.children[parent] {
        let is_imported = |other: &&String| {
            let imports_it = |(from, to): &(&[String], &[String])| {
                child_on(from).as_ref() == Some(child) && child_on(to).as_ref() == Some(*other)
            };
            *other != child && imports.iter().any(imports_it)
        };
        let imported: Vec<&str> = modules.children[parent].iter().filter(is_imported).map(String::as_str).collect();
        let arrow = if imported.is_empty() { String::new() } else { format!(" <- {}", imported.join(", ")) };
        *text += &format!("{}{child}{arrow}\n", "  ".repeat(depth + 1));
        let path = [parent, std::slice::from_ref(child)].concat();
        if OPENED.iter().any(|opened| path == *opened) {
            add_children(modules, imports, &path, text);
        }
    }
}

#[test]
fn the_picture_of_the_modules_is_up_to_date() {
    let file = root().join("ARCHITECTURE.md");
    let text = fs::read_to_string(&file).unwrap();
    let (before, after) = text.split_once("<!-- modules -->\n```text\n").expect("ARCHITECTURE.md has the picture");
    let (shown, after) = after.split_once("```\n").unwrap();
    let now = picture();
    if std::env::var_os("STICKSLIP_UPDATE").is_some() {
        fs::write(&file, format!("{before}<!-- modules -->\n```text\n{now}```\n{after}")).unwrap();
    } else {
        assert!(shown == now, "write it again with STICKSLIP_UPDATE=1; it is now\n{now}");
    }
}

#[test]
fn things_are_where_the_page_says() {
    let text = fs::read_to_string(root().join("ARCHITECTURE.md")).unwrap();
    let (_, table) = text.split_once("## Where to find what").unwrap();
    let (table, _) = table.split_once("\n## ").unwrap();
    let mut found = 0;
    for row in table.lines().filter(|line| line.contains("`crates/")) {
        let quoted: Vec<&str> = row.split('`').skip(1).step_by(2).collect();
        let [file, item] = quoted[..] else { panic!("a file and an item: {row}") };
        let code = fs::read_to_string(root().join(file)).unwrap_or_else(|error| panic!("{file}: {error}"));
        assert!(code.contains(item), "{file} has no `{item}`");
        found += 1;
    }
    assert!(found >= 20, "{found} places");
    // Files that are named elsewhere on the page exist.
    for path in
        text.split('`').skip(1).step_by(2).chain(text.split("](").skip(1).filter_map(|rest| rest.split(')').next()))
    {
        if path.starts_with("crates/") || path.starts_with("tests/") || path.starts_with("docs/") {
            assert!(root().join(path).exists(), "{path} does not exist");
        }
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
