//! Imports go round in no circle of more than two files.
//!
//! A file depends on the files that define what its paths beginning with `crate` or `super` name: re-exports are followed, and a module that
//! is named alone counts as its file.

use super::package::branches;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;
use std::slice::from_ref;

/// The path of a module below its crate's root.
type Module = Vec<String>;

/// The modules of a crate: their code without comments and tests.
type Modules = BTreeMap<Module, String>;

/// Adds the modules of a folder, which is that of the module `at`. Folders of other packages are left out.
fn read(folder: &Path, at: &[String], modules: &mut Modules) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_stem().unwrap().to_str().unwrap().to_owned();
        let module = if ["lib", "mod"].contains(&&*name) { at.to_vec() } else { [at, from_ref(&name)].concat() };
        if path.is_dir() && name != "tests" && !path.join("Cargo.toml").exists() {
            read(&path, &module, modules);
        } else if path.extension().is_some_and(|ending| ending == "rs") && name != "tests" {
            let text = std::fs::read_to_string(&path).unwrap();
            let code = text.split("#[cfg(test)]\nmod tests").next().unwrap().lines();
            modules.insert(module, code.filter(|line| !line.trim_start().starts_with("//")).collect::<Vec<_>>().join(" "));
        }
    }
}

/// The paths that begin with a word, without or with the word itself.
fn paths<'a>(code: &'a str, word: &'a str, skipped: usize) -> impl Iterator<Item = Vec<String>> + 'a {
    let begins = |at: usize| code[..at].chars().next_back().is_none_or(|c| !(c.is_alphanumeric() || "_:$".contains(c)));
    code.match_indices(word).filter(move |&(at, _)| begins(at)).flat_map(move |(at, _)| branches(&code[at + skipped..]).0)
}

/// Whether code defines an item of this name, other than by a macro.
fn defines(code: &str, name: &str) -> bool {
    let is_end = |rest: &str| !rest.starts_with(|c: char| c.is_alphanumeric() || c == '_');
    let follows = |item: String| code.match_indices(&item).any(|(at, item)| is_end(&code[at + item.len()..]));
    let is_constant = ["const", "static"].iter().any(|kind| code.contains(&format!("{kind} {name}:")));
    is_constant || ["fn", "struct", "enum", "trait", "type"].iter().any(|kind| follows(format!("{kind} {name}")))
}

/// The module that defines what a path in the code of `at` names.
fn definer(modules: &Modules, at: &[String], path: &[String], seen: &mut BTreeSet<(Module, Module)>) -> Option<Module> {
    let Some((first, rest)) = path.split_first() else { return Some(at.to_vec()) };
    if !seen.insert((at.to_vec(), path.to_vec())) {
        return None;
    }
    let child = [at, &path[..1]].concat();
    match first.as_str() {
        "crate" => return definer(modules, &[], rest, seen),
        "super" => return definer(modules, &at[..at.len().saturating_sub(1)], rest, seen),
        "self" => return definer(modules, at, rest, seen),
        _ if modules.contains_key(&child) => return definer(modules, &child, rest, seen),
        _ => (),
    }
    let code = modules.get(at)?;
    let is_of_the_crate = |root: &String| {
        ["crate", "super", "self"].contains(&root.as_str()) || modules.contains_key(&[at, from_ref(root)].concat())
    };
    let mut imports: Vec<_> = paths(code, "use ", "use ".len()).filter(|import| is_of_the_crate(&import[0])).collect();
    imports.retain(|import| import.ends_with(from_ref(first)) || import.ends_with(&["*".into()]));
    // A name before a glob.
    imports.sort_by_key(|import| import.ends_with(&["*".into()]));
    let mut through = imports.iter().map(|import| [&import[..import.len() - 1], path].concat());
    let found = through.find_map(|path| definer(modules, at, &path, seen));
    found.or_else(|| defines(code, first).then(|| at.to_vec()))
}

/// What each module depends on.
fn dependencies(modules: &Modules) -> BTreeMap<&Module, BTreeSet<Module>> {
    let of = |(module, code): (&Module, &String)| {
        let named = ["crate::", "super::"].into_iter().flat_map(|word| paths(code, word, 0).collect::<Vec<_>>());
        named.filter_map(|path| definer(modules, module, &path, &mut BTreeSet::new())).filter(|found| found != module).collect()
    };
    modules.iter().map(|module| (module.0, of(module))).collect()
}

/// The circles of more than two modules.
fn circles(modules: &Modules) -> BTreeSet<Vec<String>> {
    let dependencies = dependencies(modules);
    let reached = |from: &Module| {
        let (mut all, mut new) = (BTreeSet::new(), vec![from.clone()]);
        while let Some(module) = new.pop() {
            new.extend(dependencies[&module].iter().filter(|next| all.insert((*next).clone())).cloned());
        }
        all
    };
    let reached: BTreeMap<&Module, BTreeSet<Module>> = modules.keys().map(|module| (module, reached(module))).collect();
    let of = |module: &Module| -> Vec<String> {
        let both = reached[module].iter().filter(|other| reached[other].contains(module));
        both.map(|other| other.join("::")).collect()
    };
    modules.keys().map(of).filter(|circle| circle.len() > 2).collect()
}

/// The modules below the folder of a crate's root.
fn modules_of(root: &str) -> Modules {
    let mut modules = Modules::new();
    read(&Path::new(env!("CARGO_MANIFEST_DIR")).join(root), &[], &mut modules);
    modules
}

#[test]
fn imports_go_round_in_no_circle() {
    for root in ["src", "src/host", "bindings/anari/src", "bindings/c/src", "bindings/python/src"] {
        let modules = modules_of(root);
        assert!(modules.len() > 15, "{root}: {}", modules.len());
        assert_eq!(circles(&modules), BTreeSet::new(), "{root}");
    }
}

/// Circles by imports of each spelling.
#[test]
fn circles_of_imports_are_noticed() {
    for (root, module, line) in [
        // The session uses the painter, which uses the inbox.
        ("src", "viewer::inbox", "use super::session::Session;"),
        ("src", "viewer::inbox", "use crate::{error::Error, viewer::{\n    Session,\n}};"),
        ("src", "viewer::inbox", "fn f(_: super::Session) {}"),
        ("src", "viewer::inbox", "use super::session;"),
        ("src/host", "volume::grid", "use crate::reference::Marched;"),
    ] {
        let mut modules = modules_of(root);
        let code = modules.get_mut(&module.split("::").map(String::from).collect::<Module>()).unwrap();
        code.push_str(&line.replace('\n', " "));
        let found = circles(&modules);
        assert!(found.len() == 1 && found.iter().all(|circle| circle.contains(&module.to_owned())), "{line}: {found:?}");
    }
}
