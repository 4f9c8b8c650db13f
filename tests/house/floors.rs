//! The floors of the house: reading order is import order.
//!
//! The `mod` lines of `lib.rs` and of every `mod.rs` give each module its place among its siblings; a file names only
//! modules that stand above its own. Outside packages that could be changed are named only where they belong.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use syn::visit::{self, Visit};
use syn::{ItemMod, ItemUse, UseTree};

use crate::sources::parse;

/// A module: where its file is, and its submodules in reading order.
struct Module {
    file: PathBuf,
    children: Vec<String>,
}

type House = BTreeMap<Vec<String>, Module>;

fn src() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("src")
}

/// Reads the module tree from `file`, which holds the module `path`.
fn enter(house: &mut House, path: Vec<String>, file: PathBuf) {
    let folder = match path.as_slice() {
        [] => src(),
        _ => path.iter().fold(src(), |at, name| at.join(name)),
    };
    let mut children = Vec::new();
    for item in parse(&file).items {
        if let syn::Item::Mod(ItemMod {
            ident,
            content: None,
            ..
        }) = item
        {
            let name = ident.to_string();
            let (alone, with_mod) = (
                folder.join(format!("{name}.rs")),
                folder.join(&name).join("mod.rs"),
            );
            let child = path.iter().cloned().chain([name.clone()]).collect();
            enter(house, child, if alone.exists() { alone } else { with_mod });
            children.push(name);
        }
    }
    house.insert(path, Module { file, children });
}

fn house() -> House {
    let mut house = House::new();
    enter(&mut house, Vec::new(), src().join("lib.rs"));
    house
}

/// Collects every path that starts in this crate, with its line.
struct Paths {
    own: Vec<String>,
    /// How many inline modules we are inside of.
    depth: usize,
    found: Vec<(usize, Vec<String>)>,
}

impl Paths {
    /// The path from the crate's root, where it is one of ours.
    fn resolve(&self, segments: &[String]) -> Option<Vec<String>> {
        match segments.first().map(String::as_str) {
            Some("crate") => Some(segments[1..].to_vec()),
            Some("self") => Some([&self.own[..], &segments[1..]].concat()),
            Some("super") => {
                let ups = segments.iter().take_while(|s| *s == "super").count();
                let above = self.own.len().checked_sub(ups.saturating_sub(self.depth))?;
                Some([&self.own[..above], &segments[ups..]].concat())
            }
            _ => None,
        }
    }

    fn note(&mut self, line: usize, segments: &[String]) {
        if let Some(path) = self.resolve(segments) {
            self.found.push((line, path));
        }
    }

    fn tree(&mut self, before: &[String], tree: &UseTree) {
        match tree {
            UseTree::Path(path) => {
                let deeper = [before, &[path.ident.to_string()]].concat();
                self.tree(&deeper, &path.tree);
            }
            UseTree::Group(group) => group.items.iter().for_each(|t| self.tree(before, t)),
            UseTree::Name(name) => self.leaf(before, &name.ident),
            UseTree::Rename(rename) => self.leaf(before, &rename.ident),
            UseTree::Glob(glob) => self.note(glob.star_token.spans[0].start().line, before),
        }
    }

    fn leaf(&mut self, before: &[String], ident: &syn::Ident) {
        let path = [before, &[ident.to_string()]].concat();
        self.note(ident.span().start().line, &path);
    }
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        self.tree(&[], &item.tree);
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        let segments: Vec<String> = path.segments.iter().map(|s| s.ident.to_string()).collect();
        let line = path
            .segments
            .first()
            .map_or(0, |s| s.ident.span().start().line);
        self.note(line, &segments);
        visit::visit_path(self, path);
    }

    fn visit_item_mod(&mut self, item: &'ast ItemMod) {
        self.depth += 1;
        visit::visit_item_mod(self, item);
        self.depth -= 1;
    }
}

/// The module a path leads to: its longest part that is one.
fn module_of(house: &House, path: &[String]) -> Vec<String> {
    (0..=path.len())
        .rev()
        .map(|n| path[..n].to_vec())
        .find(|part| house.contains_key(part))
        .unwrap_or_default()
}

/// Whether `to` stands below `from`: at the first level where they part, later among its siblings.
fn is_upward(house: &House, from: &[String], to: &[String]) -> bool {
    let shared = from.iter().zip(to).take_while(|(a, b)| a == b).count();
    if shared == from.len() || shared == to.len() {
        return false;
    }
    let siblings = &house[&from[..shared]].children;
    let place = |name: &String| siblings.iter().position(|s| s == name);
    place(&to[shared]) > place(&from[shared])
}

/// No file names a module that stands below its own.
#[test]
fn law_reading_order_is_import_order() {
    let house = house();
    let mut wrong = Vec::new();
    for (own, module) in &house {
        let mut paths = Paths {
            own: own.clone(),
            depth: 0,
            found: Vec::new(),
        };
        paths.visit_file(&parse(&module.file));
        for (line, path) in &paths.found {
            let to = module_of(&house, path);
            if is_upward(&house, own, &to) {
                wrong.push(format!(
                    "{}:{line}: imports {} from below",
                    module.file.display(),
                    to.join("::")
                ));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(house.len() > 40, "the walk found {} modules", house.len());
}

/// Floors of logs and floors of machines; they share what lies above both and meet in `plan`.
const SIDES: [&[&str]; 2] = [
    &["recording", "spectrum", "identify", "encoder"],
    &[
        "gear",
        "scene",
        "machine",
        "modes",
        "motion",
        "response",
        "transmission",
    ],
];

/// Logs and machines do not import each other.
#[test]
fn law_logs_and_machines_meet_in_plan() {
    let house = house();
    let side = |path: &[String]| {
        let floor = path.first()?.as_str();
        SIDES.iter().position(|side| side.contains(&floor))
    };
    let mut wrong = Vec::new();
    let mut seen = [0, 0];
    for (own, module) in &house {
        let Some(at) = side(own) else { continue };
        seen[at] += 1;
        let mut paths = Paths {
            own: own.clone(),
            depth: 0,
            found: Vec::new(),
        };
        paths.visit_file(&parse(&module.file));
        for (line, path) in &paths.found {
            if side(path).is_some_and(|to| to != at) {
                let place = module.file.display();
                wrong.push(format!("{place}:{line}: imports {}", path.join("::")));
            }
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
    assert!(seen.iter().all(|&n| n > 20), "{seen:?} modules");
}

/// Packages that could one day be changed, and the floor that alone may name each.
const OWNERS: &[(&str, &str)] = &[
    ("faer", "numeric/"),
    ("rayon", "numeric/parallel.rs"),
    ("num_rational", "numeric/"),
    ("toml", "base/toml.rs"),
    ("plotters", "report/"),
    ("clap", "cli/"),
    ("annotate_snippets", "cli/"),
    ("indicatif", "cli/progress.rs"),
    ("signal_hook", "cli/interrupt.rs"),
    ("ctrlc", "cli/interrupt.rs"),
    ("tempfile", "cli/files.rs"),
    ("tempfile", "recording/sample_column.rs"),
    ("encoding_rs", "recording/"),
    ("zip", "recording/"),
    ("ode_solvers", "motion/methods/explicit_runge_kutta.rs"),
    ("nalgebra", "motion/methods/explicit_runge_kutta.rs"),
];

/// Outside packages are named where they belong and nowhere else.
#[test]
fn law_packages_have_owners() {
    for (path, module) in &house() {
        let file = module.file.strip_prefix(src()).unwrap().to_path_buf();
        let mut names = Packages::default();
        names.visit_file(&parse(&module.file));
        for &(package, _) in OWNERS {
            let named = names.0.contains(&package.to_string());
            let at_home = OWNERS
                .iter()
                .any(|(p, owner)| *p == package && file.to_string_lossy().starts_with(owner));
            // Our own module `base::toml` bears the name of the package it wraps.
            let reads = ["base", "scene", "recording::sidecar"];
            let ours = package == "toml" && reads.iter().any(|r| path.join("::").starts_with(r));
            assert!(
                !named || at_home || ours,
                "{} names {package}",
                file.display()
            );
        }
    }
}

/// Only the command touches the terminal.
#[test]
fn law_only_the_command_prints() {
    for module in house().values() {
        let file = module.file.strip_prefix(src()).unwrap().to_path_buf();
        let mut macros = Macros::default();
        macros.visit_file(&parse(&module.file));
        let prints = ["print", "println", "eprint", "eprintln", "dbg"];
        let printed = macros.0.iter().find(|name| prints.contains(&name.as_str()));
        let at_home = file.starts_with("cli");
        assert!(
            printed.is_none() || at_home,
            "{} has {printed:?}",
            file.display()
        );
    }
}

/// Every path that the architecture names is there, below the project or its sources.
#[test]
fn law_paths_of_the_architecture() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR"));
    let text = fs::read_to_string(root.join("docs/architecture.md")).unwrap();
    let is_path = |word: &&str| {
        let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || "/_.".contains(c);
        word.contains('/') && word.chars().all(plain)
    };
    let is_there = |path: &str| {
        let folders = [root.to_path_buf(), src(), src().join("report/page")];
        folders.iter().any(|folder| folder.join(path).exists())
    };
    let paths: Vec<&str> = text.split('`').skip(1).step_by(2).filter(is_path).collect();
    let lost: Vec<&&str> = paths.iter().filter(|path| !is_there(path)).collect();
    assert!(
        paths.len() > 100 && lost.is_empty(),
        "{} paths, not there: {lost:?}",
        paths.len()
    );
}

/// Names of every macro called.
#[derive(Default)]
struct Macros(Vec<String>);

impl<'ast> Visit<'ast> for Macros {
    fn visit_macro(&mut self, called: &'ast syn::Macro) {
        self.0
            .extend(called.path.segments.last().map(|s| s.ident.to_string()));
    }
}

/// First segments of every path.
#[derive(Default)]
struct Packages(Vec<String>);

impl<'ast> Visit<'ast> for Packages {
    fn visit_item_use(&mut self, item: &'ast ItemUse) {
        if let UseTree::Path(path) = &item.tree {
            self.0.push(path.ident.to_string());
        }
    }

    fn visit_path(&mut self, path: &'ast syn::Path) {
        if path.segments.len() > 1 {
            self.0.push(path.segments[0].ident.to_string());
        }
        visit::visit_path(self, path);
    }
}
