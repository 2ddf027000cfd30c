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
use syn::{Attribute, Item, ItemMod, ItemUse, UseTree};

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

/// For each crate its modules in order, each with the modules of the same crate that it imports.
fn picture() -> String {
    let mut text = String::new();
    for (name, file) in CRATES {
        let modules = Modules::read(&root().join("crates").join(name).join("src"), file);
        text += &format!("{name}\n");
        for child in &modules.children[&Vec::new()] {
            let imported: Vec<&str> = modules.children[&Vec::new()]
                .iter()
                .filter(|other| {
                    *other != child
                        && modules.imports().any(|(from, to)| from.first() == Some(child) && to.first() == Some(*other))
                })
                .map(String::as_str)
                .collect();
            let arrow = if imported.is_empty() { String::new() } else { format!(" <- {}", imported.join(", ")) };
            text += &format!("  {child}{arrow}\n");
        }
    }
    text
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
