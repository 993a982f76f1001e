//! The crate as a whole: what a library user pays for, and that its modules depend only on what ARCHITECTURE.md says.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::process::Command;

/// Dependencies of the command and its viewer only.
const OF_THE_COMMAND: [&str; 8] =
    ["axum", "clap", "cpu-time", "hyper", "indicatif", "signal-hook", "tokio", "tracing-subscriber"];

/// All crates that are built with these features.
fn dependencies(features: &[&str]) -> BTreeSet<String> {
    let mut command = Command::new(env!("CARGO"));
    command.args(["tree", "--offline", "--locked", "--edges", "normal", "--prefix", "none"]).args(features);
    let output = command.current_dir(env!("CARGO_MANIFEST_DIR")).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let lines = String::from_utf8(output.stdout).unwrap();
    lines.lines().filter_map(|line| line.split(' ').next()).filter(|name| !name.is_empty()).map(String::from).collect()
}

#[test]
fn the_library_alone_pays_for_nothing_of_the_command() {
    let (library, command) = (dependencies(&["--no-default-features"]), dependencies(&[]));
    assert!(library.contains("opencl3") && library.is_subset(&command), "{library:?}");
    for name in OF_THE_COMMAND {
        assert!(command.contains(name) && !library.contains(name), "{name}");
    }
}

/// The files of the archive that `cargo publish` uploads, relative to the crate's root.
fn published(package: &str) -> BTreeSet<String> {
    let mut command = Command::new(env!("CARGO"));
    command
        .args(["package", "--list", "--offline", "--locked", "--allow-dirty", "--package", package])
        .current_dir(env!("CARGO_MANIFEST_DIR"));
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap().lines().map(|line| line.replace('\\', "/")).collect()
}

/// The files below a folder of the crate that are not in a list.
fn absent(folder: &str, list: &BTreeSet<String>) -> Vec<String> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(Path::new(env!("CARGO_MANIFEST_DIR")).join(folder)).unwrap() {
        let entry = entry.unwrap();
        let path = format!("{folder}/{}", entry.file_name().to_str().unwrap());
        if entry.path().is_dir() {
            found.extend(absent(&path, list));
        } else if !list.contains(&path) {
            found.push(path);
        }
    }
    found
}

/// The crate embeds kernels, a page, a font and a picture: without them it would not compile.
#[test]
fn the_published_crate_is_whole() {
    let mut files = published("layersplat");
    assert!(!files.iter().any(|file| file.starts_with("src/host")), "a package of its own");
    let host = published("layersplat-host");
    let both = files.iter().cloned().chain(host.iter().map(|file| format!("src/host/{file}"))).collect();
    for folder in ["kernels", "src"] {
        assert_eq!(absent(folder, &both), [""; 0]);
    }
    for file in ["Cargo.lock", "LICENSE-APACHE", "LICENSE-MIT", "README.md", "build.rs", "docs/guide/embedding.md"] {
        assert!(files.contains(file), "{file}");
    }
    assert!(!files.iter().any(|file| file.starts_with("bindings") || file.ends_with(".jpg")));
    assert!(files.remove("kernels/shared/accumulator.cl"));
    assert_eq!(absent("kernels", &files), ["kernels/shared/accumulator.cl"]);
}

/// Settings and cameras can be constructed with this crate's public items only.
#[test]
fn what_users_need_is_at_hand() {
    use layersplat::glam::DVec3;
    use layersplat::settings::{Classification, Evaluation, LayerAxis, Layered};
    use layersplat::{Axis, Camera, Correction, Density, Orbit, Projection, Settings};
    let camera = Camera::orbit(DVec3::ZERO, 2.0, Orbit::default(), Projection::Parallel { scale: 1.0 });
    let settings = Settings {
        algorithm: Layered {
            layer_axis: LayerAxis::Forced(Axis::Z),
            evaluation: Evaluation::Lattice(Density::Fixed(2)),
            classification: Classification::Post(Correction::SubLayers(2)),
            ..Layered::default()
        }
        .into(),
        ..Settings::default()
    };
    assert!(camera.position.z == 2.0 && settings.layered().is_some_and(|l| l.layer_axis == LayerAxis::Forced(Axis::Z)));
}

/// The code of a file, or of all files of a folder, without tests.
fn code_of(path: &Path) -> String {
    if path.is_dir() {
        return std::fs::read_dir(path).unwrap().map(|entry| code_of(&entry.unwrap().path())).collect();
    }
    if path.extension().is_none_or(|ending| ending != "rs") {
        return String::new();
    }
    let text = std::fs::read_to_string(path).unwrap();
    text.split("#[cfg(test)]\nmod tests").next().unwrap().to_owned()
}

/// Whether a string in a line of code contains an option of the command, after `--`.
fn options(line: &str) -> bool {
    let is_letter = |byte: Option<&u8>| byte.is_some_and(u8::is_ascii_lowercase);
    line.match_indices("--").any(|(at, _)| is_letter(line.as_bytes().get(at + 2)))
}

/// Library messages name fields. Only src/cli/option_names.rs maps them to options of the command.
#[test]
fn only_the_command_knows_its_options() {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    for entry in std::fs::read_dir(source).unwrap() {
        let path = entry.unwrap().path();
        if !path.ends_with("cli") {
            let code = code_of(&path);
            let found: Vec<&str> = code.lines().filter(|l| options(l) && !l.trim_start().starts_with("//")).collect();
            assert_eq!(found, [""; 0], "{}", path.display());
        }
    }
    assert!(options("correct --dims or") && !options("a - b, c--, -- d"));
}

/// The modules that any other may use; they depend on nothing but each other.
const COMMON: [&str; 10] = ["cache", "choice", "error", "files", "memory", "npy", "numbers", "panics", "progress", "url"];

/// What the code of each module (file or folder of src or src/host) names: paths below the crate's root.
type Named = BTreeMap<String, BTreeSet<Vec<String>>>;

/// The modules of the crate with the paths that each names, those of re-exports resolved.
fn named_by_modules() -> Named {
    let source = Path::new(env!("CARGO_MANIFEST_DIR")).join("src");
    let crates = [source.join("host"), source];
    let read = |folder: &PathBuf| std::fs::read_to_string(folder.join("lib.rs")).unwrap();
    let exports: BTreeMap<_, _> = crates.iter().flat_map(|folder| exports(&read(folder))).collect();
    let mut named = Named::new();
    for entry in crates.iter().flat_map(|folder| std::fs::read_dir(folder).unwrap()) {
        let path = entry.unwrap().path();
        let module = path.file_stem().unwrap().to_str().unwrap().to_owned();
        if !["Cargo", "host", "lib", "main"].contains(&module.as_str()) {
            // A module may be a file beside a folder.
            named.entry(module).or_default().extend(resolved(named_paths(&code_of(&path)), &exports));
        }
    }
    named
}

/// Of code without comments: every path that begins with `crate::`, each branch of a group by itself.
fn named_paths(code: &str) -> Vec<Vec<String>> {
    let lines: Vec<&str> = code.lines().filter(|line| !line.trim_start().starts_with("//")).collect();
    lines.join(" ").split("crate::").skip(1).flat_map(|rest| branches(rest).0).collect()
}

/// The paths that a text begins with, and what follows them: `a::{b, c::D} …` begins with `a::b` and `a::c::D`.
pub fn branches(text: &str) -> (Vec<Vec<String>>, &str) {
    if let Some(mut rest) = text.strip_prefix('{') {
        let mut all = Vec::new();
        while !rest.trim_start().starts_with('}') {
            let (found, after) = branches(rest.trim_start());
            all.extend(found);
            rest = after.trim_start().trim_start_matches(',');
            assert!(after.len() < text.len() && !rest.is_empty(), "a group that does not end: {text}");
        }
        return (all, &rest.trim_start()[1..]);
    }
    let end = text.find(|c: char| !(c.is_alphanumeric() || c == '_' || c == '*')).unwrap_or(text.len());
    let (name, rest) = text.split_at(end);
    match rest.strip_prefix("::") {
        Some(rest) if !rest.starts_with('<') => {
            let (deeper, rest) = branches(rest);
            (deeper.into_iter().map(|path| [vec![name.to_owned()], path].concat()).collect(), rest)
        }
        _ => (vec![vec![name.to_owned()]], rest),
    }
}

/// What a `lib.rs` re-exports of its own modules: the name, and the path that it stands for.
fn exports(lib: &str) -> BTreeMap<String, Vec<String>> {
    let statements = lib.split("pub use ").skip(1).flat_map(|rest| branches(rest).0);
    let statements = statements.filter(|path| path[0] != "layersplat_host");
    statements.filter(|path| path.len() > 1).map(|path| (path.last().unwrap().clone(), path)).collect()
}

fn resolved(paths: Vec<Vec<String>>, exports: &BTreeMap<String, Vec<String>>) -> impl Iterator<Item = Vec<String>> {
    paths.into_iter().map(|path| exports.get(&path[0]).cloned().unwrap_or(path))
}

/// The rows of ARCHITECTURE.md's table for modules, in order: the module, and the paths below the crate's root that it may depend on.
fn table(text: &str) -> Vec<(String, BTreeSet<Vec<String>>)> {
    let mut rows: Vec<(String, BTreeSet<Vec<String>>)> = Vec::new();
    for line in text.lines().filter(|line| line.starts_with("| `src/")) {
        let cells: Vec<&str> = line.trim_end_matches([' ', '|']).split(" | ").collect();
        let module =
            cells[0].trim_start_matches("| `src/").trim_start_matches("host/").trim_end_matches('`').trim_end_matches(".rs");
        let may = match cells.last().unwrap().trim() {
            "nothing else" => BTreeSet::new(),
            "all of the above" => rows.iter().map(|(module, _)| vec![module.clone()]).collect(),
            list => list.split(", ").map(|path| allowed(path, line)).collect(),
        };
        rows.push((module.to_owned(), may));
    }
    rows
}

/// A path of the table's last column: `module`, or `module::Item`.
fn allowed(path: &str, line: &str) -> Vec<String> {
    let name = path.strip_prefix('`').and_then(|p| p.strip_suffix('`')).unwrap_or_else(|| panic!("no path: {path} of {line}"));
    name.split("::").map(String::from).collect()
}

/// What of the code the table does not allow, and what of the table is not so.
fn violations(table: &[(String, BTreeSet<Vec<String>>)], code: &Named) -> Vec<String> {
    let mut found = Vec::new();
    for (n, (module, may)) in table.iter().enumerate() {
        if !code.contains_key(module) {
            found.push(format!("{module} has a row and is not there"));
        }
        let above: Vec<&String> = table[..n].iter().map(|(module, _)| module).collect();
        let below = may.iter().filter(|path| !above.contains(&&path[0]));
        found.extend(below.map(|path| format!("{module} may depend on {}, which is not above it", path.join("::"))));
    }
    for (module, named) in code {
        let row = table.iter().find(|(name, _)| name == module).map(|(_, may)| may);
        if row.is_none() && !COMMON.contains(&module.as_str()) {
            found.push(format!("{module} has no row"));
        }
        // What the code says by itself: macros name `$crate`, tests of a module are left out.
        let others = named.iter().filter(|path| path[0] != *module && !COMMON.contains(&path[0].as_str()));
        let is_allowed = |path: &Vec<String>| row.is_some_and(|may| may.iter().any(|allowed| path.starts_with(allowed)));
        found.extend(others.filter(|path| !is_allowed(path)).map(|path| format!("{module} uses {}", path.join("::"))));
    }
    found
}

#[test]
fn modules_depend_on_what_the_table_says() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md")).unwrap();
    for common in COMMON {
        assert!(text.contains(&format!("`src/host/{common}.rs`")), "{common}");
    }
    let (table, code) = (table(&text), named_by_modules());
    assert!(table.len() >= 15 && code.len() == table.len() + COMMON.len(), "{} rows, {} modules", table.len(), code.len());
    assert_eq!(violations(&table, &code), [""; 0]);
}

/// A dependency in each direction and of each spelling, and rows that are wrong.
#[test]
fn violations_of_the_table_are_noticed() {
    let text = std::fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("ARCHITECTURE.md")).unwrap();
    let lib = "pub use renderer::Renderer;\npub use camera::{Basis, Camera};";
    for (module, line, expected) in [
        ("volume", "use crate::renderer::Plan;", "volume uses renderer::Plan"),
        ("volume", "fn f() { crate::renderer::plan::of() }", "volume uses renderer::plan::of"),
        ("volume", "use crate::Renderer;", "volume uses renderer::Renderer"),
        ("volume", "use crate::{\n    error::Error,\n    Camera,\n};", "volume uses camera::Camera"),
        ("error", "use crate::volume::Volume;", "error uses volume::Volume"),
        // Of another module, more than the table gives.
        ("layers", "use crate::volume::{Grid, Volume};", "layers uses volume::Volume"),
        ("annotation", "use crate::settings::{Blend, Settings};", "annotation uses settings::Settings"),
        ("device", "use crate::renderer::*;", "device uses renderer::*"),
    ] {
        let mut code = named_by_modules();
        code.get_mut(module).unwrap().extend(resolved(named_paths(line), &exports(lib)));
        assert_eq!(violations(&table(&text), &code), [expected], "{line}");
    }
    let (rows, code) = (table(&text), named_by_modules());
    let without = |module: &str| -> Vec<_> { rows.iter().filter(|(name, _)| name != module).cloned().collect() };
    assert!(violations(&without("cli"), &code).contains(&"cli has no row".into()));
    let mut backwards = rows.clone();
    backwards[0].1.insert(vec!["renderer".into()]);
    assert_eq!(violations(&backwards, &code), [format!("{} may depend on renderer, which is not above it", rows[0].0)]);
    let mut stale = code.clone();
    stale.remove("check");
    assert_eq!(violations(&rows, &stale), ["check has a row and is not there"]);
}
