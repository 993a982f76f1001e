//! Joins the viewer's page (src/viewer/page) and `widget/` into one ES module for notebooks, which load a widget as a single file.
//!
//! Each module becomes a function that returns what it exports; imports become look-ups. All of them together are the function `page`, which
//! is called once for every page. Its parameters have the names of the browser's globals that reach beyond the page.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::{env, fs};

/// Globals that the caller of `page` gives.
const GIVEN: &str =
    "globalThis, window, document, location, history, innerWidth, innerHeight, addEventListener, matchMedia, WebSocket";

fn main() {
    let here = PathBuf::from(env::var("CARGO_MANIFEST_DIR").expect("cargo sets it"));
    let (page, widget) = (here.join("../../src/viewer/page"), here.join("widget"));
    for folder in [&page, &widget] {
        println!("cargo::rerun-if-changed={}", folder.display());
    }
    let joined = joined(&page, &widget).unwrap_or_else(|problem| panic!("the page cannot be joined: {problem}"));
    let out = PathBuf::from(env::var("OUT_DIR").expect("cargo sets it"));
    fs::write(out.join("widget.js"), joined).expect("the folder for results is writable");
}

fn joined(page: &Path, widget: &Path) -> Result<String, String> {
    let mut modules = Modules::new(page);
    modules.add("main.js")?;
    let html = read(&page.join("index.html"))?;
    let body = between(&html, "<body>", "</body>").ok_or("index.html has no body")?;
    let style = scoped(&read(&page.join("style.css"))?) + &read(&widget.join("widget.css"))?;
    let mut of_widget = Modules::new(widget);
    of_widget.add("widget.js")?;
    Ok(format!(
        "// Joined from src/viewer/page and bindings/python/widget by bindings/python/build.rs.\nconst page = ({{ {GIVEN} }}) => {{\n{}}};\n{}\
         export default widget_js.widget({{ body: {}, style: {}, page }});\n",
        modules.text,
        of_widget.text,
        literal(body),
        literal(&style),
    ))
}

fn read(path: &Path) -> Result<String, String> {
    fs::read_to_string(path).map_err(|e| format!("{}: {e}", path.display()))
}

fn between<'t>(text: &'t str, start: &str, end: &str) -> Option<&'t str> {
    text.split_once(start)?.1.rsplit_once(end).map(|(inside, _)| inside)
}

/// A string of JavaScript.
fn literal(text: &str) -> String {
    let escaped = text.replace('\\', "\\\\").replace('`', "\\`").replace("${", "\\${");
    format!("`{escaped}`")
}

/// The page's style for an element of the class `page` in a shadow root: the element is the window.
fn scoped(style: &str) -> String {
    let mut scoped =
        style.replace("html, body", ".page").replace(":root", ".page").replace("@media (max-width", "@container (max-width");
    // Nested rules: the notebook's theme decides, not the system.
    scoped = scoped.replace("@media (prefers-color-scheme: dark)", ":host([dark])");
    let mut text = String::new();
    let mut rest = scoped.as_str();
    while let Some(at) = rest.find(['v']) {
        let is_unit = rest[..at].ends_with(|c: char| c.is_ascii_digit()) && rest[at + 1..].starts_with(['h', 'w']);
        text += &rest[..at];
        text += if is_unit { "cq" } else { "v" };
        rest = &rest[at + 1..];
    }
    text + rest
}

/// Modules in an order in which each comes after those that it imports.
struct Modules<'f> {
    folder: &'f Path,
    text: String,
    /// Whether a module is complete, by file name; an incomplete one imports itself over others.
    added: BTreeMap<String, bool>,
}

impl<'f> Modules<'f> {
    fn new(folder: &'f Path) -> Self {
        Self { folder, text: String::new(), added: BTreeMap::new() }
    }

    fn add(&mut self, name: &str) -> Result<(), String> {
        match self.added.get(name) {
            Some(true) => return Ok(()),
            Some(false) => return Err(format!("{name} imports itself, over other modules")),
            None => {}
        }
        self.added.insert(name.into(), false);
        let module = Module::parse(&read(&self.folder.join(name))?).map_err(|problem| format!("{name}: {problem}"))?;
        for imported in &module.imports {
            self.add(imported)?;
        }
        let exports = module.exports.join(", ");
        let written =
            write!(self.text, "const {} = (() => {{\n{}return {{ {exports} }};\n}})();\n", identifier(name), module.code);
        written.expect("strings take everything");
        self.added.insert(name.into(), true);
        Ok(())
    }
}

/// The variable of a module.
fn identifier(name: &str) -> String {
    name.replace(|c: char| !c.is_ascii_alphanumeric(), "_")
}

#[derive(Default)]
struct Module {
    imports: Vec<String>,
    exports: Vec<String>,
    code: String,
}

impl Module {
    /// Statements `import` and `export` begin a line of their own.
    fn parse(source: &str) -> Result<Self, String> {
        let mut module = Self::default();
        let mut lines = source.lines();
        while let Some(line) = lines.next() {
            if line.starts_with("import ") {
                let mut statement = line.to_owned();
                while !statement.trim_end().ends_with(';') {
                    statement += lines.next().ok_or("an import does not end")?;
                }
                module.import(&statement)?;
            } else if let Some(exported) = line.strip_prefix("export ") {
                module.export(exported)?;
            } else {
                module.code += line;
                module.code.push('\n');
            }
        }
        Ok(module)
    }

    fn import(&mut self, statement: &str) -> Result<(), String> {
        let refused = || format!("this import is not understood: {statement}");
        let (what, from) = statement.trim_start_matches("import ").rsplit_once(" from ").ok_or_else(refused)?;
        let file = from.trim().trim_end_matches(';').trim_matches('"').strip_prefix("./").ok_or_else(refused)?;
        let variable = identifier(file);
        let what = what.trim();
        self.code += &match what.strip_prefix("* as ") {
            Some(name) => format!("const {name} = {variable};\n"),
            None if what.starts_with('{') => format!("const {} = {variable};\n", what.replace(" as ", ": ")),
            None => return Err(refused()),
        };
        self.imports.push(file.to_owned());
        Ok(())
    }

    fn export(&mut self, exported: &str) -> Result<(), String> {
        let mut words = exported.split(|c: char| !(c.is_alphanumeric() || c == '_' || c == '$')).filter(|word| !word.is_empty());
        let name = match words.next() {
            Some("const" | "class" | "function") => words.next(),
            Some("async") => words.nth(1),
            _ => None,
        };
        let is_plain = !exported.starts_with("const {") && !exported.starts_with("const [");
        let name = name.filter(|_| is_plain).ok_or_else(|| format!("this export is not understood: export {exported}"))?;
        self.exports.push(name.to_owned());
        self.code += exported;
        self.code.push('\n');
        Ok(())
    }
}
